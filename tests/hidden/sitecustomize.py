"""Python with packages hidden: those named in NAO_KIN_HIDDEN cannot be imported and count as not installed.

Python imports this module at its start where its folder is in PYTHONPATH, in every process that a test starts.
"""

from __future__ import annotations

import importlib.metadata
import os
import re
import sys
from collections.abc import Iterator, Sequence
from importlib.machinery import ModuleSpec, PathFinder
from types import ModuleType
from typing import Any

HIDDEN = frozenset(os.environ.get("NAO_KIN_HIDDEN", "").split())


class HidingFinder(PathFinder):
    """Finds modules and distributions as Python does, except the hidden ones."""

    @classmethod
    def find_spec(
        cls, fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """None for a hidden module."""
        return None if fullname.partition(".")[0] in HIDDEN else PathFinder.find_spec(fullname, path, target)

    @classmethod
    def find_distributions(cls, *args: Any, **kwargs: Any) -> Iterator[importlib.metadata.Distribution]:
        """All distributions but the hidden ones."""
        for found in PathFinder.find_distributions(*args, **kwargs):
            if re.sub(r"[-_.]+", "-", found.metadata["Name"]).lower() not in HIDDEN:
                yield found


if HIDDEN:
    sys.meta_path[:] = [HidingFinder if finder is PathFinder else finder for finder in sys.meta_path]
