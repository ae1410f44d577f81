"""Odometry of a walking robot: the trajectory of its trunk from a log of its joints.

One sole at a time is the support: flat on the floor, and in place. Its leg carries the trunk. When the support
changes, the other sole is put flat on the floor where it is.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import LOWER, Floats, check_tolerance, join_poses, rigid_inverse, shaped
from nao_kin.errors import BadArgument, WrongShape
from nao_kin.robot import Feet, RobotModel, check_robot, named_soles, rigid_poses
from nao_kin.rotations import log, rot_z
from nao_kin.world.balance import feet_frame

# Share of the force from which the other sole becomes the support: more than half, so that the support does not switch
# back and forth while both carry the robot.
_SHARE = 0.6


@dataclass(frozen=True, eq=False)
class Odometry:
    """The trajectory of a robot's root link.

    Attributes:
        times: times of the n rows [s].
        T_world_base: pose of the root link, shape (n, 4, 4). The floor is z = 0, z points up [m].
        soles: names of the soles.
        support: index in `soles` of the sole that is in place, shape (n,).
        T_world_support: its pose, shape (n, 4, 4).
    """

    times: Floats
    T_world_base: Floats
    soles: tuple[str, ...]
    support: NDArray[np.intp]
    T_world_support: Floats


def odometry(
    robot: RobotModel,
    times: ArrayLike,
    q: ArrayLike,
    *,
    soles: Sequence[str] | None = None,
    contacts: ArrayLike | None = None,
    forces: ArrayLike | None = None,
    gyro: ArrayLike | None = None,
    start: ArrayLike | None = None,
    lower: float = LOWER,
    longest_gap: float = 0.5,
) -> Odometry:
    """Return the trajectory of the root link from a log of joint values.

    The support changes only on evidence, so that it does not switch back and forth while both soles are down:

    - with `contacts`, when the support loses contact and another sole has it;
    - with `forces`, when another sole carries more than 60 % of the total;
    - with neither, when another sole is lower than the support by more than `lower`, seen from both soles.

    With `gyro` the heading is that of the gyrometer: it integrates the angular velocity about the vertical, and the
    support turns about its origin where its leg disagrees. Roll and pitch are always those of a flat sole. Subtract the
    gyrometer's bias, as measured at rest, first.

    Args:
        robot: any robot whose semantics name soles, or for which `soles` does.
        times: of the n rows, ascending [s].
        q: configurations, shape (n, nq). The pose of a floating base in them is not used.
        soles: frames of the soles; None for those of the semantics.
        contacts: whether each of the s soles touches the floor, shape (n, s).
        forces: force on each sole, shape (n, s), or on each of the `force_sensors` of the semantics, shape (n, f), such
            as the eight of a NAO; any unit.
        gyro: angular velocity in the axes of the root link, shape (n, 3) [rad/s].
        start: pose of the root link at the first row, shape (4, 4). None for a world with its origin on the floor
            between the feet at the first row, and its x axis along theirs (`feet_frame`).
        lower: height difference that makes a lower sole the support [m].
        longest_gap: largest time between two rows [s].

    Raises:
        BadArgument: times that do not ascend or leave a gap, both contacts and forces, a robot without soles.
        WrongShape: arrays of different lengths.

    Examples:
        >>> nao = nk.load_nao()
        >>> q = np.linspace(nao.posture("StandInit"), nao.posture("Crouch"), 50)
        >>> found = nk.world.odometry(nao, 0.02 * np.arange(50), q)
        >>> found.T_world_base[[0, -1], 2, 3].round(3).tolist()
        [0.32, 0.227]
    """
    check_robot(robot)
    names = named_soles(robot, soles, needed=True)
    rows = robot.checked(q)
    if rows.ndim != 2 or not len(rows):
        raise WrongShape("q", f"(n, {robot.nq}), one configuration at least", rows.shape)
    moments = _checked_times(times, len(rows), longest_gap)
    check_tolerance(lower, "lower")
    feet = Feet.of(robot, names, or_origin=True)
    T_base_soles = feet.on_ground(np.asarray(robot.fk(rows, names, reference=robot.tree.root)))
    T_soles_base = rigid_inverse(T_base_soles)
    support = _supports(robot, feet, T_base_soles, contacts, forces, lower)
    turns = None if gyro is None else shaped(gyro, (len(rows), 3), "gyro")

    first = support[0]
    if start is None:
        frame = feet_frame(T_soles_base[0, first] @ T_base_soles[0])
        frame[2, 3] = 0.0
        T_world_sole = rigid_inverse(frame)
    else:
        T_world_sole = on_floor(rigid_poses(shaped(start, (4, 4), "start"), "start") @ T_base_soles[0, first])
    T_world_base, T_world_support = np.empty((2, len(rows), 4, 4))
    changes = [0, *(np.flatnonzero(np.diff(support)) + 1).tolist(), len(rows)]
    for begin, end in itertools.pairwise(changes):
        sole = support[begin]
        if begin:
            # The row before still belongs to the former support: where both legs agree best.
            T_world_sole = on_floor(T_world_base[begin - 1] @ T_base_soles[begin - 1, sole])
        back = max(begin - 1, 0)
        legs = T_world_sole @ T_soles_base[back:end, sole]
        placed = np.broadcast_to(T_world_sole, legs.shape)
        if turns is not None:
            heading = np.concatenate([[0.0], np.cumsum(_slips(legs, turns[back:end], np.diff(moments[back:end])))])
            slip = join_poses(rot_z(heading), np.zeros(3))
            about = join_poses(np.eye(3), T_world_sole[:3, 3])
            turned = about @ slip @ rigid_inverse(about)
            legs, placed = turned @ legs, turned @ placed
        T_world_base[begin:end], T_world_support[begin:end] = legs[begin - back :], placed[begin - back :]
        T_world_sole = placed[-1]
    T_world_support[:, 2, 3] -= feet.heights[support]
    return Odometry(moments, T_world_base, names, support, T_world_support)


def standing_sole(heights: Floats, before: int, lower: float = LOWER) -> int:
    """Return the sole on which a robot stands: `before`, unless another one is lower, also relative to its own sole.

    `heights[i, j]` is the height of sole j over the plane of sole i, shape (s, s) [m].
    """
    below = (heights[before] < -lower) & (heights[:, before] > -lower)
    return int(np.where(below, heights[before], np.inf).argmin()) if below.any() else before


def sole_heights(T_base_soles: Floats) -> Floats:
    """Return the height of sole j over the plane of sole i, shape (..., s, s), for soles at (..., s, 4, 4) [m]."""
    levers = T_base_soles[..., None, :, :3, 3] - T_base_soles[..., :, None, :3, 3]
    return np.asarray(np.einsum("...ijk,...ik->...ij", levers, T_base_soles[..., :3, 2]))


def _checked_times(times: ArrayLike, count: int, longest_gap: float) -> Floats:
    moments = shaped(times, (count,), "times")
    check_tolerance(longest_gap, "longest_gap")
    steps = np.diff(moments)
    for wrong, what in (
        (steps <= 0.0, "times must ascend"),
        (steps > longest_gap, f"a gap of more than {longest_gap:g} s"),
    ):
        if wrong.any():
            k = int(wrong.argmax())
            raise BadArgument(f"{what}: row {k + 1} is at {moments[k + 1]:.6g} s, row {k} at {moments[k]:.6g} s")
    return moments


def _supports(
    robot: RobotModel,
    feet: Feet,
    T_base_soles: Floats,
    contacts: ArrayLike | None,
    forces: ArrayLike | None,
    lower: float,
) -> NDArray[np.intp]:
    """Return the index of the support in each row, shape (n,)."""
    count = len(T_base_soles)
    if contacts is not None and forces is not None:
        raise BadArgument("give contacts or forces, not both")
    heights = sole_heights(T_base_soles)
    support = np.empty(count, dtype=np.intp)
    now = standing_sole(heights[0], 0, lower)
    if contacts is not None:
        touching = shaped(contacts, (count, len(feet.names)), "contacts") != 0.0
        for k, row in enumerate(touching):
            if not row[now] and row.any():
                now = int(row.argmax())
            support[k] = now
    elif forces is not None:
        pressed = feet.forces(robot, forces, (count,))
        total = pressed.sum(axis=1, keepdims=True)
        shares = np.divide(pressed, total, out=np.zeros_like(pressed), where=total > 0.0)
        largest, strongest = shares.max(axis=1), shares.argmax(axis=1)
        now = int(strongest[0]) if largest[0] > 0.0 else now
        for k in range(count):
            now = int(strongest[k]) if largest[k] > _SHARE else now
            support[k] = now
    else:
        for k in range(count):
            now = standing_sole(heights[k], now, lower)
            support[k] = now
    return support


def _slips(T_world_base: Floats, gyro: Floats, steps: Floats) -> Floats:
    """Return how much farther the gyrometer turned about the vertical than the leg did, from row to row [rad]."""
    if not len(steps):
        return np.empty(0)
    R = T_world_base[:, :3, :3]
    by_leg = log(R[1:] @ R[:-1].swapaxes(-1, -2))[:, 2]
    measured = 0.5 * np.einsum("ni,ni->n", R[:, 2], gyro)
    return np.asarray((measured[1:] + measured[:-1]) * steps - by_leg)


def on_floor(T: Floats) -> Floats:
    """Return a pose on the floor below, with the same heading."""
    return join_poses(rot_z(np.arctan2(T[1, 0], T[0, 0])), T[:3, 3] * [1.0, 1.0, 0.0])
