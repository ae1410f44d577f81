from __future__ import annotations

from fractions import Fraction
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from loops import for_all
from scipy.spatial.transform import Rotation

from nao_kin.errors import NotFinite, SingularMatrix, WrongShape
from nao_kin.rotations import rank_one

EPS = np.finfo(float).eps
BATCHES = [(), (0,), (1,), (2, 3)]
assert_near = partial(np.testing.assert_allclose, rtol=0)  # its own default lets a relative 1e-7 pass
few = settings(max_examples=80, derandomize=True, deadline=None)
component = st.floats(-10.0, 10.0).map(lambda x: round(x, 6)) | st.integers(-3, 3).map(float)
vector = st.tuples(component, component, component).map(np.array)
nonzero = vector.filter(lambda w: np.abs(w).max() > 1e-3)


def check_jordan_form(u, v, eigen: rank_one.RankOneEigen, tolerance: float) -> None:
    T, P, J = rank_one.matrix(u, v), eigen.jordan_basis, eigen.jordan_form
    scale = np.linalg.norm(T) * np.linalg.norm(P)
    assert_near(T @ P, P @ J, atol=tolerance * scale)
    assert_near(T @ eigen.vectors, eigen.vectors * eigen.values[None, :], atol=tolerance * scale)
    assert_near(np.linalg.norm(eigen.vectors, axis=0), 1, atol=4 * EPS)


def orthogonal_pair(u: np.ndarray, w: np.ndarray) -> np.ndarray:
    """A nonzero integer-valued vector exactly at right angles to an integer-valued u."""
    candidates = [np.cross(u, w), np.cross(u, [1, 0, 0]), np.cross(u, [0, 1, 0])]
    return next(v for v in candidates if v.any())


whole = st.tuples(*[st.integers(-9, 9)] * 3).map(np.array)
shears = st.tuples(whole.filter(np.any), whole).map(lambda pair: (pair[0], orthogonal_pair(*pair)))


@few
@given(vector, vector)
def test_determinant_is_one_plus_the_product(u, v) -> None:
    exact = 1 + sum(Fraction(a) * Fraction(b) for a, b in zip(u, v, strict=True))
    bound = 4 * EPS * (1 + float(np.abs(u) @ np.abs(v)))
    assert abs(Fraction(float(rank_one.determinant(u, v))) - exact) <= bound
    assert abs(np.linalg.det(rank_one.matrix(u, v)) - float(exact)) <= 100 * bound * (1 + np.abs(u).max())


@few
@given(nonzero, nonzero)
def test_eigenvectors_are_two_at_right_angles_to_v_and_u_itself(u, v) -> None:
    eigen = rank_one.eigen(u, v)
    np.testing.assert_allclose(eigen.values, [1, 1, 1 + u @ v], rtol=1e-15, atol=8 * EPS * (np.abs(u) @ np.abs(v)))
    w1, w2, w3 = eigen.vectors.T
    assert_near([w1 @ v, w2 @ v], 0, atol=8 * EPS * np.linalg.norm(v))
    assert_near([w1 @ w2, w1 @ w1, w2 @ w2], [0, 1, 1], atol=8 * EPS)
    assert_near(w3, u / np.linalg.norm(u), atol=4 * EPS)
    check_jordan_form(u, v, eigen, 8 * EPS)


@few
@given(vector, vector)
def test_the_inverse_undoes_the_matrix(u, v) -> None:
    T = rank_one.matrix(u, v)
    if abs(1 + u @ v) < 1e-6:
        return
    condition = np.linalg.cond(T)
    assert_near(rank_one.inverse(u, v) @ T, np.eye(3), atol=20 * EPS * condition**2)
    np.testing.assert_allclose(rank_one.inverse(u, v), np.linalg.inv(T), rtol=1e-9, atol=1e-12 * condition)


@few
@given(shears)
def test_a_shear_is_defective_and_has_one_jordan_block(pair) -> None:
    import sympy  # takes a second, in each process

    u, v = pair
    assert u @ v == 0
    eigen = rank_one.eigen(u, v)
    assert eigen.defective
    assert not eigen.singular
    np.testing.assert_array_equal(eigen.values, 1)
    np.testing.assert_array_equal(eigen.jordan_form, [[1, 0, 0], [0, 1, 1], [0, 0, 1]])
    np.testing.assert_array_equal(eigen.vectors[:, 1], eigen.vectors[:, 2])
    # Geometric multiplicity two: T − 1 has rank one, and sympy finds the same single block.
    T = sympy.Matrix(rank_one.matrix(u, v).astype(int))
    assert (T - sympy.eye(3)).rank() == 1
    assert sorted(sum(row) for row in T.jordan_form()[1].tolist()) == [1, 1, 2]
    check_jordan_form(u, v, eigen, 8 * EPS)
    assert abs(np.linalg.det(eigen.jordan_basis)) > 0
    assert_near(rank_one.inverse(u, v), np.eye(3) - np.outer(u, v), atol=EPS)


