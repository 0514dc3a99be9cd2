//! Loops that are plain Rust, compiled for every level.

use super::{Kind, Simd};
use crate::math::{Loop, Runner};

impl Runner for Simd {
    /// With this level's instructions.
    #[inline]
    fn run(self, task: impl Loop) {
        #[cfg(target_arch = "x86_64")]
        #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
        fn avx2(task: impl Loop) {
            task.run();
        }
        #[cfg(target_arch = "x86_64")]
        #[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
        fn avx512(task: impl Loop) {
            task.run();
        }
        match self.0 {
            Kind::Portable => task.run(),
            #[cfg(target_arch = "x86_64")]
            // SAFETY: the value exists only where the processor has the instructions.
            Kind::Avx2 => unsafe { avx2(task) },
            #[cfg(target_arch = "x86_64")]
            // SAFETY: the value exists only where the processor has the instructions.
            Kind::Avx512 => unsafe { avx512(task) },
        }
    }
}
