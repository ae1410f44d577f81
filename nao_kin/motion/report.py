"""What a check of a motion finds: stretches of time in which a joint may not do what it is to do."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Literal

from nao_kin._common.scalars import finite_or_none

Kind = Literal["limit", "coupled limit", "speed", "motor"]
# A message lists the worst this many stretches of a joint and kind.
_LISTED = 3


@dataclass(frozen=True)
class MotionViolation:
    """A stretch of time in which a joint is outside one bound.

    Attributes:
        kind: "limit": its own range. "coupled limit": the range that another joint leaves it. "speed": its largest
            speed. "motor": what its motor does, which is said otherwise by another joint of that motor.
        joint: its name.
        start: from when [s].
        end: until when [s].
        time: when it is worst [s].
        value: value then, or speed for "speed".
        lower: smallest value allowed then.
        upper: largest value allowed then.
        unit: unit of these three.
        of: the other joint, for a coupled limit and a motor; None for none.
        of_value: its value then.

    Examples:
        >>> nao = nk.load_nao()
        >>> turn = nk.Motion([0.0, 0.1], ["HeadYaw"], [[0.0], [1.5]])
        >>> violation = nk.motion.check(nao, turn).violations[0]
        >>> violation.joint, round(violation.value, 3), round(violation.upper, 3)
        ('HeadYaw', 15.0, 8.268)
    """

    kind: Kind
    joint: str
    start: float
    end: float
    time: float
    value: float
    lower: float
    upper: float
    unit: str
    of: str | None = None
    of_value: float = 0.0

    @property
    def excess(self) -> float:
        """How far outside it is where it is worst."""
        return max(self.lower - self.value, self.value - self.upper)

    def describe(self, *, degrees: bool = False) -> str:
        """The stretch in words, with angles in degrees if wanted.

        Examples:
            >>> nao = nk.load_nao()
            >>> turn = nk.Motion([0.0, 0.1], ["HeadYaw"], [[0.0], [1.5]])
            >>> nk.motion.check(nao, turn).violations[0].describe()
            'HeadYaw moves at 15 at 0 s, 6.73 rad/s outside [-8.26797, 8.26797] rad/s (0 to 0.1 s)'
        """
        turns = degrees and self.unit.startswith("rad")
        scale = math.degrees(1.0) if turns else 1.0
        unit = self.unit.replace("rad", "°") if turns else {"1": "", "1/s": "/s"}.get(self.unit, f" {self.unit}")
        value, lower, upper, excess, of_value = (
            number * scale for number in (self.value, self.lower, self.upper, self.excess, self.of_value)
        )
        when = f"{self.start:.6g} s" if self.start == self.end else f"{self.start:.6g} to {self.end:.6g} s"
        what = " moves at" if self.kind == "speed" else " ="
        text = f"{self.joint}{what} {value:.6g} at {self.time:.6g} s, "
        if self.kind == "motor":
            text += f"{self.of} = {of_value:.6g}{unit}: one motor, {excess:.3g}{unit} apart"
        else:
            text += f"{excess:.3g}{unit} outside [{lower:.6g}, {upper:.6g}]{unit}"
            text += f" at {self.of} = {of_value:.6g}" if self.of is not None else ""
        return f"{text} ({when})"

    def as_dict(self) -> dict[str, Any]:
        """For JSON: what is infinite is None.

        Examples:
            >>> nao = nk.load_nao()
            >>> turn = nk.Motion([0.0, 0.1], ["HeadYaw"], [[0.0], [1.5]])
            >>> nk.motion.check(nao, turn).violations[0].as_dict()["joint"]
            'HeadYaw'
        """
        numbers = ("start", "end", "time", "value", "lower", "upper", "excess")
        found: dict[str, Any] = {"kind": self.kind, "joint": self.joint, "unit": self.unit}
        found |= {name: finite_or_none(float(getattr(self, name))) for name in numbers}
        return found | ({} if self.of is None else {"of": self.of, "of_value": self.of_value})


@dataclass(frozen=True)
class MotionReport:
    """What is wrong with a motion.

    Attributes:
        robot: name of the robot.
        joints: those that the motion names.
        start: its first key [s].
        end: its last key [s].
        violations: by kind, joint and time; of one bound of one joint not more than the 1 000 worst.
        left_out: how many more there are.
        sampled: samples per second between which something of coupled limits or shared motors could hide; None where
            everything was found in closed form.

    Examples:
        >>> nao = nk.load_nao()
        >>> turn = nk.Motion([0.0, 0.1], ["HeadYaw"], [[0.0], [1.5]])
        >>> report = nk.motion.check(nao, turn)
        >>> report.ok, report.violations[0].kind
        (False, 'speed')
    """

    robot: str
    joints: tuple[str, ...]
    start: float
    end: float
    violations: tuple[MotionViolation, ...]
    left_out: int
    sampled: float | None

    @property
    def ok(self) -> bool:
        """Whether the robot can move so."""
        return not self.violations

    @property
    def worst(self) -> tuple[MotionViolation, ...]:
        """Of every kind and joint the stretch with the largest excess, in the order of `violations`."""
        found: dict[tuple[str, str], MotionViolation] = {}
        for violation in self.violations:
            key = violation.kind, violation.joint
            if key not in found or violation.excess > found[key].excess:
                found[key] = violation
        return tuple(found.values())

    def describe(self, *, degrees: bool = False) -> str:
        """One line for each stretch, the longest lists shortened; one line if all is well.

        Examples:
            >>> nod = nk.Motion([0.0, 0.5, 1.0], ["HeadPitch"], [[0.0], [0.3], [0.0]])
            >>> nk.motion.check(nk.load_nao(), nod).describe()
            'nao_v6 can move so: 1 joints, 0 to 1 s'
        """
        span = f"{len(self.joints)} joints, {self.start:g} to {self.end:g} s"
        if self.ok:
            return f"{self.robot} can move so: {span}"
        lines = [f"{self.robot} cannot move so: {span}, {_counted(self.violations)}"]
        groups: dict[tuple[str, str], list[MotionViolation]] = {}
        for violation in self.violations:
            groups.setdefault((violation.kind, violation.joint), []).append(violation)
        for (kind, _), group in groups.items():
            group.sort(key=lambda violation: -violation.excess)
            lines += [f"{kind}: {violation.describe(degrees=degrees)}" for violation in group[:_LISTED]]
            if len(group) > _LISTED:
                lines.append(f"{kind}: {group[0].joint}: and {len(group) - _LISTED} more stretches")
        if self.left_out:
            lines.append(f"and {self.left_out} smaller ones")
        if self.sampled is not None:
            lines.append(f"coupled limits and shared motors were looked at {self.sampled:g} times per second")
        return "\n".join(lines)

    def as_dict(self) -> dict[str, Any]:
        """For JSON, in seconds, radians, metres and ratios.

        Examples:
            >>> nod = nk.Motion([0.0, 0.5, 1.0], ["HeadPitch"], [[0.0], [0.3], [0.0]])
            >>> nk.motion.check(nk.load_nao(), nod).as_dict()["violations"]
            []
        """
        return {
            "robot": self.robot,
            "ok": self.ok,
            "joints": list(self.joints),
            "start": self.start,
            "end": self.end,
            "sampled": self.sampled,
            "left_out": self.left_out,
            "violations": [violation.as_dict() for violation in self.violations],
        }

    def __repr__(self) -> str:
        return f"<MotionReport: {'ok' if self.ok else _counted(self.violations)}>"


def _counted(violations: Iterable[MotionViolation]) -> str:
    counts: dict[str, int] = {}
    for violation in violations:
        counts[violation.kind] = counts.get(violation.kind, 0) + 1
    words = {"limit": "stretches outside limits", "coupled limit": "outside coupled limits"}
    words |= {"speed": "too fast", "motor": "of disagreeing joints"}
    return ", ".join(f"{count} {words[kind]}" for kind, count in counts.items())
