"""The contenders of `bench_batch.py`: different ways to compute the same results for the same configurations.

Each contender is a function that writes its results into an array that exists already, so that no contender is charged
for allocating memory.
"""

from __future__ import annotations

import importlib.util
import tempfile
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

import nao_kin as nk

Answer = Callable[[NDArray[np.float64], NDArray[Any]], None]

MIXED = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
# Up to this number of configurations, this library chooses its number of threads itself.
FEW = 1000
# The quantities to compute, with their frames: "effectors", "joints" or "links".
QUESTIONS = ("effectors", "joints", "links", "jacobian", "com")


def frames_of(robot: nk.RobotModel, question: str) -> list[str]:
    """Return the frames of a quantity."""
    if question == "links":
        return list(robot.link_names)
    if question == "joints":
        # The NAO's 26 joints, without the fingers, which are mimic joints of the hands.
        return [*robot.joint_names, *(name for name in robot.mimics if name == "RHipYawPitch")]
    found = list(robot.semantics.end_effectors)
    return (found or list(robot.link_names[-5:]))[:5]


def answer_shape(robot: nk.RobotModel, question: str) -> tuple[int, ...]:
    """Return the shape of the result for one configuration."""
    if question == "com":
        return (3,)
    if question == "jacobian":
        return 6, robot.nv
    return len(frames_of(robot, question)), 4, 4


# --- this library -----------------------------------------------------------------------------------------------------


def ours(robot: nk.RobotModel, question: str, threads: int | None) -> Answer:
    """This library, in the precision of the results; without a number of threads it chooses the number itself."""
    frames = frames_of(robot, question)

    def answer(q: NDArray[np.float64], out: NDArray[Any]) -> None:
        # For a few configurations the library itself uses neither a second thread nor a compiled kernel.
        workers = threads if len(q) > FEW else None
        if question == "com":
            robot.com(q, out=out, threads=workers)
        elif question == "jacobian":
            robot.jacobian(q, frames[0], out=out, threads=workers)
        else:
            robot.fk(q, frames, out=out, threads=workers)

    return answer


# --- Pinocchio --------------------------------------------------------------------------------------------------------


def pinocchio_loop(robot: nk.RobotModel, question: str) -> Answer:
    """The usual loop over configurations: for poses, it reads the property `homogeneous` of each placement."""
    model, data = robot.model, robot.model.createData()
    ids = robot.frame_ids(frames_of(robot, question))

    def poses(q: NDArray[np.float64], out: NDArray[Any]) -> None:
        for row, answer in zip(q, out, strict=True):
            pin.forwardKinematics(model, data, row)
            for k, frame in enumerate(ids):
                pin.updateFramePlacement(model, data, frame)
                answer[k] = data.oMf[frame].homogeneous

    def jacobian(q: NDArray[np.float64], out: NDArray[Any]) -> None:
        for row, answer in zip(q, out, strict=True):
            answer[...] = pin.computeFrameJacobian(model, data, row, ids[0], MIXED)

    def com(q: NDArray[np.float64], out: NDArray[Any]) -> None:
        # Pinocchio leaves the root link out of its centre of mass; this step adds it for all configurations.
        held = model.inertias[0]
        share = pin.computeTotalMass(model) / robot.mass
        for row, answer in zip(q, out, strict=True):
            answer[...] = pin.centerOfMass(model, data, row)
        out *= share
        out += (1.0 - share) * held.lever

    return {"jacobian": jacobian, "com": com}.get(question, poses)


def pinocchio_strided(robot: nk.RobotModel, question: str) -> Answer:
    """The loop for experts: it knows how Pinocchio stores placements, and reads all wanted ones in one step."""
    model, data = robot.model, robot.model.createData()
    ids = robot.frame_ids(frames_of(robot, question))
    # R by columns, then p; the placement of the universe provides the zeros and the one of the last row.
    placements = np.lib.stride_tricks.as_strided(data.oMf[0].rotation, (12 * model.nframes,), (8,), writeable=False)
    places = np.full((len(ids), 4, 4), 1)
    row, column = np.indices((3, 4))
    places[:, :3] = 12 * np.array(ids)[:, None, None] + 3 * column + row
    places[:, 3, 3] = 0
    few = len(ids) <= 10

    def poses(q: NDArray[np.float64], out: NDArray[Any]) -> None:
        for values, answer in zip(q, out, strict=True):
            if few:
                pin.forwardKinematics(model, data, values)
                for frame in ids:
                    pin.updateFramePlacement(model, data, frame)
            else:
                pin.framesForwardKinematics(model, data, values)
            placements.take(places, out=answer, mode="clip")

    return poses


# --- NumPy and JAX ----------------------------------------------------------------------------------------------------


