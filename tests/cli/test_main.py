from __future__ import annotations

import argparse
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import soundfile

from mien.cli import main
from mien.cli.outputs import unused_options


def refused(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """The one line that a refused command prints; it ends with exit code 2."""
    try:
        code = main(arguments)
    except SystemExit as stop:  # argparse
        code = stop.code  # type: ignore[assignment]
    captured = capsys.readouterr()
    assert code == 2
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    assert "Traceback" not in captured.err
    return captured.err


@pytest.fixture
def sound(tmp_path: Path) -> Path:
    path = tmp_path / "sound.wav"
    soundfile.write(path, 0.1 * np.random.default_rng(1).standard_normal(16000), 16000)
    return path


def test_version(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stop:
        main(["--version"])
    assert stop.value.code == 0
    assert capsys.readouterr().out.startswith("mien 0.")


def test_help_loads_no_heavy_library() -> None:
    script = (
        "import sys\n"
        "from mien.cli import main\n"
        "try:\n    main(['--help'])\nexcept SystemExit:\n    pass\n"
        "heavy = {'numpy', 'scipy', 'numba', 'av', 'PIL'} & set(sys.modules)\n"
        "sys.exit(f'loaded: {heavy}' if heavy else 0)\n"
    )
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["say", "Hello.", "-o", "{dir}/a.mp5"], "did you mean '.mp4'"),
        (["say", "Hello.", "-o", "{dir}/a"], "end its name in one of"),
        (["say", "Hello.", "-o", "{dir}"], "end its name in one of"),
        (["say", "Hello.", "-o", "{dir}/a.csv", "--also", "{dir}/b.doc"], "unknown output format '.doc'"),
        (["say", "Hello.", "-o", "{dir}/a.csv", "--emotion", "hapy"], "did you mean 'happy'"),
        (["say", "Hello.", "-o", "{dir}/a.csv", "--emotion", "happy:7"], "from 0 to 1, not 7"),
        (["say", "Hello.", "-o", "{dir}/a.csv", "--emotion", "happy:-1"], "from 0 to 1"),
        (["say", "Hello.", "-o", "{dir}/a.csv", "--emotion", "happy:nan"], "from 0 to 1"),
        (["say", "Hello.", "-o", "{dir}/a.csv", "--emotion", "happy:much"], "a number from 0 to 1"),
        (["say", "Hello.", "-o", "{dir}/a.csv", "--fps", "0"], "above 0"),
        (["say", "Hello.", "-o", "{dir}/a.csv", "--fps", "fast"], "frame rate"),
        (["say", "Hello.", "-o", "{dir}/a.csv", "--seed", "-1"], "seed"),
        (["say", "Hello.", "-o", "{dir}/a.csv", "--seed", "x"], "--seed"),
        (["say", "Hello.", "-o", "{dir}/a.csv", "--face", "nobody"], "unknown face 'nobody'"),
        (["say", "Hello.", "-o", "{dir}/a.csv", "--face", "line.mp4"], "line.mp4 is no face"),
        (["batch", "{dir}/a.csv", "-o", "{dir}/b"], "a table is for 'mien stimuli'"),
        (["say", "Hello.", "-o", "{dir}/a.csv", "--voice", "nobody"], "unknown voice 'nobody'"),
        (["say", "", "-o", "{dir}/a.csv"], "empty"),
        (["say", "  \n ", "-o", "{dir}/a.csv"], "empty"),
        (["say", "Привет, мир", "-o", "{dir}/a.csv"], "Cyrillic"),
        (["say", "你好", "-o", "{dir}/a.csv"], "你好"),
        (["animate", "{dir}/missing.wav", "-o", "{dir}/a.csv"], "no such file"),
        (["animate", "{sound}", "--text", "", "-o", "{dir}/a.csv"], "empty"),
        (["animate", "{sound}", "--text", "missing.txt", "-o", "{dir}/a.csv"], "no such text file"),
        (["animate", "{sound}", "--voice", "x", "-o", "{dir}/a.csv"], "--voice is for 'mien say'"),
        (["align", "{sound}", "--text", "hello", "-o", "{dir}/a.mp4"], "mien align writes .TextGrid"),
        (["align", "{sound}", "-o", "{dir}/a.TextGrid"], "--text"),
        (["sing", "la"], "there is no command"),
        ([], "COMMAND"),
    ],
)
def test_bad_input_gets_one_line_and_exit_code_2(
    arguments: list[str], words: str, tmp_path: Path, sound: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = sorted(tmp_path.iterdir())
    line = refused(capsys, *(a.format(dir=tmp_path, sound=sound) for a in arguments))
    assert words in line
    assert sorted(tmp_path.iterdir()) == before


def test_a_text_that_is_no_text_is_refused(tmp_path: Path, sound: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "line.txt").write_bytes(b"caf\xe9\x01")
    line = refused(capsys, "animate", str(sound), "--text", str(tmp_path / "line.txt"), "-o", str(tmp_path / "a.csv"))
    assert "UTF-8" in line
    assert "byte 3" in line


def test_stopping_by_hand_ends_with_130(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def stop(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("mien.api.calls.say", stop)
    assert main(["say", "Hello.", "-o", str(tmp_path / "a.csv")]) == 130
    assert "stopped" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_no_input_is_overwritten_and_no_output_given_twice(
    tmp_path: Path, sound: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = sound.read_bytes()
    assert "both read and written" in refused(capsys, "animate", str(sound), "-o", str(sound))
    (tmp_path / "said.TextGrid").write_text("hello", encoding="utf-8")
    said = str(tmp_path / "said.TextGrid")
    assert "both read and written" in refused(capsys, "align", str(sound), "--text", said, "-o", said)
    twice = ("-o", str(tmp_path / "a.csv"), "--also", str(tmp_path / "." / "a.csv"))
    assert "given twice" in refused(capsys, "say", "Hello.", *twice)
    assert sound.read_bytes() == before
    assert not (tmp_path / "a.csv").exists()


@pytest.mark.parametrize("name", ["x" * 300 + ".csv", "x" * 300 + "/a.csv"])
def test_impossible_names_are_refused(tmp_path: Path, name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert "cannot write" in refused(capsys, "say", "Hello.", "-o", str(tmp_path / name))


@pytest.mark.skipif(not hasattr(signal, "SIGTERM") or os.name != "posix", reason="signals of POSIX systems")
def test_a_request_to_end_leaves_nothing_behind(tmp_path: Path) -> None:
    long = " ".join(["Maybe my papa may buy five very good mauve vans."] * 6)
    command = [sys.executable, "-m", "mien", "say", long, "-o", str(tmp_path / "a.mp4"), "--fps", "60"]
    run = subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    deadline = time.monotonic() + 120
    while not list(tmp_path.iterdir()) and run.poll() is None and time.monotonic() < deadline:
        time.sleep(0.05)
    assert list(tmp_path.iterdir()), "the video was never begun"
    run.send_signal(signal.SIGTERM)
    _, said = run.communicate(timeout=300)  # what draws may be compiling, which is not broken off
    assert run.returncode == 130
    assert "stopped" in said
    assert list(tmp_path.iterdir()) == []


def test_a_full_standard_output_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    if not Path("/dev/full").exists():
        pytest.skip("this system has no /dev/full")
    with Path("/dev/full").open("w") as full:
        run = subprocess.run(
            [sys.executable, "-m", "mien", "doctor"], stdout=full, stderr=subprocess.PIPE, text=True, check=False
        )
    assert run.returncode == 2
    assert run.stderr.count("\n") == 1
    assert "standard output" in run.stderr


def test_options_that_no_format_has_a_use_for_are_reported() -> None:
    given = {"face": "x.glb", "deformer": "tree", "fps": "60"}
    notes = [note.message for note in unused_options(argparse.Namespace(**given), ["a.wav", "b.TextGrid"])]
    assert [message.split(" has")[0] for message in notes] == ["--face x.glb", "--deformer tree", "--fps 60"]
    assert notes[0].endswith("has no effect on .wav, .TextGrid")
    assert [n.message.split(" has")[0] for n in unused_options(argparse.Namespace(**given), ["a.csv"])] == [
        "--face x.glb",
        "--deformer tree",
    ]
    assert unused_options(argparse.Namespace(**given), ["a.csv", "a.png"]) == []
    assert unused_options(argparse.Namespace(face="default", deformer="blendshapes", fps="30"), ["a.wav"]) == []
    asked = {"emotion": ["sad", "happy:0.2"], "alive": "off", "prosody": "0.5", "fps": None}
    in_animate = unused_options(argparse.Namespace(**asked), ["a.wav"])
    assert [n.message.split(" has")[0] for n in in_animate] == ["--alive off", "--emotion sad happy:0.2"]
    in_say = unused_options(argparse.Namespace(voice_emotion=1.0, **asked), ["a.wav"])
    assert [n.message.split(" has")[0] for n in in_say] == ["--alive off"]


def test_a_folder_that_was_not_there_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    line = ["say", "Oh.", "-o", str(tmp_path / "mistpyed" / "deep" / "a.csv")]
    for told in (1, 0):  # the second time the folder is there
        assert main(line) == 0
        assert capsys.readouterr().err.count(f"not there: {tmp_path / 'mistpyed'}") == told
