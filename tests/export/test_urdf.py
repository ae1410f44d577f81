"""A robot written as a URDF is the same robot to whoever reads it."""

from __future__ import annotations

import json
import os
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
import yourdfpy
from loops import for_all, full
from made_up_robots import J, made_up

import nao_kin as nk
from nao_kin.errors import BadArgument
from nao_kin.export.inertia import make_physical, realizable
from nao_kin.export.variants import Variant
from nao_kin.robot.nao.model import nao_urdf_path
from nao_kin.robot.urdf.reader import read_urdf

DATA = Path(__file__).parents[1] / "data"
VERSIONS = ("v3.2", "v3.3", "v4", "v5", "v6")
CHOICES = {
    "frames": ("all", "effectors", "none"),
    "names": ("naoqi", "ros"),
    "coupling": ("mimic", "locked", "independent"),
    "inertia": ("published", "physical"),
}
VARIANTS = [dict(zip(CHOICES, chosen, strict=True)) for chosen in product(*CHOICES.values())]
# The same joint, or what it is fixed at.
LOCKED = ("LHipYawPitch", "LHand", "RHand")


def _name(variant: dict[str, str]) -> str:
    return "-".join(variant.values())


def _values(nao: nk.RobotModel, q: np.ndarray, ros: bool) -> dict[str, float]:
    """Value of every joint, followers too, in the names of the variant."""
    values = dict(zip(nao.joint_names, q.tolist(), strict=True))
    values |= {name: float(mimic.value(values[mimic.joint])) for name, mimic in nao.mimics.items()}
    names = nao.semantics.ros_names if ros else {}
    return {names.get(name, name): value for name, value in values.items()}


def _links(nao: nk.RobotModel, tree: Any, ros: bool) -> dict[str, str]:
    """Link of the variant → the link of the NAO at the same place, which turns with it."""
    if not ros:
        return {link: link for link in tree.links}
    back: dict[str, str] = {}
    for link in nao.link_names:
        back.setdefault(nao.semantics.ros_names.get(link, link), link)
    return {link: back[link] for link in tree.links}


def _pinocchio_fk(path: Path, values: dict[str, float], links: list[str], *, mimic: bool) -> np.ndarray:
    model = pin.buildModelFromUrdf(str(path), mimic=mimic)
    q = pin.neutral(model)
    for name, joint in zip(model.names, model.joints, strict=True):
        if name in values and joint.shortname() != "JointModelMimic":
            q[joint.idx_q] = values[name]
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    return np.array([data.oMf[model.getFrameId(link, pin.FrameType.BODY)].homogeneous for link in links])


def _yourdfpy_fk(path: Path, values: dict[str, float], links: list[str]) -> np.ndarray:
    robot = yourdfpy.URDF.load(str(path), load_meshes=False, build_scene_graph=True)
    robot.update_cfg({name: values[name] for name in robot.actuated_joint_names})
    return np.array([robot.get_transform(link, robot.base_link) for link in links])


