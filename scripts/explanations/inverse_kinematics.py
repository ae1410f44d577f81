"""The figures of inverse kinematics and of screws, drawn with matplotlib."""

from __future__ import annotations

import io
import re
from functools import partial
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Arc, FancyArrowPatch, Polygon

import nao_kin as nk
from explanations.drawing import Floats

STYLE = {
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "svg.hashsalt": "nao_kin",
    "svg.fonttype": "path",
    "mathtext.fontset": "cm",
}
INK, PALE, BODY, PLANE = "#30343b", "#9aa0a6", "#c9ced6", "#dce8f5"
LEFT, RIGHT, CHOICE = "#1f6fb2", "#c4572e", "#3a8f4d"
AXES = ("#c4572e", "#3a8f4d", "#1f6fb2")  # x, y, z
YAW_PITCH, ROLL, PITCH = "#7b4fa3", "#c4572e", "#1f6fb2"
# Corners of Romeo's sole about its frame [m].
_SOLE = np.array([(0.16, 0.05, 0.0), (0.16, -0.05, 0.0), (-0.08, -0.05, 0.0), (-0.08, 0.05, 0.0)])


class View:
    """Parallel projection of space, drawn in metres.

    Args:
        axes: the matplotlib axes.
        azimuth: direction of the viewer, from the robot's front to its left [deg].
        elevation: elevation of the viewer [deg].
    """

    def __init__(self, axes: Any, azimuth: float, elevation: float) -> None:
        a, e = np.radians([azimuth, elevation])
        self.axes = axes
        self._across = np.array([-np.sin(a), np.cos(a), 0.0])
        self._up = np.array([-np.cos(a) * np.sin(e), -np.sin(a) * np.sin(e), np.cos(e)])
        axes.set_aspect("equal")
        axes.axis("off")

    def flat(self, points: Any) -> Floats:
        """Return points in the picture, shape (..., 2)."""
        return np.stack([np.asarray(points) @ self._across, np.asarray(points) @ self._up], axis=-1)

    def line(self, points: Any, colour: str, width: float, **more: Any) -> None:
        """Draw connected straight lines."""
        self.axes.plot(*self.flat(points).T, color=colour, linewidth=width, solid_capstyle="round", **more)

    def area(self, points: Any, colour: str, **more: Any) -> None:
        """Draw a polygon."""
        self.axes.add_patch(Polygon(self.flat(points), closed=True, facecolor=colour, **more))

    def axis(self, point: Floats, direction: Floats, length: float, colour: str, label: str) -> None:
        """Draw a joint axis through a point, with its name behind the tip."""
        self.line([point - length * direction, point + length * direction], colour, 1.4, zorder=5)
        tip = self.flat([point + 0.8 * length * direction, point + 1.15 * length * direction])
        arrow = FancyArrowPatch(*tip, arrowstyle="-|>", mutation_scale=9, color=colour, linewidth=1.4, zorder=5)
        self.axes.add_patch(arrow)
        x, y = (tip[1] - tip[0]) / np.linalg.norm(tip[1] - tip[0])
        across = "left" if x > 0.3 else "right" if x < -0.3 else "center"
        along = "bottom" if y > 0.6 else "top" if y < -0.6 else "center"
        self.axes.annotate(
            label, tip[1], (4.0 * x, 4.0 * y), textcoords="offset points", color=colour, ha=across, va=along, zorder=9
        )

    def text(self, point: Floats, label: str, colour: str = INK, **more: Any) -> None:
        """Draw text at a point."""
        place = {"ha": "center", "va": "center"} | more
        self.axes.text(*self.flat(point), label, color=colour, zorder=9, **place)

    def dot(self, point: Floats, colour: str = INK, size: float = 5.0, **more: Any) -> None:
        """Draw a joint."""
        self.axes.plot(*self.flat(point), "o", markersize=size, color=colour, zorder=8, **more)


