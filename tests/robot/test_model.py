from __future__ import annotations

import math
import pickle
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, strategies as st
from loops import for_all

import nao_kin as nk
from nao_kin import errors
from nao_kin.errors import (
    BadArgument,
    CouplingViolated,
    NaoKinError,
    NotFinite,
    OutsideLimits,
    UnknownName,
    WrongShape,
)
from nao_kin.robot import kinematics as kinematics_module


def _raw_pose(model: pin.Model, q: np.ndarray, frame: str) -> np.ndarray:
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    return data.oMf[model.getFrameId(frame)].homogeneous


# --- configurations ---------------------------------------------------------------------------------------------------


def test_a_nao_has_exactly_25_degrees_of_freedom(each_nao: nk.NaoModel) -> None:
    assert each_nao.nq == each_nao.nv == len(each_nao.joint_names) == 25
    assert each_nao.nq_base == 0
    assert "RHipYawPitch" not in each_nao.joint_names
    assert each_nao.mimics["RHipYawPitch"].joint == "LHipYawPitch"


def test_arrays_of_the_model_cannot_be_written_to(nao: nk.NaoModel) -> None:
    for array in (nao.lower, nao.upper, nao.velocity_limits, nao.effort_limits):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0


def test_random_configurations_are_inside_all_limits_and_reproducible(each_nao: nk.NaoModel) -> None:
    q = each_nao.random(7, 2000)
    assert q.shape == (2000, 25)
    assert each_nao.limit_violations(q) == ()
    assert np.array_equal(q, each_nao.random(np.random.default_rng(7), 2000))
    assert each_nao.random(7).shape == (25,)
    assert each_nao.random(7, (2, 3)).shape == (2, 3, 25)
    assert each_nao.random(7, np.int64(2)).shape == (2, 25)
    assert np.all(np.ptp(q, axis=0) > 0.8 * (each_nao.upper - each_nao.lower))


def test_angles_and_configuration_are_inverse(nao: nk.NaoModel) -> None:
    q = nao.random(0)
    assert np.array_equal(nao.configuration(nao.angles(q)), q)
    batch = nao.random(0, (2, 3))
    assert np.array_equal(nao.configuration(nao.angles(batch)), batch)


def test_configuration_takes_batches_of_one_shape_and_scalars_beside_them(nao: nk.NaoModel) -> None:
    q = nao.configuration({"HeadYaw": [0.1, 0.2], "HeadPitch": 0.05})
    assert q.shape == (2, 25)
    assert q[1, nao.joint_names.index("HeadYaw")] == 0.2
    with pytest.raises(WrongShape):
        nao.configuration({"HeadYaw": [0.1, 0.2], "HeadPitch": [0.1, 0.2, 0.3]})


@for_all("name", ["Stand", "StandInit", "StandZero", "Crouch", "Sit", "SitRelax", "LyingBelly", "LyingBack"])
def test_postures_are_inside_all_limits(each_nao: nk.NaoModel, name: str) -> None:
    each_nao.check_limits(each_nao.posture(name))


def test_body_values_are_those_of_the_joints_on_a_floating_base_too() -> None:
    nao = nk.load_nao(base="floating")
    body = np.arange(26.0)
    right = nao.body_order.index("RHipYawPitch")
    body[right] = body[nao.body_order.index("LHipYawPitch")]
    q = nao.from_body(body)  # no limits unless they are asked for
    assert q[:7].tolist() == [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]
    assert nao.to_body(q).tolist() == body.tolist()
    assert nao.angles(q)["RShoulderRoll"] == nao.body_order.index("RShoulderRoll")
    with pytest.raises(OutsideLimits):
        nao.from_body(body, limits="enforce")
    assert nao.within_limits(nao.from_body(body, limits="clamp"))


