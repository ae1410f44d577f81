"""Nod and shake the head, with angles relative to its current ones."""

import argparse

from naoqi import ALProxy


def main(ip, port):
    motion = ALProxy("ALMotion", ip, port)
    motion.setStiffnesses(["HeadYaw", "HeadPitch"], [1.0, 1.0])
    motion.angleInterpolation(["HeadYaw", "HeadPitch"], [0.2, 0.1], [0.8, 0.8], True)
    # All keys of a relative list are relative to the joint's angle at the start of the call.
    motion.angleInterpolation("HeadYaw", [0.3, -0.3, 0.15], [0.6, 1.2, 1.6], False)
    motion.angleInterpolation("HeadPitch", -0.2, 0.5, False)
    print("the head is at", motion.getAngles(["HeadYaw", "HeadPitch"], False))


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--ip", default="127.0.0.1")
    parser.add_argument("--port", type=int, default=9559)
    arguments = parser.parse_args()
    main(arguments.ip, arguments.port)
