"""``mien``: reads the arguments, calls `mien.api`, tells what happened.

Exit codes: 0 done; 1 ``mien doctor`` or ``mien corpus check`` found a fault; 2 the input, an option or an output cannot
be used; 130 stopped.
"""

from __future__ import annotations

import argparse
import errno
import io
import os
import sys
from collections.abc import Iterable, Sequence
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from mien.cli import (
    completion_command,
    evaluate_command,
    express_command,
    face_commands,
    inspect_command,
    language_command,
    learn_command,
    list_commands,
    live_command,
    module_commands,
    recolor_command,
    score_command,
    serve_command,
    stimuli_command,
    studio_command,
    warm_up_command,
)
from mien.cli.corpus_commands import add_corpus_commands
from mien.cli.emotion_commands import add_emotion_commands
from mien.cli.foreign_face import ShownFace, add_face_option, add_glb_options, checked_foreign_face, glb_style
from mien.cli.help_page import HelpFormatter, examples_of, help_page, options_of, with_suggestion
from mien.cli.progress_bar import progress_bar, still_working, telling
from mien.cli.record_command import add_record_command
from mien.cli.stopping import put_off, stop_cleanly
from mien.cli.view_options import VIEW_OPTIONS, add_view_options, view_of
from mien.core.compiled import when_compiling
from mien.core.errors import InputError, MienError, Note
from mien.core.files import claimed_outputs, made_folders

if TYPE_CHECKING:
    from mien.animation.animation import Animation

__all__ = ["main"]


_OF_STREAMS = (errno.ENOSPC, errno.EBADF, errno.EIO, errno.EPIPE, errno.EFBIG)
_WAITING = ("live", "serve", "studio", "record", "interpret", "speak", "translate", "perform", "warm-up")
"""Commands that wait for somebody, or say themselves what they do."""
_WITHOUT_FRAMES = (".wav", ".textgrid")
_OF_FRAMES: dict[str, str | None] = {
    "fps": "30", "performer": "default", "speech_model": None, "prosody": "0.5", "alive": "all",
}  # fmt: skip
"""Options that change frames only, and their usual values."""
_OF_FACES: dict[str, str | None] = {"emotion": None, "effort": None}
"""Options that change frames, and a voice that is made for them."""


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        """Say it in one line, like every other error, with the nearest name that exists."""
        commands = self._commands()
        chosen = message.startswith("argument COMMAND")
        meant = self if chosen else commands.get(next((word for word in sys.argv[1:] if word in commands), ""), self)
        message = with_suggestion(message, commands, options_of(meant))
        self.exit(2, f"{self.prog}: error: {message}; see {meant.prog} --help\n")

    def format_help(self) -> str:
        """The commands by what they are for; the help of one command ends with examples."""
        if self.prog != "mien":
            self.epilog, self.formatter_class = examples_of(self.prog), HelpFormatter
            return super().format_help()
        shown = {choice.dest: choice.help or "" for choice in self._subparsers_of()._choices_actions}
        return help_page(self.description or "", shown)

    def _commands(self) -> dict[str, argparse.ArgumentParser]:
        return dict(self._subparsers_of().choices) if self._subparsers is not None else {}

    def _subparsers_of(self) -> Any:
        assert self._subparsers is not None
        return self._subparsers._group_actions[0]


