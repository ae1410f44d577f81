"""The joints of a robot as a table: what each is, where its axes lie, how far it goes, what the body calls it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from nao_kin._common.arrays import Floats
from nao_kin._common.choices import flag
from nao_kin._common.scalars import finite_or_none
from nao_kin._text import html_table
from nao_kin.joints.anatomy import anatomical_kind, body_part
from nao_kin.joints.grouping import Rule, group_joints, unmerged_joints
from nao_kin.joints.multidof_joint import JointGroups, MultiDofJoint
from nao_kin.robot import RobotModel

Numbers = tuple[float, ...]


@dataclass(frozen=True)
class JointTableRow:
    """One joint; lengths and directions in the root's frame with all joints at zero.

    Attributes:
        chain: the chain it is in: the robot's own name for it, or the name of its first joint.
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
        body: the part of the body, "" when the joint's name speaks of none.
        anatomical: the anatomical joint that moves like it, "" when there is none.
        screws: Plücker coordinates (direction; moment) of each axis about the root's origin [1; m]; the line of a
            prismatic joint runs through its centre.
        coupled_to: the joints of other rows that drive one of its parts.

    Examples:
        >>> row = nk.joints.joint_table(nk.load_nao(), typed=True).rows[0]
        >>> row.joint, row.pair, row.freedoms
        ('HeadYaw+HeadPitch', 'universal', 2)
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
        tolerance: how far the axes of a merged joint may miss their common point [m]; zero for "none".
        rows: the joints.
        driven: joints of the URDF that only follow another one and are no rows.
        dof: degrees of freedom.
        summary: the count, as "25 DOF = 2×3 + 7×2 + 6×1 − 1".

    Examples:
        >>> table = nk.joints.joint_table(nk.load_nao())
        >>> table.robot, table.dof
        ('nao_v6', 25)
    """

    robot: str
    rule: str
    tolerance: float
    rows: tuple[JointTableRow, ...]
    driven: tuple[str, ...]
    dof: int
    summary: str

    def as_dict(self) -> dict[str, Any]:
        """The table as plain dictionaries, lists, strings and numbers; a limit that is not there is None.

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
    """The joints of a robot as a table.

    Args:
        robot: any `RobotModel`.
        typed: merge runs of revolutes first, as `group_joints` does; else one row for each joint of the URDF.
        rule: with `typed`, the rule that merges.
        tolerance: with `typed`, how far the axes of a merged joint may miss their common point [m].

    Raises:
        UnknownName, BadArgument, BadModel: as `group_joints`.

    Examples:
        >>> nk.joints.joint_table(nk.load_nao(), typed=True).summary
        '25 DOF = 2×3 + 7×2 + 6×1 − 1'
    """
    groups = group_joints(robot, rule=rule, tolerance=tolerance) if flag(typed, "typed") else unmerged_joints(robot)
    chains = _chains(groups, getattr(robot, "chains", {}))
    order = list(dict.fromkeys(chains[joint.name] for joint in groups))
    named = [chain for chain in getattr(robot, "chains", {}) if chain in order]
    order = named + [chain for chain in order if chain not in named]
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
    """Joint → chain: the one the robot names, else the first joint behind the last branching."""
    chain_of = {part: chain for chain, parts in named.items() for part in parts}
    siblings: dict[str, int] = {}
    for joint in groups:
        siblings[joint.parent] = siblings.get(joint.parent, 0) + 1
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
