from __future__ import annotations

import math

import numpy as np
import pytest
from ik_checks import BESIDE, Floats
from scipy.spatial import cKDTree

import nao_kin as nk
from nao_kin.errors import BadArgument, NotFinite, UnknownName, WrongShape
from nao_kin.ik import Family, Reason
from nao_kin.rotations import matrix_from_quat, rot_x, rot_z

CAMERAS = ("CameraTop", "CameraBottom")


def angles_to(nao: nk.NaoModel, q: Floats, camera: str, points: Floats) -> Floats:
    """Between the optical axis and the direction to a point."""
    T = nao.fk(q, camera)
    towards = points - T[..., :3, 3]
    across = np.linalg.norm(np.cross(T[..., :3, 0], towards), axis=-1)
    return np.arctan2(across, np.einsum("...i,...i->...", T[..., :3, 0], towards))


@pytest.mark.parametrize("frame", ["Head", *CAMERAS])
def test_every_orientation_of_the_head_brings_the_configuration_back(each_nao: nk.NaoModel, frame: str) -> None:
    q = each_nao.random(1, 3000)
    found = nk.ik.head(each_nao, each_nao.rotation(q, frame), frame=frame, near=q)
    assert np.all(found.success)
    np.testing.assert_allclose(found.q, q, atol=1e-12)
    assert found.residual.max() < 1e-10


@pytest.mark.parametrize("camera", CAMERAS)
def test_a_camera_looks_at_a_point_exactly(each_nao: nk.NaoModel, camera: str) -> None:
    rng = np.random.default_rng(2)
    q = each_nao.random(rng, 3000)
    T = each_nao.fk(q, camera)
    points = T[:, :3, 3] + (10.0 ** rng.uniform(-2, 1, 3000))[:, None] * T[:, :3, 0]
    found = nk.ik.look_at(each_nao, points, camera)
    assert np.all(found.success)
    assert np.abs(found.branches[:, 0] - q[:, :2]).max() < 1e-11
    assert angles_to(each_nao, found.q, camera, points).max() < 1e-10
    assert each_nao.within_limits(found.q).all()
    both = nk.ik.look_at(each_nao, points, camera, limits="ignore")
    assert (both.count == 2).all()
    for k in range(2):
        assert angles_to(each_nao, both.solutions[:, k], camera, points).max() < 1e-10


@pytest.mark.parametrize("frame", ["CameraBottom_optical_frame", "CameraBottom_frame"])
def test_another_frame_of_a_camera_looks_along_the_same_axis(nao: nk.NaoModel, frame: str) -> None:
    point = np.array([0.9, 0.3, 0.1])
    found = nk.ik.look_at(nao, point, frame)
    assert np.array_equal(found.q, nk.ik.look_at(nao, point, "CameraBottom").q)
    T_optical = nao.fk(found.q, "CameraBottom_optical_frame")
    assert np.abs((np.linalg.inv(T_optical) @ np.append(point, 1.0))[:2]).max() < 1e-9
    both = [
        nk.ik.whole_body(nao, {}, gaze=(point, name), near=nao.posture("StandInit")) for name in (frame, "CameraBottom")
    ]
    assert both[0].success
    assert np.array_equal(both[0].q, both[1].q)


def test_all_solutions_of_an_exhaustive_search_are_found(nao: nk.NaoModel) -> None:
    optimize = pytest.importorskip("scipy.optimize")
    point = np.array([0.4, -0.3, 0.35])
    found = nk.ik.look_at(nao, point, "CameraBottom", limits="ignore")

    def error(values: Floats) -> Floats:
        q = np.zeros(25)
        q[:2] = np.mod(values + math.pi, 2 * math.pi) - math.pi
        T = nao.fk(q, "CameraBottom")
        towards = point - T[:3, 3]
        return np.asarray(towards / np.linalg.norm(towards) - T[:3, 0])

    seen = set()
    for start in np.random.default_rng(3).uniform(-math.pi, math.pi, (40, 2)):
        end = optimize.least_squares(error, start, xtol=1e-14, ftol=1e-14, gtol=1e-14)
        if end.cost < 1e-20:
            gaps = np.abs(np.mod(found.branches - end.x + math.pi, 2 * math.pi) - math.pi).max(axis=-1)
            assert gaps.min() < 1e-6
            seen.add(int(np.argmin(gaps)))
    assert len(seen) == found.count == 2


