"""`nao-kin view`: the robot in a browser, as a file, as a picture, or as a video."""

from __future__ import annotations

import sys
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import nao_kin as nk
from nao_kin._core.process import wait_for_signal
from nao_kin._core.text import abbreviated
from nao_kin.cli import options as shared
from nao_kin.cli.options import Needs, OutputOptions, RobotOptions, argument, command, flag, option
from nao_kin.cli.output import print_json, print_note, print_written, progress
from nao_kin.cli.sources import FileOptions, frame_names, numbers_of
from nao_kin.errors import BadArgument

if TYPE_CHECKING:
    from nao_kin.robot import RobotModel
    from nao_kin.viewer import Viewer


# --- The live page of a command.

_HOST = "127.0.0.1"
_HOST_HELP = f"Address to serve the page on; 0.0.0.0 lets other machines in. Default: {_HOST}."
_PORT_HELP = "Port of the page. Default: the next free one."


@dataclass(frozen=True)
class LivePage:
    """The options of a live page."""

    page_host: str | None = option("ADDRESS", _HOST_HELP, "--host")
    page_port: int | None = option("N", _PORT_HELP, "--port")
    allow_host: list[str] | None = option(
        "NAME", "Also accept requests for this name, as of a proxy; repeatable; * for all."
    )
    token: bool | None = flag(
        "Require a token in the page's address. Default: required if other machines can reach the page.",
        "--token/--no-token",
        default=None,
    )

    def viewer(self, robot: RobotModel) -> Viewer:
        """Return a viewer of a robot, which the caller closes."""
        from nao_kin.viewer import Viewer

        host = (self.page_host or _HOST).strip()
        return Viewer(robot, host=host, port=self.page_port, allow_hosts=self.allow_host or (), token=self.token)

    def address(self, viewer: Viewer) -> str:
        """Start serving the page and return its address; print a note if other machines need another address."""
        url = viewer.url
        if viewer.host in ("0.0.0.0", "::"):
            print_note("on another machine, put the name or the address of this one into the page's address")
        return url


@dataclass(frozen=True)
class ExtraPage(LivePage):
    """The options of a live page for a command that serves a robot under --host and --port."""

    page_host: str | None = option("ADDRESS", _HOST_HELP)
    page_port: int | None = option("N", _PORT_HELP)
    needs: ClassVar[Needs] = dict.fromkeys(("page_host", "page_port", "allow_host", "token"), "view")


# --- The command.

_FPS = 30.0
_BROWSER_SECONDS = 30.0


