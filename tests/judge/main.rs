//! What is said of a motion: its verdict, whether it fits, what is to blame, which mistake is likely.

mod adequacy;
mod credible;
mod diagnosis;
mod drawn;
mod keep_out;
mod verdict;
