"""The viewer in a real JupyterLab, used by keys and pointer, and in a notebook without its kernel."""

from __future__ import annotations

import gc
import json
import os
import re
import subprocess
import sys
import time
import weakref
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from viewer_pages import visitor

import nao_kin as nk
from nao_kin.viewer import Viewer
from nao_kin.viewer.notebook import Bridge, frame

pytestmark = pytest.mark.full

CELLS = (
    "import nao_kin as nk\nnao = nk.load_nao()\nviewer = nk.Viewer(nao)\nviewer.display(nao.posture('Crouch'))\nviewer",
    "viewer.display(nao.configuration({'HeadYaw': 1.0}))",
    "print('HeadPitch is', nao.angles(viewer.q)['HeadPitch'])",
    "viewer.close()",
)
FRAME = "iframe[data-nao-kin]"


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[str, Path]]:
    """The address of a JupyterLab with one notebook, and its folder; it is ended whatever happens."""
    pytest.importorskip("jupyterlab", reason="jupyterlab is not installed")
    nbformat = pytest.importorskip("nbformat")
    folder = tmp_path_factory.mktemp("lab")
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(source) for source in CELLS])
    notebook.metadata["kernelspec"] = {"name": "python3", "display_name": "Python 3", "language": "python"}
    nbformat.write(notebook, folder / "robot.ipynb")
    places = {f"JUPYTER_{kind}_DIR": str(folder / kind) for kind in ("CONFIG", "DATA", "RUNTIME")}
    package = str(Path(nk.__file__).parent.parent)
    options = {
        "ServerApp.ip": "127.0.0.1",
        "ServerApp.port": "0",
        "ServerApp.root_dir": str(folder),
        "IdentityProvider.token": "secret",
        "LabApp.news_url": "None",
        "LabApp.check_for_updates_class": "jupyterlab.NeverCheckForUpdate",
    }
    with (folder / "log.txt").open("w") as log:
        server = subprocess.Popen(
            [sys.executable, "-m", "jupyterlab", "--no-browser", "--allow-root"]
            + [f"--{name}={value}" for name, value in options.items()],
            env={**os.environ, **places, "PYTHONPATH": package, "IPYTHONDIR": str(folder / "ipython")},
            stdout=log,
            stderr=subprocess.STDOUT,
        )
    try:
        yield f"{_address(folder / 'RUNTIME')}doc/tree/robot.ipynb?token=secret", folder
    finally:
        server.terminate()
        try:
            server.wait(20.0)
        except subprocess.TimeoutExpired:
            server.kill()
            server.wait()


def _address(folder: Path) -> str:
    end = time.monotonic() + 60.0
    while time.monotonic() < end:
        for file in folder.glob("jpserver-*.json"):
            try:
                return str(json.loads(file.read_text("utf-8"))["url"])
            except (ValueError, KeyError):
                pass
        time.sleep(0.1)
    raise AssertionError("JupyterLab did not start")


@pytest.fixture(scope="module")
def notebook(browser: Any, lab: tuple[str, Path]) -> Iterator[Any]:
    with visitor(browser, viewport={"width": 1100, "height": 900}) as context:
        yield _running(context.new_page(), lab[0])


def _running(tab: Any, address: str) -> Any:
    """Open the notebook in a tab and run its first cell."""
    tab.set_default_timeout(90_000)
    # The dialogs of JupyterLab on a slow machine: which kernel to use, or that the server does not answer.
    tab.add_locator_handler(tab.locator("dialog.jp-Dialog .jp-mod-accept"), lambda button: button.first.click())
    tab.goto(address)
    tab.wait_for_selector(".jp-Notebook .jp-CodeCell")
    tab.wait_for_selector("[data-status='idle']")
    _run_cell(tab, 0)
    tab.frame_locator(FRAME).locator("body[data-live='live']").wait_for()
    return tab


def _run_cell(tab: Any, number: int) -> None:
    """Click into a cell and press Shift+Enter; again where JupyterLab drops it, until its kernel has settled."""
    prompt = tab.locator(".jp-CodeCell .jp-InputPrompt").nth(number)
    for _ in range(10):
        tab.locator(".jp-CodeCell .cm-content").nth(number).click()
        tab.keyboard.press("Shift+Enter")
        end = time.monotonic() + 3.0
        while time.monotonic() < end:
            if prompt.inner_text() != "[ ]:":
                return
            time.sleep(0.05)
    raise AssertionError(f"cell {number} does not run")


def _robot(tab: Any) -> Any:
    return tab.query_selector(FRAME).content_frame()


