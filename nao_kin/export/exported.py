"""What an export has written."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Exported:
    """An export that is done.

    Attributes:
        path: the file to load, or the folder of the package.
        files: every file that was written.
        changes: what in them differs from the robot, one line each.

    Examples:
        >>> done = nk.export.urdf(nk.load_nao("v5"), "nao.urdf", coupling="locked", meshes="none")
        >>> [str(file) for file in done.files], done.changes[1]
        (['nao.urdf'], 'LHipYawPitch is fixed at 0, and with it what follows it: RHipYawPitch')
    """

    path: Path
    files: tuple[Path, ...]
    changes: tuple[str, ...] = ()
