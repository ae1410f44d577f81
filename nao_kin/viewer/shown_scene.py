"""What a user moves in the page, the robot and targets: which page reports it, the callbacks, and the warnings."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Mapping
from functools import partial
from types import MappingProxyType
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import Floats, as_floats, join_poses, shaped
from nao_kin._core.text import abbreviated
from nao_kin._core.warn import warn_caller
from nao_kin.errors import BadArgument, NaoKinError, NaoKinWarning, WrongShape
from nao_kin.robot import RobotModel
from nao_kin.rotations import check_rotation
from nao_kin.viewer.messages import RetainedMessages, packed, panel_message
from nao_kin.viewer.overlays import checked_name

# --- The page whose playback is followed.

# A playing page reports up to thirty times a second. After this time without a report [s] it loses the lead; even a
# busy browser reports sooner.
_SILENCE = 3.0


class Lead:
    """The page whose playback is followed if several play at once; callers hold the viewer's lock.

    It is the page in which a user last began to play or moved the time, or else the first page that reported. A change
    of the robot by other means also takes the lead, so that outdated reports of a page are ignored.
    """

    def __init__(self) -> None:
        self._source = ""
        self._heard = -_SILENCE

    def take(self, source: str) -> None:
        """Give the lead to this page, or to the program, ""."""
        self._source, self._heard = source, time.monotonic()

    def release(self) -> None:
        """Give the lead to no page."""
        self._heard = -_SILENCE

    def admits(self, source: str, *, begins: bool) -> bool:
        """Return whether to follow a playing page; `begins`: whether its user just began to play or moved the time."""
        if not begins and source != self._source and time.monotonic() - self._heard < _SILENCE:
            return False
        self.take(source)
        return True


# --- The places of added robots.

# Distance between neighbouring robots [m].
_GAP = 0.1


class Row:
    """The places of robots that are added without one: each to the right of the one before, the first at the origin.

    Args:
        aside: the largest distance of the own robot's shapes from its root's frame along y [m].
    """

    def __init__(self, aside: float) -> None:
        self._aside = aside

    def place(self, aside: float) -> Floats:
        """Return the pose in the world of the ground of the next robot, shape (4, 4)."""
        T = np.eye(4)
        T[1, 3] = -(self._aside + _GAP + aside)
        self._aside += _GAP + 2.0 * aside
        return T


# --- Callbacks on changes by a page.

# Called with the configuration and the names of the joints that changed.
ChangeCallback = Callable[[Floats, tuple[str, ...]], object]

_LOG = logging.getLogger(__name__)


class Subscription:
    """A callback that is called until `remove`."""

    def __init__(self, callback: ChangeCallback, changes: Changes) -> None:
        self.callback = callback
        self._changes = changes

    def remove(self) -> None:
        """End the calls; a running call completes. Does nothing the second time."""
        self._changes.remove(self)


class Changes:
    """Calls callbacks on changes, one at a time and in order, in a separate thread.

    Changes during a call are combined into one: the newest configuration, and every joint that changed; the newest
    place of each target. A slow callback therefore delays neither the server nor the page, and no queue grows.
    """

    def __init__(self) -> None:
        self._subscriptions: list[Subscription] = []
        self._pending: tuple[Floats, dict[str, None]] | None = None
        self._calls: dict[object, tuple[Callable[[], object], str]] = {}
        self._running = False
        self._lock = threading.Lock()

    def add(self, callback: ChangeCallback) -> Subscription:
        """Call `callback` from now on."""
        subscription = Subscription(callback, self)
        with self._lock:
            self._subscriptions.append(subscription)
        return subscription

    def remove(self, subscription: Subscription) -> None:
        """End the calls of a subscription."""
        with self._lock:
            if subscription in self._subscriptions:
                self._subscriptions.remove(subscription)

    def tell(self, q: Floats, joints: tuple[str, ...]) -> None:
        """Report that the configuration is q now, after these joints changed."""
        with self._lock:
            if not self._subscriptions:
                return
            before = self._pending[1] if self._pending is not None else {}
            self._pending = np.array(q), before | dict.fromkeys(joints)
            self._start()

    def call(self, key: object, function: Callable[[], object], what: str) -> None:
        """Schedule one call of a function, after those that wait, and instead of one that waits under the same key.

        `what` names the function in the log if it fails.
        """
        with self._lock:
            self._calls.pop(key, None)
            self._calls[key] = function, what
            self._start()

    def _start(self) -> None:
        if not self._running:
            self._running = True
            threading.Thread(target=self._run, name="nao_kin viewer changes", daemon=True).start()

    def _run(self) -> None:
        while True:
            with self._lock:
                pending, self._pending = self._pending, None
                calls, self._calls = self._calls, {}
                subscriptions = tuple(self._subscriptions)
                if pending is None and not calls:
                    self._running = False
                    return
            for function, what in calls.values():
                _guarded(function, what)
            if pending is None:
                continue
            q, joints = pending
            for subscription in subscriptions:
                if subscription in self._subscriptions:  # unless it was removed meanwhile
                    _guarded(subscription.callback, "viewer.on_change", q.copy(), tuple(joints))


def _guarded(function: Callable[..., object], what: str, *arguments: object) -> None:
    try:
        function(*arguments)
    except BaseException:  # a failing function, even with sys.exit(), must not end the calls
        _LOG.exception("a callback of %s failed", what)


# --- Warnings of joints that are shown outside their limits.


class OutsideLimitsWarning(NaoKinWarning):
    """A displayed configuration has joints outside their limits, other than joints at zero.

    Examples:
        >>> issubclass(nk.viewer.OutsideLimitsWarning, nk.errors.NaoKinWarning)
        True
    """


def warn_outside(robot: RobotModel, qs: Floats, warned: set[str]) -> None:
    """Warn of joints outside their limits in (nq,) or (n, nq), unless they are in `warned`, and add them to it."""
    if qs.ndim > 1:
        qs = qs[_first_outside(robot, qs)]
    violations = robot.limit_violations(qs)
    found = dict.fromkeys(row.joint for row in violations if row.value != 0.0 or row.of_value != 0.0)
    new = [joint for joint in found if joint not in warned]
    warned.update(new)
    if new:
        warn_caller(f"outside the joint limits, shown in red: {', '.join(new)}", OutsideLimitsWarning)


def _first_outside(robot: RobotModel, qs: Floats) -> list[int]:
    """Return, for each joint, the first configuration of a clip in which it is outside its limits, except at zero."""
    outside = ~robot.within_limits(qs, per_joint=True)
    values = qs[:, robot.nq_base :]
    moved = outside & (values != 0.0)
    for table in robot.coupled_limits:
        joint, of = robot.joint_names.index(table.joint), robot.joint_names.index(table.of)
        if robot.lower[joint] <= 0.0 <= robot.upper[joint]:  # otherwise its own range excludes zero
            moved[:, joint] |= outside[:, joint] & (values[:, of] != 0.0)
    return sorted({int(column.argmax()) for column in moved.T if column.any()})


# --- Targets in the robot's root frame: marks, and targets that a user drags in the page.

# Called with the target's new position or pose.
MoveCallback = Callable[[Floats], object]


class Listed:
    """An item of a `Listing`: its name, its value, and the source of the value's last change."""

    def __init__(self, name: str, value: Any, listing: Listing[Any]) -> None:
        self.name = checked_name(name)
        self._value, self._listing, self._source = value, listing, listing.source()


