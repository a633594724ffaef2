//! From a recording to the handle: recorded, diagnosed, sent and felt, by messages and by three presses in the page.

use crate::access::{ask, own_socket, wait_for};
use crate::browser::{Lab, Page, chromium};
use serde_json::{Value, json};

/// Waits for a state of the lab.
fn until(socket: &mut crate::access::Socket, what: &str, holds: impl Fn(&Value) -> bool) -> Value {
    wait_for(socket, what, |message| message["is"] == "state" && holds(message))
}

/// Force at the speed at which before and after are compared, N.
fn compared(state: &Value, curve: &str) -> Option<f64> {
    let at = state["handover"]["compared"].as_u64().expect("an index") as usize;
    state["handover"][curve]["over_speed"][at].as_f64()
}

/// The virtual device streams, and knows the middle of its stroke.
fn ready(socket: &mut crate::access::Socket) {
    until(socket, "the device streams", |state| {
        state["connected"] == true && state["epoch"] != 0 && state["presets"][0].is_string()
    });
}

pub fn what_was_recorded_is_diagnosed_and_felt_on_the_handle() {
    let folder = tempfile::tempdir().expect("a folder");
    let lab = Lab::start(folder.path(), &["sim"]);
    let socket = &mut own_socket(&lab);
    ready(socket);
    // out of order, each is refused with its reason
    for (what, why) in [
        ("handover_diagnose", "record first"),
        ("handover_send", "diagnose first"),
        ("cancel", "no analysis"),
    ] {
        ask(socket, &json!({ "do": what }));
        wait_for(socket, what, |said| said["text"].as_str().is_some_and(|text| text.contains(why)));
    }
    ask(socket, &json!({ "do": "handover_record", "by_hand": false }));
    until(socket, "it is driven", |state| state["mode"] == "exciting" && state["block"] == "rubber");
    let recorded = until(socket, "it is recorded", |state| state["handover"]["step"] == "diagnose");
    assert_eq!(recorded["recordings"][0]["samples"], 10_000);

    // cancelled in the middle, and nothing has changed
    ask(socket, &json!({ "do": "handover_diagnose" }));
    until(socket, "it is diagnosed", |state| state["job"]["share"].as_f64() > Some(0.0));
    ask(socket, &json!({ "do": "cancel" }));
    let cancelled = until(socket, "it is cancelled", |state| state["job"].is_null());
    println!("{}", cancelled["done"]["text"]);
    assert_eq!(cancelled["done"]["failed"], true);
    assert_eq!(cancelled["handover"]["step"], "diagnose");

    ask(socket, &json!({ "do": "handover_diagnose" }));
    let found = until(socket, "it is found", |state| state["handover"]["step"] == "send");
    println!("{}", found["handover"]["summary"]);
    let [before, after, body] =
        ["before", "after", "recorded"].map(|curve| compared(&found, curve).expect(curve));
    println!("{before} N before, {after} N if sent, {body} N recorded");
    // [thesis, table 3-3], run 1: rubber 3.4901 N + 8.7338 N·s/m · 31 mm/s, brass 1.7714 N + 0.457 N·s/m · 31 mm/s
    assert!((after / 3.763 - 1.0).abs() < 0.05 && (before / 1.786 - 1.0).abs() < 0.01);
    assert!((body - after).abs() < 0.1, "what was recorded is what is sent");
    assert_eq!(found["armed"], false);

    ask(socket, &json!({ "do": "handover_send" }));
    let sent = until(socket, "it is felt", |state| compared(state, "felt").is_some());
    let felt = compared(&sent, "felt").expect("enough samples");
    println!("{felt} N felt");
    assert!((felt - after).abs() < 0.2, "felt {felt} N, expected {after} N");
    assert_eq!(
        (&sent["handover"]["step"], &sent["mode"], &sent["block"]),
        (&json!("sent"), &json!("rendering"), &json!("none"))
    );
    // again is once too often
    ask(socket, &json!({ "do": "handover_send" }));
    wait_for(socket, "refused", |said| said["text"].as_str().is_some_and(|text| text.contains("already")));

    // a hand on the bare handle: what it measures is the handle, and is not sent
    ask(socket, &json!({ "do": "handover_record", "by_hand": true }));
    until(socket, "it is recorded", |state| state["recording"].is_u64());
    let second = until(socket, "ten seconds", |state| {
        state["recording"].is_null() && state["handover"]["step"] == "diagnose"
    });
    assert_eq!(second["recordings"][0]["samples"], 10_000);
    ask(socket, &json!({ "do": "handover_diagnose" }));
    let refused = until(socket, "it is refused", |state| state["handover"]["step"] == "refused");
    let why = refused["handover"]["refused"].as_str().expect("a reason").to_owned();
    println!("{why}");
    assert!(why.contains("shows a hand") && why.contains("Mount the body"));
    ask(socket, &json!({ "do": "handover_send" }));
    wait_for(socket, "refused", |said| said["tone"] == "refused" && said["text"] == why.as_str());
}

/// Presses the button as a mouse does.
fn press(page: &mut Page, button: &str) {
    let place = page.eval(&format!(
        "(() => {{ const b = document.querySelector('{button}'); b.scrollIntoView({{ block: 'nearest' }}); \
         const r = b.getBoundingClientRect(); return [r.x + r.width / 2, r.y + r.height / 2]; }})()"
    ));
    let [x, y] = [&place[0], &place[1]].map(|x| x.as_f64().expect("a place"));
    page.mouse("mousePressed", x, y);
    page.mouse("mouseReleased", x, y);
}

