//! A picture from a file.
//!
//! | key | type | unit | default |
//! |---|---|---|---|
//! | `file` | path of a PNG, JPEG, BMP, TGA, WebP, HDR or EXR file, relative to the scene file | | required |
//! | `color_space` | `"srgb"`, or `"raw"`: the numbers are used as they are | | `"srgb"`; HDR and EXR are always raw |
//! | `filter` | `"linear"` or `"nearest"` | | `"linear"` |
//! | `wrap` | `"repeat"`, `"clamp"`, `"mirror"` or `"black"` | | `"repeat"` |
//!
//! s runs to the right, t = 0 is the bottom of the picture. A texel (i, j) covers s from i/width to (i+1)/width; `nearest`
//! takes the texel that holds the point, `linear` weighs the four nearest centres.
//!
//! ```toml
//! [texture.bricks]
//! image = { file = "bricks.png", filter = "nearest" }
//! ```

use serde::Deserialize;

use super::{Bitmap, BitmapId, FindBitmap, PatternKind, bitmap::ColorSpace};
use crate::{
    math::{Rgb, Vec2},
    value::{Problem, Spanned},
};

/// How texels become a colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Filter {
    #[default]
    Linear,
    Nearest,
}

/// What lies outside the picture.
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
    pub filter: Filter,
    #[serde(default)]
    pub wrap: Wrap,
}

impl ImageDesc {
    pub fn compile(&self, find: &FindBitmap<'_>) -> Result<ImagePattern, Problem> {
        Ok(ImagePattern {
            bitmap: find(self)?,
            filter: self.filter,
            wrap: [self.wrap; 2],
        })
    }
}

#[derive(Clone, Copy, Debug)]
pub struct ImagePattern {
    pub bitmap: BitmapId,
    pub filter: Filter,
    /// Along s and along t.
    pub wrap: [Wrap; 2],
}

impl Wrap {
    /// The texel that `i` stands for along an axis of `n` texels, `None` where there is none.
    fn texel(self, i: i64, n: i64) -> Option<u32> {
        let inside = match self {
            Self::Repeat => i.rem_euclid(n),
            Self::Clamp => i.clamp(0, n - 1),
            Self::Mirror => {
                let k = i.rem_euclid(2 * n);
                k.min(2 * n - 1 - k)
            }
            Self::Black => i,
        };
        (0..n).contains(&inside).then_some(inside as u32)
    }
}

impl ImagePattern {
    fn texel(&self, bitmap: &Bitmap, i: i64, j: i64) -> Rgb {
        let (w, h) = (i64::from(bitmap.width), i64::from(bitmap.height));
        match (self.wrap[0].texel(i, w), self.wrap[1].texel(j, h)) {
            (Some(i), Some(j)) => bitmap.texel_from_bottom(i, j),
            _ => Rgb::BLACK,
        }
    }
}

impl PatternKind for ImagePattern {
    fn eval(&self, bitmaps: &[Bitmap], st: Vec2) -> Rgb {
        let bitmap = &bitmaps[self.bitmap.0 as usize];
        let x = st * Vec2::new(bitmap.width as f32, bitmap.height as f32);
        if !x.is_finite() {
            return Rgb::BLACK;
        }
        match self.filter {
            Filter::Nearest => {
                let x = x.floor();
                self.texel(bitmap, x.x as i64, x.y as i64)
            }
            Filter::Linear => {
                let x = x - 0.5;
                let (base, f) = (x.floor(), x - x.floor());
                let (i, j) = (base.x as i64, base.y as i64);
                let row = |j| self.texel(bitmap, i, j) * (1.0 - f.x) + self.texel(bitmap, i + 1, j) * f.x;
                row(j) * (1.0 - f.y) + row(j + 1) * f.y
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quarter() -> Vec<Bitmap> {
        // Top row 0 1, bottom row 2 3.
        vec![Bitmap::from_floats([2, 2], 1, vec![0.0, 1.0, 2.0, 3.0])]
    }

    #[test]
    fn nearest_takes_the_texel_that_holds_the_point_and_t_runs_upwards() {
        let p = ImagePattern {
            bitmap: BitmapId(0),
            filter: Filter::Nearest,
            wrap: [Wrap::Black; 2],
        };
        let at = |s, t| p.eval(&quarter(), Vec2::new(s, t)).r;
        assert_eq!(
            [at(0.1, 0.1), at(0.9, 0.1), at(0.1, 0.9), at(0.9, 0.9)],
            [2.0, 3.0, 0.0, 1.0]
        );
        assert_eq!([at(-0.1, 0.1), at(1.0, 0.1)], [0.0, 0.0]);
    }

    #[test]
    fn linear_meets_the_texels_at_their_centres_and_their_mean_between() {
        let p = ImagePattern {
            bitmap: BitmapId(0),
            filter: Filter::Linear,
            wrap: [Wrap::Clamp; 2],
        };
        let at = |s, t| p.eval(&quarter(), Vec2::new(s, t)).r;
        assert_eq!(at(0.25, 0.25), 2.0);
        assert_eq!(at(0.5, 0.5), 1.5);
        assert_eq!(at(0.0, 0.0), 2.0);
    }

    #[test]
    fn wrap_modes_continue_the_row_as_named() {
        let row = |w: Wrap| (-3..5).map(|i| w.texel(i, 2)).collect::<Vec<_>>();
        let some = |v: [u32; 8]| v.map(Some).to_vec();
        assert_eq!(row(Wrap::Repeat), some([1, 0, 1, 0, 1, 0, 1, 0]));
        assert_eq!(row(Wrap::Clamp), some([0, 0, 0, 0, 1, 1, 1, 1]));
        assert_eq!(row(Wrap::Mirror), some([1, 1, 0, 0, 1, 1, 0, 0]));
        assert_eq!(row(Wrap::Black)[..4], [None, None, None, Some(0)]);
    }
}
