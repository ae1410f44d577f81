from __future__ import annotations

import copy
import pickle
from functools import partial

import mpmath
import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings, strategies as st
from loops import for_all
from scipy.spatial.transform import Rotation

from nao_kin.errors import (
    BadArgument,
    DegeneratePoints,
    NaoKinError,
    NotARotation,
    NotFinite,
    WrongShape,
    ZeroNorm,
)
from nao_kin.screws import lines
from nao_kin.screws.lines import PluckerLine

EPS = np.finfo(float).eps
BATCHES = [(), (0,), (1,), (2, 3)]
assert_near = partial(np.testing.assert_allclose, rtol=0)  # its own default lets a relative 1e-7 pass
few = settings(max_examples=60, derandomize=True, deadline=None)
component = st.floats(-10.0, 10.0).map(lambda x: round(x, 6)) | st.integers(-3, 3).map(float)
point = st.tuples(component, component, component).map(np.array)
direction = point.filter(lambda v: np.abs(v).max() > 1e-6)
small_angle = st.sampled_from([10.0**-k for k in range(3, 13)])


def random_motion(rng: np.random.Generator, shape: tuple[int, ...] = ()) -> np.ndarray:
    T = np.zeros((*shape, 4, 4))
    T[..., 3, 3] = 1.0
    count = int(np.prod(shape))
    T[..., :3, :3] = Rotation.random(max(count, 1), rng=rng).as_matrix()[:count].reshape(*shape, 3, 3)
    T[..., :3, 3] = rng.uniform(-2, 2, (*shape, 3))
    return T


def exact_distance(p_a, d_a, p_b, d_b) -> mpmath.mpf:
    """Distance of two lines that are not parallel, at 60 digits."""
    with mpmath.workdps(60):
        p_a, d_a, p_b, d_b = ([mpmath.mpf(float(x)) for x in v] for v in (p_a, d_a, p_b, d_b))
        n = [d_a[(i + 1) % 3] * d_b[(i + 2) % 3] - d_a[(i + 2) % 3] * d_b[(i + 1) % 3] for i in range(3)]
        return abs(mpmath.fsum((b - a) * c for a, b, c in zip(p_a, p_b, n, strict=True))) / mpmath.norm(n)


# --- the line itself


def test_line_of_the_paper_seen_from_two_origins() -> None:
    p, q, a, b = [1, 2, 3], [4, 5, 6], [0, 0, 0], [0, 0, 1]
    from_a, from_b = PluckerLine.through(p, q, origin=a), PluckerLine.through(p, q, origin=b)
    assert_near(from_a.direction, np.array([1, 1, 1]) / np.sqrt(3), atol=4 * EPS)
    assert_near(from_a.moment, np.array([-1, 2, -1]) / np.sqrt(3), atol=4 * EPS)
    assert_near(from_b.moment, np.array([0, 1, -1]) / np.sqrt(3), atol=4 * EPS)
    U = lines.transfer_matrix(a, b)
    expected = np.eye(6)
    expected[3, 1], expected[4, 0] = 1, -1
    np.testing.assert_array_equal(U, expected)
    assert_near(U @ from_a.coordinates, from_b.coordinates, atol=4 * EPS)


@few
@given(point, direction, point, st.floats(-5, 5))
def test_every_point_of_the_line_gives_the_same_coordinates(p, d, o, s) -> None:
    first = PluckerLine.from_point_direction(p, d, origin=o)
    other = PluckerLine.from_point_direction(p + s * first.direction, d, origin=o)
    assert_near(other.coordinates, first.coordinates, atol=100 * EPS)
    assert abs(np.linalg.norm(first.direction) - 1) <= 4 * EPS
    assert abs(first.direction @ first.moment) <= 100 * EPS


@few
@given(point, direction, point)
def test_the_line_through_two_points_holds_both_and_points_from_the_first_to_the_second(p, d, o) -> None:
    line = PluckerLine.through(p, p + d, origin=o)
    assert line.direction @ d > 0
    tolerance = 200 * EPS * (1 + np.linalg.norm(p) / np.abs(d).max())
    assert line.distance_to(p) <= tolerance
    assert line.distance_to(p + d) <= tolerance
    turned = PluckerLine.through(p + d, p, origin=o)
    assert_near(turned.coordinates, -line.coordinates, atol=tolerance)


def test_the_nearer_of_two_points_carries_the_moment() -> None:
    near, far = np.array([0.1, 1.3, 0.7]), np.array([1e9, 1e8, 3e8])
    for line in (PluckerLine.through(far, near), PluckerLine.through(near, far)):
        assert_near(line.moment, np.cross(near, line.direction), atol=4 * EPS)


