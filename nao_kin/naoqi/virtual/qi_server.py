"""The services of a virtual NAO offered to scripts over qi, NAOqi's own protocol."""

from __future__ import annotations

import ipaddress
import socket
import time
from collections.abc import Callable
from typing import Any

from nao_kin._core.arrays import flag, whole_number
from nao_kin._core.text import quoted
from nao_kin._core.warn import warn_caller
from nao_kin.errors import BadArgument, NaoKinError, NaoKinWarning
from nao_kin.naoqi._qi import load_qi
from nao_kin.naoqi.live import PORT
from nao_kin.naoqi.virtual.engine import Call, NaoqiError
from nao_kin.naoqi.virtual.memory import Subscriber
from nao_kin.naoqi.virtual.service import Service
from nao_kin.naoqi.virtual.virtual_nao import VirtualNao

HOST = "127.0.0.1"
# If Pinocchio was loaded before qi, libqi corrupts its memory when a session is closed while the sessions of ended
# scripts are being destroyed: half of the programs that ended right after 40 scripts crashed, and none of those that
# waited a moment. A destroyed session also continues for a moment: two of three programs that ended immediately after
# were aborted.
_SECONDS_TO_SETTLE = 0.3
# Results with a declared type; bytes arrive as text otherwise.
_RETURNS = dict.fromkeys(("getImageRemote", "getImageLocal"), "(iiiiiiriffff)")


class OpenToOthersWarning(NaoKinWarning):
    """The server listens to other machines, and qi has no passwords."""


class QiServer:
    """A stand-alone qi session with the services of a virtual NAO.

        with VirtualNao() as nao, QiServer(nao) as server:
            print(server.endpoint)          # tcp://127.0.0.1:9559

    Scripts connect to it as to a robot. Calls are executed in order of arrival. Blocking methods occupy no thread: they
    return qi's future, so that thousands may wait. Angles travel as doubles; a robot sends floats of 32 bits.

    The first call that needs a compiled kernel, for walking, Cartesian or whole-body control, waits until the kernel is
    loaded, and so do later calls.

    Import `nao_kin.naoqi`, or qi, before you create a robot: qi is not reliable if Pinocchio is loaded first.

    Args:
        nao: the virtual NAO.
        host: the address to listen on; "127.0.0.1" accepts this machine only.
        port: the port to listen on; 0 for a free one.
        quiet: let qi print only fatal errors, in this process; otherwise it reports every connection.

    Attributes:
        endpoint: the address of the server, such as "tcp://127.0.0.1:9559".

    Raises:
        MissingExtra: qi is not installed.
        BadArgument: the port is in use, or the host is not an address of this machine.
    """

    def __init__(self, nao: VirtualNao, *, host: str = HOST, port: int = PORT, quiet: bool = False) -> None:
        number, silent = whole_number(port, "port", 0, 65535), flag(quiet, "quiet")
        qi = load_qi("a server that NAOqi's scripts can connect to")
        if silent:
            qi.logging.setLevel(qi.logging.FATAL)
        self._check_address(host, number)
        self._session = qi.Session()
        self._looked_up: dict[str, Any] = {}
        try:
            self._session.listenStandalone(f"tcp://{f'[{host}]' if ':' in host else host}:{number}")
        except RuntimeError as error:
            reason = " ".join(str(error).partition("[")[0].split())
            raise BadArgument(f"cannot listen on {host}, port {number}: {reason}") from None
        endpoints = self._session.endpoints()
        self.endpoint = next((endpoint for endpoint in endpoints if host in endpoint), endpoints[0])
        nao.machine.services["ALMemory"].module_called = self._call_module
        strand = None
        for name, service in nao.services.items():
            # A missing method returns an error that says that it is missing.
            methods = {method: _forwarded(qi, service, method) for method in (*service.method_names, *service.absent)}
            exported = qi.singleThreaded()(type(name, (), methods))()
            if strand is not None:
                exported.__qi_strand__ = strand
            self._session.registerService(name, exported)
            # qi executes the calls of an object in a strand, one after the other; one strand for all services also
            # keeps the order of calls to different services.
            strand = getattr(exported, "__qi_strand__", None)

    def close(self) -> None:
        """Stop listening; connected scripts get an error. Does nothing if the server is closed already."""
        session, self._session = self._session, None
        if session is not None:
            time.sleep(_SECONDS_TO_SETTLE)
            session.close()
            del session  # this destroys the session
            time.sleep(_SECONDS_TO_SETTLE)

    def __enter__(self) -> QiServer:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _check_address(self, host: str, port: int) -> None:
        """Refuse an address that is not available, and warn of one that other machines can reach."""
        try:
            addresses = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)
        except (OSError, ValueError):
            raise BadArgument(f"host {quoted(host)} is not an address of this machine") from None
        if not all(ipaddress.ip_address(str(row[4][0]).partition("%")[0]).is_loopback for row in addresses):
            warn_caller(
                f"listening on {host}: qi has no passwords, and any client of port {port} can drive the robot",
                OpenToOthersWarning,
            )
        with socket.socket(addresses[0][0], socket.SOCK_STREAM) as probe:
            # As in qi, a port that a server has just left may be reused.
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                probe.bind(addresses[0][4])
            except OSError as error:
                why = error.strerror or error
                raise BadArgument(f"cannot listen on {host}, port {port}: {why}; give another port") from None

    def _call_module(self, module: str, function: str, key: str, value: Any, message: str) -> None:
        """Call a script's own service at an event, without waiting for it."""
        session = self._session
        if session is None:
            return

        def call(service: Any) -> None:
            if not service.hasError():
                service.value().call(function, key, value, message, _async=True)

        # Events in quick succession share one look-up, because qi may fail one of several simultaneous look-ups.
        service_future = self._looked_up.get(module)
        if service_future is None or not service_future.isRunning():
            service_future = self._looked_up[module] = session.service(module, _async=True)
        service_future.addCallback(call)


