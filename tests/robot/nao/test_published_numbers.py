"""Every number of the NAO, entry by entry: as published, in the parameters, and in the model.

The table in data/published_numbers.json was gathered from the public sources that it names, not from this package.
"""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial.transform import Rotation

import nao_kin as nk
from nao_kin.robot.nao import BODY_ORDER, CHAINS, VERSIONS, NaoParameters, nao_parameters
from nao_kin.robot.nao.model import nao_urdf_path
from nao_kin.robot.nao.parameters import PLACEHOLDER
from nao_kin.robot.nao.tables import FINGERS, FITTED_SHAPES, NAOQI_SHAPES, POSTURES

PUBLISHED = json.loads((Path(__file__).parents[2] / "data" / "published_numbers.json").read_text(encoding="utf-8"))
# Sources print π/2 and π with five digits or more, where the model has them in full.
PRINTED_ANGLE = 1e-5
EXACT = 1e-12


@pytest.fixture(scope="module", params=VERSIONS)
def version(request: pytest.FixtureRequest) -> str:
    return request.param


@pytest.fixture(scope="module")
def parameters(version: str) -> NaoParameters:
    return nao_parameters(version)


@pytest.fixture(scope="module")
def robot(version: str) -> nk.NaoModel:
    return nk.load_nao(version)


@pytest.fixture(scope="module")
def urdf(version: str) -> ET.Element:
    return ET.parse(nao_urdf_path(version)).getroot()


def _holds(row: dict[str, Any], version: str) -> bool:
    """Whether a row is for this version: from the oldest one to the newest one unless it says since= or until=."""
    ends = row.get("since", VERSIONS[0]), row.get("until", VERSIONS[-1])
    return VERSIONS.index(ends[0]) <= VERSIONS.index(version) <= VERSIONS.index(ends[1])


def _published(table: str, version: str, key: str) -> dict[str, dict[str, Any]]:
    """The rows of one table that hold for one version, by name."""
    rows = [row for row in PUBLISHED[table] if _holds(row, version)]
    found = {row[key]: row for row in rows}
    assert len(found) == len(rows)
    return found


def _off(name: str, what: str, got: object, wanted: object, tolerance: float = EXACT) -> Iterator[str]:
    """A line when two numbers, or two arrays of them, differ."""
    found, expected = np.asarray(got, dtype=float), np.asarray(wanted, dtype=float)
    if found.shape != expected.shape or not np.allclose(found, expected, rtol=0.0, atol=tolerance):
        yield f"{name} {what}: {got} is not {wanted}"


def _rotation(rpy: object) -> np.ndarray:
    """Rz(yaw) Ry(pitch) Rx(roll)."""
    return Rotation.from_euler("xyz", rpy).as_matrix()


def _limits_in_radians(row: dict[str, Any]) -> tuple[float, float]:
    lower, upper = row["range"]
    return (math.radians(lower), math.radians(upper)) if row["unit"] == "deg" else (lower, upper)


def _joint_elements(urdf: ET.Element) -> dict[str, ET.Element]:
    return {joint.get("name", ""): joint for joint in urdf.findall("joint")}


def _floats(element: ET.Element | None, attribute: str) -> list[float]:
    assert element is not None
    return [float(text) for text in element.get(attribute, "").split()]


def test_every_published_row_names_its_source() -> None:
    tables = [rows for rows in PUBLISHED.values() if isinstance(rows, list) and isinstance(rows[0], dict)]
    assert len(tables) == 11
    named = {code for rows in tables for row in rows for code in row["source"].split()}
    assert named == PUBLISHED["sources"].keys()


# --- joints -----------------------------------------------------------------------------------------------------------


def test_the_orders_and_the_chains_are_the_published_ones(robot: nk.NaoModel) -> None:
    assert list(BODY_ORDER) == list(robot.body_order) == PUBLISHED["body_order"]
    for chains in (CHAINS, robot.chains):
        assert {name: list(joints) for name, joints in chains.items()} == PUBLISHED["chains"]
        assert list(chains) == list(PUBLISHED["chains"])


