"""Set and change angles without waiting, at a fraction of the largest speed."""

import argparse
import time

from naoqi import ALProxy


def main(ip, port):
    motion = ALProxy("ALMotion", ip, port)
    motion.wakeUp()

    motion.setAngles("HeadYaw", 0.0, 0.5)
    time.sleep(1.0)
    # Two joints, one speed; a later call for the same joints replaces the earlier one.
    motion.setAngles(["HeadYaw", "HeadPitch"], [1.0, 0.1], 0.05)
    motion.setAngles(["HeadYaw", "HeadPitch"], [-0.6, -0.3], 0.4)
    time.sleep(1.5)
    # Relative to the current command.
    motion.changeAngles("HeadYaw", 0.25, 0.4)
    time.sleep(1.0)
    print("commanded", motion.getAngles("Head", False))


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--ip", default="127.0.0.1")
    parser.add_argument("--port", type=int, default=9559)
    arguments = parser.parse_args()
    main(arguments.ip, arguments.port)