def test_the_nearest_orientation_is_as_good_as_a_fine_scan_finds(nao: nk.NaoModel) -> None:
    rng = np.random.default_rng(4)
    quaternions = rng.normal(size=(40, 4))
    R = matrix_from_quat(quaternions / np.linalg.norm(quaternions, axis=1)[:, None])
    scan = nao.random(rng, 40000)
    made = nao.rotation(scan, "Head")
    found = nk.ik.head(nao, R)
    assert nao.within_limits(found.q).all()
    assert not np.any(found.success)
    assert (found.count == 0).all()
    best = np.array([np.arccos(np.clip((np.einsum("nij,ij->n", made, r).max() - 1) / 2, -1, 1)) for r in R])
    assert (found.residual[:, 1] < best + 1e-9).all()
    assert (found.residual[:, 1] > best - 0.03).all()
    one = nk.ik.head(nao, R[0])
    np.testing.assert_allclose(one.q, found.q[0], atol=1e-6)


@pytest.mark.parametrize("camera", CAMERAS)
def test_the_nearest_look_is_as_good_as_a_fine_scan_finds(nao: nk.NaoModel, camera: str) -> None:
    rng = np.random.default_rng(5)
    points = rng.normal(scale=0.5, size=(60, 3))
    scan = nao.random(rng, 40000)
    found = nk.ik.look_at(nao, points, camera)
    assert nao.within_limits(found.q).all()
    T = nao.fk(scan, camera)
    for point, angle, q in zip(points, found.residual[:, 1], found.q, strict=True):
        towards = point - T[:, :3, 3]
        cosines = np.einsum("ni,ni->n", towards, T[:, :3, 0]) / np.linalg.norm(towards, axis=1)
        best = math.acos(cosines.max())
        assert best - 0.03 < angle < best + 1e-9
        assert angle == pytest.approx(float(angles_to(nao, q, camera, point)), abs=1e-9)


@pytest.mark.parametrize("camera", CAMERAS)
def test_no_look_of_a_grid_is_nearer_to_a_point_beside_the_neck(nao: nk.NaoModel, camera: str) -> None:
    rng = np.random.default_rng(6)
    towards = rng.normal(size=(60, 3))
    towards *= rng.uniform(0.005, 0.12, (60, 1)) / np.linalg.norm(towards, axis=1, keepdims=True)
    points = nao.position(nao.neutral(), "Head") + towards
    yaws, pitches = np.meshgrid(*(np.linspace(nao.lower[k], nao.upper[k], 200) for k in range(2)))
    scan = np.zeros((40000, nao.nq))
    scan[:, 0], scan[:, 1] = yaws.ravel(), pitches.ravel()
    T = nao.fk(nao.clamp(scan), camera)
    found = nk.ik.look_at(nao, points, camera)
    assert (~np.asarray(found.success)).sum() > 30
    assert nao.within_limits(found.q).all()
    for point, angle in zip(points, found.residual[:, 1], strict=True):
        seen = point - T[:, :3, 3]
        cosines = np.einsum("ni,ni->n", seen, T[:, :3, 0]) / np.linalg.norm(seen, axis=1)
        assert angle < math.acos(min(1.0, cosines.max())) + 1e-9


def test_what_is_in_the_way_is_said(nao: nk.NaoModel) -> None:
    turned = nk.ik.head(nao, rot_z(2.5))
    assert turned.reason is Reason.JOINT_LIMIT
    assert str(turned.message).startswith("HeadYaw needs 2.5 rad, limit 2.09; the nearest pose is off by")
    assert turned.q[0] == pytest.approx(2.0857, abs=1e-3)
    coupled = nk.ik.head(
        nao, nao.rotation(nao.configuration({"HeadYaw": 1.5, "HeadPitch": 0.5}, limits="ignore"), "Head")
    )
    assert coupled.reason is Reason.COUPLED_LIMIT
    assert "HeadPitch needs 0.5 rad, coupled limit there 0.2" in str(coupled.message)
    assert nk.ik.head(nao, rot_x(0.2)).reason is Reason.NOT_ENOUGH_JOINTS
    assert nk.ik.head(nao, rot_x(0.2)).residual[1] == pytest.approx(0.2, abs=1e-9)
    assert nk.ik.look_at(nao, [-1.0, 0.0, 0.3]).reason is Reason.JOINT_LIMIT


