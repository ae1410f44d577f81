"""The reference names everything public, in the words of the code."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from public_names import ROOMS, TOP, called, offered
from site_pages import built_site

import nao_kin as nk

pytestmark = pytest.mark.full

REFERENCE = Path(__file__).resolve().parents[2] / "docs" / "reference"


@pytest.fixture(scope="module")
def site() -> Path:
    return built_site()


@pytest.fixture(scope="module")
def documented(site: Path) -> set[str]:
    """Every Python name that the site has an entry for, without the package's."""
    import posixpath

    from sphinx.util.inventory import InventoryFile

    with (site / "objects.inv").open("rb") as file:
        inventory = InventoryFile.load(file, "", posixpath.join)
    names = {name for domain, names in inventory.items() if domain.startswith("py:") for name in names}
    # A room inside another one is known by a name of the package, too: nao_kin.robot.urdf is nk.urdf.
    also = {
        name.replace(room.__name__, f"nao_kin.{short}", 1)
        for short, room in ROOMS.items()
        for name in names
        if name.startswith(f"{room.__name__}.")
    }
    return {name.removeprefix("nao_kin.") for name in names | also if name.startswith("nao_kin.")}


def _value(name: str) -> Any:
    value: Any = nk
    for part in name.split("."):
        value = getattr(value, part, None)
    return value


def test_every_public_name_has_an_entry(documented: set[str]) -> None:
    # Some stand under another of their names: viewer.Viewer.display is Viewer.display.
    entries = {id(getattr(_value(name), "__func__", _value(name))) for name in documented if callable(_value(name))}
    missing = [name for name, value in (*offered(), *called()) if name not in documented and id(value) not in entries]
    assert not missing


def test_no_entry_shows_what_an_alias_stands_for(site: Path) -> None:
    for page in (site / "reference").glob("*.html"):
        text = page.read_text(encoding="utf-8")
        assert not re.search(r"_Buffer|_SupportsArray|_NestedSequence|TypeAliasForwardRef|>Floats<", text), page.name
    assert "ArrayLike" in (site / "reference" / "robot.html").read_text(encoding="utf-8")


def test_entries_show_names_as_programs_write_them(site: Path) -> None:
    shown = {"ik": "nk.ik.", "lines": "nk.screws.lines.", "robot": "nk.", "parameters": "nk.parameters."}
    found = {}
    for page in (site / "reference").glob("*.html"):
        text = page.read_text(encoding="utf-8")
        prefixes = set(re.findall(r'class="sig-prename descclassname"><span class="pre">([^<]*)', text))
        assert all(prefix.startswith(("nk.", "nao.")) for prefix in prefixes), page.name
        found[page.stem] = prefixes
        # Types name no internal module; examples show what Python prints.
        text = re.sub(r"<pre>.*?</pre>", "", text, flags=re.DOTALL)
        assert not re.search(r"nao_kin\.\w+\.\w+\.[A-Z]\w*</", text), page.name
    assert all(prefix in found[page] for page, prefix in shown.items()), found
    assert 'href="#nao_kin.ik.leg"' in (site / "reference" / "ik.html").read_text(encoding="utf-8")


def test_every_room_has_its_page_in_the_table() -> None:
    table = (REFERENCE / "index.md").read_text(encoding="utf-8")
    for name in TOP:
        assert f"`{name}`" in table or f"`nao_kin.{name}`" in table, name
