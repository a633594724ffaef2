//! The report of a diagnosis.

use crate::chart::{Chart, Ink, Stroke, laid_end_to_end};
use crate::escape::escape;
use crate::fragments::{experiment, faults, parameters};
use crate::number::{html as number, html_with_std as with_std, p_value, percent};
use crate::page::{Page, words};
use diagnose::{
    Bin, CarriesNot, Curve, Diagnosis, ForceError, FreeFormFinding, Location, LooksLike, Missing,
    PerRecording, Verdict,
};
use std::fmt::Write;

/// The report of `diagnosis` of the recording called `name`, as one HTML document.
///
/// Units are those of the recording (N and m, or N·m and rad). Every text is escaped; long series are reduced
/// by min-max decimation, so that the file stays below 2 MB whatever the length of the recording.
#[must_use]
pub fn diagnosis(diagnosis: &Diagnosis, name: &str) -> String {
    let mut page = Page::default();
    head(&mut page, diagnosis, name);
    recording(&mut page, diagnosis);
    conviction(&mut page, diagnosis);
    comparison(&mut page, diagnosis);
    validation(&mut page, diagnosis);
    findings(&mut page, diagnosis);
    instruments(&mut page, diagnosis);
    withdrawn(&mut page, diagnosis);
    baseline(&mut page, diagnosis);
    excluded(&mut page, diagnosis);
    next(&mut page, diagnosis);
    method(&mut page, diagnosis);
    page.finish(&format!("tribos diagnosis of {name}"), &format!("schema {}", diagnosis.schema))
}

fn chip(d: &Diagnosis) -> (&'static str, &'static str) {
    match d.verdict {
        Verdict::Mismatch => ("mismatch", "The simulation misses something"),
        Verdict::NoMismatch if !d.is_down_to_its_noise() => ("not_located", "Nothing that could be located"),
        Verdict::NoMismatch => ("no_mismatch", "Nothing is missing above the noise"),
        Verdict::NotTestable => ("not_testable", "This recording cannot answer"),
    }
}

