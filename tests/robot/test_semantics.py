"""The semantics of a robot, which its URDF does not hold: from Python, a TOML file or an SRDF, for any robot."""

from __future__ import annotations

import copy
import math
import pickle
import re
from pathlib import Path

import numpy as np
import pytest
from made_up_robots import J, made_up

import nao_kin as nk
from nao_kin.errors import BadInputFile, BadModel, NaoKinError, NotFinite, OutsideLimits, UnknownName
from nao_kin.robot.nao.tables import REST
from nao_kin.robot.semantics import CoupledLimit, Mimic, Posture, Semantics, View, read_semantics

TOML = """
end_effectors = ["tip_l", "c"]
soles = ["base"]
cameras = ["b_l"]
start = "bent"
root = "the base"

[chains]
arm = ["a", "b", "c"]

[postures.bent]
angles = { a = 0.5, c = -0.25 }

[postures.down]
angles = {}
up = [0, 0, -1]

[[coupled_limits]]
joint = "b"
of = "a"
at = [-1.0, 0.0, 1]
lower = [-0.5, -1.0, -0.5]
upper = [0.5, 1.0, 0.5]

[units]
c = "1"

[stall_torques]
a = 7.5

[views.close]
direction = [1, 0.5, 0]
joints = ["c"]
"""


def _robot(folder: Path, semantics: object = None) -> nk.RobotModel:
    robot = made_up(folder, J("a"), J("b"), J("c"), J("tip", kind="fixed"))
    return nk.RobotModel.from_urdf(robot.urdf_path, semantics=semantics)  # type: ignore[arg-type]


@pytest.fixture
def toml(tmp_path: Path) -> Path:
    path = tmp_path / "meaning.toml"
    path.write_text(TOML, encoding="utf-8")
    return path


def test_a_toml_file_says_what_python_says(toml: Path) -> None:
    assert read_semantics(toml) == Semantics(
        chains={"arm": ("a", "b", "c")},
        end_effectors=("tip_l", "c"),
        soles=("base",),
        cameras=("b_l",),
        postures={"bent": Posture({"a": 0.5, "c": -0.25}), "down": Posture({}, (0.0, 0.0, -1.0))},
        start="bent",
        coupled_limits=(CoupledLimit("b", "a", (-1.0, 0.0, 1.0), (-0.5, -1.0, -0.5), (0.5, 1.0, 0.5)),),
        units={"c": "1"},
        stall_torques={"a": 7.5},
        views={"close": View((1.0, 0.5, 0.0), ("c",))},
        root="the base",
    )


def test_any_robot_has_the_postures_limits_and_units_of_its_semantics(tmp_path: Path, toml: Path) -> None:
    robot = _robot(tmp_path, toml)
    assert robot.posture_names == ("bent", "down")
    assert robot.posture("bent").tolist() == [0.5, 0.0, -0.25]
    assert robot.chains == {"arm": ("a", "b", "c")}
    assert robot.joint_units == ("rad", "rad", "1")
    assert robot.unit("c") == "1"
    (violation,) = robot.limit_violations([1.0, 0.75, 0.0])
    assert (violation.joint, violation.of, violation.upper) == ("b", "a", 0.5)
    assert robot.clamp([1.0, 0.75, 0.0]).tolist() == [1.0, 0.5, 0.0]
    with pytest.raises(OutsideLimits):
        robot.configuration({"a": 1.0, "b": 0.75})
    with pytest.raises(UnknownName, match=r"unknown posture 'bend' \(nearest: bent\)"):
        robot.posture("bend")
    robot.posture("bent")[0] = 9.0
    assert robot.posture("bent")[0] == 0.5


def test_a_robot_without_semantics_has_none(tmp_path: Path) -> None:
    robot = _robot(tmp_path)
    assert (robot.posture_names, robot.chains, robot.coupled_limits) == ((), {}, ())
    with pytest.raises(UnknownName, match=r"unknown posture 'Stand' \(there are none\)"):
        robot.posture("Stand")


def test_the_file_beside_the_urdf_is_found_and_noted(tmp_path: Path) -> None:
    (tmp_path / "robot.toml").write_text(TOML, encoding="utf-8")
    robot = _robot(tmp_path)
    assert robot.posture_names == ("bent", "down")
    assert robot.load_notes == ("chains, effectors and postures from robot.toml beside the URDF",)


