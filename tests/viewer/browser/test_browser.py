"""The viewer's pages in a real browser: their computations, their pictures, and that they send no other requests."""

from __future__ import annotations

import math
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from viewer_pages import Page, made_of, opened, processes, read_png, until, visitor

import nao_kin as nk
from nao_kin.cli.app import run
from nao_kin.cli.naoqi import camera_pictures
from nao_kin.errors import NoBrowser
from nao_kin.naoqi import VirtualNao
from nao_kin.rotations import rpy_from_matrix
from nao_kin.viewer import OutsideLimitsWarning, Viewer
from nao_kin.viewer.browser import pictures

FPS = 20.0


@pytest.fixture(scope="module")
def clip(nao: nk.NaoModel) -> np.ndarray:
    return np.linspace(nao.posture("StandInit"), nao.posture("Crouch"), 21)


@pytest.fixture(scope="module")
def document(nao: nk.NaoModel, clip: np.ndarray, tmp_path_factory: pytest.TempPathFactory) -> Path:
    viewer = Viewer(nao)
    viewer.animate(clip, FPS, play=False)
    return viewer.save_html(tmp_path_factory.mktemp("viewer") / "nao.html")


def test_no_script_runs_but_the_pages_own(page: Page) -> None:
    page.run("""() => {
        const script = document.createElement("script");
        script.textContent = "window.foreign = true;";
        document.body.append(script);
        script.remove();
        const made = document.createElement("button");
        made.setAttribute("onclick", "window.foreign = true;");
        document.body.append(made);
        made.click();
        made.remove();
    }""")
    page.tab.wait_for_timeout(100)
    assert page.run("() => window.foreign") is None
    assert all("Content Security Policy" in line for line in page.errors)
    page.errors.clear()


@pytest.mark.full
def test_the_page_from_disk_asks_for_nothing_but_itself(page: Page, document: Path) -> None:
    assert page.requests == [document.as_uri()]
    assert page.errors == []
    assert page.run("() => document.title") == "nao_v6"


def test_every_link_is_where_forward_kinematics_says(page: Page, nao: nk.NaoModel) -> None:
    for q in made_of(nao):
        page.set(q)
        assert np.abs(page.poses(nao.frame_names) - nao.fk(q, nao.frame_names)).max() < 1e-6
        assert np.abs(np.array(page.run("() => naoKin.com()")) - nao.com(q)).max() < 1e-6


def test_a_slider_moves_its_joint_and_nothing_else(page: Page, nao: nk.NaoModel) -> None:
    q = nao.posture("StandInit")
    page.set(q)
    for joint in ("HeadYaw", "LShoulderPitch", "LHipYawPitch", "RAnkleRoll", "RHand"):
        column = nao.joint_names.index(joint)
        q[column] = 0.3 * nao.lower[column] + 0.7 * nao.upper[column]
        page.slide(joint, q[column])
        assert np.allclose(page.q, q, atol=1e-12)
        assert np.abs(page.poses(nao.link_names) - nao.fk(q)).max() < 1e-6


def test_sliders_have_the_limits_of_the_joints_and_stand_where_they_stand(page: Page, nao: nk.NaoModel) -> None:
    q = nao.posture("Crouch")
    page.set(q)
    for joint, value, low, high in zip(nao.joint_names, q, nao.lower, nao.upper, strict=True):
        slider = page.slider(joint)
        shown = [float(slider.get_attribute(name)) for name in ("min", "max")]
        assert np.allclose(shown, [low, high], atol=1e-12)
        assert math.isclose(float(slider.input_value()), value, abs_tol=1e-6)
    chains = page.run("() => [...document.querySelectorAll('.joints summary')].map((title) => title.textContent)")
    assert chains == list(nao.chains)


def _in_the_room(page: Page, frame: str) -> np.ndarray:
    """Return the pose of a frame relative to the floor, which is at z = 0."""
    placed = "naoKin.robot.root.matrix.clone().multiply(naoKin.robot.pose(naoKin.robot.frames.get(frame)))"
    return np.reshape(page.run(f"(frame) => (naoKin.settle(), {placed}.elements)", frame), (4, 4)).T


