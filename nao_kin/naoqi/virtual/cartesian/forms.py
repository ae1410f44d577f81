"""What Cartesian calls take: effectors, spaces, masks, poses and times, in the forms that NAOqi takes them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin._text import quoted
from nao_kin.errors import BadArgument, UnknownName
from nao_kin.naoqi.axis_mask import axis_mask
from nao_kin.naoqi.names import as_names
from nao_kin.naoqi.poses import pose, pose_from_list
from nao_kin.naoqi.spaces import EFFECTORS, FRAME_TORSO, space_number
from nao_kin.naoqi.virtual import arguments

ToPoses = Callable[[Any], Floats]


@dataclass(frozen=True, eq=False)
class Wish:
    """What is asked of one effector.

    Attributes:
        effector: one of the six.
        space: the space of its poses.
        mask: the axes that count, along those of the space.
        poses: of its path, shape (k, 4, 4), in the space; or changes.
        times: of these, shape (k,) [s]; empty where there is no time.
        relative: the poses are changes of where the effector is at the beginning.
    """

    effector: str
    space: int
    mask: int
    poses: Floats
    times: Floats
    relative: bool


def positions(value: Any) -> Floats:
    """Poses of Position6D, shape (..., 6)."""
    return pose(value)


def transforms(value: Any) -> Floats:
    """Poses of transforms, shape (..., 16) or (..., 12)."""
    return pose_from_list(value)


def wishes(
    names: Any, spaces: Any, paths: Any, masks: Any, times: Any, read: ToPoses, *, relative: bool = False
) -> tuple[Wish, ...]:
    """Every effector's path.

    Args:
        names: an effector, or a list of them.
        spaces: a space for all, or a list of one for each.
        paths: a list of one path for each effector, a path being a list of poses or one pose; of a single effector also
            its path alone.
        masks: a mask for all, or a list of one for each.
        times: of one effector a time or a list of times; of several a list of times for each, or one list for all; one
            time for each pose. None where there are none.
        read: `positions` or `transforms`.
        relative: the poses are changes.

    Raises:
        UnknownName: no effector or space of this name.
        BadArgument: lengths that do not fit, or what is no number, mask or space.
        WrongShape, NotFinite, NotARotation: what is no pose.
    """
    effectors = _effectors(names)
    count = len(effectors)
    numbers = _each(spaces, count, "spaces", space_number)
    chosen = _each(masks, count, "axis masks", axis_mask)
    rows = [_path(path, read, effector) for path, effector in zip(_split(paths, count), effectors, strict=True)]
    when = [np.empty(0)] * count if times is None else _times(times, effectors, rows)
    for effector, space in zip(effectors, numbers, strict=True):
        if effector == "Torso" and space == FRAME_TORSO:
            raise BadArgument("Torso does not move in FRAME_TORSO, which is the torso: FRAME_WORLD or FRAME_ROBOT")
    fields = zip(effectors, numbers, chosen, rows, when, strict=True)
    return tuple(Wish(*entry, relative) for entry in fields)


def single(
    names: Any, spaces: Any, poses: Any, masks: Any, read: ToPoses, *, relative: bool = False
) -> tuple[Wish, ...]:
    """Every effector's one pose, without a time; arguments and errors as in `wishes`."""
    found = wishes(names, spaces, poses, masks, None, read, relative=relative)
    for wish in found:
        if len(wish.poses) != 1:
            raise BadArgument(f"{wish.effector} must have one pose, got {len(wish.poses)}")
    return found


def _effectors(names: Any) -> tuple[str, ...]:
    effectors = as_names(names)
    for name in effectors:
        if name not in EFFECTORS:
            raise UnknownName("effector", name, EFFECTORS)
    if len(set(effectors)) < len(effectors):
        raise BadArgument(f"an effector is named twice: {', '.join(effectors)}")
    if not effectors:
        raise BadArgument("effectorNames must name an effector at least")
    return effectors


def _each(value: Any, count: int, what: str, read: Callable[[Any], int]) -> list[int]:
    """One number for all, or one for each."""
    if not isinstance(value, (list, tuple, np.ndarray)):
        return [read(value)] * count
    if len(value) != count:
        raise BadArgument(f"{what} must be one for all effectors or {count}, got {len(value)}")
    return [read(entry) for entry in value]


def _depth(value: Any) -> int:
    """How many lists are inside each other, along the first entries."""
    depth = 0
    while isinstance(value, (list, tuple, np.ndarray)):
        depth += 1
        value = value[0] if len(value) else None
    return depth


def _split(paths: Any, count: int) -> Sequence[Any]:
    """The path of each effector."""
    if count == 1:
        return paths if _depth(paths) == 3 and len(paths) == 1 else [paths]
    if _depth(paths) < 2 or len(paths) != count:
        got = len(paths) if isinstance(paths, (list, tuple, np.ndarray)) else quoted(paths, 60)
        raise BadArgument(f"paths must be {count}, one for each effector, got {got}")
    return list(paths)


def _path(path: Any, read: ToPoses, effector: str) -> Floats:
    """The poses of one path, shape (k, 4, 4)."""
    depth = _depth(path)
    if depth not in (1, 2) or not len(path):
        raise BadArgument(f"the path of {effector} must be a pose or a list of poses, got {quoted(path, 60)}")
    poses = read(list(path))
    return poses[None] if poses.ndim == 2 else poses


def _times(times: Any, effectors: Sequence[str], rows: Sequence[Floats]) -> list[Floats]:
    count, lengths = len(effectors), [len(row) for row in rows]
    depth = _depth(times)
    if depth == 1 and count > 1:
        for_all = all(length == len(times) for length in lengths)
        one_each = len(times) == count and all(length == 1 for length in lengths)
        lists: list[Any] = [times] * count if for_all or not one_each else [[time] for time in times]
    elif depth == 2 and len(times) == count:
        lists = list(times)
    elif depth < 2:
        lists = [[times] if depth == 0 else times] * count
    else:
        got = len(times) if depth else quoted(times, 60)
        raise BadArgument(f"times must be a list for each of {count} effectors, got {got}")
    found = [arguments.list_each([row], [name], "times")[0] for row, name in zip(lists, effectors, strict=True)]
    arguments.check_lengths(rows, found, effectors, "poses")
    arguments.check_times(found, effectors)
    return found
