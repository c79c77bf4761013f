import contextlib
import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mien.animation.edits import EditLayer, layer_of, plain_layer, read_layer, write_layer
from mien.core.errors import InputError
from tests.animation.edits.layers import layers

GOOD = {
    "format": "mien-edits",
    "version": 1,
    "line": [{"word": None, "pauses": ["SIL"]}, {"word": "never", "phones": ["N", "EH", "V", "ER"]}],
    "emotions": ["happy"],
    "edits": [
        {"kind": "border", "phone": {"word": "never", "phone": 2}, "edge": "end", "shift": 0.03},
        {"kind": "intensity", "emotion": "happy", "points": [{"anchor": {"word": "never", "phone": 0}, "value": 0.8}]},
        {
            "kind": "channel",
            "channel": "jawOpen",
            "mode": "add",
            "keys": [{"anchor": {"word": None, "pause": 0, "share": 0.5}, "value": -0.3}],
        },
    ],
}


@given(layers)
def test_a_layer_comes_back_as_it_was_written(layer):
    assert layer_of(json.loads(json.dumps(plain_layer(layer)))) == layer


def test_through_a_file(tmp_path):
    layer = layer_of(GOOD)
    write_layer(layer, tmp_path / "edits.json")
    assert read_layer(tmp_path / "edits.json") == layer
    assert [type(edit).__name__ for edit in layer.edits] == ["BorderEdit", "IntensityEdit", "ChannelEdit"]


def changed(path: str, value):
    document = json.loads(json.dumps(GOOD))
    *way, last = [int(step) if step.isdigit() else step for step in path.split("/")]
    at = document
    for step in way:
        at = at[step]
    at[last] = value
    return document


@pytest.mark.parametrize(
    ("path", "value", "told"),
    [
        ("format", "other", "expected an object with"),
        ("version", 2, "version 1"),
        ("edits", 3, "edits: expected a list"),
        ("edits/0/edge", "middle", "edits[0].edge: expected one of start, end"),
        ("edits/0/shift", "far", "edits[0].shift: expected a number"),
        ("edits/0/shift", 1e9, "edits[0]: a border is shifted by at most"),
        ("edits/0/phone", {"word": "never"}, "one of 'phone' and 'pause'"),
        ("edits/0/phone/phone", -1, "count from 1"),
        ("edits/0/phone/word", None, "before the first word"),
        ("edits/1/points", [], "at least one point"),
        ("edits/1/points/0/value", 80, "did you mean 0.8?"),
        ("edits/1/points/0/anchor/share", 1.5, "from 0 to 1"),
        ("edits/2/channel", "jawOpne", "did you mean 'jawOpen'?"),
        ("edits/2/keys/0/value", True, "edits[2].keys[0].value: expected a number"),
        ("edits/2/fade", -1, "a fade lasts"),
        ("edits/2/fades", 1, "unknown field 'fades'"),
        ("line/0/word", "i", "its first entry, and no other, has the word null"),
    ],
)
def test_faults_name_their_place(path, value, told):
    with pytest.raises(InputError) as caught:
        layer_of(changed(path, value))
    assert told in str(caught.value)
    assert "\n" not in str(caught.value)


values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(["kind", "edits", "word"]), inner),
    max_leaves=6,
)


@given(st.sampled_from(["line", "emotions", "edits", "edits/0", "edits/1/points", "edits/2/keys/0/anchor"]), values)
def test_anything_else_is_refused_or_read_never_a_crash(path, value):
    with contextlib.suppress(InputError):
        assert isinstance(layer_of(changed(path, value)), EditLayer)


@given(st.binary(max_size=40))
def test_files_of_random_bytes_are_refused(tmp_path_factory, content):
    path = tmp_path_factory.mktemp("edits") / "x.json"
    path.write_bytes(content)
    with pytest.raises(InputError):
        read_layer(path)
