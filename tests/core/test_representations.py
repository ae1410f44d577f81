"""What a result prints: one line."""

from __future__ import annotations

import dataclasses
import inspect
from typing import Any

import numpy as np
import pytest

import nao_kin as nk

NAO = nk.load_nao()
Q = NAO.posture("StandInit")
ROOMS = [getattr(nk, name) for name in nk.__all__ if inspect.ismodule(getattr(nk, name))]
NAMED = [getattr(room, name) for room in ROOMS for name in room.__all__]
CLASSES = {kind for kind in NAMED if inspect.isclass(kind) and dataclasses.is_dataclass(kind)}


@pytest.mark.parametrize("kind", sorted(CLASSES, key=lambda kind: kind.__name__), ids=lambda kind: kind.__name__)
def test_no_class_with_arrays_prints_them_whole(kind: Any) -> None:
    types = " ".join(str(field.type) for field in dataclasses.fields(kind))
    if any(array in types for array in ("Floats", "NDArray", "ArrayLike")):
        generated = inspect.unwrap(kind.__repr__).__code__.co_filename == "<string>"
        assert not generated, "a generated repr; @one_line_repr gives a short one"


@pytest.mark.parametrize("q", [Q, np.tile(Q, (500, 1))], ids=["one configuration", "500 configurations"])
def test_results_print_in_one_line_that_has_their_numbers(q: Any) -> None:
    results = [
        nk.world.balance(NAO, q),
        NAO.set_down(q),
        NAO.clearance(q),
        NAO.semantics,
        NAO.joints,
        nk.ik.velocity(NAO, q, np.ones(6), "LArm"),
        nk.rotations.euler_from_matrix(NAO.rotation(q, "LArm"), "xyz", axes="moving"),
    ]
    for result in results:
        text = repr(result)
        assert "\n" not in text
        assert len(text) <= 400
        assert text.startswith(f"{type(result).__name__}({dataclasses.fields(result)[0].name}=")  # type: ignore[arg-type]
    com = nk.world.balance(NAO, q).com
    shown = f"[{com[0]:.6f}, " if com.ndim == 1 else "com=<array of shape (500, 3)>"
    assert shown in repr(results[0])
    assert "down=SetDown(…)" in repr(results[0])
