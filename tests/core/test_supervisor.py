"""A browser that takes a picture ends with the program, however that ends; if the browser dies, the program notices."""

from __future__ import annotations

import fcntl
import os
import select
import signal
import stat
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import pytest
from loops import full
from viewer_pages import PATIENCE, processes, until

import nao_kin as nk
from nao_kin._core.process import _locked, find_browsers, kill_group
from nao_kin.cli.app import run
from nao_kin.errors import NoBrowser
from nao_kin.viewer import Viewer

pytestmark = pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="needs /proc")

ENVIRONMENT = {**os.environ, "PYTHONPATH": str(Path(nk.__file__).parent.parent)}


def _processes_of_chromium(folder: Path) -> list[int]:
    """Return the processes with the folder on their command line, without the supervisor and the program itself."""
    found = []
    for process in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            words = process.read_bytes().split(b"\0")
        except OSError:
            continue
        if any(str(folder).encode() in word for word in words) and not words[0].decode().count("python"):
            found.append(int(process.parent.name))
    return found


@pytest.fixture
def needs_browser() -> None:
    try:
        find_browsers()
    except NoBrowser as error:
        pytest.skip(f"no browser to draw with: {error}")


def _picture(folder: Path, *, before: str = "") -> subprocess.Popen[bytes]:
    """A program that draws pictures until it is ended, its temporary files in a folder."""
    code = (
        f"import nao_kin as nk\n{before}\n"
        "viewer = nk.Viewer(nk.load_nao())\n"
        "while True: viewer.save_png('x.png', size=(4000, 4000), overwrite=True)\n"
    )
    return subprocess.Popen(
        [sys.executable, "-c", code],
        cwd=folder,
        env={**ENVIRONMENT, "TMPDIR": str(folder)},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        start_new_session=True,
    )


# A copy of the program, as multiprocessing makes them, holds every pipe that was open.
_FORKING = """
import os, subprocess, time
class Forking(subprocess.Popen):
    def __init__(self, *arguments, **options):
        super().__init__(*arguments, **options)
        if os.fork() == 0:
            time.sleep(600)
            os._exit(0)
subprocess.Popen = Forking
"""


@pytest.mark.full
@pytest.mark.parametrize("before", ["", _FORKING], ids=["alone", "forked"])
@pytest.mark.usefixtures("needs_browser")
def test_sigkill_leaves_neither_browser_nor_folder(short_folder: Path, before: str) -> None:
    process = _picture(short_folder, before=before)
    try:
        assert until(lambda: len(_processes_of_chromium(short_folder)) >= 3)
        process.kill()
        process.wait()
        process.stderr.close()
        assert until(lambda: processes(str(short_folder)) == [])
        assert until(lambda: list(short_folder.iterdir()) == [])
    finally:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)


def test_what_a_program_has_started_is_killed_with_it() -> None:
    command = ["sh", "-c", "sleep 1000 & echo started; wait"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, start_new_session=True) as program:
        assert program.stdout is not None
        assert program.stdout.readline() == "started\n"
        kill_group(program)
        # The pipe ends with the last of those that hold it.
        assert select.select([program.stdout], [], [], 10.0)[0]
        assert program.stdout.read() == ""


@pytest.mark.full
@pytest.mark.usefixtures("needs_browser")
def test_the_browser_of_a_program_ends_with_it_and_a_forked_copy_has_its_own(short_folder: Path) -> None:
    code = """if True:
        import os, sys
        import nao_kin as nk
        viewer = nk.Viewer(nk.load_nao())
        viewer.save_png("a.png", size=(64, 64))
        copy = os.fork()
        if copy == 0:
            viewer.save_png("b.png", size=(64, 64))
            os._exit(0)
        status = os.waitpid(copy, 0)[1]
        viewer.save_png("c.png", size=(64, 64))
        sys.exit(status)
    """
    environment = {**ENVIRONMENT, "TMPDIR": str(short_folder)}
    done = subprocess.run([sys.executable, "-c", code], cwd=short_folder, env=environment, check=False)
    assert done.returncode == 0
    assert until(lambda: processes(str(short_folder)) == [])
    assert until(lambda: sorted(path.name for path in short_folder.iterdir()) == ["a.png", "b.png", "c.png"])
    assert len({(short_folder / name).read_bytes() for name in ("a.png", "b.png", "c.png")}) == 1


