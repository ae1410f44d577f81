"""A robot of the scene: its messages, and its description for the panel."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from pathlib import Path
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import (
    COLD_TO_WARM,
    Floats,
    Vector,
    choice,
    colours as scale_colours,
    finite_or_none,
    join_poses,
)
from nao_kin._core.files import URDF_FOLDERS
from nao_kin._core.text import abbreviated
from nao_kin.errors import BadArgument, UnknownName
from nao_kin.joints import group_joints
from nao_kin.robot import Feet, RobotModel, topology
from nao_kin.robot.nao import BODY_ORDER
from nao_kin.robot.urdf import MeshFile, Rgba, UnreadableShape, UrdfJoint, UrdfTree, Visual
from nao_kin.viewer import overlays
from nao_kin.viewer.meshes import GROUPS, Mesh, Shape, lights_of, load_meshes, shape_box
from nao_kin.viewer.messages import (
    COLOURLESS,
    by_columns,
    content_name,
    geometry_document,
    geometry_pose,
    hex_colour,
    node_name,
    panel_message,
    row,
    typed_array,
)

# Straight from above or below, the tilt turns the robot's front up in the picture.
_TILT = 1e-5
# Views of the whole robot, the buttons over the picture: the direction from the robot to the camera.
_BODY_CAMERAS: Mapping[str, Vector] = {
    "front": (1.0, 0.0, 0.12),
    "side": (0.0, 1.0, 0.12),
    "three-quarter": (1.0, 0.62, 0.38),
    "top": (-_TILT, 0.0, 1.0),
}
# Views after those of the semantics.
_OTHER_CAMERAS: Mapping[str, Vector] = {
    "back": (-1.0, 0.0, 0.12),
    "right": (0.0, -1.0, 0.12),
    "bottom": (_TILT, 0.0, -1.0),
}


class SceneRobot:
    """A robot in a scene: its shapes and links, and its description for the panel.

    Parts that the semantics do not define are derived from the tree: branches are chains, and their ends effectors. If
    the scene already has a robot with the same tree, `like`, the mesh files are not read again. `number` is its number
    in the scene, 0 for the leading robot, `key` the prefix of the keys of its messages, and `ground` the path of the
    node that it stands on, with a slash at its end, or "" for the scene.
    """

    def __init__(self, robot: RobotModel, number: int = 0, like: SceneRobot | None = None) -> None:
        self.robot, self.number = robot, number
        self.key, self.ground = (f"robot {number} ", f"ground:{number}/") if number else ("", "")
        semantics, tree = robot.semantics, robot.tree
        self.drawables: tuple[Drawable, ...]
        self.notes: tuple[str, ...]
        self.drawables, self.notes = robot_drawables(tree) if like is None else (like.drawables, like.notes)
        self.paths = link_paths(tree)  # link → path of its node, parents first
        self._places = {link: index for index, link in enumerate(self.paths)}
        self._moved = {joint.name: joint.child for joint in tree.moving_joints}
        self._carriers = carriers(tree, self.drawables)
        child = {joint.name: joint.child for joint in tree.joints}
        # Name of a view → direction to the camera in the world, and the links to show with all that they carry.
        self.cameras: dict[str, tuple[Vector, tuple[str, ...]]] = {
            name: (direction, ()) for name, direction in _BODY_CAMERAS.items()
        }
        for name, view in semantics.views.items():
            self.cameras[name] = view.direction, tuple(child[joint] for joint in view.joints)
        for name, direction in _OTHER_CAMERAS.items():
            self.cameras.setdefault(name, (direction, ()))
        names = tuple(drawable.light for drawable in self.drawables if drawable.light)
        self._light_groups = {group: parts for group, parts in GROUPS.items() if set(parts) <= set(names)}
        self.light_names = (*self._light_groups, *names)  # groups first
        self.start = robot.posture(semantics.start) if semantics.start else robot.clamp(robot.neutral())
        # Posture → vertical in the root's frame; other postures stand on the soles.
        self.rest = {name: posture.up for name, posture in semantics.postures.items() if posture.up is not None}

    @property
    def aside(self) -> float:
        """Largest distance of its shapes from its root's frame along y at the start [m]."""
        poses = dict(zip(self.robot.link_names, self.robot.fk(self.start), strict=True))
        widest = 0.0
        for drawable in self.drawables:
            T = poses[drawable.link] @ drawable.T_link_shape
            widest = max(widest, float(np.abs(_box_in(T, drawable.shape))[:, 1].max()))
        return widest

    def link_of(self, frame: str) -> str:
        """Return the link whose node carries a frame: the link itself, the child of a moving joint, or the root."""
        return frame if frame in self.paths else self._moved.get(frame, self.robot.tree.root)

    def placements(self) -> Iterator[tuple[str, Floats]]:
        """Yield path and pose of each node with a constant pose in its parent: of joints and of fixed links.

        Placements are those of the model's own forward kinematics, so that a calibrated model stays calibrated.
        """
        robot, paths = self.robot, self.paths
        poses = dict(zip(robot.link_names, robot.fk(robot.neutral()), strict=True))
        for joint in robot.tree.joints:
            mimic = robot.mimics.get(joint.name)
            moved = joint.travel(mimic.offset if mimic is not None else 0.0)
            path = paths[joint.child] if joint.kind == "fixed" else holder(paths, joint)
            yield path, np.linalg.solve(poses[joint.parent], poses[joint.child]) @ np.linalg.inv(moved)

    def parts(self) -> dict[str, bytes]:
        """Return key → message of the geometries and of the description, which equal robots share."""
        name, model = self._model
        geometries = (drawable.geometry for drawable in self.drawables)
        return {**{f"geometry {name}": message for name, message in geometries}, f"model {name}": model}

    @cached_property
    def _model(self) -> tuple[str, bytes]:
        """Return a name for the description, the same for equal robots, and its message."""
        about = self.about()
        name = content_name(about)
        return name, panel_message("model", {"name": name, "about": about})

    def messages(self, name: str = "", opacity: float = 1.0) -> Iterator[tuple[str, bytes]]:
        """Yield key and message of the robot itself, which refers to its `parts`."""
        if self.number:
            of = {"robot": self.number}
            # A page that has another robot of this number, from an earlier program, must remove it.
            yield f"{self.key}anew", panel_message("robot_removed", of)
            content = {**of, "name": name, "model": self._model[0], "opacity": opacity}
            yield f"{self.key}about", panel_message("robot_added", content)
        else:
            yield "robot", panel_message("robot", {"model": self._model[0]})
            # Meshes are read and sent only when they are asked for.
            if not any(isinstance(part.geometry, MeshFile) for part in self.robot.tree.collisions):
                yield "shapes", self.shapes()

    def lights(self, values: Mapping[str, ArrayLike]) -> bytes:
        """Return the message that sets colours of lights; a light named in addition to its group has its own colour."""
        rgb: dict[str, list[float]] = {}
        for name in sorted(values, key=lambda name: name not in self._light_groups):
            colour = overlays.one_colour(values[choice(name, self.light_names, "light")], f"colour of {name}")
            rgb |= dict.fromkeys(self._light_groups.get(name, (name,)), colour)
        return panel_message("lights", {"lights": [{"name": name, "rgb": colour} for name, colour in rgb.items()]})

    def shapes(self) -> bytes:
        """Return the message of the collision shapes; shapes whose files cannot be read are left out."""
        tree = self.robot.tree
        as_visuals = tuple(Visual(part.link, part.origin, part.geometry) for part in tree.collisions)
        found, _ = robot_drawables(replace(tree, visuals=as_visuals))
        rows = [
            {"link": self._places[part.link], "geometry": geometry_document(part.shape)}
            | {"matrix": by_columns(part.T_link_shape @ geometry_pose(part.shape))}
            for part in found
        ]
        return panel_message("shapes", {"shapes": rows})

    def colours(
        self, values: Mapping[str, float], low: float | None, high: float | None, label: str
    ) -> tuple[str, bytes]:
        """Return key and message that show links in the colours of a scale, with its legend.

        A link without a shape colours the link with a shape to which it is fixed, unless that link is named too.
        """
        for name in values:
            choice(name, self._places, "link")
        content: dict[str, Any] = {**COLOURLESS, "robot": self.number, "label": str(label)}
        if values:
            numbers = {name: overlays.number(value, f"value of {name}") for name, value in values.items()}
            bottom = min(numbers.values()) if low is None else overlays.number(low, "low")
            top = max(numbers.values()) if high is None else overlays.number(high, "high")
            if bottom == top and (low is None or high is None):
                bottom, top = (bottom - 0.5 if low is None else bottom), (top + 0.5 if high is None else top)
            if not bottom < top:
                raise BadArgument(f"the colour scale needs low < high, got {bottom:g} and {top:g}")
            rgb = {name: scale_colours(value, bottom, top).tolist() for name, value in numbers.items()}
            own = {self._carriers[name]: rgb[name] for name in numbers if name in self._carriers} | rgb
            content["links"] = [{"link": self._places[name], "rgb": own[name]} for name in own]
            content |= {"low": f"{bottom:.4g}", "high": f"{top:.4g}", "stops": COLD_TO_WARM}
        return f"{self.key}colours", panel_message("colours", content)

    def hulls(self) -> bytes:
        """Return the message of the hulls by which pages find links that overlap.

        Raises:
            BadArgument: the robot has no shapes.
        """
        links, table, pairs = self.robot.link_shapes.hulls
        content = {
            "links": [self._places[links[k]] for k in table.link.tolist()],
            "counts": np.diff(table.first).tolist(),
            "radii": table.radius.tolist(),
            "parts": table.parts.tolist(),
            "points": typed_array(table.points.astype(np.float32).reshape(-1)),
            "pairs": typed_array(pairs.astype(np.uint16).reshape(-1)),
        }
        return panel_message("hulls", content)

    def about(self) -> dict[str, Any]:
        """Return the description for the page: shapes, joints, limits, postures, mirror, frames, masses, cameras.

        Links are given by their index in `links`, coordinates by their index in q. Names from foreign files are values,
        never keys, because some keys have a meaning in JavaScript.
        """
        robot, semantics, place = self.robot, self.robot.semantics, self._places
        feet = Feet.of(robot, None, or_origin=True)
        moving, drivers, views = robot.tree.moving_joints, drivers_of(robot), semantics.fields_of_view
        child = {joint: place[link] for joint, link in self._moved.items()}
        column = {name: drivers[name].column for name in robot.joint_names}
        chains = {**semantics.chains, **_branches(robot)}
        ends = limb_ends(robot, chains.values(), self.drawables)
        effectors = (*semantics.end_effectors, *semantics.cameras) or tuple(ends) or robot.link_names[:1]
        root = semantics.root or robot.tree.root
        shaped = {drawable.link for drawable in self.drawables}
        titles = {ros: own for own, ros in semantics.ros_names.items() if ros in shaped and own in place}
        pairs = {
            part: (joint.pair.name, number) for number, joint in enumerate(group_joints(robot)) for part in joint.joints
        }
        return {
            "name": robot.name,
            "floating": robot.base == "floating",
            "root": "the world" if robot.base == "floating" else titles.get(root, root),
            "soles": [
                row("Sole", place[link], feet.points[feet.owner == k].ravel().tolist())
                for k, link in enumerate(semantics.soles)
            ],
            "notes": list(self.notes),
            "links": [row("Link", name, titles.get(name, name), path.split("/")) for name, path in self.paths.items()],
            "places": [row("Place", path.split("/"), by_columns(T)) for path, T in self.placements()],
            "shapes": [
                row(
                    "ShapeAbout",
                    place[drawable.link],
                    drawable.geometry[0],
                    by_columns(drawable.T_link_shape @ geometry_pose(drawable.shape)),
                    hex_colour(drawable.rgba),
                    drawable.rgba[3],
                    drawable.light,
                )
                for drawable in self.drawables
            ],
            "joints": [
                {"name": joint.name, **vars(drivers[joint.name])}
                | row(
                    "JointAbout",
                    child[joint.name],
                    joint.kind == "prismatic",
                    joint.axis,
                    *pairs.get(joint.name, ("", -1)),
                )
                for joint in moving
            ],
            "coordinates": [
                row("Coordinate", name, column[name], *map(finite_or_none, bounds), unit)
                for name, unit, *bounds in zip(
                    robot.joint_names,
                    robot.joint_units,
                    *(bound.tolist() for bound in (robot.lower, robot.upper, robot.velocity_limits)),
                    strict=True,
                )
            ],
            "tables": [
                row("CoupledLimits", column[table.joint], column[table.of], table.at, table.lower, table.upper)
                for table in robot.coupled_limits
            ],
            "chains": [
                row("Chain", title, [{"name": name, **vars(drivers[name])} for name in names])
                for title, names in _each_once(chains).items()
            ],
            "postures": self._postures(),
            "mirror": _mirror(robot, drivers),
            "naoqi": _naoqi_order(robot),
            "neutral": robot.neutral().tolist(),
            "frames": [row("Frame", name, place[self.link_of(name)]) for name in robot.frame_names],
            "effectors": [name for name in effectors if name in robot.frame_names],
            "ends": [row("End", name, ends.get(name, [0.0] * 3)) for name in dict.fromkeys((*effectors, *ends))],
            "bodies": _bodies(robot, child),
            "cameras": [
                row("Camera", name, direction, [place[link] for link in links])
                for name, (direction, links) in self.cameras.items()
            ],
            "eyes": [
                row("Eye", name, place[self.link_of(name)], *views.get(name, (None, None)))
                for name in semantics.cameras
            ],
        }

    def _postures(self) -> list[dict[str, Any]]:
        """Return the robot's postures; if it has none, one with all joints at zero or at the nearest limit to it."""
        robot = self.robot
        postures = {name: robot.posture(name) for name in robot.posture_names} or {"Zero": robot.clamp(robot.neutral())}
        return [row("Posture", name, q.tolist(), self.rest.get(name)) for name, q in postures.items()]


