// The coefficients on the card, for meshes that move: two passes that render into textures. The first finds the slopes at
// each point, the second the coefficients of each triangle. They compute what coefficients() in ordinates.js does;
// coefficients.wgsl of the kit describes the textures.

import {
  BufferGeometry, DataTexture, Float32BufferAttribute, FloatType, GLSL3, Mesh, NearestFilter, NoBlending,
  OrthographicCamera, RawShaderMaterial, RGBAFormat, RGBAIntegerFormat, Scene, UnsignedIntType, Vector2,
  WebGLRenderTarget,
} from "three";
import * as glsl from "./glsl.js";

const pass = (fragmentShader) => new RawShaderMaterial({
  glslVersion: GLSL3,
  vertexShader: "in vec3 position; void main() { gl_Position = vec4(position, 1.0); }",
  fragmentShader,
  uniforms: Object.fromEntries(["camera", "points", "ring", "corners", "gradients"].map((name) => [name, { value: null }])),
  blending: NoBlending,
  depthTest: false,
  depthWrite: false,
});
const slopes = pass(glsl.slopes), coefficients = pass(glsl.coefficients);
// One triangle that covers the target.
const covering = new Float32BufferAttribute([-1, -1, 0, 3, -1, 0, -1, 3, 0], 3);
const screen = new Mesh(new BufferGeometry().setAttribute("position", covering));
screen.frustumCulled = false;
// The shaders need no camera, but three.js wants one whose projection it can reverse.
const scene = new Scene(), viewer = new OrthographicCamera();
scene.add(screen);
scene.matrixWorldAutoUpdate = viewer.matrixWorldAutoUpdate = false;

// The width and height of a texture for items of so many texels: nearly square, and a row has whole items.
export function extent(items, texels) {
  const perRow = Math.max(Math.ceil(Math.sqrt(items / texels)), 1);
  return [perRow * texels, Math.max(Math.ceil(items / perRow), 1)];
}

function table(items, texels, array, format, internalFormat) {
  const [width, height] = extent(items, texels), data = new array(4 * width * height);
  const texture = new DataTexture(data, width, height, format, array === Float32Array ? FloatType : UnsignedIntType);
  // Older versions of three.js do not find it.
  texture.internalFormat = internalFormat;
  texture.needsUpdate = true;
  return texture;
}

const target = (items, texels) => new WebGLRenderTarget(...extent(items, texels), {
  type: FloatType, minFilter: NearestFilter, magFilter: NearestFilter, depthBuffer: false,
});

// The two passes for one surface.
export class Passes {
  constructor({ positions, normals }, { vertices, tensors, triangles, sides, starts, ring }) {
    const count = vertices.length;
    this.triangles = triangles.length / 3;
    const points = table(count, 5, Float32Array, RGBAFormat, "RGBA32F");
    const around = table(triangles.length, 1, Uint32Array, RGBAIntegerFormat, "RGBA32UI");
    const corners = table(this.triangles, 3, Uint32Array, RGBAIntegerFormat, "RGBA32UI");
    for (let p = 0; p < count; p++) {
      const { data } = points.image, at = 20 * p, v = 3 * vertices[p];
      for (let i = 0; i < 3; i++) {
        data[at + i] = positions[v + i];
        data[at + 4 + i] = normals[v + i];
        for (let k = 0; k < 3; k++) data[at + 8 + 4 * k + i] = tensors[9 * p + 3 * k + i];
      }
      data[at + 3] = starts[p];
      data[at + 7] = starts[p + 1];
    }
    around.image.data.set(ring);
    for (let h = 0; h < triangles.length; h++) {
      const { data } = corners.image;
      data[4 * h] = triangles[h];
      data[4 * h + 1] = sides[2 * h];
      data[4 * h + 2] = sides[2 * h + 1];
    }
    this.slopes = target(count, 2);
    this.textures = { points, ring: around, corners };
    this.camera = { model_view: null, projection: null, size: new Vector2(), width: 0 };
  }

  // A target for the coefficients.
  target() {
    return target(this.triangles, 9);
  }

  // Renders the coefficients of a view, while `camera` renders a scene.
  render(renderer, camera, modelView, projection, aspect, into) {
    const before = [renderer.getRenderTarget(), renderer.getActiveCubeFace(), renderer.getActiveMipmapLevel()];
    const { autoClear, xr, info } = renderer, { enabled } = xr, { autoReset } = info;
    renderer.autoClear = xr.enabled = info.autoReset = false;
    Object.assign(this.camera, { model_view: modelView, projection });
    this.camera.size.set(aspect, 1);
    const draw = (material, textures, to) => {
      this.camera.width = to.width;
      material.uniforms.camera.value = this.camera;
      for (const name of Object.keys(textures)) material.uniforms[name].value = textures[name];
      screen.material = material;
      renderer.setRenderTarget(to);
      renderer.render(scene, viewer);
    };
    draw(slopes, this.textures, this.slopes);
    draw(coefficients, { ...this.textures, gradients: this.slopes.texture }, into);
    [renderer.autoClear, xr.enabled, info.autoReset] = [autoClear, enabled, autoReset];
    renderer.setRenderTarget(...before);
    // As three.js's own Reflector does.
    if (camera.viewport) renderer.state.viewport(camera.viewport);
  }

  dispose() {
    for (const held of [...Object.values(this.textures), this.slopes]) held.dispose();
  }
}