def test_a_point_inside_the_head_is_too_near(nao: nk.NaoModel) -> None:
    neck = nao.position(nao.neutral(), "HeadPitch")
    found = nk.ik.look_at(nao, np.add(neck, [0.02, 0.0, 0.0]))
    assert found.reason is Reason.OUT_OF_REACH
    camera = nao.position(nao.neutral(), "CameraTop") - neck
    assert found.obstacles.needed == pytest.approx(np.linalg.norm(camera) - 0.02, abs=1e-12)
    assert nao.within_limits(found.q).all()


@pytest.mark.parametrize("beside", BESIDE)
def test_a_point_above_the_neck_and_beside_that(nao: nk.NaoModel, beside: float) -> None:
    neck = nao.position(nao.neutral(), "HeadPitch")
    reference = nao.configuration({"HeadYaw": 0.7})
    point = np.add(neck, [beside, 0.0, 0.8])
    found = nk.ik.look_at(nao, point, limits="ignore", near=reference)
    assert found.success
    assert angles_to(nao, found.solutions, "CameraTop", point).max() < 1e-10
    if beside < 1e-12:
        assert found.family is Family.YAW_AXIS
        assert found.q[0] == 0.7


def test_of_a_free_yaw_the_nearest_that_allows_the_pitch_is_taken() -> None:
    # A camera that looks up from where it is, so that the point above needs a pitch that only some yaws allow.
    nao = nk.load_nao("v6")
    tilt = -math.pi / 2 + 0.45
    frame = nao.model.frames[nao.frame_ids(["CameraTop"])[0]]
    placement = frame.placement.copy()
    placement.rotation = np.array(
        [[math.cos(tilt), 0, math.sin(tilt)], [0, 1, 0], [-math.sin(tilt), 0, math.cos(tilt)]]
    )
    frame.placement = placement
    point = np.add(nao.position(nao.neutral(), "HeadPitch"), [0.0, 0.0, 0.9])
    free = nk.ik.look_at(nao, point, limits="ignore")
    needed = free.q[1]
    assert -0.6 < needed < -0.4
    reference = nao.configuration({"HeadYaw": 1.5, "HeadPitch": -0.3})
    found = nk.ik.look_at(nao, point, near=reference)
    assert found.success
    assert found.family is Family.YAW_AXIS
    assert nao.within_limits(found.q).all()
    table = nao.coupled_limits[0]
    allowed = [yaw for yaw in np.linspace(0.0, 2.0, 20001) if table.range(np.array(yaw))[0] <= needed]
    assert found.q[0] == pytest.approx(min(allowed, key=lambda yaw: abs(yaw - 1.5)), abs=1e-3)


# --- positions of a frame on the head ---------------------------------------------------------------------------------

MARKERS = ("CameraTop", "HeadTouchFront_frame", "SpeakerLeft", "SpeakerRight")


@pytest.mark.parametrize("frame", MARKERS)
def test_every_position_of_a_frame_on_the_head_brings_the_configuration_back(each_nao: nk.NaoModel, frame: str) -> None:
    q = each_nao.random(1, 1000)
    found = nk.ik.head(each_nao, position=each_nao.position(q, frame), frame=frame, near=q)
    assert np.all(found.success)
    np.testing.assert_allclose(found.q, q, atol=1e-10)
    assert found.residual.max() < 1e-15
    both = nk.ik.head(each_nao, position=each_nao.position(q, frame), frame=frame, limits="ignore")
    assert (both.count == 2).all()
    for k in range(2):
        off = each_nao.position(both.solutions[:, k], frame) - each_nao.position(q, frame)
        assert np.abs(off).max() < 1e-15


