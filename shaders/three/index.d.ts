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
  /** Computes on the card (true) or in JavaScript (false). By default, meshes above 500 triangles use the card. */
  gpu?: boolean;
}

/**
 * Gives every mesh under `root` C1 normals. Each gets a copy of its material: change `mesh.material` afterward, not the
 * original. Meshes that cannot have C1 normals, or whose materials use no interpolated normals, stay as they are, and the
 * console names them.
 */
export function applyC1(root: Object3D, options?: Options): Applied;
