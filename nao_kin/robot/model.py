"""A robot model from a file: its kinematics, and its shapes, soles, mirror images and calibrated offsets."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from nao_kin._core.arrays import TOUCHING, Floats, choice, shaped
from nao_kin._core.text import abbreviated, quoted
from nao_kin._core.warn import warn_caller
from nao_kin.errors import BadArgument, OtherRobotWarning
from nao_kin.robot.build import Base
from nao_kin.robot.chains import mirror_image, mirrored
from nao_kin.robot.collisions import Clearance, CollisionRule, Contact, Obstacle
from nao_kin.robot.geometry import GeometryKind, Shape, geometry_model, shapes_of, unit_notes
from nao_kin.robot.ground import OutlineKind, SetDown, set_down, sole_outline
from nao_kin.robot.kinematic_robot import KinematicRobot
from nao_kin.robot.link_shapes import LinkShapes
from nao_kin.robot.offsets import with_frames, with_offsets
from nao_kin.robot.semantics import INERTIAL_UNIT, Mimic, Semantics
from nao_kin.robot.semantics_files import camera_of, find_semantics, pose_of_body
from nao_kin.robot.support_polygon import SupportPolygon, support_polygon
from nao_kin.robot.urdf import Collision, UrdfTree, Visual, read_mjcf, read_robot, read_urdf

_Robot = TypeVar("_Robot", bound="RobotModel")


class RobotModel(KinematicRobot):
    """A robot from a URDF or MJCF, with one coordinate for each joint that moves independently.

    Configurations are arrays q of shape (..., nq). With a fixed base, q holds the joint values in the order of
    `joint_names`. With a floating base, the seven numbers of Pinocchio's free-flyer precede them: the position of the
    base in the world and its orientation as a unit quaternion (x, y, z, w).

    All methods take any leading batch shape, return new arrays, and may be called from several threads concurrently.

    Pinocchio computes a few configurations; compiled kernels, which agree with it to 1e-12, compute many. The methods
    for poses, Jacobians, motions and centres of mass share three arguments:

    - `dtype`: precision of the result, np.float64 or np.float32; None for that of `out`, or float64. With float32, many
      configurations are also computed in float32. Poses, Jacobians and centres of mass are then accurate to 2e-6 where
      joints are within a turn of zero; angles and rates of motion, which enlarge rounding, to several times that.
    - `out`: an array for the result, which is also returned. It must have the shape and precision of the result, be
      contiguous, and not share memory with the input; otherwise BadArgument or WrongShape is raised.
    - `threads`: how many threads may compute many configurations; None for all cores where that is worthwhile. If it
      is a number, the kernels compute any batch, however small, and the result of a configuration is the same to the
      last bit in every batch.

    Attributes:
        model: the Pinocchio model.
        name: name of the robot in its URDF.
        nq: number of coordinates in q.
        nq_base: number of coordinates of the base, which are first in q: 7 of a floating base, 0 of a fixed one.
        nv: number of velocity coordinates: the degrees of freedom.
        tree: the URDF as read: links, joints, inertias and shapes.
        semantics: what the URDF lacks: chains, end effectors, postures, coupled limits.
        urdf_path: the file that was read.
        base: "fixed" or "floating".
        load_notes: changes made on loading, one line each.
        joint_names: names of the independent joints, in the order of q.
        joint_units: unit of each joint's value: "rad", "m", or "1" for a ratio.
        mimics: the joints that follow another one, by name.
        chains: named chains, each with its joints from the trunk outwards; empty without semantics.
        posture_names: the names that `posture` takes.
        frame_names: every name `fk` takes: links and joints. A joint's frame moves with the joint; a name that the URDF
            gives to a link and to a joint means the link.
        frame_table: frame name → index in Pinocchio's list, in the order of `frame_names`.
        link_names: the links, in the order in which `fk(q)` returns them.
        lower: smallest joint values, shape (n,).
        upper: largest joint values, shape (n,).
        velocity_limits: largest joint speeds, above 0, shape (n,); ∞ for a joint without a speed limit, which is also
            the meaning of a 0 in the file.
        effort_limits: largest joint torques or forces, shape (n,).
        coupled_limits: tables in which one joint's range depends on another's value.

    The limits are those of the file; changing them in `model` affects Pinocchio, not the checks of this class.

    Examples:
        >>> nao = nk.load_nao()
        >>> isinstance(nao, nk.RobotModel), nao.name, round(float(nao.upper[0]), 3)
        (True, 'nao_v6', 2.086)
    """

    # --- from files -----------------------------------------------------------------------------------------------

    @classmethod
    def from_file(
        cls,
        path: Path | str,
        *,
        base: Base = "fixed",
        semantics: Semantics | Path | str | None = None,
        package_dirs: Iterable[Path | str] = (),
        xacro: bool | None = None,
        xacro_arguments: Mapping[str, object] | None = None,
    ) -> RobotModel:
        """Return a robot from a URDF, xacro or MJCF file; the format is recognised by the content.

        Args:
            path: the file; it is read once, and may be a pipe.
            base: "fixed", or "floating" for a free base.
            semantics: chains, end effectors, postures …, as for `from_urdf`.
            package_dirs: folders to search for packages and meshes, as `from_urdf` and `from_mjcf` take them.
            xacro: whether to expand the file as a xacro source, as for `from_urdf`.
            xacro_arguments: values of the arguments of a xacro source, by name.

        Raises:
            BadModel: the file has none of the three formats, or its reader refuses it.
            MissingExtra: MuJoCo, which reads MJCF, is not installed.
            BadArgument: xacro arguments for a file that is not expanded.

        Examples:
            >>> robot = nk.RobotModel.from_file(nk.load_nao().urdf_path)
            >>> robot.nv, robot.load_notes
            (25, ())
        """
        tree, own = read_robot(path, package_dirs=package_dirs, xacro=xacro, xacro_arguments=xacro_arguments)
        return _loaded(tree, semantics, own, base)

    @classmethod
    def from_urdf(
        cls,
        path: Path | str,
        *,
        base: Base = "fixed",
        semantics: Semantics | Path | str | None = None,
        package_dirs: Iterable[Path | str] = (),
        xacro: bool | None = None,
        xacro_arguments: Mapping[str, object] | None = None,
    ) -> RobotModel:
        """Return a robot from any URDF, with every joint coupling.

        Descriptions that Pinocchio refuses are repaired (see `load_notes`): joints are ordered so that the driving one
        comes first, `continuous` joints become revolute ones without limits, axes are normalised, a link that shares
        its name with a joint is renamed ("…_link", or "…_frame" if that is taken) and found under both names. Meshes
        are not read. A xacro source is expanded if it is named .xacro or `xacro` asks for it (nao-kin[xacro]).

        Args:
            path: the URDF file, or its xacro source.
            base: "fixed", or "floating" for a free base.
            semantics: what the URDF lacks: a `Semantics`, or the path of a TOML file (as
                `nk.semantics.read_semantics` takes it) or of an SRDF. None for the .toml or .srdf file of the same name
                beside the URDF, or for the SRDF in its package's folder srdf that fits the robot; `load_notes` says
                which was found.
            package_dirs: ROS packages, or folders of packages, for `package://` and `$(find …)`; they are searched
                before the folders above the file, ROS_PACKAGE_PATH and AMENT_PREFIX_PATH.
            xacro: whether to expand the file as a xacro source, which runs the code of its author; None to expand only
                files named .xacro.
            xacro_arguments: values of the arguments of a xacro source, by name.

        Raises:
            BadModel: the file cannot be read or describes no tree of revolute, continuous, prismatic and fixed joints;
                a xacro source cannot or must not be expanded; or the semantics name missing parts.
            BadInputFile: the TOML file cannot be read.
            BadArgument: a folder that does not exist, or arguments for a file that is not expanded.

        Examples:
            >>> robot = nk.RobotModel.from_urdf(nk.load_nao().urdf_path, base="floating")
            >>> robot.nq, robot.nv
            (32, 31)
        """
        tree = read_urdf(path, package_dirs=package_dirs, xacro=xacro, xacro_arguments=xacro_arguments)
        return _loaded(tree, semantics, None, base)

    @classmethod
    def from_mjcf(
        cls,
        path: Path | str,
        *,
        base: Base = "fixed",
        semantics: Semantics | Path | str | None = None,
        package_dirs: Iterable[Path | str] = (),
    ) -> RobotModel:
        """Return a robot from an MJCF, MuJoCo's own format, compiled by MuJoCo (nao-kin[mujoco]).

        Bodies become links; hinges and slides become joints, with MuJoCo's values; a ball joint becomes three joints
        about x, y and z; linear equality constraints between joints become couplings; sites and cameras become frames;
        named keyframes become postures. `load_notes` lists the parts that a tree of joints cannot express:
        closed loops, bodies that are not part of the robot, nonlinear couplings.

        Args:
            path: the MJCF file.
            base: "fixed", or "floating" for a free base; a free joint of the file is the joint of the base.
            semantics: as for `from_urdf`; a TOML or SRDF file takes precedence over the MJCF part by part, a
                `Semantics` replaces all parts.
            package_dirs: folders to search for meshes that are not where the file says.

        Raises:
            MissingExtra: MuJoCo is not installed.
            BadModel: the file cannot be read, is no MJCF, is refused by MuJoCo, or has no body; or the semantics name
                missing parts.
            BadInputFile: the TOML file cannot be read.
            BadArgument: a folder that does not exist.

        Examples:
            >>> panda = nk.RobotModel.from_mjcf("panda.xml")  # doctest: +SKIP
            >>> panda.fk(panda.posture("home"), "hand")  # doctest: +SKIP
        """
        tree, own = read_mjcf(path, package_dirs=package_dirs)
        return _loaded(tree, semantics, own, base)

    # --- properties -----------------------------------------------------------------------------------------------

    def with_offsets(
        self: _Robot,
        joints: Mapping[str, ArrayLike] | None = None,
        frames: Mapping[str, ArrayLike] | None = None,
        *,
        added_frames: Mapping[str, tuple[str, ArrayLike]] | None = None,
        cameras: Mapping[str, ArrayLike] | None = None,
        sensors: Mapping[str, ArrayLike] | None = None,
        version: str | None = None,
        body_id: str | None = None,
        found_for: str | None = None,
    ) -> _Robot:
        """Return the same robot with calibrated joints and frames, and with measured lenses and sensors.

        The offsets are in the tree of the new robot, and so in its Pinocchio model, batch kernels, inverse kinematics
        and exports. Closed forms whose geometry no longer holds are refused with the reason; `nk.ik.numeric` takes any
        robot. New offsets add to the offsets that this robot already has. Changes in `model` are not copied.

        Args:
            joints: name → offset δ [rad; m for a sliding joint]. True value = reported value + δ, where q holds the
                reported value: `new.fk(q) == old.fk(q + δ)`. A joint that follows one of these, and is not named, has
                its share: an offset of LHipYawPitch turns both legs, as their one motor does, unless RHipYawPitch has
                an offset of its own. The limits of the reported values do not change.
            frames: name of a frame that is fixed to a link, such as a camera or hand → its true pose in the old frame,
                `T_link_new = T_link_old @ T_old_new`: a matrix, shape (4, 4), or (dx, dy, dz, roll, pitch, yaw),
                R = Rz(yaw) Ry(pitch) Rx(roll), in the axes of the old frame [m, rad]. Frames fixed to it move with it.
                The offset of a camera's optical frame is in the axes of that frame, and moves the whole camera.
            added_frames: name of a new frame → its parent and its pose there, as for `with_frame`; they come before the
                offsets.
            cameras: camera → its measured lens: width and height of its images, fx, fy, cx, cy, and coefficients of the
                distortion, 0, 4, 5 or 8 [pixel]. `nk.world.camera` returns the camera with this lens.
            sensors: errors of the inertial unit and of force sensors, as `Semantics.sensors` has them, which
                `nk.world.state` and `odometry` correct.
            version: version of the NAO that this was measured on; for another robot it is refused.
            body_id: the body's serial number, for the notes.
            found_for: name of the robot that the offsets were found for, as files of `nk.calibration` say it. If this
                robot has another name, a warning says so; it may be the same robot with your own URDF.

        Raises:
            BadArgument: another version, a frame that a joint moves, a value that is not a pose, an angle of more than
                half a turn. A
                warning names offsets of more than 0.2 rad or 0.1 m, which no calibration finds.

        Examples:
            >>> nao = nk.load_nao()
            >>> mine = nao.with_offsets(joints={"HeadYaw": 0.01}, frames={"CameraTop": (0, 0, 0.002, 0, 0.02, 0)})
            >>> q = nao.configuration({"HeadYaw": 0.3})
            >>> np.allclose(mine.fk(q, "Head"), nao.fk(nao.configuration({"HeadYaw": 0.31}), "Head"))
            True
        """
        semantics, joints, cameras, sensors = self.semantics, dict(joints or {}), cameras or {}, sensors or {}
        if version not in (None, semantics.version):
            raise BadArgument(f"this was measured on a NAO {version}, and this robot is {self.name}")
        if found_for is not None and found_for != self.name:
            warn_caller(f"these offsets were found for {found_for}, and this robot is {self.name}", OtherRobotWarning)
        shared = {
            name: np.multiply(mimic.multiplier, joints[mimic.joint])
            for name, mimic in self.mimics.items()
            if mimic.joint in joints and name not in joints
        }
        added = added_frames or {}
        tree = with_offsets(with_frames(self.tree, added), joints | shared, frames or {}, semantics.cameras)
        notes = [*self.load_notes, *tree.notes[len(self.tree.notes) :]]
        if shared:
            notes.append(f"{', '.join(shared)}: the offset of the motor that moves them, too")
        for name in cameras:
            choice(name, semantics.cameras, f"camera of {self.name}")
            notes.append(f"camera {name}: a measured lens")
        for name, values in sensors.items():
            choice(name, (*INERTIAL_UNIT, *semantics.force_sensors), f"sensor of {self.name}")
            notes.append(f"{name}: {', '.join(f'{value:g}' for value in np.ravel(values).tolist())}")
        notes += [f"body {body_id}"] if body_id else []
        own: dict[str, Any] = {"lenses": {**semantics.lenses, **cameras}, "sensors": {**semantics.sensors, **sensors}}
        own["end_effectors"] = (*semantics.end_effectors, *added)
        own = {"tree": tree, "semantics": replace(semantics, **own), "load_notes": tuple(notes), "numbers": None}
        robot = type(self).__new__(type(self))
        robot.__setstate__({**self.__getstate__(), **own})
        return robot

    def with_frame(self: _Robot, name: str, parent: str, T: ArrayLike) -> _Robot:
        """Return the same robot with one more frame, such as the tip of a tool in its hand.

        The frame is a link without mass and shapes that is fixed to the link of its parent, and an end effector of the
        new robot's semantics. It is in the new robot's tree, and so in `fk`, Jacobians, inverse kinematics (closed
        forms of the limb that carries it, too), exports and viewers. `with_offsets` also takes such frames, and so
        does the file of one robot. Changes in `model` are not copied.

        Args:
            name: name of the new frame, which no link and no joint has.
            parent: the frame that carries it.
            T: T_parent_frame, its pose in the parent, shape (4, 4), or (x, y, z, roll, pitch, yaw) [m, rad].

        Raises:
            BadArgument: a name in use, or a pose that is not rigid.
            UnknownName: a parent that does not exist.

        Examples:
            >>> nao = nk.load_nao().with_frame("Pen", "LArm", (0.08, 0.0, 0.02, 0.0, 0.0, 0.0))
            >>> target = nao.fk(nao.posture("StandInit"), "Pen")
            >>> bool(np.allclose(nao.fk(nk.ik.arm(nao, "L", target, frame="Pen").q, "Pen"), target, atol=1e-9))
            True
        """
        return self.with_offsets(added_frames={name: (parent, T)})

    def body_frame(self, frame: str) -> str:
        """Return the body frame of the camera that has this frame beside it, as its optical frame; else the frame.

        Examples:
            >>> nao = nk.load_nao()
            >>> nao.body_frame("CameraTop"), nao.body_frame("LArm")
            ('CameraTop', 'LArm')
        """
        found = camera_of(self.tree, self.semantics.cameras, frame)
        return frame if found is None else found[0]

    def pose_in_optical_frame(self, frame: str) -> Floats | None:
        """Return the pose (4, 4) of a camera's body frame in its optical frame; None if this is no optical frame.

        An optical frame is that of a camera of the semantics, or has a name that ends in "_optical" or
        "_optical_frame", as in ROS (REP 103).

        Examples:
            >>> nao = nk.load_nao()
            >>> nao.pose_in_optical_frame("CameraTop") is None
            True
        """
        return pose_of_body(self.tree, self.semantics.cameras, frame)

    def geometry(self, kind: GeometryKind) -> pin.GeometryModel:
        """Return the shapes of the links as a new Pinocchio `GeometryModel`, placed on the joints of `model`.

        Pinocchio's visualizers draw it, and its collision library coal computes distances and collisions with it, after
        `addAllCollisionPairs` or `addCollisionPair`: it has no collision pairs yet.

        Args:
            kind: "visual" for the displayed shapes of the links, "collision" for their simplified shapes in contacts.

        Returns:
            One object per shape, named as Pinocchio's own parser names it: the link, "_", and its number from 0. A
            capsule is three shapes, a cylinder and two spheres.

        Warns:
            MissingShapeWarning: some shapes are left out, because their meshes are missing or they cannot be read.

        Examples:
            >>> nao = nk.load_nao()
            >>> nao.geometry("collision").ngeoms
            72
        """
        return geometry_model(self.model, self._frames, self.tree, kind)

    def random(
        self,
        rng: np.random.Generator | int | None = None,
        n: int | tuple[int, ...] | None = None,
        *,
        collision_free: bool | CollisionRule = False,
    ) -> Floats:
        """Return configurations inside all limits, coupled ones included, each joint uniform in its range.

        Joints without limits are uniform in [−π, π]; a floating base is at the world's origin.

        Args:
            rng: a generator, or a seed for one.
            n: how many, or a batch shape; None for one configuration of shape (nq,).
            collision_free: draw configurations again if links overlap, as `clearance` finds: True, or a
                `nk.robot.CollisionRule`.

        Returns:
            Configurations, shape (n…, nq).

        Examples:
            >>> nao = nk.load_nao()
            >>> q = nao.random(rng=0, n=(2, 3))
            >>> q.shape, bool(nao.within_limits(q).all())
            ((2, 3, 25), True)
        """
        rule = CollisionRule.of(collision_free, "collision_free")
        if rule is not None:
            return self.link_shapes.random_free(rule, rng, n)
        return super().random(rng, n)

    def mirror(self, q: ArrayLike) -> Floats:
        """Return configurations mirrored at the plane between left and right, y = 0, which may be outside the limits.

        The mirror image of a point p is M p, with M = diag(1, −1, 1). The image of a joint that turns about the axis a
        turns about −M a: its value changes its sign if the joint on the other side has the opposite axis. A floating
        base at the position p with the rotation R goes to M p and M R M. `nk.motion.mirror` does the same with motions.

        Args:
            q: configurations, shape (..., nq).

        Returns:
            Shape (..., nq).

        Raises:
            UnknownName: a joint has no other side.
            BadArgument: the joint on the other side is not its mirror image, or a mimic joint does not follow as that.

        Examples:
            >>> nao = nk.load_nao()
            >>> q = nao.mirror(nao.configuration({"LShoulderRoll": 0.5, "HeadYaw": 0.2}, limits="ignore"))
            >>> nao.angles(q)["RShoulderRoll"], nao.angles(q)["HeadYaw"]
            (-0.5, -0.2)
        """
        return mirrored(self, self.checked(q))

    def mirror_image(self, joint: str) -> Mimic:
        """Return how a joint of the mirror image follows the joint on the other side: with the multiplier 1 or −1.

        Raises:
            UnknownName: the joint has no other side.
            BadArgument: the joint on the other side is not its mirror image, or a mimic joint does not follow as that.

        Examples:
            >>> nk.load_nao().mirror_image("LShoulderRoll")
            Mimic(joint='RShoulderRoll', multiplier=-1.0, offset=0.0)
        """
        return mirror_image(self, joint)

    def support_polygon(
        self, q: ArrayLike, soles: Sequence[str] | None = None, *, reference: str | None = None
    ) -> SupportPolygon:
        """Return the convex hull of the soles on the floor, seen along the z axis of a frame on the floor.

        Args:
            q: one configuration, shape (nq,).
            soles: frames of the soles on the floor; None for all soles of the robot's semantics.
            reference: frame whose xy plane contains the polygon; None for the first of the soles.

        Returns:
            The polygon, with vertices in the xy plane of the reference [m]; its `signed_distance` takes points in that
            frame, such as the centre of mass.

        Raises:
            BadArgument: no soles; a sole without outline; soles without area.

        Examples:
            >>> nao = nk.load_nao()
            >>> q = nao.posture("StandInit")
            >>> polygon = nao.support_polygon(q)
            >>> T_sole_torso = np.linalg.inv(nao.fk(q, nao.semantics.soles[0]))
            >>> com = T_sole_torso[:3, :3] @ nao.com(q) + T_sole_torso[:3, 3]
            >>> bool(polygon.signed_distance(com) > 0.02)
            True
        """
        return support_polygon(self, q, soles, reference)

    def sole_outline(self, sole: str, kind: OutlineKind = "sole") -> Floats:
        """Return the corners of a sole in its own frame, counter-clockwise, shape (k, 3) [m].

        "sole" is the area that touches the floor: the outline in the semantics; without one, the hull of the frames on
        the foot in the plane of the sole; without three of these, the hull of its visual shapes within 2 mm of their
        lowest point, at the height of that point. "sensors" is the hull of the frames on the foot in the plane of the
        sole, which `support_polygon` and the whole-body poses take: on a NAO the four force sensors, 100 mm long, 53 mm
        wide in front and 49 mm behind, inside the sole of 142 × 81 mm.

        Raises:
            BadArgument: the sole has no outline.

        Examples:
            >>> nao = nk.load_nao()
            >>> outline = nao.sole_outline("LLeg")
            >>> np.ptp(outline, axis=0).round(3).tolist()
            [0.142, 0.081, 0.0]
        """
        return sole_outline(self, sole, kind)

    def set_down(
        self,
        q: ArrayLike,
        *,
        soles: Sequence[str] | str | None = None,
        contacts: ArrayLike | None = None,
        forces: ArrayLike | None = None,
        gravity: ArrayLike | None = None,
        tolerance: float = TOUCHING,
    ) -> SetDown:
        """Set the robot down on the floor z = 0 as a rigid body; return its pose and the parts that touch the floor.

        With `gravity`, the vertical is known. With `soles`, the lowest of their corners is on the floor, wherever other
        links are; without `gravity`, the mean of the soles' normals is then vertical. `contacts` or `forces` do the
        same for each configuration, and all corners of the soles that carry touch the floor; a row in which none
        carries is set down as without them. With none of these arguments:

        1. The robot is put down on all soles, or on one of them, and turns over its edges until its centre of mass is
           above the corners on the floor. It stands if no other link is lower by more than 1 mm, and if it turns by at
           most 5° from a sole that the centre of mass is above, or by at most 1.5° onto another foot.
        2. Otherwise the nearest posture of the semantics is considered. If that posture rests on other links, the robot
           is put down with the vertical of the posture, and rolls over its edges until its centre of mass is above the
           area that touches the floor.
        3. In all other cases the robot stands on the soles from which it falls, with the mean of their normals
           vertical, or, if other links are then lower, its root is upright.

        Links other than the feet stay above the floor, so the soles of a robot that sits may be in the air. A robot
        that does not stand has the lowest point of its shapes and soles on the floor.

        Args:
            q: configurations, shape (..., nq). The pose of a floating base in them is not used.
            soles: frames of the soles on the floor; None for those of the robot's semantics.
            contacts: whether each of the s soles touches the floor, shape (..., s).
            forces: force on each sole, shape (..., s), or on each of the `force_sensors` of the semantics, shape
                (..., f), of any unit; a sole carries with at least 10 % of the total.
            gravity: direction of gravity in the frame of the root link, shape (..., 3), of any length but zero: the
                measurement of an accelerometer at rest with opposite sign. Broadcasts with q.
            tolerance: height up to which a point touches the floor [m].

        Returns:
            The pose T_world_base of the root link and the soles, corners and links that touch.

        Raises:
            BadArgument: the robot has neither soles nor shapes, or the soles face opposite directions.
            ZeroNorm: zero gravity.

        Examples:
            >>> nao = nk.load_nao()
            >>> down = nao.set_down(nao.posture("StandInit"))
            >>> down.touching.tolist(), down.T_world_base[:3, 3].round(3).tolist()
            ([True, True], [0.0, 0.0, 0.32])
        """
        return set_down(self, q, soles=soles, contacts=contacts, forces=forces, gravity=gravity, tolerance=tolerance)

    # --- self-collision -------------------------------------------------------------------------------------------

    @cached_property
    def link_shapes(self) -> LinkShapes:
        """The shapes of the links for self-collision, and the pairs that are checked; prepared on first use."""
        return LinkShapes(self, list(self._collision_shapes()), self._exact_shapes())

    def _collision_shapes(self) -> Iterable[Shape]:
        """Return the shapes of `link_shapes`: those of the collision elements, or of the visuals if there are none."""
        return shapes_of(self.tree)

    def _exact_shapes(self) -> tuple[Visual, ...] | tuple[Collision, ...]:
        """Return the shapes that the hulls of `link_shapes` contain."""
        return self.tree.collisions or self.tree.visuals

    def clearance(
        self,
        q: ArrayLike,
        *,
        tolerance: float = 0.0,
        allowed: Sequence[tuple[str, str]] = (),
        exact: bool | None = None,
        obstacles: Sequence[Obstacle] = (),
    ) -> Clearance:
        """Return the smallest distance between links, and the two links that have it.

        The shapes of a NAO are the convex hulls of its meshes. Those of another robot are its collision elements, or
        its visuals if it has none: balls, capsules (a cylinder with a sphere at each end) and the convex hulls of
        boxes, cylinders and meshes. Pairs of links that a joint connects, that always touch or that never touch are
        left out: the pairs in `semantics.disabled_collisions` (of an SRDF) or, if there are none, those found on the
        first call by the rules of `nk.export.srdf`.

        Args:
            q: configurations, shape (..., nq).
            tolerance: overlap that `is_free` accepts [m].
            allowed: pairs of links that may overlap, and are not checked.
            exact: whether coal compares the meshes where hulls overlap: None for where they overlap by less than 3 mm,
                True for everywhere, False for nowhere.
            obstacles: objects near the robot, made by `nk.robot.Obstacle`; each is compared with all links.

        Returns:
            Distances, shape (...) [m]. Where links overlap, the distance is negative: minus the length of the least
            translation that separates them.

        Raises:
            BadArgument: the robot has no shapes.

        Warns:
            MissingShapeWarning: some shapes are left out, because their meshes are missing or they cannot be read.

        Examples:
            >>> nao = nk.load_nao()
            >>> found = nao.clearance(nao.posture("StandInit", LShoulderRoll=-0.3, LElbowRoll=-1.2))
            >>> found.distance.round(4).tolist(), found.pair
            (-0.0026, ('LForeArm', 'torso'))
            >>> nao.clearance(nao.random(rng=0, n=1000)).is_free.sum().tolist()
            678
        """
        rule = CollisionRule(tolerance, allowed, exact, obstacles)
        shapes = self.link_shapes.among(rule.obstacles)
        checked = ~shapes.allowed(rule)
        return shapes.clearance(self.checked(q), tolerance=rule.tolerance, checked=checked, exact=exact)

    def collisions(
        self,
        q: ArrayLike,
        *,
        margin: float = 0.0,
        tolerance: float = 0.0,
        allowed: Sequence[tuple[str, str]] = (),
        exact: bool | None = None,
        obstacles: Sequence[Obstacle] = (),
    ) -> tuple[Contact, ...]:
        """Return the pairs of links that overlap, or are nearer than a margin, with their nearest points.

        Making one object per contact takes time; for many configurations use `clearance`, which also describes the
        shapes and the pairs.

        Args:
            q: configurations, shape (..., nq).
            margin: distance below which links are listed; negative for those that overlap by more [m].
            tolerance: overlap that is accepted, subtracted from `margin` [m].
            allowed: pairs of links that may overlap, and are not listed.
            exact: as in `clearance`.
            obstacles: as in `clearance`.

        Returns:
            The contacts, by configuration and then by distance. Each has the names of its `links`; their `distance`,
            negative if they overlap [m]; the nearest `points` of the two, or the deepest ones, in the root's frame,
            shape (2, 3) [m]; and the `index` of the configuration in the batch. `describe()` says it in words.

        Raises:
            BadArgument: the robot has no shapes.
            NotFinite: the margin is not a finite number.

        Examples:
            >>> nao = nk.load_nao()
            >>> q = nao.configuration({"LShoulderRoll": -0.3, "LElbowRoll": -1.5, "RElbowRoll": 0.04, "LHand": 1.0})
            >>> [contact.links for contact in nao.collisions(q)]
            [('RBicep', 'l_wrist')]
        """
        rule = CollisionRule(tolerance, allowed, exact, obstacles)
        shapes, distance = self.link_shapes.among(rule.obstacles), float(shaped(margin, (), "margin"))
        return shapes.contacts(self.checked(q), distance - rule.tolerance, rule)


def _loaded(tree: UrdfTree, given: Semantics | Path | str | None, implied: Semantics | None, base: Base) -> RobotModel:
    """Return the robot of a tree, with the semantics given or implied by its file, and notes on both."""
    notes: list[str] = []
    # A RobotModel even if the caller used NaoModel: a NaoModel always has the numbers of its version.
    robot = RobotModel(tree, find_semantics(tree, given, notes, implied), base=base)
    for name in robot.posture_names:
        outside = [violation.joint for violation in robot.limit_violations(robot.posture(name))]
        if outside:
            notes.append(f"posture {quoted(name)} is outside the limits of {abbreviated(', '.join(outside))}")
    robot.load_notes = (*tree.notes, *unit_notes(tree), *notes)
    return robot
