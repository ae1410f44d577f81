"""No package that an installation brings is under a copyleft licence that docs/licences.md does not name."""

from __future__ import annotations

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))

import generate_licences as licences  # noqa: E402, from the folder of scripts


def test_no_package_of_an_installation_is_under_a_copyleft_licence_but_those_that_the_page_names() -> None:
    core, whole = licences.required(), licences.required("all")
    assert {"pin", "numpy", "libpinocchio"} <= core < whole  # required by packages that are required, too
    found = {name: licences.licence(name) for name in whole if licences.COPYLEFT.search(licences.licence(name))}
    assert found.keys() <= {"certifi", "jrl-cmakemodules"}, found
    assert found.keys() & core <= {"certifi"}
    page = licences.PAGE.read_text(encoding="utf-8")
    assert all(page.count(name) > 1 for name in found)  # in the text, and in the table
    assert "not stated" not in licences.table()


def test_a_copyleft_licence_is_recognised() -> None:
    for text in ("LGPL-3.0-or-later", "GNU Affero General Public License v3", "MPL-2.0", "AGPL-3.0-only"):
        assert licences.COPYLEFT.search(text)
    assert not any(map(licences.COPYLEFT.search, ("MIT", "BSD-3-Clause", "Apache-2.0 WITH LLVM-exception", "PSF-2.0")))
