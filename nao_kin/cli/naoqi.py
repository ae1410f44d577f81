"""`nao-kin serve`, `run` and `live`: a virtual NAO, scripts for NAOqi, and the joints of a running robot."""

from __future__ import annotations

import math
import shutil
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass
from functools import cache, partial
from json import dumps
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np
import typer

from nao_kin._core import files as atomic
from nao_kin._core.arrays import Floats, whole_number
from nao_kin._core.process import before_ending, uninterrupted, wait_for_signal
from nao_kin.cli import options as shared
from nao_kin.cli.options import OTHER_ROBOTS, OutputOptions, RobotOptions, argument, command, flag, option
from nao_kin.cli.output import print_json, print_note
from nao_kin.cli.sources import check_motion_file, posture_or_number
from nao_kin.cli.view import ExtraPage, LivePage
from nao_kin.errors import BadArgument

if TYPE_CHECKING:
    from nao_kin import world
    from nao_kin.naoqi import Event, JointReading, State, VirtualNao
    from nao_kin.viewer import Viewer


_FRAMES_PER_SECOND = 25.0

_HOST, _PORT = "127.0.0.1", 9559


@dataclass(frozen=True)
class VirtualOptions(ExtraPage):
    """The options of the virtual NAO of `serve` and `run`, and of its page."""

    speed: float | None = option("X", "Seconds of robot time in each second. Default: 1.")
    posture: str | None = option("NAME", "Initial posture. Default: Crouch.")
    behaviors: str | None = option("FOLDER", "Choregraphe's behaviours (.xar) for ALBehaviorManager to play.")
    view: bool = flag("Show the robot in a live page.")
    log: bool = flag("Print what the virtual NAO says, and its log.")

    @property
    def begin(self) -> dict[str, Any]:
        """The arguments of the virtual NAO that are given."""
        given = {"speed": self.speed, "posture": self.posture, "behaviors": self.behaviors}
        return {name: value for name, value in given.items() if value is not None}


@command("serve", "Example: nao-kin serve --speed 10 --log", without=OTHER_ROBOTS)
def serve(
    *,
    port: int = option("N", "Port to listen on; 0 for a free one.", default=_PORT),
    host: str = option("ADDRESS", "Address to listen on. Caution: qi has no passwords.", default=_HOST),
    robot: RobotOptions,
    virtual: VirtualOptions,
    awake: bool = flag("Start with stiffness, as after wakeUp."),
    json: bool = shared.JSON,
) -> None:
    """Serve a virtual NAO to NAOqi scripts, until Ctrl-C.

    Scripts connect to it as to a robot: with a qi session at tcp://127.0.0.1:9559. The virtual NAO starts without
    stiffness, like a robot that was just switched on. Its simulation is kinematic: joints move within their limits and
    maximum speeds, without mass. Commands to joints without stiffness are reported on standard error.
    """
    with served(robot, virtual, host=host, port=port, awake=awake, kinds=("limp", "kernels")) as done:
        if json:
            print(dumps(done))  # one line: the reader waits for its end
        else:
            for where in done.values():
                print(f"{where}  (Ctrl-C ends)")
        sys.stdout.flush()
        wait_for_signal()


@contextmanager
def served(
    options: RobotOptions, virtual: VirtualOptions, *, host: str, port: int, awake: bool, kinds: tuple[str, ...]
) -> Iterator[dict[str, str]]:
    """Serve a virtual NAO over qi until the end of the context; yield "endpoint", and "url" if it has a page.

    Changes of these `kinds` are printed on standard error: "limp" for commands to joints without stiffness, "kernels"
    for remarks on compiled kernels; with --log all messages and remarks.
    """
    from nao_kin.naoqi import QiServer, VirtualNao
    from nao_kin.robot import load_nao

    robot = load_nao(options.nao, offsets=options.offsets)
    with ExitStack() as running:

        def shown(page: LivePage) -> Viewer:
            moving = load_nao(options.nao, base="floating", offsets=options.offsets)
            return running.enter_context(closing(page.viewer(moving)))

        def watcher(change: Event) -> None:
            if change.kind in (("log",) if virtual.log else kinds):
                print_note(f"{change.time:.2f} s: {change.value}")

        pictures = camera_pictures(lambda: shown(LivePage()))
        nao = running.enter_context(VirtualNao(robot, on_change=watcher, pictures=pictures, **virtual.begin))
        if awake:
            nao.call("ALMotion", "wakeUp")
        server = running.enter_context(QiServer(nao, host=host, port=port, quiet=True))
        done = {"endpoint": server.endpoint}
        if virtual.view:
            viewer = shown(virtual)
            done["url"] = virtual.address(viewer)
            ended = threading.Event()
            follower = threading.Thread(target=follow, args=(nao, viewer, ended), name="live view", daemon=True)
            follower.start()
            running.callback(follower.join)
            running.callback(ended.set)
        yield done


