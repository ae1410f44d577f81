"""Robot models: any URDF as a Pinocchio model that answers kinematic questions."""

from nao_kin.robot.answers import CROSSOVER as CROSSOVER
from nao_kin.robot.build import LIMIT_ARRAYS as LIMIT_ARRAYS, Base as Base, ModelNumbers as ModelNumbers
from nao_kin.robot.camera_frames import (
    body_frame_of as body_frame_of,
    camera_of as camera_of,
    pose_of_body as pose_of_body,
)
from nao_kin.robot.chains import (
    SerialChain as SerialChain,
    Topology,
    joint_rows as joint_rows,
    joints_below as joints_below,
    serial_chain as serial_chain,
    topology,
)
from nao_kin.robot.collision_pairs import LinkPair as LinkPair, disabled_collisions as disabled_collisions
from nao_kin.robot.collisions import Clearance, Contact as Contact, LinkShapes as LinkShapes
from nao_kin.robot.configurations import COUPLING_TOLERANCE as COUPLING_TOLERANCE, UNIT_TOLERANCE as UNIT_TOLERANCE
from nao_kin.robot.geometry import (
    GeometryKind as GeometryKind,
    capsules as capsules,
    mesh_path as mesh_path,
    read_mesh as read_mesh,
    shape_geometry as shape_geometry,
)
from nao_kin.robot.ground import (
    TOUCHING as TOUCHING,
    Feet as Feet,
    OutlineKind as OutlineKind,
    SetDown,
    common_down as common_down,
    level_axes as level_axes,
    points_on_floor as points_on_floor,
    rows_with_gravity as rows_with_gravity,
)
from nao_kin.robot.kinematics import (
    WORLD as WORLD,
    Expression as Expression,
    FrameIds as FrameIds,
    Kinematics as Kinematics,
    PoseForm as PoseForm,
    expression_named as expression_named,
)
from nao_kin.robot.library import load_robot, robot_names
from nao_kin.robot.limits import LIMIT_TOLERANCE as LIMIT_TOLERANCE, LimitPolicy as LimitPolicy, LimitViolation
from nao_kin.robot.model import RobotModel, check_robot as check_robot
from nao_kin.robot.motors import (
    Hips as Hips,
    check_hips as check_hips,
    joint_bounds as joint_bounds,
    joints_by_motor as joints_by_motor,
    joints_of_side as joints_of_side,
    motor_values as motor_values,
    other_side as other_side,
    with_shared_motors as with_shared_motors,
)
from nao_kin.robot.nao.model import NaoModel, load_nao, nao_urdf_path as nao_urdf_path
from nao_kin.robot.offsets import (
    pose_of as pose_of,
    read_offsets as read_offsets,
    refuse_not_rigid as refuse_not_rigid,
    refuse_not_rotation as refuse_not_rotation,
    refuse_other_last_row as refuse_other_last_row,
    rigid_poses as rigid_poses,
    write_offsets as write_offsets,
)
from nao_kin.robot.support_polygon import (
    SupportPolygon,
    named_soles as named_soles,
    polygon_below as polygon_below,
    sole_corners as sole_corners,
)

__all__ = [
    "Clearance",
    "LimitViolation",
    "NaoModel",
    "RobotModel",
    "SetDown",
    "SupportPolygon",
    "Topology",
    "load_nao",
    "load_robot",
    "robot_names",
    "topology",
]
