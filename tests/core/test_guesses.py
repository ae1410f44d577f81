"""The errors for attributes that do not exist."""

from __future__ import annotations

import copy
import importlib
import inspect
import pickle
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import nao_kin as nk
from nao_kin._core.guesses import GUESSES

OWNERS = {
    "RobotModel": nk.load_nao(),
    "Motion": nk.Motion([0.0, 1.0], ["HeadYaw"], [[0.0], [0.5]]),
    "Viewer": nk.Viewer,
}
CASES = [(owner, name, meant) for owner, names in GUESSES.items() for name, meant in names.items()]


@pytest.mark.parametrize(("owner", "name", "meant"), CASES)
def test_a_name_that_people_try_is_answered_with_names_that_exist(owner: str, name: str, meant: str) -> None:
    names = {"nk": nk, "np": np, "copy": copy, "robot": OWNERS["RobotModel"], "motion": OWNERS["Motion"]}
    for expression in meant.split(", "):
        eval(expression, names | {"viewer": nk.Viewer})
    found: Any = OWNERS[owner] if owner in OWNERS else importlib.import_module(owner)
    if name == "times":  # an instance has them
        found = nk.Motion
    with pytest.raises(AttributeError, match=rf"has no attribute '{name}'; see ") as error:
        getattr(found, name)
    assert str(error.value).endswith(meant)


def test_other_names_are_answered_with_the_nearest() -> None:
    nao = nk.load_nao()
    with pytest.raises(AttributeError, match=r"object has no attribute 'frame_name'; nearest: .*frame_names"):
        nao.frame_name  # type: ignore[attr-defined]  # noqa: B018
    with pytest.raises(AttributeError, match=r"module 'nao_kin.rotations' has no attribute 'rotx'; nearest: rot_x"):
        nk.rotations.rotx  # type: ignore[attr-defined]  # noqa: B018
    with pytest.raises(
        AttributeError, match=r"module 'nao_kin.errors' has no attribute 'WrongSize'; nearest: WrongShape"
    ):
        nk.errors.WrongSize  # type: ignore[attr-defined]  # noqa: B018
    with pytest.raises(AttributeError, match=r"'NaoModel' object has no attribute 'qqqqqqqqq'$"):
        nao.qqqqqqqqq  # type: ignore[attr-defined]  # noqa: B018
    assert not hasattr(nao, "__array__")


def test_what_fails_inside_a_property_is_not_hidden_and_copies_work() -> None:
    nao = nk.load_nao()
    twin = copy.copy(nao)
    assert np.array_equal(twin.posture("Stand"), nao.posture("Stand"))
    motion = nk.Motion([0.0, 1.0], ["HeadYaw"], [[0.0], [0.5]])
    assert np.array_equal(pickle.loads(pickle.dumps(motion)).sample(0.5), motion.sample(0.5))


MODULES = [getattr(nk, name) for name in nk.__all__ if name != "cli"]
MODULES = [nk, *filter(inspect.ismodule, MODULES)]


@pytest.mark.parametrize("module", MODULES, ids=lambda module: str(module.__name__))
def test_an_editor_completes_the_public_names_of_a_module_alone(module: ModuleType) -> None:
    assert dir(module) == sorted(module.__all__)
    with pytest.raises(AttributeError, match=r"has no attribute 'qqqqqqqqq'$"):
        module.qqqqqqqqq  # noqa: B018
