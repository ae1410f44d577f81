"""What a robot is doing, from logs of a simulated NAO whose truth is known: noise, bias, delay, gaps, falls, lifts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial.transform import Rotation

import nao_kin as nk
from nao_kin.errors import BadArgument, NaoKinError, WrongShape

pytest.importorskip("mujoco")
import simulated_robot as simulated
from simulated_robot import LYING, Recording, Truth

ROW = 0.01  # time between rows of these logs [s]
# Errors of sensors that `state` can do nothing about.
NONE: dict[str, object] = {"every": ROW, "backlash": 0.0, "acceleration_bias": 0.0}


@pytest.fixture(scope="module")
def life(nao: nk.NaoModel) -> Truth:
    """31 s: a walk, falls to the front, the left and on the back, and carrying, with standing between them."""
    return simulated.life(nao).at(slice(None, None, 5))


def sensors(nao: nk.NaoModel, truth: Truth, seed: int = 0, **noise: object) -> Recording:
    return simulated.recorded(nao, truth, np.random.default_rng(seed), **(NONE | noise))


def walked(nao: nk.NaoModel, steps: int, x: float, y: float, turn: float) -> Truth:
    """Return a walk between standing, by the way of a step."""
    scene = simulated.Scene(nao).hold(1.5).walk(simulated.walk(nao, steps, x, y, turn))
    return scene.truth().at(slice(None, None, 5))


@pytest.fixture(scope="module")
def ahead(nao: nk.NaoModel) -> Truth:
    """Six steps ahead."""
    return walked(nao, 6, 0.04, 0.0, 0.0)


def found_in(nao: nk.NaoModel, log: Recording, **more: object) -> nk.world.State:
    given = {"forces": log.forces, "accelerometer": log.accelerometer, "gyro": log.gyro} | more
    return nk.world.state(nao, log.q, times=log.times, **{k: v for k, v in given.items() if v is not None})


@dataclass(frozen=True)
class Errors:
    """Errors of a state: tilt on the ground [°], height [m], wrong supports of single ones, and times [s]."""

    tilt: float
    height: float
    support: float
    false_lying: float
    false_lifted: float
    missed_lying: float
    missed_lift: float
    left_out: float

    @classmethod
    def of(cls, found: nk.world.State, truth: Truth) -> Errors:
        ground = np.isin(truth.doing, ("standing", "walking"))
        cosine = np.einsum("ni,ni->n", found.up, truth.T[:, 2, :3])
        tilt = np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))
        used = found.valid & ground
        single = used & (truth.share.max(axis=1) > 0.6)
        lying, down = found.doing == "lying", np.isin(truth.doing, LYING)
        x, y = np.nan_to_num(found.up[:, :2]).T
        side = np.where(np.abs(x) >= np.abs(y), np.where(x < 0.0, "front", "back"), np.where(y < 0.0, "left", "right"))
        upside = np.arccos(np.clip(truth.T[:, 2, 2], -1.0, 1.0)) < np.radians(25.0)
        lifted = np.isin(found.doing, ("lifted", "sitting"))
        return cls(
            tilt=float(np.sqrt(np.nanmean(tilt[ground] ** 2))),
            height=float(np.sqrt(np.mean((found.T_world_base[used, 2, 3] - truth.T[used, 2, 3]) ** 2))),
            support=float(np.mean(found.odometry.support[single] != truth.share.argmax(axis=1)[single])),
            false_lying=ROW * float((lying & upside).sum()),
            false_lifted=ROW * float((lifted & ~np.isin(truth.doing, ("carried", ""))).sum()),
            missed_lying=ROW * float((down & ~(lying & (side == truth.doing))).sum()),
            missed_lift=ROW * float(((truth.doing == "carried") & upside & ~lifted).sum()),
            left_out=float(np.mean(~found.valid[ground])),
        )


# --- The whole of a life, by each kind of sensor.


@pytest.mark.parametrize(
    ("encoder", "delay", "angles", "tilt"), [(0.1, 0, False, 0.7), (0.3, 3, False, 0.8), (0.3, 1, True, 1.0)]
)
def test_walks_falls_and_lifts_are_told_apart(
    nao: nk.NaoModel, life: Truth, encoder: float, delay: int, angles: bool, tilt: float
) -> None:
    log = sensors(nao, life, encoder=encoder, delay=ROW * delay)
    kind = {"accelerometer": None, "gyro": None, "angles": log.angles} if angles else {}
    found = found_in(nao, log, **kind)
    errors = Errors.of(found, life)
    assert errors.tilt < tilt
    assert errors.height < 0.002
    assert errors.support < 0.05 + 0.05 * delay  # three rows late of 40 in a step
    assert errors.false_lying == 0.0
    assert errors.missed_lying <= 0.1 + ROW * 2 * delay
    assert max(errors.false_lifted, errors.missed_lift) <= ROW * (3 + 2 * delay)
    assert errors.left_out < 0.005
    assert found.odometry.segments == 5
    # The time in which it tilts by less than 15° over its toe is not known to be a fall.
    outside = ~np.isin(life.doing, ("standing", "walking"))
    assert found.valid[outside].mean() < 0.15
    assert np.isnan(found.T_world_base[~found.valid]).all()
    assert np.isfinite(found.T_world_base[found.valid]).all()
    walked = float((life.doing == "walking").sum()) * ROW
    assert abs(found.seconds["walking"] - walked) < 1.1  # the first and the last half step
    assert sum(found.seconds.values()) == pytest.approx(life.times[-1])


def test_joints_that_are_missing_for_long_are_not_made_up(nao: nk.NaoModel) -> None:
    q = np.tile(nao.posture("StandInit"), (300, 1))
    q[50:60], q[100:250] = np.nan, np.nan  # 0.1 s are interpolated, 1.5 s are not
    found = nk.world.state(nao, q, times=0.01 * np.arange(300))
    lost = np.isnan(found.up).any(axis=1)
    assert np.flatnonzero(lost).tolist() == list(range(100, 250))
    assert set(found.doing[lost]) == {"unknown"}
    assert set(found.doing[~lost]) == {"standing"}


def test_gaps_and_nan_leave_rows_out_and_nothing_else(nao: nk.NaoModel, life: Truth) -> None:
    whole = sensors(nao, life)
    log = simulated.without(whole, nao, np.random.default_rng(1))
    assert np.isnan(log.q).any(axis=1).all()
    found, before = found_in(nao, log), found_in(nao, whole)
    knee = np.isnan(log.q[:, nao.joint_names.index("LKneePitch")])
    assert not found.valid[knee].any()
    assert np.array_equal(found.valid[~knee], before.valid[~knee])
    assert found.odometry.segments == before.odometry.segments == 5
    errors = Errors.of(found, life)
    assert errors.tilt < 0.7
    assert errors.false_lying == errors.false_lifted == 0.0
    both = found.valid & before.valid & (found.odometry.segment == 0)
    assert np.abs(found.T_world_base[both] - before.T_world_base[both]).max() < 0.02


def test_a_gap_begins_a_segment_where_the_one_before_it_ended(nao: nk.NaoModel, life: Truth) -> None:
    log = sensors(nao, life)
    rows = np.flatnonzero((life.times < 2.5) | ((life.times > 3.4) & (life.times < 5.0)))
    cut = log.at(rows)
    path = found_in(nao, cut).odometry
    assert path.segments == 2
    first, last = np.flatnonzero(path.segment == 1)[0], np.flatnonzero(path.segment == 0)[-1]
    feet = [nk.world.feet_frame(path.T_world_base[k] @ nao.fk(cut.q[k], simulated.LEGS)) for k in (first, last)]
    assert np.abs(feet[0] - feet[1]).max() < 2e-3
    assert np.abs(path.covariance[first]).max() == 0.0
    longer = found_in(nao, cut, longest_gap=1.0).odometry
    assert longer.segments == 1


def test_a_clock_that_is_set_is_only_a_gap(nao: nk.NaoModel, life: Truth) -> None:
    log = sensors(nao, life)
    times = log.times + np.where(log.times > 1.0, 1.7e9, 0.0)
    found = nk.world.state(nao, log.q, times=times, forces=log.forces, accelerometer=log.accelerometer, gyro=log.gyro)
    assert found.odometry.segments == 6
    assert sum(found.seconds.values()) == pytest.approx(life.times[-1], abs=0.02)
    assert found.valid[life.doing == "walking"].all()


def test_a_hand_that_reports_nothing_changes_nothing(nao: nk.NaoModel, life: Truth) -> None:
    log = sensors(nao, life)
    q = log.q.copy()
    q[:, nao.joint_names.index("LHand")] = np.nan
    with_hand, without = (
        nk.world.state(nao, values, times=log.times, forces=log.forces, angles=log.angles) for values in (log.q, q)
    )
    assert np.array_equal(with_hand.T_world_base, without.T_world_base, equal_nan=True)


# --- The orientation.


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("unit", [1.0, 1.0 / simulated.GRAVITY])
def test_the_accelerometers_sign_and_unit_do_not_matter(
    nao: nk.NaoModel, life: Truth, sign: float, unit: float
) -> None:
    log = sensors(nao, life)
    found = found_in(nao, log, accelerometer=sign * unit * log.accelerometer)
    assert Errors.of(found, life).tilt < 0.7
    assert any("as LoLA has it" in note for note in found.notes) == (sign < 0.0)
    assert not any("not used" in note for note in found.notes)


def test_a_robot_that_only_lies_gets_a_note_on_the_sign(nao: nk.NaoModel) -> None:
    q = np.tile(nao.posture("LyingBelly"), (50, 1))
    times = 0.01 * np.arange(50)
    found = nk.world.state(nao, q, times=times, accelerometer=np.tile([-9.8, 0.0, 0.0], (50, 1)))
    assert set(found.doing.tolist()) == {"lying"}
    assert "sign is taken as that of 9.8 m/s² up" in found.notes[0]
    empty = nk.world.state(nao, q, times=times, accelerometer=np.tile([0.0, 0.0, 0.0], (50, 1)))
    assert set(empty.doing.tolist()) == {"unknown"}
    assert not empty.valid.any()


def test_the_filter_is_the_differential_equation_of_its_docstring(nao: nk.NaoModel) -> None:
    """A standing robot rocks: the vertical of SciPy's rotations, with noise, to a quarter of a degree."""
    rng, times = np.random.default_rng(5), 0.01 * np.arange(1500)
    R = Rotation.from_rotvec(np.radians(4.0) * np.column_stack([np.sin(2.0 * times), np.cos(3.0 * times), 0 * times]))
    turn = (R[:-1].inv() * R[1:]).as_rotvec() / 0.01
    gyro = np.concatenate([turn[:1], 0.5 * (turn[1:] + turn[:-1]), turn[-1:]])
    gyro += np.array([0.03, -0.02, 0.01])
    up = R.inv().apply([0.0, 0.0, 1.0])
    measured = 9.81 * up + rng.normal(0.0, 0.5, (1500, 3))
    measured[rng.random(1500) < 0.05] *= 2.0  # impacts
    q = np.tile(nao.posture("StandInit"), (1500, 1))
    found = nk.world.state(nao, q, times=times, accelerometer=measured, gyro=gyro)
    away = np.degrees(np.arccos(np.clip(np.einsum("ni,ni->n", found.up, up), -1.0, 1.0)))
    assert np.sqrt(np.mean(away[300:-300] ** 2)) < 0.25  # the bias cancels: one direction alone is 1.7° off
    assert away.max() < 3.5  # at the ends
    roll_pitch = R.as_euler("ZYX")[:, :0:-1]
    assert np.abs(found.roll_pitch - roll_pitch)[100:-100].max() < np.radians(1.0)


