"""The server of `sdfstent app`: whom it answers, what it opens, and that nothing is left of it."""

import asyncio
import http.client
import os
import re
import socket
import stat
import struct
import sys
import time
from pathlib import Path

import psutil
import pytest
from app_server import IS_APP_INSTALLED, AppServer, get
from child_processes import PATIENCE

from SDFStentLib.cli import main
from SDFStentLib.validation import InputError

if not IS_APP_INSTALLED:
    pytest.skip("the extra app is not installed", allow_module_level=True)

import aiohttp
import msgpack

from SDFStentApp.chunks import Chunks

HELLO = {
    "wslink": "1.0",
    "id": "system:c0:0",
    "method": "wslink.hello",
    "args": [{"secret": "wslink-secret"}],
    "kwargs": {},
}
"""What a page's script says first."""


def way_from(server):
    """Where the server sends a browser for a page of its own."""
    connection = http.client.HTTPConnection(server.origin.removeprefix("http://"))
    connection.request("GET", f"/{server.token}/")
    way = connection.getresponse().headers["Location"]
    connection.close()
    return way


@pytest.fixture
def a_server(tmp_path):
    """One that a test ends."""
    server = AppServer(tmp_path / "workshop", "--keep", "0.2")
    yield server
    server.close()


@pytest.fixture(scope="module")
def the_server(tmp_path_factory):
    server = AppServer(tmp_path_factory.mktemp("workshop"), "--demo", "--keep", "300")
    yield server
    assert server.interrupt() == ""


@pytest.fixture(scope="module")
def the_page(the_server):
    """The process of its first page, and what a browser got: status, text and address."""
    answer = get(the_server.address)
    return the_server.pages()[0], answer


@pytest.fixture(scope="module")
def another_page(the_server, the_page):
    """The process that waited for the next page, that of the page, and where a browser is sent."""
    spare, known, deadline = [], the_server.pages(), time.monotonic() + PATIENCE
    while not spare and time.monotonic() < deadline:
        children = psutil.Process(the_server.process.pid).children()
        spare = [child for child in children if child not in known]
    way = way_from(the_server)
    assert get(the_server.address + way)[0] == 200
    (page,) = (one for one in the_server.pages() if one not in known)
    return spare[0], page, way


def test_only_who_knows_the_token_is_answered(the_server, the_page):
    page, (status, text, address) = the_page
    assert re.findall(r'(?:src|href)="(?:/|\w+:)', text) == []
    assert (status, '<div id="app">' in text) == (200, True)
    assert address.startswith(the_server.address)
    kept = Path(f"{the_server.folder}-state")
    written = {path.name for path in kept.rglob("*.vtp")}
    assert written == {"surface.vtp", "centerline.vtp"}  # of --demo
    ports = [c.laddr.port for c in page.net_connections() if c.status == psutil.CONN_LISTEN]
    for port in ports:  # the process of the page itself, without the server in front of it
        assert get(f"http://127.0.0.1:{port}/index.html")[0] == 403
    assert len(ports) == 1
    assert the_server.origin.startswith("http://127.0.0.1:")
    token = the_server.token
    for path in ("", "/", "/index.html", "/x/", f"/{token[:-1]}/", "/../", "/%2e%2e/"):
        status, text, _ = get(the_server.origin + path)
        assert status == 403, path
        assert text == (
            "SDF Stent: This address is not complete: use the one that sdfstent app has printed.\n"
        )
    status, _, _ = get(f"{the_server.origin}/x/ws", Upgrade="websocket", Connection="Upgrade")
    assert status == 403


def answers(server, *lines):
    """What a server says, to the end, to who sends some lines."""
    host, port = server.origin.removeprefix("http://").split(":")
    with socket.create_connection((host, int(port)), timeout=PATIENCE) as wire:
        wire.sendall(b"\r\n".join([line.encode() for line in lines]) + b"\r\n\r\n")
        return wire.recv(4096).decode(errors="replace")


