"""Frames of LoLA, decoded and encoded."""

from __future__ import annotations

import io
from contextlib import suppress

import numpy as np
import pytest
import umsgpack
from hypothesis import given, strategies as st

from nao_kin.errors import BadArgument, NaoKinError
from nao_kin.naoqi import decode_lola, encode_lola, lola_frames
from nao_kin.naoqi.live import LOLA_ENTRIES


def _frame(value: float = 0.25) -> dict[str, object]:
    frame: dict[str, object] = {name: np.full(count, value) for name, count in LOLA_ENTRIES.items()}
    frame["Status"] = np.arange(25.0)
    frame["Position"] = np.arange(25) / 8.0
    return {**frame, "RobotConfig": ("P0000074A03S8C700021", "6.0.0", "P0000074A05S98G00001", "6.0.0")}


def test_what_is_encoded_is_decoded_again() -> None:
    found = decode_lola(encode_lola(_frame()))
    assert found.keys() == _frame().keys()
    for name, values in _frame().items():
        assert np.array_equal(found[name], values), name


def test_numbers_travel_as_floats_of_32_bits_as_a_robot_sends_them() -> None:
    content = encode_lola({"Position": np.full(25, 0.1)})
    assert content == b"\x81\xa8Position\xdc\x00\x19" + 25 * b"\xca\x3d\xcc\xcc\xcd"
    assert np.array_equal(decode_lola(content)["Position"], np.full(25, np.float32(0.1), dtype=np.float64))


def test_a_frame_by_another_encoder_is_read() -> None:
    content = umsgpack.packb({"Position": [0] * 25, "Battery": [0.5, 16, -0.1, 30.0], "Unknown": {"x": 1}})
    found = decode_lola(content)
    assert found.keys() == {"Position", "Battery"}
    assert np.array_equal(found["Battery"], [0.5, 16.0, -0.1, 30.0])


def test_a_stream_gives_its_frames_in_order_and_what_is_cut_off_is_no_frame() -> None:
    frames = [encode_lola({"Position": np.full(25, float(i))}) for i in range(3)]
    stream = io.BytesIO(b"".join(frames) + frames[0][:40])
    assert [float(frame["Position"][0]) for frame in lola_frames(stream)] == [0.0, 1.0, 2.0]


def test_bytes_that_come_in_pieces_make_the_same_frames() -> None:
    class Slow(io.BytesIO):
        def read(self, count: int | None = -1, /) -> bytes:
            return super().read(min(3, count or 0))

    content = encode_lola(_frame()) * 2
    assert len(list(lola_frames(Slow(content)))) == 2


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "must be a MessagePack map"),
        (b"\xc1", "must be a MessagePack map"),
        (b"\x80", "must have the entry Position"),
        (b"\x91" * 5000, "must be a MessagePack map"),
        (b"\xdf\xff\xff\xff\xff", "must be a MessagePack map"),
        (umsgpack.packb({"Position": [0.0] * 24}), "Position must have shape"),
        (umsgpack.packb({"Position": [float("inf")] * 25}), "Position must be finite"),
        (umsgpack.packb({"Position": [0.0] * 25, "FSR": 3}), "FSR must be 8 numbers, got 3"),
        (umsgpack.packb({"Position": [0.0] * 25, "RobotConfig": [1, 2]}), "RobotConfig must be 4 texts"),
    ],
)
def test_what_is_no_frame_is_refused_in_one_line(content: bytes, message: str) -> None:
    with pytest.raises(NaoKinError, match=message) as error:
        decode_lola(content)
    assert "\n" not in str(error.value)


def test_a_number_beyond_every_float_is_no_frame_to_encode() -> None:
    with pytest.raises(BadArgument, match="Touch must be 14 numbers"):
        encode_lola({**_frame(), "Touch": 10**400})  # type: ignore[dict-item]


def test_a_stream_that_claims_endless_frames_is_not_read_to_its_end() -> None:
    class Endless(io.RawIOBase):
        read_bytes = 0

        def read(self, count: int = -1, /) -> bytes:
            self.read_bytes += count
            return (b"\xdd" if count == 1 else b"\xff" * 4) if self.read_bytes <= 5 else b"\x01" * count

    stream = Endless()
    with pytest.raises(BadArgument, match="bytes"):
        list(lola_frames(stream))
    assert stream.read_bytes < 70_000


@given(st.binary(max_size=200))
def test_any_bytes_are_a_frame_or_refused(content: bytes) -> None:
    with suppress(NaoKinError):
        decode_lola(content)


@given(st.integers(0, 700), st.integers(0, 255))
def test_a_damaged_frame_is_a_frame_or_refused(place: int, byte: int) -> None:
    content = bytearray(encode_lola(_frame()))
    content[place] = byte
    with suppress(NaoKinError):
        decode_lola(bytes(content))
