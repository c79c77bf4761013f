"""One stream, many listeners: none of them can hold up the others.

Every listener has a short queue of its own. Whoever reads too slowly loses the oldest frames of that queue and sees the
newest; `Listener.skipped` counts them, and the frame numbers show the gap.
"""

from __future__ import annotations

import asyncio
import json
from collections import deque

from mien.serve.live.frames import Frame

__all__ = ["QUEUE", "Hub", "Listener"]

QUEUE = 8
"""Frames that wait for a listener at most: a quarter of a second at 30 frames per second."""


class Listener:
    """One receiver's queue.

    Attributes
    ----------
    skipped : int
        Frames that it was too slow for.
    """

    def __init__(self, size: int = QUEUE) -> None:
        self._waiting: deque[Frame | str] = deque(maxlen=size)
        self._news = asyncio.Event()
        self._ended = False
        self.skipped = 0

    def __len__(self) -> int:
        return len(self._waiting)

    def put(self, frame: Frame | str) -> None:
        """Add a frame, or an event; with a full queue the oldest one is lost."""
        self.skipped += len(self._waiting) == self._waiting.maxlen
        self._waiting.append(frame)
        self._news.set()

    def end(self) -> None:
        """Say that no frame will follow."""
        self._ended = True
        self._news.set()

    async def get(self) -> Frame | str | None:
        """The next frame or event, or None at the end of the stream."""
        while not self._waiting:
            if self._ended:
                return None
            self._news.clear()
            await self._news.wait()
        return self._waiting.popleft()


class Hub:
    """Hands every frame to every listener.

    Attributes
    ----------
    began : float or None
        The moment of frame 0, seconds since 1970; None before.
    """

    def __init__(self) -> None:
        self._listeners: set[Listener] = set()
        self._ended = False
        self.began: float | None = None
        self._changed = asyncio.Event()

    def __len__(self) -> int:
        return len(self._listeners)

    def join(self) -> Listener:
        """A new listener, which gets the frames from now on."""
        listener = Listener()
        self._listeners.add(listener)
        self._changed.set()
        if self._ended:
            listener.end()
        return listener

    def leave(self, listener: Listener) -> None:
        """Forget a listener."""
        self._listeners.discard(listener)
        self._changed.set()

    async def occupied(self) -> None:
        """Wait until somebody listens."""
        await self._until(True)

    async def empty(self) -> None:
        """Wait until nobody listens."""
        await self._until(False)

    async def _until(self, occupied: bool) -> None:
        while bool(self._listeners) != occupied:
            self._changed.clear()
            await self._changed.wait()

    def begin(self, moment: float) -> None:
        """Tell all when frame 0 stands."""
        self.began = moment
        for listener in self._listeners:
            listener.put(json.dumps({"event": "began", "at": moment}))

    def publish(self, frame: Frame) -> None:
        """Hand on a frame; never waits."""
        for listener in self._listeners:
            listener.put(frame)

    def end(self) -> None:
        """Tell all that the stream is over."""
        self._ended = True
        for listener in self._listeners:
            listener.end()