def draw_leg(nao: nk.NaoModel) -> Figure:
    """Draw the axes of a leg in space, and the triangle of hip, knee and ankle in its plane."""
    figure, (space, plane) = plt.subplots(1, 2, figsize=(7.6, 4.7), gridspec_kw={"width_ratios": [1.0, 1.0]})
    q = nao.configuration({"LHipRoll": 0.12, "LHipPitch": -0.75, "LKneePitch": 1.25, "LAnklePitch": -0.5})
    hip, knee, ankle = (nao.position(q, "L" + joint) for joint in ("HipPitch", "KneePitch", "AnklePitch"))
    view = View(space, 38.0, 16.0)
    other = hip * [1.0, -1.0, 1.0]
    view.line([hip, other], BODY, 7.0, zorder=1)
    view.line([0.5 * (hip + other), 0.5 * (hip + other) + [0.0, 0.0, 0.06]], BODY, 12.0, zorder=1)
    view.dot(other, BODY, 7.0)
    view.area([hip, knee, ankle], PLANE, edgecolor="none", zorder=0)
    view.line([hip, ankle], PALE, 1.1, linestyle=(0, (4, 3)), zorder=2)
    view.line([hip, knee, ankle], BODY, 7.0, zorder=3)
    view.line([hip, knee, ankle], INK, 1.0, zorder=4)
    T_torso_foot = nao.fk(q, "LFoot")
    R, sole = T_torso_foot[:3, :3], nao.position(q, "l_sole")
    corners = [sole + R @ [x, y, 0.0] for x, y in ((0.10, 0.035), (0.10, -0.03), (-0.05, -0.03), (-0.05, 0.035))]
    view.area(corners, BODY, edgecolor=INK, linewidth=0.8, alpha=0.85, zorder=1)
    view.line([ankle, sole], INK, 1.0, zorder=4)
    x, y = np.eye(3)[0], np.eye(3)[1]
    view.axis(hip, (y - np.eye(3)[2]) / np.sqrt(2.0), 0.055, YAW_PITCH, "HipYawPitch")
    thigh = nao.rotation(q, "LHipRoll")
    view.axis(hip, x, 0.065, ROLL, "HipRoll")
    view.axis(hip, thigh @ y, 0.055, PITCH, "HipPitch")
    view.axis(knee, thigh @ y, 0.045, PITCH, "KneePitch")
    view.axis(ankle, thigh @ y, 0.045, PITCH, "AnklePitch")
    view.axis(ankle, R @ x, 0.065, ROLL, "AnkleRoll")
    for point in (hip, knee, ankle):
        view.dot(point)
    space.set_title("three axes in the hip, two in the ankle", color=INK, fontsize=9.5, pad=10)
    _draw_triangle(plane, *(float(np.linalg.norm(part)) for part in (hip - knee, knee - ankle)))
    return figure


def _draw_triangle(axes: Any, thigh: float, tibia: float) -> None:
    """Draw hip, knee and ankle in the plane of the leg, in the frame of the foot."""
    bend, pitch = 1.25, -0.45
    ankle = np.zeros(2)
    knee = ankle + tibia * np.array([-np.sin(pitch), np.cos(pitch)])
    hip = knee + thigh * np.array([-np.sin(pitch + bend), np.cos(pitch + bend)])
    axes.add_patch(Polygon([hip, knee, ankle], facecolor=PLANE, edgecolor="none"))
    axes.plot(*np.transpose([hip, knee, ankle]), color=INK, linewidth=1.6, solid_capstyle="round")
    axes.plot(*np.transpose([hip, ankle]), color=PALE, linewidth=1.1, linestyle=(0, (4, 3)))
    beyond = knee + 0.045 * (knee - ankle) / tibia
    axes.plot(*np.transpose([knee, beyond]), color=PALE, linewidth=0.9)
    first = np.degrees(np.arctan2(*(beyond - knee)[::-1]))
    last = np.degrees(np.arctan2(*(hip - knee)[::-1]))
    axes.add_patch(Arc((knee[0], knee[1]), 0.06, 0.06, theta1=first, theta2=last, color=PITCH, linewidth=1.2))
    axes.text(*np.add(knee, (-0.012, 0.040)), "$q_4$", color=PITCH, ha="center", fontsize=11)
    for end, name in ((np.array([0.075, 0.0]), "$x$"), (np.array([0.0, 0.075]), "$z$")):
        axes.add_patch(
            FancyArrowPatch((0.0, 0.0), (end[0], end[1]), arrowstyle="-|>", mutation_scale=8, color=PALE, linewidth=1.0)
        )
        axes.text(*(1.1 * end), name, color=PALE, ha="center", va="center", fontsize=10)
    along = np.degrees(np.arctan2(*knee[::-1]))
    axes.add_patch(Arc((0.0, 0.0), 0.085, 0.085, theta1=along, theta2=90.0, color=PITCH, linewidth=1.2))
    axes.text(0.0165, 0.052, "$q_5$", color=PITCH, ha="center", fontsize=11)
    axes.plot([-0.035, 0.09], [-0.03, -0.03], color=INK, linewidth=3.0, solid_capstyle="round")
    axes.plot([0.0, 0.0], [0.0, -0.03], color=INK, linewidth=1.0)
    for point, name, place in (
        (hip, "hip", (-0.018, 0.004)),
        (knee, "knee", (0.022, 0.0)),
        (ankle, "ankle", (-0.024, 0.0)),
    ):
        axes.plot(*point, "o", color=INK, markersize=5)
        axes.text(*(point + place), name, color=INK, ha="center", va="center")
    for one, two, name, place in ((hip, knee, "$L_1$", (0.004, 0.013)), (knee, ankle, "$L_2$", (0.014, -0.004))):
        axes.text(*(0.5 * (one + two) + place), name, color=INK, ha="center", va="center", fontsize=11)
    axes.text(*(0.5 * (hip + ankle) + [-0.012, 0.0]), "$d$", color=INK, ha="center", va="center", fontsize=11)
    axes.text(*np.add(hip, (0.016, 0.006)), r"$w = (h_x, \pm\sqrt{h_y^2 + h_z^2})$", color=INK, ha="left", fontsize=10)
    axes.set_title("the plane of the leg, from the foot", color=INK, fontsize=9.5, pad=10)
    axes.set_aspect("equal")
    axes.axis("off")
    axes.margins(0.08)


