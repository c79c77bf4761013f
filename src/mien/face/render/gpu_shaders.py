"""The programs that run on a graphics card: `mien.face.render.shading`, `relief` and `colour` again, in GLSL.

Each surface that a pixel shows is shaded once (multi-sampling), bent by the tone curve, and then averaged, as on the
processor. Terms and names are those of the compiled kernels, which say where they come from.
"""

from __future__ import annotations

from mien.face.render.colour import KNEE, SRGB_STEPS
from mien.face.render.relief import PIT_SHADE, SLOPE_SHADE
from mien.face.render.shading import MOST_SHINE

__all__ = ["BUFFERS", "ENCODED", "FOLDED", "PLACED", "SHADED", "WHOLE_PICTURE"]

BUFFERS = {"triangles": 0, "parts": 1, "levels": 2, "texels": 3, "tables": 4}
"""Storage buffers of `SHADED` and where they are bound."""

_TABLES = f"""
layout(std430, binding = {BUFFERS["tables"]}) readonly buffer Tables {{
    float light_of_byte[256];
    float srgb[{SRGB_STEPS}];
    float noise[64];
}};
"""

PLACED = """
#version 430
uniform vec2 size;
uniform float focal;
uniform float nearest;
uniform vec3 place;
uniform mat3 view;  // columns across, up, back
in vec3 in_vertex;
in vec3 in_normal;
in vec4 in_lit;
in float in_dome;
in vec3 in_albedo;
in vec2 in_gloss;
in vec2 in_uv;
in float in_solid;
centroid out vec3 normal;
centroid out vec3 diffuse;
centroid out vec4 gloss_open;
centroid out vec3 uv_solid;
void main() {
    vec3 seen = (in_vertex - place) * view;
    // The picture's first row is the lowest of OpenGL, which is the first that is read back. Near is 1, far away 0.
    gl_Position = vec4(2.0 * focal * vec2(seen.x, -seen.y) / size, 2.0 * nearest + seen.z, -seen.z);
    normal = in_normal;
    diffuse = in_albedo * in_lit.rgb;
    gloss_open = vec4(in_gloss, in_lit.a, in_dome);
    uv_solid = vec3(in_uv, in_solid);
}
"""

SHADED = f"""
#version 430
#define CLEAR 0
{_TABLES}
layout(std430, binding = {BUFFERS["triangles"]}) readonly buffer Triangles {{ int triangles[]; }};
layout(std430, binding = {BUFFERS["parts"]}) readonly buffer Parts {{ vec2 parts[]; }};
layout(std430, binding = {BUFFERS["levels"]}) readonly buffer Levels {{ ivec4 levels[]; }};
layout(std430, binding = {BUFFERS["texels"]}) readonly buffer Texels {{ uint texels[]; }};
uniform int first_triangle;
uniform vec2 size;
uniform float focal;
uniform mat3 view;  // columns across, up, back
uniform vec3 directions[3];
uniform vec3 colours[3];
uniform vec3 sky[3];
uniform float exposure;
uniform float relief_share;
uniform sampler2D relief;
centroid in vec3 normal;
centroid in vec3 diffuse;
centroid in vec4 gloss_open;
centroid in vec3 uv_solid;
out vec4 colour;

vec3 texel(int number) {{
    uint word = texels[number];
    return vec3(light_of_byte[word & 255u], light_of_byte[(word >> 8) & 255u], light_of_byte[(word >> 16) & 255u]);
}}

vec3 texture_colour(ivec4 found) {{  // bilinear
    vec2 at = uv_solid.xy * vec2(found.yz) - 0.5;
    ivec2 most = found.yz - 1, low = ivec2(floor(at));
    vec2 share = at - vec2(low);
    ivec2 high = clamp(low + 1, ivec2(0), most);
    low = clamp(low, ivec2(0), most);
    int below = found.x + low.y * found.y, above = found.x + high.y * found.y;
    return mix(mix(texel(below + low.x), texel(below + high.x), share.x),
               mix(texel(above + low.x), texel(above + high.x), share.x), share.y);
}}

int kept_samples(ivec4 found) {{  // of what is seen through: as many as its opacity says
    float kept = parts[found.w].y;
    if (found.y > 0) {{
        ivec2 at = clamp(ivec2(uv_solid.xy * vec2(found.yz)), ivec2(0), found.yz - 1);
        kept *= float(texels[found.x + at.y * found.y + at.x] >> 24) / 255.0;
    }}
    ivec2 pixel = ivec2(gl_FragCoord.xy) & 7;
    int mask = 0;
    for (int s = 0; s < 4; s++)
        if (4.0 * kept > float((s + found.w) & 3) + noise[8 * pixel.y + pixel.x]) mask |= 1 << s;
    return mask;
}}

vec3 highlight(vec3 n, vec3 v, vec3 l, float alpha, float head_on) {{
    float facing = max(dot(n, v), 0.05), lit = max(dot(n, l), 0.0);
    float half_length = sqrt(max(2.0 + 2.0 * dot(v, l), 0.0)) + 1e-9;
    float nh = max(0.0, dot(n, v + l) / half_length);
    float squared = alpha * alpha, away = 1.0 - 0.5 * half_length;
    float spread = nh * nh * (squared - 1.0) + 1.0;
    float fresnel = head_on + (1.0 - head_on) * pow(max(away, 0.0), 5.0) * min(1.0, 12.5 * head_on);
    float masked = 2.0 * lit * facing * (1.0 - alpha) + (lit + facing) * alpha;
    return vec3(min(0.5 * squared * fresnel * lit / (spread * spread * masked), {MOST_SHINE} / alpha));
}}

void main() {{
    ivec4 found = levels[triangles[first_triangle + gl_PrimitiveID]];
#if CLEAR
    int mask = kept_samples(found);
    if (mask == 0) discard;
    gl_SampleMask[0] = mask;
#endif
    float alpha = gloss_open.x, head_on = gloss_open.y, key = gloss_open.z, dome = gloss_open.w;
    vec3 light = diffuse, n = gl_FrontFacing ? -normal : normal;
    if (found.y > 0) light *= texture_colour(found);
    float tiles = parts[found.w].x;
    if (relief_share > 0.0 && tiles > 0.0) {{
        vec3 bump = textureLod(relief, uv_solid.xy * tiles, 0.0).xyz;
        float level = inversesqrt(n.x * n.x + n.z * n.z + 1e-6);
        vec3 t = vec3(n.z * level, 0.0, -n.x * level);
        vec3 moved = relief_share * (bump.x * t + bump.y * cross(n, t));
        n -= moved;
        light *= 1.0 - {SLOPE_SHADE} * key * dot(moved, directions[0]) - relief_share * {PIT_SHADE} * bump.z;
    }}
    vec2 from_middle = (0.5 * size - gl_FragCoord.xy) * vec2(1.0, -1.0) / focal;
    vec3 v = normalize(view * vec3(from_middle, 1.0));
    n /= length(n) + 1e-9;
    float open = dome * dome;
    light += key * colours[0] * highlight(n, v, directions[0], alpha, head_on);
    light += open * open * colours[1] * highlight(n, v, directions[1], alpha, head_on);
    light += open * open * colours[2] * highlight(n, v, directions[2], alpha, head_on);
    float straight = dot(n, v), away = 1.0 - max(straight, 0.05);
    float rise = max(1.0 - alpha, head_on) - head_on;
    float mirrored = (head_on + rise * pow(away, 5.0) * min(1.0, 12.5 * head_on)) * open;
    float up = 2.0 * straight * n.y - v.y;
    light += mirrored * (sky[1] + max(up, 0.0) * (sky[0] - sky[1]) + max(-up, 0.0) * (sky[2] - sky[1]));
    light *= exposure;
    vec3 over = max(light - {KNEE}, 0.0) / (1.0 - {KNEE});
    colour = vec4(min(light, {KNEE}) + (1.0 - {KNEE}) * over / (1.0 + over), 1.0) * uv_solid.z;
}}
"""

