"""Problem 3: the joints of the body and their mechanical equivalents."""

from __future__ import annotations

import nao_kin as nk
from nao_kin.joints import ANATOMY, KINEMATIC_PAIRS, group_joints
from paper.rows import Problem, Row

# The paper's tables I and II: anatomical joint → mechanical equivalents and their degrees of freedom.
_TABLES = {
    "hinge": {"revolute": 1},
    "pivot": {"revolute": 1, "cylindrical": 2},
    "ball and socket": {"spherical": 3},
    "ellipsoid": {"condyloid": 2},
    "saddle": {"universal": 2},
    "plane": {"planar": 3, "prismatic": 1},
}


def problem_3() -> Problem:
    """Solve problem 3: tables I and II, and the NAO's own joints as kinematic pairs."""
    rows = []
    for joint in ANATOMY:
        printed = _TABLES.get(joint.name, {})
        rows.append(Row(f"{joint.name}: same equivalents", "joints.ANATOMY", joint.mechanical == tuple(printed), True))
        rows.append(Row(f"{joint.name}: freedoms", "joints.ANATOMY", joint.freedoms, tuple(printed.values())))
        constrained = tuple(6 - KINEMATIC_PAIRS[name].freedoms for name in joint.mechanical)
        forbidden = tuple(KINEMATIC_PAIRS[name].constraints for name in joint.mechanical)
        rows.append(Row(f"{joint.name}: constraints", "joints.KINEMATIC_PAIRS", forbidden, constrained))
    groups = group_joints(nk.load_nao())
    for name, count in (("revolute", 6), ("universal", 7), ("spherical", 2)):
        found = sum(joint.pair.name == name for joint in groups)
        rows.append(Row(f"NAO's {name} joints", "joints.group_joints", found, count))
    return Problem(
        "3",
        "anatomical joints and their mechanical equivalents",
        rows=tuple(rows),
        notes=tuple(f"{joint.name} ({joint.example}): {', '.join(joint.mechanical)}" for joint in ANATOMY),
    )
