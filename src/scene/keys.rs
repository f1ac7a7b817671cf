//! The statement of a table's keys.

/// A table of a scene, each of its keys stated once: what it means, its type, what it is where it is left out (without
/// `=` it must be given), and after `=>` what may stand there. A key that the file calls otherwise has its name after
/// `as`.
///
/// From this come the type, its reader, and its default where every key has one.
macro_rules! keys {
    ($(#[$meta:meta])* $table:ident {
        $($(#[$about:meta])* $key:ident $(as $name:literal)?: $type:ty = $default:expr => $kind:expr,)*
    }) => {
        $crate::scene::keys::keys! { @read
            $(#[$meta])* $table { $($(#[$about])* $key $(as $name)?: $type = $default => $kind,)* }
        }

        impl Default for $table {
            fn default() -> Self {
                Self { $($key: $default),* }
            }
        }
    };
    (@read $(#[$meta:meta])* $table:ident {
        $($(#[$about:meta])* $key:ident $(as $name:literal)?: $type:ty $(= $default:expr)? => $kind:expr,)*
    }) => {
        $(#[$meta])*
        pub struct $table {
            $($(#[$about])* pub $key: $type,)*
        }

        impl $table {
            /// All keys are read before the first failure counts, so that independent mistakes are reported together.
            pub(in crate::scene) fn read(table: &mut $crate::scene::table::Table<'_>) -> Option<Self> {
                $(let $key = $crate::scene::keys::keys!(@key table, ($key $($name)?), $kind $(, $default)?);)*
                Some(Self { $($key: $key?),* })
            }
        }
    };
    (@key $table:ident, $name:tt, $kind:expr) => {
        $table.required($crate::scene::keys::keys!(@name $name), &$kind)
    };
    (@key $table:ident, $name:tt, $kind:expr, $default:expr) => {
        $table.or($crate::scene::keys::keys!(@name $name), &$kind, $default)
    };
    (@name ($key:ident)) => { stringify!($key) };
    (@name ($key:ident $name:literal)) => { $name };
    ($($table:tt)*) => { $crate::scene::keys::keys! { @read $($table)* } };
}

pub(super) use keys;

/// Whether a value need not be written.
pub(super) fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}
