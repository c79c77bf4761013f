"""The way of a line: which files a text passes through until it is motion.

    python tools/way_of_a_line.py [--tell]

Follows a short emotional line through `mien.say`, from call to call between files of mien. A call is on the way if it
is given the line in one of its forms: the text, `Script`, `SpokenText`, `Speech`, `Utterance`, `Spoken`, `Animation`.
Rooms stand in the order of the way: text, speech, emotion (which gives feeling to the voice), motion. `core` (the forms
themselves) and what only conducts (`api`, `pipeline`) belong to no place on it. Counted, each pair of files once:

files      through which the line passes
climbs     from a room to one before it on the way
returns    to a file in which the line was before, from another than the one that called it first
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from types import FrameType

import mien
from mien.animation.animation import Animation
from mien.core.utterance import Utterance
from mien.pipeline.spoken import Spoken
from mien.pipeline.spoken_joining import Joined
from mien.speech.voices import Speech
from mien.text.script import Script
from mien.text.spoken_text import SpokenText

SOURCE = str(Path(mien.__file__).parent) + "/"
LINE = "He said five words."
FORMS = (Script, SpokenText, Speech, Utterance, Spoken, Joined, Animation)
ORDER = ("text", "speech", "emotion", "motion", "face", "formats")
CONDUCTING = ("core", "__init__.py")


def calls_of_a_line() -> list[tuple[str, str, str]]:
    """Caller's file, called file and function of every call that is given the line, in order."""
    calls: list[tuple[str, str, str]] = []

    def bears_line(frame: FrameType) -> bool:
        code = frame.f_code
        given = [frame.f_locals.get(name) for name in code.co_varnames[: code.co_argcount + code.co_kwonlyargcount]]
        return any(isinstance(value, FORMS) or (isinstance(value, str) and value == LINE) for value in given)

    def watch(frame: FrameType, event: str, _: object) -> None:
        path = frame.f_code.co_filename
        if event != "call" or not path.startswith(SOURCE) or frame.f_code.co_name.startswith("<"):
            return
        caller = frame.f_back
        while caller is not None and not caller.f_code.co_filename.startswith(SOURCE):
            caller = caller.f_back
        if caller is not None and bears_line(frame):
            calls.append((caller.f_code.co_filename[len(SOURCE) :], path[len(SOURCE) :], frame.f_code.co_name))

    mien.say(LINE, emotion="happy:0.5")  # loads what is loaded once
    sys.setprofile(watch)
    try:
        mien.say(LINE, emotion="happy:0.5")
    finally:
        sys.setprofile(None)
    return calls


def main() -> None:
    """Print the three figures; with --tell the calls behind them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tell", action="store_true", help="print the calls")
    told = parser.parse_args().tell
    pairs: dict[tuple[str, str], str] = {}
    for caller, called, name in calls_of_a_line():
        if caller != called and not called.startswith(CONDUCTING):
            pairs.setdefault((caller, called), name)
    place = {room: number for number, room in enumerate(ORDER)}
    seen: set[str] = set()
    climbs = returns = 0
    for (caller, called), name in pairs.items():
        here, there = (place.get(path.partition("/")[0]) for path in (caller, called))
        climb = here is not None and there is not None and there < here
        climbs, returns = climbs + climb, returns + (called in seen)
        if told:
            marks = f"{'climbs' if climb else '':7}{'returns' if called in seen else '':8}"
            print(f"{marks}{caller} -> {called}: {name}")
        seen.add(called)
    print(f"files {len(seen)}, climbs {climbs}, returns {returns}")


if __name__ == "__main__":
    main()
