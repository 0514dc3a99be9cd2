//! Loops that are plain Rust, compiled for every level.

use super::{Kind, Simd, portable::Portable};
#[cfg(target_arch = "x86_64")]
use super::{avx2::Avx2, avx512::Avx512};
use crate::math::{Loop, Runner};

impl Runner for Portable {
    #[inline]
    fn run(self, task: impl Loop) {
        task.run();
    }
}

#[cfg(target_arch = "x86_64")]
impl Runner for Avx2 {
    #[inline]
    fn run(self, task: impl Loop) {
        #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
        fn avx2(task: impl Loop) {
            task.run();
        }
        // SAFETY: the value exists only where the processor has the instructions.
        unsafe { avx2(task) };
    }
}

#[cfg(target_arch = "x86_64")]
impl Runner for Avx512 {
    #[inline]
    fn run(self, task: impl Loop) {
        #[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
        fn avx512(task: impl Loop) {
            task.run();
        }
        // SAFETY: the value exists only where the processor has the instructions.
        unsafe { avx512(task) };
    }
}

impl Runner for Simd {
    /// With this level's instructions.
    #[inline]
    fn run(self, task: impl Loop) {
        match self.0 {
            Kind::Portable => Portable.run(task),
            #[cfg(target_arch = "x86_64")]
            // SAFETY: the value exists only where the processor has the instructions.
            Kind::Avx2 => unsafe { Avx2::new() }.run(task),
            #[cfg(target_arch = "x86_64")]
            // SAFETY: the value exists only where the processor has the instructions.
            Kind::Avx512 => unsafe { Avx512::new() }.run(task),
        }
    }
}
