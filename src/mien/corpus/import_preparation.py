"""One recording becomes one take: read, check, lay on the reference, clean, align. Pure but for the files it writes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.capture.layouts import Layout, find_layout, load_layout
from mien.core.errors import InputError
from mien.corpus.face_loss import check_face
from mien.corpus.readers import Found, Raw, reader_named
from mien.corpus.recipes import Recipe
from mien.corpus.recordings import Corpus
from mien.corpus.reference_frame import settled
from mien.corpus.take import Take
from mien.corpus.take_timing import timed
from mien.corpus.transcripts import Transcript, read_transcript

__all__ = ["Job", "layout_for", "prepare", "prepare_and_write"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Job:
    """All that a worker needs to know to make one take; travels between processes.

    Attributes
    ----------
    name : str
        Of the take.
    found : Found
    recipe : Recipe
    facts : mapping of str to str
        Emotion, sentence, speaker, and text where a table or the name gives it.
    reference : ndarray, shape (markers, 3)
        The frame that all frames of this speaker are laid on, mm, in the axes of the face.
    corpus : str
        Folder.
    where : str
        The recording's place under the source, for the manifest.
    fingerprint : str
        Says whether a take that is there was made from the same files by the same settings.
    """

    name: str
    found: Found
    recipe: Recipe
    facts: Mapping[str, str]
    reference: Floats
    corpus: str
    where: str
    fingerprint: str


def layout_for(recipe: Recipe, raw: Raw, source: str) -> Layout:
    """The recipe's layout, or the smallest that has all markers."""
    return load_layout(recipe.layout) if recipe.layout else find_layout(raw.markers.names, source)


def prepare_and_write(job: Job) -> dict[str, Any]:
    """Make a take, write its files into the corpus, and return its line for the manifest."""
    return Corpus.files_only(Path(job.corpus)).write_files(prepare(job))


def prepare(job: Job) -> Take:
    """Make a take.

    Raises
    ------
    InputError
        In one line with file, frame and likely cause.
    """
    source = job.where if job.found.name == job.found.motion.stem else f"{job.where} ({job.found.name})"
    raw = reader_named(job.recipe.reader).read(job.found, job.recipe)
    layout = layout_for(job.recipe, raw, source)
    if raw.audio is None:
        raise InputError(f"{source}: no sound in it or beside it; put a WAV of the same name beside it")
    motion = settled(raw, job.recipe, layout, job.reference, source)
    lost = check_face(raw.markers, source)
    transcript = _transcript(job, source)
    speech = timed(raw.audio, transcript, job.recipe, source)
    notes = (*raw.notes, *motion.notes, *transcript.notes, *speech.notes)
    return Take(
        name=job.name,
        audio=raw.audio,
        markers=motion.track,
        text=transcript.text,
        words=speech.words,
        phones=speech.phones,
        layout=layout.name,
        head=motion.head,
        emotion=job.facts["emotion"],
        sentence=job.facts["sentence"],
        speaker=job.facts["speaker"],
        source={
            "file": job.where,
            "recipe": job.recipe.name,
            "fingerprint": job.fingerprint,
            "filled": str(motion.filled),
            "lost": str(lost),
            "dropped": " ".join(motion.dropped),
            "confidence": "" if speech.confidence is None else f"{speech.confidence:.3f}",
            "notes": " | ".join(note.message for note in notes if note.kind == "note"),
            "warnings": " | ".join(note.message for note in notes if note.kind == "warning"),
        },
        channels=raw.channels,
    )


def _transcript(job: Job, source: str) -> Transcript:
    given = job.facts.get("text", "")
    if job.found.transcript is not None:
        transcript = read_transcript(job.found.transcript)
        return replace(transcript, text=given) if given and transcript.phones is None else transcript
    if given:
        return Transcript(given)
    raise InputError(
        f"{source}: no transcript: expected {job.found.name}.txt, .lab, .align or .TextGrid beside it, "
        "or a line of --table"
    )
