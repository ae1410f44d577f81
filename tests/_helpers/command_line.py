"""A command of `nao-kin` run in this process: what it says, or the line in which it refuses."""

from __future__ import annotations

import pytest

from nao_kin.cli.app import run


def said(command: str, capsys: pytest.CaptureFixture, *arguments: str) -> str:
    """What a command prints that has nothing to say beside it."""
    assert run([command, *arguments]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    return str(out)


def refused(command: str, capsys: pytest.CaptureFixture, *arguments: str) -> str:
    """The one line of a command that does nothing."""
    assert run([command, *arguments]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("nao-kin: ")
    assert err.count("\n") == 1
    return str(err)
