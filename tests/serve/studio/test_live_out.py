"""What the page shows, sent to an engine: received on a socket, decoded by python-osc and by Live Link's layout."""

from __future__ import annotations

import socket
import struct
import time
from collections.abc import Iterator

import pytest
from pythonosc.osc_bundle import OscBundle

from mien.serve.studio.live_out import Shown
from tests.serve.studio.client import Client, studio


@pytest.fixture(scope="module")
def client() -> Iterator[Client]:
    with studio() as running:
        yield running


@pytest.fixture(scope="module")
def take(client: Client) -> str:
    return client.take(text="Hi.", fps=30)


@pytest.fixture
def engine() -> Iterator[socket.socket]:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as heard:
        heard.bind(("127.0.0.1", 0))
        heard.settimeout(20)
        yield heard


def test_moments_run_stand_and_loop():
    assert Shown("a", 1.0, 0.0).moment(9.0, 5.0) == 1.0
    assert Shown("a", 1.0, 0.5, since=2.0).moment(4.0, 5.0) == 2.0
    assert Shown("a", 0.5, 1.0, (1.0, 2.0)).moment(2.75, 5.0) == 1.25
    assert Shown("a", 4.0, 1.0).moment(9.0, 5.0) == 5.0


def test_an_engine_hears_what_the_page_shows_and_edits_as_they_are_made(
    client: Client, take: str, engine: socket.socket
):
    to = f"127.0.0.1:{engine.getsockname()[1]}"
    told = client.ask("POST", "/api/live", {"kind": "vmc", "to": to, "take": take, "at": 0}).json
    assert told["sending"]
    assert told["to"] == to

    def jaw() -> float:
        while True:
            messages = [one for one in OscBundle(engine.recv(65536)) if one.address == "/VMC/Ext/Blend/Val"]
            return dict(one.params for one in messages)["JawOpen"]

    before = jaw()
    keys = [{"anchor": {"word": None, "pause": 0, "share": 0.0}, "value": 1}]
    edits = [{"kind": "channel", "channel": "jawOpen", "mode": "replace", "keys": keys}]
    client.ask("PUT", f"/api/takes/{take}/edits", {"edits": edits})
    assert before < 0.5
    until = time.monotonic() + 20
    while jaw() < 0.9:
        assert time.monotonic() < until, "the engine never saw the edit"
    assert client.ask("DELETE", "/api/live").json["sending"] is False


def test_live_link_under_a_name_of_ones_own(client: Client, take: str, engine: socket.socket):
    to = f"127.0.0.1:{engine.getsockname()[1]}"
    client.ask("POST", "/api/live", {"kind": "livelink", "to": to, "subject": "Anna", "take": take, "at": 0.1})
    packet = engine.recv(65536)
    (length,) = struct.unpack_from(">I", packet, 1)
    start = 5 + length
    (length,) = struct.unpack_from(">I", packet, start)
    assert packet[start + 4 : start + 4 + length] == b"Anna"
    client.ask("DELETE", "/api/live")


@pytest.mark.parametrize(
    ("asked", "field"),
    [
        ({"kind": "smoke", "to": "localhost"}, "kind"),
        ({"kind": "vmc", "to": "localhost:99999"}, "to"),
        ({"kind": "vmc", "to": "", "take": 3}, "take"),
    ],
)
def test_what_cannot_be_used_is_told_with_its_field(client: Client, take: str, asked: dict, field: str):
    answer = client.ask("POST", "/api/live", {"take": take, **asked})
    assert (answer.status, answer.json["field"]) == (400, field)
