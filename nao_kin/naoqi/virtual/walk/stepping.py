"""One step as joint values: the standing foot fixed, the other one lifted along a smooth arc, the torso between.

It is kinematics, without balance: no centre of mass is moved over the standing foot, as a real walk does.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nao_kin import ik
from nao_kin._common.arrays import Floats
from nao_kin.naoqi.poses import pose
from nao_kin.naoqi.virtual.walk.footsteps import Step, turned_by
from nao_kin.robot import RobotModel

# "The double support time uses one third of the step time" (Aldebaran documentation, locomotion control).
_DOUBLE_SUPPORT = 1.0 / 3.0
# Steps are stretched until joints are this far below their largest speeds.
_SPEED_SHARE = 0.98
_MOST_STRETCHES = 6


@dataclass(frozen=True, eq=False)
class StepMotion:
    """A step in joint values at every tick.

    Attributes:
        q: configurations at the ends of the ticks, shape (n, nq); the last is where the step ends.
        reached: whether the legs make all of it.
        message: why not; "" where they do.
    """

    q: Floats
    reached: bool
    message: str = ""


def walking_height(robot: RobotModel) -> float:
    """Height of the level torso above the soles while walking: that of the posture StandInit [m]."""
    return -float(robot.fk(robot.posture("StandInit"), "LLeg")[2, 3])


def smooth(u: Floats) -> Floats:
    """From 0 to 1 at rest at both ends, with continuous acceleration: 10u³ − 15u⁴ + 6u⁵."""
    return np.asarray(u * u * u * (10.0 + u * (6.0 * u - 15.0)))


def stance(robot: RobotModel, feet: dict[str, Floats], q: Floats) -> Floats:
    """The configuration that stands at walking height with the feet there, shape (nq,); arms and head as in q.

    Args:
        robot: a NAO.
        feet: poses on the floor by "L" and "R", shape (3,).
        q: the other joints.
    """
    between = _between(feet["L"], feet["R"])
    return _legs(robot, _flat(feet["L"][None]), _flat(feet["R"][None]), _torso(robot, between[None]), q).q[0]


def step_motion(robot: RobotModel, step: Step, q: Floats, tick: float) -> StepMotion:
    """A step at every tick; longer than its gait says where joints would be too fast.

    Args:
        robot: a NAO.
        step: the step.
        q: where the robot stands now, shape (nq,).
        tick: time between two configurations [s].
    """
    ticks = max(2, math.ceil(step.gait.period / tick - 1e-9))
    for _ in range(_MOST_STRETCHES):
        motion = _at(robot, step, q, ticks)
        if not motion.reached:
            return motion
        speeds = np.abs(np.diff(np.vstack([q, motion.q]), axis=0))[:, -len(robot.velocity_limits) :] / tick
        share = float((speeds / robot.velocity_limits).max()) / _SPEED_SHARE
        if share <= 1.0:
            break
        ticks = math.ceil(ticks * max(share, 1.02))
    return motion


def _at(robot: RobotModel, step: Step, q: Floats, ticks: int) -> StepMotion:
    time = np.arange(1, ticks + 1) / ticks
    swing = np.clip((time - 0.5 * _DOUBLE_SUPPORT) / (1.0 - _DOUBLE_SUPPORT), 0.0, 1.0)
    moving = _moved(step.start, step.end, smooth(swing))
    height = step.gait.step_height * 16.0 * np.square(swing * (1.0 - swing))
    standing = np.broadcast_to(step.support, moving.shape)
    first, last = (_between(step.support, foot) for foot in (step.start, step.end))
    torso = _torso(robot, _moved(first, last, smooth(time)))
    feet = {step.side: _flat(moving, height), "R" if step.side == "L" else "L": _flat(standing)}
    found = _legs(robot, feet["L"], feet["R"], torso, q)
    missed = np.flatnonzero(~np.asarray(found.success))
    return StepMotion(found.q, not missed.size, found.describe((int(missed[0]),)) if missed.size else "")


def _legs(robot: RobotModel, left: Floats, right: Floats, torso: Floats, q: Floats) -> ik.LegsResult:
    """Both legs by their closed form; the torso's yaw gives way so that both feet are met on one hip motor."""
    return ik.legs(robot, left, right, base="floating", torso=torso, free="yaw", reference=q)


def _between(left: Floats, right: Floats) -> Floats:
    middle = 0.5 * (left + right)
    middle[2] = left[2] + 0.5 * turned_by(float(right[2] - left[2]))
    return middle


def _moved(start: Floats, end: Floats, share: Floats) -> Floats:
    way = end - start
    way[2] = turned_by(float(way[2]))
    return np.asarray(start + share[:, None] * way)


def _flat(places: Floats, height: Floats | float = 0.0) -> Floats:
    """Level poses of places on the floor, shape (n, 4, 4)."""
    six = np.zeros((len(places), 6))
    six[:, :2], six[:, 2], six[:, 5] = places[:, :2], height, places[:, 2]
    return pose(six)


def _torso(robot: RobotModel, places: Floats) -> Floats:
    """Level poses of the torso above places on the floor, shape (n, 4, 4)."""
    six = np.zeros((len(places), 6))
    six[:, :2], six[:, 2] = places[:, :2], walking_height(robot)
    six[:, 5] = places[:, 2]
    return pose(six)
