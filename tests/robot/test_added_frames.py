"""Frames that `with_frame` adds, such as a tool in the hand, in everything that is made of a robot; columns of q."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import nao_kin as nk
from nao_kin.cli.app import run
from nao_kin.errors import BadArgument, NaoKinWarning, UnknownName, WrongShape
from nao_kin.rotations import matrix_from_rpy
from nao_kin.viewer.description import SceneRobot

T_HAND_PEN = nk.screws.pose(matrix_from_rpy([0.2, 0.4, -0.7]), [0.08, 0.01, 0.02])


@pytest.fixture(scope="module")
def writer(nao: nk.NaoModel) -> nk.NaoModel:
    return nao.with_frame("Pen", "LArm", T_HAND_PEN)


def test_an_added_frame_is_where_pinocchio_adds_it(nao: nk.NaoModel, writer: nk.NaoModel) -> None:
    model = nao.model.copy()
    hand = model.frames[nao.frame_table["LArm"]]
    T_joint_pen = hand.placement * pin.SE3(T_HAND_PEN)
    pen = model.addFrame(pin.Frame("Pen", hand.parentJoint, T_joint_pen, pin.FrameType.OP_FRAME))
    data, qs = model.createData(), nao.random(1, 40)
    for q, T in zip(qs, writer.fk(qs, "Pen"), strict=True):
        pin.framesForwardKinematics(model, data, q)
        assert np.abs(T - data.oMf[pen].homogeneous).max() < 1e-14
    J = pin.computeFrameJacobian(model, data, qs[0], pen, pin.LOCAL)
    assert np.abs(writer.jacobian(qs[0], "Pen", "frame") - J).max() < 1e-14
    assert (
        np.abs(writer.fk(nao.random(2, 1000), "Pen") - nao.fk(nao.random(2, 1000), "LArm") @ T_HAND_PEN).max() < 1e-13
    )
    assert writer.link_names == (*nao.link_names, "Pen")
    assert writer.load_notes == ("frame Pen: added, (80, 10, 20) mm and 49.2° from LArm",)


def test_limbs_are_solved_for_an_added_frame(nao: nk.NaoModel, writer: nk.NaoModel) -> None:
    q = nao.random(3, 20)
    targets = writer.fk(q, "Pen")
    for found in (
        nk.ik.arm(writer, "L", targets, frame="Pen"),
        nk.ik.analytic(writer, "Pen", targets),
        nk.ik.numeric(writer, "Pen", targets[:3]),
    ):
        assert found.success.all()
        assert np.abs(writer.fk(found.q, "Pen") - targets[: len(found.q)]).max() < 1e-7
    places = nk.ik.arm(writer, "L", targets[..., :3, 3], frame="Pen")
    assert np.abs(writer.position(places.q, "Pen") - targets[..., :3, 3]).max() < 1e-9
    shod = nao.with_frame("Skate", "r_sole", (0.05, 0.0, -0.03, 0.0, 0.1, 0.0))
    below = shod.fk(q, "Skate")
    assert np.abs(shod.fk(nk.ik.leg(shod, "R", below, frame="Skate").q, "Skate") - below).max() < 1e-9


def test_copies_and_files_have_an_added_frame(writer: nk.NaoModel, tmp_path: Path) -> None:
    q = writer.random(4, 5)
    T = writer.fk(q, "Pen")
    assert np.array_equal(pickle.loads(pickle.dumps(writer)).fk(q, "Pen"), T)
    urdf = nk.export.urdf(writer, tmp_path / "nao.urdf", meshes="none", frames="effectors").path
    assert np.abs(nk.RobotModel.from_urdf(urdf).fk(q, "Pen") - T).max() < 1e-12
    assert writer.semantics.end_effectors[-1] == "Pen"


@pytest.mark.full
def test_simulators_pages_and_the_cross_check_know_an_added_frame(writer: nk.NaoModel, tmp_path: Path) -> None:
    q = writer.random(4, 5)
    assert '<frame name="Pen"' in (nk.export.sdf(writer, tmp_path / "sdf").path).read_text()
    mjcf = nk.RobotModel.from_mjcf(nk.export.mjcf(writer, tmp_path / "mjcf", meshes="none").path)
    there = mjcf.configuration(writer.angles(q), ignore_other=True)
    T_hand_pen = mjcf.fk(there, "Pen", reference="LArm")
    assert np.abs(T_hand_pen - T_HAND_PEN).max() < 1e-6
    assert nk.crosscheck.run(writer, 20).ok
    about = SceneRobot(writer).about()
    assert "Pen" in about["effectors"]
    assert "Pen" in {frame["name"] for frame in about["frames"]}


def test_offsets_and_the_file_of_a_robot_know_an_added_frame(
    nao: nk.NaoModel, writer: nk.NaoModel, tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    q, bent = nao.random(5, 4), (0.0, 0.0, 0.01, 0.0, 0.0, 0.0)
    moved = nao.with_offsets({"LElbowYaw": 0.01}, {"Pen": bent}, added_frames={"Pen": ("LArm", T_HAND_PEN)})
    assert np.array_equal(moved.fk(q), writer.with_offsets({"LElbowYaw": 0.01}, {"Pen": bent}).fk(q))
    hand = nao.with_offsets({"LElbowYaw": 0.01}).fk(q, "LArm")
    expected = hand @ T_HAND_PEN @ nk.screws.pose(np.eye(3), bent[:3])
    assert np.abs(moved.fk(q, "Pen") - expected).max() < 1e-14
    tables = {"joints": {"LElbowYaw": 0.01}, "frames": {"Pen": bent}, "added_frames": {"Pen": ("LArm", T_HAND_PEN)}}
    path = nk.robot.write_offsets(tmp_path / "mine.toml", tables)
    assert np.abs(nk.load_nao(offsets=path).fk(q, "Pen") - expected).max() < 1e-14
    assert run(["fk", "--offsets", str(path), "--frame", "Pen", "--json"]) == 0
    assert '"Pen"' in capsys.readouterr().out
    path.write_text('[added_frames]\nPen = ["LArm", 0.08, 0.0, 0.02, 0.0, 0.0, 0.1]\n')
    six = nao.with_frame("Pen", "LArm", [0.08, 0.0, 0.02, 0.0, 0.0, 0.1])
    assert np.array_equal(nk.load_nao(offsets=path).fk(q, "Pen"), six.fk(q, "Pen"))
    path.write_text('[added_frames]\nPen = ["LArm", 0.08, 0.0]\n')
    assert run(["fk", "--offsets", str(path)]) == 2
    assert "the pose of Pen must have shape (6,) or (4, 4)" in capsys.readouterr().err


def test_a_frame_under_a_foot_carries_nothing(nao: nk.NaoModel) -> None:
    shod = nao.with_frame("Toe", "LLeg", (0.3, 0.0, 0.0, 0.0, 0.0, 0.0))
    assert np.array_equal(shod.sole_outline("LLeg", "sensors"), nao.sole_outline("LLeg", "sensors"))


@pytest.mark.parametrize(
    ("name", "parent", "T", "error", "says"),
    [
        ("LArm", "RArm", T_HAND_PEN, BadArgument, "new frame 'LArm': the name is blank, or in use"),
        ("HeadYaw", "Head", T_HAND_PEN, BadArgument, "in use"),
        (" ", "Head", T_HAND_PEN, BadArgument, "blank"),
        ("Pen", "LArn", T_HAND_PEN, UnknownName, "unknown frame 'LArn' .nearest: LArm"),
        ("Pen", "LArm", 2.0 * T_HAND_PEN, BadArgument, "the pose of Pen: not a rotation"),
        ("Pen", "LArm", T_HAND_PEN[:3], WrongShape, "the pose of Pen must have shape"),
    ],
)
def test_a_frame_that_cannot_be_added_is_named(
    nao: nk.NaoModel, name: str, parent: str, T: object, error: type, says: str
) -> None:
    with pytest.raises(error, match=says):
        nao.with_frame(name, parent, T)


def test_millimetres_are_doubted(nao: nk.NaoModel) -> None:
    with pytest.warns(NaoKinWarning, match="Pen is 80 m from LArm; poses are in metres"):
        nao.with_frame("Pen", "LArm", (80.0, 0.0, 0.0, 0.0, 0.0, 0.0))


def test_columns_are_those_of_joints_chains_and_frames() -> None:
    nao = nk.load_nao(base="floating")
    base = nao.nq - len(nao.joint_names)
    for name, joints in {**nao.chains, "HeadPitch": ["HeadPitch"], "CameraTop": ["HeadYaw", "HeadPitch"]}.items():
        drivers = [nao.mimics[joint].joint if joint in nao.mimics else joint for joint in joints]
        assert nao.columns(name).tolist() == [base + nao.joint_names.index(joint) for joint in drivers]
    assert not nao.columns("Torso").size
    moved = np.flatnonzero(nao.jacobian(nao.random(0), "RArm", reference="Torso").any(axis=0))
    assert nao.columns("r_gripper").tolist() == (moved + nao.nq - nao.nv).tolist()
    with pytest.raises(UnknownName, match="unknown joint, chain or frame 'LArn' .nearest: LArm"):
        nao.columns("LArn")
