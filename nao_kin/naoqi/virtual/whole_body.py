"""ALMotion's whole-body control: what of feet and balance is kept, the tasks that keep it, and the methods."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from nao_kin import ik
from nao_kin._core.arrays import Floats, join_poses
from nao_kin.errors import BadArgument
from nao_kin.naoqi.names import joint_names
from nao_kin.naoqi.spaces import AXIS_MASK_ALL, AXIS_MASK_ROT, AXIS_MASK_VEL, FRAME_TORSO
from nao_kin.naoqi.virtual import arguments
from nao_kin.naoqi.virtual.cartesian import NOTEWORTHY, CartesianControl, EffectorPath, Scene, Wish, hold_still
from nao_kin.naoqi.virtual.engine import TICK, Call, Task
from nao_kin.naoqi.virtual.interpolation import ON_TIME
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
# The axis masks that whole-body control knows, with weights of metres and of radians.
MASKS: dict[int, tuple[float, float]] = {
    AXIS_MASK_VEL: (1.0, 0.0),
    AXIS_MASK_ROT: (0.0, RADIAN),
    AXIS_MASK_ALL: (1.0, RADIAN),
}


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


class WholeTask(Task):
    """A task of all joints but the hands, with the feet in place and the centre of mass above what supports it.

    Args:
        nao: the virtual NAO.
        name: NAOqi's method.
        balance: what is kept; read in every tick.
    """

    keeps_feet = True

    def __init__(self, nao: VirtualNao, name: str, balance: Balance) -> None:
        self._joints = joint_names(nao.robot, "Joints")
        super().__init__(name, self._joints)
        self._robot, self._balance = nao.robot, balance

    def start(self, nao: VirtualNao, time: float) -> None:
        """Note how the robot stands."""
        self._scene, self._start = Scene(nao), time
        # How far each joint may go in a tick; infinite for what is not moved after all.
        self._most = nao.robot.velocity_limits * TICK
        nao.joints.note_limp(nao.joints.columns(self._joints), self.notes)

    def command(self, nao: VirtualNao, targets: Targets, missed: str, *, com: Floats | None = None) -> Solution | None:
        """Command joint values for targets that can be reached in this tick.

        At the end of its reach the nearest pose of the whole robot may be a far one. Targets are then brought nearer to
        where the effectors are, by halves, until no joint is too fast; joints that were late would let the feet slip.

        Args:
            nao: the virtual NAO.
            targets: as in `solve`.
            missed: what the log says where a target is missed.
            com: as in `solve`.

        Returns:
            As `solve`, with the joint values that are commanded; what is missing is of the targets as they were given.
        """
        q = nao.joints.q(sensor=False)
        T_world_torso = nao.base.torso(q)
        above = com_above(self._robot, q, T_world_torso)
        joints, missing = q, 0.0
        for halving in range(_MOST_HALVINGS):
            share = 0.5**halving
            nearer = targets
            if halving:
                nearer = {
                    name: (_part(T_world_torso @ self._robot.fk(q, name), wanted, share), weights)
                    for name, (wanted, weights) in targets.items()
                }
            found = self.solve(nearer, q, com=None if com is None else above + share * (com - above))
            if found is None:
                return None
            # Of the targets that were brought nearer something is missing in any case.
            missing = max(missing, _NOTEWORTHY_IN_BALANCE) if halving else found.missing
            if np.all(np.abs(found.q - q) <= self._most):
                joints = found.q
                break
        if missing > NOTEWORTHY:
            self.notes.once("missed", missed)
        columns = nao.joints.columns(self._joints)
        nao.joints.set(columns, nao.robot.to_body(joints)[columns], self.notes)
        return Solution(np.array(joints), missing)

    def solve(self, targets: Targets, q: Floats, *, com: Floats | None = None) -> Solution | None:
        """Joint values of the whole robot, near to those at the beginning.

        Args:
            targets: effector → pose (4, 4) or place (3,) in the world, and its weights of metres and of radians. A foot
                that has one is not kept.
            q: where the search begins, shape (nq,).
            com: where the centre of mass is to be above, shape (2,); None for anywhere above the support.

        Returns:
            What is missing of all targets together, radians times 0.1; None where no foot stands.
        """
        feet, balance = dict(zip(LEGS, self._scene.T_world_feet, strict=True)), self._balance
        kept = {foot: T for foot, T in feet.items() if foot not in targets and balance.feet[foot] != "Free"}
        standing = {balance.support: kept[balance.support]} if com is None and balance.support in kept else kept
        if not standing:
            return None
        asked = dict(targets) | {foot: (T, (_HELD, RADIAN * _HELD)) for foot, T in kept.items() if foot not in standing}
        torso = asked.pop(TORSO, None)
        weights = {name: weight for name, (_, weight) in asked.items()}
        if torso is not None:
            weights["torso"] = torso[1]
        supported = com is None and balance.support is not None
        found = ik.whole_body(
            self._robot,
            {name: T for name, (T, _) in asked.items()},
            feet={foot[0]: T for foot, T in standing.items()},
            com="support" if supported else com,
            margin=_MARGIN if supported else 0.0,
            torso=None if torso is None else torso[0],
            weights=weights,
            reference=q,
            posture=self._scene.q,
            restarts=0,
        )
        if not np.isfinite(found.q).all():
            return Solution(np.array(q), np.inf)
        off = [np.hypot(away, RADIAN * turn) for away, turn in found.residuals.values()]
        return Solution(found.q, float(np.linalg.norm(off)))


def com_above(robot: NaoModel, q: Floats, T_world_torso: Floats) -> Floats:
    """The centre of mass seen from above, shape (2,) [m]."""
    return np.asarray((T_world_torso[:3, :3] @ robot.com(q) + T_world_torso[:3, 3])[:2])


def _part(now: Floats, wanted: Floats, share: float) -> Floats:
    """A share of the way from a pose (4, 4) to a pose or a place (3,)."""
    if wanted.ndim == 1:
        return np.asarray(now[:3, 3] + share * (wanted - now[:3, 3]))
    R = now[:3, :3] @ exp(share * log(now[:3, :3].T @ wanted[:3, :3]))
    return join_poses(R, now[:3, 3] + share * (wanted[:3, 3] - now[:3, 3]))


# --- The motion tasks of whole-body control: to balance, along paths, and effectors that are held in FRAME_ROBOT.

HELD: tuple[str, ...] = ("Head", "LArm", "RArm")
# How fast targets of effectors that are held move [m/s, rad/s].
_PLACE_SPEED, _TURN_SPEED = 0.2, 0.8
# The least time that a way at the joints' speed takes [s].
_LEAST_DURATION = 0.1


class GoToBalance(WholeTask):
    """The centre of mass goes above a foot, or between both; what wbGoToBalance does.

    Args:
        nao: the virtual NAO.
        name: NAOqi's method.
        support: "Legs", "LLeg" or "RLeg".
        duration: how long it takes [s]; or with `fraction` the least.
        fraction: of the joints' largest speeds; None where the duration is given.
    """

    def __init__(
        self, nao: VirtualNao, name: str, support: str, duration: float, fraction: float | None = None
    ) -> None:
        super().__init__(nao, name, Balance(enabled=True))
        self._support, self._duration, self._fraction = support, duration, fraction
        self.value = False

    def start(self, nao: VirtualNao, time: float) -> None:
        """Note where the centre of mass is, and where it goes: above the middle of the feet's pressure sensors."""
        super().start(nao, time)
        scene, feet = self._scene, LEGS if self._support == "Legs" else (self._support,)
        sensors = nao.robot.fk(scene.q, [f"{foot[0]}Foot/FSR/{sensor}" for foot in feet for sensor in _SENSORS])
        self._to = (scene.T_world_torso @ sensors)[:, :2, 3].mean(axis=0)
        self._from = com_above(nao.robot, scene.q, scene.T_world_torso)
        if self._fraction is not None:
            goal = self.solve({}, scene.q, com=self._to)
            assert goal is not None
            ways = np.abs(goal.q - scene.q) / (self._fraction * nao.robot.velocity_limits)
            # The smooth way is 15/8 as fast in its middle as on average.
            self._duration = max(self._duration, 1.875 * float(ways.max()))
            arguments.check_duration(self._duration, "the time to balance")

    def advance(self, nao: VirtualNao, time: float) -> bool:
        """The whole robot for this tick's place of the centre of mass."""
        share = min((time - self._start) / self._duration, 1.0)
        place = self._from + float(smooth(np.array(share))) * (self._to - self._from)
        found = self.command(nao, {}, "the centre of mass goes as near to its place as it can", com=place)
        assert found is not None
        done = share >= 1.0 - ON_TIME
        if done:
            away = com_above(nao.robot, found.q, nao.base.torso(found.q)) - self._to
            stiff = bool((nao.joints.stiffness[nao.joints.columns(self._joints)] > 0.0).all())
            self.value = stiff and float(np.linalg.norm(away)) <= NOTEWORTHY
        return done


