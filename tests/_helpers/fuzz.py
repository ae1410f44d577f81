"""Call the library with one wrong argument or one damaged file: the interpreter must not crash or hang.

The right calls are those of the examples in docstrings, and those of `CALLS` and `COMMANDS`. A child process runs an
example up to the call of what it explains. There it makes the same call with other values instead, so that robots,
files and servers are as the example has made them. A call may answer or raise any exception; crashes and hangs are
reported, and commands that print a traceback or end with another exit code than 0, 1 or 2.

    python tests/_helpers/fuzz.py                                      # prints its seed
    python tests/_helpers/fuzz.py --seed 7 --only stream.read_log      # the same calls again, of one name
"""

from __future__ import annotations

import argparse
import ast
import doctest
import faulthandler
import functools
import importlib
import inspect
import json
import os
import random
import resource
import shutil
import sys
import tempfile
import traceback
import warnings
from collections.abc import Callable, Iterator
from contextlib import nullcontext, suppress
from decimal import Decimal
from pathlib import Path
from types import CodeType, FrameType, SimpleNamespace
from typing import Any, NamedTuple, TextIO

import bad_values
import meshcat
import numpy as np
from bad_values import DAMAGES, VALUES
from public_names import called

import nao_kin as nk

MOTIONS = Path(__file__).parents[1] / "data" / "motions"
SECONDS, MEMORY = 20, 4 << 30