@few
@given(point, direction, point, point)
def test_the_closest_point_lies_on_the_line_at_right_angles(p, d, o, x) -> None:
    line = PluckerLine.from_point_direction(p, d, origin=o)
    for to, foot in ((o, line.point), (x, line.closest_point(x))):
        assert line.distance_to(foot) <= 200 * EPS
        assert abs((foot - to) @ line.direction) <= 200 * EPS
        assert_near(line.distance_to(to), np.linalg.norm(foot - to), atol=200 * EPS)


@few
@given(point, direction, point, point)
def test_transfer_matrix_and_transfer_to_agree_with_a_line_built_about_the_other_origin(p, d, a, b) -> None:
    seen_from_a = PluckerLine.from_point_direction(p, d, origin=a)
    seen_from_b = PluckerLine.from_point_direction(p, d, origin=b)
    moved = seen_from_a.transfer_to(b)
    assert_near(moved.coordinates, seen_from_b.coordinates, atol=200 * EPS)
    np.testing.assert_array_equal(moved.origin, b)
    U = lines.transfer_matrix(a, b)
    assert_near(U @ seen_from_a.coordinates, seen_from_b.coordinates, atol=200 * EPS)
    assert_near(U @ lines.transfer_matrix(b, a), np.eye(6), atol=100 * EPS)


@for_all("origin", [[0, 0, 0], [0.3, -1.0, 2.0]])
def test_a_moved_line_is_the_line_through_the_moved_points(origin) -> None:
    rng = np.random.default_rng(1)
    p, q, T = rng.normal(size=(50, 3)), rng.normal(size=(50, 3)), random_motion(rng, (50,))
    carried = [np.einsum("nij,nj->ni", T[:, :3, :3], x) + T[:, :3, 3] for x in (p, q)]
    moved = PluckerLine.through(p, q, origin=origin).transformed(T)
    expected = PluckerLine.through(*carried, origin=origin)
    assert_near(moved.coordinates, expected.coordinates, atol=1e-14)
    np.testing.assert_array_equal(moved.origin, expected.origin)
    if not any(origin):
        by_matrix = np.einsum("nij,nj->ni", lines.motion_matrix(T), PluckerLine.through(p, q).coordinates)
        assert_near(by_matrix, expected.coordinates, atol=1e-14)


def test_a_pose_rounded_to_float32_leaves_a_unit_direction() -> None:
    T = random_motion(np.random.default_rng(2)).astype(np.float32)
    moved = PluckerLine.through([1, 2, 3], [4, 5, 7]).transformed(T)
    assert abs(np.linalg.norm(moved.direction) - 1) <= 4 * EPS


def test_motion_matrix_is_the_adjoint_of_pinocchio_with_its_halves_exchanged() -> None:
    rng = np.random.default_rng(3)
    exchange = np.roll(np.eye(6), 3, axis=0)
    for T in random_motion(rng, (20,)):
        X, pose = lines.motion_matrix(T), pin.SE3(T)
        assert_near(exchange @ X @ exchange, pose.toActionMatrix(), atol=1e-15)
        assert_near(X, pose.toDualActionMatrix(), atol=1e-15)
        # The velocity (linear; angular) of a unit turn about a line is (moment; direction).
        line = PluckerLine.through(rng.normal(size=3), rng.normal(size=3))
        turn = pose.act(pin.Motion(line.moment, line.direction))
        moved = line.transformed(T)
        assert_near(np.r_[turn.linear, turn.angular], np.r_[moved.moment, moved.direction], atol=1e-14)


@for_all("k", [1, -1])
def test_a_translation_is_the_transfer_of_the_origin_the_other_way(k) -> None:
    T = np.eye(4)
    T[:3, 3] = [0.1 * k, 0.2, -0.3]
    np.testing.assert_array_equal(lines.motion_matrix(T), lines.transfer_matrix(T[:3, 3], [0, 0, 0]))


@few
@given(point, direction, point, st.floats(1e-3, 1e3))
def test_coordinates_give_the_line_back_at_any_positive_scale(p, d, o, scale) -> None:
    line = PluckerLine.from_point_direction(p, d, origin=o)
    back = PluckerLine.from_coordinates(scale * line.coordinates, origin=o)
    assert_near(back.coordinates, line.coordinates, atol=100 * EPS)


def test_a_rounding_sized_pitch_is_taken_out_of_the_coordinates() -> None:
    line = PluckerLine.from_coordinates([1, 0, 0, 1e-10, 3, -2])
    np.testing.assert_array_equal(line.coordinates, [1, 0, 0, 0, 3, -2])


def test_coordinates_of_a_line_through_its_new_origin_are_accepted_with_their_rounding() -> None:
    p, q = np.array([1.1, 2.3, 3.7]), np.array([4.9, 5.3, 6.1])
    b = (p + q) / 2
    k = lines.transfer_matrix([0, 0, 0], b) @ PluckerLine.through(p, q).coordinates
    assert PluckerLine.from_coordinates(k, origin=b).distance_to(b) <= 20 * EPS


