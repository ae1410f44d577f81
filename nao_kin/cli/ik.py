"""`nao-kin ik`: joint values for a pose of a foot, a hand, the head, or of any frame of any robot."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer

from nao_kin._core import files as atomic
from nao_kin._core.arrays import Floats, join_poses
from nao_kin._core.text import quoted
from nao_kin.cli.options import (
    ColumnsOption,
    DegOption,
    IgnoreOtherOption,
    JsonOption,
    RobotOptions,
    check_sinks,
    columns_of,
    command,
    print_json,
    print_note,
    print_table,
    without_sign_of_zero,
)
from nao_kin.cli.targets import Targets, numbers_of, read_targets, target_of, targets_as_csv
from nao_kin.errors import BadArgument, UnknownName

if TYPE_CHECKING:
    from nao_kin.ik import IKResult
    from nao_kin.robot import RobotModel


# Both feet together.
LEGS = "Legs"
_FEET = ("LLeg", "RLeg")
# Targets not reached that are named one by one.
_MOST_NAMED = 5
# Groups of neighbouring targets that are listed.
_MOST_RANGES = 30
# So many targets may take seconds: a line says that they are worked on.
_MANY = 2000
# Solutions of a list of targets are played at so many a second.
_FPS = 25.0


class Criterion(str, Enum):
    """Which member of the family of an arm with a place alone."""

    nearest = "nearest"
    limits = "limits"
    manipulability = "manipulability"


class Priority(str, Enum):
    """Which foot is turned less where the two cannot both be met."""

    left = "left"
    right = "right"
    balanced = "balanced"


_EXAMPLES = (
    'Example: nao-kin ik LArm --target "0.15 0.12 0.05" --html arm.html; '
    'nao-kin ik LLeg --target "0 0.05 -0.3 0 0 0" --all; '
    "nao-kin fk walk.csv --frame LLeg --csv | nao-kin ik LLeg - --csv"
)


@dataclass(frozen=True)
class Asked:
    """What is asked for beside the targets.

    Attributes:
        frame: the frame to place, or "Legs".
        direction: of the forearm, with places.
        criterion: for places of a hand; None where none is given.
        limits: "enforce" or "ignore".
        priority: of the feet; None where none is given.
        numeric: by search, where there is a closed form too.
    """

    frame: str
    direction: list[float] | None
    criterion: Criterion | None
    limits: Any
    priority: Priority | None
    numeric: bool


@command("ik", _EXAMPLES)
def ik(
    *,
    frame: Annotated[
        str, typer.Argument(metavar="FRAME", help="LLeg, RLeg, LArm, RArm, Head, a camera, Legs, or any other frame.")
    ],
    file: Annotated[
        str | None, typer.Argument(metavar="FILE", help="CSV, JSON or .npy file of targets, - for standard input.")
    ] = None,
    target: Annotated[
        str | None, typer.Option(metavar="NUMBERS", help="One target, between quotes; see above.")
    ] = None,
    direction: Annotated[
        str | None, typer.Option(metavar="NUMBERS", help="With places: where the forearm is to point, three numbers.")
    ] = None,
    criterion: Annotated[
        Criterion | None, typer.Option("--criterion", help="Which solution for a place alone. Default: nearest.")
    ] = None,
    priority: Annotated[
        Priority | None,
        typer.Option("--priority", help="For Legs: the foot that is turned less where the hips disagree."),
    ] = None,
    reference: Annotated[
        str | None,
        typer.Option(
            metavar="POSTURE", help="A posture or a file of configurations to be near. Default: all joints at zero."
        ),
    ] = None,
    columns: ColumnsOption = None,
    ignore_other: IgnoreOtherOption = False,
    all_: Annotated[bool, typer.Option("--all", help="Print every solution.")] = False,
    ignore_limits: Annotated[bool, typer.Option("--ignore-limits", help="Take joints wherever they are.")] = False,
    numeric: Annotated[bool, typer.Option("--numeric", help="Search, also where there is a closed form.")] = False,
    deg: DegOption = False,
    csv: Annotated[
        bool, typer.Option("--csv", help="Print configurations as CSV for fk and view: no row where there is none.")
    ] = False,
    html: Annotated[
        str | None, typer.Option(metavar="FILE", help="Write a page: the robot, and its other solutions as ghosts.")
    ] = None,
    json: JsonOption = False,
    robot: RobotOptions,
) -> None:
    """Joint values for a pose: all solutions inside the limits, or the reason why there are none.

    How many numbers a target has says what it is: 3 are a place, 4 (quaternion, scalar first) or 9 (rows) an
    orientation, 6 a place with roll, pitch, yaw, 7 a place with a quaternion, 16 the rows of a homogeneous matrix.
    Metres and radians, in the torso. The head takes an orientation, a camera a point to look at; Legs takes the poses
    of both feet, the left one first. A file has one target in each row; what `nao-kin fk --csv` and `--json` print is
    such a file.

    Exit code 1 when a target is not reached: then the nearest pose is given where there is one.
    """
    if (file is None) == (target is None):
        raise BadArgument('give one target with --target "NUMBERS", or the FILE of a list of them')
    check_sinks("--json" if json else "--csv" if csv else None, html=html)
    if reference is None and (columns or ignore_other):
        raise BadArgument("--columns and --ignore-other are for a file of configurations; name it with --reference")
    model = robot.load()
    frames = _FEET if frame == LEGS else (frame,)
    model.frame_ids(frames)
    if target is not None:
        targets = target_of(target, feet=frame == LEGS, degrees=deg)
    else:
        roots = (model.semantics.root, model.tree.root, *(("world",) if "world" not in model.frame_names else ()))
        targets = read_targets(str(file), frames, degrees=deg, roots=roots)
    near = None
    if reference is not None:
        near = _reference(model, reference, len(targets.values), deg, columns_of(columns), ignore_other)
    towards = None if direction is None else numbers_of(direction, "--direction")
    if towards is not None and len(towards) != 3:
        raise BadArgument(f"--direction {quoted(direction)}: {len(towards)} numbers, expected 3")
    asked = Asked(frame, towards, criterion, "ignore" if ignore_limits else "enforce", priority, numeric)
    found = _solved(model, asked, targets, near)
    for note in found.notes:
        print_note(note)
    written = None if html is None else _write_page(model, found, html)
    if written is not None and not atomic.leads_to_standard_output(written) and not json:
        # What follows on standard output under --csv is a file, which this is no line of.
        print(written, file=sys.stderr if csv else sys.stdout)
    if json:
        files = {} if written is None else {"html": written}
        print_json({**_document(model, asked, targets, found, deg=deg, every=all_), **files})
    elif csv:
        sys.stdout.write(_configurations(model, found, deg=deg, every=all_))
    elif html is None or not atomic.leads_to_standard_output(html):
        if targets.many:
            _print_lines(model, found, deg, every=all_)
        else:
            _print_one(model, found, deg, every=all_)
    missed = np.flatnonzero(~np.atleast_1d(found.success))
    if missed.size:
        if csv or targets.many:
            _print_missed(found, missed, deg)
        if csv and targets.many:
            _print_left_out(found, missed)
        raise typer.Exit(1)


def _reference(
    model: RobotModel,
    reference: str,
    targets: int,
    deg: bool,
    columns: dict[str, str | None] | None,
    ignore_other: bool,
) -> Floats:
    """The configuration, or one for each target, that --reference names."""
    if reference in model.posture_names:
        if columns or ignore_other:
            raise BadArgument("--columns and --ignore-other are for a file of configurations; --reference is a posture")
        return model.posture(reference)
    if reference != "-" and Path(reference).suffix.lower() not in (".csv", ".json") and not Path(reference).exists():
        hint = "or a CSV or JSON file of configurations"
        raise UnknownName("posture", reference, model.posture_names, hint)
    from nao_kin.stream import read_log

    q = read_log(model, reference, limits="ignore", degrees=deg, columns=columns, ignore_other=ignore_other).q
    if len(q) not in (1, targets):
        raise BadArgument(
            f"--reference {reference}: {len(q)} configurations for {targets} targets; give one, or as many"
        )
    return q[0] if len(q) == 1 else q


def _solved(model: RobotModel, asked: Asked, targets: Targets, near: Floats | None) -> IKResult:
    """The answer for a list of targets, or for one."""
    from rich.console import Console

    solve = _solver(model, asked, targets)
    values = targets.values if targets.many else targets.values[0]
    if near is not None and not targets.many and near.ndim == 2:
        near = near[0]
    console = Console(file=sys.stderr)
    if len(targets.values) < _MANY or not console.is_terminal:
        return solve(values, near)
    with console.status(f"{len(targets.values)} targets"):
        return solve(values, near)


def _solver(model: RobotModel, asked: Asked, targets: Targets) -> Callable[[Floats, Floats | None], IKResult]:
    """The function of `nao_kin.ik` that answers for this frame and this kind of target."""
    from nao_kin import ik as room

    frame, kind, limits = asked.frame, targets.kind, asked.limits
    limb = LEGS if frame == LEGS else None if asked.numeric else room.limb_of_frame(model, frame)
    if limb == LEGS and asked.numeric:
        raise BadArgument("--numeric places one frame; Legs are two")
    if limb != LEGS and asked.priority is not None:
        raise BadArgument("--priority goes with Legs, which has two feet")
    is_arm = limb in ("LArm", "RArm")
    if not (is_arm and kind == "place"):
        for option, value in (("--direction", asked.direction), ("--criterion", asked.criterion)):
            if value is not None:
                raise BadArgument(f"{option} goes with places of a hand, three numbers, and the closed form of an arm")
    if asked.direction is not None and asked.criterion is not None:
        raise BadArgument("--direction leaves an arm no freedom to choose from; leave out --criterion")
    if limb == LEGS:
        priority: Any = "balanced" if asked.priority is None else asked.priority.value
        return lambda T, near: room.legs(
            model, T[..., 0, :, :], T[..., 1, :, :], reference=near, limits=limits, priority=priority
        )
    if limb in _FEET and kind == "pose":
        return lambda T, near: room.leg(model, limb[0], T, frame=frame, reference=near, limits=limits)
    if limb == "Head":
        if kind == "place":
            if frame not in model.semantics.cameras:
                raise BadArgument(f"{frame} takes an orientation, 4 or 9 numbers; a camera takes a point to look at")
            return lambda p, near: room.look_at(model, p, frame, reference=near, limits=limits)
        if kind == "rotation":
            return lambda R, near: room.head(model, R, frame=frame, reference=near, limits=limits)
        return lambda T, near: room.head(model, _rotations(frame, T), frame=frame, reference=near, limits=limits)
    if is_arm and kind != "rotation":
        more: dict[str, Any] = {} if asked.criterion is None else {"criterion": asked.criterion.value}
        return lambda target, near: room.arm(
            model, str(limb)[0], target, direction=asked.direction, frame=frame, reference=near, limits=limits, **more
        )
    weights = {"place": (1.0, 0.0), "rotation": (0.0, 0.1), "pose": (1.0, 0.1)}[kind]
    return lambda target, near: room.numeric(
        model, frame, _as_poses(kind, target), reference=near, limits=limits, weights=weights
    )


def _rotations(frame: str, T: Floats) -> Floats:
    """The orientations of poses that the head is asked for, whose place follows from them."""
    print_note(f"of the poses of {frame} the orientations are used; two joints do not choose the place")
    return T[..., :3, :3]


def _as_poses(kind: str, target: Floats) -> Floats:
    """Places or rotations as poses, whose other half has no weight."""
    if kind == "pose":
        return target
    return join_poses(np.eye(3), target) if kind == "place" else join_poses(target, np.zeros(3))


def _scale(model: RobotModel, joint: str, deg: bool) -> float:
    """What a joint's value is multiplied with to be printed."""
    driver = model.mimics[joint].joint if joint in model.mimics else joint
    return math.degrees(1.0) if deg and model.unit(driver) == "rad" else 1.0


