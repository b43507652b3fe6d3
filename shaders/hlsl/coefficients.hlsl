// Generated from wgsl/coefficients.wgsl, which has the comments. Do not edit: `UPDATE_SHADERS=1 cargo test --test shading generated` writes it.
struct Camera {
    row_major float4x4 model_view;
    row_major float4x4 projection;
    float2 size;
    uint points;
    uint triangles;
    uint width;
    int _end_pad_0;
    int _end_pad_1;
    int _end_pad_2;
};

struct Equations {
    float3 matrix_;
    int _pad1_0;
    float3 right;
    int _pad2_0;
    float3 up;
    int _end_pad_0;
};

struct Slope {
    float3 right;
    int _pad1_0;
    float3 up;
    int _end_pad_0;
};

cbuffer camera : register(b0) { Camera camera; }
Texture2D<float4> points : register(t1);
Texture2D<uint4> ring : register(t2);
Texture2D<uint4> corners : register(t3);
Texture2D<float4> gradients : register(t4);
RWTexture2D<float4> slopes_out : register(u5);
RWTexture2D<float4> coefficients_out : register(u6);

struct FragmentInput_slopes_texel {
    float4 place_3 : SV_Position;
};

struct FragmentInput_coefficients_texel {
    float4 place_4 : SV_Position;
};

uint naga_mod(uint lhs, uint rhs) {
    return lhs % (rhs == 0u ? 1u : rhs);
}

uint naga_div(uint lhs, uint rhs) {
    return lhs / (rhs == 0u ? 1u : rhs);
}

uint2 texel(uint at, uint width)
{
    return uint2(naga_mod(at, width), naga_div(at, width));
}

uint2 NagaDimensions2D(Texture2D<float4> tex)
{
    uint4 ret;
    tex.GetDimensions(0, ret.x, ret.y, ret.z);
    return ret.xy;
}

float4 point_(uint v, uint which)
{
    const uint2 _e9 = texel(((5u * v) + which), NagaDimensions2D(points).x);
    float4 _e11 = points.Load(int3(_e9, int(0)));
    return _e11;
}

uint2 NagaDimensions2D(Texture2D<uint4> tex)
{
    uint4 ret;
    tex.GetDimensions(0, ret.x, ret.y, ret.z);
    return ret.xy;
}

uint3 around(uint at_1)
{
    const uint2 _e5 = texel(at_1, NagaDimensions2D(ring).x);
    uint4 _e7 = ring.Load(int3(_e5, int(0)));
    return _e7.xyz;
}

float3 eye_of(uint v_1)
{
    float4x4 _e3 = camera.model_view;
    const float4 _e5 = point_(v_1, 0u);
    return mul(float4(_e5.xyz, 1.0), _e3).xyz;
}

float3 normal_of(uint v_2)
{
    float4x4 _e3 = camera.model_view;
    const float4 _e5 = point_(v_2, 1u);
    return normalize(mul(float4(_e5.xyz, 0.0), _e3).xyz);
}

float3 screen_of(uint v_3)
{
    float4x4 _e3 = camera.projection;
    const float3 _e4 = eye_of(v_3);
    float4 place_5 = mul(float4(_e4, 1.0), _e3);
    float2 _e14 = camera.size;
    return float3((((place_5.xy / (place_5.w).xx) * _e14) / (2.0).xx), place_5.w);
}

float2 moved(float3 eye, float3 step_)
{
    float4x4 _e4 = camera.projection;
    float4 place_6 = mul(float4(eye, 1.0), _e4);
    float4x4 _e10 = camera.projection;
    float4 change_1 = mul(float4(step_, 0.0), _e10);
    float2 _e28 = camera.size;
    return (((((change_1.xy * place_6.w) - (place_6.xy * change_1.w)) / ((place_6.w * place_6.w)).xx) * _e28) / (2.0).xx);
}

float3 toward_eye(float3 eye_1)
{
    float _e5 = camera.projection[3].w;
    if ((_e5 == 1.0)) {
        return float3(0.0, 0.0, 1.0);
    }
    return normalize(-(eye_1));
}

float turn(float2 a, float2 b)
{
    return ((a.x * b.y) - (a.y * b.x));
}

bool is_drawn(float3 a_1, float3 b_1, float3 c)
{
    bool local = (bool)0;

    if ((min(a_1.z, min(b_1.z, c.z)) > 0.0)) {
        const float _e18 = turn((b_1.xy - a_1.xy), (c.xy - a_1.xy));
        local = (_e18 > 0.0);
    } else {
        local = false;
    }
    bool _e22 = local;
    return _e22;
}

