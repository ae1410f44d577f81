"""Shift the weight onto one leg, and back onto both."""

import argparse

from naoqi import ALProxy

FRAME_ROBOT = 2


def main(ip, port):
    motion = ALProxy("ALMotion", ip, port)
    motion.wakeUp()
    ALProxy("ALRobotPosture", ip, port).goToPosture("StandInit", 1.0)
    motion.wbEnable(True)
    motion.wbFootState("Fixed", "Legs")
    motion.wbEnableBalanceConstraint(True, "Legs")
    for support, duration in (("LLeg", 2.0), ("Legs", 1.5)):
        motion.wbGoToBalance(support, duration)
        centre = motion.getCOM("Body", FRAME_ROBOT, False)
        foot = motion.getPosition("LLeg", FRAME_ROBOT, False)
        print("%s: centre of mass at y = %.4f m, left foot at %.4f m" % (support, centre[1], foot[1]))
    motion.wbEnable(False)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--ip", default="127.0.0.1")
    parser.add_argument("--port", type=int, default=9559)
    arguments = parser.parse_args()
    main(arguments.ip, arguments.port)
