"""How the page shows the robot: how much it draws, labels, colours, the robot's cameras, pictures and films."""

from __future__ import annotations

import base64
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from viewer_pages import Page, opened, read_png

import nao_kin as nk
from nao_kin.cli.app import run
from nao_kin.errors import NoBrowser
from nao_kin.viewer import Viewer

# Count what is drawn from now on: pictures at their best, and pictures of a movement.
COUNT = """() => {
    window.pictures = { fine: 0, fast: 0 };
    const { smoothing, fastLook } = naoKin.studio;
    for (const [name, who] of [["fine", smoothing], ["fast", fastLook]]) {
        const draw = Object.getPrototypeOf(who).draw.bind(who);
        who.draw = (...given) => { pictures[name] += 1; draw(...given); };
    }
}"""
COLOURS = (
    "(links) => links.map((l) => naoKin.robot.meshes.find((m) => m.link === l).mesh.material.color.getHexString())"
)


@pytest.fixture(scope="module")
def shared(shared: Page) -> Page:
    shared.run(COUNT)
    return shared


@pytest.fixture(scope="module")
def shared_drawn(browser: Any, document: Path) -> Iterator[Page]:
    # What is drawn only once, as the light from around, must be drawn from the beginning.
    with opened(browser, document, draws=True) as page:
        yield page


@pytest.fixture
def drawn(shared_drawn: Page, nao: nk.NaoModel) -> Iterator[Page]:
    """A page that draws, its picture at rest."""
    shared_drawn.reset(nao.posture("StandInit"))
    shared_drawn.draw(True)
    _rest(shared_drawn)
    yield shared_drawn
    shared_drawn.draw(False)
    shared_drawn.tab.emulate_media(color_scheme="light")


def _click(page: Page, name: str) -> None:
    page.tab.get_by_role("button", name=name, exact=True).click()


def _open_menu(page: Page) -> None:
    page.tab.locator("button.view").click()
    assert page.tab.locator(".menu.view").is_visible()


def _close_menu(page: Page) -> None:
    page.tab.keyboard.press("Escape")
    assert not page.tab.locator(".menu.view").is_visible()


def _rest(page: Page) -> None:
    page.tab.wait_for_function("() => !naoKin.viewer.needs_render && !naoKin.studio.quality.moving")


def _orbit(page: Page, steps: int) -> None:
    page.tab.mouse.move(60, 150)
    page.tab.mouse.down()
    for step in range(steps):
        page.tab.mouse.move(60 + 9 * (step + 1), 150)
        page.animation_frames(1)
    page.tab.mouse.up()


# --- what is drawn, and how often --------------------------------------------------------------------------------


# How often the page asks for a frame, a timeout or an interval, and draws, in two seconds.
ASK = """() => {
    window.asked = 0;
    for (const name of ["requestAnimationFrame", "setTimeout", "setInterval"]) {
        const own = window[name].bind(window);
        window[name] = (...given) => { asked += 1; return own(...given); };
        if (name === "setTimeout") window.after = own;
    }
}"""
IN_TWO_SECONDS = """() => new Promise((done) => {
    const before = [asked, naoKin.drawn];
    after(() => done([asked - before[0], naoKin.drawn - before[1]]), 2000);
})"""


@pytest.mark.full
def test_a_page_in_which_nothing_changes_sleeps_and_a_change_wakes_it(browser: Any, nao: nk.NaoModel) -> None:
    with Viewer(nao) as viewer, opened(browser, viewer.url) as page:

        def rest() -> None:
            _rest(page)
            page.tab.wait_for_function("() => !naoKin.player.playback?.playing")
            page.tab.wait_for_timeout(600)  # what follows a change late: the address, reports

        page.run(ASK)
        rest()
        assert page.run(IN_TWO_SECONDS) == [0, 0]
        drawn = page.run("() => naoKin.drawn")
        for change in (
            lambda: page.type_number("HeadYaw", "20"),
            lambda: _orbit(page, 2),
            lambda: viewer.display(nao.posture("Crouch")),
            lambda: page.tab.set_viewport_size({"width": 700, "height": 500}),
        ):
            change()
            page.tab.wait_for_function("(drawn) => naoKin.drawn > drawn", arg=drawn)
            rest()
            drawn = page.run("() => naoKin.drawn")
        # A clip keeps it awake to its end.
        viewer.animate([nao.posture("StandInit"), nao.posture("Crouch")], fps=1.0, loop=False)
        page.tab.wait_for_function("(drawn) => naoKin.drawn > drawn + 3", arg=drawn)
        rest()
        assert page.run("() => naoKin.player.time") == pytest.approx(1.0)
        assert page.run(IN_TWO_SECONDS) == [0, 0]


