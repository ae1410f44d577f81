"""Write the library's results into a folder, or compare two such folders: a refactoring must not change the results.

    python scripts/golden_answers.py write before
    python scripts/golden_answers.py write after
    python scripts/golden_answers.py compare before after --tolerance 1e-12

Poses, Jacobians and centres of mass of all versions of the NAO and of three other robots; inverse kinematics with its
reasons; the bytes of every export and of every motion format; the output of the commands, with their help.
Arrays are compared with a tolerance (0: bit by bit), everything else exactly.
"""

from __future__ import annotations

import argparse
import os
import shlex
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import nao_kin as nk

ROOT = Path(nk.__file__).resolve().parents[1]
VERSIONS = ("v3.2", "v3.3", "v4", "v5", "v6")
OTHERS = ("romeo", "tiago", "ur10_robot")
TARGETS = 200
PARTS = ("kinematics", "inverse", "exports", "motions", "commands")
Arrays = dict[str, NDArray[Any]]

_COMMANDS = (
    *("info --json", "info --version v4", "joints --json", "joints --typed --deg", "check --samples 20 --json"),
    *("fk --posture StandInit --json", "fk --posture Sit --deg", "fk walk.csv --csv", "fk walk.json --json"),
    *("fk wave.xar --rate 10 --frame LHand --csv", "fk walk.csv --as quaternion --frame LArm --json", "ik --json"),
    *(
        "ik LArm --target 0.18 0.1 0.25 --json",
        "ik LLeg --target 0 0.05 -0.3 --json",
        "reach LArm --samples 1e4 --json",
    ),
    *("motion check wave.xar --json", "motion info wave.xar --json", "export - --format urdf"),
)
_HELP = ("", *"info joints fk ik check reach view export serve run live warmup doctor motion".split())


