"""`nao-kin calibrate`: joint offsets and camera mountings from photos of a chessboard, or a file of observations."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from nao_kin._core import files as atomic
from nao_kin.cli.options import (
    DEG,
    FILE_DEG,
    MISSING,
    OUTPUT,
    SEED,
    OutputOptions,
    RobotOptions,
    argument,
    command,
    flag,
    option,
)
from nao_kin.cli.output import degrees_per, fixed, print_json, print_note, print_table, print_written, units
from nao_kin.cli.sources import numbers_of, posture_or_number
from nao_kin.errors import BadArgument

if TYPE_CHECKING:
    from nao_kin.calibration import Calibration, NextPosture, Pixels
    from nao_kin.robot import RobotModel


@dataclass(frozen=True)
class PhotoOptions:
    """The options of photos of a chessboard."""

    photos: str | None = option("DIR", "Find the corners of a chessboard in all photos in this folder.")
    board: str | None = option("CxR", "Inner corners of a row of the chessboard, and rows, as in 9x6.")
    square: float | None = option("M", "Side of a square [m].")
    log: str | None = option("FILE", "Joint values with times, for the photos.")
    camera: str = option("NAME", "The camera that took the photos.", default="CameraTop")
    lens: str | None = option("NUMBERS", "Its fx,fy,cx,cy[,k1,k2,p1,p2[,k3]], by OpenCV's calibrateCamera.")
    times: str | None = option(
        "FILE", "CSV file with columns file and time. Default: the numbers in the photos' names."
    )
    place: str | None = option("X,Y,Z,R,P,Y", "The measured pose of the board in the root link [m, rad].")
    missing: str | None = MISSING
    file_deg: bool = FILE_DEG

    def check(self) -> None:
        """Refuse options of photos without --photos, and --photos without those that it needs."""
        needed = {"--board": self.board, "--square": self.square, "--log": self.log}
        others = {"--lens": self.lens, "--times": self.times, "--place": self.place, "--missing": self.missing}
        others["--file-deg"] = "yes" if self.file_deg else None
        for name, value in (needed | others).items():
            if self.photos is None and value is not None:
                raise BadArgument(f"{name} is for photos; give --photos")
            if self.photos is not None and value is None and name in needed:
                raise BadArgument(f"--photos needs {', '.join(needed)}; {name} is missing")

    def read(self, model: RobotModel, deg: bool) -> Pixels | None:
        """Return what the photos show; None without --photos. With `deg` the angles of --place are in degrees."""
        if self.photos is None:
            return None
        sides = re.fullmatch(r"(\d{1,4})\s*[xX×*]\s*(\d{1,4})", str(self.board))
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
            str(self.log),
            board=(int(sides[1]), int(sides[2])),
            square=float(str(self.square)),
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
    output: str | None = option("FILE", "Write the offsets as TOML, for --offsets.", *OUTPUT),
    refuse: bool = flag("Refuse numbers that the data cannot tell apart, instead of holding some at zero."),
    next_: bool = flag("Print the posture to observe next.", "--next"),
    seed: int = SEED,
    deg: bool = DEG,
    written: OutputOptions,
    robot: RobotOptions,
) -> None:
    """Find joint offsets and camera mountings from photos of a chessboard, or a file of observations.

    With --photos and no FILE, the zeros of the joints below the camera and the angles of its mounting are unknown.
    """
    written.check({"--output": output}, kind="toml")
    photo.check()
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
        _print(found, following, deg)
        print_written(*[] if output is None else [output])


def _print(found: Calibration, following: NextPosture | None, deg: bool) -> None:
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
