"""`Session`: a script read aloud, sentence by sentence; stopped at any point it goes on where it was.

Who speaks is led through it by a `Console` (a terminal, a test); takes come from a `Source` (devices, prepared files).

::

    each sentence that is not there yet
      shown ── Enter ──► 3-2-1, recorded until a key ──► checked ── Enter ──► kept
        │ s: next            ▲                              │ r: again, s: next without it
        └ q: end             └──────────────────────────────┘ q: end without it
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

from mien.core.errors import InputError, Note
from mien.corpus.readers.recording_files import VIDEO
from mien.corpus.recording.folder import SessionFolder, plain_name
from mien.corpus.recording.levels import level_notes, measure_levels
from mien.corpus.recording.scripts import Line
from mien.corpus.recording.sources import MOTION, Source, sound_of

__all__ = ["Console", "Plan", "Session", "SessionReport"]

COUNTDOWN = 3  # seconds


class Console(Protocol):
    """How a session talks to the speaker."""

    def show(self, message: str) -> None:
        """Say one line."""
        ...

    def key(self, prompt: str, known: str) -> str:
        r"""Wait for one of the keys in ``known`` (Enter is ``"\n"``); ``"q"`` where no more keys will come."""
        ...


@dataclass(frozen=True)
class Plan:
    """What is to be recorded.

    Attributes
    ----------
    lines : sequence of Line
    script : str
        Name of the script; with the number of the sentence it links the takes that say the same.
    speaker, emotion : str
    """

    lines: Sequence[Line]
    script: str
    speaker: str
    emotion: str = "neutral"

    def __post_init__(self) -> None:
        for what in ("script", "speaker", "emotion"):
            plain_name(what, getattr(self, what))

    def sentence(self, line: Line) -> str:
        """What links takes of the same sentence."""
        return f"{self.script}-{line.label}"

    def name(self, line: Line) -> str:
        """Of the take of a sentence.

        Examples
        --------
        >>> Plan([], "english", "anna", "happy").name(Line(7, "Hello."))
        'anna-happy-english-007'
        """
        return f"{self.speaker}-{self.emotion}-{self.sentence(line)}"

    def facts(self, line: Line) -> dict[str, str]:
        """The line of the table."""
        return {
            "text": line.text,
            "emotion": self.emotion,
            "sentence": self.sentence(line),
            "speaker": self.speaker,
        }


@dataclass
class SessionReport:
    """What a session did.

    Attributes
    ----------
    recorded, kept : list of str
        Takes made now, and those that were there.
    skipped : list of Line
        Sentences passed over by the speaker, or not reached.
    failed : list of (Line, str)
        Sentences whose prepared recording cannot be used, and why.
    without_motion : bool
        Whether a take made now is sound alone, which an import cannot use by itself.
    notes : list of Note
    """

    recorded: list[str] = field(default_factory=list)
    kept: list[str] = field(default_factory=list)
    skipped: list[Line] = field(default_factory=list)
    failed: list[tuple[Line, str]] = field(default_factory=list)
    without_motion: bool = False
    notes: list[Note] = field(default_factory=list)


class Session:
    """A guided recording.

    Parameters
    ----------
    plan : Plan
    folder : SessionFolder
    source : Source
    console : Console
    pause : callable
        Waits for so many seconds; tests wait for none.
    """

    def __init__(
        self,
        plan: Plan,
        folder: SessionFolder,
        source: Source,
        console: Console,
        pause: Callable[[float], None] = time.sleep,
    ) -> None:
        self._plan, self._folder, self._source = plan, folder, source
        self._console, self._pause = console, pause
        self._report = SessionReport()

    def run(self) -> SessionReport:
        """Go through the sentences that are not there yet.

        Raises
        ------
        InputError
            If the folder holds takes of another script under the same names.
        OutputError
            If a take cannot be written; those before it are safe.
        """
        report = self._report
        waiting = [line for line in self._plan.lines if not self._folder.has(self._plan.name(line), line.text)]
        report.kept = [self._plan.name(line) for line in self._plan.lines if line not in waiting]
        for place, line in enumerate(waiting):
            goes_on = self._speak(line) if self._source.live else self._copy(line)
            if not goes_on:
                report.skipped += waiting[place + 1 :]
                break
        return report

    def _speak(self, line: Line) -> bool:
        """One sentence of a live session; False to end it."""
        self._console.show(f"{line.number}/{self._plan.lines[-1].number} [{self._plan.emotion}]  {line.text}")
        choice = self._console.key("Enter: record   s: skip   q: quit", "\nsq")
        while choice in "\nr":
            with self._folder.scratch() as scratch:
                for left in range(COUNTDOWN, 0, -1):
                    self._console.show(f"{left}...")
                    self._pause(1.0)
                files = self._source.take(line, self._plan.name(line), scratch, self._until_done)
                notes = self._judged(files)
                for note in notes:
                    self._console.show(f"{note.kind}: {note.message}")
                choice = self._console.key("Enter: keep   r: record again   s: skip   q: quit without it", "\nrsq")
                if choice == "\n":
                    self._keep(line, files, notes)
                    return True
        self._report.skipped.append(line)
        return choice != "q"

    def _until_done(self) -> None:
        self._console.key("recording... Enter when you have finished", "\nq")

    def _copy(self, line: Line) -> bool:
        """One sentence from prepared files; one that cannot be used never stops the others."""
        with self._folder.scratch() as scratch:
            try:
                files = self._source.take(line, self._plan.name(line), scratch, lambda: None)
                notes = self._judged(files)
            except InputError as problem:
                self._report.failed.append((line, " ".join(str(problem).split())))
                return True
            self._keep(line, files, notes)
        return True

    def _judged(self, files: list[Path]) -> tuple[Note, ...]:
        return level_notes(measure_levels(sound_of(files)))

    def _keep(self, line: Line, files: list[Path], notes: Sequence[Note]) -> None:
        name = self._plan.name(line)
        self._folder.keep(name, self._plan.facts(line), files)
        self._report.recorded.append(name)
        self._report.notes += [Note(note.kind, f"{name}: {note.message}") for note in notes]
        if not any(path.suffix.lower() in (*VIDEO, *MOTION) for path in files):
            self._report.without_motion = True
