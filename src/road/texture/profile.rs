//! Measures of a profile that need no spectrum: line and root mean square.

/// Subtracts mean and least-squares line.
pub(crate) fn remove_line(heights: &mut [f64]) {
    let (mean, slope) = line_of(heights);
    let middle = 0.5 * (heights.len() as f64 - 1.0);
    for (index, height) in heights.iter_mut().enumerate() {
        *height -= mean + slope * (index as f64 - middle);
    }
}

/// Mean, and slope per sample, of the least-squares line about the middle of the profile.
pub(crate) fn line_of(heights: &[f64]) -> (f64, f64) {
    let count = heights.len() as f64;
    let middle = 0.5 * (count - 1.0);
    let mean = heights.iter().sum::<f64>() / count.max(1.0);
    let moment: f64 = heights.iter().enumerate().map(|(index, height)| (index as f64 - middle) * height).sum();
    let inertia = count * (count * count - 1.0) / 12.0;
    (mean, if inertia > 0.0 { moment / inertia } else { 0.0 })
}

/// Root mean square about the mean \[m\].
pub(crate) fn rms(heights: &[f64]) -> f64 {
    let count = heights.len().max(1) as f64;
    let mean = heights.iter().sum::<f64>() / count;
    (heights.iter().map(|height| (height - mean) * (height - mean)).sum::<f64>() / count).sqrt()
}
