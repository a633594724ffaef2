//! The page without installation, as `.ci/web` builds it, opened as a file: nothing serves it.

use crate::browser::{CHROMIUM, Page, chromium};
use crate::cost::cpu;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::Command;
use untested::Need;

pub static PAGE: Need = Need::new(|| {
    let no_page = || page().is_none().then(|| "no TRIBOS_PAGE: .ci/web builds the page and sets it".into());
    CHROMIUM.missing().map(str::to_owned).or_else(no_page)
})
.spared_in_ci();

fn page() -> Option<PathBuf> {
    std::env::var_os("TRIBOS_PAGE").map(PathBuf::from).filter(|path| path.exists())
}

fn opened(size: (u32, u32)) -> Page {
    let file = page().expect("the tests need it");
    let mut page = Page::open(&chromium(), &format!("file://{}", file.display()), size);
    page.until(
        "the page is there",
        "document.readyState === 'complete' && document.querySelector('#run') !== null",
        10,
    );
    // whatever the policy refuses is noted
    page.eval("addEventListener('securitypolicyviolation', (e) => { (window.refused ??= []).push(e.blockedURI); }); true");
    page
}

/// Chooses files as a person does.
fn choose(page: &mut Page, files: &[&Path]) {
    let field = page.call("Runtime.evaluate", json!({ "expression": "document.querySelector('#files')" }));
    let files: Vec<String> = files.iter().map(|path| path.display().to_string()).collect();
    page.call("DOM.setFileInputFiles", json!({ "objectId": field["result"]["objectId"], "files": files }));
}

/// What a click on a download would save.
fn saved(page: &mut Page, name: &str) -> String {
    // the policy forbids to fetch even that; a request of the tests' own is outside of it
    let url = page.eval(&format!("document.querySelector('#downloads a[download=\"{name}\"]').href"));
    let text = page.eval(&format!("window.savedTexts[{url}]"));
    text.as_str().unwrap_or_else(|| panic!("{name} is saved")).to_owned()
}

/// Keeps the text of everything that is offered for saving.
fn keep_saved(page: &mut Page) {
    page.eval(
        "window.savedTexts = {}; { const make = URL.createObjectURL; URL.createObjectURL = (blob) => { const url = make(blob); \
         blob.text().then((text) => { window.savedTexts[url] = text; }); return url; }; } true",
    );
}

const DONE: &str = "document.querySelector('#work').hidden && !document.querySelector('#results').hidden";

/// Numbers of the page and of the command, and the largest difference relative to the larger.
fn compare(path: &str, page: &Value, command: &Value, differ: &mut Vec<(f64, String)>) {
    match (page, command) {
        (Value::Object(a), Value::Object(b)) => {
            assert_eq!(a.keys().collect::<Vec<_>>(), b.keys().collect::<Vec<_>>(), "{path}");
            a.iter().for_each(|(key, value)| compare(&format!("{path}/{key}"), value, &b[key], differ));
        }
        (Value::Array(a), Value::Array(b)) => {
            assert_eq!(a.len(), b.len(), "{path}");
            a.iter().zip(b).enumerate().for_each(|(i, (a, b))| compare(&format!("{path}/{i}"), a, b, differ));
        }
        (Value::Number(a), Value::Number(b)) => {
            let (a, b) = (a.as_f64().expect("a number"), b.as_f64().expect("a number"));
            if a.to_bits() != b.to_bits() {
                differ.push(((a - b).abs() / a.abs().max(b.abs()), format!("{path}: {a} {b}")));
            }
        }
        _ => assert_eq!(page, command, "{path}"),
    }
}

