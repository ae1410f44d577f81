"""The Pinocchio model of a URDF tree, its frames by name, and the detection of changes in it."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, Literal, TypeAlias

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats, texts
from nao_kin._core.text import abbreviated, fresh_name, quoted
from nao_kin._core.warn import warn_caller
from nao_kin.errors import BadArgument, BadModel, RenamedFrameWarning, UnknownName
from nao_kin.robot.urdf import Origin, UrdfJoint, UrdfTree

Base = Literal["fixed", "floating"]
FrameIds = tuple[int, ...]

# Pinocchio's data grows with the cube of the number of joints: 0.6 GB for 200, 4 GB for 400.
MOST_JOINTS = 250

LIMIT_ARRAYS = tuple(f"{end}{kind}Limit" for kind in ("Position", "Velocity", "Effort") for end in ("lower", "upper"))
# Arrays of a model that users may change after loading.
_NUMBERS = (
    "armature",
    "damping",
    "lowerDryFrictionLimit",
    "upperDryFrictionLimit",
    "rotorGearRatio",
    "rotorInertia",
    *LIMIT_ARRAYS,
)

_REVOLUTE = {(1, 0, 0): pin.JointModelRX, (0, 1, 0): pin.JointModelRY, (0, 0, 1): pin.JointModelRZ}
_PRISMATIC = {(1, 0, 0): pin.JointModelPX, (0, 1, 0): pin.JointModelPY, (0, 0, 1): pin.JointModelPZ}
_IDENTITY = pin.SE3.Identity()


def build_model(tree: UrdfTree, base: Base) -> pin.Model:
    """Return a copy of the model of a URDF tree with a fixed or floating base; the original is built once per tree."""
    if base not in ("fixed", "floating"):
        raise BadArgument(f"base must be 'fixed' or 'floating', got {quoted(base)}")
    if isinstance(tree, str):
        raise BadArgument(f"RobotModel.from_file({quoted(tree)}) reads a file")
    if base not in tree.made:
        tree.made[base] = _built(tree, base)
    return tree.made[base].copy()


def _built(tree: UrdfTree, base: Base) -> pin.Model:
    """Return the model that Pinocchio's parser makes of such a URDF: same joints, frames and bodies in the same order.

    The model is built joint by joint, and not by the parser, because the parser orders siblings by name, has no
    unlimited joint of one coordinate, and calls itself recursively for every link of a chain.
    """
    if len(tree.moving_joints) > MOST_JOINTS:
        raise BadModel(
            f"{tree.name}: {len(tree.moving_joints)} moving joints; "
            f"Pinocchio's memory grows too fast beyond {MOST_JOINTS}"
        )
    model = pin.Model()
    model.name = tree.name
    joint = frame = 0
    # Joint of the file → its id, without Pinocchio's "universe", whose name a joint of the file may have.
    drivers: dict[str, int] = {}
    if base == "floating":
        # Pinocchio's own name for this joint, with a number if a joint of the file has that name.
        free = fresh_name("root_joint", {row.name for row in tree.joints})
        joint = model.addJoint(0, pin.JointModelFreeFlyer(), _IDENTITY, free)
        frame = model.addJointFrame(joint)
        model.appendBodyToJoint(joint, _inertia(tree, tree.root), _IDENTITY)
        frame = model.addBodyFrame(tree.root, joint, _IDENTITY, frame)
    else:
        body = pin.Frame(tree.root, joint, frame, _IDENTITY, pin.FrameType.BODY, _inertia(tree, tree.root))
        frame = model.addFrame(body)
    # Link → the joint that moves it, its pose in that joint's frame, and its place among the frames.
    links = {tree.root: (joint, _IDENTITY, frame)}
    for row in tree.joints:
        joint, placement, frame = links[row.parent]
        placement = _placed(placement, row.origin)
        if row.kind == "fixed":
            body = _inertia(tree, row.child)
            frame = model.addFrame(pin.Frame(row.name, joint, frame, placement, pin.FrameType.FIXED_JOINT, body))
        else:
            joint = model.addJoint(joint, _motion(row, model, drivers), placement, row.name)
            frame = model.addJointFrame(joint, frame)
            placement = _IDENTITY
            model.appendBodyToJoint(joint, _inertia(tree, row.child), placement)
            if row.mimic is None:
                drivers[row.name] = joint
                _set_limits(model, model.joints[joint], row)
        links[row.child] = joint, placement, model.addBodyFrame(row.child, joint, placement, frame)
    return model


def _motion(row: UrdfJoint, model: pin.Model, drivers: Mapping[str, int]) -> pin.JointModel:
    """Return Pinocchio's joint; a mimic joint moves with the coordinate of its driver."""
    aligned, free = (
        (_PRISMATIC, pin.JointModelPrismaticUnaligned)
        if row.kind == "prismatic"
        else (_REVOLUTE, pin.JointModelRevoluteUnaligned)
    )
    motion = aligned[row.axis]() if row.axis in aligned else free(np.array(row.axis))
    if row.mimic is None:
        return motion
    driver = model.joints[drivers[row.mimic.joint]]
    motion.setIndexes(driver.id, driver.idx_q, driver.idx_v, driver.idx_vExtended)
    return pin.JointModel(pin.JointModelMimic(pin.JointModel(motion), row.mimic.multiplier, row.mimic.offset))


