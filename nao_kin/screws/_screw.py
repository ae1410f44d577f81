"""A screw motion: turn and slide along one line."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import LARGEST, Floats, as_batch, common_batch, cross, dot, largest, unit
from nao_kin.errors import BadArgument
from nao_kin.screws._exponential import FARTHEST_AXIS, log, motion_of, turns_checked
from nao_kin.screws.lines import PluckerLine


@dataclass(frozen=True, eq=False, init=False)
class Screw:
    """A turn about a line together with a slide along it, or a batch of them: what every rigid motion is (Chasles).

    It stands for a displacement, with angle [rad] and slide [m], or for a velocity, with [rad/s] and [m/s]. Immutable:
    the arrays are read-only copies of what was given. `screws[i]` picks from the batch axes.

    Attributes:
        axis: the line, directed.
        angle: turn about it, right-handed, shape (...).
        slide: shift along it, shape (...).

    Raises:
        BadArgument: `axis` is no `PluckerLine`; angle or slide are not numbers, or outside ±1e150.
        WrongShape, NotFinite: batch shapes that do not fit together, NaN or infinity.

    Source: Murray, Li and Sastry, A Mathematical Introduction to Robotic Manipulation, 2.3.3.

    Examples:
        >>> upright = nk.lines.PluckerLine.from_point_direction([1, 0, 0], [0, 0, 1])
        >>> nk.screws.Screw(upright, np.pi, 0.4).pose[:3, 3].round(9) + 0.0
        array([2. , 0. , 0.4])
    """

    axis: PluckerLine
    angle: Floats
    slide: Floats

    def __init__(self, axis: PluckerLine, angle: ArrayLike, slide: ArrayLike) -> None:
        if not isinstance(axis, PluckerLine):
            raise BadArgument(f"axis must be a PluckerLine, got {type(axis).__name__}")
        numbers = {"angle": as_batch(angle, (), "angle"), "slide": as_batch(slide, (), "slide")}
        batch = common_batch("axis, angle and slide", axis.batch_shape, *(value.shape for value in numbers.values()))
        for name, value in numbers.items():
            if np.abs(value).max(initial=0.0) > LARGEST:
                raise BadArgument(f"{name} must not exceed {LARGEST:.0e} in magnitude, got {np.abs(value).max():.3g}")
            own = np.array(np.broadcast_to(value, batch))
            own.setflags(write=False)
            object.__setattr__(self, name, own)
        # The axis seen from where it is seen already, but by all of the batch.
        object.__setattr__(self, "axis", axis.transfer_to(np.broadcast_to(axis.origin, (*batch, 3))))

    @classmethod
    def from_twist(cls, twist: ArrayLike) -> Screw:
        """The screw of a twist (v; ω): angle ‖ω‖, slide v·e, about the line along e = ω/‖ω‖ through ω × v/‖ω‖².

        A twist without ω is a translation, whose pitch is infinite: angle 0, slide ‖v‖, along the line through the
        origin in the direction of v, which stands for all its parallels. So is one whose line would be farther away
        than 1e150 m. The zero twist, which has no line, gets the z axis, with angle and slide 0.

        Args:
            twist: (v; ω), linear part first, shape (..., 6).

        Returns:
            Screws with angle ≥ 0, about axes whose moments are about the origin of the twist's frame.

        Raises:
            BadArgument: not numbers, outside ±1e150, or ‖ω‖ above 1e15.
            WrongShape, NotFinite: not of shape (..., 6), NaN or infinity.

        Examples:
            >>> screw = nk.screws.Screw.from_twist([0, -2, 1, 0, 0, 2])
            >>> screw.axis.point, screw.angle.tolist(), screw.slide.tolist(), screw.pitch.tolist()
            (array([1., 0., 0.]), 2.0, 1.0, 0.5)
        """
        v, omega = turns_checked(twist)
        without_turn, moving = (omega == 0.0).all(axis=-1), np.asarray(v.any(axis=-1))
        e, angle = unit(np.where(np.asarray(without_turn)[..., None], 1.0, omega), "axis")
        along, speed = unit(np.where(moving[..., None], v, [0.0, 0.0, 1.0]), "direction")
        across = cross(cross(e, v), e)
        straight = np.asarray(without_turn | (largest(across) > FARTHEST_AXIS * angle))
        moment = np.where(straight[..., None], 0.0, across / np.where(straight, 1.0, angle)[..., None])
        return cls(
            PluckerLine(np.where(straight[..., None], along, e), moment),
            np.where(straight, 0.0, angle),
            np.where(straight, np.where(moving, speed, 0.0), dot(e, v)),
        )

    @classmethod
    def from_pose(cls, T_ab: ArrayLike) -> Screw:
        """The screw of a displacement: that of its twist `log(T_ab)`, with the angle in [0, π].

        A pure translation has angle 0, pitch infinite, and the line through the origin along it; the identity the z
        axis, with angle and slide 0. Near them the line is far away, and moves by the rounding of R divided by θ².

        Args:
            T_ab: poses [[R, t], [0, 1]], shape (..., 4, 4).

        Returns:
            Screws; axes in the coordinates of frame a, which the screw's motion leaves where they are.

        Raises:
            NotARotation: the rotation part of some pose is none.
            BadArgument: the last row of some pose is not (0, 0, 0, 1).
            WrongShape, NotFinite: in `T_ab`.

        Examples:
            >>> screw = nk.screws.Screw.from_pose(nk.screws.pose(nk.rotations.rot_z(np.pi), [2, 0, 0.4]))
            >>> screw.axis.point, screw.axis.direction, screw.slide.round(9).tolist()
            (array([1., 0., 0.]), array([0., 0., 1.]), 0.4)
        """
        return cls.from_twist(log(T_ab))

    @property
    def pitch(self) -> Floats:
        """Slide per angle, shape (...) [m/rad]: 0 for a turn, ±∞ for a translation, 0 for no motion at all.

        Examples:
            >>> nk.screws.Screw.from_twist([[0, 0, 1, 0, 0, 2], [0, 0, 1, 0, 0, 0]]).pitch
            array([0.5, inf])
        """
        turning = self.angle != 0.0
        with np.errstate(over="ignore"):
            finite = self.slide / np.where(turning, self.angle, 1.0)
        return np.asarray(np.where(turning | (self.slide == 0.0), finite, np.copysign(np.inf, self.slide)))

    @property
    def twist(self) -> Floats:
        """The twist (v; ω) = (angle · moment + slide · e; angle · e) about the axis' frame, shape (..., 6).

        Examples:
            >>> nk.screws.Screw.from_twist([0, -2, 1, 0, 0, 2]).twist
            array([ 0., -2.,  1.,  0.,  0.,  2.])
        """
        v, omega = self._parts()
        return np.concatenate([v, omega], axis=-1)

    @property
    def pose(self) -> Floats:
        """The displacement by this screw, exp of its twist, shape (..., 4, 4).

        Examples:
            >>> x_axis = nk.lines.PluckerLine.through([0, 0, 0], [1, 0, 0])
            >>> nk.screws.Screw(x_axis, 0, 0.5).pose[:3, 3]
            array([0.5, 0. , 0. ])
        """
        return motion_of(*turns_checked(self.twist, "screw"))

    def __getitem__(self, index: Any) -> Screw:
        """The screws that `index`, any NumPy index over the batch axes, picks; IndexError outside them."""
        return Screw(self.axis[index], self.angle[index], self.slide[index])

    def __reduce__(self) -> tuple[Any, ...]:
        # Pickling alone would give the copy writable arrays.
        return Screw, (self.axis, self.angle, self.slide)

    def _parts(self) -> tuple[Floats, Floats]:
        about_origin = self.axis.transfer_to((0.0, 0.0, 0.0))
        angle, slide, e = self.angle[..., None], self.slide[..., None], about_origin.direction
        return angle * about_origin.moment + slide * e, angle * e
