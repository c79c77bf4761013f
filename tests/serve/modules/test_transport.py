from __future__ import annotations

import socket
import threading
import time
from collections.abc import Iterator

import pytest

from mien.core.errors import InputError, OutputError
from mien.serve.modules.handlers import output_path, refusal_frame
from mien.serve.modules.messages import Messages
from mien.serve.modules.running import Module
from mien.serve.modules.transport import Delivery, Listener, Sender, parse_address


def listener(port: int = 0, stay: bool = False) -> Listener:
    return Listener("127.0.0.1", port, lambda: Messages({"HeadNod"}), stay)


def collect(source: Listener, into: list[str], answer: bool = True) -> threading.Thread:
    def work() -> None:
        for delivery in source.deliveries():
            into.append(delivery.message.text)
            if answer:
                delivery.answer(None, "test")

    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    return thread


def test_messages_arrive_in_order_and_are_answered() -> None:
    heard: list[str] = []
    answers: list[str] = []
    source = listener()
    thread = collect(source, heard)
    sender = Sender("127.0.0.1", source.port)
    for number in range(50):
        sender.send(
            f'<m n="{number}"/>', f"abcdef01:{number}", lambda reason, module, n=number: answers.append(f"{n}{reason}")
        )
    sender.close()
    thread.join(5)
    assert heard == [f'<m n="{number}"/>' for number in range(50)]
    assert answers == [f"{number}None" for number in range(50)]


def test_what_other_machines_can_reach_wants_a_token() -> None:
    with pytest.raises(InputError, match="give --token"):
        Listener("0.0.0.0", 0, lambda: Messages(()))
    heard: list[str] = []
    source = Listener("127.0.0.1", 0, lambda: Messages(()), token="a token <&")
    thread = collect(source, heard)
    with socket.create_connection(("127.0.0.1", source.port)) as stranger:
        stranger.sendall(b"<token>another </token>\n<m/>\n")
        assert b"refused" in stranger.recv(100)
    sender = Sender("127.0.0.1", source.port, token="a token <&")
    sender.send("<m/>", "abcdef01:1", lambda *_: None)
    sender.close()
    thread.join(5)
    assert heard == ["<m/>"]


def test_a_sender_without_the_token_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mien.serve.modules.transport.PATIENCE", 0.2)
    source = Listener("127.0.0.1", 0, lambda: Messages(()), token="12345678")
    collect(source, heard := [])
    sender = Sender("127.0.0.1", source.port, patience=0.5)
    sender.send("<m/>", "abcdef01:1", lambda *_: None)
    with pytest.raises(OutputError, match="does it want a --token"):
        sender.close()
    assert heard == []


def test_long_messages_cost_what_they_hold() -> None:
    for head, line in (
        ("<speak>", "<x/>"),
        ("<!-- a", "b -- c"),
        ("<?xml version='1'?>", "<!-- a -->"),
        ("<N a='", "b"),
    ):
        messages = Messages({"N"}, texts=True)
        assert [m for text in (head, *[line] * 30_000) for m in messages.take(text)] == []


def test_a_receiver_that_does_not_answer_holds_the_sender_up() -> None:
    heard: list[str] = []
    source = listener()
    collect(source, heard, answer=False)
    sender, sent = Sender("127.0.0.1", source.port, window=3), []

    def work() -> None:
        for number in range(20):
            sender.send("<m/>", f"abcdef01:{number}", lambda *_: None)
            sent.append(number)

    threading.Thread(target=work, daemon=True).start()
    time.sleep(0.4)
    assert len(sent) == 3
    assert len(heard) == 3


def test_what_was_not_answered_is_sent_again_when_the_module_is_back() -> None:
    first = listener()
    port = first.port
    sender = Sender("127.0.0.1", port)
    answered: list[int] = []

    def work() -> None:
        for number in range(10):
            sender.send(f"<m{number}/>", f"abcdef01:{number}", lambda reason, module, n=number: answered.append(n))
        sender.close()

    worker = threading.Thread(target=work, daemon=True)
    worker.start()
    deliveries = first.deliveries()
    for number in range(3):  # two are dealt with, the third was read and dies with the module
        delivery = next(deliveries)
        assert delivery.message.text == f"<m{number}/>"
        if number < 2:
            delivery.answer(None, "test")
    time.sleep(0.1)
    first.server.close()
    assert first.connection is not None
    first.connection.shutdown(socket.SHUT_RDWR)
    first.connection.close()
    heard: list[str] = []
    collect(listener(port), heard)
    worker.join(10)
    assert not worker.is_alive()
    assert heard == [f"<m{number}/>" for number in range(2, 10)]
    assert answered == list(range(10))


def test_a_message_is_dealt_with_once_though_its_answer_was_lost() -> None:
    source = listener()
    heard: list[str] = []
    collect(source, heard)
    for _ in range(2):
        with socket.create_connection(("127.0.0.1", source.port)) as connection:
            connection.sendall(b"abcdef01:1 <m/>\n")
            assert connection.makefile().readline() == '<done id="abcdef01:1"/>\n'
    assert heard == ["<m/>"]


