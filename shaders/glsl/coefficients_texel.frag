#version 450 core
// Generated from wgsl/coefficients.wgsl, which has the comments. Do not edit: `UPDATE_SHADERS=1 cargo test --test shading generated` writes it.
struct Camera {
    mat4x4 model_view;
    mat4x4 projection;
    vec2 size;
    uint points;
    uint triangles;
    uint width;
};
layout(std140, binding = 0) uniform Camera_block { Camera camera; };

layout(binding = 1) uniform sampler2D points;

layout(binding = 3) uniform usampler2D corners;

layout(binding = 4) uniform sampler2D gradients;

layout(location = 0) out vec4 _fs2p_location0;

uvec2 texel(uint at, uint width) {
    return uvec2((at % width), (at / width));
}

vec4 point(uint v, uint which) {
    uvec2 _e9 = texel(((5u * v) + which), uvec2(textureSize(points, 0).xy).x);
    vec4 _e11 = texelFetch(points, ivec2(_e9), 0);
    return _e11;
}

vec3 eye_of(uint v_1) {
    mat4x4 _e3 = camera.model_view;
    vec4 _e5 = point(v_1, 0u);
    return (_e3 * vec4(_e5.xyz, 1.0)).xyz;
}

vec3 normal_of(uint v_2) {
    mat4x4 _e3 = camera.model_view;
    vec4 _e5 = point(v_2, 1u);
    return normalize((_e3 * vec4(_e5.xyz, 0.0)).xyz);
}

vec3 screen_of(uint v_3) {
    mat4x4 _e3 = camera.projection;
    vec3 _e4 = eye_of(v_3);
    vec4 place_2 = (_e3 * vec4(_e4, 1.0));
    vec2 _e14 = camera.size;
    return vec3((((place_2.xy / vec2(place_2.w)) * _e14) / vec2(2.0)), place_2.w);
}

vec2 moved(vec3 eye, vec3 step_) {
    mat4x4 _e4 = camera.projection;
    vec4 place_3 = (_e4 * vec4(eye, 1.0));
    mat4x4 _e10 = camera.projection;
    vec4 change = (_e10 * vec4(step_, 0.0));
    vec2 _e28 = camera.size;
    return (((((change.xy * place_3.w) - (place_3.xy * change.w)) / vec2((place_3.w * place_3.w))) * _e28) / vec2(2.0));
}

float turn(vec2 a, vec2 b) {
    return ((a.x * b.y) - (a.y * b.x));
}

bool is_drawn(vec3 a_1, vec3 b_1, vec3 c) {
    bool local = false;
    if ((min(a_1.z, min(b_1.z, c.z)) > 0.0)) {
        float _e18 = turn((b_1.xy - a_1.xy), (c.xy - a_1.xy));
        local = (_e18 > 0.0);
    } else {
        local = false;
    }
    bool _e22 = local;
    return _e22;
}

vec3 along(uint v_4, vec2 step_1) {
    uint width_1 = uvec2(textureSize(gradients, 0).xy).x;
    uvec2 _e8 = texel((2u * v_4), width_1);
    vec4 _e10 = texelFetch(gradients, ivec2(_e8), 0);
    vec3 right = _e10.xyz;
    uvec2 _e17 = texel(((2u * v_4) + 1u), width_1);
    vec4 _e19 = texelFetch(gradients, ivec2(_e17), 0);
    vec3 up = _e19.xyz;
    return ((right * step_1.x) + (up * step_1.y));
}

float crossing(vec2 i, vec2 j, vec2 centroid_, mat2x3 eyes, vec3 normals) {
    vec2 across = vec2(0.0);
    vec2 edge = (j - i);
    vec2 _e16 = moved(((eyes[0] + eyes[1]) / vec3(2.0)), cross(normals, (eyes[1] - eyes[0])));
    across = _e16;
    vec2 _e18 = across;
    float _e19 = turn(_e18, edge);
    vec2 _e21 = across;
    if ((abs(_e19) <= ((0.1 * length(_e21)) * length(edge)))) {
        across = vec2(-(edge.y), edge.x);
    }
    vec2 _e33 = across;
    float _e34 = turn((centroid_ - i), _e33);
    vec2 _e35 = across;
    float _e36 = turn(edge, _e35);
    return (_e34 / _e36);
}

vec3 middle(float x, vec3 i_1, vec3 ij, vec3 ji, vec3 j_1, vec3 near_i, vec3 near_j) {
    return ((((near_i + near_j) / vec3(2.0)) + ((1.0 - x) * (ij - ((i_1 + ji) / vec3(2.0))))) + (x * (ji - ((ij + j_1) / vec3(2.0)))));
}

