"""The first page a person sees, near misses, and the lists of what there is to choose from."""

from __future__ import annotations

import argparse
import re
import shlex
from collections.abc import Iterator

import pytest

from mien.cli import list_commands
from mien.cli.help_page import GROUPS
from mien.cli.main import _parser, main
from mien.core.assets import asset_table
from mien.formats import exporters
from mien.speech.voices import catalogue


def commands() -> set[str]:
    groups = [action for action in _parser()._actions if isinstance(action, argparse._SubParsersAction)]
    return set(groups[0].choices)


def test_every_command_stands_on_the_page_once_and_grouped(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["--help"])
    page = capsys.readouterr().out
    shown = [line.split()[0] for line in page.splitlines() if line.startswith("  ") and not line.startswith("   ")]
    listed = [name for name in shown if name != "mien"]
    assert sorted(listed) == sorted(commands())
    assert {name for names in GROUPS.values() for name in names} <= commands()
    assert page.index("say ") < page.index("interpret ")


def test_every_command_shows_examples_that_it_understands() -> None:
    table = asset_table("help/examples.toml")
    assert set(table) == set(leaves(_parser()))
    for name, lines in table.items():
        assert len(set(lines)) >= 3, name
        assert f"mien {name}" in lines[0]
        for line in lines:
            for one in re.split(r" \| | && ", line):
                words = shlex.split(re.sub(r" > \S+$", "", one))
                if words[0] == "mien" and words[1] != "help":
                    _parser().parse_args(words[1:])


def leaves(parser: argparse.ArgumentParser, *above: str) -> Iterator[str]:
    below = [action for action in parser._actions if isinstance(action, argparse._SubParsersAction)]
    for action in below:
        for name, one in action.choices.items():
            yield from leaves(one, *above, name)
    if not below:
        yield " ".join(above)


@pytest.mark.parametrize(
    ("typed", "meant"),
    [
        (["sya", "hello"], "did you mean 'say'?"),
        (["say", "hello", "-o", "x.csv", "--emotoin", "sad"], "did you mean --emotion?"),
        (["corpus", "improt"], "did you mean 'import'?"),
        (["help", "sya"], "did you mean 'say'?; see mien --help"),
        (["zzzz"], "there is no command 'zzzz'; see mien --help"),
    ],
)
def test_near_misses_are_suggested_in_one_line(
    typed: list[str], meant: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.argv", ["mien", *typed])
    with pytest.raises(SystemExit) as left:
        main(typed)
    assert left.value.code == 2
    told = capsys.readouterr().err
    assert meant in told
    assert told.count("\n") == 1


def test_lists_come_from_the_registries(capsys: pytest.CaptureFixture[str]) -> None:
    expected = {
        "formats": [exporter.suffix for exporter in exporters()],
        "voices": [voice.name for voice in catalogue()],
        "emotions": ["neutral", "happy", "afraid"],
        "languages": ["en", "fi", "de", "es"],
        "faces": ["default"],
        "performers": ["default"],
    }
    assert set(expected) == set(list_commands.LISTS)
    for name, values in expected.items():
        assert main([name]) == 0
        first = [line.split()[0] for line in capsys.readouterr().out.splitlines()]
        assert set(values) <= set(first)


def test_help_of_a_command(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        main(["help", "say"])
    assert left.value.code == 0
    assert "usage: mien say" in capsys.readouterr().out
