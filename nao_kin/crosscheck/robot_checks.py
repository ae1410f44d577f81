"""The rows about the robot: poses by several implementations, single steps, Jacobians, and limits."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal

import numpy as np
import pinocchio as pin

from nao_kin._core.arrays import Floats
from nao_kin._kernels.cache import has_numba
from nao_kin.crosscheck.oracles import Oracle, ParsedJoint, PinocchioOracle, driver_of
from nao_kin.crosscheck.report import LEFT_OUT, TOLERANCE, Conversions, Tally, difference, largest
from nao_kin.crosscheck.samples import turns_about
from nao_kin.crosscheck.steps import Step, StepKinematics
from nao_kin.robot import RobotModel
from nao_kin.robot.semantics import CoupledLimit

_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
_EXPRESSIONS: tuple[Literal["frame", "root", "mixed"], ...] = ("frame", "root", "mixed")


class PoseChecks:
    """Poses by elementary rotations, the robot, batch kernels, Pinocchio and other readers, of common `frames`."""

    def __init__(
        self,
        robot: RobotModel,
        steps: Sequence[Step],
        conversions: Conversions,
        second: Oracle,
        parsed: PinocchioOracle | None,
        unparsed: str,
    ) -> None:
        self._robot, self._conversions = robot, conversions
        self._by_hand = StepKinematics(steps, robot.joint_names, conversions)
        known = set(robot.frame_names)
        self._mine = [i for i, step in enumerate(steps) if step.name in known]
        self.frames = tuple(steps[i].name for i in self._mine)
        column = {name: i for i, name in enumerate(self.frames)}
        self._second = _Reader(second, column)
        # Pinocchio's own model of the file, with which the robot's model is compared.
        self._parsed = [(_Reader(parsed, column), Tally("poses by Pinocchio", parsed.name))] if parsed else []
        self._steps = _StepChecks(robot, self._by_hand, self.frames)

        count = len(second.left_out)
        different = f"{second.name} reads a coupling, a sliding axis or a quaternion differently"
        note = f"{count} frames left out: {different}" if count else ""
        self._poses = [
            Tally("poses from elementary rotations", "Pinocchio"),
            Tally("poses from elementary rotations", second.name, note=note),
            Tally("poses by Pinocchio", second.name, note="; ".join(filter(None, (note, unparsed)))),
            Tally("poses by RobotModel.fk", "pin.framesForwardKinematics"),
        ]
        # Without Numba there are no kernels, and Pinocchio would be compared with itself.
        if has_numba():
            self._poses.append(Tally("poses by the batch kernels", "pin.framesForwardKinematics"))
        self._elementary = {axis: Tally(f"rot_{axis}", "pin.AngleAxis") for axis in _AXES}
        self._names = Tally("frame names", "Pinocchio")
        by_hand = {step.name for step in steps}
        names = sorted(by_hand | known)
        self._names.add(np.array([[float((name in by_hand) != (name in known)) for name in names]]), 0, names)

    @property
    def tallies(self) -> list[Tally]:
        """The rows, in the order of the report."""
        elementary = self._elementary.values() if self._robot.joint_names else ()
        return [*self._poses, *(tally for _, tally in self._parsed), self._names, *self._steps.tallies, *elementary]

    def add(self, q: Floats, first: int) -> Floats:
        """Compare configurations (n, nq) with indices from `first` on; return the robot's poses (n, frames, 4, 4)."""
        n, shared, joint_names = len(q), self._second.columns, self._robot.joint_names
        T, direct = self._robot.fk(q, self.frames), _pinocchio_poses(self._robot, self.frames, q)
        second = self._second.poses(q)

        @functools.cache
        def by_hand() -> Floats:  # fails if an elementary rotation under test does
            return self._by_hand.poses(q)[:, self._mine]

        hand_direct, hand_second, direct_second, robot_direct, *kernels_direct = self._poses
        hand_direct.compare(first, n, self.frames, lambda: _pose_difference(by_hand(), direct))
        hand_second.compare(first, n, self._second.frames, lambda: _pose_difference(by_hand()[:, shared], second))
        direct_second.add(_pose_difference(direct[:, shared], second), first, self._second.frames)
        for reader, tally in self._parsed:
            tally.add(_pose_difference(direct[:, reader.columns], reader.poses(q)), first, reader.frames)
        robot_direct.add(_pose_difference(T, direct), first, self.frames)
        for tally in kernels_direct:
            kernels = self._robot.fk(q, self.frames, threads=1)  # `threads` excludes Pinocchio
            tally.add(_pose_difference(kernels, direct), first, self.frames)
        self._steps.add(direct, q, first)
        for axis, tally in self._elementary.items():
            tally.compare(first, n, joint_names, self._elementary_difference, axis, q.ravel())
        return T

    def _elementary_difference(self, axis: str, angles: Floats) -> Floats:
        ours = getattr(self._conversions, f"rot_{axis}")(angles)
        return difference(ours, turns_about(_AXES[axis], angles))


