//! The page and its socket.

mod app;
mod files;
mod socket;

pub(crate) use app::App;

use crate::assets;
use crate::guard::{Asking, COOKIE};
use axum::Router;
use axum::body::Body;
use axum::extract::{Query, Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use serde::Deserialize;

/// What the page itself may load: what the lab serves, nothing else.
const PAGE_POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; \
    connect-src 'self'; frame-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// The routes.
pub(crate) fn router(app: App) -> Router {
    Router::new()
        .route("/", get(page))
        .route("/assets/{name}", get(asset))
        .route("/socket", get(socket::open))
        .route("/recordings/{name}", get(files::recording))
        .route("/reports/{name}", get(files::report))
        .layer(middleware::from_fn_with_state(app.clone(), guard))
        .with_state(app)
}

fn text<'a>(headers: &'a HeaderMap, name: &HeaderName) -> Option<&'a str> {
    // what is not text is not what is expected
    headers.get(name).map(|value| value.to_str().unwrap_or("?"))
}

async fn guard(State(app): State<App>, request: Request, next: Next) -> Response {
    let headers = request.headers();
    let path = request.uri().path();
    let asking = Asking {
        host: text(headers, &header::HOST),
        origin: text(headers, &header::ORIGIN),
        site: text(headers, &HeaderName::from_static("sec-fetch-site")),
        cookie: text(headers, &header::COOKIE),
        socket: path == "/socket",
        page: path == "/",
    };
    let mut response = match app.guard.check(&asking) {
        Ok(()) => next.run(request).await,
        Err(why) => (StatusCode::FORBIDDEN, format!("refused: {why}\n")).into_response(),
    };
    let headers = response.headers_mut();
    for (name, value) in [
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::CACHE_CONTROL, "no-store"),
        (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
        (HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
    ] {
        headers.insert(name, HeaderValue::from_static(value));
    }
    if !headers.contains_key(header::CONTENT_SECURITY_POLICY) {
        headers.insert(header::CONTENT_SECURITY_POLICY, HeaderValue::from_static(PAGE_POLICY));
    }
    response
}

/// What may follow the address of the page.
#[derive(Debug, Deserialize)]
struct Typed {
    token: Option<String>,
}

async fn page(State(app): State<App>, headers: HeaderMap, Query(typed): Query<Typed>) -> Response {
    if let Some(token) = &typed.token {
        if !app.guard.is_token(token) {
            return (StatusCode::FORBIDDEN, "refused: not the token that `tribos lab` printed\n")
                .into_response();
        }
        // kept where no script and no other page reads it, and taken out of the address
        let cookie = format!("{COOKIE}={token}; Path=/; HttpOnly; SameSite=Strict");
        return match HeaderValue::from_str(&cookie) {
            Ok(cookie) => (
                StatusCode::OK,
                [
                    (header::SET_COOKIE, cookie),
                    (header::CONTENT_TYPE, HeaderValue::from_static("text/html; charset=utf-8")),
                ],
                // a page of its own: after a redirect from another site the strict cookie would not be sent
                "<!doctype html><meta http-equiv=\"refresh\" content=\"0;url=/\"><title>tribos lab</title>",
            )
                .into_response(),
            Err(_) => StatusCode::BAD_REQUEST.into_response(),
        };
    }
    if !app.guard.knows(text(&headers, &header::COOKIE)) {
        let why = "the token is missing: open the address that `tribos lab` printed\n";
        return (StatusCode::FORBIDDEN, why).into_response();
    }
    served("index.html")
}

async fn asset(axum::extract::Path(name): axum::extract::Path<String>) -> Response {
    served(&name)
}

fn served(name: &str) -> Response {
    match assets::find(name) {
        Some((kind, body)) => {
            ([(header::CONTENT_TYPE, HeaderValue::from_static(kind))], Body::from(body)).into_response()
        }
        None => (StatusCode::NOT_FOUND, "no such file\n").into_response(),
    }
}
