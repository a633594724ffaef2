use super::*;
use friction::effects::{Effect, EffectKind, MAX_GAINS, MAX_SHAPE};
use proptest::prelude::*;
use std::collections::BTreeMap;
use std::format;
use std::string::{String as Text, ToString};
use std::vec::Vec;

/// The store with the items that would survive a restart.
#[derive(Default)]
struct Kept {
    store: PresetStore,
    items: BTreeMap<u8, Vec<u8>>,
}

impl Kept {
    fn keep(&mut self, change: Change) {
        let mut next = Some(change);
        while let Some(change) = next {
            let mut buffer = [0; MAX_ITEM];
            self.items.insert(change.key(), change.encode(&mut buffer).to_vec());
            next = self.store.commit(change);
        }
    }

    fn restart(&mut self) {
        self.store = PresetStore::new();
        for (key, item) in &self.items {
            self.store.load(*key, item);
        }
        assert_eq!(self.store.loaded(), None, "every change was whole");
    }
}

#[test]
fn saved_presets_can_be_deleted_built_in_cannot() {
    let mut kept = Kept::default();
    let mut mine = Settings::rubber();
    mine.set("f_dynamic", "1.5").unwrap();
    kept.keep(kept.store.save("mine-2", &mine).unwrap());
    kept.restart();
    assert_eq!(kept.store.find("mine-2"), Ok(mine));
    assert_eq!(kept.store.save("rubber", &mine), Err(PresetError::BuiltIn("rubber")));
    assert_eq!(kept.store.find("rubber"), Ok(Settings::rubber()));
    for bad in ["", "Mine", "a b", "näme", "abcdefghijklmnopqrstuvwxy"] {
        assert_eq!(kept.store.save(bad, &mine), Err(PresetError::BadName(bad)));
    }
    kept.keep(kept.store.set_default("mine-2").unwrap());
    kept.restart();
    assert_eq!(kept.store.default_name(), Some("mine-2"));
    let change = kept.store.delete("mine-2").unwrap().expect("it is saved");
    kept.keep(change);
    assert_eq!(kept.store.default_name(), None);
    kept.restart();
    assert_eq!(kept.store.default_name(), None);
    assert_eq!(kept.store.delete("mine-2"), Err(PresetError::NotThere("mine-2")));
    assert_eq!(kept.store.delete("brass"), Err(PresetError::BuiltIn("brass")));
}

#[test]
fn a_full_store_still_replaces() {
    let mut kept = Kept::default();
    for name in ["a", "b", "c", "d", "e", "f", "g", "h"] {
        kept.keep(kept.store.save(name, &Settings::brass()).unwrap());
    }
    assert_eq!(kept.store.save("i", &Settings::brass()), Err(PresetError::Full));
    kept.keep(kept.store.save("h", &Settings::teflon()).unwrap());
    kept.restart();
    assert_eq!(kept.store.find("h"), Ok(Settings::teflon()));
    assert_eq!(kept.store.names().count(), Settings::PRESETS.len() + 8);
}

#[test]
fn identified_presets_persist_only_if_saved() {
    let mut kept = Kept::default();
    kept.store.set_identified(&Settings::teflon());
    assert_eq!(kept.store.find(IDENTIFIED), Ok(Settings::teflon()));
    assert_eq!(
        kept.store.set_default(IDENTIFIED),
        Err(PresetError::NotSaved(IDENTIFIED)),
        "it would not last"
    );
    kept.keep(kept.store.save(IDENTIFIED, &Settings::teflon()).unwrap());
    kept.store.set_identified(&Settings::rubber());
    assert_eq!(kept.store.find(IDENTIFIED), Ok(Settings::rubber()), "the newest");
    assert_eq!(kept.store.names().filter(|name| *name == IDENTIFIED).count(), 1);
    kept.restart();
    assert_eq!(kept.store.find(IDENTIFIED), Ok(Settings::teflon()));
    let change = kept.store.delete(IDENTIFIED).unwrap().expect("it is saved");
    kept.keep(change);
    assert!(kept.store.find(IDENTIFIED).is_err());
    kept.store.set_identified(&Settings::rubber());
    assert_eq!(kept.store.delete(IDENTIFIED), Ok(None), "only in memory");
    assert!(kept.store.find(IDENTIFIED).is_err());
}

