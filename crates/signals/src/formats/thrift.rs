//! A walk through Thrift's compact protocol [parquet-format], in which Parquet writes its headers.
//!
//! The library that reads Parquet reserves what lists and pages are said to need before it reads them. This walk runs first: a
//! list longer than the bytes that are left, or a page that unpacks to more than a file may, is refused with its place.

/// Bytes of a header.
pub(crate) struct Walk<'a> {
    bytes: &'a [u8],
    at: usize,
}

/// Structs and lists within each other.
const DEEPEST: usize = 32;

/// Sizes of a page, bytes.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Page {
    /// Of the header itself.
    pub header: usize,
    pub unpacked: usize,
    pub packed: usize,
}

impl<'a> Walk<'a> {
    pub(crate) const fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    fn byte(&mut self) -> Option<u8> {
        let byte = *self.bytes.get(self.at)?;
        self.at += 1;
        Some(byte)
    }

    fn varint(&mut self) -> Option<u64> {
        let mut out = 0u64;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            out |= u64::from(byte & 0x7f) << shift;
            if byte & 0x80 == 0 {
                return Some(out);
            }
        }
        None
    }

    fn skip(&mut self, n: u64) -> Option<()> {
        self.at = self.at.checked_add(usize::try_from(n).ok()?).filter(|at| *at <= self.bytes.len())?;
        Some(())
    }

    /// Walks over a struct; false where it does not fit its bytes.
    pub(crate) fn fits(&mut self) -> bool {
        self.structure(0, &mut |_, _| ()).is_some()
    }

    /// The header of a page; None where it does not fit its bytes.
    pub(crate) fn page(&mut self) -> Option<Page> {
        let mut page = Page::default();
        let mut negative = false;
        self.structure(0, &mut |field, value| {
            let size = usize::try_from(value);
            negative |= matches!(field, 2 | 3) && size.is_err();
            match field {
                2 => page.unpacked = size.unwrap_or(0),
                3 => page.packed = size.unwrap_or(0),
                _ => {}
            }
        })?;
        page.header = self.at;
        (!negative).then_some(page)
    }

    /// Walks over a struct; `see` gets the whole numbers among its own fields.
    fn structure(&mut self, depth: usize, see: &mut dyn FnMut(i64, i64)) -> Option<()> {
        if depth > DEEPEST {
            return None;
        }
        let mut field = 0i64;
        loop {
            let head = self.byte()?;
            if head == 0 {
                return Some(());
            }
            let step = i64::from(head >> 4);
            field = if step == 0 { self.zigzag()? } else { field.checked_add(step)? };
            match head & 0x0f {
                // the value is the type
                1 | 2 => {}
                4..=6 => {
                    let value = self.zigzag()?;
                    see(field, value);
                }
                kind => self.value(kind, depth)?,
            }
        }
    }

    fn zigzag(&mut self) -> Option<i64> {
        let raw = self.varint()?;
        Some((raw >> 1) as i64 ^ -((raw & 1) as i64))
    }

    fn value(&mut self, kind: u8, depth: usize) -> Option<()> {
        match kind {
            1..=3 => self.byte().map(drop),
            4..=6 => self.varint().map(drop),
            7 => self.skip(8),
            8 => {
                let length = self.varint()?;
                self.skip(length)
            }
            9 | 10 => {
                let head = self.byte()?;
                let length = if head >> 4 == 15 { self.varint()? } else { u64::from(head >> 4) };
                // an element takes at least a byte
                if length > (self.bytes.len() - self.at) as u64 {
                    return None;
                }
                (0..length).try_for_each(|_| self.value(head & 0x0f, depth + 1))
            }
            12 => self.structure(depth + 1, &mut |_, _| ()),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_header_is_read() {
        // 1: type 0, 2: unpacked 100, 3: packed 60, 5: struct { 1: 10 values }, stop
        let header = [0x15, 0x00, 0x15, 0xc8, 0x01, 0x15, 0x78, 0x2c, 0x15, 0x14, 0x00, 0x00];
        assert_eq!(Walk::new(&header).page(), Some(Page { header: 12, unpacked: 100, packed: 60 }));
        for cut in 0..header.len() {
            assert_eq!(Walk::new(&header[..cut]).page(), None);
        }
    }

    #[test]
    fn a_list_longer_than_its_bytes_does_not_fit() {
        assert!(Walk::new(&[0x19, 0x28, 0x01, b'a', 0x00, 0x00]).fits());
        assert!(!Walk::new(&[0x19, 0xf8, 0xff, 0xff, 0xff, 0x7f, 0x01, b'a', 0x00]).fits());
        // lists in lists, without end
        assert!(!Walk::new(&[0x19; 4096]).fits());
    }
}
