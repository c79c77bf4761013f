"""``mien voices | emotions | faces | languages | formats | performers``: what there is to choose from."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Sequence
from typing import Any

from mien.cli.face_make_command import write_sheet

__all__ = ["add_commands"]

Row = tuple[str, str]


def add_commands(commands: Any) -> None:
    """Add the lists to the parser of ``mien``."""
    for name, (what, rows) in LISTS.items():
        parser = commands.add_parser(name, help=what)
        parser.set_defaults(run=_printing(rows))
        if name == "faces":
            parser.add_argument("--sheet", metavar="X.png", help="draw them all on one sheet")


def _printing(rows: Callable[[], Iterable[Row]]) -> Callable[[argparse.Namespace], int]:
    def run(options: argparse.Namespace) -> int:
        if getattr(options, "sheet", None) is not None:
            write_sheet(options.sheet)
        print(table(tuple(rows())), end="")
        return 0

    return run


def table(rows: Sequence[Row]) -> str:
    """Two columns, names first.

    Examples
    --------
    >>> print(table([(".mp4", "video"), (".TextGrid", "words")]), end="")
    .mp4       video
    .TextGrid  words
    """
    width = max((len(name) for name, _ in rows), default=0)
    return "".join(f"{name:{width}}  {what}".rstrip() + "\n" for name, what in rows)


def _voices() -> Iterable[Row]:
    from mien.speech.voices import catalogue

    for voice in catalogue():
        availability = voice.availability()
        state = "installed" if availability.installed else f"not installed: {availability.hint}"
        yield voice.name, f"{voice.language}, {voice.engine}; {state}"


def _emotions() -> Iterable[Row]:
    from mien.motion.performers import load_performer

    performer = load_performer("default")
    yield "neutral", "as spoken"
    for name in performer.expression.names:
        if name == "neutral":
            continue
        yield name, f"--emotion {name}, {name}:0.6 for less, '{name}[0.5-1.2]' for a stretch (seconds)"


def _faces() -> Iterable[Row]:
    from mien.face.cast.made_person import person_named
    from mien.face.library import known_faces

    yield "default", "a young man; the face that everything is learned on"
    for name in known_faces()[1:]:
        yield name, person_named(name).summary
    yield "NAME+NAME:0..1", "between two of the cast; new ones from a seed: mien face make --help"
    yield "FILE", ".glb, .vrm or .gltf with blendshapes of its own, .npz, or .obj with a parameter tree (docs/faces.md)"


def _languages() -> Iterable[Row]:
    from mien.text.languages import find_language, known_languages

    yield "en", "English, with or without a text"
    for tag in known_languages():
        language = find_language(tag)
        assert language is not None
        yield tag, f"{language.name}, mapped onto English; read by {language.reader}"
    yield "FILE.toml", "a phone map of your own (docs/languages.md)"


def _formats() -> Iterable[Row]:
    from mien.core.errors import MissingPartError
    from mien.formats import exporters

    for exporter in exporters():
        try:
            exporter.check()
            missing = ""
        except MissingPartError as problem:
            missing = f"; not installed: {problem}"
        yield exporter.suffix, f"{exporter.title}{missing}"


def _performers() -> Iterable[Row]:
    from mien.motion.performers import HAND_MADE, brought_performers, known_performers, load_learned_performer

    for name in known_performers():
        if name == HAND_MADE:
            yield name, "made by hand, learned from nobody"
        elif name in brought_performers():
            yield name, f"of the package {brought_performers()[name][0]}"
        else:
            yield name, f"learned from {len(load_learned_performer(name).trained_on)} takes (see NOTICE)"
    yield "FILE.mien", "one of your own, learned by 'mien learn'"


LISTS: dict[str, tuple[str, Callable[[], Iterable[Row]]]] = {
    "voices": ("list the voices", _voices),
    "emotions": ("list the emotions", _emotions),
    "faces": ("list the faces that come with mien", _faces),
    "languages": ("list the languages", _languages),
    "formats": ("list the formats that are written", _formats),
    "performers": ("list the performers", _performers),
}
