"""Faults planted in each convention must be found, and reported for that convention only."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from loops import full
from made_up_robots import J, made_up

import nao_kin as nk
from nao_kin import crosscheck, rotations
from nao_kin.crosscheck import Conversions
from nao_kin.crosscheck.steps import Step, steps_of
from nao_kin.joints import JointAxes
from nao_kin.robot.limits import JointLimits
from nao_kin.robot.nao import NaoParameters, nao_parameters
from nao_kin.rotations import EulerAngles

Function = Callable[..., Any]
Euler = Callable[[EulerAngles], EulerAngles]

ELEMENTARY = "poses from elementary rotations"
CONVENTIONS = [(sequence, axes) for sequence in rotations.SEQUENCES for axes in ("moving", "fixed")]
ALL_EXTRACTIONS = {f"euler_from_matrix {sequence} {axes}" for sequence, axes in CONVENTIONS}
ALL_COMPOSITIONS = {f"matrix_from_euler {sequence} {axes}" for sequence, axes in CONVENTIONS}
HIPS = {"davenport_angles left hip", "davenport_angles right hip"}
LINES = {f"joint axes as lines, {way}" for way in ("frame", "root", "mixed")}
FIRST_TURN = np.array([2.0 * math.pi, 0.0, 0.0])
OTHER = {"moving": "fixed", "fixed": "moving"}


@dataclass(frozen=True)
class ConversionFault:
    """A wrong function in one field of `Conversions`; its rows must fail, or those of these conventions, no others."""

    name: str
    field: str
    faulty: Function
    conventions: frozenset[str] | set[str] = frozenset()

    @property
    def rows(self) -> set[str]:
        return {*self.conventions} or {self.field}

    @property
    def conversions(self) -> Conversions:
        return Conversions(**{self.field: self.faulty})


@dataclass(frozen=True)
class StepFault:
    """Wrong numbers of the robot built by hand, the row of steps that must fail, and the joints or frames it names."""

    name: str
    parameters: NaoParameters
    row: str
    culprits: set[str]


@dataclass(frozen=True)
class RobotFault:
    """A robot changed after loading, the conventions that must fail, and the joints that they name."""

    name: str
    change: Callable[[nk.RobotModel], None]
    rows: set[str]
    culprits: set[str]


def named(faults: tuple[Any, ...]) -> Any:
    return pytest.mark.parametrize("fault", [faults[0], *full(*faults[1:])], ids=[fault.name for fault in faults])


def failing(report: crosscheck.Report) -> set[str]:
    return {row.convention for row in report.failures}


def blamed(report: crosscheck.Report, convention: str) -> set[str]:
    """The frames in which a convention fails."""
    return {frame for row in report.failures if row.convention == convention for frame in row.failing}


# --- conversions ------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> nk.RobotModel:
    """A small robot whose frames take every kind of rotation."""
    return made_up(
        tmp_path_factory.mktemp("robot"),
        J("yaw"),
        J("pitch", axis=(0.0, 1.0, 0.0), xyz=(0.1, 0.2, 0.3)),
        J("roll", axis=(1.0, 0.0, 0.0), xyz=(0.1, 0.0, -0.2), rpy=(0.3, -0.5, 0.7)),
        J("twin", axis=(0.0, 1.0, -1.0), follows=("pitch", -2.0, 0.1)),
        J("slide", kind="prismatic", axis=(0.0, 0.0, -1.0), rpy=(math.pi / 2, 0.0, 0.0)),
    )


def transposed(function: Function) -> Function:
    return lambda *given, **named: np.swapaxes(function(*given, **named), -1, -2)


def scaled(function: Function, factor: object) -> Function:
    return lambda *given, **named: function(*given, **named) * np.asarray(factor)


def reordered(function: Function, order: list[int]) -> Function:
    return lambda *given, **named: function(*given, **named)[..., order]


def euler_fault(name: str, fault: Euler, sequence: str = "zyx", axes: str = "moving") -> ConversionFault:
    """The true extraction, with a fault in one of the 24 conventions."""

    def faulty(R: np.ndarray, wanted: str, *, axes: str) -> EulerAngles:
        found = rotations.euler_from_matrix(R, wanted, axes=axes)
        return fault(found) if (wanted, axes) == chosen else found

    chosen = (sequence, axes)
    return ConversionFault(name, "euler_from_matrix", faulty, {f"euler_from_matrix {sequence} {axes}"})


def lower_pole_taken_for_the_upper(found: EulerAngles) -> EulerAngles:
    angles = found.angles.copy()
    angles[found.locked & (angles[:, 1] < 0.0), 0] *= -1.0
    return replace(found, angles=angles)


def first_angle_zero_at_lock(found: EulerAngles) -> EulerAngles:
    angles = found.angles.copy()
    sign = np.where(angles[:, 1] > 0.0, -1.0, 1.0)
    angles[found.locked, 2] = (sign * angles[:, 0])[found.locked]
    angles[found.locked, 0] = 0.0
    return replace(found, angles=angles)


def snapped_beside_lock(found: EulerAngles) -> EulerAngles:
    angles = found.angles.copy()
    near = (np.cos(angles[:, 1]) < 1e-7) & ~found.locked
    sign = np.where(angles[:, 1] > 0.0, -1.0, 1.0)
    angles[near, 0] += (sign * angles[:, 2])[near]
    angles[near, 2] = 0.0
    return replace(found, angles=angles)


def other_first(found: EulerAngles) -> EulerAngles:
    free = ~found.locked[:, None]
    return replace(
        found,
        angles=np.where(free, found.other, found.angles),
        other=np.where(free, found.angles, found.other),
    )


def middle_negated_in_the_other(found: EulerAngles) -> EulerAngles:
    """Only for rotations of which eigenpy, whose first angle is never negative, gives the principal triple."""
    signs = np.where(found.angles[:, :1] >= 0.0, [[1.0, -1.0, 1.0]], 1.0)
    return replace(found, other=found.other * signs)


def angle_by_arccos(R: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    axis, _ = rotations.natural_invariants(R)
    angle = np.arccos(np.clip(0.5 * (np.trace(R, axis1=-2, axis2=-1) - 1.0), -1.0, 1.0))
    return axis, angle


def log_without_the_sign_at_half_a_turn(R: np.ndarray) -> np.ndarray:
    """Signs by the antisymmetric part alone, which vanishes at π."""
    v = rotations.log(R)
    antisymmetric = np.stack([R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]], axis=-1)
    return np.abs(v) * np.sign(antisymmetric)


def outer_angle_in_the_next_turn(found: EulerAngles) -> EulerAngles:
    return replace(found, angles=found.angles + FIRST_TURN)


def other_in_the_next_turn(found: EulerAngles) -> EulerAngles:
    return replace(found, other=found.other + FIRST_TURN)


def other_is_the_same(found: EulerAngles) -> EulerAngles:
    return replace(found, other=found.angles)


def half_turns_at_minus_pi(found: EulerAngles) -> EulerAngles:
    """−π for π: the same angle, and in its range too."""
    outer = [True, False, True]
    return replace(
        found,
        angles=np.where((found.angles == math.pi) & outer, -math.pi, found.angles),
        other=np.where((found.other == math.pi) & outer, -math.pi, found.other),
    )


def hips(fault: Euler) -> Function:
    return lambda R, *axes: fault(rotations.davenport_angles(R, *axes))


def log_the_long_way_round(R: np.ndarray) -> np.ndarray:
    axis, angle = rotations.natural_invariants(R)
    return axis * (angle - 2.0 * math.pi)[:, None]


def exp_of_a_clipped_angle(v: np.ndarray) -> np.ndarray:
    """Right up to half a turn."""
    length = np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-300)
    return rotations.exp(v / length * np.minimum(length, math.pi))


class VelocityInTheOtherFrame(rotations.RotationSpline):
    def angular_velocity(self, t: Any, *, expressed_in: Any = None) -> np.ndarray:
        return super().angular_velocity(t, expressed_in=OTHER[expressed_in])


class MomentsTheOtherWay(JointAxes):
    """Moments e × p for p × e."""

    def jacobian(self, *given: Any, **named: Any) -> np.ndarray:
        return super().jacobian(*given, **named) * np.array([-1.0, -1.0, -1.0, 1.0, 1.0, 1.0])[:, None]


class RootForMixed(JointAxes):
    def jacobian(self, q: np.ndarray, frame: str, expressed_in: Any = "mixed") -> np.ndarray:
        return super().jacobian(q, frame, "root" if expressed_in == "mixed" else expressed_in)


class WithoutFollowers(JointAxes):
    def coupling(self, frame: str) -> np.ndarray:
        C = super().coupling(frame)
        C[[name in self.robot.mimics for name in self.names]] = 0.0
        return C


TRUE = Conversions()
CONVERSION_FAULTS: tuple[ConversionFault, ...] = (
    ConversionFault(
        "fixed for moving axes",
        "matrix_from_euler",
        lambda a, s, *, axes: rotations.matrix_from_euler(a, s, axes=OTHER[axes]),
        ALL_COMPOSITIONS,
    ),
    ConversionFault(
        "fixed for moving axes, taken apart",
        "euler_from_matrix",
        lambda R, s, *, axes: rotations.euler_from_matrix(R, s, axes=OTHER[axes]),
        ALL_EXTRACTIONS,
    ),
    euler_fault("the other branch as the principal one", other_first, "xzx", "fixed"),
    euler_fault("sign of the middle angle in the other branch", middle_negated_in_the_other),
    ConversionFault(
        "sign of one axis", "matrix_from_rpy", lambda rpy: rotations.matrix_from_rpy(rpy * [1.0, -1.0, 1.0])
    ),
    ConversionFault(
        "yaw, pitch, roll for roll, pitch, yaw", "rpy_from_matrix", reordered(TRUE.rpy_from_matrix, [2, 1, 0])
    ),
    ConversionFault("matrix of a quaternion transposed", "matrix_from_quat", transposed(TRUE.matrix_from_quat)),
    ConversionFault("xyzw for wxyz", "quat_from_matrix", reordered(TRUE.quat_from_matrix, [1, 2, 3, 0])),
    ConversionFault("quaternion not in canonical sign", "quat_from_matrix", scaled(TRUE.quat_from_matrix, -1.0)),
    ConversionFault("product in the opposite order", "quat_multiply", lambda p, q: rotations.quat_multiply(q, p)),
    ConversionFault("conjugate negated", "quat_conjugate", scaled(TRUE.quat_conjugate, -1.0)),
    ConversionFault("wxyz called xyzw", "quat_to_xyzw", lambda q: q),
    ConversionFault("xyzw read the wrong way round", "quat_from_xyzw", TRUE.quat_to_xyzw),
    ConversionFault("slerp from the far end", "slerp", lambda p, q, t: rotations.slerp(q, p, t)),
    ConversionFault("angle by an arccos", "natural_invariants", angle_by_arccos),
    ConversionFault(
        "rotation about the axis the other way", "matrix_from_natural", transposed(TRUE.matrix_from_natural)
    ),
    ConversionFault(
        "tr R for cos φ",
        "linear_invariants",
        lambda R: (rotations.linear_invariants(R)[0], np.trace(R, axis1=-2, axis2=-1)),
    ),
    ConversionFault("linear invariants of the inverse", "matrix_from_linear", transposed(TRUE.matrix_from_linear)),
    ConversionFault("whole angle for half angle", "euler_rodrigues", TRUE.linear_invariants),
    ConversionFault(
        "Euler–Rodrigues parameters of the inverse",
        "matrix_from_euler_rodrigues",
        lambda r, r0: rotations.matrix_from_euler_rodrigues(-r, r0),
    ),
    ConversionFault("logarithm of the inverse", "log", scaled(TRUE.log, -1.0)),
    ConversionFault("sign of zero at half a turn", "log", log_without_the_sign_at_half_a_turn),
    ConversionFault(
        "left hip for right hip",
        "davenport_angles",
        lambda R, a, b, c: rotations.davenport_angles(R, np.multiply(a, [1, 1, -1]), b, c),
        {"davenport_angles left hip", "davenport_angles right hip"},
    ),
    ConversionFault(
        "the other branch of the hips as the principal one",
        "davenport_angles",
        lambda R, *axes: other_first(rotations.davenport_angles(R, *axes)),
        {"davenport_angles left hip", "davenport_angles right hip"},
    ),
    euler_fault("an outer angle in the next turn", outer_angle_in_the_next_turn, "zxz"),
    euler_fault("the other solution in the next turn", other_in_the_next_turn, "zyx", "fixed"),
    euler_fault("the same solution twice", other_is_the_same, "yxz"),
    ConversionFault("roll in the next turn", "rpy_from_matrix", lambda R: rotations.rpy_from_matrix(R) + FIRST_TURN),
    ConversionFault("logarithm the long way round", "log", log_the_long_way_round),
    ConversionFault("exponential of a clipped angle", "exp", exp_of_a_clipped_angle),
    ConversionFault("slerp from −p", "slerp", lambda p, q, t: -rotations.slerp(p, q, t)),
    ConversionFault("outer hip angle in the next turn", "davenport_angles", hips(outer_angle_in_the_next_turn), HIPS),
    ConversionFault("other hip angles in the next turn", "davenport_angles", hips(other_in_the_next_turn), HIPS),
    ConversionFault("the same hip angles twice", "davenport_angles", hips(other_is_the_same), HIPS),
    ConversionFault(
        "hip angles in the opposite order",
        "matrix_from_davenport",
        lambda a, *axes: rotations.matrix_from_davenport(a[:, ::-1], *axes),
        {"matrix_from_davenport left hip", "matrix_from_davenport right hip"},
    ),
    ConversionFault(
        "tangent of half the angle",
        "mrp_from_matrix",
        lambda R: np.divide(*(part.T for part in rotations.euler_rodrigues(R))).T,
    ),
    ConversionFault("parameters of the inverse", "matrix_from_mrp", lambda p: rotations.matrix_from_mrp(-p)),
    ConversionFault("power of the inverse", "power", lambda R, t: rotations.power(R, -t)),
    ConversionFault("left for right", "right_jacobian", TRUE.left_jacobian),
    ConversionFault(
        "weights in the opposite order",
        "mean_rotation",
        lambda R, weights: rotations.mean_rotation(R, weights[:, ::-1]),
    ),
    ConversionFault("velocity in the other frame", "RotationSpline", VelocityInTheOtherFrame),
    ConversionFault(
        "rates in the other frame",
        "euler_rate_jacobian",
        lambda a, s, *, axes, expressed_in: rotations.euler_rate_jacobian(
            a, s, axes=axes, expressed_in=OTHER[expressed_in]
        ),
    ),
    ConversionFault(
        "fixed for moving axes in quaternions",
        "quat_from_euler",
        lambda a, s, *, axes: rotations.quat_from_euler(a, s, axes=OTHER[axes]),
    ),
    ConversionFault("moments e × p", "joint_axes", MomentsTheOtherWay, LINES),
    ConversionFault("velocity of the wrong point", "joint_axes", RootForMixed, {"joint axes as lines, mixed"}),
    ConversionFault("followers left out of the Jacobian", "joint_axes", WithoutFollowers, LINES),
    ConversionFault(
        "turn about y transposed",
        "rot_y",
        transposed(TRUE.rot_y),
        {"rot_y", ELEMENTARY, "orientation in the parent frame"},
    ),
    ConversionFault(
        "turn about z in degrees",
        "rot_z",
        lambda angle: rotations.rot_z(np.radians(angle)),
        {"rot_z", ELEMENTARY, "orientation in the parent frame"},
    ),
)


# Only rotations at lock or just beside it show these.
LOCK_FAULTS: tuple[ConversionFault, ...] = (
    euler_fault("wrong branch at one pole of lock", lower_pole_taken_for_the_upper),
    euler_fault("the other tie-break at lock", first_angle_zero_at_lock),
    euler_fault("snapped to lock within 1e-7", snapped_beside_lock),
    euler_fault("lock not reported", lambda found: replace(found, locked=np.zeros_like(found.locked)), "zyz"),
)

# The same, of functions whose angles at lock are compared otherwise.
TIE_BREAK_FAULTS: tuple[ConversionFault, ...] = (
    ConversionFault(
        "roll zero at lock",
        "rpy_from_matrix",
        lambda R: rotations.euler_from_matrix(R, "xyz", axes="fixed", at_lock="first").angles,
    ),
    ConversionFault(
        "the other tie-break of the hips",
        "davenport_angles",
        lambda R, *axes: rotations.davenport_angles(R, *axes, at_lock="first"),
        HIPS,
    ),
    ConversionFault(
        "lock of the hips not reported",
        "davenport_angles",
        hips(lambda found: replace(found, locked=np.zeros_like(found.locked))),
        HIPS,
    ),
    ConversionFault(
        "lock of the hips reported everywhere",
        "davenport_angles",
        hips(lambda found: replace(found, locked=np.ones_like(found.locked))),
        HIPS,
    ),
)


@pytest.mark.full
@named(CONVERSION_FAULTS)
def test_a_broken_conversion_is_caught_and_named(robot: nk.RobotModel, fault: ConversionFault) -> None:
    report = crosscheck.run(robot, 60, conversions=fault.conversions)
    assert failing(report) == fault.rows
    assert all(row.failing and row.worst > 1e-10 for row in report.failures)


def test_the_robot_of_these_tests_passes_unbroken(robot: nk.RobotModel) -> None:
    assert crosscheck.run(robot, 150).ok


@named(LOCK_FAULTS)
def test_a_fault_at_lock_is_caught_there(nao: nk.NaoModel, fault: ConversionFault) -> None:
    report = crosscheck.run(nao, 30, conversions=fault.conversions)
    (row,) = report.failures
    assert {row.convention} == fault.rows
    assert row.worst > 1e-8
    assert row.place is not None
    _, sequence, axes = row.convention.split()
    middle = rotations.euler_from_matrix(nao.rotation(row.place.q, row.place.frame), sequence, axes=axes).angles[1]
    assert abs(math.sin(middle) if sequence[0] == sequence[2] else math.cos(middle)) < 1e-7


@named(TIE_BREAK_FAULTS)
def test_a_wrong_tie_break_is_caught_and_named(nao: nk.NaoModel, fault: ConversionFault) -> None:
    assert failing(crosscheck.run(nao, 30, conversions=fault.conversions)) == fault.rows


def test_minus_pi_is_as_good_as_pi(nao: nk.NaoModel) -> None:
    met = []

    def extracted(R: np.ndarray, sequence: str, *, axes: str) -> EulerAngles:
        found = rotations.euler_from_matrix(R, sequence, axes=axes)
        met.append((np.abs(found.angles) == math.pi).any())
        return half_turns_at_minus_pi(found)

    report = crosscheck.run(nao, 60, conversions=Conversions(euler_from_matrix=extracted))
    assert any(met)
    assert report.ok, report.failures


def test_several_faults_at_once_are_all_named(robot: nk.RobotModel) -> None:
    wrong = Conversions(exp=transposed(TRUE.exp), log=scaled(TRUE.log, -1.0), slerp=scaled(TRUE.slerp, 2.0))
    assert failing(crosscheck.run(robot, 40, conversions=wrong)) == {"exp", "log", "slerp"}


@pytest.mark.parametrize(
    "faulty",
    [
        lambda R: rotations.quat_from_matrix(R) * np.nan,
        lambda R: rotations.quat_from_matrix(R)[:, :3],
        lambda R: rotations.quat_from_matrix(R[:1]),
    ],
    ids=["NaN", "three numbers", "one for all"],
)
def test_what_is_no_number_or_of_the_wrong_shape_fails(robot: nk.RobotModel, faulty: Function) -> None:
    report = crosscheck.run(robot, 10, conversions=Conversions(quat_from_matrix=faulty))
    assert failing(report) == {"quat_from_matrix"}
    assert report.failures[0].worst == math.inf
    assert report.failures[0].as_dict()["worst"] is None


def test_a_conversion_that_refuses_a_rotation_fails_and_says_why(robot: nk.RobotModel) -> None:
    report = crosscheck.run(robot, 10, conversions=Conversions(log=lambda R: rotations.log(2.0 * R)))
    assert failing(report) == {"log"}
    assert report.failures[0].note.startswith("refused: not a rotation matrix at index [0]: det R − 1 = 7")


# --- the robot's numbers ----------------------------------------------------------------------------------------------


def joints(parameters: NaoParameters, **changes: dict[str, object]) -> NaoParameters:
    changed = (replace(joint, **changes.get(joint.name, {})) for joint in parameters.joints)
    return replace(parameters, joints=tuple(changed))


def frames(parameters: NaoParameters, **changes: dict[str, object]) -> NaoParameters:
    changed = (replace(frame, **changes.get(frame.name, {})) for frame in parameters.frames)
    return replace(parameters, frames=tuple(changed))


def negated(vector: tuple[float, float, float]) -> tuple[float, float, float]:
    x, y, z = vector
    return -x, -y, -z


V6 = nao_parameters("v6")
BY_NAME = {joint.name: joint for joint in V6.joints}
X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
LEFT, RIGHT = BY_NAME["LHipYawPitch"].axis, BY_NAME["RHipYawPitch"].axis
AXIS, TRAVEL, COUPLED = "axis and sense of a joint", "travel of a joint", "travel of a coupled joint"
POSITION, ORIENTATION = "position in the parent frame", "orientation in the parent frame"
SOLE = (0.0, 0.0, -V6.offsets["FootHeight"])
FINGERS = {name for name in nk.load_nao().mimics if "Finger" in name or "Thumb" in name}

PARAMETER_FAULTS: tuple[StepFault, ...] = (
    StepFault(
        "left and right hip axes swapped",
        joints(V6, LHipYawPitch={"axis": RIGHT}, RHipYawPitch={"axis": LEFT}),
        AXIS,
        {"LHipYawPitch", "RHipYawPitch"},
    ),
    StepFault(
        "sign of HipYawPitch",
        joints(V6, LHipYawPitch={"axis": negated(LEFT)}, RHipYawPitch={"axis": negated(RIGHT)}),
        AXIS,
        {"LHipYawPitch", "RHipYawPitch"},
    ),
    StepFault("sign of one hip", joints(V6, RHipYawPitch={"axis": negated(RIGHT)}), AXIS, {"RHipYawPitch"}),
    StepFault("coupling of the hips dropped", joints(V6, RHipYawPitch={"mimic": None}), COUPLED, {"RHipYawPitch"}),
    StepFault(
        "right hip driven by the left roll", joints(V6, RHipYawPitch={"mimic": "LHipRoll"}), COUPLED, {"RHipYawPitch"}
    ),
    StepFault(
        "arm roll about x",
        joints(V6, LShoulderRoll={"axis": X}, RShoulderRoll={"axis": X}),
        AXIS,
        {"LShoulderRoll", "RShoulderRoll"},
    ),
    StepFault("elbow yaw about z", joints(V6, LElbowYaw={"axis": Z}), AXIS, {"LElbowYaw"}),
    StepFault("pitch the other way", joints(V6, LKneePitch={"axis": negated(Y)}), AXIS, {"LKneePitch"}),
    StepFault("height of the foot", frames(V6, LLeg={"xyz": SOLE}, RLeg={"xyz": SOLE}), POSITION, {"LLeg", "RLeg"}),
    StepFault(
        "left shoulder for the right one",
        joints(V6, RShoulderPitch={"xyz": BY_NAME["LShoulderPitch"].xyz}),
        POSITION,
        {"RShoulderPitch"},
    ),
    StepFault("millimetres", joints(V6, HeadYaw={"xyz": (0.0, 0.0, 126.5)}), POSITION, {"HeadYaw"}),
    StepFault("camera looks up", frames(V6, CameraTop={"rpy": (0.0, -0.0209435, 0.0)}), ORIENTATION, {"CameraTop"}),
)


@named(PARAMETER_FAULTS)
def test_a_wrong_number_is_caught_and_blamed_on_its_joint_or_frame(nao: nk.NaoModel, fault: StepFault) -> None:
    report = crosscheck.run(nao, 5, steps=crosscheck.steps_of_nao(fault.parameters))
    assert failing(report) == {fault.row, ELEMENTARY}
    assert blamed(report, fault.row) == fault.culprits


def changed(steps: tuple[Step, ...], change: Callable[[Step], Step]) -> tuple[Step, ...]:
    return tuple(change(step) for step in steps)


def test_turns_of_a_urdf_about_moving_axes_are_caught_and_named(nao: nk.NaoModel) -> None:
    steps = steps_of(nao)
    report = crosscheck.run(nao, 15, steps=changed(steps, lambda step: replace(step, turns=step.turns[::-1])))
    assert failing(report) == {ORIENTATION, ELEMENTARY}
    several = {step.name for step in steps if sum(angle != 0.0 for _, angle in step.turns) > 1}
    # Between half turns about x and z, a turn about y commutes with the rest: there the order is all one.
    assert blamed(report, ORIENTATION) == several - {"Head/Touch/Rear"}
    assert {"Sonar/Left", "LHandFinger11", "CameraTop_optical_frame"} <= several


def geared(step: Step, multiplier: float) -> Step:
    return replace(step, mimic=step.mimic and replace(step.mimic, multiplier=multiplier))


def test_fingers_that_follow_in_full_are_caught_and_named(nao: nk.NaoModel) -> None:
    steps = changed(steps_of(nao), lambda step: geared(step, 1.0))
    report = crosscheck.run(nao, 15, steps=steps)
    assert failing(report) == {COUPLED, ELEMENTARY}
    assert blamed(report, COUPLED) == FINGERS


def test_a_joint_driven_in_degrees_is_caught_and_named(nao: nk.NaoModel) -> None:
    def degrees(step: Step) -> Step:
        return geared(step, math.pi / 180) if step.name == "LKneePitch" else step

    report = crosscheck.run(nao, 15, steps=changed(steps_of(nao), degrees))
    assert failing(report) == {TRAVEL, ELEMENTARY}
    assert blamed(report, TRAVEL) == {"LKneePitch"}


def test_a_joint_on_the_wrong_body_is_caught_and_named(nao: nk.NaoModel) -> None:
    report = crosscheck.run(nao, 15, steps=crosscheck.steps_of_nao(joints(V6, HeadPitch={"parent": "torso"})))
    assert blamed(report, POSITION) == blamed(report, AXIS) == blamed(report, TRAVEL) == {"HeadPitch"}


def test_a_missing_and_a_misspelt_frame_are_caught_and_named(nao: nk.NaoModel) -> None:
    steps = [step for step in steps_of(nao) if step.name != "RLeg" and step.parent != "RLeg"]
    steps = [replace(step, name="Gaze_") if step.name == "gaze" else step for step in steps]
    report = crosscheck.run(nao, 5, steps=steps)
    assert failing(report) == {"frame names"}
    assert blamed(report, "frame names") == {"RLeg", "r_sole", "gaze", "Gaze_"}


def test_a_version_taken_for_another_is_caught() -> None:
    report = crosscheck.run(nk.load_nao("v3.2"), 5, steps=crosscheck.steps_of_nao(nao_parameters("v3.3")))
    assert {"LElbowYaw", "RElbowYaw", "LWristYaw", "RWristYaw"} <= blamed(report, POSITION)


def test_a_changed_pinocchio_model_stands_alone() -> None:
    nao = nk.load_nao()
    nao.model.jointPlacements[nao.model.getJointId("LKneePitch")].translation[2] += 1e-9
    report = crosscheck.run(nao, 15)
    assert {(row.convention, row.against) for row in report.failures} == {
        (ELEMENTARY, "Pinocchio"),
        ("poses by Pinocchio", "yourdfpy"),
        ("poses by Pinocchio", "pin.buildModelFromUrdf"),
        (POSITION, "Pinocchio"),
    }
    assert blamed(report, POSITION) == {"LKneePitch"}


def test_an_orientation_that_was_not_read_is_caught(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    robot = made_up(tmp_path, J("a"), J("b", rpy=(0.5, 0.0, 0.0)), J("c"))
    text = robot.urdf_path.read_text(encoding="utf-8").replace('rpy="0.5 0.0 0.0"', 'quat_xyzw="0.3 0 0 0.95"')
    robot.urdf_path.write_text(text.replace("<robot", '<robot version="1.1"'), encoding="utf-8")
    for module in ("tree", "reader"):
        monkeypatch.setattr(f"nao_kin.robot.urdf.{module}.has_quaternions", lambda document: False)
    report = crosscheck.run(nk.RobotModel.from_urdf(robot.urdf_path), 5)
    assert {(row.convention, row.against) for row in report.failures} == {
        ("poses by Pinocchio", "pin.buildModelFromUrdf")
    }
    assert blamed(report, "poses by Pinocchio") == {"b", "b_l", "c", "c_l"}


# --- whatever raises an error -----------------------------------------------------------------------------------------


def raising(*given: object, **named: object) -> object:
    raise RuntimeError("out of order")


FIELDS = [*vars(TRUE)]


@pytest.mark.parametrize("field", [FIELDS[0], *full(*FIELDS[1:])])
def test_a_function_that_raises_an_error_fails_its_own_rows_and_no_others(robot: nk.RobotModel, field: str) -> None:
    report = crosscheck.run(robot, 8, conversions=Conversions(**{field: raising}))
    own = {row.convention for row in report.rows if row.convention.split()[0] == field}
    if field == "joint_axes":
        own = LINES
    elif field.startswith("rot_"):
        own |= {ELEMENTARY, ORIENTATION}
    assert failing(report) == own
    for row in report.failures:
        assert row.note == "refused: RuntimeError: out of order"
        assert row.worst == math.inf
        assert row.pairs > 0


def test_an_elementary_rotation_that_raises_an_error_is_blamed_on_what_it_turns(robot: nk.RobotModel) -> None:
    report = crosscheck.run(robot, 8, conversions=Conversions(rot_x=raising))
    assert blamed(report, ORIENTATION) == {"roll", "slide"}


def test_a_long_error_is_abbreviated_in_the_note(robot: nk.RobotModel) -> None:
    def talkative(R: object) -> object:
        raise ValueError("blah " * 1000)

    (row,) = crosscheck.run(robot, 3, conversions=Conversions(quat_from_matrix=talkative)).failures
    assert len(row.note) < 250


# --- limits and mimics ------------------------------------------------------------------------------------------------

VIOLATIONS, CLAMP = "limit_violations", "clamp"
TABLED = {"HeadPitch", "LAnkleRoll", "RAnkleRoll"}


def array_changed(robot: nk.RobotModel, name: str, joint: str, change: Callable[[float], float]) -> None:
    values = getattr(robot, name).copy()
    column = robot.joint_names.index(joint)
    values[column] = change(values[column])
    setattr(robot, name, values)


def without_tables(robot: nk.RobotModel) -> JointLimits:
    return JointLimits(robot.joint_names, robot.lower, robot.upper, robot.joint_units, ())


def violations_of_boxes_only(robot: nk.RobotModel) -> None:
    limits = without_tables(robot)
    robot.limit_violations = limits.violations  # type: ignore[method-assign]


def clamped_into_boxes_only(robot: nk.RobotModel) -> None:
    robot.clamp = lambda q: np.clip(q, robot.lower, robot.upper)  # type: ignore[method-assign]


def table_of_the_other_foot(robot: nk.RobotModel) -> None:
    head, left, right = robot.coupled_limits
    swapped = (head, replace(left, lower=right.lower, upper=right.upper), right)
    limits = JointLimits(robot.joint_names, robot.lower, robot.upper, robot.joint_units, swapped)
    robot.limit_violations, robot.clamp = limits.violations, limits.clamp  # type: ignore[method-assign]


LIMIT_FAULTS: tuple[RobotFault, ...] = (
    RobotFault(
        "a lower limit in degrees",
        lambda robot: array_changed(robot, "lower", "LKneePitch", math.degrees),
        {"lower limits", VIOLATIONS, CLAMP},
        {"LKneePitch"},
    ),
    RobotFault(
        "an upper limit of the other version",
        lambda robot: array_changed(robot, "upper", "LShoulderRoll", lambda _: math.radians(94.5)),
        {"upper limits", VIOLATIONS, CLAMP},
        {"LShoulderRoll"},
    ),
    RobotFault(
        "a speed in degrees",
        lambda robot: array_changed(robot, "velocity_limits", "HeadYaw", math.degrees),
        {"velocity limits"},
        {"HeadYaw"},
    ),
    RobotFault(
        "a torque too large by a rounding",
        lambda robot: array_changed(robot, "effort_limits", "RHand", lambda effort: effort + 1e-9),
        {"effort limits"},
        {"RHand"},
    ),
    RobotFault("tables not looked at", violations_of_boxes_only, {VIOLATIONS}, TABLED),
    RobotFault("clamped into the boxes only", clamped_into_boxes_only, {CLAMP}, TABLED),
    RobotFault("the table of the other foot", table_of_the_other_foot, {VIOLATIONS, CLAMP}, {"LAnkleRoll"}),
)


@named(LIMIT_FAULTS)
def test_a_wrong_limit_is_caught_and_blamed_on_its_joint(fault: RobotFault) -> None:
    robot = nk.load_nao()
    fault.change(robot)
    report = crosscheck.run(robot, 25)
    assert failing(report) == fault.rows
    assert {joint for row in report.failures for joint in row.failing} == fault.culprits
    for convention in fault.rows - {VIOLATIONS, CLAMP}:
        against = {row.against for row in report.failures if row.convention == convention}
        assert against == {"yourdfpy", "pin.buildModelFromUrdf"}


def coupled(folder: Path, *extra: J) -> nk.RobotModel:
    """A driving joint confined by three that follow it: one faster, one the other way round, one with an offset."""
    return made_up(
        folder,
        J("a", limits=(-3.0, 3.0)),
        J("b", axis=(0.0, 1.0, 0.0), limits=(-3.0, 3.0), follows=("a", 2.0, 0.0)),
        J("c", axis=(1.0, 0.0, 0.0), limits=(-1.0, 2.0), follows=("a", -1.0, 0.25)),
        J("d", kind="continuous", follows=("a", 0.5, 0.0)),
        *extra,
    )


def test_shared_limits_are_explained(tmp_path: Path) -> None:
    robot = coupled(tmp_path)
    assert (robot.lower[0], robot.upper[0], robot.velocity_limits[0]) == (-1.5, 1.25, 1.0)
    report = crosscheck.run(robot, 20)
    assert report.ok, report.failures
    assert [row.pairs for row in report.rows if row.convention == "mimics"] == [3]


@pytest.mark.parametrize("name", ["lower", "upper", "velocity_limits"])
def test_limits_that_are_not_shared_are_caught(tmp_path: Path, name: str) -> None:
    robot = coupled(tmp_path)
    own = {"lower": -3.0, "upper": 3.0, "velocity_limits": 2.0}
    array_changed(robot, name, "a", lambda _: own[name])
    report = crosscheck.run(robot, 20)
    assert f"{name.removesuffix('_limits')} limits" in failing(report)
    assert {joint for row in report.failures for joint in row.failing} == {"a"}


def test_a_wrong_mimic_is_caught(tmp_path: Path) -> None:
    (tmp_path / "right").mkdir()
    robot = coupled(tmp_path / "right")
    wrong = {name: replace(mimic, multiplier=-mimic.multiplier) for name, mimic in robot.mimics.items() if name == "c"}
    robot.mimics = {**robot.mimics, **wrong}
    assert blamed(crosscheck.run(robot, 20), "mimics") == {"c"}


def test_a_mimic_that_was_dropped_is_caught(tmp_path: Path) -> None:
    (tmp_path / "right").mkdir()
    robot = coupled(tmp_path / "right")
    robot.mimics = {name: mimic for name, mimic in robot.mimics.items() if name != "b"}
    assert blamed(crosscheck.run(robot, 20), "mimics") == {"b"}


def test_what_pinocchio_does_not_read_is_left_out_in_words(tmp_path: Path, capfd: pytest.CaptureFixture) -> None:
    path = tmp_path / "bare.urdf"
    path.write_text(
        '<robot name="bare"><link name="a"/><link name="b"/><joint name="j" type="revolute">'
        '<parent link="a"/><child link="b"/><limit lower="-1" upper="1"/></joint></robot>'
    )
    report = crosscheck.run(nk.RobotModel.from_urdf(path), 5)
    assert report.ok, report.failures
    rows = [row for row in report.rows if row.convention.endswith(" limits") or row.convention == "poses by Pinocchio"]
    assert len(rows) == 5
    assert {row.against for row in rows} == {"yourdfpy"}
    assert {row.note for row in rows} == {
        "not compared with Pinocchio's own parser, which needs velocity and effort of 'j'"
    }
    assert capfd.readouterr().err == ""
