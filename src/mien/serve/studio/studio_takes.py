"""`Take`: a performed line that the page looks at, and what it is told of it."""

from __future__ import annotations

import io
from dataclasses import dataclass, field, replace
from functools import cached_property
from hashlib import sha256
from threading import Lock
from typing import Any

from mien.animation.animation import Animation
from mien.animation.edits import EditLayer, line_of, plain_layer
from mien.animation.edits.applied import AppliedEdits, Before
from mien.animation.edits.borders import with_borders
from mien.animation.edits.edited_emotions import asked_emotions, with_intensities
from mien.animation.edits.layer_file import plain_line
from mien.core.audio import Audio
from mien.core.errors import Note
from mien.core.timeline import FrameRate, Tier
from mien.core.utterance import Utterance
from mien.motion.performer import Performer
from mien.pipeline.edited_performance import perform_under
from mien.pipeline.spoken import Spoken
from mien.serve.studio.requests import TakeRequest
from mien.text.intensity import IntensityCurve
from mien.text.score import EmotionSpan, Score

__all__ = ["Basis", "Source", "Take", "plain_notes", "plain_tier"]

_IN_THE_PAGE = ("--effort auto keeps the voice's", "the effort 'as the voice' keeps it")


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

    def under(self, layer: EditLayer) -> Animation:
        """The performance with a layer's borders and intensities, but without its curves."""
        utterance, seed = self.spoken.utterance, self.request.seed
        return perform_under(utterance, self.score, self.performer, self.rate, seed, layer)

    def neutral(self, layer: EditLayer) -> Animation:
        """The performance with a layer's borders, without any emotion and without curves."""
        calm = replace(layer, edits=tuple(edit for _, edit in layer.borders), emotions=())
        score = replace(self.score, emotions=())
        return perform_under(self.spoken.utterance, score, self.performer, self.rate, self.request.seed, calm)

    def with_layer(self, under: Animation, layer: EditLayer) -> Animation:
        """A performance of `under` with another layer of the same borders and intensities."""
        utterance = self.spoken.utterance
        speech, lost, notes = with_borders(layer, utterance)
        _, also_lost, also_noted = with_intensities(layer, speech, self.score, self.performer.expression.names)
        before = Before(utterance.words, utterance.phones, utterance.native, self.score.emotions)
        edits = AppliedEdits(layer, (*lost, *also_lost), before)
        plain = (*under.utterance.notes, *self.performer.expression.notes(under.score))
        return replace(under, edits=edits, notes=(*plain, *notes, *also_noted))


@dataclass(eq=False)
class Take:
    """A take as it stands.

    Attributes
    ----------
    basis : Basis
    under : Animation
        With moved borders and changed intensities, but without the curves of edited channels.
    animation : Animation
        With all edits.
    layer : EditLayer
        With the line on which it was made.
    revision : int
        Counts the changes, from 1.
    """

    basis: Basis
    under: Animation
    animation: Animation
    layer: EditLayer
    revision: int = 1
    lock: Lock = field(default_factory=Lock)
    changing: Lock = field(default_factory=Lock)

    @property
    def size(self) -> int:
        """Bytes in memory, roughly."""
        markers = self.animation.markers
        held = 0 if markers is None else markers.positions.nbytes
        return 2 * self.animation.channels.values.nbytes + held + self.animation.utterance.audio.samples.nbytes

    def frames(self, kind: str = "") -> tuple[int, bytes]:
        """The revision, and all its frames as float32, little-endian, frame by frame in the order of the channels.

        ``kind``: ``"plain"`` leaves out the curves of edited channels, ``"neutral"`` those and all emotions.
        """
        with self.lock:
            revision, shown, layer = self.revision, self.under if kind == "plain" else self.animation, self.layer
        if kind == "neutral":
            shown = self.basis.neutral(layer)
        return revision, shown.channels.values.astype("<f4").tobytes()

    def sound(self) -> bytes:
        """The sound as a WAV file, 24 bit."""
        import soundfile

        audio, content = self.animation.utterance.audio, io.BytesIO()
        soundfile.write(content, audio.samples, audio.rate, format="WAV", subtype="PCM_24")
        return content.getvalue()

    def plain(self, name: str) -> dict[str, Any]:
        """As JSON."""
        with self.lock:
            shown, layer, revision = self.animation, self.layer, self.revision
        track, bare = shown.channels, self.basis.spoken.utterance
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
            "plain_words": plain_tier(bare.words),
            "plain_phones": plain_tier(bare.phones),
            "line": plain_line(line_of(bare).line),
            "asked_emotions": list(asked_emotions(self.basis.score)),
            "emotions": [_plain_span(span, shown.utterance) for span in shown.score.emotions],
            "channels": list(track.names),
            "notes": plain_notes(shown.notes),
            "edits": plain_layer(layer),
            "lost": [vars(loss) for loss in shown.edits.lost] if shown.edits is not None else [],
            "revision": revision,
        }


def plain_tier(tier: Tier) -> list[list[Any]]:
    """A tier as JSON: begin, end, label."""
    return [[interval.start, interval.end, interval.label] for interval in tier]


def plain_notes(notes: tuple[Note, ...]) -> list[dict[str, str]]:
    """Notes as JSON, in the words of the page."""
    return [{"kind": note.kind, "message": note.message.replace(*_IN_THE_PAGE)} for note in notes]


def _plain_span(span: EmotionSpan, utterance: Utterance) -> dict[str, Any]:
    if isinstance(span.intensity, IntensityCurve):
        points = [[time, value] for time, value in zip(span.intensity.times, span.intensity.values, strict=True)]
        how: str = span.intensity.interpolation
    else:
        start, end = span.start or 0.0, utterance.duration if span.end is None else span.end
        points, how = [[start, float(span.intensity)], [end, float(span.intensity)]], "linear"
    return {"name": span.name, "points": points, "interpolation": how, "start": span.start, "end": span.end}
