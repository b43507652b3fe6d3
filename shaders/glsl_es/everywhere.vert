#version 300 es
// Generated from wgsl/coefficients.wgsl, which has the comments. Do not edit: `UPDATE_SHADERS=1 cargo test --test shading generated` writes it.

precision highp float;
precision highp int;


void main() {
    uint index = uint(gl_VertexID);
    gl_Position = vec4(((float((index & 1u)) * 4.0) - 1.0), ((float((index >> 1u)) * 4.0) - 1.0), 0.0, 1.0);
    return;
}

