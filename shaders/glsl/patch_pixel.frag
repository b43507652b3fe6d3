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
struct PatchPixel {
    vec4 position;
    vec3 weights;
    vec4 a;
    vec4 b;
    vec4 c;
};
const uint PROVOKING = 2u;

layout(std140, binding = 0) uniform Scene_block { Scene scene; };

layout(location = 0) smooth in vec3 _vs2fs_location0;
layout(location = 1) flat in vec4 _vs2fs_location1;
layout(location = 2) flat in vec4 _vs2fs_location2;
layout(location = 3) flat in vec4 _vs2fs_location3;
layout(location = 0) out vec4 _fs2p_location0;

vec4 terms_of(vec3 weights) {
    vec3 w = (weights / vec3(((weights.x + weights.y) + weights.z)));
    float x = (w.x - w.z);
    float y = (w.y - w.z);
    float xx = (((x < 0.0) && (x <= y)) ? (x * x) : 0.0);
    float yy = (((y < 0.0) && (y < x)) ? (y * y) : 0.0);
    return vec4(x, y, ((yy * (y - (2.0 * x))) - (xx * y)), ((xx * (x - (2.0 * y))) - (yy * x)));
}

float scalar_value(vec4 a, vec4 b, vec4 c, vec4 t) {
    float along = (a.x + (t.x * (a.y + (t.x * (a.w + (t.x * b.z))))));
    float mixed = ((a.z + (t.x * (b.x + (t.x * b.w)))) + (t.y * ((b.y + (t.x * c.x)) + (t.y * c.y))));
    return (((along + (t.y * mixed)) + (t.z * c.z)) + (t.w * c.w));
}

void main() {
    PatchPixel pixel = PatchPixel(gl_FragCoord, _vs2fs_location0, _vs2fs_location1, _vs2fs_location2, _vs2fs_location3);
    vec3 _e3 = scene.diffuse;
    vec4 _e8 = terms_of(pixel.weights);
    float _e9 = scalar_value(pixel.a, pixel.b, pixel.c, _e8);
    _fs2p_location0 = vec4((_e3 * _e9), 1.0);
    return;
}

