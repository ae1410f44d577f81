"""What a whole-body pose is asked for, looked at once at the door and laid out for the search."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._common.arrays import Floats, as_floats, as_numbers
from nao_kin._common.vectors import as_vectors
from nao_kin._text import quoted
from nao_kin.errors import BadArgument, UnknownName, WrongShape
from nao_kin.ik.body.body import SIDES
from nao_kin.ik.body.body_errors import COM, GAZE, PLACE, POSE, Plan
from nao_kin.ik.body.body_tables import BodyTables
from nao_kin.ik.geometry import torso_frame
from nao_kin.ik.targets import rigid_poses

SUPPORT = "support"
_OWN_NAMES = ("com", "gaze", "torso")
# Weights of what is measured in metres [1/m] and in radians [1/rad], as in `numeric`; and of the posture [1/rad].
DEFAULT_WEIGHTS = (1.0, 0.1)
DEFAULT_POSTURE = 0.01
# Beside a target that weighs more, rounding leaves nothing of the others.
_LARGEST_WEIGHT = 1e12


@dataclass(frozen=True, eq=False)
class Target:
    """One of the things that are asked for.

    Attributes:
        name: what it is called in weights and residuals.
        kind: PLACE, POSE, GAZE or COM.
        row: the row of the body that carries the frame.
        T_row_frame: of the frame in it, shape (4, 4).
        values: T_world_target, or the place in its last column, shape (..., 4, 4).
        weights: of metres and of radians.
    """

    name: str
    kind: int
    row: int
    T_row_frame: Floats
    values: Floats
    weights: tuple[float, float]


def standing_feet(feet: Mapping[str, ArrayLike] | None, at_reference: Floats) -> dict[str, Floats]:
    """The feet that stand with T_world_foot, shape (..., 4, 4); None for both where the reference has them.

    Raises:
        BadArgument: no mapping, or no foot.
        NotARotation, BadArgument: a pose that is not rigid.
        UnknownName: a foot that is neither "L" nor "R".
        WrongShape, NotFinite: no poses.
    """
    if feet is None:
        return {side: at_reference[..., k, :, :] for k, side in enumerate(SIDES)}
    if not isinstance(feet, Mapping):
        raise BadArgument(f"feet must be a mapping of L and R to poses, or None for both, got {type(feet).__name__}")
    for side in feet:
        if side not in SIDES:
            raise UnknownName("foot", side, SIDES)
    if not feet:
        raise BadArgument("feet names no foot: a robot in the air has nothing to stand on; nk.ik.numeric moves limbs")
    return {side: rigid_poses(feet[side], f"feet[{quoted(side)}]") for side in SIDES if side in feet}


def all_targets(
    tables: BodyTables,
    standing: Mapping[str, Floats],
    targets: Mapping[str, ArrayLike],
    com: ArrayLike | str | None,
    gaze: ArrayLike | tuple[ArrayLike, str] | None,
    torso: ArrayLike | None,
    weights: Mapping[str, float | tuple[float, float]],
) -> list[Target]:
    """Everything that is asked for, except the support polygon.

    Raises:
        BadArgument: targets that contradict what stands or each other, or are no poses or places.
        NotARotation: a pose that is none.
        UnknownName: a frame, camera or weight that is not there.
        WrongShape, NotFinite: other shapes, NaN or infinity.
    """
    robot = tables.robot
    if not isinstance(targets, Mapping):
        raise BadArgument(f"targets must be a mapping of frames to poses or places, got {type(targets).__name__}")
    asked: list[tuple[str, str, ArrayLike, int]] = []
    for name, value in targets.items():
        if not isinstance(name, str) or name not in robot.frame_table:
            raise UnknownName("target", name, (*robot.semantics.end_effectors, *robot.frame_names))
        asked.append((name, name, value, POSE))
    trunk = torso_frame(robot)
    if torso is not None:
        # The torso's body carries other frames as well, and who places these places it.
        for name in targets:
            if tables.frame(name)[0] == 0:
                raise BadArgument(f"the torso is asked for twice: as torso and as the target {quoted(name)}")
        asked.append(("torso", trunk, torso, POSE))
    if gaze is not None:
        with_camera = isinstance(gaze, tuple) and len(gaze) == 2 and isinstance(gaze[1], str)
        point, camera = cast("tuple[ArrayLike, str]", gaze) if with_camera else (cast("ArrayLike", gaze), "CameraTop")
        if camera not in robot.frame_table:
            raise UnknownName("camera", camera, robot.semantics.cameras)
        asked.append(("gaze", camera, point, GAZE))
    if com is not None and not isinstance(com, str):
        asked.append(("com", trunk, com, COM))
    elif isinstance(com, str) and com != SUPPORT:
        raise UnknownName("com", com, (SUPPORT,), "or a place (x, y)")
    ankles = {int(tables.body.legs[SIDES.index(side), -1]): side for side in standing}
    found = []
    for name, frame, value, kind in asked:
        row, T_row_frame = tables.frame(frame)
        if row in ankles and kind != GAZE:
            raise BadArgument(
                f"{quoted(name)} is on the {'left' if ankles[row] == 'L' else 'right'} foot, which stands: "
                f"leave it out of targets, or feet without {ankles[row]}"
            )
        what, weight = (f"targets[{quoted(name)}]" if name not in _OWN_NAMES else name), _weights(name, weights)
        kind, values = _values(what, value, kind)
        as_vectors(weight[0] * values[..., :3, 3], f"{what} times its weight")
        found.append(Target(name, kind, row, T_row_frame, values, weight))
    names = [target.name for target in found] + ["com", "posture"]
    for name in weights:
        if name not in names:
            raise UnknownName("weight", name, names)
    return found


def plan_of(targets: list[Target], support: float, posture: float) -> Plan:
    """Targets for the compiled search."""
    return Plan(
        np.array([target.kind for target in targets], np.int64),
        np.array([target.row for target in targets], np.int64),
        np.array([target.T_row_frame for target in targets]).reshape(-1, 4, 4),
        np.array([target.weights for target in targets]).reshape(-1, 2),
        float(support),
        float(posture),
    )


def checked_weights(weights: Mapping[str, object] | None) -> Mapping[str, float | tuple[float, float]]:
    """Weights by name, each a factor or a pair.

    Raises:
        BadArgument: not so, negative, or above 1e12.
    """
    found: dict[str, float | tuple[float, float]] = {}
    if weights is not None and not isinstance(weights, Mapping):
        raise BadArgument(f"weights must be a mapping of targets to numbers, got {type(weights).__name__}")
    for name, given in (weights or {}).items():
        values = as_floats(given, (), f"weights[{quoted(str(name))}]")  # type: ignore[arg-type]
        if values.shape not in ((), (2,)) or (values < 0.0).any():
            raise BadArgument(
                f"weights[{quoted(str(name))}] must be a factor, or two weights for metres and radians, none below 0, "
                f"got {values.tolist()}"
            )
        if (values > _LARGEST_WEIGHT).any():
            raise BadArgument(
                f"weights[{quoted(str(name))}] must not exceed {_LARGEST_WEIGHT:.0e}, got {values.max():.3g}"
            )
        found[str(name)] = float(values) if values.ndim == 0 else (float(values[0]), float(values[1]))
    return found


def factor(name: str, weights: Mapping[str, float | tuple[float, float]]) -> float:
    """The weight of what has but one: a factor.

    Raises:
        BadArgument: two are given.
    """
    given = weights.get(name, 1.0)
    if isinstance(given, tuple):
        raise BadArgument(f"weights[{quoted(name)}] must be one factor, got {list(given)}")
    return given


def _weights(name: str, weights: Mapping[str, float | tuple[float, float]]) -> tuple[float, float]:
    given = weights.get(name, 1.0)
    return given if isinstance(given, tuple) else (given * DEFAULT_WEIGHTS[0], given * DEFAULT_WEIGHTS[1])


def _values(what: str, value: ArrayLike, kind: int) -> tuple[int, Floats]:
    """The kind of a target, a pose or a place, and its numbers, shape (..., 4, 4)."""
    if kind == POSE:
        shape = as_numbers(value, what).shape
        if shape[-2:] == (4, 4):
            return POSE, rigid_poses(value, what)
        if shape[-1:] != (3,):
            raise WrongShape(what, "(..., 4, 4) for poses or (..., 3) for places", shape)
        kind = PLACE
    size = 2 if kind == COM else 3
    places = as_vectors(value, what, size)
    values = np.zeros((*places.shape[:-1], 4, 4))
    values[...] = np.eye(4)
    values[..., :size, 3] = places
    return kind, values
