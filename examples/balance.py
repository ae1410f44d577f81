"""How far a NAO is from tipping.

Learn how to place a robot on the floor, and how to compute the distance of its centre of mass from the edge of its
support polygon.
"""

import sys
from pathlib import Path

import numpy as np

import nao_kin as nk

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
nao = nk.load_nao()

for name in nao.posture_names:
    found = nk.world.balance(nao, nao.posture(name))
    touching = [link for link, on in zip(nao.link_names, found.down.links, strict=True) if on]
    print(
        f"{name:10} margin {1000 * found.margin:3.0f} mm, tips at {np.degrees(found.tilts.min()):4.1f}°, "
        f"rests on {', '.join(touching[:3])}{' …' * (len(touching) > 3)}"
    )

# Bend forward at the hips until the centre of mass is above the toes.
bend = np.linspace(0.0, -1.4, 57)
q = nao.configuration(nao.angles(nao.posture("StandZero")) | {"LHipPitch": bend, "RHipPitch": bend}, limits="ignore")
margins = nk.world.margin(nao, q)  # both soles stay on the floor
last = int(np.flatnonzero(margins > 0.01)[-1])
print(f"with the hips at {np.degrees(bend[last]):.0f}° the margin is {1000 * margins[last]:.0f} mm")

viewer = nk.Viewer(nao)
viewer.display(q[last])
viewer.show_com()
viewer.show_support_polygon()
print("see", viewer.save_html(folder / "balance.html", overwrite=True))
