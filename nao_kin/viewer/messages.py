"""The messages for the page, as MessagePack: meshcat's own commands, and a message type of this package.

meshcat's JavaScript takes `set_object`, `set_transform` and `set_animation`; messages of type "nao_kin" are for the
panel. Arrays are sent as typed arrays, numbers as doubles.
"""

from __future__ import annotations

import hashlib
import itertools
import math
import threading
import uuid
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
import umsgpack
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats
from nao_kin._core.text import quoted
from nao_kin.errors import BadArgument
from nao_kin.robot.urdf import Box, Cylinder, Rgba, Sphere
from nao_kin.viewer.meshes import Shape

# MessagePack extension types of msgpack-lite, the reader inside meshcat.
_TYPED_ARRAYS = {
    "uint8": ("Uint8Array", 0x12),
    "int16": ("Int16Array", 0x13),
    "uint16": ("Uint16Array", 0x14),
    "uint32": ("Uint32Array", 0x16),
    "float32": ("Float32Array", 0x17),
    "float64": ("Float64Array", 0x18),
}
# A command of meshcat, or a message for the panel, before it is packed.
Command = Mapping[str, Any]
_NAMESPACE = uuid.UUID("6f3c1c0e-5a0b-4f6e-9d6b-2c8f6f0b7a11")


class RetainedMessages:
    """The newest message of every key, retained for pages that open later; safe for several threads."""

    def __init__(self) -> None:
        self.scene: frozenset[str] = frozenset()  # keys of the constant messages
        self.scene_tag = ""  # their digest
        self._messages: dict[str, bytes] = {}
        self._lock = threading.Lock()
        self._watchers: list[Callable[[str], None]] = []
        self._changes = itertools.count(1)

    def source(self) -> str:
        """Return the source of a change that the program makes; no other change in these messages has it.

        A page thereby finds what has changed in a list that is sent whole.
        """
        return f"program {next(self._changes)}"

    def put(self, key: str, message: bytes) -> None:
        """Replace the message of a key; the key keeps its first place in the order."""
        with self._lock:
            self._messages[key] = message
        for watcher in tuple(self._watchers):  # a watcher may stop watching meanwhile, in another thread
            watcher(key)

    def drop(self, prefix: str) -> None:
        """Remove the messages of all keys with a prefix; pages that have them are not notified."""
        with self._lock:
            for key in [key for key in self._messages if key.startswith(prefix)]:
                del self._messages[key]

    def scene_is_complete(self) -> None:
        """Declare all messages so far as the constant scene, which is not sent again to a page that has it."""
        with self._lock:
            self.scene = frozenset(self._messages)
            self.scene_tag = hashlib.sha256(b"".join(self._messages.values())).hexdigest()[:32]

    def get(self, key: str) -> bytes | None:
        """Return the newest message of a key."""
        return self._messages.get(key)

    def names(self) -> tuple[str, ...]:
        """Return all keys, in the order in which a page needs them."""
        with self._lock:
            return tuple(self._messages)

    def messages(self) -> tuple[bytes, ...]:
        """Return the newest messages, in the order of the keys."""
        with self._lock:
            return tuple(self._messages.values())

    def copy(self, other: RetainedMessages, removing: Callable[[str], bytes | None]) -> None:
        """Replace all messages with those of `other`; `removing` returns the message that removes a key's drawing."""
        is_same = self.scene_tag == other.scene_tag
        theirs = dict(zip(other.names(), other.messages(), strict=True))
        self.scene, self.scene_tag = other.scene, other.scene_tag
        for key in set(self.names()) - theirs.keys():
            message = removing(key)
            self.drop(key) if message is None else self.put(key, message)
        for key, message in theirs.items():
            if not (is_same and key in self.scene):
                self.put(key, message)

    def watch(self, watcher: Callable[[str], None]) -> None:
        """Call `watcher` with the key of every new message, in the thread that puts it."""
        self._watchers.append(watcher)

    def unwatch(self, watcher: Callable[[str], None]) -> None:
        """Stop calling `watcher`."""
        with suppress(ValueError):
            self._watchers.remove(watcher)


