"""The live page that a command shows: its options, what they mean for a viewer, and its address.

A command that listens for nothing else names them --host and --port; one that serves a robot too has those for the
robot, and --page-host and --page-port for the page.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any

import typer

from nao_kin.cli.output import print_note
from nao_kin.errors import BadArgument

if TYPE_CHECKING:
    from nao_kin.robot import RobotModel
    from nao_kin.viewer import Viewer

_HOST = "127.0.0.1"
_HOST_HELP = f"Address of the page; 0.0.0.0 lets others in. Default: {_HOST}."
_PORT_HELP = "Port of the page. Default: the next free one."

HostOption = Annotated[str | None, typer.Option("--host", metavar="ADDRESS", help=_HOST_HELP)]
PortOption = Annotated[int | None, typer.Option("--port", metavar="N", help=_PORT_HELP)]
PageHostOption = Annotated[str | None, typer.Option("--page-host", metavar="ADDRESS", help=_HOST_HELP)]
PagePortOption = Annotated[int | None, typer.Option("--page-port", metavar="N", help=_PORT_HELP)]
AllowHostOption = Annotated[
    list[str] | None,
    typer.Option("--allow-host", metavar="NAME", help="Answer to this name too, as of a proxy; repeatable, * for all."),
]
TokenOption = Annotated[
    bool | None,
    typer.Option(
        "--token/--no-token",
        help="Let in only who has the page's whole address. Default: where others could reach it.",
    ),
]

# A page that is served on all addresses of this machine names one of them.
_ELSEWHERE = "on another machine, put the name or the address of this one into the page's address"
_EVERYWHERE = ("", "0.0.0.0", "::")


class LivePage:
    """What the options of a page say.

    Args:
        host: the address to serve on; None for this machine alone.
        port: the port to serve on; None for the first free one.
        allow_host: names to answer to.
        token: whether there is one; None where others could reach the page.
        prefix: what stands before host and port in the options' names.

    Raises:
        BadArgument: an empty address.
    """

    def __init__(
        self, host: str | None, port: int | None, allow_host: list[str] | None, token: bool | None, prefix: str = "--"
    ) -> None:
        if host is not None and not host.strip():
            raise BadArgument(
                f"{prefix}host is empty; expected an address, such as {_HOST}, or 0.0.0.0 to let others in"
            )
        self._arguments: Mapping[str, Any] = {
            "host": _HOST if host is None else host.strip(),
            "port": port,
            "allow_hosts": allow_host or (),
            "token": token,
        }
        self._given = (host, port, allow_host or None, token)
        self._options = f"{prefix}host, {prefix}port, --allow-host and --token"

    def refuse(self, instead: str) -> None:
        """Refuse the options where no page is shown.

        Args:
            instead: what to do, the end of the message.

        Raises:
            BadArgument: one of them is given.
        """
        if any(value is not None for value in self._given):
            raise BadArgument(f"{self._options} are for the live page; {instead}")

    def viewer(self, robot: RobotModel) -> Viewer:
        """A viewer of a robot, which the caller closes.

        Raises:
            BadArgument: no names that could be answered to.
        """
        from nao_kin.viewer import Viewer

        return Viewer(robot, **self._arguments)

    def address(self, viewer: Viewer) -> str:
        """The address of the page, which is served from now on; with a note, where others have to change it.

        Raises:
            BadArgument: the port is in use, or the address cannot be had; every name is allowed without a token.
        """
        url = viewer.url
        if self._arguments["host"] in _EVERYWHERE:
            print_note(_ELSEWHERE)
        return url
