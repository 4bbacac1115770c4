//! Which vectors of the machine the kernels use: the widest, or fewer where the environment variable
//! [`VARIABLE`] says so. No bit of a result depends on it, which is what it is for: to test that.

use std::sync::OnceLock;

use pulp::Arch;

/// The environment variable that limits them.
pub const VARIABLE: &str = "BEDLOAD_VECTORS";

/// The vectors to use.
pub fn arch() -> Arch {
    static ARCH: OnceLock<Arch> = OnceLock::new();
    *ARCH.get_or_init(|| {
        let wanted = std::env::var(VARIABLE).unwrap_or_default();
        #[cfg(target_arch = "x86_64")]
        match (wanted.as_str(), pulp::x86::V3::try_new()) {
            ("baseline", _) => return Arch::Scalar,
            ("avx2", Some(simd)) => return Arch::V3(simd),
            _ => {}
        }
        let _ = wanted;
        Arch::new()
    })
}

/// Refuses a value of [`VARIABLE`] that is not known.
///
/// # Errors
/// The value, what is allowed, and what to do.
pub fn check() -> Result<(), String> {
    match std::env::var(VARIABLE) {
        Ok(value) if !["baseline", "avx2"].contains(&value.as_str()) => Err(format!(
            "the environment variable {VARIABLE} is {value:?}; allowed: baseline, avx2; leave it out for the widest \
             vectors of this machine"
        )),
        _ => Ok(()),
    }
}
