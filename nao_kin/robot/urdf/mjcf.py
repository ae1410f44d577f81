"""The tree of an MJCF: bodies become links, coordinates become joints, sites and cameras become fixed links."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin._core.text import abbreviated, fresh_name, quoted
from nao_kin.errors import BadModel
from nao_kin.robot.semantics import Mimic, Posture, Semantics
from nao_kin.robot.urdf.couplings import Refused, drive_order, resolve_chains, share_limits
from nao_kin.robot.urdf.document import checked_folders, file_content, root_tag
from nao_kin.robot.urdf.mjcf_compiled import Compiled, Shapes, compile_mjcf, import_mujoco, pose, translation
from nao_kin.robot.urdf.tree import Inertial, Origin, UrdfJoint, UrdfTree, rename_links
from nao_kin.rotations import euler_from_matrix

# --- The bodies of the robot: files also contain floors, tables and objects to grasp.

WORLD = 0


def robot_of(model: Any, notes: list[str]) -> tuple[int, list[int]]:
    """Return the root body of the robot, and all its bodies in order, root included; a note names omitted bodies.

    The robot is the child of the world with the most joints. It is the root if it floats (a free joint), or if it is
    fixed and alone in the world. Otherwise the world is the root, and all bodies that do not float belong to the robot.
    """
    if model.nbody < 2:
        raise ValueError("no bodies")
    members: dict[int, list[int]] = {}
    for body, top in enumerate(model.body_rootid.tolist()):
        if body != WORLD:
            members.setdefault(top, []).append(body)
    mocap = {body for body in members if int(model.body_mocapid[body]) >= 0}
    candidates = {body: bodies for body, bodies in members.items() if body not in mocap} or members
    joints = {body: sum(int(model.body_jntnum[one]) for one in bodies) for body, bodies in candidates.items()}
    anchored = [body for body in candidates if free_joint(model, body) is None]
    main = max(candidates, key=lambda body: (joints[body] - (body not in anchored), len(candidates[body]), -body))
    if main not in anchored:
        chosen, root = [main], main
        notes.append(f"body {quoted(_name(model, main))} has a free joint: base='floating' gives it a free base")
    elif anchored == [main] and not int(model.body_jntnum[main]):
        chosen, root = anchored, main
        _note_place(model, main, notes)
    else:
        chosen, root = anchored, WORLD
    left_out = [body for body in members if body not in chosen]
    if left_out:
        names = abbreviated(", ".join(_name(model, body) for body in left_out), 100)
        notes.append(f"left out, not part of the robot: {names}")
    bodies = sorted(body for one in chosen for body in members[one])
    return root, bodies if root != WORLD else [WORLD, *bodies]


def _name(model: Any, body: int) -> str:
    return str(model.body(body).name) or f"body_{body}"


def _note_place(model: Any, body: int, notes: list[str]) -> None:
    """Add a note on the pose of a root in the world, which the tree does not contain."""
    T = pose(model.body_pos[body], model.body_quat[body])
    if not np.allclose(T, np.eye(4), atol=1e-12):
        place = " ".join(f"{float(value):.4g}" for value in model.body_pos[body])
        turned = "" if np.allclose(T[:3, :3], np.eye(3), atol=1e-12) else ", turned,"
        notes.append(
            f"{quoted(_name(model, body))} is at {place}{turned} in the world; poses are relative to its frame"
        )


# --- The joints of MuJoCo's bodies as a sequence of joints with one coordinate each.
#
# A body of MuJoCo has a pose in its parent body and is moved by its joints in their order: about an axis through an
# anchor (hinge), along an axis (slide), or freely about the anchor (ball). A joint's value is measured from `ref`.

FREE, BALL, SLIDE, HINGE = range(4)
"""The kinds of joints, as `mujoco.mjtJoint` numbers them."""

_AXES = (("x", (1.0, 0.0, 0.0)), ("y", (0.0, 1.0, 0.0)), ("z", (0.0, 0.0, 1.0)))
# The kinds of actuators that act on a joint, as `mujoco.mjtTrn` numbers them.
_ON_JOINTS = (0, 1)


class JointCoordinate(NamedTuple):
    """One coordinate of a MuJoCo joint."""

    id: int  # of the joint in MuJoCo
    part: int  # 0, 1, 2 for the three turns of a ball joint about x, y, z; otherwise 0
    joint: UrdfJoint  # its description without names of links; its own name is "" if the file gives none
    is_ball: bool  # whether it is part of a ball joint


def joint_coordinates(model: Any, body: int) -> tuple[list[JointCoordinate], Floats]:
    """Return the coordinates that move a body, in order, except a free joint's, and its pose in the last one."""
    T = pose(model.body_pos[body], model.body_quat[body])
    found: list[JointCoordinate] = []
    first = int(model.body_jntadr[body])
    for joint in range(first, first + int(model.body_jntnum[body])):
        kind = int(model.jnt_type[joint])
        if kind == FREE:
            continue
        name, anchor = str(model.joint(joint).name), np.array(model.jnt_pos[joint])
        if kind == BALL:
            T = T @ translation(anchor)
            limits = _ball_limits(model, joint)
            for part, ((letter, axis), limit) in enumerate(zip(_AXES, limits, strict=True)):
                label = f"{name}_{letter}" if name else ""
                turn = UrdfJoint(label, "revolute", "", "", Origin.of(T), axis, -limit, limit)
                found.append(JointCoordinate(joint, part, turn, is_ball=True))
                T = np.eye(4)
            T = translation(-anchor)
            continue
        ref = float(model.qpos0[model.jnt_qposadr[joint]])
        x, y, z = (float(value) for value in model.jnt_axis[joint])
        limited = bool(model.jnt_limited[joint])
        lower, upper = (float(value) for value in model.jnt_range[joint]) if limited else (-math.inf, math.inf)
        if math.isfinite(lower) and math.isfinite(upper) and math.isinf(upper - lower):
            lower, upper = -math.inf, math.inf  # a range that overflows
        moving, by = ("prismatic", np.zeros(3)) if kind == SLIDE else ("revolute", anchor)
        single = UrdfJoint(name, moving, "", "", Origin(), (x, y, z), lower, upper)
        place = Origin.of(T @ translation(by) @ single.travel(-ref))
        found.append(JointCoordinate(joint, 0, replace(single, origin=place), is_ball=False))
        T = translation(-by)
    return found, T


