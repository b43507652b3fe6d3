// Phong with C1 normals, GLSL ES 3.00. Put it after patch.glsl and ordinates.glsl. Replace the lighting below with your
// material's: it may use the normal and the position in any way.

in vec3 view_position;
in vec3 view_normal;

// A vector toward a distant lamp, in view space.
uniform vec3 lamp;
// Linear light.
uniform vec3 ambient;
uniform vec3 diffuse;
uniform vec3 specular;
uniform float shininess;
uniform bool is_orthographic;

out vec4 color;

// Linear light to sRGB; not needed if the target has an sRGB format.
vec3 encoded(vec3 light) {
    vec3 l = clamp(light, 0.0, 1.0);
    return mix(1.055 * pow(l, vec3(1.0 / 2.4)) - 0.055, 12.92 * l, lessThanEqual(l, vec3(0.0031308)));
}

void main() {
    vec3 normal = view_normal, place = view_position;
    Patch p = patch_here();
    if (has_patch(p)) {
        vec4 shape = patch_value(p, corner_weights());
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
    color = vec4(encoded(light), 1.0);
}