@pytest.mark.parametrize(
    ("text", "reason"),
    [("[tool.ruff]\n", "unknown entry 'tool'"), ('soles = ["nowhere"]', "soles names the frame 'nowhere'")],
)
def test_a_file_beside_the_urdf_that_does_not_fit_keeps_no_robot_from_loading(
    tmp_path: Path, text: str, reason: str
) -> None:
    (tmp_path / "robot.toml").write_text(text, encoding="utf-8")
    robot = _robot(tmp_path)
    assert robot.semantics == Semantics()
    (note,) = robot.load_notes
    assert note.startswith("robot.toml beside the URDF is not used: ")
    assert reason in note


@pytest.mark.parametrize(
    ("semantics", "message"),
    [
        (
            Semantics(chains={"arm": ("a", "bb")}),
            r"chain 'arm' names the joint 'bb', which does not exist \(nearest: b",
        ),
        (Semantics(end_effectors=("tipp_l",)), r"end_effectors names the frame 'tipp_l', .*nearest: tip_l"),
        (Semantics(postures={"p": Posture({"tip": 1.0})}), "posture 'p' names the joint 'tip'"),
        (Semantics(start="p"), "start names the posture 'p'"),
        (Semantics(units={"x": "m"}), "the units names the joint 'x'"),
        (Semantics(views={"v": View((1.0, 0.0, 0.0), ("x",))}), "view 'v' names the joint 'x'"),
    ],
)
def test_semantics_that_name_what_is_not_there_are_refused(tmp_path: Path, semantics: Semantics, message: str) -> None:
    with pytest.raises(BadModel, match=message):
        _robot(tmp_path, semantics)


def test_a_table_may_not_bind_a_joint_that_follows(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("a"), J("b", follows=("a", 2.0, 0.0)))
    table = CoupledLimit("b", "a", (0.0,), (0.0,), (1.0,))
    with pytest.raises(BadModel, match="a coupled limit names 'b', which follows another joint"):
        nk.RobotModel.from_urdf(robot.urdf_path, semantics=Semantics(coupled_limits=(table,)))


@pytest.mark.parametrize(
    ("make", "word"),
    [
        (lambda: Semantics(end_effectors="tool"), "end_effectors"),
        (lambda: Semantics(cameras=(3,)), "cameras"),
        (lambda: Semantics(chains={"arm": "a"}), "arm"),
        (lambda: Semantics(postures={"p": {"a": 1.0}}), "Posture"),
        (lambda: Semantics(units={"a": "deg"}), "'deg'"),
        (lambda: CoupledLimit("a", "a", (0.0,), (0.0,), (1.0,)), "itself"),
        (lambda: CoupledLimit("a", "b", ("x",), (0.0,), (1.0,)), "at of the coupled limit of a"),
        (lambda: Posture({"a": [0.1, 0.2]}), "a in a posture"),
        (lambda: Posture({"a": math.nan}), "a in a posture"),
        (lambda: Posture({}, up=(0, 0, 0)), "up"),
    ],
)
def test_parts_that_would_mean_something_else_are_refused(make, word: str) -> None:
    with pytest.raises(NaoKinError, match=word):
        make()


def test_semantics_are_copies_that_nobody_changes() -> None:
    angles, joints = {"a": 1.0}, ["a", "b"]
    semantics = Semantics(chains={"arm": joints}, postures={"p": Posture(angles)}, end_effectors=["tip"])
    angles["a"] = 2.0
    joints.clear()
    assert semantics.postures["p"].angles == {"a": 1.0}
    assert (semantics.chains, semantics.end_effectors) == ({"arm": ("a", "b")}, ("tip",))
    with pytest.raises(TypeError):
        semantics.postures["p"].angles["a"] = 3.0
    for copied in (copy.deepcopy(semantics), pickle.loads(pickle.dumps(semantics))):
        assert copied == semantics


