"""Which bodies of an MJCF are the robot: files hold floors, tables and things to grasp beside it."""

from __future__ import annotations

from typing import Any

import numpy as np

from nao_kin._text import abbreviated, quoted
from nao_kin.urdf.mjcf.joints import FREE, pose

WORLD = 0


def robot_of(model: Any, notes: list[str]) -> tuple[int, list[int]]:
    """The root body of the robot, and all its bodies in order, the root among them.

    The robot is what moves most: the body of the world with most joints on it. Where that one floats (a free joint), or
    stands still as the only one of the world, it is the root, as in a URDF. Else the world is, and with it come all
    bodies that do not float.

    Args:
        model: the `mujoco.MjModel`.
        notes: gets a line for what is left out.

    Raises:
        ValueError: there are no bodies.
    """
    count, top = int(model.nbody), _tops(model)
    if count < 2:
        raise ValueError("no bodies")
    members: dict[int, list[int]] = {}
    for body in range(1, count):
        members.setdefault(top[body], []).append(body)
    mocap = {body for body in members if int(model.body_mocapid[body]) >= 0}
    candidates = {body: bodies for body, bodies in members.items() if body not in mocap} or members
    joints = {body: sum(int(model.body_jntnum[one]) for one in bodies) for body, bodies in candidates.items()}
    main = max(candidates, key=lambda body: (joints[body] - _floats(model, body), len(candidates[body]), -body))
    standing = [body for body in candidates if not _floats(model, body)]
    if _floats(model, main):
        chosen, root = [main], main
        notes.append(f"body {quoted(_name(model, main))} has a free joint: base='floating' gives it a free base")
    elif standing == [main] and not int(model.body_jntnum[main]):
        chosen, root = standing, main
        _note_place(model, main, notes)
    else:
        chosen, root = standing, WORLD
    left_out = [body for body in members if body not in chosen]
    if left_out:
        names = abbreviated(", ".join(_name(model, body) for body in left_out), 100)
        notes.append(f"left out, for they are not the robot's: {names}")
    bodies = sorted(body for one in chosen for body in members[one])
    return root, bodies if root != WORLD else [WORLD, *bodies]


def _tops(model: Any) -> list[int]:
    """Body → the body of the world that carries it."""
    top = [WORLD]
    for body in range(1, int(model.nbody)):
        parent = int(model.body_parentid[body])
        top.append(body if parent == WORLD else top[parent])
    return top


def _floats(model: Any, body: int) -> bool:
    joint = int(model.body_jntadr[body])
    return joint >= 0 and int(model.jnt_type[joint]) == FREE


def _name(model: Any, body: int) -> str:
    return str(model.body(body).name) or f"body_{body}"


def _note_place(model: Any, body: int, notes: list[str]) -> None:
    """Say where a root stands in the world, which the tree does not keep."""
    T = pose(model.body_pos[body], model.body_quat[body])
    if not np.allclose(T, np.eye(4), atol=1e-12):
        place = " ".join(f"{float(value):.4g}" for value in model.body_pos[body])
        turned = "" if np.allclose(T[:3, :3], np.eye(3), atol=1e-12) else ", turned,"
        notes.append(
            f"{quoted(_name(model, body))} stands at {place}{turned} in the world; poses are given in its own frame"
        )
