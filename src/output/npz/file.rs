//! Files of arrays.

use std::{
    fs::File,
    io::{self, BufReader, Write},
    path::Path,
};

use super::{
    array::Array,
    zip::{self, Archive, Member},
};
use crate::output::{EncodeError, NpzCompression, facts, seal};

/// Writes a file with these arrays, of which the first is the metadata; returns its size.
pub(super) fn write(arrays: Vec<Array>, compression: NpzCompression, out: &mut dyn Write) -> Result<u64, EncodeError> {
    let members: Vec<Member> = arrays.into_iter().map(Array::into_member).collect();
    zip::write(&members, &seal::attribute(), compression, out)
}

/// Opens the file at `path`.
pub(super) fn open(path: &Path) -> io::Result<Archive<BufReader<File>>> {
    Archive::open(BufReader::new(facts::open(path)?))
}
