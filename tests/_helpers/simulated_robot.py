"""A NAO in MuJoCo that stands, walks, kicks, sits, is pushed and carried: logs of its sensors, with the truth.

The robot is the library's own MJCF export, on a plane, with servos that are damped a little less, so that its feet slip
as they do on a floor. The truth is that of MuJoCo.
"""

from __future__ import annotations

import functools
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from scipy.linalg import solve_banded
from scipy.spatial.transform import Rotation
from simulated_plans import LEGS, SHIFT, STEP, gesture, kick, smooth, walk

import nao_kin as nk

GRAVITY = 9.81
LYING = ("front", "back", "left", "right")
# Directions in which a robot is pushed to fall on a side, in its own axes.
SIDES = {"front": (1.0, 0.0), "back": (-1.0, 0.0), "left": (0.0, 1.0), "right": (0.0, -1.0)}
_SETTLES = 0.3  # time before the first row, in which the feet begin to press [s]


@dataclass(frozen=True)
class Truth:
    """What happens in each row; nothing is known of it on a robot.

    Attributes:
        times: times of the n rows [s].
        q: joints as they are, shape (n, nq).
        T: pose of the torso, shape (n, 4, 4).
        loads: force on each sole along its normal [kg], shape (n, 2).
        pressure: centre of pressure of each sole in the world, shape (n, 2, 3) [m], NaN where it carries nothing.
        specific, rates: what an ideal accelerometer [m/s²] and gyrometer [rad/s] show, shapes (n, 3).
        play: which side of its gear each joint rests on, −1 to 1, shape (n, nq).
        doing: "standing", "walking", "falling", "front", "back", "left" and "right" where it lies on that side,
            "carried", "sitting", or "" between two of these.
    """

    times: np.ndarray
    q: np.ndarray
    T: np.ndarray
    loads: np.ndarray
    pressure: np.ndarray
    specific: np.ndarray
    rates: np.ndarray
    play: np.ndarray
    doing: np.ndarray

    @property
    def share(self) -> np.ndarray:
        """Share of the weight on each sole, shape (n, 2)."""
        return self.loads / max(float(np.percentile(self.loads.sum(axis=1), 95.0)), 2.7)

    @property
    def roll_pitch(self) -> np.ndarray:
        """AngleX and AngleY as they are, shape (n, 2) [rad]."""
        R = self.T[:, :3, :3]
        return np.column_stack([np.arctan2(R[:, 2, 1], R[:, 2, 2]), np.arcsin(np.clip(-R[:, 2, 0], -1.0, 1.0))])

    @property
    def heading(self) -> np.ndarray:
        """Heading of the torso, shape (n,) [rad]."""
        return np.unwrap(np.arctan2(self.T[:, 1, 0], self.T[:, 0, 0]))

    @property
    def centre_of_pressure(self) -> np.ndarray:
        """Centre of pressure of both soles in the world, shape (n, 2) [m]."""
        with np.errstate(invalid="ignore"):
            return (self.loads[..., None] * np.nan_to_num(self.pressure)).sum(axis=1)[:, :2] / self.loads.sum(
                axis=1, keepdims=True
            )

    def at(self, rows: Any) -> Truth:
        """Return some rows."""
        return Truth(*(getattr(self, field.name)[rows] for field in fields(self)))


# --- The simulation.


@functools.cache
def _model(version: str) -> Any:
    """Return the exported robot on its floor, with a person's hand that can hold the torso, and a chair far away."""
    with tempfile.TemporaryDirectory() as folder:
        done = nk.export.mjcf(nk.load_nao(version), Path(folder) / "nao", meshes="none", frames="none")
        spec = mujoco.MjSpec.from_file(str(done.path))
    for sensor in [one for one in spec.sensors if not one.name.startswith(("Accelerometer", "Gyrometer"))]:
        spec.delete(sensor)
    spec.worldbody.add_body(name="hand", mocap=True)
    chair = spec.worldbody.add_body(name="chair", mocap=True, pos=[0.0, 0.0, -5.0])
    chair.add_geom(name="chair", type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.1, 0.15, 0.05])
    weld = spec.add_equality(
        name="hand",
        type=mujoco.mjtEq.mjEQ_WELD,
        objtype=mujoco.mjtObj.mjOBJ_BODY,
        name1="hand",
        name2="torso",
        active=False,
        solref=[0.04, 1.0],  # arms yield
    )
    weld.data[:11] = [0.0] * 6 + [1.0] + [0.0] * 3 + [1.0]  # at the same pose
    return spec.compile()