def test_who_does_not_speak_http_is_answered_and_nobody_else_hears_of_it(the_server):
    for line in ("GARBAGE", "GET / HTTP/9.9", f"GET /{'a' * 100_000} HTTP/1.1", "\x16\x03\x01"):
        assert " 400 " in answers(the_server, line).splitlines()[0]
    assert " 400 " in answers(the_server, "POST / HTTP/1.1", "Host: x", "Content-Length: -5")


def test_a_page_takes_no_messages_for_another_site(the_server, the_page):
    _, (_, _, address) = the_page
    path = "/" + address.partition("://")[2].partition("/")[2].replace("index.html", "ws")
    host = the_server.origin.removeprefix("http://")
    asks = [
        f"GET {path} HTTP/1.1", f"Host: {host}", "Upgrade: websocket", "Connection: Upgrade",
        "Sec-WebSocket-Version: 13", "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==",
    ]  # fmt: skip
    for origin in ("http://elsewhere.org", "null", f"http://{host}.org", "http://localhost:1"):
        said = answers(the_server, *asks, f"Origin: {origin}")
        assert " 403 " in said.splitlines()[0], origin
        assert "Another site has asked for this page." in said
    for own in ([], [f"Origin: http://{host}"], [f"Origin: https://{host}"]):
        assert " 101 " in answers(the_server, *asks, *own).splitlines()[0]


async def end_of(wire):
    """What ends it; the page may have sent a picture before."""
    # Ends: with that.
    while (said := await wire.receive(timeout=PATIENCE)).type is aiohttp.WSMsgType.BINARY:
        pass
    return said.type


async def told_too_much(address, frame):
    """What becomes of who sends a frame to a page, and of two that look at it in turn."""
    async with aiohttp.ClientSession() as client:
        first = await client.ws_connect(address)
        await first.send_bytes(chunk(msgpack.packb(HELLO)))
        await first.receive()  # the page answers
        await first.send_bytes(frame)
        said = await end_of(first)
        second = await client.ws_connect(address)
        third = await client.ws_connect(address)
        return said, await end_of(second), third.closed


def chunk(content, length=None):
    return struct.pack("<III", 7, 0, len(content) if length is None else length) + content


def test_nobody_makes_a_page_take_memory_and_two_windows_do_not_share_a_picture(
    the_server, another_page
):
    _, page, way = another_page
    address = the_server.address.replace("http", "ws", 1) + way.replace("index.html", "ws")
    before = page.memory_info().rss
    closed = (aiohttp.WSMsgType.CLOSE, aiohttp.WSMsgType.CLOSE, False)
    for frame in (chunk(b"x", 1_500_000_000), b"", b"abc", chunk(b"more than it says", 3)):
        assert asyncio.run(told_too_much(address, frame)) == closed
    assert page.memory_info().rss < before + 300e6


def test_messages_are_bounded_together():
    chunks = Chunks(100)
    assert chunks.are_bounded(chunk(b"x" * 40, 60))
    assert not Chunks(50).are_bounded(chunk(b"x" * 40, 60))
    assert chunks.are_bounded(chunk(b"x" * 20, 60))  # the first is there, whole
    assert all(chunks.are_bounded(chunk(b"x" * 50)) for _message in range(100))


def test_another_process_is_ready_for_the_next_page(another_page):
    spare, page, address = another_page
    assert page == spare
    assert re.fullmatch(r"[\w-]+/index.html", address)  # relative, behind any proxy


def test_a_page_that_has_failed_is_loaded_again_at_once_and_ctrl_c_leaves_nothing(a_server):
    status, text, address = get(a_server.address)
    (page,) = a_server.pages()
    assert (status, '<div id="app">' in text) == (200, True)
    page.kill()  # and before the server has heard of it:
    assert get(address)[:2] == (status, text)
    (page,) = a_server.pages()
    assert a_server.interrupt() == ""
    assert a_server.process.returncode == 0
    assert not page.is_running()
    assert list(a_server.folder.iterdir()) == []


