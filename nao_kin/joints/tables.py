"""The joints of a robot as a table, and the joints of the human body that move like them."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, TypeVar

from nao_kin._core.arrays import Floats, finite_or_none, flag
from nao_kin._core.files import read_toml
from nao_kin._core.text import html_table, one_line_repr, text_table
from nao_kin.joints.grouping import Rule, group_joints, unmerged_joints
from nao_kin.joints.pairs import KINEMATIC_PAIRS, JointGroups, KinematicPair, MultiDofJoint
from nao_kin.robot import RobotModel
from nao_kin.robot.nao import JOINTS

_TABLES = read_toml(Path(__file__).with_name("anatomy.toml"))
_Row = TypeVar("_Row")


def _rows(kind: Callable[..., _Row], table: str) -> Iterator[_Row]:
    """Yield the rows of a table, with tuples in place of lists."""
    for row in _TABLES[table]:
        yield kind(**{name: tuple(entry) if isinstance(entry, list) else entry for name, entry in row.items()})


# --- The NAO's joints and the human joints in the same places.

NAO_TWISTS = frozenset(row.name for row in JOINTS if row.motion == "twist")
"""The NAO's joints that turn a limb about its long axis."""


@dataclass(frozen=True)
class BodyPart:
    """A part of the NAO's body, its joints, and the human joints in the same place.

    Attributes:
        name: part of the body.
        joints: the NAO's joints in this part, from the trunk outwards, without the side.
        anatomical: the anatomical joint that moves like them.
        human: the human anatomical joints in the same place.
        difference: how the NAO differs from the human.
    """

    name: str
    joints: tuple[str, ...]
    anatomical: str
    human: tuple[str, ...]
    difference: str


NAO_ANATOMY: tuple[BodyPart, ...] = tuple(_rows(BodyPart, "nao"))
"""The NAO's joints mapped to anatomy, for the versions V3.2 to V6."""


# --- Joints of the human body, the mechanical joints that move like them, and body parts in names of joints.


@dataclass(frozen=True)
class AnatomicalJoint:
    """A kind of synovial joint.

    Attributes:
        name: its anatomical name.
        mechanical: names of the pairs that move like it, the closest first.
        allows: the motions that it allows.
        forbids: the motions that it forbids.
        example: where the human body has it.
        table: the table of the source that lists it.
    """

    name: str
    mechanical: tuple[str, ...]
    allows: str
    forbids: str
    example: str
    table: str

    @property
    def pairs(self) -> tuple[KinematicPair, ...]:
        """The mechanical equivalents."""
        return tuple(KINEMATIC_PAIRS[name] for name in self.mechanical)

    @property
    def freedoms(self) -> tuple[int, ...]:
        """Degrees of freedom of each of these."""
        return tuple(pair.freedoms for pair in self.pairs)


class AnatomyTable(tuple[AnatomicalJoint, ...]):
    """A tuple of anatomical joints that prints as a table."""

    __slots__ = ()

    def __repr__(self) -> str:
        return text_table(_HEAD, self._cells())

    def _repr_html_(self) -> str:
        return html_table("Anatomical joints", _HEAD, self._cells())

    def _cells(self) -> list[tuple[str, ...]]:
        return [
            (kind.name, ", ".join(kind.mechanical), ", ".join(map(str, kind.freedoms)), kind.example) for kind in self
        ]


_HEAD = ("joint", "moves like", "freedoms", "example")

ANATOMY = AnatomyTable(_rows(AnatomicalJoint, "anatomy"))
"""Tables I and II of the source paper: six anatomical joints, their mechanical equivalents and degrees of freedom."""


_KIND_OF_PAIR = {pair: kind.name for kind in reversed(ANATOMY) for pair in kind.mechanical}
_BODY_PARTS = ("neck", "shoulder", "elbow", "wrist", "hand", "hip", "knee", "ankle")
_SIDES = (
    ("left", re.compile(r"^(L(?=[A-Z])|l_|left)|_l(eft)?_")),
    ("right", re.compile(r"^(R(?=[A-Z])|r_|right)|_r(ight)?_")),
)


def anatomical_kind(joints: tuple[str, ...], pair: KinematicPair) -> str:
    """Return the anatomical joint that moves like a joint made of these URDF joints; "" if the human body has none."""
    if pair.name == "revolute" and joints[0] in NAO_TWISTS:
        return "pivot"
    return _KIND_OF_PAIR.get(pair.name, "")


def body_part(joint: str) -> str:
    """Return the part of the body that a joint's name contains, as "left hip"; "" when it contains none."""
    lower = joint.lower()
    # The head turns in the neck.
    part = next((part for part in _BODY_PARTS if part in lower), "neck" if "head" in lower else "")
    side = next((side for side, pattern in _SIDES if pattern.search(joint)), "")
    return f"{side} {part}".strip() if part else ""


# --- The joints of a robot as a table.

Numbers = tuple[float, ...]


@one_line_repr
@dataclass(frozen=True)
class JointTableRow:
    """One joint; lengths and directions in the root's frame with all joints at zero.

    Attributes:
        chain: name of its chain: the robot's own name, or else the name of the chain's first joint.
        joint: its name; for a merged joint the names of its parts, joined by "+".
        parts: the joints of the URDF it is made of.
        pair: "revolute", "universal" …
        symbol: the letter for it.
        freedoms: degrees of freedom.
        axes: unit vector of each axis.
        centre: common point of the axes [m].
        lower: smallest value of each part, in its unit.
        upper: largest value of each part, in its unit.
        units: "rad", "m", or "1" for a ratio, of each part.
        body: the part of the body, "" when the joint's name contains none.
        anatomical: the anatomical joint that moves like it, "" when there is none.
        screws: Plücker coordinates (direction; moment) of each axis about the root's origin [1; m]; the line of a
            prismatic joint runs through its centre.
        coupled_to: the joints of other rows that drive one of its parts.
    """

    chain: str
    joint: str
    parts: tuple[str, ...]
    pair: str
    symbol: str
    freedoms: int
    axes: tuple[Numbers, ...]
    centre: Numbers
    lower: tuple[float, ...]
    upper: tuple[float, ...]
    units: tuple[str, ...]
    body: str
    anatomical: str
    screws: tuple[Numbers, ...]
    coupled_to: tuple[str, ...]


