//! Parameters of a tyre that can be fitted.

use std::ops::Range;

use crate::counters::catalogue::catalogue;
use crate::scene::{Law, Tyre};

/// Bounds of a parameter: its start divided and multiplied by this.
pub const BOUND: f64 = 4.0;

catalogue! {
    /// A parameter of the tyre. The tread is the outermost layer, the belt the innermost one under tension, or the
    /// innermost where none is under tension. All are positive and fitted by their logarithm.
    pub enum Parameter as "kebab-case",
    /// Name on the command line.
    name {
        /// Modulus of the tread \[Pa\].
        TreadModulus => "tread-modulus",
        /// Its loss factor.
        TreadLoss => "tread-loss",
        /// Its thickness \[m\].
        TreadThickness => "tread-thickness",
        /// Its density \[kg/m^3\].
        TreadDensity => "tread-density",
        /// Modulus of the belt \[Pa\].
        BeltModulus => "belt-modulus",
        /// Its loss factor.
        BeltLoss => "belt-loss",
        /// Stiffness of the belt's first family of cords \[Pa\].
        CordStiffness => "cord-stiffness",
        /// Their angle, in degrees.
        CordAngle => "cord-angle",
        /// Its tension along the circumference \[N/m\].
        TensionAlong => "tension-along",
        /// Its tension across \[N/m\].
        TensionAcross => "tension-across",
        /// Normal stiffness of the foundation \[N/m^3\].
        FoundationNormal => "foundation-normal",
        /// Its tangential stiffness \[N/m^3\].
        FoundationTangential => "foundation-tangential",
        /// Its loss factor.
        FoundationLoss => "foundation-loss",
        /// Radius of the sidewalls' arcs \[m\].
        SidewallRadius => "sidewall-radius",
        /// Half their angle \[rad\].
        SidewallAngle => "sidewall-angle",
        /// Their mass \[kg/m^2\].
        SidewallMass => "sidewall-mass",
        /// Their shear stiffness \[N/m\].
        SidewallShear => "sidewall-shear",
        /// Their loss factor.
        SidewallLoss => "sidewall-loss",
    }
}

impl Parameter {
    /// The parameters that determine the lowest modes: a search over starts varies these.
    pub(crate) const OF_LOW_MODES: [Self; 5] = [
        Self::TensionAlong,
        Self::FoundationNormal,
        Self::FoundationTangential,
        Self::SidewallRadius,
        Self::SidewallAngle,
    ];