Item = TypeVar("Item", bound=Listed)


class Listing(Generic[Item]):
    """Items of a program by name, in the order in which they were added; pages get the list whole."""

    def __init__(self, kind: str, messages: RetainedMessages, lock: threading.RLock, changes: Changes) -> None:
        self._kind, self._messages, self._lock, self._changes = kind, messages, lock, changes
        self._items: dict[str, Item] = {}
        self.source = messages.source

    def put(self, item: Item) -> Item:
        """Add an item, instead of the one of the same name."""
        with self._lock:
            self._items[item.name] = item
            self._send()
        return item

    def has(self, item: Item) -> bool:
        """Return whether an item was neither removed nor replaced."""
        return self._items.get(item.name) is item

    def named(self, name: object) -> Item | None:
        """Return the item of a name that a page sent."""
        return self._items.get(name) if isinstance(name, str) else None

    def set(self, item: Item, value: Any, source: str) -> None:
        """Set a value; `source` names the change."""
        with self._lock:
            if not self.has(item):
                raise BadArgument(f"{abbreviated(item.name)} was removed from the viewer")
            item._value, item._source = value, source
            self._send()

    def remove(self, item: Item) -> None:
        """Remove an item, if it is there."""
        with self._lock:
            if self.has(item):
                del self._items[item.name]
                self._send()

    def _rows(self) -> list[dict[str, Any]]:
        raise NotImplementedError

    def _send(self) -> None:
        self._messages.put(self._kind, panel_message(self._kind, {self._kind: self._rows()}))


