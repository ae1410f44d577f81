"""Forward kinematics by hand: elementary rotations and steps, nothing else."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from nao_kin._arrays import Floats
from nao_kin.crosscheck.conversions import Conversions, Function
from nao_kin.crosscheck.steps import Step, Vector
from nao_kin.errors import UnknownName


class HandRolled:
    """Poses of all frames of a robot from its steps.

    Raises:
        UnknownName: a step whose parent is not a step before it.
    """

    def __init__(self, steps: Sequence[Step], joint_names: Sequence[str], conversions: Conversions) -> None:
        self.steps = tuple(steps)
        self._column = {name: index for index, name in enumerate(joint_names)}
        self._rot: dict[str, Function] = {"x": conversions.rot_x, "y": conversions.rot_y, "z": conversions.rot_z}
        self.parents: list[int | None] = []
        known: dict[str, int] = {}
        for index, step in enumerate(self.steps):
            if step.parent is not None and step.parent not in known:
                raise UnknownName("frame", step.parent, tuple(known))
            self.parents.append(None if step.parent is None else known[step.parent])
            known[step.name] = index

    def value(self, step: Step, q: Floats) -> Floats:
        """Joint values of one step, shape (n,); a joint without a coordinate stays at its offset."""
        column = self._column.get(step.driver)
        coordinate = np.zeros(len(q)) if column is None else q[:, column]
        return np.asarray(step.ratio * coordinate + step.offset)

    def poses(self, q: Floats) -> Floats:
        """T_root_frame of every step, shape (n, steps, 4, 4), for configurations of shape (n, nq)."""
        T = np.zeros((len(q), len(self.steps), 4, 4))
        T[..., 3, 3] = 1.0
        R, p = T[..., :3, :3], T[..., :3, 3]
        for index, (step, parent) in enumerate(zip(self.steps, self.parents, strict=True)):
            R_step, p_step = self.relative(step, q)
            if parent is None:
                R[:, index], p[:, index] = R_step, p_step
            else:
                R[:, index] = R[:, parent] if _only_shifts(step) else R[:, parent] @ R_step
                p[:, index] = p[:, parent] + (R[:, parent] @ p_step[..., None])[..., 0]
        return T

    def relative(self, step: Step, q: Floats) -> tuple[Floats, Floats]:
        """R_parent_frame and the origin of the frame in its parent; (n, …) only where they depend on q."""
        R = np.eye(3)
        for axis, angle in step.turns:
            R = R @ self._rot[axis](angle)
        p = np.array(step.xyz)
        if step.axis is not None:
            value = self.value(step, q)
            if step.sliding:
                p = p + value[:, None] * (R @ step.axis)
            else:
                R = R @ self._turn_about(step.axis, value)
        return R, p

    def _turn_about(self, axis: Vector, angle: Floats) -> Floats:
        """The turn about any axis e = Rz(a) Ry(b) z: Rz(a) Ry(b) Rz(angle) Ry(−b) Rz(−a)."""
        x, y, z = axis
        for name, component in zip("xyz", axis, strict=True):
            if abs(component) == math.hypot(x, y, z):
                return np.asarray(self._rot[name](math.copysign(1.0, component) * angle))
        a, b = math.atan2(y, x), math.atan2(math.hypot(x, y), z)
        rot_y, rot_z = self._rot["y"], self._rot["z"]
        return np.asarray(rot_z(a) @ rot_y(b) @ rot_z(angle) @ rot_y(-b) @ rot_z(-a))


def _only_shifts(step: Step) -> bool:
    return not step.turns and (step.axis is None or step.sliding)
