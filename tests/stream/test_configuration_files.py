from __future__ import annotations

import io
import json
import random
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import nao_kin as nk
from nao_kin._core import csv_numbers
from nao_kin.errors import BadInputFile
from nao_kin.stream.tables import read_log


def _csv(nao: nk.NaoModel, q: np.ndarray, names: list[str], delimiter: str = ",") -> str:
    columns = nao.angles(q)
    columns["RHipYawPitch"] = columns["LHipYawPitch"]
    rows = zip(*(columns[name] for name in names), strict=True)
    return "\n".join([delimiter.join(names), *(delimiter.join(map(repr, map(float, row))) for row in rows)]) + "\n"


@pytest.fixture
def shuffled(nao: nk.NaoModel) -> list[str]:
    names = list(nao.joint_names)
    random.Random(0).shuffle(names)
    return names


def test_json_holds_one_object_or_a_list(nao: nk.NaoModel, tmp_path: Path) -> None:
    q = nao.random(0, 3)
    path = tmp_path / "poses.json"
    path.write_text(json.dumps([nao.angles(row) for row in q]))
    log = read_log(nao, path)
    read, many = log.q, log.many
    assert many
    assert np.array_equal(read, q)
    path.write_text(json.dumps(nao.angles(q[1])))
    log = read_log(nao, path)
    read, many = log.q, log.many
    assert not many
    assert np.array_equal(read, q[1:2])


@pytest.mark.parametrize("kind", ["csv", "json"])
def test_standard_input_is_recognised_by_its_content(
    nao: nk.NaoModel, shuffled: list[str], monkeypatch: pytest.MonkeyPatch, kind: str
) -> None:
    q = nao.random(0, 2)
    text = _csv(nao, q, shuffled) if kind == "csv" else json.dumps([nao.angles(row) for row in q])
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(text.encode())))
    assert np.array_equal(read_log(nao, "-").q, q)


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.csv", f"{','.join(['0.1'] * 25)}\n" * 2, "line 1: 25 numbers and no header: .* joint_names or, .* LoLA$"),
        ("a.csv", f"{','.join(['0.1'] * 26)}\n" * 2, "line 1: 26 numbers and no header: .* H25, .* 25 joints$"),
        ("a.csv", f"0;{';'.join(['0.1'] * 26)}\n" * 2, "line 1: 27 numbers and no header: the .* name the joints$"),
        ("a.csv", f"2026-03-01T12:00:00,{','.join(['0.1'] * 25)}\n", "line 1: 26 numbers and no header"),
        (
            "a.txt",
            "Dear robot,\nhow are you?\n",
            "line 1: no table of joint values: the first line must name the joints",
        ),
        (
            "a.yaml",
            "header:\n  stamp:\n    sec: 1\nname:\n- HeadYaw\n",
            "a JointState with 0 positions|line 1: no table",
        ),
        ("a.html", "<!DOCTYPE html>\n<html></html>\n", "line 1: no table of joint values"),
        ("a.png", b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR", r"not UTF-8 text \(byte 0\); expected joint names and values$"),
    ],
)
def test_a_file_whose_first_line_names_no_joint_is_told_so(
    nao: nk.NaoModel, tmp_path: Path, name: str, text: str | bytes, message: str
) -> None:
    path = tmp_path / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    for ignore_other in (False, True):
        with pytest.raises(BadInputFile, match=message):
            read_log(nao, path, ignore_other=ignore_other)
        with pytest.raises(BadInputFile, match=message):
            nk.stream.fk(nao, path, tmp_path / "poses.npy", frame="Head", ignore_other=ignore_other)


# --- ROS messages, which name the joints in every row -----------------------------------------------------------------


