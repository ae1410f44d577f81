"""Comparison of this library's conventions with those of Pinocchio, eigenpy and yourdfpy."""

from __future__ import annotations

from nao_kin._core.guesses import public_attributes as _public_attributes
from nao_kin.crosscheck._run import run
from nao_kin.crosscheck.report import Conversions, Report
from nao_kin.crosscheck.steps import steps_of_nao

__all__ = ["Conversions", "Report", "run", "steps_of_nao"]

globals().update(_public_attributes(__name__))
