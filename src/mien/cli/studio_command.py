"""``mien studio``: the studio's server, until it is stopped."""

from __future__ import annotations

import argparse
import contextlib
import os
import signal
import sys
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import asyncio

    from mien.serve.studio.settings import StudioSettings
    from mien.serve.studio.workshop import Workshop

__all__ = ["add_command"]


def add_command(commands: Any) -> None:
    """Add ``mien studio`` to the commands."""
    studio = commands.add_parser("studio", help="direct a line in the browser: listen, watch, edit, export")
    studio.add_argument("--port", type=int, default=8700, help="port of the page (default 8700; 0: any free one)")
    studio.add_argument("--no-browser", action="store_true", help="print the address and do not open a browser")
    studio.add_argument("--host", default="127.0.0.1", help="address to listen on (default: this machine only)")
    studio.add_argument("--token", help="token that clients must give; required with another --host")
    studio.add_argument("--name", action="append", default=[], help="another name of this machine (repeatable)")
    studio.add_argument(
        "--folder", metavar="DIR", help="where takes are saved as you make them (default: with your user data)"
    )
    studio.set_defaults(run=_studio)


def _studio(options: argparse.Namespace) -> int:
    from mien.serve.studio.settings import StudioSettings
    from mien.serve.studio.workshop import Workshop

    settings = StudioSettings(options.host, options.port, options.token, tuple(options.name))
    workshop = Workshop(settings.limits, options.folder)
    try:
        import asyncio

        asyncio.run(_serve(settings, workshop, options))
    finally:
        ended = workshop.close()
    if not ended:  # a voice is in the middle of a text; Python's own way out would abort with it
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(0)
    return 0


async def _serve(settings: StudioSettings, workshop: Workshop, options: argparse.Namespace) -> None:
    import asyncio

    from mien.serve.studio.server import running_studio

    stop = asyncio.Event()
    _stop_on_signals(stop)
    async with running_studio(settings, workshop) as port:
        address = settings.address(port)
        print(f"the studio is open at {address}  (Ctrl-C closes it)", flush=True)
        for told in (workshop.told, *workshop.journal.faults):
            print(told, flush=True)
        workshop.jobs.start(workshop.warm_up)
        if not options.no_browser:
            await asyncio.to_thread(_open_browser, address)
        await stop.wait()


def _stop_on_signals(stop: asyncio.Event) -> None:
    """Let requests to end set an event; where the system has no such handlers they unwind as KeyboardInterrupt."""
    from asyncio import get_running_loop

    loop = get_running_loop()
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        if hasattr(signal, name):
            with contextlib.suppress(NotImplementedError):
                loop.add_signal_handler(getattr(signal, name), stop.set)


def _open_browser(address: str) -> None:
    import webbrowser

    webbrowser.open(address)
