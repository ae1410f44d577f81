"""What all services have in common: which methods they offer, how these are called, and how they refuse."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from inspect import Parameter
from typing import TYPE_CHECKING, Any, TypeVar

from nao_kin._core.text import quoted
from nao_kin._kernels.cache import compiles, warm_up
from nao_kin.errors import BadArgument, NaoKinError, nearest_names
from nao_kin.naoqi.names import joint_names
from nao_kin.naoqi.virtual import arguments
from nao_kin.naoqi.virtual.engine import Call, NaoqiError

if TYPE_CHECKING:
    from nao_kin.naoqi.virtual.virtual_nao import VirtualNao


_S = TypeVar("_S", bound="Service")


# Methods of every service that are for this library, and not for scripts.
_OWN = frozenset(("help", "invoke", "joints", "keep", "kept", "kernels_for"))


class Service:
    """A service that scripts call by name.

    A subclass sets `name`. As qi does with a Python object, its public methods are offered to scripts, under their own
    names; what is not for them begins with an underscore. They take what NAOqi's take, positional arguments only;
    defaults make overloads. They run with the lock held (`nao.monitor`), so they neither wait nor sleep: what takes
    time is a task, and its `Call` is returned. Arguments go through `arguments`; every `NaoKinError` becomes a
    `NaoqiError` that names service and method.

    Args:
        nao: the virtual NAO.

    Attributes:
        name: "ALMotion" …
        absent: methods that NAOqi's service has and this one does not.
    """

    name: str
    absent: tuple[str, ...] = ()

    def __init__(self, nao: VirtualNao) -> None:
        self.nao = nao
        self._kept: dict[tuple[str, str], Any] = {}
        kind = type(self)
        public = [name for name in dir(kind) if not name.startswith("_") and name not in _OWN]
        offered = [name for name in public if callable(getattr(kind, name))]
        self._methods: dict[str, Callable[..., Any]] = {name: getattr(self, name) for name in offered}
        self._signatures = {name: inspect.signature(function) for name, function in self._methods.items()}

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
        missing = self.kernels_for(name, given) - _ready
        if missing:
            with self.nao.time_held():
                if compiles():
                    report(self.nao, f"{self.name}::{name} waits for compiled kernels; robot time stands still")
                make_ready(missing)
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

    def kept(self, row: Kept, *given: Any) -> Any:
        """A kept value, of the name that is given where there are several."""
        return self._kept.get((row.name, row.whose(given)), row.first)

    def keep(self, row: Kept, *given: Any) -> bool | None:
        """Set it; "Arms" are both arms."""
        of, value = row.whose(given), row.check(given[-1], row.what or row.takes[-1])
        for each in (of, "LArm", "RArm") if of == "Arms" else (of,):
            self._kept[row.name, each] = value
        if row.log:
            on = "on" if value else "off"
            self.nao.log.write(f"{row.log}{f' of {of}' if of else ''} is {on}; it is not simulated")
        return row.answer

    def _no_method(self, name: str) -> NaoqiError:
        if name in self.absent:
            has = ", ".join(self.method_names)
            return NaoqiError(self.name, quoted(name)[1:-1], f"not in this virtual NAO; it has: {has}")
        near = nearest_names(name, (*self._methods, *self.absent))
        advice = f"nearest: {', '.join(near)}" if near else f"it has: {', '.join(self.method_names)}"
        return NaoqiError(self.name, quoted(name)[1:-1], f"no such method ({advice})")

    # --- what every module of NAOqi has ---------------------------------------------------------------------------

    def ping(self) -> bool:
        """Whether the service is there: True."""
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
        """What the service is."""
        return inspect.getdoc(type(self)) or ""

    def getBrokerName(self) -> str:
        """Who runs the service."""
        return "nao-kin"

    def isRunning(self, id: Any) -> bool:
        """Whether a motion task, by its number in the task list, is not over."""
        return self.nao.tasks.find(arguments.whole(id, "id")) is not None

    def stop(self, id: Any) -> None:
        """End a motion task, by its number in the task list."""
        self.nao.tasks.kill(arguments.whole(id, "id"))

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
            self.nao.after(seconds).add_done_callback(lambda _: waiting.finish(True))
        return waiting


# --- Methods that are made from tables: values that are kept and not simulated, and former names.


@dataclass(frozen=True)
class Kept:
    """A value that scripts set and read, and that changes nothing here.

    Attributes:
        name: of the two methods, behind "set" and "get".
        note: the help of the first.
        first: the value at first.
        takes: its parameters, the value last; the first of two says whose value it is.
        check: the value from what is given and what a refusal calls it.
        what: what a refusal calls it; the parameter's name where this is "".
        of: what the first of two parameters is called, and what it may be; any text where this is None.
        log: what the log calls it where setting it is logged.
        answer: what setting it returns.
        read: the help of the second method; "" for what most say.
    """

    name: str
    note: str
    first: Any
    takes: tuple[str, ...]
    check: Callable[[Any, str], Any]
    what: str = ""
    of: tuple[str, tuple[str, ...]] | None = None
    log: str = ""
    answer: bool | None = None
    read: str = ""

    def whose(self, given: tuple[Any, ...]) -> str:
        """The name that a call is about; "" where there is one value only."""
        if len(self.takes) == 1:
            return ""
        return arguments.text(given[0], self.takes[0]) if self.of is None else arguments.choice(given[0], *self.of)


def keeps(*rows: Kept) -> Callable[[type[_S]], type[_S]]:
    """Give a service the methods that set and read kept values."""

    def completed(kind: type[_S]) -> type[_S]:
        for row in rows:
            first = {str: '"{}"', float: "{:g} m"}.get(type(row.first), "{}").format(row.first)
            read = row.read or f"As it was set; at first {first}."
            _offer(kind, f"set{row.name}", row.takes, row.note, Service.keep, row)
            _offer(kind, f"get{row.name}", row.takes[:-1], read, Service.kept, row)
        return kind

    return completed


def formerly(note: str = "As {}.", **names: str) -> Callable[[type[_S]], type[_S]]:
    """Offer methods of a service under former names too: former name → name, which `note` says."""

    def completed(kind: type[_S]) -> type[_S]:
        for former, name in names.items():
            _, *takes = inspect.signature(getattr(kind, name)).parameters.values()
            _offer(kind, former, takes, note.format(name), _call, name)
        return kind

    return completed


def answers(**fixed: tuple[Any, str]) -> Callable[[type[_S]], type[_S]]:
    """Give a service methods that always answer the same: name → what, and the method's help."""

    def completed(kind: type[_S]) -> type[_S]:
        for name, (answer, note) in fixed.items():
            _offer(kind, name, (), note, lambda _, same: same, answer)
        return kind

    return completed


