"""From a person's skeleton to a motion that the robot can play: gaps, smoothing, directions, speeds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import Floats, as_floats, check_tolerance, choice, flag, norm
from nao_kin._core.warn import need_extra
from nao_kin.errors import BadArgument, DegeneratePoints, WrongShape
from nao_kin.imitation.arms import make_room, opened, places_of_hands
from nao_kin.imitation.bones import CONFIDENCE
from nao_kin.imitation.directions import DIRECTIONS, Directions, mirrored
from nao_kin.imitation.limbs import Clamp, LimbMap
from nao_kin.imitation.skeleton import POINTS, Skeleton, lacking_notes, left_and_trunk
from nao_kin.imitation.stance import followed, in_place, stood
from nao_kin.motion import Change, Motion, MotionReport, check, clamp, slow_down
from nao_kin.robot import CollisionRule, RobotModel
from nao_kin.rotations import nearest_rotation, rot_z

# The points that nothing needs.
_NEEDLESS = ("chest", "left_thumb", "right_thumb")
# Length of a NAO's trunk, from the hips to the shoulders [m]: of the figure beside it.
_TRUNK = 0.185
# Samples per second of the check's collisions.
_RATE = 200.0
# Distance of the stick figure from the robot [m].
_BESIDE = 0.4
# Straight lines across longer gaps than this [s] are noted with their length.
_NOTED = 1.0
# In a longer pause between frames [s] nobody knows what the person did.
_PAUSE = 5.0
# Times that differ from evenly spaced ones by less than this share of a frame are evenly spaced.
_EVEN = 0.01
# How often limbs make room for legs that stand otherwise because they have.
_ROOMS = 3
# Order of the low-pass filter, which runs forward and backward.
_ORDER = 2


@dataclass(frozen=True, eq=False)
class Imitation:
    """A person's motion as that of a robot.

    Attributes:
        motion: the motion that the robot can play: of arms and head, of the legs unless they are ignored, and of the
            hands if the skeleton has fingers.
        times: the frames that were imitated, shape (n,) [s]: those of the skeleton, evenly spaced if it was smoothed.
        played: the time of each frame in `motion`, which has a key there, shape (n,) [s].
        q: the configuration of each frame, shape (n, nq).
        errors: name → angles between the person's directions and the robot's, shape (n,) [rad], NaN where unknown: of
            upper arms, forearms, hands and gaze.
        clamped: name → why, shape (n,), a sum: 1 if ShoulderPitch, ElbowYaw, WristYaw or HeadYaw is at its limit, 2 if
            ShoulderRoll, ElbowRoll or HeadPitch is, 4 for an unknown direction, 8 for an arm or head that made room.
        lean: the share of the trunk's lean that the feet allow, shape (n,); NaN if the legs are ignored.
        changes: how the motion was changed so that it can be played, as in `nk.motion.MendedMotion`.
        report: what a check of the motion found, as of `nk.motion.check`.
        notes: on the skeleton, unknown points, steps and frames.
        skeleton: the person.
    """

    motion: Motion
    times: Floats
    played: Floats
    q: Floats
    errors: Mapping[str, Floats]
    clamped: Mapping[str, NDArray[np.int64]]
    lean: Floats
    changes: tuple[Change, ...]
    report: MotionReport
    notes: tuple[str, ...]
    skeleton: Skeleton

    @property
    def ok(self) -> bool:
        """Whether the check of the motion found no violation."""
        return self.report.ok

    def as_dict(self) -> dict[str, Any]:
        """Return the result for JSON: mean and largest angles [rad], shares of frames, changes, check and notes."""
        directions = {}
        for name, errors in self.errors.items():
            known, codes = errors[np.isfinite(errors)], self.clamped[name]
            if len(known):
                outside, room = ((codes & flags) > 0 for flags in (Clamp.FIRST | Clamp.SECOND, Clamp.LINKS))
                directions[name] = {"mean": float(known.mean()), "most": float(known.max())} | {
                    "outside_limits": float(np.mean(outside)),
                    "made_room": float(np.mean(room)),
                }
        return {
            "frames": len(self.times),
            "start": float(self.times[0]),
            "end": float(self.times[-1]),
            "duration": self.motion.duration,
            "joints": list(self.motion.joint_names),
            "directions": directions,
            "least_lean": None if np.isnan(self.lean).any() else float(self.lean.min()),
            "changes": [change.as_dict() for change in self.changes],
            "check": self.report.as_dict(),
            "notes": list(self.notes),
        }

    def describe(self) -> str:
        """Return the error of each direction and how often limits or other links prevent it, changes, notes, check."""
        lines = []
        for name, row in self.as_dict()["directions"].items():
            degrees = np.rad2deg([row["mean"], row["most"]])
            line = f"{name.replace('_', ' ')}: {degrees[0]:.1f}° off, at most {degrees[1]:.1f}°"
            line += f"; {row['outside_limits']:.0%} outside of limits"
            lines.append(line + (f"; {row['made_room']:.0%} to make room" if row["made_room"] else ""))
        if (self.lean < 1.0).any():
            lines.append(f"trunk: {np.mean(self.lean < 1.0):.0%} with less lean, at least {self.lean.min():.0%} of it")
        changes = (change.describe() for change in self.changes)
        return "\n".join([*lines, *changes, *self.notes, self.report.describe()])

    def figure(self, times: ArrayLike) -> Floats:
        """Return the person as a stick figure beside the robot, for `Viewer.animate`.

        It is as large as the robot, 0.4 m to its left, faces the way the robot does, and stays in place, with its feet
        on the floor.

        Args:
            times: of the motion, shape (k,) [s].

        Returns:
            Both ends of each bone in the world, shape (k, bones, 2, 3) [m].
        """
        at = as_floats(times, (), "times")
        if at.ndim != 1:
            raise WrongShape("times", "(k,)", at.shape)
        at = np.interp(at, self.played, self.times)
        bones = self.skeleton.bones
        left, trunk = left_and_trunk(self.skeleton.points)
        scale = _TRUNK / float(np.nanmedian(norm(trunk)))
        turned = bones @ rot_z(float(np.arctan2(*np.nanmedian(left[:, :2] * (-1.0, 1.0), axis=0))))
        columns = scale * turned.reshape(len(bones), -1)
        found = np.stack([_bridged(self.skeleton.times, column, at) for column in columns.T], axis=1)
        figure = found.reshape(len(at), *bones.shape[1:])
        low = np.nan_to_num(np.nanmin(figure[..., 2], axis=(1, 2)))
        figure[..., 2] -= low[:, None, None]
        figure[..., :2] -= np.nanmean(figure[:, :2, :, :2], axis=(1, 2))[:, None, None]
        figure[..., 1] += _BESIDE
        return figure

    def __repr__(self) -> str:
        joints, seconds = len(self.motion.joint_names), self.motion.duration
        return f"<Imitation: {len(self.times)} frames, {joints} joints, {seconds:.4g} s, {self.report!r}>"


def imitate(
    robot: RobotModel,
    skeleton: Skeleton,
    *,
    arms: bool = True,
    head: bool = True,
    legs: Literal["stand", "follow", "ignore"] = "stand",
    mirror: bool = False,
    cutoff: float = 4.0,
    weights: Mapping[str, float] | None = None,
    collisions: bool | CollisionRule = True,
) -> Imitation:
    """Return a person's motion as a motion that the robot can play.

    Directions count, not places: upper arms, forearms and hands, and the face, get the directions in the torso that
    they have in the person's. Where the joints do not reach them, arms take the path through all frames with the least
    weighted squared errors and speeds, and the face the nearest direction. Unknown points, and those with a confidence
    below 0.5, are bridged in time by straight lines; notes say in how many frames, and for how long. Arms that overlap
    other links move outwards. Then time is stretched where a joint would be too fast, and, unless legs are ignored, as
    a whole until the robot does not tip.

    Args:
        robot: a NAO of any version, or another robot with arms, a neck and, unless they are ignored, legs of its
            geometry.
        skeleton: the person.
        arms: whether arms move; otherwise they keep their values in the posture "StandInit".
        head: whether the head moves.
        legs: "stand" keeps both feet in place, and legs lean the trunk as the person's leans, as far as balance allows;
            "follow" also takes the person's steps and height of the hips; "ignore" leaves out the legs.
        mirror: whether the robot is the person's mirror image, such as of someone who faces it.
        cutoff: the frequency [Hz] above which motion of the points is filtered out, by a Butterworth filter of second
            order that runs forward and backward; 0 for no filter. Frames that are not evenly spaced become so.
        weights: of the squares in the cost of the arms' path, by name; those that are not given keep their defaults.
            "upper_arm", 1, and "forearm", 1, of errors of directions [rad²]; "hand", 0.05, of the error of the back of
            the hand about the forearm [rad²]; "place", 0, of the distance of the hand from the person's place about the
            middle of the shoulders, times the ratio of the spans, as a share of the arm's length; "speed", 0.01, of
            speeds of joints as shares of their limits.
        collisions: whether arms make room for other links, as in `nk.motion.check`: True, or a
            `nk.robot.CollisionRule` with an overlap that is accepted. They stay 2 mm farther away.

    Raises:
        UnknownName: an unknown weight.
        BadArgument: the robot has no arms, neck or legs of this geometry; the cut-off or a weight is below zero;
            frames are more than 5 s apart, so that nobody knows what the person did: `Skeleton.between` takes a part;
            hips or ankles are unknown, which legs="follow" needs.
        DegeneratePoints: no frame shows where the shoulders or hips are.
        MissingExtra: SciPy is not installed, which filters; a cut-off of 0 needs none.

    Examples:
        >>> nao = nk.load_nao()
        >>> wave = nk.imitation.imitate(nao, nk.imitation.read_skeleton(nk.imitation.SAMPLES["wave"]))
        >>> wave.ok
        True
    """
    check_tolerance(cutoff, "cutoff")
    choice(legs, ("stand", "follow", "ignore"), "treatment of legs")
    rule, solver = CollisionRule.of(collisions), LimbMap(robot)
    _refuse_pauses(skeleton.times)
    times, points, turned, notes = _filtered(skeleton, float(cutoff))
    if flag(mirror, "mirror"):
        points, turned = mirrored(points, turned)
    person = Directions.of(points, turned)
    torso = person.torso
    if not np.isfinite(torso).all():
        raise DegeneratePoints(f"no frame has shoulders or hips that are known with a confidence of {CONFIDENCE:g}")
    lacking = lacking_notes(skeleton.points, skeleton.orientations)
    wanted = person.only(arms=flag(arms, "arms"), head=flag(head, "head"))
    start = start_of(robot)
    seconds, places = np.diff(times, prepend=-np.inf), places_of_hands(solver, points, wanted)
    q = solver.solve(wanted, start, seconds=seconds, weights=weights, places=places)
    hands = opened(robot, points, q)
    lean, least, stance, misses = np.full(len(q), np.nan), np.zeros(len(q) - 1), None, 0
    moved = np.zeros((len(q), 3), dtype=bool)
    if legs != "ignore":
        stance = in_place(robot, start, torso) if legs == "stand" else followed(robot, start, times, points, torso)
        least, notes = stance.least, (*notes, *stance.notes)
        q, lean, misses = stood(robot, times, q, stance, solver.columns)
    if rule is not None and arms:
        # Legs that stand otherwise may come near to arms.
        for _ in range(_ROOMS):
            q, moved_now = make_room(robot, solver, times, q, rule)
            moved |= moved_now
            if stance is None or not moved_now.any():
                break
            q, lean, misses = stood(robot, times, q, stance, solver.columns)
    errors, codes = solver.errors(wanted, q)
    codes[:, [0, 1, 3, 4, 6]] |= np.where(moved, int(Clamp.LINKS), 0)[:, [0, 0, 1, 1, 2]]
    joints = [name for k, name in enumerate(robot.joint_names) if k + robot.nq_base in {*solver.columns, *hands}]
    if stance is not None:
        joints = [name for name in robot.joint_names if robot.unit(name) == "rad" or name in joints]
    at = [robot.joint_names.index(name) + robot.nq_base for name in joints]
    steps = np.maximum(np.diff(times), least)
    motion = Motion(np.concatenate([[0.0], np.cumsum(steps)]), joints, q[:, at])
    motion, played, changes, more = _playable(robot, motion, start, balance=legs != "ignore" and not misses)
    if (steps > np.diff(times) + 1e-9).any():
        notes = (*notes, f"{(steps - np.diff(times)).sum():.3g} s more for shifting the weight from foot to foot")
    if misses:
        notes = (*notes, f"no balanced pose was found for {misses} of {len(q)} frames")
    return Imitation(
        motion=motion,
        times=times,
        played=played,
        q=q,
        errors=dict(zip(DIRECTIONS, errors.T, strict=True)),
        clamped=dict(zip(DIRECTIONS, codes.T, strict=True)),
        lean=lean,
        changes=changes,
        report=check(robot, motion, fill=start, rate=_RATE, collisions=rule or False, balance=stance is not None),
        notes=tuple(dict.fromkeys((*skeleton.notes, *lacking, *notes, *person.notes, *more))),
        skeleton=skeleton,
    )


def _bridged(times: Floats, column: Floats, at: Floats) -> Floats:
    """Return a column at other times, with straight lines across gaps; NaN if it is unknown."""
    known = np.isfinite(column)
    return np.interp(at, times[known], column[known]) if known.any() else np.full(len(at), np.nan)


def _playable(
    robot: RobotModel, motion: Motion, start: Floats, *, balance: bool
) -> tuple[Motion, Floats, tuple[Change, ...], tuple[str, ...]]:
    """Return the motion inside limits and speed limits and, with `balance`, without tipping.

    Also return the time of each of its frames, changes, and notes.
    """
    inside = clamp(robot, motion, fill=start)
    # Keys between frames may be new; slower motions keep all keys.
    keys = np.searchsorted(inside.motion.key_times, motion.key_times - 1e-9)
    played = slow_down(robot, inside.motion)
    changes, notes = inside.changes + played.changes, list[str]()
    if balance and motion.duration > 0.0:
        try:
            played = slow_down(robot, played.motion, balance=True, fill=start)
            changes += played.changes
        except BadArgument as reason:
            notes.append(str(reason))
    return played.motion, played.motion.key_times[keys], changes, tuple(notes)


def start_of(robot: RobotModel) -> Floats:
    """Return the posture before the first frame."""
    names = robot.semantics.postures
    return robot.clamp(robot.posture("StandInit") if "StandInit" in names else robot.neutral())


def _refuse_pauses(times: Floats) -> None:
    """Raise where frames are so far apart that filling the time between would be made up, and may have no end."""
    steps = np.diff(times)
    if len(steps) and steps.max() > _PAUSE:
        k = int(steps.argmax())
        raise BadArgument(
            f"no frames between {times[k]:.6g} and {times[k + 1]:.6g} s; frames more than {_PAUSE:g} s apart are not "
            "joined: take a part with between() (--start, --end), or mend the times, which are in seconds"
        )


def _longest_gap(times: Floats, known: NDArray[np.bool_]) -> float:
    """Return the longest time between two known frames with unknown ones between, or to an end [s]."""
    ends = np.concatenate([times[:1], times[known], times[-1:]])
    unknown = np.concatenate([[not known[0]], np.diff(np.flatnonzero(known)) > 1, [not known[-1]]])
    return float(np.max(np.diff(ends)[unknown], initial=0.0)) if known.any() else float(times[-1] - times[0])


def _filtered(
    skeleton: Skeleton, cutoff: float
) -> tuple[Floats, dict[str, Floats], dict[str, Floats], tuple[str, ...]]:
    """Return evenly spaced times, points and orientations without gaps and without fast motion, and notes on gaps."""
    times, notes = skeleton.times, []
    even, rate = times, 0.0
    if cutoff > 0.0 and len(times) > 1:
        rate = 1.0 / float(np.median(np.diff(times)))
        spaced = np.linspace(times[0], times[-1], round(float(times[-1] - times[0]) * rate) + 1)
        if len(spaced) != len(times) or np.abs(spaced - times).max() * rate > _EVEN:
            even = spaced
    found: list[dict[str, Floats]] = [{}, {}]
    needed = {name: skeleton.points[name] for name in POINTS if name in skeleton.points and name not in _NEEDLESS}
    for k, arrays in enumerate((needed, skeleton.orientations)):
        for name, array in arrays.items():
            columns = np.array(array).reshape(len(times), -1)
            known: NDArray[np.bool_] = np.asarray(np.isfinite(columns).all(axis=1))
            if k == 0:
                known &= skeleton.confidence.get(name, np.ones(len(times))) >= CONFIDENCE
            if not known.all():
                label = name.replace("_", " ") + (" is unknown" if k == 0 else "'s orientation is unknown")
                bridged = _longest_gap(times, known)
                span = f", for up to {bridged:.2g} s" if bridged >= _NOTED else ""
                notes.append(f"{label} in {np.count_nonzero(~known)} of {len(times)} frames{span}")
            if not known.any():
                found[k][name] = np.full((len(even), *array.shape[1:]), np.nan)
                continue
            columns = np.stack([_bridged(times, np.where(known, column, np.nan), even) for column in columns.T], axis=1)
            if 0.0 < cutoff < 0.5 * rate:
                columns = _low_pass(columns, cutoff / rate)
            values = columns.reshape(len(even), *array.shape[1:])
            found[k][name] = values if k == 0 else nearest_rotation(values)
    return even, found[0], found[1], tuple(notes)


def _low_pass(columns: Floats, cutoff: float) -> Floats:
    """Return columns without frequencies above the cut-off, given in cycles per row, and without delay."""
    need_extra("the filter of imitate (none with cutoff=0, --cutoff 0)", "calibration", "scipy")
    from scipy.signal import butter, sosfiltfilt

    sections = butter(_ORDER, 2.0 * cutoff, output="sos")
    return np.asarray(sosfiltfilt(sections, columns, axis=0, padlen=min(len(columns) - 1, int(2.0 / cutoff))))