def _branches(robot: RobotModel) -> dict[str, tuple[str, ...]]:
    """Return the joints that are in no chain of the semantics, by the branches of the tree."""
    named = {joint for joints in robot.chains.values() for joint in joints}
    branches = (tuple(j for j in chain if j not in named) for chain in topology(robot).chains)
    return {joints[0] if len(joints) == 1 else f"{joints[0]} … {joints[-1]}": joints for joints in branches if joints}


# Joints of grippers without mimic joints, and frames at ends, by name.
_GRIPS = re.compile("grip|jaw|finger", re.IGNORECASE)
_ENDS = re.compile("tool|tcp|end_?eff|grip|grasp|hand|foot|sole", re.IGNORECASE)
# A branch is a finger if it is shorter than _FINGER of the limb of at least _ARM joints that carries it. A fixed frame
# is no end if it is nearer to the last joint than _NEAR of the reach of the shapes there.
_FINGER, _ARM, _NEAR = 1 / 3, 3, 0.25


def limb_ends(
    robot: RobotModel, chains: Iterable[Sequence[str]], drawables: Iterable[Drawable]
) -> dict[str, list[float]]:
    """Return frame → point in it [m] for the ends of chains, without grippers and fingers, which belong to their hand.

    The end is the origin of the farthest link that is fixed to the last moving one and has the name of an end, such as
    a tool or a sole, or of the only link there. Otherwise it is the middle of the farthest side of a box around the
    shapes that the last joint moves.
    """
    table, structure = robot.joints, topology(robot)
    mimics = {name: mimic.joint for name, mimic in structure.couplings.items()}
    grips = {joint for name, joint in mimics.items() if name not in structure.couplings_between_limbs}
    limbs: dict[int, list[int]] = {}  # row of the last joint → rows of the joints
    for chain in chains:
        rows = [table.row(name) for name in chain]
        while rows and (table.names[rows[-1]] in grips or _GRIPS.search(table.names[rows[-1]])):
            rows.pop()
        if rows:
            limbs.setdefault(rows[-1], rows)
    bodies: dict[int, dict[str, Floats]] = {}
    for link in robot.link_names:
        row, T_joint_link = robot.frame_placement(link)
        bodies.setdefault(row, {})[link] = T_joint_link
    steps = np.linalg.norm(table.placements[:, :3, 3], axis=1)
    found: dict[str, list[float]] = {}
    for last, rows in limbs.items():
        frame, point, reach = _end(robot, table.links[last], bodies[last], drawables)
        carrier = limbs.get(int(table.parents[rows[0]]), [])
        arm = steps[[*carrier[1:], rows[0]]].sum()
        if len(carrier) < _ARM or steps[rows[1:]].sum() + reach > _FINGER * arm:
            found[frame] = point
    return found


