"""``mien serve``: an animation streamed in real time."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mien.core.timeline import FrameRate
    from mien.serve.live.streaming import Outlets

__all__ = ["add_command", "add_outlet_options", "outlets_of", "places"]


def add_command(commands: Any) -> None:
    """Add ``mien serve`` to the commands."""
    serve = commands.add_parser("serve", help="stream an animation to browsers and engines in real time")
    serve.add_argument("animation", metavar="LINE.json", help="a native animation: mien say ... -o LINE.json")
    add_outlet_options(serve)
    serve.add_argument("--loop", action="store_true", help="repeat until stopped")
    serve.add_argument("--wait", action="store_true", help="start when a client connects or an engine listens")
    serve.add_argument("--quiet", action="store_true", help="print nothing but errors")
    serve.set_defaults(run=_serve)


def add_outlet_options(parser: argparse.ArgumentParser) -> None:
    """The options that say where frames go."""
    parser.add_argument("--port", type=int, help="port of the WebSocket (default 8765; 0: any free one)")
    parser.add_argument("--host", default="127.0.0.1", help="address to listen on (default: this machine only)")
    parser.add_argument(
        "--token", help="token that clients must give (ws://...?token=...); required with another --host"
    )
    parser.add_argument(
        "--origin", action="append", default=[], help="origin of a web page that may connect (repeatable)"
    )
    parser.add_argument("--vmc", metavar="HOST[:PORT]", help="also send VMC packets there (usual port 39539)")
    parser.add_argument("--vmc-shapes", default="arkit", help="shape names in VMC packets: arkit, vrm or vrm1")
    parser.add_argument(
        "--vmc-head",
        default="0,0.09,0.01",
        metavar="X,Y,Z",
        help="rest position of the head bone on the neck in metres, or off",
    )
    parser.add_argument("--livelink", metavar="HOST[:PORT]", help="also send Live Link Face packets (usual port 11111)")
    parser.add_argument("--subject", default="mien", help="name that Live Link shows (default mien)")
    parser.add_argument("--no-websocket", action="store_true", help="send packets only")


def _serve(options: argparse.Namespace) -> int:
    from mien.formats.native import read_native
    from mien.serve.live.streaming import stream

    animation = read_native(options.animation)
    outlets = outlets_of(options, animation.channels.names, animation.rate)

    def opened(port: int | None) -> None:
        if not options.quiet:
            print(
                f"streaming {animation.utterance.duration:.2f} s to {places(options.host, port, outlets)}", flush=True
            )

    import asyncio

    played = asyncio.run(stream(animation, outlets, loop=options.loop, wait=options.wait, opened=opened))
    if not options.quiet:
        late = f", {played.skipped} skipped because this machine was late" if played.skipped else ""
        print(f"sent {played.frames} frames{late}", file=sys.stderr)
    return 0


def places(host: str, port: int | None, outlets: Outlets) -> str:
    """Where frames go, in words."""
    found = [f"ws://{f'[{host}]' if ':' in host else host}:{port}"] if port is not None else []
    return ", ".join([*found, *(f"{address[0]}:{address[1]} (UDP)" for address, _ in outlets.datagrams)])


def outlets_of(options: argparse.Namespace, names: Sequence[str], rate: FrameRate, recorded: bool = False) -> Outlets:
    """What `add_outlet_options` was given; ``recorded``: there may be no other outlet."""
    from mien.core.errors import InputError
    from mien.serve.live.datagrams import LIVELINK_PORT, VMC_PORT, livelink_encoder, parse_address, vmc_encoder
    from mien.serve.live.sockets import Access
    from mien.serve.live.streaming import Outlets

    packets = []
    if options.vmc is not None:
        packets.append(
            (parse_address(options.vmc, VMC_PORT), vmc_encoder(names, options.vmc_shapes, _rest(options.vmc_head)))
        )
    if options.livelink is not None:
        address = parse_address(options.livelink, LIVELINK_PORT)
        packets.append((address, livelink_encoder(names, rate, options.subject)))
    if not options.no_websocket:
        port = 8765 if options.port is None else options.port
        return Outlets(Access(options.host, port, options.token, tuple(options.origin)), packets)
    if not packets and not recorded:
        raise InputError("--no-websocket leaves nothing to stream to: give --vmc or --livelink")
    if options.port is not None or options.token is not None:
        raise InputError("--port and --token belong to the WebSocket, which --no-websocket leaves out")
    return Outlets(None, packets)


def _rest(asked: str) -> tuple[float, float, float] | None:
    """Where the head bone rests; None: bones are not sent."""
    from mien.core.errors import InputError

    if asked.strip().lower() == "off":
        return None
    try:
        x, y, z = (float(part) for part in asked.split(","))
    except ValueError as problem:
        raise InputError(f"--vmc-head is X,Y,Z in metres (such as 0,0.09,0.01) or off, not {asked[:40]!r}") from problem
    return x, y, z
