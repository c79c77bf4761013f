"""How much light reaches every vertex, on a graphics card: the kernels of `mien.face.render.light` again, in GLSL.

The lights' maps are drawn as depth pictures, the key light's by itself and the soft ones side by side in one; all
vertices are lit, and light spreads below the skin between all of them, seen or not.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.face.render import light
from mien.face.render.light import light_axes
from mien.face.render.renderer import SPREAD_STEPS, Renderer

__all__ = ["LightOnCard"]

_ACROSS = 4  # soft maps side by side
_FAR = 8.0  # how many times the radius of the head's ball a map is deep: shoulders lie outside
_TOGETHER = 64

_CAST = """
#version 430
uniform vec3 axes[3];
uniform vec3 centre;
uniform float radius;
in vec3 in_vertex;
void main() {
    vec3 from = in_vertex - centre;
    gl_Position = vec4(vec3(dot(axes[0], from), dot(axes[1], from), dot(axes[2], from) / FAR) / radius, 1.0);
}
"""

_DARK = """
#version 430
void main() {}
"""

_BUFFERS = """
layout(local_size_x = TOGETHER) in;
layout(std430, binding = 0) readonly buffer Vertices { float vertices[]; };
layout(std430, binding = 1) readonly buffer Normals { float normals[]; };
layout(std430, binding = 2) readonly buffer About { vec4 about[]; };  // scatter thin lift cavity; spacing side weld
layout(std430, binding = 3) buffer Lit { vec4 lit[]; };  // light, and the key light's share
layout(std430, binding = 4) buffer Dome { float dome_share[]; };
layout(std430, binding = 5) readonly buffer From { vec4 from[]; };
layout(std430, binding = 6) readonly buffer Starts { int start[]; };
layout(std430, binding = 7) readonly buffer Neighbours { vec4 neighbour[]; };  // weight, and which vertex
"""

_GATHERED = (
    "#version 430\n"
    + _BUFFERS
    + """
uniform vec3 axes[3 * LIGHTS];
uniform vec3 colours[LIGHTS];
uniform vec3 place;
uniform vec3 centre;
uniform float radius;
uniform vec3 wrap;
uniform vec3 bounce;
uniform vec3 deep;  // 1 / how deep each colour goes through flesh
uniform sampler2D key_map;
uniform sampler2D soft_maps;

float near, nearest;

float depth(int k, ivec2 cell) {
    float stored = k == 0 ? texelFetch(key_map, cell, 0).r
                          : texelFetch(soft_maps, cell + SOFT * ivec2((k - 1) % ACROSS, (k - 1) / ACROSS), 0).r;
    return (2.0 * stored - 1.0) * FAR * radius;
}

float share_seen(int k, vec3 q) {
    int cells = k == 0 ? KEY : SOFT;
    float middle = 0.5 * float(cells);
    vec2 at = (middle / radius) * vec2(dot(axes[3 * k], q), dot(axes[3 * k + 1], q)) + middle - 0.5;
    near = dot(axes[3 * k + 2], q);
    bool inside = all(greaterThanEqual(at, vec2(0.0))) && all(lessThan(at, vec2(cells - 1)));
    if (!inside) at = vec2(0.0);
    ivec2 low = ivec2(at);
    vec2 f = at - vec2(low);
    vec4 d = vec4(depth(k, low), depth(k, low + ivec2(1, 0)), depth(k, low + ivec2(0, 1)), depth(k, low + 1));
    nearest = max(max(d.x, d.y), max(d.z, d.w));
    vec4 seen = vec4(greaterThanEqual(vec4(near), d));
    return inside ? mix(mix(seen.x, seen.y, f.x), mix(seen.z, seen.w, f.x), f.y) : 1.0;
}

