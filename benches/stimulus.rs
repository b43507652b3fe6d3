//! What one stimulus costs: 1024 × 1024 pixels, 8-bit RGB (3 MiB), sRGB, against plainly filling
//! the same memory.
//!
//! Peers, as reported and not measured here: stimupy 1.2.0 takes 62–100 ms for a step or Cornsweet
//! image of this size (it has no Mach-band ramp). Results and how to repeat them:
//! `benches/README.md`.

use divan::counter::BytesCount;
use divan::{Bencher, black_box};
use machband::light::{Bits, Depth, Quantizer, Transfer};
use machband::stimulus::{MachBand, StimulusColor};

const SIZE: u32 = 1024;
const BYTES: usize = SIZE as usize * SIZE as usize * 3;

fn main() {
    divan::main();
}

fn quantizer() -> Quantizer {
    Quantizer::new(&Transfer::Srgb, Bits::Eight)
}

/// The stimulus that the target is about, and what it is at other orientations.
fn band(orientation_deg: f64) -> MachBand {
    MachBand { width: 0.4, depth: Depth::Finite(3), orientation_deg, ..MachBand::default() }
}

fn bench_into(bencher: Bencher<'_, '_>, band: &MachBand) {
    let (quantizer, mut codes) = (quantizer(), vec![1; BYTES]);
    bencher.counter(BytesCount::new(BYTES)).bench_local(|| {
        black_box(band).codes_into(SIZE, &quantizer, black_box(&mut codes));
    });
}

/// Into memory that is already there.
#[divan::bench_group(sample_count = 400, sample_size = 1)]
mod existing_memory {
    use super::*;

    /// The measure of all others.
    #[divan::bench]
    fn fill(bencher: Bencher<'_, '_>) {
        let mut codes = vec![1u8; BYTES];
        bencher.counter(BytesCount::new(BYTES)).bench_local(|| black_box(&mut codes).fill(black_box(137)));
    }

    #[divan::bench(args = [0.0, 33.0, 45.0, 89.0, 89.9, 90.0])]
    fn orientation(bencher: Bencher<'_, '_>, orientation_deg: f64) {
        bench_into(bencher, &band(orientation_deg));
    }

    #[divan::bench(args = ["1", "32", "inf"])]
    fn depth_at_33(bencher: Bencher<'_, '_>, depth: &str) {
        let depth = depth.parse().expect("a depth");
        bench_into(bencher, &MachBand { depth, ..band(33.0) });
    }

    /// Three channels of different weight, full range: as many steps as there can be.
    #[divan::bench]
    fn most_steps_at_33(bencher: Bencher<'_, '_>) {
        let color = StimulusColor::new([1.0, 0.9, 0.8]).expect("weights within 0…1");
        bench_into(bencher, &MachBand { low: 0.0, high: 1.0, color, ..band(33.0) });
    }
}

/// Memory asked of the system and given back every time.
#[divan::bench_group(sample_count = 200, sample_size = 1)]
mod fresh_memory {
    use super::*;

    #[divan::bench]
    fn fill(bencher: Bencher<'_, '_>) {
        bencher.counter(BytesCount::new(BYTES)).bench(|| vec![black_box(137u8); BYTES]);
    }

    #[divan::bench]
    fn codes_at_33(bencher: Bencher<'_, '_>) {
        let (band, quantizer) = (band(33.0), quantizer());
        bencher.counter(BytesCount::new(BYTES)).bench(|| black_box(&band).codes(SIZE, &quantizer));
    }
}

/// Every pixel on its own, as the definition says.
#[divan::bench_group(sample_count = 20, sample_size = 1)]
mod reference {
    use super::*;

    #[divan::bench]
    fn linear_at_33(bencher: Bencher<'_, '_>) {
        let band = band(33.0);
        bencher.bench(|| black_box(&band).linear(SIZE));
    }

    #[divan::bench]
    fn linear_and_quantize_at_33(bencher: Bencher<'_, '_>) {
        let (band, quantizer) = (band(33.0), quantizer());
        bencher.counter(BytesCount::new(BYTES)).bench(|| quantizer.quantize(&black_box(&band).linear(SIZE)));
    }

    #[divan::bench(args = [Bits::Eight, Bits::Sixteen])]
    fn new_quantizer(bencher: Bencher<'_, '_>, bits: Bits) {
        bencher.bench(|| Quantizer::new(black_box(&Transfer::Srgb), bits));
    }
}
