"""`nao-kin sample`: small files to try the other commands with. All are computed here, the same on every call."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from nao_kin._core import files as atomic
from nao_kin._core.arrays import Floats, choice
from nao_kin.cli.options import OUTPUT, OutputOptions, argument, command, option
from nao_kin.cli.output import csv_text, print_json, print_table, print_written
from nao_kin.errors import BadArgument

if TYPE_CHECKING:
    from nao_kin.robot import NaoModel
    from nao_kin.world import Camera

_ALL = "all"


@command("sample", "Example: nao-kin sample walk.csv wave.xar; nao-kin sample all -o samples")
def sample(
    *,
    sample_names: list[str] | None = argument(
        "NAME", "A sample; several, or all. Default: list them, or with -o write all.", None
    ),
    folder: str | None = option(
        "FOLDER", "Write the files into this folder; it is made if needed. Default: the current one.", *OUTPUT
    ),
    written: OutputOptions,
) -> None:
    """Write small files to try the other commands with, or list them."""
    if folder == "-":
        raise BadArgument("--output is the folder for the samples, and - is not one; leave it out for this folder")
    if not sample_names and folder is None:
        rows = [(name, one.purpose) for name, one in SAMPLES.items()]
        if written.json:
            print_json({"samples": [{"name": name, "purpose": purpose} for name, purpose in rows]})
        else:
            print_table(("name", "what it is"), rows)
        return
    chosen = list(
        dict.fromkeys(part for name in sample_names or [_ALL] for part in (SAMPLES if name == _ALL else [name]))
    )
    for name in chosen:
        choice(name, NAMES, "sample")
    folder = "." if folder is None else folder
    with atomic.errors_naming(folder):
        Path(folder).mkdir(parents=True, exist_ok=True)
    paths = {name: Path(folder, name) for name in chosen}
    for path in paths.values():
        check = atomic.check_replaceable if path.suffix else atomic.check_folder
        check(path, overwrite=written.force)
    from nao_kin.robot import load_nao

    nao = load_nao()
    for name, path in paths.items():
        SAMPLES[name].write(nao, path)
    if written.json:
        print_json({"files": [str(path) for path in paths.values()]})
    else:
        print_written(*paths.values())


def _table(path: Path, names: Sequence[str], columns: Iterable[Floats]) -> None:
    rows = np.column_stack([*columns]).round(5) + 0.0
    atomic.write_text(path, csv_text(names, rows.tolist()))


# --- A walk, and what a robot's sensors would say of it.

_STEP, _STEPS, _STRIDE, _STILL, _SAMPLING = 0.8, 6, 0.03, 1.0, 0.02  # s, number, m, s, s
_GRAVITY = 9.81  # m/s²


def _times(begin: float, end: float, step: float) -> Floats:
    return begin + step * np.arange(round((end - begin) / step) + 1, dtype=np.float64)


def _smooth(time: Floats, begin: float, end: float) -> Floats:
    """Return 0 before `begin`, 1 after `end`, and between them a polynomial at rest at both ends."""
    s = np.clip((time - begin) / (end - begin), 0.0, 1.0)
    return s**3 * (10.0 - 15.0 * s + 6.0 * s * s)


def _standing(nao: NaoModel, n: int) -> tuple[Floats, dict[str, Floats], float]:
    """Return configurations (n, 25) of standing, the places (n, 3) of both feet in the world, the torso's height."""
    stand = nao.posture("StandInit")
    at = {side: nao.position(stand, f"{side}Leg") for side in "LR"}
    feet = {side: np.tile(place * [0.0, 1.0, 0.0], (n, 1)) for side, place in at.items()}
    return np.tile(stand, (n, 1)), feet, float(-at["L"][2])


def _legs(nao: NaoModel, q: Floats, torso: Floats, roll: Floats, feet: dict[str, Floats]) -> Floats:
    """Return q with legs that put parallel feet at places (n, 3) in the world, under a torso that leans to a side."""
    from nao_kin.ik import leg
    from nao_kin.rotations import rot_x
    from nao_kin.screws import inverse, pose

    T_world_torso = pose(rot_x(roll), torso)
    for side, places in feet.items():
        columns = [nao.joint_names.index(name) for name in nao.chains[f"{side}Leg"] if name in nao.joint_names]
        targets = inverse(T_world_torso) @ pose(np.eye(3), places)
        # One by one: each is a closed form, and nothing is compiled.
        q[:, columns] = [leg(nao, side, target).q[columns] for target in targets]
    return q