@command(
    "view",
    "Example: nao-kin view --posture StandInit --html nao.html",
    needs={"fps": "file", "balance": "file", "video": "file"},
)
def view(
    *,
    file: str | None = argument("[FILE]", "CSV or JSON trajectory or motion to play, - for standard input.", None),
    given: FileOptions,
    up: str | None = option(
        "X,Y,Z|NAME", "The vertical in the root's frame, or a posture's name. Default: found from the joint values."
    ),
    fps: float | None = option("N", f"Configurations of FILE per second. Default: {_FPS:g}."),
    balance: bool = flag("Also plot the margins of the balance while FILE plays, red where the robot tips."),
    frame: list[str] | None = shared.FRAME,
    output: str | None = option("FILE", "The same as --html, --png or --video, by the ending of FILE."),
    html: str | None = option("FILE", "Write the page with everything in it, and end."),
    png: str | None = option("FILE", "Write a picture, and end."),
    video: str | None = option("FILE", "Write a .webm video, or a .zip of PNG files, 30 pictures a second, and end."),
    beside: str | None = option(
        "ROBOT",
        "Another robot beside it, which moves along: a NAO version, a name as of --robot, or a file as of --urdf.",
    ),
    camera: str = option(
        "NAME",
        "Direction of view: front, side, three-quarter, hands, feet; for pictures and videos also CameraTop …",
        default="three-quarter",
    ),
    open_: bool = flag("Open the live page in this machine's browser."),
    wait: bool | None = flag(
        "Serve a live page until Ctrl-C, the default without a file to write; --no-wait needs --open or such a file.",
        "--wait/--no-wait",
        default=None,
    ),
    page: LivePage,
    robot: RobotOptions,
    written: OutputOptions,
) -> None:
    """Show the robot in a browser, as a live page until Ctrl-C, or write it to files with --html, --png and --video.

    A trajectory names all joints in its header or keys, as in `nao-kin fk`; its rows are played at --fps. A motion file
    of any format (see nao-kin motion) plays at its own speed, sampled 30 times a second or --rate times, unless --fps
    gives another speed. With --open and --no-wait the command ends when the browser has the scene, and the page
    continues to work alone.
    """
    if output is not None:
        kind = Path(output).suffix.lower()
        if {".html": html, ".png": png, ".webm": video, ".zip": video}.get(kind, output) is not None:
            raise BadArgument(f"--output {abbreviated(output)}: expected one .html, .png, .webm or .zip file")
        html, png = output if kind == ".html" else html, output if kind == ".png" else png
        video = output if kind in (".webm", ".zip") else video
    files = [path for path in (html, png, video) if path is not None]
    live = open_ or wait or not files
    if wait is False and not (open_ or files):
        raise BadArgument("--no-wait without --open shows nothing: add --open, --html, --png or --video")
    if not live and page != LivePage():
        raise BadArgument("--host, --port, --allow-host and --token are for a live page: add --wait or --open")
    written.check({"--html": html, "--png": png, "--video": video})
    if fps is not None and not fps > 0.0:
        raise BadArgument(f"--fps {fps:g}: expected a number above zero")
    # The file is read before any mesh, so that its errors are reported without delay.
    speed = _FPS if fps is None else fps
    model = robot.load()
    q, _, many, _ = given.configurations(model, file, limits="ignore", sampling=speed)
    if (balance or video is not None) and not many:
        raise BadArgument(f"--balance and --video are for a motion, and {file} has one configuration")
    speed = given.rate if fps is None and given.rate is not None else speed
    posed = file is not None or given.posture is not None or bool(given.joint)
    with closing(page.viewer(model)) as viewer:
        vertical = None if up is None else numbers_of(up, "--up", 3) if "," in up else viewer.rest(up)
        if many:
            viewer.animate(q, speed, up=vertical, balance=balance)
        elif posed or vertical is not None:
            viewer.display(q[0] if posed else viewer.q, up=vertical)
        if beside is not None:
            kind = "nao" if beside.lower() in nk.robot.nao.VERSIONS else "urdf" if Path(beside).suffix else "robot"
            viewer.add_robot(RobotOptions(**dict[str, Any]({kind: beside})).load())
            viewer.show("together")
        if frame is not None:
            viewer.show_frames(frame_names(model, frame))
        if camera not in model.semantics.cameras:
            viewer.camera(camera)
        elif html is not None or live:
            raise BadArgument(f"--camera {camera} is for --png and --video; a page shows it with Camera view")
        print_note(*viewer.notes)
        done: dict[str, str] = {}
        if html is not None:
            done["html"] = str(viewer.save_html(html, overwrite=written.force))
        if png is not None:
            done["png"] = str(viewer.save_png(png, camera=camera, overwrite=written.force))
        if video is not None:
            with progress("video", shown=not written.json) as say:
                done["video"] = str(viewer.save_video(video, camera=camera, progress=say, overwrite=written.force))
        if live:
            done["url"] = page.address(viewer)
        serving = live and wait is not False
        if written.json:
            print_json(done)
        else:
            print_written(*(where for what, where in done.items() if what != "url"))
            if live:
                print(f"{done['url']}  (Ctrl-C ends)" if serving else done["url"])
        sys.stdout.flush()
        if open_:
            viewer.open()
        if serving:
            wait_for_signal()
        elif open_:
            viewer.wait(_BROWSER_SECONDS)