def test_two_hips_that_disagree_are_refused_by_both_names_and_values(nao: nk.NaoModel) -> None:
    both = {"LHipYawPitch": np.array([-0.1, -0.3]), "RHipYawPitch": np.array([-0.2, -0.3]), "HeadYaw": 0.5}
    for hips, value in (("average", -0.15), ("left", -0.1), ("right", -0.2)):
        found = nao.angles(nao.configuration(both, hips=hips))
        assert np.allclose(found["LHipYawPitch"], [value, -0.3], rtol=0.0, atol=1e-15)
        assert found["HeadYaw"].tolist() == [0.5, 0.5]
        in_degrees = {name: np.degrees(angle) for name, angle in both.items()}
        assert np.allclose(nao.configuration(in_degrees, degrees=True, hips=hips), nao.configuration(both, hips=hips))
    with pytest.raises(UnknownName, match="rule for the hips"):
        nao.configuration(both, hips="both")
    with pytest.raises(CouplingViolated, match=r"LHipYawPitch = 0\.1 drives RHipYawPitch.* RHipYawPitch = 0\.2"):
        nao.configuration({"LHipYawPitch": 0.1, "RHipYawPitch": 0.2})
    body = nao.to_body(nao.neutral())
    body[nao.body_order.index("RHipYawPitch")] = 0.3
    with pytest.raises(CouplingViolated) as caught:
        nao.from_body(body)
    assert (caught.value.primary, caught.value.mimic, caught.value.mimic_value) == ("LHipYawPitch", "RHipYawPitch", 0.3)


def test_one_hip_alone_sets_the_other(nao: nk.NaoModel) -> None:
    assert np.array_equal(nao.configuration({"RHipYawPitch": 0.2}), nao.configuration({"LHipYawPitch": 0.2}))


def test_a_finger_sets_its_hand(nao: nk.NaoModel) -> None:
    q = nao.configuration({"LHandFinger11": 0.5})
    assert q[nao.joint_names.index("LHand")] == pytest.approx(0.5 / 0.999899)
    with pytest.raises(CouplingViolated):
        nao.configuration({"LHandFinger11": 0.5, "LHandFinger12": 0.6})


# --- forward kinematics -----------------------------------------------------------------------------------------------


def test_poses_are_those_of_pinocchio(each_nao: nk.NaoModel) -> None:
    for q in each_nao.random(2, 5):
        for frame in each_nao.frame_names:
            expected = _raw_pose(each_nao.model, q, frame)
            assert np.array_equal(each_nao.fk(q, frame), expected)
        assert np.array_equal(each_nao.fk(q), each_nao.fk(q, each_nao.link_names))


def test_without_the_known_memory_layout_the_poses_are_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    fast, slow = nk.load_nao(), nk.load_nao()
    monkeypatch.setattr(kinematics_module, "_block_of", lambda data, count: None)
    q = fast.random(0)
    assert np.array_equal(slow.fk(q), nk.load_nao().fk(q))
    monkeypatch.undo()
    assert np.array_equal(fast.fk(q), slow.fk(q))
    assert np.array_equal(fast.fk(q, "LArm"), slow.fk(q, "LArm"))


def test_the_layout_is_recognised_by_its_addresses(nao: nk.NaoModel) -> None:
    data = nao.model.createData()
    assert kinematics_module._block_of(data, nao.model.nframes) is not None
    other = type("Data", (), {"oMf": [pin.SE3.Identity() for _ in range(5)]})()
    assert kinematics_module._block_of(other, 5) is None


def test_the_world_is_a_reference_with_a_floating_base_alone(nao: nk.NaoModel) -> None:
    floating = nk.load_nao(base="floating")
    q = np.concatenate([[1.0, 2.0, 3.0, 0.0, 0.0, 0.6, 0.8], nao.random(3)])
    assert np.array_equal(floating.fk(q, "LLeg", reference="world"), floating.fk(q, "LLeg"))
    assert np.allclose(floating.fk(q, "LLeg", reference="torso"), nao.fk(q[7:], "LLeg"), atol=1e-14)
    message = "unknown frame 'world' .*; the place of a fixed base in the world is not known; load .* base=.floating"
    for ask in (nao.fk, nao.rotation, nao.position):
        with pytest.raises(UnknownName, match=message):
            ask(q[7:], "LLeg", reference="world")
    for ask in (nao.com, nao.support_polygon):
        with pytest.raises(UnknownName, match=message):
            ask(q[7:], reference="world")
    with pytest.raises(UnknownName, match="the world is a reference only"):
        floating.fk(q, "world")


