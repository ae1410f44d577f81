"""MJCF read as URDFs are: the same tree, whose poses, masses and couplings are MuJoCo's own."""

from __future__ import annotations

import os
import sys
import threading
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from mjcf_samples import BOX, SAMPLES, Mujoco, all_values, write

import nao_kin as nk
from nao_kin.errors import BadModel, MissingExtra, NaoKinError
from nao_kin.robot.semantics import Mimic
from nao_kin.robot.urdf.mjcf import read_mjcf

pytest.importorskip("mujoco", reason="MuJoCo reads MJCF")


def _load(folder: Path, inside: str, **options: object) -> nk.RobotModel:
    return nk.RobotModel.from_mjcf(write(folder, inside), **options)  # type: ignore[arg-type]


# --- poses, masses ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", SAMPLES)
def test_every_body_stands_where_mujoco_has_it(tmp_path: Path, name: str) -> None:
    robot = _load(tmp_path, SAMPLES[name])
    own = Mujoco(tmp_path / "robot.xml")
    for q in (robot.neutral(), *robot.random(1, 20)):
        values = all_values(robot, q)
        values |= {"D": 0.75} if name == "couplings" else {}  # held there
        own.set(values)
        expected = own.bodies()
        T_world_root = expected.get(robot.tree.root, np.eye(4))
        for body, T_world_body in expected.items():
            assert np.allclose(T_world_root @ robot.fk(q, body), T_world_body, rtol=0.0, atol=1e-12), body


@pytest.mark.parametrize("name", SAMPLES)
def test_masses_and_tensors_are_those_of_mujoco(tmp_path: Path, name: str) -> None:
    robot = _load(tmp_path, SAMPLES[name])
    own = Mujoco(tmp_path / "robot.xml")
    q = robot.random(2)
    own.set(all_values(robot, q) | ({"D": 0.75} if name == "couplings" else {}))
    assert robot.mass == pytest.approx(own.model.body_mass[1:].sum(), abs=1e-12)
    T_world_root = own.bodies().get(robot.tree.root, np.eye(4))
    centre = T_world_root[:3, :3] @ robot.com(q) + T_world_root[:3, 3]
    assert np.allclose(centre, own.data.subtree_com[0], rtol=0.0, atol=1e-9)


def test_the_mass_matrix_is_that_of_mujoco(tmp_path: Path) -> None:
    inertial = '<inertial pos=".01 .02 .03" mass="2" fullinertia=".03 .04 .05 .001 -.002 .003"/>'
    diagonal = '<inertial pos="0 .1 0" quat=".9 .2 -.1 .3" mass="1" diaginertia=".02 .03 .04"/>'
    robot = _load(
        tmp_path,
        f"""<worldbody><body name="base">{BOX}<body name="a" pos="0 0 .1"><joint name="A" axis="0 1 0"/>{inertial}
        <body name="b" pos=".2 0 0" euler=".3 .1 0"><joint name="B" axis="1 1 0" pos=".05 0 0"/>{diagonal}
        <body name="c" pos=".2 0 0"><joint name="C" type="slide" axis="0 0 1"/>
          <geom type="capsule" fromto="0 0 0 .1 .2 .3" size=".02"/></body></body></body></body></worldbody>""",
    )
    own = Mujoco(tmp_path / "robot.xml")
    q = robot.random(3)
    own.set(all_values(robot, q))
    expected = np.zeros((3, 3))
    for column in range(3):  # the same in every version of MuJoCo, whose accessor of the whole matrix changed
        unit, product = np.eye(3)[column], np.zeros(3)
        own.mujoco.mj_mulM(own.model, own.data, product, unit)
        expected[:, column] = product
    M = np.triu(pin.crba(robot.model, robot.model.createData(), q))
    assert np.allclose(M, np.triu(expected), rtol=0.0, atol=1e-9)


