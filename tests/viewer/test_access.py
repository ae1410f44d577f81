"""Access to the live page: real requests with forged host names, origins and tokens."""

from __future__ import annotations

import base64
import gzip
import hashlib
import http.client
import os
import re
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, urlsplit

import pytest
from free_ports import free_port
from viewer_pages import unpacked

import nao_kin as nk
from nao_kin.cli.app import run
from nao_kin.errors import BadArgument
from nao_kin.viewer import Viewer
from nao_kin.viewer.access import Access


@pytest.fixture(scope="module")
def viewer(nao: nk.NaoModel) -> Iterator[Viewer]:
    with Viewer(nao) as viewer:
        yield viewer


@pytest.fixture(scope="module")
def guarded(nao: nk.NaoModel) -> Iterator[Viewer]:
    """With a token, behind a proxy."""
    with Viewer(nao, allow_hosts=["Hub.example.org"]) as viewer:
        yield viewer


@pytest.fixture(scope="module")
def public(nao: nk.NaoModel) -> Iterator[Viewer]:
    with Viewer(nao, host="0.0.0.0") as viewer:
        yield viewer


class Answer:
    def __init__(self, status: int, headers: dict[str, str], body: bytes) -> None:
        self.status, self.headers, self.body = status, headers, body
        self.text = body.decode("utf-8", "replace")


def _ask(viewer: Viewer, path: str = "/", *, method: str = "GET", **headers: str | list[str]) -> Answer:
    """Send a request with exactly these headers, where _ stands for -; Host is valid unless it is given."""
    port = urlsplit(viewer.url).port
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=10.0)
    try:
        connection.putrequest(method, path, skip_host=True, skip_accept_encoding=True)
        for name, values in {"Host": f"127.0.0.1:{port}", **headers}.items():
            for value in [values] if isinstance(values, str) else values:
                connection.putheader(name.replace("_", "-"), value)
        connection.endheaders()
        response = connection.getresponse()
        headers_back = {name.lower(): value for name, value in response.getheaders()}
        return Answer(response.status, headers_back, b"" if response.status == 101 else response.read())
    finally:
        connection.close()


def _connect(viewer: Viewer, query: str = "", **headers: str | list[str]) -> Answer:
    """Ask for the page's socket."""
    return _ask(
        viewer,
        f"/live{query}",
        Upgrade="websocket",
        Connection="Upgrade",
        Sec_WebSocket_Version="13",
        Sec_WebSocket_Key=base64.b64encode(bytes(16)).decode(),
        **headers,
    )


def _port(viewer: Viewer) -> int:
    return int(urlsplit(viewer.url).port or 0)


def _query(viewer: Viewer) -> str:
    return f"?{urlsplit(viewer.url).query}"


OWN = ("localhost", "LOCALHOST", "localhost.", "nao.localhost", "127.0.0.1", "127.8.9.1", "[::1]", "[0:0:0:0:0:0:0:1]")
FOREIGN = (
    "evil.example",
    "127.0.0.1.evil.example",
    "evillocalhost",
    "[2001:db8::1]",
    "x" * 5000,
    "<script>alert(1)</script>",
    "127.0.0.1:80@evil.example",
    "0.0.0.0",
    "",
    "[::1",
)


@pytest.mark.parametrize("host", OWN)
def test_names_of_this_machine_are_answered_with_any_port(viewer: Viewer, host: str) -> None:
    for asked in (host, f"{host}:{_port(viewer)}", f"{host}:8000"):  # another port: a tunnel
        assert _ask(viewer, Host=asked).status == 200
        assert _connect(viewer, Host=asked, Origin=f"http://{asked}").status == 101


@pytest.mark.parametrize("host", FOREIGN)
def test_other_names_get_neither_page_nor_socket_nor_anything(viewer: Viewer, host: str) -> None:
    for asked in (host, f"{host}:{_port(viewer)}"):
        answers = [
            _ask(viewer, Host=asked),
            _ask(viewer, "/no/such/path", Host=asked),
            _connect(viewer, Host=asked, Origin=f"http://{asked}"),
        ]
        for answer in answers:
            assert answer.status in (400, 403)  # 400: tornado's, where it is no name at all
            assert "<" not in answer.text
            assert len(answer.text) < 1000
            assert answer.body.count(b"\n") <= 1