def free_joint(model: Any, body: int) -> int | None:
    """Return the free joint of a body, None without one."""
    joint = int(model.body_jntadr[body])
    return joint if joint >= 0 and int(model.jnt_type[joint]) == FREE else None


def _ball_limits(model: Any, joint: int) -> tuple[float, float, float]:
    """Return limits of the turns about x, y and z: the smallest box that contains all rotations the joint allows."""
    if not model.jnt_limited[joint]:
        return math.inf, math.inf, math.inf
    largest = float(model.jnt_range[joint, 1])
    # If the total turn is at most a right angle, none of the three turns exceeds it.
    return (largest, largest, largest) if largest <= math.pi / 2 else (math.inf, math.pi / 2, math.inf)


def efforts(model: Any) -> dict[int, float]:
    """Return joint → the largest torque or force of its actuators, if the file limits it."""
    strongest: dict[int, float] = {}
    for actuator in range(len(model.actuator_trntype)):
        if int(model.actuator_trntype[actuator]) in _ON_JOINTS:
            joint = int(model.actuator_trnid[actuator, 0])
            strongest[joint] = strongest.get(joint, 0.0) + _strongest(model, actuator)
    for joint in range(int(model.njnt)):
        if model.jnt_actfrclimited[joint]:
            bound = float(np.abs(model.jnt_actfrcrange[joint]).max())
            strongest[joint] = min(bound, strongest.get(joint, math.inf))
    return {joint: effort for joint, effort in strongest.items() if math.isfinite(effort)}


def _strongest(model: Any, actuator: int) -> float:
    """Return the largest force of one actuator at its joint; infinite if the file does not limit it."""
    gear = abs(float(model.actuator_gear[actuator, 0]))
    if model.actuator_forcelimited[actuator]:
        return gear * float(np.abs(model.actuator_forcerange[actuator]).max())
    # Since MuJoCo 4 an actuator may have several controls, or none.
    control = int(model.actuator_ctrladr[actuator]) if hasattr(model, "actuator_ctrladr") else actuator
    is_motor = not model.actuator_gaintype[actuator] and not model.actuator_biastype[actuator] and control >= 0
    if is_motor and model.actuator_ctrllimited[control]:
        gain = abs(float(model.actuator_gainprm[actuator, 0]))
        return gear * gain * float(np.abs(model.actuator_ctrlrange[control]).max())
    return math.inf


# --- The equality constraints between joints as couplings; other constraints as notes.

