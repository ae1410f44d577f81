"""Pictures of the scene, drawn by a browser without a window."""

from __future__ import annotations

import base64
import itertools
import queue
import time

from nao_kin.errors import BadArgument, NoBrowser
from nao_kin.viewer.browser import headless
from nao_kin.viewer.messages import panel_message
from nao_kin.viewer.server import Answer, LiveServer

_EDGES = range(16, 8193)


class Screenshots:
    """Opens a page of its own for every picture, and knows which answer belongs to which."""

    def __init__(self) -> None:
        self._numbers = itertools.count()
        self._waiting: dict[int, queue.SimpleQueue[Answer]] = {}

    def picture(self, server: LiveServer, url: str, camera: str, size: tuple[int, int], timeout: float) -> bytes:
        """A PNG of what is on show.

        Args:
            server: who serves the scene.
            url: where.
            camera: from where to look.
            size: width and height in pixels, 16 to 8192.
            timeout: seconds for all of it.

        Raises:
            BadArgument: a size out of range.
            NoBrowser: there is none, or it gives no picture in time.
        """
        if (
            not isinstance(size, (tuple, list))
            or len(size) != 2
            or not all(isinstance(edge, int) and edge in _EDGES for edge in size)
        ):
            raise BadArgument(f"size must be two whole numbers from {_EDGES[0]} to {_EDGES[-1]}, got {size!r}")
        end = time.monotonic() + timeout
        mine = next(self._numbers)
        answers = self._waiting[mine] = queue.SimpleQueue()
        try:
            role = f"capture{mine}"
            with headless(f"{url}?role={role}", size=size):
                if not server.wait_for_page(max(0.0, end - time.monotonic()), role):
                    raise NoBrowser(f"the browser did not show the scene within {timeout:g} s")
                request = {"id": mine, "camera": camera, "width": size[0], "height": size[1]}
                server.send_once(panel_message("capture", request), role)
                answer = answers.get(timeout=max(0.01, end - time.monotonic()))
                return base64.b64decode(str(answer["data"]).partition(",")[2], validate=True)
        except (queue.Empty, KeyError, ValueError):
            raise NoBrowser(f"the browser gave no picture within {timeout:g} s") from None
        finally:
            del self._waiting[mine]

    def deliver(self, answer: Answer) -> None:
        """Pass an answer on to the request that waits for it."""
        number = answer.get("id")
        waiting = self._waiting.get(number) if isinstance(number, int) else None
        if waiting is not None:
            waiting.put(answer)
