"""The ground that cameras see, compared with OpenCV, searched intersections, finite differences and Monte Carlo."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from loops import every_value
from made_up_robots import J, made_up

import nao_kin as nk
from nao_kin.errors import BadArgument, UnknownName, WrongShape
from nao_kin.world import Camera

_LENS = (-0.25, 0.1, 0.002, -0.001, -0.02)
_K = [[558.0, 0.0, 317.0], [0.0, 561.0, 243.0], [0.0, 0.0, 1.0]]
ENDS = "", "_optical_frame"
_POSTURES = ("StandInit", "Crouch", "Stand", "StandZero")


def _lensed(camera: Camera) -> Camera:
    return Camera("lens", camera.frame, 640, 480, 558.0, 561.0, 317.0, 243.0, _LENS)


def _pose(rng: np.random.Generator, spread: float = 0.3) -> np.ndarray:
    R = nk.rotations.matrix_from_rpy(rng.normal(scale=spread, size=3))
    return nk.screws.pose(R, [*rng.normal(size=2), 0.5 + rng.uniform(0.0, 0.2)])


@pytest.fixture(scope="module")
def nao() -> nk.NaoModel:
    return nk.load_nao()


def test_pixels_of_points_in_the_world_are_those_of_opencv(nao: nk.NaoModel) -> None:
    cv2 = pytest.importorskip("cv2", reason="OpenCV is not installed")
    rng = np.random.default_rng(5)
    for name in ("CameraTop", "CameraBottom"):
        camera = _lensed(nk.world.camera(nao, name))
        q, T_world_base = nao.random(rng), _pose(rng)
        T_world_optical = T_world_base @ nao.fk(q, f"{name}_optical_frame")
        T = np.linalg.inv(T_world_optical)
        seen = np.column_stack([rng.uniform(-0.5, 0.5, (200, 2)), np.ones(200)]) * rng.uniform(0.3, 5.0, (200, 1))
        points = seen @ T_world_optical[:3, :3].T + T_world_optical[:3, 3]
        expected, _ = cv2.projectPoints(points, cv2.Rodrigues(T[:3, :3])[0], T[:3, 3], camera.matrix, np.array(_LENS))
        found = nk.world.project(nao, q, points, camera, T_world_base=T_world_base)
        assert np.abs(found.pixels - expected[:, 0]).max() < 1e-6
        assert (found.visible == camera.sees(expected[:, 0])).all()
        assert found.visible.any()
        assert not found.visible.all()


def test_a_camera_mounted_at_its_optical_frame_sees_what_opencv_sees(nao: nk.NaoModel) -> None:
    cv2 = pytest.importorskip("cv2", reason="OpenCV is not installed")
    q = nao.posture("StandInit", HeadYaw=0.3, HeadPitch=0.2)
    T_world_base = nao.set_down(q).T_world_base
    body, optical = (Camera.from_matrix(_K, _LENS, frame=f"CameraTop{end}", size=(640, 480)) for end in ENDS)
    T = np.linalg.inv(T_world_base @ nao.fk(q, "CameraTop_optical_frame"))
    points = np.array([[1.0, 0.3, 0.0], [2.0, 1.0, 0.1], [1.5, 0.5, 0.0]])
    expected, _ = cv2.projectPoints(points, cv2.Rodrigues(T[:3, :3])[0], T[:3, 3], body.matrix, np.array(_LENS))
    found = nk.world.project(nao, q, points, optical)
    assert found.visible.all()
    assert np.abs(found.pixels - expected[:, 0]).max() < 1e-6
    ground = nk.world.pixel_to_ground(nao, q, found.pixels[[0, 2]], optical)
    assert np.abs(ground.points - points[[0, 2]]).max() < 1e-9
    assert np.abs(np.subtract(*[nk.world.camera_pose(nao, q, one) for one in (body, optical)])).max() < 1e-12
    assert np.abs(np.subtract(*[nk.world.visible_ground(nao, q, one) for one in (body, optical)])).max() < 1e-9
    covariances = [nk.world.ground_covariance(nao, q, [300, 400], one, joint_noise=0.01) for one in (body, optical)]
    assert covariances[0] == pytest.approx(covariances[1])


def test_an_optical_frame_is_known_by_its_name_in_any_robot_and_by_the_semantics_under_any_name(tmp_path: Path) -> None:
    tiago = nk.load_robot("tiago")
    camera = Camera.from_matrix(_K, frame="xtion_rgb_optical_frame", size=(640, 480))
    q = tiago.neutral()
    T_optical = tiago.fk(q, camera.frame, reference=tiago.tree.root)
    T = nk.world.camera_pose(tiago, q, camera, T_world_base=np.eye(4))
    assert np.abs(T[:3, 0] - T_optical[:3, 2]).max() < 1e-12  # x of the body frame is z of the optical frame
    assert T[2, 2] > 0.9
    optical = {"rpy": (-1.5708, 0.0, -1.5708), "kind": "fixed"}  # as rounded in many files
    joints = J("neck"), J("eye", xyz=(0.1, 0.0, 0.0), kind="fixed"), J("image", **optical)  # type: ignore[arg-type]
    plain = made_up(tmp_path, *joints)
    robot = nk.RobotModel(plain.tree, nk.semantics.Semantics(cameras=("eye_l",)))
    at_eye, at_image = (
        nk.world.camera_pose(robot, [0.5], Camera.from_matrix(_K, frame=f"{name}_l", size=(640, 480)),
                             T_world_base=np.eye(4))
        for name in ("eye", "image")
    )  # fmt: skip
    assert np.abs(at_eye - at_image).max() < 1e-5
    moved = robot.with_offsets(frames={"image_l": (0.0, 0.0, 0.02, 0.0, 0.0, 0.0)})
    assert moved.fk([0.0], "eye_l")[:3, 3] == pytest.approx([0.12, 0.0, 0.0])
    camera = Camera.from_matrix(_K, frame="image_l", size=(640, 480))
    unknown = nk.world.camera_pose(plain, [0.5], camera, T_world_base=np.eye(4))
    assert np.array_equal(unknown, plain.fk([0.5], "image_l"))  # no camera, no ending: a body frame


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**31), st.booleans(), st.sampled_from([-0.1, 0.0, 0.05, 3.0]))
def test_the_ground_at_a_pixel_is_projected_to_that_pixel(seed: int, lens: bool, height: float) -> None:
    nao, rng = nk.load_nao(), np.random.default_rng(seed)
    camera = nk.world.camera(nao, ("CameraTop", "CameraBottom")[seed % 2])
    camera = _lensed(camera) if lens else camera
    q, T_world_base = nao.random(rng, n=4), _pose(rng, 0.6)
    pixels = rng.uniform([-0.5, -0.5], [639.5, 479.5], (5, 4, 2))
    found = nk.world.pixel_to_ground(nao, q, pixels, camera, T_world_base=T_world_base, height=height)
    assert found.points.shape == (5, 4, 3)
    assert (np.isfinite(found.points).all(axis=-1) == found.valid).all()
    assert np.abs(found.points[found.valid, 2] - height).max(initial=0.0) < 1e-6 * (
        1 + np.nanmax(np.abs(found.points), initial=0)
    )
    again = nk.world.project(nao, q, np.nan_to_num(found.points), camera, T_world_base=T_world_base)
    assert np.abs(again.pixels - pixels)[found.valid].max(initial=0.0) < 1e-6
    # The other rays lead away from the plane: each of their points is on the eye's side of it.
    T = nk.world.camera_pose(nao, q, camera, T_world_base=T_world_base)
    towards = np.einsum("qj,pqj->pq", T[:, 2, :3], camera.ray(pixels)) * np.sign(height - T[:, 2, 3])
    assert (found.valid == (towards > 0.0)).all()


def test_without_a_pose_the_robot_stands_on_the_floor(nao: nk.NaoModel) -> None:
    for posture in _POSTURES:
        q = nao.posture(posture)
        bottom = nk.world.camera(nao, "CameraBottom")
        point = nk.world.pixel_to_ground(nao, q, [320.0, 400.0], bottom).points
        T_sole_base = nk.screws.inverse(nao.fk(q, "LLeg"))
        T_world_sole = nao.set_down(q).T_world_base @ nao.fk(q, "LLeg")
        in_sole = nk.screws.transform_point(nk.screws.inverse(T_world_sole), point)
        assert abs(in_sole[2]) < 0.006  # the floor is the plane of a sole that is flat on it
        given_base = nk.world.pixel_to_ground(nao, q, [320.0, 400.0], bottom, T_world_base=T_sole_base)
        assert np.linalg.norm(given_base.points - in_sole) < 0.03


def test_a_floating_base_sees_the_same_ground(nao: nk.NaoModel) -> None:
    floating, q = nk.load_nao(base="floating"), nao.posture("StandInit", HeadYaw=0.3)
    q_floating = floating.posture("StandInit", HeadYaw=0.3)
    q_floating[:7] = [
        0.3,
        -0.2,
        0.9,
        *nk.rotations.quat_to_xyzw(nk.rotations.quat_from_matrix(nk.rotations.matrix_from_rpy([0.3, 0.2, 0.5]))),
    ]
    camera, pixels = nk.world.camera(nao, "CameraBottom"), np.array([[100.0, 200.0], [500.0, 400.0]])
    results = [nk.world.pixel_to_ground(robot, at, pixels, camera) for robot, at in ((nao, q), (floating, q_floating))]
    assert np.abs(results[0].points - results[1].points).max() < 1e-9
    covariances = [
        nk.world.ground_covariance(robot, at, pixels, camera, joint_noise=0.01)
        for robot, at in ((nao, q), (floating, q_floating))
    ]
    assert np.abs(covariances[0] - covariances[1]).max() < 1e-12


def test_a_pixel_above_the_horizon_is_nan_in_a_batch_and_an_error_alone(nao: nk.NaoModel) -> None:
    q, camera = nao.posture("StandInit"), nk.world.camera(nao, "CameraTop")
    rows = nk.world.horizon(nao, q, camera).pixels[16, 1] + np.array([-1.0, 1.0])
    pixels = np.column_stack([np.full(2, 320.0), rows])
    found = nk.world.pixel_to_ground(nao, q, pixels, camera)
    assert found.valid.tolist() == [False, True]
    assert np.isnan(found.points[0]).all()
    with pytest.raises(BadArgument, match=r"pixel \(320, 165\.\d+\) of CameraTop shows no point .* above the horizon"):
        nk.world.pixel_to_ground(nao, q, pixels[0], camera)
    covariance = nk.world.ground_covariance(nao, q, pixels, camera, joint_noise=0.01)
    assert np.isnan(covariance[0]).all()
    assert np.isfinite(covariance[1]).all()
    with pytest.raises(BadArgument, match="above the horizon"):
        nk.world.ground_covariance(nao, q, pixels[0], camera, joint_noise=0.01)
    with pytest.raises(BadArgument, match="not in front of CameraTop"):
        nk.world.project(nao, q, [-1.0, 0.0, 0.0], camera)


def test_a_pixel_outside_the_image_shows_nothing_and_alone_names_the_resolution_that_fits(nao: nk.NaoModel) -> None:
    q, camera = nao.posture("StandInit"), nk.world.camera(nao, "CameraTop")
    pixels = np.array([[639.4, 479.4], [639.5, 479.0], [1000.0, 700.0], [-0.6, 400.0], [np.nan, np.nan]])
    found = nk.world.pixel_to_ground(nao, q, pixels, camera)
    assert found.valid.tolist() == [True, False, False, False, False]
    assert np.isfinite(found.points).all(axis=-1).tolist() == found.valid.tolist()
    covariance = nk.world.ground_covariance(nao, q, pixels, camera, joint_noise=0.01)
    assert np.isfinite(covariance).all(axis=(1, 2)).tolist() == found.valid.tolist()
    says = r"\(1000, 700\) is outside the image of CameraTop, 640 × 480 pixels \(VGA\); 4VGA, 1280 × 960, contains it"
    for ask in (nk.world.pixel_to_ground, partial(nk.world.ground_covariance, joint_noise=0.01)):
        with pytest.raises(BadArgument, match=says):
            ask(nao, q, [1000.0, 700.0], camera)
    for robot, pixel in ((nao, [-1.0, 400.0]), (nk.load_nao("v3.3"), [1000.0, 700.0])):
        with pytest.raises(BadArgument, match=r"640 × 480 pixels \(VGA\)$"):
            nk.world.pixel_to_ground(robot, q, pixel, camera)
    grabbed = nk.world.pixel_to_ground(nao, q, [1000.0, 700.0], nk.world.camera(nao, "CameraTop", "4VGA")).points
    assert grabbed == pytest.approx(nk.world.pixel_to_ground(nao, q, [499.75, 349.75], camera).points)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**31), st.booleans())
def test_the_horizon_divides_rays_that_go_up_from_those_that_go_down(seed: int, lens: bool) -> None:
    nao, rng = nk.load_nao(), np.random.default_rng(seed)
    plain = nk.world.camera(nao, "CameraTop")
    camera = _lensed(plain) if lens else plain
    q, T_world_base = nao.random(rng, n=6), _pose(rng)
    found = nk.world.horizon(nao, q, camera, T_world_base=T_world_base)
    assert found.line.shape == (6, 3)
    assert np.linalg.norm(found.line[:, :2], axis=-1) == pytest.approx(1.0)
    T = nk.world.camera_pose(nao, q, camera, T_world_base=T_world_base)
    pixels = rng.uniform([0, 0], [640, 480], (6, 50, 2))
    straight = camera.normalised(pixels) * (camera.fx, camera.fy) + (camera.cx, camera.cy)
    side = np.einsum("nk,npk->np", found.line[:, :2], straight) + found.line[:, 2:]
    heights = np.einsum("nk,npk->np", T[:, 2, :3], camera.ray(pixels))
    assert ((side > 0.0) == (heights < 0.0)).all()
    # On the horizon rays are level; it is visible if the image has both kinds of rays.
    level = np.einsum("nk,npk->np", T[:, 2, :3], camera.ray(found.pixels))
    assert np.abs(level[found.visible]).max(initial=0.0) < 1e-9
    assert np.isnan(found.pixels[~found.visible]).all()
    both = (heights > 0.0).any(axis=-1) & (heights < 0.0).any(axis=-1)
    assert (found.visible | ~both).all()
    inside = camera.sees(found.pixels[:, 1:-1])
    assert (inside == found.visible[:, None]).mean() > 0.95
    assert (found.pixels[found.visible][:, 0, 0] <= found.pixels[found.visible][:, -1, 0]).all()


def test_a_camera_that_looks_straight_down_has_its_horizon_at_infinity(nao: nk.NaoModel) -> None:
    camera = nk.world.camera(nao, "CameraTop")
    q = nao.neutral()
    for angle, sign in ((np.pi / 2, 1.0), (-np.pi / 2, -1.0)):
        T_world_camera = nk.screws.pose(nk.rotations.rot_y(angle), [0.0, 0.0, 1.0])
        T_world_base = T_world_camera @ nk.screws.inverse(nao.fk(q, "CameraTop"))
        found = nk.world.horizon(nao, q, camera, T_world_base=T_world_base)
        assert found.line.tolist() == pytest.approx([0.0, 0.0, sign])
        assert not found.visible
        polygon = nk.world.visible_ground(nao, q, camera, T_world_base=T_world_base)
        across, high = (2.0 * np.tan(angle / 2) for angle in nao.semantics.fields_of_view["CameraTop"])
        assert len(polygon) == (4 if sign > 0 else 0)
        if sign > 0:
            assert np.ptp(polygon, axis=0).tolist() == pytest.approx([high, across, 0.0], abs=1e-9)


def _contains(polygon: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Whether a ray from each point crosses the edges an odd number of times."""
    (x, y), (ax, ay) = points.T[..., None], polygon.T
    bx, by = np.roll(polygon, -1, axis=0).T
    with np.errstate(divide="ignore", invalid="ignore"):
        crossed = ((ay > y) != (by > y)) & (x < ax + (y - ay) / (by - ay) * (bx - ax))
    return np.asarray(crossed.sum(axis=1) % 2 == 1)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**31), st.booleans())
