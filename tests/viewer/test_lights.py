"""A NAO's lights on their way to the page, without a browser: which shapes are lights, what is refused."""

from __future__ import annotations

import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
import umsgpack
from made_up_robots import J, made_up
from viewer_pages import messages_of, until

import nao_kin as nk
from nao_kin.cli.naoqi import follow
from nao_kin.errors import UnknownName
from nao_kin.export.meshes import MESH_FOLDER
from nao_kin.naoqi import VirtualNao, light_colours, spoken_words
from nao_kin.robot.nao.model import nao_urdf_path
from nao_kin.viewer import Viewer
from nao_kin.viewer.description import Drawable, robot_drawables
from nao_kin.viewer.meshes import Mesh, pieces

EYES = [f"{side}Eye{number}" for side in ("Left", "Right") for number in range(8)]


@pytest.fixture(scope="module")
def viewer(nao: nk.NaoModel) -> Viewer:
    return Viewer(nao)


@pytest.fixture(scope="module")
def lights(nao: nk.NaoModel) -> dict[str, Drawable]:
    return {drawable.light: drawable for drawable in robot_drawables(nao.tree)[0] if drawable.light}


def _shown(viewer: Viewer, kind: str) -> dict[str, Any]:
    """The newest message of a kind in the page that is saved."""
    return [message for message in messages_of(viewer.static_html()) if message.get("kind") == kind][-1]


def _colours(viewer: Viewer) -> dict[str, list[float]]:
    return {light["name"]: light["rgb"] for light in _shown(viewer, "lights")["lights"]}


def _solid(name: str) -> trimesh.Trimesh:
    """A mesh file, with one vertex where its faces meet."""
    solid = trimesh.load_mesh(nao_urdf_path("v6").parent / MESH_FOLDER / f"{name}.obj")
    solid.merge_vertices(merge_norm=True, merge_tex=True)
    return solid


# --- shapes -----------------------------------------------------------------------------------------------------------


def test_every_version_has_eyes_a_chest_and_feet_that_light(each_nao: nk.NaoModel) -> None:
    names = Viewer(each_nao).light_names
    assert set(names) == {*EYES, "LeftEye", "RightEye", "Chest", "LeftFoot", "RightFoot"}
    assert len(names) == 21


def test_eyes_are_numbered_from_the_top_towards_the_nose(lights: dict[str, Drawable]) -> None:
    for side, sign in (("Left", 1.0), ("Right", -1.0)):
        ring = np.array([lights[f"{side}Eye{number}"].shape.vertices.mean(axis=0) for number in range(8)])
        outwards, upwards = sign * ring[:, 1], ring[:, 2]
        assert (outwards > 0.0).all()
        assert (np.argmax(upwards), np.argmin(upwards)) == (0, 4)
        assert (np.argmin(outwards), np.argmax(outwards)) == (2, 6)
        # The eye looks a little down, and its vertices stand on a grid of 10 µm.
        assert upwards[1] == pytest.approx(upwards[3] + 2 * (upwards[1] - upwards[2]), abs=1e-5)


def test_the_segments_are_the_whole_mesh_and_nothing_else(lights: dict[str, Drawable]) -> None:
    whole = _solid("head_led")
    volumes = sorted(part.volume for part in whole.split())
    segments = [lights[name].shape for name in EYES]
    made = [trimesh.Trimesh(segment.vertices, segment.faces) for segment in segments]
    assert len(volumes) == 16
    assert all(part.is_watertight for part in made)
    assert sorted(part.volume for part in made) == pytest.approx(volumes, rel=1e-9)
    assert sum(len(segment.faces) for segment in segments) == len(whole.faces)


def test_lights_keep_the_look_of_their_mesh_until_they_are_lit(lights: dict[str, Drawable]) -> None:
    assert {lights[name].rgba for name in lights} == {(0.7, 0.89, 1.0, 1.0)}
    assert [lights[name].link for name in ("LeftEye3", "Chest", "LeftFoot", "RightFoot")] == [
        *("Head", "torso", "l_ankle", "r_ankle")
    ]


def test_pieces_of_a_mesh_touch_nowhere() -> None:
    """Two boxes whose faces meet in no vertex of the list, only in places; and a box that stands alone."""
    box = trimesh.creation.box(extents=(1.0, 1.0, 1.0))
    box.unmerge_vertices()
    places = (0.0, 5.0, 1.0)
    vertices = np.concatenate([box.vertices + np.array([x, 0.0, 0.0]) for x in places])
    faces = np.concatenate([box.faces + 36 * k for k in range(3)])
    found = pieces(Mesh(vertices, np.ones_like(vertices), faces.astype(np.uint32), (1.0, 0.0, 0.0, 1.0)))
    assert [len(piece.faces) for piece in found] == [24, 12]
    assert [piece.vertices[:, 0].min() for piece in found] == [-0.5, 4.5]
    assert np.ptp(found[0].vertices, axis=0).tolist() == [2.0, 1.0, 1.0]
    assert found[1].vertices[found[1].faces].tolist() == vertices[faces[12:24]].tolist()
    assert {piece.colour for piece in found} == {(1.0, 0.0, 0.0, 1.0)}


