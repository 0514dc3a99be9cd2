//! The kernels of the wide tree, for every processor.
//!
//! Each is written once, over [`lanes::Level`], and compiled for every level: `portable`, `avx2` (with FMA) and `avx512`
//! (F, VL, DQ, BW). Which one runs is found out at run time; the environment variable `BATCH_RENDER_SIMD` forces one. All
//! give the same bits: culling is widened by more than any level rounds ([`super::slab`]), and what decides about hits
//! is the same operations in the same order, none of them fused.
//!
//! All `unsafe` code of the accelerators is in here. It indexes without checks what [`tree::Tree`] has checked, and
//! uses instructions that [`Simd`] has found.

use std::{fmt, str::FromStr};

use super::{Geometry, Hit, UnknownName};
use crate::math::Ray;

mod ahead;
mod analytic;
#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod course;
mod heads;
mod hits;
mod inflight;
mod lanes;
mod loops;
mod nodes;
mod packet;
pub mod pages;
mod pair;
mod portable;
mod query;
mod refit;
mod room;
mod scratch;
mod shaft;
mod sixteen;
mod slot;
#[cfg(target_arch = "x86_64")]
mod together;
mod tree;
mod triangle;
mod umbra;
mod visits;
mod waiting;

pub use ahead::prefetch;
pub use inflight::Pick;
pub use packet::{Order, RAYS as PACKET};
pub use scratch::Scratch;
pub use tree::{Grown, Numbers, Tree};

use portable::Portable;
use query::{Nearest, Occluded};

/// The variable that forces a level.
pub const VARIABLE: &str = "BATCH_RENDER_SIMD";

/// The instructions that the kernels use.
///
/// A value beyond `Portable` exists only where the processor has the instructions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Simd(Kind);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

const NAMES: &[(Kind, &str)] = &[
    (Kind::Portable, "portable"),
    #[cfg(target_arch = "x86_64")]
    (Kind::Avx2, "avx2"),
    #[cfg(target_arch = "x86_64")]
    (Kind::Avx512, "avx512"),
];

impl Kind {
    fn is_available(self) -> bool {
        match self {
            Self::Portable => true,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => ["avx2", "fma", "bmi1", "bmi2", "lzcnt", "popcnt"]
                .iter()
                .all(|name| detected(name)),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => {
                Self::Avx2.is_available()
                    && ["avx512f", "avx512vl", "avx512dq", "avx512bw"]
                        .iter()
                        .all(|n| detected(n))
            }
        }
    }
}

/// `is_x86_feature_detected` for a name that is not a literal.
#[cfg(target_arch = "x86_64")]
fn detected(feature: &str) -> bool {
    match feature {
        "avx2" => is_x86_feature_detected!("avx2"),
        "fma" => is_x86_feature_detected!("fma"),
        "bmi1" => is_x86_feature_detected!("bmi1"),
        "bmi2" => is_x86_feature_detected!("bmi2"),
        "lzcnt" => is_x86_feature_detected!("lzcnt"),
        "popcnt" => is_x86_feature_detected!("popcnt"),
        "avx512f" => is_x86_feature_detected!("avx512f"),
        "avx512vl" => is_x86_feature_detected!("avx512vl"),
        "avx512dq" => is_x86_feature_detected!("avx512dq"),
        "avx512bw" => is_x86_feature_detected!("avx512bw"),
        _ => false,
    }
}

impl Simd {
    /// What this processor has, from the least to the best.
    pub fn available() -> Vec<Self> {
        NAMES
            .iter()
            .filter(|row| row.0.is_available())
            .map(|row| Self(row.0))
            .collect()
    }

    /// What the environment asks for, `None` where it does not.
    pub fn requested() -> Result<Option<Self>, UnknownName> {
        let name = std::env::var_os(VARIABLE).unwrap_or_default();
        if name.is_empty() {
            return Ok(None);
        }
        name.to_string_lossy().parse().map(Some)
    }

    /// What the environment asks for where it can be had, otherwise the best. A program that wants to complain asks
    /// [`Simd::requested`] first.
    pub fn detect() -> Self {
        let requested = Self::requested().ok().flatten();
        requested.unwrap_or_else(|| *Self::available().last().expect("the portable level is always there"))
    }
}

impl FromStr for Simd {
    type Err = UnknownName;