@for_all("frames", ["LArm", ["LArm"], ["LArm", "Head", "RLeg"], None])
@for_all("shape", [(), (1,), (5,), (2, 3)])
def test_relative_poses_are_those_of_pinocchio_for_any_number_of_frames(nao: nk.NaoModel, frames, shape) -> None:
    q = nao.random(4, shape)
    found = nao.fk(q, frames, reference="LElbowRoll").reshape(-1, *nao.fk(q[(0,) * len(shape)], frames).shape)
    names = [frames] if isinstance(frames, str) else nao.link_names if frames is None else frames
    data = nao.model.createData()
    for row, poses in zip(q.reshape(-1, 25), found, strict=True):
        pin.framesForwardKinematics(nao.model, data, row)
        reference = data.oMf[nao.frame_ids(["LElbowRoll"])[0]]
        for index, T in zip(nao.frame_ids(names), poses.reshape(-1, 4, 4), strict=True):
            assert np.allclose(T, reference.actInv(data.oMf[index]).homogeneous, rtol=0.0, atol=1e-14)


def test_results_are_fresh_arrays(nao: nk.NaoModel) -> None:
    q = nao.random(5)
    first = nao.fk(q)
    kept = first.copy()
    nao.fk(nao.random(6))
    assert np.array_equal(first, kept)
    first[...] = 0.0
    assert np.array_equal(nao.fk(q), kept)
    for array in (nao.fk(q, "LArm"), nao.rotation(q, "LArm"), nao.position(q, "LArm"), nao.com(q), nao.check_limits(q)):
        assert array.flags.writeable
        assert not np.shares_memory(array, q)


# --- Jacobian and centre of mass --------------------------------------------------------------------------------------


def _twist_by_differences(
    robot: nk.RobotModel, q: np.ndarray, frame: str, column: int, step: float = 1e-6
) -> np.ndarray:
    """(v, ω) of the frame's origin in the root's axes, by central differences along one velocity coordinate."""
    velocity = np.zeros(robot.nv)
    velocity[column] = step
    before = robot.fk(pin.integrate(robot.model, q, -velocity), frame)
    after = robot.fk(pin.integrate(robot.model, q, velocity), frame)
    linear = (after[:3, 3] - before[:3, 3]) / (2 * step)
    spin = (after[:3, :3] @ before[:3, :3].T - before[:3, :3] @ after[:3, :3].T) / 2 / (2 * step)
    return np.array([*linear, spin[2, 1], spin[0, 2], spin[1, 0]])


@for_all("base", ["fixed", "floating"])
def test_jacobians_agree_with_central_differences(base: str) -> None:
    nao = nk.load_nao("v6", base=base)
    rng = np.random.default_rng(0)
    for q in nao.random(rng, 4):
        if base == "floating":
            q[:7] = pin.integrate(nao.model, q, np.array([*rng.normal(size=6), *np.zeros(25)]))[:7]
        for frame in ("CameraTop_optical_frame", "LArm", "RLeg", "RFinger13_link", "RHipYawPitch", "torso"):
            mixed = nao.jacobian(q, frame, "mixed")
            numeric = np.stack([_twist_by_differences(nao, q, frame, column) for column in range(nao.nv)], axis=1)
            assert np.allclose(mixed, numeric, atol=2e-9)
            T = nao.fk(q, frame)
            R, p = T[:3, :3], T[:3, 3]
            local = nao.jacobian(q, frame, "frame")
            assert np.allclose(R @ local[:3], mixed[:3], atol=1e-14)
            assert np.allclose(R @ local[3:], mixed[3:], atol=1e-14)
            root = nao.jacobian(q, frame, "root")
            # The spatial twist is the velocity of the point of the body that passes through the root's origin.
            assert np.allclose(root[:3], mixed[:3] + np.cross(p, mixed[3:], axis=0).reshape(3, -1), atol=1e-14)
            assert np.allclose(root[3:], mixed[3:], atol=1e-14)


def test_an_unknown_expression_is_refused(nao: nk.NaoModel) -> None:
    with pytest.raises(UnknownName, match=r"unknown expression 'local' \(valid: frame, root, mixed\)"):
        nao.jacobian(nao.neutral(), "LArm", "local")  # type: ignore[arg-type]


def test_the_centre_of_mass_is_the_mean_of_the_links(each_nao: nk.NaoModel) -> None:
    """Summed link by link from the parameters, the trunk included, which Pinocchio leaves out."""
    from nao_kin.robot.nao import nao_parameters

    rows = nao_parameters(each_nao.version).inertials
    for q in each_nao.random(8, 20):
        moment = np.zeros(3)
        for link, row in rows.items():
            moment += row.mass_kg * (each_nao.fk(q, link) @ [*row.com_m, 1.0])[:3]
        placeholder = each_nao.mass - sum(row.mass_kg for row in rows.values())
        assert np.allclose(each_nao.com(q), moment / each_nao.mass, atol=1e-12 + 0.3 * placeholder / each_nao.mass)


