//! The picture of a sky, and the light of its sun.

use std::f64::consts::{FRAC_PI_2, PI};

use super::{
    atmosphere::{Air, Atmosphere, GROUND, Ray, aerosols_phase, molecules_phase},
    spectrum::{COUNT, SUNLIGHT, Spectrum, ToRgb},
};
use crate::math::parallel;

/// The width and height of the picture, in texels.
pub(super) const SIZE: [usize; 2] = [1024, 512];

/// Elevations above the horizon and below it, and azimuths of half a turn, that are computed; others are interpolated.
const ABOVE: usize = 80;
const BELOW: usize = 24;
const AZIMUTHS: usize = 20;
/// Steps along each of their rays.
const STEPS: usize = 40;
/// Polar angles and azimuths of the directions from which light reaches the ground.
const IRRADIANCE: [usize; 2] = [16, 10];

/// A linear colour of Rec. 709.
type Color = [f64; 3];

/// A sky over a place and under a sun.
#[derive(Clone, Copy, Debug)]
pub(super) struct Setting {
    pub air: Air,
    /// The angle of the centre of the sun above the horizontal plane, in radians.
    pub elevation: f64,
    /// The height of the observer above the ground, in km.
    pub altitude: f64,
}

/// The light from a direction, see [`Scattered`](super::atmosphere::Scattered). The light of the ground is part of the last.
type Node = [Color; 3];

pub(super) struct Panorama {
    nodes: Vec<Node>,
    /// The angle of the horizon below the horizontal plane, in radians.
    dip: f64,
    elevation: f64,
    /// The irradiance on a surface that faces the sun.
    pub sun: Color,
}

/// A row of directions: the first node of the row above, the place between this and the next row, and the parts of the cosine
/// to the sun that depend on the elevation.
struct Row {
    nodes: usize,
    down: f64,
    up: f64,
    across: f64,
}

/// The directions of an azimuth: the node to the left, the place between this and the next node, and the cosine of the
/// azimuth from the sun.
struct Column {
    node: usize,
    right: f64,
    cos: f64,
}

/// The sine and the cosine of the elevation of the sun, and the distance of the observer from the centre.
struct Frame {
    sin: f64,
    cos: f64,
    r: f64,
}

impl Frame {
    fn ray(&self, elevation: f64, azimuth: f64) -> Ray {
        let (up, across) = (libm::sin(elevation), libm::cos(elevation));
        Ray {
            r: self.r,
            up,
            to_sun: (up * self.sin + across * self.cos * libm::cos(azimuth)).clamp(-1.0, 1.0),
            sun: self.sin,
        }
    }
}

impl Panorama {
    pub fn new(setting: &Setting) -> Self {
        let atmosphere = Atmosphere::new(&setting.air);
        let to_rgb = ToRgb::new();
        let shine = |spectrum: &Spectrum| {
            let mut light = *spectrum;
            light.iter_mut().zip(SUNLIGHT).for_each(|(light, sun)| *light *= sun);
            to_rgb.convert(&light)
        };
        let frame = |r| Frame {
            sin: libm::sin(setting.elevation),
            cos: libm::cos(setting.elevation),
            r,
        };
        let own = frame(GROUND + setting.altitude);
        let sky = irradiance(&atmosphere, &frame(GROUND));
        let dip = libm::acos((GROUND / own.r).min(1.0));
        let node = |k: usize| {
            let (row, column) = (k / AZIMUTHS, k % AZIMUTHS);
            let azimuth = PI * column as f64 / (AZIMUTHS - 1) as f64;
            let ray = own.ray(elevation_of(row, dip), azimuth);
            let mut light = atmosphere.scattered(&ray, STEPS);
            if row >= ABOVE {
                let ground = atmosphere.ground(&ray, &sky);
                let seen = light.transmittance.iter().zip(ground).map(|(t, l)| t * l);
                light.multiple.iter_mut().zip(seen).for_each(|(to, own)| *to += own);
            }
            [&light.molecules, &light.aerosols, &light.multiple].map(shine)
        };
        Self {
            nodes: parallel::map(0..(ABOVE + BELOW) * AZIMUTHS, node),
            dip,
            elevation: setting.elevation,
            sun: shine(&atmosphere.sunlight(own.r, own.sin)).map(|c| c.max(0.0)),
        }
    }

