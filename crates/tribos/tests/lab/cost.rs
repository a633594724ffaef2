//! What the page costs, and how late it shows what happened.

use crate::browser::Page;

/// Seconds of processor time that a process and its descendants have used.
pub fn cpu(root: u32) -> f64 {
    let mut known = vec![root];
    let mut sum = 0.0;
    let stats: Vec<(u32, u32, f64)> = std::fs::read_dir("/proc")
        .into_iter()
        .flatten()
        .filter_map(|entry| {
            let pid: u32 = entry.ok()?.file_name().to_str()?.parse().ok()?;
            let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
            // the name in parentheses may hold anything
            let rest: Vec<&str> = stat.rsplit(") ").next()?.split(' ').collect();
            let ticks: f64 = rest.get(11)?.parse::<f64>().ok()? + rest.get(12)?.parse::<f64>().ok()?;
            Some((pid, rest.get(1)?.parse().ok()?, ticks / 100.0))
        })
        .collect();
    let mut at = 0;
    while at < known.len() {
        let of = known[at];
        known.extend(stats.iter().filter(|(_, parent, _)| *parent == of).map(|(pid, ..)| *pid));
        at += 1;
    }
    for (pid, _, seconds) in &stats {
        if known.contains(pid) {
            sum += seconds;
        }
    }
    sum
}

/// What the page costs, and how late it shows what happened.
pub fn paint_and_latency(page: &mut Page) {
    let paint = page.eval(
        "(() => { const e = performance.getEntriesByType('resource'); const n = performance.getEntriesByType('navigation')[0]; \
          return { paint: performance.getEntriesByName('first-contentful-paint')[0]?.startTime ?? null, files: e.length + 1, \
            bytes: e.reduce((s, r) => s + r.encodedBodySize, n.encodedBodySize) }; })()",
    );
    println!(
        "page: {} files, {} bytes; first contentful paint {} ms",
        paint["files"], paint["bytes"], paint["paint"]
    );
    assert!(paint["bytes"].as_f64().is_some_and(|bytes| bytes < 250_000.0));
    let measured = page.eval(
        "(async () => { const { wire, ring, scope } = lab; const sleep = (ms) => new Promise((r) => setTimeout(r, ms)); \
          const offsets = []; wire.on('pong', ({ id, clock }) => { const now = performance.now(); offsets.push([now - id, clock - 0.5 * (now + id)]); }); \
          for (let k = 0; k < 20; k++) { wire.ask({ do: 'ping', id: performance.now() }); await sleep(20); } \
          offsets.sort((a, b) => a[0] - b[0]); const offset = offsets[0][1]; \
          const shown = []; let clock = 0; wire.on('samples', (batch) => { clock = batch.clock; }); \
          await new Promise((done) => { let last = 0; const look = () => { if (clock !== last && scope.newestDrawn === ring.newest) { last = clock; shown.push(performance.now() + offset - clock); } shown.length < 120 ? requestAnimationFrame(look) : done(); }; look(); }); \
          const touch = []; for (let k = 0; k < 6; k++) { const from = ring.at('position', ring.end - 1), to = from > 0 ? -0.008 : 0.008; \
            const began = performance.now(); wire.ask({ do: 'hand', at: to }); \
            await new Promise((done) => { const look = () => { const i = ring.nearest(scope.newestDrawn); Math.abs(ring.at('position', i) - from) > 1e-4 ? done() : requestAnimationFrame(look); }; look(); }); \
            touch.push(performance.now() - began); await sleep(700); } \
          wire.ask({ do: 'hand', at: null }); \
          const at = (list, share) => [...list].sort((a, b) => a - b)[Math.floor(share * (list.length - 1))]; \
          return { ping: offsets[0][0], shown: [at(shown, 0.5), at(shown, 0.95)], touch: [at(touch, 0.5), at(touch, 0.95)], cost: scope.cost }; })()",
    );
    println!(
        "motion to pixel: newest sample drawn {} ms (median, 95 %) after it left the server, which waits up to 16 + 5 ms; \
         mouse to the handle's first 0.1 mm on the screen {} ms, hand and inertia included; drawing {:.1} ms; ping {:.1} ms",
        measured["shown"],
        measured["touch"],
        measured["cost"].as_f64().unwrap_or(f64::NAN),
        measured["ping"].as_f64().unwrap_or(f64::NAN)
    );
    assert!(measured["shown"][0].as_f64().is_some_and(|ms| ms.is_finite()));
}
