//! The experiments of the lab, run by script through the page; what is kept when device, server or browser die.

use crate::browser::{Lab, Page, chromium};
#[cfg(unix)]
use crate::cable::Cable;
use perception::{Record, Session};
use serde_json::json;
use std::path::Path;
use std::time::Duration;

fn session(folder: &Path, name: &str) -> Session {
    Session::read(&folder.join(format!("{name}.jsonl"))).expect("a session")
}

fn connected(lab: &Lab, chromium: &Path) -> Page {
    Page::of(lab, chromium, (1280, 860))
}

/// Opens a session by its form.
fn begin(page: &mut Page, what: &str) {
    page.eval("document.querySelector('#tab-try').click(); document.querySelector('#begin').elements.practice.checked = false");
    page.eval(&format!("document.querySelector('#begin [value={what}]').click()"));
    page.until("the stage", "!document.querySelector('#stage').hidden && lab.known.experiment", 10);
}

/// Presses Enter until the trial runs: first it arms, then it starts.
fn start(page: &mut Page) {
    for _ in 0..2 {
        if page.eval("lab.known.experiment.running") == json!(true) {
            return;
        }
        let armed = page.eval("lab.known.experiment.armed") == json!(true);
        page.key("Enter");
        let wanted = if armed { "lab.known.experiment.running" } else { "lab.known.experiment.armed" };
        page.until("armed, then started", wanted, 10);
    }
}

/// Goes through the cases of a trial, each once the one before it is felt.
fn feel_every_case(page: &mut Page) {
    for case in ["a", "b"] {
        page.key("Enter");
        page.until("the next case", &format!("lab.known.experiment.cases.case === '{case}'"), 5);
    }
}

/// Feels every case and answers; `done` trials are then finished.
fn answer(page: &mut Page, key: &str, done: u32) {
    feel_every_case(page);
    page.key(key);
    page.until("answered", &format!("lab.known.experiment.done === {done}"), 5);
}

/// Goes to the target and clicks, until so many valid clicks or the segment is over.
fn click_targets(page: &mut Page, clicks: u32) {
    for _ in 0..clicks {
        let before = page.eval("[lab.known.experiment.done, lab.known.experiment.targets.valid]");
        page.eval("(() => { const t = lab.known.experiment.targets; lab.wire.ask({ do: 'hand', at: 0.5 * t.side * t.distance_px * t.metre_per_px }); })()");
        page.until(
            "the cursor rests in the target",
            "(() => { const t = lab.known.experiment.targets, i = lab.ring.end - 1; \
              const off = lab.ring.at('position', i) - 0.5 * t.side * t.distance_px * t.metre_per_px; \
              return Math.abs(off) < 0.3 * t.width_px * t.metre_per_px && Math.abs(lab.ring.at('velocity', i)) < 0.005; })()",
            15,
        );
        page.key("Enter");
        page.until(
            "the click is taken",
            &format!("JSON.stringify([lab.known.experiment.done, lab.known.experiment.targets.valid]) !== '{before}'"),
            5,
        );
    }
}

