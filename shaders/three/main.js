// Gouraud, Phong and C1 normals side by side, and what test.mjs asks of the browser.

import * as THREE from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { applyC1 } from "./index.js";

const LAMP = new THREE.Vector3(0.36, 0.48, 0.8);
// The lighting of `machband shade`, in linear light: reflection after Phong, where three.js has that after Blinn.
const LIGHT = `vec3 lit(vec3 n, vec3 eye) {
  vec3 lamp = normalize(vec3(${LAMP.toArray()}));
  float cosine = dot(n, lamp), shine = max(2.0 * cosine * dot(n, eye) - dot(lamp, eye), 0.0);
  return vec3(cosine > 0.0 ? 0.1 + 0.6 * cosine + 0.3 * pow(shine, 20.0) : 0.1);
}`;
const EYE = "isOrthographic ? vec3(0.0, 0.0, 1.0) : normalize(vViewPosition)";

function lit(color = 0xffffff) {
  const material = new THREE.MeshPhongMaterial({ color });
  material.onBeforeCompile = (shader) => {
    shader.fragmentShader = shader.fragmentShader.replace("void main()", `${LIGHT}\nvoid main()`)
      .replace("#include <opaque_fragment>", `outgoingLight = diffuse * lit(normal, ${EYE});\n#include <opaque_fragment>`);
  };
  return material;
}
const gouraud = new THREE.ShaderMaterial({
  vertexShader: `varying vec3 light; ${LIGHT} void main() {
    vec4 place = modelViewMatrix * vec4(position, 1.0);
    light = lit(normalize(normalMatrix * normal), normalize(-place.xyz));
    gl_Position = projectionMatrix * place;
  }`,
  fragmentShader: "varying vec3 light; void main() { gl_FragColor = vec4(light, 1.0); \n#include <colorspace_fragment>\n }",
});

const renderer = new THREE.WebGLRenderer({ antialias: true });
renderer.setPixelRatio(window.devicePixelRatio);
document.body.prepend(renderer.domElement);
const camera = new THREE.PerspectiveCamera(30, 1, 0.1, 100);
camera.position.set(1.6, -2.6, 2.6);
const controls = new OrbitControls(camera, renderer.domElement);
const scenes = [0, 1, 2].map(() => new THREE.Scene());
let applied;

// Shows a model in the unit sphere, once with each shading.
function show(model) {
  applied?.dispose();
  const sphere = new THREE.Box3().setFromObject(model).getBoundingSphere(new THREE.Sphere());
  model.scale.divideScalar(sphere.radius);
  model.position.sub(sphere.center).divideScalar(sphere.radius);
  scenes.forEach((scene, i) => {
    const own = model.clone();
    own.traverse((mesh) => mesh.isMesh && (mesh.material = i === 0 ? gouraud : lit()));
    scene.clear().add(own);
  });
  applied = applyC1(scenes[2]);
  draw();
}

function draw() {
  const [width, height] = [window.innerWidth, window.innerHeight];
  renderer.setSize(width, height, false);
  renderer.setScissorTest(true);
  camera.aspect = width / 3 / height;
  // Tall panes fit the mesh into their width.
  camera.zoom = Math.min(1, camera.aspect);
  camera.updateProjectionMatrix();
  scenes.forEach((scene, i) => {
    const pane = [Math.round((i * width) / 3), 0, Math.round(width / 3), height];
    renderer.setViewport(...pane);
    renderer.setScissor(...pane);
    renderer.render(scene, camera);
  });
  renderer.setScissorTest(false);
}

const read = async (buffer) => (await new GLTFLoader().parseAsync(buffer, "")).scene;
document.getElementById("file").addEventListener("change", async ({ target }) => {
  try {
    show(await read(await target.files[0].arrayBuffer()));
  } catch (error) {
    document.getElementById("status").textContent = error.message;
  }
});
controls.addEventListener("change", draw);
window.addEventListener("resize", draw);
const model = await read(await (await fetch("./mesh.glb")).arrayBuffer());
show(model.clone());

// For the test: a mesh from flat arrays (or the file's), as machband sees it, in codes from the bottom row on. "phong" and
// "c1-phong" have the lights of three.js and no shine; with `shine`, a user's own onBeforeCompile.
window.codes = ({ shape, shader, shine, gpu, side, rotate, fill, distance }) => {
  let { geometry } = model.getObjectByProperty("isMesh", true);
  if (shape) {
    const attribute = (array) => new THREE.Float32BufferAttribute(array, 3);
    geometry = new THREE.BufferGeometry().setAttribute("position", attribute(shape.positions))
      .setAttribute("normal", attribute(shape.normals)).setIndex(shape.index);
  }
  const mesh = new THREE.Mesh(geometry, shine ? lit() : new THREE.MeshPhongMaterial({ color: 0xffffff, specular: 0 }));
  const { position } = geometry.attributes, place = new THREE.Vector3();
  const center = new THREE.Box3().setFromBufferAttribute(position).getCenter(new THREE.Vector3());
  let radius = 0;
  for (let i = 0; i < position.count; i++) radius = Math.max(radius, center.distanceTo(place.fromBufferAttribute(position, i)));
  const turned = new THREE.Euler(...rotate.map((degrees) => (degrees * Math.PI) / 180), "ZYX");
  mesh.matrixAutoUpdate = false;
  mesh.matrix.makeRotationFromEuler(turned).scale(new THREE.Vector3().setScalar(1 / radius))
    .multiply(new THREE.Matrix4().makeTranslation(center.negate()));
  let eye = new THREE.OrthographicCamera(-1 / fill, 1 / fill, 1 / fill, -1 / fill, 0.1, 10);
  if (distance) {
    eye = new THREE.PerspectiveCamera((2 * Math.atan(1 / (fill * Math.sqrt(distance ** 2 - 1))) * 180) / Math.PI, 1, 0.01, 100);
  }
  eye.position.z = distance || 3;
  const sun = new THREE.DirectionalLight(0xffffff, 0.6 * Math.PI);
  sun.position.copy(LAMP);
  const scene = new THREE.Scene().add(mesh, sun, new THREE.AmbientLight(0xffffff, 0.1 * Math.PI));
  const own = shader === "c1-phong" && applyC1(scene, { gpu });
  const target = new THREE.WebGLRenderTarget(side, side, { type: THREE.FloatType }), pixels = new Float32Array(4 * side * side);
  renderer.setRenderTarget(target);
  // Another camera between must not disturb.
  renderer.render(scene, camera);
  renderer.setClearColor(0x000000);
  renderer.render(scene, eye);
  renderer.readRenderTargetPixels(target, 0, 0, side, side, pixels);
  renderer.setRenderTarget(null);
  if (own) own.dispose();
  target.dispose();
  const code = (light) => Math.round(255 * (light <= 0.0031308 ? 12.92 * light : 1.055 * light ** (1 / 2.4) - 0.055));
  return Array.from({ length: side * side }, (_, i) => code(pixels[4 * i]));
};
window.THREE = THREE;
window.applyC1 = applyC1;
window.ready = true;
