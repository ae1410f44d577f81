"""Rooms import downwards only."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parent.parent / "nao_kin"

ROOMS = {
    "errors": 1,
    "_arrays": 1,
    "_scalars": 1,
    "_text": 1,
    "_vectors": 1,
    "atomic": 1,
    "files": 1,
    "rotations": 1,
    "lines": 1,
    "rank_one": 1,
    "parameters": 2,
    "urdf_writer": 2,
    "urdf_reader": 2,
    "joints": 3,
    "robot": 3,
    "nao": 3,
    "joint_axes": 3,
    "topology": 3,
    "multidof": 4,
    "typed": 4,
    "configuration_files": 4,
    "installation": 5,
    "crosscheck": 5,
    "viewer": 5,
    "cli": 6,
    "__main__": 6,
    "__init__": 7,
}
MODULES = sorted(PACKAGE.rglob("*.py"))


def _room(module: Path) -> str:
    return module.relative_to(PACKAGE).parts[0].removesuffix(".py")


def _imported(module: Path) -> set[str]:
    """The rooms that a module imports from, at its top or inside its functions."""
    names = set()
    for node in ast.walk(ast.parse(module.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names.add(node.module)
            names |= {f"{node.module}.{alias.name}" for alias in node.names if node.module == "nao_kin"}
    inside = {name.split(".")[1] for name in names if name.startswith("nao_kin.")}
    return {name for name in inside if (PACKAGE / name).exists() or (PACKAGE / f"{name}.py").exists()}


def test_every_module_lives_in_a_known_room() -> None:
    assert {_room(module) for module in MODULES} <= ROOMS.keys()


@pytest.mark.parametrize("module", MODULES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_a_room_imports_only_its_own_and_lower_rooms(module: Path) -> None:
    room = _room(module)
    above = {name for name in _imported(module) if ROOMS[name] > ROOMS[room]}
    assert not above, f"{module.relative_to(PACKAGE)} (room {ROOMS[room]}) imports from above: {above}"


@pytest.mark.parametrize("module", [m for m in MODULES if ROOMS.get(_room(m)) == 1], ids=lambda p: p.stem)
def test_the_mathematics_knows_no_robot_and_no_pinocchio(module: Path) -> None:
    text = module.read_text(encoding="utf-8")
    assert "import pinocchio" not in text
    assert "import scipy" not in text
    assert "from scipy" not in text