def test_a_point_is_in_the_visible_polygon_if_and_only_if_its_pixel_is_in_the_image(seed: int, lens: bool) -> None:
    nao, rng = nk.load_nao(), np.random.default_rng(seed)
    plain = nk.world.camera(nao, ("CameraTop", "CameraBottom")[seed % 2])
    camera = _lensed(plain) if lens else plain
    q, T_world_base = nao.random(rng), _pose(rng)
    polygon = nk.world.visible_ground(nao, q, camera, T_world_base=T_world_base, max_distance=4.0)
    batch = nk.world.visible_ground(nao, np.stack([q, q]), camera, T_world_base=T_world_base, max_distance=4.0)
    assert np.array_equal(batch[1][np.isfinite(batch[1, :, 0])], polygon)
    T = nk.world.camera_pose(nao, q, camera, T_world_base=T_world_base)
    points = np.column_stack([T[:2, 3] + rng.uniform(-5.0, 5.0, (400, 2)), np.zeros(400)])
    forward = T[:2, 0] / np.linalg.norm(T[:2, 0])
    near = (points[:, :2] - T[:2, 3]) @ forward < 4.0
    visible = nk.world.project(nao, q, points, camera, T_world_base=T_world_base).visible & near
    contained = _contains(polygon[:, :2], points[:, :2])
    wrong = visible != contained
    assert not wrong.any() if not lens else wrong.mean() < 0.01  # a curved edge is drawn with corners


