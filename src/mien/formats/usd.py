"""``.usdz``, ``.usdc``, ``.usda``: the face and its performance for USD (UsdSkel blend shapes), with the sound.

::

    /mien                   SkelRoot, the default prim; y up, centimetres, the face looks along +z
    ├── skeleton            joints trunk, trunk/head, trunk/head/eye_left, trunk/head/eye_right
    ├── performance         SkelAnimation: one time sample per frame: weights by channel name, rotations of the joints
    ├── skin, teeth_lower…  one Mesh per part, each with its own BlendShape prims, named by channel
    ├── materials           UsdPreviewSurface
    └── sound               SpatialAudio, starts at time code 0

A ``.usdz`` holds everything, uncompressed, as its format asks. A ``.usdc`` (binary) or ``.usda`` (text) layer cannot
hold pictures and sound: they go into a folder beside it, ``line_usdc`` for ``line.usdc``, named relative to it.
"""

from __future__ import annotations

import io
import re
import zipfile
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.animation.animation import Animation
from mien.core.channels import HEAD, WEIGHTS
from mien.core.errors import InputError, MissingPartError, Note, OutputError
from mien.core.files import replace_when_complete
from mien.core.temporary_folder import temporary_folder
from mien.face.model import Eye, Face, Material, Part
from mien.face.posing import eye_rotation, head_rotation
from mien.formats.face_motion import TargetNormals, linear_light, lost_tree, playing_facts, quaternions
from mien.formats.tinted_picture import tinted_picture

__all__ = ["check_usd", "companion_folder", "write_usd"]

_CENTIMETRES = 0.1
_JPEG_QUALITY = 92
_LOOKS = ("Up", "Down", "In", "Out")
_JOINTS = 2  # that carry one vertex at most
_ALIGNED = 64  # bytes: where the content of every file in a .usdz begins

Floats = NDArray[np.float32]


def check_usd() -> None:
    """Say early whether USD can be written.

    Raises
    ------
    MissingPartError
        If Pixar's USD library is not installed.
    """
    if find_spec("pxr") is None:
        raise MissingPartError("USD files need Pixar's library: pip install 'mien[usd]' (or: pip install usd-core)")


def companion_folder(path: str | Path) -> Path:
    """Where pictures and sound of a ``.usdc`` or ``.usda`` file go.

    Examples
    --------
    >>> companion_folder("takes/line.usdc").as_posix()
    'takes/line_usdc'
    """
    path = Path(path)
    return path.with_name(f"{path.stem}_{path.suffix[1:].lower()}")


def write_usd(animation: Animation, face: Face, path: str | Path) -> tuple[Note, ...]:
    """Write a face that performs an animation as USD; the suffix picks the kind.

    Parameters
    ----------
    animation : Animation
    face : Face
    path : path-like
        Ends in ``.usdz``, ``.usdc`` or ``.usda``.

    Raises
    ------
    InputError
        If the animation has no frames.
    MissingPartError
        If the USD library is not installed.
    OutputError
        If the file cannot be written.
    """
    check_usd()
    path = Path(path)
    if len(animation.channels) == 0:
        raise InputError(f"cannot write {path}: the animation has no frames")
    kind = path.suffix[1:].lower()
    package = kind == "usdz"
    folder = "" if package else f"./{companion_folder(path).name}/"
    stage = _Stage(face, folder)
    layer = stage.layer(animation, "usda" if kind == "usda" else "usdc")
    files = {**stage.files, "sound.wav": _sound(animation)}
    if package:
        with replace_when_complete(path) as unfinished:
            unfinished.write_bytes(_packed({"face.usdc": layer, **files}))
    else:
        _write_beside(path, layer, files)
    notes = lost_tree(animation, face, "USD")
    if package:
        return notes
    return (
        *notes,
        Note("note", f"pictures and sound of {path.name} are in the folder {companion_folder(path).name}"),
    )


def _sound(animation: Animation) -> bytes:
    """As 16-bit WAV: the kind that every player of a USDZ takes."""
    import soundfile

    content, audio = io.BytesIO(), animation.utterance.audio
    soundfile.write(content, audio.samples, audio.rate, format="WAV", subtype="PCM_16")
    return content.getvalue()


