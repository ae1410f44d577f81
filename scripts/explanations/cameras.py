"""The fields of view of the cameras, and the frames of a camera."""

from __future__ import annotations

import numpy as np

import nao_kin as nk
from explanations.drawing import AXES, BODY, INK, LINE, ORANGE, PALE, Drawing, Floats, View
from explanations.robot_outline import draw_robot, nao_shapes
from explanations.solids import box, draw_solid

TOP, BOTTOM = "#0f766e", ORANGE
COLOURS = {"CameraTop": TOP, "CameraBottom": BOTTOM}
SIGHT, GROUND = 2.1, 1.75  # length of a drawn field of view, in the air and on the ground [m]
FARTHEST, TURN = 2.6, np.linspace(0.0, 2.0 * np.pi, 49)  # points drawn [m], and directions of an ellipse
SCALE, LEFT, SOLE = 240.0, 78.0, 350.0  # pixels per metre, position of the torso, and height of the ground


def eye_of(camera: str) -> tuple[Floats, float, float]:
    """Return a camera's position in the torso with all joints at zero, its height above the ground, and its tilt."""
    nao, _ = nao_shapes()
    q = nao.neutral()
    eye = nao.position(q, camera)
    pitch = nk.rotations.rpy_from_matrix(nao.rotation(q, camera))[1]
    return eye, float(eye[2] - nao.position(q, "LLeg")[2]), float(pitch)


def on_sole() -> Floats:
    """Return the pose of the torso above the ground with all joints at zero."""
    nao, _ = nao_shapes()
    return nk.screws.pose(np.eye(3), [0.0, 0.0, -nao.position(nao.neutral(), "LLeg")[2]])


def fields_of_view() -> Drawing:
    """Draw both fields from the right, down to the ground, and the visible part of the ground from above."""
    nao, _ = nao_shapes()
    drawing = Drawing(
        760, 905, "The fields of view of both cameras of a standing NAO, from the right, and on the ground"
    )
    side_view(drawing)
    ground_view(drawing)
    across, high = np.degrees(nao.semantics.fields_of_view["CameraTop"])
    words = f"V6: {across:.1f}° across, {high:.1f}° high, both cameras alike; joints at zero."
    drawing.text((24, 885), words, 13.5, PALE)
    return drawing


