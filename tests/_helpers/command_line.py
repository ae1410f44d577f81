"""Run commands of `nao-kin` in this process and return their output or their error line."""

from __future__ import annotations

import pytest

from nao_kin.cli.app import run

Capture = pytest.CaptureFixture[str]


def said(command: str, capsys: Capture, *arguments: str) -> str:
    """Return the output of a command that prints nothing on standard error."""
    assert run([command, *arguments]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    return str(out)


def said_with_notes(command: str, capsys: Capture, *arguments: str) -> tuple[str, str]:
    """Return the output of a command, and its notes on standard error."""
    assert run([command, *arguments]) == 0
    out, err = capsys.readouterr()
    return str(out), str(err)


def refused(command: str, capsys: Capture, *arguments: str) -> str:
    """Return the single error line of a command that refuses its input."""
    return refused_line(capsys, command, *arguments)


def refused_line(capsys: Capture, *arguments: str) -> str:
    """Return the single error line of words that are refused."""
    assert run(arguments) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("nao-kin: ")
    assert err.count("\n") == 1
    return str(err)
