//! The light that a point of a surface sends to the eye, Shoaff §3. The same function lights vertices and pixels:
//!
//! I = k_a·I_a·O_d + Σ f_att·I_p·[k_d·O_d·(N·L)⁺ + k_s·O_s·s], separately for red, green and blue,
//!
//! where s is the highlight of a [`Specular`] model. Everything is evaluated in eye space, before the projection,
//! because the projection does not preserve angles. Light values are linear. Lamps cast no shadows.

mod microfacets;
mod model;

pub use microfacets::{Microfacets, beckmann, fresnel, gaussian, geometry};
pub use model::{Lamp, LampPosition, Lighting, Material, Specular, attenuation};
pub use model::{Refraction, Transmits, Transparency};
