"""Whole-body control: what of feet and balance is kept, and the tasks that keep it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from nao_kin import ik
from nao_kin._core.arrays import Floats, join_poses
from nao_kin.naoqi.names import joint_names
from nao_kin.naoqi.spaces import AXIS_MASK_ALL, AXIS_MASK_ROT, AXIS_MASK_VEL, FRAME_TORSO
from nao_kin.naoqi.virtual.arguments import check_duration
from nao_kin.naoqi.virtual.cartesian import EffectorPath, Scene, Wish, hold_still
from nao_kin.naoqi.virtual.engine import TICK, Task
from nao_kin.naoqi.virtual.limb_solvers import LEGS, RADIAN, TORSO, Solution
from nao_kin.naoqi.virtual.steps import smooth
from nao_kin.robot import NaoModel
from nao_kin.rotations import exp, log, matrix_from_rpy

if TYPE_CHECKING:
    from nao_kin.naoqi.virtual.virtual_nao import VirtualNao


# --- What whole-body control keeps, and joint values that keep it.

# Effector → pose (4, 4) or place (3,) in the world, and its weights of metres and of radians.
Targets = Mapping[str, tuple[Floats, tuple[float, float]]]

FOOT_STATES: tuple[str, ...] = ("Fixed", "Plane", "Free")
SUPPORTS: tuple[str, ...] = ("Legs", "LLeg", "RLeg")
_SENSORS = ("FrontLeft", "FrontRight", "RearLeft", "RearRight")
# A foot that is held by its leg, and not stood on, counts so much more than what else is asked for.
_HELD = 100.0
# How far inside the support polygon the centre of mass is kept [m].
_MARGIN = 0.005
# How often targets are brought nearer so that joints are not too fast.
_MOST_HALVINGS = 7
# What counts as missing where they were: metres, and radians times 0.1.
_NOTEWORTHY_IN_BALANCE = 2e-3


@dataclass
class Balance:
    """What is kept while whole-body control is on.

    Attributes:
        enabled: whether it is on.
        feet: foot → "Fixed", "Plane" or "Free".
        support: what the centre of mass is kept above: "Legs", "LLeg" or "RLeg"; None for nothing.
    """

    enabled: bool = False
    feet: dict[str, str] = field(default_factory=lambda: dict.fromkeys(LEGS, "Fixed"))
    support: str | None = None


def above(robot: NaoModel, q: Floats, T_world_torso: Floats, support: str) -> Floats:
    """The middle of the pressure sensors of a foot, or of both for "Legs", seen from above, shape (2,) [m]."""
    feet = LEGS if support == "Legs" else (support,)
    frames = [f"{foot[0]}Foot/FSR/{sensor}" for foot in feet for sensor in _SENSORS]
    places = robot.fk(q, frames)[:, :, 3] @ T_world_torso.T
    return np.asarray(places[:, :2].mean(axis=0))


def com_above(robot: NaoModel, q: Floats, T_world_torso: Floats) -> Floats:
    """The centre of mass seen from above, shape (2,) [m]."""
    return np.asarray((T_world_torso[:3, :3] @ robot.com(q) + T_world_torso[:3, 3])[:2])


def solve(
    robot: NaoModel,
    balance: Balance,
    T_world_feet: Floats,
    targets: Targets,
    q: Floats,
    posture: Floats,
    *,
    com: Floats | None = None,
) -> Solution | None:
    """Joint values of the whole robot, with the feet in place and the centre of mass above what supports it.

    Args:
        robot: a NAO.
        balance: what is kept.
        T_world_feet: where the feet are kept, left and right, shape (2, 4, 4).
        targets: effector → pose (4, 4) or place (3,) in the world, and its weights of metres and of radians. A foot
            that has one is not kept.
        q: where the search begins, shape (nq,).
        posture: what the joints stay near to, shape (nq,).
        com: where the centre of mass is to be above, shape (2,); None for anywhere above the support.

    Returns:
        What is missing of all targets together, radians times 0.1; None where no foot stands.
    """
    kept = {foot: T for foot, T in zip(LEGS, T_world_feet, strict=True) if foot not in targets}
    kept = {foot: T for foot, T in kept.items() if balance.feet[foot] != "Free"}
    standing = {balance.support: kept[balance.support]} if com is None and balance.support in kept else kept
    if not standing:
        return None
    asked = dict(targets) | {foot: (T, (_HELD, RADIAN * _HELD)) for foot, T in kept.items() if foot not in standing}
    torso = asked.pop(TORSO, None)
    weights = {name: weight for name, (_, weight) in asked.items()}
    if torso is not None:
        weights["torso"] = torso[1]
    found = ik.whole_body(
        robot,
        {name: T for name, (T, _) in asked.items()},
        feet={foot[0]: T for foot, T in standing.items()},
        com="support" if com is None and balance.support is not None else com,
        margin=_MARGIN if com is None and balance.support is not None else 0.0,
        torso=None if torso is None else torso[0],
        weights=weights,
        reference=q,
        posture=posture,
        restarts=0,
    )
    if not np.isfinite(found.q).all():
        return Solution(np.array(q), np.inf)
    off = [np.hypot(away, RADIAN * turn) for away, turn in found.residuals.values()]
    return Solution(found.q, float(np.linalg.norm(off)))


def step_towards(
    robot: NaoModel,
    balance: Balance,
    T_world_feet: Floats,
    targets: Targets,
    q: Floats,
    posture: Floats,
    T_world_torso: Floats,
    most: Floats,
    *,
    com: Floats | None = None,
) -> Solution | None:
    """As `solve`, for joint values that can be reached in a tick.

    At the end of its reach the nearest pose of the whole robot may be a far one. Targets are then brought nearer to
    where the effectors are, by halves, until no joint is too fast; joints that were late would let the feet slip.

    Args:
        robot: as in `solve`.
        balance: as in `solve`.
        T_world_feet: as in `solve`.
        targets: as in `solve`.
        q: the joints of now, shape (nq,).
        posture: as in `solve`.
        T_world_torso: where the torso is now, shape (4, 4).
        most: how far each joint may go, shape (nq,); infinite for what is not moved after all.
        com: as in `solve`.

    Returns:
        As `solve`; what is missing is of the targets as they were given.
    """
    missing = 0.0
    for halving in range(_MOST_HALVINGS):
        share = 0.5**halving
        nearer = {name: (_part(robot, q, T_world_torso, name, T, share), w) for name, (T, w) in targets.items()}
        place = None if com is None else _share_of(com_above(robot, q, T_world_torso), com, share)
        found = solve(robot, balance, T_world_feet, nearer, q, posture, com=place)
        if found is None:
            return None
        missing = missing if halving else found.missing
        if np.all(np.abs(found.q - q) <= most):
            return Solution(found.q, missing if halving == 0 else max(missing, _NOTEWORTHY_IN_BALANCE))
    return Solution(np.array(q), max(missing, _NOTEWORTHY_IN_BALANCE))


def _part(robot: NaoModel, q: Floats, T_world_torso: Floats, name: str, wanted: Floats, share: float) -> Floats:
    """A share of the way of an effector to a pose (4, 4) or a place (3,)."""
    if share == 1.0:
        return wanted
    now = T_world_torso @ robot.fk(q, name)
    if wanted.ndim == 1:
        return _share_of(now[:3, 3], wanted, share)
    part = np.array(wanted)
    part[:3, 3] = _share_of(now[:3, 3], wanted[:3, 3], share)
    part[:3, :3] = now[:3, :3] @ exp(share * log(now[:3, :3].T @ wanted[:3, :3]))
    return part


def _share_of(start: Floats, end: Floats, share: float) -> Floats:
    return np.asarray(start + share * (end - start))


# --- The motion tasks of whole-body control: to balance, along paths, and effectors that are held in FRAME_ROBOT.

# The axis masks that whole-body control knows, with weights of metres and of radians.
MASKS: dict[int, tuple[float, float]] = {
    AXIS_MASK_VEL: (1.0, 0.0),
    AXIS_MASK_ROT: (0.0, RADIAN),
    AXIS_MASK_ALL: (1.0, RADIAN),
}
HELD: tuple[str, ...] = ("Head", "LArm", "RArm")
_ON_TIME = 1e-9
# How fast targets of effectors that are held move [m/s, rad/s].
_PLACE_SPEED, _TURN_SPEED = 0.2, 0.8
_NOTEWORTHY = 1e-3


class GoToBalance(Task):
    """The centre of mass goes above a foot, or between both; what wbGoToBalance does.

    Args:
        nao: the virtual NAO.
        name: NAOqi's method.
        support: "Legs", "LLeg" or "RLeg".
        duration: how long it takes [s]; or with `fraction` the least.
        fraction: of the joints' largest speeds; None where the duration is given.
    """

    keeps_feet = True

    def __init__(
        self, nao: VirtualNao, name: str, support: str, duration: float, fraction: float | None = None
    ) -> None:
        super().__init__(name, joint_names(nao.robot, "Joints"))
        self._support, self._duration, self._fraction = support, duration, fraction
        self._balance = Balance(enabled=True)
        self.value = False

    def start(self, nao: VirtualNao, time: float) -> None:
        """Note where the centre of mass is, and where it goes."""
        self._columns = nao.joints.columns(joint_names(nao.robot, "Joints"))
        scene = Scene(nao)
        self._posture, self._start = scene.q, time
        self._most = nao.robot.velocity_limits * TICK
        self._feet = np.stack([scene.T_world_torso @ nao.robot.fk(scene.q, foot) for foot in LEGS])
        self._from = com_above(nao.robot, scene.q, scene.T_world_torso)
        self._to = above(nao.robot, scene.q, scene.T_world_torso, self._support)
        if self._fraction is not None:
            goal = solve(nao.robot, self._balance, self._feet, {}, scene.q, self._posture, com=self._to)
            assert goal is not None
            ways = np.abs(goal.q - scene.q) / (self._fraction * nao.robot.velocity_limits)
            # The smooth way is 15/8 as fast in its middle as on average.
            self._duration = max(self._duration, 1.875 * float(ways.max()))
            check_duration(self._duration, "the time to balance")
        nao.joints.note_limp(self._columns, self.notes)

    def advance(self, nao: VirtualNao, time: float) -> bool:
        """The whole robot for this tick's place of the centre of mass."""
        share = min((time - self._start) / self._duration, 1.0)
        place = self._from + float(smooth(np.array(share))) * (self._to - self._from)
        q = nao.joints.q(sensor=False)
        where = nao.base.torso(q)
        found = step_towards(nao.robot, self._balance, self._feet, {}, q, self._posture, where, self._most, com=place)
        assert found is not None
        if found.missing > _NOTEWORTHY:
            self.notes.once("com", "the centre of mass goes as near to its place as it can")
        nao.joints.set(self._columns, nao.robot.to_body(found.q)[self._columns], self.notes)
        done = share >= 1.0 - _ON_TIME
        if done:
            away = com_above(nao.robot, found.q, nao.base.torso(found.q)) - self._to
            stiff = bool((nao.joints.stiffness[self._columns] > 0.0).all())
            self.value = stiff and float(np.linalg.norm(away)) <= _NOTEWORTHY
        return done


