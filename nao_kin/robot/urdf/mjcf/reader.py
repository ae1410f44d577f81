"""An MJCF as a tree: bodies as links, each coordinate of each joint as a joint, sites and cameras as fixed links."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin._core.text import abbreviated, fresh_name, quoted
from nao_kin.errors import BadModel
from nao_kin.robot.semantics import Semantics
from nao_kin.robot.urdf.couplings import Refused, drive_order, resolve_chains, share_limits
from nao_kin.robot.urdf.document import checked_folders, file_content, root_tag
from nao_kin.robot.urdf.mjcf.compiled import Compiled, Shapes, compile_mjcf, import_mujoco
from nao_kin.robot.urdf.mjcf.joints import (
    R_CAMERA_FRAME,
    Couplings,
    Motion,
    efforts,
    free_joint,
    motions,
    origin,
    pose,
    read_couplings,
    semantics_of,
)
from nao_kin.robot.urdf.tree import Inertial, UrdfJoint, UrdfTree, names_apart

# --- Which bodies of an MJCF are the robot: files hold floors, tables and things to grasp beside it.

WORLD = 0


def robot_of(model: Any, notes: list[str]) -> tuple[int, list[int]]:
    """The root body of the robot, and all its bodies in order, the root among them.

    The robot is what moves most: the body of the world with most joints on it. Where that one floats (a free joint), or
    stands still as the only one of the world, it is the root, as in a URDF. Else the world is, and with it come all
    bodies that do not float.

    Args:
        model: the `mujoco.MjModel`.
        notes: gets a line for what is left out.

    Raises:
        ValueError: there are no bodies.
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
    standing = [body for body in candidates if free_joint(model, body) is None]
    main = max(candidates, key=lambda body: (joints[body] - (body not in standing), len(candidates[body]), -body))
    if main not in standing:
        chosen, root = [main], main
        notes.append(f"body {quoted(_name(model, main))} has a free joint: base='floating' gives it a free base")
    elif standing == [main] and not int(model.body_jntnum[main]):
        chosen, root = standing, main
        _note_place(model, main, notes)
    else:
        chosen, root = standing, WORLD
    left_out = [body for body in members if body not in chosen]
    if left_out:
        names = abbreviated(", ".join(_name(model, body) for body in left_out), 100)
        notes.append(f"left out, for they are not the robot's: {names}")
    bodies = sorted(body for one in chosen for body in members[one])
    return root, bodies if root != WORLD else [WORLD, *bodies]


def _name(model: Any, body: int) -> str:
    return str(model.body(body).name) or f"body_{body}"


def _note_place(model: Any, body: int, notes: list[str]) -> None:
    """Say where a root stands in the world, which the tree does not keep."""
    T = pose(model.body_pos[body], model.body_quat[body])
    if not np.allclose(T, np.eye(4), atol=1e-12):
        place = " ".join(f"{float(value):.4g}" for value in model.body_pos[body])
        turned = "" if np.allclose(T[:3, :3], np.eye(3), atol=1e-12) else ", turned,"
        notes.append(
            f"{quoted(_name(model, body))} stands at {place}{turned} in the world; poses are given in its own frame"
        )


# --- An MJCF as a tree: bodies as links, each coordinate of each joint as a joint, sites and cameras as fixed links.

_FIXED_CAMERA = 0  # as `mujoco.mjtCamLight` numbers them


def read_mjcf(path: Path | str, *, package_dirs: Iterable[Path | str] = ()) -> tuple[UrdfTree, Semantics]:
    """Read an MJCF file through MuJoCo's own parser and compiler.

    Args:
        path: the file.
        package_dirs: folders to search for meshes that are not where the file says.

    Returns:
        The tree, and what the file says beyond it: cameras, keyframes as postures, sensors.

    Raises:
        MissingExtra: MuJoCo is not installed.
        BadModel: the file cannot be read, is no MJCF, is refused by MuJoCo, or holds no body.
        BadArgument: a folder that is not there.
    """
    return mjcf_tree(path, file_content(path), package_dirs)


