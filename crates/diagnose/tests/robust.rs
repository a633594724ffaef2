//! Recordings that are broken in every way people break them: no panic, and no verdict without a warning where the
//! audit should have warned.
//!
//! The suite breaks three of every kind; all 2 000:
//! `cargo test -p diagnose --test robust -- --ignored --nocapture`

mod plant;

use diagnose::{Diagnosis, Options, Verdict, diagnose};
use plant::{Case, Hidden, Motion, record};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use signals::{FaultKind, ReadOptions, Recording};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;

/// What is given to the tool.
enum Input {
    Text(Vec<u8>),
    Columns(Box<Recording>),
}

/// What must come of it, whatever else does.
#[derive(Debug, Clone, Copy)]
enum Expect {
    /// It is refused with a message that names the file.
    Refused,
    /// One of these faults is reported, or it is refused.
    Warned(&'static [FaultKind]),
    /// One of these faults is reported and nothing is concluded, or it is refused.
    NotTestable(&'static [FaultKind]),
    /// Nothing in the file says that it is broken: only no panic, and numbers that are numbers.
    Survived,
}

struct Kind {
    name: &'static str,
    expect: Expect,
    broken: fn(&Recording, &mut ChaCha8Rng) -> Input,
}

use Expect::{NotTestable, Refused, Survived, Warned};
use FaultKind::*;

fn text(r: &Recording) -> String {
    r.to_csv().expect("a table")
}

fn lines(r: &Recording) -> Vec<String> {
    text(r).lines().map(str::to_string).collect()
}

fn joined(lines: &[String]) -> Input {
    Input::Text((lines.join("\n") + "\n").into_bytes())
}

fn edited(r: &Recording, edit: impl FnOnce(&mut Recording)) -> Input {
    let mut out = r.clone();
    edit(&mut out);
    Input::Text(text(&out).into_bytes())
}

/// Some samples of one of the measured columns.
fn some<'a>(r: &'a mut Recording, random: &mut ChaCha8Rng) -> &'a mut Vec<f64> {
    match (random.random_range(0..3), &mut r.velocity) {
        (0, _) => &mut r.position,
        (1, Some(v)) => v,
        _ => &mut r.force,
    }
}

fn scatter(
    values: &mut [f64],
    share: f64,
    random: &mut ChaCha8Rng,
    with: impl Fn(f64, &mut ChaCha8Rng) -> f64,
) {
    let count = ((values.len() as f64 * share) as usize).max(1);
    for _ in 0..count {
        let i = random.random_range(0..values.len());
        values[i] = with(values[i], random);
    }
}

fn spread(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
}

/// Rows `range` of every column.
fn rows(r: &Recording, keep: impl Fn(usize) -> bool) -> Recording {
    let pick = |s: &Vec<f64>| -> Vec<f64> {
        s.iter().enumerate().filter(|(i, _)| keep(*i)).map(|(_, x)| *x).collect()
    };
    Recording {
        time: pick(&r.time),
        position: pick(&r.position),
        force: pick(&r.force),
        velocity: r.velocity.as_ref().map(pick),
        ..r.clone()
    }
}