def test_the_bias_of_the_gyrometer_is_measured_at_rest_only(nao: nk.NaoModel, life: Truth) -> None:
    log = sensors(nao, life).at(life.times < life.times[life.doing == "falling"][0] - 0.2)
    path = found_in(nao, log).odometry
    note = next(note for note in found_in(nao, log).notes if "mean at rest" in note)
    shown = np.array([float(word.strip(",")) for word in note.split() if word.strip(",-").replace(".", "").isdigit()])
    bias = (log.gyro - log.truth.rates).mean(axis=0)
    assert np.abs(bias).min() > 0.015
    assert (np.abs(shown - bias) < [0.003, 0.013, 0.003]).all()  # it bends slowly before it walks
    at = np.flatnonzero(path.segment == 0)[-1]
    assert abs(path.pose[at, 2] - path.pose[0, 2] - life.heading[at]) < np.radians(1.0)
    only = log.at(log.truth.doing == "walking")
    assert not any("mean at rest" in note for note in found_in(nao, only).notes)


def test_a_gyrometer_in_degrees_is_noted(nao: nk.NaoModel, life: Truth) -> None:
    log = sensors(nao, life)
    walk = np.flatnonzero(life.doing == "walking")
    path = nk.world.odometry(nao, log.q[walk], log.times[walk], gyro=np.degrees(log.gyro[walk]))
    assert "are these deg/s? A heading such as GyroX [deg/s] says so" in path.notes[0]
    (note,) = nk.world.odometry(nao, log.q[walk], log.times[walk], gyro=log.gyro[walk]).notes
    assert "bias is not known, as the robot is never at rest" in note


