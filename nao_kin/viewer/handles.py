"""The results of a viewer's methods: additional robots, and recordings."""

from __future__ import annotations

import threading
import time
from collections import defaultdict, deque
from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import Floats, as_floats
from nao_kin.errors import BadArgument, WrongShape
from nao_kin.joints import MultiDofModel
from nao_kin.motion import Motion
from nao_kin.robot import RobotModel
from nao_kin.viewer import overlays
from nao_kin.viewer.description import SceneRobot
from nao_kin.viewer.messages import RetainedMessages, packed, panel_message, set_transform, typed_array
from nao_kin.viewer.panels import MAX_POINTS
from nao_kin.viewer.shown_scene import checked_pose


class ShownRobot:
    """An additional robot in the scene, made by `Viewer.add_robot`.

    It is placed on its ground by the same rule as the viewer's own robot. A typed model is shown with the links of the
    robot that it was made from.

    Attributes:
        name: its name in the page.
        robot: the robot, or the typed model.
        notes: shapes that cannot be shown, one line each.
        T_world_ground: pose of its ground, shape (4, 4); the viewer's own robot stands on that of the world.

    Examples:
        >>> nao = nk.load_nao()
        >>> other = nk.Viewer(nao).add_robot(nao, name="second")
        >>> isinstance(other, nk.viewer.ShownRobot)
        True
    """

    def __init__(
        self,
        messages: RetainedMessages,
        look: SceneRobot,
        robot: RobotModel | MultiDofModel,
        name: str,
        forget: Callable[[SceneRobot], None],
    ) -> None:
        self.name, self.robot = name, robot
        self._typed = robot if isinstance(robot, MultiDofModel) else None
        self._messages, self._look, self._forget, self._shown = messages, look, forget, True
        self.notes = look.notes
        self.T_world_ground = np.eye(4)
        self._show(look.start, None)

    @property
    def q(self) -> Floats:
        """The displayed configuration, shape (nq,), of the robot or of the typed model."""
        return np.array(self._q) if self._typed is None else self._typed.from_q(self._q)

    def display(self, q: ArrayLike, *, up: ArrayLike | None = None) -> None:
        """Show a configuration, as `Viewer.display` does.

        Args:
            q: one configuration, shape (nq,); a typed one for a typed model.
            up: the vertical in the root's frame, shape (3,); None to compute it as in `Viewer.display`.

        Raises:
            DisagreeingJoints: a typed configuration in which joints of one motor disagree.
            BadArgument: the robot was removed.

        Examples:
            >>> nao = nk.load_nao()
            >>> other = nk.Viewer(nao).add_robot(nao, name="second")
            >>> other.display(nao.posture("Sit"))
        """
        self._check_shown()
        if self._typed is not None:
            if np.ndim(q) != 1:
                raise WrongShape("q", f"({self._typed.nq},)", np.shape(q))
            q = self._typed.to_q(q, near=self._q)
        array = overlays.one_configuration(self._look.robot, q)
        self._show(array, None if up is None else overlays.direction(up, "up"))

    def place(self, T: ArrayLike) -> None:
        """Move the ground on which the robot stands.

        Args:
            T: pose of the ground in the world, shape (4, 4); the identity is the ground of the viewer's own robot.

        Raises:
            NotARotation: T is not a pose.
            BadArgument: the robot was removed.

        Examples:
            >>> nao = nk.load_nao()
            >>> other = nk.Viewer(nao).add_robot(nao, name="second")
            >>> other.place(nk.screws.pose(np.eye(3), [0.0, 0.5, 0.0]))
        """
        self._check_shown()
        self.T_world_ground = checked_pose(T)
        command = set_transform(self._look.ground.rstrip("/"), self.T_world_ground)
        self._messages.put(f"{self._look.key}place", packed(command))

    def color_links(
        self, values: Mapping[str, float], *, low: float | None = None, high: float | None = None, label: str = ""
    ) -> None:
        """Colour its links by numbers, as `Viewer.color_links` does; the page's legend belongs to the last colours.

        Examples:
            >>> nao = nk.load_nao()
            >>> other = nk.Viewer(nao).add_robot(nao, name="second")
            >>> other.color_links({"Head": 0.2, "torso": 0.8}, label="load")
        """
        self._check_shown()
        self._messages.put(*self._look.colours(values, low, high, label))

    def remove(self) -> None:
        """Remove the robot from the scene; does nothing the second time.

        Examples:
            >>> nao = nk.load_nao()
            >>> other = nk.Viewer(nao).add_robot(nao, name="second")
            >>> other.remove()
        """
        if self._shown:
            self._shown = False
            self._messages.drop(self._look.key)
            self._forget(self._look)

    def _show(self, q: Floats, up: list[float] | None) -> None:
        self._q = q
        message = panel_message("robot_joints", {"robot": self._look.number, "q": typed_array(q), "up": up})
        self._messages.put(f"{self._look.key}joints", message)

    def _check_shown(self) -> None:
        if not self._shown:
            raise BadArgument(f"{self.name} was removed from the viewer")

    def __repr__(self) -> str:
        return f"<ShownRobot {self.name}{'' if self._shown else ', removed'}>"