@pytest.mark.parametrize(("lens", "support"), every_value([True, False], [None, "RLeg", "torso", "LArm"]))
def test_derivatives_behind_the_covariance_are_differences(nao: nk.NaoModel, lens: bool, support: str | None) -> None:
    q, pixel, step = nao.posture("StandInit", HeadYaw=0.4, HeadPitch=0.2), np.array([400.0, 300.0]), 1e-6
    camera = nk.world.camera(nao, "CameraTop")
    camera = _lensed(camera) if lens else camera
    down = nao.set_down(q)
    still = support or down.soles[int(down.touching.argmax())]
    T_world_still = down.T_world_base @ nao.fk(q, still)

    def point(q: np.ndarray, pixel: np.ndarray) -> np.ndarray:
        """The ground at a pixel, while the support stays where it is."""
        T_world_base = T_world_still @ nk.screws.inverse(nao.fk(q, still))
        return nk.world.pixel_to_ground(nao, q, pixel, camera, T_world_base=T_world_base).points[:2]

    G = [(point(q + step * e, pixel) - point(q - step * e, pixel)) / (2 * step) for e in np.eye(nao.nq)]
    H = [(point(q, pixel + step * e) - point(q, pixel - step * e)) / (2 * step) for e in np.eye(2)]
    sigma = np.linspace(0.001, 0.02, nao.nv)
    expected = np.einsum("ki,k,kj->ij", G, sigma**2, G) + 0.25 * np.einsum("ki,kj->ij", H, H)
    found = nk.world.ground_covariance(nao, q, pixel, camera, joint_noise=sigma, pixel_noise=0.5, support=support)
    assert found == pytest.approx(expected, rel=1e-5, abs=1e-9)
    full = nk.world.ground_covariance(
        nao, q, pixel, camera, joint_noise=np.diag(sigma**2), pixel_noise=0.5, support=support
    )
    assert full == pytest.approx(found)


