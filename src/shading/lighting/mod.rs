//! How much light a point of a surface sends to the eye, Shoaff §3. Evaluated per vertex or per pixel by the same
//! function, [`Lighting::light`]:
//!
//! I = k_a·I_a·O_d + Σ f_att·I_p·[k_d·O_d·(N·L)⁺ + k_s·O_s·s], per red, green and blue,
//!
//! where s is the highlight of a [`Specular`] model. Everything is evaluated in eye space, before the projection, which
//! does not keep angles. Lights are linear. Lamps cast no shadows.

mod fault;
mod lamp;
mod lighting;
mod material;
mod microfacets;
mod refraction;
mod transparency;

pub use fault::{LightingError, ParameterFault};
pub use lamp::{Lamp, LampPlace, attenuation};
pub use lighting::Lighting;
pub use material::{Material, Specular};
pub use microfacets::{Facets, Microfacets, beckmann, fresnel, gaussian, geometry, index_from_reflectance};
pub use refraction::Refraction;
pub use transparency::{Transparency, TransparencyError};
