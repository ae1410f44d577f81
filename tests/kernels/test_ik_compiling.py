"""The same kernels, run as Python and compiled, give the same results."""

from __future__ import annotations

import io
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import nao_kin as nk
from nao_kin.errors import BadArgument, UnknownName

TARGETS = """
import sys
import numpy as np, nao_kin as nk
nao = nk.load_nao("v6")
q = nao.random(1, 6)
def solved(solve, side, T):
    return np.array([solve(nao, side, each).q for each in T]) if one else solve(nao, side, T).q
parts = [
    solved(solve, side, nao.fk(q, side + limb))
    for side in "LR"
    for solve, limb in ((nk.ik.leg, "Leg"), (nk.ik.arm, "Arm"))
]
T = nao.fk(nao.posture("Crouch"), "LArm")
parts += [nk.ik.numeric(nao, "LArm", T if one else T[None], near=nao.posture("StandInit")).q.reshape(1, -1)]
feet = nao.fk(q, ["LLeg", "RLeg"])
if one:
    parts += [nk.ik.legs(nao, *pair).q[None] for pair in feet]
else:
    parts += [nk.ik.legs(nao, feet[:, 0], feet[:, 1]).q]
parts += [nk.ik.look_at(nao, [2.0, 0.1 * k, 0.3]).q for k in range(6)]
np.save(sys.stdout.buffer, np.vstack(parts))
"""


def answers(one: bool, **environment: str) -> np.ndarray:
    """Return the answers of a separate process, target by target or in batches."""
    command = [sys.executable, "-c", f"one = {one}\n{TARGETS}"]
    done = subprocess.run(command, env={**os.environ, **environment}, capture_output=True, check=True)
    return np.asarray(np.load(io.BytesIO(done.stdout)))


@pytest.mark.full
def test_python_and_the_compiled_kernels_give_the_same_bits() -> None:
    compiled = answers(one=False)
    assert not np.isnan(compiled).any()
    np.testing.assert_array_equal(answers(one=True), compiled)  # Python, for no batch has come
    np.testing.assert_array_equal(answers(one=False, NUMBA_DISABLE_JIT="1"), compiled)


