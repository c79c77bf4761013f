"""Commands, the library that explains them, and their translation into curves of face parameters (Frydrych et al.
2003).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches
from functools import cache
from pathlib import Path

from mien.core.assets import asset
from mien.core.errors import InputError, Note, unknown_name
from mien.text.library_file import CommandDefinition, ListedKey, read_library_file
from mien.text.parameter_curves import ParameterCurve
from mien.text.procedures import PROCEDURES, Request

__all__ = ["Command", "CommandLibrary", "shipped_library"]


@dataclass(frozen=True)
class Command:
    """A high-level command as it was given.

    Attributes
    ----------
    name : str
    attributes : tuple of (str, str)
        As written. ``at`` is in milliseconds from the start of the sound.
    where : str
        File and line, for messages.
    """

    name: str
    attributes: tuple[tuple[str, str], ...] = ()
    where: str = field(default="", compare=False)

    @property
    def given(self) -> dict[str, str]:
        """The attributes by name."""
        return dict(self.attributes)

    def with_(self, **attributes: str) -> Command:
        """The same command with some attributes set anew; those that were there keep their places."""
        return Command(self.name, tuple((self.given | attributes).items()), self.where)


class CommandLibrary:
    """Commands by name.

    Parameters
    ----------
    definitions : iterable of CommandDefinition
        A later one of the same name takes the place of an earlier one.

    Examples
    --------
    >>> curve, = shipped_library().translate(Command("HeadNod", (("at", "1000"), ("amplitude", "60")))).curves
    >>> curve.keys[1]
    (1166.5, 0.09)
    """

    def __init__(self, definitions: Iterable[CommandDefinition]) -> None:
        self.definitions: dict[str, CommandDefinition] = {}
        for definition in definitions:
            self.definitions[definition.name] = definition

    @classmethod
    def of(cls, *folders: str | Path) -> CommandLibrary:
        """The shipped library with the ``.txt`` files of further folders; a later folder goes before an earlier one.

        Raises
        ------
        InputError
            If a folder is missing or holds no ``.txt`` file, or a file has a fault: file, line, what was expected.
        """
        definitions = list(shipped_library().definitions.values())
        for folder in map(Path, folders):
            if not folder.is_dir():
                raise InputError(f"{folder}: expected a folder with command files (.txt)")
            found = _read_folder(folder)
            if not found:
                raise InputError(f"{folder}: no command file (.txt) in it")
            definitions += found
        return cls(definitions)

    def __contains__(self, name: object) -> bool:
        return name in self.definitions

    def __getitem__(self, name: str) -> CommandDefinition:
        if name not in self.definitions:
            near = get_close_matches(name, self.definitions, n=3)
            guess = f"did you mean {' or '.join(map(repr, near))}?" if near else "docs/commands.md lists them"
            raise InputError(f"unknown command {name!r}: {guess}")
        return self.definitions[name]

    @property
    def names(self) -> tuple[str, ...]:
        """All names, sorted."""
        return tuple(sorted(self.definitions))

    def check(self, command: Command) -> None:
        """Refuse a command that is not known, or parameters that it does not have; times are not looked at.

        Raises
        ------
        InputError
            With the nearest name that there is.
        """
        definition = self[command.name]
        for name in command.given:
            if name not in definition.parameters:
                raise unknown_name(f"parameter of {command.name}", name, definition.parameters)
        for name in definition.mandatory:
            if name not in command.given:
                raise InputError(f'{command.name} needs {name}=: give <{command.name} {name}="…"/>')
        for name, text in command.attributes:
            _number(command.name, name, text)

    def translate(self, command: Command) -> Translation:
        """A command as curves of face parameters.

        Raises
        ------
        InputError
            If the command is not known, or its parameters do not fit.
        """
        try:
            self.check(command)
            return _translated(self[command.name], command)
        except InputError as problem:
            if not command.where or str(problem).startswith(command.where):
                raise
            raise InputError(f"{command.where}: {problem}") from problem


@dataclass(frozen=True)
class Translation:
    """What became of a command: its curves, and what should be said about it."""

    curves: tuple[ParameterCurve, ...]
    notes: tuple[Note, ...] = ()


@cache
def shipped_library() -> CommandLibrary:
    """The library that comes with mien (``docs/commands.md`` lists it)."""
    return CommandLibrary(_read_folder(asset("commands")))


def _read_folder(folder: Path) -> list[CommandDefinition]:
    found: dict[str, CommandDefinition] = {}
    for path in sorted(folder.glob("*.txt")):
        for definition in read_library_file(path):
            if definition.name in found:
                raise InputError(
                    f"{definition.where}: {definition.name!r} is defined at {found[definition.name].where} too"
                )
            found[definition.name] = definition
    return list(found.values())


def _translated(definition: CommandDefinition, command: Command) -> Translation:
    given = {name: _number(command.name, name, text) for name, text in command.attributes}
    numbers = definition.optional | given
    at, scale = numbers.get("at", 0.0), numbers.get("amplitude", 100.0) / 100
    request = Request(command.name, numbers, given.keys())
    lists = {
        parameter: [(key.time, _value(key, numbers)) for key in keys] for parameter, keys in definition.lists.items()
    }
    expanded = PROCEDURES[definition.procedure].expand(lists, request)
    curves = tuple(
        ParameterCurve(
            parameter,
            tuple((round(at + time, 6), round(value * scale, 9) + 0.0) for time, value in keys),
            definition.interpolation,
            "set" if definition.mode == "set" else "add",
            definition.fade,
        )
        for parameter, keys in expanded.items()
    )
    return Translation(curves, _beaten(command, request))


def _value(key: ListedKey, numbers: Mapping[str, float]) -> float:
    return key.factor * (numbers[key.of] if key.of is not None else 1.0)


def _beaten(command: Command, request: Request) -> tuple[Note, ...]:
    """Given parameters that count for nothing because another one was given that beats them."""
    notes = []
    for winner, loser in (("period", "frequency"), ("count", "end")):
        if winner in request.given and loser in request.given:
            where = f"{command.where}: " if command.where else ""
            notes.append(Note("note", f"{where}{command.name}: {winner} was given, so {loser} does not count"))
    return tuple(notes)


def _number(command: str, name: str, text: str) -> float:
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise InputError(f"{command}: {name} is a number, not {text!r}")
    return number