@pytest.mark.parametrize(
    ("ending", "text", "reason"),
    [
        (".toml", "[postures.p]\nangles = { a = 0.5, b = 3.0 }", "posture 'p': a = 0.5 drives b"),
        (".toml", f"[postures.p]\nangles = {{ a = 1{'0' * 400} }}", "a in a posture"),
        (".toml", f"[postures.p]\nangles = {{ a = 1{'0' * 5000} }}", "cannot be read: "),
        (".toml", '[units]\na = "deg"', "unit of a must be one of rad, m, 1, got 'deg'"),
        (".srdf", "<sdf/>", "root element is <sdf>"),
    ],
)
def test_postures_beside_the_urdf_that_do_not_fit_keep_no_robot_from_loading(
    tmp_path: Path, ending: str, text: str, reason: str
) -> None:
    path = made_up(tmp_path, J("a"), J("b", follows=("a", 2.0, 0.0), limits=(-6.0, 6.0))).urdf_path
    path.with_suffix(ending).write_text(text, encoding="utf-8")
    robot = nk.RobotModel.from_urdf(path)
    assert robot.semantics == Semantics()
    (note,) = robot.load_notes
    assert f"{ending} beside the URDF is not used: " in note
    assert reason in note
    with pytest.raises(nk.NaoKinError):
        nk.RobotModel.from_urdf(path, semantics=path.with_suffix(ending))


