"""ALLeds and ALTextToSpeech."""

from __future__ import annotations

import bisect
import functools
import itertools
import re
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats
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
EYES, EARS = (*LEFT_EYE, *RIGHT_EYE), (*LEFT_EAR, *RIGHT_EAR)
ALL = (*EYES, *EARS, *BRAIN, CHEST, *FEET)
_ROW = {led: row for row, led in enumerate(ALL)}
# LEDs with one colour only: blue in the ears, white on the head.
_BLUE, _WHITE = (np.isin(ALL, leds)[:, None] for leds in (EARS, BRAIN))
_NUMBER_IN_EYE = np.array([[int(led[-1]) if led in EYES else -1] for led in ALL])

# Places on the head, from Brain0 on.
_HEAD = (
    "Front/Right/1 Front/Right/0 Middle/Right/0 Rear/Right/0 Rear/Right/1 Rear/Right/2 "
    "Rear/Left/2 Rear/Left/1 Rear/Left/0 Middle/Left/0 Front/Left/0 Front/Left/1"
).split()

# Which channels of which LEDs, shape (leds, 3).
Mask = NDArray[np.bool_]


@functools.cache
def masks() -> Mapping[str, Mask]:
    """Return the channels of every name: an LED, a group, an alternative name, or an actuator's name in ALMemory.

    Actuators' names lack "Device/SubDeviceList/" and "/Actuator/Value".
    """
    named: dict[str, Mask] = {}

    def add(name: str, leds: Sequence[str], channels: int | slice = slice(None)) -> None:
        named[name] = np.zeros((len(ALL), 3), dtype=np.bool_)
        named[name][[_ROW[led] for led in leds], channels] = True

    leds_of = {"FaceLeds": EYES, "LeftFaceLeds": LEFT_EYE, "RightFaceLeds": RIGHT_EYE, "BrainLeds": BRAIN}
    leds_of |= {"EarLeds": EARS, "LeftEarLeds": LEFT_EAR, "RightEarLeds": RIGHT_EAR, "FeetLeds": FEET, "AllLeds": ALL}
    for name, leds in (leds_of | {led: (led,) for led in ALL}).items():
        add(name, leds)
    # The eyes' LEDs in pairs, and by their alternative names, which count backwards in the right eye.
    for number, (left, right) in enumerate(zip(LEFT_EYE, RIGHT_EYE, strict=True)):
        add(f"FaceLed{number}", (left, right))
        add(f"LeftFaceLed{number + 1}", (left,))
        add(f"RightFaceLed{8 - number}", (right,))
        for channel, colour in enumerate(CHANNELS):
            add(f"Face/Led/{colour}/Left/{(45 - 45 * number) % 360}Deg", (left,), channel)
            add(f"Face/Led/{colour}/Right/{315 - 45 * number}Deg", (right,), channel)
    for place, led in zip(("ChestBoard", "LFoot", "RFoot"), (CHEST, *FEET), strict=True):
        for channel, colour in enumerate(CHANNELS):
            add(f"{place}/Led/{colour}", (led,), channel)
    for number in range(10):
        add(f"Ears/Led/Left/{36 * number}Deg", (LEFT_EAR[number],))
        add(f"Ears/Led/Right/{36 * number}Deg", (RIGHT_EAR[number],))
    for place, led in zip(_HEAD, BRAIN, strict=True):
        add(f"Head/Led/{place}", (led,))
    return named


# NAOqi's name of each LED with a shape in the viewer → the viewer's name; ears and head have none.
_LIGHTS = {led: f"{led[7:-1]}Eye{led[-1]}" for led in EYES} | {led: led.removesuffix("Leds") for led in (CHEST, *FEET)}
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
# The colours of the binary numbers from 000 to 111: red, green and blue.
_NAMED = ("black", "blue", "green", "cyan", "red", "magenta", "yellow", "white")
_INITIAL: Floats = np.where(_BLUE, (0.0, 0.0, 1.0), 1.0)
# The interval between two colours of a fade or an effect, and of an effect's colours [s].
_STEP, _BEAT = 0.05, 0.25


