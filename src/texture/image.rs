//! An image from a file.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `file` | path of a PNG, JPEG, BMP, TGA, WebP, HDR or EXR file, relative to the scene file | | required |
//! | `color_space` | `"srgb"`, or `"raw"` for data: the values are used as they are. HDR and EXR are always linear | | `"srgb"` |
//! | `filter` | `"trilinear"`, `"linear"` or `"nearest"` | | `"trilinear"` |
//! | `wrap` | `"repeat"`, `"clamp"`, `"mirror"` or `"black"` | | `"repeat"` |
//!
//! ```toml
//! [texture.bricks]
//! image = { file = "bricks.png", filter = "nearest" }
//! ```
//!
//! The coordinate s runs to the right, and t = 0 is the bottom of the image. The texel (i, j) covers s from i/width to
//! (i+1)/width. `nearest` takes the texel that contains the point; `linear` interpolates the four nearest texel centres at
//! full resolution, at any distance.
//!
//! `trilinear` looks like `linear` from nearby. From afar it averages the texels that a pixel covers, by mip maps. A surface
//! at a grazing angle is looked up in up to 8 pieces along the footprint of the pixel; where that is not enough, the texture
//! is blurred. Beyond an edge of a picture with `clamp` or `black` it averages what is there. The light of a lamp on other surfaces
//! is that of `linear`.
//!
//! Where alpha is the opacity of a material, the colours of texels count by it: what is transparent has no colour. The colours of
//! an EXR file are premultiplied, as in OpenEXR, and have the primaries that the file names by `colorInteropID` (a linear space) or
//! `chromaticities`, else those of Rec. 709; with `color_space = "raw"` they stay as they are. What a material reads as data is
//! never converted. Of an EXR file with several layers the one is shown that is named as light is: without a name, `rgba`,
//! `beauty`, `combined`, `color`. Colours below 0 count as 0, with a warning.
//!
//! # Implementation
//!
//! The width of the ray's footprint, in texels, selects two levels of the mip map, see [`super::mipmap`]. The footprint is
//! that of the ray's cone, see [`crate::math::cone`]; the samples of a pixel share the pixel's area.

use serde::Deserialize;

use super::{
    Bitmap, BitmapId, FindSources, Lookup, PatternKind, Textures,
    bitmap::ColorSpace,
    footprint::{Footprint, MAX_PROBES},
    source::channel_of,
};
use crate::{
    math::{DVec2, Rgb, Vec2, exponential, float},
    value::{Channel, Problem, Spanned},
};

/// The interpolation of texels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TextureFilter {
    /// Linear, in smaller copies of the picture where it is far away.
    #[default]
    Trilinear,
    Linear,
    Nearest,
}

/// The largest number of pieces of the part of a footprint beyond an edge of the picture, which sees one row or column of texels.
const MAX_EDGE_PROBES: u32 = 64;

/// The colour outside of the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Wrap {
    #[default]
    Repeat,
    Clamp,
    Mirror,
    Black,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ImageDesc {
    pub file: Spanned<String>,
    #[serde(default)]
    pub color_space: ColorSpace,
    #[serde(default)]
    pub filter: TextureFilter,
    #[serde(default)]
    pub wrap: Wrap,
}

impl ImageDesc {
    pub fn compile(&self, find: &FindSources<'_>) -> Result<ImagePattern, Problem> {
        Ok(ImagePattern {
            bitmap: (find.bitmap)(self)?,
            filter: self.filter,
            wrap: [self.wrap; 2],
        })
    }
}

#[derive(Clone, Copy, Debug)]
pub struct ImagePattern {
    pub bitmap: BitmapId,
    pub filter: TextureFilter,
    /// Along s and along t.
    pub wrap: [Wrap; 2],
}

impl Wrap {
    /// The texel that `i` stands for along an axis of `n` texels, `None` where there is none.
    #[inline(always)]
    fn texel(self, i: i64, n: i64) -> Option<u32> {
        if (0..n).contains(&i) {
            return Some(i as u32);
        }
        if self == Self::Repeat && n & (n - 1) == 0 {
            // Most pictures are of such sizes, and a division takes as long as the rest of the look-up.
            return Some((i & (n - 1)) as u32);
        }
        self.texel_outside(i, n)
    }