def _end(
    robot: RobotModel, link: str, body: Mapping[str, Floats], drawables: Iterable[Drawable]
) -> tuple[str, list[float], float]:
    """Return the frame at the end of a limb, the point in it, and how far the point is from the joint of the last link.

    `body` are the poses of the links that are fixed to the last link, in that link.
    """
    parents = {joint.parent for joint in robot.tree.joints if joint.kind == "fixed"}
    leaves = [name for name in body if name not in parents]
    named = [name for name in leaves if _ENDS.search(name)] or (leaves if len(leaves) == 1 else [link])
    leaf = max(named, key=lambda name: float(np.linalg.norm(body[name][:3, 3])))
    distance = float(np.linalg.norm(body[leaf][:3, 3]))
    boxes = [_box_in(body[part.link] @ part.T_link_shape, part.shape) for part in drawables if part.link in body]
    if not boxes:
        return leaf, [0.0] * 3, distance
    low, high = np.min([box[0] for box in boxes], axis=0), np.max([box[1] for box in boxes], axis=0)
    sides = np.tile((low + high) / 2.0, (6, 1))
    sides[range(6), [0, 1, 2] * 2] = [*low, *high]
    point = max(sides, key=lambda side: float(np.linalg.norm(side)))
    reach = float(np.linalg.norm(point))
    return (leaf, [0.0] * 3, distance) if distance >= _NEAR * reach else (link, point.tolist(), reach)


