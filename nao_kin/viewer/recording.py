"""What is shown in a stretch of time, as a motion."""

from __future__ import annotations

import threading
import time

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin.motion import Motion
from nao_kin.robot import RobotModel

# With so many configurations a recording is thinned out. Of a NAO they take some 30 MB.
_MOST = 120_000


class Recording:
    """What a viewer shows between the beginning and the end of a `with` block.

    Attributes:
        robot: the robot that moves.
        fps: configurations kept per second, at most; halved whenever there are 120 000 of them, and those kept until
            then are thinned out to as few. At 30 an hour fits, and longer recordings need no more memory.

    Examples:
        >>> nao = nk.load_nao()
        >>> recording = nk.viewer.Recording(nao, nao.neutral(), fps=30.0)
        >>> recording.fps
        30.0
    """

    def __init__(self, robot: RobotModel, q: Floats, fps: float) -> None:
        self.robot, self.fps = robot, fps
        self._begin = time.monotonic()
        self._end: float | None = None
        self._times, self._rows = [0.0], [np.array(q)]
        self._lock = threading.Lock()

    @property
    def times(self) -> Floats:
        """When the configurations were shown, from 0, shape (n,) [s]."""
        with self._lock:
            return np.array(self._times)

    @property
    def q(self) -> Floats:
        """The configurations, shape (n, nq)."""
        with self._lock:
            return np.array(self._rows)

    @property
    def motion(self) -> Motion:
        """The joints as a motion, linear between the configurations kept; of a floating base only `q` tells."""
        with self._lock:
            times, rows = np.array(self._times), np.array(self._rows)
        names = self.robot.joint_names
        return Motion(times, names, rows[:, rows.shape[1] - len(names) :])

    def show(self, q: Floats) -> None:
        """Note that q is shown from now on.

        Examples:
            >>> nao = nk.load_nao()
            >>> recording = nk.viewer.Recording(nao, nao.neutral(), fps=30.0)
            >>> recording.show(nao.posture("Stand"))
        """
        with self._lock:
            if self._end is None:
                self._note(time.monotonic() - self._begin, np.array(q))

    def finish(self) -> None:
        """Note that what is shown was shown until now, and note no more; does nothing the second time.

        Examples:
            >>> nao = nk.load_nao()
            >>> recording = nk.viewer.Recording(nao, nao.neutral(), fps=30.0)
            >>> recording.finish()
            >>> recording.q.shape[1]
            25
        """
        with self._lock:
            if self._end is None:
                self._end = time.monotonic() - self._begin
                if self._end > self._times[-1]:
                    self._times.append(self._end)
                    self._rows.append(self._rows[-1])

    def _note(self, now: float, q: Floats) -> None:
        step = 1.0 / self.fps
        last = self._times[-1]
        if now - last > 2.0 * step:  # it stood still until just now
            self._times.append(now - step)
            self._rows.append(self._rows[-1])
        elif now - last < step and len(self._times) > 1:
            self._rows[-1] = q
            return
        if now <= self._times[-1]:  # the clock did not tick
            self._rows[-1] = q
            return
        self._times.append(now)
        self._rows.append(q)
        if len(self._times) >= _MOST:
            self._thin_out()

    def _thin_out(self) -> None:
        """Halve the pace until a quarter is free; what stood still goes on doing so."""
        while len(self._times) > 0.75 * _MOST:
            self.fps /= 2.0
            # Numbers of equal steps are compared, which are not equal to the last digit.
            longest = 1.01 / self.fps
            kept = [0]
            for index in range(1, len(self._times) - 1):
                if self._times[index + 1] - self._times[kept[-1]] > longest:
                    kept.append(index)
            kept.append(len(self._times) - 1)
            self._times, self._rows = [self._times[k] for k in kept], [self._rows[k] for k in kept]

    def __len__(self) -> int:
        return len(self._times)

    def __enter__(self) -> Recording:
        return self

    def __exit__(self, *_: object) -> None:
        self.finish()
