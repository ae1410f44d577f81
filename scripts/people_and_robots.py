"""Six people whom a NAO imitates, each in the layout of another program, and what is said of them.

The person is that of `generate_skeleton_samples.py`, and `draw_pages.py` draws what it makes of them.

Example:
    python scripts/people_and_robots.py  # what the imitations say
"""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from generate_skeleton_samples import FACE, Angles, bvh, rising

import nao_kin as nk
from nao_kin._core.arrays import Floats
from nao_kin.imitation import SAMPLES, Imitation, Skeleton, imitate
from nao_kin.imitation.layouts import LAYOUTS

PAGE = Path(__file__).resolve().parents[1] / "docs" / "imitation.md"

HANGING = {"LeftArm": (-78.0, 0.0, 0.0), "RightArm": (78.0, 0.0, 0.0)}
# Where the camera looks at [m], from how far and from how far above.
CENTRE, DISTANCE, ABOVE = np.array([0.0, 0.2, 0.26]), 1.7, np.deg2rad(8.0)


@dataclass(frozen=True)
class Take:
    """A person who stands upright and then takes a pose, or a sample.

    Attributes:
        source: the sample, or the layout of the points.
        time: of the picture [s].
        says: a part of what the imitation says, which the page quotes.
        camera: from where the picture is taken, from the front to the robot's left [degrees].
        pose: joint → (z, x, y) about moving axes [degrees], as in a BVH file.
        hips: how far the hips move: to the left, up, ahead [cm].
        legs: as for `nk.imitation.imitate`.
    """

    source: str
    time: float
    says: str
    camera: float
    pose: Angles | None = None
    hips: tuple[float, float, float] = (0.0, 0.0, 0.0)
    legs: Literal["stand", "follow"] = "stand"

    def skeleton(self) -> Skeleton:
        """Return the person."""
        if self.pose is None:
            return nk.imitation.read_skeleton(SAMPLES[self.source])
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder, "person.bvh")
            file.write_text(bvh(self.motion, 3.0, 20))
            person = nk.imitation.read_skeleton(file)
        points, head = dict(person.points), person.orientations["head"]
        for name, sign in (("nose", 1.0), ("left_ear", 1.0), ("right_ear", -1.0)):
            points[name] = points["head"] + head @ (FACE[name.split("_")[-1]] * np.array([1.0, sign, 1.0]))
        return Skeleton.from_landmarks(in_layout(points, self.source), self.source, times=person.times)

    def motion(self, time: float) -> tuple[tuple[float, float, float], Angles]:
        """Return the place of the hips [cm] and the angles at a time [s]."""
        on, still = rising(time, 0.5, 2.0), (0.0, 0.0, 0.0)
        x, y, z = (on * value for value in self.hips)
        angles: dict[str, tuple[float, float, float]] = {}
        for joint, there in {**HANGING, **(self.pose or {})}.items():
            a, b, c = (1.0 - on) * np.array(HANGING.get(joint, still)) + on * np.array(there)
            angles[joint] = (a, b, c)
        return (x, 95.0 + y, z), angles

    def imitated(self, nao: nk.NaoModel) -> tuple[Imitation, float]:
        """Return the imitation, and the time of the picture in its motion; what it says is as quoted."""
        made = imitate(nao, self.skeleton(), legs=self.legs)
        for text in (made.describe(), " ".join(PAGE.read_text(encoding="utf-8").split())):
            if self.says not in text:
                raise ValueError(f"expected {self.says!r} in:\n{text}")
        return made, float(np.interp(self.time, made.times, made.played))

    def view(self) -> Floats:
        """Return the pose of the camera."""
        R = nk.rotations.rot_z(np.pi + np.deg2rad(self.camera)) @ nk.rotations.rot_y(ABOVE)
        return nk.screws.pose(R, CENTRE - DISTANCE * R[:, 0])


def in_layout(points: dict[str, Floats], source: str) -> Floats:
    """Return points as an array in the order and axes of a source, with y up if it has no axes; NaN for others."""
    layout = LAYOUTS[source]
    order = layout.orders[0]
    named = {joints[0]: name for name, joints in layout.resolved(order).items() if len(joints) == 1}
    unknown = np.full_like(points["head"], np.nan)
    places = np.stack([points.get(named.get(joint, ""), unknown) for joint in order], axis=1)
    array = np.empty_like(places)
    for k, axis in enumerate(layout.axes or ("z", "x", "y")):
        array[..., "xyz".index(axis[-1])] = places[..., k] * (-1.0 if axis[0] == "-" else 1.0)
    return array


def _both(left: Angles) -> Angles:
    """Return angles of the left side with their mirror image."""
    return {**left, **{name.replace("Left", "Right"): (-z, x, -y) for name, (z, x, y) in left.items()}}


CROUCH = {"LeftUpLeg": (0.0, -95.0, 0.0), "LeftLeg": (0.0, 115.0, 0.0), "LeftFoot": (0.0, -35.0, 0.0)}
TAKES = {
    "circles": Take("circles", 5.0, "nao_v6 can perform the motion: 23 joints, 0 to 8 s", -22.0),
    "bow": Take("bow", 1.5, "nao_v6 can perform the motion: 23 joints, 0 to 3 s", -30.0),
    "crouch": Take(
        "kinect_v2",
        2.6,
        "margin 64.3 mm at rest, 62.3 mm moving",
        -35.0,
        {
            **_both({**CROUCH, "LeftArm": (5.0, 0.0, -80.0)}),
            "Hips": (0.0, 15.0, 0.0),
            "Spine1": (0.0, 15.0, 0.0),
            "Head": (0.0, -25.0, 0.0),
        },
        (0.0, -44.0, -8.0),
        "follow",
    ),
    "wave": Take(
        "coco18",
        2.6,
        "right forearm: 20.2° off, at most 38.1°; 100% outside of limits",
        -15.0,
        {"RightArm": (45.0, 0.0, 40.0), "RightForeArm": (-142.0, 0.0, 0.0), "Head": (6.0, 0.0, -8.0)},
    ),
    "behind": Take(
        "h36m17",
        2.6,
        "left upper arm: 14.3° off, at most 27.3°; 54% outside of limits; 72% to make room",
        155.0,
        _both({"LeftArm": (-78.0, 0.0, 45.0), "LeftForeArm": (-95.0, 0.0, 15.0)}),
    ),
    "kick": Take(
        "smpl",
        2.4,
        "no balanced pose was found for 3 of 61 frames, the first at 1.1 s of the person: interpolated",
        -10.0,
        {**_both({"LeftArm": (-50.0, 0.0, -20.0)}), "LeftUpLeg": (75.0, 0.0, 0.0), "Spine1": (-15.0, 0.0, 0.0)},
        legs="follow",
    ),
}


def main() -> None:
    """Print what is said of each take."""
    nao = nk.load_nao()
    for name, take in TAKES.items():
        print(f"{name}, {take.source}:\n{take.imitated(nao)[0].describe()}\n")


if __name__ == "__main__":
    main()