def _coordinates(model: RobotModel, found: IKResult) -> list[str]:
    """The coordinates that were solved for, by name: a joint that follows another is told by that other's."""
    first = model.nq - len(model.joint_names)
    return [model.joint_names[column - first] for column in found.columns]


def _print_one(model: RobotModel, found: IKResult, deg: bool, *, every: bool) -> None:
    """One target: the reason, and a table of joints and solutions."""
    print(found.describe(degrees=deg))
    names = _coordinates(model, found)
    scales = [_scale(model, name, deg) for name in names]
    shown = [found.best] if not every or int(found.count) < 2 else list(found.branches[: int(found.count)])
    if np.isnan(found.best).any():
        return
    headings = (
        [f"{'solution' if found.success else 'nearest'}"]
        if len(shown) == 1
        else [f"{i + 1}" for i in range(len(shown))]
    )
    rows = [
        [name, *(f"{without_sign_of_zero(float(values[j]) * scale, 5):.5f}" for values in shown)]
        for j, (name, scale) in enumerate(zip(names, scales, strict=True))
    ]
    unit = "°" if deg else "rad"
    print_table(
        ["joint", *(f"{heading}\n[{unit}]" for heading in headings)], rows, numbers=[f"{h}\n[{unit}]" for h in headings]
    )