const KINDS: &[Kind] = &[
    Kind {
        name: "cut off at a byte",
        expect: Survived,
        broken: |r, random| {
            let mut bytes = text(r).into_bytes();
            bytes.truncate(random.random_range(0..bytes.len()));
            Input::Text(bytes)
        },
    },
    Kind {
        name: "cut off early",
        expect: NotTestable(&[TooShort]),
        broken: |r, random| {
            let keep = random.random_range(3..60);
            Input::Text(text(&rows(r, |i| i < keep)).into_bytes())
        },
    },
    Kind {
        name: "one sample, two, none",
        expect: NotTestable(&[TooShort]),
        broken: |r, random| {
            let keep = random.random_range(0..3);
            Input::Text(text(&rows(r, |i| i < keep)).into_bytes())
        },
    },
    Kind {
        name: "values that are not numbers",
        expect: Warned(&[NotANumber]),
        broken: |r, random| {
            edited(r, |r| {
                let share = 10f64.powf(random.random_range(-3.0..-0.5));
                let bad = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY][random.random_range(0..3)];
                scatter(some(r, random), share, random, |_, _| bad);
            })
        },
    },
    Kind {
        name: "a hole of empty cells",
        expect: Warned(&[NotANumber]),
        broken: |r, random| {
            edited(r, |r| {
                let (from, n) =
                    (random.random_range(0..r.time.len() / 2), random.random_range(1..r.time.len() / 3));
                some(r, random)[from..from + n].fill(f64::NAN);
            })
        },
    },
    Kind {
        name: "a column of nothing",
        expect: NotTestable(&[NotANumber, ConstantChannel, TooLittleMotion, TooShort]),
        broken: |r, random| {
            edited(r, |r| {
                let which = if random.random() { &mut r.position } else { &mut r.force };
                which.fill(f64::NAN);
            })
        },
    },
    Kind {
        name: "rows exchanged",
        expect: Warned(&[ClockBackward]),
        broken: |r, random| {
            let mut all = lines(r);
            let first = all.iter().position(|l| l.starts_with("time")).expect("a header") + 1;
            for _ in 0..random.random_range(1..20) {
                let i = random.random_range(first..all.len());
                let j = random.random_range(first..all.len());
                if i.abs_diff(j) > 1 {
                    all.swap(i, j);
                }
            }
            let last = all.len() - 1;
            all.swap(last, last - 2);
            joined(&all)
        },
    },
    Kind {
        name: "rows in random order",
        expect: Warned(&[ClockBackward]),
        broken: |r, random| {
            let mut all = lines(r);
            let first = all.iter().position(|l| l.starts_with("time")).expect("a header") + 1;
            for i in first..all.len() {
                let j = random.random_range(i..all.len());
                all.swap(i, j);
            }
            joined(&all)
        },
    },
    Kind {
        name: "backward in time",
        expect: Warned(&[ClockBackward]),
        broken: |r, _| {
            edited(r, |r| {
                for column in [&mut r.time, &mut r.position, &mut r.force].into_iter().chain(&mut r.velocity)
                {
                    column.reverse();
                }
            })
        },
    },
    Kind {
        name: "the file twice",
        expect: Warned(&[ClockBackward]),
        broken: |r, _| {
            let all = lines(r);
            let first = all.iter().position(|l| l.starts_with("time")).expect("a header") + 1;
            let twice: Vec<String> = all.iter().chain(&all[first..]).cloned().collect();
            joined(&twice)
        },
    },
    Kind {
        name: "duplicated times",
        expect: Warned(&[ClockBackward]),
        broken: |r, random| {
            edited(r, |r| {
                for _ in 0..random.random_range(1..30) {
                    let i = random.random_range(1..r.time.len());
                    r.time[i] = r.time[i - 1];
                }
            })
        },
    },
    Kind {
        name: "time stands still",
        expect: NotTestable(&[ClockBackward, NotANumber]),
        broken: |r, random| {
            let at = random.random_range(0.0..100.0);
            edited(r, |r| r.time.fill(at))
        },
    },
    Kind {
        name: "uneven clock",
        expect: Warned(&[IrregularClock, ClockBackward]),
        broken: |r, random| {
            let jitter = random.random_range(0.1..0.45);
            edited(r, |r| {
                let dt = r.time[1] - r.time[0];
                for t in &mut r.time {
                    *t += dt * jitter * random.random_range(-1.0..1.0);
                }
            })
        },
    },
    Kind {
        name: "lost samples",
        expect: Warned(&[LostSamples]),
        broken: |r, random| {
            let (from, n) = (random.random_range(10..r.time.len() - 300), random.random_range(2..250));
            Input::Text(text(&rows(r, |i| i < from || i >= from + n)).into_bytes())
        },
    },
    Kind {
        name: "a rate that the file contradicts",
        expect: Warned(&[TimeBase]),
        broken: |r, random| {
            let factor = random.random_range(1.05..3.0);
            edited(r, |r| {
                let rate = factor / (r.time[1] - r.time[0]);
                r.metadata.insert("sample_rate_hz".into(), format!("{rate}"));
            })
        },
    },
    Kind {
        name: "velocity rescaled",
        expect: Warned(&[VelocityScale, TimeBase, VelocityMismatch]),
        broken: |r, random| {
            let factor = random.random_range(0.3..0.9);
            let factor = if random.random() { factor } else { 1.0 / factor };
            edited(r, |r| r.velocity.iter_mut().flatten().for_each(|v| *v *= factor))
        },
    },
    Kind {
        name: "clock rescaled",
        expect: Warned(&[VelocityScale, TimeBase, VelocityMismatch, Implausible]),
        broken: |r, random| {
            let factor = [0.1, 0.5, 0.8, 1.25, 2.0, 10.0, 1000.0][random.random_range(0..7)];
            edited(r, |r| r.time.iter_mut().for_each(|t| *t *= factor))
        },
    },
    Kind {
        name: "millimetres for metres",
        expect: Warned(&[VelocityScale, VelocityMismatch, Implausible]),
        broken: |r, random| {
            let keep: bool = random.random();
            edited(r, |r| {
                r.position.iter_mut().for_each(|x| *x *= 1000.0);
                r.velocity = r.velocity.take().filter(|_| keep);
            })
        },
    },
    Kind {
        name: "milliseconds for seconds",
        expect: Warned(&[Implausible]),
        broken: |r, _| {
            edited(r, |r| {
                r.time.iter_mut().for_each(|t| *t *= 1000.0);
                r.velocity = None;
            })
        },
    },
    Kind {
        name: "velocity of something else",
        expect: Warned(&[VelocityMismatch, VelocityScale]),
        broken: |r, random| {
            edited(r, |r| {
                let shift = random.random_range(100..400);
                if let Some(v) = &mut r.velocity {
                    v.rotate_left(shift);
                }
            })
        },
    },
    Kind {
        name: "wrong sign of the force",
        expect: Warned(&[Implausible]),
        broken: |r, _| edited(r, |r| r.force.iter_mut().for_each(|f| *f = -*f)),
    },
    Kind {
        name: "constant force",
        expect: Warned(&[ConstantChannel]),
        broken: |r, random| {
            let value = random.random_range(-5.0..5.0);
            edited(r, |r| r.force.fill(value))
        },
    },
    Kind {
        name: "constant position",
        expect: NotTestable(&[TooLittleMotion, ConstantChannel]),
        broken: |r, random| {
            let value = random.random_range(-5.0..5.0);
            edited(r, |r| {
                r.position.fill(value);
                r.velocity = None;
            })
        },
    },
    Kind {
        name: "all zero",
        expect: NotTestable(&[TooLittleMotion, ConstantChannel]),
        broken: |r, _| {
            edited(r, |r| {
                r.position.fill(0.0);
                r.force.fill(0.0);
                r.velocity = None;
            })
        },
    },
    Kind {
        name: "10 % outliers",
        expect: Warned(&[Outliers, NotANumber]),
        broken: |r, random| {
            edited(r, |r| {
                let column = if random.random() { &mut r.position } else { &mut r.force };
                let size = spread(column);
                scatter(column, 0.1, random, |x, random| {
                    let sign = if random.random() { 1.0 } else { -1.0 };
                    x + sign * size * random.random_range(5.0..100.0)
                });
            })
        },
    },
    Kind {
        name: "a few outliers",
        expect: Warned(&[Outliers]),
        broken: |r, random| {
            edited(r, |r| {
                let share = random.random_range(0.0..0.01);
                let column = some(r, random);
                let size = spread(column);
                scatter(column, share, random, |x, random| x + size * random.random_range(5.0..1e6));
                // where a random place lies beside the ends there is nothing to compare with
                let n = column.len() / 2;
                column[n] += 50.0 * size;
            })
        },
    },
    Kind {
        name: "force clipped",
        expect: Warned(&[Saturation]),
        broken: |r, random| {
            let share = random.random_range(0.3..0.6);
            edited(r, |r| {
                let most = share * r.force.iter().fold(0.0f64, |m, f| m.max(f.abs()));
                r.force.iter_mut().for_each(|f| *f = f.clamp(-most, most));
            })
        },
    },
    Kind {
        name: "coarse position",
        expect: Warned(&[Quantisation, TooLittleMotion, VelocityMismatch]),
        broken: |r, random| {
            let share = random.random_range(0.1..0.8);
            edited(r, |r| {
                let step = share * spread(&r.position);
                r.position.iter_mut().for_each(|x| *x = (*x / step).round() * step);
            })
        },
    },
    Kind {
        name: "absurd sizes",
        expect: Survived,
        broken: |r, random| {
            let factor = 10f64.powf(random.random_range(-200.0..200.0));
            edited(r, |r| some(r, random).iter_mut().for_each(|x| *x *= factor))
        },
    },
    Kind {
        name: "position and force exchanged",
        expect: Survived,
        broken: |r, _| edited(r, |r| std::mem::swap(&mut r.position, &mut r.force)),
    },
    Kind {
        name: "a sensor that hangs",
        expect: Survived,
        broken: |r, random| {
            edited(r, |r| {
                let (from, n) =
                    (random.random_range(0..r.time.len() / 2), random.random_range(50..r.time.len() / 3));
                let column = some(r, random);
                let held = column[from];
                column[from..from + n].fill(held);
            })
        },
    },
    Kind {
        name: "garbage header",
        expect: Refused,
        broken: |r, random| {
            let all = text(r);
            let body = all.split_once("\n").map_or("", |(_, body)| body);
            let header: String = (0..random.random_range(1..40))
                .map(|_| char::from_u32(random.random_range(33..0x2fff)).unwrap_or('?'))
                .collect();
            Input::Text(format!("{header}\n{body}").into_bytes())
        },
    },
    Kind {
        name: "a column missing, twice or of a wrong unit",
        expect: Refused,
        broken: |r, random| {
            let (from, to) = [
                ("position_m", "position_mm"),
                ("position_m", "time_s"),
                ("force_n", "force_kn"),
                ("force_n", "remark"),
                ("time_s", "time_ms"),
                ("velocity_m_s", "velocity_rad_s"),
            ][random.random_range(0..6)];
            Input::Text(text(r).replacen(from, to, 1).into_bytes())
        },
    },
    Kind {
        name: "bytes",
        expect: Refused,
        broken: |_, random| {
            let n = random.random_range(0..5000);
            Input::Text((0..n).map(|_| random.random()).collect())
        },
    },
    Kind {
        name: "a damaged byte in a line",
        expect: Survived,
        broken: |r, random| {
            let mut bytes = text(r).into_bytes();
            for _ in 0..random.random_range(1..20) {
                let i = random.random_range(0..bytes.len());
                bytes[i] = random.random();
            }
            Input::Text(bytes)
        },
    },
    Kind {
        name: "columns of unequal length",
        expect: Refused,
        broken: |r, random| {
            let mut out = r.clone();
            let n = random.random_range(0..out.time.len() - 1);
            match random.random_range(0..3) {
                0 => out.position.truncate(n),
                1 => out.force.truncate(n),
                _ => out.velocity.iter_mut().for_each(|v| v.truncate(n)),
            }
            Input::Columns(Box::new(out))
        },
    },
];