def test_the_covariance_is_the_spread_of_noisy_measurements(nao: nk.NaoModel) -> None:
    rng, n = np.random.default_rng(2), 20_000
    q, pixel, camera = nao.posture("StandInit"), np.array([250.0, 400.0]), nk.world.camera(nao, "CameraTop")
    T_world_base = nao.set_down(q).T_world_base
    head = (
        [nao.velocity_names.index(name) for name in ("HeadYaw", "HeadPitch")]
        if hasattr(nao, "velocity_names")
        else [0, 1]
    )
    sigma = np.zeros(nao.nv)
    sigma[head] = np.radians(0.3)
    noisy = q + sigma * rng.normal(size=(n, nao.nq))
    pixels = pixel + 0.7 * rng.normal(size=(n, 2))
    points = nk.world.pixel_to_ground(nao, noisy, pixels, camera, T_world_base=T_world_base).points[:, :2]
    expected = np.cov(points.T)
    found = nk.world.ground_covariance(
        nao, q, pixel, camera, joint_noise=sigma, pixel_noise=0.7, T_world_base=T_world_base
    )
    scale = np.sqrt(np.diag(expected))
    assert np.abs((found - expected) / np.outer(scale, scale)).max() < 0.05


@pytest.mark.parametrize("support", [None, "RLeg", "torso"])
def test_a_robot_that_tilts_moves_its_points_as_the_noise_of_its_base_says(
    nao: nk.NaoModel, support: str | None
) -> None:
    q, pixel, step = nao.posture("StandInit", HeadYaw=0.4), np.array([400.0, 300.0]), 1e-6
    camera = _lensed(nk.world.camera(nao, "CameraTop"))
    own = nk.screws.pose(nk.rotations.matrix_from_rpy([0.2, 0.1, 0.7]), [0.3, 0.1, 0.34])
    # Roll and pitch of the set down robot are zero, those of the given pose are not.
    for T in (None, own):
        down = nao.set_down(q)
        still = support or ("torso" if T is not None else down.soles[int(down.touching.argmax())])
        base = down.T_world_base if T is None else T
        rpy, foot = nk.rotations.rpy_from_matrix(base[:3, :3]), nao.position(q, still)

        def point(change: np.ndarray, base: np.ndarray = base, rpy: np.ndarray = rpy, foot: np.ndarray = foot) -> Any:
            """The ground at the pixel after a change of roll, pitch and height about the support."""
            R = nk.rotations.matrix_from_rpy(rpy + np.array([change[0], change[1], 0.0]))
            place = base[:3, :3] @ foot + base[:3, 3] - R @ foot + [0.0, 0.0, change[2]]
            return nk.world.pixel_to_ground(nao, q, pixel, camera, T_world_base=nk.screws.pose(R, place)).points[:2]

        G = np.array([(point(step * e) - point(-step * e)) / (2.0 * step) for e in np.eye(3)])
        sigma = np.array([0.02, 0.03, 0.008])
        noise = {"joint_noise": 0.0, "pixel_noise": 0.0, "T_world_base": T, "support": support}
        found = nk.world.ground_covariance(nao, q, pixel, camera, base_noise=sigma, **noise)
        assert found == pytest.approx(np.einsum("ki,k,kj->ij", G, sigma**2, G), rel=1e-5, abs=1e-9)
        for short, full in ((0.02, [0.02, 0.02, 0.0]), ([0.02, 0.03], [0.02, 0.03, 0.0])):
            one, other = (
                nk.world.ground_covariance(nao, q, pixel, camera, base_noise=b, **noise) for b in (short, full)
            )
            assert np.array_equal(one, other)
    parts = [
        nk.world.ground_covariance(nao, q, pixel, camera, joint_noise=j, base_noise=b, pixel_noise=p)
        for j, b, p in ((0.01, 0.02, 1.0), (0.01, 0.0, 0.0), (0.0, 0.02, 0.0), (0.0, 0.0, 1.0))
    ]
    assert parts[0] == pytest.approx(sum(parts[1:]))


