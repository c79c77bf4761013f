"""The guided session: what each key does, what is on disk after it, and how it goes on."""

from __future__ import annotations

import csv
import errno
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from mien.core.audio import Audio
from mien.core.errors import InputError, OutputError
from mien.corpus.recording.folder import SessionFolder
from mien.corpus.recording.scripts import Line
from mien.corpus.recording.session import Plan, Session, SessionReport

LINES = [Line(1, "Hello there."), Line(2, "It is late."), Line(3, "Good bye.")]
PLAN = Plan(LINES, "mine", "anna", "happy")


def speech(loudness: float = 0.3) -> Audio:
    tone = loudness * np.sin(np.arange(8000) * 0.2)
    return Audio(np.concatenate([np.zeros(3200), tone, np.zeros(3200)]), 16_000)


class Keys:
    """Presses keys in turn; the words ``stop`` raises as Ctrl-C does."""

    def __init__(self, *pressed: str) -> None:
        self._pressed = iter(pressed)
        self.said: list[str] = []
        self.asked: list[str] = []

    def show(self, message: str) -> None:
        self.said.append(message)

    def key(self, prompt: str, known: str) -> str:
        self.asked.append(prompt)
        pressed = next(self._pressed, "q")
        if pressed == "stop":
            raise KeyboardInterrupt
        assert pressed in known
        return pressed


class FakeDevices:
    live = True

    def __init__(self, *sounds: Audio) -> None:
        self._sounds: Iterator[Audio] = iter(sounds)
        self.taken: list[int] = []

    def take(self, line: Line, name: str, folder: Path, until_done: Callable[[], None]) -> list[Path]:
        path = folder / f"{name}.wav"
        path.write_bytes(b"half of a take")
        until_done()
        next(self._sounds, speech()).write(path)
        self.taken.append(line.number)
        return [path]


def run(folder: Path, keys: Keys, devices: FakeDevices | None = None, plan: Plan = PLAN) -> SessionReport:
    session = Session(plan, SessionFolder(folder), devices or FakeDevices(), keys, pause=lambda _: None)
    return session.run()


