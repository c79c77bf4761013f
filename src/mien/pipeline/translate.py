"""`translate`: every high-level command becomes curves of face parameters."""

from __future__ import annotations

from dataclasses import replace

from mien.core.errors import Note
from mien.pipeline.spoken import Spoken
from mien.text.commands import CommandLibrary, shipped_library

__all__ = ["translate"]


def translate(spoken: Spoken, library: CommandLibrary | None = None) -> Spoken:
    """Translate all commands; the result has none left.

    Raises
    ------
    InputError
        If a command is not known or its parameters do not fit.
    """
    library = library or shipped_library()
    curves, notes = list(spoken.curves), list[Note]()
    for command in spoken.commands:
        translation = library.translate(command)
        curves += translation.curves
        notes += translation.notes
    return replace(spoken, utterance=spoken.utterance.with_notes(*notes), commands=(), curves=tuple(curves))
