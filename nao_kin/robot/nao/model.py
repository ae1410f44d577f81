"""The NAO: its versions, its semantics, and NAOqi's Body order."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import Floats, LimitPolicy, as_floats, choice
from nao_kin._core.files import URDF_FOLDERS
from nao_kin._core.sides import Hips
from nao_kin.errors import BadModel
from nao_kin.robot.build import Base
from nao_kin.robot.geometry import Shape, hulls_in
from nao_kin.robot.model import RobotModel
from nao_kin.robot.nao import tables
from nao_kin.robot.nao.parameters import NaoParameters, nao_parameters, ros_names, version_named
from nao_kin.robot.nao.rows import VERSIONS, Version
from nao_kin.robot.offsets import read_offsets
from nao_kin.robot.semantics import Posture, Semantics, View
from nao_kin.robot.urdf import UrdfTree, Visual, read_urdf

# The file of the convex hulls of the meshes of all versions, beside the URDFs.
HULLS = "collision_hulls.obj"


class NaoModel(RobotModel):
    """A NAO H25 with its 25 degrees of freedom.

    In addition to the attributes of `RobotModel`:

    Attributes:
        version: one of `nk.parameters.VERSIONS`.
        body_order: NAOqi's 26 joint names in the order of "Body".

    Examples:
        >>> nao = nk.NaoModel("v5")
        >>> nao.version, nao.nv, nao.body_order[-1]
        ('v5', 25, 'RHand')
    """

    body_order: tuple[str, ...] = tables.BODY_ORDER

    def __init__(self, version: str = "v6", *, base: Base = "fixed") -> None:
        self.version: Version = version_named(version)
        super().__init__(_tree(self.version), _semantics(self.version), base=base)

    @property
    def parameters(self) -> NaoParameters:
        """The numbers of this version, each with its unit and its source."""
        return nao_parameters(self.version)

    def _collision_shapes(self) -> Iterable[Shape]:
        """Return the convex hulls of the meshes; the URDF has simple shapes around these hulls, for simulators."""
        return hulls_in(nao_urdf_path(self.version).with_name(HULLS).read_text(encoding="utf-8"), self.version)

    def _exact_shapes(self) -> tuple[Visual, ...]:
        """Return the visual shapes, which are the meshes."""
        return self.tree.visuals

    def to_body(self, q: ArrayLike) -> Floats:
        """Return joint values in NAOqi's Body order; RHipYawPitch repeats LHipYawPitch.

        Args:
            q: configurations, shape (..., nq).

        Returns:
            Shape (..., 26).

        Examples:
            >>> nao = nk.load_nao()
            >>> body = nao.to_body(nao.posture("Stand"))
            >>> body.shape, dict(zip(nao.body_order, body.round(3).tolist()))["RHipYawPitch"]
            ((26,), -0.17)
        """
        joints = self.joints  # each time it is asked for, the robot looks whether its joints have changed
        return joints.values(self.checked(q))[..., [joints.row(name) for name in tables.BODY_ORDER]]

    def from_body(
        self,
        body: ArrayLike,
        *,
        limits: LimitPolicy = "ignore",
        hips: Hips | None = None,
        missing: str | float | None = None,
    ) -> Floats:
        """Return the configuration with the given values in NAOqi's Body order.

        Args:
            body: shape (..., 26) [rad; 0 to 1 for the hands].
            limits: what to do with joints outside their limits, as in `configuration`.
            hips: value of both HipYawPitch if they differ, as in `configuration`.
            missing: values of joints that are NaN, as in `configuration`.

        Returns:
            q, shape (..., nq).

        Raises:
            CouplingViolated: the two HipYawPitch values differ by more than 1e-6, and `hips` is None; carries the index of the
                configuration.
            OutsideLimits: with limits="enforce", a joint is outside its limits.

        Examples:
            >>> nao = nk.load_nao()
            >>> q = nao.posture("Stand")
            >>> np.array_equal(nao.from_body(nao.to_body(q)), q)
            True
        """
        values = as_floats(body, (len(tables.BODY_ORDER),), "Body values", gaps=True)
        by_name = dict(zip(tables.BODY_ORDER, np.moveaxis(values, -1, 0), strict=True))
        return self.configuration(by_name, limits=limits, hips=hips, missing=missing)

    def __getstate__(self) -> dict[str, Any]:
        return {**super().__getstate__(), "version": self.version}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.version = state["version"]
        super().__setstate__(state)


def load_nao(
    version: str | None = None, *, base: Base = "fixed", offsets: Mapping[str, Any] | Path | str | None = None
) -> NaoModel:
    """Return a NAO H25 as a Pinocchio model with exactly 25 degrees of freedom.

    Args:
        version: one of `nk.parameters.VERSIONS`: "v3.2" to "v6"; None is that of `offsets`, or "v6".
        base: "fixed" holds the trunk at the origin; "floating" adds a free-flyer before the joints.
        offsets: what was measured of one robot: `{"joints": {…}, "frames": {…}, "cameras": {…}, …}` as for
            `nk.robot.read_offsets`, or the path of a file that it reads.

    Raises:
        BadArgument: invalid offsets, or those of another version, as in `RobotModel.with_offsets`.
        BadInputFile: the file of offsets cannot be read.

    Examples:
        >>> nao = nk.load_nao("v6")
        >>> nao.model.nv, nao.joint_names[:2]
        (25, ('HeadYaw', 'HeadPitch'))
    """
    measured = {} if offsets is None else read_offsets(offsets)
    nao = NaoModel(version or measured.get("version", "v6"), base=base)
    return nao.with_offsets(**measured) if measured else nao


def nao_urdf_path(version: str) -> Path:
    """Return the URDF file of one NAO version; raise `BadModel` if the installation lacks it."""
    name = urdf_name(version)
    for folder in URDF_FOLDERS:
        if (folder / name).is_file():
            return folder / name
    raise BadModel(f"no urdf folder with {name} in {URDF_FOLDERS[0].parent} or beside it; reinstall nao-kin")


def urdf_name(version: str) -> str:
    """Return the file name of the URDF of one version: "v3.2" → "nao_v32.urdf"."""
    return f"nao_{choice(version, VERSIONS, 'NAO version').replace('.', '')}.urdf"


@functools.cache
def _tree(version: Version) -> UrdfTree:
    """Return the URDF of a version, read once per process: the files of the package do not change."""
    return read_urdf(nao_urdf_path(version))


@functools.cache
def _semantics(version: Version) -> Semantics:
    """Return the semantics of a version."""
    parameters = nao_parameters(version)
    return Semantics(
        chains=tables.CHAINS,
        end_effectors=("Head", "LArm", "RArm", "LLeg", "RLeg"),
        soles=("LLeg", "RLeg"),
        cameras=tables.CAMERAS,
        fields_of_view={
            row.camera: (math.radians(row.field_of_view_deg[0]), math.radians(row.field_of_view_deg[1]))
            for row in parameters.cameras
        },
        resolutions=parameters.resolutions,
        postures={
            row.name: Posture(dict(zip(tables.BODY_ORDER, row.body, strict=True)), tables.REST.get(row.name))
            for row in tables.POSTURES
        },
        start="StandInit",
        coupled_limits=parameters.coupled_limits,
        units={joint.name: joint.unit for joint in parameters.joints if joint.unit == "1"},
        stall_torques=tables.STALL_TORQUES,
        views={
            "hands": View((1.0, 0.25, 0.55), ("LWristYaw", "RWristYaw")),
            "feet": View((1.0, 0.45, 0.42), ("LAnklePitch", "RAnklePitch")),
        },
        version=version,
        root="torso",
        accelerometers=("Accelerometer",),
        gyrometers=("Gyrometer",),
        force_sensors=tuple(frame.name for frame in parameters.frames if "/FSR/" in frame.name),
        ros_names=ros_names(parameters),
        outlines={row.sole: row.corners_m for row in tables.SOLE_OUTLINES},
        disabled_collisions=tables.DISABLED_COLLISIONS,
    )
