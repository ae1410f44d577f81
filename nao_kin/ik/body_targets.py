"""The robot and the targets of a whole-body pose, checked and laid out for the search."""

from __future__ import annotations

import math
import threading
import weakref
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import Floats, as_floats, join_poses, shaped
from nao_kin._core.text import quoted
from nao_kin.errors import BadArgument, UnknownName
from nao_kin.ik.body_errors import DEFAULT_WEIGHTS, SIDES, Body, SecondLeg
from nao_kin.ik.closed_form import Limb, torso_frame, torso_in_trunk
from nao_kin.ik.leg import leg_limb
from nao_kin.ik.limit_regions import extended, region_of
from nao_kin.ik.targets import is_pose, rigid_poses
from nao_kin.robot import RobotModel, SupportPolygon
from nao_kin.rotations import check_rotation

# --- The robot in the arrays of `body`, cached until the numbers of its model change.

_FEET = [f"{side}Leg" for side in SIDES]


class PreparedRobot:
    """The data of a robot for whole-body poses."""

    def __init__(self, robot: RobotModel) -> None:
        limbs: list[Limb] = [leg_limb(robot, side, None) for side in SIDES]
        joints = self.joints = robot.joints
        self.torso_in_root = torso_in_trunk(robot)  # T_root_torso
        T_torso_root = np.linalg.inv(self.torso_in_root)
        moves = np.array([unit == "rad" for unit in robot.joint_units])
        columns, moving = np.argsort(~moves, kind="stable"), int(np.count_nonzero(moves))
        self.order = robot.nq_base + columns  # index in q of each variable
        places = np.argsort(columns)
        variable = dict(zip(robot.joint_names, places.tolist(), strict=True))
        mass = np.append(joints.root_mass, joints.masses)
        levers = np.vstack([joints.root_centre_of_mass, joints.centres_of_mass])
        self.names = tuple(robot.joint_names[column] for column in columns)  # of the joints that the variables move
        self._frames: dict[str, tuple[int, Floats]] = {}
        levers[0] = T_torso_root[:3, :3] @ levers[0] + T_torso_root[:3, 3]
        parent = np.append(-1, joints.parents + 1)
        placements = np.concatenate([np.eye(4)[None], joints.placements])
        placements[parent == 0] = T_torso_root @ placements[parent == 0]
        axes = np.vstack([np.zeros(3), joints.axes])
        which = np.append(-1, places[joints.coordinates - robot.nq_base])
        multiplier, offset = np.append(0.0, joints.multipliers), np.append(0.0, joints.offsets)
        self.turns = np.arange(len(columns)) < moving  # which may change by whole turns without moving anything
        self.turns[which[multiplier % 1.0 != 0.0]] = False
        tables = [table for table in robot.coupled_limits if max(variable[table.joint], variable[table.of]) < moving]
        bends = [(variable[table.of], variable[table.joint], extended(table)) for table in tables]
        limited, winding = columns[:moving], np.zeros(moving)
        limits = region_of(robot.lower[limited], robot.upper[limited], winding, bends)
        R, p = placements[:, :3, :3].copy(), placements[:, :3, 3].copy()
        leg_rows = np.array([[joints.row(joint) + 1 for joint in limb.joints] for limb in limbs])
        soles = np.array([self.frame(robot, foot)[1] for foot in _FEET])
        self.ankles = np.linalg.inv(soles)[:, :, 3:]  # in the soles' frames, in columns (x, y, z, 1), shape (2, 4, 1)
        self.body = Body(parent, R, p, axes, which, multiplier, offset, mass, levers, leg_rows, soles, moving, limits)
        free = region_of(winding - math.inf, winding + math.inf, winding, [])
        self.unlimited = self.body._replace(limits=free)
        leg = limbs[1]
        motors = tuple(leg.multiplier.tolist()), tuple(leg.offset.tolist())
        self.second_leg = SecondLeg(leg.numbers._replace(stretched=0.0), leg.ranges, *motors)
        self.corners = {side: robot.sole_outline(f"{side}Leg", "sensors") for side in SIDES}  # shape (k, 3) [m]
        self.rest = limbs[0].rest  # all joints at zero, or at the limit nearest to zero
        self._feet_at_rest = np.asarray(robot.fk(self.rest, _FEET))

    def frame(self, robot: RobotModel, name: str) -> tuple[int, Floats]:
        """Return the row that carries a frame of the robot, and T_row_frame."""
        if name not in self._frames:
            row, T = robot.frame_placement(name)
            self._frames[name] = row + 1, (np.linalg.inv(self.torso_in_root) @ T if row < 0 else T)
        return self._frames[name]

    def unwound(self, x: Floats, near: Floats | float) -> Floats:
        """Return variables (..., n), with whole turns removed to within π of `near` from those that may turn."""
        turns = np.round((x - near) / (2.0 * math.pi))
        return np.asarray(np.where(self.turns & (turns != 0.0), x - 2.0 * math.pi * turns, x))

    def feet(self, robot: RobotModel, q: Floats | None) -> dict[str, Floats]:
        """Return T_world_foot of both feet, shape (..., 4, 4), in configurations; None for the rest configuration."""
        T = self._feet_at_rest if q is None else np.asarray(robot.fk(q, _FEET))
        return {side: T[..., k, :, :] for k, side in enumerate(SIDES)}


