"""Getting messages from one module to the next: standard input and output, or TCP.

On TCP every line is ``ID MESSAGE``; the receiver answers ``<done id="ID"/>`` once the message has been dealt with by
all modules after it, or ``<refused id="ID" module="NAME">why</refused>``; the sender ends with ``<end/>``. A sender
keeps what was not answered and sends it again when a module comes back; a receiver knows the IDs it has dealt with, so
nothing is done twice by a module that stayed alive. At most `WINDOW` messages are unanswered, so a slow module slows
those before it. With a token, every connection begins with the line ``<token>TOKEN</token>``; a listener that other
machines can reach has one.
"""

from __future__ import annotations

import contextlib
import re
import secrets
import socket
import sys
import threading
import time
import uuid
from collections import OrderedDict
from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass, replace
from typing import IO, Protocol, TextIO
from xml.sax.saxutils import escape, quoteattr

from mien.core.errors import InputError, OutputError
from mien.core.limits import is_whole
from mien.serve.addresses import check_address
from mien.serve.modules.messages import MOST_CHARACTERS, Message, Messages
from mien.serve.modules.xml_form import element_of

__all__ = [
    "PATIENCE",
    "WINDOW",
    "Delivery",
    "Listener",
    "Sender",
    "Sink",
    "Source",
    "StandardInput",
    "StandardOutput",
    "parse_address",
]

WINDOW = 4
"""Messages on their way at once between two modules."""
_REMEMBERED = 10_000
PATIENCE = 5.0
"""Seconds within which a sender has to give its token."""
_RETRY = 0.2  # seconds between two tries to reach a module
_IDENTIFIED = re.compile(r"([0-9a-f]{8}:[0-9.]+) (.*)", re.DOTALL)

Answer = Callable[[str | None, str], None]
"""Called once with None if all went well, else with why the message was refused, and the module's name."""


@dataclass
class Delivery:
    """A message that came in, and how to say what became of it."""

    message: Message
    identity: str
    answer: Answer

    @property
    def number(self) -> int | None:
        """Which message of its sender it is, from 1; the same when it is sent again. None without an identity."""
        number = self.identity.partition(":")[2].partition(".")[0]
        return int(number) if number else None


class Source(Protocol):
    """Where messages come from."""

    def deliveries(self) -> Iterator[Delivery]:
        """Messages in order, until the stream ends."""


class Sink(Protocol):
    """Where messages go."""

    def send(self, text: str, identity: str, answer: Answer) -> None:
        """Hand on one line; waits while too many are unanswered."""

    def close(self) -> None:
        """Wait until everything is answered."""


def parse_address(text: str) -> tuple[str, int]:
    """Host and port of ``PORT`` or ``HOST:PORT``; the host is this computer unless named.

    Raises
    ------
    InputError
        If it is neither.

    Examples
    --------
    >>> parse_address("7001"), parse_address("10.0.0.5:7001")
    (('127.0.0.1', 7001), ('10.0.0.5', 7001))
    """
    host, _, port = text.rpartition(":")
    if not is_whole(port) or not 0 <= int(port) < 65536:
        raise InputError(f"an address is PORT or HOST:PORT, such as 7001 or 10.0.0.5:7001, not {text!r}")
    return host.strip("[]") or "127.0.0.1", int(port)


def _keep_alive(connection: socket.socket) -> None:
    """Send at once, and notice a computer that vanished (cable, power) within about a minute."""
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    for name, value in (("TCP_KEEPIDLE", 20), ("TCP_KEEPINTVL", 10), ("TCP_KEEPCNT", 4), ("TCP_USER_TIMEOUT", 60_000)):
        if hasattr(socket, name):  # not every system has each
            connection.setsockopt(socket.IPPROTO_TCP, getattr(socket, name), value)


class StandardInput:
    """Messages from a stream of text lines."""

    def __init__(self, stream: IO[str], messages: Messages) -> None:
        self.stream, self.messages = stream, messages

    def deliveries(self) -> Iterator[Delivery]:
        """Messages as their lines come in."""
        session, number = uuid.uuid4().hex[:8], 0
        for line in self._lines():
            found = self.messages.finish() if line is None else self.messages.take(line)
            for message in found:
                number += 1
                yield Delivery(replace(message, sender=session), f"{session}:{number}", lambda *_: None)

    def _lines(self) -> Iterator[str | None]:
        try:
            yield from self.stream
        except UnicodeDecodeError as problem:
            raise InputError(
                f"standard input, after line {self.messages.count}: expected UTF-8 text, got other bytes"
            ) from problem
        yield None


class StandardOutput:
    """Lines to a stream, each at once."""

    def __init__(self, stream: TextIO | None = None) -> None:
        self.stream = stream or sys.stdout

    def send(self, text: str, identity: str, answer: Answer) -> None:
        """Write a line."""
        self.stream.write(text + "\n")
        self.stream.flush()
        answer(None, "")

    def close(self) -> None:
        """Nothing is left to wait for."""


