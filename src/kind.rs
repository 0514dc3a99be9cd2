//! The registry macro: one table row makes a shape, a texture, a material, a light or a camera known everywhere.

/// Declares a closed set of kinds from one table.
///
/// `Kind` becomes the enum of what is rendered, `Desc` the enum of what a scene file says (externally tagged by the
/// row's name); each method listed is answered by the row that `self` is. Rows of `described only` have a
/// description but no compiled form of their own.
///
/// ```ignore
/// kinds! {
///     /// Everything that a ray can meet.
///     enum Shape / ShapeDesc {
///         "sphere" => Sphere(sphere::Sphere, sphere::SphereDesc),
///     }
///     described only { "mesh" => Mesh(mesh::MeshDesc), }
///     fn bounds(&self) -> Aabb;
/// }
/// ```
macro_rules! kinds {
    (
        $(#[$meta:meta])*
        enum $Kind:ident / $Desc:ident $rows:tt
        described only $extra:tt
        $( compile($($parameter:ident: $Parameter:ty)?) -> $Error:ty; )?
        $( $(#[$doc:meta])* fn $method:ident(&self $(, $arg:ident: $ty:ty)* $(,)?) $(-> $ret:ty)?; )*
    ) => {
        kinds!(@kind [$(#[$meta])*] $Kind $rows);
        kinds!(@desc $Desc $rows $extra);
        $( kinds!(@compile $Kind $Desc $rows [$($parameter: $Parameter)?] $Error); )?
        impl $Kind {
            $(
                $(#[$doc])*
                #[inline]
                pub fn $method(&self $(, $arg: $ty)*) $(-> $ret)? {
                    kinds!(@answer self $rows; kind => kind.$method($($arg),*))
                }
            )*
        }
    };
    (@kind [$(#[$meta:meta])*] $Kind:ident { $( $name:literal => $Variant:ident($Runtime:ty, $Text:ty), )* }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug)]
        pub enum $Kind { $( $Variant($Runtime), )* }
    };
    (@desc $Desc:ident { $( $name:literal => $Variant:ident($Runtime:ty, $Text:ty), )* } { $( $xname:literal => $Extra:ident($XText:ty), )* }) => {
        /// What a scene file says of one.
        #[derive(Clone, Debug, serde::Deserialize)]
        pub enum $Desc {
            $( #[serde(rename = $name)] $Variant($Text), )*
            $( #[serde(rename = $xname)] $Extra($XText), )*
        }
        impl $Desc {
            /// The names of all kinds, in the order of the table.
            pub const NAMES: &[&str] = &[$($name,)* $($xname,)*];

            /// The name of this kind.
            pub fn name(&self) -> &'static str {
                match self {
                    $( Self::$Variant(_) => $name, )*
                    $( Self::$Extra(_) => $xname, )*
                }
            }
        }
    };
    (@compile $Kind:ident $Desc:ident { $( $name:literal => $Variant:ident($Runtime:ty, $Text:ty), )* } [] $Error:ty) => {
        impl $Desc {
            /// What is rendered, of what was described.
            pub fn compile(&self) -> Result<$Kind, $Error> {
                Ok(match self { $( Self::$Variant(desc) => $Kind::$Variant(desc.compile()?), )* })
            }
        }
    };
    (@compile $Kind:ident $Desc:ident { $( $name:literal => $Variant:ident($Runtime:ty, $Text:ty), )* } [$parameter:ident: $Parameter:ty] $Error:ty) => {
        impl $Desc {
            /// What is rendered, of what was described.
            pub fn compile(&self, $parameter: $Parameter) -> Result<$Kind, $Error> {
                Ok(match self { $( Self::$Variant(desc) => $Kind::$Variant(desc.compile($parameter)?), )* })
            }
        }
    };
    (@answer $self:ident { $( $name:literal => $Variant:ident($Runtime:ty, $Text:ty), )* }; $kind:ident => $answer:expr) => {
        match $self { $( Self::$Variant($kind) => $answer, )* }
    };
}

pub(crate) use kinds;
