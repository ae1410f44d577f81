"""A comparison of all versions.

Learn how the NAO versions from V3.2 to V6 differ, in numbers of the model.
"""

import numpy as np

import nao_kin as nk
from nao_kin.robot.nao import VERSIONS

print("version   mass [kg]   hand reaches   camera above sole   knee turns")
for version in VERSIONS:
    nao = nk.load_nao(version)
    q = nao.posture("StandZero")
    shoulder, hand, sole, camera = nao.position(q, ["LShoulderPitch", "LArm", "LLeg", "CameraTop"])
    lower, upper, _, _ = nk.naoqi.limits(nao, "LKneePitch")[0]
    reach, height = 1000 * (hand - shoulder)[0], 1000 * (camera - sole)[2]
    print(f"{version:7} {nao.mass:10.3f} {reach:11.1f} mm {height:16.1f} mm {np.degrees(upper - lower):12.1f}°")
