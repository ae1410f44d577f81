"""ALMemory with the robot's keys and events, and ALTouch and ALSonar, whose sensors are keys."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Annotated, Any

from nao_kin.errors import BadArgument, UnknownName
from nao_kin.naoqi.conventions import position6d
from nao_kin.naoqi.virtual import arguments
from nao_kin.naoqi.virtual.arguments import Entries, Text
from nao_kin.naoqi.virtual.engine import Call
from nao_kin.naoqi.virtual.machine import Machine
from nao_kin.naoqi.virtual.service import Service

# --- The robot's own keys in ALMemory: switches with their events, sonars, and constants.
#
# Sources: Aldebaran documentation 2.1, actuator and sensor list of NAO
# (doc.aldebaran.com/2-1/family/nao_dcm/actuator_sensor_names.html), ALSensors, ALTouch, ALSonar and ALFsr; the short
# names of the inertial sensor are those of 1.14.

DEVICE = "Device/SubDeviceList/"
SENSOR = "/Sensor/Value"

# Switches and touch sensors → their events, and ALTouch's name of the part of the body.
SWITCHES: Mapping[str, tuple[str, str]] = {
    "Head/Touch/Front": ("FrontTactilTouched", "Head"),
    "Head/Touch/Middle": ("MiddleTactilTouched", "Head"),
    "Head/Touch/Rear": ("RearTactilTouched", "Head"),
    "LHand/Touch/Left": ("HandLeftLeftTouched", "LArm"),
    "LHand/Touch/Back": ("HandLeftBackTouched", "LArm"),
    "LHand/Touch/Right": ("HandLeftRightTouched", "LArm"),
    "RHand/Touch/Left": ("HandRightLeftTouched", "RArm"),
    "RHand/Touch/Back": ("HandRightBackTouched", "RArm"),
    "RHand/Touch/Right": ("HandRightRightTouched", "RArm"),
    "LFoot/Bumper/Left": ("LeftBumperPressed", "LLeg"),
    "LFoot/Bumper/Right": ("LeftBumperPressed", "LLeg"),
    "RFoot/Bumper/Left": ("RightBumperPressed", "RLeg"),
    "RFoot/Bumper/Right": ("RightBumperPressed", "RLeg"),
    "ChestBoard/Button": ("ChestButtonPressed", "Torso"),
}
SWITCH_EVENTS = tuple(dict.fromkeys(event for event, _ in SWITCHES.values()))

SONARS = ("Left", "Right")
_ECHOES = ("", *map(str, range(1, 10)))
_NO_ECHO = 2.55  # the range of a sonar [m]

_IDLE_TEMPERATURE = 38.0  # [°C]
_PER_FOOT = "FrontLeft FrontRight RearLeft RearRight TotalWeight CenterOfPressure/X CenterOfPressure/Y".split()
_GYROSCOPES = "GyroscopeX GyroscopeY GyroscopeZ GyrX GyrY GyrRef".split()


def sonar_key(side: str) -> str:
    """Return the key of the nearest echo on a side, "Left" or "Right"."""
    return f"{DEVICE}US/{side}{SENSOR}"


def constants(joints: Iterable[str]) -> dict[str, Any]:
    """Return the keys with constant values: nothing has weight, uses current or warms up."""
    values: dict[str, Any] = {f"{DEVICE}{switch}{SENSOR}": 0.0 for switch in SWITCHES}
    values |= {f"{sonar_key(side)}{echo}": _NO_ECHO for side in SONARS for echo in _ECHOES}
    values |= {f"{DEVICE}{foot}/FSR/{place}{SENSOR}": 0.0 for foot in ("LFoot", "RFoot") for place in _PER_FOOT}
    values |= {f"{DEVICE}InertialSensor/{name}{SENSOR}": 0.0 for name in _GYROSCOPES}
    for joint in joints:
        values[f"{DEVICE}{joint}/Temperature{SENSOR}"] = _IDLE_TEMPERATURE
        values[f"{DEVICE}{joint}/Temperature/Sensor/Status"] = 0
        values[f"{DEVICE}{joint}/ElectricCurrent{SENSOR}"] = 0.0
    return values | {
        f"{DEVICE}US/Actuator/Value": 0.0,
        f"{DEVICE}Head/Temperature{SENSOR}": _IDLE_TEMPERATURE,
        f"{DEVICE}Battery/Charge{SENSOR}": 1.0,
        f"{DEVICE}Battery/Current{SENSOR}": -0.5,
        f"{DEVICE}Battery/Temperature{SENSOR}": 35.0,
        "leftFootTotalWeight": 0.0,
        "rightFootTotalWeight": 0.0,
    }


# --- ALMemory: values by key, and events.


def _key(value: object, what: str) -> str:
    if not arguments.text(value, what):
        raise BadArgument(f"{what} must not be empty")
    return str(value)


Key = Annotated[str, _key]
# A quantity of a joint → its device and sensor or actuator in keys.
_QUANTITIES = {"sensor": "Position/Sensor", "command": "Position/Actuator", "stiffness": "Hardness/Actuator"}
_GRAVITY = 9.81  # m/s²


class Subscriber:
    """The result of `ALMemory.subscriber`, which reports every value that is raised under its key."""

    def __init__(self, memory: ALMemory, key: str) -> None:
        self.key = key
        self._memory = memory

    def connect(self, callback: Callable[[Any], object]) -> int:
        """Call `callback` with every value from now on; return a number for `disconnect`."""
        with self._memory.nao.monitor:
            number = next(self._memory.numbers)
            self._memory.listening.setdefault(self.key, {})[number] = callback
        return number

    def disconnect(self, number: int) -> bool:
        """Remove a callback; return whether there was one with this number."""
        with self._memory.nao.monitor:
            listening = self._memory.listening.get(self.key, {})
            known = listening.pop(number, None) is not None
            if not listening:
                self._memory.listening.pop(self.key, None)
        return known


class ALMemory(Service):
    """Values by key, and events.

    The robot's own keys are evaluated when they are read. These follow the robot: for each joint
    `Device/SubDeviceList/<joint>/Position/Sensor/Value`, `…/Position/Actuator/Value` and `…/Hardness/Actuator/Value`;
    the torso's angles (AngleX, AngleY, AngleZ) and gravity in its frame (AccelerometerX …) of the inertial
    sensor; footContact, leftFootContact and rightFootContact; postures; `robotIsWakeUp`; `DCM/Time`. RHipYawPitch has
    the values of LHipYawPitch. The other keys are constant.

    An inserted value replaces the robot's own until it is removed. ALTouch and ALSonar sense a value that is inserted
    under the key of a switch or a sonar, and raise their events.
    """

    name = "ALMemory"

    def __init__(self, nao: Machine) -> None:
        super().__init__(nao)
        self._values: dict[str, Any] = {}
        self._events: set[str] = {*SWITCH_EVENTS, "TouchChanged"}
        self._times: dict[str, float] = {}  # robot time of each stored value
        # Event → number of a callback, or name of a service that subscribed → what to call with the value.
        self.listening: dict[str, dict[int | str, Callable[[Any], object]]] = {}
        self.numbers = itertools.count(1)
        self.module_called: Callable[[str, str, str, Any, str], object] | None = None
        self._own = self._own_keys()

    # --- values ---------------------------------------------------------------------------------------------------

    def getData(self, key: Text, iDummy: Any = 0) -> Any:
        """The value of a key; an error for an unknown key. The second argument of old scripts is ignored."""
        return self._value(key)

    def getListData(self, keyList: Entries) -> list[Any]:
        """The values of several keys at one moment; None for an unknown key."""
        keys = [arguments.text(key, "key") for key in keyList]
        return [self._value(key) if key in self._values or key in self._own else None for key in keys]

    def insertData(self, key: Key, data: Any) -> None:
        """Store a value under a key; only switches and sonars raise events."""
        self._keep(key, data)

    def insertListData(self, pairs: Any) -> None:
        """Store several values: a list of [key, value]."""
        for key, value in arguments.pairs(pairs, "pairs"):
            self._keep(_key(key, "key"), value)

    def removeData(self, key: Text) -> None:
        """Remove an inserted value, so that the robot's own is read again; an error for an unknown key."""
        if key not in self._values:
            raise self._unknown(key)
        del self._values[key], self._times[key]
        self._sense(key)

    def getDataList(self, filter: Text = "") -> list[str]:
        """All keys that contain a text, in alphabetical order."""
        return sorted(key for key in {*self._values, *self._own} if filter in key)

    getDataListName = getDataList

    def getDataOnChange(self, key: Key, iDummy: Any = 0) -> Call:
        """Wait for the next event of this name, and return its value."""
        wanted, waiting = Subscriber(self, key), Call()
        number = wanted.connect(waiting.finish)
        waiting.add_done_callback(lambda _: wanted.disconnect(number))
        return waiting

    def getTimestamp(self, key: Text) -> list[Any]:
        """[value, seconds, microseconds] of a key, in the robot's time; a value of the robot itself is of now."""
        seconds, microseconds = divmod(round(1e6 * self._times.get(key, self.nao.clock.now)), 1_000_000)
        return [self._value(key), seconds, microseconds]

    # --- events ---------------------------------------------------------------------------------------------------

    def declareEvent(self, eventName: Key, extractorName: Any = "") -> None:
        """Add an event to the list of events before it is raised."""
        self._events.add(eventName)

    def getEventList(self) -> list[str]:
        """Names of the declared or raised events, in alphabetical order."""
        return sorted(self._events)

    def raiseEvent(self, name: Key, value: Any) -> None:
        """Store a value under a key, and notify the subscribers."""
        self._keep(name, value)
        self._raise(name, value)

    raiseMicroEvent = raiseEvent

    def subscriber(self, eventName: Key) -> Subscriber:
        """An object with a `signal` to connect to."""
        return Subscriber(self, eventName)

    def subscribeToEvent(self, name: Key, callbackModule: Text, callbackMethod: Text, *more: Any) -> None:
        """Call a method of a service with key, value and message whenever the event is raised.

        Four arguments are key, service, message and method; with three, the message is the service's name.
        """
        if len(more) > 1:
            raise BadArgument("takes an event, a service, optionally a message, and a method")
        function = arguments.text(more[0], "callbackMethod") if more else callbackMethod
        note = callbackMethod if more else callbackModule
        self._events.add(name)
        calling = partial(self._call_module, callbackModule, function, name, note)
        self.listening.setdefault(name, {})[callbackModule] = calling

    subscribeToMicroEvent = subscribeToEvent

    def unsubscribeToEvent(self, name: Key, callbackModule: Text) -> None:
        """End the calls of a service at an event."""
        if self.listening.get(name, {}).pop(callbackModule, None) is None:
            raise BadArgument(f"{callbackModule} has not subscribed to {name}")

    unsubscribeToMicroEvent = unsubscribeToEvent

    def _announce(self, key: str, value: Any) -> None:
        """Raise an event of the robot; the values of the robot's own keys are not stored."""
        if key not in self._own:
            self._store(key, value)
        self._raise(key, value)

    # --- inside ---------------------------------------------------------------------------------------------------

    def _keep(self, key: str, value: Any) -> None:
        self._store(key, value)
        self._sense(key)

    def _store(self, key: str, value: Any) -> None:
        self._values[key], self._times[key] = value, self.nao.clock.now

    def _sense(self, key: str) -> None:
        """Notify the sensors of a new value under a key of the robot."""
        if key in self._own:
            for service in ("ALTouch", "ALSonar"):
                self.nao.services[service]._sensed(key, self._value(key))

    def _raise(self, key: str, value: Any) -> None:
        self._events.add(key)
        for callback in self.listening.get(key, {}).values():
            self.nao.monitor.later(partial(callback, value))

    def _call_module(self, module: str, function: str, key: str, message: str, value: Any) -> None:
        if self.module_called is not None:
            self.module_called(module, function, key, value, message)

    def _value(self, key: str) -> Any:
        if key in self._values:
            return self._values[key]
        if key in self._own:
            value = self._own[key]
            return value() if callable(value) else value
        raise self._unknown(key)

    def _unknown(self, key: str) -> UnknownName:
        return UnknownName("key", key, tuple(sorted({*self._values, *self._own})))

    def _own_keys(self) -> dict[str, Any]:
        """Return the robot's own keys, each with a constant or with a function that returns its value."""
        joints, base = self.nao.joints, self.nao.base
        own = constants(joints.column)
        for joint, column in joints.column.items():
            for quantity, place in _QUANTITIES.items():
                own[f"{DEVICE}{joint}/{place}/Value"] = lambda of=quantity, at=column: float(getattr(joints, of)[at])
        for event in SWITCH_EVENTS:
            own[event] = lambda event=event: self.nao.services["ALTouch"]._is_raised(event)
        # The inertial sensor at rest: the torso's roll, pitch and yaw in the world [rad], and gravity, upwards [m/s²].
        for axis, letter in enumerate("XYZ"):
            place = f"{DEVICE}InertialSensor"
            own[f"{place}/Angle{letter}/Sensor/Value"] = lambda at=axis: float(
                position6d(base.torso(joints.q()))[3 + at]
            )
            for quantity in ("Accelerometer", "Acc"):
                own[f"{place}/{quantity}{letter}/Sensor/Value"] = lambda at=axis: (
                    _GRAVITY * float(base.vertical(joints.q())[at])
                )
        return own | {
            "footContact": lambda: self._contact("LLeg") or self._contact("RLeg"),
            "leftFootContact": partial(self._contact, "LLeg"),
            "rightFootContact": partial(self._contact, "RLeg"),
            "PostureChanged": lambda: self.nao.services["ALRobotPosture"].invoke("getPosture"),
            "PostureFamilyChanged": lambda: self.nao.services["ALRobotPosture"].invoke("getPostureFamily"),
            "robotIsWakeUp": lambda: self.nao.services["ALMotion"].invoke("robotIsWakeUp"),
            "BatteryChargeChanged": lambda: self.nao.services["ALBattery"].invoke("getBatteryCharge"),
            "DCM/Time": lambda: int(1000.0 * self.nao.clock.now),
        }

    def _contact(self, foot: str) -> bool:
        """Return whether the robot stands with this sole on the floor."""
        return self.nao.base.is_down(foot, self.nao.joints.q())


