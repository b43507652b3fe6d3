// Phong with C1 normals: the vertex shader, which patch.hlsl uses too, and the pixel shader. Replace the lighting below
// with your material's: it may use the normal and the position in any way.
#include "patch.hlsl"

cbuffer Scene : register(b0) {
    float4x4 model_view;
    float4x4 projection;
    // A vector toward a distant lamp, in view space.
    float3 lamp;
    float shininess;
    // Linear light.
    float3 ambient;
    bool is_orthographic;
    float3 diffuse;
    float3 specular;
};

// Draw un-indexed vertices: the three vertices of triangle t are 3t, 3t + 1 and 3t + 2, because each must know its
// triangle and its corner.
Pixel triangle_vertex(float3 position : POSITION, float3 normal : NORMAL, uint vertex : SV_VertexID) {
    float4 place = mul(model_view, float4(position, 1.0));
    Pixel output;
    output.position = mul(projection, place);
    output.view_position = place.xyz;
    output.view_normal = mul((float3x3)model_view, normal);
    uint corner = vertex % 3;
    output.weights = float3(corner == 0 ? 1.0 : 0.0, corner == 1 ? 1.0 : 0.0, corner == 2 ? 1.0 : 0.0);
    output.which = vertex / 3;
    return output;
}

// Returns linear light; the target should have an sRGB format.
float4 c1_phong_pixel(Pixel input) : SV_Target {
    float3 normal = input.view_normal, place = input.view_position;
    if (has_patch(input.which)) {
        float4 shape = patch_value(input.which, input.weights);
        normal = shape.xyz;
        // The pixel's line of sight with a smooth depth. Only lamps that are near need this.
        place = is_orthographic ? float3(place.xy, shape.w) : place * (shape.w / place.z);
    }
    normal = normalize(normal);
    float3 to_eye = is_orthographic ? float3(0.0, 0.0, 1.0) : normalize(-place), to_lamp = normalize(lamp);
    float3 light = ambient;
    float cosine = dot(normal, to_lamp);
    if (cosine > 0.0) {
        float shine = max(2.0 * cosine * dot(normal, to_eye) - dot(to_lamp, to_eye), 0.0);
        light += diffuse * cosine + specular * pow(shine, shininess);
    }
    return float4(light, 1.0);
}
