"""Xacro sources expanded on reading, by the package `xacro`, with `$(find package)` answered by our own search."""

from __future__ import annotations

import contextlib
import io
import sys
import threading
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import ModuleType

from nao_kin._text import abbreviated, quoted
from nao_kin.errors import BadArgument, BadModel
from nao_kin.urdf.packages import Packages

# xacro keeps the file it is at, its arguments and its macros in variables of the module.
_EXPANDING = threading.Lock()
# The package by which xacro looks for packages of ROS; it comes with ROS 2 and not from an index.
_ROS_INDEX = "ament_index_python"


def expand_xacro(
    path: Path, content: bytes, notes: list[str], *, arguments: Mapping[str, object], packages: Packages, what: str
) -> bytes:
    """The URDF that a xacro source becomes.

    The expressions of the source are Python code, and run with all that this process may do.

    Args:
        path: the source; what it includes is looked for from its folder.
        content: what it holds.
        notes: gets a line for what xacro warned of.
        arguments: values of its `<xacro:arg>`, by name.
        packages: where `$(find package)` looks.
        what: what the file is, in words, for the error.

    Raises:
        BadModel: xacro is not installed, or refuses the source.
    """
    try:
        import xacro
    except ImportError:
        target = path.name.removesuffix(".xacro").removesuffix(".urdf") + ".urdf"
        raise BadModel(
            f"{path}: {what}; pip install 'nao-kin[xacro]' has it read as it is, or expand it first: "
            f"xacro {path.name} -o {target if target != path.name else 'expanded.urdf'}"
        ) from None
    said = io.StringIO()
    try:
        with _EXPANDING, _found_by(packages), contextlib.redirect_stderr(said):
            xacro.init_stacks(str(path.absolute()))
            document = xacro.parse(io.BytesIO(content.lstrip()))
            xacro.process_doc(document, mappings=xacro_values(arguments))
            expanded: bytes = document.toxml(encoding="utf-8")
    except (Exception, SystemExit) as error:  # whatever its expressions raise
        raise BadModel(f"{path}: xacro refuses it: {abbreviated(_reason(error)) or type(error).__name__}") from None
    warned = said.getvalue().split("\n", 1)[0]
    if warned.strip():
        notes.append(f"xacro says: {abbreviated(warned)}")
    return expanded


def xacro_values(arguments: Mapping[str, object]) -> dict[str, str]:
    """Arguments as xacro takes them: texts, with true and false in lower case.

    Raises:
        BadArgument: no names with values.
    """
    if not isinstance(arguments, Mapping) or not all(isinstance(name, str) for name in arguments):
        raise BadArgument(f"xacro_arguments must be a mapping name → value, got {quoted(arguments)}")
    return {name: str(value).lower() if isinstance(value, bool) else str(value) for name, value in arguments.items()}


def _reason(error: BaseException) -> str:
    """Return what an error of xacro says, with the reason of the error that caused it once: xacro often repeats it."""
    cause = getattr(error, "exc", None)
    if cause is None:
        return str(error)
    own, reason = error.args[0] or "", _reason(cause)
    if own and isinstance(cause, OSError):
        reason = ""
    elif str(cause) in own:
        own = ""
    return " ".join(part for part in (own, reason, getattr(error, "suffix", None)) if part)


@contextlib.contextmanager
def _found_by(packages: Packages) -> Iterator[None]:
    """Have xacro find packages of ROS where `packages` does."""

    def share_directory(name: str) -> str:
        folder = packages.folder(name)
        if folder is None:
            raise LookupError(
                f"package {quoted(name)} is in none of the folders given, nor in ROS_PACKAGE_PATH or AMENT_PREFIX_PATH"
            )
        return str(folder)

    module, inside = ModuleType(_ROS_INDEX), ModuleType(f"{_ROS_INDEX}.packages")
    inside.get_package_share_directory = share_directory  # type: ignore[attr-defined]
    module.packages = inside  # type: ignore[attr-defined]
    names = (_ROS_INDEX, f"{_ROS_INDEX}.packages")
    before = {name: sys.modules[name] for name in names if name in sys.modules}
    sys.modules.update(zip(names, (module, inside), strict=True))
    try:
        yield
    finally:
        for name in names:
            del sys.modules[name]
        sys.modules.update(before)
