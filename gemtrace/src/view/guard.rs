//! Who may speak to the server: whoever knows the token, from a page of this server, under a name that is an address.
//!
//! A page of another site cannot read the token. A name that is rebound to 127.0.0.1 is refused because it is a name,
//! and a page of another site because its origin is not the host that it asks.

use axum::http::{HeaderMap, StatusCode, header};
use std::fmt::Write as _;
use std::net::IpAddr;

/// Bytes of the token: 128 bits cannot be guessed.
const BYTES: usize = 16;

/// The secret of one run of the server.
#[derive(Clone)]
pub struct Guard {
    token: String,
    /// Whether addresses other than loopback may be asked.
    open: bool,
}

impl Guard {
    /// A new secret from the system's source of randomness; `open` where others than this machine may connect.
    pub fn new(open: bool) -> Result<Self, String> {
        let mut bytes = [0; BYTES];
        getrandom::fill(&mut bytes).map_err(|e| format!("the system gives no random numbers: {e}"))?;
        let token = bytes.iter().fold(String::new(), |mut text, byte| {
            // Writing to a string cannot fail.
            let _ = write!(text, "{byte:02x}");
            text
        });
        Ok(Guard { token, open })
    }

    pub fn token(&self) -> &str {
        &self.token
    }

    /// Whether this is the token; takes as long wherever the first difference is.
    pub fn knows(&self, token: &str) -> bool {
        let differ = self.token.bytes().zip(token.bytes()).fold(0, |all, (a, b)| all | (a ^ b));
        token.len() == self.token.len() && std::hint::black_box(differ) == 0
    }

    /// Refuses a request whose host is a name that could be anyone's, or that comes from a page of another host.
    pub fn check(&self, headers: &HeaderMap) -> Result<(), (StatusCode, &'static str)> {
        let text = |name| headers.get(name).map(|value| value.to_str().unwrap_or_default());
        let mut hosts = headers.get_all(header::HOST).iter();
        let host = hosts.next().and_then(|host| host.to_str().ok()).unwrap_or_default();
        if hosts.next().is_some() || !self.is_own(host) {
            let why =
                "this server is asked by its address, such as 127.0.0.1 or localhost, and by no other name";
            return Err((StatusCode::MISDIRECTED_REQUEST, why));
        }
        match text(header::ORIGIN) {
            None => Ok(()),
            Some(origin) if origin.strip_prefix("http://") == Some(host) => Ok(()),
            Some(_) => Err((StatusCode::FORBIDDEN, "pages of other origins may not ask this server")),
        }
    }

    /// Whether a host names this machine: any port, since a tunnel may have another one.
    fn is_own(&self, host: &str) -> bool {
        let name = match host.rsplit_once(':') {
            Some((name, port)) if !port.is_empty() && port.bytes().all(|b| b.is_ascii_digit()) => name,
            _ => host,
        };
        let address = name.trim_start_matches('[').trim_end_matches(']').parse::<IpAddr>();
        name == "localhost" || address.is_ok_and(|address| self.open || address.is_loopback())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::http::HeaderValue;

    fn guard(open: bool) -> Guard {
        Guard::new(open).unwrap()
    }

    fn asked(open: bool, host: &'static str, origin: Option<&'static str>) -> bool {
        let mut headers = HeaderMap::from_iter([(header::HOST, HeaderValue::from_static(host))]);
        if let Some(origin) = origin {
            headers.insert(header::ORIGIN, HeaderValue::from_static(origin));
        }
        guard(open).check(&headers).is_ok()
    }

    #[test]
    fn a_token_is_known_as_a_whole() {
        let guard = guard(false);
        let token = guard.token().to_owned();
        assert!(token.len() == 32 && guard.knows(&token) && guard.token() != self::guard(false).token());
        for wrong in ["", &token[1..], &(token.clone() + "0"), &token.replace(char::is_numeric, "g")] {
            assert!(!guard.knows(wrong), "{wrong}");
        }
    }

    #[test]
    fn hosts_are_addresses() {
        for own in ["127.0.0.1:8000", "localhost:9", "localhost", "[::1]:8000", "127.1.2.3"] {
            assert!(asked(false, own, None), "{own}");
        }
        for foreign in
            ["", "evil.example:80", "127.0.0.1.evil.example", "192.168.0.2:80", "localhost.x", "[::2]"]
        {
            assert!(!asked(false, foreign, None), "{foreign}");
        }
        assert!(asked(true, "192.168.0.2:80", None) && !asked(true, "evil.example", None));
    }

    #[test]
    fn origins_are_the_host_itself() {
        assert!(asked(false, "localhost:9", Some("http://localhost:9")));
        for foreign in
            ["http://localhost:8", "https://localhost:9", "http://127.0.0.1:9", "null", "http://evil.example"]
        {
            assert!(!asked(false, "localhost:9", Some(foreign)), "{foreign}");
        }
    }
}
