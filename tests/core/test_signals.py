"""Signals end every command at once, and leave nothing behind."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from loops import full
from viewer_pages import processes

import nao_kin as nk

pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals")

ENVIRONMENT = {**os.environ, "PYTHONPATH": str(Path(nk.__file__).parent.parent)}
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
COMMANDS = {
    "live": ("view",),
    "html": ("view", "--html", "x.html"),
    "png": ("view", "--png", "x.png"),
    "fk": ("fk", "--posture", "StandInit"),
    "fk from standard input": ("fk", "-"),
    "check": ("check", "--samples", "50"),
    "info": ("info",),
    "doctor": ("doctor",),
}
# How a file ends that is whole.
ENDS = {".html": b"</html>\n", ".png": b"IEND\xaeB`\x82"}


@pytest.fixture(autouse=True)
def nothing_ignored() -> Iterator[None]:
    """Ignore no signal: programs inherit ignored signals if the tests run under nohup or in the background."""
    ignored = [number for number in SIGNALS if signal.getsignal(number) is signal.SIG_IGN]
    for number in ignored:
        signal.signal(number, lambda *_: None)  # which no program inherits
    yield
    for number in ignored:
        signal.signal(number, signal.SIG_IGN)


def _program(*code: str, **options) -> subprocess.Popen:
    return subprocess.Popen(
        [sys.executable, *code],
        env={**ENVIRONMENT, **options.pop("env", {})},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        start_new_session=True,
        **options,
    )


def test_the_program_handles_signals_before_it_imports_what_takes_long() -> None:
    code = "import sys, nao_kin.cli; print(*{'numpy', 'dataclasses', 'inspect', 'nao_kin.errors'} & {*sys.modules})"
    done = subprocess.run(
        [sys.executable, "-S", "-c", code], env=ENVIRONMENT, capture_output=True, text=True, check=True
    )
    assert done.stdout == "\n"


def _handles(process: subprocess.Popen, number: signal.Signals) -> bool:
    """Return whether the program has installed its own handler for the signal, according to Linux."""
    try:
        status = Path(f"/proc/{process.pid}/status").read_text()
    except OSError:
        return False
    caught = int(next(line.split()[1] for line in status.splitlines() if line.startswith("SigCgt")), 16)
    return all(caught >> (each - 1) & 1 for each in (number, signal.SIGTERM))


def _kill_group(process: subprocess.Popen) -> bool:
    """Kill the remaining processes of the program's group; return whether there were any."""
    try:
        os.killpg(process.pid, signal.SIGKILL)
    except ProcessLookupError:
        return False
    return True


def _problems(folder: Path, name: str, number: signal.Signals, delay: float) -> list[str]:
    """Send a command a signal after a delay; return what went wrong."""
    here, temporary = folder / "here", folder / "temporary"
    here.mkdir(parents=True)
    temporary.mkdir()
    process = _program("-m", "nao_kin", *COMMANDS[name], cwd=here, env={"TMPDIR": str(temporary)})
    found = []
    try:
        time.sleep(delay)
        handles = _handles(process, number)
        ended = process.poll() is not None
        process.send_signal(number)
        start = time.monotonic()
        try:
            process.wait(10.0)
        except subprocess.TimeoutExpired:
            found.append("does not end")
        if time.monotonic() - start > 3.0:  # at once, on a machine that is busy
            found.append(f"took {time.monotonic() - start:.2f} s")
    finally:
        if _kill_group(process):
            found.append("left a process of its group")
        process.wait(10.0)
    code, err = process.returncode, process.stderr.read()
    process.communicate()
    # Before the program's first line, Python itself answers; in its last moments, the work is done and the code is 0.
    if not ended and code != 0 and code != 128 + number and (handles or code not in (-number, 1)):
        found.append(f"exit code {code}")
    if handles and code != 0 and err:
        found.append(f"printed {err!r}")
    if processes(str(folder)):
        found.append(f"left {processes(str(folder))}")
    # A file that is whole may be there: the signal came between the last byte and the end of the program.
    whole = [path for path in here.iterdir() if path.read_bytes().endswith(ENDS.get(path.suffix, b"?"))]
    files = [str(path) for path in folder.rglob("*") if path not in (here, temporary, *whole)]
    if code != 0 and files:
        found.append(f"left {files}")
    return [f"{name}, {number.name} after {delay:.2f} s: {problem}" for problem in found]


@pytest.mark.full
@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="needs /proc")
def test_every_command_ends_at_once_at_any_moment_of_its_life(short_folder: Path) -> None:
    names = list(COMMANDS)
    # Each command twice, with two of the signals.
    tries = [
        (short_folder / str(index), names[index % len(names)], SIGNALS[index % 3], 0.12 * index) for index in range(16)
    ]
    with ThreadPoolExecutor(2) as pool:
        found = [problem for problems in pool.map(lambda each: _problems(*each), tries) for problem in problems]
    assert found == []


