"""What is drawn over the robot of a viewer, and beside it."""

from __future__ import annotations

import threading
from collections.abc import Iterable, Mapping
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import choice, flag
from nao_kin._core.text import abbreviated
from nao_kin.errors import BadArgument
from nao_kin.reach import ReachMap
from nao_kin.viewer import overlays
from nao_kin.viewer.description import SceneRobot
from nao_kin.viewer.meshes import GROUPS
from nao_kin.viewer.messages import RetainedMessages, panel_message

# What the page's buttons show and hide, as it begins.
_SHOWN = {"frames": False, "axes": False, "com": False, "support": False, "ghosts": True, "handles": True}
# What a page may say of buttons at once, and how long their names may be.
_MOST_SHOWN = 64


class Drawings:
    """What is drawn over a robot, and shapes that are no part of it.

    Attributes:
        robot: the robot on show.
        light_names: names that `show_lights` takes; none for a robot without lights.
    """

    def __init__(self, look: SceneRobot) -> None:
        self.robot, self._look = look.robot, look
        names = tuple(drawable.light for drawable in look.drawables if drawable.light)
        self._lights = {group: parts for group, parts in GROUPS.items() if set(parts) <= set(names)}
        self.light_names: tuple[str, ...] = (*self._lights, *names)
        self._messages = RetainedMessages()
        # Held while what is shown and the message that says so change: a page's answers come in another thread.
        self._lock = threading.RLock()
        self._shown = dict(_SHOWN)
        self._extras: dict[str, None] = {}

    @property
    def shown(self) -> Mapping[str, bool]:
        """What the page's buttons show, by name: frames, axes, com, support, ghosts, handles and what else it has.

        A button pressed in one page is known here and to every other page.
        """
        return MappingProxyType(dict(self._shown))

    def show_frames(self, names: Iterable[str], *, size: float | None = None) -> None:
        """Draw frames as triads, x red, y green, z blue, with their names; none for none.

        Args:
            names: frame names.
            size: length of the arrows [m]; None for a length that suits the robot.

        Raises:
            UnknownName: no such frame.
            BadArgument: no names, or a size that is not positive.

        Examples:
            >>> viewer = nk.Viewer(nk.load_nao())
            >>> viewer.show_frames(["LArm", "CameraTop"])
            >>> viewer.shown["frames"]
            True
        """
        chosen = [names] if isinstance(names, str) else list(names) if isinstance(names, Iterable) else names
        self._draw("frames", overlays.frames(self.robot, chosen, size), on=bool(chosen))

    def show_joint_axes(self, on: bool = True) -> None:
        """Draw the joint axes as screws, turning or sliding.

        Their colour is that of the joint they belong to, as `nao_kin.joints.group_joints` finds it: revolute,
        prismatic, universal, spherical …

        Examples:
            >>> viewer = nk.Viewer(nk.load_nao())
            >>> viewer.show_joint_axes()
            >>> viewer.shown["axes"]
            True
        """
        self._show("axes", on)

    def show_com(self, on: bool = True) -> None:
        """Draw the centre of mass and its projection onto the floor.

        Examples:
            >>> viewer = nk.Viewer(nk.load_nao())
            >>> viewer.show_com()
            >>> viewer.shown["com"]
            True
        """
        self._show("com", on)

    def show_support_polygon(self, on: bool = True) -> None:
        """Draw the convex hull of what touches the floor: green while the centre of mass is above it, red otherwise.

        Examples:
            >>> viewer = nk.Viewer(nk.load_nao())
            >>> viewer.show_support_polygon()
            >>> viewer.shown["support"]
            True
        """
        self._show("support", on)

    def show_ghosts(self, configurations: ArrayLike, *, opacity: float = 0.3, first: int = 1) -> None:
        """Draw the links that other configurations put elsewhere, pale, instead of those before.

            viewer.show_ghosts(nao.posture("StandZero"))

            found = nk.ik.leg(nao, "L", T_torso_foot, reference=q, limits="ignore")
            viewer.display(found.q)
            viewer.show_ghosts(found.solutions[1:], first=2)

        Links that are where the robot has them are not drawn twice. One configuration by itself is one to compare with:
        it is blue, and stays until it is cleared. The rows of several have a colour each, and numbers in the legend of
        the page; they belong to the configuration shown, and a limb that is dragged in a page removes them there.

        Args:
            configurations: one, shape (nq,), or several, shape (k, nq), k up to 64; none for none.
            opacity: of the links, above 0 and at most 1.
            first: number of the first row in the legend, at least 0; 2 where the robot itself is solution 1.

        Raises:
            WrongShape, NotFinite, BadArgument: no configurations, too many of them, no opacity or no such number.

        Examples:
            >>> nao = nk.load_nao()
            >>> viewer = nk.Viewer(nao)
            >>> viewer.show_ghosts(nao.random(rng=0, n=3), opacity=0.2)
        """
        self._draw("ghosts", overlays.ghosts(self.robot, configurations, opacity, first), on=True)

    def clear_ghosts(self) -> None:
        """Remove what `show_ghosts` has drawn.

        Examples:
            >>> nao = nk.load_nao()
            >>> viewer = nk.Viewer(nao)
            >>> viewer.show_ghosts(nao.posture("Sit"))
            >>> viewer.clear_ghosts()
        """
        self.show_ghosts(np.zeros((0, self.robot.nq)))

    def show_targets(self, targets: Mapping[str, ArrayLike]) -> None:
        """Mark points or poses in the robot's root frame, under any names; an empty mapping removes them.

        Args:
            targets: name → position, shape (3,) [m], or pose, shape (4, 4).

        Raises:
            WrongShape, NotFinite, NotARotation, BadArgument: no position and no pose.

        Examples:
            >>> viewer = nk.Viewer(nk.load_nao())
            >>> viewer.show_targets({"cup": [0.2, 0.1, 0.1]})
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

        Examples:
            >>> viewer = nk.Viewer(nk.load_nao())
            >>> viewer.color_links({"Head": 0.2, "torso": 0.8}, low=0.0, high=1.0, label="load")
        """
        self._messages.put("colours", self._look.colours(values, low, high, label))

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

        Examples:
            >>> nao = nk.load_nao()
            >>> viewer = nk.Viewer(nao)
            >>> viewer.show_reach(nk.reach.workspace(nao, "LArm", 1000, voxel=0.05), by="count")
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

        Examples:
            >>> viewer = nk.Viewer(nk.load_nao())
            >>> viewer.show_lights({viewer.light_names[0]: (1.0, 0.0, 0.0)})
        """
        self._messages.put("lights", overlays.lights(self.light_names, self._lights, colours))

    def say(self, text: str) -> None:
        """Show a speech bubble beside the head, until another text; "" removes it.

        It stands beside the first link with "head" in its name, or beside the whole robot. Screen readers read it. More
        than 280 characters are cut off in the bubble.

        Raises:
            BadArgument: no text.

        Examples:
            >>> viewer = nk.Viewer(nk.load_nao())
            >>> viewer.say("Hello")
        """
        self._messages.put("speech", overlays.speech(text))

    def color_edition(self, name: str) -> None:
        """Give a NAO's shells the colour that they were sold in; for the meshes of this library, others keep theirs.

        Args:
            name: "orange", "blue", "red" or "grey"; "" for the colours of the URDF.

        Raises:
            UnknownName: no such edition.

        Examples:
            >>> viewer = nk.Viewer(nk.load_nao())
            >>> viewer.color_edition("blue")
        """
        self._messages.put("edition", overlays.edition(name))

    # --- shapes that are no part of it ----------------------------------------------------------------------------

    def add_points(
        self,
        name: str,
        points: ArrayLike,
        *,
        colors: ArrayLike | None = None,
        size: float = 0.005,
        frame: str | None = None,
    ) -> None:
        """Draw a cloud of points, instead of what bears the same name.

        Args:
            name: what `remove` calls it, 1 to 200 characters.
            points: shape (n, 3), up to two million and 10 km away [m].
            colors: red, green and blue from 0 to 1, shape (3,) for all or (n, 3) for each; None for blue.
            size: diameter of a point [m].
            frame: the frame of the robot that they are given in and move with; None for the world, x and y on the floor
                from under the robot's root, z up.

        Raises:
            WrongShape, NotFinite, BadArgument: no points, no colours, no size; too many shapes.
            UnknownName: no such frame.

        Examples:
            >>> viewer = nk.Viewer(nk.load_nao())
            >>> viewer.add_points("path", [[0.2, 0.1, 0.1], [0.2, 0.1, 0.2]], colors=[1.0, 0.0, 0.0])
        """
        self._add(name, overlays.points(self.robot, name, points, colors, size, frame))

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
        """Draw a surface of triangles, instead of what bears the same name.

        Args:
            name: what `remove` calls it, 1 to 200 characters.
            vertices: shape (n, 3) [m]; or a file that trimesh reads (STL, OBJ, PLY, GLB …), in metres.
            faces: places of the triangles' corners in `vertices`, shape (m, 3); not for a file.
            color: red, green and blue from 0 to 1, shape (3,); None for the file's own, or blue.
            opacity: above 0 and at most 1.
            frame: as in `add_points`.

        Raises:
            WrongShape, NotFinite, BadArgument: no mesh, no colour, no opacity; more than two million vertices or faces;
                a file that cannot be read; too many shapes.
            UnknownName: no such frame.

        Examples:
            >>> viewer = nk.Viewer(nk.load_nao())
            >>> viewer.add_mesh("triangle", [[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]], [[0, 1, 2]], frame="LArm")
        """
        self._add(name, overlays.mesh(self.robot, name, vertices, faces, color, opacity, frame))

    def add_line(
        self,
        name: str,
        points: ArrayLike,
        *,
        color: ArrayLike | None = None,
        width: float = 0.004,
        frame: str | None = None,
    ) -> None:
        """Draw a line through points, round like a wire, instead of what bears the same name.

        Args:
            name: what `remove` calls it, 1 to 200 characters.
            points: shape (n, 3) with n ≥ 2, up to 100 000 and 10 km away [m].
            color: red, green and blue from 0 to 1, shape (3,); None for blue.
            width: its thickness [m].
            frame: as in `add_points`.

        Raises:
            WrongShape, NotFinite, BadArgument: no points, no colour, no width; too many shapes.
            UnknownName: no such frame.

        Examples:
            >>> viewer = nk.Viewer(nk.load_nao())
            >>> viewer.add_line("path", [[0.2, 0.1, 0.1], [0.2, 0.1, 0.2]], width=0.002)
        """
        self._add(name, overlays.line(self.robot, name, points, color, width, frame))

    def remove(self, name: str) -> None:
        """Take away the points, the mesh or the line of a name.

        Raises:
            UnknownName: there is none.

        Examples:
            >>> viewer = nk.Viewer(nk.load_nao())
            >>> viewer.add_points("path", [[0.2, 0.1, 0.1]])
            >>> viewer.remove("path")
        """
        with self._lock:
            del self._extras[choice(name, self._extras, "shape")]
            self._messages.drop(_key(name))
            self._list_extras()

    # --- inside ---------------------------------------------------------------------------------------------------

    def _add(self, name: str, message: bytes) -> None:
        with self._lock:
            if name not in self._extras and len(self._extras) >= overlays.MOST:
                raise BadArgument(f"at most {overlays.MOST} shapes are drawn; remove some before {abbreviated(name)}")
            self._extras[name] = None
            self._messages.put(_key(name), message)
            self._list_extras()

    def _list_extras(self) -> None:
        """Which shapes there are: a page forgets all others, whatever it has missed."""
        self._messages.put("extras", panel_message("extras", {"names": list(self._extras)}))

    def _show(self, what: str, on: bool, source: str = "") -> None:
        message = panel_message("shown", {"shown": {what: flag(on, "on")}, "source": source})
        with self._lock:
            self._shown[what] = bool(on)
            self._messages.put(f"shown {what}", message)

    def _draw(self, what: str, message: bytes, *, on: bool) -> None:
        """Put a message that draws something and sets its button; what that one said before is out of date."""
        with self._lock:
            self._messages.put(what, message)
            self._shown[what] = on
            self._messages.drop(f"shown {what}")

    def _receive_shown(self, answer: Mapping[str, object], source: str) -> None:
        """Take what a page's buttons show."""
        shown = answer.get("shown")
        for what, on in list(shown.items())[:_MOST_SHOWN] if isinstance(shown, dict) else ():
            known = what in self._shown or (
                len(self._shown) < _MOST_SHOWN and 0 < len(what) <= 40 and what.isprintable()
            )
            if known and isinstance(on, bool) and self._shown.get(what) is not on:
                self._show(what, on, source)


def _key(name: str) -> str:
    """The key of a shape's message, which begins no other one: `drop` goes by beginnings."""
    return f"extra {len(name)} {name}"