def structure_of_arrays(robot: nk.RobotModel, question: str, xp: Any) -> Callable[[Any], Any]:
    """Poses by the array operations of NumPy or JAX: one array for every entry of every matrix."""
    model = robot.model
    ids = robot.frame_ids(frames_of(robot, question))
    moving = {joint.name: joint for joint in robot.tree.moving_joints}
    needed = sorted({k for frame in ids for k in list(model.supports[model.frames[frame].parentJoint])[1:]})
    column = {name: k for k, name in enumerate(robot.joint_names, robot.nq_base)}

    def times(A: Sequence[Any], B: Sequence[Any]) -> list[Any]:
        """Multiply poses given as twelve entries, row by row; constant zeros and ones cost nothing."""

        def dot(x: Sequence[Any], y: Sequence[Any], start: Any) -> Any:
            total = start
            for a, b in zip(x, y, strict=True):
                if (isinstance(a, float) and a == 0.0) or (isinstance(b, float) and b == 0.0):
                    continue
                term = b if isinstance(a, float) and a == 1.0 else a if isinstance(b, float) and b == 1.0 else a * b
                total = term if isinstance(total, float) and total == 0.0 else total + term
            return total

        return [
            dot(A[4 * i : 4 * i + 3], (B[j], B[4 + j], B[8 + j]), A[4 * i + 3] if j == 3 else 0.0)
            for i in range(3)
            for j in range(4)
        ]

    def fixed(placement: pin.SE3) -> list[Any]:
        rows = np.round(placement.homogeneous[:3], 16)
        return [float(entry) for entry in rows.reshape(-1)]

    def moved(name: str, q: Any) -> list[Any]:
        joint = moving[name]
        driver, ratio, offset = (name, 1.0, 0.0)
        if joint.mimic is not None:
            driver, ratio, offset = joint.mimic.joint, joint.mimic.multiplier, joint.mimic.offset
        angle = ratio * q[:, column[driver]] + offset
        x, y, z = joint.axis
        s, c = xp.sin(angle), xp.cos(angle)
        v = 1.0 - c
        return [
            x * x * v + c, x * y * v - z * s, x * z * v + y * s, 0.0,
            x * y * v + z * s, y * y * v + c, y * z * v - x * s, 0.0,
            x * z * v - y * s, y * z * v + x * s, z * z * v + c, 0.0,
        ]  # fmt: skip

    def answer(q: Any) -> Any:
        poses: dict[int, list[Any]] = {0: fixed(pin.SE3.Identity())}
        for k in needed:
            placed = times(poses[model.parents[k]], fixed(model.jointPlacements[k]))
            poses[k] = times(placed, moved(model.names[k], q))
        entries = []
        one, zero = xp.ones_like(q[:, 0]), xp.zeros_like(q[:, 0])
        for frame in ids:
            row = model.frames[frame]
            pose = times(poses[row.parentJoint], fixed(row.placement))
            entries += [zero + entry if isinstance(entry, float) else entry for entry in pose] + [zero, zero, zero, one]
        return xp.stack(entries, axis=-1).reshape(len(q), len(ids), 4, 4)

    return answer


def numpy_arrays(robot: nk.RobotModel, question: str) -> Answer:
    """NumPy on parts of the batch that fit into the processor's cache."""
    answer = structure_of_arrays(robot, question, np)

    def run(q: NDArray[np.float64], out: NDArray[Any]) -> None:
        for start in range(0, len(q), 2048):
            out[start : start + 2048] = answer(q[start : start + 2048])

    return run


def jax_arrays(robot: nk.RobotModel, question: str) -> Answer:
    """JAX, compiled for this robot and these frames, in double precision."""
    import jax

    jax.config.update("jax_enable_x64", True)
    answer = jax.jit(structure_of_arrays(robot, question, jax.numpy))
    return lambda q, out: np.copyto(out, np.asarray(answer(q)))


# --- others -----------------------------------------------------------------------------------------------------------


def links_of(robot: nk.RobotModel, question: str) -> list[str]:
    """Return the links with the poses of a quantity's frames: other libraries have no frames of joints."""
    moved = {joint.name: joint.child for joint in robot.tree.moving_joints}
    return [name if name in robot.link_names else moved[name] for name in frames_of(robot, question)]


def without_shapes(robot: nk.RobotModel) -> ElementTree.Element:
    """Return the URDF without its visual elements."""
    root = ElementTree.parse(robot.urdf_path).getroot()
    for link in root.iter("link"):
        for shape in (*link.findall("visual"), *link.findall("collision")):
            link.remove(shape)
    return root


