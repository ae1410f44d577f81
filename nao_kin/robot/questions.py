"""What a robot can be asked about configurations, apart from who answers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from nao_kin.errors import UnknownName

Expression = Literal["frame", "root", "mixed"]
PoseForm = Literal["matrix", "position_quaternion", "position6d"]
FrameIds = tuple[int, ...]

EXPRESSIONS = ("frame", "root", "mixed")
POSE_FORMS = ("matrix", "position_quaternion", "position6d")

# The shape of one frame's pose in each form.
POSE_SHAPES = {
    "matrix": (4, 4),
    "rotation": (3, 3),
    "position": (3,),
    "position_quaternion": (7,),
    "position6d": (6,),
}


@dataclass(frozen=True)
class Question:
    """One question, the same for any number of configurations.

    Attributes:
        kind: "poses", "jacobian", "com", "com_jacobian", "velocity" or "acceleration".
        frame_ids: the frames it is about.
        reference_id: the frame that poses and centres of mass are expressed in; None for the root.
        form: for poses, one of POSE_SHAPES; for Jacobians and motions, the expression.
    """

    kind: str
    frame_ids: FrameIds = ()
    reference_id: int | None = None
    form: str = ""

    def shape(self, nv: int) -> tuple[int, ...]:
        """Shape of the answer for one configuration."""
        if self.kind == "poses":
            return (len(self.frame_ids), *POSE_SHAPES[self.form])
        if self.kind == "jacobian":
            return 6, nv
        if self.kind == "com":
            return (3,)
        if self.kind == "com_jacobian":
            return 3, nv
        return len(self.frame_ids), 6


def check_expression(name: str) -> None:
    """Refuse what is none of EXPRESSIONS."""
    if not isinstance(name, str) or name not in EXPRESSIONS:
        raise UnknownName("expression", name, EXPRESSIONS)


def check_pose_form(name: str) -> None:
    """Refuse what is none of POSE_FORMS."""
    if not isinstance(name, str) or name not in POSE_FORMS:
        raise UnknownName("form of a pose", name, POSE_FORMS)
