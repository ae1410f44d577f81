"""A robot: one configuration, or a batch of them, in; poses, rotations, Jacobians and the centre of mass out."""

from __future__ import annotations

import operator
import threading
from collections.abc import Collection, Iterable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from nao_kin._arrays import Floats, as_floats
from nao_kin.errors import BadArgument, NotFinite, OutsideLimits, UnknownName
from nao_kin.parameters import CoupledLimit
from nao_kin.robot.build import Base, ModelSource, numbers_of, restore_numbers, source_of_tree
from nao_kin.robot.coordinates import UNIT_TOLERANCE, Coordinates
from nao_kin.robot.limits import JointLimits, LimitViolation
from nao_kin.robot.workspace import Selection, Workspace, expression_named, over_batch, selection_of
from nao_kin.urdf_reader import Mimic, read_urdf

LimitPolicy = Literal["raise", "clamp", "ignore"]
WORLD = "world"

_POLICIES = ("raise", "clamp", "ignore")
# An error about a batch carries the violations of this many configurations, and counts the rest.
_MOST_TOLD = 100


class RobotModel:
    """A robot from a URDF, with one coordinate per joint that can be moved on its own.

    Configurations are arrays q of shape (..., nq). With a fixed base, q holds the joint values in the order of
    `joint_names`. With a floating base, seven numbers of Pinocchio's free-flyer stand before them: the position of the
    base in the world and its orientation as a unit quaternion (x, y, z, w).

    All methods take any leading batch shape, return fresh arrays, and may be called from several threads at once.

    Attributes:
        model: the Pinocchio model, nq coordinates and nv velocities.
        urdf_path: the file it came from.
        base: "fixed" or "floating".
        load_notes: what had to be changed on loading, one line each.
        joint_names: names of the joints with a coordinate of their own, in the order of q.
        joint_units: unit of each: "rad", "m", or "1" for a ratio.
        mimics: the joints that follow another one, by name.
        frame_names: every name `fk` takes: links and joints. A joint's frame moves with the joint.
        link_names: the links, in the order in which `fk(q)` returns them.
        lower: smallest joint values, shape (n,).
        upper: largest joint values, shape (n,).
        velocity_limits: largest joint speeds, shape (n,).
        effort_limits: largest joint torques or forces, shape (n,).
        coupled_limits: tables in which one joint's range depends on another's value.
    The limits are those of the file; changing them in `model` changes what Pinocchio knows, not what this class checks.
    """

    def __init__(
        self,
        source: ModelSource,
        urdf_path: Path,
        *,
        mimics: Mapping[str, Mimic] | None = None,
        units: Mapping[str, str] | None = None,
        coupled_limits: Sequence[CoupledLimit] = (),
        load_notes: Sequence[str] = (),
    ) -> None:
        self._source = source
        self.model = model = source.build()
        self.urdf_path = Path(urdf_path)
        self.base: Base = source.base
        self.load_notes = tuple(load_notes)
        self.coupled_limits = tuple(coupled_limits)
        self.mimics: Mapping[str, Mimic] = MappingProxyType(dict(mimics or {}))
        self._units = dict(units or {})

        moving = [joint for joint in list(model.joints)[1:] if joint.nq == 1]
        self.joint_names: tuple[str, ...] = tuple(model.names[joint.id] for joint in moving)
        self.joint_units = tuple(self._units.get(name, "rad") for name in self.joint_names)
        self._q_offset = moving[0].idx_q if moving else model.nq
        self._coordinates = Coordinates(self.joint_names, self.mimics)

        joints = slice(self._q_offset, None)
        self.lower, self.upper = _frozen(model.lowerPositionLimit[joints]), _frozen(model.upperPositionLimit[joints])
        velocities = slice(model.nv - len(moving), None)
        self.velocity_limits = _frozen(model.upperVelocityLimit[velocities])
        self.effort_limits = _frozen(model.upperEffortLimit[velocities])
        self._one = (int(model.nq),)
        self._limits = JointLimits(self.joint_names, self.lower, self.upper, self.joint_units, self.coupled_limits)

        ids, self.link_names = _frame_table(model)
        self.frame_names = tuple(ids)
        self._frames = {name: (frame_id, selection_of([frame_id])[0]) for name, frame_id in ids.items()}
        self._link_selection = selection_of([ids[name] for name in self.link_names])
        self._local = threading.local()

    @classmethod
    def from_urdf(cls, path: Path | str, *, base: Base = "fixed") -> RobotModel:
        """A robot from any URDF, with every joint coupling kept.

        Couplings that Pinocchio refuses are mended (see `load_notes`): joints are ordered so that the driving one comes
        first, `continuous` joints become revolute ones without limits, axes are normalised, a link that shares its name
        with a joint gets the suffix "_link". Meshes are not read.

        Args:
            path: the URDF file.
            base: "fixed", or "floating" for a free base.

        Raises:
            BadModel: the file cannot be read or describes no tree of revolute, continuous, prismatic and fixed joints.
        """
        path = Path(path).absolute()
        tree = read_urdf(path)
        return RobotModel(
            source_of_tree(tree, base),
            path,
            mimics={joint.name: joint.mimic for joint in tree.joints if joint.mimic is not None},
            units={joint.name: "m" for joint in tree.joints if joint.kind == "prismatic"},
            load_notes=tree.notes,
        )

    @property
    def name(self) -> str:
        """Name of the robot, as its URDF has it."""
        return str(self.model.name)

    @property
    def nq(self) -> int:
        """Number of coordinates in q."""
        return int(self.model.nq)

    @property
    def nv(self) -> int:
        """Number of velocity coordinates: the degrees of freedom."""
        return int(self.model.nv)

    @property
    def mass(self) -> float:
        """Mass of the whole robot, root link included [kg]."""
        # With a fixed base, Pinocchio counts only what moves: the rest is bolted to the world.
        return float(pin.computeTotalMass(self.model) + self.model.inertias[0].mass)

    def unit(self, joint: str) -> str:
        """Unit of a joint's value, of a joint that follows another one too: "rad", "m", or "1" for a ratio.

        Raises:
            UnknownName: no such joint.
        """
        if joint not in self.joint_names and joint not in self.mimics:
            raise UnknownName("joint", joint, (*self.joint_names, *self.mimics))
        return self._units.get(joint, "rad")

    # --- configurations -------------------------------------------------------------------------------------------

    def neutral(self) -> Floats:
        """All joints at zero, a floating base at the world's origin; shape (nq,).

        Zero is the configuration that the frames are defined in. It need not lie inside the limits: NAO's elbows
        stop 2° before it.
        """
        return self._neutral(())

    def random(self, rng: np.random.Generator | int | None = None, n: int | tuple[int, ...] | None = None) -> Floats:
        """Configurations inside all limits, coupled ones included, each joint uniform in its range.

        Joints without limits are uniform in [−π, π]; a floating base stays at the world's origin.

        Args:
            rng: a generator, or a seed for one.
            n: how many, or a batch shape; None for one configuration of shape (nq,).

        Returns:
            Configurations, shape (n…, nq).

        Raises:
            BadArgument: no generator and no seed, or no batch shape.
        """
        try:
            generator = np.random.default_rng(rng)
            shape = () if n is None else tuple(map(operator.index, n if isinstance(n, Iterable) else (n,)))
        except (TypeError, ValueError) as error:
            raise BadArgument(f"random needs a generator or a seed, and a number or a shape: {error}") from None
        if any(length < 0 for length in shape):
            raise BadArgument(f"n must not be negative, got {n}")
        q = self._neutral(shape)
        q[..., self._q_offset :] = self._limits.random(generator, shape)
        return q

    def configuration(self, angles: Mapping[str, ArrayLike], *, limits: LimitPolicy = "raise") -> Floats:
        """The configuration with the given joint values; joints not named are at zero.

        A joint that follows another one may be named too: alone it sets the driving joint, beside it the two must
        agree.

        Args:
            angles: joint name → value, or an array of values of one batch shape [rad, m or ratio].
            limits: what to do with a named joint outside its limits: "raise", "clamp" or "ignore".

        Returns:
            q, shape (..., nq).

        Raises:
            UnknownName: no such joint.
            CouplingViolated: two joints of one motor disagree.
            OutsideLimits: a named joint is outside its limits.
            WrongShape, NotFinite, BadArgument: values that are no numbers of one batch shape.
        """
        joints, given = self._coordinates.values(angles)
        q = self._neutral(joints.shape[:-1])
        q[..., self._q_offset :] = joints
        return self._within(q, limits, given)

    def angles(self, q: ArrayLike) -> dict[str, Floats | float]:
        """Joint values by name, joints that follow another one not included: the inverse of `configuration`.

        Args:
            q: configurations, shape (..., nq).

        Returns:
            name → float, or → array of the batch shape.
        """
        return self._coordinates.by_name(self._checked(q)[..., self._q_offset :])

    # --- kinematics -----------------------------------------------------------------------------------------------

    def fk(
        self,
        q: ArrayLike,
        frame: str | Sequence[str] | None = None,
        *,
        reference: str | None = None,
        limits: LimitPolicy = "ignore",
    ) -> Floats:
        """Poses of frames: T_reference_frame maps coordinates in the frame to coordinates in the reference.

        Args:
            q: configurations, shape (..., nq).
            frame: a frame name, several, or None for all links in the order of `link_names`.
            reference: the frame to express the poses in. None for the root: the trunk with a fixed base, the world
                with a floating one. "world" names the latter in both cases.
            limits: "ignore" computes the pose wherever the joints are; "raise" and "clamp" look at the limits first.

        Returns:
            Homogeneous matrices, shape (..., 4, 4) for one name, (..., n, 4, 4) for several [m].

        Raises:
            UnknownName: no such frame.
            WrongShape, NotFinite: q is no configuration.
            OutsideLimits: with limits="raise".
        """
        q = self._within(self._checked(q), limits)
        workspace = self._workspace()
        if not self._is_root(reference):
            return self._relative_fk(q, frame, str(reference))
        if isinstance(frame, str):
            frame_id, selection = self._frame(frame)
            if q.ndim == 1:
                return workspace.pose(q, frame_id, selection)
            return over_batch(q, (4, 4), lambda row: workspace.pose(row, frame_id, selection))
        selection = self._selection(frame)
        if q.ndim == 1:
            return workspace.poses(q, selection)
        return over_batch(q, selection.shape, lambda row: workspace.poses(row, selection))

    def rotation(
        self, q: ArrayLike, frame: str | Sequence[str] | None = None, *, reference: str | None = None
    ) -> Floats:
        """Rotations of frames, R_reference_frame; arguments as in `fk`, shape (..., 3, 3) or (..., n, 3, 3)."""
        return np.array(self.fk(q, frame, reference=reference)[..., :3, :3])

    def position(
        self, q: ArrayLike, frame: str | Sequence[str] | None = None, *, reference: str | None = None
    ) -> Floats:
        """Positions of frame origins in the reference; arguments as in `fk`, shape (..., 3) or (..., n, 3) [m]."""
        return np.array(self.fk(q, frame, reference=reference)[..., :3, 3])

    def jacobian(self, q: ArrayLike, frame: str, expressed_in: Literal["frame", "root", "mixed"] = "mixed") -> Floats:
        """Geometric Jacobian of a frame with respect to the root: J(q) · velocity = twist (linear; angular).

        Args:
            q: configurations, shape (..., nq).
            frame: a frame name.
            expressed_in: "frame": twist at the frame's origin in the frame's axes; "mixed": at the frame's origin in
                the root's axes; "root": the spatial twist, at the root's origin in the root's axes.

        Returns:
            Shape (..., 6, nv): rows vx vy vz ωx ωy ωz, columns in the order of the velocities; a joint that drives
            others carries their motion in its column [m/s and rad/s per unit of joint speed].

        Raises:
            UnknownName: no such frame or expression.
            WrongShape, NotFinite: q is no configuration.
        """
        q = self._checked(q)
        frame_id, expression = self._frame(frame)[0], expression_named(expressed_in)
        workspace = self._workspace()
        return over_batch(q, (6, self.nv), lambda row: workspace.jacobian(row, frame_id, expression))

    def com(self, q: ArrayLike, *, reference: str | None = None) -> Floats:
        """Centre of mass of the whole robot, the root link included.

        Args:
            q: configurations, shape (..., nq).
            reference: the frame to express it in, as in `fk`.

        Returns:
            Position, shape (..., 3) [m].

        Raises:
            BadArgument: the robot has no mass.
        """
        q = self._checked(q)
        fixed, moving_mass = self.model.inertias[0], float(pin.computeTotalMass(self.model))
        mass = moving_mass + float(fixed.mass)
        if mass <= 0.0:
            raise BadArgument(f"{self.name} has no mass, so no centre of mass")
        workspace = self._workspace()
        moving = over_batch(q, (3,), workspace.com) if moving_mass > 0.0 else np.zeros((*q.shape[:-1], 3))
        centres: Floats = (moving_mass * moving + fixed.mass * np.asarray(fixed.lever)) / mass
        if self._is_root(reference):
            return centres
        T_root_reference = self.fk(q, str(reference))
        lever = centres - T_root_reference[..., :3, 3]
        com: Floats = np.einsum("...ji,...j->...i", T_root_reference[..., :3, :3], lever)
        return com

    # --- limits ---------------------------------------------------------------------------------------------------

    def limit_violations(self, q: ArrayLike) -> tuple[LimitViolation, ...]:
        """Every joint outside its limits, by configuration and then by how far; empty when all are inside."""
        return self._limits.violations(self._checked(q)[..., self._q_offset :])

    def check_limits(self, q: ArrayLike) -> Floats:
        """`q` as an array when every joint is inside its limits, the tables of coupled limits included.

        Raises:
            OutsideLimits: with the violations.
        """
        return np.array(self._within(self._checked(q), "raise"))

    def clamp(self, q: ArrayLike) -> Floats:
        """The nearest configurations inside the limits: first every joint into its box, then into its table."""
        return self._within(self._checked(q), "clamp")

    # --- inside ---------------------------------------------------------------------------------------------------

    def _neutral(self, shape: tuple[int, ...]) -> Floats:
        return np.tile(pin.neutral(self.model), (*shape, 1)).reshape(*shape, self.nq)

    def _checked(self, q: ArrayLike) -> Floats:
        # The common case, one good configuration, in as few steps as possible; everything else takes the long way.
        if (
            type(q) is np.ndarray
            and q.shape == self._one
            and q.dtype == np.float64
            and self.base == "fixed"
            and np.isfinite(q).all()
        ):
            return q
        try:
            array = as_floats(q, (self.nq,), "q")
        except NotFinite as error:
            column = error.index[-1] - self._q_offset
            name = self.joint_names[column] if column >= 0 else "base"
            raise NotFinite("q", error.index, error.value, name) from None
        if self.base == "floating":
            norms = np.linalg.norm(array[..., 3:7], axis=-1)
            if np.any(np.abs(norms - 1.0) > UNIT_TOLERANCE):
                worst = float(norms.flat[np.argmax(np.abs(norms - 1.0))])
                raise BadArgument(f"q[..., 3:7] must be a unit quaternion (x, y, z, w), got one of norm {worst:.6g}")
            array = array.copy()
            array[..., 3:7] /= norms[..., None]  # what is left of the norm would end up in the rotation matrices
        return array

    def _within(self, q: Floats, limits: str, joints: Collection[str] | None = None) -> Floats:
        if limits == "ignore":
            return q
        _check_policy(limits)
        values = q[..., self._q_offset :]
        if limits == "raise":
            count = self._limits.count(values, joints)
            if count:
                raise OutsideLimits(self._limits.violations(values, joints, most=_MOST_TOLD), count)
            return q
        inside = np.array(q)
        clamped = self._limits.clamp(values)
        if joints is None:
            inside[..., self._q_offset :] = clamped
        else:
            columns = [self._coordinates.column[name] for name in joints]
            inside[..., [self._q_offset + column for column in columns]] = clamped[..., columns]
        return inside

    def _is_root(self, reference: str | None) -> bool:
        """Whether `reference` is the root; a link that is called "world" is a link like any other."""
        return reference is None or (reference == WORLD and WORLD not in self._frames)

    def _frame(self, name: str) -> tuple[int, Selection]:
        try:
            return self._frames[name]
        except (KeyError, TypeError):
            raise UnknownName("frame", name, self.frame_names) from None

    def _selection(self, frames: Sequence[str] | None) -> Selection:
        if frames is None:
            return self._link_selection
        if not isinstance(frames, Iterable):
            raise UnknownName("frame", frames, self.frame_names)
        return selection_of([self._frame(name)[0] for name in frames])

    def _relative_fk(self, q: Floats, frame: str | Sequence[str] | None, reference: str) -> Floats:
        """T_reference_frame = T_root_reference⁻¹ T_root_frame, from one pass over the configurations."""
        selection = self._selection([frame] if isinstance(frame, str) else frame)
        both = np.concatenate([selection, self._selection([reference])])
        workspace = self._workspace()
        poses = over_batch(q, both.shape, lambda row: workspace.poses(row, both))
        frames, origin = poses[..., :-1, :, :], poses[..., -1:, :, :]
        inverse = np.swapaxes(origin[..., :3, :3], -1, -2)
        relative = frames.copy()
        relative[..., :3, :3] = inverse @ frames[..., :3, :3]
        relative[..., :3, 3:] = inverse @ (frames[..., :3, 3:] - origin[..., :3, 3:])
        return np.array(relative[..., 0, :, :]) if isinstance(frame, str) else relative

    def _workspace(self) -> Workspace:
        try:
            workspace: Workspace = self._local.workspace
        except AttributeError:
            workspace = self._local.workspace = Workspace(self.model)
        return workspace

    def __getstate__(self) -> dict[str, Any]:
        state = self.__dict__.copy()
        state["model"] = numbers_of(self.model)
        state["mimics"] = dict(self.mimics)
        del state["_local"]
        return state

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self.mimics = MappingProxyType(state["mimics"])
        self.model = self._source.build()
        restore_numbers(self.model, state["model"])
        for array in (self.lower, self.upper, self.velocity_limits, self.effort_limits):
            array.flags.writeable = False
        self._local = threading.local()

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.name}: {self.nv} degrees of freedom, {len(self.link_names)} links>"


def _frozen(array: ArrayLike) -> Floats:
    """A read-only copy."""
    copy: Floats = np.array(array, dtype=np.float64)
    copy.flags.writeable = False
    return copy


def _check_policy(limits: str) -> None:
    if not isinstance(limits, str) or limits not in _POLICIES:
        raise UnknownName("limits policy", limits, _POLICIES)


def _frame_table(model: pin.Model) -> tuple[dict[str, int], tuple[str, ...]]:
    """Frame name → id in the model's order, and the names of the links.

    The frames of fixed joints are left out, for the links they hold stand at the same place; where two frames share a
    name, the link has it.
    """
    links = {frame.name: index for index, frame in enumerate(model.frames) if frame.type == pin.FrameType.BODY}
    table = {}
    for index, frame in enumerate(model.frames):
        if index > 0 and frame.type != pin.FrameType.FIXED_JOINT and frame.name not in table:
            table[frame.name] = links.get(frame.name, index)
    return table, tuple(links)


def check_robot(robot: object) -> None:
    """Raise `BadArgument` for what is no robot model."""
    if not isinstance(robot, RobotModel):
        raise BadArgument(f"robot must be a RobotModel, got {type(robot).__name__}")