    /// Unit; empty for a number.
    pub(crate) const fn unit(self) -> &'static str {
        match self {
            Self::TreadModulus | Self::BeltModulus | Self::CordStiffness => "Pa",
            Self::CordAngle => "degrees",
            Self::TreadLoss | Self::BeltLoss | Self::FoundationLoss | Self::SidewallLoss => "",
            Self::TreadThickness | Self::SidewallRadius => "m",
            Self::TreadDensity => "kg/m^3",
            Self::TensionAlong | Self::TensionAcross | Self::SidewallShear => "N/m",
            Self::SidewallAngle => "rad",
            Self::SidewallMass => "kg/m^2",
            Self::FoundationNormal | Self::FoundationTangential => "N/m^3",
        }
    }

    /// True if it is fitted to this start by default. Tension that follows from inflation and sidewalls is not: it
    /// would be fitted twice, beside their radius and angle.
    pub(crate) fn is_free_from(self, start: &Tyre) -> bool {
        self.is_usually_free() && !(self == Self::TensionAlong && start.tension_is_carried())
    }

    /// True if it is fitted by default. Thickness and density of the tread are weighed and measured more accurately
    /// than any mobility determines them, and with them known the others are well determined. The angle of cords is
    /// known from the tyre's construction. The foundation's and the sidewalls' losses show in the lowest modes only;
    /// the sidewalls' mass is weighed.
    pub const fn is_usually_free(self) -> bool {
        !matches!(
            self,
            Self::TreadThickness
                | Self::TreadDensity
                | Self::CordAngle
                | Self::FoundationLoss
                | Self::SidewallMass
                | Self::SidewallLoss
        )
    }

    /// Key of the scene that holds it.
    pub(crate) fn key(self, tyre: &Tyre) -> String {
        let belt = belt(tyre).unwrap_or(0);
        let tread = tyre.layers.len().saturating_sub(1);
        match self {
            Self::TreadModulus => format!("tyre.layers[{tread}].material.modulus"),
            Self::TreadLoss => format!("tyre.layers[{tread}].material.loss_factor"),
            Self::TreadThickness => format!("tyre.layers[{tread}].thickness"),
            Self::TreadDensity => format!("tyre.layers[{tread}].material.density"),
            Self::BeltModulus => format!("tyre.layers[{belt}].material.modulus"),
            Self::BeltLoss => format!("tyre.layers[{belt}].material.loss_factor"),
            Self::CordStiffness => format!("tyre.layers[{belt}].cords[0].stiffness"),
            Self::CordAngle => format!("tyre.layers[{belt}].cords[0].angle_deg"),
            Self::TensionAlong | Self::TensionAcross => format!("tyre.layers[{belt}].tension"),
            Self::FoundationNormal => "tyre.foundation.normal".to_owned(),
            Self::FoundationTangential => "tyre.foundation.tangential".to_owned(),
            Self::FoundationLoss => "tyre.foundation.loss_factor".to_owned(),
            Self::SidewallRadius => "tyre.sidewall.radius".to_owned(),
            Self::SidewallAngle => "tyre.sidewall.angle".to_owned(),
            Self::SidewallMass => "tyre.sidewall.mass".to_owned(),
            Self::SidewallShear => "tyre.sidewall.shear".to_owned(),
            Self::SidewallLoss => "tyre.sidewall.loss_factor".to_owned(),
        }
    }

    /// Reference to its value in a tyre; `None` where the tyre, or its material's law, has no such parameter.
    pub fn place(self, tyre: &mut Tyre) -> Option<&mut f64> {
        let belt = belt(tyre);
        let layer = match self {
            Self::TreadModulus | Self::TreadLoss | Self::TreadThickness | Self::TreadDensity => {
                tyre.layers.last_mut()?
            }
            Self::FoundationNormal => return Some(&mut tyre.foundation.normal),
            Self::FoundationTangential => return Some(&mut tyre.foundation.tangential),
            Self::FoundationLoss => return Some(&mut tyre.foundation.loss_factor),
            Self::SidewallRadius => return Some(&mut tyre.sidewall.as_mut()?.radius),
            Self::SidewallAngle => return Some(&mut tyre.sidewall.as_mut()?.angle),
            Self::SidewallMass => return Some(&mut tyre.sidewall.as_mut()?.mass),
            Self::SidewallShear => return Some(&mut tyre.sidewall.as_mut()?.shear),
            Self::SidewallLoss => return Some(&mut tyre.sidewall.as_mut()?.loss_factor),
            _ => tyre.layers.get_mut(belt?)?,
        };
        let has_loss = matches!(layer.material.law, Law::PowerLaw | Law::Hysteretic);
        match self {
            Self::TreadThickness => Some(&mut layer.thickness),
            Self::TensionAlong => Some(&mut layer.tension[0]),
            Self::TensionAcross => Some(&mut layer.tension[1]),
            Self::TreadDensity => Some(&mut layer.material.density),
            Self::TreadModulus | Self::BeltModulus if layer.orthotropic.is_some() => None,
            Self::TreadModulus | Self::BeltModulus => Some(&mut layer.material.modulus),
            Self::CordStiffness => layer.cords.first_mut()?.stiffness.as_mut(),
            Self::CordAngle => layer.cords.first_mut().map(|cords| &mut cords.angle_deg),
            _ if has_loss => Some(&mut layer.material.loss_factor),
            _ => None,
        }
    }

    /// Its value, if that is positive, so that a logarithm can vary it.
    pub fn value(self, tyre: &Tyre) -> Option<f64> {
        self.place(&mut tyre.clone()).copied().filter(|&value| value > 0.0)
    }
}

/// Index of the belt among the layers; `None` for a single layer, which is the tread.
fn belt(tyre: &Tyre) -> Option<usize> {
    let inner = tyre.layers.len().checked_sub(1).filter(|&count| count > 0)?;
    Some(tyre.layers[..inner].iter().position(crate::scene::Layer::is_tense).unwrap_or(0))
}

/// Space of the free parameters around a starting tyre: coordinates are logarithms of value over start.
#[derive(Clone, Debug)]
pub(super) struct Space<'a> {
    pub(super) start: &'a Tyre,
    pub(super) free: &'a [Parameter],
}

