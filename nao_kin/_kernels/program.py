"""Programs: lists of operations on three-vectors without branches, built once and run on any number of tiles.

A builder hands out registers. Columns that do not change are shared and not copied: a rotation about z does not change
the third column of a matrix, and a joint without an offset does not move the origin. A finished program contains only
the operations on which its results depend.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from ctypes import addressof, c_char
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats
from nao_kin._kernels.cache import Floats1, Floats2, Ints1, Ints2

# --- The codes of the operations, and the size of a tile, shared by programs and the kernel that runs them.

TURN, ADD_1, ADD_2, ADD_3, SLIDE, CROSS, PROJECT, BASE, HINGE, MATRIX, QUATERNION, RPY = range(12)

# Bytes of a vector and of a cache line; and vectors in a tile, two because their work hides the look-up of operations.
LINE = 64
VECTORS = 2

# Largest angles for which the products with parts of π/2 are exact, by bytes of a number; the C library does the rest.
FARTHEST = {8: 1e5, 4: 500.0}


class Tables(NamedTuple):
    """A program in the kernel's form; "row" means a row of scratch memory."""

    widths: Ints1  # numbers in each configuration, velocity and acceleration; 0 if it is not read
    inputs: Ints1  # row of the first number of each of these three inputs
    angles: Ints2  # rows of its number and of its sine, (angles, 2); the cosine is next
    ratios: Floats2  # ratio and offset, (angles, 2): angle = ratio × number + offset
    operations: Ints2  # shape (operations, 10), see `nao_kin._kernels.operations`
    weights: Floats1  # the constants of the operations
    sources: Ints1  # row of each number of the result