fn head(page: &mut Page, d: &Diagnosis, name: &str) {
    let (class, words) = chip(d);
    page.html(format!(
        r#"<header><p class="overline"><span class="chip {class}">{words}</span>recording <b>{}</b></p>
<h1>{}</h1>"#,
        escape(name),
        escape(&headline(d))
    ));
    if d.verdict == Verdict::Mismatch && !d.missing.is_empty() {
        page.html(format!(r#"<p class="soft" style="margin-top:12px">{}</p>"#, escape(&d.summary)));
    }
    let unit = escape(&d.noise_floor.unit);
    let ForceError { before, after, of_samples, left_out } = ForceError::of(d);
    let (without, with) = match (of_samples, d.missing.is_empty()) {
        (true, _) => ("as recorded", "set right"),
        (_, true) => ("error of the model", ""),
        _ => ("without the missing physics", "with it"),
    };
    let mut rows: Vec<(&str, f64, &str)> = vec![(without, before, "before")];
    // where nothing explains it the model is the same
    if !d.missing.is_empty() && after != before {
        rows.push((with, after, "after"));
    }
    if !of_samples {
        rows.push(("noise floor", d.noise_floor.rms, "bar"));
    }
    rows.retain(|r| r.1.is_finite());
    let longest = rows.iter().map(|r| r.1).fold(0.0, f64::max);
    if longest > 0.0 {
        let mut ladder = String::from(r#"<div class="ladder">"#);
        for (label, value, ink) in rows {
            let _ = write!(
                ladder,
                r#"<div class="rung"><span>{label}</span><span class="track"><i style="width:{:.1}%;background:var(--{ink})"></i></span><span class="n">{} {unit}</span></div>"#,
                100.0 * value / longest,
                number(value, 3)
            );
        }
        ladder.push_str("</div>");
        page.html(ladder);
        let note = if of_samples {
            "Root-mean-square error of the force a simulation driven by this channel gives, with the noise of one sample."
        } else if let Some(l) = d.left_out.as_ref().filter(|_| left_out) {
            &format!(
                "Root-mean-square force error on {}, which was not fitted. No model can go below the noise floor.",
                escape(&l.on)
            )
        } else {
            "Root-mean-square force error on data the fit did not see. No model can go below the noise floor."
        };
        page.html(format!(r#"<p class="soft" style="margin-top:10px;font-size:13.5px">{note}</p>"#));
    }
    page.html("</header>");
    page.html(faults(&d.recording_faults));
}

/// Missing physics in one sentence: the strongest effect, and the number of others.
fn headline(d: &Diagnosis) -> String {
    let Some(first) = d.missing.first().filter(|_| d.verdict == Verdict::Mismatch) else {
        return d.summary.clone();
    };
    let mut says = sentence(&first.says);
    match d.missing.len() {
        // a statement about the recording, not a law
        1 if first.equation.is_empty() => {}
        1 => says.push_str(" The simulation leaves that out."),
        2 => says.push_str(" The simulation leaves that out, and one effect more."),
        n => {
            let _ = write!(says, " The simulation leaves that out, and {} effects more.", n - 1);
        }
    }
    says
}

/// With a capital and a full stop.
fn sentence(text: &str) -> String {
    let text = text.trim();
    let mut letters = text.chars();
    let mut out: String = letters.next().into_iter().flat_map(char::to_uppercase).collect();
    out.push_str(letters.as_str());
    if !out.ends_with(['.', '!', '?']) {
        out.push('.');
    }
    out
}

/// Main chart: the residual over the coordinate of its location.
fn conviction(page: &mut Page, d: &Diagnosis) {
    let curves: Vec<&Curve> = d.figures.curves.iter().filter(|c| c.bins.len() >= 2).collect();
    let Some((first, rest)) = curves.split_first() else { return };
    page.heading(if d.verdict == Verdict::Mismatch {
        "Where the simulation goes wrong"
    } else {
        "The residual, looked at from every side"
    });
    let told = d.missing.first().is_some_and(|m| m.equation.is_empty());
    let (hero, rest) = match d.location.first().filter(|l| told && l.coordinate == "time") {
        Some(_) => (error_when(d), curves.as_slice()),
        None => (residual_over(first, d, 340).caption(hero_caption(first, d)), rest),
    };
    page.chart(&hero);
    if !d.location.is_empty() {
        page.html(locations(&d.location));
    }
    // the next most informative views, at most six
    let rest = &rest[..rest.len().min(6)];
    if !rest.is_empty() {
        page.html(r#"<h3>The same residual over other coordinates</h3><div class="pair">"#);
        for curve in rest {
            page.chart(&residual_over(curve, d, 200));
        }
        page.html("</div>");
    }
}

fn hero_caption(curve: &Curve, d: &Diagnosis) -> String {
    let here: Vec<&Location> = d.location.iter().filter(|l| l.coordinate == curve.coordinate).collect();
    let mut text = format!(
        "Mean of measured minus predicted force in bins of {}. Inside the grey band a mean is what noise alone gives, for all bins at once, in 95 of 100 recordings.",
        words(&curve.coordinate)
    );
    if let Some(l) = here.first() {
        let _ = write!(
            text,
            " The shaded stretch holds {} of the squared error above the noise floor.",
            percent(l.share_of_mismatch)
        );
    }
    if !d.missing.is_empty() {
        text.push_str(" The blue curve is the same mean once the missing physics is in the model.");
    }
    text
}

/// The error over the time, with what happened once or a few times.
fn error_when(d: &Diagnosis) -> Chart {
    let (error, starts) = error_over_time(d);
    let when: Vec<&Location> = d.location.iter().filter(|l| l.coordinate == "time").collect();
    // recordings laid end to end have another time
    let regions = if starts.is_empty() { when.iter().map(|l| [l.from, l.to]).collect() } else { Vec::new() };
    let shaded = if when.len() == 1 { "stretch holds" } else { "stretches hold" };
    error.height(340).regions("when it happened", regions).caption(format!(
        "The shaded {shaded} {} of the squared error.",
        percent(when.iter().map(|l| l.share_of_mismatch).sum())
    ))
}

/// Measured minus predicted force over the time, and where another recording starts.
fn error_over_time(d: &Diagnosis) -> (Chart, Vec<usize>) {
    let f = &d.figures;
    let (time, starts) = laid_end_to_end(&f.time);
    let less = |model: &[f64]| -> Vec<f64> {
        broken_at(&f.force.iter().zip(model).map(|(m, p)| m - p).collect::<Vec<_>>(), &starts)
    };
    let mut error = Chart::new(format!("measured − predicted, {}", d.noise_floor.unit), "time, s", time)
        .sync("time")
        .series("before", Ink::Before, Stroke::Line, less(&f.before));
    if !d.missing.is_empty() && f.after != f.before {
        error = error.series("after", Ink::After, Stroke::Line, less(&f.after));
    }
    (error, starts)
}

fn residual_over(curve: &Curve, d: &Diagnosis, height: u32) -> Chart {
    let mut bins: Vec<_> = curve.bins.iter().filter(|b| b.at.is_finite()).copied().collect();
    bins.sort_by(|a, b| a.at.total_cmp(&b.at));
    bins.dedup_by(|a, b| a.at == b.at);
    let unit = &d.noise_floor.unit;
    let coordinate = curve.coordinate.replace('_', " ");
    let title = if curve.subset.is_empty() {
        format!("force residual, {unit}, over {coordinate}")
    } else {
        format!("force residual, {unit}, over {coordinate}, {}", curve.subset)
    };
    let x_label = if curve.unit.is_empty() { coordinate } else { format!("{coordinate}, {}", curve.unit) };
    let column = |f: fn(&Bin) -> f64| bins.iter().map(f).collect::<Vec<_>>();
    let regions = d
        .location
        .iter()
        .filter(|l| l.coordinate == curve.coordinate && l.from.is_finite() && l.to.is_finite())
        .map(|l| [l.from, l.to])
        .collect();
    let mut chart = Chart::new(title, x_label, column(|b| b.at))
        .height(height)
        .log_where_crowded()
        .band("95 % band", column(|b| b.band))
        .series("before", Ink::Before, Stroke::Both, column(|b| b.before));
    if !d.missing.is_empty() {
        chart = chart.series("after", Ink::After, Stroke::Both, column(|b| b.after));
    }
    chart.regions("where it sits", regions)
}

fn locations(locations: &[Location]) -> String {
    let mut out = String::from(
        r#"<div class="scroll"><table><tr><th>coordinate</th><th class="n">from</th><th class="n">to</th><th>unit</th><th class="n">share</th><th class="n">p</th></tr>"#,
    );
    for l in locations {
        let _ = write!(
            out,
            r#"<tr><td>{}</td><td class="n">{}</td><td class="n">{}</td><td>{}</td><td class="n">{}</td><td class="n">{}</td></tr>"#,
            words(&l.coordinate),
            number(l.from, 3),
            number(l.to, 3),
            escape(&l.unit),
            percent(l.share_of_mismatch),
            p_value(l.p)
        );
    }
    out.push_str("</table></div>");
    out
}

fn findings(page: &mut Page, d: &Diagnosis) {
    if d.missing.is_empty() {
        return;
    }
    page.heading("What was left out");
    for m in &d.missing {
        page.html(finding(m, &d.noise_floor.unit));
        if let Some(form) = &m.free_form {
            page.chart(&free_form(
                form,
                d.figures.time.first().zip(d.figures.time.last()).map(|(a, b)| b - a),
            ));
            if let Some(hint) = &form.looks_like {
                page.html(looks_like(hint));
            }
            if !form.kin.is_empty() {
                let kin: Vec<String> = form.kin.iter().map(|k| words(k)).collect();
                page.html(format!(
                    "<p>Named at first, and needless beside this curve: {}.</p>",
                    kin.join(", ")
                ));
            }
        }
    }
}

/// What the curve looks like, marked as a hint.
fn looks_like(hint: &LooksLike) -> String {
    let also = hint
        .runner_up
        .as_ref()
        .map_or_else(String::new, |r| format!(" Next best: <code>{}</code>.", escape(r)));
    format!(
        "<p><b>A hint:</b> it looks like <code>gain*{}</code>. In a machine such a curve is usually made by {}.{also}</p>{}",
        escape(&hint.formula),
        escape(&hint.made_by),
        parameters(&hint.parameters)
    )
}

/// The curve of what has no name with its 95 % interval; of a map a curve at the middle and at either end.
/// `seconds` is the length of the recording.
fn free_form(form: &FreeFormFinding, seconds: Option<f64>) -> Chart {
    let mut c = form.curve.clone();
    // a curve stays at its ends, and a change at a moment has nothing but ends
    if let ([only], Some(seconds)) = (form.coordinates.as_slice(), seconds)
        && only == "time"
        && c.period_s.is_none()
    {
        let held = |of: &[f64]| of.first().into_iter().chain(of).chain(of.last()).copied().collect();
        (c.values, c.band) = (held(&c.values), held(&c.band));
        let last = c.knots.last().map_or(seconds, |last| last.max(seconds));
        c.knots = [&[0.0], c.knots.as_slice(), &[last]].concat();
    }
    let axis = |i: usize| {
        let name = form.coordinates.get(i).map_or_else(String::new, |n| n.replace('_', " "));
        match form.units.get(i).filter(|u| !u.is_empty()) {
            Some(unit) => format!("{name}, {unit}"),
            None => name,
        }
    };
    let times = match c.times.as_str() {
        "direction" => " against the motion",
        "velocity" => " per velocity",
        _ => "",
    };
    let chart = Chart::new(format!("force{times}, {}", c.unit), axis(0), c.knots.clone()).height(260);
    let across = c.knots_across.len().max(1);
    let at = |of: &dyn Fn(usize) -> f64, j: usize| (0..c.knots.len()).map(|i| of(i * across + j)).collect();
    let value = |k: usize| c.values.get(k).copied().unwrap_or(f64::NAN);
    let band = |k: usize| c.band.get(k).copied().unwrap_or(f64::NAN);
    if c.knots_across.is_empty() {
        return chart
            .band_between("95 % interval", at(&|k| value(k) + band(k), 0), at(&|k| value(k) - band(k), 0))
            .series("fitted", Ink::After, Stroke::Both, at(&value, 0))
            .caption("What the simulation lacks there, with its 95 % interval at each knot.");
    }
    let name = |j: usize| format!("at {} {}", number(c.knots_across[j], 3), axis(1));
    chart
        .series(&name(0), Ink::Before, Stroke::Both, at(&value, 0))
        .series(&name(across / 2), Ink::Measured, Stroke::Both, at(&value, across / 2))
        .series(&name(across - 1), Ink::After, Stroke::Both, at(&value, across - 1))
        .caption("What the simulation lacks there, cut through at three places of the other coordinate.")
}

/// What was named and withdrawn.
fn withdrawn(page: &mut Page, d: &Diagnosis) {
    if d.does_not_carry_over.is_empty() {
        return;
    }
    page.heading("What does not carry over");
    let unit = escape(&d.noise_floor.unit);
    let row = |w: &CarriesNot| {
        format!(
            r#"<tr><td>{}</td><td>{}</td><td class="n">{}</td><td class="n">{}</td></tr>"#,
            words(&w.effect),
            escape(&w.regime),
            number(w.rms_before, 3),
            number(w.rms_after, 3)
        )
    };
    page.html(format!(
        r#"<p>These effects lower the error of what they are fitted to, and are withdrawn: they do not predict what they are not fitted to, or end on a bound of their shape.</p>
<div class="scroll"><table><tr><th>effect</th><th>fails on</th><th class="n">error without it, {unit}</th><th class="n">with it</th></tr>{}</table></div>"#,
        d.does_not_carry_over.iter().map(row).collect::<String>()
    ));
}

/// Channels that were repaired.
fn instruments(page: &mut Page, d: &Diagnosis) {
    if d.instruments.is_empty() {
        return;
    }
    page.heading("Instruments");
    page.html("<p>Faults of the channels, repaired before anything was fitted. A simulation need not contain them.</p>");
    for m in &d.instruments {
        page.html(finding(m, &d.noise_floor.unit));
    }
}

fn finding(m: &Missing, unit: &str) -> String {
    let unit = escape(unit);
    let mut out = format!(
        r#"<div class="finding"><p>{} <code class="id">{}</code></p><div class="equation">{}</div>"#,
        escape(&sentence(&m.says)),
        escape(&m.effect),
        escape(&m.equation)
    );
    let _ = write!(
        out,
        "<p>Adding it lowers the held-out error from {} to {} {unit}; the gain is between {} and {} {unit} with 95 % confidence (p {}).</p>",
        number(m.rms_heldout_before, 3),
        number(m.rms_heldout_after, 3),
        number(m.gain_ci95[0], 2),
        number(m.gain_ci95[1], 2),
        p_value(m.p),
    );
    out.push_str(&parameters(&m.parameters));
    if m.indistinguishable_from.is_empty() {
        out.push_str("<p>No other effect of the catalogue explains this recording as well.</p>");
    } else {
        let rivals: Vec<String> = m.indistinguishable_from.iter().map(|r| words(r)).collect();
        let _ = write!(
            out,
            "<p><b>It could also be</b> {}: on this recording they cannot be told apart.{}</p>",
            rivals.join(", "),
            if m.experiment.trim().is_empty() { "" } else { " This would:" }
        );
        out.push_str(&experiment(&m.experiment));
    }
    out.push_str("</div>");
    out
}

/// Recordings not used for the fit, with frozen structure and parameters.
fn validation(page: &mut Page, d: &Diagnosis) {
    if !d.nuisances.is_empty() {
        page.heading("What differs between the recordings");
        let rows =
            d.nuisances.iter().map(|n| format!("<tr><td>{}</td>{}</tr>", escape(&n.recording), nuisance(n)));
        page.html(format!(
            r#"<p>Declared to differ, relative to the first recording; everything else is shared.</p>
<div class="scroll"><table><tr><th>recording</th><th>what</th><th class="n">value</th><th class="n">std</th><th>unit</th></tr>{}</table></div>"#,
            rows.collect::<String>()
        ));
    }
    if d.validation.is_empty() {
        return;
    }
    let unit = escape(&d.noise_floor.unit);
    page.heading("On recordings it has not seen");
    let mut table = format!(
        r#"<p>Structure and parameters frozen; root-mean-square force error, and its share of the force.</p>
<div class="scroll"><table><tr><th>recording</th><th class="n">before, {unit}</th><th class="n">after, {unit}</th><th class="n">before</th><th class="n">after</th><th>fitted again</th></tr>"#
    );
    for v in &d.validation {
        let again: Vec<String> = v.refitted.iter().map(|r| words(r)).collect();
        let _ = write!(
            table,
            r#"<tr><td>{}</td><td class="n">{}</td><td class="n">{}</td><td class="n">{} %</td><td class="n">{} %</td><td>{}</td></tr>"#,
            escape(&v.recording),
            number(v.rms_before, 3),
            number(v.rms_after, 3),
            number(100.0 * v.relative_before, 3),
            number(100.0 * v.relative_after, 3),
            if again.is_empty() { "nothing".into() } else { again.join(", ") }
        );
    }
    table.push_str("</table></div>");
    let again: Vec<_> = d.validation.iter().filter(|v| v.rms_after_refitted.is_some()).collect();
    if !again.is_empty() {
        let _ = write!(
            table,
            r#"<p>Beside the frozen figures, the same with the nuisances fitted again that were declared to differ:</p>
<div class="scroll"><table><tr><th>recording</th><th class="n">before, {unit}</th><th class="n">after, {unit}</th><th>fitted again</th><th class="n">value</th><th class="n">std</th><th>unit</th></tr>"#
        );
        for v in again {
            let cell = |x: Option<f64>| number(x.unwrap_or(f64::NAN), 3);
            let first = v.nuisances.first().map_or_else(
                || r#"<td>nothing</td><td class="n"></td><td class="n"></td><td></td>"#.to_string(),
                nuisance,
            );
            let _ = write!(
                table,
                r#"<tr><td>{}</td><td class="n">{}</td><td class="n">{}</td>{first}</tr>"#,
                escape(&v.recording),
                cell(v.rms_before_refitted),
                cell(v.rms_after_refitted),
            );
            for n in v.nuisances.iter().skip(1) {
                let _ = write!(table, r#"<tr><td></td><td></td><td></td>{}</tr>"#, nuisance(n));
            }
        }
        table.push_str("</table></div>");
    }
    page.html(table);
}

/// Cells of a nuisance parameter: name, value, standard error, unit.
fn nuisance(n: &PerRecording) -> String {
    let (value, std) = with_std(n.value, n.std);
    format!(
        r#"<td>{}</td><td class="n">{value}</td><td class="n">{std}</td><td>{}</td>"#,
        words(&n.nuisance),
        escape(&n.unit)
    )
}

/// Interrupts a line between recordings.
fn broken_at(values: &[f64], starts: &[usize]) -> Vec<f64> {
    let mut out = values.to_vec();
    for &start in starts {
        if let Some(v) = out.get_mut(start) {
            *v = f64::NAN;
        }
    }
    out
}

fn comparison(page: &mut Page, d: &Diagnosis) {
    let f = &d.figures;
    if f.time.len() < 2 {
        return;
    }
    let (time, starts) = laid_end_to_end(&f.time);
    let line = |v: &[f64]| broken_at(v, &starts);
    let unit = &d.noise_floor.unit;
    let named = !d.missing.is_empty();
    page.heading("Measured against simulated");
    let mut force = Chart::new(format!("force, {unit}"), "time, s", time.clone())
        .height(270)
        .sync("time")
        .series("measured", Ink::Measured, Stroke::Line, line(&f.force))
        .series("before", Ink::Before, Stroke::Line, line(&f.before));
    if named {
        force = force.series("after", Ink::After, Stroke::Dashed, line(&f.after));
    }
    page.chart(&force);
    page.chart(&error_over_time(d).0.height(220).caption(
        "Each sample is predicted by a fit that did not see its block. Drag across a chart to look closer, double-click to go back.",
    ));
    if f.free_run_position.len() == f.time.len() {
        let length = length_unit(unit);
        page.chart(
            &Chart::new(format!("position in free run, {length}"), "time, s", time)
                .height(220)
                .sync("time")
                .series("measured", Ink::Measured, Stroke::Line, line(&f.position))
                .series(
                    "simulated from the start, no correction",
                    Ink::After,
                    Stroke::Dashed,
                    line(&f.free_run_position),
                ),
        );
    }
}

/// Position unit of a force unit.
fn length_unit(force_unit: &str) -> &'static str {
    if force_unit.trim() == "N" { "m" } else { "rad" }
}

fn recording(page: &mut Page, d: &Diagnosis) {
    let f = &d.figures;
    if f.time.len() < 2 {
        return;
    }
    let (time, starts) = laid_end_to_end(&f.time);
    let length = length_unit(&d.noise_floor.unit);
    page.heading("The recording");
    for (title, values) in
        [(format!("position, {length}"), &f.position), (format!("velocity, {length}/s"), &f.velocity)]
    {
        page.chart(&Chart::new(title, "time, s", time.clone()).height(180).sync("time").series(
            "measured",
            Ink::Measured,
            Stroke::Line,
            broken_at(values, &starts),
        ));
    }
    if !starts.is_empty() {
        page.html(format!(r#"<p class="soft">{} recordings, laid end to end.</p>"#, starts.len() + 1));
    }
}

fn baseline(page: &mut Page, d: &Diagnosis) {
    page.heading("The model it was compared with");
    page.html(format!(
        "<p>A mass with {} friction, fitted jointly with every candidate and with the delay and offset of the sensors.</p>",
        words(&d.baseline.law)
    ));
    page.html(parameters(&d.baseline.parameters));
    if !d.missing.is_empty() && !d.after.parameters.is_empty() {
        page.html("<p>The same parameters once the missing physics is in the model:</p>");
        page.html(parameters(&d.after.parameters));
    }
}

fn excluded(page: &mut Page, d: &Diagnosis) {
    if !d.rejected.is_empty() {
        page.heading("What is ruled out");
        page.html("<p>Tested, and not there: with 95 % confidence the force of each is below its bound.</p>");
        let top = d.rejected.iter().map(|r| r.upper_bound).filter(|b| b.is_finite()).fold(0.0, f64::max);
        let mut table = String::from(
            r#"<div class="scroll"><table><tr><th>effect</th><th class="n">at most (rms)</th><th>unit</th></tr>"#,
        );
        for r in &d.rejected {
            let share =
                if top > 0.0 && r.upper_bound.is_finite() { 100.0 * r.upper_bound / top } else { 0.0 };
            let _ = write!(
                table,
                r#"<tr><td>{}</td><td class="n">{}<span class="meter"><i style="width:{share:.0}%"></i></span></td><td>{}</td></tr>"#,
                words(&r.effect),
                number(r.upper_bound, 2),
                escape(&r.unit)
            );
        }
        table.push_str("</table></div>");
        page.html(table);
    }
    if !d.blind_to.is_empty() {
        page.heading("What this recording cannot show");
        page.html("<p>These may be present; this motion would look the same with and without them.</p>");
        let mut table = String::from(
            r#"<div class="scroll"><table><tr><th>effect</th><th>because</th><th>a recording that would show it</th></tr>"#,
        );
        for b in &d.blind_to {
            let _ = write!(
                table,
                "<tr><td>{}</td><td>{}</td><td>{}</td></tr>",
                words(&b.effect),
                escape(&b.because),
                escape(&b.experiment)
            );
        }
        table.push_str("</table></div>");
        page.html(table);
    }
}

fn next(page: &mut Page, d: &Diagnosis) {
    let found = d.missing.iter().filter(|m| !m.indistinguishable_from.is_empty()).map(|m| &m.experiment);
    let unseen = d.blind_to.iter().map(|b| &b.experiment);
    let Some(first) = found.chain(unseen).find(|e| !e.trim().is_empty()) else { return };
    page.heading("What to record next");
    page.html(experiment(first));
    page.html(r#"<p>Then diagnose both recordings together: <code>tribos diagnose first.csv --validate next.csv --report next.html</code></p>"#);
}

fn method(page: &mut Page, d: &Diagnosis) {
    page.heading("How this was computed");
    let unit = escape(&d.noise_floor.unit);
    let mut list = format!(
        r#"<ul class="plain"><li>Noise floor {} {unit}, from {}.</li>
<li>Every signal and every regressor passes the same zero-phase filter ({} Hz); both ends are trimmed by its length. Every error here is behind that filter.</li>
<li>The baseline is fitted jointly with every candidate and the nuisances, never to the residual of a frozen baseline.</li>
<li>Bands and p values of a location come from flipping the sign of whole blocks of the residual (maximum statistic, so that looking at many bins is paid for).</li>
<li>Held-out means blocks, or recordings, not used for the fit; the interval of a gain is a block bootstrap.</li>"#,
        number(d.noise_floor.rms, 3),
        escape(&d.noise_floor.how),
        number(d.cutoff_hz, 3)
    );
    if d.fitted_share < 1.0 {
        let _ = write!(
            list,
            "<li>Parts spread evenly over the recording were fitted, {} of its samples.</li>",
            percent(d.fitted_share)
        );
    }
    if d.detectable.is_finite() {
        let _ = write!(
            list,
            "<li>An effect of about {} {unit} (rms) or more would have been seen.</li>",
            number(d.detectable, 2)
        );
    }
    if !d.missing.is_empty() {
        let _ = write!(
            list,
            "<li>With everything named, {} of the mismatch above the noise floor is explained; {} {unit} (rms) remain{}.</li>",
            percent(d.after.explained_share),
            number(d.remainder.rms, 3),
            match d.remainder.located_at.first() {
                Some(l) => format!(", most of it over {}", words(&l.coordinate)),
                None => ", nowhere in particular".into(),
            }
        );
        if let Some(error) = d.after.free_run_error.filter(|e| e.is_finite()) {
            let _ = write!(
                list,
                "<li>Run freely over the whole recording, the final model misses the position by {} of its range.</li>",
                number(error, 2)
            );
        }
    }
    list.push_str("</ul>");
    page.html(list);
}