def test_a_free_joint_is_the_base(tmp_path: Path) -> None:
    robot = _load(tmp_path, SAMPLES["several joints in one body"], base="floating")
    assert "body 'pelvis' has a free joint: base='floating' gives it a free base" in robot.load_notes
    assert (robot.tree.root, robot.nv) == ("pelvis", 11)
    own = Mujoco(tmp_path / "robot.xml")
    rng = np.random.default_rng(5)
    q = robot.random(4)
    q[:3] = rng.normal(size=3)
    q[3:7] = rng.normal(size=4)
    q[3:7] /= np.linalg.norm(q[3:7])
    own.set(all_values(robot, q), base=np.r_[q[:3], q[6], q[3:6]])
    for body, T_world_body in own.bodies().items():
        assert np.allclose(robot.fk(q, body, reference="world"), T_world_body, rtol=0.0, atol=1e-12), body


# --- joints -------------------------------------------------------------------------------------------------------


def test_ranges_come_in_radians_whatever_the_file_is_in(tmp_path: Path) -> None:
    robot = _load(tmp_path, SAMPLES["degrees and classes"])
    limits = dict(zip(robot.joint_names, zip(robot.lower, robot.upper, strict=True), strict=True))
    assert np.allclose(np.degrees(limits["hip"]), (-90, 45))
    assert np.allclose(np.degrees(limits["elbow"]), (-20, 80))


def test_a_ball_joint_is_three_in_the_box_of_its_range(tmp_path: Path) -> None:
    robot = _load(tmp_path, SAMPLES["ball joints"])
    limits = dict(zip(robot.joint_names, zip(robot.lower, robot.upper, strict=True), strict=True))
    assert limits["shoulder_y"] == limits["shoulder_x"] == (-1.2, 1.2)
    assert limits["wrist_z"] == (-np.inf, np.inf)
    assert any("ball joint 'shoulder' made of three" in note and "its limit" in note for note in robot.load_notes)


def test_the_three_turns_of_a_ball_hold_every_turn_of_its_range() -> None:
    from nao_kin.rotations import euler_from_matrix, exp

    rng = np.random.default_rng(7)
    axes = rng.normal(size=(2000, 3))
    turns = exp(1.2 * axes / np.linalg.norm(axes, axis=1, keepdims=True))
    assert np.abs(euler_from_matrix(turns, "xyz", axes="moving").angles).max() <= 1.2 + 1e-12


def test_linear_equalities_are_couplings(tmp_path: Path) -> None:
    robot = _load(tmp_path, SAMPLES["couplings"])
    assert robot.joint_names == ("A",)
    # y − y₀ = a₀ + a₁ (x − x₀), with the references −0.2 and 0.1; C follows B, which follows A.
    assert robot.mimics["B"] == Mimic("A", -2.0, pytest.approx(-0.2 + 0.05 + 2.0 * 0.1))
    assert robot.mimics["C"] == Mimic("A", pytest.approx(-1.0), pytest.approx(0.5 * (robot.mimics["B"].offset + 0.2)))
    assert "joint 'D' is locked at 0.75: taken as fixed" in robot.load_notes


_TWO = f"""<worldbody><body name="base">{BOX}<body name="a"><joint name="A" axis="0 1 0"/>{BOX}</body>
  <body name="b"><joint name="B" axis="0 0 1"/>{BOX}</body></body></worldbody>"""


@pytest.mark.parametrize(
    ("equality", "note"),
    [
        ('<joint joint1="A" joint2="B" polycoef="0 1 .5 0 0"/>', "joint 'A' follows 'B' by a curve of degree 2"),
        ('<joint joint1="A" joint2="B" active="false"/>', "1 inactive"),
        ('<connect body1="a" body2="b" anchor="0 0 0"/>', "1 connect"),
        ('<weld body1="a" body2="b"/>', "1 weld"),
    ],
)
def test_constraints_that_no_tree_has_are_left_out_with_a_note(tmp_path: Path, equality: str, note: str) -> None:
    robot = _load(tmp_path, f"{_TWO}<equality>{equality}</equality>")
    assert robot.joint_names == ("A", "B")
    assert any(note in line for line in robot.load_notes)