/// Runs the command in a folder; its standard error if it fails.
fn tribos(folder: &Path, arguments: &[&str]) -> Result<(), String> {
    let out = Command::new(env!("CARGO_BIN_EXE_tribos"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("it runs");
    if out.status.success() { Ok(()) } else { Err(String::from_utf8_lossy(&out.stderr).into_owned()) }
}

/// Largest relative difference between numbers of the page and of the command: sine, exponential and power come from other
/// libraries, and sums run in another order.
const ROUNDING: f64 = 1e-6;

pub fn a_file_is_diagnosed_as_the_command_does() {
    let folder = tempfile::tempdir().expect("a folder");
    let dir = folder.path();
    std::fs::copy(fixtures::folder().join("tribometer.csv"), dir.join("tribometer.csv")).expect("copied");
    let map = "time_s=time_s,position_m=0.001*stroke_mm,force_n=friction_n,normal_force_n=load_n";
    let mut page = opened((1280, 900));
    page.picture("page-empty");
    keep_saved(&mut page);
    page.eval("document.querySelector('#example').click()");
    page.until("the answer", DONE, 120);
    page.until("what is saved", "Object.keys(window.savedTexts).length >= 3", 10);
    page.until("the report", "document.querySelector('#report').srcdoc.length > 1e4", 10);
    std::thread::sleep(std::time::Duration::from_secs(1));
    page.picture("page-report");
    page.size((1280, 1900), 1.0);
    page.picture("page-report-tall");
    page.dark(true);
    page.picture("page-report-dark");
    for (what, file, model) in
        [("diagnose", "diagnosis", "found.toml"), ("identify", "identification", "model.toml")]
    {
        let tab = if what == "diagnose" { "diagnosis" } else { "identification" };
        page.eval(&format!("document.querySelector('#tab-{tab}').click()"));
        std::thread::sleep(std::time::Duration::from_millis(300));
        let json_name = format!("{file}.json");
        tribos(
            dir,
            &[
                what,
                "tribometer.csv",
                "--map",
                map,
                "--json",
                &json_name,
                "--out",
                model,
                "--report",
                "r.html",
            ],
        )
        .expect("the command does it");
        let read = |name: &str| std::fs::read_to_string(dir.join(name)).expect("written");
        let parsed = |text: &str| serde_json::from_str::<Value>(text).expect("JSON");
        let (of_page, of_command) = (saved(&mut page, &json_name), read(&json_name));
        let mut differ = Vec::new();
        compare("", &parsed(&of_page), &parsed(&of_command), &mut differ);
        differ.sort_by(|a, b| b.0.total_cmp(&a.0));
        println!("{what}: {} numbers differ, most: {:?}", differ.len(), differ.first());
        assert!(
            differ.first().is_none_or(|(most, _)| *most < ROUNDING),
            "{:?}",
            &differ[..differ.len().min(9)]
        );
        let (of_page, of_command) = (saved(&mut page, model), read(model));
        let names = |text: &str| -> Vec<String> {
            text.lines().map(|line| line.split('=').next().unwrap_or_default().to_owned()).collect()
        };
        assert_eq!(names(&of_page), names(&of_command));
        let (of_page, of_command) = (saved(&mut page, &format!("{file}.html")), read("r.html"));
        // the same page: the length differs by digits only
        let share = of_page.len() as f64 / of_command.len() as f64;
        assert!((share - 1.0).abs() < 0.02, "{} and {} bytes", of_page.len(), of_command.len());
    }
    let terminal = page.eval("document.querySelector('#command').textContent");
    assert!(
        terminal
            .as_str()
            .is_some_and(|text| text.contains(&format!("tribos identify tribometer.csv --map '{map}'"))),
        "{terminal}"
    );
    page.size((390, 844), 2.0);
    page.until("nothing is wider than a phone", "document.documentElement.scrollWidth <= 390", 5);
    page.picture("page-narrow");
}

pub fn a_bad_cell_is_refused_in_the_words_of_the_command() {
    let folder = tempfile::tempdir().expect("a folder");
    let dir = folder.path();
    std::fs::write(dir.join("bad.csv"), "time_s,position_m,force_n\n0,1,2\n0.001,x1,3\n").expect("written");
    let said = tribos(dir, &["diagnose", "bad.csv"]).expect_err("refused");
    let line =
        said.lines().next().and_then(|line| line.strip_prefix("error: ")).expect("an error").to_owned();
    let mut page = opened((1280, 900));
    choose(&mut page, &[&dir.join("bad.csv")]);
    page.until(
        "refused",
        "document.querySelector('#said .refused') !== null && document.querySelector('#work').hidden",
        30,
    );
    let shown = page.eval("[...document.querySelectorAll('#said .refused')].map((p) => p.textContent)");
    println!("{shown}");
    assert_eq!(shown, json!([line]));
    page.picture("page-refused");
    // a file with other names says what to do; the columns, typed in, are the map
    std::fs::write(dir.join("foreign.csv"), "t,x,F\n0,1,2\n1,2,3\n").expect("written");
    choose(&mut page, &[&dir.join("foreign.csv")]);
    page.until("the columns are asked for", "document.body.classList.contains('foreign')", 30);
    page.eval(
        "for (const [name, value] of [['time_s', 't'], ['position', 'x'], ['force', 'F']]) \
         document.querySelector(`[data-column=${name}]`).value = value; \
         document.querySelector('[data-unit=position]').selectedIndex = 1; \
         document.querySelector('[data-column=force]').dispatchEvent(new Event('input', { bubbles: true })); true",
    );
    let map = page.eval("document.querySelector('[name=map]').value");
    assert_eq!(map, json!("time_s=t,position_m=0.001*x,force_n=F"));
    page.picture("page-foreign");
    page.eval("document.querySelector('[name=cutoff]').value = '-3'; document.querySelector('#run').click()");
    let refused =
        "document.querySelector('#said .refused')?.textContent.startsWith('cutoff: `-3`: a frequency in Hz')";
    page.until("the option is refused", refused, 30);
}

pub fn nothing_leaves_the_machine_and_a_bug_is_told() {
    let mut page = opened((1000, 700));
    // that nothing answers proves nothing; that the policy refuses does
    page.eval(
        "fetch('https://example.org/fetched').catch(() => {}); fetch(location.href).catch(() => {}); \
         try { new WebSocket('wss://example.org/socket'); } catch {} \
         new Image().src = 'https://example.org/image'; navigator.sendBeacon('https://example.org/beacon', 'x'); \
         document.body.append(Object.assign(document.createElement('iframe'), { src: 'https://example.org/frame' })); true",
    );
    page.until("six refusals", "window.refused.length >= 6", 10);
    let refused = page.eval("window.refused.sort()");
    let expected = ["fetched", "beacon", "image"].map(|name| format!("https://example.org/{name}"));
    let expected = expected.iter().map(String::as_str).chain([
        "file",
        "wss://example.org/socket",
        "https://example.org",
    ]);
    let missing: Vec<&str> =
        expected.filter(|name| !refused.as_array().is_some_and(|all| all.contains(&json!(name)))).collect();
    assert!(missing.is_empty(), "not refused: {missing:?} of {refused}");
    // a name in a file never becomes a script, not even in the report
    page.eval(
        "document.body.insertAdjacentHTML('beforeend', '<img src=data:, onerror=\"window.ran = 1\">'); true",
    );
    std::thread::sleep(std::time::Duration::from_millis(300));
    assert_eq!(page.eval("window.ran === undefined"), json!(true));
    // a program that is broken: the page says so, and lives
    page.eval(
        "{ const Plain = Worker; window.Worker = function (url) { const worker = new Plain(url); \
         const post = worker.postMessage.bind(worker); const empty = new WebAssembly.Module(new Uint8Array([0, 97, 115, 109, 1, 0, 0, 0])); \
         worker.postMessage = (message) => post({ ...message, module: empty }); return worker; }; } true",
    );
    page.eval("document.querySelector('#example').click()");
    page.until(
        "it is told",
        "document.querySelectorAll('#said .refused').length === 2 && document.querySelector('#work').hidden",
        30,
    );
    let said = page.eval("document.querySelector('#said').textContent");
    println!("{said}");
    assert!(said.as_str().is_some_and(|text| text.contains("A bug in tribos ended the work (no diagnosis)")));
}

pub fn twenty_five_thousand_samples_are_timed_and_cancelled() {
    let folder = tempfile::tempdir().expect("a folder");
    let (file, map) = match untested::recordings("emps/DATA_EMPS.mat") {
        Ok(file) => (file.canonicalize().expect("a path"), "position_m=qm,force_n=gtau*vir"),
        Err(_) => {
            let file = folder.path().join("rec.csv");
            let name = file.display().to_string();
            tribos(
                folder.path(),
                &[
                    "record",
                    "sim",
                    "--move",
                    "multisine 0.01 0.8",
                    "--seconds",
                    "25",
                    "--out",
                    &name,
                    "--yes",
                ],
            )
            .expect("the rig is recorded");
            (file, "")
        }
    };
    let mut page = opened((1280, 900));
    page.eval(&format!("document.querySelector('[name=map]').value = '{map}'; true"));
    choose(&mut page, &[&file]);
    page.until("it works", "document.querySelector('#work progress').value > 0.05", 60);
    page.picture("page-working");
    // the page lives meanwhile, and hears
    page.eval("document.querySelector('#cancel').click()");
    assert_eq!(page.eval("document.querySelector('#work').hidden"), json!(true));
    let before = cpu(page.pid());
    let took = page.eval(&format!(
        "new Promise((told) => {{ const began = performance.now(); document.querySelector('#run').click(); \
         const look = setInterval(() => {{ if ({DONE}) {{ clearInterval(look); told((performance.now() - began) / 1000); }} }}, 20); }})"
    ));
    let chosen = page.eval("document.querySelector('#chosen').textContent");
    println!(
        "{}: {:.1} s in the browser, {:.1} s of processor time",
        chosen.as_str().unwrap_or_default(),
        took.as_f64().expect("seconds"),
        cpu(page.pid()) - before
    );
}