void main() {
    int v = int(gl_GlobalInvocationID.x);
    if (v >= dome_share.length()) return;
    vec3 vertex = vec3(vertices[3 * v], vertices[3 * v + 1], vertices[3 * v + 2]);
    vec3 n = vec3(normals[3 * v], normals[3 * v + 1], normals[3 * v + 2]), p = vertex - centre;
    float scatter = about[2 * v].x, thin = about[2 * v].y, lift = about[2 * v].z, cavity = about[2 * v].w;
    int side = int(about[2 * v + 1].y);
    float shaded = 1.0;
    if (side > 0) {
        float away = dot(n, vertex - place), turned = 1.0;
        if (side == 1 ? away > 0.0 : dot(n, p) < 0.0) turned = -1.0;
        if (side == 2) shaded = clamp(LIT_THROUGH - 2.0 * turned * away / (distance(vertex, place) + 1e-9), 0.0, 1.0);
        n *= turned;
    }
    float off_soft = lift + (lift > 0.5 ? SOFT_CELLS_OFF * 2.0 * radius / SOFT : 0.0);
    float apart = max(KEY_EDGE_MM, 0.8 * about[2 * v + 1].x);
    float dome = 1e-6, dome_seen = 1e-6, key = 0.0;
    vec3 light = vec3(0.0);
    for (int k = 0; k < LIGHTS; k++) {
        vec3 l = axes[3 * k + 2];
        float facing = dot(n, l), seen = 0.0, thick = 0.0;
        if (k == 0) {
            for (int i = -1; i <= 1; i++) for (int j = -1; j <= 1; j++) {
                vec3 a = float(i) * axes[0] + float(j) * axes[1];
                float back = -dot(n, a) / max(facing, 0.25);
                seen += share_seen(0, p + lift * (n + l) + apart * (a + back * l)) / 9.0;
                if (i == 0 && j == 0) thick = nearest - near;
            }
        } else {
            seen = share_seen(k, p + off_soft * (n + l));
            thick = nearest - near;
        }
        float limit = k >= 3 ? DOME_REACH : -scatter * wrap.r - SLACK;
        if (facing <= limit) seen = 0.0;
        else if (k >= 3) {
            float plain = max(facing + 0.3, 0.0);
            dome += plain;
            dome_seen += plain * seen;
        }
        if (k == 0) key = seen;
        light += seen * colours[k] * max(facing + scatter * wrap, 0.0) / (1.0 + scatter * wrap);
        if (k == 0 || k == 2) {
            float behind = clamp(THROUGH_RISE * (THROUGH - facing), 0.0, 1.0);
            vec3 x = max(thick + lift, LEAST_THICK_MM) * deep;
            light += thin * colours[k] * behind / (1.0 + x * (1.0 + x * (0.5 + x / 6.0)));
        }
    }
    float closed = 1.0 - dome_seen / dome, left = 1.0 - cavity * closed;
    dome_share[v] = shaded * (1.0 - closed);
    lit[v] = vec4(left * (INNER + (1.0 - INNER) * shaded) * light + closed * bounce, shaded * left * key);
}
"""
)

_SPREAD = (
    "#version 430\n"
    + _BUFFERS
    + """
