"""One motor for two hips, and one for eight parts of the fingers."""

from __future__ import annotations

import numpy as np

from explanations.drawing import INK, LINE, PALE, VIOLET, Drawing, Floats, View, circle_points
from explanations.robot_outline import draw_robot, nao_shapes

HIPS, HAND = VIOLET, "#0f766e"
Y, Z = np.eye(3)[1:]


def hips() -> Drawing:
    """Draw the two axes, and the legs at zero and turned by the same value."""
    nao, _ = nao_shapes()
    drawing = Drawing(760, 335, "The axes of both HipYawPitch joints from the front, and the legs turned by one motor")
    values = (0.0, -0.55, 0.45)
    words = (
        "0°",
        f"−{np.degrees(-values[1]):.0f}°: toes out, thighs forward",
        f"{np.degrees(values[2]):.0f}°: toes in, thighs back",
    )
    for k, (value, label) in enumerate(zip(values, words, strict=True)):
        q = nao.configuration({"LHipYawPitch": value}, limits="ignore")
        x = 130.0 + 250.0 * k
        view = View((x, 65.0), 620.0 if k == 0 else 560.0, Y, Z)
        for side in "LR":
            draw_robot(drawing, view, q, only=f"{side}HipYawPitch")
        centres = {side: nao.position(q, f"{side}HipYawPitch") for side in "LR"}
        for side, outwards in (("L", 1.0), ("R", -1.0)):
            axis = np.array([0.0, outwards, -1.0]) / np.sqrt(2.0)
            # Both turn about an axis that points to the robot's left: outwards and down, inwards and up.
            way = np.array([0.0, 1.0, -outwards]) / np.sqrt(2.0)
            assert np.allclose(nao.rotation(nao.configuration({"LHipYawPitch": 0.3}), f"{side}HipYawPitch") @ way, way)
            centre = centres[side]
            drawing.line(view.flat(centre - 0.085 * axis), view.flat(centre + 0.1 * axis), HIPS, 2.0, "7 4")
            drawing.circle(view.flat(centre), 5.0, "white", HIPS, 2.2)
            if k == 0:
                tip = view.flat(centre + 0.12 * way)
                drawing.arrow([view.flat(centre), tip], HIPS, 2.6)
        if k == 0:
            middle = (view.flat(centres["L"]) + view.flat(centres["R"])) / 2
            motor(drawing, middle - [0.0, 72.0], [view.flat(centres[side]) for side in "LR"])
            horizon = view.flat(centres["L"])
            drawing.line(horizon, horizon + np.array([74.0, 0.0]), LINE, 1.2)
            drawing.path(circle_points(horizon, [48.0, 0.0], [0.0, 48.0], 0.0, 45.0), stroke=INK, width=1.3)
            drawing.text(horizon + np.array([54.0, 26.0]), "45°", 13.5, INK, halo=True)
        drawing.text((x, 315), label, 14, INK if k == 0 else HIPS, anchor="middle", weight="600")
    return drawing


def motor(drawing: Drawing, at: Floats, hips_at: list[Floats]) -> None:
    """Draw a box that drives both hips."""
    for hip in hips_at:
        drawing.path([at, (hip[0], at[1]), hip + np.array([0.0, -8.0])], stroke=PALE, width=1.6)
    corners = [at + np.array([dx, dy]) for dx, dy in ((-36, -14), (36, -14), (36, 14), (-36, 14))]
    drawing.path(corners, fill="white", stroke=INK, width=1.6, closed=True)
    drawing.text(at + np.array([0.0, 5.0]), "one motor", 13, INK, anchor="middle")


def fingers() -> Drawing:
    """Draw the left hand closed, half open and open, from the right."""
    nao, _ = nao_shapes()
    drawing = Drawing(760, 245, "The left hand with LHand at 0, one half and 1, and the turn of each part of a finger")
    for k, value in enumerate((0.0, 0.5, 1.0)):
        q = nao.configuration({"LHand": value})
        x = 34.0 + 250.0 * k
        wrist = nao.position(q, "LWristYaw")
        view = View((x - 1500.0 * wrist[0], 80.0 + 1500.0 * wrist[2]), 1500.0, (1.0, 0.0, 0.0), Z)
        draw_robot(drawing, view, q, only="LWristYaw")
        for joint in ("LHandFinger11", "LHandFinger12", "LHandFinger13", "LHandThumb1", "LHandThumb2"):
            drawing.circle(view.flat(nao.position(q, joint)), 3.4, "white", HAND, 1.8)
        title = {0.0: "closed", 0.5: "half open", 1.0: "open"}[value]
        drawing.text((x + 90.0, 205), f"LHand = {value:g}: {title}", 15, HAND, anchor="middle", weight="600")
        bend = nao.mimics["LHandFinger11"].multiplier * value
        drawing.text((x + 90.0, 226), f"each joint at {bend:.2f} rad", 13, PALE, anchor="middle")
    return drawing


FIGURES = {"coupling_hips": hips, "coupling_fingers": fingers}
