"""Small MJCF files with the traits that models in the wild have, and MuJoCo's own answers about them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import nao_kin as nk
from nao_kin.rotations import matrix_from_euler, quat_from_matrix

BOX = '<geom type="box" size=".05 .02 .03" mass="0.4"/>'

SAMPLES = {
    "degrees and classes": f"""
      <compiler angle="degree" eulerseq="zyx"/>
      <default>
        <joint damping="0.3" range="-20 80"/>
        <default class="leg"><joint axis="0 1 0" range="-90 45"/>
          <default class="foot"><joint axis="1 2 -1"/></default></default>
      </default>
      <worldbody><body name="base">{BOX}
        <body name="thigh" childclass="leg" pos="0 .1 -.2" euler="30 20 -10"><joint name="hip"/>{BOX}
          <body name="foot" pos="0 0 -.3" axisangle="1 1 0 40"><joint name="ankle" class="foot"/>{BOX}</body></body>
        <body name="arm" pos="0 -.1 .2" xyaxes="0 1 0 -1 0 1"><joint name="elbow" axis="0 0 -2"/>{BOX}</body>
      </body></worldbody>""",
    "several joints in one body": f"""
      <worldbody><body name="pelvis" pos="0 0 1"><freejoint name="free"/>{BOX}
        <body name="thigh" pos=".1 0 0" quat=".9 .1 .3 -.2">
          <joint name="hip_x" axis="1 0 0" pos="0 0 .05"/><joint name="hip_z" axis="0 0 1" pos="0 .02 .05"/>
          <joint name="hip_y" axis="0 1 1" pos=".01 0 .05" ref="0.3"/>{BOX}
          <body name="shin" pos="0 0 -.4"><joint name="knee" axis="0 -1 0" pos="0 0 .02" ref="-0.2"/>
            <joint name="stretch" type="slide" axis="0 0 1" ref="0.1" range="-.2 .3" limited="true"/>{BOX}</body>
        </body></body></worldbody>""",
    "joints on the world": f"""
      <worldbody><geom type="plane" size="1 1 1"/>
        <body name="cart" pos=".2 0 .5" euler="0.1 0.2 0.3"><joint name="x" type="slide" axis="1 0 0"/>
          <joint name="y" type="slide" axis="0 1 0" pos="3 4 5"/><joint name="yaw" axis="0 0 1" pos=".5 0 0"/>{BOX}
          <site name="top" pos="0 0 .1" euler="1 0 0"/></body>
        <body name="table" pos="1 1 0">{BOX}</body></worldbody>""",
    "ball joints": f"""
      <worldbody><body name="base">{BOX}<body name="arm" pos=".1 .2 .3" euler=".3 0 .2">
        <joint name="shoulder" type="ball" pos="-.1 0 .02" range="0 1.2" limited="true"/>{BOX}
        <body name="hand" pos=".3 0 0"><joint name="slide" type="slide" axis="1 0 0" range="0 .1"/>
          <joint name="wrist" type="ball"/>{BOX}</body></body></body></worldbody>""",
    "frames, copies and no names": f"""
      <worldbody><body name="hub">{BOX}<frame pos="0 0 .1" euler=".4 0 0">
        <replicate count="3" euler="0 0 1.2" offset=".01 0 0">
        <body name="finger" pos=".1 0 0"><joint name="f" axis="0 1 0" range="0 1"/>{BOX}
          <body pos=".1 0 0"><joint axis="0 1 0"/>{BOX}</body></body></replicate></frame></body></worldbody>""",
    "couplings": f"""
      <worldbody><body name="base">{BOX}
        <body name="a" pos=".1 0 0"><joint name="A" axis="0 1 0" range="-1 1" ref=".1"/>{BOX}
          <body name="b" pos=".1 0 0"><joint name="B" axis="0 0 1" ref="-.2"/>{BOX}</body></body>
        <body name="c" pos="0 .1 0"><joint name="C" axis="1 0 0"/>{BOX}</body>
        <body name="d" pos="0 .2 0"><joint name="D" axis="1 0 0" ref=".5"/>{BOX}</body></body></worldbody>
      <equality><joint joint1="B" joint2="A" polycoef=".05 -2 0 0 0"/>
        <joint joint1="C" joint2="B" polycoef="0 .5 0 0 0"/>
        <joint joint1="D" polycoef=".25 0 0 0 0"/></equality>""",
}


def write(folder: Path, inside: str, name: str = "robot.xml") -> Path:
    path = folder / name
    if "<compiler" not in inside:
        inside = f'<compiler angle="radian"/>{inside}'  # degrees are the default
    path.write_text(f'<mujoco model="sample">{inside}</mujoco>', encoding="utf-8")
    return path


class Mujoco:
    """A file loaded by MuJoCo, to compare with."""

    def __init__(self, path: Path) -> None:
        import mujoco

        self.mujoco, self.model = mujoco, mujoco.MjModel.from_xml_path(str(path))
        self.data: Any = mujoco.MjData(self.model)

    def set(self, values: dict[str, float], base: np.ndarray | None = None) -> None:
        """Take joint values by name, and the pose of a free base as position and quaternion (scalar first)."""
        model, qpos = self.model, np.array(self.model.qpos0)
        for joint in range(model.njnt):
            name, first, kind = model.joint(joint).name, model.jnt_qposadr[joint], model.jnt_type[joint]
            if kind == 0 and base is not None:
                qpos[first : first + 7] = base
            elif kind == 1:
                R = matrix_from_euler([values[f"{name}_{axis}"] for axis in "xyz"], "xyz", axes="moving")
                qpos[first : first + 4] = quat_from_matrix(R)
            elif kind > 1:
                body = model.body(model.jnt_bodyid[joint]).name or f"body_{model.jnt_bodyid[joint]}"
                qpos[first] = values.get(name or f"{body}_joint", qpos[first])
        self.data.qpos[:] = qpos
        self.mujoco.mj_fwdPosition(model, self.data)

    def pose(self, kind: str, name: str | int) -> np.ndarray:
        where = getattr(self.data, {"camera": "cam"}.get(kind, kind))(name)
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = where.xmat.reshape(3, 3), where.xpos
        return T

    def bodies(self) -> dict[str, np.ndarray]:
        """Return T_world_body of all bodies, by the robot's names."""
        names = {body: self.model.body(body).name or f"body_{body}" for body in range(1, self.model.nbody)}
        return {name: self.pose("body", body) for body, name in names.items()}


def all_values(robot: nk.RobotModel, q: np.ndarray) -> dict[str, float]:
    """Return the values of all joints by name, including mimic joints."""
    values = {name: float(value) for name, value in robot.angles(q).items()}
    return values | {name: float(mimic.value(values[mimic.joint])) for name, mimic in robot.mimics.items()}