def note_last(keys: dict[str, None], key: str) -> None:
    """Note that the message under `key` changed last.

    A page gets its missing messages in the order of the last changes: a clip after a configuration must play, and a
    configuration after a clip must end it.
    """
    keys.pop(key, None)
    keys[key] = None


def named_key(kind: str, name: str) -> str:
    """Return the key of a named message. No key is a prefix of another one, because `drop` takes prefixes."""
    return f"{kind} {len(name)} {name}"


class NamedMessages:
    """One message per name, and a list of the names, by which even a page that missed messages removes all others."""

    def __init__(self, messages: RetainedMessages, kind: str, listing: str) -> None:
        self._messages, self._kind, self._listing = messages, kind, listing
        self.names: dict[str, None] = {}

    def put(self, name: str, message: bytes) -> None:
        """Put a message, instead of the one of the same name."""
        is_new = name not in self.names
        self.names[name] = None
        self._messages.put(named_key(self._kind, name), message)
        if is_new:
            self._list()

    def drop(self, name: str) -> None:
        """Drop the messages of a name, if there are any."""
        self.names.pop(name, None)
        self._messages.drop(named_key(self._kind, name))
        self._list()

    def _list(self) -> None:
        self._messages.put(self._listing, panel_message(self._listing, {"names": list(self.names)}))


def panel_message(kind: str, content: Mapping[str, Any]) -> bytes:
    """Return a message for the panel, of one of `KINDS`."""
    return packed({"type": "nao_kin", "kind": kind, **content})


def set_transform(path: str, T: Floats) -> Command:
    """Return meshcat's command that places a node of the scene in its parent."""
    return {"type": "set_transform", "path": path, "matrix": by_columns(T)}


def by_columns(T: Floats) -> list[float]:
    """Return a pose as three.js lists it."""
    return [float(entry) for entry in T.T.flat]


def set_object(path: str, shape: Shape, rgba: Rgba) -> Command:
    """Return meshcat's command that puts a shape at a node of the scene."""
    name = f"{path}#"
    geometry, material, mesh = (str(uuid.uuid5(_NAMESPACE, name + part)) for part in ("geometry", "material", "mesh"))
    appearance = {
        "uuid": material,
        "type": "MeshPhongMaterial",
        "color": hex_colour(rgba),
        "opacity": rgba[3],
        "transparent": rgba[3] < 1.0,
    }
    document = {
        "metadata": {"version": 4.5, "type": "Object"},
        "geometries": [{"uuid": geometry, **geometry_document(shape)}],
        "materials": [appearance],
        "object": {"uuid": mesh, "type": "Mesh", "geometry": geometry, "material": material}
        | {"matrix": by_columns(geometry_pose(shape))},
    }
    return {"type": "set_object", "path": path, "object": document}


def hex_colour(rgba: Rgba) -> int:
    """Return a colour as one number, 0xRRGGBB."""
    r, g, b = (round(255 * value) for value in rgba[:3])
    return r << 16 | g << 8 | b


def set_animation(
    clips: Mapping[str, list[dict[str, Any]]], fps: float, *, play: bool = False, loop: bool = False
) -> Command:
    """Return meshcat's command that replaces the clip; `clips` is path of a node → tracks, empty to end the clip."""
    animations = [
        {"path": path, "clip": {"fps": fps, "name": "clip", "tracks": tracks}} for path, tracks in clips.items()
    ]
    options = {"play": play, "repetitions": math.inf if loop else 1.0, "clampWhenFinished": True}
    return {"type": "set_animation", "path": "", "animations": animations, "options": options}


