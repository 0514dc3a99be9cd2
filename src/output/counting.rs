//! A writer that counts.

use std::io::{self, Write};

/// Passes bytes on and counts them.
pub(super) struct Counting<'a> {
    pub out: &'a mut dyn Write,
    pub bytes: u64,
}

impl Write for Counting<'_> {
    fn write(&mut self, buf: &[u8]) -> io::Result<usize> {
        let n = self.out.write(buf)?;
        self.bytes += n as u64;
        Ok(n)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}
