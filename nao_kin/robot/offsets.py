"""Offsets of calibrated joints and frames, applied to the tree of a robot."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import Floats, as_floats, shaped
from nao_kin._core.files import read_toml, write_document
from nao_kin._core.text import nearest_names, quoted
from nao_kin._core.warn import warn_caller
from nao_kin.errors import BadArgument, BadInputFile, DegreesWarning, NaoKinWarning, UnknownName
from nao_kin.robot.semantics_files import camera_of
from nao_kin.robot.urdf import Origin, UrdfTree
from nao_kin.rotations import angle_between, matrix_from_rpy, rpy_from_matrix
from nao_kin.screws import pose_of

# The tables of a file, and what their numbers are.
_KINDS = {
    "joints": "rad, or m",
    "frames": "dx, dy, dz [m], roll, pitch, yaw [rad]",
    "cameras": "width, height, fx, fy, cx, cy, k1, k2, p1, p2 [pixels]",
}
# The table of a file that says where its offsets are from.
_ABOUT = "calibration"
# Decimal places of millimetres and degrees in notes: smaller values are rounding errors.
_DIGITS = 6
# Calibrations find smaller offsets [rad, m]; larger ones are degrees or millimetres, or not offsets.
_LARGE = {"rad": 0.2, "m": 0.1}


def with_offsets(
    tree: UrdfTree, joints: Mapping[str, ArrayLike], frames: Mapping[str, ArrayLike], cameras: Iterable[str] = ()
) -> UrdfTree:
    """Return a tree with calibrated joints and frames, given as for `RobotModel.with_offsets`; `cameras` by name."""
    moving = {joint.name: joint for joint in tree.moving_joints}
    fixed = {joint.child: joint for joint in tree.joints if joint.kind == "fixed"}
    moved = {joint.child: joint for joint in moving.values()}
    origins: dict[str, Origin] = {}
    notes, sizes = list[str](), list[tuple[str, str, float]]()
    for name, value in joints.items():
        if name not in moving:
            hint = f"{quoted(name)} is fixed; give frames={{…}} for its link" if name in tree.fixed_joints else ""
            raise UnknownName("joint", name, tuple(moving), hint)
        row, offset = moving[name], float(shaped(value, (), f"the offset of {name}"))
        origins[name] = _after(row.origin, row.travel(offset))
        notes.append(f"joint {name}: offset {offset:g}")
        sizes.append((name, "m" if row.kind == "prismatic" else "rad", offset))
    for name, value in frames.items():
        # The offset of another frame of a camera moves the body frame, which carries them all.
        body, T_body_frame = camera_of(tree, cameras, name) or (name, np.eye(4))
        link = tree.shared_names.get(body, body)
        if link in moved or name in moving:
            joint = moved[link].name if link in moved else name
            raise BadArgument(f"frame {quoted(name)} is moved by the joint {joint}; give joints={{{joint!r}: …}}")
        if link not in fixed:
            raise UnknownName("frame", name, tuple(fixed))
        row, T_nominal_true = fixed[link], pose_of(value, f"the offset of {name}")
        if row.name in origins:
            raise BadArgument(f"two offsets move {body}; give one, of {body} or of its optical frame")
        origins[row.name] = _after(row.origin, T_body_frame @ T_nominal_true @ T_body_frame.T)
        x, y, z = np.round(1000.0 * T_nominal_true[:3, 3], _DIGITS) + 0.0  # no −0
        angle = angle_between(np.eye(3), T_nominal_true[:3, :3])
        turned = np.round(np.degrees(angle), _DIGITS)
        six = np.ravel(value)
        sizes.append((name, "rad", float(np.abs(six[3:]).max() if len(six) == 6 else angle)))
        sizes.append((name, "m", float(np.linalg.norm(T_nominal_true[:3, 3]))))
        also = "" if body == name else f", moves {body}"
        notes.append(f"frame {name}: offset ({x:g}, {y:g}, {z:g}) mm and {turned:.4g}°{also}")
    _warn_of_large(sizes)
    return replace(
        tree,
        joints=tuple(replace(row, origin=origins.get(row.name, row.origin)) for row in tree.joints),
        notes=(*tree.notes, *notes),
        offsets={**tree.offsets, **origins},
    )


def _warn_of_large(offsets: Sequence[tuple[str, str, float]]) -> None:
    """Warn of offsets (name, unit, value) larger than those of calibrations; refuse angles of more than half a turn."""
    large = [row for row in offsets if abs(row[2]) > _LARGE[row[1]]]
    for name, unit, offset in large:
        if unit == "rad" and abs(offset) > math.pi:
            raise BadArgument(
                f"the offset of {name} is more than half a turn, {offset:g} rad; offsets are in rad and m"
            )
    if large:
        found = ", ".join(
            f"{name} by {f'{math.degrees(offset):.3g}°' if unit == 'rad' else f'{offset:.3g} m'}"
            for name, unit, offset in large
        )
        usual = " and ".join(f"{size:g} {unit}" for unit, size in _LARGE.items())
        warn_caller(
            f"large offsets: {found}; offsets are in rad and m, calibrated ones below {usual}",
            DegreesWarning if any(unit == "rad" for _, unit, _ in large) else NaoKinWarning,
        )


def read_offsets(offsets: Mapping[str, Any] | Path | str) -> dict[str, Any]:
    """Return the arguments of `RobotModel.with_offsets` from a mapping with "joints" and "frames", or from a TOML file.

    The file has a table `joints` of numbers, a table `frames` of six numbers or four rows of four each, and perhaps a
    table `cameras` of measured lenses. A table `calibration` may say where they are from; its `robot` is the argument
    `found_for`.

    Examples:
        >>> nk.robot.read_offsets({"joints": {"LKneePitch": 0.01}})
        {'joints': {'LKneePitch': 0.01}}
    """
    document = dict(offsets) if isinstance(offsets, Mapping) else read_toml(offsets)
    for kind, table in document.items():
        if kind in (*_KINDS, _ABOUT) and isinstance(table, Mapping):
            continue
        if isinstance(offsets, Mapping) and kind == "found_for":
            continue
        fault = f"{kind} must be a table of names and offsets, got {quoted(table)}"
        if kind not in (*_KINDS, _ABOUT):
            near = ", ".join(nearest_names(str(kind), (*_KINDS, _ABOUT)) or _KINDS)
            fault = f"unknown entry {quoted(kind)} (nearest: {near})"
        given = isinstance(offsets, Mapping)
        raise BadArgument(f"offsets: {fault}") if given else BadInputFile(str(offsets), fault)
    about = document.pop(_ABOUT, {})
    return document | ({"found_for": str(about["robot"])} if "robot" in about else {})


def write_offsets(
    path: Path | str,
    offsets: Mapping[str, Any],
    *,
    about: Mapping[str, str | float | Mapping[str, float]] | None = None,
    remarks: Mapping[str, str] | None = None,
    overwrite: bool = False,
) -> Path:
    """Write offsets of joints and frames, as `read_offsets` returns them, to a TOML file; return its path.

    Args:
        path: the file.
        offsets: "joints", "frames" and "cameras".
        about: the table `calibration` of the file, with the name of the "robot".
        remarks: joint or frame → a comment at its line, and "lens of CameraTop" for that of a lens; a name without an
            offset has a line with the comment alone.
        overwrite: replace the file if it exists.

    Examples:
        >>> path = nk.robot.write_offsets("mine.toml", {"joints": {"LKneePitch": 0.01}})
        >>> nk.robot.read_offsets(path)["joints"]
        {'LKneePitch': 0.01}
    """
    lines, tables = [], read_offsets(offsets)
    remarks = dict(remarks or {})
    if about:
        lines += _table(_ABOUT, about)
    for kind, what in _KINDS.items():
        rows, of = tables.get(kind, {}), "lens of " if kind == "cameras" else ""
        if kind == "cameras" and not rows:
            continue
        lines.append(f"[{kind}]  # {what}")
        for name, value in rows.items():
            numbers = as_floats(value, (), f"the offset of {name}").tolist()
            remark = f"  # {remarks.pop(of + name)}" if of + name in remarks else ""
            lines.append(f"{_toml(name)} = {_toml(numbers)}{remark}")
        if kind == "joints":
            with_line = {*tables.get("frames", {}), *(f"lens of {name}" for name in tables.get("cameras", {}))}
            lines += [f"# {name}: {remark}" for name, remark in remarks.items() if name not in with_line]
        lines.append("")
    return write_document(path, "\n".join(lines).encode(), overwrite=overwrite)[0]


def _table(title: str, table: Mapping[str, Any]) -> list[str]:
    """Return the lines of a table of texts and numbers, and then of the tables in it."""
    lines = [f"[{title}]", *(f"{_toml(k)} = {_toml(v)}" for k, v in table.items() if not isinstance(v, Mapping)), ""]
    for name, inner in table.items():
        lines += _table(f"{title}.{name}", inner) if isinstance(inner, Mapping) else []
    return lines


def _toml(value: Any) -> str:
    """Return a text, a number or a list of numbers in TOML, which writes them as JSON does."""
    return json.dumps(value, ensure_ascii=False)


def _after(origin: Origin, T: Floats) -> Origin:
    """Return the pose T, given in the frame at `origin`."""
    R = matrix_from_rpy(origin.rpy)
    xyz, rpy = R @ T[:3, 3] + origin.xyz, rpy_from_matrix(R @ T[:3, :3])
    # Without a rotation the angles are copied, and so stay those of the file to the last digit.
    turned = not np.array_equal(T[:3, :3], np.eye(3))
    return Origin(tuple(xyz.tolist()), tuple(np.asarray(rpy).tolist()) if turned else origin.rpy)
