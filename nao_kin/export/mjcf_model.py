"""A robot in MuJoCo's specification: bodies, couplings, shapes and contacts, key frames, motors and sensors."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import mujoco
import numpy as np
import pinocchio as pin

from nao_kin._core.arrays import Floats, Vector
from nao_kin._core.text import fresh_name
from nao_kin.export.inertia import central_tensor
from nao_kin.export.meshes import GREY, paint_names, shapes_of
from nao_kin.export.urdf import UNBOUNDED
from nao_kin.export.variants import joint_values
from nao_kin.joints import JointGroups
from nao_kin.robot import RobotModel, capsules
from nao_kin.robot.semantics import Semantics
from nao_kin.robot.urdf import Box, Collision, Cylinder, Geometry, MeshFile, Origin, Sphere, UrdfJoint, UrdfTree, Visual
from nao_kin.rotations import log, matrix_from_natural, quat_from_matrix, rotation_between

# --- A tree of links as MuJoCo's bodies: one body for each moving link and all links fixed to it.


def pose(origin: Origin) -> pin.SE3:
    """Return the pose of a URDF's origin, to the last bit as in the robot's model."""
    return pin.SE3(pin.rpy.rpyToMatrix(*origin.rpy), np.array(origin.xyz))


def pos_quat(T: pin.SE3) -> dict[str, list[float]]:
    """Return position [m] and quaternion, scalar first."""
    return {"pos": (T.translation + 0.0).tolist(), "quat": (quat_from_matrix(T.rotation) + 0.0).tolist()}


_BALL = (1e-3, 6.2e-3)  # mass [kg] and radius [m] of a ball of water


@dataclass(frozen=True, eq=False)
class BodyJoint:
    """A joint of a body."""

    name: str  # for a ball, the names of its parts joined by "+"
    kind: str  # "hinge", "slide" or "ball"
    axes: Floats  # in the body's frame with all joints at zero, shape (n, 3): one, or the three of a ball
    rows: tuple[UrdfJoint, ...]  # the joints of the tree for each axis
    motor: Servo  # of a ball the weakest of its three, because all three reach this effort


@dataclass(eq=False)
class Body:
    """A body."""

    name: str  # the name of a link in its frame
    parent: int  # index of the body that carries it, −1 for the root
    T_parent: pin.SE3  # its pose in the parent with all joints at zero
    joints: tuple[BodyJoint, ...]  # the joints between the two, the outermost last
    inertia: pin.Inertia = field(default_factory=pin.Inertia.Zero)  # of all its links, in its frame
    links: dict[str, pin.SE3] = field(default_factory=dict)  # link → its pose in the body


@dataclass(frozen=True, eq=False)
class Bodies:
    """The bodies of a robot."""

    bodies: tuple[Body, ...]  # parents first, beginning with the root
    between: frozenset[str]  # links between merged axes, fixed to the body before as with all joints at zero

    def place(self, link: str) -> tuple[Body, pin.SE3]:
        """Return the body of a link, and the link's pose in it."""
        return next((body, body.links[link]) for body in self.bodies if link in body.links)

    def joints(self) -> Iterator[BodyJoint]:
        """Yield all joints, parents first."""
        for body in self.bodies:
            yield from body.joints