# --- ALTouch and ALSonar, whose sensors are keys of ALMemory.

_NEAR = 0.5  # an obstacle nearer than this is detected [m]


class ALTouch(Service):
    """Bumpers, the chest button, and the touch sensors of head and hands.

    All are released until a value is inserted in ALMemory under a sensor's key. Each change raises the sensor's event
    (FrontTactilTouched …: 1.0 or 0.0) and TouchChanged, with [name, pressed] of the part of the body and of the sensor.
    """

    name = "ALTouch"

    def __init__(self, nao: Machine) -> None:
        super().__init__(nao)
        self._pressed = dict.fromkeys(SWITCHES, False)

    def getSensorList(self) -> list[str]:
        """Names of all sensors."""
        return list(self._pressed)

    def getStatus(self) -> list[list[Any]]:
        """[name, pressed] of each sensor."""
        return [[sensor, pressed] for sensor, pressed in self._pressed.items()]

    def _is_raised(self, event: str) -> float:
        """Return 1.0 while a sensor of this event is pressed, else 0.0."""
        return float(any(self._pressed[sensor] for sensor, (raised, _) in SWITCHES.items() if raised == event))

    def _sensed(self, key: str, value: Any) -> None:
        """Update a sensor from its new value in ALMemory."""
        sensor = key.removeprefix(DEVICE).removesuffix(SENSOR)
        pressed = isinstance(value, (int, float)) and value > 0.5
        if self._pressed.get(sensor, pressed) == pressed:
            return
        event, part = SWITCHES[sensor]
        before = self._is_raised(event)
        self._pressed[sensor] = pressed
        if self._is_raised(event) != before:
            self.nao.announce(event, self._is_raised(event))
        self.nao.announce("TouchChanged", [[part, pressed], [sensor, pressed]])


