"""``mien emotion``, ``emotion-train``, ``emotion-table``: which emotion is in a voice."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mien.core.audio import Audio
    from mien.core.errors import Note
    from mien.emotion.emotion_classifier import EmotionClassifier, EmotionReading

__all__ = ["add_emotion_commands"]


def add_emotion_commands(commands: Any) -> None:
    """Add the commands on emotion: read from the voice, changed in a motion."""
    from mien.cli import emotion_map_command as emotion_map

    emotion_map.add_command(commands)
    emotion = commands.add_parser("emotion", help="recognise the emotion in a voice")
    emotion.add_argument("files", metavar="FILE", nargs="+", help="sound files, or videos with a sound track")
    emotion.add_argument("--classifier", metavar="X.npz", help="a classifier made by 'mien emotion-train'")
    emotion.add_argument(
        "--baseline", metavar="NEUTRAL", nargs="+", default=[], help="recordings of the same speaker without emotion"
    )
    emotion.add_argument(
        "--together",
        action="store_true",
        help="judge the files together, as one speaker in several moods (the default for several files)",
    )
    emotion.add_argument("--apart", action="store_true", help="judge each file by itself")
    emotion.add_argument(
        "--over-time", action="store_true", help="report every change of emotion in a longer recording"
    )
    emotion.add_argument("--json", action="store_true", help="write JSON, one object per file")
    emotion.set_defaults(run=_emotion)

    train = commands.add_parser("emotion-train", help="learn a classifier of voices from labelled recordings")
    _add_corpora(train)
    train.add_argument("-o", "--output", metavar="X.npz", required=True, help="the classifier to write")
    train.add_argument("--features", default="voice", help="voice (default), or cepstral:500 (Cao et al. 2005)")
    train.add_argument(
        "--kernel", choices=("radial", "linear"), help="default: linear for voices, radial for the paper's features"
    )
    train.add_argument("--cost", type=float, help="C of libsvm (default: linear 0.003, radial 0.5)")
    train.add_argument(
        "--variations",
        type=int,
        help="variations of each recording with other rooms and microphones (default 4; cepstral: 0)",
    )
    train.add_argument("--cluster", metavar="tcp://HOST:PORT", help="measure on a Dask cluster; the result is the same")
    train.set_defaults(run=_train)

    table = commands.add_parser("emotion-table", help="how well emotions are recognised in voices (Cao et al. 2005)")
    _add_corpora(table)
    table.add_argument("--report", metavar="X.md", help="write the tables into this file")
    table.set_defaults(run=_table)


def _add_corpora(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "corpora",
        metavar="CORPUS",
        nargs="+",
        help="a .csv with the columns file, emotion and speaker, or a folder as described in docs/emotion.md",
    )
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--workers", type=int, help="number of processes (default: one per core)")
    parser.add_argument("--quiet", action="store_true", help="print nothing but errors")


def _emotion(options: argparse.Namespace) -> int:
    from mien.core.errors import InputError
    from mien.emotion.emotion_classifier import default_classifier, load_classifier
    from mien.formats.sound_files import read_audio

    for other in ("apart", "over_time", "baseline"):
        if options.together and getattr(options, other):
            raise InputError(f"--together and --{other.replace('_', '-')} exclude one another")
    classifier = load_classifier(options.classifier) if options.classifier else default_classifier()
    baseline = [read_audio(path)[0] for path in options.baseline]
    beside = not (options.apart or options.over_time or baseline)
    groups = _speakers(options.files, options.together) if beside else [[path] for path in options.files]
    if any(len(group) > 1 for group in groups):
        sounds = {path: read_audio(path)[0] for path in options.files}
        told: dict[str, EmotionReading] = {}
        for group in groups:
            told |= dict(zip(group, classifier.read_together([sounds[path] for path in group]), strict=True))
        return _tell([(path, told[path]) for path in options.files], classifier, options.json)
    for number, path in enumerate(options.files):
        audio, _ = read_audio(path)
        if options.over_time:
            _tell_stretches(path, audio, classifier, options.json, baseline)
        else:
            _tell([(path, classifier.read(audio, baseline))], classifier, options.json, heading=number == 0)
        sys.stdout.flush()
    return 0


def _speakers(paths: list[str], together: bool) -> list[list[str]]:
    """The files of each speaker, as far as their names tell; all are one speaker's where they do not."""
    from mien.corpus.labelled_sounds import speaker_of_name

    speakers = [None if together else speaker_of_name(path) for path in paths]
    if len(paths) > 1 and None in speakers and not together:
        print(
            f"mien: note: the {len(paths)} files are taken for one speaker's and judged beside one another; "
            "--apart judges each alone",
            file=sys.stderr,
        )
    if None in speakers:
        return [list(dict.fromkeys(paths))]
    return [
        [path for path, of in dict.fromkeys(zip(paths, speakers, strict=True)) if of == name]
        for name in dict.fromkeys(speakers)
    ]


