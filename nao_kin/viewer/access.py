"""The page as a document: what is in it, who may see and command it, and the headers of its answers.

Three things decide who may see and command it.

*Name.* A browser sends the name that it was asked for as `Host`. A name that a stranger owns may lead to this machine
(DNS rebinding), and a page under it would pass for ours. So only names that nobody else can own are answered: those of
this machine itself, the address listened on, and names that are given. Where the address is not loopback, every address
in numbers is answered too: there is no name in it to rebind.

*Origin.* A browser says on every socket which page opens it. It has to be the page that was served here, under the same
name and port, or under a name that was given, where a proxy in between has changed `Host`.

*Token.* Text that only the page's address carries. It is asked for on the page and on the socket wherever somebody
else could reach them: where the address listened on, or a name that is given, is not loopback. It stays in the
address: a cookie would go to every other port of the same machine as well. With the right token a socket needs no
origin, for programs that are no browser. Without a token there must be one: nobody who lacks it can be told apart from
a browser whose origin was taken away on the way.
"""

from __future__ import annotations

import base64
import gzip
import hashlib
import hmac
import html
import importlib.util
import ipaddress
import logging
import re
import secrets
import socket
import string
from collections.abc import Iterable, Sequence
from contextlib import suppress
from functools import cache, cached_property
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import tornado.httputil
import tornado.web

from nao_kin._core.text import abbreviated, quoted
from nao_kin.errors import BadArgument, BadModel

# Given as a name, it lets every name in, provided that there is a token.
ANY_NAME = "*"
_NAME = re.compile(r"[A-Za-z0-9_-]+(\.[A-Za-z0-9_-]+)*\.?")
_HOST = re.compile(r"(?P<name>\[[0-9A-Fa-f:.]+\]|[A-Za-z0-9_.-]+)(:\d{1,5})?")
_TOKEN = re.compile(r"[A-Za-z0-9._~-]{8,256}")
_TOKEN_BYTES = 24

Token = bool | str | None


class Access:
    """The rules above, for one server.

    Args:
        address: in numbers, that the server listens on.
        host: what was asked for as the address; it is answered to.
        names: further names and addresses to answer to; "*" for all.
        token: text of its own, True for a random one, False for none; None for a random one wherever the address or a
            name is not loopback.

    Attributes:
        token: the text to be asked for; "" for none.
        expected: roles, too long to be guessed, in which a page needs no token; each for one socket.

    Raises:
        BadArgument: "*" without a token.
    """

    def __init__(self, address: str, host: str, names: Sequence[str], token: Token) -> None:
        self._given = frozenset(names)
        self._local = is_loopback(address)
        self._own = {_spelled(address), _spelled(host)}
        if not self._local:
            name = socket.gethostname()
            self._own |= {_spelled(name), _spelled(name.partition(".")[0] + ".local")}
        if token is None:
            token = not (self._local and all(map(is_loopback, self._given)))
        self.token = token if isinstance(token, str) else secrets.token_urlsafe(_TOKEN_BYTES) if token else ""
        self.expected: set[str] = set()
        if ANY_NAME in self._given and not self.token:
            raise BadArgument('allow_hosts has "*", every name; that needs a token')

    def refusal_of_host(self, hosts: Sequence[str]) -> str | None:
        """Why a request is not answered that came with these `Host` headers, in one line; None if it is."""
        match = _HOST.fullmatch(hosts[0].strip()) if len(hosts) == 1 else None
        if match is None:
            return "A request needs one Host header with a name."
        name = _spelled(match["name"])
        if self._answers_to(name):
            return None
        asked = abbreviated(name)
        return (
            f"This page is not served as {asked}. If that is a name of this machine or of a proxy before it, "
            f'start the program with --allow-host {asked}, or Viewer(allow_hosts=["{asked}"]).'
        )

    def refusal_of_token(self, token: str) -> str | None:
        """Why a request with this token is not answered, in one line; None if it is."""
        if self.has_token(token):
            return None
        return "This page needs its token: open the whole address that the program prints, with ?token= in it."

    def refusal_of_origin(self, origins: Sequence[str], host: str, token: str) -> str | None:
        """Why a socket is not opened for a page of this origin, in one line; None if it is.

        Args:
            origins: the `Origin` headers.
            host: the `Host` header.
            token: that came with the request.
        """
        if not origins:
            if self.token and self.has_token(token):
                return None
            return "A socket needs the Origin header of the page, as browsers send it, or a token."
        parts = urlsplit("")
        if len(origins) == 1:
            with suppress(ValueError):  # an address in brackets that is none
                parts = urlsplit(origins[0])
        match = _HOST.fullmatch(parts.netloc) if parts.scheme in ("http", "https") else None
        if match is not None:
            same = parts.netloc.lower() == host.strip().lower()
            if same or _spelled(match["name"]) in self._given or ANY_NAME in self._given:
                return None
        return "A page from elsewhere may not open this socket."

    def has_token(self, token: str) -> bool:
        """Whether this is the token, or none is asked for; takes as long whatever is wrong with it."""
        return not self.token or hmac.compare_digest(token.encode(), self.token.encode())

    def embedders(self) -> str:
        """Pages that may show this one in a frame, as sources of a content security policy.

        They are those of this machine, where notebooks run under ports of their own, of VS Code, and of the names that
        are given.
        """
        if ANY_NAME in self._given:
            return "*"
        names = ["localhost", "*.localhost", "127.0.0.1", *sorted(name for name in self._given if ":" not in name)]
        hosts = (f"{scheme}://{name}:*" for name in dict.fromkeys(names) for scheme in ("http", "https"))
        return " ".join(("'self'", *hosts, "vscode-webview:"))

    def _answers_to(self, name: str) -> bool:
        if is_loopback(name) or name in self._own or name in self._given or ANY_NAME in self._given:
            return True
        return not self._local and _address(name) is not None