def _print_lines(model: RobotModel, found: IKResult, deg: bool, *, every: bool) -> None:
    """A line for each target, or for each of its solutions: joint values, and the reason."""
    from nao_kin.ik import Reason

    names = _coordinates(model, found)
    scales = np.array([_scale(model, name, deg) for name in names])
    width = max(10, *(len(name) + 1 for name in names))
    print(f"{'row':>7}" + "".join(f"{name:>{width}}" for name in names) + "  reason")
    for row, reason in enumerate(found.reasons.tolist()):
        many = every and int(found.count[row]) > 1
        shown = found.branches[row][: int(found.count[row])] if many else found.best[row][None]
        for number, values in enumerate((shown * scales).tolist(), start=1):
            cells = "".join(f"{'–' if math.isnan(v) else f'{without_sign_of_zero(v, 5):.5f}':>{width}}" for v in values)
            said = f"solution {number} of {len(shown)}" if many else Reason(reason).name
            print(f"{row:>7}{cells}  {said}")


def _configurations(model: RobotModel, found: IKResult, *, deg: bool, every: bool) -> str:
    """Whole configurations under the names of all joints: solutions, or what is nearest, of each target."""
    q = found.solutions if every else found.q
    rows = q.reshape(-1, q.shape[-1])[:, -len(model.joint_names) :]
    rows = rows[~np.isnan(rows).any(axis=-1)]
    return targets_as_csv(model.joint_names, rows * [_scale(model, name, deg) for name in model.joint_names])


