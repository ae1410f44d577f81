"""Cameras beside OpenCV, finite differences, and the published numbers."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given, settings, strategies as st

import nao_kin as nk
from nao_kin.errors import BadArgument, BadInputFile, UnknownName, WrongShape
from nao_kin.robot.semantics import Semantics
from nao_kin.world import Camera

# OpenCV's axes from ours: x right, y down, z forward.
_OPTICAL = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
_LENSES = {
    "none": (),
    "barrel": (-0.3, 0.09, 0.0, 0.0),
    "pincushion": (0.2, 0.05, 0.001, -0.002),
    "five": (-0.25, 0.1, 0.002, -0.001, -0.02),
    "rational": (0.6, -0.2, 0.001, 0.0005, 0.02, 0.9, -0.1, 0.05),
}


def _camera(distortion: tuple[float, ...] = ()) -> Camera:
    return Camera("c", "CameraTop", 640, 480, 558.0, 561.0, 317.0, 243.0, distortion)


@pytest.mark.parametrize("lens", _LENSES)
def test_points_are_projected_as_opencv_does(lens: str) -> None:
    cv2 = pytest.importorskip("cv2", reason="OpenCV is not installed")
    camera = _camera(_LENSES[lens])
    rng = np.random.default_rng(3)
    points = rng.uniform(0.2, 5.0, (1000, 1)) * np.column_stack([np.ones(1000), rng.uniform(-0.55, 0.55, (1000, 2))])
    coefficients = np.array(camera.distortion) if camera.distortion else None
    expected, _ = cv2.projectPoints(points @ _OPTICAL.T, np.zeros(3), np.zeros(3), camera.matrix, coefficients)
    assert np.abs(camera.project(points) - expected[:, 0]).max() < 1e-9


@pytest.mark.parametrize("lens", _LENSES)
def test_rays_agree_with_opencv_and_lead_back_to_their_pixels(lens: str) -> None:
    cv2 = pytest.importorskip("cv2", reason="OpenCV is not installed")
    camera = _camera(_LENSES[lens])
    pixels = np.stack(np.meshgrid(np.linspace(-0.5, 639.5, 33), np.linspace(-0.5, 479.5, 25)), axis=-1)
    rays = camera.ray(pixels)
    assert np.abs(np.linalg.norm(rays, axis=-1) - 1.0).max() < 1e-14
    assert np.abs(camera.project(rays) - pixels).max() < 1e-8
    criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 2000, 1e-14)
    coefficients = np.array(camera.distortion) if camera.distortion else None
    expected = cv2.undistortPoints(pixels.reshape(-1, 1, 2), camera.matrix, coefficients, criteria=criteria)
    assert np.abs(camera.normalised(pixels).reshape(-1, 2) - expected[:, 0]).max() < 1e-7


@settings(max_examples=60, deadline=None)
@given(
    st.tuples(*[st.floats(-0.5, 0.5)] * 2, *[st.floats(-0.01, 0.01)] * 2, *[st.floats(-0.3, 0.3)] * 4),
    st.tuples(st.floats(-0.9, 0.9), st.floats(-0.9, 0.9)),
)
def test_every_lens_is_inverted_or_named(distortion: tuple[float, ...], point: tuple[float, float]) -> None:
    camera = replace(_camera(), distortion=distortion)
    pixel = camera.project([[1.0, -point[0], -point[1]]])[0]
    if np.isnan(pixel).any():
        with pytest.raises(BadArgument, match="too far from the optical axis"):
            camera.project([1.0, -point[0], -point[1]])
        return
    assume(np.linalg.det(camera.lens_jacobian(np.array(point))) > 0.05 * camera.fx * camera.fy)
    found = camera.normalised(pixel)  # no other point of the invertible circle has this pixel
    assert found == pytest.approx(point, abs=1e-7)


def test_a_pixel_beyond_the_largest_distorted_radius_is_named() -> None:
    camera = _camera((-0.3, 0.0, 0.0, 0.0))  # r (1 − 0.3 r²) is at most 0.7027 at r = 1.054
    edge = 317.0 + 558.0 * (2.0 / 3.0 / np.sqrt(0.9))
    assert camera.normalised([edge - 0.01, 243.0])[0] < np.sqrt(1.0 / 0.9)
    with pytest.raises(BadArgument, match=r"the distortion of c cannot be inverted at the pixel \(730, 243\)"):
        camera.ray([730.0, 243.0])
    rays = camera.ray([[730.0, 243.0], [317.0, 243.0]])
    assert np.isnan(rays[0]).all()
    assert rays[1].tolist() == [1.0, 0.0, 0.0]
    # OpenCV's polynomial sends a point 60° off the axis back into the image.
    assert np.isnan(camera.project([[1.0, -1.7, 0.0]])).all()
    with pytest.raises(BadArgument, match="too far from the optical axis"):
        camera.project([1.0, -1.7, 0.0])


def test_no_point_has_a_pixel_where_tangential_distortion_folds_the_image() -> None:
    camera = Camera("c", "f", 640, 480, 560.0, 560.0, 320.0, 240.0, (-0.385, 0.0196, -0.0029, 0.0029))
    with pytest.raises(BadArgument, match="too far from the optical axis"):
        camera.project([1.0, 0.8302, -0.4902])  # its pixel would be inside the image, that of another ray
    rng, seen = np.random.default_rng(0), 0
    for size in (5e-4, 3e-3, 0.02):
        for _ in range(60):
            lens = (rng.uniform(-0.4, 0.3), rng.uniform(-0.1, 0.1), *rng.normal(0.0, size, 2))
            camera = replace(camera, distortion=lens)
            points = np.column_stack([np.ones(300), rng.uniform(-1.2, 1.2, (300, 2))])
            pixels = camera.project(points)
            visible = camera.sees(pixels)
            rays = camera.ray(pixels[visible])
            np.testing.assert_allclose(rays / rays[:, :1], points[visible], atol=1e-6)
            seen += visible.sum()
    assert seen > 10_000


@pytest.mark.parametrize("lens", _LENSES)
def test_derivatives_of_pixels_are_differences(lens: str) -> None:
    camera, step = _camera(_LENSES[lens]), 1e-6
    for point in np.array([[2.0, 0.0, 0.0], [1.5, 0.4, -0.3], [0.4, -0.1, 0.15]]):
        sides = [camera.project(point + sign * step * np.eye(3)) for sign in (1.0, -1.0)]
        assert camera.pixel_jacobian(point) == pytest.approx((sides[0] - sides[1]).T / (2.0 * step), rel=1e-6, abs=1e-4)


def _middle(image: np.ndarray) -> np.ndarray:
    """The centroid (u, v) of the light in an image."""
    v, u = np.indices(image.shape)
    return np.array([(u * image).sum(), (v * image).sum()]) / image.sum()


@pytest.mark.parametrize("size", [(320, 240), (1280, 960), (160, 240)])
def test_a_resized_camera_sees_a_light_where_opencv_s_resized_image_shows_it(size: tuple[int, int]) -> None:
    cv2 = pytest.importorskip("cv2", reason="OpenCV is not installed")
    camera, point = _camera(_LENSES["five"]), np.array([1.0, 0.21, -0.17])
    u, v = camera.project(point)
    rows, columns = np.mgrid[:480, :640]
    image = np.exp(-((columns - u) ** 2 + (rows - v) ** 2) / (2.0 * 6.0**2))
    assert _middle(image) == pytest.approx([u, v], abs=1e-6)
    scaled = cv2.resize(image, size, interpolation=cv2.INTER_AREA if size[0] < 640 else cv2.INTER_LINEAR)
    other = camera.resized(size)
    assert (other.width, other.height) == size
    assert other.project(point) == pytest.approx(_middle(scaled), abs=1e-3)
    part = camera.cropped((37, 251), (300, 200))
    assert part.project(point) == pytest.approx(_middle(image[251:451, 37:337]), abs=1e-3)


def test_resized_and_cropped_cameras_keep_their_rays_and_edges() -> None:
    camera = _camera(_LENSES["rational"])
    for other in (camera.resized((1280, 960)), camera.resized((160, 240)).resized((640, 480))):
        assert other.ray(other.border(3)) == pytest.approx(camera.ray(camera.border(3)), abs=1e-9)
    assert camera.resized((640, 480)) == camera
    assert camera.resized((160, 240)).resized((640, 480)).matrix == pytest.approx(camera.matrix)
    part = camera.cropped((600, 400), (40, 80))
    assert part.ray([0.0, 0.0]) == pytest.approx(camera.ray([600.0, 400.0]))
    nao = nk.load_nao()
    vga, large = (nk.world.camera(nao, "CameraTop", size) for size in ("VGA", "4VGA"))
    assert vga.resized((1280, 960)).matrix == pytest.approx(large.matrix)
    for corner, size in (((601, 0), (40, 80)), ((0, 401), (40, 80)), ((-1, 0), (40, 80)), ((0, 0), (0, 80))):
        with pytest.raises(BadArgument):
            camera.cropped(corner, size)  # type: ignore[arg-type]


@pytest.mark.parametrize("lens", _LENSES)
def test_the_outline_of_a_ball_is_where_rays_just_touch_it(lens: str) -> None:
    camera, rng = _camera(_LENSES[lens]), np.random.default_rng(7)
    centres = rng.uniform(0.3, 4.0, (30, 1)) * np.column_stack([np.ones(30), rng.uniform(-0.4, 0.4, (30, 2))])
    outline = camera.ball_outline(centres, 0.05, n=40)
    assert outline.shape == (30, 40, 2)
    rays = camera.ray(outline)
    along = np.einsum("kni,ki->kn", rays, centres)
    miss = np.linalg.norm(along[..., None] * rays - centres[:, None], axis=-1)
    assert np.abs(miss - 0.05).max() < 1e-9
    found = camera.ball_centre(outline, 0.05)
    assert np.abs(found - centres).max() < 1e-6
    assert camera.ball_centre(outline[3, :3], 0.05) == pytest.approx(centres[3], abs=1e-6)
    # The whole outline is inside what points of the ball cover, and its ends are the outermost of them.
    on_ball = centres[5] + 0.05 * nk.rotations.matrix_from_rpy(rng.normal(size=(20_000, 3)))[..., 0]
    shown = camera.project(on_ball)
    assert np.abs(shown.min(axis=0) - outline[5].min(axis=0)).max() < 0.15
    assert np.abs(shown.max(axis=0) - outline[5].max(axis=0)).max() < 0.15


def test_a_circle_around_a_ball_gives_its_distance_within_the_error_of_its_radius() -> None:
    camera = nk.world.camera(nk.load_nao(), "CameraTop")
    centre = np.array([2.0, 0.7, -0.4])
    edge = camera.ball_outline(centre, 0.05)
    middle = (edge.min(axis=0) + edge.max(axis=0)) / 2.0
    turn = np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False)
    circle = middle + np.sqrt(np.prod(np.ptp(edge, axis=0)) / 4.0) * np.column_stack([np.cos(turn), np.sin(turn)])
    found = camera.ball_centre(circle, 0.05)
    assert np.linalg.norm(found) == pytest.approx(np.linalg.norm(centre), rel=0.03)
    rng = np.random.default_rng(1)
    noisy = camera.ball_centre(edge + 0.5 * rng.normal(size=(2000, 32, 2)), 0.05)
    distances = np.linalg.norm(noisy, axis=-1)
    radius = camera.fx * 0.05 / 2.0  # a pixel of the radius is a share of 1/radius of the distance
    expected = np.linalg.norm(centre) * 0.5 / np.sqrt(32) / radius
    assert distances.std() == pytest.approx(expected, rel=0.25)


def test_wrong_balls_are_refused() -> None:
    camera = _camera()
    edge = camera.ball_outline([2.0, 0.1, 0.0], 0.05)
    for radius in (0.0, -0.05, np.nan, "small", [0.05]):
        for ask in (lambda r: camera.ball_outline([2.0, 0.0, 0.0], r), lambda r: camera.ball_centre(edge, r)):
            with pytest.raises(nk.NaoKinError, match="radius"):
                ask(radius)
    with pytest.raises(BadArgument, match="c is inside the ball at"):
        camera.ball_outline([[2.0, 0.0, 0.0], [0.03, 0.0, 0.0]], 0.05)
    with pytest.raises(BadArgument, match="n must be at least 3"):
        camera.ball_outline([2.0, 0.0, 0.0], 0.05, n=2)
    assert np.isnan(camera.ball_outline([-2.0, 0.0, 0.0], 0.05)).all()
    for few in (edge[:2], edge[0], np.zeros((4, 3))):
        with pytest.raises(nk.NaoKinError, match="pixels"):
            camera.ball_centre(few, 0.05)
    for pixels in ([[10.0, 10.0]] * 4, [[10.0, 10.0], [20.0, 10.0], [40.0, 10.0]]):
        with pytest.raises(BadArgument, match="not those of the edge of a ball"):
            _camera().ball_centre(pixels, 0.05)
    unknown = edge.copy()
    unknown[3] = np.nan
    found = camera.ball_centre([unknown, edge], 0.05)
    assert np.isnan(found[:, 0]).tolist() == [True, False]
    assert camera.ball_centre(np.empty((0, 5, 2)), 0.05).shape == (0, 3)


def test_points_behind_the_camera_have_no_pixel() -> None:
    camera = _camera()
    pixels = camera.project(np.array([[[1.0, 0.2, 0.1]], [[-1.0, 0.2, 0.1]], [[0.0, 0.2, 0.1]]]))
    assert np.isnan(pixels).all(axis=-1).ravel().tolist() == [False, True, True]
    for x in (0.0, -2.0):
        with pytest.raises(BadArgument, match="is not in front of c"):
            camera.project([x, 0.0, 0.0])
    assert camera.project(np.empty((0, 3))).shape == camera.ray(np.empty((0, 2)))[:, :2].shape == (0, 2)


def test_the_image_begins_half_a_pixel_before_the_first_centre() -> None:
    camera = nk.world.camera(nk.load_nao(), "CameraTop")
    across, high = nk.load_nao().semantics.fields_of_view["CameraTop"]
    corner = camera.ray(camera.border())[0]
    assert (corner[1:] / corner[0]).tolist() == pytest.approx([np.tan(across / 2), np.tan(high / 2)])
    inside = camera.sees([[-0.5, -0.5], [639.4, 479.4], [639.5, 3.0], [3.0, 479.5], [-0.51, 3.0]])
    assert inside.tolist() == [True, True, False, False, False]
    border = camera.border(5)
    assert len(border) == 20
    assert (
        np.linalg.norm(np.diff(border, axis=0), axis=1).round(9).tolist() == [128] * 5 + [96] * 5 + [128] * 5 + [96] * 4
    )


def test_each_version_has_the_published_sensors() -> None:
    # Aldebaran's pages on video cameras, and the data sheet of NAO6.
    published = {"v6": (56.3, 43.7, 2560), "v5": (60.9, 47.6, 1280), "v4": (60.9, 47.6, 1280)}
    published |= dict.fromkeys(("v3.3", "v3.2"), (47.8, 36.8, 640))
    for version, (across, high, widest) in published.items():
        nao = nk.load_nao(version)
        assert max(nao.semantics.resolutions.values())[0] == widest
        for name in ("CameraTop", "CameraBottom"):
            camera = nk.world.camera(nao, name)
            angles = 2.0 * np.arctan([320.0 / camera.fx, 240.0 / camera.fy])
            assert np.degrees(angles).tolist() == pytest.approx([across, high])
    assert nk.world.camera(nk.load_nao(), "CameraTop", "QQVGA").width == 160
    assert nk.world.camera(nao, "CameraTop", "640x480") == nk.world.camera(nao, "CameraTop", (640, 480))
    assert nk.parameters.nao_parameters("v4").cameras[0].sensor == "MT9M114"


def test_unknown_cameras_and_resolutions_are_named() -> None:
    nao = nk.load_nao("v5")
    with pytest.raises(UnknownName, match="CameraTop"):
        nk.world.camera(nao, "CameraTopp")
    with pytest.raises(UnknownName, match="4VGA"):
        nk.world.camera(nao, "CameraTop", "16VGA")
    with pytest.raises(BadArgument, match="height"):
        nk.world.camera(nao, "CameraTop", (640, 0))
    blind = nk.RobotModel(nao.tree, replace(nao.semantics, fields_of_view={}))
    with pytest.raises(BadArgument, match="field of view of CameraTop is not known"):
        nk.world.camera(blind, "CameraTop")


def test_any_robot_has_cameras_and_resolutions_of_its_own(tmp_path: Path) -> None:
    nao = nk.load_nao()
    fields = {"cameras": ("Head",), "fields_of_view": {"Head": (1.0, 0.5)}}
    robot = nk.RobotModel(nao.tree, Semantics(**fields))  # type: ignore[arg-type]
    wide = nk.world.camera(robot, "Head", (1027, 480))
    assert wide.fx == pytest.approx(wide.fy, rel=1e-3)
    # Of NAOqi's sizes, none has its shape.
    with pytest.raises(BadArgument, match="1027 × 480"):
        nk.world.camera(robot, "Head")
    own = nk.RobotModel(nao.tree, Semantics(**fields, resolutions={"HD": (1280, 720)}))  # type: ignore[arg-type]
    assert nk.world.camera(own, "Head", "HD").height == 720
    with pytest.raises(UnknownName, match="HD"):
        nk.world.camera(own, "Head")
    file = tmp_path / "robot.toml"
    file.write_text("[resolutions]\nHD = [1280, 720]\n")
    assert nk.semantics.read_semantics(file).resolutions == {"HD": (1280, 720)}
    file.write_text("[resolutions]\nHD = [1280.5, 720]\n")
    with pytest.raises(BadInputFile, match="resolution HD must be a width and a height"):
        nk.semantics.read_semantics(file)


@pytest.mark.parametrize(
    ("size", "named"),
    [
        ((480, 640), "640 × 480"),
        ((240, 320), "320 × 240"),
        ((30, 40), "40 × 30"),
        ((100, 900), "1201 × 900"),
        ((1280, 720), "1280 × 959"),
        ((640, 640), "854 × 640"),
    ],
)
def test_a_size_that_is_not_that_of_a_whole_image_is_refused(size: tuple[int, int], named: str) -> None:
    with pytest.raises(BadArgument, match=named):
        nk.world.camera(nk.load_nao("v6"), "CameraTop", size)


@pytest.mark.parametrize("size", [(640, 480), (1024, 768), (8, 6), (7, 5), (300, 224), (3, 2), (1, 1)])
def test_whole_images_of_any_size_are_accepted(size: tuple[int, int]) -> None:
    for version in ("v6", "v4", "v3.2"):
        assert nk.world.camera(nk.load_nao(version), "CameraBottom", size).width == size[0]


def test_a_matrix_of_another_size_is_refused() -> None:
    nao = nk.load_nao()
    sizes = {name: nao.semantics.resolutions[name] for name in ("QVGA", "VGA", "4VGA")}
    for of, (width, height) in sizes.items():
        for off in (-0.03, 0.0, 0.03):  # lenses are off their images' middles by some percent
            matrix = nk.world.camera(nao, "CameraTop", of).matrix
            matrix[:2, 2] += np.array([off * width, -off * height])
            for size in [*sizes.values(), (height, width)]:
                if size == (width, height):
                    assert Camera.from_matrix(matrix, frame="CameraTop", size=size).cx == matrix[0, 2]
                    continue
                with pytest.raises(BadArgument, match="size is the width and height"):
                    Camera.from_matrix(matrix, frame="CameraTop", size=size)


def test_a_size_whose_order_is_that_of_an_array_is_refused() -> None:
    camera = _camera()
    for wrong in ((480, 640), (240, 320), (3, 4)):
        with pytest.raises(BadArgument, match=rf"\({wrong[1]}, {wrong[0]}\)"):
            camera.resized(wrong)
    assert camera.resized((224, 224)).width == 224  # squeezed
    assert replace(camera, height=640).resized((320, 320)).width == 320


def test_wrong_cameras_are_refused() -> None:
    good = {"frame": "CameraTop", "size": (640, 480)}
    assert Camera.from_matrix(_camera().matrix, np.zeros((1, 5)), **good).distortion == (0.0,) * 5  # type: ignore[arg-type]
    rational = np.array(_LENSES["rational"])
    for count in (12, 14):  # what calibrateCamera returns with CALIB_RATIONAL_MODEL
        padded = np.zeros((1, count))
        padded[0, :8] = rational
        assert Camera.from_matrix(_camera().matrix, padded, **good).distortion == _LENSES["rational"]  # type: ignore[arg-type]
        padded[0, -1] = 0.01
        with pytest.raises(BadArgument, match="thin prisms and tilted sensors are not modelled"):
            Camera.from_matrix(_camera().matrix, padded, **good)  # type: ignore[arg-type]
    for matrix in (np.eye(4), [[5, 0.1, 3], [0, 5, 2], [0, 0, 1]], [[5, 0, 3], [0, 5, 2], [0, 0, 2]], -np.eye(3)):
        with pytest.raises((BadArgument, WrongShape)):
            Camera.from_matrix(matrix, **good)  # type: ignore[arg-type]
    for change in ({"width": 0}, {"fx": 0.0}, {"fy": "x"}, {"distortion": (0.1, 0.2)}, {"distortion": (np.nan,) * 4}):
        with pytest.raises(nk.NaoKinError):
            replace(_camera(), **change)  # type: ignore[arg-type]
    for pixels in ([1.0, 2.0, 3.0], 4.0, [np.inf, 0.0]):
        with pytest.raises(nk.NaoKinError, match="pixels"):
            _camera().ray(pixels)