def checked_names(names: Iterable[str]) -> tuple[str, ...]:
    """Names and addresses in one spelling each.

    Raises:
        BadArgument: one of them is neither a name, nor an address, nor "*".
    """
    if not isinstance(names, Iterable):
        raise BadArgument(f"allow_hosts must be names, got {quoted(names)}")
    found = []
    for name in [names] if isinstance(names, str) else names:
        known = isinstance(name, str) and (name == ANY_NAME or _NAME.fullmatch(name) or _address(_spelled(name)))
        if not known:
            raise BadArgument(
                f"allow_hosts takes names as hub.example.org, without scheme, port and path, got {quoted(name)}"
            )
        found.append(_spelled(name))
    return tuple(found)


def checked_token(token: Token) -> Token:
    """The token as it is.

    Raises:
        BadArgument: it is neither text that stands in an address as it is, at least 8 letters, nor True, False or None.
    """
    if isinstance(token, str) and not _TOKEN.fullmatch(token):
        raise BadArgument("a token is 8 to 256 letters, digits and -._~; or True for a random one, False for none")
    if not (token is None or isinstance(token, (bool, str))):
        raise BadArgument(f"token must be text, True, False or None, got {quoted(token)}")
    return token


def is_loopback(name: str) -> bool:
    """Whether a name or an address is one by which a machine calls itself."""
    address = _address(name)
    if address is None:
        # No resolver may answer these from outside (RFC 6761, 6.3), and browsers do not ask one.
        return name == "localhost" or name.endswith(".localhost")
    return address.is_loopback


def _spelled(name: str) -> str:
    name = name.strip().lower().rstrip(".").removeprefix("[").removesuffix("]")
    address = _address(name)
    return name if address is None else str(address)


