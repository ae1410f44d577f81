"""Simulate logs of a NAO in MuJoCo, and print how right `nk.world` is about them, as tables in Markdown.

For every σ of `state`, `odometry` and `ground_covariance` the table has the root mean square of error / σ, with and
without systematic errors; 1 is right. The second table has what the robot does, and what `state` says it does.

Example:
    python scripts/simulate_logs.py --scenes 210             # some minutes; the tables of docs/real_data.md
    python scripts/simulate_logs.py --scenes 14 --write logs  # one of each kind, also as logs/*.npz
    python scripts/simulate_logs.py --life scripts/explanations/robot_state.npz  # the log of a figure
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import nao_kin as nk

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "_helpers"))

import simulated_robot as simulated  # type: ignore[import-not-found]  # the simulation of the tests

Floats = NDArray[np.float64]

# Errors that are switched on: arguments of `simulated_robot.recorded`.
NONE: dict[str, Any] = {"backlash": 0.0, "acceleration_bias": 0.0, "gyro_bias": 0.0}
ERRORS: dict[str, dict[str, Any]] = {
    "noise alone": NONE,
    "backlash 0.5°": NONE | {"backlash": 0.5},
    "gyrometer 1°/s": NONE | {"gyro_bias": 1.0},
    "accelerometer 0.2 m/s²": NONE | {"acceleration_bias": 0.2},
    "zeros of the legs 1°": NONE | {"zeros": 1.0},
    "24 ms late": NONE | {"delay": 0.024},
    "all of these": {"zeros": 1.0, "delay": 0.024},
}
# Sensors that `state` has besides the joints, and the errors with which they are compared; `StateEstimator` has them
# row by row.
LIVE = "row by row: accelerometer, gyrometer, forces"
SENSORS = {
    "accelerometer, gyrometer, forces": (("accelerometer", "gyro", "forces"), tuple(ERRORS)),
    "AngleX, AngleY, forces": (("angles", "forces"), ("noise alone", "all of these")),
    "forces": (("forces",), ("noise alone", "all of these")),
    LIVE: (("accelerometer", "gyro", "forces"), ("noise alone", "all of these")),
}
NUMBERS = ("roll", "pitch", "height", "x", "y", "heading", "ball ahead", "ball aside")
DOES = ("standing", "walking", "sitting", "carried", "falling", "lying")
SAID = ("standing", "walking", "sitting", "lifted", "carried", "falling", "lying", "unknown")
# σ below these do not count as smaller [rad, m]: nobody needs them, and simulation and model differ by as much.
LEAST_ANGLE, LEAST_LENGTH = np.radians(0.05), 0.0005
# Rows in which the pose is compared [s], and time about a change of what it does in which either is right [s].
EVERY, EITHER = 0.25, 0.25


def measured(
    scene: int, seed: int, folder: Path | None
) -> tuple[dict[tuple[str, str, str], list[float]], Counter[Any]]:
    """Return error / σ by errors, sensors and number, and a count of (does, said), of one scene."""
    nao = nk.load_nao()
    kind, truth = simulated.scene(nao, scene, seed)
    z: dict[tuple[str, str, str], list[float]] = {}
    said: Counter[Any] = Counter()
    for name, errors in ERRORS.items():
        # Rows every 10 ms in every third scene; with all errors on, every third log has offsets of the force sensors.
        every = 0.010 if scene % 3 == 1 else 0.012
        more = {"offset": 0.1} if name == "all of these" and scene % 3 == 2 else {}
        log = simulated.recorded(nao, truth, np.random.default_rng([seed, scene]), every=every, **errors, **more)
        for sensors, (names, compared) in SENSORS.items():
            if name not in compared:
                continue
            given = {part: getattr(log, part) for part in names}
            found = (_live if sensors == LIVE else nk.world.state)(nao, log.q, times=log.times, **given)
            for number, values in _normalised(nao, found, log, np.random.default_rng([seed, scene])).items():
                z.setdefault((name, sensors, number), []).extend(values)
            if name == "all of these":
                said.update((sensors, *pair) for pair in _pairs(found, log.truth))
        if folder is not None and name == "all of these":
            _save(folder / f"{scene:03d}_{kind.replace(' ', '_')}.npz", log)
    return z, said


def _live(nao: nk.NaoModel, q: Floats, *, times: Floats, **given: Floats) -> nk.world.State:
    """Return the states of `StateEstimator` as those of a log."""
    estimator = nk.world.StateEstimator(nao)
    rows = [
        estimator.update(q[k], time, **{name: values[k] for name, values in given.items()})
        for k, time in enumerate(times)
    ]
    found: nk.world.State = _joined(rows)
    return replace(found, odometry=_joined([row.odometry for row in rows]))


def _joined(rows: list[Any]) -> Any:
    """Return rows of states as one, with all of their rows."""
    arrays = [name for name, value in vars(rows[-1]).items() if isinstance(value, np.ndarray)]
    return replace(rows[-1], **{name: np.concatenate([getattr(row, name) for row in rows]) for name in arrays})


def _save(path: Path, log: Any) -> None:
    """Write a log and its truth; joints as steps of their encoders, 4096 in a turn."""
    sensors: dict[str, Any] = {
        name: np.float16(getattr(log, name)) for name in ("forces", "accelerometer", "gyro", "angles")
    }
    steps = np.round(log.q * 4096.0 / (2.0 * np.pi)).astype(np.int16)
    truth = {
        "T_world_base": np.float32(log.truth.T.round(4)),
        "loads": np.float16(log.truth.loads),
        "doing": log.truth.doing,
    }
    np.savez_compressed(path, times=log.times.round(3), steps=steps, **sensors, **truth)


def _normalised(nao: nk.NaoModel, found: nk.world.State, log: Any, rng: np.random.Generator) -> dict[str, list[float]]:
    """Return error / σ of all numbers, in some rows in which it stands or walks, and at the ends of its path."""
    truth, path = log.truth, found.odometry
    does, clear = _does(truth)
    upright = clear & np.isin(does, ("standing", "walking"))
    near = round(EVERY / float(np.median(np.diff(log.times))))
    rows = np.flatnonzero(found.valid & upright)[::near]
    pose = np.column_stack([truth.roll_pitch, truth.T[:, 2, 3]])
    away = np.column_stack([found.roll_pitch, found.T_world_base[:, 2, 3]]) - pose
    least = [LEAST_ANGLE, LEAST_ANGLE, LEAST_LENGTH]
    z = dict(zip(NUMBERS, (away / np.fmax(_deviations(found.covariance), least))[rows].T.tolist(), strict=False))
    ends: list[Floats] = []
    for segment in range(path.segments):
        own = np.flatnonzero((path.segment == segment) & upright)
        if len(own) and log.times[own[-1]] - log.times[own[0]] > 1.0:
            error = _moved(path.pose[own]) - _moved(np.column_stack([truth.T[:, :2, 3], truth.heading])[own])
            c, s = np.cos(path.pose[own[0], 2]), np.sin(path.pose[own[0], 2])
            R = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
            covariance = R @ (path.covariance[own[-1]] - path.covariance[own[0]]) @ R.T
            ends.append(error / np.fmax(_deviations(covariance), [LEAST_LENGTH, LEAST_LENGTH, LEAST_ANGLE]))
    z |= dict(zip(NUMBERS[3:6], np.array(ends).reshape(-1, 3).T.tolist(), strict=True))
    return z | dict(zip(NUMBERS[6:], _balls(nao, found, log, rows, rng).T.tolist(), strict=True))


def _deviations(covariance: Floats) -> Floats:
    return np.asarray(np.sqrt(np.maximum(np.diagonal(covariance, axis1=-2, axis2=-1), 0.0)))


def _moved(pose: Floats) -> Floats:
    """Return the last of the poses (n, 3) on the floor, seen from the first one."""
    x, y, turn = pose[-1] - pose[0]
    c, s = np.cos(pose[0, 2]), np.sin(pose[0, 2])
    return np.array([c * x + s * y, c * y - s * x, turn])


def _balls(
    nao: nk.NaoModel, found: nk.world.State, log: Any, rows: NDArray[np.intp], rng: np.random.Generator
) -> Floats:
    """Return error / σ of balls on the floor at 0.5 to 2.5 m, ahead and aside of the robot, shape (n, 2)."""
    top, radius, results = nk.world.camera(nao, "CameraTop"), nk.world.SPL.ball_radius, [np.empty((0, 2))]
    for row in rows[::4]:
        T = log.truth.T[row]
        heading = float(np.arctan2(T[1, 0], T[0, 0]))
        at = nk.rotations.rot_z(heading)[:2, :2] @ (rng.uniform(0.5, 2.5) * np.array([1.0, rng.uniform(-0.4, 0.4)]))
        ball = np.array([*(T[:2, 3] + at), radius])
        T_world_camera = nk.world.camera_pose(nao, log.truth.q[row], top, T_world_base=T)
        pixel = top.project(nk.screws.transform_point(nk.screws.inverse(T_world_camera), ball)) + rng.normal(
            0.0, 0.5, 2
        )
        if not top.sees(pixel):
            continue
        T_found = found.T_world_base[row]
        place = {"T_world_base": T_found, "height": radius}
        seen = nk.world.pixel_to_ground(nao, log.q[row], pixel[None], top, **place)
        noise = {"joint_noise": np.radians(0.15), "pixel_noise": 0.5, "base_noise": _deviations(found.covariance[row])}
        covariance = nk.world.ground_covariance(nao, log.q[row], pixel[None], top, **place, **noise)
        turns = (nk.rotations.rot_z(angle)[:2, :2].T for angle in (found.odometry.pose[row, 2], heading))
        R, R_true = turns
        error = R @ (seen.points[0, :2] - T_found[:2, 3]) - R_true @ at
        results.append(error[None] / _deviations(R @ covariance[0] @ R.T))
    return np.concatenate(results)


def _does(truth: Any) -> tuple[NDArray[Any], NDArray[np.bool_]]:
    """Return what the robot does, and in which rows this is clear: not within 0.25 s of a change."""
    does = np.where(np.isin(truth.doing, simulated.LYING), "lying", truth.doing)
    changes = truth.times[1:][does[1:] != does[:-1]]
    near = np.abs(truth.times[:, None] - changes).min(axis=1, initial=np.inf) <= EITHER
    # A fall is brief: all of its rows count.
    return does, np.asarray((does != "") & (~near | (does == "falling")))


def _pairs(found: nk.world.State, truth: Any) -> list[tuple[str, str]]:
    """Return what the robot does and what `state` says, in clear rows."""
    does, clear = _does(truth)
    return list(zip(does[clear].tolist(), found.doing[clear].tolist(), strict=True))


def _table(head: list[str], rows: list[list[str]]) -> str:
    lines = [head, ["---", *["---:"] * (len(head) - 1)], *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=int, default=210)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--write", type=Path, metavar="FOLDER", help="also write the logs, with all errors, as npz")
    parser.add_argument("--life", type=Path, metavar="FILE", help="only write a log of 31 s, that of docs/real_data.md")
    given = parser.parse_args()
    if given.life is not None:
        nao = nk.load_nao()
        _save(given.life, simulated.recorded(nao, simulated.life(nao), np.random.default_rng(0), delay=0.012))
        return
    if given.write is not None:
        given.write.mkdir(parents=True, exist_ok=True)
    z: dict[tuple[str, str, str], list[float]] = {}
    said: Counter[Any] = Counter()
    with ProcessPoolExecutor() as pool:
        work: Callable[[int], Any] = partial(measured, seed=given.seed, folder=given.write)
        for part, pairs in pool.map(work, range(given.scenes)):
            for key, values in part.items():
                z.setdefault(key, []).extend(values)
            said.update(pairs)
    print(f"Root mean square of error / σ, {given.scenes} scenes:\n")
    rows = []
    for sensors, (_, compared) in SENSORS.items():
        for errors in compared:
            values = [np.array(z.get((errors, sensors, number), [])) for number in NUMBERS]
            shown = (f"{np.sqrt(np.nanmean(v**2)):.2f}" if len(v) else "–" for v in values)
            rows.append([sensors if errors == compared[0] else "", errors, *shown])
    print(_table(["sensors", "errors", *NUMBERS], rows))
    for sensors in SENSORS:
        print(f"What it does, and what `state` says, % of rows; all errors; {sensors}:\n")
        rows = []
        for does in DOES:
            counts = [said[sensors, does, word] for word in SAID]
            shares = [f"{100.0 * count / max(sum(counts), 1):.1f}" for count in counts]
            rows.append([f"{does} ({sum(counts)})", *shares])
        print(_table(["does", *SAID], rows))


if __name__ == "__main__":
    main()
