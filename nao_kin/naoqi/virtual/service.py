"""What all services have in common: which methods they offer, how these are called, and how they refuse."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

from nao_kin._core.text import quoted
from nao_kin._kernels.cache import compiles, warm_up
from nao_kin.errors import BadArgument, NaoKinError, nearest_names
from nao_kin.naoqi.names import joint_names
from nao_kin.naoqi.virtual import arguments
from nao_kin.naoqi.virtual.engine import Call, NaoqiError

if TYPE_CHECKING:
    from nao_kin.naoqi.virtual.virtual_nao import VirtualNao


_F = TypeVar("_F", bound=Callable[..., Any])


def method(function: _F) -> _F:
    """Offer this method of a service to scripts, under its own name."""
    function.is_offered = True  # type: ignore[attr-defined]
    return function


class Service:
    """A service that scripts call by name.

    A subclass sets `name` and marks its methods with `@method`. They take what NAOqi's take, positional arguments only;
    defaults make overloads. They run with the lock held (`nao.monitor`), so they neither wait nor sleep: what takes
    time is a task, and its `Call` is returned. Arguments go through `arguments`; every `NaoKinError` becomes a
    `NaoqiError` that names service and method.

    Args:
        nao: the virtual NAO.

    Attributes:
        name: "ALMotion" …
        absent: methods that NAOqi's service has and this one does not; what is offered after all is taken out of it.
    """

    name: ClassVar[str]
    absent: tuple[str, ...] = ()

    def __init__(self, nao: VirtualNao) -> None:
        self.nao = nao
        kind = type(self)
        offered = [name for name in dir(kind) if getattr(getattr(kind, name), "is_offered", False)]
        self._methods: dict[str, Callable[..., Any]] = {name: getattr(self, name) for name in offered}
        self._signatures = {name: inspect.signature(function) for name, function in self._methods.items()}
        self.absent = tuple(name for name in type(self).absent if name not in self._methods)

    @property
    def method_names(self) -> tuple[str, ...]:
        """What scripts may call, in alphabetical order."""
        return tuple(sorted(self._methods))

    def help(self, name: str) -> str:
        """What a method does; "" for one that is not there."""
        return inspect.getdoc(self._methods[name]) or "" if name in self._methods else ""

    def invoke(self, name: str, *given: Any) -> Any:
        """Call a method by name; a blocking one returns a `Call`.

        Raises:
            NaoqiError: no such method, arguments that do not fit, or the method refuses.
            BadArgument: no name.
        """
        if not isinstance(name, str):
            raise BadArgument(f"method must be a name, got {quoted(name)}")
        function = self._methods.get(name)
        if function is None:
            raise self._no_method(name)
        try:
            self._signatures[name].bind(*given)
        except TypeError:
            takes = ", ".join(self._signatures[name].parameters)
            count = f"{len(given)} argument{'' if len(given) == 1 else 's'}"
            raise NaoqiError(self.name, name, f"takes ({takes}), got {count}") from None
        self._wait_for_kernels(name, given)
        try:
            with self.nao.monitor:
                self.nao.check_open()
                answer = function(*given)
                if isinstance(answer, Call):
                    self.nao.await_answer(answer)
                return answer
        except NaoqiError:
            raise
        except NaoKinError as error:
            raise NaoqiError(self.name, name, str(error)) from None

    def kernels_for(self, name: str, given: tuple[Any, ...]) -> frozenset[str]:
        """Return the compiled kernels of `nk.ik` that a call needs, some of `KERNELS`.

        They are loaded, or compiled, before the lock is taken, and robot time stands still meanwhile. One target of the
        head, a camera or a leg alone needs none: its closed form does not search, and is solved as Python.
        """
        return frozenset()

    def _wait_for_kernels(self, name: str, given: tuple[Any, ...]) -> None:
        missing = self.kernels_for(name, given) - _ready
        if missing:
            with self.nao.time_held():
                if compiles():
                    report(self.nao, f"{self.name}::{name} waits for compiled kernels; robot time stands still")
                make_ready(missing)

    def joints(self, names: Any, what: str = "names") -> tuple[str, ...]:
        """The joints that a name, chain or list of them stands for, each once.

        Raises:
            UnknownName, BadArgument: no such joint or chain; no names; a joint twice.
        """
        found = joint_names(self.nao.robot, names)
        if not found:
            raise BadArgument(f"{what} must name a joint at least")
        if len(set(found)) < len(found):
            twice = next(name for index, name in enumerate(found) if name in found[:index])
            raise BadArgument(f"{what} has {twice} twice")
        return found

    def _no_method(self, name: str) -> NaoqiError:
        if name in self.absent:
            has = ", ".join(self.method_names)
            return NaoqiError(self.name, quoted(name)[1:-1], f"not in this virtual NAO; it has: {has}")
        near = nearest_names(name, (*self._methods, *self.absent))
        advice = f"nearest: {', '.join(near)}" if near else f"it has: {', '.join(self.method_names)}"
        return NaoqiError(self.name, quoted(name)[1:-1], f"no such method ({advice})")

    # --- what every module of NAOqi has ---------------------------------------------------------------------------

    @method
    def ping(self) -> bool:
        """Whether the service is there: True."""
        return True

    @method
    def version(self) -> str:
        """The version of nao_kin."""
        from nao_kin._core import __version__

        return __version__

    @method
    def getMethodList(self) -> list[str]:
        """Names of all methods."""
        return list(self.method_names)

    @method
    def getMethodHelp(self, methodName: Any) -> list[Any]:
        """Name and description of a method."""
        wanted = arguments.choice(methodName, "method", self.method_names)
        return [wanted, self.help(wanted)]

    @method
    def getModuleHelp(self) -> str:
        """What the service is."""
        return inspect.getdoc(type(self)) or ""

    @method
    def getBrokerName(self) -> str:
        """Who runs the service."""
        return "nao-kin"

    @method
    def isRunning(self, id: Any) -> bool:
        """Whether a motion task, by its number in the task list, is not over."""
        return self.nao.tasks.find(arguments.whole(id, "id")) is not None

    @method
    def stop(self, id: Any) -> None:
        """End a motion task, by its number in the task list."""
        self.nao.tasks.kill(arguments.whole(id, "id"))

    @method
    def wait(self, id: Any, timeoutPeriod: Any = 0) -> Call | bool:
        """Wait until a motion task is over, at most some milliseconds, 0 for ever; True if the time ran out first."""
        task = self.nao.tasks.find(arguments.whole(id, "id"))
        seconds = arguments.number(timeoutPeriod, "timeoutPeriod") / 1000.0
        arguments.duration(seconds, "timeoutPeriod", zero=True)
        if task is None:
            return False
        waiting = Call()
        task.call.add_done_callback(lambda _: waiting.finish(False))
        if seconds > 0.0:
            self.nao.clock.after(seconds, lambda: self.nao.monitor.later(lambda: waiting.finish(True)))
        return waiting


KERNELS: tuple[str, ...] = (
    "both legs",
    "projections onto limits",
    "damped least squares",
    "arms by pose",
    "arms by place",
    "bodies",
)
"""The compiled kernels of `nk.ik` that calls need: those of the walk first, which scripts need most."""

_ready: set[str] = set()


def make_ready(kernels: Iterable[str]) -> None:
    """Load compiled kernels from the disk, or compile them; does nothing for those that are loaded."""
    missing = sorted(set(kernels) - _ready, key=KERNELS.index)
    if missing:
        warm_up([f"ik kernel, {name}" for name in missing])
        _ready.update(missing)


def report(nao: VirtualNao, message: str) -> None:
    """Log a message about compiled kernels, and publish it as a `Change` of its own kind, "kernels"."""
    with nao.monitor:
        nao.log.write(message)
        nao.log.change("kernels", message)
