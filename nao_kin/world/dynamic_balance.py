"""Balance of a moving robot: its zero-moment point, how surely it is known, and whether the robot rocks or falls.

A robot that plays a given motion on a rigid floor begins to tip where its zero-moment point leaves the support polygon.
The motion of the joints is taken as given: no motors, no slipping, no impacts.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import TOUCHING, Floats, as_floats, check_tolerance, rigid_inverse
from nao_kin._core.text import one_line_repr
from nao_kin._kernels.cache import Ints1
from nao_kin._kernels.hulls import hulls
from nao_kin.errors import BadArgument
from nao_kin.robot import Feet, RobotModel, SetDown
from nao_kin.world.balance import balance, on_floor
from nao_kin.world.legs import GRAVITY, LegLog, Legs, centre_of_pressure
from nao_kin.world.momenta import momenta, momentum_jacobians
from nao_kin.world.rest import Mask
from nao_kin.world.rocking import Edges, rocking

# Accelerations are means over this time [s]: motors and gears do not follow the corners of a motion any faster. Of
# noisy joint values they are means over more, up to _LONGEST, until the zero-moment point is known to _SURE [m].
_OVER, _LONGEST, _SURE = 0.1, 0.4, 0.005
# Times are even if their steps differ by this share and time [s]. A step is a gap if it takes longer than _OVER and
# this many usual ones: across gaps nothing is interpolated.
_EVEN, _GAP = (1e-3, 1e-6), 2.5
# Samples that have an acceleration.
_FEWEST = 5
# Rows whose momentum is computed at once, which takes 20 KB a row.
_AT_ONCE = 4096
# Directions of edges, seen by the robot.
EDGES = ("front", "left", "back", "right")


@one_line_repr
@dataclass(frozen=True, eq=False)
class DynamicBalance:
    """Balance of a robot during a motion of n samples, each in the world of `set_down`.

    Samples in which the robot does not stand on its soles, as when it sits or lies, have NaN, and −1 as `edge`; so
    have those in a part of less than five samples between gaps. Where the robot would leave the floor, because the
    motion needs a force that pulls at it (F_z ≤ 0), no zero-moment point exists: `margin` is −∞, so that it is the
    least one, and `edge` the one about which the robot turns most. Where the robot stands on an edge or a corner of its
    soles alone, it falls at any speed: both margins are −∞, and `edge` is −1.

    Attributes:
        times: shape (n,) [s].
        down: the robot set down in each sample: poses, and what touches.
        com: centre of mass, shape (n, 3) [m].
        com_margin: signed distance of the centre of mass, seen from above, from the edge of the support polygon,
            positive inside, shape (n,) [m]: the margin of a robot that stands still.
        zmp: zero-moment point on the floor, shape (n, 2) [m]; where the soles' sensors carry, their centre of pressure.
        margin: its signed distance from the edge of the support polygon, positive inside, shape (n,) [m].
        deviation: standard deviation of `margin` by the noise of the joint values, shape (n,) [m].
        edge: index in `EDGES` of the edge nearest to the zero-moment point, as the robot sees it, shape (n,).
        rocking: tilt about an edge of the soles, with which a rigid robot follows the motion, shape (n,) [rad]; 0 where
            it stands flat. The last sample has the largest tilt also of 1.5 s after the motion.
        notes: what was assumed about times, contacts and forces.
    """

    times: Floats
    down: SetDown
    com: Floats
    com_margin: Floats
    zmp: Floats
    margin: Floats
    deviation: Floats
    edge: NDArray[np.intp]
    rocking: Floats
    notes: tuple[str, ...] = ()

    # Of robots that tilt farther about an edge of their soles few come back [rad] (docs/balance.md).
    FALLS: ClassVar[float] = math.radians(5.0)

    @property
    def stands(self) -> NDArray[np.bool_]:
        """In which samples the robot stands on its soles, shape (n,)."""
        return np.asarray(~np.isnan(self.margin))

    @property
    def falls(self) -> NDArray[np.bool_]:
        """In which samples the robot tilts by more than `FALLS`, 5°, from which few robots come back, shape (n,)."""
        return np.asarray(self.rocking > self.FALLS)


def dynamic_balance(
    robot: RobotModel,
    q: ArrayLike,
    times: ArrayLike,
    *,
    soles: Sequence[str] | str | None = None,
    contacts: ArrayLike | None = None,
    forces: ArrayLike | None = None,
    joint_noise: float = 0.0,
) -> DynamicBalance:
    """Return the zero-moment point of a motion and its distance from the edge of the support polygon.

    With the mass m, the centre of mass c, its acceleration a, the rate of the angular momentum about it L̇ and gravity
    g, the ground's force F = m (a + g e_z) has no moment about a horizontal axis at

        x = c_x − (F_x c_z + L̇_y) / F_z,   y = c_y − (F_y c_z − L̇_x) / F_z.

    Accelerations are means over 0.1 s (a filter of Savitzky and Golay of third degree),
    because motors and gears do not follow the corners of a motion any faster. Samples at uneven times, as in a log or
    at the end of a sampled motion, are interpolated at even ones between them.

    The support polygon is that of `balance`. A sole that touches the floor is in place: of several, the one
    that touches it for the longest time before and after.

    Args:
        robot: any robot whose semantics name soles, or for which `soles` does.
        q: configurations, shape (n, nq), at least 0.1 s of them.
        times: of the n samples, ascending; of samples with one time the first counts [s].
        soles: frames of the soles on the floor, as in `balance`.
        contacts: whether each sole touches the floor, shape (n, s), as far as they are not odd, as in `odometry`.
        forces: force on each sole or sensor, as `contacts`.
        joint_noise: standard deviation of each measured joint value [rad or its unit], 0.0017 (0.1°) for a NAO. It is
            independent from row to row, and accelerations are means over more than 0.1 s, up to 0.4 s, until it moves
            the zero-moment point by 5 mm or less.

    Raises:
        BadArgument: times that go back, fewer than five samples without a gap, a robot without mass or soles.
        WrongShape: arrays of different lengths.

    Source: Vukobratović and Borovac, Zero-moment point: thirty five years of its life, 2004.

    Examples:
        >>> nao = nk.load_nao()
        >>> times = 0.01 * np.arange(100)
        >>> lean = nao.posture("Stand", LAnklePitch=-0.1 * np.sin(8 * times), RAnklePitch=-0.1 * np.sin(8 * times))
        >>> found = nk.world.dynamic_balance(nao, lean, times, soles=nao.semantics.soles)
        >>> bool(found.margin.min() < found.com_margin.min())
        True
    """
    log = LegLog.of(Legs(robot, soles), times, robot.checked(q), contacts, forces, _OVER)
    given, ground = log.rows.own, log.ground
    rows, moments = log.q[given], as_floats(log.moments[given], (len(given),), "times")
    measured = None if ground.rule == "joints" else log.carrying[given]
    rest = balance(robot, rows, soles=soles, contacts=measured)
    support, acceleration, moment = _lasting(rest.down.touching), *np.full((2, len(rows), 3), np.nan)
    T_base_soles = rigid_inverse(rest.T_sole_base)
    T_world_soles = rest.down.T_world_base[:, None] @ T_base_soles
    R_world_sole = T_world_soles[np.arange(len(rows)), support, :3, :3]
    parts, covariance = _parts(moments, log.notes), np.zeros((len(rows), 2, 2))
    check_tolerance(joint_noise, "joint_noise")
    noise = None if joint_noise == 0.0 else _noise(robot, rows, rest.down, support, joint_noise)
    for part in parts:
        even, step = _even(moments[part])
        q_even = np.column_stack([np.interp(even, moments[part], column) for column in rows[part].T])
        window = min(2 * round(0.5 * max(_OVER / step, 4.0)) + 1, len(even) - 1 + len(even) % 2)
        while noise is not None:
            covariance[part] = _covariance(noise[part], rest.com[part, 2], window, step)
            unsure = np.sqrt(np.median(covariance[part].trace(axis1=1, axis2=2)) / 2.0) > _SURE
            if not unsure or window + 2 > min(len(even), _LONGEST / step + 1.0):
                break
            window += 2
        for sole in np.unique(support[part]):
            own = np.arange(len(rows))[part][support[part] == sole]
            T_sole_base = rigid_inverse(np.asarray(robot.fk(q_even, rest.down.soles[sole], reference=robot.tree.root)))
            found = _rates(robot, q_even, T_sole_base, step, (moments[own] - even[0]) / step, window)
            for rates, of_sole in zip((acceleration, moment), found, strict=True):
                rates[own] = np.einsum("nij,nj->ni", R_world_sole[own], of_sole)
    mass = robot.mass
    lever = mass * acceleration[:, :2] * rest.com[:, 2:] + np.stack([moment[:, 1], -moment[:, 0]], axis=-1)
    weight = mass * (GRAVITY + acceleration[:, 2])
    # Where the floor would have to pull, the line without moment is that of the whole force, but no point of the floor.
    weight = np.where(np.abs(weight) > 1e-9 * mass * GRAVITY, weight, -1e-9 * mass * GRAVITY)
    zmp, flies = rest.com[:, :2] - lever / weight[:, None], weight < 0.0
    if ground.rule == "forces" and ground.sensors is not None:
        T = rest.down.T_world_base[:, None] @ log.T_base_soles[given]
        centre = centre_of_pressure(T, ground.pressed[given], log.pressure[given])
        felt: Mask = np.asarray(np.isfinite(centre).all(axis=1))
        zmp, flies = np.where(felt[:, None], centre, zmp), flies & ~felt
        lever = weight[:, None] * (rest.com[:, :2] - zmp)
        covariance[felt] = 0.0
        log.notes.append("the zero-moment point is the centre of pressure of the force sensors")
    supported = np.isfinite(rest.margin)
    stands = rest.down.touching.any(axis=1) & (supported | rest.down.stands) & np.isfinite(zmp).all(axis=1)
    feet = Feet.of(robot, rest.down.soles)
    stands &= ~feet.others(robot, rest.down.links).any(axis=1)
    stands &= (ground.known & ground.stands)[given]
    lost = stands & ~supported  # on an edge or a corner of its soles
    vertices, distances, margin, nearest = hulls(rest.vertices, np.where(stands[:, None], zmp, 0.0))
    zmp[~stands | flies | lost] = np.nan
    moments_about = np.where(np.isfinite(distances), weight[:, None] * distances, np.inf)
    nearest = np.where(flies, moments_about.argmin(axis=1), nearest)
    R_robot_world = rest.T_robot_base[:, :3, :3] @ rest.down.T_world_base[:, :3, :3].swapaxes(1, 2)
    rocks = np.full(len(rows), np.nan)
    placed = feet.placed(T_world_soles)
    carrying, corners = on_floor(rest.down, feet, placed, TOUCHING), np.einsum("nij,nkj->nki", R_robot_world, placed)
    turned = [np.einsum("nij,nj->ni", R_robot_world[:, :2, :2], vector) for vector in (rest.com[:, :2], lever)]
    force = np.where(stands, weight, np.nan)
    edges = Edges.of(corners, carrying, turned[0], force, turned[1])
    for part in parts:
        own = Edges(*(array[part] for array in edges))
        rocks[part] = rocking(moments[part], own, force[part], rest.com[part, 2], mass)
    outwards = _outwards(vertices, nearest)
    with np.errstate(invalid="ignore"):
        outwards = outwards / np.linalg.norm(outwards, axis=1, keepdims=True)
    deviation = np.sqrt(np.einsum("ni,nij,nj->n", outwards, covariance, outwards))
    ahead, left = np.einsum("nij,nj->in", R_robot_world[:, :2, :2], outwards)
    quarter = np.round(np.nan_to_num(np.arctan2(left, ahead)) / (0.5 * np.pi)).astype(np.intp) % 4
    return DynamicBalance(
        times=moments,
        down=rest.down,
        com=rest.com,
        com_margin=np.where(stands, np.where(lost, -np.inf, rest.margin), np.nan),
        zmp=zmp,
        margin=np.where(stands, np.where(flies | lost, -np.inf, margin), np.nan),
        deviation=np.where(stands, deviation, np.nan),
        edge=np.where(stands & ~lost, quarter, -1),
        rocking=rocks,
        notes=tuple(log.notes),
    )


def _parts(moments: Floats, notes: list[str]) -> list[slice]:
    """Return the slices of times (n,) between gaps that have enough samples; note gaps and uneven times."""
    steps = np.diff(moments)
    if len(steps) + 1 < _FEWEST:
        raise BadArgument(f"a motion has at least five samples, got {len(moments)}")
    usual = float(np.median(steps))
    gaps = np.flatnonzero(steps > max(_OVER, _GAP * usual) + _EVEN[1]) + 1
    parts = [slice(*ends) for ends in itertools.pairwise([0, *gaps.tolist(), len(moments)])]
    used = [part for part in parts if part.stop - part.start >= _FEWEST]
    if not used:
        raise BadArgument(f"of times with {len(gaps)} gaps, none has at least five samples before the next")
    if len(gaps):
        left = len(moments) - sum(part.stop - part.start for part in used)
        notes.append(
            f"times have {len(gaps)} gaps, up to {steps.max():.3g} s; {left} samples between them are left out"
        )
    inside = [np.diff(np.unique(moments[part]))[:-1] for part in used]
    if any(len(own) and np.ptp(own) > 2.0 * (_EVEN[1] + _EVEN[0] * usual) for own in inside):
        least, most = (1e3 * end(np.concatenate(inside)) for end in (np.min, np.max))
        notes.append(f"times are uneven, {least:.3g} to {most:.3g} ms apart: interpolated every {1e3 * usual:.3g} ms")
    return used


def _even(moments: Floats) -> tuple[Floats, float]:
    """Return even times from the first of given ones on, and their step."""
    span = moments[-1] - moments[0]
    step = min(float(np.median(np.diff(np.unique(moments)))), span / (_FEWEST - 1))
    return moments[0] + step * np.arange(int(span / step + _EVEN[0]) + 1), step


def _lasting(touching: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Return which of s soles touches the floor, and for the longest time before and after, shapes (n, s) and (n,)."""
    rows = np.arange(len(touching))[:, None]
    before = np.maximum.accumulate(np.where(touching, -np.inf, rows))
    after = np.minimum.accumulate(np.where(touching, np.inf, rows)[::-1])[::-1]
    return np.asarray(np.minimum(rows - before, after - rows).argmax(axis=1))


