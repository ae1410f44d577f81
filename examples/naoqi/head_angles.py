"""Turn the head along two lists of angles, one list of times for each joint."""

import argparse
import math
import time

from naoqi import ALProxy


def main(ip, port):
    motion = ALProxy("ALMotion", ip, port)
    motion.setStiffnesses("Head", 1.0)

    # One joint, one angle, one time.
    started = time.time()
    motion.angleInterpolation("HeadYaw", math.radians(30.0), 1.0, True)
    print("one angle took %.3f s" % (time.time() - started))

    # Two joints with keys of their own.
    names = ["HeadYaw", "HeadPitch"]
    angles = [[math.radians(50.0), math.radians(-50.0), 0.1], [math.radians(20.0), -0.2]]
    times = [[1.0, 2.0, 3.0], [1.5, 2.5]]
    started = time.time()
    motion.angleInterpolation(names, angles, times, True)
    print("two lists took %.3f s" % (time.time() - started))
    print("the head is at", motion.getAngles("Head", True))


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--ip", default="127.0.0.1")
    parser.add_argument("--port", type=int, default=9559)
    arguments = parser.parse_args()
    main(arguments.ip, arguments.port)