def _tell(
    readings: list[tuple[str, EmotionReading]], classifier: EmotionClassifier, as_json: bool, heading: bool = True
) -> int:
    if heading and not as_json:
        print(
            f"{'emotion':10}  {'likeliest':10}  intensity  "
            + "  ".join(f"{n:>9}" for n in classifier.emotions)
            + "  file"
        )
    for path, reading in readings:
        if as_json:
            print(json.dumps({"file": path, **_as_data(reading)}))
        else:
            shares = "  ".join(f"{reading.probabilities[name]:9.2f}" for name in classifier.emotions)
            print(f"{reading.emotion:10}  {reading.most_likely:10}  {reading.intensity:9.2f}  {shares}  {path}")
    return 0


def _tell_stretches(
    path: str, audio: Any, classifier: EmotionClassifier, as_json: bool, baseline: Sequence[Audio]
) -> None:
    from mien.emotion.emotion_over_time import read_over_time

    stretches = read_over_time(audio, classifier, baseline)
    if as_json:
        told = [{"start": s.start, "end": s.end, **_as_data(s.reading)} for s in stretches]
        print(json.dumps({"file": path, "stretches": told}))
        return
    print(path)
    for s in stretches:
        reading = s.reading
        sure = f"{reading.most_likely} {reading.probabilities[reading.most_likely]:.2f}"
        print(f"  {s.start:7.2f} - {s.end:7.2f} s  {reading.emotion:10} {reading.intensity:4.2f}  (likeliest {sure})")


def _as_data(reading: EmotionReading) -> dict[str, Any]:
    return {
        "emotion": reading.emotion,
        "most_likely": reading.most_likely,
        "sure": reading.is_sure,
        "intensity": round(reading.intensity, 4),
        "activation": round(reading.activation, 4),
        "seconds_of_speech": round(reading.seconds, 3),
        "probabilities": {name: round(value, 4) for name, value in reading.probabilities.items()},
    }


def _train(options: argparse.Namespace) -> int:
    from mien.core.errors import InputError
    from mien.core.files import check_writable
    from mien.corpus.labelled_sounds import read_labelled_sounds
    from mien.emotion.emotion_classifier import EmotionClassifier
    from mien.emotion.emotion_samples import VOICE, emotion_samples, join_samples

    path = check_writable(options.output)
    if path.suffix.lower() != ".npz":
        raise InputError(f"mien emotion-train writes an .npz file, not {options.output!r}; give -o NAME.npz")
    if options.cost is not None and options.cost <= 0:
        raise InputError(f"a cost is greater than 0, not {options.cost:g}")
    variations = options.variations if options.variations is not None else (4 if options.features == VOICE else 0)
    if variations < 0 or options.seed < 0:
        raise InputError("--variations and --seed are whole numbers, 0 or more")
    corpora = [read_labelled_sounds(source) for source in options.corpora]
    samples = []
    for corpus in corpora:
        with _bar(options.quiet, corpus.name) as progress:
            samples.append(
                emotion_samples(
                    corpus, options.features, variations, options.seed, options.workers, progress, options.cluster
                )
            )
        _notes(samples[-1].notes, options.quiet)
    learned = EmotionClassifier(options.features, options.kernel, options.cost).fit(
        join_samples(samples), {"corpora": ", ".join(corpus.name for corpus in corpora)}
    )
    learned.save(path)
    if not options.quiet:
        recordings = sum(len(corpus.sounds) for corpus in corpora)
        print(f"{path}: {', '.join(learned.emotions)}; learned from {recordings} recordings")
    return 0


def _table(options: argparse.Namespace) -> int:
    from mien.core.files import check_writable, replace_when_complete
    from mien.corpus.labelled_sounds import read_labelled_sounds
    from mien.metrics.emotion_tables import emotion_tables

    path = check_writable(options.report) if options.report else None
    corpora = [read_labelled_sounds(source) for source in options.corpora]
    with _bar(options.quiet, "measuring") as progress:
        text, notes = emotion_tables(corpora, options.seed, options.workers, progress)
    _notes(notes, options.quiet)
    if path is None:
        print(text)
        return 0
    with replace_when_complete(path) as unfinished:
        unfinished.write_text(text + "\n", encoding="utf-8")
    if not options.quiet:
        print(f"{path}: tables of {', '.join(corpus.name for corpus in corpora)}")
    return 0


@contextmanager
def _bar(quiet: bool, name: str) -> Iterator[Callable[[int, int], None]]:
    from tqdm import tqdm

    with tqdm(desc=name, leave=False, disable=quiet or not sys.stderr.isatty()) as bar:

        def progress(done: int, total: int) -> None:
            bar.total = total
            bar.update(done - bar.n)

        yield progress


def _notes(notes: tuple[Note, ...], quiet: bool) -> None:
    if not quiet:
        for note in notes:
            print(f"mien: {note.kind}: {note.message}", file=sys.stderr)
