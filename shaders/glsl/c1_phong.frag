// Phong with C1 normals, GLSL 4.5. Put "#version 450", patch.glsl and ordinates.glsl before it. Replace the lighting
// below with your material's: it may use the normal and the position in any way.

layout(location = 0) in vec3 view_position;
layout(location = 1) in vec3 view_normal;
layout(location = 2) noperspective in vec3 weights;
layout(location = 3) flat in int triangle;

// A vector toward a distant lamp, in view space.
layout(location = 2) uniform vec3 lamp;
// Linear light.
layout(location = 3) uniform vec3 ambient;
layout(location = 4) uniform vec3 diffuse;
layout(location = 5) uniform vec3 specular;
layout(location = 6) uniform float shininess;
layout(location = 7) uniform bool is_orthographic;

// Linear light; the target should have an sRGB format.
layout(location = 0) out vec4 color;

void main() {
    vec3 normal = view_normal, place = view_position;
    Patch p = patch_of(triangle);
    if (has_patch(p)) {
        vec4 shape = patch_value(p, weights);
        normal = shape.xyz;
        // The pixel's line of sight with a smooth depth. Only lamps that are near need this.
        place = is_orthographic ? vec3(place.xy, shape.w) : place * (shape.w / place.z);
    }
    normal = normalize(normal);
    vec3 to_eye = is_orthographic ? vec3(0.0, 0.0, 1.0) : normalize(-place), to_lamp = normalize(lamp);
    vec3 light = ambient;
    float cosine = dot(normal, to_lamp);
    if (cosine > 0.0) {
        float shine = max(2.0 * cosine * dot(normal, to_eye) - dot(to_lamp, to_eye), 0.0);
        light += diffuse * cosine + specular * pow(shine, shininess);
    }
    color = vec4(light, 1.0);
}