class Listener:
    """Messages from whoever connects, one sender at a time; a sender that breaks off may come back.

    Parameters
    ----------
    host, port
        Port 0 takes a free one; `port` then tells which.
    make_messages : callable
        Gives a fresh `Messages` for each connection.
    stay : bool
        Whether to go on listening after a sender has ended.
    token : str, optional
        What a sender has to begin with, within `PATIENCE` seconds.

    Raises
    ------
    InputError
        If others could reach it and there is no token, or the address cannot be listened at.
    """

    def __init__(
        self,
        host: str,
        port: int,
        make_messages: Callable[[], Messages],
        stay: bool = False,
        token: str | None = None,
    ) -> None:
        check_address(host, port, token)
        self.make_messages, self.stay, self.token = make_messages, stay, token
        self.answers: OrderedDict[str, tuple[str | None, str] | None] = OrderedDict()
        self.lock = threading.Lock()
        self.connection: socket.socket | None = None
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        try:
            self.server = socket.create_server((host, port), family=family)
        except OSError as problem:
            raise InputError(f"cannot listen at {host}:{port}: {problem.strerror or problem}") from problem
        self.port = int(self.server.getsockname()[1])

    def deliveries(self) -> Iterator[Delivery]:
        """Messages from all senders, one sender after another."""
        ended = False
        while not ended or self.stay:
            connection, _ = self.server.accept()
            _keep_alive(connection)
            if self.token is not None and not _knows(connection, self.token):
                connection.close()
                continue
            with self.lock:
                self.connection = connection
            ended = yield from self._of(connection)
            if ended:
                connection.close()
        self.server.close()

    def _of(self, connection: socket.socket) -> Generator[Delivery, None, bool]:
        """Messages of one connection; returns whether the sender ended properly."""
        messages, session, number = self.make_messages(), uuid.uuid4().hex[:8], 0
        identity = ""
        with connection.makefile("rb") as stream:
            for raw in _lines_of(stream):
                if raw.strip() == b"<end/>":
                    for message in messages.finish():
                        yield from self._delivery(message, identity or f"{session}:{number + 1}")
                    self._drain()
                    return True
                line = raw.decode("utf-8", errors="replace")
                found = _IDENTIFIED.match(line)
                if found:
                    identity, line = found[1], found[2]
                for message in messages.take(line):
                    number += 1
                    yield from self._delivery(message, identity or f"{session}:{number}")
                    identity = ""
        if not identity:  # a sender without identities, such as nc, that simply closes
            for message in messages.finish():
                yield from self._delivery(message, f"{session}:{number + 1}")
        return False

    def _delivery(self, message: Message, identity: str) -> Iterator[Delivery]:
        with self.lock:
            known = identity in self.answers
            answered = self.answers.get(identity)
            if not known:
                self.answers[identity] = None
                while len(self.answers) > _REMEMBERED:
                    self.answers.popitem(last=False)
        if not known:
            sent = replace(message, sender=identity.partition(":")[0])
            yield Delivery(sent, identity, lambda reason, module: self._answer(identity, reason, module))
        elif answered is not None:  # dealt with before; the answer was lost on its way
            self._tell(identity, *answered)

    def _answer(self, identity: str, reason: str | None, module: str) -> None:
        with self.lock:
            self.answers[identity] = reason, module
        self._tell(identity, reason, module)

    def _tell(self, identity: str, reason: str | None, module: str) -> None:
        if reason is None:
            line = f"<done id={quoteattr(identity)}/>\n"
        else:
            about = f"id={quoteattr(identity)} module={quoteattr(module)}"
            line = f"<refused {about}>{escape(' '.join(reason.split()))}</refused>\n"
        with self.lock:
            if self.connection is None:
                return
            try:
                self.connection.sendall(line.encode())
            except OSError:  # the sender is gone; it will ask again when it is back
                self.connection = None

    def _drain(self) -> None:
        """Wait until every message has its answer, so that a sender hears all before we go."""
        while True:
            with self.lock:
                if all(answer is not None for answer in self.answers.values()):
                    break
            time.sleep(0.01)
        with self.lock:
            if self.connection is not None:
                try:
                    self.connection.sendall(b"<end/>\n")
                except OSError:  # it did not wait for the farewell
                    self.connection = None


def _knows(connection: socket.socket, token: str) -> bool:
    """Whether a sender begins with the token; one that is silent is not waited for."""
    expected, given, until = _greeting(token), b"", time.monotonic() + PATIENCE
    try:
        while len(given) < len(expected) and b"\n" not in given and (left := until - time.monotonic()) > 0:
            connection.settimeout(left)
            more = connection.recv(len(expected) - len(given))
            if not more:
                return False
            given += more
        if not secrets.compare_digest(given, expected):
            connection.sendall(b'<refused id="">the token is missing or wrong</refused>\n')
            return False
        connection.settimeout(None)
    except OSError:  # silent, or gone
        return False
    return True


def _greeting(token: str) -> bytes:
    return f"<token>{escape(token)}</token>\n".encode()