class ALLeds(Service):
    """The LEDs. The watcher gets an `Event` of kind "leds" (name → r, g, b from 0 to 1) for new colours.

    Groups: AllLeds, FaceLeds, LeftFaceLeds, RightFaceLeds, EarLeds, LeftEarLeds, RightEarLeds, BrainLeds, ChestLeds,
    FeetLeds, LeftFootLeds, RightFootLeds, FaceLed0 to FaceLed7 for one LED of each eye, and every single LED. With
    Red, Green or Blue at the end, a name means one channel, as in FaceLedsRed. The actuators' names in ALMemory are
    accepted too, such as Face/Led/Red/Left/0Deg/Actuator/Value. The ears are only blue and the head only white: they
    show the brightest channel.

    The last call for an LED has priority: it takes the LED from a running fade or effect, which continues with its
    other LEDs. `colours` has the r, g, b of each LED, `rgb` the same as an array (leds, 3).
    """

    name = "ALLeds"

    def __init__(self, nao: Machine) -> None:
        super().__init__(nao)
        self._masks = dict(masks())
        self.rgb = _INITIAL.copy()
        # The number of the last call for each LED; earlier calls no longer change it.
        self._caller, self._calls = np.zeros(len(ALL), dtype=np.int64), itertools.count(1)

    @property
    def colours(self) -> dict[str, Colour]:
        """The r, g, b of each LED, from 0 to 1."""
        return {led: (r, g, b) for led, (r, g, b) in zip(ALL, self.rgb.tolist(), strict=True)}

    def listGroups(self) -> list[str]:
        """Names of all groups."""
        single = {*EYES, *EARS, *BRAIN}
        return sorted(name for name in self._masks if "/" not in name and name not in single)

    def createGroup(self, groupName: Text, ledNames: Entries) -> None:
        """Make a group of LEDs or groups."""
        if groupName in masks():
            raise BadArgument(f"{groupName} already exists")
        self._masks[groupName] = np.any([self._mask(name) for name in ledNames], axis=0)

    def on(self, name: Any) -> None:
        """Light an LED or group fully, in white or in the only colour of the LED."""
        self.fade(name, 1.0, 0.0)

    def off(self, name: Any) -> None:
        """Darken an LED or group."""
        self.fade(name, 0.0, 0.0)

    def reset(self, name: Any) -> None:
        """Set an LED or group to its initial colours."""
        self._fade(self._mask(name), [_INITIAL], [0.0])

    def setIntensity(self, name: Any, intensity: Fraction) -> None:
        """Set the brightness of an LED or group, from 0 to 1: white, or the channel at the end of its name."""
        self.fade(name, intensity, 0.0)

    def getIntensity(self, name: Any) -> list[float]:
        """[r, g, b] of the first LED of an LED or group, from 0 to 1."""
        return list(map(float, self.rgb[int(self._mask(name).any(axis=1).argmax())]))

    def fade(self, name: Any, intensity: Fraction, duration: Delay) -> Call:
        """Fade an LED or group to a brightness in some seconds; returns at the end."""
        return self._fade(self._mask(name), [np.full(3, intensity)], [duration])

    def fadeRGB(self, name: Any, *colour: Any) -> Call:
        """Fade an LED or group to a colour in some seconds; returns at the end.

        The colour is 0x00RRGGBB, a name, or three numbers from 0 to 1; the seconds follow.
        """
        if len(colour) not in (2, 4):
            count = len(colour) + 1
            raise BadArgument(f"takes name, rgb, seconds or name, red, green, blue, seconds, got {count} arguments")
        *wanted, seconds = colour
        if len(wanted) == 1:
            rgb = _colour(wanted[0], "rgb")
        else:
            rgb = np.array(list(map(arguments.fraction, wanted, ("red", "green", "blue"))))
        return self._fade(self._mask(name), [rgb], [arguments.duration(seconds, "duration", zero=True)])

    def fadeListRGB(self, name: Any, rgbList: Entries, timeList: Any) -> Call:
        """Fade an LED or group through colours at times from now; returns at the end."""
        times = arguments.list_each(timeList, ("LEDs",), "times")
        arguments.entries(times[0], "timeList", len(rgbList))
        arguments.check_times(times, ("LEDs",))
        return self._fade(self._mask(name), [_colour(value, "rgb") for value in rgbList], times[0].tolist())

    def rasta(self, duration: Duration) -> Call:
        """Show green, yellow and red in the eyes for some seconds; returns at the end."""
        return self._cycle(("green", "yellow", "red"), duration)

    def randomEyes(self, duration: Duration) -> Call:
        """Show a fixed sequence of colours in the eyes for some seconds; returns at the end."""
        return self._cycle(("cyan", "magenta", "yellow", "blue", "green", "red"), duration)

    def rotateEyes(self, rgb: Any, timeForRotation: Duration, totalDuration: Delay) -> Call:
        """Rotate one lit LED in each eye for some seconds; returns at the end."""
        colour = _colour(rgb, "rgb")

        def at(time: float) -> Floats:
            return np.where(int(8.0 * time / timeForRotation) % 8 == _NUMBER_IN_EYE, colour, 0.0)

        return self._eyes(at, totalDuration)

    # --- inside ---------------------------------------------------------------------------------------------------

    def _mask(self, name: Any) -> Mask:
        """Return the channels of a name."""
        wanted = arguments.text(name, "name").removeprefix(_PREFIX).removesuffix(_SUFFIX)
        if wanted in self._masks:
            return self._masks[wanted]
        for channel, colour in enumerate(CHANNELS):
            if wanted.endswith(colour) and wanted.removesuffix(colour) in self._masks:
                return np.asarray(self._masks[wanted.removesuffix(colour)] & (np.arange(3) == channel))
        raise UnknownName("LED or group", wanted, tuple(self._masks))

    def _fade(self, mask: Mask, colours: Sequence[Floats], times: Sequence[float]) -> Call:
        """Fade channels to colours, (3,) or (leds, 3), on straight lines; a time of zero means immediately."""
        keys, when = [self.rgb.copy(), *colours], [0.0, *times]

        def at(time: float) -> Floats:
            key = min(bisect.bisect(when, time), len(times))
            gap = when[key] - when[key - 1]
            share = (time - when[key - 1]) / gap if gap > 0.0 else 1.0
            return np.asarray((1.0 - share) * keys[key - 1] + share * keys[key])

        return self._play(mask, at, times[-1])

    def _cycle(self, names: tuple[str, ...], seconds: float) -> Call:
        return self._eyes(lambda time: _colour(names[int(time / _BEAT) % len(names)], "rgb"), seconds)

    def _eyes(self, at: Callable[[float], Floats], seconds: float) -> Call:
        """Show the colours of an effect in the eyes, and then the previous ones."""
        before = self.rgb.copy()
        return self._play(self._masks["FaceLeds"], lambda time: before if time >= seconds else at(time), seconds)

    def _play(self, mask: Mask, at: Callable[[float], Floats], seconds: float) -> Call:
        """Show colours that are a function of the time from now; the call ends with the last."""
        begin, number = self.nao.clock.now, next(self._calls)
        call = Call(lambda: call.finish())
        self._caller[mask.any(axis=1)] = number

        def show() -> None:
            if call.done():
                return
            time = self.nao.clock.now - begin
            done = time >= seconds - 1e-9
            self._write(mask & (self._caller == number)[:, None], at(seconds if done else time))
            if done:
                self.nao.monitor.later(call.finish)
            else:
                self.nao.clock.after(min(_STEP, seconds - time), show)

        show()
        return call

    def _write(self, mask: Mask, colours: Floats) -> None:
        mixed = np.where(mask, colours, self.rgb)
        light = mixed.max(axis=1, keepdims=True)
        self.rgb = np.where(_BLUE, light * (0.0, 0.0, 1.0), np.where(_WHITE, light, mixed))
        changed = {led: colour for led, colour in self.colours.items() if mask[_ROW[led]].any()}
        if changed:
            self.nao.log.change("leds", changed)


def _colour(value: Any, what: str) -> Floats:
    """Return a colour from 0x00RRGGBB or a name, shape (3,)."""
    if isinstance(value, str):
        bits = _NAMED.index(arguments.choice(value, "colour", _NAMED))
        return np.array([float(bits >> shift & 1) for shift in (2, 1, 0)])
    number = arguments.whole(value, what)
    if not 0 <= number <= 0xFFFFFFFF:
        raise BadArgument(f"{what} must be 0x00RRGGBB, got {number}")
    return np.array([number >> shift & 0xFF for shift in (16, 8, 0)]) / 255.0


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
