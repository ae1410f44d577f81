"""Options that several commands share."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from nao_kin.errors import BadArgument

if TYPE_CHECKING:
    from nao_kin.robot import RobotModel

Version = Annotated[str, typer.Option("--version", metavar="V", help="NAO version: v3.2, v3.3, v4, v5 or v6.")]
Urdf = Annotated[str | None, typer.Option("--urdf", metavar="FILE", help="Another robot, from a URDF file.")]
Robot = Annotated[str | None, typer.Option("--robot", metavar="NAME", help="Another robot, from example-robot-data.")]
Json = Annotated[bool, typer.Option("--json", help="Print JSON.")]
Deg = Annotated[bool, typer.Option("--deg", help="Angles in degrees, in and out; hands stay 0 to 1.")]


def load(version: str, urdf: str | None, robot: str | None) -> RobotModel:
    """The robot that the options name.

    Raises:
        BadArgument: both another file and another name.
        NaoKinError: the robot does not load.
    """
    from nao_kin import RobotModel, load_nao, load_robot

    if urdf is not None and robot is not None:
        raise BadArgument("--urdf and --robot name two robots; give one")
    if urdf is not None:
        return RobotModel.from_urdf(urdf)
    if robot is not None:
        return load_robot(robot)
    return load_nao(version)
