//! What robots log: messages of several topics, each with a clock of its own, and the recording they make.
//!
//! A joint of a `sensor_msgs/JointState` is `position`, `velocity` and `effort`; every series has the name `TOPIC:FIELD` as well:
//! `/joint_states:elbow.position`, `/ft:force.z`. The clock of the recording is that of the position: other topics are interpolated
//! linearly at its stamps, only where they overlap, and not across their own gaps.

use super::cdr::{self, JOINT_FIELDS, WRENCH_FIELDS};
use super::columns::{self, Named, Slot};
use super::variables::{TIME_ZERO, Wanted};
use crate::error::Place;
use crate::{Error, Geometry, Map, Recording};
use std::borrow::Cow;

/// Median steps of a topic's clock: nothing is interpolated across more.
const GAP: i64 = 5;

/// The types that are read, as ROS 2 names them.
pub(crate) const JOINT_STATE: &str = "sensor_msgs/msg/JointState";
pub(crate) const WRENCH: &str = "geometry_msgs/msg/WrenchStamped";

/// Series of one clock.
#[derive(Debug, Default)]
struct Track {
    topic: String,
    joint: Option<String>,
    /// By the sender, ns; zero where it gave none.
    stamps: Vec<i64>,
    /// By the recorder, ns.
    logged: Vec<i64>,
    fields: Vec<(Cow<'static, str>, Vec<f64>)>,
}

impl Track {
    fn push(&mut self, stamp: i64, logged: i64, values: &[f64]) {
        self.stamps.push(stamp);
        self.logged.push(logged);
        for ((_, series), value) in self.fields.iter_mut().zip(values) {
            series.push(*value);
        }
    }

    fn series(&self, field: &str) -> Option<&[f64]> {
        let values = &self.fields.iter().find(|(name, _)| name == field)?.1;
        values.iter().any(|x| !x.is_nan()).then_some(values)
    }

    fn name_of(&self, field: &str) -> String {
        match &self.joint {
            Some(joint) => format!("{}:{joint}.{field}", self.topic),
            None => format!("{}:{field}", self.topic),
        }
    }

    fn range(&self) -> (i64, i64) {
        (self.stamps.first().copied().unwrap_or(0), self.stamps.last().copied().unwrap_or(0))
    }

    /// In the order of the stamps; where a sender gave none, by the recorder's.
    fn settle(&mut self, remarks: &mut Vec<String>) {
        if self.stamps.contains(&0) {
            remarks.push(format!("{}: messages without stamp, the time is the recorder's", self.topic));
            self.stamps.clone_from(&self.logged);
        }
        self.logged = Vec::new();
        if self.stamps.is_sorted() {
            return;
        }
        remarks.push(format!("{}: messages are sorted by their stamps", self.topic));
        let mut order: Vec<usize> = (0..self.stamps.len()).collect();
        order.sort_by_key(|&i| self.stamps[i]);
        self.stamps = order.iter().map(|&i| self.stamps[i]).collect();
        for (_, values) in &mut self.fields {
            *values = order.iter().map(|&i| values[i]).collect();
        }
    }

    /// Values interpolated linearly at `stamps`. In a gap the value is NaN; the number of these is returned, too.
    fn at(&self, values: &[f64], stamps: &[i64]) -> (Vec<f64>, usize) {
        let mut steps: Vec<i64> = self.stamps.windows(2).map(|w| w[1].saturating_sub(w[0])).collect();
        steps.sort_unstable();
        let longest = steps.get(steps.len() / 2).map_or(i64::MAX, |step| step.saturating_mul(GAP));
        let mut lost = 0;
        let value = |&t: &i64| {
            let after = self.stamps.partition_point(|s| *s <= t);
            let Some(before) = after.checked_sub(1) else { return f64::NAN };
            let (from, start) = (values[before], self.stamps[before]);
            if start == t {
                return from;
            }
            let Some(end) = self.stamps.get(after) else { return f64::NAN };
            if end - start > longest {
                lost += 1;
                return f64::NAN;
            }
            let share = (t - start) as f64 / (end - start) as f64;
            from + share * (values[after] - from)
        };
        let values = stamps.iter().map(value).collect();
        (values, lost)
    }
}

/// Everything of a log that is understood, and what else it has.
#[derive(Debug, Default)]
pub(crate) struct Topics {
    tracks: Vec<Track>,
    /// Topic and type of the rest.
    others: Vec<(String, String)>,
}

impl Topics {
    /// A topic that is not read.
    pub(crate) fn other(&mut self, topic: &str, kind: &str) {
        let other = (topic.to_owned(), kind.to_owned());
        if !self.others.contains(&other) {
            self.others.push(other);
        }
    }

