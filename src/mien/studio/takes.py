"""`Take`: a performed line that the page looks at, and what it is told of it."""

from __future__ import annotations

import io
from dataclasses import dataclass, field
from functools import cached_property
from hashlib import sha256
from threading import Lock
from typing import Any

from mien.animation import Animation
from mien.audio import Audio
from mien.errors import Note
from mien.models.performer import Performer
from mien.modules.spoken import Spoken
from mien.script.intensity import IntensityCurve
from mien.script.score import EmotionSpan, Score
from mien.speech.utterance import Utterance
from mien.studio.requests import TakeRequest
from mien.timeline import FrameRate, Tier

__all__ = ["Basis", "Source", "Take", "plain_notes", "plain_tier"]


@dataclass(frozen=True, eq=False)
class Source:
    """An uploaded sound.

    Attributes
    ----------
    sound : Audio
    notes : tuple of Note
        What was done with it on reading.
    """

    sound: Audio
    notes: tuple[Note, ...]

    @cached_property
    def digest(self) -> str:
        """The same for the same samples."""
        return sha256(self.sound.samples.tobytes() + str(self.sound.rate).encode()).hexdigest()


@dataclass(frozen=True, eq=False)
class Basis:
    """What a take is performed from, before any edit.

    Attributes
    ----------
    request : TakeRequest
    source : Source or None
        What was uploaded; None where a voice speaks.
    spoken : Spoken
    score : Score
        Of the whole: the request's emotions, then those of the text.
    performer : Performer
    rate : FrameRate
    """

    request: TakeRequest
    source: Source | None
    spoken: Spoken
    score: Score
    performer: Performer
    rate: FrameRate


@dataclass(eq=False)
class Take:
    """A take as it stands.

    Attributes
    ----------
    basis : Basis
    animation : Animation
        With all edits.
    revision : int
        Counts the changes, from 1.
    """

    basis: Basis
    animation: Animation
    revision: int = 1
    lock: Lock = field(default_factory=Lock)

    @property
    def size(self) -> int:
        """Bytes in memory, roughly."""
        markers = self.animation.markers
        held = 0 if markers is None else markers.positions.nbytes
        return 2 * self.animation.channels.values.nbytes + held + self.animation.utterance.audio.samples.nbytes

    def frames(self, plain: bool = False) -> tuple[int, bytes]:
        """The revision, and all its frames as float32, little-endian, frame by frame in the order of the channels."""
        with self.lock:
            revision, shown = self.revision, self.animation
        return revision, shown.channels.values.astype("<f4").tobytes()

    def sound(self) -> bytes:
        """The sound as a WAV file, 24 bit."""
        import soundfile

        audio, content = self.animation.utterance.audio, io.BytesIO()
        soundfile.write(content, audio.samples, audio.rate, format="WAV", subtype="PCM_24")
        return content.getvalue()

    def plain(self, name: str) -> dict[str, Any]:
        """As JSON."""
        shown, track = self.animation, self.animation.channels
        return {
            "take": name,
            "request": self.basis.request.plain(),
            "from_sound": self.basis.source is not None,
            "fps": shown.rate.fps,
            "frames": len(track),
            "seconds": shown.utterance.duration,
            "text": shown.utterance.text,
            "words": plain_tier(shown.utterance.words),
            "phones": plain_tier(shown.utterance.phones),
            "emotions": [_plain_span(span, shown.utterance) for span in shown.score.emotions],
            "channels": list(track.names),
            "notes": plain_notes(shown.notes),
            "revision": self.revision,
        }


def plain_tier(tier: Tier) -> list[list[Any]]:
    """A tier as JSON: begin, end, label."""
    return [[interval.start, interval.end, interval.label] for interval in tier]


def plain_notes(notes: tuple[Note, ...]) -> list[dict[str, str]]:
    """Notes as JSON."""
    return [{"kind": note.kind, "message": note.message} for note in notes]


def _plain_span(span: EmotionSpan, utterance: Utterance) -> dict[str, Any]:
    if isinstance(span.intensity, IntensityCurve):
        points = [[time, value] for time, value in zip(span.intensity.times, span.intensity.values, strict=True)]
        how: str = span.intensity.interpolation
    else:
        start, end = span.start or 0.0, utterance.duration if span.end is None else span.end
        points, how = [[start, float(span.intensity)], [end, float(span.intensity)]], "linear"
    return {"name": span.name, "points": points, "interpolation": how, "start": span.start, "end": span.end}
