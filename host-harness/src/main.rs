//! The command `joint`.

fn main() -> std::process::ExitCode {
    host_harness::cli::main()
}
