"""What of a NAO's LEDs and words a viewer shows: NAOqi's names as the viewer has them."""

from __future__ import annotations

import re
from collections.abc import Mapping

from nao_kin.errors import BadArgument

Colour = tuple[float, float, float]

# NAOqi's name of each LED that the viewer has a shape for → the viewer's; ears and head have none.
_LIGHTS: Mapping[str, str] = {
    **{f"FaceLed{side}{number}": f"{side}Eye{number}" for side in ("Left", "Right") for number in range(8)},
    "ChestLeds": "Chest",
    "LeftFootLeds": "LeftFoot",
    "RightFootLeds": "RightFoot",
}
_TAG = re.compile(r"\\[a-zA-Z]+=[^\\]*\\|\\(?:pau|rst|mrk)[^\\]*\\|\^[a-zA-Z]+\([^)]*\)")


def light_colours(leds: Mapping[str, Colour]) -> dict[str, Colour]:
    """Colours of LEDs as `Viewer.show_lights` takes them; LEDs of the ears and on the head are left out.

        viewer.show_lights(nk.naoqi.light_colours(robot.state().leds))

    Args:
        leds: name of each LED in ALLeds → red, green, blue from 0 to 1.

    Examples:
        >>> nk.naoqi.light_colours({"FaceLedRight0": (1.0, 0.0, 0.0)})
        {'RightEye0': (1.0, 0.0, 0.0)}
    """
    if not isinstance(leds, Mapping):
        raise BadArgument(f"leds must be a mapping, got {type(leds).__name__}")
    return {_LIGHTS[led]: colour for led, colour in leds.items() if led in _LIGHTS}


def spoken_words(text: str) -> str:
    r"""A text for ALTextToSpeech without what is not said: tags such as `\rspd=80\` and `^start(animation)`.

    Examples:
        >>> nk.naoqi.spoken_words("^start(animations/Stand/Gestures/Hey_1) Hello")
        'Hello'
    """
    if not isinstance(text, str):
        raise BadArgument(f"text must be a string, got {type(text).__name__}")
    return _TAG.sub("", text).strip()
