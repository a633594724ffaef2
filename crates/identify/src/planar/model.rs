//! A model of a body that slides in the plane: mass of each axis, level by direction, viscous friction, offset.

use super::ellipse::Ellipse;
use super::track::Track;
use crate::identification::Identification;
use friction::planar::{Coulomb, FrictionLaw, Grain, Law, Vector};
use friction::{Invalid, in_range};
use serde::{Deserialize, Serialize};
use signals::files::reason;
use signals::{Error, Place};
use std::collections::BTreeMap;
use std::path::Path;

/// Name and version of the file.
pub const PLANAR_MODEL_SCHEMA: &str = "tribos.planar_model/1";

/// A body that slides in the plane.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanarModel {
    /// [`PLANAR_MODEL_SCHEMA`].
    pub schema: String,
    /// Name.
    #[serde(default)]
    pub name: String,
    /// Mass that the x axis moves, kg.
    pub mass_x: f64,
    /// Mass that the y axis moves, kg.
    pub mass_y: f64,
    /// Level of friction along the grain, N.
    pub level_along: f64,
    /// Level across the grain, N.
    pub level_across: f64,
    /// Angle of the grain with the x axis, rad.
    pub angle: f64,
    /// Viscous friction, N·s/m: a symmetric matrix.
    pub viscous_xx: f64,
    /// Its element off the diagonal.
    pub viscous_xy: f64,
    /// Its second element on the diagonal.
    pub viscous_yy: f64,
    /// Constant that the force channel of x adds, N.
    #[serde(default)]
    pub offset_x: f64,
    /// Constant that the force channel of y adds, N.
    #[serde(default)]
    pub offset_y: f64,
    /// Cut-off of the zero-phase filter of a prediction, Hz.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cutoff_hz: Option<f64>,
    /// Standard deviations, by the names of an identification.
    #[serde(default)]
    pub std: BTreeMap<String, f64>,
}

impl PlanarModel {
    /// What was identified; what the recording does not determine adds nothing.
    #[must_use]
    pub fn of(found: &Identification, ellipse: Ellipse) -> Self {
        let of = |name: &str| found.value(name).filter(|v| v.is_finite());
        let shared = |own: &str, common: &str| of(own).or_else(|| of(common)).unwrap_or(0.0);
        Self {
            schema: PLANAR_MODEL_SCHEMA.into(),
            name: String::new(),
            mass_x: shared("mass_x", "mass").max(0.0),
            mass_y: shared("mass_y", "mass").max(0.0),
            level_along: ellipse.along().max(0.0),
            level_across: ellipse.across().max(0.0),
            angle: ellipse.angle(),
            viscous_xx: shared("viscous_xx", "viscous"),
            viscous_xy: of("viscous_xy").unwrap_or(0.0),
            viscous_yy: shared("viscous_yy", "viscous"),
            offset_x: of("offset_x").unwrap_or(0.0),
            offset_y: of("offset_y").unwrap_or(0.0),
            cutoff_hz: None,
            std: found
                .parameters
                .iter()
                .filter(|(_, p)| p.std.is_finite())
                .map(|(name, p)| (name.clone(), p.std))
                .collect(),
        }
    }

    /// The law of the contact, which a renderer and a rig step. Viscous friction of a matrix is not in it.
    #[must_use]
    pub fn law(&self) -> Law<f64> {
        let across = if self.level_along > 0.0 { self.level_across / self.level_along } else { 1.0 };
        Law::Coulomb(Coulomb {
            level: self.level_along,
            stiction: self.level_along,
            viscous: 0.0,
            grain: Grain::at(self.angle, across),
        })
    }

    /// Checks that every number is finite and physical.
    ///
    /// # Errors
    /// The first that is not, with what would be accepted.
    pub fn validate(&self) -> Result<(), Invalid> {
        in_range("mass_x", self.mass_x, 0.0, 1e6)?;
        in_range("mass_y", self.mass_y, 0.0, 1e6)?;
        in_range("level_along", self.level_along, 0.0, 1e6)?;
        in_range("level_across", self.level_across, self.level_along, 100.0 * self.level_along)?;
        in_range("angle", self.angle, -7.0, 7.0)?;
        for (name, value) in [
            ("viscous_xx", self.viscous_xx),
            ("viscous_xy", self.viscous_xy),
            ("viscous_yy", self.viscous_yy),
            ("offset_x", self.offset_x),
            ("offset_y", self.offset_y),
        ] {
            in_range(name, value, -1e6, 1e6)?;
        }
        if let Some(cutoff) = self.cutoff_hz {
            in_range("cutoff_hz", cutoff, 1e-3, 1e6)?;
        }
        self.law().validate()
    }

