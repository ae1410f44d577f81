"""Names of a NAO's LEDs and of their groups.

Source: Aldebaran documentation 2.5, LEDs of NAO V5, V4 and V3.3 (doc.aldebaran.com/2-5/family/robots/leds_robot.html).
"""

from __future__ import annotations

CHANNELS = ("Red", "Green", "Blue")
LEFT_EYE = tuple(f"FaceLedLeft{number}" for number in range(8))
RIGHT_EYE = tuple(f"FaceLedRight{number}" for number in range(8))
LEFT_EAR = tuple(f"LeftEarLed{number}" for number in range(1, 11))
RIGHT_EAR = tuple(f"RightEarLed{number}" for number in range(1, 11))
BRAIN = tuple(f"Brain{number}" for number in range(12))
CHEST, FEET = "ChestLeds", ("LeftFootLeds", "RightFootLeds")
# Those that have one colour only: blue in the ears, white on the head.
BLUE, WHITE = frozenset({*LEFT_EAR, *RIGHT_EAR}), frozenset(BRAIN)
ALL = (*LEFT_EYE, *RIGHT_EYE, *LEFT_EAR, *RIGHT_EAR, *BRAIN, CHEST, *FEET)

# Places on the head, from Brain0 on.
_HEAD = (
    "Front/Right/1 Front/Right/0 Middle/Right/0 Rear/Right/0 Rear/Right/1 Rear/Right/2 "
    "Rear/Left/2 Rear/Left/1 Rear/Left/0 Middle/Left/0 Front/Left/0 Front/Left/1"
).split()

# One LED, or one channel of it: 0 red, 1 green, 2 blue, None all.
Part = tuple[str, int | None]


def groups() -> dict[str, tuple[Part, ...]]:
    """Every group of NAOqi's, and every other name of a LED, with what it stands for."""
    eyes, ears = LEFT_EYE + RIGHT_EYE, LEFT_EAR + RIGHT_EAR
    found: dict[str, tuple[str, ...]] = {
        "FaceLeds": eyes,
        "LeftFaceLeds": LEFT_EYE,
        "RightFaceLeds": RIGHT_EYE,
        "EarLeds": ears,
        "LeftEarLeds": LEFT_EAR,
        "RightEarLeds": RIGHT_EAR,
        "BrainLeds": BRAIN,
        "FeetLeds": FEET,
        "AllLeds": ALL,
    }
    # The eyes' LEDs in pairs, and by their other names, which count the other way round in the right eye.
    for number, (left, right) in enumerate(zip(LEFT_EYE, RIGHT_EYE, strict=True)):
        found |= {f"FaceLed{number}": (left, right), f"LeftFaceLed{number + 1}": (left,)}
        found[f"RightFaceLed{8 - number}"] = (right,)
    return {name: tuple((led, None) for led in leds) for name, leds in found.items()}


def actuators() -> dict[str, Part]:
    """The names that the actuators have in ALMemory and the DCM, without their prefix and "/Actuator/Value"."""
    found: dict[str, Part] = {}
    for channel, colour in enumerate(CHANNELS):
        for number in range(8):
            found[f"Face/Led/{colour}/Left/{(45 - 45 * number) % 360}Deg"] = LEFT_EYE[number], channel
            found[f"Face/Led/{colour}/Right/{315 - 45 * number}Deg"] = RIGHT_EYE[number], channel
        for place, led in zip(("ChestBoard", "LFoot", "RFoot"), (CHEST, *FEET), strict=True):
            found[f"{place}/Led/{colour}"] = led, channel
    for number in range(10):
        found[f"Ears/Led/Left/{36 * number}Deg"] = LEFT_EAR[number], None
        found[f"Ears/Led/Right/{36 * number}Deg"] = RIGHT_EAR[number], None
    for place, led in zip(_HEAD, BRAIN, strict=True):
        found[f"Head/Led/{place}"] = led, None
    return found
