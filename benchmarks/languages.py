"""How exact is alignment in other languages, from text to phones? Writes docs/tables/languages.md.

    python benchmarks/languages.py --data FOLDER               about five minutes on two cores
    python benchmarks/languages.py --data FOLDER --subset 10   a quick look

* German: EmoDB against its hand labels. Its ten sentences go the way of ``--language de`` (eSpeak NG reads them, the
  phone map leads to the English acoustic model). The sounds are cut at 2 s, so each text is cut after the last word
  that the labels hold as a whole, and the sound with it.
* Finnish: Festival's two voices against their own phone times; the text is read by its letters (``--language fi``).
* Every language: eSpeak NG's voice against its own phone times, over the sentences of its table (``mien language
  check``). Made speech of one engine, which also reads the text for the aligner: it says that the phone map and the way
  through it hold, less about people.
* A boundary counts where its neighbours are the same phones in both. *Warned* is the share of true texts that get a
  warning that text and sound do not fit.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from difflib import SequenceMatcher
from pathlib import Path

import hand_labels
import numpy as np
from hand_labels import Labelled

from mien.core.audio import Audio
from mien.core.timeline import Interval
from mien.core.utterance import PAUSE, Utterance
from mien.speech.align import align
from mien.speech.language_check import boundary_errors, check_language, heard_phones
from mien.speech.synthesis import synthesise
from mien.text.languages import find_language, heard_as, known_languages
from mien.text.languages.reading import read_in

OUT = Path(__file__).parent.parent / "docs" / "tables" / "languages.md"
FILES = 150
GERMAN = {
    "a01": "Der Lappen liegt auf dem Eisschrank.",
    "a02": "Das will sie am Mittwoch abgeben.",
    "a04": "Heute abend könnte ich es ihm sagen.",
    "a05": "Das schwarze Stück Papier befindet sich da oben neben dem Holzstück.",
    "a07": "In sieben Stunden wird es soweit sein.",
    "b01": "Was sind denn das für Tüten, die da unter dem Tisch stehen?",
    "b02": "Sie haben es gerade hochgetragen und jetzt gehen sie wieder runter.",
    "b03": "An den Wochenenden bin ich jetzt immer nach Hause gefahren und habe Agnes besucht.",
    "b09": "Ich will das eben wegbringen und dann mit Karl was trinken gehen.",
    "b10": "Die wird auf dem Platz sein, wo wir sie immer hinlegen.",
}
FINNISH = (
    "Hyvää päivää, tämä on suomenkielinen puhuva pää.",
    "Se ilahtuu, kun sille puhutaan kauniisti.",
    "Yöllä satoi lunta, ja aamulla kaikki oli valkoista.",
    "Kuningas ja kuningatar kävelivät hitaasti metsän läpi.",
    "Minä en ymmärrä, miksi hän suuttui niin kovasti.",
    "Talvi tulee tänä vuonna aikaisin pohjoiseen.",
)
HEAD = "| language | utterances | boundaries | counted | median ms | mean ms | ≤20 ms | ≤50 ms | warned |\n"


def heard_in(utterance: Utterance) -> list[Interval]:
    language = find_language(utterance.language)
    assert language is not None
    return heard_phones(utterance, language)


def whole_words(item: Labelled) -> tuple[str, float] | None:
    """The words that the labels hold as a whole, and where the last of them ends."""
    german = find_language("de")
    assert german is not None
    said = read_in(german, GERMAN[item.name[2:5]])
    labels = [phone for phone in item.phones if phone.label != PAUSE]
    phones = [heard_as(word.phones or (), german) for word in said.words]
    flat = [phone for word in phones for phone in word]
    match = SequenceMatcher(None, flat, [p.label for p in labels], autojunk=False).get_matching_blocks()
    place = {block.a + k: block.b + k for block in match for k in range(block.size)}
    ends = np.cumsum([len(word) for word in phones]) - 1
    for count in range(len(ends), 1, -1):
        last = place.get(int(ends[count - 1]))
        if last is not None and last < len(labels) - 1:
            return " ".join(said.written[w.start : w.end] for w in said.words[:count]), labels[last].end
    return None


def row(name: str, utterances: int, found: Sequence[float], boundaries: int, warned: int) -> str:
    e = np.array(found)
    cells = [name, str(utterances), str(len(e)), f"{len(e) / boundaries:.0%}", f"{1000 * np.median(e):.1f}"]
    cells += [f"{1000 * e.mean():.1f}", f"{np.mean(e <= 0.02):.0%}", f"{np.mean(e <= 0.05):.0%}"]
    return "| " + " | ".join([*cells, f"{warned / utterances:.0%}"]) + " |"


def has_warning(utterance: Utterance) -> bool:
    return any(note.kind == "warning" for note in utterance.notes)


def german_row(data: Path, number: int) -> str:
    found: list[float] = []
    boundaries, utterances, warned = 0, 0, 0
    for item in hand_labels.emodb(data / "emodb", number):
        cut = whole_words(item)
        if cut is None:
            continue
        text, end = cut
        audio = Audio(item.audio.samples[: round((end + 0.05) * item.audio.rate)], item.audio.rate)
        aligned = align(audio, text, language="de")
        labels = [phone for phone in item.phones if phone.end <= end + 1e-6]
        found += boundary_errors(labels, heard_in(aligned))
        boundaries += len(labels) - 1
        utterances, warned = utterances + 1, warned + has_warning(aligned)
    return row("German, EmoDB, hand labels", utterances, found, boundaries, warned)


def engine_row(name: str, voice: str, language: str, texts: Sequence[str]) -> str:
    """Made speech against the times that its engine gives."""
    found: list[float] = []
    boundaries, warned = 0, 0
    for text in texts:
        said = synthesise(text, voice=voice)
        aligned = align(said.audio, text, language=language)
        found += boundary_errors(heard_in(said), heard_in(aligned))
        boundaries += len(heard_in(said)) - 1
        warned += has_warning(aligned)
    return row(f"{name}, {voice}, the engine's times", len(texts), found, boundaries, warned)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True, help="folder of emodb")
    parser.add_argument("--subset", type=int, help="only so many files of EmoDB")
    parser.add_argument("--out", type=Path, default=OUT)
    options = parser.parse_args()
    rows = [german_row(options.data, options.subset or FILES)]
    rows += [engine_row("Finnish", voice, "fi", FINNISH) for voice in ("suopuhe-lj", "suopuhe-mv")]
    for tag in known_languages():
        done = check_language(tag)
        name = f"{done.language}, espeak-{tag}, the engine's times"
        rows.append(row(name, done.sentences, done.errors.tolist(), done.boundaries, done.warned))
    page = (
        "# Alignment in other languages\n\nWritten by `python benchmarks/languages.py`"
        f"{'' if options.subset is None else ', a subset'}; definitions stand at its head.\n\n{HEAD}| "
        + " | ".join(["---"] * 9)
        + " |\n"
        + "\n".join(rows)
        + "\n"
    )
    options.out.parent.mkdir(parents=True, exist_ok=True)
    options.out.write_text(page, encoding="utf-8")
    print(page)


if __name__ == "__main__":
    main()