# --- The pose and its covariance.


def test_the_pose_is_that_of_pinocchio_with_the_support_sole_on_the_floor(nao: nk.NaoModel) -> None:
    rng = np.random.default_rng(2)
    q = np.tile(nao.posture("Stand"), (40, 1)) + rng.normal(0.0, 0.02, (40, 25))
    angles = rng.normal(0.0, np.radians(2.0), (40, 2))
    forces = np.tile([[0.1, 5.0]], (40, 1))
    found = nk.world.state(nao, q, times=0.02 * np.arange(40), angles=angles, forces=forces)
    assert found.valid.all()
    assert set(found.support.tolist()) == {"RLeg"}
    data = nao.model.createData()
    for k in range(40):
        pin.framesForwardKinematics(nao.model, data, q[k])
        sole = data.oMf[nao.model.getFrameId("RLeg")].translation
        R = Rotation.from_euler("xyz", [*angles[k], found.odometry.pose[k, 2]]).as_matrix()
        assert np.abs(R - found.T_world_base[k, :3, :3]).max() < 1e-12
        placed = R @ sole + found.T_world_base[k, :3, 3]
        assert np.abs(placed - found.odometry.T_world_support[k, :3, 3] * [1.0, 1.0, 0.0]).max() < 1e-12


def test_the_covariance_of_the_height_is_that_of_finite_differences(nao: nk.NaoModel) -> None:
    q, forces = np.tile(nao.posture("Crouch"), (3, 1)), np.tile([[4.5, 0.9]], (3, 1))
    angles = np.tile([0.05, -0.1], (3, 1))
    times = [0.0, 0.1, 0.2]
    found = nk.world.state(nao, q, times=times, angles=angles, forces=forces)
    step = 1e-6
    moved = [nk.world.state(nao, q, times=times, angles=angles + step * np.eye(2)[k], forces=forces) for k in range(2)]
    J = [(other.T_world_base[0, 2, 3] - found.T_world_base[0, 2, 3]) / step for other in moved]
    P = found.covariance[0]
    assert P[2, :2] == pytest.approx(P[:2, :2] @ J, rel=1e-4)
    assert P[2, 2] == pytest.approx(J @ P[:2, :2] @ J + 0.0012**2, rel=1e-4)


