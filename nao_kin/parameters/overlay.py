"""How the numbers of one version are laid over those of another."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

from nao_kin.errors import UnknownName
from nao_kin.parameters.rows import (
    VERSIONS,
    ActuatorRow,
    FrameRow,
    InertialRow,
    LimitRow,
    OffsetRow,
    Version,
    VersionedRow,
    VisualRow,
)

_Row = TypeVar("_Row", bound=VersionedRow)


@dataclass(frozen=True)
class Tables:
    """All rows of one version that another version may have otherwise.

    Attributes:
        offsets: the distances between the joints.
        limits: the ranges of the joints.
        actuators: their speeds and torques.
        inertials: mass and inertia of the links.
        frames: sensor and effector frames.
        visuals: the meshes of the links.
        placeholder: what links without a mass of their own are given; None for nothing.
    """

    offsets: tuple[OffsetRow, ...]
    limits: tuple[LimitRow, ...]
    actuators: tuple[ActuatorRow, ...]
    inertials: tuple[InertialRow, ...]
    frames: tuple[FrameRow, ...]
    visuals: tuple[VisualRow, ...]
    placeholder: InertialRow | None


@dataclass(frozen=True, kw_only=True)
class VersionPage:
    """What one version has otherwise than another one.

    A row stands in the place of the base's row of the same key. Frames and visuals may also come and go.

    Attributes:
        version: the version.
        base: the version that it is laid over.
        offsets: distances that differ; likewise limits, actuators and inertials.
        frames: frames that differ, and those that the base does not have.
        without_frames: names of the base's frames that it does not have.
        visuals: meshes that the base does not have, or has in other colours.
        without_visuals: keys, "joint/part", of the base's meshes that it does not have.
        placeholder: what links without a mass of their own are given; None for what the base gives.

    Examples:
        >>> page = nk.parameters.VersionPage(version="v5", base="v6")
        >>> page.version, page.offsets
        ('v5', ())
    """

    version: Version
    base: Version
    offsets: tuple[OffsetRow, ...] = ()
    limits: tuple[LimitRow, ...] = ()
    actuators: tuple[ActuatorRow, ...] = ()
    inertials: tuple[InertialRow, ...] = ()
    frames: tuple[FrameRow, ...] = ()
    without_frames: tuple[str, ...] = ()
    visuals: tuple[VisualRow, ...] = ()
    without_visuals: tuple[str, ...] = ()
    placeholder: InertialRow | None = None

    def over(self, base: Tables) -> Tables:
        """The tables of this version.

        Args:
            base: the tables of the version `base`.

        Raises:
            UnknownName: the page changes or leaves out a row that the base does not have.
        """
        of = f"of {self.base}, which {self.version} is laid over"
        return Tables(
            offsets=overlaid(f"offset {of}", base.offsets, self.offsets),
            limits=overlaid(f"limit {of}", base.limits, self.limits),
            actuators=overlaid(f"actuator {of}", base.actuators, self.actuators),
            inertials=overlaid(f"inertial {of}", base.inertials, self.inertials),
            frames=overlaid(f"frame {of}", base.frames, self.frames, self.without_frames),
            visuals=overlaid(f"visual {of}", base.visuals, self.visuals, self.without_visuals),
            placeholder=self.placeholder or base.placeholder,
        )


def overlaid(
    what: str, base: Iterable[_Row], changes: Sequence[_Row] = (), without: Sequence[str] = ()
) -> tuple[_Row, ...]:
    """The rows of `base` with some of them changed, left out or added.

    A new row stands where the first row of the same place was left out, or else after the last row of that place.

    Args:
        what: what the rows are, for messages.
        base: the rows of the version underneath.
        changes: rows that differ, and new rows.
        without: keys of the rows to leave out.

    Raises:
        UnknownName: `without` names a row that is not there, or a row is new in a table whose rows every version has.
    """
    rows = {row.key: [row] for row in base}
    places = {key: row.place for key, (row,) in rows.items()}
    for key in without:
        if key not in rows:
            raise UnknownName(what, key, tuple(rows))
        rows[key] = []
    for row in changes:
        if row.key in rows:
            rows[row.key] = [row]
        else:
            beside = [key for key, place in places.items() if place is not None and place == row.place]
            if not beside:
                raise UnknownName(what, row.key, tuple(rows))
            rows[next((key for key in beside if key in without), beside[-1])].append(row)
    return tuple(row for group in rows.values() for row in group)


def with_versions(tables: Mapping[Version, Sequence[_Row]]) -> tuple[_Row, ...]:
    """One table of the rows of all versions, each row once, with the versions it holds for.

    Args:
        tables: the rows of each version.

    Returns:
        The rows of the newest version in their order, after each those of older versions about the same, and at the
        end those that only older versions have.
    """
    held: dict[str, dict[_Row, list[Version]]] = {}
    for version in reversed(VERSIONS):
        for row in tables[version]:
            held.setdefault(row.key, {}).setdefault(row, []).insert(0, version)
    return tuple(replace(row, versions=tuple(found)) for rows in held.values() for row, found in rows.items())
