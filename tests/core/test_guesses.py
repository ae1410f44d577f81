"""The errors for attributes that do not exist."""

from __future__ import annotations

import copy
import inspect
import pickle
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from loops import for_all
from public_names import ROOMS, TOP

import nao_kin as nk
from nao_kin._core.guesses import public_index
from nao_kin.errors import NaoKinError

PLACES = [place for places in public_index().values() for place in places if not place.startswith("viewer.")]
NAO, NOD = nk.load_nao(), nk.Motion([0.0, 1.0], ["HeadYaw"], [[0.0], [0.5]])
NAMES = {"nk": nk, "robot": NAO, "nao": NAO, "motion": NOD}


def test_every_place_of_the_index_exists() -> None:
    assert len(PLACES) > 400
    for place in PLACES:
        eval(place, NAMES)


@pytest.mark.parametrize("module", [nk, nk.world, nk.rotations], ids=lambda module: str(module.__name__))
def test_every_public_name_is_found_from_another_module(module: ModuleType) -> None:
    others = (
        {name for key, room in ROOMS.items() if key != "cli" for name in room.__all__}
        - set(dir(module))
        - set(vars(module))
    )
    assert len(others) > 200
    for name in others:
        with pytest.raises(AttributeError, match=rf"'{name}'; see .*\.{name}\b"):
            getattr(module, name)


@pytest.mark.parametrize(
    ("owner", "name", "meant"),
    [
        (nk, "fk", "robot.fk, nk.stream.fk, nk.distributed.fk"),
        (nk, "mirror", "robot.mirror, nk.motion.mirror"),
        (nk, "slerp", "nk.rotations.slerp"),
        (nk, "link_names", "robot.link_names"),
        (nk, "from_urdf", "nk.RobotModel.from_urdf"),
        (nk, "read_motion", "nk.motion.read_motion"),
        (nk.rotations, "rpy_to_matrix", "nk.rotations.matrix_from_rpy"),  # not the inverse, whose letters are nearer
        (NAO, "balance", "motion.balance, nk.world.balance"),
        (NAO, "dh_table", "nk.joints.dh_table"),
        (nk, "getQuaternionFromEuler", "nk.rotations.quat_from_euler"),
        (nk, "quaternion_multiply", "nk.rotations.quat_multiply, nk.screws.dual_quat_multiply"),
        (nk, "quat2euler", "nk.rotations.euler_from_quat"),
        (NAO, "getAngles", "robot.angles, nk.naoqi.angles, nk.screws.lines.angle"),  # its own name comes first
        (nk.Viewer, "save_motion", ""),
    ],
)
def test_a_name_that_exists_elsewhere_is_answered_with_its_place(owner: Any, name: str, meant: str) -> None:
    with pytest.raises(AttributeError) as error:
        getattr(owner, name)
    assert str(error.value).endswith(f"; see {meant}" if meant else f"has no attribute '{name}'")


def test_other_names_are_answered_with_the_nearest_or_nothing() -> None:
    nao = nk.load_nao()
    with pytest.raises(AttributeError, match=r"object has no attribute 'frame_name'; nearest: .*frame_names"):
        nao.frame_name  # type: ignore[attr-defined]  # noqa: B018
    with pytest.raises(AttributeError, match=r"module 'nao_kin.rotations' has no attribute 'rotx'; nearest: rot_x"):
        nk.rotations.rotx  # type: ignore[attr-defined]  # noqa: B018
    with pytest.raises(AttributeError, match=r"'NaoModel' object has no attribute 'qqqqqqqqq'$"):
        nao.qqqqqqqqq  # type: ignore[attr-defined]  # noqa: B018
    with pytest.raises(AttributeError, match=r"has no attribute 'teach'$"):  # nothing is better than "reach"
        nk.teach  # type: ignore[attr-defined]  # noqa: B018
    assert not hasattr(nao, "__array__")


