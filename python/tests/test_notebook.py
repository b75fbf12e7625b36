"""The live view in a notebook: its page is served, framed, and speaks with the kernel."""

from __future__ import annotations

import re
import sys
import time
import urllib.request
from pathlib import Path

import gemtrace
import pytest


def test_the_page_is_served_until_it_is_closed(scene: gemtrace.Scene, tmp_path: Path) -> None:
    with gemtrace.view(scene, backend="cpu", height=300, output=tmp_path) as live:
        assert re.fullmatch(r"http://127\.0\.0\.1:\d+/\?token=\w+", live.address) and live.address in repr(live)
        with urllib.request.urlopen(f"{live.address}&embed=1", timeout=30) as answer:
            assert answer.status == 200 and b"<title>" in answer.read()
            assert "frame-ancestors" not in answer.headers["Content-Security-Policy"]
    live.close()
    for _ in range(50):
        try:
            urllib.request.urlopen(live.address, timeout=5)
        except OSError:
            break
        time.sleep(0.1)
    else:
        pytest.fail("it is still served")


def test_the_notebooks_frame(scene: gemtrace.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    with gemtrace.view(scene, backend="cpu", height=300) as live:
        assert live.pose is None
        shown = live._repr_mimebundle_()
        assert "application/vnd.jupyter.widget-view+json" in (shown[0] if isinstance(shown, tuple) else shown)
        frame = live._widget()
        assert frame is not None and frame.address == f"{live.address}&embed=1" and frame.height == 300
        sent: list[object] = []
        monkeypatch.setattr(frame, "send", sent.append)
        live.set("material", "ruby")
        assert sent == [{"gemtrace": 1, "type": "set", "path": "material", "value": "ruby"}]
        frame.pose = [0.0, 0.0, 0.6, 0.8]
        assert live.pose == (0.0, 0.0, 0.6, 0.8)
    # Without anywidget there is the frame alone.
    monkeypatch.setitem(sys.modules, "gemtrace._widget", None)
    with gemtrace.view(scene, backend="cpu") as live:
        assert "<iframe" in live._repr_mimebundle_()["text/html"] and live.pose is None
        with pytest.raises(gemtrace.InputError, match="anywidget"):
            live.set("material", "ruby")


def test_views_that_are_none(scene: gemtrace.Scene) -> None:
    with pytest.raises(gemtrace.InputError, match="unknown backend"):
        gemtrace.view(scene, backend="gpu")
    with pytest.raises(gemtrace.InputError, match="height: 0"):
        gemtrace.view(scene, height=0)
    with pytest.raises(AttributeError):
        gemtrace.view(None)  # type: ignore[arg-type]
