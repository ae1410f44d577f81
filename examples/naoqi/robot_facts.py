"""Print what the robot reports about itself: names, limits, masses."""

import argparse

from naoqi import ALProxy


def main(ip, port):
    motion = ALProxy("ALMotion", ip, port)
    keys, values = motion.getRobotConfig()
    for key, value in zip(keys, values):
        print("%s: %s" % (key, value))
    print("%d joints in Body, chains %s" % (len(motion.getBodyNames("Body")), motion.getBodyNames("Chains")))
    for name, limits in zip(motion.getBodyNames("Head"), motion.getLimits("Head")):
        print("%s: min %.4f, max %.4f, speed %.3f, torque %.3f" % (name, *limits))
    print("mass %.5f kg" % motion.getMass("Body"))
    print("centre of mass", [round(value, 5) for value in motion.getCOM("Body", 0, False)])


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--ip", default="127.0.0.1")
    parser.add_argument("--port", type=int, default=9559)
    arguments = parser.parse_args()
    main(arguments.ip, arguments.port)
