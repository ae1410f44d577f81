"""ALLeds and ALTextToSpeech."""

from __future__ import annotations

import itertools
import math
import re
from collections import deque
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from typing import Annotated, Any

from nao_kin._core.text import abbreviated
from nao_kin.errors import BadArgument, UnknownName
from nao_kin.naoqi.virtual import arguments
from nao_kin.naoqi.virtual.arguments import Delay, Duration, Entries, Fraction, Text, one_of
from nao_kin.naoqi.virtual.engine import Call
from nao_kin.naoqi.virtual.machine import Machine
from nao_kin.naoqi.virtual.service import Service, stored

# --- Names of a NAO's LEDs and of their groups.
#
# Source: Aldebaran documentation 2.5, LEDs of NAO V5, V4 and V3.3
# (doc.aldebaran.com/2-5/family/robots/leds_robot.html).

CHANNELS = ("Red", "Green", "Blue")
LEFT_EYE = tuple(f"FaceLedLeft{number}" for number in range(8))
RIGHT_EYE = tuple(f"FaceLedRight{number}" for number in range(8))
LEFT_EAR = tuple(f"LeftEarLed{number}" for number in range(1, 11))
RIGHT_EAR = tuple(f"RightEarLed{number}" for number in range(1, 11))
BRAIN = tuple(f"Brain{number}" for number in range(12))
CHEST, FEET = "ChestLeds", ("LeftFootLeds", "RightFootLeds")
# LEDs with one colour only: blue in the ears, white on the head.
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
    """Return NAOqi's groups and alternative names of LEDs, with their LEDs."""
    eyes, ears = LEFT_EYE + RIGHT_EYE, LEFT_EAR + RIGHT_EAR
    leds_of: dict[str, tuple[str, ...]] = {
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
    # The eyes' LEDs in pairs, and by their alternative names, which count backwards in the right eye.
    for number, (left, right) in enumerate(zip(LEFT_EYE, RIGHT_EYE, strict=True)):
        leds_of |= {f"FaceLed{number}": (left, right), f"LeftFaceLed{number + 1}": (left,)}
        leds_of[f"RightFaceLed{8 - number}"] = (right,)
    return {name: tuple((led, None) for led in leds) for name, leds in leds_of.items()}


def actuators() -> dict[str, Part]:
    """Return the LEDs by their actuators' names in ALMemory and the DCM, without prefix and "/Actuator/Value"."""
    parts: dict[str, Part] = {}
    for channel, colour in enumerate(CHANNELS):
        for number in range(8):
            parts[f"Face/Led/{colour}/Left/{(45 - 45 * number) % 360}Deg"] = LEFT_EYE[number], channel
            parts[f"Face/Led/{colour}/Right/{315 - 45 * number}Deg"] = RIGHT_EYE[number], channel
        for place, led in zip(("ChestBoard", "LFoot", "RFoot"), (CHEST, *FEET), strict=True):
            parts[f"{place}/Led/{colour}"] = led, channel
    for number in range(10):
        parts[f"Ears/Led/Left/{36 * number}Deg"] = LEFT_EAR[number], None
        parts[f"Ears/Led/Right/{36 * number}Deg"] = RIGHT_EAR[number], None
    for place, led in zip(_HEAD, BRAIN, strict=True):
        parts[f"Head/Led/{place}"] = led, None
    return parts


# NAOqi's name of each LED with a shape in the viewer → the viewer's name; ears and head have none.
_LIGHTS: Mapping[str, str] = {
    **{f"FaceLed{side}{number}": f"{side}Eye{number}" for side in ("Left", "Right") for number in range(8)},
    "ChestLeds": "Chest",
    "LeftFootLeds": "LeftFoot",
    "RightFootLeds": "RightFoot",
}
Colour = tuple[float, float, float]


def light_colours(leds: Mapping[str, Colour]) -> dict[str, Colour]:
    """Return colours of LEDs for `Viewer.show_lights`, without the LEDs in the ears and on the head.

        viewer.show_lights(nk.naoqi.light_colours(robot.state().leds))

    Args:
        leds: name of each LED in ALLeds → red, green, blue from 0 to 1.

    Examples:
        >>> nk.naoqi.light_colours({"FaceLedRight0": (1.0, 0.0, 0.0)})
        {'RightEye0': (1.0, 0.0, 0.0)}
    """
    return {_LIGHTS[led]: colour for led, colour in leds.items() if led in _LIGHTS}


# --- ALLeds: the lamps of eyes, ears, chest, feet and head.

_SUFFIX = "/Actuator/Value"
_PREFIX = "Device/SubDeviceList/"
_OFF_ON = (0.0, 1.0)
_NAMES = ("black", "blue", "green", "cyan", "red", "magenta", "yellow", "white")
# Red, green and blue of each colour: the binary numbers from 000 to 111.
_NAMED: dict[str, Colour] = dict(zip(_NAMES, itertools.product(_OFF_ON, _OFF_ON, _OFF_ON), strict=True))
_INITIAL: dict[str, Colour] = dict.fromkeys(ALL, (1.0, 1.0, 1.0)) | dict.fromkeys(BLUE, (0.0, 0.0, 1.0))
_STEPS_PER_SECOND = 20
_MAX_FRAMES = 10_000


class ALLeds(Service):
    """The LEDs. The watcher gets an `Event` of kind "leds" (name → r, g, b from 0 to 1) for new colours.

    Groups: AllLeds, FaceLeds, LeftFaceLeds, RightFaceLeds, EarLeds, LeftEarLeds, RightEarLeds, BrainLeds, ChestLeds,
    FeetLeds, LeftFootLeds, RightFootLeds, FaceLed0 to FaceLed7 for one LED of each eye, and every single LED. With
    Red, Green or Blue at the end, a name means one channel, as in FaceLedsRed. The actuators' names in ALMemory are
    accepted too, such as Face/Led/Red/Left/0Deg/Actuator/Value. The ears are only blue and the head only white: they
    show the brightest channel.

    The last call for an LED has priority: it takes the LED from a running fade or effect, which continues with its
    other LEDs. `colours` has the r, g, b of each LED.
    """

    name = "ALLeds"

    def __init__(self, nao: Machine) -> None:
        super().__init__(nao)
        self._groups = groups()
        self._actuators = actuators()
        self.colours = dict(_INITIAL)
        # The last call for each LED; earlier effects no longer change it.
        self._owners: dict[str, object] = {}

    # --- groups ---------------------------------------------------------------------------------------------------

    def listGroups(self) -> list[str]:
        """Names of all groups."""
        return sorted([*self._groups, CHEST, *FEET])

    def listGroup(self, groupName: Any) -> list[str]:
        """Names of the LEDs of a group."""
        return list(dict.fromkeys(led for led, _ in self._parts(groupName)))

    def listLEDs(self) -> list[str]:
        """Names of all LEDs."""
        return list(self.colours)

    listLED = listLEDs

    def createGroup(self, groupName: Text, ledNames: Entries) -> None:
        """Make a group of LEDs or groups."""
        if groupName in self.colours or groupName in groups():
            raise BadArgument(f"{groupName} already exists")
        self._groups[groupName] = tuple(dict.fromkeys(part for each in ledNames for part in self._parts(each)))

    # --- light ----------------------------------------------------------------------------------------------------

    def on(self, name: Any) -> None:
        """Light an LED or group fully, in white or in the only colour of the LED."""
        self._fade(self._parts(name), (1.0, 1.0, 1.0))

    def off(self, name: Any) -> None:
        """Darken an LED or group."""
        self._fade(self._parts(name), (0.0, 0.0, 0.0))

    def reset(self, name: Any) -> None:
        """Set an LED or group to its initial colours."""
        self._play([({led: _INITIAL[led] for led, _ in self._parts(name)}, 0.0)])

    def setIntensity(self, name: Any, intensity: Fraction) -> None:
        """Set the brightness of an LED or group, from 0 to 1: white, or the channel at the end of its name."""
        self._fade(self._parts(name), (intensity,) * 3)

    def getIntensity(self, name: Any) -> list[float]:
        """[r, g, b] of the first LED of an LED or group, from 0 to 1."""
        return list(self.colours[self._parts(name)[0][0]])

    def fade(self, name: Any, intensity: Fraction, duration: Delay) -> Call:
        """Fade an LED or group to a brightness in some seconds; returns at the end."""
        return self._fade(self._parts(name), (intensity,) * 3, duration)

    def fadeRGB(self, name: Any, *colour: Any) -> Call:
        """Fade an LED or group to a colour in some seconds; returns at the end.

        The colour is 0x00RRGGBB, a name, or three numbers from 0 to 1; the seconds follow.
        """
        parts = self._parts(name)
        if len(colour) not in (2, 4):
            count = len(colour) + 1
            raise BadArgument(f"takes name, rgb, seconds or name, red, green, blue, seconds, got {count} arguments")
        if len(colour) == 2:
            r, g, b = _colour(colour[0], "rgb")
        else:
            r, g, b = map(arguments.fraction, colour, ("red", "green", "blue"))
        return self._fade(parts, (r, g, b), arguments.duration(colour[-1], "duration", zero=True))

    def fadeListRGB(self, name: Any, rgbList: Entries, timeList: Any) -> Call:
        """Fade an LED or group through colours at times from now; returns at the end."""
        parts, colours = self._parts(name), [_colour(value, "rgb") for value in rgbList]
        times = arguments.list_each(timeList, ("LEDs",), "times")
        arguments.entries(times[0], "timeList", len(colours))
        arguments.check_times(times, ("LEDs",))
        frames = [(self._with(parts, colour), float(at)) for colour, at in zip(colours, times[0], strict=True)]
        return self._play(frames)

    def rasta(self, duration: Duration) -> Call:
        """Show green, yellow and red in the eyes for some seconds; returns at the end."""
        return self._cycle(("green", "yellow", "red"), duration)

    def randomEyes(self, duration: Duration) -> Call:
        """Show a fixed sequence of colours in the eyes for some seconds; returns at the end."""
        return self._cycle(("cyan", "magenta", "yellow", "blue", "green", "red"), duration)

    def rotateEyes(self, rgb: Any, timeForRotation: Duration, totalDuration: Delay) -> Call:
        """Rotate one lit LED in each eye for some seconds; returns at the end."""
        colour, step = _colour(rgb, "rgb"), timeForRotation / 8
        count = min(math.ceil(totalDuration / timeForRotation * 8), _MAX_FRAMES)
        return self._eyes(lambda i, led: colour if led == i % 8 else (0.0, 0.0, 0.0), count, step, totalDuration)

    # --- inside ---------------------------------------------------------------------------------------------------

    def _parts(self, name: Any) -> tuple[Part, ...]:
        """Return the LEDs of a name, each with its channel."""
        wanted = arguments.text(name, "name")
        actuator = self._actuators.get(wanted.removeprefix(_PREFIX).removesuffix(_SUFFIX))
        if actuator is not None:
            return (actuator,)
        for candidate, channel in ((wanted, None), *((wanted.removesuffix(c), i) for i, c in enumerate(CHANNELS))):
            parts = ((candidate, None),) if candidate in self.colours else self._groups.get(candidate)
            if parts is not None:
                return parts if channel is None else tuple((led, channel) for led, _ in parts)
        raise UnknownName("LED or group", wanted, (*self._groups, *self.colours))

    def _with(self, parts: tuple[Part, ...], colour: Colour) -> dict[str, Colour]:
        """Return the colours of LEDs after some or all of their channels are set to those of a colour."""
        colours: dict[str, Colour] = {}
        for led, channel in parts:
            mixed = list(colours.get(led, self.colours[led]))
            for index in range(3) if channel is None else (channel,):
                mixed[index] = colour[index]
            colours[led] = (mixed[0], mixed[1], mixed[2])
        return colours

    def _write(self, colours: dict[str, Colour]) -> None:
        for led, colour in colours.items():
            light = max(colour)
            self.colours[led] = (0.0, 0.0, light) if led in BLUE else (light,) * 3 if led in WHITE else colour
        self.nao.log.change("leds", {led: self.colours[led] for led in colours})

    def _fade(self, parts: tuple[Part, ...], colour: Colour, seconds: float = 0.0) -> Call:
        """Fade LEDs to a colour; set it immediately for zero seconds."""
        return self._play([(self._with(parts, colour), seconds)])

    def _cycle(self, names: tuple[str, ...], seconds: float) -> Call:
        """Show one colour after the other in the eyes, four per second, and then the previous colours."""
        count = min(math.ceil(seconds * 4), _MAX_FRAMES)
        return self._eyes(lambda i, _: _NAMED[names[i % len(names)]], count, seconds / count, seconds)

    def _eyes(self, colour: Callable[[int, int], Colour], count: int, step: float, seconds: float) -> Call:
        """Show frames in the eyes every `step` seconds, by frame and LED number, and then the previous colours."""
        before = {led: self.colours[led] for led, _ in self._groups["FaceLeds"]}
        frames = [({led: colour(i, int(led[-1])) for led in before}, i * step) for i in range(count)]
        return self._play([*frames, (before, seconds)], smooth=False)

    def _play(self, frames: list[tuple[dict[str, Colour], float]], *, smooth: bool = True) -> Call:
        """Show colours at times from now, interpolated if `smooth`; the call ends with the last colour."""
        begin = self.nao.clock.now
        call = Call(lambda: call.finish())
        start = {led: self.colours[led] for led in frames[-1][0]}
        last = 0.0
        self._owners |= dict.fromkeys(start, call)

        def write(colours: dict[str, Colour]) -> None:
            owned = {led: colour for led, colour in colours.items() if self._owners[led] is call}
            if owned:
                self._write(owned)

        def show(index: int) -> None:
            nonlocal start, last
            if call.done():
                return
            now = self.nao.clock.now - begin
            while index < len(frames) and now >= frames[index][1] - 1e-9:
                write(frames[index][0])
                start, last = frames[index]
                index += 1
            if index == len(frames):
                self.nao.monitor.later(call.finish)
                return
            goal, end = frames[index]
            if smooth and now > last:
                share = (now - last) / (end - last)
                write({led: _mixed(start[led], goal[led], share) for led in goal})
            wait = min(1.0 / _STEPS_PER_SECOND, end - now) if smooth else end - now
            self.nao.clock.after(wait, lambda: show(index))

        show(0)
        return call


def _colour(value: Any, what: str) -> Colour:
    """Return a colour from 0x00RRGGBB or a name."""
    if isinstance(value, str):
        return _NAMED[arguments.choice(value, "colour", tuple(_NAMED))]
    number = arguments.whole(value, what)
    if not 0 <= number <= 0xFFFFFFFF:
        raise BadArgument(f"{what} must be 0x00RRGGBB, got {number}")
    return ((number >> 16 & 0xFF) / 255.0, (number >> 8 & 0xFF) / 255.0, (number & 0xFF) / 255.0)


def _mixed(one: Colour, other: Colour, share: float) -> Colour:
    r, g, b = ((1.0 - share) * a + share * c for a, c in zip(one, other, strict=True))
    return (r, g, b)


# --- ALTextToSpeech: speech that takes time, but makes no sound.

# The duration of a text: a pause before it [s], and the number of characters per second at speed 100.
BEFORE_SPEAKING = 0.3
CHARACTERS_PER_SECOND = 14.0
_LANGUAGES = ("English", "French", "German", "Italian", "Spanish", "Japanese", "Chinese")
_language = one_of("language", _LANGUAGES)
_PAUSE = re.compile(r"\\pau=(\d{1,6})\\")
_TAG = re.compile(r"\\[a-zA-Z]+=[^\\]*\\|\\(?:pau|rst|mrk)[^\\]*\\|\^[a-zA-Z]+\([^)]*\)")


def spoken_words(text: str) -> str:
    r"""Return the spoken words of a text for ALTextToSpeech, without tags such as `\rspd=80\` and `^start(animation)`.

    Examples:
        >>> nk.naoqi.spoken_words("^start(animations/Stand/Gestures/Hey_1) Hello")
        'Hello'
    """
    return _TAG.sub("", text).strip()


_body_language = one_of("mode of body language", ("disabled", "random", "contextual"))


class ALTextToSpeech(Service):
    r"""Speaks texts one after the other, without sound: they go to the log and to the watcher.

    A text takes 0.3 s and 1/14 s for each character, scaled by the parameter "speed" (100 is normal), and its
    `\pau=milliseconds\`; other tags take no time. The watcher gets an `Event` of kind "speech" with the text at its
    beginning, and with "" at its end. `saying` is the current text, "" for none.
    """

    name = "ALTextToSpeech"

    def __init__(self, nao: Machine) -> None:
        super().__init__(nao)
        self.saying = ""
        self._queue: deque[tuple[str, Call]] = deque()
        self._timer: Future[Any] | None = None
        zero = "doubleVoice doubleVoiceLevel doubleVoiceTimeShift enableCompression".split()
        self._parameters = {"pitchShift": 1.0} | dict.fromkeys(zero, 0.0)
        self._parameters |= dict.fromkeys(("speed", "defaultVoiceSpeed", "volume", "pitch"), 100.0)

    def say(self, stringToSay: Text, language: Annotated[str, _language] = "") -> Call:
        """Say a text after the previous ones; returns at its end."""
        call = Call(lambda: self._cancel(call))
        self._queue.append((stringToSay, call))
        if self._timer is None:
            self._next()
        return call

    def stopAll(self) -> None:
        """Stop speaking immediately, and drop the pending texts."""
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        waiting, self._queue = self._queue, deque()
        for _, call in waiting:
            self.nao.monitor.later(call.finish)
        self._tell("")

    setLanguage, getLanguage = stored("language", _language, "English")
    setVoice, getVoice = stored("voice", arguments.text, "naoenu")
    setVolume, getVolume = stored("volume", arguments.fraction, 1.0)

    def getAvailableLanguages(self) -> list[str]:
        """The languages that setLanguage accepts."""
        return list(_LANGUAGES)

    def getAvailableVoices(self) -> list[str]:
        """The name of the only voice."""
        return ["naoenu"]

    def setParameter(self, pEffectName: Any, pEffectValue: Any) -> None:
        """Set a parameter; "speed" changes the duration of texts, the others are only stored."""
        name = arguments.choice(pEffectName, "parameter", tuple(self._parameters))
        value = arguments.number(pEffectValue, name)
        if name in ("speed", "defaultVoiceSpeed") and not 50.0 <= value <= 400.0:
            raise BadArgument(f"{name} must be from 50 to 400, got {value:g}")
        self._parameters["speed" if name == "defaultVoiceSpeed" else name] = value

    def getParameter(self, pParameterName: Any) -> float:
        """The stored value of a parameter."""
        return self._parameters[arguments.choice(pParameterName, "parameter", tuple(self._parameters))]

    def resetSpeed(self) -> None:
        """Set the speed to 100."""
        self._parameters["speed"] = 100.0

    def _duration(self, words: str) -> float:
        """Return the duration of a text [s]."""
        pauses = sum(int(milliseconds) for milliseconds in _PAUSE.findall(words)) / 1000.0
        letters = len(spoken_words(words))
        return BEFORE_SPEAKING + pauses + letters / (CHARACTERS_PER_SECOND * self._parameters["speed"] / 100.0)

    def _next(self) -> None:
        """Begin the first text of the queue."""
        words, _ = self._queue[0]
        self._tell(words)
        self.nao.announce("ALTextToSpeech/CurrentSentence", words)
        self.nao.announce("ALTextToSpeech/TextStarted", 1)
        self.nao.announce("ALTextToSpeech/TextDone", 0)
        self.nao.log.write(f"says: {abbreviated(words)}")
        self._timer = self.nao.clock.after(self._duration(words), self._said)

    def _said(self) -> None:
        self._timer = None
        _, call = self._queue.popleft()
        self.nao.monitor.later(call.finish)
        self._tell("")
        self.nao.announce("ALTextToSpeech/TextStarted", 0)
        self.nao.announce("ALTextToSpeech/TextDone", 1)
        if self._queue:
            self._next()

    def _cancel(self, call: Call) -> None:
        with self.nao.monitor:
            if self._queue and self._queue[0][1] is call and self._timer is not None:
                self._timer.cancel()
                self._said()
            else:
                self._queue = deque(entry for entry in self._queue if entry[1] is not call)
                self.nao.monitor.later(call.finish)

    def _tell(self, words: str) -> None:
        self.saying = words
        self.nao.log.change("speech", words)


class ALAnimatedSpeech(Service):
    """Speaks as ALTextToSpeech; gestures, such as `^start(animation)` in a text, are left out."""

    name = "ALAnimatedSpeech"

    def say(self, text: Text, configuration: Any = None) -> Call:
        """Say a text after the previous ones; returns at its end."""
        call: Call = self.nao.services["ALTextToSpeech"].invoke("say", text)
        return call

    setBodyLanguageModeFromStr, getBodyLanguageModeToStr = stored("mode of body language", _body_language, "contextual")


class ALAudioPlayer(Service):
    """Plays no sound: files go to the log, and take no time."""

    name = "ALAudioPlayer"

    def __init__(self, nao: Machine) -> None:
        super().__init__(nao)
        self._files: list[str] = []

    def playFile(self, fileName: Text, volume: Any = 1.0, pan: Any = 0.0) -> None:
        """Name a file in the log."""
        self.nao.log.write(f"plays the sound {abbreviated(fileName)}")

    def loadFile(self, fileName: Text) -> int:
        """Return the number by which `play` plays a file."""
        self._files.append(fileName)
        return len(self._files)

    def play(self, taskId: Any, volume: Any = 1.0, pan: Any = 0.0) -> None:
        """Name a loaded file in the log."""
        number = arguments.whole(taskId, "taskId")
        if not 0 < number <= len(self._files):
            raise BadArgument(f"taskId {number}: no such file is loaded")
        self.playFile(self._files[number - 1])

    def stopAll(self) -> None:
        """End all sounds: there are none here."""

    setMasterVolume, getMasterVolume = stored("volume of sounds", arguments.fraction, 1.0)
