"""`nao_kin.robot.topology` under its former name."""

from nao_kin.robot import SharedMotor, Topology, topology

__all__ = ["SharedMotor", "Topology", "topology"]
