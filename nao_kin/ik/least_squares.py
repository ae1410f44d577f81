"""Damped least squares for the pose of one frame or of several, as scalar code.

With the target (R_t, p_t) and the pose (R, p) of each frame, it minimises ½‖e‖² with e = w · (R_tᵀ (p_t − p);
log(Rᵀ R_t)) and its exact derivative ∂e/∂q = −w · (R_tᵀ J_v; J_l⁻¹(log(Rᵀ R_t)) Rᵀ J_ω).

A step solves (JᵀJ + λ 1) δ = −Jᵀe in the directions that the limits leave free, with λ proportional to ‖e‖² (quadratic
convergence also for singular J). It is then shortened to 1 rad, and projected onto the limits; joints that the
projection moves are held, and the step of the others is computed again. λ follows the ratio of
the actual decrease to the decrease predicted by the linear model.

Source: Sugihara, Solvability-unconcerned inverse kinematics by the Levenberg–Marquardt method, IEEE T-RO 2011; Nielsen,
Damping parameter in Marquardt's method, IMM-REP-1999-05; Barfoot, State Estimation for Robotics, 7.1.5 (J_l⁻¹).
"""

from __future__ import annotations

import math
import weakref
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats, join_poses
from nao_kin._core.text import quoted
from nao_kin._kernels.cache import CachedKernel, Floats2, Row, both_ways
from nao_kin._kernels.chains import SMALL_ANGLE, Chain, chain_of, rotation_vector, to_frame
from nao_kin._kernels.rows import copied, in_lists, run_rows
from nao_kin.errors import BadArgument
from nao_kin.ik.branches import MAX_TURNED, Rotation
from nao_kin.ik.closed_form import Limb, cached_limb, torso_in_trunk
from nao_kin.ik.limit_regions import TABLE, LimitRegion, Region, nearest_corner, open_directions, project
from nao_kin.ik.quadratic_program import cholesky, solve_cholesky
from nao_kin.ik.targets import Options
from nao_kin.robot import Expression, RobotModel, serial_chain
from nao_kin.rotations import matrix_from_quat, nearest_rotation, quat_from_xyzw

# Initial damping as a share of the squared error; it grows after a rejected step, and shrinks after an accepted one.
FIRST_DAMPING = 0.1
MIN_DAMPING, MAX_DAMPING = 1e-6, 1e12
# A step is rejected if it decreases the error by a smaller share than this of the decrease in the linear model.
MIN_GAIN = 1e-3
# Largest change of a joint in one step [rad or m]: the linear model does not hold beyond.
MAX_STEP = 1.0
# A slope is flat if it is a smaller share than this of the steepest possible slope; where the result of one search is
# the answer, with the most steps of that search.
FLAT = 1e-7
_PRECISE, _LAST_STEPS = 1e-9, 1000
# Largest number of times that a step is computed again because it leaves the limits; largest rounding of a step
# [rad or m].
MAX_HOLDS, ROUNDING = 4, 1e-14
# A floor against rounding keeps the linear system regular when damping vanishes with the error.
_FLOOR, _TINY = 1e-15, 1e-300

# Indices in the report of a start: half the squared error, whether the target is met, whether no direction decreases
# the error any more, and the errors of position and angle in the components with a weight.
COST, MET, SETTLED, POSITION, ANGLE = range(5)


class Goal(NamedTuple):
    """The goal of a search for joint values."""

    weights: Row  # of the six errors of each frame
    tolerance: float  # of position and angle [m, rad]
    steps: int  # largest number of steps
    directed: bool = False  # whether only the direction of the frame's x axis counts, not the rotation about it
    flat: float = FLAT  # share of the steepest possible slope below which the search ends


class Scratch(NamedTuple):
    """Working memory of a step."""

    T: Row
    axes: Row
    origins: Row
    e: Row
    e_ahead: Row
    turn: Row
    J: Row
    J_ahead: Row
    J_open: Row
    wanted: Row
    ahead: Row
    inside: Row
    is_open: Row
    along: Row
    step: Row
    normal: Row
    right: Row


