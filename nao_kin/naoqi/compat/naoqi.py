"""The module `naoqi` that old scripts import: proxies, a broker and modules, on top of qi.

Aldebaran's own module is for Python 2. This module has the parts that scripts use:

    from naoqi import ALProxy
    motion = ALProxy("ALMotion", "127.0.0.1", 9559)
    motion.wakeUp()
    task = motion.post.angleInterpolation("HeadYaw", 0.5, 1.0, True)   # does not wait
    motion.wait(task, 0)

If the environment variable NAO_KIN_ENDPOINT is set, every proxy connects there, whatever address a script gives.
"""

from __future__ import annotations

import importlib
import inspect
import itertools
import os
import sys
import threading
import traceback
from collections.abc import Callable
from typing import Any

import qi

__all__ = ["ALBroker", "ALModule", "ALProxy"]


ENDPOINT_VARIABLE = "NAO_KIN_ENDPOINT"
DEFAULT_PORT = 9559

_sessions: dict[str, Any] = {}
_lock = threading.Lock()
_broker: ALBroker | None = None
_redirected: set[str] = set()


def __getattr__(name: str) -> Any:
    """Load `motion`, which Aldebaran's package contains too."""
    if name != "motion":
        raise AttributeError(f"module 'naoqi' has no attribute {name!r}")
    return importlib.import_module("nao_kin.naoqi.compat.motion")


class ALProxy:
    """A service of a robot, with the methods of the service.

    Make it with `ALProxy(name, ip, port)`, `ALProxy(name, broker)`, or, after an `ALBroker`, `ALProxy(name)`. The
    methods of its `post` do not wait, and return a number for `wait`, `isRunning` and `stop`. As in NAOqi, errors are
    RuntimeError.
    """

    def __init__(self, name: str, *where: Any) -> None:
        self._name = name
        session = _session_of(where)
        try:
            self._service = session.service(name)
        except RuntimeError:
            services = ", ".join(_services(session))
            raise RuntimeError(f"ALProxy::ALProxy\n\tCan't find service: {name}; there are: {services}") from None
        self._tasks: dict[int, Any] = {}
        self._numbers = itertools.count(1)
        self.post = _Post(self)

    def __getattr__(self, method: str) -> Callable[..., Any]:
        if method.startswith("__"):  # Python's own attributes are not methods of a robot
            raise AttributeError(method)

        def call(*arguments: Any, **named: Any) -> Any:
            return self.call(method, *arguments, *named.values())

        call.__name__ = method
        return call

    def call(self, method: str, *arguments: Any) -> Any:
        """Call a method by name, and wait for its answer."""
        self._check(method)
        return self._service.call(method, *arguments)

    def pCall(self, method: str, *arguments: Any) -> int:
        """Call a method by name without waiting; return a number for `wait`, `isRunning` and `stop`."""
        self._check(method)
        number = next(self._numbers)
        future = self._service.call(method, *arguments, _async=True)
        self._tasks[number] = future
        future.addCallback(lambda done: self._over(number, done))
        return number

    def wait(self, number: int, timeout: int = 0) -> bool:
        """Wait until a posted call is over, at most `timeout` ms (0: no limit); return whether it is still running."""
        future = self._tasks.get(int(number))
        if future is not None:
            future.wait(*((int(timeout),) if timeout else ()))
        return self.isRunning(number)

    def isRunning(self, number: int) -> bool:
        """Whether a posted call is still running."""
        future = self._tasks.get(int(number))
        return future is not None and bool(future.isRunning())

    def stop(self, number: int) -> None:
        """Stop a posted call."""
        future = self._tasks.get(int(number))
        if future is not None:
            future.cancel()

    def _check(self, method: str) -> None:
        if not hasattr(self._service, method):
            methods = ", ".join(name for name in dir(self._service) if not name.startswith("_"))
            raise RuntimeError(f"ALProxy::{method}\n\t{self._name} has no method {method}; it has: {methods}")

    def _over(self, number: int, done: Any) -> None:
        self._tasks.pop(number, None)
        if done.hasError():
            sys.stderr.write(f"naoqi: {self._name}, posted call {number}: {done.error()}\n")

    def __repr__(self) -> str:
        return f"<ALProxy of {self._name}>"


class _Post:
    """The methods of a proxy, called without waiting."""

    def __init__(self, proxy: ALProxy) -> None:
        self._proxy = proxy

    def __getattr__(self, method: str) -> Callable[..., int]:
        if method.startswith("__"):
            raise AttributeError(method)
        return lambda *arguments: self._proxy.pCall(method, *arguments)


