"""ALTextToSpeech: words that take time, without a sound."""

from __future__ import annotations

import re
from collections import deque
from typing import TYPE_CHECKING, Any

from nao_kin._core.text import abbreviated
from nao_kin.errors import BadArgument
from nao_kin.naoqi.scripts import spoken_words
from nao_kin.naoqi.virtual import arguments
from nao_kin.naoqi.virtual.engine import Call, Timer
from nao_kin.naoqi.virtual.service import Kept, Service, keeps

if TYPE_CHECKING:
    from nao_kin.naoqi.virtual.virtual_nao import VirtualNao


# How long a text takes: a moment before it, and so many characters a second at speed 100.
BEFORE_SPEAKING = 0.3
CHARACTERS_PER_SECOND = 14.0
_LANGUAGES = ("English", "French", "German", "Italian", "Spanish", "Japanese", "Chinese")
_PAUSE = re.compile(r"\\pau=(\d{1,6})\\")


def _language(value: Any, _: str) -> str:
    return arguments.choice(value, "language", _LANGUAGES)


_SOUNDS = "Choose a language; it sounds like any other here.", "The language chosen; at first English."
_CHOSEN = "Choose a voice; kept.", 'The voice chosen; at first "naoenu".'
_LOUD = "Set the volume, from 0 to 1; kept.", "The volume; at first 1."


@keeps(
    Kept("Language", _SOUNDS[0], "English", ("pLanguage",), _language, read=_SOUNDS[1]),
    Kept("Voice", _CHOSEN[0], "naoenu", ("pVoiceID",), arguments.text, read=_CHOSEN[1]),
    Kept("Volume", _LOUD[0], 1.0, ("volume",), arguments.fraction, read=_LOUD[1]),
)
class ALTextToSpeech(Service):
    r"""Words that are said one text after the other, written to the log and given to watchers.

    There is no voice. A text takes 0.3 s and 1/14 s for each character, more or less by the parameter "speed" (100 is
    as said), and its `\pau=milliseconds\`; other tags take no time. Watchers get a `Change` of kind "speech" with the
    text when it begins, and with "" at its end.

    Attributes:
        saying: the text that is being said; "" for none.
    """

    name = "ALTextToSpeech"
    absent = tuple(
        "sayToFile sayToFileAndPlay addToDictionary deleteFromDictionary enableNotifications disableNotifications "
        "loadVoicePreference getSupportedLanguages locale".split()
    )

    def __init__(self, nao: VirtualNao) -> None:
        super().__init__(nao)
        self.saying = ""
        self._queue: deque[tuple[str, Call]] = deque()
        self._timer: Timer | None = None
        self._parameters = {"pitchShift": 1.0}
        self._parameters |= dict.fromkeys(
            ("doubleVoice", "doubleVoiceLevel", "doubleVoiceTimeShift", "enableCompression"), 0.0
        )
        self._parameters |= dict.fromkeys(("speed", "defaultVoiceSpeed", "volume", "pitch"), 100.0)

    def say(self, stringToSay: Any, language: Any = None) -> Call:
        """Say a text, after those that were given before; returns when it is said."""
        if language is not None:
            arguments.choice(language, "language", _LANGUAGES)
        words = arguments.text(stringToSay, "stringToSay")
        call = Call(lambda: self._cancel(call))
        self._queue.append((words, call))
        if self._timer is None:
            self._next()
        return call

    def stopAll(self) -> None:
        """Be silent at once; whoever waits for a text gets an answer."""
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        waiting, self._queue = self._queue, deque()
        for _, call in waiting:
            self.nao.monitor.later(call.finish)
        self._tell("")

    def getAvailableLanguages(self) -> list[str]:
        """The languages that setLanguage takes."""
        return list(_LANGUAGES)

    def getAvailableVoices(self) -> list[str]:
        """The one voice that is pretended."""
        return ["naoenu"]

    def setParameter(self, pEffectName: Any, pEffectValue: Any) -> None:
        """Set a parameter; "speed" changes how long a text takes, the others are kept."""
        name = arguments.choice(pEffectName, "parameter", tuple(self._parameters))
        value = arguments.number(pEffectValue, name)
        if name in ("speed", "defaultVoiceSpeed") and not 50.0 <= value <= 400.0:
            raise BadArgument(f"{name} must be from 50 to 400, got {value:g}")
        self._parameters["speed" if name == "defaultVoiceSpeed" else name] = value

    def getParameter(self, pParameterName: Any) -> float:
        """A parameter as it was set."""
        return self._parameters[arguments.choice(pParameterName, "parameter", tuple(self._parameters))]

    def resetSpeed(self) -> None:
        """Speak at speed 100 again."""
        self._parameters["speed"] = 100.0

    def _duration(self, words: str) -> float:
        """How long a text takes [s]."""
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