def test_half_a_line_of_a_sender_that_died_is_not_taken_for_a_message() -> None:
    source = listener()
    heard: list[str] = []
    collect(source, heard)
    with socket.create_connection(("127.0.0.1", source.port)) as connection:
        connection.sendall(b"abcdef01:1 <m/>\nabcdef01:2 <m>hal")
    with socket.create_connection(("127.0.0.1", source.port)) as connection:
        connection.sendall(b"abcdef01:2 <m>half</m>\n<end/>\n")
        while connection.recv(100):
            pass
    assert heard == ["<m/>", "<m>half</m>"]


def test_a_sender_without_identities_such_as_nc() -> None:
    source = listener()
    heard: list[str] = []
    collect(source, heard)
    with socket.create_connection(("127.0.0.1", source.port)) as connection:
        connection.sendall(b'<HeadNod at="0"\ncount="2">\n<end/>\n')
        assert connection.makefile().readline().startswith("<done id=")
    assert heard == ['<HeadNod at="0"\ncount="2"/>']


def test_nobody_there() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        port = taken.getsockname()[1]
    sender = Sender("127.0.0.1", port, patience=0.3)
    sender.send("<m/>", "abcdef01:1", lambda *_: None)
    with pytest.raises(OutputError, match=r"nobody answers at 127.0.0.1:.* messages not delivered: 1"):
        sender.close()


def test_a_port_that_is_taken() -> None:
    source = listener()
    with pytest.raises(InputError, match="cannot listen at"):
        listener(source.port)


@pytest.mark.parametrize("text", ["", "seven", "host:", "1:2:x", "70000"])
def test_an_address_that_is_none(text: str) -> None:
    with pytest.raises(InputError, match="an address is PORT or HOST:PORT"):
        parse_address(text)


class _Given:
    def __init__(self, *texts: str) -> None:
        self.texts, self.answers = texts, []

    def deliveries(self) -> Iterator[Delivery]:
        messages = Messages(())
        for text in self.texts:
            for message in messages.take(text):
                yield Delivery(message, "", lambda reason, module: self.answers.append((reason, module)))


class _Kept:
    def __init__(self) -> None:
        self.lines: list[str] = []

    def send(self, text: str, identity: str, answer: object) -> None:
        self.lines.append(text)
        answer(None, "")  # type: ignore[operator]

    def close(self) -> None: ...


def test_a_refusal_is_told_passed_on_and_ends_with_two() -> None:
    def handle(message: object, number: int) -> list[str]:
        if number == 2:
            raise InputError("no good:\n see here")
        return [f"<out{number}/>"]

    source, sink, told = _Given("<a/>", "<b/>", "<c/>"), _Kept(), []
    assert Module("translate", handle, source, sink, told.append).run() == 2
    assert sink.lines == ["<out1/>", '<refused module="translate" line="2">no good: see here</refused>', "<out3/>"]
    assert source.answers == [(None, "translate"), ("no good: see here", "translate"), (None, "translate")]
    assert told == ["error: line 2: no good: see here"]
    after, last, told = _Given(*sink.lines), _Kept(), []
    assert Module("perform", lambda m, n: ["frame"], after, last, told.append, refusal_line=refusal_frame).run() == 2
    assert last.lines == [
        "frame",
        '{"refused": "no good: see here", "module": "translate", "line": 2}',
        "frame",
    ]
    assert told == ["error: message 2 was refused before: by translate, line 2: no good: see here"]


def test_an_empty_stream_is_told() -> None:
    told: list[str] = []
    assert Module("speak", lambda m, n: [], _Given(), _Kept(), told.append).run() == 2
    assert told == ["error: nothing came in"]


def test_a_message_keeps_its_number_when_it_is_sent_again() -> None:
    numbers: list[int] = []
    source = listener()

    def work() -> None:
        Module("perform", lambda m, n: numbers.append(n) or [], source, _Kept(), [].append).run()

    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    with socket.create_connection(("127.0.0.1", source.port)) as connection:
        connection.sendall(b"abcdef01:7 <m/>\nabcdef01:8 <m/>\n<end/>\n")
        while connection.recv(100):
            pass
    thread.join(5)
    assert numbers == [7, 8]


def test_no_file_takes_the_place_of_another() -> None:
    first = output_path("line.mp4", "1", "aa", ())
    with pytest.raises(InputError, match=r"put \{id\} in the name"):
        output_path("line.mp4", "2", "aa", {first})
    second = output_path("line-{id}.mp4", "1", "aa", ())
    with pytest.raises(InputError, match=r"put \{sender\} in the name"):
        output_path("line-{id}.mp4", "1", "bb", {second})
    assert output_path("line-{sender}-{id}.mp4", "1", "bb", {second}).name == "line-bb-1.mp4"
    with pytest.raises(InputError, match="cannot be part of a file name"):
        output_path("line-{id}.mp4", "../x", "aa", ())
