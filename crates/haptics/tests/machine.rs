//! The state machine and its safety: hand-made and random cases.

mod rig;

use haptics::{
    Channel, Control, Denied, Device, Excitation, FaultKind, Inputs, LawKind, Mode, ModeId, Procedure,
    RendererKind, Request, Settings, Wave,
};
use proptest::prelude::*;
use rig::{Rig, control, render};

/// Largest force of the default device, and while it is unreferenced, N.
const FORCE_MAX: f32 = 9.48;
const UNREFERENCED: f32 = 0.3 * FORCE_MAX;

fn idle() -> (Control, Rig) {
    let mut control = control(&Settings::rubber());
    let mut rig = Rig::of(&Device::default());
    for _ in 0..3 {
        control.step(None, &rig.inputs());
        rig.push(0.0);
    }
    (control, rig)
}

/// Rendering, then one disturbed sample; the fault it raises.
fn fault_of(disturb: impl Fn(u32, &mut Inputs)) -> Option<FaultKind> {
    let (mut control, mut rig) = idle();
    render(&mut control, &mut rig);
    let mut first = None;
    for k in 0..20 {
        rig.push(0.3);
        let mut inputs = rig.inputs();
        disturb(k, &mut inputs);
        let outputs = control.step(None, &inputs);
        assert_eq!(outputs.amplifier, outputs.fault.is_none(), "off in the step that finds the fault");
        if outputs.fault.is_some() {
            assert_eq!((outputs.force, outputs.mode), (0.0, ModeId::Fault));
            first = first.or(outputs.fault);
            assert_eq!(first, outputs.fault, "the first fault stays");
        }
    }
    first
}

#[test]
fn every_check_finds_only_its_fault() {
    assert_eq!(fault_of(|_, _| {}), None);
    let late = |k: u32, inputs: &mut Inputs| {
        if k >= 5 {
            inputs.sample_ticks = inputs.sample_ticks.wrapping_add(170_000);
        }
    };
    assert_eq!(fault_of(late), Some(FaultKind::MissedDeadline));
    let early = |k: u32, inputs: &mut Inputs| {
        if k == 5 {
            inputs.sample_ticks = inputs.sample_ticks.wrapping_sub(100_000);
        }
    };
    assert_eq!(fault_of(early), Some(FaultKind::MissedDeadline));
    for jump in [600, -600_i32, 6_000, i32::MAX, i32::MIN] {
        let jumped = |k: u32, inputs: &mut Inputs| {
            if k >= 5 {
                inputs.count = inputs.count.wrapping_add(jump as u32);
                inputs.edge_ticks = inputs.sample_ticks;
            }
        };
        assert_eq!(fault_of(jumped), Some(FaultKind::EncoderJump), "{jump} counts");
    }
    for (load, accel) in [(0, 32_768), (65_520, 32_768), (32_768, 65_535), (32_768, 3)] {
        let rail = |k: u32, inputs: &mut Inputs| {
            if k >= 5 {
                (inputs.load_code, inputs.accel_code) = (load, accel);
            }
        };
        assert_eq!(fault_of(rail), Some(FaultKind::SensorRail), "{load} {accel}");
        let blip = |k: u32, inputs: &mut Inputs| {
            if k == 5 || k == 6 {
                (inputs.load_code, inputs.accel_code) = (load, accel);
            }
        };
        assert_eq!(fault_of(blip), None, "two samples at a rail are an impact, not a cable");
    }
}

