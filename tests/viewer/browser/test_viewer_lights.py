"""Lights in the viewer's page, in a real browser: which shapes shine, and how they look."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from viewer_pages import Page, opened

import nao_kin as nk
from nao_kin.viewer import Viewer
from nao_kin.viewer.description import robot_drawables

pytestmark = pytest.mark.full

# Of a light: colour and light of its material as the screen has them, and its glow.
LOOK = """(name) => {
    const { mesh, glow } = naoKin.lights.shapes.get(name);
    const screen = (colour) => colour.clone().convertLinearToSRGB().toArray();
    return [screen(mesh.material.color), screen(mesh.material.emissive), glow.visible, mesh.material.type];
}"""
# Where the middles of lights are in the picture, as shares of its width and height.
SEEN = """(names) => {
    naoKin.settle();
    naoKin.viewer.camera.updateMatrixWorld();
    return names.map((name) => {
        const { mesh } = naoKin.lights.shapes.get(name);
        const { x, y } = mesh.localToWorld(mesh.geometry.boundingSphere.center.clone()).project(naoKin.viewer.camera);
        return [(1 + x) / 2, (1 - y) / 2];
    });
}"""
RAINBOW = [(1, 0, 0), (1, 0.5, 0), (1, 1, 0), (0, 1, 0), (0, 1, 1), (0, 0.25, 1), (0.5, 0, 1), (1, 0, 0.5)]
OWN = (0.7, 0.89, 1.0)
COLOURS: dict[str, tuple[float, ...]] = {f"LeftEye{n}": colour for n, colour in enumerate(RAINBOW)}
COLOURS |= {f"RightEye{n}": colour for n, colour in enumerate(RAINBOW)}
COLOURS |= {"Chest": (0, 0.5, 0), "LeftFoot": (0, 0, 0)}


@pytest.fixture
def viewer(nao: nk.NaoModel) -> Viewer:
    viewer = Viewer(nao)
    viewer.display(nao.posture("Stand"))
    return viewer


@pytest.fixture(scope="module")
def page(browser: Any, nao: nk.NaoModel, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    """A page from disk that was saved with lights, shared: each test shows its own first."""
    viewer = Viewer(nao)
    viewer.display(nao.posture("Stand"))
    viewer.show_lights(COLOURS)
    with opened(browser, viewer.save_html(tmp_path_factory.mktemp("viewer") / "lights.html"), (900, 600)) as page:
        yield page


def _show(page: Page, colours: dict[str, tuple[float, ...]]) -> None:
    rows = [{"name": name, "rgb": rgb} for name, rgb in colours.items()]
    page.run("(lights) => naoKin.receive({ kind: 'lights', lights })", rows)


# --- lights -----------------------------------------------------------------------------------------------------------


def test_a_saved_page_opens_with_its_lights_on(page: Page) -> None:
    _show(page, COLOURS)
    for name, rgb in COLOURS.items():
        colour, light, glows, material = page.run(LOOK, name)
        assert np.allclose(light, rgb, atol=1e-4), name
        assert max(colour) < 0.25, f"{name} is dark glass"
        assert glows == (max(rgb) > 0.0)
        assert material == "MeshStandardMaterial"
    own, light, glows, _ = page.run(LOOK, "RightFoot")
    assert np.allclose(own, OWN, atol=0.002)
    assert (light, glows) == ([0.0, 0.0, 0.0], False)


def test_each_light_is_the_shape_that_bears_its_name(page: Page, nao: nk.NaoModel) -> None:
    places = page.run(
        """() => [...naoKin.lights.shapes].map(([name, { mesh, link }]) => {
            if (!mesh.geometry.boundingBox) mesh.geometry.computeBoundingBox();
            const { min, max } = mesh.geometry.boundingBox;
            return [name, naoKin.robot.about.links[link].name, [...min.toArray(), ...max.toArray()]];
        })"""
    )
    drawables = {drawable.light: drawable for drawable in robot_drawables(nao.tree)[0] if drawable.light}
    assert {name for name, _, _ in places} == set(drawables)
    for name, link, box in places:
        vertices = drawables[name].shape.vertices
        assert link == drawables[name].link
        assert np.allclose(box, [*vertices.min(axis=0), *vertices.max(axis=0)], atol=1e-6)


def test_a_lit_light_outshines_the_colour_of_its_link_and_red(page: Page, nao: nk.NaoModel) -> None:
    head = "() => [{ link: naoKin.robot.about.links.findIndex(({ name }) => name === 'Head'), rgb: [1, 1, 0] }]"
    colour = "(links) => naoKin.receive({ kind: 'colours', links, label: '', low: '', high: '', stops: null })"
    _show(page, {"LeftEye0": (0.0, 0.0, 1.0)})
    page.run(colour, page.run(head))
    assert max(page.run(LOOK, "LeftEye0")[0]) < 0.25
    assert page.run(LOOK, "LeftEye1")[0] == pytest.approx([1.0, 1.0, 0.0], abs=1e-4)
    page.set(nao.configuration({"HeadPitch": 1.0}, limits="ignore"))
    assert max(page.run(LOOK, "LeftEye0")[0]) < 0.25
    _show(page, {})
    red = page.run(LOOK, "LeftEye0")[0]
    assert red[0] > red[1] + 0.2  # mostly red, for the joint is outside its limits
    page.set(nao.posture("Stand"))
    assert page.run(LOOK, "LeftEye0")[0] == pytest.approx([1.0, 1.0, 0.0], abs=1e-4)
    page.run(colour, [])
    assert np.allclose(page.run(LOOK, "LeftEye0")[0], OWN, atol=0.002)


def test_neither_ghosts_nor_the_size_of_the_robot_have_glows(page: Page, nao: nk.NaoModel) -> None:
    _show(page, {})
    count = "() => { let n = 0; naoKin.ghosts.group.traverse((node) => (n += node.isSprite ? 1 : 0)); return n; }"
    ghosts = """(qs) => naoKin.receive({
        kind: 'ghosts', qs: new Float64Array(qs.flat()), count: qs.length, opacity: 0.3, first: null,
    })"""
    box = "() => { const { min, max } = naoKin.robot.box([]); return [...min.toArray(), ...max.toArray()]; }"
    dark = page.run(box)
    _show(page, COLOURS)
    page.run(ghosts, [nao.posture("Crouch").tolist()])
    assert page.run("() => naoKin.ghosts.group.children.length") > 10
    assert page.run(count) == 0
    assert page.run(box) == dark
    page.run(ghosts, [])


def test_the_picture_shows_each_segment_in_its_colour(page: Page, nao: nk.NaoModel) -> None:
    page.set(nao.posture("Stand"))
    _show(page, COLOURS)
    page.draw(True)
    page.run("() => naoKin.show({ handles: false })")
    page.run(
        """() => {
            const { camera, controls } = naoKin.viewer;
            naoKin.camera("front");
            camera.fov = 9;  // the face, from the front
            camera.updateProjectionMatrix();
            const [eye, other] = ["LeftEye2", "RightEye2"].map((name) => {
                const { mesh } = naoKin.lights.shapes.get(name);
                return mesh.localToWorld(mesh.geometry.boundingSphere.center.clone());
            });
            controls.target.copy(eye.add(other).multiplyScalar(0.5));
            camera.position.y = controls.target.y;
            controls.update();
            naoKin.viewer.set_dirty();
        }"""
    )
    names = [name for name in COLOURS if "Eye" in name]
    shares = np.array(page.run(SEEN, names))
    picture = page.picture()
    rows, columns = (shares[:, ::-1] * picture.shape[:2]).astype(int).T
    for name, seen in zip(names, picture[rows, columns].astype(float) / 255.0, strict=True):
        assert np.abs(seen - COLOURS[name]).max() < 0.3, f"{name}: {seen}"
    _show(page, dict.fromkeys(names, (0.0, 0.0, 0.0)))
    assert page.picture()[rows, columns].max() < 110
    page.draw(False)
    page.run("() => { naoKin.show({ handles: true }); naoKin.camera('three-quarter'); }")


def test_a_glow_is_seen_from_where_its_light_is_seen(page: Page, nao: nk.NaoModel) -> None:
    page.set(nao.posture("Stand"))
    _show(page, {"Chest": (0.5, 0.0, 0.0), "LeftEye0": (1.0, 0.0, 0.0)})
    strength = """(back) => {
        const { camera, controls } = naoKin.viewer;
        naoKin.camera("front");
        if (back) camera.position.x *= -1;
        controls.update();
        naoKin.viewer.render();
        return ["Chest", "LeftEye0"].map((name) => naoKin.lights.shapes.get(name).glow.material.opacity);
    }"""
    chest, eye = page.run(strength, False)
    assert 0.0 < chest == pytest.approx(eye / 2)
    assert page.run(strength, True) == [0.0, 0.0]
