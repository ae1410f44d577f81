"""Go to some postures, and print their families."""

import argparse

from naoqi import ALProxy


def main(ip, port):
    ALProxy("ALMotion", ip, port).wakeUp()
    posture = ALProxy("ALRobotPosture", ip, port)
    print("there are", posture.getPostureList())
    for name in ("StandInit", "Sit", "Crouch", "StandZero"):
        reached = posture.goToPosture(name, 1.0)
        print("%s: %s, of the family %s" % (name, reached, posture.getPostureFamily()))
    print("no such posture:", posture.goToPosture("Handstand", 1.0))


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--ip", default="127.0.0.1")
    parser.add_argument("--port", type=int, default=9559)
    arguments = parser.parse_args()
    main(arguments.ip, arguments.port)
