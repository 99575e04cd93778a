//! Ranges of atom types such as `2`, `*`, `2*`, `*3`, `2*3` (LAMMPS doc page `pair_coeff`).

use std::ops::RangeInclusive;

use crate::script::{Complaint, Name};

/// The types a word stands for, all between 1 and `types`.
pub fn type_range(name: &Name, types: usize) -> Result<RangeInclusive<u32>, Complaint> {
    let complain = |message: String| Complaint::new(name.word, message);
    let last_type = types as u32;
    let (first, last) = match name.text.split_once('*') {
        Some((first, last)) => (first, last),
        None => (name.text.as_str(), name.text.as_str()),
    };
    let bound =
        |text: &str, open: u32| if text.is_empty() && name.text.contains('*') { Some(open) } else { digits(text) };
    let (Some(first), Some(last)) = (bound(first, 1), bound(last, last_type)) else {
        return Err(complain(format!("expected an atom type or a range such as 1*{types}, got '{}'", name.text)));
    };
    if first < 1 || last > last_type || first > last {
        return Err(complain(format!("expected atom types from 1 to {types}, got '{}'", name.text)));
    }
    Ok(first..=last)
}

fn digits(text: &str) -> Option<u32> {
    text.bytes().all(|b| b.is_ascii_digit()).then(|| text.parse().ok()).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_those_of_lammps() {
        let range = |text: &str| type_range(&Name { text: text.into(), word: 1 }, 3);
        assert_eq!(range("2"), Ok(2..=2));
        assert_eq!(range("*"), Ok(1..=3));
        assert_eq!(range("2*"), Ok(2..=3));
        assert_eq!(range("*2"), Ok(1..=2));
        assert_eq!(range("1*2"), Ok(1..=2));
        for wrong in ["", "0", "4", "1*4", "3*1", "a", "1*a", "**", "-1", "0*", "*0", "99999999999"] {
            assert!(range(wrong).is_err(), "{wrong}");
        }
    }
}