    /// The length after which it repeats the picture; 0 if it does not.
    fn period(self) -> f64 {
        match self {
            Self::Repeat => 1.0,
            Self::Mirror => 2.0,
            Self::Clamp | Self::Black => 0.0,
        }
    }

    /// The parts of an interval that lie in the picture, before it and behind it, along an axis on which the picture goes from
    /// 0 to 1.
    fn parts(self, middle: f32, length: f32) -> [Part; 3] {
        let part = |middle, length, share| Part { middle, length, share };
        let nothing = part(0.0, 0.0, 0.0);
        // Further away the interval sees the same.
        let near = middle.clamp(-length, 1.0 + length);
        let [low, high] = [near - 0.5 * length, near + 0.5 * length];
        if self.period() > 0.0 || (low >= 0.0 && high <= 1.0) {
            return [part(middle, length, 1.0), nothing, nothing];
        }
        let [from, to] = [low, high].map(|x| x.clamp(0.0, 1.0));
        let inside = part(0.5 * (from + to), to - from, (to - from) / length);
        if self == Self::Black {
            return [inside, nothing, nothing];
        }
        let share = |outside: f32| outside.max(0.0) / length;
        let before = part(0.0, 0.0, share(high.min(0.0) - low));
        let behind = part(1.0, 0.0, share(high - low.max(1.0)));
        [inside, before, behind]
    }

    /// The same outside of the picture.
    #[cold]
    fn texel_outside(self, i: i64, n: i64) -> Option<u32> {
        let inside = match self {
            Self::Repeat => i.rem_euclid(n),
            Self::Clamp => i.clamp(0, n - 1),
            Self::Mirror => {
                let k = i.rem_euclid(2 * n);
                k.min(2 * n - 1 - k)
            }
            Self::Black => return None,
        };
        Some(inside as u32)
    }
}

/// A part of an interval along an axis of a picture.
#[derive(Clone, Copy)]
struct Part {
    /// The middle and the length of what it sees of the picture.
    middle: f32,
    length: f32,
    /// Its share of the interval.
    share: f32,
}

impl ImagePattern {
    /// The four nearest texels of `bitmap`, weighed; black where `st` is not finite.
    #[inline]
    fn linear(&self, bitmap: &Bitmap, st: Vec2) -> Rgb {
        let x = st * Vec2::new(bitmap.width as f32, bitmap.height as f32) - 0.5;
        if !x.is_finite() {
            return Rgb::BLACK;
        }
        let base = Vec2::new(float::floor(x.x), float::floor(x.y));
        let (i, j) = (base.x as i64, base.y as i64);
        let (w, h) = (i64::from(bitmap.width), i64::from(bitmap.height));
        let [across, up] = self.wrap;
        let columns = [across.texel(i, w), across.texel(i.saturating_add(1), w)];
        let rows = [up.texel(j, h), up.texel(j.saturating_add(1), h)];
        bitmap.blend(columns, rows, x - base)
    }

    fn nearest(&self, bitmap: &Bitmap, st: Vec2) -> Rgb {
        let x = st * Vec2::new(bitmap.width as f32, bitmap.height as f32);
        if !x.is_finite() {
            return Rgb::BLACK;
        }
        let (w, h) = (i64::from(bitmap.width), i64::from(bitmap.height));
        let texel = (
            self.wrap[0].texel(x.x.floor() as i64, w),
            self.wrap[1].texel(x.y.floor() as i64, h),
        );
        match texel {
            (Some(i), Some(j)) => bitmap.texel_from_bottom(i, j),
            _ => Rgb::BLACK,
        }
    }

    /// The colour in the copies of the picture above and below `level`.
    #[inline]
    fn between_levels(&self, bitmap: &Bitmap, st: Vec2, level: f32) -> Rgb {
        let lower = float::floor(level);
        let f = level - lower;
        let near = self.linear(bitmap.level(lower as usize), st);
        if f == 0.0 || lower as usize >= bitmap.levels.len() {
            return near;
        }
        near * (1.0 - f) + self.linear(bitmap.level(lower as usize + 1), st) * f
    }