def test_the_read_out_gives_position_and_roll_pitch_yaw(page: Page, nao: nk.NaoModel) -> None:
    q = nao.random(11)
    page.reset(q, (1100, 700))  # in a low window the numbers are shown on demand
    for frame in ("Head", "LArm", "RLeg", "CameraBottom", "LFoot/Bumper/Left"):
        page.tab.get_by_label("Frame", exact=True).select_option(frame)
        shown = page.run(
            """() => Object.fromEntries(
                [...document.querySelectorAll(".readout .numbers output")].filter((o) => o.checkVisibility())
                    .map((o) => [o.ariaLabel, [o.dataset.value, o.textContent]]))"""
        )
        T = nao.fk(q, frame)
        expected = dict(
            zip(("x", "y", "z", "roll", "pitch", "yaw"), [*T[:3, 3], *rpy_from_matrix(T[:3, :3])], strict=True)
        )
        assert shown.keys() == expected.keys()
        for name, (value, text) in shown.items():
            assert float(value) == pytest.approx(expected[name], abs=1e-6)
            scale = 1000.0 if name in "xyz" else math.degrees(1.0)
            assert float(text.rstrip("° m").replace("−", "-")) == pytest.approx(scale * expected[name], abs=0.051)


def test_switches_draw_frames_axes_mass_and_support(page: Page, nao: nk.NaoModel) -> None:
    page.set(nao.posture("StandInit"))
    drawn = """() => [naoKin.frames.triads.length, naoKin.axes.screws.length,
        naoKin.balance.group.children.filter(({ visible }) => visible).length]"""
    assert page.run(drawn) == [0, 0, 0]
    for name in ("Effectors", "Joint axes", "Centre of mass", "Support"):
        page.switch(name)
    assert page.run(drawn) == [7, 26, 6]
    legend = page.tab.locator("#legend").inner_text()
    assert sorted(legend.split()) == ["revolute", "spherical", "universal"]
    for name in ("None", "Joint axes", "Centre of mass", "Support"):
        page.switch(name)
    assert page.run(drawn) == [0, 0, 0]
    assert not page.tab.locator("#legend").is_visible()


def test_the_clip_scrubs_between_the_configurations(page: Page, nao: nk.NaoModel, clip: np.ndarray) -> None:
    assert page.tab.locator("#player").is_visible()
    assert page.run("() => naoKin.player.duration") == pytest.approx(1.0)
    scrubber = page.tab.get_by_label("Time")
    middle = (clip[10] + clip[11]) / 2
    for seconds, expected in ((0.0, clip[0]), (0.5, clip[10]), (0.5, clip[10]), (0.525, middle), (1.0, clip[20])):
        page.set(nao.posture("Sit"))  # the robot is moved between two looks at the clip, even at the same time of it
        scrubber.evaluate("(bar, t) => { bar.value = t; bar.dispatchEvent(new Event('input')); }", seconds)
        q = page.q
        assert np.allclose(q, expected, atol=1e-6)
        assert np.abs(page.poses(nao.link_names) - nao.fk(q)).max() < 1e-6
        assert float(page.slider("LKneePitch").input_value()) == pytest.approx(q[nao.joint_names.index("LKneePitch")])


def test_a_slider_takes_over_from_the_clip(page: Page, nao: nk.NaoModel) -> None:
    page.run("() => { naoKin.player.seek(0); naoKin.player.toggle(); }")
    page.slide("HeadYaw", 0.5)
    assert not page.run("() => naoKin.player.playback.playing")
    assert page.q[nao.joint_names.index("HeadYaw")] == pytest.approx(0.5)


def test_a_clip_does_not_lie_down_with_the_direction_given_before_it(page: Page) -> None:
    for start in ("naoKin.player.seek(0.5)", "naoKin.player.toggle()"):
        page.run("() => { naoKin.set(naoKin.q, [1, 0, 0]); naoKin.settle(); }")
        assert _in_the_room(page, "torso")[2, 0] == pytest.approx(1.0)
        page.run(f"() => {{ {start}; naoKin.player.pause(); naoKin.settle(); }}")
        assert page.run("() => naoKin.stance.up") is None
        assert _in_the_room(page, "torso")[2, 2] > 0.9


def test_the_legend_holds_colours_and_kinds_of_joints_at_once(page: Page) -> None:
    colour = "(stops) => naoKin.receive({kind: 'colours', links: [], label: 'heat', low: '1', high: '2', stops})"
    axes = "(on) => naoKin.show({axes: on})"
    legend, stops = page.tab.locator("#legend"), [[0, 0, 1], [1, 0, 0]]
    both = {"heat", "1", "2", "revolute", "spherical", "universal"}
    for first, second in (((colour, stops), (axes, True)), ((axes, True), (colour, stops))):
        page.run(*first)
        page.run(*second)
        assert set(legend.inner_text().split()) == both
        page.run(axes, False)
        assert set(legend.inner_text().split()) == {"heat", "1", "2"}
        page.run(colour, None)
        assert not legend.is_visible()


