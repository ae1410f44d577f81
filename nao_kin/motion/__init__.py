"""Trajectories: joints with keys of their own, interpolated, checked, mended and edited; and files of many kinds."""

from __future__ import annotations

__all__: list[str] = []