class _Reader:
    """Another reader of the robot's file, for the `frames` that the compared poses have in their `columns`."""

    def __init__(self, oracle: Oracle | PinocchioOracle, column: Mapping[str, int]) -> None:
        self._oracle = oracle
        self.frames = tuple(name for name in oracle.frames if name in column)
        self.columns = [column[name] for name in self.frames]
        self._chosen = [oracle.frames.index(name) for name in self.frames]

    def poses(self, q: Floats) -> Floats:
        """Return T_root_frame of its frames, shape (n, frames, 4, 4)."""
        return self._oracle.poses(q)[:, self._chosen]


def _pinocchio_poses(robot: RobotModel, frames: Sequence[str], q: Floats) -> Floats:
    """Return T_root_frame by Pinocchio itself, shape (n, frames, 4, 4), for configurations of shape (n, nq)."""
    model, data, ids = robot.model, robot.model.createData(), dict[str, int]()
    for index, frame in enumerate(model.frames):
        if frame.type == pin.FrameType.BODY or frame.name not in ids:
            ids[frame.name] = index
    T = np.empty((len(q), len(frames), 4, 4))
    # A name that the file gives to a link and to a joint means the link, which has another name in the model.
    places = [ids[robot.tree.shared_names.get(name, name)] for name in frames]
    for row, configuration in zip(T, q, strict=True):
        pin.framesForwardKinematics(model, data, configuration)
        for pose, place in zip(row, places, strict=True):
            pose[:] = data.oMf[place].homogeneous
    return T


