"""What holds for the arrays of all public functions, given and returned, in the calls that their examples make."""

from __future__ import annotations

import inspect
from collections.abc import Iterator

import fuzz
import numpy as np
import pytest
from example_calls import arrays, calls_of

import nao_kin as nk

pytestmark = pytest.mark.full


@pytest.fixture(scope="module", autouse=True)
def files(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    folder = tmp_path_factory.mktemp("files")
    fuzz.write_files(folder)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setattr("sys.displayhook", lambda value: None)
        yield


@pytest.mark.filterwarnings("ignore")
def test_arrays_are_neither_read_only_nor_those_of_an_object_or_the_caller() -> None:
    """An array can be changed without changing a robot, and the caller's arrays without changing a result.

    No call changes the arrays that it is given.
    """
    wrong, count = set[str](), 0
    for name, case in fuzz.cases().items():
        made = inspect.isclass(case.function)
        for call in calls_of(case) if not name.startswith(("nk.cli", "nk.motion.read_motion(")) else ():
            wrong |= {f"{name} changes {argument}" for argument in call.changed if argument not in ("self", "out")}
            given = [
                (argument == "self", array)
                for argument, value in call.given.items()
                if not (made and argument == "self") and (argument == "self" or not isinstance(value, nk.RobotModel))
                for _, array in arrays(value, private=True)
                if array.size
            ]
            for path, array in arrays(call.result, private=made):
                count += 1
                shared = [own for own, other in given if other.flags.writeable and np.shares_memory(array, other)]
                if "." not in path and not array.flags.writeable:
                    wrong.add(f"{name}{path} is read-only")
                if False in shared:
                    wrong.add(f"{name}{path} is the caller's")
                if array.flags.writeable and True in shared:
                    wrong.add(f"{name}{path} is the object's own")
    assert count > 500
    assert sorted(wrong) == []
