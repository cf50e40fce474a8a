//! Sizes of blocks: fixed when compiled where they are common, known at run time otherwise.

/// The number of columns of a block.
pub(super) trait Width: Copy + Send + Sync {
    /// The number.
    fn get(self) -> usize;
}

/// A width that the compiler knows; loops over it are unrolled.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fixed<const N: usize>;

impl<const N: usize> Width for Fixed<N> {
    #[inline(always)]
    fn get(self) -> usize {
        N
    }
}

/// Any width.
#[derive(Clone, Copy, Debug)]
pub(super) struct Runtime(pub(super) usize);

impl Width for Runtime {
    #[inline(always)]
    fn get(self) -> usize {
        self.0
    }
}
