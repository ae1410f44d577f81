"""From joints that turn relative to their parents to points and orientations: BVH, and SMPL in AMASS."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats, cross, norm
from nao_kin.errors import BadArgument, BadInputFile
from nao_kin.imitation.layouts import LAYOUTS, SIDES, tables
from nao_kin.imitation.reading import Options, seconds
from nao_kin.imitation.skeleton import Skeleton, assembled
from nao_kin.rotations import exp

# Joints between the two ends of a bone are this far from it at most, as part of its length: they twist it.
_BESIDE = 0.15
# The square of a length that is none.
_LEAST = 1e-12


def of_tree(
    times: Floats,
    names: Sequence[str],
    parents: Sequence[int],
    local: Sequence[tuple[Floats, Floats]],
    rest: Sequence[tuple[Floats, Floats]],
    options: Options,
    *,
    rest_is_upright: bool = True,
) -> Skeleton:
    """Return the skeleton of joints that have positions and rotations relative to their parents, and a rest pose.

    `rest_is_upright`: the axis that points up in the rest pose does so in the frames.
    """
    # Axes of points in an order are those of cameras.
    layout, notes = options.layout(names, ordered=False)
    points, rotations = _forward(parents, local)
    resolved = layout.resolved(names)
    standing, _ = _forward(parents, rest)
    at = {name: i for i, name in enumerate(names)}
    _refuse_bent_bones(
        {name: joints for name, joints in resolved.items() if name not in (layout.stated or ())}, names, parents, points
    )
    frames = _part_frames({name: np.mean([standing[at[p]][0] for p in parts], 0) for name, parts in resolved.items()})
    turned = {}
    for part, R_rest_part in frames.items():
        joint = resolved.get(part.replace("hand", "wrist"), ())
        if len(joint) == 1:
            turned[part] = rotations[at[joint[0]]] @ R_rest_part
    up = frames["chest"][:, 2] if frames and rest_is_upright else None
    return assembled(
        times,
        dict(zip(names, points, strict=True)),
        layout,
        units=options.units,
        up=options.up,
        orientations=turned,
        rest_up=None if up is None else ("-" if up.sum() < 0.0 else "") + "xyz"[int(np.abs(up).argmax())],
        notes=tuple(notes),
    )


def _refuse_bent_bones(
    resolved: Mapping[str, tuple[str, ...]], names: Sequence[str], parents: Sequence[int], points: Sequence[Floats]
) -> None:
    """Raise if a limb bends between the joints found for its ends, which then are others, such as a clavicle."""
    for side in SIDES:
        for one, two in (("shoulder", "elbow"), ("elbow", "wrist"), ("hip", "knee"), ("knee", "ankle")):
            ends = [resolved.get(side + part, ()) for part in (one, two)]
            if any(len(end) != 1 for end in ends):
                continue
            start, k = (names.index(end[0]) for end in ends)
            bone = points[k] - points[start]
            bent = -1
            while (k := parents[k]) not in (start, -1):
                away = norm(cross(points[k] - points[start], bone))
                if (away > _BESIDE * np.maximum(norm(bone) ** 2, _LEAST)).any():
                    bent = k
            if k == start and bent >= 0:
                raise BadArgument(
                    f"{names[start]}, found for {side}{one}, bends at {names[bent]} before the {two}; "
                    f"names= (--names) states the joint, such as {side}{one}={names[bent]}"
                )


def _forward(parents: Sequence[int], local: Sequence[tuple[Floats, Floats]]) -> tuple[list[Floats], list[Floats]]:
    """Return positions (n, 3) and rotations (n, 3, 3) of joints in the axes of the root's parent."""
    points: list[Floats] = []
    rotations: list[Floats] = []
    for parent, (p, R) in zip(parents, local, strict=True):
        if parent < 0:
            points.append(p)
            rotations.append(R)
        else:
            points.append(points[parent] + np.einsum("nij,nj->ni", rotations[parent], p))
            rotations.append(rotations[parent] @ R)
    return points, rotations


