"""Running a module: messages in, what it makes of them out, refusals back and on."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable
from itertools import count
from threading import Lock
from xml.etree.ElementTree import Element

from mien.core.errors import InputError, MienError, Note
from mien.core.limits import is_whole
from mien.serve.modules.messages import Message
from mien.serve.modules.transport import Answer, Delivery, Sink, Source
from mien.serve.modules.xml_form import element_of, one_line

__all__ = ["Module", "Outcome", "refusal"]

Outcome = Iterable[str]
"""Lines that a module makes of one message."""


def refusal(module: str, line: int, reason: str) -> str:
    """The message that takes the place of a refused one, so that the modules after it know."""
    element = Element("refused", {"module": module, "line": str(line)})
    element.text = " ".join(reason.split())
    return one_line(element)


class Module:
    """One of the four programs.

    Parameters
    ----------
    name : str
    handle : callable
        Makes lines of a message, given its number in the stream; raises `MienError` to refuse it.
    source : Source
    sink : Sink
    say : callable, optional
        Takes lines for the person who runs it; the default writes to standard error.
    refusal_line : callable or None
        Makes the line that takes the place of a refused message, given module, line and reason; None where the sink
        has answers of its own (TCP), or nobody reads it.
    """

    def __init__(
        self,
        name: str,
        handle: Callable[[Message, int], Outcome],
        source: Source,
        sink: Sink,
        say: Callable[[str], None] | None = None,
        refusal_line: Callable[[str, int, str], str] | None = refusal,
    ) -> None:
        self.name, self.handle, self.source, self.sink = name, handle, source, sink
        self.say = say or (lambda line: print(f"mien {name}: {line}", file=sys.stderr, flush=True))
        self.refusal_line = refusal_line
        self.refused = 0
        self.handled = 0

    def run(self) -> int:
        """Until the source ends; 0, or 2 if a message was refused here or further on, or none came.

        Raises
        ------
        OutputError
            If the next module cannot be reached.
        """
        for number, delivery in zip(count(1), self.source.deliveries(), strict=False):
            self.handled += 1
            self._deal(delivery, delivery.number or number)
        self.sink.close()
        if not self.handled:
            self.say("error: nothing came in")
        return 2 if self.refused or not self.handled else 0

    def tell(self, notes: Iterable[Note]) -> None:
        """Notes, for the person who runs it."""
        for note in notes:
            self.say(f"{note.kind}: {note.message}")

    def _deal(self, delivery: Delivery, number: int) -> None:
        before = _refused_before(delivery.message)
        if before is not None:
            module, line, reason = before
            self._refuse(delivery, f"message {number} was refused before: by {module}, line {line}: {reason}", before)
            return
        try:
            lines = list(self.handle(delivery.message, number))
        except MienError as problem:
            line = delivery.message.line
            reason = " ".join(str(problem).split())
            self._refuse(delivery, f"line {line}: {reason}", (self.name, line, reason))
            return
        if lines:
            self._pass_on(lines, delivery)
        else:
            delivery.answer(None, self.name)

    def _refuse(self, delivery: Delivery, told: str, refused: tuple[str, int, str]) -> None:
        module, _, reason = refused
        self.refused += 1
        self.say(f"error: {told}")
        delivery.answer(reason, module)
        if self.refusal_line is not None:
            self.sink.send(self.refusal_line(*refused), delivery.identity, lambda *_: None)

    def _pass_on(self, lines: list[str], delivery: Delivery) -> None:
        answer = _Together(len(lines), self._answered(delivery))
        many = len(lines) > 1
        for part, line in enumerate(lines, start=1):
            identity = f"{delivery.identity}.{part}" if many else delivery.identity
            self.sink.send(line, identity, answer)

    def _answered(self, delivery: Delivery) -> Answer:
        def answer(reason: str | None, module: str) -> None:
            if reason is not None:
                self.refused += 1
                self.say(f"error: message of line {delivery.message.line} refused by {module}: {reason}")
            delivery.answer(reason, module or self.name)

        return answer


class _Together:
    """Answers once for several messages: well if all went well, else with the first refusal."""

    def __init__(self, parts: int, answer: Answer) -> None:
        self.left, self.answer = parts, answer
        self.problem: tuple[str | None, str] = (None, "")
        self.lock = Lock()

    def __call__(self, reason: str | None, module: str) -> None:
        with self.lock:
            self.left -= 1
            if reason is not None and self.problem[0] is None:
                self.problem = reason, module
            last = self.left == 0
        if last:
            self.answer(*self.problem)


def _refused_before(message: Message) -> tuple[str, int, str] | None:
    """Module, line and reason, if the message stands in the place of a refused one."""
    if not message.text.lstrip().startswith("<refused"):
        return None
    try:
        element = element_of(message.text)
    except InputError:
        return None
    if element.tag != "refused":
        return None
    line = element.get("line", "0")
    return element.get("module", "a module"), int(line) if is_whole(line) else 0, element.text or "no reason given"