float3 across_both(float3 normal, float3 other)
{
    float3 across_1 = cross(normal, other);
    if ((dot(across_1, across_1) >= 1e-9)) {
        return normalize(across_1);
    }
    return normalize(cross(normal, ((abs(normal.x) < 0.6) ? float3(1.0, 0.0, 0.0) : float3(0.0, 1.0, 0.0))));
}

float3 bent(uint v_4, float3 step_1)
{
    float4 _e5 = camera.model_view[0];
    float4 _e10 = camera.model_view[1];
    float4 _e15 = camera.model_view[2];
    float3x3 turn_1 = float3x3(_e5.xyz, _e10.xyz, _e15.xyz);
    const float4 _e19 = point_(v_4, 2u);
    const float4 _e22 = point_(v_4, 3u);
    const float4 _e25 = point_(v_4, 4u);
    float3x3 curvature = float3x3(_e19.xyz, _e22.xyz, _e25.xyz);
    float squared = dot(turn_1[0], turn_1[0]);
    return (mul(mul(mul(turn_1, step_1), curvature), turn_1) / ((squared * sqrt(squared))).xxx);
}

Equations ConstructEquations(float3 arg0, float3 arg1, float3 arg2) {
    Equations ret = (Equations)0;
    ret.matrix_ = arg0;
    ret.right = arg1;
    ret.up = arg2;
    return ret;
}

Equations observed(Equations sum, float2 offset, float3 change, float weight)
{
    float3 squares = float3((offset.x * offset.x), (offset.x * offset.y), (offset.y * offset.y));
    const Equations equations = ConstructEquations((sum.matrix_ + (weight * squares)), (sum.right + ((weight * offset.x) * change)), (sum.up + ((weight * offset.y) * change)));
    return equations;
}

Equations neighbor(Equations sum_1, uint other_1, float2 offset_1, float3 normal_1)
{
    float squared_1 = dot(offset_1, offset_1);
    if ((squared_1 > 0.0)) {
        const float3 _e7 = normal_of(other_1);
        const Equations _e11 = observed(sum_1, offset_1, (_e7 - normal_1), (1.0 / squared_1));
        const Equations equations_1 = _e11;
        return equations_1;
    }
    const Equations equations_2 = sum_1;
    return equations_2;
}

Slope ConstructSlope(float3 arg0, float3 arg1) {
    Slope ret = (Slope)0;
    ret.right = arg0;
    ret.up = arg1;
    return ret;
}

Slope solved(Equations sum_2)
{
    float3 m = sum_2.matrix_;
    float determinant_ = ((m.x * m.z) - (m.y * m.y));
    float trace = (m.x + m.z);
    if ((determinant_ > ((1e-6 * trace) * trace))) {
        const Slope slope = ConstructSlope((((m.z * sum_2.right) - (m.y * sum_2.up)) / (determinant_).xxx), (((m.x * sum_2.up) - (m.y * sum_2.right)) / (determinant_).xxx));
        return slope;
    }
    float scale = ((trace > 0.0) ? (1.0 / trace) : 0.0);
    const Slope slope_1 = ConstructSlope((sum_2.right * scale), (sum_2.up * scale));
    return slope_1;
}

uint naga_f2u32(float value) {
    return uint(clamp(value, 0.0, 4294967000.0));
}