def bodies_of(tree: UrdfTree, groups: JointGroups | None, stall: Mapping[str, float]) -> Bodies:
    """Return the bodies of a tree, with the joints of `groups` merged, and motors with stall torques [N m].

    A universal joint becomes two hinges of one body, a spherical joint a ball, or three hinges of one body if one of
    its axes is coupled, because MuJoCo couples only joints of one coordinate.
    """
    runs = [group.joints for group in groups or () if len(group.axes) > 1]
    before_last = {name for run in runs for name in run[:-1]}
    run_of = {run[-1]: run for run in runs}
    rows = {joint.name: joint for joint in tree.joints}
    coupled = {name for joint, mimic in tree.mimics.items() for name in (joint, mimic.joint)}
    bodies = [Body(tree.root, -1, pin.SE3.Identity(), ())]
    places = {tree.root: (0, pin.SE3.Identity())}
    axes: dict[str, Floats] = {}  # of merged joints, in the frame of the body before them
    between: set[str] = set()
    for row in tree.joints:
        index, T_link = places[row.parent]
        T_joint = T_link * pose(row.origin)
        if row.kind == "fixed" or row.name in before_last:
            places[row.child] = index, T_joint
            if row.kind != "fixed":
                axes[row.name] = T_joint.rotation @ np.array(row.axis)
            if row.parent in between or row.name in before_last:
                between.add(row.child)
            continue
        run = run_of.get(row.name, (row.name,))
        axes[row.name] = T_joint.rotation @ np.array(row.axis)
        parts = [(row, np.array(row.axis))]
        if len(run) > 1:
            turned = [T_joint.rotation.T @ axes[name] for name in run]
            # Avoids the rounding of a rotation and its inverse.
            parts = [
                (rows[name], np.where(np.abs(e) < 1e-15, 0.0, e) + 0.0) for name, e in zip(run, turned, strict=True)
            ]
        elif row.parent in between:
            between.add(row.child)
        bodies.append(Body(row.child, index, T_joint, _joints(parts, coupled, stall)))
        places[row.child] = len(bodies) - 1, pin.SE3.Identity()
    for link in tree.links:
        index, T_body = places[link]
        bodies[index].links[link] = T_body
        held = tree.inertials.get(link)
        if held is not None:
            inertia = pin.Inertia.Zero()
            inertia.mass, inertia.lever, inertia.inertia = held.mass, np.array(held.origin.xyz), central_tensor(held)
            bodies[index].inertia += T_body.act(inertia)
    bodies[0].name = _root_name(tree, bodies[0])
    return Bodies(tuple(bodies), frozenset(between))


def give_the_root_mass(bodies: Bodies) -> tuple[str, ...]:
    """Give a freely moving root without mass a ball of water of one gram; return a line if this was done."""
    root = bodies.bodies[0]
    if root.inertia.mass > 0.0:
        return ()
    root.inertia += pin.Inertia.FromSphere(*_BALL)
    return (f"{root.name}: mass 0 → {_BALL[0]:g} kg, because it moves freely",)


def _joints(
    parts: Sequence[tuple[UrdfJoint, Floats]], coupled: set[str], stall: Mapping[str, float]
) -> tuple[BodyJoint, ...]:
    rows = tuple(row for row, _ in parts)
    motors = [servo(row, stall) for row in rows]
    if len(rows) == 3 and not coupled.intersection(row.name for row in rows):
        axes, weakest = np.stack([axis for _, axis in parts]), min(motors, key=lambda motor: motor.effort)
        return (BodyJoint("+".join(row.name for row in rows), "ball", axes, rows, weakest),)
    return tuple(
        BodyJoint(row.name, "slide" if row.kind == "prismatic" else "hinge", axis[None], (row,), motor)
        for (row, axis), motor in zip(parts, motors, strict=True)
    )


def _root_name(tree: UrdfTree, root: Body) -> str:
    """Return the first link with mass at the root's frame; not "world", which is MuJoCo's own body."""
    identity = pin.SE3.Identity()
    heavy = (link for link, T in root.links.items() if link in tree.inertials and identity == T)
    name = next(heavy, tree.root)
    return name if name != "world" else "world_link"


# --- Bodies and joints in the specification.

# The stiffest couplings that MuJoCo accepts: a time constant of two steps of the simulation, critically damped, and
# constraint forces that yield by a ten-thousandth.
_COUPLING_SOLREF = (0.004, 1.0)
_COUPLING_SOLIMP = (0.9999, 0.9999, 0.001, 0.5, 2.0)


