"""A lecture on lower pairs.

Learn which of Reuleaux's pairs a NAO is made of, when hinges whose axes meet count as one joint, and why 26 make 25.
"""

import sys
from pathlib import Path

import nao_kin as nk
from nao_kin.joints import KINEMATIC_PAIRS, group_joints, mobility

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
print("pair          symbol  freedoms  constraints  lower")
for name, pair in KINEMATIC_PAIRS.items():
    print(f"{name:13} {pair.symbol:^6} {pair.freedoms:8} {pair.constraints:11}    {'yes' if pair.lower else 'no'}")

nao = nk.load_nao()
groups = group_joints(nao)
print()
print("a NAO as its file has it:", mobility(["revolute"] * 26, couplings=1), "degrees of freedom, 26 hinges − 1 motor shared")
print("with hinges merged:     ", groups.summary)
for joint in groups:
    if joint.name[0] != "R":
        print(f"{joint.pair.symbol}  {joint.pair.name:10} {' + '.join(joint.joints)}")

viewer = nk.Viewer(nao)
viewer.display(nao.posture("StandZero"))
viewer.show_joint_axes()
print("see", viewer.save_html(folder / "lower_pairs.html"))
