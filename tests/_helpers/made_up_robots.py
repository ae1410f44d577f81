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
    """Make the robot; a joint without a parent is fixed to the joint before it with `chain`, else to the base."""
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


_SHAPES = """<robot name="shapes">
  <link name="trunk">
    <visual><origin xyz="0 0 0.1" rpy="0.3 0 0"/><geometry><box size="0.1 0.2 0.3"/></geometry></visual>
    <visual><geometry><mesh filename="wedge.{ending}" scale="0.5 -0.5 0.5"/></geometry></visual>
    <visual><geometry><cylinder radius="0.01" length="0.4"/></geometry></visual>
    <collision><geometry><cylinder radius="0.03" length="0.2"/></geometry></collision>
  </link>
  <link name="arm">
    <visual><geometry><mesh filename="absent.stl"/></geometry></visual>
    <visual><origin xyz="0.1 0 0"/><geometry><sphere radius="0.02"/></geometry></visual>
  </link>
  <joint name="shoulder" type="revolute">
    <parent link="trunk"/><child link="arm"/><origin xyz="0 0.2 0" rpy="0 0.4 0"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/>
  </joint>
</robot>"""


def with_shapes(folder: Path, ending: str) -> nk.RobotModel:
    """A robot of two links with one shape of each kind, a mirrored mesh and a missing mesh."""
    import trimesh

    wedge = trimesh.Trimesh(
        [[0, 0, 0], [0.2, 0, 0], [0, 0.1, 0], [0, 0, 0.3]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    )
    wedge.export(folder / f"wedge.{ending}")
    (folder / "shapes.urdf").write_text(_SHAPES.format(ending=ending))
    return nk.RobotModel.from_urdf(folder / "shapes.urdf")
