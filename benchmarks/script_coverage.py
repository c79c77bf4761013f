"""Which diphones are frequent in English, and how many of them the recording scripts hold.

    python benchmarks/script_coverage.py            writes docs/tables/script_coverage.md, under ten seconds
    python benchmarks/script_coverage.py --missing  prints what the English script lacks, with words that have it

Definitions:

* A diphone is a phone and the next one, within a word or from the last of a word to the first of the next; what
  stands beside a pause at either end of a sentence does not count.
* How often: words as often as the language model inside pocketsphinx expects them, all words of its dictionary in
  their first pronunciation; pairs of words by its bigrams over the `NEIGHBOURS` likeliest words. Nothing is fetched.
* Frequent: the most usual diphones that together make up `SHARE` of all diphones spoken.
* Finnish: letters are phones (``nk`` and ``ng`` hold the velar nasal, a doubled letter is a long phone). What is
  frequent is not known here, so the table counts kinds, and which phones of the standard language are there.
"""

from __future__ import annotations

import argparse
import heapq
from collections import Counter, defaultdict
from collections.abc import Iterable
from functools import cache
from itertools import pairwise
from pathlib import Path

from mien.corpus.recording.scripts import Line, read_script
from mien.text.normalisation import pronounce_text
from mien.text.phones import phone_table
from mien.text.pronunciation import dictionary_entries

SHARE = 0.99
NEIGHBOURS = 2000
TABLE = Path(__file__).parent.parent / "docs" / "tables" / "script_coverage.md"
Diphone = tuple[str, str]


@cache
def diphone_shares() -> dict[Diphone, float]:
    """Share of every diphone among all that are spoken, the most usual first."""
    import pocketsphinx

    model = pocketsphinx.NGramModel.readfile(pocketsphinx.get_model_path("en-us/en-us.lm.bin"))
    probability, value = model.prob, pocketsphinx.LogMath().exp
    phones = dict(dictionary_entries())
    often = {word: p for word in phones if (p := value(probability([word]))) > 1e-30}  # others are not in the model
    inside: Counter[Diphone] = Counter()
    for word, share in often.items():
        for diphone in pairwise(phones[word]):
            inside[diphone] += share
    across: Counter[Diphone] = Counter()
    near = heapq.nlargest(NEIGHBOURS, often, key=lambda word: often[word])
    for word in near:
        for following in near:  # the model takes the later word first
            diphone = (phones[word][-1], phones[following][0])
            across[diphone] += often[word] * value(probability([following, word]))
    # Every word but the last of a sentence has one diphone with the next word, rare neighbours like the usual ones.
    missing = (sum(often.values()) - value(probability(["</s>"]))) / across.total()
    total = inside + Counter({diphone: count * missing for diphone, count in across.items()})
    return {diphone: count / total.total() for diphone, count in total.most_common()}


def frequent_diphones(share: float = SHARE) -> list[Diphone]:
    """The most usual diphones that together make up ``share`` of all."""
    found, reached = [], 0.0
    for diphone, part in diphone_shares().items():
        if reached >= share:
            break
        found.append(diphone)
        reached += part
    return found


def phones_of(line: Line) -> tuple[str, ...]:
    return tuple(phone for _, phones in pronounce_text(line.text) for phone in phones)


def english_diphones(lines: Iterable[Line]) -> Counter[Diphone]:
    return Counter(diphone for line in lines for diphone in pairwise(phones_of(line)))


def english_rows(lines: list[Line]) -> list[tuple[str, str]]:
    held = english_diphones(lines)
    rows = []
    for share in (0.95, 0.98, SHARE):
        frequent = frequent_diphones(share)
        there = sum(diphone in held for diphone in frequent)
        rows.append(
            (f"of the {len(frequent)} diphones that make up {share:.0%} of speech", f"{there / len(frequent):.1%}")
        )
    spoken = sum(part for diphone, part in diphone_shares().items() if diphone in held)
    phones = Counter(phone for line in lines for phone in phones_of(line))
    words = [len(line.text.split()) for line in lines]
    rarest = min(phone_table(), key=lambda phone: phones[phone])
    return [
        ("sentences", str(len(lines))),
        ("words in a sentence", f"{min(words)} to {max(words)}, {sum(words)} in all"),
        ("phones", f"{sum(phones[phone] > 0 for phone in phone_table())} of {len(phone_table())}"),
        ("rarest phone", f"{rarest}, {phones[rarest]} times"),
        ("kinds of diphones", str(len(held))),
        *rows,
        ("of all diphones spoken, by how often they are", f"{spoken:.1%}"),
    ]


