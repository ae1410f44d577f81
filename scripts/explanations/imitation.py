"""Axes of the sources of skeletons."""

from __future__ import annotations

import numpy as np

import nao_kin as nk
from explanations.drawing import AXES, INK, LINE, PALE, VIOLET, Drawing, View
from nao_kin.imitation.layouts import LAYOUTS
from nao_kin.imitation.skeleton import UP_AXES

_CHAINS = [
    ("pelvis", "chest", "neck", "head"),
    ("left_shoulder", "neck", "right_shoulder"),
    ("left_hip", "pelvis", "right_hip"),
    *((f"{side}_shoulder", f"{side}_elbow", f"{side}_wrist", f"{side}_hand") for side in ("left", "right")),
    *((f"{side}_hip", f"{side}_knee", f"{side}_ankle", f"{side}_toe") for side in ("left", "right")),
]


def skeleton_axes() -> Drawing:
    """Draw a person who faces the camera, and the axes of each source beside."""
    drawing = Drawing(900, 330, "The axes of MediaPipe, Kinect and BVH files beside a person who faces the camera")
    wave = nk.imitation.read_skeleton(nk.imitation.SAMPLES["wave"])
    places = {name: values[len(wave) // 2] for name, values in wave.points.items()}
    sources = (
        ("MediaPipe, Azure Kinect", LAYOUTS["mediapipe"].axes),
        ("Kinect v2", LAYOUTS["kinect_v2"].axes),
        ("BVH, y up", UP_AXES["y"]),
        ("a Skeleton; BVH, z up", UP_AXES["z"]),
    )
    for k, (title, axes) in enumerate(sources):
        view = View.around((76.0 + 225.0 * k, 285.0), 118.0, 32.0, 14.0)
        for chain in _CHAINS:
            drawing.path(view.flat([places[name] for name in chain]), stroke=INK, width=4.0)
        drawing.circle(view.flat(places["head"] + [0.0, 0.0, 0.09]), 12.0, INK)
        drawing.text(view.flat(places["left_elbow"] + [0.0, 0.1, 0.1]), "left", 12.0, PALE)
        nose = places["head"] + [0.0, 0.0, 0.09]
        drawing.arrow(view.flat([nose, nose + np.array([0.45, 0.0, 0.0])]), VIOLET, 2.0)
        origin = np.array([0.1, 0.95, 0.55])
        for axis, direction in zip(axes or (), np.eye(3), strict=True):
            sign = -1.0 if axis.startswith("-") else 1.0
            letter = axis[-1]
            tip, beyond = origin + sign * 0.36 * direction, origin + sign * 0.48 * direction
            drawing.arrow(view.flat([origin, tip]), AXES["xyz".index(letter)], 2.2, head=8.0)
            x, y = view.flat(beyond)
            drawing.text((x, y + 4.5), letter, 14.0, AXES["xyz".index(letter)], anchor="middle", weight="600")
        drawing.text((112.0 + 225.0 * k, 28.0), title, 14.0, anchor="middle", weight="600")
        if k:
            drawing.line((225.0 * k, 20.0), (225.0 * k, 310.0), LINE, 1.0)
    return drawing


FIGURES = {"skeleton_axes": skeleton_axes}