def test_a_posture_outside_the_limits_is_noted(tmp_path: Path) -> None:
    robot = _robot(tmp_path, Semantics(postures={"in": Posture({"a": 1.0}), "out": Posture({"a": 4.0, "c": -5.0})}))
    assert robot.load_notes == ("posture 'out' is outside the limits of c, a",)
    assert robot.angles(robot.posture("out"))["c"] == -5.0


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("chains = 3", "chains"),
        ("[chains]\narm = 'a'", "arm"),
        ("[postures.p]\nangle = {}", r"postures\.p\.angle' \(nearest: angles"),
        ("[postures.p]\nup = [1, 0, 0]", "postures.p has no 'angles'"),
        ("[views]\nhand = 3", "views.hand"),
        ("coupled_limits = 3", "coupled_limits"),
        ("[[coupled_limits]]\njoint = 'a'", r"coupled_limits\[0\] has no 'of'"),
        ("[[coupled_limits]]\njoint = 'a'\nof = 'b'\nat = [0, 0]\nlower = [0, 0]\nupper = [1, 1]", "ascending"),
        ("[[coupled_limits]]\njoint = 'a'\nof = 'b'\nat = [0]\nlower = [0]\nupper = [1, 1]", "1, 1 and 2"),
        ("[[coupled_limits]]\njoint = 'a'\nof = 'b'\nat = [0]\nlower = [2]\nupper = [1]", "lower bound above"),
        ("soles = [", "not well-formed TOML"),
        ("\x80", "not well-formed TOML"),
    ],
)
def test_a_toml_file_that_makes_no_sense_is_refused_by_name(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "bad.toml"
    path.write_bytes(text.encode("latin-1"))
    with pytest.raises(BadInputFile, match=message) as caught:
        read_semantics(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_toml_file_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(BadInputFile, match=r"none\.toml: cannot be read: No such file"):
        read_semantics(tmp_path / "none.toml")


# --- SRDF -------------------------------------------------------------------------------------------------------------

SRDF = """<robot name="r">
  <group name="arm"><chain base_link="base" tip_link="c_l"/></group>
  <group name="upper"><joint name="a"/><joint name="b"/></group>
  <group name="hand"><link name="c_l"/></group>
  <group name="both"><group name="arm"/><joint name="side"/></group>
  <group name="loop"><group name="loop"/><joint name="a"/></group>
  <group name="none"><link name="base"/><joint name="gone"/></group>
  <end_effector name="e" parent_link="tip_l" group="hand"/>
  <end_effector name="f" parent_link="elsewhere" group="hand"/>
  <group_state name="home" group="arm">
    <joint name="a" value="0.5"/>
    <joint name="root_joint" value="0 0 1 0 0 0 1"/>
  </group_state>
  <group_state name="home" group="hand"><joint name="c" value="0. -1."/><joint name="lost" value="1"/></group_state>
</robot>"""


def _with_srdf(folder: Path, text: str = SRDF) -> nk.RobotModel:
    robot = made_up(folder, J("a"), J("b"), J("c"), J("tip", kind="fixed"), J("side", parent="base"))
    robot.urdf_path.with_suffix(".srdf").write_text(text, encoding="utf-8")
    return nk.RobotModel.from_urdf(robot.urdf_path)


def test_an_srdf_gives_chains_effectors_and_postures(tmp_path: Path) -> None:
    robot = _with_srdf(tmp_path)
    assert robot.chains == {"arm": ("a", "b", "c"), "upper": ("a", "b"), "hand": ("c",), "loop": ("a",)}
    assert robot.semantics.end_effectors == ("tip_l",)
    # Two numbers are the cosine and the sine of an unlimited joint.
    assert robot.angles(robot.posture("home")) == {"a": 0.5, "b": 0.0, "c": -math.pi / 2, "side": 0.0}
    assert robot.load_notes == (
        "robot.srdf names 3 joints and links that the robot does not have: gone, lost, elsewhere",
        "chains, effectors and postures from robot.srdf beside the URDF",
    )


def test_a_chain_of_an_srdf_goes_outwards_whatever_its_joints_are_called(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("z"), J("fix", kind="fixed"), J("m"), J("a"), J("b", parent="m"))
    robot.urdf_path.with_suffix(".srdf").write_text(
        """<robot name="r">
          <group name="whole"><joint name="a"/><joint name="m"/><joint name="fix"/><joint name="z"/></group>
          <group name="links"><link name="a_l"/><link name="m_l"/><link name="base"/></group>
          <group name="part"><chain base_link="z_l" tip_link="a_l"/></group>
          <group name="apart"><joint name="a"/><joint name="b"/></group>
          <group name="held"><joint name="fix"/></group>
          <group name="first"><group name="second"/><joint name="z"/></group>
          <group name="second"><group name="first"/><joint name="m"/></group>
        </robot>""",
        encoding="utf-8",
    )
    robot = nk.RobotModel.from_urdf(robot.urdf_path)
    assert robot.chains == {
        "whole": ("z", "m", "a"),
        "links": ("m", "a"),
        "part": ("m", "a"),
        "first": ("z", "m"),
        "second": ("z", "m"),
    }
    assert robot.load_notes == ("chains, effectors and postures from robot.srdf beside the URDF",)


def test_an_srdf_that_was_asked_for_is_refused_when_it_is_none(tmp_path: Path) -> None:
    for text, message in (("<sdf/>", "root element is <sdf>, an SRDF has <robot>"), ("<robot", "not well-formed XML")):
        path = tmp_path / "bad.srdf"
        path.write_text(text)
        with pytest.raises(BadModel, match=message):
            _robot(tmp_path, path)


def test_a_group_state_that_cannot_be_taken_is_left_out_alone(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("a"), J("b", follows=("a", 2.0, 0.0), limits=(-6.0, 6.0)), J("f", kind="fixed"))
    states = {
        "good": '<joint name="a" value="0.5"/><joint name="f" value="0.2"/>',
        "against the mimic": '<joint name="a" value="1"/><joint name="b" value="9"/>',
        "no number": '<joint name="a" value="half"/><joint name="b" value="0.1"/>',
        "too large": '<joint name="a" value="1e999"/>',
    }
    elements = "".join(
        f'<group_state name="{name}" group="arm">{inside}</group_state>' for name, inside in states.items()
    )
    path = robot.urdf_path.with_suffix(".srdf")
    path.write_text(
        f'<robot name="r"><group name="arm"><chain base_link="base" tip_link="b_l"/></group>{elements}'
        '<disable_collisions link1="base" link2="b_l" reason="Never"/></robot>',
        encoding="utf-8",
    )
    notes = (
        "group state 'no number' of robot.srdf is left out: 'a' is 'half', expected a number",
        "group state 'too large' of robot.srdf is left out: 'a' is '1e999', expected a number",
        "robot.srdf gives values to 1 fixed joints: f",
    )
    for semantics in (None, path):
        robot = nk.RobotModel.from_urdf(robot.urdf_path, semantics=semantics)
        assert robot.chains == {"arm": ("a", "b")}
        assert robot.posture_names == ("good",)
        assert robot.semantics.disabled_collisions == (("base", "b_l", "Never"),)
        assert robot.load_notes[:3] == notes
        assert robot.load_notes[3].startswith(
            "group state 'against the mimic' of robot.srdf is left out: a = 1 drives b"
        )


def test_a_fixed_joint_is_called_fixed(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("a"), J("f", kind="fixed"))
    with pytest.raises(UnknownName, match="unknown joint 'f' .*; 'f' is fixed in the robot's file"):
        robot.configuration({"f": 0.1})
    with pytest.raises(UnknownName, match="'f' is fixed in the robot's file"):
        robot.unit("f")
    with pytest.raises(UnknownName, match="'f' is fixed; give frames="):
        robot.with_offsets(joints={"f": 0.1})
    for semantics, message in (
        (Semantics(postures={"p": Posture({"f": 0.1})}), "posture 'p' names the joint 'f', which is fixed"),
        (Semantics(chains={"c": ("a", "f")}), "chain 'c' names the joint 'f', which is fixed"),
        (Semantics(soles=("f",)), "soles names the frame 'f', which is a fixed joint"),
        (Semantics(soles=("x",)), "soles names the frame 'x', which does not exist"),
    ):
        with pytest.raises(BadModel, match=message):
            nk.RobotModel.from_urdf(robot.urdf_path, semantics=semantics)


def test_an_srdf_speaks_of_links_by_the_names_of_the_file(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("a"), J("b"), J("c"))
    text = robot.urdf_path.read_text(encoding="utf-8").replace('"a_l"', '"a"').replace('"c_l"', '"c"')
    robot.urdf_path.write_text(text, encoding="utf-8")
    robot.urdf_path.with_suffix(".srdf").write_text(
        '<robot name="r"><group name="arm"><chain base_link="a" tip_link="c"/></group>'
        '<group name="end"><link name="c"/></group><end_effector name="e" parent_link="c" group="end"/></robot>',
        encoding="utf-8",
    )
    robot = nk.RobotModel.from_urdf(robot.urdf_path)
    assert robot.chains == {"arm": ("b", "c"), "end": ("c",)}
    assert robot.semantics.end_effectors == ("c_link",)


def test_robots_of_example_robot_data_bring_their_postures() -> None:
    romeo = nk.load_robot("romeo")
    assert romeo.posture_names == ("half_sitting",)
    assert romeo.angles(romeo.posture("half_sitting"))["LShoulderPitch"] == 1.5
    assert romeo.semantics.end_effectors == ("r_sole", "l_sole")
    assert romeo.chains["l_leg"][0] == "LHipYaw"


# --- NAO --------------------------------------------------------------------------------------------------------------


def test_nao_means_what_its_parameters_say(each_nao: nk.NaoModel) -> None:
    semantics = each_nao.semantics
    assert set(semantics.chains) == {"Head", "LArm", "RArm", "LLeg", "RLeg"}
    assert {*semantics.end_effectors, *semantics.soles, *semantics.cameras} <= set(each_nao.frame_names)
    assert semantics.coupled_limits == each_nao.parameters.coupled_limits
    assert semantics.start in each_nao.posture_names
    assert each_nao.mimics == each_nao.parameters.mimics
    assert each_nao.parameters.version == semantics.version == each_nao.version
    # Hands are read as ratios; lying and on all fours, the vertical is not the trunk's.
    assert {name: each_nao.unit(name) for name in each_nao.joint_names if each_nao.unit(name) != "rad"} == {
        "LHand": "1",
        "RHand": "1",
    }
    assert {name: posture.up for name, posture in semantics.postures.items() if posture.up is not None} == REST
    assert len(REST) > 0


# --- mimics -----------------------------------------------------------------------------------------------------------


def test_a_mimic_is_composed_and_turned_round() -> None:
    a_of_b, b_of_c = Mimic("b", -2.0, 0.5), Mimic("c", 3.0, 0.25)
    value = a_of_b.value(b_of_c.value(0.7))
    assert a_of_b.through(b_of_c).value(0.7) == pytest.approx(value, abs=1e-15)
    assert a_of_b.through(b_of_c).joint == "c"
    assert a_of_b.inverted("a").value(a_of_b.value(0.3)) == pytest.approx(0.3, abs=1e-15)
    assert a_of_b.driver_value(a_of_b.value(0.3)) == pytest.approx(0.3, abs=1e-15)
    assert a_of_b.range(-1.0, 2.0) == (-3.5, 2.5)
    assert a_of_b.driver_range(-3.5, 2.5) == (-1.0, 2.0)
    for lower, upper in ((-1.0, 2.0), (-math.inf, math.inf)):
        assert Mimic("b", 0.0, 0.5).range(lower, upper) == (0.5, 0.5)
    assert a_of_b.range(-math.inf, 2.0) == (-3.5, math.inf)
    assert a_of_b.driver_range(-math.inf, 2.5) == (-1.0, math.inf)
    assert a_of_b.through(b_of_c) == Mimic("c", -6.0, 0.0)
    assert a_of_b.inverted("a") == Mimic("a", -0.5, 0.25)


def test_a_coupled_limit_is_constant_outside_its_table() -> None:
    table = CoupledLimit("b", "a", (-1.0, 1.0), (-0.5, 0.0), (0.5, 1.0))
    lower, upper = table.range(np.array([-9.0, -1.0, 0.0, 1.0, 9.0]))
    assert lower.tolist() == [-0.5, -0.5, -0.25, 0.0, 0.0]
    assert upper.tolist() == [0.5, 0.5, 0.75, 1.0, 1.0]


@pytest.mark.parametrize("column", ["at", "lower", "upper"])
def test_a_coupled_limit_has_finite_numbers_alone(column: str) -> None:
    columns = {"at": (-1.0, 1.0), "lower": (-0.5, 0.0), "upper": (0.5, 1.0), column: (-math.inf, 1.0)}
    with pytest.raises(NotFinite, match=column):
        CoupledLimit("b", "a", **columns)


def test_sensors_that_a_robot_does_not_have_are_refused(nao: nk.NaoModel) -> None:
    for part in ("accelerometers", "gyrometers", "force_sensors"):
        with pytest.raises(
            BadModel, match=rf"{part} names the frame 'Gyro', which does not exist \(nearest: Gyrometer\)"
        ):
            nk.RobotModel(nao.tree, Semantics(**{part: ("Gyro",)}))


# --- the folder srdf of a package -----------------------------------------------------------------------------------

FITS = '<robot name="R"><group name="arm"><joint name="a"/><joint name="root_joint"/></group></robot>'


def _in_package(folder: Path, urdf: str, **srdf: str) -> nk.RobotModel:
    """The robot "r" of `_robot` in the folder urdf of a package, with files in its folder srdf."""
    for name in ("urdf", "srdf"):
        (folder / name).mkdir()
    for name, text in srdf.items():
        (folder / "srdf" / f"{name}.srdf").write_text(text)
    path = folder / "urdf" / f"{urdf}.urdf"
    path.write_text(re.sub('<robot name="[^"]*"', '<robot name="r"', _robot(folder).urdf_path.read_text(), count=1))
    return nk.RobotModel.from_urdf(path)


@pytest.mark.parametrize(
    ("urdf", "files"),
    [
        ("r_full", {"r": FITS}),  # as talos.srdf for talos_full_v2.urdf
        ("other", {"it": FITS}),  # the only one
        ("r_robot", {"r": FITS, "r_gripper": FITS}),  # as ur5.srdf for ur5_robot.urdf
        ("r_full", {"r": FITS, "r_left": FITS.replace('"a"', '"lost"')}),
        ("r_full", {"r_full": FITS.replace('"a"', '"c"').replace('"R"', '"any"'), "r": FITS}),  # by its name
    ],
)
def test_the_srdf_of_a_package_is_found_if_it_fits(tmp_path: Path, urdf: str, files: dict[str, str]) -> None:
    robot = _in_package(tmp_path, urdf, **files)
    used = next(name for name in (urdf, *files) if name in files)
    assert robot.chains == {"arm": ("c",) if used == urdf else ("a",)}
    assert any(f"{used}.srdf" in note for note in robot.load_notes)


@pytest.mark.parametrize(
    "files",
    [
        {"r": FITS.replace('"R"', '"s"')},  # of another robot
        {"r": FITS.replace('"a"', '"lost"')},  # of a variant with more joints
        {"r": '<robot name="r"/>'},  # without evidence
        {"one": FITS, "two": FITS},
        {"r": "<robot"},
    ],
)
def test_an_srdf_that_may_be_of_another_robot_is_not_used(tmp_path: Path, files: dict[str, str]) -> None:
    robot = _in_package(tmp_path, "r_full", **files)
    assert robot.chains == {}
    (note,) = (note for note in robot.load_notes if "srdf" in note)
    assert all(name in note for name in files)


def test_a_robot_of_example_robot_data_says_whose_postures_it_has() -> None:
    try:
        talos, ur10 = nk.load_robot("talos_full_v2"), nk.load_robot("ur10_robot")
        g1 = nk.load_robot("g1_29dof_rev_1_0")
    except nk.errors.MissingExtra as error:
        pytest.skip(str(error))
    assert (talos.posture_names, len(talos.chains)) == (("half_sitting",), 8)
    assert any("talos.srdf" in note for note in talos.load_notes)
    assert any("ur5.srdf" in note for note in ur10.load_notes)
    assert any("g1_29dof_rev_1_0.srdf" in note for note in g1.load_notes)
