"""`limbs`: the limbs of a robot that the closed forms solve, as numbers for other programs."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import Any

from nao_kin._core.arrays import finite_or_none
from nao_kin.errors import BadArgument, UnknownName
from nao_kin.ik.arm import arm_limb
from nao_kin.ik.closed_form import Limb
from nao_kin.ik.head import camera_limb, head_limb
from nao_kin.ik.leg import leg_limb
from nao_kin.robot import RobotModel

_LIMBS: dict[str, tuple[str, str, Callable[..., Limb]]] = {
    "LArm": ("arm", "L", partial(arm_limb, side="L")),
    "RArm": ("arm", "R", partial(arm_limb, side="R")),
    "LLeg": ("leg", "L", partial(leg_limb, side="L")),
    "RLeg": ("leg", "R", partial(leg_limb, side="R")),
    "Head": ("head", "", head_limb),
}


def limbs(robot: RobotModel, frame: str | None = None) -> list[dict[str, Any]]:
    """Return the limbs that the closed forms solve, as numbers, strings and lists that JSON can store.

    Args:
        robot: any robot.
        frame: a frame, for the one limb whose closed form solves for its pose, if there is one; None for the limbs of
            all end effectors, and for the head with each camera.

    Returns:
        One dictionary for each limb that a closed form fits:

        - `kind`: "leg", "arm", "head" or "gaze", the last for each camera that `look_at` takes; `side`: "L", "R" or "".
        - `frame`: the frame whose pose is the target; `torso`: the frame in which targets are given.
        - `joints`: their names from the torso outwards; `zeros`: the values of these joints from which the closed form
          counts; `columns`: the coordinates of q that move them, by value from there = `multiplier` · coordinate +
          `offset`.
        - `lower`, `upper`: limits of these values [rad], None if unlimited; `table`: None, or a coupled limit: indices
          of the limited joint (`joint`) and of the other (`of`), and `lower` and `upper` bounds `at` values of the
          other, linear between them and constant outside.
        - `geometry`: lengths and positions [m], angles [rad] and rotations (nine numbers by rows) by name, as in the
          derivation in docs/inverse_kinematics.md.

    Examples:
        >>> [limb["frame"] for limb in nk.ik.limbs(nk.load_nao())]
        ['LArm', 'RArm', 'LLeg', 'RLeg', 'Head', 'CameraTop', 'CameraBottom']
    """
    wanted = [(kind, side, limb, name if frame is None else frame) for name, (kind, side, limb) in _LIMBS.items()]
    if frame is not None:
        robot.frame_ids([frame])
    else:
        wanted += [("gaze", "", camera_limb, camera) for camera in robot.semantics.cameras]
    described = []
    for kind, side, limb, name in wanted:
        with suppress(BadArgument, UnknownName):
            described.append({"kind": kind, "side": side, **_described(limb(robot, frame=name))})
    return described


def _described(limb: Limb) -> dict[str, Any]:
    ranges, bends = limb.ranges, limb.ranges.bends
    table = {"joint": ranges.joint, "of": ranges.of, "at": list(ranges.at[:bends])}
    table |= {"lower": list(ranges.low[:bends]), "upper": list(ranges.high[:bends])}
    return {
        "frame": limb.frame,
        "torso": limb.torso,
        "joints": list(limb.joints),
        "zeros": limb.zeros.tolist(),
        "columns": list(limb.columns),
        "multiplier": limb.multiplier.tolist(),
        "offset": limb.offset.tolist(),
        "lower": [finite_or_none(value) for value in ranges.lower],
        "upper": [finite_or_none(value) for value in ranges.upper],
        "table": table if bends > 0 else None,
        "geometry": {name: list(x) if isinstance(x, tuple) else x for name, x in limb.numbers._asdict().items()},
    }
