"""The programs of browsers that can draw pictures: Chromium and Chrome."""

from __future__ import annotations

import os
import shutil
from collections.abc import Mapping
from pathlib import Path

from nao_kin._core.text import quoted
from nao_kin.errors import NoBrowser

VARIABLE = "NAO_KIN_BROWSER"
_NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "microsoft-edge")
_MAC_APPLICATIONS = (
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
)


def find_browsers(environment: Mapping[str, str] = os.environ) -> list[Path]:
    """Return the browsers to try, in this order: the one in the variable NAO_KIN_BROWSER, or all on the path.

    Raises:
        NoBrowser: there is none.
    """
    named = environment.get(VARIABLE, "")
    found: dict[Path, Path] = {}
    for name in [named] if named else [*_NAMES, *_MAC_APPLICATIONS]:
        program = shutil.which(name, path=environment.get("PATH"))
        if program is not None:
            found.setdefault(Path(program).resolve(), Path(program))
    if found:
        return list(found.values())
    if named:
        raise NoBrowser(f"{VARIABLE} names {quoted(named)}, which is not a program")
    raise NoBrowser(
        f"a picture needs Chromium or Chrome, and none was found: install one (Debian: apt install chromium) "
        f"or name it in {VARIABLE}"
    )