@pytest.mark.parametrize("frame", MARKERS)
def test_the_nearest_position_is_as_good_as_a_fine_scan_finds(nao: nk.NaoModel, frame: str) -> None:
    rng = np.random.default_rng(3)
    neck = nao.position(nao.neutral(), "Head")
    places = neck + rng.normal(size=(100, 3)) * 0.1
    for limits in ("enforce", "ignore"):
        found = nk.ik.head(nao, position=places, frame=frame, limits=limits)  # type: ignore[arg-type]
        assert (found.reasons == Reason.OUT_OF_REACH).all()
        distances = np.linalg.norm(nao.position(found.q, frame) - places, axis=-1)
        np.testing.assert_allclose(found.residual, np.stack([distances, 0.0 * distances], axis=-1), rtol=0, atol=1e-15)
        assert np.isnan(found.solutions).all()
        scan = nao.random(rng, 100_000)
        if limits == "ignore":
            scan[:, :2] = rng.uniform(-np.pi, np.pi, (100_000, 2))
        else:
            assert nao.within_limits(found.q).all()
            at_most = found.obstacles.needed
        nearest = cKDTree(nao.position(scan, frame)).query(places)[0]
        assert (distances <= nearest + 1e-12).all()
        assert np.median(nearest - distances) < 1e-4
    # How far the target is out of reach does not depend on the limits.
    np.testing.assert_allclose(at_most, distances, rtol=0, atol=1e-15)


def test_positions_are_met_on_a_sphere_without_caps_and_else_the_nearest_is_found(nao: nk.NaoModel) -> None:
    neck = nao.position(nao.neutral(), "Head")
    o = nao.position(nao.neutral(), "SpeakerLeft") - neck
    radius, beside = np.linalg.norm(o), abs(o[1])
    assert beside > 0.03
    directions = np.random.default_rng(4).normal(size=(2000, 3)) * np.repeat(
        [[0.5, 0.5, 1.0], [1.0, 1.0, 0.3]], 1000, axis=0
    )
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    across = np.linalg.norm(directions[:, :2], axis=1)
    outside_caps = radius * across >= beside
    assert 0.1 < outside_caps.mean() < 0.9
    height = np.copysign(np.sqrt(radius**2 - beside**2), directions[:, 2])
    edge = np.column_stack([beside * directions[:, :2] / across[:, None], height])
    nearest = np.where(outside_caps[:, None], radius * directions, edge)
    for scale in (1.0, 0.5, 1.5):
        wanted = scale * radius * directions
        found = nk.ik.head(nao, position=neck + wanted, frame="SpeakerLeft", limits="ignore")
        assert np.array_equal(found.success, outside_caps & (scale == 1.0))
        assert np.array_equal(found.count, 2 * found.success)
        np.testing.assert_allclose(nao.position(found.q, "SpeakerLeft") - neck, nearest, atol=1e-7)
        np.testing.assert_allclose(found.residual[:, 0], np.linalg.norm(nearest - wanted, axis=1), atol=1e-12)


def test_a_position_on_the_sphere_outside_the_limits_names_the_joint(nao: nk.NaoModel) -> None:
    q = nao.configuration({"HeadYaw": [2.6, 0.3, 0.0], "HeadPitch": [0.1, 1.0, 0.4]}, limits="ignore")
    found = nk.ik.head(nao, position=nao.position(q, "CameraTop"), frame="CameraTop")
    assert found.reasons.tolist() == [Reason.JOINT_LIMIT, Reason.JOINT_LIMIT, Reason.REACHED]
    assert found.obstacles.joint.tolist() == [0, 1, -1]
    np.testing.assert_allclose(found.obstacles.needed, [2.6, 1.0, 0.0], atol=1e-9)
    scan = cKDTree(nao.position(nao.random(0, 300_000), "CameraTop")).query(nao.position(q, "CameraTop"))[0]
    assert (found.residual[:, 0] <= scan).all()
    assert (found.residual[:2, 0] > scan[:2] - 1e-3).all()


