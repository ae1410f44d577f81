from __future__ import annotations

import pytest
from hypothesis import settings

import nao_kin as nk
from nao_kin.parameters import VERSIONS

settings.register_profile("nao_kin", derandomize=True, deadline=None, max_examples=60)
settings.load_profile("nao_kin")


@pytest.fixture(scope="session")
def nao() -> nk.NaoModel:
    return nk.load_nao("v6")


@pytest.fixture(scope="session", params=VERSIONS)
def each_nao(request: pytest.FixtureRequest) -> nk.NaoModel:
    return nk.load_nao(request.param)