def draw_arm(nao: nk.NaoModel) -> Figure:
    """Draw the sphere of the elbow, and the elbow that the hand's pose requires."""
    figure, axes = plt.subplots(figsize=(6.4, 4.4))
    q = nao.configuration(
        {"LShoulderPitch": 0.95, "LShoulderRoll": 0.85, "LElbowYaw": -2.05, "LElbowRoll": -1.25, "LWristYaw": 0.3}
    )
    shoulder = nao.position(q, "LShoulderPitch")
    elbow = nao.position(q, "LElbowYaw")
    wrist, hand = nao.position(q, "LWristYaw"), nao.position(q, "LArm")
    radius = float(np.linalg.norm(elbow - shoulder))
    view = View(axes, 18.0, 18.0)
    centre = view.flat(shoulder)
    axes.add_patch(plt.Circle(centre, radius, facecolor=PLANE, edgecolor=PALE, linewidth=1.0, alpha=0.55, zorder=0))
    turn = np.linspace(0.0, 2.0 * np.pi, 181)
    for u, v in ((0, 1), (0, 2), (1, 2)):
        ring = np.tile(shoulder, (181, 1))
        ring[:, u] += radius * np.cos(turn)
        ring[:, v] += radius * np.sin(turn)
        view.line(ring, PALE, 0.6, alpha=0.7, zorder=1)
    trunk = shoulder * [1.0, 0.0, 1.0]
    view.line([shoulder, trunk], BODY, 7.0, zorder=1)
    view.line([np.add(trunk, (0.0, 0.0, 0.02)), trunk - [0.0, 0.0, 0.12]], BODY, 13.0, zorder=1)
    upper = nao.rotation(q, "LShoulderRoll")
    corner = shoulder + upper @ np.array([(upper.T @ (elbow - shoulder))[0], 0.0, 0.0])
    view.line([shoulder, corner, elbow], BODY, 7.0, zorder=3)
    view.line([shoulder, corner, elbow], INK, 1.0, zorder=4)
    view.line([shoulder, elbow], PALE, 1.1, linestyle=(0, (4, 3)), zorder=4)
    view.line([elbow, wrist, hand], BODY, 7.0, zorder=3)
    view.line([elbow, wrist, hand], INK, 1.0, zorder=4)
    x, y, z = np.eye(3)
    forearm = nao.rotation(q, "LWristYaw")
    view.axis(shoulder, y, 0.03, PITCH, "ShoulderPitch")
    view.axis(shoulder, nao.rotation(q, "LShoulderPitch") @ z, 0.04, YAW_PITCH, "ShoulderRoll")
    view.axis(elbow, upper @ x, 0.035, ROLL, "ElbowYaw")
    view.axis(elbow, nao.rotation(q, "LElbowYaw") @ z, 0.035, YAW_PITCH, "ElbowRoll")
    view.axis(hand, forearm @ x, 0.03, ROLL, "WristYaw")
    for point in (shoulder, elbow, hand):
        view.dot(point)
    view.text(np.add(0.5 * (shoulder + elbow), (0.0, 0.0, 0.012)), "$|e|$", fontsize=11)
    view.text(np.add(hand, (0.0, -0.010, 0.004)), "hand at $p$,\nturned by $R$", ha="right")
    view.text(np.add(elbow, (0.0, -0.026, -0.024)), "elbow at $p - R\\,h$", ha="right")
    return figure


