"""The base of all services: their methods, calls by scripts, and errors."""

from __future__ import annotations

import functools
import inspect
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from nao_kin._core.text import abbreviated, nearest_names, quoted
from nao_kin._kernels.cache import compiles, warm_up
from nao_kin.errors import BadArgument, NaoKinError
from nao_kin.naoqi.conventions import joint_names
from nao_kin.naoqi.virtual import arguments
from nao_kin.naoqi.virtual.arguments import Delay, Whole
from nao_kin.naoqi.virtual.engine import Call, NaoqiError
from nao_kin.naoqi.virtual.machine import Machine

# The methods of NAOqi 1.14 to 2.8 that are missing here, by service; and the missing services with their methods, by
# reason. "*" stands for the methods of every extractor.
ABSENT: dict[str, Any] = json.loads((Path(__file__).parent / "absent_methods.json").read_text(encoding="utf-8"))
# Public methods of every service that are not offered to scripts.
_INTERNAL = frozenset(("help", "invoke", "joints", "kernels_for"))


class Service:
    """A service that scripts call by its `name`, such as "ALMotion".

    The methods of NAOqi's service that it lacks are `absent`. As qi does with a Python object, its public methods are
    offered to scripts. They take NAOqi's positional arguments; annotations such as `arguments.Share` say how a value is
    read, and default values replace overloads. They run with the lock held (`nao.monitor`), so they must not wait or
    sleep: a method that takes time starts a task and returns its `Call`.
    Every `NaoKinError` becomes a `NaoqiError`.
    """

    name: str

    def __init__(self, nao: Machine) -> None:
        self.nao = nao
        self.absent = tuple(ABSENT["absent"].get(self.name, "").split())
        self.takes = _offered(type(self))  # type: ignore[arg-type]  # mypy looks at the hash of instances
        self._methods: dict[str, Callable[..., Any]] = {name: getattr(self, name) for name in self.takes}
        # The values of `stored` methods.
        self.stored: dict[Any, Any] = {}

    @property
    def method_names(self) -> tuple[str, ...]:
        """The methods that scripts may call, in alphabetical order."""
        return tuple(sorted(self._methods))

    def help(self, name: str) -> str:
        """Return the description of a method; "" for an unknown one, and a reference for a second name of a method."""
        method = self._methods.get(name)
        if method is None:
            return ""
        other = method.__name__
        return f"The same as {other}." if other != name and other in self._methods else inspect.getdoc(method) or ""

    def invoke(self, name: str, *given: Any) -> Any:
        """Call a method by name; a blocking method returns a `Call`. Every error is a `NaoqiError`."""
        function = self._methods.get(name)
        if function is None:
            raise self._no_method(name)
        try:
            self.takes[name].bind(*given)
        except TypeError:
            takes = ", ".join(self.takes[name].parameters)
            count = f"{len(given)} argument{'' if len(given) == 1 else 's'}"
            raise NaoqiError(self.name, name, f"takes ({takes}), got {count}") from None
        missing = self.kernels_for(name, given) - _ready
        if missing:
            _make_ready(self.nao, f"{self.name}::{name}", missing)
        try:
            with self.nao.monitor:
                self.nao.check_open()
                answer = function(*_values(self.takes[name], given))
                if isinstance(answer, Call):
                    self.nao.await_answer(answer)
                return answer
        except NaoqiError:
            raise
        except NaoKinError as error:
            raise NaoqiError(self.name, name, str(error)) from None

    def kernels_for(self, name: str, given: tuple[Any, ...]) -> frozenset[str]:
        """Return the names of the compiled kernels of `nk.ik` that a call needs.

        They are loaded, or compiled, before the lock is taken. Single targets of the head or a camera need no kernels:
        their closed forms run as Python.
        """
        return frozenset()

    def joints(self, names: Any, what: str = "names") -> tuple[str, ...]:
        """Return the joints of a name, a chain or a list of names; reject an empty list and repeated joints."""
        joints = joint_names(self.nao.robot, names)
        if not joints:
            raise BadArgument(f"{what} must name at least one joint")
        if len(set(joints)) < len(joints):
            twice = next(name for index, name in enumerate(joints) if name in joints[:index])
            raise BadArgument(f"{what} has {twice} twice")
        return joints

    def _no_method(self, name: str) -> NaoqiError:
        methods = abbreviated(f"it has: {', '.join(self.method_names)}", 600)
        if name in self.absent:
            return NaoqiError(self.name, quoted(name)[1:-1], f"not in this virtual NAO; {methods}")
        near = nearest_names(name, (*self._methods, *self.absent))
        advice = f"nearest: {', '.join(near)}" if near else methods
        return NaoqiError(self.name, quoted(name)[1:-1], f"no such method ({advice})")

    # --- the methods of every module of NAOqi ---------------------------------------------------------------------

    def ping(self) -> bool:
        """True: the service is running."""
        return True

    def version(self) -> str:
        """The version of nao_kin."""
        from nao_kin._core import __version__

        return __version__

    def getMethodList(self) -> list[str]:
        """Names of all methods."""
        return list(self.method_names)

    def getMethodHelp(self, methodName: Any) -> list[Any]:
        """Name and description of a method."""
        wanted = arguments.choice(methodName, "method", self.method_names)
        return [wanted, self.help(wanted)]

    def getModuleHelp(self) -> str:
        """The description of the service."""
        return inspect.getdoc(type(self)) or ""

    def getBrokerName(self) -> str:
        """The program that runs the service."""
        return "nao-kin"

    def isRunning(self, id: Whole) -> bool:
        """Whether a motion task, by its number in the task list, is running or waiting."""
        return self.nao.tasks.find(id) is not None

    def stop(self, id: Whole) -> None:
        """End a motion task, by its number in the task list."""
        self.nao.tasks.kill(lambda task: task.id == id)

    def wait(self, id: Whole, timeoutPeriod: Delay = 0) -> Call | bool:
        """Wait until a motion task is over, at most some milliseconds (0: no limit); True if the time ran out first."""
        task, seconds = self.nao.tasks.find(id), timeoutPeriod / 1000.0
        if task is None:
            return False
        waiting = Call()
        task.call.add_done_callback(lambda _: waiting.finish(False))
        if seconds > 0.0:
            self.nao.clock.after(seconds, lambda: self.nao.monitor.later(lambda: waiting.finish(True)))
        return waiting


