//! Settings by name, validation with physics, presets.

use friction::effects::EffectName;
use haptics::{Accepted, Device, LawKind, RendererKind, Settings, Value, bounds};

const T: f64 = 1e-3;

#[test]
fn every_preset_validates_without_a_warning() {
    let device = Device::default();
    for (name, make) in Settings::PRESETS {
        let settings = make();
        assert_eq!(settings.validate(&device), Ok(None), "{name}");
        let (m, k, b) = (f64::from(settings.mass), f64::from(settings.k_vc), f64::from(settings.b_vc));
        let friction = f64::from(settings.f_dynamic_p.max(settings.f_dynamic_n));
        let cycle = bounds::limit_cycle_velocity(friction, m, k, b, T);
        let stiffest = bounds::stiffness_max(f64::from(device.mass), f64::from(device.damping), T, b);
        // K·1.5T < b + B, the margin with a whole period of delay and a device of 1 N·s/m
        let delayed = (1.0 + b) / (1.5 * T);
        println!(
            "{name:8} k_vc {k} of {stiffest:.0} N/m ({delayed:.0} delayed), limit cycle {:.2} mm/s, dv {:.2} mm/s",
            cycle * 1e3,
            settings.dv * 1e3
        );
        assert!(k < stiffest && k < delayed && cycle < f64::from(settings.dv));
        assert_eq!(Settings::preset(name), Some(settings));
    }
    assert_eq!(Settings::preset("velvet"), None);
}

#[test]
fn table_5_3_is_accepted_with_a_warning() {
    let settings = Settings::forced_choice();
    let warning = settings.validate(&Device::default()).expect("safe").expect("unfaithful");
    println!("ok warn: {warning}");
    assert_eq!(warning.parameter, "dv");
    let Accepted::AtLeast(dv) = warning.faithful else { panic!("a lower bound") };
    assert!((dv - 2.05e-3).abs() < 0.01e-3);
    assert_eq!(
        Settings { dv, ..settings }.validate(&Device::default()),
        Ok(None),
        "the number it names is faithful"
    );
    assert!(settings.build(&Device::default()).is_ok());
}

#[test]
fn the_named_number_is_accepted() {
    let device = Device::default();
    let base = Settings::rubber();
    let impedance = Settings { renderer: RendererKind::Impedance, ..base };
    let dahl = Settings { law: LawKind::Dahl, damping_n: base.damping_p, ..base };
    let cases: &[(Settings, &str, &str)] = &[
        (base, "k_vc", "1e6"),
        (base, "k_vc", "-5"),
        (base, "k_vc", "0"),
        (impedance, "k_vc", "60000"),
        (base, "b_vc", "1200"),
        (base, "b_vc", "-1"),
        (base, "f_static_p", "30"),
        (base, "f_static", "9.5"),
        (base, "f_dynamic_p", "9.481"),
        (base, "f_dynamic_n", "3"),
        (base, "f_dynamic_p", "-0.1"),
        (base, "f_static_n", "1"),
        (base, "mass", "-1"),
        (base, "mass", "0"),
        (base, "mass", "0.011"),
        (base, "mass", "1e9"),
        (base, "dv", "0"),
        (base, "dv", "-0.1"),
        (base, "dv", "5"),
        (base, "damping_p", "-10"),
        (base, "damping_n", "1e5"),
        (impedance, "damping", "1200"),
        (dahl, "sigma", "1e9"),
        (dahl, "damping_p", "7"),
        (Settings { renderer: RendererKind::Impedance, ..dahl }, "sigma", "1e5"),
        (base, "stribeck_velocity", "0"),
        (base, "sigma_1", "-1"),
        (base, "spring.stiffness", "9e8"),
        (base, "stribeck.force_p", "20"),
        (base, "quadratic_drag.c_p", "1e5"),
        (base, "nonlinear_spring.cubic", "1e12"),
        (base, "stribeck.delta", "9"),
    ];
    for (settings, name, value) in cases {
        let mut tried = *settings;
        tried.set(name, value).expect("understood");
        let refused = tried.validate(&device).expect_err(&format!("{name} = {value}"));
        println!("err: {refused}");
        let line = refused.to_string();
        assert!(!line.contains('\n') && line.contains(refused.parameter));
        // follow the advice until the value is accepted
        let mut advised = tried;
        let mut rounds = 0;
        while let Err(refused) = advised.validate(&device) {
            rounds += 1;
            assert!(rounds <= 3, "advice leads nowhere: {refused}");
            let number = match refused.accepted {
                Accepted::AtMost(x) | Accepted::AtLeast(x) => x,
                Accepted::Between(low, high) => {
                    assert!(low <= high, "{refused}");
                    if refused.value > high { high } else { low }
                }
            };
            let name = match refused.effect {
                Some(effect) => format!("{effect}.{}", refused.parameter),
                None => refused.parameter.to_string(),
            };
            advised.set(&name, &number.to_string()).expect("understood");
        }
        assert!(advised.build(&device).is_ok());
    }
}

