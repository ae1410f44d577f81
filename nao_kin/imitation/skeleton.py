"""A person as named points in the course of time, whatever recorded them, with axes, size and handedness checked.

World axes are right-handed with z up. Sources differ in the names, axes and units of their points; `layouts.toml` has
the names and axes of each, and the size of the person's trunk tells the unit.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import Floats, as_floats, choice, cross, dot, norm, positive, shaped, single_number, texts
from nao_kin._core.text import one_line_repr
from nao_kin.errors import BadArgument, DegeneratePoints, WrongShape
from nao_kin.imitation.bones import misfit
from nao_kin.imitation.layouts import LAYOUTS, LIMBS, POINTS, SIDES, Layout, by_joint, check_shoulders, landmark_array

PARTS = ("pelvis", "chest", "head", "left_hand", "right_hand")

# The bones of a stick figure, those of the trunk first; "a + b" is the middle of two points.
_NECK, _LOINS = "left_shoulder + right_shoulder", "left_hip + right_hip"
_ENDS = ((*LIMBS[0], "hand"), (*LIMBS[1], "toe"))
_BONES = (
    (_NECK, "head"),
    (_NECK, _LOINS),
    *((SIDES[0] + limb[0], SIDES[1] + limb[0]) for limb in _ENDS),
    *((side + one, side + two) for side in SIDES for limb in _ENDS for one, two in pairwise(limb)),
)

UNITS: Mapping[str, float] = MappingProxyType(
    {"m": 1.0, "cm": 0.01, "mm": 0.001, "inch": 0.0254, "cmu": 0.0254 / 0.45}  # cmu: of CMU's skeletons, 1/0.45 inch
)
# The axes that point ahead, left and up, for each axis that may point up.
_AXES = ("x y z", "z x y", "-z x -y", "x -y -z", "y z x", "y -z -x")
UP_AXES: Mapping[str, tuple[str, ...]] = MappingProxyType({text.split()[2]: tuple(text.split()) for text in _AXES})
# Points that show, with both ears, where the face looks.
_FACES = (("nose",), ("left_eye", "right_eye"))
_FACE = ("neck", "head", "nose", "left_ear", "right_ear")
# The distance from the middle of the hips to the middle of the shoulders of an adult [m].
_TRUNK_LENGTH = 0.5
# A trunk that is shorter than this [m] has no direction.
_SMALLEST = 1e-6
# Of landmarks in an image, x and y are between 0 and 1, and the hips are farther than this from the origin.
_IMAGE_HIPS = 0.1
# Along an axis that points up, the lowest point is within this part of the trunk from zero; a root that moves less
# shows no floor.
_FLOOR, _STAYS = 0.2, 0.02
# In left-handed axes, face, toes and knees point backwards; the sum of their cosines is below this, by as much more in
# a single frame: there, errors of 3 cm in all points may give -1.3.
_BACKWARDS, _BACKWARDS_OF_A_FRAME = -0.5, -0.8


@one_line_repr
@dataclass(frozen=True, eq=False)
class Skeleton:
    """The points of a person at given times, in a right-handed world frame with z up.

    Attributes:
        times: shape (n,), ascending [s].
        points: name → positions, shape (n, 3) [m], NaN where unknown. The names are some of `POINTS`: the joints; hand
            is the knuckle of the middle finger, thumb its tip, toe the tip or ball of the foot, head a point in or on
            the head.
        orientations: name → R_world_part, shape (n, 3, 3), NaN where unknown; often empty. The names are some of
            `PARTS`. Axes of pelvis, chest and head: x ahead, y left, z up; of a hand: x from the wrist to the knuckles,
            z out of its back.
        confidence: name → shape (n,), in [0, 1]; points without an entry count as certain.
        source: the naming that the points come from, such as "mediapipe".
        notes: what was decided in reading the points: units, axes, corrections.

    Raises:
        UnknownName: a name is not in `POINTS` or `PARTS`.
        WrongShape: an array has another shape.
        BadArgument: times do not ascend; shoulders or hips are missing.
        DegeneratePoints: all points are equal, or no point is known.

    Examples:
        >>> points = {"left_shoulder": [[0, 0.2, 1.4]], "right_shoulder": [[0, -0.2, 1.4]], "pelvis": [[0, 0, 0.9]]}
        >>> nk.imitation.Skeleton([0.0], points).names
        ('pelvis', 'left_shoulder', 'right_shoulder')
    """

    times: Floats
    points: Mapping[str, Floats]
    orientations: Mapping[str, Floats] = field(default_factory=dict)
    confidence: Mapping[str, Floats] = field(default_factory=dict)
    source: str = "points"
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        times = as_floats(self.times, (), "times").copy()
        if times.ndim != 1 or not len(times):
            raise WrongShape("times", "(n,) with n ≥ 1", times.shape)
        back = np.flatnonzero(np.diff(times) <= 0.0)
        if len(back):
            k = int(back[0]) + 1
            raise BadArgument(f"times must ascend, but times[{k}] = {times[k]:.9g} follows {times[k - 1]:.9g}")
        times.flags.writeable = False
        object.__setattr__(self, "times", times)
        tails = (("points", (3,), POINTS), ("orientations", (3, 3), PARTS), ("confidence", (), POINTS))
        for name, tail, valid in tails:
            given = getattr(self, name)
            for key in given:
                choice(key, valid, "point" if valid is POINTS else "part with an orientation")
            checked = {
                key: shaped(given[key], (len(times), *tail), f"{name} of {key}", gaps=True).copy()
                for key in valid
                if key in given
            }
            for array in checked.values():
                array.flags.writeable = False
            object.__setattr__(self, name, MappingProxyType(checked))
        object.__setattr__(self, "notes", texts(self.notes, "notes"))
        check_points(self.points)

    def __len__(self) -> int:
        """Return the number of frames."""
        return len(self.times)

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the points, in the order of `POINTS`."""
        return tuple(self.points)

    def between(self, start: float | None = None, end: float | None = None) -> Skeleton:
        """Return the frames between two times, which are part of it [s]; None for the first and the last frame.

        Raises:
            BadArgument: no frame is between them.

        Examples:
            >>> wave = nk.imitation.read_skeleton(nk.imitation.SAMPLES["wave"])
            >>> len(wave), len(wave.between(1.0, 2.0))
            (65, 21)
        """
        low, high = (
            ends if limit is None else single_number(limit, what)
            for limit, what, ends in ((start, "start", self.times[0]), (end, "end", self.times[-1]))
        )
        rows = (self.times >= low) & (self.times <= high)
        if not rows.any():
            whole = f"{self.times[0]:.6g} to {self.times[-1]:.6g} s"
            raise BadArgument(f"no frame from {low:.6g} to {high:.6g} s; the skeleton has {whole}")

        parts: dict[str, Any] = {
            field: {name: array[rows] for name, array in getattr(self, field).items()}
            for field in ("points", "orientations", "confidence")
        }
        return replace(self, times=self.times[rows], **parts)

    @property
    def bones(self) -> Floats:
        """Both ends of each bone of a stick figure, for `Viewer.animate`, shape (n, bones, 2, 3) [m]."""

        def ends(name: str) -> Floats | None:
            parts = [self.points[part] for part in name.split(" + ") if part in self.points]
            return np.asarray(np.mean(parts, axis=0)) if len(parts) > name.count("+") else None

        pairs = [(ends(one), ends(two)) for one, two in _BONES]
        return np.stack([np.stack([one, two], axis=1) for one, two in pairs if one is not None and two is not None], 1)

    @classmethod
    def from_landmarks(
        cls,
        landmarks: ArrayLike,
        source: str,
        *,
        times: ArrayLike | None = None,
        rate: float | None = None,
        units: str | None = None,
        up: str | None = None,
    ) -> Skeleton:
        """Return the skeleton of an array of points in the order of a source, such as a webcam program has them.

        Args:
            landmarks: shape (n, k, 3) or (n, k, 4), the fourth entry a confidence; (k, 3) or (k, 4) for one frame. NaN
                for unknown points. k is the number of points of the source.
            source: "mediapipe" (k = 33, world landmarks), "kinect_v2" (25), "kinect_v1" or "msr" (20), "azure_kinect"
                (32), "nite", "kard" or "cad60" (15), "coco17", "coco18", "body25", "h36m17", "h36m32" or "smpl" (24,
                or 22, 52 or 55).
            times: shape (n,), ascending [s]. Without times and rate, there must be one frame, whose time is 0.
            rate: frames per second, instead of times.
            units: "m", "cm", "mm", "inch" or "cmu" (1/0.45 inch); None finds it by the size of the trunk.
            up: the axis that points up, "z", "y", "-y" and so on; None for the axes of the source, or, if it has none,
                the axis along which the trunk is longest in the median frame.

        Raises:
            UnknownName: an unknown source, unit or axis.
            WrongShape, BadArgument, DegeneratePoints: the array has another shape, is two-dimensional, lacks shoulders
                or hips, or times do not ascend.

        Examples:
            >>> landmarks = np.random.default_rng(1).normal(size=(33, 4))
            >>> nk.imitation.Skeleton.from_landmarks(landmarks, "mediapipe").points["nose"].shape
            (1, 3)
        """
        layout = LAYOUTS[choice(source, LAYOUTS, "source")]
        array = landmark_array(landmarks, layout)
        return assembled(
            frame_times(times, rate, len(array)), Points(*by_joint(array, layout), layout, units=units), up
        )


