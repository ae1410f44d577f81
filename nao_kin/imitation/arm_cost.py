"""The cost of an arm's configurations for a person's directions, and its descent inside the joint limits.

With the elbow at (e_x, e_y, 0) in the robot's upper arm and κ = atan2(e_y, e_x), the upper arm u, the forearm f and the
back of the hand b are, in the torso,

    u = Ry(q₁) Rz(q₂) Rz(κ) x,  f = Ry(q₁) Rz(q₂) Rx(q₃) Rz(q₄) x,  b = Ry(q₁) Rz(q₂) Rx(q₃) Rz(q₄) Rx(q₅) z.

With those of the person, û, f̂, b̂, the place p̂ of their hand, and the robot's lengths l of upper arm and forearm, a
path of frames i costs

    Σ w_u |u − û|² + w_f |f − f̂|² + w_b |b − b̂|² + w_p |l_u u + l_f f − p̂|² / (l_u + l_f)² + Σ_j W_ij (q_ij − q_i−1,j)².

`descend` finds a local minimum by Gauss-Newton steps with damping (Levenberg 1944, Marquardt 1963), of a whole path or
of many frames by themselves. Joints that the gradient presses against a limit stay there, and steps end at limits.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats

# A path is at its minimum if no joint moves by more than this [rad], or the cost sinks by less than this share of it;
# the most rounds until there.
_AT_MINIMUM, _LEAST_GAIN, _NOTHING, _ROUNDS = 1e-8, 1e-9, 1e-14, 40
# The least damping, that after a first worse step, the factors after better and worse steps, and the damping with which
# nothing becomes better.
_LEAST_DAMPING, _DAMPING, _BETTER, _WORSE, _STUCK = 1e-9, 1e-3, 0.1, 10.0, 1e6
# Which of five joints move upper arm, forearm and back of the hand, shape (5, 3, 1).
_MOVES = np.array([[1, 1, 1], [1, 1, 1], [0, 1, 1], [0, 1, 1], [0, 0, 1]])[:, :, None]
# Indices of a cross product.
_NEXT, _LAST = [1, 2, 0], [2, 0, 1]
_AHEAD, _ACROSS, _UP = np.eye(3)


class Paths(NamedTuple):
    """The numbers of the cost of m paths, each of n frames of one arm.

    `targets` are û, f̂, b̂ and p̂ / (l_u + l_f); `roots` are square roots of their weights, `pull` is W.
    """

    tilt: Floats  # κ, shape (m, 1)
    share: Floats  # l_u / (l_u + l_f), shape (m, 1)
    lower: Floats  # shape (m, 1, 5)
    upper: Floats
    targets: Floats  # shape (m, n, 4, 3)
    roots: Floats  # shape (m, n, 4)
    pull: Floats  # shape (m, n, 5)
    before: Floats  # q of the frame before the first one, shape (m, 5)

    def only(self, rows: NDArray[np.intp]) -> Paths:
        """Return some of the paths."""
        return Paths(*(part[rows] for part in self))

    def errors(self, vectors: Floats) -> Floats:
        """Return the weighted differences of u, f, b (m, n, 3, 3) from the four targets, shape (m, n, 12)."""
        share = self.share[..., None, None]
        hand = share * vectors[..., :1, :] + (1.0 - share) * vectors[..., 1:2, :]
        made = np.concatenate([vectors, hand], axis=-2)
        return np.reshape((made - self.targets) * self.roots[..., None], (*self.roots.shape[:-1], 12))

    def frame_costs(self, q: Floats) -> Floats:
        """Return the cost of each frame without its step, shape (m, n)."""
        return np.asarray((self.errors(vectors_and_axes(q, self.tilt)[0]) ** 2).sum(axis=-1))

    def quadratic(self, q: Floats) -> tuple[Floats, Floats, Floats]:
        """Return the cost of each path (m,), half its gradient (m, n, 5), and the Gauss-Newton matrices of frames.

        The matrices have the shape (m, n, 5, 5); that of the whole path has −W between a frame and the one before.
        """
        vectors, axes = vectors_and_axes(q, self.tilt)
        errors, steps = self.errors(vectors), np.diff(q, axis=1, prepend=self.before[:, None])
        pulls = self.pull * steps
        costs = (errors**2).sum(axis=(1, 2)) + (pulls * steps).sum(axis=(1, 2))
        a, v = axes[..., :, None, :], vectors[..., None, :, :]
        turned = np.empty((*q.shape, 4, 3))
        turned[..., :3, :] = (a[..., _NEXT] * v[..., _LAST] - a[..., _LAST] * v[..., _NEXT]) * _MOVES
        share = self.share[..., None, None]
        turned[..., 3, :] = share * turned[..., 0, :] + (1.0 - share) * turned[..., 1, :]
        J = (turned * self.roots[..., None, :, None]).reshape(*q.shape, 12)
        g = (J @ errors[..., None])[..., 0] + pulls
        g[:, :-1] -= pulls[:, 1:]
        H = J @ np.swapaxes(J, -1, -2)
        diagonal = np.einsum("...ii->...i", H)
        diagonal += self.pull
        diagonal[:, :-1] += self.pull[:, 1:]
        return np.asarray(costs), g, H


def vectors_and_axes(q: Floats, tilt: Floats) -> tuple[Floats, Floats]:
    """Return u, f and b in the torso, shape (..., 3, 3), and the axes of the five joints, shape (..., 5, 3)."""
    s, c = np.sin(q)[..., None], np.cos(q)[..., None]

    def turned(a: Floats, b: Floats, k: int) -> tuple[Floats, Floats]:
        """Return the first two axes of a frame that turns about the third one by the joint k."""
        return c[..., k, :] * a + s[..., k, :] * b, c[..., k, :] * b - s[..., k, :] * a

    z, ahead = turned(_UP, _AHEAD, 0)
    x, y = turned(ahead, _ACROSS, 1)
    side, normal = turned(y, z, 2)
    f, across = turned(x, side, 3)
    b = turned(across, normal, 4)[1]
    vectors, axes = np.empty((*q.shape[:-1], 3, 3)), np.empty((*q.shape[:-1], 5, 3))
    tilt = tilt[..., None]
    vectors[..., 0, :], vectors[..., 1, :], vectors[..., 2, :] = np.cos(tilt) * x + np.sin(tilt) * y, f, b
    axes[..., 0, :], axes[..., 1, :], axes[..., 2, :], axes[..., 3, :], axes[..., 4, :] = _ACROSS, z, x, normal, f
    return vectors, axes


def _solved(A: Floats, L: Floats, b: Floats) -> Floats:
    """Return x (m, n, 5) of L_i x_i−1 + A_i x_i + L_i+1ᵀ x_i+1 = b_i, by cyclic reduction: those with even i first.

    This halves n with few operations on large arrays (Golub and Van Loan, Matrix Computations, 4.5.4).
    """
    n = A.shape[1]
    if n == 1:
        return np.asarray(np.linalg.solve(A, b[..., None])[..., 0])
    if n % 2 == 0:
        A, L, b = (np.concatenate([part, 0.0 * part[:, :1]], axis=1) for part in (A, L, b))
        A[:, -1] = np.eye(5)
    inverse, b_even, L_odd, L_even = np.linalg.inv(A[:, ::2]), b[:, ::2, :, None], L[:, 1::2], L[:, 2::2]
    left, right = L_odd @ inverse[:, :-1], np.swapaxes(L_even, -1, -2) @ inverse[:, 1:]
    A_odd = A[:, 1::2] - left @ np.swapaxes(L_odd, -1, -2) - right @ L_even
    L_new = -left @ np.concatenate([0.0 * L_even[:, :1], L_even[:, :-1]], axis=1)
    x = _solved(A_odd, L_new, b[:, 1::2] - (left @ b_even[:, :-1] + right @ b_even[:, 1:])[..., 0])[..., None]
    rest = np.array(b_even)
    rest[:, :-1] -= np.swapaxes(L_odd, -1, -2) @ x
    rest[:, 1:] -= L_even @ x
    made = np.empty(b.shape)
    made[:, 1::2], made[:, ::2] = x[..., 0], (inverse @ rest)[..., 0]
    return made[:, :n]


def descend(paths: Paths, q: Floats, rounds: int = _ROUNDS) -> Floats:
    """Return paths inside the limits at local minima of the cost, from q, shape (m, n, 5)."""
    q, todo = np.clip(q, paths.lower, paths.upper), np.arange(len(q))
    some, now, damping = paths, q, np.full(len(q), _LEAST_DAMPING)
    cost, g, H = paths.quadratic(q)
    for _ in range(rounds):
        free = ~(((now <= some.lower) & (g > 0.0)) | ((now >= some.upper) & (g < 0.0)))
        A, L = H * (free[..., :, None] & free[..., None, :]), np.zeros_like(H)
        np.einsum("...ii->...i", A)[:] += damping[:, None, None] + ~free
        np.einsum("...ii->...i", L)[:, 1:] = -some.pull[:, 1:] * (free[:, 1:] & free[:, :-1])
        new = np.clip(now + _solved(A, L, -g * free), some.lower, some.upper)
        values = some.quadratic(new)
        better = values[0] <= cost
        ended = np.where(better, cost - values[0] <= _LEAST_GAIN * cost + _NOTHING, damping > _STUCK)
        ended |= np.abs(new - now).max(axis=(1, 2)) < _AT_MINIMUM
        q[todo[better]] = new[better]
        damping = np.maximum(damping * np.where(better, _BETTER, _WORSE), np.where(better, _LEAST_DAMPING, _DAMPING))
        left = np.flatnonzero(~ended)
        if not len(left):
            break
        cost, g, H = (
            np.where(better.reshape(-1, *[1] * (old.ndim - 1)), made, old)[left]
            for made, old in zip(values, (cost, g, H), strict=True)
        )
        todo, some, damping = todo[left], some.only(left), damping[left]
        now = q[todo]
    return q