class _Version(argparse.Action):
    """Looks the version up when it is asked for: loading what knows it takes longer than all else of ``--help``."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> NoReturn:
        from importlib.metadata import version

        print(f"mien {version('mien')}")
        parser.exit()


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; returns its exit code."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal that cannot show a name must not end the work
    options = _parser().parse_args(arguments)
    stop_cleanly()
    when_compiling(None if getattr(options, "quiet", False) else _tell_of_compiling)
    try:
        with claimed_outputs(), _at_work(options):
            code: int = options.run(options)
        sys.stdout.flush()
        _tell_of_folders(getattr(options, "quiet", False))
        _tell_of_lost_kernels(getattr(options, "quiet", False))
        return code
    except MienError as problem:
        print(f"mien: error: {_one_line(problem)}", file=sys.stderr)
        return 2
    except MemoryError:
        print("mien: error: not enough memory for this; give less at once, or more memory", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("mien: stopped; nothing half-written was left", file=sys.stderr)
        return 130
    except BrokenPipeError:
        sys.stderr.close()
        return 0
    except OSError as problem:
        if problem.filename is not None:  # a fault of ours: the rooms below name files in errors of their own
            raise
        sys.stdout = open(os.devnull, "w")  # noqa: SIM115, PTH123 - what is left in it cannot be written either
        about = "cannot write to standard output" if problem.errno in _OF_STREAMS else "the system refuses"
        print(f"mien: error: {about}: {problem.strerror or _one_line(problem)}", file=sys.stderr)
        return 2


def _at_work(options: argparse.Namespace) -> AbstractContextManager[None]:
    """A sign of life while a command works in silence; those that wait for somebody else have none."""
    silent = getattr(options, "quiet", False) or options.command_name in _WAITING
    return nullcontext() if silent else still_working(options.command_name)


def _tell_of_compiling() -> None:
    line = "mien: first use of some parts: compiling them, up to half a minute ('mien warm-up' compiles all at once)"
    print(line, file=sys.stderr, flush=True)


def _tell_of_folders(quiet: bool) -> None:
    told = [str(folder) for folder in dict.fromkeys(made_folders) if folder.is_dir()]
    made_folders.clear()
    if told and not quiet:
        print(f"mien: note: made for the output, as it was not there: {', '.join(told)}", file=sys.stderr)


def _tell_of_lost_kernels(quiet: bool) -> None:
    compiled = sys.modules.get("mien.core.compiled")
    if compiled is not None and "numba" in sys.modules and not compiled.kept() and not quiet:
        print(f"mien: note: {compiled.cache_note()}; set NUMBA_CACHE_DIR to a folder of yours", file=sys.stderr)


def _one_line(problem: BaseException) -> str:
    return " ".join(str(problem).split())


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(prog="mien", description="Speech or text in, an expressive 3D talking face out.")
    parser.add_argument("--version", action=_Version, nargs=0, help="show program's version number and exit")
    commands = parser.add_subparsers(
        title="commands", dest="command_name", required=True, metavar="COMMAND", parser_class=_Parser
    )

    _add_say(commands)
    _add_animate(commands)
    _add_align(commands)
    add_corpus_commands(commands)
    add_record_command(commands)
    learn_command.add_command(commands)
    evaluate_command.add_command(commands)
    score_command.add_command(commands)
    inspect_command.add_command(commands)
    face_commands.add_command(commands, _checked_face, _finish)
    express_command.add_command(commands, _checked_face, _finish)
    recolor_command.add_command(commands, _checked_face, _finish)
    add_emotion_commands(commands)
    serve_command.add_command(commands)
    live_command.add_command(commands)
    studio_command.add_command(commands)

    module_commands.add_commands(commands, _checked_face)
    stimuli_command.add_commands(commands)

    list_commands.add_commands(commands)
    language_command.add_command(commands)
    warm_up_command.add_command(commands)
    completion_command.add_command(commands, parser)
    doctor = commands.add_parser("doctor", help="what is installed, what is missing, and why it matters")
    doctor.set_defaults(run=_doctor)
    helping = commands.add_parser("help", help="show this page, or the help of a command")
    helping.add_argument("command", metavar="COMMAND", nargs="?")
    helping.set_defaults(
        run=lambda options: parser.parse_args([options.command, "--help"] if options.command else ["--help"])
    )
    return parser


def _add_say(commands: Any) -> None:
    say = commands.add_parser("say", help="speak a text and perform it")
    say.add_argument("text", metavar="TEXT", nargs="?", help="what to say; '-' reads it from standard input")
    say.add_argument("--script", metavar="FILE", help="what to say, from a file: .txt .xml .ssml .bml (docs/script.md)")
    say.add_argument("--voice", help="voice to speak with (mien voices): kokoro-heart, heart, female, male")
    say.add_argument(
        "--voice-emotion",
        metavar="off|0..1",
        default="1",
        help="how strongly the voice takes on the emotion (default 1; docs/emotion.md)",
    )
    say.add_argument("--rate", metavar="0.2..5|PER%", help="how fast to speak; 1 or 100%% is normal")
    say.add_argument("--pitch", metavar="SEMITONES", help="how much higher to speak, or lower if negative")
    _add_performance_options(say)
    say.set_defaults(run=_say)


def _add_animate(commands: Any) -> None:
    animate = commands.add_parser("animate", help="perform recorded speech")
    animate.add_argument("audio", metavar="AUDIO", help="a sound file, or a video with a sound track")
    animate.add_argument(
        "--text",
        metavar="FILE_OR_TEXT",
        help="what is said; a .TextGrid gives words and phones with their times; without it phones are recognised",
    )
    _add_tiers_option(animate)
    animate.add_argument("--script", metavar="FILE", help="what is said, with directions: .txt .xml .ssml .bml")
    animate.add_argument(
        "--song", action="store_true", help="treat it as a song whose lyrics are the text (docs/song.md)"
    )
    animate.add_argument("--voice", help=argparse.SUPPRESS)
    _add_performance_options(animate)
    animate.set_defaults(run=_animate)


def _add_align(commands: Any) -> None:
    align = commands.add_parser("align", help="find when each word and phone is spoken")
    align.add_argument("audio", metavar="AUDIO", help="a sound file, or a video with a sound track")
    align.add_argument("--text", metavar="FILE_OR_TEXT", required=True, help="what is said")
    align.add_argument(
        "-o",
        "--output",
        metavar="OUT",
        required=True,
        help="the file to write; its suffix picks the format: .TextGrid .json .csv .srt .vtt .lab .ctm",
    )
    _add_tiers_option(align)
    align.add_argument("--song", action="store_true", help="treat it as a song whose lyrics are the text")
    _add_language_option(align)
    align.add_argument("--quiet", action="store_true", help="print nothing but errors")
    align.set_defaults(run=_align)


def _add_performance_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "-o",
        "--output",
        metavar="OUT",
        required=True,
        help="file to write; its suffix picks the format: .mp4 .webm .mov .gif .png NAME%%05d.png .glb .fbx .usdz "
        ".usdc .usda .c3d .csv .fap .TextGrid .wav .json",
    )
    parser.add_argument("--also", metavar="OUT2", action="append", default=[], help="one more output (repeatable)")
    parser.add_argument("--fps", default="30", help="frames per second (default 30)")
    parser.add_argument("--seed", type=int, default=0, help="seed of blinks, glances and drift (default 0)")
    add_face_option(parser)
    add_glb_options(parser)
    add_view_options(parser)
    _add_performer_options(parser)
    _add_language_option(parser)
    parser.add_argument("--quiet", action="store_true", help="print nothing but errors")


def _add_performer_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--deformer",
        default="blendshapes",
        metavar="NAME|X.tree",
        help="what moves the face: blendshapes, tree, regions, or a parameter tree in a file",
    )
    parser.add_argument(
        "--performer",
        default="default",
        metavar="NAME|X.mien",
        help="who moves: default, mandarin, hand-made, or a .mien file",
    )
    parser.add_argument(
        "--speech-model",
        choices=("coarticulation", "graph", "both"),
        help="what moves the mouth, if the performer has it: learned curves, recorded motion, or both",
    )
    parser.add_argument(
        "--emotion",
        metavar="NAME[:0..1]",
        action="append",
        help="happy, sad, angry, surprised, afraid, disgusted, contempt, frustrated: sad:0.4 or sad:0.2@0,0.9@1.5 "
        "(value at second), sad:curve.csv, 'sad[0.5-1.2]:0.8' (from second to second); repeatable, "
        "docs/expression.md; "
        "for mien animate also auto: what the voice sounds like, docs/emotion.md",
    )
    parser.add_argument(
        "--effort",
        metavar="0..2|auto|off",
        help="how strongly words are articulated, 1 being as recorded: 1.4, 0.5@0,1.6@2 (value at second) or "
        "curve.csv; mien "
        "animate reads it from the voice (auto) unless it is given or off; docs/effort.md",
    )
    parser.add_argument(
        "--commands", metavar="FOLDER", action="append", default=[], help="folder with your own commands (repeatable)"
    )
    parser.add_argument("--edits", metavar="X.json", help="manual edits to apply to the performance (docs/edits.md)")
    parser.add_argument(
        "--prosody",
        metavar="off|0..1",
        default="0.5",
        help="how much brows and head follow the accents and phrase ends of the voice (default 0.5)",
    )
    parser.add_argument(
        "--alive",
        metavar="all|off|blinks,gaze,head,sway",
        default="all",
        help="which signs of life to add (default all); blinks=8, or all,blinks=8: that many a minute",
    )


def _add_tiers_option(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--tiers", metavar="WORDS,PHONES", default="", help="names of the tiers of a TextGrid (default: words,phones)"
    )


def _tiers(options: argparse.Namespace) -> tuple[str, ...]:
    return tuple(name.strip() for name in options.tiers.split(",") if name.strip())


def _add_language_option(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--language",
        metavar="TAG|X.toml",
        help="what language is spoken: a tag from 'mien languages', or a table of your own (default: English)",
    )


def _say(options: argparse.Namespace) -> int:
    from mien.api import calls as api
    from mien.pipeline.text_inputs import text_or_file

    face = _checked_face(options, [options.script, options.text, options.edits])
    if (options.text is None) == (options.script is None):
        raise InputError("expected a text to say, or a file with --script, and not both")
    text = sys.stdin.read() if options.text == "-" else text_or_file(options.text or "")
    if options.script is not None:
        text = Path(options.script)
    with telling(options.quiet):
        animation = api.say(
            text,
            voice=options.voice,
            voice_emotion=options.voice_emotion,
            rate=options.rate,
            pitch=options.pitch,
            **_asked(options),
        )
    return _finish(animation, face, options)


def _animate(options: argparse.Namespace) -> int:
    from mien.api import calls as api

    if options.voice is not None:
        raise InputError("--voice is for 'mien say'; 'mien animate' keeps the voice that is in the sound")
    face = _checked_face(options, [options.script, options.audio, options.text, options.edits])
    if options.text is not None and options.script is not None:
        raise InputError("--text and --script both say what is spoken: give one of them")
    text = Path(options.script) if options.script is not None else options.text
    with telling(options.quiet):
        animation = api.animate(options.audio, text=text, song=options.song, tiers=_tiers(options), **_asked(options))
    return _finish(animation, face, options)


def _asked(options: argparse.Namespace) -> dict[str, Any]:
    """What say and animate share."""
    names = ("language", "emotion", "effort", "fps", "seed", "performer", "speech_model", "prosody", "alive")
    return {name: getattr(options, name) for name in (*names, "commands", "edits")}


def _checked_face(options: argparse.Namespace, inputs: Sequence[str | None]) -> ShownFace:
    """The face to show; an output or a face that cannot be had is refused before any work is done."""
    from mien.face.library import is_named_face, load_face
    from mien.formats.registry import check_output

    view = view_of(options)
    outputs = [check_output(path, view) for path in (options.output, *options.also)]
    glb_style(options)
    foreign = not is_named_face(options.face) and _is_foreign(options.face)
    _refuse_same_file(outputs, [*inputs, *([options.face, options.names] if foreign else [])])
    arms = getattr(options, "arms", "lower")  # only what performs on avatars asks
    if foreign:
        return checked_foreign_face(options.face, outputs, options.deformer, options.names, arms)
    if arms == "keep":
        raise InputError(f"--arms is for a face in .glb, .vrm or .gltf, not for {options.face!r}")
    if options.names is not None:
        raise InputError(f"--names is for a face in .glb, .vrm or .gltf, not for {options.face!r}")
    if is_named_face(options.face) and options.deformer == "blendshapes":
        return str(options.face)  # read when something shows it
    face = load_face(options.face)
    if options.deformer != "blendshapes":
        from mien.face.deformers import deformed_by

        return deformed_by(face, options.deformer)
    if not any(part.targets for part in face.parts):
        raise InputError(f"{options.face} has no morph targets that could move it: give --deformer X.tree")
    return face


def _is_foreign(face: str) -> bool:
    from mien.face.foreign.gltf_document import is_gltf

    return is_gltf(face)


def _refuse_same_file(outputs: Sequence[Path], inputs: Sequence[str | None]) -> None:
    """Refuse an output that would overwrite an input, or another output."""
    read = {Path(path).resolve() for path in inputs if path and len(path) < 1000}
    written: set[Path] = set()
    for path in outputs:
        real = path.resolve()
        if real in read:
            raise InputError(f"{path} is both read and written: give the output another name")
        if real in written:
            raise InputError(f"{path} is given twice as an output: give each a name of its own")
        written.add(real)


def _finish(animation: Animation, face: ShownFace, options: argparse.Namespace) -> int:
    from mien.api import calls as api

    _tell(animation.notes, options.quiet)
    outputs = _written(options, face)
    with progress_bar("drawing", " frames", options.quiet) as show, put_off() as obey:

        def progress(done: int, total: int) -> None:
            obey()
            show(done, total)

        view, glb = view_of(options), glb_style(options)
        notes = api.save(animation, *outputs, face=face, view=view, progress=progress, glb=glb)
    _tell((*notes, *_unused(options, outputs)), options.quiet)
    if not options.quiet:
        seconds = animation.utterance.duration
        print(f"{', '.join(outputs)}: {seconds:.2f} s at {animation.rate} frames/s")
    return 0


def _written(options: argparse.Namespace, face: ShownFace) -> tuple[str, ...]:
    """The outputs, less those for which a face would have to be drawn that cannot be (that was told at the start)."""
    outputs = (options.output, *options.also)
    if isinstance(face, str):
        return outputs
    from mien.face.foreign.drawn import not_drawn
    from mien.face.foreign.recognition import ForeignFace
    from mien.formats.registry import draws_pictures

    if isinstance(face, ForeignFace) and not_drawn(face):
        return tuple(path for path in outputs if not draws_pictures(path))
    return outputs


def _unused(options: argparse.Namespace, outputs: Sequence[str]) -> list[Note]:
    """Notes on options that none of the formats written has a use for."""
    from mien.formats.registry import draws_pictures, shows_face

    suffixes = ", ".join(dict.fromkeys(Path(path).suffix for path in outputs))
    unused: dict[str, str | None] = {}
    if not any(shows_face(path) for path in outputs):
        unused |= {"face": "default", "deformer": "blendshapes"}
    if not any(map(draws_pictures, outputs)):
        unused |= dict.fromkeys(VIEW_OPTIONS)
    if all(Path(path).suffix.lower() in _WITHOUT_FRAMES for path in outputs):
        unused |= _OF_FRAMES if hasattr(options, "voice_emotion") else _OF_FRAMES | _OF_FACES
    asked = {name: value for name in unused if (value := getattr(options, name, None)) not in (unused[name], None)}
    given = [f"--{name.replace('_', '-')} {' '.join(v) if isinstance(v, list) else v}" for name, v in asked.items()]
    return [Note("warning", f"{option} has no effect on {suffixes}") for option in given]


def _align(options: argparse.Namespace) -> int:
    from mien.api import calls as api
    from mien.core.files import check_writable
    from mien.formats.spoken_times import TIME_FORMATS, write_times

    if Path(options.output).suffix.lower() not in [suffix.lower() for suffix in TIME_FORMATS]:
        raise InputError(f"mien align writes {' '.join(TIME_FORMATS)}, not {options.output!r}; give -o NAME.TextGrid")
    path = check_writable(options.output)
    _refuse_same_file([path], [options.audio, options.text])
    utterance = api.align(
        options.audio, options.text, language=options.language, song=options.song, tiers=_tiers(options)
    )
    notes = write_times(utterance, path)
    _tell((*utterance.notes, *notes), options.quiet)
    if not options.quiet:
        spoken = len(utterance.words)
        print(f"{options.output}: words: {spoken}, phones and pauses: {len(utterance.spelled_phones)}")
    return 0


def _doctor(options: argparse.Namespace) -> int:
    from mien.api.diagnosis import doctor

    report = doctor()
    print(report)
    return 0 if report.healthy else 1


def _tell(notes: Iterable[Note], quiet: bool) -> None:
    if not quiet:
        for note in notes:
            print(f"mien: {note.kind}: {note.message}", file=sys.stderr)
