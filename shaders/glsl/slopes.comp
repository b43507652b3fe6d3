#version 450 core
// Generated from wgsl/coefficients.wgsl, which has the comments. Do not edit: `UPDATE_SHADERS=1 cargo test --test shading generated` writes it.
#extension GL_ARB_compute_shader : require
layout(local_size_x = 64, local_size_y = 1, local_size_z = 1) in;

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
layout(std140, binding = 0) uniform Camera_block { Camera camera; };

layout(binding = 1) uniform sampler2D points;

layout(binding = 2) uniform usampler2D ring;

layout(binding = 5,rgba32f) writeonly uniform image2D slopes_out;


uvec2 texel(uint at, uint width) {
    return uvec2((at % width), (at / width));
}

vec4 point(uint v, uint which) {
    uvec2 _e9 = texel(((5u * v) + which), uvec2(textureSize(points, 0).xy).x);
    vec4 _e11 = texelFetch(points, ivec2(_e9), 0);
    return _e11;
}

uvec3 around(uint at_1) {
    uvec2 _e5 = texel(at_1, uvec2(textureSize(ring, 0).xy).x);
    uvec4 _e7 = texelFetch(ring, ivec2(_e5), 0);
    return _e7.xyz;
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
    vec4 place = (_e3 * vec4(_e4, 1.0));
    vec2 _e14 = camera.size;
    return vec3((((place.xy / vec2(place.w)) * _e14) / vec2(2.0)), place.w);
}

vec2 moved(vec3 eye, vec3 step_) {
    mat4x4 _e4 = camera.projection;
    vec4 place_1 = (_e4 * vec4(eye, 1.0));
    mat4x4 _e10 = camera.projection;
    vec4 change_1 = (_e10 * vec4(step_, 0.0));
    vec2 _e28 = camera.size;
    return (((((change_1.xy * place_1.w) - (place_1.xy * change_1.w)) / vec2((place_1.w * place_1.w))) * _e28) / vec2(2.0));
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
            uint _e47 = i;
            i = (_e47 + 1u);
        }
        loop_init = false;
        uint _e21 = i;
        if ((_e21 < end)) {
        } else {
            break;
        }
        {
            uint _e23 = i;
            uvec3 _e24 = around(_e23);
            vec3 _e26 = screen_of(_e24.x);
            vec3 _e28 = screen_of(_e24.y);
            bool _e29 = is_drawn(_e3, _e26, _e28);
            if (_e29) {
                Equations _e30 = sum_3;
                Equations _e35 = neighbor(_e30, _e24.x, (_e26.xy - _e3.xy), _e2);
                sum_3 = _e35;
                vec3 _e37 = screen_of(_e24.z);
                bool _e38 = is_drawn(_e3, _e28, _e37);
                if (!(_e38)) {
                    Equations _e40 = sum_3;
                    Equations _e45 = neighbor(_e40, _e24.y, (_e28.xy - _e3.xy), _e2);
                    sum_3 = _e45;
                }
            }
        }
    }
    float _e51 = sum_3.matrix.x;
    float _e54 = sum_3.matrix.z;
    float trace_1 = (_e51 + _e54);
    float weight_1 = ((trace_1 > 0.0) ? (0.07 / trace_1) : 0.0);
    vec3 _e63 = sum_3.matrix;
    vec3 _e66 = sum_3.right;
    vec3 _e69 = sum_3.up;
    sum_3 = Equations((_e63 * weight_1), (_e66 * weight_1), (_e69 * weight_1));
    vec3 _e72 = toward_eye(_e1);
    vec3 _e73 = across_both(_e2, _e72);
    vec3 away = cross(_e2, _e73);
    vec3 _e75 = across_both(_e72, _e2);
    vec2 _e76 = moved(_e1, _e75);
    float pixels = length(_e76);
    float facing = clamp((dot(_e2, _e72) / 0.05), 0.0, 1.0);
    Equations _e84 = sum_3;
    vec2 _e85 = moved(_e1, _e73);
    vec3 _e88 = bent(v_5, _e73);
    Equations _e91 = observed(_e84, (_e85 / vec2(pixels)), (_e88 / vec3(pixels)), facing);
    sum_3 = _e91;
    Equations _e92 = sum_3;
    vec2 _e93 = moved(_e1, away);
    vec3 _e96 = bent(v_5, away);
    Equations _e99 = observed(_e92, (_e93 / vec2(pixels)), (_e96 / vec3(pixels)), facing);
    sum_3 = _e99;
    Equations _e100 = sum_3;
    Slope _e101 = solved(_e100);
    return _e101;
}

void main() {
    uvec3 id = gl_GlobalInvocationID;
    uint _e4 = camera.points;
    if ((id.x >= _e4)) {
        return;
    }
    Slope _e7 = slope_of(id.x);
    uint width_1 = uvec2(imageSize(slopes_out).xy).x;
    uvec2 _e15 = texel((2u * id.x), width_1);
    imageStore(slopes_out, ivec2(_e15), vec4(_e7.right, 0.0));
    uvec2 _e25 = texel(((2u * id.x) + 1u), width_1);
    imageStore(slopes_out, ivec2(_e25), vec4(_e7.up, 0.0));
    return;
}