# --- immutable, batched


def test_a_line_is_immutable_and_shares_nothing_with_its_arguments() -> None:
    p = np.array([1.0, 2.0, 3.0])
    k = np.array([1.0, 0, 0, 0, 3, -2])
    o = np.zeros(3)
    for line in (PluckerLine.from_point_direction(p, [1, 0, 0], origin=o), PluckerLine.from_coordinates(k, origin=o)):
        for name in ("direction", "moment", "origin"):
            with pytest.raises(ValueError, match="read-only"):
                getattr(line, name)[0] = 7
            with pytest.raises(AttributeError):
                setattr(line, name, p)
        before = line.coordinates
        p[:], k[:], o[:] = 9, 9, 9
        np.testing.assert_array_equal(line.coordinates, before)
        np.testing.assert_array_equal(line.origin, 0)
        p[:], k[:], o[:] = [1, 2, 3], [1, 0, 0, 0, 3, -2], 0
    line.coordinates[:] = 0
    np.testing.assert_array_equal(line.coordinates, before)


@for_all("duplicate", [lambda line: pickle.loads(pickle.dumps(line)), copy.deepcopy])
def test_a_copy_of_a_line_is_as_immutable_as_the_line(duplicate) -> None:
    line = PluckerLine.through([1, 2, 3], [4, 5, 6], origin=[1, 0, 0])
    again = duplicate(line)
    np.testing.assert_array_equal(again.coordinates, line.coordinates)
    np.testing.assert_array_equal(again.origin, line.origin)
    assert not again.moment.flags.writeable


@for_all("shape", BATCHES)
def test_every_function_takes_every_batch_shape_and_treats_each_line_alone(shape) -> None:
    rng = np.random.default_rng(5)
    p, q, o, x = (rng.normal(size=(*shape, 3)) for _ in range(4))
    T = random_motion(rng, shape)
    a, b = PluckerLine.through(p, q, origin=o), PluckerLine.from_point_direction(q, x)
    results = {
        "coordinates": lambda i: PluckerLine.through(p[i], q[i], origin=o[i]).coordinates,
        "transferred": lambda i: a[i].transfer_to(x[i]).coordinates,
        "transformed": lambda i: a[i].transformed(T[i]).coordinates,
        "closest": lambda i: a[i].closest_point(x[i]),
        "distance_to": lambda i: a[i].distance_to(x[i]),
        "reciprocal": lambda i: lines.reciprocal_product(a[i], b[i]),
        "distance": lambda i: lines.distance(a[i], b[i]),
        "incident": lambda i: lines.incident(a[i], b[i]),
        "foot_a": lambda i: lines.common_normal(a[i], b[i]).foot_a,
        "normal": lambda i: lines.common_normal(a[i], b[i]).direction,
        "angle": lambda i: lines.angle(a[i], b[i]),
        "U": lambda i: lines.transfer_matrix(p[i], q[i]),
        "X": lambda i: lines.motion_matrix(T[i]),
    }
    for name, result in results.items():
        whole = result(...)
        assert whole.shape[: len(shape)] == shape, name
        for i in np.ndindex(*shape):
            assert_near(result(i), whole[i], atol=1e-13, err_msg=name)


def test_arguments_broadcast_against_each_other() -> None:
    grid = PluckerLine.through(np.zeros((4, 1, 3)), np.eye(3), origin=[1.0, 2.0, 3.0])
    assert grid.batch_shape == grid.moment.shape[:-1] == grid.origin.shape[:-1] == (4, 3)
    assert lines.distance(grid, PluckerLine.through([0, 0, 1], [1, 0, 1])).shape == (4, 3)


def test_lines_of_a_batch_are_picked_by_index() -> None:
    batch = PluckerLine.from_point_direction(np.arange(18.0).reshape(2, 3, 3), [0, 0, 1])
    np.testing.assert_array_equal(batch[1, 2].point, [15, 16, 0])
    assert batch[:, 1:].batch_shape == (2, 2)
    assert batch[0].batch_shape == (3,)
    with pytest.raises(IndexError):
        batch[2]


def test_a_batch_is_iterated_over_along_its_first_axis() -> None:
    batch = PluckerLine.from_point_direction(np.arange(18.0).reshape(2, 3, 3), [0, 0, 1])
    assert [row.batch_shape for row in batch] == [(3,), (3,)]
    assert [line.point.tolist() for line in batch[1]] == [[9, 10, 0], [12, 13, 0], [15, 16, 0]]
    assert list(batch[:0]) == []


def test_a_single_line_is_not_iterated_over() -> None:
    line = PluckerLine.through([0, 0, 0], [1, 0, 0])
    for walk in (iter, list, lambda line: [*line]):
        with pytest.raises(NaoKinError, match="a single PluckerLine contains no lines to iterate over"):
            walk(line)
    with pytest.raises(TypeError):
        iter(line)
    assert not np.iterable(line)