def _write_beside(path: Path, layer: bytes, files: Mapping[str, bytes]) -> None:
    """Write the folder, then the layer; what was made is removed if the layer cannot take its place."""
    folder = companion_folder(path)
    fresh = not folder.exists()
    made: list[Path] = []
    try:
        with replace_when_complete(path) as unfinished:
            unfinished.write_bytes(layer)
            if fresh:
                folder.mkdir()
            for name, content in files.items():
                here = folder / name
                new = not here.exists()
                with replace_when_complete(here) as part:
                    part.write_bytes(content)
                made += [here] if new else []
    except OutputError:
        for here in made:
            here.unlink(missing_ok=True)
        if fresh and folder.exists():
            folder.rmdir()
        raise


def _packed(files: Mapping[str, bytes]) -> bytes:
    """A USDZ: a zip without compression in which every file's content begins at a multiple of 64 bytes."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_STORED) as package:
        for name, content in files.items():
            entry = zipfile.ZipInfo(name, date_time=(1980, 1, 1, 0, 0, 0))
            entry.create_system = 0
            begin = packed.tell() + 30 + len(name.encode("utf-8"))
            gap = -begin % _ALIGNED
            gap += _ALIGNED if 0 < gap < 4 else 0  # an extra field has a head of four bytes
            entry.extra = b"" if gap == 0 else b"\x19\x86" + (gap - 4).to_bytes(2, "little") + bytes(gap - 4)
            package.writestr(entry, content)
    return packed.getvalue()


class _Stage:
    """Builds the layer; pictures gather in ``files``."""

    def __init__(self, face: Face, folder: str) -> None:
        from pxr import Usd

        self.face, self.folder = face, folder
        self.files: dict[str, bytes] = {}
        self.stage = Usd.Stage.CreateInMemory()
        self._normals = TargetNormals(face)
        self._materials: dict[tuple[int, str], Any] = {}
        self._names, self._joint_names = _Identifiers(), _Identifiers()
        self._eyes = [(eye, self._joint(eye)) for eye in face.eyes]
        self._channels = [n for n in WEIGHTS if any(n in part.targets for part in face.parts)]

    def layer(self, animation: Animation, kind: str) -> bytes:
        """The layer's bytes."""
        from pxr import UsdSkel

        self._describe(animation)
        root = UsdSkel.Root.Define(self.stage, "/mien")
        self.stage.SetDefaultPrim(root.GetPrim())
        self._skeleton()
        self._motion(animation)
        self._extent(root)
        for part in self.face.parts:
            self._mesh(part)
        self._play_sound()
        with temporary_folder() as folder:
            file = folder / f"layer.{kind}"
            try:
                written = self.stage.GetRootLayer().Export(str(file))
            except RuntimeError as problem:  # pxr.Tf.ErrorException, with a line for every piece that failed
                reason = re.findall(r"'([^']*)'\s*$", str(problem), re.MULTILINE)[:1] or ["no reason given"]
                raise OutputError(
                    f"cannot write the USD layer to {folder}: {reason[0]}: is the disk full?"
                ) from problem
            if not written:
                raise OutputError(f"cannot write the USD layer to {folder}: is the disk full?")
            return file.read_bytes()

    def _describe(self, animation: Animation) -> None:
        from pxr import UsdGeom

        rate = animation.rate.fps
        UsdGeom.SetStageUpAxis(self.stage, UsdGeom.Tokens.y)
        UsdGeom.SetStageMetersPerUnit(self.stage, UsdGeom.LinearUnits.centimeters)
        self.stage.SetTimeCodesPerSecond(rate)
        self.stage.SetFramesPerSecond(rate)
        self.stage.SetStartTimeCode(0)
        self.stage.SetEndTimeCode(len(animation.channels) - 1)
        facts = {name: fact for name, fact in playing_facts(animation).items() if name != "words"}
        said = [{"start": word.start, "end": word.end, "label": word.label} for word in animation.utterance.words]
        facts |= {"words": {f"w{number}": word for number, word in enumerate(said)}}
        if self.face.licence:
            facts |= {"licence": self.face.licence}
        self.stage.GetRootLayer().customLayerData = {"mien": facts}

    # ------------------------------------------------------------ joints and motion

    def _joint(self, eye: Eye) -> str:
        return "trunk/head/" + self._joint_names.fresh(f"eye_{eye.side.lower()}", f"eye_{eye.side.lower()}_{eye.part}")

    def _places(self) -> list[tuple[float, float, float]]:
        """Of the joints: trunk at the origin, head at its pivot, eyes at their centres; centimetres."""
        return [(0.0, 0.0, 0.0), _scaled(self.face.head_pivot), *(_scaled(eye.centre) for eye, _ in self._eyes)]

    def _joints(self) -> list[str]:
        return ["trunk", "trunk/head", *(joint for _, joint in self._eyes)]

    def _locals(self) -> list[tuple[float, float, float]]:
        places = self._places()
        parents = [np.zeros(3), np.array(places[0]), *(np.array(places[1]) for _ in self._eyes)]
        steps = (np.array(place) - parent for place, parent in zip(places, parents, strict=True))
        return [(float(x), float(y), float(z)) for x, y, z in steps]

    def _skeleton(self) -> None:
        from pxr import Gf, UsdSkel

        def moves(places: Sequence[tuple[float, float, float]]) -> list[Any]:
            return [Gf.Matrix4d().SetTranslate(Gf.Vec3d(*place)) for place in places]

        skeleton = UsdSkel.Skeleton.Define(self.stage, "/mien/skeleton")
        skeleton.CreateJointsAttr(self._joints())
        skeleton.CreateBindTransformsAttr(moves(self._places()))
        skeleton.CreateRestTransformsAttr(moves(self._locals()))
        binding = UsdSkel.BindingAPI.Apply(skeleton.GetPrim())
        binding.CreateAnimationSourceRel().SetTargets(["/mien/performance"])

    def _motion(self, animation: Animation) -> None:
        from pxr import Gf, UsdSkel, Vt

        track, joints = animation.channels, self._joints()
        motion = UsdSkel.Animation.Define(self.stage, "/mien/performance")
        motion.CreateJointsAttr(joints)
        motion.CreateTranslationsAttr([Gf.Vec3f(*place) for place in self._locals()])
        motion.CreateScalesAttr([Gf.Vec3h(1, 1, 1)] * len(joints))
        turns = np.zeros((len(joints), len(track), 4))
        turns[0] = [0, 0, 0, 1]
        turns[1] = quaternions([head_rotation(*angles) for angles in track.select(HEAD).values])
        for number, (eye, _) in enumerate(self._eyes):
            looks = track.select([f"eyeLook{way}{eye.side}" for way in _LOOKS]).values
            turns[2 + number] = quaternions([eye_rotation(eye, *row) for row in looks])
        rotations = motion.CreateRotationsAttr()
        motion.CreateBlendShapesAttr(self._channels)
        weights = motion.CreateBlendShapeWeightsAttr()
        values = track.select(self._channels).values.astype(np.float32)
        for frame in range(len(track)):
            rotations.Set([Gf.Quatf(*(float(q[frame, k]) for k in (3, 0, 1, 2))) for q in turns], frame)
            weights.Set(Vt.FloatArray.FromNumpy(np.ascontiguousarray(values[frame])), frame)

    def _extent(self, root: Any) -> None:
        """The box of the head at rest, and room for turns and open jaws."""
        points = np.concatenate([part.vertices for part in self.face.parts]) * _CENTIMETRES
        low, high = points.min(axis=0) - 5.0, points.max(axis=0) + 5.0
        root.CreateExtentAttr([low.tolist(), high.tolist()])

    # ------------------------------------------------------------ meshes

    def _mesh(self, part: Part) -> None:
        from pxr import Tf, UsdGeom, UsdShade, UsdSkel, Vt

        path = f"/mien/{self._names.fresh(Tf.MakeValidIdentifier(part.name))}"
        mesh = UsdGeom.Mesh.Define(self.stage, path)
        points = np.ascontiguousarray(part.vertices * _CENTIMETRES, dtype=np.float32)
        mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points))
        mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(_whole(part.triangles.reshape(-1))))
        mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.full(len(part.triangles), 3, np.int32)))
        mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
        mesh.CreateDoubleSidedAttr(True)
        mesh.CreateExtentAttr(Vt.Vec3fArray.FromNumpy(np.stack([points.min(axis=0), points.max(axis=0)])))
        mesh.CreateNormalsAttr(Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(self._normals.at_rest(part))))
        mesh.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
        self._surface(mesh, part)
        binding = UsdSkel.BindingAPI.Apply(mesh.GetPrim())
        binding.CreateSkeletonRel().SetTargets(["/mien/skeleton"])
        joints, shares = self._carried(part)
        binding.CreateJointIndicesPrimvar(False, _JOINTS).Set(Vt.IntArray.FromNumpy(_whole(joints.reshape(-1))))
        binding.CreateJointWeightsPrimvar(False, _JOINTS).Set(Vt.FloatArray.FromNumpy(shares.reshape(-1)))
        self._shapes(part, path, binding)
        UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(self._material(part))

    def _carried(self, part: Part) -> tuple[NDArray[np.int32], Floats]:
        """Numbers and weights of the joints that carry each vertex, (n, 2) each."""
        joints, shares = np.zeros((len(part.vertices), _JOINTS), np.int32), np.zeros((len(part.vertices), _JOINTS))
        eyes = [number for number, (eye, _) in enumerate(self._eyes) if eye.part == part.name]
        if eyes:
            joints[:, 0], shares[:, 0] = 2 + eyes[0], 1.0
            return joints, shares.astype(np.float32)
        weight = np.clip(part.head_weight.astype(np.float64), 0.0, 1.0)
        joints[:, 0] = 1
        shares[:, 0], shares[:, 1] = weight, 1.0 - weight
        return joints, shares.astype(np.float32)

    def _shapes(self, part: Part, path: str, binding: Any) -> None:
        from pxr import Tf, UsdSkel, Vt

        paths, names = [], [name for name in self._channels if name in part.targets]
        for name in names:
            offsets = np.zeros(part.vertices.shape, np.float32)
            target = part.targets[name]
            np.add.at(offsets, target.vertices, target.offsets * np.float32(_CENTIMETRES))
            normals = self._normals.change(part, name)
            moved = np.flatnonzero(offsets.any(axis=1) | normals.any(axis=1)).astype(np.int32)
            shape = UsdSkel.BlendShape.Define(self.stage, f"{path}/{Tf.MakeValidIdentifier(name)}")
            shape.CreateOffsetsAttr(Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(offsets[moved])))
            shape.CreateNormalOffsetsAttr(Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(normals[moved])))
            shape.CreatePointIndicesAttr(Vt.IntArray.FromNumpy(moved))
            paths.append(shape.GetPath())
        if names:
            binding.CreateBlendShapesAttr(names)
            binding.CreateBlendShapeTargetsRel().SetTargets(paths)

    # ------------------------------------------------------------ looks

    def _surface(self, mesh: Any, part: Part) -> None:
        """Texture coordinates where there is a picture, else the vertices' colours."""
        from pxr import Sdf, UsdGeom, Vt

        primvars = UsdGeom.PrimvarsAPI(mesh)
        if part.material.texture is not None:
            places = np.stack([part.uv[:, 0], 1.0 - part.uv[:, 1]], axis=1).astype(np.float32)  # USD counts from below
            st = primvars.CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.vertex)
            st.Set(Vt.Vec2fArray.FromNumpy(np.ascontiguousarray(places)))
            return
        colours = linear_light(part.colours) * linear_light(np.array(part.material.colour))
        shown = primvars.CreatePrimvar("displayColor", Sdf.ValueTypeNames.Color3fArray, UsdGeom.Tokens.vertex)
        shown.Set(Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(colours, dtype=np.float32)))

    def _material(self, part: Part) -> Any:
        from pxr import Sdf, Tf, UsdShade

        material = part.material
        picture = tinted_picture(part)
        key = (id(material), "" if picture is material.texture else part.name)  # a tint is the part's own
        if key in self._materials:
            return self._materials[key]
        if not self._materials:
            self.stage.DefinePrim("/mien/materials", "Scope")
        path = f"/mien/materials/{self._names.fresh(Tf.MakeValidIdentifier(f'{material.name}_surface'))}"
        made = UsdShade.Material.Define(self.stage, path)
        shader = UsdShade.Shader.Define(self.stage, f"{path}/preview")
        shader.CreateIdAttr("UsdPreviewSurface")
        shader.CreateInput("roughness", Sdf.ValueTypeNames.Float).Set(float(material.roughness))
        shader.CreateInput("metallic", Sdf.ValueTypeNames.Float).Set(0.0)
        colour = shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f)
        colour.ConnectToSource(self._colour_source(path, material, picture))
        if picture is not None and picture.shape[2] == 4:  # cut out where it is see-through
            seen = UsdShade.Shader.Get(self.stage, f"{path}/picture").CreateOutput("a", Sdf.ValueTypeNames.Float)
            shader.CreateInput("opacity", Sdf.ValueTypeNames.Float).ConnectToSource(seen)
            shader.CreateInput("opacityThreshold", Sdf.ValueTypeNames.Float).Set(0.5)
        made.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
        self._materials[key] = made
        return made

    def _colour_source(self, path: str, material: Material, texture: NDArray[np.uint8] | None) -> Any:
        from pxr import Gf, Sdf, UsdShade

        reader = UsdShade.Shader.Define(self.stage, f"{path}/reader")
        if texture is None:
            reader.CreateIdAttr("UsdPrimvarReader_float3")
            reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set("displayColor")
            return reader.CreateOutput("result", Sdf.ValueTypeNames.Float3)
        reader.CreateIdAttr("UsdPrimvarReader_float2")
        reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set("st")
        picture = UsdShade.Shader.Define(self.stage, f"{path}/picture")
        picture.CreateIdAttr("UsdUVTexture")
        picture.CreateInput("file", Sdf.ValueTypeNames.Asset).Set(self._picture(material.name, texture))
        picture.CreateInput("sourceColorSpace", Sdf.ValueTypeNames.Token).Set("sRGB")
        tint = linear_light(np.array(material.colour))
        picture.CreateInput("scale", Sdf.ValueTypeNames.Float4).Set(Gf.Vec4f(*(float(c) for c in tint), 1.0))
        for axis in ("wrapS", "wrapT"):
            picture.CreateInput(axis, Sdf.ValueTypeNames.Token).Set("repeat")
        coordinates = reader.CreateOutput("result", Sdf.ValueTypeNames.Float2)
        picture.CreateInput("st", Sdf.ValueTypeNames.Float2).ConnectToSource(coordinates)
        return picture.CreateOutput("rgb", Sdf.ValueTypeNames.Float3)

    def _picture(self, title: str, texture: NDArray[np.uint8]) -> str:
        from PIL import Image
        from pxr import Tf

        stream = io.BytesIO()
        picture = Image.fromarray(np.ascontiguousarray(texture))
        kind = "PNG" if texture.shape[2] == 4 else "JPEG"
        picture.save(stream, kind, quality=_JPEG_QUALITY, subsampling=0)
        content = stream.getvalue()
        for name, held in self.files.items():
            if held == content:  # both eyes show one picture
                return self.folder + name
        stem, ending = Tf.MakeValidIdentifier(title), "png" if kind == "PNG" else "jpg"
        name = f"{stem}.{ending}"
        if name in self.files:
            name = f"{stem}_{len(self.files)}.{ending}"
        self.files[name] = content
        return self.folder + name

    def _play_sound(self) -> None:
        """From time code 0, which is what the schema takes where no start is told."""
        from pxr import UsdMedia

        sound = UsdMedia.SpatialAudio.Define(self.stage, "/mien/sound")
        sound.CreateFilePathAttr(f"{self.folder}sound.wav")
        sound.CreateAuralModeAttr(UsdMedia.Tokens.nonSpatial)
        sound.CreatePlaybackModeAttr(UsdMedia.Tokens.onceFromStart)


class _Identifiers:
    """Names that have not been given yet."""

    def __init__(self) -> None:
        self._given = {"skeleton", "performance", "materials", "sound"}

    def fresh(self, *wishes: str) -> str:
        """The first wish that is free, else the last one with a number."""
        numbered = (f"{wishes[-1]}_{number}" for number in range(2, len(self._given) + 3))
        name = next(n for n in (*wishes, *numbered) if n not in self._given)
        self._given.add(name)
        return name


def _scaled(point: Sequence[float]) -> tuple[float, float, float]:
    x, y, z = (float(number) * _CENTIMETRES for number in point)
    return x, y, z


def _whole(numbers: NDArray[Any]) -> NDArray[np.int32]:
    return np.ascontiguousarray(numbers, dtype=np.int32)