@pytest.mark.parametrize(
    ("version", "variant"),
    [
        *((VERSIONS[-1], variant) for variant in VARIANTS),
        # Every fifth, which together have all choices.
        *full(*((version, each) for start, version in enumerate(VERSIONS[:-1]) for each in VARIANTS[start::5])),
    ],
    ids=lambda value: value if isinstance(value, str) else _name(value),
)
def test_every_variant_moves_as_the_robot_does(version: str, variant: dict[str, str], tmp_path: Path) -> None:
    nao = nk.load_nao(version)
    path = tmp_path / "nao.urdf"
    nk.export.urdf(nao, path, meshes="none", **variant)
    q = nao.random(np.random.default_rng(5))
    if variant["coupling"] == "locked":
        q[[nao.joint_names.index(name) for name in LOCKED]] = 0.0
    ros = variant["names"] == "ros"
    values, read = _values(nao, q, ros), nk.RobotModel.from_urdf(path)
    places = _links(nao, Variant(**variant).tree_of(nao)[0], ros)
    expected = nao.fk(q, list(places.values()))

    own = read.configuration({name: values[name] for name in read.joint_names}, limits="ignore")
    np.testing.assert_allclose(read.fk(own, list(places)), expected, atol=1e-12)
    np.testing.assert_allclose(read.com(own), nao.com(q), atol=1e-12)
    assert read.mass == pytest.approx(nao.mass, abs=1e-12)
    np.testing.assert_allclose(_yourdfpy_fk(path, values, list(places)), expected, atol=1e-12)
    mimic = variant["coupling"] == "mimic"
    if mimic and ros:  # LFinger11 is before LHand in the alphabet, in which urdfdom sorts
        with pytest.raises(ValueError, match="mimic"):
            pin.buildModelFromUrdf(str(path), mimic=True)
    else:
        np.testing.assert_allclose(
            _pinocchio_fk(path, values, list(places), mimic=mimic), expected, atol=1e-12, err_msg="Pinocchio"
        )
    if variant["inertia"] == "physical":
        moving = {joint.child for joint in read.tree.moving_joints}
        bodies = read.tree.inertials
        assert all(realizable(body) for body in bodies.values() if body.mass > 0.0)
        assert all(bodies[link].mass > 0.0 for link in moving)


def test_the_default_is_what_was_read(tmp_path: Path) -> None:
    nao = nk.load_nao("v5")
    done = nk.export.urdf(nao, tmp_path / "nao.urdf")
    tree = read_urdf(done.path)
    assert done.changes == ()
    assert (tree.joints, dict(tree.inertials)) == (nao.tree.joints, dict(nao.tree.inertials))
    assert set(tree.visuals) == set(nao.tree.visuals)
    assert set(tree.collisions) == set(nao.tree.collisions)
    assert set(tree.links) == set(nao.tree.links)


# Inertias.


@for_all("version", VERSIONS)
def test_the_published_inertias_are_mended_only_where_no_body_can_have_them(version: str) -> None:
    nao = nk.load_nao(version)
    mended, changes = make_physical(nao.tree)
    changed = {link for link, body in mended.inertials.items() if nao.tree.inertials.get(link) != body}
    assert changed == {line.partition(":")[0] for line in changes}
    expected = {"v3.2": {"LHip", "RHip", "r_ankle"}, "v3.3": {"LHip", "RHip"}, "v4": set(), "v5": set()}
    if version in expected:
        assert changed == expected[version]
    else:
        assert changed == {link for link in mended.links if "Finger" in link or "Thumb" in link} | {
            "LHand_link", "RHand_link", "l_wrist", "r_wrist"
        }  # fmt: skip


def test_no_tensor_that_a_body_can_have_is_nearer(tmp_path: Path) -> None:
    nao = nk.load_nao("v3.2")
    rng = np.random.default_rng(7)

    def moments(tree: Any) -> np.ndarray:
        xx, xy, xz, yy, yz, zz = tree.inertials["LHip"].inertia
        inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        return 0.5 * np.trace(inertia) * np.eye(3) - inertia

    before, after = moments(nao.tree), moments(make_physical(nao.tree)[0])
    assert np.linalg.eigvalsh(before)[0] < 0.0 < np.linalg.eigvalsh(after)[0]
    distance, size = np.linalg.norm(after - before), np.linalg.norm(before)
    for _ in range(2000):
        step = rng.normal(size=(3, 3)) * size * 10.0 ** rng.uniform(-4, 0)
        other = after + step + step.T
        if np.linalg.eigvalsh(other)[0] >= 0.0:
            assert np.linalg.norm(other - before) > distance - 1e-5 * size


