"""Inverse kinematics: all joint values for a pose inside the limits, or the reason why there are none.

These options are the same in all solvers of poses:

- `near`: preferred configurations, shape (..., nq), that broadcast with the targets, or the name of a posture.
  Solutions are sorted by their distance to it, searches begin there, and joints that the targets do not determine keep
  its values. If limits are enforced, `near` is projected into them, and `notes` says so. None for all joints at zero,
  or at the limit nearest to it.
- `limits`: "enforce" leaves out solutions with a joint outside its own range or a coupled limit; "ignore" keeps them,
  with the whole turns that bring each joint within half a turn of `near`. The policy "clamp" is refused: with
  "enforce", `best` has the nearest values inside the limits that a search finds.
- `threads`: how many threads may work on a batch; None for all cores if that is worthwhile.
- `collisions`: whether to leave out solutions in which links overlap, by `RobotModel.clearance`: True, or a
  `nk.robot.CollisionRule` with an overlap that is accepted and pairs that may overlap. Only pairs that the joints
  solved for move are checked, and pairs that overlap in `near` may not overlap more. If links overlap in all solutions,
  the result has the one with the largest clearance, and the reason `COLLISION`.
"""

from nao_kin._core.guesses import public_attributes as _public_attributes
from nao_kin.ik.analytic import analytic
from nao_kin.ik.arm import arm
from nao_kin.ik.follow import FollowedPath, follow
from nao_kin.ik.head import head, look_at
from nao_kin.ik.least_squares import descended_along as descended_along
from nao_kin.ik.leg import leg
from nao_kin.ik.legs import LegsResult, legs
from nao_kin.ik.limbs import limbs
from nao_kin.ik.numeric import numeric
from nao_kin.ik.results import Family, IKResult, Obstacles, Reason
from nao_kin.ik.velocity import TwistMap, VelocityResult, velocity
from nao_kin.ik.whole_body import WholeBodyResult, whole_body

__all__ = [
    "Family",
    "FollowedPath",
    "IKResult",
    "LegsResult",
    "Obstacles",
    "Reason",
    "TwistMap",
    "VelocityResult",
    "WholeBodyResult",
    "analytic",
    "arm",
    "follow",
    "head",
    "leg",
    "legs",
    "limbs",
    "look_at",
    "numeric",
    "velocity",
    "whole_body",
]

globals().update(_public_attributes(__name__))
