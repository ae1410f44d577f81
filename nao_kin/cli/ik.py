"""`nao-kin ik`: joint values for a pose of a foot, a hand, the head, or any frame of any robot."""

from __future__ import annotations

import math
import sys
from contextlib import closing
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np
import typer

from nao_kin._core import files as atomic
from nao_kin._core.arrays import Floats, join_poses
from nao_kin._core.sides import Hips
from nao_kin._core.text import abbreviated, quoted
from nao_kin.cli import options as shared
from nao_kin.cli.options import Needs, OutputOptions, RobotOptions, argument, command, flag, option
from nao_kin.cli.output import csv_text, degrees_per, fixed, print_json, print_note, print_table, print_written, units
from nao_kin.cli.sources import FileOptions, joint_values, numbers_of
from nao_kin.errors import BadArgument, NaoKinError, UnknownName

if TYPE_CHECKING:
    from nao_kin.ik import IKResult
    from nao_kin.robot import RobotModel
    from nao_kin.stream import Targets


# Both feet together.
LEGS = "Legs"
_FEET = ("LLeg", "RLeg")
# The largest number of unreached targets that are named one by one.
_MAX_NAMED = 5
# The clip of a list of targets shows so many solutions per second.
_FPS = 25.0

# Part of a message that is redundant for a single target.
_ONLY = " at index [0]"

_EXAMPLES = (
    'Example: nao-kin ik LArm --target "0.15 0.12 0.05" --html arm.html; '
    'nao-kin ik LLeg --target "0 0.05 -0.3 0 0 0" --all; '
    'nao-kin ik LAnkleRoll --robot romeo --analytic --target "0 0.1 -0.7 0 0 0" --all; '
    "nao-kin fk walk.csv --frame LLeg --csv | nao-kin ik LLeg - --csv"
)


@dataclass(frozen=True)
class Request:
    """The requested targets, and the format of the answer."""

    frame: str = argument("FRAME", "LLeg, RLeg, LArm, RArm, Head, a camera, Legs, or any other frame.")
    file: str | None = argument("FILE", "CSV, JSON or .npy file of targets, - for standard input.", None)
    target: str | None = option("NUMBERS", "One target, in quotes; see above.")
    direction: str | None = option("NUMBERS", "For a position: direction of the forearm, three numbers.")
    criterion: Literal["nearest", "limits", "manipulability"] | None = option(
        None, "For a position without --direction: which solution. Default: nearest."
    )
    priority: Literal["left", "right", "balanced"] | None = option(
        None, "For Legs: the foot with the smaller yaw error if one hip motor cannot satisfy both."
    )
    near: str | None = option(
        "POSTURE|FILE", "Prefer solutions near a posture or the configurations in a file. Default: all joints at zero."
    )
    columns: list[str] | None = shared.COLUMNS
    ignore_other: bool = shared.IGNORE_OTHER
    hips: Hips | None = shared.HIPS
    every: bool = flag("Print every solution.", "--all")
    limits: Literal["enforce", "ignore"] = shared.LIMITS
    numeric: bool = flag("Use the numeric solver even if there is a closed form.")
    analytic: bool = flag("Use the closed form that EAIK finds for up to six joints of any robot, with all branches.")
    lock: list[str] | None = option("NAME=VALUE", "With --analytic: keep a joint at this value; repeatable.")
    deg: bool = shared.DEG
    file_deg: bool = shared.FILE_DEG
    csv: bool = shared.CSV
    output: str | None = option("FILE", "Write the CSV here.")
    html: str | None = option("FILE", "Write a page with the robot in the best solution, and the other ones as ghosts.")
    needs: ClassVar[Needs] = {
        **dict.fromkeys(("columns", "ignore_other", "hips"), "near"),
        "file_deg": "file|near",
        "lock": "analytic",
    }

    def targets(self, model: RobotModel) -> Targets:
        """Return the one target, or those of the file."""
        from nao_kin.stream import Targets, read_targets

        frames = _FEET if self.frame == LEGS else (self.frame,)
        model.frame_ids(frames)
        if self.target is None:
            return read_targets(model, str(self.file), frames, degrees=self.file_deg)
        numbers = numbers_of(self.target, "--target")
        try:
            found = Targets.of([numbers], frames=len(frames), degrees=self.deg)
        except NaoKinError as error:
            raise BadArgument(f"--target {quoted(self.target)}: {str(error).replace(_ONLY, '')}") from None
        return replace(found, many=False)

    def preferred(self, model: RobotModel, targets: int) -> Floats | None:
        """Return the configuration of --near, or its configurations, one for each target."""
        if self.near is None:
            return None
        if self.near in model.posture_names:
            return model.posture(self.near)
        path = Path(self.near)
        if self.near != "-" and path.suffix.lower() not in (".csv", ".json") and not path.exists():
            hint = "or a CSV or JSON file of configurations"
            raise UnknownName("posture", self.near, model.posture_names, hint)
        given = FileOptions(file_deg=self.file_deg, columns=self.columns, ignore_other=self.ignore_other)
        q: Floats = given.log(model, self.near, hips=self.hips).q
        if len(q) not in (1, targets):
            found = f"{len(q)} configurations for {targets} targets"
            raise BadArgument(f"--near {self.near}: {found}; give one for all, or one for each")
        return q[0] if len(q) == 1 else q


