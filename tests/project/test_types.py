"""A type checker sees the mistakes in a user's script, and no others."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import nao_kin as nk

# Each line that ends with # wrong has one mistake.
SCRIPT = """
from __future__ import annotations
import numpy as np
import nao_kin as nk

nao = nk.load_nao("v6", base="fixed")
q = nao.posture("StandInit")
T = nao.fk(q, "LArm")
nk.misspelt  # wrong
nk.rotations.rpy_from_matix(np.eye(3))  # wrong
nao.fkk(q, "LArm")  # wrong
nao.fk(q, frames=["LArm"])  # wrong
nao.fk(q, 5)  # wrong
found = nk.ik.arm(nao, "L", T, near="StandInit" if nao.nq else q)
print(found.message.upper(), found.describe().upper(), found.best[0])
found.mesage  # wrong
nk.ik.numeric(nao, "LArm", T, limits="clamp")  # wrong
motion = nk.Motion([0.0, 1.0], ["HeadYaw"], [[0.0], [0.5]])
motion.sampel(0.5)  # wrong
nk.load_nao(base="float")  # wrong
viewer = nk.Viewer(nao)
viewer.display(q)
viewer.displai(q)  # wrong
viewer.display(q, colour="red")  # wrong
print(nk.world.balance(nao, q).margin)
nk.world.balance(nao, q).margn  # wrong
nk.rotations.matrix_from_euler([0, 0, 0], "zyx", axes="fix")  # wrong
nao.configuration({"HeadYaw": 0.1}, degree=True)  # wrong
nk.export.urdf(nao)  # wrong
mass: int = nao.mass  # wrong
nk.motion.write_motion("a.csv", motion)  # wrong
nk.errors.UnknownNam  # wrong
nk.world.odometry(nao, [q, q], [0.0, 0.1]).headng  # wrong
"""


@pytest.mark.full
def test_mypy_finds_each_mistake_in_a_script_and_no_other(tmp_path: Path) -> None:
    pytest.importorskip("mypy")
    (tmp_path / "user.py").write_text(SCRIPT)
    command = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(tmp_path / "cache"), "user.py"]
    environment = {**os.environ, "MYPYPATH": str(Path(nk.__file__).parents[1])}
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, env=environment)
    found = {int(line) for line in re.findall(r"^user\.py:(\d+): error", done.stdout, re.M)}
    assert found == {k for k, line in enumerate(SCRIPT.splitlines(), 1) if line.endswith("# wrong")}, done.stdout