def _box_in(T: Floats, shape: Shape) -> tuple[Floats, Floats]:
    """Return the least and the greatest coordinates of the box of a shape at a pose."""
    low, high = shape_box(shape)
    middle, half = T[:3, :3] @ ((low + high) / 2.0) + T[:3, 3], np.abs(T[:3, :3]) @ ((high - low) / 2.0)
    return middle - half, middle + half


def _each_once(chains: Mapping[str, tuple[str, ...]]) -> dict[str, tuple[str, ...]]:
    """Return the chains with each joint in the shortest one that has it, without chains that have no joint left."""
    owner: dict[str, str] = {}
    for title in sorted(chains, key=lambda title: len(chains[title])):
        for joint in chains[title]:
            owner.setdefault(joint, title)
    kept = {title: tuple(j for j in joints if owner[j] == title) for title, joints in chains.items()}
    return {title: joints for title, joints in kept.items() if joints}


def _mirror(robot: RobotModel, drivers: Mapping[str, Driver]) -> list[dict[str, Any]]:
    """Return the mirror image of q: q[column] becomes multiplier · q[of] + offset. Empty for robots without sides."""
    try:
        images = {name: robot.mirror_image(name) for name in robot.joint_names}
    except (BadArgument, UnknownName):
        return []
    if all(name == image.joint for name, image in images.items()):
        return []
    rows = []
    for name, image in images.items():
        driver, sign = drivers[image.joint], image.multiplier
        rows.append(
            row("Mirrored", drivers[name].column, driver.column, sign * driver.multiplier, sign * driver.offset)
        )
    return rows