def test_joints_outside_their_limits_are_red(page: Page, nao: nk.NaoModel) -> None:
    red = "() => [...document.querySelectorAll('.joint.outside')].map((row) => row.dataset.joint)"
    page.set(nao.posture("StandInit"))
    assert page.run(red) == []
    angles = nao.angles(nao.posture("StandInit")) | {"HeadYaw": 2.0, "HeadPitch": 0.45, "LKneePitch": -1.0}
    page.set(nao.configuration(angles, limits="ignore"))
    assert page.run(red) == ["HeadPitch", "LKneePitch"]  # the head by its table, the knee by its box
    tinted = page.run("() => naoKin.robot.meshes.filter(({link}) => naoKin.colours.outside.has(link)).length")
    assert tinted >= 2
    page.set(nao.posture("StandInit"))
    assert page.run(red) == []


def test_the_page_and_the_library_agree_on_what_is_outside(page: Page, nao: nk.NaoModel) -> None:
    rng = np.random.default_rng(5)
    reach = nao.upper - nao.lower
    qs = rng.uniform(nao.lower - 0.05 * reach, nao.upper + 0.05 * reach, (60, nao.nq))
    outside = "(qs) => qs.map((q) => (naoKin.set(q), [...naoKin.robot.outside(naoKin.q)]))"
    for q, columns in zip(qs, page.run(outside, qs.tolist()), strict=True):
        assert {nao.joint_names[column] for column in columns} == {v.joint for v in nao.limit_violations(q)}


def test_whole_body_cameras_show_the_whole_robot_and_little_else(shared: Page, nao: nk.NaoModel) -> None:
    corners = """(name) => {
        naoKin.camera(name);
        const { camera } = naoKin.viewer;
        camera.updateMatrixWorld();
        const { min, max } = naoKin.robot.box([]);
        return [0, 1, 2, 3, 4, 5, 6, 7].map((i) => new MeshCat.THREE.Vector3(
            i & 1 ? max.x : min.x, i & 2 ? max.y : min.y, i & 4 ? max.z : min.z,
        ).project(camera).toArray());
    }"""
    shared.reset(nao.posture("StandInit"), (900, 600))
    page = shared
    box = page.tab.locator("#top").bounding_box()
    lowest_button = box["y"] + box["height"]
    bar = 1.0 - 2.0 * lowest_button / 600.0
    assert bar < 0.9
    for posture in ("StandZero", "LyingBack"):
        page.run("(name) => naoKin.posture(name)", posture)
        for name in ("front", "side", "three-quarter"):
            seen = np.array(page.run(corners, name))[:, :2]
            assert np.abs(seen).max() < 0.95
            assert seen[:, 1].max() < bar + 1e-6
            assert np.ptp(seen, axis=0).max() > 1.08
    page.run("() => { naoKin.notice('The program behind this page has ended.'); naoKin.show({axes: true}); }")
    tops = [page.tab.locator(where).bounding_box()["y"] for where in ("#notice", "#legend", "#player")]
    assert min(tops) > lowest_button


def test_foreign_names_are_text_and_nothing_else(browser: Any, tmp_path: Path) -> None:
    evil = "</script><script>window.hacked=1</script><img src=x onerror='window.hacked=2'>"
    quoted = evil.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;").replace("'", "&apos;")
    names = [quoted, "__proto__", "constructor"]
    links = "".join(f'<link name="l{n}"/>' for n in [*names, "end"])
    joints = "".join(
        f'<joint name="{name}" type="revolute"><parent link="l{name}"/><child link="l{after}"/><axis xyz="0 0 1"/>'
        f'<origin xyz="0 0 0.1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
        for name, after in zip(names, [*names[1:], "end"], strict=True)
    )
    path = tmp_path / "evil.urdf"
    path.write_text(f'<robot name="{quoted}">{links}{joints}</robot>', encoding="utf-8")
    robot = nk.RobotModel.from_urdf(path)
    viewer = Viewer(robot)
    viewer.show_frames(robot.link_names)
    viewer.show_targets({evil: [0.1, 0.0, 0.1]})
    viewer.color_links({robot.link_names[0]: 1.0}, label=evil)
    with opened(browser, viewer.save_html(tmp_path / "evil.html")) as page:
        assert page.run("() => window.hacked") is None
        assert page.tab.locator("h1").inner_text() == evil
        assert page.tab.locator("img").count() == 0
        q = robot.random(1)
        page.set(q)
        assert np.abs(page.poses(robot.frame_names) - robot.fk(q, robot.frame_names)).max() < 1e-6
        assert len(page.requests) == 1


