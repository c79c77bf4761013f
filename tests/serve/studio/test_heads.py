"""Heads without shapes: found landmarks are told, and what cannot be fitted is said in one line."""

from __future__ import annotations

from base64 import b64decode
from collections.abc import Iterator
from types import SimpleNamespace

import numpy as np
import pytest

from mien.fit.landmarks import needed_landmarks
from mien.formats.gltf import write_glb
from tests.faces import tiny_animation, tiny_face
from tests.serve.studio.client import Client, studio

PLACES = {name: np.array([number, 0.0, 0.1]) for number, name in enumerate(needed_landmarks())}


@pytest.fixture(scope="module")
def client() -> Iterator[Client]:
    with studio() as running:
        yield running


@pytest.fixture(scope="module")
def content(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    path = tmp_path_factory.mktemp("heads") / "own.glb"
    write_glb(tiny_animation(1), tiny_face(), path)
    return path.read_bytes()


def test_a_head_is_told_with_its_landmarks_and_fitted_with_those_that_were_moved(
    client: Client, content: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = {}

    def fit(mesh: object, landmarks: dict, *_: object) -> SimpleNamespace:
        asked.update(landmarks)
        refusal = SimpleNamespace(kind="refusal", words="the lips lie on the nose")
        return SimpleNamespace(findings=(refusal,), lip_gap=0.1, lid_gap=0.1)

    monkeypatch.setattr("mien.serve.studio.heads.find_head", lambda *_: SimpleNamespace(places=PLACES))
    monkeypatch.setattr("mien.serve.studio.heads.fit_head", fit)
    opened = client.finished(client.ask("POST", "/api/heads?name=own.glb", content))
    told = client.ask("GET", f"/api/heads/{opened['head']}").json
    assert set(told["landmarks"]) == set(needed_landmarks())
    assert told["landmarks"]["chin"]["place"] == PLACES["chin"].tolist()
    assert len(b64decode(told["vertices"])) % 12 == 0
    fitted = client.finished(
        client.ask("POST", f"/api/heads/{opened['head']}/fit", {"landmarks": {"chin": [0.0, -0.05, 0.02]}})
    )
    assert asked == {"chin": (0.0, -0.05, 0.02)}
    assert (fitted["state"], fitted["field"]) == ("failed", "face")
    assert "the lips lie on the nose" in fitted["error"]


def test_what_is_no_head_is_one_line(client: Client) -> None:
    told = client.finished(client.ask("POST", "/api/heads", b"no file at all"))
    assert (told["state"], told["field"]) == ("failed", "face")
    assert "/" not in told["error"]
