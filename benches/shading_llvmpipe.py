#!/usr/bin/env python3
"""The comparison for shading.rs: Mesa's llvmpipe, a rasterizer on the CPU, draws the same kind of image.

1024 x 1024 pixels RGBA8, 28 x 28 x 2 jittered triangles over the whole window, two threads, no depth buffer, vertices
already in graphics memory. Prints medians in Mpix/s. Nothing is read back. GLSL uses 32-bit floats and writes codes
without a transfer function, so it does not include the conversion to sRGB that shading.rs includes.

    pip install moderngl numpy        # and Mesa's EGL: libegl1 libgl1-mesa-dri on Debian
    python3 benches/shading_llvmpipe.py [threads]
"""
import os
import statistics
import sys
import time

os.environ.setdefault("LP_NUM_THREADS", sys.argv[1] if len(sys.argv) > 1 else "2")
os.environ.setdefault("LIBGL_ALWAYS_SOFTWARE", "1")
os.environ.setdefault("GALLIUM_DRIVER", "llvmpipe")

import moderngl
import numpy as np

SIZE, CELLS = 1024, 28

VERTEX = """
#version 330
in vec2 place; in vec3 normal; in vec3 light; in vec3 weights; in vec3 c0; in vec3 c1; in vec3 c2;
out vec3 v_normal; out vec3 v_light; out vec3 v_weights; flat out vec3 v_flat; flat out vec3 v_c[3];
void main() {
    gl_Position = vec4(place, 0.0, 1.0);
    v_normal = normal; v_light = light; v_weights = weights; v_flat = light;
    v_c[0] = c0; v_c[1] = c1; v_c[2] = c2;
}
"""

HEAD = """
#version 330
in vec3 v_normal; in vec3 v_light; in vec3 v_weights; flat in vec3 v_flat; flat in vec3 v_c[3];
out vec4 pixel;
const vec3 L = vec3(0.36, 0.48, 0.8), COLOR = vec3(0.9, 0.6, 0.3);
"""

FRAGMENTS = {
    "flat": "void main() { pixel = vec4(v_flat, 1.0); }",
    "gouraud": "void main() { pixel = vec4(v_light, 1.0); }",
    "phong diffuse": """void main() {
        pixel = vec4(COLOR * (0.1 + 0.6 * max(dot(normalize(v_normal), L), 0.0)), 1.0);
    }""",
    "phong specular": """void main() {
        vec3 n = normalize(v_normal);
        float c = dot(n, L);
        vec3 light = 0.1 * COLOR;
        if (c > 0.0) light += 0.6 * c * COLOR + 0.3 * pow(max((2.0 * c * n - L).z, 0.0), 20.0);
        pixel = vec4(light, 1.0);
    }""",
    "exact n=3 b=0.05": """
    const float B = 0.05;
    float ease(float x) { x = min(x, 2.0); return x - 0.25 * x * x; }
    float bump(float w, float wi, float wj) {
        if (w >= B) return 0.0;
        float width = B * ease((1.0 - wi) / (2.0 * B)) * ease((1.0 - wj) / (2.0 * B));
        float u = min(w / max(width, 1e-30), 1.0);
        return w * (1.0 - u * u * u * (10.0 - u * (15.0 - 6.0 * u)));
    }
    void main() {
        vec3 w = v_weights;
        pixel = vec4(v_light + bump(w.x, w.y, w.z) * v_c[0] + bump(w.y, w.z, w.x) * v_c[1]
            + bump(w.z, w.x, w.y) * v_c[2], 1.0);
    }""",
}


def grid():
    """Positions, normals and light values at the corners of every triangle, and the constants of their edges."""
    random = np.random.default_rng(1)
    n = CELLS + 1
    y, x = np.mgrid[0:n, 0:n].astype(float)
    inner = ((x > 0) & (x < CELLS) & (y > 0) & (y < CELLS))[..., None]
    place = np.stack([x, y], -1) + inner * random.uniform(-0.25, 0.25, (n, n, 2))
    place = (place / CELLS * 2 - 1).reshape(-1, 2)
    normal = np.stack([0.5 * np.sin(4 * place[:, 0]), 0.5 * np.sin(3 * place[:, 1] + place[:, 0]), np.ones(n * n)], -1)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    shade = 0.1 + 0.6 * np.clip(normal @ [0.36, 0.48, 0.8], 0, 1)
    light = shade[:, None] * [0.9, 0.6, 0.3]
    a = (np.arange(CELLS)[:, None] * n + np.arange(CELLS)).ravel()
    triangles = np.concatenate([np.stack([a, a + 1, a + n + 1], -1), np.stack([a, a + n + 1, a + n], -1)])
    corners = triangles.ravel()
    # The values of the constants do not affect the time.
    bend = random.uniform(-0.02, 0.02, (len(triangles), 9)).repeat(3, 0)
    weights = np.tile(np.eye(3), (len(triangles), 1))
    rows = np.concatenate([place[corners], normal[corners], light[corners], weights, bend], 1)
    return rows.astype("f4"), len(triangles)


def main():
    context = moderngl.create_context(standalone=True, backend="egl")
    print(context.info["GL_RENDERER"], "·", os.environ["LP_NUM_THREADS"], "threads")
    rows, triangles = grid()
    buffer = context.buffer(rows.tobytes())
    target = context.framebuffer([context.renderbuffer((SIZE, SIZE), 4)])
    target.use()
    names = ["place", "normal", "light", "weights", "c0", "c1", "c2"]
    for name, fragment in FRAGMENTS.items():
        program = context.program(vertex_shader=VERTEX, fragment_shader=HEAD + fragment)
        used = [n for n in names if n in program]
        layout = " ".join((f"{2 if n == 'place' else 3}f" if n in used else f"{8 if n == 'place' else 12}x") for n in names)
        array = context.vertex_array(program, [(buffer, layout, *used)])
        times = []
        for _ in range(220):
            start = time.perf_counter()
            array.render(moderngl.TRIANGLES)
            context.finish()
            times.append(time.perf_counter() - start)
        times = times[20:]
        median, best = (SIZE * SIZE / t / 1e6 for t in (statistics.median(times), min(times)))
        print(f"{name:18} {median:7.0f} Mpix/s median, {best:7.0f} best, {triangles} triangles")


if __name__ == "__main__":
    main()