    /// The mean over a footprint around `st`; `look` has the mean over each of its pieces.
    #[inline]
    fn along(footprint: &Footprint, st: Vec2, look: impl Fn(Vec2) -> Rgb) -> Rgb {
        let mut sum = Rgb::BLACK;
        for probe in 0..footprint.probes {
            let along = (probe as f32 + 0.5) / footprint.probes as f32 - 0.5;
            sum += look(st + footprint.long_axis * along);
        }
        sum / footprint.probes as f32
    }

    /// The mean over a square of `width` texels around `st`, of a picture that does not repeat: the part of the square outside
    /// of the picture sees its edge, or black.
    #[cold]
    fn within(&self, bitmap: &Bitmap, st: Vec2, width: f32) -> Rgb {
        if !st.is_finite() {
            return Rgb::BLACK;
        }
        // The share of the square that sees black is left out, so levels need no black around them.
        let inside = Self {
            wrap: self.wrap.map(|w| if w == Wrap::Black { Wrap::Clamp } else { w }),
            ..*self
        };
        let size = Vec2::new(bitmap.width as f32, bitmap.height as f32);
        let lengths = Vec2::splat(width) / size;
        let columns = self.wrap[0].parts(st.x, lengths.x);
        let rows = self.wrap[1].parts(st.y, lengths.y);
        if columns[0].share * rows[0].share == 1.0 {
            return inside.between_levels(bitmap, st, exponential::log2(width));
        }
        let mut sum = Rgb::BLACK;
        for (s, t) in columns.iter().flat_map(|s| rows.iter().map(move |t| (s, t))) {
            let share = s.share * t.share;
            if share == 0.0 {
                continue;
            }
            let sees_edge = s.length == 0.0 || t.length == 0.0;
            let most = if sees_edge { MAX_EDGE_PROBES } else { MAX_PROBES };
            let part = Footprint::of([Vec2::X * s.length, Vec2::Y * t.length], size, most);
            let look = |st| inside.between_levels(bitmap, st, part.level());
            sum += Self::along(&part, Vec2::new(s.middle, t.middle), look) * share;
        }
        sum
    }
}

/// From here on texels have no exact numbers.
const MAX_TEXEL: f32 = (1_u32 << 24) as f32;

/// The largest number of texels that are read for a bound.
const MAX_BOUNDED_TEXELS: f32 = 65_536.0;

impl ImagePattern {
    /// The colour at `st`.
    #[inline]
    fn eval(&self, bitmaps: &[Bitmap], st: Vec2) -> Rgb {
        let bitmap = &bitmaps[self.bitmap.0 as usize];
        match self.filter {
            TextureFilter::Nearest => self.nearest(bitmap, st),
            TextureFilter::Linear | TextureFilter::Trilinear => self.linear(bitmap, st),
        }
    }

    /// The mean over a footprint around `st`, which has this level.
    fn mean(&self, bitmap: &Bitmap, st: Vec2, (footprint, level): (Footprint, f32)) -> Rgb {
        let ends = self.wrap.iter().any(|wrap| wrap.period() == 0.0);
        if ends && footprint.width > 1.0 {
            return Self::along(&footprint, st, |st| self.within(bitmap, st, footprint.width));
        }
        Self::along(&footprint, st, |st| self.between_levels(bitmap, st, level))
    }
}

impl PatternKind for ImagePattern {
    #[inline]
    fn numbers(&self, lookup: &Lookup<'_>) -> Rgb {
        if self.filter != TextureFilter::Trilinear || lookup.is_at_point() {
            return self.eval(lookup.textures.bitmaps, lookup.st());
        }
        let bitmap = &lookup.textures.bitmaps[self.bitmap.0 as usize];
        let size = Vec2::new(bitmap.width as f32, bitmap.height as f32);
        let known = lookup.shared_footprint(size);
        let footprint = known.unwrap_or_else(|| Footprint::with_level(lookup.st_axes(), size));
        self.mean(bitmap, lookup.st(), footprint)
    }

