//! Golden transcripts: what every subcommand says, word for word, its exit code, and the files it leaves.
//! After a wanted change: `TRYCMD=overwrite cargo test -p tribos --test command cli`, then read the diff.

#[test]
fn transcripts() {
    trycmd::TestCases::new().case("tests/cmd/*.trycmd");
}
