"""How the uncertainty of a calibration shrinks with the postures observed, chosen or random."""

from __future__ import annotations

import numpy as np

import nao_kin as nk
from explanations.drawing import BLUE, INK, ORANGE, PALE, Drawing, Floats

MARKS = np.array([[x, y, 0.01] for x in (0.0, 0.03, 0.06) for y in (-0.02, 0.02)])
JOINTS = ("HeadYaw", "HeadPitch", "LShoulderPitch", "LShoulderRoll", "LElbowYaw", "LElbowRoll")
ANGLES = ("roll", "pitch", "yaw")
FIRST, LAST = 4, 20  # postures
LEFT, TOP, WIDTH, HEIGHT = 84.0, 60.0, 620.0, 260.0
MOST = 0.5  # at the top of the figure [deg]


def pixels_of(camera: nk.world.Camera, q: Floats) -> Floats:
    """Return the pixels of the marks on the left hand, NaN outside of the picture, shape (n, marks, 2)."""
    nao = nk.load_nao("v6")
    T = nk.screws.inverse(nao.fk(q, camera.frame)) @ nao.fk(q, "LArm")
    pixels = camera.project(nk.screws.transform_point(T[:, None], MARKS))
    pixels[~camera.sees(pixels)] = np.nan
    return pixels


def deviations(chosen: bool) -> list[float]:
    """Return the largest standard deviation [deg] after FIRST … LAST postures."""
    nao = nk.load_nao("v6")
    camera = nk.world.camera(nao, "CameraTop")
    candidates = nao.random(0, 8000)
    candidates = candidates[np.isfinite(pixels_of(camera, candidates)).all(axis=(1, 2))]
    q, rest, found = candidates[:FIRST], candidates[FIRST:], []
    while True:
        seen = nk.calibration.Pixels(q, camera, pixels_of(camera, q), MARKS, "LArm")
        result = nk.calibration.calibrate(nao, [seen], joints=JOINTS, frames={"CameraTop": ANGLES})
        found.append(float(np.degrees(max(result.standard_deviations.values()))))
        if len(q) == LAST:
            return found
        best = nk.calibration.next_posture(result, rest).index if chosen else 0
        q, rest = np.vstack((q, rest[best])), np.delete(rest, best, axis=0)


def postures() -> Drawing:
    """Draw the largest standard deviation over the number of postures."""
    title = "The largest standard deviation over the number of postures: chosen ones need half as many as random ones"
    drawing = Drawing(760, 400, title)
    counts = np.arange(FIRST, LAST + 1)

    def at(count: object, value: object) -> Floats:
        x = LEFT + WIDTH * (np.asarray(count, dtype=float) - FIRST) / (LAST - FIRST)
        y = TOP + HEIGHT * (1.0 - np.asarray(value, dtype=float) / MOST)
        return np.stack(np.broadcast_arrays(x, y), axis=-1)

    for count in counts[::2]:
        drawing.line(at(count, 0.0), at(count, MOST), "#e5e7eb", 1.0)
        drawing.text(at(count, -0.027), str(count), 12.5, PALE, anchor="middle")
    for value in np.arange(0.0, MOST + 1e-9, 0.1):
        drawing.line(at(FIRST, value), at(LAST, value), "#e5e7eb", 1.0)
        drawing.text(at(FIRST - 0.2, value - 0.005), f"{value:.1f}°", 12.5, PALE, anchor="end")
    for chosen, colour, words, place in ((False, ORANGE, "random postures", 3), (True, BLUE, "next_posture", 5)):
        values = deviations(chosen)
        way = at(counts, values)
        drawing.path(way, stroke=colour, width=2.2)
        for point in way:
            drawing.circle(point, 3.6, colour)
        at_words = way[place] + np.array([0.0, 32.0 if chosen else -14.0])
        drawing.text(at_words, words, 14, colour, weight="600", halo=True)
    drawing.text((LEFT, 34), "largest standard deviation of six joints and a camera", 14, INK, weight="600")
    drawing.text((LEFT + WIDTH / 2, 374), "postures observed", 14, INK, anchor="middle", weight="600")
    return drawing


FIGURES = {"calibration_postures": postures}