@both_ways
def new_scratch(frames: int, joints: int, moving: int, tables: int) -> Scratch:
    """Allocate the working memory of a step; in the kernel, so that the compiler knows that no arrays overlap."""
    rows = 6 * frames
    size = min(rows, moving)
    return Scratch(
        np.empty(12), np.empty(3 * joints), np.empty(3 * joints), np.empty(rows), np.empty(rows), np.empty(3),
        np.empty(rows * moving), np.empty(rows * moving), np.empty(rows * moving), np.empty(moving), np.empty(moving),
        np.empty(moving), np.empty(moving), np.empty(2 * max(1, tables)), np.empty(moving), np.empty(size * size),
        np.empty(size),
    )  # fmt: skip


@both_ways
def descend(
    chain: Chain, region: Region, goal: Goal, scratch: Scratch, target: Row, fixed: Row, values: Row, report: Row
) -> None:
    """Search from `values`, which are inside the limits; write the end into `values` and `report`."""
    m, rows = len(region.lower), len(scratch.e)
    cost = errors_at(chain, goal, target, values, scratch, scratch.e, scratch.J)
    damping, growth, settled = FIRST_DAMPING, 2.0, False
    met = is_met(goal, scratch.e)
    for _ in range(goal.steps):
        if met or settled:
            break
        for j in range(m):
            slope = 0.0
            for i in range(rows):
                slope += scratch.J[i * m + j] * scratch.e[i]
            scratch.wanted[j] = -slope
        restrict(region, values, fixed, scratch)
        # If the open directions gain no more than rounding, this is a minimum inside the limits.
        slopes, squares = 0.0, 0.0
        for j in range(m):
            slope = 0.0
            for i in range(rows):
                slope += scratch.J_open[i * m + j] * scratch.e[i]
                squares += scratch.J[i * m + j] * scratch.J[i * m + j]
            slopes += slope * slope
        settled = slopes <= goal.flat * goal.flat * squares * 2.0 * cost
        step_inside(region, values, fixed, 2.0 * damping * cost, scratch)
        # If the projection has changed the step, the model predicts the decrease of the changed step.
        promised = 0.0
        for i in range(rows):
            change = 0.0
            for j in range(m):
                change += scratch.J[i * m + j] * (scratch.inside[j] - values[j])
            promised -= scratch.e[i] * change + 0.5 * change * change
        cost_ahead = errors_at(chain, goal, target, scratch.inside, scratch, scratch.e_ahead, scratch.J_ahead)
        gain = (cost - cost_ahead) / promised if promised > 0.0 else 0.0
        if cost_ahead < cost and gain > MIN_GAIN:
            steeper = 2.0 * min(max(gain, 0.0), 2.0) - 1.0
            damping *= max(1.0 / 3.0, 1.0 - steeper * steeper * steeper)
            growth = 2.0
            for j in range(m):
                values[j] = scratch.inside[j]
                if region.winding[j] != 0.0:
                    values[j] -= 2.0 * math.pi * math.floor(values[j] / (2.0 * math.pi) + 0.5)
            for i in range(rows):
                scratch.e[i] = scratch.e_ahead[i]
            for i in range(rows * m):
                scratch.J[i] = scratch.J_ahead[i]
            cost = cost_ahead
            met = is_met(goal, scratch.e)
        else:
            damping *= growth
            growth *= 2.0
        damping = min(max(damping, MIN_DAMPING), MAX_DAMPING)
        settled = settled or damping >= MAX_DAMPING
    report[COST], report[MET], report[SETTLED] = cost, 1.0 if met else 0.0, 1.0 if settled else 0.0
    report[POSITION], report[ANGLE] = unweighted_errors(goal, scratch.e)


@both_ways
def is_met(goal: Goal, e: Row) -> bool:
    """Return whether weighted errors are within the tolerance."""
    position, angle = unweighted_errors(goal, e)
    return position <= goal.tolerance and angle <= goal.tolerance


