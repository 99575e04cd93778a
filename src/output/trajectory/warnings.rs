//! Warnings of the chemfiles library: kept here until someone prints them, each once.

use std::collections::BTreeSet;
use std::sync::{Mutex, Once, PoisonError};

#[derive(Default)]
struct Heard {
    before: BTreeSet<String>,
    new: Vec<String>,
}

static HEARD: Mutex<Option<Heard>> = Mutex::new(None);
static LISTEN: Once = Once::new();

/// From now on chemfiles writes nothing to standard error.
pub(super) fn collect() {
    LISTEN.call_once(|| {
        chemfiles::set_warning_callback(|message| {
            let mut heard = HEARD.lock().unwrap_or_else(PoisonError::into_inner);
            let heard = heard.get_or_insert_default();
            if heard.before.insert(message.to_string()) {
                heard.new.push(message.to_string());
            }
        });
    });
}

/// Warnings not taken yet.
pub(super) fn take() -> Vec<String> {
    let mut heard = HEARD.lock().unwrap_or_else(PoisonError::into_inner);
    heard.as_mut().map(|heard| std::mem::take(&mut heard.new)).unwrap_or_default()
}