def test_the_covariance_of_a_tilting_robot_is_the_spread_of_its_measurements(nao: nk.NaoModel) -> None:
    rng, n = np.random.default_rng(4), 20_000
    q, pixel, camera = nao.posture("StandInit"), np.array([250.0, 400.0]), nk.world.camera(nao, "CameraTop")
    T, sigma = nao.set_down(q).T_world_base, np.array([0.01, 0.015, 0.004])
    noise = sigma * rng.normal(size=(n, 3))
    noisy = np.broadcast_to(T, (n, 4, 4)).copy()
    rpy = nk.rotations.rpy_from_matrix(T[:3, :3]) + np.column_stack([noise[:, :2], np.zeros(n)])
    noisy[:, :3, :3] = nk.rotations.matrix_from_rpy(rpy)
    noisy[:, 2, 3] += noise[:, 2]
    points = nk.world.pixel_to_ground(nao, q, pixel, camera, T_world_base=noisy).points[:, :2]
    expected, scale = np.cov(points.T), points.std(axis=0)
    found = nk.world.ground_covariance(
        nao, q, pixel, camera, joint_noise=0.0, base_noise=sigma, pixel_noise=0.0, T_world_base=T
    )
    assert np.abs((found - expected) / np.outer(scale, scale)).max() < 0.06


# --- Uprights.


@pytest.mark.parametrize("lens", [False, True])
def test_the_position_of_a_post_is_found_from_its_height(nao: nk.NaoModel, lens: str) -> None:
    camera, rng = (
        _lensed(nk.world.camera(nao, "CameraTop")) if lens else nk.world.camera(nao, "CameraTop"),
        np.random.default_rng(1),
    )
    q = nao.posture("StandInit", HeadYaw=0.1)
    T_world_base = nao.set_down(q).T_world_base @ nk.screws.pose(nk.rotations.matrix_from_rpy([0.05, 0.1, 0]), [0] * 3)
    feet = np.column_stack([rng.uniform(2.0, 6.0, 40), rng.uniform(-0.4, 0.4, 40), np.zeros(40)])
    tops = feet + np.array([0.0, 0.0, nk.world.SPL.post_height])
    both = np.stack([feet, tops], axis=-2)
    pixels = nk.world.project(nao, q, both, camera, T_world_base=T_world_base)
    shown = pixels.visible.all(axis=-1)
    find = partial(nk.world.upright_position, nao, q, camera=camera, T_world_base=T_world_base)
    by_height = find(pixels.pixels, height=nk.world.SPL.post_height)
    assert (by_height.valid == shown).all()
    assert shown.sum() > 20
    assert np.abs(by_height.points - feet)[shown].max() < 1e-6


def test_wrong_uprights_are_named(nao: nk.NaoModel) -> None:
    q, camera = nao.posture("StandInit"), nk.world.camera(nao, "CameraTop")
    find = partial(nk.world.upright_position, nao, q, camera=camera)
    pair = [[320.0, 300.0], [320.0, 100.0]]
    for size in (0.0, -1.0, np.nan, "tall", [0.8]):
        with pytest.raises(nk.NaoKinError, match="height"):
            find(pair, height=size)
    with pytest.raises(WrongShape, match="pixels of uprights"):
        find([[320.0, 300.0]], height=0.8)
    with pytest.raises(BadArgument, match="are not the foot and the top of an upright object in CameraTop"):
        find(pair[::-1], height=0.8)  # upside down
    with pytest.raises(BadArgument, match=r"\(320, 300\) and \(320, 300\) are not the foot"):
        find([pair[0], pair[0]], height=0.8)
    with pytest.raises(BadArgument, match=r"one of the pixels \(320, 900\) and .* is outside the image of CameraTop"):
        find([[320.0, 900.0], [320.0, 100.0]], height=0.8)
    several = find([pair, pair[::-1], [[320.0, 900.0], [320.0, 100.0]], [[np.nan] * 2, [320.0, 100.0]]], height=0.8)
    assert several.valid.tolist() == [True, False, False, False]
    assert np.isfinite(several.points).all(axis=-1).tolist() == several.valid.tolist()


