"""`nao-kin calibrate`: joint offsets and camera mountings from a file of observations."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from nao_kin._core import files as atomic
from nao_kin.cli.options import OUTPUT, OutputOptions, RobotOptions, argument, command, flag, option
from nao_kin.cli.output import degrees_per, fixed, print_json, print_note, print_table, print_written
from nao_kin.cli.shared import SEED

if TYPE_CHECKING:
    from nao_kin.calibration import Calibration, NextPosture


@command("calibrate", "Example: nao-kin calibrate observations.json -o nao_7.toml --deg")
def calibrate(
    *,
    file: str = argument("FILE", "A JSON file of observations, - for standard input."),
    output: str | None = option("FILE", "Write the offsets as TOML, for --offsets.", *OUTPUT),
    refuse: bool = flag("Refuse numbers that the data cannot tell apart, instead of holding some at zero."),
    next_: bool = flag("Print the posture to observe next.", "--next"),
    seed: int = SEED,
    deg: bool = flag("Print angles in degrees."),
    written: OutputOptions,
    robot: RobotOptions,
) -> None:
    """Find joint offsets and camera mountings from pixels of known points, measured poses and contacts of soles."""
    written.check({"--output": output}, kind="toml")
    model = robot.load()
    from nao_kin import calibration as room

    arguments = room.read_observations(model, file)
    found = room.calibrate(model, **arguments, indistinguishable="refuse" if refuse else "hold")
    following = room.next_posture(found, rng=seed) if next_ else None
    print_note(*found.notes)
    if output is not None:
        found.save(output, overwrite=written.force)
    if written.json:
        print_json(_document(found, following, output))
    elif output is None or not atomic.leads_to_standard_output(output):
        _print(found, following, deg)
        print_written(*[] if output is None else [output])


def _rms(residuals: tuple[Any, ...]) -> float:
    flat = np.concatenate([part.ravel() for part in residuals])
    return float(np.sqrt(flat @ flat / flat.size))


def _print(found: Calibration, following: NextPosture | None, deg: bool) -> None:
    rows = []
    deviations = found.standard_deviations.values()
    for label, unit, value, deviation in zip(found.labels, found.units, found.values, deviations, strict=True):
        scale = degrees_per(unit, deg)
        shown = "held" if label in found.held else f"{scale * deviation:.2g}"
        rows.append((label, fixed(scale * value), shown, "°" if scale != 1.0 else unit))
    print_table(("number", "value", "±", "unit"), rows, numbers=("value", "±"))
    print(f"residuals: {_rms(found.initial_residuals):.3g} σ before, {_rms(found.residuals):.3g} σ after")
    if following is not None:
        angles = found.robot.angles(following.q, degrees=deg)
        print(f"next posture, gain {following.gain[following.index]:.3g} nats:")
        for name, value in angles.items():
            print(f"  {name} {value:.4f}")


def _document(found: Calibration, following: NextPosture | None, output: str | None) -> dict[str, Any]:
    document: dict[str, Any] = {
        "robot": found.robot.name,
        "joints": dict(found.joints),
        "frames": {name: list(six) for name, six in found.frames.items()},
        "poses": {name: T.tolist() for name, T in found.poses.items()},
        "standard_deviations": found.standard_deviations,
        "held": list(found.held),
        "notes": list(found.notes),
        "outliers": [vars(outlier) for outlier in found.outliers],
        "rms_before": _rms(found.initial_residuals),
        "rms_after": _rms(found.residuals),
        "files": [] if output is None else [output],
    }
    if following is not None:
        gain = float(following.gain[following.index])
        document["next"] = {"joints": found.robot.angles(following.q), "gain": gain}
    return document