def _set_limits(model: pin.Model, joint: pin.JointModel, row: UrdfJoint) -> None:
    model.lowerPositionLimit[joint.idx_q], model.upperPositionLimit[joint.idx_q] = row.lower, row.upper
    model.lowerVelocityLimit[joint.idx_v], model.upperVelocityLimit[joint.idx_v] = -row.velocity, row.velocity
    model.lowerEffortLimit[joint.idx_v], model.upperEffortLimit[joint.idx_v] = -row.effort, row.effort
    model.damping[joint.idx_v] = row.damping
    model.lowerDryFrictionLimit[joint.idx_v], model.upperDryFrictionLimit[joint.idx_v] = -row.friction, row.friction


def _placed(placement: pin.SE3, origin: Origin) -> pin.SE3:
    """Return the pose `origin`, given in the frame at `placement`."""
    if not any(origin.rpy) and not any(origin.xyz):
        return placement
    return placement * pin.SE3(pin.rpy.rpyToMatrix(*origin.rpy), np.array(origin.xyz))


def only_links(model: pin.Model, tree: UrdfTree, frame_ids: Iterable[int]) -> pin.Model:
    """Return a copy of a model of this tree in which only some links have mass: that of the file."""
    only, links = model.copy(), [model.frames[frame_id] for frame_id in frame_ids]
    only.name = f"{model.name} with only {abbreviated(', '.join(link.name for link in links)) or 'no link'}"
    for index in range(model.njoints):
        only.inertias[index] = pin.Inertia.Zero()
    for link in links:
        only.inertias[link.parentJoint] += link.placement.act(_inertia(tree, link.name))
    return only


def _inertia(tree: UrdfTree, link: str) -> pin.Inertia:
    """Return mass, centre and tensor of a link in its frame, unchanged: published tensors need not be physical."""
    body = pin.Inertia.Zero()
    row = tree.inertials.get(link)
    if row is not None:
        xx, xy, xz, yy, yz, zz = row.inertia
        tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        if any(row.origin.rpy):
            R = pin.rpy.rpyToMatrix(*row.origin.rpy)
            tensor = R @ tensor @ R.T
        body.mass, body.lever, body.inertia = row.mass, np.array(row.origin.xyz), tensor
    return body


def numbers_of(model: pin.Model) -> dict[str, Any]:
    """Return the placements, inertias, gravity, rotors and limits of a model in a form that pickles.

    A Pinocchio 4.1 model with mimic joints does not survive pickling: the copy crashes in forward kinematics.
    """
    return {
        "gravity": model.gravity.vector.copy(),
        "jointPlacements": list(model.jointPlacements),
        "inertias": list(model.inertias),
        "frames": [frame.placement for frame in model.frames],
        **{name: getattr(model, name).copy() for name in _NUMBERS},
    }


