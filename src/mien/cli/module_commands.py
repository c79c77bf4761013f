"""``mien interpret | mien speak | mien translate | mien perform``: the four modules as programs (docs/modules.md)."""

from __future__ import annotations

import argparse
import io
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mien.cli.outputs import checked_face
from mien.cli.view_options import VIEW_OPTIONS, add_view_options, view_of

if TYPE_CHECKING:
    from mien.animation.animation import Animation
    from mien.serve.modules.transport import Sink, Source
    from mien.text.commands import CommandLibrary

__all__ = ["add_commands"]


def add_commands(commands: Any) -> None:
    """Add the four commands."""
    interpret = commands.add_parser("interpret", help="module 1: turns text with tags into speech and commands")
    interpret.add_argument("file", metavar="FILE", nargs="?", help="a script to interpret instead of standard input")
    _add_streams(interpret, _interpret)
    speak = commands.add_parser("speak", help="module 2: speaks it and times everything")
    speak.add_argument("--voice", help="voice to speak with (mien doctor lists them)")
    speak.add_argument("--language", metavar="TAG", help="such as fi (default: the language of the voice)")
    speak.add_argument("--seed", type=int, default=0, help="seed of the voice (default 0)")
    speak.add_argument(
        "--emotion",
        metavar="NAME[:0..1]",
        action="append",
        help="emotion of the voice; 'mien perform' takes that of the face",
    )
    speak.add_argument(
        "--voice-emotion",
        metavar="off|0..1",
        default="1",
        help="how strongly the voice takes on the emotion (default 1)",
    )
    _add_streams(speak, _speak)
    translate = commands.add_parser("translate", help="module 3: turns commands into curves of face parameters")
    _add_streams(translate, _translate)
    perform = commands.add_parser("perform", help="module 4: performs it, as JSON frames or into a file (-o)")
    perform.add_argument(
        "-o",
        "--output",
        metavar="OUT",
        help="write a file instead; {id} stands for the utterance's number, {sender} for its stream's",
    )
    perform.add_argument("--fps", default="30", help="frames per second (default 30)")
    perform.add_argument("--seed", type=int, default=0, help="seed of blinks, glances and drift (default 0)")
    perform.add_argument("--face", metavar="NAME|FILE", help="with -o: the face to show, as for mien say")
    perform.add_argument("--names", metavar="X.toml", help="with -o: names for your own face, as for mien say")
    perform.add_argument("--deformer", metavar="NAME|X.tree", help="with -o: what moves the face, as for mien say")
    add_view_options(perform)
    perform.add_argument("--performer", default="default", metavar="NAME|X.mien", help="who moves")
    perform.add_argument(
        "--speech-model", choices=("coarticulation", "graph", "both"), help="what moves the mouth, as for mien say"
    )
    perform.add_argument(
        "--emotion", metavar="NAME[:0..1]", action="append", help="emotion of every whole utterance (repeatable)"
    )
    perform.add_argument("--alive", default="all", help="signs of life, as for mien say (default all)")
    perform.add_argument("--edits", metavar="X.json", help="manual edits to apply to every utterance (docs/edits.md)")
    perform.add_argument(
        "--effort", default=None, help="how strongly words are articulated, 0..2 or off, as for mien say"
    )
    perform.add_argument("--prosody", default=None, help="visual prosody: off, or 0..1, as for mien say")
    _add_streams(perform, _perform)


def _add_streams(parser: Any, run: Callable[[argparse.Namespace], int]) -> None:
    parser.add_argument(
        "--commands", metavar="FOLDER", action="append", default=[], help="folder with your own commands"
    )
    parser.add_argument(
        "--listen", metavar="[HOST:]PORT", help="read from a connection to this address instead of standard input"
    )
    parser.add_argument(
        "--token",
        help="token that the sender must give (with --listen) and that the next module expects (with --connect)",
    )
    parser.add_argument("--stay", action="store_true", help="with --listen: keep running when a sender has finished")
    parser.add_argument("--connect", metavar="[HOST:]PORT", help="send to this address instead of standard output")
    parser.add_argument(
        "--patience", type=float, default=30.0, help="how many seconds to wait for the next module (default 30)"
    )
    parser.add_argument("--quiet", action="store_true", help="print nothing but errors")
    parser.set_defaults(run=run)


def _library(options: argparse.Namespace) -> CommandLibrary:
    from mien.text.commands import CommandLibrary

    return CommandLibrary.of(*options.commands)