def test_a_clip_that_stands_at_a_limit_leaves_its_joints_inside(browser: Any, nao: nk.NaoModel, tmp_path: Path) -> None:
    viewer = Viewer(nao)
    viewer.animate([nao.posture("Sit")] * 2, play=False)
    with opened(browser, viewer.save_html(tmp_path / "sit.html")) as page:
        assert (page.q[nao.joint_names.index("RHipPitch")] < nao.lower[nao.joint_names.index("RHipPitch")]) is np.True_
        assert page.tab.locator(".joint.outside").count() == 0
        assert page.run("() => naoKin.colours.outside.size") == 0
        # A thousandth of a degree outside is outside.
        q = nao.posture("Sit")
        q[nao.joint_names.index("RHipPitch")] -= 2e-5
        page.set(q)
        assert page.tab.locator(".joint.outside").evaluate_all("(all) => all.map((row) => row.dataset.joint)") == [
            "RHipPitch"
        ]


def test_a_movement_is_drawn_fast_and_then_once_at_its_best(page: Page) -> None:
    _rest(page)
    page.run("() => Object.assign(pictures, { fine: 0, fast: 0 })")
    page.run("() => (naoKin.studio.quality.level = 1)")
    _orbit(page, 8)
    fast = page.run("() => pictures.fast")
    assert fast >= 4
    page.tab.wait_for_function("() => pictures.fine >= 1 && !naoKin.studio.quality.moving")
    best = page.run("() => pictures.fine")
    page.tab.wait_for_timeout(400)
    assert page.run("() => [pictures.fine, pictures.fast]") == [best, page.run("() => pictures.fast")]


@pytest.mark.full
def test_the_picture_of_a_movement_looks_like_the_one_at_rest(drawn: Page) -> None:
    drawn.run("() => naoKin.show({ handles: false })")
    seen = []
    for fine in (True, False):
        drawn.run("(fine) => (naoKin.studio.quality.next = () => ({ fine, ratio: 1 }))", fine)
        drawn.run("() => naoKin.viewer.set_dirty()")
        drawn.animation_frames(3)
        seen.append(drawn.picture().astype(float))
    drawn.run("() => { delete naoKin.studio.quality.next; }")
    without = np.array([235.0, 238.0, 243.0])
    robot = np.abs(seen[0] - without).max(axis=2) > 12
    assert robot.mean() > 0.03
    assert np.median(np.abs(seen[0] - seen[1])[robot]) < 3.0
    assert np.abs(seen[0] - seen[1])[robot].mean() < 9.0


def test_the_backs_of_closed_shells_are_not_drawn(page: Page) -> None:
    assert page.run("() => naoKin.robot.meshes.every(({ mesh }) => mesh.material.side === MeshCat.THREE.FrontSide)")


# --- frames, axes, chains ----------------------------------------------------------------------------------------


def _labels(page: Page) -> dict[str, tuple[float, float, float, float]]:
    page.run("() => naoKin.viewer.render()")
    shown = page.run("() => naoKin.labels.shown.map(({ text, at }) => [text, [at.x, at.y, at.width, at.height]])")
    return {text: tuple(at) for text, at in shown}


def test_frames_are_sought_or_all_drawn_at_once_each_place_under_one_name(page: Page, nao: nk.NaoModel) -> None:
    drawn = "() => naoKin.frames.names"
    _open_menu(page)
    search = page.tab.get_by_role("searchbox", name="Search frames to draw")
    search.fill("camera top")
    shown = page.run(drawn)
    assert shown == ["CameraTop", "CameraTop_optical_frame"]  # CameraTop_frame is CameraTop
    assert page.tab.locator(".menu.view .search output").inner_text() == f"{len(shown)} places"
    assert set(_labels(page)) <= set(shown)
    search.fill("bumper left")
    names = page.run(drawn)
    assert set(names) <= {name for name in nao.frame_names if "bumper" in name.lower() and "left" in name.lower()}
    search.fill("nothing like that")
    assert page.run(drawn) == []
    assert page.tab.locator(".menu.view .search output").inner_text() == "no places"
    _click(page, "All")
    assert search.input_value() == ""
    poses = {nao.fk(page.q, name).round(6).tobytes() for name in nao.frame_names}
    names = page.run(drawn)
    assert poses == {nao.fk(page.q, name).round(6).tobytes() for name in names}
    assert len(names) < 0.7 * len(nao.frame_names)
    assert "Head" in names
    _click(page, "Effectors")
    assert page.run(drawn) == page.run("() => naoKin.robot.about.effectors")
    pressed = page.tab.locator(".menu.view [aria-pressed=true]")
    assert "Effectors" in pressed.all_inner_texts()
    _click(page, "None")
    assert _labels(page) == {}
    _close_menu(page)


