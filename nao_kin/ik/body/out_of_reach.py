"""What certainly cannot be met: farther away than a robot whose joints all bend as they like, stretched.

A search that finds nothing proves nothing. By the triangle inequality no pose takes two points of the robot farther
apart than the sum of the lengths between them, and no place is deeper inside a polygon than half its least width.
"""

from __future__ import annotations

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin.ik.body.body import SIDES, Body
from nao_kin.ik.body.body_errors import COM, GAZE
from nao_kin.ik.body.whole_body_targets import Target
from nao_kin.robot import SupportPolygon


def target_beyond(body: Body, target: Target, standing: tuple[str, ...], feet: Floats, places: Floats) -> Floats:
    """How much farther than the stretched robot a target is from the feet that stand, at least, shape (n,) [m].

    Args:
        body: the robot.
        target: what is asked for. A gaze is nowhere, and has zeros.
        standing: the feet that stand.
        feet: their poses, shape (n, 2, 4, 4).
        places: of the target, shape (n, 3); of a centre of mass two numbers count.
    """
    beyond = np.zeros(len(places))
    if target.kind == GAZE or not target.weights[0] > 0.0:
        return beyond
    axes = 2 if target.kind == COM else 3
    for side in standing:
        k = SIDES.index(side)
        away = np.linalg.norm((places - feet[:, k, :3, 3])[:, :axes], axis=-1)
        most = _com_reach(body, k) if target.kind == COM else _reach(body, k, target.row, target.T_row_frame[:3, 3])
        beyond = np.maximum(beyond, away - most)
    return beyond


def feet_beyond(body: Body, feet: Floats) -> Floats:
    """How much farther than two stretched legs the feet are apart, at least, shape (n,) for (n, 2, 4, 4) [m]."""
    most = _reach(body, 0, int(body.legs[1, -1]), body.ankle_to_sole[1, :3, 3])
    apart = np.linalg.norm(feet[:, 1, :3, 3] - feet[:, 0, :3, 3], axis=-1)
    return np.asarray(np.maximum(0.0, apart - most))


def margin_beyond(polygon: SupportPolygon, margin: float) -> float:
    """How much more a margin is than the half of the polygon's least width [m]."""
    planes = polygon.half_planes
    widths = (planes[:, :2] @ polygon.vertices.T - planes[:, 2:]).max(axis=1)
    return max(0.0, margin - 0.5 * float(widths.min()))


def _reach(body: Body, side: int, row: int, place: Floats) -> float:
    """No pose takes a place on a body farther from the sole of a foot [m]."""
    hip, *leg = body.legs[side]
    length = float(np.linalg.norm(body.ankle_to_sole[side, :3, 3]))
    length += sum(float(np.linalg.norm(body.place[joint])) for joint in leg)
    while row > 0:
        length += float(np.linalg.norm(place))
        place, row = body.place[row], int(body.parent[row])
    return length + float(np.linalg.norm(place - body.place[hip]))


def _com_reach(body: Body, side: int) -> float:
    """No pose takes the centre of mass farther from the sole of a foot [m]."""
    lengths = [_reach(body, side, row, body.lever[row]) for row in range(len(body.mass))]
    return float(np.dot(lengths, body.mass) / body.mass.sum())
