//! The requirements on a graphics card, and its errors.

/// Storage buffers that a stage reads.
const STORAGE_BUFFERS: u32 = 4;

/// Why a card does not draw.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GpuError {
    /// The device has too few storage buffers for the shaders.
    #[error("the graphics device gives a shader {0} storage buffers; expected at least {STORAGE_BUFFERS}")]
    NoStorage(u32),
    /// More than the card accepts.
    #[error("{what} of {size} is too large for the graphics device; expected at most {most}")]
    TooLarge {
        /// What is too large: `a side`, in pixels, `a buffer`, in bytes, or `a number of lamps`.
        what: &'static str,
        /// How large it is.
        size: u64,
        /// How large it may be.
        most: u64,
    },
    /// The driver refused or failed.
    #[error("the graphics driver failed: {0}")]
    Driver(String),
}

/// What to ask of a device on which [`Gpu`](super::Gpu) is to draw: all that `adapter` has. Defaults may leave out
/// storage buffers, as eframe's do on OpenGL.
#[must_use]
pub fn limits(adapter: &wgpu::Adapter) -> wgpu::Limits {
    adapter.limits()
}

/// Whether `device` has what the shaders read.
pub(super) fn check(device: &wgpu::Device) -> Result<(), GpuError> {
    let buffers = device.limits().max_storage_buffers_per_shader_stage;
    if buffers < STORAGE_BUFFERS { Err(GpuError::NoStorage(buffers)) } else { Ok(()) }
}

/// The result of `make`; an error, not a panic, if the device refuses it.
pub(super) fn guarded<T>(device: &wgpu::Device, make: impl FnOnce() -> T) -> Result<T, GpuError> {
    let filters = [wgpu::ErrorFilter::Internal, wgpu::ErrorFilter::OutOfMemory, wgpu::ErrorFilter::Validation];
    let mut scopes = filters.map(|filter| Some(device.push_error_scope(filter)));
    let made = make();
    let mut fault = None;
    for scope in scopes.iter_mut().rev().filter_map(Option::take) {
        fault = pollster::block_on(scope.pop()).or(fault);
    }
    match fault {
        Some(fault) => Err(GpuError::Driver(fault.to_string())),
        None => Ok(made),
    }
}
