"""The eight postures placed on the floor with their contact areas, and the margin of one of them."""

from __future__ import annotations

import numpy as np

import nao_kin as nk
from explanations.drawing import INK, LINE, ORANGE, PALE, Drawing, Floats, View
from explanations.robot_outline import draw_robot, nao_shapes

SCALE, COLUMN, ROW = 205.0, 190.0, 330.0
STANDS = "#2f9e64"
X, Y, Z = np.eye(3)


def view_of(T_world_base: Floats, at: tuple[float, float], right: Floats, up: Floats, scale: float = SCALE) -> View:
    """Return a view of the world for points given in the root: `at` shows the world's origin."""
    R, t = T_world_base[:3, :3], T_world_base[:3, 3]
    origin = at[0] + scale * float(right @ t), at[1] - scale * float(up @ t)
    return View(origin, scale, tuple(R.T @ right), tuple(R.T @ up))


def postures() -> Drawing:
    """Draw each posture from the right on its floor, and its support polygon from above."""
    nao, _ = nao_shapes()
    drawing = Drawing(
        4 * COLUMN, 2 * ROW + 6, "NAO's eight postures set down on the floor, from the right and from above"
    )
    for k, name in enumerate(nao.posture_names):
        q = nao.posture(name)
        found = nk.world.balance(nao, q)
        x, y = COLUMN * (k % 4), ROW * (k // 4)
        drawing.text((x + COLUMN / 2, y + 24), name, 15, anchor="middle", weight="600")
        T = found.down.T_world_base
        # The robot's extent seen from the right, to place it in the middle of its column.
        points = found.vertices[:, 0].min(), found.vertices[:, 0].max()
        middle = x + COLUMN / 2 - SCALE * (0.0 if found.down.stands else 0.35 * sum(points))
        floor = y + 172.0
        draw_robot(drawing, view_of(T, (middle, floor), X, Z), q, fill="#f3f4f6", detail=4.5)
        drawing.line((x + 12, floor), (x + COLUMN - 12, floor), LINE, 1.6)
        com = middle + SCALE * found.com[0], floor - SCALE * found.com[2]
        drawing.line(com, (com[0], floor), INK, 1.2, "4 3")
        drawing.line((middle + SCALE * points[0], floor), (middle + SCALE * points[1], floor), STANDS, 4.0)
        drawing.circle(com, 4.0, INK)
        above = y + 250.0
        draw_robot(drawing, view_of(T, (middle, above), X, Y), q, fill="#f3f4f6", detail=4.5)
        plan = View((middle, above), SCALE, tuple(X), tuple(Y))
        corners = plan.flat(np.pad(found.vertices, ((0, 0), (0, 1))))
        drawing.path(corners, fill=STANDS, opacity=0.3, stroke=STANDS, width=1.6, closed=True)
        drawing.circle(plan.flat([*found.com[:2], 0.0]), 3.5, INK)
        words = f"{1000 * found.margin:.0f} mm, {np.degrees(found.tilts.min()):.0f}°"
        drawing.text((x + COLUMN / 2, y + ROW - 8), words, 13.5, PALE, anchor="middle")
    return drawing


def margin() -> Drawing:
    """Draw the polygon of StandInit with its nearest edge, and the tilt about it, from the side."""
    nao, _ = nao_shapes()
    q = nao.posture("StandInit")
    found = nk.world.balance(nao, q, soles="LLeg")
    both = nk.world.balance(nao, q)
    drawing = Drawing(
        760, 330, "Margin: from above, the distance of the centre of mass from the edges; from the right, the tilt"
    )
    scale = 900.0
    plan = View((190.0, 165.0), scale, tuple(X), tuple(Y))
    drawing.text((24, 30), "from above", 15, weight="600")
    for each, colour in ((both, STANDS), (found, ORANGE)):
        corners = plan.flat(np.pad(each.vertices, ((0, 0), (0, 1))))
        drawing.path(corners, fill=colour, opacity=0.15, stroke=colour, width=1.6, closed=True)
    for each, colour, words_at in ((both, STANDS, (14.0, -10.0)), (found, ORANGE, (-70.0, 5.0))):
        centre, k = each.com[:2], each.nearest
        begin, end = each.vertices[k], np.roll(each.vertices, -1, axis=0)[k]
        along = (end - begin) / np.linalg.norm(end - begin)
        foot = begin + along * np.clip((centre - begin) @ along, 0.0, np.linalg.norm(end - begin))
        a, b = plan.flat([[*centre, 0.0], [*foot, 0.0]])
        drawing.line(a, b, colour, 2.2)
        middle = (a + b) / 2 + np.array(words_at)
        drawing.text(middle, f"{1000 * each.margin:+.0f} mm", 14, colour, weight="600", halo=True)
    drawing.circle(plan.flat([*both.com[:2], 0.0]), 4.5, INK)
    drawing.text((24, 312), "green: both soles on the floor; orange: the left one alone", 13.5, PALE)
    drawing.text((430, 30), "from the right", 15, weight="600")
    side, at = 420.0, (560.0, 285.0)
    draw_robot(drawing, view_of(both.down.T_world_base, at, X, Z, side), q, fill="#f3f4f6")
    drawing.line((440, at[1]), (746, at[1]), LINE, 1.6)
    edge = float(both.vertices[:, 0].max())
    com = np.array([at[0] + side * both.com[0], at[1] - side * both.com[2]])
    tip = np.array([at[0] + side * edge, at[1]])
    drawing.line(com, (com[0], at[1]), INK, 1.2, "4 3")
    drawing.line(com, tip, STANDS, 2.0)
    drawing.line(tip, (tip[0], com[1] - 10), STANDS, 1.2, "4 3")
    drawing.circle(com, 5.0, INK)
    tilt = np.degrees(both.tilts[both.nearest])
    drawing.text((tip[0] + 10, com[1] + 12), f"tilt {tilt:.1f}°", 14, STANDS, weight="600", halo=True)
    return drawing


FIGURES = {"balance_postures": postures, "balance_margin": margin}
