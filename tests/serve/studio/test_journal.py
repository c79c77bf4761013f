"""What was done is there again: after a kill, in another program, in another tab, as one file."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from mien.core.errors import InputError
from mien.serve.studio.journal import Journal, Record, Step, folder_to_keep, record_of, step_of, sweep
from mien.serve.studio.requests import TakeRequest
from mien.serve.studio.settings import Limits
from tests.serve.studio.client import Client, studio

LINE = "I never said that."
LIMITS = Limits()


def channel(value: float) -> dict[str, Any]:
    """A layer with one key."""
    anchor = {"word": "never", "occurrence": 1, "phone": 0, "share": 0.5}
    edit = {"kind": "channel", "channel": "jawOpen", "mode": "replace", "interpolation": "linear", "fade": 0.1,
            "keys": [{"anchor": anchor, "value": value}]}  # fmt: skip
    return {"format": "mien-edits", "version": 1, "edits": [edit]}


def step(client: Client, take: str, keep: int, add: list[dict[str, Any]], at: int, count: int) -> Any:
    return client.ask("PUT", f"/api/takes/{take}/steps", {"keep": keep, "add": add, "at": at, "count": count})


def test_a_take_with_its_steps_is_there_in_the_next_studio(tmp_path: Path) -> None:
    with studio(folder=tmp_path) as client:
        take = client.take(text=LINE, emotion="happy:0.7", fps=30)
        assert step(client, take, 1, [channel(0.4), channel(0.9)], 2, 1).status == 200
        told = step(client, take, 3, [], 1, 3).json["take"]  # one step back
        assert (told["at"], told["count"]) == (1, 3)
        client.ask("PUT", f"/api/takes/{take}/name", {"name": "the\n first"})
        client.ask("PUT", "/api/page", {"take": take})
        before = client.ask("GET", f"/api/takes/{take}/frames").body
    with studio(folder=tmp_path) as client:
        assert client.ask("GET", "/api/page").json == {"take": take}
        assert [(one["take"], one["name"]) for one in client.ask("GET", "/api/takes").json["takes"]] == [
            (take, "the first")
        ]
        assert client.finished(client.ask("POST", f"/api/takes/{take}/open"))["take"] == take
        assert client.ask("GET", f"/api/takes/{take}/frames").body == before
        assert [len(one["layer"]["edits"]) for one in client.ask("GET", f"/api/takes/{take}/steps").json["steps"]] == [
            0,
            1,
            1,
        ]
        assert step(client, take, 3, [], 2, 3).json["take"]["edits"]["edits"][0]["keys"][0]["value"] == 0.9
        assert step(client, take, 1, [], 0, 1).status == 409, "another window thinks that there is one step"


def test_undo_runs_across_performances_and_a_copy_is_on_its_own(tmp_path: Path) -> None:
    with studio(folder=tmp_path) as client:
        take = client.take(text=LINE, fps=30)
        plain = client.ask("GET", f"/api/takes/{take}/frames").body
        step(client, take, 1, [channel(0.4)], 1, 1)
        assert client.finished(client.ask("POST", f"/api/takes/{take}/redo", {"emotion": "angry"}))["take"] == take
        told = client.ask("GET", f"/api/takes/{take}").json
        assert (told["at"], told["request"]["emotion"], len(told["edits"]["edits"])) == (2, ["angry"], 1)
        copy = client.ask("POST", f"/api/takes/{take}/copy").json["take"]
        client.finished(step(client, take, 3, [], 0, 3))
        assert client.ask("GET", f"/api/takes/{take}/frames").body == plain
        assert client.ask("GET", f"/api/takes/{copy}").json["request"]["emotion"] == ["angry"]
        assert client.ask("DELETE", f"/api/takes/{take}").status == 200
        assert client.ask("GET", f"/api/takes/{take}").status == 404
        assert [one["take"] for one in client.ask("GET", "/api/takes").json["takes"]] == [copy]


def test_a_project_is_one_file_and_a_page_hands_its_take_back(tmp_path: Path) -> None:
    with studio(folder=tmp_path / "one") as client:
        take = client.take(text=LINE, fps=30)
        step(client, take, 1, [channel(0.4)], 1, 1)
        frames = client.ask("GET", f"/api/takes/{take}/frames").body
        project = client.ask("GET", "/api/project").body
        record = client.ask("GET", f"/api/takes/{take}/steps").body
    with studio(folder=tmp_path / "two") as client:
        assert client.ask("POST", "/api/project", project).json["takes"] == {take: take}
        assert client.ask("GET", f"/api/takes/{take}/frames").body == frames
        assert client.ask("POST", "/api/project", b"PK nothing").status == 400
    with studio(folder=tmp_path / "three") as client:
        mark = "mark"
        parts = [("take", take.encode()), ("record", record)]
        body = b"".join(
            f'--{mark}\r\nContent-Disposition: form-data; name="{name}"\r\n\r\n'.encode() + part + b"\r\n"
            for name, part in parts
        )
        answer = client.ask(
            "POST",
            "/api/takes/back",
            body + f"--{mark}--\r\n".encode(),
            Content_Type=f"multipart/form-data; boundary={mark}",
        )
        assert (answer.status, answer.json) == (201, {"take": take})
        assert client.ask("GET", f"/api/takes/{take}/frames").body == frames


def test_a_line_that_was_cut_off_is_passed_over(tmp_path: Path) -> None:
    journal = Journal(tmp_path, LIMITS)
    request = TakeRequest.of({"text": LINE}, LIMITS)
    name = journal.add(Record("a take", 0.0, [Step(request)]))
    journal.change(name, 1, [Step(request)], 1)
    path = tmp_path / "takes" / f"{name}.jsonl"
    path.write_bytes(path.read_bytes()[:-20])
    again = Journal(tmp_path, LIMITS)
    assert "cut off" in again.faults[0]
    assert (len(again.get(name).steps), again.get(name).at) == (1, 0)
    again.change(name, 1, [Step(request)], 1)
    assert Journal(tmp_path, LIMITS).get(name).at == 1


def test_a_number_beyond_all_bounds_is_a_fault_that_is_told(tmp_path: Path) -> None:
    (tmp_path / "takes").mkdir()
    (tmp_path / "takes" / "abcdefgh.jsonl").write_text('{"name": "a", "made": 1, "steps": [], "at": 1e999}\n')
    assert "abcdefgh.jsonl" in Journal(tmp_path, LIMITS).faults[0]
    with pytest.raises(InputError, match="not a take of mien's studio"):
        record_of({"name": "a", "made": 1, "steps": [], "at": float("inf")}, LIMITS)


def test_an_effort_that_was_read_from_a_sound_goes_with_it() -> None:
    heard = TakeRequest.of({"text": "a", "effort": "auto"}, LIMITS, with_sound=True)
    assert heard.changed({"fps": 30}, LIMITS, with_sound=True).effort == "auto"
    assert heard.changed({"fps": 30}, LIMITS).effort == ""
    told = {"request": {"text": "a", "effort": "auto"}, "layer": channel(0.4), "sound": None}  # of an earlier version
    assert step_of(told, LIMITS).request.effort == ""


def test_steps_are_bounded() -> None:
    request = TakeRequest.of({"text": LINE}, LIMITS)
    record = Record("a take", 0.0, [Step(request)])
    for _ in range(300):
        record = record.changed(record.at + 1, [Step(request)], record.at + 1)
    assert (len(record.steps), record.at) == (200, 199)
    with pytest.raises(InputError, match="cannot keep"):
        record.changed(1, [], 5)


def test_a_folder_belongs_to_one_studio_at_a_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    spare = tmp_path / "spare"
    with folder_to_keep(None, spare) as (folder, _), folder_to_keep(None, spare) as (other, told):
        assert folder == tmp_path / "mien" / "studio"
        assert other == spare
        assert "another studio" in told
        with pytest.raises(InputError, match="another studio"), folder_to_keep(folder, spare):
            pass


def test_temporaries_of_killed_studios_are_swept(tmp_path: Path) -> None:
    for name in ("mien-studio-a", "mien-studio-b", "other"):
        (tmp_path / name).mkdir()
    for name in ("mien-studio-a", "mien-studio-b"):
        (tmp_path / name / ".lock").touch()
    with folder_to_keep(tmp_path / "mien-studio-b", tmp_path):
        assert sweep("mien-studio-", tmp_path) == 1
    assert sorted(path.name for path in tmp_path.iterdir()) == ["mien-studio-b", "other"]


def test_kill_9_in_the_middle_loses_nothing_that_was_answered(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "mien", "studio", "--no-browser", "--port", "0", "--folder", str(tmp_path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as program:
        assert program.stdout is not None
        found = re.search(r":(\d+)/", program.stdout.readline())
        assert found
        client = Client(int(found[1]), None)  # type: ignore[arg-type]
        take = client.take(text=LINE, fps=30)
        for number in range(1, 6):
            assert step(client, take, number, [channel(number / 10)], number, number).status == 200
        client.ask("POST", f"/api/takes/{take}/redo", {"emotion": "angry"})
        os.kill(program.pid, signal.SIGKILL)
        program.wait()
    record = Journal(tmp_path, LIMITS).get(take)
    assert [one.layer.edits[0].keys[0][1] for one in record.steps[1:6]] == [0.1, 0.2, 0.3, 0.4, 0.5]  # type: ignore[union-attr]
    assert record.at in (5, 6)  # the performance that was under way is there or not, never half
    assert json.loads((tmp_path / "takes" / f"{take}.jsonl").read_bytes().splitlines()[0])["steps"]


def test_phones_are_corrected_over_the_sound_as_it_is(tmp_path: Path) -> None:
    with studio(folder=tmp_path) as client:
        take = client.take(text=LINE, fps=30)
        told = client.ask("GET", f"/api/takes/{take}").json
        phones = [[begin, end, "EY" if label == "EH" else label] for begin, end, label in told["phones"]]
        times = {"words": told["words"], "phones": phones}
        assert client.finished(client.ask("POST", f"/api/takes/{take}/redo", {"times": times}))["state"] == "done"
        assert [label for _, _, label in client.ask("GET", f"/api/takes/{take}").json["phones"]] == [
            one[2] for one in phones
        ]
        wrong = client.finished(
            client.ask("POST", f"/api/takes/{take}/redo", {"times": {**times, "phones": [[0, 1, "QQ"]]}})
        )
        assert (wrong["state"], wrong["field"]) == ("failed", "times")
        assert "QQ" in wrong["error"]


def test_the_beginning_of_a_long_line_is_shown_first_and_emotions_have_a_face(tmp_path: Path) -> None:
    with studio(folder=tmp_path) as client:
        text = "Well. " + "I never said that. " * 4 + "Really."
        job = client.ask("POST", "/api/takes", {"text": text, "fps": 30}).json["job"]
        seen = []
        while (told := client.ask("GET", f"/api/jobs/{job}").json)["state"] in ("queued", "running"):
            if told.get("beginning") and told["beginning"] not in seen:
                seen.append(told["beginning"])
                words = client.ask("GET", f"/api/takes/{told['beginning']}").json["words"]
                assert 0 < len(words) < 10
        assert seen
        assert [one["take"] for one in client.ask("GET", "/api/takes").json["takes"]] == [told["take"]]
        shown = client.ask("GET", "/api/expressions").json
        happy = dict(zip(shown["channels"], shown["emotions"]["happy"], strict=True))
        assert happy["mouthSmileLeft"] > 0.1 > abs(happy["headYaw"]) / 100
