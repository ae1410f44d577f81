"""A robot in a meshcat scene."""

from __future__ import annotations

import math
from collections.abc import Iterable
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import Floats, flag
from nao_kin._core.text import quoted
from nao_kin.errors import BadArgument
from nao_kin.motion import Motion
from nao_kin.robot import RobotModel
from nao_kin.robot.urdf import Cylinder, Origin, UrdfJoint
from nao_kin.viewer import overlays
from nao_kin.viewer.description import ROBOT, SceneRobot, drivers_of, numbered
from nao_kin.viewer.messages import Command, node_name, packed, set_animation, set_object, set_transform, track

# The arrows of a frame: rpy of the cylinder's axis z, and colour.
_ARROWS = {
    "x": ((0.0, math.pi / 2.0, 0.0), (0.9, 0.15, 0.15, 1.0)),
    "y": ((-math.pi / 2.0, 0.0, 0.0), (0.1, 0.65, 0.2, 1.0)),
    "z": ((0.0, 0.0, 0.0), (0.15, 0.35, 0.95, 1.0)),
}
_SLENDERNESS = 30.0  # length of an arrow : its radius
# A browser rotates the shorter way from key to key; keys closer together than this avoid half turns.
_LARGEST_STEP = math.pi / 2.0


class MeshcatRobot:
    """Draw a robot into a meshcat scene.

    The scene is any `meshcat.Visualizer`: your own, the `viewer` of Pinocchio's `MeshcatVisualizer`, a notebook's, or
    one of a server on another machine. Every moving joint is a node of the scene, so that the browser composes the
    poses, and a configuration costs one command for each joint that moved.

    The root link is at the origin of the node `path`. Move it with meshcat's `visualizer[path].set_transform(T)`: for a
    robot with a fixed base that stands on its left sole, T is `robot.fk(q, robot.tree.root, reference="LLeg")`. A
    floating base is placed in that node by its configuration.

    Args:
        robot: any robot, with the current placements of `robot.model`.
        visualizer: a `meshcat.Visualizer`.
        path: name of the node to draw into, below the visualizer's own. A robot that this class has drawn there is
            replaced.

    Attributes:
        robot: the robot.
        path: the node, from the root of the scene.
        notes: shapes that cannot be shown, one line each.

    Examples:
        >>> import meshcat  # doctest: +SKIP
        >>> nao = nk.load_nao()  # doctest: +SKIP
        >>> shown = nk.viewer.MeshcatRobot(nao, meshcat.Visualizer())  # doctest: +SKIP
    """

    def __init__(self, robot: RobotModel, visualizer: Any, path: str = "nao") -> None:
        self.robot, self._window = robot, visualizer.window
        self.path = _path_of(visualizer, path)
        self._look = look = SceneRobot(robot)
        drivers, under, self.notes = drivers_of(robot), f"{self.path}/", look.notes
        self._paths = {link: f"{under}{path}" for link, path in look.paths.items()}
        # Each moving joint, its driver, and the path of the node that it moves.
        self._joints = [(joint, drivers[joint.name], self._paths[joint.child]) for joint in robot.tree.moving_joints]
        # Path of a node → the values sent last: of a joint, or of the base.
        self._sent: dict[str, tuple[float, ...]] = {}
        self._frames: list[str] = []
        self._plays = self._deleted = False
        self._send({"type": "delete", "path": f"{under}{ROBOT}"})
        for node, T in look.placements():
            self._send(set_transform(f"{under}{node}", T))
        for index, drawable in numbered(look.drawables):
            node = f"{self._paths[drawable.link]}/visual:{index}"
            self._send(set_object(node, drawable.shape, drawable.rgba))
            self._send(set_transform(node, drawable.T_link_shape))
        self.display(look.start)

    def display(self, q: ArrayLike) -> None:
        """Show a configuration; ends a clip of `animate`.

        Args:
            q: one configuration, shape (nq,). Joints outside their limits are shown at their values.

        Raises:
            BadArgument: the robot was deleted.

        Examples:
            >>> shown.display(nao.posture("Crouch"))  # doctest: +SKIP
        """
        self._check_shown()
        array = overlays.one_configuration(self.robot, q)
        self._stop()
        if self.robot.base == "floating":
            root = self._paths[self.robot.tree.root]
            if self._is_new(root, tuple(array[:7].tolist())):
                self._send(set_transform(root, self.robot.fk(array, self.robot.tree.root)))
        for joint, driver, path in self._joints:
            value = float(driver.values(array))
            if self._is_new(path, (value,)):
                self._send(set_transform(path, joint.travel(value)))

    def animate(
        self,
        qs: ArrayLike | Motion,
        fps: float = 30.0,
        *,
        play: bool = True,
        loop: bool = True,
        missing: str | ArrayLike = "hold",
    ) -> None:
        """Send a clip of configurations to meshcat, whose controls play, pause and scrub it.

        Between two configurations every joint moves at constant speed. Meshcat has one clip in the whole scene: the new
        clip replaces an existing one.

        Args:
            qs: configurations, shape (n, nq) with n ≥ 1; or a motion, which is sampled and plays at its own speed.
            fps: configurations per second.
            play: start immediately.
            loop: repeat the clip.
            missing: values of the joints that a motion does not name, as in `Motion.configurations`.

        Raises:
            BadArgument: the robot was deleted.

        Examples:
            >>> shown.animate(np.linspace(nao.posture("Stand"), nao.posture("Crouch"), 30))  # doctest: +SKIP
        """
        self._check_shown()
        array, rate = overlays.clip(self.robot, qs, fps, missing)
        play, loop = flag(play, "play"), flag(loop, "loop")
        self.display(array[0])
        clips = {
            path: [_joint_track(joint, values)]
            for joint, driver, path in self._joints
            if np.ptp(values := driver.values(array)) > 0.0
        }
        if self.robot.base == "floating":
            # three.js has quaternions in Pinocchio's order, x, y, z, w.
            base = [track("position", "vector3", array[:, :3]), track("quaternion", "quaternion", array[:, 3:7])]
            clips[self._paths[self.robot.tree.root]] = base
        self._send(set_animation(clips, rate, play=play, loop=loop))
        self._plays = True

    def show_frames(self, names: Iterable[str], *, size: float = 0.05) -> None:
        """Draw frames as triads, x red, y green, z blue, instead of the previous ones; they move with the robot.

        Args:
            names: frame names; empty to remove all.
            size: length of the arrows [m].

        Examples:
            >>> shown.show_frames(["LArm", "CameraTop"])  # doctest: +SKIP
        """
        self._check_shown()
        chosen, length = overlays.frame_names(self.robot, names), overlays.positive(size, "size")
        while self._frames:
            self._send({"type": "delete", "path": self._frames.pop()})
        for name in dict.fromkeys(chosen):
            node = f"{self._paths[self._look.link_of(name)]}/{node_name('frame', name)}"
            self._frames.append(node)
            for axis, (rpy, rgba) in _ARROWS.items():
                path, T = f"{node}/{axis}", Origin(rpy=rpy).matrix
                T[:3, 3] = T[:3, 2] * length / 2.0
                self._send(set_object(path, Cylinder(length / _SLENDERNESS, length), rgba))
                self._send(set_transform(path, T))

    def delete(self) -> None:
        """Remove the robot, its frames and its clip from the scene; does nothing the second time.

        Examples:
            >>> shown.delete()  # doctest: +SKIP
        """
        if not self._deleted:
            self._stop()
            self._send({"type": "delete", "path": self.path})
            self._deleted = True

    # --- inside ---------------------------------------------------------------------------------------------------

    def _is_new(self, path: str, values: tuple[float, ...]) -> bool:
        """Record the values sent to a node, and return whether they differ from the last ones."""
        before, self._sent[path] = self._sent.get(path), values
        return before != values

    def _stop(self) -> None:
        """End the clip, which would otherwise continue to move the nodes and restore their poses at its end."""
        if self._plays:
            self._send(set_animation({}, 1.0))
            self._sent.clear()
            self._plays = False

    def _send(self, command: Command) -> None:
        self._window.send(SimpleNamespace(lower=lambda: command))  # the form of meshcat's own commands

    def _check_shown(self) -> None:
        if self._deleted:
            raise BadArgument(f"the {self.robot.name} at {self.path} was deleted from the scene")

    def __repr__(self) -> str:
        return f"<MeshcatRobot of {self.robot.name} at {self.path}>"


def _path_of(visualizer: Any, path: str) -> str:
    """Return the path of a node below a visualizer's, in the form of meshcat's commands."""
    if not all(path.split("/")):
        raise BadArgument(f"path must be names separated by slashes, such as 'nao' or 'robots/nao', got {quoted(path)}")
    packed({"path": path})  # refuses what cannot be sent
    return str(visualizer[path].path.lower())


def _joint_track(joint: UrdfJoint, values: Floats) -> dict[str, Any]:
    """Return the track of a joint's node through values (n,), at the times 0, 1, … n − 1."""
    if joint.kind == "prismatic":
        return track("position", "vector3", values[:, None] * joint.axis)
    steps = max(1, math.ceil(np.abs(np.diff(values)).max() / _LARGEST_STEP))
    times = np.arange(len(values), dtype=np.float64)
    finer = np.linspace(0.0, times[-1], steps * (len(times) - 1) + 1)
    half = np.interp(finer, times, values) / 2.0
    turns = np.column_stack([np.sin(half)[:, None] * joint.axis, np.cos(half)])
    return track("quaternion", "quaternion", turns, finer)
