#version 450 core
// Generated from wgsl/c1.wgsl, which has the comments. Do not edit: `UPDATE_SHADERS=1 cargo test --test shading generated` writes it.
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

layout(location = 0) smooth in vec3 _vs2fs_location0;
layout(location = 1) smooth in vec3 _vs2fs_location1;
layout(location = 2) smooth in vec3 _vs2fs_location2;
layout(location = 3) flat in vec4 _vs2fs_location3;
layout(location = 4) flat in vec4 _vs2fs_location4;
layout(location = 5) flat in vec4 _vs2fs_location5;
layout(location = 6) flat in vec4 _vs2fs_location6;
layout(location = 7) flat in vec4 _vs2fs_location7;
layout(location = 8) flat in vec4 _vs2fs_location8;
layout(location = 9) flat in vec4 _vs2fs_location9;
layout(location = 10) flat in vec4 _vs2fs_location10;
layout(location = 11) flat in vec4 _vs2fs_location11;
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

void main() {
    Pixel pixel = Pixel(gl_FragCoord, _vs2fs_location0, _vs2fs_location1, _vs2fs_location2, _vs2fs_location3, _vs2fs_location4, _vs2fs_location5, _vs2fs_location6, _vs2fs_location7, _vs2fs_location8, _vs2fs_location9, _vs2fs_location10, _vs2fs_location11);
    vec3 _e1 = value_of(pixel);
    _fs2p_location0 = vec4(_e1, 1.0);
    return;
}