@dataclass(frozen=True)
class JointTable:
    """All joints of a robot, chain by chain.

    Attributes:
        robot: name of the robot.
        rule: the rule that merged its joints, "none" for the joints as its URDF has them.
        tolerance: largest distance of the axes of a merged joint from their common point [m]; zero for "none".
        rows: the joints, each with its `chain`, its name `joint`, its `parts` (joints of the URDF), `pair`, `symbol`,
            `freedoms`, `axes`, `centre`, `lower`, `upper` and `units`; the part of the `body` and the `anatomical`
            joint, "" for none; Plücker coordinates of its axes, `screws`; and `coupled_to`, the joints that drive it.
        driven: joints of the URDF that only follow another one and are not rows.
        dof: degrees of freedom.
        summary: the count, such as "25 DOF = 2×3 + 7×2 + 6×1 − 1".
    """

    robot: str
    rule: str
    tolerance: float
    rows: tuple[JointTableRow, ...]
    driven: tuple[str, ...]
    dof: int
    summary: str

    def as_dict(self) -> dict[str, Any]:
        """Return the table as plain dictionaries, lists, strings and numbers; a missing limit is None.

        Examples:
            >>> nk.joints.joint_table(nk.load_nao()).as_dict()["dof"]
            25
        """
        return asdict(self, dict_factory=_without_infinities)

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.robot}, {self.rule}: {len(self.rows)} joints, {self.summary}>"

    def _repr_html_(self) -> str:
        head = ("chain", "joint", "pair", "body", "like a", "centre [m]", "range")
        return html_table(f"{self.robot}: {self.summary} ({self.rule})", head, map(_cells, self.rows))


def joint_table(
    robot: RobotModel, *, typed: bool = False, rule: Rule = "coincident", tolerance: float = 1e-9
) -> JointTable:
    """Return the joints of a robot as a table.

    Args:
        robot: any robot.
        typed: merge runs of revolute joints first, as `group_joints` does; otherwise one row for each joint of the
            URDF.
        rule: with `typed`, the rule for merging.
        tolerance: with `typed`, the largest distance of the axes of a merged joint from their common point [m].

    Examples:
        >>> nk.joints.joint_table(nk.load_nao(), typed=True).summary
        '25 DOF = 2×3 + 7×2 + 6×1 − 1'
    """
    groups = group_joints(robot, rule=rule, tolerance=tolerance) if flag(typed, "typed") else unmerged_joints(robot)
    chains = _chains(groups, robot.chains)
    order = list(dict.fromkeys((*robot.chains, *chains.values())))
    drivers = {name: mimic.joint for name, mimic in groups.mimics.items()}
    rows = [_row(joint, chains[joint.name], drivers) for joint in groups]
    return JointTable(
        robot=str(robot.model.name),
        rule=groups.rule,
        tolerance=groups.tolerance,
        rows=tuple(sorted(rows, key=lambda row: order.index(row.chain))),
        driven=groups.driven,
        dof=groups.mobility,
        summary=groups.summary,
    )


def _chains(groups: JointGroups, named: Mapping[str, Sequence[str]]) -> dict[str, str]:
    """Return joint → chain: the robot's name for it, or the first joint behind the last branching."""
    chain_of = {part: chain for chain, parts in named.items() for part in parts}
    siblings = Counter(joint.parent for joint in groups)
    chains: dict[str, str] = {}
    for joint in groups:
        starts = joint.parent == "" or siblings[joint.parent] > 1
        chains[joint.name] = chain_of.get(joint.joints[0], joint.joints[0] if starts else chains.get(joint.parent, ""))
    return chains


def _row(joint: MultiDofJoint, chain: str, drivers: Mapping[str, str]) -> JointTableRow:
    return JointTableRow(
        chain=chain,
        joint=joint.name,
        parts=joint.joints,
        pair=joint.pair.name,
        symbol=joint.pair.symbol,
        freedoms=joint.pair.freedoms,
        axes=_plain(joint.axes),
        centre=_plain(joint.centre[None])[0],
        lower=joint.lower,
        upper=joint.upper,
        units=joint.units,
        body=body_part(joint.joints[0]),
        anatomical=anatomical_kind(joint.joints, joint.pair),
        screws=_plain(joint.lines.coordinates) if len(joint.axes) else (),
        coupled_to=tuple(drivers[part] for part in joint.joints if part in drivers),
    )


def _cells(row: JointTableRow) -> tuple[str, ...]:
    centre = " ".join(f"{value:.4g}" for value in row.centre)
    ranges = (
        f"{lower:.4g} … {upper:.4g}{'' if unit == '1' else f' {unit}'}"
        for lower, upper, unit in zip(row.lower, row.upper, row.units, strict=True)
    )
    return row.chain, row.joint, row.pair, row.body, row.anatomical, centre, "; ".join(ranges)


def _without_infinities(items: list[tuple[str, Any]]) -> dict[str, Any]:
    return {name: tuple(map(finite_or_none, value)) if name in ("lower", "upper") else value for name, value in items}


def _plain(rows: Floats) -> tuple[Numbers, ...]:
    # Adding 0.0 turns −0.0 into 0.0.
    return tuple(tuple(float(value) + 0.0 for value in row) for row in rows)