def test_a_click_on_the_label_or_the_origin_of_a_frame_selects_it(page: Page, drawn: Page) -> None:
    drawn.run(
        "() => { naoKin.chooseFrames({ names: ['LLeg', 'Head'], size: null }); naoKin.show({ handles: false }); }"
    )
    drawn.run("() => naoKin.viewer.render()")
    shown = drawn.run("() => naoKin.labels.shown.map(({ text, at, point }) => [text, at, point])")
    left, top = drawn.run("() => { const { left, top } = naoKin.pane.getBoundingClientRect(); return [left, top]; }")
    places = {text: [(at["x"] + 5, at["y"] + 5), (point["x"], point["y"])] for text, at, point in shown}
    for way in (0, 1):
        for name in ("LLeg", "Head"):
            drawn.tab.mouse.click(left + places[name][way][0], top + places[name][way][1])
            assert drawn.run("() => naoKin.pick.selection.read") == name


def test_joint_axes_are_named_with_their_pair_once(page: Page, nao: nk.NaoModel) -> None:
    page.set(nao.posture("StandZero"))
    page.switch("Joint axes")
    texts = page.run("() => [...naoKin.labels.owners.get(naoKin.axes)].map(({ text }) => text)")
    assert "LKneePitch" in texts
    assert "HeadYaw, HeadPitch" in texts
    assert "LHipYawPitch, LHipRoll, LHipPitch" in texts
    assert {"revolute", "universal", "spherical"} <= set(page.tab.locator("#legend .entry").all_inner_texts())
    named = [joint for text in texts for joint in text.split(", ")]
    assert len(named) == len(set(named))
    page.switch("Joint axes")
    assert page.run("() => naoKin.labels.canvas.hidden")


def test_chains_have_a_colour_each_and_links_their_own_back(page: Page, nao: nk.NaoModel) -> None:
    page.set(nao.posture("StandInit"))
    links = [nao.link_names.index(name) for name in ("Head", "LBicep", "l_wrist", "LFinger11_link", "RTibia")]
    own = page.run(COLOURS, links)
    page.switch("Chains")
    head, upper, wrist, finger, shin = page.run(COLOURS, links)
    assert upper == wrist == finger
    assert len({head, upper, shin}) == 3
    assert page.tab.locator("#legend .entry").all_inner_texts() == list(nao.chains)
    page.switch("Chains")
    assert page.run(COLOURS, links) == own
    assert page.tab.locator("#legend").is_hidden()


# --- through the robot's cameras ---------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["CameraTop", "CameraBottom"])
def test_the_inset_shows_what_the_camera_sees(page: Page, nao: nk.NaoModel, name: str) -> None:
    q = nao.configuration({"HeadYaw": 0.4, "HeadPitch": 0.1})
    page.set(q)
    page.switch("Camera view")
    page.tab.get_by_label("Camera of the robot").select_option(name)
    # A metre ahead, at the edges of the published field of view, in the torso's frame.
    T, [right, down] = nao.fk(q, name), np.tan(np.radians([56.3, 43.7]) / 2)
    points = [T[:3, :3] @ [1.0, -x * right, -y * down] + T[:3, 3] for x, y in ((0, 0), (1, 0), (0, 1), (-1, -1))]
    seen = page.run(
        """(points) => {
            const { eyes, robot } = naoKin;
            robot.root.updateWorldMatrix(true, true);
            const inWorld = (point) => robot.root.localToWorld(new MeshCat.THREE.Vector3(...point));
            return points.map((point) => inWorld(point).project(eyes.camera).toArray());
        }""",
        [point.tolist() for point in points],
    )
    assert np.allclose(np.array(seen)[:, :2], [[0, 0], [1, 0], [0, -1], [-1, 1]], atol=1e-6)
    assert page.tab.locator("#eye").inner_text().endswith("56.3° × 43.7°")
    box = page.tab.locator("#eye .sight").bounding_box()
    assert box["width"] / box["height"] == pytest.approx(right / down, rel=0.02)
    page.switch("Camera view")
    assert page.tab.locator("#eye").is_hidden()
    assert page.run("() => naoKin.eyes.camera.parent") is None


def test_the_ground_in_view_of_a_camera_is_outlined_as_the_head_turns(page: Page, nao: nk.NaoModel) -> None:
    page.switch("Camera view")
    counts = set()
    for name in ("CameraTop", "CameraBottom"):
        page.tab.get_by_label("Camera of the robot").select_option(name)
        camera = nk.world.camera(nao, name)
        for posture, yaw, pitch in (
            ("StandInit", 0.0, 0.0),
            ("StandInit", 1.2, 0.2),
            ("StandInit", 0.0, -0.67),
            ("Crouch", -2.0, -0.1),
            ("Sit", 0.8, 0.0),
        ):
            q = nao.posture(posture, HeadYaw=yaw, HeadPitch=pitch)
            page.set(q)
            seen = page.run("() => naoKin.eyes.footprint.corners.map(({ x, y }) => [x, y])")
            expected = nk.world.visible_ground(nao, q, camera)[:, :2]
            counts.add(len(expected))
            assert np.shape(seen) == expected.shape or not len(expected) + len(seen)
            # The page follows a ring of corners from another one.
            for corner in seen:
                assert np.linalg.norm(expected - corner, axis=1).min() < 2e-3 * max(1.0, np.linalg.norm(corner))
            assert page.run("() => naoKin.eyes.footprint.rim.visible") == bool(len(expected))
    assert counts == {0, 4, 5}
    page.switch("Camera view")
    assert not page.run("() => naoKin.eyes.footprint.rim.visible")