def restore_numbers(model: pin.Model, numbers: Mapping[str, Any]) -> None:
    """Write the numbers that `numbers_of` took from another model into a freshly built one."""
    model.gravity.vector = numbers["gravity"]
    for name in ("jointPlacements", "inertias"):
        for index, value in enumerate(numbers[name]):
            getattr(model, name)[index] = value
    for frame, placement in zip(model.frames, numbers["frames"], strict=True):
        frame.placement = placement
    for name in _NUMBERS:
        setattr(model, name, numbers[name])


# --- Detection of changes in the placements and masses of a Pinocchio model.
#
# A user who calibrates a robot writes into `robot.model`. Pinocchio uses the new numbers immediately; programs compiled
# from the old numbers must be made again. Reading all numbers one by one takes longer than a small batch, so they are
# compared in Pinocchio's own memory, where the elements lie at equal distances.

_DOUBLE = 8
# An inertia is its mass, lever and tensor: the mass of the next one follows the tensor.
_LEVER_AND_TENSOR = 9


def address(array: Floats) -> int:
    """Return the memory address of an array."""
    return int(array.__array_interface__["data"][0])


# The placements of some frames: views of Pinocchio's memory, and the bytes that were there.
SomeFrames: TypeAlias = tuple[tuple[NDArray[np.void], bytes], ...]


class ModelNumbers:
    """A copy of the numbers of a model, and views of the memory that holds them."""

    def __init__(self, model: pin.Model) -> None:
        self._inertias = model.inertias
        placements = _Part(model.jointPlacements, lambda placement: placement.rotation, 12)  # R by columns, then p
        frames = _Part(model.frames, lambda frame: frame.placement.rotation, 12)
        bodies = _Part(model.inertias, lambda inertia: inertia.lever, _LEVER_AND_TENSOR + 1, skip=1)
        last = _Part(model.inertias, lambda inertia: inertia.lever, _LEVER_AND_TENSOR)
        self._parts = placements, frames, bodies, last
        self._first = self._inertias[0]
        self._first_mass = float(self._first.mass)
        masses = [float(inertia.mass) for inertia in model.inertias]
        self._masses = None if bodies.view[:, _LEVER_AND_TENSOR].tolist() == masses[1:] else masses

    def changed(self) -> bool:
        """Return whether any number has changed since this object was made."""
        placements, frames, bodies, last = self._parts
        if placements.changed() or frames.changed() or bodies.changed() or last.changed():
            return True
        if self._masses is not None:  # None if this version of Pinocchio stores masses elsewhere
            return [float(inertia.mass) for inertia in self._inertias] != self._masses
        return bool(self._first.mass != self._first_mass)

    def placements_changed(self, some: SomeFrames | None = None) -> bool:
        """Return whether the placement of a joint or frame has changed since this object was made.

        With `some_frames` only these frames count: a robot has hundreds, and to compare all takes longer than a leg.
        """
        placements, frames, _, _ = self._parts
        return placements.changed() or frames.changed(some)

    def some_frames(self, frame_ids: Iterable[int]) -> SomeFrames:
        """Return the placements of some frames for `placements_changed`, as they were when this object was made."""
        return self._parts[1].some(frame_ids)


class _Part:
    """Some doubles of each element of a Pinocchio vector, without its last `skip` elements: a view and a copy."""

    def __init__(self, elements: Sequence[Any], array_in: Callable[[Any], Floats], doubles: int, skip: int = 0) -> None:
        self._elements, self._count = elements, len(elements)
        first = array_in(elements[0])
        step = address(array_in(elements[1])) - address(first) if self._count > 1 else _DOUBLE * doubles
        shape = self._count - skip, doubles
        self.view = np.lib.stride_tricks.as_strided(first, shape, (step, _DOUBLE), writeable=False)
        self._blocks = self.view.view(f"V{_DOUBLE * doubles}")  # copied by the block, not by the number
        self._seen = self._blocks.tobytes()

    def changed(self, some: SomeFrames | None = None) -> bool:
        """Return whether the vector has grown, which moves it and invalidates the view, or a number has changed."""
        if len(self._elements) != self._count:
            return True
        if some is None:
            return self._blocks.tobytes() != self._seen
        for now, seen in some:  # noqa: SIM110, a generator takes longer than the comparison
            if now.tobytes() != seen:
                return True
        return False

    def some(self, rows: Iterable[int]) -> SomeFrames:
        """Return views of some elements, each with its former bytes."""
        size = self._blocks.itemsize
        return tuple((self._blocks[row], self._seen[size * row : size * (row + 1)]) for row in rows)


