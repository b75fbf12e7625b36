//! Tables of a TOML document read key by key, so that every complaint has a line, and no key goes unread.

use super::value::{Fault, Value, What};
use crate::Error;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use spectral_core::{nearest_name, shown};
use std::cell::RefCell;
use std::path::Path;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The text of a scene and where it stands.
#[derive(Clone, Copy)]
pub(crate) struct Document<'a> {
    pub path: &'a Path,
    pub text: &'a str,
}

impl Document<'_> {
    /// An error at a byte of the text.
    pub fn error(&self, offset: usize, message: impl ToString) -> Error {
        let before = self.text.as_bytes().get(..offset).unwrap_or(self.text.as_bytes());
        let line = before.iter().filter(|b| **b == b'\n').count() + 1;
        Error::Scene { path: self.path.to_owned(), line, message: message.to_string() }
    }

    /// An error of the TOML parser.
    pub fn toml_error(&self, error: &toml::de::Error) -> Error {
        self.error(error.span().map_or(0, |s| s.start), readable(error.message()))
    }

    /// A fault of a value that begins at `offset`.
    fn fault(&self, offset: usize, fault: Fault) -> Error {
        let message = match fault.what {
            What::UnknownKey(key, valid) => unknown_key(&key, valid, ""),
            What::Other(message) => readable(&message),
        };
        self.error(fault.at.unwrap_or(offset), message)
    }
}

/// Another crate's message in one line, with our quotes.
fn readable(message: &str) -> String {
    let message: String = message.trim().chars().take(500).collect();
    message.replace('\n', ", ").replace('`', "'")
}

fn unknown_key(key: &str, valid: &[&str], place: &str) -> String {
    let hint = match nearest_name(key, valid.iter().copied()) {
        Some(near) => format!("did you mean '{near}'?"),
        None => format!("valid: {}", valid.join(", ")),
    };
    format!("unknown key '{}'{place}; {hint}", shown(key))
}

/// One table, and the keys of it that were asked for.
pub(crate) struct Fields<'a> {
    pub document: Document<'a>,
    /// As a person would write it: `[camera]`.
    pub name: String,
    /// Where it begins, bytes.
    pub offset: usize,
    table: &'a DeTable<'a>,
    asked: RefCell<Vec<&'static str>>,
}

impl<'a> Fields<'a> {
    pub fn new(
        document: Document<'a>,
        name: impl Into<String>,
        offset: usize,
        table: &'a DeTable<'a>,
    ) -> Self {
        Fields { document, name: name.into(), offset, table, asked: RefCell::default() }
    }

    /// An error at the table's head.
    pub fn error(&self, message: impl ToString) -> Error {
        self.document.error(self.offset, message)
    }

    /// The value of a key, if it is there.
    pub fn get(&self, key: &'static str) -> Option<Entry<'a>> {
        self.asked.borrow_mut().push(key);
        let (name, value) = self.table.get_key_value(key)?;
        Some(Entry {
            document: self.document,
            key: key.into(),
            table: self.name.clone(),
            at: name.span().start,
            value,
        })
    }

    /// The value of a key that must be there; `expected` says what it is.
    pub fn need(&self, key: &'static str, expected: &str) -> Result<Entry<'a>, Error> {
        self.get(key).ok_or_else(|| self.error(format!("{} needs '{key}': {expected}", self.name)))
    }

    /// The one of several keys that is there, or `None`; two of them are an error.
    pub fn one_of(&self, keys: &[&'static str]) -> Result<Option<(&'static str, Entry<'a>)>, Error> {
        let mut found: Vec<_> = keys.iter().filter_map(|key| Some((*key, self.get(key)?))).collect();
        found.sort_by_key(|(_, entry)| entry.at);
        match found.as_slice() {
            [(a, _), (b, second), ..] => {
                let all = either(keys);
                Err(second
                    .error(format!("{} has both '{a}' and '{b}'; it takes exactly one of {all}", self.name)))
            }
            _ => Ok(found.pop()),
        }
    }

    /// All keys and values as they stand, for tables whose keys are names.
    pub fn entries(&self) -> impl Iterator<Item = Entry<'a>> + '_ {
        let mut all: Vec<_> = self.table.iter().collect();
        all.sort_by_key(|(name, _)| name.span().start);
        all.into_iter().map(|(name, value)| Entry {
            document: self.document,
            key: name.get_ref().to_string(),
            table: self.name.clone(),
            at: name.span().start,
            value,
        })
    }

    /// Refuses keys that were never asked for.
    pub fn finish(&self) -> Result<(), Error> {
        let asked = self.asked.borrow();
        let mut unread: Vec<_> =
            self.table.keys().filter(|key| !asked.iter().any(|a| *a == key.get_ref().as_ref())).collect();
        unread.sort_by_key(|key| key.span().start);
        match unread.first() {
            Some(key) => {
                let message = unknown_key(key.get_ref(), &asked, &format!(" in {}", self.name));
                Err(self.document.error(key.span().start, message))
            }
            None => Ok(()),
        }
    }

    /// The core's complaint, at the key that it is about, or at the table's head.
    pub fn blame(&self, error: spectral_core::Error) -> Error {
        let about = match &error {
            spectral_core::Error::Value { what, .. } => what.as_str(),
            _ => "",
        };
        // The core names a quantity by the keys that lead to it, after the name of a stone or a material: the first that
        // stands in this table is meant.
        let word = |c: char| !c.is_alphanumeric() && c != '_';
        let path = about.rsplit(": ").next().unwrap_or_default();
        let key = path.split(word).find_map(|w| self.table.keys().find(|key| key.get_ref() == w));
        self.document.error(key.map_or(self.offset, |k| k.span().start), error)
    }
}

/// `"'a', 'b' and 'c'"`.
pub(crate) fn either(keys: &[&str]) -> String {
    let quoted: Vec<String> = keys.iter().map(|k| format!("'{k}'")).collect();
    match quoted.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} and {last}", rest.join(", ")),
        _ => quoted.concat(),
    }
}

/// One value, with its key.
pub(crate) struct Entry<'a> {
    pub document: Document<'a>,
    pub key: String,
    /// The table it stands in.
    table: String,
    /// Where its key begins, bytes.
    pub at: usize,
    pub value: &'a Spanned<DeValue<'a>>,
}

