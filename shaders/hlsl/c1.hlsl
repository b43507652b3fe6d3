// Generated from wgsl/c1.wgsl, which has the comments. Do not edit: `UPDATE_SHADERS=1 cargo test --test shading generated` writes it.
struct Scene {
    row_major float4x4 model_view;
    row_major float4x4 projection;
    float3 lamp;
    float shininess;
    float3 ambient;
    uint is_orthographic;
    float3 diffuse;
    int _pad7_0;
    float3 specular;
    int _end_pad_0;
};

struct Pixel {
    float4 position : SV_Position;
    float3 weights : LOC0;
    float3 place : LOC1;
    float3 normal : LOC2;
    nointerpolation float4 a : LOC3;
    nointerpolation float4 b : LOC4;
    nointerpolation float4 c : LOC5;
    nointerpolation float4 d : LOC6;
    nointerpolation float4 e : LOC7;
    nointerpolation float4 f : LOC8;
    nointerpolation float4 g : LOC9;
    nointerpolation float4 h : LOC10;
    nointerpolation float4 i : LOC11;
};

struct PatchPixel {
    float4 position : SV_Position;
    float3 weights : LOC0;
    nointerpolation float4 a : LOC1;
    nointerpolation float4 b : LOC2;
    nointerpolation float4 c : LOC3;
};

static const uint PROVOKING = 0u;

cbuffer scene : register(b0) { Scene scene; }
Texture2D<float4> coefficients : register(t1);

struct VertexOutput_c1_vertex {
    float3 weights_1 : LOC0;
    float3 place_1 : LOC1;
    float3 normal_2 : LOC2;
    nointerpolation float4 a_2 : LOC3;
    nointerpolation float4 b_2 : LOC4;
    nointerpolation float4 c_2 : LOC5;
    nointerpolation float4 d_1 : LOC6;
    nointerpolation float4 e_1 : LOC7;
    nointerpolation float4 f_1 : LOC8;
    nointerpolation float4 g_1 : LOC9;
    nointerpolation float4 h_1 : LOC10;
    nointerpolation float4 i_1 : LOC11;
    float4 position_2 : SV_Position;
};

struct FragmentInput_c1_phong_pixel {
    float3 weights_2 : LOC0;
    float3 place_2 : LOC1;
    float3 normal_3 : LOC2;
    nointerpolation float4 a_3 : LOC3;
    nointerpolation float4 b_3 : LOC4;
    nointerpolation float4 c_3 : LOC5;
    nointerpolation float4 d_2 : LOC6;
    nointerpolation float4 e_2 : LOC7;
    nointerpolation float4 f_2 : LOC8;
    nointerpolation float4 g_2 : LOC9;
    nointerpolation float4 h_2 : LOC10;
    nointerpolation float4 i_2 : LOC11;
    float4 position_3 : SV_Position;
};

struct FragmentInput_patch_color_pixel {
    float3 weights_3 : LOC0;
    float3 place_3 : LOC1;
    float3 normal_4 : LOC2;
    nointerpolation float4 a_4 : LOC3;
    nointerpolation float4 b_4 : LOC4;
    nointerpolation float4 c_4 : LOC5;
    nointerpolation float4 d_3 : LOC6;
    nointerpolation float4 e_3 : LOC7;
    nointerpolation float4 f_3 : LOC8;
    nointerpolation float4 g_3 : LOC9;
    nointerpolation float4 h_3 : LOC10;
    nointerpolation float4 i_3 : LOC11;
    float4 position_4 : SV_Position;
};

struct VertexOutput_patch_vertex {
    float3 weights_4 : LOC0;
    nointerpolation float4 a_5 : LOC1;
    nointerpolation float4 b_5 : LOC2;
    nointerpolation float4 c_5 : LOC3;
    float4 position_5 : SV_Position;
};

struct FragmentInput_patch_pixel {
    float3 weights_5 : LOC0;
    nointerpolation float4 a_6 : LOC1;
    nointerpolation float4 b_6 : LOC2;
    nointerpolation float4 c_6 : LOC3;
    float4 position_6 : SV_Position;
};

uint naga_mod(uint lhs, uint rhs) {
    return lhs % (rhs == 0u ? 1u : rhs);
}

uint naga_div(uint lhs, uint rhs) {
    return lhs / (rhs == 0u ? 1u : rhs);
}

uint2 NagaDimensions2D(Texture2D<float4> tex)
{
    uint4 ret;
    tex.GetDimensions(0, ret.x, ret.y, ret.z);
    return ret.xy;
}

float4 texel(uint at)
{
    uint width = NagaDimensions2D(coefficients).x;
    float4 _e9 = coefficients.Load(int3(uint2(naga_mod(at, width), naga_div(at, width)), int(0)));
    return _e9;
}

