"""The ranges that depend on another joint: HeadPitch of HeadYaw, AnkleRoll of AnklePitch."""

from __future__ import annotations

import numpy as np

import nao_kin as nk
from explanations.drawing import INK, ORANGE, PALE, Drawing, Floats

FREE, FORBIDDEN = "#15803d", ORANGE


class Chart:
    """A chart with degrees to the right and upwards.

    Args:
        drawing: the drawing.
        box: left, top, width and height.
        x, y: the ranges of both axes.
        steps: the steps between the marks of both axes.
    """

    def __init__(
        self,
        drawing: Drawing,
        box: tuple[float, float, float, float],
        x: tuple[float, float],
        y: tuple[float, float],
        steps: tuple[float, float],
    ) -> None:
        self._drawing, self._x, self._y = drawing, x, y
        self._left, self._top, self._width, self._height = box
        for value in np.arange(np.ceil(x[0] / steps[0]) * steps[0], x[1] + 1e-9, steps[0]):
            a, b = self.at([[value, y[0]], [value, y[1]]])
            drawing.line(a, b, "#e5e7eb", 1.0 if value else 1.8)
            drawing.text((a[0], a[1] + 18.0), degrees(value), 12.5, PALE, anchor="middle")
        for value in np.arange(np.ceil(y[0] / steps[1]) * steps[1], y[1] + 1e-9, steps[1]):
            a, b = self.at([[x[0], value], [x[1], value]])
            drawing.line(a, b, "#e5e7eb", 1.0 if value else 1.8)
            drawing.text((a[0] - 7.0, a[1] + 4.5), degrees(value), 12.5, PALE, anchor="end")

    def at(self, points: object) -> Floats:
        """Return the positions of points given in degrees."""
        points = np.asarray(points, dtype=float)
        across = (points[..., 0] - self._x[0]) / (self._x[1] - self._x[0])
        upwards = (points[..., 1] - self._y[0]) / (self._y[1] - self._y[0])
        return np.stack([self._left + self._width * across, self._top + self._height * (1.0 - upwards)], axis=-1)

    def limits(self, nao: nk.NaoModel, joint: str) -> None:
        """Draw the joint's own rectangle, dashed, and the region that the table allows."""
        (x0, y0, x1, y1), region, (at, lower, upper) = self.region(nao, joint)
        rectangle = self.at([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
        self._drawing.path(rectangle, fill=FORBIDDEN, opacity=0.12, stroke=FORBIDDEN, dash="6 4", closed=True)
        self._drawing.path(self.at(region), fill="white", closed=True)
        self._drawing.path(self.at(region), fill=FREE, opacity=0.16, stroke=FREE, width=2.0, closed=True)
        for limit in (lower, upper):
            for place, value in zip(at, limit, strict=True):
                if x0 - 0.1 <= place <= x1 + 0.1 and y0 - 0.1 <= value <= y1 + 0.1:
                    self._drawing.circle(self.at([place, value]), 3.2, "white", FREE, 1.7)

    def region(self, nao: nk.NaoModel, joint: str) -> tuple[Floats, Floats, Floats]:
        """Return the joints' own ranges (x0, y0, x1, y1), the region that the table allows, and the table [°]."""
        table = next(limit for limit in nao.coupled_limits if limit.joint == joint)
        columns = [nao.joint_names.index(name) for name in (table.of, joint)]
        (x0, y0), (x1, y1) = np.degrees([nao.lower[columns], nao.upper[columns]])
        at, lower, upper = (np.degrees(column) for column in (table.at, table.lower, table.upper))
        x = np.unique(np.concatenate([[x0, x1], at[(at > x0) & (at < x1)]]))
        low, high = np.maximum(np.interp(x, at, lower), y0), np.minimum(np.interp(x, at, upper), y1)
        region = np.concatenate([np.column_stack([x, low]), np.column_stack([x, high])[::-1]])
        return np.array([x0, y0, x1, y1]), region, np.stack([at, lower, upper])

    def words(self, x: float, y: float, words: str, colour: str) -> None:
        """Draw text centred at a point in degrees."""
        self._drawing.text(self.at([x, y]), words, 13.5, colour, anchor="middle", weight="600")


def degrees(value: float) -> str:
    """Return degrees with a minus sign instead of a hyphen."""
    return f"{value:.0f}°".replace("-", "−")


def head() -> Drawing:
    """Draw HeadPitch over HeadYaw."""
    drawing = Drawing(760, 400, "The range of HeadPitch over HeadYaw: least where the chin would meet the shoulders")
    chart = Chart(drawing, (84.0, 48.0, 640.0, 280.0), (-130.0, 130.0), (-45.0, 35.0), (30.0, 10.0))
    chart.limits(nk.load_nao("v6"), "HeadPitch")
    chart.words(0.0, -7.0, "free", FREE)
    chart.words(92.0, -33.0, "refused", FORBIDDEN)
    chart.words(-92.0, -33.0, "refused", FORBIDDEN)
    drawing.text((84, 30), "HeadPitch (up: the head looks down)", 14, INK, weight="600")
    drawing.text((404, 374), "HeadYaw (right: the head looks to the left)", 14, INK, anchor="middle", weight="600")
    return drawing


def ankles() -> Drawing:
    """Draw AnkleRoll over AnklePitch, left and right."""
    drawing = Drawing(760, 420, "The ranges of LAnkleRoll over LAnklePitch and of RAnkleRoll over RAnklePitch")
    nao = nk.load_nao("v6")
    for k, side in enumerate("LR"):
        left = 66.0 + 370.0 * k
        chart = Chart(drawing, (left, 66.0, 300.0, 280.0), (-75.0, 60.0), (-50.0, 50.0), (30.0, 10.0))
        chart.limits(nao, f"{side}AnkleRoll")
        chart.words(-3.0, 8.0 if side == "L" else -12.0, "free", FREE)
        chart.words(-49.0, 29.0 if side == "L" else -33.0, "refused", FORBIDDEN)
        drawing.text((left, 30), "left foot" if side == "L" else "right foot", 16, weight="600")
        drawing.text((left, 52), f"{side}AnkleRoll", 14, INK, weight="600")
        drawing.text((left + 150, 394), f"{side}AnklePitch", 14, INK, anchor="middle", weight="600")
    return drawing


FIGURES = {"limits_head": head, "limits_ankles": ankles}
