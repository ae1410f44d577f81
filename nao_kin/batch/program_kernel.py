"""A program run on many configurations, a tile of them at a time.

For each tile the configurations are read as columns, one row of the scratch memory for each number of a configuration;
sines and cosines are taken; the operations follow; and the rows that make up the result are written out, one
configuration after another. What a configuration gives does not depend on its place in a tile or on the others in it.
"""

from __future__ import annotations

import math
from typing import Any

import numba
import numpy as np
from numba import types

from nao_kin.batch.functions import FARTHEST, compiled, sine_and_cosine
from nao_kin.batch.lanes import (
    Array,
    lane_count,
    larger,
    largest,
    load,
    magnitude_bits,
    read_columns,
    spread,
    store,
    write_fours,
)
from nao_kin.batch.opcodes import VECTORS, Tables
from nao_kin.batch.operations import perform

_FARTHEST_DOUBLE, _FARTHEST_SINGLE = FARTHEST[8], FARTHEST[4]


def run(q: Array, v: Array, a: Array, tables: Tables, m: Array, out: Array, far: int) -> int:
    """Run a program on all configurations.

    Args:
        q: configurations, one after another.
        v: velocities; empty where the program takes none.
        a: accelerations; empty where the program takes none.
        tables: the program.
        m: scratch memory, a tile for each row, with the constant registers filled.
        out: the results, one after another.
        far: bits of the magnitude from which on an angle may be too large for the polynomials.

    Returns:
        The bits of the largest magnitude among the inputs: of infinity or NaN, if there is one.
    """
    n = lane_count(m)
    width = VECTORS * n
    inputs = q, v, a
    angles, ratios = tables.angles, tables.ratios
    count = out.size // len(tables.sources)
    peak = 0
    for first in range(0, count, width):
        here = min(width, count - first)
        bits = magnitude_bits(spread(m, 0.0))
        for k in range(3):
            numbers, at = tables.widths[k], tables.inputs[k] * width
            if numbers:
                _read(inputs[k], numbers, first, here, m, at)
                for i in range(at, at + numbers * width, n):
                    bits = larger(bits, magnitude_bits(load(m, i)))
        top = largest(bits)
        peak = max(peak, top)
        for k in range(len(angles)):
            ratio, offset = spread(m, ratios[k, 0]), spread(m, ratios[k, 1])
            for i in range(0, width, n):
                sine, cosine = sine_and_cosine(m, load(m, angles[k, 0] * width + i) * ratio + offset)
                store(m, angles[k, 1] * width + i, sine)
                store(m, (angles[k, 1] + 1) * width + i, cosine)
        if top > far:
            _far_angles(m, angles, ratios)
        perform(m, tables.operations, tables.weights)
        _write(m, tables.sources, out, first, here)
    return peak


@compiled
def _read(values: Array, numbers: int, first: int, here: int, m: Array, at: int) -> None:
    """The numbers of a tile as rows of `m`; rows of zeros after the last configuration."""
    n = lane_count(m)
    width = VECTORS * n
    if here == width and numbers >= n:
        for i in range(0, width, n):
            for k in range(0, numbers, n):
                # The last block reaches back rather than past the end.
                column = min(k, numbers - n)
                read_columns(values, (first + i) * numbers + column, numbers, m, at + column * width + i, width)
        return
    for k in range(numbers):
        for i in range(here):
            m[at + k * width + i] = values[(first + i) * numbers + k]
        for i in range(here, width):
            m[at + k * width + i] = 0.0


@compiled
def _write(m: Array, sources: Array, out: Array, first: int, here: int) -> None:
    """The rows of `m` that make up the result, configuration by configuration."""
    n = lane_count(m)
    width = VECTORS * n
    numbers = len(sources)
    if here == width and numbers >= 4:
        for i in range(0, width, n):
            for k in range(0, numbers, 4):
                column = min(k, numbers - 4)
                write_fours(m, sources, column, width, i, out, (first + i) * numbers + column, numbers)
        return
    for i in range(here):
        for k in range(numbers):
            out[(first + i) * numbers + k] = m[sources[k] * width + i]


@compiled
def _far_angles(m: Array, angles: Array, ratios: Array) -> None:
    """Sines and cosines of angles that the polynomials do not reach, by the C library in double precision."""
    width = VECTORS * lane_count(m)
    farthest = _FARTHEST_DOUBLE if m.itemsize == 8 else _FARTHEST_SINGLE
    for k in range(len(angles)):
        for i in range(width):
            x = m[angles[k, 0] * width + i] * ratios[k, 0] + ratios[k, 1]
            if abs(x) > farthest and math.isfinite(x):
                m[angles[k, 1] * width + i] = math.sin(x)
                m[(angles[k, 1] + 1) * width + i] = math.cos(x)


def signature(given: np.dtype[Any], computed: np.dtype[Any]) -> Any:
    """The types of `run` for inputs in one precision, computed in the same one or in single."""
    # Arrays inside a tuple are not taken for read-only ones.
    row, table = types.int64[::1], types.int64[:, ::1]
    tables = types.NamedTuple((row, row, table, types.float64[:, ::1], table, types.float64[::1], row), Tables)
    values = types.Array(numba.from_dtype(given), 1, "C", readonly=True)
    memory = types.Array(numba.from_dtype(computed), 1, "C")
    return types.int64(values, values, values, tables, memory, memory, types.int64)