void main() {
    int v = int(gl_GlobalInvocationID.x);
    if (v >= dome_share.length()) return;
    int w = int(about[2 * v + 1].z);
    vec3 light = from[v].rgb, share = vec3(1.0);
    for (int e = start[w]; e < start[w + 1]; e++) {
        light += neighbour[e].rgb * from[int(neighbour[e].w)].rgb;
        share += neighbour[e].rgb;
    }
    lit[v] = vec4(light / share, from[v].w);
}
"""
)


class LightOnCard:
    """What lighting keeps on the card; made and used in the card's thread.

    Attributes
    ----------
    vertices, normals : moderngl.Buffer
        Three numbers a vertex, of the last pose that was lit.
    lit : moderngl.Buffer
        Four numbers a vertex: the light that a white matt surface would send back, and the key light's share.
    dome : moderngl.Buffer
        The share of the dome that is seen, one number a vertex.
    """

    def __init__(self, context: Any, renderer: Renderer) -> None:
        import moderngl

        self._gl, self._context = moderngl, context
        scene, lights = renderer.scene, renderer.lighting
        self._axes, self._cells, count = light_axes(lights.directions), renderer.key_cells, len(scene.uv)
        names = {
            "LIGHTS": len(self._axes), "KEY": self._cells, "SOFT": light.SOFT_CELLS, "ACROSS": _ACROSS, "FAR": _FAR,
            "TOGETHER": _TOGETHER, "KEY_EDGE_MM": light.KEY_EDGE_MM, "DOME_REACH": light.DOME_REACH,
            "SLACK": light.SLACK, "THROUGH": light.THROUGH, "THROUGH_RISE": light.THROUGH_RISE,
            "LEAST_THICK_MM": light.LEAST_THICK_MM, "LIT_THROUGH": light.LIT_THROUGH, "INNER": light.INNER,
            "SOFT_CELLS_OFF": light.SOFT_CELLS_OFF,
        }  # fmt: skip
        head = "#version 430\n" + "".join(f"#define {name} {value}\n" for name, value in names.items())

        def whole(source: str) -> str:
            return source.replace("#version 430\n", head)

        self.vertices, self.normals = (context.buffer(reserve=12 * count, dynamic=True) for _ in range(2))
        self.lit, self._from = (context.buffer(reserve=16 * count) for _ in range(2))
        self.dome = context.buffer(reserve=4 * count)
        about = np.stack(
            [
                scene.scatter, scene.thin, scene.lift, scene.cavity, scene.spacing, scene.lit_side, scene.welded,
                np.zeros(count),
            ], axis=1,
        )  # fmt: skip
        around = np.concatenate([scene.neighbour_weight, scene.neighbour[:, None]], axis=1)
        self._about, self._around = (context.buffer(_floats(each) or bytes(16)) for each in (about, around))
        self._starts = context.buffer(scene.neighbour_start.tobytes())
        self._cast = context.program(vertex_shader=whole(_CAST), fragment_shader=_DARK)
        self._gather, self._spread = (context.compute_shader(whole(source)) for source in (_GATHERED, _SPREAD))
        self._groups = -(-count // _TOGETHER)
        rows = -(-(len(self._axes) - 1) // _ACROSS)
        self._maps = [
            context.depth_texture(size)
            for size in ((self._cells, self._cells), (_ACROSS * light.SOFT_CELLS, rows * light.SOFT_CELLS))
        ]
        self._drawn = [context.framebuffer(depth_attachment=each) for each in self._maps]
        for each in self._maps:
            each.compare_func = ""
        self._casters = [
            context.vertex_array(
                self._cast, [(self.vertices, "3f", "in_vertex")], index_buffer=context.buffer(_corners(*casters))
            )
            for casters in (renderer.key_casters, (scene.coarse_casters, scene.coarse_vertices))
        ]
        self._cast["centre"].write(_floats(scene.head_centre))
        self._cast["radius"].write(_floats(scene.head_radius))
        uniforms = {
            "axes": self._axes, "colours": lights.colours, "place": renderer.camera.place(),
            "centre": scene.head_centre, "radius": scene.head_radius, "wrap": lights.wrap, "bounce": lights.bounce,
            "deep": 1 / (lights.reach_mm * light.THROUGH_MM),
        }  # fmt: skip
        for name, value in uniforms.items():
            self._gather[name].write(_floats(value))
        self._gather["key_map"].value, self._gather["soft_maps"].value = 0, 1

    def light(self, vertices: NDArray[np.float32], normals: NDArray[np.float32]) -> None:
        """Fill `vertices`, `normals`, `lit` and `dome`."""
        context, gl = self._context, self._gl
        self.vertices.write(vertices)
        self.normals.write(normals)
        context.enable_only(gl.DEPTH_TEST | gl.CULL_FACE)
        context.depth_func = ">"
        for number, axes in enumerate(self._axes):
            soft, place = min(number, 1), number - 1
            if number < 2:
                self._drawn[soft].use()
                self._drawn[soft].clear(depth=0.0)
            side = light.SOFT_CELLS if soft else self._cells
            self._drawn[soft].viewport = (
                (place % _ACROSS * side, place // _ACROSS * side, side, side) if soft else (0, 0, side, side)
            )
            self._cast["axes"].write(axes.tobytes())
            self._casters[soft].render(gl.TRIANGLES)
        for number, each in enumerate(self._maps):
            each.use(number)
        given = {0: self.vertices, 1: self.normals, 2: self._about, 4: self.dome, 6: self._starts, 7: self._around}
        for number, buffer in given.items():
            buffer.bind_to_storage_buffer(number)
        for left in range(SPREAD_STEPS, -1, -1):  # to and fro, so that the last step ends in `lit`
            (self.lit, self._from)[left % 2].bind_to_storage_buffer(3)
            (self._from, self.lit)[left % 2].bind_to_storage_buffer(5)
            (self._gather if left == SPREAD_STEPS else self._spread).run(self._groups)
            context.memory_barrier()


def _floats(numbers: Any) -> bytes:
    return np.ascontiguousarray(numbers, np.float32).tobytes()


def _corners(triangles: NDArray[np.int32], listed: NDArray[np.int32]) -> bytes:
    """Of triangles between listed vertices, the vertices themselves; one of no size where there is none."""
    return np.ascontiguousarray(listed[triangles] if len(triangles) else np.zeros((1, 3)), np.int32).tobytes()
