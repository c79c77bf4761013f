"""mien's own elements, and the table of all: `ELEMENTS`."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from functools import cache

from mien.core.assets import asset_table
from mien.core.errors import InputError, unknown_name
from mien.text.commands import Command
from mien.text.effort_spans import AS_RECORDED, EffortCurve
from mien.text.face_parameters import face_parameter
from mien.text.intensity import parse_span_intensity, parse_span_values
from mien.text.parameter_curves import INTERPOLATIONS, MODES
from mien.text.parameter_values import Given, needed, number, only
from mien.text.script import DirectedCommand, DirectedCurve, DirectedEffort, DirectedEmotion
from mien.text.script_builder import Builder, OpenEmotion
from mien.text.sync_points import Moment, clock
from mien.text.vocal_elements import VOCAL_ELEMENTS

__all__ = ["ELEMENTS", "gaze_targets"]

BREAKS = {"none": 0.0, "x-weak": 100.0, "weak": 200.0, "medium": 400.0, "strong": 700.0, "x-strong": 1000.0}
"""Milliseconds by SSML's strengths. Hand-made: the specification leaves them to the voice."""


def _root(builder: Builder, given: Given) -> None:
    if len(builder.opened) > 1 or builder.segments or builder.text.strip():
        raise InputError(f"<{builder.opened[-1].event.text}> is the root of a document and stands around everything")
    names = ("version", "voice", "language", "startmark", "endmark", "onlangfailure")
    only(given, *names, "schemaLocation")
    builder.language = given.get("language") or given.get("xml:lang")
    builder.script_voice = given.get("voice")
    for name in ("startmark", "endmark", "onlangfailure"):
        if name in given:
            builder.note(f"{name} is not followed: everything is spoken")


def _emotion(builder: Builder, given: Given) -> None:
    only(given, "name", "intensity")
    name, intensity = needed(given, "name").lower(), parse_span_intensity(given.get("intensity", "1"))
    here = builder.point()
    _interrupt(builder, here)
    points = intensity if isinstance(intensity, tuple) else ()
    held = 1.0 if isinstance(intensity, tuple) else intensity
    builder.emotions.append(OpenEmotion(name, held, points, here, here))

    def close() -> None:
        here = builder.point(after=True)
        _interrupt(builder, here)
        closed = builder.emotions.pop()
        keys = tuple((point.moment(closed.start, here), point.value) for point in closed.points)
        for piece in closed.pieces:
            builder.done_emotions[piece] = replace(builder.done_emotions[piece], keys=keys)
        if builder.emotions:
            builder.emotions[-1].goes_on = here

    builder.opened[-1].close = close


def _interrupt(builder: Builder, here: Moment) -> None:
    """The innermost emotion counts: the one around it ends here, and goes on after it."""
    if builder.emotions:
        outer = builder.emotions[-1]
        outer.pieces.append(len(builder.done_emotions))
        builder.done_emotions.append(DirectedEmotion(outer.name, outer.intensity, outer.goes_on, here))


def _effort(builder: Builder, given: Given) -> None:
    """How hard what it holds is articulated; the innermost counts."""
    only(given, "level")
    level = parse_span_values(needed(given, "level"), EffortCurve)
    start, place = builder.point(), len(builder.efforts)
    held = AS_RECORDED if isinstance(level, tuple) else level
    builder.efforts.append(DirectedEffort(held, start, start))

    def close() -> None:
        end = builder.point(after=True)
        keys = tuple((point.moment(start, end), point.value) for point in level) if isinstance(level, tuple) else ()
        builder.efforts[place] = DirectedEffort(held, start, end, keys)

    builder.opened[-1].close = close


def _pause(builder: Builder, given: Given) -> None:
    only(given, "time", "ms", "seconds", "strength")
    if "seconds" in given:
        length = clock(f"{given['seconds']}s", "a pause")
    elif "time" in given or "ms" in given:
        length = clock(given.get("time") or given["ms"], "a pause")
    else:
        strength = given.get("strength", "medium")
        if strength not in BREAKS:
            raise unknown_name("strength of a break", strength, BREAKS)
        length = BREAKS[strength]
    if length > 600_000:
        raise InputError(f"a pause lasts at most ten minutes, not {length / 1000:g} s")
    before = builder.silence if not builder.text.strip() else None
    if before is None:
        builder.end_segment()
    builder.silence = (before or 0.0) + length


def _mark(builder: Builder, given: Given) -> None:
    only(given, "name")
    name = needed(given, "name")
    if name in ("start", "end", "here", "word", "phone"):
        builder.note(f"a mark cannot be called {name!r}, which has a meaning of its own; it is left out")
    elif re.fullmatch(r"[A-Za-z_][\w:-]*", name) is None:
        builder.note(f"a mark's name is a word such as m1; {name!r} is left out")
    else:
        builder.point(name=name)


