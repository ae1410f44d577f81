"""The page: meshcat's viewer and our panel in one HTML document, live or with the whole scene inside."""

from __future__ import annotations

import base64
import html
import importlib.util
import string
from collections.abc import Iterable
from functools import cache
from pathlib import Path

from nao_kin.errors import BadModel

_FOLDER = Path(__file__).resolve().parent / "page"

# Everything is inside the document; a page that nothing can lead out of needs no trust.
POLICY = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:"


def live_page(title: str) -> str:
    """The page that takes its scene from the server it came from.

    Which address that is, only the server knows: the policy in its header leaves no other one.
    """
    return _document(title, f"{POLICY}; connect-src 'self' ws: wss:", "")


def static_page(title: str, messages: Iterable[bytes]) -> str:
    """The page that carries its scene: one file that needs no network.

    The messages are written in base64, which no name in them can break out of.
    """
    return _document(title, POLICY, "\n".join(base64.b64encode(message).decode("ascii") for message in messages))


def _document(title: str, policy: str, scene: str) -> str:
    template, style, library, scripts = _parts()
    return template.substitute(
        title=html.escape(title), policy=policy, style=style, library=library, scripts=scripts, scene=scene
    )


@cache
def _parts() -> tuple[string.Template, str, str, str]:
    """The document, its styles, meshcat's library and our scripts, which are built from the sources in web/."""
    template, style, scripts = (
        (_FOLDER / f"page.{kind}").read_text(encoding="utf-8") for kind in ("html", "css", "js")
    )
    return string.Template(template), style, _meshcat(), scripts


def _meshcat() -> str:
    """The JavaScript of meshcat, found without importing its Python half, which brings IPython with it."""
    spec = importlib.util.find_spec("meshcat")
    for folder in (spec.submodule_search_locations or []) if spec is not None else []:
        path = Path(folder) / "viewer" / "dist" / "main.min.js"
        if path.is_file():
            return path.read_text(encoding="utf-8")
    raise BadModel("meshcat is not installed, or lacks its viewer; reinstall meshcat")
