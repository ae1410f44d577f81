"""The frames of a robot by name."""

from __future__ import annotations

from collections.abc import Sequence
from types import MappingProxyType

import pinocchio as pin

from nao_kin._common.warn import warn_caller
from nao_kin._text import quoted
from nao_kin.errors import RenamedFrameWarning, UnknownName
from nao_kin.robot.questions import FrameIds
from nao_kin.urdf import UrdfTree


class FrameTable:
    """Frame name → id in a Pinocchio model.

    The frames of fixed joints are left out, for the links they hold stand at the same place. A name that the URDF gives
    to a link and to a joint means the link, as in every tool that knows links only. Where the joint's own frame is
    another one, whoever asks for the name is warned once: the joint's frame goes by the name of the link it moves.

    Attributes:
        names: every name, in the order of the model.
        places: name → id, in the same order.
        link_names: the links.
    """

    def __init__(self, model: pin.Model, tree: UrdfTree) -> None:
        frames = list(model.frames)
        links: dict[str, int] = {
            frame.name: index for index, frame in enumerate(frames) if frame.type == pin.FrameType.BODY
        }
        joints: dict[str, int] = {
            frame.name: index
            for index, frame in enumerate(frames)
            if index > 0 and frame.type not in (pin.FrameType.BODY, pin.FrameType.FIXED_JOINT)
        }
        self._ids = {name: links[link] for name, link in tree.shared_names.items()} | links
        moved = {joint.name: joint.child for joint in tree.moving_joints}
        # Shared name → the link it means, and the link that has the joint's frame.
        self._ambiguous = {
            name: (link, moved[name])
            for name, link in tree.shared_names.items()
            if name in moved and moved[name] != link
        }
        for name, index in joints.items():
            self._ids.setdefault(name, index)
        order = self._ids | joints
        self.names = tuple(sorted(self._ids, key=order.__getitem__))
        self.places = MappingProxyType({name: self._ids[name] for name in self.names})
        self.link_names = tuple(links)
        self._link_ids = tuple(links.values())
        self._sets: dict[tuple[str, ...], FrameIds] = {}

    def id(self, name: object) -> int:
        """The frame called `name`.

        Raises:
            UnknownName: there is none.
        """
        if not isinstance(name, str) or name not in self._ids:
            raise UnknownName("frame", name, self.names)
        if name in self._ambiguous and (frames := self._ambiguous.pop(name, None)):  # another thread may be quicker
            link, moved = frames
            warn_caller(
                f"frame {quoted(name)}: the URDF has a link and a joint of this name. This is the link's frame "
                f"({quoted(link)}); the joint's own frame is {quoted(moved)}",
                RenamedFrameWarning,
            )
        return self._ids[name]

    def ids(self, names: Sequence[str] | None) -> FrameIds:
        """The frames of these names; all links for None.

        Raises:
            UnknownName: there is no such frame, or `names` are no names.
        """
        if names is None:
            return self._link_ids
        try:
            key = tuple(names)
        except TypeError:  # one thing that is no name, where several names are expected
            raise UnknownName("frame", names, self.names) from None
        try:
            return self._sets[key]
        except (TypeError, KeyError):  # no names, or names asked for the first time
            pass
        found = tuple(self.id(name) for name in key)
        if len(self._sets) > 1000:
            self._sets.clear()
        self._sets[key] = found
        return found
