//! What stays of a long series on a page: per column its least and its greatest value.
//!
//! A plot is a thousand pixels wide; a million samples drawn as they are would show nothing more
//! and make a page that no mail carries. A mean would hide the spikes that the reader looks for.

/// Columns that a series is thinned to: two points each.
const COLUMNS: usize = 1000;

/// The finite points of a series, thinned, and split where it has a long hole.
pub(super) fn thinned(x: &[f64], y: &[f64]) -> Vec<Vec<[f64; 2]>> {
    let all = x.iter().zip(y).map(|(x, y)| [*x, *y]);
    let points: Vec<[f64; 2]> = all.filter(|p| p[0].is_finite() && p[1].is_finite()).collect();
    let Some([low, high]) = range(points.iter().map(|p| p[0])) else {
        return Vec::new();
    };
    let span = high - low;
    let hole = (3.0 * span / points.len() as f64).max(0.01 * span);
    let mut runs: Vec<Vec<[f64; 2]>> = Vec::new();
    let mut last = f64::NEG_INFINITY;
    for point in few(points, low, span) {
        match runs.last_mut() {
            Some(run) if point[0] - last <= hole => run.push(point),
            _ => runs.push(vec![point]),
        }
        last = point[0];
    }
    runs
}

fn few(points: Vec<[f64; 2]>, low: f64, span: f64) -> Vec<[f64; 2]> {
    if points.len() <= 2 * COLUMNS || span <= 0.0 {
        return points;
    }
    let column = |p: &[f64; 2]| (((p[0] - low) / span * COLUMNS as f64) as usize).min(COLUMNS - 1);
    let mut kept = Vec::with_capacity(2 * COLUMNS);
    for group in points.chunk_by(|a, b| column(a) == column(b)) {
        let by_value = |a: &&[f64; 2], b: &&[f64; 2]| a[1].total_cmp(&b[1]);
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
