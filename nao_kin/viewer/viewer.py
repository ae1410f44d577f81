"""The robot in a browser: live, as one file, or as a picture."""

from __future__ import annotations

import html
import math
import weakref
import webbrowser
from collections.abc import Iterable, Mapping
from pathlib import Path
from types import TracebackType

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._common import atomic
from nao_kin._common.arrays import Floats
from nao_kin._common.warn import warn_caller
from nao_kin.errors import BadArgument, NaoKinError, NaoKinWarning, NoBrowser, UnknownName, WrongShape
from nao_kin.motion import HOLD, Hips, Motion
from nao_kin.reach import ReachMap
from nao_kin.robot import RobotModel
from nao_kin.viewer import overlays
from nao_kin.viewer.browser import Screenshots
from nao_kin.viewer.description import describe, presets_of
from nao_kin.viewer.lights import GROUPS
from nao_kin.viewer.messages import RetainedMessages, panel_message, set_animation, typed_array
from nao_kin.viewer.page import live_page, static_page
from nao_kin.viewer.scene import ROBOT, carriers, link_paths, robot_drawables, scene_messages
from nao_kin.viewer.server import Answer, LiveServer

# A browser asked for an address that stands for all addresses would not know where to go.
_HERE = {"": "127.0.0.1", "0.0.0.0": "127.0.0.1", "::": "::1"}


class OutsideLimitsWarning(NaoKinWarning):
    """A configuration on show has joints outside their limits, and not because nobody moved them from zero."""


