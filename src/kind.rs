//! The registry macros: one row of a table registers a kind of shape, texture, material, light or
//! camera, or a choice that a name makes.

/// Declares a closed set of kinds from one table.
///
/// `Kind` becomes the enum of the compiled kinds, and `Desc` the enum of their descriptions in
/// scene files, externally tagged by the name of the row. Each method in the list matches on `self`
/// and calls the method of the row. It is inlined, so that results are not copied. Rows in
/// `described only` have a description but no compiled form.
///
/// With a line `compiled by`, `Desc` gets a method of that name, which calls the same method of the
/// row's description. For rows in `described only` it returns a [`Problem`](crate::value::Problem),
/// so callers handle these rows first.
///
/// The methods of `described by` are those of every description, also of rows in `described only`; the methods of
/// `changed by` change a compiled kind.
///
/// ```ignore
/// kinds! {
///     /// Everything that a ray can meet.
///     enum Shape / ShapeDesc {
///         "sphere" => Sphere(sphere::Sphere, sphere::SphereDesc),
///     }
///     described only { "mesh" => Mesh(mesh::MeshDesc), }
///     compiled by fn compile(&self) -> Result<Shape, Problem>;
///     described by { fn anchor(&self) -> Option<DVec3>; }
///     changed by { fn convert_colors(&mut self, space: WorkingSpace); }
///     fn bounds(&self) -> Aabb;
/// }
/// ```
macro_rules! kinds {
    (
        $(#[$meta:meta])*
        enum $Kind:ident / $Desc:ident $rows:tt
        described only $extra:tt
        $( compiled by fn $compile:ident(&self $(, $carg:ident: $cty:ty)* $(,)?) -> Result<$Compiled:ty, $Problem:ty>; )?
        $( described by { $( $(#[$ddoc:meta])* fn $dmethod:ident(&self $(, $darg:ident: $dty:ty)* $(,)?) -> $dret:ty; )* } )?
        $( changed by { $( $(#[$mdoc:meta])* fn $mmethod:ident(&mut self $(, $marg:ident: $mty:ty)* $(,)?); )* } )?
        $( $(#[$doc:meta])* fn $method:ident(&self $(, $arg:ident: $ty:ty)* $(,)?) $(-> $ret:ty)?; )*
    ) => {
        kinds!(@kind [$(#[$meta])*] $Kind $rows);
        kinds!(@desc $Desc $rows $extra);
        $(
            impl $Desc {
                /// Compiles the description.
                pub fn $compile(&self $(, $carg: $cty)*) -> Result<$Compiled, $Problem> {
                    kinds!(@compile self $Kind $rows $extra; desc => desc.$compile($($carg),*))
                }
            }
        )?
        $(
            impl $Desc {
                $(
                    $(#[$ddoc])*
                    pub fn $dmethod(&self $(, $darg: $dty)*) -> $dret {
                        kinds!(@described self $rows $extra; desc => desc.$dmethod($($darg),*))
                    }
                )*
            }
        )?
        $(
            impl $Kind {
                $(
                    $(#[$mdoc])*
                    pub fn $mmethod(&mut self $(, $marg: $mty)*) {
                        kinds!(@answer self $rows; kind => kind.$mmethod($($marg),*))
                    }
                )*
            }
        )?
        kinds!(@row $Kind $rows);
        impl $Kind {
            $(
                $(#[$doc])*
                #[inline(always)]
                pub fn $method(&self $(, $arg: $ty)*) $(-> $ret)? {
                    kinds!(@answer self $rows; kind => kind.$method($($arg),*))
                }
            )*
        }
    };
    (@kind [$(#[$meta:meta])*] $Kind:ident { $( $name:literal => $Variant:ident($Runtime:ty, $Text:ty), )* }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug)]
        #[allow(clippy::large_enum_variant, reason = "flat and without pointers")]
        pub enum $Kind { $( $Variant($Runtime), )* }
    };
    (@row $Kind:ident { $( $name:literal => $Variant:ident($Runtime:ty, $Text:ty), )* }) => {
        impl $Kind {
            /// The number of kinds.
            pub const KINDS: usize = [$($name),*].len();

            /// The number of this kind, below [`Self::KINDS`].
            #[inline(always)]
            pub fn kind(&self) -> usize {
                enum Row { $( $Variant, )* }
                match self { $( Self::$Variant(_) => Row::$Variant as usize, )* }
            }
        }
    };
    (@desc $Desc:ident { $( $name:literal => $Variant:ident($Runtime:ty, $Text:ty), )* } { $( $xname:literal => $Extra:ident($XText:ty), )* }) => {
        /// A description in a scene file.
        #[derive(Clone, Debug, serde::Deserialize)]
        #[allow(clippy::large_enum_variant, reason = "a scene has few descriptions, and none when it is rendered")]
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
    (@compile $self:ident $Kind:ident { $( $name:literal => $Variant:ident($Runtime:ty, $Text:ty), )* } { $( $xname:literal => $Extra:ident($XText:ty), )* }; $desc:ident => $answer:expr) => {
        match $self {
            $( Self::$Variant($desc) => $answer.map($Kind::$Variant), )*
            $( Self::$Extra(_) => Err($crate::value::Problem {
                span: None,
                message: concat!("`", $xname, "` has no compiled form of its own").to_owned(),
                help: None,
            }), )*
        }
    };
    (@described $self:ident { $( $name:literal => $Variant:ident($Runtime:ty, $Text:ty), )* } { $( $xname:literal => $Extra:ident($XText:ty), )* }; $desc:ident => $answer:expr) => {
        match $self {
            $( Self::$Variant($desc) => $answer, )*
            $( Self::$Extra($desc) => $answer, )*
        }
    };
    (@answer $self:ident { $( $name:literal => $Variant:ident($Runtime:ty, $Text:ty), )* }; $kind:ident => $answer:expr) => {
        match $self { $( Self::$Variant($kind) => $answer, )* }
    };
}

/// Declares a choice among names, as scene files, the command line and outputs write them.
///
/// The enum gets `ALL` in the order of its rows, `name`, `Display`, `Serialize`, and [`FromStr`](std::str::FromStr) and
/// `Deserialize`, whose error suggests a name. The text after its name says in messages what a name is of; with `ignoring case`
/// after it, letters may be small or large.
///
/// ```ignore
/// named! {
///     /// The bits of each number of PNG files.
///     pub enum PngBits: "bits" {
///         Eight = "8",
///         Sixteen = "16",
///     }
/// }
/// ```
macro_rules! named {
    (
        $(#[$meta:meta])*
        pub enum $Name:ident: $what:literal $( ignoring $case:ident )? { $( $(#[$doc:meta])* $Variant:ident = $name:literal, )* }
    ) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $Name { $( $(#[$doc])* $Variant, )* }

        impl $Name {
            /// All of them, in the order of the documentation.
            pub const ALL: [Self; [$($name),*].len()] = [$( Self::$Variant, )*];

            /// Returns its name.
            pub const fn name(self) -> &'static str {
                match self { $( Self::$Variant => $name, )* }
            }
        }

        impl std::fmt::Display for $Name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.pad(self.name())
            }
        }

        impl std::str::FromStr for $Name {
            type Err = $crate::value::UnknownName;

            fn from_str(name: &str) -> Result<Self, Self::Err> {
                let is_meant = |one: &Self| {
                    $( let $case = one.name().eq_ignore_ascii_case(name); )?
                    one.name() == name $( || $case )?
                };
                let found = Self::ALL.into_iter().find(is_meant);
                found.ok_or_else(|| $crate::value::UnknownName::new($what, name, Self::ALL.map(Self::name)))
            }
        }

        impl serde::Serialize for $Name {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.serialize_str(self.name())
            }
        }

        impl<'de> serde::Deserialize<'de> for $Name {
            fn deserialize<D: serde::Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
                let name = $crate::value::name(d)?;
                name.parse().map_err(|_| $crate::value::unknown_name($what, &name, &Self::ALL.map(Self::name)))
            }
        }
    };
}

pub(crate) use kinds;
pub(crate) use named;

#[cfg(test)]
mod tests {
    use crate::value::Problem;

    #[derive(Clone, Debug, serde::Deserialize)]
    pub struct Text {
        n: u8,
    }

    impl Text {
        fn compile(&self, factor: u8) -> Result<Row, Problem> {
            Ok(Row(self.n * factor))
        }

        fn number(&self) -> u8 {
            self.n
        }
    }

    #[derive(Clone, Copy, Debug)]
    pub struct Row(u8);

    impl Row {
        fn double(&self) -> u8 {
            self.0 * 2
        }

        fn add(&mut self, n: u8) {
            self.0 += n;
        }
    }

    kinds! {
        /// Two rows, one of them without a compiled form.
        enum Kind / KindDesc {
            "row" => Row(Row, Text),
        }
        described only { "outside" => Outside(Text), }
        compiled by fn compile(&self, factor: u8) -> Result<Kind, Problem>;
        described by {
            /// The number as described.
            fn number(&self) -> u8;
        }
        changed by {
            /// Adds to the number.
            fn add(&mut self, n: u8);
        }
        /// Twice the number.
        fn double(&self) -> u8;
    }

    #[test]
    fn a_row_is_read_named_compiled_and_answers() {
        let desc: KindDesc = toml::from_str("row = { n = 3 }").unwrap();
        assert_eq!((desc.name(), KindDesc::NAMES), ("row", &["row", "outside"][..]));
        assert_eq!(desc.compile(2).unwrap().double(), 12);
        assert_eq!((desc.compile(2).unwrap().kind(), Kind::KINDS), (0, 1));
        let mut kind = desc.compile(2).unwrap();
        kind.add(1);
        assert_eq!((desc.number(), kind.double()), (3, 14));
    }

    named! {
        /// Two names.
        #[derive(Default)]
        pub enum Side: "side" {
            #[default]
            Left = "left",
            Right = "to the right",
        }
    }

    #[test]
    fn a_name_is_written_read_and_suggested() {
        assert_eq!(Side::ALL.map(|side| side.to_string()), ["left", "to the right"]);
        assert!(Side::ALL.iter().all(|side| side.name().parse() == Ok(*side)));
        let unknown = "Left".parse::<Side>().unwrap_err().to_string();
        assert_eq!(unknown, "unknown side `Left` (did you mean `left`?)");
        #[derive(Debug, serde::Deserialize)]
        struct Table {
            side: Side,
        }
        assert_eq!(toml::from_str::<Table>("side = 'left'").unwrap().side, Side::default());
        let unknown = toml::from_str::<Table>("side = 'Left'").unwrap_err();
        let message = "unknown side `Left`, expected one of `left`, `to the right`";
        assert_eq!(unknown.message(), message);
    }

    #[test]
    fn a_row_that_is_described_only_compiles_to_a_problem() {
        let desc: KindDesc = toml::from_str("outside = { n = 3 }").unwrap();
        assert!(matches!(&desc, KindDesc::Outside(text) if text.n == 3));
        assert_eq!(desc.number(), 3);
        let problem = desc.compile(2).unwrap_err();
        assert_eq!(problem.message, "`outside` has no compiled form of its own");
    }
}