_CACHE: weakref.WeakKeyDictionary[RobotModel, PreparedRobot] = weakref.WeakKeyDictionary()
_LOCK = threading.Lock()


def prepared(robot: RobotModel) -> PreparedRobot:
    """Return the cached data of a robot, computed again if `robot.model` has changed."""
    with _LOCK:
        ready = _CACHE.get(robot)
        if ready is None or ready.joints is not robot.joints:
            ready = _CACHE[robot] = PreparedRobot(robot)
    return ready


# --- The targets of a whole-body pose, checked and laid out for the search.

COM, GAZE, SUPPORT, TORSO = "com", "gaze", "support", "torso"
# A factor, two weights or six, or six and their axes.
Weight = ArrayLike | tuple[ArrayLike, ArrayLike]
# Which of the six errors a target has that is not a pose.
_POSITION = (1.0, 1.0, 1.0, 0.0, 0.0, 0.0)
_USED = {COM: (1.0, 1.0, 0.0, 0.0, 0.0, 0.0), GAZE: (0.0, 0.0, 0.0, 0.0, 1.0, 1.0)}
_DEFAULT = np.array(DEFAULT_WEIGHTS)


@dataclass(frozen=True, eq=False)
class BodyTarget:
    """One target of a whole-body pose."""

    name: str  # its key in weights and residuals
    row: int  # of the body that carries the frame; −1 for the centre of mass
    frames: Floats  # T_row_frame, turned with the target to the axes of the weights, shape (..., 4, 4)
    values: Floats  # T_world_target; of a position, with the axes of the world, shape (..., 4, 4)
    weights: Floats  # of the six errors, 0 for those that it has not


def standing_feet(feet: Mapping[str, ArrayLike]) -> dict[str, Floats]:
    """Return the checked T_world_foot (..., 4, 4) of the standing feet."""
    for side in feet:
        if side not in SIDES:
            raise UnknownName("foot", side, SIDES)
    if not feet:
        raise BadArgument("feet names no foot to stand on; nk.ik.numeric moves limbs of a robot that does not stand")
    return {side: rigid_poses(feet[side], f"feet[{quoted(side)}]") for side in SIDES if side in feet}


def all_targets(
    robot: RobotModel,
    ready: PreparedRobot,
    standing: Mapping[str, Floats],
    targets: Mapping[str, ArrayLike],
    com: ArrayLike | str | None,
    gaze: ArrayLike | tuple[ArrayLike, str] | None,
    torso: ArrayLike | None,
    weights: Mapping[str, Weight],
) -> list[BodyTarget]:
    """Return all targets, checked, without the support polygon."""
    requested: list[tuple[str, str, ArrayLike]] = []
    for name, value in targets.items():
        if name not in robot.frame_table:
            raise UnknownName("target", name, (*robot.semantics.end_effectors, *robot.frame_names))
        requested.append((name, name, value))
    if torso is not None:
        # A target for another frame on the torso's body would also place the torso.
        for name in targets:
            if ready.frame(robot, name)[0] == 0:
                raise BadArgument(f"the torso is given twice: as torso and as the target {quoted(name)}")
        requested.append((TORSO, torso_frame(robot), torso))
    if gaze is not None:
        with_camera = isinstance(gaze, tuple) and len(gaze) == 2 and isinstance(gaze[1], str)
        point, camera = cast("tuple[ArrayLike, str]", gaze) if with_camera else (cast("ArrayLike", gaze), "CameraTop")
        if camera not in robot.frame_table:
            raise UnknownName("camera", camera, robot.semantics.cameras)
        requested.append((GAZE, robot.body_frame(camera), point))
    if com is not None and not isinstance(com, str):
        requested.append((COM, "", com))
    elif isinstance(com, str) and com != SUPPORT:
        raise UnknownName(COM, com, (SUPPORT,), "or a position (x, y)")
    ankles = {int(ready.body.legs[SIDES.index(side), -1]): side for side in standing}
    found = []
    for name, frame, value in requested:
        row, T_row_frame = ready.frame(robot, frame) if frame else (-1, np.eye(4))
        if row in ankles and name != GAZE:
            raise BadArgument(
                f"{quoted(name)} is on the {'left' if ankles[row] == 'L' else 'right'} foot, which stands: "
                f"leave it out of targets, or feet without {ankles[row]}"
            )
        six, axes = _six_weights(name, weights)
        what = f"targets[{quoted(name)}]" if name not in (COM, GAZE, TORSO) else name
        if name not in _USED and is_pose(value, what):
            values = rigid_poses(value, what)
        else:
            six = six * _USED.get(name, _POSITION)
            positions = as_floats(value, (2 if name == COM else 3,), what)
            values = np.zeros((*positions.shape[:-1], 4, 4))
            values[..., :, :] = np.eye(4)
            values[..., : positions.shape[-1], 3] = positions
        if axes is not None:
            # Errors are along the axes of the target. The frame and the target are turned equally, to other axes.
            T_row_frame = T_row_frame @ join_poses(np.swapaxes(values[..., :3, :3], -1, -2) @ axes, np.zeros(3))
            values[..., :3, :3] = axes
        found.append(BodyTarget(name, row, T_row_frame, values, six))
    names = [target.name for target in found] + [COM, "posture"]
    for name in weights:
        if name not in names:
            raise UnknownName("weight", name, names)
    return found