def _rostopic(nao: nk.NaoModel, q: np.ndarray, names: list[str]) -> str:
    """Return joint states as `rostopic echo -p` prints them: the header is a comment."""
    columns = nao.angles(q)
    columns["RHipYawPitch"] = columns["LHipYawPitch"]
    heads = [f"field.{kind}{index}" for kind in ("name", "position") for index in range(len(names))]
    lines = [",".join(["%time", "field.header.seq", "field.header.stamp", "field.header.frame_id", *heads])]
    for row in range(len(q)):
        stamp = 1_700_000_000_000_000_000 + 20_000_000 * row
        values = (repr(float(columns[name][row])) for name in names)
        lines.append(",".join([str(stamp), str(row), str(stamp), "", *names, *values]))
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("large", [False, True], ids=["", "large"])
def test_joint_states_that_rostopic_prints_are_read_by_the_names_in_their_rows(
    nao: nk.NaoModel, shuffled: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, large: bool
) -> None:
    monkeypatch.setattr(csv_numbers, "_LARGE", 0 if large else 1 << 30)
    q, path, sink = nao.random(0, 7), tmp_path / "states.csv", tmp_path / "poses.npy"
    text = _rostopic(nao, q, ["RHipYawPitch", *shuffled])
    path.write_text(text)
    log = read_log(nao, path)
    assert np.array_equal(log.q, q)
    assert np.allclose(log.times, 1.7e9 + 0.02 * np.arange(7), rtol=0.0, atol=1e-6)
    nk.stream.fk(nao, path, sink, frame="LArm")
    assert np.allclose(np.load(sink), nao.fk(q, "LArm"), rtol=0.0, atol=1e-12)
    with pytest.warns(nk.motion.MotionFileWarning, match="taken as ns"):
        motion = nk.motion.read_motion(path)
    assert np.array_equal(motion.configurations(nao).q, q)
    # columns= has the last word.
    swapped = {"field.position1": shuffled[1], "field.position2": shuffled[0]}
    one, other = (nao.joint_names.index(name) for name in shuffled[:2])
    expected = q.copy()
    expected[:, [one, other]] = q[:, [other, one]]
    assert np.array_equal(read_log(nao, path, columns=swapped, limits="ignore").q, expected)
    # A message in another order, as of another node, is a bad row.
    lines = text.splitlines()
    lines[4] = lines[4].replace(f"{shuffled[0]},{shuffled[1]}", f"{shuffled[1]},{shuffled[0]}")
    path.write_text("\n".join(lines))
    message = r"line 5: its joints are not those of the first row"
    for read in (lambda: read_log(nao, path), lambda: nk.stream.fk(nao, path, sink, frame="LArm", overwrite=True)):
        with pytest.raises(BadInputFile, match=message):
            read()
    done = nk.stream.fk(nao, path, sink, frame="LArm", on_error="skip", overwrite=True)
    assert (done.bad_rows, done.first_bad_rows[0].line) == (1, 5)


def _state(nao: nk.NaoModel, q: np.ndarray, stamp: dict[str, int]) -> dict[str, Any]:
    values = nao.angles(q)
    header = {"stamp": stamp, "frame_id": "base_link"}
    return {"header": header, "name": [*values], "position": [*values.values()], "velocity": [], "effort": []}


def test_joint_states_in_json_are_configurations_with_their_stamps(nao: nk.NaoModel, tmp_path: Path) -> None:
    q, path = nao.random(0, 2), tmp_path / "state.json"
    first = _state(nao, q[0], {"sec": 12, "nanosec": 500_000_000})
    second = {"op": "publish", "topic": "/joint_states", "msg": _state(nao, q[1], {"secs": 13, "nsecs": 0})}
    for document, times in ((first, [12.5]), (second, [13.0]), ([first, second], [12.5, 13.0])):
        path.write_text(json.dumps(document))
        log = read_log(nao, path)
        assert np.array_equal(log.q, q[-1:] if document is second else q[: len(times)])
        assert log.times.tolist() == times
        assert log.many is isinstance(document, list)
        assert not nk.motion.is_motion_file(path)
    path.write_text(json.dumps({**first, "header": {}}))
    assert read_log(nao, path).times is None


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"position": []}, "a JointState with 0 positions for 25 names"),
        ({"name": [1] * 25}, "a JointState with 25 positions for 25 names"),
        ({"name": ["HeadYaw"] * 25}, "a JointState that names a joint twice"),
        ({"position": [None] * 25}, "HeadYaw is null, expected a finite number"),
    ],
)
def test_a_wrong_joint_state_is_refused(nao: nk.NaoModel, tmp_path: Path, change: dict, message: str) -> None:
    path = tmp_path / "state.json"
    path.write_text(json.dumps({**_state(nao, nao.neutral(), {}), **change}))
    with pytest.raises(BadInputFile, match=message):
        read_log(nao, path)


