"""A program's own buttons, sliders, selects and texts in the panel of the page."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Any

from nao_kin._core.arrays import choice
from nao_kin._core.text import abbreviated, quoted
from nao_kin.errors import BadArgument, NaoKinError
from nao_kin.viewer.messages import RetainedMessages, packed, panel_message
from nao_kin.viewer.overlays import checked_name, number
from nao_kin.viewer.shown_scene import Changes

_MAX_CONTROLS, _MAX_OPTIONS, _LONGEST_TEXT, _LONGEST_UNIT = 100, 1000, 10_000, 20
# Presses of a button that wait for a slow callback; further ones are counted, but cause no call.
_MAX_WAITING = 16

Value = float | int | str


class Control:
    """A button, slider, select or text in the panel of the page, made by `Viewer.add_button` and the like.

    Attributes:
        name: its name in the page.

    Examples:
        >>> viewer = nk.Viewer(nk.load_nao())
        >>> speed = viewer.add_slider("speed", 0.0, 2.0, 1.0, unit="m/s")
        >>> speed
        <Control speed: 1.0>
    """

    def __init__(
        self,
        name: str,
        row: Mapping[str, Any],
        value: Value,
        checked: Callable[[Any], Value],
        callback: Callable[..., object] | None,
        controls: Controls,
    ) -> None:
        self.name = name
        self._value: Any = value
        self._row, self._checked, self._source = row, checked, controls.source()
        self._callback, self._controls = callback, controls

    @property
    def value(self) -> Any:
        """The current value: the number of a slider, the option of a select, a text, or how often a button was pressed.

        Setting it changes it in all pages, and does not call `on_change`. That of a button cannot be set.

        Raises:
            BadArgument: the new value is outside the slider's range or no text, or the control was removed or replaced.
            UnknownName: the new value is not an option.

        Examples:
            >>> speed = nk.Viewer(nk.load_nao()).add_slider("speed", 0.0, 2.0)
            >>> speed.value = 1.5
            >>> speed.value
            1.5
        """
        return self._value

    @value.setter
    def value(self, value: Value) -> None:
        if self._row["kind"] == "button":
            raise BadArgument(f"{abbreviated(self.name)} is a button: its value counts its presses and cannot be set")
        self._controls.set(self, self._checked(value), self._controls.source())

    def remove(self) -> None:
        """Remove the control from the page; does nothing the second time.

        Examples:
            >>> nk.Viewer(nk.load_nao()).add_button("go").remove()
        """
        self._controls.remove(self)

    def __repr__(self) -> str:
        return f"<Control {self.name}{f': {self._value}' if self._controls.has(self) else ', removed'}>"


class Controls:
    """The controls of a viewer, by name, in the order in which they were added."""

    def __init__(self, messages: RetainedMessages, lock: threading.RLock, changes: Changes) -> None:
        self._messages, self._lock, self._changes = messages, lock, changes
        self._controls: dict[str, Control] = {}
        self.source = messages.source

    def button(self, name: str, on_click: Callable[[], object] | None) -> Control:
        """Add a button."""
        return self._add(Control(checked_name(name), {"kind": "button"}, 0, lambda _: 0, on_click, self), "on_click")

    def slider(
        self,
        name: str,
        low: float,
        high: float,
        value: float | None,
        on_change: Callable[[float], object] | None,
        unit: str,
    ) -> Control:
        """Add a slider; its value is `low` if none is given."""
        ends = number(low, "low"), number(high, "high")
        if not (ends[0] < ends[1] and math.isfinite(ends[1] - ends[0])):
            raise BadArgument(f"a slider needs low < high, got {ends[0]:g} and {ends[1]:g}")
        checked = partial(_in_range, ends)
        row = {"kind": "slider", "low": ends[0], "high": ends[1], "unit": _text(unit, "unit", _LONGEST_UNIT)}
        at_first = checked(ends[0] if value is None else value)
        return self._add(Control(checked_name(name), row, at_first, checked, on_change, self), "on_change")

    def select(
        self, name: str, options: Iterable[str], value: str | None, on_change: Callable[[str], object] | None
    ) -> Control:
        """Add a select; its value is the first option if none is given."""
        if isinstance(options, str) or not isinstance(options, Iterable):
            raise BadArgument(f"options must be a list of texts, got {quoted(options)}")
        rows = [checked_name(option) for option in options]
        if not 0 < len(rows) <= _MAX_OPTIONS or len(set(rows)) < len(rows):
            raise BadArgument(f"options must be 1 to {_MAX_OPTIONS} different texts, got {abbreviated(rows)}")
        checked = partial(choice, valid=tuple(rows), what="option")
        row = {"kind": "select", "options": rows}
        at_first = checked(rows[0] if value is None else value)
        return self._add(Control(checked_name(name), row, at_first, checked, on_change, self), "on_change")

    def text(self, name: str, value: str, on_change: Callable[[str], object] | None) -> Control:
        """Add a text; a user can edit it if there is a function to call."""
        checked = partial(_text, what="value", longest=_LONGEST_TEXT)
        row = {"kind": "text", "edited": on_change is not None}
        return self._add(Control(checked_name(name), row, checked(value), checked, on_change, self), "on_change")

    def _add(self, control: Control, what: str) -> Control:
        """Add a control, whose function is the argument `what`."""
        if not (control._callback is None or callable(control._callback)):
            raise BadArgument(f"{what} must be a function, got {quoted(control._callback)}")
        with self._lock:
            if control.name not in self._controls and len(self._controls) >= _MAX_CONTROLS:
                raise BadArgument(
                    f"at most {_MAX_CONTROLS} controls are shown; remove some before {abbreviated(control.name)}"
                )
            self._controls[control.name] = control
            self._send()
        return control

    def has(self, control: Control) -> bool:
        """Return whether a control was neither removed nor replaced."""
        return self._controls.get(control.name) is control

    def set(self, control: Control, value: Value, source: str) -> None:
        """Set a value; `source` names the change."""
        with self._lock:
            if not self.has(control):
                raise BadArgument(f"{abbreviated(control.name)} was removed from the viewer")
            control._value, control._source = value, source
            self._send()

    def remove(self, control: Control) -> None:
        """Remove a control, if it is there."""
        with self._lock:
            if self.has(control):
                del self._controls[control.name]
                self._send()

    def receive(self, name: object, value: object, source: str) -> None:
        """Take a value that a user set in a page, and call the function of the control; other values are ignored."""
        control = self._controls.get(name) if isinstance(name, str) else None
        if control is None or (control._row.get("edited") is False):
            return
        with self._lock:
            try:
                pressed = control._row["kind"] == "button"
                self.set(control, control._value + 1 if pressed else control._checked(value), source)
            except NaoKinError:
                return
        if control._callback is not None:
            what = f"{'on_click' if pressed else 'on_change'} of {control.name}"
            key = (control, control._value % _MAX_WAITING) if pressed else control
            self._changes.call(key, partial(self._tell, control, pressed), what)

    def _tell(self, control: Control, pressed: bool) -> None:
        if self.has(control) and control._callback is not None:
            control._callback(*(() if pressed else (control.value,)))

    def _send(self) -> None:
        rows = [
            {"name": control.name, "value": control._value, "source": control._source, **control._row}
            for control in self._controls.values()
        ]
        self._messages.put("controls", panel_message("controls", {"controls": rows}))


def _in_range(ends: tuple[float, float], value: float) -> float:
    found = number(value, "value")
    if not ends[0] <= found <= ends[1]:
        raise BadArgument(f"value must be from {ends[0]:g} to {ends[1]:g}, got {found:g}")
    return found


def _text(value: str, what: str, longest: int) -> str:
    if not isinstance(value, str) or len(value) > longest:
        raise BadArgument(f"{what} must be a text of at most {longest} characters, got {quoted(value, 60)}")
    packed(value)  # refuses texts that cannot be sent
    return value