    /// A message of a type that [`is_read`]; times in ns.
    pub(crate) fn message(
        &mut self,
        topic: &str,
        kind: &str,
        logged: i64,
        data: &[u8],
    ) -> Result<(), String> {
        if kind == JOINT_STATE {
            let (stamp, joints) = cdr::joint_state(data)?;
            for (name, values) in joints {
                self.track(topic, Some(name), JOINT_FIELDS.map(Cow::Borrowed)).push(stamp, logged, &values);
            }
        } else {
            let (stamp, values) = cdr::wrench(data)?;
            self.track(topic, None, WRENCH_FIELDS.map(Cow::Borrowed)).push(stamp, logged, &values);
        }
        Ok(())
    }

    /// Numbers of a message by name; those of a topic's first message are kept.
    pub(crate) fn numbers(&mut self, topic: &str, logged: i64, numbers: &[(String, f64)]) {
        let track = self.track(topic, None, numbers.iter().map(|(name, _)| name.clone().into()));
        let value = |field: &str| numbers.iter().find(|(name, _)| name == field).map_or(f64::NAN, |n| n.1);
        let values: Vec<f64> = track.fields.iter().map(|(field, _)| value(field)).collect();
        track.push(logged, logged, &values);
    }

    /// The track of a topic and joint; a new one has these fields.
    fn track(
        &mut self,
        topic: &str,
        joint: Option<&str>,
        fields: impl IntoIterator<Item = Cow<'static, str>>,
    ) -> &mut Track {
        let at = self.tracks.iter().position(|t| t.topic == topic && t.joint.as_deref() == joint);
        let at = at.unwrap_or_else(|| {
            self.tracks.push(Track {
                topic: topic.into(),
                joint: joint.map(str::to_owned),
                fields: fields.into_iter().map(|field| (field, Vec::new())).collect(),
                ..Track::default()
            });
            self.tracks.len() - 1
        });
        &mut self.tracks[at]
    }

    /// What there is, for messages.
    fn says(&self) -> String {
        let track = |t: &Track| {
            let fields: Vec<&str> =
                t.fields.iter().map(|(f, _)| &**f).filter(|f| t.series(f).is_some()).collect();
            let (topic, n) = (t.name_of(""), t.stamps.len());
            format!("{topic}{{{}}} ({n} messages)", fields.join(","))
        };
        let others = self.others.iter().map(|(topic, kind)| format!("{topic} ({kind})"));
        let all: Vec<String> = self.tracks.iter().map(track).chain(others).collect();
        if all.is_empty() { "no messages".into() } else { all.join(", ") }
    }

    /// The recording of one joint.
    pub(crate) fn assemble(mut self, file: &str, wanted: &Wanted) -> Result<Recording, Error> {
        let mut remarks = Vec::new();
        for track in &mut self.tracks {
            track.settle(&mut remarks);
        }
        remarks.sort();
        remarks.dedup();
        let fail = |accepted: String| Error::Input {
            file: file.into(),
            place: Place::default(),
            value: String::new(),
            accepted,
        };
        let joint = self.joint(wanted.joint);
        let map = (wanted.map)(&|name| self.find(name, joint.as_ref().ok().copied()).is_some());
        // a position that the map gives by its topic needs no joint
        let position = map.and_then(|map| map.first_variable(Slot::Position));
        let base = match position.and_then(|name| self.find(name, joint.as_ref().ok().copied())) {
            Some((track, _)) => track,
            None => joint.map_err(fail)?,
        };
        let made = self.joined(base, map, &fail, &mut remarks)?;
        let mut recording =
            columns::assemble(made).map_err(|missing| fail(format!("no {missing}; {}", self.has())))?;
        recording.remarks = remarks;
        recording.metadata.insert(TIME_ZERO.into(), base.range().0.to_string());
        if let Some(joint) = &base.joint {
            recording.metadata.insert("joint".into(), joint.clone());
            let beside =
                |t: &&Track| t.topic == base.topic && t.joint != base.joint && t.stamps == base.stamps;
            for other in self.tracks.iter().filter(beside) {
                let name = other.joint.as_deref().unwrap_or_default();
                for (field, values) in &other.fields {
                    if recording.len() == values.len() && other.series(field).is_some() {
                        recording.extra.insert(format!("{name}.{field}"), values.clone());
                    }
                }
            }
        }
        Ok(recording)
    }

