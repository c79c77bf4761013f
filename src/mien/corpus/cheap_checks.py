"""What can be said of a recording before the costly part of an import: is there a transcript, a sound, anything at all?

Tracking a video takes minutes; a missing text is noticed at once.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from mien.core.errors import InputError, MienError
from mien.corpus.import_plan import Failure
from mien.corpus.readers import Found
from mien.corpus.readers.recording_files import VIDEO
from mien.corpus.transcripts import read_transcript
from mien.formats.media import open_media

__all__ = ["cheap_faults", "check_cheaply"]


def cheap_faults(
    takes: Mapping[str, Found], facts: Mapping[str, Mapping[str, str]], source: Path
) -> tuple[dict[str, Found], list[Failure]]:
    """The recordings that can become takes as far as a glance says, and a failure for each other one.

    Parameters
    ----------
    takes : mapping of str to Found
    facts : mapping of str to mapping of str to str
        What is known of each: its text, among others.
    source : Path
        Of the import: names in messages are given from there.
    """
    base = source if source.is_dir() else source.parent
    passed: dict[str, Found] = {}
    failed: list[Failure] = []
    for name, found in takes.items():
        where = found.motion.relative_to(base).as_posix()
        where = where if found.name == found.motion.stem else f"{where} ({found.name})"
        try:
            check_cheaply(found, facts[name].get("text", ""), where)
            passed[name] = found
        except MienError as problem:
            failed.append(Failure(name, where, " ".join(str(problem).split())))
    return passed, failed


def check_cheaply(found: Found, text: str, source: str) -> None:
    """Refuse a recording that cannot become a take, without reading its motion.

    Raises
    ------
    InputError
        In one line: no transcript, one that cannot be read, an empty file, or a video without sound.
    """
    for path in found.files:
        if path.is_file() and path.stat().st_size == 0:
            raise InputError(f"{source}: {path.name} is empty (0 bytes); copy it again")
    if found.transcript is not None:
        read_transcript(found.transcript)
    elif not text:
        raise InputError(
            f"{source}: no transcript: expected {found.name}.txt, .lab, .align or .TextGrid beside it, "
            "or a line of --table"
        )
    if found.sound is None and found.motion.suffix.lower() in VIDEO:
        with open_media(found.motion, "a video") as container:
            if not container.streams.video:
                raise InputError(f"{source}: expected a video, got a file without pictures")
            if not container.streams.audio:
                raise InputError(f"{source}: no sound in it or beside it; put a WAV of the same name beside it")