#[test]
fn a_deleted_default_does_not_return() {
    // power went after the preset was deleted and before its default was
    let mut kept = Kept::default();
    kept.keep(kept.store.save("a", &Settings::brass()).unwrap());
    kept.keep(kept.store.set_default("a").unwrap());
    let mut buffer = [0; MAX_ITEM];
    let change = kept.store.delete("a").unwrap().expect("it is saved");
    kept.items.insert(change.key(), change.encode(&mut buffer).to_vec());
    kept.store = PresetStore::new();
    for (key, item) in &kept.items {
        kept.store.load(*key, item);
    }
    let clear = kept.store.loaded().expect("to be stored now");
    assert_eq!(kept.store.default_name(), None);
    kept.keep(clear);
    kept.keep(kept.store.save("a", &Settings::brass()).unwrap());
    kept.restart();
    assert_eq!(kept.store.default_name(), None);
}

#[test]
fn unknown_formats_are_reported_and_replaced() {
    let mut kept = Kept::default();
    let mut buffer = [0; MAX_ITEM];
    let mut other = kept.store.save("a", &Settings::brass()).unwrap().encode(&mut buffer).to_vec();
    other[0] += 1;
    for key in 0..7 {
        kept.items.insert(key, other.clone());
    }
    kept.items.insert(DEFAULT_KEY, other);
    kept.restart();
    assert_eq!((kept.store.unreadable(), kept.store.default_name()), (7, None));
    assert_eq!(kept.store.names().count(), Settings::PRESETS.len());
    kept.keep(kept.store.save("a", &Settings::brass()).unwrap());
    assert_eq!(kept.store.unreadable(), 7, "the free place first");
    kept.keep(kept.store.save("b", &Settings::brass()).unwrap());
    kept.restart();
    assert_eq!(kept.store.unreadable(), 6);
}

/// A change of these bytes is a change of format: a device that was updated could not read what it holds. Then count
/// up `FORMAT` in `item.rs`.
#[test]
fn the_format_of_a_saved_preset_is_what_devices_hold() {
    let mut settings = Settings { dv: 0.25, ..Settings::rubber() };
    settings.effects[1] =
        Some(Effect { kind: EffectKind::Offset, gains: [1.0, 0.0, 0.0, 0.0], shape: [0.0, 2.0] });
    let mut buffer = [0; MAX_ITEM];
    let item = PresetStore::new().save("x-1", &settings).unwrap();
    let hex: Text = item.encode(&mut buffer).iter().map(|byte| format!("{byte:02x}")).collect();
    std::println!("{hex}");
    assert_eq!(hex, FORMAT_3);
    let on = Settings { passivity: true, ..settings };
    let hex: Text = PresetStore::new()
        .save("x-1", &on)
        .unwrap()
        .encode(&mut buffer)
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect();
    let at = FORMAT_3.len() - 2 * OF_LAWS;
    assert_eq!(hex, format!("{}01{}", &FORMAT_3[..at - 2], &FORMAT_3[at..]));
    let laws: Vec<_> = (0..haptics::LawKind::ALL.len())
        .filter_map(|at| postcard::from_bytes::<haptics::LawKind>(&[at as u8]).ok())
        .map(|law| law.id())
        .collect();
    assert_eq!(laws.join(" "), LAWS_3);
    let kinds: Vec<_> = EffectKind::ALL.iter().map(|kind| kind.id()).collect();
    assert_eq!(kinds.join(" "), KINDS_1);
}

