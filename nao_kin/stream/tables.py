"""Configurations in CSV and JSON files, and the columns of tables of joint values.

A file names every joint once, in any order: the robot's independent joints, and perhaps mimic joints, as in NAOqi's 26
Body names. Names may be followed by a unit in brackets, or be keys of NAOqi's devices; there may be a column of times.
CSV has the names in its header and one configuration a line, separated by commas, semicolons or tabs; lines above the
header that begin with # are skipped. JSON has one object name → value, or a list of such objects, or one on each line.
ROS messages of joint states, which name the joints in every row, are read in JSON, as `rostopic echo -p` prints them in
CSV, and as `_core.headings` reads what `topic echo` prints. Columns of the sensors in feet and trunk are found by name.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import COUPLING_TOLERANCE, UNIT_TOLERANCE, Floats, LimitPolicy, flag, limit_policy
from nao_kin._core.csv_numbers import CsvHead, Records, SensorColumns, TableColumns, csv_head, read_csv
from nao_kin._core.files import described, is_finite_number, opened, read_json, read_table_text
from nao_kin._core.headings import (
    INERTIAL,
    JOINT_UNITS,
    SENSOR_UNITS,
    TIME_UNITS,
    entry_name,
    guessed_time_unit,
    in_si_units,
    is_decimal,
    is_iso_time,
    is_joint_state,
    is_never_read,
    joint_state_values,
    printed_messages,
    read_heading,
    resembles_time,
    sensor_name,
)
from nao_kin._core.sides import Hips, check_hips
from nao_kin._core.text import MAX_SHOWN, abbreviated, listed, nearest_names, quoted
from nao_kin.errors import BadArgument, BadInputFile, CouplingViolated, OutsideLimits, UnknownName
from nao_kin.robot import OutsideRows, RobotModel
from nao_kin.robot.nao import BODY_ORDER

# Bytes of a file to inspect.
_BEGINNING = 1 << 16
_TURN = 2.0 * math.pi
# Angles are not taken for degrees if so few of them, other than zeros, are beyond a turn, or so far from a range [rad].
_FEW, _NEAR = 0.25, 0.1
# Rows of a table that show the unit of its angles.
_FEW_ROWS = 100
_Error = Callable[[str, int], Exception]  # of a reason and the index of a column
# Columns that are named if they are left out.
_MAX_NAMED = 12


@dataclass(frozen=True, eq=False)
class Log:
    """Configurations in a file, their times, and what sensors measured.

    Attributes:
        q: configurations, shape (n, nq).
        times: times of the rows, shape (n,) [s]; None without times. Dates and times count from the first row.
        many: whether the file contains a list; False for one JSON object.
        notes: assumptions about the file, which columns are those of sensors, and which are left out.
        gaps: which joints have a column but no value in a row, so that `missing` gave it, shape (n, nq).
        sensors: arguments of `nk.world.state` that the file has, by name: "contacts" or "forces", "gyro", "angles" or
            "accelerometer", shapes (n, k), NaN for empty cells.
    """

    q: Floats
    times: Floats | None
    many: bool
    notes: tuple[str, ...]
    gaps: NDArray[np.bool_]
    sensors: dict[str, Floats]


def read_log(
    robot: RobotModel,
    path: Path | str,
    *,
    limits: LimitPolicy = "enforce",
    degrees: bool = False,
    columns: Mapping[str, str | None] | None = None,
    ignore_other: bool = False,
    hips: Hips | None = None,
    missing: str | float | None = None,
) -> Log:
    """Return the configurations in a file, and the times and the values of sensors if it has columns of them.

    Sensors are found by their names in ALMemory, LoLA, ROS and PlotJuggler, and notes say which columns are used:
    the forces on the soles, rather than their sums, rather than contacts; the gyrometer; and the angles of the inertial
    unit, rather than its accelerometer. `nk.world.state(robot, log.q, times=log.times, **log.sensors)` takes them.
    `nk.motion.read_motion` reads a table of times and only some of the joints.

    Args:
        robot: its joints are named in the file.
        path: a CSV file (also packed, .csv.gz) or a JSON file, or "-" for standard input; joint states of ROS in JSON,
            also one on each line, in CSV of PlotJuggler, or as `rostopic echo` and `ros2 topic echo` print them.
        limits: "enforce" refuses joints outside their limits, "clamp" moves them to the limit, "ignore" accepts them,
            "measured" accepts them up to what sensors show, 5° or 0.02 of a ratio, with a warning.
        degrees: turning joints, angles and gyrometers are in degrees if the file does not give their unit.
        columns: headings of columns with other names: name in the file → heading, such as "HeadYaw", "HeadYaw [deg]",
            "time [ms]", "GyroX", "LLeg/TotalWeight" or "LLeg/Contact"; None leaves the column out, and a joint in it is
            at zero.
        ignore_other: leave out columns of unknown names.
        hips: value of a motor whose two joints differ: "average", or "left" or "right" for the joint of that side; None
            refuses them.
        missing: values of joints without a column, and for empty cells, NaN and null, moved to the nearest limit: those
            of a posture, or a number [rad, m or ratio]; None refuses them.

    Returns:
        The configurations `q`, shape (n, nq), and the `times` of the rows, shape (n,) [s], or None; `many`, False for a
        JSON file with one object instead of a list; `notes`, assumptions about the file; `gaps`, shape (n, nq), the
        joints that have a column, but whose value in a row is that of `missing`; and `sensors`, by the names of the
        arguments of `nk.world.state`, each of shape (n, k) [rad, rad/s; forces and acceleration in the file's unit].
        Times without a unit are
        in seconds, or in another unit if the first ones then are times since 1970. Dates and times as in ISO 8601, such
        as 2026-03-01T12:00:00.5Z or 2026-03-01 12:00:00.5, are seconds from the first row.

    Raises:
        BadArgument: no file name, or `columns` that the file does not have.
        BadInputFile: the file is unreadable, empty or malformed; a joint is unknown, missing or named twice; a value is
            not a finite number; only some times have a zone; joints of one motor disagree; or a joint is outside its
            limits. The message has line and column if the file has them.

    Examples:
        >>> from pathlib import Path
        >>> nao = nk.load_nao()
        >>> names = (f"{name} [deg]" if "Hand" not in name else name for name in nao.joint_names)
        >>> _ = Path("log.csv").write_text(";".join(("ms", *names)) + chr(10) + "20" + 25 * ";0,5")
        >>> log = nk.stream.read_log(nao, "log.csv", columns={"ms": "time [ms]"}, limits="ignore")
        >>> log.times.tolist(), round(float(log.q[0, 0]), 4)
        ([0.02], 0.0087)

    Source of the names: doc.aldebaran.com/2-1, actuator_sensor_names; ros-sports/nao_lola; sensor_msgs/Imu.
    """
    limits = limit_policy(limits)
    if hips is not None:
        check_hips(hips)
    name = str(path)
    if not name:
        raise BadArgument("no file name; expected a CSV or JSON file, or - for standard input")
    large = Path(name).suffix.lower() in (".npy", ".parquet", ".arrow", ".feather")
    advice = "; such a file is read with an output, as in -o poses.npy, or by nao_kin.stream" if large else ""
    text, is_json = read_table_text(name, "joint names and values", advice)
    options = TableOptions(degrees, columns, ignore_other, missing, sensors=True)
    many = True
    lines: Sequence[int]
    messages = printed_messages(name, text)
    if is_json or messages is not None:
        table, rows, many = _from_json(name, read_json(name, text) if messages is None else messages, robot, options)
        lines = [0] * len(rows)
    else:
        table, rows, lines = read_csv(
            name, text.encode(), lambda head: options.table(name, head.fields, robot, head), "joint names and values"
        )
        if not len(rows):
            raise BadInputFile(name, "a header and no configurations")
    raw = rows[:, : len(table.names)]
    joints = JointColumns(robot, table, limits, hips, missing=missing)
    values = joints.values(raw)
    try:
        q = robot.configuration(values, limits=limits)
    except CouplingViolated as error:
        row = int(np.argmax(values[error.mimic] == error.mimic_value))
        column, reason = joints.located(error)
        raise BadInputFile(name, reason + HIPS_ADVICE, *table.place(lines[row], column)) from None
    except OutsideLimits as error:
        row = error.violations[0].index[0]
        column, reason = joints.located(error)
        where = f"configuration {row}: " if many and not lines[row] else ""
        reason = f"{where}{reason}{limits_advice(robot, table, raw[row])}"
        raise BadInputFile(name, reason, *table.place(lines[row], column)) from None
    gaps, notes, times = joints.gaps(raw), [*table.notes, joints.unit_note(raw)], None
    if table.timed:
        unit, note = guessed_time_unit(rows[:, -1]) if table.time_unit is None else (table.time_unit, "")
        times, notes = rows[:, -1] / TIME_UNITS[unit], [*notes, note]
    return Log(q, times, many, tuple(filter(None, notes)), gaps, table.measured(rows))


HIPS_ADVICE = '; hips="average" (--hips average) takes their mean'


@dataclass(frozen=True)
class TableOptions:
    """Options for the columns of a file.

    Attributes:
        degrees: turning joints without a unit are in degrees.
        columns: heading in the file → heading to read it as; None leaves it out.
        ignore_other: leave out columns of other names.
        missing: values of joints without a column and of empty cells, a posture or a number; None refuses them.
        sensors: read columns of sensors, too.
    """

    degrees: bool = False
    columns: Mapping[str, str | None] | None = None
    ignore_other: bool = False
    missing: str | float | None = None
    sensors: bool = False

    def __post_init__(self) -> None:
        flag(self.degrees, "degrees")
        flag(self.ignore_other, "ignore_other")

    def table(
        self, name: str, headings: Sequence[str], robot: RobotModel, head: CsvHead | None = None, where: str = ""
    ) -> TableColumns:
        """Return the columns of a table, which must name every joint of a robot once; `where` begins its messages.

        A heading is a name of times, the name of a joint, or NAOqi's key of its position, such as
        Device/SubDeviceList/HeadYaw/Position/Sensor/Value; a unit may follow in brackets. A first column without a name
        is an index, and left out. `head` is that of a CSV file. A joint whose column is left out is at zero.
        """
        known = {*robot.joint_names, *robot.mimics}
        line = 0 if head is None else head.line
        given, columns, others = [heading.strip() for heading in headings], self.columns or {}, list[str]()
        for heading in columns:
            if heading not in given:
                raise BadArgument(str(UnknownName(f"column of {abbreviated(name)}", heading, given)))
        read_as = [({**(head.read_as if head else {}), **columns}).get(text, text) for text in given]
        lola = sorted((joint for joint in BODY_ORDER if joint in robot.joint_names), key=lambda joint: "Hand" in joint)
        read_as = [text and entry_name(text, lola, robot.semantics.force_sensors) for text in read_as]

        def error(reason: str, place: int) -> BadInputFile:
            return BadInputFile(name, where + reason, line, place + 1 if line else 0)

        sensors, unused = self._sensors(robot, read_as, known, error)

        def units_of(text: str, joint: str, place: int) -> Sequence[str]:
            if joint in known:
                return JOINT_UNITS.get(robot.unit(joint), (robot.unit(joint),))
            if not (self.ignore_other or place in unused or any(place in one.places for one in sensors)):
                raise error(_unknown(robot, text), place)
            others.append(given[place])
            return ()

        if head is not None and not any(read_heading(text).name in known for text in read_as if text is not None):
            _check_header(name, head, known)
        table, times = TableColumns.of(read_as, known, units_of, error, degrees=self.degrees, given=given)
        if len(times) > 1:
            both = " and ".join(quoted(given[place], MAX_SHOWN) for place in times[:2])
            raise error(f"two columns of times, {both}; columns= (--columns) leaves one out", times[1])
        notes = list[str]()
        if sensors:
            found = "; ".join(f"{one.kind} {', '.join(given[place] for place in one.places)}" for one in sensors)
            notes.append(f"columns of sensors, by their names: {found}")
        if unused and not self.ignore_other:
            notes.append(f"columns left out: {listed([given[place] for place in unused], _MAX_NAMED)}")
        like_times = [quoted(other, MAX_SHOWN) for other in others if not times and resembles_time(other)]
        if like_times:
            advice = "columns= (--columns) reads a column of times, as in {'clock': 'time [s]'} (clock='time [s]')"
            notes.append(f"no times are read, and {', '.join(like_times[:3])} left out; {advice}")
        table = replace(table, notes=tuple(notes), sensors=tuple(sensors))
        table = table.with_sensors() if self.sensors else table
        left_out = [read_heading(heading).name for heading, read in columns.items() if read is None]
        named = {*table.names, *left_out} & known
        determined = {robot.mimics[joint].joint if joint in robot.mimics else joint for joint in named}
        missing = [joint for joint in robot.joint_names if joint not in determined]
        if missing and (self.missing is None or not table.names):
            advice = "" if self.missing is not None else "; missing= (--missing) gives their values"
            raise BadInputFile(name, f"{where}missing joints: {listed(missing, 5)}{advice}", line)
        return table if self.missing is None else replace(table, gaps=True)

    def _sensors(
        self, robot: RobotModel, read_as: Sequence[str | None], joints: set[str], error: _Error
    ) -> tuple[list[SensorColumns], list[int]]:
        """Return the columns of sensors, and the indices of those that are known but not read.

        Of sensors that say the same, the first kind with one column for each name is used.
        """
        sums, contacts = (
            tuple(f"{sole}/{end}" for sole in robot.semantics.soles) for end in ("TotalWeight", "Contact")
        )
        known = [("forces", robot.semantics.force_sensors), ("forces", sums), ("contacts", contacts), *INERTIAL.items()]
        columns: dict[str, list[int]] = {sensor_name(name): [] for _, names in known for name in names}
        unused = list[int]()
        for place, text in enumerate(read_as):
            if text is None or read_heading(text).name in joints or read_heading(text).is_time:
                continue
            if (name := sensor_name(text)) in columns:
                columns[name].append(place)
            elif is_never_read(text) or name == "AngleZ":
                unused.append(place)
        found = dict[str, SensorColumns]()
        for kind, names in known:
            places = [columns[sensor_name(name)] for name in names]
            instead = {"contacts": "forces", "accelerometer": "angles"}.get(kind, kind)
            if not names or any(len(one) != 1 for one in places) or found.keys() & {kind, instead}:
                continue
            units, expected = list[str](), SENSOR_UNITS.get(kind, ())
            for (place,) in places:
                unit = read_heading(str(read_as[place])).unit
                if self.sensors and expected and unit not in (None, *expected):
                    one_of = f"expected one of {', '.join(expected)}"
                    raise error(f"unit {quoted(unit)} of {abbreviated(str(read_as[place]))}, {one_of}", place)
                units.append("" if not expected else unit or (expected[1] if self.degrees else ""))
            found[kind] = SensorColumns(kind, names, tuple(place for (place,) in places), tuple(units))
        used = {place for one in found.values() for place in one.places}
        return list(found.values()), sorted([*unused, *(p for one in columns.values() for p in one if p not in used)])


# Numbers in a row of a NAO's joints without names → the orders that they may have.
_ORDERS = {
    25: "; 25 may be in the order of joint_names or, as nk.naoqi.from_order reads them, of LoLA",
    26: "; 26 may be in NAOqi's order H25, as nk.naoqi.from_order reads them, or a time and 25 joints",
}


def _check_header(name: str, head: CsvHead, known: set[str]) -> None:
    """Refuse the first line of a file that names no joint, if it is no header: numbers, or a line of a text."""
    expected = "the first line must name the joints"
    if all(is_decimal(field) or is_iso_time(field) for field in head.fields):
        count = len(head.fields)
        order = _ORDERS.get(count, "") if known >= {*BODY_ORDER} else ""
        raise BadInputFile(name, f"{count} numbers and no header: {expected}{order}", head.line)
    if head.first and not any(map(is_decimal, head.first)):
        raise BadInputFile(name, f"no table of joint values: {expected}, and rows of numbers follow", head.line)


def _unknown(robot: RobotModel, text: str) -> str:
    """Return the error of a heading that names no joint."""
    if not text.strip():
        return "a column without a name"
    near = ", ".join(nearest_names(text, [*robot.joint_names, *robot.mimics]))
    advice = f"nearest: {near}" if near else f"expected the robot's {len(robot.joint_names)} joints"
    return (
        f"unknown joint {quoted(text, MAX_SHOWN)} ({advice}); columns= (--columns) renames it, "
        "ignore_other=True (--ignore-other) leaves it out"
    )


def log_columns(
    robot: RobotModel,
    path: Path | str,
    *,
    columns: Mapping[str, str | None] | None = None,
    missing: str | float | None = None,
    data: bytes | None = None,
) -> TableColumns | None:
    """Return the columns of a CSV table if its beginning has complete configurations of a robot, otherwise None.

    The result is also None for a motion (a table of times and some joints, or with empty cells), an unreadable file and
    a pipe. `data` is the content, if it has been read; `columns` and `missing` are those of `read_log`, and with
    `missing` the configurations need not be complete.
    """
    try:
        if data is None and Path(path).is_file():
            with opened(str(path)) as file:
                data = file.read(_BEGINNING)
    except (OSError, ValueError, EOFError, zlib.error):
        return None
    whole = data is not None and len(data) < _BEGINNING
    beginning = (data or b"")[:_BEGINNING].removeprefix(b"\xef\xbb\xbf")
    try:
        head = csv_head(str(path), beginning, "a header", at_end=whole)
        table = TableOptions(columns=columns, ignore_other=True, missing=missing).table(
            str(path), head.fields, robot, head
        )
    except (BadArgument, BadInputFile):
        return None
    rows = beginning[head.size :]
    records = Records(rows if whole else rows[: rows.rfind(b"\n") + 1], head.delimiter, at_end=whole)
    empty = missing is None and any(
        len(fields) == table.all and not all(fields[at].strip() for at in table.places) for _, fields, _ in records
    )
    return None if empty else table


def limits_advice(robot: RobotModel, table: TableColumns, row: Floats) -> str:
    """Return the end of a message about a row (joints,) of a file outside the limits: the options that accept it."""
    values = in_si_units(row[None], table.units)[0]
    if _look_like_degrees(robot, table.names, values[None]):
        return f"; are these degrees{' (degrees=True, --file-deg)' if any(table.assumed) else ''}?"
    by_name = dict(zip(table.names, values, strict=True))
    q = robot.configuration(by_name, limits="ignore", hips="average", missing=0.0)
    noise = ', or "measured", as noise of a sensor' if robot.within_limits(q, limits="measured") else ""
    return f'; limits="clamp" or "ignore" (--limits clamp or ignore) accepts it{noise}'


def unit_note(robot: RobotModel, names: Sequence[str], values: Floats, *, degrees: bool) -> str:
    """Return a note on values (n, joints) [rad, m or ratio] that were probably read in the wrong unit of angles, or "".

    Their file does not say the unit, and with `degrees` they are converted from degrees.
    """
    rows = np.nan_to_num(values[:: 1 + len(values) // _FEW_ROWS])
    if not degrees:
        advice = "angles are read as radians; are these degrees (degrees=True, --file-deg)?"
        return advice if _look_like_degrees(robot, names, rows) else ""
    turning = np.array([robot.unit(name) == "rad" for name in names])
    numbers = np.where(turning, np.degrees(rows), 0.0)
    largest = float(np.abs(numbers).max(initial=0.0))
    if not 0.0 < largest <= _TURN or not _near_limits(robot, names, numbers):
        return ""
    return f"angles are read as degrees, none above {largest:.2g}°; are these radians (no degrees=True, --file-deg)?"


def _look_like_degrees(robot: RobotModel, names: Sequence[str], values: Floats) -> bool:
    """Return whether values (n, joints), taken as radians, are probably degrees.

    Many of the angles are beyond a full turn, some of them outside their limits, and all are near their ranges if they
    are converted.
    """
    turning = np.array([robot.unit(name) == "rad" for name in names])
    angles = np.where(turning, values, 0.0)
    if (np.abs(angles) > _TURN).sum() <= _FEW * np.count_nonzero(angles):
        return False
    return not _near_limits(robot, names, angles) and _near_limits(robot, names, np.radians(angles))


def _near_limits(robot: RobotModel, names: Sequence[str], angles: Floats) -> bool:
    """Return whether angles (n, joints) [rad] are inside their limits, or not far from them."""
    by_name = dict(zip(names, angles.T, strict=True))
    q = robot.configuration(by_name, limits="ignore", hips="average", missing=0.0)
    return all(row.excess < _NEAR for row in robot.limit_violations(q) if row.unit == "rad")


def _from_json(name: str, document: Any, robot: RobotModel, options: TableOptions) -> tuple[TableColumns, Floats, bool]:
    many = isinstance(document, list)
    objects = document if many else [document]
    if not objects:
        raise BadInputFile(name, "a list without configurations")
    names: list[str] = []
    rows = []
    for index, entry in enumerate(objects):
        where = f"configuration {index}: " if many else ""
        if not isinstance(entry, dict):
            raise BadInputFile(name, f"{where}expected an object of joint values, got {described(entry)}")
        if is_joint_state(entry):
            try:
                entry = joint_state_values(entry)
            except ValueError as error:
                raise BadInputFile(name, f"{where}{error}") from None
        entry = dict(_flattened(entry, {*robot.joint_names, *robot.mimics}))
        if not names:
            names = list(entry)
            table = options.table(name, names, robot, where=where)
            stamp = entry[names[table.places[-1]]] if table.timed else None
            table = table.with_times([stamp]) if isinstance(stamp, str) else table
            keys = [names[place] for place in table.places]
        elif entry.keys() != set(names):
            odd = sorted(entry.keys() ^ set(names))
            raise BadInputFile(
                name, f"{where}names other joints than configuration 0: {abbreviated(', '.join(odd[:3]))}"
            )
        row = [entry[key] for key in keys]
        if table.iso_times is not None:
            try:
                row[-1] = table.iso_times.seconds(str(row[-1]))
            except ValueError as error:
                raise BadInputFile(name, f"{where}time {error}") from None
        for place, (value, heading) in enumerate(zip(row, table.headings, strict=True)):
            if table.may_lack(place) and (value is None or value != value):
                row[place] = math.nan
            elif not is_finite_number(value):
                raise BadInputFile(name, f"{where}{heading} is {described(value)}, expected a finite number")
        rows.append(row)
    return table, np.array(rows, dtype=np.float64), many


def _flattened(entry: Mapping[str, Any], joints: set[str]) -> Iterator[tuple[str, Any]]:
    """Yield the entries of an object; those of lists and objects in it as Gyroscope[0], angular_velocity[x]."""
    for key, value in entry.items():
        inner = dict(enumerate(value)) if isinstance(value, list) else value
        if isinstance(inner, dict) and key not in joints:
            yield from ((f"{key}[{at}]", one) for at, one in inner.items())
        else:
            yield key, value


# --- Rows of joint values as configurations, and the errors of bad rows.

_OUTSIDE = "outside the joint limits: "


@dataclass(frozen=True)
class JointColumns:
    """The meaning of the columns of a table of joint values."""

    robot: RobotModel
    table: TableColumns  # joint and unit of every column; with `whole`, of those after the floating base
    limits: LimitPolicy = "enforce"  # "enforce" makes a row with joints outside their limits a bad row
    hips: Hips | None = None  # value of a motor whose two joints differ; None makes the row a bad row
    whole: bool = False  # whether the columns are those of q
    missing: str | float | None = None  # values of joints without a column and of NaN; None makes the row a bad row

    @property
    def base(self) -> int:
        """Number of columns of a floating base, before the joints."""
        return self.robot.nq_base if self.whole else 0

    def configurations(self, values: Floats) -> tuple[Floats, NDArray[np.bool_], OutsideRows]:
        """Return configurations (m, nq) of the good rows of `values` (n, columns), which rows are good, and changes."""
        good: NDArray[np.bool_] = np.asarray(self._known(values).all(axis=1))
        rows = values if good.all() else values[good]
        if self.base:
            unit = np.abs(np.linalg.norm(rows[:, 3:7], axis=1) - 1.0) <= UNIT_TOLERANCE
            rows = _narrow(good, unit, rows)
        q, agreeing = self._assembled(rows)
        q = _narrow(good, agreeing, q)
        if self.limits == "ignore":
            return q, good, OutsideRows()
        if self.limits != "clamp":
            q = _narrow(good, self.robot.within_limits(q, limits=self.limits), q)
        inside, joints = self.robot.clamp(q), self.robot.joint_names
        outside = OutsideRows.of(q[:, -len(joints) :], inside[:, -len(joints) :], joints)
        return inside if self.limits == "clamp" else q, good, outside

    def advice(self, row: Floats) -> str:
        """Return the options that accept a row (columns,) outside the limits or with disagreeing joints, or ""."""
        reason = self.problem(row)[1]
        if reason.startswith(_OUTSIDE):
            return limits_advice(self.robot, self.table, row[self.base :])
        return HIPS_ADVICE if " drives " in reason else ""

    def problem(self, row: Floats) -> tuple[int, str]:
        """Return column, from 0 or -1 for none, and reason why a row (columns,) is not a valid configuration."""
        for column in np.flatnonzero(~self._known(row)).tolist():
            name = self.table.names[column - self.base] if column >= self.base else f"number {column + 1} of the base"
            return column, f"{name} is {float(row[column])}, expected a finite number"
        if self.base and abs(float(np.linalg.norm(row[3:7])) - 1.0) > UNIT_TOLERANCE:
            return 3, f"the base's quaternion has norm {float(np.linalg.norm(row[3:7])):.6g}, expected 1"
        try:
            self.robot.configuration(self.values(row[None]), limits=self.limits)
        except (CouplingViolated, OutsideLimits) as error:
            column, reason = self.located(error)
            return column + self.base if column >= 0 else column, reason
        return -1, "no configuration"

    def located(self, error: CouplingViolated | OutsideLimits) -> tuple[int, str]:
        """Return the column of the joint of an error, from 0 after the base or -1 for none, and the reason."""
        robot, table = self.robot, self.table
        if isinstance(error, CouplingViolated):
            both_turn = robot.unit(error.mimic) == robot.unit(error.primary) == "rad"
            return table.names.index(error.mimic), error.describe(degrees=table.in_degrees and both_turn)
        first = error.violations[0]
        more = f" (and {error.count - 1} more)" if error.count > 1 else ""
        # A joint that the file gives only through its mimic joint has no column.
        column = table.names.index(first.joint) if first.joint in table.names else -1
        return column, f"{_OUTSIDE}{first.describe(degrees=table.in_degrees, index=False)}{more}"

    def values(self, values: Floats) -> dict[str, Floats]:
        """Return joint → values (n,) of rows (n, columns) [rad, m or ratio]."""
        table, robot = self.table, self.robot
        found = dict(zip(table.names, in_si_units(values[:, self.base :], table.units).T, strict=True))
        if self.missing is not None:
            found = robot.fill_missing(found, self.missing)
        return found if self.hips is None else robot.motor_values(found, self.hips)

    def unit_note(self, values: Floats) -> str:
        """Return `unit_note` of the columns whose headings give no unit, of rows (n, columns)."""
        table, assumed = self.table, np.array(self.table.assumed, dtype=np.bool_)
        if not assumed.any() or not len(values):
            return ""
        names = [name for name, one in zip(table.names, assumed, strict=True) if one]
        found = in_si_units(values[:, self.base :], table.units)[:, assumed]
        converted = any(one and unit == "deg" for unit, one in zip(table.units, table.assumed, strict=True))
        return unit_note(self.robot, names, found, degrees=converted)

    def gaps(self, values: Floats) -> NDArray[np.bool_]:
        """Return which joints, in the order of q, have columns in rows (n, columns), but no value, shape (n, nq)."""
        robot, unknown = self.robot, dict[str, NDArray[np.bool_]]()
        for name, column in zip(self.table.names, values[:, self.base :].T, strict=True):
            motor = robot.mimics[name].joint if name in robot.mimics else name
            unknown[motor] = unknown.get(motor, True) & np.isnan(column)
        found = np.zeros((len(values), robot.nq), dtype=np.bool_)
        for motor, rows in unknown.items():
            found[:, robot.nq_base + robot.joint_names.index(motor)] = rows
        return found

    def _known(self, values: Floats) -> NDArray[np.bool_]:
        """Return which numbers (..., columns) may be in a row: finite ones, and NaN of joints that may be missing."""
        known = np.isfinite(values)
        if self.missing is not None:
            known[..., self.base :] |= np.isnan(values[..., self.base :])
        return known

    def _assembled(self, values: Floats) -> tuple[Floats, NDArray[np.bool_]]:
        """Return configurations (n, nq) of finite rows, and in which of them the joints of one motor agree."""
        robot, found = self.robot, self.values(values)
        # One joint of each motor: these cannot disagree.
        first = [joints[0] for joints in robot.joints_by_motor(found).values()]
        set_joints = robot.configuration({name: found[name] for name in first}, limits="ignore")
        q = np.array(np.broadcast_to(set_joints, (len(values), robot.nq)))
        q[:, : self.base] = values[:, : self.base]
        joints = dict(zip(robot.joint_names, q.T[robot.nq_base :], strict=True))
        agreeing = np.ones(len(q), dtype=np.bool_)
        for name in found.keys() & robot.mimics.keys():
            mimic = robot.mimics[name]
            agreeing &= np.abs(mimic.value(joints[mimic.joint]) - found[name]) <= COUPLING_TOLERANCE
        return q, agreeing


def _narrow(good: NDArray[np.bool_], kept: NDArray[np.bool_], rows: Floats) -> Floats:
    """Set `good` to False for rows with `kept` False, and return the remaining rows."""
    if kept.all():
        return rows
    good[np.flatnonzero(good)[~kept]] = False
    return rows[kept]
