"""Does the voice say what is felt? Measured pitch, rate and level, a reader of emotion, a recogniser of phones.

    python benchmarks/emotional_voice.py [--voices kokoro-heart,espeak] [--sentences 8]

writes ``docs/tables/emotional_voice.md``. Sentences that the reader of emotion never heard are spoken without emotion
and then with each at full strength (`mien.emotion.emotional_voice`). The reader was learned from recordings of people.
*Alone*: it hears one sentence; *beside neutral*: it also hears the same voice saying the other sentences without
emotion. The reader was not used to tune ``assets/performance/emotions`` on these lines, but it
was learned from the corpus whose means stand behind the sizes of pitch and tilt there.
Phone error: edit distance of what a recogniser (hama) hears from the dictionary, as in ``benchmarks/voices.py``.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from voices import heard_phones, phone_errors

from mien.core.emotions import emotions
from mien.core.files import replace_when_complete
from mien.core.utterance import PAUSE, Utterance
from mien.emotion.emotion_classifier import NEUTRAL, EmotionClassifier, default_classifier
from mien.emotion.emotion_samples import VOICE, features_of
from mien.emotion.emotional_voice import with_feeling
from mien.speech.pitch import level_contour, pitch_contour
from mien.speech.synthesis import synthesise
from mien.speech.voices import get_voice
from mien.text.normalisation import spoken_words
from mien.text.score import EmotionSpan, Score

TABLE = Path(__file__).parent.parent / "docs" / "tables" / "emotional_voice.md"
SPEAKING = {name: table["voice"] for name, table in emotions().items() if "voice" in table}
EMOTIONS = (NEUTRAL, *SPEAKING)
JUDGED = (NEUTRAL, "happy", "sad", "angry", "afraid")
SENTENCES = (
    "I never said that you could take it with you.",
    "The kids are talking by the door.",
    "We will be there at seven, and then we go home.",
    "Put the letter on the table before you leave.",
    "She told me that nobody had seen the money.",
    "It rained all night and the river rose again.",
    "Where did you leave the keys?",
    "My brother is coming back tomorrow morning.",
    "Dogs are sitting by the door.",
    "They have changed the plan, so we must wait.",
)


def measured(said: Utterance) -> dict[str, float]:
    """What can be measured of one sentence."""
    pitch, level = pitch_contour(said.audio), level_contour(said.audio)
    height = pitch.semitones(100.0)[pitch.voiced]
    spoken = [phone for phone in said.phones if phone.label != PAUSE]
    active = level.decibels > np.percentile(level.decibels, 95) - 30
    spectrum = np.abs(np.fft.rfft(said.audio.samples)) ** 2
    hertz = np.fft.rfftfreq(len(said.audio), 1 / said.audio.rate)
    low, high = (spectrum[(hertz >= a) & (hertz < b)].sum() for a, b in ((50, 1000), (1000, 5000)))
    return {
        "pitch": float(np.median(height)),
        "range": float(np.percentile(height, 90) - np.percentile(height, 10)),
        "rate": len(spoken) / sum(phone.duration for phone in spoken),
        "level": float(10 * np.log10((10 ** (level.decibels[active] / 10)).mean())),
        "bright": float(10 * np.log10(high / low)),
    }


def spoken_by(voice: str, sentences: int) -> dict[str, list[Utterance]]:
    plain = [synthesise(text, voice=voice) for text in SENTENCES[:sentences]]
    carried = get_voice(voice).feeling
    return {
        emotion: [
            with_feeling(said, Score((EmotionSpan(emotion),)), seed=n, carried=carried) for n, said in enumerate(plain)
        ]
        for emotion in EMOTIONS
    }


def direction_rows(said: dict[str, list[Utterance]]) -> list[str]:
    """Each emotion less neutral, means over sentences; a sign that is not the table's stands with a mark."""
    found = {emotion: [measured(one) for one in lines] for emotion, lines in said.items()}
    rows = []
    for emotion in SPEAKING:
        asked = SPEAKING[emotion]
        cells = []
        for name, unit in (("pitch", "st"), ("range", "%"), ("rate", "%"), ("level", "dB"), ("bright", "dB")):
            pairs = [(a[name], b[name]) for a, b in zip(found[emotion], found[NEUTRAL], strict=True)]
            change = np.mean([100 * (a / b - 1) if unit == "%" else a - b for a, b in pairs])
            goal = asked.get("tilt" if name == "bright" else name, 1.0 if unit == "%" else 0.0)
            goal = goal - 1 if unit == "%" else goal
            wrong = " ✗" if goal * change < 0 and abs(goal) > 0.01 else ""
            cells.append(f"{change:+.1f} {unit}{wrong}" if unit != "%" else f"{change:+.0f} %{wrong}")
        rows.append(f"| {emotion} | {' | '.join(cells)} |")
    return rows