# --- the robot's looks -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("kept", "aside"), [("Keep as ghost", 0.0), ("Keep beside", -0.8)])
def test_a_configuration_is_kept_as_a_ghost(page: Page, nao: nk.NaoModel, kept: str, aside: float) -> None:
    q = nao.posture("Crouch")
    page.set(q)
    _open_menu(page)
    remove = page.tab.get_by_role("button", name="Remove ghost", exact=True)
    assert not remove.is_visible()
    _click(page, kept)
    assert remove.is_visible()
    assert page.run("() => naoKin.isInSight")
    page.set(nao.posture("StandZero"))
    ghost = "(link) => naoKin.ghosts.copies.find(({ userData }) => userData.link === link).userData.pose.toArray()"
    link = page.run("() => naoKin.robot.about.links.findIndex(({ name }) => name === 'l_wrist')")
    standing = nao.set_down(q).T_world_base @ nao.fk(q, "l_wrist")
    standing[1, 3] += aside * page.run("() => naoKin.studio.size")
    assert np.allclose(np.reshape(page.run(ghost, link), (4, 4)).T, standing, atol=1e-4)
    way = np.linalg.norm(nao.position(nao.posture("StandZero"), "LArm") - nao.position(q, "LArm"))
    assert f"LArm {1e3 * way:.1f} mm" in page.tab.locator(".readout .apart h3").inner_text()
    _click(page, "Remove ghost")
    assert page.run("() => naoKin.ghosts.copies.length") == 0
    assert not remove.is_visible()
    _close_menu(page)


def test_the_difference_to_a_ghost_is_read_in_numbers(page: Page, nao: nk.NaoModel) -> None:
    card, then = page.tab.locator(".readout .apart"), nao.posture("StandInit")
    page.set(then)
    _open_menu(page)
    _click(page, "Keep as ghost")
    _close_menu(page)
    assert not card.is_visible()  # nothing differs yet
    now = nao.posture("StandInit", LShoulderPitch=0.4, LElbowRoll=-1.2, HeadYaw=0.1)
    page.set(now)
    way = nao.fk(now, "LArm")[:3, 3] - nao.fk(then, "LArm")[:3, 3]
    assert card.locator("h3").inner_text() == f"From the ghost: 3 joints, LArm {1e3 * np.linalg.norm(way):.1f} mm"
    shown = dict(card.locator("output").evaluate_all("(all) => all.map((o) => [o.ariaLabel, Number(o.dataset.value)])"))
    differences = {name: now[k] - then[k] for k, name in enumerate(nao.joint_names) if now[k] != then[k]}
    assert list(shown)[:3] == sorted(differences, key=lambda name: -abs(differences[name]))
    assert shown == pytest.approx(differences | dict(zip(("Δx", "Δy", "Δz"), way, strict=True)), abs=1e-9)
    assert not page.switch("Ghosts")
    assert not card.is_visible()
    assert page.switch("Ghosts")
    assert card.is_visible()
    page.set(then)
    assert not card.is_visible()
    # Without a ghost, more of the pose has the difference to the posture chosen last.
    _open_menu(page)
    _click(page, "Remove ghost")
    _close_menu(page)
    more = page.tab.get_by_role("button", name="Quaternion, axis and angle, copying")
    more.click()
    _click(page, "Stand")
    assert np.array_equal(page.q, nao.posture("Stand"))
    assert not card.is_visible()
    page.slide("HeadYaw", 0.2)
    assert page.q[0] == pytest.approx(0.2)
    assert card.locator("h3").inner_text().startswith("From Stand: 1 joint, ")
    more.click()
    assert not card.is_visible()