pub fn a_segment_of_targeting_and_a_batch_of_forced_choice_by_script() {
    let chromium = chromium();
    let folder = tempfile::tempdir().expect("a folder");
    let lab = Lab::start(folder.path(), &["sim"]);
    let mut page = connected(&lab, &chromium);
    begin(&mut page, "targeting");
    page.picture("targeting-waits");
    start(&mut page);
    // a miss first: from the middle nothing can be hit
    page.key("Enter");
    page.until("a miss", "lab.known.experiment.last === 'miss'", 5);
    click_targets(&mut page, 4);
    page.picture("targeting");
    click_targets(&mut page, 4);
    page.until("the segment is over", "lab.known.experiment.done === 1 && !lab.known.experiment.running", 5);
    let kept = session(folder.path(), "targeting-s01-1");
    let Record::Targeting(trial) = &kept.records[0] else { panic!("a targeting trial") };
    println!(
        "segment: {:.2} bits, {:.2} s, {} misses, {:.2} mm beside",
        trial.id_bits, trial.completion_s, trial.errors, trial.mean_error_mm
    );
    assert_eq!((kept.records.len(), trial.errors, trial.clicks.len()), (1, 1, 9));
    // the trajectory holds every millisecond of the trial, and the clicks lie on it
    let file = trial.trajectory.as_ref().expect("a trajectory");
    let text = std::fs::read_to_string(folder.path().join(file)).expect("its file");
    let rows: Vec<Vec<f64>> = text
        .lines()
        .filter(|line| line.starts_with(|c: char| c.is_ascii_digit()))
        .map(|line| line.split(',').map(|x| x.parse().expect("a number")).collect())
        .collect();
    let worst = rows.windows(2).map(|w| w[1][0] - w[0][0]).fold(0.0, f64::max);
    println!(
        "trajectory: {} samples, {:.3} s, longest step {:.4} s",
        rows.len(),
        rows.last().map_or(0.0, |r| r[0]),
        worst
    );
    assert!((rows.len() as f64 * 1e-3 - trial.completion_s).abs() < 0.05 && worst < 1.5e-3);
    for click in &trial.clicks {
        let row =
            rows.iter().min_by(|a, b| (a[0] - click.time_s).abs().total_cmp(&(b[0] - click.time_s).abs()));
        let px = row.expect("a row")[1] / trial.metre_per_px;
        assert!(
            (px - click.position_px).abs() < 0.01,
            "click at {} px, trajectory {px} px",
            click.position_px
        );
    }
    let download = page.eval("fetch('/recordings/targeting-s01-1.jsonl').then((r) => r.text())");
    assert_eq!(
        download.as_str().map(|text| text.lines().count()),
        Some(2),
        "header and one trial are downloaded"
    );
    page.eval("document.querySelector('#leave').click()");
    page.until("left", "!lab.known.experiment && lab.known.mode === 'idle'", 5);

    begin(&mut page, "choice");
    start(&mut page);
    for trial in 0..10 {
        page.until(
            "the question",
            &format!("lab.known.experiment.done === {trial} && lab.known.experiment.running"),
            10,
        );
        assert_eq!(page.eval("lab.known.experiment.cases.may_answer"), json!(false));
        feel_every_case(&mut page);
        if trial == 0 {
            page.until(
                "three cases are felt",
                "document.querySelector('#stage-buttons').children.length === 3",
                5,
            );
            page.picture("choice");
        }
        page.key(if trial % 2 == 0 { "a" } else { "b" });
    }
    page.until("ten answers", "lab.known.experiment.done === 10", 10);
    let kept = session(folder.path(), "choice-s01-1");
    let answers: Vec<_> = kept
        .records
        .iter()
        .filter_map(|record| if let Record::ForcedChoice(trial) = record { Some(trial) } else { None })
        .collect();
    let right = answers.iter().filter(|trial| trial.correct).count();
    println!("batch 1: {} answers, {right} right of a script that feels nothing", answers.len());
    assert!(
        answers.len() == 10
            && answers.iter().all(|trial| trial.batch == "batch 1" && trial.visits == [1, 1, 1])
    );
    // what a subject's browser is told holds neither levels nor the right answer: the device itself says so
    let told = page.eval("JSON.stringify(lab.known.experiment)");
    assert!(!told.as_str().is_some_and(|text| text.contains("different") || text.contains("f_static")));
    // the analysis of `tribos experiment analyse`, from the page
    page.eval("document.querySelector('#leave').click()");
    page.until("left", "!lab.known.experiment", 5);
    page.eval("document.querySelector('#analyse').click()");
    page.until("it is analysed", "lab.known.done && lab.known.done.kind === 'analyse'", 40);
    let done = page.eval("lab.known.done");
    println!("{}", done["text"].as_str().unwrap_or_default());
    assert!(
        done["failed"] == json!(false) && done["text"].as_str().is_some_and(|text| text.contains("batch 1"))
    );
    page.until("its report is open beside", "!document.querySelector('#beside').hidden", 5);
    page.picture("analysis");
    let tables = done["tables"].as_array().expect("tables").clone();
    for table in &tables {
        let table = table.as_str().expect("a name");
        let head = lab.get(&format!("/recordings/{table}"), "");
        assert!(head.starts_with("HTTP/1.1 200") && head.contains("subject,"), "{table}");
    }
    println!("{} tidy tables", tables.len());
}

