"""A robot of your own.

Learn how to load any URDF with its couplings and limits: a lamp whose head is kept level by a coupling.
"""

import sys
import tempfile
from pathlib import Path

import nao_kin as nk

LAMP = """<robot name="lamp">
  <material name="dark"><color rgba="0.2 0.25 0.35 1"/></material>
  <material name="red"><color rgba="0.8 0.3 0.15 1"/></material>
  <link name="base"><visual><geometry><cylinder radius="0.08" length="0.03"/></geometry>
    <material name="dark"/></visual></link>
  <link name="arm"><visual><origin xyz="0 0 0.15"/><geometry><box size="0.02 0.03 0.3"/></geometry>
    <material name="dark"/></visual></link>
  <link name="head"><visual><origin xyz="0.1 0 0"/><geometry><box size="0.2 0.03 0.02"/></geometry>
    <material name="dark"/></visual></link>
  <link name="shade"><visual><origin xyz="0 0 -0.04"/>
    <geometry><cylinder radius="0.05" length="0.08"/></geometry><material name="red"/></visual></link>
  <joint name="lean" type="revolute"><parent link="base"/><child link="arm"/>
    <axis xyz="0 1 0"/><limit lower="-0.6" upper="0.9" effort="1" velocity="1"/></joint>
  <joint name="reach" type="revolute"><parent link="arm"/><child link="head"/><origin xyz="0 0 0.3"/>
    <axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/>
    <mimic joint="lean" multiplier="-1"/></joint>
  <joint name="tilt" type="revolute"><parent link="head"/><child link="shade"/><origin xyz="0.2 0 0"/>
    <axis xyz="0 1 0"/><limit lower="-0.8" upper="0.8" effort="1" velocity="1"/></joint>
</robot>"""

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
with tempfile.TemporaryDirectory() as temporary:
    path = Path(temporary) / "lamp.urdf"
    path.write_text(LAMP)
    lamp = nk.RobotModel.from_urdf(path)
    print(f"{lamp.name} moves by {', '.join(lamp.joint_names)}; reach follows {lamp.mimics['reach'].joint}")
    for lean in (-0.5, 0.0, 0.5):
        x, _, z = lamp.position(lamp.configuration({"lean": lean, "tilt": 0.2}), "shade")
        print(f"lean {lean:4.1f} rad: the shade is at x = {x:.3f} m, z = {z:.3f} m")
    try:
        lamp.configuration({"lien": 0.5})
    except nk.NaoKinError as error:
        print(error)

    viewer = nk.Viewer(lamp)
    viewer.display(lamp.configuration({"lean": 0.4, "tilt": 0.2}))
    viewer.show_ghosts(lamp.configuration({"lean": -0.4, "tilt": 0.2}))
    print("see", viewer.save_html(folder / "own_urdf.html", overwrite=True))
