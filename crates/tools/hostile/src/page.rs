//! Messages of a page of the lab.

use crate::one_line::is_one_line;
use haptics::{Device, Settings};
use lab::message::Ask;
use lab::verdict;
use perception::ForcedChoicePlan;

/// A message, and what it carries: proposed settings are judged, batches are drawn.
pub(crate) fn message(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    match Ask::read(text) {
        Ok(Ask::Propose { changes, .. } | Ask::Set { changes }) => {
            let (settings, device) = (Settings::default(), Device::default());
            match verdict::changed(&settings, &changes) {
                Ok(changed) => is_one_line(&format!("{} ", verdict::judge(&changed, &device).says)),
                Err(why) => is_one_line(&why),
            }
            if let Err(why) = verdict::steps(&settings, &device, &changes) {
                is_one_line(&why);
            }
        }
        Ok(Ask::BeginChoice { batches, .. }) => drop(ForcedChoicePlan::from_toml(&batches)),
        Ok(_) => {}
        Err(why) => is_one_line(&why),
    }
    // a file of batches by itself
    drop(ForcedChoicePlan::from_toml(text));
}
