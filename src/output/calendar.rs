//! Dates.

use std::time::{SystemTime, UNIX_EPOCH};

/// Today in UTC, "2026-11-26".
pub fn today() -> String {
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs());
    date((seconds / 86_400) as i64)
}

/// The date so many days after 1970-01-01, in the Gregorian calendar. Years begin in March here, so that the leap day is the last
/// of one.
fn date(days: i64) -> String {
    // Days of 400 years, and of the years before 1970 that begin with one whose number is a multiple of 400.
    const ERA: i64 = 146_097;
    const BEFORE: i64 = 719_468;
    let (era, day) = ((days + BEFORE).div_euclid(ERA), (days + BEFORE).rem_euclid(ERA));
    let year = (day - day / 1460 + day / 36_524 - day / (ERA - 1)) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let first = (153 * month + 2) / 5;
    let month_of_year = if month < 10 { month + 3 } else { month - 9 };
    let year = year + era * 400 + i64::from(month_of_year <= 2);
    format!("{year}-{month_of_year:02}-{:02}", day - first + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_become_dates() {
        let of = [-1, 0, 58, 59, 365, 11_016, 11_017, 20_783].map(date);
        let known = [
            "1969-12-31",
            "1970-01-01",
            "1970-02-28",
            "1970-03-01",
            "1971-01-01",
            "2000-02-29",
            "2000-03-01",
            "2026-11-26",
        ];
        assert_eq!(of, known);
    }
}