# Kinds of equality constraints, as `mujoco.mjtEq` numbers them.
_JOINT = 2
_KINDS = {0: "connect", 1: "weld", 3: "tendon", 4: "flex"}


@dataclass
class Couplings:
    """The couplings between joints: follower → its driver, and locked joint → its value."""

    mimics: dict[str, Mimic] = field(default_factory=dict)
    locked: dict[str, float] = field(default_factory=dict)

    def follow(self, name: str, mimic: Mimic) -> bool:
        """Make a joint follow another one, or the reverse if it already follows one; False if neither is possible."""
        if self._leads_to(mimic.joint, name):
            return False
        if name not in self.mimics and name not in self.locked:
            self.mimics[name] = mimic
            return True
        if mimic.joint not in self.mimics and mimic.joint not in self.locked and not self._leads_to(name, mimic.joint):
            self.mimics[mimic.joint] = mimic.inverted(name)
            return True
        return False

    def lock_followers(self, notes: list[str]) -> None:
        """Lock the joints that follow a locked one, with a note for each."""
        while held := [name for name, mimic in self.mimics.items() if mimic.joint in self.locked]:
            for name in held:
                mimic = self.mimics.pop(name)
                self.locked[name] = value = float(mimic.value(self.locked[mimic.joint]))
                notes.append(
                    f"joint {quoted(name)} follows {quoted(mimic.joint)}, which is locked: fixed at {value:.6g}"
                )

    def _leads_to(self, name: str, end: str) -> bool:
        """Return whether the chain of mimics that starts at a joint passes another one."""
        while name != end and name in self.mimics:
            name = self.mimics[name].joint
        return name == end


def read_couplings(model: Any, names: Mapping[int, str], notes: list[str]) -> Couplings:
    """Return the couplings between joints, given by id → name; notes are added on constraints that are left out.

    MuJoCo constrains y − y₀ = a₀ + a₁ (x − x₀) + … + a₄ (x − x₀)⁴ for the values x and y of two joints and their `ref`.
    """
    couplings, left_out = Couplings(), Counter[str]()
    for row in range(int(model.neq)):
        kind = int(model.eq_type[row])
        if not model.eq_active0[row]:
            left_out["inactive"] += 1
        elif kind != _JOINT:
            left_out[_KINDS.get(kind, "other")] += 1
        elif (first := int(model.eq_obj1id[row])) in names:
            second = int(model.eq_obj2id[row])
            if second in names or second < 0:
                _couple(model, row, names[first], names.get(second, ""), couplings, notes)
            else:
                notes.append(f"joint {quoted(names[first])} is coupled to a joint outside the robot: left out")
    couplings.lock_followers(notes)
    if left_out:
        kinds = ", ".join(f"{count} {kind}" for kind, count in left_out.items())
        notes.append(f"equality constraints left out, so that their joints move independently: {kinds}")
    return couplings


def _couple(model: Any, row: int, name: str, driver: str, couplings: Couplings, notes: list[str]) -> None:
    """Convert one constraint between two joints, or on a single joint."""
    constant, slope, *higher = (float(value) for value in model.eq_data[row, :5])
    y = float(model.qpos0[model.jnt_qposadr[model.eq_obj1id[row]]])
    if driver and any(higher):
        notes.append(
            f"joint {quoted(name)} follows {quoted(driver)} by a curve of degree "
            f"{max(n for n, value in enumerate(higher, 2) if value)}: taken as independent"
        )
    elif driver and slope:
        x = float(model.qpos0[model.jnt_qposadr[model.eq_obj2id[row]]])
        if not couplings.follow(name, Mimic(driver, slope, y + constant - slope * x)):
            notes.append(
                f"joint {abbreviated(name)} is coupled to {abbreviated(driver)} by a second constraint: left out"
            )
    elif name in couplings.mimics:
        notes.append(f"joint {abbreviated(name)} is locked and follows another joint: the lock is left out")
    else:
        couplings.locked[name] = y + constant
        notes.append(f"joint {quoted(name)} is locked at {y + constant:.6g}: taken as fixed")


# --- The tree.

_FIXED_CAMERA = 0  # as `mujoco.mjtCamLight` numbers them


