//! Choices that have a name on the command line and in files.

/// Declares an enum whose variants have names: `ALL`, `name`, `Display` and `FromStr` derive from the one list.
macro_rules! named_choice {
    ($(#[$doc:meta])* $name:ident, $what:literal, { $($(#[$vdoc:meta])* $variant:ident = $text:literal,)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum $name { $($(#[$vdoc])* $variant,)* }
        impl $name {
            /// Every choice, in the order of the documentation.
            pub const ALL: &'static [$name] = &[$($name::$variant,)*];
            /// The name on the command line and in files.
            pub fn name(self) -> &'static str {
                match self { $($name::$variant => $text,)* }
            }
        }
        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.pad(self.name())
            }
        }
        impl std::str::FromStr for $name {
            type Err = String;
            fn from_str(text: &str) -> std::result::Result<Self, String> {
                match text {
                    $($text => Ok($name::$variant),)*
                    _ => {
                        let known = [$($text),*];
                        let meant = crate::nearest::close(text, known);
                        let hint = meant.map_or(String::new(), |near| format!(" (did you mean `{near}`?)"));
                        Err(format!("unknown {} `{text}`{hint}; known: {}", $what, known.join(", ")))
                    }
                }
            }
        }
    };
}
pub(crate) use named_choice;
