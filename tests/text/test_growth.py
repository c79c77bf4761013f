"""Texts are read in time linear in their length, whatever they hold.

Every case is as long as a file may reasonably be and gets processor seconds that a linear reader does not use by far,
and that one whose work grows with the square would need many times over: 10 s, where 0.1 to 2 s are used.
"""

from __future__ import annotations

import multiprocessing
import resource
from collections.abc import Callable
from pathlib import Path

import pytest

from mien.core.errors import InputError
from mien.formats.textgrid import read_textgrid
from mien.text.intensity import read_intensity
from mien.text.languages.reading import read_words
from mien.text.library_file import parse_library
from mien.text.normalisation import spoken_words
from mien.text.script_reading import read_script

CPU_SECONDS = 10


def _limited(work: Callable[[], object]) -> None:
    resource.setrlimit(resource.RLIMIT_CPU, (CPU_SECONDS, CPU_SECONDS + 1))
    try:
        work()
    except InputError as problem:
        if len(str(problem)) > 2000 or "\n" in str(problem):
            raise SystemExit(3) from problem


def ends_in_time(work: Callable[[], object]) -> None:
    """Do it in a process of its own; it may refuse its input, but must come to an end."""
    process = multiprocessing.get_context("fork").Process(target=_limited, args=(work,))
    process.start()
    process.join()
    assert process.exitcode == 0


SCRIPTS = {
    "comments": lambda n: "<!---->" * n + "Hello.",
    "comments before XML": lambda n: "<!---->" * n + "<speak>Hello.</speak>",
    "half comments": lambda n: "<!--" * n,
    "declarations": lambda n: "<?xml ?>" * n,
    "document types": lambda n: "<!DOCTYPE" * n,
    "blanks": lambda n: " " * 10 * n + "a" + " " * 10 * n,
    "angles": lambda n: "<" * n,
    "half tags": lambda n: "<a " * n,
    "half known tags": lambda n: "<emotion " * n,
    "unknown tags": lambda n: "a<b>c " * n,
    "different unknown tags": lambda n: " ".join(f"<b{i}>" for i in range(n)),
    "attributes": lambda n: "<a " + 'x="1" ' * n,
    "levels": lambda n: '<emotion name="happy">' * n,
    "commands": lambda n: "word <HeadNod/> " * n,
    "entities": lambda n: "&amp;" * n,
    "half entities": lambda n: "&" * n,
    "levels of XML": lambda n: "<speak>" + "<p>" * n,
    "sentences of XML": lambda n: "<speak>" + "<s>a</s>" * n + "</speak>",
    "namespaces": lambda n: "<speak " + " ".join(f'xmlns:a{i}="x"' for i in range(n)) + ">" + "<s>a</s>" * n,
    "marks": lambda n: "".join(f'<mark name="m{i}"/>w ' for i in range(n)),
    "BML": lambda n: "<bml>" + "".join(f'<head id="a{i}" lexeme="NOD"/>' for i in range(n)) + "</bml>",
}
TEXTS = {
    "digits": "1", "letters": "a", "capitals": "A", "dots": "a.", "numbers with commas": "1,", "decimals": "1.",
    "hyphens": "a-", "apostrophes": "a'", "addresses": "a@", "slashes": "1/", "money": "$1", "times": "1:",
    "dates": "1-2-", "telephones": "555-", "underlines": "a_", "brackets": "(", "quotes": '"', "signs": "#",
    "Roman numbers": "II ", "saints": "St. ", "doctors": "Dr. ", "initials": "A.", "words": "read ", "lines": "\n",
    "accents": "e\u0301", "emoji": "\U0001f444", "net": "http://", "thousands": "1 000 ", "stops": "!?", "dashes": "-",
}  # fmt: skip


@pytest.mark.parametrize("name", SCRIPTS)
def test_scripts(name: str) -> None:
    ends_in_time(lambda: read_script(SCRIPTS[name](8_000)))


@pytest.mark.parametrize("name", TEXTS)
def test_normalisation(name: str) -> None:
    ends_in_time(lambda: spoken_words(TEXTS[name] * 20_000 + " end"))


@pytest.mark.parametrize("piece", ["$command = Nod\n", "a = 0,0; ", "$", ";", "1,1;", "\n", "[", "x"])
def test_libraries_of_commands(piece: str) -> None:
    ends_in_time(lambda: parse_library(piece * 30_000))


@pytest.mark.parametrize("piece", ['"', "1 ", "<exists>", '""', "-", "1e", "<", '"a" 1 ', "!"])
def test_textgrids(piece: str, tmp_path: Path) -> None:
    head = 'File type = "ooTextFile"\nObject class = "TextGrid"\n'
    (tmp_path / "a.TextGrid").write_text(head + piece * 100_000, encoding="utf-8")
    ends_in_time(lambda: read_textgrid(tmp_path / "a.TextGrid"))


@pytest.mark.parametrize("piece", ["1,", '"', "0.1,0.5\n", ",", "#\n"])
def test_tables(piece: str, tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(piece * 100_000, encoding="utf-8")
    ends_in_time(lambda: read_intensity(tmp_path / "a.csv"))


def test_a_speller_of_numbers_does_not_stumble() -> None:
    long = "9" * 5000
    forms = ("{} km", "{}th", "{}½", "${}.50", "1/{}", "{} 1/2", "{}0s", "{}%", "{}.{}", "chapter {}", "+{}", "{}-{}")
    for form in forms:
        assert len(spoken_words(form.format(long, long)).words) >= 5000


def test_more_than_four_hours_of_text_are_refused_at_once() -> None:
    for language in (None, "fi"):
        with pytest.raises(InputError, match=r"^the text: 4,000,000 characters .*MIEN_MOST_SPOKEN"):
            read_words("Oh no. " * 571_428 + "Well", language)
