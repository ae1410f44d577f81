"""Rooms import downwards only."""

from __future__ import annotations

import ast
import importlib
from pathlib import Path
from types import ModuleType

import pytest

import nao_kin

PACKAGE = Path(__file__).resolve().parent.parent / "nao_kin"

# Lower rooms never import higher ones.
ROOMS = {
    "_extras": 1,
    "_text": 1,
    "errors": 1,
    "_common": 1,
    "rotations": 1,
    "lines": 1,
    "screws": 1,
    "rank_one": 1,
    "batch": 2,
    "semantics": 2,
    "urdf": 2,
    "parameters": 2,
    "robot": 3,
    "_nao": 4,
    "joints": 4,
    "configuration_files": 4,
    "multidof": 5,
    "distributed": 5,
    "motion": 5,
    "stream": 5,
    "ik": 6,
    "reach": 6,
    "export": 6,
    "crosscheck": 7,
    "naoqi": 7,
    "viewer": 7,
    "cli": 8,
    "__main__": 8,
    # Former names of rooms.
    "topology": 4,
    "joint_axes": 5,
    "typed": 6,
    "__init__": 9,
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


@pytest.mark.parametrize("module", MODULES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_a_room_is_entered_through_its_face(module: Path) -> None:
    room = _room(module)
    past = set()
    for node in ast.walk(ast.parse(module.read_text(encoding="utf-8"))):
        names = [node.module] if isinstance(node, ast.ImportFrom) and node.module else []
        names += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        parts = [name.split(".") for name in names if name.startswith("nao_kin.")]
        past |= {".".join(p) for p in parts if len(p) > 2 and p[1] not in (room, "_common")}
    assert not past, f"{module.relative_to(PACKAGE)} reaches past the face of a room: {past}"


def test_everything_public_is_listed_in_one_place_and_documented() -> None:
    public = {_room(path) for path in MODULES} - {"__init__", "__main__"}
    public = {name for name in public if not name.startswith("_")}
    assert public <= set(nao_kin.__all__)
    pages = "".join(
        page.read_text(encoding="utf-8") for page in sorted((PACKAGE.parent / "docs" / "reference").glob("*.md"))
    )
    missing = [name for name in nao_kin.__all__ if f"nao_kin.{name}" not in pages]
    assert not missing, f"docs/reference says nothing about {missing}"


@pytest.mark.parametrize("name", sorted(nao_kin.__all__))
def test_a_public_room_lists_what_it_offers(name: str) -> None:
    value = getattr(nao_kin, name)
    if not isinstance(value, ModuleType):
        return
    assert list(value.__all__) == sorted(value.__all__, key=lambda n: (not n.isupper(), not n[0].isupper(), n)), name
    assert all(hasattr(value, entry) for entry in value.__all__)
    if hasattr(value, "__path__"):  # what a face imports and does not list starts with an underscore or is a module
        ours = {n: getattr(v, "__module__", "") for n, v in vars(value).items() if not n.startswith("_")}
        offered = {n for n, home in ours.items() if home.startswith("nao_kin") and not home.startswith("nao_kin._")}
        assert offered <= set(value.__all__), name


def test_no_module_takes_the_place_of_a_public_name() -> None:
    for module in MODULES:
        if module.stem != "__main__":
            try:
                importlib.import_module(".".join(("nao_kin", *module.relative_to(PACKAGE).with_suffix("").parts)))
            except ModuleNotFoundError as error:
                if error.name != "qi":  # for which not every Python has a wheel
                    raise
    taken = [
        f"{name}.{entry}"
        for name in nao_kin.__all__
        if isinstance(room := getattr(nao_kin, name), ModuleType)
        for entry in room.__all__
        if isinstance(getattr(room, entry), ModuleType)
    ]
    assert not taken
