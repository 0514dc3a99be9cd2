//! Vectors of floats at every level that a processor may have.
//!
//! A kernel is written once, over `lanes::SimdLevel`, and compiled for every level: `portable`, `avx2` (with FMA) and `avx512`
//! (F, VL, DQ, BW). Which one runs is found out at run time ([`Isa`]). All give the same bits as long as no operation that
//! decides about a result is fused.
//!
//! The unsafe code in here uses instructions that [`Isa`] has found.

#[cfg(target_arch = "x86_64")]
pub(crate) mod avx2;
#[cfg(target_arch = "x86_64")]
pub(crate) mod avx512;
#[cfg(target_arch = "x86_64")]
mod compact_table;
pub(crate) mod dispatch;
pub(crate) mod huge_pages;
pub(crate) mod isa;
pub(crate) mod lanes;
mod pair;
pub(crate) mod portable;
mod prefetch;

pub use isa::{Isa, UnknownIsa};
pub use prefetch::prefetch;