def test_solutions_are_stepped_through_by_arrows_with_their_target_and_why_they_are_refused(
    browser: Any, nao: nk.NaoModel, tmp_path: Path
) -> None:
    T = nk.screws.pose(np.eye(3), [0.02, 0.05, -0.25])
    path, words = tmp_path / "leg.html", " ".join(map(str, T.reshape(-1)))
    assert run(["ik", "LLeg", "--target", words, "--html", str(path)]) == 0
    every = nk.ik.leg(nao, "L", T, limits="ignore").solutions
    with opened(browser, path) as page:
        card, legend = page.tab.locator(".readout .apart"), page.tab.locator("#legend")
        numbers = "(all) => Object.fromEntries(all.map((one) => [one.ariaLabel, Number(one.dataset.value)]))"
        assert card.locator("h3").inner_text().startswith("From the target of LLeg: 0.0")
        assert "LLeg: target" in page.run("() => [...naoKin.labels.owners.values()].flat().map(({ text }) => text)")
        radios = legend.get_by_role("radio")
        assert radios.count() == len(every) == 8
        assert legend.inner_text().split() == ["solutions", *"12345678", "inside", "all", "limits"]
        radios.first.focus()
        for k in range(1, 8):
            page.tab.keyboard.press("ArrowRight")
            assert radios.nth(k).is_checked()
            assert min(np.abs(every - page.q).max(axis=1)) < 1e-6
            assert "refused: " in legend.inner_text()
            assert any(found.joint in legend.inner_text() for found in nao.limit_violations(page.q))
            found = card.locator("output").evaluate_all(numbers)
            assert found["distance"] == pytest.approx(0.0, abs=1e-6)
        page.slide("LKneePitch", 0.3)
        page.animation_frames(2)
        found = card.locator("output").evaluate_all(numbers)
        E = np.linalg.inv(T) @ nao.fk(page.q, "LLeg")
        assert found["distance"] == pytest.approx(np.linalg.norm(E[:3, 3]), abs=1e-6)
        assert found["angle"] == pytest.approx(float(nk.rotations.natural_invariants(E[:3, :3])[1]), abs=1e-6)


def test_a_posture_shows_its_ghost_in_the_picture_too(page: Page, nao: nk.NaoModel) -> None:
    inside = """() => {
        const { camera } = naoKin.pick.viewport;
        const { min, max } = naoKin.ghosts.box;
        const corners = [min, max].flatMap(({ x, z }) => [min.y, max.y].map((y) => new MeshCat.THREE.Vector3(x, y, z)));
        return corners.every((corner) => corner.project(camera) && Math.abs(corner.x) < 1 && Math.abs(corner.y) < 1);
    }"""
    page.switch("Keep as ghost")
    for name in ("LyingBack", "Sit"):
        page.tab.get_by_role("button", name=name, exact=True).click()
        assert page.run("() => naoKin.ghosts.copies.some(({ visible }) => visible)")
        assert page.run(inside)


# --- links that overlap ------------------------------------------------------------------------------------------


def _overlapping(page: Page, q: np.ndarray) -> list[set[tuple[str, ...]]]:
    """Return the pairs of links that overlap in each of the configurations, as the page finds them."""
    found = page.run(
        """(qs) => qs.map((q) => (naoKin.set(q), naoKin.settle(),
            naoKin.collisions.pairs.map((pair) => pair.map((k) => naoKin.robot.about.links[k].name))))""",
        q.tolist(),
    )
    return [{tuple(sorted(pair)) for pair in pairs} for pairs in found]


def test_the_page_finds_the_links_that_overlap_as_the_library_does(page: Page, nao: nk.NaoModel) -> None:
    # A step at a time, because the search begins with the last direction between the links.
    steps = np.linspace(nao.random(22), nao.random(23), 60)
    q = np.concatenate([[nao.posture(name) for name in nao.posture_names], steps, nao.random(21, 240)])
    expected: list[set[tuple[str, ...]]] = [set() for _ in q]
    for contact in nao.collisions(q, exact=False):
        expected[contact.index[0]].add(tuple(sorted(contact.links)))
    assert 60 < sum(map(bool, expected)) < len(q) - 60
    assert _overlapping(page, q) == expected


def test_links_that_overlap_are_told_and_coloured(page: Page, nao: nk.NaoModel) -> None:
    page.reset(nao.posture("StandInit"), (1100, 700))
    line = page.tab.get_by_label("Overlaps", exact=True).and_(page.tab.locator("output"))
    names = page.run("() => naoKin.robot.about.links.map(({ name }) => name)")
    feet = [names.index(name) for name in ("l_ankle", "r_ankle", "Head")]
    own = page.run(COLOURS, feet)
    assert line.inner_text() == "no links overlap"
    page.set(nao.posture("Crouch"))
    assert line.inner_text() == "overlap: LFoot, RFoot"
    assert line.get_attribute("data-state") == "known"
    q = nao.posture("Crouch")
    q[nao.joint_names.index("HeadYaw")] = 0.1
    page.set(q)
    assert line.get_attribute("data-state") == "warn"
    assert page.run(COLOURS, feet) == own
    assert page.switch("Overlaps")
    left, right, head = page.run(COLOURS, feet)
    assert left != own[0]
    assert right != own[1]
    assert head == own[2]
    legend = page.tab.locator("#legend")
    assert legend.inner_text() == "links that overlap"
    page.set(nao.posture("Sit"))
    assert line.inner_text() == "2 pairs overlap"
    page.set(nao.posture("Stand"))
    assert not legend.is_visible()
    assert page.run(COLOURS, feet) == own
    assert not page.switch("Overlaps")