class Scene:
    """A robot that does one thing after the other; `truth()` returns all rows, every 2 ms."""

    def __init__(self, nao: nk.NaoModel, posture: str = "StandInit", *, friction: float = 0.8) -> None:
        self.nao, self.model = nao, _model(nao.version).__copy__()
        model = self.model
        model.geom_friction[:, 0] = friction
        damping = model.dof_damping.reshape(model.nv, -1)[model.jnt_dofadr[model.actuator_trnid[:, 0]], 0]
        model.actuator_biasprm[:, 2] += (3.0**0.5 - 1.0) * damping
        self.data = data = mujoco.MjData(model)
        mujoco.mj_resetDataKeyframe(model, data, model.key(posture).id)
        self.q = nao.posture(posture)  # what the servos shall do
        self._joints = [model.joint(name).qposadr[0] for name in nao.joint_names]
        self._servos = [model.actuator(name).id for name in nao.joint_names]
        self._torso = model.body("torso").id
        self._weld = model.equality("hand").id
        self._chair = model.body("chair").mocapid[0]
        feet = [model.body(name).id for name in ("l_ankle", "r_ankle")]
        self._foot_of = np.full(model.ngeom, -1)
        for k, foot in enumerate(feet):
            self._foot_of[model.geom_bodyid == foot] = k
        self._rows: list[tuple[Any, ...]] = []
        self.doing = "sitting" if posture.startswith("Sit") else "standing"
        mujoco.mj_step(model, data, round(_SETTLES / STEP))

    @property
    def T(self) -> np.ndarray:
        """The pose of the torso now."""
        T = np.eye(4)
        mujoco.mj_kinematics(self.model, self.data)
        T[:3, :3], T[:3, 3] = self.data.xmat[self._torso].reshape(3, 3), self.data.xpos[self._torso]
        return T

    def _step(self) -> None:
        """Go on by 2 ms, and write down the state before."""
        data = self.data
        before = data.qpos[self._joints]
        mujoco.mj_step(self.model, data)
        contact = data.contact
        pressed = np.zeros((3, 4))  # of the left and the right sole, and of all else: force and force · place
        if len(contact.dist):
            force = np.where(contact.efc_address >= 0, data.efc_force[contact.efc_address], 0.0)
            ground = self._ground[contact.geom].any(axis=1)
            for f, geoms, place in zip(force[ground], contact.geom[ground], contact.pos[ground], strict=True):
                pressed[self._foot_of[geoms].max(), 0] += f
                pressed[self._foot_of[geoms].max(), 1:] += f * place
        sensors = data.sensordata.copy()
        effort = data.actuator_force[self._servos]
        held = bool(data.eq_active[self._weld])
        self._rows.append(
            (
                before,
                data.xmat[self._torso].copy(),
                data.xpos[self._torso].copy(),
                pressed,
                sensors,
                effort,
                held,
                self.doing,
            )
        )

    @functools.cached_property
    def _ground(self) -> np.ndarray:
        ground = np.zeros(self.model.ngeom, dtype=bool)
        ground[[self.model.geom("floor").id, self.model.geom("chair").id]] = True
        return ground

    def play(self, q: np.ndarray, doing: str | None = None) -> Scene:
        """Play configurations (n, nq), one every 2 ms."""
        before, self.doing = self.doing, doing or self.doing
        for row in q:
            self.data.ctrl[self._servos] = row
            self._step()
        if len(q):
            self.q = q[-1]
        self.doing = before
        return self

    def walk(self, way: np.ndarray, posture: str = "StandInit") -> Scene:
        """Play a walk, with the shift of the weight before and after it, and end in a posture."""
        shift = round(SHIFT / STEP)
        self.go(way[0], 0.5).play(way[:shift]).play(way[shift:-shift], "walking").play(way[-shift:])
        return self.go(self.nao.posture(posture), 0.5)

    def hold(self, seconds: float) -> Scene:
        """Stay as it is."""
        return self.play(np.tile(self.q, (round(seconds / STEP), 1)))

    def go(self, q: np.ndarray, seconds: float) -> Scene:
        """Move all joints to a configuration."""
        u = smooth(np.arange(1, round(seconds / STEP) + 1) * STEP / seconds)[:, None]
        return self.play(self.q + u * (q - self.q))

    def push(self, direction: Sequence[float], force: float, seconds: float = 0.1) -> Scene:
        """Push the torso, in a direction of its own axes [N]."""
        x, y = direction
        R = self.T[:3, :3]
        self.data.xfrc_applied[self._torso, :3] = force * (R @ [x, y, 0.0])
        self.hold(seconds)
        self.data.xfrc_applied[self._torso] = 0.0
        return self

    def carry(
        self,
        seconds: float,
        tilt: float = 0.0,
        about: float = 0.0,
        *,
        rng: np.random.Generator | None = None,
        posture: str = "",
        x: float = 0.0,
    ) -> Scene:
        """A person lifts the robot in 1 s, tilts it about a horizontal axis, walks, and puts it down in 1.5 s.

        It is put down as it was, in a posture of the robot, or on a "chair", `x` ahead in the world.
        """
        data, begin, end, q, seat = self.data, self.T, self.T, self.q, None
        if posture == "chair":
            sides = {side + joint: value for side in "LR" for joint, value in (("HipPitch", -1.5), ("KneePitch", 1.5))}
            q, end[:3, :3] = self.nao.posture("Stand", **sides, LAnklePitch=0.0, RAnklePitch=0.0), np.eye(3)
            end[2, 3] = 0.14 + rng.uniform(-0.02, 0.03) + 0.09
            seat = np.array([end[0, 3] + x - 0.06, end[1, 3], end[2, 3] - 0.18])
        elif posture:
            key, q = self.model.key(posture).qpos[:7], self.nao.posture(posture)
            end[:3, :3] = Rotation.from_quat(key[3:], scalar_first=True).as_matrix()
            end[2, 3] = key[2]
        end[0, 3] += x
        phases = np.zeros(4) if rng is None else rng.uniform(0.0, 2.0 * np.pi, 4)
        lifted, put = 1.0, 1.5
        n = round((lifted + seconds + put) / STEP)
        t = STEP * np.arange(1, n + 1)
        up = smooth(t / lifted) - smooth((t - lifted - seconds) / put)
        leaned = smooth(t / lifted - 0.3) - smooth((t - lifted - seconds) / put + 0.3)
        there = smooth((t - lifted) / seconds)
        axis = Rotation.from_euler("z", about).apply([1.0, 0.0, 0.0])
        first, last = Rotation.from_matrix(begin[:3, :3]), Rotation.from_matrix(end[:3, :3])
        between = (last * first.inv()).as_rotvec()
        data.mocap_pos[0], data.eq_active[self._weld] = begin[:3, 3], 1
        before, self.doing = self.q, "sitting" if posture.startswith(("Sit", "chair")) else "standing"
        walks = up[:, None] * np.sin(2.0 * np.pi * t[:, None] * [1.8, 0.9, 0.5, 0.7] + phases)
        sway = Rotation.from_rotvec(walks[:, [1, 3, 2]] * np.radians([3.0, 3.0, 6.0]))
        R = (
            sway
            * Rotation.from_rotvec(np.outer(tilt * leaned, axis))
            * Rotation.from_rotvec(np.outer(there, between))
            * first
        )
        place = begin[:3, 3] + there[:, None] * (end[:3, 3] - begin[:3, 3])
        place[:, 1:] += 0.02 * walks[:, [1, 0]]
        place[:, 2] += 0.3 * up
        joints = before + there[:, None] * (q - before)
        for now, quaternion, row in zip(place, R.as_quat(scalar_first=True), joints, strict=True):
            data.mocap_pos[0], data.mocap_quat[0], data.ctrl[self._servos] = now, quaternion, row
            if seat is not None and now[2] > begin[2, 3] + 0.25:
                data.mocap_pos[self._chair] = seat
            self._step()
        self.q = q
        data.eq_active[self._weld] = 0
        return self

    def truth(self) -> Truth:
        """Return what has happened so far."""
        joints, R, place, pressed, sensors, effort, held, doing = (
            np.array(part) for part in zip(*self._rows, strict=True)
        )
        T = np.tile(np.eye(4), (len(R), 1, 1))
        T[:, :3, :3], T[:, :3, 3] = R.reshape(-1, 3, 3), place
        # Sensors under a sole feel what presses along its normal: not what a foot on its edge carries.
        normal = (T[:, None] @ self.nao.fk(joints, list(LEGS)))[..., 2, 2]
        loads = pressed[:, :2, 0] / GRAVITY * np.maximum(normal, 0.0)
        with np.errstate(invalid="ignore", divide="ignore"):
            centre = pressed[:, :2, 1:] / pressed[:, :2, :1]
        address = [
            self.model.sensor(f"{name}").adr[0] for name in ("Accelerometer_acceleration", "Gyrometer_angular_velocity")
        ]
        specific, rates = (sensors[:, at : at + 3] for at in address)
        found = Truth(
            STEP * np.arange(len(R)),
            joints,
            T,
            loads,
            centre,
            specific,
            rates,
            np.tanh(effort / 0.1),
            doing,
        )
        return replace(found, doing=_named(found, pressed[:, 2, 0] / GRAVITY, held, self.nao))


