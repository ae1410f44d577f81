"""A robot and all that is shown with it: what every page of it gets, live or in a file."""

from __future__ import annotations

import itertools
import logging
import math
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core import files as atomic
from nao_kin._core.arrays import Floats, choice, flag
from nao_kin._core.text import abbreviated, quoted
from nao_kin._core.warn import warn_caller
from nao_kin.errors import BadArgument, NaoKinWarning
from nao_kin.joints import MultiDofModel
from nao_kin.motion import HOLD, Hips, Motion
from nao_kin.robot import RobotModel
from nao_kin.viewer import overlays
from nao_kin.viewer.access import static_page
from nao_kin.viewer.description import SceneRobot
from nao_kin.viewer.drawings import Drawings
from nao_kin.viewer.messages import packed, panel_message, set_animation, typed_array
from nao_kin.viewer.recording import Recording
from nao_kin.viewer.scene import ROBOT
from nao_kin.viewer.shown_robot import ShownRobot, checked_pose

# --- Which page says where a motion is that is played.

# A page that plays says where it is up to thirty times a second. One that is silent for so long [s] leads no more: it
# has ended or is gone, for even a browser that is busy with another page is heard sooner.
_SILENCE = 3.0


class Lead:
    """Who leads: of several pages that play at once, each at a time of its own, only one is listened to.

    It is the page in which somebody began to play, or went to a time, last; before anybody did, the one that was heard
    first. Who moves the robot otherwise leads too, so that what a page has sent before it stopped is not taken for new.
    """

    def __init__(self) -> None:
        self._source = ""
        self._heard = -_SILENCE
        self._lock = threading.Lock()

    def take(self, source: str) -> None:
        """Let this page lead, or the program, ""."""
        with self._lock:
            self._source, self._heard = source, time.monotonic()

    def release(self) -> None:
        """Let nobody lead."""
        with self._lock:
            self._heard = -_SILENCE

    def admits(self, source: str, *, begins: bool) -> bool:
        """Whether to listen to a page that plays.

        Args:
            source: who it is.
            begins: whether somebody has just begun to play in it, or gone to a time.
        """
        with self._lock:
            now = time.monotonic()
            if not begins and source != self._source and now - self._heard < _SILENCE:
                return False
            self._source, self._heard = source, now
            return True


# --- Who wants to know what a page does to the robot, and how they hear of it.

# Called with the configuration and the names of the joints that changed.
ChangeCallback = Callable[[Floats, tuple[str, ...]], object]

_LOG = logging.getLogger(__name__)


class Subscription:
    """A callback that is called until `remove`."""

    def __init__(self, callback: ChangeCallback, changes: Changes) -> None:
        self.callback = callback
        self._changes = changes

    def remove(self) -> None:
        """Call it no more; does nothing the second time. A call under way ends by itself."""
        self._changes.remove(self)


class Changes:
    """Tells callbacks of changes, one at a time and in their order, in a thread of its own.

    The thread lives while there is something to tell. What happens while callbacks run is told in one when they have
    ended: the newest configuration, and every joint that changed. So a slow callback holds up neither the server nor
    the page, and nothing piles up.
    """

    def __init__(self) -> None:
        self._subscriptions: list[Subscription] = []
        self._pending: tuple[Floats, dict[str, None]] | None = None
        self._running = False
        self._lock = threading.Lock()

    def add(self, callback: ChangeCallback) -> Subscription:
        """Call `callback` from now on."""
        subscription = Subscription(callback, self)
        with self._lock:
            self._subscriptions.append(subscription)
        return subscription

    def remove(self, subscription: Subscription) -> None:
        """Call it no more."""
        with self._lock:
            if subscription in self._subscriptions:
                self._subscriptions.remove(subscription)

    def tell(self, q: Floats, joints: tuple[str, ...]) -> None:
        """Say that the configuration is q now, after these joints changed."""
        with self._lock:
            if not self._subscriptions:
                return
            before = self._pending[1] if self._pending is not None else {}
            self._pending = np.array(q), before | dict.fromkeys(joints)
            if self._running:
                return
            self._running = True
        threading.Thread(target=self._run, name="nao_kin viewer changes", daemon=True).start()

    def _run(self) -> None:
        while True:
            with self._lock:
                pending, self._pending = self._pending, None
                subscriptions = tuple(self._subscriptions)
                if pending is None:
                    self._running = False
                    return
            q, joints = pending
            for subscription in subscriptions:
                if subscription not in self._subscriptions:  # removed by the one before it, or meanwhile
                    continue
                try:
                    subscription.callback(q.copy(), tuple(joints))
                except BaseException:  # whatever a caller's function raises, sys.exit() too, is the caller's
                    _LOG.exception("a callback of viewer.on_change failed")


