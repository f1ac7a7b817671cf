//! Amounts that add up, part by part: declared once, with their arithmetic.

/// Declares a structure of amounts. Adding adds each of them; taking a part off the whole takes each of them off, and
/// nothing goes below zero, whatever clocks and counts say.
macro_rules! amounts {
    ($(#[$about:meta])* pub struct $name:ident { $($(#[$meaning:meta])* pub $part:ident: $amount:ty,)+ }) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize, serde::Serialize)]
        pub struct $name {
            $($(#[$meaning])* pub $part: $amount,)+
        }

        impl std::ops::AddAssign for $name {
            fn add_assign(&mut self, other: Self) {
                $(self.$part += other.$part;)+
            }
        }

        impl std::ops::Sub for $name {
            type Output = Self;

            fn sub(self, part: Self) -> Self {
                Self { $($part: self.$part.saturating_sub(part.$part),)+ }
            }
        }
    };
}

pub(crate) use amounts;