def kinematics() -> Iterator[tuple[str, Arrays | str]]:
    """Return poses, Jacobians, centres of mass and limits."""
    for robot in _robots():
        q = robot.random(1, TARGETS)
        frames = [robot.frame_names[index] for index in (1, len(robot.frame_names) // 2, -1)]
        answers = {
            "q": q,
            "fk": robot.fk(q),
            "one": robot.fk(q[0]),
            "com": robot.com(q),
            "clamped": robot.clamp(2.0 * q),
        }
        for frame in frames:
            answers[f"fk {frame}"] = robot.fk(q, frame, reference=frames[0])
            for expressed_in in ("frame", "root", "mixed"):
                answers[f"jacobian {frame} {expressed_in}"] = robot.jacobian(q, frame, expressed_in=expressed_in)
            answers[f"single {frame}"] = robot.jacobian(q[0], frame)
        answers |= {
            "clamped": robot.clamp(2.0 * q),
            "lower": robot.lower,
            "upper": robot.upper,
            "speeds": robot.velocity_limits,
        }
        yield f"kinematics/{robot.name}.npz", {name: np.asarray(value) for name, value in answers.items()}
        yield f"kinematics/{robot.name}.txt", "\n".join([*robot.joint_names, *robot.frame_names, *robot.load_notes])


def inverse() -> Iterator[tuple[str, Arrays | str]]:
    """Return all solutions, the nearest pose if there is none, and the reports."""
    rng = np.random.default_rng(7)
    for version in VERSIONS:
        nao = nk.load_nao(version)
        q = nao.random(2, TARGETS)
        near = nao.clamp(q + rng.normal(0.0, 0.3, q.shape))
        moved = np.eye(4) + np.zeros((TARGETS, 1, 1))
        moved[::4, :3, 3] = rng.normal(0.0, 0.03, moved[::4, :3, 3].shape)
        feet, hands, head = (nao.fk(q, frame) @ moved for frame in ("LLeg", "RArm", "Head"))
        points = hands[:, :3, 3]
        found: dict[str, Any] = {
            "leg": nk.ik.leg(nao, "L", feet, near=near),
            "leg ignore": nk.ik.leg(nao, "L", feet, near=near, limits="ignore"),
            "arm": nk.ik.arm(nao, "R", hands, near=near),
            "arm place": nk.ik.arm(nao, "R", points, near=near),
            "arm direction": nk.ik.arm(nao, "R", points, direction=hands[:, :3, 0], near=near),
            "head": nk.ik.head(nao, head[:, :3, :3], near=near),
            "gaze": nk.ik.look_at(nao, points, near=near),
            "legs": nk.ik.legs(nao, feet, nao.fk(q, "RLeg"), near=near),
            "numeric": nk.ik.numeric(nao, "LArm", nao.fk(q, "LArm")[:20], near=near[:20], restarts=3),
        }
        if version in ("v4", "v6"):
            targets = {"LArm": nao.fk(q, "LArm", reference="LLeg")[:6]}
            feet_held = {"L": np.eye(4), "R": nao.fk(nao.posture("StandInit"), "RLeg", reference="LLeg")}
            found["whole body"] = nk.ik.whole_body(nao, targets, feet=feet_held, com="support", restarts=2)
        for name, result in found.items():
            arrays = {key: value for key, value in vars(result).items() if isinstance(value, np.ndarray)}
            plain = {key: value for key, value in arrays.items() if value.dtype.kind in "fiub"}
            yield f"inverse/{nao.name}/{name}.npz", plain
            words = {key: repr(value.tolist()) for key, value in arrays.items() if value.dtype.kind not in "fiub"}
            yield f"inverse/{nao.name}/{name}.txt", "\n".join([str(result), *(f"{k}: {v}" for k, v in words.items())])


def exports() -> Iterator[tuple[str, Arrays | str]]:
    """Return every format of every version, each in a folder."""
    for version in VERSIONS:
        for format in nk.export.FORMATS:
            for typed in (False, True):
                if typed and "typed" not in nk.export.options(format):
                    continue
                path = Path("exports", f"{version}{' typed' if typed else ''}", format, _name(format))
                path.parent.mkdir(parents=True)
                chosen: dict[str, Any] = {"typed": True} if typed else {}
                written = nk.export.write(nk.load_nao(version), path, format, **chosen)
                yield f"{path.parent}/said.txt", "\n".join(written.changes)


def motions() -> Iterator[tuple[str, Arrays | str]]:
    """Return one motion written in every format, and read back."""
    wave = _wave()
    Path("motions").mkdir()
    for name, format in nk.motion.FORMATS.items():
        if format.write is not None:
            for rate in (None, 20.0):
                path = Path("motions", f"wave {rate} {name}{format.suffixes[0]}")
                try:
                    nk.motion.write_motion(wave, path, format=name, rate=rate)
                    again = nk.motion.read_motion(path, format=name)
                    yield f"{path}.read.txt", repr((again.joint_names, again.times, again.keys, again.interpolation))
                except nk.NaoKinError as error:
                    yield f"{path}.txt", str(error)


def commands() -> Iterator[tuple[str, Arrays | str]]:
    """Return the output and the exit code of every command."""
    nao = nk.load_nao()
    rows = nao.random(0, 3)
    Path("walk.csv").write_text(
        "\n".join([",".join(nao.joint_names), *(",".join(map(str, row)) for row in rows)]), encoding="utf-8"
    )
    Path("walk.json").write_text(f"[{', '.join(str(nao.angles(row)) for row in rows)}]".replace("'", '"'))
    nk.motion.write_motion(_wave(), "wave.xar")
    environment = {**os.environ, "COLUMNS": "120", "PYTHONPATH": str(ROOT)}
    for line in (*_COMMANDS, *(f"{name} --help".strip() for name in _HELP)):
        run = subprocess.run(
            [sys.executable, "-m", "nao_kin", *shlex.split(line)],
            capture_output=True,
            text=True,
            env=environment,
            check=False,
        )
        text = f"{run.returncode}\n{run.stdout}\n{run.stderr}".replace(str(ROOT), "@")
        yield f"commands/{line.replace('/', '_')}.txt", text


def _robots() -> Iterator[nk.RobotModel]:
    for version in VERSIONS:
        yield nk.load_nao(version)
    for name in OTHERS:
        yield nk.load_robot(name)


def _wave() -> nk.Motion:
    times = [[0.0, 1.0, 2.0], [0.5, 1.5]]
    return nk.Motion(times, ["LShoulderRoll", "LHand"], [[0.2, 1.0, 0.2], [0.0, 1.0]], "smooth")


def _name(format: str) -> str:
    return {"ros2": "package", "gltf": "nao.glb", "mjcf": "nao.xml"}.get(format, f"nao.{format}")


def write(folder: Path, parts: list[str]) -> None:
    """Write all results into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    os.chdir(folder)
    for part in parts:
        for name, answer in globals()[part]():
            path = Path(name)
            path.parent.mkdir(parents=True, exist_ok=True)
            if isinstance(answer, str):
                path.write_text(answer, encoding="utf-8")
            else:
                np.savez(path, **answer)
        print(part)


def compare(before: Path, after: Path, tolerance: float) -> int:
    """Print the differences; return 1 if there are any."""
    files = [{p.relative_to(root) for p in root.rglob("*") if p.is_file()} for root in (before, after)]
    said = [f"only in one: {name}" for name in sorted(files[0] ^ files[1])]
    largest = 0.0
    for name in sorted(files[0] & files[1]):
        if (before / name).read_bytes() == (after / name).read_bytes():
            continue
        if name.suffix != ".npz" or name.parts[0] == "motions":
            said.append(f"{name} differs")
            continue
        one, other = np.load(before / name), np.load(after / name)
        if sorted(one.files) != sorted(other.files):
            said.append(f"{name}: {sorted(set(one.files) ^ set(other.files))} in one only")
        for key in set(one.files) & set(other.files):
            a, b = one[key], other[key]
            if a.shape != b.shape or (a.dtype.kind != "f" and (a != b).any()) or (np.isnan(a) != np.isnan(b)).any():
                said.append(f"{name}: {key} differs")
            elif a.dtype.kind == "f" and a.size:
                off = float(np.nanmax(np.where(a == b, 0.0, np.abs(a - b)), initial=0.0))
                largest = max(largest, off)
                if off > tolerance:
                    said.append(f"{name}: {key} differs by {off:.3g}")
    print("\n".join(said) or "equal", f"\nlargest difference within the tolerance or above it: {largest:.3g}")
    return 1 if said else 0


def main() -> None:
    """Write or compare."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    actions = parser.add_subparsers(dest="action", required=True)
    writing = actions.add_parser("write")
    writing.add_argument("folder", type=Path)
    writing.add_argument("--parts", nargs="+", choices=PARTS, default=list(PARTS))
    comparing = actions.add_parser("compare")
    comparing.add_argument("before", type=Path)
    comparing.add_argument("after", type=Path)
    comparing.add_argument("--tolerance", type=float, default=0.0)
    given = parser.parse_args()
    if given.action == "write":
        write(given.folder, given.parts)
    else:
        sys.exit(compare(given.before, given.after, given.tolerance))


if __name__ == "__main__":
    main()
