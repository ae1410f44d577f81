"""What is meant by an attribute that does not exist: names that people try, and the nearest valid ones."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

from nao_kin.errors import nearest_names

# Class or module → a name that people try → expressions that give what it promises. In these, `robot`, `motion` and
# `viewer` are objects of the classes.
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
        "mirror": "nk.motion.mirror",
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
    },
    "nao_kin": {
        "deg2rad": "np.radians",
        "invert": "np.linalg.inv",
        "load_motion": "nk.motion.read_motion",
        "load_urdf": "nk.RobotModel.from_urdf",
        "plot": "nk.motion.plot",
        "read_csv": "nk.stream.read_configurations, nk.stream.read_log",
        "read_motion": "nk.motion.read_motion",
        "transforms": "nk.rotations, nk.screws",
    },
    "nao_kin.ik": {"solve": _CLOSED},
    "nao_kin.motion": {
        "read": "nk.motion.read_motion",
        "to_csv": "nk.motion.write_motion",
        "write": "nk.motion.write_motion",
    },
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


def guessing(module: str) -> Callable[[str], Any]:
    """Return a `__getattr__` for a module, whose errors name what was meant."""

    def missing(name: str) -> Any:
        public = getattr(sys.modules[module], "__all__", ())
        raise unknown_attribute(f"module {module!r}", name, public, (module,))

    return missing


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
