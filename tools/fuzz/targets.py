"""Every reader of mien, with sound files to begin from.

A target reads one file. What it raises on purpose is a `MienError`; anything else is a fault.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from tools.fuzz import readers, seeds

__all__ = ["TARGETS", "Target"]


@dataclass(frozen=True)
class Target:
    """One reader.

    Attributes
    ----------
    name : str
    suffix : str
        Of the files that it is given.
    read : callable
    seeds : callable
        Makes sound files in a folder and returns them.
    """

    name: str
    suffix: str
    read: Callable[[Path], object]
    seeds: Callable[[Path], Sequence[Path | bytes]]


TARGETS: tuple[Target, ...] = (
    Target("script", ".txt", readers.script, seeds.lines(seeds.SCRIPT, seeds.TEXT)),
    Target("ssml", ".ssml", readers.script, seeds.lines(seeds.SSML)),
    Target("bml", ".bml", readers.script, seeds.lines(seeds.BML)),
    Target("spoken", ".txt", readers.spoken, seeds.lines(seeds.TEXT, seeds.SCRIPT)),
    Target("messages", ".txt", readers.messages, seeds.lines(seeds.SCRIPT, seeds.SSML, '<HeadNod at="1"\ncount="2">\n<!-- a\n-->\n<Smile/>\n')),
    Target("commands", ".txt", readers.call("mien.text.library_file", "read_library_file"), seeds.of_assets("commands/*.txt")),
    Target("intensity", ".csv", readers.call("mien.text.intensity", "read_intensity"), seeds.lines("seconds,happy\n0,0.1\n1,0.9\n2.5,0\n")),
    Target(
        "expression parameters", ".csv", readers.call("mien.text.expression_parameters", "read_expression_parameters"),
        seeds.lines("seconds,expression1,intensity1,expression2,intensity2\n0,joy,30,,\n0.5,joy,60,sadness,3\n"),
    ),
    Target("language", ".toml", readers.by_name("mien.text.languages.language", "find_language"), seeds.of_assets("languages/*.toml")),
    Target("textgrid", ".TextGrid", readers.call("mien.formats.textgrid", "read_textgrid"), seeds.grids),
    Target("transcript grid", ".TextGrid", readers.call("mien.corpus.transcripts", "read_transcript"), seeds.grids),
    Target("transcript lab", ".lab", readers.call("mien.corpus.transcripts", "read_transcript"), seeds.lines("0 1000000 hello\n1000000 2000000 there\n")),
    Target("transcript align", ".align", readers.call("mien.corpus.transcripts", "read_transcript"), seeds.lines("0 23750 sil\n23750 29500 bin\n")),
    Target("table", ".csv", readers.call("mien.corpus.transcripts", "read_table"), seeds.lines('name,text,emotion\na,"Hello, you",happy\nb;,x,\n')),
    Target("list", ".txt", readers.call("mien.metrics.splits", "read_list", "takes"), seeds.lines("a b # c\nd\n")),
    Target("design", ".csv", readers.call("mien.api.stimuli.design", "read_design"), seeds.lines("name,sentence,emotion,intensity\na,Hello.|Bye.,happy|sad,0.5|1\n")),
    Target("livelink", ".csv", readers.call("mien.formats.livelink", "read_livelink"), seeds.livelink),
    Target("livelink recording", ".csv", readers.recording("livelink"), seeds.livelink),
    Target("native", ".json", readers.call("mien.formats.native", "read_native"), seeds.native),
    Target("layer", ".json", readers.call("mien.animation.edits.layer_file", "read_layer"), seeds.layers),
    Target("fap", ".fap", readers.call("mien.formats.fap", "read_fap"), seeds.faps),
    Target("beat recording", ".json", readers.recording("beat"), seeds.beat),
    Target("marker table", ".csv", readers.recording("tracks"), seeds.marker_tables),
    Target("marker archive", ".npz", readers.recording("tracks"), seeds.marker_archives),
    Target("c3d", ".c3d", readers.recording("c3d"), seeds.c3d),
    Target("sound", ".wav", readers.call("mien.formats.sound_files", "read_audio"), seeds.sounds),
    Target("sound text", ".txt", readers.sound_text, seeds.sound_texts),
    Target("video", ".mp4", readers.read_video, seeds.videos),
    Target("picture", ".png", readers.read_picture, seeds.pictures),
    Target("obj", ".obj", readers.mesh, seeds.lines(seeds.OBJ)),
    Target("ply", ".ply", readers.mesh, seeds.binary_ply),
    Target("bare glb", ".glb", readers.mesh, seeds.zoo),
    Target("foreign glb", ".glb", readers.read_foreign, seeds.zoo),
    Target("foreign gltf", ".gltf", readers.read_foreign, seeds.text_zoo),
    Target("drawn glb", ".glb", readers.draw_foreign, seeds.zoo),
    Target("face", ".npz", readers.call("mien.face.storage", "read_face"), seeds.small_faces),
    Target("tree", ".tree", readers.call("mien.face.tree_config", "read_tree"), seeds.lines(seeds.TREE)),
    Target("landmarks csv", ".csv", readers.call("mien.fit.landmarks", "read_landmarks", 1), seeds.lines("name,vertex\nnose_tip,3\nchin,4\n")),
    Target("landmarks json", ".json", readers.call("mien.fit.landmarks", "read_landmarks", 3), seeds.lines('{"nose_tip": [1, 2, 3], "chin": [0, 0, 1]}')),
    Target("names", ".toml", readers.call("mien.face.foreign.rig_names", "own_names"), seeds.lines('faces = "+z"\n[targets]\njawOpen = "Mouth"\n[eyes]\nUp = 20\n')),
    Target("recipe", ".toml", readers.by_name("mien.corpus.recipes", "load_recipe"), seeds.of_assets("recipes/*.toml")),
    Target("layout", ".toml", readers.by_name("mien.capture.layouts", "load_layout"), seeds.of_assets("markers/*.toml")),
    Target("classifier", ".npz", readers.call("mien.emotion.emotion_classifier", "load_classifier"), seeds.learned),
    Target("performer", ".mien", readers.call("mien.motion.performer_file", "load_learned"), seeds.performers),
    Target("stl", ".stl", readers.mesh, seeds.stl),
    Target("camera", ".toml", readers.call("mien.face.render.camera", "camera_table"), seeds.of_assets("render/cameras/*.toml")),
    Target("light", ".toml", readers.light, seeds.of_assets("render/lights/*.toml")),
    Target("emotion", ".toml", readers.table_of("performance/emotions", readers.own_emotion), seeds.of_assets("performance/emotions/*.toml")),
    Target("person", ".toml", readers.table_of("faces/cast", readers.own_person), seeds.of_assets("faces/cast/*.toml")),
    Target("project", ".zip", readers.project, seeds.projects),
    Target("journal", ".jsonl", readers.journal, seeds.lines("\n".join(map(json.dumps, seeds.LINES)))),
    Target("stream", ".bin", readers.stream, seeds.stream_messages),
)  # fmt: skip
