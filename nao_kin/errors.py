"""What can go wrong, one class per kind.

Every error of the library derives from `NaoKinError`, prints as one line that names what was wrong, what was expected
and the nearest valid names, and carries the values as attributes so that a program can act on them.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable, Sequence
from typing import Any

from nao_kin._core.extras import missing
from nao_kin._core.text import MOST_ECHOED, abbreviated, quoted

__all__ = [
    "BadArgument",
    "BadInputFile",
    "BadModel",
    "CouplingViolated",
    "DegeneratePoints",
    "DegreesWarning",
    "DisagreeingJoints",
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
    "OutsideLimits",
    "RenamedFrameWarning",
    "SingularMatrix",
    "StartedOverWarning",
    "UnknownName",
    "WrongShape",
    "ZeroNorm",
    "nearest_names",
]


class NaoKinWarning(UserWarning):
    """Base of all warnings of nao_kin: what was asked is done, and is likely not what was meant.

    Examples:
        >>> issubclass(nk.errors.DegreesWarning, nk.errors.NaoKinWarning)
        True
    """


class DegreesWarning(NaoKinWarning):
    """Joint values that make sense as degrees, where radians are expected.

    Examples:
        >>> import warnings
        >>> with warnings.catch_warnings(record=True) as caught:
        ...     warnings.simplefilter("always")
        ...     _ = nk.load_nao().fk(np.full(25, 45.0), "LArm")
        >>> caught[0].category.__name__
        'DegreesWarning'
    """


class RenamedFrameWarning(NaoKinWarning):
    """A frame is asked for by a name that a link of the URDF and a joint share: the joint's frame answers.

    Examples:
        >>> issubclass(nk.errors.RenamedFrameWarning, UserWarning)
        True
    """


class MissingShapeWarning(NaoKinWarning):
    """Shapes of links are left out of a geometry model, because their meshes are missing or cannot be read.

    Examples:
        >>> issubclass(nk.errors.MissingShapeWarning, nk.errors.NaoKinWarning)
        True
    """


class NotCachedWarning(NaoKinWarning):
    """Compiled kernels cannot be kept on disk; every process compiles them anew.

    Examples:
        >>> issubclass(nk.errors.NotCachedWarning, nk.errors.NaoKinWarning)
        True
    """


class NotCompiledWarning(NaoKinWarning):
    """Much is asked at once where Numba, which would compile it, is not installed: the answer comes, slower.

    Examples:
        >>> issubclass(nk.errors.NotCompiledWarning, nk.errors.NaoKinWarning)
        True
    """


class StartedOverWarning(NaoKinWarning):
    """A run that was to go on from an earlier one begins at the beginning, for what it depends on has changed.

    Examples:
        >>> issubclass(nk.errors.StartedOverWarning, nk.errors.NaoKinWarning)
        True
    """


class NaoKinError(Exception):
    """Base of all errors raised by nao_kin; one line, whatever names from outside hold.

    Examples:
        >>> try:
        ...     nk.load_nao("v7")
        ... except nk.NaoKinError as error:
        ...     print(error)
        unknown NAO version 'v7' (nearest: v6, v5, v4)
    """

    def __init__(self, message: str = "") -> None:
        super().__init__(" ".join(message.split()))

    def __reduce__(self) -> tuple[Any, ...]:
        # Errors are built from several values and must still come back from another process.
        return _revived, (type(self), self.args, self.__dict__)


def _revived(kind: type[NaoKinError], args: tuple[Any, ...], state: dict[str, Any]) -> NaoKinError:
    error = kind.__new__(kind)
    error.args = args
    error.__dict__.update(state)
    return error


def at_index(index: Sequence[int]) -> str:
    """Where in a batch something stands, to follow a word of a message: " at index [2, 0]"; "" outside a batch."""
    return f" at index {list(index)}" if index else ""


def nearest_names(name: str, valid: Iterable[str], count: int = 3) -> tuple[str, ...]:
    """The valid names that look most like `name`, best first; letter case counts for nothing.

    Examples:
        >>> nk.errors.nearest_names("lhnd", ["LHand", "RHand", "LLeg"])
        ('LHand', 'RHand')
    """
    name = name[:MOST_ECHOED]
    by_lower: dict[str, list[str]] = {}
    for candidate in valid:
        by_lower.setdefault(candidate.lower(), []).append(candidate)
    close = difflib.get_close_matches(name.lower(), list(by_lower), n=count, cutoff=0.5)
    return tuple(candidate for lower in close for candidate in by_lower[lower])[:count]


class UnknownName(NaoKinError):
    """A joint, frame, posture, version, sequence … that does not exist.

    Attributes:
        kind: what the name should have named ("joint", "frame", …).
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
        self.nearest = nearest_names(self.name, valid)
        if self.nearest:
            advice = f"nearest: {', '.join(self.nearest)}"
        elif len(valid) <= 12:
            advice = f"valid: {', '.join(valid)}" if valid else "there are none"
        else:
            advice = f"{len(valid)} valid names, from {valid[0]} to {valid[-1]}"
        super().__init__(f"unknown {kind} {quoted(self.name)} ({abbreviated(advice)}){'; ' + hint if hint else ''}")