# --- Recordings.


# The number of configurations, some 30 MB for a NAO, at which a recording is thinned out.
_MAX_ROWS = 120_000


class Recording:
    """The configurations that a viewer shows in a `with` block.

    Attributes:
        robot: the robot that moves.
        fps: configurations recorded per second, at most. When there are 120 000, about an hour at 30, they are thinned
            out and this rate is halved, so that longer recordings need no more memory.

    Examples:
        >>> nao = nk.load_nao()
        >>> recording = nk.viewer.Recording(nao, nao.neutral(), fps=30.0)
    """

    def __init__(self, robot: RobotModel, q: Floats, fps: float) -> None:
        self.robot, self.fps = robot, fps
        self._begin = time.monotonic()
        self._end: float | None = None
        self._times, self._rows = [0.0], [np.array(as_floats(q, (), "q"))]
        self._plots: dict[tuple[str, str], deque[tuple[float, float]]] = defaultdict(lambda: deque(maxlen=MAX_POINTS))
        self._lock = threading.Lock()

    @property
    def times(self) -> Floats:
        """Times at which the configurations were shown, from 0, shape (n,) [s]."""
        with self._lock:
            return np.array(self._times)

    @property
    def q(self) -> Floats:
        """The configurations, shape (n, nq)."""
        with self._lock:
            return np.array(self._rows)

    @property
    def motion(self) -> Motion:
        """The joints as a motion, linear between the configurations; a floating base is only in `q`."""
        with self._lock:
            times, rows = np.array(self._times), np.array(self._rows)
        names = self.robot.joint_names
        return Motion(times, names, rows[:, rows.shape[1] - len(names) :])

    @property
    def plots(self) -> Mapping[tuple[str, str], Floats]:
        """The points of `Viewer.plot`: plot and line → times and values, shape (n, 2); the newest 100 000 each."""
        with self._lock:
            return {key: np.array(points) for key, points in self._plots.items()}

    def note(self, name: str, values: Mapping[str, float]) -> None:
        """Record one point for each line of a plot, line → value, at the current time.

        Examples:
            >>> nao = nk.load_nao()
            >>> recording = nk.viewer.Recording(nao, nao.neutral(), fps=30.0)
            >>> recording.note("battery", {"charge": 0.8})
            >>> recording.plots["battery", "charge"].shape
            (1, 2)
        """
        with self._lock:
            if self._end is None:
                now = time.monotonic() - self._begin
                for line, value in values.items():
                    self._plots[name, line].append((now, value))

    def show(self, q: Floats) -> None:
        """Record that q is shown from now on.

        Examples:
            >>> nao = nk.load_nao()
            >>> recording = nk.viewer.Recording(nao, nao.neutral(), fps=30.0)
            >>> recording.show(nao.posture("Stand"))
        """
        q = self.robot.checked(q).copy()
        with self._lock:
            if self._end is None:
                self._note(time.monotonic() - self._begin, q)

    def finish(self) -> None:
        """Record that the last configuration was shown until now, and stop; does nothing the second time.

        Examples:
            >>> nao = nk.load_nao()
            >>> recording = nk.viewer.Recording(nao, nao.neutral(), fps=30.0)
            >>> recording.finish()
        """
        with self._lock:
            if self._end is None:
                self._end = time.monotonic() - self._begin
                if self._end > self._times[-1]:
                    self._times.append(self._end)
                    self._rows.append(self._rows[-1])

    def _note(self, now: float, q: Floats) -> None:
        step = 1.0 / self.fps
        last = self._times[-1]
        if now - last > 2.0 * step:  # the last configuration was shown until now
            self._times.append(now - step)
            self._rows.append(self._rows[-1])
        elif now - last < step and len(self._times) > 1:
            self._rows[-1] = q
            return
        if now <= self._times[-1]:  # the clock did not tick
            self._rows[-1] = q
            return
        self._times.append(now)
        self._rows.append(q)
        if len(self._times) >= _MAX_ROWS:
            self._thin_out()

    def _thin_out(self) -> None:
        """Halve the rate until a quarter of the rows is free; pauses in the movement keep their duration."""
        while len(self._times) > 0.75 * _MAX_ROWS:
            self.fps /= 2.0
            # The margin is for rounding: steps of equal length differ in their last digits.
            longest = 1.01 / self.fps
            indices = [0]
            for index in range(1, len(self._times) - 1):
                if self._times[index + 1] - self._times[indices[-1]] > longest:
                    indices.append(index)
            indices.append(len(self._times) - 1)
            self._times, self._rows = [self._times[i] for i in indices], [self._rows[i] for i in indices]