def _rates(
    robot: RobotModel, rows: Floats, T_world_base: Floats, step: float, at: Floats, window: int
) -> tuple[Floats, Floats]:
    """Return the acceleration of the centre of mass, and the rate of the angular momentum about it, shapes (m, 3).

    `at` are m places among the n rows, which are a step apart.
    """
    n, blocks = len(rows), []
    for first in range(0, n, _AT_ONCE):
        # Differences in time need one row more on both sides.
        part = slice(max(first - 1, 0), min(first + _AT_ONCE + 1, n))
        kept = slice(first - part.start, first - part.start + _AT_ONCE)
        blocks.append([array[kept] for array in momenta(robot, rows[part], T_world_base[part], step)])
    com, about_origin = (np.concatenate(arrays) for arrays in zip(*blocks, strict=True))
    momentum = about_origin - robot.mass * np.cross(com, np.gradient(com, step, axis=0))
    return _derivative(com, 2, window, step, at), _derivative(momentum, 1, window, step, at)


def _derivative(values: Floats, order: int, window: int, step: float, at: Floats) -> Floats:
    """Return derivatives of values (n, 3) at m places among them by cubics through windows of samples, shape (m, 3).

    At the ends they are those of the first and the last window.

    Source: Savitzky and Golay, Smoothing and differentiation of data, 1964.
    """
    half, fit = window // 2, _cubic(window)
    cubics = np.lib.stride_tricks.sliding_window_view(values, window, axis=0) @ fit.T
    middle = np.clip(np.round(at).astype(np.intp), half, len(values) - 1 - half)
    away, slopes = (at - middle)[:, None], cubics[middle - half]
    for _ in range(order):
        slopes = slopes[..., 1:] * np.arange(1, slopes.shape[-1])
    powers = away ** np.arange(slopes.shape[-1])
    return np.asarray((slopes * powers[:, None]).sum(axis=-1) / step**order)


