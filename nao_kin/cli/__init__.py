"""The command line: one thin command per capability."""

from nao_kin.cli.app import main

__all__ = ["main"]
