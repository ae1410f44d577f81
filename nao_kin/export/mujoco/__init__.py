"""The robot as MuJoCo's own format, MJCF."""

from nao_kin.export.mujoco.package import mjcf

__all__ = ["mjcf"]