class WholePathTask(Task):
    """Effectors follow paths, the whole robot after them; what positionInterpolations does in whole-body control.

    Args:
        name: NAOqi's method.
        nao: the virtual NAO.
        wishes: of each effector its path, with masks of `MASKS`.
        balance: what is kept.
    """

    keeps_feet = True

    def __init__(self, name: str, nao: VirtualNao, wishes: Sequence[Wish], balance: Balance) -> None:
        super().__init__(name, joint_names(nao.robot, "Joints"))
        self._wishes, self._balance = tuple(wishes), balance

    def start(self, nao: VirtualNao, time: float) -> None:
        """Begin where the joints are commanded to be."""
        self._columns = nao.joints.columns(joint_names(nao.robot, "Joints"))
        hold_still(nao, self._wishes)
        scene = Scene(nao)
        self._posture, self._start = scene.q, time
        self._most = nao.robot.velocity_limits * TICK
        self._feet = np.stack([scene.T_world_torso @ nao.robot.fk(scene.q, foot) for foot in LEGS])
        self._paths = [EffectorPath(np.concatenate([[0.0], wish.times]), scene.path(wish)) for wish in self._wishes]
        self._end = max(path.end for path in self._paths)
        nao.joints.note_limp(self._columns, self.notes)

    def advance(self, nao: VirtualNao, time: float) -> bool:
        """The whole robot for this tick's poses."""
        t = time - self._start
        q = nao.joints.q(sensor=False)
        T_world_torso = nao.base.torso(q)
        targets: dict[str, tuple[Floats, tuple[float, float]]] = {}
        for wish, path in zip(self._wishes, self._paths, strict=True):
            T = path.pose(t)
            T_world = T_world_torso @ T if wish.space == FRAME_TORSO else T
            weights = MASKS[AXIS_MASK_ALL if wish.effector == TORSO else wish.mask]
            targets[wish.effector] = T_world[:3, 3] if weights[1] == 0.0 else T_world, weights
        found = step_towards(nao.robot, self._balance, self._feet, targets, q, self._posture, T_world_torso, self._most)
        if found is None:
            self.notes.once("feet", "no foot stands: nothing moves (wbFootState says which stay)")
        else:
            if found.missing > _NOTEWORTHY:
                self.notes.once("missed", "an effector goes as near to its target as balance and the feet let it")
            nao.joints.set(self._columns, nao.robot.to_body(found.q)[self._columns], self.notes)
        return t >= self._end - _ON_TIME


