// C1 normals for three.js: Phong shading without the lines at the edges of the mesh. One line does it:
//
//   import { applyC1 } from "machband-c1";
//   applyC1(gltf.scene);

import {
  BufferGeometry, DataTexture, Float32BufferAttribute, FloatType, GLSL3, Mesh, NearestFilter, NoBlending,
  OrthographicCamera, RawShaderMaterial, RGBAFormat, RGBAIntegerFormat, Scene, UnsignedIntType, Vector2, Vector3, Vector4,
  WebGLRenderTarget,
} from "three";
import { bulges, coefficients, curvature, welded } from "./ordinates.js";
import * as glsl from "./glsl.js";

// Smaller meshes are faster in JavaScript than as two passes on the card.
const FEW = 500;
// Materials whose shaders have no normals.
const UNLIT = ["isMeshBasicMaterial", "isMeshDepthMaterial", "isMeshDistanceMaterial", "isShadowMaterial"];
// Where C1 normals belong in a shader.
const PARS = "#include <normal_pars_fragment>";
// Cameras whose coefficients a mesh keeps.
const CAMERAS = 8;

// What was made of each geometry, each mesh, and the material behind each patched one.
const made = new WeakMap(), applied = new WeakMap(), sources = new WeakMap();

// Without coefficients, normals are interpolated.
const none = new DataTexture(new Float32Array(36), 9, 1, RGBAFormat, FloatType);
none.needsUpdate = true;

const declared = `
uniform highp sampler2D c1_coefficients;
ivec2 c1_place(int triangle) {
  int at = 9 * triangle, width = textureSize(c1_coefficients, 0).x;
  return ivec2(at % width, at / width);
}`;

// Nine flat vectors where there are enough varyings, so that a pixel reads nothing; phones often have fifteen.
const vertexHead = `${declared}
out vec3 c1_weights;
#ifdef C1_STILL
  out mat3 c1_axes;
#endif
#ifdef C1_FLAT
  flat out vec4 c1[9];
#else
  flat out int c1_triangle;
#endif
`;
// The weights of the corners, linear on the screen: GLSL ES has no noperspective. A varying v is interpolated as Σ b v / w
// divided by Σ b / w, where b are the weights on the screen. With v = e w, it is proportional to Σ b e, and the cubic
// divides by the sum. This also holds for a triangle that the near plane clips.
const vertexTail = `
  int c1_corner = gl_VertexID % 3;
  c1_weights = vec3(c1_corner == 0, c1_corner == 1, c1_corner == 2);
#ifdef C1_STILL
  // From the mesh's own axes to those of vNormal, which has unit length.
  c1_axes = normalMatrix;
  #ifdef USE_INSTANCING
    mat3 c1_turn = mat3(instanceMatrix);
    for (int i = 0; i < 3; i++) c1_turn[i] /= dot(c1_turn[i], c1_turn[i]);
    c1_axes *= c1_turn;
  #endif
  #ifdef USE_SKINNING
    c1_axes *= mat3(skinMatrix);
  #endif
  c1_axes /= length(c1_axes * normalize(normal));
  #ifdef FLIP_SIDED
    c1_axes = -c1_axes;
  #endif
#else
  c1_weights *= gl_Position.w;
#endif
#ifdef C1_FLAT
  // The last corner of a triangle gives the flat vectors.
  ivec2 c1_from = c1_place(gl_VertexID / 3);
  for (int k = 0; k < 9; k++) c1[k] = c1_corner == 2 ? texelFetch(c1_coefficients, c1_from + ivec2(k, 0), 0) : vec4(0.0);
#else
  c1_triangle = gl_VertexID / 3;
#endif
}`;
const fragmentHead = `
#ifndef FLAT_SHADED
${glsl.cubic.replace(/\b(terms_of|cubic_value)\b/g, "c1_$1")}
in vec3 c1_weights;
#ifdef C1_STILL
  in mat3 c1_axes;
#endif
#ifdef C1_FLAT
  flat in vec4 c1[9];
#else
  ${declared}
  flat in int c1_triangle;
#endif
vec3 c1_normal() {
#ifndef C1_FLAT
  vec4 c1[9];
  ivec2 from = c1_place(c1_triangle);
  for (int k = 0; k < 9; k++) c1[k] = texelFetch(c1_coefficients, from + ivec2(k, 0), 0);
#endif
  vec3 value = c1_cubic_value(c1[0], c1[1], c1[2], c1[3], c1[4], c1[5], c1[6], c1[7], c1[8], c1_terms_of(c1_weights));
#ifdef C1_STILL
  return vNormal + c1_axes * value;
#else
  // A triangle that faces away or reaches behind the eye has zeros.
  return c1[0].xyz == vec3(0.0) ? vNormal : value;
#endif
}
#define vNormal c1_normal()
#endif
`;

