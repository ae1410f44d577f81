"""Small faults of the kind that review overlooks: where each is planted, and the tests that must notice it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Mutation:
    """A fault.

    Attributes:
        name: what is wrong, in words joined by hyphens.
        file: the source file, from the root of the project.
        old: text that occurs in it exactly once.
        new: what stands in its place.
        tests: arguments for pytest, files or single tests.
    """

    name: str
    file: str
    old: str
    new: str
    tests: tuple[str, ...]


MUTATIONS: tuple[Mutation, ...] = (
    Mutation(
        name="finite-check-refuses-arrays-whose-squares-overflow",
        file="nao_kin/_arrays.py",
        old="                return True\n    return bool(np.isfinite(array).all())",
        new="                return True\n            return False\n    return bool(np.isfinite(array).all())",
        tests=("tests/test_rotations_inputs.py", "tests/test_robot_model.py", "tests/test_lines.py"),
    ),
    Mutation(
        name="canonical-sign-blind-to-the-last-component",
        file="nao_kin/rotations/quaternions.py",
        old="nonzero.argmax(axis=-1)",
        new="nonzero[..., :3].argmax(axis=-1)",
        tests=("tests/test_rotations_quaternions.py",),
    ),
    Mutation(
        name="lines-coincident-a-million-times-too-easily",
        file="nao_kin/lines/_line.py",
        old="_COINCIDENT = 4.0 *",
        new="_COINCIDENT = 4.0e6 *",
        tests=("tests/test_lines.py",),
    ),
    Mutation(
        name="feet-of-lines-coincident-a-million-times-too-easily",
        file="nao_kin/lines/_pairs.py",
        old="coincident_below: float = 1e-12",
        new="coincident_below: float = 1e-6",
        tests=("tests/test_lines.py",),
    ),
    Mutation(
        name="rank-one-defective-a-million-times-too-easily",
        file="nao_kin/rank_one.py",
        old="np.abs(cosine) <= _ROUNDING *",
        new="np.abs(cosine) <= 1e6 * _ROUNDING *",
        tests=("tests/test_rank_one.py",),
    ),
    Mutation(
        name="rank-one-singular-a-million-times-too-easily",
        file="nao_kin/rank_one.py",
        old="blur = _ROUNDING *",
        new="blur = 1e6 * _ROUNDING *",
        tests=("tests/test_rank_one.py",),
    ),
)