@pytest.mark.full
@pytest.mark.usefixtures("needs_browser")
def test_a_browser_that_is_killed_is_missed_at_once_in_one_line(short_folder: Path) -> None:
    process = _picture(short_folder)
    try:
        assert until(lambda: len(_processes_of_chromium(short_folder)) >= 3)
        os.kill(min(_processes_of_chromium(short_folder)), signal.SIGKILL)
        _, err = process.communicate(timeout=PATIENCE)
        last = err.decode().splitlines()[-1]
        assert last.startswith("nao_kin.errors.NoBrowser: the browser ")
        assert " was ended by SIGKILL before it " in last
    finally:
        process.kill()
        process.wait()
    assert until(lambda: processes(str(short_folder)) == [])
    assert list(short_folder.iterdir()) == []


@pytest.mark.parametrize(
    ("script", "line"),
    [
        ("#!/bin/sh\nexit 0\n", "ended with exit code 0 before it showed the scene"),
        *full(
            ("#!/bin/sh\nexit 7\n", "ended with exit code 7 before it showed the scene"),
            ("#!/bin/sh\nkill -SEGV $$\n", "was ended by SIGSEGV before it showed the scene"),
            pytest.param(
                "#!/bin/sh\nkill -36 $$\n",
                "was ended by signal 36 before it showed the scene",
                marks=pytest.mark.skipif(sys.platform != "linux", reason="real-time signals have other numbers"),
            ),
            ("#!/no/such/shell\n", "does not start: No such file or directory"),
            ("\0\1\2", "does not start: Exec format error"),
        ),
    ],
)
def test_a_program_that_is_no_browser_is_noticed_at_once(
    nao: nk.NaoModel, tmp_path: Path, short_folder: Path, monkeypatch: pytest.MonkeyPatch, script: str, line: str
) -> None:
    program = tmp_path / "browser"
    program.write_text(script)
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setenv("NAO_KIN_BROWSER", str(program))
    monkeypatch.setattr("nao_kin.viewer.browser._short_folder", lambda: str(short_folder))
    with pytest.raises(NoBrowser) as caught:
        Viewer(nao).save_png(tmp_path / "x.png", timeout=PATIENCE)
    assert str(caught.value) == f"the browser {program} {line}"
    assert not (tmp_path / "x.png").exists()
    assert list(short_folder.iterdir()) == []


def _program(path: Path, script: str) -> Path:
    path.write_text(f"#!/bin/sh\n{script}\n", encoding="utf-8")
    path.chmod(0o755)
    return path


