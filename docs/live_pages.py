"""Write the pages with a robot that the documentation shows."""

from __future__ import annotations

import contextlib
import io
from pathlib import Path

import walk_and_draw

import nao_kin as nk


def write_pages(folder: Path) -> None:
    """Write the page of `nao-kin view --html`, and the walk of {doc}`following_paths`.

    A file that is the same already stays, because Sphinx copies what is new. The walk takes ten seconds: it is computed
    again only when its script or its robot is newer.
    """
    viewer = nk.Viewer(nk.load_nao())
    viewer.display(viewer.robot.posture("StandInit"))
    _write(folder / "robot.html", viewer)
    walk = folder / "walk_and_draw.html"
    sources = [Path(walk_and_draw.__file__), *Path(nk.__file__).parent.rglob("*.[pj][ys]")]
    if not walk.exists() or walk.stat().st_mtime < max(path.stat().st_mtime for path in sources):
        with contextlib.redirect_stdout(io.StringIO()):
            viewer_of_walk = walk_and_draw.viewer_of(walk_and_draw.compute())
        _write(walk, viewer_of_walk)


def _write(path: Path, viewer: nk.Viewer) -> None:
    page = viewer.static_html()
    if not path.exists() or path.read_text(encoding="utf-8") != page:
        path.write_text(page, encoding="utf-8")
