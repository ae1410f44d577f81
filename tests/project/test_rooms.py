"""Packages import only from lower ones, and only through their `__init__` modules."""

from __future__ import annotations

import ast
import functools
import importlib
import re
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path
from types import ModuleType

import pytest
from public_names import TOP
from syntax import statements

import nao_kin

PACKAGE = Path(nao_kin.__file__).parent

# From below; rooms of one floor do not import each other. `errors` is what the room `_core` shows of itself.
FLOORS = (
    ("_core", "errors"),
    ("_kernels",),
    ("rotations",),
    ("screws",),
    ("robot",),
    ("joints", "world"),
    ("ik",),
    ("stream",),
    ("motion", "reach", "calibration"),
    ("crosscheck", "export", "imitation", "naoqi", "viewer"),
    ("cli",),
    ("__init__", "__main__"),
)
FLOOR = {room: height for height, rooms in enumerate(FLOORS) for room in rooms}
# Inside `robot`, likewise; its own modules are "robot".
INSIDE_ROBOT = {"semantics": 0, "urdf": 1, "robot": 2, "nao": 3}
# Rooms inside others that have faces of their own.
INNER_FACES = ("robot.nao", "robot.semantics", "robot.urdf", "rotations.rank_one", "screws.lines", "stream.distributed")
# The machine rooms have no face that hides anything.
OPEN = ("_core", "_kernels")
MODULES = sorted(PACKAGE.rglob("*.py"))


def _parts(module: Path) -> tuple[str, ...]:
    parts = module.relative_to(PACKAGE).with_suffix("").parts
    return parts[:-1] if parts[-1] == "__init__" and len(parts) > 1 else parts


# Modules inside the package by the names under which they are imported.
NAMES = {".".join(("nao_kin", *_parts(module))): ".".join(_parts(module)) for module in MODULES}


@functools.cache
def _import_statements(module: Path) -> list[ast.Import | ast.ImportFrom]:
    """Return the imports of a module: at its top, inside functions, and for types."""
    tree = ast.parse(module.read_text(encoding="utf-8"))
    return [node for node in statements(tree) if isinstance(node, (ast.Import, ast.ImportFrom))]


def _imports(module: Path) -> Iterator[tuple[str, ...]]:
    """Return the imports of a module from the package, such as ("robot", "urdf")."""
    for node in _import_statements(module):
        names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        if isinstance(node, ast.ImportFrom) and node.module:
            names = [node.module]
            if node.module == "nao_kin":
                names = [f"nao_kin.{alias.name}" for alias in node.names]
        for name in names:
            if name.startswith("nao_kin."):
                yield tuple(name.split(".")[1:])


def _rooms() -> set[str]:
    return {_parts(module)[0] for module in MODULES}


def test_every_module_lives_in_a_known_room() -> None:
    assert _rooms() == FLOOR.keys()


def test_a_room_imports_only_lower_rooms() -> None:
    upwards = []
    for module in MODULES:
        room = _parts(module)[0]
        for other, *_ in _imports(module):
            same = other == room or {other, room} == {"_core", "errors"}
            if not same and FLOOR.get(other, -1) >= FLOOR[room]:
                upwards.append(f"{module.relative_to(PACKAGE)} imports {other}")
    assert not upwards


def test_a_product_imports_only_the_products_that_it_needs() -> None:
    page = (PACKAGE.parent / "docs" / "architecture.md").read_text(encoding="utf-8")
    table = page.split("## Products and their budgets")[1].split("\n## ")[0]
    rows = {
        name: (re.findall(r"`nao_kin/(\w+)", rooms), allowed)
        for name, rooms, allowed in re.findall(r"^\| (\w[\w ]*) \| (`nao_kin.*?) \|[^|]*\| (.*?) \|", table, re.M)
    }
    product = {room: name for name, (rooms, _) in rows.items() for room in rooms}
    assert product.keys() == _rooms()
    wrong = set[str]()
    for module in MODULES:
        room = _parts(module)[0]
        allowed = rows[product[room]][1]
        for other, *_ in _imports(module):
            fine = other in product and (product[other] in (product[room], "core") or f"`{other}`" in allowed)
            if not fine and allowed != "all" and room not in ("__init__", "__main__"):
                wrong.add(f"{room} imports {other}")
    assert not wrong


