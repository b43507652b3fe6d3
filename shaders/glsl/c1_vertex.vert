#version 450 core
// Generated from wgsl/c1.wgsl, which has the comments. Do not edit: `UPDATE_SHADERS=1 cargo test --test shading generated` writes it.
struct Scene {
    mat4x4 model_view;
    mat4x4 projection;
    vec3 lamp;
    float shininess;
    vec3 ambient;
    uint is_orthographic;
    vec3 diffuse;
    vec3 specular;
};
struct Pixel {
    vec4 position;
    vec3 weights;
    vec3 place;
    vec3 normal;
    vec4 a;
    vec4 b;
    vec4 c;
    vec4 d;
    vec4 e;
    vec4 f;
    vec4 g;
    vec4 h;
    vec4 i;
};
const uint PROVOKING = 2u;

layout(std140, binding = 0) uniform Scene_block { Scene scene; };

layout(binding = 1) uniform sampler2D coefficients;

layout(location = 0) in vec3 _p2vs_location0;
layout(location = 1) in vec3 _p2vs_location1;
layout(location = 0) smooth out vec3 _vs2fs_location0;
layout(location = 1) smooth out vec3 _vs2fs_location1;
layout(location = 2) smooth out vec3 _vs2fs_location2;
layout(location = 3) flat out vec4 _vs2fs_location3;
layout(location = 4) flat out vec4 _vs2fs_location4;
layout(location = 5) flat out vec4 _vs2fs_location5;
layout(location = 6) flat out vec4 _vs2fs_location6;
layout(location = 7) flat out vec4 _vs2fs_location7;
layout(location = 8) flat out vec4 _vs2fs_location8;
layout(location = 9) flat out vec4 _vs2fs_location9;
layout(location = 10) flat out vec4 _vs2fs_location10;
layout(location = 11) flat out vec4 _vs2fs_location11;

vec4 texel(uint at) {
    uint width = uvec2(textureSize(coefficients, 0).xy).x;
    vec4 _e9 = texelFetch(coefficients, ivec2(uvec2((at % width), (at / width))), 0);
    return _e9;
}

vec3 corner_weights(uint index_1, float w) {
    uint corner = (index_1 % 3u);
    return (vec3(float((corner == 0u)), float((corner == 1u)), float((corner == 2u))) * w);
}

void main() {
    vec3 position = _p2vs_location0;
    vec3 normal = _p2vs_location1;
    uint index = uint(gl_VertexID);
    Pixel out_ = Pixel(vec4(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0));
    mat4x4 _e5 = scene.model_view;
    vec4 place = (_e5 * vec4(position, 1.0));
    mat4x4 _e14 = scene.projection;
    out_.position = (_e14 * place);
    float _e19 = out_.position.w;
    vec3 _e20 = corner_weights(index, _e19);
    out_.weights = _e20;
    out_.place = place.xyz;
    mat4x4 _e26 = scene.model_view;
    out_.normal = (_e26 * vec4(normal, 0.0)).xyz;
    if (((index % 3u) == PROVOKING)) {
        uint at_1 = ((index / 3u) * 9u);
        vec4 _e40 = texel(at_1);
        out_.a = _e40;
        vec4 _e44 = texel((at_1 + 1u));
        out_.b = _e44;
        vec4 _e48 = texel((at_1 + 2u));
        out_.c = _e48;
        vec4 _e52 = texel((at_1 + 3u));
        out_.d = _e52;
        vec4 _e56 = texel((at_1 + 4u));
        out_.e = _e56;
        vec4 _e60 = texel((at_1 + 5u));
        out_.f = _e60;
        vec4 _e64 = texel((at_1 + 6u));
        out_.g = _e64;
        vec4 _e68 = texel((at_1 + 7u));
        out_.h = _e68;
        vec4 _e72 = texel((at_1 + 8u));
        out_.i = _e72;
    }
    Pixel _e73 = out_;
    gl_Position = _e73.position;
    _vs2fs_location0 = _e73.weights;
    _vs2fs_location1 = _e73.place;
    _vs2fs_location2 = _e73.normal;
    _vs2fs_location3 = _e73.a;
    _vs2fs_location4 = _e73.b;
    _vs2fs_location5 = _e73.c;
    _vs2fs_location6 = _e73.d;
    _vs2fs_location7 = _e73.e;
    _vs2fs_location8 = _e73.f;
    _vs2fs_location9 = _e73.g;
    _vs2fs_location10 = _e73.h;
    _vs2fs_location11 = _e73.i;
    return;
}