@few
@given(nonzero, nonzero, st.sampled_from([0.0, *(10.0**-k for k in range(3, 13))]), st.sampled_from([1.0, 1e10]))
def test_vectors_at_right_angles_up_to_rounding_are_defective_and_those_beside_are_not(u, w, aside, size) -> None:
    if np.linalg.norm(np.cross(u, w)) < 1e-2:
        return
    e, f = u / np.linalg.norm(u), np.cross(u, w) / np.linalg.norm(np.cross(u, w))
    v = size * (f + aside * e)
    eigen = rank_one.eigen(u, v)
    assert eigen.defective == (aside == 0.0)
    assert (eigen.values == 1).all() == (aside == 0.0)
    check_jordan_form(u, v, eigen, 8 * EPS)


@few
@given(nonzero, nonzero, st.sampled_from([0.0, *(s * 10.0**-k for k in range(3, 13) for s in (1, -1))]))
def test_a_product_of_minus_one_is_singular_and_one_beside_is_not(u, w, aside) -> None:
    product = u @ w
    if abs(product) < 1e-2 * np.linalg.norm(u) * np.linalg.norm(w):
        return
    v = w * (-1 + aside) / product
    eigen = rank_one.eigen(u, v)
    assert eigen.singular == (aside == 0.0)
    assert not eigen.defective
    check_jordan_form(u, v, eigen, 8 * EPS)
    if aside:
        product_matrix = rank_one.inverse(u, v) @ rank_one.matrix(u, v)
        size = np.linalg.norm(u) * np.linalg.norm(v)
        assert_near(product_matrix, np.eye(3), atol=40 * EPS * (1 + size) ** 2 / abs(aside))
    else:
        with pytest.raises(SingularMatrix):
            rank_one.inverse(u, v)
        assert_near(rank_one.matrix(u, v) @ u, 0, atol=20 * EPS * np.abs(u).max() * (1 + np.abs(v @ u)))


@for_all("scale", [2.0**-60, 1.0, 2.0**40])
@for_all(("roundings", "defective"), [(0, True), (1, True), (-3, True), (7, False), (-7, False), (100, False)])
def test_a_cosine_counts_as_zero_up_to_four_roundings_of_its_terms(roundings, defective, scale) -> None:
    # u·v is exactly 2 · roundings · EPS, its two terms have the size 1 each.
    u, v = np.array([1.0, 1.0, 0.0]), np.array([1.0, -1.0 + 2 * roundings * EPS, 0.0])
    assert rank_one.eigen(scale * u, v).defective == defective
    assert rank_one.eigen(v, scale * u).defective == defective


@for_all(("roundings", "singular"), [(0, True), (1, True), (-7, True), (9, False), (-9, False), (100, False)])
def test_a_product_counts_as_minus_one_up_to_four_roundings_of_each_term_and_of_the_one(roundings, singular) -> None:
    u, v = np.array([0.0, 2.0, 0.0]), np.array([0.0, (-1.0 + roundings * EPS) / 2, 0.0])
    assert u @ v == -1.0 + roundings * EPS
    assert rank_one.eigen(u, v).singular == singular


@for_all("sign", [1.0, -1.0])
@for_all("sine", [0.0, 1e-15, 1e-9, 1e-4, 1e-2, 0.099, 0.101, 0.3, 1.0])
def test_eigenvectors_stay_at_right_angles_to_v_however_nearly_u_is_along_it(sine, sign) -> None:
    for turn in Rotation.random(30, rng=np.random.default_rng(2)).as_matrix():
        v = turn @ [sign, 0.0, 0.0]
        u = turn @ [np.sqrt(1 - sine * sine), sine, 0.0]
        w1, w2, w3 = rank_one.eigen(u, v).vectors.T
        assert_near([w1 @ v, w2 @ v, w1 @ w2], 0, atol=4 * EPS)
        assert_near(w3, u, atol=4 * EPS)
        if sine > 0.1:
            assert_near(w1 @ u, 0, atol=4 * EPS)


def test_long_vectors_whose_product_is_minus_one_are_singular_and_not_defective() -> None:
    eigen = rank_one.eigen([2**26, 2**26, 1], [2**26, -(2**26), -1])
    assert eigen.singular
    assert not eigen.defective