    fn has(&self) -> String {
        format!("the file has {}", self.says())
    }

    /// The joint that is asked for, or the only one.
    fn joint(&self, wanted: Option<&str>) -> Result<&Track, String> {
        let joints: Vec<&Track> = self.tracks.iter().filter(|t| t.joint.is_some()).collect();
        let name = |t: &Track| t.joint.clone().unwrap_or_default();
        let full = |t: &Track| format!("{}:{}", t.topic, name(t));
        let list = |tracks: &[&Track]| {
            let twice = |t: &Track| tracks.iter().filter(|o| o.joint == t.joint).count() > 1;
            let names: Vec<String> =
                tracks.iter().map(|t| if twice(t) { full(t) } else { name(t) }).collect();
            format!("accepted is --joint with one of {}", names.join(", "))
        };
        if joints.is_empty() {
            return Err(format!("no message of the type {JOINT_STATE}; {}", self.has()));
        }
        let Some(wanted) = wanted else {
            return match joints[..] {
                [one] => Ok(one),
                _ => Err(format!("several joints; {}", list(&joints))),
            };
        };
        let fitting: Vec<&Track> =
            joints.iter().copied().filter(|t| name(t) == wanted || full(t) == wanted).collect();
        match fitting[..] {
            [one] => Ok(one),
            [] => Err(format!("no joint `{wanted}`; {}", list(&joints))),
            _ => Err(format!("joint `{wanted}` is on several topics; {}", list(&fitting))),
        }
    }

