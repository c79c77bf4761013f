"""What the studio's server allows: addresses, limits, how much is kept."""

from __future__ import annotations

import secrets
from dataclasses import dataclass, field
from urllib.parse import urlencode

from mien.serve.addresses import check_address

__all__ = ["Limits", "StudioSettings"]


@dataclass(frozen=True)
class Limits:
    """How much one studio takes in and keeps. What is past a limit is refused with status 413 or 429, or, where it is
    kept, the least recently used gives way.

    Attributes
    ----------
    upload_bytes : int
        Of one body: a sound, a GLB, a tree configuration.
    json_bytes : int
        Of a body in JSON other than a tree configuration.
    text_characters : int
        Of a line.
    seconds : float
        Of sound, spoken or uploaded.
    edits : int
        In one layer, keys and points counted.
    fps : float
        The highest frame rate.
    takes, faces, rigs, files : int
        How many of each are kept.
    kept_bytes : int
        Of faces and result files on disk together, and of takes in memory together.
    jobs_waiting : int
        Jobs that wait for a worker; one more is refused.
    jobs_kept : int
        Ended jobs that can still be asked for.
    workers : int
        Jobs at once.
    request_seconds : float
        Seconds after which a body that does not arrive whole is refused, and a client that takes nothing cut off.
    head_seconds : float
        Seconds after which a connection without a request is closed.
    connections : int
        Connections at once; one more is closed.
    """

    upload_bytes: int = 64 * 2**20
    json_bytes: int = 4 * 2**20
    text_characters: int = 2000
    seconds: float = 300.0
    edits: int = 5000
    fps: float = 240.0
    takes: int = 24
    faces: int = 8
    rigs: int = 8
    files: int = 24
    kept_bytes: int = 2**30
    jobs_waiting: int = 8
    jobs_kept: int = 64
    workers: int = 2
    request_seconds: float = 60.0
    head_seconds: float = 15.0
    connections: int = 64


@dataclass(frozen=True)
class StudioSettings:
    """Where the studio listens, and to whom.

    Attributes
    ----------
    host : str
        Address to bind to.
    port : int
        0 takes any free one.
    token : str or None
        Must be given once, in the page's address (``?token=...``) or in the header ``Authorization: Bearer ...``;
        needed where ``host`` is not the machine itself.
    names : tuple of str
        Further names by which this machine is reached, for the check of the header ``Host``; the bound host and, on
        loopback, ``localhost``, are known. With a token any name is taken, since the token keeps strangers out.
    limits : Limits

    Raises
    ------
    InputError
        If others could reach it and there is no token, or the port is none.

    Examples
    --------
    >>> StudioSettings(host="0.0.0.0")
    Traceback (most recent call last):
    mien.core.errors.InputError: 0.0.0.0 can be reached by other machines: give --token, which every client must know
    """

    host: str = "127.0.0.1"
    port: int = 8700
    token: str | None = None
    names: tuple[str, ...] = ()
    limits: Limits = field(default_factory=Limits)
    session: str = field(default_factory=lambda: secrets.token_urlsafe(24))

    def __post_init__(self) -> None:
        check_address(self.host, self.port, self.token)

    def address(self, port: int) -> str:
        """Where a browser finds the page, with the token if there is one.

        Examples
        --------
        >>> StudioSettings().address(8700)
        'http://127.0.0.1:8700/'
        """
        host = {"0.0.0.0": "127.0.0.1", "::": "[::1]"}.get(self.host, self.host)
        host = f"[{host}]" if ":" in host and not host.startswith("[") else host
        return f"http://{host}:{port}/" + (f"?{urlencode({'token': self.token})}" if self.token else "")
