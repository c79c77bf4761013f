"""``mien record``: a guided session, from a microphone and a camera or from prepared files."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

if TYPE_CHECKING:
    from mien.corpus.recording.scripts import Line
    from mien.corpus.recording.session import Plan, SessionReport
    from mien.corpus.recording.sources import Source

__all__ = ["Terminal", "add_record_command"]


def add_record_command(commands: Any) -> None:
    """Add the command to the parser of ``mien``."""
    command = commands.add_parser(
        "record",
        help="record a script, sentence by sentence, for learning",
        description="Shows each sentence, counts down, records sound and camera, checks the level. If you stop "
        "it, the same command continues. The folder is for 'mien corpus import'.",
    )
    command.add_argument("-o", "--output", metavar="SESSION", help="folder of the recordings")
    command.add_argument("--from", dest="prepared", metavar="FOLDER", help="use 001.mp4, 002.mp4... instead of devices")
    command.add_argument("--language", default="en", metavar="en|fi", help="language of the script (default en)")
    command.add_argument("--script", metavar="FILE", help="your own script instead: one sentence a line")
    command.add_argument("--emotion", default="neutral", metavar="NAME", help="emotion to say it in (default neutral)")
    command.add_argument("--speaker", metavar="NAME", default="me", help="name of the speaker (default me)")
    command.add_argument("--camera", metavar="DEVICE", help="such as /dev/video1 (default: the first one)")
    command.add_argument("--no-camera", action="store_true", help="record the sound only")
    command.add_argument("--list", action="store_true", help="print the script and do nothing else")
    command.add_argument("--quiet", action="store_true", help="print only errors and what the session needs")
    command.set_defaults(run=_record)


class Terminal:
    """Talks to the speaker through standard input and output; a line from a pipe counts as a key.

    Parameters
    ----------
    keys, screen : text streams
    """

    def __init__(self, keys: TextIO, screen: TextIO) -> None:
        self._keys, self._screen = keys, screen

    def show(self, message: str) -> None:
        """Print one line."""
        print(message, file=self._screen, flush=True)

    def key(self, prompt: str, known: str) -> str:
        """Ask until one of the known keys comes, each with Enter; at the end of the input it is ``q``."""
        while True:
            print(f"  {prompt} ", end="", file=self._screen, flush=True)
            line = self._keys.readline()
            if not line:
                return "q"
            pressed = line.strip().lower()[:1] or "\n"
            if pressed in known:
                return pressed


def _record(options: argparse.Namespace) -> int:
    from mien.core.errors import InputError
    from mien.corpus.recording.folder import SessionFolder
    from mien.corpus.recording.scripts import LANGUAGES, read_script
    from mien.corpus.recording.session import Plan, Session

    lines = read_script(options.language, options.script)
    if options.list:
        _print_script(lines)
        return 0
    if options.output is None:
        raise InputError("mien record needs -o SESSION, the folder of the recordings (or --list)")
    script = _plain(Path(options.script).stem) if options.script else LANGUAGES[options.language]
    plan = Plan(lines, script, options.speaker, options.emotion.lower())
    source = _source(options)
    report = Session(plan, SessionFolder(options.output), source, Terminal(sys.stdin, sys.stdout)).run()
    _tell(report, plan, options)
    return 2 if report.failed and not (report.recorded or report.kept) else 0


def _plain(stem: str) -> str:
    return "".join(char if char.isalnum() else "_" for char in stem)


def _print_script(lines: list[Line]) -> None:
    for line in lines:
        print(f"{line.label}  {line.text}")


def _source(options: argparse.Namespace) -> Source:
    from mien.core.errors import InputError
    from mien.corpus.recording.sources import PreparedFolder

    if options.no_camera and options.camera:
        raise InputError("--camera and --no-camera contradict each other; give one")
    if options.prepared is None:
        from mien.corpus.recording.devices import open_devices

        devices, notes = open_devices(options.camera, not options.no_camera)
        for note in notes:
            print(f"mien: {note.kind}: {note.message}", file=sys.stderr)
        return devices
    if options.camera or options.no_camera:
        raise InputError("--from takes prepared files; --camera and --no-camera are for recording")
    if Path(options.prepared).resolve() == Path(options.output).resolve():
        raise InputError(f"--from and -o are the same folder {options.output}; give another for the session")
    return PreparedFolder(options.prepared)


def _tell(report: SessionReport, plan: Plan, options: argparse.Namespace) -> None:
    for line, reason in report.failed:
        print(f"mien: not taken: sentence {line.number}: {reason}", file=sys.stderr)
    if options.quiet:
        return
    for note in report.notes:
        print(f"mien: {note.kind}: {note.message}", file=sys.stderr)
    if report.without_motion:
        print(
            "mien: warning: sound alone moves no face: put a video or markers of the same name beside", file=sys.stderr
        )
    there = f", {len(report.kept)} were there" if report.kept else ""
    missing = len(plan.lines) - len(report.recorded) - len(report.kept)
    left = f", {missing} to go" if missing else ""
    print(f"{options.output}: {len(report.recorded)} sentences{there}{left}")
    if not missing:
        print(f"next: mien corpus import {options.output} -o CORPUS")