SetterAndGetter = tuple[Callable[..., Any], Callable[..., Any]]


@functools.cache  # to find out takes longer than all else of a new virtual NAO
def _offered(kind: type[Service]) -> dict[str, inspect.Signature]:
    """Return the methods that a service offers to scripts, and what they take after `self`."""
    methods = {name: getattr(kind, name) for name in dir(kind) if not name.startswith("_") and name not in _INTERNAL}
    bound = {name: functools.partial(method, None) for name, method in methods.items() if callable(method)}
    return {name: inspect.signature(method, eval_str=True) for name, method in bound.items()}


def _values(takes: inspect.Signature, given: tuple[Any, ...]) -> list[Any]:
    """Return the values of the arguments that a script gave, read by the kinds of the parameters."""
    values = list(given)
    for index, (parameter, value) in enumerate(zip(takes.parameters.values(), given, strict=False)):
        for read in getattr(parameter.annotation, "__metadata__", ()):
            values[index] = read(value, parameter.name)
    return values


def stored(what: str, read: Callable[[Any, str], Any], initially: Any, answer: bool | None = None) -> SetterAndGetter:
    """Return the setter, with its answer, and the getter of a value that a service only stores, as the log says."""

    def setter(self: Service, value: Any) -> bool | None:
        self.stored[what] = read(value, what)
        self.nao.log.write(f"{what} = {self.stored[what]}: stored, without effect")
        return answer

    def getter(self: Service) -> Any:
        return self.stored.get(what, initially)

    setter.__doc__ = f"Set the {what}; stored, without effect."
    getter.__doc__ = f"The stored value; initially {initially!r}."
    return setter, getter


# The compiled kernels of `nk.ik` that calls have loaded.
_ready: set[str] = set()


def _make_ready(nao: Machine, call: str, kernels: frozenset[str]) -> None:
    """Load compiled kernels from the disk, or compile them, before a call takes the lock."""
    if compiles():
        message = f"{call} waits for compiled kernels"
        with nao.monitor:
            nao.log.write(message)
            nao.log.change("kernels", message)
    warm_up([f"ik kernel, {name}" for name in sorted(kernels)])
    _ready.update(kernels)
