"""`nao-kin live`: the joints of a robot that runs, in a page and as a recording."""

from __future__ import annotations

import sys
from contextlib import ExitStack, closing
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nao_kin._common import atomic
from nao_kin._common.ending import uninterrupted
from nao_kin._text import abbreviated
from nao_kin.cli.live_page import AllowHostOption, HostOption, LivePage, PortOption, TokenOption
from nao_kin.cli.options import JsonOption, OffsetsOption, VersionOption, command, load
from nao_kin.cli.output import print_json, print_note
from nao_kin.errors import BadArgument

if TYPE_CHECKING:
    from nao_kin.naoqi import JointReading

_RATE = 25.0


@command("live", "Example: nao-kin live tcp://nao.local:9559 --record wave.json")
def live(
    address: Annotated[
        str | None, typer.Argument(metavar="[tcp://HOST:PORT]", help="A robot, or a virtual NAO, over NAOqi.")
    ] = None,
    lola: Annotated[
        str | None, typer.Option(metavar="SOCKET", help="A NAO6's RoboCup interface, a Unix socket, instead.")
    ] = None,
    rate: Annotated[float, typer.Option(metavar="N", help="At most so many readings a second.")] = _RATE,
    record: Annotated[
        str | None, typer.Option(metavar="FILE", help="Write what was read as a motion, in the end.")
    ] = None,
    seconds: Annotated[float | None, typer.Option(metavar="S", help="End after so many seconds of readings.")] = None,
    view: Annotated[bool, typer.Option("--view/--no-view", help="Show the robot in a live page.")] = True,
    host: HostOption = None,
    port: PortOption = None,
    allow_host: AllowHostOption = None,
    token: TokenOption = None,
    force: Annotated[bool, typer.Option("--force", help="Overwrite the recording if it exists.")] = False,
    version: VersionOption = "v6",
    offsets: OffsetsOption = None,
    json: JsonOption = False,
) -> None:
    """A robot's joints as they are now, in a live page; and recorded, until Ctrl-C or for some seconds.

    It only reads: no command is ever sent. A connection that is lost is made anew.
    """
    if (address is None) == (lola is None):
        raise BadArgument("give the address of a robot, as in tcp://nao.local:9559, or --lola SOCKET")
    if seconds is not None and not seconds > 0.0:
        raise BadArgument(f"--seconds must be a positive number, got {seconds:g}")
    page = LivePage(host, port, allow_host, token)
    if not view:
        page.refuse("leave out --no-view")
    if record is not None:
        from nao_kin.motion import FORMATS

        suffixes = dict.fromkeys(suffix for known in FORMATS.values() for suffix in known.suffixes)
        if Path(record).suffix.lower() not in suffixes:  # now, and not when all is recorded
            raise BadArgument(f"no motion format for {abbreviated(record)}; end it in one of: {', '.join(suffixes)}")
        atomic.check_writable(record)
        existing = atomic.replaced_file(record)
        if existing is not None and existing.exists() and not force:
            raise BadArgument(f"{record} exists; --force overwrites it")
    robot = load(version, None, None, offsets=offsets)
    from nao_kin.naoqi import LolaSource, NaoqiSource, readings, recorded

    source = LolaSource(lola) if lola is not None else NaoqiSource(str(address))
    found: list[JointReading] = []
    with ExitStack() as running:
        viewer = None
        if view:
            viewer = running.enter_context(closing(page.viewer(robot)))
            print_note(f"{page.address(viewer)}  (Ctrl-C ends)")
        # A signal ends the reading, and what was read is still written.
        ended = running.enter_context(uninterrupted())
        for reading in readings(source, robot, rate=rate, wanted=lambda: not ended(), on_state=print_note):
            if viewer is not None:
                viewer.display(reading.q, up=reading.up)
            if record is not None or not found:
                found.append(reading)
            else:
                found[0] = reading
            if seconds is not None and reading.time >= seconds:
                break
        if record is not None and found:
            from nao_kin.motion import write_motion

            write_motion(recorded(found, robot), record, overwrite=force)
        _report(robot.joint_names, found, record, json)


def _report(names: tuple[str, ...], found: list[JointReading], record: str | None, json: bool) -> None:
    if json:
        last = None if not found else dict(zip(names, found[-1].q.tolist(), strict=True))
        print_json({"readings": len(found) if record is not None else None, "last": last, "record": record})
    elif record is not None:
        print(record if found else "no readings")
    sys.stdout.flush()  # a signal that waits leaves without it