def _named(truth: Truth, other: np.ndarray, held: np.ndarray, nao: nk.NaoModel) -> np.ndarray:
    """Return what the robot does, from the names of a scene and what carries it; `other` are not its soles [kg]."""
    doing = truth.doing.astype("<U8")
    up = truth.T[:, 2, :3]
    carried = truth.loads.sum(axis=1) / nao.mass
    soles = truth.T[:, None] @ nao.fk(truth.q, list(LEGS))
    flat = (soles[..., 2, 2] > np.cos(np.radians(3.0))) & (truth.loads > 0.2 * nao.mass)
    doing[held] = np.where((carried + other / nao.mass < 0.05)[held], "carried", "")
    free = ~held & (doing != "sitting")
    down = free & (up[:, 2] < np.cos(np.radians(50.0))) & ~flat.any(axis=1)
    side = np.where(
        np.abs(up[:, 0]) >= np.abs(up[:, 1]),
        np.where(up[:, 0] < 0.0, "front", "back"),
        np.where(up[:, 1] < 0.0, "left", "right"),
    )
    begins = np.flatnonzero(np.diff(down.astype(int), prepend=0) == 1)
    stood = np.flatnonzero(flat.any(axis=1) | held)
    for begin in begins:
        if begin == 0 or held[begin - 1]:
            continue
        before = stood[stood < begin].max(initial=-1)
        doing[before + 1 : begin] = "falling"
        struck = other[begin:] > 0.3 * nao.mass
        end = begin + int(np.argmax(struck)) if struck.any() else len(doing)
        doing[begin:end] = "falling"
        down[begin:end] = False
    doing[down] = side[down]
    sitting = (truth.doing == "sitting") & ~held
    doing[sitting & (other < 0.3 * nao.mass)] = ""
    return doing


