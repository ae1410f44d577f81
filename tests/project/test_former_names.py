"""Every former name works for a release and warns, and the documentation lists it."""

import re
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import nao_kin as nk
from nao_kin._core.former import FORMER_NAMES
from nao_kin.errors import FormerNameWarning
from nao_kin.stream.results import Clamped

PAGE = Path(__file__).parents[2] / "docs" / "former_names.md"
NAO = nk.load_nao()
Q = NAO.posture("Stand")
# Two calls for each former name outside the command line: with it, and with the new one.
CALLS: dict[tuple[str, str], tuple[Callable[[], Any], Callable[[], Any]]] = {
    ('limits="raise"', 'limits="enforce"'): (
        lambda: NAO.configuration({"HeadYaw": 0.1}, limits="raise"),
        lambda: NAO.configuration({"HeadYaw": 0.1}, limits="enforce"),
    ),
    ("most=", "max_configurations="): (
        lambda: NAO.limit_violations([np.full(25, 3.0)] * 2, most=1),
        lambda: NAO.limit_violations([np.full(25, 3.0)] * 2, max_configurations=1),
    ),
    ('hips="agree"', "hips=None"): (
        lambda: nk.naoqi.from_order(NAO, NAO.to_body(Q), "H25", hips="agree"),
        lambda: nk.naoqi.from_order(NAO, NAO.to_body(Q), "H25", hips=None),
    ),
    ("reference=", "near="): (
        lambda: nk.naoqi.from_order(NAO, np.zeros(22), "H21", reference=Q),
        lambda: nk.naoqi.from_order(NAO, np.zeros(22), "H21", near=Q),
    ),
    ("clamped.most", "clamped.largest"): (lambda: Clamped(1, 0.25, "a").most, lambda: Clamped(1, 0.25, "a").largest),
    ("colour_by=", "by="): (
        lambda: nk.reach.workspace(NAO, "LArm", 9, voxel=0.1).save_ply("a.ply", colour_by="count").read_bytes(),
        lambda: nk.reach.workspace(NAO, "LArm", 9, voxel=0.1).save_ply("b.ply", by="count").read_bytes(),
    ),
}
ROWS = [row for row in FORMER_NAMES if not row.where.startswith("nao-kin")]


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.old)
def test_a_former_name_gives_the_same_result_and_one_warning(
    row: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    former, new = CALLS[row.old, row.new]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        expected = new()
    with pytest.warns(FormerNameWarning, match=f"^{re.escape(row.old)} is now {re.escape(row.new)};") as caught:
        found = former()
    assert len(caught) == 1
    assert caught[0].filename == __file__
    assert str(found) == str(expected)


def test_the_documentation_lists_every_former_name() -> None:
    rows = re.findall(r"^\| `(.+?)` \| `(.+?)` \| (.+?) \|$", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    assert rows == [(row.old, row.new, row.where) for row in FORMER_NAMES]