    /// A series by its name: `position` of the joint, or `TOPIC:FIELD`.
    fn find<'t>(&'t self, name: &str, joint: Option<&'t Track>) -> Option<(&'t Track, &'t [f64])> {
        let of_joint = joint.and_then(|t| Some((t, t.series(name)?)));
        let named = |t: &'t Track| {
            let (field, _) = t.fields.iter().find(|(field, _)| t.name_of(field) == name)?;
            Some((t, t.series(field)?))
        };
        of_joint.or_else(|| self.tracks.iter().find_map(named))
    }

    /// The columns on the clock of `base`.
    fn joined(
        &self,
        base: &Track,
        map: Option<&Map>,
        fail: &dyn Fn(String) -> Error,
        remarks: &mut Vec<String>,
    ) -> Result<Vec<(&'static Named, Vec<f64>)>, Error> {
        let named = map.map(Map::variables).unwrap_or_default();
        let used: Vec<(&str, &Track, &[f64])> = named
            .iter()
            .filter(|name| **name != "time")
            .filter_map(|name| self.find(name, Some(base)).map(|(track, values)| (*name, track, values)))
            .collect();
        // where every series that is used has begun and none has ended
        let (mut start, mut end) = base.range();
        for (_, track, _) in &used {
            (start, end) = (start.max(track.range().0), end.min(track.range().1));
        }
        let zero = base.range().0;
        let kept = base.stamps.partition_point(|s| *s < start)..base.stamps.partition_point(|s| *s <= end);
        let Some(stamps) = base.stamps.get(kept.clone()).filter(|stamps| stamps.len() > 1) else {
            let spans: Vec<String> = used
                .iter()
                .map(|(name, track, _)| (*name, track.range()))
                .chain([("the position", base.range())])
                .map(|(name, (a, b))| format!("{name} from {} to {} s", seconds(a, zero), seconds(b, zero)))
                .collect();
            return Err(fail(format!("topics that do not overlap in time: {}", spans.join(", "))));
        };
        let mut series: Vec<(String, Vec<f64>)> = Vec::new();
        series.push(("time".into(), stamps.iter().map(|s| seconds(*s, zero)).collect()));
        let mut told: Vec<&str> = Vec::new();
        for (name, track, values) in used {
            if track.stamps == base.stamps {
                series.push((name.into(), values[kept.clone()].to_vec()));
                continue;
            }
            let (values, lost) = track.at(values, stamps);
            if !told.contains(&track.topic.as_str()) {
                told.push(&track.topic);
                let gaps = if lost > 0 {
                    format!(", {lost} of them in its gaps, which are NaN")
                } else {
                    String::new()
                };
                remarks.push(format!(
                    "{}: interpolated linearly at the stamps of {}; they overlap in {} of its {} samples{gaps}",
                    track.topic,
                    base.topic,
                    stamps.len(),
                    base.stamps.len()
                ));
            }
            series.push((name.into(), values));
        }
        let lookup = |name: &str| series.iter().find(|(n, _)| n == name).map(|(_, values)| values.as_slice());
        let mut out = map.map_or(Ok(Vec::new()), |map| map.apply(lookup, &self.says()))?;
        let slide = out.iter().any(|(column, _)| column.geometry == Some(Geometry::Linear));
        let given: Vec<Slot> = out.iter().map(|(column, _)| column.slot).collect();
        let of_joint = |field: &str| base.series(field).map(|values| values[kept.clone()].to_vec());
        let default = [
            (Slot::Time, ["time_s", "time_s"], Some(stamps.iter().map(|s| seconds(*s, zero)).collect())),
            (Slot::Position, ["position_m", "position_rad"], of_joint("position")),
            (Slot::Velocity, ["velocity_m_s", "velocity_rad_s"], of_joint("velocity")),
            (Slot::Force, ["force_n", "torque_nm"], of_joint("effort")),
        ];
        for (slot, names, values) in default {
            if !given.contains(&slot)
                && let (Some(column), Some(values)) = (columns::find(names[usize::from(!slide)]), values)
            {
                out.push((column, values));
            }
        }
        if let Some(joint) = &base.joint {
            let has = |slot: Slot| out.iter().any(|(column, _)| column.slot == slot);
            if !has(Slot::Force) {
                return Err(fail(format!(
                    "joint `{joint}` has no effort; accepted is a map that gives the force, such as \
                     torque_nm=/ft:torque.z, or force_n=/ft:force.z for a joint that slides; {}",
                    self.has()
                )));
            }
            if map.is_none() {
                remarks.push(format!(
                    "joint {joint} is read as turning (rad, N·m); one that slides is read with --map force_n=effort"
                ));
            }
        }
        Ok(out)
    }
}

/// Seconds from zero.
fn seconds(stamp: i64, zero: i64) -> f64 {
    stamp.saturating_sub(zero) as f64 / 1e9
}