def _naoqi_order(robot: RobotModel) -> list[str]:
    """Return the robot's joints in the order of NAOqi's Body; empty if those names do not set every joint."""
    names = [name for name in BODY_ORDER if name in robot.joint_names or name in robot.mimics]
    moved = {robot.mimics[name].joint if name in robot.mimics else name for name in names}
    return names if moved == set(robot.joint_names) else []


def _box_of(mass: float, centre: Floats, inertia: Floats) -> tuple[Floats, Floats]:
    """Return edges and pose of the even box with a mass, a centre and an inertia about it: I₁ = m (b² + c²) / 12."""
    moments, axes = np.linalg.eigh(inertia)
    axes[:, 2] *= np.linalg.det(axes)
    squares = 6.0 * (moments.sum() - 2.0 * moments) / mass
    return np.sqrt(np.maximum(squares, 0.0)), join_poses(axes, centre)


def _bodies(robot: RobotModel, child: Mapping[str, int]) -> list[dict[str, Any]]:
    """Return mass and centre of each group of links that moves as one, from the model."""
    bodies = []
    for index, inertia in enumerate(robot.model.inertias):
        if inertia.mass > 0.0:
            link = child.get(robot.model.names[index], 0)
            size, pose = _box_of(float(inertia.mass), np.array(inertia.lever), np.array(inertia.inertia))
            centre = np.array(inertia.lever).tolist()
            bodies.append(row("Body", link, float(inertia.mass), centre, size.tolist(), by_columns(pose)))
    return bodies


