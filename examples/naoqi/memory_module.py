"""Receive an event in a method of your own module, as scripts did before qi had signals."""

import argparse
import time

from naoqi import ALBroker, ALModule, ALProxy

memory = None


class BumperModule(ALModule):
    """Records the events of a bumper."""

    def __init__(self, name):
        ALModule.__init__(self, name)
        self.hits = []
        memory.subscribeToEvent("LeftBumperPressed", name, "onBumper")

    def onBumper(self, key, value, message):
        """Called by the robot."""
        memory.unsubscribeToEvent("LeftBumperPressed", "bumperModule")
        self.hits.append((key, value))
        memory.subscribeToEvent("LeftBumperPressed", "bumperModule", "onBumper")


def main(ip, port):
    global memory
    broker = ALBroker("myBroker", "0.0.0.0", 0, ip, port)
    memory = ALProxy("ALMemory")
    module = BumperModule("bumperModule")
    for value in (1.0, 0.0):
        memory.raiseEvent("LeftBumperPressed", value)
        time.sleep(0.4)
    print("hits:", module.hits)
    module.exit()
    broker.shutdown()


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--ip", default="127.0.0.1")
    parser.add_argument("--port", type=int, default=9559)
    arguments = parser.parse_args()
    main(arguments.ip, arguments.port)