@pytest.mark.parametrize("shape", [(), (1,), (4,), (2, 2)])
@pytest.mark.parametrize("root", [0.0, 2.0])
@pytest.mark.parametrize("tip", [0.0, 3.0])
def test_the_centre_of_mass_counts_root_and_tip_by_their_masses(tmp_path, shape, root: float, tip: float) -> None:
    bodies = "".join(
        f'<link name="{name}"><inertial><origin xyz="{centre}"/><mass value="{mass}"/></inertial></link>'
        for name, mass, centre in (("root", root, "0.3 -0.2 0.1"), ("tip", tip, "0 0.5 0"))
    )
    path = tmp_path / "robot.urdf"
    path.write_text(
        f'<robot name="r">{bodies}<joint name="J" type="continuous"><parent link="root"/><child link="tip"/>'
        '<origin xyz="1 0 0"/><axis xyz="0 0 1"/></joint></robot>'
    )
    robot = nk.RobotModel.from_urdf(path)
    q = np.random.default_rng(0).uniform(-3.0, 3.0, (*shape, 1))
    assert robot.mass == root + tip
    if root + tip == 0.0:
        with pytest.raises(BadArgument, match="r has no mass"):
            robot.com(q)
        return
    at_tip = np.concatenate([1.0 - 0.5 * np.sin(q), 0.5 * np.cos(q), np.zeros_like(q)], axis=-1)
    expected = (root * np.array([0.3, -0.2, 0.1]) + tip * at_tip) / (root + tip)
    assert np.allclose(robot.com(q), expected, rtol=0.0, atol=1e-15)


def test_the_centre_of_mass_transforms_with_its_reference(nao: nk.NaoModel) -> None:
    q = nao.random(9)
    T = nao.fk(q, "LLeg")
    assert np.allclose((T @ [*nao.com(q, reference="LLeg"), 1.0])[:3], nao.com(q), atol=1e-15)


def test_a_payload_added_to_the_model_counts() -> None:
    fixed, free = nk.load_nao(), nk.load_nao(base="floating")
    for nao in (fixed, free):
        index = nao.model.getJointId("LWristYaw")
        nao.model.inertias[index] += pin.Inertia(0.5, np.array([0.05, 0.0, 0.0]), np.zeros((3, 3)))
    q = fixed.random(0)
    q_free = free.neutral()
    q_free[7:] = q
    assert fixed.mass == pytest.approx(nk.load_nao().mass + 0.5)
    assert np.allclose(fixed.com(q), free.com(q_free), atol=1e-15)
    assert np.array_equal(pickle.loads(pickle.dumps(fixed)).com(q), fixed.com(q))


def test_violations_of_a_large_batch_are_counted_and_not_all_told(nao: nk.NaoModel) -> None:
    q = np.full((5000, 25), 9.0)
    with pytest.raises(OutsideLimits, match=r"and 124997 more") as caught:
        nao.check_limits(q)
    assert caught.value.count == 125000
    assert len(caught.value.violations) == 2500


def test_a_floating_base_moves_everything(nao: nk.NaoModel) -> None:
    free = nk.load_nao("v6", base="floating")
    assert (free.nq, free.nv, free.nq_base) == (32, 31, 7)
    assert free.joint_names == nao.joint_names
    q = free.random(10)
    assert q.shape == (32,)
    assert np.array_equal(q[:7], [0, 0, 0, 0, 0, 0, 1])
    assert np.allclose(free.fk(q, "LArm"), nao.fk(q[7:], "LArm"), atol=1e-15)
    assert np.allclose(free.com(q), nao.com(q[7:]), atol=1e-15)
    q[:3] = [1.0, 2.0, 3.0]
    q[3:7] = [0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5)]
    turned = np.array([[0.0, -1.0, 0.0, 1.0], [1.0, 0.0, 0.0, 2.0], [0.0, 0.0, 1.0, 3.0], [0.0, 0.0, 0.0, 1.0]])
    assert np.allclose(free.fk(q, "LArm"), turned @ nao.fk(q[7:], "LArm"), atol=1e-15)
    assert np.allclose(free.fk(q, "LArm", reference="torso"), nao.fk(q[7:], "LArm"), atol=1e-15)
    assert np.allclose(free.com(q), (turned @ [*nao.com(q[7:]), 1.0])[:3], atol=1e-14)
    assert free.mass == pytest.approx(nao.mass, rel=1e-15)
    with pytest.raises(BadArgument, match=r"unit quaternion \(x, y, z, w\), got one of norm 1\.1"):
        free.fk([*q[:6], 0.855, *q[7:]])