def test_a_joint_state_is_no_motion(nao: nk.NaoModel, tmp_path: Path) -> None:
    path = tmp_path / "state.json"
    path.write_text(json.dumps(_state(nao, nao.neutral(), {})))
    for format in (None, "motion2"):
        with pytest.raises(BadInputFile, match="a ROS JointState, which is one configuration"):
            nk.motion.read_motion(path, format=format)


def test_a_joint_whose_column_is_left_out_is_at_zero(nao: nk.NaoModel, tmp_path: Path) -> None:
    # naoqi_driver publishes NaN for the hands.
    q, path, sink = nao.random(0, 3), tmp_path / "log.csv", tmp_path / "poses.npy"
    hands = [nao.joint_names.index(name) for name in ("LHand", "RHand")]
    q[:, hands] = np.nan
    path.write_text("\n".join([",".join(nao.joint_names), *(",".join(map(repr, row)) for row in q.tolist())]))
    with pytest.raises(BadInputFile, match="LHand is 'nan'"):
        read_log(nao, path)
    left_out = {"LHand": None, "RHand": None}
    q[:, hands] = 0.0
    assert np.array_equal(read_log(nao, path, columns=left_out).q, q)
    nk.stream.fk(nao, path, sink, frame="LArm", columns=left_out)
    assert np.allclose(np.load(sink), nao.fk(q, "LArm"), rtol=0.0, atol=1e-12)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('{"HeadYaw": 0.1,}', r"line 1, column \d+: malformed JSON"),
        ('{"HeadYaw":\n 0.1 x}', r"line 2, column 6: malformed JSON"),
        ('{"HeadYaw": 0.1, "HeadYaw": 0.2}', "'HeadYaw' is given twice in one object"),
        ('{"HeadYaw": 0.1}', "missing joints: HeadPitch"),
        ("[]", "a list without configurations"),
        ("[1, 2]", "configuration 0: expected an object of joint values, got 1"),
        ('"text"', "expected an object"),
        ('{"HeadYam": 1}', r"unknown joint 'HeadYam' \(nearest: HeadYaw"),
    ],
)
def test_bad_json_names_the_place(nao: nk.NaoModel, tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "poses.json"
    path.write_text(text)
    with pytest.raises(BadInputFile, match=message):
        read_log(nao, path)


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        ("NaN", "NaN"),
        ("Infinity", "Infinity"),
        ("true", "true"),
        ('"1"', "'1'"),
        ("null", "null"),
        ("[1]", "a list of 1"),
        ('{"a": 1}', "an object"),
        ("1e400", "a number too large for floating point"),
        ("1" * 400, "a number too large for floating point"),
        (f'"{"é" * 5000}"', ".é{38}…"),
    ],
    ids=lambda text: text[:10],
)
def test_json_values_must_be_finite_numbers(nao: nk.NaoModel, tmp_path: Path, value: str, shown: str) -> None:
    angles = nao.angles(nao.posture("Stand"))
    text = json.dumps([angles, angles])
    head, _, tail = text.rpartition('"HeadYaw": 0.0')
    path = tmp_path / "poses.json"
    path.write_text(f'{head}"HeadYaw": {value}{tail}')
    with pytest.raises(BadInputFile, match=f"configuration 1: HeadYaw is {shown}, expected a finite number"):
        read_log(nao, path)


@pytest.mark.parametrize("place", ["name", "second name", "value", "row", "quote"])
def test_long_cells_are_shortened_in_the_message(nao: nk.NaoModel, tmp_path: Path, place: str) -> None:
    names, values, long = list(nao.joint_names), ["0.0"] * len(nao.joint_names), "y" * 100_000
    if place.endswith("name"):
        names[-1] = long
        names += [long] * (place == "second name")
    elif place == "value":
        values[3] = long
    elif place == "row":
        values += [long]
    else:
        values[3] = '"' + long + long
    path = tmp_path / "poses.csv"
    path.write_text("\n".join([",".join(names), ",".join(values)]) + "\n")
    with pytest.raises(BadInputFile) as caught:
        read_log(nao, path)
    assert str(caught.value).count("y") <= 200
    assert caught.value.line == (1 if "name" in place else 2)


