"""Draw the NAO's kinematic tree with symbols of its URDF joints and of merged joints, or check the drawing.

Example:
    python scripts/generate_joint_diagram.py            # writes docs/images/kinematic_tree.svg
    python scripts/generate_joint_diagram.py --check    # exit 1 if the file differs
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from nao_kin import NaoModel, load_nao
from nao_kin._core.files import write_text
from nao_kin.joints import JointGroups, MultiDofJoint, group_joints
from nao_kin.joints.grouping import unmerged_joints
from nao_kin.joints.tables import body_part

OUTPUT = Path(__file__).resolve().parent.parent / "docs" / "images" / "kinematic_tree.svg"

Point = tuple[float, float]
Floats = NDArray[np.float64]

PANEL, HEIGHT = 465.0, 545.0
SCALE = 700.0  # pixels per metre
ORIGIN = (174.0, 238.0)  # the torso point within a panel
GAP = 16.0  # pixels between symbols of joints that share a centre
INK, BONE, TRUNK, MOTOR = "#1f2937", "#9ca3af", "#e5e7eb", "#7c3aed"
COLOURS = {"revolute": "#2563eb", "universal": "#d97706", "spherical": "#dc2626"}

# Arms slightly away from the body, feet apart: every joint is visible from the front.
POSTURE = {
    "LShoulderPitch": 90.0,
    "LShoulderRoll": 32.0,
    "RShoulderPitch": 90.0,
    "RShoulderRoll": -32.0,
    "LHipRoll": 6.0,
    "RHipRoll": -6.0,
}


class Figure:
    """The NAO from the front: points and directions of space as points and directions of the page."""

    def __init__(self, nao: NaoModel) -> None:
        self.nao = nao
        self._zero = nao.neutral()
        angles = {name: math.radians(value) for name, value in POSTURE.items()}
        self._q = nao.configuration(angles, limits="ignore")

    def centre(self, joint: MultiDofJoint) -> Point:
        """Return the position of a joint."""
        T_zero, T_shown = (self.nao.fk(q, joint.joints[0]) for q in (self._zero, self._q))
        return self._on_page(T_shown[:3, :3] @ T_zero[:3, :3].T @ (joint.centre - T_zero[:3, 3]) + T_shown[:3, 3])

    def axis(self, joint: MultiDofJoint, part: int) -> Floats:
        """Return the direction of an axis: right, up, and towards the reader."""
        R_zero, R_shown = (self.nao.rotation(q, joint.joints[part]) for q in (self._zero, self._q))
        x, y, z = R_shown @ R_zero.T @ joint.axes[part]
        return np.array([y, z, x])

    def frame(self, name: str) -> Point:
        """Return the position of a frame's origin."""
        return self._on_page(self.nao.position(self._q, name))

    @staticmethod
    def _on_page(position: Floats) -> Point:
        return ORIGIN[0] + SCALE * float(position[1]), ORIGIN[1] - SCALE * float(position[2])


def revolute(at: Point, axis: Floats) -> list[str]:
    """Draw a cylinder along the axis; seen from its end, a circle with a dot."""
    colour = COLOURS["revolute"]
    if abs(axis[2]) > 0.9:
        return [_circle(at, 6.0, "white", colour), _circle(at, 1.8, colour, "none")]
    turn = -math.degrees(math.atan2(axis[1], axis[0]))
    return [
        f'<g transform="translate({_xy(at)}) rotate({_n(turn)})">'
        f'<rect x="-9" y="-4.5" width="18" height="9" rx="2" fill="white" stroke="{colour}" stroke-width="2"/>'
        f'<line x1="-13" y1="0" x2="13" y2="0" stroke="{colour}" stroke-width="1.2"/></g>'
    ]


def universal(at: Point) -> list[str]:
    """Draw a ring with a cross: the two axes of Hooke's joint."""
    colour = COLOURS["universal"]
    cross = [_line((at[0] - dx, at[1] - dy), (at[0] + dx, at[1] + dy), colour, 2.0) for dx, dy in ((9, 0), (0, 9))]
    return [_circle(at, 9.0, "white", colour), *cross]


