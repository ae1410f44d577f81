"""A virtual NAO for as long as a command runs: served over qi, shown in a page where that is wanted."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

from nao_kin._common.ending import before_ending
from nao_kin.cli.output import print_note

if TYPE_CHECKING:
    from nao_kin.naoqi import Change, VirtualNao
    from nao_kin.viewer import Viewer

_FRAMES_PER_SECOND = 25.0


@dataclass(frozen=True)
class Served:
    """Where a virtual NAO is found.

    Attributes:
        nao: the virtual NAO.
        endpoint: for scripts, "tcp://127.0.0.1:9559".
        url: of the live page; None without one.
    """

    nao: VirtualNao
    endpoint: str
    url: str | None


@contextmanager
def served(
    version: str, *, host: str, port: int, speed: float, posture: str, view: bool, log: bool
) -> Iterator[Served]:
    """Make a virtual NAO, serve it, and end it.

    Args:
        version: of the NAO.
        host: address to listen on.
        port: port to listen on; 0 for a free one.
        speed: seconds of its time in one second.
        posture: to begin in.
        view: show it in a live page.
        log: print what it says and remarks on standard error.

    Raises:
        NaoKinError: qi is not installed, the port is in use, no such version, posture or speed.
    """
    from nao_kin import load_nao
    from nao_kin.naoqi import QiServer, VirtualNao

    robot = load_nao(version)
    with ExitStack() as running:
        nao = running.enter_context(
            VirtualNao(robot, speed=speed, posture=posture, on_change=_print_log if log else None)
        )
        server = running.enter_context(QiServer(nao, host=host, port=port, quiet=True))
        running.callback(before_ending(server.close))
        url = None
        if view:
            from nao_kin.viewer import Viewer

            viewer = running.enter_context(closing(Viewer(load_nao(version, base="floating"))))
            url = viewer.url
            ended = threading.Event()
            follower = threading.Thread(target=_follow, args=(nao, viewer, ended), name="live view", daemon=True)
            follower.start()
            running.callback(follower.join)
            running.callback(ended.set)
        yield Served(nao, server.endpoint, url)


def _print_log(change: Change) -> None:
    if change.kind == "log":
        print_note(f"{change.time:.2f} s: {change.value}")


def _follow(nao: VirtualNao, viewer: Viewer, ended: threading.Event) -> None:
    """Show the robot where it is."""
    import numpy as np

    from nao_kin.rotations import quat_from_matrix

    shown = None
    while not ended.wait(1.0 / _FRAMES_PER_SECOND):
        state = nao.state()
        r0, *vector = quat_from_matrix(state.T_world_torso[:3, :3])
        q = np.concatenate([state.T_world_torso[:3, 3], vector, [r0], state.q])
        if shown is None or not np.array_equal(q, shown):
            viewer.display(q)
            shown = q
