"""No part of the project outgrows its budget, the last column of a table in docs/architecture.md."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from sizes import ROOT, size

TABLE = "## Products and their budgets"
# Lines that a budget may have more than its product, so that what leaves is not used up by what comes.
SLACK = 150


def budgets(page: str) -> dict[str, tuple[list[str], int]]:
    """Return product → its files and folders, and its lines."""
    table = page.split(TABLE)[1].split("\n## ")[0]
    rows = re.findall(r"^\| ([\w ]+) \| (.*?) \|.*\| ([\d ]+) \|$", table, re.MULTILINE)
    return {name: (re.findall(r"`([\w/.]+)`", places), int(lines.replace(" ", ""))) for name, places, lines in rows}


BUDGETS = budgets((ROOT / "docs" / "architecture.md").read_text(encoding="utf-8"))


def excess(places: list[str], lines: int, root: Path = ROOT) -> str:
    """Return what to do about a product that has outgrown its budget, or whose budget is too large; "" if neither."""
    has = size(places, root)
    if has > lines:
        return f"{has} lines, {has - lines} more than its budget: delete something, or raise it in a commit of its own"
    if has < lines - SLACK:
        return f"{has} lines: lower its budget of {lines}"
    return ""


@pytest.mark.parametrize("product", BUDGETS)
def test_a_product_stays_within_its_budget(product: str) -> None:
    places, lines = BUDGETS[product]
    assert not excess(places, lines)


def test_every_file_of_the_package_belongs_to_one_product() -> None:
    places = [place for places, _ in BUDGETS.values() for place in places if place.startswith("nao_kin")]
    assert len(places) == len(set(places))
    assert size(places) == size(["nao_kin"])


def test_a_product_that_grows_is_noticed(tmp_path: Path) -> None:
    room = tmp_path / "nao_kin" / "screws"
    room.mkdir(parents=True)
    module = room / "lines.py"
    module.write_text('"""Lines."""\n\n# A comment.\nx = 1\n')
    assert not excess(["nao_kin/screws"], 1, tmp_path)
    module.write_text('"""Lines."""\n\n# A comment.\nx = 1\ny = 2\n')
    assert excess(["nao_kin/screws"], 1, tmp_path).startswith("2 lines, 1 more than its budget")
    assert excess(["nao_kin/screws"], 1000, tmp_path).endswith("lower its budget of 1000")
