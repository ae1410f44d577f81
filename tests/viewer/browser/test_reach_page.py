"""Reach maps in the viewer's page, in a real browser: which voxels are drawn, where, and what cuts them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from viewer_pages import Page, messages_of, opened

import nao_kin as nk
from nao_kin.errors import BadArgument, NotFinite, UnknownName
from nao_kin.reach import ReachMap, workspace
from nao_kin.viewer import Viewer

# Middles of the voxels that are drawn, in the frame of the robot's root; one after another.
DRAWN = """() => {
    const { Matrix4, Vector3 } = MeshCat.THREE;
    naoKin.settle();
    const { mesh } = naoKin.reach;
    mesh.updateWorldMatrix(true, false);
    const toRoot = new Matrix4().copy(naoKin.robot.root.matrixWorld).invert().multiply(mesh.matrixWorld);
    const one = new Matrix4();
    return Array.from({ length: mesh.count }, (_, i) => {
        mesh.getMatrixAt(i, one);
        return new Vector3().setFromMatrixPosition(one).applyMatrix4(toRoot).toArray();
    });
}"""
COLOUR = """(place) => {
    const [i] = naoKin.reach.voxels
        .map(({ centre }, i) => [i, Math.hypot(...centre.map((x, k) => x - place[k]))])
        .sort((a, b) => a[1] - b[1])[0];
    const colour = new MeshCat.THREE.Color();
    naoKin.reach.mesh.getColorAt(i, colour);
    return colour.convertLinearToSRGB().toArray();
}"""

# How many clouds of voxels are anywhere under a node.
CLOUDS = """(node) => {
    let clouds = 0;
    const nodes = { scene: naoKin.viewer.scene, ghost: naoKin.ghosts.group };
    nodes[node].traverse((child) => (clouds += child.isInstancedMesh ? 1 : 0));
    return clouds;
}"""


@pytest.fixture(scope="module")
def reach(nao: nk.NaoModel) -> ReachMap:
    return workspace(nao, "LArm", 30_000, voxel=0.03)


@pytest.fixture(scope="module")
def page(browser: Any, nao: nk.NaoModel, reach: ReachMap, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    viewer = Viewer(nao)
    viewer.display(nao.posture("StandInit"))
    viewer.show_reach(reach, cut=("y", 0.15))
    with opened(browser, viewer.save_html(tmp_path_factory.mktemp("reach") / "reach.html")) as page:
        yield page


def rows(points: np.ndarray) -> list[tuple[float, ...]]:
    return sorted(map(tuple, np.round(np.asarray(points).reshape(-1, 3), 6).tolist()))


def slider(page: Page) -> Any:
    return page.tab.get_by_label("Position of the cut")


def put(page: Page, place: float) -> None:
    slider(page).evaluate(
        "(slider, value) => { slider.value = value; slider.dispatchEvent(new Event('input', {bubbles: true})); }", place
    )


def choose(page: Page, axis: str) -> None:
    page.tab.get_by_label("Axis of the cut").select_option(axis)


@pytest.mark.full
def test_the_page_opens_with_the_cut_that_was_asked_for(page: Page, reach: ReachMap) -> None:
    assert page.tab.locator("#cut").is_visible()
    assert page.tab.locator("#cut output").inner_text() == "y < 150 mm"
    assert rows(page.run(DRAWN)) == rows(reach.centres[reach.centres[:, 1] < 0.15])


def test_every_axis_cuts_where_the_slider_stands_and_either_side_can_be_seen(page: Page, reach: ReachMap) -> None:
    for column, axis in enumerate("xyz"):
        choose(page, axis)
        along = reach.centres[:, column]
        least, most = along.min() - 0.015, along.max() + 0.015
        assert float(slider(page).get_attribute("min")) == pytest.approx(least)
        assert float(slider(page).get_attribute("max")) == pytest.approx(most)
        assert float(slider(page).input_value()) == pytest.approx((least + most) / 2)
        put(page, 0.031)
        assert rows(page.run(DRAWN)) == rows(reach.centres[along < 0.031])
        assert page.tab.locator("#cut output").inner_text() == f"{axis} < 31 mm"
        page.tab.get_by_title("Show the other side").click()
        assert rows(page.run(DRAWN)) == rows(reach.centres[along > 0.031])
        assert page.tab.locator("#cut output").inner_text() == f"{axis} > 31 mm"
        page.tab.get_by_title("Show the other side").click()


def test_the_best_voxel_is_warm_and_the_worst_cold_in_the_cut_through_them(page: Page, reach: ReachMap) -> None:
    middle = int(np.argmin(np.abs(reach.best - (reach.best.min() + reach.best.max()) / 2)))
    for i, expected, within in (
        (np.argmax(reach.best), [0.74, 0.17, 0.12], 1e-3),
        (np.argmin(reach.best), [0.16, 0.32, 0.66], 1e-3),
        (middle, [0.90, 0.91, 0.88], 0.05),
    ):
        choose(page, "z")
        put(page, reach.centres[i][2] + 0.001)
        assert page.run(COLOUR, reach.centres[i].tolist()) == pytest.approx(expected, abs=within)
        put(page, 9.0)
        assert sum(page.run(COLOUR, reach.centres[i].tolist())) < 0.95 * sum(expected)


def test_the_legend_names_what_is_coloured(page: Page, reach: ReachMap) -> None:
    text = " ".join(page.tab.locator("#legend").inner_text().split())
    assert text == f"LArm: best manipulability [m³] {reach.best.min():.5f} {reach.best.max():.5f}"


@pytest.mark.full
def test_the_voxels_move_with_their_reference(browser: Any, nao: nk.NaoModel, tmp_path: Path) -> None:
    reach = workspace(nao, "LArm", 3000, voxel=0.05, reference="Head")
    viewer = Viewer(nao)
    viewer.show_reach(reach, by="coverage", cut=("x", 9.0))
    with opened(browser, viewer.save_html(tmp_path / "a.html")) as page:
        for q in nao.random(3, 2):
            page.set(q)
            T = nao.fk(q, "Head")
            expected = reach.centres @ T[:3, :3].T + T[:3, 3]
            order = np.argsort(reach.centres[:, 0], kind="stable")
            assert np.abs(np.array(page.run(DRAWN)) - expected[order]).max() < 1e-5
        page.tab.locator("button.view").click()
        page.tab.get_by_role("button", name="Keep as ghost").click()
        assert page.run("() => naoKin.ghosts.copies.length") > 20
        assert page.run(CLOUDS, "ghost") == 0


@pytest.mark.full
def test_a_live_page_takes_it_away_and_shows_another(browser: Any, nao: nk.NaoModel, reach: ReachMap) -> None:
    with Viewer(nao) as viewer, opened(browser, viewer.url) as page:
        assert page.run(CLOUDS, "scene") == 0
        assert page.tab.locator("#cut").is_hidden()
        viewer.show_reach(reach)
        page.tab.wait_for_selector("#cut:not([hidden])")
        viewer.show_reach(reach.coarser(2), by="count")
        page.tab.wait_for_function("() => naoKin.reach.voxel > 0.05")
        assert page.run(CLOUDS, "scene") == 1
        assert "samples" in page.tab.locator("#legend").inner_text()
        viewer.show_reach(None)
        page.tab.wait_for_selector("#cut", state="hidden")
        assert page.run(CLOUDS, "scene") == 0
        assert page.tab.locator("#legend").is_hidden()


def test_too_many_voxels_are_drawn_coarser(nao: nk.NaoModel) -> None:
    fine = workspace(nao, "LArm", 200_000, voxel=0.004)
    assert len(fine.count) > 40_000
    viewer = Viewer(nao)
    viewer.show_reach(fine)
    (message,) = (m for m in messages_of(viewer.static_html()) if m.get("kind") == "reach")
    assert 10_000 < len(message["values"].data) // 2 <= 40_000
    assert message["voxel"] == pytest.approx(0.008)


def test_a_map_without_differences_is_shown_too(nao: nk.NaoModel) -> None:
    viewer = Viewer(nao)
    viewer.show_reach(workspace(nao, "LArm", 1), by="count")
    (message,) = (m for m in messages_of(viewer.static_html()) if m.get("kind") == "reach")
    assert (message["low"], message["high"], message["values"].data) == ("1", "1", b"\0\0")


def test_what_cannot_be_shown_is_refused(nao: nk.NaoModel, reach: ReachMap) -> None:
    viewer = Viewer(nao)
    before = viewer.static_html()
    with pytest.raises(UnknownName, match="column of a reach map 'worst'"):
        viewer.show_reach(reach, by="worst")
    with pytest.raises(BadArgument, match="is of nao_v5, and the viewer shows nao_v6"):
        viewer.show_reach(replace(reach, settings=replace(reach.settings, robot="nao_v5")))
    with pytest.raises(UnknownName, match="unknown frame 'Nowhere'"):
        viewer.show_reach(replace(reach, settings=replace(reach.settings, reference="Nowhere")))
    with pytest.raises(UnknownName, match="axis"):
        viewer.show_reach(reach, cut=("a", 0.1))
    with pytest.raises(NotFinite, match="cut"):
        viewer.show_reach(reach, cut=("x", float("nan")))
    nothing = {name: getattr(reach, name)[:0] for name in nk.reach.reach_map.ROW_ARRAYS}
    with pytest.raises(BadArgument, match="empty"):
        viewer.show_reach(replace(reach, ranges=(), **nothing))
    assert viewer.static_html() == before
