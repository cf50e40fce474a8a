//! Loops on the processor's widest vectors.

/// Calls `f` compiled for AVX-512 or AVX2 where this processor has it (feature `simd`), or as it is: that is with SSE2 or NEON.
///
/// `f` and what it calls are compiled once an instruction set where they are `#[inline(always)]`: plain loops over arrays,
/// which compilers turn into vector instructions. No multiplication is fused with an addition, so the results are the
/// same bytes everywhere.
#[inline(always)]
pub(crate) fn vectorised<R>(f: impl FnOnce() -> R) -> R {
    #[cfg(feature = "simd")]
    {
        use fearless_simd::{Level, Simd};
        match Level::new().as_avx2() {
            Some(simd) => simd.vectorize(f),
            None => f(),
        }
    }
    #[cfg(not(feature = "simd"))]
    f()
}