def track(name: str, kind: str, rows: Floats, times: Floats | None = None) -> dict[str, Any]:
    """Return a track of a property, one row of numbers at each of `times`, by default 0, 1, … n − 1.

    The property is that of the clip's node, or, as in "child.position", of the part of its object with this name.
    """
    at = np.arange(len(rows)) if times is None else times
    values = typed_array(rows.astype(np.float32).reshape(-1))
    name = name if "." in name else f".{name}"
    return {"name": name, "type": kind, "times": typed_array(at.astype(np.float32)), "values": values}


def typed_array(array: NDArray[Any]) -> Any:
    """Return an array as JavaScript's typed array."""
    return umsgpack.Ext(_TYPED_ARRAYS[array.dtype.name][1], np.ascontiguousarray(array).tobytes())


def content_name(content: Command) -> str:
    """Return a name for some content, the same for equal content."""
    return hashlib.sha256(packed(content)).hexdigest()[:32]


def node_name(kind: str, name: str) -> str:
    """Return a name as one step of a scene path, with its slashes escaped."""
    return f"{kind}:{name.replace('%', '%25').replace('/', '%2F')}"


def packed(message: Command | str) -> bytes:
    """Return a command or message as bytes; refuse text that has no UTF-8."""
    try:
        return bytes(umsgpack.packb(message))
    except UnicodeEncodeError as error:
        raise BadArgument(f"text has half a surrogate pair, which no page can show: {quoted(error.object)}") from None


def geometry_document(shape: Shape) -> dict[str, Any]:
    """Return a shape in the form of three.js's loader, without a colour and a pose."""
    if isinstance(shape, Box):
        return {"type": "BoxGeometry", **dict(zip(("width", "height", "depth"), shape.size, strict=True))}
    if isinstance(shape, Cylinder):
        radii = {"radiusTop": shape.radius, "radiusBottom": shape.radius}
        return {"type": "CylinderGeometry", **radii, "height": shape.length, "radialSegments": 48}
    if isinstance(shape, Sphere):
        return {"type": "SphereGeometry", "radius": shape.radius, "widthSegments": 40, "heightSegments": 28}
    index = shape.faces.astype(np.uint16 if len(shape.vertices) <= 0xFFFF else np.uint32)
    attributes = {
        "position": _attribute(shape.vertices.astype(np.float32)),
        "normal": _attribute(np.round(shape.normals * 32767).astype(np.int16), normalized=True),
    }
    return {"type": "BufferGeometry", "data": {"attributes": attributes, "index": _attribute(index.reshape(-1, 1))}}


def _attribute(rows: NDArray[Any], *, normalized: bool = False) -> dict[str, Any]:
    name = _TYPED_ARRAYS[rows.dtype.name][0]
    return {"itemSize": rows.shape[1], "type": name, "array": typed_array(rows), "normalized": normalized}


def geometry_pose(shape: Shape) -> Floats:
    """Return the pose of a shape's geometry in the shape's frame: three.js draws cylinders about y."""
    T = np.eye(4)
    if isinstance(shape, Cylinder):
        T[1:3, 1:3] = [[0.0, -1.0], [1.0, 0.0]]
    return T


# --- The messages for the panel, each kind with its fields: sent here, read by web/src/messages.ts.


@dataclass(frozen=True)
class Kind:
    """A kind of message for the panel."""

    fields: Mapping[str, str]  # name → TypeScript type; a question mark after the name marks an optional field
    blank: Mapping[str, Any] | None = None  # fields of the message that removes the drawing; None if there is none