@for_all(("ulps", "is_line"), [(-5, False), (-1, False), (0, False), (1, False), (5, False), (8, True), (-8, True)])
def test_two_points_are_one_up_to_four_roundings_of_their_largest_coordinate(ulps, is_line) -> None:
    p, q = np.array([1.0, -0.5, 3.0]), np.array([1.0, -0.5, 3.0 + ulps * 2 * EPS])
    for scale in (1.0, 2.0**-400, 2.0**300):
        if is_line:
            np.testing.assert_array_equal(PluckerLine.through(scale * p, scale * q).direction, [0, 0, np.sign(ulps)])
        else:
            with pytest.raises(DegeneratePoints):
                PluckerLine.through(scale * p, scale * q)


@for_all("size", [1.0, 1e3])
def test_a_pitch_up_to_1e_9_of_the_moment_is_taken_for_rounding(size) -> None:
    PluckerLine([0, 1, 0], [size, 0.99e-9 * size, 0])
    for pitch in (1.01e-9, 1e-7, 1e-3):
        with pytest.raises(BadArgument, match="screw of pitch"):
            PluckerLine([0, 1, 0], [size, pitch * size, 0])


# --- two lines


@few
@given(point, direction, point, direction, point, point)
def test_the_common_normal_connects_its_feet_at_right_angles(p, d, q, f, o, w) -> None:
    a, b = PluckerLine.from_point_direction(p, d, origin=o), PluckerLine.from_point_direction(q, f, origin=w)
    sine = np.linalg.norm(np.cross(a.direction, b.direction))
    normal = lines.common_normal(a, b)
    # Feet of nearly parallel lines lie far away, and move by the rounding of the directions times that distance.
    tolerance = 1e-12 / max(sine, 1e-9) if not normal.parallel else 1e-12
    assert a.distance_to(normal.foot_a) <= tolerance
    assert b.distance_to(normal.foot_b) <= tolerance
    assert_near(normal.foot_a + normal.offset * normal.direction, normal.foot_b, atol=tolerance)
    assert abs(normal.direction @ a.direction) <= 1e-12
    assert abs(normal.direction @ b.direction) <= 1e-12
    assert abs(np.cos(normal.angle) - a.direction @ b.direction) <= 4 * EPS
    np.testing.assert_array_equal(normal.distance, abs(normal.offset))
    if not normal.parallel:
        assert normal.direction @ np.cross(a.direction, b.direction) > 0
        assert_near(normal.distance, float(exact_distance(p, d, q, f)), atol=tolerance)
    product = lines.reciprocal_product(a, b)
    assert_near(product, -normal.offset * np.sin(normal.angle), atol=1e-12)
    swapped = lines.common_normal(b, a)
    assert_near(swapped.distance, normal.distance, atol=tolerance)


def test_the_common_normal_of_close_parallels_is_perpendicular_to_them() -> None:
    a = PluckerLine.from_point_direction([0.0, 0.0, 6.1e-5], [1.0, 0.0, 1.0], origin=[3.0, 0.0, -1.0])
    b = PluckerLine.from_point_direction([0.0, 0.0, 0.0], [1.0, 0.0, 1.0], origin=[0.0, 0.0, 1.0])
    normal = lines.common_normal(a, b)
    assert normal.parallel
    assert abs(normal.direction @ a.direction) <= 4 * EPS


def test_offset_and_angle_are_the_length_and_twist_of_denavit_and_hartenberg() -> None:
    # x is the common normal, z and z' the axes: z' is z turned by the twist about x and shifted by the length along x.
    for twist in (-2.5, -1e-3, 1e-9, 0.7, 3.1):
        a = PluckerLine.from_point_direction([0, 0, 5], [0, 0, 2])
        b = PluckerLine.from_point_direction([0.25, 0, 1], [0, -np.sin(twist), np.cos(twist)])
        normal = lines.common_normal(a, b)
        sign = np.sign(twist)
        assert_near(normal.direction, [sign, 0, 0], atol=EPS)
        np.testing.assert_allclose([normal.offset * sign, normal.angle * sign], [0.25, twist], rtol=1e-15)
        assert_near(normal.foot_b, [0.25, 0, 1], atol=1e-14 / abs(np.sin(twist)))


@few
@given(point, direction, direction)
def test_lines_through_one_point_meet_there(p, d, f) -> None:
    a, b = PluckerLine.from_point_direction(p, d), PluckerLine.from_point_direction(p, f, origin=[1, 2, 3])
    sine = np.linalg.norm(np.cross(a.direction, b.direction))
    normal = lines.common_normal(a, b)
    assert normal.distance <= 100 * EPS / max(sine, 1e-3) + (1e-13 * 20 if normal.parallel else 0)
    assert abs(lines.reciprocal_product(a, b)) <= 100 * EPS
    if sine > 1e-6:
        assert lines.incident(a, b)
        assert_near(normal.foot_a, p, atol=100 * EPS / sine)
        assert abs(np.linalg.norm(normal.direction) - 1) <= 4 * EPS


