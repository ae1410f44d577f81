"""Folders are written whole or not at all."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from nao_kin._core.files import check_folder, write_folder
from nao_kin.errors import BadArgument

FILES = {"package.xml": b"<package/>", "urdf/nao.urdf": b"<robot/>"}


def _content(folder: Path) -> dict[str, bytes]:
    return {file.relative_to(folder).as_posix(): file.read_bytes() for file in folder.rglob("*") if file.is_file()}


def test_a_new_folder_holds_the_files(tmp_path: Path) -> None:
    assert write_folder(tmp_path / "nao", FILES) == (tmp_path / "nao/package.xml", tmp_path / "nao/urdf/nao.urdf")
    assert _content(tmp_path / "nao") == FILES
    assert os.listdir(tmp_path) == ["nao"]


def test_an_empty_folder_is_filled_and_keeps_its_mode(tmp_path: Path) -> None:
    (tmp_path / "nao").mkdir(mode=0o750)
    write_folder(tmp_path / "nao", FILES)
    assert _content(tmp_path / "nao") == FILES
    assert (tmp_path / "nao").stat().st_mode & 0o777 == 0o750


def test_a_folder_is_replaced_only_by_force(tmp_path: Path) -> None:
    write_folder(tmp_path / "nao", FILES)
    with pytest.raises(BadArgument, match=r"nao already exists; overwrite=True \(--force\) replaces it"):
        write_folder(tmp_path / "nao", {"package.xml": b"new"})
    assert _content(tmp_path / "nao") == FILES
    write_folder(tmp_path / "nao", FILES | {"package.xml": b"new"}, overwrite=True)
    assert _content(tmp_path / "nao") == FILES | {"package.xml": b"new"}
    assert os.listdir(tmp_path) == ["nao"]


def test_what_somebody_else_has_put_there_stays(tmp_path: Path) -> None:
    write_folder(tmp_path / "nao", FILES)
    (tmp_path / "nao/thesis.tex").write_text("x")
    with pytest.raises(BadArgument, match=r"it contains 1 other files, first 'thesis.tex'"):
        write_folder(tmp_path / "nao", FILES, overwrite=True)
    assert _content(tmp_path / "nao") == FILES | {"thesis.tex": b"x"}


def test_a_link_leads_to_the_folder_and_stays(tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to("real")
    write_folder(tmp_path / "link", FILES)
    assert (tmp_path / "link").is_symlink()
    assert _content(tmp_path / "real") == FILES


def test_a_link_inside_is_not_followed(tmp_path: Path) -> None:
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere/kept").write_text("x")
    (tmp_path / "nao").mkdir()
    (tmp_path / "nao/urdf").symlink_to("../elsewhere")
    with pytest.raises(BadArgument, match="first 'urdf'"):
        write_folder(tmp_path / "nao", FILES, overwrite=True)
    assert (tmp_path / "elsewhere/kept").exists()


def test_a_folder_that_somebody_works_in_stays_under_their_feet(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "nao/src").mkdir(parents=True)
    monkeypatch.chdir("nao")
    for force in (False, True):
        assert write_folder(".", FILES, overwrite=force) == (Path("package.xml"), Path("urdf/nao.urdf"))
        assert sorted(os.listdir()) == ["package.xml", "src", "urdf"]
        assert _content(Path.cwd()) == FILES


def test_before_the_work_the_place_is_looked_at(tmp_path: Path) -> None:
    write_folder(tmp_path / "nao", FILES)
    with pytest.raises(BadArgument, match="nao already exists"):
        check_folder(tmp_path / "nao", overwrite=False)
    check_folder(tmp_path / "nao", overwrite=True)
    check_folder(tmp_path / "new", overwrite=False)
    assert os.listdir(tmp_path) == ["nao"]


def test_a_signal_between_the_renames_waits_for_the_new_folder(tmp_path: Path) -> None:
    write_folder(tmp_path / "nao", FILES)
    program = (
        "import os, signal, sys\n"
        "from nao_kin._core import process as ending; from nao_kin._core import files as folders\n"
        "ending.end_on_signals()\n"
        "replace = os.replace\n"
        "def slow(*names):\n"
        "    os.kill(os.getpid(), signal.SIGTERM)\n"
        "    return replace(*names)\n"
        "os.replace = slow\n"
        "folders.write_folder(sys.argv[1], {'package.xml': b'new', 'urdf/nao.urdf': b'new'}, overwrite=True)\n"
        "print('went on')\n"
    )
    done = subprocess.run([sys.executable, "-c", program, str(tmp_path / "nao")], capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (128 + signal.SIGTERM, "")
    assert _content(tmp_path / "nao") == dict.fromkeys(FILES, b"new")
    assert os.listdir(tmp_path) == ["nao"]


def test_where_no_folder_can_be_it_is_said_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("x")
    for path, reason in (
        (tmp_path / "file", "it is a file"),
        (tmp_path / "none/nao", "No such file or directory"),
        (tmp_path / "file/nao", "Not a directory"),
        ("a\0b", "null"),
        ("", "no folder name"),
        (None, "expected str"),
    ):
        with pytest.raises(BadArgument, match=reason) as caught:
            write_folder(path, FILES)  # type: ignore[arg-type]
        assert "\n" not in str(caught.value)
        with pytest.raises(BadArgument) as before:
            check_folder(path, overwrite=False)  # type: ignore[arg-type]
        assert str(before.value) == str(caught.value)
    assert os.listdir(tmp_path) == ["file"]


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_program_that_is_ended_leaves_the_old_folder(tmp_path: Path, number: signal.Signals) -> None:
    write_folder(tmp_path / "nao", FILES)
    program = (
        "import sys, time\n"
        "from nao_kin._core import process as ending; from nao_kin._core import files as folders\n"
        "ending.end_on_signals()\n"
        "class Slow(dict):\n"
        "    def items(self):\n"
        "        yield 'package.xml', b'new'\n"
        "        print('begun', flush=True)\n"
        "        while True: time.sleep(0.01)\n"  # one long wait would miss a signal that arrives just before it
        "folders.write_folder(sys.argv[1], Slow({'package.xml': b'', 'urdf/nao.urdf': b''}), overwrite=True)\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", program, str(tmp_path / "nao")], stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "begun\n"
        process.send_signal(number)
        assert process.wait() == 128 + number
    assert _content(tmp_path / "nao") == FILES
    assert os.listdir(tmp_path) == ["nao"]
