"""Robots by the names of robot_descriptions, which a made-up package stands for: nothing here goes to the network."""

from __future__ import annotations

import importlib
import importlib.metadata
import sys
from pathlib import Path

import pytest

import nao_kin as nk
from nao_kin.errors import BadModel, UnknownName

needs_data = pytest.mark.skipif(
    not any(importlib.metadata.distributions(name="example-robot-data")),
    reason="example-robot-data has the other names",
)
LINK = '<link name="a"><visual><geometry><mesh filename="package://arm_pkg/a.stl"/></geometry></visual></link>'


@pytest.fixture
def descriptions(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of a package robot_descriptions with a few robots."""
    repository = tmp_path / "cache" / "repository"
    (repository / "arm_pkg").mkdir(parents=True)
    (repository / "arm_pkg" / "a.stl").touch()
    (tmp_path / "arm.urdf").write_text(f'<robot name="arm">{LINK}</robot>')
    (tmp_path / "arm.srdf").write_text('<robot name="arm"><end_effector name="e" parent_link="a" group="g"/></robot>')
    (tmp_path / "arm.xacro").write_text(
        '<robot name="arm" xmlns:x="http://www.ros.org/wiki/xacro"><link name="$(arg link)"/><x:if value="1"/></robot>'
    )
    (tmp_path / "arm.xml").write_text("<mujoco model='arm'><worldbody><body name='b'/></worldbody></mujoco>")
    package = tmp_path / "site" / "robot_descriptions"
    package.mkdir(parents=True)
    (package / "__init__.py").write_text("")
    paths = f"REPOSITORY_PATH = {str(repository)!r}\nPACKAGE_PATH = REPOSITORY_PATH + '/arm_pkg'\n"
    modules = {
        "arm_description": f"print('Cloning')\nURDF_PATH = {str(tmp_path / 'arm.urdf')!r}\n"
        "SRDF_PATH = URDF_PATH[:-4] + 'srdf'",
        "arm_xacro_description": f"XACRO_PATH = {str(tmp_path / 'arm.xacro')!r}\nXACRO_ARGS = {{'link': 'l'}}",
        "arm_mj_description": f"MJCF_PATH = {str(tmp_path / 'arm.xml')!r}",
        "far_description": "raise OSError('Could not resolve host:\\n github.com')",
        "none_description": "",
        "_empty_description": "raise SystemExit",
    }
    for name, text in modules.items():
        (package / f"{name}.py").write_text(paths + text)
    for name in [name for name in sys.modules if name.partition(".")[0] == "robot_descriptions"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.syspath_prepend(str(tmp_path / "site"))
    importlib.invalidate_caches()
    yield package
    for name in [name for name in sys.modules if name.partition(".")[0] == "robot_descriptions"]:
        del sys.modules[name]


def test_a_description_loads_with_its_packages_and_its_srdf(
    descriptions: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    robot = nk.load_robot("arm_description", base="floating")
    assert (robot.link_names, robot.base) == (("a",), "floating")
    assert robot.semantics.end_effectors == ("a",)
    assert robot.load_notes == ()  # the mesh of package://arm_pkg is there
    assert capsys.readouterr() == ("", "Cloning\n")  # standard output is for what was asked


def test_the_package_of_a_description_is_found_without_its_repository(descriptions: Path) -> None:
    module = descriptions / "arm_description.py"
    text = module.read_text()
    module.write_text(f"{text}\ndel REPOSITORY_PATH\n")
    assert nk.load_robot("arm_description").load_notes == ()


def test_a_description_in_xacro_loads_with_its_arguments(descriptions: Path) -> None:
    pytest.importorskip("xacro")
    assert nk.load_robot("arm_xacro_description").link_names == ("l",)


def test_a_description_that_calls_itself_a_urdf_is_not_expanded(descriptions: Path, tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text('<robot name="arm"><link name="${1 + 1}"/></robot>')
    with pytest.raises(BadModel, match="xacro=True"):
        nk.load_robot("arm_description")


def test_a_description_in_mjcf_loads(descriptions: Path) -> None:
    pytest.importorskip("mujoco")
    assert nk.load_robot("arm_mj_description").link_names == ("b",)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        (
            "far_description",
            "'far_description': robot_descriptions cannot download it: Could not resolve host: github.com",
        ),
        ("none_description", "neither a URDF nor an MJCF"),
    ],
)
def test_a_description_that_cannot_be_had_is_refused_in_one_line(descriptions: Path, name: str, message: str) -> None:
    with pytest.raises(BadModel, match=message) as caught:
        nk.load_robot(name)
    assert "\n" not in str(caught.value)


@needs_data
def test_names_are_listed_where_they_are_installed(descriptions: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    ours = ("arm_description", "arm_mj_description", "arm_xacro_description", "far_description", "none_description")
    assert nk.robot_names(download=True)[-5:] == ours
    assert not set(ours) & set(nk.robot_names())
    assert "_empty_description" not in nk.robot_names(download=True)
    with pytest.raises(UnknownName, match="nearest: arm_description") as caught:
        nk.load_robot("arm_descripton")
    assert "pip install" not in str(caught.value)


@needs_data
def test_without_the_package_its_names_say_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("nao_kin.robot.library._DESCRIPTIONS", "a_package_that_nobody_has")
    with pytest.raises(UnknownName, match=r"pip install 'nao-kin\[descriptions\]'"):
        nk.load_robot("g1_description")
    with pytest.raises(UnknownName) as caught:
        nk.load_robot("romoe")
    assert "descriptions" not in str(caught.value)
    assert nk.robot_names(download=True) == nk.robot_names()


def test_without_either_package_a_name_says_which_it_needs(monkeypatch: pytest.MonkeyPatch) -> None:
    for constant in ("_DESCRIPTIONS", "_PACKAGE"):
        monkeypatch.setattr(f"nao_kin.robot.library.{constant}", "a_package_that_nobody_has")
    for name, extra in (("g1_description", "descriptions"), ("romeo", "robots")):
        with pytest.raises(nk.errors.MissingExtra, match=rf"^loading a robot by .*nao-kin\[{extra}\]"):
            nk.load_robot(name)


def test_descriptions_serve_without_example_robot_data(descriptions: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("nao_kin.robot.library._PACKAGE", "a-package-that-nobody-has")
    assert nk.load_robot("arm_description").name == "arm"
    assert "romeo" not in nk.robot_names(download=True)
    with pytest.raises(nk.errors.MissingExtra, match=r"nao-kin\[robots\]"):
        nk.robot_names()


@needs_data
def test_a_robot_by_name_may_have_a_floating_base() -> None:
    robot = nk.load_robot("ur5_robot", base="floating")
    assert (robot.base, robot.nq, robot.nv) == ("floating", 13, 12)
