//! A TOML table laid over another.

use toml::{Table, Value};

/// Lays a table over another: tables in tables key by key, anything else in place of what was there.
pub fn lay(under: &mut Table, over: &Table) {
    for (key, value) in over {
        match (under.get_mut(key), value) {
            (Some(Value::Table(under)), Value::Table(over)) => lay(under, over),
            _ => drop(under.insert(key.clone(), value.clone())),
        }
    }
}
