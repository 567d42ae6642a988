//! Measurements.

mod accuracy;
mod answer;
mod book;
mod chart;
mod covariance;
mod coverage;
mod damage;
mod data;
mod durations;
mod estimation;
mod failure;
mod figure;
mod flow;
mod growth;
mod nonsense_table;
mod page;
mod pages;
mod peers;
mod phases;
mod plot;
mod proposal;
mod proposals;
mod real;
mod results;
mod run;
mod scale;
mod scales;
mod scaling;
mod scenes;
mod sequences;
mod statistics;
mod stopwatch;
mod stress_table;
mod study;
mod table;
mod tasks;
mod tosses;
mod troubles;
mod tuned;

use clap::Parser;

use book::Book;
use chart::Options;
use study::Study;

#[derive(Parser)]
enum Cli {
    /// Studies
    Study(study::Cli),
    /// Charts
    Chart(chart::Options),
}

fn main() -> anyhow::Result<()> {
    match Cli::parse() {
        Cli::Study(cli) => study::run(cli),
        Cli::Chart(options) => chart::run(options),
    }
}
