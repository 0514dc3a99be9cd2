//! Compression methods of EXR files.

use crate::kind::named;

named! {
    /// A compression method for blocks of lines. All but DWAA are lossless.
    #[derive(Default)]
    pub enum Compression: "compression" {
        None = "none",
        /// Runs of equal bytes, a line at a time.
        Rle = "rle",
        /// Deflate, a line at a time: compositors read it fastest.
        #[default]
        Zips = "zips",
        /// Deflate, 16 lines at a time: smaller.
        Zip = "zip",
        /// Wavelets and Huffman codes, 32 lines at a time: smallest for noisy pictures.
        Piz = "piz",
        /// Cosine transforms, 32 lines at a time: lossy, for pictures only.
        Dwaa = "dwaa",
    }
}

impl Compression {
    /// Whether it changes numbers, which would destroy ids and other data.
    pub fn is_lossy(self) -> bool {
        self == Self::Dwaa
    }

    /// The error message for a pass of data that a lossy method would change.
    pub fn refusal(self, pass: &str) -> String {
        format!("the compression `{self}` would ruin the data of the pass `{pass}`: use a lossless one, such as `zips`")
    }

    /// Its number in files.
    pub(super) fn code(self) -> u8 {
        match self {
            Self::None => 0,
            Self::Rle => 1,
            Self::Zips => 2,
            Self::Zip => 3,
            Self::Piz => 4,
            Self::Dwaa => 8,
        }
    }

    pub(super) fn lines_per_block(self) -> u32 {
        match self {
            Self::None | Self::Rle | Self::Zips => 1,
            Self::Zip => 16,
            Self::Piz | Self::Dwaa => 32,
        }
    }
}
