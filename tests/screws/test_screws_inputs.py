from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from loops import for_all
from screw_samples import BATCHES, random_twists

from nao_kin import lines, screws
from nao_kin.errors import BadArgument, NotARotation, NotFinite, WrongShape

assert_near = partial(np.testing.assert_allclose, rtol=0)

# What each function takes: T poses, x twists, p points, R rotations, s numbers, q dual quaternions, l lines, h [ξ].
FUNCTIONS = {
    "pose": (screws.pose, "Rp"),
    "inverse": (screws.inverse, "T"),
    "compose": (screws.compose, "TT"),
    "transform_point": (screws.transform_point, "Tp"),
    "nearest_pose": (screws.nearest_pose, "T"),
    "exp": (screws.exp, "x"),
    "log": (screws.log, "T"),
    "hat": (screws.hat, "x"),
    "vee": (screws.vee, "h"),
    "adjoint": (screws.adjoint, "T"),
    "dual_adjoint": (screws.dual_adjoint, "T"),
    "transform_twist": (screws.transform_twist, "Tx"),
    "transform_wrench": (screws.transform_wrench, "Tx"),
    "bracket": (screws.bracket, "xx"),
    "dual_bracket": (screws.dual_bracket, "xx"),
    "sclerp": (screws.sclerp, "TTs"),
    "sclerp, the longer way": (partial(screws.sclerp, longer=True), "TTs"),
    "left_jacobian": (screws.left_jacobian, "x"),
    "left_jacobian_inverse": (screws.left_jacobian_inverse, "x"),
    "right_jacobian": (screws.right_jacobian, "x"),
    "right_jacobian_inverse": (screws.right_jacobian_inverse, "x"),
    "dual_quat_from_pose": (screws.dual_quat_from_pose, "T"),
    "pose_from_dual_quat": (screws.pose_from_dual_quat, "q"),
    "dual_quat_multiply": (screws.dual_quat_multiply, "qq"),
    "dual_quat_conjugate": (screws.dual_quat_conjugate, "q"),
    "dual_quat_transform_point": (screws.dual_quat_transform_point, "qp"),
    "dual_quat_transform_line": (lambda q, line: screws.dual_quat_transform_line(q, line).coordinates, "ql"),
    "Screw.from_twist": (lambda x: screws.Screw.from_twist(x).axis.coordinates, "x"),
    "Screw.from_pose": (lambda T: screws.Screw.from_pose(T).pitch, "T"),
    "Screw.twist": (lambda line, a, d: screws.Screw(line, a, d).twist, "lss"),
    "Screw.pose": (lambda line, a, d: screws.Screw(line, a, d).pose, "lss"),
}
AXES = {"T": 2, "R": 2, "h": 2, "x": 1, "p": 1, "q": 1, "s": 0, "l": 0}


def made(kinds: str, shape: tuple[int, ...]) -> list:
    """Arguments of these kinds for a batch, all different."""
    arguments = []
    for seed, kind in enumerate(kinds):
        twist = random_twists(max(int(np.prod(shape)), 1), seed)[: int(np.prod(shape))].reshape(*shape, 6)
        T = screws.exp(twist)
        arguments.append(
            {
                "T": lambda T=T: T,
                "R": lambda T=T: T[..., :3, :3],
                "h": lambda twist=twist: screws.hat(twist),
                "x": lambda twist=twist: twist,
                "p": lambda twist=twist: twist[..., :3],
                "q": lambda T=T: screws.dual_quat_from_pose(T),
                "s": lambda twist=twist: twist[..., 0],
                "l": lambda twist=twist: lines.PluckerLine.from_point_direction(twist[..., :3], twist[..., 3:]),
            }[kind]()
        )
    return arguments


def test_every_function_of_the_room_is_looked_at_here() -> None:
    assert {name.split(",")[0].split(".")[0] for name in FUNCTIONS} == set(screws.__all__)


