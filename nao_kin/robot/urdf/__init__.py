"""Robot description files: URDF and MJCF files read into one tree, with a note for every repair."""

from nao_kin._core.guesses import public_attributes as _public_attributes
from nao_kin.robot.urdf.document import Packages, read_document as read_document
from nao_kin.robot.urdf.mjcf import read_mjcf as read_mjcf
from nao_kin.robot.urdf.reader import file_format as file_format, read_robot, read_urdf as read_urdf
from nao_kin.robot.urdf.tree import (
    TENSOR_LABELS as TENSOR_LABELS,
    Box as Box,
    Collision as Collision,
    Cylinder as Cylinder,
    Geometry as Geometry,
    Inertial as Inertial,
    MeshFile as MeshFile,
    Origin as Origin,
    Rgba as Rgba,
    Sphere as Sphere,
    UnreadableShape,
    UrdfJoint as UrdfJoint,
    UrdfTree,
    Visual as Visual,
    has_quaternions as has_quaternions,
)

__all__ = ["Packages", "UnreadableShape", "UrdfTree", "read_robot"]

globals().update(_public_attributes(__name__))
