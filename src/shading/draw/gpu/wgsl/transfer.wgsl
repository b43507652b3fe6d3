// What a display is driven with to make a light, 0…1 each.

const LINEAR = 0u;
const SRGB = 1u;
const GAMMA = 2u;
const TABLE = 3u;

fn encoded(linear: vec3f) -> vec3f {
    let l = clamp(linear, vec3f(0.0), vec3f(1.0));
    if TRANSFER == SRGB {
        // IEC 61966-2-1.
        return select(1.055 * pow(l, vec3f(1.0 / 2.4)) - 0.055, 12.92 * l, l <= vec3f(0.04045 / 12.92));
    }
    if TRANSFER == GAMMA {
        return select(vec3f(0.0), pow(l, vec3f(globals.exponent)), l > vec3f(0.0));
    }
    if TRANSFER == TABLE {
        return vec3f(from_table(l.r), from_table(l.g), from_table(l.b));
    }
    return l;
}

// The straight line between two points of the table.
fn from_table(linear: f32) -> f32 {
    // No light is code 0, also where a table's first line begins above it.
    if linear <= 0.0 {
        return 0.0;
    }
    var low = 0u;
    var high = globals.points - 1u;
    while high - low > 1u {
        let middle = (low + high) / 2u;
        if table[middle].x <= linear {
            low = middle;
        } else {
            high = middle;
        }
    }
    let point = table[low];
    return point.y + (linear - point.x) * point.z;
}
