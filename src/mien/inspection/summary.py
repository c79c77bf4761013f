"""What a performer has learned, in words."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from textwrap import wrap
from typing import Any

from mien.inspection.shares import EVIDENCE, PairShares
from mien.motion.em_pca import EMPCA
from mien.motion.mouth.articulation import articulation_table
from mien.motion.mouth.coverage import heard_phones
from mien.motion.mouth.influence_curves import PENALTIES
from mien.motion.mouth.learned_mouth import by_hand
from mien.motion.mouth.mouth_space import MarkerSpace
from mien.motion.performer_file import LearnedSpeech

__all__ = ["summary", "table_of_shares"]

_WIDTH, _LINE = 20, 110
_MOST_UNHEARD = 12


def summary(learned: LearnedSpeech, shares: PairShares) -> str:
    """Everything that ``mien inspect`` prints.

    Parameters
    ----------
    learned : LearnedSpeech
    shares : PairShares
        From `mien.inspection.shares.share_of_pairs`.
    """
    blocks = [
        _origin(learned),
        _heard(learned),
        _spaces(learned),
        _settings(learned),
        _cost(learned),
        table_of_shares(shares),
    ]
    return "\n\n".join("\n".join(block) for block in blocks)


def _row(name: str, value: object) -> str:
    return f"{name:<{_WIDTH}}{value}"


def _wrapped(name: str, items: Iterable[str]) -> list[str]:
    """A row whose value may take several lines."""
    lines, line = [], ""
    for item in items:
        if line and _WIDTH + len(line) + 2 + len(item) > _LINE:
            lines.append(line + ",")
            line = item
        else:
            line = f"{line}, {item}" if line else item
    lines.append(line)
    return [_row(name if number == 0 else "", text) for number, text in enumerate(lines)]


def _paragraph(name: str, text: str) -> list[str]:
    lines = wrap(text, _LINE - _WIDTH, break_long_words=False, break_on_hyphens=False) or [""]
    return [_row(name if number == 0 else "", line) for number, line in enumerate(lines)]


def _origin(learned: LearnedSpeech) -> list[str]:
    motion = learned.motion
    rows = [_row("performer", learned.name)]
    about = learned.about or {"licence": "not stated in the file"}
    rows += [row for key, value in about.items() for row in _paragraph(key, value)]
    mouth = motion.mouth_
    rows.append(_row("learned in", f"{len(mouth.names)} {mouth.kind} of the mouth"))
    rows += [_row("layout", mouth.layout)] if isinstance(mouth, MarkerSpace) else _wrapped("", mouth.names)
    rows.append(_row("learned from", f"{len(learned.trained_on)} takes"))
    return rows


def _heard(learned: LearnedSpeech) -> list[str]:
    coverage, paper = learned.motion.coverage_, learned.coarticulation
    phones = heard_phones(coverage)
    missing = [f"{phone} (class {articulation_table().viseme_of(phone)})" for phone, n in phones.items() if not n]
    rows = [_row("phones", f"{sum(n > 0 for n in phones.values())} of {len(phones)} heard")]
    if missing:
        rows += _wrapped("never heard", missing)
        shapes = " ".join(by_hand(coverage)) or "none"
        rows.append(_row("", f"hand-made key shapes: {shapes}; the others move like their kin"))
    for name, counts in (
        ("diphones", coverage.diphones_),
        ("triphones", coverage.triphones_),
        ("class pairs", coverage.classes_),
    ):
        often = sum(n >= coverage.least for n in counts.values())
        rows.append(_row(name, f"{len(counts)} heard, {often} of them {coverage.least} times or more"))
    by_length = Counter(len(phones) for phones in paper.curves_)
    rows.append(
        _row(
            "curves fitted",
            f"{by_length[2]} diphones, {by_length[3]} triphones, {len(paper.class_curves_)} class pairs "
            f"(from {paper.settings.least_pairs} time-weight pairs up)",
        )
    )
    rows.append(_row("hand-made besides", "tongue, inside of the mouth, the lip on the teeth at F and V"))
    if learned.motion.edits_:
        rows += _wrapped("key shapes changed", learned.motion.edits_)
    return rows


def _spaces(learned: LearnedSpeech) -> list[str]:
    spaces = {"performing mouth": learned.motion.space_, "paper's curves": learned.coarticulation.space_}
    rows = ["pose space"] + [_row(f"  {name}", _space(space)) for name, space in spaces.items()]
    if learned.expressions is None:
        return [*rows, _row("expressions", "none recorded: the hand-made ones are used"), *_maps(learned)]
    seconds = ", ".join(f"{name} {length:.1f} s" for name, length in learned.expressions.seconds.items())
    space = _row("  expression space", _space(learned.expressions.space.space_))
    return [*rows, _row("expressions", seconds), space, *_maps(learned)]


def _maps(learned: LearnedSpeech) -> list[str]:
    """Maps between emotions: how near each comes on sentences held out, against a mean offset."""
    if learned.emotion_maps is None:
        return []
    rows = [
        _row("emotion maps", f"{len(learned.emotion_maps.maps)}; missed on sentences held out, beside a mean offset")
    ]
    for (source, target), mapping in learned.emotion_maps.maps.items():
        number = learned.emotion_maps.sentences[source, target]
        rows.append(_row(f"  {source} to {target}", f"{mapping.map_}, from {number} sentences"))
    return rows


def _space(space: EMPCA) -> str:
    total = space.variances_.sum() / space.share_
    each = " ".join(f"{100 * variance / total:.1f}" for variance in space.variances_)
    what = "variance" if (space.weights_ == 1).all() else "weighted variance"
    return f"{len(space.variances_)} dimensions hold {100 * space.share_:.1f} % of the {what} (each, %: {each})"


def _settings(learned: LearnedSpeech) -> list[str]:
    speech = asdict(learned.motion.settings)
    groups: list[tuple[str, Mapping[str, Any]]] = [
        ("influence", speech.pop("influence")),
        ("correction", speech.pop("correction")),
        ("paper's curves", asdict(learned.coarticulation.settings)),
    ]
    rows = ["settings"]
    for name, values in [("performing mouth", speech), *groups]:
        rows += _wrapped(f"  {name}", [f"{key} {_short(value)}" for key, value in values.items()])
    return rows


def _short(value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, Sequence) and not isinstance(value, str):
        return "x".join(str(item) for item in value)
    return f"{value:g}" if isinstance(value, float) else str(value)


def _cost(learned: LearnedSpeech) -> list[str]:
    degrees = range(1, learned.fitting_cost.shape[1] + 1)
    rows = [f"fit cost of the curves by degree (the one used: {learned.coarticulation.settings.degree})"]
    rows.append(_row("  lambda", "".join(f"{degree:>11}" for degree in degrees)))
    for penalty, costs in zip(PENALTIES, learned.fitting_cost, strict=True):
        rows.append(_row(f"  {penalty:g}", "".join(f"{cost:>11.0f}" for cost in costs)))
    return rows


def table_of_shares(shares: PairShares) -> list[str]:
    """What the phone pairs of a text rest on, as lines."""
    rows = [f"{shares.sentences} sentences, {shares.pairs} phone pairs ({shares.kinds} different) rest on"]
    rows.append(" " * 22 + "".join(f"{kind:>11}" for kind in EVIDENCE))
    for name, found in (("paper's curves", shares.paper), ("heard in learning", shares.mouth)):
        rows.append(f"  {name:<20}" + "".join(f"{100 * found[kind]:>9.1f} %" for kind in EVIDENCE))
    rows.append("  cosine: no curve to use; Algorithm 1 interpolates, the performing mouth goes by articulation alone")
    if shares.unheard:
        most = [f"{' '.join(pair)} ({count})" for pair, count in shares.unheard[:_MOST_UNHEARD]]
        rows += _wrapped("  nothing like it", most)
    return rows
