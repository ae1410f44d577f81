from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
import pytest

import nao_kin as nk
from nao_kin.errors import MissingExtra, NotFinite, UnknownName, WrongShape
from nao_kin.joints import JointAxes
from nao_kin.screws import lines
from nao_kin.screws.lines import PluckerLine

assert_near = partial(np.testing.assert_allclose, rtol=0)  # its own default lets a relative 1e-7 pass
NAO = nk.load_nao()
AXES = JointAxes(NAO)

SLIDER = """<robot name="slider"><link name="base"/><link name="cart"/><link name="hook"/><link name="side"/>
<joint name="rail" type="prismatic"><parent link="base"/><child link="cart"/><origin xyz="1 2 3" rpy="0.1 0.2 0.3"/>
 <axis xyz="3 0 4"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
<joint name="swing" type="continuous"><parent link="cart"/><child link="hook"/><origin xyz="0 0 -1"/>
 <axis xyz="0 2 0"/></joint>
<joint name="gear" type="revolute"><parent link="base"/><child link="side"/><axis xyz="1 0 0"/>
 <limit lower="-9" upper="9" effort="1" velocity="1"/><mimic joint="rail" multiplier="-2.5" offset="0.1"/></joint>
</robot>"""


def configurations(robot: nk.RobotModel, shape: tuple[int, ...] = (4,)) -> np.ndarray:
    """Return random configurations inside the limits, and zero, which is outside NAO's limits."""
    q = robot.random(np.random.default_rng(1), shape)
    if shape == (4,):
        q[0] = robot.neutral()
    return q


@pytest.mark.parametrize("expressed_in", ["frame", "root", "mixed"])
def test_all_25_columns_are_plucker_coordinates_at_every_frame(expressed_in) -> None:
    q = configurations(NAO)
    seen = np.zeros(25, dtype=bool)
    for frame in NAO.frame_names:
        expected = NAO.jacobian(q, frame, expressed_in)
        assert expected.shape == (4, 6, 25)
        assert_near(AXES.jacobian(q, frame, expressed_in), expected, atol=5e-15, err_msg=frame)
        seen |= np.abs(expected).max(axis=(0, 1)) > 0
    assert seen.all()


@pytest.mark.parametrize("side", ["L", "R"])
def test_the_coupled_column_is_the_axis_of_the_hip_on_the_side_of_the_foot(side) -> None:
    q = configurations(NAO)
    column = NAO.joint_names.index("LHipYawPitch")
    line = AXES.lines(q)[:, AXES.names.index(f"{side}HipYawPitch")]
    J = NAO.jacobian(q, f"{side}AnkleRoll", "root")[..., column]
    assert_near(J, np.concatenate([line.moment, line.direction], axis=-1), atol=5e-15)
    sign = {"L": 1, "R": -1}[side]
    assert_near(line.direction, np.tile([0, 1, -sign], (4, 1)) / np.sqrt(2), atol=1e-15)
    assert line.distance_to([0, 0.05 * sign, -0.085]).max() <= 1e-15


def test_the_axes_of_the_hip_and_of_the_head_meet_at_right_angles() -> None:
    lines_of = dict(zip(AXES.names, AXES.lines(NAO.neutral()), strict=True))
    for a, b in [("HeadYaw", "HeadPitch"), ("LHipYawPitch", "LHipRoll"), ("RHipRoll", "RHipPitch")]:
        assert lines.distance(lines_of[a], lines_of[b]) <= 1e-15
        assert_near(lines.common_normal(lines_of[a], lines_of[b]).angle, np.pi / 2, atol=1e-15)
    normal = lines.common_normal(lines_of["LKneePitch"], lines_of["LAnklePitch"])
    assert normal.parallel
    assert_near(normal.distance, 0.1029, atol=1e-15)


@pytest.mark.parametrize("robot", ["romeo", "talos_full_v2", "panda"])
def test_other_robots_sliding_grippers_included(robot) -> None:
    try:
        model = nk.load_robot(robot)
    except MissingExtra:
        pytest.skip("example-robot-data is not installed")
    axes, q = JointAxes(model), configurations(model)
    for frame in model.frame_names[:: max(1, len(model.frame_names) // 25)]:
        for expressed_in in ("frame", "root", "mixed"):
            expected = model.jacobian(q, frame, expressed_in)
            assert_near(axes.jacobian(q, frame, expressed_in), expected, atol=2e-14, err_msg=frame)


def test_a_sliding_joint_with_a_coupled_one(tmp_path: Path) -> None:
    path = tmp_path / "slider.urdf"
    path.write_text(SLIDER, encoding="utf-8")
    robot = nk.RobotModel.from_urdf(path)
    axes = JointAxes(robot)
    assert dict(zip(axes.names, axes.sliding.tolist(), strict=True)) == {"rail": True, "swing": False, "gear": False}
    q = configurations(robot)
    for frame in robot.frame_names:
        for expressed_in in ("frame", "root", "mixed"):
            expected = robot.jacobian(q, frame, expressed_in)
            assert_near(axes.jacobian(q, frame, expressed_in), expected, atol=5e-15, err_msg=frame)
    assert axes.coupling("side").tolist()[axes.names.index("gear")] == [-2.5, 0.0]
    assert not axes.coupling("base").any()


def test_a_floating_base_leaves_the_columns_of_the_joints() -> None:
    floating = nk.load_nao(base="floating")
    q = configurations(floating)
    q[:, :3] = [1, 2, 3]
    q[:, 3:7] = [0.5, 0.5, -0.5, 0.5]
    axes = JointAxes(floating)
    for expressed_in in ("frame", "root", "mixed"):
        expected = floating.jacobian(q, "RAnkleRoll", expressed_in)[..., 6:]
        assert_near(axes.jacobian(q, "RAnkleRoll", expressed_in), expected, atol=1e-14)


def test_the_lines_are_plucker_lines_about_the_root() -> None:
    line = AXES.lines(NAO.neutral())
    assert isinstance(line, PluckerLine)
    np.testing.assert_array_equal(line.origin, 0)


def test_bad_input_is_refused_with_the_librarys_own_error() -> None:
    with pytest.raises(UnknownName, match="LFoot"):
        AXES.jacobian(NAO.neutral(), "LFot")
    with pytest.raises(UnknownName, match="mixed"):
        AXES.jacobian(NAO.neutral(), "LFoot", "local")  # type: ignore[arg-type]
    with pytest.raises(UnknownName):
        AXES.coupling("nowhere")
    with pytest.raises(WrongShape):
        AXES.lines(np.zeros(26))
    with pytest.raises(NotFinite):
        AXES.lines(np.full(25, np.nan))