def add_bodies(spec: Any, bodies: Bodies, *, floating: bool) -> list[Any]:
    """Add bodies with masses and joints, and an equality for each mimic joint; return MuJoCo's body for each."""
    added: list[Any] = []
    for body in bodies.bodies:
        parent = spec.worldbody if body.parent < 0 else added[body.parent]
        one = parent.add_body(name=body.name, **pos_quat(body.T_parent))
        _set_inertia(one, body)
        for joint in body.joints:
            _add_joint(one, joint)
        added.append(one)
    if floating:
        added[0].add_freejoint(name=fresh_name("root_joint", {joint.name for joint in bodies.joints()}))
    for joint in bodies.joints():
        mimic = joint.rows[0].mimic
        if joint.kind != "ball" and mimic is not None:
            equality = spec.add_equality(
                name=joint.name,
                type=mujoco.mjtEq.mjEQ_JOINT,
                objtype=mujoco.mjtObj.mjOBJ_JOINT,
                name1=joint.name,
                name2=mimic.joint,
                solref=_COUPLING_SOLREF,
                solimp=_COUPLING_SOLIMP,
            )
            # Coefficients of a polynomial; the length of the array differs between versions of MuJoCo.
            equality.data[:5] = mimic.offset, mimic.multiplier, 0.0, 0.0, 0.0
    return added