Slope slope_of(uint v_5)
{
    Equations sum_3 = ConstructEquations((0.0).xxx, (0.0).xxx, (0.0).xxx);
    uint i = (uint)0;

    const float3 _e1 = eye_of(v_5);
    const float3 _e2 = normal_of(v_5);
    const float3 _e3 = screen_of(v_5);
    const float4 _e5 = point_(v_5, 0u);
    uint start = naga_f2u32(_e5.w);
    const float4 _e9 = point_(v_5, 1u);
    uint end = naga_f2u32(_e9.w);
    i = start;
    uint2 loop_bound = uint2(4294967295u, 4294967295u);
    bool loop_init = true;
    while(true) {
        if (all(loop_bound == uint2(0u, 0u))) { break; }
        loop_bound -= uint2(loop_bound.y == 0u, 1u);
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
            const uint3 _e24 = around(_e23);
            const float3 _e26 = screen_of(_e24.x);
            const float3 _e28 = screen_of(_e24.y);
            const bool _e29 = is_drawn(_e3, _e26, _e28);
            if (_e29) {
                Equations _e30 = sum_3;
                const Equations _e35 = neighbor(_e30, _e24.x, (_e26.xy - _e3.xy), _e2);
                sum_3 = _e35;
                const float3 _e37 = screen_of(_e24.z);
                const bool _e38 = is_drawn(_e3, _e28, _e37);
                if (!(_e38)) {
                    Equations _e40 = sum_3;
                    const Equations _e45 = neighbor(_e40, _e24.y, (_e28.xy - _e3.xy), _e2);
                    sum_3 = _e45;
                }
            }
        }
    }
    float _e51 = sum_3.matrix_.x;
    float _e54 = sum_3.matrix_.z;
    float trace_1 = (_e51 + _e54);
    float weight_1 = ((trace_1 > 0.0) ? (0.07 / trace_1) : 0.0);
    float3 _e63 = sum_3.matrix_;
    float3 _e66 = sum_3.right;
    float3 _e69 = sum_3.up;
    sum_3 = ConstructEquations((_e63 * weight_1), (_e66 * weight_1), (_e69 * weight_1));
    const float3 _e72 = toward_eye(_e1);
    const float3 _e73 = across_both(_e2, _e72);
    float3 away = cross(_e2, _e73);
    const float3 _e75 = across_both(_e72, _e2);
    const float2 _e76 = moved(_e1, _e75);
    float pixels = length(_e76);
    float facing = clamp((dot(_e2, _e72) / 0.05), 0.0, 1.0);
    Equations _e84 = sum_3;
    const float2 _e85 = moved(_e1, _e73);
    const float3 _e88 = bent(v_5, _e73);
    const Equations _e91 = observed(_e84, (_e85 / (pixels).xx), (_e88 / (pixels).xxx), facing);
    sum_3 = _e91;
    Equations _e92 = sum_3;
    const float2 _e93 = moved(_e1, away);
    const float3 _e96 = bent(v_5, away);
    const Equations _e99 = observed(_e92, (_e93 / (pixels).xx), (_e96 / (pixels).xxx), facing);
    sum_3 = _e99;
    Equations _e100 = sum_3;
    const Slope _e101 = solved(_e100);
    const Slope slope_2 = _e101;
    return slope_2;
}

float3 along(uint v_6, float2 step_2)
{
    uint width_1 = NagaDimensions2D(gradients).x;
    const uint2 _e8 = texel((2u * v_6), width_1);
    float4 _e10 = gradients.Load(int3(_e8, int(0)));
    float3 right = _e10.xyz;
    const uint2 _e17 = texel(((2u * v_6) + 1u), width_1);
    float4 _e19 = gradients.Load(int3(_e17, int(0)));
    float3 up = _e19.xyz;
    return ((right * step_2.x) + (up * step_2.y));
}

float crossing(float2 i_1, float2 j, float2 centroid_, float2x3 eyes, float3 normals)
{
    float2 across = (float2)0;

    float2 edge = (j - i_1);
    const float2 _e16 = moved(((eyes[0] + eyes[1]) / (2.0).xxx), cross(normals, (eyes[1] - eyes[0])));
    across = _e16;
    float2 _e18 = across;
    const float _e19 = turn(_e18, edge);
    float2 _e21 = across;
    if ((abs(_e19) <= ((0.1 * length(_e21)) * length(edge)))) {
        across = float2(-(edge.y), edge.x);
    }
    float2 _e33 = across;
    const float _e34 = turn((centroid_ - i_1), _e33);
    float2 _e35 = across;
    const float _e36 = turn(edge, _e35);
    return (_e34 / _e36);
}

float3 middle(float x, float3 i_2, float3 ij, float3 ji, float3 j_1, float3 near_i, float3 near_j)
{
    return ((((near_i + near_j) / (2.0).xxx) + ((1.0 - x) * (ij - ((i_2 + ji) / (2.0).xxx)))) + (x * (ji - ((ij + j_1) / (2.0).xxx))));
}

typedef float4 ret_Constructarray9_float4_[9];
ret_Constructarray9_float4_ Constructarray9_float4_(float4 arg0, float4 arg1, float4 arg2, float4 arg3, float4 arg4, float4 arg5, float4 arg6, float4 arg7, float4 arg8) {
    float4 ret[9] = { arg0, arg1, arg2, arg3, arg4, arg5, arg6, arg7, arg8 };
    return ret;
}

