"""Move a hand to a position at a fraction of its speed, without waiting."""

import argparse
import time

from naoqi import ALProxy

FRAME_ROBOT = 2


def main(ip, port):
    motion = ALProxy("ALMotion", ip, port)
    motion.wakeUp()
    ALProxy("ALRobotPosture", ip, port).goToPosture("StandInit", 1.0)
    target = motion.getPosition("RArm", FRAME_ROBOT, False)
    target[0] += 0.03
    target[2] += 0.04
    motion.setPositions("RArm", FRAME_ROBOT, target, 0.5, 7)
    time.sleep(2.0)
    there = motion.getPosition("RArm", FRAME_ROBOT, True)
    print("misses by %.6f m" % max(abs(a - b) for a, b in zip(there[:3], target[:3])))


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--ip", default="127.0.0.1")
    parser.add_argument("--port", type=int, default=9559)
    arguments = parser.parse_args()
    main(arguments.ip, arguments.port)
