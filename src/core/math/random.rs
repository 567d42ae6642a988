//! Pseudo-random numbers from a fixed seed (Marsaglia, "Xorshift RNGs", 2003): the same everywhere
//! and always.

/// A sequence of pseudo-random numbers.
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Default for Random {
    fn default() -> Self {
        Self(0x9e37_79b9_7f4a_7c15)
    }
}

impl Random {
    /// The next number, uniform in ±1.
    pub fn signed(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// The next number of a standard normal distribution (Marsaglia's polar method).
    pub fn normal(&mut self) -> f64 {
        loop {
            let (u, v) = (self.signed(), self.signed());
            let square = u * u + v * v;
            if square > 0.0 && square < 1.0 {
                return u * (-2.0 * square.ln() / square).sqrt();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_those_of_the_distributions() {
        let mut random = Random::default();
        let mut sums = [0.0; 4];
        const COUNT: usize = 20_000;
        for _ in 0..COUNT {
            let (uniform, normal) = (random.signed(), random.normal());
            assert!(uniform.abs() <= 1.0);
            for (sum, value) in sums.iter_mut().zip([
                uniform,
                3.0 * uniform * uniform - 1.0,
                normal,
                normal * normal - 1.0,
            ]) {
                *sum += value;
            }
        }
        // Standard deviations of these means are below 0.01.
        assert!(
            sums.iter().all(|sum| (sum / COUNT as f64).abs() < 0.03),
            "{sums:?}"
        );
    }
}