def test_joints_coupled_both_ways_are_coupled_once(tmp_path: Path) -> None:
    both = '<equality><joint joint1="A" joint2="B"/><joint joint1="B" joint2="A"/></equality>'
    robot = _load(tmp_path, _TWO + both)
    assert len(robot.joint_names) == len(robot.mimics) == 1
    assert any("coupled to" in note and "by a second constraint" in note for note in robot.load_notes)


def test_a_joint_that_two_constraints_name_leads_the_second(tmp_path: Path) -> None:
    three = _TWO.replace("</body></worldbody>", f'<body name="c"><joint name="C"/>{BOX}</body></body></worldbody>')
    equality = '<equality><joint joint1="A" joint2="B" polycoef="0 2 0 0 0"/><joint joint1="A" joint2="C"/></equality>'
    robot = _load(tmp_path, three + equality)
    assert robot.joint_names == ("B",)
    assert robot.mimics == {"A": Mimic("B", 2.0), "C": Mimic("B", 2.0)}


# --- names, frames and what is the robot ----------------------------------------------------------------------------


def test_frames_of_one_name_are_told_apart(tmp_path: Path) -> None:
    robot = _load(
        tmp_path,
        f"""<worldbody><body name="base">{BOX}<body name="hip"><joint name="hip"/>{BOX}
        <site name="hip"/><site name="imu" pos="0 0 .1"/><camera name="imu"/></body></body></worldbody>""",
    )
    assert {"hip_link", "hip_site", "imu", "imu_camera"} <= set(robot.link_names)
    assert robot.tree.shared_names == {"hip": "hip_link"}
    assert any("1 sites are renamed …_site, because their names are taken: hip" in note for note in robot.load_notes)
    assert np.allclose(robot.position(robot.neutral(), "imu"), (0.0, 0.0, 0.1))


def test_what_has_no_name_gets_one(tmp_path: Path) -> None:
    robot = _load(tmp_path, f"<worldbody><body>{BOX}<body><joint/><joint axis='1 0 0'/>{BOX}</body></body></worldbody>")
    assert robot.tree.root == "body_1"
    assert set(robot.joint_names) == {"body_2_joint", "body_2_joint_2"}


def test_the_robot_is_what_moves_most_and_the_rest_is_named(tmp_path: Path) -> None:
    arm = f'<body name="arm">{BOX}<body name="hand"><joint name="J"/>{BOX}</body></body>'
    cube = f'<body name="cube"><freejoint/>{BOX}</body>'
    robot = _load(tmp_path, f'<worldbody>{cube}{arm}<body name="goal" mocap="true">{BOX}</body></worldbody>')
    assert (robot.tree.root, robot.joint_names) == ("arm", ("J",))
    assert any(note == "left out, not part of the robot: cube, goal" for note in robot.load_notes)


def test_a_camera_looks_along_x_with_z_up(tmp_path: Path) -> None:
    robot = _load(
        tmp_path,
        f"""<worldbody><body name="base" pos="1 2 3">{BOX}
          <camera name="eye" pos=".1 0 .2" euler=".5 -.4 .3" fovy="60" resolution="640 480"/>
          <camera name="still" pos="0 0 1"/><camera name="hunter" mode="targetbody" target="base"/>
        </body></worldbody>""",
    )
    assert robot.semantics.cameras == ("eye", "still")
    own = Mujoco(tmp_path / "robot.xml")
    own.set({})
    R = own.data.cam("eye").xmat.reshape(3, 3)
    pose = robot.fk(robot.neutral(), "eye")
    assert np.allclose(pose[:3, 0], -R[:, 2])
    assert np.allclose(pose[:3, 2], R[:, 1])
    assert np.allclose(pose[:3, 3] + (1, 2, 3), own.data.cam("eye").xpos)
    horizontal, vertical = robot.semantics.fields_of_view["eye"]
    assert np.degrees(vertical) == pytest.approx(60.0)
    assert np.tan(horizontal / 2) / np.tan(vertical / 2) == pytest.approx(640 / 480)
    assert "still" not in robot.semantics.fields_of_view  # without a resolution, nobody knows how wide it is
    assert "tracking cameras left out: 1" in robot.load_notes


