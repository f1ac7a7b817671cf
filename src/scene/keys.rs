//! The statement of a table's keys.

/// A table of a scene, each of its keys stated once: what it means, its type, what it is where it is left out (without
/// `=` it must be given), and after `=>` what may stand there. A key that the file calls otherwise has its name after
/// `as`. Values that a file does not give, but a plan, stand after `without key` with what they are until then.
///
/// From this come the type, its reader, its schema, and its default where every key has one.
macro_rules! keys {
    ($(#[doc = $title:literal])* #[derive($($trait:ident),*)] $vis:vis $table:ident {
        $($(#[doc = $about:literal])* $(#[serde($($serde:tt)*)])*
        $key:ident $(as $name:literal)?: $type:ty = $default:expr => $kind:expr,)*
    }) => {
        $crate::scene::keys::keys! { @read
            $(#[doc = $title])* #[derive($($trait),*)] $vis $table {
                $($(#[doc = $about])* $(#[serde($($serde)*)])* $key $(as $name)?: $type = $default => $kind,)*
            }
        }

        impl Default for $table {
            fn default() -> Self {
                Self { $($key: $default),* }
            }
        }
    };
    (@read $(#[doc = $title:literal])* #[derive($($trait:ident),*)] $vis:vis $table:ident {
        $($(#[doc = $about:literal])* $(#[serde($($serde:tt)*)])*
        $key:ident $(as $name:literal)?: $type:ty $(= $default:expr)? => $kind:expr,)*
    } $(without key {
        $($(#[doc = $told:literal])* $(#[serde($($own_serde:tt)*)])* $own:ident: $own_type:ty = $own_value:expr,)*
    })?) => {
        $(#[doc = $title])*
        #[derive($($trait),*)]
        $vis struct $table {
            $($(#[doc = $about])* $(#[serde($($serde)*)])* pub $key: $type,)*
            $($($(#[doc = $told])* $(#[serde($($own_serde)*)])* pub $own: $own_type,)*)?
        }

        impl $table {
            /// Returns all keys are read before the first failure counts, so that independent mistakes are reported
            /// together.
            pub(in crate::scene) fn read(table: &mut $crate::scene::table::Table<'_>) -> Option<Self> {
                $(let $key = $crate::scene::keys::keys!(@key table, ($key $($name)?), $kind $(, $default)?);)*
                Some(Self { $($key: $key?,)* $($($own: $own_value,)*)? })
            }

            /// Returns the schema of the table.
            pub(in crate::scene) fn schema() -> serde_json::Value {
                $crate::scene::schema::table(concat!($($title),*), [$((
                    $crate::scene::keys::keys!(@name ($key $($name)?)),
                    concat!($($about),*),
                    $crate::scene::keys::keys!(@schema $type, $kind $(, $default)?),
                )),*])
            }
        }
    };
    (@key $table:ident, $name:tt, $kind:expr) => {
        $table.required($crate::scene::keys::keys!(@name $name), &$kind)
    };
    (@key $table:ident, $name:tt, $kind:expr, $default:expr) => {
        $table.or($crate::scene::keys::keys!(@name $name), &$kind, $default)
    };
    (@schema $type:ty, $kind:expr) => { $crate::scene::schema::key::<$type>(&$kind, None) };
    (@schema $type:ty, $kind:expr, $default:expr) => {
        $crate::scene::schema::key::<$type>(&$kind, Some($default))
    };
    (@name ($key:ident)) => { stringify!($key) };
    (@name ($key:ident $name:literal)) => { $name };
    ($($table:tt)*) => { $crate::scene::keys::keys! { @read $($table)* } };
}

pub(super) use keys;

/// Tells whether a value need not be written.
pub(super) fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}
