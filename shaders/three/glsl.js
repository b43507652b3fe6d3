// Generated from ../glsl_es, which is generated from ../wgsl. Do not edit: `node make_glsl.mjs` writes it.

export const slopes = `
precision highp float;
precision highp int;

struct Camera {
    mat4x4 model_view;
    mat4x4 projection;
    vec2 size;
    uint points;
    uint triangles;
    uint width;
};
struct Equations {
    vec3 matrix;
    vec3 right;
    vec3 up;
};
struct Slope {
    vec3 right;
    vec3 up;
};
uniform Camera camera;

uniform highp sampler2D points;

uniform highp usampler2D ring;

layout(location = 0) out vec4 _fs2p_location0;

uvec2 texel(uint at, uint width) {
    return uvec2((at % width), (at / width));
}

vec4 point(uint v, uint which) {
    uvec2 _e9 = texel(((5u * v) + which), uvec2(textureSize(points, 0).xy).x);
    vec4 _e11 = texelFetch(points, ivec2(_e9), 0);
    return _e11;
}

uvec2 pair_of(uint at_1) {
    uvec2 _e5 = texel(at_1, uvec2(textureSize(ring, 0).xy).x);
    uvec4 _e7 = texelFetch(ring, ivec2(_e5), 0);
    return _e7.xy;
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
    vec4 change_1 = (_e10 * vec4(step_, 0.0));
    vec2 _e28 = camera.size;
    return (((((change_1.xy * place_3.w) - (place_3.xy * change_1.w)) / vec2((place_3.w * place_3.w))) * _e28) / vec2(2.0));
}

vec3 toward_eye(vec3 eye_1) {
    float _e5 = camera.projection[3][3];
    if ((_e5 == 1.0)) {
        return vec3(0.0, 0.0, 1.0);
    }
    return normalize(-(eye_1));
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

vec3 across_both(vec3 normal, vec3 other) {
    vec3 across = cross(normal, other);
    if ((dot(across, across) >= 1e-9)) {
        return normalize(across);
    }
    return normalize(cross(normal, ((abs(normal.x) < 0.6) ? vec3(1.0, 0.0, 0.0) : vec3(0.0, 1.0, 0.0))));
}

vec3 bent(uint v_4, vec3 step_1) {
    vec4 _e5 = camera.model_view[0];
    vec4 _e10 = camera.model_view[1];
    vec4 _e15 = camera.model_view[2];
    mat3x3 turn_1 = mat3x3(_e5.xyz, _e10.xyz, _e15.xyz);
    vec4 _e19 = point(v_4, 2u);
    vec4 _e22 = point(v_4, 3u);
    vec4 _e25 = point(v_4, 4u);
    mat3x3 curvature = mat3x3(_e19.xyz, _e22.xyz, _e25.xyz);
    float squared = dot(turn_1[0], turn_1[0]);
    return ((turn_1 * (curvature * (step_1 * turn_1))) / vec3((squared * sqrt(squared))));
}

Equations observed(Equations sum, vec2 offset, vec3 change, float weight) {
    vec3 squares = vec3((offset.x * offset.x), (offset.x * offset.y), (offset.y * offset.y));
    return Equations((sum.matrix + (weight * squares)), (sum.right + ((weight * offset.x) * change)), (sum.up + ((weight * offset.y) * change)));
}

Equations neighbor(Equations sum_1, uint other_1, vec2 offset_1, vec3 normal_1) {
    float squared_1 = dot(offset_1, offset_1);
    if ((squared_1 > 0.0)) {
        vec3 _e7 = normal_of(other_1);
        Equations _e11 = observed(sum_1, offset_1, (_e7 - normal_1), (1.0 / squared_1));
        return _e11;
    }
    return sum_1;
}

Slope solved(Equations sum_2) {
    vec3 m = sum_2.matrix;
    float determinant_ = ((m.x * m.z) - (m.y * m.y));
    float trace = (m.x + m.z);
    if ((determinant_ > ((1e-6 * trace) * trace))) {
        return Slope((((m.z * sum_2.right) - (m.y * sum_2.up)) / vec3(determinant_)), (((m.x * sum_2.up) - (m.y * sum_2.right)) / vec3(determinant_)));
    }
    float scale = ((trace > 0.0) ? (1.0 / trace) : 0.0);
    return Slope((sum_2.right * scale), (sum_2.up * scale));
}

Slope slope_of(uint v_5) {
    Equations sum_3 = Equations(vec3(0.0), vec3(0.0), vec3(0.0));
    uint i = 0u;
    bool local_1 = false;
    vec3 _e1 = eye_of(v_5);
    vec3 _e2 = normal_of(v_5);
    vec3 _e3 = screen_of(v_5);
    vec4 _e5 = point(v_5, 0u);
    uint start = uint(_e5.w);
    vec4 _e9 = point(v_5, 1u);
    uint end = uint(_e9.w);
    i = start;
    bool loop_init = true;
    while(true) {
        if (!loop_init) {
            uint _e65 = i;
            i = (_e65 + 1u);
        }
        loop_init = false;
        uint _e21 = i;
        if ((_e21 < end)) {
        } else {
            break;
        }
        {
            uint _e23 = i;
            uvec2 _e24 = pair_of(_e23);
            vec3 _e26 = screen_of(_e24.x);
            vec3 _e28 = screen_of(_e24.y);
            bool _e29 = is_drawn(_e3, _e26, _e28);
            if (!(_e29)) {
                continue;
            }
            Equations _e31 = sum_3;
            Equations _e36 = neighbor(_e31, _e24.x, (_e26.xy - _e3.xy), _e2);
            sum_3 = _e36;
            uint _e37 = i;
            uint _e40 = i;
            uvec2 _e45 = pair_of((((_e40 + 1u) == end) ? start : (_e37 + 1u)));
            if (!((_e45.x != _e24.y))) {
                vec3 _e53 = screen_of(_e45.y);
                bool _e54 = is_drawn(_e3, _e28, _e53);
                local_1 = !(_e54);
            } else {
                local_1 = true;
            }
            bool _e57 = local_1;
            if (_e57) {
                Equations _e58 = sum_3;
                Equations _e63 = neighbor(_e58, _e24.y, (_e28.xy - _e3.xy), _e2);
                sum_3 = _e63;
            }
        }
    }
    float _e69 = sum_3.matrix.x;
    float _e72 = sum_3.matrix.z;
    float trace_1 = (_e69 + _e72);
    float weight_1 = ((trace_1 > 0.0) ? (0.07 / trace_1) : 0.0);
    vec3 _e81 = sum_3.matrix;
    vec3 _e84 = sum_3.right;
    vec3 _e87 = sum_3.up;
    sum_3 = Equations((_e81 * weight_1), (_e84 * weight_1), (_e87 * weight_1));
    vec3 _e90 = toward_eye(_e1);
    vec3 _e91 = across_both(_e2, _e90);
    vec3 away = cross(_e2, _e91);
    vec3 _e93 = across_both(_e90, _e2);
    vec2 _e94 = moved(_e1, _e93);
    float pixels = length(_e94);
    Equations _e96 = sum_3;
    vec2 _e97 = moved(_e1, _e91);
    vec3 _e100 = bent(v_5, _e91);
    Equations _e104 = observed(_e96, (_e97 / vec2(pixels)), (_e100 / vec3(pixels)), 1.0);
    sum_3 = _e104;
    if ((dot(_e2, _e90) > 0.0)) {
        Equations _e108 = sum_3;
        vec2 _e109 = moved(_e1, away);
        vec3 _e112 = bent(v_5, away);
        Equations _e116 = observed(_e108, (_e109 / vec2(pixels)), (_e112 / vec3(pixels)), 1.0);
        sum_3 = _e116;
    }
    Equations _e117 = sum_3;
    Slope _e118 = solved(_e117);
    return _e118;
}

uint index_of(vec4 place_1) {
    uint _e5 = camera.width;
    return ((uint(place_1.y) * _e5) + uint(place_1.x));
}

void main() {
    vec4 place = gl_FragCoord;
    uint _e1 = index_of(place);
    Slope _e4 = slope_of((_e1 / 2u));
    _fs2p_location0 = vec4((((_e1 % 2u) == 1u) ? _e4.up : _e4.right), 0.0);
    return;
}
`;