def spherical(at: Point) -> list[str]:
    """Draw a ball in its socket."""
    x, y = at
    socket = f'<path d="M {_n(x - 9.2)} {_n(y + 5.3)} A 10.6 10.6 0 1 1 {_n(x + 9.2)} {_n(y + 5.3)}" '
    socket += f'fill="white" stroke="{COLOURS["spherical"]}" stroke-width="2.2" stroke-linecap="round"/>'
    return [socket, _circle(at, 6.6, COLOURS["spherical"], "none")]


def panel(figure: Figure, groups: JointGroups, title: str, label: Callable[[MultiDofJoint], str]) -> list[str]:
    """Draw the figure with the symbols of its joints, and labels on the robot's left side."""
    centres = {joint.name: figure.centre(joint) for joint in groups}
    drawn = [_text((ORIGIN[0], 28.0), title, 17, anchor="middle", weight="600")]
    drawn += skeleton(figure)
    left, right = (figure.frame(f"{side}HipYawPitch") for side in "LR")
    dip = left[1] + 46.0
    drawn.append(
        f'<path d="M {_xy(left, " ")} Q {_n((left[0] + right[0]) / 2)} {_n(dip)} {_xy(right, " ")}" fill="none" '
        f'stroke="{MOTOR}" stroke-width="2" stroke-dasharray="4 3"/>'
    )
    drawn.append(_text(((left[0] + right[0]) / 2, dip - 5.0), "one motor", 12, anchor="middle", fill=MOTOR))
    together: dict[Point, list[MultiDofJoint]] = {}
    for joint in groups:
        together.setdefault(centres[joint.name], []).append(joint)
    for at, joints in together.items():
        # Joints that share a centre are drawn in a row, the neck's upwards, away from the shoulders.
        outwards, first = (-1.0, 0.3) if "Head" in joints[0].name else (1.0, -(len(joints) - 1) / 2)
        for k, joint in enumerate(joints):
            spot = (at[0], at[1] + outwards * GAP * (k + first))
            drawn += symbol(figure, joint, spot)
            if not joint.joints[0].startswith("R"):
                drawn.append(_text((at[0] + 18.0, spot[1] + 4.5), label(joint), 13))
    drawn.append(_text((ORIGIN[0], HEIGHT - 16.0), groups.summary, 15, anchor="middle"))
    return drawn


def symbol(figure: Figure, joint: MultiDofJoint, at: Point) -> list[str]:
    """Draw the symbol of a joint."""
    if joint.pair.name == "universal":
        return universal(at)
    return spherical(at) if joint.pair.name == "spherical" else revolute(at, figure.axis(joint, 0))


def skeleton(figure: Figure) -> list[str]:
    """Draw trunk, head and limbs."""
    corners = [figure.frame(f"{name}") for name in ("LShoulderPitch", "LHipRoll", "RHipRoll", "RShoulderPitch")]
    outline = " ".join(_xy(corner) for corner in corners)
    neck = figure.frame("HeadYaw")
    between = ((corners[0][0] + corners[3][0]) / 2, corners[0][1])
    drawn = [
        f'<polygon points="{outline}" fill="{TRUNK}" stroke="{TRUNK}" stroke-width="22" stroke-linejoin="round"/>',
        _line(between, neck, BONE, 6.0),
        f'<ellipse cx="{_n(neck[0])}" cy="{_n(neck[1] - 48)}" rx="44" ry="36" fill="{TRUNK}"/>',
        _line(neck, (neck[0], neck[1] - 30.0), BONE, 6.0),
    ]
    for side in "LR":
        arm = [figure.frame(f"{side}{part}") for part in ("ShoulderPitch", "ElbowYaw", "WristYaw", "Hand")]
        leg = [figure.frame(f"{side}{part}") for part in ("HipRoll", "KneePitch", "AnklePitch", "Leg")]
        drawn += [_line(a, b, BONE, 6.0) for limb in (arm, leg) for a, b in pairwise(limb)]
        foot = leg[-1]
        drawn.append(_line((foot[0] - 20.0, foot[1]), (foot[0] + 20.0, foot[1]), BONE, 8.0))
    return drawn