def test_the_legs_have_their_share_in_what_an_inertial_unit_differs_by(nao: nk.NaoModel) -> None:
    """Deviations a of the unit and b of the legs: of a difference d, the unit has d a²/(a² + b²) ± a b/√(a² + b²)."""
    q, a, b, d = np.tile(nao.posture("StandInit"), (50, 1)), 1.2, 1.7, 5.0
    level = -np.arctan2(*nao.fk(q[0], "LLeg")[[0, 2], 2])
    angles = np.tile([0.0, level + np.radians(d)], (50, 1))
    found = nk.world.state(nao, q, times=0.01 * np.arange(50), angles=angles, forces=np.full((50, 2), 2.7))
    share, own = a**2 / (a**2 + b**2), a * b / np.hypot(a, b)
    expected = [own**2, own**2 + (share * d) ** 2]
    assert np.degrees(np.sqrt(np.diag(found.covariance[0])[:2])) == pytest.approx(np.sqrt(expected), rel=1e-3)


def test_the_covariances_contain_the_errors(nao: nk.NaoModel, ahead: Truth) -> None:
    """Mean squares of normalised errors: at most about 1 for each number, and not a hundredth of it."""
    paths, tilts = [], []
    for k, truth in enumerate([ahead, walked(nao, 4, 0.0, 0.02, -0.04)]):
        log = sensors(nao, truth, k, encoder=0.3, delay=ROW)
        for gyro in (log.gyro, None):
            found = found_in(nao, log, gyro=gyro, start=truth.T[0])
            e = found.odometry.pose[-1] - [
                *truth.T[-1, :2, 3],
                Rotation.from_matrix(truth.T[-1, :3, :3]).as_rotvec()[2],
            ]
            e[2] = (e[2] + np.pi) % (2.0 * np.pi) - np.pi
            paths.append(e @ np.linalg.solve(found.odometry.covariance[-1], e) / 3.0)
            z = found.T_world_base[:, 2, 3] - truth.T[:, 2, 3]
            away = np.column_stack([found.roll_pitch - log.angles, z])
            R = truth.T[:, :3, :3]
            away[:, 0] = found.roll_pitch[:, 0] - np.arctan2(R[:, 2, 1], R[:, 2, 2])
            away[:, 1] = found.roll_pitch[:, 1] - np.arcsin(-R[:, 2, 0])
            tilts.append(float(np.mean(np.einsum("ni,nij,nj->n", away, np.linalg.inv(found.covariance), away)) / 3.0))
    assert 0.05 < np.mean(paths) < 1.5
    assert max(paths) < 4.0
    assert 0.05 < np.mean(tilts) < 1.5


