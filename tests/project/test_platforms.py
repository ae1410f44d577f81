"""What works on a system without the modules of POSIX, as Windows is."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = """
import sys
for name in ("fcntl", "grp", "pwd"):
    sys.modules[name] = None  # as if it were not there
import numpy as np
import nao_kin as nk

nao = nk.load_nao()
q = nao.posture("StandInit")
poses = nao.fk(np.tile(q, (300, 1)), "LArm")
assert poses.shape == (300, 4, 4) and np.allclose(poses, nao.fk(q, "LArm"))
assert nk.ik.leg(nao, "L", nao.fk(q, "LLeg")).count == 1
assert nk.warm_up() == ()
nk.export.urdf(nao, sys.argv[1] + "/nao.urdf")
nk.Viewer(nao).save_html(sys.argv[1] + "/nao.html")
"""


@pytest.mark.full
def test_without_posix_all_is_computed_and_nothing_compiled(tmp_path: Path) -> None:
    command = [sys.executable, "-W", "error", "-c", SCRIPT, str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "nao.html").stat().st_size > 1e6
