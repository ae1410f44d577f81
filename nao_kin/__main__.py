"""`python -m nao_kin` is `nao-kin`."""

from __future__ import annotations

from nao_kin.cli import main

main()
