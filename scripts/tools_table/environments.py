"""A Python environment for each tool, created once, because the tools require conflicting versions."""

from __future__ import annotations

import os
import subprocess
import venv
from pathlib import Path

from tools_table.tools import Tool


def default_cache() -> Path:
    """The folder of the environments, in the user's cache."""
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "nao_kin" / "tools"


def python_of(tool: Tool, cache: Path) -> Path:
    """Return the Python that has the tool; install the tool first if necessary.

    Raises:
        RuntimeError: pip cannot install it; with the last line of pip's output.
    """
    folder = cache / tool.key
    python = folder / "bin" / "python"
    wanted = "\n".join(tool.requirements) + "\n"
    stamp = folder / ".installed"
    if not stamp.is_file() or stamp.read_text(encoding="utf-8") != wanted:
        venv.create(folder, with_pip=True, clear=True)
        pip = [str(python), "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-compile"]
        done = subprocess.run([*pip, *tool.requirements], capture_output=True, text=True)
        if done.returncode:
            said = done.stderr.strip().splitlines() or [f"pip ended with {done.returncode}"]
            raise RuntimeError(said[-1])
        stamp.write_text(wanted, encoding="utf-8")
    return python


def installed_version(tool: Tool, python: Path) -> str:
    """The version of the tool that is installed."""
    program = f"import importlib.metadata as m; print(m.version({tool.package!r}))"
    return subprocess.run([python, "-c", program], check=True, capture_output=True, text=True).stdout.strip()


def environment() -> dict[str, str]:
    """Return the variables for a process of a tool: it can import the probes, and nothing else of this project."""
    scripts = str(Path(__file__).resolve().parent.parent)
    kept = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    return {**kept, "PYTHONPATH": scripts, "PYTHONDONTWRITEBYTECODE": "1", "MPLBACKEND": "Agg"}
