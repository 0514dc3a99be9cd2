//! ZIP archives: whole members, stored or deflated, without encryption, comments and ZIP64.
//!
//! Stored members begin at multiples of 64 bytes, by a padding in their headers, so that programs may map their numbers. Members
//! have the date 1 January 1980.
//!
//! Source: PKWARE, ".ZIP File Format Specification" (APPNOTE.TXT), version 6.3.10.

use std::{
    borrow::Cow,
    io::{self, Read, Seek, SeekFrom, Write},
};

use crate::{
    math::parallel,
    output::{EncodeError, NpzCompression, counting::Counting},
};
use libdeflater::{CompressionLvl, Compressor, Decompressor};

/// The level of deflate: that of EXR files.
const LEVEL: i32 = 4;
/// The multiple of bytes at which members begin.
pub(super) const ALIGNMENT: usize = 64;
/// The field of a header that pads it, by the number that Android gave it.
const PADDING: u16 = 0xd935;
/// The field with the seal of a file. Its number is this program's own.
const SEAL: u16 = 0x5242;

const STORED: u16 = 0;
const DEFLATED: u16 = 8;
/// The version of the specification that a reader needs to know.
const NEEDED: u16 = 20;
const ON_UNIX: u16 = 3 << 8;
const UTF8: u16 = 1 << 11;
/// The time of day, and the date as years from 1980, months and days.
const TIME: [u16; 2] = [0, (1 << 5) | 1];
/// A regular file that everybody may read.
const MODE: u32 = 0o100_644 << 16;

const LOCAL: u32 = 0x0403_4b50;
const CENTRAL: u32 = 0x0201_4b50;
const END: u32 = 0x0605_4b50;
const LOCAL_LENGTH: usize = 30;
const CENTRAL_LENGTH: usize = 46;
const END_LENGTH: usize = 22;

/// A file in an archive, of two parts.
pub(super) struct Member<'a> {
    pub name: String,
    pub head: Vec<u8>,
    pub data: Cow<'a, [u8]>,
}

/// A member as it is written.
struct Packed<'a> {
    name: &'a str,
    method: u16,
    checksum: u32,
    size: u32,
    parts: [Cow<'a, [u8]>; 2],
}

impl Member<'_> {
    fn pack(&self, compression: NpzCompression) -> Result<Packed<'_>, EncodeError> {
        let size = self.head.len() + self.data.len();
        let mut checksum = crc32fast::Hasher::new();
        checksum.update(&self.head);
        checksum.update(&self.data);
        let stored = Packed {
            name: &self.name,
            method: STORED,
            checksum: checksum.finalize(),
            size: size_32(size as u64)?,
            parts: [Cow::Borrowed(&self.head), Cow::Borrowed(&self.data)],
        };
        if compression == NpzCompression::None {
            return Ok(stored);
        }
        let mut compressor = Compressor::new(CompressionLvl::new(LEVEL).unwrap_or_default());
        // The compressor fails if the result is not smaller than this buffer.
        let mut packed = vec![0; size.saturating_sub(1)];
        match compressor.deflate_compress(&[&self.head, &*self.data].concat(), &mut packed) {
            Ok(length) => {
                packed.truncate(length);
                Ok(Packed {
                    method: DEFLATED,
                    parts: [Cow::Owned(packed), Cow::Borrowed(&[])],
                    ..stored
                })
            }
            Err(_) => Ok(stored),
        }
    }
}

impl Packed<'_> {
    /// The part that the headers of a member share, from the needed version to the size.
    fn facts(&self) -> Result<Vec<u8>, EncodeError> {
        let length: usize = self.parts.iter().map(|part| part.len()).sum();
        let flags = if self.name.is_ascii() { 0 } else { UTF8 };
        let [time, date] = TIME;
        let mut bytes = [NEEDED, flags, self.method, time, date].map(u16::to_le_bytes).concat();
        let sizes = [self.checksum, size_32(length as u64)?, self.size];
        bytes.extend(sizes.map(u32::to_le_bytes).as_flattened());
        bytes.extend(name_length(self.name)?.to_le_bytes());
        Ok(bytes)
    }
}

