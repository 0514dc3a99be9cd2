//! Prefetching.

/// Prefetches the cache line of `slice[i]`, if the element exists.
///
/// The memory accesses of rays are random; with prefetching, many of them are in progress at once.
#[inline]
pub fn prefetch<T>(slice: &[T], i: usize) {
    if let Some(element) = slice.get(i) {
        prefetch_line(std::ptr::from_ref(element).cast());
    }
}

/// Prefetches the cache line at `p`, on processors that have an instruction for it.
#[inline(always)]
pub fn prefetch_line(p: *const u8) {
    // Miri knows no prefetches.
    if cfg!(miri) {
        return;
    }
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: a prefetch of any address is valid, and every x86-64 processor has it.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(p.cast()) };
    }
    #[cfg(target_arch = "aarch64")]
    // SAFETY: a prefetch of any address is valid.
    unsafe {
        std::arch::asm!("prfm pldl1keep, [{0}]", in(reg) p, options(nostack, preserves_flags, readonly));
    }
    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    let _ = p;
}
