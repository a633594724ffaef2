//! The live trace: every sample, and what is felt.

use crate::browser::{Lab, Page, chromium};
use crate::cost::{cpu, paint_and_latency};
use std::time::{Duration, Instant};

/// Drags the handle to and fro on the page's strip, with the mouse, for so long.
fn drag(page: &mut Page, seconds: f64) {
    let place = page.eval("(() => { const r = document.querySelector('#handle').getBoundingClientRect(); return [r.left, r.top, r.width, r.height]; })()");
    let place: Vec<f64> = serde_json::from_value(place).expect("a rectangle");
    let (middle, y) = (place[0] + 0.5 * place[2], place[1] + 0.4 * place[3]);
    let began = Instant::now();
    page.mouse("mousePressed", middle, y);
    while began.elapsed().as_secs_f64() < seconds {
        let t = began.elapsed().as_secs_f64();
        // a triangle: constant speed between the turns
        let phase = (t / 1.1).fract();
        let share = if phase < 0.5 { 4.0 * phase - 1.0 } else { 3.0 - 4.0 * phase };
        page.mouse("mouseMoved", middle + 0.3 * place[2] * share, y);
        std::thread::sleep(Duration::from_millis(8));
    }
    page.mouse("mouseReleased", middle, y);
}

/// Samples received, lost, batches skipped, and the worst gap in time, in periods.
const HEALTH: &str = "(() => { const r = lab.ring; let worst = 0; \
    for (let i = r.start + 1; i < r.end; i++) worst = Math.max(worst, (r.at('time', i) - r.at('time', i - 1)) / r.period); \
    return [r.end, r.lost, r.skipped, worst, r.newest - r.at('time', r.start)]; })()";

/// Rubber is felt as what it is: the load cell against the preset's Coulomb and viscous friction on this device.
fn friction_is_felt(page: &mut Page) {
    page.eval("document.querySelector('[data-preset=rubber]').click()");
    page.until("the preset", "lab.known.preset === 'rubber'", 10);
    page.eval("document.querySelector('#arm').click()");
    page.until("force on", "lab.known.mode === 'rendering'", 10);
    drag(page, 4.0);
    // sliding faster than rubber's Δv of 20 mm/s, 50 ms before and after. The load cell between hand and handle carries
    // the rubber [thesis, table 3-3], and the device's own damping and mass and the block's besides
    let read = page.eval(
        "(() => { const r = lab.ring; const out = { p: [0, 0, 0], n: [0, 0, 0] }; \
          const slides = (i) => Math.abs(r.at('velocity', i)) > 0.022 && r.at('mode', i) === 1; \
          for (let i = r.start + 60; i < r.end - 60; i++) { const v = r.at('velocity', i); let all = true; \
            for (let k = -50; all && k <= 50; k += 5) all = slides(i + k) && r.at('velocity', i + k) * v > 0; \
            if (!all) continue; \
            const a = (r.at('velocity', i + 15) - r.at('velocity', i - 15)) / (30 * r.period); \
            const o = v > 0 ? out.p : out.n; \
            const own = 6.92 * v + (0.692 + 0.3886) * a; \
            const law = v > 0 ? 3.4901 + 8.7338 * v + own : 2.5611 - 7.9521 * v - own; \
            o[0]++; o[1] += Math.abs(r.at('force', i)); o[2] += law; } \
          return out; })()",
    );
    for (side, least) in [("p", 100.0), ("n", 100.0)] {
        let [count, felt, law]: [f64; 3] = serde_json::from_value(read[side].clone()).expect("sums");
        println!(
            "rubber, {side}: {count} samples of sliding, load cell {:.3} N, law {:.3} N",
            felt / count,
            law / count
        );
        assert!(count >= least, "the handle slid for {count} samples");
        assert!((felt / law - 1.0).abs() < 0.02, "felt {} N, law {} N", felt / count, law / count);
    }
}

fn trace_is_live(seconds: u64) {
    let chromium = chromium();
    let folder = tempfile::tempdir().expect("a folder");
    let lab = Lab::start(folder.path(), &["sim"]);
    let mut page = Page::of(&lab, &chromium, (1400, 950));
    friction_is_felt(&mut page);
    page.picture("scope-light");
    let ran =
        |page: &mut Page| -> [f64; 5] { serde_json::from_value(page.eval(HEALTH)).expect("five numbers") };
    let before = ran(&mut page);
    let (lab_cpu, browser_cpu, began) = (cpu(lab.child.id()), cpu(page.pid()), Instant::now());
    let mut drawn = 0;
    let mut last = f64::NAN;
    while began.elapsed() < Duration::from_secs(seconds) {
        drag(&mut page, 1.0);
        let newest = page.eval("lab.scope.newestDrawn").as_f64().expect("a time");
        drawn += u32::from(newest > last);
        last = newest;
    }
    let took = began.elapsed().as_secs_f64();
    let share = |now: f64, before: f64| 100.0 * (now - before) / took;
    let after = ran(&mut page);
    println!(
        "{took:.1} s: {} samples, {} lost, {} batches skipped, worst gap {:.3} periods; the trace was newer in {drawn} looks, \
         CPU: lab {:.0} %, browser {:.0} % of a core",
        after[0] - before[0],
        after[1],
        after[2],
        after[3],
        share(cpu(lab.child.id()), lab_cpu),
        share(cpu(page.pid()), browser_cpu),
    );
    assert_eq!((after[1], after[2]), (0.0, 0.0), "nothing is lost");
    assert!(after[3] < 1.5, "no sample is missing in between");
    assert!(drawn + 1 >= seconds as u32 / 2, "the trace moves: {drawn}");
    // a stop from the keyboard, whatever has the focus
    page.key("Escape");
    page.until("stopped by Escape", "lab.known.mode === 'idle' && !lab.known.armed", 5);
    paint_and_latency(&mut page);
}