/// Writes an archive, and returns its size. The first member's header has the field `seal`.
///
/// # Errors
/// The archive is larger than the format allows, or `out` fails.
pub(super) fn write(
    members: &[Member],
    seal: &[u8],
    compression: NpzCompression,
    out: &mut dyn Write,
) -> Result<u64, EncodeError> {
    let packed = parallel::map(members, |member| member.pack(compression));
    let packed: Vec<Packed> = packed.into_iter().collect::<Result<_, _>>()?;
    let mut out = Counting { out, bytes: 0 };
    let mut directory = Vec::new();
    for (i, member) in packed.iter().enumerate() {
        let (offset, facts) = (size_32(out.bytes)?, member.facts()?);
        let mut fields = Vec::new();
        if i == 0 {
            put_field(&mut fields, SEAL, seal);
        }
        let before = offset as usize + LOCAL_LENGTH + member.name.len() + fields.len();
        fields.extend(padding(before));
        out.write_all(&LOCAL.to_le_bytes())?;
        out.write_all(&facts)?;
        out.write_all(&(fields.len() as u16).to_le_bytes())?;
        out.write_all(member.name.as_bytes())?;
        out.write_all(&fields)?;
        member.parts.iter().try_for_each(|part| out.write_all(part))?;

        directory.extend(CENTRAL.to_le_bytes());
        directory.extend((ON_UNIX | NEEDED).to_le_bytes());
        directory.extend(&facts);
        // No fields, no comment, the first disk, and nothing about its text.
        directory.extend([0; 8]);
        directory.extend(MODE.to_le_bytes());
        directory.extend(offset.to_le_bytes());
        directory.extend(member.name.as_bytes());
    }
    let (start, count) = (size_32(out.bytes)?, packed.len() as u16);
    out.write_all(&directory)?;
    out.write_all(&END.to_le_bytes())?;
    out.write_all(&[0, 0, count, count].map(u16::to_le_bytes).concat())?;
    out.write_all(&[directory.len() as u32, start].map(u32::to_le_bytes).concat())?;
    out.write_all(&[0; 2])?;
    Ok(out.bytes)
}

/// A size or a place, which have 32 bits.
fn size_32(size: u64) -> Result<u32, EncodeError> {
    u32::try_from(size).map_err(|_| {
        EncodeError::Unfit("an NPZ file is smaller than 4 GB; write fewer passes, or EXR files".to_owned())
    })
}

fn name_length(name: &str) -> Result<u16, EncodeError> {
    u16::try_from(name.len()).map_err(|_| EncodeError::Unfit(format!("a name of {} bytes", name.len())))
}

fn put_field(fields: &mut Vec<u8>, id: u16, data: &[u8]) {
    fields.extend(id.to_le_bytes());
    fields.extend((data.len() as u16).to_le_bytes());
    fields.extend(data);
}

/// The field after which a member's data are aligned, if they follow `before` bytes without it.
fn padding(before: usize) -> Vec<u8> {
    const LEAST: usize = 6;
    let length = (before + LEAST).next_multiple_of(ALIGNMENT) - before;
    let mut data = vec![0; length - 4];
    data[..2].copy_from_slice(&(ALIGNMENT as u16).to_le_bytes());
    let mut field = Vec::new();
    put_field(&mut field, PADDING, &data);
    field
}

/// An archive that is read.
pub(super) struct Archive<R> {
    file: R,
    pub members: Vec<Listed>,
}

/// A member in the directory of an archive.
pub(super) struct Listed {
    pub name: String,
    method: u16,
    checksum: u32,
    packed: u32,
    size: u32,
    offset: u32,
}

impl Listed {
    pub fn is_deflated(&self) -> bool {
        self.method == DEFLATED
    }

    /// The size of its unpacked bytes.
    pub fn size(&self) -> usize {
        self.size as usize
    }
}