def test_the_line_of_a_refusal_names_the_option(viewer: Viewer) -> None:
    answer = _ask(viewer, Host="nao.lab.example:7000")
    assert answer.status == 403
    assert "not served as nao.lab.example" in answer.text
    assert "--allow-host nao.lab.example" in answer.text
    assert 'allow_hosts=["nao.lab.example"]' in answer.text
    assert answer.headers["content-type"].startswith("text/plain")


def test_no_host_and_two_hosts_are_refused(viewer: Viewer) -> None:
    assert _ask(viewer, Host=[]).status in (400, 403)
    assert _ask(viewer, Host=["127.0.0.1", "evil.example"]).status in (400, 403)
    with socket.create_connection(("127.0.0.1", _port(viewer)), timeout=5.0) as old:
        old.sendall(b"GET / HTTP/1.0\r\n\r\n")
        assert b" 200 " not in old.recv(100)
    assert _ask(viewer, Host="evil.example", X_Forwarded_Host="127.0.0.1").status == 403
    # Newer Tornados refuse two by themselves; the rule does not lean on that.
    rule = Access("127.0.0.1", "127.0.0.1", (), None)
    assert rule.refusal_of_host(["127.0.0.1"]) is None
    for hosts in ([], ["127.0.0.1", "evil.example"], ["evil.example", "127.0.0.1"], ["127.0.0.1"] * 2):
        assert rule.refusal_of_host(hosts) is not None


@pytest.mark.parametrize(
    "origin",
    [
        [],
        "http://evil.example",
        "null",
        "",
        "http://localhost:{port}",  # another name than the page's
        "http://127.0.0.1:{port}.evil.example",
        "chrome-extension://127.0.0.1:{port}",
        "http://[127.0.0.1:{port}",
        ["http://127.0.0.1:{port}", "http://evil.example"],
    ],
)
def test_without_a_token_a_socket_is_only_for_the_page_that_was_served_here(viewer: Viewer, origin: Any) -> None:
    port = _port(viewer)
    forged = [each.format(port=port) for each in ([origin] if isinstance(origin, str) else origin)]
    answer = _connect(viewer, Origin=forged)
    assert answer.status == 403
    assert answer.text.count("\n") == 1
    assert _connect(viewer, Origin=f"http://127.0.0.1:{port}").status == 101


def test_with_a_token_neither_page_nor_socket_is_had_without_it(guarded: Viewer) -> None:
    (token,) = parse_qs(_query(guarded)[1:])["token"]
    assert len(token) >= 32
    origin = f"http://127.0.0.1:{_port(guarded)}"
    wrong = (
        "",
        "?token=",
        f"?token={token[:-1]}",
        f"?token={token}x",
        "?token=%C3%A4",
        f"?Token={token}",
        "?token=%ff",
    )
    for query in wrong:
        for answer in (
            _ask(guarded, f"/{query}"),
            _ask(guarded, f"/x{query}"),
            _connect(guarded, query, Origin=origin),
        ):
            assert answer.status in (400, 403)
            assert token not in answer.text
    assert _ask(guarded, f"/?token={token}").status == 200
    assert _connect(guarded, f"?token={token}", Origin=origin).status == 101
    # A program that is no browser says no origin; a page from elsewhere has one, and no business here.
    assert _connect(guarded, f"?token={token}").status == 101
    assert _connect(guarded, f"?token={token}", Origin="http://evil.example").status == 403


def test_a_name_that_is_allowed_may_be_that_of_a_proxy_which_keeps_or_changes_the_name(guarded: Viewer) -> None:
    query = _query(guarded)
    assert _ask(guarded, f"/{query}", Host="hub.example.org").status == 200
    assert _connect(guarded, query, Host="hub.example.org", Origin="https://hub.example.org").status == 101
    assert _connect(guarded, query, Origin="https://hub.example.org").status == 101
    assert _ask(guarded, f"/{query}", Host="other.example.org").status == 403
    assert _connect(guarded, query, Origin="https://other.example.org").status == 403


@pytest.mark.full
def test_a_token_is_asked_for_wherever_others_could_come_in(nao: nk.NaoModel, public: Viewer) -> None:
    def has_token(**options: Any) -> bool:
        with Viewer(nao, **options) as viewer:
            return "?token=" in viewer.url

    assert not has_token()
    assert not has_token(allow_hosts=["nao.localhost", "127.0.0.3"])
    assert has_token(token=True)
    assert "?token=" in public.url
    assert has_token(allow_hosts=["*"])
    assert not has_token(host="0.0.0.0", token=False)
    with Viewer(nao, token="correct-horse") as viewer:
        assert viewer.url.endswith("/?token=correct-horse")
        first = viewer.url
    assert first == viewer.url.replace(f":{_port(viewer)}/", f":{urlsplit(first).port}/")
    viewer.close()


