use machband::{light::Depth, stimulus::*, vision::*};
fn main() {
    for d in [1, 2] { for w in [0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.6] {
        print!("n {d} width {w}: ");
        for o in [0.0, 30.0, 45.0] {
            let b = MachBand { width: w, depth: Depth::Finite(d), orientation_deg: o, ..MachBand::default() };
            let light = luminances(&Stimulus::from(b).linear(512));
            let px = 51.2;
            let row = &light[256 * 512..][..512];
            if o == 0.0 { for border in [Border::Continues, Border::Cut] {
                print!("{border:?} {:.3} ", Line { light: row, px_per_deg: px, border }.predict(&Eye::default()).unwrap().visibility.max()); } }
            let v = LuminanceImage { light: &light, width: 512, height: 512, px_per_deg: px, mask: None }.predict(&Eye::default()).unwrap();
            print!("{o}° {:.3}  ", v.visibility.max());
        }
        println!();
    } }
}
