"""Move a whole arm at a fraction of its speed: all joints of the chain, in NAOqi's order."""

import argparse
import sys
import time

from naoqi import ALProxy


def main(ip, port):
    try:
        motion = ALProxy("ALMotion", ip, port)
    except RuntimeError as error:
        print("no ALMotion:", error)
        sys.exit(1)
    motion.wakeUp()
    print("the arm is", motion.getBodyNames("LArm"))

    started = time.time()
    motion.angleInterpolationWithSpeed("LArm", [0.5, 0.4, -1.0, -0.8, 0.3, 1.0], 0.2)
    print("there after %.2f s" % (time.time() - started))
    motion.angleInterpolationWithSpeed(["RShoulderPitch", "RElbowRoll"], [0.7, 1.1], 0.3)
    print("left", motion.getAngles("LArm", True))


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--ip", default="127.0.0.1")
    parser.add_argument("--port", type=int, default=9559)
    arguments = parser.parse_args()
    main(arguments.ip, arguments.port)
