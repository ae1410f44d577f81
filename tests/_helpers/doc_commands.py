"""The command lines of the documentation, and the pages as a reader runs them, in an empty folder.

As a program, with the name of a JSON file: all command lines; the file has those that fail, and what they say.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import re
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from doc_pages import PAGES, blocks

from nao_kin.cli.app import run
from nao_kin.errors import MissingExtra

# Lines that no test can run → the reason.
SKIPPED = {
    r"nao-kin (serve|run|live) ": "a server, a script or a robot, with the extra naoqi",
    r"nao-kin view (?!.*--html)": "a live page until Ctrl-C",
    r"--nao v6\.1": "a version that the reader has added",
    r"robot\.urdf\.xacro|scene\.xml": "the reader's own robot",
    r"--offsets nao_7\.toml": "a file of which the page shows the content",
}
# Lines that end with another exit code than 0, as their page says.
ENDS_WITH = {'nao-kin ik LLeg --target "0 0.05 -0.5 0 0 0"': 1}
# On this page most lines fail, as it shows; tests/cli/test_printed_output.py compares what they say.
FAILING = "installation.md"
# The lines of this page are each for another tool, and have a folder each.
SEPARATE = "tools.md"
# On these pages lines use files that Python writes.
PYTHON_FIRST = ("getting_started.md", "real_data.md")

_SHELLS = ("sh", "bash", "console", "text", "{code-block} sh")
_LINE = re.compile(r"(?:^|\| )nao-kin |^printf ")
_COMMENT = re.compile(r"\s#\s.*")


def lines_of(kind: str, block: str) -> list[str]:
    """Return the lines of a block that call nao-kin or make a file for it, without prompts and comments."""
    texts = [line.removeprefix("$ ") for line in block.replace("\\\n", " ").splitlines() if kind in _SHELLS]
    return [_COMMENT.sub("", text).strip() for text in texts if _LINE.search(text)]


def commands_of(page: Path) -> list[str]:
    """Return all these lines of a page."""
    return [line for kind, text in blocks(page) for line in lines_of(kind, text)]


def why_skipped(line: str) -> str | None:
    """Return why no test can run a line, or None."""
    return next((reason for pattern, reason in SKIPPED.items() if re.search(pattern, line)), None)


class Ran(NamedTuple):
    """A line that was run, its exit code, and what it said on standard error."""

    line: str
    code: int
    said: str

    @property
    def fine(self) -> bool:
        """Whether it ended as its page says."""
        return self.code == ENDS_WITH.get(self.line, 0)


def _with_few_samples(words: list[str]) -> list[str]:
    """Return the words with three samples for a check or a proof, which take ten seconds with the number of a page."""
    if words[0] == "check" or not {"ros2", "srdf"}.isdisjoint(words):
        given = words.index("--samples") if "--samples" in words else len(words)
        words = [*words[:given], "--samples", "3", *words[given + 2 :]]
    return words


def run_line(line: str) -> Ran:
    """Run a line: nao-kin in this process, other programs in a shell."""
    code, text, errors, stdin = 0, "", io.StringIO(), sys.stdin
    for stage in line.split(" | "):
        program, _, file = stage.partition(" > ")
        words = shlex.split(program)
        if words[0] == "nao-kin":
            sys.stdin = io.TextIOWrapper(io.BytesIO(text.encode()))
            with contextlib.redirect_stdout(io.StringIO()) as out, contextlib.redirect_stderr(errors):
                code = run(_with_few_samples(words[1:])) or code
            text, sys.stdin = out.getvalue(), stdin
        else:
            text = subprocess.run(["bash", "-c", program], input=text, stdout=-1, text=True, check=True).stdout
        if file:
            Path(file).write_text(text, encoding="utf-8")
    return Ran(line, code, errors.getvalue())


def run_page(page: Path, *, python: bool = False) -> Iterator[Ran]:
    """Run the lines of a page in their order in the current folder, and its Python between them or only if needed."""
    names: dict[str, Any] = {"__name__": "example"}
    for kind, text in blocks(page):
        if kind == "python" and (python or page.name in PYTHON_FIRST):
            exec(compile(text, page.name, "exec"), names)
        for line in lines_of(kind, text):
            if why_skipped(line) is None:
                with tempfile.TemporaryDirectory() if page.name == SEPARATE else contextlib.nullcontext() as folder:
                    os.chdir(folder or ".")
                    yield run_line(line)


def check(lines: Iterable[Ran]) -> None:
    """Demand that lines end as their page says.

    A line that needs an extra that is not installed is left out, and with it a later one that fails without its files.
    The test is then skipped at the end, with these lines as the reason.
    """
    left_out, files = list[str](), set[str]()
    for ran in lines:
        named = {name for name in re.findall(r"[\w/-]+\.\w+", ran.line) if not Path(name).exists()}
        if not ran.fine and ("pip install 'nao-kin[" in ran.said or named & files):
            left_out.append(f"{ran.line}: {ran.said.strip()}")
            files |= named
            continue
        assert ran.fine, ran
    if left_out:
        pytest.skip(f"left out: {'; '.join(left_out)}")


def main() -> None:
    """Write all lines that fail to a file: their pages, the lines, and what they say."""
    failed = []
    for page in (page for page in PAGES if page.name != FAILING):
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            try:
                failed += [(page.name, ran.line, ran.said) for ran in run_page(page) if not ran.fine]
            except MissingExtra as error:  # in Python
                failed.append((page.name, "Python", str(error)))
    Path(sys.argv[1]).write_text(json.dumps(failed), encoding="utf-8")


if __name__ == "__main__":
    main()