def follow(nao: VirtualNao, viewer: Viewer, ended: threading.Event) -> None:
    """Show pose and lights of the virtual NAO until `ended` is set; `viewer` has it with a floating base."""
    from nao_kin.naoqi import light_colours

    shown = lit = None
    while not ended.wait(1.0 / _FRAMES_PER_SECOND):
        state = nao.state()
        q = _configuration(state)
        if shown is None or not np.array_equal(q, shown):
            viewer.display(q)
            shown = q
        if state.leds != lit:
            viewer.show_lights(light_colours(state.leds))
            lit = state.leds


def _configuration(state: State) -> Floats:
    """Return the configuration of the robot with a floating base."""
    from nao_kin.rotations import quat_from_matrix

    r0, *vector = quat_from_matrix(state.T_world_torso[:3, :3])
    return np.concatenate([state.T_world_torso[:3, 3], vector, [r0], state.q])


def camera_pictures(make_viewer: Callable[[], Viewer]) -> Callable[[State, str, tuple[int, int]], Any]:
    """Return the `pictures` of a virtual NAO, drawn by a headless browser, which starts with the first picture."""
    viewer, lock = cache(make_viewer), threading.Lock()

    def pictures(state: State, camera: str, size: tuple[int, int]) -> Any:
        from PIL import Image

        from nao_kin.naoqi import light_colours

        with lock, TemporaryDirectory() as folder, before_ending(partial(shutil.rmtree, folder, ignore_errors=True)):
            viewer().display(_configuration(state))
            viewer().show_lights(light_colours(state.leds))
            file = viewer().save_png(Path(folder) / "seen.png", camera=camera, size=size)
            return np.asarray(Image.open(file).convert("RGB"))

    return pictures


# --- `nao-kin run`: a script for NAOqi, with a virtual NAO or a running server.


@command(
    "run",
    "Example: nao-kin run wave.py --view; nao-kin run wave.py --port 9559 -- --ip nao.local",
    without=OTHER_ROBOTS,
)
def run(
    *,
    script: str = argument("SCRIPT", "A Python script that drives a NAO."),
    arguments: list[str] | None = argument("[-- ARGUMENTS]", "Arguments of the script, after --.", None),
    port: int | None = option("N", "Port of a running server, such as that of nao-kin serve."),
    host: str | None = option("ADDRESS", f"Address of that server. Default: {_HOST}."),
    robot: RobotOptions,
    virtual: VirtualOptions,
    asleep: bool = flag("Start without stiffness, until the script sets it."),
) -> None:
    """Run a script for NAOqi, which imports naoqi or qi, without a robot.

    Without --port, the script gets a virtual NAO of its own, awake and with stiffness, which ends with the script. All
    connections of the script lead there, whatever their address. A script in Python 2 is translated. The exit code is
    the script's.
    """
    from nao_kin.naoqi import run_script

    if port is None and host is None:
        with served(robot, virtual, host=_HOST, port=0, awake=not asleep, kinds=("limp",)) as done:
            if "url" in done:
                print_note(f"the virtual NAO is at {done['url']}")
            code = run_script(script, arguments or [], endpoint=done["endpoint"])
    else:
        own = {"offsets": robot.offsets, "asleep": asleep, "view": virtual.view, "log": virtual.log} | virtual.begin
        for name, value in own.items():
            if value not in (None, False):
                raise BadArgument(f"--{name} is for a virtual NAO of the script's own; leave out --port and --host")
        where = (host or _HOST).strip()
        number = whole_number(_PORT if port is None else port, "port", 1, 65535)
        code = run_script(script, arguments or [], endpoint=f"tcp://{f'[{where}]' if ':' in where else where}:{number}")
    raise typer.Exit(code)


