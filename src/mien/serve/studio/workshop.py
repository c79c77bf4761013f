"""`Workshop`: everything the studio holds and does, without a word of HTTP.

Lines are spoken and performed by `mien.serve.studio.performing`. All work here runs in the threads of the `JobPool`.
"""

from __future__ import annotations

import contextlib
import shutil
import tempfile
import time
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
from mien.core.errors import Note
from mien.core.timeline import Tier
from mien.face.deformers import with_tree
from mien.face.library import load_face
from mien.face.model import Face
from mien.pipeline.edited_performance import with_edited_channels
from mien.serve.studio.expressions import expressions_of
from mien.serve.studio.given_speech import times_of_tiers
from mien.serve.studio.jobs import Job, JobPool
from mien.serve.studio.journal import Journal, Record, Step, folder_to_keep, sweep
from mien.serve.studio.lru_store import Kept
from mien.serve.studio.performing import Performing
from mien.serve.studio.requests import FieldError, TakeRequest, checked_layer
from mien.serve.studio.results import Export, ResultShelf
from mien.serve.studio.rigs import RigShelf
from mien.serve.studio.settings import Limits
from mien.serve.studio.studio_faces import DEFAULT_FACE, FaceShelf
from mien.serve.studio.studio_lines import beginnings_of, named
from mien.serve.studio.studio_takes import Source, Take, plain_notes
from mien.serve.studio.views import Shown

__all__ = ["Changed", "Workshop"]

_PREFIX = "mien-studio-"
_FIRST_LINE = "Hello, mienlings!"
"""A word that no dictionary has, so that what guesses at such words is loaded too."""


class Changed(Exception):  # noqa: N818 - not a fault of ours: two pages work on one take
    """A take has other steps than the page thinks."""


