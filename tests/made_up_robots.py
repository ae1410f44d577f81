"""Small robots made up joint by joint: every link with a mass, an inertia and a centre of mass of its own."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

import nao_kin as nk


@dataclass(frozen=True)
class J:
    """A joint of a made-up robot; it moves the link `name`_l."""

    name: str
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    xyz: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rpy: tuple[float, float, float] = (0.0, 0.0, 0.0)
    kind: str = "revolute"
    parent: str = ""
    follows: tuple[str, float, float] | None = None
    limits: tuple[float, float] = (-3.0, 3.0)


def made_up(folder: Path, *joints: J, base: str = "fixed", chain: bool = True) -> nk.RobotModel:
    """The robot; with `chain`, a joint without a parent hangs on the one before it, else on the base."""
    rng = np.random.default_rng(len(joints))
    parts, before = [_link("base", rng)], "base"
    for joint in joints:
        parent = f"{joint.parent}_l" if joint.parent and joint.parent != "base" else joint.parent or before
        follows = ""
        if joint.follows:
            driver, multiplier, offset = joint.follows
            follows = f'<mimic joint="{driver}" multiplier="{multiplier!r}" offset="{offset!r}"/>'
        limit = f'<limit lower="{joint.limits[0]!r}" upper="{joint.limits[1]!r}" effort="5" velocity="2"/>'
        parts.append(
            f'<joint name="{joint.name}" type="{joint.kind}"><parent link="{parent}"/><child link="{joint.name}_l"/>'
            f'<origin xyz="{_text(joint.xyz)}" rpy="{_text(joint.rpy)}"/><axis xyz="{_text(joint.axis)}"/>'
            f"{limit if joint.kind != 'continuous' else ''}{follows}</joint>"
        )
        parts.append(_link(f"{joint.name}_l", rng))
        before = f"{joint.name}_l" if chain else "base"
    path = folder / "robot.urdf"
    path.write_text(f'<robot name="made_up">{"".join(parts)}</robot>', encoding="utf-8")
    return nk.RobotModel.from_urdf(path, base=base)


def _link(name: str, rng: np.random.Generator) -> str:
    mass, centre = float(rng.uniform(0.5, 2.0)), rng.uniform(-0.1, 0.1, 3)
    a, b, c = rng.uniform(0.01, 0.02, 3).tolist()
    return (
        f'<link name="{name}"><inertial><origin xyz="{_text(centre)}"/><mass value="{mass!r}"/>'
        f'<inertia ixx="{a!r}" iyy="{b!r}" izz="{c!r}" ixy="0.001" ixz="-0.002" iyz="0.001"/></inertial></link>'
    )


def _text(vector: object) -> str:
    return " ".join(repr(float(value)) for value in vector)