# --- Whole scenes.


def life(nao: nk.NaoModel) -> Truth:
    """31 s: stand, walk, fall to the front, be put on the feet, be carried, fall to the left and on the back."""
    scene = Scene(nao).hold(1.0).walk(walk(nao, 6, 0.04, 0.005, 0.05)).hold(1.0)
    for side in ("front", "left", "back"):
        scene.push(SIDES[side], 80.0).hold(1.5).carry(1.0, posture="StandInit", x=0.2).hold(1.0)
        if side == "front":
            scene.carry(1.5, np.radians(8.0), 1.0, x=0.3).hold(1.0)
    return scene.truth()


def _standing(nao: nk.NaoModel, rng: np.random.Generator) -> Scene:
    scene = Scene(nao, rng.choice(["Stand", "StandInit", "Crouch"]))
    return scene.play(gesture(nao, scene.q, rng.uniform(3.0, 8.0), rng, ["Head"]))


def _turning_its_head(nao: nk.NaoModel, rng: np.random.Generator) -> Scene:
    scene = Scene(nao, "StandInit")
    return scene.play(gesture(nao, scene.q, 50.0, rng, ["Head"]))


def _gesturing(nao: nk.NaoModel, rng: np.random.Generator) -> Scene:
    scene = Scene(nao, rng.choice(["Stand", "StandInit"]))
    scene.play(gesture(nao, scene.q, rng.uniform(4.0, 8.0), rng))
    for name in rng.choice(["Stand", "StandInit", "Crouch"], 2):
        scene.go(nao.posture(name), rng.uniform(1.0, 2.0))
    return scene.hold(0.5)


