"""Move both hands at the same time, each along its own path with its own times."""

import argparse
import time

import qi

FRAME_TORSO = 0
AXIS_MASK_VEL = 7


def main(session):
    motion = session.service("ALMotion")
    motion.wakeUp()
    session.service("ALRobotPosture").goToPosture("StandInit", 1.0)
    paths, times = [], [[0.8, 1.6], [1.0, 2.0]]
    for arm, side in (("LArm", 1.0), ("RArm", -1.0)):
        x, y, z, wx, wy, wz = motion.getPosition(arm, FRAME_TORSO, False)
        paths.append([[x + 0.04, y, z + 0.03, wx, wy, wz], [x + 0.02, y + side * 0.03, z, wx, wy, wz]])
    started = time.time()
    motion.positionInterpolations(["LArm", "RArm"], FRAME_TORSO, paths, [AXIS_MASK_VEL, AXIS_MASK_VEL], times)
    print("took %.3f s" % (time.time() - started))
    for arm, path in zip(("LArm", "RArm"), paths):
        there = motion.getPosition(arm, FRAME_TORSO, True)
        print("%s misses by %.6f m" % (arm, max(abs(a - b) for a, b in zip(there[:3], path[-1][:3]))))


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--ip", default="127.0.0.1")
    parser.add_argument("--port", type=int, default=9559)
    arguments = parser.parse_args()
    session = qi.Session()
    session.connect("tcp://%s:%d" % (arguments.ip, arguments.port))
    main(session)