def test_the_robot_without_massless_links_falls_as_before() -> None:
    """Balls on the axes change nothing that another joint feels: its row of the mass matrix stays."""
    nao, mended = nk.load_nao("v6"), nk.RobotModel(make_physical(nk.load_nao("v6").tree)[0])
    q = nao.random(np.random.default_rng(3))
    hands = [nao.joint_names.index(name) for name in ("LHand", "RHand")]
    rows = []
    for robot in (nao, mended):
        M = pin.crba(robot.model, robot.model.createData(), q)
        M = np.triu(M) + np.triu(M, 1).T
        rows.append(np.delete(np.delete(M, hands, 0), hands, 1))
        smallest = np.linalg.eigvalsh(M)[0]
    np.testing.assert_allclose(rows[1], rows[0], atol=1e-15)
    assert smallest > 1e-8


def test_mass_comes_from_nowhere_only_where_nothing_has_any(tmp_path: Path) -> None:
    path = tmp_path / "light.urdf"
    path.write_text(
        '<robot name="light"><link name="a"/><link name="b"/><link name="c"/>'
        '<joint name="ab" type="continuous"><parent link="a"/><child link="b"/></joint>'
        '<joint name="bc" type="continuous"><parent link="b"/><child link="c"/><origin xyz="1 0 0"/></joint></robot>'
    )
    tree, changes = make_physical(read_urdf(path))
    assert changes[-1] == "a: no link that carries b has mass; 0.002 kg added"
    assert [tree.inertials[link].mass for link in "bc"] == [0.001, 0.001]
    assert all(realizable(body) for body in tree.inertials.values())


def test_a_point_mass_becomes_a_ball_of_water(tmp_path: Path) -> None:
    path = tmp_path / "point.urdf"
    path.write_text('<robot name="p"><link name="a"><inertial><mass value="4.18879"/></inertial></link></robot>')
    tree, changes = make_physical(read_urdf(path))
    assert changes == ("a: no inertia → a ball of water, 0.0168 kg m²",)  # 10 cm: 0.4 · 4.19 · 0.01
    assert tree.inertials["a"].inertia[0] == pytest.approx(0.4 * 4.18879 * 0.1**2, rel=1e-5)


@pytest.mark.parametrize(("thickness", "mended"), [(0.0, True), (0.9e-6, True), (1.1e-6, False)])
def test_a_sheet_thinner_than_a_millionth_is_made_as_thick(thickness: float, mended: bool, tmp_path: Path) -> None:
    """Second moments 1, 1 and `thickness` kg m², so that Ixx = Iyy = 1 + thickness and Izz = 2."""
    path = tmp_path / "sheet.urdf"
    inertia = f'<inertia ixx="{1 + thickness!r}" iyy="{1 + thickness!r}" izz="2" ixy="0" ixz="0" iyz="0"/>'
    path.write_text(f'<robot name="s"><link name="a"><inertial><mass value="3"/>{inertia}</inertial></link></robot>')
    tree, changes = make_physical(read_urdf(path))
    assert len(changes) == mended
    xx, _, _, yy, _, zz = tree.inertials["a"].inertia
    assert (xx + yy - zz) / 2 == pytest.approx(1e-6 if mended else thickness, rel=1e-5)
    assert yy + zz - xx == pytest.approx(2.0, rel=1e-5)


@pytest.mark.parametrize("size", [0.0, 1e-22, 4e-18, 1.9e-12, 2.1e-12, 1e-9])
def test_a_tensor_of_rounding_errors_is_none(size: float, tmp_path: Path) -> None:
    """A rod along z of two kilograms; 2e-12 kg m² is that of one that reaches a micrometre far."""
    path = tmp_path / "rod.urdf"
    inertia = f'<inertia ixx="{size}" iyy="{size}" izz="0" ixy="0" ixz="0" iyz="0"/>'
    path.write_text(f'<robot name="r"><link name="a"><inertial><mass value="2"/>{inertia}</inertial></link></robot>')
    tree, changes = make_physical(read_urdf(path))
    assert realizable(tree.inertials["a"])
    assert ("no inertia → a ball of water" in changes[0]) == (size < 2e-12)
    assert np.diag(nk.RobotModel(tree).model.inertias[0].inertia).max() >= min(size, 1e-12)


