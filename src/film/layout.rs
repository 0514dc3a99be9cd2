//! The layout of a film: its planes, and the inputs that they need.

use std::sync::Arc;

use super::{
    coverage::DEFAULT_RANKS,
    passes::{BEAUTY, Feature, PassSource, PassSpec, group_pass_name},
    request::PassRequest,
};
use crate::{
    scene::{LightGroup, MatteTable, Mattes},
    value::UnknownName,
};

/// One plane of a film: the values of a pass.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaneSpec {
    pub pass: &'static PassSpec,
    /// The name of the pass, with that of the light group.
    pub name: String,
    /// The layer of light that it shows, if it shows one.
    pub light_layer: Option<usize>,
    /// The number of mattes per pixel; 0 for other passes.
    pub ranks: u32,
    /// The mattes that it shows, once the scene is known.
    pub mattes: Option<Arc<MatteTable>>,
}

impl PlaneSpec {
    /// The number of values per pixel. The integrator's picture has four, of which the last is alpha; other passes have their
    /// channels.
    pub fn width(&self) -> usize {
        match self.pass.source {
            PassSource::Integrator => 4,
            PassSource::Matte(_) => 2 * self.ranks as usize,
            _ => self.pass.channels.len(),
        }
    }

    /// The number of values that a plane holds side by side for a pixel: all, but of passes of mattes those of a layer.
    pub fn step(&self) -> usize {
        match self.pass.source {
            PassSource::Matte(_) => self.pass.channels.len(),
            _ => self.width(),
        }
    }

    /// The names of its channels in EXR files, in the order of its values.
    pub fn channel_names(&self) -> Vec<String> {
        let channels = self.pass.channels.iter();
        match self.pass.source {
            _ if self.pass == BEAUTY => channels.map(|channel| (*channel).to_owned()).collect(),
            PassSource::Matte(_) => (0..self.ranks / 2)
                .flat_map(|layer| channels.clone().map(move |channel| (layer, channel)))
                .map(|(layer, channel)| format!("{}{layer:02}.{channel}", self.name))
                .collect(),
            _ => channels.map(|channel| format!("{}.{channel}", self.name)).collect(),
        }
    }
}

/// The planes of a film: first the integrator's picture, then passes.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmLayout {
    planes: Vec<PlaneSpec>,
}

/// The inputs that the passes of a film need from the renderer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Needs {
    /// Light sorted by components and groups.
    pub light_layers: bool,
    pub first_hits: bool,
    /// The albedo of first hits.
    pub albedo: bool,
}

impl FilmLayout {
    /// The layout for distinct `passes` in a scene with these light groups. Its first plane is `picture`, which the integrator
    /// computes.
    ///
    /// # Errors
    /// A pass names a light group that the scene does not have.
    pub fn new(picture: &'static PassSpec, passes: &[PassRequest], groups: &[String]) -> Result<Self, UnknownName> {
        let mut planes = vec![plane(picture, None)];
        for request in passes {
            let spec = request.spec();
            match (&spec.source, request) {
                (PassSource::Integrator, _) => {}
                (PassSource::Light(component), _) => planes.push(plane(spec, Some(component.layer()))),
                (
                    PassSource::FirstHit(_)
                    | PassSource::Mean(_)
                    | PassSource::MeanVariance(_)
                    | PassSource::Half(_)
                    | PassSource::AlphaHalves
                    | PassSource::Coverage
                    | PassSource::Statistic(_),
                    _,
                ) => planes.push(plane(spec, None)),
                (PassSource::Matte(_), _) => planes.push(PlaneSpec {
                    ranks: DEFAULT_RANKS,
                    ..plane(spec, None)
                }),
                (PassSource::LightGroup, PassRequest::Pass(_)) => {
                    planes.extend((0..groups.len()).map(|i| group_plane(spec, groups, i)));
                }
                (PassSource::LightGroup, PassRequest::LightGroup(name)) => {
                    let pass = group_pass_name(name);
                    let known: Vec<String> = groups.iter().map(|group| group_pass_name(group)).collect();
                    let Some(i) = known.iter().position(|known| *known == pass) else {
                        return Err(UnknownName::new("light group", &pass, known.iter().map(String::as_str)));
                    };
                    planes.push(group_plane(spec, groups, i));
                }
            }
        }
        let mut unique: Vec<PlaneSpec> = Vec::new();
        for plane in planes {
            if unique.iter().all(|other| other.name != plane.name) {
                unique.push(plane);
            }
        }
        Ok(Self { planes: unique })
    }

