"""nao_kin: the kinematics of the NAO humanoid.

Conventions: metres, radians, kilograms; rotations are active, R_ab maps coordinates in b to coordinates in a;
quaternions are scalar first; every array function takes leading batch axes.

The names below are loaded on first use, so that the mathematics works without Pinocchio, and the command line handles
signals at once and can report an installation in which Pinocchio does not load.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from nao_kin._core import __version__ as __version__

if TYPE_CHECKING:
    from collections.abc import Iterable

    from nao_kin import (
        calibration,
        cli as cli,
        crosscheck,
        errors,
        export,
        ik,
        imitation,
        joints,
        motion,
        naoqi,
        reach,
        robot,
        rotations,
        screws,
        stream,
        viewer,
        world,
    )
    from nao_kin._kernels import KernelState, cache_folder
    from nao_kin.errors import NaoKinError
    from nao_kin.motion import Motion
    from nao_kin.robot import (
        LimitViolation,
        NaoModel,
        RobotModel,
        load_nao,
        load_robot,
        nao as parameters,
        robot_names,
        semantics as semantics,
        urdf as urdf,
    )
    from nao_kin.stream import distributed as distributed
    from nao_kin.viewer import Viewer

__all__ = [
    "KernelState",
    "LimitViolation",
    "Motion",
    "NaoKinError",
    "NaoModel",
    "RobotModel",
    "Viewer",
    "cache_folder",
    "calibration",
    "crosscheck",
    "errors",
    "export",
    "ik",
    "imitation",
    "joints",
    "load_nao",
    "load_robot",
    "motion",
    "naoqi",
    "parameters",
    "reach",
    "robot",
    "robot_names",
    "rotations",
    "screws",
    "stream",
    "viewer",
    "warm_up",
    "world",
]

# Modules that are found here but not listed, because few programs need them.
_UNLISTED = ("cli", "distributed", "semantics", "urdf")
# Public modules that are not directly in `nao_kin`, and then the module of every other public name.
_INSIDE = {
    "distributed": "nao_kin.stream.distributed",
    "parameters": "nao_kin.robot.nao",
    "semantics": "nao_kin.robot.semantics",
    "urdf": "nao_kin.robot.urdf",
}
_HOME = {
    "KernelState": "nao_kin._kernels",
    "LimitViolation": "nao_kin.robot",
    "Motion": "nao_kin.motion",
    "NaoKinError": "nao_kin.errors",
    "NaoModel": "nao_kin.robot",
    "RobotModel": "nao_kin.robot",
    "Viewer": "nao_kin.viewer",
    "cache_folder": "nao_kin._kernels",
    "load_nao": "nao_kin.robot",
    "load_robot": "nao_kin.robot",
    "robot_names": "nao_kin.robot",
}


def warm_up(names: Iterable[str] | None = None) -> tuple[KernelState, ...]:
    """Compile kernels, or read them from the cache, so that later calls do not wait for them.

    Args:
        names: names of kernels, such as "ik kernel, legs"; None for all kernels of the package.

    Returns:
        The state of each kernel; empty without Numba, where nothing is compiled.

    Examples:
        >>> [state.name for state in nk.warm_up(["ik kernel, heads"])]
        ['ik kernel, heads']
    """
    from nao_kin._kernels import cache

    if cache.has_numba():  # the modules that make kernels
        from nao_kin import ik, imitation, reach  # noqa: F401
        from nao_kin._kernels import operations  # noqa: F401
    return cache.warm_up(names)


if not TYPE_CHECKING:  # for type checkers, every name would exist

    def __getattr__(name: str) -> Any:
        if name not in (*__all__, *_UNLISTED):
            from nao_kin._core.guesses import unknown_attribute

            raise unknown_attribute("module 'nao_kin'", name, __all__)
        try:
            module = importlib.import_module(_HOME.get(name) or _INSIDE.get(name, f"nao_kin.{name}"))
        except ImportError as error:
            from nao_kin._core.extras import with_remedy

            remedy = with_remedy(str(error))
            if remedy != str(error):
                raise ImportError(remedy, name=error.name, path=error.path) from None
            raise
        value = getattr(module, name) if name in _HOME else module
        globals()[name] = value
        return value


def __dir__() -> list[str]:
    return sorted(__all__)