def test_a_negative_tensor_is_called_negative_and_becomes_a_ball_of_water(tmp_path: Path) -> None:
    path = tmp_path / "negative.urdf"
    inertia = '<inertia ixx="-1" iyy="-1" izz="-1" ixy="0" ixz="0" iyz="0"/>'
    path.write_text(
        f'<robot name="n"><link name="a"><inertial><mass value="4.18879"/>{inertia}</inertial></link></robot>'
    )
    tree, changes = make_physical(read_urdf(path))
    assert changes == ("a: a negative inertia → a ball of water, 0.0168 kg m²",)
    assert realizable(tree.inertials["a"])


# Names.


@for_all("version", VERSIONS[:4])
def test_links_and_joints_are_named_and_connected_as_in_nao_description(version: str) -> None:
    published = json.loads((DATA / "nao_description_names.json").read_text())["versions"][version]
    tree, _ = Variant(names="ros").tree_of(nk.load_nao(version))
    ours = {"LArm", "RArm", "LFoot/Sole", "RFoot/Sole", "SpeakerLeft", "SpeakerRight"}
    if version == "v5":
        ours |= {f"Micro{place}_frame" for place in ("FrontCenter", "RearCenter", "SurroundLeft", "SurroundRight")}
    assert tree.name == published["robot"]
    assert set(tree.links) == set(published["links"]) | ours
    joints = {(joint.name, joint.parent, joint.child) for joint in tree.joints if joint.child not in ours}
    assert joints == set(map(tuple, published["joints"]))


@for_all("frames", CHOICES["frames"])
@for_all("version", VERSIONS)
def test_what_the_semantics_name_is_there_under_its_ros_name(version: str, frames: str) -> None:
    nao = nk.load_nao(version)
    tree, _ = Variant(names="ros", frames=frames).tree_of(nao)
    new = nao.semantics.ros_names
    named = {new.get(frame, frame) for frame in nao.semantics.frames()}
    assert (named <= set(tree.links)) == (frames != "none")


# Meshes.


def test_copied_meshes_are_found_beside_the_file(tmp_path: Path) -> None:
    nao = nk.load_nao("v6")
    done = nk.export.urdf(nao, tmp_path / "nao.urdf")
    assert sorted(done.files) == sorted([done.path, *(tmp_path / "meshes").iterdir()])
    assert len(yourdfpy.URDF.load(str(done.path)).scene.geometry) == len(nao.tree.visuals)
    model = pin.buildModelFromUrdf(str(done.path))
    looks = pin.buildGeomFromUrdf(model, str(done.path), pin.GeometryType.VISUAL, package_dirs=[str(tmp_path)])
    assert looks.ngeoms == len(nao.tree.visuals)


@pytest.mark.parametrize(
    ("meshes", "first"),
    [
        ("package://nao_description", "package://nao_description/meshes/torso_white.obj"),
        ("package://nao_description/", "package://nao_description/meshes/torso_white.obj"),
        ("package://nao/a/b", "package://nao/a/b/torso_white.obj"),
        ("absolute", str(nao_urdf_path("v6").resolve().parent / "meshes/torso_white.obj")),
    ],
)
def test_meshes_have_the_names_that_are_asked_for(meshes: str, first: str, tmp_path: Path) -> None:
    done = nk.export.urdf(nk.load_nao("v6"), tmp_path / "nao.urdf", meshes=meshes)
    assert done.files == (done.path,)
    assert read_urdf(done.path).visuals[0].geometry == nk.urdf.MeshFile(first)