def test_offsets_are_the_published_ones(version: str, parameters: NaoParameters) -> None:
    rows = _published("offsets", version, "name")
    assert parameters.offsets.keys() == rows.keys()
    wrong = [line for name, row in rows.items() for line in _off(name, "m", parameters.offsets[name], row["mm"] / 1000)]
    assert wrong == []


def test_joints_sit_and_turn_as_published(version: str, parameters: NaoParameters, robot: nk.NaoModel) -> None:
    rows = _published("joints", version, "joint")
    assert [joint.name for joint in parameters.joints] == list(rows)
    neutral, wrong = robot.neutral(), []
    for joint in parameters.joints:
        row = rows[joint.name]
        origin, axis = np.array(row["origin_mm"]) / 1000, np.array(row["axis"]) / np.linalg.norm(row["axis"])
        assert (joint.chain, joint.parent, joint.mimic) == (row["chain"], row["parent"], row.get("same_motor_as"))
        wrong += _off(joint.name, "origin", joint.xyz, origin)
        wrong += _off(joint.name, "axis", joint.axis, axis)
        pose = robot.fk(neutral, joint.name, reference=row["parent"])
        wrong += _off(joint.name, "pose in the model", pose[:3], np.column_stack([np.eye(3), origin]))
        turned = robot.configuration({joint.name: 0.4}, limits="ignore")
        turn = robot.rotation(turned, joint.name, reference=row["parent"])
        wrong += _off(joint.name, "turn in the model", turn, Rotation.from_rotvec(0.4 * axis).as_matrix())
    assert wrong == []


def test_ranges_are_the_published_ones(
    version: str, parameters: NaoParameters, robot: nk.NaoModel, urdf: ET.Element
) -> None:
    rows, elements, wrong = _published("limits", version, "joint"), _joint_elements(urdf), []
    assert rows.keys() == {joint.name for joint in parameters.joints}
    for joint in parameters.joints:
        row = rows[joint.name]
        wanted = _limits_in_radians(row)
        assert joint.unit == ("rad" if row["unit"] == "deg" else row["unit"])
        wrong += _off(joint.name, "range", (joint.lower, joint.upper), wanted)
        limit = elements[joint.name].find("limit")
        wrong += _off(joint.name, "range in the URDF", _floats(limit, "lower") + _floats(limit, "upper"), wanted)
        if joint.name in robot.joint_names:
            column = robot.joint_names.index(joint.name)
            assert robot.joint_units[column] == joint.unit
            wrong += _off(joint.name, "range of the robot", (robot.lower[column], robot.upper[column]), wanted)
            q = robot.model.joints[robot.model.getJointId(joint.name)].idx_q
            bounds = robot.model.lowerPositionLimit[q], robot.model.upperPositionLimit[q]
            wrong += _off(joint.name, "range in the model", bounds, wanted)
    assert wrong == []


def test_speeds_and_torques_are_the_published_ones(
    version: str, parameters: NaoParameters, robot: nk.NaoModel, urdf: ET.Element
) -> None:
    rows, elements, wrong = _published("actuators", version, "joint"), _joint_elements(urdf), []
    assert rows.keys() == {joint.name for joint in parameters.joints}
    for joint in parameters.joints:
        row = rows[joint.name]
        wanted = row["velocity"], row["effort"]
        wrong += _off(joint.name, "speed and torque", (joint.velocity, joint.effort), wanted)
        limit = elements[joint.name].find("limit")
        wrong += _off(joint.name, "in the URDF", _floats(limit, "velocity") + _floats(limit, "effort"), wanted)
        if joint.name in robot.joint_names:
            column = robot.joint_names.index(joint.name)
            wrong += _off(
                joint.name, "of the robot", (robot.velocity_limits[column], robot.effort_limits[column]), wanted
            )
            v = robot.model.joints[robot.model.getJointId(joint.name)].idx_v
            wrong += _off(
                joint.name, "in the model", (robot.model.upperVelocityLimit[v], robot.model.upperEffortLimit[v]), wanted
            )
    assert wrong == []


