//! Amounts that add up, part by part: declared once, with their arithmetic.

/// Declares a structure of amounts that are added part by part and subtracted part by part, saturating at zero: clocks
/// and counts of a part may exceed those of the whole.
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
