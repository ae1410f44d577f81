"""The steps of a walk: the move configuration, footsteps, and the joint values of a step.

The walk is kinematic, without balance: unlike in a real walk, the centre of mass does not move over the standing foot.
"""

from __future__ import annotations

import bisect
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from nao_kin import ik
from nao_kin._core.arrays import Floats, choice
from nao_kin.errors import BadArgument, UnknownName
from nao_kin.naoqi.conventions import pose
from nao_kin.naoqi.virtual import arguments
from nao_kin.naoqi.virtual.engine import TICK
from nao_kin.robot import RobotModel

# --- NAOqi's move configuration, with its defaults and bounds.

SIDES = {"L": "Left", "R": "Right"}

# Parameter of each foot → default, lowest and highest value [m, rad, share]; the torso's angles have no effect.
# Source: Aldebaran documentation 2.1, locomotion control, "Move config parameters" of NAO; getMoveConfig("Default") of
# a robot prints the same defaults.
PARAMETERS = {
    "MaxStepX": (0.04, 0.001, 0.08),
    "MaxStepY": (0.14, 0.101, 0.16),
    "MaxStepTheta": (0.349, 0.001, 0.524),
    "MaxStepFrequency": (1.0, 0.0, 1.0),
    "StepHeight": (0.02, 0.005, 0.04),
    "TorsoWx": (0.0, -0.122, 0.122),
    "TorsoWy": (0.0, -0.122, 0.122),
}
# The name of the frequency in moveToward.
_OTHER_NAMES = {"Frequency": "MaxStepFrequency"}

# A step lasts 21 cycles of 20 ms at frequency 1, and 30 at frequency 0; with MaxStepX that is 9.5 cm/s.
_SHORTEST, _LONGEST = 0.42, 0.6


FootGait = dict[str, float]  # the move configuration of one foot, by the names of `PARAMETERS`
Gait = dict[str, FootGait]  # of both feet, by "L" and "R"
DEFAULT, LOWEST, HIGHEST = (dict(zip(PARAMETERS, row, strict=True)) for row in zip(*PARAMETERS.values(), strict=True))


def period(gait: FootGait) -> float:
    """Return the duration of a step [s]."""
    return _LONGEST + (_SHORTEST - _LONGEST) * gait["MaxStepFrequency"]


def gait_of(config: Any, report: Callable[[str], object] = lambda change: None) -> Gait:
    """Return a gait from NAOqi's list of [name, value] pairs; clip numbers outside the documented range, and report it.

    A name applies to both feet, or with the prefix "Left" or "Right" to one. Later pairs override earlier ones.
    """
    gait = {side: DEFAULT.copy() for side in SIDES}
    for name, given in [] if config is None else arguments.pairs(config, "a move configuration"):
        sides = [side for side, prefix in SIDES.items() if name.startswith(prefix)]
        plain = name.removeprefix(SIDES[sides[0]]) if sides else name
        plain = _OTHER_NAMES.get(plain, plain)
        if plain not in PARAMETERS:
            raise UnknownName("move parameter", name, (*PARAMETERS, *_OTHER_NAMES))
        _, lowest, highest = PARAMETERS[plain]
        value = arguments.number(given, name)
        inside = min(max(value, lowest), highest)
        if inside != value:
            report(f"{name} = {value:g} is clipped to {inside:g}")
        for side in sides or SIDES:
            gait[side][plain] = inside
    return gait


def move_config(which: str) -> list[list[object]]:
    """Return NAOqi's getMoveConfig: [name, value] pairs of "Default", "Min" or "Max"."""
    gaits = {"Default": DEFAULT, "Min": LOWEST, "Max": HIGHEST}
    return [list(row) for row in gaits[choice(which, gaits, "move configuration")].items()]


# --- Footsteps: poses on the floor, and steps along a path that a NAO's legs can make.
#
# A pose on the floor is (x, y, theta), an array of shape (3,) [m, m, rad]. The body is the pose between the feet
# when they stand side by side; each step puts a foot beside the body's next pose.

# Feet stand below the hips, 50 mm beside the body, left positive (HipOffsetY).
_FOOT_Y = {"L": 0.05, "R": -0.05}
# The smallest distance between the feet [m], and the largest inward rotation of the toes [rad].
NEAREST = 0.088
_TOES_INWARDS = 0.12
_DONE = 1e-9
# The tolerance for feet side by side.
_TOGETHER = 1e-6
_SCANNED = 40
_PARTS = 2**30


def wrapped(theta: float) -> float:
    """Return the same angle within ±π."""
    return math.remainder(theta, 2.0 * math.pi)


def composed(a: ArrayLike, b: ArrayLike) -> Floats:
    """Return the pose b, given in the frame of a, in the floor's frame."""
    (ax, ay, angle), (bx, by, more) = np.array([a, b], dtype=np.float64).tolist()
    c, s = math.cos(angle), math.sin(angle)
    return np.array([ax + c * bx - s * by, ay + s * bx + c * by, angle + more])


