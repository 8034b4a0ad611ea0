//! The contexts of representations: units and tolerance.

use super::entities::{Entities, Entity};
use super::part21::Attribute;
use crate::units::Units;

/// What a representation's lengths and angles are in.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Context {
    pub(super) units: Units,
    /// Radians.
    pub(super) angle: f64,
    /// How far apart what is said to be one may be.
    pub(super) tolerance: Option<f64>,
}

/// What a list refers to; what else it holds is none of ours.
fn referred(e: Entity<'_>) -> impl Iterator<Item = u64> {
    // Of many: files have four units and one uncertainty, and all parts may share the list.
    let list = e.list(0).unwrap_or_default().iter().take(64);
    list.filter_map(|a| match a {
        Attribute::EntityRef(id) => Some(*id),
        _ => None,
    })
}

/// Units and tolerance.
pub(super) fn context(entities: &Entities, id: u64) -> Option<Context> {
    let units = entities.part(id, "GLOBAL_UNIT_ASSIGNED_CONTEXT")?;
    let mut found = Context {
        units: Units::None,
        angle: 1.0,
        tolerance: None,
    };
    for unit in referred(units) {
        if entities.is(unit, "LENGTH_UNIT") {
            found.units = length(entities, unit, 0);
        } else if entities.is(unit, "PLANE_ANGLE_UNIT")
            && let Some(c) = entities.part(unit, "CONVERSION_BASED_UNIT")
            && let Some(measure) = c.optional(1)
            && let Some(m) = measured(entities, measure)
        {
            found.angle = m.0;
        }
    }
    if let Some(u) = entities.part(id, "GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT") {
        for m in referred(u) {
            if let Some(e) = entities.part(m, "UNCERTAINTY_MEASURE_WITH_UNIT")
                && let Ok(x) = e.number(0)
                && x > 0.0
                && e.optional(1).is_some_and(|u| entities.is(u, "LENGTH_UNIT"))
            {
                found.tolerance = Some(x);
            }
        }
    }
    Some(found)
}

/// A value and the unit it is in.
fn measured(entities: &Entities, id: u64) -> Option<(f64, u64)> {
    let kinds = [
        "LENGTH_MEASURE_WITH_UNIT",
        "PLANE_ANGLE_MEASURE_WITH_UNIT",
        "MEASURE_WITH_UNIT",
    ];
    let all = kinds.iter().filter_map(|k| entities.part(id, k));
    let mut values = all.filter_map(|e| Some((e.number(0).ok()?, e.optional(1)?)));
    values.next().filter(|(x, _)| *x > 0.0)
}

/// A unit of length.
fn length(entities: &Entities, id: u64, depth: u32) -> Units {
    if let Some(si) = entities.part(id, "SI_UNIT") {
        // In one part the dimensions come first.
        let at = usize::from(entities.simple(id).is_some());
        let factor = match si.word(at) {
            None => 1.0,
            Some("EXA") => 1e18,
            Some("PETA") => 1e15,
            Some("TERA") => 1e12,
            Some("GIGA") => 1e9,
            Some("MEGA") => 1e6,
            Some("KILO") => 1e3,
            Some("HECTO") => 1e2,
            Some("DECA") => 1e1,
            Some("DECI") => 1e-1,
            Some("CENTI") => 1e-2,
            Some("MILLI") => 1e-3,
            Some("MICRO") => 1e-6,
            Some("NANO") => 1e-9,
            Some("PICO") => 1e-12,
            Some(_) => return Units::None,
        };
        let name = si.word(at).unwrap_or("").to_lowercase() + "metre";
        return known(factor, name);
    }
    if let Some(c) = entities.part(id, "CONVERSION_BASED_UNIT") {
        let at = usize::from(entities.simple(id).is_some());
        if let Some((value, unit)) = c.optional(at + 1).and_then(|m| measured(entities, m))
            && depth < 4
            && let Some(metres) = length(entities, unit, depth + 1).metres()
        {
            return known(value * metres, c.text(at).to_lowercase());
        }
    }
    Units::None
}

/// The named unit that is this long up to rounding, or one of its own.
fn known(metres: f64, name: String) -> Units {
    let named = (1..=10).map(Units::from_code);
    let near = |u: &Units| {
        u.metres()
            .is_some_and(|m| (m - metres).abs() <= 4.0 * f64::EPSILON * metres)
    };
    { named }.find(near).unwrap_or(Units::Custom {
        name,
        metres: Some(metres),
    })
}
