//! What the motion does not explain: errors that follow a further column of the recording, or nothing in it.

use crate::findings::event::{Event, Part, event};
use crate::findings::words::short;
use crate::library::term::TermKind;
use crate::result::{Location, Missing};
use crate::search::extra_columns::Followed;
use crate::search::hypothesis::Hypothesis;
use crate::search::judgement::{LEVEL, Search};
use friction::effects::{Describe, Unnamed};
use friction::{Dimension, Geometry};
use std::collections::BTreeMap;

/// Error over the noise floor above which something is missing although no effect describes it, if the error follows a
/// coordinate.
pub const SEVERAL: f64 = 3.0;
/// The same if the error follows no coordinate.
const MANY: f64 = 10.0;

/// An error of several floors that nothing in the catalogue describes: a statement about the recording, not a model; and when
/// it happened, where it happened once or a few times.
pub fn elsewhere(
    search: &Search,
    found: &Hypothesis,
    p: f64,
    geometry: Geometry,
) -> Option<(Missing, Vec<Location>)> {
    let rms = search.design.rms(found.fit.heldout_sum());
    let floor = search.design.rms(search.floor);
    let unit = Dimension::FORCE.unit(geometry);
    let left = short(rms);
    let everywhere = rms > if p <= LEVEL { SEVERAL } else { MANY } * floor;
    let event = event(search, found);
    if !everywhere && event.is_none() {
        return None;
    }
    let (size, when) = match &event {
        Some(Event { rms, parts }) => {
            let part = |Part { between: (from, to), .. }: &Part| {
                format!(" from {} to {} s and", short(*from), short(*to))
            };
            (*rms, parts.iter().map(part).collect::<String>() + " small elsewhere")
        }
        None => (rms, String::new()),
    };
    let (why, experiment) = match (&event, search.design.is_one_way()) {
        (_, true) => (
            "no explanation of one part of this recording holds in another: what acts happened once, or depends on something \
             that is not in the recording; the body passes every place once, so the two look alike",
            "repeat the move, and record other influences (a load, a temperature, a supply) as further columns",
        ),
        (Some(Event { parts, .. }), false) if parts.len() > 1 => (
            "no law and no curve over the motion explains it: what acts there acts too rarely for one part of this recording to \
             confirm another",
            "make a move that comes to these places and speeds more often",
        ),
        (Some(_), false) => (
            "no other part of this recording explains it: what acts there happened once, or depends on something that is not in \
             the recording",
            "find out what happened then (a touch, a cable that caught, another load), and repeat the move",
        ),
        (None, false) => (
            "nothing in this recording explains it: it depends on something that is not in the recording",
            "record other influences on this body (other joints, a temperature, a supply, a load) as further columns",
        ),
    };
    // p is of means over coordinates; an event is far beyond what noise does in any block
    let p = if event.is_some() { p.min(LEVEL) } else { p };
    let location = |Part { between: (from, to), share }| Location {
        coordinate: "time".into(),
        from,
        to,
        unit: "s".into(),
        share_of_mismatch: share,
        p,
    };
    let mut locations: Vec<Location> =
        event.into_iter().flat_map(|event| event.parts).map(location).collect();
    // where most of it is stands first
    locations.sort_by(|a, b| b.share_of_mismatch.total_cmp(&a.share_of_mismatch));
    let missing = Missing {
        effect: Unnamed::ABOUT.id.into(),
        says: format!("the error is {:.0} times the noise floor{when}, and {why}", size / floor),
        equation: String::new(),
        parameters: BTreeMap::new(),
        rms_heldout_before: rms,
        rms_heldout_after: rms,
        gain_ci95: [0.0, 0.0],
        p,
        indistinguishable_from: Vec::new(),
        experiment: format!("{experiment}: {left} {unit} are left"),
        free_form: None,
    };
    Some((missing, locations))
}

/// The further columns that the error follows, and the effects that explain as much without them.
pub fn follows(all: &[Followed], instead: &[TermKind]) -> Option<Missing> {
    let (first, last) = (all.first()?, all.last()?);
    let list = |of: &dyn Fn(&Followed) -> String| all.iter().map(of).collect::<Vec<_>>().join(", ");
    let names = list(&|f| f.name.clone());
    Some(Missing {
        effect: Unnamed::ABOUT.id.into(),
        says: match instead {
            [] => format!("the mismatch follows {names}: what acts there is not in the model"),
            _ => format!(
                "the mismatch follows {names}: what acts there is not in the model, or it follows this body's own {}, which \
                 explains as much",
                instead.iter().map(|kind| kind.id().replace('_', " ")).collect::<Vec<_>>().join(" and ")
            ),
        },
        equation: list(&|f| {
            format!("{}curve of {}", if f.with_direction { "sgn(v) times a " } else { "" }, f.name)
        }),
        parameters: BTreeMap::new(),
        rms_heldout_before: first.rms.0,
        rms_heldout_after: last.rms.1,
        gain_ci95: [all.iter().map(|f| f.gain[0]).sum(), all.iter().map(|f| f.gain[1]).sum()],
        p: LEVEL,
        indistinguishable_from: instead.iter().map(|kind| kind.id().into()).collect(),
        experiment: format!("repeat the move with {} held still", first.name),
        free_form: None,
    })
}

/// Where it follows them: over the whole range of each column.
pub fn where_it_follows(all: &[Followed]) -> Vec<Location> {
    let whole = all.first().map_or(1.0, |f| f.rms.0 * f.rms.0);
    let of = |f: &Followed| Location {
        coordinate: f.name.clone(),
        from: f.range().0,
        to: f.range().1,
        unit: unit_of(&f.name).into(),
        share_of_mismatch: (f.rms.0 * f.rms.0 - f.rms.1 * f.rms.1) / whole,
        p: LEVEL,
    };
    all.iter().map(of).collect()
}

/// The unit in a column's name; empty if it has none.
fn unit_of(name: &str) -> &'static str {
    let units = [
        ("_rad_s", "rad/s"),
        ("_m_s", "m/s"),
        ("_rad_s2", "rad/s²"),
        ("_m_s2", "m/s²"),
        ("_nm", "N·m"),
        ("_rad", "rad"),
        ("_n", "N"),
        ("_m", "m"),
        ("_v", "V"),
        ("_a", "A"),
        ("_c", "°C"),
        ("_s", "s"),
        ("_pa", "Pa"),
    ];
    units.iter().find(|(end, _)| name.ends_with(end)).map_or("", |(_, unit)| unit)
}
