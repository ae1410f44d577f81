"""The documentation built once for the tests, and its pages in a browser that reaches no network."""

from __future__ import annotations

import fcntl
import os
import subprocess
import sys
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[2]
# The same in all workers of one run.
RUN = os.environ.get("PYTEST_XDIST_TESTRUNUID", uuid.uuid4().hex)


def _is_new(site: Path) -> bool:
    """Return whether a build, by `make docs` or an earlier run, ended after the last change of its sources."""
    try:
        built = min((site / name).stat().st_mtime for name in ("searchindex.js", "objects.inv"))
    except OSError:
        return False
    folders = (ROOT / name for name in ("docs", "nao_kin", "examples"))
    files = (*ROOT.glob("*.md"), *(path for folder in folders for path in folder.rglob("*") if path.is_file()))
    made = {"_build", "_generated", "lecture", "__pycache__"}
    return all(path.stat().st_mtime < built for path in files if made.isdisjoint(path.relative_to(ROOT).parts))


def built_site() -> Path:
    """The folder with the pages, built as `make docs` does unless that has been done; once in a run."""
    for needed in ("sphinx", "furo", "myst_parser", "sphinx_design", "sphinxcontrib.katex"):
        pytest.importorskip(needed, reason="the documentation's packages are not installed")
    site = ROOT / "docs" / "_build" / "html"
    command = "-m sphinx -W --keep-going -q -d docs/_build/doctrees -b html docs docs/_build/html".split()
    site.parent.mkdir(exist_ok=True)
    with (site.parent / "tests.lock").open("a+") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # two test modules need the site, often at the same time
        lock.seek(0)
        if lock.read() != RUN and not _is_new(site):
            done = subprocess.run([sys.executable, *command], cwd=ROOT, capture_output=True, text=True)
            assert done.returncode == 0, done.stderr[-4000:]
            lock.truncate(0)
            lock.write(RUN)
    return site


class Reader:
    """A tab for several pages; any request to a network is refused and fails the test."""

    def __init__(self, context: Any) -> None:
        self.tab = context.new_page()
        self.outside: list[str] = []
        self.errors: list[str] = []
        self.tab.on("request", lambda request: self.outside.append(request.url) if not _is_local(request.url) else None)
        self.tab.on("requestfailed", lambda request: self.errors.append(f"{request.url}: {request.failure}"))
        self.tab.on("pageerror", lambda error: self.errors.append(str(error)))

    @contextmanager
    def at(self, page: Path, *, width: int = 1280, dark: bool = False) -> Iterator[Any]:
        """The tab, with a page opened from its file."""
        self.outside.clear()
        self.errors.clear()
        self.resize(width)
        self.darken(dark)
        self.tab.goto(page.resolve().as_uri())
        self.tab.evaluate("document.fonts.ready")
        yield self.tab
        assert self.outside == []
        assert self.errors == []

    def resize(self, width: int) -> None:
        """Make the screen so wide [pixels]."""
        self.tab.set_viewport_size({"width": width, "height": 844})

    def darken(self, dark: bool) -> None:
        """Set the system's preference to dark or light pages."""
        self.tab.emulate_media(color_scheme="dark" if dark else "light")

    def overflow(self) -> int:
        """Return by how much the page or its content is wider than the screen [pixels]."""
        # On narrow screens furo scrolls the content, never the document.
        return self.tab.evaluate(
            "Math.max(...[document.documentElement, ...document.querySelectorAll('.content')]"
            ".map((node) => node.scrollWidth - node.clientWidth))"
        )


@contextmanager
def reading(browser: Any) -> Iterator[Reader]:
    """A reader without a network."""
    context = browser.new_context(offline=True)
    try:
        yield Reader(context)
    finally:
        context.close()


def _is_local(url: str) -> bool:
    return url.startswith(("file:", "data:", "blob:", "about:"))
