"""ALTouch and ALSonar: what the robot would feel and hear, as ALMemory's keys say it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from nao_kin.errors import BadArgument
from nao_kin.naoqi.virtual import arguments
from nao_kin.naoqi.virtual.service import Service, method
from nao_kin.naoqi.virtual.services.memory import DEVICE, SENSOR, SONARS, SWITCHES, sonar_key

if TYPE_CHECKING:
    from nao_kin.naoqi.virtual.virtual_nao import VirtualNao


_NEAR = 0.5  # an obstacle nearer than this is detected [m]


class ALTouch(Service):
    """Bumpers, the button of the chest, touch sensors of head and hands.

    All are released until a value is inserted in ALMemory under a sensor's key. Each change raises the event of the
    sensor (FrontTactilTouched …: 1.0 or 0.0) and TouchChanged, with [name, pressed] of the part of the body and of the
    sensor.
    """

    name = "ALTouch"
    absent = ("createALMemoryEvent",)

    def __init__(self, nao: VirtualNao) -> None:
        super().__init__(nao)
        self._pressed = dict.fromkeys(SWITCHES, False)

    @method
    def getSensorList(self) -> list[str]:
        """Names of all sensors."""
        return list(self._pressed)

    @method
    def getStatus(self) -> list[list[Any]]:
        """[name, pressed] of each sensor."""
        return [[sensor, pressed] for sensor, pressed in self._pressed.items()]

    def is_raised(self, event: str) -> float:
        """1.0 while a sensor of an event is pressed, else 0.0."""
        return float(any(self._pressed[sensor] for sensor, (raised, _) in SWITCHES.items() if raised == event))

    def sensed(self, key: str, value: Any) -> None:
        """Take what ALMemory has under a key now."""
        sensor = key.removeprefix(DEVICE).removesuffix(SENSOR)
        pressed = isinstance(value, (int, float)) and value > 0.5
        if self._pressed.get(sensor, pressed) == pressed:
            return
        event, part = SWITCHES[sensor]
        before = self.is_raised(event)
        self._pressed[sensor] = pressed
        if self.is_raised(event) != before:
            self.nao.announce(event, self.is_raised(event))
        self.nao.announce("TouchChanged", [[part, pressed], [sensor, pressed]])


class ALSonar(Service):
    """The two sonars.

    No echo comes until a distance is inserted in ALMemory, under Device/SubDeviceList/US/Left/Sensor/Value or
    …/US/Right/Sensor/Value.

    While somebody subscribes, each inserted distance raises SonarLeftDetected or SonarRightDetected if it is below
    0.5 m, else SonarLeftNothingDetected or SonarRightNothingDetected, with the distance.
    """

    name = "ALSonar"
    absent = tuple("updatePeriod updatePrecision getMyPeriod getMyPrecision getOutputNames getEventList".split())

    def __init__(self, nao: VirtualNao) -> None:
        super().__init__(nao)
        self._subscribers: list[str] = []

    @method
    def subscribe(self, name: Any, period: Any = 500, precision: Any = 0.0) -> None:
        """Switch the sonars on; period and precision count for nothing."""
        subscriber = arguments.text(name, "name")
        if subscriber not in self._subscribers:
            self._subscribers.append(subscriber)

    @method
    def unsubscribe(self, name: Any) -> None:
        """Switch the sonars off, when the last has unsubscribed."""
        subscriber = arguments.text(name, "name")
        if subscriber not in self._subscribers:
            raise BadArgument(f"{subscriber} has not subscribed")
        self._subscribers.remove(subscriber)

    @method
    def getSubscribersInfo(self) -> list[list[Any]]:
        """[name, period, precision] of those who have subscribed."""
        return [[name, 500, 0.0] for name in self._subscribers]

    def sensed(self, key: str, value: Any) -> None:
        """Take what ALMemory has under a key now."""
        for side in SONARS if self._subscribers and isinstance(value, (int, float)) else ():
            if key == sonar_key(side):
                self.nao.announce(f"Sonar{side}{'' if value < _NEAR else 'Nothing'}Detected", float(value))
