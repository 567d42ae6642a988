//! The layout that a line of column names gives.

use super::columns::{AngleKind, Column, Meaning, column};
use super::layout::{
    Angles, BodyColumns, Orientation, QuaternionOrder, TableFault, TableLayout, TimeColumns, fault,
    points_are_taken,
};
use super::said::listed;
use super::turn::Turn;
use super::units::{AngleUnit, TimeUnit};
use crate::motion::LengthUnit;

/// The columns of a name, with what they mean.
struct NamedColumn<'n> {
    line: usize,
    names: &'n [String],
    columns: Vec<Option<Column>>,
}

/// What the columns of one owner give.
#[derive(Clone, Debug, Default)]
struct Group {
    owner: String,
    position: Option<[usize; 3]>,
    orientation: Option<Orientation>,
    notes: Vec<String>,
    against: Vec<String>,
}

/// Finds the columns of a meaning among those of an owner.
type Find<'f> = dyn Fn(&dyn Fn(&Meaning) -> bool) -> Vec<usize> + 'f;

/// What letters by themselves give.
struct Letters {
    position: [Option<usize>; 3],
    /// Where a w stands beside them.
    quaternion: Option<[usize; 4]>,
}

/// The layout that a line of column names gives.
pub(super) fn layout(
    line: usize,
    names: &[String],
    order: Option<QuaternionOrder>,
) -> Result<TableLayout, TableFault> {
    let named = NamedColumn {
        line,
        names,
        columns: names.iter().map(|name| column(name)).collect(),
    };
    let groups = named.groups(order)?;
    let bodies: Vec<BodyColumns> = groups
        .iter()
        .map(|group| BodyColumns {
            name: (groups.len() > 1).then(|| group.owner.clone()),
            position: group.position.unwrap_or_default(),
            orientation: group.orientation.unwrap_or(Orientation::Unseen),
            seen: named.seen(&group.owner, groups.len() == 1),
        })
        .collect();
    let (time, other_times) = named.time()?;
    let body_name = named.one("the body's name", named.all(|of| *of == Meaning::Body))?;
    let mut used: Vec<usize> = body_name.into_iter().collect();
    match time {
        TimeColumns::One(column, _) => used.push(column),
        TimeColumns::Two(whole, rest) => used.extend([whole, rest]),
        TimeColumns::Row => {}
    }
    for body in &bodies {
        used.extend(body.position);
        match &body.orientation {
            Orientation::Quaternion(columns) => used.extend(columns),
            Orientation::Angles(angles) => used.extend(angles.columns),
            Orientation::Matrix(columns) => used.extend(columns),
            Orientation::Unseen => {}
        }
    }
    let is_used = |index: usize| {
        let is_seen = named.columns[index].as_ref();
        let is_seen = is_seen.is_some_and(|of| matches!(of.meaning, Meaning::Seen(_)));
        is_seen || used.contains(&index)
    };
    let unread = (0..names.len()).filter(|index| !is_used(*index) && !is_skipped(&names[*index]));
    Ok(TableLayout {
        body_name,
        length: named.length(&bodies),
        unread: unread.map(|index| names[index].clone()).collect(),
        other_times,
        is_order_named: groups.iter().all(|group| group.notes.is_empty()),
        notes: groups
            .iter()
            .flat_map(|group| group.notes.clone())
            .collect(),
        against: groups
            .iter()
            .flat_map(|group| group.against.clone())
            .collect(),
        ..TableLayout::plain("a table", time, bodies)
    })
}

/// How a column is named that is not to be read.
fn is_skipped(name: &str) -> bool {
    name == "-" || name.is_empty()
}