def draw_legs(nao: nk.NaoModel) -> Figure:
    """Draw the rotation of each foot over HipYawPitch, for hips that disagree."""
    q = nao.posture("StandInit")
    column = nao.joint_names.index("LHipYawPitch")
    feet = []
    for side, hip in (("L", -0.65), ("R", -0.05)):
        q[column] = hip
        feet.append(nao.fk(q, side + "Leg"))
    hips, turns = _turns(nao, feet[0], feet[1])
    figure, axes = plt.subplots(figsize=(6.8, 4.0))
    both = np.hypot(*turns)
    inside = np.isfinite(both)
    axes.axhline(0.0, color=PALE, linewidth=0.8)
    axes.axvspan(hips[inside][0], hips[inside][-1], color=PLANE, alpha=0.55, linewidth=0)
    axes.text(hips[inside][0], 0.02, "  inside the limits of both legs", color=PALE, ha="left", va="bottom",
              transform=axes.get_xaxis_transform())  # fmt: skip
    for turn, colour, name in zip(turns, (LEFT, RIGHT), ("left", "right"), strict=True):
        axes.plot(hips, np.degrees(turn), color=colour, linewidth=2.0, label=f"$\\psi$ of the {name} foot")
    axes.plot(hips, np.degrees(both), color=CHOICE, linewidth=1.6, linestyle=(0, (5, 2)),
              label=r"$\sqrt{\psi_L^2 + \psi_R^2}$")  # fmt: skip
    for priority, colour in (("left", LEFT), ("balanced", CHOICE), ("right", RIGHT)):
        found = nk.ik.legs(nao, *feet, priority=priority)  # type: ignore[arg-type]
        hip, errors = float(found.q[column]), np.degrees(found.yaw_errors)
        axes.plot([hip, hip], errors, color=colour, linewidth=1.0, linestyle=":")
        axes.plot([hip], errors[:1], "o", color=LEFT, markersize=5.5, zorder=5)
        axes.plot([hip], errors[1:], "o", color=RIGHT, markersize=5.5, zorder=5)
        axes.annotate(f'"{priority}"', (hip, min(errors)), (0, -14), textcoords="offset points", color=colour,
                      ha="center", va="top")  # fmt: skip
    axes.set_xlabel("HipYawPitch [rad]")
    axes.set_ylabel("turn of the foot about its normal [deg]")
    axes.legend(frameon=False, loc="upper left")
    axes.set_xlim(-1.3, 0.9)
    axes.margins(y=0.12)
    return figure


def draw_branches(_: nk.NaoModel) -> Figure:
    """Draw all branches of Romeo's left leg for one pose of the foot."""
    romeo = nk.load_robot("romeo")
    q = romeo.neutral()
    bent = {
        "LHipYaw": -0.25,
        "LHipRoll": 0.22,
        "LHipPitch": -0.5,
        "LKneePitch": 0.9,
        "LAnklePitch": -0.3,
        "LAnkleRoll": 0.1,
    }
    q[[romeo.joint_names.index(joint) for joint in bent]] = list(bent.values())
    found = nk.ik.analytic(romeo, "l_sole", romeo.fk(q, "l_sole"), limits="ignore", near=q)
    figure, pictures = plt.subplots(2, 4, figsize=(7.4, 5.4))
    hip = romeo.position(q, "LHipPitch")
    for number, (axes, solution) in enumerate(zip(pictures.flat, found.solutions, strict=True), start=1):
        view = View(axes, 42.0, 14.0)
        inside = bool(romeo.within_limits(solution))
        joints = romeo.position(solution, "LHipPitch"), romeo.position(solution, "LKneePitch")
        ankle, T = romeo.position(solution, "LAnklePitch"), romeo.fk(solution, "l_sole")
        sole = [T[:3, :3] @ corner + T[:3, 3] for corner in _SOLE]
        axes.add_patch(Polygon(view.flat(sole), facecolor=PLANE, edgecolor=PALE, linewidth=0.8, zorder=0))
        view.line([joints[0] + [0.0, 0.0, 0.08], hip], BODY, 9.0, zorder=1)
        view.line([*joints, ankle, T[:3, 3]], CHOICE if inside else BODY, 6.0, zorder=2)
        view.line([*joints, ankle, T[:3, 3]], INK, 1.0, zorder=3)
        # The directions of two axes tell branches apart that have the knee on the same side.
        view.axis(joints[0], romeo.rotation(solution, "LHipRoll")[:, 0], 0.09, ROLL, "HipRoll")
        view.axis(joints[1], romeo.rotation(solution, "LKneePitch")[:, 1], 0.09, PITCH, "KneePitch")
        for point in (*joints, ankle):
            view.dot(point)
        axes.margins(0.02)
        axes.set_title(f"{number}  {'inside' if inside else 'outside'}", color=CHOICE if inside else INK, fontsize=9)
    return figure