def mjcf_tree(path: Path | str, content: bytes, package_dirs: Iterable[Path | str]) -> tuple[UrdfTree, Semantics]:
    """As `read_mjcf`, of a file that has been read."""
    tag = root_tag(path, content)
    if tag != "mujoco":
        other = "; it is a URDF, which RobotModel.from_urdf reads" if tag == "robot" else ""
        raise BadModel(f"{path}: the root element is <{abbreviated(tag)}>, an MJCF has <mujoco>{other}")
    notes: list[str] = []
    folders = checked_folders(package_dirs)
    compiled = compile_mjcf(Path(path), content, folders, notes)
    try:
        tree, semantics = _Reader(compiled, Path(path), notes).read()
    except (Refused, ValueError) as error:
        raise BadModel(f"{path}: {error}") from None
    return replace(tree, package_dirs=folders), semantics


class _Reader:
    """One file on its way into a tree."""

    def __init__(self, compiled: Compiled, path: Path, notes: list[str]) -> None:
        self.compiled, self.model, self.path, self.notes = compiled, compiled.model, path, notes
        self.root, self.bodies = robot_of(self.model, notes)
        self.base = free_joint(self.model, self.root)
        # Body → its motions, and its pose in the frame of the last one.
        self.moves = {body: motions(self.model, body) for body in self.bodies if body != self.root}
        self.taken = set[str]()
        # Site that has its own name → its body, and its pose there.
        self.placed: dict[str, tuple[int, Floats]] = {}

    def read(self) -> tuple[UrdfTree, Semantics]:
        """The tree and the semantics."""
        model = self.model
        body_names = self._body_names()
        self._name_motions(body_names)
        motions = [motion for moves, _ in self.moves.values() for motion in moves]
        shared = names_apart(body_names.values(), (motion.joint.name for motion in motions), self.notes)
        self.taken |= {*shared.values()}
        self.links = {body: shared.get(name, name) for body, name in body_names.items()}
        scalar = {motion.id: motion.joint.name for motion in motions if not motion.is_ball}
        joints = self._moving_joints(read_couplings(model, scalar, self.notes))
        sites = self._frames("site", range(int(model.nsite)), joints)
        cameras = self._frames("camera", self._fixed_cameras(), joints)
        resolved = resolve_chains({joint.name: joint for joint in joints}, self.notes)
        root = self.links[self.root]
        ordered = share_limits(drive_order(resolved, root, self.notes), self.notes)
        self._note_unlimited(ordered)
        shapes = Shapes(self.compiled, self.links, self.path)
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
            notes=(),
            visual_notes=shapes.visual_notes,
            collisions=shapes.collisions,
        )
        own = {joint.name for joint in ordered if joint.kind != "fixed" and joint.mimic is None}
        moving = [motion for motion in motions if motion.joint.name in own]
        semantics = semantics_of(
            import_mujoco(), model, own=moving, base=self.base, cameras=cameras, sites=sites, notes=self.notes
        )
        return replace(tree, notes=tuple(self.notes)), semantics

    def _body_names(self) -> dict[int, str]:
        """Body → its name; bodies without one are numbered."""
        given = {body: str(self.model.body(body).name) for body in self.bodies}
        self.taken |= {name for name in given.values() if name}
        return {body: name or self._fresh(f"body_{body}", "") for body, name in given.items()}

    def _name_motions(self, bodies: dict[int, str]) -> None:
        """Give names to the motions without one, by the bodies they move, and to balls of a name that another has."""
        every = [motion for moves, _ in self.moves.values() for motion in moves]
        self.taken |= {motion.joint.name for motion in every if motion.joint.name}
        single = {motion.joint.name for motion in every if not motion.is_ball}
        for body, (moves, _) in self.moves.items():
            for place, motion in enumerate(moves):
                name = motion.joint.name or self._fresh(bodies[body], "_joint")
                if motion.is_ball and name in single:
                    name = self._fresh(name, "_ball")
                moves[place] = motion._replace(joint=replace(motion.joint, name=name))

    def _moving_joints(self, couplings: Couplings) -> list[UrdfJoint]:
        """The joints, one behind the other, with links between the joints of one body."""
        joints: list[UrdfJoint] = []
        strength = efforts(self.model)
        for body, (moves, T_last_body) in self.moves.items():
            parent = self.links[int(self.model.body_parentid[body])]
            ends_here = bool(moves) and np.array_equal(T_last_body, np.eye(4))
            for count, motion in enumerate(moves, 1):
                last = ends_here and count == len(moves)
                child = self.links[body] if last else self._fresh(motion.joint.name, "_link")
                joint = replace(motion.joint, parent=parent, child=child)
                joints.append(self._joint(motion, joint, couplings, strength))
                parent = child
            if not ends_here:
                joints.append(self._fixed(parent, self.links[body], T_last_body))
            self._note_ball(moves)
        return joints

    def _joint(self, motion: Motion, joint: UrdfJoint, couplings: Couplings, strength: dict[int, float]) -> UrdfJoint:
        """The joint of a motion, which has its names already, as it is coupled, locked, driven and damped."""
        if joint.name in couplings.locked:
            T = joint.origin.matrix @ joint.travel(couplings.locked[joint.name])
            return UrdfJoint(joint.name, "fixed", joint.parent, joint.child, origin(T))
        dof = int(self.model.jnt_dofadr[motion.id]) + motion.part
        return replace(
            joint,
            effort=strength.get(motion.id, math.inf),
            damping=float(self.model.dof_damping[dof]),
            friction=float(self.model.dof_frictionloss[dof]),
            mimic=couplings.mimics.get(joint.name),
        )

    def _frames(self, kind: str, ids: Any, joints: list[UrdfJoint]) -> dict[int, str]:
        """Sites or cameras as links fixed to those of their bodies: id → name; those without a name are left out."""
        prefix = "cam" if kind == "camera" else kind
        bodies = getattr(self.model, f"{prefix}_bodyid")
        found, renamed = dict[int, str](), list[str]()
        for index in ids:
            name, body = str(getattr(self.model, kind)(index).name), int(bodies[index])
            if not name or body not in self.links:
                continue
            T = pose(getattr(self.model, f"{prefix}_pos")[index], getattr(self.model, f"{prefix}_quat")[index])
            if kind == "camera":
                T[:3, :3] = T[:3, :3] @ R_CAMERA_FRAME
            placed = self.placed.get(name)
            if placed is not None and placed[0] == body and np.allclose(placed[1], T, rtol=0.0, atol=1e-9):
                found[index] = name  # a camera in a site of its name: one frame
                continue
            if name in self.taken:
                renamed.append(name)
                found[index] = self._fresh(name, f"_{kind}")
            else:
                self.taken.add(name)
                self.placed[name] = body, T
                found[index] = name
            joints.append(self._fixed(self.links[body], found[index], T))
        if renamed:
            names = abbreviated(", ".join(renamed), 100)
            self.notes.append(f"{len(renamed)} {kind}s are called …_{kind}, for others have their names: {names}")
        return found

    def _fixed_cameras(self) -> list[int]:
        """The cameras that do not follow a body about."""
        modes = [int(mode) for mode in self.model.cam_mode]
        fixed = [camera for camera, mode in enumerate(modes) if mode == _FIXED_CAMERA]
        if len(fixed) < len(modes):
            self.notes.append(f"cameras that turn by themselves left out: {len(modes) - len(fixed)}")
        return fixed

    def _fixed(self, parent: str, child: str, T: Floats) -> UrdfJoint:
        return UrdfJoint(self._fresh(child, "_fixed"), "fixed", parent, child, origin(T))

    def _inertial(self, body: int) -> Inertial:
        a, b, c = (float(moment) for moment in self.model.body_inertia[body])
        place = origin(pose(self.model.body_ipos[body], self.model.body_iquat[body]))
        return Inertial(float(self.model.body_mass[body]), place, (a, 0.0, 0.0, b, 0.0, c))

    def _note_ball(self, moves: list[Motion]) -> None:
        for place, motion in enumerate(moves):
            if motion.part == 2:
                three = ", ".join(quoted(turn.joint.name) for turn in moves[place - 2 : place + 1])
                limit = "; its limit on the whole turn is one on each" if self.model.jnt_limited[motion.id] else ""
                self.notes.append(
                    f"ball joint {quoted(str(self.model.joint(motion.id).name))} made of three about x, y and z: "
                    f"{three}{limit}"
                )

    def _note_unlimited(self, joints: list[UrdfJoint]) -> None:
        own = (joint for joint in joints if joint.kind != "fixed" and joint.mimic is None)
        names = [joint.name for joint in own if np.isinf(joint.upper - joint.lower)]
        if names:
            self.notes.append(f"joints without limits: {abbreviated(', '.join(names))}")

    def _fresh(self, name: str, *endings: str) -> str:
        fresh = fresh_name(name, self.taken, *endings)
        self.taken.add(fresh)
        return fresh
