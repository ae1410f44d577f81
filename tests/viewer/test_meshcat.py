"""A robot in a meshcat of another program: a real server and browser, and poses read back from the scene."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import meshcat
import numpy as np
import pytest
import umsgpack
from made_up_robots import J, made_up, with_shapes
from meshcat.servers.zmqserver import start_zmq_server_as_subprocess
from viewer_pages import made_of, until, visitor

import nao_kin as nk
from nao_kin.errors import BadArgument, NotFinite, UnknownName, WrongShape
from nao_kin.viewer import MeshcatRobot
from nao_kin.viewer.description import link_paths

# Poses of nodes in the scene's own root, which has z up; null for a node that is not there.
_POSES = """
    (paths) => {
        const below = (node, [first, ...rest]) => (first && node ? below(node.children[first], rest) : node);
        const root = below(viewer.scene_tree, ["meshcat"])?.object;
        if (!root) return paths.map(() => null);  // nothing has arrived yet
        root.updateWorldMatrix(true, true);
        const inverse = root.matrixWorld.clone().invert();
        return paths.map((path) => {
            const node = below(viewer.scene_tree, path.split("/").filter((step) => step));
            return node ? inverse.clone().multiply(node.object.matrixWorld).elements : null;
        });
    }
"""


class Scene:
    """A meshcat server, the page that shows it, and a visualizer that counts what it sends."""

    def __init__(self, visualizer: meshcat.Visualizer, tab: Any) -> None:
        self.visualizer, self.tab = visualizer, tab
        self.sent: list[dict[str, Any]] = []
        send = visualizer.window.send

        def counted(command: Any) -> None:
            self.sent.append(dict(command.lower()))
            send(command)

        visualizer.window.send = counted

    def poses(self, paths: list[str]) -> list[np.ndarray | None]:
        found = self.tab.evaluate(_POSES, paths)
        return [None if elements is None else np.reshape(elements, (4, 4)).T for elements in found]

    def clip(self, duration: float) -> None:
        """Wait for a clip that long, and halt it; meshcat scrubs what has been played."""
        assert until(
            lambda: bool(self.tab.evaluate("() => viewer.animator.duration") == pytest.approx(duration)), 120.0
        )
        self.tab.evaluate("() => { viewer.animator.play(); viewer.animator.pause(); }")

    def seek(self, seconds: float) -> None:
        self.tab.evaluate("(time) => viewer.animator.seek(time)", seconds)

    def shows(self, paths: list[str], expected: np.ndarray, tolerance: float = 1e-6) -> bool:
        """Return whether the page moves the nodes there, which happens a moment after Python sends them."""

        def there() -> bool:
            return all(
                T is not None and np.abs(T - other).max() < tolerance
                for T, other in zip(self.poses(paths), expected, strict=True)
            )

        return until(there, 120.0)


@pytest.fixture(scope="module")
def server() -> Iterator[str]:
    """The address at which a meshcat server takes commands."""
    process, zmq_url, _ = start_zmq_server_as_subprocess()
    try:
        yield zmq_url
    finally:
        process.terminate()
        process.communicate()


@pytest.fixture
def visualizer(server: str) -> Iterator[meshcat.Visualizer]:
    """A visualizer of the server, whose scene is empty."""
    with contextlib.redirect_stdout(io.StringIO()):
        visualizer = meshcat.Visualizer(zmq_url=server)
        visualizer.delete()
        yield visualizer
        visualizer.window.zmq_socket.close(0)


@pytest.fixture(scope="module")
def shared(browser: Any) -> Iterator[Any]:
    with visitor(browser) as context:
        yield context.new_page()


@pytest.fixture
def scene(visualizer: meshcat.Visualizer, shared: Any) -> Scene:
    """The scene in the page that all tests share, with nothing in it and no clip."""
    if not shared.url.startswith("http"):
        shared.goto(visualizer.url())
    shared.wait_for_function("() => !viewer.scene_tree.children.meshcat")
    shared.evaluate("() => { viewer.animator.clear(); viewer.animator.duration = 0; }")
    return Scene(visualizer, shared)


def _nodes(robot: nk.RobotModel, path: str = "/meshcat/nao") -> list[str]:
    """The nodes of the links, in the order of `link_names`."""
    paths = link_paths(robot.tree)
    return [f"{path}/{paths[link]}" for link in robot.link_names]


def test_every_link_in_the_page_is_where_forward_kinematics_says(scene: Scene, nao: nk.NaoModel) -> None:
    shown = MeshcatRobot(nao, scene.visualizer)
    assert shown.notes == ()
    for q in made_of(nao)[::3]:
        shown.display(q)
        assert scene.shows(_nodes(nao), nao.fk(q))


@pytest.mark.full
def test_only_the_joints_that_moved_are_sent(scene: Scene, nao: nk.NaoModel) -> None:
    shown = MeshcatRobot(nao, scene.visualizer)
    q = nao.posture("Stand")
    shown.display(q)
    for joint, value, nodes in (
        ("", 0.0, []),
        ("HeadYaw", 0.3, ["Neck"]),
        ("LHipYawPitch", -0.4, ["LPelvis", "RPelvis"]),
    ):
        if joint:
            q[nao.joint_names.index(joint)] = value
        scene.sent.clear()
        shown.display(q)
        assert sorted(command["path"].rpartition(":")[2] for command in scene.sent) == nodes
        assert {command["type"] for command in scene.sent} <= {"set_transform"}
    assert scene.shows(_nodes(nao), nao.fk(q))


def test_a_page_that_opens_later_sees_the_same(visualizer: meshcat.Visualizer, browser: Any, nao: nk.NaoModel) -> None:
    shown = MeshcatRobot(nao, visualizer, "robots/nao")
    q = nao.posture("Crouch")
    shown.display(q)
    with visitor(browser) as context:
        tab = context.new_page()
        tab.goto(visualizer.url())
        assert Scene(visualizer, tab).shows(_nodes(nao, "/meshcat/robots/nao"), nao.fk(q))


def test_a_floating_base_and_the_node_s_own_transform_place_the_robot(scene: Scene) -> None:
    floating = nk.load_nao(base="floating")
    shown = MeshcatRobot(floating, scene.visualizer["left"], "nao")
    T = nk.screws.pose(nk.rotations.matrix_from_rpy([0.0, 0.0, 0.5]), [0.0, 1.0, 0.3])
    scene.visualizer["left/nao"].set_transform(T)
    q = floating.random(5)
    shown.display(q)
    assert scene.shows(_nodes(floating, "/meshcat/left/nao"), T @ floating.fk(q, reference="world"))


def test_joints_that_slide_follow_and_have_their_own_axes_are_shown(scene: Scene, tmp_path: Path) -> None:
    robot = made_up(
        tmp_path,
        J("lift", kind="prismatic", axis=(0.0, 0.6, 0.8), xyz=(0.1, 0.0, 0.2)),
        J("turn", parent="lift", axis=(0.6, 0.0, 0.8), xyz=(0.0, 0.0, 0.3)),
        J("finger", parent="turn", axis=(1.0, 0.0, 0.0), follows=("turn", -2.0, 0.3)),
    )
    shown = MeshcatRobot(robot, scene.visualizer)
    for q in robot.random(1, 3):
        shown.display(q)
        assert scene.shows(_nodes(robot), robot.fk(q))


def test_a_mirrored_mesh_and_a_cylinder_stand_in_the_page_as_in_the_file(scene: Scene, tmp_path: Path) -> None:
    robot = with_shapes(tmp_path, "stl")
    shown = MeshcatRobot(robot, scene.visualizer)
    assert shown.notes == ("mesh files not found: absent.stl",)
    trunk = f"/meshcat/nao/{link_paths(robot.tree)['trunk']}"
    box = """
        (path) => {
            const node = path.split("/").reduce((node, step) => (step ? node.children[step] : node), viewer.scene_tree);
            const object = node.children["<object>"].object;
            object.geometry.computeBoundingBox();
            object.updateMatrix();
            const { min, max } = object.geometry.boundingBox.clone().applyMatrix4(object.matrix);
            return [min.toArray(), max.toArray()];
        }
    """
    assert scene.shows([trunk], [np.eye(4)])
    mirrored, cylinder = (np.array(scene.tab.evaluate(box, f"{trunk}/visual:{index}")) for index in (1, 2))
    assert np.allclose(mirrored, [[0, -0.05, 0], [0.1, 0, 0.15]], atol=1e-6)
    assert np.allclose(cylinder, [[-0.01, -0.01, -0.2], [0.01, 0.01, 0.2]], atol=1e-6)


def test_frames_are_drawn_where_they_are_move_along_and_go(scene: Scene, nao: nk.NaoModel) -> None:
    shown = MeshcatRobot(nao, scene.visualizer)
    names = ["LArm", "CameraTop", "HeadPitch", "torso"]
    shown.show_frames(names, size=0.1)
    drawn = {
        name: next(c["path"] for c in scene.sent if c["path"].endswith(f"frame:{name}/z")).rpartition("/")[0]
        for name in names
    }
    q = nao.posture("Sit")
    shown.display(q)
    assert scene.shows([drawn[name] for name in names], nao.fk(q, names))
    for axis, direction in zip("xyz", np.eye(3), strict=True):
        # The arrow's own z axis is the axis, and its middle is half its length from the origin.
        poses = scene.poses([f"{drawn[name]}/{axis}" for name in names])
        frames = nao.fk(q, names)
        assert all(
            np.abs(T[:3, 2] - T_frame[:3, :3] @ direction).max() < 1e-6
            for T, T_frame in zip(poses, frames, strict=True)
        )
        middles = frames[:, :3, 3] + 0.05 * frames[:, :3, :3] @ direction
        assert all(np.abs(T[:3, 3] - middle).max() < 1e-6 for T, middle in zip(poses, middles, strict=True))
    shown.show_frames(["RArm"])
    assert until(lambda: scene.poses([drawn["LArm"]])[0] is None, 60.0)
    shown.show_frames([])
    with pytest.raises(UnknownName, match="LArm"):
        shown.show_frames(["LArn"])
    assert not shown._frames


def test_the_frame_of_a_free_joint_stands_in_the_root_that_it_moves(scene: Scene) -> None:
    robot = nk.load_nao("v6", base="floating")
    MeshcatRobot(robot, scene.visualizer).show_frames(["root_joint"])
    root = f"/meshcat/nao/{link_paths(robot.tree)[robot.tree.root]}"
    assert {c["path"] for c in scene.sent if "frame:" in c["path"]} == {f"{root}/frame:root_joint/{a}" for a in "xyz"}


def test_a_motion_plays_scrubs_and_ends_with_the_next_configuration(scene: Scene, nao: nk.NaoModel) -> None:
    shown = MeshcatRobot(nao, scene.visualizer)
    names = ("HeadYaw", "LHipYawPitch", "LHand")
    keys = np.array([[-0.5, 0.0, 0.0], [0.8, -0.6, 1.0], [0.0, -0.3, 0.5]])
    motion = nk.Motion([0.0, 1.0, 2.0], names, keys)
    shown.animate(motion, fps=10.0, play=False)
    trajectory = motion.configurations(nao, rate=10.0)
    scene.clip(2.0)
    for index in (0, 7, 20):
        scene.seek(index / 10.0)
        assert scene.shows(_nodes(nao), nao.fk(trajectory.q[index]))
    scene.seek(0.55)
    between = nao.fk((trajectory.q[5] + trajectory.q[6]) / 2.0)
    assert scene.shows(_nodes(nao), between, 1e-5)
    shown.animate(motion, play=True)
    q = nao.posture("StandInit")
    shown.display(q)
    assert scene.shows(_nodes(nao), nao.fk(q))
    assert not scene.tab.evaluate("() => viewer.animator.playing")


def test_turns_of_more_than_half_a_circle_between_two_configurations_stay_whole(scene: Scene, tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("wheel", axis=(0.0, 1.0, 0.0), limits=(-20.0, 20.0)))
    shown = MeshcatRobot(robot, scene.visualizer)
    shown.animate([[0.0], [10.0]], fps=1.0, play=False)
    scene.clip(1.0)
    for share in (0.1, 0.35, 0.8):
        scene.seek(share)
        assert scene.shows(_nodes(robot), robot.fk([10.0 * share]), 1e-4)


def test_delete_leaves_nothing_of_it_and_other_things_alone(scene: Scene, nao: nk.NaoModel) -> None:
    scene.visualizer["table"].set_transform(np.eye(4))
    shown = MeshcatRobot(nao, scene.visualizer)
    shown.animate(np.stack([nao.posture("Stand"), nao.posture("Crouch")]))
    shown.delete()
    shown.delete()
    assert until(lambda: scene.poses(["/meshcat/nao"])[0] is None, 60.0)
    assert scene.shows(["/meshcat/table"], np.eye(4)[None])
    for call in (lambda: shown.display(nao.neutral()), lambda: shown.show_frames([]), lambda: shown.animate([])):
        with pytest.raises(BadArgument, match="nao_v6 at /meshcat/nao was deleted"):
            call()


def test_a_robot_drawn_again_takes_the_place_of_the_first(scene: Scene, nao: nk.NaoModel) -> None:
    MeshcatRobot(nao, scene.visualizer)
    old = nk.load_nao("v4")
    MeshcatRobot(old, scene.visualizer).display(old.posture("Sit"))
    gone = sorted({*_nodes(nao)} - {*_nodes(old)})
    assert gone
    assert until(lambda: scene.poses(gone[:1])[0] is None, 60.0)
    assert scene.shows(_nodes(old), old.fk(old.posture("Sit")))


@pytest.mark.full
def test_pinocchio_s_own_visualizer_takes_the_model_and_the_geometry(scene: Scene, nao: nk.NaoModel) -> None:
    from pinocchio.visualize import MeshcatVisualizer

    pinocchio = MeshcatVisualizer(nao.model, nao.geometry("collision"), nao.geometry("visual"))
    pinocchio.initViewer(viewer=scene.visualizer, loadModel=True)
    q = nao.posture("Crouch")
    pinocchio.display(q)
    # Our own beside it, with the same shapes in the same places.
    ours = MeshcatRobot(nao, scene.visualizer)
    ours.display(q)
    rows = [row for row in nao.tree.visuals if row.link in ("Head", "l_ankle", "RForeArm")]
    paths, expected = [], []
    for link in dict.fromkeys(row.link for row in rows):
        row = next(row for row in rows if row.link == link)
        T_link_shape = nk.screws.pose(nk.rotations.matrix_from_rpy(row.origin.rpy), row.origin.xyz)
        paths += [f"/meshcat/pinocchio/visuals/{link}_0", f"/meshcat/nao/{link_paths(nao.tree)[link]}/visual:0"]
        expected += [nao.fk(q, link) @ T_link_shape] * 2
    assert len(paths) >= 4
    assert scene.shows(paths, np.array(expected))


class _Window:
    """A meshcat window that discards all commands."""

    def __init__(self) -> None:
        self.commands: list[dict[str, Any]] = []

    def send(self, command: Any) -> None:
        self.commands.append(umsgpack.unpackb(umsgpack.packb(command.lower())))


def test_after_a_clip_every_joint_is_sent_again(nao: nk.NaoModel) -> None:
    window = _Window()
    shown, q = MeshcatRobot(nao, meshcat.Visualizer(window=window)), nao.posture("Stand")
    shown.animate(np.stack([q, nao.posture("Crouch")]))
    window.commands.clear()
    shown.display(q)  # the first configuration of the clip, at whose end the page may be
    assert len([command for command in window.commands if command["type"] == "set_transform"]) == len(
        nao.tree.moving_joints
    )


def test_what_is_no_path_or_configuration_is_refused(nao: nk.NaoModel) -> None:
    visualizer = meshcat.Visualizer(window=_Window())
    for path in ("", "/", "a//b", "/nao", "\ud800"):
        with pytest.raises(BadArgument):
            MeshcatRobot(nao, visualizer, path)
    assert visualizer.window.commands == []
    shown = MeshcatRobot(nao, visualizer)
    for q, error in ((np.zeros(24), WrongShape), (np.full(25, np.nan), NotFinite)):
        with pytest.raises(error):
            shown.display(q)
    with pytest.raises(WrongShape):
        shown.animate(nao.neutral())
    with pytest.raises(BadArgument, match="fps"):
        shown.animate([nao.neutral()], fps=0.0)


@pytest.mark.full
def test_the_library_s_viewer_needs_no_python_of_meshcat() -> None:
    import subprocess
    import sys

    program = "import sys, nao_kin as nk; nk.Viewer(nk.load_nao()).static_html(); sys.exit('meshcat' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 0