@dataclass(frozen=True)
class Points:
    """Points of a file under the names of its joints or, once their order is taken, of a layout.

    Attributes:
        joints: joint → places (n, 3), in the axes and units of the file.
        confidence: joint → (n,), up to the levels of the layout.
        layout: the names and axes.
        times: of the frames, if the file has some.
        time_unit: the unit of the times, if the file states it.
        units: the unit of the places, if it is stated.
        orientations: R_source_part, of `PARTS`.
        rest_up: the axis that points up in the rest pose of the file.
        notes: what was found out.
    """

    joints: Mapping[str, Floats]
    confidence: Mapping[str, Floats] = field(default_factory=dict)
    layout: Layout = field(default_factory=lambda: Layout("names"))
    times: Any = None
    time_unit: str | None = None
    units: str | None = None
    orientations: Mapping[str, Floats] = field(default_factory=dict)
    rest_up: str | None = None
    notes: tuple[str, ...] = ()

    def __len__(self) -> int:
        """Return the number of frames."""
        return len(next(iter(self.joints.values())))

    def named(self) -> tuple[dict[str, Floats], dict[str, Floats]]:
        """Return name of `POINTS` → places (n, 3), and → confidence in [0, 1], (n,), if it is known."""
        resolved = self.layout.resolved(self.joints)
        check_shoulders(resolved, tuple(self.joints))
        places = {name: np.mean([self.joints[part] for part in parts], axis=0) for name, parts in resolved.items()}
        sure = {}
        for name, parts in resolved.items():
            values = [self.confidence[part] for part in parts if part in self.confidence]
            if values:
                least = np.min(values, axis=0) / self.layout.levels
                sure[name] = np.where(least > 0.0, np.minimum(least, 1.0), 0.0)  # also for NaN
        return places, sure