def test_the_covariance_of_the_path_grows_with_its_steps_and_its_lever(nao: nk.NaoModel, life: Truth) -> None:
    """The closed sums are those of errors that are propagated step by step, by the derivative of the composed poses."""
    rows = np.flatnonzero(life.doing == "walking")  # never at rest
    path = nk.world.odometry(nao, life.q[rows], life.times[rows], forces=life.loads[rows])
    pose = np.column_stack([path.pose[:, :2], np.unwrap(path.pose[:, 2])])
    P = np.zeros((3, 3))
    for k in range(1, len(pose)):
        F = np.eye(3)
        F[:2, 2] = -(pose[k, 1] - pose[k - 1, 1]), pose[k, 0] - pose[k - 1, 0]
        P = F @ P @ F.T + np.diag([0.004**2, 0.004**2, np.radians(1.9) ** 2]) * (path.times[k] - path.times[k - 1])
        if path.steps[k]:
            P += np.diag([0.003**2, 0.003**2, np.radians(0.5) ** 2])
    P += np.diag([0.0015**2, 0.0015**2, np.radians(0.15) ** 2])  # the noise of two rows
    way = 0.035 * (pose[-1] - pose[0])
    assert path.covariance[-1] == pytest.approx(P + np.outer(way, way), rel=1e-9, abs=1e-15)
    assert path.steps.sum() > 6
    assert (np.diff(np.linalg.det(path.covariance[path.steps])) > 0.0).all()