class EffectorControl(Task):
    """Effectors are held where they were last told to be, by the whole robot; what wbSetEffectorControl does.

    Targets are in FRAME_ROBOT: of an arm the place of its hand [m], of the head its rotation (wx, wy, wz) [rad]. They
    move at 0.2 m/s and 0.8 rad/s to where they are told.

    Args:
        nao: the virtual NAO.
        balance: what is kept; read in every tick.
    """

    reactive = True
    keeps_feet = True

    def __init__(self, nao: VirtualNao, balance: Balance) -> None:
        super().__init__("wbEnableEffectorControl", joint_names(nao.robot, "Joints"))
        self._balance = balance
        self._names = nao.robot.joint_names
        self._goals: dict[str, Floats] = {}
        self._now: dict[str, Floats] = {}
        self.over = False

    def start(self, nao: VirtualNao, time: float) -> None:
        """Note how the robot stands."""
        scene = Scene(nao)
        self._posture = scene.q
        self._most = nao.robot.velocity_limits * TICK
        self._feet = np.stack([scene.T_world_torso @ nao.robot.fk(scene.q, foot) for foot in LEGS])
        nao.joints.note_limp(nao.joints.columns(sorted(self.resources)), self.notes)

    def hold(self, nao: VirtualNao, effector: str) -> None:
        """Hold an effector where it is."""
        scene = Scene(nao)
        T_world = scene.T_world_torso @ nao.robot.fk(scene.q, effector)
        self._now[effector] = T_world[:3, :3] if effector == "Head" else T_world[:3, 3]
        self._goals[effector] = self._now[effector]

    def release(self, effector: str) -> bool:
        """Do not hold it any longer; whether others are held."""
        self._now.pop(effector, None)
        self._goals.pop(effector, None)
        return bool(self._goals)

    def holds(self, effector: str) -> bool:
        """Whether it is held."""
        return effector in self._goals

    def send(self, nao: VirtualNao, effector: str, target: Floats) -> None:
        """Tell where an effector is to be, shape (3,) in FRAME_ROBOT."""
        T_world_robot = Scene(nao).T_world_robot
        if effector == "Head":
            self._goals[effector] = T_world_robot[:3, :3] @ matrix_from_rpy(target)
        else:
            self._goals[effector] = T_world_robot[:3, :3] @ target + T_world_robot[:3, 3]

    def advance(self, nao: VirtualNao, time: float) -> bool:
        """Move the targets on, and the whole robot after them."""
        targets: dict[str, tuple[Floats, tuple[float, float]]] = {}
        for effector, goal in self._goals.items():
            now = self._now[effector] = _towards(self._now[effector], goal)
            if effector == "Head":
                targets[effector] = join_poses(now, np.zeros(3)), MASKS[AXIS_MASK_ROT]
            else:
                targets[effector] = now, MASKS[AXIS_MASK_VEL]
        q = nao.joints.q(sensor=False)
        where = nao.base.torso(q)
        found = step_towards(nao.robot, self._balance, self._feet, targets, q, self._posture, where, self._most)
        if found is None or not self.resources:
            return False
        if found.missing > _NOTEWORTHY:
            self.notes.once("missed", "an effector goes as near to its target as balance lets it")
        columns = nao.joints.columns(sorted(self.resources))
        nao.joints.set(columns, nao.robot.to_body(found.q)[columns], self.notes)
        return False

    def give_up(self, resources: frozenset[str]) -> None:
        """Leave some joints to another task."""
        super().give_up(resources)
        if self.started is not None:
            self._most[[index for index, name in enumerate(self._names) if name in resources]] = np.inf

    def end(self, nao: VirtualNao, *, killed: bool) -> None:
        """Nothing is held any longer."""
        self.over = True


def _towards(now: Floats, goal: Floats) -> Floats:
    """One tick's way of a place, shape (3,), or of a rotation, shape (3, 3)."""
    if now.ndim == 1:
        way, most = goal - now, _PLACE_SPEED * TICK
        length = float(np.linalg.norm(way))
        return goal if length <= most else now + (most / length) * way
    turn, most = log(now.T @ goal), _TURN_SPEED * TICK
    angle = float(np.linalg.norm(turn))
    return goal if angle <= most else np.asarray(now @ exp((most / angle) * turn))
