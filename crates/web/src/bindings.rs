//! What JavaScript calls. It runs in a worker, so that the page stays alive; ending the worker cancels.

use crate::analysis::{Answer, Options, Refusal};
use wasm_bindgen::prelude::*;

#[wasm_bindgen]
extern "C" {
    /// Of the worker: told of a bug before it ends the work.
    fn panicked(text: &str);
}

#[wasm_bindgen(start)]
fn start() {
    std::panic::set_hook(Box::new(|info| panicked(&info.to_string())));
}

/// Files, by name and content.
#[wasm_bindgen]
#[derive(Default)]
pub struct Files(Vec<(String, Vec<u8>)>);

#[wasm_bindgen]
impl Files {
    /// None yet.
    #[wasm_bindgen(constructor)]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds one.
    pub fn add(&mut self, name: String, bytes: Vec<u8>) {
        self.0.push((name, bytes));
    }

    /// Reads them; `options` is JSON.
    ///
    /// # Errors
    /// The option that is refused, or the file with line and column; what would be accepted.
    pub fn read(&self, options: &str) -> Result<Analysis, JsError> {
        let options: Options = serde_json::from_str(options)?;
        Ok(Analysis(crate::Analysis::new(&self.0, &options)?))
    }
}

/// Recordings, and how they are analysed.
#[wasm_bindgen]
pub struct Analysis(crate::Analysis);

#[wasm_bindgen]
impl Analysis {
    /// What reading did to the numbers, a line each.
    pub fn remarks(&self) -> Vec<String> {
        self.0.remarks()
    }

    /// Number of samples in all recordings.
    pub fn samples(&self) -> usize {
        self.0.samples()
    }

    /// As `tribos identify`: an object with `html`, `json` and `model`.
    ///
    /// # Errors
    /// What is wrong with the recordings.
    pub fn identify(&self) -> Result<js_sys::Object, JsError> {
        object(self.0.identify())
    }

    /// As `tribos diagnose`; `progress(share, what)` is called on the way.
    ///
    /// # Errors
    /// What is wrong with the recordings.
    pub fn diagnose(&self, progress: &js_sys::Function) -> Result<js_sys::Object, JsError> {
        object(self.0.diagnose(&|share, what| {
            // a page that does not listen changes nothing
            let _ = progress.call2(&JsValue::NULL, &share.into(), &what.into());
        }))
    }
}

fn object(answer: Result<Answer, Refusal>) -> Result<js_sys::Object, JsError> {
    let Answer { html, json, model } = answer?;
    let entries = js_sys::Array::new();
    for (name, text) in [("html", Some(html)), ("json", Some(json)), ("model", model)] {
        let value = text.map_or(JsValue::NULL, JsValue::from);
        entries.push(&js_sys::Array::of2(&name.into(), &value));
    }
    js_sys::Object::from_entries(&entries).map_err(|_| JsError::new("the answer is no object"))
}
