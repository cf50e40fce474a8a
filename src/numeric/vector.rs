//! Loops on the processor's vectors.

/// Calls `f` compiled for AVX-512 or AVX2 where this processor has it (feature `simd`), or as it is: that is with SSE2 or NEON.
///
/// `f` and what it calls are compiled once an instruction set where they are `#[inline(always)]`: plain loops over arrays,
/// which compilers turn into vector instructions. No multiplication is fused with an addition, so the results are the
/// same bytes everywhere.
#[inline(always)]
pub(crate) fn vectorised<R>(f: impl FnOnce() -> R) -> R {
    #[cfg(all(feature = "simd", target_arch = "x86_64"))]
    {
        use fearless_simd::{Level, Simd};
        if let Some(simd) = Level::new().as_avx512() {
            return simd.vectorize(f);
        }
    }
    vectorised_by_half(f)
}

/// As [`vectorised`], but for AVX2 even where there is AVX-512: for loops of loads at places that are not side by side, for
/// which compilers take the places from vectors there, at twice the cost.
#[inline(always)]
pub(crate) fn vectorised_by_half<R>(f: impl FnOnce() -> R) -> R {
    #[cfg(all(feature = "simd", target_arch = "x86_64"))]
    {
        use fearless_simd::{Level, Simd};
        if let Some(simd) = Level::new().as_avx2() {
            return simd.vectorize(f);
        }
    }
    f()
}
