#!/usr/bin/env python3
"""The cost of c1_phong and patch over Phong, with the files in shaders/glsl on Mesa's llvmpipe.

A torus that fills the window, with the same lighting, in one program whose draws alternate; nothing is read back while it
is timed. Phong is drawn with and without an index buffer; the kit's shaders cannot use one. The coefficients are
computed by the two compute passes, and are timed as well. Prints a Markdown table of medians over Phong without an index
buffer. Needs Node.js for the surface (shaders/ordinates.js).

    pip install moderngl numpy        # and Mesa's EGL: libegl1 libgl1-mesa-dri on Debian
    python3 benches/kit_llvmpipe.py [rounds]
    python3 benches/kit_llvmpipe.py --check PATH   # compares the picture with that of the program machband; pip install pillow
"""
import json
import os
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile
import time

os.environ.setdefault("LP_NUM_THREADS", "2")
os.environ.setdefault("LIBGL_ALWAYS_SOFTWARE", "1")
os.environ.setdefault("GALLIUM_DRIVER", "llvmpipe")

import moderngl
import numpy as np

SHADERS = pathlib.Path(__file__).parent.parent / "shaders"
ROW = 64


def torus(around, along):
    u, v = np.meshgrid(np.arange(around) / around * 2 * np.pi, np.arange(along) / along * 2 * np.pi, indexing="ij")
    normal = np.stack([np.cos(u) * np.cos(v), np.sin(u) * np.cos(v), np.sin(v)], -1)
    place = np.stack([np.cos(u), np.sin(u), 0 * u], -1) + 0.4 * normal
    i, j = np.meshgrid(np.arange(around), np.arange(along), indexing="ij")
    at = lambda a, b: (i + a) % around * along + (j + b) % along
    faces = np.stack([at(0, 0), at(1, 0), at(1, 1), at(0, 0), at(1, 1), at(0, 1)], -1)
    return place.reshape(-1, 3), normal.reshape(-1, 3), faces.reshape(-1, 3)


def surface(place, normal, faces):
    code = """
      const { curvature } = await import(process.argv[1]);
      const [positions, normals, t] = JSON.parse(await new Response(process.stdin).text());
      const s = curvature({ positions, normals, triangles: Uint32Array.from(t) });
      console.log(JSON.stringify(Object.fromEntries(Object.entries(s).map(([k, v]) => [k, Array.from(v)]))));"""
    path = str((SHADERS / "ordinates.js").resolve())
    given = json.dumps([x.ravel().tolist() for x in (place, normal, faces)])
    done = subprocess.run(["node", "--input-type=module", "-e", code, path], input=given, capture_output=True, text=True, check=True)
    return {key: np.array(value) for key, value in json.loads(done.stdout).items()}


def glsl(name):
    return (SHADERS / "glsl" / name).read_text()


def phong():
    """The same lighting without the cubic."""
    fragment = glsl("c1_phong_pixel.frag")
    block = re.search(r"struct Scene \{.*?\};", fragment, re.S)[0]
    uniform = re.search(r"layout\(std140.*?;", fragment)[0]
    lit = re.search(r"vec3 lit\(.*?\n\}\n", fragment, re.S)[0]
    head = f"#version 450\n{block}\nlayout(std140, binding = 0) uniform Scene_block {{ Scene scene; }};\n"
    vertex = head + """
      layout(location = 0) in vec3 at; layout(location = 1) in vec3 direction;
      layout(location = 0) out vec3 place; layout(location = 1) out vec3 normal;
      void main() {
        vec4 p = scene.model_view * vec4(at, 1.0);
        place = p.xyz; normal = mat3(scene.model_view) * direction; gl_Position = scene.projection * p;
      }"""
    return vertex, head + lit + """
      layout(location = 0) in vec3 place; layout(location = 1) in vec3 normal; layout(location = 0) out vec4 color;
      void main() { color = vec4(lit(normal, place), 1.0); }"""