#[test]
fn non_finite_fields_are_refused() {
    let device = Device::default();
    for &law in LawKind::ALL {
        for &renderer in RendererKind::ALL {
            let base = Settings {
                law,
                renderer,
                f_static_n: 3.9,
                f_static_p: 3.9,
                f_dynamic_n: 3.0,
                f_dynamic_p: 3.0,
                damping_p: 3.0,
                damping_n: 3.0,
                sigma: 5_000.0,
                stribeck_velocity: 0.2,
                ..Settings::rubber()
            };
            assert!(base.validate(&device).is_ok(), "{law:?} {renderer:?}: {:?}", base.validate(&device));
            for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
                let fields: &[fn(&mut Settings) -> &mut f32] = &[
                    |s| &mut s.f_static_p,
                    |s| &mut s.f_static_n,
                    |s| &mut s.f_dynamic_p,
                    |s| &mut s.f_dynamic_n,
                    |s| &mut s.damping_p,
                    |s| &mut s.damping_n,
                    |s| &mut s.dv,
                    |s| &mut s.mass,
                    |s| &mut s.k_vc,
                    |s| &mut s.b_vc,
                    |s| &mut s.sigma,
                    |s| &mut s.sigma_1,
                    |s| &mut s.stribeck_velocity,
                    |s| &mut s.elastic,
                    |s| &mut s.attraction,
                    |s| &mut s.memory,
                    |s| &mut s.dwell,
                    |s| &mut s.steepness,
                ];
                for field in fields {
                    let mut settings = base;
                    *field(&mut settings) = bad;
                    assert!(settings.validate(&device).is_err(), "{settings:?}");
                    assert!(settings.build(&device).is_err());
                }
            }
        }
    }
}

#[test]
fn names_round_trip_and_errors_change_nothing() {
    let mut settings = Settings::brass();
    for parameter in Settings::PARAMETERS {
        let value = settings.get(parameter.name).expect(parameter.name);
        let before = settings;
        let text = value.to_string();
        settings.set(parameter.name, &text).expect("its own value");
        assert_eq!(settings, before, "{} = {text}", parameter.name);
        assert!(!parameter.what.is_empty());
        assert_eq!(
            parameter.unit(friction::Geometry::Linear).is_none(),
            matches!(value, Value::Word(_)) || matches!(parameter.name, "elastic" | "steepness"),
            "{}",
            parameter.name
        );
    }
    settings.set("f_static", "3.5").expect("both directions");
    assert_eq!((settings.f_static_p, settings.f_static_n), (3.5, 3.5));
    assert_eq!(settings.get("f_static"), Some(Value::Number(3.5)));
    assert_eq!(settings.get("f_dynamic"), Some(Value::Pair(1.7714, 1.729)));
    settings.set("stribeck.force_p", "0.4").expect("an effect");
    settings.set("stribeck.v_s", "0.02").expect("its shape");
    assert_eq!(settings.get("stribeck.force_p"), Some(Value::Number(0.4)));
    for id in ["spring.stiffness", "quadratic_drag.c_p", "offset.force"] {
        let _ = settings.set(id, "1");
    }
    let before = settings;
    for (name, value) in [
        ("f_static", "nan"),
        ("f_static", "inf"),
        ("f_static", ""),
        ("f_static", "3,5"),
        ("f_static", "1e99"),
        ("law", "butter"),
        ("renderer", ""),
        ("", "1"),
        ("f_statik", "1"),
        ("stribeck.colour", "1"),
        ("stribeck.force_p", "x"),
        ("unicorn.force", "1"),
        ("stribeck", "on"),
        ("cogging.cosine_1", "1"),
        (".", "1"),
        ("stribeck.", "1"),
        ("damping_p ", "1"),
        ("\u{fc}", "\u{1F9CA}"),
    ] {
        let error = settings.set(name, value).expect_err(name).to_string();
        println!("err: {error}");
        assert!(!error.contains('\n'));
        assert_eq!(settings, before, "{name} = {value}");
    }
    settings.set("stribeck", "off").expect("takes it out");
    assert_eq!(settings.get("stribeck.force_p"), None);
}

