//! Enums that are listed in order and shown by a title: written once, as one list.

/// Declares an enum from one list of its values, each with its documentation and the text that people read: the enum
/// itself, its values in order (`ALL`), and a function that returns the text. Files name the values in snake case, or
/// in the case that follows `as`.
macro_rules! catalogue {
    ($(#[$about:meta])* $vis:vis enum $name:ident, $($rest:tt)*) => {
        $crate::counters::catalogue::catalogue! { $(#[$about])* $vis enum $name as "snake_case", $($rest)* }
    };
    (
        $(#[$about:meta])*
        $vis:vis enum $name:ident as $case:literal, $(#[$about_text:meta])* $text:ident {
            $($(#[$meaning:meta])* $value:ident => $words:literal,)+
        }
    ) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Deserialize, serde::Serialize)]
        #[serde(rename_all = $case)]
        $vis enum $name {
            $($(#[$meaning])* $value,)+
        }

        impl $name {
            /// All of them, in order.
            $vis const ALL: [Self; [$($words),+].len()] = [$(Self::$value),+];

            $(#[$about_text])*
            $vis const fn $text(self) -> &'static str {
                match self {
                    $(Self::$value => $words,)+
                }
            }
        }
    };
}

pub(crate) use catalogue;