# --- bad input --------------------------------------------------------------------------------------------------------


@for_all(
    ("call", "message"),
    [
        (lambda n: n.fk(n.neutral(), "LHnd"), r"unknown frame 'LHnd' \(nearest: LHand"),
        (lambda n: n.fk(n.neutral(), ["LArm", "larm2"]), r"unknown frame 'larm2' \(nearest: LArm"),
        (lambda n: n.fk(n.neutral(), "LArm", reference="trunk"), "unknown frame 'trunk'"),
        (lambda n: n.posture("standinit"), r"unknown posture 'standinit' \(nearest: StandInit"),
        (lambda n: n.configuration({"HeadYam": 0.1}), r"unknown joint 'HeadYam' \(nearest: HeadYaw"),
        (lambda n: n.configuration({"HeadYaw": 0.1}, limits="warn"), "unknown limits policy 'warn'"),
        (lambda n: nk.load_nao("v7"), "unknown NAO version 'v7'"),
        (lambda n: nk.load_robot("rome"), r"unknown robot 'rome' \(nearest: romeo"),
    ],
)
def test_unknown_names_are_answered_with_the_nearest_ones(nao: nk.NaoModel, call, message: str) -> None:
    with pytest.raises(UnknownName, match=message):
        call(nao)


@for_all("q", [np.zeros(24), np.zeros((25, 2)), 0.0, []])
def test_a_wrong_shape_is_told_with_the_right_one(nao: nk.NaoModel, q) -> None:
    for method in (nao.fk, nao.com, nao.angles, nao.clamp, nao.check_limits, nao.to_body):
        with pytest.raises(WrongShape, match=r"q must have shape \(\.\.\., 25\), got \("):
            method(q)
    with pytest.raises(WrongShape, match="Body values"):
        nao.from_body(np.zeros(25))


def test_an_unknown_base_is_refused() -> None:
    with pytest.raises(BadArgument, match="base must be 'fixed' or 'floating', got 'free'"):
        nk.load_nao(base="free")  # type: ignore[arg-type]


# Names come from files and callers, and so do line breaks of every kind.
_LINES = "one\ntwo\r\nthree\x0bfour\x85five\u2028six"
_COUPLING = SimpleNamespace(
    primary=_LINES, mimic=_LINES, primary_value=0.1, mimic_value=0.2, expected=0.1, nearest=0.15, index=(0,)
)
_ERRORS = [
    NaoKinError(_LINES),
    UnknownName(_LINES, _LINES, ()),
    UnknownName("joint", _LINES, (_LINES, "HeadYaw"), _LINES),
    UnknownName("joint", "x", (_LINES,)),
    UnknownName("joint", "x", (_LINES, *map(str, range(20)), _LINES)),
    BadArgument(_LINES),
    WrongShape(_LINES, _LINES, _LINES),
    NotFinite(_LINES, (1, 2), math.nan, _LINES),
    errors.NotARotation((0,), 0.1, 0.2),
    errors.ZeroNorm(_LINES, (0,)),
    errors.DegeneratePoints(_LINES),
    OutsideLimits([nk.LimitViolation(_LINES, 2.0, -1.0, 1.0, "rad", (0,), _LINES, 0.5)] * 5),
    CouplingViolated(_LINES, _LINES, 0.1, 0.2, 0.1),
    errors.DisagreeingJoints([_COUPLING, _COUPLING]),
    errors.BadModel(_LINES),
    errors.BadInputFile(_LINES, _LINES, 3, 4),
    errors.MissingExtra(_LINES, _LINES),
    errors.SingularMatrix(_LINES, _LINES, (0,)),
    errors.NoBrowser(_LINES),
    errors.NotABatch(_LINES),
]


def test_no_kind_of_error_was_forgotten() -> None:
    kinds = {kind for kind in vars(errors).values() if isinstance(kind, type) and issubclass(kind, Exception)}
    kinds = {kind for kind in kinds if not issubclass(kind, Warning)}
    assert kinds == {type(error) for error in _ERRORS}


