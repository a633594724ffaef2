//! Recordings onto disk, and the labels beside them, under a name that says what to do with them.

use crate::cases::{Extent, HIDES, Planned, Purpose, Scene, stage};
use crate::error::{Error, Result};
use crate::hidden::Hidden;
use crate::sensors::{record, truth};
use signals::Recording;
use signals::files;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// One effect of a case.
#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
pub(crate) struct Concealed {
    /// Catalogue id.
    pub effect: String,
    /// Times the noise that were asked for.
    pub strength: f64,
    /// Times the noise that were reached.
    pub reached: f64,
    /// Parameters as a diagnosis would state them, SI.
    pub parameters: BTreeMap<String, f64>,
}

/// What is concealed in a recording.
#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
pub(crate) struct Label {
    /// Number of the case.
    pub case: usize,
    /// `null`, `single`, `pair`, `never`, `decoy` or `unreached`.
    pub kind: String,
    /// What is hidden, or the decoy's name.
    pub concealed: Vec<Concealed>,
    /// Name of the decoy.
    pub decoy: String,
    /// Share of what is hidden that the baseline cannot absorb (U).
    pub left: f64,
    /// The baseline's parameters, SI.
    pub baseline: BTreeMap<String, f64>,
}

/// Where the files of a proof are.
#[derive(Debug, Clone)]
pub(crate) struct Places {
    root: PathBuf,
}

impl Places {
    /// A folder for a proof.
    pub(crate) fn new(root: &Path) -> Self {
        Self { root: root.to_path_buf() }
    }

    /// A file of the folder.
    pub(crate) fn file(&self, name: &str) -> PathBuf {
        self.root.join(name)
    }

    pub(crate) fn recording(&self, case: usize) -> PathBuf {
        self.root.join(format!("recordings/{case:04}.csv"))
    }

    pub(crate) fn again(&self, case: usize) -> PathBuf {
        self.root.join(format!("recordings/{case:04}-again.csv"))
    }

    pub(crate) fn answer(&self, case: usize, extension: &str) -> PathBuf {
        self.root.join(format!("answers/{case:04}.{extension}"))
    }

    pub(crate) fn truth(&self, case: usize) -> PathBuf {
        self.root.join(format!("sealed/{case:04}.csv"))
    }

    pub(crate) fn label(&self, case: usize) -> PathBuf {
        self.root.join(format!("sealed/{case:04}.json"))
    }

    /// Makes the folders, and refuses one that holds another proof. True where this proof was begun before.
    ///
    /// # Errors
    /// Names the folder and what is in the way.
    pub(crate) fn prepare(&self, extent: &Extent) -> Result<bool> {
        for folder in ["recordings", "answers", "sealed"] {
            let path = self.root.join(folder);
            std::fs::create_dir_all(&path).map_err(|e| Error::Folder { path, reason: files::reason(&e) })?;
        }
        let plan = self.file("plan.json");
        let wanted = serde_json::to_string_pretty(extent)?;
        match std::fs::read_to_string(&plan) {
            Ok(found) if found.trim() == wanted => Ok(true),
            Ok(_) => Err(Error::OtherProof(self.root.clone())),
            Err(_) => {
                files::write(&plan, format!("{wanted}\n").as_bytes())?;
                Ok(false)
            }
        }
    }

    /// Whether the labels of this proof have been looked at.
    pub(crate) fn are_labels_open(&self) -> bool {
        self.file("opened").exists()
    }

    /// Opens the labels for good, and tells which of `count` cases had been answered until then.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub(crate) fn open_labels(&self, count: usize) -> Result<Vec<usize>> {
        let answered: Vec<usize> = (0..count).filter(|case| self.answer(*case, "json").exists()).collect();
        if !self.are_labels_open() {
            let said = format!("the labels were opened after {} of {count} answers\n", answered.len());
            files::write(&self.file("opened"), said.as_bytes())?;
        }
        Ok(answered)
    }
}

/// Makes the recordings of one case and puts its label and its truth into the sealed folder.
///
/// # Errors
/// A file that cannot be written.
pub(crate) fn seal(places: &Places, case: usize, planned: &Planned, seconds: f64) -> Result<()> {
    // the label comes last: with it the case is whole
    if places.label(case).exists() {
        return Ok(());
    }
    let scene = stage(planned, seconds);
    let decoy = match planned.purpose {
        Purpose::Decoy(decoy) => Some(decoy),
        _ => None,
    };
    for (path, (history, seen), seed) in [
        (places.recording(case), &scene.recorded, planned.seed ^ 0x0011),
        (places.again(case), &scene.again, planned.seed ^ 0x0022),
    ] {
        write_csv(&path, &record(&scene.bench, seen, history, decoy, seed))?;
    }
    let (history, seen) = &scene.again;
    let judge = truth(&scene.bench, seen, history);
    write_csv(&places.truth(case), &judge)?;
    write_json(&places.label(case), &label(case, planned, &scene, seconds))
}

fn write_csv(path: &Path, recording: &Recording) -> Result<()> {
    Ok(files::write(path, recording.to_csv()?.as_bytes())?)
}

/// Writes `value` as indented JSON with a line end.
///
/// # Errors
/// The file cannot be written.
pub(crate) fn write_json(path: &Path, value: &impl serde::Serialize) -> Result<()> {
    let text = serde_json::to_string_pretty(value)?;
    Ok(files::write(path, format!("{text}\n").as_bytes())?)
}

fn label(case: usize, planned: &Planned, scene: &Scene, seconds: f64) -> Label {
    let half = scene.bench.half;
    let strength = if let Purpose::Hidden { strength, .. } = planned.purpose { strength } else { 0.0 };
    let concealed: Vec<Concealed> = scene
        .hidden
        .iter()
        .zip(&scene.reached)
        .map(|(h, reached)| Concealed {
            effect: h.kind.id.into(),
            strength,
            reached: *reached,
            parameters: h.parameters(half, seconds),
        })
        .collect();
    let missed = |c: &Concealed| !(0.75..1.34).contains(&(c.reached / c.strength));
    let kind = match planned.purpose {
        // on this plant and motion the effect does not come to that size: nothing is known about the case then
        Purpose::Hidden { first, .. } if !first.never && concealed.iter().any(missed) => "unreached",
        Purpose::Null => "null",
        Purpose::Decoy(_) => "decoy",
        // by what the plant shows, not by the name of what is hidden
        Purpose::Hidden { .. } if scene.left < HIDES => "never",
        Purpose::Hidden { second: Some(_), .. } => "pair",
        Purpose::Hidden { .. } => "single",
    };
    let body = &scene.body;
    let of_the_law: f64 = scene.hidden.iter().map(Hidden::of_the_law).sum();
    let baseline = [
        ("mass", body.mass / half),
        ("coulomb_p", body.coulomb[0] + of_the_law),
        ("coulomb_n", body.coulomb[1] + of_the_law),
        ("viscous_p", body.viscous[0] / half),
        ("viscous_n", body.viscous[1] / half),
    ];
    Label {
        case,
        kind: kind.into(),
        concealed,
        left: scene.left,
        decoy: if let Purpose::Decoy(d) = planned.purpose { d.id.into() } else { String::new() },
        baseline: baseline.into_iter().map(|(n, v)| (n.to_string(), v)).collect(),
    }
}
