"""A virtual NAO: services that answer as NAOqi's do, over a kinematic robot, and a server that offers them.

Nothing here but `qi_server` knows qi: a test drives services directly, and time is stepped by hand.

    with VirtualNao(stepped=True) as nao:
        call = nao.post("ALMotion", "angleInterpolation", "HeadYaw", 0.5, 1.0, True)
        nao.step(0.5)
        nao.call("ALMotion", "getAngles", "HeadYaw", True)

## How a method is written

A service is a class with a `name`; its topics may be classes of their own in files of their own (`services/motion.py`
puts ALMotion together, with `cartesian`, `whole_body` and `walk`). Its public methods are offered to scripts: each has
NAOqi's name, and takes what NAOqi's takes. What else a service needs begins with an underscore:

    class Tools(Service):
        def getAngles(self, names, useSensors):
            columns = self.nao.joints.columns(self.joints(names))
            ...

It runs with the lock held, on whichever thread, and so neither waits nor sleeps. Arguments are read by `arguments`
(`number`, `fraction`, `flag`, `one_each`, `list_each` …) and names by `self.joints`; every `NaoKinError` reaches the
script as `Service::method`, a line break, a tab and the error's line. Names of NAOqi's methods that are missing stand
in `absent`. What takes time returns a `Call`: that of a task, of `nao.after(seconds)`, or one of its own.
A value that scripts set and read, and that changes nothing, is a row of `@keeps(Kept(...))`, one that never changes a
row of `@answers`; a former name of a method is one of `@formerly(walkTo="moveTo")`, and methods that differ in what
they take, or in how many, are `@variants` of one.

## How a task is written

What moves joints over time is a `Task`: its name, its resources, and what it does in a tick of 10 ms:

    class Nod(Task):
        def __init__(self):
            super().__init__("nod", ["HeadPitch"])

        def start(self, nao, time):                 # its joints are free
            self.columns = nao.joints.columns(["HeadPitch"])
            self.first, self.begin = nao.joints.command[self.columns], time

        def advance(self, nao, time):               # the tick that ends at `time`
            angle = self.first + 0.2 * np.sin(2 * np.pi * (time - self.begin))
            nao.joints.set(self.columns, angle, self.notes)
            return time - self.begin >= 1.0         # True: done, its call ends

    return self.nao.start_task(Nod())               # in a method: the Call of it

A task with `reactive = True` books nothing; later tasks take its joints (`give_up`). `end` is called once at its end,
killed or not; `value` is what its call answers. Where the same method is called again while its task runs (move), find
it in `nao.tasks.running` and change it. Commands need not be inside limits: `Joints` clips them and notes it in
`self.notes`. `nao.base` says where the torso is in the world, and a walk plants feet with `nao.base.plant`. A task that
plans with the standing foot in place sets `keeps_feet = True`; while none does, FRAME_ROBOT stays as long as both soles
are down.
"""

from nao_kin.naoqi.virtual.body import Base
from nao_kin.naoqi.virtual.engine import Call, Change, NaoqiError, Task
from nao_kin.naoqi.virtual.interpolation import Approach, Interpolation
from nao_kin.naoqi.virtual.qi_server import OpenToOthersWarning, QiServer
from nao_kin.naoqi.virtual.service import Service
from nao_kin.naoqi.virtual.virtual_nao import State, VirtualNao

__all__ = [
    "Approach",
    "Base",
    "Call",
    "Change",
    "Interpolation",
    "NaoqiError",
    "OpenToOthersWarning",
    "QiServer",
    "Service",
    "State",
    "Task",
    "VirtualNao",
]