# --- `nao-kin live`: the joints of a running robot, in a page and as a recording.

_RATE = 25.0


@command("live", "Example: nao-kin live tcp://nao.local:9559 -o wave.json", without=OTHER_ROBOTS)
def live(
    *,
    address: str | None = argument("[tcp://HOST:PORT]", "A robot, or a virtual NAO, over NAOqi.", None),
    lola: str | None = option("SOCKET", "Read a NAO6's RoboCup interface instead, from its Unix socket."),
    rate: float = option("N", "Largest number of readings per second.", default=_RATE),
    missing: str | None = option("VALUE", "Values of joints whose sensors give none: a posture, or a number."),
    output: str | None = option("FILE", "Write the readings as a motion at the end."),
    seconds: float | None = option("S", "End after this many seconds of readings, or as many without one."),
    view: bool = flag("Show the robot in a live page, the default.", "--view/--no-view", default=True),
    page: LivePage,
    written: OutputOptions,
    robot: RobotOptions,
) -> None:
    """Show a robot's current joints in a live page, or record them, until Ctrl-C or for some seconds.

    The page also says what the robot does, and where it has walked, as far as its sensors show it. The joints are only
    read: no command is ever sent. A lost connection is reestablished.
    """
    if (address is None) == (lola is None):
        raise BadArgument("give the address of a robot, as in tcp://nao.local:9559, or --lola SOCKET")
    if seconds is not None and not seconds > 0.0:
        raise BadArgument(f"--seconds must be a positive number, got {seconds:g}")
    if output is not None:
        check_motion_file(output)  # now, not after the recording
        atomic.check_replaceable(output, overwrite=written.force)
    model = robot.load()
    from nao_kin.naoqi import LolaSource, Lost, NaoqiSource, readings, recorded

    source = LolaSource(lola) if lola is not None else NaoqiSource(str(address))
    found: list[JointReading] = []
    patience = math.inf if seconds is None else seconds
    with ExitStack() as running:
        viewer = None
        if view:
            from nao_kin.world import StateEstimator

            viewer = running.enter_context(closing(page.viewer(model)))
            estimator, doing = StateEstimator(model), viewer.add_text("state")
            print_note(f"{page.address(viewer)}  (Ctrl-C ends)")
        # A signal ends the reading; the readings so far are still written.
        ended = running.enter_context(uninterrupted())
        since = time.monotonic()  # the last reading, or the start

        def wanted() -> bool:
            return not ended() and time.monotonic() < since + patience

        rest = posture_or_number(missing)
        for reading in readings(source, model, rate=rate, wanted=wanted, on_state=print_note, missing=rest):
            since = time.monotonic()
            if viewer is not None:
                viewer.display(reading.q, up=reading.up)
                doing.value = _described(estimator.update(reading.q, reading.time, **reading.sensors))
            if output is None:
                found.clear()  # without a recording, the last reading is enough
            found.append(reading)
            if reading.time >= patience:
                break
        if not found and not ended():
            raise Lost(f"{source.address} gave no reading within {patience:g} s")
        if output is not None and found:
            from nao_kin.motion import write_motion

            write_motion(recorded(found, model), output, overwrite=written.force)
        _report(model.joint_names, found, output, written.json)


def _described(now: world.State) -> str:
    """Return what a robot does, on which soles, and where it is, in the words of its page."""
    x, y, heading = now.odometry.pose[0]
    on = {"both": ", on both soles", "none": ""}.get(str(now.support[0]), f", on {now.support[0]}")
    at = f"; {x:.2f}, {y:.2f} m, {math.degrees(heading):.0f}°" if now.valid[0] else ""
    return f"{now.doing[0]}{on}{at}"


def _report(names: tuple[str, ...], found: list[JointReading], output: str | None, json: bool) -> None:
    if json:
        last = None if not found else dict(zip(names, found[-1].q.tolist(), strict=True))
        print_json({"readings": len(found) if output is not None else None, "last": last, "record": output})
    elif output is not None:
        print(output if found else "no readings")
    sys.stdout.flush()  # a pending signal would exit without flushing