    fn max_value(&self, textures: &Textures<'_>) -> Rgb {
        textures.bitmaps[self.bitmap.0 as usize].max_value()
    }

    fn max_within(&self, textures: &Textures<'_>, corners: [Vec2; 2]) -> Rgb {
        let bitmap = &textures.bitmaps[self.bitmap.0 as usize];
        let size = Vec2::new(bitmap.width as f32, bitmap.height as f32);
        let [low, high] = corners.map(|st| (st * size - 0.5).floor());
        let texels = high - low + 2.0;
        let count = texels.x * texels.y;
        let is_near = low.abs().max_element() < MAX_TEXEL && high.abs().max_element() < MAX_TEXEL;
        // The count may be no number.
        if !(is_near && count <= MAX_BOUNDED_TEXELS) {
            return bitmap.max_value();
        }
        let run = |axis: usize, n: u32| {
            let first = low[axis] as i64;
            let all = first..first + texels[axis] as i64;
            let all = all.filter_map(|i| self.wrap[axis].texel(i, i64::from(n)));
            Some([all.clone().min()?, all.max()? + 1])
        };
        let (Some(columns), Some(rows)) = (run(0, bitmap.width), run(1, bitmap.height)) else {
            return Rgb::BLACK;
        };
        let [across, up] = [columns, rows].map(|[first, end]| end - first);
        if across as f32 * up as f32 > MAX_BOUNDED_TEXELS {
            return bitmap.max_value();
        }
        let rows = (rows[0]..rows[1]).map(|j| bitmap.max_of_row(bitmap.height - 1 - j, columns));
        Rgb::gray(rows.fold(0.0, f32::max))
    }

    fn alpha(&self, lookup: &Lookup<'_>) -> f32 {
        let (bitmap, st) = (&lookup.textures.bitmaps[self.bitmap.0 as usize], lookup.st());
        let (w, h) = (i64::from(bitmap.width), i64::from(bitmap.height));
        let in_texels = st * Vec2::new(bitmap.width as f32, bitmap.height as f32);
        let x = in_texels - 0.5;
        if !bitmap.has_alpha() || !x.is_finite() {
            return 1.0;
        }
        let texel = |i: i64, j: i64| match (self.wrap[0].texel(i, w), self.wrap[1].texel(j, h)) {
            (Some(i), Some(j)) => bitmap.alpha(i, bitmap.height - 1 - j),
            _ => 0.0,
        };
        let (base, f) = (x.floor(), x - x.floor());
        if self.filter == TextureFilter::Nearest {
            let near = in_texels.floor();
            return texel(near.x as i64, near.y as i64);
        }
        let (i, j) = (base.x as i64, base.y as i64);
        let row = |j: i64| texel(i, j) * (1.0 - f.x) + texel(i.saturating_add(1), j) * f.x;
        row(j) * (1.0 - f.y) + row(j.saturating_add(1)) * f.y
    }

    fn all(&self, textures: &Textures<'_>, channel: Channel, test: &dyn Fn(f32) -> bool) -> bool {
        let bitmap = &textures.bitmaps[self.bitmap.0 as usize];
        let number = |x, y| match channel {
            Channel::A if bitmap.has_alpha() => bitmap.alpha(x, y),
            _ => channel_of(bitmap.rgb(x, y), channel),
        };
        (0..bitmap.height).all(|y| (0..bitmap.width).all(|x| test(number(x, y))))
    }

    fn bitmap(&self) -> Option<BitmapId> {
        Some(self.bitmap)
    }

    fn filtered_bitmap(&self) -> Option<BitmapId> {
        (self.filter == TextureFilter::Trilinear).then_some(self.bitmap)
    }

    fn periods(&self) -> DVec2 {
        DVec2::from_array(self.wrap.map(Wrap::period))
    }

    fn steps(&self, textures: &Textures<'_>) -> Vec2 {
        let bitmap = &textures.bitmaps[self.bitmap.0 as usize];
        Vec2::new(bitmap.width as f32, bitmap.height as f32)
    }
}

#[cfg(test)]
mod tests;
