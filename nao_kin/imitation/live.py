"""A robot that follows a person while they move: one frame in, one configuration out."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import Floats, check_tolerance, choice, flag, shaped, single_number
from nao_kin.errors import BadArgument
from nao_kin.imitation.arms import places_of_hands
from nao_kin.imitation.bones import believed
from nao_kin.imitation.directions import Directions, mirrored
from nao_kin.imitation.imitate import start_of
from nao_kin.imitation.layouts import LAYOUTS, POINTS, by_joint, landmark_array
from nao_kin.imitation.limbs import LimbMap, checked_weights
from nao_kin.imitation.skeleton import UP_AXES, Points, axis_matrix, check_points
from nao_kin.robot import RobotModel

# After a pause of this length [s] every joint may be anywhere.
_LONGEST = 1e6


class Imitator:
    """A robot's arms and head that follow a person's, frame by frame.

    It keeps the last configuration and the last smoothed points. Directions, mirror and weights are those of `imitate`,
    with the cost of one frame and the step to it; legs do not move, and links may overlap: NAOqi itself stops arms
    before they touch the body.

    Args:
        robot: a NAO of any version, or another robot with arms and a neck of its geometry.
        source: of the arrays that `step` takes, "mediapipe", "kinect_v2", "azure_kinect" …, as in
            `Skeleton.from_landmarks`. The axes of "coco17", "h36m17" and "smpl" differ from program to program: `up`
            states them.
        arms: whether arms move.
        head: whether the head moves.
        mirror: whether the robot is the person's mirror image.
        up: the axis of the source that points up, "z", "y", "-y" …; None for that of the source.
        cutoff: the frequency [Hz] above which motion of the points is damped, by a low-pass filter of first order,
            which delays slow motion by 1 / (2π · cutoff); 0 for none.
        weights: as in `imitate`.

    Attributes:
        joints: the joints that move.

    Raises:
        UnknownName: an unknown source, axis or weight.
        BadArgument: the robot has no arms or neck of this geometry, or a number is below zero; `up` is not stated.

    Examples:
        >>> nao = nk.load_nao()
        >>> follower = nk.imitation.Imitator(nao, "mediapipe")
        >>> landmarks = np.random.default_rng(1).normal(size=(33, 4))
        >>> follower.step(landmarks, 0.0).shape
        (25,)
    """

    def __init__(
        self,
        robot: RobotModel,
        source: str = "mediapipe",
        *,
        arms: bool = True,
        head: bool = True,
        mirror: bool = False,
        up: str | None = None,
        cutoff: float = 4.0,
        weights: Mapping[str, float] | None = None,
    ) -> None:
        self._layout = LAYOUTS[choice(source, LAYOUTS, "source")]
        known = self._layout.axes
        if up is None and (known is None or "±" in known[1]):
            raise BadArgument(f'{source} has no fixed axes; state the one that points up, such as up="z"')
        axes = known if up is None else UP_AXES[choice(up, UP_AXES, "axis")]
        check_tolerance(cutoff, "cutoff")
        self._map, self._weights, self._cutoff = LimbMap(robot), checked_weights(weights), float(cutoff)
        self._parts = {"arms": flag(arms, "arms"), "head": flag(head, "head")}
        self._mirror = flag(mirror, "mirror")
        self.joints = self._map.joints
        self._q = start_of(robot)
        self._turn = axis_matrix(axes or ())
        self._names: tuple[str, ...] = ()
        self._points = np.empty((0, 3))
        self._time = -math.inf
        self._speeds = np.array([robot.joints.limits(name)[2] for name in self.joints])

    @property
    def q(self) -> Floats:
        """The last configuration, shape (nq,); that of the posture "StandInit" at first."""
        return self._q.copy()

    def step(self, frame: ArrayLike | Mapping[str, ArrayLike], time: float) -> Floats:
        """Return the configuration for a frame, no farther from the last one than the joints move in the time between.

        The first frame is where the time begins, and returns the posture at the start.
        Points that are NaN, or have a confidence below 0.5, keep their last place; without any, so does the robot.

        Args:
            frame: points in the order of the source, shape (k, 3) or (k, 4), the fourth entry the confidence; or name
                of `POINTS` → (3,), in a right-handed frame with z up. In any unit, which must not change. Other names
                than those of the last frame begin anew: nothing is known of their last places.
            time: of the frame, later than that of the last one [s].

        Raises:
            WrongShape: the frame has another shape.
            UnknownName: a name is not in `POINTS`.
            BadArgument: the time is not later.

        Examples:
            >>> nao = nk.load_nao()
            >>> follower = nk.imitation.Imitator(nao)
            >>> shoulders = {"left_shoulder": [0.0, 0.19, 0.5], "right_shoulder": [0.0, -0.19, 0.5]}
            >>> arm = {"left_elbow": [0.0, 0.47, 0.5], "left_wrist": [0.0, 0.47, 0.75]}
            >>> points = {**shoulders, **arm, "pelvis": [0.0, 0.0, 0.0]}
            >>> start, end = follower.step(points, 0.0), follower.step(points, 2.0)
            >>> round(float(end[nao.joint_names.index("LShoulderRoll")]), 2)  # of an arm out to the side, 76° at most
            1.33
        """
        now = single_number(time, "time")
        if not self._time < now < math.inf:
            raise BadArgument(f"time must be later than {self._time:g} s, that of the last frame, got {now:g}")
        names, points = self._named(frame)
        # The first frame moves nothing, for there is no time to do so.
        passed, self._time = (min(now - self._time, _LONGEST) if self._time > -math.inf else 0.0), now
        if names != self._names:
            self._names, self._points = names, points
        else:
            share = 1.0 - math.exp(-2.0 * math.pi * self._cutoff * passed) if self._cutoff > 0.0 else 1.0
            moved = self._points + share * (points - self._points)
            # A point that was unknown is not filtered, one that is unknown stays.
            moved = np.where(np.isnan(self._points), points, moved)
            self._points = np.where(np.isnan(moved), self._points, moved)
        named = {name: self._points[None, k] for k, name in enumerate(self._names)}
        if self._mirror:
            named, _ = mirrored(named, {})
        person = Directions.of(named).only(**self._parts)
        places = places_of_hands(self._map, named, person)
        found = self._map.solve(person, self._q, seconds=[passed], weights=self._weights, places=places)[0]
        columns, most = self._map.columns, self._speeds * passed
        step = found[columns] - self._q[columns]
        # All joints slow down alike, which keeps the way to the goal straight.
        slower = float(np.max(np.abs(step) / np.maximum(most, 1e-12), initial=1.0))
        self._q[columns] += step / slower
        if slower > 1.0:
            self._q = self._map.robot.clamp(self._q)  # the range of a coupled limit is not convex
        return self.q

    def _named(self, frame: ArrayLike | Mapping[str, ArrayLike]) -> tuple[tuple[str, ...], Floats]:
        """Return the names of `POINTS` that a frame gives, in their order, and their places in the world's axes."""
        if isinstance(frame, Mapping):
            for name in frame:
                choice(name, POINTS, "point")
            points = {name: shaped(frame[name], (3,), name, gaps=True) for name in POINTS if name in frame}
            check_points({name: point[None] for name, point in points.items()})
            return tuple(points), np.array([*points.values()])
        joints, sure = by_joint(landmark_array([frame], self._layout), self._layout)
        known = believed(*Points(joints, sure, self._layout).named())
        return tuple(known), np.concatenate([*known.values()]) @ self._turn.T