float3 corner_weights(uint index_2, float w)
{
    uint corner = naga_mod(index_2, 3u);
    return (float3(float((corner == 0u)), float((corner == 1u)), float((corner == 2u))) * w);
}

float4 terms_of(float3 weights)
{
    float3 w_1 = (weights / (((weights.x + weights.y) + weights.z)).xxx);
    float x = (w_1.x - w_1.z);
    float y = (w_1.y - w_1.z);
    float xx = (((x < 0.0) & (x <= y)) ? (x * x) : 0.0);
    float yy = (((y < 0.0) & (y < x)) ? (y * y) : 0.0);
    return float4(x, y, ((yy * (y - (2.0 * x))) - (xx * y)), ((xx * (x - (2.0 * y))) - (yy * x)));
}

float3 cubic_value(float4 a, float4 b, float4 c, float4 d, float4 e, float4 f, float4 g, float4 h, float4 i, float4 t)
{
    float3 along = (a.xyz + (t.x * (float3(a.w, b.xy) + (t.x * (c.yzw + (t.x * float3(e.zw, f.x)))))));
    float3 mixed = ((float3(b.zw, c.x) + (t.x * (d.xyz + (t.x * f.yzw)))) + (t.y * ((float3(d.w, e.xy) + (t.x * g.xyz)) + (t.y * float3(g.w, h.xy)))));
    return (((along + (t.y * mixed)) + (t.z * float3(h.zw, i.x))) + (t.w * i.yzw));
}

float scalar_value(float4 a_1, float4 b_1, float4 c_1, float4 t_1)
{
    float along_1 = (a_1.x + (t_1.x * (a_1.y + (t_1.x * (a_1.w + (t_1.x * b_1.z))))));
    float mixed_1 = ((a_1.z + (t_1.x * (b_1.x + (t_1.x * b_1.w)))) + (t_1.y * ((b_1.y + (t_1.x * c_1.x)) + (t_1.y * c_1.y))));
    return (((along_1 + (t_1.y * mixed_1)) + (t_1.z * c_1.z)) + (t_1.w * c_1.w));
}

float3 value_of(Pixel p)
{
    const float4 _e11 = terms_of(p.weights);
    const float3 _e12 = cubic_value(p.a, p.b, p.c, p.d, p.e, p.f, p.g, p.h, p.i, _e11);
    return _e12;
}

float3 lit_(float3 direction, float3 place)
{
    float3 light = (float3)0;

    float3 normal_5 = normalize(direction);
    uint _e11 = scene.is_orthographic;
    float3 to_eye = ((_e11 != 0u) ? float3(0.0, 0.0, 1.0) : normalize(-(place)));
    float3 _e17 = scene.lamp;
    float3 to_lamp = normalize(_e17);
    float cosine = dot(normal_5, to_lamp);
    float3 _e22 = scene.ambient;
    light = _e22;
    if ((cosine > 0.0)) {
        float shine = max((((2.0 * cosine) * dot(normal_5, to_eye)) - dot(to_lamp, to_eye)), 0.0);
        float3 _e34 = light;
        float3 _e37 = scene.diffuse;
        float3 _e41 = scene.specular;
        float _e44 = scene.shininess;
        light = (_e34 + ((_e37 * cosine) + (_e41 * pow(shine, _e44))));
    }
    float3 _e49 = light;
    return _e49;
}

Pixel ZeroValuePixel() {
    return (Pixel)0;
}

VertexOutput_c1_vertex c1_vertex(float3 position : LOC0, float3 normal : LOC1, uint index : SV_VertexID)
{
    Pixel out_ = ZeroValuePixel();

    float4x4 _e5 = scene.model_view;
    float4 place_4 = mul(float4(position, 1.0), _e5);
    float4x4 _e14 = scene.projection;
    out_.position = mul(place_4, _e14);
    float _e19 = out_.position.w;
    const float3 _e20 = corner_weights(index, _e19);
    out_.weights = _e20;
    out_.place = place_4.xyz;
    float4x4 _e26 = scene.model_view;
    out_.normal = mul(float4(normal, 0.0), _e26).xyz;
    if ((naga_mod(index, 3u) == PROVOKING)) {
        uint at_1 = (naga_div(index, 3u) * 9u);
        const float4 _e40 = texel(at_1);
        out_.a = _e40;
        const float4 _e44 = texel((at_1 + 1u));
        out_.b = _e44;
        const float4 _e48 = texel((at_1 + 2u));
        out_.c = _e48;
        const float4 _e52 = texel((at_1 + 3u));
        out_.d = _e52;
        const float4 _e56 = texel((at_1 + 4u));
        out_.e = _e56;
        const float4 _e60 = texel((at_1 + 5u));
        out_.f = _e60;
        const float4 _e64 = texel((at_1 + 6u));
        out_.g = _e64;
        const float4 _e68 = texel((at_1 + 7u));
        out_.h = _e68;
        const float4 _e72 = texel((at_1 + 8u));
        out_.i = _e72;
    }
    Pixel _e73 = out_;
    const Pixel pixel_3 = _e73;
    const VertexOutput_c1_vertex pixel_3_ = { pixel_3.weights, pixel_3.place, pixel_3.normal, pixel_3.a, pixel_3.b, pixel_3.c, pixel_3.d, pixel_3.e, pixel_3.f, pixel_3.g, pixel_3.h, pixel_3.i, pixel_3.position };
    return pixel_3_;
}

