"""Read skeletons from files, which are recognised by their content, and say what those are that it does not read."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

import numpy as np

from nao_kin._core.arrays import choice
from nao_kin._core.files import read_arrays, read_bytes
from nao_kin._core.text import abbreviated
from nao_kin.errors import BadInputFile
from nao_kin.imitation.json_points import of_json
from nao_kin.imitation.layouts import LAYOUTS
from nao_kin.imitation.reading import Options, errors_of, of_array
from nao_kin.imitation.recorders import is_ntu, of_c3d, of_ntu
from nao_kin.imitation.skeleton import Skeleton
from nao_kin.imitation.tables import of_motive, of_rows, of_table, of_trc
from nao_kin.imitation.trees import of_amass, of_bvh

_SAMPLES = Path(__file__).with_name("samples")
#: Small skeletons of our own making, to try things with: name → file.
SAMPLES: Mapping[str, Path] = MappingProxyType(
    {name: _SAMPLES / file for name, file in (("wave", "wave.bvh"), ("bow", "bow.json"), ("circles", "circles.bvh"))}
)
# Other files, by their first bytes: what they are, and how they become readable ones.
_OTHERS = tuple(
    (re.compile(first, re.DOTALL), what)
    for first, what in (
        (rb"Kaydara FBX|\s*; FBX", "an FBX file: import it in Blender, and export it as Motion Capture (.bvh)"),
        (rb"glTF|\{\s*\"asset\"", "a glTF file: import it in Blender, and export it as Motion Capture (.bvh)"),
        (rb"\x80[\x02-\x05]", "a pickle, which would run code: save its arrays with numpy.savez"),
        (rb"\x89HDF|MATLAB", "a file of MATLAB or HDF5: save its arrays with numpy.savez"),
        (rb".{4}ftyp|RIFF|\x1aE\xdf\xa3", "a video: examples/webcam.py shows how MediaPipe finds a person in one"),
        (rb":version|#!OML|:FULLY-SPECIFIED", "ASF or AMC of Acclaim: convert both together to BVH"),
    )
)
_CONTENTS = "BVH, JSON or CSV of points, .skeleton, TRC, C3D, a .npy or .npz array, or an .npz file of AMASS"


def read_skeleton(
    path: Path | str,
    *,
    source: str | None = None,
    names: Mapping[str, str] | None = None,
    rate: float | None = None,
    units: str | None = None,
    up: str | None = None,
) -> Skeleton:
    """Return the skeleton in a file of motion capture, of a depth camera or of a pose estimator.

    Files are recognised by their content:

    - BVH, with any hierarchy, order of channels and names that the rule for names understands;
    - JSON of points, such as `{"times": [s …], "landmarks": [[[x, y, z, visibility] …] …]}`, null for a frame without a
      person, or a list of frames as MediaPipe, TensorFlow.js or Azure Kinect have them;
    - a folder of JSON files, one for each frame, as OpenPose and EasyMocap write them;
    - CSV with a column of times and columns such as SpineBase_X, left_wrist.y, z11 or left_wrist_visibility, or numbers
      alone: a frame or a point in each row;
    - .skeleton of NTU RGB+D, CSV of OptiTrack's Motive, TRC and C3D;
    - NumPy's .npy, shape (n, k, 3 or 4), or .npz with such an array, and an array `times` if it has one;
    - AMASS, .npz with `poses` (n, 66 or more), `trans` (n, 3) and `mocap_framerate`; the rotations of the joints turn
      the bones of the mean shape of SMPL.

    Args:
        path: the file, unpacked if its name ends in .gz, or the folder, or "-" for standard input.
        source: the order of points: "mediapipe", "kinect_v2", "kinect_v1", "msr", "azure_kinect", "nite", "kard",
            "cad60", "coco17", "coco18", "body25", "h36m17", "h36m32" or "smpl". None finds it by names, or by the
            number of points and the lengths of bones, and notes it.
        names: name of `POINTS` → joint of the file, where its name is another; "a + b" for the mean of two joints.
        rate: frames per second, 1 to 1000, of a file without times, or instead of its times.
        units: as in `Skeleton.from_landmarks`.
        up: as in `Skeleton.from_landmarks`.

    Raises:
        UnknownName: an unknown source, unit, axis, point or joint.
        BadInputFile: the file cannot be read, is malformed or incomplete, or its points are no skeleton. The message is
            one line, with the file and, for text, line and column.
        MissingExtra: the package c3d is not installed, which reads C3D.

    Examples:
        >>> wave = nk.imitation.read_skeleton(nk.imitation.SAMPLES["wave"])
        >>> wave.source, len(wave), wave.notes[1:]
        ('names', 65, ('y points up, by the direction of the trunk', 'unit cm, by the size of the trunk: 0.53 m'))
    """
    if source is not None:
        choice(source, LAYOUTS, "source")
    name, options = str(path), Options(source, names, rate, units, up)
    with errors_of(name):
        if name != "-" and Path(name).is_dir():
            return _of_folder(name, options)
        data = read_bytes(name)
        for first, what in _OTHERS:
            if first.match(data):
                raise BadInputFile(name, f"{what}; expected {_CONTENTS}")
        if data.startswith((b"\x93NUMPY", b"PK\x03\x04")):
            return _of_arrays(name, data, options)
        if re.match(rb"[\x01-\x08]\x50", data):
            return of_c3d(name, data, options)
        text = _text(name, data)
        start = text.lstrip()[:20].upper()
        if start.startswith("HIERARCHY") or name.lower().removesuffix(".gz").endswith(".bvh"):
            return of_bvh(name, text, options)
        if start.startswith(("{", "[")):
            return of_json(name, [text], options)
        readers = {"PATHFILETYPE": of_trc, "FORMAT VERSION": of_motive}
        for begin, reader in readers.items():
            if start.startswith(begin):
                return reader(name, text, options)
        return of_ntu(name, text, options) if is_ntu(text) else of_table(name, text, options)


def _text(name: str, data: bytes) -> str:
    try:
        text = data.decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")
    except UnicodeDecodeError as error:
        raise BadInputFile(name, f"not UTF-8 text (byte {error.start}); expected {_CONTENTS}") from None
    if not text.strip():
        raise BadInputFile(name, f"empty; expected {_CONTENTS}")
    return text


def _of_folder(name: str, options: Options) -> Skeleton:
    """Return the skeleton in the JSON files of a folder, one for each frame, in the order of their names."""
    files = sorted(Path(name).glob("*.json"), key=lambda file: [int(k) for k in re.findall("[0-9]+", file.stem)])
    if not files:
        raise BadInputFile(name, "a folder without JSON files; expected one for each frame, as OpenPose writes them")
    return of_json(name, [_text(str(file), read_bytes(str(file))) for file in files], options)


def _of_arrays(name: str, data: bytes, options: Options) -> Skeleton:
    """Return the skeleton in a .npy or .npz file, without unpickling anything."""
    if not data.startswith(b"PK"):
        array = read_arrays(name, data)[""]
        flat = array.ndim == 2 and array.shape[1] > 4 and array.dtype.kind == "f"
        return of_rows(name, array.astype(float), options) if flat else of_array(name, array, options)
    wanted = ("poses", "root_orient", "pose_body", "trans", "mocap_framerate", "mocap_frame_rate")
    amass = read_arrays(name, data, wanted)
    if "pose_body" in amass and "root_orient" in amass:  # SMPL-X, whose poses may be those of the face too
        amass.setdefault("poses", np.concatenate([amass["root_orient"], amass["pose_body"]], axis=-1))
    if "poses" in amass:
        return of_amass(name, amass, options)
    arrays = read_arrays(name, data)
    times = arrays.pop("times", None)
    points = [key for key, array in arrays.items() if array.ndim == 3]
    if len(points) != 1:
        listed = abbreviated(", ".join(f"{key} {array.shape}" for key, array in arrays.items()) or "none")
        raise BadInputFile(name, f"expected one array of points (n, k, 3 or 4), or poses of AMASS; arrays: {listed}")
    return of_array(name, arrays[points[0]], options, times=times)
