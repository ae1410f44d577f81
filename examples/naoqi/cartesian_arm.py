"""Move a hand up and forwards by some centimetres: only its position, relative to the current one."""

import argparse
import time

import almath
import motion as names
from naoqi import ALProxy


def main(ip, port):
    motion = ALProxy("ALMotion", ip, port)
    posture = ALProxy("ALRobotPosture", ip, port)
    motion.wakeUp()
    posture.goToPosture("StandInit", 1.0)

    before = motion.getPosition("LArm", names.FRAME_TORSO, True)
    path = [0.03, 0.02, 0.05, 0.0, 0.0, 0.0]
    started = time.time()
    motion.positionInterpolation("LArm", names.FRAME_TORSO, path, almath.AXIS_MASK_VEL, 1.5, False)
    print("took %.3f s" % (time.time() - started))
    after = motion.getPosition("LArm", names.FRAME_TORSO, True)
    print("moved by", [round(b - a, 5) for a, b in zip(before[:3], after[:3])])


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--ip", default="127.0.0.1")
    parser.add_argument("--port", type=int, default=9559)
    arguments = parser.parse_args()
    main(arguments.ip, arguments.port)
