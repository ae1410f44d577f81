"""Configurations as a robot's sensors give them: gaps, two hips that differ, and joints somewhat past their limits."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from made_up_robots import J, made_up

import nao_kin as nk
from nao_kin.errors import (
    BadInputFile,
    CouplingViolated,
    MeasuredLimitsWarning,
    OutsideLimits,
    UnknownName,
)

DEGREE = math.radians(1.0)


@pytest.fixture(scope="module")
def stand(nao: nk.NaoModel) -> dict[str, float]:
    return {name: float(value) for name, value in nao.angles(nao.clamp(nao.posture("Stand"))).items()}


def _measured(nao: nk.NaoModel, n: int = 200, seed: int = 0) -> dict[str, np.ndarray]:
    """Return the 26 values of n configurations with noise of 0.2°, a third of all joints at a limit."""
    rng = np.random.default_rng(seed)
    q = nao.random(rng, n)
    ends = np.where(rng.random(q.shape) < 0.5, nao.lower, nao.upper)
    q = nao.clamp(np.where(rng.random(q.shape) < 0.3, ends, q))
    body = nao.to_body(q) + rng.normal(0.0, math.radians(0.2), (n, 26)).clip(-DEGREE / 2, DEGREE / 2)
    return dict(zip(nao.body_order, body.T, strict=True))


# --- gaps ---------------------------------------------------------------------------------------------------------


def test_gaps_and_absent_joints_have_the_values_of_a_posture(nao: nk.NaoModel, stand: dict[str, float]) -> None:
    q = nao.configuration({"HeadYaw": [0.1, np.nan], "LHand": np.nan}, missing="Stand")
    assert q.shape == (2, 25)
    expected = [{**stand, "HeadYaw": 0.1}, stand]
    assert q.tolist() == [[row[name] for name in nao.joint_names] for row in expected]


@pytest.mark.parametrize("number", [0.5, -9.0])
def test_a_number_for_gaps_is_moved_to_the_nearest_limit(nao: nk.NaoModel, number: float) -> None:
    q = nao.configuration({"HeadYaw": 0.3}, missing=number)
    expected = nao.clamp(np.full(25, float(number)))
    expected[nao.joint_names.index("HeadYaw")] = 0.3
    np.testing.assert_array_equal(q, expected)
    assert nao.within_limits(nao.configuration({}, missing=number))


@pytest.mark.parametrize(
    ("left", "right", "expected"),
    [(np.nan, -0.3, -0.3), (-0.3, np.nan, -0.3), (np.nan, np.nan, None), (-0.3, -0.3, -0.3)],
)
@pytest.mark.parametrize("hips", [None, "left", "right", "average"])
def test_a_hip_without_a_value_has_that_of_the_other(
    nao: nk.NaoModel, stand: dict[str, float], left: float, right: float, expected: float | None, hips
) -> None:
    given = {"LHipYawPitch": left, "RHipYawPitch": [right, right]}
    q = nao.configuration(given, hips=hips, missing="Stand")
    found = nao.angles(q)["LHipYawPitch"]
    assert found.tolist() == pytest.approx([stand["LHipYawPitch"] if expected is None else expected] * 2, abs=0.0)


def test_gaps_of_coupled_joints_are_filled_through_the_coupling(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("a"), J("b", follows=("a", -2.0, 0.5), limits=(-9.0, 9.0)), J("c"))
    q = robot.configuration({"b": [0.7, np.nan], "c": [np.nan, 0.2]}, missing=0.25)
    np.testing.assert_allclose(q, [[-0.1, 0.25], [0.25, 0.2]], atol=1e-15)


def test_gaps_are_refused_without_a_value_for_them(nao: nk.NaoModel) -> None:
    expected = r"LHand must be finite, got nan at index \[1\] \(missing= gives its value\)"
    with pytest.raises(nk.errors.NotFinite, match=expected):
        nao.configuration({"LHand": [0.0, np.nan]})
    body = np.where(np.array(nao.body_order) == "LHand", np.nan, [nao.to_body(nao.posture("Stand"))] * 2)
    body[0] = nao.to_body(nao.posture("Stand"))
    with pytest.raises(nk.errors.NotFinite, match=expected):
        nao.from_body(body)
    with pytest.raises(nk.errors.NotFinite, match=expected):
        nk.naoqi.from_order(nao, body, "H25")
    with pytest.raises(nk.errors.NotFinite, match="HeadYaw"):
        nao.configuration({"HeadYaw": np.inf}, missing="Stand")
    with pytest.raises(UnknownName, match=r"posture 'Stnad' \(nearest: Stand"):
        nao.configuration({}, missing="Stnad")


# --- limits -------------------------------------------------------------------------------------------------------


def test_noise_of_sensors_is_accepted_by_name_with_one_warning(nao: nk.NaoModel) -> None:
    values = _measured(nao)
    with pytest.raises(OutsideLimits):
        nao.configuration(values, hips="average")
    with pytest.warns(
        MeasuredLimitsWarning, match=r"^\d+ configurations have joints outside their limits, \w+ by 0\.\d+°"
    ) as caught:
        q = nao.configuration(values, hips="average", limits="measured")
    assert len(caught) == 1
    # The values are kept as they are.
    np.testing.assert_array_equal(q, nao.configuration(values, hips="average", limits="ignore"))
    outside = np.abs(nao.clamp(q) - q)
    text = str(caught[0].message)
    assert text.startswith(f"{int((outside.max(axis=1) > 1e-6).sum())} configurations")
    assert f"{nao.joint_names[int(outside.max(axis=0).argmax())]} by {math.degrees(outside.max()):.2g}°" in text


def _recorded(nao: nk.NaoModel) -> dict[str, np.ndarray]:
    """Return a gesture with zeros that are off and joints pressed to their stops, as far as in real recordings."""
    excess = {"LShoulderRoll": 4.24, "RWristYaw": 2.6, "LElbowRoll": 1.8, "HeadYaw": 0.3}
    values = {name: np.tile(value, 50) for name, value in nao.angles(nao.clamp(nao.posture("Stand"))).items()}
    for name, beyond in excess.items():
        at = nao.joint_names.index(name)
        values[name] = nao.upper[at] + np.radians(np.linspace(-20.0, beyond, 50))
    return values


def test_what_a_real_robot_records_is_accepted_and_the_joints_are_named(nao: nk.NaoModel, tmp_path: Path) -> None:
    values = _recorded(nao)
    named = "LShoulderRoll by 4.2°, RWristYaw by 2.6°, LElbowRoll by 1.8°, HeadYaw by 0.3°"
    with pytest.warns(MeasuredLimitsWarning, match=named):
        nao.configuration(values, limits="measured")
    # The farthest of several blocks and files, whichever comes first.
    files = []
    for rows in (slice(25, None), slice(None, 45)):
        files.append(tmp_path / f"{rows.start}.csv")
        table = np.column_stack([values[name][rows] for name in nao.joint_names])
        np.savetxt(files[-1], table, delimiter=",", header=",".join(nao.joint_names), comments="")
    with pytest.warns(MeasuredLimitsWarning, match=named):
        result = nk.stream.fk(nao, files, tmp_path / "t.npy", frame="LArm", limits="measured")
    assert list(result.clamped.joints) == ["LShoulderRoll", "RWristYaw", "LElbowRoll", "HeadYaw"]
    assert result.clamped.joint == "LShoulderRoll"
    assert math.degrees(result.clamped.largest) == pytest.approx(4.24)


def test_a_warning_names_the_joints_that_are_farthest_out(nao: nk.NaoModel) -> None:
    arms = [name for name in nao.joint_names if any(part in name for part in ("Shoulder", "Elbow", "WristYaw"))]
    beyond = {
        name: nao.upper[nao.joint_names.index(name)] + math.radians(0.1 * k) for k, name in enumerate(arms, start=1)
    }
    with pytest.warns(MeasuredLimitsWarning) as caught:
        nao.configuration(beyond, limits="measured")
    text = str(caught[0].message)
    assert [f"{name} by" in text for name in arms] == [False] * 4 + [True] * 6
    assert "and 4 more joints" in text


@pytest.mark.parametrize("name", ["HeadYaw", "RElbowRoll", "LHand"])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_the_tolerance_is_five_degrees_or_two_hundredths(nao: nk.NaoModel, name: str, side: float) -> None:
    column = nao.joint_names.index(name)
    tolerance = 0.02 if name == "LHand" else 5.0 * DEGREE
    limit = (nao.lower if side < 0 else nao.upper)[column]
    with pytest.warns(MeasuredLimitsWarning, match=f"^1 configuration has .*{name}"):
        nao.configuration({name: limit + side * 0.999 * tolerance}, limits="measured")
    with pytest.raises(OutsideLimits, match=name):
        nao.configuration({name: limit + side * 1.001 * tolerance}, limits="measured")
    q = nao.neutral()
    q[column] = limit + side * 0.999 * tolerance
    inside = nao.within_limits(q, per_joint=True, limits="measured")
    assert inside[column]
    assert not nao.within_limits(q, per_joint=True)[column]


def test_a_coupled_limit_has_the_same_tolerance(nao: nk.NaoModel) -> None:
    yaw = 1.2
    pitch = nao.angles(nao.clamp(nao.configuration({"HeadYaw": yaw, "HeadPitch": 9.0}, limits="ignore")))["HeadPitch"]
    with pytest.warns(MeasuredLimitsWarning, match="HeadPitch by 4.9°"):
        nao.configuration({"HeadYaw": yaw, "HeadPitch": pitch + 4.9 * DEGREE}, limits="measured")
    with pytest.raises(OutsideLimits, match="HeadPitch"):
        nao.configuration({"HeadYaw": yaw, "HeadPitch": pitch + 5.1 * DEGREE}, limits="measured")


# --- the same in the other readers --------------------------------------------------------------------------------


def test_orders_of_joints_take_the_same_options(nao: nk.NaoModel) -> None:
    q = nao.random(3, 4)
    values = nk.naoqi.to_order(nao, q, "LoLA")
    broken = np.where(values == nao.angles(q)["LHand"][:, None], np.nan, values)
    assert np.isnan(broken).sum() == 4
    found = nk.naoqi.from_order(nao, broken, "LoLA", hips="left", missing=0.5)
    column = nao.joint_names.index("LHand")
    assert found[:, column].tolist() == [0.5] * 4
    np.testing.assert_allclose(np.delete(found, column, 1), np.delete(q, column, 1))
    body = nao.to_body(q)
    body[:, nao.body_order.index("RHipYawPitch")] += 0.01
    with pytest.raises(CouplingViolated):
        nao.from_body(body)
    hip = nao.joint_names.index("LHipYawPitch")
    np.testing.assert_allclose(nao.from_body(body, hips="average")[:, hip], q[:, hip] + 0.005)


PARTIAL = "time,HeadYaw,HeadPitch,LFsr\n0,0.1,,3.2\n0.1,NaN,0.2,3.3\n"


def test_a_partial_table_is_a_log_with_values_for_the_missing(
    nao: nk.NaoModel, stand: dict[str, float], tmp_path: Path
) -> None:
    path = tmp_path / "part.csv"
    path.write_text(PARTIAL)
    with pytest.raises(BadInputFile, match=r"missing joints: .*; missing= \(--missing\) gives their values"):
        nk.stream.read_log(nao, path, ignore_other=True)
    log = nk.stream.read_log(nao, path, ignore_other=True, missing="Stand")
    yaw, pitch = nao.angles(log.q)["HeadYaw"], nao.angles(log.q)["HeadPitch"]
    assert yaw.tolist() == [0.1, stand["HeadYaw"]]
    assert pitch.tolist() == [stand["HeadPitch"], 0.2]
    assert log.times.tolist() == [0.0, 0.1]
    nk.stream.fk(nao, path, tmp_path / "t.npy", frame="CameraTop", ignore_other=True, missing="Stand")
    np.testing.assert_array_equal(np.load(tmp_path / "t.npy"), nao.fk(log.q, "CameraTop"))


@pytest.mark.parametrize("text", ["time,HeadYaw\n,0.1\n", "time,HeadYaw\nnan,0.1\n", "time,HeadYaw\n0,inf\n"])
def test_times_have_no_gaps_and_infinity_is_no_gap(nao: nk.NaoModel, tmp_path: Path, text: str) -> None:
    (tmp_path / "a.csv").write_text(text)
    with pytest.raises(BadInputFile, match="line 2"):
        nk.stream.read_log(nao, tmp_path / "a.csv", missing="Stand")


def test_joint_states_in_json_with_gaps_and_fingers(nao: nk.NaoModel, stand: dict[str, float], tmp_path: Path) -> None:
    names = [*nao.body_order, "LFinger11"]
    values = [stand.get(name, stand["LHipYawPitch"] + 0.002) for name in nao.body_order]
    values[names.index("LHand")] = None  # NaN is null in JSON
    message = {"header": {"stamp": {"secs": 3, "nsecs": 0}}, "name": names, "position": [*values, 0.3]}
    (tmp_path / "states.json").write_text(json.dumps([message, message]))
    log = nk.stream.read_log(
        nao, tmp_path / "states.json", hips="average", missing="Stand", ignore_other=True, limits="measured"
    )
    expected = np.array([stand[name] for name in nao.joint_names])
    expected[nao.joint_names.index("LHipYawPitch")] += 0.001
    np.testing.assert_allclose(log.q, [expected, expected], atol=1e-12)


def test_a_run_over_a_file_counts_what_it_accepted(nao: nk.NaoModel, tmp_path: Path) -> None:
    values = _measured(nao)
    rows = np.column_stack(list(values.values()))
    np.savetxt(tmp_path / "log.csv", rows, delimiter=",", header=",".join(values), comments="")
    source, sink = tmp_path / "log.csv", tmp_path / "t.npy"
    with pytest.warns(MeasuredLimitsWarning) as caught:
        result = nk.stream.fk(nao, source, sink, frame="LArm", hips="average", limits="measured")
    assert len([warning for warning in caught if warning.category is MeasuredLimitsWarning]) == 1
    assert result.bad_rows == 0
    assert result.rows_written == len(rows)
    assert str(caught[0].message).startswith(f"{result.clamped.rows} configurations")
    with pytest.raises(BadInputFile, match="outside the joint limits.* as noise of a sensor$"):
        nk.stream.fk(nao, source, sink, frame="LArm", hips="average", overwrite=True)