def _walking(nao: nk.NaoModel, rng: np.random.Generator, friction: float = 0.8, seconds: float = 1.5) -> Scene:
    scene = Scene(nao, friction=friction).hold(seconds)
    x, y, turn = rng.uniform(-0.03, 0.05), rng.uniform(-0.015, 0.015), rng.uniform(-0.2, 0.2)
    way = walk(nao, int(rng.integers(4, 16)), x, y, turn)
    return scene.walk(way).hold(1.0)


def _slipping(nao: nk.NaoModel, rng: np.random.Generator) -> Scene:
    return _walking(nao, rng, 0.15)


def _kicking(nao: nk.NaoModel, rng: np.random.Generator) -> Scene:
    way = kick(nao, int(rng.integers(2)), rng.uniform(0.03, 0.08), rng.uniform(0.25, 0.5))
    return Scene(nao).hold(0.5).go(way[0], 0.5).play(way).hold(0.5)


def _falling(nao: nk.NaoModel, rng: np.random.Generator) -> Scene:
    scene = Scene(nao, rng.choice(["Stand", "StandInit", "Crouch"])).hold(rng.uniform(1.0, 2.0))
    return scene.push(SIDES[rng.choice(LYING)], rng.uniform(70.0, 110.0)).hold(3.0)


def _pushed(nao: nk.NaoModel, rng: np.random.Generator) -> Scene:
    scene = Scene(nao, rng.choice(["Stand", "StandInit"])).hold(1.0)
    for side in rng.choice(LYING, 3):
        scene.push(SIDES[side], rng.uniform(5.0, 25.0)).hold(1.0)
    return scene


def _falling_as_it_walks(nao: nk.NaoModel, rng: np.random.Generator) -> Scene:
    way = walk(nao, 10, rng.uniform(0.02, 0.05), 0.0, rng.uniform(-0.1, 0.1))
    scene, at = Scene(nao).hold(1.0).go(way[0], 0.5), round(rng.uniform(2.0, 4.0) / STEP)
    scene.play(way[: round(SHIFT / STEP)]).doing = "walking"
    scene.play(way[round(SHIFT / STEP) : at]).push(SIDES[rng.choice(LYING)], rng.uniform(40.0, 90.0)).play(way[at:])
    scene.doing = "standing"
    return scene.hold(1.5)


def _carried(nao: nk.NaoModel, rng: np.random.Generator) -> Scene:
    scene = Scene(nao, rng.choice(["Stand", "StandInit", "Crouch"])).hold(1.0)
    tilt, about = np.radians(rng.uniform(0.0, 90.0)), rng.uniform(0.0, 2.0 * np.pi)
    return scene.carry(rng.uniform(2.0, 5.0), tilt, about, rng=rng, x=rng.uniform(-0.5, 0.5)).hold(1.5)


def _sitting(nao: nk.NaoModel, rng: np.random.Generator) -> Scene:
    scene = Scene(nao, rng.choice(["Sit", "SitRelax"])).hold(0.5)
    return scene.play(gesture(nao, scene.q, rng.uniform(3.0, 6.0), rng, ["Head", "RElbow", "RWrist"]))


def _put_on_the_floor(nao: nk.NaoModel, rng: np.random.Generator) -> Scene:
    scene = Scene(nao, "Stand").hold(1.5)
    return scene.carry(2.0, rng=rng, posture=rng.choice(["Sit", "SitRelax", "LyingBack", "LyingBelly"])).hold(4.0)


def _put_on_a_chair(nao: nk.NaoModel, rng: np.random.Generator) -> Scene:
    return Scene(nao, "Stand").hold(1.5).carry(2.0, rng=rng, posture="chair").hold(4.0)