# --- The frames of a robot by name.

# Name of the root as a reference, unless the robot has a frame with this name.
WORLD = "world"
# Size of the cache of ids, one for each set of frames.
_MAX_SETS = 1000


class FrameTable:
    """Frame name → id in a Pinocchio model.

    The frames of fixed joints are left out: they coincide with the frames of the links that these joints carry. A name
    that the URDF gives to a link and to a joint means the link, as in every tool that knows only links. If the joint's
    frame is another one, the first use of the name warns that the joint's frame has the name of the link it moves.
    """

    def __init__(self, model: pin.Model, tree: UrdfTree, base: Base) -> None:
        self._floating = base == "floating"
        links, joints = dict[str, int](), dict[str, int]()
        for index, frame in enumerate(model.frames):
            if frame.type == pin.FrameType.BODY:
                links[frame.name] = index
            elif index > 0 and frame.type != pin.FrameType.FIXED_JOINT:
                joints[frame.name] = index
        self._ids = {name: links[link] for name, link in tree.shared_names.items()} | links
        moved = {joint.name: joint.child for joint in tree.moving_joints}
        # Shared name → the link that it means, and the link that has the joint's frame.
        self._ambiguous = {
            name: (link, moved[name])
            for name, link in tree.shared_names.items()
            if name in moved and moved[name] != link
        }
        for name, index in joints.items():
            self._ids.setdefault(name, index)
        order = self._ids | joints
        self.names = tuple(sorted(self._ids, key=order.__getitem__))
        self.places = MappingProxyType({name: self._ids[name] for name in self.names})
        self.link_names = tuple(links)
        self._link_ids, self._links = tuple(links.values()), links
        self._shared_names = tree.shared_names
        self._known = functools.lru_cache(_MAX_SETS)(lambda key: tuple(map(self.id, key)))

    def id(self, name: object) -> int:
        """Return the id of a frame."""
        if not isinstance(name, str | None):
            raise BadArgument(f"a frame is named by a text, got {quoted(name, 60)}; are two arguments swapped?")
        if name not in self._ids:
            raise UnknownName("frame", name, self.names, self._about_world if str(name) == WORLD else "")
        frames = self._ambiguous.pop(name, None)  # removed, so that only the first call warns
        if frames is not None:
            link, moved = frames
            warn_caller(
                f"frame {quoted(name)}: the URDF has a link and a joint of this name. This is the link's frame "
                f"({quoted(link)}); the joint's own frame is {quoted(moved)}",
                RenamedFrameWarning,
            )
        return self._ids[name]

    def link_ids(self, names: str | Sequence[str]) -> FrameIds:
        """Return the ids of links, each once, in the order of `link_names`; `names` may be one name."""
        given = {
            self._shared_names.get(name, name)
            for name in ((names,) if isinstance(names, str) else texts(names, "links"))
        }
        for name in sorted(given - self._links.keys()):
            raise UnknownName("link", name, self.link_names)
        return tuple(index for link, index in self._links.items() if link in given)

    def reference_id(self, name: object) -> int | None:
        """Return the id of a frame; None for the root, which None means and, with a floating base, "world"."""
        if name is None or (self._floating and isinstance(name, str) and name == WORLD and name not in self._ids):
            return None
        return self.id(name)

    @property
    def _about_world(self) -> str:
        """How poses in the world are obtained, where the world is no frame."""
        if self._floating:
            return 'the world is a reference only: poses with reference="world", or without a reference, are in it'
        return 'the place of a fixed base in the world is not known; load the robot with base="floating"'

    def ids(self, names: str | Sequence[str] | None) -> FrameIds:
        """Return the ids of the frames with these names, or with one name; for None, those of all links."""
        if names is None:
            return self._link_ids
        key = (names,) if isinstance(names, str) or not isinstance(names, Iterable) else tuple(names)
        try:
            return self._known(key)
        except TypeError:  # what cannot be hashed is no name
            return tuple(map(self.id, key))
