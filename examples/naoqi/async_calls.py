"""Run several motions at the same time, with the futures of qi."""

import argparse
import time

import qi


def main(session):
    motion = session.service("ALMotion")
    motion.wakeUp()
    started = time.time()
    futures = [
        motion.angleInterpolation("HeadYaw", 0.3, 1.0, True, _async=True),
        motion.angleInterpolation("LShoulderPitch", 0.9, 2.0, True, _async=True),
        motion.angleInterpolation(["RShoulderPitch", "RShoulderRoll"], [0.8, -0.4], [1.0, 1.5], True, _async=True),
    ]
    for future in futures:
        future.wait()
    print("all after %.3f s" % (time.time() - started))
    failed = motion.angleInterpolation("HeadYawn", 0.3, 1.0, True, _async=True)
    failed.wait()
    print("failed:", failed.hasError(), failed.error().splitlines()[-1].strip())


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--ip", default="127.0.0.1")
    parser.add_argument("--port", type=int, default=9559)
    arguments = parser.parse_args()
    session = qi.Session()
    session.connect("tcp://%s:%d" % (arguments.ip, arguments.port))
    main(session)
