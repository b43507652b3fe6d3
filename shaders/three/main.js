// Gouraud, Phong and Phong with C1 normals side by side.

import * as THREE from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { mergeGeometries } from "three/addons/utils/BufferGeometryUtils.js";
import { C1Mesh, c1Material, fragment, ordinatesTexture, withC1Normals } from "./c1_mesh.js";

const SHADERS = ["gouraud", "phong", "c1-phong"];

// The lamp moves with the viewer.
const lights = {
  lamp: { value: new THREE.Vector3(0.36, 0.48, 0.8) },
  ambient: { value: new THREE.Vector3(0.1, 0.1, 0.1) },
  diffuse: { value: new THREE.Vector3(0.6, 0.6, 0.6) },
  specular: { value: new THREE.Vector3(0.3, 0.3, 0.3) },
  shininess: { value: 20 },
};

// Gouraud: the same lighting, at the vertices. It is the code of c1_phong.frag from `vec3 to_eye` on.
const lighting = fragment.slice(fragment.indexOf("    normal = normalize(normal);"), fragment.indexOf("    color = "));
const declared = fragment.slice(fragment.indexOf("// A vector toward a distant lamp"), fragment.indexOf("out vec4 color"));
const encoded = fragment.slice(fragment.indexOf("// Linear light to sRGB"), fragment.indexOf("void main()"));
const gouraud = new THREE.RawShaderMaterial({
  glslVersion: THREE.GLSL3,
  vertexShader: `precision highp float;
    in vec3 position; in vec3 normal;
    uniform mat4 modelViewMatrix; uniform mat4 projectionMatrix; uniform mat3 normalMatrix;
    ${declared}
    out vec3 vertex_light;
    vec3 lit(vec3 normal, vec3 place) { ${lighting} return light; }
    void main() {
      vec4 place = modelViewMatrix * vec4(position, 1.0);
      gl_Position = projectionMatrix * place;
      vertex_light = lit(normalMatrix * normal, place.xyz);
    }`,
  fragmentShader: `precision highp float;
    in vec3 vertex_light; out vec4 color;
    ${encoded}
    void main() { color = vec4(encoded(vertex_light), 1.0); }`,
  uniforms: { ...lights, is_orthographic: { value: false } },
});

const renderer = new THREE.WebGLRenderer({ antialias: true });
renderer.setPixelRatio(window.devicePixelRatio);
renderer.autoClear = false;
document.body.prepend(renderer.domElement);

const scene = new THREE.Scene();
const perspective = new THREE.PerspectiveCamera(30, 1, 0.1, 100);
perspective.position.set(1.6, -2.6, 2.6);
const controls = new OrbitControls(perspective, renderer.domElement);

// For the materials of three.js, whose lights are π times as strong.
const sun = new THREE.DirectionalLight(0xffffff, 0.6 * Math.PI);
sun.position.copy(lights.lamp.value);
scene.add(sun, new THREE.AmbientLight(0xffffff, 0.1 * Math.PI));

// Without ordinates, c1_phong is Phong.
const materials = { gouraud, phong: c1Material(lights, ordinatesTexture(0)) };
let mesh, fit;

// Shows every mesh of a GLB file as one.
function show(buffer) {
  return new Promise((done, failed) => new GLTFLoader().parse(buffer, "", (gltf) => {
    const geometries = [];
    gltf.scene.updateMatrixWorld(true);
    gltf.scene.traverse((node) => {
      if (!node.isMesh) return;
      const placed = node.geometry.clone().applyMatrix4(node.matrixWorld);
      if (!placed.attributes.normal) placed.computeVertexNormals();
      const { position, normal } = (placed.index ? placed.toNonIndexed() : placed).attributes;
      geometries.push(new THREE.BufferGeometry().setAttribute("position", position).setAttribute("normal", normal));
    });
    if (geometries.length === 0) return failed(new Error("the file has no mesh"));
    if (mesh) scene.remove(mesh);
    mesh = new C1Mesh(mergeGeometries(geometries), lights);
    mesh.matrixAutoUpdate = false;
    scene.add(mesh);
    materials["c1-phong"] = mesh.material;
    materials.matt = withC1Normals(new THREE.MeshPhongMaterial({ color: 0xffffff, specular: 0 }), mesh.ordinates);
    // The sphere around the mesh becomes the unit sphere.
    const { position } = mesh.geometry.attributes, place = new THREE.Vector3();
    const center = new THREE.Box3().setFromBufferAttribute(position).getCenter(new THREE.Vector3());
    let radius = 0;
    for (let i = 0; i < position.count; i++) {
      radius = Math.max(radius, center.distanceTo(place.fromBufferAttribute(position, i)));
    }
    fit = new THREE.Matrix4().makeScale(1 / radius, 1 / radius, 1 / radius)
      .multiply(new THREE.Matrix4().makeTranslation(center.negate()));
    mesh.matrix.copy(fit);
    done(position.count / 3);
  }, failed));
}