class BadArgument(NaoKinError):
    """An argument whose value makes no sense; the message says which and why.

    Examples:
        >>> nk.load_nao().fk(np.zeros(25), "LArm", threads=0)
        Traceback (most recent call last):
            ...
        nao_kin.errors.BadArgument: threads must be at least 1, got 0
    """


class WrongShape(NaoKinError):
    """An array of the wrong shape, or arrays whose batch shapes do not fit together.

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
        super().__init__(f"{what} must have shape {expected}, got {got}")


class NotFinite(NaoKinError):
    """NaN or infinity in the input.

    Attributes:
        what: which argument.
        index: where the first such value stands.
        value: the value.

    Examples:
        >>> nk.rotations.rot_x([0.0, float("nan")])
        Traceback (most recent call last):
            ...
        nao_kin.errors.NotFinite: angle must be finite, got nan at index [1]
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

    Examples:
        >>> nk.rotations.log(2 * np.eye(3))
        Traceback (most recent call last):
            ...
        nao_kin.errors.NotARotation: not a rotation matrix: det R − 1 = 7, max |RᵀR − 1| = 3
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
    """An axis, direction or quaternion of length zero, which names no rotation or line.

    Attributes:
        what: which argument.
        index: which entry of the batch.

    Examples:
        >>> nk.rotations.matrix_from_quat([0, 0, 0, 0])
        Traceback (most recent call last):
            ...
        nao_kin.errors.ZeroNorm: quaternion must not be zero
    """

    def __init__(self, what: str, index: tuple[int, ...] = ()) -> None:
        self.what, self.index = what, index
        super().__init__(f"{what} must not be zero{at_index(index)}")


class DegeneratePoints(NaoKinError):
    """Points that do not determine what was asked of them (coincident, collinear, too few).

    Examples:
        >>> nk.rotations.rotation_from_points(np.zeros((3, 3)), np.zeros((3, 3)))
        Traceback (most recent call last):
            ...
        nao_kin.errors.DegeneratePoints: points before lie on one line ...
    """


class OutsideLimits(NaoKinError):
    """A configuration outside the joint limits.

    Attributes:
        violations: `LimitViolation` rows by configuration, the worst joint of each first; of a large batch, the first.
        count: how many there are in all.

    Examples:
        >>> nk.load_nao().configuration({"HeadYaw": 3.0})
        Traceback (most recent call last):
            ...
        nao_kin.errors.OutsideLimits: outside the joint limits: HeadYaw = 3 not in [-2.08567, 2.08567] rad
    """

    def __init__(self, violations: Sequence[Any], count: int | None = None) -> None:
        self.violations = tuple(violations)
        self.count = len(self.violations) if count is None else count
        super().__init__(self.describe())

    def describe(self, *, degrees: bool = False) -> str:
        """The message, with angles in degrees if wanted."""
        shown = [violation.describe(degrees=degrees) for violation in self.violations[:3]]
        more = f"; and {self.count - len(shown)} more" if self.count > len(shown) else ""
        return f"outside the joint limits: {'; '.join(shown)}{more}"


