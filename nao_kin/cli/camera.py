"""`nao-kin camera` and `calibrate`: what a camera sees, and where it and the joints are, from what it has seen."""

from __future__ import annotations

import math
import os
import sys
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from nao_kin._core import files as atomic
from nao_kin._core.arrays import Floats, LimitPolicy
from nao_kin._core.text import two_numbers
from nao_kin.cli import options as shared
from nao_kin.cli.options import Needs, OutputOptions, RobotOptions, argument, command, flag, option
from nao_kin.cli.output import csv_text, degrees_per, fixed, print_json, print_note, print_table, print_written, units
from nao_kin.cli.sources import JointOptions, numbers_of, posture_or_number, read_columns
from nao_kin.errors import BadArgument, BadInputFile

if TYPE_CHECKING:
    from nao_kin.calibration import Calibration, NextPosture, Pixels
    from nao_kin.robot import RobotModel
    from nao_kin.world import Camera

# Headings of the two kinds of rows.
_PIXEL: tuple[str, ...] = ("u", "v")
_POINT: tuple[str, ...] = ("x", "y", "z")


@command(
    "camera",
    "Example: nao-kin camera --posture StandInit; "
    'nao-kin camera CameraBottom --posture StandInit --pixel "320 240" --json',
    needs={"csv": "file|pixel|point"},
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
    limits: LimitPolicy = shared.LIMITS,
    csv: bool = shared.CSV,
    json: bool = shared.JSON,
    robot: RobotOptions,
) -> None:
    """Print what a camera of a robot that stands on the floor sees.

    With pixels, the points of the ground that they show; with points, their pixels; without either, the numbers of the
    camera, its horizon and the part of the ground that it sees, with --json a polygon cut off at 10 m. In the world x
    and y are zero below the root link, x is forward, and the floor is z = 0. The lens has no distortion. A row without
    answer has empty numbers.
    """
    headings, many = _PIXEL, file is not None
    rows: Floats | None = None
    if file is not None:
        headings, rows = _read(file)
    elif pixel is not None or point is not None:
        headings = _PIXEL if pixel is not None else _POINT
        option_name, text = ("--pixel", str(pixel)) if pixel is not None else ("--point", str(point))
        rows = np.array(numbers_of(text, option_name, len(headings)))
    model = robot.load()
    q = joints.configuration(model, limits=limits)
    from nao_kin import world

    found = world.camera(model, name, resolution)
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


# --- `nao-kin calibrate`.


@dataclass(frozen=True)
class PhotoOptions:
    """The options of photos of a chessboard."""

    photos: str | None = option("DIR", "Find the corners of a chessboard in all photos in this folder.")
    board: str = option("CxR", "Inner corners of a row of the chessboard, and rows, as in 9x6.")
    square: float = option("M", "Side of a square [m].")
    log: str = option("FILE", "Joint values with times, for the photos.")
    camera: str = option("NAME", "The camera that took the photos.", default="CameraTop")
    lens: str | None = option("NUMBERS", "Its measured fx,fy,cx,cy[,k1,k2,p1,p2[,k3]], by OpenCV's calibrateCamera.")
    times: str | None = option(
        "FILE", "CSV file with columns file and time. Default: the numbers in the photos' names."
    )
    place: str | None = option("X,Y,Z,R,P,Y", "The measured pose of the board in the root link [m, rad].")
    missing: str | None = shared.MISSING
    file_deg: bool = shared.FILE_DEG

    needs: ClassVar[Needs] = {
        **dict.fromkeys(("board", "square", "log", "lens", "times", "place", "missing", "file_deg"), "photos"),
        "photos": ("board", "square", "log"),
    }

    def read(self, model: RobotModel, deg: bool) -> Pixels | None:
        """Return what the photos show; None without --photos. With `deg` the angles of --place are in degrees."""
        if self.photos is None:
            return None
        sides = two_numbers(self.board)
        if sides is None:
            raise BadArgument(f"--board {self.board}: expected columns and rows of inner corners, as in 9x6")
        # OpenCV reads it when it is loaded, and then decodes no picture with more pixels.
        os.environ.setdefault("OPENCV_IO_MAX_IMAGE_PIXELS", str(atomic.MAX_NUMBERS))
        from nao_kin.calibration import from_photos

        place = None if self.place is None else np.array(numbers_of(self.place, "--place", 6))
        if place is not None and deg:
            place[3:] = np.radians(place[3:])
        return from_photos(
            model,
            self.photos,
            self.log,
            board=sides,
            square=self.square,
            camera=self.camera,
            lens=None if self.lens is None else numbers_of(self.lens, "--lens"),
            times=self.times,
            place=place,
            missing=posture_or_number(self.missing),
            degrees=self.file_deg,
        )


