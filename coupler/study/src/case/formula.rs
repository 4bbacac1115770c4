//! Formulas in case files: numbers, names, `+ - * / ^`, brackets, `exp`, `ln`, `sqrt`, `abs`, and
//! `min(a, b)`, `max(a, b)`.

/// Value of `formula`, with `value` of each name in it.
pub(super) fn evaluate(formula: &str, value: &dyn Fn(&str) -> Option<f64>) -> Result<f64, String> {
    let mut reader = Reader { formula, at: 0, value };
    let result = reader.sum()?;
    if reader.peek().is_some() {
        return Err(reader.wrong("an operator or the end"));
    }
    Ok(result)
}

struct Reader<'a> {
    formula: &'a str,
    at: usize,
    value: &'a dyn Fn(&str) -> Option<f64>,
}

impl<'a> Reader<'a> {
    /// Next character that is not white.
    fn peek(&mut self) -> Option<char> {
        let rest = &self.formula[self.at..];
        self.at += rest.len() - rest.trim_start().len();
        self.formula[self.at..].chars().next()
    }

    fn take(&mut self, wanted: char) -> bool {
        let found = self.peek() == Some(wanted);
        self.at += if found { wanted.len_utf8() } else { 0 };
        found
    }

    fn wrong(&self, expected: &str) -> String {
        let (before, after) = self.formula.split_at(self.at);
        format!("the formula goes wrong at {after:?} after {before:?}: expected {expected}")
    }

    fn sum(&mut self) -> Result<f64, String> {
        let mut total = self.product()?;
        loop {
            if self.take('+') {
                total += self.product()?;
            } else if self.take('-') {
                total -= self.product()?;
            } else {
                return Ok(total);
            }
        }
    }

    fn product(&mut self) -> Result<f64, String> {
        let mut total = self.signed()?;
        loop {
            if self.take('*') {
                total *= self.signed()?;
            } else if self.take('/') {
                total /= self.signed()?;
            } else {
                return Ok(total);
            }
        }
    }

    fn signed(&mut self) -> Result<f64, String> {
        if self.take('-') {
            return Ok(-self.signed()?);
        }
        let base = self.atom()?;
        if self.take('^') { Ok(base.powf(self.signed()?)) } else { Ok(base) }
    }

    fn atom(&mut self) -> Result<f64, String> {
        match self.peek() {
            Some('(') => self.bracket(),
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if c.is_ascii_alphabetic() => self.named(),
            _ => Err(self.wrong("a number, a name or a bracket")),
        }
    }

    fn expect(&mut self, wanted: char) -> Result<(), String> {
        if self.take(wanted) { Ok(()) } else { Err(self.wrong(&format!("'{wanted}'"))) }
    }

    fn bracket(&mut self) -> Result<f64, String> {
        self.expect('(')?;
        let inner = self.sum()?;
        self.expect(')').map(|()| inner)
    }

    fn pair(&mut self) -> Result<(f64, f64), String> {
        self.expect('(')?;
        let first = self.sum()?;
        self.expect(',')?;
        let second = self.sum()?;
        self.expect(')').map(|()| (first, second))
    }

    /// The run of characters that `belongs` accepts, taken.
    fn word(&mut self, belongs: impl Fn(char) -> bool) -> &'a str {
        let rest = &self.formula[self.at..];
        let word = &rest[..rest.find(|c| !belongs(c)).unwrap_or(rest.len())];
        self.at += word.len();
        word
    }

    fn number(&mut self) -> Result<f64, String> {
        let word = self.word(|c| c.is_ascii_digit() || c == '.');
        word.parse().map_err(|_| self.wrong(&format!("a number, not {word:?}")))
    }

    fn named(&mut self) -> Result<f64, String> {
        let name = self.word(|c| c.is_ascii_alphanumeric() || c == '_');
        match name {
            "exp" => Ok(self.bracket()?.exp()),
            "ln" => Ok(self.bracket()?.ln()),
            "sqrt" => Ok(self.bracket()?.sqrt()),
            "abs" => Ok(self.bracket()?.abs()),
            "min" => self.pair().map(|(a, b)| a.min(b)),
            "max" => self.pair().map(|(a, b)| a.max(b)),
            _ => (self.value)(name).ok_or_else(|| format!("the formula needs {name:?}, which has no value")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn precedence_names_and_faults() {
        let value = |name: &str| (name == "St").then_some(53.0);
        assert_eq!(evaluate("exp(-35/St)", &value), Ok((-35.0_f64 / 53.0).exp()));
        assert_eq!(evaluate("2 + 3*4 - 6/3/2 - -1", &value), Ok(14.0));
        assert_eq!(evaluate("-2^2 + 2^(1+1)^0.5", &value), Ok(-4.0 + 2.0_f64.powf(2.0_f64.sqrt())));
        assert_eq!(evaluate("min(St, 2*4) + max(1, 3 - 1)", &value), Ok(10.0));
        for wrong in ["min(1)", "max 1, 2", "min(1, 2", "", "2 +", "(1", "exp 2", "1 2", "1.2.3", "$"] {
            assert!(evaluate(wrong, &value).is_err(), "{wrong}");
        }
        assert!(evaluate("Re", &value).unwrap_err().contains("\"Re\""));
    }
}
