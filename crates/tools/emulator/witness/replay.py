"""Repeats a run of the firmware on QEMU's Cortex-M4 (unicorn), and compares everything that it does.

    replay.py FOLDER              flash.bin, system.bin and run.bin of `emulator record --out FOLDER`
    replay.py FOLDER --spoil      the same with one bit of one force changed: must be different

Reads of peripherals are answered from the recording, and exceptions begin and end after the recorded number of instructions. The core
is QEMU's: every instruction, every flag and every floating-point operation. Each access must have the recorded address and size,
and each write the recorded value. Exceptions are entered and left here, by hand, because unicorn has no interrupt controller; the
registers of the core's own peripherals (0xe0000000) are memory that keeps what is written.
"""

import struct
import sys
import time
from array import array

from unicorn import UC_ARCH_ARM, UC_HOOK_INTR, UC_HOOK_MEM_INVALID, UC_MODE_MCLASS, UC_MODE_THUMB, Uc, UcError
from unicorn.arm_const import *

READ, WRITE, ENTER, RETURN, CHAIN, END, SLEEP = range(7)
NAMES = ["read", "write", "enter", "return", "chain", "end", "sleep"]
FLASH, RAM, CCM, SYSTEM, CORE = 0x0800_0000, 0x2000_0000, 0x1000_0000, 0x1FFF_0000, 0xE000_0000
BANK_2, BANK_BYTES = 0x0804_0000, 0x4_0000
DAC_FORCE = 0x5000_0808
# content of the RAM before power-on, as in the emulator
PAINT = 0xC5
# a `clrex`, in unused system memory
SCRATCH = SYSTEM + 0x100

CORE_REGISTERS = [
    UC_ARM_REG_R0, UC_ARM_REG_R1, UC_ARM_REG_R2, UC_ARM_REG_R3, UC_ARM_REG_R12, UC_ARM_REG_LR, UC_ARM_REG_PC, UC_ARM_REG_XPSR,
]
FLOATS = [UC_ARM_REG_S0 + k for k in range(16)]
# what QEMU calls the branch to an EXC_RETURN
EXCEPTION_EXIT = 8
# within an IT block: the next instruction is one whose condition holds
CARRIED_OUT = 1
# in the place of an instruction that waits for an event: the recording has the events
NOP = bytes.fromhex("00bf")


class Different(Exception):
    """The core did something else than in the recording."""