Q, POSE = NAO.neutral(), np.eye(4)


@for_all(
    ("ask", "way"),
    [
        (lambda: NAO.fk("LArm", Q), "frame is named by a text"),  # type: ignore[arg-type]
        (lambda: nk.ik.numeric(NAO, POSE, "LArm"), "frame is named by a text"),  # type: ignore[arg-type]
        (lambda: nk.ik.velocity(NAO, Q, "LArm", np.zeros(6)), "frame is named by a text"),  # type: ignore[arg-type]
        (lambda: NAO.fk(np.zeros(26), "LArm"), "nao.from_body"),
        (lambda: NAO.fk({"HeadYaw": 0.1}, "LArm"), "robot.configuration"),  # type: ignore[arg-type]
        (lambda: NAO.fk("StandInit", "LArm"), "robot.posture"),  # type: ignore[arg-type]
        (lambda: nk.rotations.quat_from_matrix(POSE), "T[..., :3, :3]"),
        (lambda: nk.rotations.log([1.0, 0.0, 0.0, 0.0]), "nk.rotations.matrix_from_quat"),
        (lambda: nk.ik.leg(NAO, "L", [0.0, 0.05, -0.3]), "nk.ik.numeric takes a position"),
        (lambda: nk.ik.head(NAO, [1.0, 0.0, 0.0]), "nk.ik.look_at a point"),
        (lambda: nk.RobotModel("r.urdf"), "RobotModel.from_file('r.urdf')"),  # type: ignore[arg-type]
        (lambda: nk.load_nao("r.urdf"), "RobotModel.from_file"),
        (lambda: nk.load_robot("nao"), "load_nao"),
        (lambda: nk.calibration.calibrate(NAO, "seen.json"), "read_observations"),  # type: ignore[arg-type]
        (lambda: NAO.fk(Q, 5), "frame is named by a text"),  # type: ignore[arg-type]
        (lambda: NAO.columns(["HeadYaw"]), "unknown joint, chain or frame"),  # type: ignore[arg-type]
        (lambda: NAO.configuration("Stand"), "robot.posture"),  # type: ignore[arg-type]
        (lambda: NAO.configuration({"HeadYaw": 30.0}), "values are in radians"),
        (lambda: nk.ik.arm(NAO, "L", nk.rotations.rot_x(0.3)), "nk.screws.pose makes a pose of a rotation"),
        (lambda: nk.rotations.matrix_from_quat(POSE[:3, :3]), "nk.rotations.quat_from_matrix"),
        (lambda: nk.screws.exp(POSE), "nk.screws.log"),
        (lambda: nk.Viewer(NAO).show(Q), "display(q)"),  # type: ignore[arg-type]
    ],
)
def test_what_is_given_in_the_wrong_place_is_answered_with_what_takes_it(ask: Any, way: str) -> None:
    with pytest.raises(NaoKinError) as error:
        ask()
    assert way in str(error.value)


def test_what_fails_inside_a_property_is_not_hidden_and_copies_work() -> None:
    nao = nk.load_nao()
    twin = copy.copy(nao)
    assert np.array_equal(twin.posture("Stand"), nao.posture("Stand"))
    motion = nk.Motion([0.0, 1.0], ["HeadYaw"], [[0.0], [0.5]])
    assert np.array_equal(pickle.loads(pickle.dumps(motion)).sample(0.5), motion.sample(0.5))


MODULES = [getattr(nk, name) for name in TOP if name != "cli"]
MODULES = [nk, *filter(inspect.ismodule, MODULES)]


@pytest.mark.parametrize("module", MODULES, ids=lambda module: str(module.__name__))
def test_an_editor_completes_the_public_names_of_a_module_alone(module: ModuleType) -> None:
    assert dir(module) == sorted(module.__all__)
    with pytest.raises(AttributeError, match=r"has no attribute 'qqqqqqqqq'$"):
        module.qqqqqqqqq  # noqa: B018
