"""Walk to a place, and print the displacement that the robot itself reports."""

import argparse
import math

import almath
from naoqi import ALProxy


def main(ip, port):
    motion = ALProxy("ALMotion", ip, port)
    motion.wakeUp()
    ALProxy("ALRobotPosture", ip, port).goToPosture("StandInit", 1.0)
    motion.moveInit()
    start = almath.Pose2D(motion.getRobotPosition(False))
    motion.moveTo(0.2, 0.05, math.pi / 6.0)
    end = almath.Pose2D(motion.getRobotPosition(False))
    moved = almath.pose2DInverse(start) * end
    moved.theta = almath.modulo2PI(moved.theta)
    print("walked %.4f %.4f %.4f" % (moved.x, moved.y, moved.theta))


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--ip", default="127.0.0.1")
    parser.add_argument("--port", type=int, default=9559)
    arguments = parser.parse_args()
    main(arguments.ip, arguments.port)