impl<'a> Entry<'a> {
    /// An error at this key.
    pub fn error(&self, message: impl ToString) -> Error {
        self.document.error(self.at, message)
    }

    /// What was written is not `expected`.
    pub fn refuse(&self, expected: &str) -> Error {
        let span = self.value.span();
        let text = self.document.text.get(span.clone()).unwrap_or_default();
        // Inline values are shown as they stand; a table with a header of its own would show its header.
        let value: String = match self.value.get_ref() {
            DeValue::Table(_) if !text.starts_with('{') => "a table".into(),
            DeValue::Array(_) if !text.starts_with('[') || text.starts_with("[[") => "a list".into(),
            _ => shown(&text.split_whitespace().collect::<Vec<_>>().join(" ")),
        };
        let (key, table) = (shown(&self.key), &self.table);
        self.error(format!("{key} = {value} in {table}: expected {expected}"))
    }

    /// Anything that serde can read from the value.
    pub fn read<T: DeserializeOwned>(&self) -> Result<T, Error> {
        T::deserialize(Value(self.value)).map_err(|fault| self.document.fault(self.at, fault))
    }

    /// A finite number; `expected` says of what.
    pub fn number(&self, expected: &str) -> Result<f64, Error> {
        finite(self.value).ok_or_else(|| self.refuse(expected))
    }

    /// A list of finite numbers of any length.
    pub fn numbers(&self, expected: &str) -> Result<Vec<f64>, Error> {
        let list = self.value.get_ref().as_array().ok_or_else(|| self.refuse(expected))?;
        list.iter().map(|v| finite(v).ok_or_else(|| self.refuse(expected))).collect()
    }

    /// `N` finite numbers.
    pub fn vector<const N: usize>(&self, expected: &str) -> Result<[f64; N], Error> {
        self.numbers(expected)?.try_into().map_err(|_| self.refuse(expected))
    }

    /// The values of a list, each under this key.
    #[cfg(feature = "batch")]
    pub fn list(&self, expected: &str) -> Result<Vec<Entry<'a>>, Error> {
        let list = self.value.get_ref().as_array().ok_or_else(|| self.refuse(expected))?;
        let entry = |value: &'a Spanned<DeValue<'a>>| Entry {
            document: self.document,
            key: self.key.clone(),
            table: self.table.clone(),
            at: value.span().start,
            value,
        };
        Ok(list.iter().map(entry).collect())
    }

    /// A whole number that `T` can hold.
    pub fn whole<T: TryFrom<i64>>(&self, expected: &str) -> Result<T, Error> {
        let DeValue::Integer(_) = self.value.get_ref() else { return Err(self.refuse(expected)) };
        let number = i64::deserialize(Value(self.value)).ok();
        number.and_then(|n| T::try_from(n).ok()).ok_or_else(|| self.refuse(expected))
    }

    /// A string.
    pub fn text(&self, expected: &str) -> Result<&'a str, Error> {
        self.value.get_ref().as_str().ok_or_else(|| self.refuse(expected))
    }

    /// True or false.
    pub fn flag(&self) -> Result<bool, Error> {
        self.value.get_ref().as_bool().ok_or_else(|| self.refuse("true or false"))
    }

    /// A table, called `name` in messages.
    pub fn fields(&self, name: impl Into<String>) -> Result<Fields<'a>, Error> {
        match self.value.get_ref() {
            DeValue::Table(table) => Ok(Fields::new(self.document, name, self.at, table)),
            _ => Err(self.refuse("a table")),
        }
    }

    /// A list of tables, each called `name` in messages.
    pub fn tables(&self, name: &str) -> Result<Vec<Fields<'a>>, Error> {
        let refuse = || self.refuse(&format!("tables, each under its own {name}"));
        let list = self.value.get_ref().as_array().ok_or_else(refuse)?;
        list.iter()
            .map(|item| match item.get_ref() {
                DeValue::Table(table) => Ok(Fields::new(self.document, name, item.span().start, table)),
                _ => Err(refuse()),
            })
            .collect()
    }
}

fn finite<'a>(value: &'a Spanned<DeValue<'a>>) -> Option<f64> {
    match value.get_ref() {
        DeValue::Integer(_) | DeValue::Float(_) => {
            f64::deserialize(Value(value)).ok().filter(|v| v.is_finite())
        }
        _ => None,
    }
}
