# A wave as Choregraphe exports a timeline, with Bezier handles.
from naoqi import ALProxy

names = list()
times = list()
keys = list()

names.append("HeadPitch")
times.append([0.8, 1.6, 2.4])
keys.append([[-0.1, [3, -0.266667, 0], [3, 0.266667, 0]], [0.2, [3, -0.266667, 0], [3, 0.266667, 0]], [0.05, [3, -0.266667, 0], [3, 0, 0]]])

names.append("RElbowRoll")
times.append([0.8, 1.6, 2.4])
keys.append([[1.2, [3, -0.266667, -0.1], [3, 0.266667, 0.1]], [0.5, [3, -0.266667, 0.1], [3, 0.266667, -0.1]], [0.9, [3, -0.266667, 0], [3, 0, 0]]])

names.append("RHand")
times.append([0.8, 2.4])
keys.append([[0.9, [3, -0.266667, 0], [3, 0.533333, 0]], [0.2, [3, -0.533333, 0], [3, 0, 0]]])

names.append("RShoulderPitch")
times.append([1.2, 2])
keys.append([[-0.9, [3, -0.4, 0], [3, 0.266667, 0]], [1.4, [3, -0.266667, 0], [3, 0, 0]]])

try:
    motion = ALProxy("ALMotion", "127.0.0.1", 9559)
    motion.setStiffnesses("Body", 1.0)
    motion.angleInterpolationBezier(names, times, keys)
except BaseException as error:
    print(error)
