//! Reads a TOML text into a type, and refuses lists with too many or too few numbers in them.
//!
//! What a list of a fixed length does not take, the deserialiser leaves out without a word: of
//! `gravity_m_s2 = [0, 0, -9,80665]`, with a comma for a decimal point, it takes −9. How long lists are is in the
//! schema of the type, so that no list of any key is forgotten.

use std::ops::Range;

use schemars::{JsonSchema, schema_for};
use serde::de::DeserializeOwned;
use serde_json::Value;
use toml::de::{DeTable, DeValue, Deserializer};

use super::error::{Fault, SceneError, fault};

/// Nesting of schemas within one value that is followed; ours have two or three.
const DEPTH: usize = 16;

/// The text as that type. Fails with the place of the first error.
pub(super) fn read<T: DeserializeOwned + JsonSchema>(text: &str) -> Result<T, SceneError> {
    let of_toml = |error: toml::de::Error| SceneError::from_toml(text, &error);
    let table = DeTable::parse(text).map_err(of_toml)?;
    let schema = schema_for!(T);
    let lengths = Lengths {
        root: schema.as_value(),
    };
    let looked = lengths.of_table(&[schema.as_value()], table.get_ref());
    looked.map_err(|fault| SceneError::from_fault(text, fault))?;
    T::deserialize(Deserializer::from(table)).map_err(of_toml)
}

/// How long lists are.
struct Lengths<'a> {
    root: &'a Value,
}

impl<'a> Lengths<'a> {
    /// What a value may be: the schema itself, or what it refers to or chooses among.
    fn alternatives(&self, schema: &'a Value, depth: usize, into: &mut Vec<&'a Value>) {
        if depth > DEPTH {
            return;
        }
        if let Some(name) = schema.get("$ref").and_then(Value::as_str) {
            let pointer = name.trim_start_matches('#');
            if let Some(of) = self.root.pointer(pointer) {
                self.alternatives(of, depth + 1, into);
            }
        }
        for key in ["anyOf", "oneOf", "allOf"] {
            let choices = schema.get(key).and_then(Value::as_array);
            for choice in choices.into_iter().flatten() {
                self.alternatives(choice, depth + 1, into);
            }
        }
        into.push(schema);
    }

    /// Looks at the values of a table that has one of those schemas.
    fn of_table(&self, schemas: &[&'a Value], table: &DeTable) -> Result<(), Fault> {
        for (key, value) in table {
            let key = key.get_ref();
            let mut found = Vec::new();
            for schema in schemas {
                let of_key = |properties: &'a Value| properties.get(key.as_ref());
                let own = schema.get("properties").and_then(of_key);
                let any = schema.get("additionalProperties");
                if let Some(of) = own.or(any.filter(|any| any.is_object())) {
                    self.alternatives(of, 0, &mut found);
                }
            }
            self.of_value(&found, key, value.get_ref(), value.span())?;
        }
        Ok(())
    }

    fn of_value(
        &self,
        schemas: &[&'a Value],
        key: &str,
        value: &DeValue,
        span: Range<usize>,
    ) -> Result<(), Fault> {
        match value {
            DeValue::Table(table) => self.of_table(schemas, table),
            DeValue::Array(array) => {
                let lists = schemas.iter().filter(|of| of.get("items").is_some());
                // It must be one of the lists that it may be; that it may be none is said when it is read.
                let mut refused = None;
                for list in lists {
                    match self.of_list(list, key, array, span.clone()) {
                        Ok(()) => return Ok(()),
                        Err(why) => refused = refused.or(Some(why)),
                    }
                }
                refused.map_or(Ok(()), Err)
            }
            _ => Ok(()),
        }
    }

    fn of_list(
        &self,
        schema: &'a Value,
        key: &str,
        array: &[toml::Spanned<DeValue>],
        span: Range<usize>,
    ) -> Result<(), Fault> {
        let bound = |name: &str| {
            let bound = schema.get(name).and_then(Value::as_u64);
            bound.and_then(|bound| usize::try_from(bound).ok())
        };
        let (least, most) = (bound("minItems"), bound("maxItems"));
        let (found, are_numbers) = (array.len(), array.iter().all(|of| is_number(of.get_ref())));
        let what = if are_numbers { "numbers" } else { "values" };
        if let Some((expected, extra)) = most.and_then(|most| Some((most, array.get(most)?))) {
            let hint = match are_numbers {
                true => {
                    ": a decimal is written with a point, as in 9.81, and a comma begins the next number"
                }
                false => "",
            };
            let said = format!("`{key}` has {found} {what}, expected {expected}{hint}");
            return fault(extra.span(), said);
        }
        if let Some(expected) = least.filter(|least| found < *least) {
            return fault(
                span,
                format!("`{key}` has {found} {what}, expected {expected}"),
            );
        }
        let mut items = Vec::new();
        if let Some(of) = schema.get("items") {
            self.alternatives(of, 0, &mut items);
        }
        for item in array {
            self.of_value(&items, key, item.get_ref(), item.span())?;
        }
        Ok(())
    }
}

fn is_number(value: &DeValue) -> bool {
    matches!(value, DeValue::Integer(_) | DeValue::Float(_))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, serde::Deserialize, JsonSchema)]
    #[expect(dead_code, reason = "it is read and not looked at")]
    struct Outer {
        #[serde(default)]
        row: Vec<Inner>,
        #[serde(default)]
        named: std::collections::BTreeMap<String, [f64; 2]>,
        either: Option<Either>,
    }

    #[derive(Debug, serde::Deserialize, JsonSchema)]
    #[expect(dead_code, reason = "it is read and not looked at")]
    struct Inner {
        points: Vec<[f64; 3]>,
    }

    #[derive(Debug, serde::Deserialize, JsonSchema)]
    #[serde(untagged)]
    enum Either {
        _One(#[expect(dead_code, reason = "it is read and not looked at")] f64),
        _Two(#[expect(dead_code, reason = "it is read and not looked at")] [f64; 2]),
    }

    #[test]
    fn lists_have_as_many_numbers_as_are_taken_wherever_they_are() {
        for right in [
            "[[row]]\npoints = [[1, 2, 3], [4, 5, 6]]\n",
            "named = { a = [1, 2.5] }\neither = 3\n",
            "either = [1, 2]\n",
        ] {
            read::<Outer>(right).unwrap_or_else(|error| panic!("{error}"));
        }
        for (wrong, place, said) in [
            (
                "[[row]]\npoints = [[1, 2, 3], [4, 5,5, 6]]\n",
                (2, 31),
                "has 4 numbers, expected 3",
            ),
            (
                "[[row]]\npoints = [[1, 2]]\n",
                (2, 11),
                "`points` has 2 numbers, expected 3",
            ),
            (
                "named = { a = [1, 2, 3] }\n",
                (1, 22),
                "`a` has 3 numbers, expected 2",
            ),
            ("named.a = [1]\n", (1, 11), "has 1 numbers, expected 2"),
            (
                "either = [1, 2, 3, 4]\n",
                (1, 17),
                "has 4 numbers, expected 2: a decimal",
            ),
        ] {
            let error = read::<Outer>(wrong).expect_err(wrong);
            assert_eq!((error.line, error.column), place, "{error}");
            assert!(error.message.contains(said), "{error}");
        }
    }
}
