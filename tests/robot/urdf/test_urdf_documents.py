"""XML as people write it: what a URDF may hold beside links and joints, and what makes it no URDF."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

import nao_kin as nk
from nao_kin.errors import BadModel

BODY = '<link name="a"/><link name="b"/><joint name="J" type="{kind}"><parent link="a"/><child link="b"/></joint>'
FIXED = BODY.format(kind="fixed")


def _load(folder: Path, text: str | bytes, name: str = "robot.urdf") -> nk.RobotModel:
    path = folder / name
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return nk.RobotModel.from_urdf(path)


@pytest.mark.parametrize(
    ("text", "note"),
    [
        (f'<robot name="r" xmlns:xacro="http://ros.org/wiki/xacro"><xacro:property name="x" value="1"/>{FIXED}</robot>',
         "1 leftover elements of xacro left out: <xacro:property>"),
        (f'<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:property name="x" value="${{pi}}"/>'
         f'<xacro:include filename="$(find y)/z.xacro"/>{FIXED}</robot>',
         "2 leftover elements of xacro left out: <xacro:property>, <xacro:include>"),
        (f'<robot name="r">{FIXED}<gazebo><xacro:wheel name="w"/></gazebo></robot>',
         "1 leftover elements of xacro left out: <xacro:wheel>"),
        (f'<robot name="r" xmlns:x="http://wiki.ros.org/xacro"><x:arg name="n"/>{FIXED}</robot>',
         "1 leftover elements of xacro left out: <xacro:arg>"),
        (f'<robot name="r">{FIXED}<xacro:wheel name="w"/><xacro:gazebo_color/></robot>',
         "2 leftover elements of xacro left out: <xacro:wheel>, <xacro:gazebo_color>"),
    ],
    ids=["property", "definitions", "anywhere, prefix not bound", "another prefix", "calls of nothing"],
)  # fmt: skip
def test_what_xacro_left_behind_is_left_out_and_noted(tmp_path: Path, text: str, note: str) -> None:
    robot = _load(tmp_path, text)
    assert robot.link_names == ("a", "b")
    assert robot.load_notes == (note,)


@pytest.mark.parametrize(
    "inside",
    [
        '<xacro:macro name="m"/>' + FIXED,
        '<gazebo><xacro:macro name="m"/></gazebo>' + FIXED,
        FIXED.replace('name="J"', 'name="${prefix}J"'),
        FIXED.replace('name="J"', 'name="$(arg prefix)J"'),
        '<xacro:if value="${flag}"><link name="c"/></xacro:if>' + FIXED,
        '<xacro:if value="true"><link name="c"/></xacro:if>' + FIXED,
        f'<xacro:unless value="false">{FIXED}</xacro:unless>',
        f'{FIXED}<xacro:include filename="arms.xacro"/><xacro:arm side="left"/>',
    ],
)
def test_a_xacro_source_is_refused_with_what_expands_it(
    tmp_path: Path, inside: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "xacro", None)  # as if it were not installed
    text = f'<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">{inside}</robot>'
    with pytest.raises(BadModel, match=r"xacro source with [12] .*nao-kin\[xacro\].* xacro arm\.xacro -o arm\.urdf$"):
        _load(tmp_path, text, "arm.xacro")
    with pytest.raises(BadModel, match=r"xacro source with 1 .*; xacro=True \(--xacro\) expands it"):
        _load(tmp_path, text)
    with pytest.raises(BadModel, match=r"xacro robot\.urdf -o expanded\.urdf$"):
        nk.RobotModel.from_urdf(tmp_path / "robot.urdf", xacro=True)


def test_a_source_is_a_source_without_the_word_xacro(tmp_path: Path) -> None:
    with pytest.raises(BadModel, match="a xacro source with 2 unexpanded"):
        _load(tmp_path, '<robot name="${name}">' + FIXED.replace('name="J"', 'name="${prefix}J"') + "</robot>")


def test_a_file_named_a_source_misses_what_it_includes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "xacro", None)
    text = f'<robot name="r"><xacro:include filename="hand.xacro"/>{FIXED}</robot>'
    with pytest.raises(BadModel, match="a xacro source with 1 unexpanded"):
        _load(tmp_path, text, "arm.xacro")
    defines = f'<robot name="r"><xacro:arg name="n"/><xacro:property name="p" value="1"/>{FIXED}</robot>'
    assert len(_load(tmp_path, defines, "arm.xacro").load_notes) == 1


def test_dollars_of_other_programs_make_no_source(tmp_path: Path) -> None:
    joint = FIXED.replace('name="J"', 'name="$(JOINT) $5"')
    assert _load(tmp_path, f'<robot name="r">{joint}</robot>').load_notes == ()


@pytest.mark.parametrize("kind", ["property", "arg", "include"])
def test_what_merely_defines_may_hold_expressions(tmp_path: Path, kind: str) -> None:
    robot = _load(tmp_path, f'<robot name="r"><xacro:{kind} name="n" value="${{x}}"/>{FIXED}</robot>')
    assert robot.load_notes == (f"1 leftover elements of xacro left out: <xacro:{kind}>",)


def test_elements_of_other_tools_are_no_leftovers_of_xacro(tmp_path: Path) -> None:
    others = '<sensor:camera/><xacro:arg name="n"/><x:arg name="m"/>'
    text = f'<robot name="r" xmlns:sensor="http://s.org" xmlns:x="http://ros.org/xacro">{others}{FIXED}</robot>'
    assert _load(tmp_path, text).load_notes == ("2 leftover elements of xacro left out: <xacro:arg>",)


def test_an_expression_that_no_element_uses_keeps_nothing_from_loading(tmp_path: Path) -> None:
    assert _load(tmp_path, f'<robot name="r"><!-- ${{x}} -->{FIXED}</robot>').load_notes == ()


@pytest.mark.parametrize(
    "text",
    [
        f'\n\n  <?xml version="1.0"?>\n<robot name="r">{FIXED}</robot>',
        f'<robot name="r" xmlns="http://drake.mit.edu">{FIXED}</robot>',
        f'<robot name="r">{FIXED}<sensor:camera sensor:name="c"/><controller:gazebo/></robot>',
        f'<?xml version="1.0" encoding="latin-1"?><robot name="r">{FIXED}<!-- é --></robot>'.encode("latin-1"),
        b"\xef\xbb\xbf" + f'<robot name="r">{FIXED}</robot>'.encode(),
        b"\xef\xbb\xbf\n\n" + f'<?xml version="1.0"?><robot name="r">{FIXED}</robot>'.encode(),
        f'<!-- a licence -- <?xml -->\n<!---->\n<?xml version="1.0"?>\n<robot name="r">{FIXED}</robot>',
        f'<?xml-model href="urdf.xsd"?>\n <!-- a -> b? --> <?x?>\n<?xml version="1.0"?><robot name="r">{FIXED}</robot>',
        f'<!-- no declaration --><?x?><robot name="r">{FIXED}</robot>',
    ],
    ids=range(9),
)
def test_what_strict_xml_refuses_and_everybody_reads_is_read(tmp_path: Path, text: str | bytes) -> None:
    robot = _load(tmp_path, text)
    assert (robot.link_names, robot.load_notes) == (("a", "b"), ())
    report = nk.crosscheck.run(robot, 2)
    assert report.ok, report.failures


@pytest.mark.parametrize("before", ["\n\n", "<!-- two\nlines -->\n"])
def test_the_line_of_a_mistake_counts_those_before_the_declaration(tmp_path: Path, before: str) -> None:
    with pytest.raises(BadModel, match=r"line 4, column \d+: not well-formed XML \(mismatched tag\)"):
        _load(tmp_path, before + '<?xml version="1.0"?>\n<robot><link name="a"></robot>')


def test_a_declaration_after_other_text_is_refused(tmp_path: Path) -> None:
    for before in ("text", "<!-- not closed", "<!-- a --> text"):
        with pytest.raises(BadModel, match="not well-formed XML"):
            _load(tmp_path, f'{before}<?xml version="1.0"?><robot name="r">{FIXED}</robot>')


def test_a_chain_of_thousands_of_fixed_links_loads(tmp_path: Path) -> None:
    links = "".join(f'<link name="l{i}"/>' for i in range(2000))
    joints = "".join(
        f'<joint name="j{i}" type="fixed"><origin xyz="0.001 0 0"/><parent link="l{i}"/><child link="l{i + 1}"/>'
        "</joint>"
        for i in range(1999)
    )
    robot = _load(tmp_path, f'<robot name="r">{links}{joints}</robot>')
    assert robot.position([], "l1999").tolist() == pytest.approx([1.999, 0.0, 0.0])


def test_a_mesh_name_that_no_system_takes_is_a_missing_file(tmp_path: Path) -> None:
    for name in ("x" * 5000, "package://" + "y" * 5000, "a&#0;b".replace("&#0;", "")):
        shape = f'<link name="a"><visual><geometry><mesh filename="{name}"/></geometry></visual></link>'
        (note,) = _load(tmp_path, f'<robot name="r">{shape}</robot>').load_notes
        assert note.startswith("1 of 1 mesh files are missing, first ")
        assert len(note) < 300
