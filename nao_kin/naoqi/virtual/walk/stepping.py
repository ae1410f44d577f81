"""Steps as joint values: the standing foot fixed, the other one lifted along a smooth arc, the torso between.

It is kinematics, without balance: no centre of mass is moved over the standing foot, as a real walk does.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from nao_kin import ik
from nao_kin._common.arrays import Floats
from nao_kin.naoqi.poses import pose
from nao_kin.naoqi.virtual.cartesian.paths import EffectorPath
from nao_kin.naoqi.virtual.walk.footsteps import Step, between, foot_beside, turned_by
from nao_kin.robot import RobotModel

# "The double support time uses one third of the step time" (Aldebaran documentation, locomotion control).
_DOUBLE_SUPPORT = 1.0 / 3.0
# Steps are stretched until joints need no more than this share of their largest speeds.
_SPEED_SHARE = 0.98
# A robot gets ready to walk in half a second, or as much longer as keeps joints to this share.
_GETTING_READY = 0.5
_READY_SPEED_SHARE = 0.4
_READY = 1e-6
_MOST_STRETCHED = 10


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


def ready_motion(
    robot: RobotModel, feet: dict[str, Floats], T_world_torso: Floats, q: Floats, tick: float
) -> StepMotion:
    """From where the robot stands to where a step begins: the torso level, between the feet.

    The feet stay where they are while the torso comes over them. Where the legs cannot do that (from Crouch, whose
    ankles are at their limits), the joints go straight to the end of it, and the feet slide a little; and where they
    cannot stand so at all, to feet side by side.

    Args:
        robot: a NAO.
        feet: poses on the floor by "L" and "R", shape (3,).
        T_world_torso: where the torso is now, shape (4, 4).
        q: the joints of now, shape (nq,).
        tick: time between two configurations [s].

    Returns:
        No configuration at all where the robot is ready.
    """
    left, right = (_flat(feet[side][None]) for side in ("L", "R"))
    ready = _legs(robot, left, right, _torso(robot, between(feet["L"], feet["R"])[None]), q)
    stands = bool(np.all(ready.success))
    goal = ready.q[0] if stands else _side_by_side(robot, q)
    if np.abs(goal - q).max() < _READY:
        return StepMotion(np.empty((0, robot.nq)), True)
    ticks = round(_GETTING_READY / tick)
    if stands:
        poses = np.stack([T_world_torso, np.asarray(ready.torso)[0]])

        def over_feet(count: int) -> StepMotion:
            path = EffectorPath([0.0, float(count)], poses)
            torso = np.stack([path.pose(float(time)) for time in range(1, count + 1)])
            return _as_motion(_legs(robot, left, right, torso, q))

        motion = _slow_enough(robot, over_feet, q, ticks, tick, _READY_SPEED_SHARE)
        if motion.reached:
            return motion

    def straight(count: int) -> StepMotion:
        share = smooth(np.arange(1, count + 1) / count)[:, None]
        return StepMotion(q + share * (goal - q), True)

    return _slow_enough(robot, straight, q, ticks, tick, _READY_SPEED_SHARE)


def step_motion(robot: RobotModel, step: Step, q: Floats, tick: float) -> StepMotion:
    """A step at every tick; longer than its period where joints would be too fast.

    Args:
        robot: a NAO.
        step: the step.
        q: where the robot stands now, shape (nq,).
        tick: time between two configurations [s].
    """
    ticks = max(2, math.ceil(step.period / tick - 1e-9))
    return _slow_enough(robot, lambda count: _at(robot, step, q, count), q, ticks, tick, _SPEED_SHARE)


def _slow_enough(
    robot: RobotModel, at: Callable[[int], StepMotion], q: Floats, ticks: int, tick: float, share: float
) -> StepMotion:
    """A motion of so many ticks, or of more, so that no joint needs more than a share of its largest speed.

    More time does not help a joint that jumps, from one branch of the legs' solutions to another: that is not reached.
    """
    most = _MOST_STRETCHED * ticks
    while True:
        motion = at(ticks)
        if not motion.reached:
            return motion
        speeds = np.abs(np.diff(np.vstack([q, motion.q]), axis=0)) / tick
        used = speeds.max(axis=0) / robot.velocity_limits / share
        if used.max() <= 1.0:
            return motion
        ticks = math.ceil(ticks * max(float(used.max()), 1.02))
        if ticks > most:
            jumps = robot.joint_names[int(np.argmax(used))]
            return StepMotion(motion.q, False, f"{jumps} would have to jump")


def _at(robot: RobotModel, step: Step, q: Floats, ticks: int) -> StepMotion:
    time = np.arange(1, ticks + 1) / ticks
    swing = np.clip((time - 0.5 * _DOUBLE_SUPPORT) / (1.0 - _DOUBLE_SUPPORT), 0.0, 1.0)
    moving = _moved(step.start, step.end, smooth(swing))
    height = step.height * 16.0 * np.square(swing * (1.0 - swing))
    standing = np.broadcast_to(step.support, moving.shape)
    first, last = (between(step.support, foot) for foot in (step.start, step.end))
    torso = _torso(robot, _moved(first, last, smooth(time)))
    feet = {step.side: _flat(moving, height), "R" if step.side == "L" else "L": _flat(standing)}
    return _as_motion(_legs(robot, feet["L"], feet["R"], torso, q))


def _side_by_side(robot: RobotModel, q: Floats) -> Floats:
    """The configuration at walking height with the feet side by side, shape (nq,)."""
    feet = {side: _flat(foot_beside(np.zeros(3), side)[None]) for side in ("L", "R")}
    return np.asarray(_legs(robot, feet["L"], feet["R"], _torso(robot, np.zeros((1, 3))), q).q[0])


def _as_motion(found: ik.LegsResult) -> StepMotion:
    missed = np.flatnonzero(~np.asarray(found.success))
    return StepMotion(found.q, not missed.size, found.describe((int(missed[0]),)) if missed.size else "")


def _legs(robot: RobotModel, left: Floats, right: Floats, torso: Floats, q: Floats) -> ik.LegsResult:
    """Both legs by their closed form; the torso's yaw gives way so that both feet are met on one hip motor."""
    return ik.legs(robot, left, right, base="floating", torso=torso, free="yaw", reference=q)


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