def variants(of: str, does: str, **rows: tuple[str, str]) -> Callable[[type[_S]], type[_S]]:
    """Offer variants of a method: name → what their first parameters are called instead, and the help.

    Args:
        of: the method that they are variants of.
        does: what is called with the variant's name and its arguments.
        rows: of each variant its parameters' names and its help.
    """

    def completed(kind: type[_S]) -> type[_S]:
        _, *takes = inspect.signature(getattr(kind, of)).parameters.values()
        for name, (called, note) in rows.items():
            own = [each.replace(name=new) for new, each in zip(called.split(), takes, strict=False)]
            _offer(kind, name, (*own, *takes[len(own) :]), note, _call, does, name)
        return kind

    return completed


def _call(service: Service, name: str, *given: Any) -> Any:
    return getattr(service, name)(*given)


_PLACED = Parameter.POSITIONAL_OR_KEYWORD


def _offer(
    kind: type[Service], name: str, takes: Iterable[str | Parameter], note: str, does: Callable[..., Any], *about: Any
) -> None:
    """Offer a method that calls a function with the service, what it is about, and the arguments."""

    def offered(self: Service, *given: Any) -> Any:
        return does(self, *about, *given)

    order = [each if isinstance(each, Parameter) else Parameter(each, _PLACED) for each in ("self", *takes)]
    offered.__name__, offered.__doc__ = name, note
    offered.__signature__ = inspect.Signature(order)  # type: ignore[attr-defined]
    setattr(kind, name, offered)


# --- Compiled kernels that calls need.

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
