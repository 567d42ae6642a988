//! Coefficients of explicit Runge–Kutta methods.

/// An explicit Runge–Kutta method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tableau {
    /// Weights of the earlier stages in each stage.
    pub a: &'static [&'static [f64]],
    /// Weights of the stages in a step.
    pub b: &'static [f64],
    /// Order.
    pub order: i32,
    /// How states within a step are told; of some methods alone.
    pub dense: Option<Dense>,
}

/// What tells the states within a step, from its stages, the slope at its end and a few more stages.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dense {
    /// Weights of the earlier stages, and of the slope at the end, in each further stage.
    pub a: &'static [&'static [f64]],
    /// Weights of all these in the last coefficients of the polynomial.
    pub d: &'static [&'static [f64]],
}

/// Stages of a step of `DOP853` with those that tell the states within it.
pub const DENSE_STAGES: usize = 16;

impl Tableau {
    /// Number of stages with those that tell the states within a step.
    pub fn stages(&self) -> usize {
        self.b.len() + self.dense.map_or(0, |dense| 1 + dense.a.len())
    }

    /// Weights of all stages in the state at a share `θ` of a step, and in its derivative by `θ`.
    ///
    /// With `F₀ = Σ b k`, `F₁ = k₁ − F₀`, `F₂ = 2 F₀ − k₁ − k_end` and `F_j = Σ d k` beyond, in units of the step,
    ///
    /// ```text
    /// y(θ) = y₀ + θ (F₀ + (1−θ) (F₁ + θ (F₂ + (1−θ) (F₃ + θ (F₄ + …)))))
    /// ```
    ///
    /// (Hairer, Nørsett and Wanner, II.6): of order seven, and once continuously differentiable from step to step.
    ///
    /// # Panics
    /// Where the method does not tell states within its steps.
    pub fn weights(&self, share: f64) -> [[f64; DENSE_STAGES]; 2] {
        let mut weights = [[0.0; DENSE_STAGES]; 2];
        let dense = self.dense.expect("a method with states within steps");
        let end = self.b.len();
        // `θ`, `θ (1−θ)`, `θ² (1−θ)`, … with their derivatives.
        let (mut factor, mut slope) = (share, 1.0);
        let mut factors = [[0.0; 2]; 3 + 4];
        for (index, to) in factors.iter_mut().enumerate() {
            *to = [factor, slope];
            let (by, by_slope) = if index % 2 == 0 {
                (1.0 - share, -1.0)
            } else {
                (share, 1.0)
            };
            (factor, slope) = (factor * by, slope * by + factor * by_slope);
        }
        for (weights, of) in weights.iter_mut().zip([0, 1]) {
            let [first, second, third] = [0, 1, 2].map(|index| factors[index][of]);
            for (weight, b) in weights.iter_mut().zip(self.b) {
                *weight = (first - second + 2.0 * third) * b;
            }
            weights[0] += second - third;
            weights[end] -= third;
            for (row, factor) in dense.d.iter().zip(&factors[3..]) {
                for (weight, d) in weights.iter_mut().zip(*row) {
                    *weight += factor[of] * d;
                }
            }
        }
        weights
    }
}

