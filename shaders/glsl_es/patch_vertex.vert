#version 300 es
// Generated from wgsl/c1.wgsl, which has the comments. Do not edit: `UPDATE_SHADERS=1 cargo test --test shading generated` writes it.

precision highp float;
precision highp int;

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
struct PatchPixel {
    vec4 position;
    vec3 weights;
    vec4 a;
    vec4 b;
    vec4 c;
};
const uint PROVOKING = 2u;

layout(std140) uniform Scene_block { Scene scene; };

uniform highp sampler2D coefficients;

layout(location = 0) in vec3 _p2vs_location0;
smooth out vec3 _vs2fs_location0;
flat out vec4 _vs2fs_location1;
flat out vec4 _vs2fs_location2;
flat out vec4 _vs2fs_location3;

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
    uint index = uint(gl_VertexID);
    PatchPixel out_ = PatchPixel(vec4(0.0), vec3(0.0), vec4(0.0), vec4(0.0), vec4(0.0));
    mat4x4 _e7 = scene.projection;
    mat4x4 _e10 = scene.model_view;
    out_.position = (_e7 * (_e10 * vec4(position, 1.0)));
    float _e18 = out_.position.w;
    vec3 _e19 = corner_weights(index, _e18);
    out_.weights = _e19;
    if (((index % 3u) == PROVOKING)) {
        uint at_1 = ((index / 3u) * 3u);
        vec4 _e29 = texel(at_1);
        out_.a = _e29;
        vec4 _e33 = texel((at_1 + 1u));
        out_.b = _e33;
        vec4 _e37 = texel((at_1 + 2u));
        out_.c = _e37;
    }
    PatchPixel _e38 = out_;
    gl_Position = _e38.position;
    _vs2fs_location0 = _e38.weights;
    _vs2fs_location1 = _e38.a;
    _vs2fs_location2 = _e38.b;
    _vs2fs_location3 = _e38.c;
    return;
}

