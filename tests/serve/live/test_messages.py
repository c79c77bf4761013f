"""Messages and packets: what was put in comes out, and anything else is refused in one line."""

from __future__ import annotations

import contextlib
import json
import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pylivelinkface import FaceBlendShape, PyLiveLinkFace
from pythonosc.osc_bundle import OscBundle

from mien.core import channels
from mien.core.errors import InputError
from mien.core.timeline import FrameRate
from mien.serve.live.datagrams import livelink_encoder
from mien.serve.live.frames import Frame, Greeting, decode_frame, encode_frame
from mien.serve.live.livelink_packets import LiveLinkPacket, decode_livelink, encode_livelink
from mien.serve.live.osc import decode_packet, encode_bundle, encode_message
from mien.serve.live.vmc import HEAD_REST, VmcEncoder


def frame(**given_channels: float) -> Frame:
    values = np.zeros(len(channels.ALL))
    for name, value in given_channels.items():
        values[channels.ALL.index(name)] = value
    return Frame(3, 0.1, values)


@given(st.integers(0, 2**32 - 1), st.floats(0, 1e6), st.lists(st.floats(-90, 90, width=32), max_size=80))
def test_a_frame_comes_back_as_it_was(number: int, time: float, values: list[float]) -> None:
    back = decode_frame(encode_frame(Frame(number, time, np.array(values))))
    assert (back.number, back.time) == (number, time)
    np.testing.assert_array_equal(back.values, values)


def test_the_bytes_of_a_frame_are_those_of_the_document() -> None:
    assert encode_frame(Frame(7, 0.25, np.array([1.0, -2.0]))) == struct.pack("<BBHIdff", 1, 1, 2, 7, 0.25, 1.0, -2.0)


@given(st.binary(max_size=80))
def test_other_bytes_are_no_frame(message: bytes) -> None:
    for decode in (decode_frame, decode_livelink, decode_packet):
        with contextlib.suppress(InputError):  # any other error fails the test
            decode(message)


def test_a_frame_cut_short_says_how_much_is_missing() -> None:
    with pytest.raises(InputError, match="frame 3: expected 24 bytes for 2 channels, got 23"):
        decode_frame(encode_frame(Frame(3, 0.0, np.zeros(2)))[:-1])


def test_a_greeting_of_another_version_is_refused() -> None:
    message = json.dumps({"format": "mien-live", "version": 2, "channels": [], "fps": 30})
    with pytest.raises(InputError, match="expected mien-live 1, got mien-live 2"):
        Greeting.decode(message)


@pytest.mark.parametrize(
    "message", ["", "{}", "[1]", '{"format": "mien-live", "version": 1, "channels": [1], "fps": 2}']
)
def test_other_texts_are_no_greeting(message: str) -> None:
    with pytest.raises(InputError):
        Greeting.decode(message)


@given(
    st.text(alphabet=st.characters(exclude_characters="\0", exclude_categories=["Cs"])),
    st.integers(-(2**31), 2**31 - 1),
)
def test_osc_arguments_come_back(text: str, number: int) -> None:
    packet = encode_bundle(encode_message("/a/b", text, number, 0.5), encode_message("/c"))
    assert len(packet) % 4 == 0
    assert decode_packet(packet) == (("/a/b", (text, number, 0.5)), ("/c", ()))


def test_vmc_sends_every_arkit_shape_then_applies_them() -> None:
    messages = decode_packet(VmcEncoder(channels.ALL).encode(frame(jawOpen=0.5)))
    addresses = [address for address, _ in messages]
    assert addresses == [
        "/VMC/Ext/OK",
        "/VMC/Ext/T",
        *["/VMC/Ext/Blend/Val"] * 52,
        "/VMC/Ext/Blend/Apply",
        "/VMC/Ext/Bone/Pos",
    ]
    sent = dict(arguments for address, arguments in messages if address.endswith("Val"))
    assert sent["JawOpen"] == 0.5
    assert sum(map(float, sent.values())) == 0.5


def test_vmc_presets_for_avatars_without_arkit_shapes() -> None:
    sent = dict(
        a
        for address, a in decode_packet(
            VmcEncoder(channels.ALL, "vrm").encode(frame(eyeBlinkLeft=1.0, mouthPucker=1.0))
        )
        if address.endswith("Val")
    )
    moods = {"Joy": 0, "Angry": 0, "Sorrow": 0, "Fun": 0, "Surprised": 0}
    assert sent == pytest.approx({"A": 0, "I": 0, "U": 0.9, "E": 0, "O": 0, "Blink_L": 1, "Blink_R": 0, **moods})


