"""ALVideoDevice: pictures from a function, in NAOqi's resolutions and colour spaces, to scripts and over qi."""

from __future__ import annotations

import threading
import time
from typing import Any

import numpy as np
import pytest

import nao_kin as nk
from nao_kin.errors import BadArgument
from nao_kin.naoqi import QiServer, State, VirtualNao
from nao_kin.naoqi.virtual import NaoqiError

# Red, green, blue, grey, from left to right, and their luma and chroma by the definition, rounded (ITU-T T.871).
COLOURS = np.array([[255, 0, 0], [0, 255, 0], [0, 0, 255], [128, 128, 128]], dtype=np.uint8)
YUV = [[76, 85, 255], [150, 44, 21], [29, 255, 107], [128, 128, 128]]


def _stripes(state: State, camera: str, size: tuple[int, int]) -> Any:
    """Return four stripes, the colours in the reverse order for the bottom camera."""
    row = np.repeat(COLOURS if camera == "CameraTop" else COLOURS[::-1], size[0] // 4, axis=0)
    return np.broadcast_to(row, (size[1], *row.shape))


def _video(nao: VirtualNao, method: str, *arguments: Any) -> Any:
    return nao.call("ALVideoDevice", method, *arguments)


def test_pictures_are_in_the_resolution_and_the_colour_space_asked_for(nao: nk.NaoModel) -> None:
    with VirtualNao(nao, stepped=True, pictures=_stripes) as robot:
        robot.step(1.25)
        handle = _video(robot, "subscribe", "mine", 0, 11, 5)
        answer = _video(robot, "getImageRemote", handle)
        half = 0.5 * np.array(nao.semantics.fields_of_view["CameraTop"])
        assert answer[:6] == [160, 120, 3, 11, 1, 250_000]
        assert answer[7] == 0
        assert np.allclose(answer[8:], [*half, *-half])
        rgb = np.frombuffer(answer[6], np.uint8).reshape(120, 160, 3)
        assert np.array_equal(rgb[0, ::40], COLOURS)
        assert np.array_equal(rgb, _stripes(robot.state(), "CameraTop", (160, 120)))
        found = {}
        for space, layers in ((0, 1), (9, 2), (10, 3), (13, 3)):
            _video(robot, "setColorSpace", handle, space)
            answer = _video(robot, "getImageLocal", handle)
            assert answer[2:4] == [layers, space]
            assert _video(robot, "releaseImage", handle)
            found[space] = np.frombuffer(answer[6], np.uint8).reshape(120, 160, layers)[7]
        assert np.array_equal(found[13][::40], COLOURS[:, ::-1])
        yuv = found[10][::40].astype(int)
        assert np.abs(yuv - YUV).max() <= 1  # rounded by other arithmetic
        assert np.array_equal(found[0][::40, 0], yuv[:, 0])
        assert np.array_equal(found[9].reshape(80, 4)[::20], yuv[:, [0, 1, 0, 2]])
        assert _video(robot, "setResolution", handle, 7)
        assert _video(robot, "getImageRemote", handle)[:2] == [80, 60]
        assert _video(robot, "setFrameRate", handle, 15)


def test_a_subscriber_sees_its_camera_or_the_active_one(nao: nk.NaoModel) -> None:
    with VirtualNao(nao, stepped=True, pictures=_stripes) as robot:
        active, bottom = _video(robot, "subscribe", "a", 8, 11, 5), _video(robot, "subscribeCamera", "a", 1, 8, 11, 5)
        assert (active, bottom) == ("a_0", "a_1")

        def seen(handle: str) -> tuple[int, bool]:
            answer = _video(robot, "getImageRemote", handle)
            return answer[7], answer[6][:3] == bytes(COLOURS[0])

        assert (seen(active), seen(bottom)) == ((0, True), (1, False))
        _video(robot, "setParam", 18, 1)
        assert (seen(active), _video(robot, "getActiveCamera"), _video(robot, "getParam", 18)) == ((1, False), 1, 1)
        _video(robot, "setActiveCamera", 0)
        assert seen(active) == (0, True)
        _video(robot, "setParam", 0, 55)
        assert (_video(robot, "getParam", 0), _video(robot, "getParameter", 0, 0)) == (55, 55)
        assert (_video(robot, "getParameter", 1, 0), _video(robot, "getCameraIndexes")) == (0, [0, 1])
        _video(robot, "unsubscribe", bottom)
        assert _video(robot, "subscribe", "a", 8, 11, 5) == "a_1"
        _video(robot, "unsubscribeAllInstances", "a")
        with pytest.raises(NaoqiError, match="unknown handle 'a_0'"):
            seen(active)


@pytest.mark.parametrize(
    ("method", "given", "words"),
    [
        ("subscribe", ("b", 14, 11, 5), r"Resolution 14 is not in this virtual NAO; there are: 0 \(160 x 120\), 1 "),
        ("subscribe", ("b", 2, 12, 5), r"ColorSpace 12 .*there are: 0 \(Yuv\), 9 \(YUV422\), 10 "),
        ("subscribeCamera", ("b", 2, 2, 11, 5), r"CameraIndex 2 .*0 \(top\), 1 \(bottom\)"),
        ("setParam", (18, 3), "camera 3 "),
        ("setParameter", (0, 0, 1e300), "a number of 32 bits, got 1e"),
        ("unsubscribe", ("b_3",), "nearest: a_3"),
        ("subscribe", ("a", 2, 11, 5), "'a' has subscribed 8 times"),
    ],
)
def test_what_the_cameras_lack_is_refused(nao: nk.NaoModel, method: str, given: tuple[Any, ...], words: str) -> None:
    with VirtualNao(nao, stepped=True) as robot:
        for _ in range(8):
            _video(robot, "subscribe", "a", 0, 11, 5)
        with pytest.raises(NaoqiError, match=words):
            _video(robot, method, *given)


def test_a_function_that_fails_fails_one_call(nao: nk.NaoModel) -> None:
    wrong = [np.zeros((120, 160, 4), np.uint8), np.zeros((120, 160, 3)), None]

    def pictures(*_: Any) -> Any:
        drawn = wrong.pop()
        if drawn is None:
            raise BadArgument("no browser")
        return drawn

    with VirtualNao(nao, stepped=True, pictures=pictures) as robot:
        handle = _video(robot, "subscribe", "a", 0, 11, 5)
        for words in ("no browser", r"\(120, 160, 3\), got float64", r"got uint8 of \(120, 160, 4\)"):
            with pytest.raises(NaoqiError, match=f"getImageRemote\n\t.*{words}"):
                _video(robot, "getImageRemote", handle)
    with VirtualNao(nao, stepped=True) as blind:
        handle = _video(blind, "subscribe", "a", 0, 11, 5)
        with pytest.raises(NaoqiError, match="give VirtualNao a function that draws, pictures="):
            _video(blind, "getImageRemote", handle)


def test_bytes_arrive_over_qi_while_the_robot_moves(nao: nk.NaoModel) -> None:
    qi = pytest.importorskip("qi")
    moved = threading.Event()

    def pictures(state: State, camera: str, size: tuple[int, int]) -> Any:
        assert moved.wait(20.0)  # another call is answered while a picture is drawn
        return _stripes(state, camera, size)

    with VirtualNao(nao, pictures=pictures) as robot, QiServer(robot, port=0, quiet=True) as server:
        session = qi.Session()
        session.connect(server.endpoint)
        video, motion = session.service("ALVideoDevice"), session.service("ALMotion")
        handle = video.subscribe("mine", 8, 11, 5)
        begin = robot.clock.now
        future = video.getImageRemote(handle, _async=True)
        motion.setStiffnesses("Head", 1.0)
        while robot.clock.now < begin + 0.05:
            time.sleep(0.005)
        moved.set()
        answer = future.value()
        assert bytes(answer[6]) == _stripes(robot.state(), "CameraTop", (40, 30)).tobytes()
        assert list(answer[:4]) == [40, 30, 3, 11]
        session.close()
