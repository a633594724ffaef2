//! What a law tells about itself: the names and the texts of its parameters are those of its fields.

/// A parameter of a law.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LawParameter {
    /// Name of the field, and the key when the law is serialised.
    pub name: &'static str,
    /// What it is, with its unit on a slide, as documented.
    pub what: &'static str,
}

/// The description of a law.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AboutLaw {
    /// The documentation of the law, in Markdown, each line after a space.
    pub text: &'static str,
    /// Its parameters, in order.
    pub parameters: &'static [LawParameter],
}

/// A law that describes itself.
pub trait DescribeLaw {
    /// The description.
    const LAW: AboutLaw;
}

/// Defines the parameters of a law, and its description from their documentation.
macro_rules! described {
    (
        $(#[doc = $text:literal])*
        #[derive($($derive:path),* $(,)?)]
        pub struct $Law:ident<S $(, const $N:ident: usize = $default:literal)?> {
            $($(#[doc = $what:literal])* pub $field:ident: $Type:ty,)*
        }
    ) => {
        $(#[doc = $text])*
        #[derive($($derive),*)]
        pub struct $Law<S $(, const $N: usize = $default)?> {
            $($(#[doc = $what])* pub $field: $Type,)*
        }

        impl<S $(, const $N: usize)?> $crate::DescribeLaw for $Law<S $(, $N)?> {
            const LAW: $crate::AboutLaw = $crate::AboutLaw {
                text: concat!($($text, "\n"),*),
                parameters: &[
                    $($crate::LawParameter { name: stringify!($field), what: concat!($($what),*) },)*
                ],
            };
        }
    };
}

/// Passes every law over `f64`, with its id, to the macro of the given name.
///
/// ```
/// macro_rules! count {
///     ($($id:literal => $Law:ty,)*) => { [$($id),*].len() };
/// }
/// assert_eq!(friction::with_every_law!(count), friction::LAWS.len());
/// ```
#[macro_export]
macro_rules! with_every_law {
    ($then:ident) => {
        $then! {
            "viscous" => $crate::Viscous<f64>,
            "classic" => $crate::Classic<f64>,
            "majd_simaan" => $crate::MajdSimaan<f64>,
            "karnopp" => $crate::Karnopp<f64>,
            "coulomb" => $crate::Coulomb<f64>,
            "bristle" => $crate::Bristle<f64>,
            "dahl" => $crate::Dahl<f64>,
            "hayward_armstrong" => $crate::HaywardArmstrong<f64>,
            "lugre" => $crate::LuGre<f64>,
            "elasto_plastic" => $crate::ElastoPlastic<f64>,
            "maxwell_slip" => $crate::MaxwellSlip<f64>,
            "armstrong" => $crate::Armstrong<f64>,
        }
    };
}

macro_rules! catalogued {
    ($($id:literal => $Law:ty,)*) => { &[$(($id, &<$Law as DescribeLaw>::LAW)),*] };
}

/// Every law by its id.
///
/// ```
/// let (_, dahl) = friction::LAWS.iter().find(|(id, _)| *id == "dahl").expect("a law");
/// assert_eq!(dahl.parameters[2].name, "sigma");
/// assert_eq!(dahl.parameters[2].what.trim(), "Stiffness at z = 0, σ, N/m.");
/// ```
pub const LAWS: &[(&str, &AboutLaw)] = with_every_law!(catalogued);