def check_points(points: Mapping[str, Floats]) -> None:
    """Raise unless there are two shoulders and a hip, and two points differ."""
    lacking = [side + "shoulder" for side in SIDES if side + "shoulder" not in points]
    if not {"pelvis", "left_hip", "right_hip"} & points.keys():
        lacking += ["left_hip, right_hip or pelvis"]
    if lacking:
        raise BadArgument(f"no {' and no '.join(lacking)} among the points: {', '.join(points) or 'none'}")
    known = np.concatenate([*points.values()])
    known = known[np.isfinite(known).all(axis=-1)]
    if not len(known):
        raise DegeneratePoints("no point is known in any frame")
    if not np.ptp(known, axis=0).any():
        raise DegeneratePoints(f"all points are equal, at {known[0].tolist()}")


def frame_times(times: ArrayLike | None, rate: float | None, count: int) -> Floats:
    """Return the given times, or those of frames at the given rate; one frame needs neither."""
    if times is not None:
        return shaped(times, (count,), "times")
    if rate is None and count > 1:
        raise BadArgument(f"{count} frames without times; state the frames per second with rate=, or times=")
    return np.arange(count) / (1.0 if rate is None else positive(rate, "rate"))


def axis_matrix(axes: Sequence[str]) -> Floats:
    """Return the rows of a matrix that turns vectors into axes ahead, left and up, given as "x", "-y" and so on."""
    return np.array([[axis.endswith(c) * (-1.0 if axis.startswith("-") else 1.0) for c in "xyz"] for axis in axes])


# --- From the points of a source to a skeleton: names, axes, units, handedness.


