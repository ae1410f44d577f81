"""Choregraphe's behaviours (.xar): the timelines in their boxes.

    <ChoregrapheProject xar_version="3"><Box name="root"><Timeline fps="25" start_frame="1" end_frame="-1">
      <ActuatorList model="nao">
        <ActuatorCurve actuator="HeadYaw" mute="0" unit="0">
          <Key frame="13" value="20.0">
            <Tangent side="left" interpType="bezier" abscissaParam="-4.0" ordinateParam="0.0" />
          </Key>
        </ActuatorCurve>
      </ActuatorList>
    </Timeline></Box></ChoregrapheProject>

Source: Aldebaran's qicore, timeline.cpp, actuatorcurvemodel.cpp and tangentmodel.cpp: a key is played at (frame −
start_frame) / fps; values are degrees for unit 0, ratios from 0 to 1 for unit 1 (percent), and where there is no unit
ratios for the hands and degrees for all else; tangents are offsets in frames and in the unit of the value, automatic
where there is none; muted curves are not played.

The file is untrusted XML: it is read by expat; a document type, and with it every entity, is refused; nothing outside
of the file is opened.
"""

from __future__ import annotations

import math
from xml.sax.saxutils import quoteattr

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin._common.warn import warn_caller
from nao_kin._text import abbreviated, quoted
from nao_kin.motion.files.choice import chosen
from nao_kin.motion.files.choregraphe_timelines import (
    AUTOMATIC,
    BEZIER,
    LINEAR,
    SIDES,
    Curve,
    Timeline,
    TimelineReader,
)
from nao_kin.motion.files.control_points import straight
from nao_kin.motion.files.format import Format
from nao_kin.motion.files.source import MOST_SHOWN, MotionFileWarning, Place, Source
from nao_kin.motion.files.tables import is_hand, sampled
from nao_kin.motion.files.tracks import Track, motion_of
from nao_kin.motion.motion import Motion

_THIRD = 1.0 / 3.0
_DEGREE, _PERCENT = "0", "1"
_RATES = (25, 50, 100, 1000)
_NOTICED = 1e-6
_FIRST_FRAME = 1


def recognises(source: Source) -> bool:
    """Whether it is XML that says Choregraphe or has a timeline near its beginning."""
    head = source.data[:4096].replace(b"\x00", b"")
    start = head.removeprefix(b"\xef\xbb\xbf").removeprefix(b"\xff\xfe").removeprefix(b"\xfe\xff").lstrip()
    return start[:1] == b"<" and (b"Choregraphe" in head or b"<Timeline" in head or b"<?xml" in head)


def read(source: Source) -> Motion:
    """The motion of the only timeline with keys, or of the one that `timeline` names.

    Timelines are named by their boxes, from the outermost inside the root: "Dance/wave".

    Raises:
        BadInputFile: with line and column.
    """
    reader = TimelineReader(source)
    reader.read()
    full = [timeline for timeline in reader.timelines if any(curve.frames for curve in timeline.curves)]
    if not full:
        raise source.error("no timeline with keys")
    timeline = full[chosen(source, [timeline.name for timeline in full], "timelines")]
    if timeline.fps <= 0.0:
        raise source.error(f"fps is {timeline.fps:g}, expected a number > 0", timeline.place)
    tracks, curved = [], False
    for curve in timeline.curves:
        if curve.frames:
            track, bends = _track(source, timeline, curve)
            curved |= bends
            if len(track.keys):
                tracks.append(track)
    if sum(len(track.keys) for track in tracks) < sum(len(curve.frames) for curve in timeline.curves):
        warn_caller(
            f"{abbreviated(source.name)}: keys outside of frames {timeline.first:g} to {timeline.last:g} are left out",
            MotionFileWarning,
        )
    return motion_of(source, tracks, "bezier" if curved else "linear")


def _track(source: Source, timeline: Timeline, curve: Curve) -> tuple[Track, bool]:
    """The keys of a curve that are played, and whether it is more than straight lines."""
    if curve.unit not in (None, "-1", _DEGREE, _PERCENT):
        shown = quoted(curve.unit, MOST_SHOWN)
        raise source.error(f"unit {shown}, expected {_DEGREE} (degrees) or {_PERCENT} (percent)", curve.place)
    ratio = curve.unit == _PERCENT or (curve.unit != _DEGREE and is_hand(curve.joint))
    scale = 1.0 if ratio else math.pi / 180.0
    frames, values = np.array(curve.frames), np.array(curve.values)
    if not (np.diff(frames) > 0.0).all():
        key = int(np.argmin(np.diff(frames) > 0.0)) + 1
        raise source.error(f"frame {frames[key]:g} does not come after frame {frames[key - 1]:g}", curve.place_of(key))
    kinds = np.array(curve.kinds).reshape(-1, 2)
    handles = np.stack([curve.offsets, curve.rises], axis=-1).reshape(-1, 2, 2)
    automatic = kinds == AUTOMATIC
    handles[automatic] = automatic_handles(frames, values)[automatic]
    straight(frames, values, handles, kinds == LINEAR)
    inner = np.concatenate([kinds[1:, 0], kinds[:-1, 1]])
    played = (frames >= timeline.first) & ((frames <= timeline.last) | (timeline.last < 1.0))
    kept = np.flatnonzero(played)

    def place(key: int) -> Place:
        return curve.place_of(int(kept[key]))

    times = (frames[played] - timeline.first) / timeline.fps
    scaled = handles[played] * [1.0 / timeline.fps, scale]
    track = Track(curve.joint, times, values[played] * scale, scaled, curve.place, place, place)
    return track, bool((inner != LINEAR).any())


def automatic_handles(frames: Floats, values: Floats) -> Floats:
    """Choregraphe's automatic handles, shape (k, 2, 2), in frames and values.

    They are a third of the segment beside them long. Their slope β is zero at the first and the last key and where the
    value is not strictly between its neighbours; else β = (v₊ − v₋) / (f₊ − f₋), made smaller where a handle would end
    beyond the value of its neighbour.
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
    handles = np.zeros((len(values), 2, 2))
    thirds = np.diff(frames) * _THIRD
    handles[1:, 0, 0], handles[:-1, 1, 0] = -thirds, thirds
    handles[..., 1] = handles[..., 0] * slopes[:, None]
    return handles


def write(motion: Motion, rate: float | None) -> bytes:
    """A behaviour with one timeline, in degrees and ratios, at 25, 50, 100 or 1000 frames a second.

    Raises:
        BadArgument: times before 0 or nearer than a millisecond.
    """
    if rate is not None:
        times, values = sampled(motion, rate, "xar")
        motion = Motion(times, motion.joint_names, values)
    fps, frames = _frames(motion)
    curves = motion.as_bezier()
    assert curves.handles is not None
    kind = LINEAR if motion.interpolation == "linear" else BEZIER
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
        # Where frames are rounded, handles must not leave their segment.
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
    """Frames a second, and the frame of each key of each joint; with a warning where keys had to move."""
    from nao_kin.motion.files.tables import milliseconds

    milliseconds(motion.key_times, "xar")
    times = motion.key_times
    for fps in _RATES:
        if np.abs(np.rint(times * fps) / fps - times).max() <= _NOTICED:
            break
    return fps, [np.rint(own * fps) for own in motion.times]


XAR = Format("xar", (".xar",), "Choregraphe's timelines", recognises, read, write)