def _lines_of(stream: IO[bytes]) -> Iterator[bytes]:
    """Whole lines; half a line at the end (a sender that died) does not count unless it has no identity."""
    try:
        while line := stream.readline(MOST_CHARACTERS):
            if not line.endswith(b"\n") and re.match(rb"[0-9a-f]{8}:[0-9.]+ ", line):
                return
            yield line
    except OSError:  # the connection broke; the sender sends again
        return


class Sender:
    """Sends to a module, keeps what it has not answered, finds it again when it was away.

    Parameters
    ----------
    host, port
    patience : float
        Seconds for which a module may be away.
    window : int
        Messages that may be unanswered.
    token : str, optional
        What the module wants to be told first.
    """

    def __init__(
        self, host: str, port: int, patience: float = 30.0, window: int = WINDOW, token: str | None = None
    ) -> None:
        self.host, self.port, self.patience, self.window, self.token = host, port, patience, window, token
        self.waiting: OrderedDict[str, tuple[str, Answer]] = OrderedDict()
        self.changed = threading.Condition()
        self.connection: socket.socket | None = None
        self.failed: OutputError | None = None
        self.ended = False
        self.farewell = False
        self.worker = threading.Thread(target=self._keep_connected, name=f"mien-to-{port}", daemon=True)
        self.worker.start()

    def send(self, text: str, identity: str, answer: Answer) -> None:
        """Send a line; waits while `window` messages are unanswered.

        Raises
        ------
        OutputError
            If nobody was there for longer than the patience.
        """
        with self.changed:
            self.changed.wait_for(lambda: self.failed is not None or len(self.waiting) < self.window)
            self._check()
            self.waiting[identity] = text, answer
            self._put(f"{identity} {text}\n")

    def close(self) -> None:
        """Wait for all answers, then say that this was all.

        Raises
        ------
        OutputError
            If nobody was there for longer than the patience.
        """
        with self.changed:
            self.changed.wait_for(lambda: self.failed is not None or not self.waiting)
            self._check()
            self.changed.wait_for(lambda: self.failed is not None or self.connection is not None)
            self.ended = True
            self._put("<end/>\n")
            self.changed.wait_for(lambda: self.failed is not None or self.farewell, timeout=self.patience)
            if self.connection is not None:
                self.connection.close()

    def _check(self) -> None:
        if self.failed is not None:
            raise self.failed

    def _put(self, line: str) -> None:
        if self.connection is None:
            return  # all that waits is sent when it is back
        try:
            self.connection.sendall(line.encode())
        except OSError:
            self.connection = None

    def _keep_connected(self) -> None:
        away = time.monotonic()
        while not self.farewell:
            try:
                connection = socket.create_connection((self.host, self.port), timeout=5)
            except OSError as problem:
                if self.ended:
                    self._finish()
                    return
                if time.monotonic() - away > self.patience:
                    self._give_up(problem)
                    return
                time.sleep(_RETRY)
                continue
            connection.settimeout(None)
            _keep_alive(connection)
            if self.token is not None:
                with contextlib.suppress(OSError):  # broken off already: heard below
                    connection.sendall(_greeting(self.token))
            with self.changed:
                self.connection = connection
                for identity, (text, _) in list(self.waiting.items()):
                    self._put(f"{identity} {text}\n")
                if self.ended:
                    self._put("<end/>\n")
                self.changed.notify_all()
            if self._hear(connection):
                away = time.monotonic()
            elif time.monotonic() - away > self.patience:
                self._give_up(OSError(0, "it breaks off at once: does it want a --token?"))
                return
            else:
                time.sleep(_RETRY)
            if self.ended and not self.waiting:
                self._finish()
                return

    def _finish(self) -> None:
        with self.changed:
            self.farewell = True
            self.changed.notify_all()

    def _give_up(self, problem: OSError) -> None:
        with self.changed:
            lost = len(self.waiting)
            self.failed = OutputError(
                f"nobody answers at {self.host}:{self.port} for {self.patience:g} s ({problem.strerror or problem}); "
                f"messages not delivered: {lost}"
            )
            self.changed.notify_all()

    def _hear(self, connection: socket.socket) -> bool:
        """Answers, until the connection breaks; whether somebody was there: it answered, or held on for a while."""
        heard, began = False, time.monotonic()
        try:
            with connection.makefile("r", encoding="utf-8", errors="replace") as stream:
                for line in stream:
                    heard = heard or not line.startswith('<refused id=""')
                    if line.strip() == "<end/>":
                        self._finish()
                        break
                    self._heard(line)
        except OSError:  # broken off; `_keep_connected` tries again
            pass
        with self.changed:
            if self.connection is connection:
                self.connection = None
        connection.close()
        return heard or time.monotonic() - began > PATIENCE

    def _heard(self, line: str) -> None:
        try:
            element = element_of(line)
        except InputError:
            return  # not an answer; what waits will be asked for again
        with self.changed:
            waiting = self.waiting.pop(element.get("id", ""), None)
            self.changed.notify_all()
        if waiting is not None:
            refused = element.tag == "refused"
            waiting[1](element.text or "refused" if refused else None, element.get("module", ""))
