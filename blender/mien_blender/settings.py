"""What is set in the panel, kept in the scene."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

from . import environment


def _listed(kind: str):
    return lambda _self, _context, typed: [name for name in environment.names_of(kind) if typed.lower() in name]


class MIEN_PG_line(bpy.types.PropertyGroup):
    """The line that is to be performed."""

    head: PointerProperty(type=bpy.types.Object, name="Head", description="Any object of the head that is to speak")
    source: EnumProperty(
        name="From",
        items=[
            ("TEXT", "Text", "Words to be spoken by a synthetic voice"),
            ("SOUND", "Sound", "Recorded speech"),
            ("FILE", "Motion", "A mien .json or a Live Link Face .csv"),
        ],
    )
    text: StringProperty(
        name="Text", description="What is said; tags such as <nod/> give direction", default="Hello there."
    )
    sound: StringProperty(name="Sound", subtype="FILE_PATH", description="A sound file, or a video with sound")
    transcript: StringProperty(
        name="Said", subtype="FILE_PATH", description="A text file or a Praat TextGrid of what is said; empty: heard"
    )
    file: StringProperty(name="File", subtype="FILE_PATH", description="A mien .json or a Live Link Face .csv")
    voice: StringProperty(name="Voice", search=_listed("voices"), description="Empty: the default voice")
    language: StringProperty(name="Language", search=_listed("languages"), description="Empty: English")
    emotion: StringProperty(name="Emotion", search=_listed("emotions"), description="Empty: neutral")
    strength: FloatProperty(name="Strength", default=1.0, min=0.0, max=1.0, subtype="FACTOR")
    seed: IntProperty(name="Seed", default=0, min=0, description="Of blinks, glances and drift")
    start: IntProperty(name="Start", default=1, description="The frame with which the sound starts")
    markers: EnumProperty(
        name="Markers",
        items=[
            ("BOTH", "Words and phones", "Move a phone's marker and perform again to move the phone"),
            ("WORDS", "Words", "Words alone"),
            ("NONE", "None", "No markers"),
        ],
    )
    keep: BoolProperty(
        name="Keep my edits", default=True, description="Lay what you changed by hand on the new performance"
    )
    status: StringProperty(options={"SKIP_SAVE"})


class MIEN_AP_preferences(bpy.types.AddonPreferences):
    """Where mien is."""

    bl_idname = __package__
    program: StringProperty(name="mien", subtype="FILE_PATH", description="The mien program; empty: looked for")

    def draw(self, _context: bpy.types.Context) -> None:
        found = environment.program()
        self.layout.label(text=f"mien: {found}" if found else "mien was not found on this computer")
        self.layout.prop(self, "program")
        self.layout.operator("mien.install")


def register() -> None:
    for kind in (MIEN_PG_line, MIEN_AP_preferences):
        bpy.utils.register_class(kind)
    bpy.types.Scene.mien = PointerProperty(type=MIEN_PG_line)


def unregister() -> None:
    del bpy.types.Scene.mien
    for kind in (MIEN_AP_preferences, MIEN_PG_line):
        bpy.utils.unregister_class(kind)
