"""Choregraphe's behaviours (.xar): the timelines in their boxes; and its libraries of poses (.xap).

    <ChoregrapheProject xar_version="3"><Box name="root"><Timeline fps="25" start_frame="1" end_frame="-1">
      <ActuatorList model="nao">
        <ActuatorCurve actuator="HeadYaw" mute="0" unit="0">
          <Key frame="13" value="20.0">
            <Tangent side="left" interpType="bezier" abscissaParam="-4.0" ordinateParam="0.0" />
          </Key>
        </ActuatorCurve>
      </ActuatorList>
    </Timeline></Box></ChoregrapheProject>

Source: Aldebaran's qicore, timeline.cpp, actuatorcurvemodel.cpp and tangentmodel.cpp. A key is played at (frame −
start_frame) / fps. Values are degrees for unit 0, and ratios from 0 to 1 for unit 1 (percent); without a unit they are
ratios for hands and degrees for all other joints. Tangents are offsets in frames and in the unit of the value; a
missing tangent is automatic. Muted curves are not played.

The file is untrusted XML, read by expat: a document type, and with it every entity, is refused, and nothing outside the
file is opened.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any
from xml.parsers import expat
from xml.sax.saxutils import quoteattr

import numpy as np

from nao_kin._core.arrays import Floats, finite_decimal
from nao_kin._core.files import described
from nao_kin._core.text import MAX_SHOWN, abbreviated, quoted
from nao_kin._core.warn import warn_caller
from nao_kin.motion.files.source import FilePosition, FilePositionOf, Format, MotionFileWarning, MotionSource, chosen
from nao_kin.motion.files.tracks import Track, is_hand, milliseconds, motion_of
from nao_kin.motion.interpolation import handles_along
from nao_kin.motion.motion import Motion

# --- The timelines in the XML of a behaviour: frames, values and tangents.

# Kinds of tangents, with the types of NAOqi's control points: 0 constant, 1 linear, 2 Bezier, 3 Bezier with automatic
# handles; the points contain these handles too. Source: Aldebaran's qicore.
CONSTANT, LINEAR, BEZIER, AUTOMATIC = range(4)
KINDS = {"bezier": BEZIER, "bezier_auto": AUTOMATIC, "linear": LINEAR}
SIDES = {"left": 0, "right": 1}
_DEEPEST = 200


@dataclass
class Curve:
    """The keys of one actuator, in flat lists, which are faster than a million small objects."""

    joint: str
    unit: str | None
    place: FilePosition
    keys: list[float] = field(default_factory=list)  # frame, value, line and column of each key
    # For each key, left and then right: the kind, and offsets in frames and in the unit of the value.
    tangents: list[float] = field(default_factory=list)


@dataclass
class Timeline:
    """A timeline of a box."""

    name: str
    fps: float
    first: float
    last: float
    place: FilePosition
    curves: list[Curve] = field(default_factory=list)


class _XmlReader:
    """The elements of a file, in the events of expat."""

    def __init__(self, source: MotionSource) -> None:
        self._source = source
        self._depth = 0
        self._parser = parser = expat.ParserCreate()
        parser.StartElementHandler = self._enter
        parser.EndElementHandler = self._leave
        parser.StartDoctypeDeclHandler = self._refuse
        parser.EntityDeclHandler = self._refuse
        parser.ExternalEntityRefHandler = self._refuse

    def _parse(self) -> None:
        try:
            self._parser.Parse(self._source.data, True)
        except expat.ExpatError as error:
            reason = expat.ErrorString(error.code)
            raise self._source.error(f"malformed XML: {reason}", FilePosition(error.lineno, error.offset + 1)) from None
        except (ValueError, LookupError) as error:  # an encoding that Python or expat does not know
            raise self._source.error(f"malformed XML: {abbreviated(error)}") from None

    def _place(self) -> FilePosition:
        return FilePosition(*self._position())

    def _position(self) -> tuple[int, int]:
        return self._parser.CurrentLineNumber, self._parser.CurrentColumnNumber + 1

    def _refuse(self, *_: object) -> int:
        raise self._source.error("a document type or an entity, which are refused", self._place())

    def _enter(self, tag: str, attributes: dict[str, str]) -> None:
        self._depth += 1
        if self._depth > _DEEPEST:
            raise self._source.error(f"elements more than {_DEEPEST} deep", self._place())
        self._start(tag.rpartition(":")[2], attributes)

    def _leave(self, tag: str) -> None:
        self._depth -= 1
        self._end(tag.rpartition(":")[2])

    def _start(self, kind: str, attributes: dict[str, str]) -> None:
        """Take the beginning of an element."""
        raise NotImplementedError

    def _end(self, kind: str) -> None:
        """Take the end of an element."""
        raise NotImplementedError

    def _decimal(self, text: str, name: str) -> float:
        value = finite_decimal(text)
        if value is None:
            reason = f"{name} is {quoted(text, MAX_SHOWN)}, expected a finite number"
            raise self._source.error(reason, self._place())
        return value


class _TimelineReader(_XmlReader):
    """The timelines of a behaviour, and the behaviours that a project names."""

    def __init__(self, source: MotionSource) -> None:
        super().__init__(source)
        self.timelines: list[Timeline] = []
        self.behaviours: list[str] = []  # paths of .xar files
        self._boxes: list[str] = []
        self._open: list[Timeline] = []
        self._curve: Curve | None = None
        self._parse()

    def _start(self, kind: str, attributes: dict[str, str]) -> None:
        if kind == "Tangent":
            if self._curve and self._curve.keys:
                self._tangent(attributes, self._curve)
        elif kind == "Key":
            if self._curve:
                frame, value = self._number(attributes, "frame"), self._number(attributes, "value")
                self._curve.keys += (frame, value, *self._position())
                self._curve.tangents += (AUTOMATIC, 0.0, 0.0, AUTOMATIC, 0.0, 0.0)
        elif kind == "ActuatorCurve" and self._open:
            self._start_curve(attributes)
        elif kind == "Timeline":
            self._start_timeline(attributes)
        elif kind == "Box":
            self._boxes.append(attributes.get("name", ""))
        elif kind == "BehaviorDescription":
            self.behaviours.append(f"{attributes.get('src', '.')}/{attributes.get('xar', 'behavior.xar')}")

    def _end(self, kind: str) -> None:
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
        self._curve = Curve(attributes.get("actuator", ""), attributes.get("unit"), self._place())
        if attributes.get("mute", "0") not in ("1", "true"):
            self._open[-1].curves.append(self._curve)

    def _tangent(self, attributes: dict[str, str], curve: Curve) -> None:
        side, kind = attributes.get("side"), attributes.get("interpType")
        if side not in SIDES:
            raise self._source.error(
                f"side of a tangent is {quoted(side, MAX_SHOWN)}, expected left or right", self._place()
            )
        if kind not in KINDS:
            reason = f"interpType is {quoted(kind, MAX_SHOWN)}, expected bezier, bezier_auto or linear"
            raise self._source.error(reason, self._place())
        offset, rise = self._number(attributes, "abscissaParam", 0.0), self._number(attributes, "ordinateParam", 0.0)
        at = len(curve.tangents) - 6 + 3 * SIDES[side]
        curve.tangents[at : at + 3] = KINDS[kind], offset, rise

    def _number(self, attributes: dict[str, str], name: str, missing: float | None = None) -> float:
        if name not in attributes:
            if missing is None:
                raise self._source.error(f"an element without {name}", self._place())
            return missing
        return self._decimal(attributes[name], name)


# --- NAOqi's control points: [value, [type, time, value] before, [type, time, value] after], offsets from the key.

_EXPECTED = "[value, [type, time, value], [type, time, value]]"


def plain_keys(rows: list[Any]) -> bool:
    """Return whether the keys of a joint are values without handles."""
    return not any(isinstance(row, list) for row in rows)


def control_points(
    source: MotionSource, rows: list[Any], times: Floats, place: FilePositionOf
) -> tuple[Floats, Floats]:
    """Return values (k,) and handles (k, 2, 2) of the control points of one joint."""
    for key, row in enumerate(rows):
        if not (
            type(row) is list
            and len(row) == 3
            and type(row[1]) is list is type(row[2])
            and len(row[1]) == 3 == len(row[2])
        ):
            raise source.error(f"expected {_EXPECTED}, got {described(row)}", place(key))
    flat = [number for row in rows for number in (row[0], *row[1], *row[2])]
    table = source.floats(flat, "control point", lambda at: place(at // 7)).reshape(-1, 7)
    types = table[:, [1, 4]]
    known = np.isin(types, (LINEAR, BEZIER, AUTOMATIC))
    if not known.all():
        key = int(np.argmin(known.all(axis=1)))
        kind = types[key][~known[key]][0]
        what = "constant, and so jumps to the next key" if kind == CONSTANT else f"of type {kind:g}"
        raise source.error(f"the curve at this key is {what}; expected type 1, 2 or 3", place(key))
    handles = table[:, [[2, 3], [5, 6]]]
    make_straight(times, table[:, 0], handles, types == LINEAR)
    return table[:, 0].copy(), handles


def make_straight(times: Floats, keys: Floats, handles: Floats, linear: Any) -> None:
    """Change the handles marked as linear to a third of the straight line to the next key."""
    chords = np.stack([np.diff(times), np.diff(keys)], axis=-1) / 3.0
    handles[1:, 0][linear[1:, 0]] = -chords[linear[1:, 0]]
    handles[:-1, 1][linear[:-1, 1]] = chords[linear[:-1, 1]]


def points(motion: Motion) -> list[list[Any]]:
    """Return the keys of each joint as in NAOqi: plain for a linear motion, otherwise control points."""
    if motion.interpolation == "linear":
        return [keys.tolist() for keys in motion.keys]
    curves = motion.as_bezier()
    assert curves.handles is not None
    return [
        [[key, [AUTOMATIC, *before], [AUTOMATIC, *after]] for key, (before, after) in zip(keys, handles, strict=True)]
        for keys, handles in zip((k.tolist() for k in curves.keys), (h.tolist() for h in curves.handles), strict=True)
    ]


# --- Choregraphe's behaviours (.xar): the timelines in their boxes.

_THIRD = 1.0 / 3.0
_DEGREE, _PERCENT = "0", "1"
_RATES = (25, 50, 100, 1000)
_NOTICED = 1e-6
_FIRST_FRAME = 1
_LIBRARY = b"ChoregraphePositionLibrary"


def _xml_head(source: MotionSource) -> bytes:
    """Return the beginning of an XML file, in any encoding; nothing of another file."""
    head = source.data[:4096].replace(b"\x00", b"")
    start = head.removeprefix(b"\xef\xbb\xbf").removeprefix(b"\xff\xfe").removeprefix(b"\xfe\xff").lstrip()
    return head if start[:1] == b"<" else b""


def recognises(source: MotionSource) -> bool:
    """Return whether the file is XML with Choregraphe, a timeline or an XML declaration near its beginning."""
    head = _xml_head(source)
    return _LIBRARY not in head and any(word in head for word in (b"Choregraphe", b"<Timeline", b"<?xml"))


def read(source: MotionSource) -> Motion:
    """Read the motion of the only timeline with keys, or of the one that `timeline` chooses.

    Timelines are named by their boxes, from the outermost inside the root: "Dance/wave".
    """
    reader = _TimelineReader(source)
    full = [timeline for timeline in reader.timelines if any(curve.keys for curve in timeline.curves)]
    if not full and reader.behaviours:
        more = f" and {len(reader.behaviours) - 1} more" if len(reader.behaviours) > 1 else ""
        first = abbreviated(reader.behaviours[0], MAX_SHOWN)
        raise source.error(f"a project of Choregraphe, with its motions in other files: {first}{more}")
    if not full:
        raise source.error("no timeline with keys")
    timeline = full[chosen(source, [timeline.name for timeline in full], "timelines")]
    if timeline.fps <= 0.0:
        raise source.error(f"fps is {timeline.fps:g}, expected a number > 0", timeline.place)
    tracks, curved = [], False
    for curve in timeline.curves:
        if curve.keys:
            track, bends = _track(source, timeline, curve)
            curved |= bends
            if len(track.keys):
                tracks.append(track)
    if 4 * sum(len(track.keys) for track in tracks) < sum(len(curve.keys) for curve in timeline.curves):
        warn_caller(
            f"{abbreviated(source.name)}: keys outside of frames {timeline.first:g} to {timeline.last:g} are left out",
            MotionFileWarning,
        )
    return motion_of(source, tracks, "bezier" if curved else "linear")


def _track(source: MotionSource, timeline: Timeline, curve: Curve) -> tuple[Track, bool]:
    """Return the keys of a curve that are played, and whether the curve has more than straight lines."""
    if curve.unit not in (None, "-1", _DEGREE, _PERCENT):
        shown = quoted(curve.unit, MAX_SHOWN)
        raise source.error(f"unit {shown}, expected {_DEGREE} (degrees) or {_PERCENT} (percent)", curve.place)
    ratio = curve.unit == _PERCENT or (curve.unit != _DEGREE and is_hand(curve.joint))
    scale = 1.0 if ratio else math.pi / 180.0
    frames, values, lines, columns = np.array(curve.keys).reshape(-1, 4).T
    tangents = np.array(curve.tangents).reshape(-1, 2, 3)
    kinds, handles = tangents[..., 0], tangents[..., 1:]
    played = (frames >= timeline.first) & ((frames <= timeline.last) | (timeline.last < 1.0))
    indices = np.flatnonzero(played)

    def place_of(key: int) -> FilePosition:
        return FilePosition(int(lines[key]), int(columns[key]))

    if not (np.diff(frames) > 0.0).all():
        key = int(np.argmin(np.diff(frames) > 0.0)) + 1
        raise source.error(f"frame {frames[key]:g} does not come after frame {frames[key - 1]:g}", place_of(key))
    automatic = kinds == AUTOMATIC
    handles[automatic] = automatic_handles(frames, values)[automatic]
    make_straight(frames, values, handles, kinds == LINEAR)
    inner = np.concatenate([kinds[1:, 0], kinds[:-1, 1]])

    def place(key: int) -> FilePosition:
        return place_of(indices[key])

    times = (frames[played] - timeline.first) / timeline.fps
    scaled = handles[played] * [1.0 / timeline.fps, scale]
    track = Track(curve.joint, times, values[played] * scale, scaled, curve.place, place, place)
    return track, bool((inner != LINEAR).any())


def automatic_handles(frames: Floats, values: Floats) -> Floats:
    """Return Choregraphe's automatic handles, shape (k, 2, 2), in frames and values.

    They are a third of their segment long. Their slope β is zero at the first and the last key and where the value is
    not strictly between its neighbours; else β = (v₊ − v₋) / (f₊ − f₋), reduced where a handle would end beyond the
    value of its neighbour.
    """
    slopes = np.zeros_like(values)
    if len(values) > 2:
        before, after = np.diff(values)[:-1], np.diff(values)[1:]
        left, right = np.diff(frames)[:-1], np.diff(frames)[1:]
        inner = np.where(np.sign(before) * np.sign(after) > 0.0, (before + after) / (left + right), 0.0)
        for width, rise in ((right, after), (left, before)):
            height = _THIRD * width * inner
            beyond = np.abs(height) > np.abs(rise)
            inner[beyond] *= rise[beyond] / height[beyond]
        slopes[1:-1] = inner
    return handles_along(frames, slopes, slopes)


def write(motion: Motion, _: Motion) -> bytes:
    """Write a behaviour with one timeline, in degrees and ratios, at 25, 50, 100 or 1000 frames a second."""
    fps, frames = _frames(motion)
    curves = motion.as_bezier()
    assert curves.handles is not None
    kind = "linear" if motion.interpolation == "linear" else "bezier"
    lines = [
        '<?xml version="1.0" encoding="UTF-8" ?>',
        '<ChoregrapheProject xmlns="http://www.aldebaran-robotics.com/schema/choregraphe/project.xsd" xar_version="3">',
        '<Box name="root" id="-1" localization="8" tooltip="" x="0" y="0">',
        f'<Timeline enable="1" fps="{fps}" start_frame="{_FIRST_FRAME}" end_frame="-1" '
        f'size="{int(max(own[-1] for own in frames)) + _FIRST_FRAME}">',
        '<ActuatorList model="nao">',
    ]
    for joint, own, keys, handles in zip(motion.joint_names, frames, motion.keys, curves.handles, strict=True):
        hand = is_hand(joint)
        scale = 1.0 if hand else 180.0 / math.pi
        lines.append(
            f'<ActuatorCurve name="value" actuator={quoteattr(joint)} recordable="0" mute="0" '
            f'unit="{_PERCENT if hand else _DEGREE}">'
        )
        offsets = handles * [fps, scale]
        # Rounding of frames must not move handles out of their segment.
        offsets[1:, 0, 0] = np.maximum(offsets[1:, 0, 0], -np.diff(own))
        offsets[:-1, 1, 0] = np.minimum(offsets[:-1, 1, 0], np.diff(own))
        for frame, value, pair in zip(own.tolist(), (keys * scale).tolist(), offsets.tolist(), strict=True):
            lines.append(f'<Key frame="{int(frame) + _FIRST_FRAME}" value="{value!r}">')
            for side, (x, y) in zip(SIDES, pair, strict=True):
                lines.append(
                    f'<Tangent side="{side}" interpType="{kind}" abscissaParam="{x!r}" ordinateParam="{y!r}" />'
                )
            lines.append("</Key>")
        lines.append("</ActuatorCurve>")
    lines += ["</ActuatorList>", "</Timeline>", "</Box>", "</ChoregrapheProject>"]
    return ("\n".join(lines) + "\n").encode()


def _frames(motion: Motion) -> tuple[int, list[Floats]]:
    """Return the frames a second, and the frame of each key of each joint; warn about keys that move."""
    milliseconds(motion.key_times, "xar")
    times = motion.key_times
    fits = (fps for fps in _RATES if np.abs(np.rint(times * fps) / fps - times).max() <= _NOTICED)
    fps = next(fits, _RATES[-1])
    return fps, [np.rint(own * fps) for own in motion.times]


XAR = Format("xar", (".xar",), "Choregraphe's timelines", recognises, read, write)


# --- Choregraphe's libraries of poses (.xap).
#
#     <ChoregraphePositionLibrary><folder><title>Basics</title>
#       <position>
#         <Motors><Motor><name>HeadYaw</name><value>20</value></Motor></Motors>
#         <version>2</version><name>Look</name>
#       </position>
#     </folder></ChoregraphePositionLibrary>
#
# Source: ros-naoqi/nao_robot, nao_pose/config/basic.xap and xapparser.py: values are radians in version 2, degrees in a
# pose without a version, and for hands always ratios.

_RADIANS = "2"


@dataclass
class _Pose:
    """A pose of a library."""

    name: str = ""
    version: str | None = None
    motors: list[tuple[str, float, FilePosition]] = field(default_factory=list)  # joint, value, place


class _PoseReader(_XmlReader):
    """The poses of a library."""

    def __init__(self, source: MotionSource) -> None:
        super().__init__(source)
        self.poses: list[_Pose] = []
        self._folders: list[str] = []
        self._pose: _Pose | None = None
        self._motor: dict[str, str] | None = None  # its name and value
        self._words: list[str] = []  # the text since the beginning of the element
        self._parser.CharacterDataHandler = lambda text: self._words.append(text)
        self._parse()

    def _start(self, kind: str, attributes: dict[str, str]) -> None:
        self._words = []
        if kind == "folder":
            self._folders.append("")
        elif kind == "position":
            self._pose = _Pose()
        elif kind == "Motor":
            self._motor = {}

    def _end(self, kind: str) -> None:
        text, self._words = "".join(self._words).strip(), []
        if kind == "folder":
            self._folders.pop()
        elif kind == "title" and self._folders and self._pose is None:
            self._folders[-1] = text
        elif self._pose is None:
            return
        elif self._motor is not None and kind in ("name", "value"):
            self._motor[kind] = text
        elif kind == "Motor" and self._motor is not None:
            value = self._decimal(self._motor.get("value", ""), "value")
            self._pose.motors.append((self._motor.get("name", ""), value, self._place()))
            self._motor = None
        elif kind == "name":
            self._pose.name = "/".join([*self._folders, text])
        elif kind == "version":
            self._pose.version = text
        elif kind == "position":
            self.poses.append(self._pose)
            self._pose = None


def _read_pose(source: MotionSource) -> Motion:
    """Read the only pose, or the one that `timeline` chooses, as a motion with one key at 0 s."""
    poses = _PoseReader(source).poses
    if not poses:
        raise source.error("no pose")
    pose = poses[chosen(source, [pose.name for pose in poses], "poses")]
    if pose.version not in (None, _RADIANS):
        shown = quoted(pose.version, MAX_SHOWN)
        raise source.error(f"version {shown} of a pose, expected {_RADIANS} (radians) or none (degrees)")
    scale, start = 1.0 if pose.version else math.pi / 180.0, np.zeros(1)
    values = ((joint, value if is_hand(joint) else value * scale, place) for joint, value, place in pose.motors)
    return motion_of(source, [Track(joint, start, np.array([value]), place=place) for joint, value, place in values])


XAP = Format("xap", (".xap",), "Choregraphe's poses", lambda source: _LIBRARY in _xml_head(source), _read_pose)
