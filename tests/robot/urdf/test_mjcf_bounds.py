"""MJCF files of a few lines that would keep MuJoCo busy for hours; no signal ends a call into it."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from mjcf_samples import BOX, write

import nao_kin as nk
from nao_kin.errors import BadModel
from nao_kin.robot.urdf import mjcf_compiled as compiled

pytest.importorskip("mujoco", reason="MuJoCo reads MJCF")

BODY = f'<worldbody><body name="a">{BOX}</body></worldbody>'
MANY = f'<replicate count="100000000" offset="0 0 1"><body>{BOX}</body></replicate>'
BOMBS = {
    "copies": f"<worldbody>{MANY}</worldbody>",
    "copies of copies": f'<worldbody><replicate count="9999"><replicate count="9999">{BOX}</replicate></replicate>'
    "</worldbody>",
    "copies in another file": '<worldbody><include file="many.xml"/></worldbody>',
    "a soft body": '<worldbody><body name="a"><flexcomp name="f" type="grid" count="2000 2000 200" spacing="1 1 1" '
    'dim="3" mass="1"/></body></worldbody>',
    "keyframes": f'<size nkey="100000000"/>{BODY}',
    "a height field": f'<asset><hfield name="h" nrow="60000" ncol="60000" size="1 1 1 1"/></asset>{BODY}',
    "a mesh by formula": f'<asset><mesh name="m" builtin="plate" params="60000 60000"/></asset>{BODY}',
}


@pytest.mark.parametrize(
    "name",
    [name if name in ("copies", "a mesh by formula") else pytest.param(name, marks=pytest.mark.full) for name in BOMBS],
)
def test_a_small_file_does_not_keep_mujoco_busy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    monkeypatch.setattr(compiled, "_SECONDS", 1.5)
    (tmp_path / "many.xml").write_text(f"<mujocoinclude>{MANY}</mujocoinclude>")
    with pytest.raises(BadModel, match=r"robot\.xml: "):
        nk.RobotModel.from_mjcf(write(tmp_path, BOMBS[name]))


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="signals of POSIX")
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_ends_the_command_that_reads_such_a_file(tmp_path: Path, number: signal.Signals) -> None:
    path = write(tmp_path, BOMBS["copies"])
    with subprocess.Popen(
        [sys.executable, "-m", "nao_kin", "info", "--urdf", str(path)], stderr=subprocess.PIPE, cwd=tmp_path
    ) as process:
        children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
        began = time.monotonic()
        while children.exists() and not children.read_text() and time.monotonic() - began < 60.0:
            time.sleep(0.1)
        process.send_signal(number)
        assert process.wait(10.0) in (128 + number, -number)


def test_a_file_of_ordinary_numbers_is_read_in_this_process(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(subprocess, "Popen", None)
    robot = nk.RobotModel.from_mjcf(write(tmp_path, f'<size nconmax="2000" memory="10M"/>{BODY}'))
    assert robot.link_names == ("a",)


def test_a_few_copies_are_read_as_mujoco_makes_them(tmp_path: Path) -> None:
    few = '<replicate count="3" offset="0 0 1"><site name="s"/></replicate>'
    robot = nk.RobotModel.from_mjcf(write(tmp_path, f'<worldbody><body name="a">{BOX}{few}</body></worldbody>'))
    assert robot.position([], "s2").tolist() == [0.0, 0.0, 2.0]


@pytest.mark.parametrize(
    ("limits", "expected"),
    [
        ('range="-inf inf"', (-np.inf, np.inf)),
        ('range="-inf 0.5"', (-np.inf, 0.5)),
        ('range="-0.5 inf" limited="true"', (-0.5, np.inf)),
    ],
)
def test_an_infinite_limit_is_none_and_noted(tmp_path: Path, limits: str, expected: tuple[float, float]) -> None:
    joint = f'<body name="b"><joint name="J" {limits}/>{BOX}</body>'
    robot = nk.RobotModel.from_mjcf(write(tmp_path, f'<worldbody><body name="a">{BOX}{joint}</body></worldbody>'))
    np.testing.assert_allclose((robot.lower[0], robot.upper[0]), expected, rtol=1e-7)
    assert any("J" in note for note in robot.load_notes)