typedef float4 ret_cubic_of[9];
ret_cubic_of cubic_of(uint t)
{
    uint width_2 = NagaDimensions2D(corners).x;
    const uint2 _e7 = texel((3u * t), width_2);
    uint4 _e9 = corners.Load(int3(_e7, int(0)));
    uint3 ia = _e9.xyz;
    const uint2 _e16 = texel(((3u * t) + 1u), width_2);
    uint4 _e18 = corners.Load(int3(_e16, int(0)));
    uint3 ib = _e18.xyz;
    const uint2 _e25 = texel(((3u * t) + 2u), width_2);
    uint4 _e27 = corners.Load(int3(_e25, int(0)));
    uint3 ic = _e27.xyz;
    const float3 _e30 = screen_of(ia.x);
    const float3 _e32 = screen_of(ib.x);
    const float3 _e34 = screen_of(ic.x);
    const bool _e35 = is_drawn(_e30, _e32, _e34);
    if (!(_e35)) {
        float4 zero = (0.0).xxxx;
        return Constructarray9_float4_(zero, zero, zero, zero, zero, zero, zero, zero, zero);
    }
    const float3 _e41 = eye_of(ia.x);
    const float3 _e43 = eye_of(ib.x);
    const float3 _e45 = eye_of(ic.x);
    const float3 _e47 = normal_of(ia.x);
    const float3 _e49 = normal_of(ib.x);
    const float3 _e51 = normal_of(ic.x);
    float2 centroid_1 = (((_e30.xy + _e32.xy) + _e34.xy) / (3.0).xx);
    const float3 _e64 = along(ia.y, (_e32.xy - _e30.xy));
    float3 ab = (_e47 + (_e64 / (3.0).xxx));
    const float3 _e73 = along(ia.z, (_e34.xy - _e30.xy));
    float3 ac = (_e47 + (_e73 / (3.0).xxx));
    const float3 _e82 = along(ib.y, (_e34.xy - _e32.xy));
    float3 bc = (_e49 + (_e82 / (3.0).xxx));
    const float3 _e91 = along(ib.z, (_e30.xy - _e32.xy));
    float3 ba = (_e49 + (_e91 / (3.0).xxx));
    const float3 _e100 = along(ic.y, (_e30.xy - _e34.xy));
    float3 ca = (_e51 + (_e100 / (3.0).xxx));
    const float3 _e109 = along(ic.z, (_e32.xy - _e34.xy));
    float3 cb = (_e51 + (_e109 / (3.0).xxx));
    float3 na = (((_e47 + ab) + ac) / (3.0).xxx);
    float3 nb = (((_e49 + bc) + ba) / (3.0).xxx);
    float3 nc = (((_e51 + ca) + cb) / (3.0).xxx);
    const float _e133 = crossing(_e32.xy, _e34.xy, centroid_1, float2x3(_e43, _e45), (_e49 + _e51));
    const float3 _e134 = middle(_e133, _e49, bc, cb, _e51, nb, nc);
    const float _e139 = crossing(_e34.xy, _e30.xy, centroid_1, float2x3(_e45, _e41), (_e51 + _e47));
    const float3 _e140 = middle(_e139, _e51, ca, ac, _e47, nc, na);
    const float _e145 = crossing(_e30.xy, _e32.xy, centroid_1, float2x3(_e41, _e43), (_e47 + _e49));
    const float3 _e146 = middle(_e145, _e47, ab, ba, _e49, na, nb);
    float3 fa = (((na + _e140) + _e146) / (3.0).xxx);
    float3 fb = (((nb + _e146) + _e134) / (3.0).xxx);
    float3 fc = (((nc + _e134) + _e140) / (3.0).xxx);
    float3 n = (((fa + fb) + fc) / (3.0).xxx);
    float3 cube_a = (((_e47 - (3.0 * na)) + (3.0 * fa)) - n);
    float3 cube_b = (((_e49 - (3.0 * nb)) + (3.0 * fb)) - n);
    float3 cube_c = (((_e51 - (3.0 * nc)) + (3.0 * fc)) - n);
    float3 dab = (3.0 * (((((ab - na) - (2.0 * _e146)) + (2.0 * fa)) + fb) - n));
    float3 dba = (3.0 * (((((ba - nb) - (2.0 * _e146)) + (2.0 * fb)) + fa) - n));
    float3 dac = (3.0 * (((((ac - na) - (2.0 * _e140)) + (2.0 * fa)) + fc) - n));
    float3 dca = (3.0 * (((((ca - nc) - (2.0 * _e140)) + (2.0 * fc)) + fa) - n));
    float3 dbc = (3.0 * (((((bc - nb) - (2.0 * _e134)) + (2.0 * fb)) + fc) - n));
    float3 dcb = (3.0 * (((((cb - nc) - (2.0 * _e134)) + (2.0 * fc)) + fb) - n));
    float3 k1_ = (3.0 * (fa - n));
    float3 k2_ = (3.0 * (fb - n));
    float3 k3_ = (3.0 * ((na - (2.0 * fa)) + n));
    float3 k4_ = (6.0 * (((_e146 - fa) - fb) + n));
    float3 k5_ = (3.0 * ((nb - (2.0 * fb)) + n));
    float3 k10_ = (-((((cube_c + dca) + dac) + cube_a)) - cube_b);
    float3 k11_ = (-((((cube_b + dbc) + dcb) + cube_c)) - cube_a);
    return Constructarray9_float4_(float4(n, k1_.x), float4(k1_.yz, k2_.xy), float4(k2_.z, k3_), float4(k4_, k5_.x), float4(k5_.yz, cube_a.xy), float4(cube_a.z, dab), float4(dba, cube_b.x), float4(cube_b.yz, k10_.xy), float4(k10_.z, k11_));
}

