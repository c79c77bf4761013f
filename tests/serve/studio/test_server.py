"""The contract of the studio's HTTP interface, end to end with the real voice and performer."""

from __future__ import annotations

import gzip
import io
import time
import zipfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from mien.core import channels
from mien.formats.gltf import write_glb
from tests.faces import tiny_animation, tiny_face
from tests.serve.studio.client import Client, form, studio

LINE = "I never said that."


@pytest.fixture(scope="module")
def client() -> Iterator[Client]:
    with studio() as running:
        yield running


@pytest.fixture(scope="module")
def take(client: Client) -> str:
    return client.take(text=LINE, emotion="angry:0.7", fps=30)


def test_it_tells_what_it_offers(client: Client) -> None:
    told = client.ask("GET", "/api/about").json
    assert told["performers"][0] == "default"
    assert "happy" in told["emotions"]
    assert [channel["name"] for channel in told["channels"]] == list(channels.ALL)
    assert ".mp4" in told["exports"]
    assert told["limits"]["text_characters"] == client.workshop.limits.text_characters


def test_the_default_face_has_every_channel_of_the_muscles_and_the_tongue(client: Client) -> None:
    answer = client.ask("GET", "/api/faces/default.glb")
    assert answer.headers["content-type"] == "model/gltf-binary"
    assert answer.body[:4] == b"glTF"
    assert all(name.encode() in answer.body for name in channels.WEIGHTS)


def test_a_take_is_told_with_its_words_phones_and_emotions(client: Client, take: str) -> None:
    told = client.ask("GET", f"/api/takes/{take}").json
    assert [word for _, _, word in told["words"]] == ["i", "never", "said", "that"]
    assert told["phones"][0][0] == 0
    assert told["phones"][-1][1] == pytest.approx(told["seconds"])
    assert told["emotions"][0]["name"] == "angry"
    assert told["request"]["text"] == LINE
    assert told["revision"] == 1


def test_frames_are_those_of_the_library(client: Client, take: str) -> None:
    import mien

    answer = client.ask("GET", f"/api/takes/{take}/frames")
    told = client.ask("GET", f"/api/takes/{take}").json
    frames = np.frombuffer(answer.body, "<f4").reshape(told["frames"], len(told["channels"]))
    same = mien.say(LINE, emotion="angry:0.7", fps=30).channels.values.astype("<f4")
    assert np.array_equal(frames, same)


def test_the_sound_comes_whole_and_in_parts(client: Client, take: str) -> None:
    whole = client.ask("GET", f"/api/takes/{take}/sound.wav")
    part = client.ask("GET", f"/api/takes/{take}/sound.wav", Range="bytes=10-19")
    assert whole.body[:4] == b"RIFF"
    assert part.status == 206
    assert part.body == whole.body[10:20]
    assert client.ask("GET", f"/api/takes/{take}/sound.wav", Range="bytes=999999999-").status == 416


