"""Files larger than memory: every kind of source and sink, and bad rows by their lines."""

from __future__ import annotations

import csv
import io
import math
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.feather
import pyarrow.parquet
import pytest
from loops import every_value
from made_up_robots import J, made_up
from scipy.spatial.transform import Rotation

import nao_kin as nk
from nao_kin._core.csv_numbers import line_ends, whole_lines
from nao_kin.errors import BadArgument, BadInputFile, DegreesWarning, MissingExtra, UnknownName
from nao_kin.stream import run, sinks, sinks as csv_text, sources as csv_source, sources as table_sources

ROWS = 60
FEET = ["LLeg", "RLeg"]
SOURCES = ("csv", "npy", "parquet", "arrow", "feather")
SINKS = ("csv", "npy", "parquet", "arrow", "feather")


@pytest.fixture(autouse=True)
def small_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Blocks of a few rows, and parts of two blocks: everything happens at the borders."""
    monkeypatch.setattr(csv_source, "BYTES_AT_ONCE", 3000)
    monkeypatch.setattr(table_sources, "ROWS_AT_ONCE", 7)
    monkeypatch.setattr(run, "_BLOCKS_OF_PART", 2)
    monkeypatch.setattr(run, "_MOST_ENTRIES", 100)
    monkeypatch.setattr(sinks, "_ROWS_OF_GROUP", 50)


@pytest.fixture
def q(nao: nk.NaoModel) -> np.ndarray:
    return nao.random(0, ROWS)


def _table(nao: nk.NaoModel, q: np.ndarray) -> pa.Table:
    """The joints in another order than in q."""
    order = np.random.default_rng(0).permutation(nao.nq)
    return pa.table({nao.joint_names[column]: q[:, column] for column in order})


def _lines(nao: nk.NaoModel, q: np.ndarray) -> list[str]:
    return [",".join(nao.joint_names), *(",".join(map(repr, row)) for row in q.tolist())]


def _write(nao: nk.NaoModel, q: np.ndarray, path: Path) -> Path:
    table = _table(nao, q)
    if path.suffix == ".npy":
        np.save(path, q)
    elif path.suffix == ".parquet":
        pyarrow.parquet.write_table(table, path, row_group_size=25)
    elif path.suffix == ".csv":
        rows = zip(*(column.to_pylist() for column in table.itercolumns()), strict=True)
        path.write_text("\n".join(",".join(map(str, row)) for row in (table.column_names, *rows)) + "\n")
    else:
        pyarrow.feather.write_feather(table, path, chunksize=20)
    return path


def _read(path: Path, frames: int, numbers: int) -> tuple[np.ndarray, list[str], np.ndarray]:
    """Return row and frame of every record, and the poses (rows, frames, numbers), read by other libraries."""
    if path.suffix == ".npy":
        array = np.load(path)
        return np.arange(len(array)), [], array.reshape(len(array), frames, numbers)
    if path.suffix == ".csv":
        with path.open(newline="") as file:
            head, *records = csv.reader(file)
        columns: dict[str, list] = {name: [record[i] for record in records] for i, name in enumerate(head)}
    else:
        read = pyarrow.parquet.read_table if path.suffix == ".parquet" else pyarrow.feather.read_table
        columns = read(path).to_pydict()
    poses = np.array([list(map(float, columns[name])) for name in list(columns)[2:]]).T
    return np.array(list(map(int, columns["row"]))), columns["frame"], poses.reshape(-1, frames, numbers)


def _same(a: np.ndarray, b: np.ndarray) -> bool:
    """Return whether results agree to the tolerance between Pinocchio, which computes few rows, and the kernels."""
    return a.shape == b.shape and np.allclose(a, b, rtol=0.0, atol=1e-12, equal_nan=True)


@pytest.mark.parametrize(("source", "sink"), every_value(SOURCES, SINKS))
def test_poses_of_every_row_go_from_any_kind_of_file_to_any_other(
    nao: nk.NaoModel, q: np.ndarray, tmp_path: Path, source: str, sink: str
) -> None:
    path = tmp_path / f"poses.{sink}"
    result = nk.stream.fk(nao, _write(nao, q, tmp_path / f"q.{source}"), path, frame=FEET)
    rows, frames, poses = _read(path, 2, 16)
    assert _same(poses, nao.fk(q, FEET).reshape(ROWS, 2, 16))
    if sink != "npy":
        assert rows.tolist() == [row for row in range(ROWS) for _ in FEET]
        assert frames == FEET * ROWS
    assert (result.rows_read, result.rows_written, result.bad_rows, result.rows_resumed) == (ROWS, ROWS, 0, 0)
    assert {p.name for p in tmp_path.iterdir()} == {f"q.{source}", f"poses.{sink}"}


@pytest.mark.parametrize(
    ("dtype", "style"),
    every_value([np.float64, np.float32, "float32"], ["matrix", "quaternion", "rpy"]),
)
def test_a_pose_is_written_as_the_numbers_its_columns_name(
    nao: nk.NaoModel, q: np.ndarray, tmp_path: Path, style: str, dtype: object
) -> None:
    path = tmp_path / "poses.parquet"
    source = _write(nao, q, tmp_path / "q.npy")
    result = nk.stream.fk(nao, source, path, frame="LArm", as_=style, dtype=dtype, reference="RLeg")
    table = pyarrow.parquet.read_table(path)
    assert table.column_names == ["row", "frame", *result.columns]
    assert {str(field.type) for field in table.schema} >= {"float" if np.dtype(dtype) == np.float32 else "double"}
    got = {name: table[name].to_numpy() for name in result.columns}
    T = nao.fk(q, "LArm", reference="RLeg")
    tolerance = 1e-14 if np.dtype(dtype) == np.float64 else 1e-6
    if style == "matrix":
        for i in range(4):
            for j in range(4):
                assert np.allclose(got[f"t{i + 1}{j + 1}"], T[:, i, j], rtol=0.0, atol=tolerance)
        return
    assert np.allclose(np.stack([got[axis] for axis in "xyz"], -1), T[:, :3, 3], rtol=0.0, atol=tolerance)
    if style == "quaternion":
        R = Rotation.from_quat(np.stack([got[f"r{i}"] for i in (1, 2, 3, 0)], -1))
    else:
        R = Rotation.from_euler("xyz", np.stack([got[name] for name in ("roll", "pitch", "yaw")], -1))
    assert np.allclose(R.as_matrix(), T[:, :3, :3], rtol=0.0, atol=10 * tolerance)


@pytest.mark.parametrize(
    ("frames", "style", "shape"),
    [
        ("LArm", "matrix", (4, 4)),
        (["LArm"], "matrix", (1, 4, 4)),
        (FEET, "quaternion", (2, 7)),
        ("LArm", "rpy", (6,)),
        (None, "rpy", None),
    ],
)
def test_an_array_of_poses_has_the_shape_that_fk_gives(
    nao: nk.NaoModel, q: np.ndarray, tmp_path: Path, frames: object, style: str, shape: tuple[int, ...] | None
) -> None:
    nk.stream.fk(nao, _write(nao, q, tmp_path / "q.npy"), tmp_path / "poses.npy", frame=frames, as_=style)
    assert np.load(tmp_path / "poses.npy").shape == (ROWS, *(shape or (len(nao.link_names), 6)))


def test_degrees_are_for_turning_joints_and_for_the_angles_of_poses(
    nao: nk.NaoModel, q: np.ndarray, tmp_path: Path
) -> None:
    turning = np.array([unit == "rad" for unit in nao.joint_units])
    for ending in ("npy", "csv"):
        source = _write(nao, np.where(turning, np.degrees(q), q), tmp_path / f"q.{ending}")
        for written in (False, True):
            options = {"as_": "rpy", "degrees": True, "poses_in_degrees": written, "overwrite": True}
            result = nk.stream.fk(nao, source, tmp_path / "poses.npy", frame="LArm", **options)
            angles = Rotation.from_euler("xyz", np.load(tmp_path / "poses.npy")[:, 3:], degrees=written)
            assert np.allclose(angles.as_matrix(), nao.fk(q, "LArm")[:, :3, :3], atol=1e-13)
            names = ("roll", "pitch", "yaw")
            assert result.columns[3:] == tuple(f"{name}{'_deg' * written}" for name in names)
            assert result.notes == ()


def test_degrees_leave_lengths_alone(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("turn"), J("slide", kind="prismatic"))
    np.save(tmp_path / "q.npy", [[90.0, 0.5]])
    nk.stream.fk(robot, tmp_path / "q.npy", tmp_path / "poses.npy", frame="slide_l", degrees=True)
    assert _same(np.load(tmp_path / "poses.npy")[0], robot.fk([math.radians(90.0), 0.5], "slide_l"))


def test_an_existing_output_is_replaced_only_if_asked(nao: nk.NaoModel, q: np.ndarray, tmp_path: Path) -> None:
    source, sink = _write(nao, q, tmp_path / "q.npy"), tmp_path / "poses.npy"
    sink.write_bytes(b"old")
    with pytest.raises(BadArgument, match=r"poses\.npy already exists; overwrite=True \(--force\) replaces it"):
        nk.stream.fk(nao, source, sink, frame="Head")
    assert sink.read_bytes() == b"old"
    nk.stream.fk(nao, source, sink, frame="Head", overwrite=True)
    assert np.load(sink).shape == (len(q), 4, 4)


def test_limits_are_raised_clamped_or_ignored(nao: nk.NaoModel, q: np.ndarray, tmp_path: Path) -> None:
    q[17, 0] = 3.0
    source = _write(nao, q, tmp_path / "q.npy")
    out = tmp_path / "poses.npy"
    with pytest.raises(BadInputFile, match=r"q.npy: row 17: outside the joint limits: HeadYaw = 3 not in"):
        nk.stream.fk(nao, source, out, frame="Head")
    assert not out.exists()
    nk.stream.fk(nao, source, out, frame="Head", limits="clamp")
    assert _same(np.load(out), nao.fk(nao.clamp(q), "Head"))
    nk.stream.fk(nao, source, out, frame="Head", limits="ignore", overwrite=True)
    assert _same(np.load(out), nao.fk(q, "Head"))


def test_degrees_by_mistake_are_warned_of_once(
    nao: nk.NaoModel, q: np.ndarray, tmp_path: Path, recwarn: pytest.WarningsRecorder
) -> None:
    nk.stream.fk(nao, _write(nao, q * 60, tmp_path / "q.npy"), tmp_path / "poses.npy", frame="Head", limits="ignore")
    assert [warning.category for warning in recwarn] == [DegreesWarning]


def test_naoqis_26_names_are_taken_when_the_hips_agree(nao: nk.NaoModel, q: np.ndarray, tmp_path: Path) -> None:
    table = _table(nao, q).append_column("RHipYawPitch", pa.array(q[:, nao.joint_names.index("LHipYawPitch")]))
    only_right = table.drop_columns(["LHipYawPitch"])
    for columns in (table, only_right):
        pyarrow.parquet.write_table(columns, tmp_path / "q.parquet")
        nk.stream.fk(nao, tmp_path / "q.parquet", tmp_path / "poses.npy", frame=FEET, overwrite=True)
        assert _same(np.load(tmp_path / "poses.npy"), nao.fk(q, FEET))
    apart = table.set_column(
        table.num_columns - 1, "RHipYawPitch", pa.array(np.where(np.arange(ROWS) == 31, 0.0, table["RHipYawPitch"]))
    )
    pyarrow.parquet.write_table(apart, tmp_path / "q.parquet")
    with pytest.raises(BadInputFile, match="row 31: LHipYawPitch = .* drives RHipYawPitch, which must then be"):
        nk.stream.fk(nao, tmp_path / "q.parquet", tmp_path / "poses.npy", frame=FEET, overwrite=True)


def test_followers_with_a_ratio_and_an_offset_stand_for_their_driver(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("a"), J("b", follows=("a", -2.0, 0.5)), J("c"), J("d", follows=("c", 0.5, 0.0)))
    values = {"b": [0.1, 0.3], "d": [0.2, -0.1], "c": [0.4, -0.2]}
    pyarrow.parquet.write_table(pa.table(values), tmp_path / "q.parquet")
    nk.stream.fk(robot, tmp_path / "q.parquet", tmp_path / "poses.npy", frame="d_l")
    expected = robot.configuration({name: np.array(value) for name, value in values.items()})
    assert _same(np.load(tmp_path / "poses.npy"), robot.fk(expected, "d_l"))


def test_a_floating_base_is_read_from_arrays_of_q(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("a"), J("b", axis=(0, 1, 0)), base="floating")
    q = robot.random(0, 9)
    q[:, :3] = np.random.default_rng(0).normal(size=(9, 3))
    q[:, 3:7] = Rotation.random(9, rng=0).as_quat()
    np.save(tmp_path / "q.npy", q)
    nk.stream.fk(robot, tmp_path / "q.npy", tmp_path / "poses.npy", frame="b_l")
    assert _same(np.load(tmp_path / "poses.npy"), robot.fk(q, "b_l"))
    q[4, 3:7] *= 1.1
    q[6, 2] = math.inf
    np.save(tmp_path / "q.npy", q)
    result = nk.stream.fk(
        robot, tmp_path / "q.npy", tmp_path / "poses.npy", frame="b_l", on_error="skip", overwrite=True
    )
    assert [str(bad) for bad in result.first_bad_rows] == [
        "row 4: the base's quaternion has norm 1.1, expected 1",
        "row 6: number 3 of the base is inf, expected a finite number",
    ]


# --- bad rows -----------------------------------------------------------------------------------------------------


def _spoil(line: str, how: str) -> str:
    _, _, rest = line.partition(",")
    return {
        "long": f"{line},1.0",
        "short": rest,
        "text": f"zero,{rest}",
        "nan": f"nan,{rest}",
        "huge": f"1e400,{rest}",
        "limits": f"9,{rest}",
        "quote": f'0"1,{rest}',
        "open quote": f'"{line}',
        "bytes": f"\udcff,{rest}",
    }[how]


REASONS = {
    "long": ", line {}: 26 values, the header names 25 joints",
    "short": ", line {}: 24 values, the header names 25 joints",
    "text": ", line {}, column 1: HeadYaw is 'zero', expected a finite number",
    "nan": ", line {}, column 1: HeadYaw is 'nan', expected a finite number",
    "huge": ", line {}, column 1: HeadYaw is '1e400', expected a finite number",
    "limits": ", line {}, column 1: outside the joint limits: HeadYaw = 9 not in [-2.08567, 2.08567] rad",
    "quote": ", line {}, column 1: HeadYaw is '0\"1', expected a finite number",
    "open quote": ", line {}: malformed CSV: ",
    "bytes": ", line {}, column 1: HeadYaw is '\ufffd', expected a finite number",
}


@pytest.mark.parametrize(
    ("how", "policy"), [*((how, "stop") for how in REASONS), *every_value(REASONS, ["skip", "nan"])]
)
def test_a_bad_row_of_a_csv_file_is_named_by_its_line_and_costs_no_good_one(
    nao: nk.NaoModel, q: np.ndarray, tmp_path: Path, how: str, policy: str
) -> None:
    source, sink = tmp_path / "q.csv", tmp_path / "poses.csv"
    lines = _lines(nao, q)
    lines[38] = _spoil(lines[38], how)
    source.write_bytes("\n".join(lines).encode("utf-8", "surrogateescape"))
    if policy == "stop":
        with pytest.raises(BadInputFile) as caught:
            nk.stream.fk(nao, source, sink, frame=FEET)
        assert str(caught.value).startswith(f"{source}{REASONS[how].format(39)}")
        assert [path.name for path in tmp_path.iterdir()] == ["q.csv"]
        return
    result = nk.stream.fk(nao, source, sink, frame=FEET, on_error=policy)
    assert (result.rows_read, result.bad_rows) == (ROWS, 1)
    bad = result.first_bad_rows[0]
    assert (bad.row, bad.line) == (37, 39)
    assert f", {bad}".startswith(REASONS[how].format(39))
    rows, _, poses = _read(sink, 2, 16)
    expected = nao.fk(q, FEET).reshape(ROWS, 2, 16)
    if policy == "skip":
        assert rows[::2].tolist() == [row for row in range(ROWS) if row != 37]
        assert _same(poses, np.delete(expected, 37, axis=0))
    else:
        expected[37] = np.nan
        assert _same(poses, expected)


@pytest.mark.parametrize(("end", "delimiter"), every_value(["\n", "\r\n", "\r"], [",", ";", "\t"]))
def test_blank_lines_quotes_and_spaces_do_no_harm_and_count_as_lines(
    nao: nk.NaoModel, q: np.ndarray, tmp_path: Path, end: str, delimiter: str
) -> None:
    head, *rows = (line.replace(",", delimiter) for line in _lines(nao, q))
    lines = ["", head, ""]
    for index, row in enumerate(rows):
        if index % 5 == 0:
            lines += ["", " ", delimiter * 24]
        if index % 3 == 0:
            row = delimiter.join(f'"{field}"' for field in row.split(delimiter))
        if index % 7 == 0:
            row = row.replace(delimiter, f" {delimiter}  ") if index % 3 else row
        if index == 44:  # a record of two lines
            first, _, rest = row.partition(delimiter)
            row = f'"{first}{end}"{delimiter}{rest}'
        if index == 50:
            row = "x" + row
            bad_line = sum(line.count(end) + 1 for line in lines) + 1
        lines.append(row)
    source = tmp_path / "q.csv"
    source.write_bytes(b"\xef\xbb\xbf" + end.join(lines).encode())
    result = nk.stream.fk(nao, source, tmp_path / "poses.npy", frame=FEET, on_error="skip")
    assert [(bad.row, bad.line) for bad in result.first_bad_rows] == [(50, bad_line)]
    assert _same(np.load(tmp_path / "poses.npy"), nao.fk(np.delete(q, 50, axis=0), FEET))


def test_records_of_several_lines_may_lie_across_the_border_of_blocks(
    nao: nk.NaoModel, q: np.ndarray, tmp_path: Path
) -> None:
    head, *rows = _lines(nao, q)
    fields = [row.split(",") for row in rows]
    rows = [",".join([f'"{first}\n"', f'"\r\n{second}"', *others]) for first, second, *others in fields]
    rows[55] = rows[55] + ",1"
    (tmp_path / "q.csv").write_bytes("\n".join([head, *rows]).encode())
    result = nk.stream.fk(nao, tmp_path / "q.csv", tmp_path / "poses.npy", frame=FEET, on_error="skip")
    assert [str(bad) for bad in result.first_bad_rows] == [f"line {1 + 3 * 56}: 26 values, the header names 25 joints"]
    assert _same(np.load(tmp_path / "poses.npy"), nao.fk(np.delete(q, 55, axis=0), FEET))


def test_blocks_end_where_a_line_does() -> None:
    for block, used in ((b"1,2\n3,", 4), (b"1,2\r3,", 4), (b"1,2\r", 0), (b"1\r2\r", 2), (b"1\r\n2", 3), (b"1,2", 0)):
        assert whole_lines(block) == used
    assert line_ends(b"1\r2\n3\r\n4\r\r\n\n5") == 6


def test_groups_of_a_parquet_file_have_one_length(nao: nk.NaoModel, q: np.ndarray, tmp_path: Path) -> None:
    nk.stream.fk(nao, _write(nao, q, tmp_path / "q.npy"), tmp_path / "poses.parquet", as_="rpy")
    metadata = pyarrow.parquet.ParquetFile(tmp_path / "poses.parquet").metadata
    lengths = [metadata.row_group(index).num_rows for index in range(metadata.num_row_groups)]
    assert set(lengths[:-1]) == {50}
    assert sum(lengths) == ROWS * len(nao.link_names)


def test_every_bad_row_is_counted_and_the_first_are_listed(nao: nk.NaoModel, q: np.ndarray, tmp_path: Path) -> None:
    lines = _lines(nao, q)
    bad = {row: ("text", "long", "limits")[row % 3] for row in range(1, ROWS, 2)}
    for row, how in bad.items():
        lines[row + 1] = _spoil(lines[row + 1], how)
    source = tmp_path / "q.csv"
    source.write_text("\n".join(lines) + "\n")
    result = nk.stream.fk(nao, source, tmp_path / "poses.parquet", frame=FEET, on_error="skip")
    assert (result.bad_rows, result.rows_written, len(result.first_bad_rows)) == (len(bad), ROWS - len(bad), 20)
    assert [(b.row, b.line) for b in result.first_bad_rows] == [(row, row + 2) for row in list(bad)[:20]]
    assert pyarrow.parquet.read_table(tmp_path / "poses.parquet")["row"].to_pylist()[::2] == list(range(0, ROWS, 2))


@pytest.mark.parametrize("sink", SINKS)
def test_a_file_of_bad_rows_alone_gives_an_empty_one(
    nao: nk.NaoModel, q: np.ndarray, tmp_path: Path, sink: str
) -> None:
    np.save(tmp_path / "q.npy", q + np.nan)
    result = nk.stream.fk(nao, tmp_path / "q.npy", tmp_path / f"poses.{sink}", frame=FEET, as_="rpy", on_error="skip")
    assert (result.bad_rows, result.rows_written, len(result.first_bad_rows)) == (ROWS, 0, 20)
    assert _read(tmp_path / f"poses.{sink}", 2, 6)[2].size == 0


def test_an_open_quote_does_not_swallow_the_rest_of_the_file(nao: nk.NaoModel, tmp_path: Path) -> None:
    q = nao.random(0, 900)  # more text than a field may hold
    lines = _lines(nao, q)
    lines[300] = '"' + lines[300]
    (tmp_path / "q.csv").write_text("\n".join(lines))
    result = nk.stream.fk(nao, tmp_path / "q.csv", tmp_path / "poses.npy", frame="Head", on_error="skip")
    assert [(bad.row, bad.line) for bad in result.first_bad_rows] == [(299, 301)]
    assert _same(np.load(tmp_path / "poses.npy"), nao.fk(np.delete(q, 299, axis=0), "Head"))


@pytest.mark.parametrize("ending", ["npy", "parquet", "arrow"])
def test_a_bad_row_of_another_file_is_named_by_its_number(
    nao: nk.NaoModel, q: np.ndarray, tmp_path: Path, ending: str
) -> None:
    q[20, 3], q[41, 0] = np.nan, 9.0
    source = _write(nao, q, tmp_path / f"q.{ending}")
    joint = nao.joint_names[3]
    with pytest.raises(BadInputFile, match=f"row 20: {joint} is nan, expected a finite number"):
        nk.stream.fk(nao, source, tmp_path / "poses.npy", frame="Head")
    result = nk.stream.fk(nao, source, tmp_path / "poses.npy", frame="Head", on_error="nan")
    assert [(bad.row, bad.line, bad.column) for bad in result.first_bad_rows] == [(20, 0, 0), (41, 0, 0)]
    poses = np.load(tmp_path / "poses.npy")
    assert np.isnan(poses[[20, 41]]).all()
    assert np.isfinite(np.delete(poses, [20, 41], axis=0)).all()


def test_a_null_is_a_bad_row_and_whole_numbers_are_numbers(nao: nk.NaoModel, tmp_path: Path) -> None:
    columns = {name: pa.array([0, 0, 0], pa.int32()) for name in nao.joint_names}
    columns["LHand"] = pa.array([0.5, None, 1.0], pa.float32())
    pyarrow.parquet.write_table(pa.table(columns), tmp_path / "q.parquet")
    result = nk.stream.fk(
        nao, tmp_path / "q.parquet", tmp_path / "poses.npy", frame="Head", on_error="skip", limits="ignore"
    )
    assert [str(bad) for bad in result.first_bad_rows] == ["row 1: LHand is null, expected a finite number"]
    assert result.rows_written == 2


# --- bad files ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda t: "", "empty; expected joint names"),
        (lambda t: "\n \n", "empty; expected joint names"),
        (lambda t: ",,\n \n", "empty; expected joint names"),
        (lambda t: t.split("\n")[0], "a header and no configurations"),
        (lambda t: t.split("\n")[0] + "\n\n , \n", "line 3: 2 values, the header names 25 joints|no configurations"),
        (lambda t: t.replace("HeadYaw", "HeadYam"), r"line 1, column 1: unknown joint 'HeadYam' \(nearest: HeadYaw"),
        (lambda t: t.replace("HeadPitch", "HeadYaw"), "line 1, column 2: joint 'HeadYaw' is given twice"),
        (lambda t: t.replace("HeadYaw,", ""), "line 1: missing joints: HeadYaw"),
        (lambda t: '"' + t, "malformed CSV"),
    ],
)
def test_a_file_whose_header_is_wrong_is_refused(
    nao: nk.NaoModel, q: np.ndarray, tmp_path: Path, change: Callable[[str], str], message: str
) -> None:
    (tmp_path / "q.csv").write_text(change("\n".join(_lines(nao, q[:3]))))
    with pytest.raises(BadInputFile, match=message):
        nk.stream.fk(nao, tmp_path / "q.csv", tmp_path / "poses.npy", frame="Head")
    with pytest.raises(BadInputFile, match=message):
        nk.stream.read_log(nao, tmp_path / "q.csv")
    assert [path.name for path in tmp_path.iterdir()] == ["q.csv"]


def _save(name: str, array: object, *, pickle: bool = False) -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        np.save(folder / name, array, allow_pickle=pickle)
        return folder / name

    return write


# NumPy reads a header with the tokenizer of Python, whose errors are no ValueErrors.
_BROKEN_NPY = b"\x93NUMPY\x01\x00v\x00((((" + b" " * 113 + b"\n" + bytes(25 * 8)


def _text(name: str, text: str | bytes) -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        (folder / name).write_bytes(text if isinstance(text, bytes) else text.encode())
        return folder / name

    return write


def _columns(**columns: object) -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        names = [name for name in nk.load_nao().joint_names if name not in columns]
        table = pa.table({**{name: [0.0] for name in names}, **columns})
        pyarrow.parquet.write_table(table, folder / "q.parquet")
        return folder / "q.parquet"

    return write


@pytest.mark.parametrize(
    ("write", "message"),
    [
        (_save("q.npy", np.zeros((3, 24))), r"an array of shape \(3, 24\), expected \(N, 25\)"),
        (_save("q.npy", np.zeros(25)), r"an array of shape \(25,\), expected \(N, 25\)"),
        (_save("q.npy", np.zeros((3, 25), complex)), "an array of complex128, expected real numbers"),
        (_save("q.npy", np.full((3, 25), None), pickle=True), "not a whole NumPy array"),
        (_text("q.npy", "HeadYaw"), "not a whole NumPy array"),
        (_text("q.npy", _BROKEN_NPY), "not a whole NumPy array: .*EOF in multi-line statement"),
        (_text("q.npy", ""), "not a whole NumPy array"),
        (_text("q.npy", "PK\3\4 no archive"), "not a whole NumPy array: the magic string"),
        (_text("q.parquet", "HeadYaw"), "not a Parquet file"),
        (_text("q.arrow", "HeadYaw"), "not an Arrow IPC file"),
        (_text("q.json", "{}"), "JSON is read whole"),
        (_text("q.csv", "\0" * 100), "unknown joint|NUL|not UTF-8"),
        (_columns(battery=[0.0]), r"unknown joint .battery. .*ignore_other=True \(--ignore-other\) leaves it out"),
        (_columns(HeadYaw=["0.0"]), "column 'HeadYaw' holds string, expected numbers"),
        (_columns(HeadYaw=[True]), "column 'HeadYaw' holds bool, expected numbers"),
        (lambda folder: folder / "none.csv", "none.csv: cannot be read: No such file"),
        (lambda folder: folder / "none.arrow", "none.arrow: cannot be read: "),
        (lambda folder: folder, "cannot be read: Is a directory"),
    ],
)
def test_what_is_no_table_of_joint_values_is_refused(
    nao: nk.NaoModel, tmp_path: Path, write: Callable[[Path], Path], message: str
) -> None:
    source = write(tmp_path)
    before = {path.name for path in tmp_path.iterdir()}
    with pytest.raises(BadInputFile, match=message) as caught:
        nk.stream.fk(nao, source, tmp_path / "poses.npy", frame="Head")
    assert "\n" not in str(caught.value)
    assert {path.name for path in tmp_path.iterdir()} == before


def test_a_truncated_file_is_refused(nao: nk.NaoModel, q: np.ndarray, tmp_path: Path) -> None:
    for ending in ("npy", "parquet", "arrow"):
        source = _write(nao, q, tmp_path / f"q.{ending}")
        source.write_bytes(source.read_bytes()[:-2000])
        with pytest.raises(BadInputFile, match="not a"):
            nk.stream.fk(nao, source, tmp_path / "poses.npy", frame="Head")


def test_no_rows_give_no_poses_where_a_file_may_be_empty(nao: nk.NaoModel, tmp_path: Path) -> None:
    for ending in ("npy", "parquet", "arrow"):
        source = _write(nao, np.zeros((0, 25)), tmp_path / f"q.{ending}")
        for sink in SINKS:
            result = nk.stream.fk(nao, source, tmp_path / f"poses.{sink}", frame=FEET, as_="rpy", overwrite=True)
            assert (result.rows_read, result.rows_written) == (0, 0)
            assert _read(tmp_path / f"poses.{sink}", 2, 6)[2].size == 0


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"frame": "LHnd"}, UnknownName, "unknown frame 'LHnd'"),
        ({"frame": []}, BadArgument, "no frames"),
        ({"reference": "LHnd"}, UnknownName, "unknown frame 'LHnd'"),
        ({"as_": "euler"}, UnknownName, "unknown form of a pose 'euler'"),
        ({"dtype": "float16"}, BadArgument, "dtype must be float64 or float32, got 'float16'"),
        ({"limits": "rais"}, UnknownName, "unknown limits policy 'rais' .valid: enforce"),
        ({"on_error": "skipp"}, UnknownName, "unknown policy for bad rows 'skipp' .nearest: skip"),
        ({"sink": "poses.json"}, BadArgument, "the ending names the format; expected .parquet"),
        ({"sink": "none/poses.csv"}, BadArgument, "cannot write none/poses.csv: No such file or directory"),
        ({"sink": ""}, BadArgument, "sink must be the name of a file, got ''"),
        ({"sink": "q.npy"}, BadArgument, "q.npy is the source too"),
    ],
)
def test_arguments_that_make_no_sense_are_refused(
    nao: nk.NaoModel,
    q: np.ndarray,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    arguments: dict,
    error: type[Exception],
    message: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    _write(nao, q, tmp_path / "q.npy")
    given = {"source": "q.npy", "frame": "Head", "sink": "poses.npy"} | arguments
    with pytest.raises(error, match=message):
        nk.stream.fk(nao, **given)
    assert [path.name for path in tmp_path.iterdir()] == ["q.npy"]


# --- without pyarrow ----------------------------------------------------------------------------------------------


@pytest.fixture
def no_pyarrow(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [name for name in sys.modules if name.partition(".")[0] == "pyarrow"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    for module in (csv_text, csv_source):
        monkeypatch.setattr(module, "has_pyarrow", lambda: False)


def test_arrays_need_no_extra_and_the_others_name_it(
    nao: nk.NaoModel, q: np.ndarray, tmp_path: Path, no_pyarrow: None
) -> None:
    np.save(tmp_path / "q.npy", q)
    nk.stream.fk(nao, tmp_path / "q.npy", tmp_path / "poses.npy", frame=FEET)
    assert _same(np.load(tmp_path / "poses.npy"), nao.fk(q, FEET))
    nk.stream.fk(nao, tmp_path / "q.npy", tmp_path / "poses.csv", frame=FEET)
    assert _same(_read(tmp_path / "poses.csv", 2, 16)[2], nao.fk(q, FEET).reshape(ROWS, 2, 16))
    for ending in ("parquet", "arrow", "feather"):
        with pytest.raises(MissingExtra, match=rf"writing .*poses\.{ending} needs .* 'nao-kin\[arrow\]'"):
            nk.stream.fk(nao, tmp_path / "q.npy", tmp_path / f"poses.{ending}", frame=FEET)
    for ending in ("parquet", "arrow"):
        (tmp_path / f"q.{ending}").write_text("something")
        with pytest.raises(MissingExtra, match=rf"reading .*q\.{ending} as a stream needs .* 'nao-kin\[arrow\]'"):
            nk.stream.fk(nao, tmp_path / f"q.{ending}", tmp_path / "poses2.npy", frame=FEET)
    assert not (tmp_path / "poses2.npy").exists()


def test_a_csv_file_needs_pyarrow_only_if_it_is_large(
    nao: nk.NaoModel, q: np.ndarray, tmp_path: Path, no_pyarrow: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    source, sink = _write(nao, q, tmp_path / "q.csv"), tmp_path / "poses.csv"
    nk.stream.fk(nao, source, sink, frame=FEET)
    assert _same(_read(sink, 2, 16)[2], nao.fk(q, FEET).reshape(ROWS, 2, 16))
    monkeypatch.setattr(csv_source, "_MOST_WITHOUT_PYARROW", source.stat().st_size - 1)
    with pytest.raises(MissingExtra, match=r"reading .*q\.csv as a stream needs .* CSV files of up to 100 MB"):
        nk.stream.fk(nao, source, tmp_path / "large.csv", frame=FEET)


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_lines_are_the_same_whoever_writes_them(dtype: type, monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(0)
    special = [0.0, -0.0, 1.0, -3.0, np.nan, np.inf, 1e-4, 9.999e-5, 1e15, 1e16, 1e22, 5e-324, 99.99999, 100.5, 0.1]
    numbers = np.concatenate(
        [rng.normal(size=4000), rng.normal(size=2000) * 10.0 ** rng.integers(-20, 20, 2000), special]
    )
    numbers = numbers[: len(numbers) // 6 * 6].astype(dtype).reshape(-1, 1, 6).repeat(2, axis=1)
    frames = ["LLeg", 'a "name", with both']
    rows = np.arange(len(numbers)) + 10**10
    monkeypatch.setattr(csv_text, "_FEW", 0)
    quickly = csv_text.PoseColumns.csv_lines(rows, frames, numbers)
    monkeypatch.setattr(csv_text, "_FEW", 10**9)
    assert quickly == csv_text.PoseColumns.csv_lines(rows, frames, numbers)
    read = list(csv.reader(quickly.decode().splitlines()))
    assert [record[:2] for record in read[:3]] == [
        [str(10**10), frames[0]],
        [str(10**10), frames[1]],
        [str(10**10 + 1), frames[0]],
    ]
    assert np.array_equal(np.array([record[2:] for record in read], dtype), numbers.reshape(-1, 6), equal_nan=True)


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_progress_is_shown_on_a_terminal_if_asked(
    nao: nk.NaoModel, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    q = nk.stream.Configurations(nao.random(0, 10))
    shown = {}
    for asked in (True, False):
        monkeypatch.setattr(sys, "stderr", Terminal())
        nk.stream.fk(nao, q, tmp_path / f"{asked}.npy", frame="LArm", progress=asked)
        shown[asked] = sys.stderr.getvalue()
    assert "forward kinematics" in shown[True]
    assert shown[False] == ""
    assert (tmp_path / "True.npy").read_bytes() == (tmp_path / "False.npy").read_bytes()
