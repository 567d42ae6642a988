//! What a director says of a take: its name, a note, a rating. It goes into the recording, as the
//! metadata record `take`, and with it into the estimate.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::ingest::live::LabelRecord;

/// Ratings that there are.
const RATINGS: std::ops::RangeInclusive<u32> = 1..=5;

/// What was said of a take.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct TakeLabel {
    /// Its name.
    pub name: Option<String>,
    /// A note.
    pub note: Option<String>,
    /// 1 (bad) to 5 (good).
    pub rating: Option<u32>,
}

impl TakeLabel {
    /// Takes over what a record says. Fails, in words, for what is no label.
    pub(super) fn take(&mut self, record: &LabelRecord) -> Result<(), String> {
        let (name, note) = record.texts().ok_or("a name or note that is not UTF-8")?;
        let given = |text: &str| (!text.is_empty()).then(|| text.to_owned());
        let rating = match record.rating {
            0 => None,
            rating if RATINGS.contains(&rating) => Some(rating),
            rating => return Err(format!("a rating of {rating}, expected 1 to 5")),
        };
        self.name = given(name).or(self.name.take());
        self.note = given(note).or(self.note.take());
        self.rating = rating.or(self.rating);
        Ok(())
    }

    /// The pairs of the metadata record of a take of that number.
    pub(super) fn pairs(&self, number: u64) -> BTreeMap<String, String> {
        let rating = self.rating.map(|rating| rating.to_string());
        let pairs = [
            ("number", Some(number.to_string())),
            ("name", self.name.clone()),
            ("note", self.note.clone()),
            ("rating", rating),
        ];
        let given = pairs.into_iter();
        given
            .filter_map(|(key, value)| Some((key.to_owned(), value?)))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_later_word_holds_and_garbage_changes_nothing() {
        let mut label = TakeLabel::default();
        let said = |name: &str, note: &str, rating| LabelRecord::new(1, 0, name, note, rating);
        assert_eq!(label.take(&said("Wurf ü", "", 0)), Ok(()));
        assert_eq!(label.take(&said("", "too slow", 2)), Ok(()));
        let before = label.clone();
        assert!(label.take(&said("other", "", 6)).is_err());
        let mut garbage = said("", "", 3);
        garbage.name = [0xff; 256];
        assert!(label.take(&garbage).is_err());
        assert_eq!(label, before);
        let pairs: Vec<(String, String)> = label.pairs(7).into_iter().collect();
        let expected = [
            ("name", "Wurf ü"),
            ("note", "too slow"),
            ("number", "7"),
            ("rating", "2"),
        ];
        assert_eq!(pairs, expected.map(|(k, v)| (k.to_owned(), v.to_owned())));
    }
}
