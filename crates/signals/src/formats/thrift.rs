//! A walk through Thrift's compact protocol [parquet-format], in which Parquet writes its headers.
//!
//! The library that reads Parquet reserves what lists and pages are said to need before it reads them. This walk runs first: a
//! list longer than the bytes that are left, a page that unpacks to more than a file may, or one whose dictionary is not there, is
//! refused with its place.

/// Bytes of a header.
pub(crate) struct Walk<'a> {
    bytes: &'a [u8],
    at: usize,
}

/// Structs and lists within each other.
const DEEPEST: usize = 32;

/// A page, by its header.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Page {
    /// Bytes of the header itself.
    pub header: usize,
    /// Bytes.
    pub unpacked: usize,
    /// Bytes.
    pub packed: usize,
    /// It is the dictionary of those that follow.
    pub is_dictionary: bool,
    /// Its values are places in a dictionary.
    pub uses_dictionary: bool,
}

/// What a walk sees: the field that its struct is in, if it is not the outermost, its own number, and its value.
type See<'a> = &'a mut dyn FnMut(Option<i64>, i64, i64);

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
        self.structure(0, None, &mut |_, _, _| ()).is_some()
    }

    /// The header of a page; None where it does not fit its bytes.
    pub(crate) fn page(&mut self) -> Option<Page> {
        let mut page = Page::default();
        let mut negative = false;
        self.structure(0, None, &mut |within, field, value| {
            let mut size = || {
                let size = usize::try_from(value);
                negative |= size.is_err();
                size.unwrap_or(0)
            };
            match (within, field) {
                (None, 1) => page.is_dictionary = value == 2,
                (None, 2) => page.unpacked = size(),
                (None, 3) => page.packed = size(),
                // encoding of either version: PLAIN_DICTIONARY, RLE_DICTIONARY
                (Some(5), 2) | (Some(8), 4) => page.uses_dictionary = matches!(value, 2 | 8),
                _ => {}
            }
        })?;
        page.header = self.at;
        (!negative).then_some(page)
    }

    /// Walks over a struct; `see` gets the whole numbers among its own fields, and of the structs right within the outermost.
    fn structure(&mut self, depth: usize, within: Option<i64>, see: See<'_>) -> Option<()> {
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
                    see(within, field, value);
                }
                12 if depth == 0 => self.structure(1, Some(field), see)?,
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
            12 => self.structure(depth + 1, None, &mut |_, _, _| ()),
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
        let page = Page { header: 12, unpacked: 100, packed: 60, ..Page::default() };
        assert_eq!(Walk::new(&header).page(), Some(page));
        for cut in 0..header.len() {
            assert_eq!(Walk::new(&header[..cut]).page(), None);
        }
    }

    #[test]
    fn a_page_header_tells_of_its_dictionary() {
        // 1: type 2, 2: unpacked 8, 3: packed 8, 7: struct { 1: 1 value, 2: encoding 0 }, stop
        let dictionary = [0x15, 0x04, 0x15, 0x10, 0x15, 0x10, 0x4c, 0x15, 0x02, 0x15, 0x00, 0x00, 0x00];
        let page = Walk::new(&dictionary).page().expect("a page");
        assert!(page.is_dictionary && !page.uses_dictionary);
        // 5: struct { 1: 10 values, 2: encoding 8 }; 8: struct { 1: 10 values, 4: encoding 2 }
        for nested in
            [&[0x2c, 0x15, 0x14, 0x15, 0x10, 0x00, 0x00][..], &[0x5c, 0x15, 0x14, 0x35, 0x04, 0x00, 0x00][..]]
        {
            let header = [&[0x15, 0x00, 0x15, 0x10, 0x15, 0x10][..], nested].concat();
            let page = Walk::new(&header).page().expect("a page");
            assert!(page.uses_dictionary && !page.is_dictionary, "{page:?}");
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