    /// Friction against a velocity, m/s, viscous friction included, N; zero at rest.
    ///
    /// ```
    /// # let text = "schema = \"tribos.planar_model/1\"\nmass_x = 1.0\nmass_y = 1.0\nlevel_along = 1.0\nlevel_across = 2.0\n\
    /// #     angle = 0.0\nviscous_xx = 3.0\nviscous_xy = 0.0\nviscous_yy = 3.0\n";
    /// let wood = identify::planar::PlanarModel::from_toml("wood.toml", text).unwrap();
    /// let [x, y] = wood.friction([0.0, -0.1]);
    /// assert!(x.abs() < 1e-12 && (y + 2.3).abs() < 1e-12);
    /// ```
    #[must_use]
    pub fn friction(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [fx, fy] = Ellipse::of(self.level_along, self.level_across, self.angle).force(x, y)[0];
        [fx + self.viscous_xx * x + self.viscous_xy * y, fy + self.viscous_xy * x + self.viscous_yy * y]
    }

    /// Force at every sample of a stretch, N; at rest friction is unknown and the force is that without it.
    #[must_use]
    pub fn predict(&self, track: &Track) -> [Vec<f64>; 2] {
        let ellipse = Ellipse::of(self.level_along, self.level_across, self.angle);
        let mut out = [Vec::with_capacity(track.len()), Vec::with_capacity(track.len())];
        for i in 0..track.len() {
            let v = Vector { x: track.v[0][i], y: track.v[1][i] };
            let friction = if track.speed[i] >= track.guard { ellipse.force(v.x, v.y)[0] } else { [0.0; 2] };
            let x = self.mass_x * track.a[0][i] + self.viscous_xx * v.x + self.viscous_xy * v.y;
            let y = self.mass_y * track.a[1][i] + self.viscous_xy * v.x + self.viscous_yy * v.y;
            out[0].push(x + friction[0] + self.offset_x);
            out[1].push(y + friction[1] + self.offset_y);
        }
        out
    }

    /// The text of `model.toml`.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let head = "# a body that slides in the plane: kg, N, N·s/m, rad\n";
        // numbers, texts and a table of numbers: always writable
        format!("{head}{}", toml::to_string(self).unwrap_or_default())
    }

    /// Whether this is the text of such a model.
    #[must_use]
    pub fn is_planar(text: &str) -> bool {
        text.lines().any(|l| {
            let l = l.trim();
            l.starts_with("schema") && l.contains("tribos.planar_model/")
        })
    }

    /// Reads the text of a `model.toml`; `file` stands for the file in messages.
    ///
    /// # Errors
    /// File, line and column of what is not accepted.
    pub fn from_toml(file: &str, text: &str) -> Result<Self, Error> {
        let refuse = |line, column: Option<usize>, why: String| Error::Input {
            file: file.into(),
            place: Place { line, column: column.map(|c| (c, String::new())) },
            value: String::new(),
            accepted: why,
        };
        let model: Self = toml::from_str(text).map_err(|e| {
            let at = e.span().map(|s| {
                let before = text.get(..s.start).unwrap_or_default();
                let line = before.matches('\n').count() + 1;
                (line as u64, before.chars().rev().take_while(|c| *c != '\n').count() + 1)
            });
            refuse(at.map(|a| a.0), at.map(|a| a.1), e.message().replace('\n', " "))
        })?;
        if model.schema != PLANAR_MODEL_SCHEMA {
            let why = format!("schema `{}`; accepted is `{PLANAR_MODEL_SCHEMA}`", model.schema);
            return Err(refuse(None, None, why));
        }
        model.validate().map_err(|e| refuse(None, None, e.to_string()))?;
        Ok(model)
    }

    /// Reads a `model.toml`.
    ///
    /// # Errors
    /// As [`PlanarModel::from_toml`]; a file that cannot be read.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        let file = path.display().to_string();
        let text =
            std::fs::read_to_string(path).map_err(|e| Error::File { file: file.clone(), why: reason(&e) })?;
        Self::from_toml(&file, &text)
    }
}
