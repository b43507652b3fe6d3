// Phong with C1 normals for Godot 3 (GLES3): it replaces the interpolated normal, and everything else of the material
// and of Godot's own lighting stays. Use it as the shader of a ShaderMaterial, and add albedo, roughness and textures to
// fragment() as usual. UV2 of each vertex holds its triangle and its corner (0, 1 or 2), so vertices must not be shared
// between triangles.
shader_type spatial;

// RGBAF without filtering, nine texels for each triangle; the width is a multiple of nine. See shaders/README.md.
uniform sampler2D coefficients;

// x and y of the cubic, times w of the projection: see shaders/three/index.js.
varying vec2 weights_times_w;
varying float triangle;

void vertex() {
	float w = (PROJECTION_MATRIX * MODELVIEW_MATRIX * vec4(VERTEX, 1.0)).w;
	weights_times_w = w * ((UV2.y == 0.0) ? vec2(1.0, 0.0) : ((UV2.y == 1.0) ? vec2(0.0, 1.0) : vec2(-1.0, -1.0)));
	triangle = UV2.x;
}

vec3 cubic(sampler2D of, int t, vec2 w) {
	int width = textureSize(of, 0).x;
	ivec2 at = ivec2(9 * t % width, 9 * t / width);
	vec4 c0 = texelFetch(of, at, 0);
	vec4 c1 = texelFetch(of, at + ivec2(1, 0), 0);
	vec4 c2 = texelFetch(of, at + ivec2(2, 0), 0);
	vec4 c3 = texelFetch(of, at + ivec2(3, 0), 0);
	vec4 c4 = texelFetch(of, at + ivec2(4, 0), 0);
	vec4 c5 = texelFetch(of, at + ivec2(5, 0), 0);
	vec4 c6 = texelFetch(of, at + ivec2(6, 0), 0);
	vec4 c7 = texelFetch(of, at + ivec2(7, 0), 0);
	vec4 c8 = texelFetch(of, at + ivec2(8, 0), 0);
	// A triangle that faces away or reaches behind the eye.
	if (c0.xyz == vec3(0.0)) {
		return vec3(0.0);
	}
	float x = w.x;
	float y = w.y;
	float xx = (x < 0.0 && x <= y) ? x * x : 0.0;
	float yy = (y < 0.0 && y < x) ? y * y : 0.0;
	return c0.xyz + x * (vec3(c0.w, c1.xy) + x * (c2.yzw + x * vec3(c4.zw, c5.x)))
		+ y * (vec3(c1.zw, c2.x) + x * (c3.xyz + x * c5.yzw) + y * (vec3(c3.w, c4.xy) + x * c6.xyz + y * vec3(c6.w, c7.xy)))
		+ (yy * (y - 2.0 * x) - xx * y) * vec3(c7.zw, c8.x) + (xx * (x - 2.0 * y) - yy * x) * c8.yzw;
}

void fragment() {
	vec3 normal = cubic(coefficients, int(triangle + 0.5), weights_times_w * FRAGCOORD.w);
	if (normal != vec3(0.0)) {
		NORMAL = normalize(normal);
	}
	// Your material goes here.
}
