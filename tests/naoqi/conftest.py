"""A virtual NAO, stepped by hand: asleep, awake, and as a script that calls ALMotion sees it."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from naoqi_script import Script

import nao_kin as nk
from nao_kin.naoqi.virtual import VirtualNao


@pytest.fixture
def asleep(nao: nk.NaoModel) -> Iterator[VirtualNao]:
    with VirtualNao(nao, stepped=True) as made:
        yield made


@pytest.fixture
def awake(asleep: VirtualNao) -> VirtualNao:
    asleep.call("ALMotion", "wakeUp")
    return asleep


@pytest.fixture
def script() -> Iterator[Script]:
    with Script() as made:
        yield made
