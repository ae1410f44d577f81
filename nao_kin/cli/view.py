"""`nao-kin view`: the robot in a browser, as a file, or as a picture."""

from __future__ import annotations

import sys
import threading
from contextlib import closing
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import typer

from nao_kin._core import files as atomic
from nao_kin._core.arrays import Floats, decimal
from nao_kin._core.text import quoted
from nao_kin.cli.fk import one_configuration
from nao_kin.cli.motion import is_motion, log_columns, read, refuse_motion_options, trajectory
from nao_kin.cli.options import (
    ColumnsOption,
    DegOption,
    HipsOption,
    IgnoreOtherOption,
    JsonOption,
    RateOption,
    RobotOptions,
    TimelineOption,
    check_sinks,
    columns_of,
    command,
    print_json,
    print_note,
)
from nao_kin.errors import BadArgument

if TYPE_CHECKING:
    from nao_kin.robot import RobotModel
    from nao_kin.viewer import Viewer


# --- The live page that a command shows: its options, what they mean for a viewer, and its address.
#
# A command that listens for nothing else names them --host and --port; one that serves a robot too has those for the
# robot, and --page-host and --page-port for the page.

_HOST = "127.0.0.1"
_HOST_HELP = f"Address of the page; 0.0.0.0 lets others in. Default: {_HOST}."
_PORT_HELP = "Port of the page. Default: the next free one."

# A page that is served on all addresses of this machine names one of them.
_ELSEWHERE = "on another machine, put the name or the address of this one into the page's address"
_EVERYWHERE = ("", "0.0.0.0", "::")


@dataclass(frozen=True)
class LivePage:
    """The options of a live page.

    Raises:
        BadArgument: an empty address.
    """

    page_host: Annotated[str | None, typer.Option("--host", metavar="ADDRESS", help=_HOST_HELP)] = None
    page_port: Annotated[int | None, typer.Option("--port", metavar="N", help=_PORT_HELP)] = None
    allow_host: Annotated[
        list[str] | None,
        typer.Option(
            "--allow-host", metavar="NAME", help="Answer to this name too, as of a proxy; repeatable, * for all."
        ),
    ] = None
    token: Annotated[
        bool | None,
        typer.Option(
            "--token/--no-token",
            help="Let in only who has the page's whole address. Default: where others could reach it.",
        ),
    ] = None
    prefix: ClassVar[str] = "--"

    def __post_init__(self) -> None:
        if self.page_host is not None and not self.page_host.strip():
            raise BadArgument(
                f"{self.prefix}host is empty; expected an address, such as {_HOST}, or 0.0.0.0 to let others in"
            )

    @property
    def host(self) -> str:
        """The address to serve on."""
        return _HOST if self.page_host is None else self.page_host.strip()

    def refuse(self, instead: str) -> None:
        """Refuse the options where no page is shown.

        Args:
            instead: what to do, the end of the message.

        Raises:
            BadArgument: one of them is given.
        """
        if any(value is not None for value in (self.page_host, self.page_port, self.allow_host or None, self.token)):
            options = f"{self.prefix}host, {self.prefix}port, --allow-host and --token"
            raise BadArgument(f"{options} are for the live page; {instead}")

    def viewer(self, robot: RobotModel) -> Viewer:
        """A viewer of a robot, which the caller closes.

        Raises:
            BadArgument: no names that could be answered to.
        """
        from nao_kin.viewer import Viewer

        names = self.allow_host or ()
        return Viewer(robot, host=self.host, port=self.page_port, allow_hosts=names, token=self.token)

    def address(self, viewer: Viewer) -> str:
        """The address of the page, which is served from now on; with a note, where others have to change it.

        Raises:
            BadArgument: the port is in use, or the address cannot be had; every name is allowed without a token.
        """
        url = viewer.url
        if self.host in _EVERYWHERE:
            print_note(_ELSEWHERE)
        return url


@dataclass(frozen=True)
class PageBeside(LivePage):
    """The options of a live page, where the robot that is served has the names --host and --port."""

    page_host: Annotated[str | None, typer.Option("--page-host", metavar="ADDRESS", help=_HOST_HELP)] = None
    page_port: Annotated[int | None, typer.Option("--page-port", metavar="N", help=_PORT_HELP)] = None
    prefix: ClassVar[str] = "--page-"


# --- `nao-kin view`: the robot in a browser, as a file, or as a picture.

_FPS = 30.0
_BROWSER_SECONDS = 30.0


