"""First estimates of unknown poses, from the nominal robot."""

from __future__ import annotations

import numpy as np

from nao_kin._core.arrays import Floats, join_poses, rigid_inverse
from nao_kin.calibration.observations import Checked, Pixels, Poses, camera_at
from nao_kin.calibration.unknowns import State
from nao_kin.errors import BadArgument
from nao_kin.rotations import mean_rotation, nearest_rotation

# Postures from which a board's pose is estimated; the best estimate counts.
_TRIED = 10
# Ratio of the least to the greatest extent of points that lie in a plane, and of those on a line.
_FLAT = 1e-6


def add_starts(state: State, observation: Checked, starts: dict[str, Floats]) -> None:
    """Estimate the poses that an observation needs and that have no start yet."""
    if all(name in starts for name, _ in observation.poses):
        return
    given = observation.given
    if isinstance(given, Pixels):
        starts[str(given.board)] = _board(state, observation, given)
    elif isinstance(given, Poses):
        frames = state.frame(observation.q, given.reference).inverse() @ state.frame(observation.q, given.frame)
        starts |= _markers(frames.T, np.reshape(given.poses, (-1, 4, 4)), given, starts)


def _board(state: State, observation: Checked, given: Pixels) -> Floats:
    """Return the pose of a board in its frame: of those estimated from single postures, the one that suits all best."""
    points, mask = np.reshape(given.points, (-1, 3)), observation.mask
    pixels = observation.measured * given.noise
    T_frame_cameras = (
        state.frame(observation.q, given.frame).inverse() @ camera_at(state, observation.q, given.camera)
    ).T
    found = list[tuple[float, Floats]]()
    for n in np.argsort(-mask.sum(axis=1), kind="stable")[:_TRIED]:
        rays = np.asarray(given.camera.ray(pixels[n]))
        usable = np.isfinite(rays).all(axis=-1)
        T_camera_board = _pose_of_points(points[usable], rays[usable])
        if T_camera_board is None:
            continue
        T_frame_board = T_frame_cameras[n] @ T_camera_board
        T = rigid_inverse(T_frame_cameras) @ T_frame_board
        seen = T[:, None, :3, :3] @ points[:, :, None]
        error = np.abs(given.camera.project(seen[..., 0] + T[:, None, :3, 3]) - pixels)[mask]
        found.append((float(np.median(np.nan_to_num(error, nan=np.inf))), T_frame_board))
    if not found:
        raise BadArgument(
            f"the pose of board {given.board} needs a posture that sees four of its points in a plane, or six; "
            f"or give start={{{given.board!r}: pose}}"
        )
    return min(found, key=lambda pair: pair[0])[1]


def _pose_of_points(points: Floats, rays: Floats) -> Floats | None:
    """Return the pose of a body in the camera's frame from the rays to its points; None for too few of them.

    The direct linear transform: ray × (R X + t) = 0 is linear in the columns of R that the points span, and in t. Its
    solution is fixed up to a factor, which the lengths of the columns and the side of the camera give.
    Source: Hartley and Zisserman, Multiple View Geometry, 7.1.
    """
    if len(points) < 4:
        return None
    centre = points.mean(axis=0)
    _, spread, axes = np.linalg.svd(points - centre)
    rank = int((spread > _FLAT * spread.max()).sum())
    if rank < 2 or (rank == 3 and len(points) < 6):
        return None
    B = axes[:rank].T
    size = spread[0] / np.sqrt(len(points))
    local = np.concatenate(((points - centre) @ B / size, np.ones((len(points), 1))), axis=1)
    x, y, z = rays.T
    o = np.zeros_like(x)
    skew = np.array([[o, -z, y], [z, o, -x], [-y, x, o]]).transpose(2, 0, 1)
    rows = np.einsum("nij,nk->nijk", skew, local).reshape(3 * len(points), -1)
    M = np.linalg.svd(rows)[2][-1].reshape(3, rank + 1)
    M /= (
        np.cbrt(np.linalg.norm(M[:, :rank], axis=0).prod())
        if rank == 3
        else np.sqrt(np.linalg.norm(M[:, :2], axis=0).prod())
    )
    M *= np.sign((rays * (local @ M.T)).sum())
    columns = M[:, :rank] if rank == 3 else np.column_stack((M[:, :2], np.cross(M[:, 0], M[:, 1])))
    full = B if rank == 3 else np.column_stack((B, np.cross(B[:, 0], B[:, 1])))
    try:
        R = nearest_rotation(columns @ full.T)
    except BadArgument:  # the rays are in a plane, or nearly one ray
        return None
    return join_poses(R, size * M[:, rank] - R @ centre)


def _markers(frames: Floats, poses: Floats, given: Poses, starts: dict[str, Floats]) -> dict[str, Floats]:
    """Return the unknown of T_world_marker = T_world_reference · T_reference_frame · T_frame_marker."""
    world = np.eye(4) if given.world is None else starts.get(given.world)
    marker = np.eye(4) if given.marker is None else starts.get(given.marker)
    if world is None and marker is not None:
        return {str(given.world): _mean(poses @ rigid_inverse(frames @ marker))}
    if world is None:
        world = _world(frames, poses)
    marker = _mean(rigid_inverse(world @ frames) @ poses)
    return {name: T for name, T in ((given.world, world), (given.marker, marker)) if name is not None}


def _world(frames: Floats, poses: Floats) -> Floats:
    """Return T_world_reference if both ends are unknown: P N = W F with N = T_marker_frame is linear in W and N.

    Source: Shah, Solving the robot-world/hand-eye calibration problem using the Kronecker product, 2013.
    """
    R_P, R_F, one = poses[:, :3, :3], frames[:, :3, :3], np.eye(3)
    rows = np.concatenate([np.hstack((np.kron(P, one), -np.kron(one, F.T))) for P, F in zip(R_P, R_F, strict=True)])
    W = np.linalg.svd(rows)[2][-1].reshape(2, 3, 3)[1]
    R_W = nearest_rotation(W * np.sign(np.linalg.det(W)))
    # R_P t_N + t_P = R_W t_F + t_W
    A = np.concatenate([np.hstack((P, -one)) for P in R_P])
    b = (frames[:, :3, 3] @ R_W.T - poses[:, :3, 3]).ravel()
    return join_poses(R_W, np.linalg.lstsq(A, b, rcond=None)[0][3:])


def _mean(T: Floats) -> Floats:
    return join_poses(mean_rotation(T[:, :3, :3]).rotation, T[:, :3, 3].mean(axis=0))