class _Walk(NamedTuple):
    """A walk in n rows: the torso's place is (n, 3), its roll (n,), and `left` the left foot's share of the weight."""

    times: Floats
    q: Floats
    torso: Floats
    roll: Floats
    left: Floats


def _walk(nao: NaoModel) -> _Walk:
    """Return a straight walk of six steps between a second of standing before and after it."""
    times = _times(0.0, _STEPS * _STEP + 2.0 * _STILL, _SAMPLING)
    stand, feet, height = _standing(nao, len(times))
    left = np.full(len(times), 0.5)
    for step in range(_STEPS):
        begin, side = _STILL + _STEP * step, "RL"[step % 2]
        length = _STRIDE * (1.0 if step in (0, _STEPS - 1) else 2.0)
        phase = np.clip((times - begin) / _STEP * 2.0 - 0.5, 0.0, 1.0)  # of the foot, in the middle half of the step
        feet[side][:, 0] += length * _smooth(phase, 0.0, 1.0)
        feet[side][:, 2] += 0.02 * np.sin(np.pi * phase) ** 2
        left[(phase > 0.0) & (phase < 1.0)] = 0.97 if side == "R" else 0.03
    end = times[-1] - _STILL
    begins, ends = (_smooth(times, at - 0.5 * _STEP, at + 0.5 * _STEP) for at in (_STILL, end))
    sway = begins - ends
    sway *= np.sin(np.pi * (times - _STILL) / _STEP)
    torso = (feet["L"] + feet["R"]) / 2.0
    torso[:, 1] = 0.04 * sway
    torso[:, 2] = height
    q = stand.copy()
    for joint, swing in (("LShoulderPitch", 0.12), ("RShoulderPitch", -0.12), ("HeadYaw", 0.1)):
        q[:, nao.joint_names.index(joint)] += swing * sway
    return _Walk(times, _legs(nao, q, torso, 0.04 * sway, feet), torso, 0.04 * sway, left)


def _write_walk(nao: NaoModel, path: Path) -> None:
    walk = _walk(nao)
    _table(path, ("time", *nao.joint_names), (walk.times, walk.q))


def _write_log(nao: NaoModel, path: Path) -> None:
    """Write what the sensors of the walking robot would say, with their noise and the bias of a gyrometer."""
    walk, rng = _walk(nao), np.random.default_rng(0)
    n = len(walk.times)
    encoders = nao.to_body(walk.q)
    turning = [name for name in nao.body_order if not name.endswith("Hand")]
    encoders[:, [nao.body_order.index(name) for name in turning]] += rng.normal(0.0, 0.0017, (n, len(turning)))
    share = np.column_stack([walk.left, 1.0 - walk.left])
    forces = nao.mass * share * (1.0 + rng.normal(0.0, 0.03, (n, 2)))
    gyro = rng.normal((0.01, -0.02, 0.015), 0.01, (n, 3))
    gyro[:, 0] += np.gradient(walk.roll, walk.times)
    angles = rng.normal(0.0, 0.005, (n, 2))
    angles[:, 0] += walk.roll
    a = np.gradient(np.gradient(walk.torso, walk.times, axis=0), walk.times, axis=0)
    a[:, 2] += _GRAVITY
    cos, sin = np.cos(walk.roll), np.sin(walk.roll)
    accelerations = np.column_stack([a[:, 0], cos * a[:, 1] + sin * a[:, 2], cos * a[:, 2] - sin * a[:, 1]])
    accelerations += rng.normal(0.0, 0.2, (n, 3))
    sensors = "LFsr RFsr GyroX GyroY GyroZ AngleX AngleY AccX AccY AccZ".split()
    _table(
        path,
        ("time", *nao.body_order, *sensors),
        (walk.times, encoders, forces, gyro, angles, accelerations),
    )