def test_sensors_in_sites_are_known_by_their_frames(tmp_path: Path) -> None:
    robot = _load(
        tmp_path,
        f"""<worldbody><body name="base">{BOX}<site name="imu"/><site name="sole"/></body></worldbody>
        <sensor><accelerometer site="imu"/><gyro site="imu"/><touch site="sole"/></sensor>""",
    )
    meaning = robot.semantics
    assert (meaning.accelerometers, meaning.gyrometers, meaning.force_sensors) == (("imu",), ("imu",), ("sole",))


# --- keyframes ----------------------------------------------------------------------------------------------------


def test_named_keyframes_are_postures(tmp_path: Path) -> None:
    keys = """<keyframe><key name="home" qpos="0 0 1  1 0 0 0  .1 .2 .3 .4 .05"/>
      <key name="side" qpos="0 0 1  .70710678118654757 .70710678118654757 0 0  0 0 0 0 0"/>
      <key qpos="0 0 1 1 0 0 0 0 0 0 0 0"/></keyframe>"""
    robot = _load(tmp_path, SAMPLES["several joints in one body"] + keys)
    assert robot.posture_names == ("home", "side")
    assert robot.semantics.start == "home"
    assert robot.angles(robot.posture("home")) == {
        "hip_x": 0.1,
        "hip_z": 0.2,
        "hip_y": 0.3,
        "knee": 0.4,
        "stretch": 0.05,
    }
    assert robot.semantics.postures["home"].up is None
    assert np.allclose(robot.semantics.postures["side"].up, (0, 1, 0))
    assert "keyframes without a name left out: 1" in robot.load_notes


def test_a_ball_in_a_keyframe_turns_as_mujoco_has_it(tmp_path: Path) -> None:
    key = '<keyframe><key name="k" qpos=".5 .5 .5 .5 .02 .8 .6 0 0"/></keyframe>'
    robot = _load(tmp_path, SAMPLES["ball joints"] + key)
    own = Mujoco(tmp_path / "robot.xml")
    own.mujoco.mj_resetDataKeyframe(own.model, own.data, 0)
    own.mujoco.mj_fwdPosition(own.model, own.data)
    assert np.allclose(robot.fk(robot.posture("k"), "hand"), own.pose("body", "hand"), atol=1e-12)


def test_semantics_beside_the_file_fill_up_with_its_own(tmp_path: Path) -> None:
    path = write(tmp_path, f'{_TWO}<keyframe><key name="home" qpos=".1 .2"/></keyframe>')
    (tmp_path / "robot.toml").write_text('end_effectors = ["b"]\nstart = "home"\n')
    robot = nk.RobotModel.from_mjcf(path)
    assert (robot.semantics.end_effectors, robot.posture_names, robot.semantics.start) == (("b",), ("home",), "home")
    assert "chains, effectors and postures from robot.toml beside the MJCF" in robot.load_notes


