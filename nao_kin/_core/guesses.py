"""What is meant by an attribute that does not exist: guessed and former names, and the nearest valid ones."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from nao_kin._core.text import nearest_names

# Class or module → a name that people try, or a former name that no longer warns → expressions that give what it
# promises. In these, `robot`, `motion` and `viewer` are objects of the classes.
_LIMITS = "robot.lower, robot.upper"
_CLOSED = "nk.ik.leg, nk.ik.legs, nk.ik.arm, nk.ik.head, nk.ik.numeric"
GUESSES: dict[str, dict[str, str]] = {
    "RobotModel": {
        "collides": "robot.collisions, robot.clearance",
        "copy": "copy.copy",
        "dof": "robot.nv, robot.nq",
        "effectors": "robot.semantics.end_effectors",
        "frames": "robot.frame_names",
        "ik": _CLOSED,
        "in_collision": "robot.collisions, robot.clearance",
        "interpolate": "nk.Motion",
        "is_stable": "nk.world.balance",
        "joint_limits": _LIMITS,
        "limits": _LIMITS,
        "link_lengths": "robot.parameters, robot.frame_placement",
        "lower_limits": "robot.lower",
        "names": "robot.joint_names, robot.frame_names, robot.link_names",
        "pose": "robot.fk",
        "postures": "robot.posture_names, robot.posture",
        "self_collision": "robot.collisions, robot.clearance",
        "show": "nk.Viewer",
        "to_urdf": "nk.export.urdf",
        "torques": "robot.model",
        "transform": "robot.fk",
        "upper_limits": "robot.upper",
        "zero": "robot.neutral",
    },
    "Motion": {
        "at": "motion.sample, motion.configurations",
        "from_csv": "nk.motion.read_motion",
        "mirror": "nk.motion.mirror",
        "play": "nk.Viewer.animate",
        "q": "motion.configurations, motion.sample",
        "read": "nk.motion.read_motion",
        "resample": "nk.motion.resample",
        "reverse": "nk.motion.reverse",
        "save": "nk.motion.write_motion",
        "times": "motion.key_times",
        "to_csv": "nk.motion.write_motion",
        "write": "nk.motion.write_motion",
    },
    "Viewer": {
        "play": "viewer.animate",
        "save": "viewer.save_html, viewer.save_png",
        "show_ghost": "viewer.show_ghosts",
    },
    "nao_kin": {
        "deg2rad": "np.radians",
        "invert": "np.linalg.inv",
        "joint_axes": "nk.joints",
        "load_motion": "nk.motion.read_motion",
        "load_urdf": "nk.RobotModel.from_urdf",
        "multidof": "nk.joints.MultiDofModel",
        "plot": "nk.motion.plot",
        "rank_one": "nk.rotations.rank_one",
        "read_csv": "nk.stream.read_configurations, nk.stream.read_log",
        "read_motion": "nk.motion.read_motion",
        "topology": "nk.robot.topology",
        "transforms": "nk.rotations, nk.screws",
    },
    "nao_kin.crosscheck": {
        **dict.fromkeys(("Place", "Row", "Step"), "nk.crosscheck.Report"),
        "steps_of": "nk.crosscheck.steps_of_nao",
    },
    "nao_kin.ik": {
        **dict.fromkeys(("FollowedLimb", "Jump", "Stretch"), "nk.ik.FollowedPath"),
        "solve": _CLOSED,
    },
    "nao_kin.joints": {
        "AnatomicalJoint": "nk.joints.NAO_ANATOMY",
        "AnatomyTable": "nk.joints.NAO_ANATOMY",
        "BodyPart": "nk.joints.ANATOMY",
        "Coupling": "nk.semantics.Mimic",
        "CouplingViolation": "nk.joints.MultiDofModel.violations",
        "JointRow": "nk.joints.JointTableRow",
        "LOWER_PAIRS": "nk.joints.KINEMATIC_PAIRS",
        "Singularity": "nk.joints.JointGroups",
        "TypedJoint": "nk.joints.MultiDofJoint",
        "lower_pair": "nk.joints.kinematic_pair",
    },
    "nao_kin.motion": {
        "read": "nk.motion.read_motion",
        "to_csv": "nk.motion.write_motion",
        "write": "nk.motion.write_motion",
    },
    "nao_kin.naoqi": {"Change": "nk.naoqi.Event"},
    "nao_kin.reach": dict.fromkeys(("ReachSettings", "Stance"), "nk.reach.ReachMap"),
    "nao_kin.robot": {"UnreadableShape": "nk.urdf.UnreadableShape"},
    "nao_kin.robot.nao": dict.fromkeys(
        (
            *("COLOURS", "CameraRow", "CoupledLimitRow", "Finger", "Frame", "InertialRow", "Joint", "LimitRow"),
            *("Offset", "OffsetRow", "ShapeRow", "VisualRow"),
        ),
        "nk.parameters.NaoParameters",
    ),
    "nao_kin.rotations": {
        "angle": "nk.rotations.angle_between",
        "axis_angle_from_matrix": "nk.rotations.natural_invariants, nk.rotations.log",
        "convert": "nk.rotations.matrix_from_quat, nk.rotations.quat_from_matrix, nk.rotations.euler_from_matrix",
        "distance": "nk.rotations.angle_between",
        "mean": "nk.rotations.mean_rotation",
        "quat_mul": "nk.rotations.quat_multiply",
        "random": "nk.rotations.random_rotation, nk.rotations.random_quat",
        "rotvec_from_matrix": "nk.rotations.log",
    },
    "nao_kin.stream": dict.fromkeys(("BadRow", "Clamped"), "nk.stream.StreamResult"),
}


def unknown_attribute(owner: str, name: str, valid: Iterable[str], kinds: Iterable[str]) -> AttributeError:
    """Return the error for an attribute that does not exist.

    Args:
        owner: what has not the attribute, as in Python's own message.
        name: the attribute.
        valid: the names that exist.
        kinds: the keys of `GUESSES` that serve this owner.
    """
    message = f"{owner} has no attribute {name!r}"
    if name.startswith("_"):
        return AttributeError(message)
    meant = next((GUESSES[kind][name] for kind in kinds if name in GUESSES.get(kind, ())), "")
    if meant:
        return AttributeError(f"{message}; see {meant}")
    near = nearest_names(name, (one for one in valid if not one.startswith("_")), similar=0.7)
    return AttributeError(f"{message}; nearest: {', '.join(near)}" if near else message)


def public_attributes(module: str) -> dict[str, Any]:
    """Return a module's `__dir__`, which lists public names, and `__getattr__`, whose errors name what was meant.

    A module updates its globals with them, so that type checkers, for which every name would exist, do not see them.
    """

    def missing(name: str) -> Any:
        raise unknown_attribute(f"module {module!r}", name, sys.modules[module].__all__, (module,))

    return {"__dir__": lambda: sorted(sys.modules[module].__all__), "__getattr__": missing}


class _GuessingType(type):
    if not TYPE_CHECKING:  # otherwise type checkers would believe that every attribute exists

        def __getattr__(cls, name: str) -> Any:
            kinds = (kind.__name__ for kind in cls.__mro__)
            raise unknown_attribute(f"type object {cls.__name__!r}", name, dir(cls), kinds)


class Guessing(metaclass=_GuessingType):
    """A class whose errors name what was meant by an attribute that does not exist."""

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            kind = type(self)
            kinds = (one.__name__ for one in kind.__mro__)
            raise unknown_attribute(f"{kind.__name__!r} object", name, dir(self), kinds)
