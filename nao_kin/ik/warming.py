"""The compiled kernels of this room, made ready ahead."""

from __future__ import annotations

from nao_kin._common.kernel_cache import KernelState
from nao_kin.ik.body.body_search import BODY_KERNELS
from nao_kin.ik.closed_forms.arm import ARM_KERNELS
from nao_kin.ik.closed_forms.head import HEAD_KERNELS
from nao_kin.ik.closed_forms.leg import LEG_KERNELS
from nao_kin.ik.closed_forms.legs import LEGS_KERNELS
from nao_kin.ik.search.least_squares import DESCENT_KERNELS
from nao_kin.ik.search.limit_regions import LIMIT_KERNELS


def warm_up() -> tuple[KernelState, ...]:
    """Compile the kernels for batches of targets, or read them from the disk, so that no later call waits for it.

    Returns:
        The state of each kernel.
    """
    limbs = (*LEG_KERNELS, *LEGS_KERNELS, *ARM_KERNELS, *HEAD_KERNELS)
    return tuple(kernel.warm_up() for kernel in (*limbs, *LIMIT_KERNELS, *DESCENT_KERNELS, *BODY_KERNELS))
