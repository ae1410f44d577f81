"""The robot in a browser: live, as one file, or as a picture."""

from __future__ import annotations

import itertools
import threading
import weakref
import webbrowser
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core import files as atomic
from nao_kin._core.arrays import Floats, choice, flag
from nao_kin._core.guesses import Guessing
from nao_kin._core.text import quoted
from nao_kin.errors import BadArgument, NaoKinError, NoBrowser
from nao_kin.joints import MultiDofModel
from nao_kin.motion import Motion
from nao_kin.reach import ReachMap
from nao_kin.robot import RobotModel
from nao_kin.viewer import overlays
from nao_kin.viewer.access import Document, checked_names, checked_token, live_page, policy, static_page
from nao_kin.viewer.browser import pictures, zipped
from nao_kin.viewer.description import SceneRobot
from nao_kin.viewer.handles import Recording, ShownRobot
from nao_kin.viewer.messages import (
    BLANKS,
    NamedMessages,
    RetainedMessages,
    by_columns,
    panel_message,
    typed_array,
)
from nao_kin.viewer.notebook import NOT_LIVE, Bridge, bridge_of, frame, has_bridge
from nao_kin.viewer.overlays import Buttons
from nao_kin.viewer.panels import Control, Controls, Image, Streams, image_message, in_range, text
from nao_kin.viewer.server import Answer, LiveServer, weak_receiver
from nao_kin.viewer.shown_scene import (
    ChangeCallback,
    Changes,
    Lead,
    MoveCallback,
    Row,
    Subscription,
    Target,
    Targets,
    checked_pose,
    pose_of_page,
    warn_outside,
)

# A page sends its name with its messages, and gets the name back.
_MAX_SOURCE = 64
# Pictures per second of a video.
_MAX_FPS = 240.0


