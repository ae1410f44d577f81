"""Robots that stand somewhere on a soccer field and see its lines and marks."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from calibration_samples import ANGLES, measured

import nao_kin as nk
from nao_kin.calibration import FIELDS, Lines, Pixels, calibrate
from nao_kin.calibration.problem import Problem
from nao_kin.errors import BadArgument, UnknownName, WrongShape

FIELD = FIELDS["SPL 2020"]
HEAD = ["HeadYaw", "HeadPitch"]
NEAR = [
    "opponent goal line",
    "opponent penalty area line",
    "opponent left penalty area line",
    "opponent goal area line",
]
LENS = (0.1, -0.2, 0.003, -0.004, 0.05)


def drawn(name: str, count: int = 60) -> np.ndarray:
    """Points on a line of the field, shape (count, 3)."""
    if name == "centre circle":
        angle = np.linspace(0.0, 2.0 * np.pi, count)
        return FIELD.circle / 2.0 * np.stack((np.cos(angle), np.sin(angle), 0.0 * angle), axis=-1)
    return np.pad(np.linspace(*FIELD.lines[name], count), ((0, 0), (0, 1)))


def stand(nao: nk.RobotModel, place: tuple[float, float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Postures of a standing robot that looks around, and the pose of the field in its left sole."""
    yaws, pitches = np.meshgrid(np.linspace(-0.6, 0.6, 5), (0.0, 0.3))
    x, y, yaw = place
    T_field_sole = nk.screws.pose(nk.rotations.rot_z(yaw), (x, y, 0.0))
    return nao.posture("StandInit", HeadYaw=yaws.ravel(), HeadPitch=pitches.ravel()), nk.screws.inverse(T_field_sole)


