"""From joints that turn relative to their parents to points and orientations: BVH, and SMPL in AMASS.

A BVH file has a hierarchy of joints, each with an OFFSET from its parent and CHANNELS, and a row of channel values for
each frame:

    R_parent_joint = R_a(α) R_b(β) R_c(γ), about moving axes, in the order in which the rotation channels are listed
    p_parent_joint = OFFSET, or its position channels where it has some

Source: Meredith and Maddock, Motion Capture File Formats Explained, University of Sheffield, CS-01-11.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats, cross, finite_decimal, norm
from nao_kin._core.csv_numbers import plain_floats
from nao_kin._core.text import MAX_SHOWN, nearest_names, quoted
from nao_kin.errors import BadArgument, BadInputFile
from nao_kin.imitation.layouts import LAYOUTS, LIMBS, SIDES, TABLES
from nao_kin.imitation.reading import Options, skeleton_of
from nao_kin.imitation.skeleton import Points, Skeleton
from nao_kin.rotations import exp, matrix_from_euler

# Joints between the two ends of a bone are this far from it at most, as part of its length: they twist it.
_BESIDE = 0.15
# The square of a length that is none.
_LEAST = 1e-12


def of_tree(
    name: str,
    stated: Points,
    names: Sequence[str],
    parents: Sequence[int],
    local: Sequence[tuple[Floats, Floats]],
    rest: Sequence[tuple[Floats, Floats]],
    options: Options,
    *,
    rest_is_upright: bool = True,
) -> Skeleton:
    """Return the skeleton of joints with positions and rotations relative to their parents, and with a rest pose.

    `stated` has the times of the file. `rest_is_upright`: the axis that points up in the rest pose also does so in
    the frames.
    """
    points, rotations = _forward(parents, local)
    # Axes of points in an order are those of cameras.
    named = options.named(replace(stated, joints=dict(zip(names, points, strict=True))), ordered=False)
    resolved, at = named.layout.resolved(names), {name: i for i, name in enumerate(names)}
    by_rule = {point: joints for point, joints in resolved.items() if point not in (named.layout.stated or ())}
    _refuse_bent_bones(by_rule, names, parents, points)
    standing, _ = _forward(parents, rest)
    frames = _part_frames({name: np.mean([standing[at[p]][0] for p in parts], 0) for name, parts in resolved.items()})
    joints = {part: resolved.get(part.replace("hand", "wrist"), ()) for part in frames}
    turned = {part: rotations[at[joint[0]]] @ frames[part] for part, joint in joints.items() if len(joint) == 1}
    up = frames["chest"][:, 2] if frames and rest_is_upright else None
    rest_up = None if up is None else ("-" if up.sum() < 0.0 else "") + "xyz"[int(np.abs(up).argmax())]
    return skeleton_of(name, replace(named, orientations=turned, rest_up=rest_up), options)


def _refuse_bent_bones(
    resolved: Mapping[str, tuple[str, ...]], names: Sequence[str], parents: Sequence[int], points: Sequence[Floats]
) -> None:
    """Raise if a limb bends between the joints found for its ends, which then are others, such as a clavicle."""
    for side, one, two in ((side, *bone) for side in SIDES for limb in LIMBS for bone in pairwise(limb)):
        ends = [resolved.get(side + part, ()) for part in (one, two)]
        if any(len(end) != 1 for end in ends):
            continue
        start, k = (names.index(end[0]) for end in ends)
        bone, bent = points[k] - points[start], -1
        while (k := parents[k]) not in (start, -1):
            away = norm(cross(points[k] - points[start], bone))
            if (away > _BESIDE * np.maximum(norm(bone) ** 2, _LEAST)).any():
                bent = k
        if k == start and bent >= 0:
            raise BadArgument(
                f"{names[start]}, found for {side}{one}, bends at {names[bent]} before the {two}; "
                f"names= (--names) states the joint, such as {side}{one}={names[bent]}"
            )


def _forward(parents: Sequence[int], local: Sequence[tuple[Floats, Floats]]) -> tuple[list[Floats], list[Floats]]:
    """Return positions (n, 3) and rotations (n, 3, 3) of joints in the axes of the root's parent."""
    points: list[Floats] = []
    rotations: list[Floats] = []
    for parent, (p, R) in zip(parents, local, strict=True):
        root = parent < 0
        points.append(p if root else points[parent] + np.einsum("nij,nj->ni", rotations[parent], p))
        rotations.append(R if root else rotations[parent] @ R)
    return points, rotations


