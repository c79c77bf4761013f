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
from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext
from typing import Any, NoReturn

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
from mien.cli.help_page import HelpFormatter, examples_of, help_page, options_of, with_suggestion
from mien.cli.line_commands import add_align, add_animate, add_say
from mien.cli.progress_bar import still_working
from mien.cli.record_command import add_record_command
from mien.cli.stopping import stop_cleanly
from mien.core.compiled import when_compiling
from mien.core.errors import MienError
from mien.core.files import claimed_outputs, made_folders

__all__ = ["main"]


_OF_STREAMS = (errno.ENOSPC, errno.EBADF, errno.EIO, errno.EPIPE, errno.EFBIG)
_WAITING = ("live", "serve", "studio", "record", "interpret", "speak", "translate", "perform", "warm-up")
"""Commands that wait for somebody, or say themselves what they do."""


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

    add_say(commands)
    add_animate(commands)
    add_align(commands)
    add_corpus_commands(commands)
    add_record_command(commands)
    learn_command.add_command(commands)
    evaluate_command.add_command(commands)
    score_command.add_command(commands)
    inspect_command.add_command(commands)
    face_commands.add_command(commands)
    express_command.add_command(commands)
    recolor_command.add_command(commands)
    add_emotion_commands(commands)
    serve_command.add_command(commands)
    live_command.add_command(commands)
    studio_command.add_command(commands)

    module_commands.add_commands(commands)
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


def _doctor(options: argparse.Namespace) -> int:
    from mien.api.diagnosis import doctor

    report = doctor()
    print(report)
    return 0 if report.healthy else 1
