"""Reach with an arm while the whole body keeps its balance on both feet."""

import argparse
import time

from naoqi import ALProxy

FRAME_ROBOT = 2


def main(ip, port):
    motion = ALProxy("ALMotion", ip, port)
    motion.wakeUp()
    ALProxy("ALRobotPosture", ip, port).goToPosture("StandInit", 1.0)
    motion.wbEnable(True)
    motion.wbFootState("Fixed", "Legs")
    motion.wbEnableBalanceConstraint(True, "Legs")

    motion.wbEnableEffectorControl("RArm", True)
    target = motion.getPosition("RArm", FRAME_ROBOT, False)[:3]
    target[0] += 0.06
    target[2] -= 0.02
    motion.wbSetEffectorControl("RArm", target)
    time.sleep(4.0)
    there = motion.getPosition("RArm", FRAME_ROBOT, True)
    print("misses by %.6f m" % max(abs(a - b) for a, b in zip(there, target)))
    motion.wbEnableEffectorControl("RArm", False)
    motion.wbEnable(False)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--ip", default="127.0.0.1")
    parser.add_argument("--port", type=int, default=9559)
    arguments = parser.parse_args()
    main(arguments.ip, arguments.port)