def read_mjcf(
    path: Path | str, *, package_dirs: Iterable[Path | str] = (), content: bytes | None = None
) -> tuple[UrdfTree, Semantics]:
    """Return the tree of an MJCF file, compiled by MuJoCo, and its cameras, keyframes and sensors as semantics."""
    content, path = file_content(path) if content is None else content, Path(path).absolute()
    tag = root_tag(path, content)
    if tag != "mujoco":
        other = "; it is a URDF, which RobotModel.from_urdf reads" if tag == "robot" else ""
        raise BadModel(f"{path}: the root element is <{abbreviated(tag)}>, an MJCF has <mujoco>{other}")
    notes: list[str] = []
    folders = checked_folders(package_dirs)
    compiled = compile_mjcf(path, content, folders, notes)
    try:
        tree, semantics = _MjcfReader(compiled, path, notes).read()
    except (Refused, ValueError) as error:
        raise BadModel(f"{path}: {error}") from None
    return replace(tree, package_dirs=folders), semantics


class _MjcfReader:
    """The conversion of one file into a tree."""

    def __init__(self, compiled: Compiled, path: Path, notes: list[str]) -> None:
        self.compiled, self.model, self.path, self.notes = compiled, compiled.model, path, notes
        self.root, self.bodies = robot_of(self.model, notes)
        self.base = free_joint(self.model, self.root)
        # Body → its coordinates, and its pose in the frame of the last coordinate.
        self.chains = {body: joint_coordinates(self.model, body) for body in self.bodies if body != self.root}
        self.taken = set[str]()
        # Site with an unchanged name → its body, and its pose in the frame of that body.
        self.placed: dict[str, tuple[int, Floats]] = {}

    def read(self) -> tuple[UrdfTree, Semantics]:
        """Return the tree and the semantics."""
        model = self.model
        given = {body: str(model.body(body).name) for body in self.bodies}
        self.taken |= {name for name in given.values() if name}
        body_names = {body: name or self._unused_name(f"body_{body}", "") for body, name in given.items()}
        self._name_coordinates(body_names)
        coordinates = [coordinate for chain, _ in self.chains.values() for coordinate in chain]
        shared = rename_links(body_names.values(), (coordinate.joint.name for coordinate in coordinates), self.notes)
        self.taken |= {*shared.values()}
        self.links = {body: shared.get(name, name) for body, name in body_names.items()}
        scalar = {coordinate.id: coordinate.joint.name for coordinate in coordinates if not coordinate.is_ball}
        self.couplings = read_couplings(model, scalar, self.notes)
        joints = self._moving_joints()
        sites = self._frames("site", range(int(model.nsite)), joints)
        cameras = self._frames("camera", self._fixed_cameras(), joints)
        resolved = resolve_chains({joint.name: joint for joint in joints}, self.notes)
        root = self.links[self.root]
        ordered = share_limits(drive_order(resolved, root), self.notes)
        own = {joint.name: joint for joint in ordered if joint.kind != "fixed" and joint.mimic is None}
        unlimited = [name for name, joint in own.items() if np.isinf(joint.upper - joint.lower)]
        if unlimited:
            self.notes.append(f"joints without limits: {abbreviated(', '.join(unlimited))}")
        moving = [coordinate for coordinate in coordinates if coordinate.joint.name in own]
        semantics, shapes = self._semantics(moving, cameras, sites), Shapes(self.compiled, self.links, self.path)
        tree = UrdfTree(
            path=self.path,
            name=self.compiled.name or self.path.stem,
            root=root,
            links=(root, *(joint.child for joint in joints)),
            inertials={
                name: self._inertial(body) for body, name in self.links.items() if body and self.compiled.has_mass(body)
            },
            joints=tuple(ordered),
            visuals=shapes.visuals,
            shared_names=shared,
            notes=tuple(self.notes),
            visual_notes=shapes.visual_notes,
            collisions=shapes.collisions,
        )
        return tree, semantics

    def _name_coordinates(self, bodies: dict[int, str]) -> None:
        """Give coordinates without a name the names of their bodies, and rename balls that share a name."""
        every = [coordinate for chain, _ in self.chains.values() for coordinate in chain]
        self.taken |= {coordinate.joint.name for coordinate in every if coordinate.joint.name}
        single = {coordinate.joint.name for coordinate in every if not coordinate.is_ball}
        for body, (chain, _) in self.chains.items():
            for place, coordinate in enumerate(chain):
                name = coordinate.joint.name or self._unused_name(bodies[body], "_joint")
                if coordinate.is_ball and name in single:
                    name = self._unused_name(name, "_ball")
                chain[place] = coordinate._replace(joint=replace(coordinate.joint, name=name))

    def _moving_joints(self) -> list[UrdfJoint]:
        """Return the joints, with additional links between the joints of one body."""
        joints: list[UrdfJoint] = []
        strength = efforts(self.model)
        for body, (chain, T_last_body) in self.chains.items():
            parent = self.links[int(self.model.body_parentid[body])]
            ends_here = bool(chain) and np.array_equal(T_last_body, np.eye(4))
            for count, coordinate in enumerate(chain, 1):
                last = ends_here and count == len(chain)
                child = self.links[body] if last else self._unused_name(coordinate.joint.name, "_link")
                joint = replace(coordinate.joint, parent=parent, child=child)
                joints.append(self._joint(coordinate, joint, strength))
                parent = child
            if not ends_here:
                joints.append(self._fixed(parent, self.links[body], T_last_body))
            self._note_ball(chain)
        return joints

    def _joint(self, coordinate: JointCoordinate, joint: UrdfJoint, strength: dict[int, float]) -> UrdfJoint:
        """Return the joint of a coordinate, with its coupling, lock, effort, damping and friction."""
        if joint.name in self.couplings.locked:
            T = joint.origin.matrix @ joint.travel(self.couplings.locked[joint.name])
            return UrdfJoint(joint.name, "fixed", joint.parent, joint.child, Origin.of(T))
        dof = int(self.model.jnt_dofadr[coordinate.id]) + coordinate.part
        return replace(
            joint,
            effort=strength.get(coordinate.id, math.inf),
            damping=float(self.model.dof_damping[dof]),
            friction=float(self.model.dof_frictionloss[dof]),
            mimic=self.couplings.mimics.get(joint.name),
        )

    def _frames(self, kind: str, ids: Any, joints: list[UrdfJoint]) -> dict[int, str]:
        """Add sites or cameras as fixed links, and return id → name of those that have a name."""
        prefix = "cam" if kind == "camera" else kind
        bodies = getattr(self.model, f"{prefix}_bodyid")
        found, renamed = dict[int, str](), list[str]()
        for index in ids:
            name, body = str(getattr(self.model, kind)(index).name), int(bodies[index])
            if not name or body not in self.links:
                continue
            T = pose(getattr(self.model, f"{prefix}_pos")[index], getattr(self.model, f"{prefix}_quat")[index])
            if kind == "camera":
                T[:3, :3] = T[:3, :3] @ _R_CAMERA_FRAME
            placed = self.placed.get(name)
            if placed is not None and placed[0] == body and np.allclose(placed[1], T, rtol=0.0, atol=1e-9):
                found[index] = name  # a camera at a site of the same name shares one frame with it
                continue
            if name in self.taken:
                renamed.append(name)
                found[index] = self._unused_name(name, f"_{kind}")
            else:
                self.taken.add(name)
                self.placed[name] = body, T
                found[index] = name
            joints.append(self._fixed(self.links[body], found[index], T))
        if renamed:
            names = abbreviated(", ".join(renamed), 100)
            self.notes.append(f"{len(renamed)} {kind}s are renamed …_{kind}, because their names are taken: {names}")
        return found

    def _fixed_cameras(self) -> list[int]:
        """Return the cameras that do not track a body."""
        modes = [int(mode) for mode in self.model.cam_mode]
        fixed = [camera for camera, mode in enumerate(modes) if mode == _FIXED_CAMERA]
        if len(fixed) < len(modes):
            self.notes.append(f"tracking cameras left out: {len(modes) - len(fixed)}")
        return fixed

    def _fixed(self, parent: str, child: str, T: Floats) -> UrdfJoint:
        return UrdfJoint(self._unused_name(child, "_fixed"), "fixed", parent, child, Origin.of(T))

    def _inertial(self, body: int) -> Inertial:
        a, b, c = (float(moment) for moment in self.model.body_inertia[body])
        place = Origin.of(pose(self.model.body_ipos[body], self.model.body_iquat[body]))
        return Inertial(float(self.model.body_mass[body]), place, (a, 0.0, 0.0, b, 0.0, c))

    def _note_ball(self, chain: list[JointCoordinate]) -> None:
        for place, coordinate in enumerate(chain):
            if coordinate.part == 2:
                three = ", ".join(quoted(turn.joint.name) for turn in chain[place - 2 : place + 1])
                limit = "; its limit on the angle applies to each" if self.model.jnt_limited[coordinate.id] else ""
                self.notes.append(
                    f"ball joint {quoted(str(self.model.joint(coordinate.id).name))} made of three about x, y and z: "
                    f"{three}{limit}"
                )

    def _semantics(self, own: list[JointCoordinate], cameras: Mapping[int, str], sites: Mapping[int, str]) -> Semantics:
        """Return cameras and sensors as frames, and named keyframes as postures, of which the first is the start."""
        model, base, postures = self.model, self.base, dict[str, Posture]()
        for key in range(int(model.nkey)):
            name, q = str(model.key(key).name), model.key_qpos[key]
            if name:
                angles = {coordinate.joint.name: _value(model, q, coordinate) for coordinate in own}
                if not all(map(math.isfinite, angles.values())):
                    raise ValueError(f"keyframe {quoted(name)} is not finite")
                postures[name] = Posture(angles, None if base is None else _up(q[model.jnt_qposadr[base] :][3:7]))
        unnamed = int(model.nkey) - len(postures)
        if unnamed:
            self.notes.append(f"keyframes without a name left out: {unnamed}")
        return Semantics(
            cameras=tuple(cameras.values()),
            fields_of_view=_fields_of_view(model, cameras),
            postures=postures,
            start=next(iter(postures), ""),
            **_sensor_frames(model, sites),
        )

    def _unused_name(self, name: str, *endings: str) -> str:
        fresh = fresh_name(name, self.taken, *endings)
        self.taken.add(fresh)
        return fresh


