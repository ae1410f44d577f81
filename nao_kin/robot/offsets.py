"""Offsets of calibrated joints and frames, applied to the tree of a robot."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import Floats, as_floats, join_poses, split_poses
from nao_kin._core.files import read_toml, write_document
from nao_kin._core.text import quoted
from nao_kin.errors import BadArgument, BadInputFile, NaoKinError, UnknownName, WrongShape, nearest_names
from nao_kin.robot.urdf import Origin, UrdfTree
from nao_kin.rotations import angle_between, check_rotation, matrix_from_rpy, rpy_from_matrix

_KINDS = ("joints", "frames")
# Decimal places of millimetres and degrees in notes: smaller values are rounding errors.
_DIGITS = 6


def with_offsets(tree: UrdfTree, joints: Mapping[str, ArrayLike], frames: Mapping[str, ArrayLike]) -> UrdfTree:
    """Return a tree with calibrated joints and frames, given as for `RobotModel.with_offsets`."""
    moving = {joint.name: joint for joint in tree.moving_joints}
    fixed = {joint.child: joint for joint in tree.joints if joint.kind == "fixed"}
    moved = {joint.child: joint for joint in moving.values()}
    origins: dict[str, Origin] = {}
    notes = []
    for name, value in _entries(joints, "joints"):
        if name not in moving:
            raise UnknownName("joint", name, tuple(moving))
        row, offset = moving[name], as_floats(value, (), f"the offset of {name}")
        if offset.shape != ():
            raise WrongShape(f"the offset of {name}", "()", offset.shape)
        origins[name] = _after(row.origin, row.travel(float(offset)))
        notes.append(f"joint {name}: offset {float(offset):g}")
    for name, value in _entries(frames, "frames"):
        link = tree.shared_names.get(name, name)
        if link in moved or name in moving:
            joint = moved[link].name if link in moved else name
            raise BadArgument(f"frame {quoted(name)} is moved by the joint {joint}; give joints={{{joint!r}: …}}")
        if link not in fixed:
            raise UnknownName("frame", name, tuple(fixed))
        row, T_nominal_true = fixed[link], pose_of(value, f"the offset of {name}")
        origins[row.name] = _after(row.origin, T_nominal_true)
        x, y, z = np.round(1000.0 * T_nominal_true[:3, 3], _DIGITS) + 0.0  # no −0
        turned = np.round(np.degrees(angle_between(np.eye(3), T_nominal_true[:3, :3])), _DIGITS)
        notes.append(f"frame {name}: offset ({x:g}, {y:g}, {z:g}) mm and {turned:.4g}°")
    return replace(
        tree,
        joints=tuple(replace(row, origin=origins.get(row.name, row.origin)) for row in tree.joints),
        notes=(*tree.notes, *notes),
        offsets={**tree.offsets, **origins},
    )


def read_offsets(offsets: Mapping[str, Any] | Path | str) -> dict[str, Mapping[str, Any]]:
    """Return the arguments of `RobotModel.with_offsets` from a mapping with "joints" and "frames", or from a TOML file.

    The file has a table `joints` of numbers, and a table `frames` of six numbers or four rows of four each.
    """
    document = dict(offsets) if isinstance(offsets, Mapping) else read_toml(offsets)
    for kind, table in document.items():
        if kind in _KINDS and isinstance(table, Mapping):
            continue
        fault = f"{kind} must be a table of names and offsets, got {quoted(table)}"
        if kind not in _KINDS:
            near = ", ".join(nearest_names(str(kind), _KINDS) or _KINDS)
            fault = f"unknown entry {quoted(kind)} (nearest: {near})"
        given = isinstance(offsets, Mapping)
        raise BadArgument(f"offsets: {fault}") if given else BadInputFile(str(offsets), fault)
    return document


def write_offsets(path: Path | str, offsets: Mapping[str, Any], *, overwrite: bool = False) -> Path:
    """Write offsets of joints and frames, as `read_offsets` returns them, to a TOML file; return its path."""
    lines = []
    for kind in _KINDS:
        lines.append(f"[{kind}]  # {'rad, or m' if kind == 'joints' else 'dx, dy, dz [m], roll, pitch, yaw [rad]'}")
        for name, value in offsets.get(kind, {}).items():
            # A JSON string is also a TOML string, and a JSON list of numbers a TOML array.
            lines.append(f"{json.dumps(name, ensure_ascii=False)} = {json.dumps(np.asarray(value, float).tolist())}")
    return write_document(path, "\n".join([*lines, ""]).encode(), overwrite=overwrite)[0]


def _entries(offsets: Mapping[str, ArrayLike], what: str) -> list[tuple[str, ArrayLike]]:
    if not isinstance(offsets, Mapping):
        raise BadArgument(f"{what} must map names to offsets, got {quoted(offsets)}")
    return list(offsets.items())


def pose_of(value: ArrayLike, what: str) -> Floats:
    """Return a pose (4, 4) given as a matrix, or as (dx, dy, dz, roll, pitch, yaw)."""
    array = as_floats(value, (), what)
    if array.shape == (6,):
        return join_poses(matrix_from_rpy(array[3:]), array[:3])
    if array.shape != (4, 4):
        raise WrongShape(what, "(6,) or (4, 4)", array.shape)
    R, _ = split_poses(array, what)
    try:
        check_rotation(R)
    except NaoKinError as error:
        raise BadArgument(f"{what}: {error}") from None
    return np.array(array)


def _after(origin: Origin, T: Floats) -> Origin:
    """Return the pose T, given in the frame at `origin`."""
    R = matrix_from_rpy(origin.rpy)
    xyz, rpy = R @ T[:3, 3] + origin.xyz, rpy_from_matrix(R @ T[:3, :3])
    # Without a rotation the angles are copied, and so stay those of the file to the last digit.
    turned = not np.array_equal(T[:3, :3], np.eye(3))
    return Origin(tuple(xyz.tolist()), tuple(np.asarray(rpy).tolist()) if turned else origin.rpy)
