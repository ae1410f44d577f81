"""What the methods of a viewer refuse: each with its error, in one line, and nothing changes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import nao_kin as nk
from nao_kin.errors import BadArgument, NaoKinError, NotARotation, NotFinite, UnknownName, WrongShape, ZeroNorm
from nao_kin.viewer import Viewer

HERE, MIRRORED = [0.0, 0.0, 0.0], np.diag([1.0, 1.0, -1.0, 1.0])
POINTS, FACES, Q = np.zeros((4, 3)), [[0, 1, 2]], np.zeros((2, 25))
SOLID = np.vstack([np.eye(3), np.zeros(3)])
HALF = "\ud800"  # of a surrogate pair

REFUSED: dict[type[NaoKinError], dict[str, Callable[[Viewer], object]]] = {
    WrongShape: {
        "24 values": lambda v: v.display(np.zeros(24)),
        "flat vertical": lambda v: v.display(Q[0], up=[0.0, 1.0]),
        "one frame": lambda v: v.animate(Q[0]),
        "no frames": lambda v: v.animate(Q[:0]),
        "three verticals for two": lambda v: v.animate(Q, up=np.ones((3, 3))),
        "3×4 target": lambda v: v.show_targets({"a": np.zeros((3, 4))}),
        "two colours": lambda v: v.show_lights({"Chest": (1.0, 0.0)}),
        "image with opacity": lambda v: v.show_image("CameraTop", np.zeros((2, 2, 4), np.uint8)),
        "two values": lambda v: v.plot("a", [1.0, 2.0]),
        "colours of others": lambda v: v.add_points("a", POINTS, colors=np.zeros((3, 3))),
        "line of a point": lambda v: v.add_line("a", POINTS[:1]),
        "edges": lambda v: v.add_mesh("a", SOLID, [[0, 1]]),
    },
    NotFinite: {
        "nan": lambda v: v.display(np.full(25, np.nan)),
        "infinite vertical": lambda v: v.display(Q[0], up=[0.0, 0.0, np.inf]),
        "nan colour": lambda v: v.color_links({"Head": np.nan}),
        "nan in a plot": lambda v: v.plot("a", np.nan),
        "nan point": lambda v: v.add_points("a", [[0.0, np.nan, 0.0]]),
    },
    NotARotation: {
        "mirrored target to drag": lambda v: v.add_target("a", MIRRORED),
    },
    ZeroNorm: {"no vertical": lambda v: v.display(Q[0], up=HERE)},
    UnknownName: {
        "LArm": lambda v: v.show_frames(["LArn"]),
        "right": lambda v: v.save_png("x.png", camera="rigt"),
        "Head": lambda v: v.color_links({"Heed": 1.0}),
        "Sit": lambda v: v.rest("Sitt"),
        "LeftEye": lambda v: v.show_lights({"LeftEye8": (1, 1, 1)}),
        "CameraTop": lambda v: v.show_image("CameraTpo", None),
        "LHand": lambda v: v.add_points("a", POINTS, frame="LHant"),
        "left": lambda v: v.add_select("a", ["left"], "lefft"),
        "speed": lambda v: v.plot("known", {"sped": 1.0}),
        "plot": lambda v: v.plot("other", None),
        "shape": lambda v: v.remove("other"),
    },
    BadArgument: {
        "text": lambda v: v.display("Stand"),
        "no rate": lambda v: v.animate(Q, fps=0.0),
        "no size": lambda v: v.show_frames(["LArm"], size=0.0),
        "no opacity": lambda v: v.show_ghosts(Q, opacity=0.0),
        "more than opaque": lambda v: v.add_robot(v.robot, opacity=1.5),
        "no name": lambda v: v.add_robot(v.robot, name=""),
        "long name": lambda v: v.add_points("x" * 201, POINTS),
        "half a letter": lambda v: v.show_targets({HALF: HERE}),
        "scale from high to low": lambda v: v.color_links({"Head": 1.0}, low=2.0, high=1.0),
        "name of a colour": lambda v: v.add_line("a", POINTS, color="red"),
        "image of floats": lambda v: v.show_image("CameraTop", np.zeros((2, 2))),
        "another format": lambda v: v.show_image("CameraTop", b"GIF89a"),
        "no values": lambda v: v.plot("a", {}),
        "empty range": lambda v: v.add_slider("a", 1.0, 1.0),
        "value outside": lambda v: v.add_slider("a", 0.0, 1.0, 2.0),
        "no options": lambda v: v.add_select("a", []),
        "number as a text": lambda v: v.add_text("a", 3),
        "no faces": lambda v: v.add_mesh("a", POINTS),
        "no area": lambda v: v.add_mesh("a", POINTS, FACES),
        "corner that is none": lambda v: v.add_mesh("a", SOLID, [[0, 1, 4]]),
        "half a corner": lambda v: v.add_mesh("a", SOLID, [[0, 1, 0.5]]),
        "no file": lambda v: v.add_mesh("a", Path("nowhere.stl")),
        "no mesh": lambda v: v.add_mesh("a", Path(__file__)),
        "no timeout": lambda v: v.save_png("x.png", timeout="x"),
        "path that is a number": lambda v: v.save_html(3),
    },
}
ROWS = [(error, what, call) for error, rows in REFUSED.items() for what, call in rows.items()]


@pytest.fixture(scope="module")
def viewer(nao: nk.NaoModel) -> Viewer:
    viewer = Viewer(nao)
    viewer.plot("known", {"speed": 1.0})
    viewer._streams.flush()
    return viewer


@pytest.mark.parametrize(("error", "what", "call"), ROWS, ids=[what for _, what, _ in ROWS])
def test_it_is_refused_in_one_line_and_nothing_changes(
    viewer: Viewer, error: type[NaoKinError], what: str, call: Callable[[Viewer], object]
) -> None:
    before = viewer._messages.messages()
    with pytest.raises(error) as refused:
        call(viewer)
    assert "\n" not in str(refused.value)
    assert error is not UnknownName or what in str(refused.value)  # the nearest name
    assert viewer._messages.messages() == before