class ALBroker:
    """A connection to the robot at parentIP and parentPort for the proxies and modules of a script."""

    def __init__(self, name: str, ip: str = "", port: int = 0, parentIP: str = "", parentPort: int = 0) -> None:
        global _broker
        self.name = name
        self.session = _connected(parentIP or "127.0.0.1", parentPort or DEFAULT_PORT)
        _broker = self

    def shutdown(self) -> None:
        """Forget the connection; existing proxies keep it."""
        global _broker
        if _broker is self:
            _broker = None

    def getName(self) -> str:
        """The name given."""
        return self.name


class ALModule:
    """The base of a script's modules, whose methods a robot calls at events; needs an `ALBroker`.

    class Listener(ALModule):
        def onTouched(self, key, value, message): ...

    listener = Listener("listener")
    memory.subscribeToEvent("FrontTactilTouched", "listener", "onTouched")
    """

    def __init__(self, name: str) -> None:
        self._module_name = name
        session = _session_of(())
        methods = {key: _method(self, key) for key in dir(type(self)) if not key.startswith("_") and key not in _OWN}
        self._number = session.registerService(name, type(name, (), methods)())

    def getName(self) -> str:
        """The name given."""
        return self._module_name

    def BIND_PYTHON(self, name: str, method: str) -> None:
        """Without effect: all methods are offered here."""

    def exit(self) -> None:
        """Unregister the module."""
        number, self._number = self._number, None
        if number is not None:
            _session_of(()).unregisterService(number)


_OWN = ("getName", "exit", "BIND_PYTHON")


def _method(module: ALModule, name: str) -> Callable[..., Any]:
    def forward(_: Any, *arguments: Any) -> Any:
        method = getattr(module, name)
        try:
            return method(*arguments[: _max_arguments(method)])
        except Exception:  # the robot does not report the error to the script
            traceback.print_exc()
            raise

    forward.__name__, forward.__doc__ = name, getattr(getattr(type(module), name), "__doc__", None)
    return forward


def _max_arguments(method: Callable[..., Any]) -> int | None:
    """Return how many of an event's three arguments a method takes; None for all."""
    parameters = inspect.signature(method).parameters.values()
    if any(one.kind is one.VAR_POSITIONAL for one in parameters):
        return None
    return sum(one.kind in (one.POSITIONAL_ONLY, one.POSITIONAL_OR_KEYWORD) for one in parameters)


def _session_of(where: tuple[Any, ...]) -> Any:
    """Return the session for the arguments after a proxy's name."""
    if where and isinstance(where[0], ALBroker):
        return where[0].session
    if len(where) == 2:
        return _connected(str(where[0]), int(where[1]))
    if where:
        raise RuntimeError(
            "ALProxy::ALProxy\n\texpected ALProxy(name), ALProxy(name, broker) or ALProxy(name, ip, port)"
        )
    if _broker is not None:
        return _broker.session
    if os.environ.get(ENDPOINT_VARIABLE):
        return _connected("127.0.0.1", DEFAULT_PORT)
    raise RuntimeError("ALProxy::ALProxy\n\tno broker: make an ALBroker first, or give the robot's address and port")


def _services(session: Any) -> list[str]:
    """Return the names of the robot's services that answer a ping; the missing services of a virtual NAO do not."""
    names = sorted(row["name"] for row in session.service("ServiceDirectory").services())
    return [name for name in names if hasattr(session.service(name), "ping")]


def _connected(ip: str, port: int) -> Any:
    """Return the session for an address; the whole script shares it."""
    asked = f"tcp://{f'[{ip}]' if ':' in ip else ip}:{port}"
    endpoint = os.environ.get(ENDPOINT_VARIABLE) or asked
    with _lock:
        if endpoint != asked and asked not in _redirected:
            _redirected.add(asked)
            sys.stderr.write(f"naoqi: {endpoint} answers in place of {asked}\n")
        session = _sessions.get(endpoint)
        if session is None or not session.isConnected():
            qi.logging.setLevel(qi.logging.FATAL)  # qi reports every connection otherwise
            session = qi.Session()
            try:
                session.connect(endpoint)
            except RuntimeError as error:
                reason = " ".join(str(error).split())
                raise RuntimeError(f"ALProxy::ALProxy\n\tcannot connect to {endpoint}: {reason}") from None
            _sessions[endpoint] = session
        return session
