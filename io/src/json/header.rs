//! The header `"collinear": KIND, "version": N` of a document, apart from its body.

use std::fmt;
use std::marker::PhantomData;

use serde::de::value::{MapAccessDeserializer, StrDeserializer};
use serde::de::{Deserialize, DeserializeSeed, Deserializer, IgnoredAny, MapAccess, Visitor};
use serde::{Deserialize as DeriveDeserialize, Serialize};

use super::object::Object;
use crate::error::{Error, ErrorKind};

const KIND: &str = "collinear";
const VERSION: &str = "version";

#[derive(DeriveDeserialize)]
struct Header {
    collinear: Option<String>,
    version: Option<u64>,
}

/// Refuses text that is no document of this kind and version.
pub(super) fn check(text: &str, kind: &'static str, version: u64) -> Result<(), Error> {
    let Object(header) = super::from_text::<Object<Header>>(text)?;
    match header.collinear {
        None => Err(ErrorKind::NotOurs { expected: kind, version }.into()),
        Some(found) if found != kind => Err(ErrorKind::WrongKind { expected: kind, found }.into()),
        Some(_) => match header.version {
            None => Err(ErrorKind::NotOurs { expected: kind, version }.into()),
            Some(found) if found != version => {
                Err(ErrorKind::Version { kind, found, supported: version }.into())
            }
            Some(_) => Ok(()),
        },
    }
}

/// The kind that a document says it is.
pub(crate) fn kind_of(text: &str) -> Result<Option<String>, Error> {
    super::from_text::<Object<Header>>(text).map(|Object(header)| header.collinear)
}

/// A document with its header, to write.
#[derive(Serialize)]
pub(super) struct Headed<'a, T> {
    pub(super) collinear: &'static str,
    pub(super) version: u64,
    #[serde(flatten)]
    pub(super) body: &'a T,
}

/// A document whose header fields are passed over, so that its body can refuse all fields it does not know.
pub(super) struct Body<T>(pub(super) T);

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Body<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(BodyVisitor(PhantomData)).map(Body)
    }
}

struct BodyVisitor<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for BodyVisitor<T> {
    type Value = T;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an object")
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<T, A::Error> {
        T::deserialize(MapAccessDeserializer::new(WithoutHeader(map)))
    }
}

struct WithoutHeader<A>(A);

impl<'de, A: MapAccess<'de>> MapAccess<'de> for WithoutHeader<A> {
    type Error = A::Error;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, A::Error> {
        let mut seed = seed;
        loop {
            // The seed runs inside the map's own call, so that an unknown key is part of the error's path.
            match self.0.next_key_seed(KeySeed(seed))? {
                None => return Ok(None),
                Some(Key::Body(key)) => return Ok(Some(key)),
                Some(Key::Header(unused)) => {
                    self.0.next_value::<IgnoredAny>()?;
                    seed = unused;
                }
            }
        }
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, A::Error> {
        self.0.next_value_seed(seed)
    }
}

enum Key<S, V> {
    Header(S),
    Body(V),
}

struct KeySeed<S>(S);

impl<'de, S: DeserializeSeed<'de>> DeserializeSeed<'de> for KeySeed<S> {
    type Value = Key<S, S::Value>;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Self::Value, D::Error> {
        let key = String::deserialize(deserializer)?;
        if key == KIND || key == VERSION {
            Ok(Key::Header(self.0))
        } else {
            self.0.deserialize(StrDeserializer::new(&key)).map(Key::Body)
        }
    }
}