@pytest.mark.parametrize("error", _ERRORS, ids=lambda error: type(error).__name__)
def test_every_error_is_one_line_and_of_one_family(error: NaoKinError) -> None:
    assert isinstance(error, NaoKinError)
    assert len(str(error).splitlines()) == 1
    assert len(str(pickle.loads(pickle.dumps(error))).splitlines()) == 1


def test_a_place_in_a_file_is_named_by_what_is_known_of_it() -> None:
    places = {
        (0, 0): "a: why",
        (3, 0): "a, line 3: why",
        (0, 4): "a, column 4: why",
        (3, 4): "a, line 3, column 4: why",
    }
    assert {place: str(errors.BadInputFile("a", "why", *place)) for place in places} == places


# --- copies, pickles, threads -----------------------------------------------------------------------------------------


def test_a_pickle_lives_in_another_process(tmp_path) -> None:
    nao = nk.load_nao("v4")
    (tmp_path / "nao.pickle").write_bytes(pickle.dumps(nao))
    code = (
        "import pickle, sys; nao = pickle.load(open(sys.argv[1], 'rb')); "
        "print(repr(nao.position(nao.posture('Stand'), 'LArm').tolist()))"
    )
    child = subprocess.run([sys.executable, "-c", code, tmp_path / "nao.pickle"], capture_output=True, text=True)
    assert child.stdout.strip() == repr(nao.position(nao.posture("Stand"), "LArm").tolist()), child.stderr


def test_threads_do_not_disturb_each_other(nao: nk.NaoModel) -> None:
    configurations = nao.random(0, (8, 200))
    expected = [np.stack([nao.fk(row, ["LArm", "RLeg"]) for row in q]) for q in configurations]
    barrier = threading.Barrier(8)

    def work(q: np.ndarray) -> np.ndarray:
        barrier.wait()
        return np.stack([nao.fk(row, ["LArm", "RLeg"]) for row in q])

    with ThreadPoolExecutor(8) as pool:
        for got, wanted in zip(pool.map(work, configurations), expected, strict=True):
            assert np.array_equal(got, wanted)


def test_importing_the_package_loads_nothing_heavy() -> None:
    code = (
        "import sys, nao_kin; nao_kin.rotations; nao_kin.screws.lines; print('pinocchio' in sys.modules); "
        "nao_kin.load_nao(); heavy = {'numba', 'yourdfpy', 'meshcat', 'trimesh', 'scipy', 'rich'}; "
        "print(sorted(heavy & set(sys.modules)))"
    )
    child = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert child.stdout.split("\n")[:2] == ["False", "[]"], child.stderr


def test_importing_the_package_loads_no_module_that_few_calls_need() -> None:
    late = {"numpy.random", "secrets", "concurrent.futures", "logging", "subprocess", "tempfile", "shutil", "difflib"}
    code = (
        "import sys, pinocchio; before = set(sys.modules); import nao_kin; nao_kin.load_nao; "
        f"print(sorted({late!r} & (set(sys.modules) - before)))"
    )
    child = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert child.stdout == "[]\n", child.stderr


# --- limits -----------------------------------------------------------------------------------------------------------


def test_a_joint_outside_its_limits_is_told_with_value_and_limits(nao: nk.NaoModel) -> None:
    with pytest.raises(OutsideLimits, match=r"HeadYaw = 3 not in \[-2\.08567, 2\.08567\] rad") as caught:
        nao.configuration({"HeadYaw": 3.0})
    (violation,) = caught.value.violations
    assert (violation.joint, violation.value, violation.unit) == ("HeadYaw", 3.0, "rad")
    assert violation.excess == pytest.approx(3 - nao.upper[0])
    assert nao.configuration({"HeadYaw": 3.0}, limits="ignore")[0] == 3.0
    assert nao.configuration({"HeadYaw": 3.0}, limits="clamp")[0] == nao.upper[0]


def test_only_named_joints_face_their_limits(nao: nk.NaoModel) -> None:
    """The elbows' range excludes the zero that joints not named stand at."""
    q = nao.configuration({"HeadYaw": 0.3})
    with pytest.raises(OutsideLimits, match="LElbowRoll = 0"):
        nao.check_limits(q)
    assert np.array_equal(nao.configuration({"HeadYaw": 0.3}, limits="clamp"), q)