@for_all("u", [[0, 0, 0], [0, 0, 2]])
@for_all("v", [[0, 0, 0], [0, 3, 0]])
def test_with_a_zero_vector_the_matrix_is_the_identity_and_has_a_full_orthonormal_basis(u, v) -> None:
    if any(u) and any(v):
        return
    eigen = rank_one.eigen(u, v)
    np.testing.assert_array_equal(rank_one.matrix(u, v), np.eye(3))
    np.testing.assert_array_equal(eigen.jordan_form, np.eye(3))
    assert_near(eigen.vectors.T @ eigen.vectors, np.eye(3), atol=EPS)
    np.testing.assert_array_equal(eigen.jordan_basis, eigen.vectors)
    assert not eigen.defective


@few
@given(nonzero, nonzero)
def test_the_determinant_of_the_jordan_basis_is_the_cosine_or_one_over_the_lengths(u, v) -> None:
    eigen = rank_one.eigen(u, v)
    size = float(np.linalg.norm(u) * np.linalg.norm(v))
    if eigen.singular or (abs(u @ v) < 1e-9 * size and not eigen.defective):
        return
    expected = 1.0 / size if eigen.defective else abs(u @ v) / size
    assert abs(np.linalg.det(eigen.jordan_basis)) == pytest.approx(expected, rel=1e-5)


def test_the_identities_of_the_paper_hold_symbolically() -> None:
    import sympy  # takes a second, in each process

    u, v = (sympy.Matrix(sympy.symbols(f"{name}:3")) for name in "uv")
    T = sympy.eye(3) + u * v.T
    assert sympy.expand(T.det() - 1 - u.dot(v)) == 0
    assert sympy.simplify(T * u - (1 + u.dot(v)) * u) == sympy.zeros(3, 1)
    assert sympy.simplify((sympy.eye(3) - u * v.T / (1 + u.dot(v))) * T - sympy.eye(3)) == sympy.zeros(3)


@for_all("shape", BATCHES)
def test_every_function_takes_every_batch_shape_and_treats_each_pair_alone(shape) -> None:
    rng = np.random.default_rng(1)
    u, v = rng.normal(size=(2, *shape, 3))
    if shape == (2, 3):
        v[0, 1] = np.cross(u[0, 1], [1, 2, 3])
        u[1, 2] = 0
    whole_batch = rank_one.eigen(u, v)
    for name, tail in {
        "values": (3,),
        "vectors": (3, 3),
        "defective": (),
        "singular": (),
        "jordan_basis": (3, 3),
        "jordan_form": (3, 3),
    }.items():
        whole = getattr(whole_batch, name)
        assert whole.shape == (*shape, *tail), name
        for i in np.ndindex(*shape):
            assert_near(whole[i], getattr(rank_one.eigen(u[i], v[i]), name), atol=1e-15, err_msg=name)
    for function in (rank_one.matrix, rank_one.inverse, rank_one.determinant):
        for i in np.ndindex(*shape):
            np.testing.assert_allclose(function(u, v)[i], function(u[i], v[i]), rtol=1e-14, atol=1e-15)
        assert function(u, v).shape[: len(shape)] == shape
    if shape == (2, 3):
        assert whole_batch.defective.tolist() == [[False, True, False], [False, False, False]]


def test_arguments_broadcast_and_are_left_alone() -> None:
    u, v = np.ones((4, 1, 3)), np.ones(3)
    for result in (rank_one.matrix(u, v), rank_one.inverse(u, v), rank_one.eigen(u, v).vectors):
        assert result.shape == (4, 1, 3, 3)
        result[:] = 7
    assert u.min() == u.max() == v.min() == v.max() == 1


@for_all("function", [rank_one.matrix, rank_one.determinant, rank_one.inverse, rank_one.eigen])
@for_all(
    ("u", "v", "error"),
    [
        ([np.nan, 0, 0], [1, 0, 0], NotFinite),
        ([1, 0, 0], [np.inf, 0, 0], NotFinite),
        ([1, 0], [1, 0], WrongShape),
        (np.ones((2, 3)), np.ones((3, 3)), WrongShape),
    ],
)
def test_bad_input_is_refused_with_the_librarys_own_error(function, u, v, error) -> None:
    with pytest.raises(error):
        function(u, v)


def test_a_singular_matrix_is_named_by_its_place_in_the_batch() -> None:
    with pytest.raises(SingularMatrix, match=r"index \[1\]: u·v = −1") as refusal:
        rank_one.inverse([[1, 0, 0], [1, 0, 0]], [[1, 0, 0], [-1, 5, 0]])
    assert refusal.value.index == (1,)