    /// Fails for a level that this processor does not have.
    fn from_str(name: &str) -> Result<Self, UnknownName> {
        let table: Vec<_> = Self::available().into_iter().map(|simd| (simd, simd.name())).collect();
        super::find("SIMD level on this processor", &table, name)
    }
}

impl Simd {
    pub fn name(self) -> &'static str {
        super::name(NAMES, self.0)
    }
}

impl fmt::Display for Simd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// Declares a kernel for every level and the function that picks one.
macro_rules! kernel {
    (
        $(#[$doc:meta])*
        $name:ident($($arg:ident: $ty:ty),* $(,)?) = |$level:ident| $call:expr
    ) => {
        $(#[$doc])*
        pub fn $name(simd: Simd, $($arg: $ty),*) {
            #[cfg(target_arch = "x86_64")]
            #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
            fn avx2($($arg: $ty),*) {
                // SAFETY: the instructions are enabled here.
                let $level = unsafe { avx2::Avx2::new() };
                $call
            }
            #[cfg(target_arch = "x86_64")]
            #[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
            fn avx512($($arg: $ty),*) {
                // SAFETY: the instructions are enabled here.
                let $level = unsafe { avx512::Avx512::new() };
                $call
            }
            match simd.0 {
                Kind::Portable => {
                    let $level = Portable;
                    $call
                }
                #[cfg(target_arch = "x86_64")]
                // SAFETY: the value exists only where the processor has the instructions.
                Kind::Avx2 => unsafe { avx2($($arg),*) },
                #[cfg(target_arch = "x86_64")]
                // SAFETY: the value exists only where the processor has the instructions.
                Kind::Avx512 => unsafe { avx512($($arg),*) },
            }
        }
    };
}

kernel! {
    /// The nearest hits of the picked rays, if nearer than what `hits` has for them already.
    nearest_inflight(
        tree: &Tree,
        geometry: &Geometry,
        rays: &[Ray],
        pick: Pick,
        hits: &mut [Option<Hit>],
        scratch: &mut Scratch,
    ) = |level| if tree.has_instances() {
        inflight::trace::<_, Nearest, true, false>(level, tree, geometry, rays, pick, hits, scratch);
    } else {
        inflight::trace::<_, Nearest, false, false>(level, tree, geometry, rays, pick, hits, scratch);
    }
}

kernel! {
    /// Whether the rays meet anything; those that `blocked` says of are not asked.
    occluded_inflight(
        tree: &Tree,
        geometry: &Geometry,
        rays: &[Ray],
        pick: Pick,
        blocked: &mut [bool],
        scratch: &mut Scratch,
    ) = |level| match pick {
        _ if tree.has_instances() => {
            inflight::trace::<_, Occluded, true, false>(level, tree, geometry, rays, pick, blocked, scratch);
        }
        Pick::Together(_) => {
            inflight::trace::<_, Occluded, false, true>(level, tree, geometry, rays, pick, blocked, scratch);
        }
        _ => inflight::trace::<_, Occluded, false, false>(level, tree, geometry, rays, pick, blocked, scratch),
    }
}

kernel! {
    /// Whether the rays meet anything, as far as that can be said at once; `order` says which start next to one another. Where it
    /// pays, [`Scratch::is_sifted`], and the numbers of the others are left in [`Scratch::left`]. Not for scenes with instances.
    occluded_at_once(
        tree: &Tree,
        rays: &[Ray],
        order: Order,
        blocked: &mut [bool],
        scratch: &mut Scratch,
    ) = |level| umbra::trace(level, tree, rays, order, blocked, scratch)
}

kernel! {
    /// The nearest hits of rays in packets of [`PACKET`], if nearer than what `hits` has for them already; `order` says which
    /// rays make a packet. The numbers of rays that are in none are left in [`Scratch::left`].
    nearest_packets(
        tree: &Tree,
        geometry: &Geometry,
        rays: &[Ray],
        order: Order,
        hits: &mut [Option<Hit>],
        scratch: &mut Scratch,
    ) = |level| packet::trace::<_, Nearest>(level, tree, geometry, rays, order, hits, scratch)
}

kernel! {
    /// The same for whether the rays meet anything; those that `blocked` says of are not asked.
    occluded_packets(
        tree: &Tree,
        geometry: &Geometry,
        rays: &[Ray],
        order: Order,
        blocked: &mut [bool],
        scratch: &mut Scratch,
    ) = |level| packet::trace::<_, Occluded>(level, tree, geometry, rays, order, blocked, scratch)
}