/// Items that a device saved before `passivity`, and before some of the laws, were there.
#[test]
fn presets_of_earlier_formats_are_read() {
    for earlier in [FORMAT_1, FORMAT_2] {
        let bytes: Vec<u8> = (0..earlier.len() / 2)
            .map(|k| u8::from_str_radix(&earlier[2 * k..2 * k + 2], 16).expect("hexadecimal"))
            .collect();
        let mut store = PresetStore::new();
        store.load(3, &bytes);
        let settings = store.find("x-1").expect("it is read");
        assert!(!settings.passivity && store.unreadable() == 0);
        assert_eq!(settings, Settings { dv: 0.25, effects: settings.effects, ..Settings::rubber() });
        assert_eq!(settings.effects[1].map(|effect| effect.gains[0]), Some(1.0));
        // cut short, or longer than its format, it is not
        store.load(3, &bytes[..bytes.len() - 2]);
        assert_eq!(store.unreadable(), 1);
        store.load(4, &[&bytes[..], &[0]].concat());
        assert_eq!(store.unreadable(), 2);
    }
}

/// Bytes that format 3 has behind `passivity`.
const OF_LAWS: usize = 21;
const LAWS_3: &str = "karnopp dahl coulomb lugre viscous classic majd_simaan bristle hayward_armstrong elasto_plastic \
    maxwell_slip armstrong";
const FORMAT_3: &str = "030103782d310001b37b7640cd3b3a40cc5d5f4010e92340a5bd0b419a77fe400000803e94f6c63e0000fa450000704100504347000020410ad7233c0001100000803f00000000000000000000000000000000000000400000003333333f00803b45000000000000803f0000204100";
const FORMAT_2: &str = "020103782d310001b37b7640cd3b3a40cc5d5f4010e92340a5bd0b419a77fe400000803e94f6c63e0000fa450000704100504347000020410ad7233c0001100000803f0000000000000000000000000000000000000040000000";
const FORMAT_1: &str = "010103782d310001b37b7640cd3b3a40cc5d5f4010e92340a5bd0b419a77fe400000803e94f6c63e0000fa450000704100504347000020410ad7233c0001100000803f00000000000000000000000000000000000000400000";
const KINDS_1: &str = "stribeck sublinear_viscous quadratic_drag presliding frictional_lag rising_static_friction \
    friction_drift position_dependent_friction load_dependent_friction spring nonlinear_spring gravity cogging \
    periodic_friction torque_ripple hard_stop offset lost_motion rate_and_state directional_efficiency";

#[test]
fn the_longest_preset_fits_its_item() {
    let effect = Effect { kind: EffectKind::Offset, gains: [1.0; MAX_GAINS], shape: [1.0; MAX_SHAPE] };
    let settings = Settings { effects: [Some(effect); haptics::settings::MAX_EFFECTS], ..Settings::brass() };
    let mut buffer = [0; MAX_ITEM];
    let item = PresetStore::new().save("abcdefghijklmnopqrstuvwx", &settings).unwrap();
    let length = item.encode(&mut buffer).len();
    std::println!("{length} bytes of {MAX_ITEM}");
    assert!(length > 100 && length <= MAX_ITEM - 8);
}

proptest! {
    #[test]
    fn no_item_panics_and_nothing_read_from_one_is_a_bad_name(
        items in proptest::collection::vec((0_u8..=9, proptest::collection::vec(any::<u8>(), 0..80)), 0..12),
        format in any::<bool>(),
    ) {
        let mut store = PresetStore::new();
        for (key, mut item) in items {
            if let (true, Some(first)) = (format, item.first_mut()) {
                *first = 1;
            }
            store.load(key, &item);
        }
        let _ = store.loaded();
        for name in store.names().map(ToString::to_string).collect::<Vec<_>>() {
            prop_assert!(store.find(&name).is_ok() && !name.is_empty() && name.len() <= 24);
        }
    }
}
