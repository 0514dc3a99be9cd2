//! Compression methods of EXR files.

/// A compression method for blocks of lines. All are lossless.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Compression {
    None,
    /// Deflate, a line at a time: what compositors read fastest.
    #[default]
    Zips,
    /// Deflate, 16 lines at a time: smaller.
    Zip,
}

impl Compression {
    pub const ALL: [Self; 3] = [Self::None, Self::Zips, Self::Zip];

    /// The name of the method in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Zips => "zips",
            Self::Zip => "zip",
        }
    }

    /// The compression of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|c| c.name() == name)
    }

    pub(super) fn code(self) -> u8 {
        match self {
            Self::None => 0,
            Self::Zips => 2,
            Self::Zip => 3,
        }
    }

    pub(super) fn lines_per_block(self) -> u32 {
        match self {
            Self::None | Self::Zips => 1,
            Self::Zip => 16,
        }
    }
}
