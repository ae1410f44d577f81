"""The timelines of a Choregraphe behaviour, as its XML has them: frames, values and tangents.

The file is untrusted XML: it is read by expat; a document type, and with it every entity, is refused; nothing outside
of the file is opened.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from xml.parsers import expat

from nao_kin._text import abbreviated, quoted
from nao_kin.motion.files.source import MOST_SHOWN, Place, Source

AUTOMATIC, BEZIER, LINEAR = "bezier_auto", "bezier", "linear"
SIDES = {"left": 0, "right": 1}
_DEEPEST = 200


@dataclass
class Curve:
    """The keys of one actuator, in flat lists: a million small objects would cost more than the reading.

    Attributes:
        kinds: of the two tangents of each key.
        offsets: of the same, in frames.
        rises: of the same, in the unit of the value.
    """

    joint: str
    unit: str | None
    place: Place
    frames: list[float] = field(default_factory=list)
    values: list[float] = field(default_factory=list)
    kinds: list[str] = field(default_factory=list)
    offsets: list[float] = field(default_factory=list)
    rises: list[float] = field(default_factory=list)
    lines: list[int] = field(default_factory=list)
    columns: list[int] = field(default_factory=list)

    def add(self, frame: float, value: float, line: int, column: int) -> None:
        """A key whose tangents are automatic until something else is said."""
        self.frames.append(frame)
        self.values.append(value)
        self.kinds += (AUTOMATIC, AUTOMATIC)
        self.offsets += (0.0, 0.0)
        self.rises += (0.0, 0.0)
        self.lines.append(line)
        self.columns.append(column)

    def place_of(self, key: int) -> Place:
        """Where a key stands."""
        return Place(self.lines[key], self.columns[key])


@dataclass
class Timeline:
    """A timeline of a box."""

    name: str
    fps: float
    first: float
    last: float
    place: Place
    curves: list[Curve] = field(default_factory=list)


class TimelineReader:
    """What expat tells, kept: boxes that are open, timelines that are open, all timelines."""

    def __init__(self, source: Source) -> None:
        self.timelines: list[Timeline] = []
        self._source = source
        self._boxes: list[str] = []
        self._open: list[Timeline] = []
        self._curve: Curve | None = None
        self._depth = 0
        self._parser = parser = expat.ParserCreate()
        parser.StartElementHandler = self._start
        parser.EndElementHandler = self._end
        parser.StartDoctypeDeclHandler = self._refuse
        parser.EntityDeclHandler = self._refuse
        parser.ExternalEntityRefHandler = self._refuse

    def read(self) -> None:
        """Read all of the file."""
        try:
            self._parser.Parse(self._source.data, True)
        except expat.ExpatError as error:
            reason = expat.ErrorString(error.code)
            raise self._source.error(f"malformed XML: {reason}", Place(error.lineno, error.offset + 1)) from None
        except (ValueError, LookupError) as error:  # an encoding that Python does not know or that is no single byte
            raise self._source.error(f"malformed XML: {abbreviated(error)}") from None

    def _position(self) -> tuple[int, int]:
        return self._parser.CurrentLineNumber, self._parser.CurrentColumnNumber + 1

    def _place(self) -> Place:
        return Place(*self._position())

    def _refuse(self, *_: object) -> int:
        raise self._source.error("a document type or an entity, which are refused", self._place())

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        self._depth += 1
        if self._depth > _DEEPEST:
            raise self._source.error(f"elements more than {_DEEPEST} deep", self._place())
        kind = tag.rpartition(":")[2]
        if kind == "Tangent":
            if self._curve and self._curve.kinds:
                self._tangent(attributes, self._curve)
        elif kind == "Key":
            if self._curve:
                frame, value = self._number(attributes, "frame"), self._number(attributes, "value")
                self._curve.add(frame, value, *self._position())
        elif kind == "ActuatorCurve" and self._open:
            self._start_curve(attributes)
        elif kind == "Timeline":
            self._start_timeline(attributes)
        elif kind == "Box":
            self._boxes.append(attributes.get("name", ""))

    def _end(self, tag: str) -> None:
        self._depth -= 1
        kind = tag.rpartition(":")[2]
        if kind == "Box":
            self._boxes.pop()
        elif kind == "Timeline":
            self._open.pop()
        elif kind == "ActuatorCurve":
            self._curve = None

    def _start_timeline(self, attributes: dict[str, str]) -> None:
        names = self._boxes[1:] if len(self._boxes) > 1 else self._boxes
        timeline = Timeline(
            "/".join(names) or "timeline",
            self._number(attributes, "fps", 0.0),
            self._number(attributes, "start_frame", 0.0),
            self._number(attributes, "end_frame", -1.0),
            self._place(),
        )
        self._open.append(timeline)
        self.timelines.append(timeline)

    def _start_curve(self, attributes: dict[str, str]) -> None:
        unit = attributes.get("unit")
        self._curve = Curve(attributes.get("actuator", ""), unit, self._place())
        if attributes.get("mute", "0") not in ("1", "true"):
            self._open[-1].curves.append(self._curve)

    def _tangent(self, attributes: dict[str, str], curve: Curve) -> None:
        side, kind = attributes.get("side"), attributes.get("interpType")
        if side not in SIDES:
            raise self._source.error(
                f"side of a tangent is {quoted(side, MOST_SHOWN)}, expected left or right", self._place()
            )
        if kind not in (AUTOMATIC, BEZIER, LINEAR):
            expected = f"{BEZIER}, {AUTOMATIC} or {LINEAR}"
            raise self._source.error(f"interpType is {quoted(kind, MOST_SHOWN)}, expected {expected}", self._place())
        at = len(curve.kinds) - 2 + SIDES[side]
        curve.kinds[at] = kind
        curve.offsets[at] = self._number(attributes, "abscissaParam", 0.0)
        curve.rises[at] = self._number(attributes, "ordinateParam", 0.0)

    def _number(self, attributes: dict[str, str], name: str, missing: float | None = None) -> float:
        if name not in attributes:
            if missing is None:
                raise self._source.error(f"an element without {name}", self._place())
            return missing
        text = attributes[name]
        try:
            # Python reads more than decimal digits, but not in plain text without underscores.
            value = float(text) if text.isascii() and "_" not in text else math.inf
        except ValueError:
            value = math.inf
        if not math.isfinite(value):
            shown = quoted(text, MOST_SHOWN)
            raise self._source.error(f"{name} is {shown}, expected a finite number", self._place())
        return value
