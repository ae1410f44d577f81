"""The page in a notebook: static in the cell's output, and live if there is a kernel.

A cell's output is the static page in a frame, which also works in an exported notebook. An invisible anywidget, the
bridge, connects the frame to the kernel through the kernel's own channel: the kernel may run on any machine, and only
the notebook's port must be reachable.
"""

from __future__ import annotations

import html
import secrets
import threading
import weakref
from collections.abc import Callable
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from nao_kin._core.extras import command
from nao_kin.viewer.messages import RetainedMessages, note_last
from nao_kin.viewer.server import Answer, weak_receiver

_SCRIPT = Path(__file__).resolve().parent / "page" / "bridge.js"
# The time between two frames of a common screen.
_PAUSE_SECONDS = 1.0 / 30.0


def frame(page: str, name: str = "") -> str:
    """Return the HTML of a page as a frame of another document; the bridge finds the frame by `name`."""
    named = f' data-nao-kin="{html.escape(name)}"' if name else ""
    style = "width: 100%; height: 620px; border: 0"
    inner = (
        f'<iframe{named} title="Robot viewer" srcdoc="{html.escape(page)}" style="{style}" allow="fullscreen"></iframe>'
    )
    return f"<div>{inner}</div>"  # IPython.display.HTML warns of text that is an iframe alone


NOT_LIVE = (
    "<p>The robot as it was when the cell ran. "
    f"With <code>{command('notebook')}</code> it follows what later cells do.</p>"
)


def has_bridge() -> bool:
    """Return whether anywidget, which the bridge needs, is installed."""
    return find_spec("anywidget") is not None


class Bridge:
    """A connection of a frame in a notebook to the messages of a viewer, until `close`.

    `on_answer` is called in the kernel's thread with the page's messages. The cell displays `widget` next to the frame.
    """

    def __init__(self, messages: RetainedMessages, on_answer: Callable[[Answer], None]) -> None:
        self.name = secrets.token_hex(8)
        self._messages, self._on_answer = messages, on_answer
        self._in_frame = {key: messages.get(key) for key in messages.names()}
        self._changed: dict[str, None] = {}
        self._news = threading.Condition()
        self._thread: threading.Thread | None = None
        self._closed = False
        self.end: Callable[[], object] = self.close
        self.widget = _widget_class()(frame=self.name)
        self.widget.on_msg(self._received)
        messages.watch(self._note_change)

    def close(self) -> None:
        """Close the connection; the frame stays. Does nothing the second time."""
        self._messages.unwatch(self._note_change)
        with self._news:
            self._closed = True
            self._news.notify_all()
        self.widget.close()

    def _received(self, _: Any, content: Any, __: Any) -> None:
        if not isinstance(content, dict):
            return
        if content.get("kind") != "open":
            self._on_answer(content)
            return
        with self._news:
            get, before = self._messages.get, self._in_frame.get
            self._changed = dict.fromkeys(key for key in self._messages.names() if get(key) is not before(key))
            if self._thread is None:
                self._thread = threading.Thread(target=self._send_changes, name="nao_kin notebook", daemon=True)
                self._thread.start()
            self._news.notify_all()

    def _note_change(self, key: str) -> None:
        with self._news:
            if self._thread is None:  # messages that the frame lacks are found when it opens
                return
            note_last(self._changed, key)
            self._news.notify_all()

    def _send_changes(self) -> None:
        """Send the newest message of each changed key; messages that come faster than the page draws are skipped."""
        while True:
            with self._news:
                self._news.wait_for(lambda: self._closed or self._changed)
                if self._closed:
                    return
                changed, self._changed = self._changed, {}
            messages = [message for key in changed if (message := self._messages.get(key)) is not None]
            self.widget.send({"kind": "messages"}, buffers=messages)
            with self._news:
                self._news.wait_for(lambda: self._closed, _PAUSE_SECONDS)


def bridge_of(viewer: object, messages: RetainedMessages, receive: Callable[[Answer], None]) -> Bridge:
    """Return a bridge that ends with the viewer and does not keep it alive."""
    bridge = Bridge(messages, weak_receiver(receive))
    bridge.end = weakref.finalize(viewer, bridge.close)
    return bridge


@cache
def _widget_class() -> type:
    import anywidget
    import traitlets

    class NaoKinBridge(anywidget.AnyWidget):  # type: ignore[misc]
        _esm = _SCRIPT.read_text(encoding="utf-8")
        frame = traitlets.Unicode().tag(sync=True)

    return NaoKinBridge