#[test]
fn a_fault_is_latched_until_cleared_at_rest() {
    let (mut control, mut rig) = idle();
    render(&mut control, &mut rig);
    rig.push(0.0);
    let outputs = control.step(Some(&Request::Raise(FaultKind::EmergencyStop)), &rig.inputs());
    assert_eq!(
        (outputs.force, outputs.amplifier, outputs.fault),
        (0.0, false, Some(FaultKind::EmergencyStop))
    );
    let Mode::Fault(fault) = *control.state().mode() else { panic!("latched") };
    assert_eq!((fault.kind, fault.at_ticks), (FaultKind::EmergencyStop, rig.inputs().sample_ticks));
    for request in [
        Request::Render(true),
        Request::Excite(Excitation::default()),
        Request::Identify(Procedure::default()),
        Request::Raise(FaultKind::Hardware),
        Request::Stop,
        Request::Render(false),
    ] {
        rig.push(0.0);
        let outputs = control.step(Some(&request), &rig.inputs());
        assert_eq!(outputs.fault, Some(FaultKind::EmergencyStop), "{request:?}");
        assert!(!outputs.amplifier);
    }
    // moving: denied
    for _ in 0..5 {
        rig.carry(0.1);
        control.step(None, &rig.inputs());
    }
    rig.carry(0.1);
    let outputs = control.step(Some(&Request::ClearFault), &rig.inputs());
    assert_eq!((outputs.denied, outputs.mode), (Some(Denied::NotAtRest), ModeId::Fault));
    // at rest but pushed: denied
    for _ in 0..50 {
        rig.carry(0.0);
        control.step(None, &rig.inputs());
    }
    rig.load_n = 5.0;
    rig.carry(0.0);
    let outputs = control.step(Some(&Request::ClearFault), &rig.inputs());
    assert_eq!(outputs.denied, Some(Denied::NotAtRest));
    rig.load_n = 0.1;
    rig.carry(0.0);
    let outputs = control.step(Some(&Request::ClearFault), &rig.inputs());
    assert_eq!((outputs.denied, outputs.mode, outputs.fault), (None, ModeId::Idle, None));
}

#[test]
fn off_ends_every_mode_in_its_step_and_keeps_a_fault() {
    for enter in [
        None,
        Some(Request::Render(true)),
        Some(Request::Excite(Excitation::default())),
        Some(Request::Identify(Procedure::default())),
        Some(Request::Probe),
    ] {
        let (mut control, mut rig) = idle();
        let mut outputs = control.step(enter.as_ref(), &rig.inputs());
        assert_eq!(outputs.denied, None, "{enter:?}");
        for _ in 0..40 {
            rig.push(f64::from(outputs.force));
            outputs = control.step(None, &rig.inputs());
        }
        assert_eq!(outputs.amplifier, enter.is_some(), "{enter:?}");
        for _ in 0..2 {
            rig.push(f64::from(outputs.force));
            outputs = control.step(Some(&Request::Off), &rig.inputs());
            assert_eq!(
                (outputs.force, outputs.amplifier, outputs.mode, outputs.denied),
                (0.0, false, ModeId::Idle, None),
                "{enter:?}"
            );
        }
        rig.push(0.0);
        let outputs = control.step(Some(&Request::Raise(FaultKind::EmergencyStop)), &rig.inputs());
        assert_eq!(outputs.fault, Some(FaultKind::EmergencyStop));
        rig.push(0.0);
        let outputs = control.step(Some(&Request::Off), &rig.inputs());
        assert_eq!((outputs.denied, outputs.fault), (None, Some(FaultKind::EmergencyStop)));
    }
}

#[test]
fn render_off_is_refused_while_the_handle_is_driven() {
    let (mut control, mut rig) = idle();
    control.step(Some(&Request::Excite(Excitation::default())), &rig.inputs());
    rig.push(0.0);
    let outputs = control.step(Some(&Request::Render(false)), &rig.inputs());
    assert_eq!((outputs.denied, outputs.mode), (Some(Denied::Driven), ModeId::Exciting));
    rig.push(0.0);
    assert_eq!(control.step(Some(&Request::Off), &rig.inputs()).mode, ModeId::Idle);
    rig.push(0.0);
    assert_eq!(control.step(Some(&Request::Render(false)), &rig.inputs()).denied, None);
}

/// A loop that does not know the middle of the stroke, with the handle at `x` m.
fn unreferenced(x: f64) -> (Control, Rig) {
    let device = Device::default();
    let mut rig = Rig::new(f64::from(device.mass), f64::from(device.damping), x);
    let mut control = Control::new(Settings::rubber().build(&device).expect("valid settings"));
    for _ in 0..3 {
        control.step(None, &rig.inputs());
        rig.push(0.0);
    }
    (control, rig)
}

