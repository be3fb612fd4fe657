//! The compiler of NVIDIA takes all kernels, and rounds after each operation.

#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used, reason = "tests")]

use fdem_gpu::kernels::Kernel;
use fdem_gpu::{Cuda, GpuError, compile, devices};

/// Needs the library libnvrtc, and no device.
#[test]
fn kernels_are_compiled_without_contraction() {
    for architecture in [70, 75, 80, 86, 89, 90, 100, 120] {
        let text = compile(architecture, false).unwrap_or_else(|error| panic!("{architecture}: {error}"));
        for kernel in Kernel::ALL {
            assert!(
                text.contains(&format!(".entry {}(", kernel.name())),
                "{architecture}: {}",
                kernel.name()
            );
        }
        // The driver fuses no operation whose rounding is stated.
        assert!(!text.contains("fma."), "{architecture}: fused");
        for operation in ["mul.f64", "add.f64", "sub.f64", "mul.f32", "add.f32", "sub.f32", ".ftz", ".approx"]
        {
            assert!(!text.contains(operation), "{architecture}: {operation} without its rounding");
        }
        assert!(text.contains("mul.rn.f64") && text.contains("add.rn.f64"));
        assert!(text.contains("sqrt.rn.f64") && text.contains("sqrt.rn.f32"));
    }
    assert!(compile(90, true).unwrap().contains("fma.rn.f64"), "this test would find it");
}

/// Kernels that a release ships say of which text they are, and this build has none, or those of its text.
#[test]
fn kernels_are_compiled_to_be_shipped() {
    let text = fdem_gpu::compile_to_ship().unwrap();
    let title = text.lines().next().unwrap();
    assert!(
        title.starts_with("// Kernels of fdem 0.") && title.split(' ').next_back().unwrap().len() == 16,
        "{title}"
    );
    assert!(text.contains(".target sm_70") && !text.contains("fma."), "{title}");
    for kernel in Kernel::ALL {
        assert!(text.contains(&format!(".entry {}(", kernel.name())), "{}", kernel.name());
    }
    assert_eq!(fdem_gpu::has_shipped_kernels(), option_env!("FDEM_PTX").is_some());
}

/// Without a driver there is an error, and no panic.
#[test]
fn a_device_that_is_not_there_is_an_error() {
    match devices() {
        Ok(devices) => {
            let count = devices.len();
            assert_eq!(Cuda::new(count).unwrap_err(), GpuError::NoDevice { number: count, count });
        }
        Err(error) => {
            assert_eq!(error, GpuError::NoDriver);
            assert_eq!(Cuda::new(0).unwrap_err(), GpuError::NoDriver);
        }
    }
}
