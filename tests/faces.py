"""A small face and a short performance for tests: every channel moves something, nothing looks like a person."""

from __future__ import annotations

import numpy as np

from mien.animation.animation import Animation, Provenance
from mien.core.audio import Audio
from mien.core.channels import ALL, ARKIT, MUSCLES, TONGUE
from mien.core.errors import Note
from mien.core.timeline import FrameRate, Interval, Tier
from mien.core.tracks import ChannelTrack, MarkerTrack
from mien.core.utterance import PAUSE, Utterance
from mien.face.model import Eye, Face, Material, Part, Target
from mien.text.effort_spans import EffortCurve, EffortSpan
from mien.text.score import EmotionSpan, Score

PIVOT = (0.0, -110.0, -60.0)

VOICED = EffortSpan(EffortCurve((0.0, 0.25), (0.9, 1.3), "linear"), source="voice")


def ball(centre, radii, rings: int, segments: int):
    """Vertices, triangles (counter-clockwise from outside) and texture coordinates of an ellipsoid; pole along y."""
    down, around = np.meshgrid(np.linspace(0, np.pi, rings + 1), np.linspace(0, 2 * np.pi, segments + 1), indexing="ij")
    unit = np.stack([np.sin(down) * np.sin(around), np.cos(down), np.sin(down) * np.cos(around)], axis=-1)
    vertices = (np.asarray(centre) + unit * radii).reshape(-1, 3).astype(np.float32)
    uv = np.stack([around / (2 * np.pi), down / np.pi], axis=-1).reshape(-1, 2).astype(np.float32)
    first = (np.arange(rings)[:, None] * (segments + 1) + np.arange(segments)).reshape(-1)
    a, b, c, d = first, first + segments + 1, first + segments + 2, first + 1
    triangles = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]).astype(np.int32)
    return vertices, triangles, uv


def bump(vertices, place, move, reach: float) -> Target:
    """A target that moves the vertices near a place."""
    distance = np.linalg.norm(vertices - np.asarray(place), axis=1)
    near = np.flatnonzero(distance < reach)
    share = (1 - distance[near] / reach)[:, None]
    return Target(near.astype(np.int32), (share * np.asarray(move)).astype(np.float32))


def tiny_face() -> Face:
    """A head of some 600 vertices: skin with a texture and a neck, teeth, tongue and two eyeballs."""
    vertices, triangles, uv = ball((0, -30, -75), (75, 115, 90), 16, 24)
    targets = {}
    for number, name in enumerate((*ARKIT, *MUSCLES)):
        if name.startswith("eyeLook"):
            continue
        angle = 2.4 * number
        place = (45 * np.sin(angle), -20 + 60 * np.cos(angle), 5)
        targets[name] = bump(vertices, place, (3 * np.cos(angle), 4 * np.sin(angle), 6), 45)
    targets["jawOpen"] = bump(vertices, (0, -95, -20), (0, -25, -5), 60)
    ramp = np.clip((vertices[:, 1] + 120) / 40, 0, 1).astype(np.float32)
    checks = (np.indices((32, 32)).sum(axis=0) // 4 % 2)[..., None]
    texture = (np.array([200, 150, 130]) + checks * np.array([30, 30, 30])).astype(np.uint8)
    skin = Material("skin", texture=texture, roughness=0.55, scatter=0.5)
    white = np.ones_like(vertices)
    parts = [Part("skin", vertices, triangles, uv, white, skin, ramp, targets)]

    vertices, triangles, uv = ball((0, -62, 12), (15, 5, 5), 4, 8)
    shaded = np.tile(np.linspace(0.4, 1, len(vertices), dtype=np.float32)[:, None], 3)
    jaw = {"jawOpen": bump(vertices, (0, -62, 12), (0, -12, -2), 60)}
    enamel = Material("enamel", (0.9, 0.9, 0.8), roughness=0.2)
    parts.append(Part("teeth", vertices, triangles, uv, shaded, enamel, np.ones(len(vertices), np.float32), jaw))

    vertices, triangles, uv = ball((0, -70, 10), (8, 4, 12), 4, 8)
    lift = {name: bump(vertices, (0, -70, 22), (0, 4 + i, 0), 20) for i, name in enumerate((*TONGUE, "tongueOut"))}
    pink = Material("tongue", (0.8, 0.3, 0.3))
    whole = np.ones(len(vertices), np.float32)
    parts.append(Part("tongue", vertices, triangles, uv, np.ones_like(vertices), pink, whole, lift))

    eyes = []
    for side, x in (("Left", 32.0), ("Right", -32.0)):
        vertices, triangles, uv = ball((x, 0, 0), (14, 14, 14), 8, 12)
        iris = np.where(vertices[:, 2:] > 11, np.float32([[0.1, 0.1, 0.3]]), np.float32([[1, 1, 1]]))
        name, whole = f"eye_{side.lower()}", np.ones(len(vertices), np.float32)
        parts.append(Part(name, vertices, triangles, uv, iris, Material(name, roughness=0.1), whole))
        eyes.append(Eye(name, side, (x, 0.0, 0.0), 25.0, 30.0, 35.0, 40.0))
    return Face("tiny", tuple(parts), tuple(eyes), PIVOT, {"nose": ("skin", 0)}, "CC0")


def tiny_animation(frames: int = 30, rate: FrameRate | None = None, seed: int = 3) -> Animation:
    """A performance in which every channel moves, with markers, sound, words and notes."""
    rate = rate or FrameRate.of(25)
    rng = np.random.default_rng(seed)
    values = rng.uniform(0, 1, (frames, len(ALL)))
    values[:, ALL.index("headYaw") :] = rng.uniform(-20, 20, (frames, 3))
    positions = rng.normal(0, 50, (frames, 2, 3))
    positions[0, 1] = np.nan
    duration = rate.time_of(frames)
    sound = Audio(rng.uniform(-1, 1, round(duration * 8000)), 8000)
    half = sound.duration / 2
    phones = (Interval(0, half, PAUSE), Interval(half, 0.75 * sound.duration, "AH"))
    phones += (Interval(0.75 * sound.duration, sound.duration, "P"),)
    words = Tier("words", (Interval(half, sound.duration, 'up "there"'),))
    note = Note("note", "the sound had two channels; their mean is used")
    speech = Utterance('Up "there" – ä', sound, words, Tier("phones", phones), "en-US", "aligned", (note,))
    return Animation(
        ChannelTrack(ALL, values, rate),
        MarkerTrack(("chin", "brow"), positions, rate),
        speech,
        Score((EmotionSpan("happy", 0.6, None, half),), efforts=(EffortSpan(1.4, None, half), VOICED)),
        Provenance("hand-made", 7, "0.1.0"),
        (Note("warning", "lips pass through each other in frame 3"),),
    )