impl NamedColumn<'_> {
    fn fault<T>(&self, message: impl Into<String>) -> Result<T, TableFault> {
        fault(self.line, message)
    }

    fn meaning(&self, index: usize) -> Option<Meaning> {
        self.columns[index].as_ref().map(|column| column.meaning)
    }

    fn all(&self, is_it: impl Fn(&Meaning) -> bool) -> Vec<usize> {
        let indices = 0..self.names.len();
        indices
            .filter(|index| self.meaning(*index).as_ref().is_some_and(&is_it))
            .collect()
    }

    /// The only column for something, if there is one.
    fn one(&self, what: &str, found: Vec<usize>) -> Result<Option<usize>, TableFault> {
        match found[..] {
            [] => Ok(None),
            [index] => Ok(Some(index)),
            _ => {
                let names: Vec<String> = found.iter().map(|of| self.names[*of].clone()).collect();
                self.fault(format!(
                    "several columns for {what}: {}; expected one: name the columns that are meant with --columns, \
                     and - for the others",
                    listed(&names)
                ))
            }
        }
    }

    /// The poses of the table: one, or those of several owners side by side.
    fn groups(&self, order: Option<QuaternionOrder>) -> Result<Vec<Group>, TableFault> {
        let mut owners: Vec<&str> = Vec::new();
        let placed = self.columns.iter().flatten();
        for column in placed.filter(|column| is_of_pose(&column.meaning)) {
            if !owners.contains(&column.owner.as_str()) {
                owners.push(&column.owner);
            }
        }
        let of_owner = |owner: &str| -> Vec<usize> {
            let is_its = |of: &Column| of.owner == owner && is_of_pose(&of.meaning);
            let indices = 0..self.names.len();
            indices
                .filter(|at| self.columns[*at].as_ref().is_some_and(is_its))
                .collect()
        };
        let mut groups: Vec<Group> = Vec::new();
        for owner in &owners {
            groups.push(self.group(owner, &of_owner(owner), order)?);
        }
        let whole: Vec<usize> = (0..groups.len())
            .filter(|at| groups[*at].position.is_some())
            .collect();
        // That of nobody in particular goes before others; names of frames may differ between its parts.
        let own = whole.iter().find(|at| groups[**at].owner.is_empty());
        let own = own.or(whole.first().filter(|_| whole.len() == 1)).copied();
        let Some(own) = own else {
            if whole.len() > 1 {
                groups.retain(|group| group.position.is_some());
                return self.side_by_side(groups);
            }
            let all = self.all(is_of_pose);
            let group = self.group("", &all, order)?;
            return self.single(group, &all);
        };
        let turned = groups
            .iter()
            .filter(|group| group.position.is_none() && group.orientation.is_some());
        let turned: Vec<Group> = turned.cloned().collect();
        let mut group = groups[own].clone();
        if let (None, [other]) = (&group.orientation, &turned[..]) {
            group.orientation = other.orientation;
            group.notes.extend(other.notes.clone());
            group.against.extend(other.against.clone());
        }
        let owner = group.owner.clone();
        self.single(group, &of_owner(&owner))
    }

    /// Bodies side by side, of which those without an orientation are points.
    fn side_by_side(&self, mut groups: Vec<Group>) -> Result<Vec<Group>, TableFault> {
        let mut names: Vec<String> = Vec::new();
        for group in &mut groups {
            if group.orientation.is_none() {
                names.push(group.owner.clone());
            }
        }
        if let Some(first) = groups.first_mut().filter(|_| !names.is_empty()) {
            let why = format!("{} have no columns for an orientation", listed(&names));
            first.notes.push(points_are_taken(&why));
        }
        Ok(groups)
    }

    /// The only body of a table.
    fn single(&self, mut group: Group, columns: &[usize]) -> Result<Vec<Group>, TableFault> {
        if group.position.is_none() {
            let of_turn = match group.orientation {
                Some(Orientation::Quaternion(parts)) => {
                    let names: Vec<String> =
                        parts.iter().map(|at| self.names[*at].clone()).collect();
                    format!(" ({} are taken for a quaternion)", names.join(", "))
                }
                _ => String::new(),
            };
            return self.fault(format!(
                "no columns for a position among {}{of_turn}; expected x, y and z in any order, or their names \
                 with --columns",
                self.listed()
            ));
        }
        if group.orientation.is_none() {
            if columns
                .iter()
                .any(|at| self.meaning(*at).is_some_and(|of| of.is_turn()))
            {
                return self.fault(format!(
                    "not all columns for an orientation among {}; expected qx, qy, qz and qw in any order, or \
                     their names with --columns",
                    self.listed()
                ));
            }
            group
                .notes
                .push(points_are_taken("no columns for an orientation"));
        }
        Ok(vec![group])
    }

    fn listed(&self) -> String {
        let names = self.names.iter().filter(|name| !is_skipped(name));
        let names: Vec<String> = names.cloned().collect();
        listed(&names)
    }

    /// What the columns of an owner give.
    fn group(
        &self,
        owner: &str,
        columns: &[usize],
        order: Option<QuaternionOrder>,
    ) -> Result<Group, TableFault> {
        let mut group = Group {
            owner: owner.to_owned(),
            ..Group::default()
        };
        let find = |is_it: &dyn Fn(&Meaning) -> bool| -> Vec<usize> {
            let found = columns
                .iter()
                .filter(|at| self.meaning(**at).as_ref().is_some_and(is_it));
            found.copied().collect()
        };
        let letters: [Vec<usize>; 4] = std::array::from_fn(|axis| {
            find(&|of| matches!(of, Meaning::Letter { axis: at, .. } if *at == axis))
        });
        let named: [Vec<usize>; 3] = std::array::from_fn(|axis| {
            find(&|of| matches!(of, Meaning::Position { axis: at, .. } if *at == axis))
        });
        let letters = self.letters(letters, named)?;
        let position = match letters.position {
            [Some(x), Some(y), Some(z)] => Some([x, y, z]),
            _ => None,
        };
        group.position = position;
        group.orientation = match letters.quaternion {
            Some(parts) => Some(Orientation::Quaternion(parts)),
            None => self.orientation(&find, order, &mut group)?,
        };
        let counted = find(&|of| matches!(of, Meaning::Coordinate(_)));
        group.position = group.position.or(self.counted(&counted));
        // The last column of a matrix of a pose is its position.
        let entries = find(&|of| matches!(of, Meaning::Entry { .. }));
        let last = self.position_of_matrix(&entries);
        group.position = group.position.or(last);
        Ok(group)
    }

    /// The columns of a position, and of a quaternion where a w stands beside letters.
    fn letters(
        &self,
        letters: [Vec<usize>; 4],
        named: [Vec<usize>; 3],
    ) -> Result<Letters, TableFault> {
        let axes = ["x", "y", "z"];
        let one_each = |of: &[Vec<usize>; 3]| -> Result<[Option<usize>; 3], TableFault> {
            let mut found = [None; 3];
            for (axis, to) in found.iter_mut().enumerate() {
                *to = self.one(axes[axis], of[axis].clone())?;
            }
            Ok(found)
        };
        let [xs, ys, zs, ws] = letters;
        let w = self.one("w", ws)?;
        let plain = [xs, ys, zs];
        let Some(w) = w else {
            let both: [Vec<usize>; 3] =
                std::array::from_fn(|axis| [named[axis].clone(), plain[axis].clone()].concat());
            return Ok(Letters {
                position: one_each(&both)?,
                quaternion: None,
            });
        };
        let has_named = named.iter().all(|of| !of.is_empty());
        if has_named || plain.iter().all(|of| of.len() <= 1) {
            let parts = match one_each(&plain)? {
                [Some(x), Some(y), Some(z)] => Some([x, y, z, w]),
                _ => None,
            };
            return Ok(Letters {
                position: one_each(&named)?,
                quaternion: parts,
            });
        }
        // Two of each letter: those beside the w are its.
        let beside = |first: Option<usize>| -> Option<[usize; 4]> {
            let first = first?;
            let is_it = |axis: usize| plain[axis].contains(&(first + axis));
            (0..3)
                .all(is_it)
                .then_some([first, first + 1, first + 2, w])
        };
        let parts = match (beside(w.checked_sub(3)), beside(w.checked_add(1))) {
            (Some(parts), None) | (None, Some(parts)) => parts,
            _ => {
                return self.fault(format!(
                    "which x, y, z belong to w among {}? Expected qx, qy, qz, qw for the orientation: name all columns \
                     with --columns",
                    self.listed()
                ));
            }
        };
        let rest: [Vec<usize>; 3] = std::array::from_fn(|axis| {
            let others = plain[axis].iter().filter(|at| **at != parts[axis]);
            others.copied().collect()
        });
        Ok(Letters {
            position: one_each(&rest)?,
            quaternion: Some(parts),
        })
    }

    /// The columns of an orientation with names of its own.
    fn orientation(
        &self,
        find: &Find,
        order: Option<QuaternionOrder>,
        group: &mut Group,
    ) -> Result<Option<Orientation>, TableFault> {
        let part_names = ["qx", "qy", "qz", "qw"];
        let mut quaternion = [None; 4];
        let mut imaginary = [None; 4];
        let mut angles = [[None; 4]; 3];
        let kinds = [AngleKind::Rpy, AngleKind::Vector, AngleKind::Untold];
        for part in 0..4 {
            let name = part_names[part];
            quaternion[part] = self.one(
                name,
                find(&|of| matches!(of, Meaning::Quaternion { part: at, .. } if *at == part)),
            )?;
            imaginary[part] = self.one(name, find(&|of| *of == Meaning::Imaginary(part)))?;
            for (of_kind, kind) in angles.iter_mut().zip(kinds) {
                let is_it = |of: &Meaning| matches!(of, Meaning::Angle { axis, kind: at, .. } if *axis == part && *at == kind);
                of_kind[part] = self.one(["roll", "pitch", "yaw", "rw"][part], find(&is_it))?;
            }
        }
        // `Q0` beside `Qx`, `Qy`, `Qz` is the scalar.
        if let (None, [zero]) = (quaternion[3], &find(&|of| *of == Meaning::Numbered(0))[..]) {
            quaternion[3] = Some(*zero).filter(|_| quaternion[..3].iter().all(Option::is_some));
        }
        let [rpy, vector, mut untold] = angles;
        let all = |parts: [Option<usize>; 4]| -> Option<[usize; 4]> {
            let parts: Vec<usize> = parts.into_iter().flatten().collect();
            parts.try_into().ok()
        };
        // `rw` beside `rx`, `ry`, `rz` makes a quaternion of them.
        if let Some(parts) = all(quaternion).or(all(imaginary)).or(all(untold)) {
            return Ok(Some(Orientation::Quaternion(parts)));
        }
        let entries = find(&|of| matches!(of, Meaning::Entry { .. }));
        if let Some(matrix) = self.rotation_of_matrix(&entries) {
            group
                .notes
                .push("a matrix is read row by row, as its columns are counted".to_owned());
            return Ok(Some(Orientation::Matrix(matrix)));
        }
        if let Some(found) = self.numbered(
            &find(&|of| matches!(of, Meaning::Numbered(_))),
            order,
            group,
        )? {
            return Ok(Some(found));
        }
        // Without a w, `rot_x` is an angle.
        let is_loose =
            find(&|of| matches!(of, Meaning::Quaternion { is_angle: true, .. })).len() == 3;
        if is_loose {
            untold = quaternion;
        }
        for (columns, kind) in [
            (rpy, AngleKind::Rpy),
            (vector, AngleKind::Vector),
            (untold, AngleKind::Untold),
        ] {
            let [Some(x), Some(y), Some(z), _] = columns else {
                continue;
            };
            return Ok(Some(Orientation::Angles(Angles {
                columns: [x, y, z],
                unit: [x, y, z].into_iter().find_map(|at| self.angle_unit(at)),
                turn: match kind {
                    AngleKind::Rpy => Some(Turn::RPY),
                    AngleKind::Vector => Some(Turn::VECTOR),
                    AngleKind::Untold => None,
                },
            })));
        }
        Ok(None)
    }

    fn angle_unit(&self, index: usize) -> Option<AngleUnit> {
        match self.meaning(index)? {
            Meaning::Angle { unit, .. } | Meaning::Quaternion { unit, .. } => unit,
            _ => None,
        }
    }

    /// Four numbered parts are a quaternion, nine a matrix.
    fn numbered(
        &self,
        found: &[usize],
        order: Option<QuaternionOrder>,
        group: &mut Group,
    ) -> Result<Option<Orientation>, TableFault> {
        let mut by_number: Vec<(usize, usize)> = Vec::new();
        for index in found {
            if let Some(Meaning::Numbered(number)) = self.meaning(*index) {
                by_number.push((number, *index));
            }
        }
        by_number.sort();
        let follow = by_number.windows(2).all(|pair| pair[1].0 == pair[0].0 + 1);
        let columns: Vec<usize> = by_number.into_iter().map(|(_, index)| index).collect();
        if !follow {
            return Ok(None);
        }
        if let Ok([a, b, c, d]) = <[usize; 4]>::try_from(columns.as_slice()) {
            let why = match order {
                Some(_) => "as --quaternion says",
                None => "the usual order (--quaternion xyzw for the other)",
            };
            // `q0` is the scalar for whoever counts so.
            let letters = self.names[a].chars().filter(|of| of.is_alphanumeric());
            let is_usual = letters.collect::<String>().eq_ignore_ascii_case("q0");
            if order.is_none() && !is_usual {
                group.against.push(
                    "nothing tells the order of a quaternion whose columns are numbered: expected --quaternion wxyz or \
                     --quaternion xyzw"
                        .to_owned(),
                );
            }
            let order = order.unwrap_or(QuaternionOrder::Wxyz);
            let words = order.words();
            group.notes.push(format!(
                "the quaternion's columns are numbered: taken as {words}, {why}"
            ));
            return Ok(Some(Orientation::Quaternion(order.columns([a, b, c, d]))));
        }
        if let Ok(nine) = <[usize; 9]>::try_from(columns.as_slice()) {
            group
                .notes
                .push("nine numbered entries of a matrix: taken row by row".to_owned());
            group.against.push(
                "nothing tells whether a matrix whose entries are numbered is written row by row or column by column: \
                 expected r11, r12, r13, r21, … in --columns"
                    .to_owned(),
            );
            return Ok(Some(Orientation::Matrix(nine)));
        }
        Ok(None)
    }

    /// The columns of coordinates that are counted from 0 or from 1.
    fn counted(&self, found: &[usize]) -> Option<[usize; 3]> {
        let at = |number: usize| {
            let is_it = |index: &&usize| self.meaning(**index) == Some(Meaning::Coordinate(number));
            found.iter().find(is_it).copied()
        };
        let base = usize::from(at(0).is_none());
        Some([at(base)?, at(base + 1)?, at(base + 2)?])
    }

    /// The column of an entry of a matrix, counted from 0.
    fn entry(&self, entries: &[usize], [row, column]: [usize; 2]) -> Option<usize> {
        let counted = |at: &usize| match self.meaning(*at) {
            Some(Meaning::Entry { row, column }) => Some([row, column]),
            _ => None,
        };
        let base = usize::from(
            !entries
                .iter()
                .filter_map(counted)
                .any(|[row, column]| row == 0 || column == 0),
        );
        let mut found = entries
            .iter()
            .filter(|at| counted(at) == Some([row + base, column + base]));
        found.next().copied()
    }

    fn rotation_of_matrix(&self, entries: &[usize]) -> Option<[usize; 9]> {
        let all = (0..9).map(|at| self.entry(entries, [at / 3, at % 3]));
        all.collect::<Option<Vec<usize>>>()?.try_into().ok()
    }

    fn position_of_matrix(&self, entries: &[usize]) -> Option<[usize; 3]> {
        let all = (0..3).map(|row| self.entry(entries, [row, 3]));
        all.collect::<Option<Vec<usize>>>()?.try_into().ok()
    }

    fn seen(&self, owner: &str, is_only: bool) -> Vec<super::layout::SeenColumn> {
        let all = self.columns.iter().enumerate();
        let own = all.filter_map(|(index, column)| {
            let column = column.as_ref()?;
            let Meaning::Seen(kind) = column.meaning else {
                return None;
            };
            (is_only || column.owner == owner).then(|| kind.column(index))
        });
        own.collect()
    }

    fn length(&self, bodies: &[BodyColumns]) -> Option<LengthUnit> {
        let columns = bodies.iter().flat_map(|body| body.position);
        { columns }.find_map(|index| match self.meaning(index) {
            Some(Meaning::Position { unit, .. } | Meaning::Letter { unit, .. }) => unit,
            _ => None,
        })
    }

    /// The columns of time, those of the highest rank that are one or a pair, otherwise frames; and the names of others.
    fn time(&self) -> Result<(TimeColumns, Vec<String>), TableFault> {
        let ranked = (0..self.names.len()).filter_map(|index| match self.meaning(index) {
            Some(Meaning::Time { rank, unit }) => Some((rank, index, unit)),
            _ => None,
        });
        let ranked: Vec<(u8, usize, Option<TimeUnit>)> = ranked.collect();
        let mut ranks: Vec<u8> = ranked.iter().map(|(rank, ..)| *rank).collect();
        ranks.sort_by(|a, b| b.cmp(a));
        ranks.dedup();
        let frame = self
            .columns
            .iter()
            .position(|of| of.as_ref().is_some_and(|of| of.meaning == Meaning::Frame));
        let by_frame = frame.map_or(TimeColumns::Row, |at| {
            TimeColumns::One(at, Some(TimeUnit::Frame))
        });
        let Some(best) = ranks.first() else {
            return Ok((by_frame, Vec::new()));
        };
        let of_rank = |rank: u8| -> Vec<(usize, Option<TimeUnit>)> {
            let its = ranked.iter().filter(|(of, ..)| *of == rank);
            its.map(|(_, index, unit)| (*index, *unit)).collect()
        };
        let clear = ranks
            .iter()
            .find_map(|rank| columns_of_time(&of_rank(*rank)));
        let Some(found) = clear else {
            let all = of_rank(*best).into_iter().map(|(index, _)| index);
            self.one("the time", all.collect())?;
            return Ok((by_frame, Vec::new()));
        };
        let is_used = |index: &usize| match found {
            TimeColumns::One(column, _) => *index == column,
            TimeColumns::Two(whole, rest) => *index == whole || *index == rest,
            TimeColumns::Row => false,
        };
        let others = ranked
            .iter()
            .map(|(_, index, _)| *index)
            .filter(|index| !is_used(index));
        let others = others.map(|index| self.names[index].clone()).collect();
        Ok((found, others))
    }
}

fn columns_of_time(columns: &[(usize, Option<TimeUnit>)]) -> Option<TimeColumns> {
    let (s, ns) = (Some(TimeUnit::Second), Some(TimeUnit::Nanosecond));
    match columns {
        [(index, unit)] => Some(TimeColumns::One(*index, *unit)),
        [(whole, a), (rest, b)] if (*a, *b) == (s, ns) => Some(TimeColumns::Two(*whole, *rest)),
        [(rest, b), (whole, a)] if (*a, *b) == (s, ns) => Some(TimeColumns::Two(*whole, *rest)),
        // Several clocks, each with its unit.
        [(first, unit), rest @ ..]
            if unit.is_some() && rest.iter().all(|(_, unit)| unit.is_some()) =>
        {
            Some(TimeColumns::One(*first, *unit))
        }
        _ => None,
    }
}

fn is_of_pose(meaning: &Meaning) -> bool {
    let is_place = matches!(
        meaning,
        Meaning::Position { .. } | Meaning::Letter { .. } | Meaning::Coordinate(_)
    );
    is_place || matches!(meaning, Meaning::Imaginary(_)) || meaning.is_turn()
}
