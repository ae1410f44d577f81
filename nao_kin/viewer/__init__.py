"""The robot in a browser."""

from nao_kin.viewer.viewer import OutsideLimitsWarning, Viewer

__all__ = ["OutsideLimitsWarning", "Viewer"]
