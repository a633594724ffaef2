//! Map texts: which variables of a file make which column, `time_s=t,position_m=qm,force_n=gtau*vir`.

use super::columns::{self, Named, Slot};
use crate::Error;
use std::str::FromStr;

/// Parentheses and signs within each other.
const DEEPEST: usize = 64;

/// A parsed map. Each entry is `COLUMN=EXPRESSION`; an expression is made of variables of the file, numbers, `+ - * /`,
/// parentheses, `min(a, b)` and `max(a, b)`. A variable of one element is a constant, and `index` counts samples from 0. A name with other
/// characters than letters, digits and `_` is put in quotes, unless it is a series of a log, `/ft:force.z`. The columns of a CSV file
/// without header are `c1`, `c2`, … Of time, position and force, what a map leaves out is the column of its own name.
///
/// ```
/// use signals::Map;
/// let map: Map = "time_s = index/610.35, position_m = V2, force_n = (V1 - 0.1)*2".parse()?;
/// assert_eq!(map.variables(), ["V2", "V1"]);
/// let wrong = "time_s=t,position_mm=qm".parse::<Map>().unwrap_err();
/// assert!(wrong.to_string().starts_with("map, column 10: "));
/// # Ok::<(), signals::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Map {
    text: String,
    entries: Vec<Entry>,
}

#[derive(Debug, Clone, PartialEq)]
struct Entry {
    column: &'static Named,
    value: Expression,
}

#[derive(Debug, Clone, PartialEq)]
enum Expression {
    Number(f64),
    /// Name, and its place in the text.
    Variable(String, usize),
    Negative(Box<Expression>),
    /// `+ - * /`, `<` for min and `>` for max.
    Binary(char, Box<Expression>, Box<Expression>),
}

impl FromStr for Map {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let mut parser = Parser { text, characters: text.chars().collect(), at: 0, depth: 0 };
        let mut entries: Vec<Entry> = Vec::new();
        loop {
            parser.skip_space();
            let start = parser.at;
            let name = parser.name()?;
            let Some(column) = columns::find(&name) else {
                return Err(parser.error(
                    start,
                    format!("`{}` is an unknown column; {}", name.escape_debug(), columns::advice(&name)),
                ));
            };
            if entries.iter().any(|e| e.column.slot == column.slot) {
                return Err(parser.error(start, format!("{name} is given twice")));
            }
            if let Some(other) = entries.iter().find(|e| columns::contradict(e.column, column)) {
                return Err(parser.error(
                    start,
                    format!(
                        "{name} is of an axis or a slide, {} of the other; accepted is one of them",
                        other.column.name
                    ),
                ));
            }
            if !parser.take('=') {
                return Err(parser.error(parser.at, format!("{}, accepted is `=`", parser.found())));
            }
            let value = parser.sum()?;
            entries.push(Entry { column, value });
            parser.skip_space();
            if parser.peek().is_none() {
                break;
            }
            if !parser.take(',') {
                return Err(
                    parser.error(parser.at, format!("{}, accepted are + - * / or `,`", parser.found()))
                );
            }
        }
        Ok(Self { text: text.to_string(), entries })
    }
}

impl Map {
    /// The text it was made of.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Variables it names, each once.
    #[must_use]
    pub fn variables(&self) -> Vec<&str> {
        let mut out = Vec::new();
        self.visit(|name, _| {
            if name != "index" && !out.contains(&name) {
                out.push(name);
            }
        });
        out
    }

    /// The first variable in what makes a column.
    #[cfg(feature = "ros2")]
    pub(crate) fn first_variable(&self, slot: Slot) -> Option<&str> {
        let entry = self.entries.iter().find(|e| e.column.slot == slot)?;
        let mut first = None;
        entry.value.visit(&mut |name, _| {
            first.get_or_insert(name);
        });
        first
    }

    /// The map for a file, of several: the first whose variables the file all has; none where the file has columns of a
    /// recording by their names; otherwise the one that misses the fewest, whose refusal says what is missing.
    pub(crate) fn needed(maps: &[Self], has: impl Fn(&str) -> bool) -> Option<&Self> {
        let missing = |map: &Self| map.variables().iter().filter(|name| !has(name)).count();
        let fits = |map: &&Self| !map.variables().is_empty() && missing(map) == 0;
        maps.iter().find(fits).or_else(|| {
            let of_recordings =
                columns::ALL.iter().filter(|column| has(column.name)).map(|column| column.slot);
            if columns::sufficient(of_recordings) { None } else { maps.iter().min_by_key(|map| missing(map)) }
        })
    }