@cache
def gaze_targets() -> dict[str, list[float]]:
    """Degrees (yaw, pitch) of targets by name."""
    found: dict[str, list[float]] = asset_table("performance/gaze_targets.toml")
    return found


def _gaze(builder: Builder, given: Given) -> None:
    only(given, "target", "yaw", "pitch", "at", "until", "duration")
    yaw, pitch = 0.0, 0.0
    if "target" in given:
        if given["target"] not in gaze_targets():
            raise unknown_name("gaze target", given["target"], gaze_targets())
        yaw, pitch = gaze_targets()[given["target"]]
    yaw, pitch = number(given, "yaw", yaw), number(given, "pitch", pitch)
    here = builder.point()
    name = here.terms[0][0]
    at = Moment.parse(given["at"], name) if "at" in given else here
    until = Moment.parse(given["until"], name) if "until" in given else None
    if "duration" in given:
        until = at + clock(given["duration"])
    if builder.gaze is not None:
        builder.commands.append(replace(builder.gaze, until=at))
        builder.gaze = None
    if "LookAt" not in builder.library:
        raise InputError("<gaze> needs the command LookAt in the library")
    where = f"{builder.source}, line {builder.line}"
    command = Command("LookAt", (("yaw", f"{yaw:g}"), ("pitch", f"{pitch:g}")), where)
    item = builder.opened[-1]
    if until is not None:
        builder.commands.append(DirectedCommand(command, at, until))
        return
    builder.gaze = mine = DirectedCommand(command, at)

    def close() -> None:
        if builder.said_in(item) and builder.gaze is mine:
            builder.commands.append(replace(mine, until=builder.point(after=True)))
            builder.gaze = None

    item.close = close


def _curve(builder: Builder, given: Given) -> None:
    only(given, "parameter", "interp", "mode", "fade", "at")
    parameter = face_parameter(needed(given, "parameter")).name
    interpolation, mode = given.get("interp", "linear"), given.get("mode", "add")
    if interpolation not in INTERPOLATIONS:
        raise unknown_name("interpolation", interpolation, INTERPOLATIONS)
    if mode not in MODES:
        raise unknown_name("mode of a curve", mode, MODES)
    here = builder.point()
    origin = Moment.parse(given["at"], here.terms[0][0]) if "at" in given else here
    item, where = builder.opened[-1], f"{builder.source}, line {builder.line}"

    def close() -> None:
        keys = tuple((_key_moment(text, origin, here), value) for text, value in item.keys)
        if not keys:
            raise InputError("<curve> needs at least one <key at= value=/>")
        fade = clock(given.get("fade", "0"), "fade")
        builder.curves.append(DirectedCurve(parameter, keys, interpolation, mode, fade, where))

    item.close = close


def _key_moment(text: str, origin: Moment, here: Moment) -> Moment:
    moment = Moment.parse(text, here.terms[0][0])
    return moment if moment.terms else origin + moment.offset


def _key(builder: Builder, given: Given) -> None:
    only(given, "at", "value")
    if len(builder.opened) < 2 or builder.opened[-2].event.text != "curve":
        raise InputError("<key> stands in a <curve>")
    builder.opened[-2].keys.append((needed(given, "at"), number(given, "value")))


def _pose(builder: Builder, given: Given) -> None:
    """A parameter held at a value from here on, or over what the element holds."""
    only(given, "parameter", "value", "attack", "release", "mode", "at", "until", "duration")
    parameter, value = face_parameter(needed(given, "parameter")).name, number(given, "value")
    mode = given.get("mode", "add")
    if mode not in MODES:
        raise unknown_name("mode of a pose", mode, MODES)
    attack, release = clock(given.get("attack", "200")), clock(given.get("release", "300"))
    here = builder.point()
    at = Moment.parse(given["at"], here.terms[0][0]) if "at" in given else here
    until = Moment.parse(given["until"], here.terms[0][0]) if "until" in given else None
    until = at + clock(given["duration"]) if "duration" in given else until
    item, where = builder.opened[-1], f"{builder.source}, line {builder.line}"

    def close() -> None:
        end = until or (builder.point(after=True) if builder.said_in(item) else Moment.at("end"))
        keys: tuple[tuple[Moment, float], ...] = ((at + -attack, 0.0), (at, value), (end, value), (end + release, 0.0))
        if mode == "set":
            keys = keys[1:3]
        fade = max(attack, release) if mode == "set" else 0.0
        builder.curves.append(DirectedCurve(parameter, keys, "smooth", mode, fade, where))

    item.close = close


ELEMENTS: dict[str, Callable[[Builder, Given], None]] = {
    "script": _root,
    "speak": _root,
    "emotion": _emotion,
    "effort": _effort,
    "pause": _pause,
    "break": _pause,
    "mark": _mark,
    "gaze": _gaze,
    "curve": _curve,
    "key": _key,
    "pose": _pose,
    **VOCAL_ELEMENTS,
}
"""Every element that is no command, by name."""
