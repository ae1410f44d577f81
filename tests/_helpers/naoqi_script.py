"""A script that calls ALMotion of a virtual NAO, and looks at the robot."""

from __future__ import annotations

from typing import Any

import numpy as np

from nao_kin.naoqi.virtual import VirtualNao

TORSO, WORLD, ROBOT = 0, 1, 2


class Script:
    """A virtual NAO with stiffness, as a script sees it; `script("moveTo", 0.1, 0.0, 0.0)` calls ALMotion."""

    def __init__(self, posture: str = "StandInit") -> None:
        self.nao = VirtualNao(stepped=True, posture=posture)
        self("setStiffnesses", "Body", 1.0)

    def __call__(self, name: str, *given: Any) -> Any:
        return self.nao.call("ALMotion", name, *given)

    def __enter__(self) -> Script:
        return self

    def __exit__(self, *_: object) -> None:
        self.nao.close()

    def position(self, name: str, space: int) -> np.ndarray:
        return np.array(self("getPosition", name, space, True))

    def pose(self, name: str, space: int) -> np.ndarray:
        return np.array(self("getTransform", name, space, True)).reshape(4, 4)

    def feet(self) -> np.ndarray:
        """The poses of the left and the right sole in the world."""
        return np.stack([self.pose(foot, WORLD) for foot in ("LLeg", "RLeg")])

    def place(self) -> np.ndarray:
        return np.array(self("getRobotPosition", True))

    def torso(self) -> np.ndarray:
        return self.nao.state().T_world_torso

    def log(self) -> str:
        return "\n".join(line for _, line in self.nao.log.lines)
