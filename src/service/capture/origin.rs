//! Which pages in browsers may talk to the daemon, and by which names it is asked.
//!
//! A browser says with every WebSocket and every POST which page it is for, and with everything it asks the name
//! by which it found the daemon. Programs that are no browsers may say what they like: who directs must know the
//! daemon's token besides ([`Director::knows`](super::director::Director::knows)).

/// Pages of viewers: Foxglove's web application, and desktop applications, whose pages are files.
const KNOWN: [&str; 2] = ["https://app.foxglove.dev", "file://"];

/// The pages that may.
#[derive(Clone, Debug, Default)]
pub(super) struct Origins {
    /// Further pages that may watch.
    pages: Vec<String>,
    /// Further names of this machine.
    hosts: Vec<String>,
}

impl Origins {
    /// Those that always may watch, and further ones, `*` for every page; the names by which the daemon may be
    /// asked besides `localhost` and addresses in numbers.
    pub(super) fn new(pages: &[String], hosts: &[String]) -> Self {
        Self {
            pages: pages.to_vec(),
            hosts: hosts.to_vec(),
        }
    }

    /// Whether the daemon may be asked by that name, as the header `Host` has it. Any other name may be one that
    /// an attacker has made to lead here, so that a browser takes the daemon for the attacker's page.
    pub(super) fn is_known(&self, host: Option<&str>) -> bool {
        host.is_some_and(|host| {
            let name = name_of(host);
            let is_listed = |listed: &String| listed.eq_ignore_ascii_case(name);
            is_address(host) || self.hosts.iter().any(is_listed)
        })
    }

    fn are_listed(&self, origin: &str) -> bool {
        self.pages
            .iter()
            .any(|listed| listed == "*" || listed == origin)
    }

    /// Whether a page may watch: pages of this machine, of known viewers, and those that are listed.
    pub(super) fn may_watch(&self, origin: Option<&str>) -> bool {
        let Some(origin) = origin else {
            return true;
        };
        KNOWN.contains(&origin) || is_of_this_machine(origin) || self.are_listed(origin)
    }

    /// Whether a page may direct takes, if it knows the token: only the daemon's own, as a page that the daemon
    /// served says of itself. Pages that may watch may not direct. A program says no page.
    pub(super) fn may_direct(&self, origin: Option<&str>, host: Option<&str>) -> bool {
        let of_host = |origin: &str| {
            let mut schemes = ["http://", "https://"].into_iter();
            schemes.any(|scheme| origin.strip_prefix(scheme) == host)
        };
        self.is_known(host) && origin.is_none_or(of_host)
    }
}

/// `http://localhost:8080` and the like.
fn is_of_this_machine(origin: &str) -> bool {
    let rest = origin.strip_prefix("http://");
    let rest = rest.or_else(|| origin.strip_prefix("https://"));
    rest.is_some_and(|rest| {
        let name = name_of(rest);
        name == "localhost"
            || address(name).is_some_and(|address: std::net::IpAddr| address.is_loopback())
    })
}

/// Whether a host is `localhost` or an address in numbers, with or without a port.
fn is_address(host: &str) -> bool {
    let name = name_of(host);
    name.eq_ignore_ascii_case("localhost") || address(name).is_some()
}

/// The host without its port.
fn name_of(host: &str) -> &str {
    match host.rsplit_once(':') {
        Some((name, port)) if port.bytes().all(|byte| byte.is_ascii_digit()) => name,
        _ => host,
    }
}

fn address(name: &str) -> Option<std::net::IpAddr> {
    let inner = name
        .strip_prefix('[')
        .and_then(|name| name.strip_suffix(']'));
    inner.unwrap_or(name).parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pages_of_strangers_may_not_watch_unless_they_are_listed() {
        let (none, listed) = (
            Origins::default(),
            Origins::new(&["https://viewer.example".to_owned()], &[]),
        );
        for origin in [
            "http://localhost:8080",
            "http://127.0.0.1",
            "http://[::1]:8080",
            "https://app.foxglove.dev",
            "file://",
        ] {
            assert!(none.may_watch(Some(origin)), "{origin}");
        }
        for origin in [
            "null",
            "",
            "https://viewer.example",
            "http://localhost.evil.example",
            "http://evil.example:80",
            "http://127.0.0.1.evil.example",
            "https://app.foxglove.dev.evil.example",
            "http://192.168.0.7",
        ] {
            assert!(!none.may_watch(Some(origin)), "{origin}");
        }
        assert!(none.may_watch(None));
        assert!(listed.may_watch(Some("https://viewer.example")));
        assert!(Origins::new(&["*".to_owned()], &[]).may_watch(Some("null")));
    }

    #[test]
    fn only_the_own_page_directs() {
        let none = Origins::default();
        for host in [
            "localhost:9464",
            "127.0.0.1:9464",
            "[::1]:9464",
            "192.168.0.7:9464",
        ] {
            assert!(none.may_direct(Some(&format!("http://{host}")), Some(host)));
        }
        for (origin, host) in [
            (None, None),
            (None, Some("evil.example:9464")),
            (
                Some("http://localhost.evil.example"),
                Some("localhost.evil.example"),
            ),
            (Some("http://localhost:9464"), None),
            (Some("http://localhost:8080"), Some("localhost:9464")),
            (Some("http://evil.example:9464"), Some("evil.example:9464")),
            (Some("http://evil.example"), Some("127.0.0.1:9464")),
            (Some("null"), Some("127.0.0.1:9464")),
            (Some("file://"), Some("127.0.0.1:9464")),
        ] {
            assert!(!none.may_direct(origin, host), "{origin:?} {host:?}");
        }
        // That they may watch does not make them directors.
        let viewer = "https://viewer.example";
        for listed in ["*", viewer] {
            let of = Origins::new(&[listed.to_owned()], &[]);
            assert!(of.may_watch(Some(viewer)));
            assert!(!of.may_direct(Some(viewer), Some("127.0.0.1:9464")));
        }
        // A name that is listed is one of the daemon's.
        let named = Origins::new(&[], &["Mocap.local".to_owned()]);
        let host = Some("mocap.local:9464");
        assert!(named.is_known(host) && !none.is_known(host));
        assert!(named.may_direct(Some("http://mocap.local:9464"), host));
        assert!(!named.may_direct(Some("http://mocap.local.evil"), host));
    }
}
