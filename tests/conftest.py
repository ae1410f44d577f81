from __future__ import annotations

import gc
import math
import re
import signal
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings
from loops import EACH_VERSION

import nao_kin as nk

# Without one of its packages the default installation is tested: what needs more is skipped.
_WITHOUT_TEST = any(find_spec(name) is None for name in ("mpmath", "numba", "pyarrow", "sympy"))

settings.register_profile("nao_kin", derandomize=True, deadline=None, max_examples=20)
settings.register_profile("thorough", settings.get_profile("nao_kin"), max_examples=60)  # once a week
settings.register_profile("quick", settings.get_profile("nao_kin"), max_examples=4)
settings.load_profile("nao_kin")


def pytest_addoption(parser: pytest.Parser, pluginmanager: pytest.PytestPluginManager) -> None:
    """Know the setting of pytest-timeout without it too: the default installation has pytest alone."""
    if not pluginmanager.has_plugin("timeout"):
        parser.addini("timeout", "seconds after which a test fails, by pytest-timeout")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Run large modules first, so that at the end no worker waits for another."""
    items.sort(key=lambda item: -item.path.stat().st_size)


def pytest_configure(config: pytest.Config) -> None:
    if find_spec("numba") is None:
        config.addinivalue_line("filterwarnings", "ignore::nao_kin.errors.NotCompiledWarning")
    # A tenth of the time went into looking for garbage in what is imported and collected.
    gc.set_threshold(100_000, 20, 100)
    # Programs that tests start end on SIGINT also if the tests run in the background, where it is ignored.
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_collection_finish(session: pytest.Session) -> None:
    """Compile kernels before a test checks what a command prints, because compiling prints a note.

    Not in a fixture, whose time would count for the first test: on a new, busy machine it takes longer than a test may.
    """
    if not session.items or session.config.option.collectonly:
        return
    nk.warm_up([])
    nk.warm_up([name for name in nk._kernels.KERNELS if not name.startswith("ik")])
    for name in {"ik kernel, bodies", "ik kernel, both legs"} & set(nk._kernels.KERNELS):  # none without Numba
        nk._kernels.KERNELS[name].background_from = math.inf  # half a minute, of no use to a test that is short


def _skipped(report: Any, error: BaseException | str, path: Path) -> None:
    """Skip what needs a package of the extra [test], and say which, if that extra is not installed."""
    missing = re.search(r"No module named '([^']*)'|pip install", str(error))
    if _WITHOUT_TEST and missing:
        reason = f"needs {missing[1]}, of the extra [test]" if missing[1] else str(error)
        report.outcome, report.longrepr = "skipped", (str(path), 0, f"Skipped: {reason}")


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(collector: pytest.Collector) -> Iterator[Any]:
    report = yield
    if report.outcome == "failed":
        _skipped(report, report.longreprtext, collector.path)
    return report


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo[Any]) -> Iterator[Any]:
    report = yield
    if call.excinfo is not None:
        for error in (call.excinfo.value, call.excinfo.value.__cause__):
            if isinstance(error, ImportError):
                _skipped(report, error, item.path)
    return report


class _Browser:
    """A browser that stays open from one module to the next."""

    def __init__(self) -> None:
        self._stack = ExitStack()
        self._open: Any = None

    def open(self) -> Any:
        from viewer_pages import chromium

        self._open = self._open or self._stack.enter_context(chromium())
        return self._open

    def close(self) -> None:
        self._open = None
        self._stack.close()


_BROWSER = _Browser()


@pytest.fixture(scope="module")
def browser() -> Any:
    """A headless Chromium, the same for all modules in a row that need one."""
    return _BROWSER.open()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_teardown(item: pytest.Item, nextitem: pytest.Item | None) -> Iterator[None]:
    """Close the browser before a module whose first test needs none: an event loop runs as long as it is open."""
    yield
    if nextitem is None or (nextitem.path != item.path and "browser" not in getattr(nextitem, "fixturenames", ())):
        _BROWSER.close()


@pytest.fixture
def short_folder() -> Iterator[Path]:
    """A folder whose path is short enough for the socket of a browser; pytest's own often is not."""
    with tempfile.TemporaryDirectory(prefix="nk_") as folder:
        yield Path(folder)


@pytest.fixture(scope="session")
def nao() -> nk.NaoModel:
    return nk.load_nao("v6")


@pytest.fixture(scope="session", params=EACH_VERSION)
def each_nao(request: pytest.FixtureRequest) -> nk.NaoModel:
    return nk.load_nao(request.param)