def assembled(times: Floats, source: Points, up: str | None = None) -> Skeleton:
    """Return the skeleton of points whose layout is known; `up` states the axis that points up."""
    layout, units = source.layout, source.units
    if units is not None:
        choice(units, UNITS, "unit")
    if up is not None:
        choice(up, UP_AXES, "axis")
    refuse_plane(source.joints)
    mean, sure = source.named()
    check_points(mean)
    doubt = misfit(mean, sure)[1]
    found = list(source.notes)
    left, trunk = left_and_trunk(mean)
    axes, note = _axes(mean, left, trunk, layout.axes, up, source.rest_up)
    found += note
    A = axis_matrix(axes)
    size = np.nanmedian(norm(trunk)) if np.isfinite(trunk).any() else np.nan
    if units is None:
        units = _unit(size, layout.unit)
        how = f"by the size of the trunk: {size * UNITS[units]:.2g} m" if size > 0.0 else "as usual"
        found.append(f"unit {units}, {how}")
    if size * UNITS[units] < _SMALLEST:
        raise DegeneratePoints("shoulders and hips coincide in most frames, which show no trunk")
    if layout.name == "mediapipe":
        found += _image_landmarks(mean)
    if layout.axes is not None and up is None and size > 0.0 and np.nanmedian(trunk @ A[2]) < 0.0:
        found.append(f"upside down in the axes of {layout.name}: are these places in an image? up= (--up) states them")
    if doubt:
        found.append(f"{doubt}: are these the points of {layout.name}?")
    points = {name: values @ A.T * UNITS[units] for name, values in mean.items()}
    turned = {name: A @ R for name, R in source.orientations.items()}
    # Points that are not those of a person show no handedness.
    if not doubt and _backwards(points):
        points = {name: values * (1.0, -1.0, 1.0) for name, values in points.items()}
        turned = {}
        reversed_axis = "a horizontal axis is reversed, and orientations are left out"
        found.append(f"mirrored: face, toes and knees point backwards, as in left-handed axes; {reversed_axis}")
    found += lacking_notes(points, turned)
    return Skeleton(times, points, turned, sure, layout.name, tuple(found))


def lacking_notes(points: Iterable[str], orientations: Iterable[str]) -> list[str]:
    """Return notes on points that the robot's arms and head need, and that are missing."""
    have, notes = {*points}, []
    for part, limbs in (("elbow", "upper arms"), ("wrist", "forearms")):
        lacking = [side + part for side in SIDES if side + part not in have]
        if lacking:
            limb = limbs if len(lacking) == len(SIDES) else f"the {lacking[0].split('_')[0]} {limbs.removesuffix('s')}"
            notes.append(f"no {', '.join(lacking)}: {limb} keep{'s' * (len(lacking) == 1)} StandInit")
    face = ({"neck", "nose", "head"}, *({"left_ear", "right_ear", *other} for other in _FACES))
    if "head" not in orientations and not any(needed <= have for needed in face):
        notes.append("no orientation of the head, no nose and ears: the head keeps StandInit")
    return notes


def left_and_trunk(points: Mapping[str, Floats]) -> tuple[Floats, Floats]:
    """Return the vectors (n, 3) from the right to the left shoulder, and from the hips to the shoulders.

    Where the middle of the hips is unknown, the pelvis or one hip stands for it.
    """
    own = [points[name] for name in ("pelvis", "left_hip", "right_hip") if name in points]
    hips = (points["left_hip"] + points["right_hip"]) / 2.0 if {"left_hip", "right_hip"} <= points.keys() else own[0]
    for other in own:
        hips = np.where(np.isnan(hips), other, hips)
    left, right = points["left_shoulder"], points["right_shoulder"]
    return left - right, (left + right) / 2.0 - hips


def _axes(
    points: Mapping[str, Floats],
    left: Floats,
    trunk: Floats,
    known: Sequence[str] | None,
    up: str | None,
    rest_up: str | None,
) -> tuple[Sequence[str], list[str]]:
    """Return the axes that point ahead, left and up, and a note if they are found: by the trunk, or by the rest pose.

    Where the trunk is along another axis than in the rest pose, either the person lies, or the root turns the axes in
    every frame, as of files with z up. In the second case the feet are at zero along the trunk, or the root stays.
    """
    if up is not None:
        return UP_AXES[up], []
    if known is not None:
        if known[1].startswith("±"):
            along = left[np.isfinite(left).all(axis=1), "xyz".index(known[1][-1])]
            towards = "-" if len(along) and np.median(along) < 0.0 else ""
            return (known[0], towards + known[1][1:], known[2]), ["the person is taken to face the sensor"]
        return known, []
    along = trunk[np.isfinite(trunk).all(axis=-1)]
    along = along[norm(along) > 0.0]
    if not len(along):
        raise DegeneratePoints("no frame has shoulders and hips, which show the axis that points up; state it with up=")
    direction = np.median(along / norm(along)[:, None], axis=0)
    k = int(np.abs(direction).argmax())
    sign = -1.0 if direction[k] < 0.0 else 1.0
    up = ("-" if sign < 0.0 else "") + "xyz"[k]
    if rest_up in (None, up):
        return UP_AXES[up], [f"{up} points up, by the direction of the trunk"]
    all_points, size = np.stack([*points.values()]), float(np.median(norm(along)))
    lowest = float(np.nanmin(all_points[..., k] * sign))
    stays = np.nanmax(np.ptp(points["pelvis"], axis=0)) < _STAYS * size if "pelvis" in points else True
    if abs(lowest) < _FLOOR * size or stays:
        why = "the root stays where it is" if abs(lowest) >= _FLOOR * size else "the feet are at 0 along it"
        return UP_AXES[up], [f"{up} points up, by the direction of the trunk, not {rest_up} of the rest pose: {why}"]
    return UP_AXES[rest_up], [
        f"{rest_up} points up, by the rest pose: the person lies along {up}; up= (--up) says otherwise"
    ]


