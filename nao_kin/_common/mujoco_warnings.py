"""What MuJoCo warns of, as texts: by itself it prints them and leaves a MUJOCO_LOG.TXT in the working directory."""

from __future__ import annotations

import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from types import ModuleType

# MuJoCo has one place for warnings in a process.
_LISTENING = threading.RLock()


@contextmanager
def mujoco_warnings(mujoco: ModuleType) -> Iterator[list[str]]:
    """The warnings of what is done inside, which are complete behind it; nothing is printed or written.

    Args:
        mujoco: the package, which only some who are here have.
    """
    said: list[str] = []
    with _LISTENING:
        before = mujoco.get_mju_user_warning()
        mujoco.set_mju_user_warning(said.append)
        try:
            with warnings.catch_warnings(record=True) as others:
                warnings.simplefilter("always")
                yield said
        finally:
            mujoco.set_mju_user_warning(before)
            said += [str(other.message) for other in others]