FOLDED = """
#version 430
layout(local_size_x = 256) in;
layout(std430, binding = 0) readonly buffer Places { int places[]; };
layout(std430, binding = 1) readonly buffer Smooth { uint smooth_texels[]; };
layout(std430, binding = 2) readonly buffer Starts { int starts[]; };
layout(std430, binding = 3) buffer Texels { uint texels[]; };
layout(std430, binding = 4) readonly buffer Entries { vec2 entries[]; };  // fold, shade
layout(std430, binding = 5) readonly buffer Weights { float weights[]; };
uniform int begin;
uniform vec3 tint;
void main() {
    int number = begin + int(gl_GlobalInvocationID.x);
    if (number >= places.length()) return;
    float dark = 0.0;
    for (int e = starts[number]; e < starts[number + 1]; e++) dark += weights[int(entries[e].x)] * entries[e].y;
    uint word = smooth_texels[number];
    vec3 colour = vec3(word & 255u, (word >> 8) & 255u, (word >> 16) & 255u);
    uvec3 folded = uvec3(clamp(colour * (1.0 - clamp(dark, -1.0, 1.0) * tint), 0.0, 255.0));
    texels[places[number]] = folded.r | folded.g << 8 | folded.b << 16 | (word & 0xff000000u);
}
"""
"""`mien.face.folds.Folds.lay`."""

WHOLE_PICTURE = """
#version 430
void main() {
    gl_Position = vec4(4.0 * float(gl_VertexID & 1) - 1.0, 2.0 * float(gl_VertexID & 2) - 1.0, 0.0, 1.0);
}
"""

ENCODED = f"""
#version 430
{_TABLES}
uniform sampler2D total;
uniform sampler2D behind;
uniform sampler2D backdrop;
uniform bool transparent;
out vec4 pixel;

float encoded(float value, float dither) {{
    int number = int(sqrt(clamp(value, 0.0, 1.0)) * {SRGB_STEPS - 1}.0 + 0.5);
    return floor(min(255.0, srgb[number] + dither)) / 255.0;
}}

void main() {{
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec4 drawn = texelFetch(total, at, 0);
    float dither = noise[8 * (at.y & 7) + (at.x & 7)];
    if (drawn.a == 0.0) {{
        pixel = transparent ? vec4(0.0) : texelFetch(backdrop, at, 0);
        return;
    }}
    vec3 light = transparent ? drawn.rgb / drawn.a : drawn.rgb + (1.0 - drawn.a) * texelFetch(behind, at, 0).rgb;
    pixel = vec4(encoded(light.r, dither), encoded(light.g, dither), encoded(light.b, dither), min(drawn.a, 1.0));
}}
"""
