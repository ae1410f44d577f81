"""The live page as an HTTP document, and what every answer of its server has in common."""

from __future__ import annotations

import gzip
import hashlib
import logging
import re
from functools import cached_property
from typing import Any

import tornado.httputil
import tornado.web

from nao_kin.viewer.access import Access

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
