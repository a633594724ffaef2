//! The concealed-effect proof: effects hidden in recordings of a plant that shares no equation with the crates under
//! test, answers given without the labels, and the tables that come of comparing the two.
//!
//! ```text
//! motion    what the body is asked to do          hidden   what can be hidden in it
//! open      what nobody's catalogue has
//! plant     implicit contact, own time stepping   sensors  what the channels make of it
//! cases     what is hidden where, and how much    seal     recordings and labels onto disk
//! answers   recordings in, diagnoses out: sees neither plan nor labels
//! score     answers against labels                tables   for people, and for machines
//! ```

#![forbid(unsafe_code)]

mod answers;
mod body;
mod cases;
mod error;
mod estimator;
mod hidden;
mod kind;
mod motion;
mod open;
mod plant;
mod scale;
mod score;
mod seal;
mod sensors;
mod tables;

pub use cases::Extent;
pub use error::Error;
pub use scale::NOISE;
pub use tables::Proof;

use error::Result;
use rayon::prelude::*;
use seal::Places;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Ids of everything that can be hidden.
#[must_use]
pub fn effects() -> Vec<&'static str> {
    hidden::ALL.iter().map(|k| k.id).collect()
}

/// Ids of what is hidden in the open world.
#[must_use]
pub fn open_effects() -> Vec<&'static str> {
    open::ALL.iter().map(|k| k.id).collect()
}

/// What is being done, how many cases are done, and of how many.
pub type Progress<'a> = &'a (dyn Fn(&str, usize, usize) + Sync);

/// A proof in a folder, as far as it is. The steps are [`Run::seal`], [`Run::answer`] and [`Run::open_labels`], in this
/// order; each skips what was done before.
#[derive(Debug)]
pub struct Run {
    places: Places,
    extent: Extent,
    count: usize,
    continued: bool,
}

impl Run {
    /// Makes the folder, or continues the proof that is in it.
    ///
    /// # Errors
    /// The folder cannot be made, or holds a proof of another extent.
    pub fn begin(folder: &Path, extent: Extent) -> Result<Self> {
        let places = Places::new(folder);
        let continued = places.prepare(&extent)?;
        let count = cases::plan(&extent).len();
        Ok(Self { places, extent, count, continued })
    }

    /// Number of recordings.
    #[must_use]
    pub fn count(&self) -> usize {
        self.count
    }

    /// Whether this proof was begun before.
    #[must_use]
    pub fn is_continued(&self) -> bool {
        self.continued
    }

    /// Makes every recording and seals its label.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn seal(&self, progress: Progress<'_>) -> Result<()> {
        // the plan is dropped at the end: from then on nothing knows what is where
        let cases = cases::plan(&self.extent);
        let one = |case: usize| seal::seal(&self.places, case, &cases[case], self.extent.seconds);
        each("sealing recordings", self.count, progress, one).map(|_| ())
    }

    /// Diagnoses every recording for as long as there is time. Once the labels are open no answer is added.
    ///
    /// # Errors
    /// A recording that cannot be read, or an answer that cannot be written.
    pub fn answer(&self, in_time: impl Fn() -> bool + Sync, progress: Progress<'_>) -> Result<()> {
        if self.places.are_labels_open() {
            return Ok(());
        }
        let one = |case| if in_time() { answers::answer(&self.places, case) } else { Ok(()) };
        each("diagnosing", self.count, progress, one).map(|_| ())
    }

    /// Opens the labels for good, scores every case that is answered, and writes the tables into the folder. Returns them
    /// with the number of cases answered; none where nothing is answered.
    ///
    /// # Errors
    /// A file of the proof that is missing or damaged, or cannot be written.
    pub fn open_labels(&self, progress: Progress<'_>) -> Result<Option<(Proof, usize)>> {
        let answered = self.places.open_labels(self.count)?;
        if answered.is_empty() {
            return Ok(None);
        }
        let one = |i: usize| score::score(&self.places, answered[i]);
        let proof = Proof::new(each("opening the labels", answered.len(), progress, one)?);
        seal::write_json(&self.places.file("prove.json"), &proof)?;
        signals::files::write(&self.places.file("cases.csv"), proof.cases_csv().as_bytes())?;
        signals::files::write(&self.places.file("confusion.csv"), proof.confusion_csv().as_bytes())?;
        Ok(Some((proof, answered.len())))
    }
}

/// Works on all cases on every core; the first failure ends it, what is done stays done.
fn each<T: Send>(
    what: &str,
    count: usize,
    progress: Progress<'_>,
    work: impl Fn(usize) -> Result<T> + Sync,
) -> Result<Vec<T>> {
    let done = AtomicUsize::new(0);
    (0..count)
        .into_par_iter()
        .map(|case| {
            let result = work(case);
            progress(what, done.fetch_add(1, Ordering::Relaxed) + 1, count);
            result
        })
        .collect()
}
