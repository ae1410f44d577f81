"""From a person's skeleton to a motion that the robot can play: gaps, smoothing, directions, speeds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import Floats, as_floats, between_samples, check_tolerance, choice, flag, norm
from nao_kin.errors import BadArgument, DegeneratePoints, WrongShape
from nao_kin.imitation.arms import make_room, opened, places_of_hands
from nao_kin.imitation.bones import CONFIDENCE
from nao_kin.imitation.clips import clip_of
from nao_kin.imitation.directions import DIRECTIONS, Directions, mirrored
from nao_kin.imitation.limbs import Clamp, LimbMap
from nao_kin.imitation.skeleton import Skeleton, lacking_notes, left_and_trunk
from nao_kin.imitation.smoothing import filtered
from nao_kin.imitation.stance import base_in, followed, in_place, stood
from nao_kin.motion import Change, Motion, MotionReport, check, clamp, concatenate, slow_down
from nao_kin.robot import CollisionRule, RobotModel
from nao_kin.rotations import rot_z

# Length of a NAO's trunk, from the hips to the shoulders [m]: of the figure beside it.
_TRUNK = 0.185
# Samples per second of the check's collisions.
_RATE = 200.0
# Distance of the stick figure from the robot [m].
_BESIDE = 0.4
# In a longer pause between frames [s] nobody knows what the person did.
_PAUSE = 5.0
# How often limbs make room for legs that stand otherwise because they have.
_ROOMS = 3


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
        T_world_base: the pose of the robot's root in each frame, in which feet on the floor stay in place, with heading
            and steps of legs="follow"; shape (n, 4, 4) [m].
        contacts: which feet, left and right, are on the floor, shape (n, 2).
        lean: the share of the trunk's lean that the feet allow, shape (n,); NaN if the legs are ignored.
        missed: the frames for which no balanced pose was found, shape (k,); their legs are interpolated.
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
    T_world_base: Floats
    contacts: NDArray[np.bool_]
    lean: Floats
    missed: NDArray[np.intp]
    changes: tuple[Change, ...]
    report: MotionReport
    notes: tuple[str, ...]
    skeleton: Skeleton

    @property
    def ok(self) -> bool:
        """Whether the check of the motion found no violation, and a balanced pose was found for each frame."""
        return self.report.ok and not len(self.missed)

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
        figure = between_samples(columns, self.skeleton.times, at).reshape(len(at), *bones.shape[1:])
        low = np.nan_to_num(np.nanmin(figure[..., 2], axis=(1, 2)))
        figure[..., 2] -= low[:, None, None]
        figure[..., :2] -= np.nanmean(figure[:, :2, :, :2], axis=(1, 2))[:, None, None]
        figure[..., 1] += _BESIDE
        return figure

    def clip(self, robot: RobotModel) -> dict[str, NDArray[Any]]:
        """Return the motion of a floating base in the person's own time, for reinforcement learning.

        Joints have limits, room and lean as in `motion`, but times are the person's: speeds may be above the limits.

        Args:
            robot: the robot that imitates.

        Returns:
            Arrays for `numpy.savez`, with 50 frames a second, as BeyondMimic's and mjlab's `csv_to_npz` writes them:
            fps (1,), joint_pos and joint_vel (frames, joints), body_pos_w, body_quat_w (scalar first), body_lin_vel_w
            and body_ang_vel_w (frames, bodies, …); as GMR's pickles have them: root_pos, root_rot (scalar last),
            dof_pos, local_body_pos, link_body_list; and dof_names, body_names, and contacts (frames, 2) of the left and
            the right foot. Joints, with the mimic joints, and bodies are in the order of `nk.export.mjcf`.

        Examples:
            >>> nao = nk.load_nao()
            >>> wave = nk.imitation.imitate(nao, nk.imitation.read_skeleton(nk.imitation.SAMPLES["wave"]))
            >>> wave.clip(nao)["body_pos_w"].shape
            (161, 43, 3)
        """
        q = self.motion.configurations(robot, times=self.played, missing=self.q[0]).q
        return clip_of(robot, self.times, q, self.T_world_base, self.contacts)

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
    lead: float = 0.0,
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
        lead: the time [s] in which the robot moves from the posture "StandInit" to the first frame, and from the last
            one back to it. The motion then begins with the keys of the first frame, at this time: NAOqi moves there
            from where the robot is, and refuses keys at 0 s.

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
    check_tolerance(lead, "lead")
    choice(legs, ("stand", "follow", "ignore"), "treatment of legs")
    rule, solver = CollisionRule.of(collisions), LimbMap(robot)
    _refuse_pauses(skeleton.times)
    times, points, turned, notes = filtered(skeleton, float(cutoff))
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
    lean, least, stance, misses = np.full(len(q), np.nan), np.zeros(len(q) - 1), None, np.zeros(0, dtype=np.intp)
    moved = np.zeros((len(q), 3), dtype=bool)
    if legs != "ignore":
        stance = in_place(robot, start, torso) if legs == "stand" else followed(robot, start, times, points, torso)
        least, notes = stance.least, (*notes, *stance.notes)
        q, lean, misses = stood(robot, times, q, stance, solver.columns, np.ones(len(q)), np.arange(len(q)))
    if rule is not None and arms:
        # Legs that stand otherwise may come near to arms.
        changed = np.ones(len(q), dtype=bool)
        for _ in range(_ROOMS):
            before, (q, moved_now) = q, make_room(robot, solver, times, q, rule, changed)
            moved |= moved_now
            if stance is None or not moved_now.any():
                break
            again = np.flatnonzero(moved_now.any(axis=1) | bool(len(misses)))
            q, lean, misses = stood(robot, times, q, stance, solver.columns, lean, again)
            changed = np.any(q != before, axis=1)
    errors, codes = solver.errors(wanted, q)
    codes[:, [0, 1, 3, 4, 6]] |= np.where(moved, int(Clamp.LINKS), 0)[:, [0, 0, 1, 1, 2]]
    joints = [name for k, name in enumerate(robot.joint_names) if k + robot.nq_base in {*solver.columns, *hands}]
    if stance is not None:
        joints = [name for name in robot.joint_names if robot.unit(name) == "rad" or name in joints]
    at = [robot.joint_names.index(name) + robot.nq_base for name in joints]
    steps = np.maximum(np.diff(times), least)
    motion = Motion(np.concatenate([[0.0], np.cumsum(steps)]), joints, q[:, at])
    rest = Motion([0.0], joints, start[None, at])
    motion = concatenate([rest, motion, rest], gap=lead) if lead else motion
    motion, played, changes, more = _playable(robot, motion, start, balance=legs != "ignore")
    report = check(robot, motion, missing=start, rate=_RATE, collisions=rule or False, balance=stance is not None)
    if lead:
        # The robot is in its first keys already.
        played = played[1:-1]
        motion = Motion([row[1:] for row in motion.times], joints, [row[1:] for row in motion.keys])
    framed = motion.configurations(robot, times=played, missing=start).q
    down = robot.set_down(framed).T_world_base if robot.semantics.soles else np.tile(np.eye(4), (len(q), 1, 1))
    if (steps > np.diff(times) + 1e-9).any():
        notes = (*notes, f"{(steps - np.diff(times)).sum():.3g} s more for shifting the weight from foot to foot")
    if len(misses):
        first = f"the first at {times[misses[0]]:.4g} s of the person"
        notes = (*notes, f"no balanced pose was found for {len(misses)} of {len(q)} frames, {first}: interpolated")
    return Imitation(
        motion=motion,
        times=times,
        played=played,
        q=q,
        errors=dict(zip(DIRECTIONS, errors.T, strict=True)),
        clamped=dict(zip(DIRECTIONS, codes.T, strict=True)),
        T_world_base=down if stance is None else base_in(robot, framed, stance),
        contacts=np.ones((len(q), 2), dtype=bool) if stance is None else stance.carries,
        lean=lean,
        missed=misses,
        changes=changes,
        report=report,
        notes=tuple(dict.fromkeys((*skeleton.notes, *lacking, *notes, *person.notes, *more))),
        skeleton=skeleton,
    )


def _playable(
    robot: RobotModel, motion: Motion, start: Floats, *, balance: bool
) -> tuple[Motion, Floats, tuple[Change, ...], tuple[str, ...]]:
    """Return the motion inside limits and speed limits and, with `balance`, without tipping.

    Also return the time of each of its frames, changes, and notes.
    """
    inside = clamp(robot, motion, missing=start)
    # Keys between frames may be new; slower motions keep all keys.
    keys = np.searchsorted(inside.motion.key_times, motion.key_times - 1e-9)
    played = slow_down(robot, inside.motion)
    changes, notes = inside.changes + played.changes, list[str]()
    if balance and motion.duration > 0.0:
        try:
            played = slow_down(robot, played.motion, balance=True, missing=start)
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