class _StepChecks:
    """The rows about single steps: the pose of a frame in its parent frame, and the motion of its joint.

    A wrong step moves everything behind it; only the rows of the step itself identify it. The motion M of a joint is
    the pose of its frame relative to the pose at zero. A rotation by v about e has vect M = sin v e and (tr M − 1)/2 =
    cos v; a translation has the displacement v e. The amount and the axis of the motion have a row each.
    """

    def __init__(self, robot: RobotModel, by_hand: StepKinematics, frames: Sequence[str]) -> None:
        self._by_hand = by_hand
        self._column = {name: i for i, name in enumerate(frames)}
        steps = [step for step in by_hand.steps if step.name in self._column and step.parent in self._column]
        moving = [step for step in steps if step.axis is not None]
        self._own = [step for step in moving if step.name in robot.joint_names]
        self._followers = [step for step in moving if step.name not in robot.joint_names]
        self._wrong_travel: set[str] = set()
        self._axis = Tally("axis and sense of a joint", "Pinocchio")
        self._travel = Tally("travel of a joint", "Pinocchio")
        self._coupled = Tally("travel of a coupled joint", "Pinocchio")
        position = Tally("position in the parent frame", "Pinocchio")
        orientation = Tally("orientation in the parent frame", "Pinocchio")
        self._places = [position, orientation] if steps else []

        zero = robot.neutral()[None]
        T_zero = robot.fk(zero, frames)
        self._zero = {step.name: self._relative(T_zero, step) for step in steps}
        for step in steps:
            R_zero, p_zero = self._zero[step.name]
            position.compare(0, 1, [step.name], _farthest, by_hand.position, step, zero, p_zero)
            orientation.compare(0, 1, [step.name], _farthest, by_hand.rotation, step, zero, R_zero)

    @property
    def tallies(self) -> list[Tally]:
        """The rows, without those of a kind of joint that the robot lacks."""
        axes = [self._axis] if self._own or self._followers else []
        travels = [*([self._travel] if self._own else []), *([self._coupled] if self._followers else [])]
        return [*self._places, *axes, *travels]

    def add(self, T: Floats, q: Floats, first: int) -> None:
        """Compare the poses T (n, frames, 4, 4) of configurations q (n, nq)."""
        for tally, joints in ((self._travel, self._own), (self._coupled, self._followers)):
            for joint in joints:
                travel, axis = self._motion_differences(joint, T, q)
                tally.add(travel[:, None], first, [joint.name])
                self._axis.add(axis[:, None], first, [joint.name])

    def _motion_differences(self, joint: Step, T: Floats, q: Floats) -> tuple[Floats, Floats]:
        """Return the errors of one joint's travel and of its axis, two arrays (n,)."""
        (R, p), (R_zero, p_zero) = self._relative(T, joint), self._zero[joint.name]
        value = self._by_hand.value(joint, q) - (joint.mimic.offset if joint.mimic else 0.0)
        if joint.sliding:
            vector, sine = (p - p_zero) @ R_zero[0], value
            turned = np.zeros(len(q))
        else:
            M = np.swapaxes(R_zero, -1, -2) @ R
            vector, sine = _vect(M), np.sin(value)
            turned = np.abs(0.5 * (np.trace(M, axis1=-2, axis2=-1) - 1.0) - np.cos(value))
        length = np.sqrt(np.square(vector).sum(axis=-1))
        travel = largest(np.abs(length - np.abs(sine)), turned)
        along = length[:, None] * np.array(joint.axis)
        # The sense of a joint with a wrong travel cannot be determined.
        if (travel > TOLERANCE).any():
            self._wrong_travel.add(joint.name)
        if joint.name in self._wrong_travel:
            axis = np.minimum(np.abs(vector - along).max(axis=-1), np.abs(vector + along).max(axis=-1))
        else:
            axis = np.abs(vector - np.sign(sine)[:, None] * along).max(axis=-1)
        return travel, np.asarray(axis)

    def _relative(self, T: Floats, step: Step) -> tuple[Floats, Floats]:
        """Return rotations (n, 3, 3) and origins (n, 3) of a step in its parent frame."""
        T_frame, T_parent = T[:, self._column[step.name]], T[:, self._column[str(step.parent)]]
        R_parent_transposed = np.swapaxes(T_parent[:, :3, :3], -1, -2)
        offset = (T_frame - T_parent)[:, :3, 3, None]
        return R_parent_transposed @ T_frame[:, :3, :3], (R_parent_transposed @ offset)[..., 0]


class JacobianChecks:
    """One row for each way to express a Jacobian: its columns are the axes' Plücker coordinates."""

    def __init__(self, robot: RobotModel, conversions: Conversions, frames: Sequence[str]) -> None:
        self._robot, self._conversions, self._frames = robot, conversions, frames
        note = "each frame at one configuration in a hundred"
        ways = _EXPRESSIONS if robot.joint_names else ()
        self._tallies = {way: Tally(f"joint axes as lines, {way}", "Pinocchio", note=note) for way in ways}

    @property
    def tallies(self) -> list[Tally]:
        """The rows; none without joints."""
        return list(self._tallies.values())

    def add(self, q: Floats, first: int) -> None:
        """Compare every frame at one of the configurations (n, nq), another one for each frame."""
        for way, tally in self._tallies.items():
            errors = np.full((len(q), len(self._frames)), LEFT_OUT)
            for column, frame in enumerate(self._frames):
                row = (first + column) % len(q)
                try:
                    errors[row, column] = self._difference(q[row], frame, way)
                except Exception as error:  # raised by the joint axes under test
                    tally.refuse(error)
                    errors[row, column] = np.inf
            tally.add(errors, first, self._frames)

    def _difference(self, q: Floats, frame: str, way: Literal["frame", "root", "mixed"]) -> float:
        ours = np.asarray(self._axes.jacobian(q, frame, expressed_in=way))
        return float(difference(ours[None], self._robot.jacobian(q, frame, expressed_in=way)[None])[0])

    @functools.cached_property
    def _axes(self) -> Any:
        return self._conversions.joint_axes(self._robot)


def _farthest(by_hand: Callable[[Step, Floats], Floats], step: Step, zero: Floats, theirs: Floats) -> Floats:
    """Return the largest difference of any entry of a step at zero."""
    return np.asarray(np.abs(by_hand(step, zero) - theirs).max())


def _pose_difference(ours: Floats, theirs: Floats) -> Floats:
    """Return the largest difference of any entry of poses (n, m, 4, 4), shape (n, m)."""
    return np.asarray(np.abs(ours - theirs).max(axis=(2, 3), initial=0.0))


