//! The planar handle of one page: a virtual puck on a surface, pulled by the pointer through a spring and damper.
//!
//! ```text
//! pointer ── 60 Hz ──▶ hand (follows it) ── spring, damper ── puck ── friction::planar ── surface
//!                                     1 kHz, every step back to the page
//! ```
//!
//! It needs no device: each page has a puck of its own, stepped by [`haptics::planar`] while the page shows it.

mod puck;
mod surface;
mod task;

pub use puck::{COUPLING, Puck, REACH, Row, Work};
pub use surface::Surface;
pub use task::{Circle, Score, Task};

use crate::session_file;
use friction::planar::Vector;
use perception::{Experiment, RingPlan};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::time::Instant;

/// Steps at most made up for at once: a page whose computer slept does not run ahead.
const MOST_STEPS: u32 = 100;

/// One request about the plane.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(tag = "what", rename_all = "snake_case", deny_unknown_fields)]
pub enum AskPlane {
    /// Shows the plane.
    Open,
    /// Hides it; an unfinished circle starts again.
    Close,
    /// Another surface; the work begins at zero.
    Surface {
        /// Its name.
        name: String,
    },
    /// The hand goes there, m from the middle; or lets go.
    Hand {
        /// m; none lets go.
        at: Option<[f64; 2]>,
    },
    /// Opens a session of the targeting task.
    Begin {
        /// Label of the subject.
        subject: String,
        /// Seed of the order.
        seed: u64,
    },
    /// Goes on with a session of the folder.
    Resume {
        /// Its file.
        name: String,
    },
    /// Selects what is under the puck.
    Select,
    /// Closes the session; what is finished stays.
    Leave,
}

/// What a page draws besides the puck.
#[derive(Debug, Clone, Serialize)]
pub struct Shown<'a> {
    surfaces: Vec<SurfaceShown>,
    surface: &'a str,
    /// Half width and half height, m.
    reach: [f64; 2],
    circle: Option<Circle>,
    scores: &'a [Score],
}

/// A surface as a page draws it.
#[derive(Debug, Clone, Serialize)]
struct SurfaceShown {
    name: &'static str,
    says: &'static str,
    /// Pulls that just move the puck, N.
    edge: Vec<[f64; 2]>,
    /// Direction of the grain, rad.
    grain: Option<f64>,
    /// Distance between detents, m.
    pitch: Option<f64>,
}

/// The plane of one page.
pub struct Plane {
    folder: PathBuf,
    open: bool,
    surface: Surface,
    puck: Puck,
    rows: Vec<Row>,
    stepped: Instant,
    task: Option<Task>,
}

impl Plane {
    /// A plane that is not shown.
    #[must_use]
    pub fn new(folder: PathBuf, now: Instant) -> Self {
        Self {
            folder,
            open: false,
            surface: Surface::ALL[0],
            puck: Puck::default(),
            rows: Vec::new(),
            stepped: now,
            task: None,
        }
    }

    /// Whether it is shown, and stepped.
    #[must_use]
    pub fn is_open(&self) -> bool {
        self.open
    }

    /// Does what a page asks. True when the list of sessions is another one.
    ///
    /// # Errors
    /// What is not accepted, and what would be.
    pub fn obey(&mut self, ask: AskPlane, now: Instant) -> Result<bool, String> {
        match ask {
            AskPlane::Open => {
                self.stepped = now;
                self.open = true;
            }
            AskPlane::Close => {
                self.open = false;
                self.puck.let_go();
                if let Some(task) = &mut self.task {
                    task.abandon();
                }
            }
            AskPlane::Surface { name } => {
                session_file::none_open(self.task.is_some())?;
                self.put_on(Surface::named(&name)?);
            }
            AskPlane::Hand { at: Some([x, y]) } => self.puck.pull(Vector { x, y })?,
            AskPlane::Hand { at: None } => self.puck.let_go(),
            AskPlane::Begin { subject, seed } => {
                session_file::none_open(self.task.is_some())?;
                let plan = RingPlan::new(&Surface::ALL.map(|surface| surface.name), seed);
                let device = "the planar handle of the lab: a puck pulled by the pointer".to_owned();
                let experiment = Experiment::Ring(plan.clone());
                let (log, name) = session_file::create(&self.folder, "plane", &subject, device, experiment)?;
                self.task = Some(Task::new(name, log, plan));
                self.follow_task()?;
                return Ok(true);
            }
            AskPlane::Resume { name } => {
                session_file::none_open(self.task.is_some())?;
                self.task = Some(Task::resume(&self.folder, &name)?);
                self.follow_task()?;
            }
            AskPlane::Select => {
                let Some(task) = &mut self.task else { return Ok(false) };
                let finished = task.select(self.puck.time(), self.puck.position())?;
                self.follow_task()?;
                return Ok(finished);
            }
            AskPlane::Leave => self.task = None,
        }
        Ok(false)
    }