def read_rows(said: dict[str, list[Utterance]], reader: EmotionClassifier) -> list[str]:
    """How often the reader finds the emotion likeliest of those judged, alone and beside neutral lines."""
    heard = {emotion: np.array([features_of(one.audio, VOICE) for one in said[emotion]]) for emotion in JUDGED}
    places = [reader.emotions.index(name) for name in JUDGED]
    neutral = heard[NEUTRAL]
    others = np.array(
        [reader.baseline_of(np.delete(neutral, row, axis=0), neutral=True) for row in range(len(neutral))]
    )
    rows, found = [], []
    for number, emotion in enumerate(JUDGED):
        read = [reader.probabilities(heard[emotion], base)[:, places].argmax(axis=1) for base in (None, others)]
        found.append([float((likeliest == number).mean()) for likeliest in read])
        rows.append(f"| {emotion} | {found[-1][0]:.2f} | {found[-1][1]:.2f} |")
    alone, beside = np.mean(found, axis=0)
    return [*rows, f"| mean | {alone:.2f} | {beside:.2f} |"]


def phone_error(lines: list[Utterance]) -> float:
    wrong = count = 0
    for one in lines:
        wrong += phone_errors(spoken_words(one.text), heard_phones(one.audio))
        count += sum(phone.label != PAUSE for phone in one.phones)
    return 100 * wrong / count


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--voices", default="kokoro-heart,espeak")
    parser.add_argument("--sentences", type=int, default=8)
    given = parser.parse_args()
    lines = [
        "# The voice and what is felt",
        "",
        f"Written by `python benchmarks/emotional_voice.py`: {given.sentences} sentences, emotions at full strength.",
        "Changes are against the same voice without emotion; ✗: not in the direction of the table and its sources",
        "(`assets/performance/emotions`). Bright: level above 1 kHz less that below.",
        "Recognised: how often a reader of emotion learned from people finds the emotion likeliest of these five;",
        "chance is .20. It was learned from the corpus (EmoDB) whose means stand behind the sizes of pitch and tilt.",
        "Phone error in %, as in [voices](voices.md).",
    ]
    for voice in given.voices.split(","):
        said = spoken_by(voice, given.sentences)
        lines += ["", f"## {voice}", "", "| | pitch | range | rate | level | bright |", "| --- |" + " ---: |" * 5]
        lines += direction_rows(said)
        rows = read_rows(said, default_classifier())
        lines += ["", "| recognised | alone | beside neutral |", "| --- | ---: | ---: |", *rows]
        errors = {emotion: phone_error(said[emotion]) for emotion in EMOTIONS}
        lines += ["", "| | " + " | ".join(errors) + " |", "| --- |" + " ---: |" * len(errors)]
        lines += ["| phone error | " + " | ".join(f"{value:.1f}" for value in errors.values()) + " |"]
        print("\n".join(lines[-22:]), flush=True)
    with replace_when_complete(TABLE) as unfinished:
        unfinished.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