def _run(
    name: str, options: argparse.Namespace, library: CommandLibrary, handle: Any, source: Source | None = None
) -> int:
    from mien.serve.modules.handlers import refusal_frame
    from mien.serve.modules.messages import Messages
    from mien.serve.modules.running import Module, refusal
    from mien.serve.modules.transport import Listener, Sender, StandardInput, StandardOutput, parse_address

    def messages() -> Messages:
        return Messages(library.names, texts=name == "interpret")

    _check_streams(options)
    address = parse_address(options.connect) if options.connect is not None else None
    if source is None and options.listen is not None:
        source = listener = Listener(*parse_address(options.listen), messages, options.stay, options.token)
        if not options.quiet:
            print(f"mien {name}: listening at port {listener.port}", file=sys.stderr, flush=True)
    elif source is None:
        if isinstance(sys.stdin, io.TextIOWrapper):
            sys.stdin.reconfigure(encoding="utf-8", errors="strict")
        source = StandardInput(sys.stdin, messages())
    sink: Sink = StandardOutput()
    if address is not None:
        sink = Sender(*address, patience=options.patience, token=options.token)
    line = refusal_frame if name == "perform" else refusal
    answered = address is not None or getattr(options, "output", None) is not None
    return Module(name, handle, source, sink, refusal_line=None if answered else line).run()


def _check_streams(options: argparse.Namespace) -> None:
    from mien.core.errors import InputError

    if options.stay and options.listen is None:
        raise InputError("--stay is for --listen: a stream on standard input ends once")
    if options.token is not None and options.listen is None and options.connect is None:
        raise InputError("--token is for --listen and --connect: standard input and output have none")
    if getattr(options, "patience", 1.0) < 0:
        raise InputError(f"--patience is seconds, 0 or more, not {options.patience:g}")
    if getattr(options, "seed", 0) < 0:
        raise InputError(f"a seed is a whole number, 0 or more, not {options.seed}")


def _interpret(options: argparse.Namespace) -> int:
    from mien.core.errors import InputError
    from mien.serve.modules.handlers import Interpret
    from mien.serve.modules.messages import Message
    from mien.serve.modules.transport import Delivery

    library = _library(options)
    if options.file is None:
        return _run("interpret", options, library, Interpret(library))
    if options.listen is not None:
        raise InputError(f"{options.file} and --listen both say where the script comes from: give one of them")
    from mien.text.script_reading import read_script_file, script_text

    text, _ = script_text(options.file)
    read_script_file(options.file, library)

    class _File:
        def deliveries(self) -> Any:
            yield Delivery(Message(text, 1), "00000000:1", lambda *_: None)

    return _run("interpret", options, library, Interpret(library, str(options.file)), _File())


def _speak(options: argparse.Namespace) -> int:
    from mien.pipeline.options import score_of, share_of
    from mien.serve.modules.handlers import Speak
    from mien.speech.voices import get_voice
    from mien.text.languages import find_language

    library = _library(options)
    get_voice(options.voice, find_language(options.language))  # what is not there is told before anything comes in
    amount = share_of("emotion in the voice", options.voice_emotion)
    score = score_of(options.emotion)
    handle = Speak(library, options.voice, options.seed, options.language, amount, score)
    return _run("speak", options, library, handle)


def _translate(options: argparse.Namespace) -> int:
    from mien.serve.modules.handlers import Translate

    library = _library(options)
    return _run("translate", options, library, Translate(library, _teller("translate", options)))


def _teller(name: str, options: argparse.Namespace) -> Any:
    def tell(notes: Any) -> None:
        if not options.quiet:
            for note in notes:
                print(f"mien {name}: {note.kind}: {note.message}", file=sys.stderr)

    return tell


def _perform(options: argparse.Namespace) -> int:
    from mien.animation.edits import EMPTY, read_layer
    from mien.core.errors import InputError
    from mien.pipeline.options import effort_by_hand, prepared
    from mien.serve.modules.handlers import Perform

    library = _library(options)
    given = {"speech_model": options.speech_model, "alive": options.alive}
    given |= {} if options.prosody is None else {"prosody": options.prosody}
    given |= {} if options.effort is None else {"effort": effort_by_hand(options.effort)}
    performer, score, rate = prepared(options.performer, options.emotion, options.fps, options.seed, **given)
    if options.output is not None and options.connect is not None:
        raise InputError("--output and --connect both say where the frames go: give one of them")
    for name in ("face", "deformer", "names", *VIEW_OPTIONS):
        if options.output is None and getattr(options, name) is not None:
            raise InputError(f"--{name} is for --output: frames are channels and show no face")
    save = None if options.output is None else _saver(options)
    edits = EMPTY if options.edits is None else read_layer(options.edits)
    handle = Perform(library, performer, rate, options.seed, score, save, edits)
    return _run("perform", options, library, handle)


def _saver(options: argparse.Namespace) -> Callable[[Animation, str, str], None]:
    from mien.api import calls as api
    from mien.serve.modules.handlers import output_path

    options.face, options.deformer, options.also = options.face or "default", options.deformer or "blendshapes", []
    asked = argparse.Namespace(**vars(options) | {"output": str(output_path(options.output, "1", "1", ()))})
    view = view_of(options)
    face, written = checked_face(asked, [options.edits]), set[Path]()

    def save(animation: Animation, name: str, sender: str) -> None:
        path = output_path(options.output, name, sender, written)
        _teller("perform", options)((*animation.notes, *api.save(animation, path, face=face, view=view)))
        written.add(path)
        if not options.quiet:
            seconds = animation.utterance.duration
            print(f"mien perform: {path}: {seconds:.2f} s at {animation.rate} frames/s", file=sys.stderr, flush=True)

    return save
