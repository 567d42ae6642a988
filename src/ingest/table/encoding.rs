//! Bytes become text, in the encodings in which programs write tables.

/// A text, and in which encoding it was.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TableText {
    /// The text.
    pub text: String,
    /// What was taken for granted of its bytes, where they are not UTF-8.
    pub note: Option<String>,
}

/// So many bytes tell whether each second one is zero.
const LOOKED_AT: usize = 256;

/// The text of bytes: UTF-8, UTF-16 with or without a mark, or else Latin-1; `None` where they are no text.
pub fn table_text(bytes: Vec<u8>) -> Option<TableText> {
    if let Some(is_little) = utf16_order(&bytes) {
        let unit = |pair: &[u8]| match is_little {
            true => u16::from_le_bytes([pair[0], pair[1]]),
            false => u16::from_be_bytes([pair[0], pair[1]]),
        };
        let units: Vec<u16> = bytes.chunks_exact(2).map(unit).collect();
        let text = String::from_utf16(&units)
            .ok()
            .filter(|text| !text.contains('\0'))?;
        let note = Some("the text is UTF-16".to_owned());
        return Some(TableText { text, note });
    }
    match String::from_utf8(bytes) {
        Ok(text) => (!text.contains('\0')).then_some(TableText { text, note: None }),
        Err(error) => {
            let bytes = error.into_bytes();
            let is_control =
                |byte: &u8| *byte < b' ' && !matches!(byte, b'\t' | b'\n' | b'\r' | 0x0c | 0x1a);
            if bytes.iter().any(is_control) {
                return None;
            }
            Some(TableText {
                text: bytes.into_iter().map(char::from).collect(),
                note: Some("the text is no UTF-8: taken for Latin-1".to_owned()),
            })
        }
    }
}

/// Whether bytes are UTF-16, little-endian or big-endian: by their mark, or by zeros at each second byte.
fn utf16_order(bytes: &[u8]) -> Option<bool> {
    match bytes {
        [0xff, 0xfe, ..] => return Some(true),
        [0xfe, 0xff, ..] => return Some(false),
        _ => {}
    }
    let looked_at = &bytes[..bytes.len().min(LOOKED_AT) & !1];
    let zeros = |odd: usize| {
        looked_at
            .iter()
            .skip(odd)
            .step_by(2)
            .filter(|of| **of == 0)
            .count()
    };
    let half = looked_at.len() / 2;
    if half < 4 {
        return None;
    }
    match (zeros(0), zeros(1)) {
        (0, odd) if odd == half => Some(true),
        (even, 0) if even == half => Some(false),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn texts_of_several_encodings_are_the_same() {
        let text = "t,x [m],Winkel [°]\n0,1,2\n";
        let units = || text.encode_utf16();
        let little: Vec<u8> = units().flat_map(u16::to_le_bytes).collect();
        let big: Vec<u8> = units().flat_map(u16::to_be_bytes).collect();
        let latin: Vec<u8> = text.chars().map(|of| of as u8).collect();
        for bytes in [
            text.as_bytes().to_vec(),
            [&[0xff, 0xfe][..], &little].concat(),
            [&[0xfe, 0xff][..], &big].concat(),
            little,
            big,
            latin,
        ] {
            let found = table_text(bytes.clone()).unwrap_or_else(|| panic!("{bytes:?}"));
            assert_eq!(found.text.trim_start_matches('\u{feff}'), text);
            assert_eq!(found.note.is_none(), bytes == text.as_bytes());
        }
        assert_eq!(table_text(vec![0x89, b'P', 0xff, 0]), None);
    }

    proptest! {
        #[test]
        fn any_bytes_are_answered(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
            let _ = table_text(bytes);
        }
    }
}