def test_coupled_ranges_are_the_published_tables(version: str, parameters: NaoParameters, robot: nk.NaoModel) -> None:
    rows, wrong = _published("coupled_limits", version, "joint"), []
    for tables in (parameters.coupled_limits, robot.coupled_limits):
        assert {table.joint: table.of for table in tables} == {joint: row["of"] for joint, row in rows.items()}
        for table in tables:
            columns = np.degrees([table.at, table.lower, table.upper]).T
            wrong += _off(table.joint, "table [deg]", columns, rows[table.joint]["deg"])
    for joint, row in rows.items():
        of = np.array(row["deg"])
        for bound, sign in ((1, -1.0), (2, 1.0)):
            far = robot.configuration({row["of"]: np.radians(of[:, 0]), joint: sign * 2.0}, limits="ignore")
            # What the box allows and the table allows at the published places, and nothing wider.
            driver, driven = robot.joint_names.index(row["of"]), robot.joint_names.index(joint)
            box = np.degrees([robot.lower[driven], robot.upper[driven]])
            inside = np.radians(of[:, 0]) == np.clip(np.radians(of[:, 0]), robot.lower[driver], robot.upper[driver])
            got = np.degrees(robot.clamp(far)[inside, driven])
            wrong += _off(joint, "clamped to its table [deg]", got, np.clip(of[inside, bound], *box), 1e-9)
    assert wrong == []


# --- bodies -----------------------------------------------------------------------------------------------------------


def _tensor(six: Sequence[float]) -> np.ndarray:
    ixx, ixy, ixz, iyy, iyz, izz = six
    return np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]], dtype=float)


def _inertia(row: dict[str, Any]) -> pin.Inertia:
    return pin.Inertia(float(row["kg"]), np.array(row["com_m"], dtype=float), _tensor(row["inertia"]))


def test_masses_centres_and_tensors_are_the_published_ones(
    version: str, parameters: NaoParameters, robot: nk.NaoModel
) -> None:
    rows, wrong = _published("inertials", version, "link"), []
    placeholder, feet = PUBLISHED["placeholder"], _published("frames", version, "frame")
    has_placeholders = _holds(placeholder, version)
    assert parameters.inertials.keys() == rows.keys()
    assert (version in PLACEHOLDER.versions) == has_placeholders
    wrong += _off("placeholder", "kg", PLACEHOLDER.mass_kg, placeholder["kg"])
    wrong += _off("placeholder", "tensor", PLACEHOLDER.inertia, placeholder["inertia"], 1e-20)
    for link, row in rows.items():
        ours = parameters.inertials[link]
        wrong += _off(link, "kg", ours.mass_kg, row["kg"])
        wrong += _off(link, "centre of mass", ours.com_m, row["com_m"])
        wrong += _off(link, "tensor", ours.inertia, row["inertia"], 1e-18)
        expected = _inertia(row)
        if has_placeholders and link in ("LAnkleRoll", "RAnkleRoll"):
            for place in ("FrontLeft", "FrontRight", "RearLeft", "RearRight"):
                sensor = np.array(feet[f"{link[0]}Foot/FSR/{place}"]["xyz_m"])
                expected += pin.SE3(np.eye(3), sensor).act(_inertia(placeholder))
        moved = robot.model.inertias[0 if link == "torso" else robot.model.getJointId(link)]
        wrong += _off(link, "kg in the model", moved.mass, expected.mass)
        wrong += _off(link, "centre of mass in the model", moved.lever, expected.lever)
        wrong += _off(link, "tensor in the model", moved.inertia, expected.inertia, 1e-16)
    fingers = [name for name in robot.mimics if name != "RHipYawPitch"]
    for name in ("LHand", "RHand", *fingers):
        moved = robot.model.inertias[robot.model.getJointId(name)]
        wrong += _off(name, "kg in the model", moved.mass, placeholder["kg"] * has_placeholders, 1e-18)
        wrong += _off(name, "centre of mass in the model", moved.lever, placeholder["com_m"])
        tensor = _inertia(placeholder).inertia * has_placeholders
        wrong += _off(name, "tensor in the model", moved.inertia, tensor, 1e-18)
    bodies = math.fsum(row["kg"] for row in rows.values())
    wrong += _off(version, "kg in all", robot.mass, bodies + 26 * placeholder["kg"] * has_placeholders)
    assert wrong == []