@few
@given(small_angle, st.sampled_from([1.0, -1.0]), st.floats(-2, 2), st.floats(-2, 2))
def test_distance_of_nearly_parallel_lines_keeps_all_its_digits(angle, sign, height, along) -> None:
    a = PluckerLine.from_point_direction([0, 0, 0], [1, 0, 0])
    b = PluckerLine.from_point_direction([along, 0, height], [sign * np.cos(angle), sign * np.sin(angle), 0])
    normal = lines.common_normal(a, b)
    assert not normal.parallel
    assert_near(normal.distance, abs(height), atol=4 * EPS)
    np.testing.assert_allclose(np.sin(normal.angle), angle, rtol=1e-3 * angle + 1e-3)
    assert_near(normal.foot_a, [along, 0, 0], atol=1e-15 / angle)


@few
@given(point, direction, point, direction, small_angle, st.sampled_from([1.0, -1.0]))
def test_distance_beside_parallel_is_exact_for_the_directions_stored(p, d, q, f, angle, sign) -> None:
    e = d / np.linalg.norm(d)
    aside = np.cross(e, f) if np.linalg.norm(np.cross(e, f)) > 1e-3 else np.cross(e, np.eye(3)[np.abs(e).argmin()])
    g = np.cos(angle) * e + np.sin(angle) * aside / np.linalg.norm(aside)
    a, b = PluckerLine.from_point_direction(p, e), PluckerLine.from_point_direction(q, sign * g)
    tolerance = 20 * EPS * (1 + np.linalg.norm(q) + np.linalg.norm(p))
    # Against the directions as they are stored: one rounding of them turns the normal by EPS / angle.
    expected = float(exact_distance(p, a.direction, q, b.direction))
    assert_near(lines.distance(a, b), expected, atol=tolerance)


@few
@given(point, direction, point, st.sampled_from([1.0, -1.0, 3.7, -1e-3]), point)
def test_parallel_lines_have_their_distance_and_feet(p, d, q, scale, o) -> None:
    a, b = PluckerLine.from_point_direction(p, d), PluckerLine.from_point_direction(q, scale * d, origin=o)
    normal = lines.common_normal(a, b)
    assert normal.parallel
    gap = q - p
    expected = np.linalg.norm(gap - (gap @ a.direction) * a.direction)
    assert_near(normal.distance, expected, atol=1e-13)
    assert_near(normal.foot_a, a.point, atol=1e-13)
    assert b.distance_to(normal.foot_b) <= 1e-13
    assert_near(normal.angle, 0 if scale > 0 else np.pi, atol=1e-15)
    if expected > 1e-6:
        assert_near(normal.direction, (normal.foot_b - normal.foot_a) / expected, atol=1e-8)
        assert not lines.incident(a, b)
    assert abs(lines.reciprocal_product(a, b)) <= 1e-13


@few
@given(point, direction, st.floats(-3, 3), st.sampled_from([1.0, -1.0]))
def test_coincident_lines_meet_and_distinguish_no_normal(p, d, s, sign) -> None:
    a, b = PluckerLine.from_point_direction(p, d), PluckerLine.from_point_direction(p + s * d, sign * d)
    normal = lines.common_normal(a, b)
    assert normal.parallel
    assert lines.incident(a, b)
    np.testing.assert_array_equal(normal.direction, 0)
    assert_near(normal.foot_a, normal.foot_b, atol=1e-13)


def test_lines_within_1e_12_coincide_and_those_within_1e_9_share_a_point() -> None:
    a = PluckerLine.from_point_direction([0, 0, 0], [1, 0, 0])
    for apart, coincides, meets in (
        (0.99e-12, True, True),
        (1.01e-12, False, True),
        (1e-11, False, True),
        (0.99e-9, False, True),
        (1.01e-9, False, False),
        (1e-6, False, False),
    ):
        for direction in ([1, 0, 0], [-1, 0, 0]):
            b = PluckerLine.from_point_direction([0, apart, 0], direction)
            normal = lines.common_normal(a, b)
            np.testing.assert_array_equal(normal.direction, [0, 0 if coincides else 1, 0])
            assert normal.offset == lines.distance(a, b) == apart
            assert lines.incident(a, b) == meets
        crossing = PluckerLine.from_point_direction([0, 0, apart], [0, 1, 0])
        assert lines.incident(a, crossing) == meets


