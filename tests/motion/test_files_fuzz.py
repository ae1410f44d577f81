"""Motion files with something broken in them are read, or refused in one line; nothing else ever happens."""

from __future__ import annotations

import io
import random
import warnings
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

from nao_kin.errors import BadInputFile
from nao_kin.motion import FORMATS, Motion, read_motion

DATA = Path(__file__).parents[1] / "data" / "motions"
FORMAT_OF = {
    "wave.csv": "csv",
    "bezier.json": "json",
    "rows.json": "json",
    "holds.motion": "webots",
    "poses.pos": "runswift",
    "keyframes.json": "hulks",
    "frames.json": "hulks",
    "nod.motion2": "motion2",
    "simplified_export.txt": "python",
    "bezier_export.txt": "python",
    "timelines.xar": "xar",
    "arguments.json": "naoqi",
    "bezier_arguments.json": "naoqi",
    "motion.npz": "npz",
    "nod.kfm": "naodevils",
    "blocks.cfg": "bhuman",
    "library.xap": "xap",
}
# What a broken program, a wrong unit or an enemy might write.
WORDS = ["NaN", "nan", "inf", "-1", "0", "1e999", "9" * 400, "null", "true", '"x"', "[]", "{}", "", "*", ",", "'", '"']
WORDS += [*"[]()<>\\\x00\n\ufeff٣", "&x;", "<!DOCTYPE a>", "1_0", "0x1", "1.", ".5"]


def _content(name: str) -> bytes:
    if name != "motion.npz":
        return (DATA / name).read_bytes()
    file = io.BytesIO()
    arrays = {"joint_names": np.array(["HeadYaw", "LHand"]), "counts": np.array([2, 1])}
    np.savez(
        file, allow_pickle=False, times=np.arange(3.0), keys=np.zeros(3), interpolation=np.array("linear"), **arrays
    )
    return file.getvalue()


def _reads_or_refuses(path: Path, content: bytes, format: str | None) -> None:
    path.write_bytes(content)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for timeline in (None, 1):
            try:
                motion = read_motion(path, format=format, timeline=timeline)
            except BadInputFile as error:
                message = str(error)
                assert message.startswith(str(path))
                assert "\n" not in message
                assert len(message) < 1000
            else:
                assert isinstance(motion, Motion)
                assert all(np.isfinite(keys).all() for keys in motion.keys)
                assert all((np.diff(times) > 0.0).all() for times in motion.times)


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("fuzz") / "broken"


def test_every_format_is_broken_here() -> None:
    assert set(FORMAT_OF.values()) == set(FORMATS)


@pytest.mark.full
@pytest.mark.parametrize("name", FORMAT_OF)
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    changes=st.lists(st.tuples(st.floats(0, 1), st.sampled_from(WORDS), st.integers(0, 12)), min_size=1, max_size=3),
    known=st.booleans(),
)
def test_words_put_anywhere(path: Path, name: str, changes: list[tuple[float, str, int]], known: bool) -> None:
    content = _content(name)
    for share, word, removed in changes:
        at = int(share * len(content))
        content = content[:at] + word.encode() + content[at + removed :]
    _reads_or_refuses(path, content, FORMAT_OF[name] if known else None)


@pytest.mark.parametrize("name", FORMAT_OF)
@settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(seed=st.integers(0, 2**32))
def test_bytes_changed_at_random(path: Path, name: str, seed: int) -> None:
    rng = random.Random(seed)
    content = bytearray(_content(name))
    for _ in range(rng.choice([1, 3, 30])):
        content[rng.randrange(len(content))] = rng.randrange(256)
    _reads_or_refuses(path, bytes(content), FORMAT_OF[name])


@pytest.mark.parametrize("format", FORMATS)
def test_other_formats_files_are_refused_by_name_or_read(path: Path, format: str) -> None:
    for name in FORMAT_OF:
        _reads_or_refuses(path, _content(name), format)