def seen_from(a: ArrayLike, b: ArrayLike) -> Floats:
    """Return the pose b in the frame of a, the angle within ±π: the inverse of `composed`."""
    (ax, ay, angle), (bx, by, more) = np.array([a, b], dtype=np.float64).tolist()
    c, s = math.cos(angle), math.sin(angle)
    x, y = bx - ax, by - ay
    return np.array([c * x + s * y, c * y - s * x, wrapped(more - angle)])


def arc(twist: ArrayLike) -> Floats:
    """Return the pose at the end of an arc with a constant velocity in the body's frame, times its duration."""
    x, y, theta = np.asarray(twist, dtype=np.float64).tolist()
    # The chord is turned by half the angle, and shorter than the arc by sin(θ/2)/(θ/2).
    c, s = (float(np.sinc(theta / (2.0 * math.pi))) * part for part in (math.cos(0.5 * theta), math.sin(0.5 * theta)))
    return np.array([c * x - s * y, s * x + c * y, theta])


def foot_beside(body: ArrayLike, side: str) -> Floats:
    """Return the pose of a foot below a body."""
    return composed(body, (0.0, _FOOT_Y[side], 0.0))


def body_beside(foot: ArrayLike, side: str) -> Floats:
    """Return the pose of the body above a foot: the inverse of `foot_beside`."""
    return composed(foot, (0.0, -_FOOT_Y[side], 0.0))


def other(side: str) -> str:
    """Return the other foot, "L" or "R"."""
    return "R" if side == "L" else "L"


@dataclass(frozen=True, eq=False)
class Footstep:
    """One step of the walk."""

    side: str  # the foot that moves, "L" or "R"; the other one stands
    support: Floats  # pose of the standing foot, shape (3,)
    start: Floats  # pose of the moving foot, shape (3,)
    end: Floats
    height: float  # of the moving foot in the middle [m]
    period: float  # the duration, if the joints are fast enough [s]


def bounded(step: ArrayLike, side: str, gait: FootGait) -> Floats:
    """Return a foot's pose relative to the standing foot, clipped to the limits of gait and shared hip motor.

    Sideways from 88 mm to MaxStepY; turned outwards up to MaxStepTheta and inwards up to 0.12 rad, because toes that
    turn inwards come near those of the other foot.
    """
    x, y, theta = np.asarray(step, dtype=np.float64).tolist()
    outwards = 1.0 if side == "L" else -1.0
    wide = min(max(outwards * y, NEAREST), gait["MaxStepY"])
    turn = min(max(outwards * theta, -min(_TOES_INWARDS, gait["MaxStepTheta"])), gait["MaxStepTheta"])
    return np.array([min(max(x, -gait["MaxStepX"]), gait["MaxStepX"]), outwards * wide, outwards * turn])


def first_side(motion: ArrayLike) -> str:
    """Return the foot that begins: the one on the side of a sideways motion or rotation."""
    _, y, theta = np.asarray(motion, dtype=np.float64).tolist()
    return "R" if (y, theta) < (0.0, 0.0) else "L"


def along(start: Floats, goal: Floats, share: Floats | float) -> Floats:
    """Return poses at fractions of the straight path between two, shape (..., 3), turning along the shorter arc."""
    way = goal - start
    way[2] = wrapped(float(way[2]))
    poses = np.asarray(start + np.multiply.outer(share, way))
    poses[np.equal(share, 1.0), :2] = goal[:2]
    return poses


def next_step(feet: dict[str, Floats], side: str, body: Floats, goal: Floats, gait: Gait) -> tuple[Footstep, Floats]:
    """Return a foot's step that brings the body as far as possible towards a goal, and the body's pose after it."""
    own = gait[side]
    support = feet[other(side)]

    def wanted_and_made(share: float) -> tuple[Floats, Floats]:
        wanted = seen_from(support, foot_beside(along(body, goal, share), side))
        return wanted, bounded(wanted, side, own)

    def fits(share: float) -> bool:
        wanted, made = wanted_and_made(share)
        return float(np.abs(made - wanted).max()) < _DONE

    share = _largest(fits)
    end = composed(support, wanted_and_made(share)[1])
    step = Footstep(side, support.copy(), feet[side].copy(), end, own["StepHeight"], period(own))
    return step, along(body, goal, share)


def stands_beside(feet: dict[str, Floats], body: Floats) -> bool:
    """Return whether both feet stand side by side below this body."""
    errors = [float(np.abs(seen_from(foot_beside(body, side), foot)).max()) for side, foot in feet.items()]
    return max(errors) < _TOGETHER


def _largest(fits: Callable[[float], bool]) -> float:
    """Return the largest fraction for which `fits` is true, found by bisection; 0 if there is none."""
    low = next((k for k in range(_SCANNED, 0, -1) if fits(k / _SCANNED)), 0)
    if low == _SCANNED:
        return 1.0
    parts = bisect.bisect(range(1, _PARTS), False, key=lambda part: not fits((low + part / _PARTS) / _SCANNED))
    return (low + parts / _PARTS) / _SCANNED


# --- Steps as joint values: the standing foot fixed, the other one lifted along a smooth arc, the torso between.

