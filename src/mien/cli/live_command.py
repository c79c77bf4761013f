"""``mien live``: a microphone or a growing stream of sound, performed while it comes in."""

from __future__ import annotations

import argparse
import contextlib
import sys
from typing import TYPE_CHECKING, Any

from mien.cli.serve_command import add_outlet_options, outlets_of, places
from mien.cli.stopping import put_off
from mien.cli.view_options import add_view_options, given_view_options, view_of
from mien.core.errors import InputError

if TYPE_CHECKING:
    from mien.motion.performer import Performer
    from mien.serve.live.animator import LiveAnimator, LiveSettings
    from mien.serve.live.live_performance import Performed
    from mien.serve.live.live_recording import LiveRecording
    from mien.serve.live.sound_sources import SoundSource
    from mien.serve.live.streaming import Outlets

__all__ = ["add_command"]


def add_command(commands: Any) -> None:
    """Add ``mien live`` to the commands."""
    live = commands.add_parser("live", help="perform a microphone or a stream of sound live")
    live.add_argument(
        "sound",
        metavar="SOUND",
        nargs="?",
        help="'-' for standard input (WAV or raw samples), a named pipe, or a file; without it the microphone",
    )
    live.add_argument("--device", help="microphone: part of its name, or its number")
    live.add_argument("--list-devices", action="store_true", help="list the microphones")
    live.add_argument("--look-ahead", type=float, default=150.0, metavar="MS", help="50 to 300 (default 150)")
    live.add_argument("--follow", action="store_true", help="the file is still growing: wait at its end")
    live.add_argument(
        "--pace",
        choices=("auto", "live", "stored"),
        default="auto",
        help="live: catch up with late sound; stored: show everything at its own pace (default: depends on how "
        "the sound arrives)",
    )
    live.add_argument("--sample-rate", type=int, default=16_000, help="of raw samples (default 16000)")
    live.add_argument("--channels", type=int, default=1, help="of raw samples (default 1)")
    live.add_argument("--format", default="s16le", help="of raw samples: u8 s16le s24le s32le f32le f64le")
    live.add_argument("-o", "--output", metavar="OUT", help="also record it: .csv .json .wav .TextGrid .mp4 ...")
    live.add_argument("--also", metavar="OUT2", action="append", default=[], help="one more recording (repeatable)")
    live.add_argument("--fps", default="30", help="frames per second (default 30)")
    live.add_argument("--seed", type=int, default=0, help="seed of blinks, glances and drift (default 0)")
    live.add_argument("--performer", default="default", metavar="NAME|X.mien", help="who moves")
    live.add_argument(
        "--emotion",
        metavar="NAME[:0..1]",
        action="append",
        help="a constant emotion, such as happy:0.6; auto: the one that is heard",
    )
    live.add_argument("--wait", action="store_true", help="start when the first WebSocket client connects")
    add_view_options(live)
    add_outlet_options(live)
    live.add_argument("--quiet", action="store_true", help="print nothing but errors")
    live.set_defaults(run=_live)


def _live(options: argparse.Namespace) -> int:
    from mien.formats.registry import check_output, draws_pictures
    from mien.serve.live.animator import LiveAnimator
    from mien.serve.live.live_recording import LiveRecording

    if options.list_devices:
        from mien.serve.live.sound_sources import microphones

        print("\n".join(microphones()) or "no microphone was found")
        return 0
    recorded = [options.output, *options.also] if options.output else []
    if options.also and not options.output:
        raise InputError("--also names a second recording: give the first with -o")
    view = view_of(options)
    for path in recorded:
        check_output(path, view)
    if view is not None and not any(map(draws_pictures, recorded)):
        unused = " ".join(f"--{name}" for name in given_view_options(options))
        raise InputError(f"{unused}: for pictures alone; record some, with -o NAME.mp4")
    source = _source(options)
    performer, settings = _prepared(options)
    animator = LiveAnimator(performer, settings)
    outlets = outlets_of(options, _channels(), animator.settings.rate, recorded=bool(recorded))
    with contextlib.ExitStack() as stack:
        recording = None
        if recorded:
            recording = stack.enter_context(LiveRecording(animator.stream.classifier.labels))
        performed = _run(options, source, animator, outlets, recording)
        if recording is not None:
            again = (performer, source.stored, performed.dropped > 0)
            _write(options, recording, settings, recorded, *again)
    _tell(options, performed)
    return 0