def test_another_emotion_sounds_so_without_speaking_again(
    client: Client, take: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def never(*_: object, **__: object) -> None:
        raise AssertionError("the text was spoken again")

    monkeypatch.setattr("mien.speech.synthesis.synthesise", never)
    take = client.ask("POST", f"/api/takes/{take}/copy").json["take"]
    old = client.workshop.takes.get(take).animation
    told = client.finished(client.ask("POST", f"/api/takes/{take}/redo", {"emotion": "sad"}))
    assert client.ask("GET", f"/api/takes/{told['take']}").json["emotions"][0]["name"] == "sad"
    new = client.workshop.takes.get(take).animation
    assert new.utterance.duration > 1.1 * old.utterance.duration
    told = client.finished(client.ask("POST", f"/api/takes/{take}/redo", {"emotion": "sad", "voice_emotion": "off"}))
    plain = client.workshop.takes.get(told["take"]).animation
    assert old.utterance.duration < plain.utterance.duration < new.utterance.duration  # the old one is angry


def test_a_trial_is_heard_and_seen_as_it_would_be_performed_and_nothing_of_it_is_kept(
    client: Client, take: str
) -> None:
    take = client.ask("POST", f"/api/takes/{take}/copy").json["take"]
    before, steps = client.ask("GET", f"/api/takes/{take}").json, client.ask("GET", f"/api/takes/{take}/steps").body
    asked = {"emotion": "sad:0.9", "voice_emotion": 0.5}
    first = client.finished(client.ask("POST", f"/api/takes/{take}/trial", {"voice_emotion": 0.3}))["take"]
    trial = client.finished(client.ask("POST", f"/api/takes/{take}/trial", asked))["take"]
    heard, seen = (client.ask("GET", f"/api/takes/{trial}/{part}").body for part in ("sound.wav", "frames"))
    assert client.ask("GET", f"/api/takes/{take}").json == before
    assert client.ask("GET", f"/api/takes/{take}/steps").body == steps
    assert client.ask("GET", f"/api/takes/{first}").status == 404
    assert trial not in [one["take"] for one in client.ask("GET", "/api/takes").json["takes"]]
    client.finished(client.ask("POST", f"/api/takes/{take}/redo", asked))
    assert client.ask("GET", f"/api/takes/{take}/sound.wav").body == heard
    assert client.ask("GET", f"/api/takes/{take}/frames").body == seen
    assert client.ask("POST", f"/api/takes/{take}/trial", {"voice_emotion": 7}).json["field"] == "voice_emotion"


def test_an_uploaded_sound_is_performed(client: Client, take: str) -> None:
    sound = client.ask("GET", f"/api/takes/{take}/sound.wav").body
    body, kind = form({"text": LINE, "emotion": "happy:0.5", "fps": "25"}, sound)
    told = client.finished(client.ask("POST", "/api/takes", body, Content_Type=kind))
    again = client.ask("GET", f"/api/takes/{told['take']}").json
    assert again["from_sound"]
    assert again["fps"] == 25
    assert [word for _, _, word in again["words"]] == ["i", "never", "said", "that"]


def test_one_format_is_a_file_and_several_are_an_archive(client: Client, take: str) -> None:
    one = client.finished(client.ask("POST", f"/api/takes/{take}/export", {"formats": [".csv"]}))
    file = client.ask("GET", one["file"])
    assert file.body.startswith(b"Timecode")
    assert file.headers["content-disposition"].startswith('attachment; filename="i-never-said-that.csv"')
    two = client.finished(client.ask("POST", f"/api/takes/{take}/export", {"formats": [".TextGrid", ".json"]}))
    with zipfile.ZipFile(io.BytesIO(client.ask("GET", two["file"]).body)) as archive:
        assert archive.namelist() == ["i-never-said-that.TextGrid", "i-never-said-that.json"]


def edits(*some: dict[str, object]) -> dict[str, object]:
    return {"format": "mien-edits", "version": 1, "edits": list(some)}


BORDER = {"kind": "border", "phone": {"word": "never", "phone": 3}, "edge": "end", "shift": 0.05}
JAW = {
    "kind": "channel",
    "channel": "jawOpen",
    "mode": "replace",
    "keys": [{"anchor": {"word": "that", "phone": 1, "share": share}, "value": 0.9} for share in (0.1, 0.9)],
}
RISE = {
    "kind": "intensity",
    "emotion": "angry",
    "points": [
        {"anchor": {"word": "i", "phone": 0, "share": 0.0}, "value": 0.0},
        {"anchor": {"word": "that", "phone": 2, "share": 1.0}, "value": 1.0},
    ],
}


def frames(client: Client, take: str, query: str = "") -> np.ndarray:
    told = client.ask("GET", f"/api/takes/{take}").json
    body = client.ask("GET", f"/api/takes/{take}/frames{query}").body
    return np.frombuffer(body, "<f4").reshape(told["frames"], len(told["channels"]))


def test_edits_change_what_they_should_and_come_off_again(client: Client) -> None:
    take = client.take(text=LINE, emotion="angry:0.7", fps=30)
    plain = frames(client, take)
    jaw = client.ask("PUT", f"/api/takes/{take}/edits", edits(JAW)).json
    assert jaw["revision"] == 2
    assert jaw["lost"] == []
    first, last = jaw["frames_changed"]
    edited = frames(client, take)
    assert np.array_equal(edited[:first], plain[:first])
    assert np.array_equal(edited[last + 1 :], plain[last + 1 :])
    assert (edited[first : last + 1] != plain[first : last + 1]).any()
    assert np.array_equal(frames(client, take, "?plain=1"), plain)
    everything = client.ask("PUT", f"/api/takes/{take}/edits", edits(JAW, BORDER, RISE)).json
    told = everything["take"]
    assert told["words"][1][1] == pytest.approx(told["plain_words"][1][1] + 0.05)
    assert told["emotions"][0]["points"][0][1] == 0.0
    off = client.ask("PUT", f"/api/takes/{take}/edits", edits()).json
    assert off["revision"] == 4
    assert np.array_equal(frames(client, take), plain)


def test_a_take_with_edits_is_what_the_library_makes(client: Client, tmp_path) -> None:  # type: ignore[no-untyped-def]
    import json

    import mien

    take = client.take(text=LINE, emotion="angry:0.7", fps=30)
    client.ask("PUT", f"/api/takes/{take}/edits", edits(JAW, BORDER, RISE))
    layer = client.ask("GET", f"/api/takes/{take}/layer").json
    (tmp_path / "edits.json").write_text(json.dumps(layer))
    same = mien.say(LINE, emotion="angry:0.7", fps=30, edits=tmp_path / "edits.json")
    assert np.array_equal(frames(client, take), same.channels.values.astype("<f4"))


def test_curves_alone_ask_no_model(client: Client, monkeypatch: pytest.MonkeyPatch) -> None:
    take = client.take(text=LINE, emotion="angry:0.7", fps=30)
    client.ask("PUT", f"/api/takes/{take}/edits", edits(JAW, BORDER, RISE))
    wanted = client.ask("PUT", f"/api/takes/{take}/edits", edits(BORDER, RISE, {**JAW, "mode": "add"})).json
    again = client.take(text=LINE, emotion="angry:0.7", fps=30)
    client.ask("PUT", f"/api/takes/{again}/edits", edits(BORDER, RISE, {**JAW, "mode": "add"}))
    assert np.array_equal(frames(client, take), frames(client, again))
    asked: list[object] = []
    monkeypatch.setattr("mien.serve.studio.studio_takes.perform_under", lambda *given: asked.append(given))
    assert client.ask("PUT", f"/api/takes/{take}/edits", edits(BORDER, RISE, JAW)).status == 200
    assert not asked
    assert wanted["take"]["lost"] == []


def test_edits_go_along_into_another_line_and_what_is_lost_is_listed(client: Client) -> None:
    take = client.take(text=LINE, emotion="angry:0.7", fps=30)
    client.ask("PUT", f"/api/takes/{take}/edits", edits(JAW, BORDER, RISE))
    before = frames(client, take)
    told = client.finished(
        client.ask("POST", f"/api/takes/{take}/redo", {"text": "Well, I never asked.", "emotion": "sad"})
    )
    again = client.ask("GET", f"/api/takes/{told['take']}").json
    assert {loss["edit"] for loss in again["lost"]} == {0, 2}
    assert again["words"][2][1] != again["plain_words"][2][1]
    back = client.finished(
        client.ask("POST", f"/api/takes/{told['take']}/redo", {"text": LINE, "emotion": "angry:0.7"})
    )
    assert np.array_equal(frames(client, back["take"]), before)


def test_faults_of_a_layer_are_told_with_their_place(client: Client, take: str) -> None:
    answer = client.ask("PUT", f"/api/takes/{take}/edits", edits({**JAW, "channel": "jawOpne"}))
    assert answer.status == 400
    assert "jawOpen" in answer.json["error"]
    assert "edits[0]" in answer.json["error"]
    assert answer.json["field"] == "edits"


def test_without_emotions_the_borders_stay_moved(client: Client) -> None:
    take = client.take(text=LINE, emotion="angry:0.7", voice_emotion=0, fps=30)
    client.ask("PUT", f"/api/takes/{take}/edits", edits(JAW, BORDER, RISE))
    calm = client.take(text=LINE, fps=30)
    client.ask("PUT", f"/api/takes/{calm}/edits", edits(BORDER))
    assert np.array_equal(frames(client, take, "?neutral=1"), frames(client, calm))


def test_a_video_is_seen_from_where_the_page_sees_it(client: Client, tmp_path) -> None:  # type: ignore[no-untyped-def]
    import av

    take = client.take(text="Hi.", performer="hand-made", voice="espeak", fps=5)
    pictures = []
    for asked in ({}, {"camera": "profile", "light": "dramatic"}):
        told = client.finished(client.ask("POST", f"/api/takes/{take}/export", {"formats": [".mp4"], **asked}))
        (tmp_path / "line.mp4").write_bytes(client.ask("GET", told["file"]).body)
        with av.open(str(tmp_path / "line.mp4")) as video:
            pictures.append(next(video.decode(video=0)).to_ndarray(format="rgb24").mean())
    assert pictures[1] < pictures[0] / 2
    assert (
        client.ask("POST", f"/api/takes/{take}/export", {"formats": [".mp4"], "camera": "up"}).json["field"] == "camera"
    )


def test_a_glb_of_ones_own_is_driven_and_filmed(client: Client) -> None:
    body = client.ask("GET", "/api/faces/default.glb").body
    added = client.ask("POST", "/api/faces", body)
    assert added.status == 201
    assert {mesh["mesh"] for mesh in added.json["report"]["meshes"]} >= {"face"}
    face = added.json["face"]
    assert client.ask("GET", f"/api/faces/{face}.glb").body == body
    take = client.take(text="Hi.", performer="hand-made", voice="espeak", fps=5)
    asked = {"formats": [".glb", ".mp4"], "face": face, "camera": "mouth"}
    told = client.finished(client.ask("POST", f"/api/takes/{take}/export", asked))
    assert told["state"] == "done", told
    with zipfile.ZipFile(io.BytesIO(client.ask("GET", told["file"]).body)) as archive:
        assert archive.namelist() == ["hi.glb", "hi.mp4"]
        assert len(archive.read("hi.glb")) > len(body)
    gone = client.ask("POST", f"/api/takes/{take}/export", {"formats": [".glb"], "face": "x"})
    assert gone.json["field"] == "face"


def test_without_the_built_page_the_server_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mien.serve.studio.routes.load_page", dict)
    with studio() as running:
        answer = running.ask("GET", "/")
    assert answer.status == 503
    assert b"make page" in answer.body


def test_formats_whose_library_is_missing_are_not_offered(client: Client, take: str, monkeypatch) -> None:  # type: ignore[no-untyped-def]
    from dataclasses import replace

    from mien.core.errors import MissingPartError
    from mien.formats.registry import EXPORTERS
    from mien.serve.studio import about, results

    def missing() -> None:
        raise MissingPartError("it needs a library: pip install it")

    some = (EXPORTERS[0], replace(EXPORTERS[1], check=missing))
    monkeypatch.setattr(about, "exporters", lambda: some)
    monkeypatch.setattr(results, "exporters", lambda: some)
    about._writable.cache_clear()
    assert client.ask("GET", "/api/about").json["exports"] == [some[0].suffix]
    about._writable.cache_clear()
    answer = client.ask("POST", f"/api/takes/{take}/export", {"formats": [some[1].suffix]})
    assert answer.status == 400
    assert "pip install it" in answer.json["error"]


def test_a_format_with_a_folder_beside_it_comes_as_an_archive(tmp_path) -> None:  # type: ignore[no-untyped-def]
    from mien.serve.studio.results import _packed

    (tmp_path / "line.usdc").write_bytes(b"x")
    assert _packed(tmp_path, "line.zip").name == "line.usdc"
    (tmp_path / "line").mkdir()
    (tmp_path / "line" / "skin.png").write_bytes(b"y")
    with zipfile.ZipFile(_packed(tmp_path, "line.zip")) as archive:
        assert archive.namelist() == ["line/skin.png", "line.usdc"]
    assert [path.name for path in tmp_path.iterdir()] == ["line.zip"]


def test_an_emotion_that_the_performer_lacks_is_told_at_its_field(client: Client) -> None:
    told = client.finished(client.ask("POST", "/api/takes", {"text": LINE, "emotion": "hapy"}))
    assert (told["state"], told["field"]) == ("failed", "emotion")
    assert "did you mean 'happy'?" in told["error"]


def test_a_face_comes_compressed_and_only_once(client: Client) -> None:
    whole = client.ask("GET", "/api/faces/default.glb")
    packed = client.ask("GET", "/api/faces/default.glb", Accept_Encoding="gzip")
    assert packed.headers["content-encoding"] == "gzip"
    assert gzip.decompress(packed.body) == whole.body
    assert len(packed.body) < 4e6
    again = client.ask("GET", "/api/faces/default.glb", If_None_Match=packed.headers["etag"])
    assert (again.status, again.body) == (304, b"")


def test_the_cast_has_pictures(client: Client) -> None:
    faces = client.ask("GET", "/api/faces").json["faces"]
    assert faces[0] == {"face": "default", "name": "default", "own": False, "picture": True}
    for face in (one for one in faces if one["picture"]):
        assert client.ask("GET", f"/api/faces/{face['face']}.jpg").body[:2] == b"\xff\xd8", face
    assert client.ask("GET", "/api/faces/nobody.jpg").status == 404


def test_only_the_worker_of_textures_may_make_functions(client: Client) -> None:
    page = client.ask("GET", "/")
    assert "'unsafe-eval'" not in page.headers["content-security-policy"]
    worker = client.ask("GET", "/assets/basis_worker-187.js")
    assert worker.headers["content-security-policy"].startswith("default-src 'none'")


def test_the_times_of_a_textgrid_are_taken(client: Client) -> None:
    name = client.take(text=LINE, fps=30)
    told = client.ask("GET", f"/api/takes/{name}").json
    words = [[begin + 0.01, end, label] for begin, end, label in told["words"]]
    tiers = "".join(
        f'"IntervalTier" "{tier}" 0 {told["seconds"]} {len(spans)} ' + " ".join(f'{a} {b} "{c}"' for a, b, c in spans)
        + " " for tier, spans in (("words", words), ("phones", told["phones"]))
    )  # fmt: skip
    grid = f'File type = "ooTextFile" Object class = "TextGrid" 0 {told["seconds"]} <exists> 2 {tiers}'.encode()
    made = client.finished(client.ask("POST", f"/api/takes/{name}/textgrid", grid))
    now = client.ask("GET", f"/api/takes/{made['take']}").json
    assert now["words"][0][0] == pytest.approx(words[0][0])
    assert now["count"] == 2
    answer = client.ask("POST", f"/api/takes/{name}/textgrid", b"no grid")
    assert (answer.status, answer.json["field"]) == (400, "sound")
    assert "not a TextGrid" in answer.json["error"]


def test_a_line_that_is_being_written_is_made_ready(client: Client, monkeypatch: pytest.MonkeyPatch) -> None:
    asked = {"text": "Made while it is typed.", "fps": 30}
    assert client.ask("POST", "/api/ahead", asked).status == 202
    shop = client.workshop
    assert shop._ahead is not None
    while not shop._ahead[1].over:
        time.sleep(0.02)
    assert shop._ahead[1].state == "done"

    def never(*_: object, **__: object) -> None:
        raise AssertionError("the text was spoken again")

    monkeypatch.setattr("mien.serve.studio.performing.spoken_text", never)
    assert client.take(**asked)
    assert len(client.ask("GET", "/api/takes").json["takes"]) < 20


def test_who_waits_for_a_job_is_told_once_it_is_farther(client: Client) -> None:
    job = client.ask("POST", "/api/takes", {"text": LINE, "fps": 30, "seed": 7}).json["job"]
    seen = []
    while not seen or seen[-1]["state"] not in ("done", "failed"):
        seen.append(client.ask("GET", f"/api/jobs/{job}?wait=5").json)
    assert seen[-1]["state"] == "done"
    assert len(seen) < 60, "it does not wait"


def test_a_picture_that_the_page_has_drawn_of_a_face_is_kept_with_it(tmp_path: Path) -> None:
    write_glb(tiny_animation(1), tiny_face(), tmp_path / "own.glb")
    with studio(folder=tmp_path / "kept") as client:
        own = client.ask("POST", "/api/faces", (tmp_path / "own.glb").read_bytes()).json["face"]
        assert client.ask("GET", f"/api/faces/{own}.jpg").status == 404
        drawn = b"\xff\xd8\xff and the rest"
        assert client.ask("PUT", f"/api/faces/{own}.jpg", drawn).status == 200
        assert client.ask("PUT", f"/api/faces/{own}.jpg", b"<svg/>").json["field"] == "face"
        assert client.ask("PUT", "/api/faces/default.jpg", drawn).status == 404
    with studio(folder=tmp_path / "kept") as client:
        assert client.ask("GET", f"/api/faces/{own}.jpg").body == drawn
        assert client.ask("GET", "/api/faces").json["faces"][-1]["picture"]