@both_ways
def unweighted_errors(goal: Goal, e: Row) -> tuple[float, float]:
    """Return errors of position and angle in the components with a weight [m, rad], from weighted ones."""
    position, angle = 0.0, 0.0
    for first in range(0, len(e), 6):
        for i in range(3):
            if goal.weights[i] != 0.0:
                position += (e[first + i] / goal.weights[i]) * (e[first + i] / goal.weights[i])
            if goal.weights[3 + i] != 0.0:
                angle += (e[first + 3 + i] / goal.weights[3 + i]) * (e[first + 3 + i] / goal.weights[3 + i])
    return math.sqrt(position), math.sqrt(angle)


@both_ways
def errors_at(chain: Chain, goal: Goal, target: Row, values: Row, scratch: Scratch, e: Row, J: Row) -> float:
    """Write weighted errors (6 per frame) and their derivatives (.., m) at joint values; return half their square."""
    first, m, cost = 0, len(values), 0.0
    for frame in range(len(chain.joints)):
        last = first + chain.joints[frame]
        to_frame(chain, values, frame, first, scratch)
        T, at, row = scratch.T, 16 * frame, 6 * frame
        dx, dy, dz = target[at + 3] - T[3], target[at + 7] - T[7], target[at + 11] - T[11]
        for i in range(at, at + 3):
            e[row + i - at] = goal.weights[i - at] * (target[i] * dx + target[4 + i] * dy + target[8 + i] * dz)
        if goal.directed:
            direction_error(T, target, at, scratch.turn)
        else:
            rotation_error(T, target, at, scratch.turn)
        for i in range(3):
            e[row + 3 + i] = goal.weights[3 + i] * scratch.turn[i]
        for i in range(row, row + 6):
            cost += 0.5 * e[i] * e[i]
        if goal.directed:  # a turn about the direction does not change it
            for i in range(3):
                scratch.turn[i] = 0.0
        derivative(chain, goal, target, scratch, J, m, frame, first, last)
        first = last
    return cost


@both_ways
def derivative(
    chain: Chain, goal: Goal, target: Row, scratch: Scratch, J: Row, m: int, frame: int, first: int, last: int
) -> None:
    """Write ∂e/∂q of a frame whose pose is in the scratch into J."""
    T, turn, w, origins = scratch.T, scratch.turn, goal.weights, scratch.origins
    at, row = 16 * frame, 6 * frame * m
    u, v, z = turn[0], turn[1], turn[2]
    square = u * u + v * v + z * z
    angle = math.sqrt(square)
    # `inverse_jacobian_factor`, written out: a call slows down the whole search by 5 %.
    c = 1.0 / 12.0 + square / 720.0
    if angle > SMALL_ANGLE:
        c = (1.0 - 0.5 * angle * math.cos(0.5 * angle) / math.sin(0.5 * angle)) / square
    for i in range(row, row + 6 * m):
        J[i] = 0.0
    for k in range(first, last):
        j = chain.place[k]
        if j < 0:
            continue
        ratio = chain.ratio[k]
        ax, ay, az = ratio * scratch.axes[3 * k], ratio * scratch.axes[3 * k + 1], ratio * scratch.axes[3 * k + 2]
        j += row
        if chain.slides[k] != 0.0:
            vx, vy, vz = ax, ay, az
        else:
            rx, ry, rz = T[3] - origins[3 * k], T[7] - origins[3 * k + 1], T[11] - origins[3 * k + 2]
            vx, vy, vz = ay * rz - az * ry, az * rx - ax * rz, ax * ry - ay * rx
            # The axis in the frame, Rᵀ a, and J_l⁻¹ times it.
            bx = T[0] * ax + T[4] * ay + T[8] * az
            by = T[1] * ax + T[5] * ay + T[9] * az
            bz = T[2] * ax + T[6] * ay + T[10] * az
            cx, cy, cz = v * bz - z * by, z * bx - u * bz, u * by - v * bx
            dx, dy, dz = v * cz - z * cy, z * cx - u * cz, u * cy - v * cx
            J[3 * m + j] -= w[3] * (bx - 0.5 * cx + c * dx)
            J[4 * m + j] -= w[4] * (by - 0.5 * cy + c * dy)
            J[5 * m + j] -= w[5] * (bz - 0.5 * cz + c * dz)
        for i in range(3):
            J[i * m + j] -= w[i] * (target[at + i] * vx + target[at + 4 + i] * vy + target[at + 8 + i] * vz)