class WholePathTask(WholeTask):
    """Effectors follow paths, the whole robot after them; what positionInterpolations does in whole-body control.

    Args:
        name: NAOqi's method.
        nao: the virtual NAO.
        wishes: of each effector its path, with masks of `MASKS`.
        balance: what is kept.
    """

    def __init__(self, name: str, nao: VirtualNao, wishes: Sequence[Wish], balance: Balance) -> None:
        super().__init__(nao, name, balance)
        self._wishes = tuple(wishes)

    def start(self, nao: VirtualNao, time: float) -> None:
        """Begin where the joints are commanded to be."""
        hold_still(nao, self._wishes)
        super().start(nao, time)
        paths = [EffectorPath(np.concatenate([[0.0], wish.times]), self._scene.path(wish)) for wish in self._wishes]
        self._paths, self._end = paths, max(float(path.times[-1]) for path in paths)

    def advance(self, nao: VirtualNao, time: float) -> bool:
        """The whole robot for this tick's poses."""
        t = time - self._start
        T_world_torso = nao.base.torso(nao.joints.q(sensor=False))
        targets: dict[str, tuple[Floats, tuple[float, float]]] = {}
        for wish, path in zip(self._wishes, self._paths, strict=True):
            T = path.pose(t)
            T_world = T_world_torso @ T if wish.space == FRAME_TORSO else T
            weights = MASKS[AXIS_MASK_ALL if wish.effector == TORSO else wish.mask]
            targets[wish.effector] = T_world[:3, 3] if weights[1] == 0.0 else T_world, weights
        found = self.command(nao, targets, "an effector goes as near to its target as balance and the feet let it")
        if found is None:
            self.notes.once("feet", "no foot stands: nothing moves (wbFootState says which stay)")
        return t >= self._end - ON_TIME


