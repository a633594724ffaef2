//! Controls, recordings and reports of the page.

use crate::browser::{Lab, Page, chromium};
use serde_json::json;

/// Types into a field as a person does.
fn fill(page: &mut Page, field: &str, value: &str) {
    page.eval(&format!(
        "(() => {{ const f = document.querySelector('{field}'); f.focus(); f.value = '{value}'; \
         f.dispatchEvent(new Event('input', {{ bubbles: true }})); }})()"
    ));
}

pub fn what_the_device_would_refuse_cannot_be_sent_and_is_explained() {
    let chromium = chromium();
    let folder = tempfile::tempdir().expect("a folder");
    let lab = Lab::start(folder.path(), &["sim"]);
    let mut page = Page::of(&lab, &chromium, (1400, 950));
    page.eval("document.querySelector('[data-preset=rubber]').click()");
    page.until(
        "the preset",
        "lab.known.preset === 'rubber' && document.querySelector('[name=k_vc]').value === '8000'",
        10,
    );
    fill(&mut page, "[name=k_vc]", "90000");
    page.until("it is judged", "document.querySelector('#verdict').className === 'refused'", 5);
    let said = page.eval("document.querySelector('#verdict p').textContent");
    println!("90 000 N/m: {said}");
    assert!(said.as_str().is_some_and(|text| text.contains("accepted from 1 to") && text.contains("4.18")));
    assert_eq!(page.eval("document.querySelector('#apply').disabled"), json!(true));
    page.picture("refused");
    // behind the page's back it is refused by the server, in the same words, and the device keeps what it had
    page.eval("lab.wire.ask({ do: 'set', changes: [['k_vc', '90000']] })");
    page.until("refused", "document.querySelector('#said').textContent.includes('accepted from 1 to')", 5);
    fill(&mut page, "[name=dv]", "0.0005");
    fill(&mut page, "[name=k_vc]", "9000");
    page.until("unfaithful", "document.querySelector('#verdict').className === 'unfaithful' && !document.querySelector('#apply').disabled", 5);
    page.key("Enter");
    let taken = "['k_vc', 'dv'].map((n) => lab.known.verdict.parameters.find((p) => p.name === n).value).join() === '9000,0.0005'";
    page.until("both are on the device", taken, 5);
    for (dark, name) in [(false, "light"), (true, "dark")] {
        page.dark(dark);
        page.picture(name);
    }
    page.size((390, 844), 2.0);
    page.until(
        "nothing is wider than a phone",
        "document.documentElement.scrollWidth <= 390 && innerWidth === 390",
        5,
    );
    let stop = page.eval("(() => { const r = document.querySelector('#stop').getBoundingClientRect(); return r.bottom <= innerHeight && r.top >= 0 && r.width > 150; })()");
    assert_eq!(stop, json!(true), "the stop is in reach of a thumb");
    page.picture("narrow");
}

pub fn a_move_is_recorded_identified_and_its_report_opens_beside() {
    let chromium = chromium();
    let folder = tempfile::tempdir().expect("a folder");
    let lab = Lab::start(folder.path(), &["sim"]);
    let mut page = Page::of(&lab, &chromium, (1400, 950));
    page.eval("document.querySelector('#tab-move').click(); lab.wire.ask({ do: 'block', name: 'rubber' })");
    fill(&mut page, "#excite [name=seconds]", "3");
    page.eval("document.querySelector('#excite [value=identify]').click()");
    page.until("it is driven", "lab.known.mode === 'exciting'", 10);
    page.until("it is identified", "lab.known.done && !lab.known.done.failed && lab.known.done.report", 60);
    page.until("the report is open beside", "!document.querySelector('#beside').hidden", 5);
    page.picture("report");
    let text = page.eval("lab.known.done.text");
    let text = text.as_str().expect("a text");
    println!("{text}");
    let coulomb: f64 = text
        .lines()
        .find_map(|line| line.trim().strip_prefix("coulomb_p"))
        .and_then(|rest| rest.split_whitespace().next()?.parse().ok())
        .expect("coulomb_p");
    // [thesis, table 3-3], run 1
    assert!((coulomb / 3.4901 - 1.0).abs() < 0.03, "{coulomb} N");
    let report = page.eval("fetch('/reports/' + lab.known.done.report).then(async (r) => [r.status, (await r.text()).includes('<title>')])");
    assert_eq!(report, json!([200, true]));
    // the report is a page of its own that can reach nothing
    let head = lab.get("/reports/identify-rec-001.html", "");
    assert!(head.contains("sandbox allow-scripts") && head.contains("default-src 'none'"));
    let csv = page.eval("fetch('/recordings/rec-001.csv').then((r) => r.text())");
    let rows =
        csv.as_str().map(|text| text.lines().filter(|l| l.starts_with(|c: char| c.is_ascii_digit())).count());
    assert_eq!(rows, Some(3000), "3 s at 1 kHz");
    let mcap = page.eval("fetch('/recordings/rec-001.mcap').then((r) => r.arrayBuffer()).then((b) => [b.byteLength, ...new Uint8Array(b.slice(1, 5))])");
    println!("download: {} bytes of CSV, {} of MCAP", csv.as_str().map_or(0, str::len), mcap[0]);
    assert_eq!(&mcap.as_array().expect("bytes")[1..], &[b'M', b'C', b'A', b'P'].map(|b| json!(b)));
    // what was found is put on the handle: judged, applied, felt
    page.eval(
        "[...document.querySelectorAll('#done button')].find((b) => b.textContent.includes('Render')).click()",
    );
    page.until("it can be applied", "!document.querySelector('#apply').disabled", 5);
    page.eval("document.querySelector('#apply').click()");
    page.until(
        "it is on the device",
        "Math.abs(lab.known.verdict.parameters.find((p) => p.name === 'f_dynamic_p').value - 3.49) < 0.1",
        5,
    );
}
