//! Quantities as people read them: counts, shares, times.

use std::time::Duration;

/// A count as a person says it: 12.3 million.
pub fn count(n: u64) -> String {
    let scaled = |unit: f64| n as f64 / unit;
    match n {
        0..10_000 => n.to_string(),
        10_000..1_000_000 => format!("{:.0} thousand", scaled(1e3)),
        1_000_000..1_000_000_000 => format!("{:.1} million", scaled(1e6)),
        _ => format!("{:.2} billion", scaled(1e9)),
    }
}

/// A share in percent with two significant digits.
pub fn percent(share: f64) -> String {
    let value = 100.0 * share;
    if value == 0.0 {
        return "0 %".to_owned();
    }
    if value < 1e-4 {
        return format!("{value:.1e} %");
    }
    let decimals = (1.0 - value.log10().floor()).clamp(0.0, 6.0) as usize;
    format!("{value:.decimals$} %")
}

/// A time that a person waited, to the tenth of a second.
pub fn seconds(time: Duration) -> String {
    match time.as_secs() {
        0..120 => format!("{:.1} s", time.as_secs_f64()),
        s @ 120..7200 => format!("{} min {} s", s / 60, s % 60),
        s => format!("{} h {} min", s / 3600, s / 60 % 60),
    }
}

/// A time that was measured, in seconds, with three significant digits.
pub fn measured(time: f64) -> String {
    let (value, unit) = match time {
        t if t < 1e-3 => (t * 1e6, "µs"),
        t if t < 1.0 => (t * 1e3, "ms"),
        t => (t, "s"),
    };
    format!("{} {unit}", significant(value))
}

/// A ratio or another plain figure with three significant digits, and no fewer before the point.
pub fn significant(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let decimals = (2.0 - value.abs().log10().floor()).clamp(0.0, 6.0) as usize;
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_short_and_honest() {
        assert_eq!(
            [0, 9_999, 123_456, 12_345_678, 5_000_000_000].map(count),
            ["0", "9999", "123 thousand", "12.3 million", "5.00 billion"]
        );
        assert_eq!(
            [0.0, 1.0, 0.0123, 0.000_012, 1e-9].map(percent),
            ["0 %", "100 %", "1.2 %", "0.0012 %", "1.0e-7 %"]
        );
        assert_eq!(
            [1.25, 125.0, 7300.0].map(|s| seconds(Duration::from_secs_f64(s))),
            ["1.2 s", "2 min 5 s", "2 h 1 min"]
        );
    }

    #[test]
    fn measurements_keep_three_digits() {
        assert_eq!(
            [2.5e-5, 0.0123456, 0.25, 12.3456, 1234.5].map(measured),
            ["25.0 µs", "12.3 ms", "250 ms", "12.3 s", "1234 s"]
        );
        assert_eq!([0.0, 1.0, 0.012_345, 31.41].map(significant), ["0", "1.00", "0.0123", "31.4"]);
    }
}
