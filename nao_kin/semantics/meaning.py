"""The meaning of a robot's parts, by the names of its joints and frames."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from nao_kin.semantics.limits import CoupledLimit

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Posture:
    """A predefined posture.

    Attributes:
        angles: joint → value; joints not named are at zero [rad, m or ratio].
        up: the vertical in the root's frame where the robot rests in it, as an accelerometer at rest shows it; None
            where it stands on its soles.
    """

    angles: Mapping[str, float]
    up: Vector | None = None


@dataclass(frozen=True)
class View:
    """A part of the robot worth looking at.

    Attributes:
        direction: from what is looked at to the camera, in the root's frame.
        joints: look at the links that these joints move, and at all they carry.
    """

    direction: Vector
    joints: tuple[str, ...]


@dataclass(frozen=True)
class Semantics:
    """What a robot means beyond its URDF; every part may be empty.

    Attributes:
        chains: name → joints from the trunk outwards.
        end_effectors: the frames whose pose is asked for most.
        soles: frames with the floor in their xy plane when the robot stands on them.
        cameras: frames of cameras that look along their x axis.
        postures: predefined postures by name.
        start: the posture shown first; "" for all joints at zero, or at the limit nearest to it.
        coupled_limits: tables in which one joint's range depends on another's value.
        units: joint → unit, where it is neither "rad" for a turning joint nor "m" for a sliding one.
        views: close views by name.
        version: which version of the robot this is; "" where there is but one.
        root: what people call the frame that poses are given in; "" for the name of the root link.
    """

    chains: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    end_effectors: tuple[str, ...] = ()
    soles: tuple[str, ...] = ()
    cameras: tuple[str, ...] = ()
    postures: Mapping[str, Posture] = field(default_factory=dict)
    start: str = ""
    coupled_limits: tuple[CoupledLimit, ...] = ()
    units: Mapping[str, str] = field(default_factory=dict)
    views: Mapping[str, View] = field(default_factory=dict)
    version: str = ""
    root: str = ""

    def __post_init__(self) -> None:
        for name in ("chains", "postures", "units", "views"):
            object.__setattr__(self, name, MappingProxyType(dict(getattr(self, name))))

    def joints(self) -> Iterator[tuple[str, str]]:
        """Every joint that is named here, with where it is named."""
        for chain, joints in self.chains.items():
            yield from ((joint, f"chain {chain!r}") for joint in joints)
        for posture, values in self.postures.items():
            yield from ((joint, f"posture {posture!r}") for joint in values.angles)
        for table in self.coupled_limits:
            yield from ((joint, "a coupled limit") for joint in (table.joint, table.of))
        yield from ((joint, "the units") for joint in self.units)
        for view, what in self.views.items():
            yield from ((joint, f"view {view!r}") for joint in what.joints)

    def frames(self) -> Iterator[tuple[str, str]]:
        """Every frame that is named here, with where it is named."""
        for where in ("end_effectors", "soles", "cameras"):
            yield from ((frame, where) for frame in getattr(self, where))

    def __getstate__(self) -> dict[str, object]:
        # Mapping proxies do not pickle.
        return {k: dict(v) if isinstance(v, MappingProxyType) else v for k, v in self.__dict__.items()}

    def __setstate__(self, state: dict[str, object]) -> None:
        self.__dict__.update(state)
        Semantics.__post_init__(self)