class Replay:
    def __init__(self, flash, system, run):
        self.records = array("I", run)
        self.next = 0
        self.force_writes = 0
        self.instructions = 0
        self.why = None
        self.active = []
        # instructions that the code is ahead of the recording, and those that wait for the end of exceptions
        self.ahead = 0
        self.waiting = []
        self.late = 0
        self.core = Uc(UC_ARCH_ARM, UC_MODE_THUMB | UC_MODE_MCLASS)
        self.core.ctl_set_cpu_model(UC_CPU_ARM_CORTEX_M4)
        core = self.core
        core.mem_map(FLASH, BANK_BYTES)
        core.mem_write(FLASH, flash)
        while self.records[self.next] == SLEEP:
            core.mem_write(self.records[self.next + 1], NOP)
            self.next += 4
        core.mem_map(RAM, 96 * 1024)
        core.mem_write(RAM, bytes([PAINT]) * (96 * 1024))
        core.mem_map(CCM, 32 * 1024)
        core.mem_map(SYSTEM, len(system))
        core.mem_write(SYSTEM, system)
        core.mem_write(SCRATCH, bytes.fromhex("bff32f8f00bf00bf"))
        core.mem_map(CORE, 0x10_0000)
        for base, size in [(0x4000_0000, 0x1000_0000), (0x5000_0000, 0x1000_0000), (BANK_2, BANK_BYTES)]:
            core.mmio_map(base, size, self.read, base, self.write, base)
        core.hook_add(UC_HOOK_MEM_INVALID, self.invalid)
        core.hook_add(UC_HOOK_INTR, self.trap)
        stack, reset = struct.unpack_from("<2I", flash)
        core.reg_write(UC_ARM_REG_MSP, stack)
        core.reg_write(UC_ARM_REG_LR, 0xFFFF_FFFF)
        core.reg_write(UC_ARM_REG_FPEXC, 0x4000_0000)
        self.flash = flash
        self.pc = reset & ~1

    def spoil(self):
        """Another last bit in the middle one of the forces that are not zero."""
        records = self.records
        writes = [at for at in range(0, len(records), 4) if records[at : at + 2] == array("I", [WRITE, DAC_FORCE])]
        forces = [at for at in writes if records[at + 2] != 2048]
        records[forces[len(forces) // 2] + 2] ^= 1

    # what the core does

    def fail(self, why):
        """Notes the first difference; an exception does not pass through unicorn."""
        if self.why is None:
            pc = self.core.reg_read(UC_ARM_REG_PC)
            self.why = f"{why}, at pc {pc:#010x}, record {self.next // 4}, after {self.instructions} instructions"
        self.core.emu_stop()

    def expect(self, kind, address, size):
        at = self.next
        records = self.records
        if records[at] != kind or records[at + 1] != address or records[at + 3] != size:
            then = f"{NAMES[records[at]]} {records[at + 1]:#010x} of {records[at + 3]} bytes"
            self.fail(f"{NAMES[kind]} {address:#010x} of {size} bytes, recorded is {then}")
            return None
        self.next = at + 4
        return records[at + 2]

    def read(self, _core, offset, size, base):
        return self.expect(READ, base + offset, size) or 0

    def write(self, _core, offset, size, value, base):
        address = base + offset
        recorded = self.expect(WRITE, address, size)
        if recorded is None:
            return
        self.force_writes += address == DAC_FORCE
        value &= 0xFFFF_FFFF >> (32 - 8 * size)
        if recorded != value:
            self.fail(f"{value:#x} written to {address:#010x}, recorded is {recorded:#x}")

    def invalid(self, _core, _access, address, size, value, _data):
        self.fail(f"access to {address:#010x} of {size} bytes, value {value:#x}")
        return False

    def trap(self, core, number, _data):
        if number == EXCEPTION_EXIT:
            core.emu_stop()
            return
        self.fail(f"exception {number} of the core itself")

    # what happens to it

    def run(self, count):
        """This many instructions, less those that it is ahead."""
        self.ahead, count = max(self.ahead - count, 0), max(count - self.ahead, 0)
        if count:
            try:
                self.core.emu_start(self.pc | 1, 0xFFFF_FFFE, count=count)
            except UcError as error:
                self.fail(str(error))
            self.instructions += count
            self.pc = self.core.reg_read(UC_ARM_REG_PC) & ~1
        if self.why:
            raise Different(self.why)

    def vector(self, exception):
        return struct.unpack_from("<I", self.flash, 4 * exception)[0] & ~1

    def carried_out(self, place, is_first):
        """Instructions of an IT block from `place` up to here that were carried out [armv7-m, ch. A7.3]; `is_first`: the one there was."""
        half = lambda at: int.from_bytes(self.core.mem_read(at, 2), "little")
        length = lambda at: 4 if half(at) >> 11 >= 0b11101 else 2
        for start in range(place - 2, place - 16, -2):
            it = half(start)
            if it >> 8 != 0xBF or it & 15 == 0:
                continue
            block, at = {}, start + 2
            for k in range(4 - (it & -it).bit_length() + 1):
                block[at] = (it >> 4 if k == 0 else it >> (4 - k)) & 1
                at += length(at)
            if place in block:
                past = [block[at] for at in block if place <= at < self.pc]
                return sum((condition == block[place]) == is_first for condition in past)
        self.fail(f"{place:#010x} is in no IT block")
        return 0

    def enter(self, exception, place, returns_to):
        """[armv7-m, ch. B1.5.6]"""
        recorded = returns_to & ~1
        if self.ahead == 0 and self.pc != recorded:
            # unicorn stops within an IT block only after the next instruction, and one that is not carried out does not count
            if not (place and 0 < self.pc - recorded <= 16):
                self.fail(f"exception {exception} taken at {self.pc:#010x}, recorded is {recorded:#010x}")
            self.ahead = self.carried_out(recorded, place == CARRIED_OUT)
            self.late += self.ahead
        self.waiting.append(self.ahead)
        self.ahead = 0
        core = self.core
        r0, r1, r2, r3, r12, lr, _, xpsr = (core.reg_read(register) for register in CORE_REGISTERS)
        sp = core.reg_read(UC_ARM_REG_SP)
        floats = core.reg_read(UC_ARM_REG_CONTROL) >> 2 & 1
        if floats != returns_to & 1:
            self.fail(f"FPCA is {floats}, recorded is {returns_to & 1}")
        exc_return = 0xFFFF_FFE1 | (0x10 * (1 - floats)) | (0 if self.active else 8)
        frame = sp - (0x68 if floats else 0x20)
        padded = frame >> 2 & 1
        frame -= 4 * padded
        xpsr = xpsr & ~0x3FF | padded << 9 | (self.active[-1] if self.active else 0)
        core.mem_write(frame, struct.pack("<8I", r0, r1, r2, r3, r12, lr, self.pc, xpsr))
        if floats:
            words = [core.reg_read(register) for register in FLOATS] + [core.reg_read(UC_ARM_REG_FPSCR), 0]
            core.mem_write(frame + 0x20, struct.pack("<18I", *words))
        core.reg_write(UC_ARM_REG_SP, frame)
        self.active.append(exception)
        self.begin(exception, exc_return)

    def begin(self, exception, exc_return):
        core = self.core
        core.reg_write(UC_ARM_REG_LR, exc_return)
        core.reg_write(UC_ARM_REG_XPSR, 0x0100_0000)
        core.reg_write(UC_ARM_REG_CONTROL, core.reg_read(UC_ARM_REG_CONTROL) & ~4)
        core.reg_write(UC_ARM_REG_FPSCR, 0)
        self.pc = self.vector(exception)

    def leave(self):
        """[armv7-m, ch. B1.5.8]"""
        core = self.core
        exc_return = self.pc | 1
        self.active.pop()
        self.ahead = self.waiting.pop()
        if exc_return >> 8 != 0xFF_FFFF:
            self.fail(f"{exc_return:#x} is no EXC_RETURN")
            return
        sp = core.reg_read(UC_ARM_REG_SP)
        *registers, pc, xpsr = struct.unpack("<8I", core.mem_read(sp, 0x20))
        floats = exc_return & 0x10 == 0
        if floats:
            words = struct.unpack("<17I", core.mem_read(sp + 0x20, 0x44))
            for register, word in zip(FLOATS, words):
                core.reg_write(register, word)
            core.reg_write(UC_ARM_REG_FPSCR, words[16])
        control = core.reg_read(UC_ARM_REG_CONTROL)
        core.reg_write(UC_ARM_REG_CONTROL, control & ~4 | 4 * floats)
        for register, word in zip(CORE_REGISTERS, registers):
            core.reg_write(register, word)
        core.reg_write(UC_ARM_REG_SP, sp + (0x68 if floats else 0x20) + 4 * (xpsr >> 9 & 1))
        # the local monitor
        core.emu_start(SCRATCH | 1, 0xFFFF_FFFE, count=1)
        core.reg_write(UC_ARM_REG_XPSR, xpsr & ~0x3FF)
        self.pc = pc & ~1

    def all(self):
        records = self.records
        turns = (at for at in range(self.next, len(records), 4) if records[at] >= ENTER)
        for at in turns:
            kind, exception, count, returns_to = records[at : at + 4]
            self.run(count)
            if self.next != at:
                missing = records[self.next : self.next + 4]
                self.fail(f"{NAMES[missing[0]]} {missing[1]:#010x} did not happen")
            self.next = at + 4
            if kind == ENTER:
                self.enter(exception & 0xFFFF, exception >> 16, returns_to)
            elif kind == RETURN:
                self.leave()
            elif kind == CHAIN:
                # with the EXC_RETURN of the one that ends
                self.active[-1] = exception
                self.begin(exception, self.pc | 1)
            if self.why:
                raise Different(self.why)


def main():
    folder = sys.argv[1]
    def content(name):
        with open(f"{folder}/{name}.bin", "rb") as file:
            return file.read()

    replay = Replay(content("flash"), content("system"), content("run"))
    if "--spoil" in sys.argv:
        replay.spoil()
    began = time.time()
    try:
        replay.all()
    except Different as why:
        sys.exit(f"different: {why}")
    kinds = replay.records[0::4]
    print(
        f"{replay.instructions} instructions, {kinds.count(ENTER) + kinds.count(CHAIN)} exceptions ({replay.late} an instruction"
        f" late), {kinds.count(READ)} reads, {kinds.count(WRITE)} writes and {replay.force_writes} forces the same"
        f" on QEMU's Cortex-M4, in {time.time() - began:.0f} s"
    )


main()
