"""The joints of MuJoCo's bodies as a sequence of joints with one coordinate each.

A body of MuJoCo has a pose in its parent body and is moved by its joints in their order: about an axis through an
anchor (hinge), along an axis (slide), or freely about the anchor (ball). A joint's value is measured from `ref`.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from nao_kin._core.arrays import Floats, join_poses
from nao_kin._core.text import abbreviated, quoted
from nao_kin.robot.semantics import Mimic
from nao_kin.robot.urdf.tree import Origin, UrdfJoint
from nao_kin.rotations import matrix_from_quat

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


def pose(position: Any, quaternion: Any) -> Floats:
    """Return a pose (4, 4) from MuJoCo's position and quaternion (scalar first)."""
    unit = np.array(quaternion, dtype=np.float64)
    return join_poses(matrix_from_quat(unit / np.linalg.norm(unit)), np.asarray(position))


def translation(by: Floats) -> Floats:
    """Return a pose (4, 4) without rotation."""
    return join_poses(np.eye(3), by)


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