def _set_inertia(one: Any, body: Body) -> None:
    if body.inertia.mass == 0.0 and not np.any(body.inertia.inertia) and not body.joints:
        return
    tensor = body.inertia.inertia
    one.mass, one.ipos = float(body.inertia.mass), body.inertia.lever.tolist()
    one.fullinertia = [float(tensor[i, j]) for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
    one.explicitinertial = True


def _add_joint(one: Any, joint: BodyJoint) -> None:
    motor, row = joint.motor, joint.rows[0]
    added = one.add_joint(name=joint.name, type=getattr(mujoco.mjtJoint, f"mjJNT_{joint.kind.upper()}"))
    if joint.kind != "ball":
        added.axis = joint.axes[0].tolist()
        if row.mimic is None and (math.isfinite(row.lower) or math.isfinite(row.upper)):
            added.range = proper_range(row.lower, row.upper)
    # The driving joint has the motor and the limits of all its mimic joints.
    damping, added.armature = (motor.damping, motor.armature) if row.mimic is None else (row.damping, 0.0)
    # A polynomial of the speed since MuJoCo 3.10, a number in earlier versions.
    added.damping = damping if np.ndim(added.damping) == 0 else [damping, 0.0, 0.0]
    added.frictionloss = max(part.friction for part in joint.rows)


# --- Visual and collision shapes as MuJoCo's geoms.

VISUAL, COLLISION = "visual", "collision"
_VISUAL_GROUP, _COLLISION_GROUP = 2, 3


def add_shapes(
    spec: Any, added: list[Any], bodies: Bodies, tree: UrdfTree, meshes: Mapping[str, str] | None
) -> tuple[str, ...]:
    """Add the shapes of a tree, in two classes that set contacts and groups; return a line about omitted ones."""
    defaults = {kind: spec.add_default(kind, spec.default) for kind in (VISUAL, COLLISION)}
    defaults[VISUAL].geom.group, defaults[COLLISION].geom.group = _VISUAL_GROUP, _COLLISION_GROUP
    defaults[VISUAL].geom.contype = defaults[VISUAL].geom.conaffinity = 0
    everything = shapes_of(tree)
    shapes = [shape for shape in everything if meshes is not None or not isinstance(shape.geometry, MeshFile)]
    paints = {
        shape: (shape.material or "colour", shape.rgba or GREY)
        for shape in shapes
        if isinstance(shape, Visual) and (shape.material or shape.rgba)
    }
    materials = paint_names(paints.values())
    for (_, rgba), name in materials.items():
        spec.add_material(name=name, rgba=rgba)
    scaled = _add_meshes(spec, [shape.geometry for shape in shapes], meshes or {})
    places = {
        link: (one, T_link)
        for body, one in zip(bodies.bodies, added, strict=True)
        for link, T_link in body.links.items()
    }
    taken: set[str] = set()
    collisions = [shape for shape in shapes if isinstance(shape, Collision)]
    round_ended = capsules(collisions)
    caps = {id(collisions[cap]) for both in round_ended.values() for cap in both}
    whole = {id(collisions[cylinder]) for cylinder in round_ended}
    for shape in shapes:
        if id(shape) in caps:
            continue
        kind = VISUAL if isinstance(shape, Visual) else COLLISION
        one, T_link = places[shape.link]
        name = fresh_name(shape.name or f"{shape.link}_{kind}", taken)
        taken.add(name)
        geom = one.add_geom(defaults[kind], name=name, **pos_quat(T_link * pose(shape.origin)))
        _set_geometry(geom, shape.geometry, scaled)
        if id(shape) in whole:
            geom.type = mujoco.mjtGeom.mjGEOM_CAPSULE
        if shape in paints:
            geom.material = materials[paints[shape]]
    omitted = len(everything) - len(shapes)
    return (f"{omitted} shapes that are meshes are left out",) if omitted else ()


def _add_meshes(spec: Any, geometries: Iterable[Geometry], meshes: Mapping[str, str]) -> dict[MeshFile, str]:
    """Add each mesh once in each scale; return their names in the specification."""
    found: dict[tuple[str, Vector], str] = {}
    scaled = {mesh: (meshes[mesh.filename], mesh.scale) for mesh in geometries if isinstance(mesh, MeshFile)}
    # The bodies have the masses, so a mesh may be open, or flat.
    shell = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
    for file, scale in dict.fromkeys(scaled.values()):
        found[file, scale] = name = fresh_name(file.rpartition(".")[0], found.values())
        spec.add_mesh(name=name, file=file, scale=scale, inertia=shell)
    return {mesh: found[key] for mesh, key in scaled.items()}


def _set_geometry(geom: Any, geometry: Geometry, scaled: Mapping[MeshFile, str]) -> None:
    kinds = mujoco.mjtGeom
    if isinstance(geometry, Box):
        geom.type, geom.size = kinds.mjGEOM_BOX, [0.5 * length for length in geometry.size]
    elif isinstance(geometry, Cylinder):
        geom.type, geom.size = kinds.mjGEOM_CYLINDER, [geometry.radius, 0.5 * geometry.length, 0.0]
    elif isinstance(geometry, Sphere):
        geom.type, geom.size = kinds.mjGEOM_SPHERE, [geometry.radius, 0.0, 0.0]
    else:
        geom.type, geom.meshname = kinds.mjGEOM_MESH, scaled[geometry]


# --- Pairs of bodies without contacts.


def add_excludes(spec: Any) -> tuple[str, ...]:
    """Exclude contacts between neighbours, and between bodies whose shapes overlap at zero or in a posture.

    Collision shapes are approximate: those of neighbours always overlap, and those of other bodies overlap where the
    real shells just pass each other. The neighbour of a body is the nearest preceding body with a shape.
    """
    model = spec.compile()
    data = mujoco.MjData(model)
    excluded: dict[tuple[int, int], None] = {}
    touching = {int(model.geom_bodyid[geom]) for geom in range(model.ngeom) if model.geom_contype[geom]}
    for body in range(1, model.nbody):
        before = int(model.body_parentid[body])
        while before and before not in touching:
            before = int(model.body_parentid[before])
        if body in touching and before:
            excluded[before, body] = None
    neighbours = len(excluded)
    for key in range(-1, model.nkey):
        if key < 0:
            mujoco.mj_resetData(model, data)
        else:
            mujoco.mj_resetDataKeyframe(model, data, key)
        mujoco.mj_forward(model, data)
        for contact in data.contact:
            first, second = sorted(int(model.geom_bodyid[geom]) for geom in contact.geom)
            if contact.dist < 0.0:
                excluded[first, second] = None
    for first, second in excluded:
        spec.add_exclude(bodyname1=model.body(first).name, bodyname2=model.body(second).name)
    pairs = [f"{model.body(a).name}–{model.body(b).name}" for a, b in list(excluded)[neighbours:]]
    return (f"contacts are excluded where shapes overlap in a posture: {', '.join(pairs)}",) if pairs else ()


# --- Boxes of feet whose lower faces are nearly in the soles' planes, moved to them.

# A box that ends nearer than this to the plane of a sole belongs to the foot [m].
_NEAR = 0.005
_PARALLEL = 1e-6


def on_their_soles(tree: UrdfTree, bodies: Bodies, semantics: Semantics) -> tuple[UrdfTree, tuple[str, ...]]:
    """Return the tree with the boxes of its feet ending in the planes of the soles, and one line per changed sole.

    The published box of the NAO's foot ends 0.6 mm above the sole, so the frames of the soles would be below the floor.
    """
    collisions, changes = list(tree.collisions), []
    for sole in semantics.soles:
        body, T_sole = bodies.place(tree.link_of(sole))
        own = [(place, shape) for place, shape in enumerate(collisions) if shape.link in body.links]
        if not own:
            changes.append(f"the body of the sole {sole} has no shape: it touches nothing")
        for place, shape in own:
            T_shape = T_sole.actInv(body.links[shape.link] * pose(shape.origin))
            lowered = _to_the_plane(shape, T_shape)
            if lowered is not None:
                collisions[place], gap = lowered
                changes.append(f"the lower face of {shape.name or shape.link} is moved by {gap * 1e3:.2f} mm to {sole}")
    return replace(tree, collisions=tuple(collisions)), tuple(changes)


def _to_the_plane(shape: Collision, T_sole_shape: pin.SE3) -> tuple[Collision, float] | None:
    """Return a box that ends in the plane z = 0, and how far it has grown downwards; None for other shapes."""
    if not isinstance(shape.geometry, Box):
        return None
    down = T_sole_shape.rotation[2]
    axis = int(np.argmax(np.abs(down)))
    size = list(shape.geometry.size)
    gap = float(T_sole_shape.translation[2] - 0.5 * size[axis])
    if abs(down[axis]) < 1.0 - _PARALLEL or gap == 0.0 or abs(gap) > _NEAR:
        return None
    size[axis] += gap
    # The box grows along one axis, away from the fixed face.
    shift = np.zeros(3)
    shift[axis] = -0.5 * gap * np.sign(down[axis])
    x, y, z = (np.array(shape.origin.xyz) + pose(shape.origin).rotation @ shift).tolist()
    return replace(shape, geometry=Box((size[0], size[1], size[2])), origin=Origin((x, y, z), shape.origin.rpy)), gap


# --- The lowest point of all shapes that can touch the floor.


def lowest_point(model: Any, data: Any) -> float:
    """Return the least height of all geoms that can touch something; without any, of the bodies' frames [m]."""
    kinds = mujoco.mjtGeom
    heights = []
    for geom in np.flatnonzero(model.geom_contype):
        kind, size = kinds(int(model.geom_type[geom])), model.geom_size[geom]
        down = data.geom_xmat[geom].reshape(3, 3)[2]
        if kind == kinds.mjGEOM_SPHERE:
            reach = size[0]
        elif kind == kinds.mjGEOM_CAPSULE:
            reach = abs(down[2]) * size[1] + size[0]
        elif kind == kinds.mjGEOM_CYLINDER:
            reach = abs(down[2]) * size[1] + math.hypot(down[0], down[1]) * size[0]
        elif kind == kinds.mjGEOM_BOX:
            reach = np.abs(down) @ size
        else:
            mesh = model.geom_dataid[geom]
            first = model.mesh_vertadr[mesh]
            reach = -(model.mesh_vert[first : first + model.mesh_vertnum[mesh]] @ down).min()
        heights.append(float(data.geom_xpos[geom, 2] - reach))
    return min(heights) if heights else float(data.xpos[1:, 2].min())


def floor_below(model: Any) -> float:
    """Return the height of a floor that a robot with a fixed base reaches in no key frame: 0, or whole mm below [m]."""
    data = mujoco.MjData(model)
    heights = [0.0]
    for key in range(model.nkey):
        mujoco.mj_resetDataKeyframe(model, data, key)
        mujoco.mj_kinematics(model, data)
        heights.append(lowest_point(model, data))
    return math.floor(1e3 * min(heights)) / 1e3


# --- Postures as key frames: the robot on its soles, or at rest.

# Name of the key frame of a robot without postures: all joints at zero, or at the limit nearest to it.
ZERO = "zero"


def add_keyframes(spec: Any, robot: RobotModel, bodies: Bodies, *, floating: bool) -> None:
    """Add a key frame for each posture, the initial one first; a floating root is set on the floor z = 0."""
    model = spec.compile()
    data = mujoco.MjData(model)
    start = robot.semantics.start
    names = sorted(robot.posture_names, key=lambda name: name != start)
    for name in names or [ZERO]:
        q = robot.posture(name) if names else robot.clamp(robot.neutral())
        values = joint_values(robot, q)
        data.qpos[:], data.ctrl[:] = model.qpos0, 0.0
        for joint in bodies.joints():
            _set_joint(model, data, joint, values)
        if floating:
            data.qpos[:7] = model.qpos0[:7]
            mujoco.mj_kinematics(model, data)
            rest = robot.semantics.postures[name].up if names else None
            up = _across_the_soles(data, robot, bodies) if rest is None else np.array(rest)
            R = rotation_between(up, [0.0, 0.0, 1.0], axis=[0.0, 1.0, 0.0])
            data.qpos[:7] = 0.0, 0.0, 0.0, *quat_from_matrix(R)
            mujoco.mj_kinematics(model, data)
            data.qpos[2] = -lowest_point(model, data)
        spec.add_key(name=name, qpos=data.qpos.tolist(), ctrl=data.ctrl.tolist())


def _set_joint(model: Any, data: Any, joint: BodyJoint, values: Mapping[str, Floats]) -> None:
    """Set the coordinates of a joint, and the controls that keep it there."""
    place = int(model.joint(joint.name).qposadr[0])
    if joint.kind == "ball":
        R = np.eye(3)
        for row, axis in zip(joint.rows, joint.axes, strict=True):
            R = R @ matrix_from_natural(axis, values[row.name])
        data.qpos[place : place + 4] = quat_from_matrix(R)
        for letter, value in zip("xyz", log(R), strict=True):
            data.actuator(f"{joint.name}_{letter}").ctrl = value
        return
    value = data.qpos[place] = values[joint.name]
    if joint.rows[0].mimic is None:
        data.actuator(joint.name).ctrl = value


def _across_the_soles(data: Any, robot: RobotModel, bodies: Bodies) -> Floats:
    """Return the sum of the soles' normals in the world of `data`; along z for a robot without soles."""
    normals = [np.array([0.0, 0.0, 1e-9])]
    for sole in robot.semantics.soles:
        body, T_sole = bodies.place(robot.tree.link_of(sole))
        normals.append(data.body(body.name).xmat.reshape(3, 3) @ T_sole.rotation[:, 2])
    return np.asarray(np.sum(normals, axis=0))


# --- Actuators.
#
# A URDF states the largest effort e and the largest speed v of a motor, and the semantics perhaps a stall torque, which
# the motor has for a moment. Three estimates complete the servo:
#
# - the effort e acts at an error of 1/60 rad (1/600 m for a sliding joint): kp = 60 e;
# - the effort e is used up at the largest speed, as that of an ideal DC motor: damping = e / v;
# - the rotor's inertia behind the gear is armature = 0.015 s · e / v: 0.007 kg m² for the NAO's knee, as for a rotor of
#   4 g cm² behind the published ratio of 130.85.
#
# The derivative gain makes the servo critically damped on its own rotor. The NAO's knee then follows its control 1/80 s
# later, as in B-Human's SimRobot (ServoMotor p="80": BHumanCodeRelease, Config/Scenes/Includes/NaoV6H25.rsi2).

# Estimates, not published.
FULL_EFFORT_ERROR = {"revolute": 1.0 / 60.0, "prismatic": 1.0 / 600.0}  # [rad, m]
ROTOR_TIME = 0.015  # armature / damping [s]
_NARROWEST = 1e-9  # half the range of a joint that cannot move [rad, m]
UNKNOWN_GAIN = 100.0  # where no effort is published [N m / rad, N / m]


@dataclass(frozen=True)
class Servo:
    """The parameters of a joint's motor, per unit of position or speed [N m, rad; or N, m]."""

    kp: float  # effort per error
    kv: float  # effort per speed of the controller
    damping: float  # viscous effort per speed of the joint
    armature: float  # inertia of the rotor behind the gear [kg m², or kg]
    effort: float  # largest effort, ∞ where none is published


def servo(row: UrdfJoint, stall: Mapping[str, float]) -> Servo:
    """Return the motor of a joint from published efforts and speed; infinite values and effort 0 are unknown."""
    effort = row.effort if 0.0 < row.effort < math.inf else math.inf
    known = effort < math.inf and row.velocity < math.inf
    slope = effort / row.velocity if known else 0.0
    armature = ROTOR_TIME * slope
    kp = effort / FULL_EFFORT_ERROR[row.kind] if effort < math.inf else UNKNOWN_GAIN
    kv = max(2.0 * math.sqrt(kp * armature) - slope, 0.0) if known else 0.1 * kp
    return Servo(kp, kv, row.damping + slope, armature, max(effort, stall.get(row.name, 0.0)))


def proper_range(lower: float, upper: float) -> tuple[float, float]:
    """Return limits for MuJoCo, which would ignore a range of zero width or with one end, and let the joint move."""
    lower, upper = max(lower, -UNBOUNDED), min(upper, UNBOUNDED)
    return (lower, upper) if lower < upper else (lower - _NARROWEST, upper + _NARROWEST)


def add_actuators(spec: Any, joints: Iterable[BodyJoint]) -> tuple[str, ...]:
    """Add a position actuator for each joint that is not a mimic joint; return a line on joints without effort.

    A ball has three, with the suffixes _x, _y, _z, because MuJoCo measures it by its rotation vector: their controls
    are the rotation vector of the wanted orientation in the frame of the joint (`nao_kin.rotations.log`).
    """
    unknown = []
    for joint in joints:
        motor = joint.motor
        if joint.kind == "ball":
            for place, letter in enumerate("xyz"):
                _add_actuator(spec, f"{joint.name}_{letter}", joint.name, motor, (-math.pi, math.pi), place)
        elif joint.rows[0].mimic is None:
            _add_actuator(spec, joint.name, joint.name, motor, (joint.rows[0].lower, joint.rows[0].upper))
        else:
            continue
        if motor.effort == math.inf:
            unknown.append(joint.name)
    note = f"no effort is published for {', '.join(unknown)}: force without bounds, gain {UNKNOWN_GAIN:g}"
    return (note,) if unknown else ()


def _add_actuator(spec: Any, name: str, joint: str, motor: Servo, allowed: tuple[float, float], axis: int = 0) -> None:
    added = spec.add_actuator(name=name, target=joint, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    added.set_to_position(kp=motor.kp, kv=motor.kv)
    added.gear = np.eye(6)[axis]
    if any(map(math.isfinite, allowed)):
        added.ctrlrange = proper_range(*allowed)
    if motor.effort < math.inf:
        added.forcerange = (-motor.effort, motor.effort)


# --- Sites, cameras and sensors at the frames of a robot.

_FRAME_GROUP, _SENSOR_GROUP = 4, 3
_DOT = 0.005
# Cameras look along x with z up; MuJoCo's look along −z with y up.
_R_FRAME_CAMERA = np.array([[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
_IMAGE_HEIGHT = 480
# A force sensor measures contacts within this height [m].
_FELT = 0.01


def add_sites(
    spec: Any, added: list[Any], bodies: Bodies, tree: UrdfTree, semantics: Semantics, frames: str
) -> tuple[str, ...]:
    """Add a site for each link that is not a body, a camera for each camera, and all sensors; return the differences.

    `frames` selects the links with sites: "all", "effectors" for those in the semantics, "none" for sensors only.
    """
    felt = {tree.link_of(name) for name in semantics.force_sensors}
    sensing = {tree.link_of(name) for name in (*semantics.accelerometers, *semantics.gyrometers)} | felt
    named = {tree.link_of(name) for name in semantics.frames()}
    wanted = {"all": set(tree.links), "effectors": named | sensing, "none": sensing}[frames]
    for body, one in zip(bodies.bodies, added, strict=True):
        sizes = _felt_sizes({link: T for link, T in body.links.items() if link in felt})
        for link, T in body.links.items():
            if link not in sensing and (link not in wanted or link == body.name or link in bodies.between):
                continue
            site = one.add_site(name=link, group=_SENSOR_GROUP if link in sensing else _FRAME_GROUP, **pos_quat(T))
            site.size = [_DOT] * 3
            if link in sizes:
                site.type, site.size = mujoco.mjtGeom.mjGEOM_BOX, sizes[link].tolist()
    _add_sensors(spec, bodies, tree, semantics)
    return _add_cameras(added, bodies, tree, semantics)


def _felt_sizes(places: dict[str, pin.SE3]) -> dict[str, Floats]:
    """Return half lengths of a box about each force sensor; boxes do not overlap, so one sensor feels each contact."""
    sizes = {}
    for link, T in places.items():
        others = np.array([T.actInv(other).translation for name, other in places.items() if name != link])
        half = np.full(3, _FELT)
        for axis in (0, 1):
            # Neighbours along an axis are farther along it than across.
            along = [abs(p[axis]) for p in others if abs(p[axis]) > abs(p[1 - axis])]
            half[axis] = 0.5 * min(along) if along else 0.1
        sizes[link] = half
    return sizes


def _add_sensors(spec: Any, bodies: Bodies, tree: UrdfTree, semantics: Semantics) -> None:
    kinds, objects = mujoco.mjtSensor, mujoco.mjtObj

    def add(name: str, kind: Any, what: Any, of: str) -> None:
        spec.add_sensor(name=name, type=kind, objtype=what, objname=of)

    for names, kind, word in (
        (semantics.accelerometers, kinds.mjSENS_ACCELEROMETER, "acceleration"),
        (semantics.gyrometers, kinds.mjSENS_GYRO, "angular_velocity"),
        (semantics.force_sensors, kinds.mjSENS_TOUCH, "force"),
    ):
        for name in names:
            add(f"{name}_{word}", kind, objects.mjOBJ_SITE, tree.link_of(name))
    root = bodies.bodies[0].name
    add(f"{root}_orientation", kinds.mjSENS_FRAMEQUAT, objects.mjOBJ_XBODY, root)
    for joint in bodies.joints():
        measured = {"position": kinds.mjSENS_JOINTPOS, "velocity": kinds.mjSENS_JOINTVEL}
        if joint.kind == "ball":
            measured = {"orientation": kinds.mjSENS_BALLQUAT, "angular_velocity": kinds.mjSENS_BALLANGVEL}
        for word, kind in measured.items():
            add(f"{joint.name}_{word}", kind, objects.mjOBJ_JOINT, joint.name)


def _add_cameras(added: list[Any], bodies: Bodies, tree: UrdfTree, semantics: Semantics) -> tuple[str, ...]:
    changes = []
    for name in semantics.cameras:
        body, T = bodies.place(tree.link_of(name))
        one = added[bodies.bodies.index(body)]
        camera = one.add_camera(name=name, **pos_quat(T * pin.SE3(_R_FRAME_CAMERA, np.zeros(3))))
        if name in semantics.fields_of_view:
            horizontal, vertical = semantics.fields_of_view[name]
            camera.fovy = math.degrees(vertical)
            ratio = math.tan(0.5 * horizontal) / math.tan(0.5 * vertical)
            camera.resolution = [2 * round(0.5 * _IMAGE_HEIGHT * ratio), _IMAGE_HEIGHT]  # video needs even numbers
        else:
            changes.append(f"the field of view of {name} is unknown: MuJoCo's default, 45° vertically")
    return tuple(changes)