def _vect(M: Floats) -> Floats:
    """Return the vector of the antisymmetric part, (m32 − m23, m13 − m31, m21 − m12)/2."""
    return 0.5 * np.stack(
        [M[..., 2, 1] - M[..., 1, 2], M[..., 0, 2] - M[..., 2, 0], M[..., 1, 0] - M[..., 0, 1]], axis=-1
    )


# --- Limits and mimics against two other readings of the robot's URDF, and its checks against a scalar formula.
#
# The limits of a driving joint contain the values at which it, and all joints that mimic it, are inside their own
# limits. They are computed here again, from the results of the other parsers.

# A value that exceeds a limit by less than this is on the limit, as defined by the library.
_ON_THE_LIMIT = 1e-6


class LimitChecks:
    """The rows about limits and mimics."""

    def __init__(self, robot: RobotModel, second: Oracle, parsed: PinocchioOracle | None, unparsed: str) -> None:
        self._robot, self._second = robot, second
        self._tables = robot.coupled_limits
        self._fixed: list[Tally] = []
        for reader in (second, parsed):
            if reader is not None:
                self._compare_limits(reader.name, reader.joints, unparsed)
        self._compare_mimics(second.joints)
        self._violations = Tally("limit_violations", "scalar formula")
        self._clamped = Tally("clamp", "scalar formula")

    @property
    def tallies(self) -> list[Tally]:
        """The rows; none without joints."""
        return [*self._fixed, self._violations, self._clamped] if self._robot.joint_names else []

    def add(self, q: Floats, first: int) -> None:
        """Compare the robot's answers about the limits of configurations (n, nq)."""
        names = self._robot.joint_names
        self._violations.compare(first, len(q), names, self._violation_differences, q)
        clamped = np.array([self._clamp(row) for row in q.tolist()])
        self._clamped.compare(first, len(q), names, lambda: np.abs(self._robot.clamp(q) - clamped))

    def _compare_limits(self, oracle: str, joints: Mapping[str, ParsedJoint], note: str) -> None:
        names = self._robot.joint_names
        expected = [_shared_limits(name, joints) for name in names]
        ours = (self._robot.lower, self._robot.upper, self._robot.velocity_limits, self._robot.effort_limits)
        for index, kind in enumerate(("lower", "upper", "velocity", "effort")):
            if kind in self._second.kinds:
                errors = [
                    _distance(float(mine), limits[index]) for mine, limits in zip(ours[index], expected, strict=True)
                ]
                self._add_row(f"{kind} limits", oracle, errors, names, note)

    def _compare_mimics(self, joints: Mapping[str, ParsedJoint]) -> None:
        mimics, own = self._robot.mimics, self._robot.joint_names
        # Without those that follow a fixed joint, and so are fixed themselves.
        names = sorted(n for n in joints if n in mimics or (n not in own and driver_of(n, joints)[0] in joints))
        if not names:
            return
        errors = []
        for name in names:
            mimic = self._robot.mimics.get(name)
            expected = mimic and _relation(name, mimic.joint, joints)
            ours = mimic and (mimic.multiplier, mimic.offset)
            errors.append(max(map(_distance, ours, expected)) if ours and expected else math.inf)
        self._add_row("mimics", self._second.name, errors, names)

    def _add_row(self, convention: str, oracle: str, errors: list[float], names: Sequence[str], note: str = "") -> None:
        self._fixed.append(Tally(convention, oracle, note=note))
        self._fixed[-1].add(np.array([errors]), 0, names)

    def _violation_differences(self, q: Floats) -> Floats:
        """Return differences of the ranges that each joint is outside; infinite if only one side finds it outside."""
        column = {name: index for index, name in enumerate(self._robot.joint_names)}
        found = {(v.index[0], column[v.joint]): (v.lower, v.upper) for v in self._robot.limit_violations(q)}
        errors = np.zeros(q.shape)
        for row, values in enumerate(q.tolist()):
            for index in range(len(values)):
                ours, theirs = found.get((row, index)), self._violated(values, index)
                if ours is not None or theirs is not None:
                    errors[row, index] = max(map(_distance, ours, theirs)) if ours and theirs else math.inf
        return errors

    def _violated(self, values: Sequence[float], index: int) -> tuple[float, float] | None:
        """Return the range that one joint is outside: the box, or inside it the table; None inside both."""
        tables = [table for table in self._tables if table.joint == self._robot.joint_names[index]]
        for lower, upper in (self._box(index), *(self._table_range(table, values) for table in tables)):
            if values[index] < lower - _ON_THE_LIMIT or values[index] > upper + _ON_THE_LIMIT:
                return lower, upper
        return None

    def _clamp(self, values: list[float]) -> list[float]:
        """Return every joint clamped to its box, then to its table at the clamped value of the other joint."""
        inside = [_between(value, *self._box(index)) for index, value in enumerate(values)]
        for table in self._tables:
            index = self._robot.joint_names.index(table.joint)
            inside[index] = _between(_between(inside[index], *self._table_range(table, inside)), *self._box(index))
        return inside

    def _box(self, index: int) -> tuple[float, float]:
        return float(self._robot.lower[index]), float(self._robot.upper[index])

    def _table_range(self, table: CoupledLimit, values: Sequence[float]) -> tuple[float, float]:
        """Return the range at a value of the other joint: linear between rows of the table, constant outside."""
        value = values[self._robot.joint_names.index(table.of)]
        if value <= table.at[0]:
            return table.lower[0], table.upper[0]
        for i in range(1, len(table.at)):
            if value <= table.at[i]:
                part = (value - table.at[i - 1]) / (table.at[i] - table.at[i - 1])
                low, high = ((1.0 - part) * ends[i - 1] + part * ends[i] for ends in (table.lower, table.upper))
                return low, high
        return table.lower[-1], table.upper[-1]


