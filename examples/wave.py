"""A motion: wave.

Learn how to make a motion from keys, check it against the robot's limits, slow it down, and save it for Choregraphe.
"""

import sys
from pathlib import Path

import numpy as np

import nao_kin as nk
from nao_kin.motion import check, read_motion, slow_down, time_warp, write_motion

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
nao = nk.load_nao()
raise_arm, wave = [0.0, 0.4], [0.4, 0.6, 0.8, 1.0, 1.2]
hasty = nk.Motion(
    times=[raise_arm, raise_arm, raise_arm, [0.0, *wave], raise_arm],
    joint_names=["RShoulderPitch", "RShoulderRoll", "RElbowYaw", "RElbowRoll", "RHand"],
    keys=[[1.4, -1.1], [-0.3, -0.4], [1.4, 1.0], [1.0, 0.4, 1.4, 0.4, 1.4, 0.9], [0.0, 1.0]],
    interpolation="smooth",
)
for found in check(nao, hasty).violations:
    print(
        f"{found.kind}: {found.joint} at {abs(found.value):.2f} rad/s, at most {found.upper:.2f}, at {found.time:.1f} s"
    )

least = slow_down(nao, hasty).motion  # as fast as the joints allow
slow = time_warp(hasty, 1.5)  # a friendly wave
print(f"instead of {hasty.duration:.1f} s it takes {least.duration:.2f} s at least")
print(f"in {slow.duration:.1f} s:", "inside all limits" if check(nao, slow).ok else "outside the limits")

write_motion(slow, folder / "wave.xar", overwrite=True)
read = read_motion(folder / "wave.xar")
print("wave.xar:", ", ".join(read.joint_names))

hand = nao.position(slow.configurations(nao, rate=100).q, "RArm")
print(f"the path of the hand has a length of {np.linalg.norm(np.diff(hand, axis=0), axis=1).sum():.2f} m")
viewer = nk.Viewer(nao)
viewer.animate(slow)
viewer.display(slow.configurations(nao, times=[slow.end]).q[0])
viewer.add_line("way of the hand", hand, color=(0.9, 0.3, 0.1), frame="torso")
print("see", viewer.save_html(folder / "wave.html", overwrite=True))
