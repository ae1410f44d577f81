"""Shapes of a NAO, made for this library: solids per link and colour, and their meshes."""

from nao_shapes.parts import mesh_texts

__all__ = ["mesh_texts"]
