"""The rows of `tables.toml` and `collisions.toml`: those of every version, and the tables of each version."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

from nao_kin._core.arrays import Vector
from nao_kin._core.files import read_toml
from nao_kin.robot.nao.rows import (
    ActuatorRow,
    CameraRow,
    CoupledLimitRow,
    FingerRow,
    FrameRow,
    InertialRow,
    JointRow,
    LimitRow,
    OffsetRow,
    OutlineRow,
    PostureRow,
    ResolutionRow,
    ShapeRow,
    Version,
    VersionPage,
    VersionTables,
    VisualRow,
)

_Row = TypeVar("_Row")
_DOCUMENT, _COLLISIONS = (read_toml(Path(__file__).with_name(f"{name}.toml")) for name in ("tables", "collisions"))
_ALL = _DOCUMENT["all"]


def _value(cell: Any) -> Any:
    """Return a cell with tuples in place of lists, and None in place of an empty text."""
    if isinstance(cell, list):
        return tuple(map(_value, cell))
    return None if cell == "" else cell


def _rows(kind: Callable[..., _Row], given: Iterable[list[Any]]) -> tuple[_Row, ...]:
    """Return the rows of a table, one for each name in the first cell."""
    return tuple(kind(name, *map(_value, rest)) for names, *rest in given for name in names.split())


# The public source for each code in a row.
SOURCES: dict[str, str] = _DOCUMENT["sources"]


# --- What is the same in every version.

# The joints in NAOqi's Body order.
JOINTS = _rows(JointRow, _ALL["joints"])
BODY_ORDER: tuple[str, ...] = tuple(row.name for row in JOINTS)
CHAINS: dict[str, tuple[str, ...]] = {
    chain: tuple(row.name for row in JOINTS if row.chain == chain) for chain in ("Head", "LArm", "LLeg", "RLeg", "RArm")
}

# Every phalanx turns about its z axis by FINGER_RATIO [rad] times the opening; at opening 1 the fingers are straight.
FINGER_RATIO = 0.999899
FINGERS = _rows(FingerRow, _ALL["fingers"])

# Torques of the joints while their motors are stalled [N m].
STALL_TORQUES: dict[str, float] = {
    joint: 1e-3 * torque * reduction for joints, torque, reduction in _ALL["stalled_motors"] for joint in joints.split()
}


def _right_ankle(left: CoupledLimitRow) -> CoupledLimitRow:
    table = tuple((at, 0.0 - high, 0.0 - low) for at, low, high in left.table_deg)
    return CoupledLimitRow("RAnkleRoll", "RAnklePitch", table, left.source)


COUPLED_LIMITS: tuple[CoupledLimitRow, ...] = _rows(CoupledLimitRow, _ALL["coupled_limits"])
COUPLED_LIMITS = (*COUPLED_LIMITS, _right_ankle(COUPLED_LIMITS[-1]))
NAOQI_SHAPES = _rows(ShapeRow, _ALL["naoqi_shapes"])
SOLE_OUTLINES = _rows(OutlineRow, _ALL["sole_outlines"])
RESOLUTIONS = _rows(ResolutionRow, _ALL["resolutions"])
CAMERAS: tuple[str, ...] = ("CameraTop", "CameraBottom")
# x right, y down, z forward, as in image processing; the camera frames themselves look along x.
OPTICAL_RPY = (-math.pi / 2, 0.0, -math.pi / 2)
POSTURES = _rows(PostureRow, _ALL["postures"])
# The vertical, in the torso's frame, in the postures in which the robot does not stand.
REST: dict[str, Vector] = {name: _value(up) for name, up in _ALL["rest"].items()}


# Names in ros-naoqi's `nao_description`: NAOqi's names of bodies, other links, hands and joints.
BODY_ALIASES, ROS_LINKS, ROS_HANDS, ROS_JOINTS = (
    dict[str, str](_DOCUMENT["ros"][part]) for part in ("bodies", "links", "hands", "joints")
)


# --- The collision shapes of this library's meshes.


def _of_both_sides(row: ShapeRow) -> tuple[ShapeRow, ...]:
    """Return a shape; one on the left with its mirror image in the xz plane on the right."""
    if not row.name.startswith("L"):
        return (row,)
    (x, y, z), (a, b, c) = row.center_m, row.axis
    name, parent = f"R{row.name[1:]}", f"R{row.parent[1:]}"
    return row, replace(row, name=name, parent=parent, center_m=(x, -y + 0.0, z), axis=(a, -b + 0.0, c))


FITTED_SHAPES = tuple(shape for row in _rows(ShapeRow, _COLLISIONS["shapes"]) for shape in _of_both_sides(row))
DISABLED_COLLISIONS: tuple[tuple[str, str, str], ...] = tuple(
    sorted((one, other, reason) for reason, one, others in _COLLISIONS["unchecked"] for other in others.split())
)


# --- The versions: the tables of the newest one are complete, each other version is a page of changes.

_KINDS: dict[str, Callable[..., Any]] = {
    "offsets": OffsetRow,
    "limits": LimitRow,
    "actuators": ActuatorRow,
    "inertials": InertialRow,
    "frames": FrameRow,
    "cameras": CameraRow,
    "visuals": VisualRow,
}


def _mirrored(row: InertialRow) -> InertialRow:
    """Return the mirror image, in the xz plane, of a link on the left."""
    (x, y, z), (xx, xy, xz, yy, yz, zz) = row.com_m, row.inertia
    return replace(row, link=f"R{row.link[1:]}", com_m=(x, -y, z), inertia=(xx, -xy, xz, yy, -yz, zz))


def tables_of(given: dict[str, Any]) -> dict[str, Any]:
    """Return the tables of a version as `VersionTables` or `VersionPage` takes them."""
    found: dict[str, Any] = {name: _rows(kind, given.get(name, ())) for name, kind in _KINDS.items()}
    left = _rows(InertialRow, given.get("mirrored_inertials", ()))
    found["inertials"] += (*left, *map(_mirrored, left))
    if "placeholder" in given:
        found["placeholder"] = InertialRow("", *map(_value, given["placeholder"]))
    found["colours"] = {name: _value(colour) for name, colour in given.get("colours", {}).items()}
    return found | {name: _value(given[name]) for name in given if name.startswith("without_") or name == "base"}


V6 = VersionTables(**tables_of(_DOCUMENT["versions"]["v6"]))
PAGES: tuple[VersionPage, ...] = tuple(
    VersionPage(version=version, **tables_of(given))
    for version, given in _DOCUMENT["versions"].items()
    if "base" in given
)
TABLES: dict[Version, VersionTables] = {"v6": V6}
"""The complete tables of each version: the tables of its base with the changes of its page."""
for _page in PAGES:
    TABLES[_page.version] = _page.over(TABLES[_page.base])
