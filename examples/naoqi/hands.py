"""Open both hands, close one, and set each to a value between closed and open."""

import argparse

import qi


def main(session):
    motion = session.service("ALMotion")
    motion.setStiffnesses(["LHand", "RHand"], 1.0)
    motion.openHand("LHand")
    motion.openHand("RHand")
    print("open:", motion.getAngles(["LHand", "RHand"], True))
    motion.closeHand("RHand")
    # openHand and closeHand remove the stiffness at their end, to save the motors.
    motion.setStiffnesses(["LHand", "RHand"], 1.0)
    motion.setAngles("LHand", 0.33, 1.0)
    motion.angleInterpolation("RHand", 0.1, 0.5, True)
    print("now:", motion.getAngles(["LHand", "RHand"], True))


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--ip", default="127.0.0.1")
    parser.add_argument("--port", type=int, default=9559)
    arguments = parser.parse_args()
    session = qi.Session()
    session.connect("tcp://%s:%d" % (arguments.ip, arguments.port))
    main(session)