@for_all("sign", [1.0, -1.0])
@for_all(("angle", "parallel"), [(0.0, True), (0.99e-13, True), (1.01e-13, False), (1e-12, False)])
def test_lines_count_as_parallel_under_1e_13_rad(angle, parallel, sign) -> None:
    a = PluckerLine.from_point_direction([0, 0, 0], [1, 0, 0])
    for other in ([sign, angle, 0], [sign, 0, -angle]):
        assert lines.common_normal(a, PluckerLine.from_point_direction([0, 0, 1], other)).parallel == parallel


def exactly_off(line: PluckerLine, p: np.ndarray) -> float:
    """Distance of a point from the line through `line.point` along `line.direction`, at 60 digits."""
    with mpmath.workdps(60):
        arm, e = (mpmath.matrix([mpmath.mpf(float(x)) for x in v]) for v in (p, line.direction))
        arm -= mpmath.matrix([mpmath.mpf(float(x)) for x in line.point])
        along = mpmath.fsum(arm[i] * e[i] for i in range(3)) / mpmath.fsum(x * x for x in e)
        return float(mpmath.norm(arm - along * e))


@for_all("sign", [1.0, -1.0])
@for_all("angle", [0.0, 2e-13, 1e-12, 1e-9, 1e-6, 1e-3, 0.5, 1.5])
def test_the_second_foot_is_the_first_moved_along_the_normal_and_both_lie_on_their_lines(angle, sign) -> None:
    rng = np.random.default_rng(9)
    p, d, q, f, o = rng.normal(size=(5, 10, 3))
    e = d / np.linalg.norm(d, axis=-1, keepdims=True)
    aside = np.cross(e, f)
    aside /= np.linalg.norm(aside, axis=-1, keepdims=True)
    # Every second pair has a line whose origin is far away, and whose closest point with it.
    o[::2] += 1e6 * e[::2]
    a = PluckerLine.from_point_direction(p, e, origin=o)
    b = PluckerLine.from_point_direction(q, sign * (np.cos(angle) * e + np.sin(angle) * aside))
    for one, other in ((a, b), (b, a), (a, a)):
        normal = lines.common_normal(one, other)
        np.testing.assert_array_equal(normal.foot_b, normal.foot_a + normal.offset[:, None] * normal.direction)
        for i in range(10):
            for line, foot in ((one[i], normal.foot_a[i]), (other[i], normal.foot_b[i])):
                assert exactly_off(line, foot) <= 8 * EPS * max(np.abs(foot).max(), np.abs(line.point).max())


def test_reciprocal_product_is_the_same_about_every_origin() -> None:
    rng = np.random.default_rng(6)
    p, d, q, f, o, w = rng.normal(size=(6, 40, 3))
    a, b = PluckerLine.from_point_direction(p, d), PluckerLine.from_point_direction(q, f)
    moved = lines.reciprocal_product(a.transfer_to(o), b.transfer_to(w))
    assert_near(moved, lines.reciprocal_product(a, b), atol=1e-13)
    assert_near(lines.reciprocal_product(b, a), lines.reciprocal_product(a, b), atol=1e-13)


@for_all("angle", [0.0, 3e-14, 0.99e-13, 1e-10, 1e-3, 1.0])
@for_all("sign", [1.0, -1.0])
def test_distance_angle_and_incidence_do_not_depend_on_the_order_of_the_lines(angle, sign) -> None:
    rng = np.random.default_rng(11)
    p, d, f, o, w = rng.normal(size=(5, 500, 3))
    # Points of the lines metres to kilometres from where they are near each other, and lines that meet.
    q = p + d * 10.0 ** rng.uniform(0, 4, (500, 1)) + 1e-9 * f * rng.integers(0, 2, (500, 1))
    a = PluckerLine.from_point_direction(p, d, origin=o)
    b = PluckerLine.from_point_direction(q, sign * (d + angle * f), origin=w)
    ab, ba = lines.distance(a, b), lines.distance(b, a)
    np.testing.assert_array_equal(ab, ba)
    np.testing.assert_array_equal(lines.angle(a, b), lines.angle(b, a))
    np.testing.assert_array_equal(lines.incident(a, b), lines.incident(b, a))
    # The normal of lines that are parallel but for rounding is measured at its foot.
    assert_near(lines.common_normal(a, b).distance, ab, atol=1e-13 * 3e4 if angle < 1e-13 else 0)
    for one in (0, 17):
        assert lines.distance(a[one], b[one]) == lines.distance(b[one], a[one])


@few
@given(direction, direction)
def test_the_angle_of_two_lines_has_all_its_digits(d, f) -> None:
    with mpmath.workdps(60):
        u, v = (mpmath.matrix([mpmath.mpf(float(x)) for x in w]) for w in (d, f))
        cosine = mpmath.fsum(u[i] * v[i] for i in range(3)) / mpmath.norm(u) / mpmath.norm(v)
        expected = float(mpmath.acos(max(min(cosine, 1), -1)))
    a, b = PluckerLine.from_point_direction([1, 2, 3], d), PluckerLine.from_point_direction([0, 0, 1], f)
    assert_near(lines.angle(a, b), expected, atol=8 * EPS)


