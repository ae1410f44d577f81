"""Logs of joint values as people have them: times, other columns, units, keys of ALMemory, packed, and in parts."""

from __future__ import annotations

import csv
import gzip
import io
import json
import re
from collections.abc import Callable
from contextlib import closing
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.feather
import pyarrow.parquet
import pytest
from loops import every_value
from made_up_robots import J, made_up

import nao_kin as nk
from nao_kin.cli.app import run
from nao_kin.errors import BadArgument, BadInputFile
from nao_kin.stream import run as run_module, sources as csv_source
from nao_kin.stream.tables import TableOptions, read_log

ROWS = 40
TIMES = np.round(0.02 * np.arange(ROWS) + 0.01, 6)
Table = dict[str, np.ndarray]


@pytest.fixture
def q(nao: nk.NaoModel) -> np.ndarray:
    return nao.random(0, ROWS)


def _table(nao: nk.NaoModel, q: np.ndarray) -> Table:
    return dict(zip(nao.joint_names, q.T, strict=True))


def _text(table: Table, delimiter: str = ",", mark: str = ".") -> str:
    rows = zip(*(column.tolist() for column in table.values()), strict=True)
    lines = (delimiter.join(str(value).replace(".", mark) for value in row) for row in rows)
    return "\n".join([delimiter.join(table), *lines]) + "\n"


def _of_devices(table: Table) -> Table:
    return {f"Device/SubDeviceList/{name}/Position/Sensor/Value": column for name, column in table.items()}


def _with_units(table: Table) -> Table:
    units = {name: "s" if name == "time" else "%" if name.endswith("Hand") else "deg" for name in table}
    factors = {"s": 1.0, "%": 100.0, "deg": np.degrees(1.0)}
    return {f"{name} [{units[name]}]": factors[units[name]] * column for name, column in table.items()}


FORMS: dict[str, Callable[[Table], str]] = {
    "units": lambda table: _text(_with_units(table)),
    "keys of ALMemory": lambda table: _text(_of_devices(table)),
    "an index": lambda table: _text({"": np.arange(ROWS), **table}),
    "an index read and written by pandas": lambda table: _text({"Unnamed: 0": np.arange(ROWS), **table}),
    "a comment": lambda table: f"# recorded on a robot, in the lab\n\n{_text(table)}",
    "a header in a comment": lambda table: f"# of NumPy\n# {_text(table)}",
    "decimal commas": lambda table: _text(table, ";", ","),
    "tabs and decimal commas": lambda table: _text(table, "\t", ","),
    "a byte order mark": lambda table: "\ufeff" + _text(table),
}


@pytest.fixture
def small_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(csv_source, "BYTES_AT_ONCE", 4000)
    monkeypatch.setattr(run_module, "_BLOCKS_OF_PART", 2)


@pytest.mark.parametrize(("packed", "form"), every_value([False, True], FORMS))
def test_a_log_is_read_in_every_form_with_its_times(
    nao: nk.NaoModel, q: np.ndarray, tmp_path: Path, small_blocks: None, form: str, packed: bool
) -> None:
    table = _table(nao, q)
    for timed in (False, True):
        text = FORMS[form]({"time": TIMES, **table} if timed and form != "an index" else table)
        if timed and form == "an index":
            text = FORMS[form]({**table, "stamp": TIMES})
        path = tmp_path / ("log.csv.gz" if packed else "log.csv")
        path.write_bytes(gzip.compress(text.encode()) if packed else text.encode())
        log = read_log(nao, path)
        assert np.allclose(log.q, q, rtol=0, atol=1e-12)
        assert np.array_equal(read_log(nao, path).q, log.q)
        result = nk.stream.fk(nao, path, tmp_path / "poses.parquet", frame=["LArm", "RLeg"], overwrite=True)
        got = pyarrow.parquet.read_table(tmp_path / "poses.parquet").to_pydict()
        poses = np.stack([got[name] for name in result.columns], axis=-1).reshape(ROWS, 2, 4, 4)
        assert np.allclose(poses, nao.fk(q, ["LArm", "RLeg"]), rtol=0, atol=1e-12)
        if timed:
            assert np.array_equal(log.times, TIMES)
            assert np.array_equal(got["time"][::2], TIMES)
        elif not timed:
            assert log.times is None
            assert "time" not in got


@pytest.mark.parametrize(
    ("ending", "name"), every_value(["csv", "parquet", "feather"], ["time", "Timestamp", "t", "stamp"])
)
def test_times_stand_beside_the_rows_of_every_output(
    nao: nk.NaoModel, q: np.ndarray, tmp_path: Path, ending: str, name: str
) -> None:
    table, source = {name: TIMES, **_table(nao, q)}, tmp_path / f"log.{ending}"
    if ending == "csv":
        source.write_text(_text(table))
    elif ending == "parquet":
        pyarrow.parquet.write_table(pa.table(table), source, row_group_size=7)
    else:
        pyarrow.feather.write_feather(pa.table(table), source, chunksize=7)
    for kind in ("csv", "parquet", "arrow"):
        sink = tmp_path / f"poses.{kind}"
        nk.stream.fk(nao, source, sink, frame=["LArm", "RArm"], as_="rpy")
        if kind == "csv":
            header, *records = csv.reader(io.StringIO(sink.read_text()))
            columns: dict = dict(zip(header, zip(*records, strict=True), strict=True))
        else:
            read = pyarrow.parquet.read_table if kind == "parquet" else pyarrow.feather.read_table
            columns = read(sink).to_pydict()
        assert list(columns)[:3] == ["row", "time", "frame"]
        assert np.array_equal(np.array(columns["time"], float), np.repeat(TIMES, 2))
    nk.stream.fk(nao, source, tmp_path / "poses.npy", frame=["LArm", "RArm"])
    assert np.load(tmp_path / "poses.npy").shape == (ROWS, 2, 4, 4)


