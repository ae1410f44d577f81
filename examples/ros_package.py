"""A package for ROS 2.

Learn how to export a robot as a package for RViz and MoveIt.
"""

import tempfile
from pathlib import Path

import nao_kin as nk

with tempfile.TemporaryDirectory() as temporary:
    done = nk.export.ros2(
        nk.load_nao(),
        Path(temporary) / "nao_description",
        package="nao_description",
        maintainer="Ada Lovelace <ada@example.org>",
        meshes="none",
        samples=200,  # configurations tested for collisions; use 10 000 for your own package
    )
    files = sorted(file.relative_to(temporary) for file in done.files)
    for file in files:
        print(file.as_posix())
    urdf = next(file for file in done.files if file.suffix == ".urdf")
    robot = nk.RobotModel.from_urdf(urdf)

print(f"{robot.name} has ROS's names: {', '.join(name for name in robot.link_names if name.startswith('l_'))}")