def seen(true: nk.RobotModel, camera: Any, q: np.ndarray, T_sole_field: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Pixels (n, k, 2) of points of the field, NaN outside the image."""
    T = nk.screws.inverse(true.fk(q, camera.frame)) @ true.fk(q, "LLeg") @ T_sole_field
    pixels = camera.project(nk.screws.transform_point(T[:, None], points))
    pixels[~camera.sees(pixels)] = np.nan
    return pixels


def on_lines(
    true: nk.RobotModel, camera: Any, q: np.ndarray, T: np.ndarray, names: list[str], rng: np.random.Generator
) -> Lines:
    """Four noisy pixels on each line that each posture sees."""
    parts = []
    for name in names:
        pixels, part = seen(true, camera, q, T, drawn(name)), np.full((len(q), 4, 2), np.nan)
        for k, row in enumerate(pixels):
            good = np.flatnonzero(np.isfinite(row[:, 0]))
            if len(good):
                part[k] = row[rng.choice(good, 4)]
        parts.append(part + rng.normal(0.0, 0.5, part.shape))
    return Lines(q, camera, np.concatenate(parts, axis=1), [name for name in names for _ in range(4)], noise=0.5)


def test_the_dimensions_are_those_of_the_rule_book() -> None:
    points = FIELD.points
    assert points["opponent penalty mark"] == (3.2, 0.0, 0.0)
    assert points["own left corner"] == (-4.5, 3.0, 0.0)
    assert points["own right penalty area corner"] == (4.5 * -1 + 1.65, -2.0, 0.0)
    assert points["opponent left goal area at goal line"] == (4.5, 1.1, 0.0)
    assert FIELD.lines["opponent goal area line"] == ((3.9, -1.1), (3.9, 1.1))
    older = FIELDS["SPL 2013"]
    assert older.points["opponent left penalty area corner"] == (3.9, 1.1, 0.0)
    assert not any("goal area" in name for name in (*older.points, *older.lines))
    for field in FIELDS.values():
        for name, ends in field.lines.items():
            assert name.startswith(("own", "opponent", "left", "right", "halfway"))
            assert np.abs(ends).max() <= 4.5


@pytest.mark.parametrize("place", [(2.0, -0.5, 0.3), (-1.2, 0.4, 0.1), (3.0, 1.0, -2.5)])
def test_a_place_on_the_field_is_found_from_its_lines(nao: nk.NaoModel, place: tuple[float, float, float]) -> None:
    rng, camera = np.random.default_rng(3), measured(nao)
    true = nao.with_offsets({"HeadPitch": 0.02}, {"CameraTop": (0, 0, 0, 0.01, 0.03, 0)})
    q, T = stand(nao, place)
    one = on_lines(true, camera, q, T, ["centre circle", *FIELD.lines], rng)
    kept = [k for k in range(one.pixels.shape[1]) if np.isfinite(one.pixels[:, k]).any()]  # type: ignore[union-attr]
    one = replace(one, pixels=one.pixels[:, kept], lines=[one.lines[k] for k in kept])  # type: ignore[call-overload, index]
    found = calibrate(nao, [one], joints=HEAD, frames={"CameraTop": ANGLES})
    # Half a turn about the centre gives the same names to the other half, so that named lines tell the places apart.
    assert np.abs(found.poses["field"] - T)[:2, 3].max() < 0.15
    assert np.sqrt(np.mean(np.concatenate([part.ravel() for part in found.residuals]) ** 2)) < 1.2
    assert not found.outliers


def test_lines_and_marks_of_one_place_are_one_observation(nao: nk.NaoModel) -> None:
    rng, camera = np.random.default_rng(1), measured(nao)
    true = nao.with_offsets({"HeadPitch": -0.02, "HeadYaw": 0.015}, {"CameraTop": (0, 0, 0, 0.01, 0.02, 0.01)})
    q, T = stand(nao, (2.0, -0.5, 0.3))
    lines = on_lines(true, camera, q, T, NEAR, rng)
    names = ["opponent penalty mark", "opponent left penalty area corner", "opponent right goal area corner"]
    points = np.array([FIELD.points[name] for name in names])
    marks = Pixels(q, camera, seen(true, camera, q, T, points), points, "LLeg", board="field", on_floor=True)
    legs = dict.fromkeys(nao.chains["LLeg"], 1e-6)  # their zeros are right
    for observations in ([lines, marks], [marks]):
        found = calibrate(nao, observations, joints=HEAD, frames={"CameraTop": ANGLES}, prior=legs)
        assert np.linalg.norm(found.poses["field"] - T) < 0.1
        axis = [robot.fk(q, "CameraTop")[:, :3, 0] for robot in (true, found.calibrated(), nao)]
        errors = [np.abs(np.cross(axis[0], other)).max() for other in axis[1:]]
        assert errors[0] < 0.6 * errors[1]
    # The whole turn of the neck is also that of the robot on the field: its standard deviation says so.
    assert found.standard_deviations["HeadYaw offset"] > 0.005


@pytest.mark.parametrize("lens", [(), LENS])
def test_every_derivative_of_lines_is_that_of_finite_differences(nao: nk.NaoModel, lens: tuple[float, ...]) -> None:
    from test_jacobians import worst_derivative

    rng, camera = np.random.default_rng(2), replace(measured(nao), distortion=lens)
    q, T = stand(nao, (0.3, -1.4, 1.2))
    one = on_lines(nao, camera, q[:6], T, ["centre circle", "halfway line", "left touchline"], rng)
    at = replace(one, camera=replace(camera, frame="CameraTop_optical_frame"))
    speeds = rng.uniform(-1.0, 1.0, one.q.shape)  # type: ignore[union-attr]
    unknown = replace(one, camera=replace(camera, nominal=True), moving=lambda t: one.q + t * speeds)
    for some in (one, at):
        problem = Problem(nao, [some], ["HeadYaw", "LAnkleRoll", "LHipYawPitch"], {"CameraTop": ["x", "yaw"]}, {})
        for size in (0.0, 0.03):
            assert worst_derivative(problem, size * rng.uniform(-1.0, 1.0, problem.size)) < 1e-6
    problem = Problem(nao, [unknown], ["HeadYaw"], {}, {"field": T})
    assert worst_derivative(problem, np.zeros(problem.size)) < 0.02  # half a pixel from the lines


def test_a_straight_line_may_be_given_by_two_points(nao: nk.NaoModel) -> None:
    camera, (q, T) = measured(nao), stand(nao, (2.0, -0.5, 0.3))
    one = on_lines(nao, camera, q, T, NEAR, np.random.default_rng(0))
    same = replace(one, lines=[FIELD.lines[str(name)] for name in one.lines])
    first, second = (Problem(nao, [some], HEAD, (), {"field": T}) for some in (one, same))
    assert np.allclose(first.residuals(np.zeros(first.size)), second.residuals(np.zeros(first.size)))
    assert np.abs(first.residuals(np.zeros(first.size))).max() < 6.0


def test_the_next_posture_sees_the_lines_again(nao: nk.NaoModel) -> None:
    camera, (q, T) = measured(nao), stand(nao, (2.0, -0.5, 0.3))
    one = on_lines(nao, camera, q, T, NEAR, np.random.default_rng(0))
    found = calibrate(nao, [one], joints=HEAD, frames={"CameraTop": ANGLES})
    away = nao.posture("StandInit", HeadYaw=2.0)
    best = nk.calibration.next_posture(found, np.stack((q[0], away)))
    assert best.index == 0
    assert best.gain[0] > 0.01 > abs(best.gain[1])


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        (
            {"lines": ["opponent gaol line"] * 16},
            UnknownName,
            "unknown line of the field SPL 2020 'opponent gaol line'",
        ),
        ({"lines": "halfway line"}, BadArgument, "lines must be a list of names or of pairs of points"),
        ({"lines": [(1.0, 2.0)] * 16}, WrongShape, r"a line must have shape \(2, 2\)"),
        ({"lines": [((1.0, 2.0), (1.0, 2.0))] * 16}, BadArgument, "the two points of a line must differ"),
        ({"lines": ["halfway line"] * 3}, WrongShape, "pixels must have shape"),
        ({"field": "SPL 2030"}, UnknownName, "unknown field 'SPL 2030'"),
        ({"frame": "LLegg"}, UnknownName, "unknown frame 'LLegg'"),
        ({"noise": -1.0}, BadArgument, "noise of lines must be positive"),
        (
            {"pixels": np.full((10, 16, 2), np.nan)},
            BadArgument,
            "too few observations: 0 numbers for 3 of unknown poses",
        ),
        ({"pixels": np.full((10, 16, 2), [300.0, 1.0])}, BadArgument, "the place field needs at least three numbers"),
    ],
)
def test_wrong_lines_are_refused(
    nao: nk.NaoModel, change: dict[str, Any], error: type[Exception], message: str
) -> None:
    camera, (q, T) = measured(nao), stand(nao, (2.0, -0.5, 0.3))
    one = on_lines(nao, camera, q, T, NEAR, np.random.default_rng(0))
    with pytest.raises(error, match=message):
        calibrate(nao, [replace(one, **change)], joints=HEAD)


def test_a_floor_needs_a_sole_and_flat_points(nao: nk.NaoModel) -> None:
    camera, (q, _) = measured(nao), stand(nao, (2.0, -0.5, 0.3))
    one = Pixels(q, camera, np.full((10, 2, 2), 100.0), np.zeros((2, 3)), "LLeg", board="field", on_floor=True)
    for change in ({"board": None}, {"frame": None}, {"points": np.full((2, 3), 0.1)}):
        with pytest.raises(BadArgument, match="on_floor needs a board, a sole as its frame, and points with z = 0"):
            calibrate(nao, [replace(one, **change)], joints=HEAD)
    with pytest.raises(BadArgument, match="'field' names a place on the floor of LLeg and a board on LLeg"):
        calibrate(nao, [one, replace(one, on_floor=False)], joints=HEAD)
