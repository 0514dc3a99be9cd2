//! Access control of the server.
//!
//! - Every request must contain the secret of the address.
//! - The `Host` header must be an IP address or `localhost`, against DNS rebinding by other sites.
//! - A WebSocket can be opened only by a page of this server: its origin must be the host.

use std::{
    io,
    net::{IpAddr, SocketAddr},
};

use axum::http::{HeaderMap, StatusCode, Uri, header};

/// The address and its secret.
#[derive(Clone, Debug)]
pub struct Guard {
    address: SocketAddr,
    secret: String,
}

impl Guard {
    /// A guard of this address with a new secret of 128 bits.
    ///
    /// # Errors
    /// The system has no random numbers.
    pub fn new(address: SocketAddr) -> io::Result<Self> {
        let mut bytes = [0; 16];
        getrandom::fill(&mut bytes).map_err(io::Error::other)?;
        let secret = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        Ok(Self { address, secret })
    }

    /// The address of the page.
    pub fn url(&self) -> String {
        format!("http://{}/?key={}", self.address, self.secret)
    }

    /// Checks whether a request may be answered; the error is the status of the response.
    pub fn check(&self, uri: &Uri, headers: &HeaderMap) -> Result<(), StatusCode> {
        let host = header_text(headers, header::HOST).ok_or(StatusCode::BAD_REQUEST)?;
        if !self.is_own_name(host) {
            return Err(StatusCode::MISDIRECTED_REQUEST);
        }
        let query = uri.query().unwrap_or_default();
        let key = query.split('&').find_map(|pair| pair.strip_prefix("key="));
        match key {
            Some(key) if self.is_secret(key) => Ok(()),
            _ => Err(StatusCode::FORBIDDEN),
        }
    }

    /// Whether a WebSocket may be opened.
    pub fn check_origin(&self, headers: &HeaderMap) -> Result<(), StatusCode> {
        let host = header_text(headers, header::HOST);
        let origin = header_text(headers, header::ORIGIN).and_then(|origin| origin.strip_prefix("http://"));
        match (host, origin) {
            (Some(host), Some(origin)) if host.eq_ignore_ascii_case(origin) => Ok(()),
            _ => Err(StatusCode::FORBIDDEN),
        }
    }

    /// Whether a request names this server: by an address or as `localhost`, at any port, which a tunnel may change.
    fn is_own_name(&self, host: &str) -> bool {
        let name = match host.rsplit_once(':') {
            Some((name, port)) if port.bytes().all(|b| b.is_ascii_digit()) => name,
            _ => host,
        };
        let name = name.trim_start_matches('[').trim_end_matches(']');
        match name.parse::<IpAddr>() {
            Ok(address) => address.is_loopback() || !self.address.ip().is_loopback(),
            Err(_) => name.eq_ignore_ascii_case("localhost"),
        }
    }

    /// Compares hashes, so that the time does not depend on the place of the difference.
    fn is_secret(&self, key: &str) -> bool {
        blake3::hash(key.as_bytes()) == blake3::hash(self.secret.as_bytes())
    }
}

/// A header's only value.
fn header_text(headers: &HeaderMap, name: header::HeaderName) -> Option<&str> {
    let mut values = headers.get_all(name).iter();
    let value = values.next().filter(|_| values.next().is_none())?;
    value.to_str().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn guard(address: &str) -> Guard {
        Guard::new(address.parse().expect("an address")).expect("random numbers")
    }

    fn headers(pairs: &[(header::HeaderName, &str)]) -> HeaderMap {
        pairs
            .iter()
            .map(|(name, value)| (name.clone(), value.parse().expect("a value")))
            .collect()
    }

    #[test]
    fn a_request_needs_the_secret_and_a_name_that_nobody_else_can_have() {
        let guard = guard("127.0.0.1:4000");
        let own: Uri = guard.url().parse().expect("an address");
        let check = |uri: &Uri, host: &str| guard.check(uri, &headers(&[(header::HOST, host)]));
        for host in ["127.0.0.1:4000", "localhost:8022", "LOCALHOST", "[::1]:4000"] {
            assert_eq!(check(&own, host), Ok(()), "{host}");
        }
        for host in [
            "evil.example",
            "evil.example:4000",
            "localhost.evil.example",
            "10.0.0.1:4000",
            "",
        ] {
            assert_eq!(check(&own, host), Err(StatusCode::MISDIRECTED_REQUEST), "{host}");
        }
        for uri in ["/", "/?key=", "/?key=0", "/live?kex=1"] {
            let uri = uri.parse().expect("an address");
            assert_eq!(check(&uri, "localhost"), Err(StatusCode::FORBIDDEN), "{uri}");
        }
        assert_eq!(guard.check(&own, &HeaderMap::new()), Err(StatusCode::BAD_REQUEST));
    }

    #[test]
    fn a_socket_is_opened_by_an_own_page_only() {
        let guard = guard("127.0.0.1:4000");
        let check =
            |host: &str, origin: &str| guard.check_origin(&headers(&[(header::HOST, host), (header::ORIGIN, origin)]));
        assert_eq!(check("localhost:1", "http://localhost:1"), Ok(()));
        for origin in [
            "http://localhost:2",
            "https://localhost:1",
            "http://evil.example",
            "null",
        ] {
            assert_eq!(check("localhost:1", origin), Err(StatusCode::FORBIDDEN), "{origin}");
        }
        let without = guard.check_origin(&headers(&[(header::HOST, "localhost:1")]));
        assert_eq!(without, Err(StatusCode::FORBIDDEN));
    }

    #[test]
    fn one_that_listens_to_others_goes_by_addresses_too() {
        let guard = guard("0.0.0.0:4000");
        assert!(guard.is_own_name("10.0.0.1:4000") && guard.is_own_name("[fe80::1]:4000"));
        assert!(!guard.is_own_name("render.example:4000"));
    }

    #[test]
    fn secrets_are_long_and_new() {
        let [a, b] = [(); 2].map(|()| guard("127.0.0.1:1").url());
        assert_ne!(a, b);
        assert_eq!(a.split_once("key=").expect("a key").1.len(), 32);
    }
}
