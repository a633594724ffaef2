//! One page's socket: every batch of samples down, requests up; the planar handle of the page.

use super::app::App;
use crate::bench::ToBench;
use crate::message::{Ask, LONGEST};
use crate::plane::{AskPlane, Plane};
use crate::say::{Say, Tone};
use crate::verdict;
use axum::extract::State;
use axum::extract::ws::{Message, WebSocket, WebSocketUpgrade};
use axum::response::Response;
use std::sync::atomic::Ordering;
use std::sync::mpsc::Sender;
use std::time::{Duration, Instant};
use tokio::sync::broadcast::error::RecvError;
use tokio::time::MissedTickBehavior;

/// Interval between two messages of the puck.
const PUCK: Duration = Duration::from_millis(16);

/// Requests to the device's thread that a page may make a second. A mouse that holds the handle makes 60 to 240.
const A_SECOND: u32 = 500;

/// Requests that a page may still make: those of a second at most.
struct Allowance {
    left: f64,
    at: Instant,
}

impl Allowance {
    fn new() -> Self {
        Self { left: f64::from(A_SECOND), at: Instant::now() }
    }

    /// Takes one, if there is one.
    fn take(&mut self, now: Instant) -> bool {
        let gained = f64::from(A_SECOND) * now.duration_since(self.at).as_secs_f64();
        (self.left, self.at) = ((self.left + gained).min(f64::from(A_SECOND)), now);
        let is_left = self.left >= 1.0;
        self.left -= f64::from(u8::from(is_left));
        is_left
    }
}

pub(super) async fn open(State(app): State<App>, upgrade: WebSocketUpgrade) -> Response {
    upgrade
        .max_message_size(LONGEST)
        .max_frame_size(LONGEST)
        .on_upgrade(move |socket| async move { page(&app, socket).await })
}

async fn page(app: &App, mut socket: WebSocket) {
    let page = app.pages.fetch_add(1, Ordering::Relaxed);
    let bench = app.bench.clone();
    let mut news = app.shared.pages.subscribe();
    let mut allowance = Allowance::new();
    let mut plane = Plane::new(app.folder.clone(), Instant::now());
    let mut ticks = tokio::time::interval(PUCK);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    // it answers with everything that is known
    let mut open = bench.send(ToBench::Joined(page)).is_ok();
    while open {
        tokio::select! {
            news = news.recv() => {
                let message = match news {
                    Ok(message) => message,
                    Err(RecvError::Lagged(batches)) => said(&Say::Skipped { batches }),
                    Err(RecvError::Closed) => break,
                };
                open = socket.send(message).await.is_ok();
            }
            _ = ticks.tick(), if plane.is_open() => {
                let (rows, work) = plane.advance(Instant::now());
                open = socket.send(said(&Say::Puck { rows, work })).await.is_ok();
            }
            asked = socket.recv() => match asked {
                Some(Ok(Message::Text(text))) => {
                    match answer(app, &bench, &mut allowance, &mut plane, text.as_str()) {
                        Ok(None) => {}
                        Ok(Some(message)) => open = socket.send(message).await.is_ok(),
                        Err(why) => {
                            let say = Say::Said { tone: Tone::Refused, about: "page", text: &why };
                            open = socket.send(said(&say)).await.is_ok();
                        }
                    }
                }
                // pages send text only
                Some(Ok(Message::Binary(_))) => {}
                // the library answers pings itself
                Some(Ok(Message::Ping(_) | Message::Pong(_))) => {}
                Some(Ok(Message::Close(_)) | Err(_)) | None => open = false,
            }
        }
    }
    let _ = bench.send(ToBench::Left(page));
}

fn said(say: &Say<'_>) -> Message {
    Message::Text(say.to_json().into())
}

/// What is answered to this page alone; the rest goes to the device's thread.
fn answer(
    app: &App,
    bench: &Sender<ToBench>,
    allowance: &mut Allowance,
    plane: &mut Plane,
    text: &str,
) -> Result<Option<Message>, String> {
    Ok(match Ask::read(text)? {
        Ask::Ping { id } => {
            let clock = app.began.elapsed().as_millis() as u32;
            Some(said(&Say::Pong { id, clock }))
        }
        Ask::Propose { id, changes } => {
            let (settings, device) = app.shared.known(|known| (known.settings, known.device));
            let verdict = match verdict::changed(&settings, &changes) {
                Ok(changed) => verdict::judge(&changed, &device),
                Err(says) => verdict::Verdict {
                    level: "refused",
                    says,
                    about: changes.first().map(|(name, _)| name.clone()).unwrap_or_default(),
                    ..verdict::judge(&settings, &device)
                },
            };
            Some(said(&Say::Proposed { id, verdict }))
        }
        Ask::Plane { ask } => {
            let quiet = matches!(ask, AskPlane::Hand { .. });
            if plane.obey(ask, Instant::now())? {
                // the bench lists the folder for every page
                bench.send(ToBench::Sessions).map_err(|_| "the lab is closing".to_owned())?;
            }
            (!quiet).then(|| said(&Say::Plane(plane.shown())))
        }
        ask => {
            // what takes the force away is never refused
            if !matches!(ask, Ask::Stop | Ask::Disarm) && !allowance.take(Instant::now()) {
                return Err(format!("too many requests: at most {A_SECOND} a second are accepted"));
            }
            bench.send(ToBench::Asked(ask)).map_err(|_| "the lab is closing".to_owned())?;
            None
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flood_filled_the_queue_of_the_device() {
        let mut allowance = Allowance::new();
        let began = allowance.at;
        // ten times as many as are accepted, for three seconds
        let passed = (0..30_000).filter(|k| allowance.take(began + Duration::from_micros(100 * k))).count();
        println!("{passed} of 30000 pass");
        assert!((1_990..=2_000).contains(&passed));
        // a fast mouse after a pause
        let later = began + Duration::from_secs(10);
        assert!((0..2_400).all(|k| allowance.take(later + Duration::from_micros(4_167 * k))));
    }
}