def test_what_the_next_cell_displays_is_seen_in_the_output_above(notebook: Any, nao: nk.NaoModel) -> None:
    assert _robot(notebook).evaluate("() => [...naoKin.q]") == pytest.approx(nao.posture("Crouch"))
    _run_cell(notebook, 1)
    _robot(notebook).wait_for_function("() => naoKin.q[0] === 1")


def test_a_joint_moved_in_the_output_is_known_in_the_next_cell(notebook: Any) -> None:
    notebook.frame_locator(FRAME).locator('.joint[data-joint="HeadPitch"] .number').click()
    notebook.keyboard.type("10")
    notebook.keyboard.press("Enter")
    _robot(notebook).wait_for_function("() => naoKin.q[1] > 0.1")
    _run_cell(notebook, 2)
    printed = notebook.locator(".jp-CodeCell").nth(2).locator(".jp-OutputArea-output")
    printed.wait_for()
    assert float(printed.inner_text().split()[-1]) == pytest.approx(0.1745, abs=1e-4)


def test_a_frame_that_is_loaded_again_is_live_again_with_all_that_is_new(notebook: Any) -> None:
    _robot(notebook).evaluate("() => { window.old = true; }")
    # What JupyterLab does with outputs that are scrolled out of sight and back again.
    notebook.evaluate(f"() => {{ const f = document.querySelector('{FRAME}'); f.parentNode.append(f); }}")
    notebook.wait_for_function(
        f"() => {{ const w = document.querySelector('{FRAME}').contentWindow; return w.naoKin && !w.old; }}"
    )
    _robot(notebook).wait_for_function("() => document.body.dataset.live === 'live' && naoKin.q[0] === 1")


def test_a_closed_viewer_leaves_a_robot_that_is_no_longer_live(notebook: Any) -> None:
    _run_cell(notebook, 3)
    notebook.frame_locator(FRAME).locator("body[data-live='ended']").wait_for()
    assert _robot(notebook).evaluate("() => naoKin.q[0]") == 1


def test_an_exported_notebook_shows_the_robot_without_kernel_and_network(
    notebook: Any, browser: Any, lab: tuple[str, Path], nao: nk.NaoModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    notebook.keyboard.press("ControlOrMeta+S")
    path = lab[1] / "robot.ipynb"
    end = time.monotonic() + 30.0
    while "data-nao-kin" not in path.read_text("utf-8"):
        assert time.monotonic() < end
        time.sleep(0.1)
    monkeypatch.setenv("JUPYTER_DATA_DIR", str(lab[1]))
    exported, _ = pytest.importorskip("nbconvert").HTMLExporter().from_filename(str(path))
    path.with_suffix(".html").write_text(exported, encoding="utf-8")
    with visitor(browser, offline=True) as context:
        tab = context.new_page()
        tab.goto(path.with_suffix(".html").as_uri())
        tab.frame_locator(FRAME).locator("body[data-ready]").wait_for(timeout=60_000)
        robot = _robot(tab)
        assert robot.evaluate("() => [...naoKin.q]") == pytest.approx(nao.posture("Crouch"))
        assert robot.evaluate("() => document.body.dataset.live") is None


# --- without a notebook -----------------------------------------------------------------------------------------------


def test_the_html_of_a_viewer_is_its_page_in_a_frame_and_needs_no_server(
    browser: Any, nao: nk.NaoModel, tmp_path: Path
) -> None:
    with Viewer(nao) as viewer:
        viewer.display(nao.posture("Sit"))
        html = viewer._repr_html_()
        assert viewer.url not in html
    assert len(html) < 1_250_000
    path = tmp_path / "output.html"
    path.write_text(f"<!DOCTYPE html><title>Output</title>{html}", encoding="utf-8")
    with visitor(browser) as context:
        tab = context.new_page()
        tab.goto(path.as_uri())
        tab.frame_locator("iframe").locator("body[data-ready]").wait_for(timeout=30_000)
        assert tab.frames[1].evaluate("() => [...naoKin.q]") == pytest.approx(nao.posture("Sit"))


def test_a_name_cannot_break_out_of_the_frame() -> None:
    made = frame('</script></iframe>"><b>', name='"><script>')
    inner = r'<iframe data-nao-kin="[^"<>]*" title="Robot viewer" srcdoc="[^"<>]*"[^<>]*></iframe>'
    assert re.fullmatch(f"<div>{inner}</div>", made)


@pytest.mark.parametrize("where", ["terminal", "plain notebook"])
def test_without_anywidget_or_kernel_a_viewer_shows_what_can_be_shown(
    nao: nk.NaoModel, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], where: str
) -> None:
    IPython = pytest.importorskip("IPython")
    shown: list[Any] = []
    shell = object() if where == "terminal" else SimpleNamespace(kernel=object())
    monkeypatch.setattr(IPython, "get_ipython", lambda: shell)
    monkeypatch.setattr("IPython.display.display", lambda *things: shown.extend(things))
    monkeypatch.setattr("nao_kin.viewer.viewer.has_bridge", lambda: False)
    Viewer(nao)._ipython_display_()
    if where == "terminal":
        assert (capsys.readouterr().out, shown) == ("<Viewer of nao_v6, not live>\n", [])
    else:
        assert len(shown) == 1
        assert "nao-kin[notebook]" in shown[0].data
        assert shown[0].data.startswith("<div><iframe")


