"""Comparison of this library's conventions with those of Pinocchio, eigenpy and yourdfpy."""

from __future__ import annotations

from nao_kin.crosscheck._run import run
from nao_kin.crosscheck.report import Conversions, Place, Report, Row
from nao_kin.crosscheck.steps import Step, steps_of, steps_of_nao

__all__ = ["Conversions", "Place", "Report", "Row", "Step", "run", "steps_of", "steps_of_nao"]