def test_an_address_open_to_others_answers_to_numbers_and_to_the_machines_name(public: Viewer) -> None:
    query = _query(public)
    for host in ("192.168.1.5:7000", "[2001:db8::1]:7000", socket.gethostname(), "127.0.0.1", "localhost"):
        assert _ask(public, f"/{query}", Host=host).status == 200
    assert _ask(public, f"/{query}", Host="evil.example").status == 403
    assert _ask(public, "/", Host="192.168.1.5:7000").status == 403


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"token": "short"}, "a token is 8 to 256"),
        ({"allow_hosts": ["http://hub.example.org"]}, "without scheme"),
        ({"allow_hosts": ["x; script-src *"]}, "without scheme"),
    ],
)
def test_names_and_tokens_that_are_none_are_refused(nao: nk.NaoModel, options: Any, message: str) -> None:
    with pytest.raises(BadArgument, match=message) as caught:
        Viewer(nao, **options)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 400


def test_every_name_without_a_token_is_refused_and_the_port_is_free_again(nao: nk.NaoModel) -> None:
    port = free_port()
    with pytest.raises(BadArgument, match="needs a token"):
        _ = Viewer(nao, port=port, allow_hosts=["*"], token=False).url
    with Viewer(nao, port=port) as viewer:
        assert _ask(viewer).status == 200


def test_the_token_is_neither_printed_with_the_viewer_nor_given_away(guarded: Viewer) -> None:
    (token,) = parse_qs(_query(guarded)[1:])["token"]
    assert token in guarded.url
    assert token not in repr(guarded)
    answer = _ask(guarded, f"/?token={token}")
    assert token not in answer.text + str(answer.headers)
    assert answer.headers["referrer-policy"] == "no-referrer"
    assert "set-cookie" not in answer.headers


def test_the_page_may_connect_to_nothing_but_its_own_server(viewer: Viewer, guarded: Viewer) -> None:
    def policy(viewer: Viewer, host: str) -> dict[str, str]:
        text = _ask(viewer, f"/{_query(viewer)}", Host=host).headers["content-security-policy"]
        return {part.split()[0]: part.partition(" ")[2] for part in text.split("; ")}

    port = _port(viewer)
    own = policy(viewer, f"127.0.0.1:{port}")
    assert own["default-src"] == "'none'"
    # The loader and the packed scripts, and no other ones.
    served = _ask(viewer, f"/{_query(viewer)}").text
    loaders = re.findall(r"<script>(.*?)</script>", served, re.DOTALL)
    scripts = [*(loader.encode() for loader in loaders), unpacked(served, "scripts")]
    digests = [base64.b64encode(hashlib.sha256(script).digest()).decode() for script in scripts]
    assert own["script-src"].split() == [f"'sha256-{digest}'" for digest in digests]
    assert len(digests) == 2
    assert f"script-src {own['script-src']};" in served
    assert own["connect-src"] == f"'self' ws://127.0.0.1:{port} wss://127.0.0.1:{port}"
    assert policy(viewer, f"[::1]:{port}")["connect-src"] == "'self'"
    frames = own["frame-ancestors"].split()
    assert {"'self'", "http://localhost:*", "http://127.0.0.1:*"} <= set(frames)
    assert "*" not in frames
    assert not any("hub.example.org" in source for source in frames)
    assert "https://hub.example.org:*" in policy(guarded, "hub.example.org")["frame-ancestors"].split()


def test_every_answer_forbids_guessing_types_and_hides_what_serves_it(viewer: Viewer) -> None:
    for answer in (
        _ask(viewer),
        _ask(viewer, "/nothing"),
        _ask(viewer, Host="evil.example"),
        _ask(viewer, method="POST"),
    ):
        assert answer.headers["x-content-type-options"] == "nosniff"
        assert answer.headers["referrer-policy"] == "no-referrer"
        assert "server" not in answer.headers


