"""Lines and the robot's own body in an image, compared with rays, searched points and known places."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from loops import full
from scipy.spatial import ConvexHull

import nao_kin as nk
from nao_kin.errors import BadArgument, UnknownName, WrongShape
from nao_kin.world import Camera

_LENS = (-0.25, 0.1, 0.002, -0.001, -0.02)
_FOLDED = (-0.3, 0.0, 0.0, 0.0)  # the corners of the image have no rays
_LENSES = {"none": (), "lens": _LENS, "folded": _FOLDED}


def _camera(lens: str, frame: str = "CameraBottom") -> Camera:
    return Camera("c", frame, 640, 480, 500.0, 503.0, 317.0, 243.0, _LENSES[lens])


def _pose(rng: np.random.Generator) -> np.ndarray:
    return nk.screws.pose(nk.rotations.matrix_from_rpy(rng.normal(scale=0.3, size=3)), [*rng.normal(size=2), 0.6])


# --- The robot's own body.


def _hits(robot: nk.RobotModel, q: np.ndarray, camera: Camera, pixels: np.ndarray, links: set[str]) -> np.ndarray:
    """Which rays of pixels meet a hull of the links: cut by its faces, or passing a ball or capsule closely enough."""
    body = nk.world.camera_pose(robot, q, camera, T_world_base=np.eye(4))
    rays, eye = camera.ray(pixels) @ body[:3, :3].T, body[:3, 3]
    found = np.zeros(len(pixels), dtype=bool)
    for shape in (part for whole in robot.link_shapes.shapes for part in whole.parts or (whole,)):
        if shape.link not in links:
            continue
        T = robot.fk(q, shape.link, reference=robot.tree.root)
        points = shape.points @ T[:3, :3].T + T[:3, 3]
        if shape.radius:
            along = np.linspace(0.0, 1.0, 400)[:, None]
            centres = points[0] + along * (points[-1] - points[0]) - eye
            ahead = rays @ centres.T
            miss = np.sqrt(np.maximum((centres**2).sum(axis=1) - ahead**2, 0.0))
            found |= ((miss < shape.radius) & (ahead > 0.0)).any(axis=1)
            continue
        faces = ConvexHull(points).equations
        speed, room = rays @ faces[:, :3].T, -(faces[:, :3] @ eye + faces[:, 3])
        with np.errstate(divide="ignore"):
            times = room / speed
        entry = np.where(speed < 0.0, times, -np.inf).max(axis=1)
        leaving = np.where(speed > 0.0, times, np.inf).min(axis=1)
        found |= (entry < leaving) & (leaving > 0.0)
    return found & np.isfinite(rays[:, 0])


@pytest.mark.parametrize("lens", _LENSES)
@pytest.mark.parametrize("frame", ["CameraTop", *full("CameraBottom")])
def test_a_pixel_shows_the_robot_if_its_ray_meets_a_hull(nao: nk.NaoModel, frame: str, lens: str) -> None:
    camera, rng = _camera(lens, frame), np.random.default_rng(3)
    u, v = np.meshgrid(np.linspace(0.0, 639.0, 29), np.linspace(0.0, 479.0, 23))
    pixels = np.column_stack([u.ravel(), v.ravel()])
    links = {link for link in nao.link_names if nao.frame_placement(link)[0] != nao.frame_placement("Head")[0]}
    seen = wrong = 0
    for q in (nao.posture("StandInit", HeadPitch=0.4), nao.posture("Stand", HeadYaw=1.0), *nao.random(rng, 2)):
        found = nk.world.own_body(nao, q, pixels, camera)
        expected = _hits(nao, q, camera, pixels, links)
        seen, wrong = seen + expected.sum(), wrong + (found != expected).sum()
    assert seen > 20
    assert wrong == 0


def test_balls_and_capsules_are_seen_as_their_rays_meet_them() -> None:
    robot = nk.load_robot("panda_collision")
    camera = Camera("c", "panda_link4", 320, 240, 120.0, 120.0, 160.0, 120.0)
    pixels = np.random.default_rng(0).uniform([0.0, 0.0], [319.0, 239.0], (300, 2))
    rows = {shape.link for shape in robot.link_shapes.shapes if shape.radius}
    links = {link for link in rows if robot.frame_placement(link)[0] != robot.frame_placement("panda_link4")[0]}
    seen = 0
    for q in robot.random(1, 3):
        found = nk.world.own_body(robot, q, pixels, camera, links=sorted(links))
        expected = _hits(robot, q, camera, pixels, links)
        assert (found != expected).mean() < 0.01  # 64 directions instead of a circle
        seen += expected.sum()
    assert seen > 20


def test_links_of_the_own_body_are_those_that_are_named(nao: nk.NaoModel) -> None:
    camera = nk.world.camera(nao, "CameraBottom")
    q, links = nao.posture("Stand", HeadPitch=0.5), ("l_ankle", "r_ankle", "torso")
    grid = np.stack(np.meshgrid(np.arange(0.0, 640.0, 8.0), np.arange(0.0, 480.0, 8.0)), axis=-1)
    body = nk.world.own_body(nao, q, grid, camera)
    parts = [nk.world.own_body(nao, q, grid, camera, links=[link]) for link in links]
    assert body.shape == (60, 80)
    for part in parts:
        assert part.any()
        assert not (part & ~body).any()
    assert np.array_equal(nk.world.own_body(nao, q, grid, camera, links=links), np.any(parts, axis=0))
    assert not nk.world.own_body(nao, q, grid, camera, links=[]).any()
    assert nk.world.own_body(nao, q, [320.0, 240.0], camera, links=["Head"])  # a camera is inside the hull of its head
    unseen = [[-1.0, 479.0], [320.0, 480.0], [np.nan, 470.0]]
    assert not nk.world.own_body(nao, q, unseen, camera, links=["Head"]).any()
    assert nk.world.own_body(nao, q, np.empty((0, 2)), camera).shape == (0,)
    floating = nk.load_nao(base="floating")
    q_floating = floating.posture("Stand", HeadPitch=0.5)
    q_floating[:3] = [3.0, 2.0, 1.0]
    assert np.array_equal(nk.world.own_body(floating, q_floating, grid, camera), body)
    with pytest.raises(UnknownName, match="l_ankle"):
        nk.world.own_body(nao, q, grid, camera, links=["l_ankl"])
    with pytest.raises(WrongShape, match="one configuration"):
        nk.world.own_body(nao, np.stack([q, q]), grid, camera)
    with pytest.raises(BadArgument, match="links"):
        nk.world.own_body(nao, q, grid, camera, links="l_ankle")


# --- Lines.


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**31), st.sampled_from(list(_LENSES)))
def test_the_visible_part_of_a_line_is_where_its_points_are_visible(seed: int, lens: str) -> None:
    nao, rng, camera = nk.load_nao(), np.random.default_rng(seed), _camera(lens)
    q, T_world_base = nao.random(rng), _pose(rng)
    T = nk.world.camera_pose(nao, q, camera, T_world_base=T_world_base)
    ends = T[:3, 3] + rng.normal(scale=1.5, size=(8, 2, 3))
    found = nk.world.project_lines(nao, q, ends, camera, T_world_base=T_world_base)
    share = np.linspace(0.0, 1.0, 2001)[:, None]
    for k, (start, end) in enumerate(ends):
        points = start + share * (end - start)
        seen = nk.world.project(nao, q, points, camera, T_world_base=T_world_base)
        along = seen.pixels[seen.visible]
        if len(along) < 5 or np.ptp(along, axis=0).max() < 10.0:
            continue  # the edge of a folded lens is drawn with corners
        assert found.visible[k]
        apart = 3.0 + 1.5 * np.linalg.norm(np.diff(along, axis=0), axis=-1).max()
        assert np.linalg.norm(found.pixels[k, [0, -1]] - along[[0, -1]], axis=-1).max() < apart
        # Both are the same curve: each point that was found is near one of the visible ones.
        gaps = np.linalg.norm(found.pixels[k, 1:-1, None] - along, axis=-1).min(axis=1)
        assert gaps.max() < apart
        assert camera.sees(found.pixels[k, 1:-1]).mean() > 0.9
    one = nk.world.project_lines(nao, q, ends[0], camera, T_world_base=T_world_base)
    assert np.array_equal(one.pixels, found.pixels[0], equal_nan=True)
    invisible = found.pixels[~found.visible]
    assert np.isnan(invisible).all()


def test_a_long_line_on_the_floor_is_cut_at_the_image_and_ends_at_the_horizon(nao: nk.NaoModel) -> None:
    q, camera = nao.posture("StandInit", HeadYaw=0.2), nk.world.camera(nao, "CameraTop")
    ends = np.array([[[-1e7, -0.3, 0.0], [1e7, -0.3, 0.0]], [[2.0, 1e7, 0.0], [2.0, -1e7, 0.0]]])
    found = nk.world.project_lines(nao, q, ends, camera, n=5)
    assert found.visible.tolist() == [True, True]
    horizon = nk.world.horizon(nao, q, camera).line
    assert abs(horizon[:2] @ found.pixels[0, -1] + horizon[2]) < 1e-3
    assert found.pixels[1, [0, -1], 0].tolist() == pytest.approx([-0.5, 639.5], abs=1e-6)
    ground = nk.world.pixel_to_ground(nao, q, found.pixels[:, 1:-1], camera).points
    assert ground[0, :, 1] == pytest.approx(np.full(3, -0.3))
    assert ground[1, :, 0] == pytest.approx(np.full(3, 2.0))


def test_lines_that_no_image_shows_are_not_visible(nao: nk.NaoModel) -> None:
    q, camera = nao.posture("StandInit"), nk.world.camera(nao, "CameraTop")
    T = nk.world.camera_pose(nao, q, camera)
    eye, ahead = T[:3, 3], T[:3, 0]
    lines = [
        [[-1.0, 0.0, 0.0], [-2.0, 0.0, 0.0]],  # behind
        [eye + ahead, eye + 2.0 * ahead],  # seen as a point
        [eye - ahead, eye + ahead],  # through the camera
        [[1.0, 0.0, 0.3], [1.0, 0.0, 0.3]],  # no line
        [[1.0, 5.0, 0.0], [1.0, 4.0, 0.0]],  # to the left of the image
    ]
    found = nk.world.project_lines(nao, q, lines, camera)
    assert not found.visible.any()
    assert np.isnan(found.pixels).all()
    batch = nk.world.project_lines(nao, np.stack([q, q]), np.array(lines)[:, None], camera, n=4)
    assert batch.pixels.shape == (5, 2, 4, 2)
    for wrong in (np.zeros((3, 3)), [0.0, 1.0], "line", [[[0.0, 0.0, np.nan], [1.0, 0.0, 0.0]]]):
        with pytest.raises(nk.NaoKinError, match="lines"):
            nk.world.project_lines(nao, q, wrong, camera)
    with pytest.raises(WrongShape, match="configurations and lines"):
        nk.world.project_lines(nao, np.stack([q, q]), np.zeros((3, 2, 3)), camera)
    with pytest.raises(BadArgument, match="n must be"):
        nk.world.project_lines(nao, q, lines, camera, n=1)
