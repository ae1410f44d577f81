"""Optional packages at the place where they are needed."""

from __future__ import annotations

import importlib

from nao_kin._extras import EXTRAS, with_remedy
from nao_kin._text import abbreviated
from nao_kin.errors import MissingExtra


def need_extra(purpose: str, name: str, *modules: str) -> None:
    """Refuse to go on without an extra.

    Args:
        purpose: what needs it, as the message begins.
        name: of the extra.
        modules: what is going to be imported; by default all that the extra brings.

    Raises:
        MissingExtra: it is not installed, or does not load.
    """
    for module in modules or EXTRAS[name].modules:
        try:
            importlib.import_module(module)
        except ImportError as error:
            absent = isinstance(error, ModuleNotFoundError) and error.name in (module, module.partition(".")[0])
            raise MissingExtra(purpose, name, "" if absent else with_remedy(abbreviated(error))) from None