def test_without_meshes_the_other_shapes_stay(tmp_path: Path) -> None:
    nao = nk.load_nao("v6")
    tree = read_urdf(nk.export.urdf(nao, tmp_path / "nao.urdf", meshes="none").path)
    assert tree.visuals == ()
    assert set(tree.collisions) == set(nao.tree.collisions)


def test_materials_and_textures_go_with_their_meshes(tmp_path: Path) -> None:
    (tmp_path / "in/m/t").mkdir(parents=True)
    (tmp_path / "in/m/a.obj").write_text("mtllib t/a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    (tmp_path / "in/m/t/a.mtl").write_text("newmtl x\nmap_Kd -s 1 1 1 skin one.png\nmap_Ks gone.png\n")
    (tmp_path / "in/m/t/skin one.png").write_bytes(b"png")
    (tmp_path / "in/b.dae").write_text("<COLLADA><image><init_from>m/t/skin one.png</init_from></image></COLLADA>")
    visual = '<visual><geometry><mesh filename="{}"/></geometry></visual>'
    (tmp_path / "in/r.urdf").write_text(
        f'<robot name="r"><link name="a">{visual.format("m/a.obj")}{visual.format("b.dae")}</link></robot>'
    )
    (tmp_path / "out").mkdir()
    done = nk.export.urdf(nk.RobotModel.from_urdf(tmp_path / "in/r.urdf"), tmp_path / "out/r.urdf")
    names = {file.relative_to(tmp_path / "out").as_posix() for file in done.files}
    assert names == {"r.urdf", "meshes/m/a.obj", "meshes/m/t/a.mtl", "meshes/m/t/skin one.png", "meshes/b.dae"}


@pytest.mark.parametrize("meshes", ["relative", "absolute", "package://x"])
def test_a_missing_mesh_is_named_and_nothing_is_written(meshes: str, tmp_path: Path) -> None:
    path = tmp_path / "r.urdf"
    visual = '<visual><geometry><mesh filename="gone.stl"/></geometry></visual>'
    path.write_text(f'<robot name="r"><link name="a">{visual}</link></robot>')
    (tmp_path / "out").mkdir()
    robot = nk.RobotModel.from_urdf(path)
    with pytest.raises(BadArgument, match=r"r: the mesh 'gone.stl' is not there; meshes='none'"):
        nk.export.urdf(robot, tmp_path / "out/r.urdf", meshes=meshes)
    assert os.listdir(tmp_path / "out") == []
    nk.export.urdf(robot, tmp_path / "out/r.urdf", meshes="none")


# Files.


def test_a_mesh_of_somebody_else_is_replaced_by_force_only(tmp_path: Path) -> None:
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes/torso_white.obj").write_text("mine")
    with pytest.raises(BadArgument, match=r"torso_white.obj exists with other content; overwrite=True \(--force\)"):
        nk.export.urdf(nk.load_nao("v6"), tmp_path / "nao.urdf")
    assert os.listdir(tmp_path) == ["meshes"]
    assert os.listdir(tmp_path / "meshes") == ["torso_white.obj"]
    nk.export.urdf(nk.load_nao("v6"), tmp_path / "nao.urdf", overwrite=True)
    assert (tmp_path / "meshes/torso_white.obj").read_text() != "mine"


def test_a_write_that_fails_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    calls = []

    def full(descriptor: int) -> None:
        calls.append(descriptor)
        if len(calls) > 5:
            raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(BadArgument, match="No space left on device"):
        nk.export.urdf(nk.load_nao("v6"), tmp_path / "nao.urdf")
    assert os.listdir(tmp_path) == []


# Other robots.


def _same_robot(robot: nk.RobotModel, path: Path, **options: Any) -> None:
    read = nk.RobotModel.from_urdf(nk.export.urdf(robot, path, **options).path)
    assert read.joint_names == robot.joint_names
    assert read.mimics == robot.mimics
    q = np.where(np.isfinite(robot.upper), robot.upper, 1.0)
    np.testing.assert_allclose(read.fk(q, robot.link_names), robot.fk(q, robot.link_names), atol=1e-12)
    np.testing.assert_allclose(read.com(q), robot.com(q), atol=1e-12)
    np.testing.assert_array_equal(read.lower, robot.lower)
    # A URDF with a range must have a speed too: none is written as a large one, and said.
    speeds, again = (np.minimum(each.velocity_limits, 1e9) for each in (robot, read))
    np.testing.assert_array_equal(again, speeds)


def test_a_made_up_robot_comes_back_as_it_was(tmp_path: Path) -> None:
    robot = made_up(
        tmp_path,
        J("a", axis=(0.6, 0.0, 0.8), rpy=(0.1, 0.2, 0.3)),
        J("b", xyz=(0.1, 0.2, 0.3), kind="prismatic", limits=(0.0, 0.1)),
        J("c", kind="continuous"),
        J("d", rpy=(0.0, np.pi / 2, 0.0), kind="fixed"),
        J("e", axis=(0.0, 1.0, 0.0), follows=("a", -0.5, 0.25)),
        J("f", kind="continuous", follows=("a", 2.0, 0.0)),
    )
    _same_robot(robot, tmp_path / "again.urdf")
    tree = read_urdf(tmp_path / "again.urdf")
    assert dict(tree.inertials) == dict(robot.tree.inertials)
    # Which takes no `revolute` without limits, and no `continuous` that follows one.
    model = pin.buildModelFromUrdf(str(tmp_path / "again.urdf"), mimic=True)
    sizes = {model.names[j]: model.joints[j].nq for j in range(1, model.njoints)}
    assert sizes == {"a": 1, "b": 1, "c": 2, "e": 0, "f": 0}


def test_what_has_no_bound_is_written_as_a_large_one_and_said(tmp_path: Path) -> None:
    path = tmp_path / "r.urdf"
    path.write_text(
        '<robot name="r"><link name="a"/><link name="b"/><joint name="s" type="prismatic"><parent link="a"/>'
        '<child link="b"/></joint></robot>'
    )
    done = nk.export.urdf(nk.RobotModel.from_urdf(path), tmp_path / "out.urdf")
    assert done.changes == (
        "s slides without limits: written as ±1e+09",
        "s has no bound on velocity and effort: written as 1e+09",
    )
    pin.buildModelFromUrdf(str(done.path))


def test_a_locked_joint_is_fixed_at_the_value_nearest_to_zero(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("a", limits=(0.5, 1.0)), J("b", follows=("a", 2.0, 0.1)), J("c"))
    done = nk.export.urdf(robot, tmp_path / "locked.urdf", coupling="locked")
    assert done.changes == ("a is fixed at 0.5, together with its followers: b",)
    locked = nk.RobotModel.from_urdf(done.path)
    assert locked.joint_names == ("c",)
    np.testing.assert_allclose(locked.fk([0.3], "c_l"), robot.fk([0.5, 0.3], "c_l"), atol=1e-14)


@pytest.mark.skipif("romeo" not in nk.robot_names(), reason="example-robot-data is not installed")
@pytest.mark.parametrize("variant", [{}, {"frames": "none"}, {"inertia": "physical"}], ids=str)
def test_romeo_comes_back_as_it_was(variant: dict[str, str], tmp_path: Path) -> None:
    romeo = nk.load_robot("romeo")
    tree, _ = Variant(**variant).tree_of(romeo)
    robot = nk.RobotModel(tree)
    np.testing.assert_allclose(robot.com(romeo.neutral()), romeo.com(romeo.neutral()), atol=1e-12)
    assert robot.mass == pytest.approx(romeo.mass, abs=1e-12)
    _same_robot(robot, tmp_path / "romeo.urdf", meshes="none")
    assert pin.buildModelFromUrdf(str(tmp_path / "romeo.urdf")).nq > romeo.nq