def _cubic(window: int) -> Floats:
    """Return the coefficients of the cubic through a window of samples by their values, shape (degree + 1, window)."""
    half = window // 2
    return np.asarray(np.linalg.pinv(np.vander(np.arange(-half, half + 1), min(3, window - 1) + 1, increasing=True)))


def _noise(robot: RobotModel, rows: Floats, down: SetDown, support: NDArray[np.intp], joint_noise: float) -> Floats:
    """Return how the noise of each joint moves the centre of mass, and the lever of the angular momentum.

    They are x and y of the one [m], and (L_y, −L_x)/(m g) of the other [m s²], shape (n, 2, 2, nv).
    """
    noise = np.empty((len(rows), 2, 2, robot.nv))
    for sole in np.unique(support):
        every = np.flatnonzero(support == sole)
        for own in np.split(every, range(_AT_ONCE, len(every), _AT_ONCE)):
            of_centre, of_momentum = momentum_jacobians(robot, rows[own], down.T_world_base[own], down.soles[sole])
            noise[own, 0] = joint_noise * of_centre[:, :2]
            noise[own, 1] = joint_noise / (robot.mass * GRAVITY) * of_momentum[:, [1, 0]] * [[1.0], [-1.0]]
    return noise


def _covariance(noise: Floats, height: Floats, window: int, step: float) -> Floats:
    """Return the covariance of the zero-moment point for noise (n, 2, 2, nv) that is independent from row to row.

    The point is that of the weights of the rows in x − (height / g) x″ and in the lever's rate, shape (n, 2, 2).
    """
    fit = _cubic(window)
    rate = np.convolve(fit[1], [-0.5, 0.0, 0.5]) / step**2  # of the lever, a mean rate of its integral
    point = -np.multiply.outer(height / GRAVITY, np.pad(2.0 * fit[2], 1) / step**2)
    point[:, window // 2 + 1] += 1.0
    A, B = (point**2).sum(axis=1), rate @ rate
    a, b = noise[:, 0], noise[:, 1]
    mixed = a @ b.swapaxes(1, 2)
    both = (point @ rate)[:, None, None] * (mixed + mixed.swapaxes(1, 2))
    return np.asarray(A[:, None, None] * a @ a.swapaxes(1, 2) - both + B * b @ b.swapaxes(1, 2))


def _outwards(vertices: Floats, edges: Ints1) -> Floats:
    """Return outward directions of one edge of each polygon (n, e, 2), by the vertex at which it begins (n,)."""
    rows, count = np.arange(len(vertices)), np.isfinite(vertices[..., 0]).sum(axis=1)
    along = vertices[rows, (edges + 1) % np.maximum(count, 1)] - vertices[rows, edges]
    return np.stack([along[:, 1], -along[:, 0]], axis=-1)