class Workshop:
    """Takes, faces, results and jobs of one running studio.

    Parameters
    ----------
    limits : Limits
    keep : str, Path or None
        The folder that takes are kept in; None: where this system keeps a user's data.
    keeps : bool
        False: nothing is kept beyond the end of the studio.

    Attributes
    ----------
    told : str
        Where takes are kept, in one line.
    """

    def __init__(self, limits: Limits, keep: str | Path | None = None, keeps: bool = True) -> None:
        self.limits = limits
        self.folder = Path(tempfile.mkdtemp(prefix=_PREFIX))
        self._held = contextlib.ExitStack()
        self._held.enter_context(folder_to_keep(self.folder, self.folder))  # so that nobody sweeps it away
        sweep(_PREFIX, self.folder.parent)
        kept, self.told = self.folder, "takes are not kept"
        if keeps:
            try:
                kept, self.told = self._held.enter_context(folder_to_keep(keep, self.folder))
            except BaseException:
                shutil.rmtree(self.folder, ignore_errors=True)
                raise
        self.journal = Journal(kept, limits)
        self.jobs = JobPool(limits)
        self.takes: Kept[Take] = Kept("take", limits.takes, limits.kept_bytes)
        self.faces = FaceShelf(kept / "faces", limits)
        self.results = ResultShelf(self.folder, limits)
        self.rigs = RigShelf(limits, self.faces)
        self._expressions: dict[str, dict[str, Any]] = {}
        self.performing = Performing(limits, kept / "speech")
        self.perform = self.performing.perform
        self._ahead: tuple[TakeRequest, Job] | None = None
        self._trying, self._trial = Job(), ""
        self._waking = RLock()

    def close(self) -> bool:
        """Stop all jobs and remove everything from the disk; whether every job has ended (`JobPool.close`)."""
        ended = self.jobs.close()
        self._held.close()
        shutil.rmtree(self.folder, ignore_errors=True)
        return ended

    def warm_up(self, job: Job) -> dict[str, Any]:
        """Load what the first line needs: the face, the performer, the voice."""
        self.faces.own_glb(DEFAULT_FACE)
        job.at("voice", 0.5)
        self.perform(TakeRequest.of({"text": _FIRST_LINE, "emotion": "happy"}, self.limits), None, job)
        return {}

    # ------------------------------------------------------------ takes

    def take(self, name: str) -> Take:
        """The take of an id, performed again if only the journal has it; raises `Missing`."""
        return self.takes.get(name) if name in self.takes else self._woken(name, Job())

    def _woken(self, name: str, job: Job) -> Take:
        record = self.journal.get(name)
        step = record.step
        with self._waking:
            if name in self.takes:
                return self.takes.get(name)
            take = self.perform(step.request, self.journal.sound(step.sound), job, step.layer)
            if self.journal.get(name).step != step:  # it was changed meanwhile
                raise Changed("the take was changed meanwhile: open it again")
            self.takes.put(take, take.size, name)
            return take

    def start_open(self, name: str) -> str:
        """Queue what brings a take back that only the journal has."""
        self.journal.get(name)

        def work(job: Job) -> dict[str, Any]:
            if name not in self.takes:
                self._woken(name, job)
            return {"take": name}

        return self.jobs.start(work)

    def start_times(self, name: str, tiers: Sequence[Tier]) -> str:
        """Queue a take's performance with the words and phones of a TextGrid: its next step."""
        basis = self.take(name).basis
        utterance = basis.spoken.utterance
        return self.start_redo(name, {"times": times_of_tiers(utterance, tiers, basis.request.language)})

    def ahead(self, request: TakeRequest) -> None:
        """Speak and perform what is being written (of a long text its beginning), unless something else is being made.

        What is said and how the mouth moves is remembered, so that the line is there soon once it is asked for.
        """
        if self._ahead is not None:
            if self._ahead[0] == request:
                return
            self._ahead[1].cancel()
        if self.jobs.open > 1:
            return

        def work(job: Job) -> dict[str, Any]:
            for text in (*beginnings_of(request.text)[:2], request.text)[:2]:
                self.perform(replace(request, text=text), None, job)
            return {}

        self._ahead = request, self.jobs.get(self.jobs.start(work))

    def start_take(self, request: TakeRequest, sound: Audio | None = None, notes: tuple[Note, ...] = ()) -> str:
        """Queue a new take; returns the job's id. ``notes`` are what is known of the sound."""
        source = None if sound is None else Source(sound, notes)

        def work(job: Job) -> dict[str, Any]:
            take = self.performing.by_and_by(request, source, job, EMPTY, self._beginning)
            digest = None if source is None else self.journal.keep_sound(source)
            record = Record(
                named(take, {one.name for one in self.journal.records.values()}),
                time.time(),
                [Step(request, EMPTY, digest)],
            )
            job.at(job.step)
            name = self.journal.add(record)
            self.takes.put(take, take.size, name)
            return {"take": name}

        return self.jobs.start(work)

    def start_redo(
        self, name: str, changes: dict[str, Any], sound: tuple[Audio, tuple[Note, ...]] | None = None
    ) -> str:
        """Queue a take's performance with some fields of its request changed, or with another sound: its next step.

        Parameters
        ----------
        changes : dict
            Fields; ``layer`` is another layer of edits, ``sound`` None takes the recording away.
        """
        record = self.journal.get(name)
        changes = dict(changes)
        layer = changes.pop("layer", None)
        digest = record.step.sound if changes.pop("sound", True) is not None else None
        with_sound = sound is not None or digest is not None
        request = record.step.request.changed(changes, self.limits, with_sound=with_sound)

        def work(job: Job) -> dict[str, Any]:
            source = self.journal.sound(digest) if sound is None else Source(*sound)
            kept = None if source is None else self.journal.keep_sound(source)
            edits = record.step.layer if layer is None else checked_layer(layer, self.limits)
            take = self.performing.by_and_by(request, source, job, edits, self._beginning)
            job.at(job.step)
            at = self.journal.get(name).at
            self.journal.change(name, at + 1, [Step(request, take.layer, kept)], at + 1)
            self._put(name, take)
            return {"take": name}

        return self.jobs.start(work)

    def start_trial(self, name: str, changes: dict[str, Any]) -> str:
        """Queue a take's performance with some fields of its request changed, to be heard and seen only.

        Nothing is kept: the job's take is there until that of the next trial is; one that is not done yet gives way.
        """
        record = self.journal.get(name)
        changes = dict(changes)
        layer = changes.pop("layer", None)
        edits = record.step.layer if layer is None else checked_layer(layer, self.limits)
        request = record.step.request.changed(changes, self.limits, with_sound=record.step.sound is not None)

        def work(job: Job) -> dict[str, Any]:
            made = self.perform(request, self.journal.sound(record.step.sound), job, edits)
            job.at(job.step)
            self.takes.drop(self._trial)
            self._trial = self.takes.put(made, made.size)
            return {"take": self._trial}

        self._trying.cancel()
        started = self.jobs.start(work)
        self._trying = self.jobs.get(started)
        return started

    def _put(self, name: str, take: Take) -> None:
        """A take in the place of the one that had its id."""
        if name in self.takes:
            take.revision = self.takes.get(name).revision + 1
        self.takes.put(take, take.size, name)

    def _beginning(self, take: Take) -> str:
        return self.takes.put(take, take.size)

    def steps(self, name: str, keep: int, add: Sequence[EditLayer], at: int, count: int) -> dict[str, Any]:
        """Change a take's steps: edits, undo, redo. Gives what the page must know, or the job that performs it.

        Parameters
        ----------
        keep : int
            So many of the first steps stay.
        add : sequence of EditLayer
            Then come these.
        at : int
            This one is shown.
        count : int
            How many steps there were, as the page thinks.

        Raises
        ------
        Changed
            If there are others.
        """
        record = self.journal.get(name)
        if count != len(record.steps):
            raise Changed("this take was changed in another window: it is read again")
        if not 0 < keep <= count:
            raise FieldError("steps", f"the take has {count} steps: cannot keep {keep}")
        base = record.steps[keep - 1]
        if base.same_speech(record.step):
            made = self._made(self.take(name))
            add = [made(layer) for layer in add]
        added = [replace(base, layer=layer) for layer in add]
        step = record.changed(keep, added, at).step
        if step.same_speech(record.step):
            revision, changed = self._laid(name, step.layer, lambda: self.journal.change(name, keep, added, at))
            return {"revision": revision, "frames_changed": changed, "take": self.plain(name)}

        def work(job: Job) -> dict[str, Any]:
            take = self.perform(step.request, self.journal.sound(step.sound), job, step.layer)
            job.at(job.step)
            self.journal.change(name, keep, added, at)
            self._put(name, take)
            return {"take": name}

        return {"job": self.jobs.start(work)}

    def plain(self, name: str) -> dict[str, Any]:
        """A take as JSON, with what the journal knows of it."""
        told = self.take(name).plain(name)
        if name not in self.journal.records:  # the beginning of a longer one
            return told
        record = self.journal.get(name)
        return told | {"name": record.name, "made": record.made, "at": record.at, "count": len(record.steps)}

    def listed(self) -> list[dict[str, Any]]:
        """All takes, the newest first."""
        records = sorted(self.journal.records.items(), key=lambda item: -item[1].made)
        return [
            {"take": name, "name": record.name, "made": record.made, "text": record.step.request.text[:200],
             "emotion": list(record.step.request.emotion), "from_sound": record.step.sound is not None,
             "edits": len(record.step.layer.edits), "steps": len(record.steps)}
            for name, record in records
        ]  # fmt: skip

    def copy(self, name: str) -> str:
        """Another take like one; gives its id."""
        record = self.journal.get(name)
        made = self.journal.add(replace(record, name=f"{record.name} (copy)", made=time.time()))
        if name in self.takes:
            take = self.takes.get(name)
            self.takes.put(Take(take.basis, take.under, take.animation, take.layer), take.size, made)
        return made

    def with_sound(self, record: Record, source: Source) -> Record:
        """A record whose recorded steps have a sound that came back from a page."""
        digest = self.journal.keep_sound(source)
        steps = [step if step.sound is None else replace(step, sound=digest) for step in record.steps]
        return replace(record, steps=steps)

    def drop(self, name: str) -> None:
        """Delete a take."""
        self.journal.drop(name)
        self.takes.drop(name)

    def start_export(self, name: str, formats: Sequence[str], shown: Shown) -> str:
        """Queue the writing of files."""
        animation = self.take(name).animation
        foreign = self.faces.to_write(shown.face)
        rig = None if shown.rig is None else str(shown.rig)
        if rig is not None and self.rigs.face_of(rig) != (shown.face or self.rigs.face_of(rig)):
            raise FieldError("rig", "this rig moves another face: leave 'face' out")

        def work(job: Job) -> dict[str, Any]:
            job.at("face")
            own: Face | Path = foreign or load_face(str(shown.face or DEFAULT_FACE))
            if rig is not None:
                own = with_tree(self.rigs.face(self.rigs.face_of(rig)), self.rigs.get(rig).tree)
            export = Export(own, shown, formats)
            made, called, notes = self.results.export(animation, export, job)
            return {"file": f"/api/files/{made}/{called}", "notes": plain_notes(notes)}

        return self.jobs.start(work)

    def edit(self, name: str, layer: EditLayer) -> tuple[int, tuple[int, int] | None]:
        """Put another layer on a take, as its next step; only what the difference asks for is performed again.

        Returns
        -------
        revision : int
        changed : tuple of int, or None
            The first and the last frame that differ from before.
        """
        record, layer = self.journal.get(name), self._made(self.take(name))(layer)
        step, at = replace(record.step, layer=layer), record.at + 1
        return self._laid(name, layer, lambda: self.journal.change(name, at, [step], at))

    @staticmethod
    def _made(take: Take) -> Callable[[EditLayer], EditLayer]:
        """Layers that say on which line they were made, so that they are laid on another one rightly."""
        line, emotions = line_of(take.basis.spoken.utterance).line, asked_emotions(take.basis.score)
        return lambda layer: layer.made_on(line, emotions)

    def _laid(self, name: str, layer: EditLayer, keep: Callable[[], object]) -> tuple[int, tuple[int, int] | None]:
        take = self.take(name)
        with take.changing:
            same = _under(layer) == _under(take.layer)
            under = take.basis.with_layer(take.under, layer) if same else take.basis.under(layer)
            animation = with_edited_channels(under)
            changed = _changed(take.animation, animation)
            keep()
            with take.lock:
                take.under, take.animation, take.layer = under, animation, layer
                take.revision += 1
                return take.revision, changed

    def expressions(self, name: str) -> dict[str, Any]:
        """What every emotion of a performer does to the face of somebody who is silent, mean over two seconds."""
        request = TakeRequest.of({"performer": name}, self.limits, with_sound=True)
        with self._waking:
            if name not in self._expressions:
                self._expressions[name] = expressions_of(self.performing.performer(request))
            return self._expressions[name]


def _under(layer: EditLayer) -> tuple[object, ...]:
    """What of a layer the performer has to be asked for."""
    borders, intensities = (tuple(edit for _, edit in some) for some in (layer.borders, layer.intensities))
    return borders, intensities, *((layer.line, layer.emotions) if borders or intensities else ())


def _changed(before: Animation, after: Animation) -> tuple[int, int] | None:
    differ = np.flatnonzero((before.channels.values != after.channels.values).any(axis=1))
    return (int(differ[0]), int(differ[-1])) if len(differ) else None
