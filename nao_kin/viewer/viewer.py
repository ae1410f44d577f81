"""The robot in a browser: live, as one file, or as a picture."""

from __future__ import annotations

import threading
import weakref
import webbrowser
from collections.abc import Callable, Iterable
from pathlib import Path
from types import TracebackType

import numpy as np

from nao_kin._core import files as atomic
from nao_kin.errors import NaoKinError, NoBrowser
from nao_kin.robot import RobotModel
from nao_kin.viewer import overlays
from nao_kin.viewer.access import POLICY, Document, checked_names, checked_token, live_page
from nao_kin.viewer.browser import Screenshots
from nao_kin.viewer.notebook import NOT_LIVE, Bridge, bridge_of, frame, has_bridge
from nao_kin.viewer.server import Answer, LiveServer, weak_receiver
from nao_kin.viewer.shown_scene import ShownScene

# A page names itself in what it sends, and is sent it back.
_MOST_OF_A_SOURCE = 64


class Viewer(ShownScene):
    """A robot on show in a web page, with a panel of joint sliders, postures and read-outs.

    The page is meshcat's viewer and a panel beside it. The browser composes the transforms of the robot's links, so
    that a configuration is all that is sent. The server runs inside this process, from the first time the address is
    asked for until `close`; as a context manager a viewer closes itself::

        with nk.Viewer(nao) as viewer:
            print(viewer.url)
            viewer.display(q)

    Args:
        robot: any robot.
        host: the address to listen on; "127.0.0.1" lets nobody else in.
        port: the port to listen on; None for the first free one from 7000.
        allow_hosts: names under which the page is asked for, beside those of this machine, its loopback names and the
            address: of a proxy before it, for one. All others get 403. "*" is every name, and needs a token.
        token: text of at least 8 letters that the page's address must carry to see and move the robot; True for a
            random one, False for none. None: a random one where the address or an allowed name is not loopback.

    Attributes:
        robot: the robot on show.
        notes: what of its looks cannot be shown, one line each.
        camera_names: names that `camera` takes.
        light_names: names that `show_lights` takes; none for a robot without lights.

    Raises:
        BadModel: the robot's URDF can no longer be read.
        BadArgument: no robot, no names, no token; and when the server starts, a port or an address that cannot be had,
            or every name is allowed without a token.

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
        self._server: LiveServer | None = None
        # Ends it. A finalizer that has run holds nothing any more; others would keep every page ever served.
        self._end_server: Callable[[], object] | None = None
        self._starting = threading.Lock()
        self._allow_hosts, self._token = checked_names(allow_hosts), checked_token(token)
        super().__init__(robot)
        self.host, self._port = host, port
        self._screenshots = Screenshots()
        self._bridges: list[Bridge] = []

    # --- the live page --------------------------------------------------------------------------------------------

    @property
    def url(self) -> str:
        """The address of the live page, with its token if it has one; asking for it starts the server.

        Raises:
            BadArgument: the port is in use, or the address cannot be had.
        """
        return self._started().url

    def open(self) -> None:
        """Open the live page in this machine's web browser.

        Raises:
            NoBrowser: there is none that Python knows of.
        """
        if not webbrowser.open(self.url):
            raise NoBrowser(f"no web browser to open {self._started().address} with")

    def wait(self, timeout: float | None = None) -> None:
        """Wait until a browser shows the scene.

        Args:
            timeout: seconds; None for ever.

        Raises:
            NoBrowser: none did in time, or the viewer was closed.
            BadArgument, NotFinite: a timeout that is no number.

        Examples:
            >>> with nk.Viewer(nk.load_nao()) as viewer:
            ...     viewer.wait(timeout=0.01)
            Traceback (most recent call last):
                ...
            nao_kin.errors.NoBrowser: no browser opened the page within 0.01 s
        """
        if timeout is not None:
            timeout = overlays.number(timeout, "timeout")
        if not self._started().wait_for_page(timeout):
            raise NoBrowser("no browser opened the page" + ("" if timeout is None else f" within {timeout:g} s"))

    def close(self) -> None:
        """End the server, and with it the connection of every open page; does nothing when there is none.

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

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _repr_html_(self) -> str:
        """For whoever shows HTML: the page with the scene inside, which needs nobody."""
        return frame(self.static_html())

    def _ipython_display_(self) -> None:
        """In a notebook: the page with the scene inside, and with anywidget what joins it to this program."""
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
            picture = self._screenshots.picture(self._started(), camera, size, seconds)
        finally:
            if not running:
                self.close()
        atomic.write_bytes(path, picture)
        return Path(path)

    # --- inside ---------------------------------------------------------------------------------------------------

    def _started(self) -> LiveServer:
        with self._starting:
            if self._server is None:
                self._server = LiveServer(
                    self._messages,
                    Document(live_page(self.robot.name), POLICY),
                    host=self.host,
                    port=self._port,
                    # The server must not keep the viewer alive: whoever drops it drops the server too.
                    on_answer=weak_receiver(self._receive),
                    allow_hosts=self._allow_hosts,
                    token=self._token,
                )
                self._end_server = weakref.finalize(self, self._server.close)
            return self._server

    def _receive(self, answer: Answer) -> None:
        """Take what a page sends; runs in the server's thread."""
        if answer.get("kind") == "picture":
            self._screenshots.deliver(answer)
        elif answer.get("kind") == "shown":
            self._receive_shown(answer, _source_of(answer))
        elif answer.get("kind") in ("joints", "clip", "played"):
            self._receive_configuration(answer, _source_of(answer))

    def _receive_configuration(self, answer: Answer, source: str) -> None:
        """Take where a page has the robot: somebody moved it, or it plays the program's clip, or one of its own."""
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
                self._changes.tell(q, self._changed(before, q))

    def __repr__(self) -> str:
        # Not the token, for what is printed is logged and shared.
        where = f"live at {self._server.address}" if self._server is not None else "not live"
        return f"<Viewer of {self.robot.name}, {where}>"


def _source_of(answer: Answer) -> str:
    """What the page that sends this calls itself, as text that can be sent on."""
    source = answer.get("source")
    return source[:_MOST_OF_A_SOURCE].encode("utf-8", "replace").decode("utf-8") if isinstance(source, str) else ""
