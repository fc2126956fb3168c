//! Macros that keep doc comments as text, so that the panel, the command line and the docs say the same in the same
//! words.

/// One value of a choice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Choice {
    /// Its name in files and on the command line.
    pub name: &'static str,
    /// Its name in the type.
    pub variant: &'static str,
    /// Its doc comment, as it stands.
    pub(super) doc: &'static str,
}

impl Choice {
    /// What it is: its doc comment.
    pub fn help(&self) -> String {
        one_line(self.doc)
    }
}

/// The values that a type has by name; numbers and switches have none.
pub trait Choices {
    /// All of them, in the order of the type.
    const CHOICES: &'static [Choice] = &[];
}

impl Choices for f64 {}
impl Choices for u32 {}
impl Choices for bool {}
impl Choices for Option<f64> {}

/// The lines of a doc comment as one.
pub(super) fn one_line(doc: &str) -> String {
    doc.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Enums whose variants have names in files and docs that are kept as text.
macro_rules! choices {
    ($($(#[doc = $about:literal])+ pub enum $Enum:ident { $($(#[doc = $doc:literal])+ $Variant:ident = $name:literal,)+ })+) => {$(
        $(#[doc = $about])+
        #[derive(Reflect, Serialize, Deserialize, Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum $Enum {
            $($(#[doc = $doc])+ #[serde(rename = $name)] $Variant,)+
        }

        impl $Enum {
            /// All of them.
            pub const ALL: &'static [Self] = &[$(Self::$Variant),+];

            /// Its name in files and on the command line.
            pub fn name(self) -> &'static str {
                Self::CHOICES[self as usize].name
            }
        }

        impl Choices for $Enum {
            const CHOICES: &'static [Choice] = &[
                $(Choice { name: $name, variant: stringify!($Variant), doc: concat!($($doc),+) }),+
            ];
        }
    )+};
}
pub(super) use choices;

/// The settings: a struct of what several methods read and of a struct for each engine, a table of them all by what each
/// is and who reads it, and their form in files, which knows no engines: `(method: exact, hz: 120)`.
macro_rules! settings {
    (
        $(#[doc = $about:literal])+
        pub struct $Settings:ident {
            common {
                $($(#[doc = $doc:literal])+ $field:ident: $Type:ty => $readers:expr;)+
            }
            $($(#[doc = $group_doc:literal])+ $group:ident: $Group:ident {
                $($(#[doc = $inner_doc:literal])+ $inner:ident: $Inner:ty => $inner_readers:expr;)+
            })+
        }
    ) => {
        $(#[doc = $about])+
        #[derive(Resource, Reflect, Clone, Copy, Debug, PartialEq)]
        #[reflect(Resource, Debug, Default, PartialEq)]
        pub struct $Settings {
            $($(#[doc = $doc])+ pub $field: $Type,)+
            $($(#[doc = $group_doc])+ pub $group: $Group,)+
        }

        $(
            $(#[doc = $group_doc])+
            #[derive(Reflect, Clone, Copy, Debug, PartialEq)]
            pub struct $Group {
                $($(#[doc = $inner_doc])+ pub $inner: $Inner,)+
            }
        )+

        /// Every setting.
        pub const SETTINGS: &[Setting] = &[
            $(Setting {
                name: stringify!($field),
                path: stringify!($field),
                doc: concat!($($doc),+),
                choices: <$Type>::CHOICES,
                readers: $readers,
            },)+
            $($(Setting {
                name: stringify!($inner),
                path: concat!(stringify!($group), ".", stringify!($inner)),
                doc: concat!($($inner_doc),+),
                choices: <$Inner>::CHOICES,
                readers: $inner_readers,
            },)+)+
        ];

        impl Serialize for $Settings {
            /// Those that the method reads, by their names in files.
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                let read: Vec<_> = SETTINGS.iter().filter(|setting| setting.is_read(self)).collect();
                let is_read = |path| read.iter().any(|setting| setting.path == path);
                let mut fields = serializer.serialize_struct(stringify!($Settings), read.len())?;
                $(if is_read(stringify!($field)) {
                    fields.serialize_field(stringify!($field), &self.$field)?;
                })+
                $($(if is_read(concat!(stringify!($group), ".", stringify!($inner))) {
                    fields.serialize_field(stringify!($inner), &self.$group.$inner)?;
                })+)+
                fields.end()
            }
        }

        impl $Settings {
            /// Takes the value of a setting from a file's map, where there is one of that path.
            pub(super) fn take<'de, A: MapAccess<'de>>(&mut self, path: &str, map: &mut A) -> Result<(), A::Error> {
                $(if path == stringify!($field) {
                    self.$field = map.next_value()?;
                })+
                $($(if path == concat!(stringify!($group), ".", stringify!($inner)) {
                    self.$group.$inner = map.next_value()?;
                })+)+
                Ok(())
            }
        }
    };
}
pub(super) use settings;