@for_all("angle", [1e-12, 1e-9, 1e-4, np.pi - 1e-9])
def test_small_angles_of_lines_and_those_near_half_a_turn_keep_their_digits(angle) -> None:
    a = PluckerLine.from_point_direction([0, 0, 0], [1, 0, 0])
    b = PluckerLine.from_point_direction([0, 0, 1], [np.cos(angle), np.sin(angle), 0])
    assert_near(lines.angle(a, b), angle, atol=4 * EPS if angle > 1 else 4 * EPS * angle)


# --- joint axes

MIMIC_ARM = """<robot name="arm"><link name="base"/><link name="one"/><link name="two"/><link name="three"/>
<link name="four"/><link name="side"/>
<joint name="a" type="revolute"><parent link="base"/><child link="one"/><origin xyz="0.1 0 0.3" rpy="0.4 0 0"/>
 <axis xyz="0 0.6 -0.8"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
<joint name="b" type="revolute"><parent link="one"/><child link="two"/><origin xyz="0 0.2 0.1" rpy="0 -0.7 0.2"/>
 <axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
<joint name="c" type="revolute"><parent link="two"/><child link="three"/><origin xyz="0.3 0 0"/>
 <axis xyz="-1 0 0"/><limit lower="-3" upper="3" effort="1" velocity="1"/>
 <mimic joint="a" multiplier="-1.5" offset="0.2"/></joint>
<joint name="d" type="revolute"><parent link="three"/><child link="four"/><origin xyz="0 0.1 0.2" rpy="1 2 3"/>
 <axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
<joint name="s" type="revolute"><parent link="base"/><child link="side"/><origin xyz="0 -0.3 0"/>
 <axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint></robot>"""
AXES = {"a": [0, 0.6, -0.8], "b": [0, 0, 1], "c": [-1, 0, 0], "d": [0, 1, 0], "s": [0, 0, 1]}
MULTIPLIER, PRIMARY = {"c": -1.5}, {"c": "a"}


def test_columns_of_the_jacobian_are_plucker_coordinates_the_coupled_one_included() -> None:
    model = pin.buildModelFromXML(MIMIC_ARM, mimic=True)
    assert model.nv == 4
    data = model.createData()
    rng = np.random.default_rng(7)
    for link, carried in {"four": "abcd", "three": "abc", "side": "s"}.items():
        frame = model.getFrameId(link)
        coupling = np.zeros((len(AXES), model.nv))
        for row, name in enumerate(AXES):
            if name in carried:
                column = model.joints[model.getJointId(PRIMARY.get(name, name))].idx_v
                coupling[row, column] = MULTIPLIER.get(name, 1.0)
        for q in rng.uniform(-2, 2, (5, model.nq)):
            pin.computeJointJacobians(model, data, q)
            pin.updateFramePlacements(model, data)
            poses = [data.oMi[model.getJointId(name)] for name in AXES]
            axes = PluckerLine.from_point_direction(
                [pose.translation for pose in poses],
                [pose.rotation @ axis for pose, axis in zip(poses, AXES.values(), strict=True)],
            )
            placement = data.oMf[frame]
            results = {
                pin.WORLD: lines.geometric_jacobian(axes, coupling=coupling),
                pin.LOCAL_WORLD_ALIGNED: lines.geometric_jacobian(axes, at=placement.translation, coupling=coupling),
                pin.LOCAL: lines.geometric_jacobian(
                    axes.transformed(placement.inverse().homogeneous), coupling=coupling
                ),
            }
            for expressed_in, got in results.items():
                expected = pin.getFrameJacobian(model, data, frame, expressed_in)
                assert_near(got, expected, atol=1e-14)


@for_all("shape", BATCHES)
def test_the_jacobian_moves_points_as_finite_turns_about_the_axes_do(shape) -> None:
    rng = np.random.default_rng(8)
    axes = PluckerLine.from_point_direction(rng.normal(size=(*shape, 4, 3)), rng.normal(size=(*shape, 4, 3)))
    at = rng.normal(size=(*shape, 3))
    J = lines.geometric_jacobian(axes, at=at)
    assert J.shape == (*shape, 6, 4)
    h = 1e-6
    for i in np.ndindex(*shape):
        for j in range(4):
            line = axes[(*i, j)]
            turn = Rotation.from_rotvec(h * line.direction).as_matrix()
            moved = line.point + turn @ (at[i] - line.point)
            assert_near(J[(*i, slice(0, 3), j)], (moved - at[i]) / h, atol=1e-5)
            np.testing.assert_array_equal(J[(*i, slice(3, 6), j)], line.direction)


# --- bad input

