"""Trees as plain data: text -> data -> text -> data is the identity, and faults name line, parameter and place."""

from __future__ import annotations

import copy
import json
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mien.core.errors import InputError
from mien.face.library import load_face
from mien.face.parameter_tree import ParameterTree
from mien.face.tree_config import parse_tree, tree_text
from mien.face.tree_data import check_data, config_data, data_text, influence_data, tree_data
from mien.face.tree_of_face import tree_of_face
from tests.face.test_tree_config import BOX, GOOD
from tests.faces import tiny_face

number = st.floats(-1e6, 1e6, allow_nan=False)
positive = st.floats(0, 1e3)
three = st.lists(number, min_size=3, max_size=3)
axis = three.filter(lambda v: any(v))
word = st.text("abcXYZ_09é:-", min_size=1, max_size=8)
part = st.none() | word
run = st.tuples(st.integers(0, 500), st.integers(0, 40), number).map(lambda r: [r[0], r[0] + r[1], r[2]])
region = st.one_of(
    st.fixed_dictionaries({"shape": st.just("all"), "part": part, "weight": number}),
    st.fixed_dictionaries({"shape": st.just("sphere"), "part": part, "centre": three, "radius": positive,
                           "soft": positive, "weight": number}),
    st.fixed_dictionaries({"shape": st.just("side"), "part": part, "normal": axis, "point": three, "soft": positive,
                           "weight": number}),
    st.fixed_dictionaries({"shape": st.just("weights"), "part": word, "weights": st.lists(run, min_size=1)}),
)  # fmt: skip
motion = st.one_of(
    st.fixed_dictionaries({"kind": st.just("rotation"), "axis": axis, "pivot": three}),
    st.fixed_dictionaries({"kind": st.just("translation"), "translation": three}),
    st.fixed_dictionaries({"kind": st.just("fixed")}),
)
remark = st.text("abc, #é.", max_size=12).map(str.strip)
parameter = st.tuples(
    motion,
    st.fixed_dictionaries({
        "name": word, "parent": st.none() | word.filter(lambda w: w != "none"),
        "group": st.sampled_from(["skeletal", "surface", None]), "drives": st.dictionaries(word, number, max_size=3),
        "limits": st.none() | st.lists(number, min_size=2, max_size=2), "regions": st.lists(region, max_size=3),
        "remarks": st.lists(remark, max_size=2),
    }),
).map(lambda pair: pair[0] | pair[1])  # fmt: skip
trees = st.builds(
    lambda parameters, remarks: {"format": "mien-tree", "version": 1, "remarks": remarks, "parameters": parameters},
    st.lists(parameter, max_size=4),
    st.lists(remark, max_size=2),
)


def joined(data: dict[str, Any]) -> dict[str, Any]:
    """Neighbouring lists of one part are one list in the text."""
    for held in data["parameters"]:
        regions: list[dict[str, Any]] = []
        for one in held["regions"]:
            if regions and one["shape"] == regions[-1]["shape"] == "weights" and one["part"] == regions[-1]["part"]:
                regions[-1]["weights"] += one["weights"]
            else:
                regions.append(one)
        held["regions"] = regions
    return data


@settings(max_examples=150, deadline=None)
@given(trees)
def test_data_text_data_is_the_identity(data: dict[str, Any]) -> None:
    again = config_data(parse_tree(data_text(data)))
    assert again == joined(copy.deepcopy(data))
    assert config_data(parse_tree(data_text(again))) == again
    assert json.loads(json.dumps(again)) == again


def test_text_data_text_keeps_the_meaning_and_the_remarks() -> None:
    data = config_data(parse_tree(GOOD))
    assert data["remarks"] == ["a remark"]
    assert data["parameters"][0]["remarks"] == ["degrees"]
    one, other = parse_tree(GOOD).on(BOX), parse_tree(data_text(data)).on(BOX)
    assert tree_text(one) == tree_text(other)


def test_the_default_tree_passes_through_data_unchanged() -> None:
    whole = load_face()
    kept = ("jawOpen", "eyeBlinkLeft", "mouthSmileLeft", "tongueOut")
    targets = [{name: part.targets[name] for name in kept if name in part.targets} for part in whole.parts]
    face = replace(whole, parts=tuple(replace(p, targets=t) for p, t in zip(whole.parts, targets, strict=True)))
    vertices = {p.name: p.vertices for p in face.parts}
    data = tree_data(tree_of_face(face), "derived")
    assert config_data(parse_tree(data_text(data))) == data
    assert check_data(data, vertices) == []
    tree = parse_tree(data_text(data)).on(vertices)
    held = influence_data(tree)["jaw"]["skin"]
    jaw = next(p for p in tree.parameters if p.name == "jaw")
    np.testing.assert_allclose(held["weights"], jaw.influences["skin"].weights)


