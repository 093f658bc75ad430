//! What stays of a long series on a page: the corners of its line, and of noise the least and greatest value
//! of each column.
//!
//! A plot is a thousand pixels wide; a million samples drawn as they are would show nothing more and make a
//! page that no mail carries. A mean would hide the spikes that the reader looks for. A smooth signal keeps its
//! shape with few corners, however far one zooms; noise keeps its envelope.

/// Columns that a series is thinned to: two points each.
const COLUMNS: usize = 1000;
/// How far the line may pass beside a point that is left out, as a share of the field's height.
const BESIDE: f64 = 2e-4;

type Point = [f64; 2];

/// The finite points of a series, as shares of the field, thinned, and split where it has a long hole or a point
/// without a place across.
pub(super) fn thinned(x: &[f64], y: &[f64]) -> Vec<Vec<Point>> {
    let finite = || x.iter().zip(y).filter(|(x, y)| x.is_finite() && y.is_finite());
    let count = finite().count();
    let Some([low, high]) = range(finite().map(|(x, _)| *x)) else {
        return Vec::new();
    };
    let span = high - low;
    let hole = (3.0 * span / count as f64).max(0.01 * span);
    let mut runs: Vec<Vec<Point>> = Vec::new();
    let mut last = None;
    for (x, y) in x.iter().zip(y) {
        if !x.is_finite() {
            last = None;
        }
        if !x.is_finite() || !y.is_finite() {
            continue;
        }
        match runs.last_mut() {
            Some(run) if last.is_some_and(|last| x - last <= hole) => run.push([*x, *y]),
            _ => runs.push(vec![[*x, *y]]),
        }
        last = Some(*x);
    }
    let runs: Vec<_> = runs.iter().map(|run| corners(run)).collect();
    let kept: usize = runs.iter().map(Vec::len).sum();
    match kept > 2 * COLUMNS && span > 0.0 {
        true => runs.iter().map(|run| extremes(run, low, span)).collect(),
        false => runs,
    }
}

/// A line without the points that it passes anyway: from each corner the line goes on as long as one straight
/// piece passes all points since within the tolerance (the swing-door algorithm, Bristol, ISA 1990).
fn corners(run: &[Point]) -> Vec<Point> {
    let mut kept: Vec<Point> = Vec::new();
    let (mut lowest, mut highest) = (f64::NEG_INFINITY, f64::INFINITY);
    let mut before: Option<Point> = None;
    for point in run {
        let Some(corner) = kept.last().copied() else {
            kept.push(*point);
            continue;
        };
        let slopes = |from: Point| {
            let across = point[0] - from[0];
            let slope = |up: f64| (point[1] + up - from[1]) / across;
            (across > 0.0).then(|| [slope(-BESIDE), slope(BESIDE)])
        };
        let exact = (point[1] - corner[1]) / (point[0] - corner[0]);
        let door = slopes(corner).filter(|_| exact >= lowest && exact <= highest);
        match (door, before) {
            (Some([low, high]), _) => (lowest, highest) = (lowest.max(low), highest.min(high)),
            (None, before) => {
                let corner = before.unwrap_or(corner);
                kept.push(corner);
                [lowest, highest] = slopes(corner).unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
            }
        }
        before = Some(*point);
    }
    kept.extend(before);
    kept.dedup();
    kept
}

/// Of each column the least and the greatest value.
fn extremes(points: &[Point], low: f64, span: f64) -> Vec<Point> {
    let column = |p: &Point| (((p[0] - low) / span * COLUMNS as f64) as usize).min(COLUMNS - 1);
    let mut kept = Vec::with_capacity(2 * COLUMNS);
    for group in points.chunk_by(|a, b| column(a) == column(b)) {
        let by_value = |a: &&Point, b: &&Point| a[1].total_cmp(&b[1]);
        let (least, most) = (group.iter().min_by(by_value), group.iter().max_by(by_value));
        if let (Some(least), Some(most)) = (least, most) {
            let (first, second) = if least[0] <= most[0] { (least, most) } else { (most, least) };
            kept.push(*first);
            if first != second {
                kept.push(*second);
            }
        }
    }
    kept
}

/// Least and greatest of the finite values.
pub(super) fn range(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    values.filter(|value| value.is_finite()).fold(None, |range, value| match range {
        Some([low, high]) => Some([low.min(value), high.max(value)]),
        None => Some([value, value]),
    })
}

/// From when to when a flag is set, in seconds; what is nearer than a pixel is one band.
pub fn bands(time: &[f64], flags: &[bool]) -> Vec<[f64; 2]> {
    let Some([low, high]) = range(time.iter().copied()) else {
        return Vec::new();
    };
    let pixel = (high - low) / COLUMNS as f64;
    let mut bands: Vec<[f64; 2]> = Vec::new();
    let set = time.iter().zip(flags).enumerate().filter(|(_, (t, flag))| t.is_finite() && **flag);
    let mut previous = None;
    for (k, (t, _)) in set {
        match bands.last_mut() {
            Some(band) if previous == k.checked_sub(1) || t - band[1] <= pixel => band[1] = *t,
            _ => bands.push([*t, *t]),
        }
        previous = Some(k);
    }
    bands
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_smooth_line_keeps_its_shape_in_few_corners_and_noise_its_envelope() {
        let x: Vec<f64> = (0..20_000).map(|k| f64::from(k) / 2e4).collect();
        let smooth: Vec<f64> = x.iter().map(|x| 0.5 + 0.4 * (12.0 * x).sin()).collect();
        let kept = thinned(&x, &smooth).concat();
        assert!(kept.len() < 300, "{}", kept.len());
        for pair in kept.windows(2) {
            let [from, to] = [pair[0], pair[1]];
            let middle = 0.5 * (from[0] + to[0]);
            let line = 0.5 * (from[1] + to[1]);
            let exact = 0.5 + 0.4 * (12.0 * middle).sin();
            // A door lets the line pass a point by its width on either side.
            assert!((line - exact).abs() < 2.0 * BESIDE, "{middle}");
        }
        let noise: Vec<f64> = (0..20_000_u32).map(|k| f64::from(k * 7919 % 1000) / 1e3).collect();
        let kept = thinned(&x, &noise).concat();
        assert!(kept.len() <= 2 * COLUMNS);
        assert!(kept.iter().any(|p| p[1] == 0.0) && kept.iter().any(|p| p[1] == 0.999));
    }

    #[test]
    fn a_point_without_a_place_across_ends_a_line_and_one_without_a_value_does_not() {
        let x = [0.0, 0.1, f64::NAN, 0.2, 0.3, 0.4];
        let y = [0.0, 0.5, 0.0, 0.1, f64::NAN, 0.9];
        assert_eq!(thinned(&x, &y).len(), 2);
    }
}
