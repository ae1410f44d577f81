"""The texts of a ROS 2 package that describes a robot: what is needed to build it, and to look at it in RViz.

Sources: REP 149 (package.xml, format 3); ament_cmake user documentation; urdf_launch and the ROS 2 tutorials on URDF,
for the nodes; MoveIt, "Time Parameterization", for joint_limits.yaml.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from xml.etree import ElementTree as ET

from nao_kin.urdf import UrdfTree

FOLDERS = ("config", "launch", "meshes", "rviz", "urdf")


def package_xml(name: str, version: str, description: str, maintainer: tuple[str, str], license: str, file: str) -> str:
    """What the package is, for the tools that build and install it.

    Args:
        name: of the package.
        version: three numbers.
        description: one sentence.
        maintainer: name and mail address.
        license: what it is called, best as SPDX does.
        file: name of the file with its text, "" without one.
    """
    root = ET.Element("package", format="3")
    ET.SubElement(root, "name").text = name
    ET.SubElement(root, "version").text = version
    ET.SubElement(root, "description").text = description
    ET.SubElement(root, "maintainer", email=maintainer[1]).text = maintainer[0]
    ET.SubElement(root, "license", {"file": file} if file else {}).text = license
    ET.SubElement(root, "buildtool_depend").text = "ament_cmake"
    nodes = ("joint_state_publisher_gui", "robot_state_publisher", "rviz2")
    for needed in ("ament_index_python", *nodes, "launch", "launch_ros"):
        ET.SubElement(root, "exec_depend").text = needed
    ET.SubElement(ET.SubElement(root, "export"), "build_type").text = "ament_cmake"
    ET.indent(root)
    return '<?xml version="1.0"?>\n' + ET.tostring(root, encoding="unicode") + "\n"


def cmake_lists(name: str, folders: Iterable[str]) -> str:
    """How the package is built: its folders are copied to where packages find each other's files."""
    return f"""cmake_minimum_required(VERSION 3.8)
project({name} NONE)

find_package(ament_cmake REQUIRED)

install(DIRECTORY {" ".join(folders)}
  DESTINATION share/${{PROJECT_NAME}})

ament_package()
"""


def display_launch(name: str, urdf: str, rviz: str) -> str:
    """A launch file: the robot's frames from joint values, sliders for these, and RViz."""
    return f'''"""Show the robot in RViz, with a slider for each joint."""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue


def generate_launch_description():
    """The nodes; sliders:=false leaves /joint_states to somebody else, rviz:=false shows nothing."""
    share = Path(get_package_share_directory("{name}"))
    description = (share / "urdf" / "{urdf}").read_text(encoding="utf-8")
    return LaunchDescription(
        [
            DeclareLaunchArgument("sliders", default_value="true", description="Publish joint values from sliders."),
            DeclareLaunchArgument("rviz", default_value="true", description="Open RViz."),
            Node(
                package="robot_state_publisher",
                executable="robot_state_publisher",
                # Not read as YAML, which an XML text may by chance be.
                parameters=[{{"robot_description": ParameterValue(description, value_type=str)}}],
            ),
            Node(
                package="joint_state_publisher_gui",
                executable="joint_state_publisher_gui",
                parameters=[str(share / "config" / "joint_state_publisher.yaml")],
                condition=IfCondition(LaunchConfiguration("sliders")),
            ),
            Node(
                package="rviz2",
                executable="rviz2",
                arguments=["-d", str(share / "rviz" / "{rviz}")],
                condition=IfCondition(LaunchConfiguration("rviz")),
            ),
        ]
    )
'''


def rviz_config(root: str, focus: tuple[float, float, float], distance: float) -> str:
    """A view for RViz: the robot, its frames switched off, a grid, and a camera in front of it.

    Args:
        root: the frame that stands still.
        focus: what the camera looks at, in that frame [m].
        distance: of the camera from it [m].
    """
    x, y, z = (f"{value:.4g}" for value in focus)
    frame = json.dumps(root)
    return f"""Panels:
  - Class: rviz_common/Displays
    Name: Displays
  - Class: rviz_common/Views
    Name: Views
Visualization Manager:
  Class: ""
  Displays:
    - Class: rviz_default_plugins/Grid
      Name: Grid
      Cell Size: 0.1
      Plane Cell Count: 20
      Reference Frame: <Fixed Frame>
      Enabled: true
      Value: true
    - Class: rviz_default_plugins/RobotModel
      Name: RobotModel
      Description Source: Topic
      Description Topic:
        Value: /robot_description
        Durability Policy: Transient Local
        Reliability Policy: Reliable
        History Policy: Keep Last
        Depth: 5
      Visual Enabled: true
      Collision Enabled: false
      Enabled: true
      Value: true
    - Class: rviz_default_plugins/TF
      Name: TF
      Marker Scale: 0.1
      Show Names: false
      Enabled: false
      Value: false
  Enabled: true
  Global Options:
    Background Color: 48; 48; 48
    Fixed Frame: {frame}
    Frame Rate: 30
  Name: root
  Tools:
    - Class: rviz_default_plugins/MoveCamera
    - Class: rviz_default_plugins/Select
    - Class: rviz_default_plugins/FocusCamera
    - Class: rviz_default_plugins/Measure
  Value: true
  Views:
    Current:
      Class: rviz_default_plugins/Orbit
      Name: Current View
      Target Frame: <Fixed Frame>
      Value: Orbit (rviz)
      Distance: {distance:.4g}
      Focal Point:
        X: {x}
        Y: {y}
        Z: {z}
      Near Clip Distance: 0.01
      Pitch: 0.3
      Yaw: 0.5
Window Geometry:
  Width: 1200
  Height: 800
"""


def joint_limits(tree: UrdfTree) -> str:
    """Largest speeds for MoveIt; accelerations, which a URDF does not have, are left open."""
    lines = [
        "# For MoveIt. has_acceleration_limits: false until somebody measures them.",
        "default_velocity_scaling_factor: 0.1",
        "default_acceleration_scaling_factor: 0.1",
        "joint_limits:",
    ]
    own = [joint for joint in tree.moving_joints if joint.mimic is None]
    for joint in own:
        limited = math.isfinite(joint.velocity) and joint.velocity > 0.0
        lines += [
            f"  {json.dumps(joint.name)}:",
            f"    has_velocity_limits: {'true' if limited else 'false'}",
            f"    max_velocity: {joint.velocity if limited else 0.0!r}",
            "    has_acceleration_limits: false",
            "    max_acceleration: 0.0",
        ]
    return "\n".join(lines) + "\n" if own else lines[0] + "\njoint_limits: {}\n"


def slider_starts(values: Mapping[str, float]) -> str:
    """Where the sliders of joint_state_publisher begin: its parameter `zeros`."""
    lines = ["/**:", "  ros__parameters:", "    zeros:" if values else "    rate: 10"]
    return "\n".join([*lines, *(f"      {json.dumps(name)}: {value!r}" for name, value in values.items())]) + "\n"


def readme(name: str, robot: str) -> str:
    """What to do with the package."""
    return f"""# {name}

Description of the robot {robot}, written by nao_kin.

    cd ~/ros2_ws && colcon build --packages-select {name} && source install/setup.bash
    ros2 launch {name} display.launch.py

Needs ament_cmake, joint_state_publisher_gui, robot_state_publisher and rviz2: `rosdep install --from-paths .`
"""
