"""ALMemory: values by key, the robot's own among them, and events."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

from nao_kin.errors import BadArgument, UnknownName, nearest_names
from nao_kin.naoqi.poses import position6d
from nao_kin.naoqi.virtual import arguments
from nao_kin.naoqi.virtual.calls import Call
from nao_kin.naoqi.virtual.service import Service, method

if TYPE_CHECKING:
    from nao_kin.naoqi.virtual.virtual_nao import VirtualNao

_DEVICE = "Device/SubDeviceList"
_GRAVITY = 9.81  # m/s²
_CALM = 38.0  # degrees Celsius of a motor that has nothing to do
_BATTERY = {"Charge": 1.0, "Current": -0.5, "Temperature": 35.0}
_CONSTANT = (
    "LFoot/Bumper/Left LFoot/Bumper/Right RFoot/Bumper/Left RFoot/Bumper/Right ChestBoard/Button Head/Touch/Front "
    "Head/Touch/Middle Head/Touch/Rear LHand/Touch/Left LHand/Touch/Back LHand/Touch/Right RHand/Touch/Left "
    "RHand/Touch/Back RHand/Touch/Right LFoot/FSR/FrontLeft LFoot/FSR/FrontRight LFoot/FSR/RearLeft "
    "LFoot/FSR/RearRight LFoot/FSR/TotalWeight RFoot/FSR/FrontLeft RFoot/FSR/FrontRight RFoot/FSR/RearLeft "
    "RFoot/FSR/RearRight RFoot/FSR/TotalWeight"
).split()
_EVENTS = (
    "FrontTactilTouched MiddleTactilTouched RearTactilTouched HandRightBackTouched HandRightLeftTouched "
    "HandRightRightTouched HandLeftBackTouched HandLeftLeftTouched HandLeftRightTouched RightBumperPressed "
    "LeftBumperPressed ChestButtonPressed"
).split()


class Subscriber:
    """What `ALMemory.subscriber` gives: tells of every value that is raised under its key.

    Args:
        memory: whose events.
        key: which event.
    """

    def __init__(self, memory: ALMemory, key: str) -> None:
        self.key = key
        self._memory = memory
        self._numbers = itertools.count(1)
        self._callbacks: dict[int, Callable[[Any], object]] = {}

    def connect(self, callback: Callable[[Any], object]) -> int:
        """Have `callback` called with every value from now on; returns a number to disconnect it by."""
        with self._memory.nao.monitor:
            number = next(self._numbers)
            self._callbacks[number] = callback
            self._memory.listen(self)
        return number

    def disconnect(self, number: int) -> bool:
        """Call a callback no more; whether there was one of this number."""
        with self._memory.nao.monitor:
            found = self._callbacks.pop(number, None) is not None
            if not self._callbacks:
                self._memory.forget(self)
        return found

    def tell(self, value: Any) -> None:
        """Call all callbacks, when the lock is free."""
        for callback in tuple(self._callbacks.values()):
            self._memory.nao.monitor.later(partial(callback, value))


class ALMemory(Service):
    """Values by key, and events.

    The robot's own keys are read where they are asked for: for each joint `Device/SubDeviceList/<joint>/Position/
    Sensor/Value`, `…/Position/Actuator/Value`, `…/Hardness/Actuator/Value`, `…/Temperature/Sensor/Value` and
    `…/ElectricCurrent/Sensor/Value` (38 °C and 0 A, no motor works here); of the inertial sensor the angles of the
    torso (AngleX, AngleY, AngleZ), gravity in its frame (AccelerometerX …) and gyroscopes at zero; battery; bumpers,
    touch and force sensors at zero; `PostureChanged`, `robotIsWakeUp`.
    A value that is inserted under such a key is read instead, until it is removed. RHipYawPitch shows LHipYawPitch.
    """

    name = "ALMemory"
    absent = tuple(
        "getDataPtr getEventHistory getTimestamp getListTimestamp insertMapping addMapping getMicroEventList "
        "getType".split()
    )

    def __init__(self, nao: VirtualNao) -> None:
        super().__init__(nao)
        self._values: dict[str, Any] = {}
        self._events: set[str] = set(_EVENTS)
        self._descriptions: dict[str, str] = {}
        self._listening: dict[str, list[Subscriber]] = {}
        self._modules: dict[str, dict[str, tuple[str, str]]] = {}
        self.module_called: Callable[[str, str, str, Any, str], object] | None = None
        self._own = self._own_keys()

    # --- values ---------------------------------------------------------------------------------------------------

    @method
    def getData(self, key: Any, iDummy: Any = 0) -> Any:
        """The value of a key; an error where there is none. A second argument, of old scripts, counts for nothing."""
        return self._value(arguments.text(key, "key"))

    @method
    def getListData(self, keyList: Any) -> list[Any]:
        """The values of several keys of one moment; None where a key has none."""
        if not isinstance(keyList, (list, tuple)):
            raise BadArgument("keyList must be a list of keys")
        keys = [arguments.text(key, "key") for key in keyList]
        return [self._value(key) if key in self._values or key in self._own else None for key in keys]

    @method
    def insertData(self, key: Any, data: Any) -> None:
        """Keep a value under a key; nobody is told."""
        self._values[_key(key)] = data

    @method
    def insertListData(self, pairs: Any) -> None:
        """Keep several values: a list of [key, value]."""
        if not isinstance(pairs, (list, tuple)) or any(
            not isinstance(pair, (list, tuple)) or len(pair) < 2 for pair in pairs
        ):
            raise BadArgument("pairs must be a list of [key, value]")
        for pair in pairs:
            self._values[_key(pair[0])] = pair[1]

    @method
    def removeData(self, key: Any) -> None:
        """Remove a value, or an inserted one that stood before the robot's own; an error where there is none."""
        name = arguments.text(key, "key")
        if name not in self._values:
            raise self._unknown(name)
        del self._values[name]

    @method
    def getDataList(self, filter: Any = "") -> list[str]:
        """All keys that contain a text, in alphabetical order."""
        part = arguments.text(filter, "filter")
        return sorted(key for key in {*self._values, *self._own} if part in key)

    @method
    def getDataListName(self) -> list[str]:
        """All keys, in alphabetical order."""
        return self.getDataList("")

    @method
    def getDataOnChange(self, key: Any, iDummy: Any = 0) -> Call:
        """Wait for the next time that the event is raised, and return its value."""
        wanted, waiting = Subscriber(self, _key(key)), Call()
        number = wanted.connect(waiting.finish)
        waiting.add_done_callback(lambda _: wanted.disconnect(number))
        return waiting

    @method
    def setDescription(self, name: Any, description: Any) -> None:
        """Describe a key."""
        self._descriptions[_key(name)] = arguments.text(description, "description")

    @method
    def getDescriptionList(self, keylist: Any) -> list[list[str]]:
        """[key, type, description] of keys."""
        if not isinstance(keylist, (list, tuple)):
            raise BadArgument("keylist must be a list of keys")
        return [[key, type(self._value(key)).__name__, self._descriptions.get(key, "")] for key in map(_key, keylist)]

    # --- events ---------------------------------------------------------------------------------------------------

    @method
    def declareEvent(self, eventName: Any, extractorName: Any = "") -> None:
        """List an event before it is raised."""
        self._events.add(_key(eventName))

    @method
    def getEventList(self) -> list[str]:
        """Names of the events that were declared or raised, in alphabetical order."""
        return sorted(self._events)

    @method
    def raiseEvent(self, name: Any, value: Any) -> None:
        """Keep a value under a key, and tell whoever listens."""
        key = _key(name)
        self._values[key] = value
        self._raise(key, value)

    @method
    def raiseMicroEvent(self, name: Any, value: Any) -> None:
        """The same as raiseEvent here."""
        self.raiseEvent(name, value)

    @method
    def subscriber(self, eventName: Any) -> Subscriber:
        """An object with a `signal` to connect to."""
        return Subscriber(self, _key(eventName))

    @method
    def subscribeToEvent(self, name: Any, callbackModule: Any, callbackMethod: Any, *more: Any) -> None:
        """Have a method of a service called with key, value and message whenever the event is raised.

        With four arguments they are key, service, message and method; with three, the message is the service's name.
        """
        if len(more) > 1:
            raise BadArgument("takes an event, a service, a message or none, and a method")
        message = callbackMethod if more else callbackModule
        function, note = (
            arguments.text([callbackMethod, *more][-1], "callbackMethod"),
            arguments.text(message, "message"),
        )
        key = _key(name)
        self._events.add(key)
        self._modules.setdefault(key, {})[arguments.text(callbackModule, "callbackModule")] = (function, note)

    @method
    def unsubscribeToEvent(self, name: Any, callbackModule: Any) -> None:
        """Call a service no more."""
        module = arguments.text(callbackModule, "callbackModule")
        if self._modules.get(_key(name), {}).pop(module, None) is None:
            raise BadArgument(f"{module} has not subscribed to {name}")

    @method
    def subscribeToMicroEvent(self, name: Any, callbackModule: Any, callbackMessage: Any, callbackMethod: Any) -> None:
        """As subscribeToEvent with a message."""
        self.subscribeToEvent(name, callbackModule, callbackMessage, callbackMethod)

    @method
    def unsubscribeToMicroEvent(self, name: Any, callbackModule: Any) -> None:
        """As unsubscribeToEvent."""
        self.unsubscribeToEvent(name, callbackModule)

    @method
    def getSubscribers(self, name: Any) -> list[str]:
        """Names of the services that are called at an event."""
        return sorted(self._modules.get(_key(name), {}))

    def announce(self, key: str, value: Any) -> None:
        """Raise an event of the robot's own; a value that is read from the robot is not kept."""
        if key not in self._own:
            self._values[key] = value
        self._raise(key, value)

    def listen(self, subscriber: Subscriber) -> None:
        """Tell a subscriber of its events from now on."""
        listening = self._listening.setdefault(subscriber.key, [])
        if subscriber not in listening:
            listening.append(subscriber)

    def forget(self, subscriber: Subscriber) -> None:
        """Tell it no more."""
        listening = self._listening.get(subscriber.key, [])
        if subscriber in listening:
            listening.remove(subscriber)
            if not listening:
                del self._listening[subscriber.key]

    # --- inside ---------------------------------------------------------------------------------------------------

    def _raise(self, key: str, value: Any) -> None:
        self._events.add(key)
        for subscriber in self._listening.get(key, ()):
            subscriber.tell(value)
        called = self.module_called
        if called is not None:
            for module, (function, message) in self._modules.get(key, {}).items():
                self.nao.monitor.later(partial(called, module, function, key, value, message))

    def _value(self, key: str) -> Any:
        if key in self._values:
            return self._values[key]
        if key in self._own:
            return self._own[key]()
        raise self._unknown(key)

    def _unknown(self, key: str) -> UnknownName:
        keys = sorted({*self._values, *self._own})
        near = nearest_names(key, keys)
        return UnknownName("key", key, near or keys)

    def _own_keys(self) -> dict[str, Callable[[], Any]]:
        """Every key of the robot's own, with what reads it."""
        joints = self.nao.joints
        own: dict[str, Callable[[], Any]] = {}
        for name, column in joints.column.items():
            place = f"{_DEVICE}/{name}"
            own[f"{place}/Position/Sensor/Value"] = partial(joints.sensor_at, column)
            own[f"{place}/Position/Actuator/Value"] = partial(joints.command_at, column)
            own[f"{place}/Hardness/Actuator/Value"] = partial(joints.stiffness_at, column)
            own[f"{place}/Temperature/Sensor/Value"] = lambda: _CALM
            own[f"{place}/ElectricCurrent/Sensor/Value"] = lambda: 0.0
        for quantity, value in _BATTERY.items():
            own[f"{_DEVICE}/Battery/{quantity}/Sensor/Value"] = partial(float, value)
        for button in _CONSTANT:
            own[f"{_DEVICE}/{button}/Sensor/Value"] = lambda: 0.0
        for event in _EVENTS:
            own[event] = lambda: 0.0
        for axis, letter in enumerate("XYZ"):
            place = f"{_DEVICE}/InertialSensor"
            own[f"{place}/Angle{letter}/Sensor/Value"] = partial(self._torso_angle, axis)
            own[f"{place}/Accelerometer{letter}/Sensor/Value"] = partial(self._acceleration, axis)
            own[f"{place}/Gyroscope{letter}/Sensor/Value"] = lambda: 0.0
        own["PostureChanged"] = lambda: self.nao.services["ALRobotPosture"].invoke("getPosture")
        own["PostureFamilyChanged"] = lambda: self.nao.services["ALRobotPosture"].invoke("getPostureFamily")
        own["robotIsWakeUp"] = lambda: self.nao.services["ALMotion"].invoke("robotIsWakeUp")
        own["BatteryChargeChanged"] = lambda: round(100.0 * _BATTERY["Charge"])
        own["DCM/Time"] = lambda: int(1000.0 * self.nao.clock.now)
        return own

    def _torso_angle(self, axis: int) -> float:
        """Roll, pitch or yaw of the torso in the world, as its inertial sensor shows them at rest [rad]."""
        return float(position6d(self.nao.base.torso(self.nao.joints.q()))[3 + axis])

    def _acceleration(self, axis: int) -> float:
        """What an accelerometer in the torso shows at rest: gravity, upwards [m/s²]."""
        return _GRAVITY * float(self.nao.base.vertical(self.nao.joints.q())[axis])


def _key(key: object) -> str:
    name = arguments.text(key, "key")
    if not name:
        raise BadArgument("key must not be empty")
    return name
