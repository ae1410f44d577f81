"""What was measured of one robot, in one file: offsets, applied to its tree, lenses, and errors of sensors."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import Floats, as_floats, check_kind, shaped
from nao_kin._core.files import read_toml, write_document
from nao_kin._core.text import nearest_names, quoted, with_underscores
from nao_kin._core.warn import warn_caller
from nao_kin.errors import BadArgument, BadInputFile, DegreesWarning, NaoKinWarning, UnknownName
from nao_kin.robot.semantics import INERTIAL_UNIT
from nao_kin.robot.semantics_files import camera_of
from nao_kin.robot.team_files import read_team_file
from nao_kin.robot.urdf import Origin, UrdfJoint, UrdfTree
from nao_kin.rotations import angle_between, matrix_from_rpy, rpy_from_matrix
from nao_kin.screws import pose_of

# The tables of a file, and what their numbers are.
_KINDS = {
    "joints": "rad, or m",
    "frames": "dx, dy, dz [m], roll, pitch, yaw [rad]",
    "added_frames": "parent; x, y, z [m], roll, pitch, yaw [rad]",
    "cameras": "lenses [pixels], distortion k1, k2, p1, p2[, k3[, k4, k5, k6]]",
    "inertial_unit": "mounting: roll, pitch [rad]; gyro_bias [rad/s]; accelerometer_bias [m/s²]",
    "foot_sensors": "zero [kg], gain",
}
# The entries of a file that are texts, and the members of a lens.
_TEXTS = ("version", "body_id")
_LENS = ("fx", "fy", "cx", "cy")
# The table of a file that says where its offsets are from.
_ABOUT = "calibration"
# Decimal places of millimetres and degrees in notes: smaller values are rounding errors.
_DIGITS = 6
# Calibrations find smaller offsets [rad, m]; larger ones are degrees or millimetres, or not offsets.
_LARGE = {"rad": 0.2, "m": 0.1}
# Tools of a robot are smaller; larger poses of added frames are in millimetres [m].
_FAR = 2.0


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
        angle = angle_between(np.eye(3), T_nominal_true[:3, :3])
        six = np.ravel(value)
        sizes.append((name, "rad", float(np.abs(six[3:]).max() if len(six) == 6 else angle)))
        sizes.append((name, "m", float(np.linalg.norm(T_nominal_true[:3, 3]))))
        also = "" if body == name else f", moves {body}"
        notes.append(f"frame {name}: offset {_in_words(T_nominal_true)}{also}")
    _warn_of_large(sizes)
    return replace(
        tree,
        joints=tuple(replace(row, origin=origins.get(row.name, row.origin)) for row in tree.joints),
        notes=(*tree.notes, *notes),
        offsets={**tree.offsets, **origins},
    )


def with_frames(tree: UrdfTree, frames: Mapping[str, tuple[str, ArrayLike]]) -> UrdfTree:
    """Return a tree with more links, without mass and shapes, fixed to frames, as for `RobotModel.with_frame`."""
    for name, (parent, T) in frames.items():
        joints = [joint.name for joint in tree.joints]
        check_kind(name, "the name of a frame", str)
        if not name.strip() or name in (*tree.links, *tree.shared_names, *joints):
            raise BadArgument(f"{tree.name} cannot have a new frame {quoted(name)}: the name is blank, or in use")
        link = tree.link_of(parent) if isinstance(parent, str) else ""
        if link not in tree.links:
            raise UnknownName("frame", parent, (*tree.shared_names, *tree.links, *joints))
        T_parent_frame = pose_of(T, f"the pose of {name}")
        if (far := float(np.linalg.norm(T_parent_frame[:3, 3]))) > _FAR:
            warn_caller(f"frame {name} is {far:.3g} m from {parent}; poses are in metres", NaoKinWarning)
        joint = with_underscores(f"{name}_joint", {*tree.links, *joints})
        origin = Origin.of(T_parent_frame)
        tree = replace(
            tree,
            links=(*tree.links, name),
            joints=(*tree.joints, UrdfJoint(joint, "fixed", link, name, origin)),
            notes=(*tree.notes, f"frame {name}: added, {_in_words(T_parent_frame)} from {parent}"),
            offsets={**tree.offsets, joint: origin},
            added={**tree.added, name: link},
        )
    return tree


def _in_words(T: Floats) -> str:
    """Return a pose as a translation and an angle."""
    x, y, z = np.round(1000.0 * T[:3, 3], _DIGITS) + 0.0  # no −0
    return f"({x:g}, {y:g}, {z:g}) mm and {np.round(np.degrees(angle_between(np.eye(3), T[:3, :3])), _DIGITS):.4g}°"


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
    """Return the arguments of `RobotModel.with_offsets` from a mapping, or from the file of one robot.

    A TOML file has any of these tables: `joints` of numbers; `frames` of six numbers or four rows of four each;
    `cameras` of lenses {resolution, fx, fy, cx, cy, distortion}; `inertial_unit` with `mounting`, `gyro_bias` and
    `accelerometer_bias`; `foot_sensors` of [zero, gain]; `added_frames` of [parent, six numbers or four rows], as
    `RobotModel.with_frame` takes them; and the texts `version` and `body_id`. A table `calibration`
    may say where they are from; its `robot` is the argument `found_for`. Calibrations in files of B-Human
    (jointCalibration.cfg, cameraCalibration.cfg) and HULKs (JSON of bodies and heads) are recognised and converted.

    Examples:
        >>> nk.robot.read_offsets({"joints": {"LKneePitch": 0.01}, "version": "v5"})
        {'joints': {'LKneePitch': 0.01}, 'version': 'v5'}
    """
    given = isinstance(offsets, Mapping)
    document = dict(offsets) if given else read_team_file(offsets) or read_toml(offsets)  # type: ignore[arg-type]
    known = (*_KINDS, *_TEXTS, _ABOUT)
    try:
        for kind, table in document.items():
            if kind in _TEXTS or (given and kind in ("found_for", "sensors")):
                continue
            if kind not in known:
                near = ", ".join(nearest_names(str(kind), known) or _KINDS)
                raise BadArgument(f"unknown entry {quoted(kind)} (nearest: {near})")
            if not isinstance(table, Mapping):
                raise BadArgument(f"{kind} must be a table of names and offsets, got {quoted(table)}")
        if "cameras" in document:
            document["cameras"] = {name: _lens(name, row) for name, row in document["cameras"].items()}
        if "added_frames" in document:
            rows = document["added_frames"].items()  # a file has the parent and the numbers in one list
            document["added_frames"] = {name: (row[0], row[1] if len(row) == 2 else row[1:]) for name, row in rows}
    except BadArgument as error:
        raise BadArgument(f"offsets: {error}") if given else BadInputFile(str(offsets), str(error)) from None
    about = document.pop(_ABOUT, {})
    sensors = {**document.pop("inertial_unit", {}), **document.pop("foot_sensors", {})}
    document |= {"found_for": str(about["robot"])} if "robot" in about else {}
    return document | ({"sensors": sensors} if sensors else {})


def _lens(camera: str, row: Any) -> list[float]:
    """Return a lens in a table as the numbers that `with_offsets` takes."""
    if not isinstance(row, Mapping):
        return list(row)
    if odd := row.keys() ^ {"resolution", "distortion", *_LENS}:
        what = "resolution, fx, fy, cx, cy and distortion"
        raise BadArgument(f"the lens of {camera} must have {what}; see {quoted(sorted(odd)[0])}")
    return [*row["resolution"], *(row[name] for name in _LENS), *row["distortion"]]


def write_offsets(
    path: Path | str,
    offsets: Mapping[str, Any],
    *,
    about: Mapping[str, str | float | Mapping[str, float]] | None = None,
    remarks: Mapping[str, str] | None = None,
    overwrite: bool = False,
) -> Path:
    """Write what was measured of a robot, as `read_offsets` takes and returns it, to a TOML file; return its path.

    Args:
        path: the file.
        offsets: "joints", "frames", "added_frames", "cameras", "sensors", "version" and "body_id".
        about: the table `calibration` of the file, with the name of the "robot".
        remarks: joint or frame → a comment at its line, and "lens of CameraTop" for that of a lens; a name without an
            offset has a line with the comment alone.
        overwrite: replace the file if it exists.

    Examples:
        >>> path = nk.robot.write_offsets("mine.toml", {"joints": {"LKneePitch": 0.01}})
        >>> nk.robot.read_offsets(path)["joints"]
        {'LKneePitch': 0.01}
    """
    tables, remarks = read_offsets(offsets), dict(remarks or {})
    sensors = tables.get("sensors", {})
    tables["inertial_unit"] = {name: sensors[name] for name in INERTIAL_UNIT if name in sensors}
    tables["foot_sensors"] = {name: row for name, row in sensors.items() if name not in INERTIAL_UNIT}
    lines = [f"{name} = {_toml(tables[name])}" for name in _TEXTS if name in tables]
    lines += [*([""] if lines else []), *(_table(_ABOUT, about) if about else [])]
    for kind, what in _KINDS.items():
        rows, of = tables.get(kind, {}), "lens of " if kind == "cameras" else ""
        if not rows and kind not in ("joints", "frames"):
            continue
        lines.append(f"[{kind}]  # {what}")
        for name, value in rows.items():
            remark = f"  # {remarks.pop(of + name)}" if of + name in remarks else ""
            lines.append(f"{_toml(name)} = {_row_text(kind, name, value)}{remark}")
        if kind == "joints":
            with_line = {*tables.get("frames", {}), *(f"lens of {name}" for name in tables.get("cameras", {}))}
            lines += [f"# {name}: {remark}" for name, remark in remarks.items() if name not in with_line]
        lines.append("")
    return write_document(path, "\n".join(lines).encode(), overwrite=overwrite)[0]


def _row_text(kind: str, name: str, value: Any) -> str:
    """Return the value of a row of a table in TOML."""
    parent, value = (value[:1], value[1]) if kind == "added_frames" else ((), value)
    numbers = as_floats(value, (), f"the numbers of {name}").tolist()
    if kind != "cameras":
        return _toml([*parent, *numbers] if parent else numbers)
    width, height, *rest = numbers
    named = {"resolution": [int(width), int(height)], **dict(zip(_LENS, rest, strict=False)), "distortion": rest[4:]}
    return f"{{ {', '.join(f'{key} = {_toml(part)}' for key, part in named.items())} }}"


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
