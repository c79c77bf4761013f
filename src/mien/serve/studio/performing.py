"""`Performing`: lines spoken or heard, and performed; what was spoken a short while ago is not spoken again.

Models are loaded once, when first needed. All work here runs in the threads of the `JobPool`.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from threading import RLock, Thread

from mien.animation.edits import EMPTY, EditLayer, line_of
from mien.animation.edits.edited_emotions import asked_emotions
from mien.core.errors import InputError, MienError
from mien.core.progress import Listener, listening
from mien.core.timeline import FrameRate
from mien.motion.alive.visual_prosody import HandMadeProsody
from mien.motion.performer import Performer
from mien.motion.performers import load_performer
from mien.pipeline.edited_performance import directed, with_edited_channels
from mien.pipeline.inputs import spoken_recording, spoken_text
from mien.pipeline.options import is_auto, prepared, score_with_voice, with_heard_effort
from mien.pipeline.spoken import Spoken
from mien.serve.studio.given_speech import as_corrected
from mien.serve.studio.jobs import Cancelled, Job, Part
from mien.serve.studio.lru_store import Kept
from mien.serve.studio.page_memory import RememberingMouth, RememberingVoice
from mien.serve.studio.requests import FieldError, TakeRequest
from mien.serve.studio.settings import Limits
from mien.serve.studio.studio_lines import beginnings_of, checked_script
from mien.serve.studio.studio_takes import Basis, Source, Take
from mien.text.score import Score

__all__ = ["Performing"]

_SPOKEN_KEPT = 8


class Performing:
    """The voices and performers of one studio.

    Parameters
    ----------
    limits : Limits
    folder : Path
        Where what was spoken is kept.
    """

    def __init__(self, limits: Limits, folder: Path) -> None:
        self.limits = limits
        self._performers: dict[tuple[str, str | None], Performer] = {}
        self._spoken: Kept[Spoken] = Kept("speech", _SPOKEN_KEPT)
        self._voice = RememberingVoice(folder)
        self._making: dict[str, RLock] = {}
        self._lock = RLock()

    def by_and_by(
        self, request: TakeRequest, source: Source | None, job: Job, layer: EditLayer, show: Callable[[Take], str]
    ) -> Take:
        """Perform; of a long text the beginning can be heard and seen while the rest is made.

        As soon as that is there, and not before, the voice speaks on, so that what it has said need only be performed.
        ``show`` keeps a beginning and gives its id.
        """
        beginnings = beginnings_of(request.text) if source is None else ()
        for number, beginning in enumerate(beginnings):
            with contextlib.suppress(InputError):  # what is wrong with the text is told of the whole
                first = self.perform(replace(request, text=beginning), None, Part(job))
                job.shows(show(first))
            if number == 0:
                Thread(target=self._speak_on, args=(request, job), name="studio-voice", daemon=True).start()
        return self.perform(request, source, job, layer)

    def _speak_on(self, request: TakeRequest, job: Job) -> None:
        """Speak a text whose beginning is performed meanwhile; who asks for it waits (`_remembered`)."""
        with contextlib.suppress(Cancelled, MienError):  # who waits for it is told the reason
            performer, score, _ = self._directed(request)
            with listening(_telling(job)):
                self._speech(request, None, performer, score)

    def _directed(self, request: TakeRequest) -> tuple[Performer, Score, FrameRate]:
        """Who performs, what is felt, and how many frames a second."""
        performer = self.performer(request)
        emotions = [one for one in request.emotion if one != "auto"]
        try:
            _, score, rate = prepared(
                performer, emotions, request.fps, request.seed, request.prosody, effort=request.effort or None
            )
        except InputError as problem:  # all else has been checked
            raise FieldError("emotion", str(problem)) from problem
        return replace(performer, prosody=HandMadeProsody(request.prosody)), score, rate

    def perform(self, request: TakeRequest, source: Source | None, job: Job, layer: EditLayer = EMPTY) -> Take:
        """Speak or hear a line, and perform it."""
        job.at("performer", 0.02)
        performer, score, rate = self._directed(request)
        job.at("listening" if source is not None else "voice", 0.1)
        with listening(_telling(job)):
            spoken = self._speech(request, source, performer, score)
        if spoken.utterance.duration > self.limits.seconds:
            told = f"{spoken.utterance.duration:.0f} s of sound; the studio takes {self.limits.seconds:.0f} s"
            raise FieldError("text", f"the line makes {told}")
        if "auto" in request.emotion and source is not None:
            job.at("emotion", 0.5)
            score, note = score_with_voice(score, source.sound)
            performer.expression.check(score)
            spoken = replace(spoken, utterance=spoken.utterance.with_notes(note))
        if source is not None:
            score, spoken = with_heard_effort(score, spoken, is_auto(request.effort))
        job.at("motion", 0.6)
        if request.times is not None:
            spoken = replace(spoken, utterance=as_corrected(spoken.utterance, request.times))
        spoken, asked = directed(spoken, score)
        basis = Basis(request, source, spoken, asked, performer, rate)
        layer = layer.made_on(line_of(spoken.utterance).line, asked_emotions(asked))
        under = basis.under(layer)
        return Take(basis, under, with_edited_channels(under), layer)

    def performer(self, request: TakeRequest) -> Performer:
        """Who performs, with a mouth that remembers."""
        key = request.performer, request.speech_model
        with self._lock:
            if key not in self._performers:
                loaded = load_performer(*key)
                self._performers[key] = replace(loaded, mouth=RememberingMouth(loaded.mouth))
            return self._performers[key]

    def _speech(self, request: TakeRequest, source: Source | None, performer: Performer, score: Score) -> Spoken:
        """What is said and when: of the voice, or in the sound; as before, if it was asked for a short while ago."""
        sound = "" if source is None else source.digest
        asked = (request.text, request.voice, request.language, request.seed, request.song, sound, request.performer)
        felt = () if sound else (request.emotion, request.voice_emotion)  # a voice of ours goes with what is felt
        return self._remembered(repr((*asked, *felt)), lambda: self._spoken_now(request, source, performer, score))

    def _remembered(self, key: str, make: Callable[[], Spoken]) -> Spoken:
        """As `make` makes it, once: who asks for the same meanwhile waits for it."""
        with self._lock:
            lock = self._making.setdefault(key, RLock())
        try:
            with lock:
                if key not in self._spoken:
                    self._spoken.put(make(), name=key)
                return self._spoken.get(key)
        finally:
            with self._lock:
                self._making.pop(key, None)

    def _spoken_now(self, request: TakeRequest, source: Source | None, performer: Performer, score: Score) -> Spoken:
        text = checked_script(request.text, request.language, self.limits) if request.text.strip() else None
        if source is None:
            assert text is not None  # `TakeRequest` has seen to it
            return spoken_text(
                text,
                performer,
                voice=request.voice,
                language=request.language,
                seed=request.seed,
                score=score,
                voice_emotion=request.voice_emotion,
                synthesiser=self._voice,
            )
        return spoken_recording(
            source.sound,
            performer,
            text=text,
            language=request.language,
            song=request.song,
            notes=source.notes,
        )


def _telling(job: Job) -> Listener:
    """Says how far the voice, or who listens to a sound, has come."""

    def heard(what: str, done: int, total: int) -> None:
        job.at(f"{what} ({done} of {total})", 0.1 + 0.5 * done / max(total, 1))

    return heard