class EffectorControl(WholeTask):
    """Effectors are held where they were last told to be, by the whole robot; what wbSetEffectorControl does.

    Targets are in FRAME_ROBOT: of an arm the place of its hand [m], of the head its rotation (wx, wy, wz) [rad]. They
    move at 0.2 m/s and 0.8 rad/s to where they are told.

    Args:
        nao: the virtual NAO.
        balance: what is kept; read in every tick.

    Attributes:
        goals: of each effector that is held, where it goes: a place (3,), of the head a rotation (3, 3).
    """

    reactive = True

    def __init__(self, nao: VirtualNao, balance: Balance) -> None:
        super().__init__(nao, "wbEnableEffectorControl", balance)
        self.goals: dict[str, Floats] = {}
        self._now: dict[str, Floats] = {}
        self.over = False

    def hold(self, nao: VirtualNao, effector: str) -> None:
        """Hold an effector where it is."""
        scene = Scene(nao)
        T_world = scene.T_world_torso @ nao.robot.fk(scene.q, effector)
        self._now[effector] = self.goals[effector] = T_world[:3, :3] if effector == "Head" else T_world[:3, 3]

    def send(self, nao: VirtualNao, effector: str, target: Floats) -> None:
        """Tell where an effector is to be, shape (3,) in FRAME_ROBOT."""
        T_world_robot = Scene(nao).T_world_robot
        if effector == "Head":
            self.goals[effector] = T_world_robot[:3, :3] @ matrix_from_rpy(target)
        else:
            self.goals[effector] = T_world_robot[:3, :3] @ target + T_world_robot[:3, 3]

    def advance(self, nao: VirtualNao, time: float) -> bool:
        """Move the targets on, and the whole robot after them."""
        targets: dict[str, tuple[Floats, tuple[float, float]]] = {}
        for effector, goal in self.goals.items():
            now = self._now[effector] = _towards(self._now[effector], goal)
            if effector == "Head":
                targets[effector] = join_poses(now, np.zeros(3)), MASKS[AXIS_MASK_ROT]
            else:
                targets[effector] = now, MASKS[AXIS_MASK_VEL]
        if self.resources:
            self.command(nao, targets, "an effector goes as near to its target as balance lets it")
        return False

    def give_up(self, resources: frozenset[str]) -> None:
        """Leave some joints to another task."""
        super().give_up(resources)
        self._joints = tuple(joint for joint in self._joints if joint in self.resources)
        if self.started is not None:
            self._most[[index for index, name in enumerate(self._robot.joint_names) if name in resources]] = np.inf

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


