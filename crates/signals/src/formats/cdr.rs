//! The two ROS 2 messages that hold a motion, from CDR [cdr, ch. 10]: `sensor_msgs/JointState` and
//! `geometry_msgs/WrenchStamped`.

/// A joint of a message: name, position, velocity, effort; NaN where the message has none.
pub(crate) type JointSample<'a> = (&'a str, [f64; 3]);

/// Names of the three numbers of a joint.
pub(crate) const JOINT_FIELDS: [&str; 3] = ["position", "velocity", "effort"];

/// Names of the six numbers of a wrench.
pub(crate) const WRENCH_FIELDS: [&str; 6] =
    ["force.x", "force.y", "force.z", "torque.x", "torque.y", "torque.z"];

/// Bytes of a message.
struct Reader<'a> {
    bytes: &'a [u8],
    /// In the body: alignment counts from its beginning.
    at: usize,
    big: bool,
}

impl<'a> Reader<'a> {
    /// Behind the encapsulation header.
    fn new(message: &'a [u8]) -> Result<Self, String> {
        let (head, bytes) = message.split_at_checked(4).ok_or("a message without CDR header")?;
        match head[..2] {
            [0, big @ (0 | 1)] => Ok(Self { bytes, at: 0, big: big == 0 }),
            _ => Err(format!(
                "a message of encapsulation {:02x}{:02x}; accepted is plain CDR",
                head[0], head[1]
            )),
        }
    }

    fn take(&mut self, n: usize, align: usize) -> Result<&'a [u8], String> {
        let start = self.at.next_multiple_of(align);
        let taken = start.checked_add(n).and_then(|end| self.bytes.get(start..end));
        self.at = start + n;
        taken
            .ok_or_else(|| format!("a message that ends at byte {} of {}", self.bytes.len() + 4, self.at + 4))
    }

    fn word(&mut self) -> Result<u32, String> {
        let b = self.take(4, 4)?;
        let b = [b[0], b[1], b[2], b[3]];
        Ok(if self.big { u32::from_be_bytes(b) } else { u32::from_le_bytes(b) })
    }

    fn double(&mut self) -> Result<f64, String> {
        let b = self.take(8, 8)?;
        let b = [b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]];
        Ok(if self.big { f64::from_be_bytes(b) } else { f64::from_le_bytes(b) })
    }

    fn text(&mut self) -> Result<&'a str, String> {
        let length = self.word()? as usize;
        let text = self.take(length, 1)?;
        let text = text.strip_suffix(b"\0").unwrap_or(text);
        std::str::from_utf8(text).map_err(|_| "a name that is not UTF-8".into())
    }

    /// Length of a list whose elements take at least `least` bytes.
    fn length(&mut self, least: usize) -> Result<usize, String> {
        let n = self.word()? as usize;
        let most = self.bytes.len().saturating_sub(self.at) / least;
        if n <= most { Ok(n) } else { Err(format!("a list of {n} elements where {most} have room")) }
    }

    /// Stamp of a header, ns since 1970; zero where the sender gave none.
    fn header(&mut self) -> Result<i64, String> {
        let (seconds, nanoseconds) = (self.word()?.cast_signed(), self.word()?);
        self.text()?;
        Ok(i64::from(seconds) * 1_000_000_000 + i64::from(nanoseconds))
    }
}

/// Stamp (ns) and joints of a `sensor_msgs/JointState`.
pub(crate) fn joint_state(message: &[u8]) -> Result<(i64, Vec<JointSample<'_>>), String> {
    let mut reader = Reader::new(message)?;
    let stamp = reader.header()?;
    let n = reader.length(4)?;
    let mut joints = Vec::with_capacity(n);
    for _ in 0..n {
        joints.push((reader.text()?, [f64::NAN; 3]));
    }
    for (k, field) in JOINT_FIELDS.iter().enumerate() {
        let given = reader.length(8)?;
        if given != 0 && given != n {
            return Err(format!("a JointState of {n} names and {given} {field} values"));
        }
        for joint in joints.iter_mut().take(given) {
            joint.1[k] = reader.double()?;
        }
    }
    Ok((stamp, joints))
}

/// Stamp (ns), force and torque of a `geometry_msgs/WrenchStamped`.
pub(crate) fn wrench(message: &[u8]) -> Result<(i64, [f64; 6]), String> {
    let mut reader = Reader::new(message)?;
    let stamp = reader.header()?;
    let mut out = [0.0; 6];
    for value in &mut out {
        *value = reader.double()?;
    }
    Ok((stamp, out))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_beyond_the_message_are_refused() {
        // header of stamp 1 s, frame "", then a list of 2^32 - 1 names
        let message = [0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 255, 255, 255, 255];
        assert!(
            joint_state(&message).unwrap_err().contains("a list of 4294967295 elements where 0 have room")
        );
        assert!(wrench(&message).unwrap_err().contains("ends at byte 24"));
        assert!(wrench(&[0, 7, 0, 0]).unwrap_err().contains("encapsulation 0007"));
        assert!(wrench(&[0]).unwrap_err().contains("without CDR header"));
    }
}