def _channels() -> tuple[str, ...]:
    from mien.core import channels

    return channels.ALL


def _source(options: argparse.Namespace) -> SoundSource:
    from mien.serve.live.sound_sources import MicrophoneSource, open_source
    from mien.serve.live.sound_stream import PcmForm

    if options.sound is None:
        if options.follow or options.pace != "auto":
            raise InputError("--follow and --pace are for a file or a stream, not for a microphone")
        device = options.device
        return MicrophoneSource(int(device) if device is not None and device.isdecimal() else device)
    if options.device is not None:
        raise InputError(f"--device names a microphone: leave it out, or leave {options.sound!r} out")
    form = PcmForm(options.sample_rate, options.channels, options.format)
    return open_source(options.sound, form, options.pace, options.follow)


def _prepared(options: argparse.Namespace) -> tuple[Performer, LiveSettings]:
    from mien.pipeline.options import prepared, split_auto
    from mien.serve.live.animator import LiveSettings

    asked, heard = split_auto(options.emotion)
    performer, score, rate = prepared(options.performer, asked, options.fps, options.seed)
    return performer, LiveSettings(options.look_ahead / 1000, rate, score, options.seed, heard)


def _run(
    options: argparse.Namespace,
    source: SoundSource,
    animator: LiveAnimator,
    outlets: Outlets,
    recording: LiveRecording | None,
) -> Performed:
    from mien.serve.live.live_performance import perform_live

    def opened(port: int | None) -> None:
        if not options.quiet:
            aim = places(options.host, port, outlets) or "the recording only"
            ahead = f"{options.look_ahead:g} ms look-ahead"
            print(f"listening to {source.name}, {ahead}, streaming to {aim}; Ctrl-C ends", flush=True)

    asked_to_end = False
    with contextlib.suppress(KeyboardInterrupt), put_off() as obey:

        def stopping() -> bool:
            nonlocal asked_to_end
            try:
                obey()
            except KeyboardInterrupt:
                asked_to_end = True
            return asked_to_end

        import asyncio

        performed = asyncio.run(
            perform_live(
                source,
                animator,
                outlets,
                performer=options.performer,
                recording=recording,
                wait=options.wait,
                opened=opened,
                stopping=stopping,
            )
        )
    return performed


def _write(
    options: argparse.Namespace,
    recording: LiveRecording,
    settings: LiveSettings,
    paths: list[str],
    performer: Performer,
    stored: bool,
    lost: bool,
) -> None:
    """Write what was shown; for stored sound, and where sound was lost, what is shown where nothing is late."""
    from mien.api.calls import save

    if stored or lost:
        animation = recording.performed_again(performer, settings, options.performer, whole=lost)
    else:
        animation = recording.animation(settings.rate, settings.score, options.performer, settings.seed)
    if animation is None:
        raise InputError("nothing was heard, so nothing was recorded")
    notes = (*animation.notes, *save(animation, *paths, view=view_of(options)))
    if not options.quiet:
        for note in notes:
            print(f"mien: {note.kind}: {note.message}", file=sys.stderr)
        print(f"{', '.join(paths)}: {animation.utterance.duration:.2f} s at {animation.rate} frames/s")


def _tell(options: argparse.Namespace, performed: Performed) -> None:
    if options.quiet:
        return
    for note in performed.notes:
        print(f"mien: {note.kind}: {note.message}", file=sys.stderr)
    print(f"sent {performed.frames} frames, {performed.delay * 1000:.0f} ms behind the sound", file=sys.stderr)
