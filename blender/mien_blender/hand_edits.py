"""What was changed by hand in a performance, kept while the line is performed again. No Blender in here.

A curve's edit is what it is now less what mien wrote. Laid on a new performance it moves along with the words: times
between borders of words and phones that both lines share are stretched alike. An edit on a word that is gone is lost,
and reported.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from difflib import SequenceMatcher

import numpy as np

LEAST = 1e-4
"""A curve counts as edited from this difference on (weights 0..1, parts of a quaternion)."""

Tier = Sequence[Sequence]  # of [start, end, label]


def edits_of(now: Mapping[str, np.ndarray], written: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """By curve, what was changed by hand, one number a frame; only curves on which something was."""
    edits = {}
    for name, values in now.items():
        before = written.get(name)
        if before is None:
            before = np.full(len(values), values[0] if name.startswith("turn") else 0.0)
        change = values - before[: len(values)]
        if len(change) and np.abs(change).max() > LEAST:
            edits[name] = np.where(np.abs(change) > LEAST, change, 0.0)
    return edits


class Moved:
    """Where the instants of a new line lie in an old one."""

    def __init__(self, old: Mapping[str, Tier], new: Mapping[str, Tier]) -> None:
        was, now = [word[2] for word in old["words"]], [word[2] for word in new["words"]]
        pairs, kept, self.kept_old = [(0.0, 0.0)], set(), set()
        for block in SequenceMatcher(None, was, now, autojunk=False).get_matching_blocks():
            for step in range(block.size):
                a, b = old["words"][block.a + step], new["words"][block.b + step]
                pairs += _borders(a, b, old["phones"], new["phones"])
                kept.add(block.b + step)
                self.kept_old.add(block.a + step)
        pairs.append((_end(new), _end(old)))
        pairs.sort()
        self._new, self._old = (np.maximum.accumulate(np.array(column)) for column in zip(*pairs, strict=True))
        self._foreign = [word for number, word in enumerate(new["words"]) if number not in kept]
        self._gone = [word for number, word in enumerate(old["words"]) if number not in self.kept_old]

    def carried(self, edit: np.ndarray, old_fps: float, seconds: np.ndarray) -> np.ndarray:
        """An edit of the old line at instants of the new one."""
        there = np.interp(seconds, self._new, self._old)
        value = np.interp(there, np.arange(len(edit)) / old_fps, edit)
        for start, end, _ in self._foreign:
            value[(seconds >= start) & (seconds < end)] = 0.0
        return value

    def lost(self, edits: Mapping[str, np.ndarray], old_fps: float) -> list[str]:
        """Words of the old line that are gone and had edits on them."""
        total = sum((np.abs(edit) for edit in edits.values()), start=np.zeros(1))
        times = np.arange(len(total)) / old_fps
        return [label for a, b, label in self._gone if total[(times >= a) & (times < b)].any()]


def _borders(was: Sequence, now: Sequence, old_phones: Tier, new_phones: Tier) -> list[tuple[float, float]]:
    """(new, old) of a word's ends, and of its phones where it has as many of them as before."""
    inside_old = [phone for phone in old_phones if was[0] - 1e-6 <= phone[0] and phone[1] <= was[1] + 1e-6]
    inside_new = [phone for phone in new_phones if now[0] - 1e-6 <= phone[0] and phone[1] <= now[1] + 1e-6]
    ends = [(now[0], was[0]), (now[1], was[1])]
    if len(inside_old) != len(inside_new):
        return ends
    return ends + [(b[0], a[0]) for a, b in zip(inside_old, inside_new, strict=True)]


def _end(line: Mapping[str, Tier]) -> float:
    return max((tier[-1][1] for tier in (line["words"], line["phones"]) if len(tier)), default=0.0)


def moved_borders(phones: Tier, words: Tier, starts: Mapping[int, float], least: float) -> list[dict]:
    """Edits for mien's own layer (docs/edits.md): starts of phones that were moved by at least ``least`` seconds."""
    edits, seen = [], {}
    for word in words:
        seen[word[2]] = seen.get(word[2], 0) + 1
        inside = [n for n, phone in enumerate(phones) if word[0] - 1e-6 <= phone[0] and phone[1] <= word[1] + 1e-6]
        for place, number in enumerate(inside):
            shift = starts.get(number, phones[number][0]) - phones[number][0]
            if abs(shift) >= least:
                anchor = {"word": word[2], "occurrence": seen[word[2]], "phone": place}
                edits.append({"kind": "border", "phone": anchor, "edge": "start", "shift": round(shift, 4)})
    return edits