# What is not called, and why.
LEFT_OUT = {
    "distributed.connect": "starts processes",
    "naoqi.JointSource.read": "is abstract",
    "naoqi.LolaSource.read": "needs a robot",
    "naoqi.NaoqiSource.read": "needs a robot",
    "naoqi.run_script": "what a wrong script prints is its own",
    "viewer.Viewer.save_png": "needs a browser",
    "viewer.Viewer.save_video": "needs a browser",
    "viewer.Viewer.wait": "waits as long as it is told",
}
# Calls that no example makes. The outermost is meant, of `NAO` and `POSES` that were seen.
CALLS = """
    nk.calibration.Calibration.save(nk.calibration.calibrate(NAO, POSES, joints=["LElbowYaw"]), "found.toml")
    nk.calibration.Contacts(np.zeros((1, 25)), "LFoot", "RFoot")
    nk.calibration.from_photos(NAO, "photos", "log.csv", board=(9, 6), square=0.03)
    nk.calibration.Pixels(np.zeros(25), "CameraTop", np.zeros((4, 2)), np.eye(4)[:, :3], "LArm", noise=0.5)
    nk.calibration.Poses(np.zeros((1, 25)), "LArm", np.eye(4)[None])
    nk.load_nao(offsets="offsets.toml")
    nk.ik.IKResult.describe(nk.ik.arm(NAO, "L", NAO.fk(np.zeros(25), "LArm")), ())
    nk.ik.TwistMap.idle_joints(nk.ik.velocity(NAO, np.zeros(25), np.zeros(6), "LArm").map, ())
    nk.ik.TwistMap.rank(nk.ik.velocity(NAO, np.zeros(25), np.zeros(6), "LArm").map)
    nk.screws.lines.PluckerLine((1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    next(nk.naoqi.readings(Still(), NAO, rate=1000.0, wanted=lambda: True))
    nk.naoqi.NaoqiSource("tcp://127.0.0.1:9")
    nk.naoqi.QiServer(nk.naoqi.VirtualNao(NAO, stepped=True))
    nk.reach.load("reach.npz")
    nk.reach.ReachMap.best_at(nk.reach.load("reach.npz"), np.zeros((2, 3)))
    nk.reach.ReachMap.save_ply(nk.reach.load("reach.npz"), "reach.ply", overwrite=True)
    nk.reach.ReachMap.save_vtk(nk.reach.load("reach.npz"), "reach.vtk", overwrite=True)
    nk.motion.MendedMotion.describe(nk.motion.clamp(NAO, nk.motion.read_motion("walk.csv")), degrees=True)
    nk.parameters.NaoParameters.frame(NAO.parameters, "LArm")
    nk.parameters.NaoParameters.joint(NAO.parameters, "HeadYaw")
    nk.robot.CollisionRule.of(True)
    nk.robot.Obstacle.mesh("mesh", "mesh.stl", np.eye(4))
    nk.robot.Obstacle.ball("ball", 0.1, np.eye(4))
    nk.robot.Obstacle.box("box", (0.1, 0.1, 0.1), np.eye(4))
    nk.rotations.RotationSpline([0.0, 1.0], [np.eye(3)] * 2).angular_acceleration(0.5, expressed_in="fixed")
    nk.rotations.RotationSpline([0.0, 1.0], [np.eye(3)] * 2).angular_velocity(0.5, expressed_in="fixed")
    nk.RobotModel(NAO.tree, NAO.semantics)
    nk.RobotModel.from_mjcf("nao_v6.xml")
    nk.RobotModel.from_urdf("nao.urdf", semantics="nao.toml")
    nk.semantics.CoupledLimit("HeadPitch", "HeadYaw", (0.0, 1.0), (-0.1, -0.2), (0.1, 0.2)).range(0.5)
    nk.semantics.Mimic("LHand", 0.5, 0.1)
    nk.semantics.Mimic("LHand", 0.5, 0.1).driver_range(0.0, 1.0)
    nk.semantics.Mimic("LHand", 0.5, 0.1).driver_value(0.5)
    nk.semantics.Mimic("LHand", 0.5, 0.1).inverted("RHand")
    nk.semantics.Mimic("LHand", 0.5, 0.1).range(0.0, 1.0)
    nk.semantics.Mimic("LHand", 0.5, 0.1).through(nk.semantics.Mimic("RHand"))
    nk.semantics.Mimic("LHand", 0.5, 0.1).value(0.5)
    nk.semantics.Posture({"HeadYaw": 0.1}, (0.0, 0.0, 1.0))
    nk.semantics.read_semantics("nao.toml")
    nk.semantics.Semantics({}, ("a",), ("b",), ("c",), {"d": nk.semantics.Posture({"e": 0.1})}, "d")
    nk.semantics.View((1.0, 0.0, 0.0), ("HeadYaw",))
    nk.stream.fk(NAO, "walk.csv", "fk.csv", frame=["LArm"])
    nk.stream.fk(NAO, "walk.npy", "fk.npy", frame=["LArm"])
    nk.stream.fk(NAO, "walk.parquet", "fk.parquet", frame=["LArm"])
    nk.stream.read_log(NAO, "walk.json")
    nk.stream.read_targets(NAO, "targets.json", "LArm")
    nk.imitation.Imitation.figure(nk.imitation.imitate(NAO, nk.imitation.read_skeleton("wave.bvh")), [0.0])
    nk.imitation.read_skeleton(nk.imitation.SAMPLES["bow"])
    nk.viewer.MeshcatRobot(NAO, Unconnected())
    nk.viewer.MeshcatRobot(NAO, Unconnected()).animate(np.zeros((2, 25)))
    nk.viewer.MeshcatRobot(NAO, Unconnected()).display(np.zeros(25))
    nk.viewer.MeshcatRobot(NAO, Unconnected()).show_frames(["LArm"])
"""
# Commands for files of `write_files`, of which one is damaged.
COMMANDS = """
    balance walk.csv
    calibrate observations.json -o out.toml
    camera CameraTop pixels.csv --posture StandInit
    check --urdf nao.urdf --samples 5
    collisions walk.csv --offsets offsets.toml
    export out.urdf --urdf nao.urdf
    export out.glb --urdf nao.urdf
    export out --format ros2 --urdf nao.urdf
    fk walk.csv -o poses.csv
    fk walk.npy --frame LArm -o poses.npy
    fk walk.parquet --frame LArm -o poses.parquet
    ik LArm targets.json
    imitate wave.bvh -o out.xar
    info --urdf nao.urdf
    info --urdf nao_v6.xml
    motion check walk.csv
    motion convert timelines.xar out.csv --timeline 1
    motion info library.xap --timeline 1
    odometry log.csv
    state log.csv
    view walk.csv --html out.html
"""


class Unconnected(meshcat.Visualizer):
    """A scene that nobody serves."""

    def __init__(self) -> None:
        self.window, self.path = SimpleNamespace(send=lambda command: None), meshcat.path.Path(("meshcat",))


