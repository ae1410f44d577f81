"""Without its extras the library gives the same numbers or a one-line error; and one table lists the extras."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from doc_pages import PAGES
from loops import full
from packaging.requirements import Requirement

import nao_kin as nk
from nao_kin._core.extras import ALL, EXTRAS

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
OPTIONAL = PROJECT["optional-dependencies"]
FOR_DEVELOPERS = {"test", "test-full", "docs", "dev", "dev-full"}
EVERY = sorted({*(word for extra in EXTRAS.values() for word in (*extra.packages, *extra.modules)), "llvmlite"})

# The same questions with Numba and without; what they give is written to a file.
ANSWERS = """
import sys, numpy as np, nao_kin as nk
nao = nk.load_nao("v5")
q = nao.random(3, 80)
v = np.random.default_rng(3).normal(size=q.shape)
hands, feet = nao.fk(q[:6], ["LArm", "RArm"]), nao.fk(q[:6], ["LLeg", "RLeg"])
off = hands[:, 0].copy()
off[:, :3, 3] += 0.03
legs = nk.ik.legs(nao, feet[:, 0], feet[:, 1])
numeric = nk.ik.numeric(nao, "RArm", hands[:4, 1])
stand = nao.posture("StandInit")
body = nk.ik.whole_body(nao, {"LArm": nao.position(stand, "LArm") + 0.01}, com="support", near=stand)
reach = nk.reach.workspace(nao, "LArm", samples=400, voxel=0.02, seed=1)
np.savez(
    sys.argv[1],
    fk=nao.fk(q), single=nao.fk(q, "LArm", dtype=np.float32), relative=nao.fk(q, "LArm", reference="Head"),
    jacobian=nao.jacobian(q, "RLeg"), com=nao.com(q), com_jacobian=nao.com_jacobian(q),
    velocity=nao.velocity(q, v, "LArm"), acceleration=nao.acceleration(q, v, v, "LArm"),
    arm=nk.ik.arm(nao, "L", hands[:, 0]).q, off=nk.ik.arm(nao, "L", off).q,
    directed=nk.ik.arm(nao, "R", hands[:, 1, :3, 3], direction=hands[:, 1, :3, 0]).q,
    place=nk.ik.arm(nao, "R", hands[:2, 1, :3, 3]).q,
    leg=nk.ik.leg(nao, "R", feet[:, 1]).q, legs=legs.q, legs_success=legs.success,
    head=nk.ik.head(nao, nao.rotation(q[:6], "Head")).q,
    numeric=nao.fk(numeric.q, "RArm"), numeric_success=numeric.success, body=body.q,
    voxels=reach.indices, best=reach.best, directions=reach.directions,
)
"""


def answers(path: Path, **environment: str) -> dict[str, np.ndarray]:
    """Return the results of the program in an environment."""
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", ANSWERS, str(path)],
        env={**os.environ, "PYTHONPATH": str(ROOT), **environment},
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert done.returncode == 0, done.stderr
    return dict(np.load(path))


def hidden(*names: str) -> dict[str, str]:
    """The environment of a process to which these packages are not installed."""
    where = os.pathsep.join((str(ROOT / "tests" / "hidden"), str(ROOT)))
    return {"NAO_KIN_HIDDEN": " ".join(names), "PYTHONPATH": where}


@pytest.mark.full
def test_without_numba_every_number_is_the_same(tmp_path: Path) -> None:
    with_numba = answers(tmp_path / "with.npz")
    without = answers(tmp_path / "without.npz", **hidden("numba", "llvmlite"))
    assert with_numba.keys() == without.keys()
    tolerances = {"single": 1e-6, "place": 1e-7, "numeric": 1e-7, "body": 1e-7}
    for name, expected in with_numba.items():
        np.testing.assert_allclose(without[name], expected, rtol=0, atol=tolerances.get(name, 1e-11), err_msg=name)
    # And they are not the same because nothing was hidden: Pinocchio's last bits are others than the kernels'.
    assert not np.array_equal(without["fk"], with_numba["fk"])


@pytest.mark.full
def test_the_suite_of_the_default_installation_passes_where_no_extra_is(tmp_path: Path) -> None:
    done = subprocess.run(
        [
            *(sys.executable, "-m", "pytest", "-q", "--noconftest", "-p", "no:cacheprovider", "-c", os.devnull),
            *("--rootdir", str(tmp_path), str(ROOT / "tests" / "project" / "test_default_install.py")),
        ],
        cwd=tmp_path,
        env={**os.environ, **hidden(*EVERY)},
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "skipped" not in done.stdout, done.stdout


@pytest.mark.full
def test_the_command_lines_of_a_page_run_without_extras_or_the_page_names_them(tmp_path: Path) -> None:
    file = tmp_path / "failed.json"
    done = subprocess.run(
        [sys.executable, str(ROOT / "tests" / "_helpers" / "doc_commands.py"), str(file)],
        env={**os.environ, **hidden(*EVERY)},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        timeout=600,
    )
    assert done.returncode == 0, done.stderr
    asked = set()
    for page, line, said in json.loads(file.read_text(encoding="utf-8")):
        extra = re.search(r"pip install 'nao-kin\[(\w+)\]'", said)
        assert extra, (page, line, said)
        text = next(path for path in PAGES if path.name == page).read_text(encoding="utf-8")
        assert re.search(rf"nao-kin\[[\w,]*\b{extra[1]}\b|extra `{extra[1]}`", text), (page, line, said)
        asked.add(extra[1])
    assert asked == {"arrow", "calibration", "mujoco", "photos", "plot", "robots"}


@pytest.mark.parametrize("kind", [ImportError("Numba needs NumPy 2.4 or less. Got NumPy 2.9."), *full(None)])
def test_numba_that_does_not_load_is_named_and_done_without(kind: ImportError | None, tmp_path: Path) -> None:
    folder = tmp_path / "numba"
    folder.mkdir()
    text = f"raise ImportError({str(kind)!r})" if kind else "import llvmlite_that_is_gone"
    (folder / "__init__.py").write_text(text)
    code = (
        "import nao_kin as nk; nao = nk.load_nao(); q = nao.random(0, 70); print(nao.fk(q, 'LArm').shape)\n"
        "try: nk._kernels.kernel(q.dtype, q.dtype)\n"
        "except nk.errors.MissingExtra as error: print(error)"
    )
    path = os.pathsep.join((str(tmp_path), str(ROOT)))
    done = subprocess.run(
        [sys.executable, "-c", code], env={**os.environ, "PYTHONPATH": path}, capture_output=True, text=True, timeout=60
    )
    shape, line = done.stdout.splitlines()
    reason = str(kind) if kind else "No module named 'llvmlite_that_is_gone'"
    assert shape == "(70, 4, 4)"
    assert line.startswith(f"a batch kernel needs numba, which does not load ({reason})")


def test_importing_the_package_imports_none_of_its_extras() -> None:
    modules = sorted({name for extra in EXTRAS.values() for name in extra.modules})
    code = f"import sys, nao_kin; nao_kin.load_nao(); print([name for name in {modules} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


# --- one table ------------------------------------------------------------------------------------------------------


def test_every_extra_of_the_table_is_one_of_the_metadata_and_the_other_way_round() -> None:
    assert OPTIONAL.keys() == EXTRAS.keys() | FOR_DEVELOPERS | {ALL}


@pytest.mark.parametrize("name", EXTRAS)
def test_an_extra_asks_for_the_packages_of_the_table(name: str) -> None:
    assert {Requirement(line).name for line in OPTIONAL[name]} == set(EXTRAS[name].packages)


def test_all_is_the_union_of_the_others() -> None:
    (line,) = OPTIONAL[ALL]
    assert Requirement(line).extras == set(EXTRAS)


def test_no_package_is_both_an_extra_and_a_default() -> None:
    default = {Requirement(line).name for line in PROJECT["dependencies"]}
    assert not default & {package for extra in EXTRAS.values() for package in extra.packages}


def test_errors_name_extras_of_the_table() -> None:
    asked = re.compile(r'(?:need_extra|MissingExtra)\((?:[^()"]|"[^"]*"|\([^()]*\))*?, "(\w+)"')
    found = {name for path in (ROOT / "nao_kin").rglob("*.py") for name in asked.findall(path.read_text("utf-8"))}
    assert found == EXTRAS.keys() - {"notebook", "xacro"}


def test_the_page_about_installation_has_the_table() -> None:
    page = (ROOT / "docs" / "installation.md").read_text(encoding="utf-8")
    for extra in EXTRAS.values():
        assert f"| `{extra.name}` | {', '.join(extra.packages)} | {extra.brings} | {extra.without} |" in page


def test_a_cell_that_is_not_live_says_how_it_would_be() -> None:
    assert "pip install 'nao-kin[notebook]'" in nk.viewer.notebook.NOT_LIVE
