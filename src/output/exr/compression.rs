//! Compression methods of EXR files.

/// A compression method for blocks of lines. All but DWAA are lossless.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Compression {
    None,
    /// Runs of equal bytes, a line at a time.
    Rle,
    /// Deflate, a line at a time: what compositors read fastest.
    #[default]
    Zips,
    /// Deflate, 16 lines at a time: smaller.
    Zip,
    /// Wavelets and Huffman codes, 32 lines at a time: small where pictures are noisy.
    Piz,
    /// Cosine transforms, 32 lines at a time: lossy, for pictures alone.
    Dwaa,
}

/// The figures of a method.
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

    /// Whether numbers change, so that ids and other data would be ruined.
    pub fn is_lossy(self) -> bool {
        self == Self::Dwaa
    }

    /// The message about a pass of data that a lossy method would change.
    pub fn refusal(self, pass: &str) -> String {
        let name = self.name();
        format!("the compression `{name}` would ruin the data of the pass `{pass}`: use a lossless one, such as `zips`")
    }

    pub(super) fn code(self) -> u8 {
        self.row().code
    }

    pub(super) fn lines_per_block(self) -> u32 {
        self.row().lines_per_block
    }
}
