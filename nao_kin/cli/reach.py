"""`nao-kin reach`: the workspace of a hand."""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from nao_kin._core import files as atomic
from nao_kin._core.process import uninterrupted
from nao_kin._core.text import abbreviated
from nao_kin.cli import options as shared
from nao_kin.cli.options import OutputOptions, RobotOptions, argument, command, option
from nao_kin.cli.output import print_json, print_note, progress
from nao_kin.errors import BadArgument

if TYPE_CHECKING:
    from nao_kin.reach import ReachMap
    from nao_kin.robot import RobotModel


_ENDINGS = (".npz", ".vtk", ".ply", ".png")


@command("reach", "Example: nao-kin reach LArm --samples 1e6 -o larm.npz --html larm.html", needs={"by": "html|output"})
def reach(
    *,
    frame: str = argument("FRAME", "A frame, or a chain for its end effector."),
    samples: int = option("N", "Number of configurations, such as 200000 or 1e7.", default=1_000_000),
    voxel: float = option("M", "Edge of a voxel [m].", default=0.01),
    seed: int = shared.SEED,
    reference: str | None = shared.REFERENCE,
    output: str | None = option("FILE", "Write the map: .npz, which a later run continues, .vtk, .ply or .png."),
    html: str | None = option("FILE", "Write a page with the robot and its map."),
    by: Literal["best", "mean", "count", "coverage"] = option(
        None,
        "Quantity of the colours in --html, .ply and .png; best and mean manipulability.",
        default="best",
    ),
    threads: int | None = option("N", "Number of threads. Default: one per core."),
    written: OutputOptions,
    robot: RobotOptions,
) -> None:
    """Compute a voxel map of a hand's positions at random joint values, with manipulability and directions.

    Joint values are uniformly distributed inside their limits. With -o map.npz, the same command continues an earlier
    run, even one that was ended by Ctrl-C: its samples up to then are saved.
    """
    known = output is None or Path(output).suffix.lower() in _ENDINGS or atomic.leads_to_standard_output(output)
    if not known:
        raise BadArgument(f"cannot write {abbreviated(output)}: end the name in {', '.join(_ENDINGS)}")
    continued = output is not None and Path(output).suffix.lower() == ".npz"
    written.check({"--output": output, "--html": html}, continued=continued)
    model = robot.load()
    from nao_kin import reach as room
    from nao_kin._kernels.cache import KERNELS, warm_up

    first = room.workspace(model, frame, 1, voxel=voxel, seed=seed, reference=reference)  # checks the options
    settings, _ = first.settings, first.column(by)
    previous = None
    if output is not None and continued and Path(output).is_file():
        previous = room.load(output)
    warm_up([name for name in KERNELS if name.startswith("reach")])  # first, so that a signal does not wait for it
    if previous is not None:
        settings.check_same(previous.settings, abbreviated(output))
        done = previous.ranges[-1][1] if previous.ranges else 0
        if done > samples:
            raise BadArgument(f"{abbreviated(output)} has {done} samples already; ask for at least as many")

    # A signal ends the sampling; the program ends when the samples so far are written.
    with uninterrupted() as ending:
        with progress("samples") as say:
            found = room.workspace(
                model,
                frame,
                samples,
                voxel=voxel,
                seed=seed,
                reference=reference,
                previous=previous,
                threads=threads,
                progress=say,
                stop=ending,
            )
        files = _written(model, found, output, html, by, force=written.force) if found.samples else []
        if found.samples < samples:
            kept = f"kept in {abbreviated(' and '.join(files))}" if files else "without -o FILE nothing is kept"
            print_note(f"ended after {found.samples} of {samples} samples; {kept}")
        else:
            _report(found, files, written.json)
        sys.stdout.flush()


def _written(
    model: RobotModel, found: ReachMap, output: str | None, html: str | None, by: str, *, force: bool
) -> list[str]:
    savers: dict[str, Callable[..., Path]] = {".vtk": found.save_vtk, ".ply": partial(found.save_ply, by=by)}
    kind = "" if output is None else Path(output).suffix.lower()
    if html is not None or kind == ".png":
        from nao_kin.viewer import Viewer

        with closing(Viewer(model)) as viewer:
            viewer.show_reach(found, by=by)
            if html is not None:
                viewer.save_html(html, overwrite=force)
            if kind == ".png":
                viewer.save_png(str(output), overwrite=True)
    if output is not None and kind != ".png":
        savers.get(kind, found.save)(output, overwrite=True)  # checked before the sampling
    return [file for file in (output, html) if file is not None]


def _report(found: ReachMap, files: list[str], json: bool) -> None:
    settings, best = found.settings, int(found.best_steps.argmax())
    lower, upper = found.indices.min(axis=0) * found.voxel, (found.indices.max(axis=0) + 1) * found.voxel
    position = found.centres[best].tolist()
    if json:
        document = {
            "robot": settings.robot,
            "frame": settings.frame,
            "reference": settings.reference,
            "joints": list(settings.joints),
            "samples": found.samples,
            "seed": settings.seed,
            "voxel": found.voxel,
            "voxels": len(found.count),
            "volume": found.volume,
            "lower": lower.tolist(),
            "upper": upper.tolist(),
            "best": {"manipulability": float(found.best[best]), "position": position},
            "mean_coverage": float(found.coverage.mean()),
            "files": files,
        }
        print_json(document)
        return
    if any(atomic.leads_to_standard_output(file) for file in files):
        return  # standard output may contain only the file
    print(
        f"{settings.frame} in {settings.reference} of {settings.robot}, {found.samples} samples, seed {settings.seed}"
    )
    print(f"{len(found.count)} voxels of {1000 * found.voxel:g} mm, {1000 * found.volume:.4g} dm³")
    for axis, low, high in zip("xyz", lower.tolist(), upper.tolist(), strict=True):
        print(f"{axis} from {low:.3f} to {high:.3f} m")
    place = ", ".join(f"{coordinate:.3f}" for coordinate in position)
    print(f"best manipulability {found.best[best]:.4g} at ({place}) m")
    for file in files:
        print(file)
