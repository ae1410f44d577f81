"""Coloured eyes and a greeting."""

import argparse
import time

from naoqi import ALProxy


def main(ip, port):
    leds = ALProxy("ALLeds", ip, port)
    speech = ALProxy("ALTextToSpeech", ip, port)
    started = time.time()
    leds.fadeRGB("FaceLeds", 0xFF8000, 1.0)
    print("eyes after %.3f s" % (time.time() - started))
    leds.off("ChestLeds")
    speech.setLanguage("English")
    speech.setVolume(0.6)
    speech.say("Hello, I am a NAO without a body.")
    print("volume %.1f, language %s" % (speech.getVolume(), speech.getLanguage()))


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--ip", default="127.0.0.1")
    parser.add_argument("--port", type=int, default=9559)
    arguments = parser.parse_args()
    main(arguments.ip, arguments.port)