def legend() -> list[str]:
    """Draw the legend of the symbols."""
    x, y, step = 70.0, 150.0, 48.0
    entries: tuple[tuple[list[str], str], ...] = (
        (revolute((x, y), np.array([1.0, 0.0, 0.0])), "revolute, 1 freedom"),
        (revolute((x, y + step), np.array([0.0, 0.0, 1.0])), "the same, its axis towards you"),
        (universal((x, y + 2 * step)), "universal, 2 freedoms"),
        (spherical((x, y + 3 * step)), "spherical, 3 freedoms"),
        ([_line((x - 13.0, y + 4 * step), (x + 13.0, y + 4 * step), MOTOR, 2.0, dashes=True)], "coupling, −1 freedom"),
    )
    drawn = []
    for k, (marks, words) in enumerate(entries):
        drawn += [*marks, _text((x + 32.0, y + k * step + 5.0), words, 15)]
    for k, words in enumerate(("Seen from the front; the labels are", "those of the robot's left side.")):
        drawn.append(_text((x - 14.0, y + 5.4 * step + 20.0 * k), words, 13))
    return drawn


def diagram(nao: NaoModel) -> str:
    """Return the SVG."""
    figure = Figure(nao)

    def in_words(joint: MultiDofJoint) -> str:
        return f"{body_part(joint.joints[0]).removeprefix('left ')}: {joint.pair.name}"

    panels = [
        panel(figure, unmerged_joints(nao), "the URDF: revolutes", lambda joint: joint.name),
        panel(figure, group_joints(nao), "centres that coincide, merged", in_words),
        panel(figure, group_joints(nao, rule="concurrent"), "axes that meet, merged", in_words),
    ]
    panels.append(legend())
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_n(2 * PANEL)} {_n(2 * HEIGHT)}" '
        'font-family="Helvetica, Arial, sans-serif" role="img" aria-labelledby="title">',
        '<title id="title">Kinematic tree of the NAO, seen from the front, with its joints as '
        "revolutes and as universal and spherical joints</title>",
        '<rect width="100%" height="100%" rx="8" fill="white"/>',
    ]
    for k, drawn in enumerate(panels):
        lines += [f'<g transform="translate({_n(PANEL * (k % 2))} {_n(HEIGHT * (k // 2))})">', *drawn, "</g>"]
    return "\n".join([*lines, "</svg>", ""])


def _n(value: float) -> str:
    """Return a coordinate to a tenth of a pixel, as short as possible, without −0."""
    return f"{round(value, 1) + 0.0:g}"


def _xy(point: Point, separator: str = ",") -> str:
    return f"{_n(point[0])}{separator}{_n(point[1])}"


def _line(a: Point, b: Point, colour: str, width: float, *, dashes: bool = False) -> str:
    dashing = ' stroke-dasharray="4 3"' if dashes else ""
    return (
        f'<line x1="{_n(a[0])}" y1="{_n(a[1])}" x2="{_n(b[0])}" y2="{_n(b[1])}" stroke="{colour}" '
        f'stroke-width="{_n(width)}" stroke-linecap="round"{dashing}/>'
    )


def _circle(at: Point, radius: float, fill: str, stroke: str) -> str:
    return (
        f'<circle cx="{_n(at[0])}" cy="{_n(at[1])}" r="{_n(radius)}" fill="{fill}" stroke="{stroke}" stroke-width="2"/>'
    )


def _text(at: Point, words: str, size: float, *, anchor: str = "start", weight: str = "400", fill: str = INK) -> str:
    return (
        f'<text x="{_n(at[0])}" y="{_n(at[1])}" font-size="{_n(size)}" font-weight="{weight}" text-anchor="{anchor}" '
        f'fill="{fill}">{words}</text>'
    )


def main(arguments: list[str] | None = None) -> int:
    """Write or check; return 1 if --check finds a difference, otherwise 0."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="write nothing; fail if the file is out of date")
    parser.add_argument(
        "--output", type=Path, default=OUTPUT, help="the file (default: docs/images/kinematic_tree.svg)"
    )
    options = parser.parse_args(arguments)
    text = diagram(load_nao())
    if not options.check:
        options.output.parent.mkdir(parents=True, exist_ok=True)
        write_text(options.output, text)
        print(options.output)
        return 0
    if options.output.is_file() and options.output.read_text(encoding="utf-8") == text:
        return 0
    print(f"not in step with the model: {options.output} (run scripts/generate_joint_diagram.py)", file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main())
