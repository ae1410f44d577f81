"""The errors and warnings of nao_kin, one class per kind.

Every error derives from `NaoKinError`, prints as one line that names what was wrong, what was expected and the nearest
valid names, and carries the values as attributes for programs.
"""

from __future__ import annotations

import copyreg
import math
from collections.abc import Sequence
from typing import Any

from nao_kin._core.extras import missing
from nao_kin._core.guesses import public_attributes as _public_attributes
from nao_kin._core.text import abbreviated, nearest_names, one_line, quoted

__all__ = [
    "BadArgument",
    "BadInputFile",
    "BadModel",
    "CouplingViolated",
    "DegeneratePoints",
    "DegreesWarning",
    "DisagreeingJoints",
    "MeasuredLimitsWarning",
    "MissingExtra",
    "MissingShapeWarning",
    "NaoKinError",
    "NaoKinWarning",
    "NoBrowser",
    "NotABatch",
    "NotARotation",
    "NotCachedWarning",
    "NotCompiledWarning",
    "NotFinite",
    "OtherRobotWarning",
    "OutsideLimits",
    "RenamedFrameWarning",
    "SingularMatrix",
    "StartedOverWarning",
    "UnknownName",
    "WrongShape",
    "ZeroNorm",
]

globals().update(_public_attributes(__name__))


class NaoKinWarning(UserWarning):
    """Base of all warnings of nao_kin: the call succeeds, but its result is probably not what was meant."""


class DegreesWarning(NaoKinWarning):
    """Angles or joint values that look like degrees, where radians are expected."""


class MeasuredLimitsWarning(NaoKinWarning):
    """Joints somewhat outside their limits, as sensors report them, accepted because of limits="measured"."""


class OtherRobotWarning(NaoKinWarning):
    """Offsets that were found for another robot, or another version of it, are applied all the same."""


class RenamedFrameWarning(NaoKinWarning):
    """A frame name that a link of the URDF and a joint share; the link's frame is used."""


class MissingShapeWarning(NaoKinWarning):
    """Shapes of links are left out of a geometry, because their meshes are missing or they cannot be read."""


class NotCachedWarning(NaoKinWarning):
    """Compiled kernels cannot be cached on disk; every process compiles them again."""


class NotCompiledWarning(NaoKinWarning):
    """A large computation runs slowly, because Numba, which would compile it, is not installed."""


class StartedOverWarning(NaoKinWarning):
    """A run that was to be resumed starts from the beginning, because something that it depends on has changed."""


class NaoKinError(Exception):
    """Base of all errors of nao_kin; its message is one line.

    Examples:
        >>> try:
        ...     nk.load_nao("v7")
        ... except nk.NaoKinError as error:
        ...     print(error)
        unknown NAO version 'v7' (nearest: v6, v5, v4)
    """

    def __init__(self, message: str = "") -> None:
        super().__init__(one_line(message))

    def __reduce__(self) -> tuple[Any, ...]:
        # The constructors take other values than the message; this lets an error be pickled to another process.
        return copyreg.__newobj__, (type(self), *self.args), self.__dict__  # type: ignore[attr-defined]


def at_index(index: Sequence[int]) -> str:
    """Return " at index [2, 0]" for an index in a batch, to end a message, and "" for no batch."""
    return f" at index {list(index)}" if index else ""


_FEW = 3


class UnknownName(NaoKinError):
    """A joint, frame, posture, version, sequence … that does not exist.

    Attributes:
        kind: what kind of name was expected ("joint", "frame", …).
        name: the name given.
        valid: all valid names.
        nearest: the valid names most like it.

    Examples:
        >>> try:
        ...     nk.load_nao().unit("HeadYa")
        ... except nk.errors.UnknownName as error:
        ...     error.kind, error.nearest
        ('joint', ('HeadYaw', 'RHand', 'LHand'))
    """

    def __init__(self, kind: str, name: object, valid: Sequence[str], hint: str = "") -> None:
        self.kind, self.name, self.valid = kind, str(name), tuple(valid)
        # Of few valid names, all are listed if none is similar.
        self.nearest = nearest_names(self.name, valid, similar=0.5 if len(valid) > _FEW else 0.7)
        if self.nearest:
            advice = f"nearest: {', '.join(self.nearest)}"
        elif len(valid) <= 12:
            advice = f"valid: {', '.join(valid)}" if valid else "there are none"
        else:
            advice = f"{len(valid)} valid names, from {valid[0]} to {valid[-1]}"
        super().__init__(f"unknown {kind} {quoted(self.name)} ({abbreviated(advice)}){'; ' + hint if hint else ''}")