def test_a_robot_of_one_bare_link_makes_a_page(browser: Any, tmp_path: Path) -> None:
    path = tmp_path / "bare.urdf"
    path.write_text('<robot name="bare"><link name="only"/></robot>', encoding="utf-8")
    viewer = Viewer(nk.RobotModel.from_urdf(path))
    for show in (viewer.show_com, viewer.show_support_polygon, viewer.show_joint_axes):
        show()
    viewer.show_ghosts(np.zeros(0))
    with opened(browser, viewer.save_html(tmp_path / "bare.html")) as page:
        assert np.isfinite(page.run("() => naoKin.viewer.camera.position.toArray()")).all()
        assert np.array_equal(page.poses(("only",))[0], np.eye(4))
        assert page.run("() => naoKin.com()") is None


@pytest.mark.full
def test_a_floating_base_moves_in_the_world(browser: Any, tmp_path: Path) -> None:
    nao = nk.load_nao(base="floating")
    q = nao.random(2)
    q[:3], q[3:7] = [0.1, -0.2, 0.4], [0.5, 0.5, 0.5, 0.5]
    viewer = Viewer(nao)
    viewer.display(q)
    with opened(browser, viewer.save_html(tmp_path / "floating.html")) as page:
        assert np.abs(page.poses(nao.link_names) - nao.fk(q)).max() < 1e-6
        page.tab.get_by_role("button", name="Stand", exact=True).click()
        assert np.allclose(page.q[:7], q[:7])
        assert np.allclose(page.q[7:], nk.load_nao().posture("Stand"))


def test_the_camera_goes_along_with_a_robot_that_walks_away_and_not_with_one_that_sways(
    browser: Any, tmp_path: Path
) -> None:
    nao = nk.load_nao(base="floating")
    q = nao.neutral()
    viewer = Viewer(nao)
    viewer.display(q)
    seen = """() => {
        const { viewer, robot } = naoKin;
        const node = robot.nodes[0].getWorldPosition(new MeshCat.THREE.Vector3()).project(viewer.camera);
        return [node.x, node.y, ...viewer.camera.position.toArray(), ...viewer.controls.target.toArray()];
    }"""
    with opened(browser, viewer.save_html(tmp_path / "walk.html")) as page:

        def walk_to(x: float, y: float) -> list[float]:
            page.run("(q) => naoKin.set(q)", [x, y, *q[2:].tolist()])
            page.run("() => { naoKin.settle(); naoKin.viewer.camera.updateWorldMatrix(true, false); }")
            return list(page.run(seen))

        begin = walk_to(0.0, 0.0)
        assert walk_to(0.05, -0.05)[2:] == pytest.approx(begin[2:], abs=1e-9)
        end = walk_to(3.0, -2.0)
        assert max(map(abs, end[:2])) < 0.6  # still in the picture
        # The world of three.js has y up: x and −y of the robot's are its x and z.
        moved = np.subtract(end[2:], begin[2:])
        assert moved[:3] == pytest.approx(moved[3:], abs=1e-9)
        assert moved[1] == pytest.approx(0.0, abs=1e-9)
        assert np.hypot(3.0 - moved[0], 2.0 - moved[2]) < 0.2