    /// The nodes above and below an elevation.
    fn row(&self, elevation: f64) -> Row {
        let above = elevation + self.dip;
        let (first, rows, part) = match above >= 0.0 {
            true => (0, ABOVE, above / (FRAC_PI_2 + self.dip)),
            false => (ABOVE, BELOW, -above / (FRAC_PI_2 - self.dip)),
        };
        let y = part.clamp(0.0, 1.0).sqrt() * (rows - 1) as f64;
        let row = (y as usize).min(rows - 2);
        Row {
            nodes: (first + row) * AZIMUTHS,
            down: y - row as f64,
            up: libm::sin(elevation) * libm::sin(self.elevation),
            across: libm::cos(elevation) * libm::cos(self.elevation),
        }
    }

    fn radiance(&self, row: &Row, column: &Column) -> Color {
        let to_sun = row.up + row.across * column.cos;
        let factors = [molecules_phase(to_sun), aerosols_phase(to_sun), 1.0];
        let at = row.nodes + column.node;
        let mut color = [0.0; 3];
        for (at, weight) in [
            (at, (1.0 - row.down) * (1.0 - column.right)),
            (at + 1, (1.0 - row.down) * column.right),
            (at + AZIMUTHS, row.down * (1.0 - column.right)),
            (at + AZIMUTHS + 1, row.down * column.right),
        ] {
            for (part, factor) in self.nodes[at].iter().zip(factors) {
                for (to, own) in color.iter_mut().zip(part) {
                    *to += weight * factor * own;
                }
            }
        }
        color.map(|c| c.max(0.0))
    }

    /// The radiances of all directions, row by row from the top. The sun is above the centre.
    pub fn texels(&self) -> Vec<f32> {
        let [width, height] = SIZE;
        let columns: Vec<Column> = (0..width / 2)
            .map(|column| Column::new(2.0 * PI * (column as f64 + 0.5) / width as f64))
            .collect();
        let mut texels = vec![0.0; 3 * width * height];
        parallel::for_each(texels.chunks_mut(3 * width).enumerate(), |(row, to)| {
            let row = self.row(FRAC_PI_2 - PI * (row as f64 + 0.5) / height as f64);
            for (k, column) in columns.iter().enumerate() {
                let color = self.radiance(&row, column).map(|c| c as f32);
                for at in [width / 2 - 1 - k, width / 2 + k] {
                    to[3 * at..3 * at + 3].copy_from_slice(&color);
                }
            }
        });
        texels
    }
}

impl Column {
    /// The nodes around an azimuth from that of the sun, from 0 to pi.
    fn new(azimuth: f64) -> Self {
        let x = azimuth / PI * (AZIMUTHS - 1) as f64;
        let node = (x as usize).min(AZIMUTHS - 2);
        Self {
            node,
            right: x - node as f64,
            cos: libm::cos(azimuth),
        }
    }
}

/// The elevation of a row of nodes. They are close at the horizon.
fn elevation_of(row: usize, dip: f64) -> f64 {
    let square = |row: usize, rows: usize| {
        let part = row as f64 / (rows - 1) as f64;
        part * part
    };
    // Rays of the first rows pass the ground and meet it.
    match row < ABOVE {
        true => (square(row, ABOVE) * (FRAC_PI_2 + dip)).max(1e-5) - dip,
        false => -(square(row - ABOVE, BELOW) * (FRAC_PI_2 - dip)).max(1e-5) - dip,
    }
}

/// The irradiance of the sky on the ground, for sunlight of 1.
fn irradiance(atmosphere: &Atmosphere, frame: &Frame) -> Spectrum {
    let [heights, azimuths] = IRRADIANCE;
    let from = |k: usize| {
        // Uniform in the square of the sine, which is cosine-weighted on the ground.
        let sin = (((k / azimuths) as f64 + 0.5) / heights as f64).sqrt();
        let azimuth = PI * ((k % azimuths) as f64 + 0.5) / azimuths as f64;
        let ray = frame.ray(libm::asin(sin), azimuth);
        let light = atmosphere.scattered(&ray, STEPS);
        let (molecules, aerosols) = (molecules_phase(ray.to_sun), aerosols_phase(ray.to_sun));
        let mut sum = light.multiple;
        for (k, sum) in sum.iter_mut().enumerate() {
            *sum += molecules * light.molecules[k] + aerosols * light.aerosols[k];
        }
        sum
    };
    let all: Vec<Spectrum> = parallel::map(0..heights * azimuths, from);
    let mut sum = [0.0; COUNT];
    for own in &all {
        sum.iter_mut()
            .zip(own)
            .for_each(|(sum, own)| *sum += own * PI / all.len() as f64);
    }
    sum
}