class Viewer:
    """A robot on show in a web page, with a panel of joint sliders, postures and read-outs.

    The page is meshcat's viewer and a panel beside it. The browser composes the transforms of the robot's links, so
    that a configuration is all that is sent. The server runs inside this process, from the first time the address is
    asked for until `close`; as a context manager a viewer closes itself:

        with nk.Viewer(nao) as viewer:
            print(viewer.url)
            viewer.display(q)

    Args:
        robot: any robot.
        host: the address to listen on; "127.0.0.1" lets nobody else in.
        port: the port to listen on; None for the first free one from 7000.

    Attributes:
        robot: the robot on show.
        notes: what of its looks cannot be shown, one line each.
        camera_names: names that `camera` takes.
        light_names: names that `show_lights` takes; none for a robot without lights.

    Raises:
        BadModel: the robot's URDF can no longer be read.
        BadArgument: no robot; and when the server starts, a port or an address that cannot be had.
    """

    def __init__(self, robot: RobotModel, *, host: str = "127.0.0.1", port: int | None = None) -> None:
        self._server: LiveServer | None = None
        if not isinstance(robot, RobotModel):
            raise BadArgument(f"a viewer shows a robot model, got {type(robot).__name__}")
        tree = robot.tree
        drawables, self.notes = robot_drawables(tree)
        self._presets = presets = presets_of(robot)
        self.robot, self.host, self._port = robot, host, port
        self.camera_names = tuple(presets.cameras)
        self._links = {name: index for index, name in enumerate(link_paths(tree))}
        self._carriers = carriers(tree, drawables)
        names = tuple(drawable.light for drawable in drawables if drawable.light)
        self._lights = {group: parts for group, parts in GROUPS.items() if set(parts) <= set(names)}
        self.light_names = (*self._lights, *names)
        self._warned: set[str] = set()
        self._screenshots = Screenshots()
        self._messages = RetainedMessages()
        for key, message in scene_messages(robot, tree, drawables):
            self._messages.put(key, message)
        about = describe(robot, tree, presets, self.notes, drawables)
        self._messages.put("robot", panel_message("robot", {"about": about}))
        self._show_joints(presets.start, None)

    # --- the configuration ----------------------------------------------------------------------------------------

    @property
    def q(self) -> Floats:
        """The configuration on show, shape (nq,): the one last displayed, or moved to in the page."""
        return np.array(self._q)

    def display(self, q: ArrayLike, *, up: ArrayLike | None = None) -> None:
        """Show a configuration.

        A joint outside its limits is shown where it is, marked red, and warned of once (`OutsideLimitsWarning`) unless
        it is at zero, where nobody moved it: the neutral configuration of some robots, NAO's too, is not inside.

        Args:
            q: one configuration, shape (nq,).
            up: for a robot with a fixed base, the vertical in the root's frame, as an accelerometer at rest gives it,
                shape (3,): (−1, 0, 0) lies on its belly. None lets the robot stand, sit or lie by itself: on its soles
                where it is balanced on them, else as the nearest of its postures rests.

        Raises:
            WrongShape, NotFinite, BadArgument, ZeroNorm: q is no configuration, or `up` no direction.
        """
        array = overlays.one_configuration(self.robot, q)
        vertical = None if up is None else overlays.direction(up, "up")
        self._warn(array)
        if self._messages.get("clip") is not None:
            self._messages.put("clip", panel_message("still", {}))
        self._show_joints(array, vertical)

    def rest(self, posture: str) -> tuple[float, float, float] | None:
        """The vertical in the root's frame where the robot rests in a posture; None if it stands on its soles.

        What is displayed comes to rest so by itself; this is for what asks for it elsewhere, such as an `up`.

        Raises:
            UnknownName: no such posture.
        """
        if posture not in self._presets.postures:
            raise UnknownName("posture", posture, tuple(self._presets.postures))
        return self._presets.rest.get(posture)

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
        """
        if isinstance(qs, Motion):
            qs = qs.configurations(self.robot, rate=overlays.number(fps, "fps"), fill=fill, hips=hips).q
        self.robot.angles(qs)  # refuses all that is no configuration
        array = np.array(qs, dtype=np.float64)
        if array.ndim != 2 or len(array) == 0:
            raise WrongShape("qs", f"(n, {self.robot.nq}) with n ≥ 1", array.shape)
        rate = overlays.number(fps, "fps")
        if rate <= 0.0:
            raise BadArgument(f"fps must be positive, got {rate:g}")
        ups = None if up is None else overlays.directions(up, "up", len(array))
        self._warn(array)
        self._show_joints(array[0], None if ups is None else ups[0].tolist())
        repetitions = math.inf if loop else 1.0
        self._messages.put("clip", set_animation(ROBOT, array, rate, play=play, repetitions=repetitions, ups=ups))

    # --- what is drawn over it ------------------------------------------------------------------------------------

    def show_frames(self, names: Iterable[str], *, size: float | None = None) -> None:
        """Draw frames as triads, x red, y green, z blue, with their names; none for none.

        Args:
            names: frame names.
            size: length of the arrows [m]; None for a length that suits the robot.

        Raises:
            UnknownName: no such frame.
            BadArgument: no names, or a size that is not positive.
        """
        self._messages.put("frames", overlays.frames(self.robot, names, size))

    def show_joint_axes(self, on: bool = True) -> None:
        """Draw the joint axes as screws, turning or sliding.

        Their colour is that of the joint they belong to, as `nao_kin.joints.group_joints` finds it: revolute,
        prismatic, universal, spherical …
        """
        self._show("axes", on)

    def show_com(self, on: bool = True) -> None:
        """Draw the centre of mass and its projection onto the floor."""
        self._show("com", on)

    def show_support_polygon(self, on: bool = True) -> None:
        """Draw the convex hull of what touches the floor: green while the centre of mass is above it, red otherwise."""
        self._show("support", on)

    def show_ghost(self, q: ArrayLike | None) -> None:
        """Draw a second, pale robot in another configuration, shape (nq,); None removes it.

        Raises:
            WrongShape, NotFinite, BadArgument: q is no configuration.
        """
        self._messages.put("ghost", overlays.ghost(self.robot, q))

    def show_ghosts(self, configurations: ArrayLike, *, opacity: float = 0.3, first: int = 1) -> None:
        """Draw the links that other configurations put elsewhere, in one pale colour for each, instead of those before.

            found = nk.ik.leg(nao, "L", T_torso_foot, reference=q, limits="ignore")
            viewer.display(found.q)
            viewer.show_ghosts(found.solutions[1:], first=2)

        Links that are where the robot has them are not drawn twice. The legend of the page numbers the rows. They
        belong to the configuration shown: a limb that is dragged in a page removes them from that page.

        Args:
            configurations: shape (k, nq), k up to 64; none for none.
            opacity: of the links, above 0 and at most 1.
            first: number of the first row in the legend, at least 0; 2 where the robot itself is solution 1.

        Raises:
            WrongShape, NotFinite, BadArgument: no configurations, too many of them, no opacity or no such number.
        """
        self._messages.put("ghosts", overlays.ghosts(self.robot, configurations, opacity, first))

    def clear_ghosts(self) -> None:
        """Remove what `show_ghosts` has drawn."""
        self.show_ghosts(np.zeros((0, self.robot.nq)))

    def show_targets(self, targets: Mapping[str, ArrayLike]) -> None:
        """Mark points or poses in the robot's root frame, under any names; an empty mapping removes them.

        Args:
            targets: name → position, shape (3,) [m], or pose, shape (4, 4).

        Raises:
            WrongShape, NotFinite, NotARotation, BadArgument: no position and no pose.
        """
        self._messages.put("targets", overlays.targets(targets))

    def color_links(
        self, values: Mapping[str, float], *, low: float | None = None, high: float | None = None, label: str = ""
    ) -> None:
        """Colour links by a number each, cold to warm, with a legend; an empty mapping gives them their own back.

        A link without a shape colours the one it is fixed to, unless that is named too.

        Args:
            values: link name → number.
            low: the number at the cold end; None for the smallest.
            high: the number at the warm end; None for the largest.
            label: what the numbers are.

        Raises:
            UnknownName: no such link.
            NotFinite, BadArgument: no numbers, or no scale from low to high.
        """
        self._messages.put("colours", overlays.colours(self._links, self._carriers, values, low, high, label))

    def show_reach(self, reach: ReachMap | None, *, by: str = "best", cut: tuple[str, float] | None = None) -> None:
        """Draw a reach map as coloured voxels, with a slider that cuts them along an axis; None removes it.

        Where there are more than 40 000 voxels, coarser ones are drawn.

        Args:
            reach: a map of this robot.
            by: what colours them: "best", "mean" (manipulability), "count" or "coverage".
            cut: axis, "x", "y" or "z", and place of the cut in the map's reference frame [m]; what is beyond is not
                drawn. None for the middle along x.

        Raises:
            UnknownName: no such number.
            BadArgument, NotFinite, WrongShape: no map, one of another robot or an empty one; no cut.
        """
        self._messages.put("reach", overlays.reach(self.robot, reach, by, cut))

    def show_lights(self, colours: Mapping[str, ArrayLike]) -> None:
        """Light the robot in colours, instead of those before; lights that are not named have their own look.

            viewer.show_lights({"LeftEye": (0, 1, 0), "RightEye": (0, 1, 0), "RightEye0": (1, 0, 0)})

        A NAO has Chest, LeftFoot, RightFoot, and LeftEye0 … LeftEye7 and RightEye0 … RightEye7, counted from the top of
        each eye towards the nose; LeftEye and RightEye are all eight. Black is a light that is off. Lights are the LEDs
        of this library's own meshes: other robots have none, and for them every name is unknown.

        Args:
            colours: one of `light_names` → red, green and blue, shape (3,), each from 0 to 1; empty for none.

        Raises:
            UnknownName: no such light.
            WrongShape, NotFinite, BadArgument: no colour.
        """
        self._messages.put("lights", overlays.lights(self.light_names, self._lights, colours))

    def say(self, text: str) -> None:
        """Show a speech bubble beside the head, until another text; "" removes it.

        It stands beside the first link with "head" in its name, or beside the whole robot. Screen readers read it. More
        than 280 characters are cut off in the bubble.

        Raises:
            BadArgument: no text.
        """
        self._messages.put("speech", overlays.speech(text))

    def camera(self, name: str) -> None:
        """Look at the robot from one of `camera_names`.

        Raises:
            UnknownName: no such camera.
        """
        self._check_camera(name)
        self._messages.put("camera", panel_message("camera", {"name": name}))

    # --- the live page --------------------------------------------------------------------------------------------

    @property
    def url(self) -> str:
        """The address of the live page; asking for it starts the server.

        Raises:
            BadArgument: the port is in use, or the address cannot be had.
        """
        server = self._started()
        host = _HERE.get(server.host, server.host)
        return f"http://{f'[{host}]' if ':' in host else host}:{server.port}/"

    def open(self) -> None:
        """Open the live page in this machine's web browser.

        Raises:
            NoBrowser: there is none that Python knows of.
        """
        if not webbrowser.open(self.url):
            raise NoBrowser(f"no web browser to open {self.url} with")

    def wait(self, timeout: float | None = None) -> None:
        """Wait until a browser shows the scene.

        Args:
            timeout: seconds; None for ever.

        Raises:
            NoBrowser: none did in time, or the viewer was closed.
            BadArgument, NotFinite: a timeout that is no number.
        """
        if timeout is not None:
            timeout = overlays.number(timeout, "timeout")
        if not self._started().wait_for_page(timeout):
            raise NoBrowser("no browser opened the page" + ("" if timeout is None else f" within {timeout:g} s"))

    def close(self) -> None:
        """End the server, and with it the connection of every open page; does nothing when there is none."""
        server, self._server = self._server, None
        if server is not None:
            server.close()

    def __enter__(self) -> Viewer:
        self._started()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _repr_html_(self) -> str:
        """In a notebook: the live page while the server runs, else the page with the scene inside."""
        source = f'src="{self.url}"' if self._server is not None else f'srcdoc="{html.escape(self.static_html())}"'
        return f'<iframe {source} style="width: 100%; height: 620px; border: 0"></iframe>'

    # --- files ----------------------------------------------------------------------------------------------------

    def static_html(self) -> str:
        """The page with all that is on show inside: it needs no server and no network."""
        return static_page(self.robot.name, self._messages.messages())

    def save_html(self, path: Path | str) -> Path:
        """Write `static_html` to a file, whole or not at all.

        Returns:
            The file.

        Raises:
            BadArgument: it cannot be written.
        """
        atomic.write_text(path, self.static_html())
        return Path(path)

    def save_png(
        self,
        path: Path | str,
        *,
        camera: str = "three-quarter",
        size: tuple[int, int] = (1280, 800),
        timeout: float = 60.0,
    ) -> Path:
        """Write a picture of what is on show, drawn by a headless Chromium or Chrome.

        Args:
            path: the file; it ends in .png or has no suffix.
            camera: one of `camera_names`.
            size: width and height in pixels, 16 to 8192.
            timeout: seconds to wait for the browser.

        Returns:
            The file.

        Raises:
            UnknownName: no such camera.
            NoBrowser: there is none, or it gives no picture in time.
            BadArgument: the file cannot be written, or is named as no PNG; a size out of range; no timeout.
        """
        self._check_camera(camera)
        atomic.check_writable(path, suffix=".png")
        seconds = overlays.number(timeout, "timeout")
        running = self._server is not None
        try:
            picture = self._screenshots.picture(self._started(), self.url, camera, size, seconds)
        finally:
            if not running:
                self.close()
        atomic.write_bytes(path, picture)
        return Path(path)

    # --- inside ---------------------------------------------------------------------------------------------------

    def _started(self) -> LiveServer:
        if self._server is None:
            # The server must not keep the viewer alive: whoever drops it drops the server too.
            receiver = weakref.WeakMethod(self._receive)

            def on_answer(answer: Answer) -> None:
                receive = receiver()
                if receive is not None:
                    receive(answer)

            page = live_page(self.robot.name)
            self._server = LiveServer(self._messages, page, host=self.host, port=self._port, on_answer=on_answer)
            weakref.finalize(self, self._server.close)
        return self._server

    def _receive(self, answer: Answer) -> None:
        """Take what a page sends; runs in the server's thread."""
        if answer.get("kind") == "picture":
            self._screenshots.deliver(answer)
        elif answer.get("kind") == "joints":
            try:
                q = overlays.one_configuration(self.robot, answer.get("q", ()))
                up = None if answer.get("up") is None else overlays.direction(answer["up"], "up")
            except NaoKinError:
                return
            self._show_joints(q, up, str(answer.get("source", "")))

    def _show_joints(self, q: Floats, up: list[float] | None, source: str = "") -> None:
        self._q = q
        self._messages.put("joints", panel_message("joints", {"q": typed_array(q), "up": up, "source": source}))

    def _show(self, what: str, on: bool) -> None:
        self._messages.put(f"shown {what}", panel_message("shown", {"shown": {what: bool(on)}}))

    def _warn(self, qs: Floats) -> None:
        if qs.ndim > 1:
            qs = qs[_first_outside(self.robot, qs)]
        violations = self.robot.limit_violations(qs)
        found = dict.fromkeys(row.joint for row in violations if row.value != 0.0 or row.of_value != 0.0)
        new = [joint for joint in found if joint not in self._warned]
        self._warned.update(new)
        if new:
            warn_caller(f"outside the joint limits, shown in red: {', '.join(new)}", OutsideLimitsWarning)

    def _check_camera(self, name: str) -> None:
        if name not in self.camera_names:
            raise UnknownName("camera", name, self.camera_names)

    def __repr__(self) -> str:
        where = f"live at {self.url}" if self._server is not None else "not live"
        return f"<Viewer of {self.robot.name}, {where}>"


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