def test_the_output_of_a_viewer_is_the_robot_and_nothing_else(tmp_path: Path) -> None:
    """No warning, whose text would have a path of this machine, and no line of its own, with anywidget and without."""
    client = pytest.importorskip("nbclient")
    nbformat = pytest.importorskip("nbformat")
    pytest.importorskip("ipykernel")
    shown = ("viewer = nk.Viewer(nao)", "viewer", "display(HTML(viewer._repr_html_()))", "viewer.close()")
    sources = (
        "import warnings\nwarnings.simplefilter('always')",
        "import nao_kin as nk\nfrom IPython.display import HTML, display\nnao = nk.load_nao()",
        *shown,
        "import sys\nfor name in [*sys.modules]:\n    if name.split('.')[0] == 'anywidget': sys.modules[name] = None",
        *shown,
    )
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(source) for source in sources])
    own = {name: str(tmp_path / name) for name in ("IPYTHONDIR", "JUPYTER_CONFIG_DIR", "JUPYTER_DATA_DIR")}
    environment = {**os.environ, **own, "PYTHONPATH": str(Path(nk.__file__).parent.parent)}
    client.NotebookClient(notebook, timeout=120, kernel_name="python3").execute(env=environment)
    outputs = [[output["output_type"] for output in cell.outputs] for cell in notebook.cells]
    one = ["display_data"]
    assert outputs == [[], [], [], 2 * one, one, [], [], [], one, one, []]


class _Widget:
    """A stand-in for the widget that a bridge uses, without a notebook."""

    def __init__(self) -> None:
        self.sent: list[list[bytes]] = []
        self.closed = 0

    def send(self, content: dict[str, Any], buffers: list[bytes]) -> None:
        assert content == {"kind": "messages"}
        self.sent.append(buffers)

    def on_msg(self, listener: Any) -> None:
        self.listener = listener

    def close(self) -> None:
        self.closed += 1


@pytest.fixture
def widget(monkeypatch: pytest.MonkeyPatch) -> _Widget:
    made = _Widget()
    monkeypatch.setattr("nao_kin.viewer.notebook._widget_class", lambda: lambda frame: made)
    return made


def test_a_frame_that_opens_gets_what_has_changed_since_it_was_made_and_nothing_else(
    nao: nk.NaoModel, widget: _Widget
) -> None:
    viewer = Viewer(nao)
    bridge = Bridge(viewer._messages, lambda answer: None)
    q = nao.posture("Crouch")
    for _ in range(100):
        viewer.display(q)
    assert widget.sent == []
    widget.listener(widget, {"kind": "open"}, [])
    _wait_for(lambda: widget.sent)
    assert widget.sent == [[viewer._messages.get("joints")]]
    bridge.close()
    viewer.display(nao.posture("Stand"))
    time.sleep(0.1)
    assert (len(widget.sent), widget.closed) == (1, 1)


def test_a_stream_of_configurations_is_sent_no_oftener_than_it_can_be_drawn(nao: nk.NaoModel, widget: _Widget) -> None:
    viewer = Viewer(nao)
    bridge = Bridge(viewer._messages, lambda answer: None)
    widget.listener(widget, {"kind": "open"}, [])
    end = time.monotonic() + 0.5
    while time.monotonic() < end:
        viewer.display(nao.random())
    viewer.display(nao.posture("Sit"))
    _wait_for(lambda: widget.sent and widget.sent[-1] == [viewer._messages.get("joints")])
    assert len(widget.sent) <= 20
    bridge.close()


def test_a_viewer_that_is_dropped_takes_its_bridges_along(nao: nk.NaoModel, widget: _Widget) -> None:
    from nao_kin.viewer.notebook import bridge_of

    viewer = Viewer(nao)
    dropped = weakref.ref(viewer)
    bridge_of(viewer, viewer._messages, viewer._receive)
    widget.listener(widget, {"kind": "open"}, [])
    widget.listener(widget, "nonsense", [])
    del viewer
    gc.collect()
    assert dropped() is None
    _wait_for(lambda: widget.closed)


def _wait_for(condition: Any, seconds: float = 5.0) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)
