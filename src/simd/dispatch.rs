//! Kernels and vector loops that are compiled for every SIMD level and dispatched at run time.
//!
//! AVX-512 is used without its extensions DQ and BW. Of a comparison that they allow to move to a mask, LLVM 22 makes an
//! instruction that reaches the first sixteen registers alone, whichever register the vector is in: the code would read another
//! one. Windows has few others that a function may use as it likes, and there pictures had wrong pixels. Source:
//! <https://github.com/llvm/llvm-project/issues/191304>.

#[cfg(target_arch = "aarch64")]
use super::neon::Neon;
#[cfg(target_arch = "x86_64")]
use super::{avx2::Avx2, avx512::Avx512};
use super::{
    isa::{Isa, IsaKind},
    portable::Portable,
};
use crate::math::{Dispatch, VectorLoop};

impl Dispatch for Portable {
    #[inline]
    fn dispatch(self, task: impl VectorLoop) {
        task.run();
    }
}

#[cfg(target_arch = "x86_64")]
impl Dispatch for Avx2 {
    #[inline]
    fn dispatch(self, task: impl VectorLoop) {
        #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
        fn avx2(task: impl VectorLoop) {
            task.run();
        }
        // SAFETY: the value exists only where the processor has the instructions.
        unsafe { avx2(task) };
    }
}

#[cfg(target_arch = "x86_64")]
impl Dispatch for Avx512 {
    #[inline]
    fn dispatch(self, task: impl VectorLoop) {
        #[target_feature(enable = "avx512f,avx512vl,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
        fn avx512(task: impl VectorLoop) {
            task.run();
        }
        // SAFETY: the value exists only where the processor has the instructions.
        unsafe { avx512(task) };
    }
}

#[cfg(target_arch = "aarch64")]
impl Dispatch for Neon {
    #[inline]
    fn dispatch(self, task: impl VectorLoop) {
        task.run();
    }
}

impl Dispatch for Isa {
    /// Runs `task` with the instructions of this level.
    #[inline]
    fn dispatch(self, task: impl VectorLoop) {
        match self.kind() {
            IsaKind::Portable => Portable.dispatch(task),
            #[cfg(target_arch = "x86_64")]
            // SAFETY: the value exists only where the processor has the instructions.
            IsaKind::Avx2 => unsafe { Avx2::new() }.dispatch(task),
            #[cfg(target_arch = "x86_64")]
            // SAFETY: the value exists only where the processor has the instructions.
            IsaKind::Avx512 => unsafe { Avx512::new() }.dispatch(task),
            #[cfg(target_arch = "aarch64")]
            IsaKind::Neon => Neon.dispatch(task),
        }
    }
}

/// Declares a kernel: one function per SIMD level, and a public one that dispatches.
macro_rules! kernel {
    (
        $(#[$doc:meta])*
        $name:ident($($arg:ident: $ty:ty),* $(,)?) $(-> $answer:ty)? = |$level:ident| $call:expr
    ) => {
        $(#[$doc])*
        pub fn $name(simd: $crate::simd::Isa, $($arg: $ty),*) $(-> $answer)? {
            #[cfg(target_arch = "x86_64")]
            #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
            fn avx2($($arg: $ty),*) $(-> $answer)? {
                // SAFETY: this function enables the instructions.
                let $level = unsafe { $crate::simd::avx2::Avx2::new() };
                $call
            }
            #[cfg(target_arch = "x86_64")]
            #[target_feature(enable = "avx512f,avx512vl,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
            fn avx512($($arg: $ty),*) $(-> $answer)? {
                // SAFETY: this function enables the instructions.
                let $level = unsafe { $crate::simd::avx512::Avx512::new() };
                $call
            }
            match simd.kind() {
                $crate::simd::isa::IsaKind::Portable => {
                    let $level = $crate::simd::portable::Portable;
                    $call
                }
                #[cfg(target_arch = "x86_64")]
                // SAFETY: the value exists only where the processor has the instructions.
                $crate::simd::isa::IsaKind::Avx2 => unsafe { avx2($($arg),*) },
                #[cfg(target_arch = "x86_64")]
                // SAFETY: the value exists only where the processor has the instructions.
                $crate::simd::isa::IsaKind::Avx512 => unsafe { avx512($($arg),*) },
                #[cfg(target_arch = "aarch64")]
                $crate::simd::isa::IsaKind::Neon => {
                    let $level = $crate::simd::neon::Neon;
                    $call
                }
            }
        }
    };
}

pub(crate) use kernel;
