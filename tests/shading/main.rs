//! Meshes, lighting and shaders, on the processor and on a graphics card.

mod crease;
#[cfg(feature = "window")]
mod gpu;
mod illumination;
mod meshes;
mod obj;
mod patch;
mod plane;
mod raster;
mod shaders;
