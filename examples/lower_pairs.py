"""A lecture on lower pairs.

Learn which of Reuleaux's pairs a NAO has, when hinges whose axes meet count as one joint, and why 26 hinges give 25
degrees of freedom.
"""

import nao_kin as nk
from nao_kin.joints import KINEMATIC_PAIRS, group_joints, mobility

print("pair          symbol  freedoms  constraints  lower")
for name, pair in KINEMATIC_PAIRS.items():
    print(f"{name:13} {pair.symbol:^6} {pair.freedoms:8} {pair.constraints:11}    {'yes' if pair.lower else 'no'}")

nao = nk.load_nao()
groups = group_joints(nao)
print()
print("26 hinges, of which two share a motor:", mobility(["revolute"] * 26, couplings=1), "degrees of freedom")
print("with hinges merged:", groups.summary)
for joint in groups:
    if joint.name[0] != "R":
        print(f"{joint.pair.symbol}  {joint.pair.name:10} {' + '.join(joint.joints)}")
