"""USD: passes Pixar's own validators, and Pixar's skinning moves every vertex as mien does."""

from __future__ import annotations

import io
import struct
import zipfile
from pathlib import Path

import numpy as np
import pytest
import soundfile

from mien.animation.animation import Animation
from mien.core.channels import ALL
from mien.core.errors import MissingPartError, OutputError
from mien.face.library import load_face
from mien.face.model import Face
from mien.face.posing import Poser
from mien.formats import check_output, save
from mien.formats.usd import companion_folder, write_usd
from tests.faces import tiny_animation, tiny_face

pytest.importorskip("pxr", reason="USD needs the extra 'usd'")
KINDS = ("usdz", "usdc", "usda")


@pytest.fixture(scope="module")
def animation() -> Animation:
    return tiny_animation(5)


def faults(path: Path) -> list[str]:
    """What usdchecker would print: every validator that comes with USD."""
    from pxr import Usd, UsdValidation

    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    assert len(validators) > 20
    found = UsdValidation.ValidationContext(validators).Validate(Usd.Stage.Open(str(path)))
    return [f"{fault.GetName()}: {fault.GetMessage()}" for fault in found]


@pytest.mark.parametrize("kind", KINDS)
def test_passes_every_validator(kind: str, animation: Animation, tmp_path: Path) -> None:
    path = tmp_path / f"ä line.{kind}"
    write_usd(animation, tiny_face(), path)
    assert faults(path) == []


def test_the_validators_do_find_faults(animation: Animation, tmp_path: Path) -> None:
    path = tmp_path / "line.usda"
    write_usd(animation, load_face(), path)
    assert faults(path) == []
    (companion_folder(path) / "skin.jpg").unlink()
    assert any("skin.jpg" in fault for fault in faults(path))


@pytest.mark.parametrize("face", [tiny_face(), load_face()], ids=["tiny", "default"])
def test_pixars_skinning_moves_every_vertex_as_mien_does(face: Face, animation: Animation, tmp_path: Path) -> None:
    from pxr import Gf, Usd, UsdGeom, UsdSkel

    path = tmp_path / "line.usdc"
    write_usd(animation, face, path)
    stage = Usd.Stage.Open(str(path))
    assert (stage.GetEndTimeCode(), stage.GetTimeCodesPerSecond()) == (4, animation.rate.fps)
    assert UsdGeom.GetStageMetersPerUnit(stage) == 0.01
    assert UsdSkel.BakeSkinning(UsdSkel.Root(stage.GetDefaultPrim()), Gf.Interval(0, 4))
    poser = Poser(face, ALL)
    for frame, row in enumerate(animation.channels.select(ALL).values):
        for part, posed in zip(face.parts, poser.pose(row).parts, strict=True):
            points = np.array(UsdGeom.Mesh(stage.GetPrimAtPath(f"/mien/{part.name}")).GetPointsAttr().Get(frame))
            np.testing.assert_allclose(10 * points, posed.vertices, atol=0.02)


def test_a_package_holds_its_sound_and_pictures_aligned_and_uncompressed(animation: Animation, tmp_path: Path) -> None:
    path = tmp_path / "line.usdz"
    write_usd(animation, load_face(), path)
    content = path.read_bytes()
    with zipfile.ZipFile(path) as package:
        assert package.testzip() is None
        entries = package.infolist()
        assert entries[0].filename == "face.usdc"
        assert {"sound.wav", "skin.jpg"} <= set(package.namelist())
        samples, rate = soundfile.read(io.BytesIO(package.read("sound.wav")))
    for entry in entries:
        assert entry.compress_type == zipfile.ZIP_STORED
        name, extra = struct.unpack("<HH", content[entry.header_offset + 26 : entry.header_offset + 30])
        assert (entry.header_offset + 30 + name + extra) % 64 == 0
    audio = animation.utterance.audio
    assert rate == audio.rate
    np.testing.assert_allclose(samples, audio.samples, atol=1e-4)


