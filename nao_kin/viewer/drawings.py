"""What is drawn over the robot of a viewer, and beside it: the page's buttons, and shapes by their names."""

from __future__ import annotations

from threading import RLock

from nao_kin._core.arrays import choice, flag
from nao_kin._core.text import abbreviated
from nao_kin.errors import BadArgument
from nao_kin.viewer.messages import RetainedMessages, panel_message

# What the page's buttons show and hide, as it begins.
_SHOWN = {"frames": False, "axes": False, "com": False, "support": False, "ghosts": True, "handles": True}
# What a page may say of buttons at once, and how long their names may be.
_MOST_SHOWN = 64
_LONGEST_BUTTON = 40
_MOST_SHAPES = 1000


class Buttons:
    """What the page's buttons show, for all pages alike.

    Attributes:
        shown: name of a button → whether it is on.
    """

    def __init__(self, messages: RetainedMessages, lock: RLock) -> None:
        self._messages, self._lock = messages, lock
        self.shown = dict(_SHOWN)

    def press(self, what: str, on: bool, source: str = "") -> None:
        """Set a button; `source` is the page in which somebody did."""
        message = panel_message("shown", {"shown": {what: flag(on, "on")}, "source": source})
        with self._lock:
            self.shown[what] = bool(on)
            self._messages.put(f"shown {what}", message)

    def draw(self, what: str, message: bytes, *, on: bool) -> None:
        """Put a message that draws something and sets its button; what that one said before is out of date."""
        with self._lock:
            self._messages.put(what, message)
            self.shown[what] = on
            self._messages.drop(f"shown {what}")

    def receive(self, shown: object, source: str) -> None:
        """Take what a page's buttons show."""
        for what, on in list(shown.items())[:_MOST_SHOWN] if isinstance(shown, dict) else ():
            may_begin = len(self.shown) < _MOST_SHOWN and 0 < len(what) <= _LONGEST_BUTTON and what.isprintable()
            if (what in self.shown or may_begin) and isinstance(on, bool) and self.shown.get(what) is not on:
                self.press(what, on, source)


class Extras:
    """Shapes that are no part of a robot, by their names."""

    def __init__(self, messages: RetainedMessages, lock: RLock) -> None:
        self._messages, self._lock = messages, lock
        self._names: dict[str, None] = {}

    def add(self, name: str, message: bytes) -> None:
        """Put the message that draws a shape instead of the one of the same name.

        Raises:
            BadArgument: too many shapes.
        """
        with self._lock:
            if name not in self._names and len(self._names) >= _MOST_SHAPES:
                raise BadArgument(f"at most {_MOST_SHAPES} shapes are drawn; remove some before {abbreviated(name)}")
            self._names[name] = None
            self._messages.put(_key(name), message)
            self._list()

    def remove(self, name: str) -> None:
        """Take a shape away.

        Raises:
            UnknownName: there is none.
        """
        with self._lock:
            del self._names[choice(name, self._names, "shape")]
            self._messages.drop(_key(name))
            self._list()

    def _list(self) -> None:
        """Which shapes there are: a page forgets all others, whatever it has missed."""
        self._messages.put("extras", panel_message("extras", {"names": list(self._names)}))


def _key(name: str) -> str:
    """The key of a shape's message, which begins no other one: `drop` goes by beginnings."""
    return f"extra {len(name)} {name}"
