"""Keys of the robot's own in ALMemory: switches with their events, sonars, and what is constant here.

Sources: Aldebaran documentation 2.1, actuator and sensor list of NAO
(doc.aldebaran.com/2-1/family/nao_dcm/actuator_sensor_names.html), ALSensors, ALTouch, ALSonar and ALFsr; the short
names of the inertial sensor are those of 1.14.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

DEVICE = "Device/SubDeviceList/"
SENSOR = "/Sensor/Value"

# Switches and touch sensors → the event that each raises, and the part of the body that ALTouch names.
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
_NO_ECHO = 2.55  # the farthest that a sonar sees [m]

_CALM = 38.0  # degrees Celsius of what has nothing to do
_PER_FOOT = "FrontLeft FrontRight RearLeft RearRight TotalWeight CenterOfPressure/X CenterOfPressure/Y".split()
_GYROSCOPES = "GyroscopeX GyroscopeY GyroscopeZ GyrX GyrY GyrRef".split()


def sonar_key(side: str) -> str:
    """The key of the nearest echo on a side, "Left" or "Right"."""
    return f"{DEVICE}US/{side}{SENSOR}"


def constants(joints: Iterable[str]) -> dict[str, Any]:
    """Each key whose value nothing here changes, with this value; nothing has weight, works or warms up."""
    found: dict[str, Any] = {f"{DEVICE}{switch}{SENSOR}": 0.0 for switch in SWITCHES}
    found |= {f"{sonar_key(side)}{echo}": _NO_ECHO for side in SONARS for echo in _ECHOES}
    found |= {f"{DEVICE}{foot}/FSR/{place}{SENSOR}": 0.0 for foot in ("LFoot", "RFoot") for place in _PER_FOOT}
    found |= {f"{DEVICE}InertialSensor/{name}{SENSOR}": 0.0 for name in _GYROSCOPES}
    for joint in joints:
        found[f"{DEVICE}{joint}/Temperature{SENSOR}"] = _CALM
        found[f"{DEVICE}{joint}/Temperature/Sensor/Status"] = 0
        found[f"{DEVICE}{joint}/ElectricCurrent{SENSOR}"] = 0.0
    return found | {
        f"{DEVICE}US/Actuator/Value": 0.0,
        f"{DEVICE}Head/Temperature{SENSOR}": _CALM,
        f"{DEVICE}Battery/Charge{SENSOR}": 1.0,
        f"{DEVICE}Battery/Current{SENSOR}": -0.5,
        f"{DEVICE}Battery/Temperature{SENSOR}": 35.0,
        "leftFootTotalWeight": 0.0,
        "rightFootTotalWeight": 0.0,
    }