def _part_frames(rest: Mapping[str, Floats]) -> dict[str, Floats]:
    """Return R_rest_part, of the axes that `Skeleton` states, in a rest pose; nothing unless it stands along the axes.

    The person is taken to look ahead in it, and the palms to be turned to the body or, with arms stretched out, down.
    """
    needed = ("pelvis", "neck", "left_shoulder", "right_shoulder", "left_knee", "right_knee")
    if not all(name in rest for name in needed):
        return {}
    left = _nearest_axis(rest["left_shoulder"] - rest["right_shoulder"])
    up = _nearest_axis(rest["neck"] - rest["pelvis"])
    legs = _nearest_axis(rest["left_knee"] + rest["right_knee"] - 2.0 * rest["pelvis"])
    if left is None or up is None or legs is None or left @ up or (legs != -up).any():
        return {}
    ahead = cross(left, up)
    trunk = np.stack([ahead, left, up], axis=1)
    frames = dict.fromkeys(("pelvis", "chest", "head"), trunk)
    for side, y in zip(SIDES, (-ahead, ahead), strict=True):
        ends = [rest[side + part] for part in ("elbow", "wrist", "hand") if side + part in rest][-2:]
        x = ends[-1] - ends[0] if ends else ahead
        z = cross(x, y)
        if norm(z) > 0.5 * norm(x):
            x, z = x / norm(x), z / norm(z)
            frames[side + "hand"] = np.stack([x, cross(z, x), z], axis=1)
    return frames


def _nearest_axis(vector: Floats) -> Floats | None:
    """Return the signed coordinate axis within 30° of a vector."""
    k = int(np.abs(vector).argmax())
    return np.sign(vector[k]) * np.eye(3)[k] if abs(vector[k]) > np.cos(np.pi / 6.0) * norm(vector) else None


def of_amass(name: str, arrays: Mapping[str, NDArray[Any]], options: Options) -> Skeleton:
    """Return the skeleton of the rotations of the joints of SMPL, SMPL-H or SMPL-X; those of fingers are left out."""
    table = TABLES["smpl"]
    joints, parents = LAYOUTS["smpl"].orders[0], table["parents"]
    turning = len(joints) - 2  # the hands of SMPL turn with the wrists in SMPL-H
    poses = arrays["poses"]
    if poses.ndim != 2 or poses.shape[1] < 3 * turning or poses.dtype.kind != "f" or not np.isfinite(poses).all():
        raise BadInputFile(name, f"poses must be finite numbers (n, {3 * turning} or more), got {poses.shape}")
    n = len(poses)
    if not n:
        raise BadInputFile(name, "poses has no frames")
    trans = arrays.get("trans", np.zeros((n, 3)))
    if trans.shape != (n, 3) or trans.dtype.kind != "f" or not np.isfinite(trans).all():
        raise BadInputFile(name, f"trans must be finite numbers ({n}, 3), got {trans.shape}")
    rates = [arrays[key] for key in ("mocap_framerate", "mocap_frame_rate") if key in arrays]
    if rates and (rates[0].size != 1 or rates[0].dtype.kind not in "fiu"):
        raise BadInputFile(name, f"mocap_framerate must be one number, got {rates[0].dtype} of shape {rates[0].shape}")
    if rates and options.rate is None:
        options = replace(options, rate=float(rates[0].item()))
    rotations = exp(poses[:, : 3 * turning].astype(np.float64).reshape(n, turning, 3))
    still = np.tile(np.eye(3), (n, 1, 1))
    local, rest = [], []
    for k, joint in enumerate(joints):
        side = next((side for side in SIDES if joint.startswith(side)), "")
        offset = _rest_offset(table["rest"][joint.removeprefix(side)], side)
        local.append((np.tile(offset, (n, 1)) if k else trans, rotations[:, k] if k < turning else still))
        rest.append((offset[None], still[:1]))
    return of_tree(name, Points({}), joints, parents, local, rest, options, rest_is_upright=False)


