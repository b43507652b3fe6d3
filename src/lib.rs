//! machband: measure, analyze, generate and predict the visibility of Mach bands.
//!
//! **Scope.** Full-screen rating experiments on luminance ramps (width, continuity depth, orientation), their exact
//! stimulus images, their data; shaders of meshes without the bands. **Not in scope**: reaction-time or threshold
//! paradigms in general, other modalities, anything over a network.
//!
//! **Units.** Light is linear and relative to the brightest that the screen shows, 0…1, unless a name says `encoded`
//! or `code`. Angles are degrees; visual angles say so. Lengths on the screen are physical pixels or cm. Times are
//! seconds or [`std::time::Duration`]. Widths of a ramp are proportions of the stimulus window.
//!
//! **The map.** A module uses only modules with a lower floor number:
//!
//! | floor | module | what |
//! |---|---|---|
//! | 0 | [`light`] | interpolation I_n, transfer functions, light to codes, images |
//! | 1 | [`display`] | visual angle, cm and pixels; what is known of a screen |
//! | 1 | [`shading`] | meshes, illumination, the shaders on CPU and graphics card, how far their slopes jump |
//! | 1 | [`vision`] | image or profile → how visible its bands are |
//! | 2 | [`stimulus`] | a validated description becomes an image, and what is seen of it |
//! | 3 | [`experiment`] | definition, order, session, record, observers |
//! | 4 | [`analysis`] | counts of ratings in, ordinal models and tests out |
//! | 4 | [`store`] | every file format |
//! | 5 | [`report`] | tables, figures and the report of a study |
//! | 6 | [`app`], [`cli`] | the window; the commands |
//!
//! Sources: Bangay, *Methods of Reducing the Visibility of Mach Bands during Gouraud Shading*; Shoaff,
//! *Color, Illumination Models, and Shading*.

pub mod analysis;
#[cfg(feature = "window")]
pub mod app;
pub mod cli;
pub mod display;
pub mod experiment;
pub mod light;
pub mod report;
pub mod shading;
pub mod stimulus;
pub mod store;
pub mod vision;
