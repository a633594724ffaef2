//! A GPIO port: modes, alternate functions, outputs by ODR, BSRR and BRR, inputs from the world.

const MODER: u32 = 0x00;
const OSPEEDR: u32 = 0x08;
const PUPDR: u32 = 0x0c;
const IDR: u32 = 0x10;
const ODR: u32 = 0x14;
const BSRR: u32 = 0x18;
const AFRL: u32 = 0x20;
const AFRH: u32 = 0x24;
const BRR: u32 = 0x28;

#[derive(Debug)]
pub(crate) struct Gpio {
    moder: u32,
    pupdr: u32,
    odr: u32,
    afr: [u32; 2],
    other: [u32; 16],
    /// (mask of driven inputs, their levels)
    driven: (u32, u32),
}

impl Gpio {
    /// Port 0 is A. Analog, but for the pins of the debugger on A and B.
    pub fn new(port: usize) -> Self {
        let (moder, ospeedr, pupdr) = match port {
            0 => (0xabff_ffff, 0x0c00_0000, 0x6400_0000),
            1 => (0xffff_febf, 0x0000_00c0, 0x0000_0100),
            _ => (u32::MAX, 0, 0),
        };
        let mut other = [0; 16];
        other[OSPEEDR as usize / 4] = ospeedr;
        Self { moder, pupdr, odr: 0, afr: [0; 2], other, driven: (0, 0) }
    }

    /// Drives an input pin from outside.
    pub fn drive(&mut self, pin: u32, high: bool) {
        self.driven.0 |= 1 << pin;
        self.driven.1 = (self.driven.1 & !(1 << pin)) | u32::from(high) << pin;
    }

    fn mode(&self, pin: u32) -> u32 {
        self.moder >> (2 * pin) & 3
    }

    /// Whether the pin is an output and high.
    pub fn output_high(&self, pin: u32) -> bool {
        self.mode(pin) == 1 && self.odr >> pin & 1 != 0
    }

    /// Whether the pin has this alternate function.
    pub fn alternate(&self, pin: u32, function: u32) -> bool {
        let register = self.afr[usize::from(pin >= 8)];
        self.mode(pin) == 2 && register >> (4 * (pin % 8)) & 0xf == function
    }

    /// Whether the pin is analog.
    pub fn analog(&self, pin: u32) -> bool {
        self.mode(pin) == 3
    }

    pub fn read(&self, offset: u32) -> u32 {
        match offset {
            MODER => self.moder,
            PUPDR => self.pupdr,
            IDR => self.input(),
            ODR => self.odr,
            BSRR | BRR => 0,
            AFRL => self.afr[0],
            AFRH => self.afr[1],
            _ => self.other.get(offset as usize / 4).copied().unwrap_or(0),
        }
    }

    fn input(&self) -> u32 {
        let mut pulled = 0;
        let mut outputs = 0;
        for pin in 0..16 {
            pulled |= u32::from(self.pupdr >> (2 * pin) & 3 == 1) << pin;
            outputs |= u32::from(self.mode(pin) == 1) << pin;
        }
        let outside = (pulled & !self.driven.0) | (self.driven.1 & self.driven.0);
        (self.odr & outputs) | (outside & !outputs)
    }

    pub fn write(&mut self, offset: u32, value: u32) {
        match offset {
            MODER => self.moder = value,
            PUPDR => self.pupdr = value,
            IDR => {}
            ODR => self.odr = value & 0xffff,
            // set wins over reset
            BSRR => self.odr = (self.odr & !(value >> 16)) | value & 0xffff,
            BRR => self.odr &= !value,
            AFRL => self.afr[0] = value,
            AFRH => self.afr[1] = value,
            _ => {
                if let Some(register) = self.other.get_mut(offset as usize / 4) {
                    *register = value;
                }
            }
        }
    }
}
