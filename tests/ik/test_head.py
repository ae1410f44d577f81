from __future__ import annotations

import math

import numpy as np
import pytest
from ik_checks import BESIDE, Floats

import nao_kin as nk
from nao_kin.errors import BadArgument, NotARotation, NotFinite, UnknownName
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
    with pytest.raises(NotFinite):
        nk.ik.look_at(nao, [1.0, math.inf, 0.0])
    with pytest.raises(NotARotation):
        nk.ik.head(nao, 2.0 * np.eye(3))
    with pytest.raises(BadArgument, match=r"point must not exceed 1e\+150"):
        nk.ik.look_at(nao, [1e155, 0.0, 0.0])
    for camera in (["CameraTop"], np.array(["CameraTop"]), None):
        with pytest.raises(UnknownName, match="camera"):
            nk.ik.look_at(nao, [1.0, 0.0, 0.0], camera)  # type: ignore[arg-type]
    with pytest.raises(UnknownName, match="frame"):
        nk.ik.head(nao, np.eye(3), frame=["Head"])  # type: ignore[arg-type]
