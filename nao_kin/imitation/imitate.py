"""From a person's skeleton to a motion that the robot can play: gaps, smoothing, directions, speeds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats, check_tolerance, flag
from nao_kin._core.warn import need_extra
from nao_kin.errors import BadArgument
from nao_kin.imitation.limbs import DIRECTIONS, Clamp, Directions, LimbMap
from nao_kin.imitation.skeleton import POINTS, Skeleton
from nao_kin.motion import Change, Motion, clamp, slow_down
from nao_kin.robot import RobotModel, check_robot
from nao_kin.rotations import nearest_rotation

# Points with less confidence count as unknown.
_CONFIDENCE = 0.5
# The points that directions need.
_NEEDED = tuple(
    name for name in POINTS if name.split("_")[-1] not in ("hand", "thumb", "knee", "ankle", "toe", "chest")
)
# Times that differ from evenly spaced ones by less than this share of a frame are evenly spaced.
_EVEN = 0.01
# Order of the low-pass filter, which runs forward and backward.
_ORDER = 2


@dataclass(frozen=True, eq=False)
class Imitation:
    """A person's motion as that of a robot.

    Attributes:
        motion: the motion of arms and head, within limits and speed limits.
        times: the frames that were imitated, shape (n,) [s]: those of the skeleton, evenly spaced if it was smoothed.
        q: the configuration of each frame, before the motion was slowed down, shape (n, nq).
        errors: name → angles between the person's directions and the robot's, shape (n,) [rad], NaN where unknown: of
            upper arms, forearms, hands and gaze.
        clamped: name → why, shape (n,): 1 if ShoulderPitch, ElbowYaw, WristYaw or HeadYaw is at its limit, 2 if
            ShoulderRoll, ElbowRoll or HeadPitch is, 3 if both are, 4 for an unknown direction.
        changes: how the motion was changed so that it can be played, as in `nk.motion.MendedMotion`.
        notes: on the skeleton, unknown points and frames.
    """

    motion: Motion
    times: Floats
    q: Floats
    errors: Mapping[str, Floats]
    clamped: Mapping[str, NDArray[np.int64]]
    changes: tuple[Change, ...]
    notes: tuple[str, ...]

    def describe(self) -> str:
        """Return the mean error of each direction and how often it was outside of the limits, changes and notes."""
        lines = []
        for name, errors in self.errors.items():
            if np.isfinite(errors).any():
                share = np.mean((self.clamped[name] & (Clamp.FIRST | Clamp.SECOND)) > 0)
                degrees = np.rad2deg(np.nanmean(errors)), np.rad2deg(np.nanmax(errors))
                label = name.replace("_", " ")
                lines.append(
                    f"{label}: {degrees[0]:.1f}° off, at most {degrees[1]:.1f}°; {share:.0%} outside of limits"
                )
        return "\n".join([*lines, *(change.describe() for change in self.changes), *self.notes])


def imitate(
    robot: RobotModel,
    skeleton: Skeleton,
    *,
    arms: bool = True,
    head: bool = True,
    mirror: bool = False,
    cutoff: float = 4.0,
    slack: float = 0.1,
) -> Imitation:
    """Return a person's motion as a motion of the robot's arms and head.

    Directions count, not places: each upper arm, forearm and hand, and the face, gets the direction in the torso that
    it has in the person's, or the nearest that the joints reach. Unknown points, and those with a confidence below 0.5,
    are bridged in time by straight lines. Then time is stretched where a joint would be too fast.

    Args:
        robot: a NAO of any version, or another robot with arms and a neck of its geometry.
        skeleton: the person.
        arms: whether arms move; otherwise they keep their values in the posture "StandInit".
        head: whether the head moves.
        mirror: whether the robot is the person's mirror image, such as of someone who faces it.
        cutoff: the frequency [Hz] above which motion of the points is filtered out, by a Butterworth filter of second
            order that runs forward and backward; 0 for no filter. Frames that are not evenly spaced become so.
        slack: how much farther than necessary [rad] a forearm in line with the upper arm, and an upper arm out to the
            side, may be from their directions, to move less: there, small errors turn joints far. It falls to zero at
            four times this angle from the line.

    Raises:
        BadArgument: the robot has no arms or neck of this geometry, or the cut-off or the slack is below zero.
        MissingExtra: SciPy is not installed, which filters; a cut-off of 0 needs none.

    Examples:
        >>> nao = nk.load_nao()
        >>> wave = nk.imitation.imitate(nao, nk.imitation.read_skeleton(nk.imitation.SAMPLES["wave"]))
        >>> nk.motion.check(nao, wave.motion).ok
        True
    """
    check_robot(robot)
    if not isinstance(skeleton, Skeleton):
        raise BadArgument(f"skeleton must be a Skeleton, as from read_skeleton, got {type(skeleton).__name__}")
    check_tolerance(cutoff, "cutoff")
    solver = LimbMap(robot)
    times, points, turned, notes = _filtered(skeleton, float(cutoff))
    person = Directions.of(points, turned)
    if flag(mirror, "mirror"):
        person = person.mirrored()
    if not flag(arms, "arms"):
        person = replace(
            person,
            upper_arms=person.upper_arms * np.nan,
            forearms=person.forearms * np.nan,
            hands=person.hands * np.nan,
        )
    if not flag(head, "head"):
        person = replace(person, gaze=person.gaze * np.nan)
    solved = solver.solve(person, robot.clamp(_start(robot)), slack=slack)
    motion = Motion(times - times[0], solver.joints, solved.q[:, solver.columns])
    inside = clamp(robot, motion)
    played = slow_down(robot, inside.motion)
    return Imitation(
        motion=played.motion,
        times=times,
        q=solved.q,
        errors=dict(zip(DIRECTIONS, solved.errors.T, strict=True)),
        clamped=dict(zip(DIRECTIONS, solved.codes.T, strict=True)),
        changes=inside.changes + played.changes,
        notes=(*skeleton.notes, *notes, *person.notes),
    )


def _start(robot: RobotModel) -> Floats:
    """Return the posture before the first frame."""
    return robot.posture("StandInit") if "StandInit" in robot.semantics.postures else robot.neutral()


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
    needed = {name: skeleton.points[name] for name in _NEEDED if name in skeleton.points}
    for k, arrays in enumerate((needed, skeleton.orientations)):
        for name, array in arrays.items():
            columns = np.array(array).reshape(len(times), -1)
            known = np.isfinite(columns).all(axis=1)
            if k == 0:
                known &= skeleton.confidence.get(name, np.ones(len(times))) >= _CONFIDENCE
            if not known.all():
                label = name.replace("_", " ") + (" is unknown" if k == 0 else "'s orientation is unknown")
                notes.append(f"{label} in {np.count_nonzero(~known)} of {len(times)} frames")
            if not known.any():
                found[k][name] = np.full((len(even), *array.shape[1:]), np.nan)
                continue
            columns = np.stack([np.interp(even, times[known], column[known]) for column in columns.T], axis=1)
            if 0.0 < cutoff < 0.5 * rate:
                columns = _low_pass(columns, cutoff / rate)
            values = columns.reshape(len(even), *array.shape[1:])
            found[k][name] = values if k == 0 else nearest_rotation(values)
    return even, found[0], found[1], tuple(notes)


def _low_pass(columns: Floats, cutoff: float) -> Floats:
    """Return columns without frequencies above the cut-off, given in cycles per row, and without delay."""
    need_extra("imitate with a cut-off frequency", "calibration", "scipy")
    from scipy.signal import butter, sosfiltfilt

    sections = butter(_ORDER, 2.0 * cutoff, output="sos")
    return np.asarray(sosfiltfilt(sections, columns, axis=0, padlen=min(len(columns) - 1, int(2.0 / cutoff))))
