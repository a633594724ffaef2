#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    hostile::run("mat5", data);
});