def _turns(nao: nk.NaoModel, T_left: Floats, T_right: Floats) -> tuple[Floats, tuple[Floats, Floats]]:
    """Return HipYawPitch in steps, and the rotations of both feet, nan outside the limits.

    The HipYawPitch of a foot rotated by ψ is known in closed form. Therefore ψ is sampled, and the function inverted.
    """
    hips = np.linspace(-1.2, 0.8, 801)
    steps = np.linspace(-1.5, 1.5, 3001)
    turns = []
    for side, T in (("L", T_left), ("R", T_right)):
        turned = np.tile(T, (len(steps), 1, 1))
        turned[:, :3, :3] = T[:3, :3] @ nk.rotations.rot_z(steps)
        found = nk.ik.leg(nao, side, turned)
        known = np.asarray(found.success)
        at, turn = found.best[known, 0], steps[known]
        order = np.argsort(at)
        turns.append(np.interp(hips, at[order], turn[order], left=np.nan, right=np.nan))
    return hips, (turns[0], turns[1])


def draw_frame(view: View, T: Floats, length: float, width: float) -> None:
    """Draw three short axes."""
    for axis, colour in zip(T[:3, :3].T, AXES, strict=True):
        view.line([T[:3, 3], T[:3, 3] + length * axis], colour, width, zorder=6)


def draw_screw(_: nk.NaoModel) -> Figure:
    """Draw the axis, both paths of a body from one pose to another, and the foot of the perpendicular to the axis."""
    figure, axes = plt.subplots(figsize=(6.4, 4.2))
    view = View(axes, -62.0, 24.0)
    line = nk.screws.lines.PluckerLine.from_point_direction([0, 0, 0], [0, 0, 1])
    T_0 = nk.screws.pose(nk.rotations.matrix_from_rpy([0.5, 0.3, -0.4]), [1.0, -0.3, 0.0])
    T_1 = nk.screws.Screw(line, 1.9, 0.8).pose @ T_0
    shorter = nk.screws.sclerp(T_0, T_1, np.linspace(0, 1, 101))
    longer = nk.screws.sclerp(T_0, T_1, np.linspace(0, 1, 101), arc="longer")
    view.line(longer[:, :3, 3], PALE, 1.3, linestyle=(0, (4, 3)), zorder=2)
    view.line(shorter[:, :3, 3], YAW_PITCH, 2.0, zorder=4)
    for T in shorter[::20]:
        foot = line.closest_point(T[:3, 3])
        view.line([foot, T[:3, 3]], BODY, 1.0, zorder=1)
        draw_frame(view, T, 0.24, 2.0)
    for T in longer[20:100:20]:
        draw_frame(view, T, 0.16, 1.0)
    feet = line.closest_point(np.stack([T_0[:3, 3], T_1[:3, 3]]))
    view.axis(np.array([0.0, 0.0, 0.4]), np.array([0.0, 0.0, 1.0]), 0.9, INK, "axis")
    view.line(feet, INK, 3.0, zorder=5)
    view.text(0.5 * (feet[0] + feet[1]) + [-0.12, -0.06, 0.0], "slide", ha="right")
    view.text(T_0[:3, 3] + [0.12, 0.0, -0.2], "$T_0$")
    view.text(T_1[:3, 3] + [0.0, 0.0, 0.34], "$T_1$")
    view.text(shorter[50, :3, 3] + [0.2, 0.1, -0.12], "angle θ", YAW_PITCH, ha="left")
    view.text(longer[30, :3, 3] + [0.0, 0.0, -0.2], "the longer way, θ − 2π", ha="right")
    return figure


def _svg(name: str) -> str:
    """Return a figure as SVG, without the version of matplotlib, and with the same identifiers whatever its digits."""
    with plt.rc_context(STYLE):
        figure, content = _FIGURES[name](nk.load_nao()), io.StringIO()
        figure.tight_layout()
        figure.savefig(content, format="svg", metadata={"Date": None, "Creator": None})
    plt.close(figure)
    text = content.getvalue()
    for number, identifier in enumerate(dict.fromkeys(re.findall(r'id="([pm][0-9a-f]{10})"', text))):
        text = text.replace(identifier, f"{identifier[0]}_{number}")
    return text


_FIGURES = {
    "ik_leg": draw_leg,
    "ik_arm": draw_arm,
    "ik_legs": draw_legs,
    "ik_branches": draw_branches,
    "screw": draw_screw,
}
FIGURES = {name: partial(_svg, name) for name in _FIGURES}