def _put_on_its_feet(nao: nk.NaoModel, rng: np.random.Generator) -> Scene:
    scene = Scene(nao, rng.choice(["LyingBack", "LyingBelly", "Sit", "SitRelax"])).hold(rng.uniform(1.0, 3.0))
    return scene.carry(2.0, rng=rng, posture="StandInit").hold(2.0)


# Kind of scene → how to make one, and its share of all.
KINDS: dict[str, tuple[Callable[[nk.NaoModel, np.random.Generator], Scene], int]] = {
    "standing": (_standing, 2),
    "standing for 50 s": (_turning_its_head, 1),
    "gesturing": (_gesturing, 3),
    "walking": (_walking, 5),
    "slipping": (_slipping, 2),
    "kicking": (_kicking, 2),
    "falling": (_falling, 4),
    "pushed": (_pushed, 2),
    "falling as it walks": (_falling_as_it_walks, 3),
    "carried": (_carried, 5),
    "sitting": (_sitting, 2),
    "put on the floor": (_put_on_the_floor, 3),
    "put on a chair": (_put_on_a_chair, 1),
    "put on its feet": (_put_on_its_feet, 2),
}


def scene(nao: nk.NaoModel, number: int, seed: int = 0) -> tuple[str, Truth]:
    """Return kind and truth of a scene; the first ones are one of each kind."""
    names = [*KINDS, *(name for name, (_, share) in KINDS.items() for _ in range(share - 1))]
    name = names[number % len(names)]
    return name, KINDS[name][0](nao, np.random.default_rng([seed, number])).truth()


# --- The sensors.


@dataclass(frozen=True)
class Recording:
    """What the sensors say in each row: arguments of `nk.world.state`; and what they ought to say."""

    times: np.ndarray
    q: np.ndarray
    forces: np.ndarray
    accelerometer: np.ndarray
    gyro: np.ndarray
    angles: np.ndarray
    truth: Truth

    def at(self, rows: Any) -> Recording:
        """Return some rows."""
        parts = (getattr(self, field.name)[rows] for field in fields(self) if field.name != "truth")
        return Recording(*parts, self.truth.at(rows))


def recorded(
    nao: nk.NaoModel,
    truth: Truth,
    rng: np.random.Generator,
    *,
    every: float = 0.012,
    jitter: float = 0.0,
    encoder: float = 0.1,
    backlash: float = 0.5,
    zeros: float = 0.0,
    delay: float = 0.0,
    forces: float = 0.03,
    offset: float = 0.0,
    dead: Sequence[int] = (),
    acceleration: float = 0.3,
    acceleration_bias: float = 0.2,
    gyro: float = 0.01,
    gyro_bias: float = 1.0,
    angle: float = 0.1,
) -> Recording:
    """Return the truth as sensors see it.

    Args:
        nao: the robot.
        truth: what happens, every 2 ms or less often.
        rng: of all noise and biases.
        every, jitter: time between rows, and its deviation [s].
        encoder: noise of joint values [°]; they then have 4096 steps in a turn.
        backlash: of each joint [°]: the motor, which is measured, is ahead of the link by half of it where it pushes.
        zeros: deviation of the zeros of the legs' joints [°].
        delay: of all sensors but the joints [s].
        forces: noise of the force on each of the eight cells, as a share, and 0.02 kg. Cells are springs under a rigid
            sole.
        offset: of each cell, at most [kg]; `dead` are indices of cells that show zero.
        acceleration, acceleration_bias: noise and bias in each axis, of random sign [m/s²].
        gyro, gyro_bias: noise [rad/s], and bias in each axis, of random sign [°/s].
        angle: noise of AngleX and AngleY [°], which are a filter of the accelerometer, with its bias, and of a
            gyrometer without bias, with a time constant of 1 s.
    """
    step, count = truth.times[1] - truth.times[0], int((truth.times[-1] - truth.times[0]) / every + 0.5)
    steps = np.clip(every + rng.normal(0.0, jitter, count), step, None)
    rows = np.append(0, np.round(np.cumsum(steps) / step).astype(int))
    rows = rows[rows < len(truth.times)]
    late = np.maximum(rows - round(delay / step), 0)
    n, seen, tick = len(rows), truth.at(late), 2.0 * np.pi / 4096.0
    q = (
        truth.q[rows]
        + np.radians(0.5 * backlash) * truth.play[rows]
        + rng.normal(0.0, np.radians(encoder), (n, nao.nq))
    )
    legs = [k for k, name in enumerate(nao.joint_names) if name[1:].startswith(("Hip", "Knee", "Ankle"))]
    q[:, legs] += rng.normal(0.0, np.radians(zeros), len(legs))
    cells = _cells(nao, seen)
    cells = cells * (1.0 + rng.normal(0.0, forces, cells.shape)) + np.abs(rng.normal(0.0, 0.02, cells.shape))
    cells += rng.uniform(0.0, offset, 8)
    cells[:, list(dead)] = 0.0
    biases = rng.choice([-1.0, 1.0], (2, 3)) * [[acceleration_bias], [np.radians(gyro_bias)]]
    specific = seen.specific + biases[0] + rng.normal(0.0, acceleration, (n, 3))
    return Recording(
        truth.times[rows],
        tick * np.round(q / tick),
        cells,
        specific,
        seen.rates + biases[1] + rng.normal(0.0, gyro, (n, 3)),
        _angles(seen, specific, truth.times[rows]) + rng.normal(0.0, np.radians(angle), (n, 2)),
        truth.at(rows),
    )