class BadArgument(NaoKinError):
    """An argument of the wrong kind or out of range; the message says which and why.

    Examples:
        >>> nk.load_nao().fk(np.zeros(25), "LArm", threads=0)
        Traceback (most recent call last):
            ...
        nao_kin.errors.BadArgument: threads must be at least 1, got 0
    """


# Expected shape, the last axes of what was given, and what takes that.
_WAYS: tuple[tuple[str, tuple[int, ...], str], ...] = (
    ("(..., 25)", (26,), "the 26 values of NAOqi's Body become q by nao.from_body"),
    ("(..., 3, 3)", (4, 4), "the rotation of a pose is T[..., :3, :3]"),
    ("(..., 3, 3)", (3,), "nk.rotations.exp takes a rotation vector, nk.ik.look_at a point"),
    ("(..., 3, 3)", (4,), "nk.rotations.matrix_from_quat takes a quaternion"),
    ("(..., 4, 4)", (3, 3), "nk.screws.pose makes one of a rotation and a translation"),
    ("(..., 4, 4)", (3,), "nk.ik.numeric takes a position alone"),
    ("(..., 4, 4) for poses or (..., 3) for positions", (3, 3), "nk.screws.pose makes a pose of a rotation"),
    ("(..., 4)", (3, 3), "nk.rotations.quat_from_matrix takes a rotation matrix"),
    ("(..., 6)", (4, 4), "nk.screws.log takes a pose"),
)


class WrongShape(NaoKinError):
    """An array of the wrong shape, or arrays whose batch shapes do not broadcast.

    Attributes:
        what: which argument.
        expected: the expected shape in words.
        got: the shape given.

    Examples:
        >>> nk.load_nao().fk([0.0, 0.1], "LArm")
        Traceback (most recent call last):
            ...
        nao_kin.errors.WrongShape: q must have shape (..., 25), got (2,)
    """

    def __init__(self, what: str, expected: str, got: tuple[int, ...] | str) -> None:
        self.what, self.expected, self.got = what, expected, got
        hint = next((f"; {way}" for there, ends, way in _WAYS if there == expected and got[-len(ends) :] == ends), "")
        super().__init__(f"{what} must have shape {expected}, got {got}{hint}")


class NotFinite(NaoKinError):
    """NaN or infinity in the input.

    Attributes:
        what: which argument.
        index: the index of the first such value.
        value: the value.
    """

    def __init__(self, what: str, index: tuple[int, ...], value: float, name: str = "") -> None:
        self.what, self.index, self.value = what, index, value
        super().__init__(f"{what} must be finite, got {value}{at_index(index)}{f' ({name})' if name else ''}")


class NotARotation(NaoKinError):
    """A matrix that is not orthogonal with determinant +1.

    Attributes:
        index: which matrix of the batch.
        determinant_defect: det R − 1.
        orthogonality_defect: largest absolute entry of RᵀR − 1.
    """

    def __init__(self, index: tuple[int, ...], determinant_defect: float, orthogonality_defect: float) -> None:
        self.index = index
        self.determinant_defect = determinant_defect
        self.orthogonality_defect = orthogonality_defect
        super().__init__(
            f"not a rotation matrix{at_index(index)}: det R − 1 = {determinant_defect:.3g}, "
            f"max |RᵀR − 1| = {orthogonality_defect:.3g}"
        )


class ZeroNorm(NaoKinError):
    """An axis, direction or quaternion of length zero, which determines no rotation or line.

    Attributes:
        what: which argument.
        index: which entry of the batch.
    """

    def __init__(self, what: str, index: tuple[int, ...] = ()) -> None:
        self.what, self.index = what, index
        super().__init__(f"{what} must not be zero{at_index(index)}")


class DegeneratePoints(NaoKinError):
    """Points that do not determine the result (coincident, collinear, too few)."""


class OutsideLimits(NaoKinError):
    """A configuration outside the joint limits.

    Attributes:
        violations: `LimitViolation` rows by configuration, the worst joint of each first; only those of the first
            configurations of a large batch.
        count: the number of all violations.

    Examples:
        >>> nk.load_nao().configuration({"HeadYaw": 3.0})
        Traceback (most recent call last):
            ...
        nao_kin.errors.OutsideLimits: outside the joint limits: HeadYaw = 3 not in [-2.08567, 2.08567] rad
    """

    def __init__(self, violations: Sequence[Any], count: int | None = None) -> None:
        self.violations = tuple(violations)
        self.count = len(self.violations) if count is None else count
        turned = any(row.unit == "rad" and abs(row.value) > 2.0 * math.pi for row in self.violations)
        super().__init__(self.describe() + ("; values are in radians" if turned else ""))

    def describe(self, *, degrees: bool = False) -> str:
        """Return the message, optionally with angles in degrees."""
        shown = [violation.describe(degrees=degrees) for violation in self.violations[:3]]
        more = f"; and {self.count - len(shown)} more" if self.count > len(shown) else ""
        return f"outside the joint limits: {'; '.join(shown)}{more}"


