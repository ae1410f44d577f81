"""The virtual NAO: state, time, and the services that scripts talk to."""

from __future__ import annotations

import threading
import time as wall
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import Floats, choice, flag
from nao_kin._core.text import one_line_repr, quoted
from nao_kin.errors import BadArgument
from nao_kin.naoqi.virtual import expression, life, memory, motion, movements, video
from nao_kin.naoqi.virtual.engine import MAX_SECONDS, TICK, Call, Event, NaoqiError
from nao_kin.naoqi.virtual.machine import Machine
from nao_kin.naoqi.virtual.service import ABSENT, Service
from nao_kin.robot import NaoModel, load_nao

# The shortest pause of the thread, so that it does not wake up too often [s].
_SHORTEST_SLEEP = 0.001

SERVICES: tuple[type[Service], ...] = (
    motion.ALMotion,
    movements.ALRobotPosture,
    memory.ALMemory,
    expression.ALLeds,
    expression.ALTextToSpeech,
    expression.ALAnimatedSpeech,
    expression.ALAudioPlayer,
    life.ALAutonomousLife,
    life.ALBattery,
    memory.ALTouch,
    memory.ALSonar,
    movements.ALTracker,
    movements.ALBehaviorManager,
    movements.ALAnimationPlayer,
    video.ALVideoDevice,
    *life.ABILITIES,
)


class Missing(Service):
    """A service that this virtual NAO does not have."""

    def __init__(self, nao: Machine, name: str, why: str, methods: str) -> None:
        self.name, self._why = name, why
        super().__init__(nao)
        self._methods, self.absent = {}, tuple(dict.fromkeys(methods.replace("*", ABSENT["extractor"]).split()))

    def _no_method(self, name: str) -> NaoqiError:
        others = ", ".join(other for other, service in self.nao.services.items() if not isinstance(service, Missing))
        return NaoqiError(self.name, quoted(name)[1:-1], f"not in this virtual NAO: {self._why}; there are: {others}")


@one_line_repr
@dataclass(frozen=True)
class State:
    """The state of the robot at one moment; arrays are copies.

    Attributes:
        time: robot time [s].
        q: configuration measured by the sensors, shape (25,).
        command: commanded configuration, shape (25,).
        stiffness: in the order of "Body", shape (26,).
        T_world_torso: shape (4, 4).
        leds: colour of each LED, r, g, b from 0 to 1.
        saying: the text being said; "" for none.
    """

    time: float
    q: Floats
    command: Floats
    stiffness: Floats
    T_world_torso: Floats
    leds: Mapping[str, tuple[float, float, float]]
    saying: str


