"""`nao-kin run`: a script for NAOqi, with a virtual NAO or a server that runs already."""

from __future__ import annotations

from typing import Annotated

import typer

from nao_kin._common.scalars import whole_number
from nao_kin.cli.live_page import AllowHostOption, LivePage, PageHostOption, PagePortOption, TokenOption
from nao_kin.cli.options import OffsetsOption, VersionOption, command
from nao_kin.cli.output import print_note
from nao_kin.cli.serve import BehaviorsOption
from nao_kin.errors import BadArgument

_HOST, _PORT = "127.0.0.1", 9559


@command("run", "Example: nao-kin run wave.py --view; nao-kin run wave.py --port 9559 -- --ip nao.local")
def run(
    script: Annotated[str, typer.Argument(metavar="SCRIPT", help="A Python script that drives a NAO.")],
    arguments: Annotated[
        list[str] | None, typer.Argument(metavar="[-- ARGUMENTS]", help="The script's own, behind --.")
    ] = None,
    port: Annotated[
        int | None, typer.Option(metavar="N", help="Port of a server that runs already, such as nao-kin serve's.")
    ] = None,
    host: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help=f"Address of that server. Default: {_HOST}.")
    ] = None,
    version: VersionOption = "v6",
    offsets: OffsetsOption = None,
    speed: Annotated[
        float | None, typer.Option(metavar="X", help="Seconds of the virtual NAO's time in one second. Default: 1.")
    ] = None,
    posture: Annotated[str | None, typer.Option(metavar="NAME", help="Posture to begin in. Default: Crouch.")] = None,
    asleep: Annotated[
        bool, typer.Option("--asleep", help="Begin without stiffness, until the script asks for it.")
    ] = False,
    behaviors: BehaviorsOption = None,
    view: Annotated[bool, typer.Option("--view", help="Show the virtual NAO in a live page.")] = False,
    page_host: PageHostOption = None,
    page_port: PagePortOption = None,
    allow_host: AllowHostOption = None,
    token: TokenOption = None,
    log: Annotated[bool, typer.Option("--log", help="Print what the virtual NAO says and remarks.")] = False,
) -> None:
    """Run a script for NAOqi without a robot: from naoqi import ALProxy, or import qi.

    Without --port, a virtual NAO is made for it and ends with it; it begins awake, with stiffness. Wherever the script
    wants to connect to, it is led there. Python 2 runs translated. The exit code is the script's.
    """
    from nao_kin.naoqi import run_script

    given = arguments or []
    page = LivePage(page_host, page_port, allow_host, token, prefix="--page-")
    if not view:
        page.refuse("add --view")
    if port is None and host is None:
        from nao_kin.cli.serve import served

        with served(
            version,
            offsets=offsets,
            host=_HOST,
            port=0,
            speed=1.0 if speed is None else speed,
            posture="Crouch" if posture is None else posture,
            awake=not asleep,
            behaviors=behaviors,
            page=page if view else None,
            kinds=("log",) if log else ("limp",),
        ) as where_it_is:
            if "url" in where_it_is:
                print_note(f"the virtual NAO is at {where_it_is['url']}")
            code = run_script(script, given, endpoint=where_it_is["endpoint"])
    else:
        for option, used in (
            ("--offsets", offsets is not None),
            ("--speed", speed is not None),
            ("--posture", posture is not None),
            ("--asleep", asleep),
            ("--behaviors", behaviors is not None),
            ("--view", view),
            ("--log", log),
        ):
            if used:
                raise BadArgument(f"{option} is for a virtual NAO of the script's own; leave out --port and --host")
        where = _HOST if host is None else host.strip()
        if not where:
            raise BadArgument("--host is empty; expected an address, such as 127.0.0.1")
        number = whole_number(_PORT if port is None else port, "port", 1, 65535)
        code = run_script(script, given, endpoint=f"tcp://{f'[{where}]' if ':' in where else where}:{number}")
    raise typer.Exit(code)
