"""``mien say``, ``mien animate`` and ``mien align``: a line spoken, performed, and its sounds found."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from mien.cli.foreign_face import add_face_option, add_glb_options
from mien.cli.outputs import checked_face, finish, refuse_same_file, tell
from mien.cli.progress_bar import telling
from mien.cli.view_options import add_view_options
from mien.core.errors import InputError

__all__ = ["add_align", "add_animate", "add_say"]


def add_say(commands: Any) -> None:
    """Add ``mien say``."""
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


def add_animate(commands: Any) -> None:
    """Add ``mien animate``."""
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


def add_align(commands: Any) -> None:
    """Add ``mien align``."""
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
    from mien.pipeline.inputs import text_or_file

    face = checked_face(options, [options.script, options.text, options.edits])
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
    return finish(animation, face, options)


def _animate(options: argparse.Namespace) -> int:
    from mien.api import calls as api

    if options.voice is not None:
        raise InputError("--voice is for 'mien say'; 'mien animate' keeps the voice that is in the sound")
    face = checked_face(options, [options.script, options.audio, options.text, options.edits])
    if options.text is not None and options.script is not None:
        raise InputError("--text and --script both say what is spoken: give one of them")
    text = Path(options.script) if options.script is not None else options.text
    with telling(options.quiet):
        animation = api.animate(options.audio, text=text, song=options.song, tiers=_tiers(options), **_asked(options))
    return finish(animation, face, options)


def _asked(options: argparse.Namespace) -> dict[str, Any]:
    """What say and animate share."""
    names = ("language", "emotion", "effort", "fps", "seed", "performer", "speech_model", "prosody", "alive")
    return {name: getattr(options, name) for name in (*names, "commands", "edits")}


def _align(options: argparse.Namespace) -> int:
    from mien.api import calls as api
    from mien.core.files import check_writable
    from mien.formats.spoken_times import TIME_FORMATS, write_times

    if Path(options.output).suffix.lower() not in [suffix.lower() for suffix in TIME_FORMATS]:
        raise InputError(f"mien align writes {' '.join(TIME_FORMATS)}, not {options.output!r}; give -o NAME.TextGrid")
    path = check_writable(options.output)
    refuse_same_file([path], [options.audio, options.text])
    utterance = api.align(
        options.audio, options.text, language=options.language, song=options.song, tiers=_tiers(options)
    )
    notes = write_times(utterance, path)
    tell((*utterance.notes, *notes), options.quiet)
    if not options.quiet:
        spoken = len(utterance.words)
        print(f"{options.output}: words: {spoken}, phones and pauses: {len(utterance.spelled_phones)}")
    return 0
