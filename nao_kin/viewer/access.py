"""The page as an HTTP document: its contents, the access rules, and the headers of the responses.

Three rules control the access to the page.

*Host.* A browser sends the requested name as `Host`. A name owned by somebody else may resolve to this machine (DNS
rebinding), and a page under that name would appear to be ours. So the server answers only to names that nobody else can
own: those of this machine, the address listened on, and the allowed names. If the address is not loopback, it also
answers to every numeric address, which cannot be rebound.

*Origin.* A browser sends the name and port of the page that opens a socket as `Origin`. This must be the page served
here, under the same name and port, or under an allowed name if a proxy has changed `Host`.

*Token.* A secret text that only the page's address contains. The page and the socket require it if others could reach
them: if the address listened on, or an allowed name, is not loopback. It stays in the address, because a cookie would
also be sent to every other port of the same machine. With the right token a socket needs no origin, for programs that
are not browsers. Without a token, a socket needs an origin: a program that sends none looks like a browser whose origin
was removed.
"""

from __future__ import annotations

import base64
import gzip
import hashlib
import hmac
import html
import importlib.util
import ipaddress
import json
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

# As an allowed name, "*" means every name, and requires a token.
ANY_NAME = "*"
_NAME = re.compile(r"[A-Za-z0-9_-]+(\.[A-Za-z0-9_-]+)*\.?")
_HOST = re.compile(r"(?P<name>\[[0-9A-Fa-f:.]+\]|[A-Za-z0-9_.-]+)(:\d{1,5})?")
_TOKEN = re.compile(r"[A-Za-z0-9._~-]{8,256}")
_TOKEN_BYTES = 24

Token = bool | str | None


class Access:
    """The access rules of a server that listens on the numeric `address`, given as `host`, with allowed `names`.

    `token` is text, True for a random one, False for none; None for a random one if the address or a name is not
    loopback.
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
        self.expected: set[str] = set()  # random roles in which a page needs no token, each for one socket
        if ANY_NAME in self._given and not self.token:
            raise BadArgument('allow_hosts has "*", which allows every name; that needs a token')

    def refusal_of_host(self, hosts: Sequence[str]) -> str | None:
        """Return why a request with these `Host` headers is refused, in one line; None if it is accepted."""
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
        """Return why a request with this token is refused, in one line; None if it is accepted."""
        if self.has_token(token):
            return None
        return "This page needs its token: open the whole address that the program prints, with ?token= in it."

    def refusal_of_origin(self, origins: Sequence[str], host: str, token: str) -> str | None:
        """Return why a socket is refused by its `Origin` headers, `Host` header and token; None if it is accepted."""
        if not origins:
            if self.token and self.has_token(token):
                return None
            return "A socket needs the Origin header of the page, as browsers send it, or a token."
        parts = urlsplit("")
        if len(origins) == 1:
            with suppress(ValueError):  # not an address in the brackets
                parts = urlsplit(origins[0])
        match = _HOST.fullmatch(parts.netloc) if parts.scheme in ("http", "https") else None
        if match is not None:
            same = parts.netloc.lower() == host.strip().lower()
            if same or _spelled(match["name"]) in self._given or ANY_NAME in self._given:
                return None
        return "A page from elsewhere may not open this socket."

    def has_token(self, token: str) -> bool:
        """Return whether the token is right or not required; takes equally long for every wrong token."""
        return not self.token or hmac.compare_digest(token.encode(), self.token.encode())

    def embedders(self) -> str:
        """Return the pages that may frame this one, as sources of a content security policy.

        They are pages of this machine, where notebooks have their own ports, of VS Code, and of the allowed names.
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
    """Return names and addresses in canonical spelling; refuse any text but names, addresses and "*"."""
    found = []
    for name in [names] if isinstance(names, str) else names:
        known = isinstance(name, str) and (name == ANY_NAME or _NAME.fullmatch(name) or _address(_spelled(name)))
        if not known:
            raise BadArgument(
                f"allow_hosts takes names like hub.example.org, without scheme, port and path, got {quoted(name)}"
            )
        found.append(_spelled(name))
    return tuple(found)