class ALSonar(Service):
    """The two sonars; ALMemory's keys Device/SubDeviceList/US/Left/Sensor/Value and …/Right/… hold their distances.

    While a script is subscribed, each inserted distance raises SonarLeftDetected or SonarRightDetected if it is below
    0.5 m, else SonarLeftNothingDetected or SonarRightNothingDetected. The value of the event is the distance.
    """

    name = "ALSonar"

    def __init__(self, nao: Machine) -> None:
        super().__init__(nao)
        self._subscribers: list[str] = []

    def subscribe(self, name: Text, period: Any = 500, precision: Any = 0.0) -> None:
        """Switch the sonars on; period and precision are ignored."""
        if name not in self._subscribers:
            self._subscribers.append(name)

    def unsubscribe(self, name: Text) -> None:
        """Switch the sonars off after the last subscriber has left."""
        if name not in self._subscribers:
            raise BadArgument(f"{name} has not subscribed")
        self._subscribers.remove(name)

    def getSubscribersInfo(self) -> list[list[Any]]:
        """[name, period, precision] of each subscriber."""
        return [[name, 500, 0.0] for name in self._subscribers]

    def _sensed(self, key: str, value: Any) -> None:
        """Raise the event of a new value in ALMemory."""
        for side in SONARS if self._subscribers and isinstance(value, (int, float)) else ():
            if key == sonar_key(side):
                self.nao.announce(f"Sonar{side}{'' if value < _NEAR else 'Nothing'}Detected", float(value))