// Gives every mesh under `root` C1 normals. Materials, textures, lights and everything else stay. Meshes that move in the
// vertex shader get an approximation that does not depend on the view; those that can have neither, or whose materials use
// no interpolated normals, stay as they are. The console names them. Returns { meshes, approximate, skipped, dispose }.
export function applyC1(root, { gpu } = {}) {
  if (!root?.isObject3D) throw new TypeError("applyC1: root is not an Object3D; expected one, such as gltf.scene");
  const meshes = [], approximate = [], skipped = [];
  root.traverse((mesh) => {
    if (!mesh.isMesh || applied.has(mesh)) return;
    const reason = unfit(mesh), moves = moving(mesh);
    if (reason) {
      skipped.push({ mesh, reason });
      tell("warn", mesh, `${reason}; it stays as it is`);
      return;
    }
    if (moves) {
      approximate.push({ mesh, reason: moves });
      tell("info", mesh, `${moves}; its normals are continuous, but their slopes only nearly so`);
    }
    patch(mesh, moves ? new Still(mesh) : new Views(mesh, gpu));
    meshes.push(mesh);
  });
  return { meshes, approximate, skipped, dispose: () => meshes.splice(0).forEach((mesh) => applied.get(mesh)?.()) };
}

const tell = (how, mesh, text) => console[how](`machband-c1: ${mesh.name ? `mesh "${mesh.name}"` : mesh.type}: ${text}`);

function unfit(mesh) {
  const { attributes } = mesh.geometry;
  if (!attributes.position || !attributes.normal) return "the mesh has no normals";
  const bad = ["position", "normal"].find((name) => numbers(attributes[name]).some((x) => !Number.isFinite(x)));
  if (bad) return `a ${bad} is not finite`;
  const { count } = attributes.position, { index } = mesh.geometry;
  if (attributes.normal.count !== count) return "the mesh does not have a normal for each position";
  if (index?.array.some((i) => i >= count)) return "an index is not that of a position";
  if (mesh.isBatchedMesh) return "the mesh is a batch";
  const materials = [mesh.material].flat();
  if (!materials.length || !materials.every(Boolean)) return "it lacks a material";
  if (materials.some((one) => one.displacementMap)) return "a displacement map moves the surface";
  if (materials.every((one) => one.flatShading)) return "it is flat-shaded";
  // Such materials neither light nor show normals; shaders of one's own may.
  if (materials.every((one) => UNLIT.some((kind) => one[kind]))) return "its material uses no normals";
  const lacks = (one) => one.isShaderMaterial && !one.fragmentShader.includes(PARS);
  if (materials.every(lacks)) return `its shader does not have ${PARS}, where C1 normals belong`;
  return undefined;
}

function moving(mesh) {
  const { morphAttributes } = mesh.geometry;
  if (mesh.isSkinnedMesh) return "the mesh is skinned";
  if (mesh.isInstancedMesh) return "the mesh is drawn in many places at once";
  return morphAttributes.position || morphAttributes.normal ? "the mesh has morph targets" : undefined;
}

// A geometry without shared vertices, because each must know its triangle and its corner, and its surface.
function prepared(geometry) {
  const known = made.get(geometry);
  if (known && !isChanged(known)) return known;
  const { position, normal } = geometry.attributes, own = geometry.index ? geometry.toNonIndexed() : geometry;
  if (own !== geometry) {
    own.name = geometry.name;
    own.userData = geometry.userData;
    own.drawRange = geometry.drawRange;
  }
  const whole = welded(numbers(position), numbers(normal), geometry.index?.array);
  const result = { geometry: own, source: geometry, whole, points: curvature(whole) };
  result.changes = changes(result);
  made.set(geometry, result);
  made.set(own, result);
  return result;
}

// How often the positions and normals of a geometry, and of what it was made from, were changed.
function changes({ geometry, source }) {
  const attributes = [geometry, source].flatMap(({ attributes: { position, normal } }) => [position, normal]);
  return attributes.reduce((sum, attribute) => sum + (attribute.data ?? attribute).version, 0);
}