def test_the_tint_of_vertices_arrives(animation: Animation, tmp_path: Path) -> None:
    """Mean colour of every part at its vertices, as its material shows it: texture, tint and colour; within 2 %."""
    from PIL import Image
    from pxr import Usd, UsdShade

    from mien.formats.face_motion import linear_light

    face = load_face()
    write_usd(animation, face, tmp_path / "line.usdc")
    stage = Usd.Stage.Open(str(tmp_path / "line.usdc"))

    def picked(picture: np.ndarray, uv: np.ndarray) -> np.ndarray:
        places = np.clip((uv * picture.shape[1::-1]).astype(int), 0, np.array(picture.shape[1::-1]) - 1)
        return linear_light(picture[places[:, 1], places[:, 0], :3] / 255.0)

    tinted = 0
    for part in face.parts:
        mesh = stage.GetPrimAtPath(f"/mien/{part.name}")
        lips = (
            (part.colours < 0.97).any(axis=1) if part.material.texture is not None else np.ones(len(part.colours), bool)
        )
        wanted = linear_light(part.colours) * linear_light(np.array(part.material.colour))
        if part.material.texture is None:
            shown = np.array(mesh.GetAttribute("primvars:displayColor").Get())
        else:
            material = UsdShade.MaterialBindingAPI(mesh).ComputeBoundMaterial()[0]
            file = stage.GetPrimAtPath(f"{material.GetPath()}/picture").GetAttribute("inputs:file").Get().resolvedPath
            uv = np.array(mesh.GetAttribute("primvars:st").Get()) * [1, -1] + [0, 1]
            shown = picked(np.array(Image.open(file)), uv)
            wanted = wanted * picked(part.material.texture, part.uv)
            tinted += int(lips.sum())
        for chosen in (slice(None), lips):
            if len(shown[chosen]):
                np.testing.assert_allclose(
                    shown[chosen].mean(axis=0), wanted[chosen].mean(axis=0), rtol=0.02, atol=0.002
                )
    assert tinted > 100, "the lips are tinted"


def test_the_sound_is_named_and_starts_with_the_first_frame(animation: Animation, tmp_path: Path) -> None:
    from pxr import Usd, UsdMedia

    write_usd(animation, tiny_face(), tmp_path / "line.usda")
    stage = Usd.Stage.Open(str(tmp_path / "line.usda"))
    sound = UsdMedia.SpatialAudio(stage.GetPrimAtPath("/mien/sound"))
    assert sound.GetFilePathAttr().Get().path == "./line_usda/sound.wav"
    assert sound.GetStartTimeAttr().Get().GetValue() == 0
    assert sound.GetAuralModeAttr().Get() == "nonSpatial"


def test_a_full_disk_takes_the_folder_along(
    animation: Animation, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    replace = Path.replace

    def full(self: Path, target: Path) -> Path:
        if str(target).endswith("line.usdc"):
            raise OSError(28, "No space left on device")
        return replace(self, target)

    monkeypatch.setattr(Path, "replace", full)
    with pytest.raises(OutputError, match="disk is full"):
        write_usd(animation, tiny_face(), tmp_path / "line.usdc")
    assert list(tmp_path.iterdir()) == []


def test_without_the_library_it_is_refused_before_any_work(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("mien.formats.usd.find_spec", lambda name: None)
    with pytest.raises(MissingPartError, match=r"pip install 'mien\[usd\]'"):
        check_output(tmp_path / "line.usdz")


def test_a_face_by_a_tree_says_what_it_loses(animation: Animation, tmp_path: Path) -> None:
    from mien.face.deformers import deformed_by

    notes = save(animation, tmp_path / "line.usdz", face=deformed_by(tiny_face(), "tree"))
    assert "USD moves targets on straight lines" in notes[0].message


def test_somebody_elses_face_passes_too(animation: Animation, tmp_path: Path) -> None:
    import mien
    from tests import zoo

    animal = zoo.arkit(tmp_path)
    mien.save(animation, tmp_path / "line.usdz", face=animal.path)
    assert faults(tmp_path / "line.usdz") == []


def test_a_cut_out_texture_keeps_its_holes(animation: Animation, tmp_path: Path) -> None:
    from dataclasses import replace

    from PIL import Image
    from pxr import Usd

    face = tiny_face()
    part = next(part for part in face.parts if part.material.texture is not None)
    texture = np.full((8, 8, 4), 200, np.uint8)
    texture[:4, :, 3] = 0
    cut = replace(part, material=replace(part.material, texture=texture))
    face = replace(face, parts=tuple(cut if one is part else one for one in face.parts))
    write_usd(animation, face, tmp_path / "line.usdc")
    assert faults(tmp_path / "line.usdc") == []
    stage = Usd.Stage.Open(str(tmp_path / "line.usdc"))
    previews = [prim for prim in stage.Traverse() if prim.GetName() == "preview"]
    assert [prim.GetAttribute("inputs:opacityThreshold").Get() for prim in previews].count(0.5) == 1
    (picture,) = companion_folder(tmp_path / "line.usdc").glob("*.png")
    assert not np.asarray(Image.open(picture))[:4, :, 3].any()
