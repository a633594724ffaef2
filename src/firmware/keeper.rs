//! Task that stores presets, the only one that uses the flash.

use tribos_firmware::board::nucleo::flash::{Pages, Wanted};
use tribos_firmware::presets::{Library, NotStored};

#[embassy_executor::task]
pub async fn run(mut library: Result<Library<Pages>, NotStored>) {
    loop {
        let wanted = Wanted::next().await;
        let outcome = match &mut library {
            Ok(library) => library.store(wanted.key(), wanted.item()).await,
            Err(why) => Err(*why),
        };
        wanted.done(outcome);
    }
}