def test_tensors_about_the_joint_are_the_documented_ones(version: str, parameters: NaoParameters) -> None:
    """The documentation prints I + m (c² E − c cᵀ): the URDF's tensor, carried from the centre of mass c to the joint.

    The URDFs have six digits; what a row allows is half of the last one. The figures of V6 were computed from the URDF
    itself, with 1.5708 for π/2 on the way.
    """
    wrong: list[str] = []
    for row in _published("inertia_at_joint", version, "link").values():
        ours = parameters.inertials[row["link"]]
        body = pin.Inertia(ours.mass_kg, np.array(ours.com_m), _tensor(ours.inertia))
        # About the origin: the lower right block of the spatial inertia.
        wrong += _off(row["link"], "tensor", body.matrix()[3:, 3:], _tensor(row["inertia_at_joint"]), row["within"])
    assert wrong == []


# --- frames and fingers -----------------------------------------------------------------------------------------------


def test_frames_stand_where_they_were_published(version: str, parameters: NaoParameters, robot: nk.NaoModel) -> None:
    rows, wrong = _published("frames", version, "frame"), []
    ours = {frame.name: frame for frame in parameters.frames}
    cameras = {name for name in rows if name.endswith("_optical_frame")}
    assert ours.keys() == rows.keys() - cameras
    configurations = np.stack([robot.neutral(), robot.random(0)])
    for name, row in rows.items():
        if name in ours:
            assert ours[name].parent == row["parent"]
            wrong += _off(name, "place", ours[name].xyz, row["xyz_m"])
            wrong += _off(name, "rotation", _rotation(ours[name].rpy), _rotation(row["rpy"]), PRINTED_ANGLE)
        twins = [name] if name in cameras or ours[name].ros_name is None else [name, ours[name].ros_name]
        for frame, q in itertools.product(twins, configurations):
            T = robot.fk(q, frame, reference=row["parent"])
            wrong += _off(frame, "place in the model", T[:3, 3], row["xyz_m"])
            wrong += _off(frame, "rotation in the model", T[:3, :3], _rotation(row["rpy"]), PRINTED_ANGLE)
    assert wrong == []


def test_fingers_are_hinged_as_published(version: str, robot: nk.NaoModel) -> None:
    rows, wrong = _published("fingers", version, "joint"), []
    ours = {f"{side}{row.name}": (side, row) for side in "LR" for row in FINGERS}
    assert ours.keys() == rows.keys()
    assert len(robot.mimics) == 1 + len(rows)
    for name, row in rows.items():
        side, finger = ours[name]
        joint = f"{side}Hand{finger.name}"
        parent = f"{side}WristYaw" if finger.parent == "WristYaw" else f"{side}{finger.parent}_link"
        assert parent == row["parent"]
        wrong += _off(name, "place", finger.xyz_m, row["xyz_m"])
        wrong += _off(name, "rotation", _rotation(finger.rpy), _rotation(row["rpy"]), PRINTED_ANGLE)
        mimic = robot.mimics[joint]
        assert (mimic.joint, mimic.multiplier, mimic.offset) == (row["follows"], row["multiplier"], 0.0)
        for opening in (0.0, 0.5, 1.0):
            T = robot.fk(robot.configuration({f"{side}Hand": opening}), joint, reference=row["parent"])
            turn = Rotation.from_rotvec(row["multiplier"] * opening * np.array(row["axis"])).as_matrix()
            wrong += _off(name, "place in the model", T[:3, 3], row["xyz_m"])
            wrong += _off(name, f"rotation at {opening}", T[:3, :3], _rotation(row["rpy"]) @ turn, PRINTED_ANGLE)
    assert wrong == []


# --- shapes -----------------------------------------------------------------------------------------------------------