def _shared_limits(driver: str, joints: Mapping[str, ParsedJoint]) -> tuple[float, float, float, float]:
    """Return lower, upper, velocity and effort of a driving joint and of all its followers.

    Limits that were copied from joint to joint may leave at most one value to joints that can all move; then the
    driving joint's own range is used.
    """
    own_low, own_high, own_velocity = _own_bounds(joints[driver])
    lower, upper, velocity, can_move = [own_low], [own_high], [own_velocity], own_low < own_high
    for name, joint in joints.items():
        relation = _relation(name, driver, joints) if name != driver else None
        if relation is not None and relation[0] != 0.0:
            multiplier, offset = relation
            *bounds, own_speed = _own_bounds(joint)
            low, high = sorted((bound - offset) / multiplier for bound in bounds)
            lower.append(low)
            upper.append(high)
            velocity.append(own_speed / abs(multiplier))
            can_move = can_move and bounds[0] < bounds[1]
    low, high = _tightest(lower, max), _tightest(upper, min)
    if low >= high and can_move:
        low, high = own_low, own_high
    effort = joints[driver].effort
    return low, high, _tightest(velocity, min), math.inf if effort is None or effort < 0.0 else effort


def _own_bounds(joint: ParsedJoint) -> tuple[float, float, float]:
    """Return lower, upper and velocity of one joint: infinite where the file has none, velocity 0 or swapped ends."""
    velocity = math.inf if joint.velocity is None or joint.velocity <= 0.0 else joint.velocity
    lower, upper = joint.lower or 0.0, joint.upper or 0.0
    if joint.continuous or (joint.lower is None and joint.upper is None) or lower > upper:
        return -math.inf, math.inf, velocity
    return lower, upper, velocity


def _relation(name: str, driver: str, joints: Mapping[str, ParsedJoint]) -> tuple[float, float] | None:
    """Return (multiplier, offset) with value of `name` = multiplier · value of `driver` + offset; None without one."""
    (root, m, b), (other_root, m_driver, b_driver) = driver_of(name, joints), driver_of(driver, joints)
    if root != other_root or m_driver == 0.0:
        return None
    return m / m_driver, b - m / m_driver * b_driver


def _tightest(bounds: Sequence[float], choose: Callable[[Sequence[float]], float]) -> float:
    """Return the tightest bound; if several differ only by rounding, the first of them."""
    tightest = choose(bounds)
    return next(
        bound for bound in bounds if bound == tightest or math.isclose(bound, tightest, rel_tol=1e-9, abs_tol=1e-12)
    )


def _between(value: float, lower: float, upper: float) -> float:
    return min(max(value, lower), upper)


def _distance(ours: float, theirs: float) -> float:
    """Return |ours − theirs|, zero for equal infinities."""
    return 0.0 if ours == theirs else abs(ours - theirs)
