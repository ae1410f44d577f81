"""A browser without a window, and the pictures of the scene that it draws."""

from __future__ import annotations

import base64
import itertools
import os
import queue
import shutil
import signal
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path

from nao_kin._common.ending import before_ending, kill_group, uninterrupted
from nao_kin._text import quoted
from nao_kin.errors import BadArgument, NoBrowser
from nao_kin.viewer.messages import panel_message
from nao_kin.viewer.server import Answer, LiveServer

VARIABLE = "NAO_KIN_BROWSER"
_NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "microsoft-edge")
_MAC_APPLICATIONS = (
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
)
# Drawing in software is the same everywhere; and a browser that only takes a picture has nobody to call.
_PREFIX = "nao_kin_browser_"
_RANDOM = 8  # characters that a temporary folder's name ends in
# A socket's path has at most 107 bytes, and the browser's adds /org.chromium.Chromium.XXXXXX/SingletonSocket.
_LONGEST_PATH = 60
_OPTIONS = (
    "--headless=new",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-gpu",
    "--disable-dev-shm-usage",
    "--disable-background-networking",
    "--disable-breakpad",
    "--disable-component-update",
    "--disable-crash-reporter",
    "--disable-default-apps",
    "--disable-extensions",
    "--disable-quic",
    "--disable-sync",
    "--hide-scrollbars",
    "--mute-audio",
    "--no-default-browser-check",
    "--no-first-run",
    "--password-store=basic",
)
_END_SECONDS = 5.0
_REMOVE_SECONDS = 0.3
# Width and height of a picture in pixels.
_EDGES = range(16, 8193)


class Screenshots:
    """Opens a page of its own for every picture, and knows which answer belongs to which."""

    def __init__(self) -> None:
        self._numbers = itertools.count()
        self._waiting: dict[int, queue.SimpleQueue[Answer]] = {}

    def picture(self, server: LiveServer, url: str, camera: str, size: tuple[int, int], timeout: float) -> bytes:
        """A PNG of what is on show.

        Args:
            server: who serves the scene.
            url: where.
            camera: from where to look.
            size: width and height in pixels, 16 to 8192.
            timeout: seconds for all of it.

        Raises:
            BadArgument: a size out of range.
            NoBrowser: there is none, or it gives no picture in time.
        """
        if (
            not isinstance(size, (tuple, list))
            or len(size) != 2
            or not all(isinstance(edge, int) and edge in _EDGES for edge in size)
        ):
            raise BadArgument(f"size must be two whole numbers from {_EDGES[0]} to {_EDGES[-1]}, got {quoted(size)}")
        end = time.monotonic() + timeout
        mine = next(self._numbers)
        answers = self._waiting[mine] = queue.SimpleQueue()
        try:
            role = f"capture{mine}"
            with headless(f"{url}?role={role}", size=size):
                if not server.wait_for_page(max(0.0, end - time.monotonic()), role):
                    raise NoBrowser(f"the browser did not show the scene within {timeout:g} s")
                request = {"id": mine, "camera": camera, "width": size[0], "height": size[1]}
                server.send_once(panel_message("capture", request), role)
                answer = answers.get(timeout=max(0.01, end - time.monotonic()))
                return base64.b64decode(str(answer["data"]).partition(",")[2], validate=True)
        except (queue.Empty, KeyError, ValueError):
            raise NoBrowser(f"the browser gave no picture within {timeout:g} s") from None
        finally:
            del self._waiting[mine]

    def deliver(self, answer: Answer) -> None:
        """Pass an answer on to the request that waits for it."""
        number = answer.get("id")
        waiting = self._waiting.get(number) if isinstance(number, int) else None
        if waiting is not None:
            waiting.put(answer)


def find_browser() -> Path:
    """A Chromium or Chrome: the one that the environment variable NAO_KIN_BROWSER names, or the first on the path.

    Raises:
        NoBrowser: there is none.
    """
    named = os.environ.get(VARIABLE, "")
    for name in [named] if named else [*_NAMES, *_MAC_APPLICATIONS]:
        found = shutil.which(name)
        if found is not None:
            return Path(found)
    if named:
        raise NoBrowser(f"{VARIABLE} names {quoted(named)}, which is no program")
    raise NoBrowser(
        f"a picture needs Chromium or Chrome, and none was found: install one (Debian: apt install chromium) "
        f"or name it in {VARIABLE}"
    )


@contextmanager
def headless(url: str, *, size: tuple[int, int]) -> Iterator[subprocess.Popen[bytes]]:
    """Open `url` in a browser without a window; whatever happens, it is gone afterwards.

    Raises:
        NoBrowser: there is none, or it does not start.
    """
    program = find_browser()
    with _temporary_folder() as profile:
        options = [*_OPTIONS, f"--user-data-dir={profile}", f"--window-size={size[0]},{size[1]}"]
        if hasattr(os, "geteuid") and os.geteuid() == 0:
            options.append("--no-sandbox")  # Chromium refuses to run as root otherwise
        try:
            with uninterrupted():
                process = subprocess.Popen(
                    [str(program), *options, url],
                    stdin=subprocess.DEVNULL,
                    stdout=subprocess.DEVNULL,
                    stderr=subprocess.DEVNULL,
                    start_new_session=True,
                    env={**os.environ, "TMPDIR": str(profile)},
                )
                take_back = before_ending(partial(kill_group, process.pid))
        except OSError as error:
            raise NoBrowser(f"{program} does not start: {error.strerror or error}") from None
        try:
            yield process
        finally:
            _end(process)
            take_back()


@contextmanager
def _temporary_folder() -> Iterator[Path]:
    """A folder of the browser's own, for all that it writes; whatever happens, it is gone afterwards."""
    with uninterrupted():
        folder = Path(tempfile.mkdtemp(prefix=_PREFIX, dir=_short_folder()))
        take_back = before_ending(partial(_remove, folder))
    try:
        yield folder
    finally:
        _remove(folder)
        take_back()


def _short_folder() -> str:
    """The folder for temporary ones, or a shorter one: the browser puts a socket into what it is given."""
    usual = tempfile.gettempdir()
    length = len(os.fsencode(usual)) + 1 + len(_PREFIX) + _RANDOM
    return usual if length <= _LONGEST_PATH or not os.access("/tmp", os.W_OK) else "/tmp"


def _remove(folder: Path) -> None:
    """Remove a folder in which a browser that was just killed may still be writing."""
    end = time.monotonic() + _REMOVE_SECONDS
    while folder.exists() and time.monotonic() < end:
        shutil.rmtree(folder, ignore_errors=True)


def _end(process: subprocess.Popen[bytes]) -> None:
    """End the browser and the processes it started, which share its group."""
    for number in (signal.SIGTERM, signal.SIGKILL):
        with suppress(ProcessLookupError):
            os.killpg(process.pid, number)
        with suppress(subprocess.TimeoutExpired):
            process.wait(_END_SECONDS)