# --- Motions.


def _write_wave(nao: NaoModel, path: Path) -> None:
    from nao_kin.motion import Motion, write_motion

    rise, swing = [0.0, 0.8, 3.2, 4.0], [0.0, 0.8, 1.2, 1.6, 2.0, 2.4, 2.8, 3.2, 4.0]
    keys = {
        "HeadYaw": (rise, [0.0, -0.3, -0.3, 0.0]),
        "RShoulderPitch": (rise, [1.4, -1.1, -1.1, 1.4]),
        "RShoulderRoll": (rise, [-0.2, -0.4, -0.4, -0.2]),
        "RElbowYaw": (rise, [1.2, 1.0, 1.0, 1.2]),
        "RElbowRoll": (swing, [0.5, 1.2, 0.4, 1.2, 0.4, 1.2, 0.4, 1.2, 0.5]),
        "RHand": (rise, [0.1, 1.0, 1.0, 0.1]),
    }
    times, values = zip(*keys.values(), strict=True)
    write_motion(Motion(times, list(keys), values, "smooth"), path, overwrite=True)


def _write_kick(nao: NaoModel, path: Path) -> None:
    """Write a kick with the right foot: lean to the left, lift the foot, swing it back and ahead, and put it down."""
    from nao_kin.motion import Motion, write_motion

    times = _times(0.0, 6.0, 0.05)
    stand, feet, height = _standing(nao, len(times))
    lean = _smooth(times, 0.2, 1.8) - _smooth(times, 4.2, 5.8)
    torso = np.outer(lean, [0.0, 0.045, 0.0]) + np.array([0.0, 0.0, height])
    feet["R"][:, 0] += 0.08 * (
        -0.4 * _smooth(times, 2.0, 2.6) + 1.4 * _smooth(times, 2.7, 3.1) - _smooth(times, 3.3, 3.9)
    )
    lift = _smooth(times, 1.8, 2.3) - _smooth(times, 3.6, 4.2)
    feet["R"] += np.outer(lift, [0.0, 0.01, 0.025])
    q = _legs(nao, stand, torso, np.zeros(len(times)), feet)
    write_motion(Motion(times, nao.joint_names, q.round(5)), path, overwrite=True)


def _write_person(nao: NaoModel, path: Path) -> None:
    from nao_kin.imitation import SAMPLES as people

    atomic.write_bytes(path, people[path.stem].read_bytes())


# --- A chessboard in front of a robot whose head and camera are off.

_COLUMNS, _ROWS, _SQUARE = 9, 6, 0.03  # inner corners, m
_PLACE = (0.6, 0.12, 0.24, -1.671, 0.0, -1.471)  # of the first corner in the torso
_OFFSETS: dict[str, Any] = {
    "joints": {"HeadYaw": np.radians(1.0), "HeadPitch": np.radians(-0.7)},
    "frames": {"CameraTop": (0.0, 0.0, 0.0, *np.radians((0.7, 1.7, -0.85)))},
}
_LOOKS = [(yaw, pitch) for pitch in (-0.15, 0.0, 0.15) for yaw in (-0.2, -0.07, 0.07, 0.2)]
_FINER = 3  # rays per pixel in each direction


def _looking(nao: NaoModel, resolution: str) -> tuple[Camera, Floats]:
    """Return the camera, and the poses of the board in it while the head moves, shape (n, 4, 4)."""
    from nao_kin.robot import pose_of
    from nao_kin.screws import inverse
    from nao_kin.world import camera

    true = nao.with_offsets(**_OFFSETS)
    yaw, pitch = np.transpose(_LOOKS)
    q = nao.posture("StandInit", HeadYaw=yaw, HeadPitch=pitch)
    T = inverse(true.fk(q, "CameraTop")) @ pose_of(_PLACE, "place")
    return camera(nao, "CameraTop", resolution), T


def _write_head(nao: NaoModel, path: Path) -> None:
    """Write the log of the head, which is still for 0.4 s around each photo."""
    times = _times(0.5, len(_LOOKS) + 0.5, 0.1)
    moments = 1.0 + np.arange(len(_LOOKS))
    held = np.column_stack([moments - 0.2, moments + 0.2]).ravel()
    values = [np.interp(times, held, np.repeat(angles, 2)) for angles in np.transpose(_LOOKS)]
    _table(path, ("time", "HeadYaw", "HeadPitch"), (times, *values))