@for_all("name", FUNCTIONS)
@for_all("shape", BATCHES)
def test_every_function_takes_every_batch_shape_and_treats_each_item_alone(name, shape) -> None:
    function, kinds = FUNCTIONS[name]
    arguments = made(kinds, shape)
    whole = function(*arguments)
    assert whole.shape[: len(shape)] == shape
    assert whole.dtype == np.float64
    for index in np.ndindex(*shape):
        assert_near(
            function(*(a[index] for a in arguments)), whole[index], atol=1e-14 * (1 + np.abs(whole[index]).max())
        )


@for_all("name", [name for name, (_, kinds) in FUNCTIONS.items() if len(kinds) > 1])
def test_batches_broadcast_against_each_other(name) -> None:
    function, kinds = FUNCTIONS[name]
    columns, rows = made(kinds, (4, 1)), made(kinds, (3,))
    whole = function(columns[0], *rows[1:])
    assert whole.shape[:2] == (4, 3)
    for i, j in np.ndindex(4, 3):
        expected = function(columns[0][i, 0], *(row[j] for row in rows[1:]))
        assert_near(whole[i, j], expected, atol=1e-14 * (1 + np.abs(expected).max()))
    two = made(kinds, (2,))
    with pytest.raises(WrongShape, match="batch axes of"):
        function(two[0], *rows[1:])


@for_all("name", [name for name, (_, kinds) in FUNCTIONS.items() if kinds[0] != "l"])
def test_wrong_shapes_what_is_not_finite_and_what_is_no_number_are_refused(name) -> None:
    function, kinds = FUNCTIONS[name]
    for i, kind in enumerate(kinds):
        if kind == "l":
            continue
        arguments = made(kinds, (2,))
        good = arguments[i]
        for bad, error in (
            (
                np.where(np.arange(good.size).reshape(good.shape) == good.size - 1, np.nan, good),
                (NotFinite, BadArgument),
            ),
            (np.where(np.arange(good.size).reshape(good.shape) == 0, np.inf, good), NotFinite),
            ("abc", BadArgument),
            (None, BadArgument),
            (good * 1j, BadArgument),
        ):
            with pytest.raises(error):
                function(*arguments[:i], bad, *arguments[i + 1 :])
        if AXES[kind]:
            with pytest.raises(WrongShape):
                function(*arguments[:i], good[..., :-1], *arguments[i + 1 :])
            with pytest.raises(WrongShape):
                function(*arguments[:i], 1.0, *arguments[i + 1 :])


@for_all("name", [name for name, (_, kinds) in FUNCTIONS.items() if "T" in kinds])
def test_what_is_no_pose_is_refused_with_its_index(name) -> None:
    function, kinds = FUNCTIONS[name]
    scaled, projective = np.stack([np.eye(4)] * 2), np.stack([np.eye(4)] * 2)
    scaled[1, 0, 0], projective[1, 3, 0] = 1.1, 0.5
    arguments = made(kinds, (2,))
    for i, kind in enumerate(kinds):
        if kind == "T":
            with pytest.raises(BadArgument, match=r"(?s)the last row of .*index \[1\]"):
                function(*arguments[:i], projective, *arguments[i + 1 :])
            if name != "nearest_pose":
                with pytest.raises(NotARotation) as refusal:
                    function(*arguments[:i], scaled, *arguments[i + 1 :])
                assert refusal.value.index == (1,)


def test_a_rotation_rounded_to_single_precision_is_a_rotation() -> None:
    T = screws.exp(random_twists(10)).astype(np.float32)
    assert_near(screws.exp(screws.log(T)), T, atol=1e-6)


def test_nothing_to_compose_and_turns_without_digits_are_refused() -> None:
    with pytest.raises(BadArgument, match="compose needs at least one pose"):
        screws.compose()
    for function in (screws.exp, screws.left_jacobian, screws.right_jacobian_inverse, screws.Screw.from_twist):
        with pytest.raises(BadArgument, match=r"the twist at index \[1\] turns by more than 1e\+15 rad"):
            function([[0, 0, 0, 0, 0, 1], [0, 0, 0, 0, 0, 1.1e15]])
    assert np.isfinite(screws.exp([1e150, 0, 0, 0, 1e15, 0])).all()
    assert np.isfinite(screws.left_jacobian([1e150, 1e150, 0, 0, 1e15, 0])).all()
