//! Tests on nested textures with extreme numbers: no look-up panics, and each is a number.

use std::fmt::Write;

use crate::{
    math::{DVec3, Rgb, Vec2, Vec3, hash},
    texture::{
        Bitmap, BitmapId, Color, FindSources, MappingDesc, PatternDesc, ScenePlace, SharedFootprint, StTransformDesc,
        Texture, TextureId, TexturePoint, TextureSpace, Textures, VertexAttributes, WarpDesc, mipmap,
    },
    value::{Channel, ColorSource},
};

/// Random choices in a fixed order.
struct Random(u32);

impl Random {
    fn pick<T: Copy>(&mut self, of: &[T]) -> T {
        self.0 = self.0.wrapping_add(1);
        of[hash::mix32(self.0) as usize % of.len()]
    }

    /// A number above 0.
    fn positive(&mut self) -> &'static str {
        self.pick(&["1e-45", "1e-30", "0.01", "0.5", "1.0", "3.0", "1e20", "3.4e38"])
    }

    /// A number of at least 0.
    fn factor(&mut self) -> &'static str {
        self.pick(&["0.0", "1e-45", "0.2", "1.0", "7.0", "1e25", "3.4e38"])
    }

    /// A number.
    fn finite(&mut self) -> &'static str {
        self.pick(&[
            "0.0", "-3.4e38", "3.4e38", "-0.5", "0.25", "1.0", "-1e25", "1e-45", "90.0",
        ])
    }

    /// A coordinate.
    fn coordinate(&mut self) -> &'static str {
        self.pick(&[
            "0.0", "-1e300", "1e300", "1e39", "-3.4e38", "0.7", "-1.0", "1e-300", "4.0",
        ])
    }

    fn unit(&mut self) -> &'static str {
        self.pick(&["0.0", "1e-45", "0.3", "0.5", "1.0"])
    }

    fn source(&mut self, count: usize) -> String {
        self.0 = self.0.wrapping_add(1);
        match hash::mix32(self.0) as usize % (count + 1) {
            k if k < count => format!("\"texture.{k}\""),
            _ => self.factor().to_owned(),
        }
    }

    /// A texture of any kind; `count` is the number of textures before it.
    fn pattern(&mut self, count: usize) -> String {
        let colors = format!("a = {}, b = {}", self.factor(), self.factor());
        match self.pick(&[0, 1, 2, 3, 4, 5, 6, 7, 8, 8, 9, 9, 10, 10, 11, 11, 12, 12]) {
            0 => format!("constant = {{ color = {} }}", self.factor()),
            1 => format!("checker = {{ {colors}, scale = {} }}", self.positive()),
            2 => format!("stripes = {{ {colors}, width = {} }}", self.positive()),
            3 => {
                let filter = self.pick(&["trilinear", "linear", "nearest"]);
                let wrap = self.pick(&["repeat", "clamp", "mirror", "black"]);
                format!("image = {{ file = \"x.png\", filter = \"{filter}\", wrap = \"{wrap}\" }}")
            }
            4 => {
                let (kind, scale) = (self.pick(&["fbm", "turbulence"]), self.positive());
                let lacunarity = self.pick(&["1.0", "2.0", "1e9", "3.4e38"]);
                let (gain, colored) = (self.unit(), self.pick(&[true, false]));
                format!(
                    "noise = {{ {colors}, kind = \"{kind}\", scale = {scale}, octaves = 5, lacunarity = {lacunarity}, gain = {gain}, colored = {colored} }}"
                )
            }
            5 => {
                let (value, scale) = (self.pick(&["distance", "edge", "cell"]), self.positive());
                format!("voronoi = {{ {colors}, value = \"{value}\", scale = {scale} }}")
            }
            6 => {
                let (mortar, shift) = (self.factor(), self.unit());
                let [length, height, gap] = [self.positive(), self.positive(), self.factor()];
                format!(
                    "brick = {{ {colors}, mortar = {mortar}, size = [{length}, {height}], gap = {gap}, shift = {shift} }}"
                )
            }
            7 => {
                let along = self.pick(&["linear", "radial", "spherical"]);
                let wrap = self.pick(&["clamp", "repeat", "mirror"]);
                format!("gradient = {{ {colors}, along = \"{along}\", wrap = \"{wrap}\" }}")
            }
            8 => {
                let [a, b, factor] = [(); 3].map(|()| self.source(count));
                format!("mix = {{ a = {a}, b = {b}, factor = {factor} }}")
            }
            9 => {
                let [a, b] = [(); 2].map(|()| self.source(count));
                format!("multiply = {{ a = {a}, b = {b} }}")
            }
            10 => {
                let mut at = [(); 3].map(|()| self.finite());
                at.sort_by(|a, b| f32::total_cmp(&a.parse().unwrap(), &b.parse().unwrap()));
                let stops = at.map(|at| format!("{{ at = {at}, color = {} }}", self.factor()));
                let interpolation = self.pick(&["linear", "constant", "smooth"]);
                let (input, stops) = (self.source(count), stops.join(", "));
                format!("ramp = {{ input = {input}, stops = [{stops}], interpolation = \"{interpolation}\" }}")
            }
            11 => format!("invert = {{ input = {} }}", self.source(count)),
            _ => {
                let (input, clamp) = (self.source(count), self.pick(&[true, false]));
                let [from, to] = [[self.finite(), self.finite()], [self.factor(), self.factor()]];
                format!(
                    "remap = {{ input = {input}, from = [{}, {}], to = [{}, {}], clamp = {clamp} }}",
                    from[0], from[1], to[0], to[1]
                )
            }
        }
    }

    fn mapping(&mut self) -> String {
        let mut ramp = || {
            format!(
                "{{ axis = \"x\", from = {}, to = {} }}",
                self.coordinate(),
                self.coordinate()
            )
        };
        let planar = format!("planar = {{ s = {}, t = {} }}", ramp(), ramp());
        let [scale, x, y, z] = [(); 4].map(|()| self.coordinate());
        let solid = format!(
            "scale = {scale}, rotate = [{}, 0, 30], offset = [{x}, {y}, {z}]",
            self.finite()
        );
        match self.pick(&[0, 1, 2, 3, 4, 5, 6]) {
            0 => "uv = {}".to_owned(),
            1 => planar,
            2 => "spherical = {}".to_owned(),
            3 => "asin = {}".to_owned(),
            4 => format!("object = {{ {solid} }}"),
            5 => format!("world = {{ {solid} }}"),
            _ => format!("triplanar = {{ {solid}, blend = {} }}", self.unit()),
        }
    }

    /// A texture, if its numbers are allowed; `count` is the number of textures before it.
    fn texture(&mut self, count: usize) -> Option<(String, Texture)> {
        let color = |source: &crate::value::Spanned<ColorSource>| {
            Ok(match source.get_ref() {
                ColorSource::Constant(color) => Color::Constant(*color),
                ColorSource::Texture(name) => Color::Texture(TextureId(name.parse().expect("a number"))),
                ColorSource::Tinted { .. } => unreachable!("files cannot write it"),
            })
        };
        let find = FindSources {
            bitmap: &|_| Ok(BitmapId(0)),
            color: &color,
        };
        let (pattern, mapping) = (self.pattern(count), self.mapping());
        let mut text = format!("{pattern} {mapping}");
        let pattern = toml::from_str::<PatternDesc>(&pattern)
            .expect(&text)
            .compile(&find)
            .ok()?;
        let mapping = toml::from_str::<MappingDesc>(&mapping)
            .ok()?
            .compile(DVec3::ZERO)
            .ok()?;
        let mut texture = Texture::new(mapping, pattern);
        if self.pick(&[true, false]) {
            let [scale, rotate] = [(); 2].map(|()| self.finite());
            let is_zero = scale.parse::<f32>().is_ok_and(|scale| scale == 0.0);
            let scale = if is_zero { "1e-45" } else { scale };
            let transform = format!("scale = {scale}\nrotate = {rotate}");
            write!(text, " {transform}").expect("a text");
            texture.transform = toml::from_str::<StTransformDesc>(&transform).expect(&text).compile();
        }
        if self.pick(&[true, false, false]) {
            let warp = format!("by = {}\namount = {}", self.source(count), self.coordinate());
            write!(text, " {warp}").expect("a text");
            texture.warp = Some(toml::from_str::<WarpDesc>(&warp).ok()?.compile(&find).ok()?);
        }
        if self.pick(&[true, false, false]) {
            let factor = self.factor().parse().expect("a number");
            texture.factor = Rgb::new(factor, 1.0, 0.0);
        }
        Some((text, texture.prepared()))
    }

    fn number(&mut self) -> f32 {
        let extremes = [
            f32::NAN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            f32::MAX,
            -1e30,
            1e20,
            1e9,
            1e-45,
        ];
        let plain = [0.0, 0.0, 0.3, -0.6, 1.0, 12.0];
        self.pick(&[&extremes[..], &plain, &plain, &plain].concat())
    }

    fn vector(&mut self) -> Vec3 {
        Vec3::from_array([(); 3].map(|()| self.number()))
    }

    fn pair(&mut self) -> Vec2 {
        self.vector().truncate()
    }

    fn point(&mut self) -> TexturePoint {
        let still = self.pick(&[true, false, false]);
        TexturePoint {
            uv: self.pair(),
            uv_origin: self.pick(&[Vec2::ZERO, Vec2::ZERO, Vec2::new(1e9, -1e30)]),
            p: self.vector(),
            space: self.pick(&[TextureSpace::Object, TextureSpace::Scene]),
            n: self.vector(),
            dpdu: self.vector(),
            dpdv: self.vector(),
            curvature: self.number(),
            footprint: if still {
                [Vec2::ZERO; 2]
            } else {
                [self.pair(), self.pair()]
            },
            shared_footprint: SharedFootprint::NONE,
            vertex: VertexAttributes::NONE,
            scene: ScenePlace {
                p: self.vector(),
                n: self.vector(),
                dpdu: self.vector(),
                dpdv: self.vector(),
            },
        }
    }
}