def _write_photos(nao: NaoModel, path: Path) -> None:
    camera, poses = _looking(nao, "QVGA")
    photos = {f"top_{1.0 + k:.3f}.png": _photo(camera, T) for k, T in enumerate(poses)}
    atomic.write_folder(path, photos, overwrite=True)


def _photo(camera: Camera, T_camera_board: Floats) -> bytes:
    """Return the PNG file of the board on a white sheet: the mean of nine rays for each pixel."""
    from nao_kin.screws import inverse

    width, height = camera.width, camera.height
    v, u = np.mgrid[: _FINER * height, : _FINER * width] / _FINER - (_FINER - 1) / (2 * _FINER)
    T = inverse(T_camera_board)
    rays = camera.ray(np.stack([u, v], axis=-1)) @ T[:3, :3].T
    points = T[:2, 3] - rays[..., :2] * (T[2, 3] / rays[..., 2:])  # where they meet the plane of the board
    column, row = np.floor(points[..., 0] / _SQUARE), np.floor(points[..., 1] / _SQUARE)

    def inside(margin: int) -> Any:
        return (abs(column - _COLUMNS / 2 + 1) <= _COLUMNS / 2 + margin) & (
            abs(row - _ROWS / 2 + 1) <= _ROWS / 2 + margin
        )

    grey = np.where(inside(1), 235.0, 110.0)
    grey[inside(0) & ((column + row) % 2 == 0)] = 25.0
    image = grey.reshape(height, _FINER, width, _FINER).mean(axis=(1, 3)).round().astype(np.uint8)
    return atomic.png(image)


def _write_observations(nao: NaoModel, path: Path) -> None:
    """Write what the camera sees of the corners at their measured places, to half a pixel."""
    from nao_kin.robot import pose_of
    from nao_kin.screws import transform_point

    camera, poses = _looking(nao, "VGA")
    y, x = np.divmod(np.arange(_COLUMNS * _ROWS), _COLUMNS)
    corners = _SQUARE * np.column_stack([x, y, np.zeros_like(x)])
    pixels = camera.project(transform_point(poses[:, None], corners))
    pixels += np.random.default_rng(0).normal(0.0, 0.5, pixels.shape)
    seen = [
        {"joints": dict(zip(("HeadYaw", "HeadPitch"), look, strict=True)), "pixels": found.round(2).tolist()}
        for look, found in zip(_LOOKS, pixels, strict=True)
    ]
    points = transform_point(pose_of(_PLACE, "place"), corners).round(5).tolist()
    observed = {"type": "pixels", "camera": "CameraTop", "noise": 0.5, "points": points, "posture": "StandInit"}
    document = {
        "joints": ["HeadYaw", "HeadPitch"],
        "frames": {"CameraTop": ["roll", "pitch", "yaw"]},
        "observations": [observed | {"seen": seen}],
    }
    atomic.write_text(path, json.dumps(document) + "\n")


class _Sample(NamedTuple):
    purpose: str
    write: Callable[[NaoModel, Path], object]


SAMPLES = {
    "walk.csv": _Sample("log of a walk: times and the 25 joints", _write_walk),
    "log.csv": _Sample("log of the same walk by sensors: 26 joints, forces on the soles, inertial unit", _write_log),
    "wave.xar": _Sample("motion, a timeline of Choregraphe: the right arm waves", _write_wave),
    "kick.motion": _Sample("motion, a file of Webots: a kick with the right foot", _write_kick),
    "circles.bvh": _Sample("motion capture of a person, for imitate", _write_person),
    "observations.json": _Sample(
        "corners of a chessboard in pictures of a head camera, for calibrate", _write_observations
    ),
    "photos": _Sample("folder with photos of this chessboard, for calibrate", _write_photos),
    "head.csv": _Sample("log of the head's joints while these photos were taken", _write_head),
}
# What the command takes.
NAMES = (*SAMPLES, _ALL)