def test_after_a_browser_that_ends_by_itself_the_next_one_is_tried_and_their_last_words_are_shown(
    nao: nk.NaoModel, tmp_path: Path, short_folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    log = "[12:34:1128/150000.1:FATAL:zygote_host_impl_linux.cc(128)]"
    _program(
        tmp_path / "chromium", f"echo starting >&2; echo '{log} No usable sandbox!' >&2; echo '#0 0x55' >&2; exit 133"
    )
    chrome = _program(tmp_path / "google-chrome", "printf 'no\\n' >&2; kill -SEGV $$")
    _program(tmp_path / "firefox", "touch tried")
    (tmp_path / "chrome").symlink_to(chrome)  # the same program once more
    monkeypatch.setenv("PATH", f"{tmp_path}:/bin", prepend=None)
    monkeypatch.delenv("NAO_KIN_BROWSER", raising=False)
    monkeypatch.setattr("nao_kin._core.process._BROWSERS", ("chromium", "google-chrome", "chrome"))
    monkeypatch.setattr("nao_kin.viewer.browser._short_folder", lambda: str(short_folder))
    with pytest.raises(NoBrowser) as caught:
        Viewer(nao).save_png(tmp_path / "x.png", timeout=PATIENCE)
    said = str(caught.value).split("; ")
    assert (
        said[0]
        == f"the browser {tmp_path}/chromium ended with exit code 133 before it showed the scene: No usable sandbox!"
    )
    assert said[1] == f"the browser {chrome} was ended by SIGSEGV before it showed the scene: no"
    assert "NAO_KIN_BROWSER" in said[2]
    assert len(said) == 3


@pytest.mark.full
@pytest.mark.usefixtures("needs_browser")
def test_a_picture_is_drawn_by_the_first_browser_that_works(
    nao: nk.NaoModel, tmp_path: Path, short_folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "google-chrome").symlink_to(find_browsers()[0])
    _program(tmp_path / "chromium", "exit 133")
    monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
    monkeypatch.setattr("nao_kin._core.process._BROWSERS", ("chromium", "google-chrome"))
    monkeypatch.setattr("nao_kin.viewer.browser._short_folder", lambda: str(short_folder))
    viewer = Viewer(nao)
    for name in ("a.png", "b.png"):  # the second one in the page of the first
        viewer.save_png(tmp_path / name, size=(64, 64), timeout=PATIENCE)
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


@pytest.mark.full
def test_the_command_line_says_so_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("NAO_KIN_BROWSER", "/bin/true")
    assert run(["view", "--png", str(tmp_path / "x.png")]) == 2
    said = "nao-kin: the browser /bin/true ended with exit code 0 before it showed the scene\n"
    assert capfd.readouterr() == ("", said)


def test_a_browser_that_never_shows_anything_is_ended_when_the_time_is_over(
    nao: nk.NaoModel, tmp_path: Path, short_folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    program = tmp_path / "browser"
    program.write_text("#!/bin/sh\ntrap '' TERM\nsleep 1000 &\nwait\n")
    program.chmod(0o755)
    monkeypatch.setenv("NAO_KIN_BROWSER", str(program))
    monkeypatch.setattr("nao_kin.viewer.browser._short_folder", lambda: str(short_folder))
    with pytest.raises(NoBrowser, match=r"did not show the scene within 0\.5 s"):
        Viewer(nao).save_png(tmp_path / "x.png", timeout=0.5)
    assert processes(str(short_folder)) == []
    assert list(short_folder.iterdir()) == []


def test_folders_whose_programs_were_all_killed_are_removed_by_the_next_run(
    nao: nk.NaoModel, tmp_path: Path, short_folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def folder(name: str, *, age: float) -> Path:
        made = short_folder / name
        (made / "Default").mkdir(parents=True)
        (made / "in_use").touch()
        os.utime(made, (time.time() - age,) * 2)
        return made

    folder("nao_kin_browser_old", age=100.0)
    young, used = folder("nao_kin_browser_young", age=5.0), folder("nao_kin_browser_used", age=100.0)
    other = folder("nao_kin_other", age=100.0)
    (tmp_path / "precious").mkdir()
    link = short_folder / "nao_kin_browser_link"
    link.symlink_to(tmp_path / "precious")
    monkeypatch.setenv("NAO_KIN_BROWSER", "/bin/true")
    monkeypatch.setattr("nao_kin.viewer.browser._short_folder", lambda: str(short_folder))
    with (used / "in_use").open() as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        with pytest.raises(NoBrowser):
            Viewer(nao).save_png(tmp_path / "x.png")
    assert set(short_folder.iterdir()) == {young, used, other, link}
    assert (tmp_path / "precious").is_dir()


def test_a_folder_is_in_use_by_one_supervisor_at_a_time(tmp_path: Path) -> None:
    path = str(tmp_path / "in_use")
    first = _locked(path)
    assert first is not None
    assert _locked(path) is None  # whoever tidies up leaves it alone
    os.close(first)
    second = _locked(path)
    assert second is not None
    os.close(second)