@pytest.mark.parametrize(
    ("heading", "factor", "start", "note"),
    [
        ("time", 1.0, 0.0, ""),
        ("time", 1.0, 1.7e9, ""),
        ("stamp", 1e3, 1.7e9, "ms"),
        ("timestamp", 1e6, 1.7e9, "us"),
        ("t", 1e9, 1.7e9, "ns"),
        ("time [ms]", 1e3, 0.0, ""),
        ("stamp [s]", 1.0, 1.7e12, ""),
    ],
)
def test_times_are_seconds_or_what_their_unit_or_size_says(
    nao: nk.NaoModel, q: np.ndarray, tmp_path: Path, heading: str, factor: float, start: float, note: str
) -> None:
    written = np.rint((TIMES + start) * factor) if factor > 1.0 else TIMES + start
    written[0] = 0.0  # the first message of a log is often without a stamp
    (tmp_path / "log.csv").write_text(_text({heading: written, **_table(nao, q)}))
    expected = written / factor
    log = read_log(nao, tmp_path / "log.csv")
    assert np.array_equal(log.times, expected)
    result = nk.stream.fk(nao, tmp_path / "log.csv", tmp_path / "poses.parquet", frame="Head")
    assert np.array_equal(pyarrow.parquet.read_table(tmp_path / "poses.parquet")["time"].to_numpy(), expected)
    assert log.notes == result.notes
    assert [re.search(r"taken as (\w+) since 1970", line)[1] for line in log.notes] == [note] * bool(note)


@pytest.mark.parametrize(
    ("heading", "step", "unit", "noted"),
    [
        ("time", 0.02, "s", False),
        ("time", 2.0, "s", True),
        ("time", 10.0, "ms", True),
        ("time", 2e4, "us", True),
        ("time", 1e7, "ns", True),
        ("time [ns]", 1e7, "ns", False),
    ],
)
def test_the_step_of_times_shows_their_unit_and_a_guess_is_noted(
    nao: nk.NaoModel, q: np.ndarray, tmp_path: Path, heading: str, step: float, unit: str, noted: bool
) -> None:
    source, sink = tmp_path / "log.csv", tmp_path / "poses.csv"
    times = step * np.arange(ROWS)
    source.write_text(_text({heading: times, **_table(nao, q)}))
    log = read_log(nao, source)
    result = nk.stream.fk(nao, source, sink, frame="Head", overwrite=True)
    assert np.array_equal(log.times, times / {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}[unit])
    assert log.notes == result.notes
    assert [re.search(r"taken as (\w+)", note)[1] for note in log.notes] == [unit] * noted


