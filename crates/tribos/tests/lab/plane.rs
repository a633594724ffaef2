//! The planar handle: forces of a dragged path against the law, and a circle of the targeting task.

use crate::browser::{Lab, Page, chromium};
use friction::planar::{Grain, Vector};
use perception::{Record, Session};
use serde_json::Value;
use std::f64::consts::TAU;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

/// A step as the page received it: time s; hand, puck m; pull, friction N; stuck.
struct Step {
    time: f64,
    puck: Vector<f64>,
    pull: Vector<f64>,
    friction: Vector<f64>,
    stuck: bool,
}

/// The page with the plane, of a lab that keeps its sessions in `folder`.
fn plane_page(folder: &Path) -> (Lab, Page) {
    let chromium = chromium();
    let lab = Lab::start(folder, &["sim"]);
    let mut page = Page::of(&lab, &chromium, (1280, 860));
    page.eval("document.querySelector('#tab-plane').click()");
    page.until("the plane", "lab.plane.rows.length > 20", 10);
    (lab, page)
}

/// Centre of the canvas, and CSS pixels of a metre.
fn scale(page: &mut Page) -> [f64; 3] {
    let read = page.eval(
        "(() => { const c = document.querySelector('#plane-canvas'), r = c.getBoundingClientRect(), [x, y] = lab.plane.shown.reach; \
          return [r.left + 0.5 * r.width, r.top + 0.5 * r.height, Math.min(r.width / (2.12 * x), r.height / (2.16 * y))]; })()",
    );
    serde_json::from_value(read).expect("three numbers")
}

/// Waits until the puck rests: what slides on after the drag belongs to the work, too.
fn at_rest(page: &mut Page) {
    page.until(
        "at rest",
        "lab.plane.rows.length > 50 && lab.plane.rows.slice(-50).every((row) => row[1][2] === lab.plane.rows.at(-1)[1][2])",
        10,
    );
}

fn choose(page: &mut Page, surface: &str) {
    page.eval(&format!("document.querySelector('#surfaces [data-name={surface}]').click()"));
    page.until("the surface", &format!("lab.plane.shown.surface === '{surface}'"), 5);
    at_rest(page);
    page.eval("lab.plane.rows.length = lab.plane.spots.length = 0");
}

/// Drags the pointer along a path, m, with the button down; where it is then.
fn drag(page: &mut Page, path: impl Iterator<Item = (f64, f64)>) -> (f64, f64) {
    let [x, y, per] = scale(page);
    let mut kind = "mousePressed";
    let mut last = (x, y);
    for (a, b) in path {
        last = (x + a * per, y - b * per);
        page.mouse(kind, last.0, last.1);
        kind = "mouseMoved";
        std::thread::sleep(Duration::from_millis(8));
    }
    page.picture("plane-dragged");
    last
}

fn release(page: &mut Page, (x, y): (f64, f64)) {
    page.mouse("mouseReleased", x, y);
}

fn steps(page: &mut Page) -> Vec<Step> {
    let rows: Vec<(f64, [f64; 8], u8)> =
        serde_json::from_value(page.eval("lab.plane.rows")).expect("rows of the puck");
    let at = |[x, y]: [f64; 2]| Vector { x, y };
    let step = |(time, [_, _, px, py, fx, fy, qx, qy], stuck): (f64, [f64; 8], u8)| Step {
        time,
        puck: at([px, py]),
        pull: at([fx, fy]),
        friction: at([qx, qy]),
        stuck: stuck == 1,
    };
    rows.into_iter().map(step).collect()
}

