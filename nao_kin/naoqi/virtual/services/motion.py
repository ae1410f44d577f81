"""ALMotion, put together from its topics."""

from __future__ import annotations

from nao_kin.naoqi.virtual.services.cartesian_control import CartesianControl
from nao_kin.naoqi.virtual.services.general_tools import GeneralTools
from nao_kin.naoqi.virtual.services.joint_control import JointControl
from nao_kin.naoqi.virtual.services.locomotion import Locomotion
from nao_kin.naoqi.virtual.services.stiffness_control import StiffnessControl
from nao_kin.naoqi.virtual.services.whole_body_control import WholeBodyControl

# Methods of ALMotion in NAOqi 1.14 to 2.8; what no topic offers is answered with a list of what there is.
_NAOQI = """
    changePosition changeTransform getChainClosestObstaclePosition getFootGaitConfig getFootSteps getMoveArmsEnabled
    getMoveConfig getNextRobotPosition getPosition getRobotPosition getRobotVelocity getTaskLog getTransform
    getWalkArmsEnable getWalkArmsEnabled killMove killWalk move moveInit moveIsActive moveTo moveToward
    positionInterpolation positionInterpolations setEnableNotifications setFootSteps setFootStepsWithSpeed
    setFootTrajectory setMoveArmsEnabled setPosition setPositions setTransform setTransforms setWalkArmsEnable
    setWalkArmsEnabled setWalkTargetVelocity stopAll stopMove stopTasksUsingResources stopWalk transformInterpolation
    transformInterpolations updateTrackerTarget waitUntilMoveIsFinished waitUntilWalkIsFinished walkInit walkIsActive
    walkTo wbEnable wbEnableBalanceConstraint wbEnableEffectorControl wbEnableEffectorOptimization wbFootState
    wbGoToBalance wbSetEffectorControl
""".split()


class ALMotion(JointControl, StiffnessControl, CartesianControl, Locomotion, WholeBodyControl, GeneralTools):
    """Everything that moves: joints, stiffness, effectors, tasks."""

    name = "ALMotion"
    absent = tuple(_NAOQI)
