"""How the viewer places a robot on the floor: standing, sitting and lying postures, however they are shown."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from made_up_robots import J, made_up
from viewer_pages import Page, messages_of, opened

import nao_kin as nk
from nao_kin.viewer import Viewer
from nao_kin.viewer.description import robot_drawables


def _set_down(page: Page, q: np.ndarray) -> np.ndarray:
    """Return the pose of the root relative to the floor for a configuration shown as if it were the first."""
    page.run("(q) => { naoKin.shown.standing.forget(); naoKin.set(q, null); }", q.tolist())
    return _placement(page)


def _placement(page: Page) -> np.ndarray:
    return np.reshape(page.run("() => (naoKin.settle(), naoKin.robot.placement().elements)"), (4, 4)).T


def _up(page: Page) -> np.ndarray:
    return _placement(page)[2, :3]


def _degrees(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b)), np.dot(a, b))))


def _vertices(nao: nk.NaoModel, q: np.ndarray) -> np.ndarray:
    """Every vertex of the meshes in the root's frame, by the library's own forward kinematics."""
    drawables, _ = robot_drawables(nao.tree)
    poses = dict(zip(nao.link_names, nao.fk(q), strict=True))
    parts = []
    for drawable in drawables:
        T = poses[drawable.link] @ drawable.T_link_shape
        parts.append(drawable.shape.vertices.astype(np.float32).astype(float) @ T[:3, :3].T + T[:3, 3])
    return np.concatenate(parts)


def _rests(nao: nk.NaoModel, q: np.ndarray, T: np.ndarray) -> bool:
    """Whether the robot is on the floor with its centre of mass above what touches it, looked at from all sides."""
    vertices = _vertices(nao, q) @ T[:3, :3].T + T[:3, 3]
    # The planes of flat soles are on the floor, from which the edges of the feet differ.
    assert abs(vertices[:, 2].min()) < 3e-4
    centre = T[:3, :3] @ nao.com(q) + T[:3, 3]
    touching = vertices[vertices[:, 2] < 0.005, :2] - centre[:2]
    angles = np.linspace(0.0, 2.0 * np.pi, 720)
    return bool((touching @ np.stack([np.cos(angles), np.sin(angles)])).max(axis=0).min() > 0.0)


def test_every_posture_is_set_down_balanced_on_the_floor(page: Page, nao: nk.NaoModel) -> None:
    for name in nao.posture_names:
        T = _set_down(page, nao.posture(name))
        assert _rests(nao, nao.posture(name), T), name


_READ_OUT = """(qs) => qs.map((q) => {
    naoKin.shown.standing.forget();
    naoKin.set(q, null);
    naoKin.settle();
    const { hull, margin } = naoKin.balance.stand;
    return {
        T: [...naoKin.robot.placement().elements],
        hull: hull.map(({ x, y }) => [x, y]),
        margin: Number.isNaN(margin) ? null : margin,
        touching: naoKin.robot.corners().map((corners) => corners.some(({ z }) => z <= 0.002)),
        words: document.querySelector("[aria-label=Balance]").textContent,
    };
})"""


def _near_postures(nao: nk.NaoModel) -> np.ndarray:
    """Return all postures, noise around each, and changes of one joint."""
    rng, rows = np.random.default_rng(5), []
    for q in (nao.posture(name) for name in nao.posture_names):
        rows += [q, *(nao.clamp(q + rng.normal(0.0, sigma, nao.nq)) for sigma in (0.003, 0.03, 0.1) for _ in range(8))]
        rows += [q + change * np.eye(nao.nq)[rng.integers(nao.nq)] for change in (-0.2, -0.1, -0.03, 0.03, 0.1, 0.2)]
    return np.array([*rows, nao.posture("Stand", LKneePitch=-0.29, limits="ignore")])


def test_near_and_far_from_postures_the_page_reads_as_the_library(page: Page, nao: nk.NaoModel) -> None:
    # Among the last are a foot that is not quite level, and symmetric links on the floor.
    qs = np.concatenate([_near_postures(nao), nao.random(4, 12), nao.random(7, 192)[[4, 164]], nao.random(11, 61)[60:]])
    found = nk.world.balance(nao, qs)
    down = found.down
    assert min(np.count_nonzero(down.stands), np.count_nonzero(~down.stands)) > 60
    assert min(np.count_nonzero(on) for on in (np.isnan(found.margin), found.margin < 0.0, found.margin > 0.0)) > 12
    for k, shown in enumerate(page.run(_READ_OUT, qs.tolist())):
        assert np.abs(np.reshape(shown["T"], (4, 4)).T - down.T_world_base[k]).max() < 1e-9, k
        assert shown["touching"] == down.touching[k].tolist(), k
        margin = float(found.margin[k])
        if np.isnan(margin):
            assert (shown["margin"], shown["words"]) == (None, "no support"), k
            continue
        assert shown["margin"] == pytest.approx(margin, abs=1e-9), k
        assert shown["words"].startswith("margin" if margin >= 0.0 else "tips"), k
        polygon = found.vertices[k][np.isfinite(found.vertices[k, :, 0])]
        assert np.allclose(nk.robot.SupportPolygon.around(shown["hull"]).signed_distance(polygon), 0.0, atol=1e-6), k
        assert np.allclose(nk.robot.SupportPolygon(polygon).signed_distance(shown["hull"]), 0.0, atol=1e-6), k


def test_a_robot_that_would_fall_stands_in_the_red(page: Page, nao: nk.NaoModel) -> None:
    q = nao.configuration({"LHipPitch": -0.9, "LKneePitch": 1.5, "LAnklePitch": -0.5})
    T = _set_down(page, q)
    assert (T @ nao.fk(q, "RLeg"))[2, 2] == pytest.approx(1.0, abs=1e-9)
    assert not _rests(nao, q, T)


def test_of_two_soles_that_could_carry_it_the_robot_stands_on_the_one_that_turns_it_less(
    page: Page, nao: nk.NaoModel
) -> None:
    for left, right, standing in ((0.35, -0.2, "RLeg"), (0.2, -0.35, "LLeg")):
        q = nao.configuration({"LAnkleRoll": left, "RAnkleRoll": right})
        T = _set_down(page, q)
        assert (T @ nao.fk(q, standing))[2, 2] == pytest.approx(1.0, abs=1e-9), (left, right)


def test_what_is_shown_alone_does_not_depend_on_what_was_shown_before(page: Page, nao: nk.NaoModel) -> None:
    q = nao.posture("Sit")
    alone = _set_down(page, q)
    for other in ("LyingBelly", "StandZero", "LyingBack"):
        _set_down(page, nao.posture(other))
        page.set(q)
        assert np.abs(_placement(page) - alone).max() < 1e-9


@pytest.mark.full
def test_a_slow_way_from_crouching_to_lying_falls_once(page: Page, nao: nk.NaoModel) -> None:
    way = [nao.posture(name) for name in ("Crouch", "SitRelax", "LyingBack")]
    _set_down(page, way[0])
    before, jumps = _up(page), 0
    for a, b in pairwise(way):
        for q in np.linspace(a, b, 80):
            page.set(q)
            up = _up(page)
            jumps += _degrees(up, before) > 15.0
            before = up
    assert jumps <= 2  # where it leaves its feet, and where it leaves its seat
    assert before[0] > 0.95


def test_an_arm_that_is_moved_by_the_arrow_keys_turns_the_robot_little_by_little(page: Page, nao: nk.NaoModel) -> None:
    _set_down(page, nao.posture("SitRelax"))
    page.slider("LShoulderPitch").focus()
    before = _up(page)
    for key in ["ArrowLeft"] * 12 + ["ArrowRight"] * 12:
        page.tab.keyboard.press(key)
        assert _degrees(_up(page), before) < 6.0
        before = _up(page)
    assert _degrees(before, np.array(Viewer(nao).rest("SitRelax"))) < 6.0


def _box_with_a_mass(folder: Path, kind: str, up: tuple[float, float, float]) -> nk.RobotModel:
    """A box of 0.1 × 0.2 × 1 m that carries its own mass once more, on a joint along y, and knows one posture."""
    path = folder / "box.urdf"
    shape = '<visual><geometry><box size="0.1 0.2 1"/></geometry></visual>'
    mass = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    path.write_text(
        f'<robot name="box"><link name="a">{shape}{mass}</link><link name="b">{mass}</link>'
        f'<joint name="j" type="{kind}"><parent link="a"/><child link="b"/><axis xyz="0 1 0"/>'
        '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>',
        encoding="utf-8",
    )
    posture = nk.semantics.Posture({"j": 0.0}, up)
    return nk.RobotModel(nk.RobotModel.from_urdf(path).tree, nk.semantics.Semantics(postures={"Rest": posture}))


def test_a_posture_rests_as_ever_after_the_robot_was_made_to_fall_in_the_page(browser: Any, tmp_path: Path) -> None:
    robot = _box_with_a_mass(tmp_path, "prismatic", (0.0, 0.0, 1.0))
    with Viewer(robot) as viewer, opened(browser, viewer.url) as page:

        def fall() -> None:
            assert np.allclose(_up(page), [0.0, 0.0, 1.0], atol=1e-6)
            for value in (0.1, 0.3, 0.1, 0.0):  # beyond 0.2 the centre of mass leaves the foot of the box
                page.slide("j", value)
                page.run("() => naoKin.settle()")
            assert np.allclose(_up(page), [0.0, -1.0, 0.0], atol=1e-6)  # it lies on the side that it fell on

        fall()
        page.tab.get_by_role("button", name="Rest", exact=True).click()
        fall()
        viewer.display(robot.posture("Rest"))
        page.tab.wait_for_function("() => (naoKin.settle(), naoKin.robot.placement().elements[10] > 0.999999)")


# --- clips and directions given ---------------------------------------------------------------------------------------


def _scrub(page: Page, key: str) -> None:
    page.tab.get_by_label("Time").focus()
    page.tab.keyboard.press(key)


@pytest.mark.full
def test_a_clip_goes_along_with_the_directions_given(browser: Any, nao: nk.NaoModel, tmp_path: Path) -> None:
    viewer, q = Viewer(nao), nao.posture("StandZero")
    angles = np.linspace(0.0, np.pi / 2, 11)
    ups = np.stack([np.sin(angles), np.zeros(11), np.cos(angles)], axis=1)
    for up, begin, end in ((2.0 * ups, ups[0], ups[-1]), ([0.0, 3.0, 0.0], [0, 1, 0], [0, 1, 0])):
        viewer.animate(np.tile(q, (11, 1)), 10.0, play=False, up=up)
        with opened(browser, viewer.save_html(tmp_path / "falls.html", overwrite=True)) as page:
            assert np.allclose(_up(page), begin, atol=1e-6)
            _scrub(page, "End")
            assert np.allclose(_up(page), end, atol=1e-6)
            assert page.run("() => naoKin.robot.lowest()") == pytest.approx(0.0, abs=1e-9)
            page.slide("HeadYaw", 0.5)  # what a slider moves stays as the clip left it
            assert np.allclose(_up(page), end, atol=1e-6)
            page.tab.get_by_role("button", name="Stand", exact=True).click()
            assert _up(page)[2] > 0.95


def test_a_motion_takes_a_direction_too(nao: nk.NaoModel) -> None:
    viewer = Viewer(nao)
    motion = nk.Motion([0.0, 1.0], ["HeadYaw"], [[0.0], [0.5]])
    viewer.animate(motion, missing="LyingBack", up=[2.0, 0.0, 0.0])
    messages = messages_of(viewer.static_html())
    (joints,) = (m for m in messages if m.get("kind") == "joints")
    (clip,) = (m for m in messages if m.get("kind") == "clip")
    assert joints["up"] == [1.0, 0.0, 0.0]
    ups = np.frombuffer(clip["ups"].data, dtype=np.float32).reshape(-1, 3)
    assert len(ups) == 31
    assert (ups == [1.0, 0.0, 0.0]).all()


# --- other robots, and time -------------------------------------------------------------------------------------------


def test_a_robot_on_point_feet_keeps_its_trunk_upright_until_its_base_is_turned(browser: Any, tmp_path: Path) -> None:
    joints = []
    for name, x, y in (("lf", 0.2, 0.1), ("rf", 0.2, -0.1), ("lh", -0.2, 0.1), ("rh", -0.2, -0.1)):
        joints.append(J(f"{name}_hip", axis=(1.0, 0.0, 0.0), xyz=(x, y, 0.0), parent="base"))
        joints.append(J(f"{name}_thigh", axis=(0.0, 1.0, 0.0)))
        joints.append(J(f"{name}_knee", axis=(0.0, 1.0, 0.0), xyz=(0.0, 0.0, -0.2)))
        joints.append(J(f"{name}_foot", kind="fixed", xyz=(0.0, 0.0, -0.2)))
    robot = made_up(tmp_path, *joints)
    viewer = Viewer(robot)
    viewer.display(q := np.tile([0.0, 0.5, -1.0], 4))
    feet = tuple(f"{name}_foot_l" for name in ("lf", "rf", "lh", "rh"))
    with opened(browser, viewer.save_html(tmp_path / "robot.html")) as page:
        assert np.allclose(_placement(page)[:3, :3], np.eye(3), atol=1e-12)
        buttons, line = page.tab.locator("#handles"), page.tab.locator("#drag")
        buttons.get_by_role("button", name="lf_foot_l").focus()
        page.tab.keyboard.press("Shift+ArrowUp")
        assert line.inner_text().startswith("lf_foot_l, at ")
        page.tab.keyboard.press("Escape")
        buttons.get_by_role("button", name="base", exact=True).focus()
        for _ in range(5):
            page.tab.keyboard.press("x")
        assert line.inner_text() == "base turned by 5.0° about x"
        page.tab.keyboard.press("Enter")
        # Without soles the vertical is kept instead.
        T = _placement(page)
        assert _degrees(T[2, :3], np.array([0.0, 0.0, 1.0])) == pytest.approx(5.0, abs=1e-6)
        assert np.ptp((T @ robot.fk(page.q, feet))[:, 2, 3]) < 1e-6
        page.tab.keyboard.press("ControlOrMeta+z")
        assert np.array_equal(page.q, q)
        assert np.allclose(_placement(page)[:3, :3], np.eye(3), atol=1e-12)


def test_a_robot_without_soles_that_has_a_resting_posture_settles_in_it(browser: Any, tmp_path: Path) -> None:
    robot = _box_with_a_mass(tmp_path, "revolute", (0.9, 0.1, 0.2))
    with opened(browser, Viewer(robot).save_html(tmp_path / "box.html")) as page:
        assert np.allclose(_up(page), [1.0, 0.0, 0.0], atol=1e-9)