def _address(name: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address | None:
    with suppress(ValueError):
        address = ipaddress.ip_address(name)
        return getattr(address, "ipv4_mapped", None) or address
    return None


# --- The live page as an HTTP document, and what every answer of its server has in common.

_LOG = logging.getLogger(__name__)
_NO_GZIP = re.compile(r"gzip\s*;\s*q\s*=\s*0(\.0*)?")


class Document:
    """A page, compressed and named once, however often it is asked for.

    Args:
        html: the page.
        policy: its content security policy but for what it may connect to and who may frame it.

    Attributes:
        tag: a digest, by which a browser knows the page that it has.
    """

    def __init__(self, html: str, policy: str) -> None:
        self.plain, self.policy = html.encode("utf-8"), policy
        self.tag = hashlib.sha256(self.plain).hexdigest()[:32]

    @cached_property
    def compressed(self) -> bytes:
        """The page as gzip."""
        return gzip.compress(self.plain, mtime=0)


class Guarded(tornado.web.RequestHandler):
    """Answers only whom the rules of access let in; anybody else gets a 403 that says in one line why."""

    access: Access

    def prepare(self) -> None:
        """Refuse what asks for another name, or lacks the token."""
        refusal = self.access.refusal_of_host(self.request.headers.get_list("Host"))
        if refusal is None and self.role_asked_for() not in self.access.expected:
            refusal = self.access.refusal_of_token(self.given_token())
        if refusal is not None:
            self.refuse(403, refusal)

    def given_token(self) -> str:
        """The token in the address that was asked for."""
        return self.get_query_argument("token", "")

    def role_asked_for(self) -> str:
        """The role in the address that was asked for; "" for an ordinary page."""
        return self.get_query_argument("role", "")

    def refuse(self, status: int, line: str) -> None:
        """Answer with a status and one line of text."""
        self.set_status(status)
        self.set_header("Content-Type", "text/plain; charset=utf-8")
        self.finish(line + "\n")

    def set_default_headers(self) -> None:
        """What costs nothing: no guessing of types, and no address, with its token, to anybody."""
        self.clear_header("Server")
        self.set_header("X-Content-Type-Options", "nosniff")
        self.set_header("Referrer-Policy", "no-referrer")

    def compute_etag(self) -> str | None:
        """No tag, unless it is known without computing one."""
        return None

    def log_exception(self, kind: Any, error: Any, trace: Any) -> None:
        """Leave a request that was wrong to whoever sent it; a fault of ours is logged, without the token."""
        if not isinstance(error, tornado.web.HTTPError):
            _LOG.error("%s %s failed", self.request.method, self.request.path, exc_info=(kind, error, trace))

    def write_error(self, status_code: int, **_: object) -> None:
        """One line of text, whatever was wrong with the request."""
        self.refuse(status_code, f"{status_code}: {self._reason}")


class NotFound(Guarded):
    """Any other path."""

    def initialize(self, access: Access) -> None:
        """Take the rules of access."""
        self.access = access

    def prepare(self) -> None:
        """Say so to whom may ask."""
        super().prepare()
        if not self._finished:
            self.refuse(404, "There is nothing here; the page is at /.")


class PageHandler(Guarded):
    """Serves the page."""

    def initialize(self, document: Document, access: Access) -> None:
        """Take the page and the rules of access."""
        self.document, self.access = document, access

    def get(self) -> None:
        """The page, or 304 to a browser that has it."""
        zipped = _takes_gzip(self.request.headers)
        self.set_header("Content-Type", "text/html; charset=utf-8")
        self.set_header("Cache-Control", "no-cache")  # keep it, and ask each time whether it is still the same
        self.set_header("Vary", "Accept-Encoding")
        self.set_header("Content-Security-Policy", self._policy())
        if zipped:
            self.set_header("Content-Encoding", "gzip")
        self.finish(self.document.compressed if zipped else self.document.plain)

    head = get

    def compute_etag(self) -> str:
        """The document's tag, of which its compressed form is another spelling."""
        return f'W/"{self.document.tag}"'

    def _policy(self) -> str:
        # Where 'self' does not cover sockets yet (older Firefox and Safari) the address itself does; behind a proxy
        # that changes the name, only 'self' is right. The name has passed the rules of access: letters, digits, -._[]:
        host = self.request.headers["Host"].strip()
        connect = "connect-src 'self'"
        if not host.startswith("["):  # which has no place in a policy
            connect += f" ws://{host} wss://{host}"
        return f"{self.document.policy}; {connect}; frame-ancestors {self.access.embedders()}"


def _takes_gzip(headers: tornado.httputil.HTTPHeaders) -> bool:
    accepted = [part.strip().lower() for part in headers.get("Accept-Encoding", "").split(",")]
    return any(part.partition(";")[0].strip() == "gzip" and not _NO_GZIP.fullmatch(part) for part in accepted)


# --- The page: meshcat's viewer and our panel in one HTML document, live or with the whole scene inside.

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
