//! A figure, its numbers, and the page of all figures.

use friction::Invalid;
use haptics::{FaultKind, Refused};
use report::escape;
use report::page::Page;
use report::picture::{DrawError, Panel, Picture, svg};

/// What making a figure returns.
pub(crate) type Result<T> = std::result::Result<T, Error>;

/// A figure that cannot be computed.
#[derive(Debug, Clone, thiserror::Error)]
pub enum Error {
    /// The simulated rig cannot be built.
    #[error("{0}")]
    Rig(Invalid),
    /// The device refuses the settings.
    #[error("{0}")]
    Refused(Refused),
    /// A fault ended the rendering.
    #[error("the simulated device stopped: {0:?}")]
    Stopped(FaultKind),
    /// The simulated recording cannot be identified.
    #[error(transparent)]
    Recording(#[from] signals::Error),
    /// The drawing library failed.
    #[error(transparent)]
    Draw(#[from] DrawError),
}

impl From<Invalid> for Error {
    fn from(why: Invalid) -> Self {
        Self::Rig(why)
    }
}

impl From<Refused> for Error {
    fn from(why: Refused) -> Self {
        Self::Refused(why)
    }
}

/// A printed number and ours.
#[derive(Debug, Clone)]
pub struct Number {
    /// What it is, with its unit.
    pub what: String,
    /// Printed value.
    pub thesis: String,
    /// As it comes out here.
    pub ours: String,
}

/// One figure.
#[derive(Debug, Clone)]
pub struct Figure {
    /// Printed number of the figure: `4-10`.
    pub id: &'static str,
    /// Printed caption.
    pub caption: &'static str,
    /// Side by side.
    pub panels: Vec<Panel>,
    /// What can be compared.
    pub numbers: Vec<Number>,
}

pub(crate) fn number(what: impl Into<String>, thesis: impl Into<String>, ours: impl Into<String>) -> Number {
    Number { what: what.into(), thesis: thesis.into(), ours: ours.into() }
}

impl Figure {
    /// Name of its file.
    #[must_use]
    pub fn file(&self) -> String {
        format!("figure_{}.svg", self.id)
    }

    /// The figure as SVG.
    ///
    /// # Errors
    /// The drawing library's.
    pub fn svg(&self) -> Result<String> {
        Ok(svg(&Picture::of(self.panels.clone()))?)
    }
}

/// The page of these figures, with their captions and numbers; the pictures are files beside it.
#[must_use]
pub fn page(figures: &[Figure]) -> String {
    let mut page = Page::wide();
    page.html(
        "<header><h1>Figures of the thesis, recomputed</h1></header>
<p>Chapter 3: simulated recordings with the parameters of table 3-3 and the errors of table 3-2. Chapter 4: the device's own renderer around the device of section 4.4.</p>",
    );
    for f in figures {
        let img = format!(r#"<img src="{}" alt="Figure {}">"#, f.file(), f.id);
        page.picture(&img, &format!("<b>Figure {}.</b> {}", f.id, escape(f.caption)));
        if f.numbers.is_empty() {
            continue;
        }
        let rows = f.numbers.iter().map(|n| {
            format!(
                "<tr><td>{}</td><td>{}</td><td>{}</td></tr>",
                escape(&n.what),
                escape(&n.thesis),
                escape(&n.ours)
            )
        });
        page.html(format!(
            "<table><tr><th></th><th>thesis</th><th>here</th></tr>{}</table>",
            rows.collect::<String>()
        ));
    }
    page.finish("Figures of the thesis, recomputed", "")
}
