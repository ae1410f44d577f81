"""A NAO walks, lifts a foot, and draws a figure eight in the air: poses of feet and a hand, followed by `nk.ik.follow`.

The torso is upright, and placed so that the centre of mass is where the plan requires it: above the standing sole.

Example:
    python scripts/walk_and_draw.py    # writes walk_and_draw.html
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import nao_kin as nk
from nao_kin.rotations import rot_x

FPS = 30.0

Floats = NDArray[np.float64]

# Lengths in m, times in s.
APART, HEIGHT, LIFT = 0.1, 0.308, 0.025
STEPS = (-0.04, -0.04, -0.04, 0.0, 0.04, 0.04, 0.04, 0.0)  # how far ahead of the other a foot is put down
SHIFT_TIME, SWING_TIME = 0.45, 0.55
# The centre of mass above a sole, relative to its ankle: ahead, and towards the other foot.
AHEAD, INWARDS = 0.02, 0.004
EIGHT_SIZE, EIGHT_TIME, EIGHTS = (0.055, 0.04), 4.0, 2
EIGHT_FROM_TORSO = (0.15, -0.1, 0.16)
RAISED = (0.03, -0.01, 0.06)  # the right foot while the hand draws
TURNED = 0.05  # the height of a foot that is turned with its leg, so that the ankle does not roll
# The largest error of the centre of mass.
SETTLED = 1e-6
MARGIN = 0.01


@dataclass
class Plan:
    """Rows for the frames of a motion: positions of both soles, and the desired centre of mass (x, y)."""

    left: list[Floats] = field(default_factory=lambda: [np.array([0.0, APART / 2, 0.0])])
    right: list[Floats] = field(default_factory=lambda: [np.array([0.0, -APART / 2, 0.0])])
    com: list[Floats] = field(default_factory=lambda: [np.array([AHEAD, 0.0])])

    def __len__(self) -> int:
        return len(self.com)

    def go_on(self, seconds: float, com: Floats, *, left: Floats | None = None, right: Floats | None = None) -> None:
        """Move the centre of mass and one foot, which is lifted in between if it is put down elsewhere."""
        frames = round(seconds * FPS)
        for rows, last in ((self.left, left), (self.right, right)):
            first = rows[-1]
            target = first if last is None else last
            arc = LIFT if target[2] == first[2] and target[0] != first[0] else 0.0
            for u in smooth((np.arange(frames) + 1.0) / frames):
                height = 4.0 * arc * u * (1.0 - u)
                rows.append(first + u * (target - first) + [0.0, 0.0, height])
        first = self.com[-1]
        self.com.extend(first + u * (com - first) for u in smooth((np.arange(frames) + 1.0) / frames))

    def places(self, side: str) -> Floats:
        """Return the positions of a sole."""
        return np.array(self.left if side == "L" else self.right)

    def standing(self, side: str) -> NDArray[np.bool_]:
        """Return the frames in which a sole is on the floor."""
        return np.asarray(self.places(side)[:, 2] == 0.0)


def smooth(u: Floats) -> Floats:
    """Interpolate from 0 to 1, with zero speed and acceleration at both ends."""
    return np.asarray(u**3 * (10.0 - 15.0 * u + 6.0 * u * u))


def at(places: Floats) -> Floats:
    """Return poses with the axes of the world."""
    T = np.tile(np.eye(4), (len(places), 1, 1))
    T[:, :3, 3] = places
    return T


def above(sole: Floats) -> Floats:
    """Return the desired centre of mass for standing on one sole."""
    return np.asarray(sole[:2] + np.array([AHEAD, -INWARDS * np.sign(sole[1])]))


def walk() -> Plan:
    """Walk back and forth; each foot is put down, ahead of the other or beside it, before the other is lifted."""
    plan = Plan()
    for step, ahead in enumerate(STEPS):
        moved, support = (plan.right, plan.left) if step % 2 == 0 else (plan.left, plan.right)
        plan.go_on(SHIFT_TIME, above(support[-1]))
        target = np.array([support[-1][0] + ahead, moved[-1][1], 0.0])
        foot = {"right": target} if moved is plan.right else {"left": target}
        plan.go_on(SWING_TIME, above(support[-1]), **foot)
    plan.go_on(SHIFT_TIME, 0.5 * (above(plan.left[-1]) + above(plan.right[-1])))
    return plan


def stand_on_one_leg(after: Plan) -> Plan:
    """Step onto the left foot, lift the right one backwards, and return in the opposite order."""
    plan = Plan(after.left[-1:], after.right[-1:], after.com[-1:])
    middle, down = plan.com[-1], plan.right[-1]
    plan.go_on(0.9, above(plan.left[-1]))
    plan.go_on(0.9, above(plan.left[-1]), right=down + np.array(RAISED))
    plan.go_on(EIGHT_TIME * EIGHTS, above(plan.left[-1]))
    plan.go_on(0.9, above(plan.left[-1]), right=down)
    plan.go_on(0.9, middle)
    return plan


def eight(centre: Floats, turns: Floats) -> Floats:
    """Return points on a figure eight across x."""
    s = 2.0 * np.pi * turns
    width, height = EIGHT_SIZE
    return np.asarray(centre + np.stack([0.0 * s, width * np.sin(s), height * np.sin(2.0 * s)], axis=-1))


def to_eight_and_back(plan: Plan, rest: Floats, centre: Floats) -> Floats:
    """Return points from rest to the middle of the eight while the foot is lifted, along the eight, and back."""
    n, drawn = len(plan), round(EIGHT_TIME * EIGHTS * FPS)
    first = (n - 1 - drawn) // 2
    to_it = smooth(np.linspace(0.0, 1.0, first + 1))[:, None]
    reached = rest + to_it * (centre - rest)
    along = eight(centre, np.arange(1, drawn + 1) / (EIGHT_TIME * FPS))
    return np.concatenate([reached, along, reached[-2::-1]])


def drawing_path(nao: nk.NaoModel, plan: Plan, q: Floats, centre: Floats) -> dict[str, Floats]:
    """Return positions of the right hand and points to look at; both start and end at those of a configuration."""
    camera = nao.fk(q, "CameraTop")
    looked_at = camera[:3, 3] + 0.5 * camera[:3, 0]
    rests = {"RArm": nao.position(q, "RArm"), "CameraTop": looked_at}
    return {name: to_eight_and_back(plan, rest, centre) for name, rest in rests.items()}


def soles(nao: nk.NaoModel, plan: Plan, torso: Floats, side: str) -> Floats:
    """Return poses of a sole in the world: flat on the floor; if lifted, rotated about x at the ankle, with the leg."""
    T = at(plan.places(side))
    zero = nao.neutral()
    hip = torso[:, :3, 3] + nao.position(zero, f"{side}HipRoll", reference="torso")
    up_to_ankle = nao.position(zero, f"{side}AnkleRoll", reference=f"{side}Leg")
    ankle = T[:, :3, 3] + up_to_ankle
    lean = np.arctan2(ankle[:, 1] - hip[:, 1], hip[:, 2] - ankle[:, 2])
    T[:, :3, :3] = rot_x(lean * smooth(np.minimum(1.0, T[:, 2, 3] / TURNED)))
    T[:, :3, 3] = ankle - T[:, :3, :3] @ up_to_ankle
    return T


def balanced(
    nao: nk.NaoModel, plan: Plan, reference: Floats, beside: dict[str, Floats]
) -> tuple[nk.ik.FollowedPath, dict[str, Floats]]:
    """Follow a plan and further targets, with the torso placed so that the centre of mass is at its target.

    The torso is moved by the error of the centre of mass, which nearly moves with the torso: each iteration reduces the
    error about ten times.

    Returns:
        The result, and the targets.
    """
    wanted = np.array(plan.com)
    in_torso = nao.com(reference, reference="torso").reshape(-1, 3).mean(axis=0)
    torso = at(np.column_stack([wanted - in_torso[:2], np.full(len(plan), HEIGHT)]))
    times = np.arange(len(plan)) / FPS
    for _ in range(20):
        path = {f"{side}Leg": soles(nao, plan, torso, side) for side in "LR"} | beside
        found = nk.ik.follow(nao, path, torso=torso, near=reference, times=times)
        if np.isnan(found.q).any():
            break
        error = wanted - nao.com(found.q)[:, :2]
        if np.abs(error).max() < SETTLED:
            break
        torso[:, :2, 3] += error
    return found, path


def swinging_arms(nao: nk.NaoModel, plan: Plan) -> Floats:
    """Return configurations whose arms swing against the legs."""
    q = np.tile(nao.posture("StandInit"), (len(plan), 1))
    apart = np.array(plan.left)[:, 0] - np.array(plan.right)[:, 0]
    first = nao.nq_base
    for joint, sign in (("LShoulderPitch", 1.0), ("RShoulderPitch", -1.0)):
        q[:, first + nao.joint_names.index(joint)] += sign * 3.0 * apart
    return q


def largest(values: Floats) -> float:
    """Return the largest magnitude, 0 for an empty array."""
    return float(np.abs(values).max(initial=0.0))


def report(nao: nk.NaoModel, plan: Plan, found: nk.ik.FollowedPath, path: dict[str, Floats]) -> bool:
    """Print the checks of a part of the motion; return whether all are satisfied."""
    if not found.success:
        print(f"  NO   all targets reached, without a jump: {found.message}")
        return False
    checks = [("all targets reached, without a jump", True, found.message)]
    for side, name in (("L", "left"), ("R", "right")):
        stands = plan.standing(side)
        off = largest((nao.fk(found.q, f"{side}Leg") - at(plan.places(side)))[stands])
        checks.append((f"the {name} sole stays where it stands", off < 1e-9, f"off by {off:.1e}"))
        alone = stands & ~plan.standing("R" if side == "L" else "L")
        if alone.any():
            margin = float(nk.world.margin(nao, found.q[alone], soles=f"{side}Leg", outline="sensors").min())
            said = f"{1e3 * margin:.1f} mm inside its sensors in {alone.sum()} frames"
            checks.append((f"the centre of mass is above the {name} sole on one leg", margin > MARGIN, said))
    if "RArm" in path:
        off = largest(nao.position(found.q, "RArm") - path["RArm"])
        checks.append(("the hand draws the eight", off < 1e-9, f"off by {off:.1e} m"))
    share = found.largest_speed_share
    checks.append(("no joint is too fast", share <= 1.0 and not found.stretched, f"{100 * share:.0f} % of its limit"))
    for what, fine, said in checks:
        print(f"  {'yes' if fine else 'NO '}  {what}: {said}")
    return all(fine for _, fine, _ in checks)


@dataclass(frozen=True)
class Shown:
    """The motion and what the page shows besides.

    Attributes:
        nao: the robot.
        q: configurations at `FPS`, shape (n, nq).
        centre: the middle of the figure eight.
        drawing: a configuration in which the hand draws.
        fine: whether all checks are satisfied.
    """

    nao: nk.NaoModel
    q: Floats
    centre: Floats
    drawing: Floats
    fine: bool


def compute() -> Shown:
    """Compute the motion, and print its checks."""
    nao = nk.load_nao(base="floating")
    walked = walk()
    print(f"walk, {len(STEPS)} steps:")
    walking, path = balanced(nao, walked, swinging_arms(nao, walked), {})
    fine = report(nao, walked, walking, path)

    drawn = stand_on_one_leg(walked)
    q = walking.q[-1]
    centre = nao.position(q, "torso") + EIGHT_FROM_TORSO
    print(f"draw, {EIGHTS} times round:")
    drawing, path = balanced(nao, drawn, q, drawing_path(nao, drawn, q, centre))
    fine &= report(nao, drawn, drawing, path)
    posed = drawing.q[len(drawing.q) // 2 - round(0.6 * EIGHT_TIME * FPS)]
    return Shown(nao, np.concatenate([walking.sampled(FPS), drawing.sampled(FPS)[1:]]), centre, posed, fine)


def viewer_of(shown: Shown) -> nk.Viewer:
    """Return a viewer with the motion, the figure eight and the centre of mass."""
    viewer = nk.Viewer(shown.nao)
    viewer.add_line("eight", eight(shown.centre, np.linspace(0.0, 1.0, 73)), color=(0.85, 0.2, 0.5))
    viewer.show_com()
    viewer.animate(shown.q, FPS)
    viewer.camera("three-quarter")
    return viewer


def last_pose() -> nk.Viewer:
    """Return a viewer that shows the robot while its hand draws."""
    shown = compute()
    viewer = viewer_of(shown)
    viewer.show_support_polygon()
    viewer.display(shown.drawing)
    return viewer


def main() -> int:
    """Compute the motion, check it, and write the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--html", type=Path, default=Path("walk_and_draw.html"), help="the page to write")
    options = parser.parse_args()
    shown = compute()
    if not shown.fine:
        return 1
    with viewer_of(shown) as viewer:
        clip = viewer.save_html(options.html, overwrite=True)
        print(f"{clip}: {len(shown.q)} frames, {clip.stat().st_size / 1e6:.2f} MB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
