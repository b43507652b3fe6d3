//! How much light a point of a surface sends to the eye, Shoaff §3. Vertices and pixels are lit by the same function:
//!
//! I = k_a·I_a·O_d + Σ f_att·I_p·[k_d·O_d·(N·L)⁺ + k_s·O_s·s], per red, green and blue,
//!
//! where s is the highlight of a [`Specular`] model. Everything is evaluated in eye space, before the projection, which
//! does not keep angles. Lights are linear. Lamps cast no shadows.

mod lamp;
mod lights;
mod material;
mod microfacets;
mod reflection;
mod refraction;
mod transparency;

pub use lamp::{Lamp, LampPlace};
pub use lights::Lighting;
pub use material::{Material, Specular};
pub use microfacets::{Facets, Microfacets, beckmann, fresnel, gaussian, geometry};
pub use reflection::{Reflection, attenuation};
pub use refraction::Refraction;
pub use transparency::Transparency;
