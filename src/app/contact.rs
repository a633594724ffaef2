//! Lines of the board that need no register of their own: contacts that report trouble, and the lamp.

use embedded_hal::digital::{InputPin, StatefulOutputPin};

/// Last periods that are all open in trouble: three. Shorter is bounce, or a spark.
const PERIODS: u8 = 0b111;

/// A contact that is closed to ground while all is well, with a pull-up: open, pressed, or a broken wire is trouble.
#[derive(Debug)]
pub struct Contact<P> {
    pin: P,
    /// The last periods, the newest in bit 0: open.
    open: u8,
}

impl<P: InputPin> Contact<P> {
    /// A contact at a pin with a pull-up.
    pub const fn new(pin: P) -> Self {
        Self { pin, open: 0 }
    }

    /// Reads the contact; once a control period. True from the third open period in a row. A pin that cannot be read is
    /// open. Without `judged` it is not read, and counts from the start.
    #[inline]
    pub fn is_open(&mut self, judged: bool) -> bool {
        let open = judged && self.pin.is_high().unwrap_or(true);
        self.open = (self.open << 1 | u8::from(open)) & PERIODS;
        self.open == PERIODS
    }
}

/// The lamp that shows that the loop is healthy.
#[derive(Debug)]
pub struct Lamp<P> {
    pin: P,
    looks: u32,
}

impl<P: StatefulOutputPin> Lamp<P> {
    /// A lamp at a pin.
    pub const fn new(pin: P) -> Self {
        Self { pin, looks: 0 }
    }

    /// One look at a healthy loop; each `period` of them the lamp changes.
    pub fn look(&mut self, period: u32) {
        self.looks = self.looks.wrapping_add(1);
        if self.looks.is_multiple_of(period) {
            // a lamp that cannot be switched stops nothing
            let _ = self.pin.toggle();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use embedded_hal_mock::eh1::MockError;
    use embedded_hal_mock::eh1::digital::{Mock, State, Transaction};
    use std::io::ErrorKind;

    /// What a contact says of these levels.
    fn says(levels: &[Transaction]) -> Vec<bool> {
        let mut pin = Mock::new(levels);
        let mut contact = Contact::new(pin.clone());
        let said = levels.iter().map(|_| contact.is_open(true)).collect();
        pin.done();
        said
    }

    #[test]
    fn three_open_periods_are_trouble_and_bounce_is_none() {
        let (open, closed) = (Transaction::get(State::High), Transaction::get(State::Low));
        let levels = [&open, &open, &closed, &open, &open, &open, &open, &closed].map(Clone::clone);
        assert_eq!(says(&levels), [false, false, false, false, false, true, true, false]);
    }

    #[test]
    fn a_pin_that_cannot_be_read_is_open() {
        let broken = Transaction::get(State::Low).with_error(MockError::Io(ErrorKind::Other));
        assert_eq!(says(&[broken.clone(), broken.clone(), broken]), [false, false, true]);
    }

    #[test]
    fn a_contact_counts_from_the_start_once_it_is_judged() {
        let open = Transaction::get(State::High);
        let mut pin = Mock::new(&[open.clone(), open.clone(), open.clone(), open]);
        let mut contact = Contact::new(pin.clone());
        let said = [true, false, true, true, true].map(|judged| contact.is_open(judged));
        assert_eq!(said, [false, false, false, false, true]);
        pin.done();
    }

    #[test]
    fn the_lamp_changes_with_every_second_look_of_two() {
        let mut pin = Mock::new(&[Transaction::toggle(), Transaction::toggle()]);
        let mut lamp = Lamp::new(pin.clone());
        (0..5).for_each(|_| lamp.look(2));
        pin.done();
    }
}
