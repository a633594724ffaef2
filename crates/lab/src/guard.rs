//! Access control: only pages served by this lab, under the address it was started with.
//!
//! A page of another origin can send requests here (a form, an image, a WebSocket) but cannot hide where it comes from:
//! browsers set `Origin` and `Sec-Fetch-Site` themselves. A page that makes its own name point at this address (DNS
//! rebinding) sends that name in `Host`. So: `Host` must be an address this lab listens on, `Origin` must be that
//! address, and a WebSocket must say its origin.

use std::net::{IpAddr, SocketAddr};

/// Name of the cookie that carries the token.
pub const COOKIE: &str = "tribos_lab";

/// What is accepted.
#[derive(Debug, Clone)]
pub struct Guard {
    address: SocketAddr,
    token: Option<String>,
}

/// Headers of a request, as far as they matter here.
#[derive(Debug, Clone, Copy, Default)]
pub struct Asking<'a> {
    /// `Host`
    pub host: Option<&'a str>,
    /// `Origin`
    pub origin: Option<&'a str>,
    /// `Sec-Fetch-Site`
    pub site: Option<&'a str>,
    /// `Cookie`
    pub cookie: Option<&'a str>,
    /// It opens a WebSocket.
    pub socket: bool,
    /// It opens the page itself, which a link anywhere may do.
    pub page: bool,
}

/// Equal, in a time that does not tell where they differ.
fn same(a: &str, b: &str) -> bool {
    a.len() == b.len() && a.bytes().zip(b.bytes()).fold(0, |differs, (a, b)| differs | (a ^ b)) == 0
}

impl Guard {
    /// For a lab that listens on `address`.
    #[must_use]
    pub fn new(address: SocketAddr, token: Option<String>) -> Self {
        Self { address, token }
    }

    /// The lab was reached by an address of its own.
    fn is_own(&self, host: &str) -> bool {
        let (name, port) = match host.rsplit_once(':') {
            Some((name, port)) if !port.ends_with(']') => (name, port.parse::<u16>().ok()),
            _ => (host, Some(80)),
        };
        if port != Some(self.address.port()) {
            return false;
        }
        let name = name.trim_start_matches('[').trim_end_matches(']');
        match name.parse::<IpAddr>() {
            // a name can be made to point here, an address cannot
            Ok(ip) => {
                let here = self.address.ip();
                ip == here || (here.is_unspecified() && (ip.is_ipv4() || here.is_ipv6()))
            }
            Err(_) => {
                name == "localhost" && (self.address.ip().is_loopback() || self.address.ip().is_unspecified())
            }
        }
    }

    /// Lets a request in.
    ///
    /// # Errors
    /// Why not, in one line.
    pub fn check(&self, asking: &Asking<'_>) -> Result<(), String> {
        let host = asking.host.ok_or("a request without Host")?;
        if !self.is_own(host) {
            return Err(format!("Host `{host}` is not this lab; accepted is http://{}", self.address));
        }
        match asking.origin {
            Some(origin) if origin.strip_prefix("http://") != Some(host) => {
                return Err(format!("Origin `{origin}` is not this lab"));
            }
            None if asking.socket => return Err("a WebSocket without Origin".into()),
            _ => {}
        }
        match asking.site {
            None | Some("same-origin" | "none") => {}
            Some(_) if asking.page => {}
            Some(site) => return Err(format!("a {site} request")),
        }
        if asking.page || self.knows(asking.cookie) {
            Ok(())
        } else {
            Err("the token is missing: open the address that `tribos lab` printed".into())
        }
    }

    /// The cookie carries the token, or none is needed.
    #[must_use]
    pub fn knows(&self, cookie: Option<&str>) -> bool {
        let Some(token) = &self.token else { return true };
        let Some(cookie) = cookie else { return false };
        cookie
            .split(';')
            .filter_map(|pair| pair.trim().split_once('='))
            .any(|(name, value)| name == COOKIE && same(value, token))
    }

    /// The token itself was typed, or none is needed.
    #[must_use]
    pub fn is_token(&self, typed: &str) -> bool {
        self.token.as_ref().is_none_or(|token| same(token, typed))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asking<'a>(host: &'a str, origin: Option<&'a str>) -> Asking<'a> {
        Asking { host: Some(host), origin, ..Asking::default() }
    }

    #[test]
    fn other_hosts_and_origins_are_refused() {
        let guard = Guard::new("127.0.0.1:7700".parse().unwrap(), None);
        let own = Some("http://127.0.0.1:7700");
        assert!(guard.check(&asking("127.0.0.1:7700", own)).is_ok());
        assert!(guard.check(&asking("localhost:7700", Some("http://localhost:7700"))).is_ok());
        assert!(guard.check(&asking("127.0.0.1:7700", None)).is_ok());
        for (host, origin) in [
            ("evil.example:7700", None),
            ("evil.example:7700", Some("http://evil.example:7700")),
            ("127.0.0.1:80", None),
            ("127.0.0.1", None),
            ("", None),
            ("127.0.0.1.evil.example:7700", None),
            ("127.0.0.1:7700", Some("http://evil.example")),
            ("127.0.0.1:7700", Some("null")),
            ("127.0.0.1:7700", Some("https://127.0.0.1:7700")),
            ("127.0.0.1:7700", Some("http://localhost:7700")),
        ] {
            let why = guard.check(&asking(host, origin)).expect_err(host);
            println!("{host:30} {origin:?}: {why}");
        }
        let socket = Asking { socket: true, ..asking("127.0.0.1:7700", None) };
        assert!(guard.check(&socket).is_err(), "a socket says its origin");
        let cross = Asking { site: Some("cross-site"), ..asking("127.0.0.1:7700", None) };
        assert!(guard.check(&cross).is_err());
        assert!(guard.check(&Asking { page: true, ..cross }).is_ok(), "a link to the page");
    }

    #[test]
    fn beyond_loopback_a_token_is_required() {
        let guard = Guard::new("0.0.0.0:7700".parse().unwrap(), Some("s3cret".into()));
        let with = |cookie| Asking { cookie, ..asking("192.168.1.7:7700", None) };
        assert!(guard.check(&with(None)).is_err());
        assert!(guard.check(&with(Some("tribos_lab=wrong0"))).is_err());
        assert!(guard.check(&with(Some("a=b; tribos_lab=s3cret"))).is_ok());
        let named = Asking { cookie: Some("tribos_lab=s3cret"), ..asking("lab.example:7700", None) };
        assert!(guard.check(&named).is_err());
        assert!(guard.is_token("s3cret") && !guard.is_token("s3cre") && !guard.is_token(""));
    }
}
