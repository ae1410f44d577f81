"""Read a transform, change it with almath, and move the torso to it."""

import argparse
import time

import almath
from naoqi import ALProxy

FRAME_WORLD = 1


def main(ip, port):
    motion = ALProxy("ALMotion", ip, port)
    motion.wakeUp()
    ALProxy("ALRobotPosture", ip, port).goToPosture("StandInit", 1.0)
    before = almath.Transform(motion.getTransform("Torso", FRAME_WORLD, False))
    lower = almath.Transform(before.toVector())
    lower.r3_c4 -= 0.02
    lower.r1_c4 += 0.01
    started = time.time()
    motion.transformInterpolations("Torso", FRAME_WORLD, [lower.toVector()], almath.AXIS_MASK_ALL, [1.0])
    print("took %.3f s" % (time.time() - started))
    after = almath.Transform(motion.getTransform("Torso", FRAME_WORLD, True))
    print(
        "moved by %.5f %.5f %.5f m"
        % (after.r1_c4 - before.r1_c4, after.r2_c4 - before.r2_c4, after.r3_c4 - before.r3_c4)
    )
    print("turned by", almath.position6DFromTransform(before.inverse() * after).toVector()[3:])


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--ip", default="127.0.0.1")
    parser.add_argument("--port", type=int, default=9559)
    arguments = parser.parse_args()
    main(arguments.ip, arguments.port)
