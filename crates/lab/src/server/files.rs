//! Recordings and reports of this session, to download and to read.

use super::app::App;
use crate::bench::is_name;
use axum::body::Body;
use axum::extract::{Path, State};
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};

/// Reports are files of their own, with their scripts inside; they may reach nothing.
const REPORT_POLICY: &str = "sandbox allow-scripts; default-src 'none'; script-src 'unsafe-inline'; \
    style-src 'unsafe-inline'; img-src data:; frame-ancestors 'self'";

fn not_there(name: &str) -> Response {
    let name: String = name.chars().filter(|c| c.is_ascii_graphic()).take(80).collect();
    (StatusCode::NOT_FOUND, format!("no file `{name}` in this session\n")).into_response()
}

fn download(name: &str, kind: &'static str, bytes: Vec<u8>) -> Response {
    let disposition = HeaderValue::from_str(&format!("attachment; filename=\"{name}\""));
    let disposition = disposition.unwrap_or(HeaderValue::from_static("attachment"));
    let headers =
        [(header::CONTENT_TYPE, HeaderValue::from_static(kind)), (header::CONTENT_DISPOSITION, disposition)];
    (headers, Body::from(bytes)).into_response()
}

/// `rec-001.csv` as it is, `rec-001.mcap` made of it.
pub(super) async fn recording(State(app): State<App>, Path(name): Path<String>) -> Response {
    if is_name(&name, ".csv") || is_name(&name, ".jsonl") {
        let kind = if name.ends_with(".csv") {
            "text/csv; charset=utf-8"
        } else {
            "application/jsonl; charset=utf-8"
        };
        return match std::fs::read(app.folder.join(&name)) {
            Ok(bytes) => download(&name, kind, bytes),
            Err(_) => not_there(&name),
        };
    }
    if !is_name(&name, ".mcap") {
        return not_there(&name);
    }
    let made = tokio::task::spawn_blocking(move || {
        let source = app.folder.join(name.replace(".mcap", ".csv"));
        if !source.exists() {
            return Err((name, None));
        }
        let out = app.folder.join(&name);
        let written = app
            .tools
            .to_mcap(&source, &out)
            .and_then(|()| std::fs::read(&out).map_err(|e| format!("{}: {e}", out.display())));
        written.map(|bytes| (name.clone(), bytes)).map_err(|why| (name, Some(why)))
    });
    match made.await {
        Ok(Ok((name, bytes))) => download(&name, "application/octet-stream", bytes),
        Ok(Err((_, Some(why)))) => (StatusCode::UNPROCESSABLE_ENTITY, format!("{why}\n")).into_response(),
        Ok(Err((name, None))) => not_there(&name),
        Err(_) => StatusCode::INTERNAL_SERVER_ERROR.into_response(),
    }
}

/// A report: a page of its own, which can reach nothing.
pub(super) async fn report(State(app): State<App>, Path(name): Path<String>) -> Response {
    if !is_name(&name, ".html") {
        return not_there(&name);
    }
    match std::fs::read(app.folder.join(&name)) {
        Ok(bytes) => {
            let headers = [
                (header::CONTENT_TYPE, HeaderValue::from_static("text/html; charset=utf-8")),
                (header::CONTENT_SECURITY_POLICY, HeaderValue::from_static(REPORT_POLICY)),
            ];
            (headers, Body::from(bytes)).into_response()
        }
        Err(_) => not_there(&name),
    }
}