# --- Rolling shutter.


def _row_by_row(nao: nk.NaoModel, motion: Any, base: Any, point: np.ndarray, camera: Camera, row_time: float) -> Any:
    """The pixel in a simulated image: the row that shows the point when it is exposed, between two rows."""
    rows = np.arange(camera.height)
    moments = row_time * rows
    seen = nk.world.project(nao, motion(moments), np.tile(point, (len(rows), 1)), camera, T_world_base=base(moments))
    gap = seen.pixels[:, 1] - rows
    k = int(np.flatnonzero(np.sign(gap[:-1]) != np.sign(gap[1:]))[0])
    share = gap[k] / (gap[k] - gap[k + 1])
    return seen.pixels[k] + share * (seen.pixels[k + 1] - seen.pixels[k])


@pytest.mark.parametrize("lens", [False, True])
def test_a_rolling_shutter_sees_each_point_when_its_row_is_exposed(nao: nk.NaoModel, lens: bool) -> None:
    camera, row_time = nk.world.camera(nao, "CameraTop"), 0.037 / 480
    camera = _lensed(camera) if lens else camera
    q, standing = nao.posture("StandInit"), nao.set_down(nao.posture("StandInit")).T_world_base
    columns = [nao.joint_names.index(name) for name in ("HeadYaw", "HeadPitch")]

    def motion(t: np.ndarray) -> np.ndarray:
        moved = np.tile(q, (*np.shape(t), 1))
        moved[..., columns] += np.stack([4.0 * t - 20.0 * t * t, 0.1 + 3.0 * t], axis=-1)
        return moved

    def base(t: np.ndarray) -> np.ndarray:
        moved = np.tile(standing, (*np.shape(t), 1, 1))
        moved[..., 0, 3] += 0.3 * t
        return moved

    points = np.array([[1.5, 0.3, 0.0], [2.0, -0.2, 0.0], [1.2, 0.1, 0.2], [4.0, 0.9, 0.3]])
    found = nk.world.project(nao, motion, points, camera, T_world_base=base, row_time=row_time)
    still = nk.world.project(nao, motion(np.zeros(())), points, camera, T_world_base=standing)
    assert found.visible.all()
    for k, point in enumerate(points):
        expected = _row_by_row(nao, motion, base, point, camera, row_time)
        assert np.abs(found.pixels[k] - expected).max() < 1e-3
        one = nk.world.project(nao, motion, point, camera, T_world_base=base, row_time=row_time)
        assert one.pixels == pytest.approx(found.pixels[k], abs=1e-6)
    assert np.abs(found.pixels - still.pixels).max() > 10.0
    # The ground at these pixels, with the configurations of their rows.
    times = row_time * found.pixels[:2, 1]
    back = nk.world.pixel_to_ground(nao, motion(times), found.pixels[:2], camera, T_world_base=base(times))
    assert np.abs(back.points - points[:2]).max() < 1e-6
    resting = nk.world.project(nao, lambda t: q, points, camera, row_time=row_time)
    assert np.array_equal(resting.pixels, nk.world.project(nao, q, points, camera).pixels)
    instant = nk.world.project(nao, motion, points, camera, T_world_base=standing)
    assert instant.pixels == pytest.approx(still.pixels)


def test_what_a_rolling_shutter_cannot_see_is_named(nao: nk.NaoModel) -> None:
    q, camera = nao.posture("StandInit"), nk.world.camera(nao, "CameraTop")
    points = np.array([[1.5, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.4, 0.0, 0.0]])  # seen, behind, below the image
    found = nk.world.project(nao, lambda t: q, points, camera, row_time=1e-4)
    assert found.visible.tolist() == [True, False, False]
    assert np.isnan(found.pixels[:, 0]).tolist() == [False, True, False]
    with pytest.raises(BadArgument, match="not in front of CameraTop"):
        nk.world.project(nao, lambda t: q, points[1], camera, row_time=1e-4)

    def shaking(t: np.ndarray) -> np.ndarray:
        moved = np.tile(q, (*np.shape(t), 1))
        moved[..., 1] += 0.2 * np.sin(400.0 * np.asarray(t))
        return moved

    assert not nk.world.project(nao, shaking, points, camera, row_time=1e-4).visible[0]
    with pytest.raises(BadArgument, match="the robot moves too fast"):
        nk.world.project(nao, shaking, points[0], camera, row_time=1e-4)
    for wrong in (-1.0, "fast", np.zeros(2)):
        with pytest.raises(BadArgument, match="row_time"):
            nk.world.project(nao, lambda t: q, points, camera, row_time=wrong)  # type: ignore[arg-type]
    with pytest.raises(nk.NaoKinError):
        nk.world.project(nao, lambda t: None, points, camera, row_time=1e-4)  # type: ignore[arg-type,return-value]


# --- Logs at the times of images.


