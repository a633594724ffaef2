//! Work that is interrupted ends at its next step.

use procedures::identified::{FittedLaw, How, identify, identify_watched};
use procedures::{Activity, Error, Unwatched, Watch};
use signals::Recording;
use std::cell::Cell;

/// Interrupts after so many questions.
struct After {
    patience: usize,
    asked: Cell<usize>,
}

impl Watch for After {
    fn begin(&self, _: &str) -> Box<dyn Activity> {
        Box::new(Unwatched)
    }

    fn listen(&self) {}

    fn is_interrupted(&self) -> bool {
        self.asked.set(self.asked.get() + 1);
        self.asked.get() > self.patience
    }
}

fn recording() -> Recording {
    let mut out = Recording { name: "slide".into(), ..Recording::default() };
    for i in 0..4_000 {
        let t = f64::from(i) * 1e-3;
        let (s, c) = (9.0 * t).sin_cos();
        out.time.push(t);
        out.position.push(0.01 * s);
        out.force.push(0.4 * -0.81 * s + 1.5 * c.signum() + 0.18 * c + 0.01 * (1e4 * t * t).sin());
    }
    out
}

#[test]
fn an_interrupted_fit_ends_at_once() {
    let how = How { law: FittedLaw::Dahl, ..How::default() };
    let ask = |patience| {
        let watch = After { patience, asked: Cell::new(0) };
        let found = identify_watched(&[recording()], &how, &watch);
        (found, watch.asked.get())
    };
    let (found, all) = ask(usize::MAX);
    let found = found.expect("identified");
    assert_eq!(found.found, identify(&[recording()], &how).expect("identified").found);
    for patience in [0, 1, 2, 5, 20, 60, all / 2] {
        let (found, asked) = ask(patience);
        assert!(matches!(found, Err(Error::Cancelled)), "after {patience}: {found:?}");
        println!("interrupted after {patience} of {all} questions, ended {} later", asked - patience);
        // the other starts and both sides of the profile ask once each
        assert!(asked - patience < 40 && all > 200, "{asked} of {all}");
    }
}
