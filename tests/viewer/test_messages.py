"""The table of messages agrees with the messages that the viewer sends and with those that the page reads."""

from __future__ import annotations

import re
from collections import defaultdict
from pathlib import Path

import numpy as np
import pytest
import umsgpack

import nao_kin as nk
from nao_kin.viewer import Viewer
from nao_kin.viewer.messages import BLANKS, KINDS, ROWS

HANDLERS = Path(__file__).resolve().parents[2] / "web" / "src" / "messages.ts"
# A handler: its kind, and the fields that it takes apart; none where it hands the whole message on.
_HANDLER = re.compile(r"^  (\w+): \((?:app|\{[^}]*\})(?:, (?:message|\{ ([^}]*) \}))?\) =>", re.M)


@pytest.fixture(scope="module")
def sent(nao: nk.NaoModel) -> dict[str, list[dict[str, object]]]:
    """Return the messages, by kind, of a viewer that shows everything."""
    found: dict[str, list[dict[str, object]]] = defaultdict(list)
    viewer = Viewer(nao)

    def take(content: bytes | None) -> None:
        message = umsgpack.unpackb(content)
        if message["type"] == "nao_kin":
            found[message["kind"]].append(message)

    for content in (*viewer._messages.messages(), *BLANKS.values()):
        take(content)
    viewer._messages.watch(lambda key: take(viewer._messages.get(key)))
    viewer.animate(nao.random(1, 2))
    viewer.display(nao.posture("Sit"), up=[0.0, 0.0, 1.0])
    viewer.camera("front")
    viewer.show_frames(["LArm"])
    viewer.show_com()
    viewer.show_collisions()
    viewer.show_ghosts(nao.random(1, 2))
    viewer.show_targets({"cup": [0.2, 0.1, 0.1]})
    viewer.color_links({"Head": 0.1, "torso": 0.2})
    viewer.show_lights({"Chest": [1.0, 0.0, 0.0]})
    viewer.show_reach(nk.reach.workspace(nao, "LArm", 200, voxel=0.1))
    viewer.add_points("points", [[0.0, 0.0, 0.1]])
    viewer.add_mesh("mesh", np.eye(3), [[0, 1, 2]])
    viewer.add_line("line", np.eye(3))
    viewer.add_arrow("arrow", np.zeros(3), np.ones(3))
    viewer.add_label("label", "here", np.zeros(3))
    viewer.add_robot(nao).remove()
    viewer.add_text("state")
    viewer.show_image("CameraTop", np.zeros((2, 2), np.uint8))
    viewer.plot("force", 1.0)
    return found


def _fields(kind: str) -> tuple[set[str], set[str]]:
    """The fields that a message of this kind must have, and all that it may have."""
    names = KINDS[kind].fields
    return {name for name in names if not name.endswith("?")}, {name.rstrip("?") for name in names}


def test_every_message_that_is_kept_for_later_pages_is_of_the_table(sent: dict[str, list[dict[str, object]]]) -> None:
    assert sent.keys() == KINDS.keys() - {"capture", "film", "version", "complete"}


def test_every_message_has_the_fields_of_its_kind(sent: dict[str, list[dict[str, object]]]) -> None:
    for kind, messages in sent.items():
        needed, known = _fields(kind)
        written = [message.keys() - {"type", "kind"} for message in messages]
        assert all(needed <= fields <= known for fields in written), kind
        assert set[str]().union(*written) == known, kind


def test_a_robot_is_described_by_the_rows_of_the_table(sent: dict[str, list[dict[str, object]]]) -> None:
    def check(type_: str, value: object) -> None:
        name = type_.removesuffix("[]")
        if name not in ROWS:
            return
        for row in value if type_ != name else [value]:
            fields = ROWS[name] | (ROWS["Driven"] if name == "JointAbout" else {})
            assert row.keys() == fields.keys(), name
            for field, kind in fields.items():
                check(kind, row[field])

    for message in sent["model"]:
        check("About", message["about"])


def test_the_page_takes_every_kind_of_message_and_no_fields_that_are_not_sent() -> None:
    handlers = dict(_HANDLER.findall(HANDLERS.read_text(encoding="utf-8")))
    assert handlers.keys() == KINDS.keys()
    for kind, fields in handlers.items():
        assert set(re.findall(r"\w+", fields)) <= _fields(kind)[1], kind


def test_what_takes_a_message_away_has_its_fields() -> None:
    for kind, row in KINDS.items():
        if row.blank is not None:
            needed, known = _fields(kind)
            assert needed <= row.blank.keys() <= known, kind