export const coefficients = `
precision highp float;
precision highp int;

struct Camera {
    mat4x4 model_view;
    mat4x4 projection;
    vec2 size;
    uint points;
    uint triangles;
    uint width;
};
uniform Camera camera;

uniform highp sampler2D points;

uniform highp usampler2D corners;

uniform highp sampler2D gradients;

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
`;

export const cubic = `
vec4 terms_of(vec3 weights) {
    vec3 w = (weights / vec3(((weights.x + weights.y) + weights.z)));
    float x = (w.x - w.z);
    float y = (w.y - w.z);
    float xx = (((x < 0.0) && (x <= y)) ? (x * x) : 0.0);
    float yy = (((y < 0.0) && (y < x)) ? (y * y) : 0.0);
    return vec4(x, y, ((yy * (y - (2.0 * x))) - (xx * y)), ((xx * (x - (2.0 * y))) - (yy * x)));
}

vec3 cubic_value(vec4 a, vec4 b, vec4 c, vec4 d, vec4 e, vec4 f, vec4 g, vec4 h, vec4 i, vec4 t) {
    vec3 along = (a.xyz + (t.x * (vec3(a.w, b.xy) + (t.x * (c.yzw + (t.x * vec3(e.zw, f.x)))))));
    vec3 mixed = ((vec3(b.zw, c.x) + (t.x * (d.xyz + (t.x * f.yzw)))) + (t.y * ((vec3(d.w, e.xy) + (t.x * g.xyz)) + (t.y * vec3(g.w, h.xy)))));
    return (((along + (t.y * mixed)) + (t.z * vec3(h.zw, i.x))) + (t.w * i.yzw));
}
`;