#[test]
fn every_look_up_of_every_nesting_of_extreme_numbers_is_a_number() {
    let mut bitmap = Bitmap::from_floats([3, 2], 1, vec![0.0, 1.0, 2.0, 3.0, 1e20, 1e30]);
    let mut random = Random(1);
    for _ in 0..2_000 {
        let (mut texts, mut all) = (Vec::new(), Vec::new());
        while all.len() < 6 {
            if let Some((text, texture)) = random.texture(all.len()) {
                texts.push(text);
                all.push(texture);
            }
        }
        mipmap::add_levels(&all, std::slice::from_mut(&mut bitmap));
        let textures = Textures {
            textures: &all,
            bitmaps: std::slice::from_ref(&bitmap),
        };
        for _ in 0..6 {
            let at = random.point();
            for k in 0..all.len() {
                let id = TextureId(k as u32);
                let color = textures.data(&Color::Texture(id), &at);
                assert!(color.is_finite(), "{k} {color:?} {at:?} {texts:#?}");
                let (numbers, spread) = textures.source_moments(&Color::Texture(id), &at);
                assert!(
                    numbers.is_finite() && spread.is_finite(),
                    "{k} {numbers:?} {spread} {at:?} {texts:#?}"
                );
                let alpha = textures.channel(id, Channel::A, &at);
                assert!((0.0..=1.0).contains(&alpha), "{k} {alpha} {at:?} {texts:#?}");
                let corners = [at, random.point(), random.point()];
                let bound = textures.max_within(&Color::Texture(id), &corners);
                assert!(!bound.is_nan(), "{k} {bound} {corners:?} {texts:#?}");
                textures.texel(id, &at);
                textures.turned(&Color::Texture(id), Vec2::X, &at);
            }
        }
    }
}