pub fn the_force_of_a_dragged_puck_is_that_of_the_law() {
    let folder = tempfile::tempdir().expect("a folder");
    let (_lab, mut page) = plane_page(folder.path());

    // wood: 1.2 N along a grain of 0.35 rad, twice as much across it
    choose(&mut page, "wood");
    let end = drag(
        &mut page,
        (0..180).map(|k| TAU * f64::from(k) / 150.0).map(|a| (0.035 * a.sin(), 0.03 * (1.0 - a.cos()))),
    );
    // a puck that is released on the way comes to rest without a pull
    at_rest(&mut page);
    release(&mut page, end);
    at_rest(&mut page);
    let all = steps(&mut page);
    let grain = Grain::at(0.35, 2.0);
    let (mut sliding, mut worst, mut veers, mut lost) = (0, 0.0_f64, 0.0_f64, 0.0);
    for pair in all.windows(2) {
        let (before, now) = (&pair[0], &pair[1]);
        assert!((now.time - before.time - 1e-3).abs() < 1e-9, "every step arrives");
        let way = now.puck - before.puck;
        lost += now.friction.dot(way);
        let v = way * 1e3;
        // places are single precision: 4 nm
        if now.stuck || v.norm() < 5e-3 {
            continue;
        }
        sliding += 1;
        let law = grain.sliding(v, 1.2);
        worst = worst.max((now.friction - law).norm());
        veers = veers.max((v.x * law.y - v.y * law.x).abs() / v.norm() / law.norm());
    }
    let held = all.iter().filter(|step| step.stuck && step.pull.norm() > 0.1).count();
    println!(
        "wood: {} steps, {sliding} sliding, {held} held; friction off the law by {:.2e} N at most, off the path by {:.0} % of it",
        all.len(),
        worst,
        100.0 * veers
    );
    assert!(sliding > 300 && worst < 5e-3 && veers > 0.3);
    let said = page.eval("lab.plane.work.friction").as_f64().expect("J");
    assert!((said / lost - 1.0).abs() < 0.01, "{said} J said, {lost} J by the steps");
    assert!(page.eval("lab.plane.spots.length").as_u64() >= Some(1), "where it came to rest is marked");
    page.picture("plane-wood");
    page.dark(true);
    page.picture("plane-wood-dark");
    page.dark(false);

    // detents take nothing
    choose(&mut page, "detents");
    let end = drag(&mut page, (0..200).map(|k| (0.02 * (TAU * f64::from(k) / 200.0).sin(), 0.0)));
    release(&mut page, end);
    page.picture("plane-detents");
    let work: Value = page.eval("lab.plane.work");
    println!("detents: {work}");
    assert_eq!(work["friction"].as_f64(), Some(0.0));

    // by keyboard
    choose(&mut page, "brass");
    page.eval("document.querySelector('#plane-canvas').focus()");
    for _ in 0..12 {
        page.key("ArrowRight");
    }
    page.until(
        "the puck follows the keys",
        "lab.plane.rows.at(-1)[1][2] > lab.plane.rows[0][1][2] + 0.004",
        5,
    );
    page.key("Home");
    page.until("released", "lab.plane.target === null && lab.plane.rows.at(-1)[1][4] === 0", 5);
}

pub fn a_circle_of_targets_is_selected_kept_and_analysed() {
    let folder = tempfile::tempdir().expect("a folder");
    let (_lab, mut page) = plane_page(folder.path());
    page.eval("document.querySelector('#ring-begin button').click()");
    page.until("a circle", "lab.plane.shown.circle", 5);
    let [x, y, per] = scale(&mut page);
    for selection in 0..14 {
        let now: Value = page.eval("lab.plane.shown.circle");
        let target: [f64; 2] = serde_json::from_value(now["target"].clone()).expect("a target");
        let near = 0.3 * now["width"].as_f64().expect("m");
        let mut aim = target;
        // a puck that slides on may leave the target between the look and the key: it has to rest there
        let look = "(() => { const last = lab.plane.rows.at(-1)[1].slice(2, 4); \
                    return [last, lab.plane.rows.slice(-40).every((row) => row[1][2] === last[0] && row[1][3] === last[1])]; })()";
        for _ in 0..400 {
            page.mouse("mouseMoved", x + aim[0] * per, y - aim[1] * per);
            std::thread::sleep(Duration::from_millis(40));
            let (at, rests): ([f64; 2], bool) = serde_json::from_value(page.eval(look)).expect("a place");
            let off = [target[0] - at[0], target[1] - at[1]];
            if off[0].hypot(off[1]) >= near {
                aim = [aim[0] + 0.1 * off[0], aim[1] + 0.1 * off[1]];
            } else if rests {
                break;
            }
        }
        if selection == 7 {
            page.picture("plane-circle");
        }
        page.key("Enter");
        let taken = format!("lab.plane.shown.circle.selections === {}", (selection + 1) % 14);
        page.until("the selection is taken", &taken, 5);
    }
    page.until(
        "a circle is finished",
        "lab.plane.shown.circle.done === 1 && lab.plane.shown.scores.length === 1",
        5,
    );
    page.picture("plane-score");
    let text = page.eval("fetch(document.querySelector('#ring-file').href).then((r) => r.text())");
    assert_eq!(
        text.as_str().map(|text| text.lines().count()),
        Some(2),
        "header and one circle are downloaded"
    );
    let kept = Session::read(&folder.path().join("plane-s01-1.jsonl")).expect("a session");
    let Record::Ring(trial) = &kept.records[0] else { panic!("a circle") };
    let speed = trial.throughput().expect("13 movements");
    println!("{} {:.2} bits: {speed:?}", trial.case.surface, trial.id_bits);
    assert_eq!((trial.clicks.len(), trial.errors, speed.movements), (14, 0, 13));
    // what the page shows is what the file gives
    let shown = page.eval("lab.plane.shown.scores[0].bits_per_s").as_f64().expect("bit/s");
    assert!((shown - speed.bits_per_s).abs() < 1e-12);
    page.until("it is listed", "lab.known.sessions.some((s) => s.kind === 'plane' && s.done === 1)", 5);
    let analysed = Command::new(env!("CARGO_BIN_EXE_tribos"))
        .args(["experiment", "analyse"])
        .arg(folder.path())
        .output()
        .expect("tribos runs");
    let text = String::from_utf8_lossy(&analysed.stdout).into_owned();
    println!("{text}");
    assert!(text.contains(&trial.case.surface) && text.contains(&format!("{:.2}", speed.bits_per_s)));
}
