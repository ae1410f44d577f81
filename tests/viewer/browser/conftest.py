from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from viewer_pages import Page, opened

import nao_kin as nk
from nao_kin.viewer import Viewer


@pytest.fixture(scope="module")
def document(nao: nk.NaoModel, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A page with a standing robot and nothing else; a module may have another one."""
    viewer = Viewer(nao)
    viewer.display(nao.posture("StandInit"))
    return viewer.save_html(tmp_path_factory.mktemp("viewer") / "nao.html")


@pytest.fixture(scope="module")
def shared(browser: Any, document: Path, request: pytest.FixtureRequest) -> Iterator[Page]:
    """The open document of a module, in a window of the module's `SIZE`."""
    with opened(browser, document, getattr(request.module, "SIZE", (760, 420))) as page:
        yield page


@pytest.fixture
def page(shared: Page, nao: nk.NaoModel) -> Page:
    """The page that all tests of a module share, as it was after opening, the robot standing."""
    shared.reset(nao.posture("StandInit"))
    return shared


@pytest.fixture(scope="module")
def shared_phone(browser: Any, document: Path) -> Iterator[Page]:
    with opened(browser, document, (390, 844), has_touch=True, is_mobile=True) as page:
        yield page


@pytest.fixture
def phone(shared_phone: Page, nao: nk.NaoModel) -> Page:
    """The same document on a phone, for fingers."""
    shared_phone.reset(nao.posture("StandInit"))
    return shared_phone
