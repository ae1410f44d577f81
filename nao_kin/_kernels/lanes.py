"""Vectors of the width of one register, so that a kernel computes many configurations together.

The compiler vectorises a loop over parts of one array only behind a check that the parts do not overlap. Here the width
is fixed: 512 bits, 8 double or 16 single precision numbers, which narrower registers process in several steps. Vectors
have the operators + − × ÷; `lanes_numpy` defines the other functions, and runs when nothing is compiled.

For comparison, plain loops of Numba over tiles of 32, with constant widths, unsigned indices and `contract`, take 1.6
times as long for the poses of five frames (65 against 40 ns), 1.6 times for centres of mass, 2.5 times for a Jacobian,
1.4 times for quaternions and 1.3 times for roll, pitch and yaw (same programs, one thread, AVX-512).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numba

if TYPE_CHECKING or numba.config.DISABLE_JIT:
    from nao_kin._kernels.lanes_numpy import *  # noqa: F403
else:
    from nao_kin._kernels.lanes_llvm import *  # noqa: F403