uint index_of(float4 place_2)
{
    uint _e5 = camera.width;
    return ((naga_f2u32(place_2.y) * _e5) + naga_f2u32(place_2.x));
}

uint2 NagaRWDimensions2D(RWTexture2D<float4> tex)
{
    uint4 ret;
    tex.GetDimensions(ret.x, ret.y);
    return ret.xy;
}

[numthreads(64, 1, 1)]
void slopes(uint3 id : SV_DispatchThreadID)
{
    uint _e4 = camera.points;
    if ((id.x >= _e4)) {
        return;
    }
    const Slope _e7 = slope_of(id.x);
    uint width_3 = NagaRWDimensions2D(slopes_out).x;
    const uint2 _e15 = texel((2u * id.x), width_3);
    slopes_out[_e15] = float4(_e7.right, 0.0);
    const uint2 _e25 = texel(((2u * id.x) + 1u), width_3);
    slopes_out[_e25] = float4(_e7.up, 0.0);
    return;
}

[numthreads(64, 1, 1)]
void coefficients(uint3 id_1 : SV_DispatchThreadID)
{
    uint k = 0u;

    uint _e4 = camera.triangles;
    if ((id_1.x >= _e4)) {
        return;
    }
    const float4 _e7[9] = cubic_of(id_1.x);
    uint width_4 = NagaRWDimensions2D(coefficients_out).x;
    uint2 loop_bound_1 = uint2(4294967295u, 4294967295u);
    bool loop_init_1 = true;
    while(true) {
        if (all(loop_bound_1 == uint2(0u, 0u))) { break; }
        loop_bound_1 -= uint2(loop_bound_1.y == 0u, 1u);
        if (!loop_init_1) {
            uint _e26 = k;
            k = (_e26 + 1u);
        }
        loop_init_1 = false;
        uint _e13 = k;
        if ((_e13 < 9u)) {
        } else {
            break;
        }
        {
            uint _e20 = k;
            const uint2 _e22 = texel(((9u * id_1.x) + _e20), width_4);
            uint _e23 = k;
            coefficients_out[_e22] = _e7[min(uint(_e23), 8u)];
        }
    }
    return;
}

float4 everywhere(uint index : SV_VertexID) : SV_Position
{
    return float4(((float((index & 1u)) * 4.0) - 1.0), ((float((index >> 1u)) * 4.0) - 1.0), 0.0, 1.0);
}

float4 slopes_texel(FragmentInput_slopes_texel fragmentinput_slopes_texel) : SV_Target0
{
    float4 place = fragmentinput_slopes_texel.place_3;
    const uint _e1 = index_of(place);
    const Slope _e4 = slope_of(naga_div(_e1, 2u));
    return float4(((naga_mod(_e1, 2u) == 1u) ? _e4.up : _e4.right), 0.0);
}

float4 coefficients_texel(FragmentInput_coefficients_texel fragmentinput_coefficients_texel) : SV_Target0
{
    float4 place_1 = fragmentinput_coefficients_texel.place_4;
    const uint _e1 = index_of(place_1);
    const float4 _e4[9] = cubic_of(naga_div(_e1, 9u));
    return _e4[min(uint(naga_mod(_e1, 9u)), 8u)];
}
