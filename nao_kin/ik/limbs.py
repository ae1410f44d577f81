"""Which limbs of a robot the closed forms fit: the limb of a frame, and their numbers for programs in any language."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import Any

from nao_kin._core.arrays import finite_or_none
from nao_kin.errors import BadArgument, UnknownName
from nao_kin.ik.arm import arm_limb
from nao_kin.ik.geometry import Limb
from nao_kin.ik.head import camera_limb, head_limb
from nao_kin.ik.leg import leg_limb
from nao_kin.robot import RobotModel, check_robot


def limbs(robot: RobotModel) -> list[dict[str, Any]]:
    """What the closed forms know of a robot's limbs, as plain numbers, strings and lists that JSON can hold.

    Args:
        robot: any robot.

    Returns:
        One dictionary for each limb that a closed form fits; none for a robot without such limbs.

        - `kind`: "leg", "arm", "head" or "gaze", the last for each camera that `look_at` takes; `side`: "L", "R" or "".
        - `frame`: the frame whose pose is asked for; `torso`: the frame in which targets are given.
        - `joints`: their names from the torso outwards; `columns`: the coordinates of q that move them, by
          value = `multiplier` · coordinate + `offset`.
        - `lower`, `upper`: their limits as values of the joints [rad], None for none; `table`: None, or the joint whose
          range depends on another: places of `joint` and `of` among the joints, and `lower` and `upper` bounds `at`
          values of the latter, linear between them and constant outside.
        - `geometry`: lengths and places [m], angles [rad] and rotations (nine numbers by rows) by name, as in the
          derivation in docs/inverse_kinematics.md.

    Raises:
        BadArgument: no robot model.

    Examples:
        >>> [limb["frame"] for limb in nk.ik.limbs(nk.load_nao())]
        ['LArm', 'RArm', 'LLeg', 'RLeg', 'Head', 'CameraTop', 'CameraBottom']
    """
    check_robot(robot)
    wanted: list[tuple[str, str, Callable[[], Limb]]] = [
        ("arm", "L", partial(arm_limb, robot, "L", None)),
        ("arm", "R", partial(arm_limb, robot, "R", None)),
        ("leg", "L", partial(leg_limb, robot, "L", None)),
        ("leg", "R", partial(leg_limb, robot, "R", None)),
        ("head", "", partial(head_limb, robot, "Head")),
        *(("gaze", "", partial(camera_limb, robot, camera)) for camera in robot.semantics.cameras),
    ]
    found = []
    for kind, side, limb in wanted:
        with suppress(BadArgument, UnknownName):
            found.append({"kind": kind, "side": side, **_described(limb())})
    return found


def limb_of_frame(robot: RobotModel, frame: str) -> str | None:
    """The limb whose closed form places a frame: "LLeg", "RLeg", "LArm", "RArm" or "Head"; None where none does.

    Args:
        robot: any robot.
        frame: one of its frames.

    Raises:
        UnknownName: no such frame.
        BadArgument: no robot model.
    """
    check_robot(robot)
    robot.frame_ids([frame])
    wanted: dict[str, Callable[[], Limb]] = {
        "LLeg": partial(leg_limb, robot, "L", frame),
        "RLeg": partial(leg_limb, robot, "R", frame),
        "LArm": partial(arm_limb, robot, "L", frame),
        "RArm": partial(arm_limb, robot, "R", frame),
        "Head": partial(head_limb, robot, frame),
    }
    for name, limb in wanted.items():
        with suppress(BadArgument):
            limb()
            return name
    return None


def _described(limb: Limb) -> dict[str, Any]:
    ranges, bends = limb.ranges, limb.ranges.bends
    table = {"joint": ranges.joint, "of": ranges.of, "at": list(ranges.at[:bends])}
    table |= {"lower": list(ranges.low[:bends]), "upper": list(ranges.high[:bends])}
    return {
        "frame": limb.frame,
        "torso": limb.torso,
        "joints": list(limb.joints),
        "columns": list(limb.columns),
        "multiplier": limb.multiplier.tolist(),
        "offset": limb.offset.tolist(),
        "lower": [finite_or_none(value) for value in ranges.lower],
        "upper": [finite_or_none(value) for value in ranges.upper],
        "table": table if bends > 0 else None,
        "geometry": {name: list(x) if isinstance(x, tuple) else x for name, x in limb.numbers._asdict().items()},
    }