    /// Sets the number of ranks of matte passes, an even number: two share a layer.
    pub fn with_ranks(mut self, ranks: u32) -> Self {
        for plane in self.planes.iter_mut().filter(|plane| plane.ranks > 0) {
            plane.ranks = ranks.next_multiple_of(2);
        }
        self
    }

    /// Sets the names of a scene's mattes, which files list.
    pub fn with_mattes<'a>(self, mattes: impl Fn() -> &'a Mattes) -> Self {
        self.with_matte_tables(|plane| match plane.pass.source {
            PassSource::Matte(kind) => Some(Arc::clone(mattes().table(kind))),
            _ => None,
        })
    }

    /// Sets the names of the mattes of each plane that has ranks.
    pub fn with_matte_tables(mut self, table: impl Fn(&PlaneSpec) -> Option<Arc<MatteTable>>) -> Self {
        for plane in self.planes.iter_mut().filter(|plane| plane.ranks > 0) {
            plane.mattes = table(plane);
        }
        self
    }

    pub fn planes(&self) -> &[PlaneSpec] {
        &self.planes
    }

    /// The bytes of a finished film per pixel.
    pub fn bytes_per_pixel(&self) -> u64 {
        let values: usize = self.planes.iter().map(PlaneSpec::width).sum();
        (values * size_of::<f32>()) as u64
    }

    pub fn needs(&self) -> Needs {
        Needs {
            light_layers: self.planes.iter().any(|p| p.light_layer.is_some()),
            first_hits: self.planes.iter().any(|p| p.pass.reads_first_hits()),
            albedo: self.planes.iter().any(|p| p.pass.feature() == Some(Feature::Albedo)),
        }
    }
}

fn plane(pass: &'static PassSpec, light_layer: Option<usize>) -> PlaneSpec {
    PlaneSpec {
        pass,
        name: pass.name.to_owned(),
        light_layer,
        ranks: 0,
        mattes: None,
    }
}

fn group_plane(pass: &'static PassSpec, groups: &[String], group: usize) -> PlaneSpec {
    PlaneSpec {
        name: group_pass_name(&groups[group]),
        ..plane(pass, Some(LightGroup(group as u16).layer()))
    }
}

impl Default for FilmLayout {
    /// The beauty alone.
    fn default() -> Self {
        Self {
            planes: vec![plane(BEAUTY, None)],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layout(names: &[&str], groups: &[&str]) -> Result<FilmLayout, UnknownName> {
        let groups: Vec<String> = groups.iter().map(|g| (*g).to_owned()).collect();
        FilmLayout::new(BEAUTY, &PassRequest::parse_list(names.iter().copied())?, &groups)
    }

    #[test]
    fn each_pass_is_there_once_and_lightgroup_stands_for_every_group() {
        let layout = layout(&["N", "beauty", "lightgroup", "lightgroup_key", "N"], &["", "key"]).unwrap();
        let names: Vec<_> = layout.planes().iter().map(|p| p.name.as_str()).collect();
        assert_eq!(names, ["beauty", "N", "lightgroup_default", "lightgroup_key"]);
        assert_eq!(layout.planes()[3].light_layer, Some(LightGroup(1).layer()));
        assert_eq!(layout.bytes_per_pixel(), 4 * (4 + 3 + 3 + 3));
        assert_eq!(layout.planes()[1].channel_names(), ["N.X", "N.Y", "N.Z"]);
    }

    #[test]
    fn two_ranks_of_mattes_share_a_layer() {
        let layout = layout(&["CryptoAsset"], &[""]).unwrap().with_ranks(3);
        let plane = &layout.planes()[1];
        assert_eq!(plane.width(), 8);
        let layers = ["CryptoAsset00", "CryptoAsset01"];
        let expected = layers.map(|layer| ["R", "G", "B", "A"].map(|c| format!("{layer}.{c}")));
        assert_eq!(plane.channel_names(), expected.concat());
    }

    #[test]
    fn a_group_that_is_not_there_is_an_error_with_the_nearest() {
        let error = layout(&["lightgroup_kay"], &["", "key"]).unwrap_err();
        assert_eq!(error.suggestion(), Some("lightgroup_key"));
        assert!(layout(&["lightgroup_default"], &[""]).is_ok());
    }

    #[test]
    fn a_film_of_the_beauty_alone_needs_nothing_more() {
        assert_eq!(layout(&[], &[""]).unwrap().needs(), Needs::default());
        assert!(layout(&["depth"], &[""]).unwrap().needs().first_hits);
        assert!(layout(&["emission"], &[""]).unwrap().needs().light_layers);
    }
}