def test_the_live_page_follows_and_answers(browser: Any, nao: nk.NaoModel) -> None:
    with Viewer(nao) as viewer:
        one = Page(browser, viewer.url)
        try:
            viewer.wait(5.0)
            assert one.requests[0] == viewer.url
            q = nao.posture("Crouch")
            viewer.display(q)
            one.tab.wait_for_function("(x) => Math.abs(naoKin.q[9] - x) < 1e-9", arg=float(q[9]))
            assert np.array_equal(one.q, q)
            assert np.abs(one.poses(nao.link_names) - nao.fk(q)).max() < 1e-6
            with opened(browser, viewer.url) as other:
                assert np.array_equal(other.q, q)
                other.slide("HeadYaw", 0.7)
                one.tab.wait_for_function("() => Math.abs(naoKin.q[0] - 0.7) < 1e-9")
                assert nao.angles(viewer.q)["HeadYaw"] == pytest.approx(0.7)
                assert other.requests == [viewer.url]
            viewer.animate([nao.posture("StandInit"), q], fps=1.0, play=False)
            one.tab.wait_for_function("() => naoKin.player.loaded")
            viewer.display(q)
            one.tab.wait_for_function("() => !naoKin.player.loaded")
            assert until(lambda: np.array_equal(one.q, q))
            one.run("() => { naoKin.set(naoKin.robot.about.neutral); naoKin.receive({kind: 'still'}); }")
            assert np.array_equal(one.q, nao.neutral())  # whichever of the two messages comes first
            with pytest.warns(OutsideLimitsWarning, match="HeadYaw"):
                viewer.display(nao.configuration({"HeadYaw": 3.0}, limits="ignore"))
            one.tab.wait_for_selector('.joint.outside[data-joint="HeadYaw"]')
            assert one.errors == []
            viewer.close()
            one.tab.wait_for_selector("#notice:not([hidden])")
            one.slide("HeadYaw", -0.3)
            assert one.q[0] == pytest.approx(-0.3)
            # The page may have tried to reconnect meanwhile, which the browser writes to the console.
            assert [error for error in one.errors if "ERR_CONNECTION_REFUSED" not in error] == []
        finally:
            one.close()


@pytest.mark.full
def test_one_browser_draws_all_pictures_of_a_program_as_a_new_one_would(
    browser: Any, nao: nk.NaoModel, tmp_path: Path
) -> None:
    def drawn(viewer: Viewer) -> Any:
        return read_png(viewer.save_png(tmp_path / "x.png", size=(160, 120), overwrite=True).read_bytes())

    one, two = Viewer(nao), Viewer(nao)
    one.display(nao.posture("Sit"))
    first, page = drawn(one), pictures._page
    two.show_com()
    two.show_targets({"ball": [0.3, 0.0, 0.0]})
    two.add_points("cloud", [[0.2, 0.1, 0.0]], size=0.02)
    two.add_robot(nao)
    two.show_ghosts(nao.posture("Crouch"))
    two.animate(nao.posture("Crouch")[None], play=False, figure=[[[[0.0, 0.4, 0.0], [0.0, 0.4, 0.5]]]])
    other = drawn(two)
    assert (other != first).any()
    assert pictures._page is page
    assert np.array_equal(drawn(one), first)  # nothing of the other viewer is left
    one.animate(np.array([nao.posture("Crouch"), nao.posture("Stand")]))
    drawn(one)
    one.display(nao.posture("Sit"))
    assert np.array_equal(drawn(one), first)
    assert pictures._page is page
    older = Viewer(nk.load_nao("v4"))
    older.display(nk.load_nao("v4").posture("Sit"))
    assert drawn(older).shape == first.shape
    assert pictures._page is not page
    pictures.end()
    assert np.array_equal(drawn(one), first)


@pytest.mark.parametrize(("name", "place"), [("CameraTop", [1.5, -0.4, 0.7]), ("CameraBottom", [0.45, -0.1, 0.03])])
def test_a_camera_of_the_robot_sees_a_ball_where_its_lens_says(
    browser: Any, nao: nk.NaoModel, tmp_path: Path, name: str, place: list[float]
) -> None:
    viewer, size = Viewer(nk.load_nao(base="floating")), (320, 240)
    ball = trimesh.creation.icosphere(2, 0.02)
    viewer.add_mesh("ball", ball.vertices + place, ball.faces, color=[1, 0, 0])
    viewer.add_label("label", "not in the world", place)
    with VirtualNao(nao, stepped=True, posture="StandInit") as virtual:
        state = virtual.state()
    pixels = camera_pictures(lambda: viewer)(state, name, size).astype(int)
    v, u = np.nonzero(pixels[..., 0] > 1.6 * pixels[..., 1])
    T = state.T_world_torso @ nao.fk(state.q, name)
    camera = nk.world.camera(nao, name).resized(size)
    assert np.allclose([u.mean(), v.mean()], camera.project(T[:3, :3].T @ (place - T[:3, 3])), atol=0.6)
    assert np.ptp(u) == pytest.approx(2 * 0.02 * camera.fx / np.linalg.norm(place - T[:3, 3]), abs=2.5)
    # The next picture is of the page again, and the inset shows the camera that it would have shown.
    viewer.show("eye")
    after = read_png(viewer.save_png(tmp_path / "x.png", size=size).read_bytes())
    pictures.end()
    assert np.array_equal(read_png(viewer.save_png(tmp_path / "y.png", size=size).read_bytes()), after)