def changed(place: list[Any], value: Any) -> dict[str, Any]:
    data = config_data(parse_tree(GOOD))
    held: Any = data
    for step in place[:-1]:
        held = held[step]
    held[place[-1]] = value
    return data


@pytest.mark.parametrize(
    ("place", "value", "told"),
    [
        (["parameters", 0, "parent"], "lid", "circle|surface parameter"),
        (["parameters", 1, "parent"], "haed", "its parent 'haed' is not in the tree"),
        (["parameters", 0, "limits"], [3, -3], "limits run from 3 down to -3"),
        (["parameters", 2, "name"], "head", "taken twice"),
        (["parameters", 1, "regions", 1, "weights"], [[7, 8, 1.0]], "vertex 8 is beyond the 8 of part 'mesh'"),
        (["parameters", 1, "regions", 1, "part"], "skin", "the mesh has no part 'skin'; it has mesh"),
        (["parameters", 0, "axis"], [0, 0, 0], "no length"),
        (["parameters", 1, "regions", 0, "radius"], -1, "not negative"),
        (["parameters", 0, "regions", 0, "weight"], -1, "weights below zero"),
    ],
)
def test_faults_have_a_line_and_a_parameter(place: list[Any], value: Any, told: str) -> None:
    data = changed(place, value)
    faults = [fault for fault in check_data(data, BOX) if re.search(told, fault.text)]
    assert faults
    named = data["parameters"][place[1]]["name"]
    assert faults[0].parameter == named
    lines = data_text(data).splitlines()
    below = next(number for number, line in enumerate(lines, 1) if line == f"parameter {named}")
    assert below <= faults[0].line <= len(lines)


@pytest.mark.parametrize(
    ("place", "value", "told"),
    [
        (["format"], "tree", "format"),
        (["parameters"], {}, "parameters: expected a list"),
        (["parameters", 0], 3, r"parameters\[0\]: expected an object"),
        (["parameters", 1, "name"], "two words", r"parameters\[1\].name: expected a name"),
        (["parameters", 1, "name"], "a\nall 1", r"parameters\[1\].name"),
        (["parameters", 1, "kind"], "spin", r"parameters\[1\].kind: expected one of rotation"),
        (["parameters", 1, "translation"], [1, 2], r"parameters\[1\].translation: expected 3 numbers, got 2"),
        (["parameters", 1, "drives"], {"jawOpen": float("nan")}, r"drives.jawOpen: expected a finite number"),
        (["parameters", 1, "regions", 0, "shape"], "cube", r"regions\[0\].shape: expected one of all"),
        (["parameters", 1, "regions", 1, "weights"], [[0.5, 1, 1]], r"weights\[0\]: expected \[first vertex"),
        (["parameters", 1, "regions", 1, "weights"], [], "at least one run"),
        (["parameters", 1, "regions", 1, "part"], None, "the name of a part"),
        (["parameters", 1, "colour"], 1, "no such field"),
        (["parameters", 1, "remarks"], ["a\nall 1"], "lines of text"),
        (["parameters", 1, "limits"], "-1 1", r"limits: expected a list"),
    ],
)
def test_data_of_another_form_is_refused_with_its_place(place: list[Any], value: Any, told: str) -> None:
    with pytest.raises(InputError, match=told):
        data_text(changed(place, value))


def test_text_with_faults_gives_no_data() -> None:
    with pytest.raises(InputError, match=r"a\.tree:3: expected 'rotation axis"):
        config_data(parse_tree("mien-tree 1\nparameter a\nrotation nonsense\n", "a.tree"))
    with pytest.raises(InputError, match="a: needs a line 'rotation'"):
        config_data(parse_tree("mien-tree 1\nparameter a\n"))


def test_data_makes_the_same_tree_as_the_face() -> None:
    face = tiny_face()
    vertices = {p.name: p.vertices for p in face.parts}
    tree = tree_of_face(face)
    again = parse_tree(data_text(tree_data(tree))).on(vertices)
    assert isinstance(again, ParameterTree)
    values = np.linspace(0.1, 0.4, len(tree))
    for name, rest in vertices.items():
        np.testing.assert_allclose(tree.deform(name, rest, values), again.deform(name, rest, values), atol=5e-3)
