"""Which posture to observe next."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import Floats, choice, whole_number
from nao_kin._core.text import quoted
from nao_kin.calibration.observations import Pixels
from nao_kin.calibration.solve import Calibration
from nao_kin.calibration.unknowns import names_of
from nao_kin.errors import BadArgument

_MOST_RANDOM = 100_000


@dataclass(frozen=True)
class NextPosture:
    """The posture whose observation would shrink the uncertainty of the offsets most.

    Attributes:
        q: the configuration, shape (nq,).
        gain: by how much the logarithm of the volume of the offsets' uncertainty shrinks, ½ log det Σ/Σ′, of each
            candidate, shape (candidates,).
        index: which candidate q is.
        standard_deviations: of the offsets after observing it, by label.
    """

    q: Floats
    gain: Floats
    index: int
    standard_deviations: dict[str, float]


def next_posture(
    calibration: Calibration,
    candidates: ArrayLike | None = None,
    *,
    joints: Iterable[str] | None = None,
    count: int = 500,
    rng: np.random.Generator | int | None = None,
) -> NextPosture:
    """Return the posture whose observation would shrink the uncertainty of the offsets most (D-optimality).

    In every candidate posture, the items of each observation so far would be seen again with the same noise, as far as
    the camera has them in its image; other bodies may hide them. The covariance Σ of all unknowns becomes
    Σ′ = (Σ⁻¹ + Jᵀ J)⁻¹ with the whitened Jacobian J of what would be seen. The gain is ½ log det Σ/Σ′ of the offsets.

    Args:
        calibration: the result so far.
        candidates: configurations, shape (m, nq); None for random ones inside the limits.
        joints: which joints are random; the others stay as in the first posture observed. None for those that differed
            between the observed postures.
        count: how many random candidates.
        rng: a generator, or a seed for one.

    Raises:
        BadArgument: no candidate shows anything; no joint moved so far, and none is named; candidates of `Contacts` are
            not given: random postures do not stand.

    Examples:
        >>> nao = nk.load_nao()
        >>> q = nao.random(rng=0, n=5)
        >>> seen = nk.calibration.Poses(q, "LArm", nao.fk(q, "LArm"))
        >>> found = nk.calibration.calibrate(nao, [seen], joints=["LShoulderRoll", "LElbowRoll"])
        >>> best = nk.calibration.next_posture(found, rng=0)
        >>> best.gain.shape, bool(best.gain[best.index] == best.gain.max())
        ((500,), True)
    """
    if not isinstance(calibration, Calibration):
        raise BadArgument(f"expected a Calibration, as calibrate returns it, got {quoted(calibration)}")
    problem, robot = calibration._problem, calibration.robot
    free = [i for i, label in enumerate(calibration.labels) if label not in calibration.held]
    if not free:
        raise BadArgument("all offsets are held at zero: observe more first")
    if candidates is None:
        if any(one.kind == "contacts" for one in problem.observations):
            raise BadArgument("random postures do not stand on both soles: give candidates")
        q = _random(calibration, joints, whole_number(count, "count", 1, _MOST_RANDOM), rng)
    else:
        q = robot.checked(candidates).reshape(-1, robot.nq)
        if not len(q):
            raise BadArgument("candidates must have at least one configuration")
    state = problem.unknowns.at(calibration._x)
    rows = []
    for one in problem.observations:
        seen = one.measure(state, q, True)
        J = seen.J.copy()
        if isinstance(one.given, Pixels):
            J[~one.given.camera.sees(seen.residuals * one.given.noise)] = 0.0
        rows.append(J.reshape(len(q), -1, problem.size))
    J = np.concatenate(rows, axis=1)
    if not J.any():
        raise BadArgument("no candidate shows any of what was observed; try more, or other joints")
    # With Σ = L Lᵀ, Σ′ = L (1 + Lᵀ Jᵀ J L)⁻¹ Lᵀ; numbers held at zero stay there.
    values, vectors = np.linalg.eigh(calibration._covariance)
    L = vectors * np.sqrt(np.maximum(values, 0.0))
    M = np.eye(problem.size) + np.swapaxes(J @ L, -1, -2) @ (J @ L)
    after = L[free] @ np.linalg.solve(M, np.broadcast_to(L[free].T, (len(q), problem.size, len(free))))
    now = np.linalg.slogdet(calibration.covariance[np.ix_(free, free)])[1]
    gain = 0.5 * (now - np.linalg.slogdet(after)[1])
    best = int(gain.argmax())
    deviations = np.sqrt(np.diagonal(after[best])).tolist()
    return NextPosture(q[best], gain, best, dict(zip([calibration.labels[i] for i in free], deviations, strict=True)))


def _random(calibration: Calibration, joints: Iterable[str] | None, count: int, rng: Any) -> Floats:
    robot = calibration.robot
    observed = np.concatenate([one.q for one in calibration._problem.observations])
    first = robot.nq_base
    if joints is None:
        places = [first + i for i in np.flatnonzero(np.ptp(observed[:, first:], axis=0) > 0.0).tolist()]
        if not places:
            raise BadArgument("no joint differed between the observed postures: name joints=…, or give candidates")
    else:
        chosen = (choice(name, robot.joint_names, "joint") for name in names_of(joints, "joints"))
        places = [first + robot.joint_names.index(name) for name in chosen]
    q = np.repeat(observed[:1], count, axis=0)
    q[:, places] = robot.random(rng, count)[:, places]
    return q