# The description of a robot, and its rows, each with its fields. A link is an index into `links`, a column an index
# into q, a matrix a pose column by column; what is unknown or has no limit is null.
ROWS: Mapping[str, Mapping[str, str]] = {
    "About": {"name": "string", "floating": "boolean", "root": "string", "soles": "Sole[]", "notes": "string[]"}
    | {"links": "Link[]", "places": "Place[]", "shapes": "ShapeAbout[]", "joints": "JointAbout[]"}
    | {"coordinates": "Coordinate[]", "tables": "CoupledLimits[]", "chains": "Chain[]", "postures": "Posture[]"}
    # Empty without two sides, and for a robot that is no NAO, whose joints are not those of NAOqi's Body.
    | {"mirror": "Mirrored[]", "naoqi": "string[]"}
    | {"neutral": "number[]", "frames": "Frame[]", "effectors": "string[]", "ends": "End[]", "bodies": "Body[]"}
    | {"cameras": "Camera[]", "eyes": "Eye[]"},
    # The corners are x, y, z in the link, one after another.
    "Sole": {"link": "number", "corners": "number[]"},
    # The title is the name of the robot's maker for the link, such as NAOqi's LFoot, or else its name.
    "Link": {"name": "string", "title": "string", "path": "string[]"},
    # The constant pose of a node in its parent.
    "Place": {"path": "string[]", "matrix": "number[]"},
    # `geometry` names a message; the colour is 0xRRGGBB in sRGB; the light is "" for other shapes.
    "ShapeAbout": {"link": "number", "geometry": "string", "matrix": "number[]", "colour": "number"}
    | {"opacity": "number", "light": "string"},
    # Value of a joint = multiplier · q[column] + offset; `follows` names the joint that it mimics, or is empty.
    "Driven": {"name": "string", "column": "number", "multiplier": "number", "offset": "number", "follows": "string"},
    "JointAbout": {"link": "number", "slides": "boolean", "axis": "Vector", "pair": "string", "group": "number"},
    "Coordinate": {"joint": "string", "column": "number", "lower": "number | null", "upper": "number | null"}
    | {"velocity": "number | null", "unit": "string"},
    "CoupledLimits": {"joint": "number", "of": "number", "at": "number[]", "lower": "number[]", "upper": "number[]"},
    "Chain": {"title": "string", "joints": "Driven[]"},
    "Posture": {"name": "string", "q": "number[]", "up": "Vector | null"},
    # q[column] becomes multiplier · q[of] + offset.
    "Mirrored": {"column": "number", "of": "number", "multiplier": "number", "offset": "number"},
    "Frame": {"name": "string", "link": "number"},
    # The end of a limb: a frame, and the point in it that a handle moves.
    "End": {"frame": "string", "point": "Vector"},
    # Links that move as one; `size` and `matrix` are those of a box in the link with the same inertia.
    "Body": {"link": "number", "mass": "number", "centre": "Vector", "size": "Vector", "matrix": "number[]"},
    # A preset: the direction to look from, and the links to look at with all that they carry.
    "Camera": {"name": "string", "direction": "Vector", "links": "number[]"},
    # A camera of the robot, which looks along x of its link, and its field of view [rad].
    "Eye": {"name": "string", "link": "number", "horizontal": "number | null", "vertical": "number | null"},
}


def row(kind: str, *values: Any) -> dict[str, Any]:
    """Return a row of a robot's description, of one of `ROWS`."""
    return dict(zip(ROWS[kind], values, strict=True))


_SCALE = {"stops": "Vector[] | null", "label": "string", "low": "string", "high": "string"}
# Fields of the message that shows links in their own colours.
COLOURLESS: Mapping[str, Any] = {"robot": 0, "links": [], "label": "", "low": "", "high": "", "stops": None}