def test_a_marker_measured_to_a_millimetre_gives_the_head_to_a_few_degrees(nao: nk.NaoModel) -> None:
    rng = np.random.default_rng(5)
    q = nao.random(rng, 500)
    measured = nao.position(q, "HeadTouchFront_frame") + 1e-3 * rng.normal(size=(500, 3))
    found = nk.ik.head(nao, position=measured, frame="HeadTouchFront_frame", near=q)
    assert (np.abs(found.residual[:, 0]) < 5e-3).all()
    turned = nao.rotation(found.q, "Head").swapaxes(-1, -2) @ nao.rotation(q, "Head")
    assert np.median(np.linalg.norm(nk.rotations.log(turned), axis=-1)) < 0.03


def test_positions_above_the_neck_in_it_and_of_calibrated_and_floating_heads(nao: nk.NaoModel) -> None:
    neck = nao.position(nao.neutral(), "Head")
    radius = float(np.linalg.norm(nao.position(nao.neutral(), "CameraTop", reference="Head")))
    above = nk.ik.head(nao, position=np.add(neck, [0.0, 0.0, radius]), frame="CameraTop", limits="ignore")
    assert above.success is True
    assert above.family is Family.YAW_AXIS
    inside = nk.ik.head(nao, position=neck, frame="CameraTop")
    assert inside.reason is Reason.OUT_OF_REACH
    assert float(inside.obstacles.needed) == pytest.approx(radius)
    assert np.isnan(inside.q).all()
    mine = nao.with_offsets(
        {"HeadYaw": 0.05, "HeadPitch": -0.03}, {"CameraTop": (0.001, 0.004, 0.002, 0.01, 0.02, 0.0)}
    )
    free = nk.load_nao(base="floating")
    for robot in (mine, free):
        q = robot.random(2, 50)
        p = robot.position(q, "CameraTop", reference="torso")
        found = nk.ik.head(robot, position=p, frame="CameraTop", near=q)
        assert np.all(found.success)
        np.testing.assert_allclose(found.q, q, atol=1e-10)
    one = nk.ik.head(mine, position=mine.position(mine.random(2), "CameraTop"), frame="CameraTop", collisions=True)
    assert one.q.shape == (25,)
    assert nk.ik.head(nao, position=np.empty((0, 2, 3)), frame="CameraTop").q.shape == (0, 2, 25)


def test_bad_positions_are_refused(nao: nk.NaoModel) -> None:
    for wrong in ({}, {"position": [0.1, 0.0, 0.2], "target": np.eye(3)}):
        with pytest.raises(BadArgument, match="give one of target and position"):
            nk.ik.head(nao, frame="CameraTop", **wrong)  # type: ignore[arg-type]
    with pytest.raises(BadArgument, match="frame 'Head' is in the neck, which has one position"):
        nk.ik.head(nao, position=[0.1, 0.0, 0.2])
    with pytest.raises(NotFinite, match=r"position.*\[1\]"):
        nk.ik.head(nao, position=[0.1, np.nan, 0.2], frame="CameraTop")
    with pytest.raises(WrongShape, match=r"position must have shape \(\.\.\., 3\)"):
        nk.ik.head(nao, position=np.eye(4), frame="CameraTop")
    with pytest.raises(BadArgument, match="not carried by HeadPitch"):
        nk.ik.head(nao, position=[0.1, 0.0, 0.2], frame="LArm")


def test_batches_keep_their_shape(nao: nk.NaoModel) -> None:
    points = np.add(np.random.default_rng(6).normal(size=(2, 3, 3)), [2.0, 0.0, 0.0])
    found = nk.ik.look_at(nao, points)
    assert found.q.shape == (2, 3, 25)
    np.testing.assert_allclose(nk.ik.look_at(nao, points[1, 2]).q, found.q[1, 2], atol=1e-12)
    assert nk.ik.look_at(nao, np.empty((0, 3))).q.shape == (0, 25)


def test_bad_input_is_refused(nao: nk.NaoModel) -> None:
    with pytest.raises(UnknownName, match="CameraTop"):
        nk.ik.look_at(nao, [1.0, 0.0, 0.0], "CameraTopp")
    with pytest.raises(BadArgument, match="not carried by HeadPitch"):
        nk.ik.look_at(nao, [1.0, 0.0, 0.0], "LArm")