/// Sound recordings to break: a slide with something left out, and one without; both with a velocity column.
fn sound() -> Vec<Recording> {
    let of = |hidden, motion, seed| {
        let case = Case { hidden: [hidden, Hidden::Nothing], motion, seconds: 1.6, seed, ..Case::default() };
        let (mut r, _) = record(&case);
        let n = r.time.len();
        let slope = |i: usize| {
            let (a, b) = (i.saturating_sub(2), (i + 2).min(n - 1));
            (r.position[b] - r.position[a]) / (r.time[b] - r.time[a])
        };
        r.velocity = Some((0..n).map(slope).collect());
        r
    };
    vec![of(Hidden::Spring { size: 0.6 }, Motion::Multisine, 5), of(Hidden::Nothing, Motion::Chirp, 6)]
}

/// What the last panic said, and where.
static PANIC: Mutex<String> = Mutex::new(String::new());

/// One or two effects are enough: what is looked at is what becomes of a broken recording.
fn options() -> Options {
    Options { max_terms: 2, beam_width: 1, ..Options::default() }
}

/// None where all is as expected.
fn judge(kind: &Kind, input: Input) -> Option<String> {
    let name = "broken.csv";
    let outcome = catch_unwind(AssertUnwindSafe(|| -> Result<Diagnosis, String> {
        let recording = match input {
            Input::Text(bytes) => {
                Recording::from_csv(name, &bytes, &ReadOptions::default()).map_err(|e| e.to_string())?
            }
            Input::Columns(recording) => Recording { name: name.into(), ..*recording },
        };
        diagnose(&[recording], &[], &options(), &|_, _| ()).map_err(|e| e.to_string())
    }));
    let result = match outcome {
        Err(_) => return Some(PANIC.lock().map_or_else(|_| "panicked".into(), |p| p.clone())),
        Ok(result) => result,
    };
    let found = match result {
        Err(said) if said.contains(name) && !said.contains('\n') => return None,
        Err(said) => return Some(format!("refused with `{said}`")),
        Ok(found) => found,
    };
    let json = serde_json::to_string(&found).expect("JSON");
    let testable = found.verdict != Verdict::NotTestable;
    let numbers = [found.baseline.rms_heldout, found.after.rms_heldout, found.noise_floor.rms];
    if testable && !numbers.iter().all(|x| x.is_finite()) {
        return Some(format!("{:?} with {numbers:?}", found.verdict));
    }
    if !json.contains("tribos.diagnosis/2") || found.summary.is_empty() {
        return Some("no summary".into());
    }
    let kinds: Vec<FaultKind> = found.recording_faults.iter().map(|f| f.kind).collect();
    let warned = |wanted: &[FaultKind]| kinds.iter().any(|k| wanted.contains(k));
    let right = match kind.expect {
        Refused => false,
        Warned(wanted) => warned(wanted),
        NotTestable(wanted) => !testable && warned(wanted),
        Survived => true,
    };
    (!right).then(|| format!("{:?}, faults {kinds:?}, expected {:?}", found.verdict, kind.expect))
}

