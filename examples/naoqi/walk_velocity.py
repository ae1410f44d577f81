"""Walk at a velocity for a while, then stop; the head looks around meanwhile."""

import argparse
import time

from naoqi import ALProxy


def main(ip, port):
    motion = ALProxy("ALMotion", ip, port)
    motion.wakeUp()
    ALProxy("ALRobotPosture", ip, port).goToPosture("StandInit", 1.0)
    motion.move(0.05, 0.0, 0.0)
    motion.setAngles("HeadYaw", 0.5, 0.2)
    time.sleep(3.0)
    print("walking:", motion.moveIsActive())
    motion.stopMove()
    motion.waitUntilMoveIsFinished()
    print("walking:", motion.moveIsActive())
    x, y, theta = motion.getRobotPosition(True)
    print("at %.3f %.3f %.3f" % (x, y, theta))


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--ip", default="127.0.0.1")
    parser.add_argument("--port", type=int, default=9559)
    arguments = parser.parse_args()
    main(arguments.ip, arguments.port)