@both_ways
def rotation_error(T: Row, target: Row, at: int, turn: Row) -> None:
    """Write log(Rᵀ R_t) of 3×4 transforms, the target's from index `at` on, into `turn`."""
    r00, r01, r02, r10, r11, r12 = T[0], T[1], T[2], T[4], T[5], T[6]
    r20, r21, r22 = T[8], T[9], T[10]
    a0, a1, a2 = target[at], target[at + 1], target[at + 2]
    b0, b1, b2 = target[at + 4], target[at + 5], target[at + 6]
    c0, c1, c2 = target[at + 8], target[at + 9], target[at + 10]
    turn[0], turn[1], turn[2] = rotation_vector(
        r00 * a0 + r10 * b0 + r20 * c0, r00 * a1 + r10 * b1 + r20 * c1, r00 * a2 + r10 * b2 + r20 * c2,
        r01 * a0 + r11 * b0 + r21 * c0, r01 * a1 + r11 * b1 + r21 * c1, r01 * a2 + r11 * b2 + r21 * c2,
        r02 * a0 + r12 * b0 + r22 * c0, r02 * a1 + r12 * b1 + r22 * c1, r02 * a2 + r12 * b2 + r22 * c2,
    )  # fmt: skip


@both_ways
def direction_error(T: Row, target: Row, at: int, turn: Row) -> None:
    """Write the rotation vector, in the frame's axes, from the frame's x axis to the target's into `turn`."""
    x, y, z = target[at], target[at + 4], target[at + 8]
    along, across = T[0] * x + T[4] * y + T[8] * z, T[1] * x + T[5] * y + T[9] * z
    up = T[2] * x + T[6] * y + T[10] * z
    sine = math.sqrt(across * across + up * up)
    angle = math.atan2(sine, along)
    turn[0], turn[1], turn[2] = 0.0, angle, 0.0
    if sine > 1e-14:
        turn[1], turn[2] = -angle * up / sine, angle * across / sine


