//! Prints a ramp with less visible Mach bands, for use in your own shader: `cargo run --example shader_ramp`.
//!
//! Replace `mix(a, b, t)` with `mix(a, b, ramp(t))`, in linear light. I_n is a polynomial of degree 2n − 1 whose first
//! n − 1 derivatives vanish at both ends; n = 2 is the well-known smoothstep. The visibility of the bands decreases as
//! n increases.

use machband::light::{Depth, Interpolation, interpolation::coefficients};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Σ c_j·t^(3+j), j = 0…2, computed at compile time.
    const C: [f64; 3] = coefficients::<3>();
    println!("fn ramp(t: f32) -> f32 {{ // I_3, WGSL");
    println!("    let u = clamp(t, 0.0, 1.0);");
    println!("    return u * u * u * ({:?} + u * ({:?} + u * {:?}));", C[0], C[1], C[2]);
    println!("}}");

    // The same function from the library, as a table for a texture.
    let smooth = Interpolation::new(Depth::finite(3)?);
    let polynomial = |u: f64| u.powi(3) * (C[0] + u * (C[1] + u * C[2]));
    println!("\n   u   I_3(u)");
    for i in 0..=10 {
        let u = f64::from(i) / 10.0;
        assert!((polynomial(u) - smooth.value(u)).abs() < 1e-12);
        println!("{u:4.1}  {:.5}", smooth.value(u));
    }
    Ok(())
}