fn all(total: usize) {
    let began = std::time::Instant::now();
    std::panic::set_hook(Box::new(|info| {
        if let Ok(mut place) = PANIC.lock() {
            *place = info.to_string().replace('\n', " ");
        }
    }));
    let sound = sound();
    let clean: Vec<String> = sound
        .iter()
        .map(|r| {
            let found = diagnose(std::slice::from_ref(r), &[], &options(), &|_, _| ()).expect("sound");
            format!("{:?} with faults {:?}", found.verdict, found.recording_faults)
        })
        .collect();
    println!("unbroken: {clean:?}");
    assert!(clean.iter().all(|c| c.ends_with("faults []")));
    let each = total.div_ceil(KINDS.len());
    let complaints: Vec<(usize, Option<String>)> = (0..KINDS.len() * each)
        .into_par_iter()
        .map(|i| {
            let (kind, seed) = (i % KINDS.len(), i / KINDS.len());
            let mut random = ChaCha8Rng::seed_from_u64(1000 * kind as u64 + seed as u64);
            let input = (KINDS[kind].broken)(&sound[seed % sound.len()], &mut random);
            (kind, judge(&KINDS[kind], input).map(|c| format!("{} (seed {seed}): {c}", KINDS[kind].name)))
        })
        .collect();
    let _ = std::panic::take_hook();
    for (k, kind) in KINDS.iter().enumerate() {
        let bad: Vec<&String> =
            complaints.iter().filter(|(of, _)| *of == k).filter_map(|(_, c)| c.as_ref()).collect();
        println!("{:44} {:3} of {each} as expected", kind.name, each - bad.len());
        for c in bad.iter().take(3) {
            println!("    {c}");
        }
    }
    let bad = complaints.iter().filter(|(_, c)| c.is_some()).count();
    let seconds = began.elapsed().as_secs_f64();
    println!("{} broken recordings, {bad} not handled as expected, {seconds:.1} s", complaints.len());
    assert_eq!(bad, 0);
}

#[test]
fn broken_recordings_are_refused_or_warned_of() {
    all(3 * KINDS.len());
}

#[test]
#[ignore = "all 2 000, some minutes: what `--ignored` is for"]
fn two_thousand_broken_recordings() {
    all(2000);
}

/// Squares overflowed, their difference was no number, and the search for the next direction never ended.
#[test]
fn a_number_too_large_to_square_filled_the_memory() {
    let said = |factor: f64| {
        let mut r = Recording { name: "broken.csv".into(), ..sound().remove(0) };
        r.velocity = None;
        r.position.iter_mut().for_each(|x| *x *= factor);
        diagnose(&[r], &[], &options(), &|_, _| ()).map(|d| d.summary).map_err(|e| e.to_string())
    };
    for factor in [1e60, 1e160, 1e300] {
        let refused = said(factor).expect_err("too large");
        assert!(
            refused.contains("broken.csv: position at 0 s is") && refused.contains("up to 1e50"),
            "{refused}"
        );
    }
    // not a sensible number, but one: an answer or a refusal, and an end
    for factor in [1e-200, 1e-60, 1e30] {
        println!("{factor:e}: {:?}", said(factor));
    }
}