vec4[9] cubic_of(uint t) {
    uint width_2 = uvec2(textureSize(corners, 0).xy).x;
    uvec2 _e7 = texel((3u * t), width_2);
    uvec4 _e9 = texelFetch(corners, ivec2(_e7), 0);
    uvec3 ia = _e9.xyz;
    uvec2 _e16 = texel(((3u * t) + 1u), width_2);
    uvec4 _e18 = texelFetch(corners, ivec2(_e16), 0);
    uvec3 ib = _e18.xyz;
    uvec2 _e25 = texel(((3u * t) + 2u), width_2);
    uvec4 _e27 = texelFetch(corners, ivec2(_e25), 0);
    uvec3 ic = _e27.xyz;
    vec3 _e30 = screen_of(ia.x);
    vec3 _e32 = screen_of(ib.x);
    vec3 _e34 = screen_of(ic.x);
    bool _e35 = is_drawn(_e30, _e32, _e34);
    if (!(_e35)) {
        vec4 zero = vec4(0.0);
        return vec4[9](zero, zero, zero, zero, zero, zero, zero, zero, zero);
    }
    vec3 _e41 = eye_of(ia.x);
    vec3 _e43 = eye_of(ib.x);
    vec3 _e45 = eye_of(ic.x);
    vec3 _e47 = normal_of(ia.x);
    vec3 _e49 = normal_of(ib.x);
    vec3 _e51 = normal_of(ic.x);
    vec2 centroid_1 = (((_e30.xy + _e32.xy) + _e34.xy) / vec2(3.0));
    vec3 _e64 = along(ia.y, (_e32.xy - _e30.xy));
    vec3 ab = (_e47 + (_e64 / vec3(3.0)));
    vec3 _e73 = along(ia.z, (_e34.xy - _e30.xy));
    vec3 ac = (_e47 + (_e73 / vec3(3.0)));
    vec3 _e82 = along(ib.y, (_e34.xy - _e32.xy));
    vec3 bc = (_e49 + (_e82 / vec3(3.0)));
    vec3 _e91 = along(ib.z, (_e30.xy - _e32.xy));
    vec3 ba = (_e49 + (_e91 / vec3(3.0)));
    vec3 _e100 = along(ic.y, (_e30.xy - _e34.xy));
    vec3 ca = (_e51 + (_e100 / vec3(3.0)));
    vec3 _e109 = along(ic.z, (_e32.xy - _e34.xy));
    vec3 cb = (_e51 + (_e109 / vec3(3.0)));
    vec3 na = (((_e47 + ab) + ac) / vec3(3.0));
    vec3 nb = (((_e49 + bc) + ba) / vec3(3.0));
    vec3 nc = (((_e51 + ca) + cb) / vec3(3.0));
    float _e133 = crossing(_e32.xy, _e34.xy, centroid_1, mat2x3(_e43, _e45), (_e49 + _e51));
    vec3 _e134 = middle(_e133, _e49, bc, cb, _e51, nb, nc);
    float _e139 = crossing(_e34.xy, _e30.xy, centroid_1, mat2x3(_e45, _e41), (_e51 + _e47));
    vec3 _e140 = middle(_e139, _e51, ca, ac, _e47, nc, na);
    float _e145 = crossing(_e30.xy, _e32.xy, centroid_1, mat2x3(_e41, _e43), (_e47 + _e49));
    vec3 _e146 = middle(_e145, _e47, ab, ba, _e49, na, nb);
    vec3 fa = (((na + _e140) + _e146) / vec3(3.0));
    vec3 fb = (((nb + _e146) + _e134) / vec3(3.0));
    vec3 fc = (((nc + _e134) + _e140) / vec3(3.0));
    vec3 n = (((fa + fb) + fc) / vec3(3.0));
    vec3 cube_a = (((_e47 - (3.0 * na)) + (3.0 * fa)) - n);
    vec3 cube_b = (((_e49 - (3.0 * nb)) + (3.0 * fb)) - n);
    vec3 cube_c = (((_e51 - (3.0 * nc)) + (3.0 * fc)) - n);
    vec3 dab = (3.0 * (((((ab - na) - (2.0 * _e146)) + (2.0 * fa)) + fb) - n));
    vec3 dba = (3.0 * (((((ba - nb) - (2.0 * _e146)) + (2.0 * fb)) + fa) - n));
    vec3 dac = (3.0 * (((((ac - na) - (2.0 * _e140)) + (2.0 * fa)) + fc) - n));
    vec3 dca = (3.0 * (((((ca - nc) - (2.0 * _e140)) + (2.0 * fc)) + fa) - n));
    vec3 dbc = (3.0 * (((((bc - nb) - (2.0 * _e134)) + (2.0 * fb)) + fc) - n));
    vec3 dcb = (3.0 * (((((cb - nc) - (2.0 * _e134)) + (2.0 * fc)) + fb) - n));
    vec3 k1_ = (3.0 * (fa - n));
    vec3 k2_ = (3.0 * (fb - n));
    vec3 k3_ = (3.0 * ((na - (2.0 * fa)) + n));
    vec3 k4_ = (6.0 * (((_e146 - fa) - fb) + n));
    vec3 k5_ = (3.0 * ((nb - (2.0 * fb)) + n));
    vec3 k10_ = (-((((cube_c + dca) + dac) + cube_a)) - cube_b);
    vec3 k11_ = (-((((cube_b + dbc) + dcb) + cube_c)) - cube_a);
    return vec4[9](vec4(n, k1_.x), vec4(k1_.yz, k2_.xy), vec4(k2_.z, k3_), vec4(k4_, k5_.x), vec4(k5_.yz, cube_a.xy), vec4(cube_a.z, dab), vec4(dba, cube_b.x), vec4(cube_b.yz, k10_.xy), vec4(k10_.z, k11_));
}

uint index_of(vec4 place_1) {
    uint _e5 = camera.width;
    return ((uint(place_1.y) * _e5) + uint(place_1.x));
}

void main() {
    vec4 place = gl_FragCoord;
    uint _e1 = index_of(place);
    vec4 _e4[9] = cubic_of((_e1 / 9u));
    _fs2p_location0 = _e4[(_e1 % 9u)];
    return;
}