def test_the_page_travels_compressed_to_whom_takes_it_so(viewer: Viewer) -> None:
    plain = _ask(viewer)
    assert "content-encoding" not in plain.headers
    for accepted in ("gzip", "gzip, deflate, br", "br;q=1.0, GZIP;q=0.5", "deflate, gzip;q=0.1"):
        zipped = _ask(viewer, Accept_Encoding=accepted)
        assert zipped.headers["content-encoding"] == "gzip"
        assert len(zipped.body) < 360_000
        assert gzip.decompress(zipped.body) == plain.body
    for accepted in ("", "br", "gzip;q=0", "gzip; q=0.0", "identity", "notgzip", "x-gzip-not"):
        assert "content-encoding" not in _ask(viewer, Accept_Encoding=accepted).headers
    assert zipped.headers["vary"] == "Accept-Encoding"
    assert zipped.headers["cache-control"] == "no-cache"
    head = _ask(viewer, method="HEAD", Accept_Encoding="gzip")
    assert (head.status, head.body) == (200, b"")
    assert head.headers["content-length"] == str(len(zipped.body))


def test_a_page_that_the_browser_has_does_not_travel_again(viewer: Viewer, guarded: Viewer, nao: nk.NaoModel) -> None:
    tag = _ask(viewer).headers["etag"]
    for known in (tag, f'"other", {tag}', "*", tag.removeprefix("W/")):
        again = _ask(viewer, If_None_Match=known, Accept_Encoding="gzip")
        assert (again.status, again.body) == (304, b"")
        assert again.headers["etag"] == tag
    assert _ask(viewer, If_None_Match='W/"other"').status == 200
    with Viewer(nk.load_nao("v4")) as other:
        assert _ask(other, If_None_Match=tag).status == 200
    assert _ask(guarded, If_None_Match=_ask(guarded, f"/{_query(guarded)}").headers["etag"]).status == 403


def test_nothing_that_is_asked_is_logged(
    viewer: Viewer, guarded: Viewer, caplog: pytest.LogCaptureFixture, capfd: pytest.CaptureFixture
) -> None:
    _ask(viewer, Host="evil.example")
    _ask(viewer, method="POST")
    _ask(viewer, "/live")
    _ask(guarded, "/?token=%ff")
    _connect(viewer, Origin="http://evil.example")
    _connect(guarded, query=_query(guarded), Origin="http://[")
    assert caplog.records == []
    assert capfd.readouterr() == ("", "")


def test_a_fault_of_ours_is_logged_without_the_token(
    guarded: Viewer, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Access, "embedders", lambda self: 1 / 0)
    token = guarded._started().token
    assert _ask(guarded, f"/?token={token}").status == 500
    assert "GET / failed" in caplog.text
    assert "ZeroDivisionError" in caplog.text
    assert token not in caplog.text


@pytest.mark.full
def test_the_command_line_serves_other_names_and_asks_for_a_token() -> None:
    environment = {**os.environ, "PYTHONPATH": str(Path(nk.__file__).parent.parent)}
    command = [sys.executable, "-m", "nao_kin", "view", "--host", "0.0.0.0", "--allow-host", "nao.example"]
    process = subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None
        line = process.stdout.readline()
        match = re.fullmatch(r"http://127\.0\.0\.1:(\d+)/\?token=([\w-]{32})  \(Ctrl-C ends\)\n", line)
        assert match is not None, line
        for host, path, status in (
            ("nao.example", f"/?token={match[2]}", 200),
            ("nao.example", "/", 403),
            ("evil.example", f"/?token={match[2]}", 403),
        ):
            connection = http.client.HTTPConnection("127.0.0.1", int(match[1]), timeout=5.0)
            connection.request("GET", path, headers={"Host": host})
            assert connection.getresponse().status == status
            connection.close()
    finally:
        process.terminate()
        _, err = process.communicate(timeout=10.0)
    assert err == "nao-kin: on another machine, put the name or the address of this one into the page's address\n"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("view", "--allow-host", "http://a/"), "without scheme"),
        (("view", "--allow-host", "*", "--no-token"), "needs a token"),
        (("serve", "--token"), "needs --view"),
        (("serve", "--page-port", "7001"), "--page-port needs --view"),
        (("serve", "--view", "--page-host", " "), "--page-host is empty"),
        (("run", "x.py", "--no-token"), "needs --view"),
        (("view", "--html", "x.html", "--port", "7000"), "are for a live page"),
    ],
)
def test_options_without_a_page_that_they_could_be_for_are_refused(
    capsys: pytest.CaptureFixture, arguments: tuple[str, ...], message: str
) -> None:
    assert run(list(arguments)) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert message in err
    assert err.count("\n") == 1