float4 c1_phong_pixel(FragmentInput_c1_phong_pixel fragmentinput_c1_phong_pixel) : SV_Target0
{
    Pixel pixel = { fragmentinput_c1_phong_pixel.position_3, fragmentinput_c1_phong_pixel.weights_2, fragmentinput_c1_phong_pixel.place_2, fragmentinput_c1_phong_pixel.normal_3, fragmentinput_c1_phong_pixel.a_3, fragmentinput_c1_phong_pixel.b_3, fragmentinput_c1_phong_pixel.c_3, fragmentinput_c1_phong_pixel.d_2, fragmentinput_c1_phong_pixel.e_2, fragmentinput_c1_phong_pixel.f_2, fragmentinput_c1_phong_pixel.g_2, fragmentinput_c1_phong_pixel.h_2, fragmentinput_c1_phong_pixel.i_2 };
    float3 normal_1 = (float3)0;

    normal_1 = pixel.normal;
    if (any((pixel.a != (0.0).xxxx))) {
        const float3 _e8 = value_of(pixel);
        normal_1 = _e8;
    }
    float3 _e9 = normal_1;
    const float3 _e11 = lit_(_e9, pixel.place);
    return float4(_e11, 1.0);
}

float4 patch_color_pixel(FragmentInput_patch_color_pixel fragmentinput_patch_color_pixel) : SV_Target0
{
    Pixel pixel_1 = { fragmentinput_patch_color_pixel.position_4, fragmentinput_patch_color_pixel.weights_3, fragmentinput_patch_color_pixel.place_3, fragmentinput_patch_color_pixel.normal_4, fragmentinput_patch_color_pixel.a_4, fragmentinput_patch_color_pixel.b_4, fragmentinput_patch_color_pixel.c_4, fragmentinput_patch_color_pixel.d_3, fragmentinput_patch_color_pixel.e_3, fragmentinput_patch_color_pixel.f_3, fragmentinput_patch_color_pixel.g_3, fragmentinput_patch_color_pixel.h_3, fragmentinput_patch_color_pixel.i_3 };
    const float3 _e1 = value_of(pixel_1);
    return float4(_e1, 1.0);
}

PatchPixel ZeroValuePatchPixel() {
    return (PatchPixel)0;
}

VertexOutput_patch_vertex patch_vertex(float3 position_1 : LOC0, uint index_1 : SV_VertexID)
{
    PatchPixel out_1 = ZeroValuePatchPixel();

    float4x4 _e7 = scene.projection;
    float4x4 _e10 = scene.model_view;
    out_1.position = mul(mul(float4(position_1, 1.0), _e10), _e7);
    float _e18 = out_1.position.w;
    const float3 _e19 = corner_weights(index_1, _e18);
    out_1.weights = _e19;
    if ((naga_mod(index_1, 3u) == PROVOKING)) {
        uint at_2 = (naga_div(index_1, 3u) * 3u);
        const float4 _e29 = texel(at_2);
        out_1.a = _e29;
        const float4 _e33 = texel((at_2 + 1u));
        out_1.b = _e33;
        const float4 _e37 = texel((at_2 + 2u));
        out_1.c = _e37;
    }
    PatchPixel _e38 = out_1;
    const PatchPixel patchpixel = _e38;
    const VertexOutput_patch_vertex patchpixel_1 = { patchpixel.weights, patchpixel.a, patchpixel.b, patchpixel.c, patchpixel.position };
    return patchpixel_1;
}

float4 patch_pixel(FragmentInput_patch_pixel fragmentinput_patch_pixel) : SV_Target0
{
    PatchPixel pixel_2 = { fragmentinput_patch_pixel.position_6, fragmentinput_patch_pixel.weights_5, fragmentinput_patch_pixel.a_6, fragmentinput_patch_pixel.b_6, fragmentinput_patch_pixel.c_6 };
    float3 _e3 = scene.diffuse;
    const float4 _e8 = terms_of(pixel_2.weights);
    const float _e9 = scalar_value(pixel_2.a, pixel_2.b, pixel_2.c, _e8);
    return float4((_e3 * _e9), 1.0);
}
