"""``mien inspect``: what a performer has learned, in words and in pictures."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

__all__ = ["add_command"]


def add_command(commands: Any) -> None:
    """Add ``mien inspect`` to the commands."""
    inspect = commands.add_parser("inspect", help="show what a performer has learned")
    inspect.add_argument("performer", metavar="NAME|X.mien", help="default, or a file made by 'mien learn'")
    inspect.add_argument("-o", "--output", metavar="FOLDER", help="write pictures and the text into this folder")
    inspect.add_argument(
        "--phones",
        metavar="PHONES",
        action="append",
        default=[],
        help="diphone or triphone to draw, such as 'P AA' or 'P AA T' (repeatable; default: the most frequent)",
    )
    inspect.add_argument("--word", metavar="TEXT", help="word to draw influence curves for (default: maybe)")
    inspect.add_argument(
        "--text",
        metavar="FILE_OR_FOLDER",
        help="English text whose phone pairs to look up (default: built-in sentences)",
    )
    inspect.set_defaults(run=_inspect)


def _inspect(options: argparse.Namespace) -> int:
    from mien.core.errors import InputError
    from mien.inspection.shares import ordinary_english, read_sentences, share_of_pairs
    from mien.inspection.summary import summary
    from mien.motion.performers import load_learned_performer

    if options.output is None and (options.phones or options.word is not None):
        raise InputError("--phones and --word choose what is drawn: say where to with -o FOLDER")
    learned = load_learned_performer(options.performer)
    sentences = ordinary_english() if options.text is None else read_sentences(options.text)
    told = summary(learned, share_of_pairs(learned, sentences))
    if options.output is None:
        print(told)
        return 0
    from mien.inspection.performer_pictures import DEFAULT_WORD, pictures_of

    word = DEFAULT_WORD if options.word is None else options.word
    pictures = pictures_of(learned, options.phones, word)
    folder = _folder(options.output)
    print(told, end="\n\n")
    _write(told, pictures, folder)
    print(f"{options.output}: summary.txt, {', '.join(name for name, _ in pictures)}")
    return 0


def _folder(name: str) -> Path:
    from mien.core.errors import OutputError

    folder = Path(name)
    try:
        folder.mkdir(exist_ok=True)
    except OSError as problem:
        raise OutputError(f"cannot make the folder {folder}: {problem.strerror}") from problem
    return folder


def _write(told: str, pictures: list[Any], folder: Path) -> None:
    from tqdm import tqdm

    from mien.core.files import replace_when_complete
    from mien.core.plotting import write_png

    with replace_when_complete(folder / "summary.txt") as unfinished:
        unfinished.write_text(told + "\n", encoding="utf-8")
    for name, draw in tqdm(pictures, desc="drawing", leave=False, disable=not sys.stderr.isatty()):
        write_png(draw(), folder / name)
