"""A posture, and joints by name.

Learn how to make a configuration: from a posture, from a posture with some joints changed, or from a posture with
values for a whole chain.
"""

import sys
from pathlib import Path

import nao_kin as nk

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
nao = nk.load_nao()

stand = nao.posture("Stand")
looking = nao.posture("Stand", HeadYaw=0.5, HeadPitch=0.2)
# The name of a chain takes values for its joints, from the trunk outwards.
pointing = nao.posture("Stand", HeadYaw=0.5, HeadPitch=-0.2, LArm=[-0.3, 0.4, -1.2, -0.1, 0.0, 0.8])

print("LArm is", ", ".join(nao.chains["LArm"]))
for name, q in {"stand": stand, "looking": looking, "pointing": pointing}.items():
    x, y, z = nao.position(q, "LArm")
    print(f"{name:8}  head {nao.angles(q)['HeadYaw']:4.1f} rad, left hand at ({x:.3f}, {y:.3f}, {z:.3f}) m")

viewer = nk.Viewer(nao)
viewer.display(pointing)
viewer.show_ghosts(stand)
print("see", viewer.save_html(folder / "posture_and_joints.html", overwrite=True))