class CouplingViolated(NaoKinError):
    """Values of two joints of one motor that no position of the motor produces.

    Attributes:
        primary: name of the driving joint.
        mimic: name of the joint that follows it.
        primary_value: value given for the driving joint.
        mimic_value: value given for the joint that follows.
        expected: value of that joint for the given value of the driving joint.
        index: which configuration of the batch.

    Examples:
        >>> nk.load_nao().configuration({"LHipYawPitch": -0.2, "RHipYawPitch": -0.3})
        Traceback (most recent call last):
            ...
        nao_kin.errors.CouplingViolated: LHipYawPitch = -0.2 drives RHipYawPitch, ...
    """

    def __init__(
        self,
        primary: str,
        mimic: str,
        primary_value: float,
        mimic_value: float,
        expected: float,
        index: tuple[int, ...] = (),
    ) -> None:
        self.primary, self.mimic, self.index = primary, mimic, index
        self.primary_value, self.mimic_value, self.expected = primary_value, mimic_value, expected
        super().__init__(f"{self.describe()}{f' (configuration {_listed(index)})' if index else ''}")

    def describe(self, *, degrees: bool = False) -> str:
        """Return the message, optionally with the values as angles in degrees."""
        scale, unit = (math.degrees(1.0), "°") if degrees else (1.0, "")
        driver, value, wanted = (v * scale for v in (self.primary_value, self.mimic_value, self.expected))
        return (
            f"{self.primary} = {driver:.9g}{unit} drives {self.mimic}, which must then be {wanted:.9g}{unit}, "
            f"but {self.mimic} = {value:.9g}{unit} was given"
        )


class BadModel(NaoKinError):
    """A file from which no correct model can be made; the message names the file and the reason."""


class BadInputFile(NaoKinError):
    """A file of configurations, motions or settings that cannot be read.

    Attributes:
        path: the file, "-" for standard input.
        reason: why it cannot be read.
        line: the line of the error, from 1; 0 if the error is not in a single line.
        column: the column of the error, from 1; 0 if the error is not in a single column.
    """

    def __init__(self, path: str, reason: str, line: int = 0, column: int = 0) -> None:
        self.path, self.line, self.column, self.reason = path, line, column, reason
        name = "standard input" if path == "-" else path
        where = f", line {line}" if line else ""
        where += f", column {column}" if column else ""
        super().__init__(f"{name}{where}: {reason}")


class MissingExtra(NaoKinError, ImportError):
    """An optional package is needed, and is not installed or does not load; also an ImportError.

    Attributes:
        extra: the name to install, as in `pip install nao-kin[extra]`.
        reason: why it does not load though it is installed, or "".
    """

    def __init__(self, purpose: str, extra: str, reason: str = "") -> None:
        self.extra, self.reason = extra, reason
        super().__init__(missing(purpose, extra, reason))


class SingularMatrix(NaoKinError):
    """A matrix that has no inverse.

    Attributes:
        what: which matrix.
        index: which one of the batch.
    """

    def __init__(self, what: str, reason: str, index: tuple[int, ...] = ()) -> None:
        self.what, self.index = what, index
        super().__init__(f"{what} has no inverse{at_index(index)}: {reason}")


class DisagreeingJoints(CouplingViolated):
    """Joints of one motor whose values in a typed configuration belong to different motor positions.

    Attributes:
        nearest: value of the driving joint that gives the values nearest to those given.
        violations: what `MultiDofModel.violations` returns; the attributes above are those of the first.
    """

    def __init__(self, violations: Sequence[Any]) -> None:
        self.violations = tuple(violations)
        first = self.violations[0]
        values = first.primary_value, first.mimic_value, first.expected
        super().__init__(first.primary, first.mimic, *values, tuple(first.index))
        self.nearest = float(first.nearest)
        more = f"; and {len(self.violations) - 1} more" if len(self.violations) > 1 else ""
        where = f" (configuration {_listed(first.index)})" if first.index else ""
        nearest = f"nearest consistent: {first.primary} = {self.nearest:.9g}"
        NaoKinError.__init__(self, f"{self.describe()}; {nearest}{where}{more}")


class NoBrowser(NaoKinError):
    """A web browser is needed, but none is installed, or it did not start in time."""


class NotABatch(NaoKinError, TypeError):
    """A single value is iterated over as if it were a batch; also a TypeError."""


def _listed(index: Sequence[int]) -> str:
    return ", ".join(map(str, index))