def side_view(drawing: Drawing) -> None:
    """Draw both fields of view from the side, with the points where their edges meet the ground."""
    nao, _ = nao_shapes()
    sole = nao.position(nao.neutral(), "LLeg")[2]
    view = View((LEFT, SOLE + SCALE * sole), SCALE, (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    drawing.text((24, 32), "from the right", 16, weight="600")
    marks = []
    for camera, colour in COLOURS.items():
        eye, height, pitch = eye_of(camera)
        half = nao.semantics.fields_of_view[camera][1] / 2
        down = np.linspace(pitch - half, pitch + half, 200)
        reach = np.minimum(SIGHT, np.where(down > 0, height / np.maximum(np.sin(down), 1e-9), np.inf))
        far = eye + reach[:, None] * np.column_stack([np.cos(down), 0 * down, -np.sin(down)])
        drawing.path(view.flat([eye, *far]), fill=colour, opacity=0.14, stroke=colour, width=1.2, closed=True)
        length, words_at = (1.75, (0.75, 0.13)) if camera == "CameraTop" else (0.34, (0.31, -0.31))
        axis = np.array([np.cos(pitch), 0.0, -np.sin(pitch)])
        drawing.line(view.flat(eye), view.flat(eye + length * axis), colour, 1.2, "6 4")
        at = view.flat(eye + np.array([words_at[0], 0.0, words_at[1]]))
        drawing.text(at, camera, 14, colour, weight="600", halo=True)
        drawing.text(at + np.array([0.0, 18.0]), f"{np.degrees(pitch):.1f}° down", 14, colour, halo=True)
        marks += [(eye[0] + height / np.tan(angle), colour) for angle in (pitch + half, pitch - half) if angle > 0]
    draw_robot(drawing, view, nao.neutral(), fill="#f3f4f6")
    drawing.line((14, SOLE), (746, SOLE), LINE, 1.6)
    for x, colour in sorted(marks):
        foot = view.flat([x, 0.0, sole])
        drawing.line(foot, foot + np.array([0.0, 7.0]), colour, 2.0)
        drawing.text(foot + np.array([0.0, 21.0]), f"{x:.2f} m", 13, colour, anchor="middle")


def ground_view(drawing: Drawing) -> None:
    """Draw the visible part of the ground for both cameras, cut off at a distance."""
    nao, _ = nao_shapes()
    view = View((LEFT, 655.0), SCALE, (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    drawing.text((24, 420), "the ground from above", 16, weight="600")
    for camera, colour in COLOURS.items():
        seen, ahead = nk.world.camera(nao, camera), GROUND - nao.position(nao.neutral(), camera)[0]
        corners = nk.world.visible_ground(nao, nao.neutral(), seen, T_world_base=on_sole(), max_distance=ahead)
        drawing.path(view.flat(corners), fill=colour, opacity=0.14, stroke=colour, width=1.2, closed=True)
    draw_robot(drawing, view, nao.neutral(), fill="#f3f4f6")
    drawing.text(view.flat([0.55, 0.0, 0.0]), "CameraBottom", 14, BOTTOM, weight="600", halo=True)
    drawing.text(view.flat([1.85, 0.0, 0.0]), "CameraTop, and on", 14, TOP, weight="600", halo=True)


def uncertainty() -> Drawing:
    """Draw points of the ground at a grid of pixels from above, each with the ellipse of two standard deviations."""
    nao, _ = nao_shapes()
    q = nao.posture("StandInit")
    drawing = Drawing(760, 500, "Points of the ground at a grid of pixels of both cameras, with their uncertainty")
    view = View((60.0, 250.0), 210.0, (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    circle = np.stack([np.cos(TURN), np.sin(TURN)])
    u, v = np.meshgrid(np.linspace(40.0, 600.0, 5), np.linspace(30.0, 450.0, 7))
    pixels = np.stack([u, v], axis=-1).reshape(-1, 2)
    for name, colour in COLOURS.items():
        camera = nk.world.camera(nao, name)
        points = nk.world.pixel_to_ground(nao, q, pixels, camera).points[:, :2]
        covariances = nk.world.ground_covariance(nao, q, pixels, camera, joint_noise=np.radians(0.5))
        for point, covariance in zip(points, covariances, strict=True):
            if not point[0] < FARTHEST:
                continue
            ellipse = point + 2.0 * (np.linalg.cholesky(covariance) @ circle).T
            outline = view.flat(np.pad(ellipse, ((0, 0), (0, 1))))
            drawing.path(outline, fill=colour, opacity=0.22, stroke=colour, width=1.0, closed=True)
            x, y = view.flat([*point, 0.0])
            drawing.line((x - 2.0, y), (x + 2.0, y), colour, 2.0)
    draw_robot(drawing, view, q, fill="#f3f4f6")
    for x in (1.0, 2.0, 3.0):
        at = view.flat([x, 0.0, 0.0])
        drawing.line((at[0], 462.0), (at[0], 470.0), LINE, 1.6)
        drawing.text((at[0], 488.0), f"{x:.0f} m", 13, PALE, anchor="middle")
    drawing.text((24, 32), "0.5° in each joint, 1 pixel; two standard deviations", 14, PALE)
    drawing.text((24, 60), "CameraTop", 14, TOP, weight="600")
    drawing.text((124, 60), "CameraBottom", 14, BOTTOM, weight="600")
    return drawing


def own_body() -> Drawing:
    """Draw what `CameraBottom` sees of the robot and of a grid on the floor, ahead and to the left."""
    nao, _ = nao_shapes()
    drawing = Drawing(760, 350, "The robot's own body in two images of its lower camera: feet and hands, and an arm")
    camera = nk.world.camera(nao, "CameraBottom")
    ticks = np.arange(-0.4, 1.21, 0.1)
    grid = [[[x, -1.0, 0.0], [x, 1.0, 0.0]] for x in ticks] + [[[-0.5, y, 0.0], [1.5, y, 0.0]] for y in ticks - 0.4]
    colours = {"LLeg": TOP, "RLeg": TOP, "LArm": ORANGE, "RArm": ORANGE}
    firsts = {nao.semantics.chains[chain][0]: colour for chain, colour in colours.items()}
    links = {part.link for shape in nao.link_shapes.shapes for part in shape.parts or (shape,)} - {"Head"}
    pixels = np.stack(np.meshgrid(np.arange(640), np.arange(480)), axis=-1)
    for k, (words, turned) in enumerate((("HeadPitch 28°", {"HeadPitch": 0.5}), ("HeadYaw 60°", {"HeadYaw": 1.05}))):
        q, corner, scale = nao.posture("Stand", turned), np.array([24.0 + 364.0 * k, 52.0]), 0.544
        lines = nk.world.project_lines(nao, q, grid, camera, n=2)
        for line in lines.pixels[lines.visible]:
            drawing.path(corner + scale * line, stroke=BODY, width=1.0)
        for link in sorted(links):
            mask = nk.world.own_body(nao, q, pixels, camera, links=[link])
            if not mask.any():
                continue
            outline = nk.robot.SupportPolygon.around(pixels[mask]).vertices
            moving = {driver.joint for driver in nk.robot.serial_chain(nao, nao.tree.root, link).drivers}
            colour = next((colour for first, colour in firsts.items() if first in moving), PALE)
            drawing.path(corner + scale * outline, fill=colour, opacity=0.25, stroke=colour, width=1.0, closed=True)
        frame = corner + scale * camera.border()
        drawing.path(frame, stroke=LINE, width=1.4, closed=True)
        drawing.text((corner[0], 36), f"CameraBottom, {words}", 15, weight="600")
    drawing.text((24, 338), "the torso grey, arms orange, legs green; squares of 10 cm on the floor", 13.5, PALE)
    return drawing


def camera_frames() -> Drawing:
    """Draw the body frame, the optical frame and the picture of one camera."""
    drawing = Drawing(760, 330, "A camera's body frame, its optical frame, and the axes u and v of its picture")
    nao, _ = nao_shapes()
    optical = nao.rotation(nao.neutral(), "CameraTop").T @ nao.rotation(nao.neutral(), "CameraTop_optical_frame")
    across, down = (np.tan(angle / 2) for angle in nao.semantics.fields_of_view["CameraTop"])
    panels = (
        ("CameraTop", np.eye(3), "x forward, y left, z up"),
        ("CameraTop_optical_frame", optical, "z forward, x right, y down"),
    )
    for k, (name, R, words) in enumerate(panels):
        view = View.around((75.0 + 262.0 * k, 205.0), 92.0, -128.0, 24.0)
        corners = np.array([[1.6, -1.6 * across * a, -1.6 * down * b] for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))])
        for corner in corners:
            drawing.line(view.flat([0.0, 0.0, 0.0]), view.flat(corner), LINE, 1.0)
        drawing.path(view.flat(corners), fill=BODY, opacity=0.5, stroke=PALE, width=1.2, closed=True)
        draw_solid(drawing, view, box([-0.34, -0.17, -0.17], [0.0, 0.17, 0.17]))
        T = np.eye(4)
        T[:3, :3] = R
        view.triad(drawing, T, 0.78, 2.6)
        for axis, (letter, colour) in enumerate(zip("xyz", AXES, strict=True)):
            tip = view.flat(0.92 * R[:, axis])
            drawing.text((tip[0], tip[1] + 4.5), letter, 14, colour, anchor="middle", weight="600", halo=True)
        drawing.text((125.0 + 255.0 * k, 40), name, 15, anchor="middle", weight="600")
        drawing.text((125.0 + 255.0 * k, 312), words, 13.5, PALE, anchor="middle")
    x, y, width, height = 545.0, 100.0, 180.0, 135.0
    drawing.text((635, 40), "the picture", 15, anchor="middle", weight="600")
    frame = [(x, y), (x + width, y), (x + width, y + height), (x, y + height)]
    drawing.path(frame, fill=BODY, opacity=0.5, stroke=PALE, width=1.2, closed=True)
    drawing.arrow([(x, y), (x + 70, y)], AXES[0], 2.6)
    drawing.arrow([(x, y), (x, y + 70)], AXES[1], 2.6)
    drawing.text((x + 78, y - 8), "u", 14, AXES[0], weight="600")
    drawing.text((x - 14, y + 78), "v", 14, AXES[1], weight="600")
    centre = np.array([x + width / 2, y + height / 2])
    for step in ((7.0, 0.0), (0.0, 7.0)):
        drawing.line(centre - step, centre + step, INK, 1.4)
    drawing.text(centre + np.array([6.0, 20.0]), "c_{u}, c_{v}", 13.5)
    drawing.text((x + width, y + height + 22), "640 × 480", 13, PALE, anchor="end")
    drawing.text((635, 312), "u right, v down", 13.5, PALE, anchor="middle")
    return drawing


FIGURES = {
    "cameras_fields_of_view": fields_of_view,
    "cameras_frames": camera_frames,
    "cameras_own_body": own_body,
    "cameras_uncertainty": uncertainty,
}