_STUBBORN = """
import os, signal, sys, time
from nao_kin._core.process import before_ending, end_on_signals, uninterrupted
end_on_signals()
{body}
"""


def _stubborn(body: str) -> tuple[int, str, float]:
    process = _program("-c", _STUBBORN.format(body=body))
    start = time.monotonic()
    try:
        out, err = process.communicate(timeout=20.0)
    finally:
        _kill_group(process)
    assert err == b""
    return process.returncode, out.decode(), time.monotonic() - start


@pytest.mark.parametrize("number", [signal.SIGINT, *full(signal.SIGTERM, signal.SIGHUP)])
def test_code_that_swallows_every_exception_does_not_keep_the_program(number: signal.Signals) -> None:
    body = f"""
try:
    os.kill(os.getpid(), {int(number)})
    time.sleep(10)
except BaseException:
    print("swallowed")
time.sleep(10)
"""
    code, out, seconds = _stubborn(body)
    assert (code, out) == (128 + number, "")
    assert seconds < 5.0


def test_what_is_registered_is_tidied_newest_first_and_what_is_taken_back_is_not() -> None:
    body = """
before_ending(lambda: os.write(1, b"first "))
before_ending(lambda: os.write(1, b"never ")).close()
before_ending(lambda: 1 / 0)
before_ending(lambda: os.write(1, b"second "))
os.kill(os.getpid(), signal.SIGTERM)
"""
    assert _stubborn(body)[:2] == (143, "second first ")


def test_a_few_steps_can_be_kept_together() -> None:
    body = """
with uninterrupted():
    with uninterrupted():
        os.kill(os.getpid(), signal.SIGTERM)
        print("inside", flush=True)
    print("still inside", flush=True)
print("outside", flush=True)
"""
    assert _stubborn(body)[:2] == (143, "inside\nstill inside\n")


def test_a_second_signal_does_not_cut_the_tidying_short() -> None:
    body = """
before_ending(lambda: os.write(1, b"tidied"))
before_ending(lambda: [os.kill(os.getpid(), number) for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP)])
os.kill(os.getpid(), signal.SIGHUP)
"""
    assert _stubborn(body)[:2] == (129, "tidied")


def test_tidying_that_hangs_is_left() -> None:
    body = """
before_ending(lambda: time.sleep(60))
start = time.monotonic()
os.kill(os.getpid(), signal.SIGTERM)
"""
    code, _, seconds = _stubborn(body)
    assert code == 143
    assert seconds < 5.0


# A signal that comes just before a wait begins, or to another thread, wakes nobody up.
_TO_ANOTHER_THREAD = """
import threading
def send():
    time.sleep(0.5)
    signal.pthread_kill(threading.get_ident(), signal.SIGTERM)
threading.Thread(target=send, daemon=True).start()
"""


@pytest.mark.parametrize("waiting", ["process.wait_for_signal()", "run_script('sleep.py')"])
def test_a_signal_that_wakes_nobody_ends_a_wait_all_the_same(tmp_path: Path, waiting: str) -> None:
    (tmp_path / "sleep.py").write_text("import time\ntime.sleep(30)\n", encoding="utf-8")
    body = (
        f"os.chdir({str(tmp_path)!r})\nfrom nao_kin._core import process\nfrom nao_kin.naoqi import run_script"
        f"{_TO_ANOTHER_THREAD}{waiting}"
    )
    code, out, _ = _stubborn(body)
    assert (code, out) == (143, "")


def test_what_nohup_ignores_stays_ignored() -> None:
    def ignore() -> None:
        signal.signal(signal.SIGHUP, signal.SIG_IGN)

    process = _program("-m", "nao_kin", "fk", "-", preexec_fn=ignore)
    try:
        _wait_until(lambda: _handles(process, signal.SIGINT))
        process.send_signal(signal.SIGHUP)
        out, err = process.communicate(b"{}", timeout=20.0)
    finally:
        _kill_group(process)
    assert (process.returncode, out) == (2, b"")
    assert b"missing joints" in err


def test_a_terminal_gets_its_cursor_back() -> None:
    import pty

    ours, theirs = pty.openpty()
    process = subprocess.Popen(
        [sys.executable, "-m", "nao_kin", "check", "--samples", "100000"],
        env={**ENVIRONMENT, "TERM": "xterm"},
        stdout=subprocess.DEVNULL,
        stderr=theirs,
        start_new_session=True,
    )
    os.close(theirs)
    try:
        printed = b""
        while b"\x1b[?25l" not in printed:  # the progress bar hides the cursor
            printed += os.read(ours, 1024)
        process.send_signal(signal.SIGINT)
        try:
            while data := os.read(ours, 1024):
                printed += data
        except OSError:  # how Linux reports the end of a terminal
            pass
        assert process.wait(10.0) == 130
        assert printed.endswith(b"\r\x1b[K\x1b[?25h")
    finally:
        _kill_group(process)
        process.wait(10.0)
        os.close(ours)


def _wait_until(condition, seconds: float = 30.0) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)
