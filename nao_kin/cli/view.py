"""`nao-kin view`: the robot in a browser, as a file, or as a picture."""

from __future__ import annotations

import signal
import sys
import threading
import warnings
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from types import FrameType
from typing import TYPE_CHECKING, Annotated

import typer

from nao_kin.cli.fk import one_configuration
from nao_kin.cli.options import Deg, Json, Robot, Urdf, Version, load
from nao_kin.cli.output import print_json
from nao_kin.errors import BadArgument

if TYPE_CHECKING:
    from nao_kin.robot import RobotModel
    from nao_kin.viewer import Viewer


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("view", epilog="Example: nao-kin view --posture StandInit --html nao.html")(view)


def view(
    file: Annotated[
        str | None, typer.Argument(metavar="[FILE]", help="CSV or JSON trajectory to play, - for standard input.")
    ] = None,
    posture: Annotated[str | None, typer.Option(metavar="NAME", help="Start from a predefined posture.")] = None,
    joint: Annotated[
        list[str] | None, typer.Option(metavar="NAME=VALUE", help="Set a joint; repeatable. Others are at zero.")
    ] = None,
    deg: Deg = False,
    fps: Annotated[float, typer.Option(metavar="N", help="Configurations of the trajectory per second.")] = 30.0,
    frames: Annotated[
        list[str] | None, typer.Option(metavar="NAMES", help="Draw frames; several with commas, or repeated.")
    ] = None,
    html: Annotated[str | None, typer.Option(metavar="FILE", help="Write the page with all in it, and end.")] = None,
    png: Annotated[str | None, typer.Option(metavar="FILE", help="Write a picture, and end.")] = None,
    camera: Annotated[
        str, typer.Option(metavar="NAME", help="Look from here: front, side, three-quarter, hands, feet.")
    ] = "three-quarter",
    open_: Annotated[bool, typer.Option("--open", help="Open the live page in this machine's browser.")] = False,
    wait: Annotated[
        bool, typer.Option("--wait/--no-wait", help="Serve until Ctrl-C; --no-wait needs --open, --html or --png.")
    ] = True,
    host: Annotated[
        str, typer.Option(metavar="ADDRESS", help="Address to serve on; 0.0.0.0 lets others in.")
    ] = "127.0.0.1",
    port: Annotated[int | None, typer.Option(metavar="N", help="Port to serve on. Default: the next free one.")] = None,
    version: Version = "v6",
    urdf: Urdf = None,
    robot: Robot = None,
    json: Json = False,
) -> None:
    """The robot in a browser: a live page until Ctrl-C, or with --html and --png files and no server.

    A trajectory names all joints in its header or keys, as in `nao-kin fk`; its rows are played at --fps. With --open
    and --no-wait the command ends once the browser has the scene: the page goes on working alone.
    """
    if file is not None and (posture is not None or joint):
        raise BadArgument("a trajectory gives whole configurations; leave out --posture and --joint")
    if not (wait or open_ or html is not None or png is not None):
        raise BadArgument("--no-wait without --open shows nothing: add --open, --html or --png")
    model = load(version, urdf, robot)
    from nao_kin.viewer import OutsideLimitsWarning, Viewer

    with _tidy_ending(), warnings.catch_warnings(record=True) as caught, ExitStack() as cleanup:
        warnings.simplefilter("always")
        viewer = Viewer(model, host=host, port=port)
        cleanup.callback(viewer.close)
        _show(viewer, model, file, posture, joint or [], deg, fps)
        if frames is not None:
            viewer.show_frames([name.strip() for name in ",".join(frames).split(",") if name.strip()])
        viewer.camera(camera)
        _say(viewer.notes)
        _say(str(warning.message) for warning in caught if issubclass(warning.category, OutsideLimitsWarning))
        done: dict[str, str] = {}
        if html is not None:
            done["html"] = str(viewer.save_html(html))
        if png is not None:
            done["png"] = str(viewer.save_png(png, camera=camera))
        live = open_ or not done
        if live:
            done["url"] = viewer.url
        _report(done, json, serving=live and wait)
        if open_:
            viewer.open()
        if live and wait:
            threading.Event().wait()
        elif open_:
            viewer.wait(30.0)


@contextmanager
def _tidy_ending() -> Iterator[None]:
    """Let SIGTERM and SIGHUP end the command as an exception does, so that no browser and no folder is left behind."""

    def end(number: int, frame: FrameType | None) -> None:
        for each in before:
            signal.signal(each, signal.SIG_IGN)  # a second one must not cut the tidying short
        raise SystemExit(128 + number)

    numbers = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
    before = {number: signal.getsignal(number) for number in numbers}
    # What nohup ignores stays ignored; None is a handler that Python does not know and could not put back.
    before = {number: handler for number, handler in before.items() if handler not in (signal.SIG_IGN, None)}
    if threading.current_thread() is not threading.main_thread():
        before = {}
    for number in before:
        signal.signal(number, end)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _show(
    viewer: Viewer,
    model: RobotModel,
    file: str | None,
    posture: str | None,
    joints: list[str],
    deg: bool,
    fps: float,
) -> None:
    if file is not None:
        from nao_kin.configuration_files import read_configurations

        q, many = read_configurations(model, file, limits="ignore", degrees=deg)
        if many:
            viewer.animate(q, fps)
        else:
            viewer.display(q[0])
    elif posture is not None or joints:
        q = one_configuration(model, posture, joints, deg, "ignore")
        viewer.display(q, up=viewer.rest(posture) if posture is not None else None)


def _say(lines: Iterable[str]) -> None:
    for line in lines:
        print(f"nao-kin: {line}", file=sys.stderr)


def _report(done: dict[str, str], json: bool, *, serving: bool) -> None:
    if json:
        print_json(done)
    else:
        for what, where in done.items():
            print(f"{where}  (Ctrl-C ends)" if what == "url" and serving else where)
    sys.stdout.flush()
