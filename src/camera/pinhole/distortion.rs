//! The distortions of lenses: one file for each family, and one row for each model here.

use std::marker::PhantomData;

use glam::{DVec2, DVec3};
use serde::{Deserialize, Deserializer, Serialize, de};

use super::{
    brown::Brown,
    fisheyes::{FisheyePolynomial, KannalaBrandt},
    model::Model,
};
use crate::{
    camera::ViewDistortion,
    value::{Precise, Problem, Spanned},
};

macro_rules! models {
    ($( $name:literal => $Variant:ident, )*) => {
        /// The description of a distortion in a scene file: a model, and its coefficients.
        #[derive(Clone, Debug, Deserialize)]
        pub enum DistortionDesc { $( #[serde(rename = $name)] $Variant(Spanned<Coefficients<$Variant>>), )* }

        impl DistortionDesc {
            /// # Errors
            /// Coefficients of which no picture can be made.
            pub fn compile(&self) -> Result<Distortion, Problem> {
                match self { $(
                    Self::$Variant(given) => {
                        let model = $Variant::new(&given.get_ref().numbers);
                        match model.flaw() {
                            Some(flaw) => Err(Problem::at(given.span(), flaw)),
                            None => Ok(Distortion::$Variant(model)),
                        }
                    }
                )* }
            }
        }

        /// The distortion of a lens.
        #[derive(Clone, Copy, Debug, PartialEq, Serialize)]
        pub enum Distortion { None, $( $Variant($Variant), )* }

        impl Distortion {
            /// Whether depth is measured along the axis.
            pub(super) fn has_plane(&self) -> bool {
                match self { Self::None => true, $( Self::$Variant(_) => $Variant::HAS_PLANE, )* }
            }

            /// See [`Model::place`].
            pub(super) fn place(&self, d: DVec3) -> Option<DVec2> {
                match self {
                    Self::None => (d.z > 0.0).then(|| d.truncate() / d.z),
                    $( Self::$Variant(model) => model.place(d), )*
                }
            }

            /// See [`Model::direction`].
            #[inline]
            pub(super) fn direction(&self, place: DVec2) -> Option<DVec3> {
                match self {
                    Self::None => Some(place.extend(1.0)),
                    $( Self::$Variant(model) => model.direction(place), )*
                }
            }

            /// See [`Model::middle_slope`].
            pub(super) fn middle_slope(&self) -> f64 {
                match self { Self::None => 1.0, $( Self::$Variant(model) => model.middle_slope(), )* }
            }

            /// This distortion as data sets say it; `None` if they do not know it.
            pub fn of_data_sets(&self) -> Option<ViewDistortion> {
                match self { Self::None => Some(ViewDistortion::None), $( Self::$Variant(model) => model.of_data_sets(), )* }
            }
        }
    };
}

models! {
    "opencv" => Brown,
    "kannala_brandt" => KannalaBrandt,
    "fisheye_polynomial" => FisheyePolynomial,
}

impl From<ViewDistortion> for Distortion {
    fn from(of_data_set: ViewDistortion) -> Self {
        match of_data_set {
            ViewDistortion::None => Self::None,
            ViewDistortion::OpenCv(coefficients) if coefficients == [0.0; 12] => Self::None,
            ViewDistortion::OpenCv(coefficients) => Self::Brown(Brown::new(&coefficients)),
            ViewDistortion::OpenCvFisheye(coefficients) => Self::KannalaBrandt(KannalaBrandt::new(&coefficients)),
        }
    }
}

/// The coefficients of a model, as many as it takes.
#[derive(Clone, Debug)]
pub struct Coefficients<M> {
    numbers: Vec<f64>,
    model: PhantomData<M>,
}

impl<'de, M: Model> Deserialize<'de> for Coefficients<M> {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        let numbers: Vec<f64> = Vec::<Precise>::deserialize(d)?.iter().map(|c| c.0).collect();
        if M::COUNTS.contains(&numbers.len()) {
            let model = PhantomData;
            return Ok(Self { numbers, model });
        }
        let (expected, found) = (counts(M::COUNTS), numbers.len());
        Err(de::Error::custom(format_args!(
            "expected {expected} numbers, found {found}"
        )))
    }
}

/// Numbers as a list of alternatives.
fn counts(all: &[usize]) -> String {
    let texts: Vec<_> = all.iter().map(usize::to_string).collect();
    match texts.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} or {last}", rest.join(", ")),
        _ => texts.concat(),
    }
}
