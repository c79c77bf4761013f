"""``--edits`` of `mien say` and `mien animate`."""

from __future__ import annotations

import json

import pytest

from mien.animation.edits import line_of
from mien.cli import main
from mien.formats.native import read_native

JAW = {
    "kind": "channel",
    "channel": "jawOpen",
    "mode": "replace",
    "keys": [{"anchor": {"word": "said", "phone": 1, "share": share}, "value": 0.7} for share in (0, 1)],
}
GONE = {"kind": "border", "phone": {"word": "maybe", "phone": 0}, "edge": "end", "shift": 0.02}
PLAIN = ["--performer", "hand-made", "--fps", "50"]


@pytest.fixture
def layer(tmp_path):
    path = tmp_path / "edits.json"
    path.write_text(json.dumps({"format": "mien-edits", "version": 1, "edits": [JAW, GONE]}))
    return str(path)


def test_say_and_animate_lay_them_on_and_tell_what_is_lost(tmp_path, layer, capsys):
    spoken, heard = tmp_path / "spoken.json", tmp_path / "heard.json"
    said = ["say", "I never said that.", "--voice", "espeak", *PLAIN, "--edits", layer]
    assert main([*said, "-o", str(spoken), "--also", str(tmp_path / "line.wav")]) == 0
    assert "mien: warning: edit 2 (border) cannot be applied" in capsys.readouterr().err
    recorded = ["animate", str(tmp_path / "line.wav"), "--text", "I never said that.", *PLAIN, "--edits", layer]
    assert main([*recorded, "-o", str(heard)]) == 0
    for path in (spoken, heard):
        animation = read_native(path)
        vowel = animation.utterance.phones.intervals[line_of(animation.utterance).phones[3][1]]
        times = animation.rate.times(len(animation.channels))
        inside = (times >= vowel.start) & (times < vowel.end)
        assert vowel.label == "EH"
        assert inside.any()
        assert animation.channels.channel("jawOpen")[inside] == pytest.approx(0.7)
        assert [loss.edit for loss in animation.edits.lost] == [1]
        assert animation.edits.layer.line is not None
        assert set(animation.edits.before.channels) == {"jawOpen"}


def test_a_layer_that_cannot_be_read_is_told_before_any_work(tmp_path, capsys):
    said = ["say", "Hi.", "-o", str(tmp_path / "x.json")]
    assert main([*said, "--edits", str(tmp_path / "nowhere.json")]) == 2
    assert "no such file" in capsys.readouterr().err
    (tmp_path / "edits.json").write_text('{"format": "mien-edits", "version": 1, "edits": [{"kind": "bend"}]}')
    assert main([*said, "--edits", str(tmp_path / "edits.json")]) == 2
    assert "edits[0].kind" in capsys.readouterr().err
    assert main(["say", "Hi.", "-o", str(tmp_path / "edits.json"), "--edits", str(tmp_path / "edits.json")]) == 2
    assert "both read and written" in capsys.readouterr().err