#[test]
fn an_unreferenced_loop_drives_nothing() {
    let (mut control, mut rig) = unreferenced(0.0);
    for request in
        [Request::Excite(Excitation::default()), Request::Identify(Procedure::default()), Request::Probe]
    {
        let outputs = control.step(Some(&request), &rig.inputs());
        assert_eq!((outputs.denied, outputs.mode), (Some(Denied::Unreferenced), ModeId::Idle), "{request:?}");
        assert!(!outputs.amplifier && !outputs.referenced);
        rig.push(0.0);
    }
    // 20 mm from where the count began: a stop may be there
    let (mut control, mut rig) = unreferenced(0.020);
    let outputs = control.step(Some(&Request::Render(true)), &rig.inputs());
    assert_eq!((outputs.denied, outputs.mode), (None, ModeId::Rendering));
    let mut largest = 0.0_f32;
    for _ in 0..200 {
        rig.carry(-0.05);
        let outputs = control.step(None, &rig.inputs());
        assert_eq!(outputs.fault, None);
        largest = largest.max(outputs.force.abs());
    }
    assert!(largest <= UNREFERENCED && largest > 0.99 * UNREFERENCED, "{largest}");
}

#[test]
fn zero_takes_the_handle_for_the_middle() {
    let (mut control, mut rig) = unreferenced(0.011);
    rig.carry(0.1);
    control.step(None, &rig.inputs());
    rig.carry(0.1);
    let outputs = control.step(Some(&Request::Zero), &rig.inputs());
    assert_eq!((outputs.denied, outputs.referenced), (Some(Denied::Moving), false));
    for _ in 0..300 {
        rig.carry(0.0);
        control.step(None, &rig.inputs());
    }
    let count = rig.inputs().count;
    let outputs = control.step(Some(&Request::Zero), &rig.inputs());
    assert_eq!((outputs.denied, outputs.referenced), (None, true));
    rig.carry(0.0);
    let outputs = control.step(Some(&Request::Excite(Excitation::default())), &rig.inputs());
    assert_eq!((outputs.denied, outputs.mode), (None, ModeId::Exciting));
    assert_eq!(control.state().origin(), count);
    assert_eq!(outputs.position, 0.0);
    rig.push(0.0);
    assert_eq!(control.step(Some(&Request::Zero), &rig.inputs()).denied, Some(Denied::Busy));
}

#[test]
fn the_middle_is_where_an_index_pulse_tells_it_even_in_motion() {
    let (mut control, mut rig) = unreferenced(0.011);
    rig.carry(0.1);
    let middle = rig.inputs().count.wrapping_sub(1_000);
    let outputs = control.step(Some(&Request::Middle(middle)), &rig.inputs());
    assert_eq!((outputs.denied, outputs.referenced), (None, true));
    rig.carry(0.0);
    let outputs = control.step(None, &rig.inputs());
    let from_middle = rig.inputs().count.wrapping_sub(middle) as f32 * Device::default().metre_per_count;
    assert_eq!(outputs.position, from_middle);
    // under a contact the position would jump
    render(&mut control, &mut rig);
    let outputs = control.step(Some(&Request::Middle(0)), &rig.inputs());
    assert_eq!((outputs.denied, control.state().origin()), (Some(Denied::Busy), middle));
}

#[test]
fn a_doubted_count_loses_the_origin() {
    for (kind, kept) in [
        (FaultKind::EncoderJump, false),
        (FaultKind::EncoderSilent, false),
        (FaultKind::BrownOut, false),
        (FaultKind::EmergencyStop, true),
        (FaultKind::EndOfStroke, true),
    ] {
        let (mut control, mut rig) = idle();
        render(&mut control, &mut rig);
        rig.push(0.0);
        let outputs = control.step(Some(&Request::Raise(kind)), &rig.inputs());
        assert_eq!((outputs.fault, outputs.referenced), (Some(kind), kept), "{kind}");
        rig.carry(0.0);
        let outputs = control.step(Some(&Request::ClearFault), &rig.inputs());
        assert_eq!((outputs.denied, outputs.referenced), (None, kept), "{kind}");
        rig.carry(0.0);
        let denied = control.step(Some(&Request::Excite(Excitation::default())), &rig.inputs()).denied;
        assert_eq!(denied, if kept { None } else { Some(Denied::Unreferenced) }, "{kind}");
    }
    // without a force it is no fault, but the middle has moved all the same
    let (mut control, rig) = idle();
    let mut inputs = rig.inputs();
    inputs.count = inputs.count.wrapping_add(3_000);
    let outputs = control.step(None, &inputs);
    assert_eq!((outputs.fault, outputs.referenced), (None, false));
}