@both_ways
def restrict(region: Region, values: Row, fixed: Row, scratch: Scratch) -> None:
    """Write the derivative along the directions that the limits leave open into `J_open`."""
    m, rows = len(region.lower), len(scratch.e)
    for i in range(rows * m):
        scratch.J_open[i] = scratch.J[i]
    wanted, ahead, inside, is_open = scratch.wanted, scratch.ahead, scratch.inside, scratch.is_open
    if open_directions(region, values, fixed, wanted, ahead, inside, is_open, scratch.along):
        return
    for i in range(rows):
        for j in range(m):
            scratch.J_open[i * m + j] *= is_open[j]
    for t in range(len(region.tables) // TABLE):
        x, y = scratch.along[2 * t], scratch.along[2 * t + 1]
        if x <= 1.0:
            of, joint = region.tables[TABLE * t], region.tables[TABLE * t + 1]
            for i in range(rows):
                part = scratch.J_open[i * m + of] * x + scratch.J_open[i * m + joint] * y
                scratch.J_open[i * m + of], scratch.J_open[i * m + joint] = part * x, part * y


@both_ways
def step_inside(region: Region, values: Row, fixed: Row, damping: float, scratch: Scratch) -> None:
    """Write the joint values after a damped step into `inside`.

    Projecting a step that leaves the limits changes it to one that need not decrease the error. So the joints that the
    projection moves are held where it puts them, and the step of the others is computed again.
    """
    m, rows = len(values), len(scratch.e)
    held, step, ahead, e = scratch.wanted, scratch.step, scratch.ahead, scratch.e_ahead
    for j in range(m):
        held[j] = 0.0
    for count in range(MAX_HOLDS + 1):
        for i in range(rows):
            e[i] = scratch.e[i]
            for j in range(m):
                e[i] += scratch.J[i * m + j] * held[j]
        damped_step(m, damping, e, scratch)
        longest = 0.0
        for j in range(m):
            step[j] += held[j]
            longest = max(longest, abs(step[j]))
        shorter = max(1.0, longest / MAX_STEP)
        for j in range(m):
            ahead[j] = values[j] + step[j] / shorter
        project(region, ahead, fixed, scratch.inside)
        if count == MAX_HOLDS or not hold(region, values, held, scratch):
            break


@both_ways
def hold(region: Region, values: Row, held: Row, scratch: Scratch) -> bool:
    """Hold the joints that the projection has moved, a pair on the edge of its table; return whether there are any."""
    m, rows, found = len(values), len(scratch.e), False
    for j in range(m):
        scratch.is_open[j] = 1.0
        if abs(scratch.inside[j] - scratch.ahead[j]) > ROUNDING:
            found, scratch.is_open[j] = True, 0.0
    if not found:
        return False
    for t in range(len(region.tables) // TABLE):
        of, joint = region.tables[TABLE * t], region.tables[TABLE * t + 1]
        if of < 0 or joint < 0 or scratch.is_open[of] * scratch.is_open[joint] == 1.0:
            continue
        if held[of] != 0.0 or held[joint] != 0.0:
            # The step went beyond the end of an edge: the next one begins at the corner, if it is so near.
            x, y = nearest_corner(region, t, scratch.inside[of], scratch.inside[joint])
            if max(abs(x - values[of]), abs(y - values[joint])) <= max(abs(scratch.step[of]), abs(scratch.step[joint])):
                scratch.inside[of], scratch.inside[joint] = x, y
            scratch.is_open[of] = scratch.is_open[joint] = 0.0
            continue
        # Along the edge, perpendicular to the displacement by the projection.
        x, y = scratch.ahead[joint] - scratch.inside[joint], scratch.inside[of] - scratch.ahead[of]
        length = math.sqrt(x * x + y * y)
        x, y = x / length, y / length
        scratch.is_open[of] = scratch.is_open[joint] = 1.0
        held[of], held[joint] = scratch.inside[of] - values[of], scratch.inside[joint] - values[joint]
        for i in range(rows):
            part = scratch.J[i * m + of] * x + scratch.J[i * m + joint] * y
            scratch.J_open[i * m + of], scratch.J_open[i * m + joint] = part * x, part * y
    for j in range(m):
        if scratch.is_open[j] == 0.0:
            held[j] = scratch.inside[j] - values[j]
            for i in range(rows):
                scratch.J_open[i * m + j] = 0.0
    return True


@both_ways
def damped_step(m: int, damping: float, e: Row, scratch: Scratch) -> None:
    """Write −(JᵀJ + λ 1)⁻¹ Jᵀe = −Jᵀ (J Jᵀ + λ 1)⁻¹ e for the open directions, by the smaller of the two systems."""
    J, N, y = scratch.J_open, scratch.normal, scratch.right
    rows = len(e)
    size = min(rows, m)
    trace = 0.0
    for a in range(size):
        for b in range(a + 1):
            total = 0.0
            if m <= rows:
                for i in range(rows):
                    total += J[i * m + a] * J[i * m + b]
            else:
                for j in range(m):
                    total += J[a * m + j] * J[b * m + j]
            N[a * size + b] = total
        trace += N[a * size + a]
        y[a] = 0.0
        if m <= rows:
            for i in range(rows):
                y[a] += J[i * m + a] * e[i]
        else:
            y[a] = e[a]
    floor = _FLOOR * trace + _TINY
    for a in range(size):
        N[a * size + a] += damping + floor
    cholesky(N, size, size, floor)
    solve_cholesky(N, size, size, y)
    for j in range(m):
        if m <= rows:
            scratch.step[j] = -y[j]
        else:
            total = 0.0
            for i in range(rows):
                total += J[i * m + j] * y[i]
            scratch.step[j] = -total


# --- The joints that move a frame, and searches from many starts: as Python for one, compiled for many.

# Starting a thread is worthwhile only for this many starts.
_PER_THREAD = 64


class FrameMotion:
    """The m joints of a robot that move one or several frames; all others and a floating base stay fixed."""

    def __init__(self, robot: RobotModel, *frames: str) -> None:
        # A weak reference, because this object is cached per robot.
        self._robot, self.frame = weakref.ref(robot), frames[0]
        chains = [serial_chain(robot, robot.tree.root, frame) for frame in frames]
        self.names = tuple(dict.fromkeys(name for chain in chains for name in chain.coordinates))
        if not self.names:
            raise BadArgument(f"no joint moves {quoted(self.frame)}")
        # Indices in `RobotModel.joint_names`, from the base outwards.
        self.joints = np.array([robot.joint_names.index(name) for name in self.names], dtype=np.intp)
        self.units = tuple(robot.joint_units[index] for index in self.joints)
        self._offset = robot.nq_base
        self.columns = self._offset + self.joints  # indices in q
        self.velocity_columns = robot.nv - len(robot.joint_names) + self.joints  # in velocities
        self.chain = chain_of(chains, self.names)  # the joints from the base to each frame, for scalar code
        self.length = chains[0].length(robot)  # of the stretched chain from the first joint to the frame [m]
        self.limited, self.free = LimitRegion(robot, self.joints), LimitRegion(robot, self.joints, enforced=False)
        self.start = robot.clamp(robot.neutral())  # all joints at zero, or at the limit nearest to it

    @property
    def robot(self) -> RobotModel:
        """The robot, to which the caller keeps a reference."""
        return cast(RobotModel, self._robot())

    def joint_values(self, q: Floats) -> Floats:
        """Return a view of the values of all joints, shape (n, joints)."""
        return q[:, self._offset :]

    def poses(self, q: Floats) -> Floats:
        """Return T_root_frame, shape (n, 4, 4)."""
        return np.asarray(self.robot.fk(q, self.frame))

    def jacobians(self, q: Floats, expressed_in: Expression = "mixed") -> Floats:
        """Return the Jacobian of the frame for the joints that move it, shape (n, 6, m)."""
        if len(q) == 1:  # with fewer steps
            return np.asarray(self.robot.jacobian(q[0], self.frame, expressed_in)[None, :, self.velocity_columns])
        return np.asarray(self.robot.jacobian(q, self.frame, expressed_in)[..., self.velocity_columns])

    def in_base(self, poses: Floats, q: Floats) -> Floats:
        """Return T_base_frame from T_root_frame, shape (n, 4, 4); both are equal with a fixed base."""
        if self.robot.base == "fixed":
            return poses
        R = matrix_from_quat(quat_from_xyzw(q[:, 3:7])).swapaxes(-1, -2)
        moved: Floats = poses.copy()
        moved[:, :3, :3] = R @ poses[:, :3, :3]
        moved[:, :3, 3] = np.einsum("nij,nj->ni", R, poses[:, :3, 3] - q[:, :3])
        return moved

    def beyond(self, poses: Floats, q: Floats) -> Floats:
        """Return the distance of poses (n, 4, 4) from the first joint minus the chain's length, shape (n,) [m]."""
        first_joint = self.chain.links[3:12:4]
        return np.asarray(np.linalg.norm(self.in_base(poses, q)[:, :3, 3] - first_joint, axis=-1) - self.length)


@dataclass(frozen=True, eq=False)
class Minimum:
    """Results of n searches."""

    q: Floats  # configurations, shape (n, nq), or the values of the joints that move, shape (n, m)
    cost: Floats  # half the squared weighted error, shape (n,)
    residual: Floats  # errors of position and angle in the components with a weight, shape (n, 2) [m, rad]
    reached: NDArray[np.bool_]  # the residual is within the tolerance
    settled: NDArray[np.bool_]  # no direction inside the limits decreases the error any more

    def take(self, rows: NDArray[np.intp], other: Minimum, part: slice) -> None:
        """Replace the results of these rows by those of other searches that succeed first, or end nearer."""
        better = ~self.reached[rows] & (other.reached[part] | (other.cost[part] < self.cost[rows]))
        for name, mine in vars(self).items():
            mine[rows[better]] = getattr(other, name)[part][better]


def descended(
    chain: Chain, region: LimitRegion, goal: Goal, targets: Floats, fixed: Floats, starts: Floats, threads: int | None
) -> Minimum:
    """Minimise ½‖e‖² from starts (n, m) inside the limits of a region; `q` of the result has shape (n, m).

    `targets` (n, 16 F) are poses of F frames in the base, `fixed` as from `LimitRegion.fixed_values`.
    """
    limits, targets = region.numbers, np.array(targets, order="C")  # a copy: kernels take no read-only arrays
    ends, reports = np.array(starts, order="C"), np.empty((len(starts), ANGLE + 1))

    def one_in_lists(part: slice) -> None:
        values, report = ends[part.start].tolist(), [0.0] * (ANGLE + 1)
        scratch = new_scratch(len(chain.joints), len(chain.place), len(values), len(limits.tables) // TABLE)
        lists = in_lists(chain), in_lists(limits), in_lists(goal), in_lists(scratch)
        descend(*lists, targets[part.start].tolist(), fixed[part.start].tolist(), values, report)
        ends[part], reports[part] = values, report

    def solve(function: Callable[..., object], part: slice) -> None:
        numbers = (chain, limits, goal) if len(starts) == 1 else (copied(chain), copied(limits), copied(goal))
        function(*numbers, targets[part], fixed[part], ends[part], reports[part])

    if len(starts) == 1 and not _descents.in_memory:
        one_in_lists(slice(0, 1))
    else:
        run_rows(_descents, solve, len(starts), threads, _PER_THREAD, one_in_lists)
    return Minimum(ends, reports[:, COST], reports[:, POSITION:], reports[:, MET] == 1.0, reports[:, SETTLED] == 1.0)


@partial(
    CachedKernel, what="a kernel of inverse kinematics, damped least squares", name="ik kernel, damped least squares"
)
def _descents(
    chain: Chain, region: Region, goal: Goal, targets: Floats2, fixed: Floats2, values: Floats2, reports: Floats2
) -> None:
    scratch = new_scratch(len(chain.joints), len(chain.place), len(region.lower), len(region.tables) // TABLE)
    for i in range(values.shape[0]):
        descend(chain, region, goal, scratch, targets[i], fixed[i], values[i], reports[i])


def descended_along(
    robot: RobotModel,
    frame: str,
    T_base_target: Floats,
    R_base_axes: Floats,
    weights: Floats,
    tolerance: float,
    steps: int,
    q: Floats,
) -> tuple[Floats, float]:
    """Return q (nq,) after a search with the joints that move a frame for its pose in a fixed base.

    Errors are along the given axes; their weighted norm is returned too. The rest is as in `Goal`.
    """
    motion = cached_limb(robot, FrameMotion, frame)
    # Errors are along the axes of the target. The frame and its target are turned equally, so that these are R's.
    links = motion.chain.links.copy()
    last = links[-12:].reshape(3, 4)
    last[:, :3] = last[:, :3] @ T_base_target[:3, :3].T @ R_base_axes
    target, fixed = join_poses(R_base_axes, T_base_target[:3, 3]).reshape(1, 16), motion.limited.fixed_values(q[None])
    goal, chain = Goal(weights, tolerance, steps), motion.chain._replace(links=links)
    found = descended(chain, motion.limited, goal, target, fixed, q[None, motion.columns], None)
    best = q.copy()
    best[motion.columns] = found.q[0]
    return best, float(np.sqrt(2.0 * found.cost[0]))


# --- The nearest joint values of a limb whose closed form has no solution, from several starts.

# The weight of one radian [m].
ANGLE_WEIGHT = 0.1
# Costs that differ by a smaller share than this are equal; its square is the cost of a target that is met [m²].
_EQUAL = 1e-7


def nearest_values(
    robot: RobotModel,
    frames: tuple[str, ...],
    limb: Limb,
    T: Floats,
    starts: list[Floats],
    options: Options,
    *,
    weight: float = ANGLE_WEIGHT,
    directed: bool = False,
    rotation: Rotation | None = None,
) -> tuple[Floats, Floats]:
    """Return coordinates (n, c) of a limb with the least Σ (distance² + (weight · angle)²) over F frames, and errors.

    T are targets in the torso, shape (n, F, 4, 4); searches begin at the reference, shape (n, nq), and at `starts`,
    each of shape (n, c). `directed` is as in `Goal`. If the `rotation` of the frame in its link is given, the targets
    are orientations of the link. The errors in position and angle have the shape (n, 2) [m, rad].
    """
    motion = cached_limb(robot, FrameMotion, *frames)
    region, chain = motion.limited if options.enforce else motion.free, motion.chain
    if rotation is not None:
        links = chain.links.copy()
        last = links[-12:].reshape(3, 4)
        last[:, :3] = last[:, :3] @ np.reshape(rotation, (3, 3)).T
        chain = chain._replace(links=links)
    n, c = len(T), len(limb.columns)
    wanted = np.array(torso_in_trunk(robot) @ T)
    wanted[..., :3, :3] = nearest_rotation(wanted[..., :3, :3])
    near = options.near[:, limb.index]
    began = np.stack([np.broadcast_to(start, (n, c)) for start in (near, *starts)])
    values = robot.neutral()[None].repeat(len(began) * n, axis=0)
    values[:, limb.index] = began.reshape(-1, c)
    values = region.project(motion.joint_values(values))
    targets = np.broadcast_to(wanted.reshape(n, -1), (len(began), n, 16 * len(frames))).reshape(len(values), -1)
    fixed, inside = region.fixed_values(values), values[:, region.moving]
    weights = np.array([1.0, 1.0, 1.0, 0.0 if directed else weight, weight, weight])
    goal = Goal(weights, 0.0, 60 if weight == 0.0 else 200, directed)
    # A single search runs as Python where nothing is compiled yet.
    parts = [slice(k, k + 1) for k in range(len(inside))] if n == 1 and not _descents.in_memory else [slice(None)]
    minima = [descended(chain, region, goal, targets[k], fixed[k], inside[k], options.threads) for k in parts]
    q, cost = (np.concatenate([getattr(part, name) for part in minima]) for name in ("q", "cost"))
    rows = _nearest_of_the_best(cost.reshape(-1, n), (q.reshape(-1, n, c) - near) * limb.multiplier, options.enforce)
    # Only the best search goes on, to a minimum that rounding does not move.
    goal = goal._replace(steps=_LAST_STEPS, flat=_PRECISE)
    last = descended(chain, region, goal, targets[rows], fixed[rows], q[rows], options.threads)
    best = last.q
    if not options.enforce:
        turns = np.round((near - best) * limb.multiplier / (2.0 * math.pi))
        best += 2.0 * math.pi / limb.multiplier * np.where(np.abs(near) > MAX_TURNED, 0.0, turns)
    return best, last.residual


def _nearest_of_the_best(cost: Floats, away: Floats, enforce: bool) -> NDArray[np.intp]:
    """Return, for each of n targets, the index in (s, n) of the best of s searches, by joint differences (s, n, c).

    Of searches that end with the same cost, such as those for both signs of a knee, the nearest to the reference is
    the best: rounding must not decide.
    """
    if not enforce:
        away = away - 2.0 * math.pi * np.round(away / (2.0 * math.pi))
    equal = cost <= cost.min(axis=0) * (1.0 + _EQUAL) + _EQUAL * _EQUAL
    n = cost.shape[1]
    return np.asarray(np.where(equal, np.square(away).sum(axis=-1), np.inf).argmin(axis=0) * n + np.arange(n))