def _part_frames(rest: Mapping[str, Floats]) -> dict[str, Floats]:
    """Return R_rest_part, of the axes that `Skeleton` states, in a rest pose; nothing unless it stands along the axes.

    The person is taken to look ahead in it, and the palms to be turned to the body or, with arms stretched out, down.
    """
    needed = ("pelvis", "neck", "left_shoulder", "right_shoulder", "left_knee", "right_knee")
    if not all(name in rest for name in needed):
        return {}
    left = _nearest_axis(rest["left_shoulder"] - rest["right_shoulder"])
    up = _nearest_axis(rest["neck"] - rest["pelvis"])
    legs = _nearest_axis(rest["left_knee"] + rest["right_knee"] - 2.0 * rest["pelvis"])
    if left is None or up is None or legs is None or left @ up or (legs != -up).any():
        return {}
    ahead = cross(left, up)
    trunk = np.stack([ahead, left, up], axis=1)
    frames = dict.fromkeys(("pelvis", "chest", "head"), trunk)
    for side, y in zip(SIDES, (-ahead, ahead), strict=True):
        ends = [rest[side + part] for part in ("elbow", "wrist", "hand") if side + part in rest][-2:]
        x = ends[-1] - ends[0] if ends else ahead
        z = cross(x, y)
        if norm(z) > 0.5 * norm(x):
            x, z = x / norm(x), z / norm(z)
            frames[side + "hand"] = np.stack([x, cross(z, x), z], axis=1)
    return frames


def _nearest_axis(vector: Floats) -> Floats | None:
    """Return the signed coordinate axis within 30° of a vector."""
    k = int(np.abs(vector).argmax())
    return np.sign(vector[k]) * np.eye(3)[k] if abs(vector[k]) > np.cos(np.pi / 6.0) * norm(vector) else None


def of_amass(name: str, arrays: Mapping[str, NDArray[Any]], options: Options) -> Skeleton:
    """Return the skeleton of the rotations of the joints of SMPL, SMPL-H or SMPL-X; those of fingers are left out."""
    table = tables()["smpl"]
    joints, parents = LAYOUTS["smpl"].orders[0], table["parents"]
    turning = len(joints) - 2  # the hands of SMPL turn with the wrists in SMPL-H
    poses = arrays["poses"]
    if poses.ndim != 2 or poses.shape[1] < 3 * turning or poses.dtype.kind != "f" or not np.isfinite(poses).all():
        raise BadInputFile(name, f"poses must be finite numbers (n, {3 * turning} or more), got {poses.shape}")
    n = len(poses)
    if not n:
        raise BadInputFile(name, "poses has no frames")
    trans = arrays.get("trans", np.zeros((n, 3)))
    if trans.shape != (n, 3) or trans.dtype.kind != "f" or not np.isfinite(trans).all():
        raise BadInputFile(name, f"trans must be finite numbers ({n}, 3), got {trans.shape}")
    rates = [arrays[key] for key in ("mocap_framerate", "mocap_frame_rate") if key in arrays]
    if rates and (rates[0].size != 1 or rates[0].dtype.kind not in "fiu"):
        raise BadInputFile(name, f"mocap_framerate must be one number, got {rates[0].dtype} of shape {rates[0].shape}")
    if rates and options.rate is None:
        options = replace(options, rate=float(rates[0].item()))
    times, _ = seconds(name, options, n)
    rotations = exp(poses[:, : 3 * turning].astype(np.float64).reshape(n, turning, 3))
    still = np.tile(np.eye(3), (n, 1, 1))
    local, rest = [], []
    for k, joint in enumerate(joints):
        side = next((side for side in SIDES if joint.startswith(side)), "")
        offset = _rest_offset(table["rest"][joint.removeprefix(side)], side)
        local.append((np.tile(offset, (n, 1)) if k else trans, rotations[:, k] if k < turning else still))
        rest.append((offset[None], still[:1]))
    return of_tree(times, joints, parents, local, rest, options, rest_is_upright=False)


def _rest_offset(row: Sequence[float], side: str) -> Floats:
    """Return the place of a joint from its parent for a row of [smpl.rest]: direction on the left side, and length."""
    direction = np.array(row[:3])
    return direction * ((-1.0 if side == "right_" else 1.0), 1.0, 1.0) * row[3] / (norm(direction) or 1.0)
