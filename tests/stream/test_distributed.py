"""Dask arrays in, dask arrays out: the numbers of a single process, wherever they are computed."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cloudpickle
import dask
import dask.array as da
import numpy as np
import pytest
from loops import for_all, full
from made_up_robots import J, made_up

import nao_kin as nk
from nao_kin import distributed
from nao_kin.errors import BadArgument, MissingExtra, NotFinite, UnknownName, WrongShape
from nao_kin.stream.distributed import PickledRobot

ENVIRONMENT = {**os.environ, "PYTHONPATH": str(Path(nk.__file__).parent.parent)}

# Each function of the room, and what it is asked.
QUESTIONS: dict[str, tuple[str, tuple[Any, ...], dict[str, Any]]] = {
    "pose of one frame": ("fk", ("LArm",), {}),
    "poses of two frames in a third": ("fk", (["LArm", "Head"],), {"reference": "RFoot"}),
    "poses of all links": ("fk", (), {}),
    "rotation": ("rotation", ("LArm",), {"reference": "Head"}),
    "positions": ("position", (("LArm", "RArm"),), {}),
    "Jacobian": ("jacobian", ("LArm", "frame"), {}),
    "quaternions": ("fk", (["LArm", "Head"],), {"as_": "quaternion"}),
    "Jacobian of the centre of mass": ("com_jacobian", (), {"reference": "LFoot"}),
    "centre of mass": ("com", (), {"reference": "LFoot"}),
}
BATCHES = {
    "one configuration": ((), ()),
    "none": ((0,), (1,)),
    "one chunk": ((6,), (6,)),
    "uneven chunks": ((10,), ((3, 1, 6),)),
    "two axes": ((4, 6), (3, 2)),
    "three axes": ((2, 3, 4), (1, 2, 3)),
}


@for_all("question", QUESTIONS)
@pytest.mark.parametrize(
    ("batch", "last"),
    [("none", -1), ("three axes", 7), *full(*((batch, 7) for batch in BATCHES if batch != "three axes"))],
)
def test_the_results_are_those_of_a_single_process(nao: nk.NaoModel, batch: str, last: int, question: str) -> None:
    name, arguments, options = QUESTIONS[question]
    shape, chunks = BATCHES[batch]
    q = nao.random(0, shape)
    expected = getattr(nao, name)(q, *arguments, **options, threads=1)
    cut = da.from_array(q, chunks=(*chunks, last))
    lazy = getattr(distributed, name)(nao, cut, *arguments, **options)
    assert isinstance(lazy, da.Array)
    assert lazy.shape == expected.shape
    assert lazy.chunks[: len(shape)] == cut.chunks[: len(shape)]
    assert lazy.dtype == np.float64
    assert type(lazy._meta) is np.ndarray
    assert lazy._meta.ndim == lazy.ndim
    for scheduler in ("sync", "threads"):
        computed = lazy.compute(scheduler=scheduler)
        assert type(computed) is np.ndarray
        assert computed.dtype == lazy.dtype
        assert np.array_equal(computed, expected)


@pytest.mark.parametrize("base", ["fixed", "floating"])
def test_any_robot_is_taken(tmp_path: Path, base: str) -> None:
    joints = J("turn", (0.6, 0.0, 0.8)), J("slide", kind="prismatic"), J("follow", follows=("turn", -0.5, 0.1))
    robot = made_up(tmp_path, *joints, base=base)
    q = robot.random(0, 20)
    cut = da.from_array(q, chunks=(6, -1))
    assert np.array_equal(distributed.fk(robot, cut).compute(), robot.fk(q, threads=1))
    lazy = distributed.jacobian(robot, cut, "follow_l", "root")
    assert lazy.shape == (20, 6, robot.nv)
    assert np.array_equal(lazy.compute(), robot.jacobian(q, "follow_l", "root", threads=1))


def test_single_precision_stays_single_precision(nao: nk.NaoModel) -> None:
    q = nao.random(0, 30).astype(np.float32)
    cut = da.from_array(q, chunks=(8, -1))
    single = distributed.fk(nao, cut, "LArm")
    assert single.dtype == single._meta.dtype == np.float32
    assert single.compute().dtype == np.float32
    assert np.abs(single.compute() - nao.fk(q, "LArm")).max() < 2e-6
    assert distributed.com(nao, cut, dtype=np.float64).compute().dtype == np.float64
    double = da.from_array(nao.random(0, 30), chunks=(8, -1))
    assert distributed.position(nao, double, "LArm", dtype="float32").compute().dtype == np.float32
    assert distributed.position(nao, da.zeros((3, nao.nq), dtype=int), "LArm").compute().dtype == np.float64


def test_nothing_is_computed_before_it_is_asked_for(nao: nk.NaoModel) -> None:
    made = []

    def configurations() -> np.ndarray:
        made.append(1)
        return nao.random(0, 5)

    q = da.from_delayed(dask.delayed(configurations)(), (5, nao.nq), dtype=float)
    lazy = distributed.fk(nao, q, "LArm")[1:3]
    assert not made
    assert np.array_equal(lazy.compute(scheduler="sync"), nao.fk(nao.random(0, 5), "LArm", threads=1)[1:3])
    assert len(made) == 1


def test_an_unknown_number_of_rows_stays_unknown_and_works(nao: nk.NaoModel) -> None:
    q = nao.random(0, 40)
    cut = da.from_array(q, chunks=(9, -1))
    for some in (cut[cut[:, 0] > 0.0], cut[cut[:, 0] > 0.0].rechunk({1: 10})):
        lazy = distributed.fk(nao, some, "LArm")
        assert np.isnan(lazy.shape[0])
        assert lazy.shape[1:] == (4, 4)
        assert np.array_equal(lazy.compute(scheduler="sync"), nao.fk(q[q[:, 0] > 0.0], "LArm", threads=1))


@for_all("chunks", [(3, -1), (4, 7), ((1, 9), -1)])
def test_motions_take_arrays_that_are_cut_otherwise(nao: nk.NaoModel, chunks: tuple[Any, ...]) -> None:
    rng = np.random.default_rng(0)
    q, v, a = nao.random(rng, 10), rng.normal(size=(10, nao.nv)), rng.normal(size=(10, nao.nv))
    Q, V, A = da.from_array(q, chunks=(4, -1)), da.from_array(v, chunks=chunks), da.from_array(a, chunks=(10, 5))
    twists = distributed.velocity(nao, Q, V, ["LArm", "Head"], "frame")
    assert twists.shape == (10, 2, 6)
    assert twists.chunks[0] == Q.chunks[0]
    assert np.array_equal(twists.compute(), nao.velocity(q, v, ["LArm", "Head"], "frame", threads=1))
    single = distributed.velocity(nao, Q, V, "LArm", dtype=np.float32).compute()
    assert np.array_equal(single, nao.velocity(q, v, "LArm", dtype=np.float32, threads=1))
    inside = distributed.acceleration(nao, Q, V, A, "LArm", expressed_in="frame").compute()
    assert np.array_equal(inside, nao.acceleration(q, v, a, "LArm", "frame", threads=1))
    rates = distributed.acceleration(nao, Q, V, A, "LArm", dtype=np.float32)
    assert rates.dtype == np.float32
    assert np.array_equal(rates.compute(), nao.acceleration(q, v, a, "LArm", dtype=np.float32, threads=1))
    with pytest.raises(WrongShape, match=r"v must have shape \(10, 25\), got \(9, 25\)"):
        distributed.velocity(nao, Q, V[:9], "LArm")
    with pytest.raises(WrongShape, match=r"a must have shape"):
        distributed.acceleration(nao, Q, V, A[:, :9], "LArm")


# --- what is refused, and when ----------------------------------------------------------------------------------------


@for_all(
    ("ask", "message"),
    [
        (lambda nao, q: distributed.fk(nao, q, "LArn"), "unknown frame 'LArn' .*LArm"),
        (lambda nao, q: distributed.rotation(nao, q, ["LArm", "LArn"]), "unknown frame 'LArn' .*LArm"),
        (lambda nao, q: distributed.position(nao, q, "LArm", reference="LFot"), "unknown frame 'LFot' .*LFoot"),
        (lambda nao, q: distributed.com(nao, q, reference="LFot"), "unknown frame 'LFot' .*LFoot"),
        (lambda nao, q: distributed.jacobian(nao, q, "LArm", "fram"), "unknown expression 'fram' .*frame"),
    ],
)
def test_a_misspelt_name_is_refused_at_the_call(nao: nk.NaoModel, ask: Callable[..., Any], message: str) -> None:
    with pytest.raises(UnknownName, match=message):
        ask(nao, da.zeros((4, nao.nq)))


@for_all(
    ("q", "kind", "message"),
    [
        (da.zeros((4, 24)), WrongShape, r"q must have shape \(\.\.\., 25\), got \(4, 24\)"),
        (da.zeros(()), WrongShape, r"got \(\)"),
        (da.zeros((4, 30))[:, da.arange(30) < 25], WrongShape, r"unknown last axis: call q\.compute_chunk_sizes"),
    ],
)
def test_what_holds_no_configurations_is_refused(nao: nk.NaoModel, q: Any, kind: type, message: str) -> None:
    with pytest.raises(kind, match=message):
        distributed.fk(nao, q, "LArm")


def test_other_types_of_numbers_are_refused(nao: nk.NaoModel) -> None:
    q = da.zeros((4, nao.nq))
    for dtype in (np.float16, int, "flaot32", complex):
        with pytest.raises(BadArgument, match="dtype must be float64 or float32"):
            distributed.com(nao, q, dtype=dtype)


def test_a_number_that_is_none_is_named_with_its_block(nao: nk.NaoModel) -> None:
    q = nao.random(0, (20, 4))
    q[17, 2, nao.joint_names.index("LHipRoll")] = np.nan
    cut = da.from_array(q, chunks=(5, 2, -1))
    with pytest.raises(NotFinite, match=r"nan at index \[2, 0, \d+\] \(LHipRoll\); counted within q\.blocks\[3, 1\]$"):
        distributed.fk(nao, cut, "LArm").compute()
    assert np.isnan(cut.blocks[3, 1].compute()[2, 0]).any()


def test_without_dask_one_line_names_the_extra(nao: nk.NaoModel, monkeypatch: pytest.MonkeyPatch) -> None:
    for module in ("dask", "dask.array", "distributed"):
        monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(MissingExtra, match=r"nao_kin\.distributed needs .*nao-kin\[dask\]'; arrays in memory"):
        distributed.fk(nao, np.zeros(25), "LArm")
    with pytest.raises(MissingExtra, match=r"nao-kin\[dask\]"):
        distributed.connect()


# --- how the robot travels --------------------------------------------------------------------------------------------


def test_the_robot_is_in_the_graph_once(nao: nk.NaoModel) -> None:
    lazy = distributed.fk(nao, da.zeros((100, nao.nq), chunks=(1, -1)), "LArm")
    # Each by itself, as a scheduler sends them: pickled together, they would share it.
    sizes = [len(cloudpickle.dumps(task)) for task in dict(dask.optimize(lazy)[0].__dask_graph__()).values()]
    robot = len(PickledRobot.of(nao).data)
    assert len(sizes) > 100
    assert sum(size > robot for size in sizes) == 1
    assert sorted(sizes)[-2] < 0.1 * robot


def test_a_process_loads_the_robot_once_and_shares_it(nao: nk.NaoModel) -> None:
    first, second = PickledRobot.of(nao), pickle.loads(pickle.dumps(PickledRobot.of(nk.load_nao())))
    assert first == second
    assert first.load() is second.load()
    assert first.load() is not nao
    assert "data" not in repr(first)


def test_the_robot_is_taken_as_it_is_at_the_call() -> None:
    nao = nk.load_nao()
    q = nao.random(0, 4)
    before = nao.fk(q, "LArm", threads=1)
    lazy = distributed.fk(nao, da.from_array(q), "LArm")
    longer = nao.model.jointPlacements[nao.model.getJointId("LElbowYaw")].copy()
    longer.translation = 2.0 * longer.translation
    nao.model.jointPlacements[nao.model.getJointId("LElbowYaw")] = longer
    after = nao.fk(q, "LArm", threads=1)
    assert not np.allclose(before, after)
    assert np.array_equal(lazy.compute(), before)
    assert np.array_equal(distributed.fk(nao, da.from_array(q), "LArm").compute(), after)


def test_equal_questions_have_equal_names_and_others_have_others(nao: nk.NaoModel) -> None:
    q = da.zeros((4, nao.nq), chunks=(2, -1))
    asked = [
        distributed.fk(nao, q, "LArm"),
        distributed.fk(nao, q, "RArm"),
        distributed.fk(nao, q, ["LArm"]),
        distributed.fk(nao, q, "LArm", reference="Head"),
        distributed.fk(nao, q, "LArm", dtype=np.float32),
        distributed.fk(nao, q + 1.0, "LArm"),
        distributed.fk(nk.load_nao("v5"), q, "LArm"),
        distributed.rotation(nao, q, "LArm"),
    ]
    assert len({lazy.name for lazy in asked}) == len(asked)
    for same in (nao, nk.load_nao(), pickle.loads(pickle.dumps(nao))):
        assert distributed.fk(same, q, "LArm").name == asked[0].name
    assert distributed.fk(nao, q, ("LArm",)).name == asked[2].name


@pytest.mark.full
def test_another_process_finds_the_same_name() -> None:
    # A robot that no other test has changed, and an array with a name of its own: dask 2024.12 names da.zeros by its
    # pickled code, which may differ between processes.
    program = (
        "import dask.array as da, nao_kin as nk, numpy as np\n"
        "nao = nk.load_nao()\n"
        "q = da.from_array(np.zeros((4, nao.nq)), chunks=(2, -1), name='q')\n"
        "names = [nk.distributed.PickledRobot.of(nao).token, nk.distributed.fk(nao, q, 'LArm').name]"
    )
    environment = {**ENVIRONMENT, "PYTHONHASHSEED": "7"}
    command = [sys.executable, "-c", f"{program}\nprint(*names)"]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    here: dict[str, Any] = {}
    exec(program, here)
    assert done.stdout.split() == here["names"]