def test_python_osc_reads_vrm_1_names_and_the_resting_head() -> None:
    values = frame(browDownLeft=1.0, browDownRight=1.0, noseSneerLeft=0.5, headYaw=60.0)
    bundle = OscBundle(VmcEncoder(channels.ALL, "vrm1", (0.0, 0.1, 0.0)).encode(values))
    messages = [(bundle.content(place).address, bundle.content(place).params) for place in range(bundle.num_contents)]
    sent = dict(params for address, params in messages if address == "/VMC/Ext/Blend/Val")
    assert sent["angry"] == pytest.approx(1.0)
    assert (sent["happy"], sent["aa"]) == (0.0, 0.0)
    address, (bone, *numbers) = messages[-1]
    assert (address, bone) == ("/VMC/Ext/Bone/Pos", "Head")
    assert numbers == pytest.approx([0.0, 0.1, 0.0, 0.0, -0.5, 0.0, np.sqrt(0.75)], abs=1e-6)
    bare = OscBundle(VmcEncoder(channels.ALL, "vrm1", None).encode(values))
    assert bare.content(bare.num_contents - 1).address == "/VMC/Ext/Blend/Apply"


def test_py_livelink_face_reads_the_timecode_of_the_clock() -> None:
    encode = livelink_encoder(channels.ALL, FrameRate.of(60), "mien")
    values = frame(jawOpen=0.5, headPitch=10.0)
    known, face = PyLiveLinkFace.decode(encode(Frame(3, 0.05, values.values, 3600.0)))
    assert known
    assert face._frames == 216_000
    assert face.get_blendshape(FaceBlendShape.JawOpen) == pytest.approx(0.5)
    assert face.get_blendshape(FaceBlendShape.HeadPitch) == pytest.approx(-np.radians(10.0), abs=1e-6)  # up is negative


@pytest.mark.parametrize(
    ("channel", "axis"),
    # Unity is left-handed, x to the avatar's right: a turn to its left is negative about y, looking up negative
    # about x, tipping to the left shoulder positive about z.
    [("headYaw", (0.0, -1.0, 0.0)), ("headPitch", (-1.0, 0.0, 0.0)), ("headRoll", (0.0, 0.0, 1.0))],
)
def test_the_head_turns_in_unitys_axes(channel: str, axis: tuple[float, float, float]) -> None:
    address, arguments = decode_packet(VmcEncoder(channels.ALL).encode(frame(**{channel: 60.0})))[-1]
    assert (address, arguments[0]) == ("/VMC/Ext/Bone/Pos", "Head")
    assert arguments[1:4] == pytest.approx(HEAD_REST)
    assert arguments[4:] == pytest.approx((*(0.5 * part for part in axis), np.sqrt(0.75)), abs=1e-6)


def test_vmc_needs_the_channels_of_the_head() -> None:
    with pytest.raises(InputError, match="headYaw is missing"):
        VmcEncoder(channels.ARKIT)
    with pytest.raises(InputError, match="did you mean 'vrm'"):
        VmcEncoder(channels.ALL, "vrn")


def test_a_livelink_packet_comes_back_as_it_was() -> None:
    packet = LiveLinkPacket("ABC", "Ännä", 12, (30000, 1001), np.linspace(-1, 1, 61))
    back = decode_livelink(encode_livelink(packet))
    assert (back.device, back.subject, back.frame, back.rate) == ("ABC", "Ännä", 12, (30000, 1001))
    np.testing.assert_allclose(back.numbers, packet.numbers, atol=1e-7)


def test_the_bytes_of_a_livelink_packet_are_those_of_the_app() -> None:
    data = encode_livelink(LiveLinkPacket("D" * 36, "iPhone", 5, (60, 1), np.zeros(61)))
    assert data[:5] == b"\x06\x00\x00\x00$"  # receivers in the field look for these five bytes
    assert data[41:51] == b"\x00\x00\x00\x06iPhone"
    assert data[51:68] == struct.pack(">if2iB", 5, 0.0, 60, 1, 61)
    assert len(data) == 68 + 4 * 61
