"""``mien serve``: an animation streamed in real time."""

from __future__ import annotations

import argparse
import asyncio
import sys
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mien.animation import Animation
    from mien.live.streaming import Outlets

__all__ = ["add_command"]


def add_command(commands: Any) -> None:
    """Add ``mien serve`` to the commands."""
    serve = commands.add_parser("serve", help="stream an animation to browsers and engines in real time")
    serve.add_argument("animation", metavar="LINE.json", help="a native animation: mien say ... -o LINE.json")
    serve.add_argument("--port", type=int, help="port of the WebSocket (default 8765; 0: any free one)")
    serve.add_argument("--host", default="127.0.0.1", help="address to listen on (default: this machine only)")
    serve.add_argument("--token", help="clients must give it (ws://...?token=...); needed with another --host")
    serve.add_argument(
        "--origin", action="append", default=[], help="origin of a web page that may connect (repeatable)"
    )
    serve.add_argument("--vmc", metavar="HOST[:PORT]", help="also send VMC packets there (usual port 39539)")
    serve.add_argument("--vmc-shapes", default="arkit", help="names of the shapes in them: arkit or vrm")
    serve.add_argument("--livelink", metavar="HOST[:PORT]", help="also send Live Link Face packets (usual port 11111)")
    serve.add_argument("--subject", default="mien", help="name that Live Link shows (default mien)")
    serve.add_argument("--loop", action="store_true", help="begin again at the end, until stopped")
    serve.add_argument("--wait", action="store_true", help="begin when the first WebSocket client comes")
    serve.add_argument("--no-websocket", action="store_true", help="packets only")
    serve.add_argument("--quiet", action="store_true", help="say nothing but errors")
    serve.set_defaults(run=_serve)


def _serve(options: argparse.Namespace) -> int:
    from mien.live.streaming import stream
    from mien.output.native import read_native

    animation = read_native(options.animation)
    outlets = _outlets(options, animation)

    def opened(port: int | None) -> None:
        if not options.quiet:
            places = [f"ws://{options.host}:{port}"] if port is not None else []
            places += [f"{address[0]}:{address[1]} (UDP)" for address, _ in outlets.datagrams]
            print(f"streaming {animation.utterance.duration:.2f} s to {', '.join(places)}", flush=True)

    played = asyncio.run(stream(animation, outlets, loop=options.loop, wait=options.wait, opened=opened))
    if not options.quiet:
        late = f", {played.skipped} skipped because this machine was late" if played.skipped else ""
        print(f"sent {played.frames} frames{late}", file=sys.stderr)
    return 0


def _outlets(options: argparse.Namespace, animation: Animation) -> Outlets:
    from mien.errors import InputError
    from mien.live.datagrams import LIVELINK_PORT, VMC_PORT, livelink_encoder, parse_address, vmc_encoder
    from mien.live.sockets import Access
    from mien.live.streaming import Outlets

    names, rate = animation.channels.names, animation.rate
    packets = []
    if options.vmc is not None:
        packets.append((parse_address(options.vmc, VMC_PORT), vmc_encoder(names, options.vmc_shapes)))
    if options.livelink is not None:
        address = parse_address(options.livelink, LIVELINK_PORT)
        packets.append((address, livelink_encoder(names, rate, options.subject)))
    if not options.no_websocket:
        port = 8765 if options.port is None else options.port
        return Outlets(Access(options.host, port, options.token, tuple(options.origin)), packets)
    if not packets:
        raise InputError("--no-websocket leaves nothing to stream to: give --vmc or --livelink")
    if options.wait or options.port is not None or options.token is not None:
        raise InputError("--wait, --port and --token belong to the WebSocket, which --no-websocket leaves out")
    return Outlets(None, packets)