def test_other_robots_have_no_lights(tmp_path: Path) -> None:
    trimesh.creation.box(extents=(0.1, 0.1, 0.1)).export(tmp_path / "head_led.obj")
    path = tmp_path / "other.urdf"
    mesh = '<visual><geometry><mesh filename="head_led.obj"/></geometry></visual>'
    path.write_text(f'<robot name="other"><link name="head">{mesh}</link></robot>', encoding="utf-8")
    for robot in (nk.RobotModel.from_urdf(path), made_up(tmp_path, J("turn"))):
        viewer = Viewer(robot)
        assert (viewer.light_names, viewer.notes) == ((), ())
        viewer.show_lights({})
        with pytest.raises(UnknownName, match=r"unknown light 'Chest' \(there are none\)"):
            viewer.show_lights({"Chest": (1.0, 0.0, 0.0)})


# --- what is sent -----------------------------------------------------------------------------------------------------


def test_a_group_is_all_its_lights_and_a_light_beside_it_its_own(viewer: Viewer) -> None:
    red, blue = [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]
    for colours in ({"LeftEye3": red, "LeftEye": blue}, {"LeftEye": blue, "LeftEye3": red}):
        viewer.show_lights(colours)
        assert _colours(viewer) == {f"LeftEye{n}": red if n == 3 else blue for n in range(8)}
    viewer.show_lights({"Chest": np.array([0, 1, 0])})
    assert _colours(viewer) == {"Chest": [0.0, 1.0, 0.0]}
    viewer.show_lights({})
    assert _colours(viewer) == {}


# --- the virtual NAO --------------------------------------------------------------------------------------------------


def test_every_led_but_those_of_ears_and_head_has_a_light_of_its_own(viewer: Viewer) -> None:
    with VirtualNao(viewer.robot, stepped=True) as robot:
        for number, led in enumerate(robot.state().leds):
            robot.call("ALLeds", "fadeRGB", led, number / 100.0, 0.0, 1.0 - number / 100.0, 0.0)
        leds = robot.state().leds
    colours = light_colours(leds)
    assert set(colours) == {*EYES, "Chest", "LeftFoot", "RightFoot"}
    assert len(set(colours.values())) == 19
    assert colours["LeftEye3"] == leds["FaceLedLeft3"]
    assert colours["RightEye7"] == leds["FaceLedRight7"]
    assert (colours["Chest"], colours["LeftFoot"]) == (leds["ChestLeds"], leds["LeftFootLeds"])
    viewer.show_lights(colours)
    assert light_colours({"LeftEarLed1": (0.0, 0.0, 1.0), "Brain3": (1.0, 1.0, 1.0)}) == {}


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("Hello", "Hello"),
        ("", ""),
        (r"\rspd=80\Slowly \pau=500\now", "Slowly now"),
        ("^start(animations/Stand/Gestures/Hey_1) Hello ^wait(animations/Stand/Gestures/Hey_1)", "Hello"),
        (r"C:\temp and 2^3", r"C:\temp and 2^3"),
    ],
)
def test_tags_are_not_said(text: str, said: str) -> None:
    assert spoken_words(text) == said


def test_the_live_page_follows_lights_when_they_change(nao: nk.NaoModel) -> None:
    viewer, ended = Viewer(nk.load_nao(base="floating")), threading.Event()
    sent: list[str] = []
    viewer._messages.watch(sent.append)

    def newest(key: str) -> dict[str, Any]:
        return umsgpack.unpackb(viewer._messages.get(key) or umsgpack.packb({"lights": []}))

    def rgb(name: str) -> list[float] | None:
        return next((light["rgb"] for light in newest("lights")["lights"] if light["name"] == name), None)

    with VirtualNao(nao, stepped=True) as robot:
        thread = threading.Thread(target=follow, args=(robot, viewer, ended))
        thread.start()
        assert until(lambda: rgb("LeftEye0") == [1.0, 1.0, 1.0])
        robot.call("ALLeds", "fadeRGB", "FaceLeds", "blue", 0.0)
        assert until(lambda: rgb("LeftEye0") == rgb("RightEye7") == [0.0, 0.0, 1.0])
        assert rgb("Chest") == [1.0, 1.0, 1.0]
        before = len(sent)
        time.sleep(0.3)
        assert len(sent) == before  # nothing new, nothing sent
        ended.set()
        thread.join(5.0)
        assert not thread.is_alive()