def aligned_empty(count: int, dtype: np.dtype[Any]) -> NDArray[Any]:
    """Return uninitialised memory for `count` numbers, aligned to cache lines."""
    memory = np.empty(count + LINE // dtype.itemsize, dtype)
    # This takes a third of the time of memory.ctypes.data.
    skipped = -addressof(c_char.from_buffer(memory.data)) % LINE // dtype.itemsize
    return memory[skipped : skipped + count]


def tile_width(dtype: np.dtype[Any]) -> int:
    """Return the number of configurations in a tile."""
    return VECTORS * LINE // dtype.itemsize


# --- Programs and their builder.

# Smaller weights are rounding errors of a zero, as in cos(π/2) = 6e-17.
_NEGLIGIBLE = 1e-16

Register = int
Columns = tuple[Register, Register, Register]


@dataclass(frozen=True)
class FrameRegisters:
    """A pose in registers: the three columns of its matrix, and its origin."""

    x: Register
    y: Register
    z: Register
    origin: Register

    @property
    def columns(self) -> Columns:
        """The three columns."""
        return self.x, self.y, self.z


@dataclass(frozen=True)
class Component:
    """A component of a register: one number for each configuration."""

    register: Register
    component: int


@dataclass(frozen=True)
class Operation:
    """One operation, before registers are assigned to rows."""

    code: int
    results: tuple[Register, ...]
    operands: tuple[Register, ...]  # for a sum, its start, or zero, and then its terms
    weights: tuple[float, ...] = ()  # its constants
    angle: int = -1  # index of its angle of rotation; −1 for none
    number: int = -1  # index of the input that it reads; −1 for none
    axis: int = -1  # the coordinate axis of its rotation; −1 for none


@dataclass(frozen=True)
class Program:
    """A finished program."""

    tables: Tables = field(repr=False)
    constants: Floats = field(repr=False)  # the first registers, which do not change, shape (registers, 3)
    rows: int  # number of rows of scratch memory

    @cached_property
    def length(self) -> int:
        """The approximate work for one configuration: components of vectors, and numbers of the result."""
        return 3 * len(self.tables.operations) + len(self.tables.sources)

    @cached_property
    def far_bits(self) -> dict[int, int]:
        """Bits of the largest input whose angles are small enough for the polynomials, by bytes of a number."""
        ratio, offset = np.abs(self.tables.ratios).max(axis=0, initial=0.0)
        if ratio == 0.0:
            return dict.fromkeys(FARTHEST, int(np.iinfo(np.int64).max))
        most = {size: max(0.0, (farthest - offset) / ratio) for size, farthest in FARTHEST.items()}
        return {size: int(np.array(x, f"f{size}").view(f"i{size}")) for size, x in most.items()}

    @cached_property
    def free_memory(self) -> dict[int, list[NDArray[Any]]]:
        """Scratch memory that no thread is using, by bytes of a number."""
        return {size: [] for size in FARTHEST}


class Builder:
    """Collects the operations of a program that reads q, with `derivatives` 1 also v, and with 2 also v and a."""

    def __init__(self, nq: int, nv: int, derivatives: int = 0) -> None:
        self._widths = nq, nv if derivatives > 0 else 0, nv if derivatives > 1 else 0
        self._operations: list[Operation] = []
        self._angles: dict[tuple[int, float, float], int] = {}
        self._constants: dict[tuple[float, float, float], Register] = {}
        self._registers = 0
        self.zero = self.constant(0.0, 0.0, 0.0)
        x, y, z = (self.constant(*row) for row in np.eye(3).tolist())
        self.root = FrameRegisters(x, y, z, self.zero)

    # --- numbers --------------------------------------------------------------------------------------------------

    def constant(self, x: float, y: float, z: float) -> Register:
        """Return a vector that is the same for all configurations."""
        found = self._constants.get((x, y, z))
        if found is None:
            found = self._constants[(x, y, z)] = -1 - len(self._constants)
        return found

    def angle(self, coordinate: int, ratio: float = 1.0, offset: float = 0.0) -> int:
        """Return the index of the angle ratio · q[coordinate] + offset."""
        return self._angles.setdefault((coordinate, ratio, offset), len(self._angles))

    def velocity(self, index: int) -> int:
        """Return the index of a velocity among the inputs."""
        return self._widths[0] + index

    def acceleration(self, index: int) -> int:
        """Return the index of an acceleration among the inputs."""
        return self._widths[0] + self._widths[1] + index

    # --- operations -----------------------------------------------------------------------------------------------

    def combination(self, start: Register, terms: Iterable[tuple[Register, float]]) -> Register:
        """Return start + Σ weight · register."""
        terms = [(r, w) for r, w in terms if abs(w) > _NEGLIGIBLE and r != self.zero]
        if start == self.zero and len(terms) == 1 and terms[0][1] == 1.0:
            return terms[0][0]
        for i in range(0, len(terms), 3):
            some = terms[i : i + 3]
            code = (ADD_1, ADD_2, ADD_3)[len(some) - 1]
            operands, weights = (start, *(r for r, _ in some)), tuple(w for _, w in some)
            start = self._new(code, 1, operands, weights)[0]
        return start

    def placed(self, frame: FrameRegisters, R: Floats, t: Floats) -> FrameRegisters:
        """Return the frame with pose (R, t) in `frame`."""
        axes = frame.columns
        origin = self.combination(frame.origin, zip(axes, t.tolist(), strict=True))
        columns = (self.combination(self.zero, zip(axes, column, strict=True)) for column in R.T.tolist())
        x, y, z = columns
        return FrameRegisters(x, y, z, origin)

    def turned(self, frame: FrameRegisters, axis: int, angle: int) -> FrameRegisters:
        """Return the frame rotated about its own coordinate axis."""
        columns = list(frame.columns)
        a, b = (axis + 1) % 3, (axis + 2) % 3
        columns[a], columns[b] = self._new(TURN, 2, (self.zero, columns[a], columns[b]), angle=angle)
        return FrameRegisters(columns[0], columns[1], columns[2], frame.origin)

    def scaled(self, start: Register, direction: Register, number: int, weight: float = 1.0) -> Register:
        """Return start + weight · number · direction, with one number for each configuration."""
        return self._new(SLIDE, 1, (start, direction), (weight,), number=number)[0]

    def cross(self, a: Register, b: Register, weight: float = 1.0, start: Register | None = None) -> Register:
        """Return start + weight · a × b."""
        if self.zero in (a, b):
            return self.zero if start is None else start
        return self._new(CROSS, 1, (self.zero if start is None else start, a, b), (weight,))[0]

    def difference(self, a: Register, b: Register) -> Register:
        """Return a − b."""
        return a if b == self.zero else self.combination(a, [(b, -1.0)])

    def projected(self, columns: Columns, vector: Register) -> Register:
        """Return the components of a vector along three axes."""
        if columns == self.root.columns:
            return vector
        return self._new(PROJECT, 1, (vector, *columns))[0]

    def position(self, first: int) -> Register:
        """Return the vector of three consecutive coordinates."""
        vector = self.zero
        for k, axis in enumerate(self.root.columns):
            vector = self.scaled(vector, axis, first + k)
        return vector

    def orientation(self, first: int, *, inverse: bool = False) -> Columns:
        """Return the columns of the matrix of a quaternion (x, y, z, w) of the input, or of the inverse matrix."""
        x, y, z = self._new(BASE, 3, (), (-1.0 if inverse else 1.0,), number=first)
        return x, y, z

    def hinged(self, start: Register, vector: Register, axis: int, angle: int, offset: Sequence[float]) -> Register:
        """Return start + R · vector + offset, with R the rotation about a coordinate axis."""
        return self._new(HINGE, 1, (start, vector), tuple(offset), angle=angle, axis=axis)[0]

    def transformed(self, start: Register, W: Floats, vector: Register) -> Register:
        """Return start + W · vector, with a constant matrix."""
        return self._new(MATRIX, 1, (start, vector), tuple(W.reshape(-1).tolist()))[0]

    def quaternion(self, frame: FrameRegisters) -> tuple[Component, ...]:
        """Return the unit quaternion (r0, r1, r2, r3) of a frame, in canonical sign."""
        first, last = self._new(QUATERNION, 2, (self.zero, *frame.columns))
        return (*components(first), Component(last, 0))

    def rpy(self, frame: FrameRegisters) -> tuple[Component, ...]:
        """Return roll, pitch and yaw of a frame."""
        return components(self._new(RPY, 1, (self.zero, *frame.columns))[0])

    def _new(
        self,
        code: int,
        results: int,
        operands: tuple[Register, ...],
        weights: tuple[float, ...] = (),
        *,
        angle: int = -1,
        number: int = -1,
        axis: int = -1,
    ) -> tuple[Register, ...]:
        made = tuple(range(self._registers, self._registers + results))
        self._registers += results
        self._operations.append(Operation(code, made, operands, weights, angle, number, axis))
        return made

    # --- the end --------------------------------------------------------------------------------------------------

    def build(self, result: Sequence[Component]) -> Program:
        """Return the program with these results, in this order."""
        wanted = {number.register for number in result}
        needed = self._needed(set(wanted))
        angles = sorted({operation.angle for operation in needed if operation.angle >= 0})
        constants = list(self._constants)
        # Rows: the constants, the other registers, the inputs, and a sine and a cosine for each angle.
        place, count = _allocate(needed, wanted, len(constants))
        inputs = 3 * count
        sines = inputs + sum(self._widths)
        sine_of = {angle: sines + 2 * k for k, angle in enumerate(angles)}
        weights: list[float] = []
        table = []
        for operation in needed:
            row = _encode(operation, place, sine_of, inputs)
            table.append([*row, len(weights)])
            weights += operation.weights
        keys = list(self._angles)
        chosen = [keys[angle] for angle in angles]
        starts = np.cumsum([inputs, *self._widths[:2]])
        tables = Tables(
            widths=np.array(self._widths, np.int64),
            inputs=starts.astype(np.int64),
            angles=np.array(
                [[inputs + key[0], sine_of[a]] for a, key in zip(angles, chosen, strict=True)], np.int64
            ).reshape(-1, 2),
            ratios=np.array([key[1:] for key in chosen], np.float64).reshape(-1, 2),
            operations=np.array(table, np.int64).reshape(-1, 10),
            weights=np.array([*weights, 0.0]),
            sources=np.array([place[number.register] + number.component for number in result], np.int64),
        )
        return Program(tables, np.array(constants), sines + 2 * len(angles))

    def _needed(self, wanted: set[Register]) -> list[Operation]:
        """Return the operations on which the registers `wanted` depend; adds the registers these read to `wanted`."""
        needed = []
        for operation in reversed(self._operations):
            if not wanted.isdisjoint(operation.results):
                wanted.update(operation.operands)
                needed.append(operation)
        return needed[::-1]


def components(register: Register) -> tuple[Component, Component, Component]:
    """Return the three components of a register."""
    return Component(register, 0), Component(register, 1), Component(register, 2)


def _allocate(needed: Sequence[Operation], wanted: set[Register], constants: int) -> tuple[dict[Register, int], int]:
    """Return the first row of each register, and the number of registers in scratch memory.

    Rows of registers that are no longer read are reused, so that a tile stays in the nearest cache; an operation never
    writes to rows that it reads.
    """
    last = {register: k for k, operation in enumerate(needed) for register in operation.operands}
    place = {-1 - k: 3 * k for k in range(constants)}
    free: list[int] = []
    count = constants
    for k, operation in enumerate(needed):
        for register in operation.results:
            if free:
                place[register] = free.pop()
            else:
                place[register] = 3 * count
                count += 1
        done = {register for register in operation.operands if last[register] == k}
        # One of the two results of a TURN may be unused.
        done |= {register for register in operation.results if register not in last}
        free += [place[register] for register in sorted(done) if register >= 0 and register not in wanted]
    return place, count


def _encode(operation: Operation, place: dict[Register, int], sine_of: dict[int, int], inputs: int) -> tuple[int, ...]:
    """Return code, three results, four operands and a number, as `nao_kin._kernels.operations` defines them."""
    results = [place[register] for register in operation.results]
    operands = [place[register] for register in operation.operands]
    if operation.code == HINGE:
        operands += [0, operation.axis]
    number = 0
    if operation.angle >= 0:
        number = sine_of[operation.angle]
    elif operation.number >= 0:
        number = inputs + operation.number
    return operation.code, *[*results, 0, 0][:3], *[*operands, 0, 0, 0, 0][:4], number