def mujoco_loop(robot: nk.RobotModel, question: str) -> Answer:
    """MuJoCo, one configuration after another; the mimic joints are set by hand."""
    import mujoco

    root = without_shapes(robot)
    options = {"fusestatic": "false", "balanceinertia": "true", "boundmass": "1e-6", "boundinertia": "1e-9"}
    ElementTree.SubElement(ElementTree.SubElement(root, "mujoco"), "compiler", options)
    model = mujoco.MjModel.from_xml_string(ElementTree.tostring(root, encoding="unicode"))
    data = mujoco.MjData(model)
    joints = [model.joint(k).name for k in range(model.njnt)]
    column = {name: k for k, name in enumerate(robot.joint_names)}
    ratio, offset, source = np.ones(model.nq), np.zeros(model.nq), np.zeros(model.nq, dtype=int)
    for k, name in enumerate(joints):
        mimic = robot.mimics.get(name)
        source[k] = column[mimic.joint if mimic else name]
        if mimic:
            ratio[k], offset[k] = mimic.multiplier, mimic.offset
    bodies = [model.body(name).id for name in links_of(robot, question)]

    def poses(q: NDArray[np.float64], out: NDArray[Any]) -> None:
        out[..., 3, :] = (0.0, 0.0, 0.0, 1.0)
        for row, answer in zip(ratio * q[:, source] + offset, out, strict=True):
            data.qpos[:] = row
            mujoco.mj_kinematics(model, data)
            answer[:, :3, :3] = data.xmat[bodies].reshape(-1, 3, 3)
            answer[:, :3, 3] = data.xpos[bodies]

    return poses


def frax_robot(robot: nk.RobotModel, question: str) -> Answer:
    """frax, compiled by JAX in double precision; the mimic joints are set by hand."""
    import frax
    import jax

    jax.config.update("jax_enable_x64", True)
    root = without_shapes(robot)
    for link in root.iter("link"):
        if link.find("inertial") is None:  # which frax needs
            inertial = ElementTree.SubElement(link, "inertial")
            ElementTree.SubElement(inertial, "mass", value="0")
            ElementTree.SubElement(inertial, "inertia", dict.fromkeys(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), "0"))
    with tempfile.NamedTemporaryFile(suffix=".urdf") as file:
        ElementTree.ElementTree(root).write(file.name)
        made = frax.Robot(file.name)
    names = list(made.joint_names)
    column = {name: k for k, name in enumerate(robot.joint_names)}
    mimics = [robot.mimics.get(name) for name in names]
    source = np.array([column[mimic.joint if mimic else name] for name, mimic in zip(names, mimics, strict=True)])
    ratio = np.array([mimic.multiplier if mimic else 1.0 for mimic in mimics])
    offset = np.array([mimic.offset if mimic else 0.0 for mimic in mimics])
    rows = [robot.model.frames[frame] for frame in robot.frame_ids(frames_of(robot, question))]
    # The root, for which frax has no joint, comes after all joints.
    parents = np.array([names.index(robot.model.names[row.parentJoint]) if row.parentJoint else -1 for row in rows])
    placements = np.stack([row.placement.homogeneous for row in rows])

    def poses(q: Any) -> Any:
        joints = jax.numpy.concatenate([made.joint_to_world_transforms(ratio * q[source] + offset), np.eye(4)[None]])
        return joints[parents] @ placements

    answer = jax.jit(jax.vmap(poses))
    return lambda q, out: np.copyto(out, np.asarray(answer(q)))


def torch_chain(robot: nk.RobotModel, question: str) -> Answer:
    """pytorch_kinematics; the mimic joints are set by hand."""
    import pytorch_kinematics
    import torch

    chain = pytorch_kinematics.build_chain_from_urdf(ElementTree.tostring(without_shapes(robot)))
    chain = chain.to(dtype=torch.float64)
    column = {name: k for k, name in enumerate(robot.joint_names)}
    names = chain.get_joint_parameter_names()
    mimics = [robot.mimics.get(name) for name in names]
    source = [column[mimic.joint if mimic else name] for name, mimic in zip(names, mimics, strict=True)]
    ratio = np.array([mimic.multiplier if mimic else 1.0 for mimic in mimics])
    offset = np.array([mimic.offset if mimic else 0.0 for mimic in mimics])
    frames = links_of(robot, question)
    indices = chain.get_frame_indices(*frames)

    def poses(q: NDArray[np.float64], out: NDArray[Any]) -> None:
        found = chain.forward_kinematics(torch.from_numpy(ratio * q[:, source] + offset), indices)
        for k, frame in enumerate(frames):
            out[:, k] = found[frame].get_matrix().numpy()

    return poses


OTHERS = {
    "MuJoCo": ("mujoco", mujoco_loop),
    "pytorch_kinematics": ("pytorch_kinematics", torch_chain),
    "JAX": ("jax", jax_arrays),
    "frax": ("frax", frax_robot),
}


def installed_others() -> dict[str, Callable[[nk.RobotModel, str], Answer]]:
    """Return the contenders of those other libraries that are installed."""
    return {name: make for name, (module, make) in OTHERS.items() if importlib.util.find_spec(module)}