/// Whether messages of a type are read.
pub(crate) fn is_read(kind: &str) -> bool {
    matches!(kind, JOINT_STATE | WRENCH)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A message with a header, as CDR in the order of the machine's least byte first.
    struct Message(Vec<u8>);

    impl Message {
        fn new(stamp: i64) -> Self {
            let mut out = Self(vec![0, 1, 0, 0]);
            out.word((stamp / 1_000_000_000) as u32);
            out.word((stamp % 1_000_000_000) as u32);
            out.text("");
            out
        }

        fn align(&mut self, n: usize) {
            let body = (self.0.len() - 4).next_multiple_of(n);
            self.0.resize(4 + body, 0);
        }

        fn word(&mut self, word: u32) {
            self.align(4);
            self.0.extend(word.to_le_bytes());
        }

        fn text(&mut self, text: &str) {
            self.word(text.len() as u32 + 1);
            self.0.extend(text.bytes());
            self.0.push(0);
        }

        fn doubles(&mut self, values: &[f64]) {
            self.align(8);
            values.iter().for_each(|v| self.0.extend(v.to_le_bytes()));
        }
    }

    fn joint(stamp: i64, name: &str, numbers: [&[f64]; 3]) -> Vec<u8> {
        let mut out = Message::new(stamp);
        out.word(1);
        out.text(name);
        for list in numbers {
            out.word(list.len() as u32);
            if !list.is_empty() {
                out.doubles(list);
            }
        }
        out.0
    }

    fn force(stamp: i64, z: f64) -> Vec<u8> {
        let mut out = Message::new(stamp);
        out.doubles(&[0.0, 0.0, z, 0.0, 0.0, 0.0]);
        out.0
    }

    const MS: i64 = 1_000_000;
    const START: i64 = 1_700_000_000 * 1000 * MS;

    fn read(topics: Topics, map: Option<&str>) -> Result<Recording, String> {
        let map: Option<Map> = map.map(|text| text.parse().unwrap());
        topics.assemble("log", &Wanted { map: &|_| map.as_ref(), joint: None }).map_err(|e| e.to_string())
    }

    /// A joint every 10 ms from 0 to 1 s, without effort, and a force between, every 10 ms where `there` says so.
    fn log(there: impl Fn(i64) -> bool) -> Topics {
        let mut topics = Topics::default();
        for i in 0..=100 {
            let stamp = START + i * 10 * MS;
            topics
                .message("/joints", JOINT_STATE, stamp, &joint(stamp, "j", [&[i as f64], &[1.0], &[]]))
                .unwrap();
            let between = stamp + 4 * MS;
            if there(i) {
                topics.message("/ft", WRENCH, between, &force(between, (between - START) as f64)).unwrap();
            }
        }
        topics
    }

    #[test]
    fn nothing_is_continued_and_gaps_are_not_bridged() {
        // the sensor begins at 204 ms and pauses between 504 and 604 ms
        let recording =
            read(log(|i| i >= 20 && !(51..60).contains(&i)), Some("force_n=/ft:force.z")).unwrap();
        assert_eq!((recording.time[0], *recording.time.last().unwrap()), (0.21, 1.0));
        for (t, force) in recording.time.iter().zip(&recording.force) {
            if *t > 0.504 && *t < 0.604 {
                assert!(force.is_nan(), "{t}: {force}");
            } else {
                assert!((force - t * 1e9).abs() < 1.0, "{t}: {force}");
            }
        }
        assert!(
            recording.remarks[0].contains("80 of its 101 samples, 10 of them in its gaps"),
            "{:?}",
            recording.remarks
        );
    }

    #[test]
    fn a_joint_without_effort_needs_a_force() {
        let said = read(log(|_| true), None).unwrap_err();
        assert!(
            said.contains("joint `j` has no effort; accepted is a map") && said.contains("/ft:{force.x"),
            "{said}"
        );
    }

    #[test]
    fn topics_that_do_not_overlap_are_refused() {
        let mut topics = log(|_| false);
        for i in 0..3 {
            let stamp = START + 5000 * MS + i * 10 * MS;
            topics.message("/ft", WRENCH, stamp, &force(stamp, 1.0)).unwrap();
        }
        let said = read(topics, Some("force_n=/ft:force.z")).unwrap_err();
        assert!(said.contains("/ft:force.z from 5 to 5.02 s, the position from 0 to 1 s"), "{said}");
    }

    #[test]
    fn stamps_that_are_not_set_are_the_recorders() {
        let mut topics = Topics::default();
        // delivered in another order than recorded
        for i in [0, 2, 1] {
            let message = joint(0, "j", [&[i as f64], &[], &[2.0]]);
            topics.message("/joints", JOINT_STATE, START + i * 10 * MS, &message).unwrap();
        }
        let recording = read(topics, None).unwrap();
        assert_eq!((recording.time, recording.position), (vec![0.0, 0.01, 0.02], vec![0.0, 1.0, 2.0]));
        assert_eq!(recording.velocity, None);
        let remarks = recording.remarks.join("; ");
        assert!(remarks.contains("without stamp") && remarks.contains("sorted by their stamps"), "{remarks}");
    }

    #[test]
    fn one_joint_on_two_topics_is_asked_for_by_topic() {
        let mut topics = log(|_| false);
        topics.message("/commands", JOINT_STATE, START, &joint(START, "j", [&[0.0], &[], &[]])).unwrap();
        let said = read(topics, None).unwrap_err();
        assert!(said.contains("accepted is --joint with one of /joints:j, /commands:j"), "{said}");
    }
}