pub fn what_is_finished_survives_the_death_of_server_browser_and_device() {
    let chromium = chromium();
    let folder = tempfile::tempdir().expect("a folder");
    let mut lab = Lab::start(folder.path(), &["sim"]);
    let mut page = connected(&lab, &chromium);
    begin(&mut page, "choice");
    start(&mut page);
    answer(&mut page, "a", 1);
    page.key("Enter");
    page.until("in the middle of a trial", "lab.known.experiment.cases.case === 'a'", 5);

    // the server, without a word
    lab.child.kill().expect("killed");
    lab.child.wait().expect("gone");
    page.until(
        "the page says so",
        "document.querySelector('#said').textContent.includes('the lab is gone')",
        10,
    );
    println!("server killed: the page says: {}", page.eval("document.querySelector('#said').textContent"));
    page.picture("server-gone");
    assert_eq!(session(folder.path(), "choice-s01-1").records.len(), 1);
    drop(page);
    let lab = Lab::start(folder.path(), &["sim"]);
    let mut page = connected(&lab, &chromium);
    page.eval("document.querySelector('#tab-try').click()");
    page.until("the session is offered", "document.querySelector('#sessions button')", 5);
    page.eval("document.querySelector('#sessions button').click()");
    page.until("it goes on", "lab.known.experiment && lab.known.experiment.done === 1", 5);
    start(&mut page);
    answer(&mut page, "a", 2);

    // the browser's process, in the middle of a trial: nobody watches, so force goes off, and the trial that ran is none
    page.key("Enter");
    page.until("in the middle of a trial", "lab.known.experiment.cases.case === 'a'", 5);
    assert_eq!(page.eval("lab.known.experiment.armed"), json!(true));
    drop(page);
    let now = "[lab.known.experiment.done, lab.known.experiment.armed, lab.known.mode]";
    let mut page = connected(&lab, &chromium);
    page.until("the session is there", "lab.known.experiment", 20);
    let found = page.eval(now);
    println!("browser killed: {found}");
    assert_eq!(found, json!([2, false, "idle"]));
    assert_eq!(session(folder.path(), "choice-s01-1").records.len(), 2);
    start(&mut page);
    answer(&mut page, "a", 3);

    // the page is left
    page.goto("about:blank");
    std::thread::sleep(Duration::from_millis(700));
    page.goto(&lab.url);
    page.until("the page is back", "lab.known.connected && lab.known.experiment", 20);
    let found = page.eval(now);
    println!("page left: {found}");
    assert_eq!(found, json!([3, false, "idle"]));
    start(&mut page);
    answer(&mut page, "a", 4);
    assert_eq!(session(folder.path(), "choice-s01-1").records.len(), 4);
}

#[cfg(unix)]
pub fn a_pulled_cable_is_told_in_plain_words_and_finished_trials_are_kept() {
    let chromium = chromium();
    let folder = tempfile::tempdir().expect("a folder");
    let cable = Cable::plug();
    let lab = Lab::start(folder.path(), &[&cable.name]);
    let mut page = connected(&lab, &chromium);
    assert_eq!(
        page.eval("[lab.known.sim, lab.ring.lost, document.querySelector('#hand-bar').hidden]"),
        json!([false, 0, true])
    );
    page.eval("lab.wire.ask({ do: 'hand', at: 0.001 })");
    page.until(
        "a real handle has a real hand",
        "document.querySelector('#said').textContent.includes('real hand')",
        5,
    );
    begin(&mut page, "choice");
    start(&mut page);
    answer(&mut page, "b", 1);
    drop(cable);
    page.until(
        "the page says so",
        "!lab.known.connected && lab.known.experiment && !lab.known.experiment.armed",
        15,
    );
    let said = page.eval("document.querySelector('#stage-waits').textContent");
    println!("cable pulled: the page says: {said}");
    assert!(
        said.as_str().is_some_and(|text| text.contains("The device is gone") && text.contains("kept")),
        "{said}"
    );
    assert_eq!(session(folder.path(), "choice-s01-1").records.len(), 1);
}

#[cfg(unix)]
pub fn a_driven_handle_is_let_go_within_seconds_of_the_labs_death() {
    use haptics::ModeId;
    use std::sync::atomic::Ordering;
    let folder = tempfile::tempdir().expect("a folder");
    let cable = Cable::plug();
    let mut lab = Lab::start(folder.path(), &[&cable.name]);
    let origin = format!("http://{}", lab.host());
    let mut socket = lab.socket(Some(&origin)).expect("its own page");
    let mode = |wanted: ModeId, seconds: f64| {
        let began = std::time::Instant::now();
        while cable.now.0.load(Ordering::SeqCst) != wanted.code() {
            assert!(began.elapsed().as_secs_f64() < seconds, "not {} within {seconds} s", wanted.id());
            std::thread::sleep(Duration::from_millis(5));
        }
        began.elapsed().as_secs_f64()
    };
    // until the device is known a request is refused
    let drive =
        json!({ "do": "move", "wave": "sine", "amplitude": 0.008, "frequency": 2.0, "seconds": 60.0 });
    for _ in 0..100 {
        socket.send(tungstenite::Message::text(drive.to_string())).expect("the lab hears");
        std::thread::sleep(Duration::from_millis(100));
        if cable.now.0.load(Ordering::SeqCst) == ModeId::Exciting.code() {
            break;
        }
    }
    mode(ModeId::Exciting, 1.0);
    // longer than the device would wait for a host that says nothing
    std::thread::sleep(Duration::from_millis(3_000));
    assert_eq!(cable.now.0.load(Ordering::SeqCst), ModeId::Exciting.code(), "the lab keeps it alive");
    lab.child.kill().expect("killed");
    lab.child.wait().expect("gone");
    let took = mode(ModeId::Fault, 10.0);
    println!("lab killed: force off after {took:.2} s");
    assert!(took > 0.5, "not at once: two seconds of silence are waited for");
    assert_eq!(cable.now.1.load(Ordering::SeqCst), 0);
}
