"""The equality constraints of MuJoCo between joints as couplings; those that no tree of joints has, as notes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from nao_kin._text import abbreviated, quoted
from nao_kin.semantics import Mimic

# Kinds of equality constraints, as `mujoco.mjtEq` numbers them.
_JOINT = 2
_KINDS = {0: "connect", 1: "weld", 3: "tendon", 4: "flex"}


@dataclass
class Couplings:
    """What holds between the joints.

    Attributes:
        mimics: joint → the joint that it follows, and how.
        locked: joint → the value that it is held at.
    """

    mimics: dict[str, Mimic] = field(default_factory=dict)
    locked: dict[str, float] = field(default_factory=dict)

    def follow(self, name: str, mimic: Mimic) -> bool:
        """Have a joint follow another one, or where it follows already, that one follow it; False where neither can."""
        if self._leads_to(mimic.joint, name):
            return False
        if name not in self.mimics and name not in self.locked:
            self.mimics[name] = mimic
            return True
        if mimic.joint not in self.mimics and mimic.joint not in self.locked and not self._leads_to(name, mimic.joint):
            self.mimics[mimic.joint] = mimic.inverted(name)
            return True
        return False

    def lock_followers(self, notes: list[str]) -> None:
        """Hold the joints that follow one that is held, with a note for each."""
        while held := [name for name, mimic in self.mimics.items() if mimic.joint in self.locked]:
            for name in held:
                mimic = self.mimics.pop(name)
                self.locked[name] = value = float(mimic.value(self.locked[mimic.joint]))
                notes.append(
                    f"joint {quoted(name)} follows {quoted(mimic.joint)}, which is held: taken as fixed at {value:.6g}"
                )

    def _leads_to(self, name: str, end: str) -> bool:
        """Whether the chain of mimics that starts at a joint passes another one."""
        while name != end and name in self.mimics:
            name = self.mimics[name].joint
        return name == end


def read_couplings(model: Any, names: Mapping[int, str], notes: list[str]) -> Couplings:
    """The couplings of a model's joints.

    MuJoCo holds y − y₀ = a₀ + a₁ (x − x₀) + … + a₄ (x − x₀)⁴ for the values x and y of two joints and their `ref`.

    Args:
        model: the `mujoco.MjModel`.
        names: joint → its name, of the hinges and slides of the robot.
        notes: gets a line for what is left out.
    """
    couplings, left_out = Couplings(), Counter[str]()
    for row in range(int(model.neq)):
        kind = int(model.eq_type[row])
        if not model.eq_active0[row]:
            left_out["inactive"] += 1
        elif kind != _JOINT:
            left_out[_KINDS.get(kind, "other")] += 1
        elif (first := int(model.eq_obj1id[row])) in names:
            second = int(model.eq_obj2id[row])
            if second in names or second < 0:
                _couple(model, row, names[first], names.get(second, ""), couplings, notes)
            else:
                notes.append(f"joint {quoted(names[first])} is coupled to one that is not the robot's: left out")
    couplings.lock_followers(notes)
    if left_out:
        kinds = ", ".join(f"{count} {kind}" for kind, count in left_out.items())
        notes.append(f"equality constraints left out, so that their joints move on their own: {kinds}")
    return couplings


def _couple(model: Any, row: int, name: str, driver: str, couplings: Couplings, notes: list[str]) -> None:
    """Take over one constraint between two joints, or of one joint with itself."""
    constant, slope, *higher = (float(value) for value in model.eq_data[row, :5])
    y = float(model.qpos0[model.jnt_qposadr[model.eq_obj1id[row]]])
    if driver and any(higher):
        notes.append(
            f"joint {quoted(name)} follows {quoted(driver)} by a curve of degree "
            f"{max(n for n, value in enumerate(higher, 2) if value)}: it moves on its own here"
        )
    elif driver and slope:
        x = float(model.qpos0[model.jnt_qposadr[model.eq_obj2id[row]]])
        if not couplings.follow(name, Mimic(driver, slope, y + constant - slope * x)):
            notes.append(f"joint {abbreviated(name)} is coupled to {abbreviated(driver)} once more: left out")
    elif name in couplings.mimics:
        notes.append(f"joint {abbreviated(name)} is held at a value and follows another: it follows")
    else:
        couplings.locked[name] = y + constant
        notes.append(f"joint {quoted(name)} is held at {y + constant:.6g}: taken as fixed there")