def rows(folder: Path) -> list[dict[str, str]]:
    with (folder / "table.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


KEEP = ("\n", "\n", "\n")  # record, finished, keep


def test_a_whole_session(tmp_path: Path) -> None:
    keys = Keys(*KEEP * 3)
    report = run(tmp_path / "new" / "session", keys)
    folder = tmp_path / "new" / "session"
    names = [f"anna-happy-mine-00{number}" for number in (1, 2, 3)]
    assert report.recorded == names
    assert report.skipped == report.failed == report.kept == []
    assert report.without_motion
    assert sorted(p.name for p in folder.iterdir()) == [*(f"{name}.wav" for name in names), "table.csv"]
    assert rows(folder)[1] == {
        "name": names[1],
        "text": "It is late.",
        "emotion": "happy",
        "sentence": "mine-002",
        "speaker": "anna",
    }
    assert keys.said[:4] == ["1/3 [happy]  Hello there.", "3...", "2...", "1..."]


def test_countdown_takes_three_seconds(tmp_path: Path) -> None:
    waited: list[float] = []
    Session(PLAN, SessionFolder(tmp_path), FakeDevices(), Keys(*KEEP), pause=waited.append).run()
    assert waited == [1.0, 1.0, 1.0]


def test_retake_skip_and_quit(tmp_path: Path) -> None:
    loud, soft = speech(0.5), speech(0.25)
    keys = Keys("\n", "\n", "r", "\n", "\n", "s", "q")  # first twice, second skipped, end at the third
    devices = FakeDevices(loud, soft)
    report = run(tmp_path, keys, devices)
    assert devices.taken == [1, 1]
    assert [line.number for line in report.skipped] == [2, 3]
    from mien.formats.sound_files import read_audio

    assert read_audio(tmp_path / "anna-happy-mine-001.wav")[0] == soft
    assert len(rows(tmp_path)) == 1


@pytest.mark.parametrize(("pressed", "taken"), [("s", [1, 2, 3]), ("q", [1])])
def test_a_take_passed_over_leaves_nothing(tmp_path: Path, pressed: str, taken: list[int]) -> None:
    devices = FakeDevices()
    report = run(tmp_path, Keys(*("\n", "\n", pressed) * 3), devices)
    assert devices.taken == taken
    assert [line.number for line in report.skipped] == [1, 2, 3]
    assert list(tmp_path.iterdir()) == []


def test_the_session_goes_on_where_it_was(tmp_path: Path) -> None:
    run(tmp_path, Keys(*KEEP, "q"))
    keys = Keys(*KEEP * 2)
    report = run(tmp_path, keys)
    assert report.kept == ["anna-happy-mine-001"]
    assert len(report.recorded) == 2
    assert keys.said[0] == "2/3 [happy]  It is late."
    (tmp_path / "anna-happy-mine-002.wav").unlink()  # its line alone is no take
    again = run(tmp_path, Keys(*KEEP))
    assert again.recorded == ["anna-happy-mine-002"]
    assert len(rows(tmp_path)) == 3


def test_two_emotions_share_a_folder_and_link_their_sentences(tmp_path: Path) -> None:
    run(tmp_path, Keys(*KEEP, "q"))
    run(tmp_path, Keys(*KEEP, "q"), plan=Plan(LINES, "mine", "anna", "sad"))
    table = rows(tmp_path)
    assert [row["emotion"] for row in table] == ["happy", "sad"]
    assert {row["sentence"] for row in table} == {"mine-001"}


def test_a_changed_script_is_refused_before_anything_is_recorded(tmp_path: Path) -> None:
    run(tmp_path, Keys(*KEEP, "q"))
    devices = FakeDevices()
    with pytest.raises(InputError, match=r"says 'Hello there\.', the script now says 'Hello you\.'"):
        run(tmp_path, Keys(*KEEP), devices, Plan([Line(1, "Hello you.")], "mine", "anna", "happy"))
    assert devices.taken == []


@pytest.mark.parametrize("keys", [("\n", "stop"), ("\n", "\n", "stop"), ("stop",)])
def test_interrupted_nothing_half_written_stays(tmp_path: Path, keys: tuple[str, ...]) -> None:
    with pytest.raises(KeyboardInterrupt):
        run(tmp_path, Keys(*KEEP, *keys))
    assert sorted(p.name for p in tmp_path.iterdir()) == ["anna-happy-mine-001.wav", "table.csv"]
    assert len(rows(tmp_path)) == 1


def test_levels_are_told_and_kept_as_warnings(tmp_path: Path) -> None:
    keys = Keys(*KEEP, "q")
    report = run(tmp_path, keys, FakeDevices(speech(0.004)))
    (said,) = [line for line in keys.said if "too quiet" in line]
    assert said.startswith("warning: too quiet: speech at -51 dBFS")
    assert [note.message for note in report.notes] == ["anna-happy-mine-001: " + said.removeprefix("warning: ")]


def test_a_full_disk_is_one_line_and_keeps_what_was_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run(tmp_path, Keys(*KEEP, "q"))

    def full(self: Path, target: Path) -> Path:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Path, "replace", full)
    with pytest.raises(OutputError, match="the disk is full; free some space and run again"):
        run(tmp_path, Keys(*KEEP))
    monkeypatch.undo()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["anna-happy-mine-001.wav", "table.csv"]
    assert run(tmp_path, Keys()).kept == ["anna-happy-mine-001"]


def test_a_folder_that_cannot_be_made(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("x")
    with pytest.raises(OutputError, match="cannot write"):
        SessionFolder(tmp_path / "file" / "session")
    with pytest.raises(OutputError, match="cannot write"):
        SessionFolder(tmp_path / "file")


def test_a_take_of_another_kind_replaces_the_files_of_the_last(tmp_path: Path) -> None:
    folder = SessionFolder(tmp_path)
    for suffix in (".wav", ".mp4"):
        with folder.scratch() as scratch:
            (scratch / f"new{suffix}").write_bytes(b"x")
            folder.keep("a", {"text": "Hello."}, [scratch / f"new{suffix}"])
    assert [path.name for path in folder.files_of("a")] == ["a.mp4"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [(("mine", "an na"), "speaker"), (("mine", "anna", "so/so"), "emotion"), (("mine", ""), "speaker")],
)
def test_names_that_no_file_can_have(arguments: tuple[str, ...], message: str) -> None:
    with pytest.raises(InputError, match=f"the {message} goes into names of files"):
        Plan(LINES, *arguments)
