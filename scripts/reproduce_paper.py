"""Solve every problem of the source paper with nao_kin's public functions, and print the results next to the paper's.

Errors of the paper are marked with "!" and shown next to the correct value. The exit code is 1 if a number is off by
more than 1e-9, or if an error of the paper is not refuted.

Example:
    python scripts/reproduce_paper.py
    python scripts/reproduce_paper.py --json > paper.json
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike
from paper import PROBLEMS, Erratum, Problem, Row


def main(arguments: list[str] | None = None) -> int:
    """Print the problems; return 0 if every number agrees and every erratum is refuted."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", action="store_true", help="machine-readable output")
    options = parser.parse_args(arguments)

    problems = [problem() for problem in PROBLEMS]
    ok = all(problem.ok for problem in problems)
    if options.json:
        report = {"ok": ok, "problems": [problem.as_json() for problem in problems]}
        print(json.dumps(report, ensure_ascii=False, indent=1))
    else:
        print("\n\n".join(text(problem) for problem in problems))
        print(f"\n{summary(problems)}")
    return 0 if ok else 1


def text(problem: Problem) -> str:
    """Return the text of a problem."""
    title = f"Problem {problem.number}: {problem.title}"
    lines = [title, "=" * len(title)]
    for row in problem.rows:
        lines.extend(row_lines(row))
    for erratum in problem.errata:
        lines.extend(erratum_lines(erratum))
    lines.extend(f"  note: {note}" for note in problem.notes)
    return "\n".join(lines)


def row_lines(row: Row) -> Iterator[str]:
    """Return the value next to the paper's, one line for each row of a matrix."""
    mark = "  " if row.agrees else "✗ "
    yield f"{mark}{row.quantity}   [{row.function}]"
    if np.asarray(row.paper).dtype == np.bool_:
        yield f"      {'yes' if row.value else 'no'}   paper: {'yes' if row.paper else 'no'}"
        return
    ours, theirs = table(row.value), table(row.paper)
    for index, (left, right) in enumerate(zip(ours, theirs, strict=False)):
        yield f"      {left}   {'paper:' if index == 0 else '      '} {right}"
    yield f"      difference {row.difference:.1e}"


def table(value: ArrayLike) -> list[str]:
    """Return the rows of a number, vector or matrix, aligned, with twelve digits."""
    rows = np.atleast_2d(np.asarray(value, dtype=float))
    # Rounded to the shown digits, so that a rounding error is shown as zero; + 0.0 removes the sign of a zero.
    cells = [[f"{number + 0.0:.12g}" for number in row] for row in np.round(rows, 12)]
    width = max(len(cell) for row in cells for cell in row)
    return ["  ".join(cell.rjust(width) for cell in row) for row in cells]


def erratum_lines(erratum: Erratum) -> Iterator[str]:
    """Return the printed value, the correct value, and the reason."""
    yield f"! {erratum.where}"
    yield f"      printed:  {erratum.printed}"
    yield f"      right:    {erratum.right}"
    yield f"      computed: {erratum.evidence}{'' if erratum.refuted else ' ✗ not refuted'}"


def summary(problems: list[Problem]) -> str:
    """Return the last line."""
    rows = [row for problem in problems for row in problem.rows]
    errata = [erratum for problem in problems for erratum in problem.errata]
    agreeing, refuted = sum(row.agrees for row in rows), sum(erratum.refuted for erratum in errata)
    return (
        f"{agreeing} of {len(rows)} results agree with the paper to 1e-9 (largest difference "
        f"{max(row.difference for row in rows):.1e}); {refuted} of {len(errata)} errata refuted"
    )


if __name__ == "__main__":
    try:
        code = main()
        sys.stdout.flush()
    except BrokenPipeError:  # the reader of the output has closed the pipe
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        code = 0
    sys.exit(code)
