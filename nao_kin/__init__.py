"""nao_kin: the kinematics of the NAO humanoid.

Conventions: metres, radians, kilograms; rotations are active, R_ab maps coordinates in b to coordinates in a;
quaternions are scalar first; every array function takes leading batch axes.

The names below are loaded when they are first used, so that the mathematics works without Pinocchio and the command
line can report what is wrong with an installation in which Pinocchio does not load.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from nao_kin import errors
from nao_kin._extras import with_remedy
from nao_kin.errors import NaoKinError

if TYPE_CHECKING:
    from nao_kin import (
        batch,
        cli,
        configuration_files,
        crosscheck,
        distributed,
        errors,
        export,
        ik,
        joint_axes,
        joints,
        lines,
        motion,
        multidof,
        naoqi,
        parameters,
        rank_one,
        reach,
        robot,
        rotations,
        screws,
        semantics,
        stream,
        topology,
        typed,
        urdf,
        viewer,
    )
    from nao_kin._nao import NaoModel, load_nao
    from nao_kin.motion import Motion
    from nao_kin.robot import LimitViolation, RobotModel, load_robot, robot_names
    from nao_kin.viewer import Viewer

__version__ = "0.2.0"

__all__ = [
    "LimitViolation",
    "Motion",
    "NaoKinError",
    "NaoModel",
    "RobotModel",
    "Viewer",
    "batch",
    "cli",
    "configuration_files",
    "crosscheck",
    "distributed",
    "errors",
    "export",
    "ik",
    "joint_axes",
    "joints",
    "lines",
    "load_nao",
    "load_robot",
    "motion",
    "multidof",
    "naoqi",
    "parameters",
    "rank_one",
    "reach",
    "robot",
    "robot_names",
    "rotations",
    "screws",
    "semantics",
    "stream",
    "topology",
    "typed",
    "urdf",
    "viewer",
]

_HOME = {
    "NaoModel": "nao_kin._nao",
    "load_nao": "nao_kin._nao",
    "Motion": "nao_kin.motion",
    "LimitViolation": "nao_kin.robot",
    "RobotModel": "nao_kin.robot",
    "load_robot": "nao_kin.robot",
    "robot_names": "nao_kin.robot",
    "Viewer": "nao_kin.viewer",
}


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module 'nao_kin' has no attribute {name!r}")
    try:
        module = importlib.import_module(_HOME.get(name, f"nao_kin.{name}"))
    except ImportError as error:
        remedy = with_remedy(str(error))
        if remedy != str(error):
            raise ImportError(remedy, name=error.name, path=error.path) from None
        raise
    value = getattr(module, name) if name in _HOME else module
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
