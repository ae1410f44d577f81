"""Where a limb must jump: steps between two samples that no finer path between the two targets makes smaller.

A step is first looked at as the robot would make it, every joint straight from one value to the other: where the limb
halfway is off by less than a quarter of the way, it stays with the path as closely as the path is sampled, and this is
no jump. For other steps the way from the one pose to the other is cut into fifteen pieces, and the branches chosen that
lead along it with the least motion; then again inside the largest step that is left, and again. Along a continuous way
the largest step shrinks each time, fifteen times, or at a singularity, where joints move like a square root, four
times. A jump stays.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin.ik.paths.branch_choice import Choice, choose
from nao_kin.ik.paths.limb_paths import LimbPath
from nao_kin.robot import RobotModel

# Steps below the resolution of NAO's joint sensors, 0.1°, are none [rad].
_SMALLEST = 1.75e-3
# Halfway the limb may be off by this share of the way, and the step still follows the path.
_BESIDE = 0.25
# An odd number, so that opposite directions have no middle.
_PIECES = 15
_ZOOMS = 3
# A branch that is continued regardless of the limits moves by less between two samples [rad].
_FAR = 1.0
# A largest step that shrinks to no less than this when its piece is cut again is a jump.
_STILL = 0.5


@dataclass(frozen=True)
class Jump:
    """Two samples between which a limb cannot move continuously along the path.

    Attributes:
        index: it is between this sample and the next one.
        limb: "LLeg", "RLeg", "legs", "LArm", "RArm" or "Head".
        joint: the joint that has the farthest to go, in time at its speed limit.
        size: how far it goes [rad].
        cause: what ends the branch that is left, and where.

    Examples:
        >>> jump = nk.ik.Jump(3, "LArm", "LElbowYaw", 2.1, "another branch")
        >>> jump.index, jump.joint
        (3, 'LElbowYaw')
    """

    index: int
    limb: str
    joint: str
    size: float
    cause: str

    def describe(self) -> str:
        """The jump in a sentence.

        Examples:
            >>> nk.ik.Jump(3, "LArm", "LElbowYaw", 2.1, "another branch").describe()
            'LArm jumps after sample 3: LElbowYaw by 2.1 rad; another branch'
        """
        return f"{self.limb} jumps after sample {self.index}: {self.joint} by {self.size:.3g} rad; {self.cause}"


def jumps_of(limb: LimbPath, choice: Choice, reference: Floats, weights: Floats) -> tuple[Jump, ...]:
    """The jumps of a limb along its path.

    Args:
        limb: the limb and its n targets.
        choice: what it does.
        reference: configurations of the whole robot, shape (n, nq).
        weights: of each coordinate of the robot, shape (nq,).
    """
    columns = list(choice.columns)
    known = choice.known
    large = np.abs(np.diff(choice.values, axis=0)).max(axis=1, initial=0.0) > _SMALLEST
    steps = np.flatnonzero(known[:-1] & known[1:] & large)
    if not len(steps):
        return ()
    q = np.array(reference)
    q[:, columns] = choice.values
    jumps = []
    for i in steps[_leaves_path(limb, q[steps], q[steps + 1])]:
        if _stays(limb, q[i], q[i + 1], weights, columns):
            step = choice.values[i + 1] - choice.values[i]
            place = int(np.argmax(np.abs(step) * weights[columns]))
            joint = _joint_of(limb.robot, columns[place])
            jumps.append(Jump(int(i), limb.name, joint, float(step[place]), _cause(limb, q, int(i), columns)))
    return tuple(jumps)


def _leaves_path(limb: LimbPath, first: Floats, second: Floats) -> Floats:
    """Whether the limb, with its joints moved straight, leaves the straight way of what is asked of it, shape (m,)."""
    ends = limb.points(first), limb.points(second)
    halfway = limb.points(0.5 * (first + second))
    away = np.linalg.norm(ends[1] - ends[0], axis=-1).max(axis=-1)
    beside = np.linalg.norm(halfway - 0.5 * (ends[0] + ends[1]), axis=-1).max(axis=-1)
    return np.asarray(beside > _BESIDE * away)


def _stays(limb: LimbPath, first: Floats, second: Floats, weights: Floats, columns: list[int]) -> bool:
    """Whether a step stays as large however finely the way between its two poses is cut."""
    shares = np.arange(1, _PIECES) / _PIECES
    size = float(np.abs(second - first)[columns].max())
    for _ in range(_ZOOMS):
        inner = limb.between(first, second, shares)
        reference = np.tile(first, (len(shares), 1))
        choice = choose(inner, reference, weights, start=first, end=second)
        known = choice.known
        q = np.concatenate([[first], reference[known], [second]])
        q[1:-1, columns] = choice.values[known]
        steps = np.abs(np.diff(q[:, columns], axis=0)).max(axis=1)
        place = int(np.argmax(steps))
        before, size = size, float(steps[place])
        if size < _SMALLEST:
            return False
        first, second = q[place], q[place + 1]
    return size > _STILL * before


def _cause(limb: LimbPath, q: Floats, i: int, columns: list[int]) -> str:
    """What ends the branch that sample i is on: it is continued regardless of the limits until it is outside them."""
    now = q[i]
    for sample in range(i + 1, len(q)):
        found = limb.at(sample).solve(now[None], limits="ignore")
        if not found.count[0]:
            return f"its branch ends at sample {sample}: {found.describe((0,))}"
        step = found.branches[0, 0] - now[columns]
        if np.abs(step).max() > _FAR:
            return f"its branch ends at sample {sample}"
        now = np.array(q[sample])
        now[columns] = found.branches[0, 0]
        if sample == i + 1 and np.abs(now - q[sample]).max() < _SMALLEST:
            return "the limb cannot go straight from the one pose to the other"
        moved = {_joint_of(limb.robot, column) for column in columns}
        outside = [row for row in limb.robot.limit_violations(now) if row.joint in moved]
        if outside and limb.options.get("limits") != "ignore":
            return f"its branch ends at sample {sample}, where {outside[0].describe()}"
    return "its branch goes on, and there is less motion in all this way"


def _joint_of(robot: RobotModel, column: int) -> str:
    return robot.joint_names[column - (robot.nq - len(robot.joint_names))]