def test_the_velocity_is_that_of_the_truth_in_the_robots_axes(nao: nk.NaoModel, ahead: Truth) -> None:
    turned = np.eye(4)
    turned[:3, :3] = Rotation.from_rotvec([0.0, 0.0, 2.0]).as_matrix()
    path = nk.world.odometry(nao, ahead.q, ahead.times, forces=ahead.loads, start=turned @ ahead.T[0])
    walking = np.flatnonzero(ahead.doing == "walking")
    middle = walking[len(walking) // 4 : -len(walking) // 4]
    speed = (ahead.T[middle[-1], 0, 3] - ahead.T[middle[0], 0, 3]) / (ahead.times[middle[-1]] - ahead.times[middle[0]])
    assert path.velocity[middle, 0].mean() == pytest.approx(speed, rel=0.1)
    assert abs(path.velocity[middle, 1].mean()) < 0.1 * speed
    assert np.abs(path.velocity[50:100]).max() < 3e-3
    ends = [0, *np.flatnonzero(path.steps), -1]  # it sways from step to step
    assert path.distance == pytest.approx(np.linalg.norm(np.diff(ahead.T[ends, :2, 3], axis=0), axis=1).sum(), rel=0.1)


def test_an_empty_and_a_single_row(nao: nk.NaoModel) -> None:
    one = nk.world.state(nao, nao.posture("Stand")[None], times=[3.0])
    assert any("nor an inertial unit show whether the robot stands" in note for note in one.notes)
    assert one.valid.tolist() == [True]
    assert one.odometry.pose[0].round(2).tolist() == [-0.01, 0.0, 0.0]
    assert np.isnan(one.odometry.velocity).all()
    none = nk.world.state(nao, np.full((4, 25), np.nan), times=np.arange(4.0), forces=np.ones((4, 2)))
    assert not none.valid.any()
    assert none.odometry.segments == 0
    assert none.odometry.distance == 0.0


# --- Contact and pressure.


def test_the_centre_of_pressure_is_the_weighted_mean_of_the_sensors(nao: nk.NaoModel) -> None:
    rng = np.random.default_rng(4)
    q = np.tile(nao.posture("StandInit"), (30, 1)) + rng.normal(0.0, 0.01, (30, 25))
    forces = rng.uniform(0.2, 2.0, (30, 8))
    found = nk.world.state(nao, q, times=0.01 * np.arange(30), forces=forces, angles=np.zeros((30, 2)))
    assert found.valid.all()
    data = nao.model.createData()
    for k in range(30):
        pin.framesForwardKinematics(nao.model, data, q[k])
        places = np.array([data.oMf[nao.model.getFrameId(name)].translation for name in nao.semantics.force_sensors])
        world = places @ found.T_world_base[k, :3, :3].T + found.T_world_base[k, :3, 3]
        assert found.centre_of_pressure[k] == pytest.approx((forces[k] @ world / forces[k].sum())[:2], abs=1e-9)
        sole = data.oMf[nao.model.getFrameId("RLeg")].inverse() * (forces[k, 4:] @ places[4:] / forces[k, 4:].sum())
        assert found.sole_pressure[k, 1] == pytest.approx(np.asarray(sole)[:2], abs=1e-9)
    assert found.forces == pytest.approx(forces.reshape(30, 2, 4).sum(axis=2))
    by_sole = nk.world.state(nao, q, times=0.01 * np.arange(30), forces=found.forces)
    assert np.isnan(by_sole.sole_pressure).all()
    assert by_sole.support.tolist() == found.support.tolist()


@pytest.mark.parametrize("unit", [1.0, 9.81, 1.0 / 5.13])
def test_contact_is_lost_after_two_tenths_of_a_second(nao: nk.NaoModel, unit: float) -> None:
    times = 0.01 * np.arange(400)
    forces = np.full((400, 2), 2.7)
    forces[50:65] = forces[100:156] = 0.05  # 0.15 s, and 0.56 s
    forces[126:131] = 2.7  # 0.05 s in between
    forces[:, 1] *= 0.9
    found = nk.world.state(nao, np.tile(nao.posture("Stand"), (400, 1)), times=times, forces=unit * forces)
    assert np.flatnonzero(~found.valid).tolist() == list(range(100, 156))
    assert found.odometry.segments == 2
    assert found.seconds["unknown"] == pytest.approx(0.56)  # without inertial unit, it may lie
    upright = nk.world.state(
        nao, np.tile(nao.posture("Stand"), (400, 1)), times=times, forces=unit * forces, angles=np.zeros((400, 2))
    )
    assert upright.seconds["lifted"] == pytest.approx(0.56)
    assert set(found.support[100:156].tolist()) == {"none"}
    air = nk.world.state(nao, np.tile(nao.posture("Stand"), (400, 1)), times=times, forces=np.full((400, 2), 0.01))
    assert not air.valid.any()


def test_without_forces_a_foot_on_the_floor_is_one_at_its_height(nao: nk.NaoModel) -> None:
    q = np.tile(nao.posture("Stand"), (20, 1))
    q[10:, nao.joint_names.index("RKneePitch")] += 0.3
    found = nk.world.state(nao, q, times=0.01 * np.arange(20))
    assert found.support.tolist() == ["both"] * 10 + ["LLeg"] * 10
    contacts = np.tile([False, True], (20, 1))
    assert set(nk.world.state(nao, q, times=0.01 * np.arange(20), contacts=contacts).support.tolist()) == {"RLeg"}


def test_a_robot_that_bends_far_stands(nao: nk.NaoModel) -> None:
    q = np.tile(nao.posture("Stand"), (200, 1))
    angle = np.concatenate([np.linspace(0.0, 1.2, 100), np.full(100, 1.2)])
    for side in "LR":
        q[:, nao.joint_names.index(f"{side}HipPitch")] -= angle
    # Bending of the hips with the legs in place: the torso has turned forwards.
    up = nao.fk(q, "LLeg")[:, :3, 2]
    angles = np.column_stack([0.0 * angle, np.arctan2(-up[:, 0], up[:, 2])])
    assert np.degrees(angles[-1, 1]) > 60.0
    times = 0.01 * np.arange(200)
    forces = np.full((200, 2), 2.7)
    found = nk.world.state(nao, q, times=times, angles=angles, forces=forces)
    assert set(found.doing.tolist()) == {"standing"}
    assert found.valid.all()
    fallen = nk.world.state(nao, q, times=times, angles=angles, forces=np.where(angles[:, 1:] > 0.9, 0.0, forces))
    assert fallen.doing[-1] == "lying"


def test_lying_is_told_from_the_joints_to_be_unknown(nao: nk.NaoModel) -> None:
    q = np.linspace(nao.posture("StandInit"), nao.posture("LyingBelly"), 100)
    found = nk.world.state(nao, q, times=0.02 * np.arange(100))
    assert found.doing[0] == "standing"
    assert found.doing[-1] == "unknown"
    assert not found.valid[-1]
    assert found.seconds["unknown"] > 0.0


@pytest.mark.full
def test_other_robots_have_a_state_too() -> None:
    robot = nk.load_robot("romeo")
    q = np.tile(robot.neutral(), (50, 1))
    found = nk.world.state(robot, q, times=0.01 * np.arange(50), soles=["l_ankle", "r_ankle"], angles=np.zeros((50, 2)))
    assert found.valid.all()
    assert set(found.support.tolist()) == {"both"}


@pytest.mark.parametrize(
    ("changes", "error", "message"),
    [
        ({"times": [0.0, 0.2, 0.1]}, BadArgument, "times must ascend: row 2 is at 0.1 s, row 1 at 0.2 s"),
        ({"times": [0.0, 0.1]}, WrongShape, "times"),
        ({"q": np.zeros(25)}, WrongShape, "one configuration at least"),
        ({"q": np.zeros((3, 24))}, WrongShape, "q must have shape"),
        ({"q": np.full((3, 25), np.inf)}, NaoKinError, "q"),
        ({"angles": np.zeros((3, 3))}, WrongShape, "angles"),
        ({"angles": np.full((3, 2), np.inf)}, NaoKinError, "angles"),
        ({"accelerometer": np.ones((2, 3))}, WrongShape, "accelerometer"),
        ({"gyro": np.zeros((3, 2))}, WrongShape, "gyro"),
        ({"angles": np.zeros((3, 2)), "accelerometer": np.ones((3, 3))}, BadArgument, "angles or an accelerometer"),
        ({"contacts": np.ones((3, 2)), "forces": np.ones((3, 2))}, BadArgument, "not both"),
        ({"forces": np.ones((3, 5))}, WrongShape, r"forces must have shape \(3, 2\) or \(3, 8\)"),
        ({"forces": np.ones(3)}, WrongShape, "forces"),
        ({"contacts": np.ones((3, 3))}, WrongShape, "contacts"),
        ({"soles": []}, BadArgument, "soles must name at least one frame"),
        ({"longest_gap": -1.0}, BadArgument, "longest_gap"),
        ({"start": np.zeros((4, 4))}, NaoKinError, "start: not a rotation matrix"),
    ],
)
def test_wrong_input_is_refused(
    nao: nk.NaoModel, changes: dict[str, object], error: type[Exception], message: str
) -> None:
    given = {"times": [0.0, 0.1, 0.2], "q": np.tile(nao.posture("Stand"), (3, 1))} | changes
    with pytest.raises(error, match=message):
        nk.world.state(nao, given.pop("q"), **given)
