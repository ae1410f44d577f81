"""The wheel holds everything and works outside the checkout."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import venv
import zipfile
from pathlib import Path

import pytest

pytestmark = pytest.mark.full

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    target = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", str(target), str(ROOT)]
    built = subprocess.run(command, capture_output=True, text=True)
    assert built.returncode == 0, built.stdout + built.stderr
    (path,) = target.glob("*.whl")
    return path


@pytest.fixture(scope="module")
def python(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A fresh environment with the wheel; its dependencies are borrowed from the environment that runs the tests."""
    home = tmp_path_factory.mktemp("environment")
    venv.create(home, with_pip=False)
    python = home / "bin" / "python"
    where = "import sysconfig; print(sysconfig.get_path('purelib'))"
    site = Path(subprocess.run([python, "-c", where], capture_output=True, text=True, check=True).stdout.strip())
    borrowed = [entry for entry in sys.path if "site-packages" in entry]
    (site / "borrowed.pth").write_text("\n".join(borrowed) + "\n")
    subprocess.run(
        [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--no-index", "--target", site, wheel],
        check=True,
    )
    return python


def test_the_wheel_holds_the_urdfs_the_samples_and_the_type_marker(wheel: Path) -> None:
    names = set(zipfile.ZipFile(wheel).namelist())
    assert "nao_kin/_urdf_files/LICENSE" in names  # goes into ROS packages
    assert {f"nao_kin/_urdf_files/nao_{version}.urdf" for version in ("v32", "v33", "v4", "v5", "v6")} <= names
    assert {f"nao_kin/_urdf_files/meshes/{path.name}" for path in (ROOT / "urdf" / "meshes").iterdir()} <= names
    samples = [path for path in (ROOT / "nao_kin" / "cli" / "samples").rglob("*") if path.is_file()]
    assert {str(path.relative_to(ROOT)) for path in samples} <= names
    assert "nao_kin/py.typed" in names
    assert not [name for name in names if name.startswith(("tests", "scripts", "urdf"))]


def test_the_wheel_names_what_others_wrote(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        (name,) = (name for name in archive.namelist() if "/sboms/" in name)
        bill = json.loads(archive.read(name))
        page = archive.read("nao_kin/viewer/page/page.js").decode("utf-8")
    assert name.endswith(".dist-info/sboms/bundled.cdx.json")
    sources = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "web" / "src").rglob("*.ts"))
    imported = set(re.findall(r'^import (?!type )[^"]*"([^./"]+)', sources, re.MULTILINE))
    locked = json.loads((ROOT / "web" / "package-lock.json").read_text(encoding="utf-8"))["packages"]
    found = {part["name"]: (part["version"], part["licenses"][0]["license"]["id"]) for part in bill["components"]}
    expected = {package: locked[f"node_modules/{package}"] for package in imported}
    assert found == {package: (about["version"], about["license"]) for package, about in expected.items()}
    assert all(part in page for part in ("uPlot", "MIT"))


def test_the_package_index_is_told_the_readme_with_whole_addresses(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        (name,) = (name for name in archive.namelist() if name.endswith(".dist-info/METADATA"))
        metadata = archive.read(name).decode("utf-8")
    assert "\nDescription-Content-Type: text/markdown\n" in metadata
    targets = re.findall(r"(!?)\[[^\]]*\]\(([^)]+)\)", metadata)
    ours = {
        "!": "https://raw.githubusercontent.com/nao-kin/nao_kin/main/",
        "": "https://github.com/nao-kin/nao_kin/blob/main/",
    }
    found = {target.removeprefix(ours[sign]) for sign, target in targets if target.startswith(ours[sign])}
    assert found == {"docs/images/view.jpg", "CONTRIBUTING.md"}
    site = "https://nao-kin.github.io/nao_kin/"
    assert {target for _, target in targets if target.startswith(site)} == {f"{site}gallery.html", f"{site}index.html"}
    assert all(target.startswith("https://") for _, target in targets)


def test_it_works_from_another_folder(python: Path, tmp_path: Path) -> None:
    code = (
        "import nao_kin as nk; print(nk.__file__); "
        "print([nk.load_nao(v).nv for v in ('v3.2', 'v3.3', 'v4', 'v5', 'v6')]); print(nk.load_nao().urdf_path)"
    )
    done = subprocess.run([python, "-P", "-c", code], cwd=tmp_path, capture_output=True, text=True, env={})
    if "unknown option -P" in done.stderr.lower():  # Python 3.10
        done = subprocess.run([python, "-c", code], cwd=tmp_path, capture_output=True, text=True, env={})
    assert done.returncode == 0, done.stderr
    module, freedoms, urdf = done.stdout.splitlines()
    home = str(python.parent.parent)
    assert module.startswith(home)
    assert urdf.startswith(home)
    assert freedoms == "[25, 25, 25, 25, 25]"


def test_its_command_works(python: Path, tmp_path: Path) -> None:
    done = subprocess.run(
        [python, "-m", "nao_kin", "fk", "--posture", "Stand", "--frame", "LArm", "--json"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        env={},
    )
    assert done.returncode == 0, done.stderr
    assert '"LArm"' in done.stdout
