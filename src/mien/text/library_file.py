"""Reading a file of the command library (Frydrych et al. 2003, section 2.3).

::

    # a comment
    $command = HeadNod
    $mandatory = at
    $optional = amplitude=100, count=1,
    period=500,
    frequency=1, end=1000
    $interp = linear
    amplitude = 0,0; 333,0.15; 666,0;
    833,-0.025; 1000,0
    $proc = periodic

A statement goes on in the next line after ``,`` or ``;``, as in the paper's own example. A line that starts with
``NAME =`` gives the times and values of a face parameter; ``amplitude =`` is the parameter named like the command. A
file may hold several commands: each ``$command`` begins one.

Beyond the paper: a value may be a parameter of the command, with a factor or without (``300,yaw`` or ``300,0.5*yaw``);
``$mode = set`` lets the command take the place of other motion, ``$fade`` says over how many ms; ``$about`` is a line
of documentation.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path

from mien.core.border import guarded
from mien.core.errors import InputError, unknown_name
from mien.core.plain_text import read_plain_text
from mien.text.face_parameters import face_parameter
from mien.text.parameter_curves import INTERPOLATIONS, MODES
from mien.text.procedures import PROCEDURES

__all__ = ["CommandDefinition", "ListedKey", "parse_library", "read_library_file"]

_NAME = re.compile(r"[A-Za-z_][\w.-]*")
_STATEMENTS = ("command", "mandatory", "optional", "interp", "proc", "mode", "fade", "about")


@dataclass(frozen=True)
class ListedKey:
    """One pair of a time-value list: the value is ``factor`` times parameter ``of``, or ``factor`` alone."""

    time: float
    factor: float
    of: str | None = None


@dataclass(frozen=True)
class CommandDefinition:
    """One command of the library.

    Attributes
    ----------
    name : str
    mandatory : tuple of str
    optional : dict of str to float
        Defaults.
    interpolation : str
    lists : dict of str to tuple of ListedKey
        By face parameter; ms from the command's start.
    procedure : str
    where : str
        File and line of its ``$command``.
    mode, fade
        As in `mien.text.parameter_curves.ParameterCurve`.
    about : str
    """

    name: str
    where: str
    mandatory: tuple[str, ...] = ()
    optional: dict[str, float] = field(default_factory=dict)
    interpolation: str = "linear"
    lists: dict[str, tuple[ListedKey, ...]] = field(default_factory=dict)
    procedure: str = ""
    mode: str = "add"
    fade: float = 0.0
    about: str = ""

    @property
    def parameters(self) -> tuple[str, ...]:
        """All that may be given to it."""
        return (*self.mandatory, *self.optional)


@dataclass(frozen=True)
class _Statement:
    key: str
    value: str
    where: str


@guarded("a file of commands")
def read_library_file(path: str | Path) -> tuple[CommandDefinition, ...]:
    """All commands of a file.

    Raises
    ------
    InputError
        Naming the file and the line.
    """
    return parse_library(read_plain_text(path, "commands")[0], str(path))


def parse_library(text: str, source: str = "library") -> tuple[CommandDefinition, ...]:
    """All commands of a text in the form of a library file.

    Examples
    --------
    >>> nod, = parse_library('''$command = Nod
    ... $mandatory = at
    ... $interp = linear
    ... HeadNod = 0,0; 300,0.1; 600,0
    ... $proc = once''')
    >>> nod.lists["HeadNod"][1]
    ListedKey(time=300.0, factor=0.1, of=None)
    """
    found: dict[str, CommandDefinition] = {}
    current: list[_Statement] = []
    for statement in _statements(text, source):
        if statement.key == "$command" and current:
            _add(found, current)
            current = []
        if not current and statement.key != "$command":
            raise InputError(f"{statement.where}: expected '$command = NAME' first, got {statement.key!r}")
        current.append(statement)
    if not current:
        raise InputError(f"{source}, line 1: expected '$command = NAME', got no command at all")
    _add(found, current)
    return tuple(found.values())


def _add(found: dict[str, CommandDefinition], statements: list[_Statement]) -> None:
    definition = _definition(statements)
    if definition.name in found:
        raise InputError(
            f"{definition.where}: {definition.name!r} is defined before, at {found[definition.name].where}"
        )
    found[definition.name] = definition


def _statements(text: str, source: str) -> Iterator[_Statement]:
    """Logical lines: a line that ends in a comma or semicolon goes on in the next."""
    parts: list[str] = []
    started = ended = 0
    for number, raw in enumerate(text.splitlines(), start=1):
        line = raw.partition("#")[0].strip()
        if not line:
            continue
        going_on = bool(parts) and parts[-1].endswith((",", ";"))
        if going_on and re.match(r"\$\s*\w+\s*=", line):
            parts[-1] = parts[-1].rstrip(",; ")  # a list that ends in a semicolon
            going_on = False
        if going_on and parts[-1].endswith(";") and _begins_list(line):
            parts[-1] = parts[-1].rstrip("; ")
            going_on = False
        if parts and not going_on:
            yield _statement(" ".join(parts), _place(source, started, ended))
            parts = []
        if not parts:
            started = number
        parts.append(line)
        ended = number
    if parts:
        yield _statement(" ".join(parts), _place(source, started, ended))


def _place(source: str, first: int, last: int) -> str:
    return f"{source}, line {first}" if first == last else f"{source}, lines {first} to {last}"


def _begins_list(line: str) -> bool:
    """Whether a line is ``NAME = time,value...`` rather than more pairs of the list before it."""
    return re.match(r"[A-Za-z_][\w.-]*\s*=", line) is not None


def _statement(line: str, where: str) -> _Statement:
    key, equals, value = (part.strip() for part in line.partition("="))
    if not equals or not key:
        raise InputError(f"{where}: expected '$key = value' or 'NAME = time,value; ...', got {_short(line)!r}")
    key = key.replace("$ ", "$").rstrip(",; ")
    if not key.startswith("$") and not _NAME.fullmatch(key):
        raise InputError(
            f"{where}: expected '$key = value' or 'NAME = time,value; ...', got {_short(line)!r}; "
            "does the line before lack a ',' or ';' at its end?"
        )
    if key.startswith("$") and key[1:] not in _STATEMENTS:
        raise InputError(f"{where}: {unknown_name('statement', key, [f'${name}' for name in _STATEMENTS])}")
    if not value:
        raise InputError(f"{where}: nothing stands after {key!r} =")
    return _Statement(key, value.rstrip(",; "), where)


def _definition(statements: list[_Statement]) -> CommandDefinition:
    """One command of its statements, checked as a whole."""
    seen: dict[str, _Statement] = {}
    for statement in statements:
        if statement.key in seen:
            raise InputError(
                f"{statement.where}: {statement.key!r} stands there twice, first at {seen[statement.key].where}"
            )
        seen[statement.key] = statement
    first = statements[0]
    definition = CommandDefinition(_one_name(first), first.where)
    for statement in statements[1:]:
        definition = _with(definition, statement)
    return _checked(definition)


def _with(definition: CommandDefinition, statement: _Statement) -> CommandDefinition:
    value, where = statement.value, statement.where
    match statement.key:
        case "$mandatory":
            return replace(definition, mandatory=tuple(_name(part, where) for part in _parts(value, ",")))
        case "$optional":
            return replace(definition, optional=_defaults(value, where))
        case "$interp":
            return replace(definition, interpolation=_one_of(value, "interpolation", INTERPOLATIONS, where))
        case "$proc":
            return replace(definition, procedure=_one_of(value, "procedure", tuple(PROCEDURES), where))
        case "$mode":
            return replace(definition, mode=_one_of(value, "mode", MODES, where))
        case "$fade":
            return replace(definition, fade=_number(value, where))
        case "$about":
            return replace(definition, about=value)
        case name:
            keys = _list(value, where)
            parameter = definition.name if name == "amplitude" else name
            try:
                face_parameter(parameter)
            except InputError as problem:
                raise InputError(f"{where}: {problem}") from problem
            return replace(definition, lists=definition.lists | {parameter: keys})


def _parts(text: str, separator: str) -> list[str]:
    return [part.strip() for part in text.split(separator) if part.strip()]


def _name(text: str, where: str) -> str:
    if not _NAME.fullmatch(text):
        raise InputError(f"{where}: expected a name, got {_short(text)!r}")
    return text


def _one_name(statement: _Statement) -> str:
    return _name(statement.value, statement.where)


def _one_of(value: str, what: str, known: tuple[str, ...], where: str) -> str:
    if value not in known:
        raise InputError(f"{where}: {unknown_name(what, value, known)}")
    return value


def _number(text: str, where: str) -> float:
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise InputError(f"{where}: expected a number, got {_short(text)!r}")
    return number


def _defaults(text: str, where: str) -> dict[str, float]:
    found: dict[str, float] = {}
    for part in _parts(text, ","):
        name, equals, number = (piece.strip() for piece in part.partition("="))
        if not equals:
            raise InputError(f"{where}: expected name=default, got {_short(part)!r}")
        if _name(name, where) in found:
            raise InputError(f"{where}: {name!r} has two defaults")
        found[name] = _number(number, where)
    return found


def _list(text: str, where: str) -> tuple[ListedKey, ...]:
    keys = []
    for part in _parts(text, ";"):
        numbers = [piece.strip() for piece in part.split(",")]
        if len(numbers) != 2:
            hint = "does the line before lack a ',' at its end?" if "=" in part else "pairs are separated by ';'"
            raise InputError(f"{where}: expected a pair time,value, got {_short(part)!r}; {hint}")
        keys.append(ListedKey(_number(numbers[0], where), *_value(numbers[1], where)))
    if not keys:
        raise InputError(f"{where}: expected pairs time,value; ..., got none")
    if keys[0].time < 0:
        raise InputError(f"{where}: times count from the command's start, 0 or more, not {keys[0].time:g}")
    for before, after in pairwise(keys):
        if after.time < before.time:
            raise InputError(f"{where}: times run backwards: {after.time:g} comes after {before.time:g}")
    return tuple(keys)


def _value(text: str, where: str) -> tuple[float, str | None]:
    if _NAME.fullmatch(text) and text.lower() not in ("nan", "inf", "infinity"):
        return 1.0, text
    if text[:1] == "-" and _NAME.fullmatch(text[1:].strip()) and text[1:].strip().lower() not in ("nan", "inf"):
        return -1.0, text[1:].strip()
    number, times, name = (piece.strip() for piece in text.partition("*"))
    return (_number(number, where), _name(name, where)) if times else (_number(text, where), None)


def _checked(definition: CommandDefinition) -> CommandDefinition:
    where, name = definition.where, definition.name
    if not definition.lists:
        raise InputError(f"{where}: {name!r} moves nothing: give a list such as 'HeadNod = 0,0; 300,0.1; 600,0'")
    if not definition.procedure:
        raise InputError(f"{where}: {name!r} lacks '$proc = NAME'; known: {', '.join(PROCEDURES)}")
    if max(keys[-1].time for keys in definition.lists.values()) <= 0:
        raise InputError(f"{where}: the lists of {name!r} last no time at all")
    twice = set(definition.mandatory) & set(definition.optional)
    if twice:
        raise InputError(f"{where}: {sorted(twice)[0]!r} of {name!r} is both mandatory and optional")
    for group in PROCEDURES[definition.procedure].needs:
        if not set(group) & set(definition.parameters):
            raise InputError(
                f"{where}: procedure {definition.procedure!r} of {name!r} needs the parameter {' or '.join(group)}"
            )
    understood = {"at", "amplitude", *PROCEDURES[definition.procedure].uses, *_used_in_lists(definition)}
    idle = [parameter for parameter in definition.parameters if parameter not in understood]
    if idle:
        raise InputError(
            f"{where}: parameter {idle[0]!r} of {name!r} does nothing: {definition.procedure!r} understands "
            f"{', '.join(PROCEDURES[definition.procedure].uses)}"
        )
    unknown = _used_in_lists(definition) - set(definition.parameters)
    if unknown:
        raise InputError(
            f"{where}: {unknown_name(f'parameter in the lists of {name}', min(unknown), definition.parameters)}"
        )
    return definition


def _used_in_lists(definition: CommandDefinition) -> set[str]:
    return {key.of for keys in definition.lists.values() for key in keys if key.of is not None}


def _short(text: str) -> str:
    return text if len(text) <= 50 else text[:49] + "…"