# --- refusals -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<robot name='r'><link name='a'/></robot>", "it is a URDF, which RobotModel.from_urdf reads"),
        ("<sdf/>", "root element is <sdf>"),
        ("no xml", "not well-formed"),
        ("<mujoco><worldbody/></mujoco>", "no bodies"),
        ("<mujoco><worldbody><body></worldbody></mujoco>", "MuJoCo refuses it"),
        ('<mujoco><include file="gone.xml"/></mujoco>', "gone.xml"),
    ],
)
def test_what_makes_no_model_is_refused_in_one_line(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "robot.xml"
    path.write_text(text)
    with pytest.raises(BadModel, match=message) as caught:
        nk.RobotModel.from_mjcf(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_file_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BadModel, match=r"cannot read .*gone\.xml"):
        nk.RobotModel.from_mjcf(tmp_path / "gone.xml")


def test_the_handler_of_warnings_that_was_set_before_is_kept(tmp_path: Path) -> None:
    mujoco = pytest.importorskip("mujoco")
    heard: list[str] = []
    before, mine = mujoco.get_mju_user_warning(), heard.append
    mujoco.set_mju_user_warning(mine)
    try:
        _load(tmp_path, _TWO)
        assert mujoco.get_mju_user_warning() is mine
    finally:
        mujoco.set_mju_user_warning(before)


def test_without_mujoco_one_line_names_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(MissingExtra, match=r"reading MJCF needs .*nao-kin\[mujoco\]") as caught:
        _load(tmp_path, _TWO)
    assert "\n" not in str(caught.value)


def test_a_urdf_asked_for_as_mjcf_and_the_other_way_round_is_told(tmp_path: Path, nao: nk.NaoModel) -> None:
    with pytest.raises(BadModel, match="RobotModel.from_mjcf reads"):
        nk.RobotModel.from_urdf(write(tmp_path, _TWO))
    with pytest.raises(BadModel, match="RobotModel.from_urdf reads"):
        read_mjcf(nao.urdf_path)


# --- one door -----------------------------------------------------------------------------------------------------


def test_a_file_is_known_by_what_stands_in_it(tmp_path: Path, nao: nk.NaoModel) -> None:
    mjcf = write(tmp_path, _TWO, "robot.urdf")
    assert nk.RobotModel.from_file(mjcf).joint_names == ("A", "B")
    urdf = tmp_path / "nao.xml"
    urdf.write_bytes(nao.urdf_path.read_bytes())
    assert nk.RobotModel.from_file(urdf).nv == 25
    with pytest.raises(NaoKinError, match="takes arguments with xacro=True only"):
        nk.RobotModel.from_file(mjcf, xacro_arguments={"a": 1})


def test_an_mjcf_that_only_mujoco_forgives_is_left_to_it(tmp_path: Path) -> None:
    path = write(tmp_path, _TWO)
    path.write_text(path.read_text() + "\n</mujoco>")  # one end too many
    assert nk.RobotModel.from_file(path).joint_names == ("A", "B")


@pytest.mark.parametrize("name", ["couplings", "ball joints", "joints on the world"])
def test_the_cross_check_of_an_mjcf_is_against_mujoco(tmp_path: Path, name: str) -> None:
    report = nk.crosscheck.run(_load(tmp_path, SAMPLES[name]), 40)
    assert report.ok, report.failures
    assert {"MuJoCo"} <= {row.against for row in report.rows}
    assert "yourdfpy" not in {row.against for row in report.rows}


def test_the_cross_check_sees_a_wrong_tree(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("nao_kin.robot.urdf.mjcf.translation", lambda by: np.eye(4))  # anchors forgotten
    report = nk.crosscheck.run(_load(tmp_path, SAMPLES["several joints in one body"]), 20)
    assert any(row.against == "MuJoCo" for row in report.failures)


@pytest.mark.parametrize("name", ["robot.urdf", "robot.xml", "robot"])
def test_a_file_that_can_be_read_once_only_is_read(tmp_path: Path, name: str) -> None:
    text = '<robot name="r"><link name="a"/></robot>' if name == "robot.urdf" else f"<mujoco>{_TWO}</mujoco>"
    pipe = tmp_path / name
    os.mkfifo(pipe)
    writer = threading.Thread(target=pipe.write_text, args=(text,), daemon=True)
    writer.start()
    assert nk.RobotModel.from_file(pipe).nv == (0 if name == "robot.urdf" else 2)


def test_a_wide_ball_turns_less_about_its_middle_axis(tmp_path: Path) -> None:
    ball = f'<body name="arm"><joint name="s" type="ball" range="0 2" limited="true"/>{BOX}</body>'
    robot = _load(tmp_path, f'<worldbody><body name="base">{BOX}{ball}</body></worldbody>')
    limits = dict(zip(robot.joint_names, robot.upper.tolist(), strict=True))
    assert limits == {"s_x": np.inf, "s_y": np.pi / 2, "s_z": np.inf}
    assert robot.lower.tolist() == (-robot.upper).tolist()


@pytest.mark.parametrize(
    ("joint", "actuators", "effort"),
    [
        ("", '<motor joint="A" ctrlrange="-2 2"/><motor joint="A" ctrlrange="-1 3" gear="-2"/>', 8.0),
        ("", '<general joint="A" gainprm="5" ctrlrange="-2 1"/>', 10.0),
        ("", '<position joint="A" kp="5" ctrlrange="-1 1"/>', np.inf),
        ("", '<motor joint="A" ctrlrange="-2 2"/><motor joint="A"/>', np.inf),
        ('actuatorfrcrange="-7 6" actuatorfrclimited="true"', '<motor joint="A" ctrlrange="-9 2"/>', 7.0),
        ('actuatorfrcrange="-7 7" actuatorfrclimited="true"', '<motor joint="A" ctrlrange="-4 4"/>', 4.0),
    ],
)
def test_the_effort_of_a_joint_is_the_sum_of_its_actuators_within_its_own(
    tmp_path: Path, joint: str, actuators: str, effort: float
) -> None:
    text = f'{_TWO.replace("""name="A" """, f"""name="A" {joint} """)}<actuator>{actuators}</actuator>'
    assert _load(tmp_path, text).effort_limits.tolist() == [effort, np.inf]


def test_a_camera_with_a_sensor_and_a_lens_sees_what_they_let_it(tmp_path: Path) -> None:
    lens = 'sensorsize=".006 .004" focal=".003 .002" resolution="60 40"'
    robot = _load(tmp_path, f'<worldbody><body name="base">{BOX}<camera name="eye" {lens}/></body></worldbody>')
    assert robot.semantics.fields_of_view["eye"] == pytest.approx((np.pi / 2, np.pi / 2))


def test_a_base_that_stands_on_its_head_is_not_upright(tmp_path: Path) -> None:
    key = '<keyframe><key name="head" qpos="0 0 1  0 1 0 0  0 0 0 0 0"/></keyframe>'
    robot = _load(tmp_path, SAMPLES["several joints in one body"] + key)
    assert np.allclose(robot.semantics.postures["head"].up, (0, 0, -1))


def test_a_site_with_two_sensors_of_a_kind_is_named_once(tmp_path: Path) -> None:
    sensors = '<sensor><gyro site="imu"/><gyro site="imu" noise=".1"/></sensor>'
    robot = _load(tmp_path, f'<worldbody><body name="base">{BOX}<site name="imu"/></body></worldbody>{sensors}')
    assert robot.semantics.gyrometers == ("imu",)


def test_what_floats_without_joints_of_its_own_is_no_robot_beside_one(tmp_path: Path) -> None:
    parts = "".join(f'<body name="part{n}">{BOX}</body>' for n in range(3))
    arm = f'<body name="arm">{BOX}<body name="hand"><joint name="J"/>{BOX}</body></body>'
    robot = _load(tmp_path, f'<worldbody><body name="box"><freejoint/>{BOX}{parts}</body>{arm}</worldbody>')
    assert (robot.tree.root, robot.joint_names) == ("arm", ("J",))


def test_of_two_that_float_alike_the_first_is_the_robot(tmp_path: Path) -> None:
    bodies = "".join(f'<body name="{name}"><freejoint/>{BOX}</body>' for name in ("first", "second"))
    assert _load(tmp_path, f"<worldbody>{bodies}</worldbody>").tree.root == "first"


def test_what_moves_on_the_world_has_the_world_for_its_root(tmp_path: Path) -> None:
    robot = _load(tmp_path, f'<worldbody><body name="cart"><joint name="J" type="slide"/>{BOX}</body></worldbody>')
    assert (robot.tree.root, robot.link_names) == ("world", ("world", "cart"))


def test_a_robot_has_the_base_and_the_semantics_that_are_asked_for(tmp_path: Path) -> None:
    path = write(tmp_path, _TWO)
    meaning = nk.semantics.Semantics(end_effectors=("b",))
    for robot in (
        nk.RobotModel.from_mjcf(path, base="floating", semantics=meaning),
        nk.RobotModel.from_file(path, base="floating", semantics=meaning),
    ):
        assert (robot.base, robot.nq - robot.nv, robot.semantics.end_effectors) == ("floating", 1, ("b",))
