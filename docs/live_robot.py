"""The page with the robot on the documentation's first page, written when the documentation is built."""

from __future__ import annotations

from pathlib import Path

import nao_kin as nk


def write_robot(path: Path) -> None:
    """Write what `nao-kin view --html` writes; a file that is the same already stays, for Sphinx copies what is new."""
    viewer = nk.Viewer(nk.load_nao())
    viewer.display(viewer.robot.posture("StandInit"))
    page = viewer.static_html()
    path.parent.mkdir(parents=True, exist_ok=True)
    if not path.exists() or path.read_text(encoding="utf-8") != page:
        path.write_text(page, encoding="utf-8")
