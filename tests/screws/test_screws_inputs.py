from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from loops import for_all
from screw_samples import BATCHES, random_twists

from nao_kin import screws
from nao_kin.errors import BadArgument, NotARotation, NotFinite, WrongShape
from nao_kin.screws import lines

assert_near = partial(np.testing.assert_allclose, rtol=0)

# What each function takes: T poses, x twists, p points, R rotations, s numbers, q dual quaternions, l lines, h [ξ].
FUNCTIONS = {
    "pose": (screws.pose, "Rp"),
    "inverse": (screws.inverse, "T"),
    "transform_point": (screws.transform_point, "Tp"),
    "nearest_pose": (screws.nearest_pose, "T"),
    "exp": (screws.exp, "x"),
    "log": (screws.log, "T"),
    "hat": (screws.hat, "x"),
    "vee": (screws.vee, "h"),
    "adjoint": (screws.adjoint, "T"),
    "transform_twist": (screws.transform_twist, "Tx"),
    "transform_wrench": (screws.transform_wrench, "Tx"),
    "bracket": (screws.bracket, "xx"),
    "dual_bracket": (screws.dual_bracket, "xx"),
    "sclerp": (screws.sclerp, "TTs"),
    "sclerp, the longer way": (partial(screws.sclerp, arc="longer"), "TTs"),
    "left_jacobian": (screws.left_jacobian, "x"),
    "left_jacobian_inverse": (screws.left_jacobian_inverse, "x"),
    "right_jacobian": (screws.right_jacobian, "x"),
    "right_jacobian_inverse": (screws.right_jacobian_inverse, "x"),
    "dual_quat_from_pose": (screws.dual_quat_from_pose, "T"),
    "pose_from_dual_quat": (screws.pose_from_dual_quat, "q"),
    "dual_quat_multiply": (screws.dual_quat_multiply, "qq"),
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


@for_all("name", FUNCTIONS)
def test_arguments_stay_as_they_were(name) -> None:
    function, kinds = FUNCTIONS[name]
    arguments = made(kinds, (2,))
    before = [None if kind == "l" else a.copy() for a, kind in zip(arguments, kinds, strict=True)]
    result = function(*arguments)
    result[...] = 7.0
    for a, kept in zip(arguments, before, strict=True):
        if kept is not None:
            np.testing.assert_array_equal(a, kept)


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
            with pytest.raises(BadArgument, match="last row") as caught:
                function(*arguments[:i], projective, *arguments[i + 1 :])
            assert "at index [1]" in str(caught.value)
            if name != "nearest_pose":
                with pytest.raises(NotARotation) as refusal:
                    function(*arguments[:i], scaled, *arguments[i + 1 :])
                assert refusal.value.index == (1,)


def test_a_rotation_rounded_to_single_precision_is_a_rotation() -> None:
    T = screws.exp(random_twists(10)).astype(np.float32)
    assert_near(screws.exp(screws.log(T)), T, atol=1e-6)
