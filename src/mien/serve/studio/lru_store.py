"""Things under server-made ids, with the least recently used giving way to new ones."""

from __future__ import annotations

import secrets
from collections import OrderedDict
from collections.abc import Callable, Iterator
from threading import RLock
from typing import Generic, TypeVar

__all__ = ["Kept", "Missing", "new_id"]

Thing = TypeVar("Thing")


class Missing(Exception):  # noqa: N818 - not a fault: the id is unknown, or what it named has given way
    """There is nothing of this id (any more)."""


def new_id() -> str:
    """An id that cannot be guessed: 16 signs of the URL-safe alphabet."""
    return secrets.token_urlsafe(12)


class Kept(Generic[Thing]):
    """Things by id, bounded in number and in bytes.

    Parameters
    ----------
    kind : str
        What they are, for messages.
    most : int
        How many are kept.
    most_bytes : int or None
        How large they are together, as far as `put` is told; the newest is kept whatever its size.
    gone : callable or None
        Called with each thing that gives way.

    Examples
    --------
    >>> kept = Kept[str]("take", 2)
    >>> ids = [kept.put(name) for name in ("a", "b", "c")]
    >>> len(kept), kept.get(ids[2])
    (2, 'c')
    >>> kept.get(ids[0])
    Traceback (most recent call last):
    mien.serve.studio.lru_store.Missing: there is no such take (any more)
    """

    def __init__(
        self, kind: str, most: int, most_bytes: int | None = None, gone: Callable[[Thing], None] | None = None
    ) -> None:
        self.kind, self.most, self.most_bytes, self._gone = kind, most, most_bytes, gone
        self._things: OrderedDict[str, tuple[Thing, int]] = OrderedDict()
        self._lock = RLock()

    def put(self, thing: Thing, size: int = 0, name: str | None = None) -> str:
        """Keep a thing of so many bytes; returns its id."""
        with self._lock:
            name = name or new_id()
            self._things[name] = (thing, size)
            self._things.move_to_end(name)
            while len(self._things) > 1 and (len(self._things) > self.most or self._too_large()):
                _, (old, _) = self._things.popitem(last=False)
                if self._gone is not None:
                    self._gone(old)
            return name

    def _too_large(self) -> bool:
        return self.most_bytes is not None and sum(size for _, size in self._things.values()) > self.most_bytes

    def get(self, name: str) -> Thing:
        """The thing of an id.

        Raises
        ------
        Missing
            If there is none.
        """
        with self._lock:
            if name not in self._things:
                raise Missing(f"there is no such {self.kind} (any more)")
            self._things.move_to_end(name)
            return self._things[name][0]

    def drop(self, name: str) -> None:
        """Forget the thing of an id, if there is one."""
        with self._lock:
            found = self._things.pop(name, None)
        if found is not None and self._gone is not None:
            self._gone(found[0])

    def __contains__(self, name: object) -> bool:
        return name in self._things

    def __len__(self) -> int:
        return len(self._things)

    def __iter__(self) -> Iterator[Thing]:
        with self._lock:
            return iter([thing for thing, _ in self._things.values()])