def test_a_picture_needs_no_page_and_leaves_nothing_behind(
    browser: Any, nao: nk.NaoModel, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    deep = tmp_path / ("deep" * 20)  # longer than the path of a browser's socket may be
    deep.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(deep))
    viewer = Viewer(nao)
    pictures.end()
    viewer.save_png(tmp_path / "front.png", camera="front", size=(240, 320))
    picture = read_png((tmp_path / "front.png").read_bytes())
    assert picture.shape == (320, 240, 3)
    assert picture.std() > 8.0
    with pytest.raises(NoBrowser, match=r"no picture within 0.001 s"):
        viewer.save_png(tmp_path / "never.png", timeout=0.001)
    assert viewer._server is None
    pictures.end()
    assert processes(str(tmp_path)) == []
    assert list(deep.iterdir()) == []
    assert sorted(path.name for path in tmp_path.iterdir()) == [deep.name, "front.png"]


def test_two_robots_move_together_and_their_difference_is_read_in_numbers(browser: Any, tmp_path: Path) -> None:
    old, new, path = nk.load_nao("v3.3"), nk.load_nao("v6"), tmp_path / "two.html"
    assert run(["view", "--nao", "v3.3", "--beside", "v6", "--posture", "Crouch", "--html", str(path)]) == 0
    with opened(browser, path) as page:
        line = page.tab.locator(".robots output")
        for posture in ("Crouch", "Sit"):
            q = old.posture(posture)
            page.set(q)
            poses = """(name) => {
                const { robot } = naoKin.others.robots.get(1).shown;
                return robot.pose(robot.linkOf(name)).toArray();
            }"""
            for frame in ("CameraTop", "LArm"):
                page.run("(frame) => naoKin.pick.selection.follow(frame)", frame)
                other = np.reshape(page.run(poses, frame), (4, 4)).T
                assert np.abs(other - new.fk(q, frame)).max() < 1e-6
                E = np.linalg.inv(old.fk(q, frame)) @ new.fk(q, frame)
                away = 1e3 * np.linalg.norm(E[:3, 3])
                turned = math.degrees(float(nk.rotations.natural_invariants(E[:3, :3])[1]))
                text = f"{frame}: {away:.1f} mm, {turned:.1f}° apart"
                assert line.inner_text().replace("\u00a0", " ") == text
        assert not page.switch("Move together")
        page.slide("HeadYaw", 0.5)
        page.run("() => naoKin.pick.selection.follow('Head')")
        assert not line.inner_text().startswith("Head: 0.0 mm, 0.0°")


def test_without_webgl_the_panel_the_numbers_and_the_handles_work(
    browser: Any, document: Path, nao: nk.NaoModel
) -> None:
    with visitor(browser, viewport={"width": 1100, "height": 700}) as context:
        context.add_init_script("""
            const { getContext } = HTMLCanvasElement.prototype;
            HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
                return kind.includes("webgl") ? null : getContext.call(this, kind, ...rest);
            };""")
        tab = context.new_page()
        tab.goto(document.as_uri())
        tab.wait_for_selector("body[data-ready]")
        assert "there is no picture" in tab.locator("#blank").inner_text()
        tab.get_by_role("button", name="Crouch", exact=True).click()
        q = np.array(tab.evaluate("() => [...naoKin.q]"))
        assert np.array_equal(q, nao.posture("Crouch"))
        pose = tab.evaluate("() => naoKin.pose('LArm')")
        assert np.abs(np.reshape(pose, (4, 4)) - nao.fk(q, "LArm")).max() < 1e-6
        assert "margin" in tab.get_by_label("Balance").inner_text()
        tab.locator("#handles button", has_text="LArm").focus()
        for _ in range(3):
            tab.keyboard.press("Shift+ArrowUp")
        moved = nao.position(np.array(tab.evaluate("() => (naoKin.settle(), [...naoKin.q])")), "LArm")
        assert 0.015 < np.linalg.norm(moved - nao.position(q, "LArm")) < 0.035
        tab.locator("button.view").click()
        tab.get_by_role("button", name="Picture", exact=True).click()
        assert "no picture to save" in tab.locator("#message").inner_text()
