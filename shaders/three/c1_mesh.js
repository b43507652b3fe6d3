// A mesh with C1 normals for three.js, under any of its lit materials. The shaders are the files of the kit, ../glsl and
// ../glsl_es.
//
//   import { C1Mesh } from "./three/c1_mesh.js";
//   scene.add(new C1Mesh(new THREE.TorusKnotGeometry(1, 0.4, 48, 10), new THREE.MeshStandardMaterial()));

import * as THREE from "three";
import { curvature, ordinates, shared } from "../ordinates.js";

// Triangles in each row of the texture of ordinates.
const PER_ROW = 64;

const text = async (path) => {
  const response = await fetch(new URL(path, import.meta.url));
  const content = await response.text();
  // Some servers answer with a page of their own.
  if (!response.ok || content.startsWith("<")) throw new Error(`${response.url}: not found; expected the kit's ${path}`);
  return content;
};
const [vertex, patch, reader, fragment] = await Promise.all(
  ["../glsl_es/triangle.vert", "../glsl/patch.glsl", "../glsl_es/ordinates.glsl", "../glsl_es/c1_phong.frag"].map(text),
);
export { fragment };

const declared = "out vec3 weights_times_w;\nflat out int triangle;\n";
const assigned = `
  int corner = gl_VertexID % 3;
  weights_times_w = gl_Position.w * vec3(corner == 0, corner == 1, corner == 2);
  triangle = gl_VertexID / 3;
`;
const replaced = `$&
  Patch c1 = patch_here();
  if (has_patch(c1)) normal = normalize(patch_value(c1, corner_weights()).xyz);
`;

// Makes a lit material of three.js (MeshPhongMaterial, MeshStandardMaterial …) use C1 normals in place of interpolated
// ones. Its textures, normal map and lights stay. The material belongs to one mesh.
export function withC1Normals(material, texture) {
  material.onBeforeCompile = (shader) => {
    shader.uniforms.ordinates = { value: texture };
    shader.vertexShader = declared + shader.vertexShader
      .replace("#include <project_vertex>", `#include <project_vertex>\n${assigned}`);
    const normal = THREE.ShaderChunk.normal_fragment_begin.replace("vec3 normal = normalize( vNormal );", replaced);
    if (!normal.includes("patch_here")) throw new Error("this version of three.js is not known; expected 0.187");
    shader.fragmentShader = `${patch}\n${reader}\n` + shader.fragmentShader
      .replace("#include <normal_fragment_begin>", normal);
  };
  material.customProgramCacheKey = () => "c1 normals";
  return material;
}

// The plain material of c1_phong.frag: linear light, one distant lamp in view space. Without ordinates in `texture`, it
// interpolates normals, which is Phong.
export function c1Material(uniforms, texture) {
  return new THREE.RawShaderMaterial({
    glslVersion: THREE.GLSL3,
    vertexShader: `precision highp float;\nprecision highp int;\n${vertex}`,
    fragmentShader: `precision highp float;\nprecision highp int;\n${patch}\n${reader}\n${fragment}`,
    uniforms: { ...uniforms, is_orthographic: { value: false }, ordinates: { value: texture } },
  });
}

// A texture with room for the ordinates of so many triangles, all zero.
export function ordinatesTexture(triangles) {
  const rows = Math.max(Math.ceil(triangles / PER_ROW), 1), table = new Float32Array(rows * PER_ROW * 48);
  const texture = new THREE.DataTexture(table, 12 * PER_ROW, rows, THREE.RGBAFormat, THREE.FloatType);
  texture.needsUpdate = true;
  return texture;
}

// True if a matrix turns and scales, but neither distorts nor mirrors.
function keepsShape({ elements: m }) {
  const lengths = [0, 4, 8].map((i) => Math.hypot(m[i], m[i + 1], m[i + 2]));
  const [a, b, c] = [0, 4, 8].map((i) => new THREE.Vector3(m[i], m[i + 1], m[i + 2]));
  return Math.max(...lengths) < 1.001 * Math.min(...lengths) && a.cross(b).dot(c) > 0.999 * Math.min(...lengths) ** 3;
}

// Any geometry with positions; normals are computed if it has none. The mesh has a copy of the geometry without shared
// vertices, because each must know its triangle and its corner, and a copy of the material or of each in an array;
// `uniforms` in place of a material makes that of c1_phong.frag.
export class C1Mesh extends THREE.Mesh {
  constructor(geometry, material = new THREE.MeshStandardMaterial()) {
    const own = geometry.index ? geometry.toNonIndexed() : geometry.clone();
    if (!geometry.attributes.normal) {
      // Over the shared vertices, so that the normals are smooth.
      const smooth = geometry.clone();
      smooth.computeVertexNormals();
      own.setAttribute("normal", (smooth.index ? smooth.toNonIndexed() : smooth).attributes.normal);
    }
    const { position, normal } = own.attributes;
    const numbers = (attribute) =>
      Array.from({ length: 3 * attribute.count }, (_, i) => attribute.getComponent(Math.floor(i / 3), i % 3));
    const shape = shared(numbers(position), numbers(normal)), tensors = curvature(shape);
    const texture = ordinatesTexture(position.count / 3), lit = (one) => withC1Normals(one.clone(), texture);
    const isPlain = !Array.isArray(material) && !material.isMaterial;
    super(own, isPlain ? c1Material(material, texture) : Array.isArray(material) ? material.map(lit) : lit(material));
    this.ordinates = texture;
    this.uniforms = isPlain ? material : undefined;
    const size = new THREE.Vector4();
    let last = [], isTold = false;
    // The ordinates depend on the view, so they are computed before the mesh is drawn, unless the view is the last one.
    this.onBeforeRender = (renderer, scene, camera) => {
      const modelView = camera.matrixWorldInverse.clone().multiply(this.matrixWorld);
      renderer.getCurrentViewport(size);
      const viewport = [size.z, size.w], projection = camera.projectionMatrix.elements;
      const view = [...modelView.elements, ...projection, ...viewport];
      if (view.every((number, i) => number === last[i])) return;
      last = view;
      if (keepsShape(modelView)) {
        texture.image.data.set(ordinates(shape, tensors, modelView.elements, projection, viewport));
      } else {
        // Without ordinates, normals are interpolated.
        texture.image.data.fill(0);
        if (!isTold) console.warn("C1Mesh: the mesh is scaled unevenly or mirrored; expected the same scale along all axes");
        isTold = true;
      }
      texture.needsUpdate = true;
    };
  }

  clone(recursive) {
    const own = new C1Mesh(this.geometry, this.uniforms ?? this.material);
    return THREE.Object3D.prototype.copy.call(own, this, recursive);
  }

  dispose() {
    for (const held of [this.ordinates, this.geometry, this.material].flat()) held.dispose();
  }
}