# "The double support time uses one third of the step time" (Aldebaran documentation, locomotion control).
_DOUBLE_SUPPORT = 1.0 / 3.0
# Steps are stretched until joints need no more than this fraction of their largest speeds.
_SPEED_SHARE = 0.98
# The shortest time to get ready to walk [s], and the joints' fraction of their largest speeds meanwhile.
_GETTING_READY = 0.5
_READY_SPEED_SHARE = 0.4
_READY = 1e-6
_MAX_STRETCH = 10
_IMPOSSIBLE = "the legs cannot make this step"


def smooth(u: Floats) -> Floats:
    """Interpolate from 0 to 1, at rest at both ends, with continuous acceleration: 10u³ − 15u⁴ + 6u⁵."""
    return np.asarray(u * u * u * (10.0 + u * (6.0 * u - 15.0)))


def ready_motion(robot: RobotModel, feet: dict[str, Floats], q: Floats) -> Floats:
    """Return configurations (n, nq) at the ticks that bring the torso level between the feet; none if it is there.

    The joints move straight to the final configuration, and the feet slide a little meanwhile. If the legs cannot stand
    there, the feet end side by side.
    """
    left, right = (_flat(feet[side][None]) for side in ("L", "R"))
    ready = _legs(robot, left, right, _torso(robot, along(feet["L"], feet["R"], 0.5)[None]), q)
    if not np.all(ready.success):
        left, right = (_flat(foot_beside(np.zeros(3), side)[None]) for side in ("L", "R"))
        ready = _legs(robot, left, right, _torso(robot, np.zeros((1, 3))), q)
    way = ready.q[0] - q
    if np.abs(way).max() < _READY:
        return np.empty((0, robot.nq))

    def straight(count: int) -> Floats:
        return np.asarray(q + smooth(np.arange(1, count + 1) / count)[:, None] * way)

    return _slow_enough(robot, straight, q, round(_GETTING_READY / TICK), _READY_SPEED_SHARE)


def step_motion(robot: RobotModel, step: Footstep, q: Floats) -> Floats:
    """Return configurations at the ticks of a step from q, (n, nq); its period is extended if joints are too slow."""

    def at(ticks: int) -> Floats:
        time = np.arange(1, ticks + 1) / ticks
        swing = np.clip((time - 0.5 * _DOUBLE_SUPPORT) / (1.0 - _DOUBLE_SUPPORT), 0.0, 1.0)
        moving = along(step.start, step.end, smooth(swing))
        height = step.height * 16.0 * np.square(swing * (1.0 - swing))
        standing = np.broadcast_to(step.support, moving.shape)
        first, last = (along(step.support, foot, 0.5) for foot in (step.start, step.end))
        torso = _torso(robot, along(first, last, smooth(time)))
        feet = {step.side: _flat(moving, height), other(step.side): _flat(standing)}
        return _all_of(_legs(robot, feet["L"], feet["R"], torso, q))

    ticks = max(2, math.ceil(step.period / TICK - 1e-9))
    return _slow_enough(robot, at, q, ticks, _SPEED_SHARE)


def _slow_enough(robot: RobotModel, at: Callable[[int], Floats], q: Floats, ticks: int, share: float) -> Floats:
    """Return a motion of at least `ticks` ticks in which no joint needs more than a fraction of its largest speed.

    A step is rejected if a joint jumps to another branch of the legs' solutions: more time does not help there.
    """
    max_ticks = _MAX_STRETCH * ticks
    while True:
        motion = at(ticks)
        speeds = np.abs(np.diff(np.vstack([q, motion]), axis=0)) / TICK
        used = speeds.max(axis=0) / robot.velocity_limits / share
        if used.max() <= 1.0:
            return motion
        ticks = math.ceil(ticks * max(float(used.max()), 1.02))
        if ticks > max_ticks:
            raise BadArgument(f"{_IMPOSSIBLE}: {robot.joint_names[int(np.argmax(used))]} would have to jump")


def _all_of(result: ik.LegsResult) -> Floats:
    missed = np.flatnonzero(~np.asarray(result.success))
    if missed.size:
        raise BadArgument(f"{_IMPOSSIBLE}: {result.describe((int(missed[0]),))}")
    return result.q


def _legs(robot: RobotModel, left: Floats, right: Floats, torso: Floats, q: Floats) -> ik.LegsResult:
    """Solve both legs in closed form; the torso's yaw is adapted so that the shared hip motor reaches both feet."""
    return ik.legs(robot, left, right, base="floating", torso=torso, free="yaw", near=q)


def _flat(places: Floats, height: Floats | float = 0.0) -> Floats:
    """Return level poses of positions on the floor, shape (n, 4, 4)."""
    six = np.zeros((len(places), 6))
    six[:, :2], six[:, 2], six[:, 5] = places[:, :2], height, places[:, 2]
    return pose(six)


def _torso(robot: RobotModel, places: Floats) -> Floats:
    """Return level poses of the torso above positions on the floor, at the height of StandInit, shape (n, 4, 4)."""
    return _flat(places, -float(robot.fk(robot.posture("StandInit"), "LLeg")[2, 3]))