class Scene:
    def __init__(self, gl, mesh, view, projection):
        self.gl = gl
        place, normal, faces = mesh
        self.count = len(faces)
        s = surface(place, normal, faces)
        points = len(s["vertices"])
        table = np.zeros((points, 5, 4), "f4")
        table[:, 0, :3], table[:, 1, :3] = place[s["vertices"]], normal[s["vertices"]]
        table[:, 0, 3], table[:, 1, 3] = s["starts"][:-1], s["starts"][1:]
        table[:, 2:, :3] = s["tensors"].reshape(-1, 3, 3)
        corners = np.zeros((self.count, 3, 4), "u4")
        corners[..., 0], corners[..., 1:3] = s["triangles"].reshape(-1, 3), s["sides"].reshape(-1, 3, 2)
        self.points = self.texture(table, 5)
        self.ring = self.texture(s["ring"].reshape(-1, 1, 4).astype("u4"), 1)
        self.corners = self.texture(corners, 3)
        self.gradients, self.coefficients = self.texture(np.zeros((points, 2, 4), "f4"), 2), self.texture(np.zeros((self.count, 9, 4), "f4"), 9)
        # The whole number after the ambient light is nonzero for a parallel projection.
        parallel = np.array([projection[3, 3]], "u4").view("f4")[0]
        lights = np.array([[.36, .48, .8, 20], [.1, .1, .1, parallel], [.6, .6, .6, 0], [.3, .3, .3, 0]], "f4")
        self.uniform = gl.buffer(np.concatenate([view.ravel(), projection.ravel(), lights.ravel()]).tobytes())
        sizes = np.array([1024, 1024], "f4").tobytes() + np.array([points, self.count, 0, 0, 0, 0], "u4").tobytes()
        self.camera = gl.buffer(view.tobytes() + projection.tobytes() + sizes)
        self.passes = [(gl.compute_shader(glsl(f"{name}.comp")), n) for name, n in [("slopes", points), ("coefficients", self.count)]]
        both = np.concatenate([place, normal], 1).astype("f4")
        shared, split = gl.buffer(both.tobytes()), gl.buffer(both[faces.ravel()].tobytes())
        index = gl.buffer(faces.astype("u4").tobytes())
        array = lambda files, what, names, index=None: gl.vertex_array(gl.program(vertex_shader=files[0], fragment_shader=files[1]), [(what, *names)], index)
        both_of, place_of = ("3f 3f", "_p2vs_location0", "_p2vs_location1"), ("3f 12x", "_p2vs_location0")
        self.arrays = {
            "phong": array(phong(), split, ("3f 3f", "at", "direction")),
            "phong, index buffer": array(phong(), shared, ("3f 3f", "at", "direction"), index),
            "c1_phong": array([glsl("c1_vertex.vert"), glsl("c1_phong_pixel.frag")], split, both_of),
            "patch": array([glsl("patch_vertex.vert"), glsl("patch_pixel.frag")], split, place_of),
            "patch, color": array([glsl("c1_vertex.vert"), glsl("patch_color_pixel.frag")], split, place_of),
        }

    def texture(self, table, texels):
        kind = {"f": "f4", "u": "u4"}[table.dtype.kind]
        rows = -(-len(table) // ROW)
        full = np.zeros((rows * ROW, texels, table.shape[-1]), kind)
        full[: len(table)] = table
        made = self.gl.texture((ROW * texels, rows), table.shape[-1], full.tobytes(), dtype=kind)
        made.filter = (moderngl.NEAREST, moderngl.NEAREST)
        return made

    def compute(self):
        self.camera.bind_to_uniform_block(0)
        for binding, texture in enumerate([self.points, self.ring, self.corners, self.gradients], 1):
            texture.use(binding)
        self.gradients.bind_to_image(5, read=False, write=True)
        self.coefficients.bind_to_image(6, read=False, write=True)
        for program, count in self.passes:
            program.run(-(-count // 64))
            self.gl.memory_barrier()

    def draw(self, name):
        self.uniform.bind_to_uniform_block(0)
        self.coefficients.use(1)
        self.arrays[name].render()


def camera(fill, distance):
    """The camera of `machband shade --rotate 25,-35,0`, for a mesh around the origin within 1.4; matrices as rows of columns."""
    x, y = np.radians([25, -35])
    about_x = np.array([[1, 0, 0], [0, np.cos(x), -np.sin(x)], [0, np.sin(x), np.cos(x)]])
    about_y = np.array([[np.cos(y), 0, np.sin(y)], [0, 1, 0], [-np.sin(y), 0, np.cos(y)]])
    view, projection = np.eye(4, dtype="f4"), np.zeros((4, 4), "f4")
    view[:3, :3] = (about_y @ about_x).T / 1.4
    if distance is None:
        projection[0, 0] = projection[1, 1] = fill
        projection[2, 2], projection[3, 3] = -0.5, 1
        return view, projection
    view[3, 2] = -distance
    projection[0, 0] = projection[1, 1] = fill * np.sqrt(distance**2 - 1)
    near, far = distance - 1, distance + 1
    projection[2, 2], projection[2, 3], projection[3, 2] = -(far + near) / (far - near), -1, -2 * far * near / (far - near)
    return view, projection


def check(program):
    from PIL import Image

    gl, size = context(), 512
    mesh = torus(28, 28)
    with tempfile.TemporaryDirectory() as folder:
        obj, png = f"{folder}/torus.obj", f"{folder}/picture.png"
        rows = lambda word, table, format: "".join(f"{word} " + " ".join(format(x) for x in row) + "\n" for row in table)
        pathlib.Path(obj).write_text(rows("v", mesh[0], str) + rows("vn", mesh[1], str) + rows("f", mesh[2] + 1, lambda i: f"{i}//{i}"))
        for distance in None, 3:
            scene = Scene(gl, mesh, *camera(0.9, distance))
            target = gl.framebuffer([gl.renderbuffer((size, size))], gl.depth_renderbuffer((size, size)))
            scene.compute()
            target.use()
            target.clear()
            scene.draw("c1_phong")
            own = np.frombuffer(target.read(components=3), "u1").reshape(size, size, 3)[::-1].astype(int)
            options = ["--specular", "0.3", "--background", "0", "--transfer", "linear", "--dither", "none", "--size", str(size)]
            far = [] if distance is None else ["--distance", str(distance)]
            subprocess.run([program, "shade", "--mesh", obj, "--shader", "c1-phong", *options, *far, "--out", png, "--force"], check=True)
            theirs = np.asarray(Image.open(png).convert("RGB")).astype(int)
            # Inside the outline: neither the pixel nor its neighbors are background.
            inside = np.ones((size, size), bool)
            for dx in -2, 0, 2:
                for dy in -2, 0, 2:
                    inside &= (np.roll(own, (dx, dy), (0, 1)).max(-1) > 0) & (np.roll(theirs, (dx, dy), (0, 1)).max(-1) > 0)
            # At inner outlines, one surface hides another.
            steep = np.abs(np.diff(theirs[..., 0], axis=0, prepend=0)) + np.abs(np.diff(theirs[..., 0], axis=1, prepend=0)) > 24
            for _ in range(2):
                steep = steep | np.roll(steep, 1, 0) | np.roll(steep, -1, 0) | np.roll(steep, 1, 1) | np.roll(steep, -1, 1)
            apart = np.abs(own - theirs).max(-1)[inside & ~steep]
            print(f"{gl.info['GL_RENDERER']}, GLSL 4.5, distance {distance}: at most {apart.max()} codes apart over {apart.size:,} pixels")
            if apart.size < 50_000 or apart.max() > 1:
                sys.exit("expected at most 1 code over at least 50,000 pixels")


def context():
    gl = moderngl.create_standalone_context(require=450, backend="egl")
    gl.enable(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
    return gl


def main():
    if sys.argv[1:2] == ["--check"]:
        return check(sys.argv[2])
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 15
    gl = context()
    print(gl.info["GL_RENDERER"])
    print("| triangles, window | " + " | ".join(["phong, index buffer", "c1_phong", "patch", "patch, color"]) + " | phong | coefficients |")
    print("|---|" + "---:|" * 6)
    for (around, along), size in [((28, 28), 1024), ((70, 70), 1024), ((70, 70), 512), ((224, 224), 1024)]:
        scene = Scene(gl, torus(around, along), *camera(0.95, 3))
        target = gl.framebuffer([gl.renderbuffer((size, size))], gl.depth_renderbuffer((size, size)))
        times = {name: [] for name in [*scene.arrays, "coefficients"]}
        scene.compute()
        for _ in range(rounds):
            for name, list_ in times.items():
                target.use()
                gl.finish()
                start = time.perf_counter()
                for _ in range(5):
                    if name == "coefficients":
                        scene.compute()
                    else:
                        target.clear()
                        scene.draw(name)
                    gl.finish()
                list_.append((time.perf_counter() - start) / 5)
        medians = {name: statistics.median(list_) for name, list_ in times.items()}
        ratios = [f"{medians[name] / medians['phong']:.2f}" for name in list(scene.arrays)[1:]]
        print(f"| {scene.count:,}, {size} × {size} | " + " | ".join(ratios) + f" | {medians['phong'] * 1e3:.1f} ms | {medians['coefficients'] * 1e3:.1f} ms |")


if __name__ == "__main__":
    main()