#[test]
fn a_jump_far_away_leaves_a_way_out() {
    let (mut control, mut rig) = idle();
    render(&mut control, &mut rig);
    rig.push(0.0);
    let shifted = |rig: &Rig, k: u32| {
        let inputs = rig.inputs();
        let sample_ticks = inputs.sample_ticks.wrapping_add(k * 170_000);
        Inputs { count: inputs.count.wrapping_add(1 << 30), sample_ticks, ..inputs }
    };
    let outputs = control.step(None, &shifted(&rig, 0));
    assert_eq!(outputs.fault, Some(FaultKind::EncoderJump));
    for k in 1..300 {
        control.step(None, &shifted(&rig, k));
    }
    let outputs = control.step(Some(&Request::ClearFault), &shifted(&rig, 300));
    assert_eq!((outputs.denied, outputs.fault, outputs.referenced), (None, None, false));
    let outputs = control.step(Some(&Request::Zero), &shifted(&rig, 301));
    assert_eq!((outputs.denied, outputs.referenced), (None, true));
    assert_eq!(control.step(Some(&Request::Render(true)), &shifted(&rig, 302)).denied, None);
}

#[test]
fn a_silent_host_is_a_fault() {
    let (mut control, mut rig) = idle();
    render(&mut control, &mut rig);
    let mut silent_after = None;
    for k in 0..400 {
        rig.push(0.0);
        let promise = Request::HostWatch { seconds: 0.1 };
        let request = (k % 50 == 0 && k <= 150).then_some(&promise);
        let outputs = control.step(request, &rig.inputs());
        if outputs.fault.is_some() {
            assert_eq!(outputs.fault, Some(FaultKind::HostSilent));
            silent_after = Some(k);
            break;
        }
    }
    println!("last promise at 150 ms for 100 ms: force withdrawn at {silent_after:?} ms");
    assert!(silent_after.is_some_and(|k| (248..=252).contains(&k)));
}

#[test]
fn an_excitation_ramps_in_and_returns_to_centre() {
    for &wave in Wave::ALL {
        let (amplitude_m, frequency_hz) = if wave == Wave::Multisine { (0.008, 0.7) } else { (0.01, 1.0) };
        let excitation = Excitation { wave, amplitude_m, frequency_hz, seconds: 6.0 };
        let (mut control, mut rig) = idle();
        rig = Rig::new(rig.mass, rig.damping, 0.004);
        let mut fresh = Control::referenced(*control.config());
        std::mem::swap(&mut control, &mut fresh);
        control.step(None, &rig.inputs());
        rig.push(0.0);
        let mut outputs = control.step(Some(&Request::Excite(excitation)), &rig.inputs());
        assert_eq!(outputs.denied, None);
        let (mut reach, mut worst, mut last, mut jump, mut steps) = (0.0_f64, 0.0_f64, 0.0_f32, 0.0_f32, 0);
        while outputs.mode == ModeId::Exciting {
            rig.push(f64::from(outputs.force));
            outputs = control.step(None, &rig.inputs());
            assert_eq!(outputs.fault, None, "{}", wave.id());
            steps += 1;
            assert!(steps < 20_000);
            if outputs.mode == ModeId::Exciting {
                jump = jump.max((outputs.force - last).abs());
                last = outputs.force;
                worst = worst.max((f64::from(outputs.reference) - rig.x).abs());
                if (1_000..6_000).contains(&steps) {
                    reach = reach.max(rig.x.abs());
                }
            }
        }
        println!(
            "{:9} {:.0} mm {frequency_hz} Hz: {:.3} s, reach {:.2} mm, worst error {:.2} mm, largest step of force {jump:.3} N, ends {:.3} mm, last force {last:.4} N",
            wave.id(),
            amplitude_m * 1e3,
            f64::from(steps) * 1e-3,
            reach * 1e3,
            worst * 1e3,
            rig.x * 1e3
        );
        assert!((6.4..6.8).contains(&(f64::from(steps) * 1e-3)), "its length, then the ramp-out");
        assert!((reach / f64::from(amplitude_m) - 1.0).abs() < 0.08, "amplitude");
        assert!(worst < 1.5e-3 && rig.x.abs() < 0.3e-3 && last.abs() < 0.05);
        assert!(jump < 1.5, "smooth");
    }
}

