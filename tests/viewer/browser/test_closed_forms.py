"""The closed forms of the page, run by Node, beside Python's on the same targets."""

from __future__ import annotations

import functools
import importlib
import json
import subprocess
import tempfile
import threading
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from ik_checks import BESIDE, Floats, pose_errors
from loops import full

import nao_kin as nk
from nao_kin.errors import BadArgument
from nao_kin.ik import Family, IKResult, Reason
from nao_kin.robot.nao import VERSIONS
from nao_kin.rotations import exp

WEB = Path(__file__).resolve().parents[3] / "web"
SOURCES = WEB / "src"

# What the page does for each target; numbers that are no numbers do not go through JSON.
DRIVER = f"""
import {{ createInterface }} from "node:readline";
import {{ ArmPlace }} from "{(SOURCES / "ik" / "arm_place.ts").as_posix()}";
import {{ LIMB_CLASSES }} from "{(SOURCES / "ik" / "limbs.ts").as_posix()}";
"""
DRIVER += """
const solvers = {
  leg: (limb, [T], reference, enforce) => limb.solve(T, reference, enforce),
  arm: (limb, [T], reference, enforce) => limb.solve(T, reference, enforce),
  direction: (limb, [p, d], reference, enforce) => limb.solveDirection(p, d, reference, enforce),
  place: (limb, [p], reference, enforce) => new ArmPlace(limb, p, reference, enforce).solve(),
  head: (limb, [T], reference, enforce) => limb.solve(T, reference, enforce),
  gaze: (limb, [p], reference, enforce) => limb.solveGaze(p, reference, enforce),
  stand: (limb, [T, hip], reference) => limb.stand(T, hip, reference),
};
const answered = ({ limb, solver, enforce, targets, references }) => {
  const made = new LIMB_CLASSES[limb.kind](limb);
  return targets.map((target, i) => {
    const { branches, reason, joint, needed, limit, nearest } = solvers[solver](made, target, references[i], enforce);
    return { branches, reason, joint, needed, limit, nearest };
  });
};
for await (const line of createInterface({ input: process.stdin })) {
  process.stdout.write(JSON.stringify(JSON.parse(line).map(answered)) + "\\n");
}
"""


@dataclass
class Job:
    """Targets for one limb and one solver.

    Attributes:
        limb: as `nk.ik.limbs` describes it.
        solver: a key of the driver's solvers.
        targets: what it takes, one list for each target.
        references: configurations, shape (n, nq).
        enforce: whether limits are enforced.
        answers: what the page answered, when it has.
    """

    limb: dict[str, Any]
    solver: str
    targets: list[list[Any]]
    references: Floats
    enforce: bool = True
    answers: list[dict[str, Any]] = field(default_factory=list)


def node() -> str:
    """The Node that Playwright brings with it."""
    driver = pytest.importorskip("playwright._impl._driver", reason="playwright is not installed")
    return str(driver.compute_driver_executable()[0])


def packages() -> Path:
    """The packages of `npm ci`, of which esbuild makes JavaScript of the page's TypeScript."""
    found = WEB / "node_modules"
    if not found.is_dir():
        pytest.skip("npm ci was not run in web/")
    return found


@functools.cache
def driver() -> str:
    """DRIVER with the modules that it needs, as one module for Node."""
    packages()
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder, "driver.js")
        source.write_text(DRIVER, encoding="utf-8")
        command = [node(), str(WEB / "build.js"), "--node", folder, str(source)]
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
        assert done.returncode == 0, done.stderr
        return source.with_suffix(".mjs").read_text(encoding="utf-8")


@pytest.fixture(scope="module", autouse=True)
def _one_node() -> Iterator[None]:
    """Let the Node of all tests, if there is one, end after them."""
    yield
    if started.cache_info().currsize:
        started().communicate()
        started.cache_clear()


@functools.cache
def started() -> subprocess.Popen[str]:
    """A Node that answers lists of jobs, one a line."""
    command = [node(), "--input-type=module", "-e", driver()]
    return subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)


