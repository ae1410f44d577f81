"""ALBehaviorManager and ALAnimationPlayer: the timelines of Choregraphe's behaviours, played."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin.errors import BadArgument, BadInputFile, UnknownName
from nao_kin.motion import Motion, read_motion
from nao_kin.naoqi.virtual import arguments
from nao_kin.naoqi.virtual.engine import Call
from nao_kin.naoqi.virtual.interpolation import Interpolation
from nao_kin.naoqi.virtual.service import Service, formerly

if TYPE_CHECKING:
    from nao_kin.naoqi.virtual.virtual_nao import VirtualNao


# The files that Choregraphe writes are called so; a behaviour is named by their folder.
_FILE = "behavior"
# What ALAnimationPlayer writes in place of [posture].
_POSTURES = {"Standing": "Stand", "Sitting": "Sit"}


@formerly(
    "The same under its name before NAOqi 1.22.",
    getBehaviorNames="getInstalledBehaviors",
    isBehaviorPresent="isBehaviorInstalled",
)
@formerly("The same as {}: nothing is loaded ahead here.", isBehaviorLoaded="isBehaviorRunning")
@formerly("The same as {}.", getLoadedBehaviors="getRunningBehaviors")
@formerly("Taken and left; whether there is such a behaviour.", preloadBehavior="isBehaviorInstalled")
class ALBehaviorManager(Service):
    """The behaviours (.xar) in the folder of `nao-kin serve --behaviors FOLDER`, or of `VirtualNao(behaviors=FOLDER)`.

    The file dance/behavior_1/behavior.xar is the behaviour dance/behavior_1, the file wave.xar is wave. Its timeline is
    played: joints go from where they are commanded to its first keys, and through the others. Of several timelines,
    wave/1 is the first, and wave/NAME that of a box. Boxes and scripts are not run.
    """

    name = "ALBehaviorManager"
    absent = tuple(
        "addDefaultBehavior removeDefaultBehavior setDefaultBehaviors getDefaultBehaviors playDefaultProject "
        "getBehaviorTags getBehaviorsByTag getTagList getBehaviorNature getSystemBehaviorNames getUserBehaviorNames "
        "removeBehavior resolveBehaviorName installBehavior".split()
    )

    def __init__(self, nao: VirtualNao) -> None:
        super().__init__(nao)
        self._started: dict[str, Call] = {}

    def getInstalledBehaviors(self) -> list[str]:
        """Names of all behaviours."""
        return sorted(self._files())

    def isBehaviorInstalled(self, name: Any) -> bool:
        """Whether there is such a behaviour."""
        return arguments.text(name, "name") in self._files()

    def runBehavior(self, name: Any) -> Call:
        """Play a behaviour; returns at its end."""
        return self._play("runBehavior", name)

    def startBehavior(self, name: Any) -> None:
        """Play a behaviour; returns at once."""
        self._play("startBehavior", name)

    def stopBehavior(self, name: Any) -> None:
        """End a behaviour where it is; does nothing when it is not played."""
        call = self._started.get(arguments.text(name, "name"))
        if call is not None:
            call.cancel()

    def stopAllBehaviors(self) -> None:
        """End all behaviours where they are."""
        for call in self._started.values():
            call.cancel()

    def isBehaviorRunning(self, name: Any) -> bool:
        """Whether a behaviour is played, or waits for its joints."""
        return arguments.text(name, "name") in self.getRunningBehaviors()

    def getRunningBehaviors(self) -> list[str]:
        """Names of the behaviours that are played."""
        return sorted(name for name, call in self._started.items() if not call.done())

    def _play(self, task: str, name: Any) -> Call:
        """Start a behaviour, under any name of a task.

        Raises:
            UnknownName: no such behaviour.
            BadArgument: it is played already, has several timelines, or there is no folder of behaviours.
            BadInputFile: it cannot be read, or has no such timeline.
        """
        wanted, files = arguments.text(name, "name"), self._files()
        if self.nao.behaviors is None:
            raise BadArgument("no behaviours are installed; nao-kin serve and run take a folder of them, --behaviors")
        file = max((file for file in files if f"{wanted}/".startswith(f"{file}/")), key=len, default=None)
        if file is None:
            raise UnknownName("behaviour", wanted, tuple(files))
        if self.isBehaviorRunning(wanted):
            raise BadArgument(f"{wanted} is running already")
        motion = self._read(files[file], wanted[len(file) + 1 :], file)
        call = self.nao.start_task(Interpolation(task, motion.joint_names, lambda start: led_in(motion, start)))
        self._started[wanted] = call
        return call

    def _read(self, path: Path, timeline: str, name: str) -> Motion:
        """The motion of a timeline in a file, of its only one where `timeline` is empty."""
        try:
            return read_motion(path, format="xar", timeline=timeline or None, robot=self.nao.robot)
        except BadInputFile:
            if timeline:
                raise
            read_motion(path, format="xar", timeline=1, robot=self.nao.robot)  # what else is wrong is raised again
        raise BadArgument(f"{name} has several timelines; play one by its number or its box's name, as {name}/1")

    def _files(self) -> dict[str, Path]:
        folder = self.nao.behaviors
        if folder is None:
            return {}
        found = {}
        for path in folder.rglob("*.xar"):
            name = path.relative_to(folder).with_suffix("")
            found[(name.parent if name.name == _FILE and name.parent.name else name).as_posix()] = path
        return found


class ALAnimationPlayer(Service):
    """Plays behaviours of ALBehaviorManager; Aldebaran's animations are not part of nao_kin."""

    name = "ALAnimationPlayer"
    absent = ("runTag", "reset", "declarePathForTags", "addTagForAnimations", "declareTagForAnimations")

    def run(self, path: Any) -> Call:
        """Play a behaviour; returns at its end.

        Args:
            path: its name; [robot] in it stands for Nao, [posture] for Stand or Sit.
        """
        name = arguments.text(path, "path").replace("[robot]", "Nao")
        if "[posture]" in name:
            family = self.nao.services["ALRobotPosture"].invoke("getPostureFamily")
            if family not in _POSTURES:
                raise BadArgument(f"[posture] stands for Stand or Sit, and the robot's family of postures is {family}")
            name = name.replace("[posture]", _POSTURES[family])
        manager = self.nao.services["ALBehaviorManager"]
        return manager._play("ALAnimationPlayer.run", name)  # type: ignore[attr-defined, no-any-return]


def led_in(motion: Motion, start: Floats) -> Motion:
    """The motion with a key at time zero for each joint that has none: where it is, with level handles.

    Args:
        motion: of n joints, from time zero or later.
        start: their values at time zero, shape (n,).
    """
    curves = motion.as_bezier()
    assert curves.handles is not None
    times, keys, handles = list(curves.times), list(curves.keys), list(curves.handles)
    for joint, first in enumerate(start):
        gap = float(times[joint][0])
        if gap > 0.0:
            times[joint] = np.concatenate([[0.0], times[joint]])
            keys[joint] = np.concatenate([[first], keys[joint]])
            handles[joint] = np.concatenate([np.zeros((1, 2, 2)), handles[joint]])
            handles[joint][0, 1, 0], handles[joint][1, 0] = gap / 3.0, (-gap / 3.0, 0.0)
    return Motion(times, motion.joint_names, keys, "bezier", handles)
