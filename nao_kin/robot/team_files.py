"""Calibrations in the files of RoboCup teams, as the tables of `read_offsets`.

B-Human's jointCalibration.cfg and cameraCalibration.cfg, of all years; HULKs' JSON of bodies and heads:

    joints = { lHipYawPitch = { offset = -0.5deg; }; };
    cameraRotationCorrections = { upper = {x = -0.3deg; y = -2.7deg; z = 0deg;}; lower = …; };
    bodyRotationCorrection = {x = 1.6deg; y = 0.3deg;};

    {"joint_calibration_offsets": {"left_leg": {"hip_yaw_pitch": -0.2}}}
    {"camera_matrix_parameters": {"calibration": {"correction_in_camera_top": [-0.02, -0.02, 0.0], …},
                                  "vision_top": {"extrinsic_rotations": [-4.4, -2.7, 0.8]}, …}}

Both subtract offsets from reported values. Sources: B-Human's NaoProvider.cpp and CameraMatrix.cpp (bhuman/
BHumanCodeRelease), where R_camera = R_nominal Ry(y) Rx(x) Rz(z) in the axes x ahead, y left, z up, and R_world_torso =
R_measured Ry(y) Rx(x); HULKs' sensor_data_receiver.rs, camera_matrix_calculator.rs and camera_matrix.rs (HULKs/hulk),
where in optical axes R_camera = R_nominal (C E)⁻¹ with the correction C [rad] and the extrinsic rotations E [deg], and
R_world_torso = R_measured C⁻¹ in the robot's axes. Before it had corrections, R_camera = R_nominal E with x ahead
in files that have vision_top outside camera_matrix_parameters.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin._core.files import read_json, read_text
from nao_kin.errors import BadInputFile
from nao_kin.rotations import matrix_from_euler, matrix_from_rpy, rpy_from_matrix

_LINE = r"(?m)^\s*\w+\s*=[^#]*;\s*$"
_TOKEN = r"(\w+)\s*=\s*(?:(\{)|([^;{}]*);)|(\})"
_JOINT = r"(?:joints|offsets)\.(\w+)(?:\.offset)?"
_TURN = (
    r"(?:cameraRotationCorrections\.)?(upper|lower|body)(?:(?:Camera)?RotationCorrection)?\.([xyz])"
    r"|(upper|lower|body)(?:Camera)?(Roll|Tilt|Pan)Correction"
)


def read_team_file(path: Path | str) -> dict[str, Any] | None:
    """Return the tables of a file of B-Human or HULKs, recognised by its content; None for another file."""
    name, found = str(path), dict[str, Any]()
    try:
        text = read_text(name)
        if not text.lstrip().startswith("{") and not re.search(_LINE, text):
            return None
    except (BadInputFile, TypeError):
        return None  # the error is reported where the file is read as TOML
    try:
        found = _of_hulks(read_json(name, text)) if text.lstrip().startswith("{") else _of_b_human(text)
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        raise BadInputFile(name, f"not a calibration as B-Human or HULKs write it: {error}") from None
    if not found["joints"] and not found["frames"]:
        raise BadInputFile(name, "no offsets of joints or cameras, as files of B-Human and HULKs have them")
    # One motor moves both hips: the right one needs an offset of its own even if that is zero.
    hip = found["joints"].get("LHipYawPitch")
    found["joints"] = {k: value for k, value in found["joints"].items() if value or (hip and k == "RHipYawPitch")}
    return found


def _of_b_human(text: str) -> dict[str, Any]:
    joints, turns, path = dict[str, float](), dict[str, dict[str, float]](), list[str]()
    for key, opens, given, closes in re.findall(_TOKEN, re.sub(r"//[^\n]*", "", text)):
        if opens or closes:
            path = [*path, key] if opens else path[:-1]
            continue
        name = ".".join([*path, key])
        joint, turn = re.fullmatch(_JOINT, name), re.fullmatch(_TURN, name)
        if joint or turn:
            unit = np.pi / 180.0 if given.endswith("deg") else 1.0
            value = unit * float(re.sub(r"(deg|rad)$", "", given))
        if joint:
            joints[joint[1][0].upper() + joint[1][1:]] = -value
        if turn:
            axis = "xyzxyz"["xyzRTP".index((turn[2] or turn[4])[0])]
            turns.setdefault(turn[1] or turn[3], {})[axis] = value
    frames = {
        camera: _six(matrix_from_euler([turns[end].get(axis, 0.0) for axis in "yxz"], "yxz", axes="moving"))
        for end, camera in (("upper", "CameraTop"), ("lower", "CameraBottom"))
        if end in turns
    }
    body = turns.get("body", {})
    return _tables(joints, frames, [body.get("x", 0.0), body.get("y", 0.0)])


def _of_hulks(document: Any) -> dict[str, Any]:
    document = document.get("parameters", document)
    joints, frames = dict[str, float](), dict[str, list[float]]()
    for key, unit in (("joint_calibration_offsets", 1.0), ("joint_calibration_offsets_deg", np.pi / 180.0)):
        for limb, rows in document.get(key, {}).items():
            side = {"left": "L", "right": "R"}.get(limb.partition("_")[0], "Head")
            joints |= {side + joint.title().replace("_", ""): -unit * value for joint, value in rows.items()}
    cameras = document.get("camera_matrix_parameters", {})
    corrections, zero = cameras.get("calibration"), [0.0, 0.0, 0.0]
    for end, camera in (("top", "CameraTop"), ("bottom", "CameraBottom")):
        before = document.get(f"vision_{end}", {}).get("camera_matrix_parameters", {}).get("extrinsic_rotations")
        degrees = cameras.get(f"vision_{end}", {}).get("extrinsic_rotations", before)
        E = matrix_from_rpy(np.radians(degrees or zero))
        if before is not None:
            frames[camera] = _six(E)
        elif corrections is not None:
            C = matrix_from_rpy(corrections.get(f"correction_in_camera_{end}", zero))
            frames[f"{camera}_optical_frame"] = _six((C @ E).T)
        elif degrees is not None:
            raise ValueError(
                "extrinsic_rotations may be in the axes of the camera's body (until 2023) or in optical axes; an empty "
                f'"calibration" beside vision_{end} says that they are optical'
            )
    # The turn about z says how the robot stood on the field.
    robot = matrix_from_rpy((corrections or {}).get("correction_in_robot", zero)).T
    return _tables(joints, frames, rpy_from_matrix(robot)[:2].tolist())


def _six(R: Floats) -> list[float]:
    return [0.0, 0.0, 0.0, *rpy_from_matrix(R).tolist()]


def _tables(joints: dict[str, float], frames: dict[str, list[float]], mounting: list[float]) -> dict[str, Any]:
    tables: dict[str, Any] = {"joints": joints, "frames": frames}
    return tables | ({"inertial_unit": {"mounting": mounting}} if any(mounting) else {})