def test_no_module_loads_an_upper_room_by_its_name() -> None:
    """A text such as "nao_kin.ik", which `importlib` could import, names a room of the same floor or below."""
    upwards = []
    for module in MODULES:
        room = _parts(module)[0]
        for name in re.finditer(r"[\"']nao_kin\.(\w+)[.\w]*[\"']", module.read_text(encoding="utf-8")):
            if name[1] != room and FLOOR.get(name[1], -1) >= FLOOR[room]:
                upwards.append(f"{module.relative_to(PACKAGE)} names {name[0]}")
    assert not upwards


def test_inside_the_robot_imports_go_downwards_too() -> None:
    upwards = []
    for module in (PACKAGE / "robot").rglob("*.py"):
        parts = _parts(module)
        if len(parts) == 1:  # the face shows what is above, too
            continue
        own = parts[1] if parts[1] in INSIDE_ROBOT else "robot"
        for other in _imports(module):
            if other[0] == "robot":
                inner = other[1] if len(other) > 1 and other[1] in INSIDE_ROBOT else "robot"
                if INSIDE_ROBOT[inner] > INSIDE_ROBOT[own]:
                    upwards.append(f"{module.relative_to(PACKAGE)} imports {'.'.join(other)}")
    assert not upwards


def test_a_room_is_entered_through_its_face() -> None:
    past = []
    for module in MODULES:
        parts = _parts(module)
        for other in _imports(module):
            at_home = other[0] == parts[0] or other[0] in OPEN or parts[0] == "__init__"
            if len(other) > 1 and not at_home and ".".join(other) not in INNER_FACES:
                past.append(f"{module.relative_to(PACKAGE)} imports {'.'.join(other)}")
    assert not past


