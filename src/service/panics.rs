//! What a bug in one estimation must not take along: other recordings, other takes.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};

use anyhow::anyhow;

/// Does something and turns a panic into an error, which says what panicked.
pub(super) fn guarded<T>(act: impl FnOnce() -> anyhow::Result<T>) -> anyhow::Result<T> {
    catch_unwind(AssertUnwindSafe(act)).unwrap_or_else(|panic| {
        Err(anyhow!(
            "a bug: {}; nothing was written, please report it with the recording",
            message(panic.as_ref())
        ))
    })
}

fn message(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("the estimation panicked")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_an_error_that_says_what_panicked() {
        let of = |act: fn() -> anyhow::Result<u8>| guarded(act).map_err(|error| error.to_string());
        assert_eq!(of(|| Ok(3)), Ok(3));
        let error = of(|| {
            let none: Vec<u8> = Vec::new();
            Ok(none[std::hint::black_box(2)])
        });
        assert!(
            error.as_ref().unwrap_err().contains("index is 2"),
            "{error:?}"
        );
        assert!(
            of(|| panic!("plain"))
                .unwrap_err()
                .contains("a bug: plain;")
        );
    }
}