const isChanged = (shape) => changes(shape) !== shape.changes;

function numbers(attribute) {
  if (attribute.array instanceof Float32Array && !attribute.isInterleavedBufferAttribute) return attribute.array;
  const result = new Float32Array(3 * attribute.count);
  for (let i = 0; i < result.length; i++) result[i] = attribute.getComponent(Math.floor(i / 3), i % 3);
  return result;
}

function patch(mesh, normals) {
  const { geometry, material } = mesh, { shape } = normals;
  const own = [material].flat().map((one) => patched(sources.get(one) ?? one, normals));
  mesh.geometry = shape.geometry;
  mesh.material = Array.isArray(material) ? own : own[0];
  const [ownGeometry, ownMaterial] = [mesh.geometry, mesh.material];
  applied.set(mesh, () => {
    if (mesh.geometry === ownGeometry) mesh.geometry = geometry;
    if (mesh.material === ownMaterial) mesh.material = material;
    normals.dispose();
    shape.passes?.dispose();
    if (ownGeometry !== geometry) ownGeometry.dispose();
    for (const one of own) one.dispose();
    made.delete(geometry);
    applied.delete(mesh);
  });
}

// A copy of a material that uses C1 normals; the coefficients belong to one mesh, and so does the copy.
function patched(source, normals) {
  const own = source.clone();
  // The uniforms of a ShaderMaterial stay shared with the source.
  if (source.isShaderMaterial) own.uniforms = { ...source.uniforms };
  sources.set(own, source);
  own.onBeforeCompile = (shader, renderer) => {
    source.onBeforeCompile(shader, renderer);
    if (!shader.fragmentShader.includes(PARS)) return;
    const isFlat = renderer.capabilities.maxVaryings >= 24;
    const defined = `${isFlat ? "#define C1_FLAT\n" : ""}${normals.isStill ? "#define C1_STILL\n" : ""}`;
    shader.uniforms.c1_coefficients = normals.uniform;
    shader.vertexShader = defined + vertexHead + shader.vertexShader.replace(/\}\s*$/, vertexTail);
    shader.fragmentShader = defined + shader.fragmentShader.replace(PARS, `${PARS}\n${fragmentHead}`);
  };
  own.customProgramCacheKey = () => `${source.customProgramCacheKey()} c1 ${normals.isStill}`;
  own.onBeforeRender = (renderer, scene, camera, geometry, object, group) => {
    source.onBeforeRender(renderer, scene, camera, geometry, object, group);
    normals.show(renderer, camera, object);
  };
  return own;
}

// The normals of one mesh, and why it does without.
class Normals {
  constructor(mesh, isStill) {
    Object.assign(this, { mesh, shape: prepared(mesh.geometry), isStill, uniform: { value: none }, told: new Set() });
  }

  // True if an object keeps its interpolated normals because of a problem, which is told once.
  keeps(object, problem) {
    const isStale = object.geometry !== this.shape.geometry || isChanged(this.shape);
    const text = isStale ? "its geometry has changed; it keeps its interpolated normals. Call dispose() and applyC1 again" : problem;
    if (!text) return false;
    if (!this.told.has(text)) tell("warn", object, text);
    this.told.add(text);
    this.uniform.value = none;
    return true;
  }
}

// Normals that do not depend on the view.
class Still extends Normals {
  constructor(mesh) {
    super(mesh, true);
    const { whole, points } = this.shape;
    this.texture = textureFor(points.triangles.length / 3);
    this.texture.image.data.set(bulges(whole, points));
    this.texture.needsUpdate = true;
  }

  show(renderer, camera, object) {
    if (!this.keeps(object)) this.uniform.value = this.texture;
  }

  dispose() {
    this.texture.dispose();
  }
}

// The coefficients of a mesh for each camera that sees it.
class Views extends Normals {
  constructor(mesh, gpu) {
    super(mesh, false);
    Object.assign(this, { gpu, known: new Map() });
  }