/// The method of order eight of Dormand and Prince, without its error estimate, with its states within a step: the one of `DOP853`
/// (Hairer, Nørsett and Wanner, "Solving Ordinary Differential Equations I", 1993, II.5).
pub const DORMAND_PRINCE: Tableau = Tableau {
    a: &[
        &[],
        &[5.260_015_195_876_773e-2],
        &[1.972_505_698_453_79e-2, 5.917_517_095_361_37e-2],
        &[2.958_758_540_680_684_8e-2, 0.0, 8.876_275_643_042_054e-2],
        &[
            2.413_651_341_592_667e-1,
            0.0,
            -8.845_494_793_282_861e-1,
            9.248_340_032_617_92e-1,
        ],
        &[
            3.703_703_703_703_703_5e-2,
            0.0,
            0.0,
            1.708_286_087_294_738_6e-1,
            1.254_676_875_668_224_2e-1,
        ],
        &[
            3.710_937_5e-2,
            0.0,
            0.0,
            1.702_522_110_195_440_5e-1,
            6.021_653_898_045_596e-2,
            -1.757_812_5e-2,
        ],
        &[
            3.709_200_011_850_479e-2,
            0.0,
            0.0,
            1.703_839_257_122_399_8e-1,
            1.072_620_304_463_732_8e-1,
            -1.531_943_774_862_440_2e-2,
            8.273_789_163_814_023e-3,
        ],
        &[
            6.241_109_587_160_757e-1,
            0.0,
            0.0,
            -3.360_892_629_446_941_4,
            -8.682_193_468_417_26e-1,
            2.759_209_969_944_671e1,
            2.015_406_755_047_789_4e1,
            -4.348_988_418_106_996e1,
        ],
        &[
            4.776_625_364_382_643_4e-1,
            0.0,
            0.0,
            -2.488_114_619_971_667_7,
            -5.902_908_268_368_43e-1,
            2.123_005_144_818_119_3e1,
            1.527_923_363_288_242_3e1,
            -3.328_821_096_898_486e1,
            -2.033_120_170_850_862_7e-2,
        ],
        &[
            -9.371_424_300_859_873e-1,
            0.0,
            0.0,
            5.186_372_428_844_064,
            1.091_437_348_996_729_5,
            -8.149_787_010_746_927,
            -1.852_006_565_999_696e1,
            2.273_948_709_935_050_5e1,
            2.493_605_552_679_652_3,
            -3.046_764_471_898_219_6,
        ],
        &[
            2.273_310_147_516_538,
            0.0,
            0.0,
            -1.053_449_546_673_725e1,
            -2.000_872_058_224_862_5,
            -1.795_893_186_311_88e1,
            2.794_888_452_941_996e1,
            -2.858_998_277_135_023_5,
            -8.872_856_933_530_63,
            1.236_056_717_579_430_3e1,
            6.433_927_460_157_636e-1,
        ],
    ],
    b: &[
        5.429_373_411_656_876_5e-2,
        0.0,
        0.0,
        0.0,
        0.0,
        4.450_312_892_752_409,
        1.891_517_899_314_500_3,
        -5.801_203_960_010_585,
        3.111_643_669_578_199e-1,
        -1.521_609_496_625_161e-1,
        2.013_654_008_040_303_4e-1,
        4.471_061_572_777_259e-2,
    ],
    order: 8,
    dense: Some(Dense {
        a: &[
            &[
                0.056_167_502_283_047_954,
                0.0,
                0.0,
                0.0,
                0.0,
                0.0,
                0.253_500_210_216_624_83,
                -0.246_239_037_470_802_5,
                -0.124_191_423_263_816_37,
                0.153_291_798_278_765_68,
                0.008_201_052_295_634_69,
                0.007_567_897_660_545_699,
                -0.008_298,
            ],
            &[
                0.031_834_648_163_502_14,
                0.0,
                0.0,
                0.0,
                0.0,
                0.028_300_909_672_366_776,
                0.053_541_988_307_438_566,
                -0.054_923_748_571_390_99,
                0.0,
                0.0,
                -0.000_108_347_328_697_249_32,
                0.000_382_571_090_835_658_4,
                -0.000_340_465_008_687_404_56,
                0.141_312_443_674_632_5,
            ],
            &[
                -0.428_896_301_583_791_94,
                0.0,
                0.0,
                0.0,
                0.0,
                -4.697_621_415_361_164,
                7.683_421_196_062_599,
                4.068_989_818_397_11,
                0.356_727_187_455_281_1,
                0.0,
                0.0,
                0.0,
                -0.001_399_024_165_159_014_5,
                2.947_514_789_152_772_4,
                -9.150_958_472_179_87,
            ],
        ],
        d: &[
            &[
                -8.428_938_276_109_013,
                0.0,
                0.0,
                0.0,
                0.0,
                0.566_714_953_519_377_7,
                -3.068_949_945_949_891_7,
                2.384_667_656_512_07,
                2.117_034_582_445_028,
                -0.871_391_583_777_973,
                2.240_437_430_260_788_3,
                0.631_578_778_769_468_8,
                -0.088_990_336_451_333_31,
                18.148_505_520_854_727,
                -9.194_632_392_478_356,
                -4.436_036_387_594_894,
            ],
            &[
                10.427_508_642_579_134,
                0.0,
                0.0,
                0.0,
                0.0,
                242.283_491_775_258_17,
                165.200_451_717_270_28,
                -374.546_754_722_690_2,
                -22.113_666_853_125_306,
                7.733_432_668_472_264,
                -30.674_084_731_089_398,
                -9.332_130_526_430_229,
                15.697_238_121_770_845,
                -31.139_403_219_565_178,
                -9.352_924_358_844_48,
                35.816_841_486_394_08,
            ],
            &[
                19.985_053_242_002_433,
                0.0,
                0.0,
                0.0,
                0.0,
                -387.037_308_749_351_8,
                -189.178_138_195_167_58,
                527.808_159_205_423_6,
                -11.573_902_539_959_63,
                6.881_232_694_696_3,
                -1.000_605_096_691_083_8,
                0.777_713_779_805_344_3,
                -2.778_205_752_353_508,
                -60.196_695_231_264_12,
                84.320_405_506_677_16,
                11.992_291_136_182_79,
            ],
            &[
                -25.693_933_462_703_75,
                0.0,
                0.0,
                0.0,
                0.0,
                -154.189_748_690_236_43,
                -231.529_379_176_045_5,
                357.639_117_910_614_1,
                93.405_324_183_624_32,
                -37.458_323_136_451_63,
                104.099_649_508_962_3,
                29.840_293_426_660_5,
                -43.533_456_590_011_14,
                96.324_553_959_188_28,
                -39.177_261_675_615_44,
                -149.726_836_257_985_64,
            ],
        ],
    }),
};