def test_the_margin_turns_into_the_direction_in_which_a_robot_tips(page: Page, nao: nk.NaoModel) -> None:
    balance = page.tab.get_by_label("Balance")
    for name, value, way in (("AnklePitch", 0.4, "backwards"), ("AnklePitch", -0.5, "forwards")):
        q = nao.posture("StandZero", **{side + name: value for side in "LR"})
        page.set(q)
        assert balance.inner_text() == f"tips {way}"
        assert balance.get_attribute("data-state") == "bad"
        assert float(nk.world.balance(nao, q).margin) < 0.0
    page.set(nao.posture("StandInit"))
    found = nk.world.balance(nao, nao.posture("StandInit"))
    assert balance.inner_text() == f"margin {1e3 * float(found.margin):.1f}\u00a0mm"
    more = page.tab.get_by_role("button", name="Quaternion, axis and angle, copying")
    more.click()
    shown = page.run("""() => Object.fromEntries([...document.querySelectorAll(".readout .numbers output")]
        .map((o) => [o.ariaLabel, Number(o.dataset.value)]))""")
    com = nao.com(nao.posture("StandInit"), reference="torso")
    assert [shown[f"CoM {axis}"] for axis in "xyz"] == pytest.approx(com.tolist(), abs=1e-6)
    assert shown["margin"] == pytest.approx(float(found.margin), abs=1e-4)
    assert next(value for name, value in shown.items() if name.startswith("tips ")) == pytest.approx(
        float(found.tilts[found.nearest]), abs=1e-3
    )
    more.click()


def test_the_robot_becomes_transparent_and_solid_again(page: Page) -> None:
    opacity = "() => [naoKin.robot.meshes[0].mesh.material.opacity, naoKin.robot.meshes[0].mesh.material.transparent]"
    page.tab.get_by_role("button", name="Settings").click()
    slider = page.tab.get_by_label("Opacity", exact=True).and_(page.tab.locator("input"))
    slider.focus()
    page.tab.keyboard.press("Home")
    assert page.run(opacity) == [pytest.approx(0.1), True]
    page.tab.keyboard.press("End")
    assert page.run(opacity) == [1, False]


def test_high_contrast_is_black_on_white(page: Page) -> None:
    colours = "() => ['--ink', '--sky'].map((it) => getComputedStyle(document.documentElement).getPropertyValue(it))"
    page.tab.get_by_role("button", name="Settings").click()
    _click(page, "High contrast")
    assert page.run(colours) == ["rgb(0, 0, 0)", "rgb(255, 255, 255)"]
    _click(page, "High contrast")
    assert page.run(colours)[0] not in ("rgb(0, 0, 0)", "")


@pytest.mark.full
def test_a_lost_graphics_card_is_told_and_comes_back_with_the_same_picture(drawn: Page) -> None:
    drawn.run("() => naoKin.show({ com: true, axes: true })")
    _rest(drawn)
    before = drawn.picture().astype(float)
    drawn.run("""() => {
        window.card = naoKin.viewer.renderer.getContext().getExtension("WEBGL_lose_context");
        card.loseContext();
    }""")
    line = drawn.tab.locator("#blank")
    line.wait_for(timeout=15_000)
    assert "The picture returns as soon as it is back" in line.inner_text()
    count = drawn.run("() => naoKin.drawn")
    drawn.slide("HeadYaw", 0.4)
    drawn.animation_frames(3)
    assert drawn.q[0] == pytest.approx(0.4)
    assert drawn.run("() => naoKin.drawn") == count
    drawn.slide("HeadYaw", 0.0)
    # In both qualities: the balls of the fast one were on the card, too.
    drawn.run("() => card.restoreContext()")
    line.wait_for(state="hidden", timeout=60_000)
    drawn.tab.wait_for_function("(count) => naoKin.drawn > count + 2", arg=count, timeout=60_000)
    _rest(drawn)
    drawn.tab.wait_for_timeout(300)
    after = drawn.picture().astype(float)
    robot = np.abs(before - before[:, :1]).max(axis=2) > 12
    assert robot.mean() > 0.03
    assert np.abs(after - before).max(axis=2)[robot].mean() < 0.5
    assert np.abs(after - before).mean() < 0.1
    drawn.run("() => { naoKin.studio.quality.next = () => ({ fine: false, ratio: 1 }); naoKin.viewer.set_dirty(); }")
    drawn.animation_frames(3)
    fast = drawn.picture().astype(float)
    drawn.run("() => { delete naoKin.studio.quality.next; }")
    assert np.abs(fast - before)[robot].mean() < 9.0


def test_the_picture_follows_the_resolution_of_the_screen(page: Page) -> None:
    session = page.tab.context.new_cdp_session(page.tab)
    width, height = page.size
    held = "() => { const { width, clientWidth } = naoKin.viewer.renderer.domElement; return width / clientWidth; }"
    for ratio in (2.0, 1.5, 1.0):  # as the browser's zoom does it
        metrics = {
            "width": int(width / ratio),
            "height": int(height / ratio),
            "deviceScaleFactor": ratio,
            "mobile": False,
        }
        session.send("Emulation.setDeviceMetricsOverride", metrics)
        page.tab.wait_for_function("(ratio) => naoKin.studio.ratio === ratio", arg=ratio, timeout=15_000)
        _rest(page)
        assert page.run(held) == pytest.approx(ratio, abs=0.01)
    session.detach()


