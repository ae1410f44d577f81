"""`python -m nao_kin` is `nao-kin`."""

from nao_kin.cli import main

main()
