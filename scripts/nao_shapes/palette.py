"""A part of the robot: one solid per colour."""

from __future__ import annotations

from manifold3d import Manifold

# Colour name of nao_kin.parameters.COLOURS → solid, in the frame of the link.
Part = dict[str, Manifold]
