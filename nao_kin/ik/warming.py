"""The compiled kernels of this room, made ready ahead."""

from __future__ import annotations

from collections.abc import Iterable

from nao_kin._kernels.cache import KernelState, has_numba
from nao_kin.errors import BadArgument, UnknownName
from nao_kin.ik.arm import ARM_KERNELS
from nao_kin.ik.body_search import BODY_KERNELS
from nao_kin.ik.compiling import KERNEL
from nao_kin.ik.head import HEAD_KERNELS
from nao_kin.ik.leg import LEG_KERNELS
from nao_kin.ik.legs import LEGS_KERNELS
from nao_kin.ik.limit_regions import LIMIT_KERNELS
from nao_kin.ik.pose_search import DESCENT_KERNELS
from nao_kin.ik.velocity import VELOCITY_KERNELS

_LIMBS = (*LEG_KERNELS, *LEGS_KERNELS, *ARM_KERNELS, *HEAD_KERNELS)
_SEARCHES = (*LIMIT_KERNELS, *DESCENT_KERNELS, *BODY_KERNELS, *VELOCITY_KERNELS)
_KERNELS = {kernel.name.removeprefix(KERNEL): kernel for kernel in (*_LIMBS, *_SEARCHES)}
KERNELS: tuple[str, ...] = tuple(_KERNELS)
"""What is compiled: "legs", "both legs", "arms by pose" …"""


def warm_up(names: Iterable[str] | None = None) -> tuple[KernelState, ...]:
    """Compile the kernels for batches of targets, or read them from the disk, so that no later call waits for it.

    Args:
        names: which of `KERNELS`; None for all.

    Returns:
        The state of each kernel; none where Numba is not installed, for nothing is compiled then.

    Raises:
        UnknownName: no such kernel.
        BadArgument: no names.

    Examples:
        >>> [state.name for state in nk.ik.warm_up(["heads"])]
        ['ik kernel, heads']
    """
    if names is not None and not isinstance(names, Iterable):
        raise BadArgument(f"names must be names of kernels, got {type(names).__name__}")
    wanted = KERNELS if names is None else tuple(names)
    for name in wanted:
        if not isinstance(name, str) or name not in _KERNELS:
            raise UnknownName("kernel", name, KERNELS)
    return tuple(_KERNELS[name].warm_up() for name in wanted) if has_numba() else ()