def _modules_imported(module: Path) -> set[str]:
    """Return the modules of the package that a module imports."""
    found = set()
    for node in _import_statements(module):
        if isinstance(node, ast.Import):
            found |= {NAMES.get(alias.name) for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found |= {NAMES.get(f"{node.module}.{alias.name}", NAMES.get(node.module)) for alias in node.names}
    return {name for name in found if name}


@pytest.mark.parametrize("room", sorted({_parts(module)[0] for module in MODULES}))
def test_the_modules_of_a_room_do_not_import_each_other_in_a_circle_even_for_types(room: str) -> None:
    graph = {".".join(_parts(module)): _modules_imported(module) for module in MODULES if _parts(module)[0] == room}
    try:
        TopologicalSorter({name: imported & graph.keys() for name, imported in graph.items()}).prepare()
    except CycleError as error:
        pytest.fail(" ← ".join(error.args[1]))


def test_the_mathematics_knows_no_robot_and_no_pinocchio() -> None:
    for room in ("_core", "_kernels", "rotations", "screws"):
        for module in (PACKAGE / room).rglob("*.py"):
            text = module.read_text(encoding="utf-8")
            for word in ("import pinocchio", "import scipy", "from scipy"):
                assert word not in text, f"{module.relative_to(PACKAGE)}: {word}"


def test_everything_public_is_listed_in_one_place_and_documented() -> None:
    rooms = {room for room in _rooms() if not room.startswith("_")}
    assert rooms <= set(TOP)
    pages = "".join(
        page.read_text(encoding="utf-8") for page in sorted((PACKAGE.parent / "docs" / "reference").glob("*.md"))
    )
    for name in TOP:
        value = getattr(nao_kin, name)
        listed = value.__name__ if isinstance(value, ModuleType) else f"nao_kin.{name}"
        assert listed in pages, f"docs/reference says nothing about {listed}"


def test_a_public_room_lists_what_it_offers() -> None:
    for name in TOP:
        value = getattr(nao_kin, name)
        if not isinstance(value, ModuleType):
            continue
        assert list(value.__all__) == sorted(value.__all__, key=lambda n: (not n.isupper(), not n[0].isupper(), n)), (
            name
        )
        assert all(hasattr(value, entry) for entry in value.__all__), name
        if hasattr(value, "__path__") and name != "cli":
            face = Path(value.__file__ or "")
            imported = {
                alias.asname or alias.name: alias.asname
                for node in ast.parse(face.read_text(encoding="utf-8")).body
                if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("nao_kin")
                for alias in node.names
            }
            for_other_rooms = {entry for entry, again in imported.items() if again == entry}
            assert for_other_rooms.isdisjoint(value.__all__), name
            others = {n for n in imported if not n.startswith("_") and not isinstance(getattr(value, n), ModuleType)}
            unlisted = others - set(value.__all__) - for_other_rooms
            assert not unlisted, f"{name}: {unlisted}"


# Names that a room gives to other rooms without listing them as public, and why. There may be fewer, never more.
FOR_OTHER_ROOMS = {
    "ik.descended_along": "the virtual NAO descends along the axes of a mask, which no public solver does",
    "motion.is_motion_file": "the command line asks it before it reads a file as configurations",
    "robot.Feet": "soles, their outlines and contacts: world, viewer, imitation and the virtual NAO stand on them",
    "robot.Kinematics": "the seam of poses, of which the model with spherical joints makes a second one",
    "robot.LinkShapes": "an SRDF is proved with the exact shapes",
    "robot.ModelNumbers": "caches of inverse kinematics notice changes of Pinocchio's model",
    "robot.OutsideRows": "resumable files keep which rows are outside the limits",
    "robot.capsules": "an MJCF has the capsules of the collision shapes",
    "robot.read_mesh": "viewer and exports read meshes as the collisions do",
    "screws.pose_of": "poses in files, as a matrix or six numbers",
    "screws.refuse_not_rigid": "the check of poses, with the names of the caller's arguments",
    "screws.rigid_poses": "the same, with the nearest rotation",
    "stream.PoseColumns": "the command line prints the columns that files have",
    "stream.log_columns": "the command line tells a table of whole configurations from a motion",
    "stream.unit_note": "the unit of a motion that the command line reads is doubted as that of a log",
    "world.outside_image": "one message for pixels that are in no image",
    "world.standing_sole": "the virtual NAO stands on the sole that the state of a log would name",
}


def test_names_for_other_rooms_are_listed_with_their_reasons() -> None:
    given = {
        f"{face.parent.name}.{name}"
        for face in PACKAGE.glob("*/__init__.py")
        for name in re.findall(r"\b(\w+) as \1\b", face.read_text(encoding="utf-8"))
    }
    assert given == FOR_OTHER_ROOMS.keys()
    assert all(FOR_OTHER_ROOMS.values())


@pytest.mark.filterwarnings("ignore::DeprecationWarning:pyparsing")  # of matplotlib 3.9
@pytest.mark.filterwarnings("ignore::DeprecationWarning:matplotlib")
def test_no_module_takes_the_place_of_a_public_name() -> None:
    for module in MODULES:
        if module.stem != "__main__":
            try:
                importlib.import_module(".".join(("nao_kin", *_parts(module))).removesuffix(".__init__"))
            except ModuleNotFoundError as error:
                if error.name != "qi":  # for which not every Python has a wheel
                    raise
    taken = [
        f"{name}.{entry}"
        for name in TOP
        if isinstance(room := getattr(nao_kin, name), ModuleType)
        for entry in room.__all__
        if isinstance(getattr(room, entry), ModuleType)
    ]
    assert not taken