  show(renderer, camera, object) {
    const modelView = object.modelViewMatrix, projection = camera.projectionMatrix;
    const problem = object !== this.mesh ? "the material belongs to another mesh; use applyC1 on copies, too"
      : keepsShape(modelView) ? undefined
        : "it is scaled unevenly or mirrored; it keeps its interpolated normals. Apply the scale to the geometry";
    if (this.keeps(object, problem)) return;
    let view = this.known.get(camera);
    if (!view) {
      if (this.known.size >= CAMERAS) this.#forget(this.known.keys().next().value);
      view = { last: [], isOnCard: this.#fits(renderer) };
      this.known.set(camera, view);
    }
    renderer.getCurrentViewport(size);
    // Only the shape of the viewport matters.
    const aspect = size.z / size.w, now = [...modelView.elements, ...projection.elements, aspect], { last, target } = view;
    // What is on a card belongs to one renderer, and is gone after it lost its context.
    const isThere = !target || (view.renderer === renderer && renderer.properties.get(target.texture).__webglTexture);
    if (!isThere || now.some((x, i) => x !== last[i])) {
      Object.assign(view, { renderer, last: now });
      if (view.isOnCard) {
        this.shape.passes ??= new Passes(this.shape.whole, this.shape.points);
        view.target ??= this.shape.passes.target();
        this.shape.passes.render(renderer, camera, modelView, projection, aspect, view.target);
      } else {
        const { whole, points } = this.shape;
        view.texture ??= textureFor(points.triangles.length / 3);
        coefficients(whole, points, modelView.elements, projection.elements, [aspect, 1], view.texture.image.data);
        view.texture.needsUpdate = true;
      }
    }
    this.uniform.value = view.target?.texture ?? view.texture;
  }

  #fits(renderer) {
    const isLarge = this.shape.points.triangles.length / 3 > FEW;
    return (this.gpu ?? isLarge) && renderer.extensions.has("EXT_color_buffer_float");
  }

  #forget(camera) {
    const { target, texture } = this.known.get(camera);
    target?.dispose();
    texture?.dispose();
    this.known.delete(camera);
  }

  dispose() {
    for (const camera of [...this.known.keys()]) this.#forget(camera);
  }
}

const size = new Vector4(), [a, b, c] = [new Vector3(), new Vector3(), new Vector3()];

// True if a matrix turns and scales, but neither distorts nor mirrors.
function keepsShape(matrix) {
  matrix.extractBasis(a, b, c);
  const lengths = [a.length(), b.length(), c.length()], shortest = Math.min(...lengths);
  return Math.max(...lengths) < 1.001 * shortest && a.cross(b).dot(c) > 0.999 * shortest ** 3;
}

// A texture with room for the coefficients of so many triangles, nine texels each.
function textureFor(triangles) {
  const [width, height] = extent(triangles, 9);
  return new DataTexture(new Float32Array(4 * width * height), width, height, RGBAFormat, FloatType);
}

// The coefficients on the card, for meshes that move: two passes that render into textures. The first finds the slopes at
// each point, the second the coefficients of each triangle. They compute what coefficients() in ordinates.js does;
// coefficients.wgsl of the kit describes the textures.

const pass = (fragmentShader) => new RawShaderMaterial({
  glslVersion: GLSL3,
  vertexShader: "in vec3 position; void main() { gl_Position = vec4(position, 1.0); }",
  fragmentShader,
  uniforms: Object.fromEntries(["camera", "points", "ring", "corners", "gradients"].map((name) => [name, { value: null }])),
  blending: NoBlending,
  depthTest: false,
  depthWrite: false,
});
const slopesPass = pass(glsl.slopes), coefficientsPass = pass(glsl.coefficients);
// One triangle that covers the target.
const covering = new Float32BufferAttribute([-1, -1, 0, 3, -1, 0, -1, 3, 0], 3);
const screen = new Mesh(new BufferGeometry().setAttribute("position", covering));
screen.frustumCulled = false;
// The shaders need no camera, but three.js wants one whose projection it can reverse.
const scene = new Scene(), viewer = new OrthographicCamera();
scene.add(screen);
scene.matrixWorldAutoUpdate = viewer.matrixWorldAutoUpdate = false;

// The width and height of a texture for items of so many texels: nearly square, and a row has whole items.
function extent(items, texels) {
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
class Passes {
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
    draw(slopesPass, this.textures, this.slopes);
    draw(coefficientsPass, { ...this.textures, gradients: this.slopes.texture }, into);
    [renderer.autoClear, xr.enabled, info.autoReset] = [autoClear, enabled, autoReset];
    renderer.setRenderTarget(...before);
    // As three.js's own Reflector does.
    if (camera.viewport) renderer.state.viewport(camera.viewport);
  }

  dispose() {
    for (const held of [...Object.values(this.textures), this.slopes]) held.dispose();
  }
}