def answered(*jobs: Job) -> None:
    """Let Node solve all of them."""
    rows = [
        {"limb": job.limb, "solver": job.solver, "enforce": job.enforce, "targets": job.targets}
        | {
            "references": (
                job.references[:, job.limb["columns"]] * job.limb["multiplier"] + job.limb["offset"]
            ).tolist()
        }
        for job in jobs
    ]
    process = started()
    assert process.stdin is not None
    assert process.stdout is not None
    print(json.dumps(rows), file=process.stdin, flush=True)
    waiting = threading.Timer(120.0, process.kill)
    waiting.start()
    line = process.stdout.readline()
    waiting.cancel()
    assert line, "Node has ended; its error is in the captured stderr"
    for job, answers in zip(jobs, json.loads(line), strict=True):
        job.answers = answers


def limb_of(robot: nk.RobotModel, kind: str, side: str = "", frame: str | None = None) -> dict[str, Any]:
    found = [limb for limb in nk.ik.limbs(robot) if (limb["kind"], limb["side"]) == (kind, side)]
    return next(limb for limb in found if frame in (None, limb["frame"]))


def as_rows(*columns: Floats) -> list[list[Any]]:
    """Targets of several parts, each flat."""
    flat = [column.reshape(len(column), -1).tolist() for column in columns]
    return [list(parts) for parts in zip(*flat, strict=True)]


def branches_of(job: Job, count: int) -> Floats:
    """Return the coordinates of the page's branches, shape (n, count, joints), filled up with NaN."""
    values = np.full((len(job.answers), count, len(job.limb["joints"])), np.nan)
    for i, answer in enumerate(job.answers):
        for k, branch in enumerate(answer["branches"]):
            values[i, k] = branch["values"]
    return (values - job.limb["offset"]) / job.limb["multiplier"]


def assert_equal_answers(job: Job, found: IKResult) -> None:
    """Check that both answers have the same branches, in the same order, and the same reasons."""
    counts = np.array([len(answer["branches"]) for answer in job.answers])
    np.testing.assert_array_equal(counts, found.count)
    reasons = [answer["reason"] for answer in job.answers]
    assert reasons == [Reason(int(reason)).name for reason in found.reasons]
    values = branches_of(job, found.branches.shape[1])
    np.testing.assert_allclose(values, found.branches, rtol=0, atol=1e-9)
    families = [[branch["family"] for branch in answer["branches"]] for answer in job.answers]
    expected = [
        [Family(int(code)).name for code in codes[:count]]
        for codes, count in zip(found.families, found.count, strict=True)
    ]
    assert families == expected
    for key, numbers in (("joint", found.obstacles.joint), ("needed", found.obstacles.needed)):
        np.testing.assert_allclose([answer[key] for answer in job.answers], numbers, rtol=0, atol=1e-7)
    limits = [answer["limit"] for answer in job.answers]
    np.testing.assert_allclose(limits, found.obstacles.limit, rtol=0, atol=1e-7)


def assert_poses_met(nao: nk.NaoModel, job: Job, frame: str, T: Floats) -> None:
    """Forward kinematics of Python verifies every branch of the page, and its limits."""
    values = branches_of(job, max(len(answer["branches"]) for answer in job.answers))
    real = ~np.isnan(values[..., 0])
    q = np.array(np.broadcast_to(job.references[:, None], (*real.shape, nao.nq)))
    q[..., job.limb["columns"]] = values
    wanted = np.broadcast_to(T[:, None], (*real.shape, 4, 4))[real]
    assert pose_errors(nao.fk(q[real], frame), wanted).max() < 2e-10
    if job.enforce:
        assert nao.within_limits(q[real]).all()