# --- Warnings of joints that are shown outside their limits.


class OutsideLimitsWarning(NaoKinWarning):
    """A configuration on show has joints outside their limits, and not because nobody moved them from zero.

    Examples:
        >>> issubclass(nk.viewer.OutsideLimitsWarning, nk.errors.NaoKinWarning)
        True
    """


class OutsideWarnings:
    """Warns of each joint of a robot once."""

    def __init__(self, robot: RobotModel) -> None:
        self._robot = robot
        self._warned: set[str] = set()

    def check(self, qs: Floats) -> None:
        """Warn of the joints that are outside in one configuration, shape (nq,), or in several, shape (n, nq)."""
        if qs.ndim > 1:
            qs = qs[_first_outside(self._robot, qs)]
        violations = self._robot.limit_violations(qs)
        found = dict.fromkeys(row.joint for row in violations if row.value != 0.0 or row.of_value != 0.0)
        new = [joint for joint in found if joint not in self._warned]
        self._warned.update(new)
        if new:
            warn_caller(f"outside the joint limits, shown in red: {', '.join(new)}", OutsideLimitsWarning)


def _first_outside(robot: RobotModel, qs: Floats) -> list[int]:
    """Of a clip, the first configuration in which each joint is outside its limits and not because all is at zero.

    A clip that runs outside of them for minutes has a violation in every frame, and they say no more than these.
    """
    outside = ~robot.within_limits(qs, per_joint=True)
    values = qs[:, robot.nq - len(robot.joint_names) :]
    moved = outside & (values != 0.0)
    for table in robot.coupled_limits:
        joint, of = robot.joint_names.index(table.joint), robot.joint_names.index(table.of)
        if robot.lower[joint] <= 0.0 <= robot.upper[joint]:  # else the box refuses zero, whatever the table says
            moved[:, joint] |= outside[:, joint] & (values[:, of] != 0.0)
    return sorted({int(column.argmax()) for column in moved.T if column.any()})


# --- A robot and all that is shown with it: what every page of it gets, live or in a file.

# Between robots that stand beside each other [m]; and how many there may be beside the first.
_GAP = 0.1
_MOST_ROBOTS = 32