class Still(nk.naoqi.JointSource):
    """A robot that stands still."""

    address = "still"

    def connect(self) -> None:
        pass

    def close(self) -> None:
        pass

    def read(self, robot: nk.RobotModel) -> tuple[Any, None]:
        return robot.neutral(), None


class Case(NamedTuple):
    """Examples that call a function."""

    function: Callable[..., Any]
    examples: list[str]
    names: dict[str, Any]


@functools.cache
def cases() -> dict[str, Case]:
    """Return all functions, classes and methods that examples call, and the calls and commands above."""
    finder, found = doctest.DocTestFinder(recurse=False), dict[str, Case]()
    for name, function in called():
        names = {**vars(sys.modules[function.__module__]), "nk": nk, "np": np}
        tests = finder.find(function, name, globs=names)
        examples = [one.source for test in tests for one in test.examples if doctest.SKIP not in one.options]
        raised = inspect.isclass(function) and issubclass(function, Exception)
        if code_of(function) and examples and not raised and name not in LEFT_OUT:
            found[name] = Case(function, examples, names)
    motions = [f"nk.motion.read_motion({path.name!r})" for path in sorted(MOTIONS.iterdir())]
    commands = [f"nk.cli.main({line.split()})" for line in COMMANDS.strip().splitlines()]
    nao = nk.load_nao()
    given = {"NAO": nao, "POSES": [nk.calibration.Poses(q := nao.random(1, 8), "LArm", nao.fk(q, "LArm"))]}
    for call in (*map(str.strip, CALLS.strip().splitlines()), *motions, *commands):
        names = {"nk": nk, "np": np, **given, "Unconnected": Unconnected, "Still": Still}
        made: Any = ast.parse(call, mode="eval").body
        made = made.args[0] if ast.unparse(made.func) == "next" else made
        function = eval(ast.unparse(made.func), names)
        found[call] = Case(getattr(function, "__func__", function), [call], names)
    return found


def code_of(function: Callable[..., Any]) -> CodeType | None:
    return getattr(function.__init__ if inspect.isclass(function) else function, "__code__", None)


def write_files(folder: Path) -> None:
    """Write the files that the calls and commands read."""
    nao, rng = nk.load_nao(), np.random.default_rng(0)
    shutil.copytree(MOTIONS, folder, dirs_exist_ok=True)
    shutil.copy(nk.imitation.SAMPLES["wave"], folder)
    nk.export.urdf(nao, folder / "nao.urdf")
    nk.export.mjcf(nao, folder / "mjcf")
    shutil.copytree(folder / "mjcf", folder, dirs_exist_ok=True)
    (folder / "nao.toml").write_text('soles = ["LFoot"]\n[postures.up]\nangles = { HeadYaw = 0.4 }\nup = [0, 0, 1]\n')
    (folder / "offsets.toml").write_text("[joints]\nHeadYaw = 0.01\n")
    motion = nk.Motion([0.0, 1.0, 2.0], nao.joint_names, nao.random(rng, 3))
    nk.motion.write_motion(motion, folder / "walk.csv")
    (folder / "walk.json").write_text(json.dumps([nao.angles(q) for q in nao.random(rng, 3)]))
    (folder / "log.csv").write_text(
        f"time,{','.join(nao.joint_names)},LFsr,RFsr,GyroX,GyroY,GyroZ\n"
        + "".join(f"{k / 10},{','.join(map(str, nao.posture('Stand')))},20,30,0,0,0\n" for k in range(3))
    )
    corners = "".join(f"vertex {corner}\n" for corner in ("0 0 0", "1 0 0", "0 1 0"))
    (folder / "mesh.stl").write_text(f"solid\nfacet normal 0 0 1\nouter loop\n{corners}endloop\nendfacet\nendsolid\n")
    (folder / "pixels.csv").write_text("u,v\n320,240\n100,200\n")
    (folder / "targets.json").write_text(json.dumps([[0.15, 0.12, 0.05], [0.1, 0.1, 0.1]]))
    seen = [{"joints": {"HeadYaw": 0.3}, "pose": [0.0, 0.0, 0.1265, 0.0, 0.0, 0.31]}]
    observations = {"joints": ["HeadYaw"], "observations": [{"type": "poses", "frame": "Head", "seen": seen}]}
    (folder / "observations.json").write_text(json.dumps(observations))
    np.save(folder / "walk.npy", nao.random(rng, 3))
    nk.reach.workspace(nao, "LArm", 500, voxel=0.05).save(folder / "reach.npz")
    with suppress(ImportError):
        from pyarrow import parquet, table

        columns = dict(zip(nao.joint_names, nao.random(rng, 3).T, strict=True))
        parquet.write_table(table(columns), folder / "walk.parquet")


