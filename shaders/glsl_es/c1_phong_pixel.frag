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

layout(std140) uniform Scene_block { Scene scene; };

smooth in vec3 _vs2fs_location0;
smooth in vec3 _vs2fs_location1;
smooth in vec3 _vs2fs_location2;
flat in vec4 _vs2fs_location3;
flat in vec4 _vs2fs_location4;
flat in vec4 _vs2fs_location5;
flat in vec4 _vs2fs_location6;
flat in vec4 _vs2fs_location7;
flat in vec4 _vs2fs_location8;
flat in vec4 _vs2fs_location9;
flat in vec4 _vs2fs_location10;
flat in vec4 _vs2fs_location11;
layout(location = 0) out vec4 _fs2p_location0;

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

vec3 value_of(Pixel p) {
    vec4 _e11 = terms_of(p.weights);
    vec3 _e12 = cubic_value(p.a, p.b, p.c, p.d, p.e, p.f, p.g, p.h, p.i, _e11);
    return _e12;
}

vec3 lit(vec3 direction, vec3 place) {
    vec3 light = vec3(0.0);
    vec3 normal_1 = normalize(direction);
    uint _e11 = scene.is_orthographic;
    vec3 to_eye = ((_e11 != 0u) ? vec3(0.0, 0.0, 1.0) : normalize(-(place)));
    vec3 _e17 = scene.lamp;
    vec3 to_lamp = normalize(_e17);
    float cosine = dot(normal_1, to_lamp);
    vec3 _e22 = scene.ambient;
    light = _e22;
    if ((cosine > 0.0)) {
        float shine = max((((2.0 * cosine) * dot(normal_1, to_eye)) - dot(to_lamp, to_eye)), 0.0);
        vec3 _e34 = light;
        vec3 _e37 = scene.diffuse;
        vec3 _e41 = scene.specular;
        float _e44 = scene.shininess;
        light = (_e34 + ((_e37 * cosine) + (_e41 * pow(shine, _e44))));
    }
    vec3 _e49 = light;
    return _e49;
}

void main() {
    Pixel pixel = Pixel(gl_FragCoord, _vs2fs_location0, _vs2fs_location1, _vs2fs_location2, _vs2fs_location3, _vs2fs_location4, _vs2fs_location5, _vs2fs_location6, _vs2fs_location7, _vs2fs_location8, _vs2fs_location9, _vs2fs_location10, _vs2fs_location11);
    vec3 normal = vec3(0.0);
    normal = pixel.normal;
    if (any(notEqual(pixel.a, vec4(0.0)))) {
        vec3 _e8 = value_of(pixel);
        normal = _e8;
    }
    vec3 _e9 = normal;
    vec3 _e11 = lit(_e9, pixel.place);
    _fs2p_location0 = vec4(_e11, 1.0);
    return;
}