def test_every_object_of_a_list_names_the_same_joints(nao: nk.NaoModel, tmp_path: Path) -> None:
    angles = nao.angles(nao.posture("Stand"))
    other = {name: value for name, value in angles.items() if name != "HeadPitch"}
    path = tmp_path / "poses.json"
    path.write_text(json.dumps([angles, other]))
    with pytest.raises(BadInputFile, match="configuration 1: names other joints than configuration 0: HeadPitch"):
        read_log(nao, path)


def test_a_file_that_cannot_be_read_is_named(nao: nk.NaoModel, tmp_path: Path) -> None:
    with pytest.raises(BadInputFile, match=r"none\.csv: cannot be read: No such file"):
        read_log(nao, tmp_path / "none.csv")
    path = tmp_path / "latin.csv"
    path.write_bytes(b"HeadYaw\xff")
    with pytest.raises(BadInputFile, match=r"not UTF-8 text \(byte 7\)"):
        read_log(nao, path)


# --- small files, and large ones, which pyarrow reads ----------------------------------------------------------------


@pytest.fixture(params=["small", "pyarrow", "no pyarrow", "not ASCII"])
def reader(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """The ways of reading, which must not differ."""
    if request.param != "small":
        monkeypatch.setattr(csv_numbers, "_LARGE", 0)
    if request.param not in ("small", "pyarrow"):
        monkeypatch.setattr(csv_numbers, "has_pyarrow", lambda: False)
    return request.param


def _prepared(text: str, reader: str) -> str:
    # A space of another script, which a field may have around it.
    return text.replace("\n0.0,", "\n\u20030.0,", 1) if reader == "not ASCII" else text


@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
def test_joints_in_any_order_are_read_to_the_same_numbers(
    nao: nk.NaoModel, shuffled: list[str], tmp_path: Path, reader: str, delimiter: str
) -> None:
    q = nao.random(0, 50)
    q[0, nao.joint_names.index(shuffled[0])] = 0.0
    path = tmp_path / "poses.csv"
    text = _csv(nao, q, [*shuffled, "RHipYawPitch"], delimiter)
    path.write_text(_prepared("\n" + text.replace("\n", "\n\n"), reader), encoding="utf-8")
    log = read_log(nao, path, limits="ignore")
    read, many = log.q, log.many
    assert many
    assert np.array_equal(read, q)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("\n0.1,", "\n9.0,", "line 6, column 1: outside the joint limits: HeadYaw = 9 not in"),
        ("\n0.1,", "\nnan,", "line 6, column 1: HeadYaw is 'nan', expected a finite number"),
        ("\n0.1,", "\n0_1,", "line 6, column 1: HeadYaw is '0_1', expected a finite number"),
        ("\n0.1,", "\n1e400,", "line 6, column 1: HeadYaw is '1e400', expected a finite number"),
        ("\n0.1,", "\n\u0661,", "line 6, column 1: HeadYaw is '\u0661', expected a finite number"),
        ("\n0.1,", "\n,", "line 6, column 1: HeadYaw is '', expected a finite number"),
        ("\n0.1,", "\n-inf,", "line 6, column 1: HeadYaw is '-inf', expected a finite number"),
        ("\n0.1,", "\n0,1,", "line 6: 27 values, the header names 26 joints"),
        ("\n0.1,", '\n"0.1,', "malformed CSV"),
        (",0.2\n", ",0.3\n", "line 6, column 26: LHipYawPitch = 0.2 drives RHipYawPitch, which must then be 0.2"),
    ],
)
def test_what_is_wrong_in_a_table_is_named_with_line_and_column(
    nao: nk.NaoModel, tmp_path: Path, reader: str, old: str, new: str, message: str
) -> None:
    q = np.tile(nao.posture("StandInit"), (4, 1))
    q[2, nao.joint_names.index("LHipYawPitch")], q[2, 0] = 0.2, 0.1
    text = _csv(nao, q, [*nao.joint_names, "RHipYawPitch"]).replace("\n0.0,", "\n\n0.0,")
    assert text.count(old) == 1
    path = tmp_path / "poses.csv"
    path.write_text(_prepared(text.replace(old, new), reader), encoding="utf-8")
    with pytest.raises(BadInputFile) as caught:
        read_log(nao, path)
    assert message in str(caught.value)