def _print_missed(found: IKResult, missed: Any, deg: bool) -> None:
    """Which of a list of targets are not reached, and why."""
    many = found.reasons.ndim > 0
    for row in missed[:_MOST_NAMED].tolist():
        said = found.describe((row,) if many else (), degrees=deg)
        print_note(f"target {row}: {said}" if many else said)
    if missed.size > _MOST_NAMED:
        print_note(f"and {missed.size - _MOST_NAMED} more of {found.reasons.size} targets")


def _print_left_out(found: IKResult, missed: Any) -> None:
    """What CSV, which holds configurations only, does not say: rows that are missing, or only near."""
    nothing = np.isnan(found.best[missed]).any(axis=-1)
    for rows, what in ((missed[nothing], "have no row"), (missed[~nothing], "have the nearest pose in their row")):
        if rows.size:
            print_note(f"targets {_ranges(rows.tolist())} {what}")


def _ranges(rows: list[int]) -> str:
    """Ascending numbers, neighbours taken together."""
    parts: list[list[int]] = []
    for row in rows:
        if parts and row == parts[-1][1] + 1:
            parts[-1][1] = row
        else:
            parts.append([row, row])
    shown = ", ".join(str(a) if a == b else f"{a}–{b}" for a, b in parts[:_MOST_RANGES])
    return shown if len(parts) <= _MOST_RANGES else f"{shown} and more, which --json names"


def _document(
    model: RobotModel, asked: Asked, targets: Targets, found: IKResult, *, deg: bool, every: bool
) -> dict[str, Any]:
    """The answer for JSON."""
    names = _coordinates(model, found)
    scales = np.array([_scale(model, name, deg) for name in names])
    head = {
        "robot": model.name,
        "frame": asked.frame,
        "limits": asked.limits,
        "units": {"length": "m", "angle": "deg" if deg else "rad"},
        "notes": list(found.notes),
    }
    indices: list[tuple[int, ...]] = [(row,) for row in range(len(targets.values))] if targets.many else [()]
    answers = [_answer(found, index, names, scales, every=every, deg=deg) for index in indices]
    return {**head, "targets": answers} if targets.many else {**head, **answers[0]}


def _answer(
    found: IKResult, index: tuple[int, ...], names: list[str], scales: Floats, *, every: bool, deg: bool
) -> dict[str, Any]:
    from nao_kin.ik import Family, LegsResult, Reason

    reason, count = Reason(int(found.reasons[index])), int(found.count[index])
    best, (away, turned) = found.best[index], found.residual[index].tolist()
    known = not np.isnan(best).any()
    answer: dict[str, Any] = {
        "success": reason is Reason.REACHED,
        "reason": reason.name,
        "message": found.describe(index, degrees=deg),
        "joints": dict(zip(names, (best * scales).tolist(), strict=True)) if known else None,
        "residual": {"position": away, "angle_rad": turned} if known else None,
        "count": count,
    }
    if isinstance(found, LegsResult) and not np.isnan(found.yaw_errors[index]).any():
        left, right = found.yaw_errors[index].tolist()
        answer["yaw_errors_rad"] = {"left": left, "right": right}
    if every:
        answer["solutions"] = [
            {
                "joints": dict(zip(names, (values * scales).tolist(), strict=True)),
                "family": Family(int(family)).name,
            }
            for values, family in zip(found.branches[index][:count], found.families[index][:count], strict=True)
        ]
    return answer


def _write_page(model: RobotModel, found: IKResult, html: str) -> str | None:
    """The best configuration with the other solutions as ghosts; of a list of targets, one after the other.

    Returns:
        The file; None where there is nothing to show.
    """
    from nao_kin.viewer import Viewer

    q = found.q.reshape(-1, model.nq)
    shown = q[~np.isnan(q).any(axis=-1)]
    if not len(shown):
        print_note("there is no solution to show; no page is written")
        return None
    with closing(Viewer(model)) as viewer:
        if found.reasons.ndim:
            viewer.animate(shown, _FPS)
        else:
            viewer.display(shown[0])
            if int(found.count) > 1:
                viewer.show_ghosts(found.solutions[1 : int(found.count)], first=2)
        return str(viewer.save_html(html))