def test_a_page_says_that_it_loads_before_its_scripts_are_there(browser: Any, document: Path) -> None:
    context = browser.new_context(java_script_enabled=False)
    tab = context.new_page()
    tab.goto(document.as_uri())
    assert tab.locator("#blank").inner_text().split() == "Loading … It needs JavaScript.".split()
    # It stands before the scene and the scripts.
    assert document.read_text(encoding="utf-8").index('id="blank"') < 50_000
    context.close()


# --- pictures and films ------------------------------------------------------------------------------------------


# Keep the place of the first label in the next picture that is saved, where labels have another size than in the page.
NOTE_LABEL = """() => {
    const { labels } = naoKin;
    labels.paint = (ink, ...rest) => {
        Object.getPrototypeOf(labels).paint.call(labels, ink, ...rest);
        const scale = ink.getTransform().a;
        if (ink !== labels.ink) window.painted = Object.values(labels.shown[0].at).map((length) => length * scale);
    };
}"""


@pytest.mark.full
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_picture_has_the_background_and_the_labels_of_the_page(drawn: Page, tmp_path: Path, scheme: str) -> None:
    drawn.tab.emulate_media(color_scheme=scheme)
    drawn.run("() => naoKin.show({ frames: true, handles: false })")
    _rest(drawn)
    seen = drawn.picture().astype(float)
    drawn.run(NOTE_LABEL)
    _open_menu(drawn)
    with drawn.tab.expect_download() as saved:
        _click(drawn, "Picture")
    saved.value.save_as(tmp_path / "nao.png")
    picture = read_png((tmp_path / "nao.png").read_bytes()).astype(float)
    # Of a last row of pixels that the bar covers in part, the page has no picture.
    seen = seen[: len(picture)]
    assert picture.shape == seen.shape
    # Nothing is at the left edge but the background, from under the buttons to above the legend.
    assert np.abs(picture[150:-100, :4] - seen[150:-100, :4]).max() <= 2.0
    assert (picture[-1, 0].mean() < 60.0) == (scheme == "dark")
    x, y, width, height = drawn.run("() => { delete naoKin.labels.paint; return painted; }")
    label = picture[round(y) : round(y + height), round(x) : round(x + width)].mean(axis=2)
    assert (np.median(label) < 100.0) == (scheme == "dark")


def _blocks(film: bytes) -> list[tuple[int, bytes]]:
    """Return the times [ms] and the data of the encoded pictures in a WebM file of ours."""
    parents = {b"\x18\x53\x80\x67", b"\x1f\x43\xb6\x75"}  # Segment and Cluster
    blocks, start, at = list[tuple[int, bytes]](), 0, 0
    while at < len(film):
        length = 9 - film[at].bit_length()
        name, at = film[at : at + length], at + length
        size, at = int.from_bytes(film[at + 1 : at + 8]), at + 8
        if name in parents:
            continue
        if name == b"\xe7":
            start = int.from_bytes(film[at : at + size])
        elif name == b"\xa3":
            blocks.append((start + int.from_bytes(film[at + 1 : at + 3]), film[at + 4 : at + size]))
        at += size
    return blocks


# Decode a film, and return some of its pictures as rows of pixels.
DECODE = """async ([blocks, width, height, wanted]) => {
    const found = [];
    let count = 0;
    const ink = Object.assign(document.createElement("canvas"), { width, height }).getContext("2d");
    const decoder = new VideoDecoder({
        output: (frame) => {
            if (wanted.includes(count++)) {
                ink.drawImage(frame, 0, 0);
                found.push([...ink.getImageData(0, 0, width, height).data]);
            }
            frame.close();
        },
        error: (error) => { throw error; },
    });
    decoder.configure({ codec: "vp09.00.61.08" });
    blocks.forEach((block, i) => {
        const data = Uint8Array.from(atob(block), (letter) => letter.charCodeAt(0));
        decoder.decode(new EncodedVideoChunk({ type: i % 60 ? "delta" : "key", timestamp: i, data }));
    });
    await decoder.flush();
    return [count, found];
}"""


def _load(page: Page, viewer: Viewer) -> None:
    """Give the page the clip of a viewer."""
    clip = viewer._messages.get("clip")
    assert clip is not None
    page.run("(bytes) => naoKin.viewer.handle_command_bytearray(Uint8Array.from(bytes))", list(clip))


def _film(page: Page) -> Path:
    _open_menu(page)
    with page.tab.expect_download() as saved:
        _click(page, "Video")
    return Path(saved.value.path())


