"""Show that a joint without stiffness does not move, and raise the stiffness by a ramp."""

import argparse
import time

from naoqi import ALProxy


def main(ip, port):
    motion = ALProxy("ALMotion", ip, port)
    motion.wakeUp()
    motion.angleInterpolation("HeadYaw", 0.0, 0.5, True)

    motion.setStiffnesses("HeadYaw", 0.0)
    motion.angleInterpolation("HeadYaw", 0.7, 0.5, True)
    print("limp at", motion.getAngles("HeadYaw", True), "commanded", motion.getAngles("HeadYaw", False))

    started = time.time()
    motion.stiffnessInterpolation("Head", [[0.3, 1.0], [0.3, 1.0]], [[0.5, 1.0], [0.5, 1.0]])
    print("stiff after %.3f s" % (time.time() - started))
    print("stiffnesses", motion.getStiffnesses("Head"))
    motion.angleInterpolation("HeadYaw", 0.4, 0.5, True)
    print("now at", motion.getAngles("HeadYaw", True))


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--ip", default="127.0.0.1")
    parser.add_argument("--port", type=int, default=9559)
    arguments = parser.parse_args()
    main(arguments.ip, arguments.port)
