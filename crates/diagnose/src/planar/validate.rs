//! Recordings in the plane that were not fitted: what baseline and model, frozen, leave of their force.

use super::design::{Design, tracks};
use super::search::Hypothesis;
use super::term::Kind;
use crate::options::Error;
use crate::result::Validation;
use signals::{
    Cutoff, FaultKind, PlanarRecording, RecordingFault, Settings, dot, prepare_planar, subtract_scaled,
};

/// Judges each recording by itself, behind the filter of those that were fitted: `before` and `after` what was found. A
/// recording of which too little is left is a fault.
///
/// # Errors
/// A recording that cannot be prepared.
pub(super) fn judged(
    recordings: &[PlanarRecording],
    fitted: &Design,
    [before, after]: [&Hypothesis; 2],
    cutoff: f64,
) -> Result<(Vec<Validation>, Vec<RecordingFault>), Error> {
    let (mut judged, mut faults) = (Vec::new(), Vec::new());
    let settings = Settings { cutoff: Cutoff::Given(cutoff), ..Settings::default() };
    for recording in recordings {
        let prepared = prepare_planar(recording, &settings)?;
        let (tracks, of) = tracks(&[prepared], cutoff);
        let Some(mut design) = Design::new(tracks, &of) else {
            let name = &recording.name;
            let why = format!(
                "{name} cannot judge: behind a filter at {cutoff:.3} Hz too few samples are left at which the body slides in \
                 a known direction"
            );
            faults.push(RecordingFault::new(FaultKind::TooShort, None, why));
            continue;
        };
        // its own motion may tell fewer apart; nothing is fitted here
        design.present.clone_from(&fitted.present);
        let rows: f64 = design.share.iter().sum::<f64>().max(1.0);
        let size = dot(&design.force, &design.force).max(1e-300);
        let [before, after] = [before, after].map(|h| {
            let rest = rest(&design, h);
            dot(&rest, &rest)
        });
        judged.push(Validation {
            recording: recording.name.clone(),
            rms_before: (before / rows).sqrt(),
            rms_after: (after / rows).sqrt(),
            relative_before: (before / size).sqrt(),
            relative_after: (after / size).sqrt(),
            refitted: Vec::new(),
            rms_before_refitted: None,
            rms_after_refitted: None,
            relative_before_refitted: None,
            relative_after_refitted: None,
            nuisances: Vec::new(),
        });
    }
    Ok((judged, faults))
}

/// What a frozen hypothesis leaves of the force.
fn rest(design: &Design, h: &Hypothesis) -> Vec<f64> {
    let mut design = design.clone();
    design.ellipse = h.ellipse;
    let mut columns = design.baseline();
    for term in &h.terms {
        columns.extend(term.columns(&design));
    }
    let bends = h.terms.iter().any(|t| t.kind == Kind::Anisotropy);
    let mut rest = design.target(&if bends { design.anisotropy() } else { Vec::new() });
    for (column, c) in columns.iter().zip(&h.fit.coefficients) {
        subtract_scaled(&mut rest, *c, column);
    }
    rest
}
