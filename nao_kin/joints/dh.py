"""Denavit–Hartenberg parameters of chains, classic and modified, with the transforms to the robot's own frames."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from fractions import Fraction
from typing import Any, Literal, TypeAlias

import numpy as np

from nao_kin._core.arrays import Floats, as_floats, choice
from nao_kin._core.text import html_table
from nao_kin._core.warn import need_extra
from nao_kin.errors import BadArgument
from nao_kin.robot import RobotModel
from nao_kin.rotations import log

DHConvention: TypeAlias = Literal["classic", "modified"]

# Sine between two axes up to which they are parallel, and distance up to which lines meet [m].
_PARALLEL, _MEETING = 1e-9, 1e-9
# Up to this sine they count as parallel if their common normal is farther away than the chain is long: files write π/2
# with six digits, which puts it kilometres away.
_ALMOST_PARALLEL = 1e-5
# What is nearer to a multiple of π/12 or to a root than this is written as such, and axes turned by less are as given.
_ROUNDING = 1e-12
# Random configurations at which a table is compared with `fk`: too few to wait for a kernel.
_COMPARED = 30


@dataclass(frozen=True, eq=False, repr=False)
class DHTable:
    """Denavit–Hartenberg parameters of the chain from a robot's root to a frame.

    With the values s of the joints, the pose of the frame in the root is T_root_frame = B A₁(s₁) … Aₙ(sₙ) E, with

    - classic: Aᵢ(s) = Rz(θᵢ + s) Tz(dᵢ) Tx(aᵢ) Rx(αᵢ),
    - modified (Craig): Aᵢ(s) = Rx(αᵢ) Tx(aᵢ) Rz(θᵢ + s) Tz(dᵢ), where Craig numbers these αᵢ₋₁ and aᵢ₋₁.

    A prismatic joint adds its value to d instead of θ. The constant B and E (`base` and `tool`) are part of every such
    description, because axes determine the frames of the convention only up to these.

    Attributes:
        robot: the robot's name.
        frame: the frame at the end of the chain.
        convention: "classic" or "modified".
        joints: names of the n joints, from the root outwards.
        kinds: "revolute" or "prismatic" for each.
        a: lengths of the common normals, shape (n,) [m].
        alpha: angles between the axes, shape (n,) [rad].
        d: distances of the normals along the axes, shape (n,) [m].
        theta: angles between the normals about the axes with all joints at zero, shape (n,) [rad].
        base: B = T_root_0, shape (4, 4) [m].
        tool: E = T_n_frame, shape (4, 4) [m].
        coordinates: index in q of the coordinate that moves each joint, shape (n,).
        multipliers: value of a joint per coordinate, shape (n,).
        offsets: value of a joint when its coordinate is zero, shape (n,) [rad, m].
        nq: number of the robot's coordinates.
        residual: largest difference between the product and the robot's `fk` in position and in rotation, at 30 random
            configurations, shape (2,) [m, rad]: rounding, unless axes that are almost parallel count as parallel.
        notes: which axes these are.

    Examples:
        >>> table = nk.joints.dh_table(nk.load_nao(), "LArm")
        >>> table.joints[0], table.alpha.round(4).tolist()
        ('LShoulderPitch', [1.5708, 1.5708, 1.5708, 1.5708, 0.0])
    """

    robot: str
    frame: str
    convention: DHConvention
    joints: tuple[str, ...]
    kinds: tuple[str, ...]
    a: Floats
    alpha: Floats
    d: Floats
    theta: Floats
    base: Floats
    tool: Floats
    coordinates: Any
    multipliers: Floats
    offsets: Floats
    nq: int
    residual: Floats
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for field in fields(self):
            if isinstance(value := getattr(self, field.name), np.ndarray):
                value.flags.writeable = False

    def fk(self, q: Any) -> Floats:
        """Return the pose of the frame in the root by the product of the table, shape (..., 4, 4) [m].

        Args:
            q: configurations of the robot, shape (..., nq).

        Raises:
            WrongShape: q is no configuration of this robot.

        Examples:
            >>> nao = nk.load_nao()
            >>> q = nao.posture("Crouch")
            >>> bool(np.allclose(nk.joints.dh_table(nao, "LLeg").fk(q), nao.fk(q, "LLeg"), atol=1e-12))
            True
        """
        array = as_floats(q, (self.nq,), "q")
        values = array[..., self.coordinates] * self.multipliers + self.offsets
        T = np.broadcast_to(self.base, (*values.shape[:-1], 4, 4))
        for i, kind in enumerate(self.kinds):
            turn = float(kind == "revolute")
            theta, d = self.theta[i] + turn * values[..., i], self.d[i] + (1.0 - turn) * values[..., i]
            rows = np.array(_link(self.convention, theta, d, self.a[i], self.alpha[i], np))
            T = T @ np.moveaxis(rows, (0, 1), (-2, -1))
        return np.asarray(T @ self.tool)

    def symbolic(self) -> Any:
        """Return the pose of the frame in the root as a matrix of SymPy, a function of the joints' names.

        The symbols are the values of the joints. Angles that are multiples of π/12, and numbers that are simple roots,
        are exact, so that sines and cosines of right angles vanish; other lengths are decimal.

        Raises:
            MissingExtra: SymPy is not installed.

        Examples:
            >>> T = nk.joints.dh_table(nk.load_nao(), "Head").symbolic()
            >>> T[0, 0]
            cos(HeadPitch)*cos(HeadYaw)
        """
        need_extra("symbolic forward kinematics", "symbolic")
        import sympy

        T = sympy.Matrix(4, 4, [_exact(value) for value in self.base.ravel()])
        for i, kind in enumerate(self.kinds):
            value = sympy.Symbol(self.joints[i], real=True)
            theta = _angle(self.theta[i]) + (value if kind == "revolute" else 0)
            d = _exact(self.d[i]) + (value if kind == "prismatic" else 0)
            rows = _link(self.convention, theta, d, _exact(self.a[i]), _angle(self.alpha[i]), sympy)
            T = T * sympy.Matrix(rows)
        return (T * sympy.Matrix(4, 4, [_exact(value) for value in self.tool.ravel()])).applyfunc(sympy.trigsimp)

    def as_dict(self) -> dict[str, Any]:
        """Return the table as plain lists, strings and numbers.

        Examples:
            >>> nk.joints.dh_table(nk.load_nao(), "Head").as_dict()["rows"][1]["joint"]
            'HeadPitch'
        """
        numbers = (column.tolist() for column in (self.a, self.alpha, self.d, self.theta))
        columns = zip(self.joints, self.kinds, *numbers, strict=True)
        return {
            "robot": self.robot,
            "frame": self.frame,
            "convention": self.convention,
            "rows": [dict(zip(("joint", "kind", "a", "alpha", "d", "theta"), row, strict=True)) for row in columns],
            "base": self.base.tolist(),
            "tool": self.tool.tolist(),
            "residual": {"position": float(self.residual[0]), "rotation": float(self.residual[1])},
            "notes": list(self.notes),
        }

    def as_latex(self) -> str:
        r"""Return the table as a `tabular` of LaTeX, then B and E; multiples of π/12 are written as such.

        Examples:
            >>> print(nk.joints.dh_table(nk.load_nao(), "LLeg").as_latex().splitlines()[5])
            LHipPitch & $0.1$ & $0$ & $0$ & $\pi$ \\
        """
        lines = [
            r"\begin{tabular}{lrrrr}",
            r"joint & $a$ [m] & $\alpha$ [rad] & $d$ [m] & $\theta$ [rad] \\",
            r"\hline",
        ]
        for joint, a, alpha, d, theta in zip(self.joints, self.a, self.alpha, self.d, self.theta, strict=True):
            cells = f"{a + 0.0:.6g}", _latex_angle(alpha), f"{d + 0.0:.6g}", _latex_angle(theta)
            lines.append(" & ".join([joint.replace("_", r"\_"), *(f"${cell}$" for cell in cells)]) + r" \\")
        matrices = []
        for name, T in (("B", self.base), ("E", self.tool)):
            rows = r" \\ ".join(" & ".join(f"{round(value, 6) + 0.0:g}" for value in row) for row in T.tolist())
            matrices.append(rf"{name} = \begin{{bmatrix}} {rows} \end{{bmatrix}}")
        return "\n".join([*lines, r"\end{tabular}", r"\[ " + r" \quad ".join(matrices) + r" \]"])

    def __repr__(self) -> str:
        return f"<DHTable {self.robot}, {self.frame}: {len(self.joints)} joints, {self.convention}>"

    def _repr_html_(self) -> str:
        head = ("joint", "a [m]", "α [rad]", "d [m]", "θ [rad]")
        numbers = (column.round(6).astype(str).tolist() for column in (self.a, self.alpha, self.d, self.theta))
        rows = zip(self.joints, *numbers, strict=True)
        return html_table(f"{self.robot}, {self.frame} ({self.convention})", head, rows)


def dh_table(robot: RobotModel, frame: str, convention: DHConvention = "classic") -> DHTable:
    """Return the Denavit–Hartenberg parameters of the chain from the root to a frame.

    Every chain of revolute and prismatic joints has them. Where they are not unique, d is zero between parallel axes,
    and the normal of an axis that coincides with the one before is the one before. Calibration offsets of joints change
    only θ, B and E, because they turn about the joints' own axes.

    Two roundings of π/2 in a file leave axes almost parallel, and their common normal kilometres away. Axes within
    1e-5 rad count as parallel if it is farther away than the chain is long: the second one is turned about its joint's
    origin. `notes` then say so, and `residual` says by how much the product differs from `fk`. Axes farther from
    parallel are never turned, and d and θ may be large.

    Args:
        robot: any robot; of a floating base the table begins at its base link.
        frame: the end of the chain.
        convention: "classic" (Denavit and Hartenberg, 1955) or "modified" (Craig, *Introduction to Robotics*, ch. 3).

    Raises:
        UnknownName: the robot has no such frame, or the convention does not exist.
        BadArgument: no joint moves the frame.

    Examples:
        >>> nao = nk.load_nao()
        >>> nk.joints.dh_table(nao, "LLeg", "modified")
        <DHTable nao_v6, LLeg: 6 joints, modified>
        >>> nk.joints.dh_table(nao, "LLeg").a.round(3).tolist()
        [0.0, 0.0, 0.1, 0.103, 0.0, 0.0]
    """
    choice(convention, ("classic", "modified"), "convention")
    row, T_joint_frame = robot.frame_placement(frame)
    joints = robot.joints
    rows = joints.path(row)
    if not rows:
        raise BadArgument(f"no joint moves {frame}")
    poses = [joints.placements[rows[0]]]
    for row in rows[1:]:
        poses.append(poses[-1] @ joints.placements[row])
    z = [T[:3, :3] @ joints.axes[row] for T, row in zip(poses, rows, strict=True)]
    p = [T[:3, 3] for T in poses]
    feet, normals, z, tilts = _normals(z, p, poses[0][:3, 0])
    n = len(rows)
    # On each axis: the feet of the normals from the axis before and to the next one.
    before = [feet[0][0] if feet else p[0], *(foot for _, foot in feet)]
    after = [*(foot for foot, _ in feet), before[-1]]
    x = [normals[0], *normals]
    # Between the axes i and i + 1, and along and about the axis i.
    a = np.array([*((g - f) @ x[i + 1] for i, (f, g) in enumerate(feet)), 0.0])
    alpha = np.array([*(_turn(z[i], z[i + 1], x[i + 1]) for i in range(n - 1)), 0.0])
    d = np.array([(after[i] - before[i]) @ z[i] for i in range(n)])
    following = [*x[1:n], x[n - 1]]
    theta = np.array([_turn(x[i], following[i], z[i]) for i in range(n)])
    base = _pose(x[0], z[0], before[0])
    end = _pose(following[-1], z[-1], after[-1])
    if convention == "modified":
        a, alpha = np.roll(a, 1), np.roll(alpha, 1)
    T_root_frame = poses[-1] @ T_joint_frame
    names = tuple(joints.names[row] for row in rows)
    table = DHTable(
        robot=robot.name,
        frame=frame,
        convention=convention,
        joints=names,
        kinds=tuple(joints.kinds[row] for row in rows),
        a=a + 0.0,
        alpha=alpha + 0.0,
        d=d + 0.0,
        theta=theta + 0.0,
        base=base,
        tool=np.asarray(np.linalg.solve(end, T_root_frame), dtype=np.float64),
        coordinates=joints.coordinates[rows],
        multipliers=joints.multipliers[rows],
        offsets=joints.offsets[rows],
        nq=robot.nq,
        residual=np.full(2, np.nan),
    )
    q = robot.random(0, _COMPARED)
    T, T_table = robot.fk(q, frame, reference=robot.tree.root), table.fk(q)
    apart = T_table[:, :3, 3] - T[:, :3, 3], log(T[:, :3, :3].swapaxes(-1, -2) @ T_table[:, :3, :3])
    residual = np.linalg.norm(apart, axis=-1).max(axis=-1)
    turned = [f"{joint} ({tilt:.1e} rad)" for joint, tilt in zip(names[1:], tilts, strict=True) if tilt > _ROUNDING]
    note = (
        f"axes almost parallel to the one before count as parallel: {', '.join(turned)}; "
        f"the product differs from fk by up to {residual[0]:.1e} m, {residual[1]:.1e} rad"
    )
    return replace(table, residual=residual, notes=(note,) if turned else ())


def _normals(
    axes: list[Floats], p: list[Floats], start: Floats
) -> tuple[list[tuple[Floats, Floats]], list[Floats], list[Floats], list[float]]:
    """Return the feet of the common normals of consecutive axes, on the first and the second, and their directions.

    A single axis has one direction, and no feet. The third result are the axes with almost parallel ones parallel to
    the axis before, and the fourth the sines of the angles by which they were turned.
    """
    feet: list[tuple[Floats, Floats]] = []
    normals: list[Floats] = []
    tilts: list[float] = []
    z, origin = list(axes), p[0]
    reach = sum(float(np.linalg.norm(q - r)) for q, r in zip(p[1:], p, strict=False)) + _MEETING
    for i in range(len(z) - 1):
        across = np.cross(z[i], z[i + 1])
        sine = float(np.linalg.norm(across))
        parallel = sine <= _PARALLEL
        if not parallel:
            n = across / sine
            # Points on the axes with the least distance: (p₁ + t z₁) − (p₀ + s z₀) is along n.
            s, t, _ = np.linalg.solve(np.column_stack((z[i], -z[i + 1], n)), p[i + 1] - p[i])
            f, g = p[i] + s * z[i], p[i + 1] + t * z[i + 1]
            x = -n if (g - f) @ n < -_MEETING else n
            parallel = sine <= _ALMOST_PARALLEL and max(abs(s), abs(t)) > reach
        if parallel:
            z[i + 1] = math.copysign(1.0, z[i] @ z[i + 1]) * z[i]
            f = p[i] + ((origin - p[i]) @ z[i]) * z[i]
            g = p[i + 1] + ((f - p[i + 1]) @ z[i + 1]) * z[i + 1]
            length = float(np.linalg.norm(g - f))
            before = normals[-1] if normals else _perpendicular(start, z[0])
            x = (g - f) / length if length > _MEETING else before
        tilts.append(sine if parallel else 0.0)
        feet.append((f, g))
        normals.append(x)
        origin = g
    if not normals:
        normals.append(_perpendicular(start, z[0]))
    return feet, normals, z, tilts


def _perpendicular(v: Floats, z: Floats) -> Floats:
    """Return the unit vector perpendicular to z nearest to v, or any if v is along z."""
    for candidate in (v, *np.eye(3)):
        rest = candidate - (candidate @ z) * z
        if (length := float(np.linalg.norm(rest))) > 0.1:
            return np.asarray(rest / length)
    raise AssertionError("one of three axes is not along z")


def _turn(start: Floats, end: Floats, axis: Floats) -> float:
    """Return the angle about an axis that turns one vector to another, both perpendicular to it."""
    return math.atan2(float(np.cross(start, end) @ axis), float(start @ end))


def _pose(x: Floats, z: Floats, origin: Floats) -> Floats:
    T = np.eye(4)
    T[:3] = np.column_stack((x, np.cross(z, x), z, origin))
    return T


def _link(convention: str, theta: Any, d: Any, a: Any, alpha: Any, math_of: Any) -> list[list[Any]]:
    """Return the rows of Aᵢ, from numbers or symbols."""
    c, s, ca, sa = math_of.cos(theta), math_of.sin(theta), math_of.cos(alpha), math_of.sin(alpha)
    zero, one = 0 * c * d, 0 * c * d + 1
    if convention == "classic":
        return [
            [c, -s * ca, s * sa, a * c + zero],
            [s, c * ca, -c * sa, a * s + zero],
            [zero, sa + zero, ca + zero, d + zero],
            [zero, zero, zero, one],
        ]
    return [
        [c + zero, -s + zero, zero, a + zero],
        [s * ca + zero, c * ca + zero, -sa + zero, -sa * d + zero],
        [s * sa + zero, c * sa + zero, ca + zero, ca * d + zero],
        [zero, zero, zero, one],
    ]


def _exact(value: float) -> Any:
    """Return a number for SymPy: a simple root if it is one."""
    import sympy

    for root in (sympy.Integer(0), sympy.Integer(1), sympy.sqrt(2) / 2, sympy.Rational(1, 2), sympy.sqrt(3) / 2):
        for sign in (1, -1):
            if abs(value - float(sign * root)) <= _ROUNDING:
                return sign * root
    return sympy.Float(value)


def _twelfths(value: float) -> int | None:
    """Return how many π/12 an angle is; None if it is no multiple."""
    nearest = round(value / (math.pi / 12))
    return nearest if abs(value - nearest * math.pi / 12) <= _ROUNDING else None


def _angle(value: float) -> Any:
    """Return an angle for SymPy: a multiple of π/12 if it is one."""
    import sympy

    exact = _twelfths(value)
    return sympy.Float(value) if exact is None else sympy.Rational(exact, 12) * sympy.pi


def _latex_angle(value: float) -> str:
    """Return an angle [rad] in LaTeX: a multiple of π/12 if it is one."""
    exact = _twelfths(value)
    if not exact:
        return f"{value + 0.0:.6g}" if exact is None else "0"
    times, over = Fraction(abs(exact), 12).as_integer_ratio()
    return f"{'-' if exact < 0 else ''}{times if times > 1 else ''}\\pi{f'/{over}' if over > 1 else ''}"
