"""`nao-kin camera`: points to pixels, pixels to the ground, the horizon, and the numbers of a camera."""

from __future__ import annotations

import math
import re
import sys
from typing import TYPE_CHECKING

import numpy as np

from nao_kin._core.arrays import Floats, LimitPolicy
from nao_kin.cli.options import CSV, JSON, LIMITS, RobotOptions, argument, command, option
from nao_kin.cli.output import csv_text, degrees_per, fixed, print_json, print_note, print_table, units
from nao_kin.cli.sources import JointOptions, numbers_of, read_columns
from nao_kin.errors import BadArgument, BadInputFile

if TYPE_CHECKING:
    from nao_kin.robot import RobotModel
    from nao_kin.world import Camera

# Headings of the two kinds of rows.
_PIXEL: tuple[str, ...] = ("u", "v")
_POINT: tuple[str, ...] = ("x", "y", "z")


@command(
    "camera",
    "Example: nao-kin camera --posture StandInit; "
    'nao-kin camera CameraBottom --posture StandInit --pixel "320 240" --json',
)
def camera(
    *,
    name: str = argument("CAMERA", "CameraTop, CameraBottom, or a camera of another robot.", "CameraTop"),
    file: str | None = argument("FILE", "CSV file of pixels (u, v) or points (x, y, z); - for standard input.", None),
    joints: JointOptions,
    pixel: str | None = option("U,V", "Print the point of the ground at a pixel."),
    point: str | None = option("X,Y,Z", "Print the pixel of a point [m]; z is its height above the floor."),
    resolution: str = option("NAME", "VGA, another name, or width and height as in 640x480.", default="VGA"),
    height: float = option("M", "Height above the floor of the points at pixels [m].", default=0.0),
    limits: LimitPolicy = LIMITS,
    csv: bool = CSV,
    json: bool = JSON,
    robot: RobotOptions,
) -> None:
    """Print what a camera of a robot that stands on the floor sees.

    With pixels, the points of the ground that they show; with points, their pixels; without either, the numbers of the
    camera, its horizon and the part of the ground that it sees, with --json a polygon cut off at 10 m. In the world x
    and y are zero below the root link, x is forward, and the floor is z = 0. The lens has no distortion. A row without
    answer has empty numbers.
    """
    if (pixel is not None) + (point is not None) + (file is not None) > 1:
        raise BadArgument("--pixel, --point and FILE are three inputs; give one")
    if not math.isfinite(height):
        raise BadArgument(f"--height must be a finite number, got {height}")
    headings, many = _PIXEL, file is not None
    rows: Floats | None = None
    if file is not None:
        headings, rows = _read(file)
    elif pixel is not None or point is not None:
        headings = _PIXEL if pixel is not None else _POINT
        option_name, text = ("--pixel", str(pixel)) if pixel is not None else ("--point", str(point))
        rows = np.array(numbers_of(text, option_name, len(headings)))
    elif csv:
        raise BadArgument("--csv is for pixels and points; give a FILE, --pixel or --point")
    model = robot.load()
    q = joints.configuration(model, limits=limits)
    from nao_kin import world

    size = re.fullmatch(r"(\d{1,7})\s*[xX×*]\s*(\d{1,7})", resolution)
    found = world.camera(model, name, resolution if size is None else (int(size[1]), int(size[2])))
    if rows is None:
        _print_numbers(model, q, found, joints.deg, json)
        return
    if headings == _PIXEL:
        ground = world.pixel_to_ground(model, q, rows, found, height=height)
        columns, answers, good = (*headings, *_POINT, "valid"), ground.points, ground.valid
        outside = ~found.sees(rows)
        if outside.any():
            count = f"{outside.sum()} of {len(rows)} pixels are"
            print_note(f"{count} {world.outside_image(model, found, rows[outside])}")
    else:
        image = world.project(model, q, rows, found)
        columns, answers, good = (*headings, *_PIXEL, "visible"), image.pixels, image.visible
    numbers = np.column_stack([np.atleast_2d(rows), np.atleast_2d(answers)]).tolist()
    lines = [
        (*(None if math.isnan(number) else number for number in row), fine)
        for row, fine in zip(numbers, np.atleast_1d(good).tolist(), strict=True)
    ]
    if json:
        documents = [dict(zip(columns, line, strict=True)) for line in lines]
        head = {"robot": model.name, "camera": found.name, "size": [found.width, found.height]}
        print_json({**head, "rows": documents} if many else {**head, **documents[0]})
    elif csv:
        sys.stdout.write(csv_text(columns, lines))
    else:
        units = [f"{name}\n[{'px' if name in _PIXEL else 'm'}]" for name in columns[:-1]]
        shown = (["–" if cell is None else fixed(cell) for cell in line[:-1]] for line in lines)
        table = ([*cells, "yes" if line[-1] else "no"] for cells, line in zip(shown, lines, strict=True))
        print_table([*units, columns[-1]], table, numbers=units)


def _read(file: str) -> tuple[tuple[str, ...], Floats]:
    """Return the headings and the numbers (n, 2) or (n, 3) of a CSV file of pixels or points."""

    def chosen(names: list[str], line: int) -> tuple[str, ...]:
        headings = next((kind for kind in (_PIXEL, _POINT) if set(kind) <= set(names)), None)
        if headings is None:
            given = ", ".join(names)[:80] or "none"
            raise BadInputFile(file, f"has the columns {given}; expected u, v or x, y, z", line)
        return headings

    return read_columns(file, "pixels u, v or points x, y, z", chosen)


def _print_numbers(model: RobotModel, q: Floats, found: Camera, deg: bool, json: bool) -> None:
    """Print size, lens, pose, horizon and visible ground."""
    from nao_kin import world
    from nao_kin.rotations import rpy_from_matrix

    T, line = world.camera_pose(model, q, found), world.horizon(model, q, found)
    polygon = world.visible_ground(model, q, found)[:, :2]
    across, high = model.semantics.fields_of_view[found.name]
    rpy = rpy_from_matrix(T[:3, :3])
    if json:
        unit = degrees_per("rad", deg)
        document = {
            "robot": model.name,
            "camera": found.name,
            "size": [found.width, found.height],
            "focal_lengths": [found.fx, found.fy],
            "centre": [found.cx, found.cy],
            "field_of_view": [unit * across, unit * high],
            "T_world_camera": T.tolist(),
            "horizon": {"line": line.line.tolist(), "visible": bool(line.visible)},
            "visible_ground": polygon.tolist(),
            "units": units(deg),
        }
        print_json(document)
        return
    ends = line.pixels[[0, -1]].round(0) + 0.0 if line.visible else None
    lines = {
        "image": f"{found.width} × {found.height} pixels",
        "field of view": f"{math.degrees(across):.1f}° × {math.degrees(high):.1f}°",
        "focal lengths": f"{found.fx:.1f}, {found.fy:.1f} pixels",
        "position": ", ".join(f"{value + 0.0:.3f}" for value in T[:3, 3]) + " m above the floor",
        "tilt": f"{abs(math.degrees(rpy[1])):.1f}° {'up' if rpy[1] < 0.0 else 'down'}",
        "horizon": "not in the image"
        if ends is None
        else f"from ({ends[0, 0]:.0f}, {ends[0, 1]:.0f}) to ({ends[1, 0]:.0f}, {ends[1, 1]:.0f})",
        "sees the ground": f"from {polygon[:, 0].min():.2f} m ahead to "
        + ("the horizon" if line.visible else f"{polygon[:, 0].max():.2f} m")
        if len(polygon)
        else "not at all",
    }
    print_table([found.name, model.name], lines.items())
