"""The camera and the program's own controls, as the program sees them, without a browser."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from viewer_pages import messages_of

import nao_kin as nk
from nao_kin.errors import BadArgument, NotARotation, UnknownName, WrongShape
from nao_kin.viewer.overlays import BUTTONS

MENU = Path(__file__).resolve().parents[2] / "web" / "src" / "view_menu.ts"


@pytest.fixture
def viewer(nao: nk.NaoModel) -> nk.Viewer:
    return nk.Viewer(nao)


def _shown(viewer: nk.Viewer, kind: str) -> list[dict[str, Any]]:
    return [message for message in messages_of(viewer.static_html()) if message.get("kind") == kind]


# --- the camera -------------------------------------------------------------------------------------------------------


def test_the_camera_is_where_the_program_or_a_page_put_it_last(viewer: nk.Viewer) -> None:
    assert viewer.camera_pose is None
    T = nk.screws.pose(nk.rotations.rot_z(2.0), [1.0, 2.0, 0.5])
    viewer.camera_pose = T
    assert np.array_equal(viewer.camera_pose, T)
    assert _shown(viewer, "camera")[0]["camera"] == T.T.reshape(-1).tolist()
    moved = nk.screws.pose(nk.rotations.rot_z(1.0), [3.0, 2.0, 0.5])
    viewer._receive({"kind": "camera", "pose": moved.T.reshape(-1).tolist(), "source": "page 1"})
    assert np.array_equal(viewer.camera_pose, moved)
    viewer.camera("top")
    assert _shown(viewer, "camera")[0]["camera"] == "top"
    for wrong in (None, 3, "x", [1.0] * 16, [np.nan] * 16, list(range(15)), {"a": 1}):
        viewer._receive({"kind": "camera", "pose": wrong})
    assert np.array_equal(viewer.camera_pose, moved)
    with pytest.raises(NotARotation):
        viewer.camera_pose = 2.0 * np.eye(4)
    with pytest.raises(WrongShape):
        viewer.camera_pose = np.eye(3)
    with pytest.raises(BadArgument, match="10000 m is shown"):
        viewer.camera_pose = nk.screws.pose(np.eye(3), [1e5, 0.0, 0.0])
    assert np.array_equal(viewer.camera_pose, moved)


def test_the_buttons_are_those_of_the_menu(viewer: nk.Viewer) -> None:
    table = MENU.read_text(encoding="utf-8").partition("const TOGGLES")[2].partition("\n};")[0]
    assert sorted(BUTTONS) == sorted(re.findall(r"^  (\w+): \{", table, re.M))
    viewer.show("orthographic")
    assert viewer.shown["orthographic"]
    viewer.show("orthographic", False)
    assert not viewer.shown["orthographic"]
    with pytest.raises(UnknownName, match="orthographic"):
        viewer.show("ortographic")
