"""The documentation built once for the tests, and its pages in a browser that reaches no network."""

from __future__ import annotations

import fcntl
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parent.parent


def built_site() -> Path:
    """The folder with the pages, built as `make docs` does, and like there only what has changed."""
    for needed in ("sphinx", "furo", "myst_parser", "sphinx_design", "sphinxcontrib.katex"):
        pytest.importorskip(needed, reason="the documentation's packages are not installed")
    site = ROOT / "docs" / "_build" / "html"
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-b", "html", str(ROOT / "docs"), str(site)]
    site.parent.mkdir(exist_ok=True)
    with (site.parent / "tests.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # two modules of tests build it, often at once
        done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-4000:]
    return site


@contextmanager
def shown(browser: Any, page: Path, *, width: int = 1280, dark: bool = False) -> Iterator[Any]:
    """A page opened from its file; whatever it asks of a network is refused, and fails the test."""
    context = browser.new_context(
        viewport={"width": width, "height": 844}, color_scheme="dark" if dark else "light", offline=True
    )
    outside: list[str] = []
    errors: list[str] = []
    try:
        tab = context.new_page()
        tab.on("request", lambda request: outside.append(request.url) if not _is_local(request.url) else None)
        tab.on("requestfailed", lambda request: errors.append(f"{request.url}: {request.failure}"))
        tab.on("pageerror", lambda error: errors.append(str(error)))
        tab.goto(page.resolve().as_uri())
        tab.evaluate("document.fonts.ready")
        yield tab
        assert outside == []
        assert errors == []
    finally:
        context.close()


def _is_local(url: str) -> bool:
    return url.startswith(("file:", "data:", "blob:", "about:"))