class CouplingViolated(NaoKinError):
    """Two joints that one motor drives were given values that no motor position produces.

    Attributes:
        primary: name of the driving joint.
        mimic: name of the joint that follows it.
        primary_value: value given for the driving joint.
        mimic_value: value given for the joint that follows.
        expected: value the driving joint asks of it.
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
        """The message, with the values taken for angles and given in degrees if wanted."""
        scale, unit = (math.degrees(1.0), "°") if degrees else (1.0, "")
        driver, value, wanted = (v * scale for v in (self.primary_value, self.mimic_value, self.expected))
        return (
            f"{self.primary} = {driver:.9g}{unit} drives {self.mimic}, which must then be {wanted:.9g}{unit}, "
            f"but {self.mimic} = {value:.9g}{unit} was given"
        )


class BadModel(NaoKinError):
    """A URDF from which no correct model can be made; the message names the file and the reason.

    Examples:
        >>> nk.RobotModel.from_urdf("no_such.urdf")
        Traceback (most recent call last):
            ...
        nao_kin.errors.BadModel: cannot read ...no_such.urdf: No such file or directory
    """


class BadInputFile(NaoKinError):
    """A file of configurations that cannot be read.

    Attributes:
        path: the file, "-" for standard input.
        line: 1-based line, 0 when no line is to blame.
        column: 1-based column, 0 when no column is to blame.

    Examples:
        >>> nk.stream.read_configurations(nk.load_nao(), "no_such.csv")
        Traceback (most recent call last):
            ...
        nao_kin.errors.BadInputFile: no_such.csv: cannot be read: No such file or directory
    """

    def __init__(self, path: str, reason: str, line: int = 0, column: int = 0) -> None:
        self.path, self.line, self.column, self.reason = path, line, column, reason
        name = "standard input" if path == "-" else path
        where = f", line {line}" if line else ""
        where += f", column {column}" if column else ""
        super().__init__(f"{name}{where}: {reason}")


class MissingExtra(NaoKinError, ImportError):
    """An optional package is needed, and is absent or does not load; an ImportError too, as Python raises.

    Attributes:
        extra: the name to install, as in `pip install nao-kin[extra]`.
        reason: why it does not load though it is installed; "" where it is not.

    Examples:
        >>> str(nk.errors.MissingExtra("a table", "arrow")).partition(";")[0]
        "a table needs pyarrow: pip install 'nao-kin[arrow]'"
    """

    def __init__(self, purpose: str, extra: str, reason: str = "") -> None:
        self.extra, self.reason = extra, reason
        super().__init__(missing(purpose, extra, reason))


class SingularMatrix(NaoKinError):
    """A matrix that has no inverse.

    Attributes:
        what: which matrix.
        index: which one of the batch.

    Examples:
        >>> nk.rotations.rank_one.inverse([1.0, 0.0, 0.0], [-1.0, 0.0, 0.0])
        Traceback (most recent call last):
            ...
        nao_kin.errors.SingularMatrix: 1 + u vᵀ has no inverse: u·v = −1
    """

    def __init__(self, what: str, reason: str, index: tuple[int, ...] = ()) -> None:
        self.what, self.index = what, index
        super().__init__(f"{what} has no inverse{at_index(index)}: {reason}")


class DisagreeingJoints(CouplingViolated):
    """Joints of one motor whose values in a typed configuration belong to different motor positions.

    Attributes:
        nearest: value of the driving joint that, with what follows from it, is nearest to the two values given.
        violations: the `CouplingViolation` rows; the attributes above are those of the first.

    Examples:
        >>> issubclass(nk.errors.DisagreeingJoints, nk.errors.CouplingViolated)
        True
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
    """A web browser is needed and there is none, or none has shown up in time.

    Examples:
        >>> issubclass(nk.errors.NoBrowser, nk.NaoKinError)
        True
    """


class NotABatch(NaoKinError, TypeError):
    """A single value is iterated over as if it were a batch; also a TypeError, as Python's own iteration raises.

    Examples:
        >>> issubclass(nk.errors.NotABatch, TypeError)
        True
    """


def _listed(index: Sequence[int]) -> str:
    return ", ".join(map(str, index))
