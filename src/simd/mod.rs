//! Vectors of floats for every SIMD level.
//!
//! A kernel is written once, over `lanes::SimdLevel`, and compiled for every level: `portable`,
//! `avx2` (with FMA) and `avx512` (F, VL) of x86-64, and `neon` of 64-bit ARM. The level is detected at run time ([`Isa`]). All
//! levels give the same bits if no operation that affects a result is fused.
//!
//! The unsafe code in this module uses only instructions that [`Isa`] has detected.

#[cfg(target_arch = "x86_64")]
pub(crate) mod avx2;
#[cfg(target_arch = "x86_64")]
pub(crate) mod avx512;
#[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
mod compact_table;
pub(crate) mod dispatch;
pub(crate) mod huge_pages;
pub(crate) mod isa;
pub(crate) mod lanes;
#[cfg(target_arch = "aarch64")]
pub(crate) mod neon;
mod pair;
pub(crate) mod portable;
mod prefetch;

pub use isa::{Isa, UnknownIsa};
pub use prefetch::prefetch;