@command("view", "Example: nao-kin view --posture StandInit --html nao.html")
def view(
    *,
    file: Annotated[
        str | None,
        typer.Argument(metavar="[FILE]", help="CSV or JSON trajectory or motion to play, - for standard input."),
    ] = None,
    posture: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Start from a predefined posture; of a motion: of joints it does not name."),
    ] = None,
    joint: Annotated[
        list[str] | None, typer.Option(metavar="NAME=VALUE", help="Set a joint; repeatable. Others are at zero.")
    ] = None,
    up: Annotated[
        str | None,
        typer.Option(
            metavar="X,Y,Z|NAME",
            help="Direction up in the root's frame, or the posture to rest as. Default: found from the joint values.",
        ),
    ] = None,
    deg: DegOption = False,
    fps: Annotated[
        float | None, typer.Option(metavar="N", help=f"Configurations of FILE per second. Default: {_FPS:g}.")
    ] = None,
    columns: ColumnsOption = None,
    ignore_other: IgnoreOtherOption = False,
    rate: RateOption = None,
    hips: HipsOption = None,
    timeline: TimelineOption = None,
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
        bool | None,
        typer.Option(
            "--wait/--no-wait", help="Serve until Ctrl-C, the default; --no-wait needs --open, --html or --png."
        ),
    ] = None,
    page: LivePage,
    robot: RobotOptions,
    json: JsonOption = False,
) -> None:
    """The robot in a browser: a live page until Ctrl-C, or with --html and --png files and no server.

    A trajectory names all joints in its header or keys, as in `nao-kin fk`; its rows are played at --fps. A motion file
    of any format (see nao-kin motion) plays at its own speed, with 30 configurations a second or --rate of them, unless
    --fps says another. With --open and --no-wait the command ends once the browser has the scene: the page goes on
    working alone.
    """
    files = [path for path in (html, png) if path is not None]
    live = open_ or not files
    if not live and wait:
        raise BadArgument("--wait is for a live page; with --html or --png, add --open to serve one too")
    if wait is False and not (open_ or files):
        raise BadArgument("--no-wait without --open shows nothing: add --open, --html or --png")
    if fps is not None and file is None:
        raise BadArgument("--fps is the speed of a trajectory; name the FILE to play")
    if not live and png is None and (page.page_host is not None or page.page_port is not None):
        raise BadArgument("--html needs no server; leave out --host and --port, or add --open to serve a page too")
    if not live and (page.allow_host or page.token is not None):
        raise BadArgument("--allow-host and --token are for a live page; with --html or --png, add --open to serve one")
    check_sinks("--json" if json else None, html=html, png=png)
    moves = file is not None and is_motion(file)
    if not moves:
        only_file = {} if file is None else {"posture": posture}
        refuse_motion_options(file, **only_file, rate=rate, hips=hips, timeline=timeline)

    if file is None and (columns or ignore_other):
        raise BadArgument("--columns and --ignore-other are for a file; name it")

    model = robot.load()
    renamed = columns_of(columns)
    # Read before any mesh: what is wrong with the file is said at once.
    q: Floats | None = None
    many, speed = False, _FPS if fps is None else fps
    if file is not None and moves and not renamed and not (ignore_other and log_columns(model, file, None)):
        motion = read(model, file, deg=deg, timeline=timeline, ignore_other=ignore_other)
        sampling = rate if rate is not None else speed
        q, many = trajectory(model, motion, posture=posture, hips=hips, rate=sampling).q, True
        speed = sampling if fps is None else fps
    elif file is not None:
        from nao_kin.stream import read_log

        rule: Any = hips
        log = read_log(model, file, limits="ignore", degrees=deg, columns=renamed, ignore_other=ignore_other, hips=rule)
        q, many = log.q, log.many
        for note in log.notes:
            print_note(note)
    elif posture is not None or joint:
        q = one_configuration(model, posture, joint or [], deg, "ignore")[None]
    with closing(page.viewer(model)) as viewer:
        vertical = None if up is None else _vertical(viewer, up)
        if many and q is not None:
            viewer.animate(q, speed, up=vertical)
        elif q is not None or vertical is not None:
            viewer.display(viewer.q if q is None else q[0], up=vertical)
        if frames is not None:
            viewer.show_frames([name.strip() for name in ",".join(frames).split(",") if name.strip()])
        viewer.camera(camera)
        for note in viewer.notes:
            print_note(note)
        done: dict[str, str] = {}
        if html is not None:
            done["html"] = str(viewer.save_html(html))
        if png is not None:
            done["png"] = str(viewer.save_png(png, camera=camera))
        if live:
            done["url"] = page.address(viewer)
        _report(done, json, serving=live and wait is not False)
        if open_:
            viewer.open()
        if live and wait is not False:
            threading.Event().wait()
        elif open_:
            viewer.wait(_BROWSER_SECONDS)


def _vertical(viewer: Viewer, text: str) -> tuple[float, ...] | None:
    """What --up says: three numbers, or the name of a posture."""
    if "," not in text:
        return viewer.rest(text)
    try:
        x, y, z = (decimal(part) for part in text.split(","))
    except ValueError:
        raise BadArgument(f"--up must be three numbers, as in 0,0,1, or a posture, got {quoted(text)}") from None
    return x, y, z


def _report(done: dict[str, str], json: bool, *, serving: bool) -> None:
    if json:
        print_json(done)
    else:
        for what, where in done.items():
            if what == "url":
                print(f"{where}  (Ctrl-C ends)" if serving else where)
            elif not atomic.leads_to_standard_output(where):  # which has the file, and nothing behind it
                print(where)
    sys.stdout.flush()
