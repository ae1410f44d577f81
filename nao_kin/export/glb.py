"""The container of a binary glTF: its JSON, its block of numbers, and numbers added to that.

Source: Khronos, glTF 2.0 specification, "GLB File Format Specification" and "Accessors".
"""

from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np

from nao_kin._common.arrays import Floats

_MAGIC, _VERSION = 0x46546C67, 2
_JSON, _BINARY = 0x4E4F534A, 0x004E4942
_FLOAT = 5126
_KINDS = {1: "SCALAR", 3: "VEC3", 4: "VEC4"}


class Glb:
    """A binary glTF in memory.

    Attributes:
        tree: its JSON; changes here are written.
        binary: its block of numbers.
    """

    def __init__(self, content: bytes) -> None:
        """The file with this content, of one block of JSON and at most one of numbers."""
        length, _ = struct.unpack_from("<II", content, 12)
        self.tree: dict[str, Any] = json.loads(content[20 : 20 + length])
        self.binary = bytearray(content[28 + length :])

    def add_numbers(self, values: Floats, *, bounds: bool = False) -> int:
        """Add rows of single-precision numbers.

        Args:
            values: shape (n,), (n, 3) or (n, 4).
            bounds: write the smallest and the largest, as times of an animation need.

        Returns:
            The place of the accessor that reads them.
        """
        rows = np.ascontiguousarray(values, dtype="<f4")
        self.binary += bytes(-len(self.binary) % 4)
        view = {"buffer": 0, "byteOffset": len(self.binary), "byteLength": rows.nbytes}
        self.binary += rows.tobytes()
        views, accessors = self.tree.setdefault("bufferViews", []), self.tree.setdefault("accessors", [])
        views.append(view)
        kind = _KINDS[1 if rows.ndim == 1 else rows.shape[1]]
        accessor = {"bufferView": len(views) - 1, "componentType": _FLOAT, "count": len(rows), "type": kind}
        if bounds:
            accessor |= {"min": [float(rows.min())], "max": [float(rows.max())]}
        accessors.append(accessor)
        return len(accessors) - 1

    def content(self) -> bytes:
        """The file."""
        self.binary += bytes(-len(self.binary) % 4)
        if self.binary:
            self.tree["buffers"] = [{"byteLength": len(self.binary)}]
        text = json.dumps(self.tree, separators=(",", ":"), allow_nan=False).encode()
        text += b" " * (-len(text) % 4)
        blocks = struct.pack("<II", len(text), _JSON) + text
        if self.binary:
            blocks += struct.pack("<II", len(self.binary), _BINARY) + bytes(self.binary)
        return struct.pack("<III", _MAGIC, _VERSION, 12 + len(blocks)) + blocks
