"""Shapes of a NAO, drawn for this library: solids per link and colour, and the meshes made of them."""

from nao_shapes.parts import mesh_texts

__all__ = ["mesh_texts"]
