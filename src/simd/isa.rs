//! Detection and selection of the processor's vector instructions.

use std::{fmt, str::FromStr};

use thiserror::Error;

/// The instruction set that the kernels use.
///
/// A value other than `Portable` exists only if the processor has the instructions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Isa(IsaKind);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum IsaKind {
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
    #[cfg(target_arch = "aarch64")]
    Neon,
}

const NAMES: &[(IsaKind, &str)] = &[
    (IsaKind::Portable, "portable"),
    #[cfg(target_arch = "x86_64")]
    (IsaKind::Avx2, "avx2"),
    #[cfg(target_arch = "x86_64")]
    (IsaKind::Avx512, "avx512"),
    #[cfg(target_arch = "aarch64")]
    (IsaKind::Neon, "neon"),
];

/// The name of a SIMD level is unknown, or this processor does not have the level.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("no such SIMD level on this processor: `{name}` (there are {available})")]
pub struct UnknownIsa {
    name: String,
    available: String,
}

impl IsaKind {
    fn is_available(self) -> bool {
        match self {
            Self::Portable => true,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => ["avx2", "fma", "bmi1", "bmi2", "lzcnt", "popcnt"]
                .iter()
                .all(|name| detected(name)),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => Self::Avx2.is_available() && ["avx512f", "avx512vl"].iter().all(|name| detected(name)),
            #[cfg(target_arch = "aarch64")]
            Self::Neon => true,
        }
    }
}

/// Calls `is_x86_feature_detected` for a name that is not a literal.
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
        _ => false,
    }
}

impl Isa {
    /// Returns the levels that this processor has, in ascending order.
    pub fn available() -> Vec<Self> {
        NAMES
            .iter()
            .filter(|row| row.0.is_available())
            .map(|row| Self(row.0))
            .collect()
    }

    /// Returns the best level that this processor has.
    pub fn best() -> Self {
        *Self::available().last().expect("the portable level is always there")
    }
}

/// The best level that this processor has.
impl Default for Isa {
    fn default() -> Self {
        Self::best()
    }
}

impl FromStr for Isa {
    type Err = UnknownIsa;

    /// Parses the name of a level. Fails if this processor does not have the level.
    fn from_str(name: &str) -> Result<Self, UnknownIsa> {
        let available = Self::available();
        let found = available.iter().find(|simd| simd.name() == name);
        found.copied().ok_or_else(|| UnknownIsa {
            name: name.to_owned(),
            available: available.iter().map(|simd| simd.name()).collect::<Vec<_>>().join(", "),
        })
    }
}

impl Isa {
    pub(crate) fn kind(self) -> IsaKind {
        self.0
    }

    pub fn name(self) -> &'static str {
        let row = NAMES.iter().find(|row| row.0 == self.0);
        row.expect("the table lists every level").1
    }
}

impl fmt::Display for Isa {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}