@command(
    "calibrate",
    "Example: nao-kin calibrate observations.json -o nao_7.toml --deg; "
    "nao-kin calibrate --photos photos --board 9x6 --square 0.03 --log head.csv --missing StandInit -o nao_7.toml",
)
def calibrate(
    *,
    file: str | None = argument("FILE", "A JSON file of observations, - for standard input.", None),
    photo: PhotoOptions,
    output: str | None = option("FILE", "Write the offsets as TOML, for --offsets."),
    refuse: bool = flag("Refuse numbers that the data cannot tell apart, instead of holding some at zero."),
    next_: bool = flag("Print the posture to observe next.", "--next"),
    seed: int = shared.SEED,
    deg: bool = shared.DEG,
    written: OutputOptions,
    robot: RobotOptions,
) -> None:
    """Find joint offsets and camera mountings from photos of a chessboard, or a file of observations.

    With --photos and no FILE, the zeros of the joints below the camera and the angles of its mounting are unknown.
    The lens of a camera is estimated too, unless it is given. The file then has it, for all commands with --offsets.
    """
    written.check({"--output": output}, kind="toml")
    if file is None and photo.photos is None:
        raise BadArgument("give a FILE of observations, or --photos")
    model = robot.load()
    from nao_kin import calibration as room

    arguments: dict[str, Any] = {} if file is None else room.read_observations(model, file)
    seen = photo.read(model, deg)
    if seen is not None:
        arguments["observations"] = [*arguments.get("observations", []), seen]
    if file is None:
        from nao_kin.robot import serial_chain

        chain = serial_chain(model, model.tree.root, photo.camera)
        arguments |= {"joints": chain.coordinates, "frames": {photo.camera: ("roll", "pitch", "yaw")}}
    found = room.calibrate(model, **arguments, indistinguishable="refuse" if refuse else "hold")
    following = room.next_posture(found, rng=seed) if next_ else None
    print_note(*found.notes)
    if output is not None:
        found.save(output, overwrite=written.force)
    if written.json:
        print_json(_document(found, following, output, deg))
    elif output is None or not atomic.leads_to_standard_output(output):
        if deg and output is None:
            print_note("a file of offsets is in radians; --output writes it")
        _print_calibration(found, following, deg)
        print_written(*[] if output is None else [output])


def _print_calibration(found: Calibration, following: NextPosture | None, deg: bool) -> None:
    rows = []
    deviations = zip(found.standard_deviations.values(), found.prior_deviations.tolist(), strict=True)
    for label, unit, value, (after, before) in zip(found.labels, found.units, found.values, deviations, strict=True):
        scale = degrees_per(unit, deg)
        shown = "not determined" if label in found.held else fixed(scale * value)
        rows.append((label, shown, f"{scale * after:.2g}", f"{scale * before:.2g}", "°" if scale != 1.0 else unit))
    print_table(("number", "value", "±", "before", "unit"), rows, numbers=("value", "±", "before"))
    print(f"residuals: {found.rms_before:.3g} σ before, {found.rms_after:.3g} σ after")
    if following is not None:
        angles = found.robot.angles(following.q, degrees=deg)
        unit = "°" if deg else "rad"
        print(f"next posture [{unit}], gain {following.gain[following.index]:.3g} nats:")
        for name, value in angles.items():
            print(f"  {name} {value:.4f}")


def _document(found: Calibration, following: NextPosture | None, output: str | None, deg: bool) -> dict[str, Any]:
    """Return the document of --json; with `deg` angles are in degrees."""
    turn = degrees_per("rad", deg)
    scales = {label: degrees_per(unit, deg) for label, unit in zip(found.labels, found.units, strict=True)}
    document: dict[str, Any] = {
        "robot": found.robot.name,
        "units": units(deg),
        "joints": {name: value * degrees_per(found.robot.unit(name), deg) for name, value in found.joints.items()},
        "frames": {name: [*six[:3], *(turn * angle for angle in six[3:])] for name, six in found.frames.items()},
        "cameras": {name: list(numbers) for name, numbers in found.offsets.get("cameras", {}).items()},
        "clocks": dict(found.clocks),
        "poses": {name: T.tolist() for name, T in found.poses.items()},
        "standard_deviations": {label: scales[label] * value for label, value in found.standard_deviations.items()},
        "prior_deviations": {
            label: scales[label] * value if np.isfinite(value) else None
            for label, value in zip(found.labels, found.prior_deviations.tolist(), strict=True)
        },
        "held": list(found.held),
        "notes": list(found.notes),
        "outliers": [vars(outlier) for outlier in found.outliers],
        "rms_before": found.rms_before,
        "rms_after": found.rms_after,
        "files": [] if output is None else [output],
    }
    if following is not None:
        gain = float(following.gain[following.index])
        document["next"] = {"joints": found.robot.angles(following.q, degrees=deg), "gain": gain}
    return document
