"""Faults of rigid motions: sides, halves and signs exchanged, thresholds shifted."""

from __future__ import annotations

from mutation import faults

SCREWS = (
    *faults(
        "screws/_exponential.py",
        "test_exponential.py test_screws_inputs.py",
        ("exponential-without-its-second-product", "+ C[..., None] * cross(omega, across)", ""),
        ("logarithm-with-the-jacobian-of-the-other-side", "t - 0.5 * across", "t + 0.5 * across"),
        ("turns-without-digits-accepted", "LARGEST_ANGLE = 1e15", "LARGEST_ANGLE = 1e16"),
        ("twists-typed-to-six-digits-accepted", "_FORM = 1e-9", "_FORM = 1e-6"),
        ("last-row-of-a-twist-not-looked-at", ".max(axis=-1))\n    wrong", ".max(axis=-1) * 0.0)\n    wrong"),
    ),
    *faults(
        "screws/_poses.py",
        "test_poses.py",
        ("moment-carried-over-the-other-way", "turned(R, tau) + cross(t, force)", "turned(R, tau) - cross(t, force)"),
        ("bracket-of-one-half", "cross(omega_a, v_b) + cross(v_a, omega_b)", "cross(omega_a, v_b)"),
        ("dual-bracket-without-the-force", "cross(omega, tau) + cross(v, f)", "cross(omega, tau)"),
        ("twist-carried-over-the-other-way", "turned(R, v) + cross(t, about)", "turned(R, v) - cross(t, about)"),
        (
            "adjoint-with-its-factors-exchanged",
            "upper_blocks(R, cross_matrix(t) @ R)",
            "upper_blocks(R, R @ cross_matrix(t))",
        ),
        ("dual-adjoint-upside-down", "return motion_matrix(T_ab)", "return adjoint(T_ab)"),
    ),
    *faults(
        "screws/_exponential.py",
        "test_screws_jacobians.py",
        ("jacobian-without-the-derivative-of-c", "along * (dB * W + dC * W2)", "along * (dB * W)"),
        (
            "inverse-jacobian-without-the-derivative-of-d",
            "D * WV + along * dD * W2",
            "D * WV",
        ),
    ),
    *faults(
        "screws/_exponential.py",
        "test_poses.py",
        ("longer-way-a-turn-further", "1.0 - 2.0 * np.pi / angle", "1.0 + 2.0 * np.pi / angle"),
        ("longer-way-slides-back", "v - across + ratio * across", "ratio * v"),
        ("way-from-the-difference-of-far-points", "turned(back, p_1 - p_0)", "turned(back, p_1) - turned(back, p_0)"),
    ),
    *faults(
        "screws/_exponential.py",
        "test_axes.py",
        ("slide-as-long-as-the-velocity", "speed, 0.0), dot(e, v))", "speed, 0.0), np.linalg.norm(v, axis=-1))"),
        ("pitch-of-a-translation-without-its-sign", "np.copysign(np.inf, self.slide)", "np.inf"),
        ("axes-without-end", "> FARTHEST_AXIS * angle", "> 1e155 * angle"),
        (
            "axis-of-the-moment-with-a-part-along-it",
            "across = cross(cross(e, v), e)",
            "across = v - dot(e, v)[..., None] * e",
        ),
        ("zero-twist-without-the-z-axis", "v, [0.0, 0.0, 1.0])", "v, [1.0, 0.0, 0.0])"),
        (
            "screw-about-the-origin-of-its-axis",
            "about_origin = self.axis.transfer_to((0.0, 0.0, 0.0))",
            "about_origin = self.axis",
        ),
        (
            "angles-of-a-screw-not-copied",
            "own = np.array(np.broadcast_to(value, batch))",
            "own = np.broadcast_to(value, batch)",
        ),
    ),
    *faults(
        "screws/_dual_quaternions.py",
        "test_axes.py",
        ("dual-quaternion-shifts-twice", "_pure(0.5 * t)", "_pure(t)"),
        ("dual-quaternion-with-a-pitch", "return r, d - product[..., None] * r", "return r, d"),
        ("dual-quaternions-to-a-thousandth", "_TOLERANCE = 1e-6", "_TOLERANCE = 1e-3"),
        (
            "dual-quaternions-multiplied-in-the-other-order",
            "multiply(P[..., 4:], Q[..., :4])",
            "multiply(Q[..., :4], P[..., 4:])",
        ),
        ("line-carried-about-its-own-origin", "seen = line.transfer_to((0.0, 0.0, 0.0))", "seen = line"),
        ("pitch-allowed-by-the-square-of-the-shift", "np.maximum(1.0, norm(d))", "np.maximum(1.0, norm(d) ** 2)"),
        ("length-of-the-dual-part-kept", "d = Q[..., 4:] / length[..., None]", "d = Q[..., 4:]"),
    ),
    *faults(
        "screws/_poses.py",
        "test_poses.py",
        ("product-of-poses-in-the-other-frame", "p = p + turned(R, q)", "p = p + turned(S, q)"),
        ("transposed-poses-repaired", "_LAST_ROW = 1e-3", "_LAST_ROW = 1.0"),
        ("pose-of-any-matrix", "    check_rotation(rotations)\n", ""),
    ),
)
