"""Velocities and accelerations of a robot's joints in the registers of a program."""

from __future__ import annotations

from dataclasses import dataclass

from nao_kin.batch.posing import PosedTree
from nao_kin.batch.program import Frame, Register
from nao_kin.batch.tree import ROOT


@dataclass(frozen=True)
class Motion:
    """How a body moves at one of its points, in the root's axes.

    Attributes:
        point: the point.
        v: its velocity.
        w: angular velocity of the body.
        dv: acceleration of the point.
        dw: angular acceleration.
    """

    point: Register
    v: Register
    w: Register
    dv: Register
    dw: Register


class MovingTree:
    """Motions of the frames of joints, made when they are asked for.

    Args:
        posed: the frames.
        derivatives: 1 for velocities, 2 for accelerations too.
    """

    def __init__(self, posed: PosedTree, derivatives: int) -> None:
        self.posed, self.builder = posed, posed.builder
        self._accelerated = derivatives > 1
        zero = self.builder.zero
        self._motions = {ROOT: Motion(zero, zero, zero, zero, zero)}

    def motion(self, joint: int, point: Register) -> Motion:
        """The motion of what a joint carries, at a point of it."""
        for place in self.posed.tree.chain(joint):
            if place not in self._motions:
                self._motions[place] = self._moved(place)
        return self._at(self._motions[joint], point)

    def twist(self, motion: Motion, frame: Frame, expression: str) -> tuple[Register, Register]:
        """Linear and angular velocity, as the expression has them."""
        builder = self.builder
        if expression == "frame":
            return builder.projected(frame.columns, motion.v), builder.projected(frame.columns, motion.w)
        if expression == "root":
            return builder.cross(motion.point, motion.w, 1.0, motion.v), motion.w
        return motion.v, motion.w

    def twist_rate(self, motion: Motion, frame: Frame, expression: str) -> tuple[Register, Register]:
        """The derivative of the numbers of the twist, as the expression has them."""
        builder = self.builder
        if expression == "frame":
            linear = builder.cross(motion.w, motion.v, -1.0, motion.dv)
            return builder.projected(frame.columns, linear), builder.projected(frame.columns, motion.dw)
        if expression == "root":
            linear = builder.cross(motion.v, motion.w, 1.0, motion.dv)
            return builder.cross(motion.point, motion.dw, 1.0, linear), motion.dw
        return motion.dv, motion.dw

    def _at(self, motion: Motion, point: Register) -> Motion:
        """The same body at another of its points: v + ω × r and v̇ + ω̇ × r + ω × (ω × r)."""
        if point == motion.point:
            return motion
        builder = self.builder
        r = builder.difference(point, motion.point)
        swing = builder.cross(motion.w, r)
        v = builder.combination(motion.v, [(swing, 1.0)])
        dv = motion.dv
        if self._accelerated:
            dv = builder.cross(motion.w, swing, 1.0, builder.cross(motion.dw, r, 1.0, dv))
        return Motion(point, v, motion.w, dv, motion.dw)

    def _moved(self, place: int) -> Motion:
        builder, joint = self.builder, self.posed.tree.joints[place]
        origin = self.posed.frame(place).origin
        carried = self._at(self._motions[joint.parent], origin)
        if joint.kind == "free":
            return self._floating(place, origin)
        axis, weight = self.posed.axis(place)
        speed = builder.scaled(builder.zero, axis, builder.velocity(joint.velocity), weight)
        v, w, dv, dw = carried.v, carried.w, carried.dv, carried.dw
        if joint.kind == "prismatic":
            v = builder.combination(v, [(speed, 1.0)])
        else:
            w = builder.combination(w, [(speed, 1.0)])
        if self._accelerated:
            rate = builder.acceleration(joint.velocity)
            if joint.kind == "prismatic":
                dv = builder.scaled(builder.cross(carried.w, speed, 2.0, dv), axis, rate, weight)
            else:
                dw = builder.scaled(builder.cross(carried.w, speed, 1.0, dw), axis, rate, weight)
        return Motion(origin, v, w, dv, dw)

    def _floating(self, place: int, origin: Register) -> Motion:
        """A floating base, whose velocity and acceleration are given in its own axes."""
        builder, first = self.builder, self.posed.tree.joints[place].velocity
        columns = self.posed.frame(place).columns
        v = w = dv = dw = builder.zero
        for k, axis in enumerate(columns):
            v = builder.scaled(v, axis, builder.velocity(first + k))
            w = builder.scaled(w, axis, builder.velocity(first + 3 + k))
            if self._accelerated:
                dv = builder.scaled(dv, axis, builder.acceleration(first + k))
                dw = builder.scaled(dw, axis, builder.acceleration(first + 3 + k))
        # The numbers of v change with the axes, too.
        return Motion(origin, v, w, builder.cross(w, v, 1.0, dv) if self._accelerated else dv, dw)