// Draws with one shader as `camera` sees the mesh.
function draw(shader, camera) {
  if (!mesh) return;
  mesh.material = materials[shader];
  if (mesh.material.uniforms) mesh.material.uniforms.is_orthographic.value = camera.isOrthographicCamera === true;
  renderer.render(scene, camera);
}

function drawAll() {
  const [width, height] = [window.innerWidth, window.innerHeight];
  renderer.setSize(width, height, false);
  renderer.setClearColor(0x15171a);
  renderer.setScissorTest(false);
  renderer.clear();
  renderer.setScissorTest(true);
  perspective.aspect = width / 3 / height;
  // Tall panes fit the mesh into their width.
  perspective.zoom = Math.min(1, perspective.aspect);
  perspective.updateProjectionMatrix();
  SHADERS.forEach((shader, i) => {
    const pane = [Math.round((i * width) / 3), 0, Math.round(width / 3), height];
    renderer.setViewport(...pane);
    renderer.setScissor(...pane);
    draw(shader, perspective);
  });
}

// For the test: the codes of one pane, as machband sees the mesh. Row by row from the bottom, four bytes per pixel.
window.codes = (shader, { side, rotate, fill, distance }) => {
  const turn = (axis, degrees) => new THREE.Matrix4().makeRotationAxis(new THREE.Vector3(...axis), (degrees * Math.PI) / 180);
  mesh.matrix.copy(turn([0, 0, 1], rotate[2])).multiply(turn([0, 1, 0], rotate[1])).multiply(turn([1, 0, 0], rotate[0]))
    .multiply(fit);
  let camera = new THREE.OrthographicCamera(-1 / fill, 1 / fill, 1 / fill, -1 / fill, 0.1, 10);
  camera.position.z = 3;
  if (distance) {
    camera = new THREE.PerspectiveCamera((2 * Math.atan(1 / (fill * Math.sqrt(distance ** 2 - 1))) * 180) / Math.PI, 1, 0.01, 100);
    camera.position.z = distance;
  }
  // "matt" is a material of three.js under its own lights, which it sends to targets in linear light.
  const isMatt = shader === "matt", target = new THREE.WebGLRenderTarget(side, side, { type: isMatt ? THREE.FloatType : THREE.UnsignedByteType });
  renderer.setRenderTarget(target);
  renderer.setClearColor(0x000000);
  renderer.setScissorTest(false);
  renderer.clear();
  draw(shader, camera);
  const pixels = isMatt ? new Float32Array(4 * side * side) : new Uint8Array(4 * side * side);
  renderer.readRenderTargetPixels(target, 0, 0, side, side, pixels);
  renderer.setRenderTarget(null);
  const code = (light) => Math.round(255 * (light <= 0.0031308 ? 12.92 * light : 1.055 * light ** (1 / 2.4) - 0.055));
  return Array.from(pixels, isMatt ? code : undefined);
};

const status = document.getElementById("status");
document.getElementById("file").addEventListener("change", async ({ target }) => {
  const [file] = target.files;
  if (!file) return;
  try {
    const count = await show(await file.arrayBuffer());
    status.textContent = `${file.name}: ${count} triangles. Drag to turn, scroll to zoom.`;
  } catch (error) {
    status.textContent = `${file.name}: ${error.message}`;
  }
  drawAll();
});
document.getElementById("shininess").addEventListener("input", ({ target }) => {
  lights.shininess.value = Number(target.value);
  drawAll();
});
controls.addEventListener("change", drawAll);
window.addEventListener("resize", drawAll);
await show(await (await fetch("./mesh.glb")).arrayBuffer());
drawAll();
window.ready = true;