class ShownScene(Drawings):
    """What a viewer shows: a robot in a configuration or a clip, other robots, and all that is drawn.

    Attributes:
        robot: the robot on show.
        notes: what of its looks cannot be shown, one line each.
        camera_names: names that `camera` takes.

    Raises:
        BadModel: the robot's URDF can no longer be read.
        BadArgument: no robot.
    """

    def __init__(self, robot: RobotModel) -> None:
        if not isinstance(robot, RobotModel):
            raise BadArgument(f"a viewer shows a robot model, got {type(robot).__name__}")
        super().__init__(SceneRobot(robot))
        self.notes, self._presets = self._look.notes, self._look.presets
        self.camera_names = tuple(self._presets.cameras)
        self._outside = OutsideWarnings(robot)
        for key, command in self._look.commands():
            self._messages.put(key, packed(command))
        self._messages.put("robot", panel_message("robot", {"about": self._look.about()}))
        self._messages.scene_is_complete()
        self._messages.blanks = overlays.blanks(robot)
        self._others: dict[int, ShownRobot] = {}
        self._robot_numbers = itertools.count(1)
        self._edge = self._look.reaches_aside
        self._changes, self._recordings, self._lead = Changes(), list[Recording](), Lead()
        self._show_joints(self._presets.start, None)

    # --- the configuration ----------------------------------------------------------------------------------------

    @property
    def q(self) -> Floats:
        """The configuration on show, shape (nq,): the one last displayed, moved to in a page, or played.

        While a clip plays, or key frames of a page, it is where an open page says that it is, at most thirty times a
        second; of several pages the one in which somebody pressed play or went to a time last, or else the first.
        Without an open page a clip stands at its first configuration.
        """
        return np.array(self._q)

    def display(self, q: ArrayLike, *, up: ArrayLike | None = None) -> None:
        """Show a configuration.

        A joint outside its limits is shown where it is, marked red, and warned of once (`OutsideLimitsWarning`) unless
        it is at zero, where nobody moved it: the neutral configuration of some robots, NAO's too, is not inside. Values
        beyond ±1e6 rad or m are refused, from here and from the page: they are no place of a joint, and not wrapped
        because q would be another one.

        Args:
            q: one configuration, shape (nq,).
            up: for a robot with a fixed base, the vertical in the root's frame, as an accelerometer at rest gives it,
                shape (3,): (−1, 0, 0) lies on its belly. None lets the robot stand, sit or lie by itself: on its soles
                where it is balanced on them, else as the nearest of its postures rests.

        Raises:
            WrongShape, NotFinite, BadArgument, ZeroNorm: q is no configuration, or `up` no direction.

        Examples:
            >>> nao = nk.load_nao()
            >>> viewer = nk.Viewer(nao)
            >>> viewer.display(nao.posture("Crouch"))
            >>> np.array_equal(viewer.q, nao.posture("Crouch"))
            True
        """
        array = overlays.one_configuration(self.robot, q)
        vertical = None if up is None else overlays.direction(up, "up")
        self._outside.check(array)
        with self._lock:
            self._lead.take("")
            if self._messages.get("clip") is not None:
                self._messages.put("clip", panel_message("still", {}))
            self._show_joints(array, vertical)

    def rest(self, posture: str) -> tuple[float, float, float] | None:
        """The vertical in the root's frame where the robot rests in a posture; None if it stands on its soles.

        What is displayed comes to rest so by itself; this is for what asks for it elsewhere, such as an `up`.

        Raises:
            UnknownName: no such posture.

        Examples:
            >>> viewer = nk.Viewer(nk.load_nao())
            >>> viewer.rest("Stand") is None
            True
        """
        return self._presets.rest.get(choice(posture, self._presets.postures, "posture"))

    def animate(
        self,
        qs: ArrayLike | Motion,
        fps: float = 30.0,
        *,
        play: bool = True,
        loop: bool = True,
        fill: str | ArrayLike = HOLD,
        hips: Hips = "average",
        up: ArrayLike | None = None,
    ) -> None:
        """Play configurations one after another, as a meshcat clip that the page can pause and scrub.

        Between two of them every joint moves at constant speed, so that joints of one motor stay together.

        Args:
            qs: configurations, shape (n, nq) with n ≥ 1; or a motion, which is sampled and plays at its own speed.
            fps: configurations per second.
            play: start at once.
            loop: play again and again.
            fill: where joints are that a motion does not name, as in `Motion.configurations`.
            hips: what one motor does that a motion names twice, as there.
            up: as in `display`, shape (3,) for all configurations or (n, 3) for each; None lets the robot stand,
                sit and lie by itself all along.

        Raises:
            WrongShape, NotFinite, BadArgument: qs are no configurations, or fps no positive number.
            ZeroNorm: `up` is no direction.
            UnknownName: a motion of joints that the robot does not have, no such posture, no such rule.

        Examples:
            >>> nao = nk.load_nao()
            >>> viewer = nk.Viewer(nao)
            >>> viewer.animate(np.linspace(nao.posture("Stand"), nao.posture("Crouch"), 30))
            >>> viewer.save_html("down.html").name
            'down.html'
        """
        array, rate = overlays.clip(self.robot, qs, fps, fill, hips)
        play, loop = flag(play, "play"), flag(loop, "loop")
        ups = None if up is None else overlays.directions(up, "up", len(array))
        self._outside.check(array)
        repetitions = math.inf if loop else 1.0
        clip = set_animation(ROBOT, array, rate, play=play, repetitions=repetitions, ups=ups)
        with self._lock:
            self._lead.release()
            self._show_joints(array[0], None if ups is None else ups[0].tolist())
            self._messages.put("clip", packed(clip))

    def camera(self, name: str) -> None:
        """Look at the robot from one of `camera_names`.

        Raises:
            UnknownName: no such camera.

        Examples:
            >>> viewer = nk.Viewer(nk.load_nao())
            >>> viewer.camera("front")
            >>> "front" in viewer.camera_names
            True
        """
        self._check_camera(name)
        self._messages.put("camera", panel_message("camera", {"name": name}))

    # --- what pages do, and what is shown meanwhile ---------------------------------------------------------------

    def on_change(self, callback: ChangeCallback) -> Subscription:
        """Call a function when the robot moves in a page: by sliders, handles, postures, by a clip or key frames.

        It is called in a thread of its own, never twice at once, with a copy of the newest configuration and the names
        of all joints that changed since it was called last; none where the base or the direction up alone did. It may
        take its time, and use the viewer. What it raises is logged, by the logger nao_kin.viewer.shown_scene, and
        changes nothing. `display` does not call it. What is played calls it at most thirty times a second.

        Args:
            callback: called with q, shape (nq,), and the joints' names.

        Returns:
            The subscription, whose `remove` ends it.

        Raises:
            BadArgument: nothing that can be called.

        Examples:
            >>> nao = nk.load_nao()
            >>> viewer = nk.Viewer(nao)
            >>> subscription = viewer.on_change(lambda q, joints: print(joints, nao.fk(q, "LArm")[:3, 3]))
            >>> subscription.remove()
        """
        if not callable(callback):
            raise BadArgument(f"on_change takes a function of q and joint names, got {quoted(callback)}")
        return self._changes.add(callback)

    @contextmanager
    def record(self, fps: float = 30.0) -> Iterator[Recording]:
        """Record what is shown in a `with` block: what is displayed, dragged, and played in a page.

        Move the robot in the page inside the block, and write `recording.motion` to a file after it.

        Args:
            fps: configurations kept per second, at most; see `Recording` for how long ones are kept in bounded memory.

        Raises:
            BadArgument, WrongShape, NotFinite: fps is no positive number.

        Examples:
            >>> nao = nk.load_nao()
            >>> viewer = nk.Viewer(nao)
            >>> with viewer.record() as recording:
            ...     viewer.display(nao.posture("Crouch"))
            >>> recording.q.shape[1]
            25
        """
        rate = overlays.number(fps, "fps")
        if not 0.0 < rate <= 1000.0:
            raise BadArgument(f"fps must be above 0 and at most 1000, got {rate:g}")
        with self._lock:
            recording = Recording(self.robot, self._q, rate)
            self._recordings.append(recording)
        try:
            yield recording
        finally:
            self._recordings.remove(recording)
            recording.finish()

    def add_robot(
        self,
        robot: RobotModel | MultiDofModel,
        *,
        name: str | None = None,
        at: ArrayLike | None = None,
        opacity: float = 1.0,
    ) -> ShownRobot:
        """Put another robot into the scene: a second NAO, its typed model, Romeo.

            other = viewer.add_robot(nk.load_robot("romeo"), at=T_world_ground)
            other.display(q)
            other.remove()

        Args:
            robot: any robot, or a typed model of one.
            name: what it is called, 1 to 200 characters; None for the robot's name.
            at: pose in the world of the ground that it stands on, shape (4, 4); the viewer's own robot stands at the
                origin, x ahead, z up. None for beside the others, to their right.
            opacity: above 0 and at most 1.

        Raises:
            BadArgument: no robot, no name, no opacity; more than 32 robots.
            WrongShape, NotFinite, NotARotation: `at` is no pose.
            BadModel: the robot's URDF can no longer be read.

        Examples:
            >>> nao = nk.load_nao()
            >>> viewer = nk.Viewer(nao)
            >>> T = np.eye(4)
            >>> T[1, 3] = 0.5  # half a metre to the left
            >>> other = viewer.add_robot(nao, name="second", at=T)
            >>> other.name
            'second'
        """
        if not isinstance(robot, (RobotModel, MultiDofModel)):
            raise BadArgument(f"add_robot takes a robot model or a typed model, got {type(robot).__name__}")
        called = (robot.robot if isinstance(robot, MultiDofModel) else robot).name if name is None else name
        overlays.checked_name(called)
        share = overlays.checked_opacity(opacity)
        if len(self._others) >= _MOST_ROBOTS:
            raise BadArgument(f"at most {_MOST_ROBOTS} robots are added; remove some before {abbreviated(called)}")
        place = None if at is None else checked_pose(at)
        number = next(self._robot_numbers)
        added = ShownRobot(self._messages, robot, number, called, share, self._forget_robot)
        if place is None:
            place = np.eye(4)
            place[1, 3] = -(self._edge + _GAP + added.reaches_aside)
            self._edge += _GAP + 2.0 * added.reaches_aside
        added.place(place)
        self._others[number] = added
        self._list_robots()
        return added

    def _forget_robot(self, number: int) -> None:
        del self._others[number]
        if not self._others:
            self._edge = self._look.reaches_aside
        self._list_robots()

    def _list_robots(self) -> None:
        """Which robots there are: a page forgets all others, whatever it has missed."""
        self._messages.put("robots", panel_message("robots", {"robots": list(self._others)}))

    # --- the file ---------------------------------------------------------------------------------------------------

    def static_html(self) -> str:
        """The page with all that is on show inside: it needs no server and no network.

        Examples:
            >>> viewer = nk.Viewer(nk.load_nao())
            >>> viewer.static_html().startswith("<!DOCTYPE html>")
            True
        """
        return static_page(self.robot.name, self._messages.messages())

    def save_html(self, path: Path | str) -> Path:
        """Write `static_html` to a file, whole or not at all.

        Returns:
            The file.

        Raises:
            BadArgument: it cannot be written.

        Examples:
            >>> viewer = nk.Viewer(nk.load_nao())
            >>> viewer.save_html("nao.html").stat().st_size > 1_000_000
            True
        """
        atomic.write_text(path, self.static_html())
        return Path(path)

    # --- inside ---------------------------------------------------------------------------------------------------

    def _show_joints(self, q: Floats, up: list[float] | None, source: str = "") -> None:
        # What a page does comes behind the clip that it stops: pages that open later have the clip, and do not play it.
        behind_clip = source != "" and self._messages.get("clip") is not None
        if not behind_clip:
            self._messages.drop("moved")
        message = panel_message("joints", {"q": typed_array(q), "up": up, "source": source})
        self._messages.put("moved" if behind_clip else "joints", message)
        self._note(q)

    def _note(self, q: Floats) -> None:
        self._q = q
        for recording in tuple(self._recordings):
            recording.show(q)

    def _changed(self, before: Floats, q: Floats) -> tuple[str, ...]:
        """The joints whose values differ."""
        names = self.robot.joint_names
        differs = (before != q)[len(q) - len(names) :]
        return tuple(name for name, other in zip(names, differs, strict=True) if other)

    def _check_camera(self, name: str) -> None:
        choice(name, self.camera_names, "camera")