    fn visit<'a>(&'a self, mut see: impl FnMut(&'a str, usize)) {
        for entry in &self.entries {
            entry.value.visit(&mut see);
        }
    }

    /// The columns, from the variables of a file.
    pub(crate) fn apply<'v>(
        &self,
        lookup: impl Fn(&str) -> Option<&'v [f64]>,
        has: &str,
    ) -> Result<Vec<(&'static Named, Vec<f64>)>, Error> {
        let fail = |at: usize, why: String| Error::Map { map: self.text.clone(), column: at + 1, why };
        let mut wrong = None;
        let mut length: Option<(usize, &str)> = None;
        self.visit(|name, at| {
            let why = match (lookup(name), length) {
                (None, _) if name == "index" => return,
                (None, _) => format!("the file has no variable `{}`; it has {has}", name.escape_debug()),
                (Some([]), _) => format!("`{name}` is empty"),
                (Some([_]), _) => return,
                (Some(values), None) => {
                    length = Some((values.len(), name));
                    return;
                }
                (Some(values), Some((n, _))) if n == values.len() => return,
                (Some(values), Some((n, other))) => {
                    format!(
                        "`{name}` has {} elements, `{other}` has {n}; accepted are {n} or 1",
                        values.len()
                    )
                }
            };
            wrong.get_or_insert((at, why));
        });
        if let Some((at, why)) = wrong {
            return Err(fail(at, why));
        }
        let Some((length, _)) = length else {
            return Err(fail(
                0,
                format!("no variable with more than one element is named; the file has {has}"),
            ));
        };
        let mut made: Vec<(&'static Named, Vec<f64>)> = self
            .entries
            .iter()
            .map(|e| (e.column, (0..length).map(|i| e.value.at(i, &lookup)).collect()))
            .collect();
        // what a recording needs and the map leaves out may stand under its own name
        for slot in [Slot::Time, Slot::Position, Slot::Force] {
            let own = |column: &&Named| {
                column.slot == slot && lookup(column.name).is_some_and(|v| v.len() == length)
            };
            if made.iter().all(|(column, _)| column.slot != slot)
                && let Some(column) = columns::ALL.iter().find(own)
            {
                made.push((column, lookup(column.name).unwrap_or_default().to_vec()));
            }
        }
        Ok(made)
    }
}

impl Expression {
    /// Shows each variable with its place.
    fn visit<'a>(&'a self, see: &mut impl FnMut(&'a str, usize)) {
        match self {
            Self::Number(_) => {}
            Self::Variable(name, at) => see(name, *at),
            Self::Negative(inner) => inner.visit(see),
            Self::Binary(_, left, right) => {
                left.visit(see);
                right.visit(see);
            }
        }
    }

    fn at<'v>(&self, i: usize, lookup: &impl Fn(&str) -> Option<&'v [f64]>) -> f64 {
        match self {
            Self::Number(value) => *value,
            Self::Variable(name, _) => match lookup(name) {
                Some([constant]) => *constant,
                Some(values) => values.get(i).copied().unwrap_or(f64::NAN),
                None => i as f64,
            },
            Self::Negative(inner) => -inner.at(i, lookup),
            Self::Binary(operator, left, right) => {
                let (left, right) = (left.at(i, lookup), right.at(i, lookup));
                match operator {
                    '+' => left + right,
                    '-' => left - right,
                    '*' => left * right,
                    // not f64::min, which would hide a value that is not there
                    '<' | '>' if left.is_nan() || right.is_nan() => f64::NAN,
                    '<' => left.min(right),
                    '>' => left.max(right),
                    _ => left / right,
                }
            }
        }
    }
}

struct Parser<'a> {
    text: &'a str,
    characters: Vec<char>,
    at: usize,
    depth: usize,
}

