"""Former names of arguments: they work, warn at the caller's line, and leave calls and signatures as they were."""

import inspect
import warnings
from typing import NoReturn

import pytest

from nao_kin._core.warn import FormerName, hides_former
from nao_kin.errors import BadArgument, FormerNameWarning

NEAR = FormerName("reference=", "near=", "nk.ik")


@hides_former
def solved(target: int, *, near: int | None = None, **_former: NoReturn) -> tuple[int, int | None]:
    """Return the arguments."""
    if _former:
        near = NEAR.argument(_former, near)
    return target, near


def test_the_former_name_of_an_argument_works_and_warns_at_the_line_of_the_call() -> None:
    message = "^reference= is now near=; the next release does not accept reference=$"
    with pytest.warns(FutureWarning, match=message) as caught:
        assert solved(1, reference=2) == (1, 2)
    assert [warning.category for warning in caught] == [FormerNameWarning]
    assert caught[0].filename == __file__


def test_the_new_name_gives_no_warning() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert solved(1, near=2) == solved(1, near=2)


def test_an_argument_under_both_names_is_refused_in_one_line() -> None:
    with pytest.raises(BadArgument, match=r"^reference= is the former name of near=; give one of them$"):
        solved(1, near=2, reference=3)


@pytest.mark.parametrize("names", [("nera",), ("reference", "nera"), ("nera", "reference")])
def test_an_unknown_argument_is_refused_as_python_does(names: tuple[str, ...]) -> None:
    with pytest.raises(TypeError, match=r"^solved\(\) got an unexpected keyword argument 'nera'$"):
        solved(1, **dict.fromkeys(names, 2))


def test_signature_and_documentation_show_only_the_new_name() -> None:
    assert list(inspect.signature(solved).parameters) == ["target", "near"]
    assert solved.__doc__ == "Return the arguments."