def at_limits(nao: nk.NaoModel, q: Floats, joints: list[str]) -> Floats:
    """Configurations with one joint of each at an end of its range, coupled ones included."""
    q = q.copy()
    for i, row in enumerate(q):
        column = nao.joint_names.index(joints[i % len(joints)].replace("RHipYaw", "LHipYaw"))
        row[column] = (nao.lower, nao.upper)[i // len(joints) % 2][column]
    return nao.clamp(q)


def configurations(nao: nk.NaoModel, joints: list[str]) -> Floats:
    """Return configurations inside the limits, at their edges, and anywhere: 2000 of a V6, 500 of other versions."""
    third = 700 if nao.version == "v6" else 180
    inside, edges = nao.random(3, third), at_limits(nao, nao.random(4, third), joints)
    anywhere = np.random.default_rng(5).uniform(-np.pi, np.pi, (third, nao.nq))
    return np.concatenate([inside, edges, anywhere])


def pushed(T: Floats) -> Floats:
    """Return poses with every seventh one pushed away by 1 nm to 1 m."""
    T = T.copy()
    rows = np.arange(0, len(T), 7)
    away = T[rows, :3, 3] / np.linalg.norm(T[rows, :3, 3], axis=1, keepdims=True)
    T[rows, :3, 3] += away * 10.0 ** np.linspace(-9, 0, len(rows))[:, None]
    return T


# All pairs of a version, a side and limits.
WAYS = [("L", "enforce"), ("R", "ignore"), ("L", "ignore"), ("R", "enforce")]
CASES = [("v6", *way) for way in WAYS] + [
    (version, *way) for k, version in enumerate(VERSIONS[:-1]) for way in (WAYS[:2], WAYS[2:])[k % 2]
]
cases = pytest.mark.parametrize(("each_nao", "side", "limits"), [CASES[0], *full(*CASES[1:])], indirect=["each_nao"])


@cases
def test_legs_are_solved_as_in_python(each_nao: nk.NaoModel, side: str, limits: Any) -> None:
    nao, limb = each_nao, limb_of(each_nao, "leg", side)
    T = pushed(nao.fk(configurations(nao, limb["joints"]), f"{side}Leg"))
    job = Job(limb, "leg", as_rows(T), nao.random(9, len(T)), limits == "enforce")
    answered(job)
    found = nk.ik.leg(nao, side, T, near=job.references, limits=limits)
    assert_equal_answers(job, found)
    assert_poses_met(nao, job, f"{side}Leg", T)
    expected = {"REACHED", "OUT_OF_REACH", *(("JOINT_LIMIT", "COUPLED_LIMIT") if limits == "enforce" else ())}
    assert {answer["reason"] for answer in job.answers} == expected


@cases
def test_poses_of_hands_are_solved_as_in_python(each_nao: nk.NaoModel, side: str, limits: Any) -> None:
    nao, limb = each_nao, limb_of(each_nao, "arm", side)
    T = pushed(nao.fk(configurations(nao, limb["joints"]), f"{side}Arm"))
    job = Job(limb, "arm", as_rows(T), nao.random(9, len(T)), limits == "enforce")
    answered(job)
    found = nk.ik.arm(nao, side, T, near=job.references, limits=limits)
    assert_equal_answers(job, found)
    assert_poses_met(nao, job, f"{side}Arm", T)
    assert {"REACHED", "OUT_OF_REACH", "NOT_ENOUGH_JOINTS"} <= {answer["reason"] for answer in job.answers}


@pytest.mark.full
@cases
def test_places_and_directions_are_solved_as_in_python(each_nao: nk.NaoModel, side: str, limits: Any) -> None:
    nao, limb = each_nao, limb_of(each_nao, "arm", side)
    T = pushed(nao.fk(configurations(nao, limb["joints"]), f"{side}Arm"))
    directions = T[:, :3, 0].copy()
    directions[1::5] = np.random.default_rng(2).normal(size=directions[1::5].shape)
    job = Job(limb, "direction", as_rows(T[:, :3, 3], directions), nao.random(9, len(T)), limits == "enforce")
    answered(job)
    found = nk.ik.arm(nao, side, T[:, :3, 3], direction=directions, near=job.references, limits=limits)
    assert_equal_answers(job, found)


@pytest.mark.full
@pytest.mark.parametrize("side", ["L", *full("R")])
def test_places_alone_are_met_inside_the_limits_and_no_farther_from_the_reference(
    each_nao: nk.NaoModel, side: str
) -> None:
    nao, limb = each_nao, limb_of(each_nao, "arm", side)
    T = pushed(nao.fk(configurations(nao, limb["joints"])[::10], f"{side}Arm"))
    job = Job(limb, "place", as_rows(T[:, :3, 3]), nao.random(9, len(T)))
    answered(job)
    found = nk.ik.arm(nao, side, T[:, :3, 3], near=job.references)
    counts = np.array([len(answer["branches"]) for answer in job.answers])
    np.testing.assert_array_equal(counts == 1, found.success)
    assert [answer["reason"] for answer in job.answers] == [Reason(int(reason)).name for reason in found.reasons]
    reached = counts == 1
    assert reached.sum() > 30
    q = job.references[reached]
    q[:, limb["columns"]] = branches_of(job, 1)[reached, 0]
    assert np.abs(nao.position(q, f"{side}Arm") - T[reached, :3, 3]).max() < 1e-10
    assert nao.within_limits(q).all()
    away, expected = (np.linalg.norm(rows - job.references[reached], axis=1) for rows in (q, found.q[reached]))
    # Both searches step along the ridge that a limit of a joint makes, and may end on it at places 1e-4 apart.
    np.testing.assert_allclose(away, expected, rtol=0, atol=1e-4)
    assert np.quantile(np.abs(away - expected), 0.9) < 1e-6


@pytest.mark.full
@pytest.mark.parametrize("limits", ["enforce", *full("ignore")])
def test_heads_and_gazes_are_solved_as_in_python(each_nao: nk.NaoModel, limits: Any) -> None:
    nao, limb = each_nao, limb_of(each_nao, "head")
    q = configurations(nao, limb["joints"])
    T = nao.fk(q, "Head")
    T[::5, :3, :3] = T[::5, :3, :3] @ exp(np.random.default_rng(1).normal(size=(len(T[::5]), 3), scale=0.3))
    heads = Job(limb, "head", as_rows(T), nao.random(9, len(T)), limits == "enforce")
    gazes = []
    for camera in ("CameraTop", "CameraBottom"):
        seen = nao.fk(q, camera)
        points = seen[:, :3, 3] + np.random.default_rng(6).uniform(0.0, 2.0, (len(q), 1)) * seen[:, :3, 0]
        points[::9] = seen[::9, :3, 3] + np.random.default_rng(7).normal(size=(len(points[::9]), 3), scale=0.05)
        gazes.append(Job(limb_of(nao, "gaze", frame=camera), "gaze", as_rows(points), heads.references, heads.enforce))
    answered(heads, *gazes)
    found = nk.ik.head(nao, T[:, :3, :3], near=heads.references, limits=limits)
    assert_equal_answers(heads, found)
    assert_nearest(heads, found)
    for job in gazes:
        points = np.array([target[0] for target in job.targets])
        found = nk.ik.look_at(nao, points, job.limb["frame"], near=job.references, limits=limits)
        assert_equal_answers(job, found)
        if job.enforce:  # without limits the search for a point nearer than the camera ends in any of its valleys
            assert_nearest(job, found)


@pytest.mark.parametrize("side", ["L", *full("R")])
def test_limbs_of_a_calibrated_robot_are_solved_as_in_python(nao: nk.NaoModel, side: str) -> None:
    rows = np.random.default_rng(19).uniform(-0.05, 0.05, nao.nq)
    offsets = {name: float(row) for name, row in zip(nao.joint_names, rows, strict=True) if "Hand" not in name}
    cameras = dict.fromkeys(nao.semantics.cameras, (0.004, -0.01, 0.003, 0.2, -0.1, 0.3))
    mine = nao.with_offsets(offsets | {"RHipYawPitch": 0.03}, cameras)
    test_legs_are_solved_as_in_python(mine, side, "enforce")
    test_poses_of_hands_are_solved_as_in_python(mine, side, "enforce")
    test_heads_and_gazes_are_solved_as_in_python(mine, "enforce")


def assert_nearest(job: Job, found: IKResult) -> None:
    """Check that a target out of reach is missed by no more than in Python."""
    missed = [(i, answer["nearest"]["error"]) for i, answer in enumerate(job.answers) if answer.get("nearest")]
    assert missed
    rows, errors = (np.array(column) for column in zip(*missed, strict=True))
    np.testing.assert_allclose(errors, found.residual[rows, 1], rtol=0, atol=1e-7)


@pytest.mark.parametrize("enforce", [True, False])
@pytest.mark.parametrize("side", ["L", "R"])
def test_legs_at_and_beside_singularities_meet_their_poses(nao: nk.NaoModel, side: str, enforce: bool) -> None:
    limb = limb_of(nao, "leg", side)
    roll, knee, pitch, turn = (limb["columns"][joint] for joint in (1, 3, 4, 5))
    thigh, tibia = (limb["geometry"][name] for name in ("thigh", "tibia"))
    q = nao.random(11, 6 * len(BESIDE))
    beside = np.array(BESIDE)[:, None] * [1.0, -1.0]
    straight, locked, on_axis = q.reshape(3, len(BESIDE), 2, nao.nq)
    straight[..., knee] = beside
    locked[..., roll] = (-1.0 if side == "L" else 1.0) * np.pi / 4 + beside
    ankle = 0.85
    on_axis[..., pitch] = ankle + beside
    on_axis[..., knee] = np.arccos(-tibia * np.cos(ankle) / thigh) - ankle
    on_axis[..., turn] = 0.02
    T = nao.fk(q, f"{side}Leg")
    job = Job(limb, "leg", as_rows(T), nao.random(12, len(T)), enforce)
    answered(job)
    found = nk.ik.leg(nao, side, T, near=job.references, limits="enforce" if enforce else "ignore")
    np.testing.assert_array_equal([len(answer["branches"]) for answer in job.answers], found.count)
    assert_poses_met(nao, job, f"{side}Leg", T)
    families = {branch["family"] for answer in job.answers for branch in answer["branches"]}
    assert families >= ({"NONE", "ANKLE_AXIS"} if enforce else {"NONE", "ANKLE_AXIS", "HIP_LOCK"})


@pytest.mark.parametrize("enforce", [True, False])
def test_arms_at_and_beside_singularities_meet_their_poses(enforce: bool) -> None:
    nao = nk.load_nao("v3.2")  # without an offset at the elbow: it may be on the axis of ShoulderPitch
    limb = limb_of(nao, "arm", "L")
    q = nao.random(15, 4 * len(BESIDE))
    beside = np.array(BESIDE)[:, None] * [1.0, -1.0]
    spread, stretched = q.reshape(2, len(BESIDE), 2, nao.nq)
    spread[..., limb["columns"][1]] = np.pi / 2 + beside
    stretched[..., limb["columns"][3]] = beside
    T = nao.fk(q, "LArm")
    job = Job(limb, "arm", as_rows(T), nao.random(16, len(T)), enforce)
    answered(job)
    found = nk.ik.arm(nao, "L", T, near=job.references, limits="enforce" if enforce else "ignore")
    np.testing.assert_array_equal([len(answer["branches"]) for answer in job.answers], found.count)
    assert_poses_met(nao, job, "LArm", T)
    families = {branch["family"] for answer in job.answers for branch in answer["branches"]}
    assert families >= ({"NONE", "SHOULDER_AXIS"} if enforce else {"NONE", "SHOULDER_AXIS", "ELBOW_LOCK"})


@pytest.mark.parametrize("side", ["L", "R"])
def test_a_foot_stands_where_it_was_with_another_turn_of_the_hips(each_nao: nk.NaoModel, side: str) -> None:
    nao, limb = each_nao, limb_of(each_nao, "leg", side)
    q = nao.random(17, 500)
    T, hips = nao.fk(q, f"{side}Leg"), q[:, limb["columns"][0]].copy()
    hips[::2] = nao.random(18, 250)[:, limb["columns"][0]]
    job = Job(limb, "stand", [[row.ravel().tolist(), float(hip)] for row, hip in zip(T, hips, strict=True)], q)
    answered(job)
    stood = [i for i, answer in enumerate(job.answers) if answer["branches"]]
    assert len(stood) > 300
    for i in stood:
        for branch in job.answers[i]["branches"]:
            moved = q[i].copy()
            moved[limb["columns"]] = branch["values"]
            made = nao.fk(moved, f"{side}Leg")
            assert moved[limb["columns"][0]] == pytest.approx(hips[i], abs=1e-15)
            assert np.abs(made[:3, 2:] - T[i][:3, 2:]).max() < 1e-10  # the sole's normal and its place
            about_normal = T[i][:3, :3] @ exp(np.array([0.0, 0.0, branch["yaw"]]))
            assert np.abs(made[:3, :3] - about_normal).max() < 1e-10
            assert nao.within_limits(moved)
    for i in range(1, 500, 2):  # with the turn that the hips had: the configuration itself
        assert np.abs(np.array(job.answers[i]["branches"][0]["values"]) - q[i, limb["columns"]]).max() < 1e-8
        assert abs(job.answers[i]["branches"][0]["yaw"]) < 1e-8


def test_what_is_no_rigid_transform_is_refused_in_the_page_too(nao: nk.NaoModel) -> None:
    T = np.broadcast_to(nao.fk(nao.posture("StandInit"), "LLeg"), (3, 4, 4)).copy()
    T[0, 0, 0] += 1e-3
    T[1, :3, :3] *= -1.0
    T[2, 3, 3] = 2.0
    jobs = [
        Job(limb_of(nao, kind, side), kind, as_rows(T), nao.random(1, 3)) for kind, side in (("leg", "L"), ("arm", "L"))
    ]
    answered(*jobs)
    assert {answer["reason"] for job in jobs for answer in job.answers} == {"NOT_RIGID"}


@pytest.mark.full
def test_a_fault_planted_in_the_page_is_no_mistake_in_its_grammar(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.syspath_prepend(Path(__file__).resolve().parents[3] / "scripts")
    mutate = importlib.import_module("mutate")
    faults = [fault for fault in mutate.read_faults() if fault.path.endswith(".ts")]
    assert faults
    for number, fault in enumerate(faults):
        (tmp_path / f"{number}.ts").write_text(mutate.planted(fault), encoding="utf-8")
    command = [node(), str(packages() / "esbuild" / "bin" / "esbuild"), f"--outdir={tmp_path / 'out'}"]
    done = subprocess.run([*command, *map(str, tmp_path.glob("*.ts"))], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_limbs_are_plain_and_those_of_the_robot(nao: nk.NaoModel) -> None:
    limbs = nk.ik.limbs(nao)
    assert json.loads(json.dumps(limbs, allow_nan=False)) == limbs
    assert [(limb["kind"], limb["side"], limb["frame"]) for limb in limbs] == [
        ("arm", "L", "LArm"),
        ("arm", "R", "RArm"),
        ("leg", "L", "LLeg"),
        ("leg", "R", "RLeg"),
        ("head", "", "Head"),
        ("gaze", "", "CameraTop"),
        ("gaze", "", "CameraBottom"),
    ]
    for limb in limbs:
        rows = [nao.joint_names.index(name.replace("RHipYaw", "LHipYaw")) for name in limb["joints"]]
        assert limb["columns"] == rows
        np.testing.assert_array_equal(limb["lower"], nao.lower[rows])
        np.testing.assert_array_equal(limb["upper"], nao.upper[rows])
        tables = [table for table in nao.coupled_limits if table.joint in limb["joints"]]
        assert (limb["table"] is not None) == bool(tables)
        for table in tables:
            described = limb["table"]
            assert limb["joints"][described["joint"]] == table.joint
            assert limb["joints"][described["of"]] == table.of
            assert [described[key] for key in ("at", "lower", "upper")] == [
                list(column) for column in (table.at, table.lower, table.upper)
            ]
    moved = nk.load_nao()
    hip = int(moved.model.getJointId("LHipYawPitch"))
    moved.model.jointPlacements[hip].translation += np.array([0.001, 0.0, 0.0])
    assert limb_of(moved, "leg", "L")["geometry"]["hip"][0] == limb_of(nao, "leg", "L")["geometry"]["hip"][0] + 0.001


def test_the_limbs_of_the_unit_tests_of_the_page_are_those_of_the_robot(nao: nk.NaoModel) -> None:
    def to_picometres(text: str) -> Any:  # what machines round differently
        return json.loads(text, parse_float=lambda number: round(float(number), 12))

    path = WEB / "tests" / "limbs.json"
    described = json.dumps(nk.ik.limbs(nao))
    in_step = to_picometres(path.read_text(encoding="utf-8")) == to_picometres(described)
    assert in_step, f"write json.dumps(nk.ik.limbs(nk.load_nao())) into {path}, then npm run format in web/"


def test_a_robot_without_such_limbs_has_none(tmp_path: Path) -> None:
    path = tmp_path / "bare.urdf"
    path.write_text('<robot name="bare"><link name="only"/></robot>', encoding="utf-8")
    assert nk.ik.limbs(nk.RobotModel.from_urdf(path)) == []
    with pytest.raises(BadArgument, match="robot"):
        nk.ik.limbs("nao")  # type: ignore[arg-type]
