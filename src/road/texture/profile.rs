//! Measures of a profile that need no spectrum: line, root mean square, mean profile depth.

/// Segment length of the mean profile depth \[m\] (ISO 13473-1).
const SEGMENT_LENGTH: f64 = 0.1;

/// Removes mean and least-squares line.
pub fn remove_line(heights: &mut [f64]) {
    let (mean, slope) = line_of(heights);
    let middle = 0.5 * (heights.len() as f64 - 1.0);
    for (index, height) in heights.iter_mut().enumerate() {
        *height -= mean + slope * (index as f64 - middle);
    }
}

/// Mean and slope per sample of the least-squares line, about the middle of the profile.
pub fn line_of(heights: &[f64]) -> (f64, f64) {
    let count = heights.len() as f64;
    let middle = 0.5 * (count - 1.0);
    let mean = heights.iter().sum::<f64>() / count.max(1.0);
    let moment: f64 = heights.iter().enumerate().map(|(index, height)| (index as f64 - middle) * height).sum();
    let inertia = count * (count * count - 1.0) / 12.0;
    (mean, if inertia > 0.0 { moment / inertia } else { 0.0 })
}

/// Root mean square about the mean \[m\].
pub fn rms(heights: &[f64]) -> f64 {
    let count = heights.len().max(1) as f64;
    let mean = heights.iter().sum::<f64>() / count;
    (heights.iter().map(|height| (height - mean) * (height - mean)).sum::<f64>() / count).sqrt()
}

/// Mean profile depth \[m\] after ISO 13473-1, `spacing` \[m\] between heights: segments of 100 mm, slope suppressed,
/// the mean of the two halves' highest points above the segment's mean, averaged over segments. `None` when the profile
/// is shorter than one segment or a half segment holds fewer than two points.
pub fn mean_profile_depth(heights: &[f64], spacing: f64) -> Option<f64> {
    let per_segment = (SEGMENT_LENGTH / spacing).round() as usize;
    if per_segment < 4 || heights.len() < per_segment {
        return None;
    }
    let mut depths = 0.0;
    let mut segment = vec![0.0; per_segment];
    let segments = heights.chunks_exact(per_segment);
    let count = segments.len();
    for chunk in segments {
        segment.copy_from_slice(chunk);
        remove_line(&mut segment);
        let (left, right) = segment.split_at(per_segment / 2);
        let peak = |half: &[f64]| half.iter().fold(f64::NEG_INFINITY, |highest, &height| highest.max(height));
        depths += 0.5 * (peak(left) + peak(right));
    }
    Some(depths / count as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn profile_depth_of_a_known_shape() {
        // One triangular peak of height h per half segment, on a line with slope: mean h/2, peaks at h.
        let h = 2e-3;
        let profile: Vec<f64> =
            (0..1000).map(|i| h * (1.0 - ((i % 50) as f64 - 25.0).abs() / 25.0) + 1e-5 * i as f64).collect();
        let depth = mean_profile_depth(&profile, 1e-3).unwrap();
        assert!((depth - 0.5 * h).abs() < 0.03 * h, "{depth}");
        assert!(mean_profile_depth(&profile[..99], 1e-3).is_none());
        assert!(mean_profile_depth(&profile, 0.05).is_none());
    }
}