impl Parser<'_> {
    fn error(&self, at: usize, why: String) -> Error {
        Error::Map { map: self.text.to_string(), column: at + 1, why }
    }

    fn peek(&self) -> Option<char> {
        self.characters.get(self.at).copied()
    }

    fn found(&self) -> String {
        self.peek().map_or_else(|| "the text ends".into(), |c| format!("found `{}`", c.escape_debug()))
    }

    fn skip_space(&mut self) {
        while self.peek().is_some_and(char::is_whitespace) {
            self.at += 1;
        }
    }

    /// Takes `wanted` if it comes next.
    fn take(&mut self, wanted: char) -> bool {
        self.skip_space();
        let there = self.peek() == Some(wanted);
        self.at += usize::from(there);
        there
    }

    fn name(&mut self) -> Result<String, Error> {
        let start = self.at;
        if let Some(quote @ ('"' | '\'')) = self.peek() {
            self.at += 1;
            let from = self.at;
            while self.peek().is_some_and(|c| c != quote) {
                self.at += 1;
            }
            if self.peek().is_none() {
                return Err(self.error(start, "a quoted name that does not end".into()));
            }
            self.at += 1;
            return Ok(self.characters[from..self.at - 1].iter().collect());
        }
        if self.peek() == Some('/') {
            self.topic();
            return Ok(self.characters[start..self.at].iter().collect());
        }
        while self.peek().is_some_and(|c| c.is_alphanumeric() || c == '_') {
            self.at += 1;
        }
        if start == self.at {
            return Err(self.error(start, format!("{}, accepted is a name", self.found())));
        }
        Ok(self.characters[start..self.at].iter().collect())
    }

    /// A series of a log, `/robot/ft:force.z`: where a value is expected, a slash divides nothing.
    fn topic(&mut self) {
        let part = |c: char| c.is_alphanumeric() || c == '_';
        while self.peek().is_some_and(|c| part(c) || c == '/') {
            self.at += 1;
        }
        if self.peek() == Some(':') {
            self.at += 1;
            while self.peek().is_some_and(|c| part(c) || c == '.') {
                self.at += 1;
            }
        }
    }

    fn sum(&mut self) -> Result<Expression, Error> {
        let mut left = self.product()?;
        let mut terms = 0;
        loop {
            let operator = if self.take('+') {
                '+'
            } else if self.take('-') {
                '-'
            } else {
                return Ok(left);
            };
            terms = self.not_too_long(terms)?;
            left = Expression::Binary(operator, Box::new(left), Box::new(self.product()?));
        }
    }

    fn product(&mut self) -> Result<Expression, Error> {
        let mut left = self.factor()?;
        let mut terms = 0;
        loop {
            let operator = if self.take('*') {
                '*'
            } else if self.take('/') {
                '/'
            } else {
                return Ok(left);
            };
            terms = self.not_too_long(terms)?;
            left = Expression::Binary(operator, Box::new(left), Box::new(self.factor()?));
        }
    }

    /// A chain nests to the left, as deep as it is long.
    fn not_too_long(&self, terms: usize) -> Result<usize, Error> {
        if terms < DEEPEST {
            Ok(terms + 1)
        } else {
            Err(self.error(self.at, format!("more than {DEEPEST} terms")))
        }
    }

    fn factor(&mut self) -> Result<Expression, Error> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(self.error(self.at, format!("nested deeper than {DEEPEST}")));
        }
        let made = if self.take('-') {
            Expression::Negative(Box::new(self.factor()?))
        } else if self.take('+') {
            self.factor()?
        } else if self.take('(') {
            let inner = self.sum()?;
            if !self.take(')') {
                return Err(self.error(self.at, format!("{}, accepted is `)`", self.found())));
            }
            inner
        } else {
            self.leaf()?
        };
        self.depth -= 1;
        Ok(made)
    }

    fn leaf(&mut self) -> Result<Expression, Error> {
        self.skip_space();
        let start = self.at;
        if !self.peek().is_some_and(|c| c.is_ascii_digit() || c == '.') {
            if !self.peek().is_some_and(|c| c.is_alphanumeric() || matches!(c, '_' | '"' | '\'' | '/')) {
                let why = format!("{}, accepted is a variable, a number or `(`", self.found());
                return Err(self.error(start, why));
            }
            let quoted = matches!(self.peek(), Some('"' | '\''));
            let name = self.name()?;
            let operator = match name.as_str() {
                "min" if !quoted => '<',
                "max" if !quoted => '>',
                _ => return Ok(Expression::Variable(name, start)),
            };
            if !self.take('(') {
                return Ok(Expression::Variable(name, start));
            }
            let left = self.sum()?;
            if !self.take(',') {
                return Err(self.error(self.at, format!("{}, accepted is `,`", self.found())));
            }
            let right = self.sum()?;
            if !self.take(')') {
                return Err(self.error(self.at, format!("{}, accepted is `)`", self.found())));
            }
            return Ok(Expression::Binary(operator, Box::new(left), Box::new(right)));
        }
        while let Some(c) = self.peek() {
            let exponent_sign = matches!(c, '+' | '-')
                && self.at > start
                && matches!(self.characters[self.at - 1], 'e' | 'E');
            if !(c.is_alphanumeric() || c == '.' || exponent_sign) {
                break;
            }
            self.at += 1;
        }
        let text: String = self.characters[start..self.at].iter().collect();
        match text.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(Expression::Number(value)),
            _ => Err(self.error(start, format!("`{text}` is not a number"))),
        }
    }
}
