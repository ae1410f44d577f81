"""NAOqi's language: its names, orders, poses, spaces and limits, and a virtual NAO that speaks it."""

from __future__ import annotations

__all__: list[str] = []
