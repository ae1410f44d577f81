"""Print the positions of the NAO's hands, feet and cameras in each of its postures.

Example:
    python scripts/forward_kinematics.py
    python scripts/forward_kinematics.py --version v3.2 --frame LArm --reference LLeg
"""

from __future__ import annotations

import argparse
import sys

import nao_kin as nk

FRAMES = ("LArm", "RArm", "LLeg", "RLeg", "CameraTop", "CameraBottom")


def main() -> int:
    """Print one line per posture and frame."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--version", default="v6", help="NAO version (default: v6)")
    parser.add_argument("--frame", action="append", help="a frame; repeatable (default: hands, feet, cameras)")
    parser.add_argument("--reference", help="the frame to express positions in (default: the torso)")
    options = parser.parse_args()
    try:
        nao = nk.load_nao(options.version)
        frames = options.frame or list(FRAMES)
        print(f"{'posture':12}{'frame':14}{'x':>9}{'y':>9}{'z':>9}  [m]")
        for name in nao.posture_names:
            positions = nao.position(nao.posture(name), frames, reference=options.reference)
            for frame, (x, y, z) in zip(frames, positions + 0.0, strict=True):
                print(f"{name:12}{frame:14}{x:9.4f}{y:9.4f}{z:9.4f}")
    except nk.NaoKinError as error:
        print(f"forward_kinematics: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
