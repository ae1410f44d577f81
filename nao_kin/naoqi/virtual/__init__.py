"""A virtual NAO: a kinematic robot with NAOqi's services, and a server that offers them.

Only `qi_server` depends on qi: a test can call services directly, and advance the time itself.

    with VirtualNao(stepped=True) as nao:
        call = nao.post("ALMotion", "angleInterpolation", "HeadYaw", 0.5, 1.0, True)
        nao.step(0.5)
        nao.call("ALMotion", "getAngles", "HeadYaw", True)

## How to write a method

A service is a class with a `name`; its topics may be classes in other files (`motion.py` joins the topics of
ALMotion: `cartesian`, `whole_body` and `walk`). Its public methods are offered to scripts, with NAOqi's names and
arguments. The names of its internal methods begin with an underscore:

    class Tools(Service):
        def getAngles(self, names, useSensors: Flag):
            columns = self.nao.joints.columns(self.joints(names))
            ...

`self.nao` is the `Machine` that a `VirtualNao` owns: its robot, clock, joints, base, tasks, log and other services. A
method runs with the lock held, on any thread, and therefore must not wait or sleep. An annotation of the module
`arguments` says how an argument is read and checked (`Number`, `Share`, `Flag`, `Text` …) before the method is called.
Its functions read the others (`one_each`, `list_each` …), and `self.joints` reads names of joints. Every
`NaoKinError` reaches the script as `Service::method`, a line break, a tab and the error's line. A method that takes
time returns a `Call`: that of a task, or a new one. A second name of a method is an
assignment in its class, `walkTo = moveTo`. `absent_methods.json` lists NAOqi's other methods.

## How to write a task

A `MotionTask` moves joints over time. It has a name, resources, and an action for a tick of 10 ms:

    class Nod(MotionTask):
        def __init__(self):
            super().__init__("nod", ["HeadPitch"])

        def start(self, nao, time):                 # called when its joints are free
            self.columns = nao.joints.columns(["HeadPitch"])
            self.first, self.begin = nao.joints.command[self.columns], time

        def advance(self, nao, time):               # the tick that ends at `time`
            angle = self.first + 0.2 * np.sin(2 * np.pi * (time - self.begin))
            nao.joints.set(self.columns, angle, self.notes)
            return time - self.begin >= 1.0         # True: the task is done, and its call ends

    return self.nao.tasks.add(Nod())                # in a method of a service: the task's Call

A task with `reactive = True` reserves nothing; later tasks take its joints (`give_up`). `end` is called exactly one
time, when the task is done or killed; `value` is the result of its call. A method that changes a running task, such as
move, finds the task with `nao.tasks.of`. Commands may be outside the limits: `Joints` clips them, and says so in
`self.notes`. `nao.base` has the torso's pose in the world, and a walk changes the standing foot with
`nao.base.stand_on`. A task that plans with the standing foot in place sets `keeps_feet = True`; without such a task,
FRAME_ROBOT stays in place while both soles are down.
"""

from nao_kin.naoqi.virtual.body import Base
from nao_kin.naoqi.virtual.engine import Call, Event, NaoqiError
from nao_kin.naoqi.virtual.machine import AtSpeed, Interpolation, Machine, MotionTask
from nao_kin.naoqi.virtual.qi_server import OpenToOthersWarning, QiServer
from nao_kin.naoqi.virtual.service import Service
from nao_kin.naoqi.virtual.virtual_nao import State, VirtualNao

__all__ = [
    "AtSpeed",
    "Base",
    "Call",
    "Event",
    "Interpolation",
    "Machine",
    "MotionTask",
    "NaoqiError",
    "OpenToOthersWarning",
    "QiServer",
    "Service",
    "State",
    "VirtualNao",
]