#[test]
fn a_second_wavelength_has_a_name_that_stays_its_own() {
    let mut settings = Settings::rubber();
    let mut set = |name: &str, value: &str| {
        let done = settings.set(name, value).map_err(|e| e.to_string());
        (done, settings)
    };
    let wavelengths = |s: &Settings| {
        let of = |name: &str| s.get(&format!("{name}.wavelength")).map(|value| value.to_string());
        ["cogging", "cogging_2", "cogging_3"].map(of)
    };
    let some = |text: &str| Some(text.to_string());
    let first = Err("cogging_2.sine_1: set cogging.PARAMETER first".to_string());
    assert_eq!(set("cogging_2.sine_1", "0.1").0, first);
    for (name, value) in [("spring.stiffness", "5"), ("offset.force", "0.1"), ("cogging.wavelength", "0.01")]
    {
        set(name, value).0.expect("a parameter");
    }
    set("spring", "off").0.expect("it is there");
    // the places behind `cogging` are filled first, then one before it
    set("cogging_2.wavelength", "0.02").0.expect("the second");
    let (done, three) = set("cogging_3.wavelength", "0.03");
    done.expect("the third");
    assert_eq!(wavelengths(&three), [some("0.01"), some("0.02"), some("0.03")]);
    assert!(three.effects.iter().all(Option::is_some) && three.get("offset.force").is_some());
    let (done, same) = set("cogging_4.wavelength", "0.04");
    println!("{}", done.expect_err("full"));
    assert_eq!(same, three);
    // the second and what is behind it
    let (done, one) = set("cogging_2", "off");
    done.expect("it is there");
    assert_eq!(wavelengths(&one), [some("0.01"), None, None]);
    assert_eq!(wavelengths(&set("cogging", "off").1), [None, None, None]);
    assert!(set("spring_2.stiffness", "5").0.is_err(), "two springs are one");
}

/// Regression: above the bound of a stuck handle the message named that bound, which exceeds the one of a sliding block.
#[test]
fn the_named_stiffness_is_accepted_without_damping() {
    let device = Device::default();
    let asked = Settings { k_vc: 1e9, b_vc: 0.0, ..Settings::rubber() };
    let refused = asked.validate(&device).expect_err("too stiff");
    let Accepted::Between(_, most) = refused.accepted else { panic!("{refused}") };
    println!("err: {refused}");
    Settings { k_vc: most, ..asked }.validate(&device).expect("the number it names");
}

#[test]
fn a_pattern_is_no_steeper_than_the_contact_is_stable_with() {
    let device = Device::default();
    let with = |renderer, sine: &str, wavelength: &str| {
        let mut settings = Settings { renderer, ..Settings::rubber() };
        for (name, value) in [("cogging.sine_1", sine), ("cogging.wavelength", wavelength)] {
            settings.set(name, value).expect("a parameter");
        }
        settings
    };
    // 2 N over 0.2 mm has a slope of 63 kN/m, above the stable stiffness of a handle without a block
    let steep = with(RendererKind::Impedance, "2", "2e-4");
    let refused = steep.validate(&device).expect_err("unstable");
    println!("{refused}");
    assert_eq!((refused.effect, refused.parameter), (EffectName::parse("cogging"), "wavelength"));
    let Accepted::AtLeast(least) = refused.accepted else { panic!("a lower bound: {refused}") };
    let room = 2.0 * core::f64::consts::TAU / f64::from(least);
    println!("accepted from {least} m: {room:.0} N/m");
    with(RendererKind::Impedance, "2", &least.to_string()).validate(&device).expect("the number it names");
    with(RendererKind::Impedance, "2", &(0.99 * least).to_string())
        .validate(&device)
        .expect_err("just below");
    // behind a block it is safe and unfaithful: at the rate, then against the coupling
    for (wavelength, rate, why) in [("2e-4", 1e3, "periods"), ("1e-3", 1e3, "jumps"), ("2e-4", 1e4, "jumps")]
    {
        let device = Device { period: (1.0 / rate) as f32, ..device };
        let settings = with(RendererKind::StoppingForce, "2", wavelength);
        let warning = settings.validate(&device).expect("safe").expect("unfaithful");
        println!("{rate} Hz: ok warn: {warning}");
        assert!(warning.parameter == "wavelength" && warning.why.words.contains(why));
    }
    let Some(warning) = with(RendererKind::StoppingForce, "2", "1e-3").validate(&device).expect("safe")
    else {
        panic!("a warning")
    };
    let Accepted::AtLeast(least) = warning.faithful else { panic!("a lower bound") };
    assert_eq!(with(RendererKind::StoppingForce, "2", &least.to_string()).validate(&device), Ok(None));
}
