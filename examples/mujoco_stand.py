"""Stand for a second in MuJoCo.

Learn how to export the robot for a simulator, in which it stands on its own feet.

Needs nao-kin[mujoco].
"""

import sys
import tempfile
from pathlib import Path

import nao_kin as nk

try:
    import mujoco
except ImportError:
    sys.exit("the simulation needs MuJoCo: pip install 'nao-kin[mujoco]'")

nao = nk.load_nao()
with tempfile.TemporaryDirectory() as temporary:
    done = nk.export.mjcf(nao, Path(temporary) / "nao", meshes="none")
    model = mujoco.MjModel.from_xml_path(str(done.path))
print(f"{model.nbody} bodies, {model.nu} motors, {model.nsensor} sensors, {model.body_mass.sum():.3f} kg")

data = mujoco.MjData(model)
mujoco.mj_resetDataKeyframe(model, data, model.key("StandInit").id)
mujoco.mj_forward(model, data)
before = data.body("torso").xpos.copy()
while data.time < 1.0:
    mujoco.mj_step(model, data)
sunk = 1000 * (before[2] - data.body("torso").xpos[2])

on_its_feet = sum(float(data.sensor(f"{name}_force").data[0]) for name in nao.semantics.force_sensors)
print(f"after {data.time:.0f} s the torso has sunk by {sunk:.1f} mm")
print(f"the soles carry {on_its_feet:.1f} N, its weight is {9.81 * nao.mass:.1f} N")
