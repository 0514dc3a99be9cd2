//! Compression methods of EXR files.

<<<<<<< HEAD
use crate::kind::named;

named! {
    /// A compression method for blocks of lines. All but DWAA are lossless.
    #[derive(Default)]
    pub enum Compression: "compression" {
        None = "none",
        /// Runs of equal bytes, a line at a time.
        Rle = "rle",
        /// Deflate, a line at a time: what compositors read fastest.
        #[default]
        Zips = "zips",
        /// Deflate, 16 lines at a time: smaller.
        Zip = "zip",
        /// Wavelets and Huffman codes, 32 lines at a time: small where pictures are noisy.
        Piz = "piz",
        /// Cosine transforms, 32 lines at a time: lossy, for pictures alone.
        Dwaa = "dwaa",
    }
}

impl Compression {
    /// Whether numbers change, so that ids and other data would be ruined.
=======
/// A compression method for blocks of lines. All but DWAA are lossless.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Compression {
    None,
    /// Runs of equal bytes, a line at a time.
    Rle,
    /// Deflate, a line at a time: compositors read it fastest.
    #[default]
    Zips,
    /// Deflate, 16 lines at a time: smaller.
    Zip,
    /// Wavelets and Huffman codes, 32 lines at a time: smallest for noisy pictures.
    Piz,
    /// Cosine transforms, 32 lines at a time: lossy, for pictures only.
    Dwaa,
}

/// The properties of a method.
struct Row {
    name: &'static str,
    /// Its number in files.
    code: u8,
    lines_per_block: u32,
}

impl Compression {
    pub const ALL: [Self; 6] = [Self::None, Self::Rle, Self::Zips, Self::Zip, Self::Piz, Self::Dwaa];

    fn row(self) -> Row {
        let row = |name, code, lines_per_block| Row {
            name,
            code,
            lines_per_block,
        };
        match self {
            Self::None => row("none", 0, 1),
            Self::Rle => row("rle", 1, 1),
            Self::Zips => row("zips", 2, 1),
            Self::Zip => row("zip", 3, 16),
            Self::Piz => row("piz", 4, 32),
            Self::Dwaa => row("dwaa", 8, 32),
        }
    }

    /// The name of the method in scene files.
    pub fn name(self) -> &'static str {
        self.row().name
    }

    /// The names of all methods.
    pub fn names() -> impl Iterator<Item = &'static str> {
        Self::ALL.into_iter().map(Self::name)
    }

    /// The compression of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|c| c.name() == name)
    }

    /// Whether it changes numbers, which would destroy ids and other data.
>>>>>>> 0e60126 (render, output, film: use plain words in comments)
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
