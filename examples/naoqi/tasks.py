"""Two motions of one joint: the second waits for the first; then one is killed."""

import argparse
import time

from naoqi import ALProxy


def main(ip, port):
    motion = ALProxy("ALMotion", ip, port)
    motion.wakeUp()
    motion.angleInterpolation("HeadYaw", 0.0, 0.5, True)

    started = time.time()
    first = motion.post.angleInterpolation("HeadYaw", 0.5, 1.5, True)
    second = motion.post.angleInterpolation("HeadYaw", -0.5, 1.0, True)
    time.sleep(0.2)
    print("tasks:", [name for name, number in motion.getTaskList()])
    motion.wait(first, 0)
    print("first after %.3f s, second running: %s" % (time.time() - started, motion.isRunning(second)))
    motion.wait(second, 0)
    print("second after %.3f s" % (time.time() - started))

    motion.post.angleInterpolation("HeadYaw", 1.0, 20.0, True)
    time.sleep(0.2)
    name, number = motion.getTaskList()[0]
    print("killed %s: %s" % (name, motion.killTask(number)))
    motion.angleInterpolation("HeadYaw", 0.25, 0.5, True)
    print("the head is at", motion.getAngles("HeadYaw", True))


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--ip", default="127.0.0.1")
    parser.add_argument("--port", type=int, default=9559)
    arguments = parser.parse_args()
    main(arguments.ip, arguments.port)