def test_fk_looks_at_limits_only_when_asked(nao: nk.NaoModel) -> None:
    q = nao.configuration({"LShoulderRoll": 2.0}, limits="ignore")
    nao.fk(q, "LArm")
    nao.fk(q, "LArm", limits="ignore")
    with pytest.raises(OutsideLimits, match="LShoulderRoll = 2"):
        nao.fk(q, "LArm", limits="enforce")
    assert np.array_equal(nao.fk(q, "LArm", limits="clamp"), nao.fk(nao.clamp(q), "LArm"))


def test_the_coupled_table_of_the_head_is_the_published_one(nao: nk.NaoModel) -> None:
    yaw, pitch = math.radians(62.45), math.radians(17.19)
    inside = nao.configuration({"HeadYaw": yaw, "HeadPitch": pitch - 3e-6})
    assert inside.shape == (25,)
    with pytest.raises(OutsideLimits, match=r"HeadPitch = .* at HeadYaw = 1\.08996") as caught:
        nao.configuration({"HeadYaw": yaw, "HeadPitch": pitch + 3e-6})
    assert caught.value.violations[0].upper == pytest.approx(pitch)
    between = nao.configuration({"HeadYaw": math.radians(20), "HeadPitch": 0.5}, limits="clamp")
    expected = 29.51 + (24.18 - 29.51) * 20 / 27.85
    assert between[nao.joint_names.index("HeadPitch")] == pytest.approx(math.radians(expected))


@given(st.lists(st.floats(-4, 4), min_size=25, max_size=25))
def test_clamping_lands_inside_and_leaves_what_is_inside(values: list[float]) -> None:
    nao = _NAO
    q = nao.clamp(values)
    assert nao.limit_violations(q) == ()
    assert np.array_equal(nao.clamp(q), q)
    touched = {violation.joint for violation in nao.limit_violations(values)}
    for index, name in enumerate(nao.joint_names):
        if name not in touched and name not in ("HeadPitch", "LAnkleRoll", "RAnkleRoll"):
            assert q[index] == pytest.approx(values[index], abs=1e-6)


_NAO = nk.load_nao()


def test_reasons_of_numpy_and_names_of_files_are_cut_and_show_no_control_characters(nao: nk.NaoModel) -> None:
    long, escapes = "L" * 100_000, "a\x00b\x1b[31m\u202e.toml"
    for call in (
        lambda: nk.rotations.random_rotation(rng=long),  # type: ignore[arg-type]
        lambda: nao.random(rng=long),  # type: ignore[arg-type]
        lambda: nk.load_nao(offsets=long),
        lambda: nk.motion.read_motion("L " * 50_000),
        lambda: nk.load_nao(offsets=escapes),
        lambda: nao.fk(nao.neutral(), escapes),
    ):
        with pytest.raises(nk.NaoKinError) as caught:
            call()
        assert len(str(caught.value)) < 2100
        assert str(caught.value).isprintable()
    with pytest.raises(nk.NaoKinError, match=r"a\\x00b\\x1b\[31m\\u202e\.toml: cannot be read"):
        nk.load_nao(offsets=escapes)


def test_missing_values_of_the_body_order_are_filled(nao: nk.NaoModel) -> None:
    body = nao.to_body(nao.posture("Stand"))
    body[nao.body_order.index("LKneePitch")] = np.nan
    expected = nao.posture("Stand")
    for value in (0.25, "Crouch"):
        knee = value if value == 0.25 else nao.angles(nao.posture("Crouch"))["LKneePitch"]
        expected[nao.joint_names.index("LKneePitch")] = knee
        assert np.array_equal(nao.from_body(body, missing=value), expected)


@for_all(("hips", "value"), [("average", -0.25), ("left", -0.2), ("right", -0.3)])
def test_a_motor_of_two_joints_has_the_value_that_is_asked_for(nao: nk.NaoModel, hips: Any, value: float) -> None:
    found = nao.motor_values({"LHipYawPitch": np.array([-0.2]), "RHipYawPitch": np.array([-0.3])}, hips=hips)
    assert found["LHipYawPitch"] == pytest.approx(value)
    assert list(found) == ["LHipYawPitch"]


def test_a_violation_says_where_it_is_if_asked(nao: nk.NaoModel) -> None:
    q = np.tile(nao.posture("Stand"), (3, 1))
    q[2, 0] = 3.0
    (found,) = nao.limit_violations(q)
    assert found.describe() == f"{found.describe(index=False)} (configuration 2)"