# --- Wrong calls.


def wrong_calls(given: dict[str, Any], rng: random.Random, count: int) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield descriptions of wrong calls, and their arguments."""
    choices = []
    for name in given.keys() - {"self", "cls"}:
        for label, value, put in places(given[name]):
            choices += [(name, label, value, put, text) for text in VALUES]
            if isinstance(value, (str, Path)) and len(str(value)) < 200 and os.path.isfile(value):
                choices += [(name, label, value, put, damage) for damage in DAMAGES] * 15
    choices.sort(key=lambda choice: (choice[0], choice[1], choice[4]))
    for name, label, value, put, text in rng.sample(choices, min(count, len(choices))):
        try:
            wrong = put(damaged(Path(value), text, rng) if text in DAMAGES else evaluated(text, value))
        except Exception:  # a change that has no meaning for this value, or a key that is none
            continue
        yield f"{name}{label} = {text}", given | {name: wrong}


def places(value: Any) -> Iterator[tuple[str, Any, Callable[[Any], Any]]]:
    """Yield what of an argument is exchanged, and a function that returns the argument with another value there.

    That is the whole, all texts of a list and its first entry, and a dictionary's first value, last value and key.
    """
    yield "", value, lambda wrong: wrong
    if isinstance(value, (list, tuple)):
        for k, one in [(k, one) for k, one in enumerate(value) if k == 0 or isinstance(one, str)][:10]:
            yield f"[{k}]", one, lambda wrong, k=k: plain(value)([*value[:k], wrong, *value[k + 1 :]])
    elif isinstance(value, dict) and value:
        *others, (last, one) = value.items()
        for key, old in [*others[:1], (last, one)]:
            yield f"[{key!r}]", old, lambda wrong, key=key: {**value, key: wrong}
        yield f" key {last!r}", last, lambda wrong: {**dict(others), wrong: one}


def plain(value: Any) -> type[Any]:
    return tuple if isinstance(value, tuple) else list


def evaluated(text: str, given: Any) -> Any:
    with np.errstate(all="ignore"):
        return eval(text, {**vars(bad_values), "Decimal": Decimal, "Path": Path, "given": given})


def damaged(path: Path, damage: str, rng: random.Random) -> str:
    name = f"bad_{path.name}"
    Path(name).write_bytes(DAMAGES[damage](path.read_bytes(), rng))
    return name


# --- What they end with.


def complaint(case: Case, given: dict[str, Any], printed: TextIO) -> str:
    """Make a call, and return what is wrong with its end; an empty text if nothing is."""
    start, signature = printed.seek(0, os.SEEK_END), inspect.signature(case.function)
    several = [name for name, one in signature.parameters.items() if one.kind is one.VAR_POSITIONAL]
    given |= {name: (given[name],) for name in several if not isinstance(given[name], tuple)}
    call = inspect.BoundArguments(signature, given)  # type: ignore[arg-type]
    try:
        result = case.function(*call.args, **call.kwargs)
        if inspect.isgenerator(result):
            next(result, None)
        with result if hasattr(result, "__exit__") else nullcontext():  # it starts, and ends
            pass
    except SystemExit as error:
        if case.function is not nk.cli.main or error.code not in (0, 1, 2):
            return f"exit code {error.code}"
    except nk.NaoKinError:  # also of a command line that is no list of texts
        pass
    except Exception as error:
        if case.function is nk.cli.main:
            return f"{type(error).__name__}: {str(error)[:300]!r}"
    sys.stderr.flush()
    printed.seek(start)
    return "a traceback on standard error" if "Traceback" in printed.read() else ""


def child(case: Case, rng: random.Random, count: int, skip: int, report: Path) -> None:
    """Run examples up to the call; then make wrong ones, and write each and what is wrong with its end."""
    written = report.open("a", encoding="utf-8", errors="backslashreplace")
    printed = open("printed", "w+", encoding="utf-8", errors="replace")  # noqa: SIM115
    os.dup2(os.open(os.devnull, os.O_RDWR), 0)
    os.dup2(os.open(os.devnull, os.O_RDWR), 1)
    os.dup2(printed.fileno(), 2)
    faulthandler.enable()
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + MEMORY, used + MEMORY))
    warnings.simplefilter("ignore")

    code = code_of(case.function)

    def reached(frame: FrameType, event: str, _: Any) -> None:
        if event != "call" or frame.f_code is not code or frame.f_back.f_code.co_filename != "<example>":
            return
        sys.setprofile(None)
        report.with_name("reached").touch()
        # Not the arguments of what decorates a function, for they have other names.
        kinds = inspect.signature(case.function).parameters.items()
        names = [name for name, one in kinds if name in frame.f_locals and one.kind is not one.VAR_KEYWORD]
        given = {name: frame.f_locals[name] for name in names}
        for k, (text, wrong) in enumerate(wrong_calls(given, rng, count)):
            if k < skip:
                continue
            print(text, file=written, flush=True, end="\t")
            faulthandler.dump_traceback_later(SECONDS, exit=True)
            said = complaint(case, wrong, printed)
            faulthandler.cancel_dump_traceback_later()
            print(said, file=written, flush=True)
        os._exit(0)

    sys.setprofile(reached)
    for example in case.examples:
        with suppress(Exception, SystemExit):
            exec(compile(example, "<example>", "single"), case.names)


def fuzz(name: str, case: Case, seed: int, count: int, files: Path) -> tuple[int, list[str]]:
    """Return the number of wrong calls made, and a line for each that ended wrongly."""
    with tempfile.TemporaryDirectory() as folder:
        report, ended, done = Path(folder, "report"), False, 0
        report.touch()
        while not ended:  # once more after a call that ended the process
            work = Path(folder, str(done))
            shutil.copytree(files, work)
            process = os.fork()
            if not process:
                try:
                    os.chdir(work)
                    child(case, random.Random(f"{seed} {name}"), count, done, report)
                    os._exit(0)
                except BaseException:
                    traceback.print_exc()
                    os._exit(70)
            status = os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])
            ended = status == 0 or len(report.read_text().splitlines()) == done
            if not ended:
                with report.open("a") as written:
                    tail = (work / "printed").read_text(errors="replace")[-1000:]
                    print(f"ended the process with {status}: {' '.join(tail.split())}", file=written)
            done = len(report.read_text().splitlines())
        lines = [line.split("\t", 1) for line in report.read_text().splitlines()]
        # A class that no example makes is the result of a function.
        if not Path(folder, "reached").exists() and (name == case.examples[0] or not inspect.isclass(case.function)):
            lines.append(["no call", "no example and no line of CALLS gets as far as calling it"])
    return done, [f"{name}: {text}: {said}" for text, said in lines if said]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=random.SystemRandom().randrange(10**6))
    parser.add_argument("--calls", type=int, default=25, help="wrong calls of each name")
    parser.add_argument("--names", type=int, help="how many names; all by default")
    parser.add_argument("--only", default="", help="the beginning of names")
    options = parser.parse_args()
    print(f"--seed {options.seed} --calls {options.calls}", flush=True)
    # What takes a while is loaded once, and not in each child.
    nk.warm_up()
    importlib.import_module("dask.array")
    nk.Viewer(nk.load_nao()).close()
    known = {name: case for name, case in cases().items() if name.startswith(options.only)}
    chosen = random.Random(options.seed).sample(sorted(known), options.names or len(known))
    total, wrong = 0, list[str]()
    with tempfile.TemporaryDirectory() as files:
        write_files(Path(files))
        for name in chosen:
            count, found = fuzz(name, known[name], options.seed, options.calls, Path(files))
            total, wrong = total + count, wrong + found
            print(*found, sep="\n", end="\n" if found else "", flush=True)
    print(f"{total} wrong calls of {len(chosen)} names; {len(wrong)} ended wrongly")
    return 1 if wrong or not total else 0


if __name__ == "__main__":
    sys.exit(main())
