"""Write and read values in the robot's memory, and receive its events through signals."""

import argparse
import sys
import time

import qi


class Touched:
    """Counts how often the head is touched."""

    def __init__(self, session):
        self.memory = session.service("ALMemory")
        self.values = []
        self.subscriber = self.memory.subscriber("FrontTactilTouched")
        self.subscriber.signal.connect(self.on_touched)

    def on_touched(self, value):
        self.values.append(value)


def main(app):
    session = app.session
    memory = session.service("ALMemory")
    memory.insertData("Demo/Answer", 42)
    memory.insertListData([["Demo/Name", "NAO"], ["Demo/List", [1, 2.5, "three"]]])
    print("memory:", memory.getListData(["Demo/Answer", "Demo/Name", "Demo/List"]))
    print("keys:", memory.getDataList("Demo/"))

    touched = Touched(session)
    for value in (1.0, 0.0, 1.0):
        memory.raiseEvent("FrontTactilTouched", value)
    time.sleep(0.5)
    print("touched:", touched.values)

    motion = session.service("ALMotion")
    motion.wakeUp()
    motion.angleInterpolation("HeadYaw", 0.35, 0.8, True)
    key = "Device/SubDeviceList/HeadYaw/Position/%s/Value"
    print("sensor %.6f, actuator %.6f" % (memory.getData(key % "Sensor"), memory.getData(key % "Actuator")))


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--ip", default="127.0.0.1")
    parser.add_argument("--port", type=int, default=9559)
    arguments = parser.parse_args()
    application = qi.Application([sys.argv[0], "--qi-url=tcp://%s:%d" % (arguments.ip, arguments.port)])
    application.start()
    main(application)