def test_one_target_does_not_wait_for_numba() -> None:
    code = (
        "import sys, nao_kin as nk\n"
        "nao = nk.load_nao('v6'); q = nao.posture('StandInit')\n"
        "assert nk.ik.leg(nao, 'L', nao.fk(q, 'LLeg')).success\n"
        "assert nk.ik.arm(nao, 'L', nao.fk(q, 'LArm')).success\n"
        "assert nk.ik.numeric(nao, 'LLeg', nao.fk(q, 'LLeg'), near=q + 0.01).success\n"
        "assert nk.ik.legs(nao, nao.fk(q, 'LLeg'), nao.fk(q, 'RLeg')).success\n"
        "assert nk.ik.look_at(nao, [1.0, 0.0, 0.3]).success\n"
        "assert 'numba' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True)


@pytest.mark.parametrize("limits", ["enforce", "ignore"])
def test_one_target_and_a_batch_get_the_same_bits_of_a_kernel_in_memory(nao: nk.NaoModel, limits: Any) -> None:
    nk.warm_up(["ik kernel, legs", "ik kernel, arms by pose"])
    for solve, frame in ((nk.ik.leg, "RLeg"), (nk.ik.arm, "LArm")):
        T = nao.fk(nao.random(4, 20), frame)
        T[-1, 0, 3] += 0.5  # out of reach
        T.setflags(write=False)
        many = solve(nao, frame[0], T, limits=limits)
        for i, pose in enumerate(T):
            for same in (pose, np.asfortranarray(pose)):
                one = solve(nao, frame[0], same, limits=limits)
                np.testing.assert_array_equal(one.q, many.q[i])
                np.testing.assert_array_equal(one.solutions, many.solutions[i, : int(many.count[i])])
                np.testing.assert_array_equal(one.residual, many.residual[i])
                assert one.describe() == many.describe((i,))


@pytest.mark.full
def test_kernels_that_several_processes_compiled_work_in_one(tmp_path: Path) -> None:
    """A process that loads kernels from the disk takes functions of the same symbol for one function."""

    def run(code: str) -> None:
        environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
        subprocess.run([sys.executable, "-c", f"import nao_kin as nk\n{code}"], env=environment, check=True)

    for limbs in ("legs", "heads"):
        run(f"nk.warm_up(['ik kernel, {limbs}'])")
    run(
        "assert not any(state.compiled for state in nk.warm_up(['ik kernel, legs', 'ik kernel, heads']))\n"
        "nao = nk.load_nao()\n"
        "q = nao.random(1, 5)\n"
        "assert nk.ik.leg(nao, 'L', nao.fk(q, 'LLeg')).success.all()\n"
        "assert nk.ik.head(nao, nao.fk(q, 'Head')[:, :3, :3]).success.all()"
    )


FIRST_USE = """
import sys
import numpy as np, nao_kin as nk, nao_kin.ik
from nao_kin._kernels import cache as kernel_cache
kernel_cache.CachedKernel.compile_in_background = lambda kernel: started.add(kernel.name)
started = set()
if ready:
    nk.warm_up([name for name in nk._kernels.KERNELS if name.startswith("ik")])
nao = nk.load_nao("v6")
far = nao.fk(nao.posture("StandInit"), "LArm")
far[0, 3] += 0.5
parts = [
    nk.ik.arm(nao, "L", [0.15, 0.1, 0.1]).q,
    nk.ik.arm(nao, "L", far).q,
    nk.ik.whole_body(nao, {"LArm": [0.18, 0.1, 0.25]}).q,
    *nk.ik.leg(nao, "L", nao.fk(nao.random(3, 20), "LLeg")).q,
    nk.ik.numeric(nao, "LArm", far, restarts=4).q,
]
if not ready:
    assert "numba" not in sys.modules
    assert {"ik kernel, arms by place", "ik kernel, damped least squares", "ik kernel, bodies"} <= started, started
np.save(sys.stdout.buffer, np.vstack(parts))
"""


@pytest.mark.full
def test_the_first_targets_on_a_machine_wait_for_no_compiler(tmp_path: Path) -> None:
    def answered(ready: bool, **environment: str) -> np.ndarray:
        command = [sys.executable, "-c", f"ready = {ready}\n{FIRST_USE}"]
        done = subprocess.run(command, env={**os.environ, **environment}, capture_output=True, check=True)
        return np.asarray(np.load(io.BytesIO(done.stdout)))

    first = answered(ready=False, NUMBA_CACHE_DIR=str(tmp_path))
    assert not list(tmp_path.rglob("*"))
    np.testing.assert_array_equal(first, answered(ready=True))


def test_all_kernels_can_be_made_ready_ahead() -> None:
    states = nk.warm_up()
    assert {
        "batch kernel, double precision",
        "reach kernel, hands",
        "ik kernel, legs",
        "ik kernel, both legs",
        "ik kernel, arms by pose",
        "ik kernel, arms by place and direction",
        "ik kernel, arms by place",
        "ik kernel, heads",
        "ik kernel, gazes",
        "ik kernel, projections onto limits",
        "ik kernel, damped least squares",
        "ik kernel, bodies",
        "ik kernel, velocities",
        "ik kernel, analytic",
    } <= {state.name for state in states}
    names = ["ik kernel, gazes", "ik kernel, legs"]
    assert [state.name for state in nk.warm_up(names)] == names
    with pytest.raises(UnknownName, match="unknown kernel 'ik kernel, leg'.*ik kernel, legs"):
        nk.warm_up(["ik kernel, leg"])
    for no_names in ("ik kernel, legs", 3):
        with pytest.raises(BadArgument, match="names must be names of kernels, got"):
            nk.warm_up(no_names)  # type: ignore[arg-type]


def test_every_module_that_makes_a_kernel_is_imported_to_make_all_ready() -> None:
    root = Path(nk.__file__).parent.parent
    makers = {
        ".".join(file.relative_to(root).with_suffix("").parts)
        for file in (root / "nao_kin").rglob("*.py")
        if re.search(r"import .*\bCachedKernel\b", file.read_text(encoding="utf-8"))
    }
    assert len(makers) > 5
    code = f"import sys, nao_kin as nk; nk.warm_up([]); print(*{makers} - sys.modules.keys())"
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert done.stdout == "\n"


def test_a_loop_of_single_targets_loads_the_kernel(
    nao: nk.NaoModel, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    nk.warm_up(["ik kernel, legs"])
    kernel, T = nk._kernels.KERNELS["ik kernel, legs"], nao.fk(nao.posture("StandInit"), "LLeg")
    expected = nk.ik.leg(nao, "L", T).q
    started: list[str] = []
    monkeypatch.setattr(type(kernel), "compile_in_background", lambda self: started.append(self.name))
    for name, value in {"_compiled": None, "entry_point": None, "python_seconds": 0.0}.items():
        monkeypatch.setattr(kernel, name, value)

    def solved_as_python() -> bool:
        np.testing.assert_array_equal(nk.ik.leg(nao, "L", T).q, expected)
        return not kernel.in_memory

    assert solved_as_python()
    assert 0.0 < kernel.python_seconds < 0.1
    with monkeypatch.context() as elsewhere:
        elsewhere.setitem(vars(kernel), "file", tmp_path / "nao_kin" / "0123.kernel")
        assert solved_as_python()
        assert started == []
        kernel.python_seconds = 1.0  # in all; as long as to load a kernel, if there were one
        assert solved_as_python()
        assert started == ["ik kernel, legs"]
    assert not solved_as_python()  # the kernel is on the disk


@pytest.mark.parametrize(("limb", "most"), [("leg", 25), ("arm", 26)])
def test_a_single_target_takes_few_python_calls(nao: nk.NaoModel, limb: str, most: int) -> None:
    """A call of Python takes about 0.2 µs, and Pinocchio computes all poses in 1 µs."""
    nk.warm_up(["ik kernel, legs", "ik kernel, arms by pose"])
    solve, T = getattr(nk.ik, limb), nao.fk(nao.posture("StandInit"), f"L{limb.capitalize()}")
    solve(nao, "L", T)
    called = []
    sys.setprofile(lambda frame, event, _: called.append(frame.f_code.co_name) if event == "call" else None)
    try:
        solve(nao, "L", T)
    finally:
        sys.setprofile(None)
    assert called[0] == limb
    assert len(called) <= most, called