#[test]
fn stop_ramps_out_and_bad_excitations_are_denied() {
    let (mut control, mut rig) = idle();
    let endless = Excitation { seconds: 0.0, ..Excitation::default() };
    let mut outputs = control.step(Some(&Request::Excite(endless)), &rig.inputs());
    for _ in 0..3_000 {
        rig.push(f64::from(outputs.force));
        outputs = control.step(None, &rig.inputs());
    }
    assert_eq!(outputs.mode, ModeId::Exciting);
    rig.push(f64::from(outputs.force));
    outputs = control.step(Some(&Request::Render(true)), &rig.inputs());
    assert_eq!(outputs.denied, Some(Denied::Busy));
    outputs = {
        rig.push(f64::from(outputs.force));
        control.step(Some(&Request::Stop), &rig.inputs())
    };
    let mut steps = 0;
    while outputs.mode != ModeId::Idle {
        rig.push(f64::from(outputs.force));
        outputs = control.step(None, &rig.inputs());
        steps += 1;
        assert!(steps < 1_000);
    }
    println!("stop: idle after {steps} ms at {:.3} mm", rig.x * 1e3);
    let good = Excitation::default();
    for bad in [
        Excitation { amplitude_m: 0.02, ..good },
        Excitation { amplitude_m: -0.01, ..good },
        Excitation { amplitude_m: f32::NAN, ..good },
        Excitation { frequency_hz: 0.0, ..good },
        Excitation { frequency_hz: 50.0, ..good },
        Excitation { frequency_hz: f32::INFINITY, ..good },
        Excitation { seconds: -1.0, ..good },
        Excitation { seconds: f32::NAN, ..good },
    ] {
        rig.carry(0.0);
        let outputs = control.step(Some(&Request::Excite(bad)), &rig.inputs());
        assert_eq!((outputs.denied, outputs.mode), (Some(Denied::BadExcitation), ModeId::Idle));
        println!("err: {}", bad.validate(&Device::default()).expect_err("bad"));
    }
}

/// Any number: ordinary, subnormal, huge, infinite or NaN.
fn any_number() -> impl Strategy<Value = f32> {
    prop_oneof![
        4 => -10.0_f32..10.0,
        1 => prop::num::f32::ANY,
        1 => prop::num::f32::SUBNORMAL,
        1 => Just(f32::NAN),
        1 => Just(0.0_f32),
        1 => 1e3_f32..1e9,
    ]
}

prop_compose! {
    fn any_settings()(law in 0..LawKind::ALL.len(), renderer in 0..RendererKind::ALL.len(), preset in 0..4_usize,
                      change in prop::collection::vec((0..Settings::PARAMETERS.len(), any_number()), 0..4),
                      effect in 0..friction::effects::EffectKind::ALL.len(), gain in any_number()) -> Settings {
        let (_, make) = Settings::PRESETS[preset];
        let mut settings = Settings { law: LawKind::ALL[law], renderer: RendererKind::ALL[renderer], ..make() };
        for (at, value) in change {
            // the parser rejects NaN; validation must reject the rest
            let _ = settings.set(Settings::PARAMETERS[at].name, &value.to_string());
        }
        let kind = friction::effects::EffectKind::ALL[effect];
        if let Some(first) = kind.gains().first() {
            let _ = settings.set(&format!("{}.{}", kind.id(), first.name), &gain.to_string());
        }
        settings
    }
}

fn any_request() -> impl Strategy<Value = Request> {
    prop_oneof![
        any::<bool>().prop_map(Request::Render),
        (0..Wave::ALL.len(), any_number(), any_number(), any_number()).prop_map(|(w, a, f, s)| {
            Request::Excite(Excitation { wave: Wave::ALL[w], amplitude_m: a, frequency_hz: f, seconds: s })
        }),
        Just(Request::Excite(Excitation::default())),
        (any_number(), any_number()).prop_map(|(warm_up_s, record_s)| {
            Request::Identify(Procedure { warm_up_s, record_s, ..Procedure::default() })
        }),
        Just(Request::Stop),
        Just(Request::Off),
        Just(Request::Zero),
        any::<u32>().prop_map(Request::Middle),
        Just(Request::Home),
        Just(Request::Probe),
        Just(Request::ClearFault),
        (0..FaultKind::ALL.len()).prop_map(|k| Request::Raise(FaultKind::ALL[k])),
        any_number().prop_map(|seconds| Request::HostWatch { seconds }),
    ]
}

/// Mostly plausible inputs, so that states beyond the first fault are reached.
#[derive(Debug, Clone, Copy)]
enum Sample {
    Next(i8),
    Wild(u32, u32, u32, u16, u16),
}