    /// The surface of the next circle.
    fn follow_task(&mut self) -> Result<(), String> {
        let Some(name) = self.task.as_ref().and_then(Task::surface) else { return Ok(()) };
        if name != self.surface.name {
            let surface = Surface::named(name)?;
            self.put_on(surface);
        }
        Ok(())
    }

    fn put_on(&mut self, surface: Surface) {
        self.surface = surface;
        self.puck.put_on(&surface);
    }

    /// Steps up to `now`; what happened since the last call, and the work since the surface was chosen.
    pub fn advance(&mut self, now: Instant) -> (&[Row], Work) {
        let due = now.duration_since(self.stepped).as_secs_f64() / COUPLING.period;
        let steps = (due as u32).min(MOST_STEPS);
        self.stepped = if steps < MOST_STEPS {
            self.stepped + std::time::Duration::from_secs_f64(f64::from(steps) * COUPLING.period)
        } else {
            now
        };
        self.rows.clear();
        for _ in 0..steps {
            self.rows.push(self.puck.step(&self.surface));
        }
        (&self.rows, self.puck.work())
    }

    /// What a page draws.
    #[must_use]
    pub fn shown(&self) -> Shown<'_> {
        let surface = |s: &Surface| SurfaceShown {
            name: s.name,
            says: s.says,
            edge: s.edge(),
            grain: s.grain(),
            pitch: s.detent.map(|detent| detent.pitch),
        };
        Shown {
            surfaces: Surface::ALL.iter().map(surface).collect(),
            surface: self.surface.name,
            reach: REACH,
            circle: self.task.as_ref().map(Task::circle),
            scores: self.task.as_ref().map_or(&[], Task::scores),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    /// A target a page would show: the puck is led there and selects.
    fn lead_to(plane: &mut Plane, at: [f64; 2], clock: &mut Instant) -> bool {
        // the hand goes beyond the target, as friction holds the puck back, until the puck is there
        let mut aim = at;
        for _ in 0..200 {
            plane.obey(AskPlane::Hand { at: Some(aim) }, *clock).expect("inside");
            *clock += Duration::from_millis(50);
            plane.advance(*clock);
            let here = plane.puck.position();
            let off = [at[0] - here.x, at[1] - here.y];
            if off[0].hypot(off[1]) < 1e-3 {
                break;
            }
            aim = [aim[0] + 0.2 * off[0], aim[1] + 0.2 * off[1]];
        }
        plane.obey(AskPlane::Select, *clock).expect("kept")
    }

    #[test]
    fn a_session_of_circles_is_kept_and_resumed() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut clock = Instant::now();
        let mut plane = Plane::new(folder.path().to_owned(), clock);
        plane.obey(AskPlane::Open, clock).expect("open");
        let begin = || AskPlane::Begin { subject: "s01".into(), seed: 4 };
        assert!(plane.obey(begin(), clock).expect("created"));
        assert!(plane.obey(begin(), clock).is_err(), "one at a time");
        let surface = AskPlane::Surface { name: "brass".into() };
        assert!(plane.obey(surface, clock).is_err(), "the plan chooses the surface");
        for circle in 0..2 {
            for selection in 0..14 {
                let target = plane.task.as_ref().and_then(Task::target).expect("a target");
                let finished = lead_to(&mut plane, target, &mut clock);
                assert_eq!(finished, selection == 13, "circle {circle}, selection {selection}");
            }
        }
        let session = perception::Session::read(&folder.path().join("plane-s01-1.jsonl")).expect("a session");
        for record in &session.records {
            let perception::Record::Ring(trial) = record else { panic!("{record:?}") };
            println!("{} {} bits: {:?}", trial.case.surface, trial.id_bits, trial.throughput());
            assert_eq!((trial.clicks.len(), trial.errors), (14, 0));
        }
        assert_eq!(session.records.len(), 2);
        plane.obey(AskPlane::Leave, clock).expect("left");
        plane.obey(AskPlane::Resume { name: "plane-s01-1.jsonl".into() }, clock).expect("resumed");
        let circle = plane.task.as_ref().expect("a task").circle();
        assert_eq!((circle.done, circle.of), (2, 3 * Surface::ALL.len()));
        assert_eq!(plane.shown().scores.len(), 2);
        let why = plane
            .obey(AskPlane::Leave, clock)
            .and_then(|_| plane.obey(AskPlane::Resume { name: "../x.jsonl".into() }, clock));
        assert_eq!(why, Err("no session `../x.jsonl`".into()));
    }
}
