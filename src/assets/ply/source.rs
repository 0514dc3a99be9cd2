//! Readers of the numbers of a PLY file.

use super::header::NumberType;
use crate::assets::repair::is_not_finite;

/// The reason why there is no next number.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Stop {
    /// The data ends.
    End,
    /// A word is no number.
    NoNumber(String),
}

/// The data after a header.
pub(super) trait Source {
    fn number(&mut self, number: NumberType) -> Result<f64, Stop>;
    fn skip(&mut self, number: NumberType, count: usize) -> Result<(), Stop>;
    fn bytes_left(&self) -> usize;
}

/// The order of the bytes of a number.
pub(super) trait ByteOrder {
    fn number(number: NumberType, bytes: [u8; 8]) -> f64;
}

pub(super) struct LittleEndian;
pub(super) struct BigEndian;

macro_rules! byte_order {
    ($Order:ident, $from:ident) => {
        impl ByteOrder for $Order {
            #[inline(always)]
            fn number(number: NumberType, [a, b, c, d, e, f, g, h]: [u8; 8]) -> f64 {
                match number {
                    NumberType::I8 => f64::from(a as i8),
                    NumberType::U8 => f64::from(a),
                    NumberType::I16 => f64::from(i16::$from([a, b])),
                    NumberType::U16 => f64::from(u16::$from([a, b])),
                    NumberType::I32 => f64::from(i32::$from([a, b, c, d])),
                    NumberType::U32 => f64::from(u32::$from([a, b, c, d])),
                    NumberType::F32 => f64::from(f32::$from([a, b, c, d])),
                    NumberType::F64 => f64::$from([a, b, c, d, e, f, g, h]),
                }
            }
        }
    };
}

byte_order!(LittleEndian, from_le_bytes);
byte_order!(BigEndian, from_be_bytes);

/// Binary numbers.
pub(super) struct Binary<'a, O> {
    rest: &'a [u8],
    order: std::marker::PhantomData<O>,
}

impl<'a, O> Binary<'a, O> {
    pub fn new(data: &'a [u8]) -> Self {
        Self {
            rest: data,
            order: std::marker::PhantomData,
        }
    }
}

impl<O: ByteOrder> Source for Binary<'_, O> {
    #[inline(always)]
    fn number(&mut self, number: NumberType) -> Result<f64, Stop> {
        let (own, rest) = self.rest.split_at_checked(number.size()).ok_or(Stop::End)?;
        let mut bytes = [0; 8];
        match self.rest.first_chunk::<8>() {
            Some(whole) => bytes = *whole,
            None => bytes[..own.len()].copy_from_slice(own),
        }
        self.rest = rest;
        Ok(O::number(number, bytes))
    }

    fn skip(&mut self, number: NumberType, count: usize) -> Result<(), Stop> {
        let bytes = number.size().checked_mul(count).ok_or(Stop::End)?;
        (_, self.rest) = self.rest.split_at_checked(bytes).ok_or(Stop::End)?;
        Ok(())
    }

    fn bytes_left(&self) -> usize {
        self.rest.len()
    }
}

/// Numbers as text.
pub(super) struct Text<'a>(pub &'a [u8]);

impl Text<'_> {
    fn word(&mut self) -> Result<&[u8], Stop> {
        let text = self.0.trim_ascii_start();
        let end = text.iter().position(u8::is_ascii_whitespace).unwrap_or(text.len());
        let (word, rest) = text.split_at(end);
        self.0 = rest;
        if word.is_empty() { Err(Stop::End) } else { Ok(word) }
    }
}

impl Source for Text<'_> {
    fn number(&mut self, _: NumberType) -> Result<f64, Stop> {
        let word = self.word()?;
        let number = str::from_utf8(word).ok().and_then(|w| w.parse().ok());
        let number = number.or_else(|| is_not_finite(word).then_some(f64::NAN));
        number.ok_or_else(|| Stop::NoNumber(String::from_utf8_lossy(word).into_owned()))
    }

    fn skip(&mut self, _: NumberType, count: usize) -> Result<(), Stop> {
        (0..count).try_for_each(|_| self.word().map(|_| ()))
    }

    fn bytes_left(&self) -> usize {
        self.0.len()
    }
}
