"""What ros-naoqi's `nao_description` calls the links and joints that this package names otherwise.

That description has no V6; its names follow the same rules there.
"""

from __future__ import annotations

from nao_kin.parameters.frames import CAMERAS
from nao_kin.parameters.robot_parameters import NaoParameters, checked_parameters

# Bodies that have a second name here.
_BODIES = {"Torso": "torso", "LFoot": "l_ankle", "RFoot": "r_ankle"}
_JOINTS = {
    "torso_fixed": "base_link_fixedjoint",
    "Gaze_fixed": "gaze_joint",
    "LLeg_fixed": "LLeg_effector_fixedjoint",
    "RLeg_fixed": "RLeg_effector_fixedjoint",
    "MicroFrontCenter_fixed": "MicroFront_sensor_fixedjoint",
    "MicroRearCenter_fixed": "MicroRear_sensor_fixedjoint",
    "MicroSurroundLeft_fixed": "MicroLeft_sensor_fixedjoint",
    "MicroSurroundRight_fixed": "MicroRight_sensor_fixedjoint",
}
# There, the link that the hand joint turns is the gripper; here, the gripper is NAOqi's effector, which does not turn.
_HANDS = {"LHand_link": "l_gripper", "l_gripper": "LArm", "RHand_link": "r_gripper", "r_gripper": "RArm"}
_ANKLES = {"LAnklePitch_link": "LAnklePitch", "RAnklePitch_link": "RAnklePitch"}


def ros_names(parameters: NaoParameters) -> dict[str, str]:
    """Name in the URDF of this package → name in `nao_description`, of the robot, its links and its joints.

    Two links of one name there are one link there: here the second one is NAOqi's name for the same place.

    Args:
        parameters: the numbers of a version.

    Examples:
        >>> names = nk.parameters.ros_names(nk.parameters.nao_parameters("v6"))
        >>> names["CameraTop"], names["CameraTop_fixed"], names["LHandThumb1"]
        ('CameraTop_frame', 'CameraTop_sensor_fixedjoint', 'LThumb1')
    """
    digits = f"{checked_parameters(parameters).version.removeprefix('v').replace('.', '')}0"[:2]
    names = {f"nao_{parameters.version}": f"NaoH25V{digits}"} | _BODIES | _ANKLES
    for frame in parameters.frames:
        if frame.ros_name is not None:
            names |= {frame.name: frame.ros_name, f"{frame.name}_fixed": f"{frame.name}_sensor_fixedjoint"}
    for camera in CAMERAS:
        names[f"{camera}_optical_frame_fixed"] = f"{camera}_optical_frame_fixedjoint"
    for finger in parameters.fingers:
        names[finger.name] = finger.name.replace("Hand", "", 1)
    del names["LArm"], names["RArm"], names["LArm_fixed"], names["RArm_fixed"]
    return names | _HANDS | _JOINTS
