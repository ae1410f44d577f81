"""The semantics of a robot: read from a file beside the robot's file, and checked against the robot's tree."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import fields, replace
from pathlib import Path

from nao_kin._core.text import quoted
from nao_kin.errors import BadArgument, BadModel, NaoKinError, nearest_names
from nao_kin.robot.configurations import Coordinates
from nao_kin.robot.semantics import Posture, Semantics, read_semantics
from nao_kin.robot.urdf import UrdfTree, read_srdf


def find_semantics(
    tree: UrdfTree, given: Semantics | Path | str | None, notes: list[str], implied: Semantics | None = None
) -> Semantics:
    """Return the semantics given, or those of the .toml or .srdf file of the same name beside the robot's file.

    `implied` are those in the robot's own file (MJCF), which fill the parts that the other file leaves empty.
    """
    kind, implied = ("URDF", Semantics()) if implied is None else ("MJCF", implied)
    if isinstance(given, Semantics):
        return given
    if given is not None:
        try:
            path = Path(given)
        except TypeError:
            raise BadArgument(
                f"semantics must be a Semantics or the path of a .toml or .srdf file, got {quoted(given)}"
            ) from None
        return _filled(_read(path, tree, notes), implied)
    for ending in (".toml", ".srdf"):
        path = tree.path.with_name(tree.path.name.removesuffix(".xacro")).with_suffix(ending)
        if path.is_file():
            try:
                semantics = checked_semantics(_filled(_read(path, tree, notes), implied), tree)
            except NaoKinError as error:
                # The caller did not name this file, so an error in it does not keep the robot from loading.
                notes.append(f"{path.name} beside the {kind} is not used: {error}")
            else:
                notes.append(f"chains, effectors and postures from {path.name} beside the {kind}")
                return semantics
    return implied


def _filled(semantics: Semantics, implied: Semantics) -> Semantics:
    """Return the semantics, with their empty parts taken from `implied`."""
    empty = Semantics()
    blank = {field.name for field in fields(Semantics) if getattr(semantics, field.name) == getattr(empty, field.name)}
    filled = replace(semantics, **{name: getattr(implied, name) for name in blank})
    return replace(filled, start="") if "start" in blank and filled.start not in filled.postures else filled


def _read(path: Path, tree: UrdfTree, notes: list[str]) -> Semantics:
    if path.suffix.lower() != ".srdf":
        return read_semantics(path)
    semantics, postures = read_srdf(path, tree, notes), dict[str, Posture]()
    coordinates = _coordinates(tree)
    for name, posture in semantics.postures.items():
        try:
            _check_posture(posture, coordinates)
            postures[name] = posture
        except NaoKinError as error:
            notes.append(f"group state {quoted(name)} of {path.name} is left out: {error}")
    return replace(semantics, postures=postures)


def _coordinates(tree: UrdfTree) -> Coordinates:
    own = tuple([joint.name for joint in tree.moving_joints if joint.mimic is None])
    return Coordinates(own, tree.mimics)


def _check_posture(posture: Posture, coordinates: Coordinates) -> None:
    """Raise an error for a posture whose values are not one number for each joint, or contradict a mimic."""
    if coordinates.plain_values(dict(posture.angles)) is None:
        values, _ = coordinates.values(posture.angles)
        if values.ndim != 1:
            raise BadArgument("expected one number for each joint")


def checked_semantics(semantics: Semantics, tree: UrdfTree) -> Semantics:
    """Return the semantics; `BadModel` for missing joints, frames or postures, or conflicts with shared motors."""
    moving, mimics = [joint.name for joint in tree.moving_joints], tree.mimics
    _check(semantics.joints(), moving, "joint", tree)
    _check(semantics.frames(), {*moving, *tree.links, *tree.shared_names}, "frame", tree)
    if semantics.start and semantics.start not in semantics.postures:
        raise BadModel(
            f"semantics of {tree.name}: start names the posture {quoted(semantics.start)}, which does not exist"
        )
    coordinates = _coordinates(tree)
    for name, posture in semantics.postures.items():
        try:
            _check_posture(posture, coordinates)
        except NaoKinError as error:
            raise BadModel(f"semantics of {tree.name}: posture {quoted(name)}: {error}") from None
    for table in semantics.coupled_limits:
        for name in (table.joint, table.of):
            if name in mimics:
                raise BadModel(
                    f"semantics of {tree.name}: a coupled limit names {quoted(name)}, which follows another joint"
                )
    return semantics


def _check(named: Mapping[str, tuple[str, str]], valid: Collection[str], kind: str, tree: UrdfTree) -> None:
    known = set(valid)
    for name, (part, its_name) in named.items():
        if name not in known:
            where = f"{part} {quoted(its_name)}" if its_name else part
            near = ", ".join(nearest_names(name, valid))
            advice = f" (nearest: {near})" if near else ""
            fixed = "is fixed" if kind == "joint" else "is a fixed joint"
            why = fixed if name in tree.fixed_joints else "does not exist"
            raise BadModel(f"semantics of {tree.name}: {where} names the {kind} {quoted(name)}, which {why}{advice}")
