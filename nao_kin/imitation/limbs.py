"""The map of a person's directions to the configurations of a robot's arms and head.

Arms take the path of least cost (`arm_path`), the head the nearest direction in each frame (`nk.ik.look_at`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from enum import IntFlag

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import Floats, check_tolerance, choice, cross, norm, shaped
from nao_kin.errors import BadArgument
from nao_kin.ik import arm as solve_arm, head as solve_head, limbs, look_at
from nao_kin.imitation.arm_cost import Paths, vectors_and_axes
from nao_kin.imitation.arm_path import followed
from nao_kin.imitation.directions import DIRECTIONS, Directions
from nao_kin.robot import RobotModel
from nao_kin.rotations import rot_y, rot_z, rotation_between

# The default weights of squared errors, and of the squared speeds of joints as shares of their limits.
WEIGHTS = {"upper_arm": 1.0, "forearm": 1.0, "hand": 0.05, "place": 0.0, "speed": 0.01}
# A value this near to a limit is at it, and a direction this far from the person's is missed [rad].
_AT_LIMIT, _MISSED = 1e-7, 1e-6
# The first joint of each direction; the directions with a second joint, and these joints.
_FIRST, _HAS_SECOND, _SECOND = [0, 2, 4, 5, 7, 9, 10], [0, 1, 3, 4, 6], [1, 3, 6, 8, 11]
# Limits of joints without limits: a few turns [rad].
_UNLIMITED = 8.0 * math.pi
# The weight of the step to a first frame without time before it, which decides between equal configurations.
_TIE = 1e-14
# Steps in less time cost as much as in this time [s].
_SHORTEST = 1e-6


class Clamp(IntFlag):
    """Why a direction is not met: its joints at their limits, or an unknown direction.

    The first joint is ShoulderPitch, ElbowYaw, WristYaw or HeadYaw; the second is ShoulderRoll, ElbowRoll or HeadPitch.
    LINKS: the arm is farther out, or the head nearer to its middle, because links would overlap.
    """

    NONE = 0
    FIRST = 1
    SECOND = 2
    UNKNOWN = 4
    LINKS = 8


def checked_weights(weights: Mapping[str, float] | None) -> dict[str, float]:
    """Return all weights, those that are not given as in `WEIGHTS`."""
    for name, weight in (weights or {}).items():
        choice(name, WEIGHTS, "weight")
        check_tolerance(weight, f"the weight of {name}")
    return {name: float((weights or {}).get(name, usual)) for name, usual in WEIGHTS.items()}


class LimbMap:
    """The map of directions to the joint values of a robot's arms and head.

    Args:
        robot: a NAO of any version, or another robot with arms and a neck of its geometry.

    Raises:
        BadArgument: the robot lacks an arm or a neck of this geometry, or an arm has coupled limits.
    """

    def __init__(self, robot: RobotModel) -> None:
        self.robot = robot
        self._rest = robot.clamp(robot.neutral())
        found = {limb["kind"] + limb["side"]: limb for limb in limbs(robot)}
        for side in "LR":
            if "arm" + side not in found:
                solve_arm(robot, side, np.eye(4))  # raises, and says what is missing
        if "head" not in found:
            solve_head(robot, np.eye(3))
        arms, self._head = [found["armL"], found["armR"]], found["head"]
        for limb in arms:
            if limb["table"] is not None:
                raise BadArgument(
                    f"{robot.name}: imitation does not know coupled limits of arms, as of {limb['frame']}"
                )
        # Of both arms, shape (2, 5); values in the closed form are multiplier · coordinate + offset.
        self._columns, self._multiplier, self._offset = (
            np.array([limb[part] for limb in arms]) for part in ("columns", "multiplier", "offset")
        )
        self._lower, self._upper = (
            np.array([[sign * _UNLIMITED if end is None else end for end in limb[part]] for limb in arms])
            for part, sign in (("lower", -1.0), ("upper", 1.0))
        )
        self.columns = np.concatenate([*self._columns, self._head["columns"]])
        geometry = [limb["geometry"] for limb in arms]
        self._tilts = np.array([[math.atan2(own["elbow_y"], own["elbow_x"])] for own in geometry])
        # From the middle to a shoulder, to the elbow, to the hand [m].
        self.lengths: tuple[float, float, float] = (
            abs(geometry[0]["shoulder"][1]),
            math.hypot(geometry[0]["elbow_x"], geometry[0]["elbow_y"]),
            geometry[0]["place"][0],
        )

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints that move, of both arms and the head, as in `RobotModel.joint_names`."""
        return tuple(self.robot.joint_names[column - self.robot.nq_base] for column in self.columns)

    def links(self, limb: int) -> set[str]:
        """Return the links of the left arm (0), the right arm (1) or the head (2), from its first joint outwards."""
        column = self.columns[5 * limb]
        first, found = self.robot.joint_names[column - self.robot.nq_base], set[str]()
        for joint in self.robot.tree.joints:
            if joint.name == first or joint.parent in found:
                found.add(joint.child)
        return found

    def outwards(self, q: Floats, share: Floats) -> Floats:
        """Return configurations with ShoulderRoll, left and right, a share of the way to its outward limit.

        The third share (n, 3) is that of the way of the head to its middle.
        """
        made = np.array(q)
        for k, limits in enumerate((self._upper, self._lower)):
            end = (limits[k, 1] - self._offset[k, 1]) / self._multiplier[k, 1]
            column = self._columns[k, 1]
            made[:, column] += share[:, k] * (end - made[:, column])
        head = self._head["columns"]
        made[:, head] += share[:, 2:] * (self._rest[head] - made[:, head])
        return made

    def solve(
        self,
        directions: Directions,
        near: ArrayLike | None = None,
        *,
        seconds: ArrayLike | None = None,
        weights: Mapping[str, float] | None = None,
        places: Floats | None = None,
    ) -> Floats:
        """Return configurations of n frames, shape (n, nq): arms with the least cost of a path, heads frame by frame.

        With the weights w, the cost is Σ w ε² over the errors ε of upper arms and forearms, of the backs of hands, all
        as chords of unit vectors, and of places as shares of the arm's length, and over the speeds of joints as shares
        of their limits. Joints that nothing determines stay near to those of the frame before.

        Args:
            directions: of n frames.
            near: the configuration before the first frame, inside the limits, with the values of all other joints,
                shape (nq,); None for all joints at zero, or at the limit nearest to it.
            seconds: time from the frame before to each frame, shape (n,) [s]; infinite where speed has no cost, as
                everywhere by default.
            weights: as in `imitate`.
            places: of hands from the shoulders, shape (n, 2, 3) [m].
        """
        n = len(directions.gaze)
        times = np.full(n, math.inf) if seconds is None else np.asarray(seconds)
        q = self._rest if near is None else shaped(near, (self.robot.nq,), "near")
        made = np.tile(q, (n, 1))
        paths = self._paths(directions, q, times, checked_weights(weights), places)
        for k, values in enumerate(followed(paths)):
            made[:, self._columns[k]] = (values - self._offset[k]) / self._multiplier[k]
        known = np.flatnonzero(np.isfinite(directions.gaze).all(axis=1))
        if len(known):
            points = np.array(self._head["geometry"]["neck"]) + directions.gaze[known]
            gazes = look_at(self.robot, points, self._head["frame"], near=q).q[:, self._head["columns"]]
            # An unknown gaze keeps the one before.
            last = np.searchsorted(known, np.arange(n), side="right") - 1
            made[:, self._head["columns"]] = np.where(last[:, None] >= 0, gazes[last], q[self._head["columns"]])
        return made

    def _paths(
        self, person: Directions, q: Floats, seconds: Floats, weight: Mapping[str, float], places: Floats | None
    ) -> Paths:
        """Return the numbers of the cost of both arms; errors of what is unknown have no weight."""
        n, (_, upper, fore) = len(person.gaze), self.lengths
        targets = np.full((2, n, 4, 3), np.nan)
        targets[:, :, 0], targets[:, :, 1] = np.swapaxes(person.upper_arms, 0, 1), np.swapaxes(person.forearms, 0, 1)
        hands = np.swapaxes(person.hands, 0, 1)
        # The robot's wrist does not bend: hands turn with the rotation by the least angle that straightens the wrist.
        straight = np.isfinite(hands).all(axis=(-2, -1)) & np.isfinite(targets[:, :, 1]).all(axis=-1)
        turn = rotation_between(hands[straight][..., 0], targets[straight][:, 1])
        targets[straight, 2] = (turn @ hands[straight])[..., 2]
        if places is not None:
            targets[:, :, 3] = np.swapaxes(places, 0, 1) / (upper + fore)
        known = np.isfinite(targets).all(axis=-1)
        roots = np.sqrt([weight[name] for name in ("upper_arm", "forearm", "hand", "place")]) * known
        speeds = self.robot.velocity_limits[self._columns - self.robot.nq_base]
        longest = np.where(np.isfinite(speeds), speeds, 1.0)[:, None] * np.maximum(seconds, _SHORTEST)[:, None]
        return Paths(
            tilt=self._tilts,
            share=np.full((2, 1), upper / (upper + fore)),
            lower=self._lower[:, None],
            upper=self._upper[:, None],
            targets=np.nan_to_num(targets),
            roots=roots,
            pull=weight["speed"] / longest**2 + _TIE,
            before=self._multiplier * q[self._columns] + self._offset,
        )

    def errors(self, directions: Directions, q: Floats) -> tuple[Floats, NDArray[np.int64]]:
        """Return the angles between a person's directions and those of configurations, and why they are missed.

        Both have the shape (n, 7), in the order of `DIRECTIONS`: angles [rad], NaN where the direction is unknown, and
        the joints that cannot move farther, as `Clamp`.
        """
        angles = np.empty((len(q), len(DIRECTIONS)))
        values = np.swapaxes(q[:, self._columns] * self._multiplier + self._offset, 0, 1)
        vectors, _ = vectors_and_axes(values, self._tilts)
        upper, fore, back = np.moveaxis(np.swapaxes(vectors, 0, 1), 2, 0)
        hands = np.stack([fore, cross(back, fore), back], axis=-1)
        angles[:, [0, 3]] = _angle(norm(upper - directions.upper_arms))
        angles[:, [1, 4]] = _angle(norm(fore - directions.forearms))
        # ‖R − R'‖² = 8 sin²(φ / 2)
        angles[:, [2, 5]] = _angle(np.linalg.norm(hands - directions.hands, axis=(-2, -1)) / math.sqrt(2.0))
        head = q[:, self._head["columns"]] * self._head["multiplier"] + self._head["offset"]
        angles[:, -1] = _angle(norm((rot_z(head[:, 0]) @ rot_y(head[:, 1]))[..., 0] - directions.gaze))
        at_limit = np.zeros((len(q), len(self.columns)), dtype=bool)
        for nudge in (-_AT_LIMIT, _AT_LIMIT):
            moved = np.array(q)
            moved[:, self.columns] += nudge
            at_limit |= np.abs(self.robot.clamp(moved) - moved)[:, self.columns] > 0.5 * _AT_LIMIT
        codes = Clamp.FIRST * at_limit[:, _FIRST]
        codes[:, _HAS_SECOND] |= Clamp.SECOND * at_limit[:, _SECOND]
        return angles, np.where(np.isnan(angles), int(Clamp.UNKNOWN), np.where(angles > _MISSED, codes, 0))


def _angle(chord: Floats) -> Floats:
    """Return the angles between unit vectors from the lengths of their differences."""
    return np.asarray(2.0 * np.arcsin(np.minimum(0.5 * chord, 1.0)))
