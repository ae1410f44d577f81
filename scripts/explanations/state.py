"""What a robot did and what its log shows: states, pitch, height and forces over time."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np

import nao_kin as nk
from explanations.drawing import BODY, INK, LINE, ORANGE, PALE, Drawing, Floats

# A log of `scripts/simulate_logs.py --life`: MuJoCo's next version may simulate another one.
LOG = Path(__file__).with_suffix(".npz").with_stem("robot_state")
LEFT, RIGHT, WIDTH = 54.0, 20.0, 760.0
COLOURS = {"standing": "#86c79c", "walking": "#2f9e64", "falling": "#e8a15c", "lying": "#c2410c", "carried": "#7c8fd6"}
COLOURS |= {"unknown": PALE}


def state() -> Drawing:
    """Draw the states of a log, true and found, and what they are found from."""
    nao = nk.load_nao()
    log = np.load(LOG)
    times, doing_true, T = log["times"], log["doing"], log["T_world_base"].astype(float)
    sensors = {name: log[name].astype(float) for name in ("forces", "gyro")}
    q, accelerometer = log["steps"] * 2.0 * np.pi / 4096.0, -log["accelerometer"].astype(float)
    found = nk.world.state(nao, q, times=times, accelerometer=accelerometer, **sensors)
    sides = ("front", "back", "left", "right")
    drawing = Drawing(WIDTH, 460.0, "States, pitch, height and forces of a robot over 31 s, true and found")
    end = float(times[-1])

    def x(times: Floats | float) -> Floats:
        return np.asarray(LEFT + (WIDTH - LEFT - RIGHT) * np.asarray(times) / end)

    rows = (
        ("true", np.select([np.isin(doing_true, sides), doing_true == ""], ["lying", "carried"], doing_true), 34.0),
        ("found", np.where(found.doing == "lifted", "carried", found.doing), 60.0),
    )
    for name, states, y in rows:
        drawing.text((LEFT - 10, y + 14), name, 13, PALE, anchor="end")
        edges = [0, *(np.flatnonzero(states[1:] != states[:-1]) + 1).tolist(), len(states) - 1]
        for begin, stop in itertools.pairwise(edges):
            a, b = x(times[[begin, stop]]).tolist()
            corners = [(a, y), (b, y), (b, y + 20), (a, y + 20)]
            drawing.path(corners, fill=COLOURS[str(states[begin])], closed=True)
    for k, (name, colour) in enumerate(COLOURS.items()):
        at = LEFT + 100.0 * k
        drawing.circle((at + 5, 18), 5, colour)
        drawing.text((at + 15, 23), name, 13)
    pitch = np.degrees(np.arctan2(-T[:, 2, 0], np.hypot(T[:, 2, 1], T[:, 2, 2])))
    feet = found.forces.T
    charts = (
        (
            "pitch [°], grey: true, black: found",
            112.0,
            (-90.0, 90.0),
            [(pitch, LINE, 5.0), (np.degrees(found.roll_pitch[:, 1]), INK, 1.3)],
        ),
        (
            "height of the torso [m], grey: true, black: found, where it is valid",
            228.0,
            (0.2, 0.4),
            [(T[:, 2, 3], LINE, 5.0), (found.T_world_base[:, 2, 3], INK, 1.3)],
        ),
        (
            "force [kg], blue: left sole, orange: right sole",
            344.0,
            (0.0, 8.0),
            [(feet[0], "#2563eb", 1.3), (feet[1], ORANGE, 1.3)],
        ),
    )
    for name, top, (low, high), lines in charts:
        foot = top + 84.0
        drawing.path([(LEFT, top), (WIDTH - RIGHT, top), (WIDTH - RIGHT, foot), (LEFT, foot)], stroke=BODY, closed=True)
        drawing.text((LEFT, top - 8), name, 13)
        for value in (low, high):
            y = foot - (foot - top) * (value - low) / (high - low)
            drawing.text((LEFT - 8, y + 5), f"{value:g}", 12, PALE, anchor="end")
        for values, colour, width in lines:
            y = foot - (foot - top) * (np.clip(values, low, high) - low) / (high - low)
            known = np.flatnonzero(np.isfinite(values))[::4]
            for part in np.split(known, np.flatnonzero(np.diff(known) > 8) + 1):
                if len(part) > 1:
                    drawing.path(np.column_stack([x(times[part]), y[part]]), stroke=colour, width=width)
    for second in range(0, 31, 5):
        drawing.text((float(x(float(second))), 448), f"{second} s", 12, PALE, anchor="middle")
    return drawing


FIGURES = {"robot_state": state}
