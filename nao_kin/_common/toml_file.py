"""TOML files."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from nao_kin._common.input_text import read_bounded
from nao_kin._text import quoted
from nao_kin.errors import BadArgument, BadInputFile


def read_toml(path: Path | str) -> dict[str, Any]:
    """Return the document in a TOML file.

    Raises:
        BadArgument: no path.
        BadInputFile: the file cannot be read, or is no TOML.
    """
    if sys.version_info >= (3, 11):
        import tomllib
    else:
        import tomli as tomllib
    try:
        with Path(path).open("rb") as file:
            document: dict[str, Any] = tomllib.loads(read_bounded(file, str(path)).decode())
    except TypeError:
        raise BadArgument(f"expected the path of a TOML file, got {quoted(path)}") from None
    except OSError as error:
        raise BadInputFile(str(path), f"cannot be read: {error.strerror or error}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise BadInputFile(str(path), f"not well-formed TOML: {error}") from None
    except ValueError as error:  # a path that no system takes, a number of thousands of digits
        raise BadInputFile(str(path), f"cannot be read: {error}") from None
    return document
