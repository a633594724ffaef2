use super::*;

const FIRST: u32 = 0x3c000;
const PAGE_OF_FIRST: u32 = FIRST / 2048;

fn unlocked() -> Flash {
    let mut flash = Flash::new();
    flash.write(ACR, 0x0004_0200, 0);
    flash.write(KEYR, 0x4567_0123, 0);
    flash.write(KEYR, 0xcdef_89ab, 0);
    flash
}

fn program(flash: &mut Flash, offset: u32, low: u32, high: u32, now: u64) -> u32 {
    flash.store(offset, &low.to_le_bytes(), now);
    flash.store(offset + 4, &high.to_le_bytes(), now);
    flash.read(SR, now)
}

fn word(flash: &mut Flash, offset: u32, now: u64) -> u64 {
    let mut bytes = [0; 8];
    flash.fetch(offset, &mut bytes, now);
    u64::from_le_bytes(bytes)
}

#[test]
fn only_erased_double_words_are_programmed() {
    let mut flash = unlocked();
    assert_eq!(program(&mut flash, FIRST, 1, 2, 0), SR_PGSERR, "PG is not set");
    flash.write(SR, SR_FLAGS, 0);
    flash.write(CR, CR_PG, 0);
    assert_eq!(program(&mut flash, FIRST, 1, 2, 0), SR_BSY);
    let now = PROGRAM;
    assert_eq!((flash.read(SR, now), word(&mut flash, FIRST, now)), (0, 0x2_0000_0001));
    assert_eq!(program(&mut flash, FIRST, 3, 4, now), SR_PROGERR, "programmed before");
    flash.write(SR, SR_FLAGS, now);
    assert_eq!(program(&mut flash, FIRST, 0, 0, now), SR_BSY, "zeros always go");
    let now = 2 * now;
    flash.store(FIRST + 12, &[0; 4], now);
    assert_eq!(flash.read(SR, now), SR_PGAERR, "the upper half first");
    assert_eq!(program(&mut flash, FIRST + 16, 1, 1, now), SR_PGAERR | SR_PGSERR, "an error is pending");
    flash.write(SR, SR_FLAGS, now);
    flash.store(FIRST + 16, &[0; 2], now);
    assert_eq!(flash.read(SR, now), SR_SIZERR);
    assert_eq!(flash.violation, None);
}

#[test]
fn only_unlocked_pages_of_bank_2_are_erased() {
    let mut flash = unlocked();
    flash.write(CR, CR_PG, 0);
    program(&mut flash, FIRST, 1, 2, 0);
    program(&mut flash, FIRST + 2048, 1, 2, PROGRAM);
    let erase = CR_PER | CR_BKER | PAGE_OF_FIRST << 3;
    let now = 2 * PROGRAM;
    flash.write(CR, erase, now);
    flash.write(CR, erase | CR_STRT, now);
    assert_eq!(flash.read(SR, now + ERASE - 1), SR_BSY);
    let now = now + ERASE;
    assert_eq!(word(&mut flash, FIRST, now), u64::MAX);
    assert_eq!(word(&mut flash, FIRST + 2048, now), 0x2_0000_0001, "the next page");
    assert_eq!(flash.violation, None);
    flash.write(CR, CR_PER | CR_STRT, now);
    assert!(flash.violation.take().is_some_and(|v| v.contains("bank 1")));
    flash.write(CR, CR_LOCK, now);
    flash.write(CR, CR_PG, now);
    assert!(flash.violation.take().is_some_and(|v| v.contains("locked")));
    flash.write(KEYR, 0xcdef_89ab, now);
    assert!(flash.violation.take().is_some_and(|v| v.contains("key")));
    flash.write(KEYR, 0x4567_0123, now);
    assert_ne!(flash.read(CR, now) & CR_LOCK, 0, "until the reset");
}

#[test]
fn stalls_and_cache_corruption_are_violations() {
    let mut flash = unlocked();
    flash.write(CR, CR_PG, 0);
    program(&mut flash, FIRST, 1, 2, 0);
    word(&mut flash, FIRST, PROGRAM - 1);
    assert!(flash.violation.take().is_some_and(|v| v.contains("stalls")));
    flash.write(ACR, 0x0004_0600, PROGRAM);
    program(&mut flash, FIRST + 8, 1, 2, PROGRAM);
    assert!(flash.violation.take().is_some_and(|v| v.contains("data cache")));
}

#[test]
fn a_torn_double_word_raises_the_nmi() {
    let mut seen = [0; 2];
    for seed in 0..40 {
        let mut flash = unlocked();
        flash.cut_at(Some(2), seed);
        flash.write(CR, CR_PG, 0);
        program(&mut flash, FIRST, 1, 2, 0);
        program(&mut flash, FIRST + 8, 0x1234_5678, 0, PROGRAM);
        assert!(flash.power_lost);
        flash.power_up();
        assert_eq!(
            (word(&mut flash, FIRST, 0), flash.nmi),
            (0x2_0000_0001, false),
            "the first one was whole"
        );
        word(&mut flash, FIRST + 8, 0);
        seen[usize::from(flash.nmi)] += 1;
        if !flash.nmi {
            continue;
        }
        assert_eq!(flash.read(ECCR, 0), ECCR_ECCD | ECCR_BK_ECC | (FIRST + 8));
        flash.write(ECCR, ECCR_ECCD, 0);
        assert_eq!(flash.read(ECCR, 0) & ECCR_ECCD, 0);
        flash.nmi = false;
        flash.write(ACR, 0x0004_0200, 0);
        flash.write(KEYR, 0x4567_0123, 0);
        flash.write(KEYR, 0xcdef_89ab, 0);
        flash.write(CR, CR_PG, 0);
        program(&mut flash, FIRST + 8, 0, 0, 0);
        assert_eq!((word(&mut flash, FIRST + 8, PROGRAM), flash.nmi), (0, false));
    }
    println!("{} cuts left it whole or untouched, {} torn", seen[0], seen[1]);
    assert!(seen[0] > 5 && seen[1] > 10);
}
