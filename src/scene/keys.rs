//! The macro that declares a table's keys.

/// Declares a table of a scene, each of its keys once: its meaning, its type, its default (without `=` it must be
/// given), and after `=>` the kind of its value. A key that has another name in the file has that name after `as`. A
/// key with `?:` before its type may be left out, and is then `None` and not written. Values that come from the plan,
/// not from a file, follow `without key` with their initial values.
///
/// The macro expands to the type, its reader, its schema (the documentation becomes the descriptions), and its default
/// if every key has one.
macro_rules! keys {
    ($(#[doc = $title:literal])* #[derive($($trait:ident),*)] $vis:vis $table:ident {
        $($(#[doc = $about:literal])* $(#[serde($($serde:tt)*)])*
        $key:ident $(as $name:literal)? $(?: $some:ty)? $(: $type:ty = $default:expr)? => $kind:expr,)*
    }) => {
        $crate::scene::keys::keys! { @read
            $(#[doc = $title])* #[derive($($trait),*)] $vis $table {
                $($(#[doc = $about])* $(#[serde($($serde)*)])*
                $key $(as $name)? $(?: $some)? $(: $type = $default)? => $kind,)*
            }
        }

        impl Default for $table {
            fn default() -> Self {
                Self { $($key: $($default)? $(None::<$some>)?),* }
            }
        }
    };
    (@read $(#[doc = $title:literal])* #[derive($($trait:ident),*)] $(#[serde($form:ident)])?
    $vis:vis $table:ident {
        $($(#[doc = $about:literal])* $(#[serde($($serde:tt)*)])*
        $key:ident $(as $name:literal)? $(?: $some:ty)? $(: $type:ty $(= $default:expr)?)? => $kind:expr,)*
    } $(without key {
        $($(#[doc = $text:literal])* $(#[serde($($extra_serde:tt)*)])*
        $extra:ident: $extra_type:ty = $extra_value:expr,)*
    })?) => {
        $(#[doc = $title])*
        #[derive($($trait),*)]
        $(#[serde($form)])?
        $vis struct $table {
            $($(#[doc = $about])* $(#[serde($($serde)*)])* $(pub $key: $type)?
            $(#[serde(skip_serializing_if = "Option::is_none")] pub $key: Option<$some>)?,)*
            $($($(#[doc = $text])* $(#[serde($($extra_serde)*)])* pub $extra: $extra_type,)*)?
        }

        impl $crate::scene::table::Keys for $table {
            fn read(table: &mut $crate::scene::table::Table<'_>) -> Option<Self> {
                $(
                    let name = $crate::scene::keys::keys!(@name ($key $($name)?));
                    $(let $key: Option<$type> = $crate::scene::keys::keys!(@key table, name, $kind $(, $default)?);)?
                    $(let $key = table.or(name, &$crate::scene::kind::Optional($kind), None::<$some>);)?
                )*
                Some(Self { $($key: $key?,)* $($($extra: $extra_value,)*)? })
            }

            fn schema() -> serde_json::Value {
                $crate::scene::schema::table(concat!($($title),*), [$((
                    $crate::scene::keys::keys!(@name ($key $($name)?)),
                    concat!($($about),*),
                    $($crate::scene::keys::keys!(@schema $type, $kind $(, $default)?))?
                    $($crate::scene::schema::key(&$crate::scene::kind::Optional($kind), Some(None::<$some>)))?,
                )),*])
            }
        }
    };
    (@key $table:ident, $name:ident, $kind:expr) => { $table.required($name, &$kind) };
    (@key $table:ident, $name:ident, $kind:expr, $default:expr) => { $table.or($name, &$kind, $default) };
    (@schema $type:ty, $kind:expr) => { $crate::scene::schema::key::<$type>(&$kind, None) };
    (@schema $type:ty, $kind:expr, $default:expr) => {
        $crate::scene::schema::key::<$type>(&$kind, Some($default))
    };
    (@name ($key:ident)) => { stringify!($key) };
    (@name ($key:ident $name:literal)) => { $name };
    ($($table:tt)*) => { $crate::scene::keys::keys! { @read $($table)* } };
}

pub(super) use keys;

/// True if a value is the default and need not be written.
pub(super) fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}
