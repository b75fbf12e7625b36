//! Values of a document as serde reads them, with faults that keep their place and what they are about.

use serde::de::value::{MapDeserializer, SeqDeserializer};
use serde::de::{Deserializer, Error, IntoDeserializer, Visitor};
use serde::forward_to_deserialize_any;
use std::fmt;
use toml::Spanned;
use toml::de::{DeTable, DeValue, ValueDeserializer};

/// What is wrong with a value.
#[derive(Debug)]
pub(super) enum What {
    /// A key that its table does not have, and those that it has.
    UnknownKey(String, &'static [&'static str]),
    /// Anything else, for people.
    Other(String),
}

/// A fault of a value, and where it is, bytes from the start of the document.
#[derive(Debug)]
pub(super) struct Fault {
    pub at: Option<usize>,
    pub what: What,
}

impl Fault {
    /// The innermost place is kept.
    fn at(self, offset: usize) -> Self {
        Fault { at: self.at.or(Some(offset)), ..self }
    }

    /// At the key that the table should not have.
    fn at_key_of(self, table: &DeTable) -> Self {
        let span = match &self.what {
            What::UnknownKey(key, _) => table.keys().find(|k| k.get_ref() == key).map(Spanned::span),
            What::Other(_) => None,
        };
        Fault { at: self.at.or(span.map(|span| span.start)), ..self }
    }
}

impl Error for Fault {
    fn custom<T: fmt::Display>(message: T) -> Self {
        Fault { at: None, what: What::Other(message.to_string()) }
    }

    fn unknown_field(key: &str, valid: &'static [&'static str]) -> Self {
        Fault { at: None, what: What::UnknownKey(key.to_owned(), valid) }
    }
}

impl std::error::Error for Fault {}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{:?}", self.what)
    }
}

/// A value of the document.
pub(super) struct Value<'a>(pub &'a Spanned<DeValue<'a>>);

impl<'de> IntoDeserializer<'de, Fault> for Value<'de> {
    type Deserializer = Self;

    fn into_deserializer(self) -> Self {
        self
    }
}

impl<'de> Deserializer<'de> for Value<'de> {
    type Error = Fault;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        let read = match self.0.get_ref() {
            DeValue::Array(list) => visitor.visit_seq(SeqDeserializer::new(list.iter().map(Value))),
            DeValue::Table(table) => {
                let entries = table.iter().map(|(key, value)| (key.get_ref().as_ref(), Value(value)));
                visitor
                    .visit_map(MapDeserializer::new(entries))
                    .map_err(|fault: Fault| fault.at_key_of(table))
            }
            _ => ValueDeserializer::from(self.0.clone())
                .deserialize_any(visitor)
                .map_err(|e| Fault::custom(e.message())),
        };
        read.map_err(|fault| fault.at(self.0.span().start))
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        visitor.visit_some(self)
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit
        unit_struct newtype_struct seq tuple tuple_struct map struct enum identifier ignored_any
    }
}
