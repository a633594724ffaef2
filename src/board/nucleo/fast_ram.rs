//! Copies the control path and the vector table into CCM SRAM, from which the core runs without wait states.
//!
//! Flash at 170 MHz takes four wait states [rm0440, "Read access latency"]; the caches hide them only for code that ran
//! shortly before, which a control step 1 ms ago did not. `memory.x` lists the functions.

// In assembly: this runs before memory is initialised, and the functions of the compiler that copy memory are among
// what is copied.
core::arch::global_asm!(
    ".section .text.__pre_init, \"ax\", %progbits",
    ".global __pre_init",
    ".type __pre_init, %function",
    ".thumb_func",
    "__pre_init:",
    "movw r0, :lower16:__scontrol",
    "movt r0, :upper16:__scontrol",
    "movw r1, :lower16:__sicontrol",
    "movt r1, :upper16:__sicontrol",
    "movw r2, :lower16:__econtrol",
    "movt r2, :upper16:__econtrol",
    "1: cmp r0, r2",
    "bhs 2f",
    "ldm r1!, {{r3, r12}}",
    "stm r0!, {{r3, r12}}",
    "b 1b",
    "2:",
    "movw r0, :lower16:__control_vectors",
    "movt r0, :upper16:__control_vectors",
    "movw r1, :lower16:__vector_table",
    "movt r1, :upper16:__vector_table",
    "add r2, r0, #512",
    "3: ldm r1!, {{r3, r12}}",
    "stm r0!, {{r3, r12}}",
    "cmp r0, r2",
    "blo 3b",
    // SCB_VTOR
    "sub r0, r0, #512",
    "movw r1, #0xed08",
    "movt r1, #0xe000",
    "str r0, [r1]",
    "dsb",
    "isb",
    "bx lr",
    ".size __pre_init, . - __pre_init",
);