# --- Cameras, keyframes and sensors as semantics.

_R_CAMERA_FRAME = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]])
"""Axes of our camera frames in MuJoCo's: our cameras look along x with z up, MuJoCo's along −z with y up."""

# Sensors at a site, by their names in `mujoco.mjtSensor`.
_SENSORS = {"mjSENS_ACCELEROMETER": "accelerometers", "mjSENS_GYRO": "gyrometers", "mjSENS_TOUCH": "force_sensors"}
# A base is upright if it is tilted by less than this [rad].
_UPRIGHT = 1e-6


def _fields_of_view(model: Any, cameras: Mapping[int, str]) -> dict[str, tuple[float, float]]:
    """Return camera → horizontal and vertical field of view [rad], for cameras with a known aspect ratio."""
    found = {}
    for camera, name in cameras.items():
        width, height = (float(size) for size in model.cam_sensorsize[camera])
        columns, rows = (int(count) for count in model.cam_resolution[camera])
        vertical = math.radians(float(model.cam_fovy[camera]))
        if width > 0.0 and height > 0.0:
            focal = [float(length) for length in model.cam_intrinsic[camera, :2]]
            fields = tuple(2.0 * math.atan2(size, 2.0 * f) for size, f in zip((width, height), focal, strict=True))
        elif columns > 1 and rows > 1:
            fields = (2.0 * math.atan(math.tan(vertical / 2.0) * columns / rows), vertical)
        else:
            continue
        if all(0.0 < angle < math.pi for angle in fields):
            found[name] = (fields[0], fields[1])
    return found