def _rest_offset(row: Sequence[float], side: str) -> Floats:
    """Return the place of a joint from its parent for a row of [smpl.rest]: direction on the left side, and length."""
    direction = np.array(row[:3])
    return direction * ((-1.0 if side == "right_" else 1.0), 1.0, 1.0) * row[3] / (norm(direction) or 1.0)


# --- BVH.

_CHANNELS = tuple(axis + kind for kind in ("position", "rotation") for axis in "XYZ")
_INSIDE = ("OFFSET", "CHANNELS", "JOINT", "End Site", "}")


@dataclass
class Joint:
    """A joint or an End Site of a BVH file."""

    name: str
    parent: int
    offset: Floats = field(default_factory=lambda: np.full(3, np.nan))  # NaN until it is read
    channels: tuple[str, ...] | None = None
    column: int = 0  # of its first channel


class Bvh:
    """The joints and channel values of a BVH file."""

    def __init__(self, name: str, text: str) -> None:
        self.name = name
        self._lines = text.split("\n")
        self._words = (
            (word.group(), number, word.start() + 1)
            for number, line in enumerate(self._lines, start=1)
            for word in re.finditer(r"[{}]|[^\s{}]+", line)
        )
        self._line = self._column = 1
        self.joints: list[Joint] = []
        self._names: set[str] = set()
        self._hierarchy()
        self.frame_time, self.values = self._motion()

    def _error(self, reason: str) -> BadInputFile:
        return BadInputFile(self.name, reason, self._line, self._column)

    def _take(self, *expected: str) -> str:
        """Return the next word, which must be one of those expected, in any letter case, if there are any."""
        try:
            word, self._line, self._column = next(self._words)
        except StopIteration:
            reason = f"ends where {expected[0] if expected else 'a value'} is expected; it is incomplete"
            raise BadInputFile(self.name, reason, len(self._lines)) from None
        if not expected:
            return word
        for one in expected:
            if word.lower() == one.split()[0].lower():
                return one
        near, wanted = nearest_names(word, expected, 1), ", ".join(expected)
        wanted = f"{near[0]}, or another of {wanted}" if near and len(expected) > 1 else wanted
        raise self._error(f"{quoted(word, MAX_SHOWN)}, expected {wanted}")

    def _number(self, what: str) -> float:
        word = self._take()
        value = finite_decimal(word)
        if value is None:
            raise self._error(f"{what} is {quoted(word, MAX_SHOWN)}, expected a finite number")
        return value

    def _count(self, what: str, least: int) -> int:
        value = self._number(what)
        if value != int(value) or value < least:
            raise self._error(f"{what} is {value:g}, expected a whole number of at least {least}")
        return int(value)

    def _open(self, parent: int, end: bool = False) -> int:
        """Begin a joint, whose name lasts until the brace; return its index."""
        words: list[str] = []
        while (word := self._take()) != "{":
            if word in _INSIDE:
                raise self._error(f"{word}, expected {{ after the name of a joint")
            words.append(word)
        name = f"{self.joints[parent].name}_end" if end else " ".join(words)
        if not name:
            raise self._error("a joint without a name")
        if not end and name in self._names:
            raise self._error(f"a second joint {quoted(name)}")
        self._names.add(name)
        self.joints.append(Joint(name, parent, channels=() if end else None))
        return len(self.joints) - 1

    def _hierarchy(self) -> None:
        """Read the joints, each after its parent."""
        self._take("HIERARCHY")
        self._take("ROOT")
        at, column = self._open(-1), 0
        while at >= 0:
            joint = self.joints[at]
            word = self._take(*_INSIDE)
            if word == "OFFSET":
                joint.offset = np.array([self._number(f"OFFSET of {joint.name}") for _ in range(3)])
            elif word == "CHANNELS":
                if joint.channels is not None:
                    raise self._error(f"CHANNELS of {joint.name}, which has them already or is an End Site")
                count = self._count("the number of channels", 0)
                joint.channels = tuple(self._take(*_CHANNELS) for _ in range(count))
                joint.column, column = column, column + count
                if len(set(joint.channels)) < count:
                    raise self._error(f"a channel twice in {joint.name}")
            elif word == "JOINT":
                at = self._open(at)
            elif word == "End Site":
                if not (site := self._take()).lower().startswith("site"):  # some number them: End Site-7
                    raise self._error(f"{quoted(site, MAX_SHOWN)}, expected Site")
                at = self._open(at, end=True)
            else:
                if joint.channels is None or np.isnan(joint.offset).any():
                    lacking = "CHANNELS" if joint.channels is None else "OFFSET"
                    raise self._error(f"{joint.name} ends without {lacking}")
                at = joint.parent
        self._width = column

    def _motion(self) -> tuple[float, Floats]:
        """Return the time from frame to frame [s], and the channel values, shape (frames, channels)."""
        self._take("MOTION")
        self._take("Frames:")
        count = self._count("the number of frames", 1)
        self._take("Frame")
        self._take("Time:")
        step = self._number("the frame time")
        if step <= 0.0:
            raise self._error(f"the frame time is {step:g}, expected more than 0")
        rows = []
        for number, line in enumerate(self._lines[self._line :], start=self._line + 1):
            fields = line.split()
            if not fields:
                continue
            self._line, self._column = number, 0
            row = plain_floats(fields) if line.isascii() and "_" not in line else None
            if row is None:
                for word in re.finditer(r"\S+", line):
                    if finite_decimal(word.group()) is None:
                        self._column = word.start() + 1
                        raise self._error(f"{quoted(word.group(), MAX_SHOWN)}, expected a finite number")
            if len(fields) != self._width:
                raise self._error(f"{len(fields)} values, expected one for each of {self._width} channels")
            rows.append(row)
        if len(rows) != count:
            ends = "; the file is incomplete" if len(rows) < count else ""
            raise self._error(f"frame {len(rows)} is the last one, but {count} frames are stated{ends}")
        return step, np.array(rows, dtype=np.float64).reshape(count, self._width)

    def local(self, joint: Joint) -> tuple[Floats, Floats]:
        """Return p_parent_joint and R_parent_joint in all frames, shapes (n, 3) and (n, 3, 3)."""
        position = np.tile(joint.offset, (len(self.values), 1))
        sequence, columns = "", []
        for column, channel in enumerate(joint.channels or (), start=joint.column):
            if channel.endswith("position"):
                position[:, "XYZ".index(channel[0])] = self.values[:, column]
            else:
                sequence += channel[0].lower()
                columns.append(column)
        if not sequence:
            return position, np.tile(np.eye(3), (len(position), 1, 1))
        return position, matrix_from_euler(np.radians(self.values[:, columns]), sequence, axes="moving")


def of_bvh(name: str, text: str, options: Options) -> Skeleton:
    """Return the skeleton of the text of a BVH file."""
    file = Bvh(name, text)
    local = [file.local(joint) for joint in file.joints]
    rest = [(joint.offset[None], np.eye(3)[None]) for joint in file.joints]
    count = len(file.values)
    stated = Points({}, times=np.linspace(0.0, (count - 1) * file.frame_time, count), time_unit="s")
    names, parents = [joint.name for joint in file.joints], [joint.parent for joint in file.joints]
    return of_tree(name, stated, names, parents, local, rest, options)
