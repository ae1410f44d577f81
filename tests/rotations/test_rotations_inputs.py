"""Behaviour common to all functions of the package: batches, lists, single values, and the refusal of bad arrays."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from loops import for_all
from rotation_samples import CONVENTIONS, DISTANCES, integer_rotations, random_rotations, worst

import nao_kin.rotations as rotations
from nao_kin._core import kernels
from nao_kin.errors import DegreesWarning, NotARotation, NotFinite, WrongShape

X, Y, Z = np.eye(3)
HIP = (np.array([0.0, 1.0, -1.0]), X, Y)
AXIS = np.array([1.0, -2.0, 2.0])


def _parts(result):
    if dataclasses.is_dataclass(result):
        return tuple(getattr(result, field.name) for field in dataclasses.fields(result))
    return result if isinstance(result, tuple) else (result,)


# Each function of one array: what it takes per item (shape), how to call it, the shapes of what comes back per item.
OF_MATRICES = {
    "is_rotation": (rotations.is_rotation, [()]),
    "check_rotation": (rotations.check_rotation, [(), ()]),
    "nearest_rotation": (rotations.nearest_rotation, [(3, 3)]),
    "rpy_from_matrix": (rotations.rpy_from_matrix, [(3,)]),
    "davenport_angles": (lambda R: rotations.davenport_angles(R, *HIP), [(3,), (3,), ()]),
    "natural_invariants": (rotations.natural_invariants, [(3,), ()]),
    "linear_invariants": (rotations.linear_invariants, [(3,), ()]),
    "euler_rodrigues": (rotations.euler_rodrigues, [(3,), ()]),
    "quat_from_matrix": (rotations.quat_from_matrix, [(4,)]),
    "log": (rotations.log, [(3,)]),
    "power": (lambda R: rotations.power(R, 0.7), [(3, 3)]),
    "angle_between (A)": (lambda A: rotations.angle_between(A, rotations.rot_y(0.3)), [()]),
    "angle_between (B)": (lambda B: rotations.angle_between(rotations.rot_y(0.3), B), [()]),
    "mrp_from_matrix": (rotations.mrp_from_matrix, [(3,)]),
    "nearest_euler x": (lambda R: rotations.nearest_euler(R, "x", axes="moving"), [(1,), ()]),
    "nearest_euler zy": (lambda R: rotations.nearest_euler(R, "zy", axes="fixed"), [(2,), ()]),
    "nearest_davenport": (lambda R: rotations.nearest_davenport(R, HIP[0], AXIS), [(2,), ()]),
    "random_rotation_near": (lambda R: rotations.random_rotation_near(R, 0.0), [(3, 3)]),
}
for _sequence, _axes in CONVENTIONS:
    OF_MATRICES[f"euler_from_matrix {_sequence} {_axes}"] = (
        lambda R, s=_sequence, a=_axes: rotations.euler_from_matrix(R, s, axes=a),
        [(3,), (3,), ()],
    )
OF_ANGLES = {
    "rot_x": (rotations.rot_x, (), (3, 3)),
    "rot_y": (rotations.rot_y, (), (3, 3)),
    "rot_z": (rotations.rot_z, (), (3, 3)),
    "matrix_from_rpy": (rotations.matrix_from_rpy, (3,), (3, 3)),
    "matrix_from_davenport": (lambda a: rotations.matrix_from_davenport(a, *HIP), (3,), (3, 3)),
    "exp": (rotations.exp, (3,), (3, 3)),
    "matrix_from_natural": (lambda a: rotations.matrix_from_natural(AXIS, a), (), (3, 3)),
    "matrix_from_natural (axis)": (lambda e: rotations.matrix_from_natural(e, 0.3), (3,), (3, 3)),
    "matrix_from_euler_rodrigues": (lambda r: rotations.matrix_from_euler_rodrigues(r, 0.3), (3,), (3, 3)),
    "matrix_from_quat": (rotations.matrix_from_quat, (4,), (3, 3)),
    "quat_multiply (left)": (lambda p: rotations.quat_multiply(p, [0.0, 1.0, 2.0, 3.0]), (4,), (4,)),
    "quat_multiply (right)": (lambda p: rotations.quat_multiply([0.0, 1.0, 2.0, 3.0], p), (4,), (4,)),
    "quat_conjugate": (rotations.quat_conjugate, (4,), (4,)),
    "quat_canonical": (rotations.quat_canonical, (4,), (4,)),
    "quat_to_xyzw": (rotations.quat_to_xyzw, (4,), (4,)),
    "quat_from_xyzw": (rotations.quat_from_xyzw, (4,), (4,)),
    "slerp (p)": (lambda p: rotations.slerp(p, [1.0, 0.0, 0.0, 0.0], 0.3), (4,), (4,)),
    "slerp (q)": (lambda q: rotations.slerp([1.0, 0.0, 0.0, 0.0], q, 0.3), (4,), (4,)),
    "slerp (t)": (lambda t: rotations.slerp([1.0, 0.0, 0.0, 0.0], [0.5, 0.5, -0.5, 0.5], t), (), (4,)),
    "slerp (longer)": (lambda q: rotations.slerp([0.0, 0.6, 0.0, 0.8], q, 0.3, arc="longer"), (4,), (4,)),
    "matrix_from_euler (one axis)": (lambda a: rotations.matrix_from_euler(a, "y", axes="moving"), (1,), (3, 3)),
    "matrix_from_euler (two axes)": (lambda a: rotations.matrix_from_euler(a, "zx", axes="fixed"), (2,), (3, 3)),
    "matrix_from_davenport (one axis)": (lambda a: rotations.matrix_from_davenport([0.3], a), (3,), (3, 3)),
    "matrix_from_davenport (two axes)": (
        lambda a: rotations.matrix_from_davenport([0.3, 0.2], a, HIP[0]),
        (3,),
        (3, 3),
    ),
    "power (t)": (lambda t: rotations.power(rotations.rot_x(0.4), t), (), (3, 3)),
    "quat_rotate (q)": (lambda q: rotations.quat_rotate(q, [1.0, 2.0, 3.0]), (4,), (3,)),
    "quat_rotate (v)": (lambda v: rotations.quat_rotate([0.6, 0.0, 0.8, 0.0], v), (3,), (3,)),
    "skew": (rotations.skew, (3,), (3, 3)),
    "left_jacobian": (rotations.left_jacobian, (3,), (3, 3)),
    "right_jacobian": (rotations.right_jacobian, (3,), (3, 3)),
    "left_jacobian_inverse": (rotations.left_jacobian_inverse, (3,), (3, 3)),
    "right_jacobian_inverse": (rotations.right_jacobian_inverse, (3,), (3, 3)),
    "matrix_from_mrp": (rotations.matrix_from_mrp, (3,), (3, 3)),
    "rotation_between (a)": (lambda a: rotations.rotation_between(a, AXIS), (3,), (3, 3)),
    "rotation_between (b)": (lambda b: rotations.rotation_between(AXIS, b, axis=X), (3,), (3, 3)),
    "matrix_from_euler (three axes)": (lambda a: rotations.matrix_from_euler(a, "zxz", axes="fixed"), (3,), (3, 3)),
    "euler_rate_jacobian": (
        lambda a: rotations.euler_rate_jacobian(a, "xyx", axes="fixed", expressed_in="fixed"),
        (3,),
        (3, 3),
    ),
    "euler_rate_jacobian_inverse": (
        lambda a: rotations.euler_rate_jacobian_inverse(a, "zyx", axes="moving", expressed_in="moving"),
        (3,),
        (3, 3),
    ),
}

of_matrices = for_all("name", OF_MATRICES)
of_angles = for_all("name", OF_ANGLES)


def stratified_rotations():
    """Random and integer rotations, and rotations at every distance from the identity, half turns and lock."""
    special = [np.eye(3), *(rotations.exp(a * math.pi * AXIS / 3.0) for a in (1.0, -1.0))]
    special += [rotations.exp([0, a * math.pi / 2, 0]) for a in (1.0, -1.0)]
    shifts = np.array([rotations.exp(d * np.array([0.6, -0.48, 0.64])) for d in DISTANCES])
    near = np.concatenate([R @ shifts for R in special])
    return np.concatenate([random_rotations(60), integer_rotations(), near])


@of_matrices
def test_one_matrix_gives_what_a_batch_gives(name):
    call, tails = OF_MATRICES[name]
    R = stratified_rotations()
    together = _parts(call(R))
    for i, matrix in enumerate(R):
        for part, whole, tail in zip(_parts(call(matrix)), together, tails, strict=True):
            assert np.shape(part) == tail
            assert part.dtype == whole.dtype
            assert worst(part * 1.0, whole[i] * 1.0) < 2e-15


@of_angles
def test_one_value_gives_what_a_batch_gives(name):
    call, head, tail = OF_ANGLES[name]
    values = np.random.default_rng(0).uniform(-4.0, 4.0, (50, *head))
    together = call(values)
    for value, whole in zip(values, together, strict=True):
        assert call(value).shape == tail
        assert worst(call(value), whole) < 1e-14


@of_matrices
def test_batch_shapes_of_matrices_are_kept(name):
    call, tails = OF_MATRICES[name]
    R = random_rotations(6)
    flat = _parts(call(R))
    for batch in ((2, 3), (6, 1), (1, 1, 6)):
        for part, whole, tail in zip(_parts(call(R.reshape(*batch, 3, 3))), flat, tails, strict=True):
            assert part.shape == (*batch, *tail)
            assert (part.reshape(whole.shape) == whole).all()
    for batch in ((0,), (2, 0), (1,), (1, 1)):
        for part, tail in zip(_parts(call(np.broadcast_to(R[0], (*batch, 3, 3)))), tails, strict=True):
            assert part.shape == (*batch, *tail)


@of_angles
def test_batch_shapes_of_angles_are_kept(name):
    call, head, tail = OF_ANGLES[name]
    values = np.random.default_rng(1).uniform(-1.0, 1.0, (6, *head))
    for batch in ((2, 3), (6, 1)):
        assert (call(values.reshape(*batch, *head)).reshape(6, *tail) == call(values)).all()
    for batch in ((0,), (2, 0), (1,), (1, 1)):
        assert call(np.ones((*batch, *head))).shape == (*batch, *tail)


def test_batches_longer_than_a_chunk_give_what_short_ones_give(monkeypatch):
    R = random_rotations(101)
    calls = {name: OF_MATRICES[name][0] for name in ("log", "rpy_from_matrix", "natural_invariants", "check_rotation")}
    whole = {name: _parts(call(R)) for name, call in calls.items()}
    monkeypatch.setattr(kernels, "CHUNK", 10)
    for name, call in calls.items():
        for part, expected in zip(_parts(call(R)), whole[name], strict=True):
            assert worst(part, expected) < 1e-15
    v = rotations.log(R)
    assert worst(rotations.exp(v), R) < 3e-15


def test_lists_integers_single_precision_and_strided_arrays_are_taken():
    assert rotations.rpy_from_matrix([[1, 0, 0], [0, 1, 0], [0, 0, 1]]).tolist() == [0.0, 0.0, 0.0]
    assert rotations.quat_from_matrix(np.eye(3, dtype=np.int8)).tolist() == [1.0, 0.0, 0.0, 0.0]
    assert rotations.exp(np.zeros(3, dtype=np.float32)).dtype == np.float64
    R = random_rotations(10)
    assert worst(rotations.log(R[::-2]), rotations.log(R)[::-2]) == 0.0
    assert worst(rotations.log(np.swapaxes(R, -1, -2)), -rotations.log(R)) < 1e-15
    assert worst(rotations.log(np.asfortranarray(R)), rotations.log(R)) == 0.0
    assert worst(rotations.log(np.broadcast_to(R[0], (4, 3, 3)))[3], rotations.log(R[0])) < 1e-15


def test_results_share_no_memory_with_arguments_and_arguments_stay():
    for name, (call, _) in OF_MATRICES.items():
        R = random_rotations(4)
        kept = R.copy()
        for part in _parts(call(R)):
            assert not np.shares_memory(part, R), name
        assert (kept == R).all(), name
    for name, (call, head, _) in OF_ANGLES.items():
        for batch in ((4,), (1,), ()):
            values = np.ones((*batch, *head))
            kept = values.copy()
            assert not np.shares_memory(call(values), values), name
            assert (values == kept).all(), name


@for_all("name", [name for name in OF_MATRICES if name != "is_rotation"])
@for_all("bad", [math.nan, math.inf, -math.inf])
def test_matrices_with_nan_or_infinity_are_refused_at_their_index(name, bad):
    call, _ = OF_MATRICES[name]
    R = random_rotations(20)
    R[7, 1, 2] = bad
    with pytest.raises(NotFinite) as caught:
        call(R)
    assert caught.value.index == (7, 1, 2)
    with pytest.raises(NotFinite):
        call(R[7])


@of_angles
@for_all("bad", [math.nan, math.inf, -math.inf])
def test_values_with_nan_or_infinity_are_refused(name, bad):
    call, head, _ = OF_ANGLES[name]
    values = np.ones((5, *head))
    values[(3, *(0 for _ in head))] = bad
    with pytest.raises(NotFinite) as caught:
        call(values)
    assert caught.value.index[0] == 3
    with pytest.raises(NotFinite):
        call(values[3])


@for_all("name", [name for name in OF_MATRICES if name not in ("is_rotation", "nearest_rotation")])
def test_what_is_no_rotation_is_refused_at_its_index(name):
    call, _ = OF_MATRICES[name]
    R = random_rotations(6).reshape(2, 3, 3, 3)
    R[1, 2] *= 1.01
    with pytest.raises(NotARotation) as caught:
        call(R)
    assert caught.value.index == (1, 2)
    assert caught.value.orthogonality_defect == pytest.approx(0.0201, abs=1e-9)
    with pytest.raises(NotARotation) as caught:
        call(np.diag([1.0, 1.0, -1.0]))
    assert caught.value.index == ()
    assert caught.value.determinant_defect == -2.0


@of_matrices
@for_all("shape", [(), (9,), (3, 4), (3, 3, 1)])
def test_matrices_of_another_shape_are_refused(name, shape):
    with pytest.raises(WrongShape, match=r"must have shape \(..., 3, 3\), got"):
        OF_MATRICES[name][0](np.zeros(shape))


@of_angles
def test_values_of_another_shape_are_refused(name):
    call, head, _ = OF_ANGLES[name]
    if head:
        for shape in ((), (head[0] + 1,), (head[0] - 1,), (head[0], head[0] + 1), (0,)):
            with pytest.raises(WrongShape):
                call(np.ones(shape))


def test_mismatched_batches_are_refused():
    for call in (rotations.matrix_from_natural, rotations.matrix_from_linear, rotations.matrix_from_euler_rodrigues):
        with pytest.raises(WrongShape, match="batch axes"):
            call(np.ones((2, 3)), np.ones(3))
    with pytest.raises(WrongShape, match=r"quaternions p and q .*\(2,\) and \(3,\)"):
        rotations.quat_multiply(np.ones((2, 4)), np.ones((3, 4)))
    with pytest.raises(WrongShape):
        rotations.slerp(np.ones((2, 4)), np.ones(4), [0.1, 0.2, 0.3])


def test_vector_and_number_broadcast():
    angles = np.array([0.1, 0.2])
    assert rotations.matrix_from_natural(np.ones((3, 1, 3)), angles).shape == (3, 2, 3, 3)
    assert worst(rotations.matrix_from_natural(X, angles), rotations.rot_x(angles)) < 1e-15
    assert rotations.matrix_from_linear([[0, 0, 0]] * 2, 1.0).shape == (2, 3, 3)


OF_DEGREES = {
    "rot_x": rotations.rot_x,
    "rot_y": rotations.rot_y,
    "rot_z": rotations.rot_z,
    "rpy": lambda a: rotations.matrix_from_rpy(np.stack([a, 0.0 * a, 0.3 + 0.0 * a], axis=-1)),
    "euler": lambda a: rotations.matrix_from_euler(np.stack([0.0 * a, a], axis=-1), "zy", axes="moving"),
    "quat": lambda a: rotations.quat_from_euler(a[..., np.newaxis], "x", axes="moving"),
    "natural": lambda a: rotations.matrix_from_natural(Z, a),
    "davenport": lambda a: rotations.matrix_from_davenport(np.stack([a, a], axis=-1), Z, X),
}


@pytest.mark.parametrize("name", OF_DEGREES)
@pytest.mark.parametrize(
    "degrees", [90, -45.0, [0, 30, 60, 90], [[180.0], [-180.0]], np.arange(-180.0, 181.0), [90.0, 22.5, 12.566, 360.0]]
)
def test_whole_degrees_are_noticed(name, degrees):
    with pytest.warns(DegreesWarning, match=r"= \d+ rad is more than a full turn") as caught:
        OF_DEGREES[name](np.array(degrees, dtype=float))
    assert len(caught) == 1
    assert caught[0].filename == __file__


@pytest.mark.parametrize("name", OF_DEGREES)
@pytest.mark.parametrize(
    "angles",
    [
        *(4 * math.pi, -2 * math.pi, 6.0, 7.0, 1e6, 2.0**60, []),
        np.linspace(0.0, 40.0, 1001),  # a joint that goes on turning, with some whole numbers
        np.round(np.linspace(0.0, 100.0, 977), 1),  # to a decimal
        np.random.default_rng(0).normal(0.0, 30.0, (5, 7)),
        np.radians(np.arange(-720.0, 721.0)),
    ],
)
def test_angles_of_several_turns_are_honest(name, angles):
    OF_DEGREES[name](np.array(angles, dtype=float))  # warnings are errors here
