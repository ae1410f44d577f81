"""Problem 2: what kind of mechanism the NAO is."""

from __future__ import annotations

import numpy as np

import nao_kin as nk
from nao_kin import lines
from nao_kin.joints import JointAxes
from nao_kin.robot import topology
from paper.rows import Erratum, Problem, Row


def problem_2() -> Problem:
    """Solve problem 2: degrees of freedom of the NAO, and its serial parts."""
    nao = nk.load_nao()
    structure = topology(nao)
    five = set(structure.chains) == set(nao.chains.values())
    couplings = structure.couplings_between_limbs
    axes = JointAxes(nao)
    yaw, pitch = (axes.lines(nao.neutral())[axes.names.index(name)] for name in ("HeadYaw", "HeadPitch"))
    head = lines.common_normal(yaw, pitch)
    return Problem(
        "2",
        "the NAO's degrees of freedom, serial and parallel parts",
        rows=(
            Row("degrees of freedom", "load_nao", nao.nv, 25),
            Row("closed loops", "robot.topology", structure.closed_loops, 0),
            Row("serial chains", "robot.topology", len(structure.chains), 5),
            Row("they are head, arms and legs", "robot.topology", five, True),
            Row("couplings between chains", "robot.topology", len(couplings), 1),
            Row(
                "it is one motor for both HipYawPitch joints",
                "robot.topology",
                [{joint, mimic.joint} for joint, mimic in couplings.items()] == [{"LHipYawPitch", "RHipYawPitch"}],
                True,
            ),
        ),
        errata=(
            Erratum(
                where="problem 2, part 3",
                printed="parallel joints in head and hands, series joints elsewhere",
                right="a tree of serial chains; the head is two intersecting revolutes, a universal joint",
                evidence=f"{structure.closed_loops} closed loops; HeadYaw and HeadPitch lie {head.distance:.1e} m apart"
                f", at {np.rad2deg(head.angle):.9g}° to each other",
                refuted=bool(
                    structure.closed_loops == 0 and head.distance < 1e-12 and abs(head.angle - np.pi / 2) < 1e-12
                ),
            ),
        ),
        notes=tuple(" → ".join(chain) for chain in structure.chains),
    )
