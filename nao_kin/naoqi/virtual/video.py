"""ALVideoDevice: pictures of the cameras, which a function draws, as NAOqi sends them."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import choice
from nao_kin._core.text import quoted
from nao_kin.errors import BadArgument
from nao_kin.naoqi.virtual.arguments import Number, Text, Whole, whole
from nao_kin.naoqi.virtual.engine import Call, NaoqiError
from nao_kin.naoqi.virtual.machine import Machine
from nao_kin.naoqi.virtual.service import Service

Pixels = NDArray[np.uint8]

# Width and height by resolution; names of the colour spaces that are drawn here; the parameter "kCameraSelectID".
_SIZES = {0: (160, 120), 1: (320, 240), 2: (640, 480), 3: (1280, 960), 7: (80, 60), 8: (40, 30)}
_SPACES = {0: "Yuv", 9: "YUV422", 10: "YUV", 11: "RGB", 13: "BGR"}
_SELECT = 18
_HANDLES = 8  # of one name


def _numbered(value: object, what: str, *, names: Mapping[int, str]) -> int:
    number = whole(value, what)
    if number not in names:
        there = ", ".join(f"{at} ({name})" for at, name in names.items())
        raise BadArgument(f"{what} {number} is not in this virtual NAO; there are: {there}")
    return number


_camera = partial(_numbered, names={0: "top", 1: "bottom"})
CameraIndex = Annotated[int, _camera]
Resolution = Annotated[int, partial(_numbered, names={n: f"{w} x {h}" for n, (w, h) in _SIZES.items()})]
ColorSpace = Annotated[int, partial(_numbered, names=_SPACES)]


@dataclass
class _Subscriber:
    camera: int | None  # None: the active one
    resolution: int
    space: int
    fps: int


class ALVideoDevice(Service):
    """Pictures of the cameras; `VirtualNao(pictures=…)` draws them.

    The parameters of the cameras are stored, without effect, except which camera is active.

    Source: Aldebaran documentation 1.14 and 2.5, ALVideoDevice.
    """

    name = "ALVideoDevice"

    def __init__(self, nao: Machine) -> None:
        super().__init__(nao)
        self._subscribers: dict[str, _Subscriber] = {}
        self._active = 0

    # --- subscribers ----------------------------------------------------------------------------------------------

    def subscribeCamera(
        self, Name: Text, CameraIndex: CameraIndex, Resolution: Resolution, ColorSpace: ColorSpace, Fps: Whole
    ) -> str:
        """Subscribe to a camera; returns the handle, name_0 to name_7, for the other methods."""
        return self._add(Name, _Subscriber(CameraIndex, Resolution, ColorSpace, Fps))

    def subscribe(self, Name: Text, Resolution: Resolution, ColorSpace: ColorSpace, Fps: Whole) -> str:
        """Subscribe to the camera that is active when a picture is asked for."""
        return self._add(Name, _Subscriber(None, Resolution, ColorSpace, Fps))

    def _add(self, name: str, subscriber: _Subscriber) -> str:
        handles = (f"{name}_{number}" for number in range(_HANDLES))
        handle = next((one for one in handles if one not in self._subscribers), None)
        if handle is None:
            raise BadArgument(f"{quoted(name)} has subscribed {_HANDLES} times; unsubscribe the handles first")
        self._subscribers[handle] = subscriber
        return handle

    def unsubscribe(self, Handle: Text) -> None:
        """End a subscription."""
        del self._subscribers[choice(Handle, self._subscribers, "handle")]

    def unsubscribeAllInstances(self, Name: Text) -> None:
        """End all subscriptions of a name."""
        kept = {handle: one for handle, one in self._subscribers.items() if handle.rpartition("_")[0] != Name}
        self._subscribers = kept

    def _of(self, handle: str) -> _Subscriber:
        return self._subscribers[choice(handle, self._subscribers, "handle")]

    def setResolution(self, Handle: Text, Resolution: Resolution) -> bool:
        """Set the resolution of a subscriber."""
        self._of(Handle).resolution = Resolution
        return True

    def setColorSpace(self, Handle: Text, ColorSpace: ColorSpace) -> bool:
        """Set the colour space of a subscriber."""
        self._of(Handle).space = ColorSpace
        return True

    def setFrameRate(self, Handle: Text, Fps: Whole) -> bool:
        """Store the frame rate of a subscriber."""
        self._of(Handle).fps = Fps
        return True

    # --- cameras --------------------------------------------------------------------------------------------------

    def getCameraIndexes(self) -> list[int]:
        """[0, 1]: the top and the bottom camera."""
        return [0, 1]

    def setActiveCamera(self, CameraIndex: CameraIndex) -> bool:
        """Choose the camera of subscribers that did not name one."""
        self._active = CameraIndex
        return True

    def getActiveCamera(self) -> int:
        """The active camera; initially 0."""
        return self._active

    def setParameter(self, CameraIndex: CameraIndex, Id: Whole, NewValue: Number) -> bool:
        """Store a camera's parameter, a number of 32 bits."""
        if not -(2**31) <= NewValue < 2**31:
            raise BadArgument(f"NewValue must be a number of 32 bits, got {NewValue:g}")
        self.stored[CameraIndex, Id] = int(NewValue)
        return True

    def getParameter(self, CameraIndex: CameraIndex, Id: Whole) -> int:
        """The stored value; initially 0."""
        return int(self.stored.get((CameraIndex, Id), 0))

    def setParam(self, Id: Whole, NewValue: Number) -> None:
        """Choose the active camera, with 18, or store a parameter of the active camera."""
        if Id == _SELECT:
            self.setActiveCamera(_camera(NewValue, "camera"))
        else:
            self.setParameter(self._active, Id, NewValue)

    def getParam(self, Id: Whole) -> int:
        """The active camera, with 18, or the stored value of its parameter."""
        return self._active if Id == _SELECT else self.getParameter(self._active, Id)

    # --- pictures -------------------------------------------------------------------------------------------------

    def getImageRemote(self, Handle: Text) -> Call:
        """Draw a picture of the robot at this moment.

        Returns [width, height, layers, colour space, seconds, microseconds, bytes, camera, left, top, right, bottom],
        with the time of the robot and the angles [rad] of the edges, those on the left and at the top positive.
        """
        subscriber = self._of(Handle)
        camera = self._active if subscriber.camera is None else subscriber.camera
        name, call = self.nao.robot.semantics.cameras[camera], Call()
        seconds, microseconds = divmod(round(1e6 * self.nao.clock.now), 1_000_000)
        width, height = _SIZES[subscriber.resolution]
        half_width, half_height = (0.5 * angle for angle in self.nao.robot.semantics.fields_of_view[name])

        def draw() -> None:
            try:
                pixels = _in_space(self.nao.picture(name, (width, height)), subscriber.space)
            except Exception as error:  # of a user's function, or no browser
                call.fail(NaoqiError(self.name, "getImageRemote", str(error) or repr(error)))
                return
            size = [width, height, pixels.shape[-1], subscriber.space, seconds, microseconds]
            call.finish([*size, pixels.tobytes(), camera, half_width, half_height, -half_width, -half_height])

        # Only when the lock is free, so that the robot's time runs on; a time that is stepped waits for the picture.
        start = draw if self.nao.stepped else threading.Thread(target=draw, daemon=True).start
        self.nao.monitor.later(start)
        return call

    getImageLocal = getImageRemote

    def releaseImage(self, Handle: Text) -> bool:
        """Without effect: pictures are copies."""
        self._of(Handle)
        return True


def _in_space(rgb: Pixels, space: int) -> Pixels:
    """Return a picture, shape (height, width, 3), in a colour space, shape (height, width, layers).

    Y, U and V are those of JPEG's YCbCr (ITU-T T.871). YUV422 has Y U of even and Y V of odd columns.
    """
    if space == 11:
        return rgb
    if space == 13:
        return rgb[..., ::-1]
    from PIL import Image

    yuv = np.asarray(Image.fromarray(rgb).convert("YCbCr"))
    if space == 10:
        return yuv
    if space == 0:
        return yuv[..., :1]
    paired = np.array(yuv[..., :2])
    paired[:, 1::2, 1] = yuv[:, 1::2, 2]
    return paired