@command("ik", _EXAMPLES)
def ik(request: Request, written: OutputOptions, robot: RobotOptions) -> None:
    """Find joint values for a pose: all solutions inside the limits, or the reason why there is none.

    The number of values determines the kind of target: 3 are a position, 4 (quaternion, scalar first) or 9 (rows) an
    orientation, 6 a position with roll, pitch, yaw, 7 a position with a quaternion, 16 the rows of a homogeneous
    matrix. Units are metres and radians, in the torso frame. The head takes an orientation, a camera a point to look
    at, another frame on the head a position; Legs takes the poses of both feet, the left one first. A file has one
    target in each row, and may be the output of `nao-kin fk --csv` or `--json`. --csv prints configurations for fk and
    view, without targets that have no solution.

    The exit code is 1 if a target is not reached; the nearest pose is then printed if there is one.
    """
    html, output, json = request.html, request.output, written.json
    if request.file is None and request.target is None:
        raise BadArgument('give one target with --target "NUMBERS", or the FILE of a list of them')
    written.check({"--output": output, "--html": html}, csv=request.csv, kind="csv")
    model = robot.load()
    targets = request.targets(model)
    found = _solved(model, request, targets, request.preferred(model, len(targets.values)))
    answers = _Answers(model, request, targets.many, targets.kind, found)
    print_note(*targets.notes, *found.notes)
    page = None if html is None else answers.write_page(html, targets, overwrite=written.force)
    if page is not None and not atomic.leads_to_standard_output(page) and not json:
        # With --csv, standard output is a file, which must not contain this line.
        print(page, file=sys.stderr if request.csv else sys.stdout)
    if output is not None:
        atomic.write_text(output, answers.as_csv())
    if json:
        print_json(answers.document(len(targets.values)) | ({} if page is None else {"html": page}))
    elif request.csv:
        sys.stdout.write(answers.as_csv())
    elif output is not None:
        print_written(output)
    elif html is None or not atomic.leads_to_standard_output(html):
        if targets.many:
            answers.print_lines()
        else:
            answers.print_one()
    missed = np.flatnonzero(~np.atleast_1d(found.success))
    if missed.size:
        if request.csv or output is not None or targets.many:
            answers.note_missed(missed.tolist())
        raise typer.Exit(1)


def _solved(model: RobotModel, request: Request, targets: Targets, near: Floats | None) -> IKResult:
    """Return the answer of the function of `nao_kin.ik` for this frame and this kind of target."""
    from nao_kin import ik as room

    frame, kind, limits = request.frame, targets.kind, request.limits
    direction = None if request.direction is None else numbers_of(request.direction, "--direction", 3)
    general = request.numeric or request.analytic
    fitting = [] if general or frame == LEGS else room.limbs(model, frame)
    limb = LEGS if frame == LEGS else "".join(f"{one['side']}{one['kind'].title()}" for one in fitting)
    is_arm = limb in ("LArm", "RArm")
    if limb == LEGS and general:
        raise BadArgument("--numeric and --analytic solve for one frame; Legs has two")
    if request.analytic and kind != "pose":
        raise BadArgument("--analytic takes poses: 6, 7 or 16 numbers")
    if limb != LEGS and request.priority is not None:
        raise BadArgument("--priority is for Legs, which has two feet")
    if not (is_arm and kind == "position") and (direction or request.criterion):
        form = "positions of a hand, three numbers, solved by the closed form of an arm"
        raise BadArgument(f"--direction and --criterion are for {form}")

    target = targets.values if targets.many else targets.values[0]
    if limb == LEGS:
        left, right = target[..., 0, :, :], target[..., 1, :, :]
        return room.legs(model, left, right, near=near, limits=limits, priority=request.priority or "balanced")
    common: Any = {"frame": frame, "near": near, "limits": limits}
    if limb in _FEET and kind == "pose":
        return room.leg(model, limb[0], target, **common)
    if limb == "Head" and kind == "position":
        if frame not in model.semantics.cameras:
            return room.head(model, position=target, **common)
        return room.look_at(model, target, frame, near=near, limits=limits)
    if limb == "Head":
        if kind == "pose":
            print_note(
                f"only the orientation of a pose is used for {frame}; its two joints cannot set the position too"
            )
        return room.head(model, target if kind == "orientation" else target[..., :3, :3], **common)
    if is_arm and kind != "orientation":
        criterion: Any = {} if request.criterion is None else {"criterion": request.criterion}
        return room.arm(model, str(limb)[0], target, direction=direction, **common, **criterion)
    if request.analytic:
        held = joint_values(request.lock, "--lock", model, request.deg)
        return room.analytic(model, frame, target, locked=held, near=near, limits=limits)
    if kind == "orientation":  # the position of the pose has no weight
        target, common["weights"] = join_poses(target, np.zeros(3)), (0.0, 0.1)
    return room.numeric(model, target=target, **common)


