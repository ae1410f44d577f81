"""A virtual NAO says hello.

Learn how to run NAOqi calls without a robot: a virtual NAO stands up, turns its head, lights its eyes and speaks.
"""

import sys
from pathlib import Path

import nao_kin as nk

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")

with nk.naoqi.VirtualNao(stepped=True) as robot:  # time advances only during calls
    robot.call("ALMotion", "wakeUp")
    robot.call("ALRobotPosture", "goToPosture", "Stand", 0.8)
    print(f"it stands after {robot.clock.now:.1f} s of robot time")
    robot.call("ALMotion", "angleInterpolation", ["HeadYaw", "RShoulderPitch"], [0.3, -0.8], [0.8, 1.0], True)
    yaw, arm = robot.call("ALMotion", "getAngles", ["HeadYaw", "RShoulderPitch"], True)
    print(f"HeadYaw is at {yaw:.2f} rad, RShoulderPitch at {arm:.2f} rad")
    robot.call("ALLeds", "fadeRGB", "FaceLeds", "cyan", 0.0)
    robot.post("ALTextToSpeech", "say", "\\rspd=90\\Hello!")  # post does not wait for the end
    state = robot.state()
    print("it says:", nk.naoqi.spoken_words(state.saying))

    viewer = nk.Viewer(robot.robot)
    viewer.display(state.q)
    viewer.show_lights(nk.naoqi.light_colours(state.leds))
    print("see", viewer.save_html(folder / "virtual_nao.html", overwrite=True))