def checked_token(token: Token) -> Token:
    """Return the token; refuse text that an address cannot contain unescaped or that is shorter than 8 characters."""
    if isinstance(token, str) and not _TOKEN.fullmatch(token):
        raise BadArgument("a token is 8 to 256 letters, digits and -._~; or True for a random one, False for none")
    return token


def is_loopback(name: str) -> bool:
    """Return whether a name or an address refers to this machine itself."""
    address = _address(name)
    if address is None:
        # These names are never resolved outside of this machine (RFC 6761, 6.3); browsers do not look them up at all.
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


# --- The live page as an HTTP document, and the common part of the server's handlers.

_LOG = logging.getLogger(__name__)
_NO_GZIP = re.compile(r"gzip\s*;\s*q\s*=\s*0(\.0*)?")


class Document:
    """A page, compressed and hashed once; `policy` is its content security policy without connections and frames."""

    def __init__(self, html: str, policy: str) -> None:
        self.plain, self.policy = html.encode("utf-8"), policy
        self.tag = hashlib.sha256(self.plain).hexdigest()[:32]

    @cached_property
    def compressed(self) -> bytes:
        """The page as gzip."""
        return gzip.compress(self.plain, mtime=0)


class Guarded(tornado.web.RequestHandler):
    """A handler that applies the access rules; a refused request gets a 403 with the reason in one line."""

    access: Access

    def prepare(self) -> None:
        """Refuse requests for another name, and requests without the token."""
        refusal = self.access.refusal_of_host(self.request.headers.get_list("Host"))
        if refusal is None and self.role_asked_for() not in self.access.expected:
            refusal = self.access.refusal_of_token(self.given_token())
        if refusal is not None:
            self.refuse(403, refusal)

    def given_token(self) -> str:
        """Return the token in the requested address."""
        return self.get_query_argument("token", "")

    def role_asked_for(self) -> str:
        """Return the role in the requested address; "" for an ordinary page."""
        return self.get_query_argument("role", "")

    def refuse(self, status: int, line: str) -> None:
        """Answer with a status and one line of text."""
        self.set_status(status)
        self.set_header("Content-Type", "text/plain; charset=utf-8")
        self.finish(line + "\n")

    def set_default_headers(self) -> None:
        """Forbid type sniffing, and keep the address, with its token, out of the `Referer` header."""
        self.clear_header("Server")
        self.set_header("X-Content-Type-Options", "nosniff")
        self.set_header("Referrer-Policy", "no-referrer")

    def compute_etag(self) -> str | None:
        """Return None, so that no tag is computed."""
        return None

    def log_exception(self, kind: Any, error: Any, trace: Any) -> None:
        """Log internal errors, without the token; errors of the request are not logged."""
        if not isinstance(error, tornado.web.HTTPError):
            _LOG.error("%s %s failed", self.request.method, self.request.path, exc_info=(kind, error, trace))

    def write_error(self, status_code: int, **_: object) -> None:
        """Answer any error with one line of text."""
        self.refuse(status_code, f"{status_code}: {self._reason}")


class NotFound(Guarded):
    """The handler of all other paths."""

    def initialize(self, access: Access) -> None:
        """Set the access rules."""
        self.access = access

    def prepare(self) -> None:
        """Answer 404 to an accepted request."""
        super().prepare()
        if not self._finished:
            self.refuse(404, "There is nothing here; the page is at /.")


class PageHandler(Guarded):
    """The handler of the page."""

    def initialize(self, document: Document, access: Access) -> None:
        """Set the page and the access rules."""
        self.document, self.access = document, access

    def get(self) -> None:
        """Send the page, or 304 to a browser that has it."""
        zipped = _takes_gzip(self.request.headers)
        self.set_header("Content-Type", "text/html; charset=utf-8")
        self.set_header("Cache-Control", "no-cache")  # keep the page, and ask each time whether it has changed
        self.set_header("Vary", "Accept-Encoding")
        self.set_header("Content-Security-Policy", self._policy())
        if zipped:
            self.set_header("Content-Encoding", "gzip")
        self.finish(self.document.compressed if zipped else self.document.plain)

    head = get

    def compute_etag(self) -> str:
        """Return the document's tag, weak because it also covers the compressed page."""
        return f'W/"{self.document.tag}"'

    def _policy(self) -> str:
        # If 'self' does not cover sockets (older Firefox and Safari), the address itself does; behind a proxy that
        # changes the name, only 'self' is right. The access rules have limited the name to letters, digits and -._[]:
        host = self.request.headers["Host"].strip()
        connect = "connect-src 'self'"
        if not host.startswith("["):  # a policy may not name an IPv6 address
            connect += f" ws://{host} wss://{host}"
        return f"{self.document.policy}; {connect}; frame-ancestors {self.access.embedders()}"