def _corners(size: object, rotation: np.ndarray) -> np.ndarray:
    """The eight corners of a box about its centre, in an order that does not depend on how it is described."""
    signs = np.array(list(itertools.product((-0.5, 0.5), repeat=3)))
    corners = (signs * np.asarray(size, dtype=float)) @ rotation.T
    return corners[np.lexsort(np.round(corners, 9).T)]


def _shape_off(row: dict[str, Any], kind: str, size: object, rotation: np.ndarray, where: str) -> Iterator[str]:
    name = row["shape"]
    assert kind == row["kind"], f"{name} {where}"
    if kind == "box":
        wanted = _corners(row["size_m"], np.array(row["rotation"], dtype=float))
        yield from _off(name, f"corners {where}", _corners(size, rotation), wanted)
    else:
        yield from _off(name, f"size {where}", size, row["size_m"])
    if kind == "cylinder":
        # An axis has no sense: a cylinder turned end for end is the same.
        axis = np.array(row["axis"]) / np.linalg.norm(row["axis"])
        yield from _off(name, f"axis {where}", np.cross(rotation[:, 2], axis), np.zeros(3))


def test_the_parameters_hold_the_published_collision_shapes() -> None:
    rows, wrong = {row["shape"]: row for row in PUBLISHED["collision_shapes"]}, []
    assert {shape.name: shape.parent for shape in NAOQI_SHAPES} == {n: row["parent"] for n, row in rows.items()}
    assert len(NAOQI_SHAPES) == len(rows)
    for shape in NAOQI_SHAPES:
        row = rows[shape.name]
        wrong += _off(shape.name, "centre", shape.center_m, row["centre_m"])
        turn = (
            Rotation.align_vectors([shape.axis], [[0.0, 0.0, 1.0]])[0].as_matrix()
            if shape.kind == "cylinder"
            else np.eye(3)
        )
        wrong += _shape_off(row, shape.kind, shape.size_m, turn, "in the parameters")
    assert wrong == []


def test_the_urdf_holds_the_fitted_collision_shapes(version: str, robot: nk.NaoModel, urdf: ET.Element) -> None:
    assert nk.parameters.nao_parameters(version).naoqi_shapes == NAOQI_SHAPES
    found = {
        shape.get("name", ""): (link, shape) for link in urdf.findall("link") for shape in link.findall("collision")
    }
    rows = {row.name: row for row in FITTED_SHAPES}
    ends = {f"{row.name}{end}" for row in FITTED_SHAPES if row.kind == "capsule" for end in ("Start", "End")}
    assert found.keys() == rows.keys() | ends
    for row in FITTED_SHAPES:
        link, shape = found[row.name]
        carried = robot.fk(robot.random(0), link.get("name", ""), reference=row.parent)
        np.testing.assert_allclose(carried, np.eye(4), atol=1e-12)
        np.testing.assert_allclose(_floats(shape.find("origin"), "xyz"), row.center_m, atol=1e-12)
        (geometry,) = shape.findall("geometry/*")
        names = {"sphere": ("radius",), "cylinder": ("radius", "length"), "box": ("size",)}[geometry.tag]
        assert tuple(value for name in names for value in _floats(geometry, name)) == row.size_m
        if row.kind == "capsule":
            z = _rotation(_floats(shape.find("origin"), "rpy"))[:, 2]
            for end, sign in (("Start", -0.5), ("End", 0.5)):
                of, cap = found[f"{row.name}{end}"]
                at = _floats(cap.find("origin"), "xyz")
                assert of is link
                np.testing.assert_allclose(at, np.array(row.center_m) + sign * row.size_m[1] * z, atol=1e-7)


# --- postures ---------------------------------------------------------------------------------------------------------


def test_postures_are_the_published_ones(robot: nk.NaoModel) -> None:
    rows, wrong = {row["posture"]: row["body"] for row in PUBLISHED["postures"]}, []
    ours = {row.name: row.body for row in POSTURES}
    assert list(robot.posture_names) == list(ours) == list(rows)
    for name, body in rows.items():
        wrong += _off(name, "Body values", ours[name], body)
        wrong += _off(name, "of the robot", robot.to_body(robot.posture(name)), body)
    assert wrong == []