pub fn three_clicks_lead_from_a_recording_to_the_handle() {
    let chromium = chromium();
    let folder = tempfile::tempdir().expect("a folder");
    let lab = Lab::start(folder.path(), &["sim"]);
    let mut page = Page::of(&lab, &chromium, (1400, 1100));
    page.eval(
        "globalThis.clicks = 0; addEventListener('click', (e) => { if (e.isTrusted) clicks++; }, true)",
    );
    page.until(
        "the virtual device is referenced",
        "!lab.known.unreferenced && lab.known.mode === 'idle'",
        30,
    );
    page.picture("handover-0");

    press(&mut page, "#ho-record");
    page.until("it is recorded", "lab.known.recording > 2000", 20);
    page.picture("handover-1-recording");
    page.until("it waits for the diagnosis", "document.querySelector('#ho-diagnose.next')", 20);

    press(&mut page, "#ho-diagnose");
    page.until("progress and a way out are shown", "document.querySelector('#ho-progress progress').value > 0 && document.querySelector('#ho-cancel').offsetParent", 20);
    page.picture("handover-2-diagnosing");
    page.until("it can be sent", "document.querySelector('#ho-send.next')", 120);
    let forces = "(() => { const text = document.querySelector('#ho-difference').textContent; return [text, ...text.match(/[−\\d.]+(?= N)/g).map((x) => Number(x.replace('−', '-')))]; })()";
    let planned = page.eval(forces);
    println!("{}", planned[0]);
    page.picture("handover-2-found");
    assert!(
        page.eval("document.querySelector('#beside').hidden") == json!(true),
        "the report hides no button"
    );

    press(&mut page, "#ho-send");
    page.until(
        "it is felt",
        "document.querySelector('#ho-difference').textContent.includes('measured now')",
        30,
    );
    // two strokes of the simulated hand
    std::thread::sleep(std::time::Duration::from_secs(3));
    let shown = page.eval(forces);
    println!("{}", shown[0]);
    let number = |k: usize| shown[k].as_f64().expect("a force");
    let (before, after, now) = (number(1), number(2), number(3));
    assert!((after - before - 1.9).abs() < 0.25, "rubber in place of brass: {before} N, {after} N");
    assert!((now - after).abs() < 0.2, "{now} N measured");
    assert_eq!(page.eval("clicks"), json!(3));
    // from the samples of the page itself: the actuator pushes as hard
    let pushed = page.eval(
        "(() => { const r = lab.ring; let [s, n] = [0, 0]; for (let i = r.find(r.newest - 2.5); i < r.end; i++) { const v = r.at('velocity', i); \
         if (v > 0.0287 && v < 0.0337) { s -= r.at('command', i); n++; } } return [s / n, n]; })()",
    );
    println!("{pushed} N and samples in the page");
    assert!((pushed[0].as_f64().expect("a force") - after).abs() < 0.3);
    // a curve for before, one for after, points for the body and for the handle
    assert_eq!(page.eval("document.querySelectorAll('#ho-legend b').length"), json!(4));
    let inked = page.eval("(() => { const c = document.querySelector('#ho-speed'); return c.getContext('2d').getImageData(0, 0, c.width, c.height).data.some((x) => x); })()");
    assert_eq!(inked, json!(true));
    for (dark, name) in [(true, "handover-3-dark"), (false, "handover-3")] {
        page.dark(dark);
        std::thread::sleep(std::time::Duration::from_millis(800));
        page.picture(name);
    }
    page.key("Escape");
    page.until("force is off", "lab.known.mode === 'idle' && !lab.known.armed", 5);
    std::thread::sleep(std::time::Duration::from_millis(800));
    // what a device cannot render is named below the force; of a body made up for the picture
    page.eval(
        "import('/assets/handover.js').then((m) => m.state({ ...lab.known, handover: { ...lab.known.handover, step: 'send', \
         summary: 'The simulation leaves out cogging and compliance.', \
         after: { ...lab.known.handover.after, over_position: lab.known.handover.positions.map((x) => 3.7 + 0.6 * Math.sin(x / 1.3e-3)) }, \
         moved: [{ name: 'f_static_p', found: 15, sent: 9.48, unit: 'N', why: 'from dynamic friction to the limit of the actuator' }], \
         left_out: [{ name: 'spring', why: 'spring.stiffness = 50000000: accepted from 0 to 1493000; outside the stability bounds of device and block' }] } }))",
    );
    assert_eq!(
        page.eval("document.querySelector('#ho-position').hidden"),
        json!(false),
        "a force of the position is drawn"
    );
    let notes = page.eval("document.querySelector('#ho-notes').innerText");
    page.picture("handover-4-limits");
    println!("{notes}");
    assert!(notes.as_str().is_some_and(
        |text| text.contains("15 was found, 9.48 N is sent") && text.contains("Not sent: spring")
    ));
    // one more press brings the former preset back
    press(&mut page, "[data-preset=brass]");
    page.until("the comparison is with brass again", "document.querySelector('#ho-send.next')", 5);
    page.size((390, 844), 2.0);
    page.until("nothing is wider than a phone", "document.documentElement.scrollWidth <= 390", 5);
    page.eval("document.querySelector('#handover').scrollIntoView()");
    page.picture("handover-5-phone");
}
