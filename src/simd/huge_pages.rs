//! Huge pages for large arrays.
//!
//! An incoherent ray touches a new page at nearly every step, and with pages of 4 KiB each of these
//! accesses misses the TLB. Linux backs memory with pages of 2 MiB on request.

/// The size of a small page, in bytes.
pub const PAGE: usize = 4096;

/// Returns a vector with capacity for `len` values, in huge pages if the system supports them. The
/// memory is not touched yet.
pub fn reserve<T>(len: usize) -> Vec<T> {
    let vec = Vec::with_capacity(len);
    #[cfg(target_os = "linux")]
    advise(&vec);
    vec
}

#[cfg(target_os = "linux")]
fn advise<T>(vec: &Vec<T>) {
    const LARGE_PAGE: usize = 2 << 20;
    const MADV_HUGEPAGE: i32 = 14;
    unsafe extern "C" {
        fn madvise(address: *mut std::ffi::c_void, length: usize, advice: i32) -> i32;
    }
    let start = (vec.as_ptr() as usize).next_multiple_of(PAGE);
    let end = vec.as_ptr() as usize + vec.capacity() * size_of::<T>();
    if end > start && end - start >= LARGE_PAGE {
        // SAFETY: the range consists of whole pages of the vector's own memory, and the advice does
        // not change their content. A failure has no effect, so the result is ignored.
        unsafe { madvise(start as *mut _, (end - start) / PAGE * PAGE, MADV_HUGEPAGE) };
    }
}
