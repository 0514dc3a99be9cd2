//! Large pages for large arrays.
//!
//! A ray that has nothing in common with its neighbours touches a new page at nearly every step; with pages of 4 KiB each
//! of those looks up where it lies. Linux gives pages of 2 MiB to memory that asks for them.

/// Bytes of a small page.
pub const PAGE: usize = 4096;

/// Room for `len` values in large pages where the system has them. The memory is not touched yet.
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
        // SAFETY: whole pages inside memory that the vector owns; the advice changes no content. Where the system does
        // not follow it nothing is different, so the answer does not matter.
        unsafe { madvise(start as *mut _, (end - start) / PAGE * PAGE, MADV_HUGEPAGE) };
    }
}
