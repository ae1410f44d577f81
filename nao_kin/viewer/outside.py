"""Warnings of joints that are shown outside their limits."""

from __future__ import annotations

from nao_kin._common.arrays import Floats
from nao_kin._common.warn import warn_caller
from nao_kin.errors import NaoKinWarning
from nao_kin.robot import RobotModel


class OutsideLimitsWarning(NaoKinWarning):
    """A configuration on show has joints outside their limits, and not because nobody moved them from zero.

    Examples:
        >>> issubclass(nk.viewer.OutsideLimitsWarning, nk.errors.NaoKinWarning)
        True
    """


class OutsideWarnings:
    """Warns of each joint of a robot once."""

    def __init__(self, robot: RobotModel) -> None:
        self._robot = robot
        self._warned: set[str] = set()

    def check(self, qs: Floats) -> None:
        """Warn of the joints that are outside in one configuration, shape (nq,), or in several, shape (n, nq)."""
        if qs.ndim > 1:
            qs = qs[_first_outside(self._robot, qs)]
        violations = self._robot.limit_violations(qs)
        found = dict.fromkeys(row.joint for row in violations if row.value != 0.0 or row.of_value != 0.0)
        new = [joint for joint in found if joint not in self._warned]
        self._warned.update(new)
        if new:
            warn_caller(f"outside the joint limits, shown in red: {', '.join(new)}", OutsideLimitsWarning)


def _first_outside(robot: RobotModel, qs: Floats) -> list[int]:
    """Of a clip, the first configuration in which each joint is outside its limits and not because all is at zero.

    A clip that runs outside of them for minutes has a violation in every frame, and they say no more than these.
    """
    outside = ~robot.within_limits(qs, per_joint=True)
    values = qs[:, robot.nq - len(robot.joint_names) :]
    moved = outside & (values != 0.0)
    for table in robot.coupled_limits:
        joint, of = robot.joint_names.index(table.joint), robot.joint_names.index(table.of)
        if robot.lower[joint] <= 0.0 <= robot.upper[joint]:  # else the box refuses zero, whatever the table says
            moved[:, joint] |= outside[:, joint] & (values[:, of] != 0.0)
    return sorted({int(column.argmax()) for column in moved.T if column.any()})
