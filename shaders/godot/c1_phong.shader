// Phong with C1 normals for Godot 3 (GLES3): it replaces the interpolated normal, and everything else of the material
// and of Godot's own lighting stays. Use it as the shader of a ShaderMaterial, and add albedo, roughness and textures to
// fragment() as usual. UV2 of each vertex holds its triangle and its corner (0, 1 or 2), so vertices must not be shared
// between triangles.
shader_type spatial;

// RGBAF without filtering, twelve texels for each triangle; the width is a multiple of 12. See shaders/README.md.
uniform sampler2D ordinates;

varying vec3 weights_times_w;
varying float triangle;

void vertex() {
	// The weights of the corners, linear on the screen; see glsl_es/ordinates.glsl.
	float w = (PROJECTION_MATRIX * MODELVIEW_MATRIX * vec4(VERTEX, 1.0)).w;
	weights_times_w = w * vec3(UV2.y == 0.0 ? 1.0 : 0.0, UV2.y == 1.0 ? 1.0 : 0.0, UV2.y == 2.0 ? 1.0 : 0.0);
	triangle = UV2.x;
}

vec4 ordinate(sampler2D of, int t, int k) {
	int at = 12 * t + k;
	int width = textureSize(of, 0).x;
	return texelFetch(of, ivec2(at % width, at / width), 0);
}

// The cubic of one third of the triangle; see glsl/patch.glsl.
vec4 third_value(vec4 b0, vec4 b1, vec4 b2, vec4 b3, vec4 near_i, vec4 middle, vec4 near_j, vec4 far_i, vec4 far_j, vec4 center, vec2 uv, float s) {
	vec4 edge = uv.x * uv.x * (uv.x * b0 + 3.0 * uv.y * b1) + uv.y * uv.y * (3.0 * uv.x * b2 + uv.y * b3);
	vec4 near = uv.x * uv.x * near_i + 2.0 * uv.x * uv.y * middle + uv.y * uv.y * near_j;
	return edge + s * (3.0 * near + s * (3.0 * (uv.x * far_i + uv.y * far_j) + s * center));
}

vec4 patch_value(sampler2D of, int t, vec3 w) {
	vec4 corner_a = ordinate(of, t, 0);
	vec4 corner_b = ordinate(of, t, 1);
	vec4 corner_c = ordinate(of, t, 2);
	vec4 next_a = ordinate(of, t, 3);
	vec4 next_b = ordinate(of, t, 4);
	vec4 next_c = ordinate(of, t, 5);
	vec4 previous_a = ordinate(of, t, 6);
	vec4 previous_b = ordinate(of, t, 7);
	vec4 previous_c = ordinate(of, t, 8);
	vec4 middle_a = ordinate(of, t, 9);
	vec4 middle_b = ordinate(of, t, 10);
	vec4 middle_c = ordinate(of, t, 11);
	vec4 near_a = (corner_a + next_a + previous_a) / 3.0;
	vec4 near_b = (corner_b + next_b + previous_b) / 3.0;
	vec4 near_c = (corner_c + next_c + previous_c) / 3.0;
	vec4 far_a = (near_a + middle_b + middle_c) / 3.0;
	vec4 far_b = (near_b + middle_c + middle_a) / 3.0;
	vec4 far_c = (near_c + middle_a + middle_b) / 3.0;
	vec4 center = (far_a + far_b + far_c) / 3.0;
	if (w.x <= w.y && w.x <= w.z) {
		return third_value(corner_b, next_b, previous_c, corner_c, near_b, middle_a, near_c, far_b, far_c, center, w.yz - w.x, 3.0 * w.x);
	}
	if (w.y <= w.z) {
		return third_value(corner_c, next_c, previous_a, corner_a, near_c, middle_b, near_a, far_c, far_a, center, w.zx - w.y, 3.0 * w.y);
	}
	return third_value(corner_a, next_a, previous_b, corner_b, near_a, middle_c, near_b, far_a, far_b, center, w.xy - w.z, 3.0 * w.z);
}

void fragment() {
	vec4 shape = patch_value(ordinates, int(triangle + 0.5), weights_times_w * FRAGCOORD.w);
	// A triangle that faces away or reaches behind the eye has no ordinates.
	if (shape != vec4(0.0)) {
		NORMAL = normalize(shape.xyz);
	}
	// Your material goes here.
}