impl Space<'_> {
    /// Bounds of each coordinate.
    pub(super) fn bounds(&self) -> Vec<Range<f64>> {
        vec![-BOUND.ln()..BOUND.ln(); self.free.len()]
    }

    /// The tyre at a point. Tension that the start takes from its inflation and sidewalls follows the sidewalls, unless
    /// it is free itself.
    pub(super) fn tyre(&self, point: &[f64]) -> Tyre {
        let mut tyre = self.start.clone();
        for (parameter, logarithm) in self.free.iter().zip(point) {
            if let Some(value) = parameter.place(&mut tyre) {
                *value *= logarithm.exp();
            }
        }
        if self.start.tension_is_carried()
            && !self.free.contains(&Parameter::TensionAlong)
            && let Some(carried) = tyre.carried_tension()
        {
            // A single layer carries all of it.
            tyre.layers.iter_mut().filter(|layer| layer.tension[0] > 0.0).for_each(|layer| layer.tension[0] = carried);
        }
        tyre
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Cords, DEFAULT, Scene, Sidewall};
    use crate::test_models::plate_tyre;

    #[test]
    fn every_parameter_moves_its_value_and_names_its_key() {
        let mut start = plate_tyre();
        start.layers[0].cords.push(Cords::new(3e9, 20.0, 0.01));
        let (shear, hoop, loss_factor) = (8e3, None, 0.15);
        start.sidewall = Some(Sidewall { radius: 0.055, angle: 1.0, mass: 7.0, shear, hoop, loss_factor });
        let scene = toml::Table::try_from(&start).unwrap();
        for parameter in Parameter::ALL {
            let moved = Space { start: &start, free: &[parameter] }.tyre(&[2.0_f64.ln()]);
            let before = parameter.value(&start).unwrap();
            assert!((parameter.value(&moved).unwrap() / before - 2.0).abs() < 1e-12, "{parameter:?}");
            let changed = Parameter::ALL.into_iter().filter(|other| other.value(&moved) != other.value(&start));
            assert_eq!(changed.collect::<Vec<_>>(), [parameter]);
            let key = parameter.key(&start).replace("tyre.", "").replace('[', ".").replace(']', "");
            let mut value = &toml::Value::Table(scene.clone());
            for name in key.split('.') {
                value = match name.parse::<usize>() {
                    Ok(number) => &value[number],
                    Err(_) => &value[name],
                };
            }
            let places: Vec<f64> = value.as_array().map_or_else(
                || value.as_float().into_iter().collect(),
                |pair| pair.iter().filter_map(toml::Value::as_float).collect(),
            );
            assert!(places.contains(&before), "{key}: {places:?}");
        }
    }

    #[test]
    fn tension_that_the_inflation_gives_follows_the_sidewalls() {
        let start = Scene::from_str(DEFAULT, "default").unwrap().scene.tyre;
        assert!(start.tension_is_carried() && !Parameter::TensionAlong.is_free_from(&start));
        let moved = Space { start: &start, free: &[Parameter::SidewallAngle] }.tyre(&[-0.1]);
        assert!(moved.tension_is_carried() && moved.tension_along() < 0.99 * start.tension_along());
        let free = [Parameter::SidewallAngle, Parameter::TensionAlong];
        let given = Space { start: &start, free: &free }.tyre(&[-0.1, 0.0]);
        assert_eq!(given.tension_along().to_bits(), start.tension_along().to_bits());
        let springs = plate_tyre();
        assert!(!springs.tension_is_carried() && Parameter::TensionAlong.is_free_from(&springs));
    }

    #[test]
    fn what_a_tyre_does_not_have_has_no_value() {
        let mut tyre = plate_tyre();
        tyre.layers[0].tension[1] = 0.0;
        tyre.layers[1].material.law = Law::Elastic;
        assert_eq!((Parameter::TensionAcross.value(&tyre), Parameter::TreadLoss.value(&tyre)), (None, None));
        tyre.layers.remove(0);
        assert_eq!((Parameter::BeltModulus.value(&tyre), Parameter::TensionAlong.value(&tyre)), (None, None));
        assert!(Parameter::TreadModulus.value(&tyre).is_some());
    }
}
