"""The NAO: its versions, chains, postures, and NAOqi's Body order."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._arrays import Floats, as_floats
from nao_kin.errors import UnknownName
from nao_kin.files import nao_urdf_path
from nao_kin.parameters import BODY_ORDER, CHAINS, FINGER_RATIO, FINGERS, POSTURES, nao_parameters, version_named
from nao_kin.parameters.rows import Version
from nao_kin.robot.build import Base, ModelSource
from nao_kin.robot.model import LimitPolicy, RobotModel
from nao_kin.urdf_reader import Mimic

_POSTURES = {row.name: row.body for row in POSTURES}


class NaoModel(RobotModel):
    """A NAO H25 with its 25 degrees of freedom.

    Beside what every `RobotModel` has:

    Attributes:
        version: "v3.2" … "v6".
        chains: NAOqi's chains, name → joints from the trunk outwards; both HipYawPitch joints are listed.
        body_order: NAOqi's 26 joint names in the order of "Body".
        posture_names: NAOqi's predefined postures.
    """

    chains: Mapping[str, tuple[str, ...]] = MappingProxyType(CHAINS)
    body_order: tuple[str, ...] = BODY_ORDER
    posture_names: tuple[str, ...] = tuple(_POSTURES)

    def __init__(self, version: str = "v6", *, base: Base = "fixed") -> None:
        self.version: Version = version_named(version)
        parameters = nao_parameters(self.version)
        path = nao_urdf_path(self.version)
        mimics = {joint.name: Mimic(joint.mimic) for joint in parameters.joints if joint.mimic is not None}
        hands = [joint.name for joint in parameters.joints if joint.unit == "1"]
        mimics |= {f"{hand}{finger.name}": Mimic(hand, FINGER_RATIO) for hand in hands for finger in FINGERS}
        super().__init__(
            ModelSource(f"nao_{self.version}", path.read_text(encoding="utf-8"), base),
            path,
            mimics=mimics,
            units=dict.fromkeys(hands, "1"),
            coupled_limits=parameters.coupled_limits,
        )

    def posture(self, name: str) -> Floats:
        """One of NAOqi's predefined postures, shape (nq,).

        Raises:
            UnknownName: no such posture.
        """
        if not isinstance(name, str) or name not in _POSTURES:
            raise UnknownName("posture", name, self.posture_names)
        return self.from_body(_POSTURES[name])

    def to_body(self, q: ArrayLike) -> Floats:
        """Joint values in NAOqi's Body order: 26 values, RHipYawPitch repeating LHipYawPitch.

        Args:
            q: configurations, shape (..., nq).

        Returns:
            Shape (..., 26).
        """
        return self._coordinates.with_mimics(self._checked(q)[..., self._q_offset :], BODY_ORDER)

    def from_body(self, body: ArrayLike, *, limits: LimitPolicy = "ignore") -> Floats:
        """The configuration with the given values in NAOqi's Body order.

        Args:
            body: shape (..., 26) [rad; 0 to 1 for the hands].
            limits: what to do with joints outside their limits: "ignore", "raise" or "clamp".

        Returns:
            q, shape (..., nq).

        Raises:
            CouplingViolated: the two HipYawPitch values differ by more than 1e-6.
            WrongShape, NotFinite, OutsideLimits: as everywhere.
        """
        values = as_floats(body, (len(BODY_ORDER),), "Body values")
        return self.configuration(dict(zip(BODY_ORDER, np.moveaxis(values, -1, 0), strict=True)), limits=limits)


def load_nao(version: str = "v6", *, base: Base = "fixed") -> NaoModel:
    """A NAO H25 as a Pinocchio model with exactly 25 degrees of freedom.

    Args:
        version: "v3.2", "v3.3", "v4", "v5" or "v6".
        base: "fixed" holds the trunk at the origin; "floating" adds a free-flyer before the joints.

    Raises:
        UnknownName: no such version.
        BadArgument: no such base.
    """
    return NaoModel(version, base=base)
