"""`mien animate` with a script, on a recorded sentence whose words and phones were labelled by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import mien
from mien.cli import main
from mien.formats.native import read_native

pytestmark = pytest.mark.data
SCRIPT = """\
She had your <HeadNod/> dark suit in <emotion name="happy">greasy <Smile>wash</Smile></emotion>
water <BrowFlash at="phone.2"/> all <pose parameter="jawOpen" value="0.5" mode="set" at="1500" until="1700"/>
<WinkLeft at="word.end"/> year. <pause seconds="0.5"/>
"""


def labels(path: Path) -> dict[str, tuple[float, float]]:
    """Seconds by word; TIMIT counts samples at 16 kHz."""
    rows = [line.split() for line in path.read_text().splitlines()]
    return {word: (int(first) / 16_000, int(last) / 16_000) for first, last, word in rows}


def test_direction_at_words_phones_and_times_of_a_recording(shared_data: Path, tmp_path: Path) -> None:
    folder = shared_data / "timit-sample" / "dr3-falk0"
    script, out = tmp_path / "line.txt", tmp_path / "line.json"
    script.write_text(SCRIPT, encoding="utf-8")
    options = ["--script", str(script), "--performer", "hand-made", "--fps", "100", "-o", str(out), "--quiet"]
    assert main(["animate", str(folder / "sa1.flac"), *options]) == 0
    made, words = read_native(out), labels(folder / "sa1.wrd")
    assert [word.label.lower() for word in made.utterance.words] == list(words)
    curves = {curve.parameter: [at for at, _ in curve.keys] for curve in made.score.curves}

    def near(milliseconds: float, seconds: float) -> bool:
        return abs(milliseconds / 1000 - seconds) < 0.06

    assert near(curves["HeadNod"][0], words["dark"][0])
    assert near(curves["mouthSmile"][0], words["wash"][0])
    assert near(curves["mouthSmile"][-1], words["wash"][1])
    assert words["all"][0] + 0.03 < curves["browOuterUp"][0] / 1000 < words["all"][1]  # its L
    assert near(curves["eyeBlinkLeft"][0], words["year"][1])
    (emotion,) = made.score.emotions
    assert abs(emotion.start - words["greasy"][0]) < 0.06
    assert abs(emotion.end - words["wash"][1]) < 0.06
    jaw = made.channels.values[:, made.channels.names.index("jawOpen")]
    np.testing.assert_allclose(jaw[150:170], 0.5, atol=1e-9)
    assert any("the recording has its own" in note.message for note in made.notes)


def test_words_that_are_not_said_are_told(shared_data: Path) -> None:
    sound = shared_data / "timit-sample" / "dr3-falk0" / "sa1.flac"
    with pytest.raises(mien.MienError, match="lies outside the sound"):
        mien.animate(sound, text="She had your dark suit in greasy wash water <HeadNod at='9000'/> all year.")
