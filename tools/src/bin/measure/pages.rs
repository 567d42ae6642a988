//! What the studies' pages say before their tables: what was done, and what words mean.

use crate::Study;

impl Study {
    /// Name of its page and of its numbers.
    pub fn name(self) -> &'static str {
        match self {
            Study::Answer => "answer",
            Study::Scenes => "scenes",
            Study::Scales => "scales",
            Study::Accuracy => "accuracy",
            Study::Covariance => "covariance",
            Study::Coverage => "coverage",
            Study::Scaling => "scaling",
            Study::Sequences => "sequences",
            Study::Proposals => "proposals",
            Study::Phases => "phases",
            Study::Stress => "stress",
            Study::Tosses => "tosses",
            Study::Durations => "durations",
            Study::Damage => "damage",
            Study::Nonsense => "nonsense",
            Study::All => "all",
        }
    }

    /// What stands above the tables.
    pub fn about(self) -> &'static str {
        match self {
            Study::Answer => {
                "# The right answer

*Physical* is the solver's verdict. *Best known optimum*: no start of the solver that converged with
events in order reached an objective lower by more than 2e-5. The starts: the program's own; the truth
with and without the sweep; six shaken versions each of the truth and of the program's own guess, with
standard deviations from half to three times 3 cm, 0.3 rad, 0.3 m/s, 3 rad/s, 10 ms (and 10 % of the
tempo where that is unknown); slower, coarser, finer and no sweep; the slow sweep from the truth: the
best of some two dozen, not a proof. *Simulated*: flown from the estimate's first state through the
bounce by the performance maker's simulator, which finds the contact itself and shares only the flight
and impact formulae with the solver. Time is that of the whole pipeline, from events to estimate."
            }
            Study::Scenes => {
                "# Scenes of several bodies and of many bounces

As in `answer.md`, for the hat and the box, the die and cubes. Velocities may jump at the die's bounces, and
where a scene allows it no verdict above `plausible` is asked."
            }
            Study::Scales => {
                "# Sizes, speeds, rates and marks

Cubes of any size, thrown so that they bounce on corners; not every seed has a throw that bounces so
often, hence *n*. Marks: exact; within a sample; a person's, off by 30 ms (standard deviation), with
physical stamps, and acted slowly in an unknown tempo. A die of 16 mm has flights of some 45 ms, five
samples at 120 Hz, which a person's marks may swap. *Best known optimum*: the lowest objective of about twenty starts on the same
cut, the truth among them. What is refused counts as neither.
*Gaps closed* is what the solver says, *physical* what the program says with all checks: most that lose it have a
corner in the table between bounces, for the hand strays by more than the die is large."
            }
            Study::Accuracy => {
                "# Exact performances

No wander, no noise, marks at the events, 125 Hz so that the sampling interval is a whole number of
nanoseconds. Errors are relative to the largest value of that kind in the true motion, orientation in
radians; events whose time is not estimated (an end without a goal) are left out. Where the tempo varies the truth is
not the optimum: the prior asks for a steady tempo, and the fit gives a few thousandths for it."
            }
            Study::Covariance => {
                "# Errors against the covariance

White noise of 0.5 mm and 0.3° per axis, tracker at the centre of mass; weights equal to the noise
unless said. *Dense* is `Z (Zᵀ H Z)⁻¹ Zᵀ` with `Z` from an eigen-decomposition of the constraints'
derivative; 26 unknowns less 19 constraints leave 7. The normalised square under *default weights* is to
be read in the scaled column only."
            }
            Study::Coverage => {
                "# How often intervals hold the truth

Reported intervals of 50, 90 and 95 % against the truth, over scenes, hands and what is free; the noise
model was chosen on seeds 0 to 119, and between its kernels on 5000 to 5099. Hands: the maker's own at other paces (correlation times of 0.2 to 5
flights), Ornstein and Uhlenbeck's rough one, slow sinusoids, a straight and a curved drift, a real hand
(high-passed at two seconds, compressed). Quantities are of motions called physical; *determined*: those
for which the estimate gives a deviation at all. Intervals are wider than they say for most hands, most so
for one that drifts along a parabola, which no stationary wander is.

The last row is of real tosses, whose gravity is one number: what differs between them is calibration by
place and side, which is no noise along one of them. **The interval of gravity from one short flight says how
well that flight is measured, not the room.**"
            }
            Study::Scaling => {
                "# Cost against size

Pencil: the same motion sampled faster. Cube: more bounces, one motion each. Median of five runs, except where one takes
more than 20 s. Exponents are of a power fitted over all rows, in brackets over the upper half. Where a
run fails, exponents are in part its own."
            }
            Study::Sequences => {
                "# What touches, where scenes leave that open

*Likeliest is true*: at every collision the feature that the fits put first is the true one; *likely*:
all true features are among those that a search begins with. *As good or better*: the objective is no
greater than that of the scene which names the true corners, or the events of the same sequence are within
0.1 ms of its. Counts of sequences are those of all eight corners. Times are to be read against the same block's *named*."
            }
            Study::Proposals => {
                "# What touches, as sampled simulations propose it

The hybrid of paper §7 as a study (`tools/study/proposal.rs`). A particle is flown from the sketch to
where something touches, bounces off each likely feature, and is corrected by the samples after; eight
go on, so that *first 10* is all there are. *As good*: one of the first three, solved, is physical, has
the right corner first, and costs no more than the estimate of the true sequence; *expected*: the first
particle's sum of squares over that estimate's."
            }
            Study::Phases => {
                "# Where the time goes

The fastest of five runs of each performance counts."
            }
            Study::Stress => {
                "# Where methods fail

*Best*: the lowest objective of three to eight starts, the truth among them (`stress/judge.rs`). Gaps
are recomputed and up to eight events simulated from the first state, apart from the solver. *s*: a
named point is inside its surface by more than 1 µm at a time other than that of its collision; *c*: as
many of these the program itself calls `plausible` after its checks, whose tolerance is 1 mm. *i*: the
contact is touched without speed."
            }
            Study::Tosses => {
                "# Real tosses

98 tosses of a cube onto a table (DAIRLab's contact-nets, BSD-3, not in this repository), first flight
only, gravity free, the flight as the data's manifest says; stamps at the true rate, and at the nominal
one for comparison. The data's own account: 0.02 mm and 0.025° per axis, gravity 9.648 m/s² at the true
rate, tilted by about 1°. Residuals per axis have the degrees of freedom of a parabola and a constant
spin taken off. Each session is turned about z at random, so that the mean over tosses tilts less than
each."
            }
            Study::Durations => {
                "# Durations of motions acted in a tempo of their own

Against the truth: real tosses replayed 2.5 times slower, and acted pencils. The threshold at which
constraints are taken to contradict the samples (one deviation; 1.5, 2 and 3 were tried) was chosen on
tosses of even index; odd ones are held out. *Another law*: restitution 0.3 and friction 0.15 fixed,
sides as documented (2 % more than the cameras see)."
            }
            Study::Damage => {
                "# Damaged performances

Outliers, wrong units, marks that are off or absent: what is found, what is left out for nothing, and what the
estimate becomes."
            }
            Study::Nonsense => {
                "# Nonsense, and sense

*Physical* is what the program says with all checks; its alarms are doubts apart from overlap and wrong
features. Bounds were chosen on seeds below 16, those of short flights on some from 100 to 229 and from 5000 to 5009,
and all on the hovering vehicle's windows that begin four
seconds earlier; of the real data the hinged boxes, the cube's tosses and the carried cameras were looked at before."
            }
            Study::All => "",
        }
    }
}