LINE = PluckerLine.through([0, 0, 0], [1, 0, 0])
TWO, THREE = (PluckerLine.from_point_direction(np.zeros((n, 3)), [1, 0, 0]) for n in (2, 3))
GRID = PluckerLine.from_point_direction(np.zeros((2, 5, 3)), [1, 0, 0])
REFUSED = {
    "coincident points": (lambda: PluckerLine.through([1, 2, 3], [1, 2, 3]), DegeneratePoints),
    "points at the rounding": (lambda: PluckerLine.through([1, 2, 3], [1, 2, 3 + 4e-16]), DegeneratePoints),
    "zero direction": (lambda: PluckerLine.from_point_direction([1, 2, 3], [0, 0, 0]), ZeroNorm),
    "zero coordinates": (lambda: PluckerLine.from_coordinates(np.zeros(6)), ZeroNorm),
    "line at infinity": (lambda: PluckerLine.from_coordinates([0, 0, 0, 1, 0, 0]), ZeroNorm),
    "angle of two batches": (lambda: lines.angle(TWO, THREE), WrongShape),
    "screw": (lambda: PluckerLine.from_coordinates([1, 0, 0, 0.3, 1, 0]), BadArgument),
    "NaN point": (lambda: PluckerLine.through([1, np.nan, 3], [1, 2, 3]), NotFinite),
    "infinite direction": (lambda: PluckerLine.from_point_direction([1, 2, 3], [np.inf, 0, 0]), NotFinite),
    "NaN origin": (lambda: LINE.transfer_to([np.nan, 0, 0]), NotFinite),
    "wrong shape": (lambda: PluckerLine.through([1, 2], [3, 4]), WrongShape),
    "coordinates of five": (lambda: PluckerLine.from_coordinates(np.ones(5)), WrongShape),
    "points of two batches": (lambda: PluckerLine.through(np.zeros((2, 3)), np.ones((3, 3))), WrongShape),
    "parts of two batches": (lambda: PluckerLine(np.ones((2, 3)), np.zeros((3, 3))), WrongShape),
    "origin of another batch": (lambda: TWO.transfer_to(np.zeros((3, 3))), WrongShape),
    "lines of two batches": (lambda: lines.common_normal(TWO, THREE), WrongShape),
    "product of two batches": (lambda: lines.reciprocal_product(TWO, THREE), WrongShape),
    "motion that scales": (lambda: LINE.transformed(np.diag([2.0, 2, 2, 1])), NotARotation),
    "reflection": (lambda: lines.motion_matrix(np.diag([1.0, 1, -1, 1])), NotARotation),
    "projective motion": (lambda: lines.motion_matrix(np.eye(4) + np.eye(4, k=-3)), BadArgument),
    "motion without translation": (lambda: LINE.transformed(np.eye(3)), WrongShape),
    "NaN motion": (lambda: LINE.transformed(np.full((4, 4), np.nan)), NotFinite),
    "motion of another batch": (lambda: TWO.transformed(np.tile(np.eye(4), (3, 1, 1))), WrongShape),
    "origins of two batches": (lambda: lines.transfer_matrix(np.zeros((2, 3)), np.zeros((3, 3))), WrongShape),
    "one line for a chain": (lambda: lines.geometric_jacobian(LINE), WrongShape),
    "coupling of other size": (lambda: lines.geometric_jacobian(TWO, coupling=np.ones((3, 2))), WrongShape),
    "coupling that is no matrix": (lambda: lines.geometric_jacobian(TWO, coupling=[1.0, 1.0]), WrongShape),
    "NaN coupling": (lambda: lines.geometric_jacobian(TWO, coupling=[[np.nan], [1]]), NotFinite),
    "sliding as numbers": (lambda: lines.geometric_jacobian(TWO, sliding=[1, 0]), BadArgument),
    "sliding of other size": (lambda: lines.geometric_jacobian(TWO, sliding=[True]), WrongShape),
    "points of another batch": (lambda: lines.geometric_jacobian(GRID, at=np.zeros((3, 3))), WrongShape),
}


@for_all("case", REFUSED)
def test_bad_input_is_refused_with_the_librarys_own_error(case) -> None:
    call, error = REFUSED[case]
    with pytest.raises(error):
        call()


def test_a_refusal_names_the_entry_of_the_batch() -> None:
    with pytest.raises(DegeneratePoints, match=r"index \[1\]"):
        PluckerLine.through([[0, 0, 0], [1, 1, 1]], [1, 1, 1])
    with pytest.raises(BadArgument, match=r"pitch 0\.5 at index \[0, 1\]"):
        PluckerLine.from_coordinates([[[1, 0, 0, 0, 1, 0], [2, 0, 0, 1, 0, 0]]])
    with pytest.raises(ZeroNorm) as refusal:
        PluckerLine.from_point_direction([0, 0, 0], [[1, 0, 0], [0, 0, 0]])
    assert refusal.value.index == (1,)
