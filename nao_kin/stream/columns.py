"""The numbers that a pose is written as, and their names: the same on the screen and in every kind of file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import DTypeLike, NDArray

from nao_kin._common.arrays import Floats
from nao_kin.errors import UnknownName
from nao_kin.robot import CROSSOVER, RobotModel

PoseStyle = Literal["matrix", "position_quaternion", "position6d", "rpy"]

_POSITION = ("x", "y", "z")
_MATRIX = tuple(f"t{row}{column}" for row in range(1, 5) for column in range(1, 5))
_ORIENTATION: dict[str, tuple[str, ...]] = {
    "position_quaternion": ("r0", "r1", "r2", "r3"),
    "position6d": ("wx", "wy", "wz"),
    "rpy": ("roll", "pitch", "yaw"),
}


# Rows that Pinocchio answers before the batch kernels are loaded: a file of no more is left to it, in small pieces.
FEW_ROWS = 10_000


@dataclass(frozen=True)
class PoseColumns:
    """How a pose is written as a row of numbers.

    Attributes:
        style: "matrix": the 16 entries of the homogeneous matrix, row by row, t11 … t44.
            "position_quaternion": x, y, z and the unit quaternion r0, r1, r2, r3, scalar first.
            "position6d": x, y, z, wx, wy, wz with R = Rz(wz) Ry(wy) Rx(wx), named as NAOqi names them.
            "rpy": the same numbers as x, y, z, roll, pitch, yaw.
        degrees: angles in degrees; their names then end in _deg.

    Examples:
        >>> nk.stream.PoseColumns("rpy").names
        ('x', 'y', 'z', 'roll', 'pitch', 'yaw')
    """

    style: PoseStyle = "matrix"
    degrees: bool = False

    def __post_init__(self) -> None:
        if not isinstance(self.style, str) or self.style not in get_args(PoseStyle):
            raise UnknownName("form of a pose", self.style, get_args(PoseStyle))

    @property
    def orientation(self) -> tuple[str, ...]:
        """Names of the numbers behind the position; none for a matrix."""
        suffix = "_deg" if self.degrees and self.style != "position_quaternion" else ""
        return tuple(name + suffix for name in _ORIENTATION.get(self.style, ()))

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the numbers of a pose."""
        return _MATRIX if self.style == "matrix" else (*_POSITION, *self.orientation)

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of one pose in an array."""
        return (4, 4) if self.style == "matrix" else (len(self.names),)

    def poses(
        self,
        robot: RobotModel,
        q: Floats,
        frames: Sequence[str],
        reference: str | None = None,
        dtype: DTypeLike = np.float64,
        threads: int | None = None,
    ) -> NDArray[Any]:
        """Poses of frames at configurations (n, nq) as rows of numbers (n, frames, k), in the order of `names`.

        The arguments are those of `RobotModel.fk`.

        Examples:
            >>> nao = nk.load_nao()
            >>> nk.stream.PoseColumns("position_quaternion").poses(nao, nao.random(rng=0, n=3), ["LArm", "RArm"]).shape
            (3, 2, 7)
        """
        form = "position6d" if self.style == "rpy" else self.style
        # Batches below the crossover are left to Pinocchio.
        step = len(q) if threads is not None or len(q) > FEW_ROWS else CROSSOVER - 1
        starts = range(0, len(q), max(step, 1))
        parts = [
            robot.fk(q[start : start + step], frames, reference=reference, as_=form, dtype=dtype, threads=threads)
            for start in starts
        ]
        numbers = parts[0] if len(parts) == 1 else np.concatenate(parts)
        if self.orientation and self.degrees and self.style != "position_quaternion":
            numbers[..., 3:] = np.degrees(numbers[..., 3:])
        return numbers.reshape(*numbers.shape[:2], len(self.names))
