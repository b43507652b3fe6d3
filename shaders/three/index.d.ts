import type { Mesh, Object3D } from "three";

export interface Applied {
  /** The meshes that now have C1 normals. */
  meshes: Mesh[];
  /** Those among them that move in the vertex shader, with normals whose slopes are only nearly continuous, and why. */
  approximate: { mesh: Mesh; reason: string }[];
  /** The meshes that stay as they are, and why. */
  skipped: { mesh: Mesh; reason: string }[];
  /** Gives the meshes back their geometries and materials, and frees textures and copies. */
  dispose(): void;
}

export interface Options {
  /** Computes on the card (true) or in JavaScript (false). By default, meshes above 2,000 triangles use the card. */
  gpu?: boolean;
}

/**
 * Gives every mesh under `root` C1 normals. Each gets a copy of its material: change `mesh.material` afterwards, not the
 * original. Meshes that cannot have C1 normals, or whose materials use no interpolated normals, stay as they are, and the
 * console names them.
 */
export function applyC1(root: Object3D, options?: Options): Applied;

type Numbers = ArrayLike<number> & Iterable<number>;

/** Positions, unit normals (three numbers for each vertex) and triangles (three vertices each). */
export interface Shape {
  positions: Float64Array;
  normals: Float64Array;
  triangles: Uint32Array;
}

/** What does not depend on the view; ordinates.js describes each array. */
export interface Points {
  vertices: Uint32Array;
  tensors: Float64Array;
  triangles: Uint32Array;
  sides: Uint32Array;
  starts: Uint32Array;
  ring: Uint32Array;
}

/** Joins vertices whose positions and normals differ by rounding errors only. Throws a RangeError if one is not finite. */
export function welded(positions: Numbers, normals: Numbers, index?: Numbers): Shape;

/** Computes, once per mesh, what does not depend on the view. */
export function curvature(mesh: Shape): Points;

/** Where the triangles around each vertex, or around each point, are. */
export function rings(mesh: Shape | Points): { starts: Uint32Array; ring: Uint32Array };

/** The 36 numbers of each triangle for one view. */
export function coefficients(
  mesh: Shape, points: Points, modelView: Numbers, projection: Numbers, size: [number, number], out?: Float32Array,
): Float32Array;

/** What the cubic adds to the interpolated normal, for every view; 36 numbers for each triangle. */
export function bulges(mesh: Shape, points: Points): Float32Array;

/** The 36 numbers of one triangle, from what ordinates.js describes. */
export function cubic(
  places: Numbers, across: Numbers, value: Numbers, next: Numbers, previous: Numbers,
  out: Float32Array | Float64Array, at: number,
): void;
