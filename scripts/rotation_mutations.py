"""Faults of the rotations beyond their conversions: wrong signs, missing branches, wrong weights."""

from __future__ import annotations

from mutation import faults

ROTATIONS = (
    *faults(
        "rotations/_checks.py",
        "test_rotations_checks.py",
        ("nearly-rotations-projected-by-half", "- 0.5 * xx, d", "- 0.25 * xx, d"),
        ("nearly-rotations-not-projected", "            entries = _projected(f, entries, defects[1:])\n", ""),
        ("exact-rotations-projected-with-their-neighbours", "f.where(exact, 0.0, defect)", "defect"),
    ),
    *faults(
        "rotations/_exponential.py",
        "test_rotations_powers.py",
        ("angle-between-of-the-product", "a[i] * b[j] + a[3 + i] * b[3 + j]", "a[i] * b[j] + a[3 + j] * b[3 + i]"),
    ),
    *faults(
        "rotations/_quat_powers.py",
        "test_rotations_powers.py",
        ("a-whole-turn-about-no-axis", "f.where(theta >= math.pi, f.where(", "f.where(theta > 4.0, f.where("),
        ("length-forgotten-in-the-logarithm", "0.5 * f.log(square)", "0.0 * f.log(square)"),
    ),
    *faults(
        "rotations/_quaternions.py",
        "test_rotations_powers.py",
        ("a-quaternion-turns-backwards", "x + r0 * tx + (r2", "x - r0 * tx + (r2"),
    ),
    *faults(
        "rotations/_slerp.py",
        "test_rotations_paths.py",
        ("longer-arc-to-the-wrong-side", "f.where(sine == 0.0, -1.0, -sine)", "f.where(sine == 0.0, 1.0, sine)"),
        ("longer-arc-as-long-as-the-shorter", "f.atan2(sine, -1.0 - shift)", "f.atan2(sine, 1.0 + shift)"),
    ),
    *faults(
        "rotations/_continuity.py",
        "test_rotations_paths.py",
        ("signs-of-a-path-not-handed-on", "np.cumprod(flips, axis=0)", "flips"),
        ("quaternion-half-a-turn-away-flipped", "inner[..., np.newaxis] < 0.0", "inner[..., np.newaxis] <= 0.0"),
    ),
    *faults(
        "rotations/_spline_velocities.py",
        "test_rotations_paths.py",
        (
            "acceleration-without-what-the-jacobian-changes",
            "            + turning_acceleration(arcs",
            "            - 0.0 * turning_acceleration(arcs",
        ),
        ("spline-left-after-one-step", "_SHORT_STEP = 1e-9", "_SHORT_STEP = 1e-1"),
        ("newton-without-the-bend", "straight + bent", "straight"),
        ("odd-keys-without-their-right-neighbour", " - by[..., 3:6] @ following", ""),
    ),
    *faults(
        "_common/turn_coefficients.py",
        "test_rotations_jacobians.py test_screws_exponential.py test_screws_jacobians.py",
        ("series-of-the-jacobians-too-short", "_TERMS = 11", "_TERMS = 8"),
        ("closed-forms-for-small-turns", "_NEAR = math.pi**2", "_NEAR = 1e-8"),
        ("series-for-turns-past-a-half", "_NEAR = math.pi**2", "_NEAR = 100.0"),
        ("derivative-of-the-jacobian-wrong-near-zero", "3.0 * c5 - c4", "3.0 * c5 + c4"),
        ("derivative-of-the-jacobian-wrong-past-a-half", "(B - 3.0 * C) / x", "(B - 2.0 * C) / x"),
        ("second-derivative-of-the-inverse-jacobian", "8.0 * c6 - 5.0 * c5 + c4", "8.0 * c6 - 5.0 * c5 - c4"),
        ("whole-turns-from-far-away", "WHOLE_TURN = 4.0 * 2.0**-52", "WHOLE_TURN = 2.0**-20"),
        ("whole-turns-inverted", "WHOLE_TURN = 4.0 * 2.0**-52", "WHOLE_TURN = 2.0**-56"),
    ),
    *faults(
        "rotations/_jacobians.py",
        "test_rotations_jacobians.py",
        ("left-jacobian-for-right", "return _left(f, 0.0 - x, 0.0 - y, 0.0 - z)", "return _left(f, x, y, z)"),
        ("inverse-at-a-whole-turn-let-through", "np.abs(opening) <= WHOLE_TURN", "np.abs(opening) < 0.0"),
    ),
    *faults(
        "rotations/_rates.py",
        "test_rotations_jacobians.py",
        ("rates-in-the-moving-frame-not-reversed", "i, k, sign = k, i, -sign", "i, k, sign = k, i, sign"),
        ("rates-of-fixed-axes-in-the-wrong-order", "convention.reversed == body", "not body"),
        ("lock-of-the-rates-let-through", "np.abs(determinant) <= LOCK", "np.abs(determinant) < 0.0"),
        ("rates-along-the-last-axis-with-the-wrong-sign", "(cb, 0.0 - s * sb) if", "(cb, s * sb) if"),
        (
            "lock-of-the-other-kind-named",
            'if convention.symmetric else "cos β = 0"',
            'if not convention.symmetric else "cos β = 0"',
        ),
    ),
    *faults(
        "rotations/_mrp.py",
        "test_rotations_mrp.py",
        (
            "shadow-of-the-parameters-of-the-same-sign",
            "np.asarray(-(direction / square)",
            "np.asarray((direction / square)",
        ),
        ("half-the-angle-in-the-parameters", "divisor = 1.0 + r0", "divisor = r0"),
        ("matrix-of-the-parameters-transposed", "4.0 * quotient * (1.0 - square)", "-4.0 * quotient * (1.0 - square)"),
        ("shadow-that-overflows-let-through", "if not finite.all():", "if False:"),
        ("long-parameters-taken-for-short", "largest(parameters) > 1.0", "largest(parameters) < 0.0"),
    ),
    *faults(
        "rotations/_weights.py",
        "test_rotations_means.py test_rotations_directions.py",
        ("weights-not-shares-of-one", "scaled / scaled.sum(axis=-1, keepdims=True)", "scaled"),
    ),
    *faults(
        "rotations/_mean.py",
        "test_rotations_means.py",
        ("mean-left-at-the-chordal-one", '    if method == "geodesic":', '    if method == "":'),
        ("mean-stepping-away", "mean = mean @ exp(step)", "mean = mean @ exp(-step)"),
        ("mean-in-the-fixed-frame", "mean = mean @ exp(step)", "mean = exp(step) @ mean"),
        (
            "covariance-without-weights",
            "np.swapaxes(shares[..., np.newaxis] * arms, -1, -2)",
            "np.swapaxes(arms, -1, -2)",
        ),
        ("mean-left-early", "_LAST_STEP, _SHORT_STEP = 1e-15, 1e-12", "_LAST_STEP, _SHORT_STEP = 1e-6, 1e-6"),
    ),
    *faults(
        "rotations/_random.py",
        "test_rotations_means.py",
        (
            "random-quaternions-of-a-cube",
            "standard_normal((*_sizes(shape), count))",
            "uniform(-1, 1, (*_sizes(shape), count))",
        ),
        ("scatter-in-the-fixed-frame", "sizes), 3, 3) @ turns)", "sizes), 3, 3).swapaxes(-1, -2) @ turns)"),
        (
            "one-scatter-for-all",
            "standard_normal((*batch, *sizes, 3))",
            "standard_normal((*(1 for _ in batch), *sizes, 3))",
        ),
    ),
    *faults(
        "rotations/_directions.py",
        "test_rotations_directions.py",
        ("opposite-directions-not-told", "_OPPOSITE = 4.0 * 2.0**-52", "_OPPOSITE = -1.0"),
        ("opposite-directions-told-too-early", "_OPPOSITE = 4.0 * 2.0**-52", "_OPPOSITE = 1e-7"),
        ("normal-always-from-the-difference", "np.where(near, difference, total)", "difference"),
        (
            "weights-without-their-roots",
            "roots = np.sqrt(np.broadcast_to(shares, (*batch, count)))",
            "roots = (np.broadcast_to(shares, (*batch, count)))",
        ),
        ("half-turn-about-the-nearest-axis", "np.abs(first).argmin(axis=-1)", "np.abs(first).argmax(axis=-1)"),
        ("residual-without-weights", "residual = norm(roots[..., 0] * apart)", "residual = norm(apart)"),
        ("angles-left-by-the-chord", "2.0 * np.arctan2(apart, norm(B + turned))", "apart"),
    ),
    *faults(
        "rotations/_nearest_angles.py",
        "test_rotations_few_axes.py",
        ("lean-of-two-axes-forgotten", "x * n0 + y * n1 + z * n2 - r0 * cosine", "x * n0 + y * n1 + z * n2"),
        ("angles-of-fixed-axes-not-turned-round", 'if axes == "fixed" else angles', "if False else angles"),
        ("residual-halved", "4.0 * f.atan2(f.sqrt(apart)", "2.0 * f.atan2(f.sqrt(apart)"),
        ("parallel-axes-let-through", "norm(cross(*units)) <= _PARALLEL", "norm(cross(*units)) < 0.0"),
        ("angles-not-wrapped", "f.where(angle > math.pi, 2.0", "f.where(angle > 3.0 * math.pi, 2.0"),
    ),
    *faults(
        "rotations/_davenport.py",
        "test_rotations_few_axes.py",
        (
            "side-of-each-of-many-axes-forgotten",
            "second, delta = side[..., np.newaxis] * second, side * delta",
            "second, delta = 1.0 * second, side * delta",
        ),
    ),
    *faults(
        "rotations/_spline.py",
        "test_rotations_paths.py",
        ("spline-that-ends-before-its-last-key", "instants > self.times[-1]", "instants >= self.times[-1]"),
        (
            "velocity-at-the-end-with-the-other-jacobian",
            "right_jacobian_inverse(arcs) @",
            "right_jacobian_inverse(-arcs) @",
        ),
        (
            "acceleration-without-what-turns",
            "_times(right_jacobian(v), second) + turning_acceleration(v, rate)",
            "_times(right_jacobian(v), second)",
        ),
        ("velocity-in-the-frame-of-the-key", "place, :, :], _times(exp(v), moving))", "place, :, :], moving)"),
    ),
    *faults(
        "rotations/_skew.py",
        "test_rotations_jacobians.py",
        ("vector-of-one-triangle", "half[..., 2, 1] - half[..., 1, 2], half", "2.0 * half[..., 2, 1], half"),
        ("skew-symmetric-to-an-absolute-bound", "if (symmetric > TOLERANCE * largest)", "if (symmetric > TOLERANCE)"),
    ),
    *faults(
        "_common/vectors.py",
        "test_common_vectors.py",
        ("largest-of-two-components", "in range(1, v.shape[-1])", "in range(1, min(2, v.shape[-1]))"),
        ("unit-of-the-smallest-floats-infinite", "np.minimum(-exponent, 1023)", "-exponent"),
        ("length-scaled-back-the-wrong-way", "np.ldexp(length, -shift)", "np.ldexp(length, shift)"),
    ),
)