@dataclass(frozen=True)
class _Answers:
    """The solutions `found`, and their output in each format; `many` means a list of targets, of this `kind`."""

    model: RobotModel
    request: Request
    many: bool
    kind: str
    found: IKResult

    @cached_property
    def names(self) -> list[str]:
        """The solved coordinates, by name: a mimic joint is represented by its driver."""
        return [self.model.joint_names[column - self.model.nq_base] for column in self.found.columns]

    @cached_property
    def scales(self) -> Floats:
        """Factors of the coordinates in the output."""
        return self._scales(self.names)

    def _scales(self, names: list[str]) -> Floats:
        mimics, unit = self.model.mimics, self.model.unit
        drivers = [mimics[name].joint if name in mimics else name for name in names]
        return np.array([degrees_per(unit(driver), self.request.deg) for driver in drivers])

    def print_one(self) -> None:
        """Print the answer for one target: its kind, the reason, and a table of joints and solutions."""
        found, count = self.found, int(self.found.count)
        article = "an" if self.kind == "orientation" else "a"
        turned = ", quaternion w x y z" if len(str(self.request.target).replace(",", " ").split()) in (4, 7) else ""
        print(f"target: {'the poses of both feet' if self.request.frame == LEGS else f'{article} {self.kind}{turned}'}")
        print(found.describe(degrees=self.request.deg))
        if np.isnan(found.best).any():
            return
        several = self.request.every and count > 1
        shown = found.branches[:count] if several else found.best[None]
        heads = [f"{i + 1}" for i in range(count)] if several else ["solution" if found.success else "nearest"]
        columns = [f"{head}\n[{'°' if self.request.deg else 'rad'}]" for head in heads]
        values = (shown * self.scales).T.tolist()
        rows = [[name, *map(fixed, row)] for name, row in zip(self.names, values, strict=True)]
        print_table(["joint", *columns], rows, numbers=columns)

    def print_lines(self) -> None:
        """Print a line for each target, or for each of its solutions: joint values, and the reason."""
        from nao_kin.ik import Reason

        found, scales = self.found, self.scales
        width = max(10, *(len(name) + 1 for name in self.names))
        print(f"{'row':>7}" + "".join(f"{name:>{width}}" for name in self.names) + "  reason")
        for row, (reason, count) in enumerate(zip(found.reasons.tolist(), found.count.tolist(), strict=True)):
            several = self.request.every and count > 1
            shown = found.branches[row][:count] if several else found.best[row][None]
            for number, values in enumerate((shown * scales).tolist(), start=1):
                cells = "".join(f"{'–' if math.isnan(value) else fixed(value):>{width}}" for value in values)
                text = f"solution {number} of {count}" if several else Reason(reason).name
                print(f"{row:>7}{cells}  {text}")

    def as_csv(self) -> str:
        """Return whole configurations of all joints as CSV: the solutions, or the nearest one, of each target.

        A heading has the unit of its joint if that is degrees.
        """
        names = list(self.model.joint_names)
        scales = self._scales(names)
        headings = [name if scale == 1.0 else f"{name} [deg]" for name, scale in zip(names, scales, strict=True)]
        q = self.found.solutions if self.request.every else self.found.q
        rows = q.reshape(-1, q.shape[-1])[:, -len(names) :]
        return csv_text(headings, (rows[~np.isnan(rows).any(axis=-1)] * scales).tolist())

    def note_missed(self, missed: list[int]) -> None:
        """Print which targets are not reached and why, and which of them have a row in the CSV."""
        found = self.found
        for row in missed[:_MAX_NAMED]:
            text = found.describe((row,) if self.many else (), degrees=self.request.deg)
            print_note(f"target {row}: {text}" if self.many else text)
        if len(missed) > _MAX_NAMED:
            print_note(f"and {len(missed) - _MAX_NAMED} more of {found.reasons.size} targets")
        if (self.request.csv or self.request.output is not None) and self.many:
            nothing = np.isnan(found.best[missed]).any(axis=-1)
            for chosen, what in ((nothing, "have no row"), (~nothing, "have the nearest pose in their row")):
                if chosen.any():
                    rows = abbreviated(", ".join(map(str, np.array(missed)[chosen].tolist())))
                    print_note(f"targets {rows} {what}")

    def document(self, targets: int) -> dict[str, Any]:
        """Return the answer for JSON."""
        head = {
            "robot": self.model.name,
            "frame": self.request.frame,
            "target": self.kind,
            "limits": self.request.limits,
            "units": units(self.request.deg),
            "notes": list(self.found.notes),
        }
        return head | ({"targets": [self._answer((row,)) for row in range(targets)]} if self.many else self._answer(()))

    def _answer(self, index: tuple[int, ...]) -> dict[str, Any]:
        from nao_kin.ik import Family, LegsResult, Reason

        found, scales = self.found, self.scales
        reason, count = Reason(int(found.reasons[index])), int(found.count[index])
        best, (away, turned) = found.best[index], found.residual[index].tolist()
        known = not np.isnan(best).any()
        answer: dict[str, Any] = {
            "success": reason is Reason.REACHED,
            "reason": reason.name,
            "message": found.describe(index, degrees=self.request.deg),
            "joints": dict(zip(self.names, (best * scales).tolist(), strict=True)) if known else None,
            "residual": {"position": away, "angle_rad": turned} if known else None,
            "count": count,
        }
        if isinstance(found, LegsResult) and not np.isnan(found.yaw_errors[index]).any():
            left, right = found.yaw_errors[index].tolist()
            answer["yaw_errors_rad"] = {"left": left, "right": right}
        if self.request.every:
            branches = (found.branches[index][:count] * scales).tolist()
            answer["solutions"] = [
                {"joints": dict(zip(self.names, values, strict=True)), "family": Family(family).name}
                for values, family in zip(branches, found.families[index][:count].tolist(), strict=True)
            ]
        return answer

    def refused(self, targets: Targets) -> Floats:
        """Return the configurations outside the limits that reach the target, shape (k, nq)."""
        model, request = self.model, self.request
        every = _solved(model, replace(request, limits="ignore"), targets, request.preferred(model, 1))
        q = every.solutions[: int(every.count)]
        return q[~np.asarray(model.within_limits(q), bool)] if request.limits == "enforce" else q[:0]

    def marks(self, targets: Targets) -> dict[str, Floats]:
        """Return the target by the name of its frame, or of another one if it is not the frame's place."""
        target, frame = targets.values[0], self.request.frame
        if frame == LEGS:
            return dict(zip(("LLeg", "RLeg"), target, strict=True))
        if self.kind == "orientation":
            return {}
        is_seen = self.kind == "position" and frame in self.model.semantics.cameras
        return {"target" if is_seen else frame: target}

    def write_page(self, html: str, targets: Targets, *, overwrite: bool) -> str | None:
        """Write the best configuration, its target and the other solutions as ghosts, or a clip; return the file."""
        from nao_kin.viewer import Viewer

        found = self.found
        q = found.q.reshape(-1, self.model.nq)
        shown = q[~np.isnan(q).any(axis=-1)]
        if not len(shown):
            print_note("there is no solution to show; no page is written")
            return None
        with closing(Viewer(self.model)) as viewer:
            if self.many:
                viewer.animate(shown, _FPS)
            else:
                viewer.display(shown[0])
                viewer.show_targets(self.marks(targets))
                others = np.concatenate([found.solutions[1 : int(found.count)], self.refused(targets)])
                if len(others):
                    viewer.show_ghosts(others, first=2)
            return str(viewer.save_html(html, overwrite=overwrite))