def _cells(nao: nk.NaoModel, truth: Truth) -> np.ndarray:
    """Return the force on each of the eight cells (n, 8) [kg]: linear in the place on the sole, and none below zero."""
    names, found = list(nao.semantics.force_sensors), []
    T = truth.T[:, None] @ nao.fk(truth.q, list(LEGS))
    for k, leg in enumerate(LEGS):
        own = names[4 * k : 4 * k + 4]
        places = np.column_stack([np.ones(4), nao.fk(nao.neutral(), own, reference=leg)[:, :2, 3]])
        at = np.einsum("nji,nj->ni", T[:, k, :3, :3], np.nan_to_num(truth.pressure[:, k] - T[:, k, :3, 3]))
        at[:, 2] = 1.0
        pressed = np.maximum(truth.loads[:, k, None] * at[:, [2, 0, 1]] @ np.linalg.pinv(places.T).T, 0.0)
        total = pressed.sum(axis=1, keepdims=True)
        found.append(pressed * truth.loads[:, k, None] / np.where(total > 0.0, total, 1.0))
    return np.concatenate(found, axis=1)


def _angles(truth: Truth, specific: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Return AngleX and AngleY of a complementary filter: the truth, and slow errors of the accelerometer."""
    x, y, z = specific.T
    away = np.column_stack([np.arctan2(y, z), np.arctan2(-x, np.hypot(y, z))]) - truth.roll_pitch
    shaken = np.abs(np.linalg.norm(specific, axis=1) / GRAVITY - 1.0) > 0.2
    away = np.where(shaken[:, None], 0.0, (away + np.pi) % (2.0 * np.pi) - np.pi)
    part = 1.0 - np.exp(-float(np.median(np.diff(times))))
    # slow[n] = part · away[n] + (1 − part) · slow[n − 1]; scipy.signal would take most of a second to import.
    given = part * away + (1.0 - part) * away[:50].mean(axis=0) * np.eye(len(away), 1)
    slow = solve_banded((1, 0), [np.ones(len(away)), np.full(len(away), part - 1.0)], given)
    return (truth.roll_pitch + slow + np.pi) % (2.0 * np.pi) - np.pi


def without(recording: Recording, nao: nk.NaoModel, rng: np.random.Generator) -> Recording:
    """The recording with hands of NaN, 1 % of rows with a joint of NaN, and NaN in the inertial unit."""
    q = recording.q.copy()
    q[:, [nao.joint_names.index(name) for name in ("LHand", "RHand")]] = np.nan
    q[rng.random(len(q)) < 0.01, nao.joint_names.index("LKneePitch")] = np.nan
    gone = rng.random(len(q)) < 0.01
    parts = {name: getattr(recording, name).copy() for name in ("gyro", "accelerometer", "angles", "forces")}
    for part in parts.values():
        part[gone] = np.nan
    return replace(recording, q=q, **parts)
