"""Directions of a person's limbs become joint values: exact inside the limits, nearest outside of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from loops import EACH_VERSION, full
from scipy.optimize import minimize

import nao_kin as nk
from nao_kin._core.arrays import Floats
from nao_kin.imitation import limbs
from nao_kin.imitation.limbs import Clamp, Directions, LimbMap, mirrored
from nao_kin.robot.nao import VERSIONS

SIDES = (("left", "L"), ("right", "R"))
JOINTS = ("ShoulderPitch", "ShoulderRoll", "ElbowYaw", "ElbowRoll", "WristYaw")
FRAMES = {"shoulder": "Shoulder", "elbow": "Elbow", "wrist": "WristYaw", "hip": "HipPitch"}
PARTS = ("torso", "upper_arms", "forearms", "hands", "gaze")
UPPER, FORE, HAND, GAZE = [0, 3], [1, 4], [2, 5], 6
MOVED = {"LShoulderPitch": 0.02, "LShoulderRoll": -0.03, "LElbowYaw": 0.04, "RElbowRoll": -0.01, "HeadYaw": 0.03}


def points_of(robot: nk.RobotModel, q: Floats) -> dict[str, Floats]:
    """The points of the robot itself, named as those of a person."""
    return {
        f"{side}_{name}": robot.fk(q, letter + frame)[:, :3, 3]
        for side, letter in SIDES
        for name, frame in FRAMES.items()
    }


def orientations_of(robot: nk.RobotModel, q: Floats) -> dict[str, Floats]:
    frames = {"left_hand": "LWristYaw", "right_hand": "RWristYaw", "head": "Head"}
    return {name: robot.fk(q, frame)[:, :3, :3] for name, frame in frames.items()}


def columns_of(robot: nk.RobotModel) -> list[int]:
    names = [letter + joint for _, letter in SIDES for joint in JOINTS] + ["HeadYaw", "HeadPitch"]
    return [robot.nq_base + robot.joint_names.index(name) for name in names]


def changed(robot: nk.RobotModel, q: Floats, **values: float) -> Floats:
    """A configuration with other values of some joints, inside the limits or not."""
    q = np.array(q)
    for name, value in values.items():
        q[robot.joint_names.index(name)] = value
    return q


def units(rng: np.random.Generator, *shape: int) -> Floats:
    v = rng.normal(size=(*shape, 3))
    return np.asarray(v / np.linalg.norm(v, axis=-1, keepdims=True))


def angle(a: Floats, b: Floats) -> Floats:
    return np.asarray(2.0 * np.arcsin(np.minimum(0.5 * np.linalg.norm(a - b, axis=-1), 1.0)))


def directions(upper: Floats, fore: Floats, gaze: Floats | None = None, hands: Floats | None = None) -> Directions:
    n = len(upper)
    gaze = np.full((n, 3), np.nan) if gaze is None else gaze
    hands = np.full((n, 2, 3, 3), np.nan) if hands is None else hands
    return Directions(np.tile(np.eye(3), (n, 1, 1)), upper, fore, hands, gaze)


def along(start: str, end: str) -> Callable[[nk.RobotModel, Floats], Floats]:
    """The direction from one frame of the robot to another, by forward kinematics."""

    def direction(robot: nk.RobotModel, q: Floats) -> Floats:
        v = robot.fk(q, end)[..., :3, 3] - robot.fk(q, start)[..., :3, 3]
        return np.asarray(v / np.linalg.norm(v, axis=-1, keepdims=True))

    return direction


def gaze_of(robot: nk.RobotModel, q: Floats) -> Floats:
    return np.asarray(robot.fk(q, "Head")[..., :3, 0])


# --- Exact inside the limits.


def check_exact(robot: nk.RobotModel, q: Floats) -> None:
    """The directions of configurations are met, and from a configuration nearby there is no other one."""
    person, used = Directions.of(points_of(robot, q), orientations_of(robot, q)), columns_of(robot)
    assert not person.notes
    solver = LimbMap(robot)
    solved = solver.solve(person)
    assert (solved.codes == Clamp.NONE).all()
    assert solved.errors[:, [*UPPER, *FORE, GAZE]].max() < 1e-9
    assert solved.errors[:, HAND].max() < 1e-6
    assert robot.within_limits(solved.q).all()
    for k in range(0, len(q), 10):
        one = replace(person, **{name: getattr(person, name)[k : k + 1] for name in PARTS})
        near = robot.clamp(q[k] + np.random.default_rng(k).uniform(-0.1, 0.1, robot.nq))
        assert np.abs(solver.solve(one, near).q[0] - q[k])[used].max() < 1e-9
    if robot.parameters.version != "v3.2":  # its shoulders reach beyond the axis of ShoulderPitch: two solutions
        assert np.abs(solved.q - q)[:, used].max() < 1e-9


@pytest.mark.parametrize("version", VERSIONS)
def test_the_points_of_a_nao_give_back_its_arms_and_head(version: str) -> None:
    robot = nk.load_nao(version)
    check_exact(robot, robot.random(1, 200))


@pytest.mark.parametrize("version", full(*VERSIONS))
def test_ten_thousand_configurations_are_given_back(version: str) -> None:
    robot = nk.load_nao(version)
    check_exact(robot, robot.random(2, 10_000))


def test_a_calibrated_robot_gives_back_its_arms_and_head() -> None:
    robot = nk.load_nao().with_offsets(MOVED)
    check_exact(robot, robot.random(3, 100))


def test_a_floating_base_is_no_part_of_the_directions() -> None:
    robot = nk.load_nao(base="floating")
    q = robot.random(4, 50)
    q[:, :7] = 0.3, -2.0, 5.0, 0.5, 0.5, 0.5, 0.5
    solved = LimbMap(robot).solve(Directions.of(points_of(robot, q), orientations_of(robot, q)))
    assert np.abs(solved.q - q)[:, columns_of(robot)].max() < 1e-9


def test_size_place_and_heading_of_the_person_change_nothing(nao: nk.NaoModel) -> None:
    q = nao.random(5, 50)
    R, place = nk.rotations.rot_z(2.0), np.array([7.0, -3.0, 0.4])
    points = {name: 3.7 * p @ R.T + place for name, p in points_of(nao, q).items()}
    turned = {name: R @ each for name, each in orientations_of(nao, q).items()}
    assert np.abs(LimbMap(nao).solve(Directions.of(points, turned)).q - q)[:, columns_of(nao)].max() < 1e-9


def test_a_mirrored_person_is_a_mirrored_configuration(nao: nk.NaoModel) -> None:
    q = nao.random(6, 50)
    used = columns_of(nao)
    seen = Directions.of(*mirrored(points_of(nao, q), orientations_of(nao, q)))
    assert np.abs(LimbMap(nao).solve(seen).q - nao.mirror(q))[:, used].max() < 1e-9


@pytest.mark.full
def test_python_and_the_compiled_kernel_give_the_same_bits(nao: nk.NaoModel, monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(7)
    person = directions(units(rng, 200, 2), units(rng, 200, 2), units(rng, 200))
    solver = LimbMap(nao)
    compiled = solver.solve(person, slack=0.05)
    monkeypatch.setattr(
        limbs, "run_rows", lambda *a, uncompiled, **_: [uncompiled(slice(i, i + 1)) for i in range(200)]
    )
    np.testing.assert_array_equal(solver.solve(person, slack=0.05).q, compiled.q)


# --- Outside of the limits: against SciPy's optimiser.


def least_angle(
    robot: nk.RobotModel,
    q: Floats,
    pair: tuple[str, str],
    made: Callable[[nk.RobotModel, Floats], Floats],
    wanted: Floats,
) -> float:
    """The smallest angle that two joints reach, by a grid and searches from six of its points."""
    at = [robot.joint_names.index(name) for name in pair]
    low, high = robot.lower[at], robot.upper[at]
    tables = [table for table in robot.coupled_limits if (table.of, table.joint) == pair]

    def away(x: Floats) -> Floats:
        values = np.array(np.atleast_2d(x))
        for table in tables:  # the share of the second joint's own range becomes that of its range here
            share = (values[:, 1] - low[1]) / (high[1] - low[1])
            bounds = [np.interp(values[:, 0], table.at, bound) for bound in (table.lower, table.upper)]
            start, end = np.maximum(bounds[0], low[1]), np.minimum(bounds[1], high[1])
            values[:, 1] = start + share * (end - start)
        rows = np.tile(q, (len(values), 1))
        rows[:, at] = values
        return angle(made(robot, rows), wanted)

    grid = np.stack(np.meshgrid(*(np.linspace(*ends, 25) for ends in zip(low, high, strict=True))), -1).reshape(-1, 2)
    angles = away(grid)
    starts = [grid[angles.argmin()], *grid[np.random.default_rng(0).choice(len(grid), 5)]]
    bounds = list(zip(low, high, strict=True))
    found = [minimize(lambda x: away(x)[0], start, method="L-BFGS-B", bounds=bounds).fun for start in starts]
    return float(min(found))


def check_nearest(robot: nk.RobotModel, seed: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    upper, fore, gaze = units(rng, n, 2), units(rng, n, 2), units(rng, n)
    solved = LimbMap(robot).solve(directions(upper, fore, gaze))
    assert robot.within_limits(solved.q).all()
    assert (solved.codes[:, [*UPPER, *FORE, GAZE]] != Clamp.NONE).any(axis=0).all()
    parts: list[tuple[int, tuple[str, str], Any, Floats]] = [(GAZE, ("HeadYaw", "HeadPitch"), gaze_of, gaze)]
    for k, (_, side) in enumerate(SIDES):
        shoulder, elbow = (side + "ShoulderPitch", side + "ShoulderRoll"), (side + "ElbowYaw", side + "ElbowRoll")
        parts.append((UPPER[k], shoulder, along(side + "Shoulder", side + "Elbow"), upper[:, k]))
        parts.append((FORE[k], elbow, along(side + "Elbow", side + "WristYaw"), fore[:, k]))
    for part, pair, made, wanted in parts:
        # The angle that is told is that of forward kinematics, and no other one is smaller.
        np.testing.assert_allclose(angle(made(robot, solved.q), wanted), solved.errors[:, part], atol=1e-9)
        missed = np.flatnonzero(solved.codes[:, part])
        for i in missed[: n // 4]:
            assert solved.errors[i, part] <= least_angle(robot, solved.q[i], pair, made, wanted[i]) + 1e-6


@pytest.mark.parametrize("version", EACH_VERSION)
def test_no_direction_is_nearer_than_the_one_taken(version: str) -> None:
    check_nearest(nk.load_nao(version), 8, 10)


@pytest.mark.parametrize("version", full("v3.2", "v6"))
def test_no_direction_is_nearer_than_those_of_many(version: str) -> None:
    check_nearest(nk.load_nao(version), 9, 60)


@pytest.mark.parametrize("version", ["v3.2", "v6"])
def test_no_direction_of_the_arm_or_head_on_a_grid_is_nearer(version: str) -> None:
    robot, rng = nk.load_nao(version), np.random.default_rng(10)
    upper, fore, gaze = units(rng, 200, 2), units(rng, 200, 2), units(rng, 200)
    solved = LimbMap(robot).solve(directions(upper, fore, gaze))
    q = robot.random(11, 3000)
    for k, (_, side) in enumerate(SIDES):
        reached = along(side + "Shoulder", side + "Elbow")(robot, q)
        assert (solved.errors[:, UPPER[k]] <= angle(reached[:, None], upper[:, k]).min(axis=0) + 1e-9).all()
    assert (solved.errors[:, GAZE] <= angle(gaze_of(robot, q)[:, None], gaze).min(axis=0) + 1e-9).all()


@pytest.mark.parametrize("count", [150, *full(5000)])
def test_ranges_of_any_two_joints_give_their_nearest_direction(count: int) -> None:
    rng = np.random.default_rng(15)
    for k in range(count):
        low, width = rng.uniform(-3.1, 1.0), rng.uniform(0.1, 4.2)
        south, height = rng.uniform(-1.5, 2.5), rng.uniform(0.05, 1.5)  # many go over a pole
        patch = limbs.Patch(low, low + width, south, south + height)
        wanted = rng.uniform(-np.pi, np.pi), np.arcsin(rng.uniform(-1.0, 1.0)) if k % 5 else 1.5707
        near, slack = (rng.uniform(low, low + width), rng.uniform(south, south + height)), (0.0, 0.03, 0.2)[k % 3]
        x, y = np.linspace(low, low + width, 61)[:, None], np.linspace(south, south + height, 61)
        cosines = np.sin(y) * np.sin(wanted[1]) + np.cos(y) * np.cos(wanted[1]) * np.cos(x - wanted[0])
        for allowed in (0.0, slack):
            found = [limbs.on_patch(patch, wanted, near, allowed, branch) for branch in range(2)]
            found = [each for each in found if each[2] < np.inf] or [limbs.on_patch(patch, wanted, near, allowed, 2)]
            for a, b, angle in found:
                cosine = np.sin(b) * np.sin(wanted[1]) + np.cos(b) * np.cos(wanted[1]) * np.cos(a - wanted[0])
                assert low <= a <= low + width
                assert south <= b <= south + height
                assert abs(np.cos(angle) - cosine) < 1e-12
                assert angle <= np.arccos(cosines.max()) + allowed + 1e-7


def test_slack_costs_at_most_its_angle_and_saves_motion(nao: nk.NaoModel) -> None:
    rng = np.random.default_rng(12)
    # Arms to the side, and almost straight, with noise.
    base = np.array([[[0.1, 1.0, 0.0], [0.1, -1.0, 0.0]]])
    upper, fore = base + rng.normal(0.0, 0.05, (300, 2, 3)), base + rng.normal(0.0, 0.05, (300, 2, 3))
    solver, used = LimbMap(nao), columns_of(nao)
    strict, loose = (solver.solve(directions(upper, fore), slack=slack) for slack in (0.0, 0.1))
    assert (loose.errors[:, UPPER] <= strict.errors[:, UPPER] + 0.1 + 1e-9).all()
    assert (loose.errors[:, UPPER] > strict.errors[:, UPPER] + 0.05).any()
    path, short = (np.abs(np.diff(each.q[:, used], axis=0)).sum() for each in (strict, loose))
    assert short < 0.3 * path
    # The forearms of the same upper arms, each from its own configuration, without slack.
    unknown = np.full_like(upper[:1], np.nan)
    for i in range(0, 300, 10):
        alone = solver.solve(directions(unknown, fore[i : i + 1]), loose.q[i])
        assert (loose.errors[i, FORE] <= alone.errors[0, FORE] + 0.1 + 1e-9).all()


# --- Joints that a direction does not determine.


@pytest.mark.parametrize("version", ["v3.2", "v6"])
@pytest.mark.parametrize("yaw", [-1.3, 0.0, 0.7])
def test_a_straight_arm_keeps_its_elbow_yaw(version: str, yaw: float) -> None:
    robot = nk.load_nao(version)
    near = robot.clamp(changed(robot, robot.neutral(), LElbowYaw=yaw, RElbowYaw=-yaw))
    straight = changed(robot, near, LElbowRoll=0.0, RElbowRoll=0.0)  # beyond the limits
    person = Directions.of(points_of(robot, straight[None]))
    solved = LimbMap(robot).solve(person, near)
    yaws = [robot.joint_names.index(side + "ElbowYaw") for _, side in SIDES]
    np.testing.assert_allclose(solved.q[0, yaws], [yaw, -yaw], atol=1e-9)
    assert (solved.codes[0, FORE] == Clamp.SECOND).all()
    np.testing.assert_allclose(solved.errors[0, FORE], robot.lower[robot.joint_names.index("RElbowRoll")], atol=1e-9)


@pytest.mark.parametrize("version", ["v3.2", "v6"])
@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("pitch", [-1.1, 0.4])
def test_upper_arms_along_the_axis_of_the_shoulder_keep_its_pitch(version: str, sign: float, pitch: float) -> None:
    robot = nk.load_nao(version)
    near = robot.clamp(changed(robot, robot.neutral(), LShoulderPitch=pitch, RShoulderPitch=pitch))
    aside = np.array([[[0.0, sign, 0.0], [0.0, sign, 0.0]]])
    solved = LimbMap(robot).solve(directions(aside, np.full((1, 2, 3), np.nan)), near)
    pitches = [robot.joint_names.index(side + "ShoulderPitch") for _, side in SIDES]
    np.testing.assert_allclose(solved.q[0, pitches], pitch, atol=1e-9)
    outer = solved.errors[0, UPPER[0 if sign > 0.0 else 1]]  # of the arm on this side
    assert outer < (1e-9 if version == "v3.2" else 0.11)
    # Beside the axis by rounding, nothing turns either.
    beside = aside + np.array([0.3, 0.0, -0.9]) * 1e-14
    again = LimbMap(robot).solve(directions(beside, np.full((1, 2, 3), np.nan)), near)
    assert np.abs(again.q - solved.q).max() < 1e-6


def test_a_slow_swing_through_ordinary_directions_never_jumps(nao: nk.NaoModel) -> None:
    t = np.linspace(0.0, 2.0 * np.pi, 400)
    used = columns_of(nao)
    q = np.tile(nao.posture("StandInit"), (400, 1))
    swing = (0.6, 0.3, 0.8, 0.4, 0.7)
    for _, side in SIDES:
        for k, joint in enumerate(JOINTS):
            q[:, nao.joint_names.index(side + joint)] += swing[k] * np.sin((k + 1) * t)
    q = nao.clamp(q)
    solved = LimbMap(nao).solve(Directions.of(points_of(nao, q), orientations_of(nao, q)), q[0])
    assert np.abs(solved.q - q)[:, used].max() < 1e-9


# --- Unknown directions, wrists and faces.


def test_unknown_directions_keep_the_joints_of_the_frame_before(nao: nk.NaoModel) -> None:
    q = nao.random(13, 4)
    person = Directions.of(points_of(nao, q), orientations_of(nao, q))
    upper, fore, gaze, hands = (
        np.array(each) for each in (person.upper_arms, person.forearms, person.gaze, person.hands)
    )
    upper[1, 0], fore[1, 1], gaze[1], hands[1] = np.nan, np.nan, np.nan, np.nan
    solved = LimbMap(nao).solve(directions(upper, fore, gaze, hands))
    assert np.isfinite(solved.q).all()
    unknown = np.isnan(solved.errors)
    np.testing.assert_array_equal(unknown, solved.codes == Clamp.UNKNOWN)
    np.testing.assert_array_equal(np.flatnonzero(unknown[1]), [0, 2, 4, 5, 6])
    assert not unknown[[0, 2, 3]].any()
    kept = (
        "LShoulderPitch",
        "LShoulderRoll",
        "RElbowYaw",
        "RElbowRoll",
        "LWristYaw",
        "RWristYaw",
        "HeadYaw",
        "HeadPitch",
    )
    for name in kept:
        k = nao.joint_names.index(name)
        assert solved.q[1, k] == solved.q[0, k]
    # The other arm's parts follow, and so does the frame after.
    assert np.abs(solved.q[1] - q[1])[nao.joint_names.index("RShoulderPitch")] < 1e-9
    assert np.abs(solved.q[2] - q[2])[columns_of(nao)].max() < 1e-9
    nothing = LimbMap(nao).solve(directions(*(np.full((2, 2, 3), np.nan),) * 2), q[0])
    np.testing.assert_allclose(nothing.q, q[:2] * 0.0 + q[0], atol=1e-15)


def test_the_wrist_turns_as_far_as_it_can(nao: nk.NaoModel) -> None:
    q = np.tile(nao.posture("StandInit"), (5, 1))
    k = nao.joint_names.index("LWristYaw")
    q[:, k] = -1.5, 0.0, 1.5, 2.0, -2.5  # the last two are beyond the limits of ±1.82 rad
    turned = orientations_of(nao, q)
    bent = {"left_hand": turned["left_hand"] @ nk.rotations.rot_y(0.6), "right_hand": turned["right_hand"]}
    for orientations, missed in ((turned, 0.0), (bent, 0.6)):
        solved = LimbMap(nao).solve(Directions.of(points_of(nao, q), orientations))
        np.testing.assert_allclose(solved.q[:, k], np.clip(q[:, k], nao.lower[k], nao.upper[k]), atol=1e-9)
        np.testing.assert_array_equal(solved.codes[:, HAND[0]], [0, 0, 0, Clamp.FIRST, Clamp.FIRST])
        np.testing.assert_allclose(solved.errors[:3, HAND[0]], missed, atol=1e-6)
        assert (solved.errors[3:, HAND[0]] > missed + 0.01).all()


def test_a_face_shows_the_gaze_by_its_points(nao: nk.NaoModel) -> None:
    q = nao.random(14, 30)
    T, points = nao.fk(q, "Head"), points_of(nao, q)
    face = {
        "left_eye": (8, 3, 2),
        "right_eye": (8, -3, 2),
        "left_ear": (0, 7, 0),
        "right_ear": (0, -7, 0),
        "nose": (10, 0, -2),
    }
    points |= {name: T[:, :3, 3] + T[:, :3, :3] @ (0.01 * np.array(place)) for name, place in face.items()}
    solved = LimbMap(nao).solve(Directions.of(points))
    assert np.abs(solved.q - q)[:, columns_of(nao)[-2:]].max() < 1e-9
    assert np.isnan(LimbMap(nao).solve(Directions.of(points_of(nao, q))).errors[:, GAZE]).all()
    # Without ears, ahead is perpendicular to the neck.
    bare = {name: points[name] for name in points_of(nao, q)}
    bare |= {
        name: T[:, :3, 3] + T[:, :3, :3] @ np.array(place)
        for name, place in {"neck": (0, 0, -0.1), "head": (0, 0, 0.1), "nose": (0.08, 0, 0.05)}.items()
    }
    assert np.abs(LimbMap(nao).solve(Directions.of(bare)).q - q)[:, columns_of(nao)[-2:]].max() < 1e-9


# --- The torso.


@pytest.mark.parametrize("missing", ["left_shoulder", "right_shoulder", "left_hip", "right_hip"])
def test_the_torso_needs_three_of_its_four_points(nao: nk.NaoModel, missing: str) -> None:
    points = points_of(nao, np.tile(nao.posture("StandInit"), (3, 1)))
    points[missing] = np.array(points[missing])
    points[missing][1] = np.nan
    person = Directions.of(points)
    np.testing.assert_allclose(person.torso, np.tile(np.eye(3), (3, 1, 1)), atol=1e-12)
    assert person.notes == (f"1 frames lack a {missing.split('_')[1]}, which is placed beside the other one",)


def test_a_trunk_without_hips_is_vertical_and_said_so(nao: nk.NaoModel) -> None:
    points = points_of(nao, np.tile(nao.posture("StandInit"), (3, 1)))
    for side in ("left", "right"):
        points[f"{side}_hip"] = np.full((3, 3), np.nan)
    person = Directions.of(points)
    np.testing.assert_allclose(person.torso, np.tile(np.eye(3), (3, 1, 1)), atol=1e-12)
    assert person.notes == ("3 frames lack both hips: their trunk is taken as vertical",)
    pelvis = Directions.of(points | {"pelvis": np.tile([-0.1, 0.0, -0.085], (3, 1))})
    assert not pelvis.notes
    assert pelvis.torso[0, 0, 2] > 0.1


def test_equal_points_have_no_direction(nao: nk.NaoModel) -> None:
    person = Directions.of({name: np.zeros((2, 3)) for name in points_of(nao, nao.random(0, 2))})
    assert np.isnan(person.torso).all()
    solved = LimbMap(nao).solve(person, nao.posture("Crouch"))
    assert (solved.codes == Clamp.UNKNOWN).all()
    np.testing.assert_allclose(solved.q, np.tile(nao.posture("Crouch"), (2, 1)), atol=1e-15)


def test_wrong_input_is_refused(nao: nk.NaoModel) -> None:
    with pytest.raises(nk.errors.WrongShape, match="near"):
        LimbMap(nao).solve(directions(np.zeros((4, 2, 3)), np.zeros((4, 2, 3))), np.zeros(3))
