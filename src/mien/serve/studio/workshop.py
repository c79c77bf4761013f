"""`Workshop`: everything the studio holds and does, without a word of HTTP.

Models are loaded once, when first needed. What was spoken is kept for a while, so that a line in another emotion need
not be spoken again. All work here runs in the threads of the `JobPool`.
"""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from threading import RLock
from typing import Any

import numpy as np

from mien.animation.animation import Animation
from mien.animation.edits import EMPTY, EditLayer, line_of
from mien.animation.edits.edited_emotions import asked_emotions
from mien.core.audio import Audio
from mien.core.errors import InputError, Note
from mien.face.deformers import with_tree
from mien.face.library import load_face
from mien.motion.alive.visual_prosody import HandMadeProsody
from mien.motion.performer import Performer
from mien.motion.performers import load_performer
from mien.pipeline.edited_performance import with_edited_channels
from mien.pipeline.inputs import spoken_recording, spoken_text
from mien.pipeline.options import prepared, score_with_voice, with_heard_effort
from mien.pipeline.performance import directed
from mien.pipeline.spoken import Spoken
from mien.serve.studio.jobs import Job, JobPool
from mien.serve.studio.lru_store import Kept
from mien.serve.studio.page_memory import RememberingMouth, RememberingVoice
from mien.serve.studio.requests import FieldError, TakeRequest
from mien.serve.studio.results import Export, ResultShelf
from mien.serve.studio.rigs import RigShelf
from mien.serve.studio.settings import Limits
from mien.serve.studio.studio_faces import DEFAULT_FACE, FaceShelf
from mien.serve.studio.studio_lines import checked_script
from mien.serve.studio.studio_takes import Basis, Source, Take, plain_notes
from mien.serve.studio.views import Shown
from mien.text.score import Score

__all__ = ["Workshop"]

_SPOKEN_KEPT = 8


class Workshop:
    """Takes, faces, results and jobs of one running studio.

    Parameters
    ----------
    limits : Limits
    """

    def __init__(self, limits: Limits) -> None:
        self.limits = limits
        self.folder = Path(tempfile.mkdtemp(prefix="mien-studio-"))
        self.jobs = JobPool(limits)
        self.takes: Kept[Take] = Kept("take", limits.takes, limits.kept_bytes)
        self.faces = FaceShelf(self.folder, limits)
        self.results = ResultShelf(self.folder, limits)
        self.rigs = RigShelf(limits)
        self._performers: dict[tuple[str, str | None], Performer] = {}
        self._spoken: Kept[Spoken] = Kept("speech", _SPOKEN_KEPT)
        self._voice = RememberingVoice()
        self._lock = RLock()

    def close(self) -> bool:
        """Stop all jobs and remove everything from the disk; whether every job has ended (`JobPool.close`)."""
        ended = self.jobs.close()
        shutil.rmtree(self.folder, ignore_errors=True)
        return ended

    def warm_up(self, job: Job) -> dict[str, Any]:
        """Load what the first line needs: the face, the performer, the voice."""
        self.faces.default_glb()
        job.at("voice", 0.5)
        self.perform(TakeRequest.of({"text": "Hello."}, self.limits), None, job)
        return {}

    # ------------------------------------------------------------ takes

    def start_take(self, request: TakeRequest, sound: Audio | None = None, notes: tuple[Note, ...] = ()) -> str:
        """Queue a new take; returns the job's id. ``notes`` are what is known of the sound."""
        source = None if sound is None else Source(sound, notes)
        return self.jobs.start(lambda job: {"take": self._kept(self.perform(request, source, job))})

    def start_redo(self, name: str, changes: dict[str, Any]) -> str:
        """Queue a take like another with some fields of the request changed."""
        take = self.takes.get(name)
        source = take.basis.source
        request = take.basis.request.changed(changes, self.limits, with_sound=source is not None)
        layer = take.layer
        return self.jobs.start(lambda job: {"take": self._kept(self.perform(request, source, job, layer))})

    def start_export(self, name: str, formats: Sequence[str], shown: Shown) -> str:
        """Queue the writing of files."""
        animation = self.takes.get(name).animation
        foreign = self.faces.to_write(shown.face)
        if shown.rig is not None and (foreign is not None or not isinstance(shown.rig, str)):
            raise FieldError("rig", "a rig moves the default face: leave 'face' out")
        rig = None if shown.rig is None else self.rigs.known(str(shown.rig))

        def work(job: Job) -> dict[str, Any]:
            job.at("face")
            own = load_face(DEFAULT_FACE) if rig is None else with_tree(self.rigs.face, self.rigs.get(rig).tree)
            export = Export(own if foreign is None else foreign, shown, formats)
            made, called, notes = self.results.export(animation, export, job)
            return {"file": f"/api/files/{made}/{called}", "notes": plain_notes(notes)}

        return self.jobs.start(work)

    def _kept(self, take: Take) -> str:
        return self.takes.put(take, take.size)

    def perform(self, request: TakeRequest, source: Source | None, job: Job, layer: EditLayer = EMPTY) -> Take:
        """Speak or hear a line, and perform it."""
        job.at("performer", 0.02)
        performer = self._performer(request)
        emotions = [one for one in request.emotion if one != "auto"]
        try:
            _, score, rate = prepared(
                performer, emotions, request.fps, request.seed, request.prosody, effort=request.effort
            )
        except InputError as problem:  # all else has been checked
            raise FieldError("emotion", str(problem)) from problem
        performer = replace(performer, prosody=HandMadeProsody(request.prosody))
        job.at("listening" if source is not None else "voice", 0.1)
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
            score, spoken = with_heard_effort(score, spoken)
        job.at("motion", 0.6)
        spoken, asked = directed(spoken, score)
        basis = Basis(request, source, spoken, asked, performer, rate)
        layer = layer.made_on(line_of(spoken.utterance).line, asked_emotions(asked))
        under = basis.under(layer)
        return Take(basis, under, with_edited_channels(under), layer)

    def edit(self, name: str, layer: EditLayer) -> tuple[int, tuple[int, int] | None]:
        """Put another layer on a take; only what the difference asks for is performed again.

        Returns
        -------
        revision : int
        changed : tuple of int, or None
            The first and the last frame that differ from before.
        """
        take = self.takes.get(name)
        layer = layer.made_on(line_of(take.basis.spoken.utterance).line, asked_emotions(take.basis.score))
        with take.changing:
            same = _under(layer) == _under(take.layer)
            under = take.basis.with_layer(take.under, layer) if same else take.basis.under(layer)
            animation = with_edited_channels(under)
            changed = _changed(take.animation, animation)
            with take.lock:
                take.under, take.animation, take.layer = under, animation, layer
                take.revision += 1
                return take.revision, changed

    def _performer(self, request: TakeRequest) -> Performer:
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
        if key in self._spoken:
            return self._spoken.get(key)
        made = make()
        self._spoken.put(made, name=key)
        return made

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


def _under(layer: EditLayer) -> tuple[object, ...]:
    """What of a layer the performer has to be asked for."""
    borders, intensities = (tuple(edit for _, edit in some) for some in (layer.borders, layer.intensities))
    return borders, intensities, *((layer.line, layer.emotions) if borders or intensities else ())


def _changed(before: Animation, after: Animation) -> tuple[int, int] | None:
    differ = np.flatnonzero((before.channels.values != after.channels.values).any(axis=1))
    return (int(differ[0]), int(differ[-1])) if len(differ) else None
