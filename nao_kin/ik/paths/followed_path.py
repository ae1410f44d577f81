"""`FollowedPath`: a joint trajectory along a path of targets, and what is to be said about it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from nao_kin._common.arrays import Floats, as_floats
from nao_kin.errors import BadArgument
from nao_kin.ik.paths.branch_choice import Choice
from nao_kin.ik.paths.jumps import Jump
from nao_kin.ik.paths.time_scaling import Stretch, between_samples
from nao_kin.ik.results import Codes, Reason
from nao_kin.rotations import quat_from_xyzw, quat_to_xyzw, slerp

_BASE = 7
# How many of each kind a message lists.
_LISTED = 3


@dataclass(frozen=True, eq=False)
class FollowedLimb:
    """What one limb does at n samples.

    Attributes:
        name: "LLeg", "RLeg", "legs" for both, "LArm", "RArm" or "Head".
        columns: the coordinates of q that it moves.
        reasons: a `Reason` for each sample as a number, shape (n,).
        residual: errors of the pose in position and rotation angle, shape (n, 2) [m, rad]; nan without values.
        messages: why, for each sample that is not reached.

    Examples:
        >>> nao = nk.load_nao()
        >>> path = np.linspace([0.15, 0.12, 0.0], [0.15, 0.12, 0.05], 5)
        >>> result = nk.ik.follow(nao, {"LArm": path})
        >>> result.limbs[0].name, result.limbs[0].reasons.tolist()
        ('LArm', [0, 0, 0, 0, 0])
    """

    name: str
    columns: tuple[int, ...]
    reasons: Codes
    residual: Floats
    messages: Mapping[int, str]

    @property
    def reached(self) -> NDArray[np.bool_]:
        """Which samples are reached, shape (n,)."""
        return np.asarray(self.reasons == Reason.REACHED)


@dataclass(frozen=True, eq=False)
class FollowedPath:
    """A joint trajectory along a path of n samples.

    Attributes:
        joint_names: the joints in the order of q, after the seven numbers of a floating base.
        times: of the samples, shape (n,) [s]; equal where nothing moves and no times were given.
        q: configurations, shape (n, nq). Where a sample is not reached the limb is at the nearest pose, if its solver
            offers one, else its joints are nan.
        torso: the pose of the torso in the world, shape (n, 4, 4); None where targets are in the torso.
        limbs: what each limb does.
        jumps: where a limb cannot move continuously, in order.
        stretched: segments that take longer than was asked, in order.
        speed_shares: speed of each joint in each segment as a share of its limit, shape (n − 1, joints).
        motion: the sum over the path of the squared motion Σ (Δq_j / v_j)² of the limbs that follow it [s²].
        notes: what else is to be said, one line each.

    Examples:
        >>> nao = nk.load_nao()
        >>> path = np.linspace([0.15, 0.12, 0.0], [0.15, 0.12, 0.05], 5)
        >>> result = nk.ik.follow(nao, {"LArm": path})
        >>> result.q.shape, bool(result.success)
        ((5, 25), True)
    """

    joint_names: tuple[str, ...]
    times: Floats
    q: Floats
    torso: Floats | None
    limbs: tuple[FollowedLimb, ...]
    jumps: tuple[Jump, ...]
    stretched: tuple[Stretch, ...]
    speed_shares: Floats
    motion: float
    notes: tuple[str, ...]

    @property
    def duration(self) -> float:
        """From the first sample to the last [s]."""
        return float(self.times[-1] - self.times[0])

    @property
    def reached(self) -> NDArray[np.bool_]:
        """Samples whose targets are all reached, shape (n,)."""
        return np.asarray(np.logical_and.reduce([limb.reached for limb in self.limbs]))

    @property
    def reasons(self) -> Mapping[str, Codes]:
        """Limb → a `Reason` for each sample as a number, shape (n,)."""
        return MappingProxyType({limb.name: limb.reasons for limb in self.limbs})

    @property
    def success(self) -> bool:
        """Whether all targets are reached, and without a jump."""
        return bool(self.reached.all()) and not self.jumps

    @property
    def largest_speed_share(self) -> float:
        """The largest joint speed as a share of its limit; 0 where nothing moves."""
        return float(self.speed_shares.max(initial=0.0))

    @property
    def message(self) -> str:
        """What came of it, in words."""
        n = len(self.times)
        reached = int(np.count_nonzero(self.reached))
        lines = [f"{reached} of {n} {'sample' if n == 1 else 'samples'} reached in {self.duration:.4g} s"]
        for limb in self.limbs:
            if limb.messages:
                first, text = next(iter(limb.messages.items()))
                count = len(limb.messages)
                more = f" and {count - 1} more" if count > 1 else ""
                lines.append(f"{limb.name} does not reach sample {first}{more}: {text}")
        lines.extend([_some([jump.describe() for jump in self.jumps])] if self.jumps else [])
        lines.extend([_some([segment.describe() for segment in self.stretched])] if self.stretched else [])
        return "; ".join([*lines, *self.notes])

    def sampled(self, fps: float = 30.0) -> Floats:
        """Configurations at equal steps of time, as `Viewer.animate` plays them.

        Joints and the place of the base are interpolated linearly, the orientation of the base by slerp. A limb without
        values at some samples moves from the sample before them to the one behind them.

        Args:
            fps: configurations per second.

        Returns:
            Shape (m, nq); the last is that of the last sample, which may be less than a step after the one before.

        Raises:
            BadArgument: no positive number, or a limb has no values at any sample.

        Examples:
            >>> nao = nk.load_nao()
            >>> path = np.linspace([0.15, 0.12, 0.0], [0.15, 0.12, 0.05], 5)
            >>> result = nk.ik.follow(nao, {"LArm": path})
            >>> result.sampled(fps=100).shape[1]
            25
        """
        rate = positive(fps, "fps")
        q = between_samples(self.q)
        if np.isnan(q).any():
            empty = next(limb.name for limb in self.limbs if np.isnan(q[0, list(limb.columns)]).any())
            raise BadArgument(f"{empty} has no values at any sample: {self.message}")
        if len(q) == 1:
            return q
        steps = max(0, int(np.ceil(self.duration * rate - 1e-9)))
        times = np.minimum(self.times[0] + np.arange(steps + 1) / rate, self.times[-1])
        after = np.clip(np.searchsorted(self.times, times, side="right"), 1, len(self.times) - 1)
        start, width = self.times[after - 1], self.times[after] - self.times[after - 1]
        share = np.divide(times - start, width, out=np.ones_like(times), where=width > 0.0)
        found = q[after - 1] + share[:, None] * (q[after] - q[after - 1])
        if q.shape[1] > len(self.joint_names):
            turn = slice(_BASE - 4, _BASE)
            first, second = quat_from_xyzw(q[after - 1, turn]), quat_from_xyzw(q[after, turn])
            found[:, turn] = quat_to_xyzw(slerp(first, second, share))
        return np.asarray(found)

    def __repr__(self) -> str:
        limbs = ", ".join(limb.name for limb in self.limbs)
        return f"<FollowedPath of {limbs}: {self.message}>"


def followed_limb(name: str, choice: Choice) -> FollowedLimb:
    """What a limb does, as its choice of branches has it."""
    return FollowedLimb(name, choice.columns, choice.reasons, choice.residual, dict(choice.messages))


def positive(value: float, what: str) -> float:
    """One number above zero.

    Raises:
        BadArgument, WrongShape, NotFinite: it is none.
    """
    array = as_floats(value, (), what)
    if array.shape != () or not array > 0.0:
        raise BadArgument(f"{what} must be a number above zero, got {value}")
    return float(array)


def _some(texts: list[str]) -> str:
    more = f" and {len(texts) - _LISTED} more" if len(texts) > _LISTED else ""
    return "; ".join(texts[:_LISTED]) + more