@pytest.mark.parametrize("kind", ["csv", "parquet"])
def test_the_first_rows_determine_the_unit_of_times_however_much_is_read_at_once(
    nao: nk.NaoModel, q: np.ndarray, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str
) -> None:
    monkeypatch.setattr(csv_source, "BYTES_AT_ONCE", 8000)  # some ten rows
    source, sink = tmp_path / f"log.{kind}", tmp_path / "poses.csv"
    # A clock in ns that passes 100 s, where the size of its times is that of ms since 1970.
    table = {"time": 1e9 * np.arange(300.0), **_table(nao, np.repeat(q, 300 // ROWS + 1, axis=0)[:300])}
    (tmp_path / "log.csv").write_text(_text(table))
    if kind == "parquet":
        pyarrow.parquet.write_table(pa.table(table), source, row_group_size=2)
    nk.stream.fk(nao, source, sink, frame="Head")
    written = [float(line.split(",")[1]) for line in sink.read_text().splitlines()[1:]]
    assert written == (table["time"] / 1e9).tolist()
    assert read_log(nao, tmp_path / "log.csv").times.tolist() == written


def test_files_of_one_run_have_times_of_one_unit(nao: nk.NaoModel, q: np.ndarray, tmp_path: Path) -> None:
    sources, sink = [tmp_path / "a.csv", tmp_path / "b.csv"], tmp_path / "poses.csv"

    def written(headings: tuple[str, str], starts: tuple[float, float], **options: Any) -> list[float]:
        """Return the times of the poses of two files with a clock in ns."""
        for source, heading, start in zip(sources, headings, starts, strict=True):
            source.write_text(_text({heading: np.rint(1e9 * (TIMES + start)), **_table(nao, q)}))
        nk.stream.fk(nao, sources, sink, frame="Head", overwrite=True, **options)
        return [float(line.split(",")[1]) for line in sink.read_text().splitlines()[1:]]

    for headings, units in ((("time [s]", "time"), ("ns", "s")), (("time", "time [ms]"), ("ms", "ns"))):
        of_one = rf"b\.csv: its times are in {units[0]}.*, those of .*a\.csv in {units[1]}"
        with pytest.raises(BadInputFile, match=of_one):
            written(headings, (0.0, 300.0))
    # Headings are believed, also if they differ, and columns= counts as a heading.
    expected = pytest.approx([*TIMES, *(TIMES + 300.0)], abs=1e-9)
    assert written(("time [ns]", "time [ns]"), (0.0, 300.0)) == expected
    assert written(("time", "time"), (0.0, 300.0), columns={"time": "time [ns]"}) == expected
    # One unit that is guessed is one unit.
    assert written(("time", "time"), (0.0, 300.0)) == expected
    assert written(("time", "time"), (1.7e9, 1.7e9 + 300.0))[0] == pytest.approx(1.7e9 + TIMES[0])


def _iso(seconds: float, form: str) -> str:
    """The time so long after 23:59:59.5 on the last day of February 2028, a leap year."""
    moment = datetime(2028, 2, 29, 23, 59, 59, 500_000) + timedelta(seconds=seconds)
    if form == "offsets":  # another one in every row
        zone, minutes = (("+00:30", 30), ("-0130", -90), ("+02", 120))[round(seconds / 0.02) % 3]
        return (moment + timedelta(minutes=minutes)).isoformat(timespec="microseconds") + zone
    if form == "ns":
        return moment.isoformat(timespec="microseconds") + "001"
    if form == "logging":
        return moment.strftime("%Y-%m-%d %H:%M:%S,") + f"{moment.microsecond // 1000:03d}"
    return moment.isoformat(sep=" " if form == "space" else "T", timespec="milliseconds") + ("Z" if form == "Z" else "")


ISO_FORMS = ("T", "space", "Z", "offsets", "ns", "logging")


def _iso_text(nao: nk.NaoModel, q: np.ndarray, form: str, heading: str = "time") -> str:
    stamps = np.array([_iso(time, form) for time in TIMES], dtype=object)
    return (
        _text({**_table(nao, q), heading: stamps}, ";")
        if form == "logging"
        else _text({heading: stamps, **_table(nao, q)})
    )


@pytest.mark.parametrize("form", ISO_FORMS)
@pytest.mark.parametrize("large", [False, True], ids=["", "large"])
def test_dates_and_times_are_seconds_from_the_first_row(
    nao: nk.NaoModel,
    q: np.ndarray,
    tmp_path: Path,
    small_blocks: None,
    monkeypatch: pytest.MonkeyPatch,
    form: str,
    large: bool,
) -> None:
    if large:
        monkeypatch.setattr("nao_kin._core.csv_numbers._LARGE", 0)
    source, expected = tmp_path / "log.csv", TIMES - TIMES[0]
    for heading in ("time", "Stamp", "t [s]"):
        source.write_text(_iso_text(nao, q, form, heading))
        log = read_log(nao, source)
        assert np.allclose(log.times, expected, rtol=0, atol=1e-9)
        assert np.array_equal(log.q, q)
        assert log.notes == ()
        motion = nk.motion.read_motion(source, robot=nao)
        assert np.array_equal(motion.key_times, log.times)
        assert np.array_equal(motion.configurations(nao).q, q)
        nk.stream.fk(nao, source, tmp_path / "poses.parquet", frame="Head", overwrite=True)
        poses = pyarrow.parquet.read_table(tmp_path / "poses.parquet")
        assert np.array_equal(poses["time"].to_numpy(), log.times)
    objects = [nao.angles(row) | {"time": _iso(time, form)} for time, row in zip(TIMES, q, strict=True)]
    (tmp_path / "log.json").write_text(json.dumps(objects))
    assert np.array_equal(read_log(nao, tmp_path / "log.json").times, log.times)


def test_fractions_of_seconds_do_not_tell_the_mark_of_numbers(nao: nk.NaoModel, q: np.ndarray, tmp_path: Path) -> None:
    source = tmp_path / "log.csv"
    header, *rows = _text(_table(nao, q), ";", ",").splitlines()
    rows = [f"{_iso(time, 'T')};{row}" for time, row in zip(TIMES, rows, strict=True)]
    source.write_text("\n".join([f"time;{header}", *rows]))
    assert np.array_equal(read_log(nao, source).q, q)
    assert np.allclose(read_log(nao, source).times, TIMES - TIMES[0], rtol=0, atol=1e-9)
    assert np.array_equal(nk.motion.read_motion(source).configurations(nao).q, q)


def test_a_header_in_a_comment_stands_above_dates_too(nao: nk.NaoModel, q: np.ndarray, tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("# robot 7\n# " + _iso_text(nao, q, "space"))
    log = read_log(nao, tmp_path / "log.csv")
    assert np.array_equal(log.q, q)
    assert np.allclose(log.times, TIMES - TIMES[0], rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    ("first", "bad", "message"),
    [
        ("2028-02-29T12:00:00", "2027-02-29T12:00:01", "expected a time such as 2026-03-01T12:00:00.5"),
        ("2028-02-29T12:00:00", "2028-02-29T25:00:01", "expected a time such as 2026-03-01T12:00:00.5"),
        ("2028-02-29T12:00:00", "12.5", "expected a time such as 2026-03-01T12:00:00.5"),
        ("2028-02-29T12:00:00", "2028-02-29T12:00:01Z", "which has a time zone; the first time has none"),
        ("2028-02-29T12:00:00+01:00", "2028-02-29T12:00:01", "which has no time zone; the first time has one"),
        ("12.5", "2028-02-29T12:00:01", "expected a finite number"),
    ],
)
@pytest.mark.parametrize("large", [False, True], ids=["", "large"])
def test_a_bad_time_is_named_with_its_line_and_column(
    nao: nk.NaoModel, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, first: str, bad: str, message: str, large: bool
) -> None:
    if large:
        monkeypatch.setattr("nao_kin._core.csv_numbers._LARGE", 0)
    source, values = tmp_path / "log.csv", list(nao.angles(nao.posture("Stand")).values())
    rows = [[values[0], time, *values[1:]] for time in (first, bad)]
    names = list(nao.angles(nao.posture("Stand")))
    source.write_text("\n".join(",".join(map(str, row)) for row in [[names[0], "time", *names[1:]], *rows]))
    says = re.escape(f"log.csv, line 3, column 2: time is '{bad}', {message}")
    with pytest.raises(BadInputFile, match=says):
        read_log(nao, source)
    with pytest.raises(BadInputFile, match=says):
        nk.motion.read_motion(source)
    with pytest.raises(BadInputFile, match=says):
        nk.stream.fk(nao, source, tmp_path / "poses.npy", frame="Head")
    result = nk.stream.fk(nao, source, tmp_path / "poses.npy", frame="Head", on_error="skip")
    assert (result.rows_written, result.bad_rows) == (1, 1)
    stamped = [{**dict(zip(names, values, strict=True)), "time": time} for time in (first, bad)]
    (tmp_path / "log.json").write_text(json.dumps(stamped))
    if first != "12.5":
        with pytest.raises(BadInputFile, match=re.escape(f"configuration 1: time is '{bad}', {message}")):
            read_log(nao, tmp_path / "log.json")


def test_dates_and_times_in_joint_columns_are_refused(nao: nk.NaoModel, q: np.ndarray, tmp_path: Path) -> None:
    source = tmp_path / "log.csv"
    stamps = np.array([_iso(time, "T") for time in TIMES], dtype=object)
    source.write_text(_text({"time": stamps, **_table(nao, q), "HeadYaw": stamps}))
    for read in (lambda: read_log(nao, source), lambda: nk.motion.read_motion(source)):
        with pytest.raises(BadInputFile, match=r"line 2, column 2: HeadYaw is '2028-.*expected a finite number"):
            read()


def test_times_of_several_files_count_from_the_first_row_of_the_first(
    nao: nk.NaoModel, q: np.ndarray, tmp_path: Path, small_blocks: None
) -> None:
    lines = _iso_text(nao, q, "Z").splitlines()
    (tmp_path / "log_1.csv").write_text("\n".join(lines[:25]) + "\n")
    (tmp_path / "log_2.csv").write_text("\n".join([lines[0], *lines[25:]]) + "\n")
    nk.stream.fk(nao, str(tmp_path / "log_?.csv"), tmp_path / "poses.parquet", frame="Head")
    times = pyarrow.parquet.read_table(tmp_path / "poses.parquet")["time"].to_numpy()
    assert np.allclose(times, TIMES - TIMES[0], rtol=0, atol=1e-9)
    for form, message in (("T", "its times have no time zone, those of"), ("", "its times are numbers, those of")):
        text = _iso_text(nao, q, form) if form else _text({"time": TIMES, **_table(nao, q)})
        (tmp_path / "other.csv").write_text(text)
        with pytest.raises(BadInputFile, match=rf"other.csv: {message} .*log_1.csv"):
            nk.stream.fk(nao, [tmp_path / "log_1.csv", tmp_path / "other.csv"], tmp_path / "p.npy", frame="Head")


def test_times_count_from_the_first_row_where_a_run_goes_on(
    nao: nk.NaoModel, q: np.ndarray, tmp_path: Path, small_blocks: None
) -> None:
    (tmp_path / "log.csv").write_text(_iso_text(nao, q, "T"))

    def source() -> closing[csv_source.CsvSource]:
        return closing(csv_source.CsvSource(str(tmp_path / "log.csv"), nao, TableOptions()))

    with source() as whole, source() as rest:
        first, second, *_ = whole.blocks(whole.start)
        again = next(rest.blocks(first.end))
    assert np.array_equal(again.times, second.times)
    assert again.times[0] > 0.0


def test_stamps_of_arrow_are_times(nao: nk.NaoModel, q: np.ndarray, tmp_path: Path) -> None:
    stamps = pa.array((TIMES * 1e3).round().astype(int) + 1_700_000_000_000, pa.timestamp("ms"))
    index = pa.array(np.arange(ROWS))
    pyarrow.parquet.write_table(
        pa.table({"__index_level_0__": index, **_table(nao, q), "stamp": stamps}), tmp_path / "log.parquet"
    )
    nk.stream.fk(nao, tmp_path / "log.parquet", tmp_path / "poses.parquet", frame="Head")
    times = pyarrow.parquet.read_table(tmp_path / "poses.parquet")["time"].to_numpy()
    assert np.allclose(times - 1.7e9, TIMES, rtol=0, atol=1e-6)


def _poses(path: Path) -> np.ndarray:
    return np.load(path)


@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_other_columns_are_named_left_out_or_refused(
    nao: nk.NaoModel, q: np.ndarray, tmp_path: Path, ending: str, capsys: pytest.CaptureFixture[str]
) -> None:
    table = _table(nao, q)
    table["yaw_deg"] = np.degrees(table.pop("HeadYaw"))
    words = np.array(["walk"] * ROWS)
    table = {"state": words, "ms": np.rint(1e3 * TIMES), **table, "battery": np.linspace(1.0, 0.9, ROWS)}
    source, out = tmp_path / f"log.{ending}", tmp_path / "poses.npy"
    if ending == "csv":
        source.write_text(_text(table))
    else:
        pyarrow.parquet.write_table(pa.table(table), source)
    with pytest.raises(BadInputFile, match=r"unknown joint 'state' .*--columns.* ignore_other=True \(--ignore-other\)"):
        nk.stream.fk(nao, source, out, frame="Head")
    with pytest.raises(BadInputFile, match="missing joints: HeadYaw"):
        nk.stream.fk(nao, source, out, frame="Head", ignore_other=True)
    with pytest.raises(BadArgument, match="unknown column of .* 'yaw' .nearest: yaw_deg"):
        nk.stream.fk(nao, source, out, frame="Head", columns={"yaw": "HeadYaw"})
    columns = {"yaw_deg": "HeadYaw [deg]", "ms": "time [ms]"}
    nk.stream.fk(nao, source, out, frame="Head", columns=columns, ignore_other=True)
    assert np.allclose(_poses(out), nao.fk(q, "Head"), rtol=0, atol=1e-12)
    nk.stream.fk(nao, source, out, frame="Head", columns={**columns, "state": None, "battery": None}, overwrite=True)
    assert np.allclose(_poses(out), nao.fk(q, "Head"), rtol=0, atol=1e-12)
    options = ["--columns=yaw_deg=HeadYaw [deg]", "--columns=ms=time [ms]", "--columns=state=", "--ignore-other"]
    assert run(["fk", str(source), "--frame", "Head", *options, "-o", str(tmp_path / "poses.csv")]) == 0
    written = (tmp_path / "poses.csv").read_text()
    assert f"\n3,{TIMES.tolist()[3]!r},Head," in written
    if ending == "csv":
        capsys.readouterr()
        assert run(["fk", str(source), "--frame", "Head", *options, "--csv"]) == 0
        assert capsys.readouterr().out == written
        assert np.array_equal(
            read_log(nao, source, columns=columns, ignore_other=True).times, np.rint(1e3 * TIMES) / 1e3
        )
        page = tmp_path / "log.html"
        assert run(["view", str(source), *options, "--html", str(page)]) == 0
        assert page.is_file()


def test_units_that_a_joint_has_not_are_refused(nao: nk.NaoModel, q: np.ndarray, tmp_path: Path) -> None:
    for old, new, message in (
        ("HeadYaw", "HeadYaw [grad]", "line 1, column 1: unit 'grad' of HeadYaw, expected one of rad, deg"),
        ("LHand", "LHand [rad]", "unit 'rad' of LHand, expected one of 1, %"),
        ("HeadYaw", "time [h],HeadYaw", "unit 'h' of time, expected one of s, ms"),
        ("HeadYaw", "t,time,HeadYaw", "line 1, column 2: two columns of times"),
    ):
        (tmp_path / "log.csv").write_text(_text(_table(nao, q)).replace(old, new, 1))
        with pytest.raises(BadInputFile, match=message):
            read_log(nao, tmp_path / "log.csv")
        with pytest.raises(BadInputFile, match=message):
            nk.stream.fk(nao, tmp_path / "log.csv", tmp_path / "poses.npy", frame="Head")


def test_places_in_messages_are_those_of_the_file(nao: nk.NaoModel, q: np.ndarray, tmp_path: Path) -> None:
    q[7, 1] = 9.0
    text = "# a log\n" + _text({"": np.arange(ROWS), "time": TIMES, **_table(nao, q)})
    (tmp_path / "log.csv").write_text(text)
    for read in (read_log, lambda nao, path: nk.stream.fk(nao, path, tmp_path / "poses.npy", frame="Head")):
        with pytest.raises(BadInputFile, match=r"log.csv, line 10, column 4: outside the joint limits: HeadPitch = 9 "):
            read(nao, tmp_path / "log.csv")
    (tmp_path / "log.csv").write_text(text.replace(f"\n5,{TIMES.tolist()[5]!r}", "\n5,", 1))
    for read in (read_log, lambda nao, path: nk.stream.fk(nao, path, tmp_path / "poses.npy", frame="Head")):
        with pytest.raises(BadInputFile, match=r"log.csv, line 8, column 2: time is '', expected a finite number"):
            read(nao, tmp_path / "log.csv")


def test_several_files_and_patterns_go_into_one_output(
    nao: nk.NaoModel, q: np.ndarray, tmp_path: Path, small_blocks: None, capsys: pytest.CaptureFixture[str]
) -> None:
    table = {"time": TIMES, **_table(nao, q)}
    first = {name: column[:15] for name, column in table.items()}
    rest = {name: column[15:] for name, column in reversed(table.items())}
    (tmp_path / "log 1.csv").write_text(_text(first))
    pyarrow.parquet.write_table(pa.table(rest), tmp_path / "log 2.parquet")
    expected = nao.fk(q, "Head")
    for source in ([tmp_path / "log 1.csv", str(tmp_path / "log 2.parquet")], str(tmp_path / "log*")):
        result = nk.stream.fk(nao, source, tmp_path / "poses.npy", frame="Head", overwrite=True)
        assert (result.rows_read, result.rows_written) == (ROWS, ROWS)
        assert np.allclose(_poses(tmp_path / "poses.npy"), expected, rtol=0, atol=1e-12)
    out = tmp_path / "poses.csv"
    files = [str(tmp_path / name) for name in ("log 1.csv", "log 2.parquet")]
    assert run(["fk", *files, "--frame", "Head", "-o", str(out)]) == 0
    records = list(csv.reader(io.StringIO(out.read_text())))[1:]
    assert [record[:2] for record in records] == [[str(row), repr(time)] for row, time in enumerate(TIMES.tolist())]
    # A bad row is named with its file, its line there, and its row in the output.
    lines = _text(rest).splitlines()
    lines[3] = lines[3].replace(lines[3].split(",")[0], "x", 1)
    (tmp_path / "log 2.csv").write_text("\n".join(lines))
    result = nk.stream.fk(
        nao, str(tmp_path / "log*.csv"), tmp_path / "poses.npy", frame="Head", on_error="skip", overwrite=True
    )
    assert (result.rows_read, result.bad_rows) == (ROWS, 1)
    bad = result.first_bad_rows[0]
    assert (bad.row, bad.line, bad.file) == (17, 4, str(tmp_path / "log 2.csv"))
    assert str(bad).startswith(f"{tmp_path / 'log 2.csv'}, line 4, column ")
    with pytest.raises(BadInputFile, match=r"log 2.csv, line 4, column \d+: "):
        nk.stream.fk(nao, str(tmp_path / "log*.csv"), tmp_path / "poses.npy", frame="Head", overwrite=True)
    with pytest.raises(BadInputFile, match="no file matches this pattern"):
        nk.stream.fk(nao, str(tmp_path / "lag*.csv"), tmp_path / "poses.npy", frame="Head")
    (tmp_path / "log 2.csv").write_text(_text(_table(nao, q)))
    with pytest.raises(BadInputFile, match=r"log 2.csv: no column of times, which .*log 1.csv has"):
        nk.stream.fk(nao, str(tmp_path / "log*.csv"), tmp_path / "poses.npy", frame="Head", overwrite=True)
    capsys.readouterr()
    assert run(["fk", str(tmp_path / "log 1.csv"), str(tmp_path / "log 2.csv")]) == 2
    assert "2 files; several files need --output" in capsys.readouterr().err


def test_a_motor_without_a_value_is_one_that_neither_of_its_joints_gives(nao: nk.NaoModel, tmp_path: Path) -> None:
    hip = nao.joint_names.index("LHipYawPitch")
    q = np.tile(nao.posture("Stand"), (4, 1))
    left, right = q[:, hip].copy(), q[:, hip].copy()
    left[[1, 3]], right[[2, 3]] = np.nan, np.nan
    (tmp_path / "log.csv").write_text(_text({**_table(nao, q), "LHipYawPitch": left, "RHipYawPitch": right}))
    log = read_log(nao, tmp_path / "log.csv", missing="Stand")
    assert np.argwhere(log.gaps).tolist() == [[3, hip]]
    assert np.allclose(log.q, q, rtol=0.0, atol=1e-12)


def test_two_hips_of_sensors_are_settled_as_asked(
    nao: nk.NaoModel, q: np.ndarray, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table = _of_devices({**_table(nao, q), "RHipYawPitch": q[:, nao.joint_names.index("LHipYawPitch")] + 0.002})
    source = tmp_path / "log.csv"
    source.write_text(_text(table))
    with pytest.raises(
        BadInputFile, match=r"drives RHipYawPitch, .*hips=\"average\" \(--hips average\) takes their mean"
    ):
        read_log(nao, source)
    with pytest.raises(BadInputFile, match=r"drives RHipYawPitch, .*--hips average"):
        nk.stream.fk(nao, source, tmp_path / "poses.npy", frame="LLeg")
    (tmp_path / "poses.csv").write_text(_text(table))
    assert run(["fk", str(tmp_path / "poses.csv"), "--limits", "ignore"]) == 2
    assert "--hips average" in capsys.readouterr().err
    # What the message advises is accepted, without times as with them, for one file and for several.
    for arguments in ([str(source), "--csv"], [str(source), str(source), "-o", str(tmp_path / "two.csv")]):
        assert run(["fk", *arguments, "--limits", "ignore", "--hips", "average"]) == 0
        capsys.readouterr()
    for hips, off in (("average", 0.001), ("left", 0.0), ("right", 0.002)):
        expected = q.copy()
        expected[:, nao.joint_names.index("LHipYawPitch")] += off
        assert np.allclose(read_log(nao, source, hips=hips, limits="ignore").q, expected, rtol=0, atol=1e-15)
        nk.stream.fk(nao, source, tmp_path / "poses.npy", frame="LLeg", hips=hips, limits="ignore", overwrite=True)
        assert np.allclose(_poses(tmp_path / "poses.npy"), nao.fk(expected, "LLeg"), rtol=0, atol=1e-12)
    # With times it was always read so, as a motion.
    source.write_text(_text({"time": TIMES, **table}))
    expected[:, nao.joint_names.index("LHipYawPitch")] -= 0.001
    for options in (["-o", str(tmp_path / "poses.csv"), "--force"], ["--csv"]):
        capsys.readouterr()
        assert run(["fk", str(source), "--frame", "LLeg", "--as", "matrix", "--limits", "ignore", *options]) == 0
        text = capsys.readouterr().out if "--csv" in options else (tmp_path / "poses.csv").read_text()
        numbers = np.array([record[3:] for record in list(csv.reader(io.StringIO(text)))[1:]], float)
        assert np.allclose(numbers.reshape(-1, 4, 4), nao.fk(expected, "LLeg"), rtol=0, atol=1e-12)


def test_a_table_with_times_is_streamed_and_not_read_as_a_motion(
    nao: nk.NaoModel, q: np.ndarray, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "log.csv").write_text(_text({"time": TIMES, **_table(nao, q)}))

    def refuse(*arguments: object, **named: object) -> None:
        raise AssertionError("the whole file is read")

    monkeypatch.setattr("nao_kin.cli.sources.MotionFile.read", refuse)
    monkeypatch.setattr("nao_kin.stream.tables.read_log", refuse)
    assert run(["fk", str(tmp_path / "log.csv"), "--frame", "Head", "-o", str(tmp_path / "poses.npy")]) == 0
    assert _poses(tmp_path / "poses.npy").shape == (ROWS, 1, 6)


def test_a_table_with_empty_cells_is_a_motion(nao: nk.NaoModel, q: np.ndarray, tmp_path: Path) -> None:
    lines = _text({"time": TIMES, **_table(nao, q)}).splitlines()
    cells = lines[5].split(",")
    lines[5] = ",".join([cells[0], "", *cells[2:]])  # HeadYaw has no key then, and lies between its neighbours
    (tmp_path / "log.csv").write_text("\n".join(lines))
    q[4, 0] = 0.5 * (q[3, 0] + q[5, 0])
    out = tmp_path / "poses.npy"
    options = ("--frame", "Head", "--as", "matrix", "--limits", "ignore", "-o", str(out))
    assert run(["fk", str(tmp_path / "log.csv"), *options]) == 0
    assert np.allclose(_poses(out)[:, 0], nao.fk(q, "Head"), rtol=0, atol=1e-9)


def test_json_objects_may_have_times_and_units(nao: nk.NaoModel, q: np.ndarray, tmp_path: Path) -> None:
    rows = [
        {"t": time, "HeadYaw [deg]": np.degrees(row[0]), **dict(zip(nao.joint_names[1:], row[1:], strict=True))}
        for time, row in zip(TIMES.tolist(), q.tolist(), strict=True)
    ]
    (tmp_path / "log.json").write_text(json.dumps(rows))
    log = read_log(nao, tmp_path / "log.json")
    assert np.allclose(log.q, q, rtol=0, atol=1e-15)
    assert np.array_equal(log.times, TIMES)


def test_times_are_carried_to_what_is_printed_and_read_again(
    nao: nk.NaoModel, q: np.ndarray, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "log.csv").write_text(_text({"time": TIMES, **_table(nao, q)}))
    nk.motion.write_motion(nk.Motion(TIMES, nao.joint_names, q), tmp_path / "log.xar")
    for name in ("log.csv", "log.xar"):
        assert run(["fk", str(tmp_path / name), "--frame", "LLeg", "--json", "--limits", "ignore"]) == 0
        document = json.loads(capsys.readouterr().out)
        assert np.allclose(document["times"], TIMES, rtol=0, atol=0.02 if name == "log.xar" else 0.0)
        assert len(document["configurations"]) == len(document["times"])
    assert run(["fk", str(tmp_path / "log.csv"), "--frame", "LLeg"]) == 0
    assert capsys.readouterr().out.splitlines()[1].split()[:3] == ["0", "0.010000", "LLeg"]
    assert run(["fk", str(tmp_path / "log.csv"), "--frame", "LLeg", "-o", str(tmp_path / "feet.csv")]) == 0
    capsys.readouterr()
    assert run(["ik", "LLeg", str(tmp_path / "feet.csv"), "--json"]) == 0
    assert len(json.loads(capsys.readouterr().out)["targets"]) == ROWS


# --- limits -------------------------------------------------------------------------------------------------------


def test_clamping_says_how_many_rows_it_moved_and_how_far(
    nao: nk.NaoModel, q: np.ndarray, tmp_path: Path, small_blocks: None, capsys: pytest.CaptureFixture[str]
) -> None:
    q[11, 0], q[30, 5] = nao.upper[0] + 0.25, nao.lower[5] - 5e-7
    for name, text in (("log.csv", _text(_table(nao, q))), ("timed.csv", _text({"time": TIMES, **_table(nao, q)}))):
        (tmp_path / name).write_text(text)
        result = nk.stream.fk(
            nao, tmp_path / name, tmp_path / "poses.npy", frame="Head", limits="clamp", overwrite=True
        )
        assert (result.clamped.rows, result.clamped.joint) == (1, "HeadYaw")
        assert result.clamped.largest == pytest.approx(0.25)
        assert result.as_dict()["clamped"]["rows"] == 1
        for options in (["-o", str(tmp_path / "poses.csv"), "--force"], ["--csv"], ["--csv", "--rate", "50"]):
            if "--rate" in options and name == "log.csv":
                continue
            capsys.readouterr()
            assert run(["fk", str(tmp_path / name), "--frame", "Head", "--limits", "clamp", *options]) == 0
            said = capsys.readouterr().err
            assert re.search(
                rf"--limits clamp moved \d+ of {ROWS} rows to the limits, by at most 0\.25 rad \(HeadYaw\)", said
            ), said
    nk.stream.fk(nao, tmp_path / "log.csv", tmp_path / "poses.npy", frame="Head", limits="clamp", overwrite=True)
    assert np.allclose(_poses(tmp_path / "poses.npy"), nao.fk(nao.clamp(q), "Head"), rtol=0, atol=1e-12)


def test_messages_of_limits_name_the_options_that_take_the_row(
    nao: nk.NaoModel, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    q = np.stack([nao.posture("StandInit")] * 3)
    q[1, 0] = 2.5
    degrees = np.where([unit == "rad" for unit in nao.joint_units], np.degrees(q), q)
    for name, values in (("rad.csv", q), ("deg.csv", degrees[:1])):
        (tmp_path / name).write_text(_text(_table(nao, values)))
        for options in (["--csv"], ["-o", str(tmp_path / "poses.csv")]):
            assert run(["fk", str(tmp_path / name), *options]) == 2
            said = capsys.readouterr().err
            in_degrees = name == "deg.csv"
            assert ("--limits clamp or ignore" in said) == (not in_degrees), said
            assert ("are these degrees (degrees=True, --file-deg)?" in said) == in_degrees, said
    assert run(["fk", "--joint", "HeadYaw=30"]) == 2
    assert capsys.readouterr().err.endswith("rad; are these degrees (--deg)?\n")


def test_a_bad_file_is_refused_before_meshes_are_read(
    nao: nk.NaoModel, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refuse(*arguments: object, **named: object) -> None:
        raise AssertionError("the viewer is made")

    monkeypatch.setattr("nao_kin.cli.view.LivePage.viewer", refuse)
    (tmp_path / "bad.csv").write_text("HeadYam\n0\n")
    (tmp_path / "bad_motion.csv").write_text("time,HeadYam\n0,0\n")
    for name in ("bad.csv", "bad_motion.csv"):
        assert run(["view", str(tmp_path / name), "--html", str(tmp_path / "x.html")]) == 2
        assert "unknown joint 'HeadYam'" in capsys.readouterr().err


@pytest.mark.parametrize(
    "content",
    [b"", b"\x93NUMPY", b"\x93NUMPY\x01\x00v\x00{", b"\x93NUMPY\x01\x00v\x00((((" + b" " * 113 + b"\n" + bytes(24)],
)
def test_targets_in_an_array_that_is_cut_off_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], content: bytes
) -> None:
    (tmp_path / "empty.npy").write_bytes(content)
    assert run(["ik", "LLeg", str(tmp_path / "empty.npy")]) == 2
    assert re.fullmatch(r"nao-kin: \S+empty.npy: not a .npy file: [^\n]+\n", capsys.readouterr().err)


# --- Headings of other tools.


@pytest.mark.parametrize(
    ("heading", "unit"),
    [
        ("Time (Seconds)", 1.0),
        ("time_s", 1.0),
        ("__time", 1.0),
        ("header.stamp", 1.0),
        ("Time [MSec]", 1e3),
        ("time_ms", 1e3),
        ("t [μs]", 1e6),  # a Greek letter, not the sign of micro
        ("timestamp_ns", 1e9),
    ],
)
def test_times_are_found_by_the_names_and_units_of_other_tools(
    nao: nk.NaoModel, q: np.ndarray, tmp_path: Path, heading: str, unit: float
) -> None:
    path = tmp_path / "log.csv"
    path.write_text(_text({heading: unit * (5.0 + TIMES), **_table(nao, q)}))
    for ignore_other in (False, True):
        log = read_log(nao, path, limits="ignore", ignore_other=ignore_other)
        assert log.times == pytest.approx(5.0 + TIMES, abs=1e-9)
        assert log.notes == ()
    part = tmp_path / "part.csv"
    part.write_text(_text({heading: unit * TIMES, "HeadYaw": q[:, 0]}))
    assert nk.motion.read_motion(part).times[0] == pytest.approx(TIMES, abs=1e-9)


def test_a_joint_with_the_name_of_a_time_is_a_joint(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("t_s"))
    (tmp_path / "q.csv").write_text("time,t_s [deg]\n0.5,90\n")
    log = read_log(robot, tmp_path / "q.csv")
    assert (log.times.tolist(), log.q.tolist()) == ([0.5], [[np.pi / 2]])


def test_times_of_an_unknown_name_are_not_lost_without_a_note(nao: nk.NaoModel, q: np.ndarray, tmp_path: Path) -> None:
    path, table = tmp_path / "log.csv", _table(nao, q)
    path.write_text(_text({"sample_time": TIMES, "battery": TIMES, **table}))
    log = read_log(nao, path, limits="ignore", ignore_other=True)
    assert log.times is None
    assert "'sample_time'" in log.notes[0]
    assert "battery" not in log.notes[0]
    result = nk.stream.fk(nao, path, tmp_path / "poses.csv", frame="Head", limits="ignore", ignore_other=True)
    assert result.notes == log.notes
    assert read_log(nao, path, limits="ignore", columns={"sample_time": "time [s]", "battery": None}).notes == ()
    path.write_text(_text({"time_s": TIMES, "sample_time": TIMES, **table}))
    assert read_log(nao, path, limits="ignore", ignore_other=True).notes == ()


def test_a_column_under_two_names_is_refused_with_both(nao: nk.NaoModel, q: np.ndarray, tmp_path: Path) -> None:
    path, table = tmp_path / "log.csv", _table(nao, q)
    key = "Device/SubDeviceList/HeadYaw/Position/Actuator/Value"
    for more, names in (
        ({"time_s": TIMES, "timestamp_ns": TIMES}, ("time_s", "timestamp_ns")),
        ({key: TIMES}, ("'HeadYaw'", key)),
        ({"/cmd/HeadYaw/position": TIMES}, ("'HeadYaw'", "/cmd/")),
    ):
        path.write_text(_text(table | more))
        with pytest.raises(BadInputFile) as refused:
            read_log(nao, path, limits="ignore", ignore_other=True)
        assert all(name in str(refused.value) for name in names)


def test_the_table_of_plotjuggler_gives_the_positions(nao: nk.NaoModel, q: np.ndarray, tmp_path: Path) -> None:
    path, topic = tmp_path / "plot.csv", "/joint_states"
    columns: Table = {"__time": 1.7e9 + TIMES, f"{topic}/header/stamp": TIMES}
    for name, values in _table(nao, q).items():
        columns |= {f"{topic}/{name}/{what}": values + 9.0 * at for at, what in enumerate(("position", "effort"))}
        columns[f"{topic}/{name}/velocity"] = 0.0 * values
    path.write_text(_text(columns))
    log = read_log(nao, path, limits="ignore")
    assert np.array_equal(log.q, q)
    assert log.times - 1.7e9 == pytest.approx(TIMES, abs=1e-6)
    nk.stream.fk(nao, path, tmp_path / "poses.npy", frame="Head", limits="ignore")
    assert np.allclose(_poses(tmp_path / "poses.npy"), nao.fk(q, "Head"), rtol=0, atol=1e-12)


def _json_line(stamp: tuple[int, int], joints: dict[str, float]) -> str:
    header = {"stamp": dict(zip(("sec", "nanosec"), stamp, strict=True)), "frame_id": ""}
    return json.dumps({"header": header, "name": [*joints], "position": [*joints.values()], "velocity": []})


def _echoed_csv(stamp: tuple[int, int], joints: dict[str, float]) -> str:
    return ",".join(map(str, (*stamp, "base_link", *joints, *joints.values(), *[0.5] * (2 * len(joints)))))


def _echoed_yaml(stamp: tuple[int, int], joints: dict[str, float]) -> str:
    names, values = ("".join(f"- {one}\n" for one in part) for part in (joints, joints.values()))
    stamps = f"header:\n  stamp:\n    sec: {stamp[0]}\n    nanosec: {stamp[1]}\n  frame_id: ''\n"
    return f"{stamps}name:\n{names}position:\n{values}velocity: []\neffort: []\n---"


def _echoed_by_ros_1(stamp: tuple[int, int], joints: dict[str, float]) -> str:
    stamps = f"header: \n  seq: 3\n  stamp: \n    secs: {stamp[0]}\n    nsecs: {stamp[1]}\n  frame_id: ''\n"
    names = "".join(f"  - {name}\n" for name in joints)
    return f"{stamps}name: \n{names}position: {[*joints.values()]}\nvelocity: []\neffort: []\n---"


@pytest.mark.parametrize("printed", [_json_line, _echoed_csv, _echoed_yaml, _echoed_by_ros_1])
def test_messages_of_joint_states_are_read_as_tools_print_them(
    nao: nk.NaoModel, q: np.ndarray, tmp_path: Path, printed: Callable[..., str], capsys: pytest.CaptureFixture[str]
) -> None:
    rows = [dict(zip(nao.joint_names, row, strict=True)) for row in q.tolist()]
    lines = [printed((1527, round(1e9 * time)), row) for time, row in zip(TIMES.tolist(), rows, strict=True)]
    path = tmp_path / "log.txt"
    path.write_text("\n".join(lines) + "\n")
    log = read_log(nao, path, limits="ignore")
    assert np.array_equal(log.q, q)
    assert log.times == pytest.approx(1527.0 + TIMES, abs=1e-6)
    assert run(["fk", str(path), "--frame", "Head", "--limits", "ignore", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["times"] == log.times.tolist()
    rows[3]["HeadYaw"] = float("nan")
    path.write_text("\n".join([*lines[:3], printed((1528, 0), rows[3])]).replace("NaN", "null"))
    assert read_log(nao, path, limits="ignore", missing="Stand").gaps[:, 0].tolist() == [False, False, False, True]
    path.write_text("\n".join([*lines[:3], printed((1528, 0), rows[3]).replace("HeadYaw", "HeedYaw")]))
    with pytest.raises(BadInputFile, match="configuration 3"):
        read_log(nao, path, limits="ignore", missing="Stand")


def test_damaged_messages_are_refused_with_their_line(nao: nk.NaoModel, q: np.ndarray, tmp_path: Path) -> None:
    joints = dict(zip(nao.joint_names, q[0].tolist(), strict=True))
    path = tmp_path / "log.jsonl"
    rows = _echoed_csv((7, 0), joints), _json_line((7, 0), joints)
    for line, damaged in ((rows[0], "12,x"), (rows[0], f"{'9' * 5000}{rows[0]}"), (rows[1], '{"name": }')):
        path.write_text(f"{line}\n\n{damaged}\n")
        with pytest.raises(BadInputFile) as refused:
            read_log(nao, path, limits="ignore")
        assert refused.value.line == 3
    with pytest.raises(BadInputFile, match="as a stream"):
        nk.stream.fk(nao, path, tmp_path / "poses.npy", frame="Head")


# --- Units of angles that no heading says.


@pytest.mark.filterwarnings("ignore::nao_kin.errors.DegreesWarning")
@pytest.mark.parametrize("posture", ["Stand", "Crouch", "LyingBack"])
def test_angles_in_the_wrong_unit_are_noted_in_both_directions(
    nao: nk.NaoModel, tmp_path: Path, posture: str, capsys: pytest.CaptureFixture[str]
) -> None:
    rows = np.tile(nao.posture(posture), (300, 1)) + np.random.default_rng(0).normal(0.0, 0.002, (300, 25))
    turning = np.array([nao.unit(name) == "rad" for name in nao.joint_names])
    path = tmp_path / "log.csv"
    for in_degrees in (False, True):
        values = np.where(turning, np.degrees(rows), rows) if in_degrees else rows
        path.write_text(_text(_table(nao, values)))
        for degrees in (False, True):
            log = read_log(nao, path, limits="ignore", degrees=degrees)
            asked = "" if degrees == in_degrees else "radians" if degrees else "degrees"
            assert [re.findall(r"are these (\w+)", note) for note in log.notes] == ([[asked]] if asked else [])
            result = nk.stream.fk(
                nao, path, tmp_path / "poses.npy", frame="Head", limits="ignore", degrees=degrees, overwrite=True
            )
            assert result.notes == log.notes
            options = ["--file-deg"] * degrees
            assert run(["fk", str(path), "--frame", "Head", "--csv", "--limits", "ignore", *options]) == 0
            assert (f"are these {asked}" in capsys.readouterr().err) == bool(asked)
    # What a heading says is not asked about.
    path.write_text(_text({f"{name} [deg]" if turns else name: column for (name, column), turns
                           in zip(_table(nao, rows).items(), turning, strict=True)}))  # fmt: skip
    assert read_log(nao, path, limits="ignore", degrees=True).notes == ()


def test_wheels_that_turn_often_are_not_taken_for_degrees(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("wheel", limits=(-1e4, 1e4)), J("other", limits=(-1e4, 1e4)))
    (tmp_path / "q.csv").write_text("wheel,other\n" + "".join(f"{10 * k},{20 * k}\n" for k in range(1, 9)))
    assert read_log(robot, tmp_path / "q.csv").notes == ()
