//! Angles on the command line.

/// Degrees, in the order asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct Angles(pub Vec<f64>);

/// The most angles that are measured in one call.
const MOST: usize = 10_000;

/// One angle, some between commas, or `from..to:step` with both ends included.
pub(super) fn parse(text: &str) -> Result<Angles, String> {
    let hint = || format!("'{text}' is no angle; give degrees from -180 to 180: 0, or 0,10,20, or -30..30:5");
    let number = |text: &str| {
        let angle = text.trim().parse::<f64>().ok().filter(|angle| angle.abs() <= 180.0);
        angle.ok_or_else(hint)
    };
    let Some((from, rest)) = text.split_once("..") else {
        return text.split(',').map(number).collect::<Result<_, _>>().map(Angles);
    };
    let (to, step) = rest.split_once(':').unwrap_or((rest, "1"));
    let [from, to, step] = [number(from)?, number(to)?, number(step)?];
    let count = ((to - from) / step + 1e-9).floor();
    if !(step > 0.0 && count >= 0.0 && count < MOST as f64) {
        return Err(format!(
            "'{text}' goes nowhere; give from..to:step that ascends by at most {MOST} steps"
        ));
    }
    Ok(Angles((0..=count as usize).map(|k| from + k as f64 * step).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_hold_both_ends() {
        let angles = |text: &str| parse(text).unwrap().0;
        assert_eq!(angles("-30..30:20"), [-30.0, -10.0, 10.0, 30.0]);
        assert_eq!(angles("0..0.3:0.1").len(), 4);
        assert_eq!(angles("-1..1"), [-1.0, 0.0, 1.0]);
        assert_eq!(angles("7"), [7.0]);
        assert_eq!(angles("0, -10,2.5"), [0.0, -10.0, 2.5]);
    }

    #[test]
    fn what_is_no_range_is_refused() {
        for text in
            ["", "a", "1..", "5..1", "0..10:0", "0..10:-1", "0..180:0.001", "200", "nan", "0..nan", "1,,2"]
        {
            assert!(parse(text).is_err(), "{text}");
        }
    }
}
