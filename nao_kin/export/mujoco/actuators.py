"""Position actuators: one for each joint that a motor drives, three for a ball.

A URDF says of a motor its largest effort e and its largest speed v. Of the rest, three estimates make a servo of it:

- the full effort acts at an error of 0.05 rad (5 mm for a sliding joint): kp = e / 0.05;
- no effort is left at the largest speed, the line of an ideal DC motor: damping = e / v;
- the rotor's inertia, as seen behind the gear, is armature = 0.015 s · e / v: 0.007 kg m² for NAO's knee, where a rotor
  of 4 g cm² behind the published ratio of 130.85 has as much.

The derivative gain makes the servo critically damped on its own rotor.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from nao_kin.export.mujoco.bodies import BodyJoint
from nao_kin.urdf import UrdfJoint

# All three are estimates, not published.
FULL_EFFORT_ERROR = {"revolute": 0.05, "prismatic": 0.005}  # [rad, m]
ROTOR_TIME = 0.015  # armature / damping [s]
_NARROWEST = 1e-9  # half the range of a joint that cannot move [rad, m]
UNKNOWN_GAIN = 100.0  # where no effort is published [N m / rad, N / m]


@dataclass(frozen=True)
class Servo:
    """What the motor of a joint does.

    Attributes:
        kp: torque or force per unit of error.
        kv: torque or force per unit of speed that the controller adds.
        damping: viscous torque or force of the joint itself.
        armature: inertia of the rotor behind the gear [kg m², or kg].
        effort: largest torque or force, ∞ where none is published.
    """

    kp: float
    kv: float
    damping: float
    armature: float
    effort: float


def servo(row: UrdfJoint) -> Servo:
    """The motor of a joint, by the published effort and speed; those of zero or without a bound are not known."""
    effort = row.effort if 0.0 < row.effort < math.inf else math.inf
    known = effort < math.inf and 0.0 < row.velocity < math.inf
    slope = effort / row.velocity if known else 0.0
    armature = ROTOR_TIME * slope
    kp = effort / FULL_EFFORT_ERROR[row.kind] if effort < math.inf else UNKNOWN_GAIN
    kv = max(2.0 * math.sqrt(kp * armature) - slope, 0.0) if known else 0.1 * kp
    return Servo(kp, kv, row.damping + slope, armature, effort)


def weakest(servos: Iterable[Servo]) -> Servo:
    """What all of several motors can do: a ball is turned by the weakest of its three."""
    return min(servos, key=lambda motor: motor.effort)


def proper_range(lower: float, upper: float) -> tuple[float, float]:
    """Limits as MuJoCo takes them: a range of no width is none to it, and the joint would move freely."""
    return (lower, upper) if lower < upper else (lower - _NARROWEST, upper + _NARROWEST)


def add_actuators(spec: Any, joints: Iterable[BodyJoint]) -> tuple[str, ...]:
    """A position actuator for each joint that does not follow another, of the joint's name.

    A ball has three, named with _x, _y, _z: their controls are the rotation vector of the wanted orientation in the
    frame of the joint (`nao_kin.rotations.log`), for MuJoCo measures a ball by its rotation vector.

    Returns:
        One line for each joint without a published effort.
    """
    unknown = []
    for joint in joints:
        motor = weakest(map(servo, joint.rows))
        if joint.kind == "ball":
            for place, letter in enumerate("xyz"):
                gear = [1.0 if column == place else 0.0 for column in range(6)]
                _add(spec, f"{joint.name}_{letter}", joint.name, motor, (-math.pi, math.pi), gear)
        elif joint.rows[0].mimic is None:
            _add(spec, joint.name, joint.name, motor, (joint.rows[0].lower, joint.rows[0].upper))
        else:
            continue
        if motor.effort == math.inf:
            unknown.append(joint.name)
    if not unknown:
        return ()
    return (f"no effort is published for {', '.join(unknown)}: force without bounds, gain {UNKNOWN_GAIN:g}",)


def _add(
    spec: Any, name: str, joint: str, motor: Servo, allowed: tuple[float, float], gear: list[float] | None = None
) -> None:
    import mujoco

    added = spec.add_actuator(name=name, target=joint, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    added.set_to_position(kp=motor.kp, kv=motor.kv)
    if gear is not None:
        added.gear = gear
    if all(map(math.isfinite, allowed)):
        added.ctrlrange = proper_range(*allowed)
    if motor.effort < math.inf:
        added.forcerange = (-motor.effort, motor.effort)