def _sensor_frames(model: Any, sites: Mapping[int, str]) -> dict[str, Any]:
    """Return the frames of accelerometers, gyrometers and force sensors, by the fields of `Semantics`."""
    kinds = {int(getattr(import_mujoco().mjtSensor, name)): part for name, part in _SENSORS.items()}
    found: dict[str, list[str]] = {}
    for sensor in range(int(model.nsensor)):
        part, site = kinds.get(int(model.sensor_type[sensor])), int(model.sensor_objid[sensor])
        if part and site in sites and sites[site] not in found.get(part, []):
            found.setdefault(part, []).append(sites[site])
    return {part: tuple(frames) for part, frames in found.items()}


def _value(model: Any, q: Floats, coordinate: JointCoordinate) -> float:
    """Return the value of one coordinate in a configuration of MuJoCo."""
    first = int(model.jnt_qposadr[coordinate.id])
    if not coordinate.is_ball:
        return float(q[first])
    turns = euler_from_matrix(pose((0.0, 0.0, 0.0), q[first : first + 4])[:3, :3], "xyz", axes="moving").angles
    return float(turns[coordinate.part])


def _up(quaternion: Floats) -> tuple[float, float, float] | None:
    """Return the vertical in the axes of a base; None if the base is upright."""
    x, y, z = (float(component) for component in pose((0.0, 0.0, 0.0), quaternion)[2, :3])
    return None if math.hypot(x, y) < _UPRIGHT and z > 0.0 else (x, y, z)
