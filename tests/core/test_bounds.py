"""The door of all readers: arrays of bounded size, and the units and the duration of times."""

from __future__ import annotations

import io
import zipfile
from typing import Any

import numpy as np
import pytest

from nao_kin._core import files
from nao_kin._core.files import read_arrays
from nao_kin._core.headings import TIME_UNITS, seconds_of
from nao_kin.errors import BadInputFile

RNG = np.random.default_rng(5)


def saved(**arrays: Any) -> bytes:
    file = io.BytesIO()
    np.savez_compressed(file, **arrays)
    return file.getvalue()


@pytest.mark.parametrize("order", ["C", "F"])
def test_arrays_are_read_as_numpy_does(order: Any) -> None:
    points = np.asarray(RNG.normal(size=(4, 3, 2)), order=order)
    (given,) = read_arrays("a.npy", (file := io.BytesIO(), np.save(file, points))[0].getvalue()).values()
    assert np.array_equal(given, points)
    data = saved(points=points, names=np.array(["a", "bc"]), empty=np.zeros((0, 5)))
    with np.load(io.BytesIO(data)) as archive:
        expected = dict(archive)
    found = read_arrays("a.npz", data)
    assert found.keys() == expected.keys()
    assert all(np.array_equal(found[key], expected[key]) for key in found)


def test_only_what_is_wanted_is_unpacked_and_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(files, "MAX_BYTES", 10_000)
    data = saved(few=np.arange(3), many=np.zeros(5000), half=np.ones(900))
    assert [*read_arrays("a.npz", data, ("few", "half", "none"))] == ["few", "half"]
    with pytest.raises(BadInputFile, match="at most 10000 bytes"):
        read_arrays("a.npz", data)
    monkeypatch.setattr(files, "MAX_NUMBERS", 902)
    with pytest.raises(BadInputFile, match="903 numbers"):  # together
        read_arrays("a.npz", data, ("few", "half"))


def test_pickles_and_broken_archives_are_refused() -> None:
    whole = saved(a=np.arange(100.0))
    with zipfile.ZipFile(file := io.BytesIO(), "w") as archive:
        archive.writestr("readme.txt", "no array")
    for data in (
        saved(a=np.array([{}])),
        whole[:-40],
        whole[:60] + b"x" + whole[61:],
        file.getvalue(),
        b"",
        b"\x80\x04N.",
    ):
        with pytest.raises(BadInputFile, match=r"^a\.npz: no array of ours: "):
            read_arrays("a.npz", data, wrong="no array of ours")


# Rates and starts [s] of recordings: since a start, and since 1970.
@pytest.mark.parametrize("unit", ["s", "ms", "us", "ns"])
@pytest.mark.parametrize("start", [0.0, 37.0, 3e5, 1.1e9, 1.7e9])
@pytest.mark.parametrize("rate", [10.0, 29.97, 100.0, 500.0])
@pytest.mark.parametrize("frames", [False, True])
def test_times_of_a_recording_show_their_unit(unit: str, start: float, rate: float, frames: bool) -> None:
    steps = np.abs(1.0 + 0.1 * RNG.normal(size=400)) / rate
    seconds = start + np.cumsum(steps) - steps[0]
    written = seconds * TIME_UNITS[unit] if unit == "s" else np.rint(seconds * TIME_UNITS[unit])
    written = np.unique(written)
    found, note = seconds_of("a.csv", written, frames=frames)
    if not frames and unit == "ms" and start < 1e9 and rate >= 200.0:  # steps of 2, which keys may have, too
        assert np.array_equal(found, written)
        assert "taken as s, 2 s" in note
        return
    assert np.allclose(found, written / TIME_UNITS[unit], rtol=1e-12)
    assert (f"taken as {unit} " in note) == (unit != "s")
    assert bool(note) == (unit != "s")
    assert seconds_of("a.csv", written, unit, frames=frames)[1] == ""


def test_few_keys_are_in_seconds_however_far_apart_and_long_steps_are_noted() -> None:
    times = np.array([0.0, 2.5, 20.0, 30.0])
    found, note = seconds_of("a.csv", times)
    assert np.array_equal(found, times)
    assert "taken as s, 10 s" in note
    assert seconds_of("a.csv", times, "s") == (pytest.approx(times), "")
    assert seconds_of("a.csv", times / 20.0)[1] == ""


@pytest.mark.parametrize(
    ("times", "unit", "frames", "reason"),
    [
        ([0.0, 1e6], None, False, "a day"),
        ([0.0, 1e6], "s", False, "a day"),
        ([0.0, *(1.7e9 + 0.1 * np.arange(20))], None, True, "1.7e.09 s of them from 0 s"),
        ([0.0, 0.1, 0.1, 0.2], None, False, "time 2"),
        ([0.0, 0.1, 0.05], "s", True, "time 2"),
        (1e-5 * np.arange(20), None, True, "100000 frames per second"),
        (2.0 * np.arange(20), "s", True, "0.5 frames per second"),
        (np.array([0.0, 1e-300, 2e-300]), "s", True, "frames per second"),
    ],
)
def test_times_that_no_recording_has_are_refused(times: Any, unit: str | None, frames: bool, reason: str) -> None:
    with pytest.raises(BadInputFile, match=rf"^a\.csv: .*{reason}"):
        seconds_of("a.csv", np.asarray(times, dtype=np.float64), unit, frames=frames)


def test_one_time_and_none_are_no_reason_to_refuse() -> None:
    for count in (0, 1):
        found, note = seconds_of("a.csv", np.full(count, 3.0), frames=True)
        assert (len(found), note) == (count, "")
