"""`nao-kin serve`: a virtual NAO that NAOqi's scripts connect to."""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from json import dumps
from typing import TYPE_CHECKING, Annotated

import typer

from nao_kin.cli.live_page import AllowHostOption, LivePage, PageHostOption, PagePortOption, TokenOption
from nao_kin.cli.options import JsonOption, OffsetsOption, VersionOption, command
from nao_kin.cli.output import print_note
from nao_kin.errors import BadArgument

if TYPE_CHECKING:
    from nao_kin.naoqi import Change, VirtualNao
    from nao_kin.viewer import Viewer

_FRAMES_PER_SECOND = 25.0

BehaviorsOption = Annotated[
    str | None,
    typer.Option(metavar="FOLDER", help="Choregraphe's behaviours (.xar) for ALBehaviorManager to play."),
]


@command("serve", "Example: nao-kin serve --speed 10 --log")
def serve(
    port: Annotated[int, typer.Option(metavar="N", help="Port to listen on; 0 for a free one.")] = 9559,
    host: Annotated[
        str, typer.Option(metavar="ADDRESS", help="Address to listen on; qi has no passwords, so keep others out.")
    ] = "127.0.0.1",
    version: VersionOption = "v6",
    offsets: OffsetsOption = None,
    speed: Annotated[float, typer.Option(metavar="X", help="Seconds of the robot's time in one second.")] = 1.0,
    posture: Annotated[str, typer.Option(metavar="NAME", help="Posture to begin in.")] = "Crouch",
    view: Annotated[bool, typer.Option("--view", help="Show the robot in a live page.")] = False,
    page_host: PageHostOption = None,
    page_port: PagePortOption = None,
    allow_host: AllowHostOption = None,
    token: TokenOption = None,
    awake: Annotated[bool, typer.Option("--awake", help="Begin with stiffness, as after wakeUp.")] = False,
    behaviors: BehaviorsOption = None,
    log: Annotated[bool, typer.Option("--log", help="Print what the robot says and remarks.")] = False,
    json: JsonOption = False,
) -> None:
    """A virtual NAO for NAOqi's scripts, until Ctrl-C.

    Scripts connect to it as to a robot: qi's session to tcp://127.0.0.1:9559. It begins without stiffness, as a robot
    that was switched on, and moves as kinematics has it: within limits and speeds, without weight. A command to joints
    without stiffness is reported on standard error.
    """
    if not host.strip():
        raise BadArgument("--host is empty; expected an address, such as 127.0.0.1, or 0.0.0.0 to let others in")
    page = LivePage(page_host, page_port, allow_host, token, prefix="--page-")
    if not view:
        page.refuse("add --view")
    with served(
        version,
        offsets=offsets,
        host=host,
        port=port,
        speed=speed,
        posture=posture,
        awake=awake,
        behaviors=behaviors,
        page=page if view else None,
        kinds=("log",) if log else ("limp", "kernels"),
    ) as done:
        if json:
            print(dumps(done))  # one line: whoever reads it waits for its end
        else:
            for where in done.values():
                print(f"{where}  (Ctrl-C ends)")
        sys.stdout.flush()
        threading.Event().wait()


@contextmanager
def served(
    version: str,
    *,
    offsets: str | None,
    host: str,
    port: int,
    speed: float,
    posture: str,
    awake: bool,
    behaviors: str | None,
    page: LivePage | None,
    kinds: tuple[str, ...],
) -> Iterator[dict[str, str]]:
    """A virtual NAO served over qi, and shown in a page where that is wanted, as long as the context lasts.

    Args:
        version: of the NAO.
        offsets: file of its calibrated joints and frames; None for none.
        host: address to listen on.
        port: port to listen on; 0 for a free one.
        speed: seconds of its time in one second.
        posture: to begin in.
        awake: begin with stiffness, as after wakeUp.
        behaviors: folder of the behaviours that ALBehaviorManager plays; None for none.
        page: that shows it; None for none.
        kinds: which of its changes are printed on standard error: "log" for all that it says and remarks, "limp" for
            commands to joints without stiffness, "kernels" for what it says about its compiled kernels.

    Yields:
        "endpoint": for scripts, as in tcp://127.0.0.1:9559; "url": of the page, if there is one.

    Raises:
        NaoKinError: qi is not installed, the port is in use, no such version, posture or speed, or bad offsets.
    """
    from nao_kin import load_nao
    from nao_kin.naoqi import QiServer, VirtualNao

    robot = load_nao(version, offsets=offsets)
    with ExitStack() as running:

        def watcher(change: Change) -> None:
            if change.kind in kinds:
                print_note(f"{change.time:.2f} s: {change.value}")

        nao = running.enter_context(
            VirtualNao(robot, speed=speed, posture=posture, behaviors=behaviors, on_change=watcher)
        )
        if awake:
            nao.call("ALMotion", "wakeUp")
        server = running.enter_context(QiServer(nao, host=host, port=port, quiet=True))
        done = {"endpoint": server.endpoint}
        if page is not None:
            viewer = running.enter_context(closing(page.viewer(load_nao(version, base="floating", offsets=offsets))))
            done["url"] = page.address(viewer)
            ended = threading.Event()
            follower = threading.Thread(target=follow, args=(nao, viewer, ended), name="live view", daemon=True)
            follower.start()
            running.callback(follower.join)
            running.callback(ended.set)
        yield done


def follow(nao: VirtualNao, viewer: Viewer, ended: threading.Event) -> None:
    """Show the robot where it is in the world, its lights and what it says, until the end.

    Args:
        nao: the virtual NAO.
        viewer: of the same robot with a floating base.
        ended: set at the end.
    """
    import numpy as np

    from nao_kin.naoqi import light_colours, spoken_words
    from nao_kin.rotations import quat_from_matrix

    shown = lit = said = None
    while not ended.wait(1.0 / _FRAMES_PER_SECOND):
        state = nao.state()
        r0, *vector = quat_from_matrix(state.T_world_torso[:3, :3])
        q = np.concatenate([state.T_world_torso[:3, 3], vector, [r0], state.q])
        if shown is None or not np.array_equal(q, shown):
            viewer.display(q)
            shown = q
        if state.leds != lit:
            viewer.show_lights(light_colours(state.leds))
            lit = state.leds
        if state.saying != said:
            viewer.say(spoken_words(state.saying))
            said = state.saying