# --- The methods.

# What NAOqi documents for wbEnableEffectorOptimization.
_OPTIMIZED = ("All", "Arms", "Legs", "Head", "LArm", "RArm", "LLeg", "RLeg", "Torso", "Com")


class WholeBodyControl(CartesianControl):
    """The methods of ALMotion that move the whole robot, with its feet in place and its balance kept.

    They go through `nk.ik.whole_body`: the feet that stand are met exactly, and with the balance constraint the centre
    of mass stays 5 mm inside the support polygon of their pressure sensors. It is balance at rest: nothing has inertia.

    - While it is on, positionInterpolations and transformInterpolations go through it too: all joints but the hands
      help, and a foot that is neither moved nor "Free" stays. Masks are then 7, 56 or 63; others move their own chain.
    - setAngles, angleInterpolation and setPositions move their own joints; the balance does not correct them.
    - "Plane" counts as "Fixed": a foot does not slide.
    - wbEnableEffectorOptimization changes nothing.
    """

    _control: EffectorControl | None = None

    def __init__(self, nao: VirtualNao) -> None:
        super().__init__(nao)
        self.balance = Balance()

    def _path_task(self, name: str, found: Sequence[Wish]) -> Task:
        """The whole robot follows the paths while whole-body control is on and knows their masks."""
        if self.balance.enabled and all(wish.mask in MASKS for wish in found):
            return WholePathTask(name, self.nao, found, self.balance)
        return super()._path_task(name, found)

    def kernels_for(self, name: str, given: tuple[Any, ...]) -> frozenset[str]:
        """The whole body holds its balance, and while it is on, effectors too."""
        paths = name.startswith(("positionInterpolation", "transformInterpolation")) and self.balance.enabled
        needed = paths or name.startswith("wb")
        return super().kernels_for(name, given) | (frozenset({"bodies"}) if needed else frozenset())

    def wbEnable(self, isEnabled: Any) -> None:
        """Switch whole-body control on or off; off forgets all constraints."""
        on = arguments.flag(isEnabled, "isEnabled")
        if not on:
            self._release()
            self.balance = Balance()
        self.balance.enabled = on

    def wbFootState(self, stateName: Any, supportLeg: Any) -> None:
        """Say what a foot may do.

        Args:
            stateName: "Fixed", "Plane" or "Free".
            supportLeg: "LLeg", "RLeg" or "Legs" for both.
        """
        state = arguments.choice(stateName, "foot state", FOOT_STATES)
        leg = arguments.choice(supportLeg, "support leg", SUPPORTS)
        for foot in self.balance.feet:
            if leg in (foot, "Legs"):
                self.balance.feet[foot] = state

    def wbEnableBalanceConstraint(self, isEnable: Any, supportLeg: Any) -> None:
        """Keep the centre of mass above what supports it.

        Args:
            isEnable: False to let it go.
            supportLeg: "Legs" for anywhere above both feet, "LLeg" or "RLeg" for above that one.
        """
        leg = arguments.choice(supportLeg, "support leg", SUPPORTS)
        self.balance.support = leg if arguments.flag(isEnable, "isEnable") else None

    def wbGoToBalance(self, supportLeg: Any, duration: Any) -> Call:
        """Bring the centre of mass above the middle of what supports it; returns whether it is there.

        Args:
            supportLeg: "LLeg", "RLeg" or "Legs" for both.
            duration: how long it takes [s].
        """
        leg = arguments.choice(supportLeg, "support leg", SUPPORTS)
        seconds = arguments.duration(duration, "duration")
        self.nao.base.check_stands()
        return self.nao.start_task(GoToBalance(self.nao, "wbGoToBalance", leg, seconds))

    def wbGoToBalanceWithSpeed(self, supportLeg: Any, fractionMaxSpeed: Any) -> Call:
        """The same, no joint faster than a fraction of its maximum speed."""
        leg = arguments.choice(supportLeg, "support leg", SUPPORTS)
        share = arguments.fraction(fractionMaxSpeed, "fractionMaxSpeed", positive=True)
        self.nao.base.check_stands()
        return self.nao.start_task(GoToBalance(self.nao, "wbGoToBalanceWithSpeed", leg, _LEAST_DURATION, share))

    def wbEnableEffectorControl(self, effectorName: Any, isEnabled: Any) -> None:
        """Hold an effector by the whole robot, at first where it is; it switches whole-body control on.

        Args:
            effectorName: "Head", "LArm" or "RArm".
            isEnabled: False to let it go.
        """
        effector = arguments.choice(effectorName, "effector", HELD)
        if not arguments.flag(isEnabled, "isEnabled"):
            held = self._held()
            held.pop(effector, None)
            if not held:
                self._release()
            return
        self.nao.base.check_stands()
        if not self.balance.enabled:
            self.balance.enabled, self.balance.support = True, "Legs"
        if self._control is None or self._control.over:
            self._control = EffectorControl(self.nao, self.balance)
            self.nao.start_task(self._control)
        self._control.hold(self.nao, effector)

    def wbSetEffectorControl(self, effectorName: Any, targetCoordinate: Any) -> None:
        """Tell where an effector that is held is to be; returns at once.

        Args:
            effectorName: "Head", "LArm" or "RArm".
            targetCoordinate: in FRAME_ROBOT: of an arm the place of its hand [x, y, z] [m], of the head its rotation
                [wx, wy, wz] [rad].
        """
        effector = arguments.choice(effectorName, "effector", HELD)
        target = arguments.three(targetCoordinate, "targetCoordinate")
        if self._control is None or effector not in self._held():
            raise BadArgument(f"{effector} is not held: wbEnableEffectorControl({effector!r}, True) first")
        self._control.send(self.nao, effector, target)

    def wbEnableEffectorOptimization(self, effectorName: Any, isActive: Any) -> None:
        """Taken and left; an effector whose target is far goes as near as it can in any case."""
        arguments.choice(effectorName, "effector", _OPTIMIZED)
        arguments.flag(isActive, "isActive")

    def _held(self) -> dict[str, Floats]:
        """The effectors that are held, with their goals."""
        return {} if self._control is None or self._control.over else self._control.goals

    def _release(self) -> None:
        if self._control is not None and not self._control.over:
            self.nao.tasks.kill(self._control.id)
        self._control = None