# --- The robot as a tree of scene nodes, so that the browser composes the transforms.
#
# Every moving joint is a node with its constant placement in the parent link; the child link is a node below it whose
# rotation, or translation, is the joint's. Nothing else changes, so only configurations have to be sent.

ROBOT = "robot"
_GREY: Rgba = (0.75, 0.77, 0.8, 1.0)


@dataclass(frozen=True, eq=False)
class Drawable:
    """One shape of one link, in one colour and opacity, each in [0, 1]."""

    link: str
    T_link_shape: Floats
    shape: Shape
    rgba: Rgba
    light: str = ""  # name of the light, "" for other shapes

    @cached_property
    def geometry(self) -> tuple[str, bytes]:
        """A name, the same for equal shapes, and the message of the shape without colour and pose."""
        if not isinstance(self.shape, Mesh):
            return _geometry(self.shape)
        if self.shape not in _geometries:
            _geometries[self.shape] = _geometry(self.shape)
        return _geometries[self.shape]


def _geometry(shape: Shape) -> tuple[str, bytes]:
    document = geometry_document(shape)
    name = content_name(document)
    return name, panel_message("geometry", {"name": name, "geometry": document})


_geometries: WeakKeyDictionary[Mesh, tuple[str, bytes]] = WeakKeyDictionary()


def _meshes(path: Path, scale: tuple[float, float, float]) -> tuple[Mesh, ...]:
    return load_meshes(path, np.array(scale))


_own_meshes = cache(_meshes)
"""`_meshes` of files of our NAO, read once per process: the files of the package do not change."""


