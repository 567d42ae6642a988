//! Elements of the description: children, attributes, numbers, each with its place in the text.

use std::collections::BTreeMap;
use std::ops::Range;

use crate::config::spanned::Spanned;
use nalgebra::{UnitQuaternion, Vector3};
use roxmltree::{Attribute, Node};

use crate::config::error::{Fault, fault};
use crate::config::number;
use crate::math::Pose;

/// Greatest number: products of several stay finite. Some write 1e16 for a limit that is none.
const GREATEST: f64 = 1e20;

/// Sentences that are kept; what is beyond is counted.
const SENTENCES: usize = 100;

/// What is not read: sentences, each with the place where it is first true and how often it is.
#[derive(Debug, Default)]
pub(super) struct Notes {
    /// In the order in which they came, with their places and counts.
    kept: Vec<(String, usize, usize)>,
    /// Where a sentence is among those.
    places: BTreeMap<String, usize>,
    /// Times that another was said for which there was no place.
    beyond: usize,
}

impl Notes {
    /// Notes a sentence at a place of the text.
    pub(super) fn add(&mut self, span: &Range<usize>, said: String) {
        match self.places.get(&said) {
            Some(place) => self.kept[*place].2 += 1,
            None if self.kept.len() < SENTENCES => {
                self.places.insert(said.clone(), self.kept.len());
                self.kept.push((said, span.start, 1));
            }
            None => self.beyond += 1,
        }
    }

    /// As lines, each with its place in the text.
    pub(super) fn lines(&self, text: &str) -> Vec<String> {
        let line = |(said, start, count): &(String, usize, usize)| {
            let line = text.as_bytes().iter().take(*start);
            let line = 1 + line.filter(|byte| **byte == b'\n').count();
            match count {
                1 => format!("line {line}: {said}"),
                _ => format!("line {line}: {said}, {count} times in all"),
            }
        };
        let mut lines: Vec<String> = self.kept.iter().map(line).collect();
        if self.beyond > 0 {
            lines.push(format!("and {} more of the kind", self.beyond));
        }
        lines
    }
}

/// An element with the notes of all.
pub(super) struct Element<'a, 'input, 'n> {
    node: Node<'a, 'input>,
    pub(super) notes: &'n mut Notes,
}

impl<'a, 'input, 'n> Element<'a, 'input, 'n> {
    pub(super) fn new(node: Node<'a, 'input>, notes: &'n mut Notes) -> Self {
        Self { node, notes }
    }

    /// Its name.
    pub(super) fn tag(&self) -> &'a str {
        self.node.tag_name().name()
    }

    /// Its place.
    pub(super) fn span(&self) -> Range<usize> {
        self.node.range()
    }

    /// An error at this element.
    pub(super) fn fault<T>(&self, said: impl Into<String>) -> Result<T, Fault> {
        fault(self.span(), said)
    }

    /// Notes its attributes beside the known ones.
    pub(super) fn only(&mut self, known: &[&str]) -> &mut Self {
        for attribute in self.node.attributes() {
            if !known.contains(&attribute.name()) {
                let said = format!(
                    "{} of <{}> is not read",
                    attribute.name(),
                    self.node.tag_name().name()
                );
                self.notes.add(&attribute.range(), said);
            }
        }
        self
    }

    /// Visits its children; each says whether it was known, or it is noted.
    pub(super) fn children(
        &mut self,
        mut visit: impl FnMut(&mut Element<'a, 'input, '_>) -> Result<bool, Fault>,
    ) -> Result<(), Fault> {
        for node in self.node.children() {
            if node.is_text() && !node.text().unwrap_or_default().trim().is_empty() {
                let said = format!("text in <{}> is not read", self.tag());
                self.notes.add(&node.range(), said);
            }
            if !node.is_element() {
                continue;
            }
            let mut child = Element::new(node, self.notes);
            if !visit(&mut child)? {
                let said = format!("<{}> in <{}> is not read", child.tag(), self.tag());
                self.notes.add(&node.range(), said);
            }
        }
        Ok(())
    }

    /// Fails where a child that may come once came already.
    pub(super) fn once<T>(&self, before: &Option<T>) -> Result<(), Fault> {
        match before {
            None => Ok(()),
            Some(_) => self.fault(format!("a second <{}>, expected one", self.tag())),
        }
    }

    fn attribute(&self, key: &str) -> Option<Attribute<'a, 'input>> {
        self.node.attributes().find(|of| of.name() == key)
    }

    /// An attribute's text.
    pub(super) fn text(&self, key: &str) -> Result<Spanned<String>, Fault> {
        match self.attribute(key) {
            Some(of) => Ok(Spanned::new(of.range(), of.value().to_owned())),
            None => self.fault(format!("<{}> has no {key}, expected one", self.tag())),
        }
    }

    /// An attribute's text as a name that scenes can have.
    pub(super) fn name(&self, key: &str) -> Result<Spanned<String>, Fault> {
        let text = self.text(key)?;
        number::name(self.tag(), &text)?;
        Ok(text)
    }

    /// So many numbers with spaces between; `None` where there is no such attribute.
    fn numbers<const N: usize>(&self, key: &str) -> Result<Option<[f64; N]>, Fault> {
        let Some(attribute) = self.attribute(key) else {
            return Ok(None);
        };
        let number = |text: &str| text.parse::<f64>().ok().filter(|of| of.abs() <= GREATEST);
        let numbers: Option<Vec<f64>> = attribute.value().split_whitespace().map(number).collect();
        match numbers.map(<[f64; N]>::try_from) {
            Some(Ok(numbers)) => Ok(Some(numbers)),
            _ => {
                let expected = match N {
                    1 => "a number".to_owned(),
                    _ => format!("{N} numbers with spaces between them"),
                };
                let said = format!(
                    "{key} of <{}> is {:?}, expected {expected}, none beyond {GREATEST:e}",
                    self.tag(),
                    attribute.value()
                );
                fault(attribute.range(), said)
            }
        }
    }

    /// A number; `None` where there is no such attribute.
    pub(super) fn number_if(&self, key: &str) -> Result<Option<f64>, Fault> {
        Ok(self.numbers::<1>(key)?.map(|[number]| number))
    }

    /// A number.
    pub(super) fn number(&self, key: &str) -> Result<f64, Fault> {
        match self.number_if(key)? {
            Some(number) => Ok(number),
            None => self.fault(format!("<{}> has no {key}, expected one", self.tag())),
        }
    }

    /// A positive number.
    pub(super) fn positive(&self, key: &str) -> Result<f64, Fault> {
        let number = self.number(key)?;
        match number > 0.0 {
            true => Ok(number),
            false => self.fault(format!(
                "{key} of <{}> is {number}, expected a positive number",
                self.tag()
            )),
        }
    }

    /// Three numbers; `None` where there is no such attribute.
    pub(super) fn vector_if(&self, key: &str) -> Result<Option<Vector3<f64>>, Fault> {
        Ok(self.numbers::<3>(key)?.map(Vector3::from))
    }

    /// What an `<origin>` says: `xyz` \[m\], and `rpy` \[rad\] about fixed x, then y, then z.
    pub(super) fn pose(&mut self) -> Result<Pose, Fault> {
        self.only(&["xyz", "rpy"]);
        let at_m = self.vector_if("xyz")?.unwrap_or_default();
        let rpy = self.vector_if("rpy")?.unwrap_or_default();
        let turn = UnitQuaternion::from_euler_angles(rpy.x, rpy.y, rpy.z);
        Ok(Pose::from_parts(at_m.into(), turn))
    }
}
