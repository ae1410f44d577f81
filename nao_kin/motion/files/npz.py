"""NumPy's npz: every motion as it is, without loss, fast to load.

Arrays: joint_names (joints,) text; counts (joints,) the number of keys of each; times and keys (sum of counts,) one
joint after the other [s; rad, m or ratio]; interpolation () text; for "bezier", handles (sum of counts, 2, 2).
"""

from __future__ import annotations

import io
import tokenize
import zipfile
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nao_kin._text import abbreviated
from nao_kin.motion.files.format import Format
from nao_kin.motion.files.source import Place, Source
from nao_kin.motion.files.tracks import Track, motion_of
from nao_kin.motion.interpolation import INTERPOLATIONS
from nao_kin.motion.motion import Motion

# A motion of 10⁷ keys has a fifth of it.
_MOST_BYTES = 1 << 31
# What zip files and arrays that are broken make zipfile and NumPy raise.
_BROKEN = (
    *(ValueError, EOFError, OSError, KeyError, MemoryError, OverflowError, RuntimeError, SyntaxError, TypeError),
    *(zipfile.BadZipFile, zlib.error, tokenize.TokenError),
)
_REQUIRED = ("joint_names", "counts", "times", "keys", "interpolation")


def recognises(source: Source) -> bool:
    """Whether it begins as a zip file does."""
    return source.data[:4] == b"PK\x03\x04"


def read(source: Source) -> Motion:
    """The motion in an npz file; nothing in it is ever unpickled.

    Raises:
        BadInputFile: names the array.
    """
    arrays = _arrays(source)
    for name in _REQUIRED:
        if name not in arrays:
            raise source.error(f"no array {name!r}; expected {', '.join(_REQUIRED)}")
    names, counts = arrays["joint_names"], arrays["counts"]
    if names.ndim != 1 or names.dtype.kind != "U":
        raise source.error(f"joint_names must be texts (joints,), got {names.dtype} {names.shape}")
    if counts.shape != names.shape or counts.dtype.kind not in "iu" or (counts < 1).any() or (counts > 1 << 40).any():
        raise source.error(f"counts must be whole numbers ≥ 1 {names.shape}, got {counts.dtype} {counts.shape}")
    total = int(sum(counts.tolist()))
    interpolation = str(arrays["interpolation"]) if arrays["interpolation"].ndim == 0 else ""
    if interpolation not in INTERPOLATIONS:
        raise source.error(f"interpolation must be one of {', '.join(INTERPOLATIONS)}")
    shapes: dict[str, tuple[int, ...]] = {"times": (total,), "keys": (total,)}
    if interpolation == "bezier":
        shapes["handles"] = (total, 2, 2)
    for name, shape in shapes.items():
        if name not in arrays:
            raise source.error(f"no array {name!r}, which bezier interpolation needs")
        array = arrays[name]
        if array.shape != shape or array.dtype.kind not in "fiu":
            raise source.error(f"{name} must be numbers {shape}, got {array.dtype} {array.shape}")
        arrays[name] = array.astype(np.float64)
        if not np.isfinite(arrays[name]).all():
            index = np.argwhere(~np.isfinite(arrays[name]))[0].tolist()
            raise source.error(f"{name}{index} is {array[tuple(index)]}, expected a finite number")
    ends = np.cumsum(counts.astype(np.int64))[:-1]
    parts = {name: np.split(arrays[name], ends) for name in shapes}
    tracks = []
    for row, joint in enumerate(names.tolist()):
        own = parts["handles"][row].copy() if "handles" in parts else None
        first = int(ends[row - 1]) if row else 0

        def place(key: int, first: int = first) -> Place:
            return Place(where=f"times[{first + key}]")

        where = Place(where=f"joint_names[{row}]")
        tracks.append(Track(joint, parts["times"][row], parts["keys"][row], own, where, place))
    return motion_of(source, tracks, interpolation, negative=True)


def _arrays(source: Source) -> dict[str, NDArray[Any]]:
    """All arrays of the file."""
    try:
        with zipfile.ZipFile(io.BytesIO(source.data)) as archive:
            size = sum(entry.file_size for entry in archive.infolist())
        if size > _MOST_BYTES:
            raise source.error(f"unpacked it is {size} bytes, more than {_MOST_BYTES}")
        with np.load(io.BytesIO(source.data), allow_pickle=False) as archive:
            return {name: archive[name] for name in archive.files if name in (*_REQUIRED, "handles")}
    except _BROKEN as error:
        raise source.error(f"no npz file of a motion: {abbreviated(error)}") from None


def write(motion: Motion, rate: float | None) -> bytes:
    """An npz file that gives back the same motion; with a rate, its samples."""
    if rate is not None:
        from nao_kin.motion.files.tables import sampled

        times, values = sampled(motion, rate, "npz")
        motion = Motion(times, motion.joint_names, values)
    arrays: dict[str, Any] = {
        "joint_names": np.array(motion.joint_names),
        "counts": np.array([len(keys) for keys in motion.keys]),
        "times": np.concatenate(motion.times),
        "keys": np.concatenate(motion.keys),
        "interpolation": np.array(motion.interpolation),
    }
    if motion.handles is not None:
        arrays["handles"] = np.concatenate(motion.handles)
    file = io.BytesIO()
    np.savez_compressed(file, allow_pickle=False, **arrays)
    return file.getvalue()


NPZ = Format("npz", (".npz",), "NumPy arrays, without loss", recognises, read, write)