def robot_drawables(tree: UrdfTree) -> tuple[tuple[Drawable, ...], tuple[str, ...]]:
    """Return a robot's visuals with their meshes loaded, one per colour and light, and notes on missing ones."""
    found: list[Drawable] = []
    missing: list[str] = []
    notes: list[str] = []
    loaded: dict[tuple[Path, tuple[float, ...]], tuple[Mesh, ...]] = {}
    packages, own = tree.packages, set(URDF_FOLDERS)
    for visual in tree.visuals:
        T_link_shape, geometry = visual.origin.matrix, visual.geometry
        if not isinstance(geometry, MeshFile):
            found.append(Drawable(visual.link, T_link_shape, geometry, visual.rgba or _GREY))
            continue
        path = packages.file(geometry.filename)
        if path is None:
            missing.append(geometry.filename)
            continue
        try:
            if (path, geometry.scale) not in loaded:
                read = _own_meshes if own.intersection(path.parents) else _meshes
                loaded[path, geometry.scale] = read(path, geometry.scale)
        except UnreadableShape as reason:
            notes.append(f"a visual of {abbreviated(visual.link)} is not shown: {path.name}: {reason}")
            continue
        for mesh in loaded[path, geometry.scale]:
            rgba = visual.rgba or mesh.colour or _GREY
            for name, part in (lights_of(geometry.filename, mesh) or {"": mesh}).items():
                found.append(Drawable(visual.link, T_link_shape, part, rgba, name))
    if missing:
        more = f" and {len(missing) - 1} more" if len(missing) > 1 else ""
        notes.insert(0, f"mesh files not found: {abbreviated(missing[0])}{more}")
    return tuple(found), (*notes, *tree.visual_notes)


def carriers(tree: UrdfTree, shown: Iterable[Drawable]) -> dict[str, str]:
    """Return link without a shape → nearest link with a shape that carries it through fixed joints alone."""
    seen = {drawable.link for drawable in shown}
    found: dict[str, str] = {}
    for joint in tree.joints:
        if joint.kind == "fixed" and joint.child not in seen:
            carrier = joint.parent if joint.parent in seen else found.get(joint.parent)
            if carrier is not None:
                found[joint.child] = carrier
    return found


def link_paths(tree: UrdfTree) -> dict[str, str]:
    """Return the path of every link's node, parents first."""
    paths = {tree.root: f"{ROBOT}/{node_name('link', tree.root)}"}
    for joint in tree.joints:
        paths[joint.child] = f"{holder(paths, joint)}/{node_name('link', joint.child)}"
    return paths


@dataclass(frozen=True)
class Driver:
    """The coordinate that moves a joint: its value is multiplier · q[column] + offset [rad or m]."""

    column: int
    multiplier: float = 1.0
    offset: float = 0.0
    follows: str = ""  # the driving joint of a mimic joint, otherwise ""

    def values(self, q: Floats) -> Floats:
        """Return the joint's values in configurations, shape (..., nq)."""
        return np.asarray(self.multiplier * q[..., self.column] + self.offset)


def drivers_of(robot: RobotModel) -> dict[str, Driver]:
    """Return the driver of each joint of a robot, by name."""
    own = {name: Driver(column) for column, name in enumerate(robot.joint_names, robot.nq_base)}
    return own | {
        name: Driver(own[mimic.joint].column, mimic.multiplier, mimic.offset, mimic.joint)
        for name, mimic in robot.mimics.items()
    }


def numbered(drawables: Iterable[Drawable]) -> Iterator[tuple[int, Drawable]]:
    """Yield the drawables with their indices among those of their link."""
    count: dict[str, int] = {}
    for drawable in drawables:
        count[drawable.link] = index = count.get(drawable.link, -1) + 1
        yield index, drawable


def holder(paths: Mapping[str, str], joint: UrdfJoint) -> str:
    """Return the node of the child link: the joint's own, or for a fixed joint the parent link's."""
    parent = paths[joint.parent]
    return parent if joint.kind == "fixed" else f"{parent}/{node_name('joint', joint.name)}"