@pytest.mark.full
def test_a_motion_is_filmed_with_every_picture(drawn: Page, nao: nk.NaoModel) -> None:
    _open_menu(drawn)
    _click(drawn, "Video")
    assert drawn.tab.locator("#message span").inner_text().startswith("There is no motion to film")
    viewer = Viewer(nao)
    viewer.animate(np.linspace(nao.posture("Stand"), nao.posture("Crouch"), 5), 20.0, play=False)
    _load(drawn, viewer)
    drawn.run("() => naoKin.player.seek(0.1)")
    before = drawn.q
    size = "() => { const { domElement } = naoKin.viewer.renderer; return [domElement.width, domElement.style.width]; }"
    _rest(drawn)
    wide = drawn.run(size)
    # 0.2 s at 30 pictures a second, and at half the speed.
    for speed, count in ((1.0, 7), (0.5, 13)):
        drawn.run("(speed) => naoKin.player.setSpeed(speed)", speed)
        film = _film(drawn).read_bytes()
        assert film[:4] == b"\x1aE\xdf\xa3"  # Matroska, of which WebM is a part
        assert [time for time, _ in _blocks(film)] == [round(1000 * i / 30) for i in range(count)]
    # Afterwards the page is as before.
    assert drawn.tab.locator("dialog").count() == 0
    assert np.array_equal(drawn.q, before)
    _rest(drawn)
    assert drawn.run(size) == wide
    assert drawn.run("() => naoKin.studio.alwaysFine") is False
    # Escape cancels.
    drawn.run("() => { window.began = document.querySelectorAll('a').length; naoKin.player.setSpeed(0.1); }")
    _open_menu(drawn)
    _click(drawn, "Video")
    drawn.tab.wait_for_function("() => document.querySelector('dialog progress')?.value >= 1")
    drawn.tab.get_by_role("button", name="Cancel").click()
    drawn.tab.wait_for_function("() => naoKin.studio.alwaysFine === false")
    assert drawn.tab.locator("dialog").count() == 0
    assert np.array_equal(drawn.q, before)
    drawn.run("() => naoKin.player.setSpeed(1)")
    # Without an encoder.
    drawn.run("() => { window.encoder = VideoEncoder; delete window.VideoEncoder; }")
    _open_menu(drawn)
    _click(drawn, "Video")
    drawn.tab.get_by_text("this browser cannot encode video here").wait_for()
    drawn.run("() => { window.VideoEncoder = encoder; }")


@pytest.mark.full
def test_a_video_from_python_shows_each_pose_at_its_time(drawn: Page, nao: nk.NaoModel, tmp_path: Path) -> None:
    width, height = size = (160, 120)
    camera = nk.screws.pose(nk.rotations.rot_z(np.pi), [1.2, 0.0, 0.35])
    begin, end = (nao.configuration({"LShoulderPitch": up, "RShoulderPitch": up}) for up in (1.5, -1.5))
    viewer, still, told = Viewer(nao), Viewer(nao), list[tuple[int, int]]()
    viewer.animate(np.linspace(begin, end, 2), 1.0)
    path = tmp_path / "arms.webm"
    assert viewer.save_video(path, camera=camera, size=size, progress=lambda *n: told.append(n)) == path
    assert told == [(i + 1, 31) for i in range(31)]
    blocks = _blocks(path.read_bytes())
    assert [time for time, _ in blocks] == [round(1000 * i / 30) for i in range(31)]
    coded = [base64.b64encode(data).decode() for _, data in blocks]
    near = [*range(9, 12), *range(28, 31)]
    count, found = drawn.run(DECODE, [coded, width, height, near])
    assert count == 31
    pictures = dict(zip(near, (np.reshape(pixels, (height, width, 4))[..., :3] for pixels in found), strict=True))
    for number in (10, 30):
        still.display(begin + number / 30 * (end - begin))
        file = still.save_png(tmp_path / f"{number}.png", camera=camera, size=size)
        right = read_png(file.read_bytes()).astype(float)
        errors = {i: float(np.abs(picture - right).mean()) for i, picture in pictures.items()}
        assert min(errors, key=lambda i: errors[i]) == number
        assert errors[number] < 1.5
    # An exception in between leaves no file, and the next picture has a browser.
    with pytest.raises(ZeroDivisionError):
        viewer.save_video(tmp_path / "never.zip", size=size, progress=lambda done, all: 1 // (done - 2))
    with pytest.raises(NoBrowser, match=r"0\.001 s"):
        viewer.save_video(tmp_path / "never.zip", size=size, timeout=0.001)
    assert not (tmp_path / "never.zip").exists()
    (tmp_path / "arms.zip").write_bytes(b"")
    with zipfile.ZipFile(
        viewer.save_video(tmp_path / "arms.zip", camera=camera, size=size, fps=2.0, overwrite=True)
    ) as pictures:
        assert pictures.namelist() == [f"0000{i}.png" for i in range(3)]
        last = read_png(pictures.read("00002.png")).astype(float)
    assert np.abs(last - right).mean() < 0.05
