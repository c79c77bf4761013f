"""Festival's Finnish voices, end to end: a text to an utterance with native phones, and a mouth that moves."""

from __future__ import annotations

import numpy as np
import pytest

from mien.core.errors import InputError
from mien.core.timeline import FrameRate
from mien.motion.mouth.hand_made_mouth import HandMadeMouth
from mien.speech.align import align
from mien.speech.synthesis import synthesise
from mien.speech.voices import get_voice
from tests.programs import voice_or_skip

TEXT = "Hyvää yötä, pappi! Tapaan kuningattaren Åbossa."


@pytest.mark.parametrize("name", ["suopuhe-lj", "suopuhe-mv"])
def test_finnish_is_spoken_and_timed(name: str) -> None:
    voice_or_skip(name)
    said = synthesise(TEXT, voice=name)
    assert said.language == "fi"
    assert said.timing == "voice"
    assert [word.label for word in said.words] == ["hyvää", "yötä", "pappi", "tapaan", "kuningattaren", "åbossa"]
    assert said.native is not None
    labels = [phone.label for phone in said.native if phone.label != "SIL"]
    assert " ".join(labels) == "h y ʋ æː y ø t æ p ɑ pː i t ɑ p ɑː n k u n i ŋː ɑ tː ɑ r e n oː b o sː ɑ"
    assert said.native.intervals[-1].end == pytest.approx(said.duration)
    assert any("'å' as 'oo'" in note.message for note in said.notes)
    again = synthesise(TEXT, voice=name)
    assert np.array_equal(again.audio.samples, said.audio.samples)


def test_quantity_is_seen() -> None:
    voice_or_skip("suopuhe-lj")
    said = synthesise("Papin pappi.", voice="suopuhe-lj")
    assert said.native is not None
    rate = FrameRate.of(100)
    seal = HandMadeMouth().perform(said, rate).seal
    times = rate.times(len(seal))

    def sealed(label: str) -> float:
        phone = next(p for p in said.native or () if p.label == label and p.start > 0.3)
        near = (times > phone.start - 0.05) & (times < phone.end + 0.05)
        return float((seal[near] > 0.95).sum()) / 100

    assert sealed("pː") > 1.4 * sealed("p")


def test_the_sound_of_finnish_is_aligned_with_its_text() -> None:
    voice_or_skip("suopuhe-mv")
    said = synthesise(TEXT, voice="suopuhe-mv")
    found = align(said.audio, TEXT, language="fi")
    assert found.native is not None
    assert said.native is not None
    pairs = [
        (a, b)
        for a, b in zip(
            [p for p in said.native if p.label != "SIL"], [p for p in found.native if p.label != "SIL"], strict=True
        )
        if a.label == b.label
    ]
    assert len(pairs) > 25
    assert np.median([abs(a.start - b.start) for a, b in pairs]) < 0.02


def test_a_voice_speaks_one_language() -> None:
    from mien.text.languages import find_language

    with pytest.raises(InputError, match="speaks English, not Finnish"):
        get_voice("kokoro-heart", find_language("fi"))
    with pytest.raises(InputError, match="speaks 'fi', not German"):
        get_voice("suopuhe-lj", find_language("de"))


@pytest.mark.parametrize(("tag", "text"), [("de", "Schöne Grüße über Pferde."), ("es", "¡Buenos días, señor!")])
def test_languages_of_espeak(tag: str, text: str) -> None:
    voice_or_skip(f"espeak-{tag}")
    said = synthesise(text, language=tag)
    assert said.language == tag
    assert said.native is not None
    assert len(said.words) == len(text.split())
    assert any(said.shapes)
