"""The hip as a ball joint.

Learn how to convert a robot to a model with spherical joints, in which the hip has a quaternion instead of three
angles.
"""

import numpy as np

import nao_kin as nk

nao = nk.load_nao()
typed = nk.joints.MultiDofModel(nao)
q = nao.posture("Sit")
q_typed = typed.from_q(q)

hip = "LHipYawPitch+LHipRoll+LHipPitch"
columns = [nao.joint_names.index(joint) for joint in hip.split("+")]
print("three angles:", np.round(q[columns], 4), "rad")
print("a quaternion:", np.round(q_typed[typed.columns[hip]], 4), "as (x, y, z, w)")

# The spherical joint never locks, but its three hinges do.
lock = nk.joints.group_joints(nao)["LHipRoll"].singularity
print(f"the hinges lock at LHipRoll = {np.degrees(lock.at[0]):.0f}°, {np.degrees(lock.margin):.1f}° outside the limits")

difference = np.abs(typed.fk(q_typed, "LLeg") - nao.fk(q, "LLeg")).max()
print("both models have the foot at the same pose, to 1e-12:", bool(difference < 1e-12))
print("converting back gives the same joint values:", bool(np.allclose(typed.to_q(q_typed), q, atol=1e-9)))