def test_configurations_at_times_of_images_are_those_between_two_rows(nao: nk.NaoModel) -> None:
    rng = np.random.default_rng(0)
    times = np.cumsum(rng.uniform(0.005, 0.02, 50))
    q = np.cumsum(0.01 * rng.normal(size=(50, nao.nq)), axis=0)
    at = rng.uniform(times[0], times[-1], (4, 6))
    found = nk.world.configurations_at(nao, q, times, at)
    expected = np.stack([np.interp(at, times, column) for column in q.T], axis=-1)
    assert np.abs(found - expected).max() < 1e-12
    assert np.array_equal(nk.world.configurations_at(nao, q, times, times), q)
    q[20:23] = np.nan  # rows without measurement
    between = nk.world.configurations_at(nao, q, times, times[21])
    assert between == pytest.approx(np.array([np.interp(times[21], times[[19, 23]], c[[19, 23]]) for c in q.T]))


def test_times_in_a_gap_or_outside_a_log_have_no_configuration(nao: nk.NaoModel) -> None:
    times, q = np.array([0.0, 0.02, 0.5, 0.52]), nao.random(1, 4)
    at = np.array([-0.01, 0.0, 0.01, 0.02, 0.021, 0.3, 0.5, 0.52, 0.53])
    found = np.isfinite(nk.world.configurations_at(nao, q, times, at)).all(axis=-1)
    assert found.tolist() == [False, True, True, True, False, False, True, True, False]
    assert np.isfinite(nk.world.configurations_at(nao, q, times, at[1:-1], longest_gap=1.0)).all()
    for alone in (-0.01, 0.3, 0.53):
        with pytest.raises(BadArgument, match="no configuration at"):
            nk.world.configurations_at(nao, q, times, alone)
    assert nk.world.configurations_at(nao, q[:1], [1.0], 1.0).tolist() == q[0].tolist()
    assert nk.world.configurations_at(nao, q, times, np.empty((0, 3))).shape == (0, 3, nao.nq)
    with pytest.raises(BadArgument, match="times must ascend: row 2 is at 0.1 s, row 1 at 0.2 s"):
        nk.world.configurations_at(nao, q, [0.0, 0.2, 0.1, 0.3], 0.01)
    wrong = [
        {"times": times[:3]},
        {"q": q[:, :3]},
        {"q": q[0]},
        {"q": np.full((4, nao.nq), np.nan)},
        {"q": np.full((4, nao.nq), np.inf)},
        {"at": [0.0, np.nan]},
        {"longest_gap": -1.0},
    ]
    for change in wrong:
        with pytest.raises(nk.NaoKinError):
            nk.world.configurations_at(nao, **{"times": times, "q": q, "at": 0.01, **change})  # type: ignore[arg-type]


def test_a_floating_base_turns_evenly_between_two_rows() -> None:
    floating = nk.load_nao(base="floating")
    q = np.stack([floating.neutral(), floating.neutral()])
    turn = nk.rotations.quat_from_matrix(nk.rotations.rot_z(2.0))
    q[1, 3:7] = -nk.rotations.quat_to_xyzw(turn)  # the same rotation, on the other side
    found = nk.world.configurations_at(floating, q, [0.0, 0.1], [0.0, 0.025, 0.1])
    headings = nk.rotations.rpy_from_matrix(floating.rotation(found, "torso"))[:, 2]
    assert headings.tolist() == pytest.approx([0.0, 0.5, 2.0])


def test_batches_of_configurations_and_pixels_are_those_one_by_one(nao: nk.NaoModel) -> None:
    q = np.stack([nao.posture(name) for name in _POSTURES])
    camera = _lensed(nk.world.camera(nao, "CameraBottom"))
    pixels = np.array([[[100.0, 300.0]], [[320.0, 240.0]], [[500.0, 450.0]]])
    points = nk.world.pixel_to_ground(nao, q, pixels, camera).points
    covariance = nk.world.ground_covariance(nao, q, pixels, camera, joint_noise=0.01, base_noise=(0.01, 0.02, 0.005))
    lines = nk.world.horizon(nao, q, camera).line
    assert points.shape == (3, 4, 3)
    for i, j in np.ndindex(3, 4):
        one = nk.world.pixel_to_ground(nao, q[j], pixels[i, 0], camera)
        assert points[i, j] == pytest.approx(one.points, abs=1e-12)
        own = nk.world.ground_covariance(
            nao, q[j], pixels[i, 0], camera, joint_noise=0.01, base_noise=(0.01, 0.02, 0.005)
        )
        assert covariance[i, j] == pytest.approx(own)
    assert lines[2] == pytest.approx(nk.world.horizon(nao, q[2], camera).line)
    assert nk.world.pixel_to_ground(nao, q[:0], np.empty((0, 2)), camera).points.shape == (0, 3)