impl<R: Read + Seek> Archive<R> {
    /// Reads the directory of an archive, which ends where the file does.
    ///
    /// # Errors
    /// The file cannot be read, or is no such archive.
    pub fn open(mut file: R) -> io::Result<Self> {
        let length = file.seek(SeekFrom::End(0))?;
        file.seek(SeekFrom::End(-(END_LENGTH as i64)))?;
        let mut end = [0; END_LENGTH];
        file.read_exact(&mut end)?;
        let (count, size, start) = (u16_at(&end, 10), u32_at(&end, 12), u32_at(&end, 16));
        if u32_at(&end, 0) != END || u64::from(start) + u64::from(size) + END_LENGTH as u64 != length {
            return Err(broken("it has no directory at its end"));
        }
        let mut bytes = vec![0; size as usize];
        file.seek(SeekFrom::Start(start.into()))?;
        file.read_exact(&mut bytes)?;
        let (mut members, mut rest) = (Vec::new(), &bytes[..]);
        while !rest.is_empty() {
            let (member, after) = Listed::parse(rest).ok_or_else(|| broken("its directory is broken"))?;
            members.push(member);
            rest = after;
        }
        if members.len() != usize::from(count) {
            return Err(broken("its directory is incomplete"));
        }
        Ok(Self { file, members })
    }

    /// The bytes of a member, which has `members[index]`.
    ///
    /// # Errors
    /// It cannot be read, or its bytes do not fit its checksum.
    pub fn read(&mut self, index: usize) -> io::Result<Vec<u8>> {
        /// The largest ratio of deflate.
        const MOST_TIMES: u64 = 1032;
        let member = &self.members[index];
        self.file.seek(SeekFrom::Start(member.offset.into()))?;
        let mut head = [0; LOCAL_LENGTH];
        self.file.read_exact(&mut head)?;
        let skipped = i64::from(u16_at(&head, 26)) + i64::from(u16_at(&head, 28));
        let start = self.file.seek(SeekFrom::Current(skipped))?;
        let length = self.file.seek(SeekFrom::End(0))?;
        let (packed, size) = (u64::from(member.packed), u64::from(member.size));
        let fits = start + packed <= length && size <= packed.saturating_mul(MOST_TIMES);
        if u32_at(&head, 0) != LOCAL || !fits {
            return Err(broken("a member is cut off"));
        }
        self.file.seek(SeekFrom::Start(start))?;
        let mut bytes = vec![0; member.packed as usize];
        self.file.read_exact(&mut bytes)?;
        match member.method {
            STORED if packed == size => {}
            DEFLATED => {
                let mut unpacked = vec![0; member.size as usize];
                let done = Decompressor::new().deflate_decompress(&bytes, &mut unpacked);
                if done.ok() != Some(unpacked.len()) {
                    return Err(broken("a member cannot be unpacked"));
                }
                bytes = unpacked;
            }
            _ => return Err(broken("the compression of a member is not known")),
        }
        match crc32fast::hash(&bytes) == member.checksum {
            true => Ok(bytes),
            false => Err(broken("a member does not fit its checksum")),
        }
    }
}

impl Listed {
    /// Reads an entry of a directory; returns what follows it.
    fn parse(bytes: &[u8]) -> Option<(Self, &[u8])> {
        let (head, rest) = bytes.split_at_checked(CENTRAL_LENGTH)?;
        let [name, field, comment] = [28, 30, 32].map(|at| usize::from(u16_at(head, at)));
        let (name, rest) = rest.split_at_checked(name)?;
        let member = Self {
            name: str::from_utf8(name).ok()?.to_owned(),
            method: u16_at(head, 10),
            checksum: u32_at(head, 16),
            packed: u32_at(head, 20),
            size: u32_at(head, 24),
            offset: u32_at(head, 42),
        };
        (u32_at(head, 0) == CENTRAL).then_some((member, rest.get(field + comment..)?))
    }
}

fn broken(reason: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, reason)
}

fn u16_at(bytes: &[u8], at: usize) -> u16 {
    u16::from_le_bytes([bytes[at], bytes[at + 1]])
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from(u16_at(bytes, at)) | u32::from(u16_at(bytes, at + 2)) << 16
}