FINNISH = tuple("aeiouyäödhjklmnprstvŋ")


def finnish_phones(text: str) -> list[str]:
    """Phones by the letters; ``:`` after a long one.

    >>> finnish_phones("Kengät, kaappi")
    ['k', 'e', 'ŋ:', 'ä', 't', 'k', 'a:', 'p:', 'i']
    """
    phones: list[str] = []
    for word in "".join(c if c.isalpha() else " " for c in text.lower()).split():
        place = 0
        while place < len(word):
            two = word[place : place + 2]
            if two == "ng":
                phones.append("ŋ:")
            elif two == "nk":
                phones += ["ŋ", "k"]
            elif len(set(two)) == 1 and len(two) == 2:
                phones.append(f"{two[0]}:")
            else:
                phones.append(word[place])
                place -= 1
            place += 2
    return phones


def finnish_rows(lines: list[Line]) -> list[tuple[str, str]]:
    spoken = [finnish_phones(line.text) for line in lines]
    phones = Counter(phone for one in spoken for phone in one)
    plain = Counter(phone.rstrip(":") for one in spoken for phone in one)
    words = [len(line.text.split()) for line in lines]
    rarest = min(FINNISH, key=lambda phone: plain[phone])
    vowels = [phone for phone in FINNISH if phone in "aeiouyäö"]
    pairs = {pair for one in spoken for pair in pairwise(phone.rstrip(":") for phone in one)}
    with_vowel = {(a, b) for a, b in pairs if a in FINNISH and b in vowels and a not in vowels}
    consonants = [phone for phone in FINNISH if phone not in vowels and phone != "ŋ"]
    return [
        ("sentences", str(len(lines))),
        ("words in a sentence", f"{min(words)} to {max(words)}, {sum(words)} in all"),
        ("phones", f"{sum(plain[phone] > 0 for phone in FINNISH)} of {len(FINNISH)}"),
        ("rarest phone", f"{rarest}, {plain[rarest]} times"),
        ("long vowels", f"{sum(phones[f'{v}:'] > 0 for v in vowels)} of {len(vowels)}"),
        ("long consonants", " ".join(sorted(p.rstrip(":") for p in phones if p[0] not in vowels and p.endswith(":")))),
        (
            "consonant and vowel",
            f"{len([1 for a, b in with_vowel if a in consonants])} of {len(consonants) * len(vowels)} pairs",
        ),
        ("kinds of diphones", str(len(pairs))),
    ]


def table() -> str:
    parts = [
        "# Recording scripts",
        "",
        "Written by `python benchmarks/script_coverage.py`, which has the definitions.",
        "",
    ]
    for title, rows in (("English", english_rows(read_script("en"))), ("Finnish", finnish_rows(read_script("fi")))):
        parts += [f"| {title} | |", "| --- | --- |", *(f"| {name} | {value} |" for name, value in rows), ""]
    return "\n".join(parts)


def told_missing() -> str:
    held = english_diphones(read_script("en"))
    words: defaultdict[Diphone, list[str]] = defaultdict(list)
    for word, phones in dictionary_entries():
        for diphone in pairwise(phones):
            words[diphone].append(word)
    lines = [f"{a} {b}: {', '.join(words[a, b][:8])}" for a, b in frequent_diphones() if (a, b) not in held]
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--missing", action="store_true", help="print what the English script lacks")
    if parser.parse_args().missing:
        print(told_missing())
        return
    TABLE.write_text(table(), encoding="utf-8")
    print(TABLE)


if __name__ == "__main__":
    main()
