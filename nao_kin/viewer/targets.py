"""Targets in the robot's root frame: marks, and targets that a user drags in the page."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from threading import RLock
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import Floats, as_floats
from nao_kin._core.text import abbreviated, quoted
from nao_kin.errors import BadArgument, NaoKinError, WrongShape
from nao_kin.rotations import check_rotation
from nao_kin.viewer.messages import RetainedMessages, panel_message
from nao_kin.viewer.overlays import LARGEST, checked_name
from nao_kin.viewer.shown_scene import Changes

_MAX_TARGETS = 1000
# Called with the target's new position or pose.
MoveCallback = Callable[[Floats], object]


class Target:
    """A position or a pose in the robot's root frame that a user can drag in the page, made by `Viewer.add_target`.

    Attributes:
        name: its name in the page.

    Examples:
        >>> viewer = nk.Viewer(nk.load_nao())
        >>> ball = viewer.add_target("ball", [0.2, 0.1, 0.1])
        >>> ball
        <Target ball>
    """

    def __init__(self, name: str, T: Floats, on_move: MoveCallback | None, targets: Targets) -> None:
        self.name = name
        self._T, self._on_move, self._targets, self._source = T, on_move, targets, ""

    @property
    def T(self) -> Floats:
        """The current position, shape (3,) [m], or pose, shape (4, 4), in the form that `add_target` got."""
        return np.array(self._T)

    def place(self, T: ArrayLike) -> None:
        """Move the target; this does not call `on_move`.

        Args:
            T: position or pose, of the same shape as before.

        Raises:
            BadArgument: the target was removed or replaced.

        Examples:
            >>> ball = nk.Viewer(nk.load_nao()).add_target("ball", [0.2, 0.1, 0.1])
            >>> ball.place([0.2, 0.2, 0.0])
            >>> ball.T.tolist()
            [0.2, 0.2, 0.0]
        """
        array = checked_target(T, "T")
        if array.shape != self._T.shape:
            raise WrongShape("T", str(self._T.shape), array.shape)
        self._targets.place(self, array)

    def remove(self) -> None:
        """Remove the target from the scene; does nothing the second time.

        Examples:
            >>> ball = nk.Viewer(nk.load_nao()).add_target("ball", [0.2, 0.1, 0.1])
            >>> ball.remove()
        """
        self._targets.remove(self)

    def __repr__(self) -> str:
        return f"<Target {self.name}{'' if self._targets.has(self) else ', removed'}>"


class Targets:
    """The targets of a viewer: marks of `show_targets`, and those of `add_target` by name."""

    def __init__(self, messages: RetainedMessages, lock: RLock, changes: Changes) -> None:
        self._messages, self._lock, self._changes = messages, lock, changes
        self._marks: dict[str, Floats] = {}
        self._added: dict[str, Target] = {}

    def show(self, poses: Mapping[str, ArrayLike]) -> None:
        """Mark positions or poses, instead of the previous ones."""
        if not isinstance(poses, Mapping):
            raise BadArgument(f"targets are a mapping from names to positions or poses, got {type(poses).__name__}")
        self._check_count(len(poses) + len(self._added))
        marks = {str(name): checked_target(T, f"target {abbreviated(name)}") for name, T in poses.items()}
        with self._lock:
            self._send(marks, self._added)
            self._marks = marks

    def add(self, name: str, T: ArrayLike, on_move: MoveCallback | None) -> Target:
        """Add a target that can be dragged, instead of the one of the same name."""
        if not (on_move is None or callable(on_move)):
            raise BadArgument(f"on_move must be a function of T, got {quoted(on_move)}")
        target = Target(checked_name(name), checked_target(T, "T"), on_move, self)
        with self._lock:
            added = {**self._added, target.name: target}
            self._check_count(len(self._marks) + len(added))
            self._send(self._marks, added)
            self._added = added
        return target

    def has(self, target: Target) -> bool:
        """Return whether a target was neither removed nor replaced."""
        return self._added.get(target.name) is target

    def place(self, target: Target, T: Floats) -> None:
        """Move a target for the program."""
        with self._lock:
            if not self.has(target):
                raise BadArgument(f"{target.name} was removed from the viewer")
            target._T, target._source = T, ""
            self._send(self._marks, self._added)

    def remove(self, target: Target) -> None:
        """Remove a target, if it is there."""
        with self._lock:
            if self.has(target):
                del self._added[target.name]
                self._send(self._marks, self._added)

    def receive(self, name: object, matrix: object, source: str) -> None:
        """Move a target as a user did in a page, and call its `on_move`."""
        target = self._added.get(name) if isinstance(name, str) else None
        if target is None:
            return
        try:
            T = checked_target(np.reshape(as_floats(matrix, (16,), "matrix"), (4, 4)).T, "T")  # type: ignore[arg-type]
        except (NaoKinError, ValueError):
            return
        T = T[:3, 3].copy() if target._T.ndim == 1 else T
        with self._lock:
            if not self.has(target):
                return
            target._T, target._source = T, source
            self._send(self._marks, self._added)
        if target._on_move is not None:
            self._changes.call(target, lambda: self._tell(target))

    def _tell(self, target: Target) -> None:
        if self.has(target) and target._on_move is not None:
            target._on_move(target.T)

    def _send(self, marks: Mapping[str, Floats], added: Mapping[str, Target]) -> None:
        rows = [_row(name, T) for name, T in marks.items()]
        rows += [{**_row(name, target._T), "source": target._source} for name, target in added.items()]
        self._messages.put("targets", panel_message("targets", {"targets": rows}))

    def _check_count(self, count: int) -> None:
        if count > _MAX_TARGETS:
            raise BadArgument(f"at most {_MAX_TARGETS} targets are shown, got {count}; remove some first")


def checked_target(target: ArrayLike, what: str) -> Floats:
    """Return a position, shape (3,), or a pose, shape (4, 4), as a new array."""
    array = as_floats(target, (), what)
    if array.shape not in ((3,), (4, 4)):
        raise WrongShape(what, "(3,) or (4, 4)", array.shape)
    T = np.array(array)
    if T.ndim == 2:
        check_rotation(T[:3, :3])
        T[3] = 0.0, 0.0, 0.0, 1.0
    farthest = np.abs(T[..., :3, -1] if T.ndim == 2 else T).max()
    if farthest > LARGEST:
        raise BadArgument(f"{what} is {farthest:g} m away; up to {LARGEST:g} m is shown")
    return T


def _row(name: str, T: Floats) -> dict[str, Any]:
    """Return a target for the page; those that can be dragged also get a `source`: the page that moved them last."""
    matrix = np.eye(4)
    matrix[:3, 3 if T.ndim == 1 else slice(None)] = T if T.ndim == 1 else T[:3]
    return {"name": name, "matrix": matrix.T.reshape(-1).tolist(), "point": T.ndim == 1}