def _unit(size: float, usual: str | None) -> str:
    """Return the unit in which a length of the trunk is nearest to that of an adult, or the usual unit."""
    if not size > 0.0:
        if usual is not None:
            return usual
        raise DegeneratePoints("no frame has shoulders and hips that differ, whose distance shows the unit")
    return min(UNITS, key=lambda unit: abs(np.log(size * UNITS[unit] / _TRUNK_LENGTH)))


def refuse_plane(joints: Mapping[str, Floats]) -> None:
    """Raise if one coordinate of all points is the same in all frames."""
    known = np.concatenate([*joints.values()])
    known = known[np.isfinite(known).all(axis=-1)]
    ranges = np.ptp(known, axis=0) if len(known) else np.ones(3)
    if ranges.any() and not ranges.all():
        flat = "xyz"[int(np.argmin(ranges))]
        raise DegeneratePoints(f"{flat} is the same for all points: two-dimensional points give no directions")


def _image_landmarks(points: Mapping[str, Floats]) -> list[str]:
    """Return a note if points seem to be landmarks in an image, not those in metres."""
    seen = np.concatenate([*points.values()])[:, :2]
    inside = np.nanmin(seen) >= 0.0 and np.nanmax(seen) <= 1.0
    if inside and "pelvis" in points and np.nanmedian(norm(points["pelvis"][:, :2])) > _IMAGE_HIPS:
        return ["these seem to be pose_landmarks, in parts of the image; only pose_world_landmarks show directions"]
    return []


def _backwards(points: Mapping[str, Floats]) -> bool:
    """Return whether face, toes and knees point away from where left and up say that ahead is, as in a mirror.

    The median of the sum of their cosines decides, over the frames in which such points are known. Up is along the
    trunk for the face, along the shank for its toes, and along the leg for its knee: someone who kneels has toes that
    point back.
    """
    left, trunk = left_and_trunk(points)
    hips = points["left_hip"] - points["right_hip"] if {"left_hip", "right_hip"} <= points.keys() else left

    def bend(first: Floats, middle: Floats, last: Floats) -> tuple[Floats, Floats]:
        """Return how far the middle of a limb is from the middle of its ends, and half the length of the limb."""
        return middle - (first + last) / 2.0, (norm(middle - first) + norm(last - middle)) / 2.0

    gaps = np.full_like(trunk, np.nan)
    neck, head, nose, left_ear, right_ear = (points.get(name, gaps) for name in _FACE)
    face = nose - (left_ear + right_ear) / 2.0
    # Vectors that point ahead, lengths to divide them by, and what points to the left and up.
    shown = [(face, norm(face), left, trunk) if "left_ear" in points else (*bend(neck, nose, head), left, trunk)]
    for side in SIDES:
        hip, knee, ankle, toe = (points.get(side + part, gaps) for part in _ENDS[1])
        shown.append((toe - ankle, norm(toe - ankle), hips, knee - ankle))
        shown.append((*bend(hip, knee, ankle), hips, hip - ankle))
    total = np.zeros(len(trunk))
    for vector, length, leftwards, up in shown:
        ahead = cross(leftwards, up)
        with np.errstate(invalid="ignore", divide="ignore"):
            total += np.nan_to_num(dot(vector, ahead) / (norm(ahead) * length), posinf=0.0, neginf=0.0)
    known = total[total != 0.0]
    return bool(len(known) and np.median(known) < _BACKWARDS + _BACKWARDS_OF_A_FRAME / len(known))