fn any_sample() -> impl Strategy<Value = Sample> {
    prop_oneof![
        60 => (-3_i8..=3).prop_map(Sample::Next),
        10 => any::<i8>().prop_map(Sample::Next),
        1 => any::<(u32, u32, u32, u16, u16)>().prop_map(|(a, b, c, d, e)| Sample::Wild(a, b, c, d, e)),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]

    /// For any input: finite outputs, force within the limit, off in the step of a fault, latched; and the same inputs give the
    /// same bits.
    #[test]
    fn nothing_makes_it_unsafe(
        settings in any_settings(),
        knows: bool,
        wild_device in (any_number(), any_number(), any_number(), 0..8_u8),
        script in prop::collection::vec(
            (
                any_sample(),
                prop::option::weighted(0.15, any_request()),
                prop::option::weighted(0.02, any_settings()),
            ),
            1..200,
        ),
    ) {
        let mut device = Device::default();
        let (a, b, c, which) = wild_device;
        if which == 0 {
            // an invalid device description
            device = Device { metre_per_count: a, damping: b, tracking_stiffness: c, ..device };
        } else if which == 1 {
            device.load = Channel { offset_code: a, unit_per_code: b };
            device.tick_hz = c as u32;
        }
        let config = settings.build(&device).or_else(|_| Settings::rubber().build(&Device::default()));
        let config = config.expect("the default device takes rubber");
        let mut control = if knows { Control::referenced(config) } else { Control::new(config) };
        let mut twin = control;
        let mut now = Inputs { load_code: 32_768, accel_code: 32_768, ..Inputs::default() };
        let mut latched: Option<FaultKind> = None;
        for (sample, request, other) in &script {
            if let Some(Ok(other)) = other.map(|other| other.build(&device)) {
                control.configure(other);
                twin.configure(other);
            }
            match *sample {
                Sample::Next(counts) => {
                    now.sample_ticks = now.sample_ticks.wrapping_add(170_000);
                    now.count = now.count.wrapping_add(counts as u32);
                    if counts != 0 {
                        now.edge_ticks = now.sample_ticks.wrapping_sub(1_000 * u32::from(counts.unsigned_abs()));
                    }
                    (now.load_code, now.accel_code) = (32_768, 32_768);
                }
                Sample::Wild(sample_ticks, count, edge_ticks, load_code, accel_code) => {
                    now = Inputs { sample_ticks, count, edge_ticks, load_code, accel_code };
                }
            }
            let request = request.as_ref();
            let out = control.step(request, &now);
            let again = twin.step(request, &now);
            for (x, y) in [
                (out.force, again.force), (out.position, again.position), (out.velocity, again.velocity),
                (out.reference, again.reference), (out.block_position, again.block_position),
                (out.block_velocity, again.block_velocity), (out.friction, again.friction),
            ] {
                prop_assert!(x.is_finite(), "{out:?}");
                prop_assert_eq!(x.to_bits(), y.to_bits());
            }
            prop_assert!(out.force.abs() <= FORCE_MAX, "{out:?}");
            if !out.referenced {
                prop_assert!(!matches!(out.mode, ModeId::Exciting | ModeId::Identifying), "{out:?}");
                prop_assert!(out.mode != ModeId::Rendering || out.force.abs() <= UNREFERENCED, "{out:?}");
            }
            prop_assert!(out.amplifier || out.force == 0.0);
            prop_assert_eq!(out.fault.is_some(), out.mode == ModeId::Fault);
            if out.fault.is_some() {
                prop_assert!(!out.amplifier && out.force == 0.0);
            }
            if let Some(kind) = latched {
                let cleared = matches!(request, Some(Request::ClearFault)) && out.denied.is_none();
                prop_assert!(cleared || out.fault == Some(kind), "latched: {kind} became {:?}", out.fault);
            }
            latched = out.fault;
        }
    }
}

#[test]
fn codes_and_names_are_unique_and_round_trip() {
    for &kind in FaultKind::ALL {
        assert_eq!(FaultKind::from_code(kind.code()), Some(kind));
        assert!(kind.code() != 0 && !kind.explain().is_empty());
    }
    for &mode in ModeId::ALL {
        assert_eq!(ModeId::from_code(mode.code()), Some(mode));
    }
    assert_eq!(FaultKind::from_code(0), None);
    assert_eq!(FaultKind::from_code(200), None);
}
