"""MJCF files as MuJoCo takes them and few people write them: attached models, held couplings, numbers that are none."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest
import trimesh
from mjcf_samples import BOX, Mujoco, write

import nao_kin as nk
from nao_kin.errors import BadModel
from nao_kin.robot.urdf import MeshFile, Sphere

mujoco = pytest.importorskip("mujoco", reason="MuJoCo reads MJCF")

THREE = f"""<worldbody><body name="base">{BOX}<body name="a"><joint name="A" axis="0 1 0" ref=".2"/>{BOX}</body>
  <body name="b" pos=".1 0 0"><joint name="B" axis="0 0 1" ref="-.1"/>{BOX}</body>
  <body name="c"><joint name="C"/>{BOX}</body></body></worldbody>"""


def _load(folder: Path, inside: str) -> nk.RobotModel:
    return nk.RobotModel.from_mjcf(write(folder, inside))


def _mesh(path: Path, size: float = 0.1) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    trimesh.creation.box((size, size, size)).export(path)
    return path


# --- attached models ------------------------------------------------------------------------------------------------


def _attach(folder: Path, *names: str) -> None:
    """A file that attaches models, each of which has a mesh of the same name in a folder of its own."""
    models = "".join(f'<model name="{name}" file="{name}/part.xml"/>' for name in names)
    bodies = "".join(f'<attach model="{name}" body="part" prefix="{name}_"/>' for name in names)
    write(folder, f'<asset>{models}</asset><worldbody><body name="base">{BOX}{bodies}</body></worldbody>')
    for name in names:
        (folder / name).mkdir()
        joint = '<joint name="J"/><geom type="mesh" mesh="m"/>'
        asset = '<compiler meshdir="shapes"/><asset><mesh name="m" file="m.stl"/></asset>'
        write(folder / name, f'{asset}<worldbody><body name="part">{joint}</body></worldbody>', "part.xml")


@pytest.mark.parametrize("names", [("hand", "arm"), ("arm", "arm_of")])  # and where one prefix begins the other
def test_meshes_of_attached_models_are_those_beside_them(tmp_path: Path, names: tuple[str, str]) -> None:
    _attach(tmp_path, *names)
    for name, size in zip(names, (0.1, 0.2), strict=True):
        _mesh(tmp_path / name / "shapes" / "m.stl", size)
    robot = nk.RobotModel.from_mjcf(tmp_path / "robot.xml")
    assert robot.mass == pytest.approx(Mujoco(tmp_path / "robot.xml").model.body_mass.sum())
    files = {
        shape.link: shape.geometry.filename for shape in robot.tree.visuals if isinstance(shape.geometry, MeshFile)
    }
    assert files == {f"{name}_part": f"{name}/shapes/m.stl" for name in names}
    assert not any("not there" in note for note in robot.load_notes)


def test_an_attached_model_loads_without_its_meshes(tmp_path: Path) -> None:
    _attach(tmp_path, "hand")
    robot = nk.RobotModel.from_mjcf(tmp_path / "robot.xml")
    assert robot.joint_names == ("hand_J",)
    assert "1 of 1 mesh files are missing, first 'm.stl'" in robot.load_notes


def test_a_model_attached_by_one_that_is_attached_has_its_meshes_too(tmp_path: Path) -> None:
    _attach(tmp_path, "hand")
    (tmp_path / "whole").mkdir()
    for name in ("hand", "robot.xml"):
        (tmp_path / name).rename(tmp_path / "whole" / name)
    mesh = _mesh(tmp_path / "whole" / "hand" / "shapes" / "m.stl")
    model = '<asset><model name="w" file="whole/robot.xml"/></asset>'
    attach = f'<worldbody><body name="world_base">{BOX}<attach model="w" body="base" prefix="w_"/></body></worldbody>'
    robot = _load(tmp_path, model + attach)
    found = [shape.geometry.filename for shape in robot.tree.visuals if isinstance(shape.geometry, MeshFile)]
    assert [tmp_path / name for name in found] == [mesh]


def test_paths_of_meshes_are_stripped_where_the_file_says_so(tmp_path: Path) -> None:
    _mesh(tmp_path / "shapes" / "m.stl")
    _mesh(tmp_path / "shapes" / "else" / "m.stl", 0.2)
    robot = _load(
        tmp_path,
        """<compiler strippath="true" meshdir="shapes"/><asset><mesh name="m" file="else/m.stl"/></asset>
        <worldbody><body name="a"><joint name="J"/><geom type="mesh" mesh="m"/></body></worldbody>""",
    )
    assert robot.mass == pytest.approx(Mujoco(tmp_path / "robot.xml").model.body_mass.sum())
    assert [shape.geometry.filename for shape in robot.tree.visuals] == ["shapes/m.stl"]


# --- shapes that are not known --------------------------------------------------------------------------------------


def test_what_has_lost_its_shape_is_not_shown_as_another(tmp_path: Path) -> None:
    robot = _load(
        tmp_path,
        """<asset><hfield name="h" nrow="2" ncol="2" size="1 1 1 1"/><mesh name="m" file="gone.stl"/></asset>
        <worldbody><body name="a"><geom type="sphere" size=".2"/><geom type="hfield" hfield="h"/>
          <body name="b"><joint name="J"/><geom type="box" mesh="m"/></body></body></worldbody>""",
    )
    assert [shape.geometry for shape in robot.tree.visuals] == [Sphere(0.2)]
    assert [shape.geometry for shape in robot.tree.collisions] == [Sphere(0.2)]
    assert {"height fields left out: 1", "1 of 1 mesh files are missing, first 'gone.stl'"} <= {*robot.load_notes}


# --- names, couplings -----------------------------------------------------------------------------------------------


def test_the_parts_of_a_ball_take_no_name_of_another_joint(tmp_path: Path) -> None:
    ball = '<joint name="s" type="ball"/>'
    robot = _load(
        tmp_path,
        f"""<worldbody><body name="base">{BOX}<body name="a" pos="0 0 .1">{ball}{BOX}
        <body name="b" pos=".1 0 0"><joint name="s_x" axis="0 1 0"/>{BOX}</body></body></body></worldbody>""",
    )
    assert sorted(robot.joint_names) == ["s_x", "s_x_ball", "s_y", "s_z"]
    q = robot.configuration({"s_x": 0.4})
    own = Mujoco(tmp_path / "robot.xml")
    own.set({"s_x": 0.4, "s_y": 0.0, "s_z": 0.0} | {"s_x": 0.4})
    own.data.qpos[:] = (1, 0, 0, 0, 0.4)
    own.mujoco.mj_fwdPosition(own.model, own.data)
    assert np.allclose(own.pose("body", "base") @ robot.fk(q, "b"), own.pose("body", "b"), atol=1e-12)
    report = nk.crosscheck.run(robot, 10)
    assert report.ok, report.failures


@pytest.mark.parametrize(
    ("equalities", "held"),
    [
        # y − y₀ = a₀ + a₁ (x − x₀), with the references 0.2 of A and −0.1 of B.
        (('joint1="B" polycoef=".3 0 0 0 0"', 'joint1="A" joint2="B" polycoef=".1 2 0 0 0"'), {"A": 0.9, "B": 0.2}),
        (('joint1="A" polycoef=".3 0 0 0 0"', 'joint1="A" joint2="B" polycoef=".1 2 0 0 0"'), {"A": 0.5, "B": 0.0}),
        (('joint1="A" joint2="C" polycoef=".3 0 0 0 0"',), {"A": 0.5}),
    ],
)
def test_a_joint_coupled_to_one_that_is_held_is_held_too(
    tmp_path: Path, equalities: tuple[str, ...], held: dict[str, float]
) -> None:
    robot = _load(tmp_path, f"{THREE}<equality>{''.join(f'<joint {line}/>' for line in equalities)}</equality>")
    assert set(robot.joint_names) == {"A", "B", "C"} - held.keys()
    own = Mujoco(tmp_path / "robot.xml")
    own.set(held)
    for body in ("a", "b"):
        if body.upper() in held:
            assert np.allclose(robot.fk(robot.neutral(), body), own.pose("body", body), atol=1e-12), body
    report = nk.crosscheck.run(robot, 10)
    assert report.ok, report.failures


def test_a_coupling_to_what_is_not_the_robots_is_noted(tmp_path: Path) -> None:
    other = f'<body name="x"><freejoint/>{BOX}<body name="y"><joint name="K"/>{BOX}</body></body></worldbody>'
    equality = '<equality><joint joint1="A" joint2="K"/></equality>'
    robot = _load(tmp_path, THREE.replace("</worldbody>", other) + equality)
    assert "joint 'A' is coupled to a joint outside the robot: left out" in robot.load_notes
    assert set(robot.joint_names) == {"A", "B", "C"}


# --- numbers ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("inside", "message"),
    [
        (f'<body name="a" pos="nan 0 0">{BOX}</body>', "the pos of body 'a' is not finite"),
        (f'<body name="a">{BOX}<site name="s" pos="0 nan 0"/></body>', "the pos of site 's' is not finite"),
        (
            f'<body name="a">{BOX}<body name="b"><joint name="J" pos="0 0 nan"/>{BOX}</body></body>',
            "the pos of joint 'J' is not finite|Nan, Inf or huge value",  # MuJoCo 3.3 notices it, and names nothing
        ),
    ],
)
def test_numbers_that_are_none_are_refused_by_name(
    tmp_path: Path, inside: str, message: str, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(BadModel, match=message) as caught:
        _load(tmp_path, f"<worldbody>{inside}</worldbody>")
    assert str(caught.value).startswith(str(tmp_path))
    assert capfd.readouterr() == ("", "")
    assert [path.name for path in tmp_path.iterdir()] == ["robot.xml"]  # and no MUJOCO_LOG.TXT


def test_a_range_beyond_all_measure_is_none(tmp_path: Path) -> None:
    body = f'<body name="b"><joint name="J" type="slide" range="-1e308 1e308"/>{BOX}</body>'
    robot = _load(tmp_path, f'<worldbody><body name="a">{BOX}{body}</body></worldbody>')
    assert (robot.lower[0], robot.upper[0]) == (-np.inf, np.inf)
    assert np.isfinite(robot.random(0, 5)).all()


# --- what MuJoCo warns of -------------------------------------------------------------------------------------------


def test_what_mujoco_warns_of_is_a_note_and_nothing_else(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    before = mujoco.get_mju_user_warning()
    path = write(tmp_path, f'<worldbody><body name="a">{BOX}<site name="s" size="nan"/></body></worldbody>')
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        robot = nk.RobotModel.from_mjcf(path)
        assert nk.crosscheck.run(robot, 3).ok
    assert "MuJoCo says: XML contains a 'NaN'. Please check it carefully." in robot.load_notes
    assert capfd.readouterr() == ("", "")
    assert not list(Path().iterdir())
    assert mujoco.get_mju_user_warning() is before


def test_a_root_that_is_turned_is_said_to_be(tmp_path: Path) -> None:
    robot = _load(tmp_path, f'<worldbody><body name="a" euler="0 0 1">{BOX}</body></worldbody>')
    assert robot.load_notes == ("'a' is at 0 0 0, turned, in the world; poses are relative to its frame",)


# --- one name for two things -----------------------------------------------------------------------------------------


def test_a_camera_is_in_a_site_of_its_name_only_on_the_same_body(tmp_path: Path) -> None:
    site, camera = '<site name="eye"/>', '<camera name="eye" euler="1.5707963267948966 -1.5707963267948966 0"/>'
    two = f"""<worldbody><body name="a">{BOX}{site}
      <body name="b" pos="0 0 1"><joint name="J"/>{BOX}{camera}</body></body></worldbody>"""
    robot = _load(tmp_path, two)
    assert robot.semantics.cameras == ("eye_camera",)
    assert robot.position(robot.neutral(), "eye_camera").tolist() == [0.0, 0.0, 1.0]
    same = _load(tmp_path, two.replace(camera, "").replace(site, site + camera))
    assert same.semantics.cameras == ("eye",)
    assert np.allclose(same.rotation(same.neutral(), "eye"), np.eye(3))


def test_a_body_and_a_joint_beside_its_origin_may_have_one_name(tmp_path: Path) -> None:
    hip = f'<body name="hip"><joint name="hip" pos=".1 0 0" axis="0 1 0"/>{BOX}</body>'
    robot = _load(tmp_path, f'<worldbody><body name="base">{BOX}{hip}</body></worldbody>')
    assert len({*robot.link_names}) == len(robot.link_names) == 3
    own = Mujoco(tmp_path / "robot.xml")
    own.set({"hip": 0.5})
    q = robot.configuration({"hip": 0.5})
    assert np.allclose(robot.fk(q, robot.tree.shared_names["hip"]), own.pose("body", "hip"), atol=1e-12)


def test_damping_friction_and_the_name_of_the_model_are_kept(tmp_path: Path) -> None:
    joint = '<joint name="J" damping=".3" frictionloss=".2"/>'
    robot = _load(tmp_path, f'<worldbody><body name="a">{BOX}<body name="b">{joint}{BOX}</body></body></worldbody>')
    assert [(row.damping, row.friction) for row in robot.tree.moving_joints] == [(0.3, 0.2)]
    assert robot.name == "sample"
    (tmp_path / "nameless.xml").write_text(f'<mujoco><worldbody><body name="a">{BOX}</body></worldbody></mujoco>')
    assert nk.RobotModel.from_mjcf(tmp_path / "nameless.xml").name == "nameless"
