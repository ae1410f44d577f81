"""The batch kernels agree with Pinocchio for every robot, frame and query, and give the same bits in any batch."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, strategies as st
from loops import EACH_VERSION, full
from made_up_robots import J, made_up

import nao_kin as nk
from nao_kin.errors import NaoKinError
from nao_kin.rotations import matrix_from_quat, matrix_from_rpy, quat_from_matrix

EXPRESSIONS = {
    "frame": pin.ReferenceFrame.LOCAL,
    "root": pin.ReferenceFrame.WORLD,
    "mixed": pin.ReferenceFrame.LOCAL_WORLD_ALIGNED,
}
each_version = pytest.mark.parametrize("version", EACH_VERSION)
# Full tiles, a part of one, and one row; in double precision a tile holds 16 configurations.
COUNTS = (37, 1)


def configurations(robot: nk.RobotModel, count: int, seed: int = 0) -> np.ndarray:
    """Random configurations inside and outside of the limits, a floating base anywhere."""
    rng = np.random.default_rng(seed)
    q = robot.random(rng, count)
    joints = q[:, robot.nq_base :]
    joints[::3] = rng.uniform(-6.2, 6.2, joints[::3].shape)
    if robot.base == "floating":
        q[:, :3] = rng.uniform(-2, 2, (count, 3))
        q[:, 3:7] = rng.normal(size=(count, 4))
        q[:, 3:7] /= np.linalg.norm(q[:, 3:7], axis=1)[:, None]
    return q


def close(ours: np.ndarray, expected: np.ndarray, tolerance: float) -> None:
    """Check equality up to the tolerance, relative to the largest number if that is above one."""
    assert ours.shape == expected.shape
    assert np.abs(ours - expected).max(initial=0.0) <= tolerance * max(1.0, np.abs(expected).max(initial=0.0))


def check_against_pinocchio(robot: nk.RobotModel, count: int, tolerance: float = 1e-12) -> None:
    """Every frame and every question, from the kernels on one thread."""
    q = configurations(robot, count)
    rng = np.random.default_rng(1)
    v, a = rng.normal(size=(count, robot.nv)), rng.normal(size=(count, robot.nv))
    model, data = robot.model, robot.model.createData()
    frames = list(robot.frame_table)
    ids = robot.frame_ids(frames)
    poses = robot.fk(q, frames, threads=1)
    chosen = list(dict.fromkeys((frames[-1], frames[len(frames) // 2], frames[0])))
    jacobians = {(f, e): robot.jacobian(q, f, e, threads=1) for f in chosen for e in EXPRESSIONS}
    twists = {e: robot.velocity(q, v, chosen, e, threads=1) for e in EXPRESSIONS}
    rates = {e: robot.acceleration(q, v, a, chosen, e, threads=1) for e in EXPRESSIONS}
    places = [robot.frame_ids([frame])[0] for frame in chosen]
    expected_poses = np.empty_like(poses)
    expected_twists = {e: np.empty_like(twists[e]) for e in EXPRESSIONS}
    expected_rates = {e: np.empty_like(rates[e]) for e in EXPRESSIONS}
    for i in range(count):
        pin.forwardKinematics(model, data, q[i], v[i], a[i])
        pin.updateFramePlacements(model, data)
        expected_poses[i] = [data.oMf[frame_id].homogeneous for frame_id in ids]
        for e, expression in EXPRESSIONS.items():
            rate = pin.getFrameClassicalAcceleration if e == "mixed" else pin.getFrameAcceleration
            expected_twists[e][i] = [pin.getFrameVelocity(model, data, k, expression).vector for k in places]
            expected_rates[e][i] = [rate(model, data, k, expression).vector for k in places]
    close(poses, expected_poses, tolerance)
    for e, expression in EXPRESSIONS.items():
        close(twists[e], expected_twists[e], tolerance)
        close(rates[e], expected_rates[e], tolerance)
        for frame, k in zip(chosen, places, strict=True):
            expected = [pin.computeFrameJacobian(model, data, row, k, expression) for row in q]
            close(jacobians[frame, e], np.reshape(expected, (count, 6, robot.nv)), tolerance)
    reference = frames[-1]
    if robot.mass > 0.0:
        # One row at a time, Pinocchio answers.
        close(robot.com(q, threads=1), np.array([robot.com(row) for row in q]), tolerance)
        expected = np.array([robot.com(row, reference=reference) for row in q])
        close(robot.com(q, reference=reference, threads=1), expected, tolerance)
        close(robot.com_jacobian(q, threads=1), np.array([robot.com_jacobian(row) for row in q]), tolerance)
    for reference in chosen:
        expected = np.array([robot.fk(row, frames, reference=reference) for row in q])
        close(robot.fk(q, frames, reference=reference, threads=1), expected, tolerance)
        for e in EXPRESSIONS:
            expected = np.array([robot.jacobian(row, chosen[0], e, reference=reference) for row in q])
            close(robot.jacobian(q, chosen[0], e, reference=reference, threads=1), expected, tolerance)


@each_version
@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("base", ["fixed", "floating"])
def test_the_kernels_agree_with_pinocchio_on_every_version(version: str, base: str, count: int) -> None:
    check_against_pinocchio(nk.load_nao(version, base=base), count)  # type: ignore[arg-type]


@pytest.mark.parametrize("name", ["romeo", "panda", "double_pendulum", *full("icub", "tiago", "talos")])
def test_the_kernels_agree_with_pinocchio_on_other_robots(name: str) -> None:
    pytest.importorskip("cmeel")
    try:
        robot = nk.load_robot(name)
    except NaoKinError as error:
        pytest.skip(str(error))
    check_against_pinocchio(robot, 17)


def test_every_kind_of_joint_is_known(tmp_path: Path) -> None:
    robot = made_up(
        tmp_path,
        J("a", axis=(0, 0.6, 0.8), xyz=(0.1, 0.2, 0.3), rpy=(0.3, -0.4, 0.5)),
        J("b", axis=(-1, 0, 0), xyz=(0.1, 0, 0)),
        J("c", axis=(0.36, 0.48, -0.8), kind="prismatic", rpy=(0, 1.5707963, 0), limits=(-1, 2)),
        J("d", axis=(0, -1, 0), follows=("a", -2.5, 0.3)),
        J("e", axis=(0, 0, -1), kind="prismatic", follows=("c", 0.5, -0.1)),
        J("f", axis=(1, 0, 0), follows=("c", 3.0, 0.2), parent="b"),
        J("g", axis=(0, 1, 0), kind="continuous", parent="base", rpy=(3.1415926, 0, 0)),
        J("h", kind="fixed", parent="g", xyz=(0, 0, 1), rpy=(0.1, 0.2, 0.3)),
        J("i", axis=(0.6, 0, 0.8), kind="prismatic", parent="h"),
    )
    check_against_pinocchio(robot, 37)


@pytest.mark.parametrize("base", ["fixed", "floating"])
def test_a_robot_of_one_joint_is_enough(tmp_path: Path, base: str) -> None:
    check_against_pinocchio(made_up(tmp_path, J("a", axis=(0.6, 0.8, 0), xyz=(1, 2, 3)), base=base), 37)


AXES = st.sampled_from([(1, 0, 0), (0, 1, 0), (0, 0, 1), (-1, 0, 0), (0, -1, 0), (0.6, 0, -0.8), (0.36, 0.48, 0.8)])
ANGLES = st.sampled_from([0.0, 0.0, 1.5707963267948966, 3.141592653589793, -0.7, 2.1])
LENGTHS = st.sampled_from([0.0, 0.0, 0.1, -0.5])


@st.composite
def robots(draw: st.DrawFn) -> tuple[tuple[J, ...], str]:
    """Trees of up to eight joints that hang on any earlier one, some following another one."""
    joints: list[J] = []
    for k in range(draw(st.integers(1, 8))):
        parent = draw(st.sampled_from(["base", *(joint.name for joint in joints)]))
        kind = draw(st.sampled_from(["revolute", "revolute", "prismatic", "fixed"]))
        drivers = [joint.name for joint in joints if joint.kind != "fixed" and joint.follows is None]
        follows = None
        if kind != "fixed" and drivers and draw(st.booleans()):
            follows = (draw(st.sampled_from(drivers)), draw(st.sampled_from([1.0, -1.0, 0.5])), draw(LENGTHS))
        joints.append(
            J(
                f"j{k}",
                axis=draw(AXES),
                xyz=(draw(LENGTHS), draw(LENGTHS), draw(LENGTHS)),
                rpy=(draw(ANGLES), draw(ANGLES), draw(ANGLES)),
                kind=kind,
                parent=parent,
                follows=follows,
            )
        )
    return tuple(joints), draw(st.sampled_from(["fixed", "floating"]))


@given(made=robots())
def test_the_kernels_agree_with_pinocchio_on_robots_at_random(
    made: tuple[tuple[J, ...], str], tmp_path_factory: pytest.TempPathFactory
) -> None:
    joints, base = made
    if all(joint.kind == "fixed" for joint in joints) and base == "fixed":
        return  # nothing moves: nq is zero
    check_against_pinocchio(made_up(tmp_path_factory.mktemp("robot"), *joints, base=base), 18)


# --- forms ------------------------------------------------------------------------------------------------------------


def test_compact_poses_are_the_matrices(nao: nk.NaoModel) -> None:
    q = configurations(nao, 500)
    for frame in ("LArm", ["Head", "RLeg", "CameraTop"]):
        T = nao.fk(q, frame, threads=1)
        compact = nao.fk(q, frame, as_="quaternion", threads=1)
        assert compact.shape == (*T.shape[:-2], 7)
        np.testing.assert_allclose(compact[..., :3], T[..., :3, 3], rtol=0, atol=1e-15)
        np.testing.assert_allclose(matrix_from_quat(compact[..., 3:]), T[..., :3, :3], rtol=0, atol=2e-15)
        np.testing.assert_allclose(compact[..., 3:], quat_from_matrix(T[..., :3, :3]), rtol=0, atol=2e-15)
        compact = nao.fk(q, frame, as_="rpy", threads=1)
        assert compact.shape == (*T.shape[:-2], 6)
        np.testing.assert_allclose(compact[..., :3], T[..., :3, 3], rtol=0, atol=1e-15)
        np.testing.assert_allclose(matrix_from_rpy(compact[..., 3:]), T[..., :3, :3], rtol=0, atol=2e-15)
        assert (np.abs(compact[..., 4]) <= np.pi / 2).all()
        np.testing.assert_allclose(nao.rotation(q, frame, threads=1), T[..., :3, :3], rtol=0, atol=1e-15)
        np.testing.assert_allclose(nao.position(q, frame, threads=1), T[..., :3, 3], rtol=0, atol=1e-15)


@pytest.mark.parametrize("as_", ["quaternion", "rpy"])
def test_compact_poses_hold_at_every_half_turn_and_lock(tmp_path: Path, as_: str) -> None:
    robot = made_up(tmp_path, J("a", axis=(1, 0, 0)), J("b", axis=(0, 1, 0)), J("c", axis=(0, 0, 1)))
    near = np.array([0.0, 1e-12, -1e-9, 1e-7, -1e-3])
    turns = (np.pi / 2 * np.arange(-3, 4)[:, None] + near).reshape(-1)
    q = np.stack(np.meshgrid(turns, turns[::3], turns[::2], indexing="ij"), axis=-1)
    compact, T = robot.fk(q, "c_l", as_=as_, threads=1), robot.fk(q, "c_l", threads=1)
    R = matrix_from_quat(compact[..., 3:]) if as_ == "quaternion" else matrix_from_rpy(compact[..., 3:])
    np.testing.assert_allclose(R, T[..., :3, :3], rtol=0, atol=2e-15)
    if as_ == "quaternion":  # canonical: the first part that is not zero is positive
        first = np.take_along_axis(compact[..., 3:], (compact[..., 3:] != 0).argmax(-1)[..., None], -1)
        assert (first > 0).all()


def test_exact_half_turns_have_the_canonical_sign(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("a"), base="floating")
    parts = (-0.8, -0.6, 0.0, 0.6, 0.8)
    axes = np.array([[i, j, k] for i in parts for j in parts for k in parts])
    axes = np.concatenate([np.eye(3), -np.eye(3), axes[np.abs((axes**2).sum(-1) - 1.0) < 1e-15]])
    q = np.tile(robot.neutral(), (len(axes), 1))
    q[:, 3:6], q[:, 6] = axes, 0.0  # the base as (x, y, z, w)
    q = np.tile(q, (20, 1))
    quat = robot.fk(q, "base", as_="quaternion", threads=1)[:, 3:]
    first = np.take_along_axis(axes, (axes != 0).argmax(-1)[:, None], -1)
    expected = np.concatenate([np.zeros((len(axes), 1)), axes * np.sign(first)], axis=-1)
    np.testing.assert_allclose(quat, np.tile(expected, (20, 1)), rtol=0, atol=2e-16)


# --- sine and cosine --------------------------------------------------------------------------------------------------


def sines_and_cosines(robot: nk.RobotModel, x: np.ndarray, dtype: type) -> tuple[np.ndarray, np.ndarray]:
    """Return sine and cosine as the kernels compute them: two entries of a rotation about z."""
    R = robot.rotation(x[:, None], "a_l", dtype=dtype, threads=1)
    return R[:, 1, 0], R[:, 0, 0]


def units(values: np.ndarray, exact: np.ndarray) -> float:
    """The largest error, in units in the last place of the exact value."""
    spacing = np.spacing(np.abs(exact).astype(values.dtype)).astype(np.longdouble)
    return float((np.abs(values.astype(np.longdouble) - exact) / spacing).max())


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_sine_and_cosine_are_right_to_two_units(tmp_path: Path, dtype: type) -> None:
    if np.finfo(np.longdouble).eps > 1e-18:
        pytest.skip("no long double here to compare with")
    robot = made_up(tmp_path, J("a", axis=(0, 0, 1), kind="continuous"))
    quarters = np.arange(-4, 5) * (np.pi / 2)
    beside = [np.nextafter(dtype(x), dtype(side)) for x in quarters for side in (-9, 9)]
    near = [x + d for x in quarters for d in (0.0, 1e-300, 1e-12, -1e-9, 1e-6, -1e-3)]
    tiny = [s * 10.0**-k for k in range(0, 300, 7) for s in (1, -1)]
    x = np.concatenate([np.linspace(-2 * np.pi, 2 * np.pi, 200_001), beside, near, tiny]).astype(dtype)
    if dtype is np.float32:
        x = x[(x == 0) | (np.abs(x) > 1e-36)]
    sine, cosine = sines_and_cosines(robot, x, dtype)
    assert sine.dtype == cosine.dtype == dtype
    exact = x.astype(np.longdouble)
    keep = x != 0
    assert units(sine[keep], np.sin(exact[keep])) <= 2.0
    assert units(cosine, np.cos(exact)) <= 2.0


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.filterwarnings("ignore::nao_kin.errors.DegreesWarning")
def test_every_finite_angle_has_its_sine(tmp_path: Path, dtype: type) -> None:
    robot = made_up(tmp_path, J("a", axis=(0, 0, 1), kind="continuous"))
    rng = np.random.default_rng(0)
    largest = 300 if dtype is np.float64 else 37
    x = (rng.uniform(-1, 1, 4000) * 10.0 ** rng.uniform(0, largest, 4000)).astype(dtype)
    x[::50] = rng.uniform(-3, 3, 80)  # near and far angles in one tile
    sine, cosine = sines_and_cosines(robot, x, dtype)
    tolerance = 3e-16 if dtype is np.float64 else 2e-7
    np.testing.assert_allclose(sine, np.sin(x.astype(np.float64)), rtol=0, atol=tolerance)
    np.testing.assert_allclose(cosine, np.cos(x.astype(np.float64)), rtol=0, atol=tolerance)


# --- precision and bits -----------------------------------------------------------------------------------------------


@each_version
@pytest.mark.parametrize("base", ["fixed", "floating"])
def test_single_precision_is_right_to_two_millionths(version: str, base: str) -> None:
    nao = nk.load_nao(version, base=base)  # type: ignore[arg-type]
    q = nao.random(0, 300)
    if base == "floating":
        rng = np.random.default_rng(0)
        q[:, :3] = rng.uniform(-1, 1, (300, 3))
        q[:, 3:7] = quat_from_matrix(nk.rotations.exp(rng.normal(size=(300, 3))))[:, [1, 2, 3, 0]]
    for single, double in (
        (nao.fk(q, dtype=np.float32, threads=1), nao.fk(q, threads=1)),
        (nao.jacobian(q, "LLeg", dtype=np.float32, threads=1), nao.jacobian(q, "LLeg", threads=1)),
        (nao.com(q, dtype=np.float32, threads=1), nao.com(q, threads=1)),
        (nao.com_jacobian(q, dtype=np.float32, threads=1), nao.com_jacobian(q, threads=1)),
    ):
        assert single.dtype == np.float32
        np.testing.assert_allclose(single, double, rtol=0, atol=2e-6)
    # The same for configurations that are single precision themselves.
    np.testing.assert_array_equal(
        nao.fk(q.astype(np.float32), "LArm", dtype=np.float32, threads=1),
        nao.fk(q.astype(np.float32).astype(np.float64), "LArm", dtype=np.float32, threads=1),
    )


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_a_configuration_gives_the_same_bits_in_any_batch(nao: nk.NaoModel, dtype: type) -> None:
    q = configurations(nao, 1000)
    questions = {
        "fk": lambda q, **o: nao.fk(q, **o),
        "quaternions": lambda q, **o: nao.fk(q, ["LArm", "RLeg"], as_="quaternion", **o),
        "rpy": lambda q, **o: nao.fk(q, ["LArm", "RLeg"], as_="rpy", **o),
        "relative": lambda q, **o: nao.fk(q, "LArm", reference="CameraTop", **o),
        "position": lambda q, **o: nao.position(q, "LArm", **o),
        "jacobian": lambda q, **o: nao.jacobian(q, "RArm", **o),
        "com": lambda q, **o: nao.com(q, **o),
        "com_jacobian": lambda q, **o: nao.com_jacobian(q, **o),
        "velocity": lambda q, **o: nao.velocity(q, q, "LArm", **o),
        "acceleration": lambda q, **o: nao.acceleration(q, q, q, "LArm", **o),
    }
    for name, ask in questions.items():
        whole = ask(q, dtype=dtype, threads=1)
        for threads in (2, 3, 64):
            np.testing.assert_array_equal(ask(q, dtype=dtype, threads=threads), whole, err_msg=name)
        for cut in (1, 15, 16, 17, 500, 999):
            parts = [ask(part, dtype=dtype, threads=1) for part in (q[:cut], q[cut:])]
            np.testing.assert_array_equal(np.concatenate(parts), whole, err_msg=name)
        np.testing.assert_array_equal(ask(q[7], dtype=dtype, threads=1), whole[7], err_msg=name)


def move_joint(robot: nk.RobotModel) -> None:
    placements = robot.model.jointPlacements
    placements[2] = placements[2] * pin.SE3(np.eye(3), np.array([0.0, 0.5, 0.0]))


def move_frame(robot: nk.RobotModel) -> None:
    robot.model.frames[robot.frame_ids(["tip_l"])[0]].placement.translation = np.array([0.3, 0.2, 0.1])


def change_mass(robot: nk.RobotModel) -> None:
    robot.model.inertias[2].mass = 7.0


def change_first_mass(robot: nk.RobotModel) -> None:
    robot.model.inertias[0].mass = 7.0


def shift_mass(robot: nk.RobotModel) -> None:
    """From one link to another: the total stays."""
    inertias = robot.model.inertias
    inertias[1].mass, inertias[2].mass = inertias[1].mass + 0.25, inertias[2].mass - 0.25


def move_first_mass(robot: nk.RobotModel) -> None:
    robot.model.inertias[1].lever = np.array([0.3, 0.2, 0.1])


def move_last_mass(robot: nk.RobotModel) -> None:
    robot.model.inertias[len(robot.model.inertias) - 1].lever = np.array([0.3, 0.2, 0.1])


@pytest.mark.parametrize(
    "change",
    [move_joint, move_frame, change_mass, change_first_mass, shift_mass, move_first_mass, move_last_mass],
    ids=lambda change: change.__name__,
)
def test_changed_numbers_of_the_model_are_seen(tmp_path: Path, change: Callable[[nk.RobotModel], None]) -> None:
    robot = made_up(tmp_path, J("a"), J("b", axis=(0, 1, 0)), J("tip", kind="fixed", xyz=(0.1, 0, 0)))
    q = configurations(robot, 5)

    def answers(threads: int | None) -> list[np.ndarray]:
        return [
            robot.fk(q, threads=threads),
            robot.fk(q, "tip_l", reference="b_l", threads=threads),
            robot.com(q, threads=threads),
            robot.com_jacobian(q, threads=threads),
        ]

    before = answers(1)
    change(robot)
    now, expected = answers(1), answers(None)
    assert any(np.abs(a - b).max() > 1e-3 for a, b in zip(before, expected, strict=True))
    for ours, theirs in zip(now, expected, strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-14)


def test_a_robot_that_was_pickled_answers_as_before(nao: nk.NaoModel) -> None:
    import pickle

    q = configurations(nao, 40)
    again = pickle.loads(pickle.dumps(nao))
    np.testing.assert_array_equal(again.fk(q, threads=1), nao.fk(q, threads=1))