class Target(Listed):
    """A position or a pose in the robot's root frame that a user can drag in the page, made by `Viewer.add_target`.

    Attributes:
        name: its name in the page.

    Examples:
        >>> viewer = nk.Viewer(nk.load_nao())
        >>> ball = viewer.add_target("ball", [0.2, 0.1, 0.1])
        >>> ball
        <Target ball>
    """

    def __init__(self, name: str, T: Floats, callbacks: Mapping[str, MoveCallback | None], targets: Targets) -> None:
        super().__init__(name, T, targets)
        self._callbacks = callbacks

    @property
    def T(self) -> Floats:
        """The current position, shape (3,) [m], or pose, shape (4, 4), in the form that `add_target` got."""
        return np.array(self._value)

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
        if array.shape != self._value.shape:
            raise WrongShape("T", str(self._value.shape), array.shape)
        self._listing.set(self, array, self._listing.source())

    def remove(self) -> None:
        """Remove the target from the scene; does nothing the second time.

        Examples:
            >>> ball = nk.Viewer(nk.load_nao()).add_target("ball", [0.2, 0.1, 0.1])
            >>> ball.remove()
        """
        self._listing.remove(self)

    def __repr__(self) -> str:
        return f"<Target {self.name}{'' if self._listing.has(self) else ', removed'}>"


class Targets(Listing[Target]):
    """The targets of a viewer: marks of `show_targets`, and those of `add_target` by name."""

    _marks: Mapping[str, Floats] = MappingProxyType({})

    def show(self, poses: Mapping[str, ArrayLike]) -> None:
        """Mark positions or poses, instead of the previous ones."""
        marks = {str(name): checked_target(T, f"target {abbreviated(name)}") for name, T in poses.items()}
        packed(" ".join(marks))  # refuses names that cannot be sent
        with self._lock:
            self._marks = marks
            self._send()

    def add(self, name: str, T: ArrayLike, **callbacks: MoveCallback | None) -> Target:
        """Add a target that can be dragged, instead of the one of the same name; on_move, on_grab and on_release."""
        return self.put(Target(name, checked_target(T, "T"), callbacks, self))

    def receive(self, name: object, matrix: object, source: str) -> None:
        """Move a target as a user did in a page, and call its `on_move`."""
        target = self.named(name)
        if target is None:
            return
        try:
            T = pose_of_page(matrix)
            self.set(target, T[:3, 3].copy() if target._value.ndim == 1 else T, source)
        except (NaoKinError, ValueError):
            return
        self._call(target, "on_move")

    def hold(self, name: object, held: object) -> None:
        """Call `on_grab` or `on_release` of a target that a user grabbed or let go in a page."""
        target = self.named(name)
        if target is not None and isinstance(held, bool):
            self._call(target, "on_grab" if held else "on_release")

    def _call(self, target: Target, event: str) -> None:
        function = target._callbacks.get(event)
        if function is not None:
            self._changes.call((target, event), partial(self._tell, target, function), f"{event} of {target.name}")

    def _tell(self, target: Target, function: MoveCallback) -> None:
        if self.has(target):
            function(target.T)

    def _rows(self) -> list[dict[str, Any]]:
        added = [{**_row(name, target._value), "source": target._source} for name, target in self._items.items()]
        return [_row(name, T) for name, T in self._marks.items()] + added


def checked_target(target: ArrayLike, what: str) -> Floats:
    """Return a position, shape (3,), or a pose, shape (4, 4), as a new array."""
    array = as_floats(target, (), what)
    if array.shape not in ((3,), (4, 4)):
        raise WrongShape(what, "(3,) or (4, 4)", array.shape)
    return np.array(array) if array.ndim == 1 else checked_pose(array)


def checked_pose(T: ArrayLike) -> Floats:
    """Return `T` as a new pose, shape (4, 4)."""
    array = shaped(T, (4, 4), "T")
    check_rotation(array[:3, :3])
    return join_poses(array[:3, :3], array[:3, 3])


def pose_of_page(matrix: object) -> Floats:
    """Return a pose that a page sent column by column; raise NaoKinError or ValueError for anything else."""
    return checked_pose(np.reshape(as_floats(matrix, (16,), "matrix"), (4, 4)).T)  # type: ignore[arg-type]


def _row(name: str, T: Floats) -> dict[str, Any]:
    """Return a target for the page; those that can be dragged also get a `source`, which names their last change."""
    matrix = np.eye(4)
    matrix[:3, 3 if T.ndim == 1 else slice(None)] = T if T.ndim == 1 else T[:3]
    return {"name": name, "matrix": matrix.T.reshape(-1).tolist(), "point": T.ndim == 1}
