//! Runs an ELF for some milliseconds and prints observations.
fn main() {
    let mut args = std::env::args().skip(1);
    let elf = std::fs::read(args.next().expect("usage: probe ELF [MS] [TYPED]")).expect("readable");
    let ms: f64 = args.next().map_or(1000.0, |s| s.parse().expect("ms"));
    let image = emulator::Image::parse(&elf).expect("an image");
    let law = friction::Custom(|_: &friction::Motion<f64>| 0.0);
    let mut machine =
        emulator::Machine::boot(&image, plant::RigConfig::free_handle(), law, 1).expect("a rig");
    machine.set_hand(|t: f64, _: f64, _: f64| if t > 0.3 { 1.0 } else { 0.0 });
    machine.run_for(100.0);
    machine.reset_statistics();
    let wall = std::time::Instant::now();
    for typed in args {
        machine.serial_write(format!("{typed}\n").as_bytes());
        machine.run_for(20.0);
        print!("{}", String::from_utf8_lossy(&machine.serial_read()));
    }
    machine.run_for(ms);
    let wall = wall.elapsed().as_secs_f64();
    println!("{:.0} virtual ms, {wall:.2} s wall", machine.milliseconds());
    println!("{:#?}", machine.statistics());
    println!(
        "first step {:?} ms, resets {:?}, {}",
        machine.first_step_ms(),
        machine.resets(),
        machine.whereabouts()
    );
    println!(
        "force {} N, amplifier {}, truth {:?}",
        machine.force(),
        machine.amplifier_on(),
        machine.truth()
    );
    println!("violations {:?}, stack {}", machine.violations(), machine.stack_bytes());
}