def _takes_gzip(headers: tornado.httputil.HTTPHeaders) -> bool:
    accepted = [part.strip().lower() for part in headers.get("Accept-Encoding", "").split(",")]
    return any(part.partition(";")[0].strip() == "gzip" and not _NO_GZIP.fullmatch(part) for part in accepted)


# --- The page: meshcat's viewer and our panel in one HTML document, live or with the whole scene inside.

_FOLDER = Path(__file__).resolve().parent / "page"


@cache
def policy() -> str:
    """Return the content security policy of the page: it loads nothing, and runs only its loader and its scripts."""
    parts = _parts()
    digests = (hashlib.sha256(script.encode()).digest() for script in (f"\n{parts.loader}\n", parts.source))
    hashes = " ".join(f"'sha256-{base64.b64encode(digest).decode('ascii')}'" for digest in digests)
    return f"default-src 'none'; script-src {hashes}; style-src 'unsafe-inline'; img-src data: blob:"


def live_page(title: str) -> str:
    """Return the page that gets its scene from its server; the policy in the header allows no other address."""
    return _document(title, f"{policy()}; connect-src 'self' ws: wss:", "")


def static_page(title: str, messages: Iterable[bytes]) -> str:
    """Return the page with its scene, which needs no network: messages, each after its number of bytes in 32 bits."""
    return _document(
        title, policy(), packed(b"".join(len(message).to_bytes(4, "big") + message for message in messages))
    )


def packed(data: bytes) -> str:
    """Return data as gzip in base64, as web/src/packed.ts reads it; it contains no character that HTML escapes."""
    return base64.b64encode(gzip.compress(data, mtime=0)).decode("ascii")


def _document(title: str, rules: str, scene: str) -> str:
    parts = _parts()
    return parts.template.substitute(vars(parts), title=html.escape(title), policy=rules, scene=scene)


class _Parts:
    """The document, its styles, and its scripts: meshcat's library and our own, which are built from web/."""

    def __init__(self) -> None:
        page, self.style, own, self.loader = (
            (_FOLDER / name).read_text(encoding="utf-8") for name in ("page.html", "page.css", "page.js", "loader.js")
        )
        self.template, self.source = string.Template(page), f"{_meshcat()};\n{own}"
        self.scripts = packed(self.source.encode())


_parts = cache(_Parts)


def _meshcat() -> str:
    """Return meshcat's JavaScript, without importing its Python half, which imports IPython."""
    spec = importlib.util.find_spec("meshcat")
    for folder in (spec.submodule_search_locations or []) if spec is not None else []:
        path = Path(folder) / "viewer" / "dist" / "main.min.js"
        if path.is_file():
            return path.read_text(encoding="utf-8") + _licences(path)
    raise BadModel("meshcat is not installed, or lacks its viewer; reinstall meshcat")


def _licences(bundle: Path) -> str:
    """Return a comment with the licences of meshcat and of the libraries in its bundle, which must be in every copy."""
    own, others = bundle.parents[1] / "LICENSE", bundle.with_name(f"{bundle.name}.THIRD_PARTY_LICENSES.json")
    texts = [f"meshcat\n\n{own.read_text(encoding='utf-8')}"] if own.is_file() else []
    for part in json.loads(others.read_text(encoding="utf-8")) if others.is_file() else []:
        texts.append(f"{part['name']} {part['version']}, {part['license']}\n\n{part.get('licenseText') or ''}")
    return "".join(f"\n/*!\n{text.replace('*/', '* /').strip()}\n*/" for text in texts) + "\n"