pub fn the_trace_is_live_at_1_khz_and_rubber_feels_like_rubber() {
    trace_is_live(5);
}

pub fn the_trace_is_live_for_a_minute() {
    trace_is_live(60);
}

pub fn a_fault_is_told_in_plain_words_and_cleared_from_the_page() {
    let chromium = chromium();
    let folder = tempfile::tempdir().expect("a folder");
    let lab = Lab::start(folder.path(), &["sim"]);
    let mut page = Page::of(&lab, &chromium, (1400, 950));
    page.eval("document.querySelector('#arm').click()");
    page.until("force on", "lab.known.mode === 'rendering'", 10);
    // a hand that is faster than the device allows
    page.eval("lab.wire.ask({ do: 'hand_sine', amplitude: 0.015, frequency: 10 })");
    page.until("the fault", "lab.known.fault && !document.querySelector('#fault').hidden", 10);
    let said = page.eval("document.querySelector('#fault').textContent");
    println!("{said}");
    assert!(
        said.as_str().is_some_and(|text| text.contains("Force is off") && text.contains("Clear the fault"))
    );
    assert!(
        page.eval("lab.known.mode === 'fault' && document.querySelector('#arm').disabled")
            .as_bool()
            .unwrap_or(false)
    );
    page.picture("fault");
    page.eval("lab.wire.ask({ do: 'hand', at: null })");
    page.until("the handle rests", "Math.abs(lab.ring.at('velocity', lab.ring.end - 1)) < 0.002", 10);
    page.eval("document.querySelector('#clear').click()");
    page.until("cleared", "lab.known.mode === 'idle' && document.querySelector('#fault').hidden", 10);
    let arm = page.eval("[lab.known.armed, document.querySelector('#arm').textContent]");
    assert_eq!(
        arm,
        serde_json::json!([false, "Arm: force on"]),
        "after a fault it is armed anew, or not at all"
    );
}

pub fn a_picture_of_a_minute_shows_the_one_sample_that_stands_out_and_the_gap() {
    let chromium = chromium();
    let folder = tempfile::tempdir().expect("a folder");
    let lab = Lab::start(folder.path(), &["sim"]);
    let mut page = Page::of(&lab, &chromium, (1000, 700));
    let seen = page.eval(
        "(() => { const r = new lab.ring.constructor(); r.clear(1, 0.001); \
          const batch = (from, count) => { const view = new DataView(new ArrayBuffer(16 + 32 * count)); \
            for (let k = 0; k < count; k++) { const i = from + k; view.setFloat64(16 + 32 * k, i * 0.001, true); \
              view.setFloat32(24 + 32 * k, i === 12345 ? 7 : i === 23456 ? -5 : 0.001 * (i % 2), true); } \
            return { view, epoch: 1, count, number: from / 1000, lost: 0 }; }; \
          for (let from = 0; from < 60000; from += 1000) if (from < 40000 || from >= 43000) r.push(batch(from, 1000)); \
          const [t, x] = r.picture(['position'], 0, 60, 800); const real = x.filter((v) => v !== null); \
          const gap = x.indexOf(null); \
          return { points: t.length, high: Math.max(...real), low: Math.min(...real), gaps: x.length - real.length, \
            gap: t[gap], rising: t.every((v, k) => !k || v >= t[k - 1]), skipped: r.skipped, \
            sawtooth: real.filter((v) => Math.abs(v - 0.001) < 1e-6).length }; })()",
    );
    println!("57 000 samples, 800 columns: {seen}");
    assert!(seen["points"].as_f64().is_some_and(|points| points <= 1_602.0));
    assert_eq!((&seen["high"], &seen["low"]), (&serde_json::json!(7), &serde_json::json!(-5)));
    assert_eq!((&seen["gaps"], &seen["rising"]), (&serde_json::json!(1), &serde_json::json!(true)));
    assert!(seen["gap"].as_f64().is_some_and(|t| (t - 40.0).abs() < 0.075), "the gap is where it was");
    // 3 000 samples were never sent: three batches of a thousand
    assert_eq!(seen["skipped"], serde_json::json!(3));
    // what alternates from sample to sample keeps its height in every column
    assert!(seen["sawtooth"].as_f64().is_some_and(|n| n > 700.0));
}
