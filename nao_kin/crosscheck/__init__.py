"""Proof by comparison: this library's conventions against those of Pinocchio, eigenpy and yourdfpy."""

from __future__ import annotations

from nao_kin.crosscheck._run import run
from nao_kin.crosscheck.by_hand import Step, steps_of, steps_of_nao
from nao_kin.crosscheck.report import Conversions, Place, Report, Row

__all__ = [
    "Conversions",
    "Place",
    "Report",
    "Row",
    "Step",
    "run",
    "steps_of",
    "steps_of_nao",
]