def factor(name: str, weights: Mapping[str, Weight]) -> float:
    """Return the weight of a name that takes one factor."""
    if name not in weights:
        return 1.0
    values = as_floats(cast("ArrayLike", weights[name]), (), f"weights[{quoted(name)}]")
    if values.ndim or values < 0.0:
        raise BadArgument(f"weights[{quoted(name)}] must be one factor ≥ 0, got {values.tolist()}")
    return float(values)


def _six_weights(name: str, weights: Mapping[str, Weight]) -> tuple[Floats, Floats | None]:
    """Return the six weights of a target, and R_world_axes of the axes along which they are; None for the target's."""
    if name not in weights:
        return _DEFAULT, None
    given: Any = weights[name]
    axes, what = None, f"weights[{quoted(name)}]"
    if name not in _USED and isinstance(given, tuple) and len(given) == 2 and np.ndim(given[0]) == 1:
        axes = shaped(given[1], (3, 3), what)
        check_rotation(axes, name=what)
        given = given[0]
    values = as_floats(given, (), what)
    if values.shape not in ((), (2,), (6,)) or (values < 0.0).any():
        form = "a factor, two weights for metres and radians, or six for all errors, none below 0"
        raise BadArgument(f"{what} must be {form}, got {values.tolist()}")
    return values * _DEFAULT if values.ndim == 0 else np.repeat(values, 6 // values.size), axes


# --- Targets that are certainly out of reach.
#
# A failed search does not prove this. But by the triangle inequality no two points of the robot are farther apart than
# the sum of the lengths between them, and no point is deeper inside a polygon than half its least width.


def target_beyond(body: Body, target: BodyTarget, standing: tuple[str, ...], feet: Floats, targets: Floats) -> Floats:
    """Return lower bounds on how far the positions of a target (n, 4, 4) are out of reach of the feet, shape (n,) [m].

    A position with a weight on two axes is met on a line, and one with a weight on one axis on a plane.
    """
    beyond, used = np.zeros(len(targets)), target.weights[:3] > 0.0
    for k in map(SIDES.index, standing if used.any() else ()):
        ways = np.einsum("nji,nj->ni", targets[:, :3, :3], targets[:, :3, 3] - feet[:, k, :3, 3])
        place = target.frames.reshape(-1, 4, 4)[0, :3, 3]
        reach = _com_reach(body, k) if target.row < 0 else _reach(body, k, target.row, place)
        beyond = np.maximum(beyond, np.linalg.norm(ways[:, used], axis=-1) - reach)
    return beyond


def feet_beyond(body: Body, feet: Floats) -> Floats:
    """Return lower bounds on the distance by which stretched legs miss the feet (n, 2, 4, 4), shape (n,) [m]."""
    reach = _reach(body, 0, int(body.legs[1, -1]), body.ankle_to_sole[1, :3, 3])
    distance = np.linalg.norm(feet[:, 1, :3, 3] - feet[:, 0, :3, 3], axis=-1)
    return np.asarray(np.maximum(0.0, distance - reach))


def margin_beyond(polygon: SupportPolygon, margin: float) -> float:
    """Return the excess of a margin over half of the polygon's least width [m]."""
    planes = polygon.half_planes
    widths = (planes[:, :2] @ polygon.vertices.T - planes[:, 2:]).max(axis=1)
    return max(0.0, margin - 0.5 * float(widths.min()))


def _reach(body: Body, side: int, row: int, place: Floats) -> float:
    """Return an upper bound on the distance of a point on a body from the sole of a foot [m]."""
    hip, *leg = body.legs[side]
    length = float(np.linalg.norm(body.ankle_to_sole[side, :3, 3]))
    length += sum(float(np.linalg.norm(body.place[joint])) for joint in leg)
    while row > 0:
        length += float(np.linalg.norm(place))
        place, row = body.place[row], int(body.parent[row])
    return length + float(np.linalg.norm(place - body.place[hip]))


def _com_reach(body: Body, side: int) -> float:
    """Return an upper bound on the distance of the centre of mass from the sole of a foot [m]."""
    lengths = [_reach(body, side, row, body.lever[row]) for row in range(len(body.mass))]
    return float(np.dot(lengths, body.mass) / body.mass.sum())