def test_wrong_arguments_are_named(nao: nk.NaoModel) -> None:
    q, camera = nao.posture("StandInit"), nk.world.camera(nao, "CameraBottom")
    pixel = [320.0, 240.0]
    elsewhere = Camera("c", "CameraBotom", 640, 480, 500.0, 500.0, 320.0, 240.0)
    with pytest.raises(UnknownName, match="CameraBottom"):
        nk.world.pixel_to_ground(nao, q, pixel, elsewhere)
    with pytest.raises(WrongShape):
        nk.world.pixel_to_ground(nao, np.stack([q, q]), np.zeros((3, 2)), camera)
    for noise in (-0.1, np.ones(3), -np.eye(nao.nv), np.triu(np.ones((nao.nv, nao.nv)))):
        with pytest.raises(nk.NaoKinError, match="joint_noise"):
            nk.world.ground_covariance(nao, q, pixel, camera, joint_noise=noise)
    for noise in (-0.1, [0.1, -0.1], np.ones(4), np.ones((2, 2)), np.nan):
        with pytest.raises(nk.NaoKinError, match="base_noise"):
            nk.world.ground_covariance(nao, q, pixel, camera, joint_noise=0.1, base_noise=noise)  # type: ignore[arg-type]
    for noise in (-1.0, [1.0, 2.0]):
        with pytest.raises(BadArgument, match="pixel_noise"):
            nk.world.ground_covariance(nao, q, pixel, camera, joint_noise=0.1, pixel_noise=noise)  # type: ignore[arg-type]
    lying = nao.posture("LyingBelly")
    with pytest.raises(BadArgument, match="no sole touches the floor; name the support that does"):
        nk.world.ground_covariance(nao, lying, [[320.0, 470.0]], camera, joint_noise=0.1)
    for distance in (0.0, np.inf):
        with pytest.raises(nk.NaoKinError, match="max_distance"):
            nk.world.visible_ground(nao, q, camera, max_distance=distance)  # type: ignore[arg-type]
    assert nk.world.visible_ground(nao, q[None][:0], camera).shape == (0, 8, 3)
    for shape in ((), (3,), (2, 3)):
        with pytest.raises(WrongShape, match="normalised coordinates"):
            camera.lens_jacobian(np.zeros(shape))
    with pytest.raises(BadArgument, match="n must be"):
        nk.world.horizon(nao, q, camera, n=1)
    for T in (np.zeros((4, 4)), 2.0 * np.eye(4), np.ones((4, 4))):
        with pytest.raises(nk.NaoKinError, match="T_world_base"):
            nk.world.camera_pose(nao, q, camera, T_world_base=T)
    aside = Camera("aside", "CameraTop", 640, 480, 400.0, 400.0, 1320.0, 240.0, (-0.5, 0.0, 0.0, 0.0))
    with pytest.raises(BadArgument, match=r"aside cannot be inverted at \(639.5, 240\)"):
        nk.world.horizon(nao, q, aside)


def test_corners_that_the_lens_does_not_reach_are_clipped(nao: nk.NaoModel) -> None:
    # r (1 − 0.3 r²) is at most 0.70: all but the corners of the image, which is 0.57 wide and 0.43 high.
    folded = Camera("folded", "CameraTop", 640, 480, 500.0, 500.0, 320.0, 240.0, (-0.3, 0.0, 0.0, 0.0))
    corners = np.isnan(folded.ray(folded.border(1))[:, 0])
    sides = np.isnan(folded.ray(folded.border(2))[1::2, 0])
    assert (corners.all(), sides.any()) == (True, False)
    q, T_world_base = nao.posture("StandInit", HeadPitch=0.2), nk.screws.pose(np.eye(3), [0.0, 0.0, 0.3])
    polygon = nk.world.visible_ground(nao, q, folded, T_world_base=T_world_base, max_distance=3.0)
    points = np.column_stack([np.random.default_rng(0).uniform([0.0, -3.0], [3.0, 3.0], (4000, 2)), np.zeros(4000)])
    visible = nk.world.project(nao, q, points, folded, T_world_base=T_world_base).visible
    T = nk.world.camera_pose(nao, q, folded, T_world_base=T_world_base)
    near = (points[:, :2] - T[:2, 3]) @ (T[:2, 0] / np.linalg.norm(T[:2, 0])) < 3.0
    assert (_contains(polygon[:, :2], points[:, :2]) != (visible & near)).mean() < 0.01
    assert visible.mean() > 0.2
    tilted = T_world_base @ nk.screws.pose(nk.rotations.rot_x(0.62), np.zeros(3))  # the horizon through two corners
    found = nk.world.horizon(nao, nao.neutral(), folded, T_world_base=tilted)
    assert found.visible
    assert folded.sees(found.pixels).all()
    heights = folded.ray(found.pixels) @ nk.world.camera_pose(nao, nao.neutral(), folded, T_world_base=tilted)[2, :3]
    assert np.abs(heights[1:-1]).max() < 1e-9
    assert np.ptp(found.pixels[:, 0]) > 450.0


def test_a_plane_above_the_floor_is_the_floor_of_a_robot_that_is_lower(nao: nk.NaoModel) -> None:
    q, h = nao.posture("StandInit", HeadPitch=0.2), 0.08
    top, T = nk.world.camera(nao, "CameraTop"), nao.set_down(q).T_world_base
    lower = T.copy()
    lower[2, 3] -= h
    shown = nk.world.visible_ground(nao, q, top, T_world_base=T, height=h) - [0.0, 0.0, h]
    np.testing.assert_allclose(shown, nk.world.visible_ground(nao, q, top, T_world_base=lower), atol=1e-12)
    pixel, given = np.array([320.0, 300.0]), {"joint_noise": 0.01, "support": "torso"}
    spread = nk.world.ground_covariance(nao, q, pixel, top, T_world_base=T, height=h, **given)  # type: ignore[arg-type]
    alike, other = (
        nk.world.ground_covariance(nao, q, pixel, top, T_world_base=base, **given)  # type: ignore[arg-type]
        for base in (lower, T)
    )
    np.testing.assert_allclose(spread, alike, atol=1e-15)
    assert np.abs(spread - other).max() > 1e-6
