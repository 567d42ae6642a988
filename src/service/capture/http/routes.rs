//! Which answer there is to which request.

use std::sync::atomic::Ordering;
use std::sync::{Arc, LazyLock};
use std::time::Instant;

use serde_json::json;

use super::super::director::DirectorOrder;
use super::reply::{ACTING_POLICY, PICTURE_POLICY, Reply, refusal, the_header};
use super::{BODY_BYTES, Pages, RequestTarget};
use crate::page::PLAYER;

/// The operator's page, with the script that plays motions.
static PAGE: LazyLock<String> =
    LazyLock::new(|| include_str!("../operator.html").replace("/* player */", PLAYER));

/// Where the acting page is asked for and not served.
const NOT_SERVED: &str = "the acting page is not served: begin `enact capture` with --acting\n";

impl Pages {
    /// The reply to a request with that body; `None` while the body is incomplete.
    pub(super) fn page(
        &self,
        request: &httparse::Request,
        body: &[u8],
        target: RequestTarget,
    ) -> Option<Reply> {
        let RequestTarget { path, is_get } = target;
        if !self.origins.is_known(the_header(request.headers, "host")) {
            return Some(Reply::text(
                "421 Misdirected Request",
                "421 Misdirected Request: ask for an address in numbers or for localhost, or list the name \
                 in the scene, [capture] hosts\n"
                    .to_owned(),
            ));
        }
        if self.is_acting_alone && !["/act", "/motion/"].iter().any(|of| path.starts_with(of)) {
            return Some(refusal("404 Not Found"));
        }
        Some(match path {
            "/take" if request.method == Some("POST") => return self.take(request.headers, body),
            "/" | "/state" | "/take" | "/health" | "/metrics" if !is_get || path == "/take" => {
                refusal("405 Method Not Allowed")
            }
            "/" => Reply::ok("text/html; charset=utf-8", PAGE.as_bytes()),
            "/state" => Reply::ok("application/json", self.state().into_bytes()),
            "/health" => self.health(),
            "/metrics" => Reply::text("200 OK", self.metrics.text(&self.status.borrow())),
            _ if is_get => self.file(path).unwrap_or_else(|| refusal("404 Not Found")),
            _ => refusal("404 Not Found"),
        })
    }

    /// A file of the acting page, or of a take.
    fn file(&self, path: &str) -> Option<Reply> {
        let numbered = |before, after| {
            let number = path.strip_prefix(before)?.strip_suffix(after)?;
            number.parse::<u64>().ok()
        };
        let glb = |bytes| Reply::ok("model/gltf-binary", bytes);
        if let Some(take) = numbered("/picture/", ".svg") {
            let picture = self.metrics.history.picture(take)?;
            return Some(Reply {
                policy: PICTURE_POLICY,
                ..Reply::ok("image/svg+xml", picture)
            });
        }
        if let Some(take) = numbered("/motion/", ".glb") {
            return self.metrics.history.motion(take).map(glb);
        }
        let acting = self.acting.as_ref();
        match path {
            "/act" => Some(match acting {
                Some(acting) => Reply {
                    policy: ACTING_POLICY,
                    ..Reply::ok("text/html; charset=utf-8", Arc::clone(&acting.html))
                },
                None => Reply::text("404 Not Found", NOT_SERVED.to_owned()),
            }),
            "/act/scene.glb" => acting.map(|acting| glb(Arc::clone(&acting.scene))),
            _ => None,
        }
    }

    fn health(&self) -> Reply {
        const BAD: &str = "503 Service Unavailable";
        if self.stop.load(Ordering::Relaxed) {
            return Reply::text(BAD, "draining\n".to_owned());
        }
        let troubles = self.metrics.health.troubles(Instant::now());
        if troubles.is_empty() {
            return Reply::text("200 OK", "ready\n".to_owned());
        }
        Reply::text(BAD, format!("{}\n", troubles.join("\n")))
    }

    /// Everything that the page shows.
    fn state(&self) -> String {
        let status = self.status.borrow();
        json!({
            "status": &*status,
            "troubles": self.metrics.health.troubles(Instant::now()),
            "events": self.director.events(),
            "takes": self.metrics.history.takes(),
            "acts": self.acting.is_some(),
            "free_bytes": self.metrics.health.free_bytes(),
        })
        .to_string()
    }

    /// The reply to an order; `None` while its body is incomplete.
    fn take(&self, headers: &[httparse::Header], body: &[u8]) -> Option<Reply> {
        let header = |name: &str| the_header(headers, name);
        let is_own = self.origins.may_direct(header("origin"), header("host"));
        if !is_own || !self.director.knows(header("authorization")) {
            return Some(Reply::text(
                "403 Forbidden",
                "this may only watch: to direct, open the link that `enact take status` prints\n"
                    .to_owned(),
            ));
        }
        let length = header("content-length").map(str::parse);
        let Some(Ok(length)) = length else {
            return Some(refusal("411 Length Required"));
        };
        if length > BODY_BYTES {
            return Some(refusal("413 Content Too Large"));
        }
        let body = body.get(..length)?;
        let order: DirectorOrder = match serde_json::from_slice(body) {
            Ok(order) => order,
            Err(error) => {
                return Some(Reply::text(
                    "400 Bad Request",
                    format!("no order: {error}\n"),
                ));
            }
        };
        Some(match self.director.order(&order) {
            Ok(()) => Reply::text("202 Accepted", "handed on\n".to_owned()),
            Err(why) => Reply::text("409 Conflict", format!("{why}\n")),
        })
    }
}