class VirtualNao:
    """A simulated NAO that answers NAOqi's calls.

    The simulation is kinematic: joints move to their commands within limits and maximum speeds; nothing has weight,
    falls or collides. It begins in Crouch without stiffness, like a robot that was just switched on.

    Args:
        robot: a NAO with a fixed base; None for a V6.
        speed: seconds of robot time in one second.
        stepped: only `step` and `call` advance the time; no thread runs, and results are reproducible.
        posture: the initial posture.
        behaviors: a folder with Choregraphe's behaviours (.xar), which ALBehaviorManager plays; None for none.
        on_change: called with every event, on the thread that makes it; it must not wait. An event has a robot `time`
            [s], a `kind` ("log", "limp", "leds", "speech", "posture", "life" …) and a `value`, a text for "log" and for
            "limp" (a command to joints without stiffness).
        pictures: draws for ALVideoDevice what a camera sees: called with a `State`, the camera's frame, such as
            "CameraTop", and (width, height), on any thread; returns red, green and blue from 0 to 255, of type uint8,
            shape (height, width, 3).

    Attributes:
        machine: the parts of the virtual NAO, which its services and tasks use.
        robot, clock, joints, tasks, base, log: these parts; hold `monitor`, the lock, while you read or change more
            than one of them.
        services: name → service.
        behaviors: the folder of behaviours, or None.

    Raises:
        BadArgument: robot is not a NAO with a fixed base, speed is not positive, or behaviors is not a folder.

    Examples:
        >>> with nk.naoqi.VirtualNao(stepped=True) as nao:
        ...     nao.call("ALMotion", "wakeUp")
        ...     nao.call("ALMotion", "angleInterpolation", "HeadYaw", 0.5, 1.0, True)
        ...     print(np.round(nao.call("ALMotion", "getAngles", "HeadYaw", True), 3))
        [0.5]
    """

    def __init__(
        self,
        robot: NaoModel | None = None,
        *,
        speed: float = 1.0,
        stepped: bool = False,
        posture: str = "Crouch",
        behaviors: Path | str | None = None,
        on_change: Callable[[Event], object] | None = None,
        pictures: Callable[[State, str, tuple[int, int]], ArrayLike] | None = None,
    ) -> None:
        chosen = load_nao() if robot is None else robot
        if chosen.base != "fixed":
            raise BadArgument("robot must be a NAO with a fixed base, as load_nao gives it")
        self.stepped = flag(stepped, "stepped")
        self.behaviors = None if behaviors is None else Path(behaviors)
        if self.behaviors is not None and not self.behaviors.is_dir():
            raise BadArgument(f"behaviors must be a folder, got {quoted(str(behaviors))}")
        self.machine = machine = Machine(chosen, posture, speed, self.behaviors, on_change)
        self.robot, self.monitor, self.clock, self.log = machine.robot, machine.monitor, machine.clock, machine.log
        self.joints, self.base, self.tasks = machine.joints, machine.base, machine.tasks
        self._pictures, machine.picture, machine.stepped = pictures, self._picture, self.stepped
        services: dict[str, Service] = {kind.name: kind(machine) for kind in SERVICES}
        for why, methods_of in ABSENT["missing"].items():
            services |= {name: Missing(machine, name, why, methods) for name, methods in methods_of.items()}
        self.services: Mapping[str, Service] = MappingProxyType(services)
        machine.services = self.services
        self._thread: threading.Thread | None = None
        if not stepped:
            self._thread = threading.Thread(target=self._run, name="virtual NAO", daemon=True)
            self._thread.start()

    # --- for scripts ----------------------------------------------------------------------------------------------

    def call(self, service: str, method: str, *arguments: Any) -> Any:
        """Call a method and wait for its result; with `stepped`, time advances until the result is available.

        Raises:
            NaoqiError: the method raises an error, as in NAOqi.

        Examples:
            >>> with nk.naoqi.VirtualNao(stepped=True) as nao:
            ...     print(nao.call("ALMotion", "getBodyNames", "Head"))
            ['HeadYaw', 'HeadPitch']
        """
        call = self.post(service, method, *arguments)
        if self.stepped:
            end = self.clock.now + MAX_SECONDS
            while not call.done():
                if self.clock.now > end:
                    raise NaoqiError(service, method, f"no answer within {MAX_SECONDS:g} s of robot time")
                self.machine.tick()
        return call.result()

    def post(self, service: str, method: str, *arguments: Any) -> Call:
        """Call a method without waiting for its result.

        Raises:
            NaoqiError: the method refuses the call.

        Examples:
            >>> with nk.naoqi.VirtualNao(stepped=True) as nao:
            ...     _ = nao.post("ALMotion", "angleInterpolation", "HeadYaw", 0.5, 1.0, True)
            ...     nao.step(2.0)
            ...     print(np.round(nao.call("ALMotion", "getAngles", "HeadYaw", False), 3))
            [0.5]
        """
        answer = self.services[choice(service, self.services, "service")].invoke(method, *arguments)
        if isinstance(answer, Call):
            return answer
        call = Call()
        call.finish(answer)
        return call

    # --- time -----------------------------------------------------------------------------------------------------

    def step(self, dt: float) -> None:
        """Advance robot time by whole ticks of 10 ms; the remaining fraction of a tick is added to the next step.

        Raises:
            BadArgument: the virtual NAO was not made with stepped=True, or a step is longer than an hour.

        Examples:
            >>> with nk.naoqi.VirtualNao(stepped=True) as nao:
            ...     nao.step(0.5)
            ...     print(round(nao.state().time, 3))
            0.5
        """
        if not self.stepped:
            raise BadArgument("step needs a virtual NAO made with stepped=True; the time of this one runs by itself")
        self.machine.check_open()
        for _ in range(self.clock.step(dt)):
            self.machine.tick()

    def _run(self) -> None:
        pause = max(0.5 * TICK / self.clock.speed, _SHORTEST_SLEEP)
        self.clock.due(wall.monotonic())
        while not self.machine.ended.wait(pause):
            with self.monitor:
                due = self.clock.due(wall.monotonic())
            for _ in range(due):
                if self.machine.ended.is_set():
                    return
                self.machine.tick()

    # --- state ----------------------------------------------------------------------------------------------------

    def state(self) -> State:
        """Return the state at one moment.

        Examples:
            >>> with nk.naoqi.VirtualNao(stepped=True, posture="Stand") as nao:
            ...     print(nao.state().q.shape)
            (25,)
        """
        with self.monitor:
            q = self.joints.q()
            return State(
                self.clock.now,
                q,
                self.joints.q(sensor=False),
                self.joints.stiffness,
                self.base.torso(q),
                MappingProxyType(dict(self.machine.services["ALLeds"].colours)),
                self.machine.services["ALTextToSpeech"].saying,
            )

    def _picture(self, camera: str, size: tuple[int, int]) -> NDArray[np.uint8]:
        """Return what a camera sees now; not with the lock held."""
        if self._pictures is None:
            raise BadArgument("its cameras see nothing: give VirtualNao a function that draws, pictures=")
        drawn, shape = np.asarray(self._pictures(self.state(), camera, size)), (size[1], size[0], 3)
        if drawn.dtype != np.uint8 or drawn.shape != shape:
            raise BadArgument(f"pictures must return uint8 of shape {shape}, got {drawn.dtype} of {drawn.shape}")
        return drawn

    # --- the end --------------------------------------------------------------------------------------------------

    def close(self) -> None:
        """Stop robot time; pending calls get an error. Does nothing if the virtual NAO is closed already.

        Examples:
            >>> nk.naoqi.VirtualNao(stepped=True).close()
        """
        with self.monitor:
            if self.machine.ended.is_set():
                return
            self.machine.ended.set()
        if self._thread is not None and self._thread is not threading.current_thread():
            self._thread.join()
        self.machine.end_calls()

    def __enter__(self) -> VirtualNao:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