def _forwarded(qi: Any, service: Service, name: str) -> Callable[..., Any]:
    signals: dict[str, Any] = {}

    def forward(_: Any, *arguments: Any) -> Any:
        try:
            answer = service.invoke(name, *arguments)
        except NaoKinError as error:
            return _failed(qi, str(error))
        except Exception as error:  # the script gets one line, not our traceback
            return _failed(qi, str(NaoqiError(service.name, name, f"internal error: {error!r}")))
        if isinstance(answer, Call):
            return _promised(qi, answer)
        if isinstance(answer, Subscriber):
            with service.nao.monitor:
                if answer.key not in signals:
                    signals[answer.key] = _as_object(qi, _Signalling(qi, answer))
                return signals[answer.key]
        return answer

    forward.__name__, forward.__doc__ = name, service.help(name)
    qi.bind(_RETURNS.get(name))(forward)
    return forward


class _Signalling:
    """A subscriber with a qi signal; there is one for each key, so that scripts that end leave nothing behind."""

    def __init__(self, qi: Any, subscriber: Subscriber) -> None:
        self.signal = qi.Signal("(m)")
        subscriber.connect(self.signal)


def _as_object(qi: Any, thing: object) -> Any:
    """Return a Python object as a qi object, to be reused: qi otherwise makes one for every result, and keeps 8 kB."""
    promise = qi.Promise()
    promise.setValue(thing)
    return promise.future().value()


def _promised(qi: Any, call: Call) -> Any:
    """Return the qi future of a call."""
    promise = qi.Promise(lambda _: call.cancel())

    def settle(done: Any) -> None:
        try:
            if done.cancelled():
                promise.setCanceled()
                return
            error = done.exception()
            if error is None:
                promise.setValue(done.result())
            else:
                promise.setError(str(error))
        except RuntimeError:  # the caller waits no longer
            return

    call.add_done_callback(settle)
    return promise.future()


def _failed(qi: Any, message: str) -> Any:
    """Return a future with exactly this error text; an exception would arrive with its traceback."""
    promise = qi.Promise()
    promise.setError(message)
    return promise.future()