KINDS: Mapping[str, Kind] = {
    # The shapes and descriptions of robots, under names that equal shapes and equal robots share.
    "geometry": Kind({"name": "string", "geometry": "object"}),
    "model": Kind({"name": "string", "about": "About"}),
    # The leading robot.
    "robot": Kind({"model": "string"}),
    "joints": Kind({"q": "Float64Array", "up": "Vector | null", "source": "string"}),
    # The configurations at some times, or a motion with its curves; the directions upwards are `fps` per second.
    "clip": Kind(
        {"times": "Float64Array", "q": "Float32Array | Float64Array", "handles": "Float64Array | null"}
        | {"fps": "number", "ups": "Float32Array | null", "figure": "{ object: object; clip: object } | null"}
        | {"play": "boolean", "loop": "boolean"}
    ),
    "still": Kind({}),
    # The hulls of the leading robot's links: for each hull its link, number of points and radius, and the range of its
    # parts, or of itself; the points in the frames of the links [m]; and the pairs of hulls that are compared.
    "hulls": Kind(
        {"links": "number[]", "counts": "number[]", "radii": "number[]", "parts": "[number, number][]"}
        | {"points": "Float32Array", "pairs": "Uint16Array"}
    ),
    # Additional robots, with their numbers.
    "robot_added": Kind({"robot": "number", "name": "string", "model": "string", "opacity": "number"}),
    "robot_joints": Kind({"robot": "number", "q": "Float64Array", "up": "Vector | null"}),
    "robot_removed": Kind({"robot": "number"}),
    "robots": Kind({"robots": "number[]"}, blank={"robots": []}),
    # Drawings.
    "shown": Kind({"shown": "Record<string, boolean>", "source": "string"}),
    "frames": Kind({"names": "string[]", "size": "number | null"}),
    "ghosts": Kind(
        {"qs": "Float64Array", "count": "number", "opacity": "number", "first": "number | null"},
        blank={"qs": typed_array(np.zeros(0)), "count": 0, "opacity": 1.0, "first": 1},
    ),
    "targets": Kind(
        {"targets": "{ name: string; matrix: number[]; point: boolean; source?: string }[]"}, blank={"targets": []}
    ),
    # The collision shapes of the leading robot, with their poses in their links.
    "shapes": Kind({"shapes": "{ link: number; geometry: object; matrix: number[] }[]"}, blank={"shapes": []}),
    "controls": Kind({"controls": "Control[]"}, blank={"controls": []}),
    "colours": Kind({"robot": "number", "links": "{ link: number; rgb: Vector }[]", **_SCALE}, blank=COLOURLESS),
    "lights": Kind({"lights": "{ name: string; rgb: Vector }[]"}, blank={"lights": []}),
    "reach": Kind(
        {"cells": "Uint16Array | null", "values?": "Uint16Array", "frame?": "string", "voxel?": "number"}
        | {"first?": "Vector", "cut?": '{ axis: "x" | "y" | "z"; place: number } | null'}
        | {f"{name}?": kind for name, kind in _SCALE.items()},
        blank={"cells": None},
    ),
    "extra": Kind(
        {"name": "string", "shape": '"points" | "mesh" | "line" | "arrow" | "label"', "frame": "string | null"}
        | {"width?": "number", "text?": "string"}
        | {"positions?": "Float32Array", "size?": "number", "colour?": "Vector", "colours?": "Uint8Array | null"}
        | {"parts?": "{ geometry: object; colour: Vector; opacity: number }[]"}
    ),
    "extras": Kind({"names": "string[]"}, blank={"names": []}),
    # Images of cameras, and numbers over time.
    "image": Kind({"camera": "string", "format": "string", "data": "Uint8Array"}),
    "images": Kind({"names": "string[]"}, blank={"names": []}),
    "plot": Kind(
        {"name": "string", "lines": "string[]", "run": "number", "first": "number", "margins": "boolean"}
        | {"times": "Float64Array", "values": "Float64Array"}
    ),
    "plots": Kind({"names": "string[]"}, blank={"names": []}),
    # Pictures, and the connection.
    "camera": Kind({"camera": "string | number[]"}),
    "capture": Kind({"id": "string", "camera": "string | number[]", "width": "number", "height": "number"}),
    "film": Kind(
        {"id": "string", "camera": "string | number[]", "width": "number", "height": "number", "fps": "number"}
        | {"form": '"webm" | "zip"'}
    ),
    "version": Kind({"version": "string"}),
    "complete": Kind({}),
}
# Key of a message that shows something → the message that removes it.
BLANKS: Mapping[str, bytes] = {
    "clip": panel_message("still", {}),
    **{name: panel_message(name, kind.blank) for name, kind in KINDS.items() if kind.blank is not None},
}