class Viewer(Guessing):
    """Show a robot in a web page, with a panel of joint sliders, postures and read-outs.

    The browser composes the transforms of the links, so that only configurations are sent. The server runs inside this
    process, from the first use of `url` until `close`, or to the end of a `with` block.

    Args:
        robot: any robot.
        host: address to listen on; "127.0.0.1" accepts only connections from this machine.
        port: port to listen on; None for the first free one from 7000.
        allow_hosts: further names under which the page may be requested, such as that of a proxy. The names of this
            machine, its loopback names and the address are always accepted; others get 403. "*" accepts every name, and
            needs a token.
        token: text of at least 8 characters that the page's address must contain; True for a random one, False for
            none. None: a random one if the address or an allowed name is not loopback.

    Attributes:
        robot: the robot.
        notes: shapes that cannot be shown, one line each.
        camera_names: the names for `camera`.
        light_names: the names for `show_lights`; empty for a robot without lights.

    Raises:
        BadModel: the robot's URDF can no longer be read.
        BadArgument: when the server starts: the port or the address is not available, or every name is allowed without
            a token.

    Examples:
        >>> nao = nk.load_nao()
        >>> viewer = nk.Viewer(nao)
        >>> viewer.display(nao.posture("Crouch"))
        >>> viewer.save_html("crouch.html").name
        'crouch.html'
    """

    def __init__(
        self,
        robot: RobotModel,
        *,
        host: str = "127.0.0.1",
        port: int | None = None,
        allow_hosts: Iterable[str] = (),
        token: bool | str | None = None,
    ) -> None:
        # The server, and the finalizer that ends it; the server is released only after the finalizer has run.
        self._server: LiveServer | None = None
        self._end_server: Callable[[], object] | None = None
        self._starting = threading.Lock()
        self._allow_hosts, self._token = checked_names(allow_hosts), checked_token(token)
        self.host, self._port = host, port
        self._bridges = list[Bridge]()
        # The robots of the scene; the first one leads.
        self._look, self._numbers = SceneRobot(robot), itertools.count(1)
        self._robots, self._row = [self._look], Row(self._look.aside)
        self.robot, self.notes, self.light_names = robot, self._look.notes, self._look.light_names
        self.camera_names = tuple(self._look.cameras)
        # Held while the state and its message change: a page's messages arrive in another thread.
        self._messages, self._lock = RetainedMessages(), threading.RLock()
        self._buttons = Buttons(self._messages, self._lock)
        self._shapes = NamedMessages(self._messages, "extra", "extras")
        # Sources and receivers of the robot's movements.
        self._lead, self._warned = Lead(), set[str]()
        self._changes, self._recordings = Changes(), list[Recording]()
        self._camera_pose: Floats | None = None
        self._targets = Targets("targets", self._messages, self._lock, self._changes)
        self._controls = Controls("controls", self._messages, self._lock, self._changes)
        self._images = NamedMessages(self._messages, "image", "images")
        self._streams = Streams(self._messages)
        self._send_robot(self._look)
        self._messages.scene_is_complete()
        self._show_joints(self._look.start, None)

    # --- the configuration ----------------------------------------------------------------------------------------

    @property
    def q(self) -> Floats:
        """The displayed configuration, shape (nq,): the last one displayed, set in a page, or played.

        While a clip or the key frames of a page play, an open page reports the configuration, at most thirty times a
        second. If there are several pages, this is the page in which a user last pressed play or moved the time,
        otherwise the first. With no page open, a clip stays at its first configuration.
        """
        return np.array(self._q)

    def display(self, q: ArrayLike, *, up: ArrayLike | None = None) -> None:
        """Show a configuration.

        A joint outside its limits is shown at its value and marked red, with one warning (`OutsideLimitsWarning`). A
        joint at zero causes no warning, because the neutral configuration of some robots, such as the NAO, is outside.
        Values are not wrapped.

        Args:
            q: one configuration, shape (nq,).
            up: for a robot with a fixed base, the vertical in the root's frame, as an accelerometer at rest measures
                it, shape (3,): (−1, 0, 0) for a robot on its belly. With None the viewer computes it: the robot stands
                on its soles if it is balanced on them, and otherwise rests as in its nearest posture.

        Raises:
            ZeroNorm: `up` is not a direction.

        Examples:
            >>> nao = nk.load_nao()
            >>> viewer = nk.Viewer(nao)
            >>> viewer.display(nao.posture("Crouch"))
            >>> np.array_equal(viewer.q, nao.posture("Crouch"))
            True
        """
        array = overlays.one_configuration(self.robot, q)
        vertical = None if up is None else overlays.direction(up, "up")
        warn_outside(self.robot, array, self._warned)
        with self._lock:
            self._lead.take("")
            if self._messages.get("clip") is not None:
                self._messages.put("clip", panel_message("still", {}))
            self._show_joints(array, vertical)

    def rest(self, posture: str) -> tuple[float, float, float] | None:
        """Return the vertical in the root's frame for a robot that rests in a posture; None if it stands on its soles.

        `display` computes this itself; you need it only to give `up`.

        Examples:
            >>> viewer = nk.Viewer(nk.load_nao())
            >>> viewer.rest("Stand") is None
            True
        """
        return self._look.rest.get(choice(posture, self.robot.posture_names, "posture"))

    def animate(
        self,
        qs: ArrayLike | Motion,
        fps: float = 30.0,
        *,
        play: bool = True,
        loop: bool = True,
        missing: str | ArrayLike = "hold",
        up: ArrayLike | None = None,
        balance: bool = False,
        figure: ArrayLike | None = None,
    ) -> None:
        """Play a sequence of configurations, as a clip that the page can pause and scrub.

        Between two configurations every joint moves at constant speed, so that joints of one motor stay together. A
        motion is played along its own curves, at its own speed.

        Args:
            qs: configurations, shape (n, nq) with n ≥ 1; or a motion.
            fps: configurations per second; of a motion only the samples of `up` and `figure`, and of the rare motion in
                which Bezier curves of two joints that differ in time move one motor.
            play: start immediately.
            loop: repeat the clip.
            missing: values of the joints that a motion does not name, as in `Motion.configurations`.
            up: as in `display`, shape (3,) for all configurations or (n, 3) for each; None to compute it.
            balance: also plot the margins of the zero-moment point and of the centre of mass over time, as in
                `nk.motion.check`; red where the robot tips.
            figure: a stick figure that moves with them and leaves with the clip, such as a person: both ends of each
                bone in the world, shape (n, bones, 2, 3) [m]; NaN for unknown ends.

        Raises:
            BadArgument: `balance` of a robot without soles.

        Examples:
            >>> nao = nk.load_nao()
            >>> viewer = nk.Viewer(nao)
            >>> viewer.animate(np.linspace(nao.posture("Stand"), nao.posture("Crouch"), 30))
        """
        array, rate = overlays.clip(self.robot, qs, fps, missing)
        play, loop = flag(play, "play"), flag(loop, "loop")
        ups = None if up is None else overlays.directions(up, "up", len(array))
        moving = qs if isinstance(qs, Motion) else array
        margins = overlays.margins(self.robot, moving, rate, missing) if flag(balance, "balance") else None
        warn_outside(self.robot, array, self._warned)
        content = {
            **overlays.curves(self.robot, moving, rate, missing),
            "fps": rate,
            "ups": None if ups is None else typed_array(ups.astype(np.float32).reshape(-1)),
            "figure": None if figure is None else overlays.figure(figure, len(array), rate),
            "play": play,
            "loop": loop,
        }
        self._streams.restart()
        self._streams.show_margins(margins)
        with self._lock:
            self._lead.release()
            self._show_joints(array[0], None if ups is None else ups[0].tolist())
            self._messages.put("clip", panel_message("clip", content))

    def camera(self, name: str) -> None:
        """Look at the robot from one of `camera_names`.

        Examples:
            >>> viewer = nk.Viewer(nk.load_nao())
            >>> viewer.camera("front")
        """
        choice(name, self.camera_names, "camera")
        self._look_from(name)

    @property
    def camera_pose(self) -> Floats | None:
        """The pose of the page's camera in the world, T_world_camera, shape (4, 4); set it to move the camera.

        The camera's frame is a body frame, as of a NAO's CameraTop: x along the optical axis, y to the left, z up. The
        world is that of `add_points`: its origin is on the floor, z up. The vertical field of view is 28°, and a user
        turns the camera about the point of its axis nearest to the robots.

        Reading returns the pose that an open page reported last, at most ten times a second, or a newer one that you
        set; None if no page has reported any. With several pages it is that of the page whose camera moved last.
        Setting moves the camera in all pages, and in those that open later; a camera that looks straight down or up is
        turned by up to 1e-5 rad.

        Raises:
            NotARotation: the value is not a pose.

        Examples:
            >>> viewer = nk.Viewer(nk.load_nao())
            >>> viewer.camera_pose is None
            True
            >>> viewer.camera_pose = nk.screws.pose(nk.rotations.rot_z(np.pi), [1.5, 0.0, 0.3])  # from the front
            >>> viewer.camera_pose[:3, 3].tolist()
            [1.5, 0.0, 0.3]
        """
        return None if self._camera_pose is None else np.array(self._camera_pose)

    @camera_pose.setter
    def camera_pose(self, T: ArrayLike) -> None:
        pose = checked_pose(T)
        with self._lock:
            self._camera_pose = pose
            self._look_from(pose)

    def _look_from(self, camera: str | Floats) -> None:
        content = camera if isinstance(camera, str) else by_columns(camera)
        self._messages.put("camera", panel_message("camera", {"camera": content}))

    # --- movements by a page, and recordings ----------------------------------------------------------------------

    def on_change(self, callback: ChangeCallback) -> Subscription:
        """Call a function when the robot moves in a page: by sliders, handles, postures, a clip or key frames.

        The calls run in a separate thread, one at a time, at most thirty a second for a clip. The function gets a copy
        of the newest configuration and the names of all joints that changed since the last call, none if only the base
        or the vertical changed. It may be slow, and may use the viewer. Exceptions are logged by the logger
        nao_kin.viewer.shown_scene, and otherwise ignored. `display` causes no call.

        Args:
            callback: called with q, shape (nq,), and the joint names.

        Returns:
            The subscription; its `remove` ends the calls.

        Examples:
            >>> nao = nk.load_nao()
            >>> viewer = nk.Viewer(nao)
            >>> subscription = viewer.on_change(lambda q, joints: print(joints, nao.fk(q, "LArm")[:3, 3]))
            >>> subscription.remove()
        """
        return self._changes.add(callback)

    @contextmanager
    def record(self, fps: float = 30.0) -> Iterator[Recording]:
        """Record the configurations that are displayed, dragged and played in a `with` block.

        Move the robot in the page inside the block, and write `recording.motion` to a file afterwards. At most `fps`
        configurations are recorded per second; `Recording` bounds the memory of long recordings.

        Examples:
            >>> nao = nk.load_nao()
            >>> viewer = nk.Viewer(nao)
            >>> with viewer.record() as recording:
            ...     viewer.display(nao.posture("Crouch"))
            >>> recording.q.shape[1]
            25
        """
        rate = overlays.positive(fps, "fps")
        with self._lock:
            recording = Recording(self.robot, self._q, rate)
            self._recordings.append(recording)
        try:
            yield recording
        finally:
            self._recordings.remove(recording)
            recording.finish()

    # --- additional robots ------------------------------------------------------------------------------------------

    def add_robot(
        self,
        robot: RobotModel | MultiDofModel,
        *,
        name: str | None = None,
        at: ArrayLike | None = None,
        opacity: float = 1.0,
    ) -> ShownRobot:
        """Add another robot to the scene, such as a second NAO, its typed model, or Romeo.

        Args:
            robot: any robot, or a typed model of one.
            name: its name in the page, 1 to 200 characters; None for the robot's name.
            at: pose in the world of the ground on which it stands, shape (4, 4); the viewer's own robot stands at the
                origin, x ahead, z up. None to place it to the right of the others.
            opacity: above 0 and at most 1.

        Raises:
            NotARotation: `at` is not a pose.
            BadModel: the robot's URDF can no longer be read.

        Examples:
            >>> nao = nk.load_nao()
            >>> viewer = nk.Viewer(nao)
            >>> other = viewer.add_robot(nao, name="second")
            >>> other.display(nao.posture("Sit"))
        """
        model = robot.robot if isinstance(robot, MultiDofModel) else robot
        called = overlays.checked_name(model.name if name is None else name)
        share = overlays.checked_opacity(opacity)
        place = None if at is None else checked_pose(at)
        like = next((other for other in self._robots if other.robot.tree is model.tree), None)
        look = SceneRobot(model, next(self._numbers), like)
        with self._lock:
            self._send_robot(look, called, share)
            added = ShownRobot(self._messages, look, robot, called, self._forget)
            added.place(self._row.place(look.aside) if place is None else place)
            self._robots.append(look)
            self._list_robots()
        return added

    def _send_robot(self, look: SceneRobot, name: str = "", opacity: float = 1.0) -> None:
        for key, message in look.parts().items():
            if self._messages.get(key) is None:  # no other robot has it
                self._messages.put(key, message)
        for key, message in look.messages(name, opacity):
            self._messages.put(key, message)

    def _forget(self, look: SceneRobot) -> None:
        with self._lock:
            self._robots.remove(look)
            for key in look.parts().keys() - set().union(*(other.parts() for other in self._robots)):
                self._messages.drop(key)
            if len(self._robots) == 1:
                self._row = Row(self._look.aside)
            self._list_robots()

    def _list_robots(self) -> None:
        """Send the list of robots, after them, so that a page keeps their parts but removes those of all others."""
        self._messages.drop("robots")
        self._messages.put("robots", panel_message("robots", {"robots": [look.number for look in self._robots[1:]]}))

    # --- overlays of the robot ------------------------------------------------------------------------------------

    @property
    def shown(self) -> Mapping[str, bool]:
        """The state of the page's buttons, by name: frames, axes, com, support, ghosts, handles and others.

        A button pressed in one page changes it here and in every other page.
        """
        return MappingProxyType(dict(self._buttons.shown))

    def show(self, name: str, on: bool = True) -> None:
        """Switch a button of the page's menu View in all pages.

        Args:
            name: "frames", "axes", "chains", "com", "support", "shapes" (for collisions), "inertia" (for each body the
                even box with its mass and inertia, and the mass), "ghosts", "together" (in the page, added robots take
                the values of the viewer's own joints of the same names), "eye" (the camera view), "orthographic"
                (parallel projection), "contrast" or "handles". If collision shapes are meshes, the page offers them
                only after this has been called.
            on: whether it is on.

        Examples:
            >>> viewer = nk.Viewer(nk.load_nao())
            >>> viewer.show("orthographic")
            >>> viewer.camera("top")
            >>> viewer.shown["orthographic"]
            True
        """
        if not isinstance(name, str):
            raise BadArgument("show takes the name of what is drawn; display(q) shows a configuration")
        if choice(name, overlays.BUTTONS, "button") == "shapes" and self._messages.get("shapes") is None:
            self._messages.put("shapes", self._look.shapes())
        self._buttons.press(name, on)

    def show_frames(self, names: Iterable[str], *, size: float | None = None) -> None:
        """Draw frames as triads, x red, y green, z blue, with their names, instead of the previous ones.

        Args:
            names: frame names; empty to remove all.
            size: length of the arrows [m]; None for a length that suits the robot.

        Examples:
            >>> viewer = nk.Viewer(nk.load_nao())
            >>> viewer.show_frames(["LArm", "CameraTop"])
            >>> viewer.shown["frames"]
            True
        """
        chosen = overlays.frame_names(self.robot, names)
        length = None if size is None else overlays.positive(size, "size")
        self._buttons.draw("frames", panel_message("frames", {"names": chosen, "size": length}), on=bool(chosen))

    def show_joint_axes(self, on: bool = True) -> None:
        """Draw the joint axes as screws, turning or sliding.

        The colour shows the kind of joint by `nao_kin.joints.group_joints`: revolute, prismatic, universal, spherical …

        Examples:
            >>> viewer = nk.Viewer(nk.load_nao())
            >>> viewer.show_joint_axes()
        """
        self._buttons.press("axes", on)

    def show_com(self, on: bool = True) -> None:
        """Draw the centre of mass and its projection onto the floor.

        Examples:
            >>> viewer = nk.Viewer(nk.load_nao())
            >>> viewer.show_com()
        """
        self._buttons.press("com", on)

    def show_support_polygon(self, on: bool = True) -> None:
        """Draw the convex hull of the contacts with the floor: green if the centre of mass is above it, red otherwise.

        A line shows the margin, from the centre of mass to the nearest edge. The contacts are those of `world.balance`.

        Examples:
            >>> viewer = nk.Viewer(nk.load_nao())
            >>> viewer.show_support_polygon()
        """
        self._buttons.press("support", on)

    def show_ghosts(self, configurations: ArrayLike, *, opacity: float = 0.3, first: int = 1) -> None:
        """Draw the links of other configurations, pale, instead of the previous ghosts.

        Links in the same pose as those of the robot are not drawn twice. A single configuration is blue and stays until
        it is cleared. Several rows have one colour each, and numbers in the page's legend; they belong to the displayed
        configuration, and dragging a limb in a page removes them there.

        Args:
            configurations: one, shape (nq,), or several, shape (k, nq); k = 0 removes all ghosts.
            opacity: opacity of the links, above 0 and at most 1.
            first: number of the first row in the legend, at least 0; 2 if the robot itself shows solution 1.

        Examples:
            >>> nao = nk.load_nao()
            >>> viewer = nk.Viewer(nao)
            >>> found = nk.ik.arm(nao, "L", nao.fk(nao.posture("Stand"), "LArm"), limits="ignore")
            >>> viewer.display(found.q)
            >>> viewer.show_ghosts(found.solutions[1:], first=2)
        """
        self._buttons.draw("ghosts", overlays.ghosts(self.robot, configurations, opacity, first), on=True)

    def clear_ghosts(self) -> None:
        """Remove the ghosts of `show_ghosts`.

        Examples:
            >>> viewer = nk.Viewer(nk.load_nao())
            >>> viewer.clear_ghosts()
        """
        self.show_ghosts(np.zeros((0, self.robot.nq)))

    def show_targets(self, targets: Mapping[str, ArrayLike]) -> None:
        """Mark points or poses in the robot's root frame, under any names, instead of the previous marks.

        An empty mapping removes them. Targets of `add_target` stay.

        Args:
            targets: name → position, shape (3,) [m], or pose, shape (4, 4).

        Examples:
            >>> viewer = nk.Viewer(nk.load_nao())
            >>> viewer.show_targets({"cup": [0.2, 0.1, 0.1]})
        """
        self._targets.show(targets)

    def add_target(
        self,
        name: str,
        T: ArrayLike,
        *,
        on_move: MoveCallback | None = None,
        on_grab: MoveCallback | None = None,
        on_release: MoveCallback | None = None,
    ) -> Target:
        """Add a target that a user can drag in the page: a ball at a position, or a triad at a pose.

        It replaces the target that was added under the same name. The ball follows the pointer, its arrows keep it on
        an axis, and the rings of a pose turn it; the keyboard does the same.

        The functions are called in the thread of `on_change`, `on_move` at most thirty times a second, with the newest
        place. They may be slow, and may use the viewer; exceptions are logged. `Target.place` calls none of them.

        Args:
            name: its name in the page, 1 to 200 characters.
            T: position, shape (3,) [m], or pose, shape (4, 4), in the robot's root frame.
            on_move: called with the new position or pose, of the shape of T, when a user moves the target.
            on_grab: called with the position or pose when a user grabs the target, by pointer or by keyboard.
            on_release: called with the last position or pose when a user lets it go.

        Returns:
            The target: `T` is its position or pose, `place` moves it, and `remove` removes it.

        Raises:
            NotARotation: T is not a pose.

        Examples:
            >>> nao = nk.load_nao()
            >>> viewer = nk.Viewer(nao)
            >>> viewer.display(nao.posture("Crouch"))
            >>> ball = viewer.add_target(
            ...     "ball", [0.2, 0.1, 0.1], on_move=lambda T: viewer.display(nk.ik.arm(nao, "L", T, near=viewer.q).q)
            ... )
            >>> ball.T.tolist()
            [0.2, 0.1, 0.1]
        """
        return self._targets.add(name, T, on_move=on_move, on_grab=on_grab, on_release=on_release)

    # --- controls in the panel ------------------------------------------------------------------------------------

    def add_button(self, name: str, on_click: Callable[[], object] | None = None) -> Control:
        """Add a button to the panel of the page, in its section *Program*; it replaces the control of the same name.

        The functions of controls are called in the thread of `on_change`, one at a time. They may be slow, and may use
        the viewer; exceptions are logged. A saved page shows the controls with their values, disabled.

        Args:
            name: its text, 1 to 200 characters.
            on_click: called without arguments for each press; while it is busy, up to 16 presses wait.

        Returns:
            The button; its `value` is how often it was pressed.

        Examples:
            >>> nao = nk.load_nao()
            >>> viewer = nk.Viewer(nao)
            >>> sit = viewer.add_button("sit down", lambda: viewer.display(nao.posture("Sit")))
            >>> sit.value
            0
        """
        return self._controls.add(name, {"kind": "button"}, 0, lambda _: 0, on_click)

    def add_slider(
        self,
        name: str,
        low: float,
        high: float,
        value: float | None = None,
        on_change: Callable[[float], object] | None = None,
        *,
        unit: str = "",
    ) -> Control:
        """Add a slider to the panel of the page, with a field in which its number can be typed; as `add_button`.

        Changes by a user can be undone in the page, which is a change too.

        Args:
            name: its name in the page, 1 to 200 characters.
            low: the smallest value.
            high: the largest value.
            value: the value at first; None for `low`.
            on_change: called with the newest number when a user changes it, at most thirty times a second.
            unit: text behind the number.

        Raises:
            BadArgument: low is not below high, or the value is outside.

        Examples:
            >>> nao = nk.load_nao()
            >>> viewer = nk.Viewer(nao)
            >>> def bend(share: float) -> None:
            ...     viewer.display((1.0 - share) * nao.posture("Stand") + share * nao.posture("Crouch"))
            >>> depth = viewer.add_slider("depth", 0.0, 1.0, on_change=bend)
            >>> depth.value
            0.0
        """
        ends = overlays.number(low, "low"), overlays.number(high, "high")
        if not ends[0] < ends[1]:
            raise BadArgument(f"a slider needs low < high, got {ends[0]:g} and {ends[1]:g}")
        row = {"kind": "slider", "low": ends[0], "high": ends[1], "unit": text(unit)}
        return self._controls.add(name, row, ends[0] if value is None else value, partial(in_range, ends), on_change)

    def add_select(
        self,
        name: str,
        options: Iterable[str],
        value: str | None = None,
        on_change: Callable[[str], object] | None = None,
    ) -> Control:
        """Add a list, of which a user selects one option, to the panel of the page; as `add_slider`.

        Args:
            name: its name in the page, 1 to 200 characters.
            options: different texts.
            value: the option that is selected at first; None for the first one.
            on_change: called with the option that a user selects.

        Raises:
            UnknownName: the value is not an option.
            BadArgument: an option twice.

        Examples:
            >>> viewer = nk.Viewer(nk.load_nao())
            >>> side = viewer.add_select("side", ["left", "right"], on_change=print)
            >>> side.value
            'left'
        """
        rows = [] if isinstance(options, str) else [overlays.checked_name(option) for option in options]
        if not rows or len(set(rows)) < len(rows):
            raise BadArgument(f"options must be different texts, got {quoted(options)}")
        checked = partial(choice, valid=tuple(rows), what="option")
        row = {"kind": "select", "options": rows}
        return self._controls.add(name, row, rows[0] if value is None else value, checked, on_change)

    def add_text(self, name: str, value: str = "", on_change: Callable[[str], object] | None = None) -> Control:
        """Add a text to the panel of the page; a user can edit it if there is a function to call; as `add_slider`.

        Args:
            name: its name in the page, 1 to 200 characters.
            value: the text.
            on_change: called with the text that a user has edited, after Enter or when the field loses the focus.

        Examples:
            >>> viewer = nk.Viewer(nk.load_nao())
            >>> state = viewer.add_text("state", "ready")
            >>> state.value = "walking"
        """
        return self._controls.add(name, {"kind": "text", "edited": on_change is not None}, value, text, on_change)

    def show_image(self, camera: str, image: Image | None) -> None:
        """Show an image of a camera of the robot in the page, instead of the drawn view; None removes it.

        The image appears in the page's inset *Camera view*, which the first image opens, and on the far end of the
        camera's frustum.

        Args:
            camera: name of a camera of the robot, such as "CameraTop".
            image: red, green and blue, shape (h, w, 3), or grey, shape (h, w), of type uint8; or the bytes of a PNG or
                JPEG file.

        Raises:
            UnknownName: the robot has no such camera.

        Examples:
            >>> viewer = nk.Viewer(nk.load_nao())
            >>> viewer.show_image("CameraTop", np.full((240, 320, 3), 128, np.uint8))
            >>> viewer.show_image("CameraTop", None)
        """
        choice(camera, self.robot.semantics.cameras, "camera")
        message = None if image is None else image_message(camera, image)
        with self._lock:
            is_first = camera not in self._images.names
            if message is None:
                self._images.drop(camera)
            else:
                self._images.put(camera, message)
                if is_first:
                    self._buttons.press("eye", True)

    def plot(
        self, name: str, value: ArrayLike | Mapping[str, ArrayLike] | None, *, time: ArrayLike | None = None
    ) -> None:
        """Add a point to a plot over time in the page, with one line or several; None as the value removes the plot.

        The page draws the newest 100 000 points as they come, and marks the time of a clip that is playing. A time
        before the last one begins the plot anew.

        Args:
            name: title of the plot, 1 to 200 characters.
            value: a number; or a mapping, line → number. The first mapping names the lines; a later one may leave some
                out.
            time: time of the point [s]; None for the time of the call, counted from when the viewer was made or
                `animate` was last called.

        Raises:
            UnknownName: a line that the first mapping does not name.

        Examples:
            >>> viewer = nk.Viewer(nk.load_nao())
            >>> for t in np.linspace(0.0, 1.0, 11):
            ...     viewer.plot("LFoot/FSR", {"front": 10.0 + t, "rear": 12.0 - t}, time=t)
            >>> viewer.plot("LFoot/FSR", None)
        """
        if value is None:
            self._streams.remove(name)
            return
        values = self._streams.add(name, value, time)
        for recording in tuple(self._recordings):
            recording.note(name, values)

    def color_links(
        self, values: Mapping[str, float], *, low: float | None = None, high: float | None = None, label: str = ""
    ) -> None:
        """Colour links by numbers, cold to warm, with a legend; an empty mapping restores their own colours.

        A link without a shape colours the link to which it is fixed, unless that link is named too.

        Args:
            values: link name → number.
            low: the number at the cold end; None for the smallest.
            high: the number at the warm end; None for the largest.
            label: title of the legend.

        Examples:
            >>> viewer = nk.Viewer(nk.load_nao())
            >>> viewer.color_links({"Head": 0.2, "torso": 0.8}, low=0.0, high=1.0, label="load")
        """
        self._messages.put(*self._look.colours(values, low, high, label))

    def show_collisions(self, on: bool = True) -> None:
        """Colour links that overlap orange, in this configuration and whenever the robot moves; False ends this.

        This presses the page's button *Overlaps*. The page itself finds the links, by the rules of
        `RobotModel.collisions` with `exact=False`, also in a saved file. If the robot's semantics name the pairs of
        links that cannot collide, it has the button from the beginning; for other robots this call finds these pairs,
        which may take seconds.

        Args:
            on: whether to show them.

        Raises:
            BadArgument: the robot has no shapes.

        Examples:
            >>> nao = nk.load_nao()
            >>> viewer = nk.Viewer(nao)
            >>> viewer.show_collisions()
            >>> viewer.display(nao.posture("Crouch"))
        """
        if flag(on, "on"):
            self._send_hulls()
        self._buttons.press("collisions", on)

    def _send_hulls(self) -> None:
        if self._messages.get("hulls") is None:
            self._messages.put("hulls", self._look.hulls())

    def _send_known_hulls(self) -> None:
        """Send the hulls if the semantics name the pairs that cannot collide: to search for them takes seconds."""
        if self.robot.semantics.disabled_collisions:
            with suppress(BadArgument):
                self._send_hulls()

    def show_reach(self, reach: ReachMap | None, *, by: str = "best", cut: tuple[str, float] | None = None) -> None:
        """Draw a reach map as coloured voxels, with a slider that cuts them along an axis; None removes it.

        A map of more than 40 000 voxels is drawn with coarser ones.

        Args:
            reach: a map of this robot.
            by: quantity of the colours: "best", "mean" (manipulability), "count" or "coverage".
            cut: axis, "x", "y" or "z", and coordinate of the cut in the map's reference frame [m]; voxels beyond it are
                not drawn. None for the middle along x.

        Raises:
            BadArgument: the map is of another robot, or empty.

        Examples:
            >>> nao = nk.load_nao()
            >>> viewer = nk.Viewer(nao)
            >>> viewer.show_reach(nk.reach.workspace(nao, "LArm", 1000, voxel=0.05), by="count")
        """
        self._messages.put("reach", overlays.reach(self.robot, reach, by, cut))

    def show_lights(self, colours: Mapping[str, ArrayLike]) -> None:
        """Set the colours of the robot's lights; lights that are not named get the appearance of their mesh.

        A NAO has Chest, LeftFoot, RightFoot, and LeftEye0 … LeftEye7 and RightEye0 … RightEye7, counted from the top of
        each eye towards the nose; LeftEye and RightEye mean all eight. Black means that the light is off. Lights are
        the LEDs of this library's own meshes: other robots have none.

        Args:
            colours: one of `light_names` → red, green and blue, shape (3,), each from 0 to 1; may be empty.

        Examples:
            >>> viewer = nk.Viewer(nk.load_nao())
            >>> viewer.show_lights({"LeftEye": (0.0, 1.0, 0.0), "LeftEye0": (1.0, 0.0, 0.0)})
        """
        self._messages.put("lights", self._look.lights(colours))

    # --- other shapes ---------------------------------------------------------------------------------------------

    def add_points(
        self,
        name: str,
        points: ArrayLike,
        *,
        colors: ArrayLike | None = None,
        size: float = 0.005,
        frame: str | None = None,
    ) -> None:
        """Draw a cloud of points; it replaces the shape of the same name.

        Args:
            name: name for `remove`, 1 to 200 characters.
            points: shape (n, 3) [m].
            colors: red, green and blue from 0 to 1, shape (3,) for all or (n, 3) for each; None for blue.
            size: diameter of a point [m].
            frame: frame of the robot in which the points are given and with which they move; None for the world, with
                its origin on the floor below the robot's root, z up.

        Examples:
            >>> viewer = nk.Viewer(nk.load_nao())
            >>> viewer.add_points("path", [[0.2, 0.1, 0.1], [0.2, 0.1, 0.2]], colors=[1.0, 0.0, 0.0])
        """
        self._add(name, "points", frame, overlays.points(points, colors, size))

    def add_mesh(
        self,
        name: str,
        vertices: ArrayLike | Path | str,
        faces: ArrayLike | None = None,
        *,
        color: ArrayLike | None = None,
        opacity: float = 1.0,
        frame: str | None = None,
    ) -> None:
        """Draw a surface of triangles; it replaces the shape of the same name.

        Args:
            name: name for `remove`, 1 to 200 characters.
            vertices: shape (n, 3) [m]; or a file that trimesh reads (STL, OBJ, PLY, GLB …), in metres.
            faces: rows of `vertices` at the corners of the triangles, shape (m, 3); not for a file.
            color: red, green and blue from 0 to 1, shape (3,); None for the file's own, or blue.
            opacity: above 0 and at most 1.
            frame: as in `add_points`.

        Raises:
            BadArgument: the file cannot be read, or no triangle has an area.

        Examples:
            >>> viewer = nk.Viewer(nk.load_nao())
            >>> viewer.add_mesh("triangle", [[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]], [[0, 1, 2]], frame="LArm")
        """
        self._add(name, "mesh", frame, overlays.mesh(vertices, faces, color, opacity))

    def add_line(
        self,
        name: str,
        points: ArrayLike,
        *,
        color: ArrayLike | None = None,
        width: float = 0.004,
        frame: str | None = None,
    ) -> None:
        """Draw a line through points, round like a wire; it replaces the shape of the same name.

        Args:
            name: name for `remove`, 1 to 200 characters.
            points: shape (n, 3) with n ≥ 2 [m].
            color: red, green and blue from 0 to 1, shape (3,); None for blue.
            width: its thickness [m].
            frame: as in `add_points`.

        Examples:
            >>> viewer = nk.Viewer(nk.load_nao())
            >>> viewer.add_line("path", [[0.2, 0.1, 0.1], [0.2, 0.1, 0.2]], width=0.002)
        """
        self._add(name, "line", frame, overlays.line(points, color, width))

    def add_arrow(
        self,
        name: str,
        start: ArrayLike,
        end: ArrayLike,
        *,
        color: ArrayLike | None = None,
        width: float = 0.006,
        frame: str | None = None,
    ) -> None:
        """Draw an arrow, such as a force; it replaces the shape of the same name.

        Args:
            name: name for `remove`, 1 to 200 characters.
            start: where it begins, shape (3,) [m].
            end: where its head ends, shape (3,) [m]; at `start` nothing is drawn.
            color: red, green and blue from 0 to 1, shape (3,); None for blue.
            width: thickness of its shaft [m]; the head is three times as wide.
            frame: as in `add_points`.

        Examples:
            >>> viewer = nk.Viewer(nk.load_nao())
            >>> weight = 0.002 * np.array([0.0, 0.0, 52.6])  # 2 mm for each newton
            >>> viewer.add_arrow("weight", [0.0, 0.0, 0.0], weight, color=[0.9, 0.2, 0.1])
        """
        self._add(name, "arrow", frame, overlays.arrow(start, end, color, width))

    def add_label(self, name: str, text: str, place: ArrayLike, *, frame: str | None = None) -> None:
        """Write a text at a place in the picture; it replaces the shape of the same name.

        The page keeps labels from covering each other, with lines to their places, and shows at most 60 characters.

        Args:
            name: name for `remove`, 1 to 200 characters.
            text: 1 to 200 characters on one line.
            place: shape (3,) [m].
            frame: as in `add_points`.

        Examples:
            >>> viewer = nk.Viewer(nk.load_nao())
            >>> viewer.add_label("hand", "grasps here", [0.05, 0.0, 0.0], frame="LArm")
        """
        self._add(name, "label", frame, overlays.label(text, place))

    def remove(self, name: str) -> None:
        """Remove the points, the mesh, the line, the arrow or the label with this name.

        Examples:
            >>> viewer = nk.Viewer(nk.load_nao())
            >>> viewer.add_points("path", [[0.2, 0.1, 0.1]])
            >>> viewer.remove("path")
        """
        with self._lock:
            self._shapes.drop(choice(name, self._shapes.names, "shape"))

    # --- the live page --------------------------------------------------------------------------------------------

    @property
    def url(self) -> str:
        """The address of the live page, with its token if it has one; the first use starts the server.

        Raises:
            BadArgument: the port is in use, or the address is not available.
        """
        return self._started().url

    def open(self) -> None:
        """Open the live page in this machine's web browser.

        Raises:
            NoBrowser: Python finds no browser.
        """
        if not webbrowser.open(self.url):
            raise NoBrowser(f"no web browser to open {self._started().address} with")

    def wait(self, timeout: float | None = None) -> None:
        """Wait until a browser shows the scene.

        Args:
            timeout: seconds; None to wait forever.

        Raises:
            NoBrowser: no browser showed the scene in time, or the viewer was closed.

        Examples:
            >>> with nk.Viewer(nk.load_nao()) as viewer:
            ...     viewer.wait(timeout=0.01)
            Traceback (most recent call last):
                ...
            nao_kin.errors.NoBrowser: no browser opened the page within 0.01 s
        """
        if timeout is not None:
            timeout = overlays.seconds(timeout)
        if not self._started().wait_for_page(timeout):
            raise NoBrowser("no browser opened the page" + ("" if timeout is None else f" within {timeout:g} s"))

    def close(self) -> None:
        """Stop the server and close the connections of all pages; does nothing if it does not run.

        Examples:
            >>> viewer = nk.Viewer(nk.load_nao())
            >>> viewer.close()
            >>> viewer
            <Viewer of nao_v6, not live>
        """
        bridges, self._bridges = self._bridges, []
        for bridge in bridges:
            bridge.end()
        with self._starting:
            self._server, end, self._end_server = None, self._end_server, None
            if end is not None:
                end()

    def __enter__(self) -> Viewer:
        self._started()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _repr_html_(self) -> str:
        """Return a frame with the page and the scene inside, which needs no server."""
        return frame(self.static_html())

    def _ipython_display_(self) -> None:
        """Show the page in a notebook, connected to this process if anywidget is installed."""
        from IPython import get_ipython
        from IPython.display import HTML, display

        if not hasattr(get_ipython(), "kernel"):  # a terminal
            print(repr(self))  # noqa: T201
        elif not has_bridge():
            display(HTML(self._repr_html_() + NOT_LIVE))
        else:
            bridge = bridge_of(self, self._messages, self._receive)
            self._bridges.append(bridge)
            display(HTML(frame(self.static_html(), bridge.name)), bridge.widget)

    # --- pictures ----------------------------------------------------------------------------------------------------

    def save_png(
        self,
        path: Path | str,
        *,
        camera: str | ArrayLike = "three-quarter",
        size: tuple[int, int] = (1280, 800),
        timeout: float = 60.0,
        overwrite: bool = False,
    ) -> Path:
        """Write a picture of the scene, drawn by a headless Chromium or Chrome.

        The browser starts with the program's first picture, which takes seconds, and ends with the program.

        Args:
            path: the file; it ends in .png or has no suffix.
            camera: one of `camera_names`, or the pose of a camera in the world, shape (4, 4), as `camera_pose`; or a
                camera of the robot, such as "CameraTop": the picture is what it sees, with its vertical field of view,
                without distortion.
            size: width and height in pixels, 16 to 8192.
            timeout: seconds to wait for the browser.
            overwrite: replace an existing file.

        Returns:
            The file.

        Raises:
            NoBrowser: there is no browser, or it sends no picture in time.
            BadArgument: the file exists or cannot be written, or has another suffix.
        """
        view = self._view_from(camera)
        atomic.check_writable(path, kind="png")
        atomic.check_replaceable(path, overwrite=flag(overwrite, "overwrite"))
        self._streams.flush()
        atomic.write_bytes(
            path, pictures.draw(self._messages, "capture", {"camera": view}, size, overlays.seconds(timeout))
        )
        return Path(path)

    def save_video(
        self,
        path: Path | str,
        *,
        fps: float = 30.0,
        camera: str | ArrayLike = "three-quarter",
        size: tuple[int, int] = (1280, 800),
        progress: Callable[[int, int], object] | None = None,
        timeout: float = 60.0,
        overwrite: bool = False,
    ) -> Path:
        """Write the clip of `animate` as a video, every picture of it drawn at its own time, in the best quality.

        The pictures show the times 0, 1/fps, 2/fps, … and the end of the clip; one second at 30 fps has 31 of them. The
        camera follows a robot that walks away.

        Args:
            path: the file. It ends in .webm or has no suffix for WebM (VP9 or VP8), or in .zip for a ZIP file of the
                pictures as PNG files, 00000.png and so on.
            fps: pictures per second, above 0 to 240.
            camera: as in `save_png`; a named one sees the whole robot at the beginning of the clip.
            size: as in `save_png`.
            progress: called after each picture with the number of pictures drawn and that of all. If it raises an
                exception, the work ends, and nothing is written.
            timeout: seconds to wait for the browser, and then for each picture.
            overwrite: replace an existing file.

        Returns:
            The file.

        Raises:
            NoBrowser: there is no browser, it sends no picture in time, or it cannot encode video of this size; or the
                video has more than 65 535 pictures or 1 GB.
            BadArgument: the viewer has no clip, the file exists or cannot be written, or it has another suffix.
        """
        view, rate = self._view_from(camera), overlays.positive(fps, "fps", _MAX_FPS)
        atomic.check_writable(path, kind="video")
        atomic.check_replaceable(path, overwrite=flag(overwrite, "overwrite"))
        if self._messages.get("clip") in (None, BLANKS["clip"]):
            raise BadArgument("the viewer has no clip to film; call animate first")
        self._streams.flush()
        form = "zip" if Path(path).suffix.lower() == ".zip" else "webm"
        request = {"camera": view, "fps": rate, "form": form}
        film = pictures.draw(self._messages, "film", request, size, overlays.seconds(timeout), progress)
        atomic.write_bytes(path, zipped(film) if form == "zip" else film)
        return Path(path)

    def _view_from(self, camera: str | ArrayLike) -> str | list[float]:
        """Return a camera's name or pose for the page, or raise if there is no such camera."""
        if isinstance(camera, str):
            return choice(camera, (*self.camera_names, *self.robot.semantics.cameras), "camera")
        return by_columns(checked_pose(camera))

    # --- the file ---------------------------------------------------------------------------------------------------

    def static_html(self) -> str:
        """Return the page with the scene inside: it needs no server and no network.

        Examples:
            >>> viewer = nk.Viewer(nk.load_nao())
            >>> viewer.static_html().startswith("<!DOCTYPE html>")
            True
        """
        self._send_known_hulls()
        return static_page(self.robot.name, self._streams.saved())

    def save_html(self, path: Path | str, *, overwrite: bool = False) -> Path:
        """Write `static_html` to a file, completely or not at all.

        Args:
            path: the file; it ends in .html or .htm, or has no suffix.
            overwrite: replace an existing file.

        Raises:
            BadArgument: the file exists or cannot be written, or has another suffix.

        Examples:
            >>> viewer = nk.Viewer(nk.load_nao())
            >>> viewer.save_html("nao.html").stat().st_size > 1_000_000
            True
        """
        atomic.check_writable(path, kind="html")
        atomic.check_replaceable(path, overwrite=flag(overwrite, "overwrite"))
        atomic.write_text(path, self.static_html())
        return Path(path)

    # --- inside ---------------------------------------------------------------------------------------------------

    def _started(self) -> LiveServer:
        with self._starting:
            if self._server is None:
                self._server = LiveServer(
                    self._messages,
                    Document(live_page(self.robot.name), policy()),
                    host=self.host,
                    port=self._port,
                    # The server must not keep the viewer alive: it ends with the viewer.
                    on_answer=weak_receiver(self._receive),
                    allow_hosts=self._allow_hosts,
                    token=self._token,
                )
                self._end_server = weakref.finalize(self, self._server.close)
            return self._server

    def _receive(self, answer: Answer) -> None:
        """Process a message of a page; runs in the server's thread."""
        if answer.get("kind") == "ready":
            # Not before, and not in the server's thread: the first picture must not wait for it.
            threading.Thread(target=self._send_known_hulls, name="nao_kin viewer hulls", daemon=True).start()
        elif answer.get("kind") == "shown":
            self._buttons.receive(answer.get("shown"), _source_of(answer))
        elif answer.get("kind") == "target":
            self._targets.receive(answer.get("name"), answer.get("matrix"), _source_of(answer))
        elif answer.get("kind") == "held":
            self._targets.hold(answer.get("name"), answer.get("held"))
        elif answer.get("kind") == "control":
            self._controls.receive(answer.get("name"), answer.get("value"), _source_of(answer))
        elif answer.get("kind") == "camera":
            with suppress(NaoKinError, ValueError):
                self._camera_pose = pose_of_page(answer.get("pose", ()))
        elif answer.get("kind") in ("joints", "clip", "played"):
            self._receive_configuration(answer, _source_of(answer))

    def _receive_configuration(self, answer: Answer, source: str) -> None:
        """Process the configuration that a page reports: set by a user, or of a clip of the program or the page."""
        try:
            q = overlays.one_configuration(self.robot, answer.get("q", ()))
            up = None if answer.get("up") is None else overlays.direction(answer["up"], "up")
        except NaoKinError:
            return
        page = source.partition(" ")[0]
        with self._lock:
            if answer["kind"] == "joints":
                self._lead.take(page)
            elif not self._lead.admits(page, begins=answer.get("begins") is True):
                return
            before = self._q
            if answer["kind"] == "clip":
                self._note(q)  # all pages have the program's clip
            else:
                self._show_joints(q, up, source)
            if answer["kind"] == "joints" or not np.array_equal(before, q):
                first = self.robot.nq_base
                moved = itertools.compress(self.robot.joint_names, before[first:] != q[first:])
                self._changes.tell(q, tuple(moved))

    def _add(self, name: str, shape: str, frame: str | None, content: Mapping[str, object]) -> None:
        if frame is not None:
            choice(frame, self.robot.frame_names, "frame")
        known = {"name": overlays.checked_name(name), "shape": shape, "frame": frame}
        with self._lock:
            self._shapes.put(name, panel_message("extra", {**known, **content}))

    def _show_joints(self, q: Floats, up: list[float] | None, source: str = "") -> None:
        # A page's change comes after the clip that it stops: pages that open later have the clip, but do not play it.
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

    def __repr__(self) -> str:
        # Without the token, because printed text is logged and shared.
        where = f"live at {self._server.address}" if self._server is not None else "not live"
        return f"<Viewer of {self.robot.name}, {where}>"


def _source_of(answer: Answer) -> str:
    """Return the name that the sending page gives itself, as text that can be sent on."""
    source = answer.get("source")
    return source[:_MAX_SOURCE].encode("utf-8", "replace").decode("utf-8") if isinstance(source, str) else ""
