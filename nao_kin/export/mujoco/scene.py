"""The scene beside the robot: a floor, light, and a place to look from."""

from __future__ import annotations

from typing import Any
from xml.sax.saxutils import quoteattr

NAME = "scene.xml"


def scene_xml(robot_file: str, model: Any) -> str:
    """A scene that includes the robot's file.

    Args:
        robot_file: name of the file beside it.
        model: the compiled robot, for its size.
    """
    extent = float(model.stat.extent)
    return f"""<mujoco model={quoteattr(f"{robot_file.removesuffix('.xml')} on a floor")}>
  <include file={quoteattr(robot_file)}/>

  <statistic center="0 0 {0.4 * extent:.3g}" extent="{extent:.3g}"/>

  <visual>
    <headlight diffuse="0.4 0.4 0.4" ambient="0.35 0.35 0.35" specular="0 0 0"/>
    <global azimuth="150" elevation="-15" offwidth="1280" offheight="960"/>
    <quality shadowsize="4096"/>
    <map znear="0.01"/>
  </visual>

  <asset>
    <texture name="sky" type="skybox" builtin="gradient" width="256" height="1536"
      rgb1="0.75 0.82 0.9" rgb2="0.95 0.97 1"/>
    <texture name="floor" type="2d" builtin="checker" width="300" height="300"
      rgb1="0.82 0.84 0.86" rgb2="0.74 0.76 0.79"/>
    <material name="floor" texture="floor" texuniform="true" texrepeat="5 5"/>
  </asset>

  <worldbody>
    <light name="sun" pos="0 0 {1.5 * extent:.3g}" dir="0 0 -1" directional="true" diffuse="0.4 0.4 0.4"/>
    <geom name="floor" type="plane" size="0 0 0.05" material="floor"/>
  </worldbody>
</mujoco>
"""