@pytest.mark.skipif(os.name == "nt", reason="the browser is a script of the shell")
def test_a_server_that_is_killed_leaves_no_page_and_the_next_one_opens_the_browser(
    a_server, tmp_path
):
    get(a_server.address)
    processes = psutil.Process(a_server.process.pid).children()  # and one that waits
    a_server.process.kill()
    a_server.process.wait()
    assert psutil.wait_procs(processes, PATIENCE)[1] == []
    assert list(a_server.folder.iterdir()) == []
    browser, opened = tmp_path / "browser", tmp_path / "opened"
    browser.write_text(f'#!/bin/sh\necho "$@" > "{opened}"\n', encoding="utf-8")
    browser.chmod(0o755)
    port = a_server.origin.rsplit(":", 1)[1]
    again = AppServer(a_server.folder, "--port", port, browser=browser)
    assert again.origin == a_server.origin
    assert get(a_server.address)[0] == 403  # the token of before
    for _attempt in range(10 * PATIENCE):
        if opened.exists() and opened.read_text(encoding="utf-8"):
            break
        time.sleep(0.1)
    # Whoever lists the processes of this machine sees a file that only its owner can read.
    way = Path(opened.read_text(encoding="utf-8").strip().removeprefix("file://"))
    assert again.token not in str(way)
    assert f"url={again.address}" in way.read_text(encoding="utf-8")
    assert stat.S_IMODE(way.stat().st_mode) == 0o600
    again.close()
    assert not way.exists()


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--plans", "/dev/null/x"], "--plans: expected a folder that can be made, got"),
        (["--host", "256.1.1.1", "--no-browser"], "expected an address that is free"),
    ],
)
def test_what_cannot_be_served_is_refused_in_a_sentence(a_folder, capsys, arguments, sentence):
    assert main(["app", *arguments]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("sdfstent app: ")
    assert sentence in line


def test_without_the_extra_it_says_what_to_install(capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "trame_rca", None)
    assert main(["app", "--demo"]) == 2
    assert capsys.readouterr().err == (
        "sdfstent app: expected the packages of the extra app, trame_rca is missing; "
        "install them: pip install 'sdfstent[app]'.\n"
    )


def test_plans_are_kept_for_a_day_and_found_by_the_name_of_their_page(tmp_path):
    from SDFStentApp.kept import KeptPlans

    for name, hours in (("new", 23), ("old", 25), ("begun", 25)):
        folder = tmp_path / name
        folder.mkdir()
        kept = folder / ("plan.json" if name != "begun" else "surface.vtp")
        kept.touch()
        for path in (kept, folder):
            os.utime(path, (time.time() - 3600 * hours,) * 2)
    plans = KeptPlans(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["new"]
    assert plans.has("new")
    for name in ("", "old", "..", "../new", "new/", "n\u00e9w", "new\0"):
        assert not plans.has(name)
    nowhere = KeptPlans(None)
    assert not nowhere.has("new")
    assert nowhere.folder("new") is None


def test_a_page_opens_files_of_the_named_folders_only(tmp_path):
    from SDFStentApp.files import Folders

    inside, outside = tmp_path / "in", tmp_path / "out"
    for folder in (inside / "deep", outside):
        folder.mkdir(parents=True)
        (folder / "wall.vtp").touch()
    os.symlink(outside, inside / "link")
    folders = Folders([inside])
    assert folders.listing((".vtp",)) == [str(inside / "deep" / "wall.vtp")]
    assert folders.checked(inside / "deep" / "wall.vtp") == inside / "deep" / "wall.vtp"
    for path in (
        outside / "wall.vtp",
        inside / ".." / "out" / "wall.vtp",
        inside / "link" / "wall.vtp",
        f"{inside}er/wall.vtp",
        "wall.vtp",
        "/etc/passwd",
        "a\0b",
    ):
        with pytest.raises(InputError, match="expected a file in a folder that was named"):
            folders.checked(path)
    assert Folders([]).listing((".vtp",)) == []
