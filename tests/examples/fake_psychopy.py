"""As much of PsychoPy as the example needs, with a participant who knows the answers: no window, no waiting."""

# ruff: noqa: N802 - the names are PsychoPy's

from __future__ import annotations

import csv
import sys
import types
from pathlib import Path
from typing import Any

import numpy as np
import pytest


class Session:
    """What was shown, and which keys are pressed next."""

    def __init__(self) -> None:
        self.shown: list[str] = []
        self.keys: list[str] = []
        self.now = 0.0
        self.closed = 0


def install(monkeypatch: pytest.MonkeyPatch, session: Session) -> None:
    """Put a module ``psychopy`` where ``import`` finds it."""

    class Window:
        def __init__(self, fullscr: bool, color: Any, units: str) -> None:
            self.waiting: list[Any] = []
            self.frameIntervals: list[float] = []
            self.recordFrameIntervals = False

        def callOnFlip(self, call: Any) -> None:
            self.waiting.append(call)

        def flip(self) -> None:
            session.now += 1 / 60
            if self.recordFrameIntervals:
                self.frameIntervals.append(1 / 60)
            while self.waiting:
                self.waiting.pop(0)()

        def close(self) -> None:
            session.closed += 1

    class Text:
        def __init__(self, window: Window, text: str, **_: Any) -> None:
            self.text = text

        def draw(self) -> None:
            session.shown.append(self.text)

    class Image:
        def __init__(self, window: Window, image: str) -> None:
            self.image = image

        def draw(self) -> None:
            session.shown.append(Path(self.image).name)

    class Film:
        def __init__(self, window: Window, filename: str, noAudio: bool, autoStart: bool) -> None:
            self.name, self.left = Path(filename).name, 3

        def play(self) -> None:
            session.shown.append(self.name)

        @property
        def isFinished(self) -> bool:
            self.left -= 1
            return self.left < 0

        def draw(self) -> None: ...

        def stop(self) -> None: ...

    class Clock:
        def __init__(self) -> None:
            self.reset()

        def reset(self) -> None:
            self.start = session.now

        def getTime(self) -> float:
            return session.now - self.start

    def wait_keys(keyList: list[str] | None, timeStamped: Clock) -> list[tuple[str, float]]:
        session.now += 0.5
        key = session.keys.pop(0)
        assert keyList is None or key in keyList
        return [(key, timeStamped.getTime() + 0.5)]

    class Trials:
        def __init__(self, conditions: list[dict[str, str]], nReps: int, method: str, seed: int) -> None:
            assert method == "random"
            order = np.random.default_rng(seed).permutation(len(conditions) * nReps)
            self.order = [conditions[number % len(conditions)] for number in order]
            self.row: dict[str, Any] = {}

        def __iter__(self) -> Any:
            for condition in self.order:
                self.row = dict(condition)
                yield condition

        def addData(self, name: str, value: Any) -> None:
            self.row[name] = value

    class Experiment:
        def __init__(self, name: str, extraInfo: dict[str, Any], dataFileName: str) -> None:
            self.extra, self.rows = extraInfo, list[dict[str, Any]]()

        def addLoop(self, trials: Trials) -> None:
            self.trials = trials

        def nextEntry(self) -> None:
            self.rows.append(self.trials.row | self.extra)

        def saveAsWideText(self, path: str, appendFile: bool, fileCollisionMethod: str) -> None:
            with Path(path).open("w", newline="") as stream:
                writer = csv.DictWriter(stream, self.rows[0])
                writer.writeheader()
                writer.writerows(self.rows)

    def conditions(path: str) -> list[dict[str, str]]:
        with Path(path).open(newline="") as stream:
            return list(csv.DictReader(stream))

    parts = {
        "core": {"Clock": Clock, "wait": lambda seconds: setattr(session, "now", session.now + seconds)},
        "event": {"waitKeys": wait_keys, "clearEvents": lambda: None},
        "visual": {"Window": Window, "TextStim": Text, "ImageStim": Image, "MovieStim": Film},
        "data": {
            "importConditions": conditions,
            "ExperimentHandler": Experiment,
            "TrialHandler": Trials,
            "getDateStr": lambda: "today",
        },
    }
    package = types.ModuleType("psychopy")
    monkeypatch.setitem(sys.modules, "psychopy", package)
    for name, content in parts.items():
        module = types.ModuleType(f"psychopy.{name}")
        module.__dict__.update(content)
        setattr(package, name, module)
        monkeypatch.setitem(sys.modules, f"psychopy.{name}", module)
